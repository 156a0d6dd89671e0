//! Properties of the native engine that hold for every case, tried on random ones.

mod conservation;
mod history;
mod kernels;
mod limits;
mod lists;
mod symmetry;

use crossgrain::suite::{Grain, case, friction, model, punch, wall};
use grains::model::{Axis, Law};
use grains::native::CaseOptions;
use grains::scene::{
    ContactLaw, NewContactSlip, Rotation, SlipVelocity, Tension, TorqueArms, Viscosity,
};
use grains::task::Case;
use grains::variant::{self, Variant};
use proptest::prelude::*;

use crate::support::*;

/// Radius of the largest grain, m, and density, kg/m³.
const LARGEST: f64 = 0.01;
const DENSITY: f64 = 2600.0;
/// Young's modulus, Pa: soft, so that grains may overlap deeply without flying apart.
const MODULUS: f64 = 1.0e6;

fn run(case: &Case) -> Vec<Snapshot> {
    native::run_case(case, CaseOptions::default()).expect("a sound run")
}

/// With this skin over the largest radius, every moment has the bits of the step written out.
fn is_like_the_reference(case: &Case, skin_over_radius: f64) -> Result<(), TestCaseError> {
    let options = CaseOptions {
        skin_over_radius,
        ..CaseOptions::default()
    };
    let native = native::run_case(case, options).expect("a sound run");
    let written_out = variant::run(case, &Variant::default());
    prop_assert_eq!(native.len(), written_out.len());
    for (moment, other) in native.iter().zip(&written_out) {
        let step = moment.step;
        prop_assert_eq!(
            moment.bodies.digest(),
            other.bodies.digest(),
            "step {}",
            step
        );
        prop_assert_eq!(&moment.contacts, &other.contacts, "step {}", step);
        prop_assert_eq!(moment.punch, other.punch, "step {}", step);
    }
    Ok(())
}

/// From a list that is built anew whenever anything moves to one that holds far more than what is near.
fn skin() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 1.0e-3f64..0.1, Just(0.1), 0.1f64..5.0]
}

/// Any of the choices, without dashpots.
fn choices() -> impl Strategy<Value = ContactLaw> {
    any::<[bool; 4]>().prop_map(|[free, corrected, half, whole]| ContactLaw {
        rotation: [Rotation::Blocked, Rotation::Free][usize::from(free)],
        viscosity: Viscosity::None,
        slip_velocity: [
            SlipVelocity::ContactPoint,
            SlipVelocity::RatchetingCorrected,
        ][usize::from(corrected)],
        torque_arms: [TorqueArms::ContactPoint, TorqueArms::HalfOverlap][usize::from(half)],
        new_contact_slip: [NewContactSlip::SinceTouch, NewContactSlip::WholeStep]
            [usize::from(whole)],
        ..ContactLaw::default()
    })
}

fn tension() -> impl Strategy<Value = Tension> {
    prop_oneof![Just(Tension::Clipped), Just(Tension::Unclipped)]
}

fn viscosity() -> impl Strategy<Value = Viscosity> {
    prop_oneof![
        2 => Just(Viscosity::None),
        1 => (0.1f64..10.0, tension())
            .prop_map(|(c_n, tension)| Viscosity::Dashpot { c_n, tension }),
        1 => (0.1f64..=1.0, tension())
            .prop_map(|(e_n, tension)| Viscosity::Restitution { e_n, tension }),
    ]
}

/// Springs that rub, with any choices.
fn rubbing_springs() -> impl Strategy<Value = Law> {
    (0.1f64..1.5, 0.05f64..1.2, choices()).prop_map(|(ratio, angle, contact)| Law {
        contact,
        ..friction(MODULUS, ratio, angle)
    })
}

/// Smooth or rubbing springs with or without dashpots.
fn any_law() -> impl Strategy<Value = Law> {
    let smooth = prop::bool::weighted(0.25);
    (rubbing_springs(), viscosity(), smooth).prop_map(|(mut law, viscosity, smooth)| {
        law.contact.viscosity = viscosity;
        if smooth {
            law.friction_angle = 0.0;
        }
        law
    })
}

/// Of one grain: place in the cloud, velocity, spin and size, each as a share.
type Shares = ([f64; 2], [f64; 2], f64, f64);

/// Grains in a cloud that is anything from loose to crowded, of one size or fifty times apart.
#[derive(Debug, Clone)]
struct Cloud {
    grains: Vec<Grain>,
    /// m.
    side: f64,
    /// A share of √(m/k) of the smallest grain, s.
    dt: f64,
}

