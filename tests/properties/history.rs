//! What a contact remembers: kept while it lasts, through every rebuild of the list, and forgotten when
//! it ends.

use super::*;

/// What stands on either side of a grain that goes to and fro.
#[derive(Debug, Clone, Copy)]
enum Sides {
    Grains,
    Walls,
    PunchAndFloor,
}

/// A spinning grain in a gap a little wider than itself, so narrow that it never leaves the list.
fn to_and_fro(sides: Sides, law: Law, gap: f64, drift: f64, spin: f64) -> Case {
    let grain = Grain::disc([0.0; 2], LARGEST, DENSITY);
    let dt = 0.05 * (grain.mass / (MODULUS * LARGEST)).sqrt();
    let speed = 2.0e-3 * LARGEST / dt;
    let moving = grain.moving([drift * speed, speed]);
    let mut grains = vec![moving.spinning(spin * speed / LARGEST)];
    let mut model = model(law, dt);
    let half = LARGEST * (1.0 + 0.5 * gap);
    if let Sides::Grains = sides {
        // So large and heavy that they stay.
        for z in [half + 3.0 * LARGEST, -half - 3.0 * LARGEST] {
            let mut large = Grain::disc([0.0, z], 3.0 * LARGEST, DENSITY);
            large.mass *= 1.0e12;
            large.inertia *= 1.0e12;
            grains.push(large);
        }
    } else {
        model.walls.push(wall(Axis::Z, -half));
    }
    let mut of_punch = None;
    match sides {
        Sides::Grains => {}
        Sides::Walls => model.walls.push(wall(Axis::Z, half)),
        Sides::PunchAndFloor => of_punch = Some(punch(0.0, half, [5.0 * LARGEST; 2], 0.0)),
    }
    let mut case = case("to and fro", model, &grains, (0..600).collect());
    case.punch = of_punch;
    case
}

/// The case that starts at this moment of another.
fn from(case: &Case, moment: &Snapshot) -> Case {
    Case {
        bodies: moment.bodies.clone(),
        punch: moment.punch,
        moments: (0..case.moments.len() as u64 - moment.step).collect(),
        ..case.clone()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// While nothing touches, places, velocities and spins are all there is: a run that starts there goes
    /// on with the same bits, though the same bodies have touched before and touch again.
    #[test]
    fn a_contact_that_parted_begins_anew(
        law in rubbing_springs(),
        sides in prop::sample::select(vec![Sides::Grains, Sides::Walls, Sides::PunchAndFloor]),
        gap in 0.005f64..0.08,
        drift in -1.0f64..1.0,
        spin in -1.0f64..1.0,
    ) {
        let case = to_and_fro(sides, law, gap, drift, spin);
        let moments = run(&case);
        let touched = |range: &[Snapshot]| {
            let contacts = range.iter().flat_map(|moment| &moment.contacts);
            contacts.map(|c| (c.id1, c.id2)).collect::<BTreeSet<_>>()
        };
        let mut met_again = 0;
        for step in 1..moments.len() {
            let parted = moments[step].contacts.is_empty() && !moments[step - 1].contacts.is_empty();
            if !parted || touched(&moments[..step]).is_disjoint(&touched(&moments[step..])) {
                continue;
            }
            met_again += 1;
            for (anew, moment) in run(&from(&case, &moments[step])).iter().zip(&moments[step..]) {
                prop_assert_eq!(anew.bodies.digest(), moment.bodies.digest(), "step {}", moment.step);
                prop_assert_eq!(&anew.contacts, &moment.contacts, "step {}", moment.step);
            }
        }
        prop_assert!(met_again >= 2, "{met_again}");
    }

    /// A grain far off that touches nothing but makes the list old, seldom or with every step, changes
    /// nothing for the others.
    #[test]
    fn a_rebuilt_list_keeps_what_contacts_remember(case in cases(any_law()), shyness in 0.001f64..0.06) {
        let with_runner = |stride: f64| {
            let mut case = case.clone();
            let far = Grain::disc([-100.0, -100.0], 0.01 * LARGEST, DENSITY);
            let speed = -stride * LARGEST / case.model.dt;
            case.bodies.push(far.position, [speed, speed], far.radius, far.mass);
            if case.model.law.rotates() {
                case.bodies.spin.push(0.0);
                case.bodies.inertia.push(far.inertia);
            }
            run(&case)
        };
        let still = with_runner(0.0);
        for stride in [1.0, shyness] {
            for (one, other) in still.iter().zip(with_runner(stride)) {
                let count = one.bodies.len() - 1;
                for ((name, one), (_, other)) in one.bodies.motion().into_iter().zip(other.bodies.motion()) {
                    let count = count.min(one.len());
                    prop_assert_eq!(&one[..count], &other[..count], "{}", name);
                }
                prop_assert_eq!(&one.contacts, &other.contacts);
            }
        }
    }
}

/// Two grains pressed together and sheared without slip: the force grows by k_s times the way, with the
/// list rebuilt at every step or never.
#[test]
fn shear_adds_up_over_the_steps() {
    let mut law = friction(MODULUS, 0.5, 1.0);
    law.contact.rotation = Rotation::Blocked;
    law.contact.slip_velocity = SlipVelocity::ContactPoint;
    let dt = 1.0e-6;
    for stride in [0.0, 1.0] {
        let mut grains = [
            Grain::disc([0.0, 0.0], LARGEST, DENSITY),
            Grain::disc([0.0, 1.9 * LARGEST], LARGEST, DENSITY).moving([0.01, 0.0]),
            Grain::disc([-1.0, 0.0], 0.1 * LARGEST, DENSITY).moving([-stride * LARGEST / dt, 0.0]),
        ];
        // So heavy that the force does not move them.
        grains.iter_mut().for_each(|grain| grain.mass *= 1.0e12);
        let case = case("shear", model(law.clone(), dt), &grains, vec![0, 999]);
        let moments = run(&case);
        let k_s = 0.5 * MODULUS * LARGEST;
        for (moment, steps) in moments.iter().zip([1.0, 1000.0]) {
            // Body 2 goes along +x, which is against the positive tangent of a normal along z.
            let force = k_s * 0.01 * steps * dt;
            let found = moment.contacts[0].tangential_force;
            near(found / force, 1.0, 1.0e-4);
        }
    }
}
