//! How far runs part that are the same but for rounding, and whether another engine's run lies among them. And how coarsely
//! that engine computes, by its answers to small changes of its start.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::OnceLock;

use evidence::in_parallel;
use serde::Serialize;

use crate::Answer;
use crate::constants::{FLYING, KINDS, situations, until};
use crate::contacts;
use grains::constant::Constant;
use grains::native::{CaseOptions, Fault, NativeError, Noise, run_case};
use grains::tables::{Bodies, Punch, Snapshot};
use grains::task::Case;
use grains::variant::{self, Variant};
use grains::vector::{hypot, minus};
use grains::with_rows;

/// Replicas of each start; three times as many for an engine in single precision.
pub const REPLICAS: u64 = 8;
/// A run is equal to rounding if it is nowhere farther off than so many times the farthest replica.
pub const FACTOR: f64 = 3.0;
/// Numbers this coarse now and then change the sign in the damping of a grain that turns round, which takes a whole step's
/// force the other way; the grains that are farthest off, the shares from this one on, are allowed so many times as much then.
const COARSE: f64 = 1.0e-12;
const FLIPS: f64 = 30.0;
const FEW: usize = 2;
/// For so many steps after the start replicas stay close together.
const NARROW_UNTIL: u64 = 100;
/// Nine of ten grains that rounding may take so far, over the radius, show no fault.
const WIDE: f64 = 1.0e-3;
/// Looked at in each moment: half of the grains are at most so far off, nine of ten, 99 of a hundred, all.
const SHARES: [f64; 4] = [0.5, 0.9, 0.99, 1.0];

with_rows! {
    /// What is compared of a grain or of a contact, with the unit in which it is counted.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    Quantity: (&'static str, &'static str) {
        /// Distance between the positions over the radius.
        Position ("position", "R");
        /// Difference of the velocities times Δt over the radius.
        Velocity ("velocity", "R a step");
        /// Difference of the spins times Δt.
        Spin ("spin", "rad a step");
        /// Difference of the overlaps over the radius.
        Overlap ("overlap", "R");
        /// Difference of the normal forces times Δt²/(mR).
        NormalForce ("normal force", "mR/Δt²");
        /// The same of the tangential ones.
        TangentialForce ("tangential force", "mR/Δt²");
        /// Angle between the normals.
        Normal ("normal", "rad");
        /// Distance between the contact points over the radius.
        Point ("contact point", "R");
        /// Of the punch, over the smallest radius.
        PunchPlace ("place", "R");
        /// Force on it times Δt²/(mR) of the smallest grain.
        PunchForce ("force", "mR/Δt²");
    }
}

impl Quantity {
    /// With the unit in which it is counted.
    pub fn name(self) -> (&'static str, &'static str) {
        *self.row()
    }
}

const ALL: usize = MOTION + contacts::NUMBERS + 2;
/// So many are of grains, the rest of contacts.
const MOTION: usize = 3;
/// Normals and points.
const PLACES: Range<usize> = MOTION + 3..MOTION + contacts::NUMBERS;

/// How far two moments are apart: numbers for each grain, then for each contact that either has.
struct Apart {
    numbers: [Vec<f64>; ALL],
    pairs: Vec<(u32, u32)>,
}

