use super::*;
use crate::paper::disc_field::{RimForce, figure_4};

/// A disc on two others and under one, with friction and weight.
fn a_grain() -> DiscField {
    let force = |angle: f64, radial: f64, tangential: f64| RimForce {
        angle,
        radial,
        tangential,
    };
    let forces = [
        force(4.2, -3.0, 0.4),
        force(5.4, -2.0, -0.3),
        force(1.2, -1.5, -0.1),
    ];
    let volume = std::f64::consts::PI * 0.25;
    let mut body_force = [0.0; 2];
    for force in &forces {
        let (sin, cos) = force.angle.sin_cos();
        body_force[0] -= (force.radial * cos - force.tangential * sin) / volume;
        body_force[1] -= (force.radial * sin + force.tangential * cos) / volume;
    }
    DiscField::new(0.5, &forces, body_force).expect("the weight balances the forces")
}

fn no_forces() -> DiscField {
    DiscField::new(0.5, &[], [0.0; 2]).expect("balances")
}

#[test]
fn every_number_draws_and_the_picture_is_small() {
    for field in [figure_4().expect("balances"), a_grain(), no_forces()] {
        let svg = picture(&field);
        for wrong in ["NaN", "inf", "-0.0 ", "−0<"] {
            assert!(!svg.contains(wrong), "{wrong}");
        }
        assert!(svg.len() < 300_000, "{}", svg.len());
        assert_eq!(svg.matches("<svg").count(), svg.matches("</svg>").count());
    }
}

#[test]
fn the_averages_stand_beside_the_curves() {
    let svg = picture(&figure_4().expect("balances"));
    for label in [
        "disc: 0.6366",
        "control square: 0.7189",
        "cell of side 2R: 0.5<",
    ] {
        assert!(svg.contains(label), "{label}");
    }
}

#[test]
fn only_what_is_clipped_is_hatched() {
    let hatched = |field: &DiscField, name: &str| {
        picture(field).contains(&format!("fill=\"url(#disc-field-{name})\""))
    };
    assert!(hatched(&figure_4().expect("balances"), "above"));
    assert!(!hatched(&figure_4().expect("balances"), "below"));
    assert!(!hatched(&no_forces(), "above") && !hatched(&no_forces(), "below"));
}
