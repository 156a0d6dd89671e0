//! An engine's first hundred steps from a bed, judged, and what is said of them.

use std::sync::OnceLock;

use crate::checks::{Check, Outcome};
use crate::document::table::rounded;
use crate::document::{Document, Section, Table};
use crate::engine::{Description, Engine, EngineError, Part, ProgramError};
use crate::files::work_folder;
use grains::native::NativeError;
use grains::rules::{CATALOGUE, Choice, Rule};
use grains::tables::{Snapshot, Stage};
use grains::task::{Case, Task, Until};
use verdict::Answer;
use verdict::causes::Cause;
use verdict::envelope::{FACTOR, Farthest, REPLICAS};
use verdict::excerpt::{Ends, Excerpt, FirstMoments, STEPS_OF_EXCERPT, ends};
use verdict::exercise::Range;
use verdict::forms::is_between_grains;
use verdict::identify::Identified;
use verdict::invariance;
use verdict::judge::{Judgement, Limit, NONSENSE, OTHER_MOMENTS, OfStart, Reference, Verdict};
use verdict::spheres;
use verdict::starts::{Bed, State};

/// An engine that refuses a bed is asked for one of so many grains.
const SMALL: u32 = 200;

/// The moments of an excerpt and why its stages ended; a refusal is an answer.
fn run_excerpt(engine: &dyn Engine, excerpt: &Excerpt) -> Result<OfExcerpt, EngineError> {
    let work = work_folder().map_err(ProgramError::File)?;
    let mut seen: Vec<Snapshot> = Vec::new();
    match engine.run(&excerpt.scene, &excerpt.task, work.path(), &mut seen) {
        Ok(run) => Ok(Ok((seen, Some(ends(&run.outcome.stages))))),
        Err(EngineError::Program(ProgramError::Refused(why))) => Ok(Err(why)),
        Err(error) => Err(error),
    }
}

type OfExcerpt = Result<(Vec<Snapshot>, Option<Ends>), String>;

/// A bed and a small one, with what is known of them; made when an engine asks for them, once for all engines.
#[derive(Debug)]
pub struct Beds {
    grains: u32,
    dispersion: f64,
    made: [OnceLock<Reference>; 2],
    /// Spheres in space, unless the beds are a scene's.
    spheres: Option<OnceLock<Reference>>,
    /// Of a bed from which an engine is held against itself.
    itself: OnceLock<Vec<State>>,
    /// Whether it is in every state, and not in one.
    pub thorough: bool,
}

impl Beds {
    /// Of so many grains, whose radii differ by this share of the mean radius.
    pub fn new(grains: u32, dispersion: f64) -> Self {
        Beds {
            grains,
            dispersion,
            made: Default::default(),
            spheres: Some(OnceLock::new()),
            itself: OnceLock::new(),
            thorough: false,
        }
    }

    /// Those of a bed small enough that it costs little to run them many times.
    pub fn for_itself(&self) -> Result<Vec<State>, NativeError> {
        let made = match self.itself.get() {
            Some(made) => made,
            None => {
                let mut made = Bed::new(invariance::GRAINS, self.dispersion)?.states();
                made.extend(verdict::spheres::for_itself()?);
                self.itself.get_or_init(|| made)
            }
        };
        Ok(made.clone())
    }
}

impl From<Reference> for Beds {
    /// Of these states alone.
    fn from(reference: Reference) -> Self {
        Beds {
            grains: 0,
            dispersion: 0.0,
            made: [OnceLock::from(reference), OnceLock::new()],
            spheres: None,
            itself: OnceLock::new(),
            thorough: false,
        }
    }
}

/// Judges the engine from a bed, or from a small one if it refuses so many grains; and in space, if it says that it has spheres there.
pub fn first_steps(
    engine: &dyn Engine,
    beds: &Beds,
    progress: &mut dyn FnMut(&str),
) -> Result<Judgement, EngineError> {
    let mut from =
        |bed: &OnceLock<Reference>, grains: Option<u32>| -> Result<Judgement, EngineError> {
            let reference = match bed.get() {
                Some(known) => known,
                None => {
                    let made = match grains {
                        Some(grains) => Reference::new(grains, beds.dispersion, progress)?,
                        None => spheres::reference()?,
                    };
                    bed.get_or_init(|| made)
                }
            };
            from_bed(reference, engine, progress)
        };
    let [usual, small] = &beds.made;
    let mut found = from(usual, Some(beds.grains))?;
    if engine.describe()?.has(Part::SpaceAlone) {
        found.not_asked.clear();
    }
    // What it lacks it lacks in a small bed too.
    let refused = found.starts.iter().all(OfStart::was_refused);
    if refused && !found.starts.is_empty() && beds.grains > SMALL {
        found = from(small, Some(SMALL))?;
    }
    match &beds.spheres {
        Some(spheres) if engine.describe()?.has(Part::Space) => {
            Ok(found.with_spheres(from(spheres, None)?))
        }
        _ => Ok(found),
    }
}

