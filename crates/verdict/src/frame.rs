//! The same experiment seen from elsewhere: mirrored, turned, shifted, in other units or with other ids. A case goes there, and
//! the answer comes back.

use grains::model::{Axis, Wall};
use grains::scene::Viscosity;
use grains::tables::{Bodies, Contact, Memories, Punch, Snapshot};
use grains::task::Case;

/// How the same things are called elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Each coordinate there: which one it is here, and with which sign.
    from: [(usize, f64); 2],
    /// Added to it.
    shift: [f64; 2],
    /// One metre, kilogram and second in the units there.
    units: [f64; 3],
    /// The id there of each grain; empty where they stay.
    ids: Vec<u32>,
}

impl Frame {
    /// Where everything is called as it is.
    pub const HERE: Frame = Frame {
        from: [(0, 1.0), (1, 1.0)],
        shift: [0.0; 2],
        units: [1.0; 3],
        ids: Vec::new(),
    };

    /// Left is right.
    pub const MIRRORED: Frame = Frame {
        from: [(0, -1.0), (1, 1.0)],
        shift: [0.0; 2],
        units: [1.0; 3],
        ids: Vec::new(),
    };

    /// What points up points left.
    pub const TURNED: Frame = Frame {
        from: [(1, -1.0), (0, 1.0)],
        shift: [0.0; 2],
        units: [1.0; 3],
        ids: Vec::new(),
    };

    /// So far to the right, m.
    pub fn shifted(way: f64) -> Self {
        Frame {
            shift: [way, 0.0],
            ..Frame::HERE
        }
    }

    /// These powers of two are a metre, a kilogram and a second: no number is rounded.
    pub fn in_units(powers: [i32; 3]) -> Self {
        Frame {
            units: powers.map(|power| 2.0f64.powi(power)),
            ..Frame::HERE
        }
    }

    /// The last of so many grains becomes the first, and then some: of most pairs the other one has the lower id.
    pub fn renumbered(grains: usize) -> Self {
        let id = |old: usize| ((2 * grains - 1 - old + grains / 3) % grains) as u32;
        Frame {
            ids: (0..grains).map(id).collect(),
            ..Frame::HERE
        }
    }

    /// The way back.
    fn back(&self) -> Self {
        let mut back = Frame::HERE;
        for (there, (here, sign)) in self.from.into_iter().enumerate() {
            back.from[here] = (there, sign);
            if self.shift[there] != 0.0 {
                back.shift[here] = -sign * self.units[0] * self.shift[there];
            }
        }
        back.units = self.units.map(|unit| 1.0 / unit);
        back.ids = vec![0; self.ids.len()];
        for (old, new) in self.ids.iter().enumerate() {
            back.ids[*new as usize] = old as u32;
        }
        back
    }

    fn force(&self) -> f64 {
        let [length, mass, time] = self.units;
        mass * length / (time * time)
    }

    /// −1 where what turned left turns right.
    fn hand(&self) -> f64 {
        let [(first, a), (_, b)] = self.from;
        if first == 0 { a * b } else { -a * b }
    }

    /// A vector, in a unit.
    fn vector(&self, vector: [f64; 2], unit: f64) -> [f64; 2] {
        self.from.map(|(axis, sign)| sign * vector[axis] * unit)
    }

    fn place(&self, place: [f64; 2]) -> [f64; 2] {
        let mut there = self.vector(place, 1.0);
        for (coordinate, shift) in there.iter_mut().zip(self.shift) {
            // A zero keeps its sign.
            if shift != 0.0 {
                *coordinate += shift;
            }
            *coordinate *= self.units[0];
        }
        there
    }

    fn wall(&self, wall: &Wall) -> Wall {
        let mut place = [0.0; 2];
        place[wall.axis as usize] = wall.place;
        let there = usize::from(self.from[0].0 != wall.axis as usize);
        Wall {
            axis: [Axis::X, Axis::Z][there],
            place: self.place(place)[there],
        }
    }

    fn id(&self, id: u32) -> u32 {
        self.ids.get(id as usize).copied().unwrap_or(id)
    }

