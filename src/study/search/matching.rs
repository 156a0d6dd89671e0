//! What a wave finds: means with their noise, emulators of them, and the settings that are left.

use std::collections::BTreeMap;

use evidence::emulator::{Emulator, Observation};
use evidence::history::{CUT, Candidate, Match, Target};
use evidence::moments::{mean, median, standard_deviation};
use evidence::random::Key;
use evidence::{Interval, in_parallel, proportion};
use serde::{Deserialize, Serialize};

use crate::paper::published::{Of, PUBLISHED, Published};
use crate::study::member::{Member, Members};
use crate::study::realization::{Ending, Setting};
use crate::study::search::space::{AXES, snap};
use crate::study::search::{OF_BED, Plan};

const KEY: Key = *b"crossgrain: candidates of search";
/// Settings that are looked at.
const CANDIDATES: usize = 20_000;
/// An observed variance counts as much as its degrees of freedom, the mean variance of the wave as much as this.
const POOLED: f64 = 10.0;
/// An emulator whose deviations must be made larger by more than this does not follow the simulation.
const MOST_INFLATED: f64 = 1.5;
/// Bins of an axis in the maps.
pub const BINS: usize = 6;
/// Settings that are shown.
const SHOWN: usize = 12;
/// Realizations of the paper, "about a thousand", of an exponential stress.
const REALIZATIONS: f64 = 1000.0;
/// Under the punch and far beside it: no packing bears more there.
const EXCHANGED: [&str; 2] = ["stress.O", "stress.B"];
/// The id of the share of punches that get the force: our demand, printed nowhere.
pub const REACHED: &str = "reached";

/// Means that a setting gave.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observed {
    pub at: Vec<f64>,
    /// Unique over all waves; noise is common in a bed's loads.
    pub bed: u64,
    /// By the figure's id. Files call it `of`.
    #[serde(rename = "of")]
    pub sampled: BTreeMap<String, Sampled>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampled {
    /// Packings.
    pub count: usize,
    pub mean: f64,
    /// Of the mean.
    pub variance: f64,
}

/// A published figure as a target.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    pub id: String,
    pub title: String,
    pub unit: String,
    pub value: f64,
    /// Of how well the published value is known.
    pub deviation: f64,
    /// Of the noise of loads on one bed.
    pub correlation: f64,
    /// By how much the emulator's deviations were made larger, so that they are those of its errors where a bed is left out.
    pub inflation: f64,
    /// Median deviation of what is expected where nothing was run, over the candidates.
    pub uncertainty: f64,
    /// The least implausibility of this figure alone.
    pub least: f64,
}

impl Figure {
    /// Whether its emulator is about as good as it says.
    pub fn is_sound(&self) -> bool {
        self.inflation <= MOST_INFLATED
    }
}

/// A setting with what is expected of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Expectation {
    pub at: Vec<f64>,
    pub implausibility: f64,
    /// Mean and deviation of each figure.
    pub expected: Vec<[f64; 2]>,
}

/// Two figures that are hard to have at once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Odds {
    pub figures: [String; 2],
    /// The least, over all settings, of the larger of both implausibilities.
    pub least: f64,
}

/// Two axes over all others: by rows of the second axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Map {
    pub axes: [usize; 2],
    /// The least implausibility of each bin; none where there is no setting.
    pub least: Vec<Option<f64>>,
    /// The share of each bin that is left (optical depth).
    pub left: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Search {
    pub wave: u64,
    pub scene_digest: String,
    pub clouds: u64,
    pub axes: Vec<String>,
    /// Those of earlier waves first.
    pub observed: Vec<Observed>,
    pub figures: Vec<Figure>,
    /// The share of the space that is left, of so many candidates.
    pub left: f64,
    pub candidates: usize,
    /// The least implausible first.
    pub best: Vec<Expectation>,
    pub odds: Vec<Odds>,
    pub maps: Vec<Map>,
    /// Of the settings that were run, those that are left where their own means are the targets and their bed is left out.
    pub found_again: Option<Interval>,
    /// The least implausibility of figures that cannot be: as published, but with the stresses under the punch and far beside it exchanged.
    pub of_impossible: Option<f64>,
}

