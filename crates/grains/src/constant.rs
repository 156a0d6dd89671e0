//! The constants of a run that may be a little wrong: deliberate faults, fits of other engines and limits of detection are all
//! made of this one list.

use std::fmt;

use crate::model::{Axis, Model, Wall};
use crate::native::state::Constants;
use crate::scene::{Rolling, Springs, Viscosity};
use crate::tables::{Bodies, Body, Punch};
use crate::task::Case;
use crate::vector::times;

/// What a run computes with.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Given {
    pub constants: Constants,
    pub bodies: Bodies,
    pub punch: Option<Punch>,
}

impl Given {
    pub fn new(model: &Model, bodies: &Bodies, punch: Option<Punch>) -> Self {
        Given {
            constants: Constants::new(model, bodies.len() as u32),
            bodies: bodies.clone(),
            punch,
        }
    }
}

/// How a constant's being larger is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// As the factor by which it is larger.
    Factor,
    /// Over |g|: what has no component of its own cannot be multiplied.
    Gravity,
    /// Over the mean radius.
    Radius,
}

struct Row {
    /// As a fault on the command line; empty where it is none.
    fault: &'static str,
    /// Of constants that a fit cannot tell apart the one with the largest number stays.
    kept: i8,
    /// Its symbol, and of what it is; empty of what is a fault alone.
    symbol: &'static str,
    counted: Counted,
    /// Where an engine's author looks for it.
    place: &'static str,
    /// Makes it larger by a share, and leaves all as it is where that has no effect.
    enlarge: fn(&mut Given, f64),
}

const fn fault(fault: &'static str, enlarge: fn(&mut Given, f64)) -> Row {
    Row {
        fault,
        ..constant(0, "", "", enlarge)
    }
}

const fn constant(
    kept: i8,
    symbol: &'static str,
    place: &'static str,
    enlarge: fn(&mut Given, f64),
) -> Row {
    Row {
        fault: "",
        kept,
        symbol,
        counted: Counted::Factor,
        place,
        enlarge,
    }
}

const fn over_radius(kept: i8, symbol: &'static str, enlarge: fn(&mut Given, f64)) -> Row {
    Row {
        counted: Counted::Radius,
        ..constant(kept, symbol, "model.walls", enlarge)
    }
}