/// Which rules an engine computes with, whatever it declares; from a small bed if it refuses so many grains.
pub fn identify(
    engine: &dyn Engine,
    grains: u32,
    dispersion: f64,
    progress: &mut dyn FnMut(&str),
) -> Result<Identified, EngineError> {
    let mut run = |cases: &[&Case]| {
        let work = work_folder().map_err(ProgramError::File)?;
        engine.run_cases(cases, work.path())
    };
    let lacks = |case: &Case| engine.lacks_for(case);
    let mut from = |grains| -> Result<Identified, EngineError> {
        let reference = Reference::new(grains, dispersion, progress)?;
        reference.identify(engine.forms(), &lacks, &mut run, progress)
    };
    let found = from(grains)?;
    let mut starts = found.judgement.starts.iter();
    match grains > SMALL && starts.all(OfStart::was_refused) {
        true => from(SMALL),
        false => Ok(found),
    }
}

/// What was found, for people: the rules with what was not told apart, and what is said of the first steps under them.
pub fn identified(engine: &Description, found: &Identified) -> Document {
    let judgement = &found.judgement;
    let verdict = judgement.verdict();
    let names = |choices: &mut dyn Iterator<Item = Choice>| {
        let names: Vec<String> = choices.map(Choice::name).collect();
        names.join(", ")
    };
    let unusual = names(&mut found.rules.unusual());
    let mut said = match unusual.is_empty() {
        true => "all rules are this program's own.".to_owned(),
        false => format!("found from its steps: {unusual}; all others are this program's own."),
    };
    if !found.also.is_empty() {
        said += &format!(
            " As well explained: {}.",
            names(&mut found.also.iter().copied())
        );
    }
    let declared = engine.rules;
    if !declared.are_usual() {
        let is_other = |choice: &Choice| {
            let is_found = choice.is_in(&found.rules) || is_between_grains(*choice, &found.rules);
            let is_asked = !found.unasked.contains(&choice.rule().key);
            is_asked && !is_found && !found.also.contains(choice)
        };
        let others = names(&mut declared.choices().filter(is_other));
        said += &match others.is_empty() {
            true => " It declares the same.".to_owned(),
            false => format!(" It declares otherwise: {others}."),
        };
    }
    if !found.unasked.is_empty() {
        let unasked = found.unasked.join(", ");
        said += &format!(
            " Of {unasked} no state in the plane that it has the parts for says anything."
        );
    }
    let rows = CATALOGUE
        .iter()
        .filter(|rule| !found.unasked.contains(&rule.key));
    let of_rule = |rule: &Rule, choices: &mut dyn Iterator<Item = Choice>| {
        let of_rule = choices.filter(|choice| choice.rule().key == rule.key);
        let keys: Vec<&str> = of_rule.map(|choice| choice.alternative().key).collect();
        keys.join(", ")
    };
    let table = Table::of("rules", "", rows)
        .column("rule", |rule: &Rule| rule.key)
        .column("found", |rule| of_rule(rule, &mut found.rules.choices()))
        .column("or", |rule| of_rule(rule, &mut found.also.iter().copied()))
        .column("declared", |rule| {
            (!declared.are_usual()).then(|| of_rule(rule, &mut declared.choices()))
        });
    let rules = serde_json::to_string(&found.rules).expect("rules are JSON");
    let about = format!("For a description: `\"rules\": {rules}`.");
    let mut all =
        vec![Section::new("Its rules", &about).with(Table::from(table).without_empty_columns())];
    all.extend(sections(judgement));
    let rules_are = "It is judged by the rules that were found, otherwise than the model";
    let answer = format!(
        "{} {} Spheres in space, whole jobs, stages and later steps were not looked at: `engine check` does that.",
        with_verdict(verdict, &said),
        sentence(&of_states(judgement, rules_are))
    );
    let checks = checks(judgement, "engine/first-steps");
    Document {
        verdict: verdict.into(),
        ..Document::new(format!("Rules of {}", engine.label()), answer, checks).with(all)
    }
}

