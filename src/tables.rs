//! The tables as CSV text: the shortest decimal that reads back to the same bits.

use std::fmt::Display;
use std::io::{BufRead, BufReader, Read};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use csv::StringRecord;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::files::{Aside, FileError, Place, Stream, failed};
use grains::tables::{
    Across, Bodies, BodyIds, Contact, Memories, Remembered, RememberedAcross, tangential,
};

/// The most text of a row, bytes: fourteen numbers and their separators, with room to spare.
const LONGEST_ROW: u64 = 400;
/// A longer line is no row and no header, bytes.
const LONGEST_LINE: u64 = 4096;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyRow {
    id: u32,
    x: f64,
    z: f64,
    vx: f64,
    vz: f64,
    radius: f64,
    mass: f64,
    #[serde(default)]
    spin: Option<f64>,
    #[serde(default)]
    inertia: Option<f64>,
    #[serde(default)]
    y: Option<f64>,
    #[serde(default)]
    vy: Option<f64>,
    #[serde(default)]
    spin_x: Option<f64>,
    #[serde(default)]
    spin_z: Option<f64>,
    #[serde(default)]
    material: Option<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ContactRow {
    id1: u32,
    id2: u32,
    overlap: f64,
    r#fn: f64,
    ft: f64,
    nx: f64,
    nz: f64,
    x: f64,
    z: f64,
    #[serde(default)]
    ny: Option<f64>,
    #[serde(default)]
    y: Option<f64>,
    #[serde(default)]
    ftx: Option<f64>,
    #[serde(default)]
    fty: Option<f64>,
    #[serde(default)]
    ftz: Option<f64>,
}

/// Writes grains with the columns `id,x,z,vx,vz,radius,mass`, and `spin,inertia` where grains rotate; in space also `y,vy`,
/// `spin_x,spin_z` and `material`.
pub fn write_bodies<'a>(place: impl Into<Place<'a>>, bodies: &Bodies) -> Result<(), FileError> {
    let mut header = vec!["id", "x", "z", "vx", "vz", "radius", "mass"];
    let mut columns = vec![
        &bodies.x,
        &bodies.z,
        &bodies.vx,
        &bodies.vz,
        &bodies.radius,
        &bodies.mass,
    ];
    if bodies.rotate() {
        header.extend(["spin", "inertia"]);
        columns.extend([&bodies.spin, &bodies.inertia]);
    }
    for (name, column) in [
        ("y", &bodies.y),
        ("vy", &bodies.vy),
        ("spin_x", &bodies.spin_x),
        ("spin_z", &bodies.spin_z),
    ] {
        if !column.is_empty() {
            header.push(name);
            columns.push(column);
        }
    }
    header.extend((!bodies.material.is_empty()).then_some("material"));
    let rows = (0..bodies.len()).map(|row| {
        let numbers: Vec<f64> = columns.iter().map(|column| column[row]).collect();
        let material: Vec<u32> = bodies.material.get(row).copied().into_iter().collect();
        (row as u32, numbers, material)
    });
    write_rows(place, &header, rows)
}

/// Reads `count` grains; ids must be 0, 1, 2, … and every value finite, radii, masses and moments of
/// inertia above 0; all grains rotate or none does.
pub fn read_bodies<'a>(place: impl Into<Place<'a>>, count: u32) -> Result<Bodies, FileError> {
    let rows = Rows::<BodyRow>::open(place, u64::from(count))?;
    let path = &rows.path.clone();
    let mut bodies = Bodies::default();
    for (row, line) in rows.enumerate() {
        let grain = line?;
        let ensure = rules_of(path, row);
        let is_next = grain.id as usize == row;
        ensure(is_next, "id", &grain.id, "the row's number, from 0 on")?;
        let spin = grain.spin.unwrap_or(0.0);
        let values = [grain.x, grain.z, grain.vx, grain.vz, spin];
        for (key, value) in ["x", "z", "vx", "vz", "spin"].into_iter().zip(values) {
            ensure(value.is_finite(), key, &value, "finite")?;
        }
        let inertia = grain.inertia.unwrap_or(1.0);
        let values = [grain.radius, grain.mass, inertia];
        for (key, value) in ["radius", "mass", "inertia"].into_iter().zip(values) {
            let is_size = value.is_finite() && value > 0.0;
            ensure(is_size, key, &value, "finite and above 0")?;
        }
        bodies.push(
            [grain.x, grain.z],
            [grain.vx, grain.vz],
            grain.radius,
            grain.mass,
        );
        let both = grain.spin.is_some() == grain.inertia.is_some();
        ensure(both, "spin", &"alone", "given with an inertia")?;
        bodies.spin.extend(grain.spin);
        bodies.inertia.extend(grain.inertia);
        for (key, value, column) in [
            ("y", grain.y, &mut bodies.y),
            ("vy", grain.vy, &mut bodies.vy),
            ("spin_x", grain.spin_x, &mut bodies.spin_x),
            ("spin_z", grain.spin_z, &mut bodies.spin_z),
        ] {
            let number = value.unwrap_or(0.0);
            ensure(number.is_finite(), key, &number, "finite")?;
            column.extend(value);
        }
        bodies.material.extend(grain.material);
        let in_space = grain.y.is_some();
        let whole = grain.vy.is_some() == in_space
            && [grain.spin_x, grain.spin_z]
                .iter()
                .all(|spin| spin.is_some() == (in_space && grain.spin.is_some()));
        ensure(
            whole,
            "y",
            &"some columns",
            "given with vy, and with spin_x and spin_z where grains rotate",
        )?;
        for (key, rows) in [
            ("spin", bodies.spin.len()),
            ("y", bodies.y.len()),
            ("material", bodies.material.len()),
        ] {
            let in_all = rows == 0 || rows == bodies.len();
            ensure(in_all, key, &"nothing", "given in every row or in none")?;
        }
    }
    Ok(bodies)
}

