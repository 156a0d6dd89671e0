//! Running the suite: every case in every engine that is asked for; and what people are told of it.

use std::collections::BTreeSet;

use serde::Serialize;

use super::cross_code::{self, CrossCase};
use super::detection::{Limit, Limits, Varied, limits};
use super::parameters::{self, Answer, Errors};
use super::{CaseGroup, Evidence, Track, exact, outcome, symmetry};
use crate::checks::{Check, Outcome, verdict};
use crate::compare::first_steps::{self, Beds};
use crate::document::plot::Point;
use crate::document::{Axis, Cell, Colour, Document, Plot, Section, Table};
use crate::engine::yade::{self, CaseInYade, run_cases, unsupported};
use crate::engine::{Description, Engine, Part, ProgramError, value_name};
use crate::files::work_folder;
use crate::paper::disc_field::{DiscField, figure_4};
use crate::progress::{Display, StageObserver};
use crate::run::EngineError;
use crate::workers::asked_to_end;
use grains::native::{CaseOptions, loads, run_case};
use grains::rules::{Choice, Rules};
use grains::task::{Case, Observer};
use nalgebra::Matrix2;
use verdict::envelope::Resolution;
use verdict::judge::Judgement;

#[derive(Debug, Clone)]
pub struct Options {
    /// Whether the native engine takes part.
    pub native: bool,
    /// YADE, where it takes part; beside the native engine, one is held against the other.
    pub yade: Option<yade::Options>,
    /// Trajectories and rounding errors of so many grains at most.
    pub grains: u32,
    pub detection_limits: bool,
    pub command: String,
}

/// What part an engine has in a case; ids of checks have it in place of the engine's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    Tested,
    /// It is what another one is compared with, and runs the same cases.
    Reference,
    CrossCode,
    Suite,
}

/// One case in one engine, or in two.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseResult {
    pub id: String,
    pub title: String,
    pub evidence: Evidence,
    pub role: Role,
    pub engine: String,
    /// Passed if every check holds and there is one.
    pub outcome: Outcome,
    /// Why it was skipped, or what went wrong; empty otherwise.
    pub reason: String,
    /// Skipped because the engine says that it has no such option: nothing is missing. One that says that it has it and
    /// refuses leaves the suite incomplete.
    pub inapplicable: bool,
    /// Its checks; the record has those of all cases as one list.
    #[serde(skip)]
    pub checks: Vec<Check>,
}

impl CaseResult {
    /// With what was found, or why nothing was.
    fn judged(mut self, found: Result<Vec<Check>, String>) -> Self {
        let prefix = self.check_id();
        match found {
            Ok(checks) => {
                let undecided = checks.iter().any(|check| check.outcome == Outcome::Skipped);
                let failed = checks.iter().any(|check| check.outcome == Outcome::Fail);
                let by_rules = |check: &&Check| check.outcome == Outcome::ExpectedFailure;
                let known = checks.iter().filter(by_rules).count();
                self.outcome = match (failed, undecided) {
                    (false, true) => Outcome::Skipped,
                    (false, false) if known > 0 => Outcome::Pass,
                    _ => outcome(&checks),
                };
                if known > 0 && !failed {
                    self.reason = format!("{known} numbers are those of the engine's own rules.");
                }
                let named = |check: Check| Check {
                    id: format!("{prefix}/{}", check.id),
                    method: self.title.clone(),
                    ..check
                };
                self.checks = checks.into_iter().map(named).collect();
            }
            Err(reason) => (self.outcome, self.reason) = (Outcome::Fail, reason),
        }
        self.with_a_check()
    }

    fn skipped(mut self, reason: &str, inapplicable: bool) -> Self {
        (self.outcome, self.inapplicable) = (Outcome::Skipped, inapplicable);
        reason.clone_into(&mut self.reason);
        self.with_a_check()
    }

    /// What has no figures has one check without numbers.
    fn with_a_check(mut self) -> Self {
        if self.checks.is_empty() {
            let id = self.check_id();
            let mut check = Check::of_words(id, &self.title, self.outcome, &self.reason);
            check.required = !self.inapplicable;
            self.checks.push(check);
        }
        self
    }

