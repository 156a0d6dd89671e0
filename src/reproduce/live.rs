//! The main job's part with a live YADE.

use std::thread;

use super::record::{FaultCheck, LoopSteps, RunSummary};
use super::{Job, Options, faults, run_or_take_over, suite};
use crate::checks::Outcome;
use crate::compare::compare;
use crate::compare::first_steps::{Asked, from_bed};
use crate::engine::{EngineError, yade};
use crate::error::Error;
use crate::progress::Display;
use crate::run::Engine;
use crate::run::folder::RunFolder;
use crate::suite::parameters;
use crate::suite::run::{Engines, Verification};
use grains::scene::Scene;
use verdict::judge::Reference;
use verdict::starts::DISPERSION;

/// Ids of what is done live.
const SORTED: &str = "compare/sorted-live";
const LOOPS: [(&str, &str, bool); 2] = [
    ("first-steps/sorted", "YADE's sorted loop", true),
    ("first-steps/ordinary", "YADE's ordinary loop", false),
];
/// Grains of the bed from which the loops' first steps are judged.
const GRAINS: u32 = 1000;

/// Realizations that `--full` adds.
const FURTHER_REALIZATIONS: u64 = 2;

/// What is found beside YADE's whole run, and that run.
pub(super) struct Live {
    /// In the sorted loop, if YADE runs live.
    pub sorted: Option<RunFolder>,
    pub first_steps: Vec<LoopSteps>,
    pub faults: Vec<FaultCheck>,
    pub suite: Option<Verification>,
}

impl Job<'_> {
    /// YADE live: the whole experiment in the sorted loop on one core, all else on the other. Without YADE, all else.
    pub(super) fn live(&mut self, native: &RunFolder) -> Result<Live, Error> {
        let differ = parameters::outcome(&self.facts) != Some(Outcome::Pass);
        let why_not = self.without_yade().or_else(|| {
            differ.then(|| "the two engines do not use the same parameters".to_owned())
        });
        self.skipped_of_suite();
        let (options, display, scene) = (self.options, self.display, &self.options.scene);
        let Some(why) = why_not else {
            let (sorted, others) = thread::scope(|scope| {
                let others = scope.spawn(|| -> Result<_, Error> {
                    let first_steps = of_loops(options, display)?;
                    let faults = faults(scene, display)?;
                    let suite = suite(options, Engines::Both, display)?;
                    Ok((first_steps, faults, suite))
                });
                let sorted = yade_run(options, display, scene, "yade-sorted");
                (sorted, joined(others))
            });
            let sorted = sorted?;
            let (first_steps, faults, suite) = others?;
            self.compare_live(native, &sorted)?;
            return Ok(Live {
                sorted: Some(sorted),
                first_steps,
                faults,
                suite,
            });
        };
        let what =
            "YADE live: its parameters, the whole experiment, first steps, the suite's cases";
        self.skipped(SORTED, what, &why);
        Ok(Live {
            sorted: None,
            first_steps: Vec::new(),
            faults: faults(scene, display)?,
            suite: suite(options, Engines::Native, display)?,
        })
    }

    fn compare_live(&mut self, native: &RunFolder, sorted: &RunFolder) -> Result<(), Error> {
        self.runs.push(RunSummary::of("yade-sorted", sorted));
        let title = "native against YADE's sorted loop, live";
        let compared = compare(native, sorted, Some(&self.locator()));
        self.compare(SORTED, title, &["native", "yade-sorted"], compared);
        if self.options.full {
            return self.further_realizations();
        }
        self.skipped(
            "compare/further-realizations",
            "further realizations, whole, against YADE's sorted loop",
            "asked for with --full only",
        );
        Ok(())
    }

    fn further_realizations(&mut self) -> Result<(), Error> {
        let (options, display) = (self.options, self.display);
        let first = self.options.scene.realization.saturating_add(1);
        let realizations: Vec<Scene> = (first..first.saturating_add(FURTHER_REALIZATIONS))
            .map(|realization| Scene {
                realization,
                ..self.options.scene.clone()
            })
            .collect();
        let name = |engine: &str, scene: &Scene| format!("{engine}-{}", scene.realization);
        let sorted: Vec<Result<RunFolder, Error>> = thread::scope(|scope| {
            let handles: Vec<_> = realizations
                .iter()
                .map(|scene| {
                    let name = name("yade-sorted", scene);
                    scope.spawn(move || yade_run(options, display, scene, &name))
                })
                .collect();
            handles.into_iter().map(joined).collect()
        });
        for (scene, sorted) in realizations.iter().zip(sorted) {
            let (native_name, sorted_name) = (name("native", scene), name("yade-sorted", scene));
            let native = self.run(scene, &native_name, &options.native())?;
            let sorted = sorted?;
            self.runs.push(RunSummary::of(&sorted_name, &sorted));
            self.compare(
                &format!("{SORTED}-{}", scene.realization),
                &format!(
                    "native against YADE's sorted loop, live, realization {}",
                    scene.realization
                ),
                &[&native_name, &sorted_name],
                compare(&native, &sorted, Some(&self.locator())),
            );
        }
        Ok(())
    }
}

/// What a thread returned; its panic is this one's.
fn joined<T>(handle: thread::ScopedJoinHandle<'_, T>) -> T {
    match handle.join() {
        Ok(value) => value,
        Err(panic) => std::panic::resume_unwind(panic),
    }
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
            judgement: from_bed(&reference, Asked::Yade(&yade), &mut progress)?,
        });
    }
    task.done("done");
    Ok(found)
}

/// A whole run in YADE's sorted loop.
fn yade_run(
    options: &Options,
    display: &Display,
    scene: &Scene,
    name: &str,
) -> Result<RunFolder, Error> {
    let engine = Engine::Yade(yade::Options {
        sorted: true,
        ..options.yade.clone()
    });
    run_or_take_over(options, display, scene, name, &engine)
}
