//! The same experiment seen from elsewhere: mirrored, turned, shifted, in other units or with other ids. A case goes there, and
//! the answer comes back.

use grains::model::{Axis, Wall};
use grains::scene::Viscosity;
use grains::tables::{Across, Bodies, Contact, Memories, Punch, Snapshot};
use grains::task::Case;

/// How the same things are called elsewhere. Vectors are (x, y, z).
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Each coordinate there, by those here: a rotation or a reflection. In the plane y stays y.
    matrix: [[f64; 3]; 3],
    /// Added to the coordinates here, m.
    shift: [f64; 3],
    /// One metre, kilogram and second in the units there.
    units: [f64; 3],
    /// The id there of each grain; empty where they stay.
    ids: Vec<u32>,
}

impl Frame {
    /// Where everything is called as it is.
    pub const HERE: Frame = Frame::turned([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// Left is right.
    pub const MIRRORED: Frame = Frame::turned([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// What points up points left.
    pub const TURNED: Frame = Frame::turned([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);

    /// Front is back.
    pub const FRONT_TO_BACK: Frame =
        Frame::turned([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// What points right points back; up stays up.
    pub const ABOUT_UP: Frame = Frame::turned([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);

    /// About no axis of the box: the rows have length one because 1² + 4² + 8² = 4² + 7² + 4² = 9².
    pub const ASKEW: Frame = Frame::turned([
        [1.0 / 9.0, -4.0 / 9.0, 8.0 / 9.0],
        [8.0 / 9.0, 4.0 / 9.0, 1.0 / 9.0],
        [-4.0 / 9.0, 7.0 / 9.0, 4.0 / 9.0],
    ]);

    /// In the plane by an angle that is no quarter, whose sine and cosine are 3/5 and 4/5.
    pub const ASLANT: Frame = Frame::turned([[0.8, 0.0, -0.6], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]]);

    const fn turned(matrix: [[f64; 3]; 3]) -> Self {
        Frame {
            matrix,
            shift: [0.0; 3],
            units: [1.0; 3],
            ids: Vec::new(),
        }
    }

    /// So far to the right, back and up, m.
    pub fn shifted(shift: [f64; 3]) -> Self {
        Frame {
            shift,
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
        Frame::with_ids((0..grains).map(id).collect())
    }

    /// Each grain has this id there.
    pub fn with_ids(ids: Vec<u32>) -> Self {
        Frame { ids, ..Frame::HERE }
    }

    /// The way back.
    pub fn back(&self) -> Self {
        let mut back = Frame::HERE;
        back.matrix = [0, 1, 2].map(|here| self.matrix.map(|row| row[here]));
        if self.shift != [0.0; 3] {
            let shift = self.shift.map(|way| -self.units[0] * way);
            back.shift = self.vector(shift, 1.0);
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

    /// The determinant: −1 where what turned left turns right.
    fn hand(&self) -> f64 {
        let [a, b, c] = self.matrix;
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        let determinant = a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1);
        determinant.signum()
    }

    /// A vector, in a unit. Where coordinates only change their places no number is rounded and a zero keeps its sign.
    fn vector(&self, vector: [f64; 3], unit: f64) -> [f64; 3] {
        self.matrix.map(|row| {
            let parts = row
                .into_iter()
                .zip(vector)
                .filter(|(entry, _)| *entry != 0.0);
            let sum = parts
                .map(|(entry, part)| entry * part)
                .reduce(|sum, part| sum + part);
            sum.expect("each row has an entry") * unit
        })
    }

    fn place(&self, place: [f64; 3]) -> [f64; 3] {
        let mut shifted = place;
        for (coordinate, shift) in shifted.iter_mut().zip(self.shift) {
            // A zero keeps its sign.
            if shift != 0.0 {
                *coordinate += shift;
            }
        }
        self.vector(shifted, self.units[0])
    }

    /// One in the plane: what it is across stays zero.
    fn in_plane(&self, [x, z]: [f64; 2], unit: f64) -> [f64; 2] {
        let [x, _, z] = self.vector([x, 0.0, z], unit);
        [x, z]
    }

    /// Only of frames that are turned by quarters, where a wall normal to one axis is one normal to another.
    fn wall(&self, wall: &Wall) -> Wall {
        let mut place = [0.0; 3];
        place[wall.axis.in_space()] = wall.place;
        let along = |row: &[f64; 3]| row[wall.axis.in_space()].abs() == 1.0;
        let there = self.matrix.iter().position(along);
        let there = there.expect("no case with walls is turned askew");
        Wall::at([Axis::X, Axis::Y, Axis::Z][there], self.place(place)[there])
    }

    fn id(&self, id: u32) -> u32 {
        self.ids.get(id as usize).copied().unwrap_or(id)
    }

    /// Grains as they are there.
    pub fn bodies(&self, bodies: &Bodies) -> Bodies {
        let [length, mass, time] = self.units;
        let mut there = bodies.clone();
        for old in 0..bodies.len() {
            let id = self.id(old as u32) as usize;
            let place = self.place(bodies.position(old));
            let velocity = self.vector(bodies.velocity(old), length / time);
            let spin = self.vector(bodies.angular_velocity(old), self.hand() / time);
            let inertia = bodies.inertia.get(old).copied().unwrap_or(0.0);
            let others = [
                bodies.radius[old] * length,
                bodies.mass[old] * mass,
                inertia * (mass * length * length),
            ];
            let values = [place, velocity, spin, others];
            for (column, value) in there.columns_mut().into_iter().zip(values.as_flattened()) {
                // What grains in the plane or without rotation do not have stays away.
                if let Some(cell) = column.get_mut(id) {
                    *cell = *value;
                }
            }
            if let Some(material) = bodies.material.get(old) {
                there.material[id] = *material;
            }
        }
        there
    }

    fn punch(&self, punch: Punch) -> Punch {
        let [length, _, time] = self.units;
        let [x, z] = punch.centre;
        let [x, _, z] = self.place([x, 0.0, z]);
        Punch {
            centre: [x, z],
            half_extents: punch.half_extents.map(|half| half * length),
            start: (punch.start + self.shift[2]) * length,
            velocity: punch.velocity * length / time,
            force: punch.force * self.force(),
        }
    }

    /// A contact, in space with what it has across.
    pub fn contact(
        &self,
        contact: &Contact,
        across: Option<&Across>,
        grains: usize,
    ) -> (Contact, Option<Across>) {
        let ([nx, nz], [x, z]) = (contact.normal, contact.point);
        let y = across.map_or(0.0, |across| across.point);
        let mut normal = self.vector([nx, across.map_or(0.0, |across| across.normal), nz], 1.0);
        let [x, y, z] = self.place([x, y, z]);
        // In space the size of a tangential force has no direction.
        let hand = across.map_or(self.hand(), |_| 1.0);
        let mut there = Contact {
            id1: self.id(contact.id1),
            id2: self.id(contact.id2),
            overlap: contact.overlap * self.units[0],
            normal_force: contact.normal_force * self.force(),
            tangential_force: hand * contact.tangential_force * self.force(),
            normal: contact.normal,
            point: [x, z],
        };
        let mut tangential = across.map(|across| self.vector(across.tangential, self.force()));
        // The lower id of two grains stands first; forces on the other one have other signs, and so has the normal.
        if (there.id1 as usize) < grains && there.id1 > there.id2 {
            std::mem::swap(&mut there.id1, &mut there.id2);
            normal = normal.map(|part| -part);
            tangential = tangential.map(|force| force.map(|part| -part));
        }
        there.normal = [normal[0], normal[2]];
        let across = tangential.map(|tangential| Across {
            normal: normal[1],
            point: y,
            tangential,
        });
        (there, across)
    }

    /// A case as it is there. A punch goes down in all frames that are not turned.
    pub fn case(&self, case: &Case) -> Case {
        let [length, mass, time] = self.units;
        assert!(
            case.model.obstacles.is_empty(),
            "obstacles stay where they are"
        );
        let mut there = case.clone();
        let model = &mut there.model;
        model.gravity = self.in_plane(case.model.gravity, length / (time * time));
        model.dt *= time;
        let materials = model.law.materials.iter_mut();
        let moduli = materials.map(|solid| &mut solid.modulus);
        for modulus in moduli.chain([&mut model.law.modulus]) {
            *modulus *= mass / (length * time * time);
        }
        if let Some(rolling) = &mut model.law.contact.rolling {
            let stiffness = mass * length * length / (time * time);
            let bending = rolling.bending_stiffness.iter_mut();
            bending.for_each(|bending| *bending *= stiffness);
            rolling.twisting_stiffness *= stiffness;
        }
        if let Some(adhesion) = &mut model.law.contact.adhesion {
            *adhesion *= mass / (time * time);
        }
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
        let contacts = told.contacts.iter().enumerate();
        let mut contacts: Vec<(Contact, Option<Across>)> = contacts
            .map(|(row, contact)| back.contact(contact, told.across.get(row), grains))
            .collect();
        contacts.sort_by_key(|(contact, _)| (contact.id1, contact.id2));
        let across = contacts.iter().filter_map(|(_, across)| *across).collect();
        Snapshot {
            stage: told.stage,
            step: told.step,
            time: told.time * back.units[2],
            bodies: back.bodies(&told.bodies),
            contacts: contacts.into_iter().map(|(contact, _)| contact).collect(),
            across,
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
        let case = Case::new("", Model::of(&scene), initial_bodies(&scene), vec![0]);
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
        assert_eq!(quarter.in_plane([0.0, 1.0], 1.0), [-1.0, 0.0]);
        assert_eq!([quarter.hand(), Frame::MIRRORED.hand()], [1.0, -1.0]);
    }
}
