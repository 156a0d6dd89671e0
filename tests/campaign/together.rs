//! Several processes on one folder: nothing is lost, nothing counts twice.

use crossgrain::study::{shard::Shard, store::Writer};

use super::{
    MEMBERS, Running, expected, finishes_as_expected, lines, merged_bytes, must, plan, records,
    study,
};

use crate::support::*;

#[test]
fn the_second_process_of_a_shard_is_told_to_try_again() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let file = records(&place.join("c"), "1/1");
    let mut first = Running::start(place, &["--threads", "1"]);
    first.wait_for_lines(&file, 1);
    let (_, errors) = study(place, 75, "run", &[]);
    has(&errors, ["is in use by another process"]);
    let (code, errors) = first.end();
    assert_eq!(code, 0, "{errors}");
    assert_eq!(lines(&file), MEMBERS as usize);
    finishes_as_expected(place);
}

/// The same without chance: this test holds the shard's file.
#[test]
fn the_second_process_changes_nothing() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let folder = place.join("c");
    must(place, "run", &["--shard", "2/3"]);
    let file = records(&folder, "2/3");
    let before = fs::read(&file).expect("records");
    let held = Writer::open(&folder, Shard::new(2, 3).expect("a shard")).expect("it is free");
    study(place, 75, "run", &["--shard", "2/3"]);
    // Another shard's file is free, and reading is too.
    must(place, "run", &["--shard", "1/3"]);
    study(place, 3, "status", &[]);
    assert_eq!(fs::read(&file).expect("records"), before);
    drop(held);
    must(place, "run", &["--shard", "2/3"]);
    finishes_as_expected(place);
}

/// Whoever shares a campaign out in two ways at the same time does work twice, and that is all.
#[test]
fn members_that_several_processes_made_count_once() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let shards = ["1/1", "1/2", "2/2"];
    let running = shards.map(|shard| Running::start(place, &["--shard", shard]));
    for process in running {
        let (code, errors) = process.end();
        assert_eq!(code, 0, "{errors}");
    }
    finishes_as_expected(place);
    // Each of them twice for certain.
    let folder = place.join("c");
    fs::remove_dir_all(folder.join("records")).expect("a folder");
    fs::create_dir(folder.join("records")).expect("writable");
    must(place, "run", &["--shard", "1/1", "--threads", "2"]);
    fs::copy(records(&folder, "1/1"), records(&folder, "7/9")).expect("writable");
    let said = must(place, "status", &[]);
    has(&said, ["24 of 24 rows finished", "24 lines repeat a row"]);
    must(place, "merge", &[]);
    assert_eq!(&merged_bytes(&folder), expected());
}
