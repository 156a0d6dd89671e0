//! A run for other programs.
//!
//! For archives one packed file: its files, their checksums, and an RO-Crate description (version 1.1 of that specification)
//! that says what each of them is.
//!
//! For ParaView a bed as VTK PolyData (XML, ASCII, every number with all its digits): grains, contacts, cells. The plane is x and
//! z, y is 0, as in the scene; look along y. Format: "VTK XML Formats" of VTK's documentation.

use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::Path;

use flate2::{Compression, GzBuilder};
use serde_json::{Value, json};

use crate::files::{FileError, failed, sha256_hex};
use crate::run::folder::{FILES, Moment, RunFolder, SUMS, sum_line};
use grains::measure::cells;
use grains::measure::stress::{Components, of_grains};
use grains::scene::Scene;
use grains::tables::{Bodies, BodyIds, Contact};

/// Longest file that is packed, bytes.
const LONGEST: u64 = 2_000_000_000;

/// Packs a run folder that was read and found whole, as tar.gz, under a folder of this name. The same folder gives the same bytes.
pub fn pack_archive(
    folder: &Path,
    run: &RunFolder,
    name: &str,
    to: &mut dyn Write,
) -> Result<(), FileError> {
    let mut members: Vec<(String, Vec<u8>)> = Vec::new();
    let mut parts = Vec::new();
    for (file, words) in FILES {
        for file in [file.to_owned(), format!("{file}.gz")] {
            let path = folder.join(&file);
            let kind = match path.extension().and_then(|end| end.to_str()) {
                Some("json") => "application/json",
                Some("csv") => "text/csv",
                Some("gz") => "application/gzip",
                _ => "text/plain",
            };
            let Ok(about) = fs::metadata(&path) else {
                continue;
            };
            if about.len() > LONGEST {
                let limit = LONGEST;
                return Err(FileError::TooLarge { path, limit });
            }
            let bytes = fs::read(&path).map_err(failed("read", &path))?;
            parts.push(json!({
                "@id": file, "@type": "File", "description": words, "encodingFormat": kind,
                "contentSize": bytes.len().to_string(), "sha256": sha256_hex(&bytes),
            }));
            members.push((file, bytes));
        }
    }
    let crate_text =
        serde_json::to_string_pretty(&description(run, name, parts)).unwrap_or_default() + "\n";
    members.push(("ro-crate-metadata.json".to_owned(), crate_text.into_bytes()));
    members.sort();
    let sum = |(file, bytes): &(String, Vec<u8>)| sum_line(&sha256_hex(bytes), file);
    let sums: String = members.iter().map(sum).collect();
    members.push((SUMS.to_owned(), sums.into_bytes()));
    // No time and no name in the head, so that the same folder gives the same bytes.
    let packed = GzBuilder::new().mtime(0).write(to, Compression::best());
    let mut archive = tar::Builder::new(packed);
    let place = Path::new(name);
    let written = members.iter().try_for_each(|(file, bytes)| {
        let mut head = tar::Header::new_ustar();
        head.set_size(bytes.len() as u64);
        head.set_mode(0o644);
        head.set_mtime(0);
        archive.append_data(&mut head, place.join(file), bytes.as_slice())
    });
    written
        .and_then(|()| archive.into_inner()?.finish().map(|_| ()))
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

/// A column: its name, how many numbers an element has, and the numbers.
type Column = (&'static str, usize, Vec<f64>);

fn vector(name: &'static str, values: impl Iterator<Item = [f64; 2]>) -> Column {
    let values = values.flat_map(|[x, z]| [x, 0.0, z]);
    (name, 3, values.collect())
}

/// The three files of a moment, as name and text.
pub fn vtk_files(scene: &Scene, moment: &Moment, prefix: &str) -> [(String, String); 3] {
    [
        (format!("{prefix}grains.vtp"), grains(scene, moment)),
        (format!("{prefix}contacts.vtp"), contacts(moment)),
        (format!("{prefix}cells.vtp"), cells(scene, moment)),
    ]
}

/// Σ/V of every grain by its cell, Pa, compression positive, and the cells' areas, m².
fn stresses(scene: &Scene, moment: &Moment) -> (Vec<Components>, Vec<f64>) {
    let areas = cells::of(scene, &moment.bodies).area;
    let sums = of_grains(moment.bed());
    let over = |(sum, area): (&nalgebra::Matrix2<f64>, &f64)| Components::from(sum / *area);
    (sums.iter().zip(&areas).map(over).collect(), areas)
}

fn stress_columns(of: &[Components]) -> [Column; 3] {
    [
        ("stress_xx", 1, of.iter().map(|of| of.xx).collect()),
        ("stress_zz", 1, of.iter().map(|of| of.zz).collect()),
        ("stress_xz", 1, of.iter().map(|of| of.xz).collect()),
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
fn grains(scene: &Scene, moment: &Moment) -> String {
    let bodies = &moment.bodies;
    let pairs =
        |of: fn(&Bodies, usize) -> [f64; 2]| (0..bodies.len()).map(move |id| of(bodies, id));
    let points: Vec<[f64; 2]> = pairs(|of, id| [of.x[id], of.z[id]]).collect();
    let (stress, areas) = stresses(scene, moment);
    let mut columns = vec![
        ("id", 1, (0..bodies.len()).map(|id| id as f64).collect()),
        ("radius", 1, bodies.radius.clone()),
        ("mass", 1, bodies.mass.clone()),
        vector("velocity", pairs(|of, id| [of.vx[id], of.vz[id]])),
        ("contacts", 1, contact_numbers(moment)),
        ("cell_area", 1, areas),
    ];
    if !bodies.spin.is_empty() {
        columns.push(("spin", 1, bodies.spin.clone()));
    }
    columns.extend(stress_columns(&stress));
    poly_data(&points, &columns, "Verts", &vec![1; points.len()], &[])
}

/// A line a contact, from centre to centre, or from the contact point to the centre where one side is a wall or the punch.
fn contacts(moment: &Moment) -> String {
    let bodies = &moment.bodies;
    let ids = BodyIds::of_box(bodies.len() as u32);
    let centre = |id: u32| [bodies.x[id as usize], bodies.z[id as usize]];
    let of = &moment.contacts;
    let ends = of.iter().flat_map(|contact| {
        let first = match ids.is_grain(contact.id1) {
            true => centre(contact.id1),
            false => contact.point,
        };
        [first, centre(contact.id2)]
    });
    let points: Vec<[f64; 2]> = ends.collect();
    let number = |name, part: fn(&Contact) -> f64| (name, 1, of.iter().map(part).collect());
    let columns = [
        number("id1", |contact| f64::from(contact.id1)),
        number("id2", |contact| f64::from(contact.id2)),
        number("overlap", |contact| contact.overlap),
        number("normal_force", |contact| contact.normal_force),
        number("tangential_force", |contact| contact.tangential_force),
        vector("force_on_id2", of.iter().map(|contact| contact.force())),
        vector("contact_point", of.iter().map(|contact| contact.point)),
    ];
    poly_data(&points, &[], "Lines", &vec![2; of.len()], &columns)
}

/// A polygon a grain: its radical cell with the stress of the grain.
fn cells(scene: &Scene, moment: &Moment) -> String {
    let cells = cells::radical(scene, &moment.bodies);
    let (stress, areas) = stresses(scene, moment);
    let points: Vec<[f64; 2]> = cells.corners.iter().flatten().copied().collect();
    let corners: Vec<usize> = cells.corners.iter().map(Vec::len).collect();
    let mut columns = vec![
        (
            "id",
            1,
            (0..cells.corners.len()).map(|id| id as f64).collect(),
        ),
        ("area", 1, areas),
    ];
    columns.extend(stress_columns(&stress));
    poly_data(&points, &[], "Polys", &corners, &columns)
}

/// Elements of this kind with so many points each, one after the other.
fn poly_data(
    points: &[[f64; 2]],
    of_points: &[Column],
    kind: &str,
    sizes: &[usize],
    of_elements: &[Column],
) -> String {
    let count = |wanted: &str| if kind == wanted { sizes.len() } else { 0 };
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
        points.len(),
        count("Verts"),
        count("Lines"),
        count("Polys")
    );
    let places = vector("points", points.iter().copied());
    text += "<Points>\n";
    column(&mut text, &places);
    text += "</Points>\n<PointData>\n";
    of_points.iter().for_each(|of| column(&mut text, of));
    text += "</PointData>\n<CellData>\n";
    of_elements.iter().for_each(|of| column(&mut text, of));
    text += "</CellData>\n";
    text += &format!("<{kind}>\n");
    whole_numbers(&mut text, "connectivity", 0..points.len());
    let ends = sizes.iter().scan(0, |end, size| {
        *end += size;
        Some(*end)
    });
    whole_numbers(&mut text, "offsets", ends);
    text + &format!("</{kind}>\n</Piece>\n</PolyData>\n</VTKFile>\n")
}

fn column(text: &mut String, (name, components, values): &Column) {
    *text += &format!(
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">\n"
    );
    for row in values.chunks(*components) {
        let row: Vec<String> = row.iter().map(|value| format!("{value:e}")).collect();
        *text += &row.join(" ");
        text.push('\n');
    }
    *text += "</DataArray>\n";
}

fn whole_numbers(text: &mut String, name: &str, values: impl Iterator<Item = usize>) {
    *text += &format!("<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">\n");
    for value in values {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{value}");
    }
    *text += "</DataArray>\n";
}
