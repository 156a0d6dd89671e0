//! The largest stable step as an engine shows it: a bed in equilibrium is disturbed by a millionth of its overlaps, and the
//! step at which the disturbance begins to grow is bracketed by trials.
//!
//! What grows first turns its sign with every step, so the energy of that part is looked at,
//! Σ ½m |(v_{n+1} − 2v_n + v_{n−1})/4|² (and of the spins): slow motions of the bed, and free fall, are not in it.

use chacha20::ChaCha8Rng;
use nalgebra::DVector;
use rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use super::Result;
use super::spectrum::freedoms;
use grains::generate::symmetric;
use grains::native::{CaseOptions, Trouble, linear, watch_case};
use grains::tables::{Bodies, Snapshot};
use grains::task::Case;
use verdict::Answer;

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
/// The native engine's limit is known to this share.
const RESOLUTION: f64 = 1.0e-3;
/// With damping there are stable steps above the first unstable one, so it is looked for at steps that
/// are this factor apart.
const SCAN: f64 = 1.008;
/// Doublings from the first trial to an unstable step.
const MOST_DOUBLINGS: u32 = 40;
/// In an external engine: half-width of the first range about where the limit is looked for, relative; without damping, and
/// with it, where the first unstable steps are a narrow range.
const FIRST: f64 = 0.06;
const FIRST_DAMPED: f64 = 0.012;
/// Trials of a limit in one start of an external engine.
const TRIALS: usize = 5;
/// Starts at most: two that narrow the bracket, and some to find the limit where it is not expected.
const MOST_STARTS: usize = 5;
/// An external engine's limit is known to this share.
const EXTERNAL_RESOLUTION: f64 = 6.0e-3;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// The largest step tried at which nothing grew, below which nothing grew either, s.
    pub stable: f64,
    /// The smallest step tried at which the disturbance grew, s.
    pub unstable: f64,
    pub trials: u32,
}

impl Found {
    /// Middle of the bracket, s.
    pub fn limit(&self) -> f64 {
        (self.stable * self.unstable).sqrt()
    }
}

/// A case in equilibrium and how it is disturbed, with what it takes to judge a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbed {
    /// At rest.
    case: Case,
    /// Displacements of the start, m, and those of a step before it, angles in rad; a grain's as [`freedoms`] has them.
    places: [Vec<f64>; 2],
    contacts: usize,
}

impl Disturbed {
    /// Every grain displaced and set moving at random along these axes, by no more than 10⁻⁶ of a small
    /// overlap, and turned by as much.
    pub fn at_random(case: &Case, axes: [bool; 3]) -> Result<Self> {
        let mut random = ChaCha8Rng::seed_from_u64(case.bodies.len() as u64);
        let places = [(); 2].map(|()| {
            let mut all = Vec::new();
            for radius in &case.bodies.radius {
                all.extend(freedoms(&case.bodies).iter().map(|freedom| {
                    let share = symmetric(&mut random);
                    match axes.get(*freedom) {
                        Some(true) => share,
                        Some(false) => 0.0,
                        None => share / radius,
                    }
                }));
            }
            all
        });
        Disturbed::along(case, places)
    }

    /// Disturbed by what turns its sign with every step: this unit vector in coordinates weighted by √mass, as
    /// [`super::spectrum::Network::fastest_mode`] has it.
    pub fn in_mode(case: &Case, vector: &DVector<f64>) -> Result<Self> {
        let bodies = &case.bodies;
        let freedoms = freedoms(bodies);
        let is_place = |at: usize| freedoms[at % freedoms.len()] < 3;
        let weighted = vector.iter().enumerate();
        let mode: Vec<f64> = weighted
            .map(|(at, share)| {
                let inert = if is_place(at) {
                    &bodies.mass
                } else {
                    &bodies.inertia
                };
                let inert = inert.get(at / freedoms.len());
                inert.map_or(0.0, |inert| share / inert.sqrt())
            })
            .collect();
        let moves = mode.iter().enumerate().filter(|(at, _)| is_place(*at));
        let largest = moves.fold(0.0, |largest: f64, (_, share)| largest.max(share.abs()));
        let now: Vec<f64> = mode.iter().map(|share| share / largest).collect();
        let before = now.iter().map(|share| -share).collect();
        Disturbed::along(case, [now, before])
    }

    fn along(case: &Case, places: [Vec<f64>; 2]) -> Result<Self> {
        let contacts = linear(case)?;
        let mut overlaps: Vec<f64> = contacts.iter().map(|contact| contact.overlap).collect();
        overlaps.sort_by(f64::total_cmp);
        let small = (SMALL_OVERLAP * overlaps.len() as f64) as usize;
        let size = DISTURBANCE * overlaps.get(small).copied().unwrap_or(0.0);
        let steps = if case.model.law.has_dashpots() {
            STEPS_WITH_DASHPOTS
        } else {
            STEPS
        };
        // Three steps running each.
        let moments = [2, 8, 20, 60, 150, steps - 1]
            .iter()
            .flat_map(|middle| [middle - 1, *middle, middle + 1])
            .collect();
        Ok(Disturbed {
            case: Case {
                moments,
                ..case.clone()
            },
            places: places.map(|shares| shares.into_iter().map(|share| size * share).collect()),
            contacts: overlaps.len(),
        })
    }

