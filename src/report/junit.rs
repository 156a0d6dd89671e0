//! Checks as JUnit XML: passed, failed, skipped and errored told apart.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::checks::{Check, Outcome, Tally};
use crate::error::Error;

/// A suite for the first part of the ids, a test case for each check. What was skipped is skipped, and so is an expected
/// failure, with its reason; neither counts as passed.
pub fn of_checks(name: &str, checks: &[Check]) -> String {
    let mut suites: BTreeMap<&str, Vec<(&str, &Check)>> = BTreeMap::new();
    for check in checks {
        let (suite, rest) = check.id.split_once('/').unwrap_or(("checks", &check.id));
        suites.entry(suite).or_default().push((rest, check));
    }
    let counts = |tally: Tally| {
        let skipped = tally.skipped + tally.expected_failures;
        let all = skipped + tally.passed + tally.failed;
        format!(
            "tests=\"{all}\" failures=\"{}\" errors=\"0\" skipped=\"{skipped}\"",
            tally.failed
        )
    };
    let mut text = opened(name, &counts(Tally::of(checks)));
    for (suite, cases) in suites {
        let of_suite: Vec<Check> = cases.iter().map(|(_, check)| (*check).clone()).collect();
        let _ = writeln!(
            text,
            "  <testsuite name=\"{}\" {}>",
            escaped(suite),
            counts(Tally::of(&of_suite))
        );
        for (id, check) in cases {
            let class = format!("{name}.{suite}");
            let _ = write!(
                text,
                "    <testcase name=\"{}\" classname=\"{}\">",
                escaped(id),
                escaped(&class)
            );
            let line = check.in_a_line();
            let told = format!(
                "message=\"{}\" type=\"{}\"",
                escaped(&line),
                escaped(check.outcome.word())
            );
            let _ = match check.outcome {
                Outcome::Pass => Ok(()),
                Outcome::Fail => {
                    let all = format!("{line}\nmethod: {}\nlimits: {}", check.method, check.basis);
                    write!(text, "<failure {told}>{}</failure>", escaped(&all))
                }
                Outcome::Skipped | Outcome::ExpectedFailure => write!(text, "<skipped {told}/>"),
            };
            text += "</testcase>\n";
        }
        text += "  </testsuite>\n";
    }
    text + "</testsuites>\n"
}

/// A job that ended with an error has no checks: one test case that errored.
pub fn of_error(name: &str, error: &Error) -> String {
    let counts = "tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\"";
    let message = escaped(&error.to_string());
    opened(name, counts)
        + &format!(
            "  <testsuite name=\"job\" {counts}>\n    <testcase name=\"{0}\" classname=\"{0}\"><error message=\"{message}\" \
             type=\"exit code {1}\"/></testcase>\n  </testsuite>\n</testsuites>\n",
            escaped(name),
            error.exit_code()
        )
}

fn opened(name: &str, counts: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"{}\" {counts}>\n",
        escaped(name)
    )
}

/// Text in attributes and elements; what XML 1.0 cannot hold is written out.
fn escaped(text: &str) -> String {
    super::views::escaped(text)
        .replace('\n', "&#10;")
        .replace('\t', "&#9;")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything that markup, XML 1.0 or a reader of the text could stumble over.
    const HOSTILE: &str =
        "a < b & \"c\" ]]> --> \u{0}\u{1}\u{b}\u{1f}\u{7f}\u{85}\u{202e}\u{fffe}\u{ffff}\r\n\t'";

    fn checks() -> Vec<Check> {
        let check = |id: &str, outcome, found: &str| {
            Check::of_words(id.to_owned(), "height", outcome, found)
        };
        vec![
            check("compare/height", Outcome::Pass, ""),
            check("compare/porosity", Outcome::Fail, HOSTILE).with_limits(2.0, 1.0, Some(0.5)),
            check("ladder/fall", Outcome::Skipped, "YADE is missing"),
            check("paper/eq-7", Outcome::ExpectedFailure, "misprinted"),
        ]
    }

    #[test]
    fn each_outcome_is_its_own_kind_and_the_text_reads_back() {
        let text = of_checks("crossgrain", &checks());
        let read = roxmltree::Document::parse(&text).expect("XML");
        let root = read.root_element();
        let counts = ["tests", "failures", "errors", "skipped"].map(|of| root.attribute(of));
        assert_eq!(counts, ["4", "1", "0", "2"].map(Some));
        let all = |name: &'static str| {
            read.descendants()
                .filter(move |node| node.has_tag_name(name))
        };
        assert_eq!(all("testsuite").count(), 3);
        let skipped: Vec<_> = all("skipped")
            .filter_map(|node| node.attribute("message"))
            .collect();
        assert_eq!(skipped, ["height; YADE is missing", "height; misprinted"]);
        let failure = all("failure").next().expect("a failure");
        let wanted = "height: 2, must be 0.5 to 1.5; a < b & \"c\" ]]> --> \\u{0}\\u{1}\\u{b}\\u{1f}\\u{7f}\\u{85}\\u{202e}\\u{fffe}\\u{ffff}\\u{d}\n\t'";
        assert_eq!(failure.attribute("message"), Some(wanted));
        assert!(
            failure.text().is_some_and(|text| text.starts_with(wanted)),
            "{text}"
        );
    }

    #[test]
    fn a_job_that_ended_with_an_error_is_an_error() {
        let error = Error::Usage(format!("no such scene {HOSTILE}"));
        let text = of_error("crossgrain reproduce", &error);
        let read = roxmltree::Document::parse(&text).expect("XML");
        assert_eq!(read.root_element().attribute("errors"), Some("1"));
        let error = read
            .descendants()
            .find(|node| node.has_tag_name("error"))
            .expect("an error");
        assert_eq!(error.attribute("type"), Some("exit code 2"));
        assert!(
            error
                .attribute("message")
                .is_some_and(|of| of.contains("no such scene"))
        );
    }
}
