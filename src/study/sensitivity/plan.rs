//! Which settings are run, on how many clouds.

use serde::{Deserialize, Serialize};

use super::choices::*;
use super::push::Push;
use crate::files::sha256_hex;
use crate::study::tradeoff::method::{with_alpha, with_size, with_step, with_tolerance};
use grains::scene::{Scene, paper_scene};

/// The combined settings are run on clouds that took no part in choosing them.
pub const FIRST_COMBINED: u64 = 1001;

/// Fewer give no interval that is worth a verdict.
const FEWEST: u64 = 3;

/// Steps with friction cost twenty times as much: their beds have this share of the width, without friction too.
pub const NARROW: f64 = 0.5;

/// One way to fill in what the paper leaves open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// What is varied.
    pub axis: Axis,
    /// For people: `0.1 m/s, α = 0.2`.
    pub name: String,
    /// Its place on the axis, in the unit of the name.
    pub at: f64,
    /// Of a crossed axis, the place on the second.
    pub beside: Option<f64>,
    /// Its realization is replaced.
    pub scene: Scene,
    /// Clouds are numbered from here.
    pub first: u64,
    /// How many clouds.
    pub clouds: u64,
}

impl Setting {
    /// What is run, without names: settings with the same digest have the same members.
    pub fn digest(&self) -> String {
        of_any_realization(&self.scene)
    }

    /// What is poured: settings with the same digest are loaded from the same beds.
    pub fn pour_digest(&self, base: &Scene) -> String {
        let scene = Scene {
            loading: base.loading.clone(),
            measurement: base.measurement.clone(),
            control_points: base.control_points.clone(),
            ..self.scene.clone()
        };
        of_any_realization(&scene)
    }

    /// Whether a bed can be poured once and loaded in many ways with the same bits: contacts with friction remember
    /// how they came about.
    pub fn can_share_beds(&self) -> bool {
        self.scene.material.friction_angle == 0.0
    }
}

fn of_any_realization(scene: &Scene) -> String {
    let scene = Scene {
        realization: 0,
        ..scene.clone()
    };
    let text = format!("{} {}", env!("CARGO_PKG_VERSION"), scene.digest());
    sha256_hex(text.as_bytes())[..16].to_owned()
}

/// What is run.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The scene that all settings differ from.
    pub base: Scene,
    /// Every setting; the base may be one of several axes.
    pub settings: Vec<Setting>,
    /// Punches that are pushed in to the end, whatever the force, and punches that stop and stand.
    pub pushes: Vec<Push>,
    /// Clouds of a cheap setting.
    pub clouds: u64,
}

/// Speeds and damping numbers of the main picture.
const SPEEDS: [f64; 8] = [0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.2, 0.5];
const ALPHAS: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];

