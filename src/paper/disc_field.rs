//! Figure 4: the stress inside a disc under line forces on its rim, in closed form, and its averages
//! over the disc and over the control square by quadrature.
//!
//! Plane elasticity; lengths in m, forces in N per metre of depth, stresses in Pa, tension positive.
//! Points are [x, z] from the disc's centre. For plane stress and plane strain the field is the
//! same, and no elastic constant enters it.
//!
//! # The field
//!
//! A force F at the point P of the rim has Flamant's field −(2/π)(F·r̂)/r r̂⊗r̂, with r and r̂ from P.
//! On a circle r = 2R(r̂·n), so that its traction there is −(F·r̂)r̂/(πR), which is finite. As r̂ points
//! halfway between the directions of P and of the point, all forces together leave the traction
//!
//! t = −ΣF/(2πR) + (Σf_r/(2πR)) n − (Σf_t/(2πR)) e_t,
//!
//! with f_r and f_t the parts of F out of the disc and along its rim. The last term is zero where the
//! moments balance, −(Σf_r/(2πR)) I takes away the second, and a force b per volume with
//! πR²b + ΣF = 0 the first: the traction Rb/2 is that of −½(b⊗x + x⊗b) + ½(b·x)I with its sign
//! turned, and the divergence of this is −b, its trace zero.
//!
//! # The assumption that is tested
//!
//! Section 3.3 supposes that "the volumetric average of the stress field within a control volume
//! within a Voronoi cell […] is equal to the volumetric average of the stress within the whole cell";
//! so does Σ^c = Σ^p V_c/V_p of section 3.2.3. With [`figure_4`] the one is
//! [`DiscField::average_over_square`] of side R, the other [`DiscField::average_over_cell`] of side
//! 2R, Table 3's Σ/V. Two differences follow from the field alone:
//!
//! * At the centre the trace is the trace of the average over the disc, for the trace is harmonic.
//!   The cell's average is less by the share of voids, which carry nothing.
//! * Where no force has a part along the rim (no friction, as in Table 2), the rest of the stress at
//!   the centre is twice that of the average over the disc: the sums over the forces are
//!   (2/πR) Σ f_r dev(e⊗e) and (1/πR) Σ f_r dev(e⊗e).

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI, SQRT_2, TAU};

use nalgebra::{Matrix2, Vector2};

use crate::paper::integrate;

/// What is left of forces and moments that balance, as a share of the sum of the forces' sizes.
const BALANCE: f64 = 1e-9;
/// Panels of the integrals in each direction.
const PANELS: u32 = 3;

/// A force per metre of depth on the rim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RimForce {
    /// Direction of its point from the centre, counterclockwise from x, rad.
    pub angle: f64,
    /// Part out of the disc, N/m; a push is negative.
    pub radial: f64,
    /// Part along the rim, counterclockwise, N/m.
    pub tangential: f64,
}

/// A force per metre of depth at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointForce {
    /// From the disc's centre, m.
    pub point: [f64; 2],
    /// On the disc, N/m.
    pub force: [f64; 2],
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DiscFieldError {
    #[error("the disc's radius is {0} m, must be above 0 and finite")]
    Radius(f64),
    #[error("{what} is not finite")]
    NotFinite { what: String },
    #[error("forces and weight leave ({x}, {z}) N/m, must balance")]
    Forces { x: f64, z: f64 },
    #[error("the moments about the centre leave {0} N, must balance")]
    Moments(f64),
    #[error(
        "the square's side is {side} m, must be above 0 and at most {largest} m within the disc"
    )]
    Square { side: f64, largest: f64 },
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Load {
    point: Vector2<f64>,
    force: Vector2<f64>,
}

/// The stress inside a disc under balanced forces on its rim and a uniform body force.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscField {
    radius: f64,
    loads: Vec<Load>,
    body_force: Vector2<f64>,
    /// −Σf_r/(2πR), Pa.
    isotropic: f64,
}

