//! Running the suite: every case in every engine that is asked for.

use serde::Serialize;

use super::cross_code::{self, CrossCase, InYade};
use super::detection::{FromYade, Limits, limits};
use super::parameters::{self, Answer, Errors, Precisions};
use super::{CaseGroup, Evidence, Track, outcome};
use crate::checks::{Check, Outcome, verdict};
use crate::engine::ProgramError;
use crate::engine::exec::{self, Description};
use crate::engine::yade::{self, run_cases, unsupported};
use crate::files::work_folder;
use crate::paper::disc_field::{DiscField, DiscFieldError, figure_4};
use crate::progress::{Display, StageObserver};
use crate::run::EngineError;
use grains::native::{CaseOptions, loads, run_case};
use grains::task::{Case, Observer};

/// The suite could not be run.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error("the stresses in Figure 4's disc cannot be computed: {0}")]
    Disc(#[from] DiscFieldError),
}

impl From<ProgramError> for VerifyError {
    fn from(error: ProgramError) -> Self {
        VerifyError::Engine(error.into())
    }
}

/// Which engines run the suite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Engines {
    /// Our own.
    Native,
    /// YADE alone.
    Yade,
    /// Both, and one against the other.
    Both,
}

impl Engines {
    /// On the command line.
    pub fn name(self) -> &'static str {
        match self {
            Engines::Native => "native",
            Engines::Yade => "yade",
            Engines::Both => "both",
        }
    }
}

/// What is to be verified, and how.
#[derive(Debug, Clone)]
pub struct Options {
    /// Which engines run the suite.
    pub engine: Engines,
    /// Trajectories and rounding errors of so many grains at most.
    pub grains: u32,
    /// Whether detection limits are measured.
    pub detection_limits: bool,
    /// How YADE is started.
    pub yade: yade::Options,
    /// The command as it was given.
    pub command: String,
}

/// What part an engine has in a case; ids of checks have it in place of the engine's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// It is verified.
    Tested,
    /// It is what another one is compared with, and runs the same cases.
    Reference,
    /// Two engines are compared.
    CrossCode,
    /// The suite itself is tested.
    Suite,
}

impl Role {
    fn id(self) -> &'static str {
        match self {
            Role::Tested => "tested",
            Role::Reference => "reference",
            Role::CrossCode => "cross-code",
            Role::Suite => "suite",
        }
    }
}

/// One case in one engine, or in two.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseResult {
    /// Of the case.
    pub id: String,
    /// What it shows.
    pub title: String,
    /// What kind of evidence it gives.
    pub evidence: Evidence,
    /// What part the engine has.
    pub role: Role,
    /// Which engines it is about, for people.
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
                self.outcome = outcome(&checks);
                let of = |check: Check| Check {
                    id: format!("{prefix}/{}", check.id),
                    method: self.title.clone(),
                    ..check
                };
                self.checks = checks.into_iter().map(of).collect();
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
            let check = Check::of_words(id, &self.title, self.outcome, &self.reason);
            self.checks.push(Check {
                required: !self.inapplicable,
                ..check
            });
        }
        self
    }

    fn check_id(&self) -> String {
        format!("verify/{}/{}", self.role.id(), self.id)
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

fn of_cross(of: &CrossCase) -> CaseResult {
    case(&of.id, &of.title, Evidence::CrossCode, TOGETHER)
}

fn of_parameters() -> CaseResult {
    let title = "Both engines use the same parameters";
    case("parameters", title, Evidence::CrossCode, TOGETHER)
}

fn of_precision() -> CaseResult {
    let title = "Rounding errors of both engines against 128-bit arithmetic";
    case("precision", title, Evidence::Precision, TOGETHER)
}

/// How many cases, by outcome.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    pub passed: usize,
    pub failed: usize,
    /// Cases that could not be run.
    pub skipped: usize,
    /// Cases that an engine has no option for.
    pub inapplicable: usize,
}

