//! The states in space that an engine starts from when it is judged: one bed of spheres, poured and pressed, under laws of springs,
//! friction, dashpots, moments, adhesion and several materials, each with constants of its own, and under laws whose every key is
//! drawn.

use evidence::random::Source;
use grains::generate::initial_bodies;
use grains::model::{Axis, Law, Model, Solid, Wall};
use grains::native::{self, NativeError};
use grains::scene::{
    ContactLaw, Damping, Material, NewContactSlip, Rolling, Rotation, Scene, SlipVelocity, Springs,
    Tension, TorqueArms, Viscosity, parse_scene,
};
use grains::tables::{Bodies, Punch, Snapshot, Stage};
use grains::task::{Case, Task};

use crate::excerpt::Excerpt;
use crate::judge::Reference;
use crate::starts::{ANGLES, MOMENTS, RATIOS, RESTITUTIONS, Start, State, drawn};

/// Steps of pouring after which spheres are on their way down, and after which most lie.
const POURING: u64 = 2200;
const AT_REST: u64 = 12_000;
/// How far the punch has sunk, over the mean diameter.
const PRESSED: f64 = 1.0;
/// The largest speed of spins that grains are given, rad/s.
const SPIN: f64 = 40.0;
/// States of drawn laws.
const DRAWN: u64 = 20;
/// How many times as fast grains are in some states.
const FASTER: f64 = 3.0;
/// What grains of material 1 and 2 are made of.
const SOFTER: Solid = Solid {
    modulus: 0.8e7,
    stiffness_ratio: 0.7,
    poissons_ratio: 0.2,
    friction_angle: 0.3,
};
const STIFFER: Solid = Solid {
    modulus: 5.0e7,
    stiffness_ratio: 0.25,
    poissons_ratio: 0.4,
    friction_angle: 0.8,
};
const ROLLING: Rolling = Rolling {
    bending_stiffness: 0.1,
    twisting_stiffness: 0.08,
    limit: Some(0.1),
};
/// J/m²; the pull is a few weights of a grain.
const ADHESION: f64 = 2.0;

/// The scene whose bed it is.
pub fn scene() -> Scene {
    parse_scene(include_str!("spheres.json")).expect("it is a scene")
}

/// A law that engines are asked for, by what it changes of the scene's: its model, and its grains where they are of several materials.
type Change = fn(&mut Model, &mut Bodies);

/// Where precision is measured, and a law of which all states are looked at.
const HERTZ: usize = 3;
const DASHPOTS: usize = 6;

const LAWS: [(&str, Change); 11] = [
    ("linear springs in space", |model, _| {
        model.law.contact = ContactLaw::default();
        model.law.friction_angle = 0.0;
    }),
    ("linear springs and friction in space", |model, _| {
        linear(&mut model.law);
        model.alpha = 0.2;
    }),
    (
        "linear springs, friction and dashpots in space",
        |model, _| {
            linear(&mut model.law);
            model.law.wall_friction_angle = Some(0.2);
            model.law.punch_friction_angle = Some(0.7);
            model.law.contact.viscosity = Viscosity::Dashpot {
                c_n: 2.0,
                tension: Tension::Clipped,
            };
        },
    ),
    ("Hertz's springs", |model, _| {
        model.law.friction_angle = 0.0;
        model.law.contact.viscosity = Viscosity::None;
    }),
    ("Hertz's springs with other constants", |model, bodies| {
        model.law.friction_angle = 0.0;
        model.law.contact.viscosity = Viscosity::None;
        other_constants(model, bodies);
    }),
    ("Hertz–Mindlin", |model, _| {
        model.law.contact.viscosity = Viscosity::None;
        model.alpha = 0.2;
    }),
    ("Hertz–Mindlin with dashpots", |model, _| {
        model.law.contact.tangential_viscosity = Some(0.4);
    }),
    ("Hertz–Mindlin with other choices", |model, bodies| {
        let law = &mut model.law;
        law.contact.viscosity = Viscosity::Ratio {
            ratio: 0.15,
            tension: Tension::Unclipped,
        };
        law.contact.slip_velocity = SlipVelocity::ContactPoint;
        law.contact.torque_arms = TorqueArms::ContactPoint;
        law.poissons_ratio = Some(0.15);
        law.wall_friction_angle = Some(0.25);
        law.punch_friction_angle = Some(0.75);
        other_constants(model, bodies);
    }),
    ("Hertz–Mindlin with moments", |model, _| {
        model.law.contact.rolling = Some(ROLLING);
    }),
    ("Hertz–Mindlin with adhesion", |model, _| {
        model.law.contact.adhesion = Some(ADHESION);
        model.law.contact.viscosity = Viscosity::None;
    }),
    ("Hertz–Mindlin of three materials", |model, bodies| {
        three_materials(model, bodies);
    }),
];

fn linear(law: &mut Law) {
    law.contact = ContactLaw::default();
    law.stiffness_ratio = 0.3;
}

fn three_materials(model: &mut Model, bodies: &mut Bodies) {
    model.law.materials = vec![SOFTER, STIFFER];
    bodies.material = (0..bodies.len() as u32).map(|id| id % 3).collect();
}

