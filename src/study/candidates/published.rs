//! Whether a published figure comes out of a setting.

use serde::{Deserialize, Serialize};

use crate::paper::published::{Of, Published};
use crate::study::member::Member;
use crate::study::realization::Ending;
use evidence::moments::mean_interval;
use evidence::t_test::paired;
use evidence::zeros::Parted;
use evidence::{Interval, bootstrap, proportion};

/// Confidence of the intervals that are shown.
pub const LEVEL: f64 = 0.95;
/// Fewer packings give no interval of a mean, or of a variation or share, that is worth a verdict.
const FEWEST: [usize; 2] = [3, 8];
/// Stresses of a setting in which a smaller share of the punches gets the force are those of its firmer beds.
const ENOUGH_REACHED: f64 = 0.9;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The interval of the level that is corrected for all verdicts lies within value ± tolerance.
    ComesOut,
    /// It lies outside.
    DoesNot,
    /// It holds one of their ends: more packings would tell.
    Undecided,
    /// Too few packings gave the quantity.
    Skipped,
}

/// A published figure in one setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judged {
    pub id: String,
    /// Packings that gave the quantity, of a shape those whose grain bears load.
    pub packings: usize,
    /// Of a shape, the share of packings whose grain bears nothing.
    pub zeros: Option<Interval>,
    /// Ours with its 95 % interval over packings.
    pub value: Option<Interval>,
    /// Against value ± tolerance.
    pub verdict: Verdict,
    /// Whether the estimate lies within value ± tolerance, whatever the interval.
    pub near: bool,
    /// Whether it holds only for the beds that bore the force, as fewer than 90 % did.
    pub conditional: bool,
    /// Of a mean: what it is more than in the base, on the same clouds.
    pub change: Option<Interval>,
}

/// Judges a setting's members by intervals of this level; `base` are those of the base scene.
pub fn judge(figure: &Published, rows: &[&Member], base: &[&Member], level: f64) -> Judged {
    let values: Vec<f64> = rows
        .iter()
        .filter_map(|row| row.published(figure))
        .collect();
    // Shapes are those of grains that bear load.
    let parted = (figure.of != Of::Mean).then(|| Parted::of(&values));
    let zeros = parted.as_ref().and_then(|of| of.share_of_zeros(LEVEL));
    let values = parted.map_or(values, |of| of.others);
    let fewest = FEWEST[usize::from(figure.of != Of::Mean)];
    let enough = Some(&values).filter(|values| values.len() >= fewest);
    let at = |level: f64| interval(figure.of, enough?, level);
    let found = at(LEVEL);
    let [low, high] = figure.limits();
    let near = found.is_some_and(|of| low <= of.estimate && of.estimate <= high);
    Judged {
        id: figure.id.to_owned(),
        packings: values.len(),
        zeros,
        verdict: verdict(at(level), low, high),
        near,
        conditional: figure.key.starts_with("loaded.") && share_reached(rows) < ENOUGH_REACHED,
        change: (figure.of == Of::Mean)
            .then(|| change(figure, rows, base))
            .flatten(),
        value: found,
    }
}

fn verdict(found: Option<Interval>, low: f64, high: f64) -> Verdict {
    match found {
        None => Verdict::Skipped,
        Some(found) if low <= found.low && found.high <= high => Verdict::ComesOut,
        Some(found) if found.high < low || high < found.low => Verdict::DoesNot,
        Some(_) => Verdict::Undecided,
    }
}

/// The share of the members in which the punch got its force; of none, 0.
fn share_reached(rows: &[&Member]) -> f64 {
    let reached = rows.iter().filter(|row| row.ending == Ending::Reached);
    reached.count() as f64 / rows.len().max(1) as f64
}

/// t for a mean, the bootstrap (BCa) for a variation, the influence function for a share.
fn interval(of: Of, values: &[f64], level: f64) -> Option<Interval> {
    match of {
        Of::Mean => mean_interval(values, level),
        Of::Variation => bootstrap::coefficient_of_variation(values, level),
        Of::ShareAbove(multiple) => {
            proportion::above_multiple_of_mean(values, f64::from(multiple), level)
        }
    }
}

