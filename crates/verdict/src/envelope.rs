//! How far runs part that are the same but for rounding, and whether another engine's run lies among them. And how coarsely
//! that engine computes, by its answers to small changes of its start.

use evidence::in_parallel;
use serde::Serialize;

use crate::Answer;
use crate::constants::{FLYING, KINDS, situations, until};
use grains::native::{CaseOptions, NativeError, Noise, run_case};
use grains::scene::Viscosity;
use grains::tables::{Bodies, Snapshot};
use grains::task::Case;
use grains::variant::{self, Constant};

/// Replicas of each start; three times as many for an engine in single precision.
pub const REPLICAS: u64 = 8;
/// A run is equal to rounding if it is nowhere farther off than so many times the farthest replica.
pub const FACTOR: f64 = 3.0;
/// Numbers this coarse now and then change the sign in the damping of a grain that turns round, which takes a whole step's
/// force the other way; the grains that are farthest off, the shares from this one on, are allowed so many times as much then.
const COARSE: f64 = 1.0e-12;
const FLIPS: f64 = 30.0;
const FEW: usize = 2;
/// Looked at in each moment: half of the grains are at most so far off, nine of ten, 99 of a hundred, all.
const SHARES: [f64; 4] = [0.5, 0.9, 0.99, 1.0];

/// What is compared of a grain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Distance between the positions over the radius.
    Position,
    /// Difference of the velocities times Δt over the radius.
    Velocity,
    /// Difference of the spins times Δt.
    Spin,
}

impl Quantity {
    const ALL: [Quantity; 3] = [Quantity::Position, Quantity::Velocity, Quantity::Spin];

    /// With the unit in which it is counted.
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Quantity::Position => ("position", "R"),
            Quantity::Velocity => ("velocity", "R a step"),
            Quantity::Spin => ("spin", "rad a step"),
        }
    }

    /// How far each grain is off; empty for spins where nothing turns.
    fn apart(self, their: &Snapshot, own: &Snapshot, dt: f64) -> Vec<f64> {
        let (a, b) = (&their.bodies, &own.bodies);
        let grains = 0..b.len();
        match self {
            Quantity::Position => {
                let apart = |id: usize| (a.x[id] - b.x[id]).hypot(a.z[id] - b.z[id]) / b.radius[id];
                grains.map(apart).collect()
            }
            Quantity::Velocity => {
                let apart = |id: usize| (a.vx[id] - b.vx[id]).hypot(a.vz[id] - b.vz[id]);
                grains.map(|id| apart(id) * dt / b.radius[id]).collect()
            }
            Quantity::Spin => {
                let spins = a.spin.iter().zip(&b.spin);
                spins.map(|(a, b)| (a - b).abs() * dt).collect()
            }
        }
    }
}

/// Distances at the shares of grains, for each quantity.
type Summary = [[f64; SHARES.len()]; 3];

fn summary(their: &Snapshot, own: &Snapshot, dt: f64) -> Summary {
    Quantity::ALL.map(|quantity| {
        let mut apart = quantity.apart(their, own, dt);
        apart.sort_by(f64::total_cmp);
        SHARES.map(|share| {
            let at = (apart.len().saturating_sub(1)) as f64 * share;
            apart.get(at as usize).copied().unwrap_or(0.0)
        })
    })
}

/// Where a run is farthest off, measured by the replicas.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Farthest {
    /// How many times as far off as the farthest replica.
    pub ratio: f64,
    /// After so many steps.
    pub step: u64,
    pub quantity: Quantity,
    /// The grain that is farthest off then.
    pub grain: usize,
    /// How far that is, as [`Quantity`] counts it.
    pub apart: f64,
    /// The first moment at which the run has left the replicas, steps; none if it never has.
    pub left_after: Option<u64>,
}

impl Farthest {
    /// Whether it is never farther off than rounding takes it.
    pub fn is_rounding(&self) -> bool {
        self.ratio <= FACTOR
    }
}

/// One start, its native run and the reach of its replicas.
#[derive(Debug, Clone)]
pub struct Envelope {
    pub case: Case,
    pub own: Vec<Snapshot>,
    reach: Vec<Summary>,
}

