//! Which choices are varied and why, and on how many clouds.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::penetration::Penetration;
use crate::study::realization::Change::{
    Alpha, CloudSpeed, Columns, Diameter, DiameterSameArea, Friction, Hold, Settled, Size, Speed,
    Spheres, Step,
};
use crate::study::realization::{
    Change, Setting, Specification, changed, small_scene, whole_scene,
};
use grains::scene::Scene;

/// The combined settings are run on clouds that took no part in choosing them.
pub const FIRST_COMBINED: u64 = 1001;

/// Fewer give no interval that is worth a verdict.
const FEWEST: u64 = 3;

/// Share of the width where steps cost twenty times as much: with friction, and there without friction too.
pub const NARROW: f64 = 0.5;

/// Crossed axes.
pub const SPEED_AND_DAMPING: &str = "punch speed and damping";
pub const FRICTION: &str = "friction";
pub const COMBINED: &str = "combined";
const SETTLE: &str = "settle rule";
const MASS: &str = "grain mass";
const DIAMETER: &str = "mean diameter, same number of grains";
const DIAMETER_SAME_AREA: &str = "mean diameter, same area of grains";
const HOLD: &str = "hold after the force";
const COLUMNS: &str = "cloud, columns";
const CLOUD_SPEED: &str = "cloud, speed";
const GRAINS: &str = "number of grains";
const WIDTH: &str = "box width";
const STEP: &str = "time step";

const NEVER_PRINTED: &str = "never printed; R = 5 mm follows from the control volume alone";
const POURED: &str = "'randomly poured'";

/// Every axis in the order of pages: what the paper says, and why the range is what it is.
pub const AXES: [(&str, &str); 13] = [
    (
        SPEED_AND_DAMPING,
        "'gently' and 'spring-dashpot' without numbers; from where punches sink to where the force is an impact, and from \
         hardly damped to YADE's examples of quasi-static runs. Damping is that of pouring and loading",
    ),
    (
        SETTLE,
        "'almost completely dissipate'; kinetic energy over its peak, from visible motion to deep rest",
    ),
    (
        FRICTION,
        "Table 2 prints zero; friction angle in rad, to 0.6 rad = 34 degrees, a sand's. A friction coefficient is its \
         tangent. In a box half as wide, as steps with friction cost twenty times as much",
    ),
    (
        MASS,
        "'spherical' particles, but weights of discs one metre long. Spheres in a box half as wide: their steps are shorter",
    ),
    (DIAMETER, NEVER_PRINTED),
    (DIAMETER_SAME_AREA, NEVER_PRINTED),
    (
        HOLD,
        "'until the force was equal to 2ap'; a hold is not mentioned",
    ),
    (COLUMNS, POURED),
    (CLOUD_SPEED, POURED),
    (GRAINS, "5,000 is printed; shows what the floor does"),
    (WIDTH, "1 m is printed; shows what the walls do"),
    (STEP, "not printed; in units of sqrt(m/k)"),
    (COMBINED, "whether all figures come out at once"),
];

/// Speeds and damping numbers of the main picture.
const SPEEDS: [f64; 8] = [0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.2, 0.5];
const ALPHAS: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    pub base: Scene,
    /// Every setting; the base may be one of several axes.
    pub settings: Vec<Setting>,
    pub penetrations: Vec<Penetration>,
    /// Clouds of a cheap setting.
    pub clouds: u64,
    #[serde(skip)]
    tasks: OnceLock<Vec<Task>>,
}

/// A piece of work on one cloud.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// One bed, loaded by each of these settings.
    Loads(Vec<usize>, u64),
    Penetration(usize, u64),
}

