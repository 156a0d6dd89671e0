//! `python/crossgrain.py`: what Python reads has the bits of the files, and what was changed is refused. Without the feature
//! `live` this is listed as ignored and not made; with it missing numpy or pandas is a failure. `ci/install_python` installs
//! Debian's.

use crossgrain::files::read_text;
use crossgrain::run::folder::write_sums;

use crate::folder::{put, written};
use crate::support::*;

/// Runs these lines after the import, with `path` as the path: exit code, output, errors.
fn run(path: &Path, lines: &str) -> (i32, String, String) {
    let script = format!("import json, sys\nimport crossgrain\npath = sys.argv[1]\n{lines}");
    python("/usr/bin/python3", &root("python"), &script, &[path])
}

/// What the lines print as JSON.
fn printed(path: &Path, lines: &str) -> Value {
    let (code, out, errors) = run(path, lines);
    assert_eq!(code, 0, "{errors}");
    serde_json::from_str(&out).expect("JSON")
}

/// The one sentence that reading ends with.
fn refused(path: &Path, reader: &str) -> String {
    let lines = format!(
        "try:\n    crossgrain.{reader}(path)\nexcept crossgrain.CrossgrainError as error:\n    print(error)\nelse:\n    sys.exit('read')"
    );
    let (code, out, errors) = run(path, &lines);
    assert_eq!(code, 0, "{errors}");
    assert_eq!(out.lines().count(), 1, "{out}");
    out
}

fn folder_with_run() -> (Place, PathBuf, RunFolder) {
    let run = native_run(&frictional_scene(), sound(), Protocol::Whole);
    let (folder, path) = written(&run);
    (folder, path, run)
}

/// Bits as numbers that JSON keeps.
fn bits<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Value {
    let bits = numbers
        .into_iter()
        .map(|number| number.to_bits().to_string());
    Value::from(bits.collect::<Vec<_>>())
}

const BITS: &str = "
def bits(of):
    import numpy
    return [str(one) for one in numpy.ascontiguousarray(of, dtype=float).ravel().view(numpy.uint64)]
