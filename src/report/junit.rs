//! Checks as JUnit XML.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::views::escaped;
use crate::checks::{Check, Outcome, Tally};
use crate::error::Error;

/// A suite for the first part of the ids, a test case for each check. What was skipped is skipped, and so is an expected
/// failure, with its reason; neither counts as passed.
pub fn junit(name: &str, checks: &[Check]) -> String {
    let mut suites: BTreeMap<&str, Vec<&Check>> = BTreeMap::new();
    for check in checks {
        let (suite, _) = check.id.split_once('/').unwrap_or(("checks", ""));
        suites.entry(suite).or_default().push(check);
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
        let (named, counts) = (in_xml(suite), counts(Tally::of(cases.iter().copied())));
        let _ = writeln!(text, "  <testsuite name=\"{named}\" {counts}>");
        let class = in_xml(&format!("{name}.{suite}"));
        for check in cases {
            let (id, line, kind) = (&check.id, check.in_a_line(), check.outcome.word());
            let told = format!("message=\"{}\" type=\"{kind}\"", in_xml(&line));
            let told = match check.outcome {
                Outcome::Pass => String::new(),
                Outcome::Fail => {
                    let all = format!("{line}\nmethod: {}\nlimits: {}", check.method, check.basis);
                    format!("<failure {told}>{}</failure>", in_xml(&all))
                }
                Outcome::Skipped | Outcome::ExpectedFailure => format!("<skipped {told}/>"),
            };
            let _ = writeln!(
                text,
                "    <testcase name=\"{}\" classname=\"{class}\">{told}</testcase>",
                in_xml(id)
            );
        }
        text += "  </testsuite>\n";
    }
    text + "</testsuites>\n"
}

/// A job that ended with an error has no checks: one test case that errored.
pub fn junit_of_error(name: &str, error: &Error) -> String {
    let counts = "tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\"";
    let message = in_xml(&error.to_string());
    opened(name, counts)
        + &format!(
            "  <testsuite name=\"job\" {counts}>\n    <testcase name=\"{0}\" classname=\"{0}\"><error message=\"{message}\" \
             type=\"exit code {1}\"/></testcase>\n  </testsuite>\n</testsuites>\n",
            in_xml(name),
            error.exit_code()
        )
}

fn opened(name: &str, counts: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"{}\" {counts}>\n",
        in_xml(name)
    )
}

/// Text in attributes and elements; what XML 1.0 cannot hold is written out.
fn in_xml(text: &str) -> String {
    escaped(text).replace('\n', "&#10;").replace('\t', "&#9;")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything that markup, XML 1.0 or a reader of the text could stumble over.
    const HOSTILE: &str =
        "a < b & \"c\" ]]> --> \u{0}\u{1}\u{b}\u{1f}\u{7f}\u{85}\u{202e}\u{fffe}\u{ffff}\r\n\t'";

    fn checks() -> Vec<Check> {
        let check = |id: &str, outcome, found| Check::of_words(id, "height", outcome, found);
        vec![
            check("compare/height", Outcome::Pass, ""),
            check("compare/porosity", Outcome::Fail, HOSTILE).with_limits(2.0, 1.0, Some(0.5)),
            check("ladder/fall", Outcome::Skipped, "YADE is missing"),
            check("paper/eq-7", Outcome::ExpectedFailure, "misprinted"),
        ]
    }

    #[test]
    fn each_outcome_is_its_own_kind_and_the_text_reads_back() {
        let text = junit("crossgrain", &checks());
        let read = roxmltree::Document::parse(&text).expect("XML");
        let root = read.root_element();
        let counts = ["tests", "failures", "errors", "skipped"].map(|name| root.attribute(name));
        assert_eq!(counts, ["4", "1", "0", "2"].map(Some));
        let all = |name: &'static str| {
            let nodes = read.descendants();
            nodes.filter(move |node| node.has_tag_name(name))
        };
        assert_eq!(all("testsuite").count(), 3);
        let skipped = all("skipped").filter_map(|node| node.attribute("message"));
        let wanted_skipped = ["height; YADE is missing", "height; misprinted"];
        assert_eq!(skipped.collect::<Vec<_>>(), wanted_skipped);
        let failure = all("failure").next().expect("a failure");
        let wanted = "height: 2, must be 0.5 to 1.5; a < b & \"c\" ]]> --> \\u{0}\\u{1}\\u{b}\\u{1f}\\u{7f}\\u{85}\\u{202e}\\u{fffe}\\u{ffff}\\u{d}\n\t'";
        assert_eq!(failure.attribute("message"), Some(wanted));
        let all_of_it = failure.text().expect("a text");
        assert!(all_of_it.starts_with(wanted), "{text}");
    }

    #[test]
    fn a_job_that_ended_with_an_error_is_an_error() {
        let error = Error::Usage(format!("no such scene {HOSTILE}"));
        let text = junit_of_error("crossgrain reproduce", &error);
        let read = roxmltree::Document::parse(&text).expect("XML");
        assert_eq!(read.root_element().attribute("errors"), Some("1"));
        let mut nodes = read.descendants();
        let error = nodes.find(|node| node.has_tag_name("error"));
        let attribute = |name: &str| error.and_then(|node| node.attribute(name));
        assert_eq!(attribute("type"), Some("exit code 2"));
        assert!(attribute("message").is_some_and(|text| text.contains("no such scene")));
    }
}
