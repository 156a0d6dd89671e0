//! `crossgrain run`: one scene, one engine, one run folder.

use std::env;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use grains::native::timing::ThreadTime;

use super::engine::one;
use super::job_folder::clear;
use super::{print, with_options};
use crate::engine::exec::{self, ExternalEngine, usual_limits};
use crate::engine::limits::Limits;
use crate::engine::named::Named;
use crate::engine::{Engine, value_name, yade};
use crate::error::{Error, exit};
use crate::files::{has_room, make_folder, read_text, sha256_hex, size_and_age, write_whole};
use crate::limits::stability::time_step;
use crate::progress::Display;
use crate::report::outcome::answer;
use crate::run::folder::record::{Protocol, Softened, StepChoice};
use crate::run::folder::{RECORD, RunFolder, bad_scene, has_room_for_history, read_scene};
use crate::run::{Preparation, prepared};
use crate::workers::cores;
use grains::generate::initial_bodies;
use grains::native::pouring::{Softly, pour};
use grains::native::{self, Fault, Threads};
use grains::scene::Scene;
use grains::tables::{Bodies, StopReason};

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LastStage {
    /// The bed has settled
    Settled,
    /// The punch has its force
    Loaded,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LoopOrder {
    /// Interactions in the order of their ids: slower, and the native engine's bits
    Sorted,
    /// YADE's own order
    Ordinary,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  crossgrain scene paper > scene.json\n  \
    crossgrain run scene.json --engine native --out native\n  \
    crossgrain run scene.json --engine yade --steps 20000 --out yade\n  \
    crossgrain run scene.json --engine exec:adapters/lammps.py --until settled --out lammps\n\nExit code 1: the time step is beyond the \
    largest stable one of the bed. `crossgrain report run DIR --out PAGE` makes a page with pictures.")]
pub struct Arguments {
    /// The scene file
    scene: PathBuf,
    /// native, yade, or exec:PATH for a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long, value_parser = one)]
    engine: Named,
    /// Exactly this many steps of pouring, no stop rule
    #[arg(long, value_name = "N", conflicts_with = "until")]
    steps: Option<u64>,
    /// How far to go, each stage ended by the scene's rule
    #[arg(long, value_enum, default_value = "loaded")]
    until: LastStage,
    /// Another realization than the scene's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// The run folder to write; an earlier one is kept, with a number after its name
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Native: put in a deliberate fault, such as stiffness=1e-12, friction=S, time-step=S, wall=missing or
    /// sums=reversed; a wrong one is answered with all that there are
    #[arg(long, value_name = "FAULT")]
    perturb: Option<Fault>,
    /// Choose the time step: this share of the largest stable step that a probe of the scene in the native
    /// engine shows; the evidence is in run.json
    #[arg(long, value_name = "SHARE", num_args = 0..=1, default_missing_value = "0.8", value_parser = share)]
    auto_step: Option<f64>,
    /// Native: reduced-stiffness deposition, the grains poured at a tenth of their modulus and stiffened; with the scene of
    /// `scene paper --fast` the fast protocol, which the trade-off study recommends
    #[arg(long)]
    reduced_stiffness: bool,
    /// Native: threads for a big bed; all cores if not given. The bits do not depend on it
    #[arg(long, value_name = "N", default_value_t = cores(), hide_default_value = true)]
    threads: usize,
    /// Native: go on from this run folder. A run that was interrupted or stopped at a step goes on to its end, with the bits of
    /// the whole run; a settled bed is loaded as the scene says
    #[arg(long, value_name = "DIR", conflicts_with_all = ["seed", "auto_step", "reduced_stiffness"])]
    from_state: Option<PathBuf>,
    #[command(flatten)]
    yade: YadeArguments,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

#[derive(Debug, Args)]
pub struct YadeArguments {
    /// YADE: order in which interactions are visited
    #[arg(long = "loop", value_enum, default_value = "sorted")]
    order: LoopOrder,
    /// YADE: verletDist, m
    #[arg(long, value_name = "M", default_value_t = yade::Options::default().verlet_distance)]
    verlet_distance: f64,
    #[command(flatten)]
    pub limits: YadeLimits,
}

#[derive(Debug, Args)]
pub struct YadeLimits {
    /// YADE: the program, instead of the one on the path (or CROSSGRAIN_YADE)
    #[arg(long, value_name = "FILE")]
    pub yade: Option<PathBuf>,
    /// YADE and exec: longest time for a run, s
    #[arg(long, value_name = "S", default_value_t = usual_limits().time.as_secs())]
    time_limit: u64,
    /// YADE and exec: longest time without a sign of life, s
    #[arg(long, value_name = "S", default_value_t = usual_limits().stall.as_secs())]
    stall_limit: u64,
    /// YADE and exec: the most memory of the engine and all that it starts, MB
    #[arg(long, value_name = "MB", default_value_t = 4096)]
    memory_limit: u64,
    /// YADE and exec: the most that the engine may write, MB
    #[arg(long, value_name = "MB", default_value_t = 16384)]
    output_limit: u64,
}

impl YadeArguments {
    /// The words on the command line of what is not the default and changes results, a space before each.
    pub fn words(&self) -> String {
        let (order, distance) = (self.order, self.verlet_distance);
        let is_other = distance != yade::Options::default().verlet_distance;
        let options = [
            (order != LoopOrder::Sorted).then(|| format!("--loop {}", value_name(&order))),
            is_other.then(|| format!("--verlet-distance {distance}")),
        ];
        with_options("", options)
    }

    /// As they are given.
    pub fn options(&self) -> Result<yade::Options, Error> {
        let distance = self.verlet_distance;
        if !(distance.is_finite() && distance >= 0.0) {
            return Err(Error::Usage(format!(
                "--verlet-distance is {distance}, and must be a length of 0 or more"
            )));
        }
        Ok(yade::Options {
            sorted: self.order == LoopOrder::Sorted,
            verlet_distance: distance,
            ..self.limits.options()
        })
    }

    /// The engine, a program asked what it is before anything that takes long.
    pub fn engine(&self, named: &Named) -> Result<Box<dyn Engine>, Error> {
        let options = match named {
            Named::Yade(_) => self.options()?,
            _ => self.limits.options(),
        };
        Ok(named.engine(&options, Path::new(""))?)
    }
}

impl YadeLimits {
    /// Options with these limits and the default order.
    pub fn options(&self) -> yade::Options {
        yade::Options {
            limits: self.limits(),
            program: self.yade.clone(),
            ..yade::Options::default()
        }
    }

    /// The program at this path with these limits.
    pub fn exec(&self, program: PathBuf) -> exec::Options {
        exec::Options {
            program,
            limits: self.limits(),
        }
    }

    fn limits(&self) -> Limits {
        Limits {
            time: Duration::from_secs(self.time_limit),
            stall: Duration::from_secs(self.stall_limit),
            memory: self.memory_limit.saturating_mul(1 << 20),
            output: self.output_limit.saturating_mul(1 << 20),
        }
    }

    /// The program at this path, asked what it is before anything that takes long.
    pub fn external(&self, program: &Path) -> Result<ExternalEngine, Error> {
        Ok(ExternalEngine::ask(self.exec(program.to_owned()))?)
    }
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let mut scene = read_scene(&self.scene)?;
        if let Some(seed) = self.seed {
            scene.realization = seed;
        }
        if scene.in_space() && (self.auto_step.is_some() || self.reduced_stiffness) {
            let why = "--auto-step and --reduced-stiffness are for scenes in the plane: leave /box/depth or them away";
            return Err(Error::Usage(why.to_owned()));
        }
        has_room(&self.out, RECORD)?;
        let protocol = match self.steps {
            Some(steps) => Protocol::Steps { steps },
            None if self.until == LastStage::Settled => Protocol::Settled,
            None => Protocol::Whole,
        };
        let engine = self.engine()?;
        let before = match &self.from_state {
            Some(path) => Some((RunFolder::read_so_far(path)?, path.clone())),
            None => None,
        };
        let display = Display::new(self.quiet);
        // Before anything that takes long, and with the chosen step before an earlier result is moved away.
        has_room_for_history(&scene, protocol)?;
        let choice = self.choose_step(&mut scene, &display)?;
        has_room_for_history(&scene, protocol)?;
        engine.check(&scene, &protocol.task(initial_bodies(&scene)))?;
        let preparation = Preparation {
            step_choice: choice,
            softened: self.deposit(&scene, engine.as_ref())?,
            keeps: true,
            before,
        };
        clear(&self.out, RECORD)?;
        let mut run = prepared(
            &scene,
            preparation,
            engine.as_ref(),
            protocol,
            &self.out,
            &display,
        )?;
        // They are written, take room, and are not asked for any more.
        run.initial = Bodies::default();
        run.last.contacts = Vec::new();
        let share = time_step::largest_share(&run)?;
        print(&summary(&run, &self.out))?;
        print(&format!("{}\n", answer(&run, share)))?;
        Ok(match (share, run.record.stop()) {
            (Some(share), _) if share > 1.0 => exit::CHECK_FAILED,
            (_, Some(StopReason::MaxSteps)) => exit::INCOMPLETE,
            _ => exit::AGREED,
        })
    }

    /// Sets the scene's time step, if the program is to choose it.
    fn choose_step(
        &self,
        scene: &mut Scene,
        display: &Display,
    ) -> Result<Option<StepChoice>, Error> {
        let Some(share) = self.auto_step else {
            return Ok(None);
        };
        let task = display.task("probe for the time step");
        let kept = kept_probe(scene, share);
        let before = kept.as_deref().and_then(|path| probed(path, share));
        let word = if before.is_some() {
            ", probed before"
        } else {
            ""
        };
        let choice = before.map_or_else(|| time_step::choose(scene, share), Ok)?;
        task.done(&format!("{:.4e} s{word}", choice.time_step));
        if let Some(path) = kept.filter(|_| word.is_empty()) {
            // What cannot be kept is probed again.
            let _ = path.parent().map(make_folder);
            let _ = write_whole(&path, super::json(&choice)?.as_bytes());
        }
        *scene = time_step::with_step(scene, &choice);
        // A step that was chosen may be against another rule of scenes.
        let checked = scene.check();
        checked.map_err(|error| bad_scene(&self.scene, &error))?;
        Ok(Some(choice))
    }

    /// Pours the grains softened and stiffens them, if that was asked for.
    fn deposit(
        &self,
        scene: &Scene,
        engine: &dyn Engine,
    ) -> Result<Option<(Softened, Bodies)>, Error> {
        if !self.reduced_stiffness {
            return Ok(None);
        }
        let usage = |reason: &str| Err(Error::Usage(format!("--reduced-stiffness {reason}")));
        let Some(options) = engine.native() else {
            return usage("is of the native engine; others pour at the scene's modulus");
        };
        let whole = self.steps.is_none() && self.until == LastStage::Loaded;
        if !whole || options.perturbation.is_some() {
            return usage(
                "is for whole runs without a fault: leave --steps, --until and --perturb away",
            );
        }
        let Some(softly) = Softly::tested(scene) else {
            return usage("needs /time_step as a fraction, which grows as the grains get softer");
        };
        let cloud = initial_bodies(scene);
        let cloud_digest = cloud.digest();
        let mut phases = softly.phases(scene);
        phases.pop();
        let began = ThreadTime::of(options.threads.of(cloud.len()));
        let Some(poured) = pour(scene, &phases, options, cloud)? else {
            return usage("has no phases");
        };
        let softened = Softened {
            phases,
            cloud_digest,
            steps: poured.steps,
            energy_seen: poured.energy_seen,
            cpu_seconds: began.elapsed().as_secs_f64(),
        };
        Ok(Some((softened, poured.bed.bodies)))
    }

    fn engine(&self) -> Result<Box<dyn Engine>, Error> {
        if self.engine == Named::Native {
            return Ok(Box::new(native::Options {
                perturbation: self.perturb,
                threads: Threads::at_most(self.threads),
                ..native::Options::default()
            }));
        }
        if self.perturb.is_some() {
            return Err(Error::Usage(
                "--perturb puts a fault into the native engine; no other has such a thing"
                    .to_owned(),
            ));
        }
        self.yade.engine(&self.engine)
    }
}

/// Where the probe of a scene is kept for later runs by this very program: among the user's cached files, if there is such a place.
fn kept_probe(scene: &Scene, share: f64) -> Option<PathBuf> {
    let home = || Some(PathBuf::from(env::var_os("HOME")?).join(".cache"));
    let cache = env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
    let cache = cache.filter(|folder| folder.is_absolute()).or_else(home)?;
    let program = size_and_age(&env::current_exe().ok()?)?;
    let key = format!("{} {share:?} {program:?}", scene.digest());
    let name = format!("time-step-{}.json", sha256_hex(key.as_bytes()));
    Some(cache.join("crossgrain").join(name))
}

/// What a probe found before, if that can be read.
fn probed(path: &Path, share: f64) -> Option<StepChoice> {
    let choice = read_text(path, 1 << 16).ok()?;
    let choice: StepChoice = serde_json::from_str(&choice).ok()?;
    let sound = choice.share == share && choice.time_step == share * choice.limit;
    (sound && choice.time_step > 0.0).then_some(choice)
}

/// A share of the limit, in (0, 1].
fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share <= 1.0 => Ok(share),
        _ => Err("a share of the limit is above 0 and at most 1".to_owned()),
    }
}

fn summary(run: &RunFolder, out: &Path) -> String {
    let mut text = String::new();
    if let Some(choice) = &run.record.step_choice {
        text += &format!(
            "time step {:.4e} s, {} of the limit {:.4e} s at {} looks\n",
            choice.time_step, choice.share, choice.limit, choice.looks
        );
    }
    text += &format!(
        "{}: {}\n{:.1} µs a step; wrote {}\n",
        run.record.engine.label(),
        run.stages_in_words(),
        1e6 * run.record.seconds_per_step(),
        out.display()
    );
    for approximation in run.record.engine.approximations() {
        text += &format!("it says of itself: {approximation}\n");
    }
    text
}