impl DiscField {
    /// The field in a disc of `radius` m under `forces` and `body_force`, N/m³ (zero, or the weight
    /// per volume). Forces must balance with πR² of it, moments about the centre with one another.
    pub fn new(
        radius: f64,
        forces: &[RimForce],
        body_force: [f64; 2],
    ) -> Result<Self, DiscFieldError> {
        let loads = forces.iter().map(|force| {
            let (sin, cos) = force.angle.sin_cos();
            let (out, along) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
            Load {
                point: radius * out,
                force: force.radial * out + force.tangential * along,
            }
        });
        DiscField::checked(radius, loads.collect(), body_force.into())
    }

    fn checked(
        radius: f64,
        loads: Vec<Load>,
        body_force: Vector2<f64>,
    ) -> Result<Self, DiscFieldError> {
        check_numbers(radius, &loads, body_force)?;
        check_balance(radius, &loads, body_force)?;
        let radial: f64 = loads.iter().map(|load| load.force.dot(&load.point)).sum();
        Ok(DiscField {
            radius,
            isotropic: -radial / radius / (TAU * radius),
            loads,
            body_force,
        })
    }

    /// R, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    pub fn forces(&self) -> impl Iterator<Item = PointForce> + '_ {
        self.loads.iter().map(|load| PointForce {
            point: load.point.into(),
            force: load.force.into(),
        })
    }

    /// b, N/m³.
    pub fn body_force(&self) -> [f64; 2] {
        self.body_force.into()
    }

    /// σ at a point of the disc, [[xx, xz], [zx, zz]], Pa, tension positive. It grows without bound
    /// towards the point of a force and is not a number there; outside the disc it means nothing.
    pub fn stress(&self, point: [f64; 2]) -> [[f64; 2]; 2] {
        let at = Vector2::from(point);
        let flamant: Matrix2<f64> = self.loads.iter().map(|load| flamant(load, at)).sum();
        rows(flamant + self.smooth(at))
    }

    /// What is not singular: the isotropic part, and the body force's.
    fn smooth(&self, at: Vector2<f64>) -> Matrix2<f64> {
        let b = self.body_force;
        let isotropic = self.isotropic + 0.5 * b.dot(&at);
        Matrix2::from_diagonal_element(isotropic) - 0.5 * (b * at.transpose() + at * b.transpose())
    }

    /// (1/πR²) ∫σ dA over the disc by quadrature of the field, Pa. Each force's singular part is
    /// integrated in polar coordinates about its own point, where the element r dr dθ takes the
    /// singularity away and the disc is 0 < r < 2R cosθ; the rest about the centre.
    pub fn average_over_disc(&self) -> [[f64; 2]; 2] {
        let singular = self.loads.iter().map(|load| self.integral_about(load));
        let singular: Matrix2<f64> = singular.sum();
        let smooth = integrate(0.0, TAU, PANELS, |angle| {
            let direction = unit(angle);
            integrate(0.0, self.radius, PANELS, |r| r * self.smooth(r * direction))
        });
        rows((singular + smooth) / self.volume())
    }

    /// ∫ of one force's part over the disc, N.
    fn integral_about(&self, load: &Load) -> Matrix2<f64> {
        let inward = (-load.point.y).atan2(-load.point.x);
        integrate(-FRAC_PI_2, FRAC_PI_2, PANELS, |angle| {
            let direction = unit(inward + angle);
            integrate(0.0, 2.0 * self.radius * angle.cos(), PANELS, |r| {
                r * flamant(load, load.point + r * direction)
            })
        })
    }

    /// (1/s²) ∫σ dA over the control square of side s = `side` m about the centre by a tensor
    /// product of Gauss-Legendre rules, Pa. The square must lie within the disc; the nearer its
    /// corners come to a force, the less exact it is.
    pub fn average_over_square(&self, side: f64) -> Result<[[f64; 2]; 2], DiscFieldError> {
        let largest = SQRT_2 * self.radius;
        if !(side > 0.0 && side <= largest) {
            return Err(DiscFieldError::Square { side, largest });
        }
        let half = 0.5 * side;
        let integral = self.integral_over_square(half, PANELS);
        // Built from rows and read as columns: the stress is symmetric.
        Ok(rows(integral / (side * side)))
    }

    fn integral_over_square(&self, half: f64, panels: u32) -> Matrix2<f64> {
        integrate(-half, half, panels, |x| {
            integrate(-half, half, panels, |z| Matrix2::from(self.stress([x, z])))
        })
    }

    /// Σ/V of the contact forces with V = πR², Pa: what [`DiscField::average_over_disc`] must be.
    pub fn contact_average(&self) -> [[f64; 2]; 2] {
        rows(self.extensive() / self.volume())
    }

    /// Σ/V with V = s² of a Voronoi cell of side s = `side` m, Pa, as in Table 3: the voids of the
    /// cell are counted in and carry nothing.
    pub fn average_over_cell(&self, side: f64) -> [[f64; 2]; 2] {
        rows(self.extensive() / (side * side))
    }

    /// Σ_ij = Σ x_i F_j of Eq. 7, J per metre of depth, tension positive. The body force has its
    /// resultant in the centre and adds nothing. Balanced moments make it symmetric; the rounding
    /// that is left is halved between the two.
    fn extensive(&self) -> Matrix2<f64> {
        let terms = self
            .loads
            .iter()
            .map(|load| load.point * load.force.transpose());
        let sum: Matrix2<f64> = terms.sum();
        0.5 * (sum + sum.transpose())
    }

    /// πR², m³ per metre of depth.
    fn volume(&self) -> f64 {
        PI * self.radius * self.radius
    }
}

