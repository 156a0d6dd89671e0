//! Proof that the suite can fail: for each fault and case the smallest size that is detected, and how often a case fails where
//! nothing is wrong.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;

use super::analytic::halved;
use super::cross_code;
use super::parameters::{self, Answer, Precisions};
use super::run::{Suite, native_tracks};
use super::{CaseGroup, Evidence, Figures, Track, outcome};
use crate::checks::{Check, Outcome};
use crate::engine::yade::CaseInYade;
use crate::workers::asked_to_end;
use evidence::in_parallel;
use evidence::random::Source;
use grains::constant::Constant;
use grains::native::{CaseOptions, Fault, watch_case};
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

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseLimits {
    pub case: String,
    pub evidence: Evidence,
    /// One a fault, in the order of [`Limits::faults`].
    pub limits: Vec<Limit>,
    /// What was different in runs in which nothing was wrong.
    pub varied: Varied,
    pub sound_runs: u32,
    pub false_positives: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limits {
    /// The faults, as `--perturb` takes them, without their sizes.
    pub faults: Vec<String>,
    pub sized: Vec<bool>,
    pub cases: Vec<CaseLimits>,
}

impl Limit {
    /// The smallest size that is detected; 0 of a detected fault without size.
    fn size(&self) -> Option<f64> {
        match self {
            Limit::From { size } => Some(*size),
            Limit::Detected => Some(0.0),
            Limit::Unaffected | Limit::NotDetected => None,
        }
    }
}

impl Limits {
    pub fn checks(&self) -> Vec<Check> {
        let mut figures = Figures::default();
        figures.because("every fault must be detected by at least one case");
        for (index, fault) in self.faults.iter().enumerate() {
            // Which case it is stands in the table: the name of a check is the same whoever detects.
            let id = fault.replace('=', "-");
            let what = format!("{id}: {fault}: smallest size detected, 1");
            let sizes = self.cases.iter();
            let sizes = sizes.filter_map(|case| case.limits[index].size());
            let value = sizes.min_by(f64::total_cmp).unwrap_or(f64::INFINITY);
            figures.is(&what, value, 0.0, MUST_DETECT);
        }
        let count = |condition: fn(&&CaseLimits) -> bool| {
            self.cases.iter().filter(condition).count() as f64
        };
        figures.because("a check that cannot fail is none");
        let silent = count(|case| case.limits.iter().all(|limit| limit.size().is_none()));
        figures.is("cases-that-detect-nothing, 1", silent, 0.0, 0.0);
        figures.because("other neighbour lists and last bits of the start are no faults");
        let wrong = count(|case| case.false_positives > 0);
        figures.is("cases-with-false-positives, 1", wrong, 0.0, 0.0);
        figures.done()
    }
}

/// Whether the checks fail with these cases and options.
type Fails<'a> = Box<dyn Fn(&[Case], &CaseOptions) -> bool + Sync + 'a>;

/// A case of any kind, ready to be run with a fault.
struct Subject<'a> {
    id: &'a str,
    evidence: Evidence,
    cases: &'a [Case],
    fails: Fails<'a>,
}

