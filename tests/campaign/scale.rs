//! How far a campaign carries: members that were never run, written as records of their plan, counted and merged in
//! bounded memory.

use std::io::{BufWriter, Write};

use crossgrain::study::Study;
use crossgrain::study::campaign::{Campaign, Member};
use crossgrain::study::folder::StudyFolder;
use crossgrain::study::realization::{Ending, Engines};

use super::{plan, record_line};

use crate::support::*;

/// One member run, and its copies under all other numbers in the files of so many shards.
fn fabricated(members: u64, shards: u64) -> Place {
    let place = plan(&tiny_scene(), members, "c");
    let folder = place.join("c");
    let open = StudyFolder::<Campaign>::open(&folder).expect("a campaign");
    let (plan, digest) = (&open.plan, open.plan.digest());
    let first = plan.study.run(1, &Engines::default(), Path::new(""));
    let mut member = first.expect("a member");
    for index in 1..=shards {
        let path = super::records(&folder, &format!("{index}/{shards}"));
        let mut file = BufWriter::new(fs::File::create(path).expect("writable"));
        for number in (index..=members).step_by(shards as usize) {
            (member.member, member.realization) = (number, plan.study.realization(number));
            write!(file, "{}", record_line(&digest, &member)).expect("room");
        }
        file.flush().expect("room");
    }
    place
}

/// Runs a verb and watches it: its output, seconds of processor time, and the high-water mark of its memory in bytes.
fn watched(place: &Path, arguments: &[&str]) -> (String, f64, u64) {
    let mut program = cli(place);
    program
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = program.spawn().expect("the program starts");
    let times = format!("/proc/{}/stat", child.id());
    let (mut peak, mut seconds) = (0, 0.0);
    while child.try_wait().expect("a child").is_none() {
        peak = peak.max(peak_memory(child.id()) * 1024);
        // Of the user and of the system, in hundredths of a second, after a name in brackets.
        let text = fs::read_to_string(&times).unwrap_or_default();
        let fields = text.rsplit(')').next().unwrap_or_default();
        let ticks = fields.split_whitespace().skip(11).take(2);
        let ticks: u64 = ticks.filter_map(|field| field.parse::<u64>().ok()).sum();
        seconds = f64::max(seconds, ticks as f64 / 100.0);
        std::thread::sleep(Duration::from_millis(2));
    }
    let (code, out, errors) = told(&child.wait_with_output().expect("an ended child"));
    assert_eq!(code, 0, "{arguments:?}: {out}{errors}");
    assert!(peak > 1_000_000, "its memory was not seen: {peak}");
    (out, seconds, peak)
}

/// Counts and merges so many members in no more than so much memory.
fn stays_small(members: u64, shards: u64, most: u64) {
    let place = &fabricated(members, shards);
    for verb in ["status", "merge"] {
        let (out, seconds, peak) = watched(place, &["study", verb, "c"]);
        println!("{verb} of {members} members: {seconds:.2} s of a processor, {peak} bytes");
        assert!(peak < most, "{verb}: {peak} bytes");
        let counted = match verb {
            "status" => format!("{members} of {members} rows finished"),
            _ => format!("merged {members} rows"),
        };
        has(&out, [&counted]);
    }
    let lines = fs::metadata(place.join("c/rows.jsonl")).expect("a file");
    println!("rows.jsonl: {} bytes", lines.len());
}

#[test]
fn merging_needs_little_memory() {
    stays_small(3_000, 7, 30_000_000);
}

/// The figures in `docs/campaigns.md`.
#[test]
#[ignore = "writes 4 GB of records and merges them, to measure how far a campaign carries"]
fn merging_a_hundred_thousand_members_needs_little_memory() {
    stays_small(100_000, 100, 60_000_000);
}

/// Full-size members, few of their steps: what is kept in memory is all there.
#[test]
fn running_needs_little_memory() {
    let mut scene = paper_scene(1, 5000);
    scene.settle.max_steps = 3_000;
    let place = &plan(&scene, 4, "c");
    let (out, _, peak) = watched(place, &["study", "run", "c", "--threads", "2"]);
    has(&out, ["4 did not settle"]);
    assert!(peak < 200_000_000, "{peak} bytes");
    // From the first member to the hundredth nothing is kept.
    let place = &plan(&tiny_scene(), 10, "c");
    let (_, _, few) = watched(place, &["study", "run", "c", "--threads", "1"]);
    let place = &plan(&tiny_scene(), 60, "c");
    let (_, _, many) = watched(place, &["study", "run", "c", "--threads", "1"]);
    assert!(many < few + 4_000_000, "{few} bytes, then {many}");
}

/// One real member of the paper's scene, both stages.
#[test]
fn a_whole_member_of_5000_grains_needs_little_memory() {
    let place = &plan(&paper_scene(1, 5000), 1, "c");
    let (_, _, peak) = watched(place, &["study", "run", "c"]);
    println!("a member of 5000 grains: {peak} bytes");
    assert!(peak < 200_000_000, "{peak} bytes");
    let line = text_of(place.join("c/rows.jsonl"));
    let member: Member = serde_json::from_str(&line).expect("a member");
    assert_eq!(member.ending, Ending::Reached);
    println!("its record: {} bytes", line.len());
}