impl Apart {
    fn new(their: &Snapshot, own: &Snapshot, case: &Case) -> Self {
        let dt = case.model.dt;
        let (a, b) = (&their.bodies, &own.bodies);
        let grains = 0..b.len();
        let way = |id: usize| hypot(minus(a.position(id), b.position(id))) / b.radius[id];
        let speed = |id: usize| hypot(minus(a.velocity(id), b.velocity(id))) * dt / b.radius[id];
        let spin = |id: usize| hypot(minus(a.angular_velocity(id), b.angular_velocity(id))) * dt;
        let turning = 0..a.spin.len().min(b.spin.len());
        let (pairs, of_contacts) = contacts::apart(their, own, &case.model.walls, dt);
        let of_grains = [
            grains.clone().map(way).collect(),
            grains.map(speed).collect(),
            turning.map(spin).collect(),
        ];
        let (radius, mass) = (least(&b.radius), least(&b.mass));
        let of_punch = match (their.punch, own.punch) {
            (Some(a), Some(b)) => {
                let [x, z] = [0, 1].map(|axis| a.centre[axis] - b.centre[axis]);
                // Where it started and how fast it goes tell its depth and its place.
                let told = (a.start - b.start).abs() + dt * (a.velocity - b.velocity).abs();
                let force = (a.force - b.force).abs() * dt * dt / (mass * radius);
                [vec![(x.hypot(z) + told) / radius], vec![force]]
            }
            (None, None) => Default::default(),
            _ => [vec![f64::INFINITY], vec![f64::INFINITY]],
        };
        let mut all = of_grains.into_iter().chain(of_contacts).chain(of_punch);
        Apart {
            numbers: std::array::from_fn(|_| all.next().unwrap_or_default()),
            pairs,
        }
    }

    /// What this quantity is of.
    fn body(&self, index: usize, at: usize) -> String {
        match self.pairs.get(at) {
            _ if index >= MOTION + contacts::NUMBERS => "the punch".to_owned(),
            Some((one, two)) if index >= MOTION => format!("contact {one}–{two}"),
            _ => format!("grain {at}"),
        }
    }

    fn summary(&self) -> Summary {
        std::array::from_fn(|index| {
            let mut apart = self.numbers[index].clone();
            apart.sort_by(f64::total_cmp);
            SHARES.map(|share| {
                let at = (apart.len().saturating_sub(1)) as f64 * share;
                apart.get(at as usize).copied().unwrap_or(0.0)
            })
        })
    }
}

/// Distances at the shares of grains or contacts, for each quantity.
type Summary = [[f64; SHARES.len()]; ALL];

/// Each distance becomes at least so many times the other one.
fn raise(reach: &mut Summary, other: &Summary, times: f64) {
    let both = reach
        .as_flattened_mut()
        .iter_mut()
        .zip(other.as_flattened());
    both.for_each(|(reach, other)| *reach = reach.max(times * other));
}

fn multiply(reach: &mut [[f64; SHARES.len()]], times: f64) {
    let all = reach.as_flattened_mut().iter_mut();
    all.for_each(|value| *value *= times);
}

/// Where a run is farthest off, measured by the replicas.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Farthest {
    /// How many times as far off as the farthest replica.
    pub ratio: f64,
    /// After so many steps.
    pub step: u64,
    pub quantity: Quantity,
    /// The grain or contact that is farthest off then.
    pub body: String,
    /// How far that is, as [`Quantity`] counts it.
    pub apart: f64,
    /// The first moment at which the run has left the replicas, steps; none if it never has.
    pub left_after: Option<u64>,
    /// How many times as far off its motion is, contact tables aside.
    pub of_motion: f64,
}

impl Farthest {
    /// Whether it is never farther off than rounding takes it.
    pub fn is_rounding(&self) -> bool {
        self.ratio <= FACTOR
    }

    /// The same of the motion alone.
    pub fn moves_right(&self) -> bool {
        self.of_motion <= FACTOR
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
        let replicas = in_parallel(replicas(noise), |replica| {
            let options = CaseOptions {
                noise: Some(of_replica(noise, replica)),
                ..CaseOptions::default()
            };
            run_case(case, options)
        });
        let replicas: Result<Vec<_>, _> = replicas.into_iter().collect();
        Ok(Envelope::of(case.clone(), own, &replicas?, noise))
    }

