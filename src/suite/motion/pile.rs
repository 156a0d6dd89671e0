//! Piles of frictionless discs at rest, against statics.
//!
//! The lattice is opened sideways, so that only diagonal neighbours touch. From the top down, each disc
//! then rests on two bodies, and its equilibrium gives their forces from those above, as in Oron and
//! Herrmann 1998 (Phys. Rev. E 58:2079–2089). Overlaps change the angles a little: the normals are those of
//! the pile.

use super::furthest;
use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Group, Line, Rung, Track};
use grains::case::Case;
use grains::model::{Axis, Model};
use grains::tables::{BodyIds, Contact, Snapshot};

/// m.
const RADIUS: f64 = 1.0;
/// kg/m³.
const DENSITY: f64 = 1000.0;
/// m/s².
const GRAVITY: f64 = 9.81;
/// Strong local damping, so that the pile comes to rest.
const ALPHA: f64 = 0.7;
/// ER over the weight of a disc.
const STIFF: f64 = 1.0e3;
/// Half the pitch of a row over R: more than 1, so that its discs do not touch.
const OPENED: f64 = 1.1;
/// Steps to rest.
const STEPS: u64 = 8000;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![column(), pyramid()]
}

/// Weight of a disc of this radius.
fn weight(radius: f64) -> f64 {
    Grain::disc([0.0; 2], radius, DENSITY).mass * GRAVITY
}

fn modulus() -> f64 {
    STIFF * weight(RADIUS) / RADIUS
}

/// How far one row of equal discs stands above the other.
fn rise() -> f64 {
    RADIUS * (4.0 - OPENED * OPENED).sqrt()
}

/// A pile between walls at these places on the floor z = 0.
struct Pile {
    grains: Vec<Grain>,
    walls: [f64; 2],
    /// Contacts whose forces statics does not give, taken as they are.
    given: Vec<(u32, u32)>,
    /// Each disc with the two bodies that bear it, those above first.
    rests: Vec<(u32, [u32; 2])>,
}

impl Pile {
    fn case(&self, name: &str) -> Case {
        let disc = Grain::disc([0.0; 2], RADIUS, DENSITY);
        let period = (disc.mass / (modulus() * RADIUS)).sqrt();
        let walls = self.walls.map(|place| build::wall(Axis::X, place));
        let model = Model {
            gravity: [0.0, -GRAVITY],
            alpha: ALPHA,
            walls: walls
                .into_iter()
                .chain([build::wall(Axis::Z, 0.0)])
                .collect(),
            ..build::model(build::springs(modulus()), 0.3 * period)
        };
        build::case(name, model, &self.grains, vec![STEPS])
    }

    /// Rounding of a position, which is up to so high, makes that much of the smallest force, half a
    /// weight: eight roundings of half a unit in the last place.
    fn tolerance(&self) -> f64 {
        let top = self.grains.iter().map(|grain| grain.position[1]);
        let height = top.fold(0.0, f64::max);
        8.0 * 0.5 * f64::EPSILON * height * STIFF / RADIUS / 0.5
    }

    fn judge(&self, at: &Snapshot) -> Vec<Line> {
        let basis = "eight roundings of a height, times k_n, over half a weight";
        let ratio = |what: &str, ratios: Vec<f64>| {
            let value = furthest(1.0, ratios);
            line(what, "1", value, 1.0, self.tolerance(), basis)
        };
        vec![
            line(
                "contacts",
                "1",
                at.contacts.len() as f64,
                (2 * self.rests.len() + self.given.len()) as f64,
                0.0,
                "two a disc, and those that are given",
            ),
            ratio(
                "force over that of statics, of the contact where it is furthest from 1",
                self.statics(at),
            ),
            ratio(
                "force over k_n u, of the contact where it is furthest from 1",
                at.contacts
                    .iter()
                    .map(|contact| self.spring(at, contact))
                    .collect(),
            ),
        ]
    }

    /// Every contact force that statics gives: as it is over as it should be.
    fn statics(&self, at: &Snapshot) -> Vec<f64> {
        let mut solved: Vec<(&Contact, f64)> = Vec::new();
        for contact in &at.contacts {
            if self.given.contains(&(contact.id1, contact.id2)) {
                solved.push((contact, contact.normal_force));
            }
        }
        let given = solved.len();
        for &(disc, bearers) in &self.rests {
            let [Some(a), Some(b)] = bearers.map(|bearer| between(at, disc, bearer)) else {
                return vec![f64::NAN];
            };
            let mut load = [0.0, -weight(self.grains[disc as usize].radius)];
            for (contact, force) in &solved {
                let towards = direction(contact, disc);
                load[0] += force * towards[0];
                load[1] += force * towards[1];
            }
            let ([ax, az], [bx, bz]) = (direction(a, disc), direction(b, disc));
            let area = ax * bz - az * bx;
            solved.push((a, (load[1] * bx - load[0] * bz) / area));
            solved.push((b, (load[0] * az - load[1] * ax) / area));
        }
        let ratio = |(contact, force): &(&Contact, f64)| contact.normal_force / force;
        solved.iter().skip(given).map(ratio).collect()
    }

    /// The force of a contact over k_n u, both from positions and radii.
    fn spring(&self, at: &Snapshot, contact: &Contact) -> f64 {
        let place = |id: u32| [at.bodies.x[id as usize], at.bodies.z[id as usize]];
        let two = self.grains[contact.id2 as usize].radius;
        let (one, distance) = match self.grains.get(contact.id1 as usize) {
            Some(one) => {
                let (a, b) = (place(contact.id1), place(contact.id2));
                (one.radius, (a[0] - b[0]).hypot(a[1] - b[1]) - one.radius)
            }
            None => {
                let axis = usize::from(contact.normal[1] != 0.0);
                let walls = [self.walls[0], self.walls[1], 0.0];
                let wall = walls.get(contact.id1 as usize - self.grains.len());
                let wall = wall.copied().unwrap_or(f64::NAN);
                (two, (place(contact.id2)[axis] - wall).abs())
            }
        };
        let stiffness = 2.0 * modulus() * one * two / (one + two);
        contact.normal_force / (stiffness * (two - distance))
    }
}

