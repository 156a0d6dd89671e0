//! Which methods are compared, and which of them are put to the test as faster protocols.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::study::realization::Change::{Alpha, CloudSpeed, Columns, Modulus, Settled, Size, Step};
use crate::study::realization::{
    Change, FREE_MODE_STEP, Runner, Setting, Specification, changed, small_scene, whole_scene,
};
use grains::native::Mode;
use grains::native::pouring::{End, Phase, Softly};
use grains::scene::Scene;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    pub reference: Setting,
    /// All others. Those with clouds from [`FIRST_CONFIRMATORY`] on are candidates, whose equivalence is tested on these.
    pub methods: Vec<Setting>,
    /// Realizations of a method, from 1 on; expensive ones have fewer.
    pub screening: u64,
    /// Realizations of each test of equivalence.
    pub confirmatory: u64,
    #[serde(skip)]
    tasks: OnceLock<Vec<(usize, u64)>>,
}

/// The clouds of a test are none that helped to choose what is tested.
pub const FIRST_CONFIRMATORY: u64 = 1001;

/// The candidate that is the free mode's default: `run --mode free --reduced-stiffness` (`docs/tradeoff.md`).
pub const DEFAULT: &str = "free-0.65-soft-10-1e-3";

const ALPHA: f64 = 0.2;
/// Half of the paper scene's step, for external engines.
const SHORT_STEP: f64 = 0.225;

const SOFT: &str = "softened contacts";
const DAMPING: &str = "damping";
const COMBINED: &str = "combined";

/// In exact mode: id, name, what is changed, share of the clouds.
type Cases = &'static [(&'static str, &'static str, Change, u64)];

const STEPS: Cases = &[
    ("step-0.05", "step 0.05", Step(0.05), 4),
    ("step-0.1", "step 0.1", Step(0.1), 2),
    ("step-0.2", "step 0.2", Step(0.2), 1),
    ("step-0.3", "step 0.3", Step(0.3), 1),
    ("step-0.6", "step 0.6", Step(0.6), 1),
    ("step-0.65", "step 0.65", Step(0.65), 1),
    ("step-0.7", "step 0.7", Step(0.7), 1),
    ("step-0.8", "step 0.8", Step(0.8), 1),
    ("step-0.9", "step 0.9", Step(0.9), 1),
    ("step-1", "step 1", Step(1.0), 1),
];
const MODULI: Cases = &[
    ("modulus-10", "E/10 throughout", Modulus(0.1), 2),
    ("modulus-100", "E/100 throughout", Modulus(0.01), 2),
];
const SIZES: Cases = &[
    ("width-40", "40 % of the width", Size(0.4, 1.0), 1),
    ("width-50", "50 % of the width", Size(0.5, 1.0), 1),
    ("width-70", "70 % of the width", Size(0.7, 1.0), 1),
    ("depth-50", "50 % of the depth", Size(1.0, 0.5), 1),
    ("depth-75", "75 % of the depth", Size(1.0, 0.75), 1),
];
const SETTLE_RULES: Cases = &[
    ("settled-1e-3", "settled at 1e-3", Settled(1.0e-3), 1),
    ("settled-3e-4", "settled at 3e-4", Settled(3.0e-4), 1),
    ("settled-3e-5", "settled at 3e-5", Settled(3.0e-5), 1),
    ("settled-1e-5", "settled at 1e-5", Settled(1.0e-5), 2),
    ("settled-1e-6", "settled at 1e-6", Settled(1.0e-6), 4),
];
const ALPHAS: Cases = &[
    ("alpha-0.05", "α = 0.05 throughout", Alpha(0.05), 1),
    ("alpha-0.1", "α = 0.1 throughout", Alpha(0.1), 1),
    ("alpha-0.4", "α = 0.4 throughout", Alpha(0.4), 1),
    ("alpha-0.7", "α = 0.7 throughout", Alpha(0.7), 2),
];
const CLOUDS: Cases = &[
    ("columns-85", "cloud of 85 columns", Columns(85), 1),
    ("columns-90", "cloud of 90 columns", Columns(90), 1),
    ("columns-94", "cloud of 94 columns", Columns(94), 1),
    ("cloud-0", "cloud at 0 m/s", CloudSpeed(0.0), 1),
    ("cloud-1", "cloud at 1 m/s", CloudSpeed(1.0), 1),
];