    /// The same of runs that were made already; of the case its model and its grains are asked for.
    pub fn of(case: Case, own: Vec<Snapshot>, replicas: &[Vec<Snapshot>], noise: Noise) -> Self {
        let dt = case.model.dt;
        let begun = own.first().map_or(0, |snapshot| snapshot.step);
        // No number can be told from its neighbour.
        let (extent, fastest) = largest(&own);
        let (radius, mass) = (least(&case.bodies.radius), least(&case.bodies.mass));
        let law = &case.model.law;
        // A number in other units is rounded on its way there and on its way back.
        let [position, velocity, overlap] =
            [noise.position, noise.velocity, noise.overlap].map(|noise| 2.0 * noise);
        let length = position * extent + overlap;
        // An engine that computes forces in single precision writes its contacts so.
        let coarsest = noise.position.max(noise.velocity).max(noise.overlap);
        let written = if coarsest > 0.5 * FINE { SINGLE } else { 0.0 };
        let contacts = || own.iter().flat_map(|snapshot| &snapshot.contacts);
        let overlaps = contacts().map(|contact| contact.overlap);
        let written_length = length + written * overlaps.fold(0.0, f64::max);
        // The stiffest pair of a grain has k_n = 2ER, where the other one is much larger.
        let stiffness = 2.0 * law.usual_stiffness(radius) / radius;
        let spring = stiffness * law.stiffness_ratio.max(1.0) * dt * dt / mass;
        let force = contacts().fold(0.0, |most: f64, contact| {
            let grain = contact.id2 as usize;
            let push = dt * dt / (case.bodies.mass[grain] * case.bodies.radius[grain]);
            most.max(contact.normal_force.abs() * push)
        });
        let steps = own.last().map_or(0, |last| last.step.abs_diff(begun));
        let steps = steps.max(1) as f64;
        let punch = case.ids().punch();
        let at_punch = own.iter().map(|snapshot| {
            let contacts = snapshot.contacts.iter();
            contacts.filter(|contact| contact.id1 == punch).count()
        });
        let on_punch = 1.0 + at_punch.max().unwrap_or(0) as f64;
        let force = spring * length + velocity.max(written) * force;
        let least = [
            position * extent / radius,
            velocity * fastest * dt / radius,
            velocity * dt,
            written_length / radius,
            force,
            force,
            written + length / radius,
            length / radius,
            // It moves by a sum of steps, each of which is rounded.
            position * extent * steps / radius,
            // Where it is another sum of these steps, all that touches it pushes it otherwise.
            force * on_punch + spring * position * extent * steps * (on_punch - 1.0),
        ];
        let mut reach = vec![least.map(|least| [least; SHARES.len()]); own.len()];
        for replica in replicas {
            for ((reach, their), own) in reach.iter_mut().zip(replica).zip(&own) {
                raise(reach, &Apart::new(their, own, &case).summary(), 1.0);
            }
        }
        // Points and normals of pairs that both runs have move with the grains, and replicas may have few of these pairs.
        for of_moment in &mut reach {
            let moved = of_moment[0][SHARES.len() - 1];
            let of_pairs = &mut of_moment[PLACES];
            let all = of_pairs.as_flattened_mut().iter_mut();
            all.for_each(|value| *value = value.max(moved));
        }
        // Where distances grow by orders they scatter by as much.
        for (reach, own) in reach.iter_mut().zip(&own) {
            if own.step > begun + NARROW_UNTIL {
                multiply(reach, FLIPS);
            }
        }
        if is_coarse(noise) {
            for of_moment in &mut reach {
                for of_quantity in of_moment.iter_mut() {
                    let farthest = of_quantity[FEW..].iter_mut();
                    farthest.for_each(|value| *value *= FLIPS);
                }
                // What is written of a contact is rounded once more.
                multiply(&mut of_moment[MOTION..], FLIPS);
            }
        }
        Envelope { case, own, reach }
    }

    /// The same with everything after the start allowed to be as far off as this state is from the native run's last one, and so many times
    /// as much as contacts scatter.
    pub(crate) fn reaching_the_last(mut self, other: &Snapshot) -> Self {
        if let Some(last) = self.own.last() {
            let apart = Apart::new(other, last, &self.case).summary();
            for reach in self.reach.iter_mut().skip(1) {
                raise(reach, &apart, FLIPS);
            }
        }
        self
    }

    /// How far nine of ten grains part at most, over the radius.
    pub(crate) fn widest(&self) -> f64 {
        let reach = self.reach.iter();
        reach.fold(0.0, |most, moment| most.max(moment[0][1]))
    }

