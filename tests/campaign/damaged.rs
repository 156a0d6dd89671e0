//! Record files that were cut off, changed, or are of another campaign: not believed, named, and made good.

use crossgrain::study::campaign::{Campaign, Member};
use crossgrain::study::plan::Plan;

use super::{
    Chance, MEMBERS, expected, finishes_as_expected, merged_bytes, must, plan, record_line, study,
};

use crate::support::*;

const FILE: &str = "records/shard-1-of-1.jsonl";

/// The bytes of a finished record file, and what of a campaign with these bytes in it is reported.
struct Finished {
    place: Place,
    sound: Vec<u8>,
}

impl Finished {
    fn new() -> Self {
        let place = plan(&tiny_scene(), MEMBERS, "c");
        must(&place, "run", &["--threads", "2", "--shard", "1/1"]);
        let sound = fs::read(place.join("c").join(FILE)).expect("records");
        Finished { place, sound }
    }

    fn put(&self, bytes: &[u8]) {
        let folder = self.place.join("c");
        fs::write(folder.join(FILE), bytes).expect("writable");
        for name in ["rows.jsonl", "rows.csv", "merged.json"] {
            let _ = fs::remove_file(folder.join(name));
        }
    }

    /// The damaged lines that are told of these bytes, and how many rows are finished.
    fn status(&self, bytes: &[u8], code: i32) -> (Vec<u64>, u64) {
        self.put(bytes);
        let status = prints(&self.place, code, "study status c --json");
        let damaged = status["damaged"].as_array().expect("a list").iter();
        let line = |entry: &Value| {
            assert_eq!(entry[0], "shard-1-of-1.jsonl");
            entry[1].as_u64().expect("a line")
        };
        let finished = status["finished"].as_u64().expect("a number");
        (damaged.map(line).collect(), finished)
    }
}

/// Where the first line ends.
fn line_end(bytes: &[u8]) -> usize {
    let end = bytes.iter().position(|byte| *byte == b'\n');
    end.expect("a line")
}

/// Lines of these bytes that are no lines of the sound file: their numbers.
fn strange_lines(bytes: &[u8], sound: &[u8]) -> Vec<u64> {
    let known: Vec<&[u8]> = sound.split_inclusive(|byte| *byte == b'\n').collect();
    let lines = bytes.split_inclusive(|byte| *byte == b'\n').enumerate();
    lines
        .filter(|(_, line)| !known.contains(line) && *line != b"\n")
        .map(|(index, _)| index as u64 + 1)
        .collect()
}

/// Every way to cut is reported for what it is; a few are run to their end.
#[test]
fn a_file_that_was_cut_off_counts_to_its_last_whole_record() {
    let campaign_of = Finished::new();
    let sound = &campaign_of.sound;
    let mut chance = Chance(4);
    let newline = line_end(sound);
    let anywhere = |_| chance.below(sound.len() as u64) as usize;
    let mut cuts: Vec<usize> = (0..12).map(anywhere).collect();
    // Nothing, the first record without and with its end, all but the last end.
    cuts.extend([0, newline, newline + 1, sound.len() - 1]);
    for (index, cut) in cuts.into_iter().enumerate() {
        let bytes = &sound[..cut];
        let whole = bytes.iter().filter(|byte| **byte == b'\n').count();
        let told = (strange_lines(bytes, sound), whole as u64);
        assert_eq!(campaign_of.status(bytes, 3), told, "cut at {cut}");
        let place = &campaign_of.place;
        study(place, 3, "merge", &[]);
        if index % 4 == 0 {
            finishes_as_expected(place);
        }
    }
}

/// Bits that flipped, at random and where it hurts most: line ends, member numbers, checks, digits of numbers.
#[test]
fn a_changed_record_is_not_believed_and_its_member_is_run_again() {
    let campaign_of = Finished::new();
    let sound = &campaign_of.sound;
    let mut chance = Chance(5);
    let second = 1 + line_end(sound);
    let anywhere = |_| chance.below(sound.len() as u64) as usize;
    let mut places: Vec<usize> = (0..24).map(anywhere).collect();
    // A line's end, a digit of the check, the space after it, the member's number, the space, the JSON's first byte.
    places.extend([0, 4, 17, 18, 19, 20].map(|offset| second - 1 + offset));
    for (index, place) in places.into_iter().enumerate() {
        let mut bytes = sound.clone();
        bytes[place] ^= 1 << chance.below(8);
        let strange = strange_lines(&bytes, sound);
        assert!(!strange.is_empty());
        let (damaged, finished) = campaign_of.status(&bytes, 3);
        assert_eq!(damaged, strange, "byte {place}");
        // A line's end that is gone takes two records with it.
        let lost = if sound[place] == b'\n' { 2 } else { 1 };
        assert_eq!(finished, MEMBERS - lost, "byte {place}");
        let folder = &campaign_of.place;
        study(folder, 3, "merge", &[]);
        if index % 6 == 0 {
            let said = must(folder, "run", &["--threads", "2"]);
            let (file, line) = ("shard-1-of-1.jsonl", strange[0]);
            let words = format!("{file} line {line} is no whole row and is not believed");
            has(&said, [&words]);
            assert_eq!(&merged_bytes(&folder.join("c")), expected());
        }
    }
}

