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
//! moments balance, the first where the forces do, and −(Σf_r/(2πR)) I takes away the second.
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
pub const BALANCE: f64 = 1e-9;
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
    pub point: Vector2<f64>,
    /// On the disc, N/m.
    pub force: Vector2<f64>,
}

/// The stress inside a disc under balanced forces on its rim.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscField {
    radius: f64,
    loads: Vec<PointForce>,
    /// −Σf_r/(2πR), Pa.
    isotropic: f64,
}

impl DiscField {
    /// The field in a disc of `radius` m under `forces`; none where they do not balance, moments about the centre too.
    pub fn new(radius: f64, forces: &[RimForce]) -> Option<Self> {
        let field = DiscField::under_balanced(radius, forces);
        (field.imbalance() <= BALANCE).then_some(field)
    }

    /// What is left of the forces, or of their moments over the radius, over the sum of their sizes.
    fn imbalance(&self) -> f64 {
        let loads = || self.loads.iter();
        let sizes: f64 = loads().map(|load| load.force.norm()).sum();
        let left: Vector2<f64> = loads().map(|load| load.force).sum();
        let moment: f64 = loads().map(|load| load.point.perp(&load.force)).sum();
        let left = left.norm().max(moment.abs() / self.radius);
        // No forces are in balance.
        if left == 0.0 { 0.0 } else { left / sizes }
    }

    /// What is left of forces on the rim of a disc, over the sum of their sizes.
    pub fn imbalance_of(radius: f64, forces: &[RimForce]) -> f64 {
        DiscField::under_balanced(radius, forces).imbalance()
    }

    fn under_balanced(radius: f64, forces: &[RimForce]) -> Self {
        let loads = forces.iter().map(|force| {
            let out = unit(force.angle);
            PointForce {
                point: radius * out,
                force: force.radial * out + force.tangential * left_of(out),
            }
        });
        let loads: Vec<PointForce> = loads.collect();
        let radial: f64 = loads.iter().map(|load| load.force.dot(&load.point)).sum();
        DiscField {
            radius,
            isotropic: -radial / radius / (TAU * radius),
            loads,
        }
    }

    /// R, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    pub fn forces(&self) -> &[PointForce] {
        &self.loads
    }

    /// σ at a point of the disc, xx and xz above zx and zz, Pa, tension positive. It grows without bound
    /// towards the point of a force and is not a number there; outside the disc it means nothing.
    pub fn stress(&self, point: impl Into<Vector2<f64>>) -> Matrix2<f64> {
        let at = point.into();
        let flamant: Matrix2<f64> = self.loads.iter().map(|load| flamant(load, at)).sum();
        flamant + Matrix2::from_diagonal_element(self.isotropic)
    }

    /// (1/πR²) ∫σ dA over the disc by quadrature of the field, Pa. Each force's singular part is
    /// integrated in polar coordinates about its own point, where the element r dr dθ takes the
    /// singularity away and the disc is 0 < r < 2R cosθ.
    pub fn average_over_disc(&self) -> Matrix2<f64> {
        let singular = self.loads.iter().map(|load| self.integral_about(load));
        let singular: Matrix2<f64> = singular.sum();
        singular / self.volume() + Matrix2::from_diagonal_element(self.isotropic)
    }

    /// ∫ of one force's part over the disc, N.
    fn integral_about(&self, load: &PointForce) -> Matrix2<f64> {
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
    pub fn average_over_square(&self, side: f64) -> Matrix2<f64> {
        debug_assert!(0.0 < side && side <= SQRT_2 * self.radius);
        let half = 0.5 * side;
        let integral = integrate(-half, half, PANELS, |x| {
            integrate(-half, half, PANELS, |z| self.stress([x, z]))
        });
        integral / (side * side)
    }

    /// Σ/V of the contact forces with V = πR², Pa: what [`DiscField::average_over_disc`] must be.
    pub fn contact_average(&self) -> Matrix2<f64> {
        self.extensive() / self.volume()
    }

    /// Σ/V with V = s² of a Voronoi cell of side s = `side` m, Pa, as in Table 3: the voids of the
    /// cell are counted in and carry nothing.
    pub fn average_over_cell(&self, side: f64) -> Matrix2<f64> {
        self.extensive() / (side * side)
    }

    /// Σ_ij = Σ x_i F_j of Eq. 7, J per metre of depth, tension positive. Balanced moments make it symmetric; the rounding
    /// that is left is halved between the two.
    fn extensive(&self) -> Matrix2<f64> {
        let terms = self.loads.iter();
        let sum: Matrix2<f64> = terms.map(|load| load.point * load.force.transpose()).sum();
        0.5 * (sum + sum.transpose())
    }

    /// πR², m³ per metre of depth.
    fn volume(&self) -> f64 {
        PI * self.radius * self.radius
    }
}

