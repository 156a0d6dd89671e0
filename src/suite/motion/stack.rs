//! Two grains on top of each other between floor and ceiling: MFiX's test DEM03 (Garg et al. 2012,
//! Powder Technology 220:122–137), all contacts closed all the time.

use super::swing::Swing;
use super::{ROUNDING, exact, rounding, seen};
use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Group, Line, Rung, Track};
use grains::model::{Axis, Model};
use grains::tables::Snapshot;

/// m.
const RADIUS: f64 = 0.5e-3;
/// Between floor and ceiling, m.
const HEIGHT: f64 = 1.8e-3;
/// kg/m³, the lower grain first.
const DENSITIES: [f64; 2] = [2.0e4, 1.0e4];
/// Of all three contacts, N/m.
const STIFFNESS: f64 = 1.0e3;
/// Heights at the start, m.
const START: [f64; 2] = [0.45e-3, 1.35e-3];
/// m/s².
const GRAVITY: f64 = 9.81;
/// s, and steps to 1 ms.
const DT: f64 = 2.5e-7;
const STEPS: u64 = 4000;

/// Two masses and three springs: y = y_eq + Σ q_j e_j/√m with the modes of M^−½ K M^−½.
struct Modes {
    mass: [f64; 2],
    equilibrium: [f64; 2],
    omega: [f64; 2],
    /// Unit vectors in the coordinates √m·(y − y_eq).
    shape: [[f64; 2]; 2],
}

impl Modes {
    fn new(mass: [f64; 2]) -> Self {
        let [m1, m2] = mass;
        let k = STIFFNESS;
        // k[[2, −1], [−1, 2]] y = f, from the forces at y = 0.
        let f1 = -k * RADIUS - m1 * GRAVITY;
        let f2 = k * RADIUS + k * HEIGHT - m2 * GRAVITY;
        let equilibrium = [(2.0 * f1 + f2) / (3.0 * k), (f1 + 2.0 * f2) / (3.0 * k)];
        let (a, d) = (2.0 * k / m1, 2.0 * k / m2);
        let c = -k / (m1 * m2).sqrt();
        let middle = 0.5 * (a + d);
        let apart = (0.5 * (a - d)).hypot(c);
        let (sin, cos) = (0.5 * (2.0 * c).atan2(a - d)).sin_cos();
        Modes {
            mass,
            equilibrium,
            omega: [(middle + apart).sqrt(), (middle - apart).sqrt()],
            shape: [[cos, sin], [-sin, cos]],
        }
    }

    /// Amplitudes of the modes at the start.
    fn amplitudes(&self) -> [f64; 2] {
        let off = [0, 1].map(|i| self.mass[i].sqrt() * (START[i] - self.equilibrium[i]));
        self.shape.map(|e| e[0] * off[0] + e[1] * off[1])
    }

    /// Heights from the modes' coordinates.
    fn heights(&self, q: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| {
            let sum = q[0] * self.shape[0][i] + q[1] * self.shape[1][i];
            self.equilibrium[i] + sum / self.mass[i].sqrt()
        })
    }

    /// Velocities half a step before the start, for rest at the start: −½dt·a.
    fn velocities(&self) -> [f64; 2] {
        let pull = self.amplitudes().into_iter().zip(self.omega);
        let q: Vec<f64> = pull
            .map(|(q, omega)| 0.5 * DT * omega * omega * q)
            .collect();
        let heights = self.heights([q[0], q[1]]);
        [0, 1].map(|i| heights[i] - self.equilibrium[i])
    }

    /// Heights after so many steps, by the exact solution of the discrete equations.
    fn stepped(&self, steps: u64) -> [f64; 2] {
        let amplitudes = self.amplitudes();
        self.heights([0, 1].map(|j| {
            let speed = 0.5 * DT * self.omega[j] * self.omega[j] * amplitudes[j];
            Swing::new(self.omega[j], DT, amplitudes[j], speed).place(steps)
        }))
    }

    /// Heights at this time.
    fn at(&self, time: f64) -> [f64; 2] {
        let amplitudes = self.amplitudes();
        self.heights([0, 1].map(|j| amplitudes[j] * (self.omega[j] * time).cos()))
    }

    /// A bound of the steps' error at this time: each mode is ωt(ω dt)²/24 behind, to leading order.
    fn error(&self, time: f64) -> f64 {
        let amplitudes = self.amplitudes();
        let lightest = self.mass[0].min(self.mass[1]).sqrt();
        let of = |j: usize| {
            let omega = self.omega[j];
            amplitudes[j].abs() / lightest * omega * time * (omega * DT).powi(2) / 24.0
        };
        of(0) + of(1)
    }
}

