//! Every check of a job in one shape: what terminal lines, pages, JUnit files, tables and baselines are made of.
//!
//! A job's own record (`run.json`, `verify.json`, …) has them as `checks` and `speeds`.

pub mod record;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::exit;
use verdict::judge::Verdict;

/// The ids of checks of an engine against itself begin with this.
pub const ITSELF: &str = "engine/itself/";

/// What a check came to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It holds.
    Pass,
    /// It does not.
    Fail,
    /// It was not made, or nothing was expected of it; never counted as passed.
    #[default]
    Skipped,
    /// It does not hold and is known not to, for the reason that is given with it; were it to hold, it would fail.
    ExpectedFailure,
}

impl Outcome {
    /// Pass or fail.
    pub fn pass_if(holds: bool) -> Self {
        if holds { Outcome::Pass } else { Outcome::Fail }
    }

    /// Of what shows nothing where it does not hold.
    pub fn pass_or_skip(holds: bool) -> Self {
        if holds {
            Outcome::Pass
        } else {
            Outcome::Skipped
        }
    }

    /// For people.
    pub fn word(self) -> &'static str {
        match self {
            Outcome::Pass => "pass",
            Outcome::Fail => "FAIL",
            Outcome::Skipped => "skipped",
            Outcome::ExpectedFailure => "expected failure",
        }
    }

    /// As the verdict of a job.
    pub fn verdict(self) -> &'static str {
        match self {
            Outcome::Pass => "Agreed",
            Outcome::Fail => "Different",
            Outcome::Skipped | Outcome::ExpectedFailure => "Incomplete",
        }
    }

    /// What a job with this verdict tells a script.
    pub fn exit_code(self) -> u8 {
        match self {
            Outcome::Pass => exit::AGREED,
            Outcome::Fail => exit::CHECK_FAILED,
            Outcome::Skipped | Outcome::ExpectedFailure => exit::INCOMPLETE,
        }
    }
}

impl From<Verdict> for Outcome {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Identical
            | Verdict::EqualToRounding
            | Verdict::EqualInDistribution
            | Verdict::ConsistentWithItself => Outcome::Pass,
            Verdict::Different => Outcome::Fail,
            Verdict::Undecided => Outcome::Skipped,
        }
    }
}

/// What checks come to together: failed if one failed; skipped if a required one was skipped, or if none passed; else passed.
pub fn verdict<'a>(checks: impl IntoIterator<Item = &'a Check>) -> Outcome {
    let (mut passed, mut incomplete) = (false, false);
    for check in checks {
        match check.outcome {
            Outcome::Fail => return Outcome::Fail,
            Outcome::Pass => passed = true,
            Outcome::Skipped => incomplete |= check.required,
            Outcome::ExpectedFailure => {}
        }
    }
    Outcome::pass_or_skip(passed && !incomplete)
}

/// One check.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Lasting and unique in its record: parts from the general to the special with `/` between them. A baseline finds a check
    /// again by it.
    pub id: String,
    /// What is measured, for people.
    pub quantity: String,
    /// SI unit, `1` for a ratio or a count.
    pub unit: String,
    /// As measured; none where there is no number, or it is none.
    pub value: Option<f64>,
    /// What it should be.
    pub expected: Option<f64>,
    /// The least that passes.
    pub lower: Option<f64>,
    /// The most that passes.
    pub upper: Option<f64>,
    /// How it is measured and judged.
    pub method: String,
    /// Where the limits come from.
    pub basis: String,
    /// How many independent observations the value rests on.
    pub n: u64,
    /// The value's 95 % interval, where it has one.
    pub interval: Option<[f64; 2]>,
    /// What it came to.
    pub outcome: Outcome,
    /// What was found or why it was skipped, in words; empty where the numbers say all.
    pub found: String,
    /// Whether the job is incomplete if it is skipped.
    #[serde(default)]
    pub required: bool,
    /// Whether it failed because an engine gave nothing to judge: it crashed, hung or was not understood.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub engine_failed: bool,
}

impl Check {
    /// A check without numbers.
    pub fn of_words(id: impl Into<String>, quantity: &str, outcome: Outcome, found: &str) -> Self {
        Check {
            id: id.into(),
            quantity: quantity.to_owned(),
            unit: "1".to_owned(),
            n: 1,
            outcome,
            found: found.to_owned(),
            ..Check::default()
        }
    }

    /// Sets value and limits: it passes within `allowed` of `expected`. What is not finite is no number.
    pub fn with_limits(mut self, value: f64, expected: f64, allowed: Option<f64>) -> Self {
        let number = |value: f64| value.is_finite().then_some(value);
        self.value = number(value);
        self.expected = number(expected);
        self.lower = allowed.and_then(|allowed| number(expected - allowed));
        self.upper = allowed.and_then(|allowed| number(expected + allowed));
        self
    }

    /// The job is incomplete without it.
    pub fn required(self) -> Self {
        Check {
            required: true,
            ..self
        }
    }

    /// Says how it is judged and where the limits come from.
    pub fn judged_by(mut self, method: &str, basis: &str) -> Self {
        method.clone_into(&mut self.method);
        basis.clone_into(&mut self.basis);
        self
    }

