//! The neighbour list misses no pair and invents none.

use crossgrain::suite::springs;

use super::*;

/// With this skin cells have the side 2.1, over the largest radius.
const BORDERS_SKIN: f64 = 0.1;

/// A grain at the origin, where the first border of cells is; the others on borders, beside them, or as far
/// from them as touching grains are.
fn on_cell_borders() -> impl Strategy<Value = Case> {
    let side = 2.0 * LARGEST + BORDERS_SKIN * LARGEST;
    let beside = prop::sample::select(vec![
        0.0, 1.0e-15, -1.0e-15, -0.05, 0.05, 1.0, 1.99, -1.99, 2.0, 2.1,
    ]);
    let coordinate = (0u8..6, beside)
        .prop_map(move |(border, beside)| (f64::from(border) * side + beside * LARGEST).max(0.0));
    let place = [coordinate.clone(), coordinate];
    let grain = (place, prop::sample::select(vec![1.0, 0.999, 0.5]));
    (prop::collection::vec(grain, 1..40), any_law()).prop_map(|(places, law)| {
        let mut grains = vec![Grain::disc([0.0; 2], LARGEST, DENSITY)];
        for (place, size) in places {
            // Two grains at one place have no normal.
            if grains.iter().all(|grain| grain.position != place) {
                grains.push(Grain::disc(place, size * LARGEST, DENSITY));
            }
        }
        let dt = 0.1 * (grains[0].mass / (MODULUS * LARGEST)).sqrt();
        case("borders", model(law, dt), &grains, (0..30).collect())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn contacts_are_the_pairs_that_touch_on_cell_borders(case in on_cell_borders()) {
        is_like_the_reference(&case, BORDERS_SKIN)?;
    }

    /// Some grains are as far off as kilometres, and the cloud itself is.
    #[test]
    fn contacts_are_the_pairs_that_touch_far_away(
        mut case in cases(any_law()),
        far in prop::collection::vec(([-1.0f64..1.0, -1.0f64..1.0], 0usize..50), 1..6),
        away in prop::sample::select(vec![1.0, 1.0e3, 1.0e6, 1.0e9]),
        shift in prop::sample::select(vec![0.0, -1.0, 1.0e4]),
        skin in skin(),
    ) {
        let bodies = &mut case.bodies;
        bodies.x.iter_mut().chain(&mut bodies.z).for_each(|coordinate| *coordinate += shift);
        for (place, id) in far {
            let id = id % bodies.len();
            bodies.x[id] += away * place[0];
            bodies.z[id] += away * place[1];
        }
        for wall in &mut case.model.walls {
            wall.place += shift;
        }
        if let Some(punch) = &mut case.punch {
            punch.centre = punch.centre.map(|coordinate| coordinate + shift);
        }
        is_like_the_reference(&case, skin)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Grains at rest and apart make no list old; the punch's own way must.
    #[test]
    fn a_punch_finds_grains_at_rest(
        sizes in prop::collection::vec(0.1f64..1.0, 25),
        place in [0.0f64..15.0, -11.0f64..19.0],
        half in [0.5f64..6.0, 0.5f64..4.0],
        stride in -0.1f64..0.1,
        skin in skin(),
    ) {
        let grains: Vec<Grain> = sizes
            .iter()
            .enumerate()
            .map(|(index, size)| {
                let place = [(index % 5) as f64, (index / 5) as f64];
                Grain::disc(place.map(|index| 3.0 * LARGEST * index), size * LARGEST, DENSITY)
            })
            .collect();
        let dt = 1.0e-4;
        let mut case = case("at rest", model(springs(MODULUS), dt), &grains, (0..80).collect());
        let half = half.map(|side| side * LARGEST);
        let [axis, bottom] = place.map(|coordinate| coordinate * LARGEST);
        case.punch = Some(punch(axis, bottom, half, stride * LARGEST / dt));
        is_like_the_reference(&case, skin)?;
    }
}

/// Two grains that are no listed pair at the start move together by less in each step than the list allows for.
#[test]
fn grains_that_creep_together_are_found() {
    let mut grains = vec![Grain::disc([-5.0 * LARGEST, 0.0], LARGEST, DENSITY)];
    for (x, stride) in [(0.0, 0.003), (2.12 * LARGEST, -0.003)] {
        let grain = Grain::disc([x, 0.3 * LARGEST], LARGEST, DENSITY);
        grains.push(grain.moving([stride * LARGEST / 1.0e-5, 0.0]));
    }
    let moments = (0..30).collect();
    let case = case("creep", model(springs(MODULUS), 1.0e-5), &grains, moments);
    is_like_the_reference(&case, 0.1).expect("no pair is missed");
    assert!(run(&case)[18].contacts.is_empty() && !run(&case)[25].contacts.is_empty());
}

#[test]
fn a_case_may_have_no_grains() {
    let case = case("empty", model(springs(MODULUS), 1.0e-5), &[], vec![0, 3]);
    assert!(run(&case).iter().all(|moment| moment.contacts.is_empty()));
}