    pub fn at(&self, dt: f64, alpha: f64) -> Case {
        let mut case = self.case.clone();
        case.model.dt = dt;
        case.model.alpha = alpha;
        let [now, before] = &self.places;
        let freedoms = freedoms(&case.bodies);
        let bodies = &mut case.bodies;
        for (at, (now, before)) in now.iter().zip(before).enumerate() {
            let (id, freedom) = (at / freedoms.len(), freedoms[at % freedoms.len()]);
            let places = [&mut bodies.x, &mut bodies.y, &mut bodies.z];
            if let Some(places) = places.into_iter().nth(freedom) {
                places[id] += now;
            }
            let velocities = [&mut bodies.vx, &mut bodies.vy, &mut bodies.vz];
            let spins = [&mut bodies.spin_x, &mut bodies.spin, &mut bodies.spin_z];
            let speeds = velocities.into_iter().chain(spins).nth(freedom);
            if let Some(speed) = speeds.and_then(|speeds| speeds.get_mut(id)) {
                *speed = (now - before) / dt;
            }
        }
        case
    }

    /// Whether the disturbance has grown, from the first moments of a trial on.
    pub fn has_grown(&self, track: &[Snapshot]) -> bool {
        let enough = CONTACTS_LEFT * self.contacts as f64;
        let energies: Vec<f64> = track.chunks_exact(3).map(turning_energy).collect();
        let Some(first) = energies.first() else {
            return false;
        };
        let large = |energy: &f64| !energy.is_finite() || *energy > GROWN * first;
        let open = |moment: &Snapshot| (moment.contacts.len() as f64) < enough;
        track.iter().any(open) || energies.iter().any(large)
    }

    /// Whether the disturbance grows at this step in the native engine. That the engine itself gives up
    /// is growth, too.
    fn grows(&self, dt: f64, alpha: f64) -> Result<bool> {
        let mut track: Vec<Snapshot> = Vec::new();
        let mut grown = false;
        let mut watch = |moment| {
            track.push(moment);
            grown = track.len().is_multiple_of(3) && self.has_grown(&track);
            !grown
        };
        match watch_case(&self.at(dt, alpha), &CaseOptions::default(), &mut watch) {
            Ok(()) => Ok(grown),
            Err(error) if error.trouble == Trouble::Interrupted => Err(error),
            Err(_) => Ok(true),
        }
    }

    /// The largest stable step in the native engine without damping, from nothing but trials: doubled
    /// until it grows, then bisected. Begins at a hundredth of the smallest √(m/ER), which no dashpot of a physical size
    /// brings near the limit.
    pub fn undamped(&self) -> Result<Option<Found>> {
        let bodies = &self.case.bodies;
        let modulus = self.case.model.law.modulus;
        let both = bodies.mass.iter().zip(&bodies.radius);
        let scales = both.map(|(mass, radius)| (mass / (modulus * radius)).sqrt());
        let smallest = scales.fold(f64::INFINITY, f64::min);
        self.first_unstable(0.01 * smallest, 2.0, MOST_DOUBLINGS, 0.0)
    }

    /// The smallest unstable step with damping, looked for from well below the undamped limit up.
    pub fn damped(&self, alpha: f64, undamped: &Found) -> Result<Option<Found>> {
        let (first, last) = (0.7 * undamped.limit(), 1.2 * undamped.limit());
        if self.grows(first, alpha)? {
            return Ok(None);
        }
        let trials = ((last / first).ln() / SCAN.ln()).ceil() as u32;
        let found = self.first_unstable(first, SCAN, trials, alpha)?;
        Ok(found.map(|found| Found {
            trials: found.trials + 1,
            ..found
        }))
    }

    /// Goes up by `factor` from a stable step until it grows, then bisects.
    fn first_unstable(
        &self,
        mut stable: f64,
        factor: f64,
        most: u32,
        alpha: f64,
    ) -> Result<Option<Found>> {
        for trial in 1..=most {
            let mut found = Found {
                stable,
                unstable: factor * stable,
                trials: trial,
            };
            if self.grows(found.unstable, alpha)? {
                while found.unstable / found.stable > 1.0 + RESOLUTION {
                    let middle = found.limit();
                    found.trials += 1;
                    if self.grows(middle, alpha)? {
                        found.unstable = middle;
                    } else {
                        found.stable = middle;
                    }
                }
                return Ok(Some(found));
            }
            stable = found.unstable;
        }
        Ok(None)
    }
}

