//! Whether the bed can bear the published load at rest: bearing capacity of a cohesionless soil, and what watched
//! punches say.
//!
//! At rest and at depth z a strip of width 2a can press with p = γ z N_q + ½ γ 2a N_γ, γ = ρ g (1 − n), before the
//! soil beside it is lifted (Terzaghi's sum; N_q = e^{π tan φ} tan²(π/4 + φ/2) after Prandtl and Reissner,
//! N_γ = 2 (N_q + 1) tan φ after Vesić, which is on the high side for small φ).

use std::f64::consts::{FRAC_PI_4, PI};

use serde::{Deserialize, Serialize};

use super::penetration::{Kind, Penetration, Watched, Window};
use evidence::moments::{mean, mean_interval};
use evidence::{Interval, regression};
use grains::scene::Scene;

/// Internal friction of frictionless grains: 5.76° ± 0.22° for spheres (Peyneau and Roux, Phys. Rev. E 78, 011307,
/// 2008, in simple shear), in rad.
pub const FRICTIONLESS_ANGLE: f64 = 5.76 * PI / 180.0;

/// N_q: a surcharge's factor.
pub fn surcharge_factor(angle: f64) -> f64 {
    (PI * angle.tan()).exp() * (FRAC_PI_4 + 0.5 * angle).tan().powi(2)
}

/// N_γ: the factor of the soil's own weight.
pub fn weight_factor(angle: f64) -> f64 {
    2.0 * (surcharge_factor(angle) + 1.0) * angle.tan()
}

/// A soil under a punch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Soil {
    /// γ, N/m³.
    pub unit_weight: f64,
    /// a, m.
    pub half_width: f64,
}

impl Soil {
    /// The scene's bed at this porosity, under its punch.
    pub fn of(scene: &Scene, porosity: f64) -> Self {
        Soil {
            unit_weight: scene.material.density * scene.gravity * (1.0 - porosity),
            half_width: scene.loading.half_width,
        }
    }

    /// The largest pressure at rest at this depth, Pa.
    pub fn bears(&self, depth: f64, angle: f64) -> f64 {
        self.unit_weight
            * (depth * surcharge_factor(angle) + self.half_width * weight_factor(angle))
    }

    /// The depth at which this pressure is borne, m; zero where the surface bears it.
    pub fn depth_for(&self, pressure: f64, angle: f64) -> f64 {
        let rest = pressure / self.unit_weight - self.half_width * weight_factor(angle);
        (rest / surcharge_factor(angle)).max(0.0)
    }

    /// The angle that bears this pressure at this depth, rad; zero where no friction is needed.
    pub fn angle_for(&self, pressure: f64, depth: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.2);
        if self.bears(depth, low) >= pressure {
            return low;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.bears(depth, middle) < pressure {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// The pressure that a wall moving at 1 m/s puts on the bed by its inertia alone before any wave comes back, Pa·s/m:
/// ρ (1 − n) c with c = D √(k/m) of a row of mean grains.
pub fn impedance(scene: &Scene, porosity: f64) -> f64 {
    let diameter = scene.particles.mean_diameter;
    let radius = 0.5 * diameter;
    let stiffness = scene.material.youngs_modulus * radius;
    let wave_speed = diameter * (stiffness / scene.grain_mass(radius)).sqrt();
    scene.material.density * (1.0 - porosity) * wave_speed
}

/// A window over all clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Middle of the window: depth, m, or time after the stop, s.
    pub at: f64,
    /// Clouds with moments in it.
    pub clouds: usize,
    /// Mean pressure on the punch, Pa, with its 95 % t interval over clouds.
    pub pressure: Option<Interval>,
    /// The largest pressure that was seen, mean over clouds, Pa.
    pub largest: f64,
    /// What arrives at the floor, mean over clouds, Pa.
    pub on_floor: Option<Interval>,
}

/// A watched punch over all clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Of the penetration test.
    pub name: String,
    pub kind: Kind,
    /// m/s.
    pub speed: f64,
    pub alpha: f64,
    /// Friction angle between grains, rad.
    pub friction: f64,
    pub clouds: usize,
    /// Clouds that got their force, of a standing punch.
    pub reached: usize,
    /// Mean depth at the force, of a standing punch, m.
    pub depth: Option<Interval>,
    pub levels: Vec<Level>,
}

/// Pressure at rest at a depth, from the slowest punches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AtRest {
    pub depth: f64,
    pub speeds: Vec<f64>,
    /// Clouds that have all of them.
    pub clouds: usize,
    /// The height at speed zero of a line through each cloud's pressures, Pa: mean with its 95 % t interval over clouds.
    pub pressure: Option<Interval>,
    /// The internal friction angle that bears it, with those of the interval's ends, degrees.
    pub angle: Option<Interval>,
    /// What theory has for [`FRICTIONLESS_ANGLE`], Pa.
    pub theory: f64,
}

