//! The main job: the paper's experiment in the native engine and in YADE, recorded and live, compared.

pub mod beside;
mod document;
mod live;
pub mod record;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::checks::{Outcome, verdict};
use crate::compare::first_difference::Locator;
use crate::compare::{Comparison, compare};
use crate::engine::yade;
use crate::error::Error;
use crate::files::work_folder;
use crate::progress::Display;
use crate::run::folder::record::{EngineRecord, Protocol};
use crate::run::folder::{RECORDED, RunFolder, is_recorded, unpack_recorded};
use crate::run::{Engine, EngineError, recorded, to_folder};
use crate::suite::parameters::{self, ParameterPair};
use crate::suite::run::{Engines, Verification, verify};
use crate::{paper, suite};
use beside::Beside;
use grains::generate::initial_bodies;
use grains::model::Model;
use grains::native;
use grains::native::perturb::{Quantity, Switch};
use grains::native::{Perturbation, Trouble};
use grains::scene::Scene;
use grains::tables::StopReason;
use record::{
    FaultCheck, NamedComparison, REPRODUCTION_VERSION, Reproduction, RunSummary, Skipped,
};
use verdict::judge::Verdict;

/// Grains of the longest trajectories of the suite in this job; `crossgrain verify` has all.
const SUITE_GRAINS: u32 = 500;

/// What is to be reproduced, and where to.
#[derive(Debug, Clone)]
pub struct Options {
    /// The folder that everything goes into.
    pub out: PathBuf,
    /// What is run.
    pub scene: Scene,
    /// Further realizations in YADE's sorted mode.
    pub full: bool,
    /// Whether the verification suite is run too.
    pub suite: bool,
    /// YADE is not started; its recorded run stands for it.
    pub recorded: bool,
    /// How YADE is started.
    pub yade: yade::Options,
    /// A fault in the native engine, to see that the whole job would notice.
    pub fault: Option<Perturbation>,
    /// Records of other jobs that stand on the page, which the job's own record names.
    pub beside: Beside,
    /// The command as it was given.
    pub command: String,
}

impl Options {
    fn native(&self) -> Engine {
        Engine::Native(native::Options {
            perturbation: self.fault,
            ..native::Options::default()
        })
    }
}

/// The runs that the page draws.
#[derive(Debug)]
pub struct Runs {
    /// The native run.
    pub native: RunFolder,
    /// YADE in sorted mode: live if there is one, else recorded.
    pub yade: Option<RunFolder>,
}

/// Does the whole job; runs that `out` already holds are taken over.
pub fn reproduce(options: &Options, display: &Display) -> Result<(Reproduction, Runs), Error> {
    let began = Instant::now();
    let mut job = Job {
        options,
        display,
        comparisons: Vec::new(),
        skipped: Vec::new(),
        runs: Vec::new(),
        facts: Vec::new(),
    };
    job.compare_facts()?;
    let native = job.run(&options.scene, "native", &options.native())?;
    let recorded = job.recorded()?;
    if let Some(recorded) = &recorded {
        job.compare(
            "compare/sorted-recorded",
            "native against YADE's sorted loop, recorded",
            &["native", RECORDED],
            compare(&native, recorded, Some(&job.locator())),
        );
    }
    let live::Live {
        sorted,
        first_steps,
        faults,
        suite,
    } = job.live(&native)?;
    if native.record.stop() == Some(StopReason::MaxSteps) {
        let why = "the bed did not settle within /settle/max_steps";
        job.skipped("run/loading", "loading", why).required = true;
    }
    let of_native = native.record.seconds_per_step();
    for run in job.runs.iter_mut().filter(|run| run.folder != RECORDED) {
        run.times_native = Some(run.microseconds_per_step / (1e6 * of_native));
    }
    let version = sorted.as_ref().map(|run| run.record.engine.version());
    let mut reproduction = Reproduction {
        version: REPRODUCTION_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command: options.command.clone(),
        scene_digest: options.scene.digest(),
        yade: version.map(str::to_owned),
        verdict: Outcome::Skipped,
        comparisons: job.comparisons,
        first_steps,
        faults,
        facts: job.facts,
        suite,
        skipped: job.skipped,
        claims: record::claims(&native),
        numbers: paper::numbers(),
        text_faults: paper::text_faults(),
        beside: options.beside.stated(),
        runs: job.runs,
        seconds: began.elapsed().as_secs_f64(),
    };
    reproduction.verdict = verdict(&reproduction.checks());
    let runs = Runs {
        native,
        yade: sorted.or(recorded),
    };
    Ok((reproduction, runs))
}