/// Tables of faults and of constants have this order.
static ROWS: [Row; 36] = [
    constant(
        16,
        "k_n between grains",
        "k_n = 2·E·R1·R2/(R1 + R2) (Eq. 4)",
        |given, by| stiffen(given, Body::Grain, by),
    ),
    constant(
        12,
        "k_n at walls",
        "k_n at walls: a wall counts as a grain of the same radius",
        |given, by| {
            if !given.constants.walls.is_empty() {
                stiffen(given, Body::Wall, by);
            }
        },
    ),
    constant(
        11,
        "k_n at the punch",
        "k_n at the punch: it counts as a grain of the same radius",
        |given, by| {
            if given.punch.is_some() {
                stiffen(given, Body::Punch, by);
            }
        },
    ),
    // Every k_n; a scene has its punch later.
    fault("stiffness", |given, by| {
        [Body::Grain, Body::Wall, Body::Punch]
            .into_iter()
            .for_each(|body| stiffen(given, body, by));
    }),
    Row {
        fault: "shear-stiffness",
        ..constant(
            13,
            "k_s",
            "k_s = law.stiffness_ratio · k_n",
            |given, by| {
                if given.constants.law.has_friction() {
                    given.constants.tangential_factor *= 1.0 + by;
                }
            },
        )
    },
    // Young's modulus, so k_n and k_s.
    fault("modulus", |given, by| {
        given.constants.law.modulus *= 1.0 + by
    }),
    fault("gravity", |given, by| {
        given
            .constants
            .gravity
            .iter_mut()
            .for_each(|g| *g *= 1.0 + by)
    }),
    fault("density", |given, by| {
        all(&mut given.bodies.mass, by);
        all(&mut given.bodies.inertia, by);
    }),
    constant(10, "tan φ", "the limit |N| tan φ (Eq. 5)", |given, by| {
        angles(given, |angle| (angle.tan() * (1.0 + by)).atan());
    }),
    constant(14, "c_n", "law.contact.viscosity", |given, by| {
        // Of a restitution each pair has a c_n of its own.
        given.constants.damping_ratios[0] *= 1.0 + by;
        if let Viscosity::Dashpot { c_n, .. } = &mut given.constants.law.contact.viscosity {
            *c_n *= 1.0 + by;
        }
    }),
    Row {
        fault: "damping",
        ..constant(15, "α", "model.alpha", |given, by| {
            given.constants.alpha *= 1.0 + by
        })
    },
    fault("friction", |given, by| {
        angles(given, |angle| angle * (1.0 + by))
    }),
    // The damping constant of the dashpots, or the restitution.
    fault("dashpot", |given, by| {
        given
            .constants
            .change_law(|law| match &mut law.contact.viscosity {
                Viscosity::None => {}
                Viscosity::Dashpot { c_n: value, .. }
                | Viscosity::Restitution { e_n: value, .. }
                | Viscosity::Ratio { ratio: value, .. } => {
                    *value *= 1.0 + by;
                }
            });
    }),
    // Of grain 0, at its contacts only.
    fault("radius", |given, by| first(&mut given.bodies.radius, by)),
    Row {
        counted: Counted::Gravity,
        ..constant(8, "g_x", "model.gravity", |given, by| {
            pull(given, Axis::X, by)
        })
    },
    // Over |g| too, of which it has nearly all.
    constant(9, "g_z", "model.gravity", |given, by| {
        pull(given, Axis::Z, by)
    }),
    Row {
        fault: "time-step",
        ..constant(7, "Δt", "model.dt", |given, by| {
            given.constants.dt *= 1.0 + by
        })
    },
    constant(5, "mass", "the masses in initial.csv", |given, by| {
        all(&mut given.bodies.mass, by)
    }),
    constant(
        6,
        "moment of inertia",
        "the moments of inertia in initial.csv",
        |given, by| {
            if given.constants.law.rotates() {
                all(&mut given.bodies.inertia, by);
            }
        },
    ),
    // At contacts.
    constant(4, "radius", "the radii in initial.csv", |given, by| {
        all(&mut given.bodies.radius, by)
    }),
    // Of grain 0.
    fault("inertia", |given, by| first(&mut given.bodies.inertia, by)),
    // The right wall is moved by this share of its place.
    fault("wall", |given, by| {
        right_wall(&mut given.constants, |wall| wall.place *= 1.0 + by)
    }),
    over_radius(0, "place of wall 0", |given, by| shift(given, 0, by)),
    over_radius(1, "place of wall 1", |given, by| shift(given, 1, by)),
    over_radius(2, "place of wall 2", |given, by| shift(given, 2, by)),
    over_radius(-1, "place of wall 3", |given, by| shift(given, 3, by)),
    over_radius(-2, "place of wall 4", |given, by| shift(given, 4, by)),
    // The dashpots along the tangent of Hertz's springs; those of linear ones have c_n.
    Row {
        fault: "tangential-dashpot",
        ..constant(
            -3,
            "c_s",
            "law.contact.tangential_viscosity, and the damping ratio along the tangent",
            |given, by| {
                let has_its_own = given.constants.law.contact.springs == Springs::HertzMindlin;
                if has_its_own && given.constants.law.has_friction() {
                    given.constants.damping_ratios[1] *= 1.0 + by;
                }
            },
        )
    },
    Row {
        fault: "rolling-stiffness",
        ..constant(
            -4,
            "bending stiffness",
            "law.contact.rolling.bending_stiffness",
            |given, by| {
                roll(given, |rolling| {
                    let bending = rolling.bending_stiffness.iter_mut();
                    bending.for_each(|bending| *bending *= 1.0 + by);
                });
            },
        )
    },
    Row {
        fault: "twisting-stiffness",
        ..constant(
            -5,
            "twisting stiffness",
            "law.contact.rolling.twisting_stiffness",
            |given, by| roll(given, |rolling| rolling.twisting_stiffness *= 1.0 + by),
        )
    },
    Row {
        fault: "rolling-limit",
        ..constant(
            -6,
            "η",
            "law.contact.rolling.limit: the largest moment |N| η (R1 + R2)/2",
            |given, by| {
                roll(given, |rolling| {
                    let limit = rolling.limit.iter_mut();
                    limit.for_each(|limit| *limit *= 1.0 + by);
                });
            },
        )
    },
    Row {
        fault: "adhesion",
        ..constant(-7, "γ", "law.contact.adhesion", |given, by| {
            let adhesion = given.constants.law.contact.adhesion.iter_mut();
            adhesion.for_each(|energy| *energy *= 1.0 + by);
        })
    },
    Row {
        fault: "material",
        ..constant(
            -8,
            "E of material 1",
            "law.materials, of which the first is material 1",
            |given, by| {
                let first = given.constants.law.materials.first_mut();
                first
                    .into_iter()
                    .for_each(|solid| solid.modulus *= 1.0 + by);
            },
        )
    },
    constant(
        -9,
        "velocity of obstacles",
        "model.obstacles[].velocity",
        |given, by| {
            let obstacles = given.constants.obstacles.iter_mut();
            obstacles.for_each(|obstacle| obstacle.velocity = times(1.0 + by, obstacle.velocity));
        },
    ),
    constant(
        -10,
        "spin of obstacles",
        "model.obstacles[].spin, rad/s about fixed axes",
        |given, by| {
            let obstacles = given.constants.obstacles.iter_mut();
            obstacles.for_each(|obstacle| obstacle.spin = times(1.0 + by, obstacle.spin));
        },
    ),
    constant(
        3,
        "velocity of the punch",
        "punch.velocity, and when the punch moves: before the forces",
        |given, by| {
            given
                .punch
                .iter_mut()
                .for_each(|punch| punch.velocity *= 1.0 + by)
        },
    ),
];

