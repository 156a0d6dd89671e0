//! The states in space that an engine starts from when it is judged: one bed of spheres, poured and pressed, under laws of springs,
//! friction, dashpots, moments, adhesion and several materials, each with constants of its own, and under laws whose every key is
//! drawn.

use std::f64::consts::PI;

use evidence::random::Source;
use grains::model::{Axis, Law, Model, Solid};
use grains::native::NativeError;
use grains::obstacle::{Obstacle, Surface};
use grains::scene::{
    AdhesionLaw, ContactLaw, Rolling, Scene, SlipVelocity, Springs, Tension, TorqueArms, Viscosity,
    parse_scene,
};
use grains::tables::{Bodies, Punch};
use grains::task::Case;
use grains::vector::times;

use crate::drawn::{
    ADHESION, ANGLES, COMBINATIONS, RATIOS, ROLLING, contact_in_space, drawn, spin,
};
use crate::invariance::GRAINS;
use crate::judge::Reference;
use crate::starts::{Bed, MOMENTS, Start, State, highest, other_constants, other_masses};

/// How far the punch has sunk at least, over the mean radius; at most it is twice as far.
const PRESSED: f64 = 1.5;
/// The largest speed of spins that grains are given, rad/s.
const SPIN: f64 = 40.0;
/// States of drawn laws.
const DRAWN: u64 = 48;
/// More, of which some have adhesion of DMT or JKR.
const ADHESIVE: u64 = 24;
/// And of these with obstacles.
const AMONG_OBSTACLES: u64 = 24;
/// How many times as fast grains are in some states.
const FASTER: f64 = 3.0;
/// What grains of other materials are made of.
const SOFTER: Solid = Solid {
    modulus: 0.8e7,
    stiffness_ratio: 0.7,
    poissons_ratio: 0.2,
    friction_angle: 0.3,
};
const BRITTLE: Solid = Solid {
    modulus: 2.5e7,
    stiffness_ratio: 0.5,
    poissons_ratio: 0.0,
    friction_angle: 0.1,
};
const STIFFER: Solid = Solid {
    modulus: 5.0e7,
    stiffness_ratio: 0.25,
    poissons_ratio: 0.4,
    friction_angle: 0.8,
};
/// The scene whose bed it is.
pub fn scene() -> Scene {
    parse_scene(include_str!("spheres.json")).expect("it is a scene")
}

/// A law that engines are asked for, by what it changes of the scene's: its model, and its grains where they are of several materials.
type Change = fn(&mut Model, &mut Bodies);

/// Where precision is measured, and a law of which all states are looked at.
const HERTZ: usize = 3;
const DASHPOTS: usize = 6;

