//! The main job: the paper's experiment in the native engine and in YADE, recorded and live, compared.

mod document;
pub mod record;

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Instant;

use crate::checks::{Outcome, verdict};
use crate::compare::first_difference::Locator;
use crate::compare::first_steps::from_bed;
use crate::compare::{Comparison, compare};
use crate::engine::{Engine, EngineRecord, yade};
use crate::error::Error;
use crate::files::{real_folder, work_folder};
use crate::progress::Display;
use crate::run::folder::record::Protocol;
use crate::run::folder::{RECORDED, RunFolder, is_recorded, unpack_recorded};
use crate::run::{EngineError, Preparation, parts, prepared, recorded};
use crate::suite::parameters;
use crate::suite::run::{Verification, verify};
use crate::{paper, suite};
use grains::generate::initial_bodies;
use grains::native;
use grains::native::{Fault, Trouble};
use grains::scene::Scene;
use grains::tables::StopReason;
use record::{Beside, FaultCheck, LoopSteps, NamedComparison, Reproduction, RunSummary, Skipped};
use verdict::judge::{Reference, Verdict};
use verdict::starts::DISPERSION;

/// Grains of the longest trajectories of the suite in this job; `crossgrain verify` has all.
const SUITE_GRAINS: u32 = 500;

/// What is to be reproduced, and where to.
#[derive(Debug, Clone)]
pub struct Options {
    /// The folder that everything goes into.
    pub out: PathBuf,
    pub scene: Scene,
    /// Further realizations in YADE's sorted mode.
    pub full: bool,
    /// Whether the verification suite is run too.
    pub suite: bool,
    /// YADE is not started; its recorded run stands for it.
    pub recorded: bool,
    pub yade: yade::Options,
    /// A fault in the native engine, to see that the whole job would notice.
    pub fault: Option<Fault>,
    /// Records of other jobs that stand on the page, which the job's own record names.
    pub beside: Beside,
    pub command: String,
}

/// The native engine with a fault, if there is one.
fn native(perturbation: Option<Fault>) -> native::Options {
    native::Options {
        perturbation,
        ..native::Options::default()
    }
}

/// The runs that the page draws.
#[derive(Debug)]
pub struct Runs {
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
        made: Reproduction {
            crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
            command: options.command.clone(),
            scene_digest: options.scene.digest(),
            numbers: paper::numbers(),
            text_faults: paper::text_faults(),
            beside: options.beside.stated(),
            ..Reproduction::default()
        },
    };
    job.compare_facts()?;
    let native = job.run(&options.scene, "native")?;
    let recorded = job.recorded()?;
    if let Some(recorded) = &recorded {
        let compared = compare(&native, recorded, Some(&job.locator()));
        job.compare(OF_RECORDED, ["native", RECORDED], compared);
    }
    let sorted = job.live(&native)?;
    if native.record.stop() == Some(StopReason::MaxSteps) {
        let why = "the bed did not settle within /settle/max_steps";
        job.skipped("run/loading", "loading", why, true);
    }
    let Job { mut made, .. } = job;
    let of_native = native.record.seconds_per_step();
    for run in made.runs.iter_mut().filter(|run| run.folder != RECORDED) {
        run.times_native = Some(run.microseconds_per_step / (1e6 * of_native));
    }
    let version = sorted.as_ref().map(|run| run.record.engine.version());
    made.yade = version.map(str::to_owned);
    made.claims = record::claims(&native);
    made.seconds = began.elapsed().as_secs_f64();
    made.verdict = verdict(&made.checks());
    let yade = sorted.or(recorded);
    Ok((made, Runs { native, yade }))
}

/// The beginning of the ids of a part's checks, and its title.
type Part<'a> = (&'a str, &'a str);
const OF_RECORDED: Part<'_> = (
    "compare/sorted-recorded",
    "native against YADE's sorted loop, recorded",
);
const OF_LIVE: Part<'_> = (
    "compare/sorted-live",
    "native against YADE's sorted loop, live",
);
const LOOPS: [(&str, &str, bool); 2] = [
    ("first-steps/sorted", "YADE's sorted loop", true),
    ("first-steps/ordinary", "YADE's ordinary loop", false),
];

