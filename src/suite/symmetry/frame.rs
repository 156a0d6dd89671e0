//! A way to see an experiment: another frame, and other numbers for the grains.

use std::collections::BTreeMap;

use crate::suite::Track;
use crate::suite::motion::furthest;
use grains::case::Case;
use grains::model::{Axis, Wall};
use grains::tables::{Bodies, Contact, Punch, Snapshot};

/// Another frame: x′ = Mx + shift + drift·t, and another order of the grains.
#[derive(Debug, Clone)]
pub struct Frame {
    /// M, rows; one ±1 in each row and column, so that it never rounds.
    pub turn: [[f64; 2]; 2],
    /// m.
    pub shift: [f64; 2],
    /// m/s.
    pub drift: [f64; 2],
    /// The new number of each grain; empty if they keep theirs.
    pub numbers: Vec<usize>,
}

impl Frame {
    /// The frame in which nothing is any different.
    pub const SAME: Frame = Frame {
        turn: [[1.0, 0.0], [0.0, 1.0]],
        shift: [0.0; 2],
        drift: [0.0; 2],
        numbers: Vec::new(),
    };

    fn turned(&self, [x, z]: [f64; 2]) -> [f64; 2] {
        self.turn.map(|row| row[0] * x + row[1] * z)
    }

    /// A spin changes its sign in a mirror: that of det M.
    fn spin(&self, spin: f64) -> f64 {
        let [[a, b], [c, d]] = self.turn;
        (a * d - b * c) * spin
    }

    fn position(&self, position: [f64; 2], time: f64) -> [f64; 2] {
        let turned = self.turned(position);
        [0, 1].map(|i| turned[i] + self.shift[i] + self.drift[i] * time)
    }

    fn velocity(&self, velocity: [f64; 2]) -> [f64; 2] {
        let turned = self.turned(velocity);
        [0, 1].map(|i| turned[i] + self.drift[i])
    }

    fn number(&self, id: usize) -> usize {
        self.numbers.get(id).copied().unwrap_or(id)
    }

    fn wall(&self, wall: &Wall) -> Wall {
        let mut at = [0.0; 2];
        at[wall.axis as usize] = wall.place;
        let at = self.turned(at);
        let across = self.turn[0][wall.axis as usize] != 0.0;
        let (axis, i) = if across { (Axis::X, 0) } else { (Axis::Z, 1) };
        Wall {
            axis,
            place: at[i] + self.shift[i],
        }
    }

    /// The case as it is in this frame. A punch stays upright.
    pub fn case(&self, name: &str, case: &Case) -> Case {
        let mut model = case.model.clone();
        model.gravity = self.turned(model.gravity);
        model.walls = model.walls.iter().map(|wall| self.wall(wall)).collect();
        Case {
            name: name.to_owned(),
            model,
            bodies: self.bodies(&case.bodies, 0.0),
            punch: case.punch.map(|punch| Punch {
                centre: self.position(punch.centre, 0.0),
                start: punch.start + self.shift[1],
                ..punch
            }),
            moments: case.moments.clone(),
        }
    }

    /// The grains as they are in this frame at this time.
    fn bodies(&self, of: &Bodies, time: f64) -> Bodies {
        let mut seen = of.clone();
        for id in 0..of.len() {
            let to = self.number(id);
            [seen.x[to], seen.z[to]] = self.position([of.x[id], of.z[id]], time);
            [seen.vx[to], seen.vz[to]] = self.velocity([of.vx[id], of.vz[id]]);
            seen.radius[to] = of.radius[id];
            seen.mass[to] = of.mass[id];
            if let (Some(spin), Some(inertia)) = (of.spin.get(id), of.inertia.get(id)) {
                seen.spin[to] = self.spin(*spin);
                seen.inertia[to] = *inertia;
            }
        }
        seen
    }

    /// Ids and force on the second body of a contact in this frame, the lower grain first.
    fn force(&self, contact: &Contact, grains: usize) -> ((u32, u32), [f64; 2]) {
        let force = self.turned(contact.force());
        let number = |id: u32| match (id as usize) < grains {
            true => self.number(id as usize) as u32,
            false => id,
        };
        let (one, two) = (number(contact.id1), number(contact.id2));
        if one < two || one as usize >= grains {
            ((one, two), force)
        } else {
            ((two, one), force.map(|component| -component))
        }
    }

    /// The largest differences between how `still` looks in this frame and `other`, over all moments:
    /// of positions, velocities, spins and forces. The time is that of the case.
    pub fn differences(&self, dt: f64, still: &Track, other: &Track) -> [f64; 4] {
        let mut worst = [0.0; 4];
        for (still, other) in still.iter().zip(other) {
            let (a, b) = (
                self.bodies(&still.bodies, still.step as f64 * dt),
                &other.bodies,
            );
            let found = [
                furthest(0.0, [apart(&a.x, &b.x), apart(&a.z, &b.z)]),
                furthest(0.0, [apart(&a.vx, &b.vx), apart(&a.vz, &b.vz)]),
                apart(&a.spin, &b.spin),
                self.forces_apart(still, other),
            ];
            for (worst, found) in worst.iter_mut().zip(found) {
                *worst = furthest(0.0, [*worst, found]);
            }
        }
        if still.is_empty() || still.len() != other.len() {
            return [f64::NAN; 4];
        }
        worst
    }

    /// A contact that only one of the two has bears nothing in the other.
    fn forces_apart(&self, still: &Snapshot, other: &Snapshot) -> f64 {
        let grains = still.bodies.len();
        let mut apart: BTreeMap<(u32, u32), [f64; 2]> = BTreeMap::new();
        for contact in &still.contacts {
            let (ids, force) = self.force(contact, grains);
            apart.insert(ids, force);
        }
        for contact in &other.contacts {
            let force = contact.force();
            let difference = apart.entry((contact.id1, contact.id2)).or_default();
            *difference = [0, 1].map(|i| difference[i] - force[i]);
        }
        furthest(0.0, apart.into_values().flatten()).abs()
    }
}

/// The largest difference of two columns; not a number if one is longer.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::NAN;
    }
    furthest(0.0, a.iter().zip(b).map(|(a, b)| a - b)).abs()
}
