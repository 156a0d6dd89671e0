//! Rungs about motion, all of them with a solution in closed form: flight, oscillators, sliding and
//! rolling, conservation, statics.
//!
//! Most are held against the exact solution of the discrete equations, so that only rounding is left
//! and a fault of 1e-9 shows; some also against the differential equation, where what is left is
//! the order of the method.

mod conservation;
mod disc;
mod flight;
mod oscillator;
mod pile;
mod rolling;
mod springs;
mod stack;
mod swing;

use super::{Line, Rung, Track};

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    let mut rungs = flight::rungs();
    rungs.extend(oscillator::rungs());
    rungs.push(stack::rung());
    rungs.extend(springs::rungs());
    rungs.extend(rolling::rungs());
    rungs.extend(conservation::rungs());
    rungs.extend(pile::rungs());
    rungs.push(disc::rung());
    rungs
}

/// Why [`rounding`] is a bound.
const ROUNDING: &str =
    "exact but for rounding: eight roundings a step of half a unit in the last place, added up";

/// What so many steps of rounding may add up to in a number of this size. A step rounds the overlap,
/// the force, the acceleration, the velocity and the position, some of them twice.
fn rounding(steps: u64, size: f64) -> f64 {
    8.0 * 0.5 * f64::EPSILON * steps as f64 * size
}

fn line(
    quantity: impl Into<String>,
    unit: &str,
    value: f64,
    expected: f64,
    tolerance: f64,
    basis: impl Into<String>,
) -> Line {
    Line {
        quantity: quantity.into(),
        unit: unit.to_owned(),
        value,
        expected,
        tolerance,
        basis: basis.into(),
    }
}

/// A line that only rounding over so many steps may move, in a number of this size.
fn exact(
    quantity: impl Into<String>,
    unit: &str,
    value: f64,
    expected: f64,
    steps: u64,
    size: f64,
) -> Line {
    line(
        quantity,
        unit,
        value,
        expected,
        rounding(steps, size),
        ROUNDING,
    )
}

/// How a grain moves at a moment; not a number where the track has no such moment or grain.
#[derive(Debug, Clone, Copy)]
struct Seen {
    position: [f64; 2],
    /// Half a step before.
    velocity: [f64; 2],
    spin: f64,
}

fn seen(track: &Track, moment: usize, grain: usize) -> Seen {
    let bodies = track.get(moment).map(|snapshot| &snapshot.bodies);
    let of = |column: fn(&crate::tables::Bodies) -> &[f64]| {
        let value = bodies.and_then(|bodies| column(bodies).get(grain));
        value.copied().unwrap_or(f64::NAN)
    };
    Seen {
        position: [of(|bodies| &bodies.x), of(|bodies| &bodies.z)],
        velocity: [of(|bodies| &bodies.vx), of(|bodies| &bodies.vz)],
        spin: of(|bodies| &bodies.spin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::native::perturb::Perturbation;
    use crate::engine::native::run_case;

    fn climb(rung: &Rung, fault: Option<Perturbation>) -> Vec<Line> {
        let run = |case| run_case(case, fault);
        let tracks: Result<Vec<Track>, _> = rung.cases.iter().map(run).collect();
        tracks.map_or(Vec::new(), |tracks| (rung.judge)(&tracks))
    }

    #[test]
    fn report() {
        for rung in rungs() {
            let start = std::time::Instant::now();
            let lines = climb(&rung, None);
            println!(
                "{} ({} lines, {:?})",
                rung.name,
                lines.len(),
                start.elapsed()
            );
            for line in lines {
                let off = line.value - line.expected;
                println!(
                    "  {} {}: {} [{}] = {:.17e}, expected {:.17e}, off {:.2e}, share {:.2}",
                    if line.holds() { "ok  " } else { "FAIL" },
                    rung.name,
                    line.quantity,
                    line.unit,
                    line.value,
                    line.expected,
                    off,
                    off / line.tolerance
                );
            }
        }
    }
}