/// Says which value is not as it must be in the row with this index: whether it is, its column, itself, what it must be.
fn rules_of(
    path: &Path,
    row: usize,
) -> impl Fn(bool, &str, &dyn Display, &str) -> Result<(), FileError> {
    move |holds, key, value, wanted| match holds {
        true => Ok(()),
        false => Err(FileError::Unfit(format!(
            "{}: row {} has {key} = {value}, which must be {wanted}",
            path.display(),
            row + 1
        ))),
    }
}

const CONTACT_COLUMNS: [&str; 9] = ["id1", "id2", "overlap", "fn", "ft", "nx", "nz", "x", "z"];

/// Further ones in space.
const ACROSS_COLUMNS: [&str; 5] = ["ny", "y", "ftx", "fty", "ftz"];

/// Writes contacts with these columns, and what they have in space.
pub fn write_contacts<'a>(
    place: impl Into<Place<'a>>,
    contacts: &[Contact],
    across: &[Across],
) -> Result<(), FileError> {
    let mut header = CONTACT_COLUMNS.to_vec();
    if !across.is_empty() {
        header.extend(ACROSS_COLUMNS);
    }
    let rows = contacts.iter().enumerate().map(|(at, contact)| {
        let across = across.get(at);
        let across = across.map(|across| (across.normal, across.point, across.tangential));
        let forces = [
            contact.overlap,
            contact.normal_force,
            contact.tangential_force,
        ];
        (
            contact.id1,
            contact.id2,
            forces,
            contact.normal,
            contact.point,
            Vec::from_iter(across),
        )
    });
    write_rows(place, &header, rows)
}

/// More contacts than a plane bed of so many grains can have: six a grain, twice over, and walls.
pub fn most_contacts(grains: u32) -> u64 {
    12 * u64::from(grains) + 64
}

/// A normal's length may differ from 1 by so much: what single precision makes of it, and half as much again.
pub const NORMAL_TOLERANCE: f64 = 1.8e-7;

/// Reads the contacts between these bodies, sorted by ids, normals of length 1, and what they have in space.
pub fn read_contacts<'a>(
    place: impl Into<Place<'a>>,
    ids: BodyIds,
) -> Result<(Vec<Contact>, Vec<Across>), FileError> {
    let bodies = ids.punch() + 1;
    let rows = Rows::<ContactRow>::open(place, most_contacts(ids.grains))?;
    let path = &rows.path.clone();
    let mut before = None;
    let (mut contacts, mut all_across) = (Vec::new(), Vec::new());
    for (row, line) in rows.enumerate() {
        let contact = line?;
        let ensure = rules_of(path, row);
        for (key, id) in [("id1", contact.id1), ("id2", contact.id2)] {
            let wanted = "the id of a grain, a wall or the punch";
            ensure(id < bodies, key, &id, wanted)?;
        }
        let values = [
            contact.overlap,
            contact.r#fn,
            contact.ft,
            contact.nx,
            contact.nz,
            contact.x,
            contact.z,
        ];
        for (key, value) in CONTACT_COLUMNS[2..].iter().zip(values) {
            ensure(value.is_finite(), key, &value, "finite")?;
        }
        let is_later = before < Some((contact.id1, contact.id2));
        let pair = format_args!("{}-{}", contact.id1, contact.id2);
        ensure(is_later, "pair", &pair, "after the pair of the row before")?;
        before = Some((contact.id1, contact.id2));
        let across = [contact.ny, contact.y, contact.ftx, contact.fty, contact.ftz];
        for (key, value) in ACROSS_COLUMNS.iter().zip(across) {
            let number = value.unwrap_or(0.0);
            let holds = number.is_finite() && value.is_some() == contact.ny.is_some();
            ensure(holds, key, &number, "finite, and given with the others")?;
        }
        if let [Some(normal), Some(point), Some(x), Some(y), Some(z)] = across {
            all_across.push(Across {
                normal,
                point,
                tangential: [x, y, z],
            });
        }
        let in_all = all_across.is_empty() || all_across.len() == row + 1;
        ensure(in_all, "ny", &"nothing", "given in every row or in none")?;
        let length = contact
            .nx
            .hypot(contact.nz)
            .hypot(contact.ny.unwrap_or(0.0));
        let is_unit = (length - 1.0).abs() <= NORMAL_TOLERANCE;
        let normal = format_args!("({}, {})", contact.nx, contact.nz);
        ensure(is_unit, "normal", &normal, "of length 1")?;
        contacts.push(Contact {
            id1: contact.id1,
            id2: contact.id2,
            overlap: contact.overlap,
            normal_force: contact.r#fn,
            tangential_force: tangential(contact.ft),
            normal: [contact.nx, contact.nz],
            point: [contact.x, contact.z],
        });
    }
    Ok((contacts, all_across))
}

