//! Chung and Ooi's tests 1 to 3 (Granular Matter 13 (2011) 643) with their materials, radii and speeds, on a
//! linear spring of the stiffness E·R; theirs is Hertz's, so the closed forms are the linear ones.

use super::bounces::{COARSE, Rebound, in_steps};
use super::continuum::{dashpot, nominal_ratio};
use super::experiment::{Experiment, largest, rung, view};
use super::head_on::{HeadOn, Partner};
use crate::suite::build::Grain;
use crate::suite::line;
use crate::suite::{Line, Rung, Track};
use grains::case::Case;
use grains::scene::{Tension, Viscosity};

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
        rung(
            "chung-ooi-1-2-elastic",
            "Chung and Ooi 1 and 2: force, overlap and contact time of elastic impacts, pair and wall",
            elastic(),
        ),
        rung(
            "chung-ooi-3-rebound",
            "Chung and Ooi 3: rebound from a wall, dashpots that do not pull",
            rebounds(Tension::Clipped),
        ),
        rung(
            "chung-ooi-3-rebound-unclipped",
            "Chung and Ooi 3: rebound from a wall, the restitution is the nominal one if dashpots may pull",
            rebounds(Tension::Unclipped),
        ),
    ]
}

/// A ball's material.
struct Material {
    name: &'static str,
    modulus: f64,
    density: f64,
}

const fn material(name: &'static str, modulus: f64, density: f64) -> Material {
    Material {
        name,
        modulus,
        density,
    }
}

fn impact(
    material: &Material,
    radius: f64,
    partner: fn(Grain) -> Partner,
    approach: f64,
) -> HeadOn {
    let grain = Grain::sphere([0.0; 2], radius, material.density);
    HeadOn {
        name: material.name.to_owned(),
        grain,
        partner: partner(grain),
        // Eq. 4 of the paper for equal grains, and a wall counts as one.
        stiffness: material.modulus * radius,
        viscosity: Viscosity::None,
        alpha: 0.0,
        approach,
        steps: 1000.0,
        lead: 5.3,
    }
}

/// F = v√(k m_eff), δ = v√(m_eff/k), T = π√(m_eff/k) with the speed v of the approach.
struct Elastic(HeadOn);

fn elastic() -> Vec<Box<dyn Experiment>> {
    let pairs = [
        material("glass", 4.8e10, 2800.0),
        material("limestone", 2.0e10, 2500.0),
    ];
    let walls = [
        material("aluminium alloy", 7.0e10, 2699.0),
        material("magnesium alloy", 4.0e10, 1800.0),
    ];
    let pair = |of: &Material| impact(of, 0.01, Partner::Grain, 20.0);
    let wall = |of: &Material| impact(of, 0.1, |_| Partner::Wall, 0.2);
    let all = pairs.iter().map(pair).chain(walls.iter().map(wall));
    all.map(|of| -> Box<dyn Experiment> { Box::new(Elastic(of)) })
        .collect()
}

impl Elastic {
    fn duration(&self) -> f64 {
        self.0.steps * self.0.dt()
    }

    /// The three steps nearest to the middle of the contact.
    fn middle(&self) -> [u64; 3] {
        let at = (self.0.lead + 0.5 * self.0.steps).round() as u64;
        [at - 1, at, at + 1]
    }

    fn end(&self) -> u64 {
        self.0.end(self.duration())
    }
}

impl Experiment for Elastic {
    fn cases(&self) -> Vec<Case> {
        let [before, middle, after] = self.middle();
        vec![self.0.case(vec![0, before, middle, after, self.end()])]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let state = |step| of.state(view(tracks, 0, step), step);
        let [_, time] = of.outcome(&state(0), &state(self.end()));
        let force = |step| {
            view(tracks, 0, step)
                .contact()
                .map_or(f64::NAN, |of| of.normal_force)
        };
        let (mass, stiffness) = (of.mass(), of.stiffness);
        let most = of.approach * (stiffness * mass).sqrt();
        let deepest = of.approach * (mass / stiffness).sqrt();
        let eighth = 0.125 * of.angle() * of.angle();
        let peak = "the top lies half a step off at most, (ω dt)²/8 lower, and touch between two steps raises it by \
                    that at most";
        vec![
            line(
                format!("largest force, {}", of.name),
                "N",
                largest(self.middle().map(force)),
                most,
                most * eighth,
                peak,
            ),
            line(
                format!("largest overlap, {}", of.name),
                "m",
                largest(self.middle().map(|step| state(step).overlap)),
                deepest,
                deepest * eighth,
                peak,
            ),
            line(
                format!("contact time, {}", of.name),
                "s",
                time,
                self.duration(),
                self.duration() * eighth,
                "the scheme's frequency is too high by (ω dt)²/24; thrice that",
            ),
        ]
    }
}

const AGAINST_A_WALL: [Material; 2] = [
    material("aluminium oxide", 3.8e11, 4000.0),
    material("cast iron", 1.0e11, 7000.0),
];

fn at_the_wall(of: &Material, restitution: f64) -> HeadOn {
    HeadOn {
        name: format!("{}, e {restitution}", of.name),
        ..impact(of, 2.5e-3, |_| Partner::Wall, 3.9)
    }
}

fn rebounds(tension: Tension) -> Vec<Box<dyn Experiment>> {
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for of in &AGAINST_A_WALL {
        for restitution in [0.2, 0.4, 0.6, 0.8, 1.0] {
            let ratio = nominal_ratio(restitution);
            let plain = in_steps(COARSE, ratio, tension, at_the_wall(of, restitution));
            if restitution == 1.0 {
                // Without a dashpot nothing is clipped, so one of the two rungs has it.
                if tension == Tension::Clipped {
                    experiments.push(Box::new(Rebound::of_dashpot(plain)));
                }
                continue;
            }
            let c_n = dashpot(ratio, plain.mass(), plain.stiffness);
            let viscosity = Viscosity::Dashpot { c_n, tension };
            experiments.push(Box::new(Rebound::of_dashpot(HeadOn { viscosity, ..plain })));
        }
    }
    experiments
}
