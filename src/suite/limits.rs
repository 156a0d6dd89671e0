//! Proof that the ladder can fail: for each fault and rung the smallest size that the rung notices,
//! and how often a rung cries wolf when nothing is wrong.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::Serialize;

use super::facts::{self, Answer};
use super::ladder::{Ladder, native_tracks, verdict};
use super::parity::{self, InYade, ParityRung};
use super::precision::{self, Precisions};
use super::{Group, Line, Rung, Track};
use crate::compare::Verdict;
use crate::interrupt::asked_to_end;
use grains::case::Case;
use grains::native::perturb::{Quantity, Switch};
use grains::native::{CaseOptions, Perturbation, watch_case};

/// Sizes are looked for between 10 to the power of these.
const DECADES: [f64; 2] = [-16.0, -0.3];
/// Halvings of that range: the size found is right within a tenth of a decade.
const HALVINGS: u32 = 8;
/// A fault of this relative size or larger must be noticed by at least one rung.
pub const MUST_NOTICE: f64 = 1.0e-9;
/// Runs of each rung in which nothing is wrong.
pub const FALSE_ALARM_RUNS: u32 = 20;

/// What a rung makes of one fault.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Limit {
    /// The fault changes nothing in the rung's cases.
    Without,
    /// The fault changes the cases, and the rung does not notice it at any size.
    Blind,
    /// The smallest relative size that it notices.
    From {
        /// Relative, within a tenth of a decade.
        size: f64,
    },
    /// It notices a fault that has no size.
    Notices,
}

/// What may differ where nothing is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sound {
    /// Velocities and spins at the start, in last bits.
    OtherStarts,
    /// The stiffness of everything, on both sides of a comparison.
    OtherStiffness,
    /// The neighbour lists only: numbers are compared with a record, bit by bit, or nothing moves.
    OtherLists,
}

/// A rung's row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RungLimits {
    /// The rung's name.
    pub rung: String,
    /// What kind of evidence it gives.
    pub group: Group,
    /// One a fault, in the order of [`Limits::faults`].
    pub limits: Vec<Limit>,
    /// What was different in runs in which nothing was wrong.
    pub sound: Sound,
    /// Runs in which nothing was wrong.
    pub sound_runs: u32,
    /// How many of them failed.
    pub false_alarms: u32,
}

/// The table of detection limits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limits {
    /// The faults, as `--perturb` takes them, without their sizes.
    pub faults: Vec<String>,
    /// Whether each fault has a size.
    pub sized: Vec<bool>,
    /// A row a rung.
    pub rungs: Vec<RungLimits>,
}

/// A fault without its size.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Sized(Quantity),
    Switched(Switch),
}

fn faults() -> Vec<Fault> {
    let sized = Perturbation::quantities().map(Fault::Sized);
    sized
        .chain(Perturbation::switches().map(Fault::Switched))
        .collect()
}

impl Limits {
    /// The smallest size of a fault that any rung notices; 0 for a noticed fault without size.
    pub fn smallest(&self, fault: usize) -> Option<f64> {
        let noticed = self
            .rungs
            .iter()
            .filter_map(|rung| match rung.limits[fault] {
                Limit::From { size } => Some(size),
                Limit::Notices => Some(0.0),
                Limit::Without | Limit::Blind => None,
            });
        noticed.min_by(f64::total_cmp)
    }

    /// What must hold of the table, as lines.
    pub fn lines(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        for (index, fault) in self.faults.iter().enumerate() {
            lines.push(Line {
                // Which rung it is stands in the table: the name of a check is the same whoever notices.
                quantity: format!("{fault}: smallest size noticed"),
                unit: "1".to_owned(),
                value: self.smallest(index).unwrap_or(f64::INFINITY),
                expected: 0.0,
                tolerance: MUST_NOTICE,
                basis: "every fault must be noticed by at least one rung".to_owned(),
            });
        }
        let count = |of: &dyn Fn(&RungLimits) -> bool| {
            self.rungs.iter().filter(|rung| of(rung)).count() as f64
        };
        let noticing = |limit: &Limit| matches!(limit, Limit::From { .. } | Limit::Notices);
        let none = |quantity: &str, value: f64, basis: &str| Line {
            quantity: quantity.to_owned(),
            unit: "1".to_owned(),
            value,
            expected: 0.0,
            tolerance: 0.0,
            basis: basis.to_owned(),
        };
        lines.push(none(
            "rungs that notice nothing",
            count(&|rung| !rung.limits.iter().any(noticing)),
            "a check that cannot fail is none",
        ));
        lines.push(none(
            "rungs that cry wolf",
            count(&|rung| rung.false_alarms > 0),
            "other neighbour lists and last bits of the start are no faults",
        ));
        lines
    }
}

