//! Which methods are compared, and which of them are put to the test as faster protocols.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::engine::exec::{Description, missing_for_scene};
use crate::study::realization::Change::{Alpha, CloudSpeed, Columns, Modulus, Settled, Size, Step};
use crate::study::realization::{
    Change, FAST_STEP, Runner, Setting, Specification, changed, small_scene, whole_scene,
};
use grains::generate::initial_bodies;
use grains::native::pouring::{End, Phase, Softly};
use grains::scene::Scene;
use grains::task::Task;

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

/// The candidate that is the fast protocol: the scene of `scene paper --fast` with `run --reduced-stiffness` (`docs/tradeoff.md`).
pub const FAST: &str = "step-0.65-soft-10-1e-3";

const ALPHA: f64 = 0.2;
/// Half of the paper scene's step, for external engines.
const SHORT_STEP: f64 = 0.225;

const SOFT: &str = "softened contacts";
const DAMPING: &str = "damping";
const COMBINED: &str = "combined";

/// By the engine's own rules: id, name, what is changed, share of the clouds.
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

/// Reduced-stiffness depositions at the fast protocol's step, cheapest last: by how much softer it is poured, to which energy,
/// and whether it is a candidate, as the step alone is. The last two were too dense or no cheaper at first sight, so nothing is
/// spent on testing them.
const DEPOSITIONS: [(f64, f64, bool); 4] = [
    (10.0, 1.0e-3, true),
    (10.0, 3.0e-3, true),
    (10.0, 1.0e-2, false),
    (100.0, 1.0e-2, false),
];

/// The reference of the methods with friction.
pub const FRICTIONAL: &str = "friction";
/// Angle of friction between grains in both stages, rad.
const FRICTION: f64 = 0.5;
/// dt over √(m/k) of that reference: 0.45 is just beyond the largest stable step where grains with friction can turn, and at 0.65
/// they do not come to rest.
const FRICTIONAL_STEP: f64 = 0.3;

/// What is changed with friction, by the engine's own rules.
const WITH_FRICTION: Cases = &[
    ("friction-step-0.1", "friction, step 0.1", Step(0.1), 2),
    ("friction-step-0.2", "friction, step 0.2", Step(0.2), 1),
    ("friction-step-0.45", "friction, step 0.45", Step(0.45), 1),
    (
        "friction-modulus-10",
        "friction, step 0.3, E/10",
        Modulus(0.1),
        2,
    ),
];

