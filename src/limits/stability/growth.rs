//! The largest stable step as the engine shows it: a bed in equilibrium is disturbed by a millionth of
//! its overlaps, and the step is halved in on where the disturbance begins to grow.
//!
//! What grows first turns its sign with every step, so the energy of that part is looked at,
//! Σ ½m |(v_{n+1} − 2v_n + v_{n−1})/4|² (and of the spins): slow motions of the bed, and free fall, are not in it.

use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use super::spectrum::symmetric;
use grains::case::Case;
use grains::native::{CaseOptions, NativeError, Trouble, run_case, watch_case};
use grains::tables::Snapshot;

/// Largest displacement of the disturbance over a small overlap of the scene.
const DISTURBANCE: f64 = 1.0e-6;
/// The overlap that counts: this share of the contacts have a smaller one.
const SMALL_OVERLAP: f64 = 0.1;
/// The energy of the disturbance has grown when it is so many times that at the start. At the limit itself it
/// grows with the square of the steps, to 10⁵; the contacts open at 10¹².
const GROWN: f64 = 1.0e8;
/// It has also grown when so large a share of the contacts is gone.
const CONTACTS_LEFT: f64 = 0.9;
/// Steps of a trial. Growth by e^√(8ε) a step, ε the step's excess, shows an excess of 2·10⁻⁴ by then.
const STEPS: u64 = 400;
/// With dashpots growth is by about e^(2ε) a step.
const STEPS_WITH_DASHPOTS: u64 = 2000;
/// The limit is known to this share.
const RESOLUTION: f64 = 1.0e-3;
/// With damping there are stable steps above the first unstable one, so it is looked for at steps that
/// are this factor apart.
const SCAN: f64 = 1.008;
/// Doublings from the first trial to an unstable step.
const MOST_DOUBLINGS: u32 = 40;

/// The largest stable step as found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Middle of the two, s.
    pub limit: f64,
    /// The largest step tried at which nothing grew, below which nothing grew either, s.
    pub stable: f64,
    /// The smallest step tried at which the disturbance grew, s.
    pub unstable: f64,
    /// Trials that it took.
    pub trials: u32,
}

impl Found {
    /// Between these steps.
    pub fn between(stable: f64, unstable: f64, trials: u32) -> Self {
        Found {
            limit: (stable * unstable).sqrt(),
            stable,
            unstable,
            trials,
        }
    }
}

/// A case in equilibrium and how it is disturbed, with what it takes to judge a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbed {
    /// At rest.
    case: Case,
    /// Displacements of the start, m, and those of a step before it; x, z and angle (rad) a grain.
    places: [Vec<f64>; 2],
    /// Contacts at the start.
    contacts: usize,
}

impl Disturbed {
    /// Every grain displaced and set moving at random along these axes, by no more than 10⁻⁶ of a small
    /// overlap, and turned by as much.
    pub fn at_random(case: &Case, axes: [bool; 2]) -> Result<Self, NativeError> {
        let mut random = ChaCha8Rng::seed_from_u64(case.bodies.len() as u64);
        let radius = &case.bodies.radius;
        let mut draw = || -> Vec<f64> {
            let of = |radius: &f64| {
                let share = |moves: bool, random: &mut ChaCha8Rng| {
                    let share = symmetric(random);
                    if moves { share } else { 0.0 }
                };
                let [x, z] = axes.map(|moves| share(moves, &mut random));
                [x, z, share(true, &mut random) / radius]
            };
            radius.iter().flat_map(of).collect()
        };
        let places = [draw(), draw()];
        Disturbed::along(case, places)
    }

    /// Disturbed by what turns its sign with every step: this unit vector in coordinates weighted by √mass, as
    /// [`super::spectrum::Top`] has it.
    pub fn in_mode(case: &Case, vector: &[f64]) -> Result<Self, NativeError> {
        let of = &case.bodies;
        let inert = |at: usize| match at % 3 {
            2 => of.inertia.get(at / 3).copied(),
            _ => of.mass.get(at / 3).copied(),
        };
        let weighted = vector.iter().enumerate();
        let mode: Vec<f64> = weighted
            .map(|(at, share)| inert(at).map_or(0.0, |inert| share / inert.sqrt()))
            .collect();
        let largest = mode
            .iter()
            .enumerate()
            .filter(|(at, _)| at % 3 != 2)
            .fold(0.0, |largest: f64, (_, share)| largest.max(share.abs()));
        let now: Vec<f64> = mode.iter().map(|share| share / largest).collect();
        let before = now.iter().map(|share| -share).collect();
        Disturbed::along(case, [now, before])
    }

    fn along(case: &Case, places: [Vec<f64>; 2]) -> Result<Self, NativeError> {
        let still = Case {
            moments: vec![0],
            ..case.clone()
        };
        let track = run_case(&still, None)?;
        let mut overlaps: Vec<f64> = track
            .iter()
            .flat_map(|moment| &moment.contacts)
            .map(|contact| contact.overlap)
            .collect();
        overlaps.sort_by(f64::total_cmp);
        let small = overlaps
            .get((SMALL_OVERLAP * overlaps.len() as f64) as usize)
            .copied()
            .unwrap_or(0.0);
        let size = DISTURBANCE * small;
        let places = places.map(|of| of.into_iter().map(|share| size * share).collect());
        Ok(Disturbed {
            case: Case {
                moments: moments(steps(case)),
                ..case.clone()
            },
            places,
            contacts: overlaps.len(),
        })
    }

