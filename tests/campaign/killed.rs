//! Killed, asked to end, or out of room: what was finished stays, what was half-written is not believed.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use super::{
    Chance, MEMBERS, Running, campaign, expected, finishes_as_expected, lines, merged_bytes, must,
    plan, records, undisturbed_in,
};
use crate::support::{has, tiny_scene, told};
use crossgrain::study::create;
use crossgrain::study::realization::Change::Settled;
use crossgrain::study::sensitivity::plan::Plan;

/// The whole lines of all record files.
fn written(folder: &Path) -> BTreeSet<Vec<u8>> {
    let mut lines = BTreeSet::new();
    for entry in fs::read_dir(folder.join("records")).expect("records") {
        let bytes = fs::read(entry.expect("a file").path()).expect("readable");
        let whole = bytes.split_inclusive(|byte| *byte == b'\n');
        lines.extend(
            whole
                .filter(|line| line.ends_with(b"\n"))
                .map(<[u8]>::to_vec),
        );
    }
    lines
}

/// Twenty times kill -9 of the study `c` at moments that chance chooses, with other shards and threads each time: it comes to
/// what an undisturbed one, planned by the same function, comes to. Moments are counted in rows and a little more, since
/// nobody knows how busy the machine is.
fn survives_kills(planned: impl Fn() -> tempfile::TempDir) {
    let place = planned();
    let folder = place.path().join("c");
    let mut chance = Chance(20);
    let mut before = BTreeSet::new();
    for kill in 0..20 {
        let (shard, threads) = [("1/1", "2"), ("1/2", "1"), ("3/3", "2")][chance.below(3) as usize];
        let file = records(&folder, shard);
        let wanted = lines(&file) + chance.below(4) as usize;
        let mut process = Running::start(place.path(), &["--shard", shard, "--threads", threads]);
        while lines(&file) < wanted && process.0.try_wait().expect("a child").is_none() {
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(Duration::from_millis(chance.below(60)));
        // A small shard may be done by now: then this would be no kill, and the whole is killed instead.
        if process.0.try_wait().expect("a child").is_some() {
            process = Running::start(place.path(), &["--shard", "1/1"]);
            std::thread::sleep(Duration::from_millis(chance.below(60)));
        }
        process.kill();
        let after = written(&folder);
        assert!(before.is_subset(&after), "kill {kill} lost a record");
        let (_, said, _) = campaign(place.path(), "status", &["--json"]);
        let status: serde_json::Value = serde_json::from_str(&said).expect("JSON");
        let finished = status["finished"].as_u64().expect("a number");
        // A torn line that a later process has ended is a whole line and no record; a record that stands twice is one.
        assert!(finished <= after.len() as u64, "{said}");
        before = after;
    }
    assert!(
        before.len() > 15,
        "{} records before the last kill",
        before.len()
    );
    must(place.path(), "run", &["--threads", "2"]);
    assert!(before.is_subset(&written(&folder)));
    assert_eq!(merged_bytes(&folder), undisturbed_in(&planned()));
}

#[test]
fn kills_at_any_moment_lose_nothing_finished_and_believe_nothing_half_written() {
    survives_kills(|| plan(&tiny_scene(), 120, "c"));
}

/// The machine is the same for every kind of study: here two settings of a sensitivity map.
#[test]
fn kills_of_another_kind_of_study_lose_nothing_either() {
    survives_kills(|| {
        let place = tempfile::tempdir().expect("a temporary folder");
        let mut plan = Plan::new(tiny_scene(), 60);
        plan.add("settle rule", "as-it-is", "as it is", 1.0e-4, 1, &[]);
        let early = [Settled(0.05)];
        plan.add("settle rule", "early", "hardly settled", 0.05, 1, &early);
        create(&place.path().join("c"), plan, None, None).expect("a new study");
        place
    });
}

#[test]
fn asked_to_end_it_ends_soon_and_goes_on_later() {
    let place = plan(&tiny_scene(), MEMBERS, "c");
    let folder = place.path().join("c");
    let mut process = Running::start(place.path(), &["--threads", "1"]);
    process.wait_for_lines(&records(&folder, "1/1"), 2);
    let asked = Instant::now();
    let told_so = Command::new("kill")
        .args(["-TERM", &process.0.id().to_string()])
        .status();
    assert!(told_so.expect("kill is there").success());
    let (code, errors) = process.end();
    assert_eq!(code, 75, "{errors}");
    assert!(
        asked.elapsed() < Duration::from_secs(5),
        "{:?}",
        asked.elapsed()
    );
    let finished = lines(&records(&folder, "1/1"));
    assert!(finished < MEMBERS as usize);
    let message = format!("asked to end; {finished} of {MEMBERS} rows are written down");
    has(&errors, [&message]);
    let said = must(place.path(), "run", &["--threads", "2"]);
    let goes_on = format!("{MEMBERS} rows, {finished} of them finished before");
    has(&said, [&goes_on]);
    assert_eq!(&merged_bytes(&folder), expected());
}

/// A file that may not grow any more stands for a full disk: the write fails in the middle of a record.
#[test]
fn a_full_disk_says_try_again_and_later_goes_on() {
    let place = plan(&tiny_scene(), MEMBERS, "c");
    let limited = |kilobytes: u32| {
        let script = format!("ulimit -f {kilobytes}; exec \"$0\" study run c --threads 2");
        let output = Command::new("bash")
            .args(["-c", &script, env!("CARGO_BIN_EXE_crossgrain")])
            .current_dir(place.path())
            .output();
        told(&output.expect("bash is there"))
    };
    let file = records(&place.path().join("c"), "1/1");
    for (kilobytes, at_least) in [(50, 1), (50, 1), (110, 3)] {
        let (code, _, errors) = limited(kilobytes);
        assert_eq!(code, 75, "{errors}");
        has(&errors, ["cannot write", "shard-1-of-1.jsonl"]);
        let size = fs::metadata(&file).expect("a file").len();
        assert_eq!(size, u64::from(kilobytes) * 1024, "it is full");
        assert!(lines(&file) >= at_least);
    }
    finishes_as_expected(place.path());
    // Room for the records, and none for merging them.
    for name in ["rows.jsonl", "rows.csv", "merged.json"] {
        fs::remove_file(place.path().join("c").join(name)).expect("a file");
    }
    let left = || {
        let entries = fs::read_dir(place.path().join("c")).expect("a folder");
        let names = entries.map(|entry| entry.expect("a file").file_name());
        names.collect::<BTreeSet<_>>()
    };
    let before = left();
    let (code, _, errors) = limited(100);
    assert_eq!(code, 75, "{errors}");
    assert_eq!(left(), before, "nothing half-merged");
    finishes_as_expected(place.path());
}
