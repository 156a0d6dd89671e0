//! Proof that the suite can fail: for each fault and case the smallest size that is detected, and how often a case fails where
//! nothing is wrong.

use std::convert::Infallible;
use std::sync::atomic::{AtomicUsize, Ordering};

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::Serialize;

use super::cross_code::{self, CrossCase, InYade};
use super::parameters::Precisions;
use super::parameters::{self, Answer};
use super::run::{Suite, native_tracks};
use super::{CaseGroup, Evidence, Figures, Track, outcome};
use crate::checks::{Check, Outcome};
use crate::workers;
use grains::native::perturb::{Quantity, Switch};
use grains::native::{CaseOptions, Perturbation, watch_case};
use grains::task::Case;

/// Sizes are looked for between 10 to the power of these.
const DECADES: [f64; 2] = [-16.0, -0.3];
/// Halvings of that range: the size found is right within a tenth of a decade.
const HALVINGS: u32 = 8;
/// A fault of this relative size or larger must be detected by at least one case.
const MUST_DETECT: f64 = 1.0e-9;
/// Runs of each case in which nothing is wrong.
const SOUND_RUNS: u32 = 20;

/// What a case makes of one fault.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Limit {
    /// The fault changes nothing in it.
    Unaffected,
    /// The fault changes it, and is not detected at any size.
    NotDetected,
    /// The smallest relative size that is detected.
    From {
        /// Relative, within a tenth of a decade.
        size: f64,
    },
    /// A fault that has no size is detected.
    Detected,
}

/// What may differ where nothing is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Varied {
    /// Velocities and spins at the start, in last bits.
    Starts,
    /// The stiffness of everything, on both sides of a comparison.
    Stiffness,
    /// The neighbour lists only: numbers are compared with a record, bit by bit, or nothing moves.
    Lists,
}

/// A case's row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseLimits {
    /// The case's id.
    pub case: String,
    /// What kind of evidence it gives.
    pub evidence: Evidence,
    /// One a fault, in the order of [`Limits::faults`].
    pub limits: Vec<Limit>,
    /// What was different in runs in which nothing was wrong.
    pub varied: Varied,
    /// Runs in which nothing was wrong.
    pub sound_runs: u32,
    /// How many of them failed.
    pub false_positives: u32,
}

/// The table of detection limits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limits {
    /// The faults, as `--perturb` takes them, without their sizes.
    pub faults: Vec<String>,
    /// Whether each fault has a size.
    pub sized: Vec<bool>,
    /// A row a case.
    pub cases: Vec<CaseLimits>,
}

/// A fault without its size.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Sized(Quantity),
    Switched(Switch),
}

impl Limits {
    /// The smallest size of a fault that any case detects; 0 for a detected fault without size.
    fn smallest(&self, fault: usize) -> Option<f64> {
        let of = |case: &CaseLimits| match case.limits[fault] {
            Limit::From { size } => Some(size),
            Limit::Detected => Some(0.0),
            Limit::Unaffected | Limit::NotDetected => None,
        };
        self.cases.iter().filter_map(of).min_by(f64::total_cmp)
    }

    /// What must hold of the table.
    pub fn checks(&self) -> Vec<Check> {
        let mut figures = Figures::default();
        figures.because("every fault must be detected by at least one case");
        for (index, fault) in self.faults.iter().enumerate() {
            // Which case it is stands in the table: the name of a check is the same whoever detects.
            let id = fault.replace('=', "-");
            let what = format!("{id}: {fault}: smallest size detected, 1");
            let value = self.smallest(index).unwrap_or(f64::INFINITY);
            figures.is(&what, value, 0.0, MUST_DETECT);
        }
        let count = |of: &dyn Fn(&CaseLimits) -> bool| {
            self.cases.iter().filter(|case| of(case)).count() as f64
        };
        let detects = |limit: &Limit| matches!(limit, Limit::From { .. } | Limit::Detected);
        figures.because("a check that cannot fail is none");
        let silent = count(&|case| !case.limits.iter().any(detects));
        let what = "cases-that-detect-nothing, 1";
        figures.is(what, silent, 0.0, 0.0);
        figures.because("other neighbour lists and last bits of the start are no faults");
        let wrong = count(&|case| case.false_positives > 0);
        figures.is("cases-with-false-positives, 1", wrong, 0.0, 0.0);
        figures.done()
    }
}

