//! A run for other programs.
//!
//! For archives one packed file: its files, their checksums, and an RO-Crate description (version 1.1 of that specification)
//! that says what each of them is.
//!
//! For ParaView a bed as VTK PolyData (XML, ASCII, every number with all its digits): grains, contacts, cells. The plane is x and
//! z, where y is 0, as in the scene; look along y. Format: "VTK XML Formats" of VTK's documentation.

use std::io::{self, Read, Write};
use std::path::Path;

use flate2::{Compression, GzBuilder};
use serde_json::{Value, json};

use crate::files::{Aside, FileError, Heeding, Place, failed, file_digest, regular, sha256_hex};
use crate::run::folder::{FILES, Moment, RunFolder, SUMS, packed, sum_line};
use grains::measure::cells;
use grains::measure::stress::{Components, of_grains};
use grains::scene::Scene;
use grains::tables::BodyIds;
use grains::vector::{Vector, in_space};

/// The description in the archive.
const ABOUT: &str = "ro-crate-metadata.json";

/// Packs a run folder that was read and found whole, as tar.gz, under a folder of this name. The same folder gives the same bytes.
pub fn pack_archive(
    folder: &Path,
    run: &RunFolder,
    name: &str,
    to: &mut dyn Write,
) -> Result<(), FileError> {
    // Name, bytes and digest of what stands in the folder.
    let mut members: Vec<(String, u64, String)> = Vec::new();
    let mut parts = Vec::new();
    for &(file, words) in FILES.iter() {
        // The one that was read and found whole.
        let file = packed(folder, file);
        let place = Place::from((folder, &file));
        if !place.is_taken() {
            continue;
        }
        let kind = match file.rsplit_once('.') {
            Some((_, "json")) => "application/json",
            Some((_, "csv")) => "text/csv",
            Some((_, "gz")) => "application/gzip",
            _ => "text/plain",
        };
        let (bytes, digest) = (place.length(), file_digest(place)?);
        parts.push(json!({
            "@id": file, "@type": "File", "description": words, "encodingFormat": kind,
            "contentSize": bytes.to_string(), "sha256": digest,
        }));
        members.push((file, bytes, digest));
    }
    let about = description(run, name, parts);
    let about = serde_json::to_string_pretty(&about).expect("it is JSON") + "\n";
    let (bytes, digest) = (about.len() as u64, sha256_hex(about.as_bytes()));
    members.push((ABOUT.to_owned(), bytes, digest));
    members.sort();
    let sum = |(file, _, digest): &(String, u64, String)| sum_line(digest, file);
    let sums: String = members.iter().map(sum).collect();
    members.push((SUMS.to_owned(), sums.len() as u64, String::new()));
    // No time and no name in the head, so that the same folder gives the same bytes.
    let place = Path::new(name);
    let to = Heeding(to, place);
    let packed = GzBuilder::new().mtime(0).write(to, Compression::best());
    let mut archive = tar::Builder::new(packed);
    let mut add = |file: &str, bytes: u64, from: &mut dyn Read| {
        let mut head = tar::Header::new_ustar();
        head.set_size(bytes);
        head.set_mode(0o644);
        head.set_mtime(0);
        archive.append_data(&mut head, place.join(file), from.take(bytes))
    };
    for (file, bytes, _) in &members {
        let written = match file.as_str() {
            ABOUT => add(file, *bytes, &mut about.as_bytes()),
            SUMS => add(file, *bytes, &mut sums.as_bytes()),
            _ => add(file, *bytes, &mut regular((folder, file))?),
        };
        written.map_err(failed("write", place))?;
    }
    archive
        .into_inner()
        .and_then(|packed| packed.finish().map(drop))
        .map_err(failed("write", place))
}

fn description(run: &RunFolder, name: &str, parts: Vec<Value>) -> Value {
    let record = &run.record;
    let listed = parts.iter().map(|part| json!({"@id": part["@id"]}));
    let listed: Vec<Value> = listed.collect();
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json", "@type": "CreativeWork", "about": {"@id": "./"},
            "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
        }),
        json!({
            "@id": "./", "@type": "Dataset", "name": name,
            "description": format!("{}; scene {}, digest {}", record.engine.label(), run.scene.name, record.scene_digest),
            "hasPart": listed, "mentions": {"@id": "#run"},
        }),
        json!({
            "@id": "#run", "@type": "CreateAction", "name": run.stages_in_words(), "description": record.command,
            "instrument": [{"@id": "#crossgrain"}, {"@id": "#engine"}], "object": {"@id": "scene.json"},
            "result": listed,
        }),
        json!({
            "@id": "#crossgrain", "@type": "SoftwareApplication", "name": "crossgrain",
            "version": env!("CARGO_PKG_VERSION"),
        }),
        json!({
            "@id": "#engine", "@type": "SoftwareApplication", "name": record.engine.label(), "version": record.engine.version(),
        }),
    ];
    graph.extend(parts);
    json!({"@context": "https://w3id.org/ro/crate/1.1/context", "@graph": graph})
}