impl Plan {
    /// The paper's bed. Dear settings have a share of the clouds.
    pub fn full(clouds: u64) -> Self {
        let base = paper_scene(1, 5000);
        let mut plan = Plan {
            settings: Vec::new(),
            pushes: Push::all(&base, clouds.div_ceil(4).max(FEWEST)),
            clouds,
            base,
        };
        for alpha in ALPHAS {
            for speed in SPEEDS {
                // The slowest mostly sink, after a hundred thousand steps and more.
                let clouds = match speed {
                    ..0.03 => clouds.div_ceil(8),
                    ..0.05 => clouds.div_ceil(2).max(FEWEST),
                    _ => clouds,
                };
                plan.grid(speed, alpha, clouds);
            }
        }
        for fraction in [1.0e-2, 1.0e-3, 1.0e-4, 1.0e-5, 1.0e-6] {
            let share = if fraction < 1.0e-5 { 3 } else { 1 };
            plan.add(
                Axis::Settle,
                &format!("{fraction:.0e} of the peak"),
                fraction,
                share,
                |scene| with_tolerance(scene, fraction),
            );
        }
        for (speed, angles) in [
            (0.1, &[0.0, 0.1, 0.2, 0.3, 0.4, 0.6][..]),
            (0.05, &[0.0, 0.3]),
        ] {
            for &angle in angles {
                let share = if angle > 0.0 { 3 } else { 1 };
                plan.friction(angle, speed, NARROW, share);
            }
        }
        for (name, sphere) in [("disc", false), ("sphere", true)] {
            let share = if sphere { 4 } else { 1 };
            let at = f64::from(u8::from(sphere));
            plan.add(Axis::Shape, name, at, share, |scene| {
                if sphere {
                    with_spheres(with_size(scene, NARROW, 1.0))
                } else {
                    scene
                }
            });
        }
        for (axis, diameters) in [
            (Axis::Diameter, &[9.0, 9.5, 9.8, 10.0, 10.2, 10.5][..]),
            (Axis::DiameterSameArea, &[8.0, 10.0]),
        ] {
            for &diameter in diameters {
                plan.diameter(axis, diameter);
            }
        }
        for seconds in [0.0, 0.01, 0.05, 0.2, 1.0] {
            plan.hold(seconds);
        }
        for columns in [80, 90] {
            plan.add(
                Axis::CloudColumns,
                &format!("{columns} columns"),
                f64::from(columns),
                1,
                |scene| with_columns(scene, columns),
            );
        }
        for speed in [0.0, 0.3, 1.0, 3.0] {
            plan.add(
                Axis::CloudSpeed,
                &format!("{speed} m/s"),
                speed,
                1,
                |scene| with_cloud_speed(scene, speed),
            );
        }
        for (count, share) in [(2500, 1), (5000, 1), (10_000, 4)] {
            let depth = f64::from(count) / f64::from(plan.base.particles.count);
            plan.add(
                Axis::Grains,
                &format!("{count} grains"),
                f64::from(count),
                share,
                |scene| with_size(scene, 1.0, depth),
            );
        }
        for (width, share) in [(0.5, 1), (1.0, 1), (2.0, 4)] {
            plan.add(Axis::Width, &format!("{width} m"), width, share, |scene| {
                with_size(scene, width, 1.0)
            });
        }
        for (step, share) in [(0.1, 4), (0.2, 2), (0.45, 1), (0.65, 1)] {
            plan.add(
                Axis::TimeStep,
                &format!("{step} √(m/k)"),
                step,
                share,
                |scene| with_step(scene, step),
            );
        }
        for (speed, alpha) in [(0.05, 0.4), (0.07, 0.2)] {
            plan.combined(9.85, 1.0e-3, speed, alpha);
        }
        plan
    }

    /// A small bed and few settings, for tests and continuous integration.
    pub fn quick(clouds: u64) -> Self {
        let mut base = with_size(paper_scene(1, 5000), 0.4, 0.5);
        for point in &mut base.control_points {
            point.offset *= 0.5;
        }
        let mut plan = Plan {
            settings: Vec::new(),
            pushes: Push::quick(&base, 2),
            clouds,
            base,
        };
        for alpha in [0.2, 0.8] {
            for speed in [0.05, 0.1, 0.5] {
                plan.grid(speed, alpha, clouds);
            }
        }
        for fraction in [1.0e-2, 1.0e-4] {
            plan.add(
                Axis::Settle,
                &format!("{fraction:.0e} of the peak"),
                fraction,
                1,
                |scene| with_tolerance(scene, fraction),
            );
        }
        for angle in [0.0, 0.3] {
            plan.friction(angle, 0.1, 1.0, if angle > 0.0 { 3 } else { 1 });
        }
        for diameter in [9.0, 10.0] {
            plan.diameter(Axis::Diameter, diameter);
        }
        for seconds in [0.0, 0.05] {
            plan.hold(seconds);
        }
        plan
    }

    /// Adds the base scene changed along an axis, on a share of the clouds.
    pub fn add(
        &mut self,
        axis: Axis,
        name: &str,
        at: f64,
        share: u64,
        change: impl FnOnce(Scene) -> Scene,
    ) {
        self.settings.push(Setting {
            axis,
            name: name.to_owned(),
            at,
            beside: None,
            scene: change(self.base.clone()),
            first: 1,
            clouds: self.clouds.div_ceil(share).max(FEWEST),
        });
    }