fn all(column: &mut [f64], by: f64) {
    column.iter_mut().for_each(|value| *value *= 1.0 + by);
}

fn first(column: &mut [f64], by: f64) {
    column
        .iter_mut()
        .take(1)
        .for_each(|value| *value *= 1.0 + by);
}

fn stiffen(given: &mut Given, body: Body, by: f64) {
    given.constants.normal_factors[body as usize] *= 1.0 + by;
}

fn angles(given: &mut Given, change: impl Fn(f64) -> f64) {
    let law = &mut given.constants.law;
    let aside = [&mut law.wall_friction_angle, &mut law.punch_friction_angle];
    let angles = aside.into_iter().flatten();
    let angles = angles.chain([&mut law.friction_angle]);
    let further = law
        .materials
        .iter_mut()
        .map(|solid| &mut solid.friction_angle);
    angles
        .chain(further)
        .for_each(|angle| *angle = change(*angle));
}

fn roll(given: &mut Given, change: impl FnOnce(&mut Rolling)) {
    if let Some(rolling) = &mut given.constants.law.contact.rolling {
        change(rolling);
    }
}

fn pull(given: &mut Given, axis: Axis, by: f64) {
    let gravity = &mut given.constants.gravity;
    let size = gravity[0].hypot(gravity[1]);
    let component = &mut gravity[axis as usize];
    *component += if *component < 0.0 { -by } else { by } * size;
}

fn shift(given: &mut Given, index: usize, by: f64) {
    let radii = &given.bodies.radius;
    let mean = radii.iter().sum::<f64>() / radii.len().max(1) as f64;
    if let Some(wall) = given.constants.walls.get_mut(index) {
        wall.place += by * mean;
    }
}

/// The wall x > 0 with the lowest id; without one, the last wall.
pub(crate) fn right_wall(constants: &mut Constants, change: impl FnOnce(&mut Wall)) {
    let walls = &mut constants.walls;
    let right = |wall: &Wall| wall.axis == Axis::X && wall.place > 0.0;
    let at = walls.iter().position(right).or(walls.len().checked_sub(1));
    if let Some(at) = at {
        change(&mut walls[at]);
    }
}

/// One of the list.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Constant(usize);

impl Constant {
    /// Those that another engine may have otherwise.
    pub fn all() -> impl Iterator<Item = Constant> {
        Constant::where_there_is(|row| row.symbol)
    }

    /// Those that may be deliberate faults.
    pub fn faults() -> impl Iterator<Item = Constant> {
        Constant::where_there_is(|row| row.fault)
    }

    fn where_there_is(name: fn(&Row) -> &str) -> impl Iterator<Item = Constant> {
        let rows = ROWS.iter().enumerate();
        rows.filter(move |(_, row)| !name(row).is_empty())
            .map(|(at, _)| Constant(at))
    }

    /// The one with this symbol.
    pub fn with_symbol(symbol: &str) -> Option<Constant> {
        Constant::all().find(|constant| constant.symbol() == symbol)
    }

    fn row(self) -> &'static Row {
        &ROWS[self.0]
    }

    /// Its symbol, and of what; empty of what is a fault alone.
    pub fn symbol(self) -> &'static str {
        self.row().symbol
    }

    /// Its symbol, or what it is as a fault.
    pub fn name(self) -> &'static str {
        match self.symbol() {
            "" => self.row().fault,
            symbol => symbol,
        }
    }

    /// How its being larger is said.
    pub fn counted(self) -> Counted {
        self.row().counted
    }

    /// Where an engine's author looks for it.
    pub fn place(self) -> &'static str {
        self.row().place
    }

    /// Of constants that a fit cannot tell apart the one with the largest number stays.
    pub fn kept(self) -> i8 {
        self.row().kept
    }

    pub(crate) fn enlarge(self, given: &mut Given, larger: f64) {
        (self.row().enlarge)(given, larger);
    }

    /// Whether it plays a part in this case.
    pub fn is_in(self, case: &Case) -> bool {
        let given = Given::new(&case.model, &case.bodies, case.punch);
        let mut larger = given.clone();
        self.enlarge(&mut larger, 1.0);
        larger != given
    }
}

/// As a fault on the command line; by its symbol where it is none.
impl fmt::Display for Constant {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Row { fault, symbol, .. } = self.row();
        out.write_str(if fault.is_empty() { symbol } else { fault })
    }
}

impl fmt::Debug for Constant {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{self}")
    }
}