/// Protocols that might become the free mode's default, cheapest last: step, by how much softer it is poured and to which
/// energy, whether it is tested. The last two were too dense or no cheaper at first sight, so nothing is spent on
/// testing them.
type Candidate = (f64, Option<(f64, f64)>, bool);
const CANDIDATES: [Candidate; 6] = [
    (FREE_MODE_STEP, None, true),
    (FREE_MODE_STEP, Some((10.0, 1.0e-3)), true),
    (FREE_MODE_STEP, Some((10.0, 3.0e-3)), true),
    (0.6, None, false),
    (FREE_MODE_STEP, Some((10.0, 1.0e-2)), false),
    (FREE_MODE_STEP, Some((100.0, 1.0e-2)), false),
];

/// Of [`Plan::quick`], besides the candidates.
const QUICK: [&str; 9] = [
    "step-0.1",
    "step-0.65",
    "step-0.9",
    "free",
    "single",
    "modulus-100",
    "settled-1e-3",
    "settled-1e-5",
    "alpha-0.4",
];

impl Plan {
    /// Every method for the paper's scene; YADE on its first `yade` clouds.
    pub fn full(screening: u64, confirmatory: u64, yade: u64) -> Self {
        let mut plan = Plan::new(whole_scene(), screening, confirmatory);
        plan.add_all();
        plan.add_yade(yade);
        plan
    }

    /// A small bed, a few methods: that all parts work, and the large effects.
    pub fn quick(screening: u64, yade: u64) -> Self {
        let mut plan = Plan::new(small_scene(), screening, 0);
        plan.add_all();
        let kept = |of: &Setting| of.axis == COMBINED || QUICK.contains(&of.id.as_str());
        plan.methods.retain(kept);
        for method in &mut plan.methods {
            method.clouds = vec![[1, screening]];
        }
        plan.add_yade(yade);
        plan
    }

    /// The reference alone: the scene as it is, in exact mode. Against itself on other clouds it needs as many of those.
    pub fn new(scene: Scene, screening: u64, confirmatory: u64) -> Self {
        let name = "exact mode, the scene as it is";
        let of = Specification::native(Mode::Exact, scene);
        let mut reference = Setting::new("reference", name, "reference", of, screening);
        let others = screening.max(confirmatory);
        reference
            .clouds
            .push([FIRST_CONFIRMATORY, FIRST_CONFIRMATORY + others - 1]);
        Plan {
            reference,
            methods: Vec::new(),
            screening,
            confirmatory,
            tasks: OnceLock::new(),
        }
    }

    /// Adds a method, on a share of the clouds.
    pub fn add(&mut self, id: &str, name: &str, axis: &str, of: Specification, share: u64) {
        let clouds = self.screening.div_ceil(share);
        let method = Setting::new(id, name, axis, of, clouds);
        self.methods.push(method);
    }

    /// Makes a candidate of the method that was added last.
    pub fn test_last(&mut self) {
        let last = FIRST_CONFIRMATORY + self.confirmatory;
        if let Some(method) = self.methods.last_mut().filter(|_| self.confirmatory > 0) {
            method.clouds.push([FIRST_CONFIRMATORY, last - 1]);
        }
    }

    fn add_all(&mut self) {
        let scene = self.reference.specification.scene.clone();
        let native =
            |mode, changes: &[Change]| Specification::native(mode, changed(scene.clone(), changes));
        let soft = |mode, start: f64, ratio, until, step| {
            let softly = Softly {
                start,
                ratio,
                until,
                alpha: ALPHA,
                step,
            };
            Specification::soft(mode, &scene, &softly)
        };
        let add_cases = |plan: &mut Plan, axis, cases: Cases| {
            for (id, name, change, share) in cases {
                plan.add(id, name, axis, native(Mode::Exact, &[*change]), *share);
            }
        };
        add_cases(self, "time step", STEPS);
        for (id, mode) in [("free", Mode::Free), ("single", Mode::Single)] {
            self.add(id, &format!("{id} mode"), "mode", native(mode, &[]), 1);
        }
        add_cases(self, SOFT, MODULI);
        for softer in [10.0, 100.0] {
            let ways = [
                ("at-once", "at once", softer),
                ("by-2", "in steps of 2", 2.0),
            ];
            for (id, how, ratio) in ways {
                let of = soft(Mode::Exact, 1.0 / softer, ratio, 1.0e-4, 0.45);
                let name = format!("poured at E/{softer}, stiffened {how}");
                self.add(&format!("soft-{softer}-{id}"), &name, SOFT, of, 1);
            }
        }
        add_cases(self, "size", SIZES);
        add_cases(self, "settle rule", SETTLE_RULES);
        add_cases(self, DAMPING, ALPHAS);
        for alpha in [0.05, 0.1, 0.4] {
            // The scene's own α while loading.
            let phase = Phase {
                modulus: 1.0,
                alpha,
                step: 0.45,
                end: End::Settled(scene.settle.kinetic_energy_fraction),
            };
            let of = Specification {
                phases: vec![phase],
                ..native(Mode::Exact, &[])
            };
            let name = format!("poured with α = {alpha}");
            self.add(&format!("poured-alpha-{alpha}"), &name, DAMPING, of, 1);
        }
        add_cases(self, "cloud", CLOUDS);
        for (step, softly, tested) in CANDIDATES {
            let (id, name) = (format!("free-{step}"), format!("free mode, step {step}"));
            match softly {
                None => self.add(&id, &name, COMBINED, native(Mode::Free, &[Step(step)]), 1),
                Some((softer, until)) => {
                    let start = 1.0 / softer;
                    let of = soft(Mode::Free, start, softer.sqrt(), until, step);
                    let id = format!("{id}-soft-{softer}-{until:e}");
                    let name = format!("{name}, E/{softer} until {until:e}");
                    self.add(&id, &name, COMBINED, of, 1);
                }
            }
            if tested {
                self.test_last();
            }
        }
    }