    /// The trial at this step.
    pub fn at(&self, dt: f64, alpha: f64) -> Case {
        let mut case = self.case.clone();
        case.model.dt = dt;
        case.model.alpha = alpha;
        let [now, before] = &self.places;
        let of = &mut case.bodies;
        for id in 0..of.len() {
            let moved = [0, 1, 2].map(|axis| now[3 * id + axis]);
            let speed = [0, 1, 2].map(|axis| (moved[axis] - before[3 * id + axis]) / dt);
            of.x[id] += moved[0];
            of.z[id] += moved[1];
            of.vx[id] = speed[0];
            of.vz[id] = speed[1];
            if let Some(spin) = of.spin.get_mut(id) {
                *spin = speed[2];
            }
        }
        case
    }

    /// Whether the disturbance has grown, from the first moments of a trial on.
    pub fn has_grown(&self, track: &[Snapshot]) -> bool {
        let left = |moment: &Snapshot| {
            moment.contacts.len() as f64 >= CONTACTS_LEFT * self.contacts as f64
        };
        let energies: Vec<f64> = track.chunks_exact(3).map(turning_energy).collect();
        let Some(first) = energies.first() else {
            return false;
        };
        !track.iter().all(left)
            || energies
                .iter()
                .any(|energy| !energy.is_finite() || *energy > GROWN * first)
    }

    /// Whether the disturbance grows at this step in the native engine. That the engine itself gives up
    /// is growth, too.
    fn grows(&self, dt: f64, alpha: f64) -> Result<bool, NativeError> {
        let case = self.at(dt, alpha);
        let mut track: Vec<Snapshot> = Vec::new();
        let mut grown = false;
        let done = watch_case(&case, &CaseOptions::default(), &mut |moment| {
            track.push(moment);
            grown = track.len().is_multiple_of(3) && self.has_grown(&track);
            !grown
        });
        match done {
            Ok(()) => Ok(grown),
            Err(error) if error.trouble == Trouble::Interrupted => Err(error),
            Err(_) => Ok(true),
        }
    }

    /// The largest stable step in the native engine without damping, from nothing but trials: doubled
    /// until it grows, then halved in.
    pub fn undamped(&self) -> Result<Option<Found>, NativeError> {
        let mut stable = self.first_trial();
        let mut trials = 0;
        for _ in 0..MOST_DOUBLINGS {
            let unstable = 2.0 * stable;
            trials += 1;
            if self.grows(unstable, 0.0)? {
                return Ok(Some(self.halve(stable, unstable, 0.0, trials)?));
            }
            stable = unstable;
        }
        Ok(None)
    }

    /// The smallest unstable step with damping, looked for from well below the undamped limit up.
    pub fn damped(&self, alpha: f64, undamped: &Found) -> Result<Option<Found>, NativeError> {
        let mut stable = 0.7 * undamped.limit;
        let mut trials = 1;
        if self.grows(stable, alpha)? {
            return Ok(None);
        }
        while stable < 1.2 * undamped.limit {
            let unstable = SCAN * stable;
            trials += 1;
            if self.grows(unstable, alpha)? {
                return Ok(Some(self.halve(stable, unstable, alpha, trials)?));
            }
            stable = unstable;
        }
        Ok(None)
    }

    fn halve(
        &self,
        mut stable: f64,
        mut unstable: f64,
        alpha: f64,
        mut trials: u32,
    ) -> Result<Found, NativeError> {
        while unstable / stable > 1.0 + RESOLUTION {
            let middle = (stable * unstable).sqrt();
            trials += 1;
            if self.grows(middle, alpha)? {
                unstable = middle;
            } else {
                stable = middle;
            }
        }
        Ok(Found::between(stable, unstable, trials))
    }

    /// A hundredth of the smallest √(m/ER), which no dashpot of a physical size brings near the limit.
    fn first_trial(&self) -> f64 {
        let bodies = &self.case.bodies;
        let modulus = self.case.model.law.modulus;
        let times = bodies.mass.iter().zip(&bodies.radius);
        let smallest = times
            .map(|(mass, radius)| (mass / (modulus * radius)).sqrt())
            .fold(f64::INFINITY, f64::min);
        0.01 * smallest
    }
}

fn steps(case: &Case) -> u64 {
    if case.model.law.has_dashpots() {
        STEPS_WITH_DASHPOTS
    } else {
        STEPS
    }
}

/// The moments of a trial, three steps running each.
fn moments(steps: u64) -> Vec<u64> {
    [2, 8, 20, 60, 150, steps - 1]
        .into_iter()
        .flat_map(|middle| [middle - 1, middle, middle + 1])
        .collect()
}

/// Energy of what turns its sign with every step, from three moments a step apart, J.
fn turning_energy(three: &[Snapshot]) -> f64 {
    let [before, now, after] = three else {
        return 0.0;
    };
    let of = [&before.bodies, &now.bodies, &after.bodies];
    let part = |column: fn(&grains::tables::Bodies) -> &Vec<f64>, inert: &[f64]| -> f64 {
        let [a, b, c] = of.map(column);
        let turning = a.iter().zip(b).zip(c).zip(inert);
        turning
            .map(|(((a, b), c), inert)| {
                let turning = 0.25 * (c - 2.0 * b + a);
                0.5 * inert * turning * turning
            })
            .sum()
    };
    let mass = &now.bodies.mass;
    part(|of| &of.vx, mass) + part(|of| &of.vz, mass) + part(|of| &of.spin, &now.bodies.inertia)
}
