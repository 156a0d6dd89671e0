//! What a contact cannot do: pull, and bear more shear than Coulomb allows.

use super::*;

/// The dashpot clipped, if there is one.
fn clipped(mut law: Law) -> Law {
    match &mut law.contact.viscosity {
        Viscosity::None => {}
        Viscosity::Dashpot { tension, .. }
        | Viscosity::Restitution { tension, .. }
        | Viscosity::Ratio { tension, .. } => {
            *tension = Tension::Clipped;
        }
    }
    law
}

/// Two grains on their way into a collision, off centre, followed step by step.
fn collision(law: Law, off: f64) -> Case {
    let one = Grain::disc([0.0; 2], LARGEST, DENSITY);
    let dt = 0.02 * (one.mass / (MODULUS * LARGEST)).sqrt();
    let two = Grain::disc([2.001 * LARGEST, off * LARGEST], LARGEST, DENSITY);
    let two = two
        .moving([-1.0e-3 * LARGEST / dt, 0.0])
        .spinning(1.0e-3 / dt);
    case("collision", model(law, dt), &[one, two], (0..400).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// With friction the table's normal force has some of the shear force in it where the normal turned
    /// far in one step; without, it is that of spring and dashpot.
    #[test]
    fn no_smooth_contact_pulls(mut case in cases(any_law().prop_map(clipped))) {
        case.model.law.friction_angle = 0.0;
        for moment in run(&case) {
            for contact in &moment.contacts {
                prop_assert!(contact.normal_force >= 0.0, "step {}: {contact:?}", moment.step);
            }
        }
    }

    #[test]
    fn only_an_unclipped_dashpot_pulls(e_n in 0.1f64..0.9, off in 0.0f64..0.5, mut law in any_law()) {
        for tension in [Tension::Clipped, Tension::Unclipped] {
            law.contact.viscosity = Viscosity::Restitution { e_n, tension };
            let moments = run(&collision(law.clone(), off));
            prop_assert!(moments.iter().any(|moment| !moment.contacts.is_empty()));
            prop_assert!(moments[399].contacts.is_empty(), "they part");
            let mut contacts = moments.iter().flat_map(|moment| &moment.contacts);
            let pulls = contacts.any(|contact| contact.normal_force < 0.0);
            prop_assert_eq!(pulls, tension == Tension::Unclipped);
        }
    }

    /// What is left of a contact's force without its spring is no more than Coulomb allows, however wildly
    /// the grains move.
    #[test]
    fn shear_is_within_coulombs_limit(case in cases(rubbing_springs())) {
        let tangent = case.model.law.friction_angle.tan();
        for moment in run(&case) {
            let radius = &moment.bodies.radius;
            for contact in &moment.contacts {
                let two = radius[contact.id2 as usize];
                let one = radius.get(contact.id1 as usize).copied().unwrap_or(two);
                let spring = 2.0 * MODULUS * one * two / (one + two) * contact.overlap;
                let [fx, fz] = contact.force();
                let shear = (fx - spring * contact.normal[0]).hypot(fz - spring * contact.normal[1]);
                let most = tangent * spring;
                prop_assert!(shear <= most * (1.0 + 1.0e-12), "step {}: {contact:?}", moment.step);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// In a poured bed the normals turn little in a step, and the table's two forces are the two of the law:
    /// to a few parts in a billion, since a shear force is turned to first order.
    #[test]
    fn no_contact_of_a_poured_bed_pulls_or_bears_too_much_shear(
        mut law in rubbing_springs(),
        viscosity in viscosity(),
    ) {
        law.contact.viscosity = viscosity;
        law = clipped(law);
        if let Viscosity::Dashpot { c_n, .. } = &mut law.contact.viscosity {
            // As strong as the springs of stiff grains want it.
            *c_n *= 300.0;
        }
        let mut scene = frictional_scene();
        scene.measurement.history_every = 100;
        scene.material.friction_angle = law.friction_angle;
        scene.material.stiffness_ratio = law.stiffness_ratio;
        scene.contact = law.contact;
        let tangent = law.friction_angle.tan();
        let task = Task::pour(initial_bodies(&scene), 16_000);
        let (mut contacts, mut at_limit) = (0, 0);
        for moment in native_outcome(&scene, &task, None).1 {
            for contact in &moment.contacts {
                prop_assert!(contact.normal_force >= 0.0, "step {}: {contact:?}", moment.step);
                let most = tangent * contact.normal_force;
                let shear = contact.tangential_force.abs();
                prop_assert!(shear <= most * (1.0 + 1.0e-7), "step {}: {contact:?}", moment.step);
                contacts += 1;
                at_limit += usize::from(shear > most * (1.0 - 1.0e-7));
            }
        }
        prop_assert!(contacts > 1000 && at_limit > 0, "{at_limit} of {contacts}");
    }
}
