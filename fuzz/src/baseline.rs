//! Baselines: the parts `record.json`, a job's record, and `kept.json`, a baseline of another one.

use crossgrain::checks::Outcome;
use crossgrain::compare::baseline::{Store, diff};
use crossgrain::report;

use super::parts::{self, Parts};

/// What is saved is loaded as it was, and what is loaded can be held against a run.
pub fn read(input: &[u8]) -> bool {
    let parts = Parts::of(input);
    let folder = parts::folder();
    parts.write(&["record.json", "kept.json"], folder.path());
    let store = Store::new(folder.path());
    let kept = store.load("kept").ok();
    if store
        .save(&folder.path().join("record.json"), "saved", false)
        .is_err()
    {
        return kept.is_some();
    }
    let saved = store.load("saved").expect("what was saved just now");
    let same = diff::diff(&saved, &saved.record);
    assert_eq!(same.verdict, Outcome::Pass, "a run differs from itself");
    if let Some(kept) = kept {
        let diff = diff::diff(&kept, &saved.record).demanding_bits();
        assert!(!diff.in_a_line().is_empty());
        assert!(!report::markdown(&diff.document(true)).is_empty());
    }
    true
}
