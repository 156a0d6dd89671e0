//! Which methods are charted, and which of them are put to the test as faster protocols.

use super::method::*;
use grains::native::Mode;
use grains::native::pouring::{End, Phase, Softly};
use grains::scene::Scene;

/// Bed and punch of the paper; realizations are put in later.
const GRAINS: u32 = 5000;

/// What is run.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What all others are compared with.
    pub reference: Method,
    /// All others, in the order of the chart's numbers.
    pub methods: Vec<Planned>,
    /// Realizations of the chart, from 1 on.
    pub charting: u64,
    /// Realizations of the test of equivalence, from [`FIRST_CONFIRMING`] on.
    pub confirming: u64,
}

/// A method and how much of it is run.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// What is run.
    pub method: Method,
    /// Realizations of the chart; dear methods have fewer.
    pub charting: u64,
    /// Whether its equivalence to the reference is tested on realizations of its own.
    pub candidate: bool,
}

/// The clouds of the test are none that helped to choose what is tested.
pub const FIRST_CONFIRMING: u64 = 1001;

/// α of the paper's scene.
const ALPHA: f64 = 0.2;
/// Half of the paper scene's step, for engines that are brought.
const SHORT_STEP: f64 = 0.225;
/// The largest step of the combined methods, and that of [`free_mode_scene`].
const LONG_STEP: f64 = 0.65;

/// The paper's scene with the choices that are the free mode's default: those of the candidate of that step, which
/// was tested to be equivalent.
pub fn free_mode_scene(realization: u64, grains: u32) -> Scene {
    let mut scene = with_step(grains::scene::paper_scene(realization, grains), LONG_STEP);
    scene.choices.insert(
        "/time_step".to_owned(),
        format!(
            "not printed; {LONG_STEP} of sqrt(m/k) was tested to be equivalent to 0.45 (crossgrain pareto)"
        ),
    );
    scene
}

impl Plan {
    /// The whole chart of the paper's scene.
    pub fn full(charting: u64, confirming: u64, yade: u64) -> Self {
        let scene = || grains::scene::paper_scene(1, GRAINS);
        let mut plan = Plan::of(&scene(), charting, confirming);
        let add = |methods: &mut Vec<Planned>, method, share: u64| {
            methods.push(Planned {
                method,
                charting: charting.div_ceil(share),
                candidate: false,
            });
        };
        let methods = &mut plan.methods;
        for (step, share) in [
            (0.05, 4),
            (0.1, 2),
            (0.2, 1),
            (0.3, 1),
            (0.6, 1),
            (0.65, 1),
            (0.7, 1),
            (0.8, 1),
            (0.9, 1),
            (1.0, 1),
        ] {
            add(
                methods,
                exact(
                    &format!("step {step}"),
                    Family::Step,
                    with_step(scene(), step),
                ),
                share,
            );
        }
        for (mode, step) in [(Mode::Free, 0.45), (Mode::Single, 0.45)] {
            let name = format!("{} mode", mode.name());
            add(
                methods,
                Method::plain(&name, Family::Mode, mode, with_step(scene(), step)),
                1,
            );
        }
        for (name, share) in [("E/10", 0.1), ("E/100", 0.01)] {
            add(
                methods,
                exact(
                    &format!("{name} throughout"),
                    Family::Soft,
                    with_modulus(scene(), share),
                ),
                2,
            );
        }
        for (name, start, ratio) in [
            ("poured at E/10, stiffened at once", 0.1, 10.0),
            ("poured at E/10, stiffened in steps of 2", 0.1, 2.0),
            ("poured at E/100, stiffened at once", 0.01, 100.0),
            ("poured at E/100, stiffened in steps of 2", 0.01, 2.0),
        ] {
            let soft = Softly {
                start,
                ratio,
                until: 1.0e-4,
                alpha: ALPHA,
                step: 0.45,
            };
            add(
                methods,
                softly(&soft, name, Family::Soft, Mode::Exact, &scene()),
                1,
            );
        }
        for (width, depth) in [(0.4, 1.0), (0.5, 1.0), (0.7, 1.0), (1.0, 0.5), (1.0, 0.75)] {
            let name = format!(
                "{} of the width, {} of the depth",
                percent(width),
                percent(depth)
            );
            add(
                methods,
                exact(&name, Family::Size, with_size(scene(), width, depth)),
                1,
            );
        }
        for (tolerance, share) in [
            (1.0e-3, 1),
            (3.0e-4, 1),
            (3.0e-5, 1),
            (1.0e-5, 2),
            (1.0e-6, 4),
        ] {
            let name = format!("settled at {tolerance:e}");
            add(
                methods,
                exact(&name, Family::Settle, with_tolerance(scene(), tolerance)),
                share,
            );
        }
        for (alpha, share) in [(0.05, 1), (0.1, 1), (0.4, 1), (0.7, 2)] {
            let name = format!("α = {alpha} throughout");
            add(
                methods,
                exact(&name, Family::Damping, with_alpha(scene(), alpha)),
                share,
            );
        }
        for (alpha, share) in [(0.05, 1), (0.1, 1), (0.4, 1)] {
            let name = format!("poured with α = {alpha}");
            add(methods, poured_with(&name, alpha, &scene()), share);
        }
        for (columns, speed) in [(85, 0.3), (90, 0.3), (94, 0.3), (80, 0.0), (80, 1.0)] {
            let name = format!("cloud of {columns} columns at {speed} m/s");
            add(
                methods,
                exact(&name, Family::Cloud, with_cloud(scene(), columns, speed)),
                1,
            );
        }
        plan.candidates(&scene(), charting);
        if yade > 0 {
            plan.methods.push(Planned {
                method: in_yade(scene()),
                charting: yade,
                candidate: false,
            });
        }
        plan
    }