impl Tally {
    fn of(cases: &[CaseResult]) -> Self {
        let mut tally = Tally::default();
        for case in cases {
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
        let Tally {
            passed,
            failed,
            skipped,
            inapplicable,
        } = self;
        write!(
            out,
            "{passed} cases passed, {failed} failed, {skipped} skipped, {inapplicable} of options that the engine does not have"
        )
    }
}

/// A verification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verification {
    /// Version of crossgrain.
    pub crossgrain: String,
    /// The command as it was given.
    pub command: String,
    /// YADE's version, if it ran.
    pub yade: Option<String>,
    /// What an external engine says of itself, if one ran the suite.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exec: Option<Description>,
    /// Every case in every engine.
    pub cases: Vec<CaseResult>,
    /// Rounding errors, if they were measured.
    pub errors: Vec<Errors>,
    /// The stress inside Figure 4's disc.
    pub disc: DiscFigures,
    /// Detection limits, if they were asked for.
    pub limits: Option<Limits>,
    /// How many cases, by outcome.
    pub tally: Tally,
}

impl Verification {
    fn new(command: &str, cases: Vec<CaseResult>) -> Result<Self, VerifyError> {
        let disc = figure_4().and_then(|field| DiscFigures::of(&field));
        let tally = Tally::of(&cases);
        Ok(Verification {
            crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
            command: command.to_owned(),
            yade: None,
            exec: None,
            cases,
            errors: Vec::new(),
            disc: disc?,
            limits: None,
            tally,
        })
    }

    /// What the checks come to.
    pub fn verdict(&self) -> Outcome {
        verdict(self.cases.iter().flat_map(|case| &case.checks))
    }

    /// Every check of every case.
    pub fn checks(&self) -> Vec<Check> {
        let checks = self.cases.iter().flat_map(|case| &case.checks);
        checks.cloned().collect()
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
    fn of(field: &DiscField) -> Result<Self, DiscFieldError> {
        let parts = |of: [[f64; 2]; 2]| [of[0][0], of[1][1], of[0][1]];
        Ok(DiscFigures {
            contact: parts(field.contact_average()),
            disc: parts(field.average_over_disc()),
            square: parts(field.average_over_square(field.radius())?),
            cell: parts(field.average_over_cell(2.0 * field.radius())),
        })
    }
}

/// All cases.
pub struct Suite {
    /// Those that one engine can run alone.
    pub groups: Vec<CaseGroup>,
    /// Those that take two.
    pub cross: Vec<CrossCase>,
}

/// What YADE made of the suite.
struct RunInYade {
    version: String,
    /// The tracks of the groups that YADE can run, in order.
    tracks: std::vec::IntoIter<Track>,
    /// What it says of the scenes' parameters.
    answers: Vec<Answer>,
    /// What it made of the cross-code cases.
    cross: Vec<InYade>,
}

impl Suite {
    /// The suite with trajectories of so many grains at most.
    pub fn new(most_grains: u32) -> Self {
        let mut cross = cross_code::static_states();
        cross.extend(cross_code::cases(most_grains));
        Suite {
            groups: super::groups(),
            cross,
        }
    }

    /// Every group in the native engine.
    pub fn run_native(&self) -> Vec<CaseResult> {
        let sound = CaseOptions::default();
        let run = |group: &CaseGroup| {
            let tracks = native_tracks(&group.cases, &sound);
            of_group(group, (Role::Tested, "native")).judged(tracks.map(|of| group.judge(&of)))
        };
        self.groups.iter().map(run).collect()
    }

