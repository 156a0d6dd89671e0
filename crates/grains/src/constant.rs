//! The constants of a run that may be a little wrong: deliberate faults, fits of other engines and limits of detection are all
//! made of this one list.

use std::fmt;

use crate::model::{Axis, Model, Wall};
use crate::native::state::Constants;
use crate::scene::{Rolling, Springs, Viscosity};
use crate::tables::{Bodies, Body, Punch};
use crate::task::Case;

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

macro_rules! rows {
    ($($fault:literal, $kept:literal, $symbol:literal, $counted:ident, $place:literal, $enlarge:expr;)+) => {
        &[$(Row {
            fault: $fault,
            kept: $kept,
            symbol: $symbol,
            counted: Counted::$counted,
            place: $place,
            enlarge: $enlarge,
        }),+]
    };
}

/// Tables of faults and of constants have this order. A row has what a [`Row`] has, in the same order.
static ROWS: &[Row] = rows! {
    "", 16, "k_n between grains", Factor, "k_n = 2·E·R1·R2/(R1 + R2) (Eq. 4)",
        |given, by| stiffen(given, Body::Grain, by);
    "", 12, "k_n at walls", Factor, "k_n at walls: a wall counts as a grain of the same radius",
        |given, by| if !given.constants.walls.is_empty() { stiffen(given, Body::Wall, by) };
    "", 11, "k_n at the punch", Factor, "k_n at the punch: it counts as a grain of the same radius",
        |given, by| if given.punch.is_some() { stiffen(given, Body::Punch, by) };
    // Every k_n; a scene has its punch later.
    "stiffness", 0, "", Factor, "", |given, by| all(&mut given.constants.normal_factors, by);
    "shear-stiffness", 13, "k_s", Factor, "k_s = law.stiffness_ratio · k_n",
        |given, by| if given.constants.law.has_friction() { all([&mut given.constants.tangential_factor], by) };
    // Young's modulus, so k_n and k_s.
    "modulus", 0, "", Factor, "", |given, by| all([&mut given.constants.law.modulus], by);
    "gravity", 0, "", Factor, "", |given, by| all(&mut given.constants.gravity, by);
    "density", 0, "", Factor, "", |given, by| all(given.bodies.mass.iter_mut().chain(&mut given.bodies.inertia), by);
    "", 10, "tan φ", Factor, "the limit |N| tan φ (Eq. 5)",
        |given, by| angles(given).for_each(|angle| *angle = (angle.tan() * (1.0 + by)).atan());
    "", 14, "c_n", Factor, "law.contact.viscosity", |given, by| {
        // Of a restitution each pair has a c_n of its own.
        all([&mut given.constants.damping_ratios[0]], by);
        if let Viscosity::Dashpot { c_n, .. } = &mut given.constants.law.contact.viscosity {
            all([c_n], by);
        }
    };
    "damping", 15, "α", Factor, "model.alpha", |given, by| all([&mut given.constants.alpha], by);
    "friction", 0, "", Factor, "", |given, by| all(angles(given), by);
    // The damping constant of the dashpots, or the restitution.
    "dashpot", 0, "", Factor, "", |given, by| given.constants.change_law(|law| match &mut law.contact.viscosity {
        Viscosity::None => {}
        Viscosity::Dashpot { c_n: value, .. }
        | Viscosity::Restitution { e_n: value, .. }
        | Viscosity::Ratio { ratio: value, .. } => all([value], by),
    });
    // Of grain 0, at its contacts only.
    "radius", 0, "", Factor, "", |given, by| all(given.bodies.radius.first_mut(), by);
    "", 8, "g_x", Gravity, "model.gravity", |given, by| pull(given, Axis::X, by);
    // Over |g| too, of which it has nearly all.
    "", 9, "g_z", Factor, "model.gravity", |given, by| pull(given, Axis::Z, by);
    "time-step", 7, "Δt", Factor, "model.dt", |given, by| all([&mut given.constants.dt], by);
    "", 5, "mass", Factor, "the masses in initial.csv", |given, by| all(&mut given.bodies.mass, by);
    "", 6, "moment of inertia", Factor, "the moments of inertia in initial.csv",
        |given, by| if given.constants.law.rotates() { all(&mut given.bodies.inertia, by) };
    // At contacts.
    "", 4, "radius", Factor, "the radii in initial.csv", |given, by| all(&mut given.bodies.radius, by);
    // Of grain 0.
    "inertia", 0, "", Factor, "", |given, by| all(given.bodies.inertia.first_mut(), by);
    // The right wall is moved by this share of its place.
    "wall", 0, "", Factor, "", |given, by| right_wall(&mut given.constants, |wall| all([&mut wall.place], by));
    "", 0, "place of wall 0", Radius, "model.walls", |given, by| shift(given, 0, by);
    "", 1, "place of wall 1", Radius, "model.walls", |given, by| shift(given, 1, by);
    "", 2, "place of wall 2", Radius, "model.walls", |given, by| shift(given, 2, by);
    "", -1, "place of wall 3", Radius, "model.walls", |given, by| shift(given, 3, by);
    "", -2, "place of wall 4", Radius, "model.walls", |given, by| shift(given, 4, by);
    // The dashpots along the tangent of Hertz's springs; those of linear ones have c_n.
    "tangential-dashpot", -3, "c_s", Factor, "law.contact.tangential_viscosity, and the damping ratio along the tangent", |given, by| {
        let has_its_own = given.constants.law.contact.springs == Springs::HertzMindlin;
        if has_its_own && given.constants.law.has_friction() {
            all([&mut given.constants.damping_ratios[1]], by);
        }
    };
    "rolling-stiffness", -4, "bending stiffness", Factor, "law.contact.rolling.bending_stiffness",
        |given, by| all(rolling(given).flat_map(|rolling| &mut rolling.bending_stiffness), by);
    "twisting-stiffness", -5, "twisting stiffness", Factor, "law.contact.rolling.twisting_stiffness",
        |given, by| all(rolling(given).map(|rolling| &mut rolling.twisting_stiffness), by);
    "rolling-limit", -6, "η", Factor, "law.contact.rolling.limit: the largest moment |N| η (R1 + R2)/2",
        |given, by| all(rolling(given).flat_map(|rolling| &mut rolling.limit), by);
    "adhesion", -7, "γ", Factor, "law.contact.adhesion", |given, by| all(&mut given.constants.law.contact.adhesion, by);
    "material", -8, "E of material 1", Factor, "law.materials, of which the first is material 1",
        |given, by| all(given.constants.law.materials.first_mut().map(|solid| &mut solid.modulus), by);
    "", -9, "velocity of obstacles", Factor, "model.obstacles[].velocity",
        |given, by| all(given.constants.obstacles.iter_mut().flat_map(|obstacle| &mut obstacle.velocity), by);
    "", -10, "spin of obstacles", Factor, "model.obstacles[].spin, rad/s about fixed axes",
        |given, by| all(given.constants.obstacles.iter_mut().flat_map(|obstacle| &mut obstacle.spin), by);
    "", 3, "velocity of the punch", Factor, "punch.velocity, and when the punch moves: before the forces",
        |given, by| all(given.punch.iter_mut().map(|punch| &mut punch.velocity), by);
};

/// Makes each of these larger by a share.
fn all<'a>(values: impl IntoIterator<Item = &'a mut f64>, by: f64) {
    values.into_iter().for_each(|value| *value *= 1.0 + by);
}

fn stiffen(given: &mut Given, body: Body, by: f64) {
    all([&mut given.constants.normal_factors[body as usize]], by);
}

fn angles(given: &mut Given) -> impl Iterator<Item = &mut f64> {
    let law = &mut given.constants.law;
    let aside = [&mut law.wall_friction_angle, &mut law.punch_friction_angle];
    let of_bodies = aside.into_iter().flatten().chain([&mut law.friction_angle]);
    let of_materials = law.materials.iter_mut();
    of_bodies.chain(of_materials.map(|solid| &mut solid.friction_angle))
}

fn rolling(given: &mut Given) -> impl Iterator<Item = &mut Rolling> {
    given.constants.law.contact.rolling.iter_mut()
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
