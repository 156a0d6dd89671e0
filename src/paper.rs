//! What the paper printed, and each number of it that needs no simulation recomputed by a route of our own; the continuum
//! under the punch, what ground bears, and the stress inside a disc; the integration that they share.

pub mod bearing;
pub mod continuum;
pub mod disc_field;
pub mod published;
pub mod recomputed;

use std::f64::consts::PI;
use std::iter::Sum;
use std::ops::Mul;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use self::published::printed;
use crate::checks::{Check, Outcome};
use crate::document::{Cell, Document, Section, Table, rounded};

/// One printed number beside its recomputation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    pub id: String,
    pub place: String,
    pub what: String,
    /// As it is printed, in `unit`.
    pub published: f64,
    /// Half a unit of the last printed digit; 0 for whole numbers.
    pub rounding: f64,
    /// By our own route, in `unit`.
    pub recomputed: f64,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    /// What ours is known to be where the print is at fault or can be read otherwise.
    pub known: Option<f64>,
    /// Pass: ours rounds to the print. Expected failure: it is what it is known to be instead. Skipped: the paper does not
    /// print it, but it follows from what is printed and is used here.
    pub outcome: Outcome,
    /// The route of the recomputation.
    pub how: String,
    /// What is at fault and by how much; empty where nothing is.
    pub remark: String,
}

/// Known values are given to so many digits.
const KNOWN: f64 = 1e-6;

impl Number {
    /// Ours beside the printed figure of this id; it fails where none is printed.
    pub fn of(id: &str, what: &str, recomputed: f64, how: &str) -> Self {
        let figure = printed(id);
        Number {
            id: id.to_owned(),
            place: figure.map_or("", |figure| figure.place).to_owned(),
            what: what.to_owned(),
            published: figure.map_or(f64::NAN, |figure| figure.value),
            rounding: figure.map_or(0.0, |figure| figure.rounding),
            recomputed,
            unit: figure.map_or("1", |figure| figure.unit).to_owned(),
            known: None,
            outcome: Outcome::Fail,
            how: how.to_owned(),
            remark: String::new(),
        }
        .judged()
    }

    pub fn judged(mut self) -> Self {
        // A value on the edge of the rounding interval may go either way.
        let slack = 1e-9 * self.published.abs().max(1e-300);
        let agrees = (self.recomputed - self.published).abs() <= self.rounding + slack;
        self.outcome = match self.known {
            None if agrees => Outcome::Pass,
            Some(known) if !agrees && (self.recomputed / known - 1.0).abs() <= KNOWN => {
                Outcome::ExpectedFailure
            }
            _ => Outcome::Fail,
        };
        self
    }

    pub fn remark(mut self, remark: &str) -> Self {
        remark.clone_into(&mut self.remark);
        self
    }

    /// Not printed as a number.
    pub fn derived(mut self, remark: &str) -> Self {
        self.outcome = Outcome::Skipped;
        self.remark(&format!(
            "follows from what is printed, and is not printed itself; {remark}"
        ))
    }

    /// Known to differ from the print and to be this, for the reason that is given. Any other value fails.
    pub fn known(mut self, value: f64, remark: &str) -> Self {
        self.known = Some(value);
        self.judged().remark(remark)
    }

    /// In the shape that all jobs share.
    pub fn check(&self) -> Check {
        let allowed = (self.outcome != Outcome::Skipped).then_some(self.rounding);
        let quantity = format!("{}: {}", self.place, self.what);
        let id = format!("paper/{}", self.id);
        Check {
            unit: self.unit.clone(),
            ..Check::of_words(id, &quantity, self.outcome, &self.remark)
        }
        .with_limits(self.recomputed, self.published, allowed)
        .judged_by(&self.how, "half a unit of the last printed digit")
    }
}

/// Every printed number of Tables 1, 3 and 4, sections 2.2, 3.1, 4.2 and 5 and the equations behind them.
pub fn numbers() -> Vec<Number> {
    use recomputed::{of_bed, of_continuum, of_disc, of_piles, of_sums};
    [of_piles(), of_continuum(), of_disc(), of_bed(), of_sums()].concat()
}