/// Of [`Plan::quick`], besides the depositions.
const QUICK: [&str; 9] = [
    FRICTIONAL,
    "friction-step-0.45",
    "step-0.1",
    "step-0.65",
    "step-0.9",
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
        let kept =
            |setting: &Setting| setting.axis == COMBINED || QUICK.contains(&setting.id.as_str());
        plan.methods.retain(kept);
        for method in &mut plan.methods {
            method.clouds[0] = [1, screening];
        }
        plan.add_yade(yade);
        plan
    }

    /// The reference alone: the scene as it is. Against itself on other clouds it needs as many of those.
    pub fn new(scene: Scene, screening: u64, confirmatory: u64) -> Self {
        let name = "the scene as it is";
        let specification = Specification::native(scene);
        let mut reference = Setting::new("reference", name, "reference", specification, screening);
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
    pub fn add(
        &mut self,
        id: &str,
        name: &str,
        axis: &str,
        specification: Specification,
        share: u64,
    ) {
        let clouds = self.screening.div_ceil(share);
        self.methods
            .push(Setting::new(id, name, axis, specification, clouds));
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
        let native = |changes: &[Change]| Specification::native(changed(scene.clone(), changes));
        let soft = |softer: f64, ratio, until, step| {
            Specification::soft(&scene, &softly(softer, ratio, until, step))
        };
        let add_cases = |plan: &mut Plan, axis, cases: Cases| {
            for (id, name, change, share) in cases {
                plan.add(id, name, axis, native(&[*change]), *share);
                if matches!(change, Step(step) if *step == FAST_STEP) {
                    plan.test_last();
                }
            }
        };
        add_cases(self, "time step", STEPS);
        add_cases(self, SOFT, MODULI);
        for softer in [10.0, 100.0] {
            let ways = [
                ("at-once", "at once", softer),
                ("by-2", "in steps of 2", 2.0),
            ];
            for (id, how, ratio) in ways {
                let specification = soft(softer, ratio, 1.0e-4, 0.45);
                let name = format!("poured at E/{softer}, stiffened {how}");
                self.add(
                    &format!("soft-{softer}-{id}"),
                    &name,
                    SOFT,
                    specification,
                    1,
                );
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
            let specification = Specification {
                phases: vec![phase],
                ..native(&[])
            };
            let name = format!("poured with α = {alpha}");
            self.add(
                &format!("poured-alpha-{alpha}"),
                &name,
                DAMPING,
                specification,
                1,
            );
        }
        add_cases(self, "cloud", CLOUDS);
        for (softer, until, tested) in DEPOSITIONS {
            let specification = soft(softer, softer.sqrt(), until, FAST_STEP);
            let id = format!("step-{FAST_STEP}-soft-{softer}-{until:e}");
            let name = format!("step {FAST_STEP}, poured at E/{softer} until {until:e}");
            self.add(&id, &name, COMBINED, specification, 1);
            if tested {
                self.test_last();
            }
        }
        self.add_frictional();
    }

    fn add_frictional(&mut self) {
        let frictional = [Change::Friction(FRICTION), Step(FRICTIONAL_STEP)];
        let scene = changed(self.reference.specification.scene.clone(), &frictional);
        let specification = Specification::native(scene.clone());
        let name = format!("friction {FRICTION} rad, step {FRICTIONAL_STEP}: their reference");
        let clouds = self.reference.clouds.clone();
        let reference = Setting::new(FRICTIONAL, &name, FRICTIONAL, specification, self.screening);
        self.methods.push(Setting {
            clouds,
            ..reference
        });
        for (id, name, change, share) in WITH_FRICTION {
            let specification = Specification::native(changed(scene.clone(), &[*change]));
            self.add(id, name, FRICTIONAL, specification, *share);
        }
        let (softer, until, _) = DEPOSITIONS[0];
        let softly = softly(softer, softer.sqrt(), until, FRICTIONAL_STEP);
        let specification = Specification::soft(&scene, &softly);
        let name = "friction, step 0.3, poured at E/10 until 1e-3";
        self.add("friction-soft-10", name, FRICTIONAL, specification, 1);
    }

    /// The scenes that other engines run, with the beginnings of their ids and the ends of their names.
    fn references(&self) -> Vec<(&'static str, &'static str, Specification)> {
        let mut all = vec![("", "", self.reference.specification.clone())];
        let frictional = self.methods.iter().find(|method| method.id == FRICTIONAL);
        all.extend(
            frictional.map(|method| ("friction-", ", friction", method.specification.clone())),
        );
        all
    }

    /// What a method's results are held against; the reference with friction is its own.
    pub fn reference_of(&self, method: &Setting) -> &Setting {
        let mut methods = self.methods.iter();
        let frictional = methods.find(|setting| setting.id == FRICTIONAL && is_frictional(method));
        frictional.unwrap_or(&self.reference)
    }

    fn add_yade(&mut self, clouds: u64) {
        for (id, name, reference) in self.references() {
            let specification = Specification {
                runner: Runner::YadeOrdinary,
                ..reference
            };
            let (id, name) = (format!("{id}yade"), format!("YADE, ordinary loop{name}"));
            let method = Setting::new(&id, &name, "YADE", specification, clouds);
            self.methods.extend((clouds > 0).then_some(method));
        }
    }

    /// Adds the references' scenes, and two other steps of each, in an external engine, on so many clouds; the one with friction
    /// where it has that. `digest` is that of its file.
    #[must_use]
    pub fn with_external(mut self, engine: &Description, digest: &str, clouds: u64) -> Self {
        let label = engine.label();
        let all = self.references().into_iter();
        let can_pour = |scene: &Scene| {
            let task = Task::settle(initial_bodies(scene));
            missing_for_scene(engine, scene, &task).is_empty()
        };
        for (base, of_base, reference) in
            all.filter(|entry| entry.0.is_empty() || can_pour(&entry.2.scene))
        {
            for step in [None, Some(SHORT_STEP), Some(FAST_STEP)] {
                let mut specification = Specification {
                    runner: Runner::External,
                    program: Some(digest.to_owned()),
                    ..reference.clone()
                };
                let (mut id, mut name) = (format!("{base}external"), format!("{label}{of_base}"));
                if let Some(step) = step {
                    specification.scene = changed(specification.scene, &[Step(step)]);
                    id += &format!("-step-{step}");
                    name += &format!(", step {step}");
                }
                self.methods.push(Setting::new(
                    &id,
                    &name,
                    "external engine",
                    specification,
                    clouds,
                ));
            }
        }
        self
    }

    /// The reference, then all others.
    pub fn settings(&self) -> Vec<&Setting> {
        let all = std::iter::once(&self.reference);
        all.chain(&self.methods).collect()
    }

    pub fn task(&self, number: u64) -> (&Setting, u64) {
        let (place, cloud) = self.tasks()[number as usize - 1];
        (self.settings()[place], cloud)
    }

    /// Every method on every cloud of its own, the first clouds first, so that a study that is looked at early has a little
    /// of everything.
    pub fn tasks(&self) -> &[(usize, u64)] {
        self.tasks.get_or_init(|| {
            let settings = self.settings();
            let clouds: BTreeSet<u64> = settings
                .iter()
                .flat_map(|setting| setting.realizations())
                .collect();
            let on = |cloud| {
                let own = settings.iter().enumerate();
                own.filter(move |(_, setting)| setting.realizations().any(|own| own == cloud))
                    .map(move |(index, _)| (index, cloud))
            };
            clouds.into_iter().flat_map(on).collect()
        })
    }
}

/// Poured softer by this factor until this share of the largest kinetic energy, and stiffened in steps of `ratio`.
fn softly(softer: f64, ratio: f64, until: f64, step: f64) -> Softly {
    Softly {
        start: 1.0 / softer,
        ratio,
        until,
        alpha: ALPHA,
        step,
    }
}

/// Whether it is held against the reference with friction.
pub fn is_frictional(method: &Setting) -> bool {
    method.specification.scene.material.friction_angle > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_valid_and_every_method_is_itself() {
        for (plan, methods) in [(Plan::full(24, 100, 1), 50), (Plan::quick(4, 1), 15)] {
            assert_eq!(plan.methods.len(), methods);
            let (mut digests, mut ids) = (BTreeSet::new(), BTreeSet::new());
            for setting in plan.settings() {
                let (id, specification) = (&setting.id, &setting.specification);
                let read = specification.scene.check();
                assert!(read.is_ok(), "{id}: {read:?}");
                assert!(
                    digests.insert(specification.digest()) && ids.insert(id),
                    "{id}"
                );
            }
        }
    }

    #[test]
    fn names_do_not_count_and_everything_else_does() {
        let specification = Specification::native(whole_scene());
        let mut other = specification.clone();
        other.scene.realization = 7;
        assert_eq!(specification.digest(), other.digest());
        other.scene.loading.speed *= 2.0;
        assert_ne!(specification.digest(), other.digest());
        other = Specification {
            runner: Runner::YadeSorted,
            ..specification.clone()
        };
        assert_ne!(specification.digest(), other.digest());
    }
}
