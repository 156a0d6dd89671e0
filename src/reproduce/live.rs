//! The main job's part with a live YADE.

use std::thread;

use super::record::RunSummary;
use super::{Job, Options, rounding_scatter, run_or_take_over};
use crate::checks::Outcome;
use crate::compare::{ReferenceScatter, compare};
use crate::engine::yade;
use crate::error::Error;
use crate::progress::Display;
use crate::run::Engine;
use crate::run::folder::RunFolder;
use crate::suite::parameters;
use grains::scene::Scene;

/// Ways to run YADE: whether sorted, and `verletDist` over the usual one.
const SORTED_LOOP: (bool, f64) = (true, 1.0);
const ORDINARY_LOOP: (bool, f64) = (false, 1.0);
const CONTROL: (bool, f64) = (false, 2.0);

/// Ids of the comparisons with the live runs.
const SORTED: &str = "compare/sorted-live";
const ORDINARY: &str = "compare/ordinary-live";

/// Realizations that `--full` adds.
const FURTHER_REALIZATIONS: u64 = 2;

/// The live runs of YADE.
pub(super) struct Live {
    pub sorted: RunFolder,
    pub ordinary: RunFolder,
}

impl Job<'_> {
    /// YADE live: sorted on one core; the ordinary pair and the reference on the other.
    pub(super) fn live(&mut self, native: &RunFolder) -> Result<Option<Live>, Error> {
        let sorted_title = "native against YADE's sorted loop, live";
        let ordinary_title = "native against YADE's ordinary loop, live";
        let differ = parameters::outcome(&self.facts) != Some(Outcome::Pass);
        let why_not = self.without_yade().or_else(|| {
            differ.then(|| "the two engines do not use the same parameters".to_owned())
        });
        if let Some(why) = why_not {
            self.skipped(SORTED, sorted_title, &why);
            self.skipped(ORDINARY, ordinary_title, &why);
            return Ok(None);
        }
        let (options, display, scene) = (self.options, self.display, &self.options.scene);
        let run = |scene: &Scene, name: &str, way| yade_run(options, display, scene, name, way);
        let (sorted, others) = thread::scope(|scope| {
            let others = scope.spawn(|| {
                let ordinary = run(scene, "yade-ordinary", ORDINARY_LOOP)?;
                let control = run(scene, "yade-ordinary-control", CONTROL)?;
                let scatter = rounding_scatter(native, display)?;
                Ok::<_, Error>((ordinary, control, scatter))
            });
            let sorted = run(scene, "yade-sorted", SORTED_LOOP);
            (sorted, joined(others))
        });
        let sorted = sorted?;
        let (ordinary, control, scatter) = others?;
        for (name, run) in [
            ("yade-sorted", &sorted),
            ("yade-ordinary", &ordinary),
            ("yade-ordinary-control", &control),
        ] {
            self.runs.push(RunSummary::of(name, run));
        }
        let locator = self.locator();
        self.compare(
            SORTED,
            sorted_title,
            &["native", "yade-sorted"],
            compare(native, &sorted, None, Some(&locator)),
        );
        let reference = ReferenceScatter {
            control: Some(&control),
            scatter: &scatter,
        };
        self.compare(
            ORDINARY,
            ordinary_title,
            &["native", "yade-ordinary", "yade-ordinary-control"],
            compare(native, &ordinary, Some(reference), Some(&locator)),
        );
        if options.full {
            self.further_realizations()?;
        } else {
            self.skipped(
                "compare/further-realizations",
                "further realizations, whole, against YADE's sorted loop",
                "asked for with --full only",
            );
        }
        Ok(Some(Live { sorted, ordinary }))
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
                    scope.spawn(move || yade_run(options, display, scene, &name, SORTED_LOOP))
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
                compare(&native, &sorted, None, Some(&self.locator())),
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

/// A whole run of YADE.
fn yade_run(
    options: &Options,
    display: &Display,
    scene: &Scene,
    name: &str,
    (sorted, distance): (bool, f64),
) -> Result<RunFolder, Error> {
    let engine = Engine::Yade(yade::Options {
        sorted,
        verlet_distance: distance * options.yade.verlet_distance,
        ..options.yade.clone()
    });
    run_or_take_over(options, display, scene, name, &engine)
}