fn change(figure: &Published, rows: &[&Member], base: &[&Member]) -> Option<Interval> {
    let pairs: Vec<(f64, f64)> = rows
        .iter()
        .filter_map(|row| {
            let same = base.iter().find(|of| of.realization == row.realization)?;
            // The base itself has no change.
            (same.specification != row.specification).then_some(())?;
            Some((same.published(figure)?, row.published(figure)?))
        })
        .collect();
    Some(paired(&pairs)?.difference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::published::published;

    fn row(realization: u64, ending: Ending, measured: &[(&str, f64)]) -> Member {
        Member {
            specification: "abc".to_owned(),
            realization,
            ending,
            pour_steps: 1,
            load_steps: 1,
            cost: None,
            loaded_state: None,
            measured: measured
                .iter()
                .map(|(key, value)| ((*key).to_owned(), *value))
                .collect(),
        }
    }

    /// Twelve beds around this height.
    fn heights(middle: f64, spread: f64) -> Vec<Member> {
        (0..12)
            .map(|index| {
                let off = spread * (f64::from(index) - 5.5);
                let height = middle + off;
                row(
                    1 + u64::from(index as u32),
                    Ending::Reached,
                    &[("settled.height.mean_surface", height)],
                )
            })
            .collect()
    }

    fn judged(id: &str, rows: &[Member]) -> Judged {
        let rows: Vec<&Member> = rows.iter().collect();
        judge(
            published(id).expect("a published figure"),
            &rows,
            &[],
            LEVEL,
        )
    }

    #[test]
    fn a_verdict_goes_each_way() {
        let of = |middle, spread| judged("height", &heights(middle, spread)).verdict;
        assert_eq!(of(0.46, 0.001), Verdict::ComesOut);
        assert_eq!(of(0.48, 0.001), Verdict::DoesNot);
        assert_eq!(of(0.469, 0.003), Verdict::Undecided);
        // Far off or not, where the spread is wide nothing is decided.
        assert_eq!(of(0.48, 0.02), Verdict::Undecided);
        let few = heights(0.46, 0.001);
        assert_eq!(judged("height", &few[..2]).verdict, Verdict::Skipped);
        assert_eq!(judged("stress.O", &few).verdict, Verdict::Skipped);
    }

    #[test]
    fn stresses_of_the_firmer_beds_alone_are_flagged() {
        let stresses = |sunk: usize| -> Vec<Member> {
            (0..20)
                .map(|index| {
                    if index < sunk {
                        row(index as u64, Ending::TargetLoadNotReached, &[])
                    } else {
                        let value = 13.6e3 + 10.0 * index as f64;
                        let key = "loaded.stress.O.local_zz";
                        row(index as u64, Ending::Reached, &[(key, value)])
                    }
                })
                .collect()
        };
        assert!(!judged("stress.O", &stresses(2)).conditional);
        let found = judged("stress.O", &stresses(3));
        assert!(found.conditional);
        assert_eq!(found.packings, 17);
        assert_eq!(found.verdict, Verdict::ComesOut);
    }

    #[test]
    fn shapes_of_exponential_and_of_equal_stresses() {
        let of = |stress: &dyn Fn(f64) -> f64, count: u32| -> Vec<Member> {
            (0..count)
                .map(|index| {
                    let share = (f64::from(index) + 0.5) / f64::from(count);
                    let key = "loaded.stress.O.grain_zz";
                    row(u64::from(index), Ending::Reached, &[(key, stress(share))])
                })
                .collect()
        };
        let exponential = of(&|share: f64| -(1.0 - share).ln(), 2000);
        assert_eq!(
            judged("variation.O", &exponential).verdict,
            Verdict::ComesOut
        );
        let narrow = of(&|share: f64| 1.0 + share, 40);
        assert_eq!(judged("variation.O", &narrow).verdict, Verdict::DoesNot);
        assert_eq!(judged("beyond.O", &narrow).verdict, Verdict::DoesNot);
        assert_eq!(judged("beyond.O", &narrow[..7]).verdict, Verdict::Skipped);
    }

    #[test]
    fn a_change_is_that_of_the_same_clouds() {
        let base = heights(0.46, 0.01);
        let mut moved = heights(0.47, 0.01);
        for row in &mut moved {
            row.specification = "other".to_owned();
        }
        let figure = published("height").expect("a published figure");
        let (moved, base): (Vec<&Member>, Vec<&Member>) =
            (moved.iter().collect(), base.iter().collect());
        let found = judge(figure, &moved, &base, LEVEL)
            .change
            .expect("twelve pairs");
        assert!((found.estimate - 0.01).abs() < 1.0e-12);
        assert!(found.high - found.low < 1.0e-9);
        assert!(judge(figure, &base, &base, LEVEL).change.is_none());
    }
}