struct Job<'a> {
    options: &'a Options,
    display: &'a Display,
    made: Reproduction,
}

impl Job<'_> {
    /// The native engine's run of a scene.
    fn run(&mut self, scene: &Scene, name: &str) -> Result<RunFolder, Error> {
        let engine = native(self.options.fault);
        let run = run_or_take_over(self.options, self.display, scene, name, &engine, &[])?;
        self.made.runs.push(RunSummary::of(name, &run));
        Ok(run)
    }

    fn compare(&mut self, (id, title): Part<'_>, folders: [&str; 2], comparison: Comparison) {
        self.made.comparisons.push(NamedComparison {
            id: id.to_owned(),
            title: title.to_owned(),
            folders: folders.map(str::to_owned).to_vec(),
            comparison,
        });
    }

    fn skipped(&mut self, id: &str, what: &str, why: &str, required: bool) {
        self.made.skipped.push(Skipped {
            id: id.to_owned(),
            what: what.to_owned(),
            why: why.to_owned(),
            required,
        });
    }

    fn locator(&self) -> Locator {
        Locator {
            yade: self.options.yade.clone(),
            programs: Vec::new(),
        }
    }

    /// The recorded run of YADE, if it is one of this scene.
    fn recorded(&mut self) -> Result<Option<RunFolder>, Error> {
        let (folder, is_there) = real_folder(&self.options.out, RECORDED)?;
        if !is_there {
            unpack_recorded(&folder)?;
        } else if !is_recorded(&folder) {
            return Err(Error::Usage(format!(
                "{} is not the recorded run; remove it, or name another folder with --out",
                folder.display()
            )));
        }
        let recorded = RunFolder::read(&folder)?;
        if recorded.record.scene_digest != self.options.scene.digest() {
            let why = "the recorded run is of the paper's scene, this is another";
            self.skipped(OF_RECORDED.0, OF_RECORDED.1, why, false);
            return Ok(None);
        }
        self.made.runs.push(RunSummary::of(RECORDED, &recorded));
        Ok(Some(recorded))
    }

    /// Why YADE does not run live, if it does not.
    fn without_yade(&self) -> Option<String> {
        if self.options.recorded {
            return Some("--recorded leaves it out".to_owned());
        }
        let missing = yade::find(self.options.yade.program.as_deref()).err();
        let unsupported = yade::lacking(&self.options.scene);
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
        self.made.facts = parameters::side_by_side(native, &in_yade);
        Ok(())
    }

    fn skipped_of_suite(&mut self) {
        let [id, what, why] = match self.options.suite {
            true => [
                "verify/5000-grains",
                "trajectories and rounding errors of 5,000 grains",
                "crossgrain verify makes them; here up to 500 grains",
            ],
            false => [
                "verify/all",
                "the verification suite",
                "made with the paper's scene only; crossgrain verify makes it alone",
            ],
        };
        self.skipped(id, what, why, false);
    }
}

/// The verification suite with its detection limits, if it is asked for.
fn suite(
    options: &Options,
    yade: Option<&yade::Options>,
    display: &Display,
) -> Result<Option<Verification>, Error> {
    if !options.suite {
        return Ok(None);
    }
    let options = suite::run::Options {
        native: true,
        yade: yade.cloned(),
        grains: SUITE_GRAINS,
        detection_limits: true,
        command: format!("crossgrain verify --detection-limits --grains {SUITE_GRAINS}"),
    };
    Ok(Some(verify(&options, display)?))
}

/// Grains of the bed from which the loops' first steps are judged.
const GRAINS: u32 = 1000;

/// Realizations that `--full` adds.
const FURTHER_REALIZATIONS: u64 = 2;