/// The disc of Figure 4: R = 1 m, vertical forces of 1 N/m, horizontal ones of 0.5 N/m.
pub fn figure_4() -> Result<DiscField, DiscFieldError> {
    let push = |angle: f64, force: f64| RimForce {
        angle,
        radial: -force,
        tangential: 0.0,
    };
    let forces = [
        push(FRAC_PI_2, 1.0),
        push(-FRAC_PI_2, 1.0),
        push(0.0, 0.5),
        push(PI, 0.5),
    ];
    DiscField::new(1.0, &forces, [0.0; 2])
}

/// −(2/π)(F·r̂)/r r̂⊗r̂, Pa.
fn flamant(load: &Load, at: Vector2<f64>) -> Matrix2<f64> {
    let away = at - load.point;
    let square = away.norm_squared();
    away * away.transpose() * (-FRAC_2_PI * load.force.dot(&away) / (square * square))
}

fn check_numbers(
    radius: f64,
    loads: &[Load],
    body_force: Vector2<f64>,
) -> Result<(), DiscFieldError> {
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(DiscFieldError::Radius(radius));
    }
    let finite = |vector: &Vector2<f64>| vector.iter().all(|value| value.is_finite());
    let is_broken = |load: &Load| !finite(&load.point) || !finite(&load.force);
    let what = match loads.iter().position(is_broken) {
        _ if !finite(&body_force) => "the body force".to_owned(),
        Some(index) => format!("force {index}"),
        None => return Ok(()),
    };
    Err(DiscFieldError::NotFinite { what })
}

fn check_balance(
    radius: f64,
    loads: &[Load],
    body_force: Vector2<f64>,
) -> Result<(), DiscFieldError> {
    let weight = PI * radius * radius * body_force;
    let sizes: f64 = loads.iter().map(|load| load.force.norm()).sum();
    let allowed = BALANCE * (sizes + weight.norm());
    let left = loads.iter().fold(weight, |sum, load| sum + load.force);
    if left.norm() > allowed {
        return Err(DiscFieldError::Forces {
            x: left.x,
            z: left.y,
        });
    }
    let moment: f64 = loads.iter().map(|load| load.point.perp(&load.force)).sum();
    if moment.abs() > allowed * radius {
        return Err(DiscFieldError::Moments(moment));
    }
    Ok(())
}

