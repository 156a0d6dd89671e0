//! A little crowd of grains that run into each other, the same on every machine.

use crate::suite::build::{self, Grain};
use grains::model::Law;
use grains::scene::{Tension, Viscosity};

/// Mean radius, m.
pub const RADIUS: f64 = 0.01;
/// kg/m³.
pub const DENSITY: f64 = 2000.0;
/// Distance of the grains at the start over the mean radius.
const PITCH: f64 = 2.3;
/// Speed at which the outermost grains run inwards; half of it is added at random, m/s.
const SPEED: f64 = 2.0;
/// Spins are up to so much, rad/s.
const SPIN: f64 = 100.0;

/// Spheres on a lattice about this centre, moved off their places, all running to the centre and all
/// spinning. Numbers between −1 and 1 are the fractions of multiples of irrational numbers.
pub fn grains(columns: usize, rows: usize, centre: [f64; 2]) -> Vec<Grain> {
    let mut grains = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let number = (grains.len() + 1) as f64;
            let random = |root: f64| 2.0 * (number * root.sqrt()).fract() - 1.0;
            let off = |index: usize, count: usize| index as f64 - 0.5 * (count - 1) as f64;
            let place = [off(column, columns), off(row, rows)];
            let furthest = 0.5 * columns.max(rows) as f64;
            let moved = [random(2.0), random(3.0)];
            let added = [random(5.0), random(7.0)];
            let position =
                [0, 1].map(|i| centre[i] + RADIUS * (PITCH * place[i] + 0.04 * moved[i]));
            let velocity = [0, 1].map(|i| SPEED * (0.5 * added[i] - place[i] / furthest));
            let radius = RADIUS * (1.0 + 0.1 * random(11.0));
            let grain = Grain::sphere(position, radius, DENSITY);
            grains.push(grain.moving(velocity).spinning(SPIN * random(13.0)));
        }
    }
    grains
}

/// Young's modulus whose springs give way by about three hundredths of a radius at the speed of the crowd, Pa,
/// and √(m/k), s.
pub fn modulus_and_time() -> [f64; 2] {
    let mass = Grain::sphere([0.0; 2], RADIUS, DENSITY).mass;
    let time = 0.03 * RADIUS / SPEED;
    [mass / (time * time * RADIUS), time]
}

/// Laws for crowds: friction alone, and with dashpots of about a twentieth of the critical damping, which
/// YADE has too.
pub fn laws() -> [(&'static str, Law); 2] {
    let [modulus, time] = modulus_and_time();
    let friction = build::friction(modulus, 0.5, 0.4);
    let viscosity = Viscosity::Dashpot {
        c_n: 0.1 * modulus * RADIUS * time,
        tension: Tension::Clipped,
    };
    let dashpots = build::with_viscosity(friction.clone(), viscosity);
    [("friction", friction), ("friction and dashpots", dashpots)]
}