/// A column: its name, and what the element with this index has.
enum Column<'a> {
    One(&'static str, Box<dyn Fn(usize) -> f64 + 'a>),
    Vector(&'static str, Box<dyn Fn(usize) -> Vector + 'a>),
}

impl<'a> Column<'a> {
    fn one(name: &'static str, value: impl Fn(usize) -> f64 + 'a) -> Self {
        Column::One(name, Box::new(value))
    }

    fn vector(name: &'static str, value: impl Fn(usize) -> Vector + 'a) -> Self {
        Column::Vector(name, Box::new(value))
    }
}

/// Writes the files of a moment into this folder, three in the plane and in space two; their names.
pub fn write_vtk(
    folder: &Path,
    scene: &Scene,
    moment: &Moment,
    prefix: &str,
) -> Result<Vec<String>, FileError> {
    let kinds = ["grains", "contacts", "cells"];
    let kinds = if scene.in_space() {
        &kinds[..2]
    } else {
        &kinds
    };
    let names = Vec::from_iter(kinds.iter().map(|name| format!("{prefix}{name}.vtp")));
    for (name, fill) in names.iter().zip([grains, contacts, cells]) {
        let (mut file, path) = (Aside::of((folder, name))?, folder.join(name));
        let filled = fill(&mut Heeding(&mut file, &path), scene, moment);
        filled.map_err(failed("write", &path))?;
        file.into_place()?;
    }
    Ok(names)
}

/// Σ/V of every grain by its cell, Pa, compression positive, and the cells' areas, m².
fn stresses(scene: &Scene, moment: &Moment) -> (Vec<Components>, Vec<f64>) {
    let areas = cells::of(scene, &moment.bodies).area;
    let sums = of_grains(moment.bed());
    let over = |(sum, area): (&nalgebra::Matrix3<f64>, &f64)| Components::from(sum / *area);
    (sums.iter().zip(&areas).map(over).collect(), areas)
}

fn stress_columns(stress: &[Components]) -> [Column<'_>; 3] {
    [
        Column::one("stress_xx", |at| stress[at].xx),
        Column::one("stress_zz", |at| stress[at].zz),
        Column::one("stress_xz", |at| stress[at].xz),
    ]
}

fn contact_numbers(moment: &Moment) -> Vec<f64> {
    let mut numbers = vec![0.0; moment.bodies.len()];
    for contact in &moment.contacts {
        for id in [contact.id1, contact.id2] {
            if let Some(number) = numbers.get_mut(id as usize) {
                *number += 1.0;
            }
        }
    }
    numbers
}

/// A point a grain: radius, mass, velocity, stress, number of contacts.
fn grains(to: &mut dyn Write, scene: &Scene, moment: &Moment) -> io::Result<()> {
    let bodies = &moment.bodies;
    let planar = (!scene.in_space()).then(|| stresses(scene, moment));
    let contacts = contact_numbers(moment);
    let y = |column: &[f64], id: usize| column.get(id).copied().unwrap_or(0.0);
    let mut columns = vec![
        Column::one("id", |id| id as f64),
        Column::one("radius", |id| bodies.radius[id]),
        Column::one("mass", |id| bodies.mass[id]),
        Column::vector("velocity", |id| {
            [bodies.vx[id], y(&bodies.vy, id), bodies.vz[id]]
        }),
        Column::one("contacts", |id| contacts[id]),
    ];
    if let Some((_, areas)) = &planar {
        columns.push(Column::one("cell_area", |id| areas[id]));
    }
    match (bodies.rotate(), bodies.in_space()) {
        (false, _) => {}
        (true, false) => columns.push(Column::one("spin", |id| bodies.spin[id])),
        (true, true) => columns.push(Column::vector("spin", |id| {
            [bodies.spin_x[id], bodies.spin[id], bodies.spin_z[id]]
        })),
    }
    if let Some((stress, _)) = &planar {
        columns.extend(stress_columns(stress));
    }
    let points = Column::vector("points", |id| {
        [bodies.x[id], y(&bodies.y, id), bodies.z[id]]
    });
    let sizes = vec![1; bodies.len()];
    poly_data(to, (&points, &columns), "Verts", &sizes, &[])
}

