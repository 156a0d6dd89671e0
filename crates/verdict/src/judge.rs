//! The verdict on an engine's first steps: how coarsely it computes, whether it stays among the replicas, which faults would have
//! been seen, and what is wrong if it does not.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, OnceLock};

use evidence::in_parallel;
use grains::constant::Constant;
use grains::native::NativeError;
use grains::rules::{Choice, Rules};
use grains::tables::{Bodies, Snapshot};
use grains::task::Case;
use grains::variant::{self, Form, Variant};
use serde::Serialize;

use crate::causes::{Cause, causes};
use crate::envelope::{self, Envelope, Farthest, LARGER, Resolution};
use crate::excerpt::Excerpt;
use crate::exercise::{self, Count, Range};
use crate::starts::{Bed, LARGE_STATE, State};
use crate::{Answer, Engine, conditions, terms};

/// What an engine is, compared with the native one; the first that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every bit is the same.
    Identical,
    /// It parts from the native engine as runs do that are the same but for rounding.
    EqualToRounding,
    /// Its packings have the same distribution, within margins set before.
    EqualInDistribution,
    /// What must be true of any law is true of its own; it was held against no other engine.
    ConsistentWithItself,
    /// It is another engine.
    Different,
    /// Evidence is missing.
    #[default]
    Undecided,
}

impl Verdict {
    pub fn in_words(self) -> &'static str {
        match self {
            Verdict::Identical => "identical",
            Verdict::EqualToRounding => "equal to rounding",
            Verdict::EqualInDistribution => "equal in distribution",
            Verdict::ConsistentWithItself => "consistent with itself",
            Verdict::Different => "different",
            Verdict::Undecided => "undecided",
        }
    }
}

/// One start under one law.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct OfStart {
    pub law: String,
    pub start: String,
    /// For identifiers.
    #[serde(skip)]
    pub key: String,
    pub verdict: Verdict,
    pub skipped: Option<String>,
    pub farthest: Option<Farthest>,
    /// What is wrong with its contact tables, where they are off before the motion is.
    pub tables: Option<String>,
    /// The first moment at which rounding takes nine of ten grains so far apart that nothing would be seen, steps.
    #[serde(skip)]
    pub wide_from: Option<u64>,
}

impl OfStart {
    /// That was not looked at yet.
    pub(crate) fn new(law: &str, start: &str, key: &str) -> Self {
        OfStart {
            law: law.to_owned(),
            start: start.to_owned(),
            key: key.to_owned(),
            ..OfStart::default()
        }
    }

    /// Nothing is known of it, as of no state of which it wrote nonsense or other moments.
    pub fn was_refused(&self) -> bool {
        self.skipped.is_some() && self.verdict != Verdict::Different
    }

    /// How far off it is, and where.
    pub fn in_words(&self) -> String {
        let steps = |count: u64| format!("{count} {}", if count == 1 { "step" } else { "steps" });
        let Some(far) = &self.farthest else {
            return String::new();
        };
        let (quantity, unit) = far.quantity.name();
        let tables = self.tables.as_ref();
        let tables = tables.map_or(String::new(), |tables| {
            format!("; its contact tables: {tables}")
        });
        match (self.verdict, far.left_after) {
            (Verdict::Identical, _) => "every bit is the native engine's".to_owned(),
            (_, Some(step)) => format!(
                "after {} it is farther off than rounding takes it; it is farthest, {:.1e} times as far as replicas, after {}: the \
                 {quantity} of {} is off by {:.1e} {unit}{tables}",
                steps(step),
                far.ratio,
                steps(far.step),
                far.body,
                far.apart
            ),
            (_, None) => format!("at most {:.2} times as far off as replicas", far.ratio),
        }
    }
}

/// A state that the engine was not asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotAsked {
    pub law: String,
    pub start: String,
    /// What the engine says it has not.
    pub lacking: String,
}

/// The smallest fault in a constant that would have been seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limit {
    pub constant: &'static str,
    pub smallest: f64,
    pub law: String,
    pub start: String,
}