const LAWS: [(&str, Change); 18] = [
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
            model.law.contact.viscosity = Viscosity::dashpot(2.0, Tension::Clipped);
        },
    ),
    ("Hertz's springs", |model, _| {
        model.law.friction_angle = 0.0;
        model.law.contact.viscosity = Viscosity::None;
    }),
    ("Hertz's springs with other constants", |model, bodies| {
        model.law.friction_angle = 0.0;
        model.law.contact.viscosity = Viscosity::None;
        other_constants(model, bodies, 1.0e-3);
        other_masses(bodies);
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
        other_constants(model, bodies, 1.0e-3);
        other_masses(bodies);
    }),
    ("Hertz–Mindlin with moments", |model, _| {
        model.law.contact.rolling = Some(ROLLING);
    }),
    ("Hertz–Mindlin with a constant torque", |model, _| {
        model.law.contact.rolling = Some(Rolling {
            bending_stiffness: None,
            twisting_stiffness: 0.0,
            ..ROLLING
        });
    }),
    ("Hertz–Mindlin with adhesion", |model, _| {
        model.law.contact.adhesion = Some(ADHESION);
        model.law.contact.viscosity = Viscosity::None;
    }),
    ("Hertz–Mindlin of four materials", |model, bodies| {
        materials(model, bodies, &[SOFTER, STIFFER, BRITTLE]);
    }),
    ("Hertz–Mindlin on planes", |model, _| {
        let normal = [0.6 * TILT, 0.8 * TILT, (1.0 - TILT * TILT).sqrt()];
        let point = [0.0, 0.0, hair(model)];
        floor_of(model, vec![Surface::Plane { point, normal }]);
    }),
    ("Hertz–Mindlin on triangles", |model, _| {
        let triangles = uneven(model);
        floor_of(model, triangles);
    }),
    ("Hertz–Mindlin on boxes", |model, _| {
        let [width, depth] = extent(model);
        let top = hair(model);
        let box_at = |centre: [f64; 2], angle: f64| Surface::Box {
            centre: [centre[0] * width, centre[1] * depth, top - 0.5 * width],
            half_extents: [0.3 * width, 0.2 * depth, 0.5 * width],
            orientation: [(0.5 * angle).cos(), 0.0, 0.0, (0.5 * angle).sin()],
        };
        floor_of(
            model,
            vec![box_at([0.35, 0.3], 0.0), box_at([0.7, 0.75], 0.5)],
        );
        set_in_motion(model);
    }),
    ("Hertz–Mindlin with adhesion of DMT", |model, _| {
        adhesive(&mut model.law.contact, AdhesionLaw::Dmt, ADHESION);
    }),
    ("Hertz–Mindlin with adhesion of JKR", |model, _| {
        adhesive(&mut model.law.contact, AdhesionLaw::Jkr, ADHESION);
        model.law.contact.viscosity = Viscosity::None;
    }),
    (
        "Hertz with adhesion of JKR, four materials",
        |model, bodies| {
            materials(model, bodies, &[SOFTER, STIFFER, BRITTLE]);
            model
                .law
                .materials
                .iter_mut()
                .for_each(|material| material.friction_angle = 0.0);
            model.law.friction_angle = 0.0;
            adhesive(&mut model.law.contact, AdhesionLaw::Jkr, 3.0 * ADHESION);
        },
    ),
];

/// How far obstacles stand into the grains that lie on the floor, over the width of the box; and how much a plane is tilted.
const HAIR: f64 = 1.0e-4;
const TILT: f64 = 1.0e-3;
/// Triangles along a side of the box.
const ALONG: usize = 6;

/// Inner width and depth of the box, m.
fn extent(model: &Model) -> [f64; 2] {
    [Axis::X, Axis::Y].map(|axis| {
        let along = model.walls.iter().filter(|wall| wall.axis == axis);
        along.fold(0.0, |far, wall| wall.place.max(far))
    })
}

fn hair(model: &Model) -> f64 {
    HAIR * extent(model)[0]
}

/// With obstacles besides the floor, which the grains on it touch too.
fn floor_of(model: &mut Model, shapes: Vec<Surface>) {
    model.obstacles = shapes.into_iter().map(Obstacle::still).collect();
}

/// The floor of a scene, which stands still.
pub(crate) fn obstacles_of_scene(scene: &Scene, bodies: &Bodies, number: u64) -> Vec<Obstacle> {
    let mut model = Model::of(scene);
    obstacles(&mut model, bodies, STILL + number % 3);
    model.obstacles
}

/// From this number on obstacles stand still.
const STILL: u64 = 6;