/// The disc of Figure 4: R = 1 m, vertical forces of 1 N/m, horizontal ones of 0.5 N/m.
pub fn figure_4() -> DiscField {
    let pushes = [(FRAC_PI_2, 1.0), (-FRAC_PI_2, 1.0), (0.0, 0.5), (PI, 0.5)];
    let forces = pushes.map(|(angle, force)| RimForce {
        angle,
        radial: -force,
        tangential: 0.0,
    });
    DiscField::under_balanced(1.0, &forces)
}

/// −(2/π)(F·r̂)/r r̂⊗r̂, Pa.
fn flamant(load: &PointForce, at: Vector2<f64>) -> Matrix2<f64> {
    let away = at - load.point;
    let square = away.norm_squared();
    away * away.transpose() * (-FRAC_2_PI * load.force.dot(&away) / (square * square))
}

fn unit(angle: f64) -> Vector2<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector2::new(cos, sin)
}

/// A quarter of a turn counterclockwise from it.
fn left_of(vector: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-vector.y, vector.x)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn force(angle: f64, radial: f64, tangential: f64) -> RimForce {
        RimForce {
            angle,
            radial,
            tangential,
        }
    }

    /// Any forces made to balance by two more pushes or pulls.
    fn balanced(radius: f64, mut forces: Vec<RimForce>) -> DiscField {
        let mean = forces.iter().map(|f| f.tangential).sum::<f64>() / forces.len() as f64;
        let mut sum = Vector2::zeros();
        for force in &mut forces {
            force.tangential -= mean;
            let out = unit(force.angle);
            sum += force.radial * out + force.tangential * left_of(out);
        }
        forces.extend([force(0.0, -sum.x, 0.0), force(FRAC_PI_2, -sum.y, 0.0)]);
        DiscField::new(radius, &forces).expect("made to balance")
    }

    fn fields() -> impl Strategy<Value = DiscField> {
        let force = (0.0..TAU, -1.0..1.0, -1.0..1.0).prop_map(|(a, r, t)| force(a, r, t));
        let forces = prop::collection::vec(force, 1..7);
        (0.01..10.0, forces).prop_map(|(radius, forces)| balanced(radius, forces))
    }

    /// With friction, points far from the axes.
    fn an_example() -> DiscField {
        let forces = vec![
            force(0.6, -1.0, 0.3),
            force(2.2, -0.7, -0.2),
            force(4.1, -1.4, 0.5),
            force(5.5, -0.4, 0.1),
        ];
        balanced(2.0, forces)
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

    /// The largest difference as a share of the largest component.
    fn relative(a: Matrix2<f64>, b: Matrix2<f64>) -> f64 {
        (a - b).amax() / b.amax()
    }

    proptest! {
        #[test]
        fn the_rim_is_free_between_the_forces(field in fields()) {
            for step in 0..100 {
                let out = unit(TAU * f64::from(step) / 100.0);
                let point = field.radius * out;
                let mut away = field.loads.iter().map(|load| (load.point - point).norm());
                if away.all(|away| away >= 0.05 * field.radius) {
                    let traction = (field.stress(point) * out).norm();
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
                [1.0, -1.0].map(|sign| field.stress(point + sign * step * axis))
            });
            let [[right, left], [up, down]] = beside;
            let divergence = ((right - left).column(0) + (up - down).column(1)) / (2.0 * step);
            let left_over = divergence.norm() * field.radius;
            prop_assert!(left_over < 1e-3 * scale(&field), "{left_over:e}");
            let around: f64 = beside.iter().flatten().map(Matrix2::trace).sum();
            let laplacian = (around - 4.0 * field.stress(point).trace()) / 1e-6;
            prop_assert!(laplacian.abs() < 2e-2 * scale(&field), "{laplacian:e}");
        }

        #[test]
        fn the_average_over_the_disc_is_that_of_the_contacts(field in fields()) {
            let difference = field.average_over_disc() - field.contact_average();
            prop_assert!(difference.amax() < 1e-12 * scale(&field), "{:e}", difference.amax());
        }
    }

    #[test]
    fn the_average_over_a_square_is_that_of_its_tractions() {
        for field in [figure_4(), an_example()] {
            let half = 0.5 * field.radius;
            let sides = [0.0, FRAC_PI_2, PI, 3.0 * FRAC_PI_2].map(|angle| {
                let out = unit(angle);
                integrate(-half, half, 4, |s| {
                    let point = half * out + s * left_of(out);
                    point * (field.stress(point) * out).transpose()
                })
            });
            let tractions = sides.iter().sum::<Matrix2<f64>>() / (4.0 * half * half);
            let square = field.average_over_square(2.0 * half);
            let difference = relative(square, tractions);
            assert!(difference < 1e-12, "{difference:e}");
        }
    }

    #[test]
    fn the_centre_under_two_forces_has_the_known_stress() {
        // Hertz: −3P/(πR) along them and P/(πR) across.
        let forces = [force(FRAC_PI_2, -1.0, 0.0), force(-FRAC_PI_2, -1.0, 0.0)];
        let field = DiscField::new(2.0, &forces).expect("balances");
        let known = Matrix2::new(0.5 / PI, 0.0, 0.0, -1.5 / PI);
        assert!(relative(field.stress([0.0; 2]), known) < 1e-15);
    }

    #[test]
    fn the_centres_trace_is_the_average_and_without_friction_the_rest_is_twice() {
        let deviator = |tensor: Matrix2<f64>| tensor - tensor.trace() / 2.0 * Matrix2::identity();
        let smooth = [(0.6, -1.0), (2.2, -0.7), (4.1, -1.4)].map(|(a, r)| force(a, r, 0.0));
        for field in [figure_4(), balanced(2.0, smooth.into())] {
            let (centre, mean) = (field.stress([0.0; 2]), field.contact_average());
            assert!((centre.trace() - mean.trace()).abs() < 1e-14 * scale(&field));
            let left = (deviator(centre) - 2.0 * deviator(mean)).amax();
            assert!(left < 1e-14 * scale(&field), "{left:e}");
        }
    }

    #[test]
    fn figure_4_has_the_averages_of_table_3_in_its_cell_and_others_in_its_control_square() {
        let field = figure_4();
        let cell = field.average_over_cell(2.0);
        assert!(relative(cell, Matrix2::new(-0.25, 0.0, 0.0, -0.5)) < 1e-15);
        let disc = field.average_over_disc();
        let square = field.average_over_square(1.0);
        assert!(relative(disc, field.contact_average()) < 1e-14);
        // The assumption of section 3.3 fails by these ratios.
        for (i, ratios) in [(0, [0.82633, 0.64900]), (1, [1.43777, 1.12922])] {
            let found = [cell, disc].map(|average| square[(i, i)] / average[(i, i)]);
            let near = |(found, ratio): (&f64, f64)| (found - ratio).abs() < 1e-5;
            assert!(found.iter().zip(ratios).all(near), "{i}: {found:?}");
        }
    }

    #[test]
    fn what_does_not_balance_is_refused() {
        let (one, not_finite) = (force(0.0, -2.0, 0.0), force(0.0, f64::NAN, 0.0));
        let couple = [force(0.0, 0.0, 3.0), force(PI, 0.0, 3.0)];
        for forces in [&[one][..], &couple, &[not_finite]] {
            assert_eq!(DiscField::new(1.0, forces), None);
        }
    }

    #[test]
    fn a_disc_without_forces_has_no_stress() {
        let field = DiscField::new(1.0, &[]).expect("balances");
        assert_eq!(field.average_over_disc(), Matrix2::zeros());
        assert_eq!(field.stress([0.1, 0.2]), Matrix2::zeros());
    }
}