/// All that was found about an engine.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Judgement {
    pub grains: usize,
    /// Of the bed in space, where that was looked at besides.
    #[serde(skip_serializing_if = "is_zero")]
    pub spheres: usize,
    /// The largest radius over the smallest in any of the states.
    pub radii: f64,
    /// How coarsely the engine computes; that of double precision where it was not measured.
    pub resolution: Resolution,
    /// The largest coordinate of the states that tell it, m.
    pub extent: f64,
    /// Every state under every law that the engine says it has.
    pub starts: Vec<OfStart>,
    /// What it says it has not, which counts neither way.
    pub not_asked: Vec<NotAsked>,
    /// What would have been seen, the smallest first.
    pub limits: Vec<Limit>,
    /// What touched and slid in the states that were looked at.
    pub counts: Vec<Count>,
    /// From where to where constants and motion go in them.
    pub ranges: Vec<Range>,
    /// Constants and keys that change nothing in any of these states, so that nothing is known of them.
    pub unseen: Vec<String>,
    /// For each law that shows something else than the ones before.
    pub causes: Vec<Cause>,
    /// What is written of contacts otherwise, where the motion is right.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub written: Vec<String>,
    /// What the laws of all states that differ have and those of no other, in words.
    pub condition: Option<String>,
    /// Rules that the engine says it has otherwise than the model, by which it is judged.
    pub declared: Vec<Declared>,
}

/// A rule that an engine says it has otherwise than the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Declared {
    /// As key and value.
    pub rule: String,
    /// How far it moves a grain in these states at most, over the mean radius.
    pub moves: f64,
}

impl Judgement {
    /// Of all states: different if one is, undecided if one was not looked at or the evidence is too thin.
    pub fn verdict(&self) -> Verdict {
        match self.of_states() {
            Verdict::EqualToRounding | Verdict::Identical if self.open().is_some() => {
                Verdict::Undecided
            }
            of_states => of_states,
        }
    }

    /// With what was found in space besides. States in the plane that an engine refuses stay open, unless it says that it has no plane.
    pub fn with_spheres(mut self, space: Judgement) -> Self {
        // Of an engine that has nothing in the plane nothing can touch there.
        if self.starts.is_empty() {
            self.counts.clear();
        }
        self.spheres = space.grains;
        self.radii = self.radii.max(space.radii);
        self.resolution = self.resolution.coarser(space.resolution);
        self.extent = self.extent.max(space.extent);
        self.starts.extend(space.starts);
        self.not_asked.extend(space.not_asked);
        self.limits.extend(space.limits);
        self.limits
            .sort_by(|a, b| a.smallest.total_cmp(&b.smallest));
        self.counts.extend(space.counts);
        self.ranges.extend(space.ranges);
        self.unseen.extend(space.unseen);
        for rule in space.declared {
            match self
                .declared
                .iter_mut()
                .find(|known| known.rule == rule.rule)
            {
                Some(known) => known.moves = known.moves.max(rule.moves),
                None => self.declared.push(rule),
            }
        }
        let known: Vec<String> = self.causes.iter().map(Cause::sentence).collect();
        let terms = self.causes.iter().flat_map(|cause| &cause.terms);
        let terms: BTreeSet<String> = terms.cloned().collect();
        let new = |cause: &Cause| {
            let of_it = &cause.terms;
            let is_told = !of_it.is_empty() && of_it.iter().all(|term| terms.contains(term));
            !is_told && !known.contains(&cause.sentence())
        };
        self.causes.extend(space.causes.into_iter().filter(new));
        self.written.extend(space.written);
        self.condition = self.condition.or(space.condition);
        self
    }