/// What an engine makes of these cases; where one of them makes it write nonsense, what it makes of the others.
fn by_halves(engine: &dyn Engine, cases: &[&Case]) -> Result<Vec<Answer>, EngineError> {
    let run = |cases: &[&Case]| {
        let work = work_folder().map_err(ProgramError::File)?;
        engine.run_cases(cases, work.path())
    };
    let is_nonsense = |made: &Result<Vec<Answer>, EngineError>| {
        matches!(made, Err(EngineError::Program(ProgramError::Nonsense(_))))
    };
    let made = run(cases);
    let (Some(first), Some(last)) = (cases.first(), cases.last()) else {
        return made;
    };
    // Of what is nonsense at both ends no case need be blamed.
    let is_all = || {
        [first, last]
            .into_iter()
            .all(|case| is_nonsense(&run(&[*case])))
    };
    if !is_nonsense(&made) || is_all() {
        return made;
    }
    let mut answers = Vec::with_capacity(cases.len());
    let mut parts = vec![cases];
    while let Some(part) = parts.pop() {
        match (run(part), part) {
            (Err(EngineError::Program(ProgramError::Nonsense(reason))), [_]) => {
                answers.push(Err(format!("{NONSENSE}{reason}")));
            }
            (made, _) if is_nonsense(&made) => {
                let (first, second) = part.split_at(part.len() / 2);
                parts.extend([second, first]);
            }
            (made, _) => answers.extend(made?),
        }
    }
    Ok(answers)
}

/// Whether it has both stages. An engine without constants of its own for loading need not go on into it.
fn goes_on(task: &Task) -> bool {
    (task.start.stage, task.until) == (Stage::Settle, Until::EndOfLoading)
}

/// Judges the engine against what is known of a bed.
pub fn from_bed(
    reference: &Reference,
    engine: &dyn Engine,
    progress: &mut dyn FnMut(&str),
) -> Result<Judgement, EngineError> {
    let mut run = |cases: &[&Case]| by_halves(engine, cases);
    let under;
    let asked = &reference.excerpts;
    let reference = match engine.rules() {
        rules if rules.are_usual() => reference,
        rules => {
            under = reference.under(rules);
            &under
        }
    };
    let mut found = reference.judge(
        engine.forms(),
        &|case| engine.lacks_for(case),
        &mut run,
        progress,
    )?;
    let has_stages = engine.describe()?.has(Part::Stages);
    let nobody_to_ask = found.starts.iter().all(|start| start.skipped.is_some());
    let has_run = |asked: &Excerpt, excerpt: &Excerpt| {
        engine.lacks(&asked.scene, &asked.task).is_none() && !excerpt.has_no_run()
    };
    let pairs = asked.iter().zip(&reference.excerpts);
    let runs = pairs.filter(|(asked, excerpt)| !nobody_to_ask && has_run(asked, excerpt));
    let runs: Vec<_> = runs.map(|(asked, _)| (&asked.scene, &asked.task)).collect();
    let mut together = engine.run_together(&runs).unwrap_or_default().into_iter();
    for (asked, excerpt) in asked.iter().zip(&reference.excerpts) {
        progress(&excerpt.start);
        match engine.lacks(&asked.scene, &asked.task) {
            _ if nobody_to_ask => {}
            Some(lacking) => found.not_asked.push(excerpt.not_asked(lacking)),
            None if excerpt.has_no_run() => {
                let lacking = "runs by its rules that stay in the box";
                found.not_asked.push(excerpt.not_asked(lacking.to_owned()));
            }
            None => {
                let moments = together.next().map(|seen| Ok(Ok((seen, None))));
                let answer = moments.unwrap_or_else(|| run_excerpt(engine, asked));
                if matches!(answer, Ok(Err(_))) && goes_on(&asked.task) && !has_stages {
                    let lacking = "loading that goes on from settling with friction";
                    found.not_asked.push(excerpt.not_asked(lacking.to_owned()));
                    continue;
                }
                let judged = match answer {
                    // What is wrong with it is known, and may well end its run.
                    Err(error) if found.verdict() == Verdict::Different => {
                        excerpt.failed(error.to_string())
                    }
                    answer => excerpt.judge(answer?, found.resolution)?,
                };
                // What is wrong in a scene alone is in what no case has.
                let farthest = judged.farthest.as_ref();
                let is_followed = found.causes.is_empty()
                    && found.written.is_empty()
                    && found.resolution.moves_in_double()
                    && judged.verdict == Verdict::Different;
                if let Some(farthest) = farthest.filter(|_| is_followed) {
                    let mut first = FirstMoments::default();
                    let asked = asked.step_by_step();
                    let work = work_folder().map_err(ProgramError::File)?;
                    // It has run before; where it does not again, no more is told.
                    if engine
                        .run(&asked.scene, &asked.task, work.path(), &mut first)
                        .is_ok()
                    {
                        found
                            .causes
                            .extend(excerpt.followed(&first.0, !farthest.moves_right()));
                    }
                }
                found.starts.push(judged);
            }
        }
    }
    Ok(found)
}

