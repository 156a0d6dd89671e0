//! Two grains that collide spinning or obliquely and slide all through: the forms of Chung and Ooi's
//! tests 5, 7 and 8.

use std::f64::consts::PI;

use super::continuum::Impact;
use super::experiment::{Experiment, View, rung, view};
use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Line, Rung, Track};
use grains::case::Case;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
        rung(
            "gross-sliding-pair",
            "Chung and Ooi 5 and 8 for a linear spring: two grains slide on each other, momenta are kept",
            gross_sliding(),
        ),
        rung(
            "opposite-spins",
            "Chung and Ooi 7: surfaces that run alike do not rub, spins stay",
            opposite_spins(),
        ),
    ]
}

/// Two grains side by side that approach each other at their centre of mass.
#[derive(Debug, Clone)]
struct Couple {
    name: String,
    grains: [Grain; 2],
    stiffness: f64,
    approach: f64,
}

const TAN_PHI: f64 = 0.2;
/// Steps in a contact time.
const STEPS: f64 = 1000.0;
/// Steps before touch.
const LEAD: f64 = 5.5;

impl Couple {
    /// Glass balls or discs of Chung and Ooi's test 1, with these radii, velocities across and spins.
    fn glass(name: &str, disc: bool, radii: [f64; 2], across: [f64; 2], spins: [f64; 2]) -> Self {
        let shape = if disc { Grain::disc } else { Grain::sphere };
        let of = |index: usize| {
            shape([0.0; 2], radii[index], 2800.0)
                .moving([0.0, across[index]])
                .spinning(spins[index])
        };
        // Discs one metre long weigh more: as stiff for their mass.
        let heavier = of(0).mass / Grain::sphere([0.0; 2], radii[0], 2800.0).mass;
        Couple {
            name: format!("{}, {name}", if disc { "discs" } else { "balls" }),
            grains: [of(0), of(1)],
            stiffness: heavier * 2.0 * 4.8e10 * radii[0] * radii[1] / (radii[0] + radii[1]),
            approach: 2.0,
        }
    }

    fn mass(&self) -> f64 {
        let [one, two] = self.grains.map(|grain| grain.mass);
        one * two / (one + two)
    }

    fn frequency(&self) -> f64 {
        (self.stiffness / self.mass()).sqrt()
    }

    fn dt(&self) -> f64 {
        PI / (self.frequency() * STEPS)
    }

    fn reach(&self) -> f64 {
        self.grains[0].radius + self.grains[1].radius
    }

    /// In the middle of the contact, and when it is over.
    fn moments(&self) -> [u64; 2] {
        [
            (LEAD + 0.5 * STEPS).round() as u64,
            (LEAD + 1.02 * STEPS + 3.0).ceil() as u64,
        ]
    }

    fn case(&self) -> Case {
        let [one, two] = self.grains;
        let share = two.mass / (one.mass + two.mass);
        let distance = self.reach() + LEAD * self.dt() * self.approach;
        let placed = |grain: Grain, x: f64, speed: f64| Grain {
            position: [x, 0.0],
            velocity: [speed, grain.velocity[1]],
            ..grain
        };
        let grains = [
            placed(one, 0.0, share * self.approach),
            placed(two, distance, (share - 1.0) * self.approach),
        ];
        let modulus = self.stiffness * self.reach() / (2.0 * one.radius * two.radius);
        let law = build::friction(modulus, 0.8, TAN_PHI.atan());
        let [middle, end] = self.moments();
        build::case(
            &self.name,
            build::model(law, self.dt()),
            &grains,
            vec![0, middle, end],
        )
    }

    /// What rounding may do to a velocity or spin, as a share of it.
    fn rounding(&self) -> f64 {
        2.0 * self.moments()[1] as f64 * f64::EPSILON
    }