/// Planes that are touched from either side, triangles, or boxes of which edges and a corner are touched, at rest or in motion.
fn obstacles(model: &mut Model, bodies: &Bodies, number: u64) {
    let ([width, depth], hair) = (extent(model), hair(model));
    let shapes = match number % 3 {
        0 => {
            let top = highest(bodies);
            let plane = |height: f64| Surface::Plane {
                point: [0.0, 0.0, height],
                normal: [0.0, TILT, (1.0 - TILT * TILT).sqrt()],
            };
            vec![plane(hair), plane(top - hair)]
        }
        1 => uneven(model),
        _ => {
            // Turned by an eighth about y, an edge is the highest; about x too, so far that the diagonal stands up, a corner.
            let size = 0.02 * width;
            let edge = [(0.125 * PI).cos(), 0.0, (0.125 * PI).sin(), 0.0];
            let ridges = [0.2, 0.35, 0.5, 0.65, 0.8].map(|share| Surface::Box {
                centre: [
                    share * width,
                    0.5 * depth,
                    3.0 * hair - 2.0f64.sqrt() * size,
                ],
                half_extents: [size, 0.6 * depth, size],
                orientation: edge,
            });
            // On the largest grain at the floor.
            let lowest = (0..bodies.len()).min_by(|a, b| bodies.z[*a].total_cmp(&bodies.z[*b]));
            let lowest = lowest.unwrap_or(0);
            let bottom = bodies.z[lowest] - bodies.radius[lowest];
            let (half, turn) = ((2.0f64 / 3.0).sqrt().acos(), 0.125 * PI);
            let corner = Surface::Box {
                centre: [
                    bodies.x[lowest],
                    bodies.y[lowest],
                    bottom + 3.0 * hair - 3.0f64.sqrt() * size,
                ],
                half_extents: [size; 3],
                orientation: [
                    (0.5 * half).cos() * turn.cos(),
                    (0.5 * half).sin() * turn.cos(),
                    (0.5 * half).cos() * turn.sin(),
                    (0.5 * half).sin() * turn.sin(),
                ],
            };
            ridges.into_iter().chain([corner]).collect()
        }
    };
    floor_of(model, shapes);
    // Not in step with what is poured and what is under the punch.
    if (number / STILL).is_multiple_of(2) {
        set_in_motion(model);
    }
}

fn set_in_motion(model: &mut Model) {
    for obstacle in &mut model.obstacles {
        obstacle.velocity = [0.03, -0.02, 0.01];
        // A plane turns about its normal alone.
        obstacle.spin = match obstacle.shape {
            Surface::Plane { normal, .. } => times(0.5, normal),
            _ => [0.3, -0.2, 0.4],
        };
    }
}

/// Triangles up and down by a hair, so that faces, edges and corners are touched.
fn uneven(model: &Model) -> Vec<Surface> {
    let [width, depth] = extent(model);
    let vertex = |column: usize, row: usize| {
        let [x, y] = [column, row].map(|at| at as f64 / ALONG as f64);
        let height = hair(model) * (2.0 + ((5 * column + 3 * row) as f64).sin());
        [x * width, y * depth, height]
    };
    let cell = |at: usize| {
        let (column, row) = (at % ALONG, at / ALONG);
        let corner = |right: usize, back: usize| vertex(column + right, row + back);
        let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        [[a, b, c], [d, b, c]].map(|vertices| Surface::Triangle { vertices })
    };
    (0..ALONG * ALONG).flat_map(cell).collect()
}

pub(crate) fn adhesive(contact: &mut ContactLaw, law: AdhesionLaw, energy: f64) {
    (contact.adhesion, contact.adhesion_law) = (Some(energy), law);
}

fn linear(law: &mut Law) {
    law.contact = ContactLaw::default();
    law.stiffness_ratio = 0.3;
}

fn materials(model: &mut Model, bodies: &mut Bodies, others: &[Solid]) {
    model.law.materials = others.to_vec();
    let kinds = others.len() as u32 + 1;
    bodies.material = (0..bodies.len() as u32).map(|id| id % kinds).collect();
}

/// What an engine is judged by in space: the bed's states under every law, and excerpts of scenes.
pub fn reference() -> Result<Reference, NativeError> {
    let bed = Bed::of(scene(), PRESSED)?;
    Ok(Reference::of(states(&bed), bed.excerpts()?))
}

/// The bed's states under every law, of fewer grains: each is run many times where an engine is held against itself.
pub fn for_itself() -> Result<Vec<State>, NativeError> {
    let mut scene = scene();
    scene.particles.count = GRAINS;
    // As high as the whole bed.
    scene.container.width *= 0.75;
    scene.container.depth = scene.container.depth.map(|depth| 0.75 * depth);
    Ok(states(&Bed::of(scene, PRESSED)?))
}