/// Bytes that are no text, and one line of 5 MB.
#[test]
fn rubbish_is_no_record() {
    let campaign_of = Finished::new();
    let mut chance = Chance(6);
    let mut bytes = campaign_of.sound.clone();
    bytes.extend((0..100_000).map(|_| chance.below(256) as u8));
    bytes.push(b'\n');
    bytes.extend(std::iter::repeat_n(b'x', 5_000_000));
    // Every member has its record.
    let (damaged, finished) = campaign_of.status(&bytes, 0);
    assert!(damaged.len() > 100 && finished == MEMBERS);
    finishes_as_expected(&campaign_of.place);
}

/// Of the first line.
fn member(bytes: &[u8]) -> Member {
    let text = std::str::from_utf8(&bytes[..line_end(bytes)]).expect("text");
    let (_, json) = text.split_once('{').expect("JSON");
    serde_json::from_str(&format!("{{{json}")).expect("a member")
}

/// A record that says something else with a sound check: somebody, or an engine, is wrong.
#[test]
fn records_that_contradict_each_other_are_an_error_that_names_both_files() {
    let campaign_of = Finished::new();
    let folder = campaign_of.place.join("c");
    campaign_of.put(&campaign_of.sound);
    let mut wrong = member(&campaign_of.sound);
    wrong.load_steps += 1;
    let number = wrong.member;
    let plan = Plan::<Campaign>::read(&folder).expect("a plan");
    let line = record_line(&plan.digest(), &wrong);
    fs::write(folder.join("records/shard-1-of-9.jsonl"), line).expect("writable");
    write_scene(&tiny_scene(), &campaign_of.place.join("scene.json"));
    let reuse = "study plan campaign scene.json --members 24 --reuse c --out larger";
    let refused = |words: &[&str]| {
        for verb in ["study merge c", "study report c", reuse] {
            let (_, errors) = ends(&campaign_of.place, 1, verb);
            for words in words {
                assert!(errors.contains(words), "{verb}: {errors}");
            }
        }
        assert!(!folder.join("merged.json").exists());
        assert!(!campaign_of.place.join("larger").exists());
    };
    let words = format!("row {number} is written twice and differently");
    refused(&[&words, "shard-1-of-1.jsonl", "shard-1-of-9.jsonl"]);
    // The same of a row of another engine, where no other row has its number.
    let first = line_end(&campaign_of.sound) + 1;
    campaign_of.put(&campaign_of.sound[first..]);
    wrong.engine = "another 1".to_owned();
    let line = record_line(&plan.digest(), &wrong);
    fs::write(folder.join("records/shard-1-of-9.jsonl"), line).expect("writable");
    refused(&["rows were made by different engines (another 1: 1, native"]);
}

/// The same scene from another seed has other members under the same numbers.
#[test]
fn records_of_another_plan_are_not_believed() {
    let campaign_of = Finished::new();
    let scene = tiny_scene();
    let place = &new_folder();
    let plan = Plan::<Campaign>::read(&campaign_of.place.join("c")).expect("a plan");
    let runner = plan.study.runner;
    let other = Campaign::new(&scene, runner, Vec::new(), MEMBERS, 2);
    let other = Plan::new(other, None).expect("a plan");
    other.write(&place.join("c")).expect("writable");
    let folder = place.join("c");
    fs::write(folder.join(FILE), &campaign_of.sound).expect("writable");
    let (said, _) = study(place, 3, "status", &[]);
    has(&said, ["0 of 24 rows finished"]);
    // Nor is a record of a member that the plan does not have.
    let mut beyond = member(&campaign_of.sound);
    beyond.member = MEMBERS + 1;
    let line = record_line(&other.digest(), &beyond);
    fs::write(folder.join(FILE), line).expect("writable");
    let (said, _) = study(place, 3, "status", &[]);
    has(&said, ["0 of 24 rows finished", "line 1 is no whole row"]);
}