#[derive(Deserialize)]
struct MemoryRow {
    id1: u32,
    id2: u32,
    nx: f64,
    nz: f64,
    sx: f64,
    sz: f64,
    ny: Option<f64>,
    sy: Option<f64>,
    bx: Option<f64>,
    by: Option<f64>,
    bz: Option<f64>,
    tx: Option<f64>,
    ty: Option<f64>,
    tz: Option<f64>,
    slides: Option<u8>,
}

const MEMORY_COLUMNS: [&str; 6] = ["id1", "id2", "nx", "nz", "sx", "sz"];

/// Further ones in space: moments against bending and twisting, and 1 where the contact slides.
const MEMORY_ACROSS_COLUMNS: [&str; 9] = ["ny", "sy", "bx", "by", "bz", "tx", "ty", "tz", "slides"];

impl MemoryRow {
    /// What it has in space besides; nothing where a column is missing or has what it cannot have.
    fn across(&self) -> Option<RememberedAcross> {
        let slides = self.slides.filter(|slides| *slides < 2)?;
        let across = RememberedAcross {
            normal: self.ny?,
            shear: self.sy?,
            bending: [self.bx?, self.by?, self.bz?],
            twisting: [self.tx?, self.ty?, self.tz?],
            slides: slides == 1,
        };
        let moments = across.bending.into_iter().chain(across.twisting);
        let mut numbers = moments.chain([across.shear]);
        numbers.all(f64::is_finite).then_some(across)
    }
}

/// Writes what contacts remember with these columns.
pub fn write_memory<'a>(place: impl Into<Place<'a>>, memory: &Memories) -> Result<(), FileError> {
    let mut header = MEMORY_COLUMNS.to_vec();
    if !memory.across.is_empty() {
        header.extend(MEMORY_ACROSS_COLUMNS);
    }
    let rows = memory.planar.iter().enumerate().map(|(at, remembered)| {
        let across = memory.across.get(at).map(|across| {
            let forces = (across.normal, across.shear);
            let slides = u8::from(across.slides);
            (forces, across.bending, across.twisting, slides)
        });
        (
            remembered.id1,
            remembered.id2,
            remembered.normal,
            remembered.shear,
            Vec::from_iter(across),
        )
    });
    write_rows(place, &header, rows)
}

/// Reads what these contacts remember, in their order and with their normals.
pub fn read_memory<'a>(
    place: impl Into<Place<'a>>,
    contacts: &[Contact],
    across: &[Across],
) -> Result<Memories, FileError> {
    let rows = Rows::<MemoryRow>::open(place, contacts.len() as u64)?;
    let path = &rows.path.clone();
    let strange = || unlike(path, "it does not belong to the table of contacts");
    let mut memory = Memories::default();
    for line in rows {
        let row = line?;
        let remembered = Remembered {
            id1: row.id1,
            id2: row.id2,
            normal: [row.nx, row.nz],
            shear: [row.sx, row.sz],
        };
        let of_space = row.across();
        let contact = contacts.get(memory.len()).ok_or_else(strange)?;
        let normals = [
            across.get(memory.len()).map(|across| across.normal),
            of_space.map(|across| across.normal),
        ];
        let fits = (remembered.id1, remembered.id2, remembered.normal)
            == (contact.id1, contact.id2, contact.normal)
            && remembered.shear.iter().all(|force| force.is_finite())
            && normals[0] == normals[1];
        if !fits {
            return Err(strange());
        }
        memory.planar.push(remembered);
        memory.across.extend(of_space);
    }
    match memory.len() == contacts.len() {
        true => Ok(memory),
        false => Err(strange()),
    }
}