fn states(bed: &Bed) -> Vec<State> {
    let mut all = Vec::new();
    for (at, (law, change)) in LAWS.into_iter().enumerate() {
        for (start, bodies, punch) in &bed.states {
            // Of most laws two states say what there is to say.
            let tells = [Start::Pouring, Start::UnderPunch].contains(start);
            if !tells && ![0, DASHPOTS].contains(&at) {
                continue;
            }
            let (mut model, mut bodies) = (Model::of(&bed.scene), bodies.clone());
            spin(&mut bodies, SPIN);
            change(&mut model, &mut bodies);
            let key = format!("space-{at}-{}", start.key());
            all.push(State {
                probed: at == HERTZ && tells,
                drawn: false,
                ..state(law, *start, key, (model, bodies, *punch))
            });
        }
    }
    all.extend((1..=DRAWN).filter_map(|number| drawn_state(bed, number)));
    // Hertz's among a few more, with either of the other laws of adhesion.
    let more =
        (1..=ADHESIVE).filter_map(|number| Some((number, drawn_state(bed, DRAWN + number)?)));
    let hertz =
        more.filter(|(_, state)| state.case.model.law.contact.springs == Springs::HertzMindlin);
    // Obstacles under every combination of springs and dashpots; a constant dashpot beside Hertz's springs is asked for here too.
    let first = DRAWN + ADHESIVE;
    all.extend((1..=AMONG_OBSTACLES).filter_map(|number| {
        let mut state = drawn_state(bed, first + number)?;
        obstacles(&mut state.case.model, &state.case.bodies, number);
        let contact = &mut state.case.model.law.contact;
        let tension = Tension::Clipped;
        match (contact.springs, number % 4) {
            (Springs::HertzMindlin, 0) => {
                contact.viscosity = Viscosity::Dashpot { c_n: 0.3, tension };
            }
            (Springs::HertzMindlin, 1) => adhesive(contact, AdhesionLaw::Jkr, ADHESION),
            (Springs::HertzMindlin, 2) => adhesive(contact, AdhesionLaw::Dmt, ADHESION),
            (Springs::HertzMindlin, _) => adhesive(contact, AdhesionLaw::Pull, ADHESION),
            (Springs::Linear, 0 | 1) => {
                contact.viscosity = Viscosity::Ratio {
                    ratio: 0.2,
                    tension,
                };
            }
            _ => {}
        }
        Some(state)
    }));
    all.extend(hertz.map(|(number, mut state)| {
        let law = [AdhesionLaw::Jkr, AdhesionLaw::Dmt][number as usize / 2 % 2];
        let energy = ADHESION * [0.1, 1.0, 3.0][number as usize % 3];
        adhesive(&mut state.case.model.law.contact, law, energy);
        state
    }));
    all
}

fn state(
    law: &str,
    start: Start,
    key: String,
    (model, mut bodies, punch): (Model, Bodies, Option<Punch>),
) -> State {
    // Grains that nothing turns have no spins.
    if !model.law.rotates() {
        bodies.do_not_turn();
    }
    let mut case = Case::new("", model, bodies, MOMENTS.to_vec());
    case.punch = punch;
    State {
        faster: FASTER,
        ..State::drawn(law, start.name(), key, case)
    }
}