    /// All cases in one process of YADE, and the parameters of the scenes.
    fn run_yade(
        &self,
        options: &yade::Options,
        observer: &mut dyn Observer,
    ) -> Result<RunInYade, EngineError> {
        let scenes = parameters::scenes().map(|(name, scene)| (name, parameters::probe(&scene)));
        let can = |group: &&CaseGroup| not_in_yade(group).is_none();
        let alone = self.groups.iter().filter(can).flat_map(|of| &of.cases);
        let mut cases: Vec<&Case> = scenes.iter().map(|(_, probe)| probe).chain(alone).collect();
        let alone = cases.len() - scenes.len();
        cases.extend(self.cross.iter().map(|of| &of.case));
        let work = work_folder().map_err(ProgramError::File)?;
        let run = run_cases(&cases, options, work.path(), observer)?;
        let mut rest = run.cases.into_iter();
        let answer = |((name, probe), of): (&(&'static str, Case), yade::CaseInYade)| Answer {
            name,
            probe: probe.clone(),
            yade: of.effective,
        };
        let answers = scenes.iter().zip(rest.by_ref()).map(answer).collect();
        let tracks: Vec<Track> = rest.by_ref().take(alone).map(|of| of.track).collect();
        let cross = rest.map(|of| InYade {
            track: of.track,
            loads: of.loads,
        });
        Ok(RunInYade {
            version: run.version,
            tracks: tracks.into_iter(),
            answers,
            cross: cross.collect(),
        })
    }

    /// The groups from the tracks that YADE made of them.
    fn of_yade(&self, mut tracks: std::vec::IntoIter<Track>, role: Role) -> Vec<CaseResult> {
        let judge = |group: &CaseGroup| {
            let case = of_group(group, (role, "YADE"));
            match not_in_yade(group) {
                Some(reason) => case.skipped(&format!("YADE has no {reason}"), true),
                None => {
                    let own: Vec<Track> = tracks.by_ref().take(group.cases.len()).collect();
                    case.judged(Ok(group.judge(&own)))
                }
            }
        };
        self.groups.iter().map(judge).collect()
    }

    /// Native against what YADE made of the cross-code cases.
    fn compare(&self, in_yade: &[InYade]) -> Vec<CaseResult> {
        let compare = |(of, yade): (&CrossCase, &InYade)| {
            let native = run_case(&of.case, None).and_then(|track| match yade.loads[..] {
                [] => Ok((track, Vec::new())),
                _ => Ok((track, loads(&of.case, None)?)),
            });
            let found = native.map(|(track, loads)| cross_code::judge(of, &track, &loads, yade));
            of_cross(of).judged(found.map_err(|error| error.to_string()))
        };
        self.cross.iter().zip(in_yade).map(compare).collect()
    }

    /// All cases that need YADE, as skipped.
    fn without_yade(&self, reason: &str, role: Role) -> Vec<CaseResult> {
        let groups = self.groups.iter().map(|of| of_group(of, (role, "YADE")));
        let cross = self.cross.iter().map(of_cross);
        groups
            .chain([of_parameters()])
            .chain(cross)
            .chain([of_precision()])
            .map(|case| case.skipped(reason, false))
            .collect()
    }

    /// Every group in an external engine, each in a start of its own: what breaks one leaves the others.
    fn run_exec(
        &self,
        engine: &Description,
        options: &exec::Options,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Vec<CaseResult>, ProgramError> {
        let name = engine.name.as_str();
        let mut results = Vec::with_capacity(self.groups.len());
        for (index, group) in self.groups.iter().enumerate() {
            progress(index, self.groups.len());
            let case = of_group(group, (Role::Tested, name));
            let cases: Vec<&Case> = group.cases.iter().collect();
            let missing = cases
                .iter()
                .flat_map(|case| exec::missing_for_case(engine, case))
                .next();
            if group.id == cross_code::RECORDED {
                let reason = "nobody has promised YADE's bits for an external engine";
                results.push(case.skipped(reason, true));
                continue;
            }
            if let Some(part) = missing {
                results.push(case.skipped(&format!("{name} has no {}", part.in_words()), true));
                continue;
            }
            let work = work_folder()?;
            let run = exec::run_cases(&cases, engine, options, work.path(), &mut ());
            results.push(match run {
                Ok(run) => match run.into_iter().collect::<Result<Vec<Track>, String>>() {
                    Ok(tracks) => case.judged(Ok(group.judge(&tracks))),
                    Err(reason) => case.skipped(&format!("{name} refused: {reason}"), false),
                },
                Err(
                    error @ (ProgramError::NotStarted { .. }
                    | ProgramError::Interrupted
                    | ProgramError::File(_)),
                ) => return Err(error),
                Err(error) => case.judged(Err(error.to_string())),
            });
        }
        Ok(results)
    }
}

/// What YADE lacks for a group, if anything.
fn not_in_yade(group: &CaseGroup) -> Option<String> {
    let lacks = |case: &Case| unsupported(&case.model).map(|what| what.to_string());
    group.cases.iter().find_map(lacks)
}

/// The tracks of cases in the native engine, or why there are none.
pub fn native_tracks(cases: &[Case], options: &CaseOptions) -> Result<Vec<Track>, String> {
    let run = |case: &Case| {
        let track = run_case(case, *options);
        track.map_err(|error| format!("{}: {error}", case.name))
    };
    cases.iter().map(run).collect()
}

/// Runs the suite as asked.
pub fn verify(options: &Options, display: &Display) -> Result<Verification, VerifyError> {
    let both = options.engine == Engines::Both;
    // Trajectories are for comparing, and their beds have to be poured first.
    let suite = Suite::new(if both { options.grains } else { 0 });
    let mut cases = Vec::new();
    if options.engine != Engines::Yade {
        let task = display.task("cases, native");
        cases.extend(suite.run_native());
        task.done("done");
    }
    let (mut errors, mut precisions, mut version) = (Vec::new(), None, None);
    let (mut cross, mut answers) = (Vec::new(), Vec::new());
    let role = if both { Role::Reference } else { Role::Tested };
    if options.engine != Engines::Native {
        match in_yade(&suite, options, display)? {
            Err(reason) => cases.extend(suite.without_yade(&reason, role)),
            Ok(run) => {
                cases.extend(suite.of_yade(run.tracks, role));
                (version, answers, cross) = (Some(run.version), run.answers, run.cross);
            }
        }
    }
    if both && version.is_some() {
        let found = parameters::checks(&answers, None).map_err(|error| error.to_string());
        cases.push(of_parameters().judged(found));
        cases.extend(suite.compare(&cross));
        cases.push(match precisions_in_yade(options, display)? {
            Ok(measured) => {
                errors = measured.errors(None).map_err(EngineError::from)?;
                precisions = Some(measured);
                of_precision().judged(Ok(parameters::precision_checks(&errors)))
            }
            Err(case) => case,
        });
    }
    let limits = options.detection_limits.then(|| {
        let task = display.task("detection limits");
        let from_yade = FromYade {
            cross: &cross,
            answers: &answers,
            precisions: precisions.as_ref(),
        };
        let limits = limits(&suite, from_yade, &|done, all| {
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
        yade: version,
        errors,
        limits,
        ..Verification::new(&options.command, cases)?
    })
}

/// Runs the suite in an external engine.
pub fn verify_exec(
    options: &exec::Options,
    command: &str,
    display: &Display,
) -> Result<Verification, VerifyError> {
    let engine = exec::describe(options)?;
    let task = display.task(&format!("cases in {}", engine.name));
    let cases = Suite::new(0).run_exec(&engine, options, &|done, all| {
        task.share(done as f64 / all as f64, &format!("{done} of {all} cases"));
    })?;
    task.done("done");
    let mut found = Verification::new(command, cases)?;
    found.exec = Some(engine);
    Ok(found)
}

/// What YADE made of the suite; the inner error says why there is no YADE.
fn in_yade(
    suite: &Suite,
    options: &Options,
    display: &Display,
) -> Result<Result<RunInYade, String>, VerifyError> {
    let task = display.task("all cases in YADE");
    match suite.run_yade(&options.yade, &mut StageObserver::new(&task)) {
        Ok(run) => {
            task.done("done");
            Ok(Ok(run))
        }
        Err(EngineError::Program(error @ ProgramError::Missing { .. })) => {
            task.done("YADE is missing");
            Ok(Err(error.to_string()))
        }
        Err(error) => Err(error.into()),
    }
}

/// Rounding errors in every precision; the inner error is the case that could not be judged.
fn precisions_in_yade(
    options: &Options,
    display: &Display,
) -> Result<Result<Precisions, CaseResult>, VerifyError> {
    let task = display.task("rounding errors");
    match parameters::run_precisions(parameters::precision_case(options.grains), &options.yade) {
        Ok(precisions) => {
            task.done("done");
            Ok(Ok(precisions))
        }
        Err(error @ ProgramError::Missing { .. }) => {
            task.done("this YADE has no build of that precision");
            Ok(Err(of_precision().skipped(&error.to_string(), false)))
        }
        Err(error @ (ProgramError::Interrupted | ProgramError::File(_))) => Err(error.into()),
        // What the other cases have shown is not lost with it.
        Err(error) => {
            task.done("a build of YADE failed");
            Ok(Err(of_precision().judged(Err(error.to_string()))))
        }
    }
}