/// One for each state, or a missing one where the engine lacks something for all of them; their ids begin with this one.
pub fn checks(judgement: &Judgement, id: &str) -> Vec<Check> {
    if judgement.starts.is_empty() {
        let lacking = judgement
            .not_asked
            .first()
            .map_or("", |excerpt| excerpt.lacking.as_str());
        let found = format!("the engine has no {lacking}");
        let what = "first steps from a bed";
        return vec![Check::of_words(id, what, Outcome::Skipped, &found).required()];
    }
    let mut checks: Vec<Check> = judgement
        .starts
        .iter()
        .map(|start| check(start, id))
        .collect();
    let (outcome, found) = match judgement.open() {
        Some(why) => (Outcome::Skipped, why),
        None => (Outcome::Pass, touched(judgement)),
    };
    let id = format!("{id}/evidence");
    checks.push(
        Check::of_words(
            id,
            "what touches and slides in these states",
            outcome,
            &found,
        )
        .required(),
    );
    checks
}

/// What the states exercise, and what not.
fn touched(judgement: &Judgement) -> String {
    let counts: Vec<String> = judgement
        .counts
        .iter()
        .map(|count| format!("{} {}", count.found, count.what))
        .collect();
    let states = judgement
        .starts
        .iter()
        .filter(|state| state.farthest.is_some())
        .count();
    let grains = beds_in_words(judgement);
    format!(
        "{states} states of {grains} with radii up to {:.2} times the smallest, at most {} at once",
        judgement.radii,
        counts.join(", ")
    )
}

/// The beds of which the states are.
fn beds_in_words(judgement: &Judgement) -> String {
    let Judgement {
        grains, spheres, ..
    } = judgement;
    match (grains, spheres) {
        (_, 0) => format!("{grains} grains"),
        (0, _) => format!("{spheres} spheres in space"),
        _ => format!("{grains} grains in the plane and of {spheres} spheres in space"),
    }
}

fn check(state: &OfStart, id: &str) -> Check {
    let (outcome, found) = match (&state.skipped, state.verdict) {
        (Some(why), Verdict::Different) => (Outcome::Fail, why.clone()),
        (Some(why), _) if why.starts_with(OTHER_MOMENTS) => (Outcome::Skipped, why.clone()),
        (Some(why), _) => (Outcome::Skipped, format!("the engine refused: {why}")),
        (None, Verdict::Different) => (Outcome::Fail, state.in_words()),
        (None, _) => (Outcome::Pass, state.in_words()),
    };
    let id = format!("{id}/{}", state.key);
    let quantity = format!("{}, {}", state.law, state.start);
    let ratio = state
        .farthest
        .as_ref()
        .map_or(f64::NAN, |farthest| farthest.ratio);
    let check = Check::of_words(id, &quantity, outcome, &found);
    // No distance is below zero.
    let check = Check {
        lower: Some(0.0),
        ..check.with_limits(ratio, 0.0, Some(FACTOR))
    };
    check
        .required()
        .judged_by(
            "the largest distance from the native run over that of replicas with rounding errors as coarse as the engine's",
            &format!("{REPLICAS} replicas; 1, 3, 10, 30 and 100 steps"),
        )
}

/// The verdict before what is said of it; that two differ, the outcome has said.
pub fn with_verdict(verdict: Verdict, said: &str) -> String {
    match verdict {
        Verdict::Different => sentence(said),
        other => sentence(&format!("{}: {said}", other.in_words())),
    }
}