/// A case of either kind, ready to be run with a fault.
enum Subject<'a> {
    Group(&'a CaseGroup),
    Cross(&'a CrossCase, &'a Track),
    Parameters(&'a [Answer], Vec<Case>),
    Precision(&'a Precisions),
}

impl Subject<'_> {
    fn cases(&self) -> &[Case] {
        match self {
            Subject::Group(group) => &group.cases,
            Subject::Cross(of, _) => std::slice::from_ref(&of.case),
            Subject::Parameters(_, probes) => probes,
            Subject::Precision(of) => std::slice::from_ref(&of.case),
        }
    }

    fn about(&self) -> (&str, Evidence) {
        match self {
            Subject::Group(group) => (group.id, group.evidence),
            Subject::Cross(of, _) => (&of.id, Evidence::CrossCode),
            Subject::Parameters(..) => ("parameters", Evidence::CrossCode),
            Subject::Precision(_) => ("precision", Evidence::Precision),
        }
    }

    fn fails(&self, cases: &[Case], options: &CaseOptions) -> bool {
        let checks = match self {
            Subject::Group(group) => native_tracks(cases, options)
                .map(|of| group.judge(&of))
                .ok(),
            Subject::Cross(_, truth) => {
                return cases.iter().any(|case| diverges(case, truth, options));
            }
            Subject::Parameters(answers, _) => parameters::checks(answers, *options).ok(),
            Subject::Precision(of) => of
                .errors(*options)
                .ok()
                .map(|of| parameters::precision_checks(&of)),
        };
        checks.is_none_or(|checks| outcome(&checks) == Outcome::Fail)
    }

    fn detects(&self, fault: Perturbation) -> bool {
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
            return Limit::Unaffected;
        }
        if !self.detects(largest) {
            return Limit::NotDetected;
        }
        let Fault::Sized(quantity) = fault else {
            return Limit::Detected;
        };
        let [mut low, mut high] = DECADES;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.detects(Perturbation::Sized(quantity, 10f64.powf(middle))) {
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
    fn varied(&self) -> Varied {
        let bodies = self.cases().iter().map(|case| &case.bodies);
        let moves = bodies.clone().any(|bodies| {
            let all = bodies.vx.iter().chain(&bodies.vz).chain(&bodies.spin);
            all.into_iter().any(|value| *value != 0.0)
        });
        match self.about() {
            (_, Evidence::Exact) if moves => Varied::Starts,
            (_, Evidence::Symmetry) => Varied::Stiffness,
            _ => Varied::Lists,
        }
    }

    /// How many of the runs in which nothing is wrong fail.
    fn false_positives(&self) -> u32 {
        let mut random = ChaCha8Rng::from_seed(*b"crossgrain: runs without a fault");
        (0..SOUND_RUNS)
            .filter(|_| {
                let options = CaseOptions {
                    fault: None,
                    skin_over_radius: 0.02 + 0.5 * uniform(&mut random),
                    ..CaseOptions::default()
                };
                let mut cases = self.cases().to_vec();
                match self.varied() {
                    Varied::Starts => cases.iter_mut().for_each(|c| nudge(c, &mut random)),
                    Varied::Stiffness => {
                        let factor = 0.97 + 0.06 * uniform(&mut random);
                        cases.iter_mut().for_each(|c| c.model.law.modulus *= factor);
                    }
                    Varied::Lists => {}
                }
                self.fails(&cases, &options)
            })
            .count() as u32
    }
}

/// Whether the native engine diverges from a track, looked at moment by moment.
fn diverges(case: &Case, truth: &Track, options: &CaseOptions) -> bool {
    let mut moments = truth.iter();
    let mut apart = false;
    let run = watch_case(case, options, &mut |snapshot| {
        apart |= moments
            .next()
            .is_none_or(|truth| cross_code::differ(&snapshot, truth));
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

/// What YADE has to say, for the cases that take both engines.
#[derive(Debug, Clone, Copy, Default)]
pub struct FromYade<'a> {
    /// Of each cross-code case.
    pub cross: &'a [InYade],
    /// Parameters of the scenes.
    pub answers: &'a [Answer],
    /// The case of rounding errors in every precision.
    pub precisions: Option<&'a Precisions>,
}

/// Fills the table for all cases, those that take YADE with what it has to say of them; `done` hears of
/// each finished case.
pub fn limits(
    suite: &Suite,
    in_yade: FromYade<'_>,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Limits {
    let sized = Perturbation::quantities().map(Fault::Sized);
    let faults: Vec<Fault> = sized
        .chain(Perturbation::switches().map(Fault::Switched))
        .collect();
    let mut subjects: Vec<Subject> = suite.groups.iter().map(Subject::Group).collect();
    if !in_yade.answers.is_empty() {
        let probes = in_yade.answers.iter().map(|answer| answer.probe.clone());
        subjects.push(Subject::Parameters(in_yade.answers, probes.collect()));
    }
    let cross = suite.cross.iter().zip(in_yade.cross);
    subjects.extend(cross.map(|(of, yade)| Subject::Cross(of, &yade.track)));
    subjects.extend(in_yade.precisions.map(Subject::Precision));
    let finished = AtomicUsize::new(0);
    let rows = workers::map(subjects.len(), |index| {
        let row = row(&subjects[index], &faults);
        done(finished.fetch_add(1, Ordering::Relaxed) + 1, subjects.len());
        Ok::<_, Infallible>(row)
    });
    let Ok(cases) = rows;
    let name = |fault: &Fault| match fault {
        Fault::Sized(quantity) => quantity.to_string(),
        Fault::Switched(switch) => switch.to_string(),
    };
    let sized = |fault: &Fault| matches!(fault, Fault::Sized(_));
    Limits {
        faults: faults.iter().map(name).collect(),
        sized: faults.iter().map(sized).collect(),
        cases,
    }
}

fn row(subject: &Subject, faults: &[Fault]) -> CaseLimits {
    let (case, evidence) = subject.about();
    CaseLimits {
        case: case.to_owned(),
        evidence,
        limits: faults.iter().map(|fault| subject.limit(*fault)).collect(),
        varied: subject.varied(),
        sound_runs: SOUND_RUNS,
        false_positives: subject.false_positives(),
    }
}
