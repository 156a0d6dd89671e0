//! Small scenes in equilibrium whose largest stable step has a closed form.

use std::f64::consts::PI;

use crate::suite::build::{self, Grain};
use grains::case::Case;
use grains::model::{Axis, Law, Model};
use grains::scene::{Tension, Viscosity};

/// Radius of the ordinary grain, m.
const RADIUS: f64 = 0.005;
/// kg/m³.
const DENSITY: f64 = 2600.0;
/// Pa.
const MODULUS: f64 = 1.0e7;
/// Overlap over radius, where it is chosen.
const SQUEEZED: f64 = 1.0e-4;

/// A scene of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapScene {
    /// A short name, in kebab-case.
    pub name: String,
    /// What it is, in a line.
    pub title: String,
    /// In equilibrium, at rest.
    pub case: Case,
    /// Along which axes it is disturbed. A row of grains under load would buckle sideways.
    pub axes: [bool; 2],
    /// The largest stable step without damping, if it has a closed form.
    pub closed: Option<ClosedForm>,
    /// What a reader should know of it.
    pub remark: String,
}

/// A largest stable step by a formula.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ClosedForm {
    /// s.
    pub dt: f64,
    /// The formula.
    pub formula: String,
    /// How far the scene may be from it, relative: of the pre-stress, and of what the formula leaves out.
    pub tolerance: f64,
}

/// All small scenes, from the simplest up.
pub fn small() -> Vec<MapScene> {
    let mut scenes = vec![
        one_contact(),
        on_a_wall(),
        sticking_on_a_wall(),
        chain(10, 0.0),
        unequal(),
        punch_corner(),
    ];
    scenes.extend([0.5, 0.99, 1.01, 3.0].map(dashpot));
    scenes.push(chain(10, 0.5));
    scenes
}

fn grain(position: [f64; 2]) -> Grain {
    Grain::disc(position, RADIUS, DENSITY)
}

/// k of a grain of the ordinary radius at a wall or another such grain, N/m.
fn stiffness() -> f64 {
    MODULUS * RADIUS
}

fn scene(name: &str, title: &str, case: Case, closed: ClosedForm) -> MapScene {
    MapScene {
        name: name.to_owned(),
        title: title.to_owned(),
        case,
        axes: [true; 2],
        closed: Some(closed),
        remark: String::new(),
    }
}

fn formula(dt: f64, formula: &str) -> ClosedForm {
    ClosedForm {
        dt,
        formula: formula.to_owned(),
        tolerance: 1.0e-3,
    }
}

/// Gravity that presses a grain of this mass into its support by [`SQUEEZED`], m/s².
fn gravity(mass: f64) -> f64 {
    stiffness() * SQUEEZED * RADIUS / mass
}

/// Largest of the two eigenvalues of [[a, b], [b, c]].
fn larger(a: f64, b: f64, c: f64) -> f64 {
    let half = 0.5 * (a - c);
    0.5 * (a + c) + (half * half + b * b).sqrt()
}

fn one_contact() -> MapScene {
    let ratio = 100.0;
    let light = grain([0.0, 0.0]);
    let mass = light.mass;
    // The heavy one is pressed into the floor by both.
    let floor = (ratio + 1.0) * SQUEEZED * RADIUS;
    let below = Grain {
        mass: ratio * mass,
        ..grain([0.0, RADIUS - floor])
    };
    let above = grain([0.0, below.position[1] + 2.0 * RADIUS - SQUEEZED * RADIUS]);
    let model = Model {
        gravity: [0.0, -gravity(mass)],
        walls: vec![build::wall(Axis::Z, 0.0)],
        ..build::model(build::springs(MODULUS), 1.0e-6)
    };
    let of = stiffness() / mass;
    let omega = larger(2.0 * of / ratio, of / ratio.sqrt(), of).sqrt();
    MapScene {
        axes: [false, true],
        remark: "two free grains cannot be held in contact, so the lower one is a hundred times heavier and \
                 rests on the floor"
            .to_owned(),
        ..scene(
            "one-contact",
            "a grain on a heavy one",
            build::case("one contact", model, &[below, above], vec![0]),
            formula(
                2.0 / omega,
                "2/ω, ω² the larger root of (2k/M − ω²)(k/m − ω²) = k²/(mM), M = 100 m",
            ),
        )
    }
}

/// A grain on the floor under gravity.
fn resting(law: Law) -> Case {
    let resting = grain([0.0, RADIUS - SQUEEZED * RADIUS]);
    let model = Model {
        gravity: [0.0, -gravity(resting.mass)],
        walls: vec![build::wall(Axis::Z, 0.0)],
        ..build::model(law, 1.0e-6)
    };
    build::case("a grain on a wall", model, &[resting], vec![0])
}

fn on_a_wall() -> MapScene {
    let case = resting(build::springs(MODULUS));
    let omega = (stiffness() / case.bodies.mass[0]).sqrt();
    scene(
        "grain-on-wall",
        "a grain on a wall",
        case,
        formula(2.0 / omega, "2√(m/k)"),
    )
}

/// A grain that sticks to the wall sways and turns: the two springs' k_s (1/m + R²/I).
fn sticking_on_a_wall() -> MapScene {
    let case = resting(build::friction(MODULUS, 1.0, 0.5));
    let of = &case.bodies;
    let omega = (stiffness() * (1.0 / of.mass[0] + RADIUS * RADIUS / of.inertia[0])).sqrt();
    scene(
        "sticking-grain",
        "a grain on a wall that sticks to it, free to turn, k_s = k_n",
        case,
        formula(2.0 / omega, "2/√(k_s(1/m + R²/I)) = 2√(m/3k)"),
    )
}