impl Envelope {
    /// Runs the case and its replicas with this noise.
    pub fn new(case: &Case, noise: Noise) -> Result<Self, NativeError> {
        let own = run_case(case, None)?;
        let coarse = noise.position.max(noise.velocity).max(noise.overlap) > COARSE;
        let count = if coarse { 3 * REPLICAS } else { REPLICAS };
        let replicas = in_parallel(count as usize, |replica| {
            let noise = Noise {
                replica: replica as u64,
                ..noise
            };
            let options = CaseOptions {
                noise: Some(noise),
                ..CaseOptions::default()
            };
            run_case(case, options)
        });
        let dt = case.model.dt;
        // No number can be told from its neighbour.
        let (extent, fastest) = largest(&own);
        let radius = case.bodies.radius.iter().copied().fold(f64::MAX, f64::min);
        let least = [
            noise.position * extent / radius,
            noise.velocity * fastest * dt / radius,
            noise.velocity * dt,
        ];
        let mut reach = vec![least.map(|least| [least; SHARES.len()]); own.len()];
        for replica in replicas {
            for ((reach, their), own) in reach.iter_mut().zip(&replica?).zip(&own) {
                let apart = summary(their, own, dt);
                let reach = reach.as_flattened_mut().iter_mut();
                reach
                    .zip(apart.as_flattened())
                    .for_each(|(reach, apart)| *reach = reach.max(*apart));
            }
        }
        if coarse {
            for of_quantity in reach.iter_mut().flatten() {
                of_quantity[FEW..].iter_mut().for_each(|of| *of *= FLIPS);
            }
        }
        Ok(Envelope {
            case: case.clone(),
            own,
            reach,
        })
    }

    /// Where a run of this case is farthest off; the start itself is not looked at. None for a run with other moments.
    pub fn farthest(&self, theirs: &[Snapshot]) -> Option<Farthest> {
        self.farthest_from(&self.own, theirs)
    }

    /// The same from another run than the native one, such as one with the constants that were found.
    pub fn farthest_from(&self, own: &[Snapshot], theirs: &[Snapshot]) -> Option<Farthest> {
        let steps = |of: &[Snapshot]| of.iter().map(|of| of.step).collect::<Vec<_>>();
        let dt = self.case.model.dt;
        let mut farthest: Option<Farthest> = None;
        if theirs.is_empty() || steps(own) != steps(theirs) {
            return None;
        }
        let mut left_after = None;
        for ((reach, their), own) in self.reach.iter().zip(theirs).zip(own) {
            if own.step == 0 {
                continue;
            }
            let apart = summary(their, own, dt);
            for (index, quantity) in Quantity::ALL.into_iter().enumerate() {
                let ratios = apart[index].iter().zip(&reach[index]);
                // What is not a number is as far off as can be.
                let ratios = ratios.map(|(apart, reach)| apart / reach);
                let ratios = ratios.map(|of| if of.is_nan() { f64::INFINITY } else { of });
                let ratio = ratios.fold(0.0, f64::max);
                if ratio > FACTOR {
                    left_after = left_after.or(Some(own.step));
                }
                if farthest.as_ref().is_none_or(|of| ratio > of.ratio) {
                    let of_grains = quantity.apart(their, own, dt);
                    let worst = of_grains.iter().enumerate();
                    let worst = worst.max_by(|a, b| a.1.total_cmp(b.1));
                    let (grain, apart) = worst.map_or((0, 0.0), |(grain, apart)| (grain, *apart));
                    farthest = Some(Farthest {
                        ratio,
                        step: own.step,
                        quantity,
                        grain,
                        apart,
                        left_after: None,
                    });
                }
            }
        }
        farthest.map(|of| Farthest { left_after, ..of })
    }

    /// The grains that are farther off than rounding takes them, at the first moment at which there are any.
    pub fn outside(&self, own: &[Snapshot], theirs: &[Snapshot]) -> Vec<usize> {
        let dt = self.case.model.dt;
        for ((reach, their), own) in self.reach.iter().zip(theirs).zip(own) {
            let mut outside = Vec::new();
            for (index, quantity) in Quantity::ALL.into_iter().enumerate() {
                let most = FACTOR * reach[index][SHARES.len() - 1];
                let apart = quantity.apart(their, own, dt);
                let far = |id: &usize| apart[*id].is_nan() || apart[*id] > most;
                outside.extend((0..apart.len()).filter(far));
            }
            outside.sort_unstable();
            outside.dedup();
            if own.step > 0 && !outside.is_empty() {
                return outside;
            }
        }
        Vec::new()
    }

