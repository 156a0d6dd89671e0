//! Punches that are watched: pushed in to the end whatever the force, or stopped at the force and left standing.

use serde::{Deserialize, Serialize};

use super::plan::NARROW;
use crate::engine::EngineError;
use crate::study::realization::Change::{Alpha, Friction, Hold, Size, Speed};
use crate::study::realization::{Change, Specification, changed, went_wrong};
use grains::generate::initial_bodies;
use grains::native;
use grains::scene::Scene;
use grains::tables::{BodyIds, Contact, Snapshot, Stage, StopReason};
use grains::task::{Observer, Task};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// It goes on to the scene's give-up depth, whatever the force is.
    Through,
    /// It stops at the scene's force and stands still for half a second.
    Stand,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Penetration {
    pub name: String,
    pub kind: Kind,
    /// Its realization is replaced.
    pub scene: Scene,
    /// Clouds from 1 to this one.
    pub clouds: u64,
}

/// Depths of a window, m.
pub const DEPTH_WINDOW: f64 = 0.01;
/// Times after the stop, s: windows are between one and the next.
pub const TIMES: [f64; 10] = [
    0.0, 1.0e-3, 2.0e-3, 5.0e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.51,
];
/// So deep goes a punch that nothing stops, m: as deep as the paper's points.
const DEEP: f64 = 0.11;
const STANDING: f64 = 0.5;
/// More than any bed bears, Pa.
const NEVER_REACHED: f64 = 1.0e12;

/// What is varied: speed of the punch, m/s; damping number; friction angle, rad.
type Varied = (f64, f64, f64);

impl Penetration {
    pub fn all(base: &Scene, clouds: u64) -> Vec<Penetration> {
        let narrow = &changed(base.clone(), &[Size(NARROW, 1.0)]);
        let of_alpha = |alpha, speeds: &[f64]| {
            let through = |speed| Penetration::through(base, (speed, alpha, 0.0), DEEP, clouds);
            speeds.iter().copied().map(through).collect::<Vec<_>>()
        };
        let stand = |speed, alpha| Penetration::stand(base, (speed, alpha, 0.0), clouds);
        let mut all = of_alpha(0.2, &[0.01, 0.02, 0.05, 0.1]);
        all.extend(of_alpha(0.05, &[0.02, 0.1]));
        all.extend(of_alpha(0.8, &[0.02, 0.1]));
        all.push(Penetration::through(narrow, (0.1, 0.2, 0.3), DEEP, clouds));
        all.extend([stand(0.05, 0.2), stand(0.1, 0.2), stand(0.1, 0.8)]);
        all.push(Penetration::stand(narrow, (0.1, 0.2, 0.3), clouds));
        all
    }

    /// Of a small bed.
    pub fn quick(base: &Scene, clouds: u64) -> Vec<Penetration> {
        let through = |speed| Penetration::through(base, (speed, 0.2, 0.0), 0.1, clouds);
        let stand = Penetration::stand(base, (0.1, 0.2, 0.0), clouds);
        vec![through(0.05), through(0.1), through(0.2), stand]
    }

    /// Pushed in to this depth, m.
    pub fn through(base: &Scene, varied: Varied, depth: f64, clouds: u64) -> Penetration {
        let mut of = Penetration::new(base, Kind::Through, varied, &[], clouds);
        of.scene.loading.pressure = NEVER_REACHED;
        of.scene.loading.give_up_depth = depth;
        of.scene.measurement.history_every = 100;
        of
    }

    /// Stopped at the scene's force.
    pub fn stand(base: &Scene, varied: Varied, clouds: u64) -> Penetration {
        let mut of = Penetration::new(base, Kind::Stand, varied, &[Hold(STANDING)], clouds);
        of.scene.measurement.history_every = 10;
        of
    }

    fn new(
        base: &Scene,
        kind: Kind,
        (speed, alpha, friction): Varied,
        more: &[Change],
        clouds: u64,
    ) -> Self {
        let varied = [Speed(speed), Alpha(alpha), Friction(friction)];
        let scene = changed(base.clone(), &varied);
        let mut name = format!("{speed} m/s, α = {alpha}");
        if friction > 0.0 {
            name += &format!(", φ = {friction} rad");
        }
        Penetration {
            name,
            kind,
            scene: changed(scene, more),
            clouds,
        }
    }

    /// What is run, without its name.
    pub fn digest(&self) -> String {
        Specification::native(self.scene.clone()).digest()
    }

    /// m/s.
    pub fn speed(&self) -> f64 {
        self.scene.loading.speed
    }
}

