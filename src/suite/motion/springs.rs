//! The tangential spring alone: a grain squeezed between floor and ceiling that slides or turns to and
//! fro without ever reaching the Coulomb limit.

use super::swing::Swing;
use super::{exact, seen};
use crate::suite::build::{self, Grain};
use crate::suite::{Group, Rung, Track};
use grains::case::Case;
use grains::model::{Axis, Law, Model};
use grains::scene::{ContactLaw, Rotation, SlipVelocity, TorqueArms};

/// m.
const RADIUS: f64 = 1.0;
/// At floor and ceiling, m.
const OVERLAP: f64 = 1.0 / 64.0;
/// kg/m³.
const DENSITY: f64 = 1000.0;
/// k_s/k_n.
const RATIO: f64 = 0.5;
/// tan φ is 5.8: sliding would begin at a way of 0.18 m.
const FRICTION_ANGLE: f64 = 1.4;
/// Way, or angle times radius, m.
const AMPLITUDE: f64 = 0.05;
/// rad/s.
const OMEGA: f64 = 100.0;
/// s.
const DT: f64 = 0.1 / OMEGA;
/// Steps to the moments that are looked at.
const MOMENTS: [u64; 3] = [1, 137, 600];

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![sliding(), turning()]
}

/// The ways to count slip, with the arm that is used with it.
const WAYS: [(SlipVelocity, TorqueArms, &str); 2] = [
    (
        SlipVelocity::RatchetingCorrected,
        TorqueArms::HalfOverlap,
        "corrected slip",
    ),
    (
        SlipVelocity::ContactPoint,
        TorqueArms::ContactPoint,
        "slip of the contact point",
    ),
];

fn squeezed(name: &str, modulus: f64, contact: ContactLaw, grain: Grain) -> Case {
    let law = Law {
        contact,
        ..build::friction(modulus, RATIO, FRICTION_ANGLE)
    };
    let ceiling = 2.0 * (RADIUS - OVERLAP);
    let model = Model {
        walls: vec![build::wall(Axis::Z, 0.0), build::wall(Axis::Z, ceiling)],
        ..build::model(law, DT)
    };
    build::case(name, model, &[grain], MOMENTS.to_vec())
}

fn grain() -> Grain {
    Grain::sphere([0.0, RADIUS - OVERLAP], RADIUS, DENSITY)
}

/// ω² = 2a k_s/m. The factor a of the slip is 2R/(2R − u) with the correction, else 1. The contacts are
/// new at the start and are given a whole step of slip, so the springs are slack one step before it.
fn sliding() -> Rung {
    let velocity = AMPLITUDE * OMEGA;
    let cases = WAYS.map(|(slip_velocity, torque_arms, name)| {
        let factor = match slip_velocity {
            SlipVelocity::RatchetingCorrected => 2.0 * RADIUS / (2.0 * RADIUS - OVERLAP),
            SlipVelocity::ContactPoint => 1.0,
        };
        let grain = grain().moving([velocity, 0.0]);
        let stiffness = grain.mass * OMEGA * OMEGA / (2.0 * factor);
        let contact = ContactLaw {
            rotation: Rotation::Blocked,
            slip_velocity,
            torque_arms,
            ..ContactLaw::default()
        };
        squeezed(name, stiffness / (RATIO * RADIUS), contact, grain)
    });
    let judge = move |tracks: &[Track]| {
        let start = DT * velocity;
        let swing = Swing::new(OMEGA, DT, start, velocity);
        let mut lines = Vec::new();
        for (track, (.., name)) in tracks.iter().zip(WAYS) {
            for (moment, n) in MOMENTS.into_iter().enumerate() {
                let found = seen(track, moment, 0);
                let what = format!("way after {n} steps, {name}");
                let way = swing.place(n) - start;
                lines.push(exact(what, "m", found.position[0], way, n, AMPLITUDE));
                let what = format!("velocity after {n} steps, {name}");
                let speed = found.velocity[0];
                lines.push(exact(what, "m/s", speed, swing.velocity(n), n, velocity));
            }
        }
        lines
    };
    Rung {
        name: "tangential-spring",
        title: "A squeezed grain that cannot turn swings sideways with ω² = 2k_s/m",
        group: Group::Exact,
        cases: cases.into(),
        judge: Box::new(judge),
    }
}

/// Iω² = 2k_s R r with the corrected slip, which counts at the distance R, and the arm r = R − u/2;
/// 2k_s (R − u)² with both at the contact point.
fn turning() -> Rung {
    let spin = AMPLITUDE * OMEGA / RADIUS;
    let cases = WAYS.map(|(slip_velocity, torque_arms, name)| {
        let square = match torque_arms {
            TorqueArms::HalfOverlap => RADIUS * (RADIUS - 0.5 * OVERLAP),
            TorqueArms::ContactPoint => (RADIUS - OVERLAP) * (RADIUS - OVERLAP),
        };
        let grain = grain().spinning(spin);
        let stiffness = grain.inertia * OMEGA * OMEGA / (2.0 * square);
        let contact = ContactLaw {
            slip_velocity,
            torque_arms,
            ..ContactLaw::default()
        };
        squeezed(name, stiffness / (RATIO * RADIUS), contact, grain)
    });
    let judge = move |tracks: &[Track]| {
        let swing = Swing::new(OMEGA, DT, DT * spin, spin);
        let mut lines = Vec::new();
        for (track, (.., name)) in tracks.iter().zip(WAYS) {
            for (moment, n) in MOMENTS.into_iter().enumerate() {
                let found = seen(track, moment, 0);
                let what = format!("spin after {n} steps, {name}");
                lines.push(exact(what, "rad/s", found.spin, swing.velocity(n), n, spin));
            }
            let way = seen(track, MOMENTS.len() - 1, 0).position[0];
            let what = format!("way sideways, {name}");
            lines.push(exact(what, "m", way, 0.0, MOMENTS[2], AMPLITUDE));
        }
        lines
    };
    Rung {
        name: "turning-spring",
        title: "A squeezed grain turns to and fro with Iω² = 2k_s R r",
        group: Group::Exact,
        cases: cases.into(),
        judge: Box::new(judge),
    }
}