/// A line a contact, from centre to centre, or from the contact point to the centre where one side is a wall or the punch.
fn contacts(to: &mut dyn Write, _: &Scene, moment: &Moment) -> io::Result<()> {
    let bodies = &moment.bodies;
    let ids = BodyIds::of(bodies);
    let centre = |id: u32| {
        let id = id as usize;
        let y = bodies.y.get(id).copied().unwrap_or(0.0);
        [bodies.x[id], y, bodies.z[id]]
    };
    let contacts = &moment.contacts;
    let point = |at: usize| {
        let [x, z] = contacts[at].point;
        let y = moment.across.get(at).map_or(0.0, |across| across.point);
        [x, y, z]
    };
    let end = |at: usize| {
        let contact = &contacts[at / 2];
        match [contact.id1, contact.id2][at % 2] {
            id if ids.is_grain(id) => centre(id),
            _ => point(at / 2),
        }
    };
    let forces: Vec<Vector> = moment.bed().forces().map(|(_, force)| force).collect();
    let columns = [
        Column::one("id1", |at| f64::from(contacts[at].id1)),
        Column::one("id2", |at| f64::from(contacts[at].id2)),
        Column::one("overlap", |at| contacts[at].overlap),
        Column::one("normal_force", |at| contacts[at].normal_force),
        Column::one("tangential_force", |at| contacts[at].tangential_force),
        Column::vector("force_on_id2", |at| forces[at]),
        Column::vector("contact_point", point),
    ];
    let (points, sizes) = (Column::vector("points", end), vec![2; contacts.len()]);
    poly_data(to, (&points, &[]), "Lines", &sizes, &columns)
}

/// A polygon a grain: its radical cell with the stress of the grain.
fn cells(to: &mut dyn Write, scene: &Scene, moment: &Moment) -> io::Result<()> {
    let (stress, areas) = stresses(scene, moment);
    let cells = cells::radical(scene, &moment.bodies).corners;
    let sizes: Vec<usize> = cells.iter().map(Vec::len).collect();
    let corners = cells.concat();
    drop(cells);
    let mut columns = vec![
        Column::one("id", |at| at as f64),
        Column::one("area", |at| areas[at]),
    ];
    columns.extend(stress_columns(&stress));
    let points = Column::vector("points", |at| in_space(corners[at]));
    poly_data(to, (&points, &[]), "Polys", &sizes, &columns)
}

/// Elements of this kind with so many points each, one after the other.
fn poly_data(
    to: &mut dyn Write,
    (points, of_points): (&Column<'_>, &[Column<'_>]),
    kind: &str,
    sizes: &[usize],
    of_elements: &[Column<'_>],
) -> io::Result<()> {
    let count = |wanted: &str| if kind == wanted { sizes.len() } else { 0 };
    let all_points: usize = sizes.iter().sum();
    write!(
        to,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n\
         <Piece NumberOfPoints=\"{all_points}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n\
         <Points>\n",
        count("Verts"),
        count("Lines"),
        count("Polys")
    )?;
    column(to, points, all_points)?;
    to.write_all(b"</Points>\n<PointData>\n")?;
    for data in of_points {
        column(to, data, all_points)?;
    }
    to.write_all(b"</PointData>\n<CellData>\n")?;
    for data in of_elements {
        column(to, data, sizes.len())?;
    }
    write!(to, "</CellData>\n<{kind}>\n")?;
    whole_numbers(to, "connectivity", 0..all_points)?;
    let ends = sizes.iter().scan(0, |end, size| {
        *end += size;
        Some(*end)
    });
    whole_numbers(to, "offsets", ends)?;
    write!(to, "</{kind}>\n</Piece>\n</PolyData>\n</VTKFile>\n")
}

fn column(to: &mut dyn Write, column: &Column<'_>, count: usize) -> io::Result<()> {
    let (name, components) = match column {
        Column::One(name, _) => (name, 1),
        Column::Vector(name, _) => (name, 3),
    };
    writeln!(
        to,
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    )?;
    for at in 0..count {
        match column {
            Column::One(_, value) => writeln!(to, "{:e}", value(at))?,
            Column::Vector(_, value) => {
                let [x, y, z] = value(at);
                writeln!(to, "{x:e} {y:e} {z:e}")?;
            }
        }
    }
    to.write_all(b"</DataArray>\n")
}

fn whole_numbers(
    to: &mut dyn Write,
    name: &str,
    values: impl Iterator<Item = usize>,
) -> io::Result<()> {
    writeln!(
        to,
        "<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">"
    )?;
    for value in values {
        writeln!(to, "{value}")?;
    }
    to.write_all(b"</DataArray>\n")
}
