//! Speeds of a run against those of a baseline: ratios and instructions, judged beyond their scatter.

use serde::Serialize;

use crate::checks::Speed;

/// What became of a speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pace {
    /// Beyond what rounds scatter.
    Slower,
    /// Beyond what rounds scatter.
    Faster,
    /// Within it.
    Same,
    /// The machines are not the same, or one run does not have it.
    NotJudged,
}

impl Pace {
    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Pace::Slower => "SLOWER",
            Pace::Faster => "faster",
            Pace::Same => "same",
            Pace::NotJudged => "not judged",
        }
    }
}

/// A speed in both.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedPair {
    /// Of the speed.
    pub id: String,
    /// For people.
    pub what: String,
    /// Of both.
    pub unit: String,
    /// In the baseline.
    pub before: Option<f64>,
    /// In this run.
    pub after: Option<f64>,
    /// Cost after over cost before: above 1 is slower.
    pub cost: Option<f64>,
    /// A change of cost up to this factor, either way, says nothing.
    pub scatter: f64,
    /// What that amounts to.
    pub pace: Pace,
}

/// Times of one round each.
const SINGLE_ROUND: f64 = 1.5;
/// Times whose rounds do not overlap.
const APART: f64 = 1.05;
/// Numbers of instructions.
const INSTRUCTIONS: f64 = 1.01;

impl SpeedPair {
    /// Both values, and what that amounts to.
    pub fn in_a_line(&self) -> String {
        let number = |of: Option<f64>| of.map_or("–".to_owned(), |of| format!("{of:.4}"));
        let cost = self
            .cost
            .map_or(String::new(), |cost| format!(", {cost:.3} times the cost"));
        format!(
            "{}: {} to {} {}{cost}",
            self.what,
            number(self.before),
            number(self.after),
            self.unit
        )
    }
}

/// All speeds of either; judged on machines of one kind only.
pub fn speeds(before: &[Speed], after: &[Speed], same_machine: bool) -> Vec<SpeedPair> {
    let find = |list: &[Speed], id: &str| list.iter().find(|speed| speed.id == id).cloned();
    let mut ids: Vec<&Speed> = after.iter().collect();
    ids.extend(
        before
            .iter()
            .filter(|speed| find(after, &speed.id).is_none()),
    );
    let pair = |speed: &Speed| {
        let (old, new) = (find(before, &speed.id), find(after, &speed.id));
        let both = old.as_ref().zip(new.as_ref());
        let cost = both.map(|(old, new)| {
            if new.less_is_better {
                new.value / old.value
            } else {
                old.value / new.value
            }
        });
        let scatter = both.map_or(SINGLE_ROUND, |(old, new)| scatter(old, new));
        SpeedPair {
            id: speed.id.clone(),
            what: speed.what.clone(),
            unit: speed.unit.clone(),
            before: old.as_ref().map(|speed| speed.value),
            after: new.as_ref().map(|speed| speed.value),
            cost,
            scatter,
            pace: match cost {
                Some(cost) if same_machine && cost.is_finite() => pace(cost, scatter),
                _ => Pace::NotJudged,
            },
        }
    };
    ids.into_iter().map(pair).collect()
}

fn pace(cost: f64, scatter: f64) -> Pace {
    if cost > scatter {
        Pace::Slower
    } else if cost < 1.0 / scatter {
        Pace::Faster
    } else {
        Pace::Same
    }
}

/// Rounds that overlap say nothing, however far their medians are apart.
fn scatter(old: &Speed, new: &Speed) -> f64 {
    match (old.range, new.range) {
        (Some([_, high]), Some([low, _])) if high < low => APART,
        (Some([low, _]), Some([_, high])) if high < low => APART,
        (Some(_), Some(_)) => f64::INFINITY,
        _ if old.unit.starts_with("instructions") => INSTRUCTIONS,
        _ => SINGLE_ROUND,
    }
}