    /// The first moment at which they part so far that nothing would be seen, steps.
    pub(crate) fn wide_from(&self) -> Option<u64> {
        let mut moments = self.reach.iter().zip(&self.own);
        let wide = moments.find(|(reach, _)| reach[0][1] > WIDE);
        wide.map(|(_, own)| own.step)
    }

    /// Where a run of this case is farthest off; of the start itself the contacts alone are looked at. None for a run with other
    /// moments.
    pub fn farthest(&self, theirs: &[Snapshot]) -> Option<Farthest> {
        self.farthest_from(&self.own, theirs)
    }

    /// The same from another run than the native one, such as one with the constants that were found.
    pub fn farthest_from(&self, own: &[Snapshot], theirs: &[Snapshot]) -> Option<Farthest> {
        let steps = |run: &[Snapshot]| run.iter().map(|snapshot| snapshot.step).collect::<Vec<_>>();
        let mut farthest: Option<Farthest> = None;
        if theirs.is_empty() || steps(own) != steps(theirs) {
            return None;
        }
        let (mut left_after, mut of_motion) = (None, 0.0f64);
        for ((reach, their), own) in self.reach.iter().zip(theirs).zip(own) {
            let apart = Apart::new(their, own, &self.case);
            let summary = apart.summary();
            for (index, quantity) in Quantity::ALL.into_iter().enumerate() {
                let ratio = ratio(&summary[index], &reach[index]);
                if index < MOTION {
                    of_motion = of_motion.max(ratio);
                }
                if ratio > FACTOR {
                    left_after = left_after.or(Some(own.step));
                }
                if farthest.as_ref().is_none_or(|far| ratio > far.ratio) {
                    let worst = apart.numbers[index].iter().enumerate();
                    let worst = worst.max_by(|a, b| a.1.total_cmp(b.1));
                    let (at, far) = worst.map_or((0, 0.0), |(at, apart)| (at, *apart));
                    farthest = Some(Farthest {
                        ratio,
                        step: own.step,
                        quantity,
                        body: apart.body(index, at),
                        apart: far,
                        left_after: None,
                        of_motion: 0.0,
                    });
                }
            }
        }
        farthest.map(|far| Farthest {
            left_after,
            of_motion,
            ..far
        })
    }

    /// The grains whose motion is farther off than rounding takes it, at the first moment at which there are any, with the step.
    pub fn outside(&self, own: &[Snapshot], theirs: &[Snapshot]) -> (Vec<usize>, u64) {
        let (_, outside, step) = self.first_outside(own, theirs, 0..MOTION);
        (outside, step)
    }

    /// The contacts that are farther off than rounding takes them, at the first moment at which there are any, with the step.
    pub fn contacts_outside(
        &self,
        own: &[Snapshot],
        theirs: &[Snapshot],
    ) -> (Vec<(u32, u32)>, u64) {
        let of_contacts = MOTION..MOTION + contacts::NUMBERS;
        let (pairs, outside, step) = self.first_outside(own, theirs, of_contacts);
        (outside.into_iter().map(|at| pairs[at]).collect(), step)
    }

    /// Where one of these quantities is off, with all pairs of that moment.
    fn first_outside(
        &self,
        own: &[Snapshot],
        theirs: &[Snapshot],
        quantities: Range<usize>,
    ) -> (Vec<(u32, u32)>, Vec<usize>, u64) {
        for ((reach, their), own) in self.reach.iter().zip(theirs).zip(own) {
            let apart = Apart::new(their, own, &self.case);
            let outside = quantities.clone().flat_map(|index| {
                let most = FACTOR * reach[index][SHARES.len() - 1];
                let far = move |(_, apart): &(usize, &f64)| apart.is_nan() || **apart > most;
                let all = apart.numbers[index].iter().enumerate();
                all.filter(far).map(|(at, _)| at)
            });
            let outside: BTreeSet<usize> = outside.collect();
            if !outside.is_empty() {
                return (apart.pairs, outside.into_iter().collect(), own.step);
            }
        }
        Default::default()
    }