/// What a punch met in one window of depth, or of time after it stopped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    pub from: f64,
    pub to: f64,
    /// Mean force on the punch over its width, Pa.
    pub pressure: f64,
    /// The largest that was seen, Pa.
    pub largest: f64,
    /// What the floor bears more than under gravity alone, over the punch's width, Pa.
    pub on_floor: f64,
    pub moments: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Watched {
    /// Digest of the [`Penetration`].
    pub penetration: String,
    pub realization: u64,
    /// Why loading ended; none where the engine gave up.
    pub stop: Option<StopReason>,
    /// Words of an engine that gave up.
    pub failed: Option<String>,
    /// Of a standing punch: the depth at which the force was reached, m.
    pub depth: Option<f64>,
    /// Those with moments in them, in order.
    pub windows: Vec<Window>,
}

struct Moment {
    step: u64,
    depth: f64,
    standing: bool,
    force: f64,
    on_floor: f64,
}

struct Watch {
    floor: u32,
    moments: Vec<Moment>,
}

impl Observer for Watch {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        if let (Stage::Load, Some(punch)) = (snapshot.stage, &snapshot.punch) {
            self.moments.push(Moment {
                step: snapshot.step,
                depth: punch.depth(),
                standing: punch.velocity == 0.0,
                force: punch.force,
                on_floor: on_floor(&snapshot.contacts, self.floor),
            });
        }
    }
}

/// N.
fn on_floor(contacts: &[Contact], floor: u32) -> f64 {
    let on_floor = contacts.iter().filter(|contact| contact.id1 == floor);
    on_floor.map(|contact| contact.normal_force).sum()
}

/// Runs a punch on a cloud and watches it.
pub fn watch(of: &Penetration, realization: u64) -> Result<Watched, EngineError> {
    let scene = Scene {
        realization,
        ..of.scene.clone()
    };
    let mut watch = Watch {
        floor: BodyIds::of_box(scene.particles.count).floor(),
        moments: Vec::new(),
    };
    let initial = initial_bodies(&scene);
    let weight: f64 = scene.gravity * initial.mass.iter().sum::<f64>();
    let mut watched = Watched {
        penetration: of.digest(),
        realization,
        stop: None,
        failed: None,
        depth: None,
        windows: Vec::new(),
    };
    let options = native::Options::default();
    let outcome = match native::run(&scene, &Task::whole(initial), &options, &mut watch) {
        Ok(outcome) => outcome,
        Err(error) => {
            watched.failed = Some(went_wrong(EngineError::Native(error))?);
            return Ok(watched);
        }
    };
    let last = outcome.stages.last();
    watched.stop = last.map(|stage| stage.stop);
    let width = 2.0 * scene.loading.half_width;
    let mut add = |from: f64, to: f64, place: &dyn Fn(&Moment) -> Option<f64>| {
        let within = |of: &&Moment| place(of).is_some_and(|at| from <= at && at < to);
        let within: Vec<&Moment> = watch.moments.iter().filter(within).collect();
        let all = |of: fn(&Moment) -> f64| within.iter().map(move |moment| of(moment));
        let mean = |of| all(of).sum::<f64>() / within.len() as f64;
        if !within.is_empty() {
            watched.windows.push(Window {
                from,
                to,
                pressure: mean(|moment| moment.force) / width,
                largest: all(|moment| moment.force).fold(0.0, f64::max) / width,
                on_floor: (mean(|moment| moment.on_floor) - weight) / width,
                moments: within.len() as u32,
            });
        }
    };
    match of.kind {
        Kind::Through => {
            let deepest = scene.loading.give_up_depth;
            let windows = (deepest / DEPTH_WINDOW).round() as u32;
            for window in 0..windows {
                let from = f64::from(window) * DEPTH_WINDOW;
                add(from, from + DEPTH_WINDOW, &|moment| Some(moment.depth));
            }
        }
        Kind::Stand if watched.stop == Some(StopReason::Reached) => {
            let steps = last.map_or(0, |stage| stage.steps);
            let stopped = steps - scene.steps_standing_still().unwrap_or(0).min(steps);
            let dt = scene.time_step_seconds();
            for pair in TIMES.windows(2) {
                add(pair[0], pair[1], &|moment| {
                    let since = moment.step.checked_sub(stopped)?;
                    moment.standing.then_some(since as f64 * dt)
                });
            }
            watched.depth = watch.moments.last().map(|moment| moment.depth);
        }
        Kind::Stand => {}
    }
    Ok(watched)
}
