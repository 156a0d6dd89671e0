//! Checks as a table (CSV) and as a job summary (Markdown).

use super::junit::in_a_line;
use crate::checks::record::Record;
use crate::checks::{Check, Outcome};
use crate::compare::Verdict;
use crate::compare::baseline::diff::{Change, Diff, Pace};
use crate::error::Error;

/// All checks, a row each.
pub fn csv(checks: &[Check]) -> Result<String, Error> {
    let wrong = |error: csv::Error| Error::Report(error.to_string());
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record([
            "id",
            "outcome",
            "quantity",
            "unit",
            "value",
            "expected",
            "lower",
            "upper",
            "n",
            "interval_low",
            "interval_high",
            "method",
            "basis",
            "found",
        ])
        .map_err(wrong)?;
    let number = |of: Option<f64>| of.map_or(String::new(), |of| of.to_string());
    for check in checks {
        let [low, high] = check.interval.map_or([None; 2], |ends| ends.map(Some));
        writer
            .write_record([
                &check.id,
                check.outcome.word(),
                &check.quantity,
                &check.unit,
                &number(check.value),
                &number(check.expected),
                &number(check.lower),
                &number(check.upper),
                &check.n.to_string(),
                &number(low),
                &number(high),
                &check.method,
                &check.basis,
                &check.found,
            ])
            .map_err(wrong)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| Error::Report(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| Error::Report(error.to_string()))
}

/// Rows of a summary's table at most; the rest is counted.
const MOST_ROWS: usize = 40;

/// What a continuous integration shows beside a job: verdict and failures first, then what changed.
pub fn markdown(record: &Record, diff: Option<&Diff>) -> String {
    let mut text = format!(
        "## {}: {}\n\n`{}`, crossgrain {}: {}.\n",
        escaped(&record.job),
        record.verdict.word(),
        record.command.replace('`', "'"),
        escaped(&record.crossgrain),
        record.tally()
    );
    if let Some(diff) = diff {
        text += &of_diff(diff);
    }
    for (outcome, title) in [
        (Outcome::Fail, "Failed"),
        (Outcome::NotMade, "Not made"),
        (Outcome::ExpectedFailure, "Expected failures"),
    ] {
        let of: Vec<&Check> = record
            .checks
            .iter()
            .filter(|check| check.outcome == outcome)
            .collect();
        if of.is_empty() {
            continue;
        }
        text += &format!(
            "\n### {title} ({})\n\n| check | found |\n|---|---|\n",
            of.len()
        );
        for check in of.iter().take(MOST_ROWS) {
            text += &format!(
                "| `{}` | {} |\n",
                code(&check.id),
                escaped(&in_a_line(check))
            );
        }
        text += &more(of.len());
    }
    text
}

/// The same of a job that ended with an error.
pub fn error_in_markdown(name: &str, error: &Error) -> String {
    format!(
        "## {}: ERROR\n\nIt ended with exit code {}: {}\n",
        escaped(name),
        error.exit_code(),
        escaped(&error.to_string())
    )
}

fn of_diff(diff: &Diff) -> String {
    let mut text = format!(
        "\n### {} baseline {}\n\n{}\n",
        match diff.verdict {
            Verdict::Pass => "Nothing is worse than in",
            Verdict::Fail => "WORSE than",
            Verdict::NotMade => "Some of it cannot be told against",
        },
        escaped(&diff.baseline),
        diff.in_a_line()
    );
    let shown: Vec<_> = diff
        .changes
        .iter()
        .filter(|of| of.change != Change::Moved)
        .collect();
    if !shown.is_empty() {
        text += "\n| change | check | before | after |\n|---|---|---|---|\n";
        for of in shown.iter().take(MOST_ROWS) {
            let side = |check: &Option<Check>| {
                check
                    .as_ref()
                    .map_or("–".to_owned(), |check| escaped(&in_a_line(check)))
            };
            text += &format!(
                "| {} | `{}` | {} | {} |\n",
                of.change.words(),
                code(&of.id),
                side(&of.before),
                side(&of.after)
            );
        }
        text += &more(shown.len());
    }
    for speed in diff.speeds.iter().filter(|of| of.pace == Pace::Slower) {
        text += &format!("\n- slower: {}\n", escaped(&speed.in_a_line()));
    }
    text
}

fn more(rows: usize) -> String {
    match rows.saturating_sub(MOST_ROWS) {
        0 => String::new(),
        rest => format!("\n… and {rest} more\n"),
    }
}

/// Text in a cell of a Markdown table.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '|' | '*' | '_' | '`' | '[' | ']' | '<' | '>' | '\\' | '#' => {
                safe.push('\\');
                safe.push(letter);
            }
            letter if letter.is_control() => safe.push(' '),
            letter => safe.push(letter),
        }
    }
    safe
}

fn code(id: &str) -> String {
    id.replace(['`', '|'], "'")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(id: &str, outcome: Outcome) -> Check {
        Check::of_words(id.to_owned(), "height | of \"it\", m", outcome, "a\nb").with_limits(
            0.47,
            0.46,
            Some(0.005),
        )
    }

    #[test]
    fn a_table_reads_back() {
        let checks = [check("a/b", Outcome::Fail), check("a/c", Outcome::Pass)];
        let text = csv(&checks).expect("CSV");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let rows: Vec<csv::StringRecord> =
            reader.records().map(|row| row.expect("a row")).collect();
        assert_eq!(rows.len(), 2);
        assert_eq!(&rows[0][2], "height | of \"it\", m");
        assert_eq!(rows[0][4].parse(), Ok(0.47));
        assert_eq!(&rows[0][13], "a\nb");
    }

    #[test]
    fn a_summary_tells_what_failed_and_breaks_no_table() {
        let mut checks = vec![check("a/b", Outcome::Fail), check("a/c", Outcome::Pass)];
        checks.extend((0..50).map(|number| check(&format!("n/{number}"), Outcome::NotMade)));
        let record = Record {
            job: "verify".to_owned(),
            version: 2,
            crossgrain: "0.1.0".to_owned(),
            command: "crossgrain verify".to_owned(),
            machine_kind: None,
            scene_digest: None,
            yade: None,
            verdict: Outcome::Fail,
            checks,
            measured: Vec::new(),
            speeds: Vec::new(),
        };
        let text = markdown(&record, None);
        assert!(text.starts_with("## verify: FAIL"), "{text}");
        assert!(text.contains("### Failed (1)") && text.contains("… and 10 more"));
        let rows = text.lines().filter(|line| line.starts_with("| `"));
        assert!(rows.clone().count() == 41);
        for row in rows {
            let bars = row.replace("\\|", "").matches('|').count();
            assert_eq!(bars, 3, "{row}");
        }
    }
}