/// With a capital at its beginning.
pub fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// A cause: what the engine is, or what it does.
fn in_a_sentence(cause: &Cause) -> String {
    match cause.explained && !cause.constants.is_empty() {
        true => format!("It is {}", cause.sentence()),
        false => sentence(&cause.sentence()),
    }
}

/// What it comes to, in a few sentences, and what no such state would show.
pub fn answer(judgement: &Judgement) -> String {
    let later = match judgement.verdict() {
        Verdict::Identical | Verdict::EqualToRounding => format!(
            " What begins after step 100 of a list of grains or {STEPS_OF_EXCERPT} of a scene's job, in larger beds or with a grain's centre inside the punch would not have \
             been seen here, nor what begins outside these ranges: {}.",
            ranges_in_words(&judgement.ranges)
        ),
        _ => String::new(),
    };
    from_states(judgement) + &later
}

/// From where to where each constant and quantity goes, first in the plane, then in space.
fn ranges_in_words(ranges: &[Range]) -> String {
    let one = |range: &Range| {
        let unit = if range.unit.is_empty() { "" } else { " " };
        let [least, most] = [range.least, range.most].map(|value| rounded(value, 3));
        let from_to = match range.least {
            value if value == range.most => most,
            value if (0.0..1.0e-3 * range.most).contains(&value) => format!("up to {most}"),
            _ => format!("{least} to {most}"),
        };
        format!("{} {from_to}{unit}{}", range.what, range.unit)
    };
    let listed = |in_space: bool| -> Vec<String> {
        let there = ranges.iter().filter(|range| range.in_space == in_space);
        there.map(one).collect()
    };
    let parts = [("in the plane", listed(false)), ("in space", listed(true))];
    let parts = parts.into_iter().filter(|(_, ranges)| !ranges.is_empty());
    let parts: Vec<String> = parts
        .map(|(place, ranges)| format!("{place} {}", ranges.join(", ")))
        .collect();
    parts.join("; ")
}

/// The same of the states alone.
pub fn from_states(judgement: &Judgement) -> String {
    of_states(
        judgement,
        "It is judged by rules that it declares otherwise than the model",
    )
}

/// And of rules that are not the model's, with what they are.
fn of_states(judgement: &Judgement, rules_are: &str) -> String {
    let declared = judgement.declared.iter();
    let rules = declared.map(|declared| {
        format!(
            "{} (moves a grain by {:.1e} R in a hundred steps)",
            declared.rule, declared.moves
        )
    });
    let rules: Vec<String> = rules.collect();
    let said = said_of_states(judgement);
    match rules.is_empty() {
        true => said,
        false => format!("{said} {rules_are}: {}.", rules.join(", ")),
    }
}

