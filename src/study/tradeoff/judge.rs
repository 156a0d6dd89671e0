//! A method's members against the reference's, paired by cloud. And the order of convergence on cases with exact solutions: what the
//! time step does where nothing is chaotic.

use std::f64::consts::{PI, SQRT_2};
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::checks::Outcome;
use crate::study::member::{Endings, Member};
use crate::suite::{self, Grain};
use evidence::t_test::{self, Finding, Paired, paired};
use evidence::{Interval, proportion, regression};
use grains::native::{self, NativeError};
use grains::tables::Bodies;

/// A quantity of a method against the reference's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    pub key: String,
    /// Method minus reference, by cloud; clouds that lack the quantity in either are left out, and counted by
    /// [`Endings`].
    pub paired: Paired,
    /// The largest bias that is no matter, in the quantity's unit.
    pub margin: Option<f64>,
    /// Against the margin.
    pub finding: Option<Finding>,
    /// Of the two one-sided tests, the larger.
    pub p: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judgement {
    pub clouds: usize,
    /// How the method's members ended.
    pub endings: Endings,
    /// Share of members without the force, method minus reference, with its 90 % interval.
    pub missed: Option<Interval>,
    /// That share against its margin.
    pub missed_finding: Option<Finding>,
    pub differences: Vec<Difference>,
    /// The largest bias over its margin of the settled bed.
    pub bed: Option<Worst>,
    /// The same of the loaded one, missed forces included.
    pub load: Option<Worst>,
}

/// The largest bias over its margin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Worst {
    /// |bias| over margin, with the ends of that quantity's interval.
    pub error: Interval,
    /// Key of the quantity, [`MISSED_KEY`] for the share of missed forces.
    pub key: String,
}

/// Stands for the share of punches that did not get their force.
pub const MISSED_KEY: &str = "missed";
pub const MISSED_TITLE: &str = "share of missed loads";

impl Judgement {
    /// Equivalent if every quantity with a margin is, and the share of missed forces; different if one is.
    pub fn finding(&self) -> Finding {
        let of_differences = self
            .differences
            .iter()
            .filter_map(|difference| difference.finding);
        let mut all: Vec<Finding> = of_differences.chain(self.missed_finding).collect();
        if all.len() < judged().count() + 1 {
            all.push(Finding::Undecided);
        }
        t_test::together(&all)
    }

    /// What was not shown to be equivalent, in words.
    pub fn not_shown(&self) -> Vec<String> {
        let open = |title: &str, finding: Option<Finding>| {
            let word = match finding {
                Some(Finding::Equivalent) => return None,
                Some(other) => word(other),
                None => "not measured",
            };
            Some(format!("{title} ({word})"))
        };
        let quantities = judged().filter_map(|quantity| {
            let difference = self.of(quantity.key);
            open(
                quantity.title,
                difference.and_then(|difference| difference.finding),
            )
        });
        let missed = open(MISSED_TITLE, self.missed_finding);
        quantities.chain(missed).collect()
    }

    /// The largest bias over its margin, of both beds: its interval leaves out what either excludes.
    pub fn error(&self) -> Option<Interval> {
        let [bed, load] = [self.bed.as_ref()?.error, self.load.as_ref()?.error];
        Some(Interval {
            estimate: bed.estimate.max(load.estimate),
            low: bed.low.max(load.low),
            high: bed.high.max(load.high),
        })
    }

    pub fn of(&self, key: &str) -> Option<&Difference> {
        self.differences
            .iter()
            .find(|difference| difference.key == key)
    }
}

/// For people.
pub fn word(finding: Finding) -> &'static str {
    match finding {
        Finding::Equivalent => "equivalent",
        Finding::Different => "different",
        Finding::Undecided => "undecided",
    }
}

/// As a check's: what was not shown is skipped.
pub fn outcome(finding: Finding) -> Outcome {
    match finding {
        Finding::Equivalent => Outcome::Pass,
        Finding::Different => Outcome::Fail,
        Finding::Undecided => Outcome::Skipped,
    }
}

