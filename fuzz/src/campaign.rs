//! Records of a campaign, merging them, and reading what was merged. The plan is a fixed one. A record that begins with `*`
//! in the place of its check gets the right one, and where there is a part `repair`, so does `merged.json`.

use std::path::Path;

use sha2::{Digest, Sha256};

use crossgrain::files::short_hex;
use crossgrain::study::campaign::{self, Campaign};
use crossgrain::study::folder::{AnyStudy as _, SUMMARY, StudyFolder, Summary};
use crossgrain::study::plan::Plan;
use crossgrain::study::store::{self, Index, Reader};
use crossgrain::study::{Study as _, StudyError};

use super::parts::{self, Parts};
use super::small;

/// The record files that an input may have.
pub const RECORDS: [&str; 2] = ["shard-1-of-2.jsonl", "shard-2-of-2.jsonl"];

/// What is merged can be read, and is what the records say.
pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    let plan = small::plan();
    let folder = parts::folder();
    let place = folder.path().join("campaign");
    plan.write(&place).expect("a writable folder");
    for name in RECORDS {
        if let Some(bytes) = parts.get(name) {
            parts::put(&place.join(store::RECORDS), name, &checked(&plan, bytes));
        }
    }
    let given = given(&parts, &plan, &place);
    let index =
        Index::read(&place, &plan.digest(), plan.study.members).expect("files that are there");
    let mut reader = Reader::new(&index);
    for record in index.places.values() {
        reader.json(record).expect("what the index has found");
    }
    let open = StudyFolder::<Campaign>::open(&place).expect("the plan is sound");
    open.status().expect("the state of any campaign");
    match open.merge() {
        Ok(summary) => {
            let whole = campaign::merged(&place).expect("what was merged just now");
            assert_eq!(whole.summary, summary);
            assert_eq!(whole.rows.len() as u64, plan.study.members);
            true
        }
        Err(StudyError::File(error)) => panic!("{error}"),
        Err(_) => given,
    }
}

/// Whether the merged files that the input brings are accepted.
fn given(parts: &Parts<'_>, plan: &Plan<Campaign>, place: &Path) -> bool {
    let files = [
        ("members.jsonl", "rows.jsonl"),
        ("members.jsonl.gz", "rows.jsonl.gz"),
        (SUMMARY, SUMMARY),
    ];
    for (part, name) in files {
        if let Some(bytes) = parts.get(part) {
            parts::put(place, name, bytes);
        }
    }
    let members = parts.get("members.jsonl").or(parts.get("members.jsonl.gz"));
    if let (Some(members), Some(_)) = (members, parts.get("repair")) {
        parts::put(place, SUMMARY, summary(plan, members).text().as_bytes());
    }
    let whole = campaign::merged(place);
    for (_, name) in files {
        let _ = std::fs::remove_file(place.join(name));
    }
    whole.is_ok_and(|whole| whole.rows.len() as u64 == plan.study.members)
}

/// What is said of rows that are members; of others whatever.
fn summary(plan: &Plan<Campaign>, members: &[u8]) -> Summary {
    let mut summary = Summary {
        plan: plan.digest(),
        rows: plan.study.members,
        engine: String::new(),
        endings: Default::default(),
        sha256: crossgrain::files::sha256_hex(members),
    };
    for line in members.split_inclusive(|byte| *byte == b'\n') {
        if let Ok(member) = serde_json::from_slice(line) {
            let outline = plan.study.outline(&member);
            *summary
                .endings
                .entry(outline.ending.to_owned())
                .or_default() += 1;
            summary.engine = outline.engine.unwrap_or(summary.engine);
        }
    }
    summary
}

/// The lines `* MEMBER JSON` with their checks.
fn checked(plan: &Plan<Campaign>, bytes: &[u8]) -> Vec<u8> {
    let mut text = Vec::new();
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        if let Some(rest) = line.strip_prefix(b"* ") {
            let mut hash = Sha256::new();
            hash.update(plan.digest());
            hash.update(b" ");
            hash.update(rest.strip_suffix(b"\n").unwrap_or(rest));
            text.extend_from_slice(short_hex(hash).as_bytes());
            text.push(b' ');
            text.extend_from_slice(rest);
        } else {
            text.extend_from_slice(line);
        }
    }
    text
}