    /// A small bed, a few methods: that all parts work, and the large effects.
    pub fn quick(charting: u64, yade: u64) -> Self {
        let scene = small_scene;
        let mut plan = Plan::of(&scene(), charting, 0);
        for (name, family, scene) in [
            ("step 0.1", Family::Step, with_step(scene(), 0.1)),
            ("step 0.65", Family::Step, with_step(scene(), 0.65)),
            ("step 0.9", Family::Step, with_step(scene(), 0.9)),
            (
                "E/100 throughout",
                Family::Soft,
                with_modulus(scene(), 0.01),
            ),
            (
                "settled at 1e-3",
                Family::Settle,
                with_tolerance(scene(), 1.0e-3),
            ),
            (
                "settled at 1e-5",
                Family::Settle,
                with_tolerance(scene(), 1.0e-5),
            ),
            (
                "α = 0.4 throughout",
                Family::Damping,
                with_alpha(scene(), 0.4),
            ),
        ] {
            plan.methods.push(Planned {
                method: exact(name, family, scene),
                charting,
                candidate: false,
            });
        }
        for mode in [Mode::Free, Mode::Single] {
            plan.methods.push(Planned {
                method: Method::plain(
                    &format!("{} mode", mode.name()),
                    Family::Mode,
                    mode,
                    scene(),
                ),
                charting,
                candidate: false,
            });
        }
        plan.candidates(&scene(), charting);
        if yade > 0 {
            plan.methods.push(Planned {
                method: in_yade(scene()),
                charting: yade,
                candidate: false,
            });
        }
        plan
    }

    /// Adds the reference's scene, and two other steps, in an engine that was brought, on so many clouds.
    pub fn with_brought(mut self, engine: &Program, charting: u64) -> Self {
        let label = engine.described.label();
        let scene = &self.reference.scene;
        for step in [None, Some(SHORT_STEP), Some(LONG_STEP)] {
            let (name, scene) = match step {
                None => (label.clone(), scene.clone()),
                Some(step) => (
                    format!("{label}, step {step}"),
                    with_step(scene.clone(), step),
                ),
            };
            self.methods.push(Planned {
                method: Method {
                    runner: Runner::Brought,
                    engine: Some(engine.clone()),
                    ..exact(&name, Family::Brought, scene)
                },
                charting,
                candidate: false,
            });
        }
        self
    }