impl Plan {
    /// The paper's bed. Expensive settings have a share of the clouds.
    pub fn full(clouds: u64) -> Self {
        let mut plan = Plan::new(whole_scene(), clouds);
        plan.penetrations = Penetration::all(&plan.base, clouds.div_ceil(4).max(FEWEST));
        for alpha in ALPHAS {
            for speed in SPEEDS {
                // The slowest mostly sink, after a hundred thousand steps and more.
                let clouds = match speed {
                    ..0.03 => clouds.div_ceil(8),
                    ..0.05 => clouds.div_ceil(2).max(FEWEST),
                    _ => clouds,
                };
                plan.speed_and_damping(speed, alpha).clouds = vec![[1, clouds]];
            }
        }
        for share in [1.0e-2, 1.0e-3, 1.0e-4, 1.0e-5, 1.0e-6] {
            plan.settle(share, if share < 1.0e-5 { 3 } else { 1 });
        }
        for (speed, angles) in [
            (0.1, &[0.0, 0.1, 0.2, 0.3, 0.4, 0.6][..]),
            (0.05, &[0.0, 0.3]),
        ] {
            for &angle in angles {
                plan.friction(angle, speed, NARROW);
            }
        }
        plan.add(MASS, "disc", "disc", 0.0, 1, &[]);
        let spheres = [Size(NARROW, 1.0), Spheres];
        plan.add(MASS, "sphere", "sphere", 1.0, 4, &spheres);
        for millimetres in [9.0, 9.5, 9.8, 10.0, 10.2, 10.5] {
            plan.diameter(millimetres, false);
        }
        for millimetres in [8.0, 10.0] {
            plan.diameter(millimetres, true);
        }
        for seconds in [0.0, 0.01, 0.05, 0.2, 1.0] {
            plan.along(HOLD, "hold", "s", seconds, 1, Hold(seconds));
        }
        for columns in [80, 90] {
            plan.along(
                COLUMNS,
                "columns",
                "columns",
                columns.into(),
                1,
                Columns(columns),
            );
        }
        for speed in [0.0, 0.3, 1.0, 3.0] {
            plan.along(CLOUD_SPEED, "cloud", "m/s", speed, 1, CloudSpeed(speed));
        }
        for (count, share) in [(2500.0, 1), (5000.0, 1), (10_000.0, 4)] {
            let depth = count / f64::from(plan.base.particles.count);
            plan.along(GRAINS, "grains", "grains", count, share, Size(1.0, depth));
        }
        for (width, share) in [(0.5, 1), (1.0, 1), (2.0, 4)] {
            plan.along(WIDTH, "width", "m", width, share, Size(width, 1.0));
        }
        for (step, share) in [(0.1, 4), (0.2, 2), (0.45, 1), (0.65, 1)] {
            plan.along(STEP, "step", "√(m/k)", step, share, Step(step));
        }
        plan.combined(9.85, 1.0e-3, 0.05, 0.4);
        plan.combined(9.85, 1.0e-3, 0.07, 0.2);
        plan
    }

    /// A small bed and few settings, for tests and continuous integration.
    pub fn quick(clouds: u64) -> Self {
        let mut plan = Plan::new(small_scene(), clouds);
        plan.penetrations = Penetration::quick(&plan.base, 2);
        for alpha in [0.2, 0.8] {
            for speed in [0.05, 0.1, 0.5] {
                plan.speed_and_damping(speed, alpha);
            }
        }
        for share in [1.0e-2, 1.0e-4] {
            plan.settle(share, 1);
        }
        for angle in [0.0, 0.3] {
            plan.friction(angle, 0.1, 1.0);
        }
        for millimetres in [9.0, 10.0] {
            plan.diameter(millimetres, false);
        }
        for seconds in [0.0, 0.05] {
            plan.along(HOLD, "hold", "s", seconds, 1, Hold(seconds));
        }
        plan
    }

    pub fn new(base: Scene, clouds: u64) -> Self {
        Plan {
            base,
            settings: Vec::new(),
            penetrations: Vec::new(),
            clouds,
            tasks: OnceLock::new(),
        }
    }

    /// Adds the base scene changed along an axis, on a share of the clouds.
    pub fn add(
        &mut self,
        axis: &str,
        id: &str,
        name: &str,
        at: f64,
        share: u64,
        changes: &[Change],
    ) -> &mut Setting {
        let scene = changed(self.base.clone(), changes);
        let of = Specification::native(scene);
        let clouds = self.clouds.div_ceil(share).max(FEWEST);
        let mut setting = Setting::new(id, name, axis, of, clouds);
        setting.at = vec![at];
        self.settings.push(setting);
        let last = self.settings.len() - 1;
        &mut self.settings[last]
    }