    /// The smallest fault in this constant, relative, with which the native engine would have left the replicas: from one run
    /// with a small fault, to which the distances are proportional, and confirmed by a run with the fault that was found.
    pub fn detection_limit(&self, constant: Constant) -> Result<Option<f64>, NativeError> {
        let Some(case) = with_larger(&self.case, constant, PROBE) else {
            return Ok(None);
        };
        let Some(far) = self.farthest(&run_case(&case, None)?) else {
            return Ok(None);
        };
        let mut limit = PROBE * FACTOR / far.ratio;
        // Rounding adds to the distances and now and then takes from them.
        for _ in 0..4 {
            limit *= 1.5;
            let case = with_larger(&self.case, constant, limit).unwrap_or(case.clone());
            let far = self.farthest(&run_case(&case, None)?);
            if far.is_some_and(|far| !far.is_rounding()) {
                return Ok(Some(limit));
            }
        }
        Ok(None)
    }
}

/// A fault that is large against rounding and small against everything else.
const PROBE: f64 = 1.0e-7;

/// The case with a constant that is larger by so much, relative; none where it plays no part or is of walls or punch alone.
fn with_larger(case: &Case, constant: Constant, larger: f64) -> Option<Case> {
    if !constant.is_in(case) {
        return None;
    }
    let factor = 1.0 + larger;
    let mut faulty = case.clone();
    let (model, bodies) = (&mut faulty.model, &mut faulty.bodies);
    let all = |column: &mut Vec<f64>| column.iter_mut().for_each(|value| *value *= factor);
    match constant {
        Constant::GrainStiffness => {
            model.law.modulus *= factor;
            model.law.stiffness_ratio /= factor;
        }
        Constant::WallStiffness | Constant::PunchStiffness => return None,
        Constant::WallPlace(index) => {
            let mean = bodies.radius.iter().sum::<f64>() / bodies.radius.len() as f64;
            model.walls[index].place += larger * mean;
        }
        Constant::PunchSpeed => faulty.punch.iter_mut().for_each(|of| of.velocity *= factor),
        Constant::ShearStiffness => model.law.stiffness_ratio *= factor,
        Constant::Friction => {
            model.law.friction_angle = (model.law.friction_angle.tan() * factor).atan();
        }
        Constant::Dashpot => {
            if let Viscosity::Dashpot { c_n, .. } = &mut model.law.contact.viscosity {
                *c_n *= factor;
            }
        }
        Constant::Damping => model.alpha *= factor,
        Constant::GravityAcross => model.gravity[0] += larger * model.gravity[1].abs(),
        Constant::GravityUp => model.gravity[1] *= factor,
        Constant::TimeStep => model.dt *= factor,
        Constant::Mass => all(&mut bodies.mass),
        Constant::Inertia => all(&mut bodies.inertia),
        Constant::Radius => all(&mut bodies.radius),
    }
    Some(faulty)
}

/// The largest coordinate, m, and the largest velocity component, m/s.
fn largest(of: &[Snapshot]) -> (f64, f64) {
    let largest = |columns: [&[f64]; 2]| {
        let all = columns.into_iter().flatten();
        all.fold(0.0f64, |largest, of| largest.max(of.abs()))
    };
    let first = of.first().map(|of| &of.bodies);
    first.map_or((0.0, 0.0), |of| {
        (largest([&of.x, &of.z]), largest([&of.vx, &of.vz]))
    })
}

/// The smallest change, over a metre or over a velocity: about the last bit of a number in double precision.
const SMALLEST: f64 = 1.0 / (1u64 << 52) as f64;
/// Each change is so many times the one before.
const RATIO: f64 = 8.0;
/// So many changes; the largest is 2·10⁻⁶.
const CHANGES: i32 = 12;
/// A change is noticed if so many of the grains answer that answer to the largest one.
const ANSWERING: f64 = 0.95;

/// The smallest changes that the engine notices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// Of a position, by the position one step later, m.
    pub position: f64,
    /// Of a velocity, by the velocity one step later, relative.
    pub velocity: f64,
    /// Of a position, by the velocities of grains in contact one step later, so by the forces, m.
    pub overlap: f64,
}

impl Resolution {
    /// Of numbers in double precision.
    pub const DOUBLE: Resolution = Resolution {
        position: SMALLEST,
        velocity: SMALLEST,
        overlap: SMALLEST,
    };