";

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs numpy: --features live")]
fn a_run_folder_is_read_to_the_bit() {
    let (_folder, path, run) = folder_with_run();
    let lines = format!(
        "{BITS}
run = crossgrain.read_run(path)
json.dump(dict(
    positions=bits(run.positions), velocities=bits(run.velocities), radii=bits(run.radii), masses=bits(run.masses),
    spins=bits(run.table('bodies')['spin']), forces=bits(run.table('contacts')[['fn', 'ft']]),
    memory=len(run.table('memory')), states=list(run.table('history')['state']), depths=int(run.table('history')['punch_depth'].count()),
    measures=bits(run.measures), keys=list(run.measures.index), shapes=[run.positions.shape, run.fabric.shape],
    fabric=bits(run.fabric), scene=run.scene), sys.stdout)"
    );
    let found = printed(&path, &lines);
    let bodies = &run.last.bodies;
    let pair = |(x, z): (&f64, &f64)| [*x, *z];
    let pairs = |x: &[f64], z: &[f64]| x.iter().zip(z).flat_map(pair).collect::<Vec<f64>>();
    let contacts = &run.last.contacts;
    let forces = contacts
        .iter()
        .flat_map(|contact| [contact.normal_force, contact.tangential_force]);
    let forces: Vec<f64> = forces.collect();
    let measures: Vec<f64> = run
        .record
        .measures
        .iter()
        .map(|measure| measure.value)
        .collect();
    for (name, expected) in [
        ("positions", pairs(&bodies.x, &bodies.z)),
        ("velocities", pairs(&bodies.vx, &bodies.vz)),
        ("radii", bodies.radius.clone()),
        ("masses", bodies.mass.clone()),
        ("spins", bodies.spin.clone()),
        ("forces", forces),
        ("measures", measures),
    ] {
        assert!(!expected.is_empty(), "{name}");
        assert_eq!(found[name], bits(&expected), "{name}");
    }
    assert_eq!(found["memory"], run.last.memory.len());
    let states: Vec<&str> = run.history.iter().map(|row| row.state.as_str()).collect();
    assert_eq!(found["states"], json!(states));
    let depths = run.history.iter().filter(|row| row.punch_depth.is_some());
    assert_eq!(found["depths"], depths.count());
    assert_eq!(found["shapes"], json!([[bodies.x.len(), 2], [2, 2]]));
    assert_eq!(found["scene"], json_of(path.join("scene.json")));
    let number =
        |value: &Value| f64::from_bits(value.as_str().expect("bits").parse().expect("a number"));
    let fabric = found["fabric"].as_array().expect("a list").iter();
    let fabric: Vec<f64> = fabric.map(number).collect();
    let by_hand = |a: usize, b: usize| {
        let sum: f64 = contacts
            .iter()
            .map(|contact| contact.normal[a] * contact.normal[b])
            .sum();
        sum / contacts.len() as f64
    };
    for (at, [a, b]) in [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().enumerate() {
        assert!((fabric[at] - by_hand(a, b)).abs() < 1e-12, "{fabric:?}");
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs numpy: --features live")]
fn packed_tables_are_read_and_changed_ones_refused() {
    let (folder, path, run) = folder_with_run();
    assert_eq!(bash(&path, "gzip -9n bodies.csv", &[]).0, 0);
    let lines = format!("{BITS}\njson.dump(bits(crossgrain.read_run(path).radii), sys.stdout)");
    assert_eq!(printed(&path, &lines), bits(&run.last.bodies.radius));
    // Digests of the packed file, as recorded runs have them.
    write_sums(&path).expect("writable");
    assert_eq!(printed(&path, &lines), bits(&run.last.bodies.radius));

    // All digests of a short table may look like numbers.
    let history = path.join("history.csv");
    let text = text_of(&history).replace(&run.history[0].state, "0012345678901234");
    let first: Vec<&str> = text.lines().take(2).collect();
    put(&history, first.join("\n"));
    let states = "json.dump(crossgrain.read_run(path).table('history')['state'][0], sys.stdout)";
    assert_eq!(printed(&path, states), "0012345678901234");

    let contacts = path.join("contacts.csv");
    let mut bytes = fs::read(&contacts).expect("a table");
    let at = bytes.len() - 5;
    bytes[at] ^= 1;
    fs::write(&contacts, bytes).expect("writable");
    let words = "contacts.csv was changed after it was written";
    has(&refused(&path, "read_run"), [words]);
    fs::remove_file(&contacts).expect("a table");
    has(&refused(&path, "read_run"), ["contacts.csv does not exist"]);
    has(&refused(&folder, "read_run"), ["is no run folder"]);
    let words = "is no record of a job";
    has(&refused(&path.join("run.json"), "read_record"), [words]);
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs numpy: --features live")]
fn records_and_rows_are_read() {
    let at = &new_folder();
    let recorded = root("reference_data");
    let record = at.join("report.json");
    let text = read_text(&recorded.join("search-1/wave-2/report.json.gz"), 1 << 24);
    let text = text.expect("a recorded study");
    fs::write(&record, &text).expect("writable");
    let written = json_of(&record);
    let lines = "of = crossgrain.read_record(path)\njson.dump([of.verdict, list(of.checks['id']), list(of.checks['outcome'])], sys.stdout)";
    let found = printed(&record, lines);
    let column = |key: &str| {
        let checks = written["checks"].as_array().expect("checks").iter();
        Value::from(checks.map(|check| check[key].clone()).collect::<Vec<_>>())
    };
    assert!(column("id").as_array().is_some_and(|ids| !ids.is_empty()));
    let wanted = json!([written["verdict"], column("id"), column("outcome")]);
    assert_eq!(found, wanted);
    fs::write(&record, text.replacen("pass", "fail", 1)).expect("writable");
    let words = "was changed after it was written";
    has(&refused(&record, "read_record"), [words]);

    let campaign = recorded.join("campaign-native-1");
    let lines = "rows = crossgrain.read_rows(path)\njson.dump([len(rows), list(rows['ending'])[0], rows['measured.settled.height.mean_surface'][0].hex()], sys.stdout)";
    let found = printed(&campaign, lines);
    let first = crossgrain::study::campaign::merged(&campaign);
    let first = first.expect("recorded").rows;
    let height = first[0].measured["settled.height.mean_surface"];
    assert_eq!(found[0], first.len());
    assert_eq!(found[1], "reached");
    let hex = found[2].as_str().expect("text").to_owned();
    let (code, out, _) = run(at, &format!("print(repr(float.fromhex('{hex}')))"));
    assert_eq!((code, out.trim().parse()), (0, Ok(height)));
    let wrong = at.join("wrong");
    fs::create_dir(&wrong).expect("writable");
    fs::write(wrong.join("merged.json"), "{\"sha256\": \"0\"}").expect("writable");
    fs::write(wrong.join("rows.jsonl"), "{}\n").expect("writable");
    let words = "is not what merged.json says";
    has(&refused(&wrong, "read_rows"), [words]);
}
