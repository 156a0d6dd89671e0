//! All engines on one bed, one after the other, in rounds: whatever slows the machine down slows all of them, and
//! ratios are taken within a round.

use std::path::Path;

use serde::Serialize;

use super::bed::Bed;
use super::contender::{ALL, Contender, Plan, Programs, Turn};
use super::sanity::Sanity;
use super::spread::Spread;
use super::{BenchError, Missed, native};
use crate::compare::bits::{self, TableBits};
use crate::progress::Task;
use grains::native::Mode;
use grains::native::timing::Share;
use grains::tables::Bodies;

/// An engine over all rounds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contest {
    /// Which engine.
    pub contender: Contender,
    /// For tables.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Steps of a window.
    pub steps: u64,
    /// Seconds a step, round by round; of processor time, or on the clock where the engine tells no other.
    pub seconds_per_step: Spread,
    /// Processor time over time on the clock, the least of the rounds, where both are known; well below 1 on a busy machine.
    pub processor_share: Option<f64>,
    /// Its time over native exact's, round by round.
    pub over_exact: Option<Spread>,
    /// Its time over native free's, round by round.
    pub over_free: Option<Spread>,
    /// Largest resident memory of its process, bytes, where it has one of its own.
    pub peak_memory: Option<u64>,
    /// Its own account of where the time goes, where it gives one.
    pub shares: Vec<Share>,
    /// Where it says that it does something else than the model says.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub approximations: Vec<String>,
    /// Whether its bed is still the bed.
    pub sanity: Sanity,
}

/// What the rounds gave.
#[derive(Debug)]
pub struct Rounds {
    /// The engines that ran in every round.
    pub contests: Vec<Contest>,
    /// Native exact against YADE's sorted loop after the same steps: every position and velocity.
    pub sorted_bits: Option<TableBits>,
    /// What is not there, and why.
    pub missed: Vec<Missed>,
}

/// Lets every engine take its turn in every round; every second round goes backwards.
pub fn run(
    bed: &Bed,
    plan: &Plan,
    rounds: u32,
    programs: Programs<'_>,
    work: &Path,
    progress: &Task,
) -> Result<Rounds, BenchError> {
    let mut turns: Vec<(Contender, Vec<Turn>)> = ALL.map(|of| (of, Vec::new())).into();
    turns.extend(programs.brought.map(|_| (Contender::Brought, Vec::new())));
    let mut missed: Vec<Missed> = Vec::new();
    for round in 0..rounds {
        let mut order: Vec<usize> = (0..turns.len()).collect();
        if round % 2 == 1 {
            order.reverse();
        }
        let turns_a_round = order.len();
        for (turn, index) in order.into_iter().enumerate() {
            let (contender, of) = &mut turns[index];
            let name = programs.name_of(*contender);
            let of_round = turn as f64 / turns_a_round as f64;
            progress.share(
                (f64::from(round) + of_round) / f64::from(rounds),
                &format!("round {}, {name}", round + 1),
            );
            match contender.run(bed, plan, programs, work) {
                Ok(turn) => of.push(turn),
                Err(error) => missed.push(Missed::of(&name, contender.is_needed(), error)?),
            }
        }
        // What has failed once does not run again.
        turns.retain(|(contender, _)| {
            let name = programs.name_of(*contender);
            missed.iter().all(|of| of.what != name)
        });
    }
    let exact_bed = native::after(bed, Mode::Exact, plan.compared_after())?;
    let spread_of = |wanted: Contender| {
        let (_, turns) = turns.iter().find(|(contender, _)| *contender == wanted)?;
        spread(turns)
    };
    let (exact, free) = (spread_of(Contender::Exact), spread_of(Contender::Free));
    let mut contests = Vec::new();
    for (contender, of) in &turns {
        let (Some(seconds_per_step), Some(last)) = (spread(of), of.last()) else {
            continue;
        };
        let over = |base: &Option<Spread>| Spread::ratio(&seconds_per_step, base.as_ref()?);
        let shares = of.iter().filter_map(|turn| turn.window.processor_share());
        contests.push(Contest {
            contender: *contender,
            name: programs.name_of(*contender),
            version: last.version.clone(),
            steps: last.window.steps,
            processor_share: shares.min_by(f64::total_cmp),
            over_exact: over(&exact),
            over_free: over(&free),
            peak_memory: last.peak_memory,
            shares: last.shares.clone(),
            approximations: programs.approximations_of(*contender),
            sanity: contender.check(last, programs, bed, &exact_bed)?,
            seconds_per_step,
        });
    }
    let sorted = turns
        .iter()
        .find(|(contender, _)| *contender == Contender::YadeSorted)
        .and_then(|(_, turns)| turns.last()?.bed.as_ref());
    let against = |(bodies, _): &(Bodies, usize)| {
        bits::bodies("positions and velocities", &exact_bed.bodies, bodies)
    };
    Ok(Rounds {
        sorted_bits: sorted.map(against),
        contests,
        missed,
    })
}

fn spread(turns: &[Turn]) -> Option<Spread> {
    Spread::of(
        turns
            .iter()
            .map(|turn| turn.window.seconds_per_step())
            .collect(),
    )
}