/// A rung of either kind, ready to be run with a fault.
enum Subject<'a> {
    Solo(&'a Rung),
    Parity(&'a ParityRung, &'a Track),
    Facts(&'a [Answer], Vec<Case>),
    Precision(&'a Precisions),
}

impl Subject<'_> {
    fn cases(&self) -> &[Case] {
        match self {
            Subject::Solo(rung) => &rung.cases,
            Subject::Parity(rung, _) => std::slice::from_ref(&rung.case),
            Subject::Facts(_, probes) => probes,
            Subject::Precision(of) => std::slice::from_ref(&of.case),
        }
    }

    fn name(&self) -> &str {
        match self {
            Subject::Solo(rung) => rung.name,
            Subject::Parity(rung, _) => &rung.name,
            Subject::Facts(..) => "facts",
            Subject::Precision(_) => "precision",
        }
    }

    fn group(&self) -> Group {
        match self {
            Subject::Solo(rung) => rung.group,
            Subject::Parity(rung, _) => rung.group,
            Subject::Facts(..) => Group::Parity,
            Subject::Precision(_) => Group::Precision,
        }
    }

    /// Whether the rung fails.
    fn fails(&self, cases: &[Case], options: &CaseOptions) -> bool {
        match self {
            Subject::Solo(rung) => match native_tracks(cases, options) {
                Ok(tracks) => verdict(&(rung.judge)(&tracks)) == Verdict::Fail,
                Err(_) => true,
            },
            Subject::Parity(_, truth) => cases.iter().any(|case| parts(case, truth, options)),
            Subject::Facts(answers, _) => match facts::lines(answers, *options) {
                Ok(lines) => verdict(&lines) == Verdict::Fail,
                Err(_) => true,
            },
            Subject::Precision(of) => match of.errors(*options) {
                Ok(errors) => verdict(&precision::lines(&errors)) == Verdict::Fail,
                Err(_) => true,
            },
        }
    }

    fn notices(&self, fault: Perturbation) -> bool {
        let changes = |case: &Case| fault.changes_case(&case.model, &case.bodies);
        let options = CaseOptions {
            fault: Some(fault),
            ..CaseOptions::default()
        };
        self.cases().iter().any(changes) && self.fails(self.cases(), &options)
    }

    fn limit(&self, fault: Fault) -> Limit {
        let largest = match fault {
            Fault::Switched(switch) => Perturbation::Switched(switch),
            Fault::Sized(quantity) => Perturbation::Sized(quantity, 10f64.powf(DECADES[1])),
        };
        let changes = |case: &Case| largest.changes_case(&case.model, &case.bodies);
        if !self.cases().iter().any(changes) {
            return Limit::Without;
        }
        if !self.notices(largest) {
            return Limit::Blind;
        }
        let Fault::Sized(quantity) = fault else {
            return Limit::Notices;
        };
        let [mut low, mut high] = DECADES;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.notices(Perturbation::Sized(quantity, 10f64.powf(middle))) {
                high = middle;
            } else {
                low = middle;
            }
        }
        Limit::From {
            size: 10f64.powf(high),
        }
    }

    /// What can be different without anything being wrong.
    fn sound(&self) -> Sound {
        let bodies = self.cases().iter().map(|case| &case.bodies);
        let moves = bodies.clone().any(|bodies| {
            let all = bodies.vx.iter().chain(&bodies.vz).chain(&bodies.spin);
            all.into_iter().any(|value| *value != 0.0)
        });
        match self.group() {
            Group::Exact if moves => Sound::OtherStarts,
            Group::Symmetry => Sound::OtherStiffness,
            _ => Sound::OtherLists,
        }
    }

    /// How many of the runs in which nothing is wrong fail.
    fn false_alarms(&self) -> u32 {
        let mut random = ChaCha8Rng::from_seed(*b"crossgrain: runs without a fault");
        (0..FALSE_ALARM_RUNS)
            .filter(|_| {
                let options = CaseOptions {
                    fault: None,
                    skin_over_radius: 0.02 + 0.5 * uniform(&mut random),
                    ..CaseOptions::default()
                };
                let mut cases = self.cases().to_vec();
                match self.sound() {
                    Sound::OtherStarts => cases.iter_mut().for_each(|c| nudge(c, &mut random)),
                    Sound::OtherStiffness => {
                        let factor = 0.97 + 0.06 * uniform(&mut random);
                        cases.iter_mut().for_each(|c| c.model.law.modulus *= factor);
                    }
                    Sound::OtherLists => {}
                }
                self.fails(&cases, &options)
            })
            .count() as u32
    }
}