    fn add_yade(&mut self, clouds: u64) {
        if clouds > 0 {
            let of = Specification {
                runner: Runner::YadeOrdinary,
                ..self.reference.specification.clone()
            };
            let name = "YADE, ordinary loop";
            let method = Setting::new("yade", name, "YADE", of, clouds);
            self.methods.push(method);
        }
    }

    /// Adds the reference's scene, and two other steps, in an external engine, on so many clouds; `digest` is that of its file.
    #[must_use]
    pub fn with_external(mut self, label: &str, digest: &str, clouds: u64) -> Self {
        for step in [None, Some(SHORT_STEP), Some(FREE_MODE_STEP)] {
            let mut of = Specification {
                runner: Runner::External,
                program: Some(digest.to_owned()),
                ..self.reference.specification.clone()
            };
            let (mut id, mut name) = ("external".to_owned(), label.to_owned());
            if let Some(step) = step {
                of.scene = changed(of.scene, &[Step(step)]);
                id += &format!("-step-{step}");
                name += &format!(", step {step}");
            }
            self.methods
                .push(Setting::new(&id, &name, "external engine", of, clouds));
        }
        self
    }

    /// The reference, then all others.
    pub fn settings(&self) -> Vec<&Setting> {
        let all = std::iter::once(&self.reference);
        all.chain(&self.methods).collect()
    }

    pub fn task(&self, number: u64) -> (&Setting, u64) {
        let (method, cloud) = self.tasks()[number as usize - 1];
        let other = method.checked_sub(1).map(|of| &self.methods[of]);
        (other.unwrap_or(&self.reference), cloud)
    }

    /// Every method on every cloud of its own, the first clouds first, so that a study that is looked at early has a little
    /// of everything.
    pub fn tasks(&self) -> &[(usize, u64)] {
        self.tasks.get_or_init(|| {
            let settings = self.settings();
            let clouds: BTreeSet<u64> = settings.iter().flat_map(|of| of.realizations()).collect();
            let on = |cloud| {
                let own = settings.iter().enumerate();
                own.filter(move |(_, of)| of.realizations().any(|own| own == cloud))
                    .map(move |(index, _)| (index, cloud))
            };
            clouds.into_iter().flat_map(on).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains::scene::parse_scene;

    #[test]
    fn every_scene_is_valid_and_every_method_is_itself() {
        for (plan, methods) in [(Plan::full(24, 100, 1), 47), (Plan::quick(4, 1), 16)] {
            assert_eq!(plan.methods.len(), methods);
            let (mut digests, mut ids) = (BTreeSet::new(), BTreeSet::new());
            for setting in plan.settings() {
                let text = serde_json::to_string(&setting.specification.scene).expect("a scene");
                let read = parse_scene(&text);
                assert!(read.is_ok(), "{}: {read:?}", setting.name);
                assert!(
                    digests.insert(setting.specification.digest()),
                    "{}",
                    setting.id
                );
                assert!(ids.insert(&setting.id), "{}", setting.id);
            }
        }
    }

    #[test]
    fn names_do_not_count_and_everything_else_does() {
        let of = Specification::native(Mode::Exact, whole_scene());
        let mut other = of.clone();
        other.scene.realization = 7;
        assert_eq!(of.digest(), other.digest());
        other.scene.loading.speed *= 2.0;
        assert_ne!(of.digest(), other.digest());
        let mode = Specification::native(Mode::Free, whole_scene());
        assert_ne!(of.digest(), mode.digest());
    }
}
