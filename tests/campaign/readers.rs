//! Verbs that read a merged campaign: what they say of one that is not merged, damaged or none, and that nothing is
//! written then.

use super::{must, plan};

use crate::support::*;

/// What each verb says of the campaign `c` in its errors. None of them writes `drawn`.
fn all_say<const N: usize>(place: &Path, code: i32, words: [&str; N]) {
    for verb in [
        "study claims c --out drawn",
        "study figures --campaign c --out drawn",
        "study compare c c",
    ] {
        let (out, errors) = ends(place, code, verb);
        assert_eq!(out, "", "{verb}");
        assert!(!place.join("drawn").exists(), "{verb}");
        has(&errors, words);
    }
}

#[test]
fn a_campaign_that_is_not_merged_is_incomplete() {
    let place = &plan(&tiny_scene(), 4, "c");
    let words = ["not merged yet", "crossgrain study run"];
    all_say(place, 3, words);
    must(place, "run", &["--shard", "1/2"]);
    all_say(place, 3, words);
    must(place, "run", &["--shard", "2/2"]);
    all_say(place, 3, words);
    must(place, "merge", &[]);
    ends(place, 0, "study compare c c");
    // Nothing at all is no campaign.
    fs::remove_file(place.join("c/plan.json")).expect("a plan");
    all_say(place, 2, ["c is no study", "crossgrain study plan"]);
}

/// One thing wrong at a time; merging again puts each right.
#[test]
fn damaged_members_are_bad_input_and_can_be_merged_again() {
    let mut scene = tiny_scene();
    // So light that every member gets the force.
    scene.loading.pressure *= 0.1;
    let place = &plan(&scene, 4, "c");
    must(place, "run", &["--threads", "2"]);
    let members = place.join("c/rows.jsonl");
    let sound = fs::read(&members).expect("members");
    let mut turned = sound.clone();
    // A digit within a number, which is JSON before and after.
    let digit = turned.iter().rposition(u8::is_ascii_digit);
    let digit = digit.expect("a digit");
    turned[digit] = if turned[digit] == b'5' { b'6' } else { b'5' };
    let first_line = 1 + sound.iter().position(|byte| *byte == b'\n').expect("lines");
    let damages: [(&str, Option<&[u8]>); 5] = [
        ("rows.jsonl", Some(&turned)),
        ("rows.jsonl", Some(&sound[..first_line])),
        ("rows.jsonl", Some(&sound[..first_line / 2])),
        ("rows.jsonl", None),
        ("merged.json", Some(b"{")),
    ];
    for (file, bytes) in damages {
        let path = place.join("c").join(file);
        match bytes {
            Some(bytes) => fs::write(&path, bytes),
            None => fs::remove_file(&path),
        }
        .expect("a writable folder");
        all_say(place, 2, ["damaged", file, "crossgrain study merge"]);
        must(place, "merge", &[]);
        assert_eq!(fs::read(&members).expect("members"), sound);
    }
    // Four members leave claims open, which is a result: its files are there.
    let (code, _, errors) = say(place, "study claims c --out drawn");
    assert_eq!(code, 3, "{errors}");
    assert!(errors.ends_with("report: drawn/report.html\n"), "{errors}");
    for file in ["claims.json", "report.html"] {
        assert!(place.join("drawn").join(file).is_file(), "{file}");
    }
    let (code, _, errors) = say(place, "study figures --campaign c --out figures");
    assert_eq!((code, errors.as_str()), (0, ""));
    let drawn = |name: &str| fs::read_dir(place.join(name)).expect("files").count();
    assert_eq!((drawn("figures"), drawn("figures/figures")), (2, 23));
}