/// Whether a quantity stays in the rows: the bed before the load, and what the load adds.
pub fn keep(key: &str) -> bool {
    let of_bed = [
        "settled.height.",
        "settled.porosity.",
        "settled.support.",
        "loaded.punch.",
    ];
    of_bed.iter().any(|prefix| key.starts_with(prefix))
        || key.contains(".stress.") && (key.ends_with(".local_zz") || key.ends_with(".grain_zz"))
}

/// Targets: height and porosity, which are printed, and the continuum's means, which the paper says its own equal.
fn published() -> impl Iterator<Item = &'static Published> {
    PUBLISHED
        .iter()
        .filter(|figure| figure.statistic == Of::Mean)
}

/// A stress is known as well as means of a thousand realizations could show that it is the paper's, and to its last printed digit, in
/// Table 4 a tenth of a kPa; a bed to half of its printed scatter. Nothing is added for what the model itself is off.
fn deviation(figure: &Published) -> f64 {
    match figure.unit {
        "Pa" => (figure.value.powi(2) / REALIZATIONS + 50.0f64.powi(2) / 3.0).sqrt(),
        _ => 0.5 * figure.tolerance,
    }
}

type Fitted = Vec<(Target, Emulator)>;
type Matched<'a> = Match<'a, fn(&mut [f64])>;

impl Search {
    /// Of the rows that are there.
    pub fn of(plan: &Plan, members: &Members) -> Self {
        let (observed, correlations) = observed(plan, members);
        let reached = (
            REACHED,
            "share of punches that get the force",
            "1",
            1.0,
            0.02,
        );
        let means = published().map(|figure| {
            (
                &figure.id[..],
                &figure.title[..],
                figure.unit,
                figure.value,
                deviation(figure),
            )
        });
        let all = means.chain([reached]);
        let figures = all.map(|(id, title, unit, value, deviation)| Figure {
            id: id.to_owned(),
            title: title.to_owned(),
            unit: unit.to_owned(),
            value,
            deviation,
            correlation: correlations.get(id).copied().unwrap_or(0.0),
            inflation: f64::INFINITY,
            uncertainty: f64::INFINITY,
            least: 0.0,
        });
        let mut search = Search {
            wave: plan.wave,
            scene_digest: plan.base.digest(),
            clouds: plan.beds.clouds(),
            axes: AXES.iter().map(|axis| axis.name.to_owned()).collect(),
            observed: plan.before.iter().cloned().chain(observed).collect(),
            figures: figures.collect(),
            left: 1.0,
            ..Search::default()
        };
        if let Some(fitted) = search.fitted() {
            search.judge(&fitted);
        }
        search
    }

    /// An emulator of each figure; none while there is too little of one.
    pub fn fitted(&self) -> Option<Fitted> {
        let fit = |index: usize| {
            let figure = &self.figures[index];
            let (value, deviation) = (figure.value, figure.deviation);
            let observed = self.observed.iter().filter_map(|observed| {
                let sampled = observed.sampled.get(&figure.id)?;
                Some(Observation {
                    at: observed.at.clone(),
                    group: observed.bed as usize,
                    mean: sampled.mean,
                    variance: sampled.variance,
                })
            });
            let emulator = Emulator::of(observed.collect(), figure.correlation)?;
            Some((Target { value, deviation }, emulator))
        };
        let fitted = in_parallel(self.figures.len(), fit);
        fitted.into_iter().collect()
    }