    /// Why states that agree are too little evidence.
    pub fn open(&self) -> Option<String> {
        let short = self.counts.iter().filter(|count| !count.is_enough());
        let short: Vec<String> = short
            .map(|count| format!("{} {}", count.found, count.what))
            .collect();
        let coarse = self
            .limits
            .last()
            .filter(|limit| limit.smallest > LARGEST_LIMIT);
        let identical = self.of_states() == Verdict::Identical;
        match coarse {
            _ if !short.is_empty() => {
                Some(format!("nothing has touched yet: {}", short.join(", ")))
            }
            _ if identical => None,
            _ if self.resolution.is_too_coarse(self.extent) => Some(format!(
                "it takes no notice of changes of its start that single precision notices ({:.0e} of a coordinate, {:.0e} m in overlaps, \
                 {:.0e} of a velocity), so a fault of that size could not be seen",
                self.resolution.position, self.resolution.overlap, self.resolution.velocity
            )),
            Some(limit) => Some(format!(
                "{} could be wrong by {:.0e} and would not be seen",
                limit.constant, limit.smallest
            )),
            None => None,
        }
    }

    fn of_states(&self) -> Verdict {
        let has = |verdict| self.starts.iter().any(|start| start.verdict == verdict);
        let order = [
            Verdict::Different,
            Verdict::Undecided,
            Verdict::EqualToRounding,
            Verdict::Identical,
        ];
        let found = order.into_iter().find(|verdict| has(*verdict));
        found.unwrap_or(Verdict::Undecided)
    }

    pub fn farthest(&self) -> Option<&OfStart> {
        let looked_at = self.starts.iter().filter(|start| start.farthest.is_some());
        looked_at.max_by(|a, b| ratio(&a.farthest).total_cmp(&ratio(&b.farthest)))
    }
}

fn ratio(farthest: &Option<Farthest>) -> f64 {
    farthest.as_ref().map_or(0.0, |far| far.ratio)
}

/// The largest radius over the smallest.
fn radii(case: &Case) -> f64 {
    let radii = || case.bodies.radius.iter().copied();
    radii().fold(0.0, f64::max) / radii().fold(f64::INFINITY, f64::min)
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Where a constant could be wrong by more than this share unseen, nothing agrees.
const LARGEST_LIMIT: f64 = 1.0e-3;

/// A state is followed step by step for so many steps at least and at most.
const FOLLOWED: u64 = 6;
const LAST_FOLLOWED: u64 = 101;
/// A moment that is told of both ways, and by what share of the largest velocity it may differ.
const EARLY: u64 = 3;
const SAME_MOMENT: f64 = 1.0e-9;

/// An answer that begins with this is no refusal.
pub const NONSENSE: &str = "it wrote nonsense: ";
pub const OTHER_MOMENTS: &str = "it wrote other moments than were asked for";

/// By their digests: == takes −0 for 0.
pub(crate) fn have_same_bits(theirs: &[Snapshot], own: &[Snapshot]) -> bool {
    let punch = |moment: &Snapshot| {
        let punch = moment.punch.as_ref();
        punch.map(|punch| [punch.start, punch.velocity].map(f64::to_bits))
    };
    let same = |(a, b): (&Snapshot, &Snapshot)| a.digest() == b.digest() && punch(a) == punch(b);
    theirs.len() == own.len() && theirs.iter().zip(own).all(same)
}

pub(crate) fn verdict(
    farthest: &Option<Farthest>,
    theirs: &[Snapshot],
    own: &[Snapshot],
) -> Verdict {
    match farthest {
        None => Verdict::Different,
        Some(_) if have_same_bits(theirs, own) => Verdict::Identical,
        Some(far) if far.is_rounding() => Verdict::EqualToRounding,
        Some(_) => Verdict::Different,
    }
}

/// The native engine's side of a judgement: made once, for any number of engines.
#[derive(Debug, Clone)]
pub struct Reference {
    states: Vec<State>,
    pub excerpts: Vec<Excerpt>,
    names_causes: bool,
    /// Rules by which engines are judged instead of the model's.
    rules: Rules,
    /// For engines in double precision, made when the first engine has answered the case.
    double: Vec<OnceLock<Native>>,
    /// What none of them shows, of the states that an engine was asked for.
    unseen: Arc<Mutex<BTreeMap<Vec<usize>, Vec<String>>>>,
}

fn is_nonsense(answer: &Answer) -> bool {
    let reason = answer.as_ref().err();
    reason.is_some_and(|reason| reason.starts_with(NONSENSE))
}

/// What an engine made of the states that it was handed.
#[derive(Debug, Clone)]
pub(crate) struct Answers<'a> {
    /// With their places among all.
    pub states: Vec<(usize, &'a State)>,
    pub of_states: Vec<Answer>,
    not_asked: Vec<NotAsked>,
    pub resolution: Resolution,
}

/// What is known of one case.
#[derive(Debug, Clone)]
pub(crate) struct Native {
    pub envelope: Envelope,
    /// About which, and what they are once they are asked for.
    limits: Vec<(Constant, f64, Arc<OnceLock<f64>>)>,
}

/// A state with what is known of it and what an engine made of it.
pub(crate) struct Answered<'a> {
    pub asked: &'a State,
    pub native: Native,
    pub theirs: Vec<Snapshot>,
    /// None where it wrote other moments than were asked for.
    pub farthest: Option<Farthest>,
}

