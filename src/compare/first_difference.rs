//! The first step and grain in which two engines part, found by halving.
//!
//! The histories say between which two moments the first difference is. The state at the earlier one is made anew with the
//! native engine (or with A's own) and proved by its digest; from there both engines are run again over halved distances, each
//! from the last state that both had.

use serde::Serialize;

use super::bits::{self, NumberPair, TableBits};
use crate::engine::exec::{self, ExternalEngine};
use crate::engine::{Engine, EngineRecord, yade};
use crate::files::{FileError, work_folder};
use crate::run::folder::RunFolder;
use grains::model::Model;
use grains::native;
use grains::scene::Scene;
use grains::tables::Stage;
use grains::task::{Start, Task, Until};

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstDifference {
    pub stage: Stage,
    /// The first step after which the states differ; all before agree in every bit.
    pub step: u64,
    /// How many positions and velocities differ after it.
    pub differing: usize,
    /// The differing number of the grain with the lowest id.
    pub number: NumberPair,
    pub engine_starts: usize,
}

impl std::fmt::Display for FirstDifference {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (step, stage, count) = (self.step, self.stage.name(), self.differing);
        let number = &self.number;
        write!(
            out,
            "step {step} of stage {stage}: {number} (numbers that differ after this step: {count})"
        )
    }
}

/// Runs engines again to find where they part.
#[derive(Debug, Clone, Default)]
pub struct Locator {
    /// How YADE is started; order and distance are taken from the runs.
    pub yade: yade::Options,
    /// Where external engines are; a run's is the one whose file has the digest of its record.
    pub programs: Vec<exec::Options>,
}

impl Locator {
    /// The first difference of two runs of the same start; none if there is none.
    pub fn locate(&self, a: &RunFolder, b: &RunFolder) -> Result<Option<FirstDifference>, String> {
        let at_start = bits::bodies("initial grains", &a.initial, &b.initial);
        if let Some(number) = at_start.first {
            return Ok(Some(FirstDifference {
                stage: Stage::Settle,
                step: 0,
                differing: at_start.differing,
                number,
                engine_starts: 0,
            }));
        }
        let history = bits::history(a, b);
        let Some([together, (stage, unequal)]) = history.apart else {
            return match history.first_unequal {
                None => Ok(None),
                Some((stage, step)) => Err(format!(
                    "all states agree; forces first differ at step {step} of stage {}",
                    stage.name()
                )),
            };
        };
        if stage == Stage::Load && unequal == 0 {
            let why = "the states agree, but one run begins to load before the other: the settle rules differ";
            return Err(why.to_owned());
        }
        let side = |run| {
            let engine = self.engine_of(run)?;
            let scene = &run.scene;
            Ok::<_, String>(Side { scene, engine })
        };
        let mut search = Search {
            a: side(a)?,
            b: side(b)?,
            starts: 0,
        };
        let equal = if together.0 == stage { together.1 } else { 0 };
        // Contacts with friction remember, so such a run can be taken up at its very start only.
        let has_history = Model::in_stage(&a.scene, stage).law.has_history();
        if has_history && stage == Stage::Load {
            return Err(format!(
                "the runs part between steps {equal} and {unequal} of stage load, and a run with friction \
                 cannot be taken up there; a smaller measurement.history_every narrows it down"
            ));
        }
        let mut moments = a.history.iter();
        let proof = moments.find(|row| (row.stage, row.step) == (stage, equal));
        let proof = proof.map(|row| row.state.as_str());
        let taken_up = if has_history { 0 } else { equal };
        let start = search.state_at(a, stage, taken_up, proof)?;
        search.halve(start, [equal, unequal], has_history).map(Some)
    }

    /// The engine of a run, as it was, ready to be run again.
    pub fn engine_of(&self, run: &RunFolder) -> Result<Box<dyn Engine>, String> {
        Ok(match &run.record.engine {
            EngineRecord::Native { perturbation, .. } => Box::new(native::Options {
                perturbation: *perturbation,
                ..native::Options::default()
            }),
            EngineRecord::Yade {
                sorted,
                verlet_distance,
                ..
            } => Box::new(yade::Options {
                sorted: *sorted,
                verlet_distance: *verlet_distance,
                ..self.yade.clone()
            }),
            EngineRecord::Exec { described, digest } => {
                let program = self.program(&described.name, digest)?.clone();
                Box::new(ExternalEngine::ask(program).map_err(|error| error.to_string())?)
            }
        })
    }