    /// What is wrong with contact tables, at the first moment at which they are off and the motion is not.
    pub fn tables_in_words(&self, theirs: &[Snapshot]) -> Option<String> {
        for ((reach, their), own) in self.reach.iter().zip(theirs).zip(&self.own) {
            let summary = Apart::new(their, own, &self.case).summary();
            let ratios: Vec<f64> = (0..ALL)
                .map(|index| ratio(&summary[index], &reach[index]))
                .collect();
            let off = |ratios: &[f64]| ratios.iter().any(|ratio| *ratio > FACTOR);
            if off(&ratios[MOTION..]) && !off(&ratios[..MOTION]) {
                let said = contacts::in_words(their.into(), own.into());
                return Some(format!("after {} steps {said}", own.step));
            }
        }
        None
    }

    /// About the smallest fault in this constant, relative, with which the native engine would have left the replicas: from one run with
    /// a small fault, to which the distances are proportional. None where the constant changes nothing.
    pub fn detection_limit_about(&self, constant: Constant) -> Result<Option<f64>, NativeError> {
        if !constant.is_in(&self.case) {
            return Ok(None);
        }
        let far = self.faulty(constant, PROBE)?.filter(|far| far.ratio > 0.0);
        Ok(far.map(|far| PROBE * FACTOR / far.ratio))
    }

    /// The smallest one, from about which it is, confirmed by a run with the fault that was found.
    pub fn detection_limit(&self, constant: Constant, about: f64) -> Result<f64, NativeError> {
        let mut limit = about;
        // Rounding adds to the distances and now and then takes from them.
        for _ in 0..4 {
            limit *= LARGER;
            if limit > 1.0
                || self
                    .faulty(constant, limit)?
                    .is_some_and(|far| !far.is_rounding())
            {
                break;
            }
        }
        Ok(limit)
    }

    /// How far the native engine is off with this constant larger by so much.
    fn faulty(&self, constant: Constant, larger: f64) -> Result<Option<Farthest>, NativeError> {
        let fault = Fault::Sized(constant, larger);
        Ok(self.farthest(&run_case(&self.case, Some(fault))?))
    }

    /// How far the step written out is off with this variant, within so many steps.
    pub fn changed(&self, variant: &Variant, steps: u64) -> Option<Farthest> {
        let case = until(&self.case, steps);
        let count = case.moments.len().min(self.own.len());
        self.farthest_from(&self.own[..count], &variant::run(&case, variant))
    }
}

/// What is made once for engines in double precision, and anew for any other.
pub(crate) fn once<T: Clone>(
    double: &OnceLock<T>,
    resolution: Resolution,
    make: impl FnOnce() -> Result<T, NativeError>,
) -> Result<T, NativeError> {
    let is_double = resolution == Resolution::DOUBLE;
    if let Some(known) = double.get().filter(|_| is_double) {
        return Ok(known.clone());
    }
    let made = make()?;
    if is_double {
        double.get_or_init(|| made.clone());
    }
    Ok(made)
}

/// The step written out is slow, and a few of them tell enough.
pub const STEPS_WRITTEN_OUT: u64 = 10;

/// The farthest of the shares over what replicas reach; what is not a number is as far off as can be.
fn ratio(apart: &[f64; SHARES.len()], reach: &[f64; SHARES.len()]) -> f64 {
    let ratios = apart.iter().zip(reach).map(|(apart, reach)| match apart {
        0.0 => 0.0,
        _ => apart / reach,
    });
    let ratios = ratios.map(|ratio| if ratio.is_nan() { f64::INFINITY } else { ratio });
    ratios.fold(0.0, f64::max)
}

fn least(column: &[f64]) -> f64 {
    column.iter().copied().fold(f64::MAX, f64::min)
}

fn is_coarse(noise: Noise) -> bool {
    noise.position.max(noise.velocity).max(noise.overlap) > COARSE
}

/// How many replicas an envelope has.
pub fn replicas(noise: Noise) -> usize {
    let count = if is_coarse(noise) {
        3 * REPLICAS
    } else {
        REPLICAS
    };
    count as usize
}