/// Judges pairs (reference, method), one a cloud, in the quantities that can be compared.
pub fn judge(pairs: &[(&Member, &Member)], comparable: impl Fn(&str) -> bool) -> Judgement {
    let endings = Endings::of(pairs.iter().map(|pair| pair.1));
    let reference = Endings::of(pairs.iter().map(|pair| pair.0));
    let compared = QUANTITIES
        .iter()
        .filter(|quantity| comparable(quantity.key));
    let differences: Vec<Difference> = compared
        .filter_map(|quantity| difference(quantity, pairs))
        .collect();
    let missed = proportion::difference(
        (reference.missed(), reference.all()),
        (endings.missed(), endings.all()),
        1.0 - 2.0 * t_test::LEVEL,
    );
    let worst = |key: &str, bias: Interval, margin| Worst {
        error: bias.over(margin).absolute(),
        key: key.to_owned(),
    };
    let largest = |moment: &str| {
        let all = differences
            .iter()
            .filter(|difference| difference.key.starts_with(moment));
        larger(all.filter_map(|difference| {
            Some(worst(
                &difference.key,
                difference.paired.difference,
                difference.margin?,
            ))
        }))
    };
    let by_chance = missed.map(|interval| worst(MISSED_KEY, interval, MISSED));
    let (bed, load) = (largest("settled."), largest("loaded."));
    Judgement {
        clouds: pairs.len(),
        endings,
        missed,
        missed_finding: missed.map(|interval| t_test::finding(&interval, MISSED)),
        differences,
        bed,
        load: larger(load.into_iter().chain(by_chance)),
    }
}

fn larger(worsts: impl Iterator<Item = Worst>) -> Option<Worst> {
    worsts.max_by(|a, b| a.error.estimate.total_cmp(&b.error.estimate))
}

/// Of a quantity; none where too few pairs have it.
pub fn difference(quantity: &Quantity, pairs: &[(&Member, &Member)]) -> Option<Difference> {
    let value = |member: &Member| member.measured.get(quantity.key).copied();
    let values = pairs.iter().filter_map(|(a, b)| value(a).zip(value(b)));
    let values: Vec<(f64, f64)> = values.collect();
    let paired = paired(&values)?;
    let margin = quantity
        .margin
        .map(|margin| margin.absolute(paired.first_mean));
    let differences: Vec<f64> = values.iter().map(|(a, b)| b - a).collect();
    let tested = margin.and_then(|margin| t_test::equivalence(&differences, margin));
    Some(Difference {
        key: quantity.key.to_owned(),
        paired,
        margin,
        finding: tested.map(|(finding, _)| finding),
        p: tested.map(|(_, p)| p),
    })
}

/// A measured quantity with its margin.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    pub key: &'static str,
    pub title: &'static str,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
    /// The largest bias that is no matter; none where the quantity is shown and judges nothing.
    pub margin: Option<Margin>,
    /// Why this margin, or why none.
    pub reason: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Margin {
    /// In the quantity's unit.
    Absolute(f64),
    /// As a share of the reference's mean.
    OfMean(f64),
}

impl Margin {
    /// In the quantity's unit, for this mean of the reference.
    pub fn absolute(&self, mean: f64) -> f64 {
        match self {
            Margin::Absolute(margin) => *margin,
            Margin::OfMean(share) => share * mean.abs(),
        }
    }
}

/// In the order of tables: `quantities.json`, read.
pub static QUANTITIES: LazyLock<Vec<Quantity>> =
    LazyLock::new(|| listed(include_str!("quantities.json")));

/// Those of beds of spheres.
pub static IN_SPACE: LazyLock<Vec<Quantity>> =
    LazyLock::new(|| listed(include_str!("quantities_in_space.json")));

fn listed(text: &'static str) -> Vec<Quantity> {
    serde_json::from_str(text).expect("it is a list of quantities")
}

/// How much more often or more rarely than the reference's may a method's punch miss the force, as a share of
/// the realizations. Beds that are left out of a mean, were their stress as far off as all of it, move it by their share: a
/// twentieth, half of what a mean's margin is.
pub const MISSED: f64 = 0.05;

/// Quantities with a margin.
pub fn judged() -> impl Iterator<Item = &'static Quantity> {
    QUANTITIES
        .iter()
        .filter(|quantity| quantity.margin.is_some())
}

/// dt over √(m/k) of the grain: from a twentieth to beyond what beds are run with.
const STEPS: [f64; 7] = [0.0125, 0.025, 0.05, 0.1, 0.2, 0.45, 0.9];

/// m.
const RADIUS: f64 = 1.0;
/// kg/m³.
const DENSITY: f64 = 1000.0;
/// m: overlap of the swing in equilibrium, and its amplitude.
const OVERLAP: f64 = 0.125;
const AMPLITUDE: f64 = 0.0625;
/// √(k/m) of one contact, and of the swing between two, rad/s.
const FREQUENCY: f64 = 100.0;
const OMEGA: f64 = FREQUENCY * SQRT_2;

const PLACES: f64 = 8.0;

/// A case at several steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    pub title: String,
    /// What the error is over.
    pub error_of: String,
    /// dt over √(m/k), and the error.
    pub points: Vec<(f64, f64)>,
    /// Slope of log error over log dt up to the paper's step, with its 95 % interval.
    pub order: Option<Interval>,
    pub expected: f64,
}

