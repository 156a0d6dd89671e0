//! What a contact remembers is forgotten when it ends; that it is kept while it lasts, through every rebuild of the list, any
//! case shows.

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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// It touches the same again and again.
    #[test]
    fn a_contact_that_parted_begins_anew(
        law in rubbing_springs(),
        sides in prop::sample::select(vec![Sides::Grains, Sides::Walls, Sides::PunchAndFloor]),
        gap in 0.005f64..0.08,
        drift in -1.0f64..1.0,
        spin in -1.0f64..1.0,
    ) {
        let case = to_and_fro(sides, law, gap, drift, spin);
        is_like_the_reference(&case, 0.1)?;
        let found = run(&case);
        let touches = found.iter().map(|moment| !moment.contacts.is_empty());
        let touches: Vec<bool> = touches.collect();
        let met = touches.windows(2).filter(|pair| **pair == [false, true]).count();
        prop_assert!(met >= 3, "{met}");
    }
}
