//! Studies that are no campaigns: a part `kind`, a part `plan` with the study's own plan, and a part `rows`, whose lines `NUMBER JSON`
//! get their checks. What is read is judged.

use crossgrain::study::folder::{AnyStudy as _, StudyFolder};
use crossgrain::study::plan::Plan;
use crossgrain::study::store;
use crossgrain::study::{Study, StudyError, candidates, search, tradeoff};

use super::parts::{self, Parts};

pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    match parts.text("kind").map(str::trim) {
        Some("candidates") => read_as::<candidates::Plan>(&parts),
        Some("search") => read_as::<search::Plan>(&parts),
        Some("tradeoff") => read_as::<tradeoff::plan::Plan>(&parts),
        _ => false,
    }
}

/// A plan that is accepted reads back as itself; its rows are read, told and judged, or refused in words.
fn read_as<S: Study + PartialEq + std::fmt::Debug>(parts: &Parts<'_>) -> bool {
    let Some(plan) = parts.get("plan").and_then(given::<S>) else {
        return false;
    };
    let folder = parts::folder();
    let place = folder.path().join("study");
    plan.write(&place).expect("a writable folder");
    let open = StudyFolder::<S>::open(&place).expect("what was accepted once");
    assert_eq!(open.plan, plan);
    let rows = parts.text("rows").unwrap_or_default();
    let lines = rows.lines().filter_map(|row| {
        let (number, json) = row.split_once(' ')?;
        Some(store::line(&plan.digest(), number.parse().ok()?, json) + "\n")
    });
    let lines: String = lines.collect();
    parts::put(
        &place.join(store::RECORDS),
        "shard-1-of-1.jsonl",
        lines.as_bytes(),
    );
    open.status().expect("the state of any study");
    match open.rows() {
        Ok(_) => drop(open.judge()),
        Err(StudyError::File(error)) => panic!("{error}"),
        Err(_) => {}
    }
    true
}

fn given<S: Study>(bytes: &[u8]) -> Option<Plan<S>> {
    Plan::new(serde_json::from_slice(bytes).ok()?, None).ok()
}

/// A plan and rows as an input.
pub fn seed<S: Study>(plan: &S, rows: &[(u64, S::Row)]) -> Vec<u8> {
    let plan = serde_json::to_string(plan).expect("a plan can be written");
    let rows = rows.iter().map(|(number, row)| {
        let json = serde_json::to_string(row).expect("a row can be written");
        format!("{number} {json}\n")
    });
    let rows: String = rows.collect();
    parts::join(&[
        ("kind", S::KIND.as_bytes()),
        ("plan", plan.as_bytes()),
        ("rows", rows.as_bytes()),
    ])
}