    fn of(scene: &Scene, charting: u64, confirming: u64) -> Self {
        Plan {
            reference: exact(
                "exact mode, the scene as it is",
                Family::Reference,
                scene.clone(),
            ),
            methods: Vec::new(),
            charting,
            confirming,
        }
    }

    /// The protocols that might become the free mode's default, cheapest last.
    fn candidates(&mut self, scene: &Scene, charting: u64) {
        let mode = Mode::Free;
        let plain = |name: &str, step| {
            Method::plain(name, Family::Combined, mode, with_step(scene.clone(), step))
        };
        let soft = |name: &str, start, until| {
            let soft = Softly {
                start,
                ratio: start.recip().sqrt(),
                until,
                alpha: ALPHA,
                step: LONG_STEP,
            };
            softly(&soft, name, Family::Combined, mode, scene)
        };
        // The last two were too dense or no cheaper in the first charts, so nothing is spent on testing them.
        for (method, candidate) in [
            (plain("free mode, step 0.65", LONG_STEP), true),
            (
                soft("free mode, step 0.65, E/10 until 1e-3", 0.1, 1.0e-3),
                true,
            ),
            (
                soft("free mode, step 0.65, E/10 until 3e-3", 0.1, 3.0e-3),
                true,
            ),
            (plain("free mode, step 0.6", 0.6), false),
            (
                soft("free mode, step 0.65, E/10 until 1e-2", 0.1, 1.0e-2),
                false,
            ),
            (
                soft("free mode, step 0.65, E/100 until 1e-2", 0.01, 1.0e-2),
                false,
            ),
        ] {
            self.methods.push(Planned {
                method,
                charting,
                candidate,
            });
        }
    }
}

/// The paper's scene, 0.4 m wide with half of the depth and the points at half the distances.
fn small_scene() -> Scene {
    let mut scene = with_size(grains::scene::paper_scene(1, GRAINS), 0.4, 0.5);
    for point in &mut scene.control_points {
        point.offset *= 0.5;
    }
    scene
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn exact(name: &str, family: Family, scene: Scene) -> Method {
    Method::plain(name, family, Mode::Exact, scene)
}

fn in_yade(scene: Scene) -> Method {
    Method {
        runner: Runner::YadeOrdinary,
        ..exact("YADE, ordinary loop", Family::Yade, scene)
    }
}

/// Another α while pouring, the scene's while loading.
fn poured_with(name: &str, alpha: f64, scene: &Scene) -> Method {
    Method {
        phases: vec![Phase {
            modulus: 1.0,
            alpha,
            step: 0.45,
            end: End::Settled(scene.settle.kinetic_energy_fraction),
        }],
        ..exact(name, Family::Damping, scene.clone())
    }
}

fn softly(of: &Softly, name: &str, family: Family, mode: Mode, scene: &Scene) -> Method {
    Method {
        phases: of.phases(scene),
        ..Method::plain(name, family, mode, with_step(scene.clone(), of.step))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains::scene::parse_scene;

    #[test]
    fn every_scene_is_valid_and_every_method_is_itself() {
        for plan in [Plan::full(24, 100, 1), Plan::quick(4, 1)] {
            let mut digests = vec![plan.reference.digest()];
            for planned in &plan.methods {
                let text = serde_json::to_string(&planned.method.scene).expect("a scene");
                let read = parse_scene(&text);
                assert!(read.is_ok(), "{}: {read:?}", planned.method.name);
                let digest = planned.method.digest();
                assert!(!digests.contains(&digest), "{}", planned.method.name);
                digests.push(digest);
            }
        }
    }
}
