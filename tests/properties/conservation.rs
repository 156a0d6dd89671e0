//! Momentum, and that the contacts of a snapshot are the forces that move the grains.

use super::*;

/// Σmv, Σ(r × mv + Iω) about the origin, and sums of magnitudes that bound their rounding.
fn momenta(bodies: &Bodies) -> ([f64; 3], [f64; 2]) {
    let (mut sums, mut sizes) = ([0.0; 3], [0.0; 2]);
    for i in 0..bodies.len() {
        let [px, pz] = [bodies.vx[i], bodies.vz[i]].map(|v| bodies.mass[i] * v);
        let (x, z) = (bodies.x[i], bodies.z[i]);
        let spin = bodies.spin.get(i);
        let spun = spin.map_or(0.0, |spin| spin * bodies.inertia[i]);
        sums[0] += px;
        sums[1] += pz;
        sums[2] += z * px - x * pz + spun;
        sizes[0] += px.abs() + pz.abs();
        sizes[1] += (z * px).abs() + (x * pz).abs() + spun.abs();
    }
    (sums, sizes)
}

/// Force and torque on each grain by these contacts, N and N·m, with the sums of their magnitudes.
fn on_grains(case: &Case, bodies: &Bodies, contacts: &[Contact]) -> Vec<([f64; 3], [f64; 2])> {
    let mut sums = vec![([0.0; 3], [0.0; 2]); bodies.len()];
    let arms = case.model.law.contact.torque_arms;
    for contact in contacts {
        let force = contact.force();
        let between_grains = (contact.id1 as usize) < bodies.len();
        let mut add = |id: u32, sign: f64| {
            let i = id as usize;
            let [fx, fz] = force.map(|component| sign * component);
            let [x, z] = contact.point;
            let mut arm = [x - bodies.x[i], z - bodies.z[i]];
            if arms == TorqueArms::HalfOverlap && !between_grains {
                let length = bodies.radius[i] - 0.5 * contact.overlap;
                arm = contact.normal.map(|n| -length * n);
            }
            let (sum, size) = &mut sums[i];
            sum[0] += fx;
            sum[1] += fz;
            sum[2] += arm[1] * fx - arm[0] * fz;
            size[0] += fx.abs() + fz.abs();
            size[1] += (arm[1] * fx).abs() + (arm[0] * fz).abs();
        };
        if between_grains {
            add(contact.id1, -1.0);
        }
        add(contact.id2, 1.0);
    }
    sums
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Leapfrog keeps both to rounding when every force has its opposite on one line, whatever the law.
    #[test]
    fn grains_alone_keep_their_momentum_and_angular_momentum(mut case in free_cases(any_law())) {
        case.moments = (0..=300).step_by(20).collect();
        // What keeps a grain from turning takes angular momentum.
        let held = case.model.law.has_friction() && !case.model.law.rotates();
        let moments = run(&case);
        let (before, mut size) = momenta(&moments[0].bodies);
        for moment in &moments {
            let (now, of_now) = momenta(&moment.bodies);
            size = [size[0].max(of_now[0]), size[1].max(of_now[1])];
            for (which, scale) in [(0, size[0]), (1, size[0]), (2, size[1])] {
                if which == 2 && held {
                    continue;
                }
                let change = (now[which] - before[which]).abs();
                prop_assert!(change <= 1.0e-12 * scale, "{which}: {change} of {scale}");
            }
        }
    }

    /// From one step to the next each grain gains what gravity and its contacts in the table give it.
    #[test]
    fn contacts_are_the_forces_that_move_the_grains(
        mut case in cases(any_law()),
        step in 0u64..40,
    ) {
        case.model.alpha = 0.0;
        case.moments = vec![step, step + 1];
        let [before, after] = &run(&case)[..] else {
            panic!("two moments");
        };
        let (bodies, dt) = (&before.bodies, case.model.dt);
        let mut on_punch = 0.0;
        for (i, (push, size)) in on_grains(&case, bodies, &before.contacts).iter().enumerate() {
            let columns = [(0, &bodies.vx, &after.bodies.vx), (1, &bodies.vz, &after.bodies.vz)];
            for (axis, old, new) in columns {
                let gained = bodies.mass[i] * (new[i] - old[i]);
                let given = dt * (push[axis] + bodies.mass[i] * case.model.gravity[axis]);
                let speed = old[i].abs() + new[i].abs();
                let slack = 1.0e-12 * (dt * size[0] + bodies.mass[i] * speed);
                prop_assert!((gained - given).abs() <= slack, "grain {i}: {gained} {given}");
            }
            if bodies.rotate() {
                let gained = bodies.inertia[i] * (after.bodies.spin[i] - bodies.spin[i]);
                let speed = bodies.spin[i].abs() + after.bodies.spin[i].abs();
                // A contact point is known to a rounding of the place, not of the arm.
                let torque = size[1] + size[0] * LARGEST;
                let slack = 1.0e-11 * (dt * torque + bodies.inertia[i] * speed);
                let given = dt * push[2];
                prop_assert!((gained - given).abs() <= slack, "grain {i}: {gained} {given}");
            }
        }
        let id = (bodies.len() + case.model.walls.len()) as u32;
        let mut size = 0.0;
        for contact in before.contacts.iter().filter(|contact| contact.id1 == id) {
            on_punch -= contact.force()[1];
            size += contact.force()[1].abs();
        }
        if let Some(punch) = before.punch {
            prop_assert!((punch.force - on_punch).abs() <= 1.0e-12 * size);
        }
    }
}