/// Fast or slow grains with large or small spins under a law whose every key is drawn: what is right for each value alone may be
/// wrong for two together.
fn drawn_state(bed: &Bed, number: u64) -> Option<State> {
    let mut source = Source::new(b"crossgrain: laws drawn in space ", number);
    let source = &mut source;
    let start = [Start::Pouring, Start::UnderPunch][number as usize % 2];
    let (_, bodies, punch) = bed.state(start)?;
    let mut bodies = bodies.clone();
    spin(&mut bodies, drawn(source, [0.1 * SPIN, SPIN, 5.0 * SPIN]));
    let faster = drawn(source, [1.0, FASTER]);
    let velocities = [&mut bodies.vx, &mut bodies.vy, &mut bodies.vz];
    let all = velocities.into_iter().flatten();
    all.for_each(|velocity| *velocity *= faster);
    let mut model = Model::of(&bed.scene);
    model.gravity = drawn(source, [[0.0, -1.62], [0.0, -9.81], [2.0, -9.0]]);
    model.alpha = drawn(source, [0.0, 0.2, 0.6, 0.95]);
    let others: [&[Solid]; 4] = [&[], &[], &[SOFTER], &[SOFTER, STIFFER, BRITTLE]];
    materials(&mut model, &mut bodies, drawn(source, others));
    let aside = [None, None, Some(0.0), Some(0.3), Some(1.1)];
    let law = &mut model.law;
    let stiffer: f64 = drawn(source, [0.2, 1.0, 10.0]);
    law.modulus *= stiffer;
    model.dt /= stiffer.max(1.0).sqrt();
    law.friction_angle = drawn(source, ANGLES);
    law.wall_friction_angle = drawn(source, aside);
    law.punch_friction_angle = drawn(source, aside);
    law.stiffness_ratio = drawn(source, RATIOS);
    law.poissons_ratio = Some(drawn(source, [0.0, 0.3, 0.49]));
    // Of each combination of springs and dashpots as many pour as are under the punch.
    law.contact = contact_in_space(source, number as usize / 2 % COMBINATIONS);
    let (law, key) = (
        format!("drawn law {number} in space"),
        format!("space-drawn-{number}"),
    );
    Some(state(&law, start, key, (model, bodies, *punch)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every law of adhesion on every kind of obstacle, pressed and poured, still and in motion; and both in scenes.
    #[test]
    fn what_an_engine_may_have_is_asked_for_together() {
        let bed = Bed::of(scene(), PRESSED).expect("a bed");
        let kind = |shape: &Surface| match shape {
            Surface::Plane { .. } => 0,
            Surface::Triangle { .. } => 1,
            Surface::Box { .. } => 2,
        };
        let mut together = std::collections::BTreeSet::new();
        for state in states(&bed) {
            let (model, punch) = (&state.case.model, state.case.punch);
            let contact = &model.law.contact;
            for obstacle in &model.obstacles {
                let kind = kind(&obstacle.shape);
                let moves = obstacle.velocity != [0.0; 3];
                together.insert(format!(
                    "{kind} moves: {moves}, pressed: {}",
                    punch.is_some()
                ));
                if contact.adhesion.is_some() {
                    together.insert(format!("{kind} {:?}", contact.adhesion_law));
                }
            }
            if matches!(contact.viscosity, Viscosity::Ratio { .. }) {
                together.insert(format!("ratio {:?}", contact.springs));
            }
        }
        for excerpt in bed.excerpts().expect("runs") {
            let scene = &excerpt.scene;
            let kinds = scene.obstacles.iter().map(|obstacle| kind(&obstacle.shape));
            together.extend(kinds.map(|kind| format!("scene {kind}")));
            if scene.contact.adhesion.is_some() {
                together.insert(format!("scene {:?}", scene.contact.adhesion_law));
            }
        }
        // 12 of motion, 9 of adhesion, 2 of the ratio, 3 and 3 in scenes.
        assert_eq!(together.len(), 12 + 9 + 2 + 3 + 3, "{together:#?}");
    }

    #[test]
    fn rules_of_settling_and_of_loading_are_judged_in_space_too() {
        let bed = Bed::of(scene(), PRESSED).expect("a bed");
        let starts: Vec<_> = bed.states.iter().map(|(start, ..)| *start).collect();
        let all = [
            Start::Loose,
            Start::Pouring,
            Start::AtRest,
            Start::UnderPunch,
        ];
        assert_eq!(starts, all);
        let excerpts = bed.excerpts().expect("runs");
        let has = |key: &str| {
            let key = format!("excerpt-{key}-in-space");
            assert!(excerpts.iter().any(|excerpt| excerpt.key == key), "{key}");
        };
        for key in [
            "settled", "spins", "to-end", "standing", "stages", "drawn-1",
        ] {
            has(key);
        }
    }
}
