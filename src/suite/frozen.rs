//! Random frozen states: overlapping grains between walls and around a punch, for every kind of pair
//! and every option of the contact law that YADE has.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::Group;
use super::build::{Grain, case, friction, model, punch, springs, wall, with_viscosity};
use super::parity::{ParityRung, Place};
use grains::model::{Axis, Law};
use grains::scene::{ContactLaw, Rotation, SlipVelocity, Tension, TorqueArms, Viscosity};

/// Key of the random numbers.
const KEY: &[u8; 32] = b"crossgrain: random frozen states";
/// Grains of a state; half of them around the punch.
const GRAINS: usize = 160;
/// Inner width of the box, m.
const WIDTH: f64 = 0.4;
/// Centre and half-extents of the punch, m.
const PUNCH: [[f64; 2]; 2] = [[0.2, 0.25], [0.05, 0.03]];
/// Radii, m.
const RADII: [f64; 2] = [0.005, 0.015];
/// Pa; soft, so that deep overlaps do not throw the grains apart at once.
const MODULUS: f64 = 1.0e7;
/// s.
const DT: f64 = 1.0e-6;

/// A rung for each option.
pub fn rungs() -> Vec<ParityRung> {
    laws()
        .into_iter()
        .enumerate()
        .map(|(stream, (name, what, law))| rung(stream as u64, name, what, law))
        .collect()
}

/// Every contact law that YADE has, with its name.
pub fn laws() -> Vec<(&'static str, &'static str, Law)> {
    let rough = |slip_velocity, torque_arms| {
        let law = friction(MODULUS, 0.7, 0.4);
        Law {
            contact: ContactLaw {
                slip_velocity,
                torque_arms,
                ..law.contact
            },
            ..law
        }
    };
    let blocked = Law {
        contact: ContactLaw {
            rotation: Rotation::Blocked,
            ..ContactLaw::default()
        },
        ..friction(MODULUS, 0.7, 0.4)
    };
    let dashpot = || Viscosity::Dashpot {
        c_n: 37.3,
        tension: Tension::Clipped,
    };
    use SlipVelocity::{ContactPoint, RatchetingCorrected};
    vec![
        ("frictionless", "normal springs only", springs(MODULUS)),
        (
            "friction",
            "friction, corrected slip, half-overlap arms",
            rough(RatchetingCorrected, TorqueArms::HalfOverlap),
        ),
        (
            "friction-ratcheting",
            "friction, contact point slip, half-overlap arms",
            rough(ContactPoint, TorqueArms::HalfOverlap),
        ),
        (
            "friction-point-arms",
            "friction, corrected slip, contact point arms",
            rough(RatchetingCorrected, TorqueArms::ContactPoint),
        ),
        (
            "friction-point",
            "friction, contact point slip and arms",
            rough(ContactPoint, TorqueArms::ContactPoint),
        ),
        ("friction-blocked", "friction, rotations blocked", blocked),
        (
            "dashpot",
            "dashpots without friction",
            with_viscosity(springs(MODULUS), dashpot()),
        ),
        (
            "dashpot-friction",
            "dashpots and friction",
            with_viscosity(friction(MODULUS, 0.7, 0.4), dashpot()),
        ),
    ]
}

fn rung(stream: u64, name: &str, what: &str, law: Law) -> ParityRung {
    let mut model = model(law, DT);
    model.gravity = [0.3, -9.81];
    model.alpha = 0.3;
    model.walls = vec![wall(Axis::X, 0.0), wall(Axis::X, WIDTH), wall(Axis::Z, 0.0)];
    let mut case = case(
        &format!("frozen {name}"),
        model,
        &grains(stream),
        vec![0, 1, 2, 3, 30],
    );
    let [centre, half_extents] = PUNCH;
    case.punch = Some(punch(
        centre[0],
        centre[1] - half_extents[1],
        half_extents,
        -0.7,
    ));
    ParityRung {
        name: format!("frozen-{name}"),
        title: format!("forces, torques and motion from a random frozen state: {what}"),
        group: Group::Parity,
        case,
        places: Place::ALL.to_vec(),
    }
}

/// Grains thrown at random into the box, every other one at the punch, some at each wall.
fn grains(stream: u64) -> Vec<Grain> {
    let mut random = ChaCha8Rng::from_seed(*KEY);
    random.set_stream(stream);
    let mut uniform = |low: f64, high: f64| {
        let share = (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * share
    };
    let [centre, half] = PUNCH;
    (0..GRAINS)
        .map(|index| {
            let radius = uniform(RADII[0], RADII[1]);
            let position = if index % 2 == 0 {
                [0, 1].map(|axis| {
                    let reach = half[axis] + 0.9 * RADII[1];
                    uniform(centre[axis] - reach, centre[axis] + reach)
                })
            } else {
                match index % 20 {
                    1 => [0.8 * radius, uniform(0.002, 0.2)],
                    3 => [WIDTH - 0.8 * radius, uniform(0.002, 0.2)],
                    5 => [uniform(0.002, WIDTH - 0.002), 0.8 * radius],
                    _ => [uniform(0.002, WIDTH - 0.002), uniform(0.002, 0.2)],
                }
            };
            let velocity = [uniform(-2.0, 2.0), uniform(-2.0, 2.0)];
            Grain::disc(position, radius, 2600.0)
                .moving(velocity)
                .spinning(uniform(-300.0, 300.0))
        })
        .collect()
}