/// The noise of one of them.
pub fn of_replica(noise: Noise, replica: usize) -> Noise {
    Noise {
        replica: replica as u64,
        ..noise
    }
}

/// A fault that is large against rounding and small against everything else.
const PROBE: f64 = 1.0e-7;
/// A detection limit is at least so many times as large as what one run says.
pub(crate) const LARGER: f64 = 1.5;

/// At least so many grains tell how many digits are written.
const ENOUGH: usize = 50;

/// Whether all places have at most eight decimal digits: the tables are rounded, whatever the engine computes in. A number of single
/// precision has nine.
pub fn is_rounded(run: &[Snapshot]) -> bool {
    let few = |value: &f64| format!("{value:.7e}").parse() == Ok(*value);
    let last = run
        .last()
        .filter(|snapshot| snapshot.step > 0 && snapshot.bodies.len() >= ENOUGH);
    last.is_some_and(|snapshot| {
        let bodies = &snapshot.bodies;
        bodies.x.iter().chain(&bodies.y).chain(&bodies.z).all(few)
    })
}

/// The largest coordinate, m, and the largest velocity component, m/s.
pub(crate) fn largest(run: &[Snapshot]) -> (f64, f64) {
    run.first().map_or((0.0, 0.0), |snapshot| {
        let bodies = &snapshot.bodies;
        let fastest = largest_of([&bodies.vx, &bodies.vy, &bodies.vz]);
        (extent(&snapshot.bodies, snapshot.punch), fastest)
    })
}

/// The largest coordinate, m.
fn extent(bodies: &Bodies, punch: Option<Punch>) -> f64 {
    let top = punch.map_or(0.0, |punch| punch.centre[1].abs() + punch.half_extents[1]);
    largest_of([&bodies.x, &bodies.y, &bodies.z]).max(top)
}

fn largest_of(columns: [&[f64]; 3]) -> f64 {
    let all = columns.into_iter().flatten();
    all.fold(0.0, |largest, value| largest.max(value.abs()))
}

/// The smallest change, over a metre or over a velocity: about the last bit of a number in double precision.
const SMALLEST: f64 = 1.0 / (1u64 << 52) as f64;
/// Each change is so many times the one before.
const RATIO: f64 = 4.0;
/// Coarser is not double precision.
const FINE: f64 = SMALLEST * RATIO * RATIO * RATIO;
/// So many changes; the largest is 4·10⁻⁶.
const CHANGES: i32 = 18;
/// Two numbers of single precision that follow each other, over their size at most.
const SINGLE: f64 = 1.0 / (1u32 << 23) as f64;
/// A change is noticed if so many of the grains answer that answer to the largest one.
const ANSWERING: f64 = 0.95;

/// The smallest changes that the engine notices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// Of a position, by the position one step later, over the largest coordinate.
    pub position: f64,
    /// Of a velocity, by the velocity one step later, relative.
    pub velocity: f64,
    /// Of a position, by the velocities of grains in contact one step later, so by the forces, m.
    pub overlap: f64,
}

/// That of double precision.
impl Default for Resolution {
    fn default() -> Self {
        Resolution::DOUBLE
    }
}

impl Resolution {
    /// Of numbers in double precision.
    pub const DOUBLE: Resolution = Resolution::of_all(SMALLEST);

    /// The coarsest that counts as double precision.
    pub const COARSE_DOUBLE: Resolution = Resolution::of_all(FINE);

    /// Of numbers in single precision.
    pub const SINGLE: Resolution = Resolution::of_all(SINGLE);

    const fn of_all(smallest: f64) -> Self {
        Resolution {
            position: smallest,
            velocity: smallest,
            overlap: smallest,
        }
    }

    /// The same as noise for replicas: numbers are off by half of what makes a difference.
    pub fn noise(&self) -> Noise {
        Noise {
            position: 0.5 * self.position,
            velocity: 0.5 * self.velocity,
            overlap: 0.5 * self.overlap,
            replica: 0,
            every: 1,
        }
    }