    /// Velocity across of the surface of the second grain against that of the first, before touch, m/s.
    fn slip(&self) -> f64 {
        let [one, two] = self.grains;
        let turning = one.spin * one.radius + two.spin * two.radius;
        two.velocity[1] - one.velocity[1] + turning
    }

    /// How fast the grains pass each other at most, before or after the impact, m/s.
    fn passing(&self) -> f64 {
        let before = (self.grains[1].velocity[1] - self.grains[0].velocity[1]).abs();
        before.max((before - 2.0 * TAN_PHI * self.approach * self.slip().signum()).abs())
    }

    /// How far the line of centres turns while the grains touch, rad, at most.
    fn turn(&self) -> f64 {
        STEPS * self.dt() * self.passing() / self.reach()
    }
}

/// Impulses and turns along the line of centres in the middle of the contact.
struct GrossSliding(Couple);

fn gross_sliding() -> Vec<Box<dyn Experiment>> {
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    let (equal, unequal) = ([0.01, 0.01], [0.01, 0.02]);
    for disc in [false, true] {
        let all = [
            Couple::glass("equal, oblique", disc, equal, [-2.0, 2.0], [0.0, 0.0]),
            Couple::glass(
                "equal, equal spins",
                disc,
                equal,
                [0.0, 0.0],
                [300.0, 300.0],
            ),
            Couple::glass(
                "unequal, one spins",
                disc,
                unequal,
                [0.0, 0.0],
                [500.0, 0.0],
            ),
            Couple::glass(
                "unequal, oblique and spinning",
                disc,
                unequal,
                [1.0, -2.0],
                [-200.0, 50.0],
            ),
        ];
        for couple in all {
            experiments.push(Box::new(GrossSliding(couple)));
        }
    }
    experiments
}

/// Momentum of both grains and angular momentum about the origin, Σ m z v_x − m x v_z + Iω. The scheme
/// keeps all three, with velocities of half a step before the positions.
fn momenta(grains: &[Grain; 2], view: View) -> [f64; 3] {
    let of = |id: usize| {
        let ([x, z], [vx, vz]) = (view.position(id), view.velocity(id));
        let Grain { mass, inertia, .. } = grains[id];
        let angular = mass * (z * vx - x * vz) + inertia * view.spin(id);
        [mass * vx, mass * vz, angular]
    };
    let (one, two) = (of(0), of(1));
    [0, 1, 2].map(|index| one[index] + two[index])
}

impl GrossSliding {
    /// Components of a vector along the line of centres in the middle of the contact, and across.
    fn components(&self, tracks: &[Track], of: [f64; 2]) -> [f64; 2] {
        let middle = view(tracks, 0, self.0.moments()[0]);
        let (one, two) = (middle.position(0), middle.position(1));
        let (x, z) = (two[0] - one[0], two[1] - one[1]);
        let length = x.hypot(z);
        [
            (of[0] * x + of[1] * z) / length,
            (of[1] * x - of[0] * z) / length,
        ]
    }

    /// The contact along the line of centres in the middle of it.
    fn impact(&self, tracks: &[Track]) -> Impact {
        let start = view(tracks, 0, 0);
        let (one, two) = (start.velocity(0), start.velocity(1));
        let [approach, _] = self.components(tracks, [one[0] - two[0], one[1] - two[1]]);
        Impact {
            mass: self.0.mass(),
            stiffness: self.0.stiffness,
            dashpot: 0.0,
            pull: 0.0,
            approach,
            clipped: true,
        }
    }