fn unlike(path: &Path, reason: impl Display) -> FileError {
    let path = path.display();
    FileError::Unfit(format!(
        "{path} is not a table of the expected columns: {reason}"
    ))
}

/// A line of CSV with its end.
pub fn csv_line(cells: impl IntoIterator<Item = impl AsRef<[u8]>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells).expect("memory takes it");
    let line = writer.into_inner().expect("memory takes it");
    String::from_utf8(line).expect("cells are text")
}

/// Writes rows under this header, which has their field names in order.
pub fn write_rows<'a, T: Serialize>(
    place: impl Into<Place<'a>>,
    header: &[&str],
    mut rows: impl Iterator<Item = T>,
) -> Result<(), FileError> {
    let place = place.into();
    let broken = |error: csv::Error| match error.into_kind() {
        csv::ErrorKind::Io(error) => failed("write", &place.path())(error),
        other => unlike(&place.path(), format_args!("{other:?}")),
    };
    // The header by hand: left to the writer, a table without rows would have none.
    let mut writer = csv::WriterBuilder::new();
    let mut writer = writer.has_headers(false).from_writer(Aside::of(place)?);
    let written = writer.write_record(header);
    let written = written.and_then(|()| rows.try_for_each(|row| writer.serialize(row)));
    written.map_err(broken)?;
    let whole = writer.into_inner();
    let whole = whole.map_err(|error| failed("write", &place.path())(error.into_error()))?;
    whole.into_place()
}

/// The rows of a table, one after the other, by the names in their header.
pub struct Rows<T> {
    path: PathBuf,
    lines: BufReader<Box<dyn Read>>,
    header: StringRecord,
    line: Vec<u8>,
    /// Lines so far.
    read: u64,
    rows: PhantomData<T>,
}

impl<T: DeserializeOwned> Rows<T> {
    /// At most so many.
    pub fn open<'a>(place: impl Into<Place<'a>>, most: u64) -> Result<Self, FileError> {
        let place = place.into();
        let limit = most.saturating_add(1).saturating_mul(LONGEST_ROW);
        Rows::of(&place.path(), Box::new(Stream::open(place, limit)?))
    }

    /// Of this text; `path` says where it comes from.
    pub fn of(path: &Path, text: Box<dyn Read>) -> Result<Self, FileError> {
        let mut rows = Rows {
            path: path.to_owned(),
            lines: BufReader::with_capacity(1 << 16, text),
            header: StringRecord::new(),
            line: Vec::new(),
            read: 0,
            rows: PhantomData,
        };
        rows.header = rows.next_record()?.unwrap_or_default();
        Ok(rows)
    }

    /// The next line that is not empty.
    fn next_record(&mut self) -> Result<Option<StringRecord>, FileError> {
        loop {
            self.line.clear();
            let mut bounded = (&mut self.lines).take(LONGEST_LINE);
            let read = bounded.read_until(b'\n', &mut self.line);
            if read.map_err(failed("read", &self.path))? == 0 {
                return Ok(None);
            }
            self.read += 1;
            let text = std::str::from_utf8(&self.line);
            let path = || self.path.clone();
            let text = text.map_err(|_| FileError::NotText { path: path() })?;
            // A file cut inside its last number would still parse.
            let Some(text) = text.strip_suffix('\n') else {
                let why = match self.line.len() as u64 {
                    LONGEST_LINE => {
                        format!("line {} is longer than {LONGEST_LINE} bytes", self.read)
                    }
                    _ => "its last line has no end; it was cut off".to_owned(),
                };
                return Err(unlike(&self.path, why));
            };
            let text = text.strip_suffix('\r').unwrap_or(text);
            if !text.is_empty() {
                // Some programs put names into quotes; numbers have none.
                let fields = text.split(',').map(|field| field.trim_matches('"'));
                let record: StringRecord = fields.collect();
                if record.iter().any(|field| field.contains('"')) {
                    let why = format!("line {} has a quote within a field", self.read);
                    return Err(unlike(&self.path, why));
                }
                return Ok(Some(record));
            }
        }
    }

    fn next_row(&mut self) -> Result<Option<T>, FileError> {
        let Some(record) = self.next_record()? else {
            return Ok(None);
        };
        let (found, wanted) = (record.len(), self.header.len());
        if found != wanted {
            let why = format!("line {} has {found} fields, its header {wanted}", self.read);
            return Err(unlike(&self.path, why));
        }
        let row = record.deserialize(Some(&self.header));
        row.map(Some).map_err(|error| {
            unlike(
                &self.path,
                format_args!("line {}: {}", self.read, why(&error)),
            )
        })
    }
}

/// Without the place, which the caller knows better.
fn why(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => err.to_string(),
        _ => error.to_string(),
    }
}

impl<T: DeserializeOwned> Iterator for Rows<T> {
    type Item = Result<T, FileError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_row().transpose()
    }
}