    /// What is measured, its value, what it must be, and what was found.
    pub fn in_a_line(&self) -> String {
        let mut line = self.quantity.clone();
        let unit = if self.unit == "1" { "" } else { &self.unit };
        if let Some(value) = self.value {
            line += format!(": {} {unit}", number(value)).trim_end();
        }
        match (self.lower.map(number), self.upper.map(number)) {
            (Some(lower), Some(upper)) if lower == upper => line += &format!(", must be {lower}"),
            (Some(lower), Some(upper)) => line += &format!(", must be {lower} to {upper}"),
            (Some(lower), None) => line += &format!(", must be at least {lower}"),
            (None, Some(upper)) => line += &format!(", must be at most {upper}"),
            (None, None) => {}
        }
        if !self.found.is_empty() {
            line += &format!("; {}", self.found);
        }
        line
    }
}

/// All digits, as a power of ten where zeros would be many.
fn number(value: f64) -> String {
    if value == 0.0 || (1.0e-4..1.0e7).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// A cost that travels between machines: a ratio of times in one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Speed {
    /// Lasting and unique, as a check's.
    pub id: String,
    /// What it is, for people.
    pub what: String,
    /// `times native`, `times without friction`.
    pub unit: String,
    /// The median.
    pub value: f64,
    /// Least and largest of the rounds; none for one round.
    pub range: Option<[f64; 2]>,
    /// Whether a smaller value is the better one.
    pub less_is_better: bool,
}

/// A number that is judged by nothing but a baseline: as measured in the native run, say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Lasting and unique, as a check's.
    pub id: String,
    /// SI unit, `1` for a ratio or a count.
    pub unit: String,
    /// As measured.
    pub value: f64,
}

/// How many checks came to what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    pub passed: usize,
    pub failed: usize,
    pub skipped: usize,
    pub expected_failures: usize,
}

impl Tally {
    /// Of these checks.
    pub fn of<'a>(checks: impl IntoIterator<Item = &'a Check>) -> Self {
        let mut tally = Tally::default();
        for check in checks {
            *match check.outcome {
                Outcome::Pass => &mut tally.passed,
                Outcome::Fail => &mut tally.failed,
                Outcome::Skipped => &mut tally.skipped,
                Outcome::ExpectedFailure => &mut tally.expected_failures,
            } += 1;
        }
        tally
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let checks = if self.passed == 1 { "check" } else { "checks" };
        write!(
            out,
            "{} {checks} passed, {} failed, {} skipped, {} expected failures",
            self.passed, self.failed, self.skipped, self.expected_failures
        )
    }
}

/// A part of an id from words: letters and digits in lower case, anything else between them as one hyphen.
pub fn slug(words: &str) -> String {
    let mut slug = String::with_capacity(words.len());
    for letter in words.chars() {
        match letter {
            '\'' | '’' => {}
            '.' | '_' => slug.push(letter),
            letter if letter.is_alphanumeric() => slug.extend(letter.to_lowercase()),
            _ if slug.ends_with('-') || slug.is_empty() => {}
            _ => slug.push('-'),
        }
    }
    slug.truncate(slug.trim_end_matches('-').len());
    slug
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slugs_are_short_and_plain() {
        for (words, wanted) in [
            ("YADE's sorted loop, live", "yades-sorted-loop-live"),
            ("  σ_zz (x/R) ", "σ_zz-x-r"),
            ("settled.mean_surface", "settled.mean_surface"),
        ] {
            assert_eq!(slug(words), wanted);
        }
    }

    #[test]
    fn a_verdict_follows_from_the_checks() {
        use Outcome::{ExpectedFailure, Fail, Pass, Skipped};
        for (outcomes, required, expected) in [
            (&[Pass, Pass][..], true, Pass),
            (&[Pass, Skipped, ExpectedFailure], false, Pass),
            (&[Pass, Skipped], true, Skipped),
            (&[Skipped, Fail, Pass], true, Fail),
            (&[Skipped, ExpectedFailure], false, Skipped),
            (&[], false, Skipped),
        ] {
            let check = |outcome: &Outcome| Check {
                required,
                ..Check::of_words("a", "", *outcome, "")
            };
            let checks: Vec<Check> = outcomes.iter().map(check).collect();
            assert_eq!(verdict(&checks), expected, "{outcomes:?} {required}");
        }
    }

    #[test]
    fn what_is_no_number_is_none_and_json_keeps_the_rest() {
        let check = Check::of_words("a/b", "overlap", Outcome::Fail, "it is not a number");
        let check = check.with_limits(f64::NAN, 1.0, Some(f64::INFINITY));
        assert_eq!((check.value, check.lower), (None, None));
        let text = serde_json::to_string(&check).expect("JSON");
        let read: Check = serde_json::from_str(&text).expect("a check");
        assert_eq!(read, check);
    }

    #[test]
    fn a_tally_counts_each_kind() {
        use Outcome::{ExpectedFailure, Fail, Pass, Skipped};
        let checks = [Pass, Pass, Pass, Fail, Skipped, Skipped, ExpectedFailure]
            .map(|outcome| Check::of_words("", "", outcome, ""));
        let tally = Tally {
            passed: 3,
            failed: 1,
            skipped: 2,
            expected_failures: 1,
        };
        assert_eq!(Tally::of(&checks), tally);
    }
}