    fn check_id(&self) -> String {
        format!("verify/{}/{}", value_name(&self.role), self.id)
    }
}

/// A case that is about to be run.
fn case(id: &str, title: &str, evidence: Evidence, (role, engine): (Role, &str)) -> CaseResult {
    CaseResult {
        id: id.to_owned(),
        title: title.to_owned(),
        evidence,
        role,
        engine: engine.to_owned(),
        outcome: Outcome::Skipped,
        reason: String::new(),
        inapplicable: false,
        checks: Vec::new(),
    }
}

fn of_group(group: &CaseGroup, by: (Role, &str)) -> CaseResult {
    case(group.id, group.title, group.evidence, by)
}

const TOGETHER: (Role, &str) = (Role::CrossCode, "native and YADE");

fn of_cross(cross: &CrossCase) -> CaseResult {
    case(&cross.id, &cross.title, Evidence::CrossCode, TOGETHER)
}

fn of_parameters() -> CaseResult {
    let title = "Both engines use the same parameters";
    case("parameters", title, Evidence::CrossCode, TOGETHER)
}

fn of_precision() -> CaseResult {
    let title = "Rounding errors of both engines against 128-bit arithmetic";
    case("precision", title, Evidence::Precision, TOGETHER)
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    pub passed: usize,
    pub failed: usize,
    pub skipped: usize,
    /// Cases that an engine has no option for.
    pub inapplicable: usize,
}