    fn grid(&mut self, speed: f64, alpha: f64, clouds: u64) {
        let name = format!("{speed} m/s, α = {alpha}");
        self.add(Axis::SpeedAndDamping, &name, speed, 1, |scene| {
            with_speed(with_alpha(scene, alpha), speed)
        });
        self.crossed(alpha);
        if let Some(last) = self.settings.last_mut() {
            last.clouds = clouds;
        }
    }

    fn friction(&mut self, angle: f64, speed: f64, width: f64, share: u64) {
        let name = format!("φ = {angle} rad, {speed} m/s");
        self.add(Axis::Friction, &name, angle, share, |scene| {
            let scene = with_size(scene, width, 1.0);
            with_speed(with_friction(scene, angle), speed)
        });
        self.crossed(speed);
    }

    fn crossed(&mut self, beside: f64) {
        if let Some(last) = self.settings.last_mut() {
            last.beside = Some(beside);
        }
    }

    /// Smaller grains stopped earlier, so that height and porosity can be met at once, under a punch that comes near the
    /// published stress at O. Means of stresses need many beds.
    fn combined(&mut self, millimetres: f64, fraction: f64, speed: f64, alpha: f64) {
        let name =
            format!("D = {millimetres} mm, {fraction:.0e} of the peak, {speed} m/s, α = {alpha}");
        self.add(Axis::Combined, &name, speed, 1, |scene| {
            let scene = with_diameter(scene, 1.0e-3 * millimetres, false);
            with_speed(with_alpha(with_tolerance(scene, fraction), alpha), speed)
        });
        if let Some(last) = self.settings.last_mut() {
            last.first = FIRST_COMBINED;
            last.clouds *= 2;
        }
    }

    fn diameter(&mut self, axis: Axis, millimetres: f64) {
        let same_area = axis == Axis::DiameterSameArea;
        let name = format!("D = {millimetres} mm");
        let here = millimetres == 1.0e3 * self.base.particles.mean_diameter;
        self.add(axis, &name, millimetres, 1, |scene| {
            if here {
                scene
            } else {
                with_diameter(scene, 1.0e-3 * millimetres, same_area)
            }
        });
    }

    fn hold(&mut self, seconds: f64) {
        let name = format!("{seconds} s");
        self.add(Axis::Hold, &name, seconds, 1, |scene| {
            if seconds > 0.0 {
                with_hold(scene, seconds)
            } else {
                scene
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains::scene::parse_scene;

    #[test]
    fn every_setting_is_a_sound_scene_and_none_is_planned_twice_on_an_axis() {
        for plan in [Plan::full(12), Plan::quick(6)] {
            let mut seen = std::collections::BTreeSet::new();
            for setting in &plan.settings {
                let text = serde_json::to_string(&setting.scene).expect("a scene");
                let read = parse_scene(&text);
                assert!(read.is_ok(), "{}: {read:?}", setting.name);
                assert!(
                    seen.insert((setting.axis, setting.digest())),
                    "{:?} {}",
                    setting.axis,
                    setting.name
                );
                assert!(setting.clouds >= 1, "{}", setting.name);
            }
        }
    }

    #[test]
    fn axes_go_through_the_base() {
        let plan = Plan::full(12);
        let base = of_any_realization(&plan.base);
        for axis in Axis::ALL {
            let through = plan
                .settings
                .iter()
                .any(|setting| setting.axis == axis && setting.digest() == base);
            let elsewhere = matches!(axis, Axis::Combined | Axis::Friction);
            assert_eq!(through, !elsewhere, "{axis:?}");
        }
    }

    #[test]
    fn speeds_share_beds_and_damping_numbers_do_not() {
        let plan = Plan::full(12);
        let beds = |wanted: fn(&Setting) -> bool| {
            let all: std::collections::BTreeSet<String> = plan
                .settings
                .iter()
                .filter(|setting| setting.axis == Axis::SpeedAndDamping && wanted(setting))
                .map(|setting| setting.pour_digest(&plan.base))
                .collect();
            all.len()
        };
        assert_eq!(beds(|setting| setting.beside == Some(0.2)), 1);
        assert_eq!(beds(|setting| setting.at == 0.1), ALPHAS.len());
    }
}
