//! Reading the tables that the scripts wrote, trusting none of them.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use serde::Deserialize;

use super::{YadeError, nonsense};
use crate::engine::punch_line::PunchLine;
use crate::files::read_text;
use crate::run::tables::most_contacts;
use grains::tables::{Bodies, BodyIds, Contact, Punch};

const CONTACT_COLUMNS: usize = 9;

/// What a line of the index says of a moment's tables.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MomentLine {
    bodies: usize,
    contacts: usize,
    out_of_plane: f64,
    punch: Option<PunchLine>,
}

/// The most that the index of the tables may have, bytes.
const LONGEST_INDEX: u64 = 1 << 28;

/// The lines of `frames.jsonl`.
pub fn index(work: &Path) -> Result<String, YadeError> {
    read_text(&work.join("frames.jsonl"), LONGEST_INDEX)
        .map_err(|error| nonsense(error.to_string()))
}

/// `frames.bin`, read from the front.
pub struct Tables {
    file: BufReader<File>,
}

impl Tables {
    /// Opens the tables in this folder.
    pub fn open(work: &Path) -> Result<Self, YadeError> {
        let path = work.join("frames.bin");
        let file =
            File::open(&path).map_err(|error| nonsense(format!("{}: {error}", path.display())))?;
        Ok(Tables {
            file: BufReader::new(file),
        })
    }

    /// The tables of the next moment; radii, masses and moments of inertia are those of `start`.
    pub fn moment(
        &mut self,
        of: &MomentLine,
        start: &Bodies,
        ids: BodyIds,
        half_extents: [f64; 2],
        at: &str,
    ) -> Result<(Bodies, Vec<Contact>, Option<Punch>), YadeError> {
        let count = start.len();
        if of.bodies != count {
            return Err(nonsense(format!(
                "{at}: {} grains instead of {count}",
                of.bodies
            )));
        }
        if of.out_of_plane != 0.0 {
            return Err(nonsense(format!("{at}: grains have left the plane")));
        }
        if of.contacts as u64 > most_contacts(count as u32) {
            return Err(nonsense(format!("{at}: {} contacts", of.contacts)));
        }
        let bodies = Bodies {
            x: self.numbers(count, at)?,
            z: self.numbers(count, at)?,
            vx: self.numbers(count, at)?,
            vz: self.numbers(count, at)?,
            radius: start.radius.clone(),
            mass: start.mass.clone(),
            spin: self.numbers(start.spin.len(), at)?,
            inertia: start.inertia.clone(),
        };
        let rows = self.numbers(of.contacts * CONTACT_COLUMNS, at)?;
        let mut contacts = rows
            .chunks_exact(CONTACT_COLUMNS)
            .map(|row| contact(row, ids))
            .collect::<Option<Vec<Contact>>>()
            .ok_or_else(|| nonsense(format!("{at}: a contact between bodies that do not exist")))?;
        contacts.sort_by_key(|contact| (contact.id1, contact.id2));
        let punch = of.punch.as_ref();
        let punch = punch.map(|punch| punch.read(half_extents, at));
        let punch = punch.transpose().map_err(nonsense)?;
        Ok((bodies, contacts, punch))
    }

    fn numbers(&mut self, count: usize, at: &str) -> Result<Vec<f64>, YadeError> {
        let mut bytes = vec![0; count * 8];
        self.file
            .read_exact(&mut bytes)
            .map_err(|_| nonsense(format!("{at}: frames.bin is cut off")))?;
        let numbers: Vec<f64> = bytes
            .chunks_exact(8)
            .map(|chunk| {
                let mut eight = [0; 8];
                eight.copy_from_slice(chunk);
                f64::from_ne_bytes(eight)
            })
            .collect();
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(nonsense(format!("{at}: a {number} among its numbers"))),
            None => Ok(numbers),
        }
    }

    /// Nothing follows the last moment.
    pub fn at_end(&mut self) -> Result<(), YadeError> {
        let mut more = [0; 1];
        match self.file.read(&mut more) {
            Ok(0) => Ok(()),
            _ => Err(nonsense(
                "frames.bin goes on after the last moment".to_owned(),
            )),
        }
    }
}

/// A contact of the script's row; its force is split along the normal and across it as the native
/// engine splits its own.
fn contact(row: &[f64], ids: BodyIds) -> Option<Contact> {
    let id = |value: f64| {
        let id = value as u32;
        (f64::from(id) == value && id <= ids.punch()).then_some(id)
    };
    let (nx, nz, fx, fz) = (row[3], row[4], row[5], row[6]);
    Some(Contact {
        id1: id(row[0])?,
        id2: id(row[1]).filter(|id| ids.is_grain(*id))?,
        overlap: row[2],
        normal_force: fx * nx + fz * nz,
        tangential_force: fz * nx - fx * nz,
        normal: [nx, nz],
        point: [row[7], row[8]],
    })
}