pub fn convergence() -> Result<Vec<Convergence>, NativeError> {
    Ok(vec![swing()?, bounce()?, damped_swing()?])
}

/// The slope over the steps that the scene's is one of.
fn converged(
    title: &str,
    error_of: &str,
    error: impl Fn(f64) -> Result<f64, NativeError>,
) -> Result<Convergence, NativeError> {
    let points = STEPS
        .iter()
        .map(|step| Ok((*step, error(step / FREQUENCY)?)));
    let points = points.collect::<Result<Vec<(f64, f64)>, NativeError>>()?;
    let fitted = points
        .iter()
        .filter(|point| point.0 <= 0.45 && point.1 > 0.0);
    let fitted: Vec<(f64, f64)> = fitted.map(|point| (point.0.ln(), point.1.ln())).collect();
    Ok(Convergence {
        title: title.to_owned(),
        error_of: error_of.to_owned(),
        order: regression::slope(&fitted),
        points,
        expected: 2.0,
    })
}

/// x after so many steps of a grain between two walls that both touch it all the time, m off the middle.
fn between_walls(dt: f64, alpha: f64, steps: u64) -> Result<f64, NativeError> {
    let width = 2.0 * (RADIUS - OVERLAP);
    // At rest at the start, so half a step before it moves outwards.
    let before = 0.5 * dt * OMEGA * OMEGA * (1.0 - alpha) * AMPLITUDE;
    let grain = Grain::disc([0.5 * width + AMPLITUDE, 0.0], RADIUS, DENSITY);
    let grain = grain.moving([before, 0.0]);
    Ok(last(grain, dt, alpha, &[0.0, width], steps, |bodies| bodies.x[0])? - 0.5 * width)
}

/// A number of a grain after so many steps between walls at these x.
fn last(
    grain: Grain,
    dt: f64,
    alpha: f64,
    walls: &[f64],
    steps: u64,
    number: fn(&Bodies) -> f64,
) -> Result<f64, NativeError> {
    let law = suite::springs(grain.mass * FREQUENCY * FREQUENCY / RADIUS);
    let model = suite::world(law, dt, [0.0; 2], alpha, [walls, &[]]);
    let case = suite::case("convergence", model, &[grain], vec![steps]);
    let seen = native::run_case(&case, None)?;
    let last = seen.last().expect("the moment that was asked for");
    Ok(number(&last.bodies))
}

/// The root of the mean square of errors that depend on where something falls between two steps, over so many places from 0 on.
fn averaged(error: impl Fn(f64) -> Result<f64, NativeError>) -> Result<f64, NativeError> {
    let mut squares = 0.0;
    for place in 0..PLACES as u32 {
        squares += error(place.into())?.powi(2);
    }
    Ok((squares / PLACES).sqrt())
}

/// The number of steps that is nearest to this time, and the time that they take.
fn whole_steps(time: f64, dt: f64) -> (u64, f64) {
    let steps = (time / dt).round().max(1.0);
    (steps as u64, steps * dt)
}

/// x = A cos ωt, ω² = 2k/m, after ten and a quarter periods, where the error of the phase shows.
fn swing() -> Result<Convergence, NativeError> {
    converged(
        "a grain swings between two walls, ten periods and a quarter",
        "place, over the amplitude",
        |dt| {
            let (steps, time) = whole_steps(10.25 * 2.0 * PI / OMEGA, dt);
            let found = between_walls(dt, 0.0, steps)?;
            Ok((found / AMPLITUDE - (OMEGA * time).cos()).abs())
        },
    )
}

/// A grain hits a wall at 1 m/s and flies back: the end of the contact falls between two steps. The error is
/// averaged over eight places of the touch within a step, as its size depends on the place.
fn bounce() -> Result<Convergence, NativeError> {
    converged(
        "a grain hits a wall without gravity and flies back",
        "speed after the rebound, over the speed before",
        |dt| {
            averaged(|place| {
                let gap = 1.0e-6 + dt * place / PLACES;
                let grain = Grain::disc([RADIUS + gap, 0.0], RADIUS, DENSITY).moving([-1.0, 0.0]);
                let (steps, _) = whole_steps(2.0 * PI / FREQUENCY, dt);
                Ok(last(grain, dt, 0.0, &[0.0], steps, |bodies| bodies.vx[0])? - 1.0)
            })
        },
    )
}