    pub fn matched<'a>(&self, fitted: &'a Fitted) -> Matched<'a> {
        Match {
            figures: fitted,
            axes: AXES.len(),
            snap,
        }
    }

    /// Settings that are left, from all over the space and from near the best of them.
    pub fn left(&self, matched: &Matched<'_>) -> Vec<Candidate> {
        let mut all = matched.candidates(&KEY, CANDIDATES);
        all.extend(matched.better(&KEY, &all, Candidate::worst));
        all.retain(Candidate::is_left);
        all
    }

    fn judge(&mut self, fitted: &Fitted) {
        let matched = self.matched(fitted);
        let all = matched.candidates(&KEY, CANDIDATES);
        self.candidates = all.len();
        self.left =
            all.iter().filter(|candidate| candidate.is_left()).count() as f64 / all.len() as f64;
        let better = matched.better(&KEY, &all, Candidate::worst);
        let mut best: Vec<&Candidate> = all.iter().chain(&better).collect();
        best.sort_by(|a, b| a.worst().total_cmp(&b.worst()));
        let expectation = |candidate: &&Candidate| {
            let expected = fitted.iter().map(|(_, emulator)| {
                let found = emulator.at(&candidate.at);
                [found.mean, found.variance.sqrt()]
            });
            Expectation {
                at: candidate.at.clone(),
                implausibility: candidate.worst(),
                expected: expected.collect(),
            }
        };
        self.best = best.iter().take(SHOWN).map(expectation).collect();
        let least = |one: usize, other: usize| {
            let worse = |candidate: &Candidate| {
                candidate.implausibilities[one].max(candidate.implausibilities[other])
            };
            let found = matched.better(&KEY, &all, worse);
            found.first().map_or(f64::INFINITY, worse)
        };
        for (index, (figure, (_, emulator))) in self.figures.iter_mut().zip(fitted).enumerate() {
            figure.inflation = emulator.inflation;
            let deviation = |candidate: &Candidate| emulator.at(&candidate.at).variance.sqrt();
            let deviations: Vec<f64> = all.iter().take(500).map(deviation).collect();
            figure.uncertainty = median(&deviations).unwrap_or(f64::INFINITY);
            figure.least = least(index, index);
        }
        self.found_again = found_again(fitted);
        self.of_impossible = self.of_impossible(fitted);
        for one in 0..self.figures.len() {
            for other in one + 1..self.figures.len() {
                self.odds.push(Odds {
                    figures: [one, other].map(|index| self.figures[index].id.clone()),
                    least: least(one, other),
                });
            }
        }
        self.odds.sort_by(|a, b| b.least.total_cmp(&a.least));
        let pairs = (0..AXES.len()).flat_map(|one| (0..one).map(move |other| [other, one]));
        self.maps = pairs.map(|axes| Map::of(axes, &all, &better)).collect();
    }

    fn of_impossible(&self, fitted: &Fitted) -> Option<f64> {
        let place = |id: &str| self.figures.iter().position(|figure| figure.id == id);
        let (one, other) = (place(EXCHANGED[0])?, place(EXCHANGED[1])?);
        let mut exchanged: Fitted = fitted.clone();
        exchanged[one].0 = fitted[other].0;
        exchanged[other].0 = fitted[one].0;
        let matched = self.matched(&exchanged);
        let all = matched.candidates(&KEY, CANDIDATES);
        let better = matched.better(&KEY, &all, Candidate::worst);
        better.first().map(Candidate::worst)
    }

    /// Whether every emulator is as good as it says.
    pub fn is_sound(&self) -> bool {
        self.figures.iter().all(Figure::is_sound)
    }

    pub fn is_none_left(&self) -> bool {
        let best = self.best.first();
        best.is_some_and(|expectation| expectation.implausibility > CUT)
    }
}

impl Map {
    fn of(axes: [usize; 2], all: &[Candidate], better: &[Candidate]) -> Self {
        let mut least = vec![None; BINS * BINS];
        let (mut left, mut count) = (vec![0.0; BINS * BINS], vec![0.0; BINS * BINS]);
        let bin = |candidate: &Candidate| {
            let [x, y] =
                axes.map(|axis| ((candidate.at[axis] * BINS as f64) as usize).min(BINS - 1));
            y * BINS + x
        };
        for candidate in all {
            left[bin(candidate)] += f64::from(u8::from(candidate.is_left()));
            count[bin(candidate)] += 1.0;
        }
        for candidate in all.iter().chain(better) {
            let (least, worst) = (&mut least[bin(candidate)], candidate.worst());
            *least = Some(least.map_or(worst, |value: f64| value.min(worst)));
        }
        let shares = left.iter().zip(count);
        let left = shares.map(|(left, count)| left / f64::max(count, 1.0));
        let left = left.collect();
        Map { axes, least, left }
    }
}

/// Whether a setting is left by a figure of its own, by its coordinates; noise is in the variance.
fn found_again(fitted: &Fitted) -> Option<Interval> {
    let mut left: BTreeMap<Vec<u64>, bool> = BTreeMap::new();
    for (_, emulator) in fitted {
        for (predicted, own) in emulator.left_out().iter().zip(&emulator.observed) {
            let at = own.at.iter().map(|at| at.to_bits()).collect();
            let near = (predicted.mean - own.mean).abs() <= CUT * predicted.variance.sqrt();
            *left.entry(at).or_insert(true) &= near;
        }
    }
    let found = left.values().filter(|near| **near).count();
    proportion::wilson(found, left.len(), 0.95)
}