/// The rung.
pub fn rung() -> Rung {
    let [lower, upper] = [0, 1].map(|i| Grain::sphere([0.0, START[i]], RADIUS, DENSITIES[i]));
    let modes = Modes::new([lower.mass, upper.mass]);
    let [down, up] = modes.velocities();
    let grains = [lower.moving([0.0, down]), upper.moving([0.0, up])];
    let model = Model {
        gravity: [0.0, -GRAVITY],
        walls: vec![build::wall(Axis::Z, 0.0), build::wall(Axis::Z, HEIGHT)],
        ..build::model(build::springs(STIFFNESS / RADIUS), DT)
    };
    let case = build::case(
        "two stacked spheres",
        model,
        &grains,
        vec![0, STEPS / 2, STEPS],
    );
    Rung {
        name: "two-stacked-grains",
        title: "MFiX DEM03: two spheres between floor and ceiling swing in their two modes",
        group: Group::Exact,
        cases: vec![case],
        judge: Box::new(move |tracks| judge(&modes, &tracks[0])),
    }
}

fn judge(modes: &Modes, track: &Track) -> Vec<Line> {
    let mut lines = Vec::new();
    for (moment, steps) in [(1, STEPS / 2), (2, STEPS)] {
        let time = steps as f64 * DT;
        let (stepped, at) = (modes.stepped(steps), modes.at(time));
        for (id, kind) in ["lower", "upper"].into_iter().enumerate() {
            let found = seen(track, moment, id).position[1];
            let what = format!("height of the {kind} grain after {steps} steps");
            lines.push(exact(what, "m", found, stepped[id], steps, HEIGHT));
            lines.push(line(
                format!("height of the {kind} grain at {time} s"),
                "m",
                found,
                at[id],
                modes.error(time) + rounding(steps, HEIGHT),
                "the steps are behind by ωt(ω dt)²/24 in each mode, and all of it is allowed",
            ));
        }
    }
    let energy = |moment: usize| track.get(moment).map_or(f64::NAN, |at| energy(modes, at));
    let (start, end) = (energy(0), energy(2));
    lines.push(line(
        "energy after 4000 steps over that at the start, ½m v_{n−½}v_{n+½} + ½ku² + mgz",
        "1",
        end / start,
        1.0,
        rounding(STEPS, 1.0),
        ROUNDING,
    ));
    lines
}

/// The energy that linear leapfrog conserves: with the product of the velocities of both half steps.
fn energy(modes: &Modes, at: &Snapshot) -> f64 {
    let mut force = modes.mass.map(|mass| -mass * GRAVITY);
    let mut energy = 0.0;
    for contact in &at.contacts {
        let pair = [(contact.id1, -1.0), (contact.id2, 1.0)];
        for (id, sign) in pair {
            if let Some(force) = force.get_mut(id as usize) {
                *force += sign * contact.force()[1];
            }
        }
        energy += 0.5 * contact.normal_force * contact.normal_force / STIFFNESS;
    }
    let moving = modes.mass.iter().zip(&at.bodies.vz).zip(&at.bodies.z);
    for (((mass, before), height), force) in moving.zip(force) {
        let after = before + DT * force / mass;
        energy += 0.5 * mass * before * after + mass * GRAVITY * height;
    }
    energy
}