fn unit(angle: f64) -> Vector2<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector2::new(cos, sin)
}

fn rows(tensor: Matrix2<f64>) -> [[f64; 2]; 2] {
    tensor.transpose().into()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Any forces made to balance by a body force, or by two more pushes or pulls.
    fn balanced(radius: f64, mut forces: Vec<RimForce>, weight: bool) -> DiscField {
        let mean = forces.iter().map(|f| f.tangential).sum::<f64>() / forces.len() as f64;
        let mut sum = Vector2::zeros();
        for force in &mut forces {
            force.tangential -= mean;
            let out = unit(force.angle);
            sum += force.radial * out + force.tangential * Vector2::new(-out.y, out.x);
        }
        let mut body_force = [0.0; 2];
        if weight {
            body_force = (-sum / (PI * radius * radius)).into();
        } else {
            for (angle, part) in [(0.0, sum.x), (FRAC_PI_2, sum.y)] {
                forces.push(RimForce {
                    angle,
                    radial: -part,
                    tangential: 0.0,
                });
            }
        }
        DiscField::new(radius, &forces, body_force).expect("made to balance")
    }

    fn fields() -> impl Strategy<Value = DiscField> {
        let force =
            (0.0..TAU, -1.0..1.0, -1.0..1.0).prop_map(|(angle, radial, tangential)| RimForce {
                angle,
                radial,
                tangential,
            });
        let forces = prop::collection::vec(force, 1..7);
        (0.01..10.0, forces, any::<bool>())
            .prop_map(|(radius, forces, weight)| balanced(radius, forces, weight))
    }

    /// With friction and weight, points far from the axes.
    fn an_example() -> DiscField {
        let force = |angle: f64, radial: f64, tangential: f64| RimForce {
            angle,
            radial,
            tangential,
        };
        let forces = vec![
            force(0.6, -1.0, 0.3),
            force(2.2, -0.7, -0.2),
            force(4.1, -1.4, 0.5),
            force(5.5, -0.4, 0.1),
        ];
        balanced(2.0, forces, true)
    }

    /// A stress that the forces could make, Pa.
    fn scale(field: &DiscField) -> f64 {
        field
            .loads
            .iter()
            .map(|load| load.force.norm())
            .sum::<f64>()
            / field.radius
    }

    fn at(field: &DiscField, point: Vector2<f64>) -> Matrix2<f64> {
        field.stress(point.into()).into()
    }

    fn far_from_forces(field: &DiscField, point: Vector2<f64>) -> bool {
        let near = |load: &Load| (load.point - point).norm() < 0.05 * field.radius;
        !field.loads.iter().any(near)
    }

    /// The largest difference as a share of the largest component.
    fn relative(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> f64 {
        let (a, b) = (Matrix2::from(a), Matrix2::from(b));
        (a - b).amax() / b.amax()
    }

    proptest! {
        #[test]
        fn the_rim_is_free_between_the_forces(field in fields()) {
            for step in 0..100 {
                let out = unit(TAU * f64::from(step) / 100.0);
                let point = field.radius * out;
                if far_from_forces(&field, point) {
                    let traction = (at(&field, point) * out).norm();
                    prop_assert!(traction < 1e-12 * scale(&field), "{traction:e}");
                }
            }
        }

        #[test]
        fn the_interior_is_in_equilibrium_and_compatible(
            field in fields(), share in 0.0..0.6, angle in 0.0..TAU,
        ) {
            let point = share * field.radius * unit(angle);
            let step = 1e-3 * field.radius;
            let beside = [Vector2::x(), Vector2::y()].map(|axis| {
                [1.0, -1.0].map(|sign| at(&field, point + sign * step * axis))
            });
            let [[right, left], [up, down]] = beside;
            let divergence = ((right - left).column(0) + (up - down).column(1)) / (2.0 * step);
            let left_over = (divergence + field.body_force).norm() * field.radius;
            prop_assert!(left_over < 1e-3 * scale(&field), "{left_over:e}");
            let around: f64 = beside.iter().flatten().map(Matrix2::trace).sum();
            let laplacian = (around - 4.0 * at(&field, point).trace()) / 1e-6;
            prop_assert!(laplacian.abs() < 2e-2 * scale(&field), "{laplacian:e}");
        }

        #[test]
        fn the_average_over_the_disc_is_that_of_the_contacts(field in fields()) {
            let difference = Matrix2::from(field.average_over_disc())
                - Matrix2::from(field.contact_average());
            prop_assert!(difference.amax() < 1e-12 * scale(&field), "{:e}", difference.amax());
        }
    }

    #[test]
    fn a_cut_carries_what_acts_on_either_side_of_it() {
        let field = an_example();
        let height = 0.3;
        let half = (field.radius * field.radius - height * height).sqrt();
        let carried = integrate(-half, half, 12, |x| {
            Matrix2::from(field.stress([x, height]))
        });
        let mut above: Vector2<f64> = field
            .loads
            .iter()
            .filter(|load| load.point.y > height)
            .map(|load| load.force)
            .sum();
        let angle = (height / field.radius).acos();
        let area = field.radius * field.radius * angle - height * half;
        above += area * field.body_force;
        // The lower part pulls on the upper one with −σ·e_z.
        let left = (above - carried.column(1)).norm();
        assert!(left < 1e-12 * scale(&field) * field.radius, "{left:e}");
    }

    #[test]
    fn the_average_over_a_smaller_disc_is_that_of_its_tractions() {
        let field = an_example();
        let radius = 0.6 * field.radius;
        let averaged = integrate(0.0, TAU, 6, |angle| {
            integrate(0.0, radius, 6, |r| r * at(&field, r * unit(angle)))
        });
        let tractions = integrate(0.0, TAU, 6, |angle| {
            let out = unit(angle);
            radius * radius * out * (at(&field, radius * out) * out).transpose()
        });
        let difference = (averaged - tractions).amax();
        assert!(difference < 1e-10 * tractions.amax(), "{difference:e}");
    }

    #[test]
    fn the_average_over_a_square_is_that_of_its_tractions() {
        for field in [figure_4().expect("balances"), an_example()] {
            let half = 0.5 * field.radius;
            let sides = [0.0, FRAC_PI_2, PI, 3.0 * FRAC_PI_2].map(|angle| {
                let out = unit(angle);
                let along = Vector2::new(-out.y, out.x);
                integrate(-half, half, 4, |s| {
                    let point = half * out + s * along;
                    point * (at(&field, point) * out).transpose()
                })
            });
            let tractions = sides.iter().sum::<Matrix2<f64>>() / (4.0 * half * half);
            let square = field
                .average_over_square(2.0 * half)
                .expect("within the disc");
            let difference = relative(square, tractions.into());
            assert!(difference < 1e-12, "{difference:e}");
        }
    }

    #[test]
    fn fewer_panels_would_do() {
        for field in [figure_4().expect("balances"), an_example()] {
            let half = 0.5 * field.radius;
            let coarse = field.integral_over_square(half, PANELS - 1) / (4.0 * half * half);
            let fine = field
                .average_over_square(2.0 * half)
                .expect("within the disc");
            let difference = relative(coarse.into(), fine);
            assert!(difference < 1e-12, "{difference:e}");
        }
    }

    #[test]
    fn the_centre_under_two_forces_has_the_known_stress() {
        // Hertz: −3P/(πR) along them and P/(πR) across.
        let push = |angle| RimForce {
            angle,
            radial: -1.0,
            tangential: 0.0,
        };
        let forces = [push(FRAC_PI_2), push(-FRAC_PI_2)];
        let field = DiscField::new(2.0, &forces, [0.0; 2]).expect("balances");
        let known = [[0.5 / PI, 0.0], [0.0, -1.5 / PI]];
        assert!(relative(field.stress([0.0; 2]), known) < 1e-15);
    }

    #[test]
    fn the_centres_trace_is_the_average_and_without_friction_the_rest_is_twice() {
        let deviator = |tensor: Matrix2<f64>| tensor - tensor.trace() / 2.0 * Matrix2::identity();
        let mut smooth = an_example().loads;
        for load in &mut smooth {
            load.force = load.force.norm() * -load.point.normalize();
        }
        let sum: Vector2<f64> = smooth.iter().map(|load| load.force).sum();
        let smooth = DiscField::checked(2.0, smooth, -sum / (4.0 * PI)).expect("balances");
        for field in [figure_4().expect("balances"), smooth] {
            let centre = Matrix2::from(field.stress([0.0; 2]));
            let mean = Matrix2::from(field.contact_average());
            assert!((centre.trace() - mean.trace()).abs() < 1e-14 * scale(&field));
            let left = (deviator(centre) - 2.0 * deviator(mean)).amax();
            assert!(left < 1e-14 * scale(&field), "{left:e}");
        }
    }

    #[test]
    fn figure_4_has_the_averages_of_table_3_in_its_cell_and_others_in_its_control_square() {
        let field = figure_4().expect("balances");
        let cell = field.average_over_cell(2.0);
        assert!(relative(cell, [[-0.25, 0.0], [0.0, -0.5]]) < 1e-15);
        let disc = field.average_over_disc();
        let square = field.average_over_square(1.0).expect("within the disc");
        assert!(relative(disc, field.contact_average()) < 1e-14);
        // The assumption of section 3.3 fails by these ratios.
        for (i, ratio) in [(0, 0.82633), (1, 1.43777)] {
            let found = square[i][i] / cell[i][i];
            assert!((found - ratio).abs() < 1e-5, "{i}: {found}");
        }
        for (i, ratio) in [(0, 0.64900), (1, 1.12922)] {
            let found = square[i][i] / disc[i][i];
            assert!((found - ratio).abs() < 1e-5, "{i}: {found}");
        }
    }

    #[test]
    fn what_does_not_balance_is_refused() {
        let force = |angle, radial, tangential| RimForce {
            angle,
            radial,
            tangential,
        };
        let told = |radius, forces: &[RimForce], body_force| {
            DiscField::new(radius, forces, body_force)
                .expect_err("must be refused")
                .to_string()
        };
        let (right, left) = (force(0.0, -2.0, 0.0), force(PI, -2.0, 0.0));
        let pushed = told(1.0, &[right], [0.0; 2]);
        assert_eq!(pushed, "forces and weight leave (-2, 0) N/m, must balance");
        let couple = [force(0.0, 0.0, 3.0), force(PI, 0.0, 3.0)];
        let turned = told(1.0, &couple, [0.0; 2]);
        assert_eq!(
            turned,
            "the moments about the centre leave 6 N, must balance"
        );
        let radius = "the disc's radius is 0 m, must be above 0 and finite";
        assert_eq!(told(0.0, &[], [0.0; 2]), radius);
        let nan = force(0.0, f64::NAN, 0.0);
        assert_eq!(told(1.0, &[nan], [0.0; 2]), "force 0 is not finite");
        let endless = [0.0, f64::INFINITY];
        assert_eq!(
            told(1.0, &[right, left], endless),
            "the body force is not finite"
        );
    }

    #[test]
    fn a_square_beyond_the_rim_is_refused() {
        for side in [1.5, 0.0, -1.0, f64::NAN] {
            let refused = figure_4().expect("balances").average_over_square(side);
            assert!(
                matches!(refused, Err(DiscFieldError::Square { .. })),
                "{side}"
            );
        }
    }

    #[test]
    fn a_disc_without_forces_has_no_stress() {
        let field = DiscField::new(1.0, &[], [0.0; 2]).expect("balances");
        assert_eq!(field.average_over_disc(), [[0.0; 2]; 2]);
        assert_eq!(field.stress([0.1, 0.2]), [[0.0; 2]; 2]);
    }
}