fn cloud() -> impl Strategy<Value = Cloud> {
    let share = -1.0f64..1.0;
    let (place, velocity) = ([0.0f64..1.0, 0.0f64..1.0], [share.clone(), share.clone()]);
    let grain = (place, velocity, share, 0.0f64..1.0);
    let smallest = prop_oneof![Just(1.0), 0.3f64..1.0, 0.02f64..0.3];
    let crowding = prop_oneof![1 => 0.01f64..0.1, 3 => 0.1f64..1.2];
    let stride = prop_oneof![1 => Just(0.0), 3 => 0.0f64..0.05];
    let count = prop_oneof![1 => 1usize..6, 3 => 1usize..50];
    let grains = count.prop_flat_map(move |count| prop::collection::vec(grain.clone(), count));
    let all = (grains, smallest, crowding, stride, any::<bool>());
    all.prop_map(|(shares, smallest, crowding, stride, disc)| {
        make_cloud(&shares, smallest, crowding, stride, disc)
    })
}

/// `smallest` over the largest radius; `crowding` is the share of the area that grains take, `stride` how far
/// the fastest one goes in a step, over the largest radius.
fn make_cloud(grains: &[Shares], smallest: f64, crowding: f64, stride: f64, disc: bool) -> Cloud {
    let radius = |size: f64| LARGEST * (smallest + (1.0 - smallest) * size);
    let area: f64 = grains.iter().map(|g| radius(g.3) * radius(g.3)).sum();
    let side = (3.0 * area / crowding).sqrt();
    let mut dt = f64::INFINITY;
    let mut grains: Vec<Grain> = grains
        .iter()
        .map(|(place, velocity, spin, size)| {
            let place = place.map(|share| side * share);
            let grain = match disc {
                true => Grain::disc(place, radius(*size), DENSITY),
                false => Grain::sphere(place, radius(*size), DENSITY),
            };
            dt = dt.min(0.1 * (grain.mass / (MODULUS * grain.radius)).sqrt());
            grain.moving(*velocity).spinning(*spin)
        })
        .collect();
    // Two grains at one place have no normal.
    let mut places: Vec<[f64; 2]> = Vec::new();
    grains.retain(|grain| {
        let alone = !places.contains(&grain.position);
        places.push(grain.position);
        alone
    });
    let speed = stride * LARGEST / dt;
    for grain in &mut grains {
        grain.velocity = grain.velocity.map(|share| share * speed);
        grain.spin *= speed / LARGEST;
    }
    Cloud { grains, side, dt }
}

/// Nothing but grains: no gravity, local damping, walls or punch.
fn free_cases(law: impl Strategy<Value = Law>) -> impl Strategy<Value = Case> {
    (cloud(), law).prop_map(|(cloud, law)| {
        let moments = (0..=60).step_by(6).collect();
        case("free", model(law, cloud.dt), &cloud.grains, moments)
    })
}

/// Grains in gravity with local damping, walls and a punch anywhere among them.
fn cases(law: impl Strategy<Value = Law>) -> impl Strategy<Value = Case> {
    let walls = prop::collection::vec((any::<bool>(), 0.0f64..1.0), 0..4);
    let share = 0.0f64..1.0;
    let punch_at = [share.clone(), share.clone(), share.clone(), share.clone()];
    let punch_at = prop::option::of((punch_at, -0.02f64..0.02));
    let gravity = prop_oneof![Just([0.0; 2]), [-1.0f64..1.0, -1.0f64..1.0]];
    let alpha = prop_oneof![Just(0.0), 0.0f64..0.9];
    (cloud(), law, walls, punch_at, gravity, alpha).prop_map(
        |(cloud, law, walls, punch_at, gravity, alpha)| {
            let Cloud { grains, side, dt } = cloud;
            let mut model = model(law, dt);
            // At most a hundredth of the largest radius in the square of a step.
            model.gravity = gravity.map(|share| share * 0.01 * LARGEST / (dt * dt));
            model.alpha = alpha;
            for (across, place) in walls {
                let axis = if across { Axis::X } else { Axis::Z };
                model.walls.push(wall(axis, place * side));
            }
            let moments = (0..=60).step_by(6).collect();
            let mut case = case("any", model, &grains, moments);
            case.punch = punch_at.map(|([x, z, width, height], stride)| {
                let half = [width, height].map(|share| 0.3 * side * share + 0.1 * LARGEST);
                punch(x * side, z * side, half, stride * LARGEST / dt)
            });
            case
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_case_has_the_bits_of_the_reference(case in cases(any_law()), skin in skin()) {
        is_like_the_reference(&case, skin)?;
    }
}
