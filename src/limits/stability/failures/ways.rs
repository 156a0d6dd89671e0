//! The ways to fail, with what must come of each.

use super::{Came, GRAINS, Mode, run, small_bed};
use crate::limits::stability::automatic;
use grains::measure::{Bed, unbalanced_force};
use grains::native::Trouble;
use grains::scene::{Cloud, Damping, Scene, TimeStep, paper_scene};
use grains::tables::StopReason;

/// All of them, in the order of the page.
pub(super) fn all() -> Vec<Mode> {
    let base = small_bed();
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = base.clone();
        change(&mut scene);
        scene
    };
    vec![
        Mode {
            name: "step-beyond-limit",
            title: "twice the largest stable step",
            scene: changed(&|scene| {
                scene.time_step = TimeStep::Fraction {
                    of_sqrt_m_over_k: 1.7,
                };
            }),
            in_yade: true,
            judge: |came, _| {
                (
                    matches!(
                        came.trouble(),
                        Some(
                            Trouble::EnergyBlownUp { .. }
                                | Trouble::Lost { .. }
                                | Trouble::BeyondRadius { .. }
                        )
                    ),
                    "energy grows out of nothing until grains fly apart".to_owned(),
                    "the limit on the kinetic energy, looked at every 1000 steps, or the box",
                )
            },
        },
        Mode {
            name: "step-just-beyond-limit",
            title: "a tenth more than the largest stable step",
            scene: changed(&|scene| {
                let bed = automatic::choose(scene, 1.0);
                let limit = bed.map_or(f64::NAN, |choice| choice.limit);
                scene.time_step = TimeStep::Absolute {
                    seconds: 1.1 * limit,
                };
            }),
            in_yade: false,
            judge: |came, scene| {
                let share = match came {
                    Came::Ended(outcome) => {
                        let bed = outcome.settled.as_ref().unwrap_or(&outcome.last);
                        automatic::share_of_limit(scene, &bed.bodies)
                    }
                    Came::Troubled(_) => Ok(None),
                };
                let share = share.ok().flatten().unwrap_or(f64::NAN);
                (
                    share > 1.0,
                    format!(
                        "the bed settles all the same: what grows opens its own contacts and stops there; unbalanced force \
                         {:.2} of the mean contact force at the end",
                        unbalanced_at_end(came, scene)
                    ),
                    "the limit of the settled bed, which `crossgrain run` works out at the end of every run",
                )
            },
        },
        Mode {
            name: "overlap-beyond-radius",
            title: "grains far too soft for their sizes (E = 10 MPa, radii from 0.2 to 1.8 of the mean)",
            scene: changed(&|scene| {
                scene.material.youngs_modulus = 1.0e7;
                scene.particles.dispersion = 0.8;
                let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
                *columns = 5;
                scene.time_step = TimeStep::Absolute { seconds: 2.0e-5 };
            }),
            in_yade: true,
            judge: |came, _| {
                let deep = match came.trouble() {
                    Some(Trouble::BeyondRadius {
                        overlap, radius, ..
                    }) => overlap / radius,
                    _ => f64::NAN,
                };
                (
                    deep > 1.0,
                    format!("large grains swallow small ones: {deep:.2} radii when it is seen"),
                    "every moment of the history",
                )
            },
        },
        Mode {
            name: "tunnelling",
            title: "grains that move five radii a step",
            scene: changed(&|scene| {
                let Cloud::JitteredLattice { speed, .. } = &mut scene.cloud;
                *speed = 5.0 * 0.005 / base_step();
            }),
            in_yade: true,
            judge: |came, _| {
                (
                    matches!(came.trouble(), Some(Trouble::Lost { .. })),
                    "a grain is on one side of a wall before a step and on the other after it"
                        .to_owned(),
                    "the box, at every rebuild of the neighbour list and every moment of the history",
                )
            },
        },
        Mode {
            name: "fast-punch",
            title: "a punch at 1 m/s, ten times the paper's scene's",
            scene: changed(&|scene| scene.loading.speed = 1.0),
            in_yade: false,
            judge: |came, scene| {
                let unbalanced = unbalanced_at_end(came, scene);
                (
                    came.stop() == Some(StopReason::Reached) && unbalanced > 0.1,
                    format!(
                        "the load is reached by the inertia of the grains: unbalanced force {unbalanced:.2} of the mean \
                         contact force"
                    ),
                    "the measure of the unbalanced force in run.json",
                )
            },
        },
        Mode {
            name: "stiffness-contrast",
            title: "radii from 0.05 to 1.95 of the mean, a step for the mean grain",
            scene: contrast(),
            in_yade: false,
            judge: |came, scene| {
                let chosen = automatic::choose(scene, automatic::DEFAULT_SHARE);
                let cured = chosen.map(|choice| {
                    let better = automatic::with_step(scene, &choice);
                    let again = run(&better);
                    let ended = matches!(&again, Ok(came @ Came::Ended(_)) if came.is_finite());
                    (ended, choice.time_step / scene.time_step_seconds())
                });
                let (ended, share) = cured.unwrap_or((false, f64::NAN));
                (
                    came.trouble().is_some() && ended,
                    format!(
                        "the smallest grains are too fast for the step; the automatic step, {share:.3} of it, runs to the end"
                    ),
                    "the limit on the kinetic energy, or the box",
                )
            },
        },
        Mode {
            name: "zero-damping",
            title: "no damping of any kind",
            scene: changed(&|scene| scene.damping = Damping::Cundall { alpha: 0.0 }),
            in_yade: false,
            judge: |came, _| {
                (
                    came.stop() == Some(StopReason::MaxSteps),
                    "nothing takes energy out: the grains stay a gas".to_owned(),
                    "the scene's largest number of steps; exit code 3",
                )
            },
        },
        Mode {
            name: "never-at-rest",
            title: "a frictionless bed, nearly isostatic, asked for 10⁻³⁰ of its energy",
            scene: changed(&|scene| {
                scene.settle.kinetic_energy_fraction = 1.0e-30;
                scene.settle.max_steps = 60_000;
            }),
            in_yade: false,
            judge: |came, scene| {
                (
                    came.stop() == Some(StopReason::MaxSteps),
                    format!(
                        "it creeps on: unbalanced force {:.1e} of the mean contact force",
                        unbalanced_at_end(came, scene)
                    ),
                    "the scene's largest number of steps; exit code 3",
                )
            },
        },
        Mode {
            name: "load-too-large",
            title: "a pressure of 1 GPa on a shallow bed",
            scene: changed(&|scene| scene.loading.pressure = 1.0e9),
            in_yade: true,
            judge: |came, _| {
                (
                    came.stop() == Some(StopReason::SankToGiveUpDepth),
                    "the grains give way and the punch goes on down".to_owned(),
                    "the scene's give-up depth",
                )
            },
        },
    ]
}

/// The step of the paper's grains, s.
pub(super) fn base_step() -> f64 {
    paper_scene(1, GRAINS).time_step_seconds()
}

/// A wide range of sizes. One modulus rules all bodies, so stiffness differs with the radius only.
fn contrast() -> Scene {
    let mut scene = small_bed();
    scene.particles.dispersion = 0.95;
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 5;
    scene
}

fn unbalanced_at_end(came: &Came, scene: &Scene) -> f64 {
    let Came::Ended(outcome) = came else {
        return f64::NAN;
    };
    let bed = Bed {
        bodies: &outcome.last.bodies,
        contacts: &outcome.last.contacts,
    };
    unbalanced_force::of(scene, bed).unwrap_or(f64::NAN)
}