    /// Whether it takes no notice of changes that single precision notices in a bed as large as this, m: nothing can be told of it.
    pub fn is_too_coarse(&self, extent: f64) -> bool {
        let smallest = |change: f64| {
            let power = (change / SMALLEST).ln() / RATIO.ln();
            SMALLEST * RATIO.powi((power - 1.0e-9).ceil() as i32)
        };
        let (length, share) = (smallest(SINGLE * extent), smallest(SINGLE));
        self.overlap > length || self.velocity > share || self.position > RATIO * SINGLE
    }

    /// Whether all numbers are those of double precision, as far as it can be told.
    pub fn is_double(&self) -> bool {
        let coarsest = self.position.max(self.velocity).max(self.overlap);
        coarsest <= FINE
    }

    /// Whether what is written is, though forces may be coarser.
    pub fn moves_in_double(&self) -> bool {
        self.position.max(self.velocity) <= FINE
    }

    /// How much of a length is rounding in a bed as large as this, m.
    pub fn length(&self, extent: f64) -> f64 {
        match self.is_double() {
            true => 4.0 * FINE * extent,
            false => 4.0 * SINGLE * extent,
        }
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
            let mut copy = case.at(vec![1]);
            let bodies = &mut copy.bodies;
            for (id, situation) in situations.iter().enumerate() {
                // Each by another length, so that neighbours do not move together.
                let length = change * (1.0 + (id as f64 * 0.618).fract());
                bodies.x[id] += length;
                bodies.z[id] -= length;
                if let Some(y) = bodies.y.get_mut(id) {
                    *y += 0.5 * length;
                }
                if *situation == FLYING {
                    let velocities = [&mut bodies.vx, &mut bodies.vy, &mut bodies.vz];
                    for velocity in velocities.into_iter().flat_map(|column| column.get_mut(id)) {
                        *velocity *= 1.0 + change;
                    }
                }
            }
            copy
        };
        let mut all = vec![changed(0.0)];
        all.extend((0..CHANGES).map(|power| changed(SMALLEST * RATIO.powi(power))));
        all
    }

    /// From the answers to [`Resolution::cases`]; none if the engine refused one of them.
    pub fn measured(case: &Case, answers: &[Answer]) -> Option<Resolution> {
        let last = answers.iter().map(|answer| answer.as_deref().ok()?.last());
        let last = last.map(|last| last.map(|snapshot| &snapshot.bodies));
        let last: Option<Vec<&Bodies>> = last.collect();
        let (base, changed) = last.as_deref()?.split_first()?;
        let situations = at_start(case);
        // The smallest change that enough of these grains notice.
        let noticed = |answers: &dyn Fn(&Bodies, usize) -> bool, among: &dyn Fn(usize) -> bool| {
            let at_all = |id: &usize| {
                among(*id) && changed.last().is_some_and(|bodies| answers(bodies, *id))
            };
            let ids: Vec<usize> = (0..situations.len()).filter(at_all).collect();
            let mut level = SMALLEST;
            for bodies in changed {
                let share = ids.iter().filter(|id| answers(bodies, **id)).count() as f64;
                if share >= ANSWERING * ids.len() as f64 {
                    break;
                }
                level *= RATIO;
            }
            level
        };
        let moved =
            |bodies: &Bodies, id: usize| bodies.x[id] != base.x[id] && bodies.z[id] != base.z[id];
        let sped = |bodies: &Bodies, id: usize| {
            bodies.vx[id] != base.vx[id] || bodies.vz[id] != base.vz[id]
        };
        Some(Resolution {
            // The last bit of a number is a share of it.
            position: match noticed(&moved, &|_| true) {
                change if change > SMALLEST => change / extent(&case.bodies, case.punch),
                change => change,
            },
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
        let model = grains::model::Model::of(&grains::scene::paper_scene(1, 2));
        let case = Case::new("", model, cloud, vec![0]);
        let start = grains::variant::run(&case, &Default::default());
        assert_eq!(largest(&start), (3.0, 5.0));
    }
}