    fn bodies(&self, bodies: &Bodies) -> Bodies {
        let [length, mass, time] = self.units;
        let mut there = bodies.clone();
        for old in 0..bodies.len() {
            let id = self.id(old as u32) as usize;
            [there.x[id], there.z[id]] = self.place([bodies.x[old], bodies.z[old]]);
            let velocity = [bodies.vx[old], bodies.vz[old]];
            [there.vx[id], there.vz[id]] = self.vector(velocity, length / time);
            there.radius[id] = bodies.radius[old] * length;
            there.mass[id] = bodies.mass[old] * mass;
            if bodies.rotate() {
                there.spin[id] = self.hand() * bodies.spin[old] / time;
            }
            if let Some(inertia) = bodies.inertia.get(old) {
                there.inertia[id] = inertia * (mass * length * length);
            }
        }
        there
    }

    fn punch(&self, punch: Punch) -> Punch {
        let [length, _, time] = self.units;
        Punch {
            centre: self.place(punch.centre),
            half_extents: punch.half_extents.map(|half| half * length),
            start: punch.start * length,
            velocity: punch.velocity * length / time,
            force: punch.force * self.force(),
        }
    }

    fn contact(&self, contact: &Contact, grains: usize) -> Contact {
        let mut there = Contact {
            id1: self.id(contact.id1),
            id2: self.id(contact.id2),
            overlap: contact.overlap * self.units[0],
            normal_force: contact.normal_force * self.force(),
            tangential_force: self.hand() * contact.tangential_force * self.force(),
            normal: self.vector(contact.normal, 1.0),
            point: self.place(contact.point),
        };
        // The lower id of two grains stands first; forces on the other one have other signs, and so has the normal.
        if (there.id1 as usize) < grains && there.id1 > there.id2 {
            std::mem::swap(&mut there.id1, &mut there.id2);
            there.normal = there.normal.map(|part| -part);
        }
        there
    }

    /// A case as it is there. A punch goes down in all frames that are not turned.
    pub fn case(&self, case: &Case) -> Case {
        let [length, mass, time] = self.units;
        let mut there = case.clone();
        let model = &mut there.model;
        model.gravity = self.vector(case.model.gravity, length / (time * time));
        model.dt *= time;
        model.law.modulus *= mass / (length * time * time);
        if let Viscosity::Dashpot { c_n, .. } = &mut model.law.contact.viscosity {
            *c_n *= mass / time;
        }
        let walls = case.model.walls.iter();
        model.walls = walls.map(|wall| self.wall(wall)).collect();
        there.bodies = self.bodies(&case.bodies);
        there.punch = case.punch.map(|punch| self.punch(punch));
        there
    }

    /// A moment that was told there, as it is here.
    pub fn told_here(&self, told: &Snapshot) -> Snapshot {
        let back = self.back();
        let grains = told.bodies.len();
        let contacts = told.contacts.iter();
        let mut contacts: Vec<Contact> = contacts
            .map(|contact| back.contact(contact, grains))
            .collect();
        contacts.sort_by_key(|contact| (contact.id1, contact.id2));
        Snapshot {
            stage: told.stage,
            step: told.step,
            time: told.time * back.units[2],
            bodies: back.bodies(&told.bodies),
            contacts,
            across: Vec::new(),
            memory: Memories::default(),
            punch: told.punch.map(|punch| back.punch(punch)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains::generate::initial_bodies;
    use grains::model::Model;
    use grains::native::run_case;
    use grains::scene::paper_scene;

    #[test]
    fn what_goes_there_comes_back() {
        let scene = paper_scene(1, 60);
        let case = Case {
            name: String::new(),
            model: Model::of(&scene),
            bodies: initial_bodies(&scene),
            punch: None,
            moments: vec![0],
        };
        let here = run_case(&case, None).expect("a run");
        for frame in [
            Frame::HERE,
            Frame::MIRRORED,
            Frame::TURNED,
            Frame::in_units([12, -7, 5]),
            Frame::renumbered(60),
        ] {
            let there = frame.case(&case);
            let told = run_case(&there, None).expect("a run");
            assert_eq!(
                frame.told_here(&told[0]).bodies,
                here[0].bodies,
                "{frame:?}"
            );
            assert_eq!(frame == Frame::HERE, there.bodies == case.bodies);
        }
        let quarter = Frame::TURNED;
        assert_eq!(quarter.vector([0.0, 1.0], 1.0), [-1.0, 0.0]);
        assert_eq!([quarter.hand(), Frame::MIRRORED.hand()], [1.0, -1.0]);
    }
}