    fn speed_and_damping(&mut self, speed: f64, alpha: f64) -> &mut Setting {
        let id = format!("speed-{speed}-alpha-{alpha}");
        let name = format!("{speed} m/s, α = {alpha}");
        let changes = [Alpha(alpha), Speed(speed)];
        let setting = self.add(SPEED_AND_DAMPING, &id, &name, speed, 1, &changes);
        setting.at.push(alpha);
        setting
    }

    fn settle(&mut self, share: f64, of_clouds: u64) {
        let id = format!("settled-{share:e}");
        let name = format!("{share:.0e} of the peak");
        self.add(SETTLE, &id, &name, share, of_clouds, &[Settled(share)]);
    }

    fn friction(&mut self, angle: f64, speed: f64, width: f64) {
        let id = format!("friction-{angle}-speed-{speed}");
        let name = format!("φ = {angle} rad, {speed} m/s");
        let changes = [Size(width, 1.0), Friction(angle), Speed(speed)];
        let share = if angle > 0.0 { 3 } else { 1 };
        let setting = self.add(FRICTION, &id, &name, angle, share, &changes);
        setting.at.push(speed);
    }

    /// Smaller grains stopped earlier, so that height and porosity can be met at once, under a punch that comes near the
    /// published stress at O. Means of stresses need many beds.
    fn combined(&mut self, millimetres: f64, share: f64, speed: f64, alpha: f64) {
        let id = format!("combined-speed-{speed}-alpha-{alpha}");
        let name =
            format!("D = {millimetres} mm, {share:.0e} of the peak, {speed} m/s, α = {alpha}");
        let changes = [
            Diameter(1.0e-3 * millimetres),
            Settled(share),
            Alpha(alpha),
            Speed(speed),
        ];
        let clouds = 2 * self.clouds.max(FEWEST);
        let setting = self.add(COMBINED, &id, &name, speed, 1, &changes);
        setting.clouds = vec![[FIRST_COMBINED, FIRST_COMBINED + clouds - 1]];
    }

    fn diameter(&mut self, millimetres: f64, same_area: bool) {
        let name = format!("D = {millimetres} mm");
        let metres = 1.0e-3 * millimetres;
        let (axis, id, change) = if same_area {
            (DIAMETER_SAME_AREA, "same-area", DiameterSameArea(metres))
        } else {
            (DIAMETER, "diameter", Diameter(metres))
        };
        let id = format!("{id}-{millimetres}");
        self.add(axis, &id, &name, millimetres, 1, &[change]);
    }

    /// One change, whose id and name are the value's.
    fn along(&mut self, axis: &str, id: &str, unit: &str, at: f64, share: u64, change: Change) {
        let (id, name) = (format!("{id}-{at}"), format!("{at} {unit}"));
        self.add(axis, &id, &name, at, share, &[change]);
    }

    pub fn task(&self, number: u64) -> &Task {
        &self.tasks()[number as usize - 1]
    }

    /// For each setting the first one that loads the same beds.
    fn beds(&self) -> Vec<usize> {
        let mut firsts: Vec<usize> = Vec::new();
        let of = |index: usize| &self.settings[index].specification;
        let beds = (0..self.settings.len()).map(|index| {
            let found = firsts
                .iter()
                .find(|first| of(**first).pours_like(of(index)));
            found.copied().unwrap_or_else(|| {
                firsts.push(index);
                index
            })
        });
        beds.collect()
    }