fn said_of_states(judgement: &Judgement) -> String {
    let precision = judgement.resolution.name();
    let seen = seen(&judgement.limits);
    let unseen = match judgement.unseen.is_empty() {
        true => String::new(),
        false => format!(
            " (nothing is said of what changes nothing in these states: {})",
            judgement.unseen.join(", ")
        ),
    };
    let judged = format!("Judged from {}.", touched(judgement));
    let mut said = match judgement.verdict() {
        Verdict::Different => {
            let mut said: Vec<String> = judgement.causes.iter().map(in_a_sentence).collect();
            // Where a cause explains all, it has said as much.
            let mut causes = judgement.causes.iter();
            let is_open = causes.len() == 0 || causes.any(|cause| !cause.explained);
            let starts = &judgement.starts;
            let skipped = starts.iter().filter_map(|start| start.skipped.as_ref());
            let nonsense: Vec<&String> = skipped.filter(|why| why.starts_with(NONSENSE)).collect();
            if let [first, ..] = nonsense[..] {
                said.push(format!(
                    "In {} of {} states {first}.",
                    nonsense.len(),
                    starts.len()
                ));
            }
            let condition = judgement.condition.iter().filter(|_| is_open);
            said.extend(condition.map(|words| format!("Of all states: {words}.")));
            let tables = judgement
                .starts
                .iter()
                // Where the motion is wrong too, its forces are, and not what is written of them.
                .filter(|state| state.farthest.as_ref().is_some_and(Farthest::moves_right))
                .find_map(|state| Some((&state.start, state.tables.as_ref()?)));
            said.extend(
                tables.map(|(start, fault)| match judgement.written.is_empty() {
                    true => format!("Its contact tables are wrong: in {start}, {fault}."),
                    false => format!(
                        "Its contact tables are wrong: {}.",
                        judgement.written.join("; ")
                    ),
                }),
            );
            let mut starts = judgement
                .starts
                .iter()
                .filter(|state| state.verdict == Verdict::Different);
            if let (true, Some(state)) = (said.is_empty(), starts.next()) {
                let why = state.skipped.clone().unwrap_or_else(|| state.in_words());
                said.push(format!("{}, {}: {why}.", state.law, state.start));
            }
            said.join(" ")
        }
        Verdict::Undecided if judgement.starts.is_empty() => "no state was looked at.".to_owned(),
        Verdict::Undecided => match judgement.open() {
            Some(why) => format!("{why}. {judged}"),
            None => {
                let open = judgement
                    .starts
                    .iter()
                    .filter(|state| state.skipped.is_some())
                    .count();
                format!(
                    "{open} of {} states were not looked at, for it refused them.",
                    judgement.starts.len()
                )
            }
        },
        Verdict::Identical => {
            format!(
                "every bit of its first hundred steps is the native engine's{unseen}. {judged} {seen}"
            )
        }
        _ => {
            let ratio = judgement
                .farthest()
                .and_then(|state| state.farthest.as_ref());
            let ratio = ratio.map_or(0.0, |farthest| farthest.ratio);
            format!(
                "in {precision} its first hundred steps are at most {ratio:.2} times as far off as replicas{unseen}. {judged} {seen}"
            )
        }
    };
    if !judgement.not_asked.is_empty() {
        let mut lacking: Vec<&str> = Vec::new();
        for part in judgement
            .not_asked
            .iter()
            .flat_map(|excerpt| excerpt.lacking.split(", "))
        {
            if !lacking.contains(&part) {
                lacking.push(part);
            }
        }
        let (count, lacking) = (judgement.not_asked.len(), lacking.join(", "));
        said += &format!(" Of {count} other states nothing is said: it has no {lacking}.");
    }
    said
}

fn seen(limits: &[Limit]) -> String {
    let ends = limits.first().zip(limits.last());
    let range = |limit: &Limit| format!("{:.0e} ({})", limit.smallest, limit.constant);
    ends.map_or(String::new(), |(first, last)| {
        let (first, last) = (range(first), range(last));
        format!("A constant that is wrong by more than {first} to {last} would have been seen.")
    })
}

pub fn state_table(judgement: &Judgement) -> Table {
    Table::of("first-steps", "", judgement.starts.iter())
        .column("law", |state: &OfStart| &state.law)
        .column("state", |state| &state.start)
        .column("verdict", |state| state.verdict.in_words())
        .column("times as far as replicas", |state| {
            state.farthest.as_ref().map(|farthest| farthest.ratio)
        })
        .column("left them after, steps", |state| {
            state.farthest.as_ref()?.left_after
        })
        .into()
}

pub fn sections(judgement: &Judgement) -> Vec<Section> {
    let about = format!(
        "A bed of {}. The engine computes in {}: it notices changes of {:.1e} of a coordinate, {:.1e} m in overlaps, {:.1e} of a \
         velocity. Replicas are native runs with such errors in every step; up to {FACTOR} times their distance is rounding.",
        beds_in_words(judgement),
        judgement.resolution.name(),
        judgement.resolution.position,
        judgement.resolution.overlap,
        judgement.resolution.velocity
    );
    let limits = Table::of("smallest-faults", "", judgement.limits.iter())
        .column("constant", |limit: &Limit| limit.constant)
        .column("smallest fault seen", |limit| limit.smallest)
        .column("law", |limit| &limit.law)
        .column("state", |limit| &limit.start);
    let mut sections = vec![
        Section::new("Its first hundred steps", &about).with(state_table(judgement)),
        Section::new(
            "What would have been seen",
            "A constant that is wrong by this share, everywhere, leaves the replicas; g_x by this share of gravity.",
        )
        .with(Table::from(limits)),
    ];
    if !judgement.causes.is_empty() {
        let why = judgement.causes.iter().map(in_a_sentence);
        sections.push(Section::new("What is wrong", "").with_all(why));
    }
    sections
}