/// Values of a figure by cloud.
type Values = BTreeMap<u64, f64>;

/// The means of the wave's own settings, and how strongly those of one bed hang together, by figure.
fn observed(plan: &Plan, members: &Members) -> (Vec<Observed>, BTreeMap<String, f64>) {
    let beds = plan.beds.0.iter().enumerate();
    let all = beds.flat_map(|(bed, loads)| {
        loads
            .iter()
            .map(move |setting| (bed, setting, members.of(setting)))
    });
    let all: Vec<(usize, &Setting, Vec<&Member>)> = all.collect();
    let observed = all.iter().map(|(bed, setting, _)| Observed {
        at: setting.at.clone(),
        bed: plan.wave * OF_BED + *bed as u64,
        sampled: BTreeMap::new(),
    });
    let mut observed: Vec<Observed> = observed.collect();
    let mut correlations = BTreeMap::new();
    for id in published().map(|figure| &figure.id[..]).chain([REACHED]) {
        let value = |row: &Member| match published().find(|figure| figure.id == id) {
            Some(figure) => row.published(figure),
            None => Some(f64::from(u8::from(row.ending == Ending::Reached))),
        };
        let values = all.iter().map(|(_, _, rows)| {
            let rows = rows.iter();
            rows.filter_map(|row| Some((row.realization, value(row)?)))
                .collect()
        });
        let values: Vec<Values> = values.collect();
        let samples = values
            .iter()
            .map(|clouds| clouds.values().copied().collect());
        let samples: Vec<Vec<f64>> = samples.collect();
        let enough = |sample: &&Vec<f64>| sample.len() > 2;
        let variance = |sample: &Vec<f64>| standard_deviation(sample).powi(2);
        let variances: Vec<f64> = samples.iter().filter(enough).map(variance).collect();
        let pooled = mean(&variances);
        for (observed, sample) in observed
            .iter_mut()
            .zip(&samples)
            .filter(|pair| enough(&pair.1))
        {
            let (count, mean) = (sample.len(), mean(sample));
            let free = (count - 1) as f64;
            let variance = match id {
                // Half a packing more of each kind: where all reach it, the share is not known to the last digit.
                REACHED => {
                    let share = (mean * count as f64 + 0.5) / (count + 1) as f64;
                    share * (1.0 - share) / count as f64
                }
                _ => {
                    let all = free * variance(sample) + POOLED * pooled;
                    all / (free + POOLED) / count as f64
                }
            };
            let sampled = Sampled {
                count,
                mean,
                variance,
            };
            observed.sampled.insert(id.to_owned(), sampled);
        }
        let beds: Vec<usize> = all.iter().map(|row| row.0).collect();
        correlations.insert(id.to_owned(), correlation(&beds, &values));
    }
    observed.retain(|observed| !observed.sampled.is_empty());
    (observed, correlations)
}

/// The mean product of the standardized deviations of two loads on one bed, in 0 to 0.95.
fn correlation(beds: &[usize], values: &[Values]) -> f64 {
    let standard = |values: &Values| -> Option<Values> {
        let own: Vec<f64> = values.values().copied().collect();
        let (middle, unit) = (mean(&own), standard_deviation(&own));
        let own = values.iter();
        let all = own.map(|(cloud, value)| (*cloud, (value - middle) / unit));
        (unit > 0.0).then(|| all.collect())
    };
    let all = beds.iter().zip(values);
    let all = all.filter_map(|(bed, values)| Some((*bed, standard(values)?)));
    let all: Vec<(usize, Values)> = all.collect();
    let mut products = Vec::new();
    for (index, (bed, one)) in all.iter().enumerate() {
        for (_, other) in all[..index].iter().filter(|entry| entry.0 == *bed) {
            let both = one.iter();
            let both = both.filter_map(|(cloud, a)| Some(a * other.get(cloud)?));
            let free = one.len().min(other.len()).saturating_sub(1).max(1) as f64;
            products.push(both.sum::<f64>() / free);
        }
    }
    match products.is_empty() {
        true => 0.0,
        false => mean(&products).clamp(0.0, 0.95),
    }
}