/// Gravity, damping, step, walls, masses and moments of inertia that are not those of the bed.
fn other_constants(model: &mut Model, bodies: &mut Bodies) {
    model.gravity = [1.1, -3.7];
    model.alpha = 0.35;
    model.dt *= 0.8;
    let hair = 1.0e-3 * bodies.radius.iter().copied().fold(f64::MAX, f64::min);
    for wall in &mut model.walls {
        wall.place += hair;
    }
    // Another order, one more before the right wall, and a ceiling on the highest grain.
    model.walls.reverse();
    let right = model
        .walls
        .iter()
        .find(|wall| wall.axis == Axis::X && wall.place > hair);
    let place = right.map_or(0.0, |wall| wall.place) - hair;
    model.walls.push(Wall {
        axis: Axis::X,
        place,
    });
    let tops = bodies
        .z
        .iter()
        .zip(&bodies.radius)
        .map(|(z, radius)| z + radius);
    let place = tops.fold(0.0, f64::max) - hair;
    model.walls.push(Wall {
        axis: Axis::Z,
        place,
    });
    let masses = bodies.mass.iter_mut().enumerate();
    masses.for_each(|(id, mass)| *mass *= 1.0 + 0.3 * (2.3 * id as f64).sin());
    bodies
        .inertia
        .iter_mut()
        .for_each(|inertia| *inertia *= 0.8);
}

/// What an engine is judged by in space: the bed's states under every law, and excerpts of scenes.
pub fn reference() -> Result<Reference, NativeError> {
    let scene = scene();
    let poured = poured(&scene)?;
    Ok(Reference::of(
        states(&scene, &poured),
        excerpts(&scene, &poured)?,
    ))
}

fn states(scene: &Scene, poured: &Poured) -> Vec<State> {
    let mut all = Vec::new();
    for (at, (law, change)) in LAWS.into_iter().enumerate() {
        for (start, bodies, punch) in poured {
            // Of most laws two states say what there is to say.
            let tells = [Start::Pouring, Start::UnderPunch].contains(start);
            if !tells && ![0, DASHPOTS].contains(&at) {
                continue;
            }
            let (mut model, mut bodies) = (Model::of(scene), spinning(bodies, SPIN));
            change(&mut model, &mut bodies);
            let key = format!("space-{at}-{}", start.key());
            all.push(State {
                probed: at == HERTZ && tells,
                drawn: false,
                ..state(law, *start, key, model, bodies, *punch)
            });
        }
    }
    all.extend((1..=DRAWN).filter_map(|number| drawn_state(scene, poured, number)));
    all
}

/// Pouring, and a bed whose pouring ends and that is loaded: with the scene's law, and with another one in loading.
fn excerpts(scene: &Scene, poured: &Poured) -> Result<Vec<Excerpt>, NativeError> {
    let from = |start: Start| {
        let found = poured.iter().find(|state| state.0 == start);
        let (_, bodies, _) = found.expect("every bed has it");
        grains::task::Start::from(spinning(bodies, SPIN))
    };
    let mut staged = scene.clone();
    staged.loading.material = Some(Material {
        friction_angle: 0.2,
        youngs_modulus: 0.7 * scene.material.youngs_modulus,
        ..scene.material.clone()
    });
    staged.loading.damping = Some(Damping::Cundall { alpha: 0.35 });
    let pouring = from(Start::Pouring);
    let mut excerpts = vec![
        Excerpt::new(
            "pouring of spheres",
            "excerpt-space",
            scene,
            pouring.clone(),
        ),
        Excerpt::into_loading(
            "pouring of spheres, then loading with other constants",
            "excerpt-space-stages",
            &staged,
            pouring,
        ),
    ];
    let rest = grains::task::Start {
        stage: Stage::Load,
        ..from(Start::AtRest)
    };
    let (name, key) = ("loading of spheres to its end", "excerpt-space-end");
    excerpts.extend(Excerpt::to_end(name, key, scene, rest)?);
    Ok(excerpts)
}

fn state(
    law: &str,
    start: Start,
    key: String,
    model: Model,
    mut bodies: Bodies,
    punch: Option<Punch>,
) -> State {
    // Grains that nothing turns have no spins.
    if !model.law.rotates() {
        bodies.do_not_turn();
    }
    State {
        law: law.to_owned(),
        start: start.name().to_owned(),
        key,
        probed: false,
        drawn: true,
        faster: FASTER,
        case: Case {
            name: format!("{law}, {}", start.name()),
            model,
            bodies,
            punch,
            moments: MOMENTS.to_vec(),
        },
    }
}

/// With spins of all sizes about all axes.
fn spinning(bodies: &Bodies, largest: f64) -> Bodies {
    let mut bodies = bodies.clone();
    let columns = [&mut bodies.spin_x, &mut bodies.spin, &mut bodies.spin_z];
    for (axis, column) in columns.into_iter().enumerate() {
        let frequency = 1.7 + 0.6 * axis as f64;
        let spins = column.iter_mut().enumerate();
        spins.for_each(|(id, spin)| *spin = largest * (frequency * id as f64).sin());
    }
    bodies
}