/// Energy of what turns its sign with every step, from three moments a step apart, J.
fn turning_energy(three: &[Snapshot]) -> f64 {
    let [before, now, after] = three else {
        return 0.0;
    };
    let part = |column: fn(&Bodies) -> &Vec<f64>, inert: &[f64]| -> f64 {
        let [a, b, c] = [before, now, after].map(|snapshot| column(&snapshot.bodies));
        let turning = a.iter().zip(b).zip(c).zip(inert);
        turning
            .map(|(((a, b), c), inert)| {
                let turning = 0.25 * (c - 2.0 * b + a);
                0.5 * inert * turning * turning
            })
            .sum()
    };
    let (mass, inertia) = (&now.bodies.mass, &now.bodies.inertia);
    // What is across the plane is empty in it, and adds nothing.
    part(|bodies| &bodies.vx, mass)
        + part(|bodies| &bodies.vz, mass)
        + part(|bodies| &bodies.spin, inertia)
        + part(|bodies| &bodies.vy, mass)
        + part(|bodies| &bodies.spin_x, inertia)
        + part(|bodies| &bodies.spin_z, inertia)
}

/// A limit that is to be found in an external engine.
#[derive(Debug, Clone)]
pub struct Search {
    disturbed: Disturbed,
    alpha: f64,
    /// The range of the next trials while one side of the limit has not been seen, s.
    range: [f64; 2],
    stable: Option<f64>,
    unstable: Option<f64>,
    trials: u32,
    refused: Option<String>,
}

impl Search {
    /// Looks about this step first.
    pub fn new(disturbed: Disturbed, alpha: f64, about: f64) -> Self {
        let width = 1.0 + if alpha > 0.0 { FIRST_DAMPED } else { FIRST };
        Search {
            disturbed,
            alpha,
            range: [about / width, about * width],
            stable: None,
            unstable: None,
            trials: 0,
            refused: None,
        }
    }

    /// The first trial, which has every part of the model that the other trials have.
    pub fn at_start(&self) -> Case {
        self.disturbed.at(self.range[0], self.alpha)
    }

    fn bracket(&self) -> Option<Found> {
        Some(Found {
            stable: self.stable?,
            unstable: self.unstable?,
            trials: self.trials,
        })
    }

    fn found(&self) -> Option<Found> {
        let near = |found: &Found| found.unstable / found.stable <= 1.0 + EXTERNAL_RESOLUTION;
        self.bracket().filter(near)
    }

    fn is_open(&self) -> bool {
        self.refused.is_none() && self.found().is_none()
    }

    /// The steps of the next trials: evenly between what is known, or over the range with its ends.
    fn steps(&self) -> Vec<f64> {
        let (low, high, parts, from) = match self.bracket() {
            Some(found) => (found.stable, found.unstable, TRIALS + 1, 1),
            None => (self.range[0], self.range[1], TRIALS - 1, 0),
        };
        let ratio = (high / low).ln() / parts as f64;
        (from..from + TRIALS)
            .map(|at| low * (ratio * at as f64).exp())
            .collect()
    }

    /// Takes over what trials at these steps have shown: up to the first at which it grew.
    fn learn(&mut self, steps: &[f64], tracks: Vec<Answer>) {
        let tracks = match tracks.into_iter().collect::<Result<Vec<_>, String>>() {
            Ok(tracks) => tracks,
            Err(reason) => return self.refused = Some(reason),
        };
        let grown: Vec<bool> = tracks
            .iter()
            .map(|track| self.disturbed.has_grown(track))
            .collect();
        self.trials += steps.len() as u32;
        let first = grown.iter().position(|grown| *grown);
        let last_stable = first.unwrap_or(steps.len()).checked_sub(1);
        self.stable = last_stable.map(|at| steps[at]).or(self.stable);
        self.unstable = first.map(|at| steps[at]).or(self.unstable);
        // Not in the range: the next trials look beside it.
        let [low, high] = self.range;
        if self.stable.is_none() {
            self.range = [low / (high / low), low];
        } else if self.unstable.is_none() {
            self.range = [high, high * (high / low)];
        }
    }
}

/// All limits, in the order of the searches, none where it was not found; or why the engine would not look for one. `run` runs cases in one start of the engine and gives what it made of each,
/// in order.
pub fn find_all<E>(
    mut searches: Vec<Search>,
    mut run: impl FnMut(&[&Case]) -> Result<Vec<Answer>, E>,
) -> Result<Vec<Result<Option<Found>, String>>, E> {
    for _ in 0..MOST_STARTS {
        let open = searches.iter_mut().filter(|search| search.is_open());
        let mut open: Vec<&mut Search> = open.collect();
        if open.is_empty() {
            break;
        }
        let steps: Vec<Vec<f64>> = open.iter().map(|search| search.steps()).collect();
        let trials = open.iter().zip(&steps).flat_map(|(search, steps)| {
            let trial = |dt: &f64| search.disturbed.at(*dt, search.alpha);
            steps.iter().map(trial)
        });
        let cases: Vec<Case> = trials.collect();
        let mut tracks = run(&cases.iter().collect::<Vec<_>>())?.into_iter();
        for (search, steps) in open.iter_mut().zip(&steps) {
            search.learn(steps, tracks.by_ref().take(steps.len()).collect());
        }
    }
    let result = |search: Search| search.refused.clone().map_or(Ok(search.found()), Err);
    Ok(searches.into_iter().map(result).collect())
}