impl Job<'_> {
    /// YADE live: the whole experiment in the sorted loop, and all else beside it. Without YADE, all else.
    fn live(&mut self, native: &RunFolder) -> Result<Option<RunFolder>, Error> {
        let differ = parameters::outcome(&self.made.facts) != Some(Outcome::Pass);
        let why_not = self.without_yade().or_else(|| {
            differ.then(|| "the two engines do not use the same parameters".to_owned())
        });
        self.skipped_of_suite();
        let (options, display, scene) = (self.options, self.display, &self.options.scene);
        if let Some(why) = why_not {
            let what =
                "YADE live: its parameters, the whole experiment, first steps, the suite's cases";
            self.skipped(OF_LIVE.0, what, &why, false);
            self.made.faults = faults(scene, display)?;
            self.made.suite = suite(options, None, display)?;
            return Ok(None);
        }
        let cuts = parts::cuts(scene, &native.history);
        let (sorted, others) = thread::scope(|scope| {
            let others = scope.spawn(|| -> Result<_, Error> {
                let first_steps = of_loops(options, display)?;
                let faults = faults(scene, display)?;
                Ok((
                    first_steps,
                    faults,
                    suite(options, Some(&options.yade), display)?,
                ))
            });
            let sorted = yade_run(options, display, scene, "yade-sorted", &cuts);
            (sorted, joined(others))
        });
        let sorted = sorted?;
        (self.made.first_steps, self.made.faults, self.made.suite) = others?;
        self.made.runs.push(RunSummary::of("yade-sorted", &sorted));
        let compared = compare(native, &sorted, Some(&self.locator()));
        self.compare(OF_LIVE, ["native", "yade-sorted"], compared);
        if options.full {
            self.further_realizations()?;
        } else {
            let what = "further realizations, whole, against YADE's sorted loop";
            let why = "asked for with --full only";
            self.skipped("compare/further-realizations", what, why, false);
        }
        Ok(Some(sorted))
    }

    fn further_realizations(&mut self) -> Result<(), Error> {
        let (options, display) = (self.options, self.display);
        let first = options.scene.realization.saturating_add(1);
        let further = first..first.saturating_add(FURTHER_REALIZATIONS);
        let scene = |realization| Scene {
            realization,
            ..options.scene.clone()
        };
        let realizations: Vec<Scene> = further.map(scene).collect();
        let name = |engine: &str, scene: &Scene| format!("{engine}-{}", scene.realization);
        let sorted: Vec<Result<RunFolder, Error>> = thread::scope(|scope| {
            let start = |scene| {
                let name = name("yade-sorted", scene);
                scope.spawn(move || yade_run(options, display, scene, &name, &[]))
            };
            let handles: Vec<_> = realizations.iter().map(start).collect();
            handles.into_iter().map(joined).collect()
        });
        for (scene, sorted) in realizations.iter().zip(sorted) {
            let (native_name, sorted_name) = (name("native", scene), name("yade-sorted", scene));
            let native = self.run(scene, &native_name)?;
            let sorted = sorted?;
            self.made.runs.push(RunSummary::of(&sorted_name, &sorted));
            let (id, title) = OF_LIVE;
            let id = format!("{id}-{}", scene.realization);
            let title = format!("{title}, realization {}", scene.realization);
            let compared = compare(&native, &sorted, Some(&self.locator()));
            self.compare((&id, &title), [&native_name, &sorted_name], compared);
        }
        Ok(())
    }
}

