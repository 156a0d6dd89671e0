//! Run folders. Where the input has a part `repair`, the digests that tie its files together are put right first: else
//! nearly every change would end at them.

use std::path::Path;

use crossgrain::run::folder::{RunFolder, write_sums};
use crossgrain::tables::{Rows, read_bodies, write_rows};
use grains::measure::HistoryRow;
use grains::scene::parse_scene;
use grains::tables::Stage;

use super::parts::{self, Parts};

/// Every file that a run folder may have.
pub const FILES: [&str; 14] = [
    "scene.json",
    "run.json",
    "initial.csv",
    "initial.csv.gz",
    "bodies.csv",
    "contacts.csv",
    "contacts.csv.gz",
    "settled-bodies.csv",
    "settled-contacts.csv",
    "history.csv",
    "history.csv.gz",
    "trace.csv",
    "yade.log",
    "engine.log",
];

/// A folder that is accepted reads back as itself.
pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    let folder = parts::folder();
    let place = folder.path().join("run");
    std::fs::create_dir(&place).expect("a folder in a folder of ours");
    parts.write(&FILES, &place);
    if parts.get("repair").is_some() {
        repair(&parts, &place);
    }
    // Digests of whole files would let nothing through.
    write_sums(&place).expect("a folder of ours");
    let Ok(run) = RunFolder::read(&place) else {
        return false;
    };
    let again = folder.path().join("again");
    run.write(&again).expect("a run that can be written");
    assert_eq!(
        RunFolder::read(&again).expect("what was accepted once"),
        run
    );
    assert!(!run.stages_in_words().contains('\n'));
    true
}

/// Puts the digests right that can be put right; gives up quietly where the files are no such files.
fn repair(parts: &Parts<'_>, folder: &Path) -> Option<()> {
    let scene = parse_scene(parts.text("scene.json")?).ok()?;
    let mut record: serde_json::Value = serde_json::from_str(parts.text("run.json")?).ok()?;
    let grains = |name: &str| read_bodies(&folder.join(name), scene.particles.count).ok();
    let object = record.as_object_mut()?;
    object.insert("scene_digest".to_owned(), scene.digest().into());
    object.insert("time_step".to_owned(), scene.time_step_seconds().into());
    if let Some(initial) = grains("initial.csv") {
        object.insert("initial_digest".to_owned(), initial.digest().into());
    }
    parts::put(folder, "run.json", record.to_string().as_bytes());
    let path = folder.join("history.csv");
    let history = Rows::open(&path, 1 << 20).ok()?.collect();
    let mut history: Vec<HistoryRow> = Result::ok(history)?;
    let settled = history.iter().rposition(|row| row.stage == Stage::Settle);
    let loading = history.iter().position(|row| row.stage == Stage::Load);
    let end = history.len().checked_sub(1);
    let ties = [
        (Some(0), "initial.csv"),
        (settled, "settled-bodies.csv"),
        (loading, "settled-bodies.csv"),
        (end, "bodies.csv"),
    ];
    for (row, table) in ties {
        if let (Some(grains), Some(row)) = (grains(table), row.and_then(|at| history.get_mut(at))) {
            row.state = grains.digest();
        }
    }
    write_rows(&path, HistoryRow::HEADER, history.iter()).ok()
}