impl Answered<'_> {
    pub fn moves_right(&self) -> bool {
        self.farthest.as_ref().is_some_and(Farthest::moves_right)
    }

    /// The case and its native run.
    fn run(&self) -> (&Case, &[Snapshot]) {
        (&self.asked.case, &self.native.envelope.own)
    }

    fn verdict(&self) -> Verdict {
        verdict(&self.farthest, &self.theirs, &self.native.envelope.own)
    }
}

impl Native {
    fn new(state: &State, resolution: Resolution) -> Result<Self, NativeError> {
        let mut noise = resolution.noise();
        if !resolution.is_double() || state.key == LARGE_STATE {
            // The error of a coarse number is a share of it, and that of a place grows with the bed.
            noise.overlap *= state.faster;
        }
        let envelope = Envelope::new(&state.case, noise)?;
        if state.drawn {
            let limits = Vec::new();
            return Ok(Native { envelope, limits });
        }
        let constants: Vec<Constant> = Constant::all().collect();
        let all = in_parallel(constants.len(), |at| {
            envelope.detection_limit_about(constants[at])
        });
        let mut limits = Vec::new();
        for (constant, limit) in constants.into_iter().zip(all) {
            limits.extend(limit?.map(|about| (constant, about, Arc::default())));
        }
        Ok(Native { envelope, limits })
    }
}