/// The section of the record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bearing {
    pub soil: Soil,
    /// Depth of the bed, m.
    pub height: f64,
    pub wanted: f64,
    /// rad.
    pub angle: f64,
    /// N_q and N_γ of that angle.
    pub factors: [f64; 2],
    /// The depth that would bear the load, m.
    pub depth_needed: f64,
    /// The angle that would bear it at the depth of the first control point, degrees.
    pub angle_needed: f64,
    /// [`impedance`], Pa·s/m.
    pub impedance: f64,
    /// The speed at which inertia alone gives the load, m/s.
    pub speed_of_impact: f64,
    pub at_rest: Vec<AtRest>,
    /// Punches that go on.
    pub through: Vec<Curve>,
    /// Punches that stop.
    pub standing: Vec<Curve>,
}

/// Speeds up to this one make the line to zero, m/s.
const SLOW: f64 = 0.02;

/// The section from the watched punches; `height` and `porosity` are those of the settled bed.
pub fn bearing(
    base: &Scene,
    penetrations: &[Penetration],
    watched: &[Watched],
    height: f64,
    porosity: f64,
) -> Bearing {
    let soil = Soil::of(base, porosity);
    let wanted = base.loading.pressure;
    let angle = FRICTIONLESS_ANGLE;
    let depth = base.control_points.first().map_or(0.0, |point| point.depth);
    let impedance = impedance(base, porosity);
    let all = penetrations.iter().map(|push| curve(push, watched));
    let (through, standing) = all.partition(|curve| curve.kind == Kind::Through);
    Bearing {
        soil,
        height,
        wanted,
        angle,
        factors: [surcharge_factor(angle), weight_factor(angle)],
        depth_needed: soil.depth_for(wanted, angle),
        angle_needed: soil.angle_for(wanted, depth).to_degrees(),
        impedance,
        speed_of_impact: wanted / impedance,
        at_rest: at_rest(base, penetrations, watched, &soil),
        through,
        standing,
    }
}

fn of_penetration<'a>(of: &Penetration, watched: &'a [Watched]) -> Vec<&'a Watched> {
    let digest = of.digest();
    let own = watched.iter().filter(|row| row.penetration == digest);
    own.collect()
}

fn curve(push: &Penetration, watched: &[Watched]) -> Curve {
    let own = of_penetration(push, watched);
    let windows = || own.iter().flat_map(|of| &of.windows);
    let mut starts: Vec<[f64; 2]> = windows().map(|of| [of.from, of.to]).collect();
    starts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    starts.dedup();
    let depths: Vec<f64> = own.iter().filter_map(|of| of.depth).collect();
    let levels = starts.into_iter().map(|[from, to]| {
        let of = |figure: fn(&Window) -> f64| -> Vec<f64> {
            let own = windows().filter(|of| of.from == from);
            own.map(figure).collect()
        };
        let pressures = of(|window| window.pressure);
        Level {
            at: 0.5 * (from + to),
            clouds: pressures.len(),
            pressure: mean_interval(&pressures, 0.95),
            largest: mean(&of(|window| window.largest)),
            on_floor: mean_interval(&of(|window| window.on_floor), 0.95),
        }
    });
    Curve {
        name: push.name.clone(),
        kind: push.kind,
        speed: push.speed(),
        alpha: push.scene.damping.alpha(),
        friction: push.scene.material.friction_angle,
        clouds: own.len(),
        reached: depths.len(),
        depth: mean_interval(&depths, 0.95),
        levels: levels.collect(),
    }
}