/// With local damping a swing speeds up with (1−α)k and slows down with (1+α)k, so a quarter period takes
/// π/2/(ω√(1∓α)) and each half swing ends at √((1−α)/(1+α)) of where it began. Read near the sixth turn, where
/// the phase does not show; the error depends on where the steps fall, so it is averaged over eight steps about dt. The sign
/// of the damping comes half a step late, but always where either force or velocity is next to nothing: order 2.
fn damped_swing() -> Result<Convergence, NativeError> {
    const ALPHA: f64 = 0.2;
    const HALVES: i32 = 6;
    let quarters = [1.0 - ALPHA, 1.0 + ALPHA].map(|factor: f64| 0.5 * PI / (OMEGA * factor.sqrt()));
    let half = quarters[0] + quarters[1];
    let turn = AMPLITUDE * ((1.0 - ALPHA) / (1.0 + ALPHA)).sqrt().powi(HALVES);
    converged(
        "the same swing with local damping 0.2, six half periods",
        "place, over the place where it turns",
        |middle| {
            averaged(|place| {
                let dt = middle * (0.93 + 0.02 * place);
                let (steps, time) = whole_steps(f64::from(HALVES) * half, dt);
                let found = between_walls(dt, ALPHA, steps)?;
                let off = time - f64::from(HALVES) * half;
                let sign = if off > 0.0 { -1.0 } else { 1.0 };
                let expected = turn * (OMEGA * (1.0 + sign * ALPHA).sqrt() * off).cos();
                Ok((found - expected) / turn)
            })
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::realization::{Ending, Specification, whole_scene};

    /// Members whose every quantity is 1 with a little that differs from cloud to cloud, times `factor`.
    fn members(factor: f64, missed: u64) -> Vec<Member> {
        (1..=100)
            .map(|realization| {
                let noise = 1.0e-4 * (realization as f64 * 0.7).sin();
                let (reached, all) = (realization > missed, QUANTITIES.iter());
                let ending = match reached {
                    true => Ending::Reached,
                    false => Ending::TargetLoadNotReached,
                };
                let keys = all.filter(|quantity| reached || !quantity.key.starts_with("loaded."));
                let measured =
                    keys.map(|quantity| (quantity.key.to_owned(), factor * (1.0 + noise)));
                let specification = Specification::native(whole_scene());
                Member {
                    measured: measured.collect(),
                    ..Member::without(&specification, realization, ending)
                }
            })
            .collect()
    }

    fn judged(first: &[Member], second: &[Member]) -> Judgement {
        let pairs: Vec<(&Member, &Member)> = first.iter().zip(second).collect();
        judge(&pairs, |_| true)
    }

    #[test]
    fn a_bias_beyond_the_smallest_margin_is_found_and_named() {
        let reference = members(1.0, 0);
        let equal = judged(&reference, &members(1.0005, 0));
        assert_eq!(equal.finding(), Finding::Equivalent);
        let found = judged(&reference, &members(1.004, 0));
        assert_eq!(found.finding(), Finding::Different);
        let worst = found.bed.expect("there are margins");
        assert!((worst.error.estimate - 2.0).abs() < 0.01, "{worst:?}");
        let load = found.load.expect("there are margins");
        assert!(load.error.estimate < worst.error.estimate, "{load:?}");
    }

    #[test]
    fn punches_that_miss_the_force_are_counted_and_decide() {
        let reference = members(1.0, 0);
        let found = judged(&reference, &members(1.0, 30));
        assert_eq!(found.endings.target_load_not_reached, 30);
        assert_eq!(found.missed_finding, Some(Finding::Different));
        assert_eq!(found.finding(), Finding::Different);
        let stress = found.of("loaded.stress.O.local_zz");
        assert_eq!(stress.map(|difference| difference.paired.pairs), Some(70));
    }

    #[test]
    fn what_was_not_measured_is_not_equivalent() {
        let mut lacking = members(1.0, 0);
        for member in &mut lacking {
            member.measured.remove("loaded.stress.B.local_zz");
        }
        let found = judged(&members(1.0, 0), &lacking);
        assert_eq!(found.finding(), Finding::Undecided);
    }

    #[test]
    fn failures_of_one_kind_are_counted_together() {
        let mut broken = members(1.0, 0);
        for (index, member) in broken.iter_mut().enumerate().take(7) {
            member.ending = Ending::Failed(format!("lost grain {index} at x={}.5", index * 17));
            member.measured.clear();
        }
        let found = judged(&members(1.0, 0), &broken);
        assert_eq!(found.endings.failed.len(), 1, "{:?}", found.endings.failed);
        assert_eq!(found.endings.missed(), 7);
    }

    #[test]
    fn orders_are_what_theory_says() {
        for case in convergence().expect("cases run") {
            let order = case.order.expect("seven steps");
            let off = (order.estimate - case.expected).abs();
            assert!(off < 0.35, "{case:?}");
        }
    }
}