    /// What the digest of a run's program covers; none where no program was named for it.
    pub fn covered(&self, run: &RunFolder) -> Option<Result<String, FileError>> {
        let EngineRecord::Exec { described, digest } = &run.record.engine else {
            return None;
        };
        let program = self.program(&described.name, digest).ok()?;
        Some(exec::covered(&program.program))
    }

    /// The program that made a run: another one would find another difference.
    fn program(&self, name: &str, digest: &str) -> Result<&exec::Options, String> {
        for options in &self.programs {
            let found =
                exec::program_digest(&options.program).map_err(|error| error.to_string())?;
            if found == digest {
                return Ok(options);
            }
        }
        Err(if self.programs.is_empty() {
            format!(
                "a run folder does not say where its engine is; name {name} with --engine exec:PATH"
            )
        } else {
            format!(
                "none of the programs that were named made the run of {name}: they have other bytes"
            )
        })
    }
}

/// An engine, ready to be run again.
struct Side<'a> {
    scene: &'a Scene,
    engine: Box<dyn Engine>,
}

impl Side<'_> {
    /// The state after `step`, from an earlier one.
    fn advance(&self, start: &Start, step: u64) -> Result<Start, String> {
        let work = work_folder().map_err(|error| error.to_string())?;
        let task = Task {
            start: start.clone(),
            until: Until::Step(step),
        };
        let run = self.engine.run(self.scene, &task, work.path(), &mut ());
        Ok(run.map_err(|error| error.to_string())?.outcome.last.into())
    }
}

struct Search<'a> {
    a: Side<'a>,
    b: Side<'a>,
    starts: usize,
}

impl Search<'_> {
    /// The state of run A at a moment, proved by its digest.
    fn state_at(
        &mut self,
        run: &RunFolder,
        stage: Stage,
        step: u64,
        proof: Option<&str>,
    ) -> Result<Start, String> {
        let bodies = match (stage, &run.settled) {
            (Stage::Settle, _) => run.initial.clone(),
            (Stage::Load, Some(settled)) => settled.bodies.clone(),
            (Stage::Load, None) => return Err("the folder has no settled state".to_owned()),
        };
        let start = Start {
            stage,
            ..bodies.into()
        };
        if step == 0 {
            return Ok(start);
        }
        let native = Side {
            scene: &run.scene,
            engine: Box::new(native::Options::default()),
        };
        let proved = |state: &Start| proof.is_none_or(|proof| state.bodies.digest() == proof);
        self.starts += 1;
        if let Ok(state) = native.advance(&start, step)
            && proved(&state)
        {
            return Ok(state);
        }
        self.starts += 1;
        let state = self.a.advance(&start, step)?;
        let again = proved(&state).then_some(state);
        again.ok_or_else(|| {
            let stage = stage.name();
            format!(
                "the state at step {step} of stage {stage} cannot be made again with the same bits"
            )
        })
    }

    /// Both agree after the step `equal` and differ after `unequal`. Runs begin at `start`, or later where nothing remembers.
    fn halve(
        &mut self,
        mut start: Start,
        [mut equal, mut unequal]: [u64; 2],
        has_history: bool,
    ) -> Result<FirstDifference, String> {
        let stage = start.stage;
        loop {
            // The last round takes a single step, whose outcome is then looked at number by number.
            let middle = equal + (unequal - equal).div_ceil(2);
            self.starts += 2;
            let after_a = self.a.advance(&start, middle)?;
            let after_b = self.b.advance(&start, middle)?;
            let table = states(&after_a, &after_b);
            match table.first {
                None if middle == unequal => {
                    return Err(format!(
                        "the runs part between steps {equal} and {unequal} of stage {}, but agree when \
                         started again from the state before",
                        stage.name()
                    ));
                }
                None => {
                    equal = middle;
                    if !has_history {
                        start = after_a;
                    }
                }
                Some(number) if middle == equal + 1 => {
                    return Ok(FirstDifference {
                        stage,
                        step: middle,
                        differing: table.differing,
                        number,
                        engine_starts: self.starts,
                    });
                }
                Some(_) => unequal = middle,
            }
        }
    }
}

/// Grains and punch of two states.
fn states(a: &Start, b: &Start) -> TableBits {
    let mut table = bits::bodies("state", &a.bodies, &b.bodies);
    let height = |start: &Start| start.punch.map(|punch| punch.centre[1]);
    if let (Some(of_a), Some(of_b)) = (height(a), height(b)) {
        table.numbers += 1;
        table.hold(|| "the punch".to_owned(), "z", of_a, of_b);
    }
    table
}