fn at_rest(
    base: &Scene,
    penetrations: &[Penetration],
    watched: &[Watched],
    soil: &Soil,
) -> Vec<AtRest> {
    let like_base = |push: &&Penetration| {
        push.kind == Kind::Through
            && push.scene.damping == base.damping
            && push.scene.material == base.material
    };
    let mut slow: Vec<&Penetration> = penetrations.iter().filter(like_base).collect();
    slow.sort_by(|a, b| a.speed().total_cmp(&b.speed()));
    // A small bed has no punches as slow as that; its slowest three then.
    let below = slow.iter().filter(|push| push.speed() <= SLOW).count();
    slow.truncate(below.max(3));
    let mut windows: Vec<(u64, f64, (f64, f64))> = Vec::new();
    for push in &slow {
        for of in of_penetration(push, watched) {
            let own = of.windows.iter();
            windows.extend(own.map(|window| {
                let depth = 0.5 * (window.from + window.to);
                (of.realization, depth, (push.speed(), window.pressure))
            }));
        }
    }
    let mut clouds: Vec<u64> = windows.iter().map(|of| of.0).collect();
    clouds.sort_unstable();
    clouds.dedup();
    let depths = distinct(windows.iter().map(|of| of.1));
    let rows = depths.into_iter().map(|depth| {
        // A cloud is the same bed at all speeds: it is one observation. A window that some speed did not get to is another line.
        let at_zero = clouds.iter().filter_map(|cloud| {
            let own = windows.iter().filter(|of| (of.0, of.1) == (*cloud, depth));
            let own: Vec<(f64, f64)> = own.map(|of| of.2).collect();
            let line = regression::intercept(&own).filter(|_| own.len() == slow.len());
            line.map(|of| of.estimate)
        });
        let at_zero: Vec<f64> = at_zero.collect();
        let pressure = mean_interval(&at_zero, 0.95);
        let degrees = |pressure: f64| soil.angle_for(pressure, depth).to_degrees();
        AtRest {
            depth,
            clouds: at_zero.len(),
            pressure,
            angle: pressure.map(|pressure| Interval {
                estimate: degrees(pressure.estimate),
                low: degrees(pressure.low),
                high: degrees(pressure.high),
            }),
            theory: soil.bears(depth, FRICTIONLESS_ANGLE),
            speeds: slow.iter().map(|push| push.speed()).collect(),
        }
    });
    rows.filter(|row| row.clouds > 0).collect()
}

/// From small to large, each once.
pub(super) fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table values for 30°: N_q = 18.40 and Vesić's N_γ = 22.40; for 10°: 2.47 and 1.22.
    #[test]
    fn factors_are_those_of_the_tables() {
        let factors = |degrees: f64| {
            let angle = degrees.to_radians();
            [surcharge_factor(angle), weight_factor(angle)]
        };
        for (degrees, table) in [(30.0, [18.40, 22.40]), (10.0, [2.47, 1.22])] {
            for (found, known) in factors(degrees).iter().zip(table) {
                assert!((found - known).abs() < 0.006, "{degrees} {found} {known}");
            }
        }
        // tan(π/4) is 1 to its last bit at most.
        assert!((factors(0.0)[0] - 1.0).abs() < 1.0e-14);
        assert_eq!(factors(0.0)[1], 0.0);
    }

    /// Clouds that differ by 1 kPa at every speed are three observations, not nine.
    #[test]
    fn a_cloud_is_one_observation_at_all_speeds() {
        let base = grains::scene::paper_scene(1, 300);
        let all =
            [0.01, 0.02, 0.05].map(|speed| Penetration::through(&base, (speed, 0.2, 0.0), 0.1, 3));
        let watched = all.iter().flat_map(|push| {
            (1..=3).map(|cloud| Watched {
                penetration: push.digest(),
                realization: cloud,
                stop: None,
                failed: None,
                depth: None,
                windows: vec![Window {
                    from: 0.0,
                    to: 0.01,
                    moments: 1,
                    pressure: 5.0e3 + 1.0e3 * cloud as f64 + 1.0e5 * push.speed(),
                    largest: 0.0,
                    on_floor: 0.0,
                }],
            })
        });
        let watched: Vec<Watched> = watched.collect();
        let soil = Soil::of(&base, 0.17);
        let [row] = &at_rest(&base, &all, &watched, &soil)[..] else {
            panic!("one window");
        };
        let found = row.pressure.expect("three clouds");
        assert_eq!(row.clouds, 3);
        assert!((found.estimate - 7.0e3).abs() < 1.0e-6, "{found:?}");
        // t = 4.303 on two degrees, times 1 kPa/√3.
        assert!(
            (found.high - found.estimate - 2484.1).abs() < 1.0,
            "{found:?}"
        );
        assert!(at_rest(&base, &all, &watched[..3], &soil).is_empty());
    }

    #[test]
    fn depth_and_angle_are_the_inverse_of_what_is_borne() {
        let soil = Soil {
            unit_weight: 21.4e3,
            half_width: 0.0225,
        };
        let angle = 0.1;
        let depth = soil.depth_for(44.4e3, angle);
        assert!((soil.bears(depth, angle) / 44.4e3 - 1.0).abs() < 1.0e-12);
        assert!((soil.angle_for(44.4e3, depth) / angle - 1.0).abs() < 1.0e-9);
        // A fluid bears its own displacement, and needs no friction for less.
        assert!((soil.bears(0.1, 0.0) / 2140.0 - 1.0).abs() < 1.0e-14);
        assert_eq!(soil.angle_for(1000.0, 0.1), 0.0);
    }
}
