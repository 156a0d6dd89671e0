//! The native step with a clock between its stages: the same operations in the same order as
//! `Dynamics::step` of the frictionless exact kernel, for finding out where its time goes.

use std::time::{Duration, Instant};

use super::constants::Constants;
use super::dynamics::Dynamics;
use super::health::Trouble;
use super::kernel;
use super::stages::SKIN_OVER_RADIUS;
use crate::engine::timing::Share;
use crate::model::Model;
use crate::tables::{Bodies, Stage};

/// Where the time of a step goes, and what it was spent on.
#[derive(Debug, Clone, PartialEq)]
pub struct Clocked {
    /// Of the time of all steps, in the order of the step; they add to 1.
    pub shares: Vec<Share>,
    /// Listed pairs of grains at the end.
    pub listed_pairs: usize,
    /// Those of them that touch.
    pub touching_pairs: usize,
    /// How often the neighbour list was built in these steps.
    pub builds: u64,
    /// The grains afterwards; the same bits as by an ordinary run.
    pub bodies: Bodies,
}

/// Times the stages of so many steps of a frictionless bed; `mean_radius` in m.
pub fn stages_of_a_step(
    model: &Model,
    bodies: &Bodies,
    mean_radius: f64,
    steps: u64,
) -> Result<Clocked, Trouble> {
    let constants = Constants::new(model, bodies.len() as u32);
    let skin = SKIN_OVER_RADIUS * mean_radius;
    let mut dynamics = Dynamics::new(bodies, None, constants, skin)?;
    let builds = dynamics.neighbours.builds;
    let mut clock = Clock::default();
    for _ in 0..steps {
        clocked_step(&mut dynamics, &mut clock)?;
    }
    let contacts = dynamics.snapshot(Stage::Settle, steps).contacts;
    let grains = bodies.len() as u32;
    Ok(Clocked {
        shares: clock.shares(),
        listed_pairs: dynamics.neighbours.other.len(),
        touching_pairs: contacts.iter().filter(|of| of.id1 < grains).count(),
        builds: dynamics.neighbours.builds - builds,
        bodies: dynamics.state.bodies(),
    })
}

const STAGES: [&str; 5] = [
    "integration",
    "neighbour lists",
    "forces of pairs",
    "sums over pairs",
    "walls",
];

#[derive(Default)]
struct Clock {
    spent: [Duration; STAGES.len()],
}

impl Clock {
    fn time<T>(&mut self, stage: usize, work: impl FnOnce() -> T) -> T {
        let began = Instant::now();
        let result = work();
        self.spent[stage] += began.elapsed();
        result
    }

    fn shares(&self) -> Vec<Share> {
        let total: Duration = self.spent.iter().sum();
        STAGES
            .iter()
            .zip(&self.spent)
            .map(|(stage, spent)| Share {
                stage: (*stage).to_owned(),
                share: spent.as_secs_f64() / total.as_secs_f64(),
            })
            .collect()
    }
}

fn clocked_step(dynamics: &mut Dynamics, clock: &mut Clock) -> Result<(), Trouble> {
    let Constants {
        dt, gravity, alpha, ..
    } = dynamics.constants;
    let limit = dynamics.neighbours.displacement_limit_squared(None);
    let within = clock.time(0, || {
        let reference = &dynamics.neighbours.reference;
        kernel::integrate(&mut dynamics.state, reference, dt, gravity, alpha, limit)
    });
    if !within {
        clock.time(1, || dynamics.list_neighbours())?;
    }
    clock.time(2, || {
        kernel::pair_forces(
            &dynamics.state.position,
            &dynamics.neighbours,
            &mut dynamics.pair_force,
        );
    });
    clock.time(3, || {
        dynamics.state.force.fill([0.0; 2]);
        kernel::sum_pair_forces(
            &dynamics.neighbours,
            &dynamics.pair_force,
            &mut dynamics.state.force,
        );
    });
    clock.time(4, || add_wall_forces(dynamics));
    Ok(())
}

fn add_wall_forces(dynamics: &mut Dynamics) {
    let Dynamics {
        state,
        constants,
        neighbours,
        ..
    } = dynamics;
    for (wall, near) in constants.walls.iter().zip(&neighbours.by_wall) {
        for &id in near {
            let id = id as usize;
            if let Some(touch) = state.wall_touch(wall, id) {
                let force = touch.spring_force(state.flat_stiffness(constants, id));
                state.force[id][0] += force[0];
                state.force[id][1] += force[1];
            }
        }
    }
}