    /// All work, the first clouds of everything first, so that a study that is looked at early has a little of everything.
    /// A bed is poured once for all loads of a cloud; settings that are the same run are run once.
    pub fn tasks(&self) -> &[Task] {
        self.tasks.get_or_init(|| {
            let digests = self.settings.iter().map(|of| of.specification.digest());
            let digests: Vec<String> = digests.collect();
            let beds_of = self.beds();
            let of_settings = self.settings.iter().flat_map(Setting::realizations);
            let watched = self.penetrations.iter().flat_map(|of| 1..=of.clouds);
            let clouds: BTreeSet<u64> = of_settings.chain(watched).collect();
            let mut tasks = Vec::new();
            for cloud in clouds {
                let mut planned = BTreeSet::new();
                let mut beds: Vec<(usize, Vec<usize>)> = Vec::new();
                for (index, setting) in self.settings.iter().enumerate() {
                    let own = setting.realizations().any(|of| of == cloud);
                    if !own || !planned.insert(&digests[index]) {
                        continue;
                    }
                    match beds.iter_mut().find(|bed| bed.0 == beds_of[index]) {
                        Some(bed) => bed.1.push(index),
                        None => beds.push((beds_of[index], vec![index])),
                    }
                }
                tasks.extend(beds.into_iter().map(|bed| Task::Loads(bed.1, cloud)));
                let watched = self.penetrations.iter().enumerate();
                let watched = watched.filter(|(_, of)| cloud <= of.clouds);
                tasks.extend(watched.map(|(index, _)| Task::Penetration(index, cloud)));
            }
            tasks
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains::scene::{Particles, parse_scene};

    #[test]
    fn every_setting_is_a_sound_scene_and_none_is_planned_twice_on_an_axis() {
        for plan in [Plan::full(12), Plan::quick(6)] {
            let (mut seen, mut ids) = (BTreeSet::new(), BTreeSet::new());
            for setting in &plan.settings {
                let text = serde_json::to_string(&setting.specification.scene).expect("a scene");
                let read = parse_scene(&text);
                assert!(read.is_ok(), "{}: {read:?}", setting.name);
                let digest = setting.specification.digest();
                assert!(seen.insert((&setting.axis, digest)), "{}", setting.id);
                assert!(ids.insert(&setting.id), "{}", setting.id);
                assert!(setting.realizations().count() >= 1, "{}", setting.id);
                if setting.axis == DIAMETER_SAME_AREA {
                    let area = |of: &Particles| f64::from(of.count) * of.mean_diameter.powi(2);
                    let scene = &setting.specification.scene;
                    let share = area(&scene.particles) / area(&plan.base.particles);
                    assert!((share - 1.0).abs() < 1.0e-3, "{}: {share}", setting.id);
                }
            }
        }
    }

    #[test]
    fn axes_go_through_the_base() {
        let plan = Plan::full(12);
        let base = Specification::native(plan.base.clone()).digest();
        for (axis, _) in AXES {
            let mut own = plan.settings.iter().filter(|of| of.axis == axis);
            let through = own.any(|of| of.specification.digest() == base);
            assert_eq!(through, ![COMBINED, FRICTION].contains(&axis), "{axis}");
        }
    }

    #[test]
    fn speeds_share_beds_and_damping_numbers_do_not() {
        let plan = Plan::full(12);
        let beds = |wanted: fn(&[f64]) -> bool| {
            let own = plan.settings.iter().zip(plan.beds());
            let own = own.filter(|(of, _)| of.axis == SPEED_AND_DAMPING && wanted(&of.at));
            own.map(|(_, bed)| bed).collect::<BTreeSet<usize>>().len()
        };
        assert_eq!(beds(|at| at[1] == 0.2), 1);
        assert_eq!(beds(|at| at[0] == 0.1), ALPHAS.len());
    }

    /// 696 members of 86 settings and 39 watched punches.
    #[test]
    fn every_member_is_planned_once() {
        let plan = Plan::full(12);
        let mut members = BTreeSet::new();
        let mut watched = 0;
        for task in plan.tasks() {
            match task {
                Task::Loads(settings, cloud) => {
                    for index in settings {
                        let setting = &plan.settings[*index];
                        assert!(members.insert((setting.specification.digest(), *cloud)));
                    }
                }
                Task::Penetration(..) => watched += 1,
            }
        }
        assert_eq!((plan.settings.len(), members.len(), watched), (86, 696, 39));
        let wanted = plan.settings.iter().flat_map(|of| {
            let digest = of.specification.digest();
            of.realizations().map(move |cloud| (digest.clone(), cloud))
        });
        assert_eq!(members, wanted.collect());
    }
}