struct Job<'a> {
    options: &'a Options,
    display: &'a Display,
    comparisons: Vec<NamedComparison>,
    skipped: Vec<Skipped>,
    runs: Vec<RunSummary>,
    facts: Vec<ParameterPair>,
}

impl Job<'_> {
    fn run(&mut self, scene: &Scene, name: &str, engine: &Engine) -> Result<RunFolder, Error> {
        let run = run_or_take_over(self.options, self.display, scene, name, engine)?;
        self.runs.push(RunSummary::of(name, &run));
        Ok(run)
    }

    fn compare(&mut self, id: &str, title: &str, folders: &[&str], comparison: Comparison) {
        self.comparisons.push(NamedComparison {
            id: id.to_owned(),
            title: title.to_owned(),
            folders: folders.iter().map(|name| (*name).to_owned()).collect(),
            comparison,
        });
    }

    fn skipped(&mut self, id: &str, what: &str, why: &str) -> &mut Skipped {
        self.skipped.push(Skipped {
            id: id.to_owned(),
            what: what.to_owned(),
            why: why.to_owned(),
            required: false,
        });
        let last = self.skipped.len() - 1;
        &mut self.skipped[last]
    }

    fn locator(&self) -> Locator {
        Locator {
            yade: self.options.yade.clone(),
            programs: Vec::new(),
        }
    }

    /// The recorded run of YADE, if it is one of this scene.
    fn recorded(&mut self) -> Result<Option<RunFolder>, Error> {
        let folder = self.options.out.join(RECORDED);
        if !folder.exists() {
            unpack_recorded(&folder)?;
        } else if !is_recorded(&folder) {
            return Err(Error::Usage(format!(
                "{} is not the recorded run; remove it, or name another folder with --out",
                folder.display()
            )));
        }
        let recorded = RunFolder::read(&folder)?;
        if recorded.record.scene_digest != self.options.scene.digest() {
            self.skipped(
                "compare/sorted-recorded",
                "native against YADE's sorted loop, recorded",
                "the recorded run is of the paper's scene, this is another",
            );
            return Ok(None);
        }
        self.runs.push(RunSummary::of(RECORDED, &recorded));
        Ok(Some(recorded))
    }

    /// Why YADE does not run live.
    fn without_yade(&self) -> Option<String> {
        if self.options.recorded {
            return Some("--recorded leaves it out".to_owned());
        }
        let missing = yade::find(self.options.yade.program.as_deref()).err();
        let unsupported = yade::unsupported(&Model::of(&self.options.scene));
        let unsupported = unsupported.map(|reason| format!("YADE has no {reason}"));
        missing.map(|error| error.to_string()).or(unsupported)
    }

    /// What both engines say that they use, before anything is run; nothing without a YADE for this scene.
    fn compare_facts(&mut self) -> Result<(), Error> {
        if self.without_yade().is_some() {
            return Ok(());
        }
        let (scene, work) = (&self.options.scene, work_folder()?);
        let native = parameters::of_native(scene)?;
        let in_yade = parameters::of_yade(scene, &self.options.yade, work.path())?;
        self.facts = parameters::side_by_side(native, &in_yade);
        Ok(())
    }

    /// What of the verification suite is skipped.
    fn skipped_of_suite(&mut self) {
        let (id, what, why) = if self.options.suite {
            (
                "verify/5000-grains",
                "trajectories and rounding errors of 5,000 grains",
                "crossgrain verify makes them; here up to 500 grains",
            )
        } else {
            (
                "verify/all",
                "the verification suite",
                "made with the paper's scene only; crossgrain verify makes it alone",
            )
        };
        self.skipped(id, what, why);
    }
}

/// The verification suite with its detection limits, if it is asked for.
fn suite(
    options: &Options,
    engine: Engines,
    display: &Display,
) -> Result<Option<Verification>, Error> {
    if !options.suite {
        return Ok(None);
    }
    let options = suite::run::Options {
        engine,
        grains: SUITE_GRAINS,
        detection_limits: true,
        yade: options.yade.clone(),
        command: format!("crossgrain verify --detection-limits --grains {SUITE_GRAINS}"),
    };
    Ok(Some(verify(&options, display)?))
}

