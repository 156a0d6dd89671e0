//! Records of a campaign, merging them, and reading what was merged. The plan is a fixed one. A record that begins with `*`
//! in the place of its check gets the right one, and where there is a part `repair`, so does `merged.json`.

use std::path::Path;

use sha2::{Digest, Sha256};

use crossgrain::files::short_hex;
use crossgrain::study::campaign::plan::Plan;
use crossgrain::study::campaign::records::{Index, Reader, records_folder};
use crossgrain::study::campaign::{CampaignError, merge, merged, status};

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
            parts::put(&records_folder(&place), name, &checked(&plan, bytes));
        }
    }
    let given = given(&parts, &plan, &place);
    let index = Index::read(&place, &plan.digest(), plan.members).expect("files that are there");
    let mut reader = Reader::new(&index);
    for record in index.places.values() {
        reader.json(record).expect("what the index has found");
    }
    status::status(&place).expect("the state of any campaign");
    match merge::merge(&place) {
        Ok(summary) => {
            let whole = merged::read(&place).expect("what was merged just now");
            assert_eq!(whole.summary, summary);
            assert_eq!(whole.members.len() as u64, plan.members);
            true
        }
        Err(CampaignError::File(error)) => panic!("{error}"),
        Err(_) => given,
    }
}

/// Whether the merged files that the input brings are accepted.
fn given(parts: &Parts<'_>, plan: &Plan, place: &Path) -> bool {
    parts.write(&["members.jsonl", "members.jsonl.gz", "merged.json"], place);
    let members = parts.get("members.jsonl").or(parts.get("members.jsonl.gz"));
    if let (Some(members), Some(_)) = (members, parts.get("repair")) {
        let summary = serde_json::json!({
            "plan": plan.digest(), "members": plan.members, "engine": "any", "endings": {},
            "sha256": crossgrain::files::sha256_hex(members),
        });
        parts::put(place, merged::SUMMARY, summary.to_string().as_bytes());
    }
    let whole = merged::read(place);
    for name in ["members.jsonl", "members.jsonl.gz", merged::SUMMARY] {
        let _ = std::fs::remove_file(place.join(name));
    }
    whole.is_ok_and(|whole| whole.members.len() as u64 == plan.members)
}

/// The lines `* MEMBER JSON` with their checks.
fn checked(plan: &Plan, bytes: &[u8]) -> Vec<u8> {
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