/// Runs, in parts if there are cuts, or reads the folder that an earlier, interrupted job has left.
fn run_or_take_over(
    options: &Options,
    display: &Display,
    scene: &Scene,
    name: &str,
    engine: &dyn Engine,
    cuts: &[u64],
) -> Result<RunFolder, Error> {
    let (folder, is_there) = real_folder(&options.out, name)?;
    if !is_there {
        return Ok(match cuts {
            [] => {
                let nothing = Preparation::default();
                prepared(scene, nothing, engine, Protocol::Whole, &folder, display)?
            }
            cuts => parts::to_folder(scene, engine, cuts, &folder, display)?,
        });
    }
    let run = RunFolder::read(&folder)?;
    let mut same = run.record.scene_digest == scene.digest()
        && run.record.command == crate::run::command(engine, Protocol::Whole);
    match &run.record.engine {
        EngineRecord::Yade { script, .. } => same &= *script == yade::script_digest(false),
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
const FAULTS: [&str; 6] = [
    "stiffness=1e-12",
    "gravity=1e-12",
    "damping=1e-12",
    "wall=1e-12",
    "wall=missing",
    "sums=reversed",
];

/// Proof that the comparison can fail: puts each fault in, compares with the sound engine and finds the first difference.
fn faults(scene: &Scene, display: &Display) -> Result<Vec<FaultCheck>, Error> {
    let task = display.task("faults put in");
    let sound = pour(scene, None, FAULT_STEPS)?;
    let mut checks = Vec::new();
    for (done, fault) in FAULTS.into_iter().enumerate() {
        let fault: Fault = fault.parse().expect("a fault of the list");
        let why = "it changes nothing in this scene";
        let (verdict, found) = match fault.changes(scene) {
            true => find(scene, &sound, fault)?,
            false => (Outcome::Skipped, why.to_owned()),
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
fn find(scene: &Scene, sound: &RunFolder, fault: Fault) -> Result<(Outcome, String), Error> {
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
    let shortened = ended
        .as_ref()
        .map(|_| pour(scene, None, faulty.record.stages[0].steps));
    let shortened = shortened.transpose()?;
    let sound = shortened.as_ref().unwrap_or(sound);
    let comparison = compare(sound, &faulty, Some(&Locator::default()));
    let differs = comparison.verdict() == Verdict::Different;
    let mut found = match &comparison.first_difference {
        Some(first) => first.to_string(),
        None if differs => "a check failed, the place was not found".to_owned(),
        None => format!("no difference in {FAULT_STEPS} steps"),
    };
    if let Some(error) = ended {
        found += &match error.trouble {
            Trouble::Lost { grain, .. } => format!("; later grain {grain} left the box"),
            _ => format!("; the run ended at step {}", error.step),
        };
    }
    Ok((Outcome::pass_if(differs), found))
}

/// Pours for so many steps, nothing kept on disk.
fn pour(scene: &Scene, perturbation: Option<Fault>, steps: u64) -> Result<RunFolder, EngineError> {
    in_memory(scene, &native(perturbation), Protocol::Steps { steps })
}

/// A run of the native engine, which leaves nothing in its work folder.
fn in_memory(
    scene: &Scene,
    engine: &dyn Engine,
    protocol: Protocol,
) -> Result<RunFolder, EngineError> {
    let initial = initial_bodies(scene);
    let nowhere = Path::new("");
    recorded(scene, engine, protocol, initial, nowhere, &mut |_, _, _| {})
}

/// What a thread returned; its panic is this one's.
fn joined<T>(handle: thread::ScopedJoinHandle<'_, T>) -> T {
    let joined = handle.join();
    joined.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// The first steps of both loops of YADE, held against the same replicas.
fn of_loops(options: &Options, display: &Display) -> Result<Vec<LoopSteps>, Error> {
    let task = display.task("first steps of YADE's loops");
    let mut progress = |words: &str| task.share(0.0, words);
    let reference = Reference::new(GRAINS, DISPERSION, &mut progress).map_err(EngineError::from)?;
    let mut found = Vec::new();
    for (id, title, sorted) in LOOPS {
        let yade = yade::Options {
            sorted,
            ..options.yade.clone()
        };
        found.push(LoopSteps {
            id: id.to_owned(),
            title: title.to_owned(),
            judgement: from_bed(&reference, &yade, &mut progress)?,
        });
    }
    task.done("done");
    Ok(found)
}

fn yade_run(
    options: &Options,
    display: &Display,
    scene: &Scene,
    name: &str,
    cuts: &[u64],
) -> Result<RunFolder, Error> {
    let engine = yade::Options {
        sorted: true,
        ..options.yade.clone()
    };
    run_or_take_over(options, display, scene, name, &engine, cuts)
}