/// Grains in a row between two walls; modes 4k/m sin²(jπ/2(N+1)).
fn chain(count: usize, ratio: f64) -> MapScene {
    let overlap = SQUEEZED * RADIUS;
    let pitch = 2.0 * RADIUS - overlap;
    let grains: Vec<Grain> = (0..count)
        .map(|at| grain([RADIUS - overlap + pitch * at as f64, 0.0]))
        .collect();
    let end = grains[count - 1].position[0] + RADIUS - overlap;
    let (mass, k) = (grains[0].mass, stiffness());
    let share = (0.5 * PI * count as f64 / (count as f64 + 1.0)).sin();
    let omega = 2.0 * share * (k / mass).sqrt();
    // ζ of this mode: C is c/k times K.
    let c_n = 2.0 * ratio * k / omega;
    let law = if ratio > 0.0 {
        build::with_viscosity(
            build::springs(MODULUS),
            Viscosity::Dashpot {
                c_n,
                tension: Tension::Clipped,
            },
        )
    } else {
        build::springs(MODULUS)
    };
    let model = Model {
        walls: vec![build::wall(Axis::X, 0.0), build::wall(Axis::X, end)],
        ..build::model(law, 1.0e-6)
    };
    let case = build::case("a chain", model, &grains, vec![0]);
    let damped = 2.0 / omega * ((1.0 + ratio * ratio).sqrt() - ratio);
    let (name, title, words) = if ratio > 0.0 {
        (
            "chain-with-dashpots",
            format!(
                "{count} grains in a row between walls, dashpots of ζ = {ratio} in the fastest mode"
            ),
            "(2/ω)(√(1+ζ²) − ζ), ω = 2√(k/m) sin(Nπ/(2N+2))",
        )
    } else {
        (
            "chain",
            format!("{count} grains in a row between walls"),
            "2/ω, ω = 2√(k/m) sin(Nπ/(2N+2))",
        )
    };
    MapScene {
        axes: [true, false],
        ..scene(name, &title, case, formula(damped, words))
    }
}

/// A small grain between two large ones between two walls: the small one moves against both, or the large ones
/// against each other.
fn unequal() -> MapScene {
    let ratio = 10.0;
    let small = RADIUS / ratio;
    let outer = stiffness();
    let inner = 2.0 * MODULUS * RADIUS * small / (RADIUS + small);
    // The same force in all four contacts.
    let force = inner * SQUEEZED * small;
    let (at_wall, between) = (force / outer, force / inner);
    let first = grain([RADIUS - at_wall, 0.0]);
    let middle = Grain::disc(
        [first.position[0] + RADIUS + small - between, 0.0],
        small,
        DENSITY,
    );
    let last = grain([middle.position[0] + RADIUS + small - between, 0.0]);
    let end = last.position[0] + RADIUS - at_wall;
    let model = Model {
        walls: vec![build::wall(Axis::X, 0.0), build::wall(Axis::X, end)],
        ..build::model(build::springs(MODULUS), 1.0e-6)
    };
    let (large, light) = (first.mass, middle.mass);
    let square = larger(
        (outer + inner) / large,
        (2.0f64).sqrt() * inner / (large * light).sqrt(),
        2.0 * inner / light,
    );
    MapScene {
        axes: [true, false],
        ..scene(
            "unequal-sizes",
            "a grain between two that are ten times larger, between walls",
            build::case("unequal sizes", model, &[first, middle, last], vec![0]),
            formula(
                2.0 / square.sqrt(),
                "2/ω, ω² the larger root of ((K+k)/M − ω²)(2k/m − ω²) = 2k²/(mM)",
            ),
        )
    }
}

/// A grain in the corner of floor and wall, held there by the corner of the punch.
fn punch_corner() -> MapScene {
    let overlap = SQUEEZED * RADIUS;
    let half_extents = [2.0 * RADIUS, 2.0 * RADIUS];
    // Both sides bear F/√2 of the corner's F.
    let side = RADIUS - overlap / (2.0f64).sqrt();
    let centre = [side, side];
    let to_corner = (RADIUS - overlap) / (2.0f64).sqrt();
    let corner = [centre[0] + to_corner, centre[1] + to_corner];
    let model = Model {
        walls: vec![build::wall(Axis::X, 0.0), build::wall(Axis::Z, 0.0)],
        ..build::model(build::springs(MODULUS), 1.0e-6)
    };
    let punch = build::punch(corner[0] + half_extents[0], corner[1], half_extents, 0.0);
    let held = grain(centre);
    let omega = (2.0 * stiffness() / held.mass).sqrt();
    let mut case = build::case("a punch corner", model, &[held], vec![0]);
    case.punch = Some(punch);
    scene(
        "punch-corner",
        "a grain in a corner of the box, held by the corner of the punch",
        case,
        formula(2.0 / omega, "2√(m/2k)"),
    )
}

/// A grain on a wall with a dashpot of this damping ratio.
fn dashpot(ratio: f64) -> MapScene {
    let undamped = resting(build::springs(MODULUS));
    let mass = undamped.bodies.mass[0];
    let omega = (stiffness() / mass).sqrt();
    let law = build::with_viscosity(
        build::springs(MODULUS),
        Viscosity::Dashpot {
            c_n: 2.0 * ratio * mass * omega,
            tension: Tension::Clipped,
        },
    );
    let mut case = resting(law);
    case.name = format!("a dashpot of {ratio} of critical");
    let side = if ratio < 1.0 { "below" } else { "past" };
    scene(
        &format!("dashpot-{ratio}"),
        &format!("a grain on a wall with a dashpot {side} critical, ζ = {ratio}"),
        case,
        formula(
            2.0 / omega * ((1.0 + ratio * ratio).sqrt() - ratio),
            "(2/ω)(√(1+ζ²) − ζ)",
        ),
    )
}
