//! A run folder as one packed file for an archive: its files, their checksums, and an RO-Crate description (version 1.1 of
//! that specification) that says what each of them is.

use std::fs;
use std::io::Write;
use std::path::Path;

use flate2::{Compression, GzBuilder};
use serde_json::{Value, json};

use crate::files::{FileError, failed, sha256_hex};
use crate::run::folder::RunFolder;

/// Files of a run folder, and what they are.
const FILES: [(&str, &str, &str); 11] = [
    ("scene.json", "application/json", "The scene that was run"),
    (
        "run.json",
        "application/json",
        "Provenance: engine, versions, digests, time step, stages, measures, command",
    ),
    (
        "initial.csv",
        "text/csv",
        "Grains at the start: id, position, velocity, radius, mass",
    ),
    ("bodies.csv", "text/csv", "Grains at the end"),
    (
        "contacts.csv",
        "text/csv",
        "Contacts at the end: overlap, forces, normal, point",
    ),
    (
        "settled-bodies.csv",
        "text/csv",
        "Grains of the settled bed",
    ),
    (
        "settled-contacts.csv",
        "text/csv",
        "Contacts of the settled bed",
    ),
    (
        "history.csv",
        "text/csv",
        "Energies, unbalanced force, contacts, punch, and a digest of the state, along the way",
    ),
    ("trace.csv", "text/csv", "Paths of marked grains"),
    ("yade.log", "text/plain", "What YADE printed"),
    ("engine.log", "text/plain", "What the engine printed"),
];

/// Longest file that is packed, bytes.
const LONGEST: u64 = 2_000_000_000;

/// Packs a run folder that was read and found whole, as tar.gz, under a folder of this name. The same folder gives the same bytes.
pub fn pack(
    folder: &Path,
    run: &RunFolder,
    name: &str,
    to: &mut dyn Write,
) -> Result<(), FileError> {
    let mut members: Vec<(String, Vec<u8>)> = Vec::new();
    let mut parts = Vec::new();
    for (file, kind, words) in FILES {
        for (file, kind) in [
            (file.to_owned(), kind),
            (format!("{file}.gz"), "application/gzip"),
        ] {
            let path = folder.join(&file);
            let Ok(about) = fs::metadata(&path) else {
                continue;
            };
            if about.len() > LONGEST {
                return Err(FileError::TooLarge {
                    path: path.clone(),
                    limit: LONGEST,
                });
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
    let sums: String = members
        .iter()
        .map(|(file, bytes)| format!("{}  {file}\n", sha256_hex(bytes)))
        .collect();
    members.push(("SHA256SUMS".to_owned(), sums.into_bytes()));
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
    let listed: Vec<Value> = parts
        .iter()
        .map(|part| json!({"@id": part["@id"]}))
        .collect();
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