fn between(at: &Snapshot, a: u32, b: u32) -> Option<&Contact> {
    let is = |contact: &&Contact| [(a, b), (b, a)].contains(&(contact.id1, contact.id2));
    at.contacts.iter().find(is)
}

/// Which way a contact pushes this disc; nowhere if it is not the disc's.
fn direction(contact: &Contact, disc: u32) -> [f64; 2] {
    let sign = f64::from(u8::from(contact.id2 == disc)) - f64::from(u8::from(contact.id1 == disc));
    contact.normal.map(|component| sign * component)
}

/// Rows of two discs at the walls and of one in the middle by turns, numbered from below. Half of the
/// weight above goes down on each side, so the upright part of every force is known to the last digit.
fn column() -> Rung {
    const PAIRS: u32 = 5;
    let half_pitch = OPENED * RADIUS;
    let wall = half_pitch + RADIUS;
    let mut grains = Vec::new();
    let mut rests = Vec::new();
    let count = 3 * PAIRS - 1;
    let ids = BodyIds::of_box(count);
    for row in 0..PAIRS {
        let low = RADIUS + 2.0 * f64::from(row) * rise();
        let first = 3 * row;
        let below = if row == 0 { ids.floor() } else { first - 1 };
        for (side, wall) in [(-1.0, ids.left()), (1.0, ids.right())] {
            rests.push((grains.len() as u32, [wall, below]));
            grains.push(Grain::disc([side * half_pitch, low], RADIUS, DENSITY));
        }
        if row + 1 < PAIRS {
            rests.push((first + 2, [first, first + 1]));
            grains.push(Grain::disc([0.0, low + rise()], RADIUS, DENSITY));
        }
    }
    rests.reverse();
    let pile = Pile {
        grains,
        walls: [-wall, wall],
        given: Vec::new(),
        rests,
    };
    let case = pile.case("column");
    let upright = move |contact: &Contact| {
        // The lowest of the discs above.
        let first = match contact.id2 % 3 {
            _ if contact.id1 == ids.floor() => 0,
            2 => contact.id2,
            side => contact.id2 - side,
        };
        let above = f64::from(count - first) * weight(RADIUS);
        contact.force()[1].abs() / (0.5 * above)
    };
    let judge = move |tracks: &[Track]| {
        let Some(at) = tracks[0].first() else {
            return Vec::new();
        };
        let mut lines = pile.judge(at);
        let borne = at
            .contacts
            .iter()
            .filter(|contact| contact.normal[1] != 0.0);
        lines.push(line(
            "upright part of a force over half the weight above, where it is furthest from 1",
            "1",
            furthest(1.0, borne.map(upright)),
            1.0,
            pile.tolerance(),
            "eight roundings of a height, times k_n, over half a weight",
        ));
        lines
    };
    Rung {
        name: "column-of-discs",
        title: "In a column between walls each side bears half of the weight above",
        group: Group::Exact,
        cases: vec![case],
        judge: Box::new(judge),
    }
}

/// A pyramid on a row of larger discs that are wedged between walls, so that nothing else touches sideways.
/// How hard they are wedged is no matter of statics: the left wall's force is given.
fn pyramid() -> Rung {
    const BASE: u32 = 5;
    let base_radius = OPENED * RADIUS;
    // Five weights of thrust: more than the pyramid's, which would open the base at two.
    let squeeze = 5.0 * RADIUS / STIFF;
    let pitch = 2.0 * base_radius - squeeze;
    let first = base_radius - squeeze;
    let rise_from_base = RADIUS * ((1.0 + OPENED).powi(2) - OPENED * OPENED).sqrt();
    let mut grains = Vec::new();
    let mut rows = Vec::new();
    for row in 0..BASE {
        let (radius, height) = match row {
            0 => (base_radius, base_radius),
            _ => (
                RADIUS,
                base_radius + rise_from_base + f64::from(row - 1) * rise(),
            ),
        };
        rows.push(grains.len() as u32);
        for place in 0..BASE - row {
            let x = first + pitch * (f64::from(place) + 0.5 * f64::from(row));
            grains.push(Grain::disc([x, height], radius, DENSITY));
        }
    }
    let ids = BodyIds::of_box(grains.len() as u32);
    let mut rests = Vec::new();
    for row in (1..BASE).rev() {
        for place in 0..BASE - row {
            let below = rows[row as usize - 1] + place;
            rests.push((rows[row as usize] + place, [below, below + 1]));
        }
    }
    for place in 0..BASE {
        let next = if place + 1 < BASE {
            place + 1
        } else {
            ids.right()
        };
        rests.push((place, [ids.floor(), next]));
    }
    let pile = Pile {
        grains,
        walls: [0.0, first + f64::from(BASE - 1) * pitch + first],
        given: vec![(ids.left(), 0)],
        rests,
    };
    let case = pile.case("pyramid");
    let judge = move |tracks: &[Track]| {
        let at = tracks[0].first();
        at.map(|at| pile.judge(at)).unwrap_or_default()
    };
    Rung {
        name: "pyramid-of-discs",
        title: "In a pyramid every contact bears what statics says",
        group: Group::Exact,
        cases: vec![case],
        judge: Box::new(judge),
    }
}
