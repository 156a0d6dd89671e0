//! Run folders as other programs read them.

use crossgrain::files::sha256_hex;

use crate::support::*;

/// A folder with a finished run `run`, with friction.
fn with_a_run() -> Place {
    let folder = folder_with(&frictional_scene());
    ran_in(&folder, "native", &[], "run");
    folder
}

/// The numbers of a data array.
fn array<T: std::str::FromStr>(text: &str, name: &str) -> Vec<T> {
    let at = text.find(&format!("Name=\"{name}\""));
    let at = at.unwrap_or_else(|| panic!("no array {name}"));
    let rest = &text[at..];
    let from = rest.find('>').expect("an end of the tag") + 1;
    let to = rest.find("</DataArray>").expect("an end of the array");
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{word}"));
    rest[from..to].split_whitespace().map(number).collect()
}

#[test]
fn vtk_files_hold_every_digit_of_the_run() {
    let folder = &with_a_run();
    let (out, _) = ends(folder, 0, "report vtk run --out vtk");
    let run = read_run(folder.join("run"));
    let read = |name: &str| {
        has(&out, [name]);
        text_of(folder.join("vtk").join(name))
    };
    let settled = run.settled.as_ref().expect("a settled bed");
    for (prefix, moment) in [("", &run.last), ("settled-", settled)] {
        let grains = read(&format!("{prefix}grains.vtp"));
        let points: Vec<f64> = array(&grains, "points");
        let x: Vec<f64> = points.iter().step_by(3).copied().collect();
        assert_eq!(x, moment.bodies.x);
        assert_eq!(array::<f64>(&grains, "radius"), moment.bodies.radius);
        let count = moment.bodies.len();
        let counts = format!("NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\"");
        has(&grains, [&counts]);
        let contacts = read(&format!("{prefix}contacts.vtp"));
        let forces: Vec<f64> = moment
            .contacts
            .iter()
            .map(|contact| contact.normal_force)
            .collect();
        assert_eq!(array::<f64>(&contacts, "normal_force"), forces);
        assert_eq!(array::<usize>(&contacts, "offsets").len(), forces.len());
        // The cells tile the box up to the highest grain.
        let cells = read(&format!("{prefix}cells.vtp"));
        let area: f64 = array::<f64>(&cells, "area").iter().sum();
        let box_area = run.scene.container.width * grains::measure::highest_grain(&moment.bodies);
        assert!((area / box_area - 1.0).abs() < 1e-9, "{area} {box_area}");
        let corners = array::<usize>(&cells, "connectivity");
        assert_eq!(corners, (0..corners.len()).collect::<Vec<_>>());
        let offsets = array::<usize>(&cells, "offsets");
        assert_eq!(offsets.last(), Some(&corners.len()));
    }
}

#[test]
fn an_archive_is_whole_described_and_the_same_each_time() {
    let folder = &with_a_run();
    let at = |name: &str| folder.join(name);
    let archive = ["report", "archive", "run", "--out", "one.tar.gz"];
    ends(folder, 0, &archive);
    assert_eq!(bash(folder, "tar xzf one.tar.gz", &[]).0, 0);
    let inside = at("one");
    assert_eq!(read_run(&inside), read_run(at("run")));
    let sums = text_of(inside.join("SHA256SUMS"));
    let mut summed = 0;
    for line in sums.lines() {
        let (sum, file) = line.split_once("  ").expect("a line");
        let bytes = fs::read(inside.join(file)).expect("a file");
        assert_eq!(sum, sha256_hex(&bytes), "{file}");
        summed += 1;
    }
    // Every file but the sums themselves.
    assert_eq!(summed + 1, there(&inside).len());
    let text = text_of(inside.join("ro-crate-metadata.json"));
    let value: Value = serde_json::from_str(&text).expect("JSON");
    let graph = value["@graph"].as_array().expect("a graph");
    let entity = |id: &str| {
        let found = graph.iter().find(|entity| entity["@id"] == id);
        found.unwrap_or_else(|| panic!("no {id}"))
    };
    for part in entity("./")["hasPart"].as_array().expect("parts") {
        let file = part["@id"].as_str().expect("an id");
        let bytes = fs::read(inside.join(file)).expect("a file");
        assert_eq!(entity(file)["sha256"], sha256_hex(&bytes));
    }
    // The same folder under the same name gives the same bytes.
    fs::create_dir(at("again")).expect("a folder");
    let again = ["report", "archive", "run", "--out", "again/one.tar.gz"];
    ends(folder, 0, &again);
    let bytes = |name: &str| fs::read(at(name)).expect("an archive");
    assert!(bytes("one.tar.gz") == bytes("again/one.tar.gz"));
    tells(folder, 2, &archive, ["exists already"]);
}

#[test]
fn a_damaged_folder_is_not_exported() {
    let folder = &with_a_run();
    let contacts = folder.join("run/contacts.csv");
    let text = text_of(&contacts);
    fs::write(&contacts, &text[..text.len() / 2]).expect("written");
    for (verb, out) in [("vtk", "vtk"), ("archive", "a.tar.gz")] {
        let export = format!("report {verb} run --out {out}");
        tells(folder, 2, &export, ["contacts.csv"]);
        assert!(!folder.join(out).exists(), "nothing half-written");
    }
}