impl Subject<'_> {
    fn row(&self, faults: &[Fault]) -> CaseLimits {
        CaseLimits {
            case: self.id.to_owned(),
            evidence: self.evidence,
            limits: faults.iter().map(|fault| self.limit(*fault)).collect(),
            varied: self.varied(),
            sound_runs: SOUND_RUNS,
            false_positives: self.false_positives(),
        }
    }

    /// Grains times steps.
    fn work(&self) -> u64 {
        let work =
            |case: &Case| case.bodies.len() as u64 * case.moments.last().copied().unwrap_or(0);
        self.cases.iter().map(work).sum()
    }

    fn is_changed_by(&self, fault: Fault) -> bool {
        let changes = |case: &Case| fault.changes_case(&case.model, &case.bodies);
        self.cases.iter().any(changes)
    }

    fn detects(&self, fault: Fault) -> bool {
        self.is_changed_by(fault) && (self.fails)(self.cases, &Some(fault).into())
    }

    /// Of a fault that is given at its largest size.
    fn limit(&self, largest: Fault) -> Limit {
        if !self.is_changed_by(largest) {
            return Limit::Unaffected;
        }
        if !self.detects(largest) {
            return Limit::NotDetected;
        }
        let Fault::Sized(constant, _) = largest else {
            return Limit::Detected;
        };
        let fault = |decade: f64| Fault::Sized(constant, 10f64.powf(decade));
        let [_, high] = halved(DECADES, HALVINGS, |decade| !self.detects(fault(decade)));
        Limit::From {
            size: 10f64.powf(high),
        }
    }

    /// What can be different without anything being wrong.
    fn varied(&self) -> Varied {
        let moves = self.cases.iter().any(|Case { bodies, .. }| {
            let mut all = bodies.vx.iter().chain(&bodies.vz).chain(&bodies.spin);
            all.any(|value| *value != 0.0)
        });
        match self.evidence {
            Evidence::Exact if moves => Varied::Starts,
            Evidence::Symmetry => Varied::Stiffness,
            _ => Varied::Lists,
        }
    }

    /// How many of the runs in which nothing is wrong fail.
    fn false_positives(&self) -> u32 {
        let mut random = Source::new(b"crossgrain: runs without a fault", 0);
        (0..SOUND_RUNS)
            .filter(|_| {
                let options = CaseOptions {
                    skin_over_radius: 0.02 + 0.5 * random.uniform(),
                    ..CaseOptions::default()
                };
                let mut cases = self.cases.to_vec();
                match self.varied() {
                    Varied::Starts => cases.iter_mut().for_each(|c| nudge(c, &mut random)),
                    Varied::Stiffness => {
                        let factor = 0.97 + 0.06 * random.uniform();
                        cases.iter_mut().for_each(|c| c.model.law.modulus *= factor);
                    }
                    Varied::Lists => {}
                }
                (self.fails)(&cases, &options)
            })
            .count() as u32
    }
}

/// Whether the native engine diverges from a track, looked at moment by moment.
fn diverges(case: &Case, truth: &Track, options: &CaseOptions) -> bool {
    let mut moments = truth.iter();
    let mut apart = false;
    let run = watch_case(case, options, &mut |snapshot| {
        let truth = moments.next();
        apart |= truth.is_none_or(|truth| cross_code::differ(&snapshot, truth));
        !apart
    });
    apart || run.is_err()
}

/// Moves every velocity and spin by a last bit, up or down or not at all.
fn nudge(case: &mut Case, random: &mut Source) {
    let bodies = &mut case.bodies;
    for column in [&mut bodies.vx, &mut bodies.vz, &mut bodies.spin] {
        for value in column.iter_mut() {
            *value *= match random.below(3) {
                0 => 1.0 + f64::EPSILON,
                1 => 1.0 - f64::EPSILON,
                _ => 1.0,
            };
        }
    }
}

