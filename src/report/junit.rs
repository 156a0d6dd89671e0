//! Checks as JUnit XML: skipped, failed and errored told apart.

use std::collections::BTreeMap;

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite, XmlString};

use super::shell::number;
use crate::checks::{Check, Outcome};
use crate::error::Error;

/// A suite for the first part of the ids, a test case for each check. What was not made is skipped, and so is an expected
/// failure, with its reason; neither counts as passed.
pub fn of_checks(name: &str, checks: &[Check]) -> Result<String, Error> {
    let mut suites: BTreeMap<&str, TestSuite> = BTreeMap::new();
    for check in checks {
        let (suite, rest) = check.id.split_once('/').unwrap_or(("checks", &check.id));
        let mut case = TestCase::new(rest, status(check));
        case.set_classname(format!("{name}.{suite}"));
        suites
            .entry(suite)
            .or_insert_with(|| TestSuite::new(suite))
            .add_test_case(case);
    }
    let mut report = Report::new(name);
    report.add_test_suites(suites.into_values());
    text(&report)
}

/// A job that ended with an error has no checks: one test case that errored.
pub fn of_error(name: &str, error: &Error) -> Result<String, Error> {
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
    status.set_message(error.to_string());
    status.set_type(format!("exit code {}", error.exit_code()));
    let mut suite = TestSuite::new("job");
    suite.add_test_case(TestCase::new(name, status));
    let mut report = Report::new(name);
    report.add_test_suite(suite);
    text(&report)
}

fn status(check: &Check) -> TestCaseStatus {
    let mut status = match check.outcome {
        Outcome::Pass => return TestCaseStatus::success(),
        Outcome::Fail => TestCaseStatus::non_success(NonSuccessKind::Failure),
        Outcome::NotMade | Outcome::ExpectedFailure => TestCaseStatus::skipped(),
    };
    status.set_type(check.outcome.word());
    status.set_message(XmlString::new(in_a_line(check)));
    if check.outcome == Outcome::Fail {
        status.set_description(XmlString::new(format!(
            "{}\nmethod: {}\nlimits: {}",
            in_a_line(check),
            check.method,
            check.basis
        )));
    }
    status
}

/// A check in a line, with what it is judged by.
pub fn in_a_line(check: &Check) -> String {
    let mut line = check.quantity.clone();
    let unit = if check.unit == "1" { "" } else { &check.unit };
    let value = check.value.map(number);
    if let Some(value) = &value {
        line += format!(": {value} {unit}").trim_end();
    }
    match (check.lower.map(number), check.upper.map(number)) {
        (Some(lower), Some(upper)) if lower == upper => line += &format!(", must be {lower}"),
        (Some(lower), Some(upper)) => line += &format!(", must be {lower} to {upper}"),
        (Some(lower), None) => line += &format!(", must be at least {lower}"),
        (None, Some(upper)) => line += &format!(", must be at most {upper}"),
        (None, None) => {}
    }
    if !check.found.is_empty() {
        line += &format!("; {}", check.found);
    }
    line
}

fn text(report: &Report) -> Result<String, Error> {
    report
        .to_string()
        .map_err(|error| Error::Report(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks() -> Vec<Check> {
        let check = |id: &str, outcome, found: &str| {
            Check::of_words(id.to_owned(), "height", outcome, found)
        };
        vec![
            check("compare/height", Outcome::Pass, ""),
            check("compare/porosity", Outcome::Fail, "a < b & \u{1} \"c\"").with_limits(
                2.0,
                1.0,
                Some(0.5),
            ),
            check("ladder/fall", Outcome::NotMade, "YADE is missing"),
            check("paper/eq-7", Outcome::ExpectedFailure, "misprinted"),
        ]
    }

    #[test]
    fn each_outcome_is_its_own_kind_and_the_text_reads_back() {
        let text = of_checks("crossgrain", &checks()).expect("XML");
        let report = Report::deserialize_from_str(&text).expect("JUnit");
        assert_eq!((report.tests, report.failures, report.errors), (4, 1, 0));
        let skipped = text.matches("<skipped").count();
        assert_eq!((report.test_suites.len(), skipped), (3, 2));
        assert!(
            text.contains("height: 2, must be 0.5 to 1.5; a &lt; b &amp;"),
            "{text}"
        );
        assert!(text.contains("YADE is missing") && text.contains("expected failure"));
    }

    #[test]
    fn a_job_that_ended_with_an_error_is_an_error() {
        let error = Error::Usage("no such scene".to_owned());
        let text = of_error("crossgrain reproduce", &error).expect("XML");
        let report = Report::deserialize_from_str(&text).expect("JUnit");
        assert_eq!((report.tests, report.failures, report.errors), (1, 0, 1));
        assert!(text.contains("exit code 2") && text.contains("no such scene"));
    }
}