type Poured = Vec<(Start, Bodies, Option<Punch>)>;

fn poured(scene: &Scene) -> Result<Poured, NativeError> {
    let options = native::Options::default();
    let cloud = initial_bodies(scene);
    let after = |steps: u64| -> Result<Snapshot, NativeError> {
        let task = Task::pour(cloud.clone(), steps);
        Ok(native::run(scene, &task, &options, &mut ())?.last)
    };
    let [loose, pouring, rest] = [30, POURING, AT_REST].map(after);
    let (pouring, rest) = (pouring?.bodies, rest?.bodies);
    let punch = native::first_contact_punch(scene, &rest);
    let step = scene.loading.speed * scene.time_step_seconds();
    let pressing = Case {
        name: "pressing".to_owned(),
        model: Model::of(scene),
        bodies: rest.clone(),
        punch: Some(punch),
        moments: vec![(PRESSED * scene.particles.mean_diameter / step) as u64],
    };
    let pressed = native::run_case(&pressing, None)?.pop();
    let mut all = vec![
        (Start::Loose, loose?.bodies, None),
        (Start::Pouring, pouring, None),
        (Start::AtRest, rest, None),
    ];
    all.extend(pressed.map(|moment| (Start::UnderPunch, moment.bodies, moment.punch)));
    Ok(all)
}

/// Fast or slow grains with large or small spins under a law whose every key is drawn: what is right for each value alone may be
/// wrong for two together.
fn drawn_state(scene: &Scene, poured: &Poured, number: u64) -> Option<State> {
    let mut source = Source::new(b"crossgrain: laws drawn in space ", number);
    let source = &mut source;
    let start = [Start::Pouring, Start::UnderPunch][number as usize % 2];
    let (_, bodies, punch) = poured.iter().find(|state| state.0 == start)?;
    let mut bodies = spinning(bodies, drawn(source, [0.1 * SPIN, SPIN, 5.0 * SPIN]));
    let faster = drawn(source, [1.0, FASTER]);
    let velocities = [&mut bodies.vx, &mut bodies.vy, &mut bodies.vz];
    let all = velocities.into_iter().flatten();
    all.for_each(|velocity| *velocity *= faster);
    let mut model = Model::of(scene);
    model.gravity = drawn(source, [[0.0, -1.62], [0.0, -9.81], [2.0, -9.0]]);
    model.alpha = drawn(source, [0.0, 0.2, 0.6]);
    if drawn(source, [false, false, true]) {
        three_materials(&mut model, &mut bodies);
    }
    let aside = [None, None, Some(0.0), Some(0.3), Some(1.1)];
    let law = &mut model.law;
    law.modulus *= drawn(source, [0.5, 1.0]);
    law.friction_angle = drawn(source, ANGLES);
    law.wall_friction_angle = drawn(source, aside);
    law.punch_friction_angle = drawn(source, aside);
    law.stiffness_ratio = drawn(source, RATIOS);
    law.poissons_ratio = Some(drawn(source, [0.0, 0.3, 0.45]));
    law.contact = drawn_contact(source);
    let (law, key) = (
        format!("drawn law {number} in space"),
        format!("space-drawn-{number}"),
    );
    Some(state(&law, start, key, model, bodies, *punch))
}

fn drawn_contact(source: &mut Source) -> ContactLaw {
    let tension = drawn(source, [Tension::Clipped, Tension::Unclipped]);
    let e_n = drawn(source, RESTITUTIONS);
    let restitution = Viscosity::Restitution { e_n, tension };
    let free = [Rotation::Free, Rotation::Free, Rotation::Blocked];
    let slip = [
        SlipVelocity::RatchetingCorrected,
        SlipVelocity::ContactPoint,
    ];
    let arms = [TorqueArms::HalfOverlap, TorqueArms::ContactPoint];
    let new = [NewContactSlip::WholeStep, NewContactSlip::SinceTouch];
    let mut contact = ContactLaw {
        rotation: drawn(source, free),
        slip_velocity: drawn(source, slip),
        torque_arms: drawn(source, arms),
        new_contact_slip: drawn(source, new),
        springs: drawn(
            source,
            [
                Springs::HertzMindlin,
                Springs::HertzMindlin,
                Springs::Linear,
            ],
        ),
        ..ContactLaw::default()
    };
    let rolling = Rolling {
        limit: drawn(source, [None, ROLLING.limit]),
        ..ROLLING
    };
    contact.rolling = drawn(source, [None, Some(rolling)]);
    if contact.springs == Springs::Linear {
        let dashpot = Viscosity::Dashpot { c_n: 1.5, tension };
        contact.viscosity = drawn(source, [Viscosity::None, dashpot, restitution]);
        return contact;
    }
    let ratio = Viscosity::Ratio {
        ratio: 0.2,
        tension,
    };
    contact.viscosity = drawn(source, [Viscosity::None, restitution, ratio]);
    contact.tangential_viscosity = drawn(source, [None, Some(0.5)]);
    contact.adhesion = drawn(source, [None, None, Some(ADHESION)]);
    contact
}