/// All numbers and the faults of the text.
pub fn document(numbers: &[Number], faults: &[TextFault]) -> Document {
    let count = |outcome: Outcome| numbers.iter().filter(|n| n.outcome == outcome).count();
    let answer = format!(
        "{} numbers: {} agree, {} are known to differ or to be misprinted, {} are derived, {} differ unexpectedly.",
        numbers.len(),
        count(Outcome::Pass),
        count(Outcome::ExpectedFailure),
        count(Outcome::Skipped),
        count(Outcome::Fail)
    );
    let checks: Vec<Check> = numbers.iter().map(Number::check).collect();
    let table = Table::of(
        "numbers",
        "Printed numbers that need no simulation",
        numbers,
    )
    .column("place", |number| &number.place)
    .column("number", |number| &number.what)
    .column(
        "published, in brackets if not as a number",
        |number| match number.outcome {
            Outcome::Skipped => Cell::Text(format!("({})", rounded(number.published, 6))),
            _ => number.published.into(),
        },
    )
    .column("recomputed", |number| number.recomputed)
    .column("unit", |number| &number.unit)
    .column("outcome", |number| number.outcome)
    .column("how", |number| &number.how);
    let remarked = numbers.iter().filter(|number| !number.remark.is_empty());
    let remarks = Table::of("remarks", "Remarks", remarked)
        .column("number", |number| {
            format!("{}: {}", number.place, number.what)
        })
        .column("outcome", |number| number.outcome)
        .column("remark", |number| &number.remark);
    let printed = Table::of("text-faults", "Faults of the printed text", faults)
        .column("place", |fault| fault.place)
        .column("prints", |fault| fault.printed)
        .column("should be", |fault| fault.should_be)
        .column("because", |fault| fault.evidence);
    Document::new("The paper's numbers, recomputed", answer, checks).with([
        Section::new("Numbers", "").with(table).with(remarks),
        Section::new("Text", "").with(printed),
    ])
}

/// Faults of the printed text that are no single number.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextFault {
    pub place: &'static str,
    pub printed: &'static str,
    pub should_be: &'static str,
    pub evidence: &'static str,
}

/// Faults of the printed text, each with its evidence: `text_faults.json`, read.
pub fn text_faults() -> Vec<TextFault> {
    serde_json::from_str(include_str!("paper/text_faults.json")).expect("it is a list of faults")
}

/// Points of the rule on each panel.
const ORDER: usize = 16;

/// Places in [−1, 1] and their weights: the roots x of the Legendre polynomial P by Newton's method, with 2/((1−x²)P′²).
static RULE: LazyLock<[[f64; 2]; ORDER]> = LazyLock::new(|| {
    std::array::from_fn(|index| {
        // Near enough to its root that Newton's method takes no other.
        let mut x = (PI * (index as f64 + 0.75) / (ORDER as f64 + 0.5)).cos();
        // It doubles the digits each time.
        for _ in 0..8 {
            let [value, slope] = legendre(x);
            x -= value / slope;
        }
        let [_, slope] = legendre(x);
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    })
});

/// The Legendre polynomial of this order and its slope at x, |x| < 1.
fn legendre(x: f64) -> [f64; 2] {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=ORDER {
        let k = k as f64;
        let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k;
        (before, value) = (value, next);
    }
    let slope = ORDER as f64 * (x * value - before) / (x * x - 1.0);
    [value, slope]
}

/// ∫ f from `from` to `to`, of numbers, vectors or matrices, with sixteen points on each of so many panels. The ends are
/// not asked for.
pub fn integrate<T>(from: f64, to: f64, panels: u32, f: impl Fn(f64) -> T) -> T
where
    T: Mul<f64, Output = T> + Sum<T>,
{
    let half = 0.5 * (to - from) / f64::from(panels);
    (0..panels)
        .flat_map(|panel| {
            let middle = from + half * (2.0 * f64::from(panel) + 1.0);
            RULE.iter()
                .map(move |[place, weight]| (middle + half * place, half * weight))
        })
        .map(|(x, weight)| f(x) * weight)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_order_31_are_exact_and_others_nearly() {
        for power in 0..32 {
            let exact = (3f64.powi(power + 1) - 1.0) / f64::from(power + 1);
            let found = integrate(1.0, 3.0, 1, |x| x.powi(power));
            assert!((found / exact - 1.0).abs() < 1e-13, "{power}: {found}");
        }
        assert!((integrate(0.0, 60.0, 60, |x| (-x).exp()) - 1.0).abs() < 1e-14);
        assert!((integrate(0.0, PI, 3, f64::sin) - 2.0).abs() < 1e-14);
    }
}
