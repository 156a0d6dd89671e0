//! Which methods are compared, and which of them are put to the test as faster protocols.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::engine::exec::{Description, missing_for_scene};
use crate::study::change::{Change, What, changed};
use crate::study::realization::{
    FAST_STEP, Runner, Setting, Specification, small_scene, whole_scene,
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

/// Cundall's α of reduced-stiffness depositions.
const ALPHA: f64 = 0.2;
/// Half of the paper scene's step, for external engines.
const SHORT_STEP: f64 = 0.225;

/// The reference of the methods with friction.
pub const FRICTIONAL: &str = "friction";
/// Angle of friction between grains in both stages, rad, and dt over √(m/k) of that reference: 0.45 is just beyond the largest
/// stable step where grains with friction can turn, and at 0.65 they do not come to rest.
const WITH_FRICTION: [Change; 2] = [(What::Friction, 0.5), (What::Step, 0.3)];

/// One of the methods that are compared in the native engine: `methods.json`, read, in the order of tables.
#[derive(Deserialize)]
struct Method {
    id: &'static str,
    name: &'static str,
    /// Those of the axis [`FRICTIONAL`] are held against its reference, the first of them.
    axis: &'static str,
    #[serde(flatten)]
    how: How,
    /// It is run on one of so many of the clouds.
    #[serde(default = "all")]
    share: u64,
    /// It is a candidate. Two depositions were too dense or no cheaper at first sight, so nothing is spent on testing them.
    #[serde(default)]
    tested: bool,
    /// Of [`Plan::quick`] too.
    #[serde(default)]
    quick: bool,
}

/// What a method does otherwise than its reference.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum How {
    /// By the engine's own rules.
    Changes(Vec<Change>),
    /// Poured softer by a factor until a share of the largest kinetic energy, and stiffened in steps of `ratio`.
    Softly {
        softer: f64,
        ratio: f64,
        until: f64,
        step: f64,
    },
    /// Poured with this α, and loaded with the scene's own.
    PouringAlpha(f64),
}

fn all() -> u64 {
    1
}

impl How {
    fn of(&self, scene: &Scene) -> Specification {
        match self {
            How::Changes(changes) => Specification::native(changed(scene.clone(), changes)),
            How::Softly {
                softer,
                ratio,
                until,
                step,
            } => {
                let softly = Softly {
                    start: 1.0 / softer,
                    ratio: *ratio,
                    until: *until,
                    alpha: ALPHA,
                    step: *step,
                };
                Specification::soft(scene, &softly)
            }
            How::PouringAlpha(alpha) => Specification {
                phases: vec![Phase {
                    modulus: 1.0,
                    alpha: *alpha,
                    step: 0.45,
                    end: End::Settled(scene.settle.kinetic_energy_fraction),
                }],
                ..Specification::native(scene.clone())
            },
        }
    }
}

impl Plan {
    /// Every method for the paper's scene; YADE on its first `yade` clouds.
    pub fn full(screening: u64, confirmatory: u64, yade: u64) -> Self {
        let mut plan = Plan::new(whole_scene(), screening, confirmatory);
        plan.add_all(|_| true);
        plan.add_yade(yade);
        plan
    }

    /// A small bed, a few methods: that all parts work, and the large effects.
    pub fn quick(screening: u64, yade: u64) -> Self {
        let mut plan = Plan::new(small_scene(), screening, 0);
        plan.add_all(|method| method.quick);
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

    fn add_all(&mut self, wanted: impl Fn(&Method) -> bool) {
        let methods = include_str!("methods.json");
        let methods: Vec<Method> = serde_json::from_str(methods).expect("it is a list of methods");
        let scene = self.reference.specification.scene.clone();
        let frictional = changed(scene.clone(), &WITH_FRICTION);
        for method in methods.into_iter().filter(wanted) {
            let is_frictional = method.axis == FRICTIONAL;
            let scene = if is_frictional { &frictional } else { &scene };
            let specification = method.how.of(scene);
            self.add(
                method.id,
                method.name,
                method.axis,
                specification,
                method.share,
            );
            if method.tested {
                self.test_last();
            }
            if let Some(reference) = self
                .methods
                .last_mut()
                .filter(|added| added.id == FRICTIONAL)
            {
                reference.clouds.clone_from(&self.reference.clouds);
            }
        }
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
                    specification.scene = changed(specification.scene, &[(What::Step, step)]);
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