impl Reference {
    /// Of a bed of so many grains whose radii differ by this share from their mean; `progress` hears what is under way.
    pub fn new(
        grains: u32,
        dispersion: f64,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, NativeError> {
        progress("pouring a bed");
        let bed = Bed::new(grains, dispersion)?;
        Ok(Reference::of(bed.states(), bed.excerpts()?))
    }

    /// Of these states and excerpts of scenes.
    pub fn of(states: Vec<State>, excerpts: Vec<Excerpt>) -> Self {
        Reference {
            excerpts,
            names_causes: true,
            rules: Rules::default(),
            double: states.iter().map(|_| OnceLock::new()).collect(),
            states,
            unseen: Arc::default(),
        }
    }

    /// From which engines start.
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// By these rules, where they are not the usual ones, instead of the model's own.
    pub fn under(&self, rules: Rules) -> Self {
        Reference {
            rules,
            double: self.states.iter().map(|_| OnceLock::new()).collect(),
            unseen: Arc::default(),
            excerpts: self
                .excerpts
                .iter()
                .map(|excerpt| excerpt.under(rules))
                .collect(),
            ..self.clone()
        }
    }

    /// Causes are not looked for: that takes most of the time.
    pub fn without_causes(self) -> Self {
        Reference {
            names_causes: false,
            ..self
        }
    }

    /// Judges an engine that says it has these terms in another form; `lacks` says what it has not that a case asks for, and such a case is not handed to it.
    pub fn judge<E: From<NativeError>>(
        &self,
        declared: &[Form],
        lacks: &dyn Fn(&Case) -> Option<String>,
        engine: &mut Engine<'_, E>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Judgement, E> {
        let answers = self.ask(lacks, engine, progress)?;
        let early = |(state, answer): (&(usize, &State), &Answer)| {
            let mut run = answer.as_ref().ok()?.iter();
            let moment = run.find(|snapshot| snapshot.step == EARLY)?;
            Some((state.1.case.name.clone(), moment.bodies.clone()))
        };
        let told = answers.states.iter().zip(&answers.of_states);
        let told: BTreeMap<String, Bodies> = told.filter_map(early).collect();
        let mut judgement = self.judge_answers(declared, answers, progress)?;
        self.follow(&mut judgement, &told, engine, progress);
        Ok(judgement)
    }

    /// Where no cause explains what is wrong, the engine is asked for the same states at each of its first steps, for the term
    /// that is another one. What it cannot answer says nothing more.
    fn follow<E>(
        &self,
        judgement: &mut Judgement,
        told: &BTreeMap<String, Bodies>,
        engine: &mut Engine<'_, E>,
        progress: &mut dyn FnMut(&str),
    ) {
        let Judgement {
            causes,
            starts,
            resolution,
            written,
            ..
        } = judgement;
        let wrong = |start: &&OfStart| start.verdict == Verdict::Different;
        let tables = starts
            .iter()
            .filter(wrong)
            .find(|start| start.tables.is_some());
        let of_tables = tables.filter(|_| causes.is_empty() && resolution.is_double());
        let open = causes.iter_mut().filter(|cause| !cause.explained);
        let open = open.filter(|_| resolution.moves_in_double());
        let asked = open.map(|cause| {
            (
                cause.law.clone(),
                true,
                (&mut cause.terms, &mut cause.unexplained),
            )
        });
        let mut of_written = Vec::new();
        // Where the motion is right, what is written of contacts is not.
        let asked = asked
            .chain(of_tables.map(|start| (start.law.clone(), false, (written, &mut of_written))));
        for (law, moves, (terms, unexplained)) in asked {
            progress(&format!("step by step: {law}"));
            let of_law = starts.iter().filter(|start| start.law == law).filter(wrong);
            let asked = of_law.filter_map(|start| {
                let left = start.farthest.as_ref()?.left_after?;
                let state = self.states.iter().find(|state| state.key == start.key)?;
                // Up to the first moment at which it is off.
                let mut after = state.case.moments.iter().filter(|moment| **moment > left);
                let last = after.next().map_or(left + 1, |off| *off);
                let last = last.clamp(FOLLOWED, LAST_FOLLOWED);
                let moments: Vec<u64> = (0..=last).collect();
                Some(state.case.at(moments))
            });
            let asked: Vec<Case> = asked.collect();
            let Ok(answers) = engine(&asked.iter().collect::<Vec<_>>()) else {
                continue;
            };
            let judged = asked.into_iter().map(|mut case| {
                case.model.rules = self.rules.over(case.model.rules);
                case
            });
            let judged: Vec<Case> = judged.collect();
            let runs = judged.iter().zip(&answers);
            let runs = runs.filter_map(|(case, answer)| {
                let run = answer.as_ref().ok()?;
                case.is_answered_by(run).then_some((case, &run[..]))
            });
            let runs: Vec<(&Case, &[Snapshot])> = runs.collect();
            let is_other = |(case, run): &(&Case, &[Snapshot])| {
                let moment = run.iter().find(|snapshot| snapshot.step == EARLY);
                moment
                    .zip(told.get(&case.name))
                    .is_some_and(|(moment, told)| {
                        let (now, then) = (&moment.bodies, told);
                        let fastest = then.vx.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
                        let mut apart = now.vx.iter().zip(&then.vx).map(|(a, b)| (a - b).abs());
                        apart.any(|apart| apart > SAME_MOMENT * fastest)
                    })
            };
            *terms = match runs.iter().any(is_other) {
                // Then nothing that is written follows from the rest.
                true => vec![format!(
                    "moments that are told of at every step: at step {EARLY} grains move otherwise than where fewer steps are told of"
                )],
                false => {
                    let found = terms::found(&runs, None, moves);
                    *unexplained = found.unexplained;
                    found.terms
                }
            };
        }
        judgement.written.extend(of_written);
        // One fault is not told twice, and beside one that is named what is left of it under other laws says nothing.
        if causes.iter().any(|cause| !cause.terms.is_empty()) {
            let mut seen: Vec<String> = Vec::new();
            causes.retain(|cause| {
                let new = cause.terms.iter().any(|term| !seen.contains(term));
                seen.extend(cause.terms.iter().cloned());
                cause.explained || new
            });
        }
    }

    /// Hands the states to an engine, and small changes of some that tell how coarsely it computes.
    pub(crate) fn ask<E>(
        &self,
        lacks: &dyn Fn(&Case) -> Option<String>,
        engine: &mut Engine<'_, E>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Answers<'_>, E> {
        let (mut states, mut not_asked) = (Vec::new(), Vec::new());
        for (index, state) in self.states.iter().enumerate() {
            match lacks(&state.case) {
                Some(lacking) => not_asked.push(state.not_asked(lacking)),
                None => states.push((index, state)),
            }
        }
        let cases: Vec<&Case> = states.iter().map(|(_, state)| &state.case).collect();
        let probed = states.iter().filter(|(_, state)| state.probed);
        let probed: Vec<&Case> = probed.map(|(_, state)| &state.case).collect();
        let probes: Vec<Vec<Case>> = probed.iter().map(|case| Resolution::cases(case)).collect();
        progress("the engine runs");
        let asked: Vec<&Case> = probes.iter().flatten().chain(cases).collect();
        let mut of_cases = engine(&asked)?;
        let mut resolution = Resolution::DOUBLE;
        let mut nonsense = BTreeMap::new();
        for (case, probes) in probed.iter().zip(&probes) {
            let rest = of_cases.split_off(probes.len().min(of_cases.len()));
            let answers = std::mem::replace(&mut of_cases, rest);
            let of_probe = answers.iter().find(|answer| is_nonsense(answer)).cloned();
            nonsense.extend(of_probe.map(|answer| (case.name.as_str(), answer)));
            let measured = Resolution::measured(case, &answers);
            resolution = measured.map_or(resolution, |measured| resolution.coarser(measured));
        }
        // A start that is changed a little is no less of an answer to this state.
        for ((_, state), answer) in states.iter().zip(&mut of_cases) {
            if let Some(of_probe) = nonsense.remove(state.case.name.as_str()) {
                *answer = of_probe;
            }
        }
        Ok(Answers {
            states,
            of_states: of_cases,
            not_asked,
            resolution,
        })
    }

    /// Judges what an engine answered.
    pub(crate) fn judge_answers(
        &self,
        declared: &[Form],
        answers: Answers<'_>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Judgement, NativeError> {
        let Answers {
            states,
            of_states,
            not_asked,
            resolution,
        } = answers;
        let mut judgement = Judgement {
            grains: states
                .first()
                .map_or(0, |(_, state)| state.case.bodies.len()),
            radii: states
                .iter()
                .map(|(_, state)| radii(&state.case))
                .fold(1.0, f64::max),
            resolution,
            not_asked,
            ..Judgement::default()
        };
        let judged_states: Vec<State> = states
            .iter()
            .map(|(_, state)| state.under(self.rules))
            .collect();
        let mut all = Vec::with_capacity(states.len());
        let (mut looked_at, mut nonsense) = (Vec::new(), Vec::new());
        for (((index, _), state), answer) in states.into_iter().zip(&judged_states).zip(of_states) {
            let mut judged = OfStart::new(&state.law, &state.start, &state.key);
            match answer {
                answer if is_nonsense(&answer) => {
                    judged.verdict = Verdict::Different;
                    judged.skipped = answer.err();
                    nonsense.push((&state.case, true));
                }
                // So many grains are more than some engines are for.
                Err(_) if state.key == LARGE_STATE => {
                    let lacking = format!("beds of {} grains", state.case.bodies.len());
                    judgement.not_asked.push(state.not_asked(lacking));
                    continue;
                }
                // Nothing need be known of it.
                Err(reason) => judged.skipped = Some(reason),
                Ok(theirs) => {
                    progress(&format!("replicas: {}", state.case.name));
                    if envelope::is_rounded(&theirs) {
                        let why = "it writes at most 8 digits, and numbers must read back to the same bits (17 digits)";
                        judged.skipped = Some(why.to_owned());
                        judgement.starts.push(judged);
                        continue;
                    }
                    looked_at.push(index);
                    let make = || Native::new(state, resolution);
                    let native = envelope::once(&self.double[index], resolution, make)?;
                    let answered = Answered {
                        asked: state,
                        farthest: native.envelope.farthest(&theirs),
                        native,
                        theirs,
                    };
                    if state.probed {
                        let (extent, _) = envelope::largest(&answered.native.envelope.own);
                        judgement.extent = judgement.extent.max(extent);
                    }
                    judged.verdict = answered.verdict();
                    judged.farthest = answered.farthest.clone();
                    judged.tables = answered.native.envelope.tables_in_words(&answered.theirs);
                    let is_other = judged.farthest.is_none();
                    judged.skipped = is_other.then(|| OTHER_MOMENTS.to_owned());
                    all.push(answered);
                }
            }
            judgement.starts.push(judged);
        }
        judgement.declared = self.declared(&all);
        judgement.limits = limits(&all)?;
        judgement.counts = exercise::counts(all.iter().map(Answered::run));
        judgement.ranges = exercise::ranges(all.iter().map(Answered::run));
        if judgement.of_states() != Verdict::Different {
            progress("what would not have been seen");
            judgement.unseen = self.unseen(looked_at, &all);
        }
        if self.names_causes && judgement.verdict() == Verdict::Different {
            let states = all.iter().map(|answered| {
                let is_wrong = answered.verdict() == Verdict::Different;
                (&answered.asked.case, is_wrong)
            });
            judgement.condition =
                conditions::of_states(&states.chain(nonsense).collect::<Vec<_>>());
            let usual = all.iter().filter(|answered| !answered.asked.drawn);
            let usual: Vec<Case> = usual.map(|answered| answered.asked.case.clone()).collect();
            // The first of the drawn states that differs tells most, where no other does.
            let differs = |answered: &Answered| answered.verdict() == Verdict::Different;
            let usual_differ = all
                .iter()
                .any(|answered| !answered.asked.drawn && differs(answered));
            match usual_differ {
                true => all.retain(|answered| !answered.asked.drawn),
                false => {
                    let first = all.iter().position(differs);
                    let first = first.map(|at| all.swap_remove(at));
                    all = first.into_iter().collect();
                }
            }
            judgement.causes = causes(&all, resolution, declared, progress);
            for cause in judgement.causes.iter_mut().filter(|_| !usual_differ) {
                let mut constants = cause.constants.iter();
                cause.under_drawn_alone = !cause.constants.is_empty()
                    && constants.all(|fitted| usual.iter().any(|case| fitted.constant.is_in(case)));
            }
        }
        Ok(judgement)
    }
}

impl Reference {
    /// Each declared rule with what it does in the states that are not drawn.
    fn declared(&self, all: &[Answered]) -> Vec<Declared> {
        let moves = |choice: Choice| {
            let states = all.iter().filter(|answered| !answered.asked.drawn);
            let moved = states.map(|answered| {
                let (case, own) = answered.run();
                let mut usual = case.clone();
                choice.rule().unset(&mut usual.model.rules);
                match usual == *case {
                    true => 0.0,
                    false => apart(&variant::run(&usual, &Variant::default()), own),
                }
            });
            moved.fold(0.0, f64::max)
        };
        let declared = self.rules.unusual();
        declared
            .map(|choice| Declared {
                rule: choice.name(),
                moves: moves(choice),
            })
            .collect()
    }

    /// Constants and keys of which these states say nothing.
    fn unseen(&self, looked_at: Vec<usize>, all: &[Answered]) -> Vec<String> {
        let known = self.unseen.lock().ok();
        let known = known.and_then(|unseen| unseen.get(&looked_at).cloned());
        let keys = known.unwrap_or_else(|| {
            let envelopes = all.iter().map(|answered| &answered.native.envelope);
            let keys = exercise::unseen(&envelopes.collect::<Vec<&Envelope>>());
            if let Ok(mut unseen) = self.unseen.lock() {
                unseen.insert(looked_at, keys.clone());
            }
            keys
        });
        let limits = || all.iter().flat_map(|answered| &answered.native.limits);
        let constants = Constant::all().filter(|constant| {
            let mut states = all.iter();
            states.any(|answered| constant.is_in(&answered.asked.case))
                && !limits().any(|limit| limit.0 == *constant)
        });
        let constants = constants.map(Constant::symbol).map(str::to_owned);
        let corners = exercise::untouched_corners(all.iter().map(Answered::run));
        constants
            .chain(keys)
            .chain(corners.map(str::to_owned))
            .collect()
    }
}

/// How far apart a grain is at most at the last moment, over the mean radius.
fn apart(one: &[Snapshot], two: &[Snapshot]) -> f64 {
    let (Some(one), Some(two)) = (one.last(), two.last()) else {
        return 0.0;
    };
    let (one, two) = (&one.bodies, &two.bodies);
    let mean = one.radius.iter().sum::<f64>() / one.len().max(1) as f64;
    let far = |id: usize| (one.x[id] - two.x[id]).hypot(one.z[id] - two.z[id]) / mean;
    (0..one.len()).map(far).fold(0.0, f64::max)
}

/// For each constant the smallest fault that any of the states that were looked at shows.
fn limits(all: &[Answered]) -> Result<Vec<Limit>, NativeError> {
    let all = || all.iter().filter(|answered| answered.farthest.is_some());
    let known = all().flat_map(|answered| &answered.native.limits);
    let mut constants: Vec<Constant> = Vec::new();
    for (constant, ..) in known {
        if !constants.contains(constant) {
            constants.push(*constant);
        }
    }
    let least = in_parallel(constants.len(), |at| {
        let constant = constants[at];
        let of_states = all().flat_map(|answered| {
            let limits = answered.native.limits.iter();
            limits.map(move |(of_state, about, limit)| (of_state, *about, limit, answered))
        });
        let of_states = of_states.filter(|(of_state, ..)| **of_state == constant);
        let mut of_states: Vec<_> = of_states.collect();
        // The first of several that are as small.
        of_states.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut least: Option<Limit> = None;
        for (_, about, limit, answered) in of_states {
            if least
                .as_ref()
                .is_some_and(|least| about * LARGER >= least.smallest)
            {
                break;
            }
            let envelope = &answered.native.envelope;
            let smallest = match limit.get() {
                Some(known) => *known,
                None => {
                    let made = envelope.detection_limit(constant, about)?;
                    *limit.get_or_init(|| made)
                }
            };
            if least.as_ref().is_none_or(|least| smallest < least.smallest) {
                least = Some(Limit {
                    constant: constant.symbol(),
                    smallest,
                    law: answered.asked.law.clone(),
                    start: answered.asked.start.clone(),
                });
            }
        }
        Ok(least)
    });
    let least: Result<Vec<Option<Limit>>, NativeError> = least.into_iter().collect();
    let mut limits: Vec<Limit> = least?.into_iter().flatten().collect();
    limits.sort_by(|a, b| a.smallest.total_cmp(&b.smallest));
    let mut seen = BTreeSet::new();
    limits.retain(|limit| seen.insert(limit.constant));
    Ok(limits)
}