impl Tally {
    fn of(cases: &[CaseResult]) -> Self {
        let mut tally = Tally::default();
        // That each case detects its faults is no case of its own.
        for case in cases
            .iter()
            .filter(|case| case.evidence != Evidence::Detection)
        {
            *match case.outcome {
                Outcome::Pass => &mut tally.passed,
                Outcome::Skipped if case.inapplicable => &mut tally.inapplicable,
                Outcome::Skipped => &mut tally.skipped,
                _ => &mut tally.failed,
            } += 1;
        }
        tally
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (passed, failed, others) = (self.passed, self.failed, self.inapplicable);
        write!(out, "{passed} cases passed, {failed} failed, ")?;
        write!(out, "{} skipped", self.skipped + others)?;
        match others {
            0 => Ok(()),
            others => write!(out, ", {others} of them since an engine lacks the parts"),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verification {
    pub crossgrain: String,
    pub command: String,
    pub yade: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exec: Option<Description>,
    /// Of an external engine, from a bed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_steps: Option<Judgement>,
    pub cases: Vec<CaseResult>,
    pub errors: Vec<Errors>,
    /// The stress inside Figure 4's disc.
    pub disc: DiscFigures,
    pub limits: Option<Limits>,
    pub tally: Tally,
}

impl Verification {
    fn new(command: &str, cases: Vec<CaseResult>) -> Self {
        Verification {
            crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
            command: command.to_owned(),
            yade: None,
            exec: None,
            first_steps: None,
            tally: Tally::of(&cases),
            cases,
            errors: Vec::new(),
            disc: DiscFigures::of(&figure_4()),
            limits: None,
        }
    }

    pub fn verdict(&self) -> Outcome {
        verdict(&self.checks())
    }

    pub fn checks(&self) -> Vec<Check> {
        let checks = self.cases.iter().flat_map(|case| &case.checks);
        let first_steps = self.first_steps.iter();
        let first_steps =
            first_steps.flat_map(|judgement| first_steps::checks(judgement, "verify/first-steps"));
        checks.cloned().chain(first_steps).collect()
    }
}

/// Stresses of Figure 4's disc, Pa, tension positive, xx, zz, xz.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DiscFigures {
    /// Σ/V of the contact forces.
    pub contact: [f64; 3],
    /// The field averaged over the disc by quadrature.
    pub disc: [f64; 3],
    /// The field averaged over the control square of side R at the centre.
    pub square: [f64; 3],
    /// Σ over the cell of side 2R: σ of Table 3.
    pub cell: [f64; 3],
}

impl DiscFigures {
    fn of(field: &DiscField) -> Self {
        let parts = |matrix: Matrix2<f64>| [matrix[(0, 0)], matrix[(1, 1)], matrix[(0, 1)]];
        DiscFigures {
            contact: parts(field.contact_average()),
            disc: parts(field.average_over_disc()),
            square: parts(field.average_over_square(field.radius())),
            cell: parts(field.average_over_cell(2.0 * field.radius())),
        }
    }
}

pub struct Suite {
    pub groups: Vec<CaseGroup>,
    pub cross: Vec<CrossCase>,
}

#[derive(Default)]
struct RunInYade {
    version: Option<String>,
    groups: Vec<CaseResult>,
    /// What it says of the scenes' parameters.
    answers: Vec<Answer>,
    /// What it made of the cross-code cases.
    cross: Vec<CaseInYade>,
}

impl Suite {
    /// The suite with trajectories of so many grains at most, for engines with these rules.
    pub fn new(most_grains: u32, rules: Rules) -> Self {
        let mut cross = cross_code::static_states();
        cross.extend(cross_code::cases(most_grains));
        Suite {
            groups: super::groups(rules),
            cross,
        }
    }

    pub fn run_native(&self) -> Vec<CaseResult> {
        let sound = CaseOptions::default();
        let run = |group: &CaseGroup| {
            let tracks = native_tracks(&group.cases, &sound);
            of_group(group, (Role::Tested, "native"))
                .judged(tracks.map(|tracks| group.judge(&tracks)))
        };
        // Whoever asked for them is told of the signal.
        let groups = self.groups.iter().take_while(|_| !asked_to_end());
        groups.map(run).collect()
    }

    /// All cases in one process of YADE, and the parameters of the scenes.
    fn run_yade(
        &self,
        role: Role,
        options: &yade::Options,
        observer: &mut dyn Observer,
    ) -> Result<RunInYade, EngineError> {
        let scenes = parameters::scenes().map(|(name, scene)| (name, parameters::probe(&scene)));
        let can = |group: &&CaseGroup| not_in_yade(group).is_none();
        let alone = self
            .groups
            .iter()
            .filter(can)
            .flat_map(|group| &group.cases);
        let mut cases: Vec<&Case> = scenes.iter().map(|(_, probe)| probe).chain(alone).collect();
        cases.extend(self.cross.iter().map(|cross| &cross.case));
        let work = work_folder().map_err(ProgramError::File)?;
        let (made, version) = run_cases(&cases, options, work.path(), observer)?;
        let mut rest = made.into_iter();
        let answers = scenes.into_iter().zip(rest.by_ref());
        let answers = answers.map(|((name, probe), answer)| Answer {
            name,
            probe,
            yade: answer.effective,
        });
        let answers = answers.collect();
        let judge = |group: &CaseGroup| {
            let case = of_group(group, (role, "YADE"));
            if let Some(reason) = not_in_yade(group) {
                return case.skipped(&format!("YADE has no {reason}"), true);
            }
            let own = rest.by_ref().take(group.cases.len());
            let own: Vec<Track> = own.map(|answer| answer.track).collect();
            case.judged(Ok(group.judge(&own)))
        };
        Ok(RunInYade {
            version: Some(version),
            groups: {
                let groups = self.groups.iter().take_while(|_| !asked_to_end());
                groups.map(judge).collect()
            },
            answers,
            cross: rest.collect(),
        })
    }

    /// Native against what YADE made of the cross-code cases.
    fn compare(&self, in_yade: &[CaseInYade]) -> Vec<CaseResult> {
        let compare = |(cross, yade): (&CrossCase, &CaseInYade)| {
            let native = run_case(&cross.case, None).and_then(|track| match yade.loads[..] {
                [] => Ok((track, Vec::new())),
                _ => Ok((track, loads(&cross.case)?)),
            });
            let found = native.map(|(track, loads)| cross_code::judge(cross, &track, &loads, yade));
            of_cross(cross).judged(found.map_err(|error| error.to_string()))
        };
        self.cross.iter().zip(in_yade).map(compare).collect()
    }

    /// All cases that need YADE, as skipped.
    fn without_yade(&self, reason: &str, role: Role) -> Vec<CaseResult> {
        let groups = self
            .groups
            .iter()
            .map(|group| of_group(group, (role, "YADE")));
        let cross = self.cross.iter().map(of_cross).chain([of_precision()]);
        let cases = groups.chain([of_parameters()]).chain(cross);
        cases.map(|case| case.skipped(reason, false)).collect()
    }

    /// Every group in an engine, each in a start of its own: what breaks one leaves the others.
    fn run_in(
        &self,
        engine: &dyn Engine,
        name: &str,
        resolution: Resolution,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Vec<CaseResult>, EngineError> {
        let mut results = Vec::with_capacity(self.groups.len());
        let rounded = symmetry::rounded();
        for (index, group) in self.groups.iter().enumerate() {
            progress(index, self.groups.len());
            let of_engines = rounded.iter().find(|other| other.id == group.id);
            let group = of_engines.unwrap_or(group);
            let case = of_group(group, (Role::Tested, name));
            let cases: Vec<&Case> = group.cases.iter().collect();
            let lacks = match cases.iter().find_map(|case| engine.lacks_for(case)) {
                _ if group.id == cross_code::RECORDED => {
                    Some("nobody has promised YADE's bits for an external engine".to_owned())
                }
                parts => parts.map(|parts| format!("{name} has no {parts}")),
            };
            if let Some(reason) = lacks {
                results.push(case.skipped(&reason, true));
                continue;
            }
            let work = work_folder().map_err(ProgramError::File)?;
            let run = engine.run_cases(&cases, work.path());
            results.push(match run {
                Ok(run) => match run.into_iter().collect::<Result<Vec<Track>, String>>() {
                    Ok(tracks) => {
                        let checks = group.judge(&tracks).into_iter();
                        let checks = checks.map(|check| of_precision_of(check, resolution));
                        case.judged(Ok(by_its_rules(
                            checks.collect(),
                            group,
                            &tracks,
                            engine.rules(),
                        )))
                    }
                    Err(reason) => case.skipped(&format!("{name} refused: {reason}"), false),
                },
                Err(EngineError::Program(error)) if error.is_no_fault_of_it() => {
                    return Err(error.into());
                }
                Err(error) if error.is_interruption() => return Err(error),
                Err(error) => case.judged(Err(error.to_string())),
            });
        }
        Ok(results)
    }
}

/// How many times as much as the suite allows rounding may make of an engine's numbers: of one in double precision that keeps its
/// places otherwise than the suite counts on, such as from another origin; and of one in single precision.
const DOUBLE_SLACK: f64 = 1.0e3;
const SINGLE_SLACK: f64 = (1u64 << 29) as f64;

/// A number off by more than the suite allows, and by no more than rounding may make of it, decides nothing.
fn of_precision_of(mut check: Check, engine: Resolution) -> Check {
    let limits = (check.value, check.expected, check.upper);
    let (Outcome::Fail, (Some(value), Some(expected), Some(upper))) = (check.outcome, limits)
    else {
        return check;
    };
    let slack = if engine.is_double() {
        DOUBLE_SLACK
    } else {
        SINGLE_SLACK
    };
    if (value - expected).abs() <= slack * (upper - expected) {
        (check.outcome, check.required) = (Outcome::Skipped, true);
        check.found = format!("off by what rounding in {} may make of it", engine.name());
    }
    check
}

/// Checks by closed forms of the usual rules that an engine of other rules does not hold: where it does what the model does under its
/// own, they are known not to hold, and no fault.
fn by_its_rules(
    mut checks: Vec<Check>,
    group: &CaseGroup,
    tracks: &[Track],
    rules: Rules,
) -> Vec<Check> {
    let has_failed = |check: &&mut Check| check.outcome == Outcome::Fail;
    if checks.iter().any(|check| check.outcome == Outcome::Fail)
        && !rules.are_usual()
        && exact::follow_rules(&group.cases, tracks, rules)
    {
        let names: Vec<String> = rules.unusual().map(Choice::name).collect();
        for check in checks.iter_mut().filter(has_failed) {
            check.outcome = Outcome::ExpectedFailure;
            check.found = format!(
                "as the model under the rules that the engine declares: {}",
                names.join(", ")
            );
        }
    }
    checks
}

/// What YADE lacks for a group, if anything.
fn not_in_yade(group: &CaseGroup) -> Option<String> {
    let mut cases = group.cases.iter();
    cases.find_map(|case| unsupported(&case.model))
}

/// The tracks of cases in the native engine, or why there are none.
pub fn native_tracks(cases: &[Case], options: &CaseOptions) -> Result<Vec<Track>, String> {
    let run = |case: &Case| {
        let track = run_case(case, *options);
        track.map_err(|error| format!("{}: {error}", case.name))
    };
    cases.iter().map(run).collect()
}

pub fn verify(options: &Options, display: &Display) -> Result<Verification, EngineError> {
    let both = options.native && options.yade.is_some();
    // Trajectories are for comparing, and their beds have to be poured first.
    let suite = Suite::new(if both { options.grains } else { 0 }, Rules::default());
    let mut cases = Vec::new();
    if options.native {
        let task = display.task("cases, native");
        cases.extend(suite.run_native());
        task.done("done");
    }
    let (mut errors, mut precisions) = (Vec::new(), None);
    let mut in_yade = RunInYade::default();
    let role = if both { Role::Reference } else { Role::Tested };
    if let Some(yade) = &options.yade {
        let task = display.task("all cases in YADE");
        match suite.run_yade(role, yade, &mut StageObserver(&task)) {
            Ok(run) => {
                task.done("done");
                in_yade = run;
                cases.append(&mut in_yade.groups);
            }
            Err(EngineError::Program(error @ ProgramError::Missing { .. })) => {
                task.done("YADE is missing");
                cases.extend(suite.without_yade(&error.to_string(), role));
            }
            Err(error) => return Err(error),
        }
    }
    let RunInYade { cross, answers, .. } = &in_yade;
    if let Some(yade) = &options.yade
        && both
        && in_yade.version.is_some()
    {
        let found = parameters::checks(answers, None).map_err(|error| error.to_string());
        cases.push(of_parameters().judged(found));
        cases.extend(suite.compare(cross));
        let task = display.task("rounding errors");
        let case = parameters::precision_case(options.grains);
        cases.push(match parameters::run_precisions(case, yade) {
            Ok(measured) => {
                task.done("done");
                errors = measured.errors(None)?;
                precisions = Some(measured);
                of_precision().judged(Ok(parameters::precision_checks(&errors)))
            }
            Err(error @ ProgramError::Missing { .. }) => {
                task.done("this YADE has no build of that precision");
                of_precision().skipped(&error.to_string(), false)
            }
            Err(error @ (ProgramError::Interrupted | ProgramError::File(_))) => {
                return Err(error.into());
            }
            // What the other cases have shown is not lost with it.
            Err(error) => {
                task.done("a build of YADE failed");
                of_precision().judged(Err(error.to_string()))
            }
        });
    }
    let limits = options.detection_limits.then(|| {
        let task = display.task("detection limits");
        let precisions = precisions.as_ref();
        let limits = limits(&suite, cross, answers, precisions, &|done, all| {
            task.share(done as f64 / all as f64, &format!("{done} of {all} cases"));
        });
        task.done("done");
        limits
    });
    if let Some(limits) = &limits {
        let title = "Every fault is detected, every case can fail, none has false positives";
        let by = (Role::Suite, "none");
        let case = case("detection-limits", title, Evidence::Detection, by);
        cases.push(case.judged(Ok(limits.checks())));
    }
    Ok(Verification {
        yade: in_yade.version,
        errors,
        limits,
        ..Verification::new(&options.command, cases)
    })
}

/// The suite in one engine. `beds`: from which its first steps are judged beside the cases.
pub fn verify_in(
    engine: &dyn Engine,
    beds: &Beds,
    command: &str,
    display: &Display,
) -> Result<Verification, EngineError> {
    let described = engine.describe()?;
    let name = &described.name;
    // Small cases do not show what is wrong in a bed alone.
    let first_steps = match described.has(Part::Cases) {
        true => {
            let task = display.task(&format!("a bed in {name}"));
            let mut progress = |text: &str| task.share(0.0, text);
            let found = first_steps::first_steps(engine, beds, &mut progress)?;
            task.done("done");
            Some(found)
        }
        false => None,
    };
    let measured = first_steps.as_ref().map(|judgement| judgement.resolution);
    let resolution = measured.unwrap_or(Resolution::DOUBLE);
    let task = display.task(&format!("cases in {name}"));
    let cases = Suite::new(0, engine.rules()).run_in(engine, name, resolution, &|done, all| {
        task.share(done as f64 / all as f64, &format!("{done} of {all} cases"));
    })?;
    task.done("done");
    Ok(Verification {
        exec: Some(described),
        first_steps,
        ..Verification::new(command, cases)
    })
}

impl Verification {
    pub fn document(&self) -> Document {
        let live = |version| format!(" YADE {version} ran live.");
        let mut yade = self.yade.as_ref().map_or(String::new(), live);
        if let Some(judgement) = &self.first_steps {
            let (verdict, said) = (judgement.verdict(), first_steps::answer(judgement));
            yade += &format!(" From a bed: {}", first_steps::with_verdict(verdict, &said));
        }
        Document {
            title: "Verification suite: every contact law against what is known of it".to_owned(),
            verdict: self.verdict(),
            answer: format!("{}.{yade}", self.tally),
            sections: self.sections(),
            checks: self.checks(),
        }
    }

    /// The sections, of this document and of the main job's.
    pub fn sections(&self) -> Vec<Section> {
        let mut sections = vec![self.cases()];
        sections.extend(self.engine());
        sections.extend(self.limits.as_ref().map(detection));
        if !self.errors.is_empty() {
            let answer = "Native and YADE round alike; 11 more bits make the error smaller by about 2¹¹, so it is rounding and nothing else.";
            sections.push(Section::new("Rounding", answer).with(errors(&self.errors)));
        }
        sections.extend(self.first_steps.iter().flat_map(first_steps::sections));
        sections.push(inside_a_disc(&self.disc));
        sections
    }

    /// A row a case, in the order in which they were first run, with an outcome for each part that an engine had.
    fn cases(&self) -> Section {
        let mut answer = "Each case is a small experiment whose outcome is known. All engines run the same cases and are judged by \
                          the same code."
            .to_owned();
        if self.cases.iter().any(|case| case.role == Role::Reference) {
            answer += " The reference is YADE; cross-code holds its numbers against native's.";
        }
        let missing = |case: &&CaseResult| case.outcome == Outcome::Skipped && !case.inapplicable;
        if let Some(case) = self.cases.iter().find(missing) {
            answer += &format!(" Skipped: {}", case.reason);
        }
        let mut cases: Vec<&CaseResult> = self.cases.iter().collect();
        let mut seen = BTreeSet::new();
        cases.retain(|case| seen.insert(&case.id));
        let by = |case: &CaseResult, role: Role| {
            let mut all = self.cases.iter();
            let own = all.find(|result| result.id == case.id && result.role == role)?;
            Some(own.outcome)
        };
        // What is missing for many is said once, above.
        let reasons = |case: &CaseResult| {
            let own = self.cases.iter().filter(|result| result.id == case.id);
            let own =
                own.filter(|result| result.inapplicable || result.outcome != Outcome::Skipped);
            let reasons: Vec<&str> = own.map(|result| result.reason.as_str()).collect();
            reasons.join(" ")
        };
        let table = Table::of("cases", "Cases", cases)
            .column("case", |case| Cell::Code(case.id.clone()))
            .column("tested", |case| by(case, Role::Tested))
            .column("reference", |case| by(case, Role::Reference))
            .column("cross-code", |case| {
                by(case, Role::CrossCode).or(by(case, Role::Suite))
            })
            .column("what it shows", |case| &case.title)
            .column("why", reasons);
        Section::new("Cases", answer).with(table)
    }

    fn engine(&self) -> Option<Section> {
        let engine = self.exec.as_ref()?;
        let section = Section::new("The engine", format!("{} ran the suite.", engine.label()));
        Some(section.with_all(engine.approximations.clone()))
    }
}

fn inside_a_disc(figures: &DiscFigures) -> Section {
    let square = "field averaged over the control square of side R at the centre";
    let stresses = [
        ("Σ/V of the contact forces", figures.contact),
        ("field averaged over the disc, by quadrature", figures.disc),
        (square, figures.square),
        ("Σ over the cell of side 2R: Table 3", figures.cell),
    ];
    let title = "Stresses of Figure 4's disc, tension positive";
    let table = Table::of("disc", title, &stresses)
        .column("stress", |(name, _)| *name)
        .column("σ_xx, Pa", |(_, stress)| stress[0])
        .column("σ_zz, Pa", |(_, stress)| stress[1])
        .column("σ_xz, Pa", |(_, stress)| stress[2]);
    Section::new(
        "Inside a grain: the disc of Figure 4",
        "The paper computes a grain's stress from its contact forces and gives it to control volumes around it (section 3.3, \
         second bullet). The elastic field inside the disc, in closed form, averages to Σ/V over the grain, as it must. Over \
         the square at the centre it does not: the middle of a disc bears more of the vertical stress than its rim, and the \
         voids outside bear none. Giving the grain's Σ to a control square in proportion to its volume is a convention, not \
         the stress in that square.",
    )
    .with(table)
}

fn detection(limits: &Limits) -> Section {
    let cell = |limit: &Limit| match limit {
        Limit::Unaffected => Cell::Missing,
        Limit::NotDetected => "not detected".into(),
        Limit::Detected => "detected".into(),
        Limit::From { size } => Cell::Number(*size),
    };
    let title = "Smallest relative size detected";
    let table = Table::of("detection-limits", title, &limits.cases)
        .column("case", |row| Cell::Code(row.case.clone()));
    let faults = limits.faults.iter().enumerate();
    let table = faults.fold(table, |table, (at, fault)| {
        table.column(fault, |row| row.limits.get(at).map(cell))
    });
    let table = table
        .column("false positives", |row| {
            format!("{} of {}", row.false_positives, row.sound_runs)
        })
        .column("varied", |row| match row.varied {
            Varied::Starts => "last bits at the start",
            Varied::Stiffness => "stiffness",
            Varied::Lists => "neighbour lists",
        });
    Section::new(
        "Detection limits",
        "For each deliberate fault the smallest relative size at which each case fails, found by halving. No value: the fault changes \
         nothing in the case. False positives are runs that fail where nothing is wrong but what is varied differs. A symmetry \
         detects faults that its two sides do not share; every fault here keeps action equal to reaction.",
    )
    .with(table)
}

/// How rounding errors grow in each precision.
fn errors(errors: &[Errors]) -> Plot {
    let points = |value: fn(&Errors) -> f64| -> Vec<[f64; 2]> {
        let points = errors
            .iter()
            .map(|errors| [errors.step as f64, value(errors)]);
        points.filter(|[_, error]| *error > 0.0).collect()
    };
    let yade = points(|errors| errors.yade).into_iter();
    Plot::new(
        "rounding",
        "Distance from the same run in 128-bit arithmetic. It grows while grains collide, until neighbours are no longer the same.",
        Axis::linear("step of pouring"),
        Axis::logarithmic("largest error over R"),
    )
    .line("native", Colour::Blue, points(|errors| errors.native))
    .points("YADE, double", Colour::Vermilion, yade.map(|[x, y]| Point::at(x, y)))
    .line("YADE, long double", Colour::Green, points(|errors| errors.long_double))
}
