//! The punch and grains that it holds or meets.

use crossgrain::suite::{Grain, case, model, punch, springs};

use crate::support::*;

/// A punch of 0.2 m by 0.4 m around the origin and a grain in it: in a corner's reach of each face and
/// on a face itself.
#[test]
fn a_grain_inside_the_punch_bears_the_force_of_the_nearest_face() {
    let (radius, modulus) = (0.01, 1.0e7);
    for (place, normal, depth) in [
        ([0.095, -0.185], [1.0, 0.0], 0.005),
        ([-0.095, -0.185], [-1.0, 0.0], 0.005),
        ([0.085, -0.195], [0.0, -1.0], 0.005),
        ([0.02, 0.15], [0.0, 1.0], 0.05),
        ([0.0, -0.2], [0.0, -1.0], 0.0),
        ([0.1, 0.03], [1.0, 0.0], 0.0),
        ([-0.02, -0.01], [-1.0, 0.0], 0.08),
    ] {
        let grain = Grain::disc(place, radius, 2600.0);
        let model = model(springs(modulus), 1.0e-5);
        let mut case = case("in the punch", model, &[grain], vec![0, 1]);
        case.punch = Some(punch(0.0, -0.2, [0.1, 0.2], 0.0));
        let moments = native::run_case(&case, None).expect("a sound run");
        let [contact] = moments[0].contacts[..] else {
            panic!("one contact at {place:?}");
        };
        assert_eq!((contact.id1, contact.id2), (1, 0));
        assert_eq!(contact.normal, normal, "{place:?}");
        near(contact.overlap, radius + depth, 1.0e-16);
        let force = modulus * radius * (radius + depth);
        near(contact.normal_force / force, 1.0, 1.0e-14);
        // The middle between the face and the deepest point of the grain.
        let middle = [0, 1].map(|axis| place[axis] + 0.5 * (depth - radius) * normal[axis]);
        let off = (contact.point[0] - middle[0]).hypot(contact.point[1] - middle[1]);
        assert!(off < 1.0e-16, "{place:?}");
        let pushed = [moments[1].bodies.vx[0], moments[1].bodies.vz[0]];
        let speed = force / grain.mass * 1.0e-5;
        let wrong = (pushed[0] - speed * normal[0]).hypot(pushed[1] - speed * normal[1]);
        assert!(wrong < 1.0e-14 * speed, "{place:?}: {pushed:?}");
    }
}