/// Whether the native engine parts from a track, looked at moment by moment.
fn parts(case: &Case, truth: &Track, options: &CaseOptions) -> bool {
    let mut moments = truth.iter();
    let mut apart = false;
    let run = watch_case(case, options, &mut |snapshot| {
        apart |= moments
            .next()
            .is_none_or(|truth| parity::differ(&snapshot, truth));
        !apart
    });
    apart || run.is_err()
}

/// Moves every velocity and spin by a last bit, up or down or not at all.
fn nudge(case: &mut Case, random: &mut ChaCha8Rng) {
    let bodies = &mut case.bodies;
    for column in [&mut bodies.vx, &mut bodies.vz, &mut bodies.spin] {
        for value in column.iter_mut() {
            *value *= match random.next_u64() % 3 {
                0 => 1.0 + f64::EPSILON,
                1 => 1.0 - f64::EPSILON,
                _ => 1.0,
            };
        }
    }
}

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// What YADE has to say, for the rungs that take both engines.
#[derive(Debug, Clone, Copy, Default)]
pub struct FromYade<'a> {
    /// The parity rungs.
    pub parity: &'a [InYade],
    /// Facts of the scenes.
    pub answers: &'a [Answer],
    /// The case of rounding errors in every precision.
    pub precisions: Option<&'a Precisions>,
}

/// Fills the table for all rungs, those that take YADE with what it has to say of them; `done` hears of
/// each finished rung.
pub fn limits(
    ladder: &Ladder,
    in_yade: FromYade<'_>,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Limits {
    let faults = faults();
    let mut subjects: Vec<Subject> = ladder.solo.iter().map(Subject::Solo).collect();
    if !in_yade.answers.is_empty() {
        let probes = in_yade.answers.iter().map(|answer| answer.probe.clone());
        subjects.push(Subject::Facts(in_yade.answers, probes.collect()));
    }
    let parity = ladder.parity.iter().zip(in_yade.parity);
    subjects.extend(parity.map(|(rung, yade)| Subject::Parity(rung, &yade.track)));
    subjects.extend(in_yade.precisions.map(Subject::Precision));
    let next = AtomicUsize::new(0);
    let finished = AtomicUsize::new(0);
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let mut rows: Vec<(usize, RungLimits)> = thread::scope(|scope| {
        let work = || {
            let mut rows = Vec::new();
            while let Some((index, subject)) = {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let subject = subjects.get(index).filter(|_| !asked_to_end());
                subject.map(|subject| (index, subject))
            } {
                rows.push((index, row(subject, &faults)));
                done(1 + finished.fetch_add(1, Ordering::Relaxed), subjects.len());
            }
            rows
        };
        let handles: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        handles
            .into_iter()
            .flat_map(|handle| match handle.join() {
                Ok(rows) => rows,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    });
    rows.sort_by_key(|(index, _)| *index);
    let name = |fault: &Fault| match fault {
        Fault::Sized(quantity) => quantity.to_string(),
        Fault::Switched(switch) => switch.to_string(),
    };
    Limits {
        faults: faults.iter().map(name).collect(),
        sized: faults
            .iter()
            .map(|of| matches!(of, Fault::Sized(_)))
            .collect(),
        rungs: rows.into_iter().map(|(_, row)| row).collect(),
    }
}

fn row(subject: &Subject, faults: &[Fault]) -> RungLimits {
    RungLimits {
        rung: subject.name().to_owned(),
        group: subject.group(),
        limits: faults.iter().map(|fault| subject.limit(*fault)).collect(),
        sound: subject.sound(),
        sound_runs: FALSE_ALARM_RUNS,
        false_alarms: subject.false_alarms(),
    }
}
