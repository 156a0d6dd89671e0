//! Records of jobs (`run.json`, `verify.json`, `bench.json`), of any version, and what is made of them.

use crossgrain::checks::record::parse;
use crossgrain::document::Table;
use crossgrain::report;

/// A record that is accepted reads back as itself, and can be given to other programs.
pub fn read(input: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(input) else {
        return false;
    };
    let record = match parse("record.json", text) {
        Ok(record) => record,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return false;
        }
    };
    let written = serde_json::to_string(&record).expect("a record is JSON");
    let again = serde_json::from_str(&written).expect("what was accepted once");
    assert_eq!(record, again);
    let table = Table::of_checks("checks", &record.checks).csv();
    assert!(table.lines().count() > record.checks.len());
    assert!(!report::junit(&record.job, &record.checks).is_empty());
    assert!(!report::markdown(&record.document()).is_empty());
    true
}