    /// The same as noise for replicas: numbers are off by half of what makes a difference.
    pub fn noise(&self) -> Noise {
        Noise {
            position: 0.5 * self.position,
            velocity: 0.5 * self.velocity,
            overlap: 0.5 * self.overlap,
            replica: 0,
        }
    }

    /// Whether all numbers are those of double precision, as far as it can be told.
    pub fn is_double(&self) -> bool {
        let coarsest = self.position.max(self.velocity).max(self.overlap);
        coarsest <= SMALLEST * RATIO * RATIO
    }

    pub fn name(&self) -> &'static str {
        match self.is_double() {
            true => "double precision",
            false => "single precision",
        }
    }

    /// The coarser of two, number by number.
    pub fn coarser(self, other: Resolution) -> Resolution {
        Resolution {
            position: self.position.max(other.position),
            velocity: self.velocity.max(other.velocity),
            overlap: self.overlap.max(other.overlap),
        }
    }

    /// The case as it is, then with ever larger changes, each looked at after one step. Of a grain in contact the place is
    /// changed, of one in flight the velocity too: nothing but its own velocity can answer there.
    pub fn cases(case: &Case) -> Vec<Case> {
        let situations = at_start(case);
        let changed = |change: f64| {
            let mut of = Case {
                moments: vec![1],
                ..case.clone()
            };
            let bodies = &mut of.bodies;
            for (id, situation) in situations.iter().enumerate() {
                // Each by another length, so that neighbours do not move together.
                let length = change * (1.0 + (id as f64 * 0.618).fract());
                bodies.x[id] += length;
                bodies.z[id] -= length;
                if *situation == FLYING {
                    bodies.vx[id] *= 1.0 + change;
                    bodies.vz[id] *= 1.0 + change;
                }
            }
            of
        };
        let mut all = vec![changed(0.0)];
        all.extend((0..CHANGES).map(|power| changed(SMALLEST * RATIO.powi(power))));
        all
    }

    /// From the answers to [`Resolution::cases`]; none if the engine refused one of them.
    pub fn measured(case: &Case, answers: &[Answer]) -> Option<Resolution> {
        let last = answers.iter().map(|of| of.as_deref().ok()?.last());
        let last = last.map(|of| of.map(|of| &of.bodies));
        let last: Option<Vec<&Bodies>> = last.collect();
        let (base, changed) = last.as_deref()?.split_first()?;
        let situations = at_start(case);
        // The smallest change that enough of these grains notice.
        let noticed = |answers: &dyn Fn(&Bodies, usize) -> bool, among: &dyn Fn(usize) -> bool| {
            let at_all =
                |id: &usize| among(*id) && changed.last().is_some_and(|of| answers(of, *id));
            let ids: Vec<usize> = (0..situations.len()).filter(at_all).collect();
            let mut level = SMALLEST;
            for of in changed {
                let share = ids.iter().filter(|id| answers(of, **id)).count() as f64;
                if share >= ANSWERING * ids.len() as f64 {
                    break;
                }
                level *= RATIO;
            }
            level
        };
        let moved = |of: &Bodies, id: usize| of.x[id] != base.x[id] && of.z[id] != base.z[id];
        let sped = |of: &Bodies, id: usize| of.vx[id] != base.vx[id] || of.vz[id] != base.vz[id];
        Some(Resolution {
            position: noticed(&moved, &|_| true),
            velocity: noticed(&sped, &|id| situations[id] == FLYING),
            // A force on a grain at a wall or the punch may be coarser than one between grains.
            overlap: (FLYING + 1..KINDS)
                .map(|kind| noticed(&sped, &|id| situations[id] == kind))
                .fold(0.0, f64::max),
        })
    }
}

/// The kind of place that each grain is in at the start.
fn at_start(case: &Case) -> Vec<usize> {
    situations(case, &variant::run(&until(case, 0), &Default::default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_number_is_that_of_either_sign() {
        let mut cloud = grains::generate::initial_bodies(&grains::scene::paper_scene(1, 2));
        (cloud.x, cloud.z) = (vec![0.5, -3.0], vec![2.0, 1.0]);
        (cloud.vx, cloud.vz) = (vec![0.0, 4.0], vec![-5.0, 1.0]);
        let case = Case {
            name: String::new(),
            model: grains::model::Model::of(&grains::scene::paper_scene(1, 2)),
            bodies: cloud,
            punch: None,
            moments: vec![0],
        };
        let start = grains::variant::run(&case, &Default::default());
        assert_eq!(largest(&start), (3.0, 5.0));
    }
}