    fn impulses(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let impact = self.impact(tracks);
        let end = view(tracks, 0, of.moments()[1]);
        let (before, after) = (view(tracks, 0, 0).velocity(1), end.velocity(1));
        let push = [0, 1].map(|axis| of.grains[1].mass * (after[axis] - before[axis]));
        let [normal, tangential] = self.components(tracks, push);
        let turn = of.turn();
        let small = turn * turn + (PI / STEPS).powi(2);
        let of_normal = 0.25 * turn * of.passing() / of.approach + small;
        let impulse = 2.0 * impact.mass * impact.approach;
        let mut lines = vec![
            line(
                format!("tangential over normal impulse, {}", of.name),
                "1",
                tangential.abs() / normal,
                TAN_PHI,
                0.25 * turn + small,
                "the mean normal of the contact is a quarter of its turn off the middle one at most; \
                 second order in turn and step",
            ),
            line(
                format!("normal impulse over 2 m_eff v, {}", of.name),
                "1",
                normal / impulse,
                1.0,
                of_normal,
                "a quarter of the turn of the normal times passing over approach speed; second order in turn \
                 and step",
            ),
        ];
        // Both grains are turned by μJ at the arms R − u/2.
        for (id, grain) in of.grains.iter().enumerate() {
            let turning = grain.radius * impulse - 0.5 * impact.overlap_impulse();
            let expected = -of.slip().signum() * TAN_PHI * turning / grain.inertia;
            lines.push(line(
                format!("change of spin {}, {}", id + 1, of.name),
                "rad/s",
                end.spin(id) - grain.spin,
                expected,
                expected.abs() * of_normal,
                "as the normal impulse",
            ));
        }
        lines
    }

    fn conservation(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let at = |step| momenta(&of.grains, view(tracks, 0, step));
        let (before, after) = (at(0), at(of.moments()[1]));
        let momentum = |grain: &Grain| grain.mass * (of.approach + grain.velocity[1].abs());
        let angular =
            |grain: &Grain| of.reach() * momentum(grain) + grain.inertia * grain.spin.abs();
        let momentum: f64 = of.grains.iter().map(momentum).sum();
        let angular: f64 = of.grains.iter().map(angular).sum();
        let figures = [
            ("momentum across", "N·s", momentum),
            ("momentum up", "N·s", momentum),
            ("angular momentum", "N·m·s", angular),
        ];
        let kept = |(index, (what, unit, scale)): (usize, &(&str, &str, f64))| {
            line(
                format!("{what}, {}", of.name),
                unit,
                after[index],
                before[index],
                scale * of.rounding(),
                "the scheme keeps it; rounding in every step",
            )
        };
        figures.iter().enumerate().map(kept).collect()
    }
}

impl Experiment for GrossSliding {
    fn cases(&self) -> Vec<Case> {
        vec![self.0.case()]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let mut lines = self.impulses(tracks);
        lines.extend(self.conservation(tracks));
        lines
    }
}

/// Spins of opposite sign and equal surface speed.
struct OppositeSpins(Couple);

fn opposite_spins() -> Vec<Box<dyn Experiment>> {
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for disc in [false, true] {
        let all = [
            Couple::glass("equal", disc, [0.01, 0.01], [0.0, 0.0], [300.0, -300.0]),
            Couple::glass(
                "one twice as large",
                disc,
                [0.01, 0.02],
                [0.0, 0.0],
                [300.0, -150.0],
            ),
        ];
        for couple in all {
            experiments.push(Box::new(OppositeSpins(couple)));
        }
    }
    experiments
}

impl Experiment for OppositeSpins {
    fn cases(&self) -> Vec<Case> {
        vec![self.0.case()]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let name = &of.name;
        let end = view(tracks, 0, of.moments()[1]);
        let mut lines = Vec::new();
        for (id, grain) in of.grains.iter().enumerate() {
            let stays = "no slip, no tangential force; rounding in every step";
            lines.push(line(
                format!("spin {}, {name}", id + 1),
                "rad/s",
                end.spin(id),
                grain.spin,
                grain.spin.abs() * of.rounding(),
                stays,
            ));
            lines.push(line(
                format!("velocity {} across, {name}", id + 1),
                "m/s",
                end.velocity(id)[1],
                0.0,
                of.approach * of.rounding(),
                stays,
            ));
        }
        lines
    }
}
