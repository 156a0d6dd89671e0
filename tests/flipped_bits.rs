//! One flipped bit in anything that the program has written is found when it is read, and the message names the file. Each bit
//! of a byte of every kind is tried: the first and the last, in a digit, in a separator, at a line's end, in between; of a short file all.

use crossgrain::checks::record;
use crossgrain::compare::baseline::{BaselineError, Store};
use crossgrain::study::campaign::{Campaign, merged};
use crossgrain::study::{folder::StudyFolder, plan::Plan, store::Index};

use crate::campaign::plan;
use crate::folder::{put, written};
use crate::readers::parts::packed;
use crate::support::*;

fn places(bytes: &[u8]) -> BTreeSet<usize> {
    let one = |is: fn(&u8) -> bool| bytes.iter().rposition(is);
    let line_end = bytes.iter().position(|byte| *byte == b'\n');
    let separator = one(|byte| b",: ".contains(byte));
    let (length, digit) = (bytes.len(), one(u8::is_ascii_digit));
    let found = [digit, separator, line_end].into_iter().flatten();
    let spread = (0..8).map(|part| length * part / 8).chain([length - 1]);
    let all = (0..length).filter(|_| length < 600);
    found.chain(spread).chain(all).collect()
}

/// Flips each such bit of the file and gives it to the reader, which says how it fails and with which exit code.
fn every_flip_is_found(file: &Path, wanted: u8, read: impl Fn() -> Option<(String, u8)>) {
    let sound = fs::read(file).expect("what was written");
    let name = file.file_name().expect("a name").to_string_lossy();
    assert!(read().is_none(), "{name} is refused as it is: {:?}", read());
    for at in places(&sound) {
        for bit in 0..8 {
            let mut bytes = sound.clone();
            bytes[at] ^= 1 << bit;
            fs::write(file, &bytes).expect("writable");
            let told = read();
            let (said, code) =
                told.unwrap_or_else(|| panic!("{name}: bit {bit} of byte {at} is believed"));
            let named = said.contains(&*name);
            assert!(named, "{name}, bit {bit} of byte {at}: {said}");
            assert_eq!(code, wanted, "{name}, bit {bit} of byte {at}: {said}");
        }
    }
    fs::write(file, sound).expect("writable");
}

#[test]
fn one_flipped_bit_in_a_run_folder_is_found() {
    let mut run = native_run(&frictional_scene(), sound(), Protocol::Whole);
    run.record.measures.truncate(3);
    run.log = "what it printed\n".to_owned();
    let (place, folder) = &written(&run);
    // One is packed, as those that the program carries are.
    let table = folder.join("settled-contacts.csv");
    let bytes = packed(&fs::read(&table).expect("a table"));
    fs::remove_file(&table).expect("removable");
    put(&table.with_extension("csv.gz"), bytes);
    assert_eq!(read_run(folder), run);
    let files = there(folder);
    assert_eq!(files.len(), 13, "{files:?}");
    for name in &files {
        every_flip_is_found(&folder.join(name), 2, || {
            let error = RunFolder::read(folder).err()?;
            Some((error.to_string(), error.exit_code()))
        });
    }
    // Whichever verb reads it.
    let memory = folder.join("memory.csv");
    let mut bytes = fs::read(&memory).expect("a table");
    bytes[60] ^= 1;
    fs::write(&memory, bytes).expect("writable");
    for verb in [
        "compare run run",
        "report vtk run --out o",
        "report archive run --out o",
        "run run/scene.json --engine native --from-state run --out o",
    ] {
        let (_, errors) = ends(place, 2, verb);
        has(&errors, ["memory.csv was changed"]);
        assert_eq!(errors.lines().count(), 1, "{errors}");
        assert_eq!(there(place).len(), 1, "{verb}");
    }
}

#[test]
fn one_flipped_bit_in_a_study_its_record_or_a_baseline_is_found() {
    let place = &plan(&tiny_scene(), 2, "c");
    let folder = place.join("c");
    ends(place, 0, "study run c --quiet");
    let open = || StudyFolder::<Campaign>::open(&folder).map(drop);
    let merged = || merged(&folder).map(drop);
    let readers: [(&str, &dyn Fn() -> Result<(), _>); 3] = [
        ("plan.json", &open),
        ("rows.jsonl", &merged),
        ("merged.json", &merged),
    ];
    for (name, read) in readers {
        let error = || read().err();
        let told = || error().map(|error| (error.to_string(), error.exit_code()));
        every_flip_is_found(&folder.join(name), 2, told);
    }
    // Its row is made again, so it is no error: `campaign::damaged`.
    let digest = Plan::<Campaign>::read(&folder).expect("a plan").digest();
    every_flip_is_found(&folder.join("records/shard-1-of-1.jsonl"), 0, || {
        let index = Index::read(&folder, &digest, 2).expect("readable");
        let named = index.damaged.first();
        let named = named.map(|(path, _)| path.display().to_string());
        (index.places.len() < 2).then(|| (named.unwrap_or_default(), 0))
    });
    let report: PathBuf = folder.join("report.json");
    every_flip_is_found(&report, 2, || {
        let error = record::read(&report).err();
        error.map(|error| (error.to_string(), error.exit_code()))
    });
    let store = Store::new(&place.join("kept"));
    let baseline = store.save(&report, "main", false).expect("writable");
    every_flip_is_found(&baseline, 2, || {
        let error = store.load("main").err()?;
        let code = match &error {
            BaselineError::File(error) => error.exit_code(),
            _ => 2,
        };
        Some((error.to_string(), code))
    });
    ends(place, 0, "report checks c/report.json");
}