/// Fills the table for all cases, those that take YADE with what it has to say of them; `done` hears of
/// each finished case.
pub fn limits(
    suite: &Suite,
    in_yade: &[CaseInYade],
    answers: &[Answer],
    precisions: Option<&Precisions>,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Limits {
    let largest = 10f64.powf(DECADES[1]);
    let sized = Constant::faults();
    let sized = sized.map(|constant| (constant.to_string(), Fault::Sized(constant, largest)));
    let switched = Fault::switches();
    let switched = switched.map(|switch| (switch.to_string(), Fault::Switched(switch)));
    let (names, faults): (Vec<String>, Vec<Fault>) = sized.chain(switched).unzip();
    let failed =
        |checks: Option<Vec<Check>>| checks.is_none_or(|checks| outcome(&checks) == Outcome::Fail);
    let probes: Vec<Case> = answers.iter().map(|answer| answer.probe.clone()).collect();
    // Bits that are on record are those of the sound engine: the first moment with others is enough.
    let on_record = |group: &&CaseGroup| group.id == cross_code::RECORDED;
    let sound = suite.groups.iter().find(on_record);
    let sound = sound.and_then(|group| native_tracks(&group.cases, &CaseOptions::default()).ok());
    // Without its states no fault is found by them, and the table says so.
    let sound = sound.as_deref().unwrap_or_default();
    let groups = suite.groups.iter().map(|group| Subject {
        id: group.id,
        evidence: group.evidence,
        cases: &group.cases,
        fails: match on_record(&group) {
            true => Box::new(move |cases, options| {
                let mut both = cases.iter().zip(sound);
                both.any(|(case, sound)| diverges(case, sound, options))
            }),
            false => Box::new(move |cases, options| {
                let tracks = native_tracks(cases, options).ok();
                failed(tracks.map(|tracks| group.judge(&tracks)))
            }),
        },
    });
    let asked = (!answers.is_empty()).then(|| Subject {
        id: "parameters",
        evidence: Evidence::CrossCode,
        cases: &probes,
        fails: Box::new(move |_, options| failed(parameters::checks(answers, *options).ok())),
    });
    let cross = suite
        .cross
        .iter()
        .zip(in_yade)
        .map(|(cross, yade)| Subject {
            id: &cross.id,
            evidence: Evidence::CrossCode,
            cases: std::slice::from_ref(&cross.case),
            fails: Box::new(move |cases, options| {
                let mut cases = cases.iter();
                cases.any(|case| diverges(case, &yade.track, options))
            }),
        });
    let precision = precisions.map(|precision| Subject {
        id: "precision",
        evidence: Evidence::Precision,
        cases: std::slice::from_ref(&precision.case),
        fails: Box::new(move |_, options| {
            let errors = precision.errors(*options).ok();
            failed(errors.map(|errors| parameters::precision_checks(&errors)))
        }),
    });
    let subjects: Vec<Subject> = groups.chain(asked).chain(cross).chain(precision).collect();
    // The longest first, so that no worker is left with it at the end.
    let mut order: Vec<usize> = (0..subjects.len()).collect();
    order.sort_by_key(|index| std::cmp::Reverse(subjects[*index].work()));
    let finished = AtomicUsize::new(0);
    let mut cases = in_parallel(subjects.len(), |place| {
        // Whoever asked for the table is told of the signal.
        let row = (!asked_to_end()).then(|| subjects[order[place]].row(&faults));
        done(finished.fetch_add(1, Ordering::Relaxed) + 1, subjects.len());
        row.map(|row| (order[place], row))
    });
    cases.sort_by_key(|case| case.as_ref().map(|(index, _)| *index));
    let sized = |fault: &Fault| matches!(fault, Fault::Sized(..));
    Limits {
        faults: names,
        sized: faults.iter().map(sized).collect(),
        cases: cases.into_iter().flatten().map(|(_, row)| row).collect(),
    }
}

#[cfg(test)]
pub mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::engine::yade::unsupported;
    use crate::suite::{self, CaseGroup, furthest};
    use grains::rules::Rules;

    fn groups() -> Vec<CaseGroup> {
        suite::groups(Rules::default())
    }

    pub fn judged(group: &CaseGroup, fault: Option<Fault>) -> Vec<Check> {
        let tracks = native_tracks(&group.cases, &fault.into());
        tracks.map_or(Vec::new(), |tracks| group.judge(&tracks))
    }

    /// Of each group faults that it is about, and how small ones it must detect. Those on the scheme's own solution detect one part in
    /// 10¹¹; those in continuous time what the length of the step leaves.
    const FAULTS: &str = "
        bounce-local-damping: damping=1e-4 stiffness=1e-4 wall=missing damping=wrong-sign
        bounce-dashpot: dashpot=1e-4 density=1e-4 clipping=other
        bounce-dashpot-unclipped: dashpot=1e-4 density=1e-4
        bounce-restitution: dashpot=1e-4 clipping=other
        drop-on-wall: gravity=1e-10 stiffness=1e-4 start=half-step clipping=other
        drop-on-wall-unclipped: gravity=1e-10 stiffness=1e-3
        repeated-bounces: gravity=1e-3 dashpot=1e-2
        repeated-bounces-local-damping: damping=1e-4
        oblique-impact: friction=1e-9 inertia=1e-7 torque-arms=other
        gross-sliding: friction=1e-9 inertia=1e-8 torque-arms=other
        spin-impact: friction=1e-9 inertia=1e-8
        leapfrog-spring: start=half-step
        leapfrog-dashpot: dashpot=1e-11
        leapfrog-dashpot-unclipped: dashpot=1e-11
        leapfrog-local-damping: damping=1e-11 damping=wrong-sign
        leapfrog-drop: damping=1e-11 dashpot=1e-11 gravity=1e-11 wall=missing
        leapfrog-sliding: friction=1e-11 inertia=1e-11 dashpot=1e-11 torque-arms=other
        leapfrog-sticking: shear-stiffness=1e-11 inertia=1e-11 gravity=1e-11 start=half-step ratcheting=other
        first-slip: shear-stiffness=1e-10 modulus=1e-10 radius=1e-10 time-step=1e-10 ratcheting=other
        first-slip-since-touch: shear-stiffness=1e-10 modulus=1e-10 radius=1e-10 time-step=1e-10
        free-fall: gravity=1e-9 time-step=1e-9 start=half-step
        flight-with-local-damping: damping=1e-9 gravity=1e-9 damping=wrong-sign
        oscillator: stiffness=1e-9 modulus=1e-9 density=1e-9 gravity=1e-9 radius=1e-9 time-step=1e-9 wall=1e-9 start=half-step
        oscillator-order: stiffness=1e-5 time-step=1e-5 start=half-step
        oscillator-with-local-damping: damping=1e-9 stiffness=1e-9 damping=wrong-sign
        two-stacked-grains: stiffness=1e-9 density=1e-9 radius=1e-9 wall=1e-9 gravity=1e-6
        tangential-spring: shear-stiffness=1e-9 density=1e-9 time-step=1e-9 ratcheting=other
        turning-spring: shear-stiffness=1e-9 inertia=1e-9 radius=1e-9 torque-arms=other ratcheting=other
        sliding-ball: friction=1e-9 inertia=1e-9 gravity=1e-9 time-step=1e-9 torque-arms=other
        slip-then-roll: inertia=1e-9 torque-arms=other ratcheting=other friction=1e-3
        rolling-incline: inertia=1e-9 gravity=1e-9 shear-stiffness=1e-9 torque-arms=other
        sliding-incline: friction=1e-9 inertia=1e-9 gravity=1e-9
        momentum: inertia=1e-6
        elastic-energy: stiffness=1e-2 density=1e-2
        lost-energy: damping=wrong-sign
        column-of-discs: gravity=1e-9 density=1e-9 stiffness=1e-9 wall=missing
        pyramid-of-discs: gravity=1e-9 density=1e-9 stiffness=1e-9
        extensive-stress-of-a-disc: stiffness=1e-9 radius=1e-9 wall=1e-9
        field-inside-a-disc: wall=1e-9
        mirror: wall=1e-12 wall=missing
        quarter-turn: wall=1e-12 wall=missing
        shift: wall=1e-9
        other-numbers: radius=1e-9 inertia=1e-6
        moving-frame: time-step=1e-6
        chung-ooi-1: modulus=1e-7 density=1e-7 time-step=1e-7
        chung-ooi-2: modulus=1e-7 density=1e-7 radius=1e-7 wall=missing
        chung-ooi-3: modulus=1e-7 dashpot=1e-7 wall=missing clipping=other
        chung-ooi-4: friction=1e-7 inertia=1e-7 tangential-dashpot=1e-3 shear-stiffness=1e-3 torque-arms=other
        chung-ooi-5: friction=1e-7 inertia=1e-7 shear-stiffness=1e-7
        chung-ooi-6: friction=1e-7 inertia=1e-7 tangential-dashpot=1e-6 ratcheting=other
        chung-ooi-7: friction=1e-7 inertia=1e-7
        chung-ooi-8: friction=1e-7 inertia=1e-7
        mfix-dem-01: gravity=1e-7 dashpot=1e-7 stiffness=1e-7 start=half-step
        mfix-dem-03: gravity=1e-7 density=1e-7 stiffness=1e-7
        mfix-dem-04: friction=1e-7 inertia=1e-7 shear-stiffness=1e-6
        lammps-rolling: twisting-stiffness=1e-9 rolling-limit=1e-9
        moments: rolling-stiffness=1e-9 twisting-stiffness=1e-9
        constant-torque: rolling-limit=1e-9 inertia=1e-7
        lammps-pull-off: adhesion=1e-9 modulus=1e-9
        materials: material=1e-9
        adhesion: material=1e-9 adhesion=1e-8
        corner: friction=1e-7 stiffness=1e-7
        on-dem: friction=1e-7 shear-stiffness=1e-7 ratcheting=other
        on-dem-dashpots: dashpot=1e-7
        recorded-pouring: stiffness=1e-12
        ";

    /// Springs that swing as the scheme's own solution.
    const SWING: &str =
        "stiffness=1e-11 modulus=1e-11 density=1e-11 radius=1e-11 time-step=1e-11 wall=1e-11";

    #[test]
    fn every_group_detects_the_faults_that_it_is_about() {
        let lines = FAULTS.trim().lines();
        let rows = lines.map(|line| line.trim().split_once(": ").expect("an id and faults"));
        let rows: BTreeMap<&str, &str> = rows.collect();
        for group in groups() {
            let row = rows.get(group.id);
            let faults = row.unwrap_or_else(|| panic!("no faults of {}", group.id));
            let swing = group.id.starts_with("leapfrog-").then_some(SWING);
            let all = [*faults].into_iter().chain(swing);
            for fault in all.flat_map(str::split_whitespace) {
                let checks = judged(&group, Some(fault.parse().expect("a fault")));
                assert_eq!(outcome(&checks), Outcome::Fail, "{} with {fault}", group.id);
            }
        }
        let ids: BTreeSet<&str> = groups().iter().map(|group| group.id).collect();
        assert!(rows.keys().all(|id| ids.contains(id)));
    }

    /// An engine that returned nothing has shown nothing.
    #[test]
    fn missing_tracks_and_moments_hold_nowhere() {
        for group in groups() {
            let tracks = vec![Track::new(); group.cases.len()];
            let checks = group.judge(&tracks);
            assert_eq!(outcome(&checks), Outcome::Fail, "{}", group.id);
            let symmetric = group.evidence == Evidence::Symmetry;
            let passes = |check: &Check| check.outcome == Outcome::Pass;
            let none = !checks.iter().any(passes);
            assert!(symmetric || none, "{}: {checks:?}", group.id);
            assert_eq!(outcome(&group.judge(&tracks[1..])), Outcome::Fail);
            assert_eq!(outcome(&group.judge(&[])), Outcome::Fail);
        }
    }

    #[test]
    fn checks_say_why_and_ids_are_plain_and_unique() {
        let mut ids = BTreeSet::new();
        let plain = |letter: char| {
            letter.is_ascii_lowercase() || letter.is_ascii_digit() || "-./_".contains(letter)
        };
        for group in groups() {
            assert!(group.id.chars().all(plain) && ids.insert(group.id.to_owned()));
            for check in judged(&group, None) {
                let said = !check.basis.is_empty() && !check.unit.is_empty();
                assert!(said, "{check:?}");
                let id = format!("{}/{}", group.id, check.id);
                assert!(id.chars().all(plain), "{id}");
                assert!(ids.insert(id.clone()), "{id} twice");
            }
        }
    }

    #[test]
    fn cases_are_short_and_their_moments_rise() {
        for group in groups() {
            for case in &group.cases {
                let (id, name) = (group.id, &case.name);
                assert!(case.moments.is_sorted_by(|a, b| a < b), "{id} {name}");
                // YADE has to make the longest, too.
                let last = case.moments.last().copied().expect("a moment");
                assert!(last <= 20_000, "{id} {name}: {last} steps");
            }
        }
    }

    #[test]
    fn what_yade_lacks_is_in_groups_of_its_own() {
        for group in groups() {
            let lacks = |case: &Case| unsupported(&case.model).is_some();
            let marked = [
                "-unclipped",
                "-restitution",
                "-since-touch",
                "-dem-dashpots",
                "-pull-off",
                "-torque",
            ];
            let marked = marked.iter().any(|end| group.id.ends_with(end));
            assert_eq!(group.cases.iter().any(lacks), marked, "{}", group.id);
        }
    }

    #[test]
    fn the_furthest_value_may_be_none() {
        assert_eq!(furthest(1.0, [1.5, 0.0, 2.0]), 0.0);
        assert!(furthest(1.0, [1.5, f64::NAN, 2.0]).is_nan());
    }

    #[test]
    fn a_check_is_named_by_its_id_and_judged_by_one_rule() {
        let mut figures = Figures::default();
        figures.case("pair/e-0.5");
        figures.because("a bound");
        figures.is("contact-time, s", 1.5, 1.0, 0.5);
        figures.is("rest: at rest, in the end, m", f64::NAN, 0.0, f64::INFINITY);
        let checks = figures.done();
        assert_eq!(checks[0].id, "pair/e-0.5/contact-time");
        assert_eq!(checks[0].quantity, "contact time, pair/e 0.5");
        assert_eq!(checks[0].unit, "s");
        assert_eq!(checks[0].outcome, Outcome::Pass);
        assert_eq!(checks[1].quantity, "at rest, in the end, pair/e 0.5");
        assert_eq!(checks[1].outcome, Outcome::Fail);
    }
}
