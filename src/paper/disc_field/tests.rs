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
    let force = (0.0..TAU, -1.0..1.0, -1.0..1.0).prop_map(|(angle, radial, tangential)| RimForce {
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