/// Runs, or reads the folder that an earlier, interrupted job has left.
fn run_or_take_over(
    options: &Options,
    display: &Display,
    scene: &Scene,
    name: &str,
    engine: &Engine,
) -> Result<RunFolder, Error> {
    let folder = options.out.join(name);
    if !folder.exists() {
        return Ok(to_folder(scene, engine, Protocol::Whole, &folder, display)?);
    }
    let run = RunFolder::read(&folder)?;
    let mut same = run.record.scene_digest == scene.digest()
        && run.record.command == crate::run::command(engine, Protocol::Whole);
    match &run.record.engine {
        EngineRecord::Yade { script, .. } => same &= *script == yade::script_digest(),
        // It is made anew in seconds, and an older build may have had other bits.
        EngineRecord::Native { .. } => {
            let anew = in_memory(scene, engine, Protocol::Whole)?;
            same &= anew.history == run.history;
        }
        EngineRecord::Exec { .. } => same = false,
    }
    if !same {
        return Err(Error::Usage(format!(
            "{} holds another run than this job needs; name another folder with --out",
            folder.display()
        )));
    }
    display.line(&format!("{name}: taken over from an earlier job"));
    Ok(run)
}

/// Steps of pouring that a fault has to show itself in.
const FAULT_STEPS: u64 = 6000;

/// The faults, smallest sizes that the issue of finding them is about.
const FAULTS: [Perturbation; 6] = [
    Perturbation::Sized(Quantity::Stiffness, 1e-12),
    Perturbation::Sized(Quantity::Gravity, 1e-12),
    Perturbation::Sized(Quantity::Damping, 1e-12),
    Perturbation::Sized(Quantity::Wall, 1e-12),
    Perturbation::Switched(Switch::Wall),
    Perturbation::Switched(Switch::Sums),
];

/// Proof that the comparison can fail: puts each fault in, compares with the sound engine and finds the first difference.
fn faults(scene: &Scene, display: &Display) -> Result<Vec<FaultCheck>, Error> {
    let task = display.task("faults put in");
    let sound = pour(scene, None, FAULT_STEPS)?;
    let mut checks = Vec::new();
    for (done, fault) in FAULTS.into_iter().enumerate() {
        let (verdict, found) = if fault.changes(scene) {
            find(scene, &sound, fault)?
        } else {
            let why = "it changes nothing in this scene";
            (Outcome::Skipped, why.to_owned())
        };
        checks.push(FaultCheck {
            fault: fault.to_string(),
            verdict,
            found,
        });
        task.share((done + 1) as f64 / FAULTS.len() as f64, &fault.to_string());
    }
    let found = checks.iter().filter(|check| check.verdict == Outcome::Pass);
    task.done(&format!("{} of {} found", found.count(), checks.len()));
    Ok(checks)
}

/// Whether a fault is found, and the first step and grain or why it is not.
fn find(scene: &Scene, sound: &RunFolder, fault: Perturbation) -> Result<(Outcome, String), Error> {
    // A fault may end the faulty engine; a tenth earlier, all may still be well enough to compare.
    let (mut steps, mut ended) = (FAULT_STEPS, None);
    let faulty = loop {
        match pour(scene, Some(fault), steps) {
            Ok(faulty) => break faulty,
            Err(EngineError::Native(error)) if error.trouble != Trouble::Interrupted => {
                steps = error.step * 9 / 10;
                ended.get_or_insert(error);
            }
            Err(error) => return Err(error.into()),
        }
    };
    let shortened = match &ended {
        Some(_) => Some(pour(scene, None, faulty.record.stages[0].steps)?),
        None => None,
    };
    let sound = shortened.as_ref().unwrap_or(sound);
    let comparison = compare(sound, &faulty, Some(&Locator::default()));
    let differs = comparison.verdict() == Verdict::Different;
    let mut found = match &comparison.first_difference {
        Some(first) => first.to_string(),
        None if differs => "a check failed, the place was not found".to_owned(),
        None => format!("no difference in {FAULT_STEPS} steps"),
    };
    if let Some(error) = ended {
        found += &format!("; then the {error}");
    }
    Ok((Outcome::pass_if(differs), found))
}

/// Pours for so many steps, nothing kept on disk.
fn pour(
    scene: &Scene,
    perturbation: Option<Perturbation>,
    steps: u64,
) -> Result<RunFolder, EngineError> {
    let engine = Engine::Native(native::Options {
        perturbation,
        ..native::Options::default()
    });
    in_memory(scene, &engine, Protocol::Steps { steps })
}

/// A run of the native engine, which leaves nothing in its work folder.
fn in_memory(scene: &Scene, engine: &Engine, protocol: Protocol) -> Result<RunFolder, EngineError> {
    let initial = initial_bodies(scene);
    let nowhere = Path::new("");
    recorded(scene, engine, protocol, initial, nowhere, &mut |_, _, _| {})
}
