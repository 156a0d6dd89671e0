//! The largest stable step that the contacts predict: K, C and M of the linearised problem M ü + C u̇ + K u = 0, never
//! assembled into a matrix, and their largest eigenvalue by Lanczos iteration.
//!
//! The degrees of freedom of a grain are x, z and the angle about y in the plane, and in space three places and three angles;
//! grains that do not rotate keep their angles without any spring. Of a contact with normal n and overlap u_n, springs taken about where it
//! stands:
//!
//! - its normal spring gives k_n n⊗n, its dashpot c_n n⊗n; Hertz's spring has the slope k_n = dF/du;
//! - its pre-stress gives −(F_n/d) across n, with d between the two points that turn about each other: the
//!   centres, or the grain's centre and the punch's corner. It is smaller than k_n by u_n/d;
//! - a sticking tangential spring gives s k_s along both tangents t, of the slip of both sides: t and the arms of the torques;
//!   its dashpot the same with c_s. s = (R_1 + R_2)/(R_1 + R_2 − u_n) where slip is corrected for ratcheting, else 1;
//! - resistance to rolling and twisting gives its constants, of the angles of one grain against the other.
//!
//! Left out: that shear forces turn with the normal (smaller by S/(k_n d)), and what makes K unsymmetric where the arms of slip and torque
//! differ (smaller by the square of u_n/R).
//!
//! The engines step x_{n+1} − 2x_n + x_{n−1} + dt M⁻¹C (x_n − x_{n−1}) + dt² M⁻¹K x_n = 0: leapfrog,
//! with velocities half a step behind in the dashpots. A solution that turns its sign with every step,
//! x_n = (−1)ⁿ u, has (dt² K + 2dt C) u = 4 M u. K and C are symmetric and not negative, so below the
//! smallest such dt every mode is bounded (Jury's conditions on λ² − (2 − c − k) λ + 1 − c with k + 2c < 4),
//! and above it this one grows: the limit is where the largest eigenvalue of
//! M^(−1/2)(dt² K + 2dt C)M^(−1/2) is 4. Without dashpots that is dt = 2/ω_max; for one oscillator it is
//! dt = (2/ω)(√(1+ζ²) − ζ).
//!
//! Cundall damping scales each component of the acceleration by 1 + α where it brakes and 1 − α where it
//! drives. Where the velocity turns its sign with every step the braking factor rules, for each
//! component, so the same mode u grows from (dt² K + 2dt C) u = 4/(1+α) M u on. That is a necessary condition;
//! that no other motion grows at a smaller step is measured, not proved.

use chacha20::ChaCha8Rng;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand_core::SeedableRng;

use super::Result;
use grains::generate::symmetric;
use grains::native::linear;
use grains::reference::Linear;
use grains::tables::{Bodies, Body};
use grains::task::Case;
use grains::vector::{Vector, cross, dot as along, minus, plus, times};

/// Relative error of the largest eigenvalue at which iteration ends.
const TOLERANCE: f64 = 1.0e-6;
/// The same where the vector is what is wanted: it is a square root less exact than the value.
const OF_VECTOR: f64 = 1.0e-10;
/// The most Lanczos vectors; a bed of 5,000 grains takes about a hundred.
const MOST_VECTORS: usize = 600;
/// The small matrix is looked at every so many vectors.
const LOOK_EVERY: usize = 10;
/// Refinements of the step with dashpots; each squares the error.
const MOST_REFINEMENTS: usize = 60;

/// One contact as a spring between degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Link {
    /// Both grains; none for a wall or the punch.
    grains: [Option<usize>; 2],
    contact: Linear,
    /// s·k_s and s·c_s where it sticks, N/m and N·s/m.
    sticking: [f64; 2],
    /// F_n/d, N/m.
    pre_stress: f64,
}

/// The linearised scene at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    links: Vec<Link>,
    /// Of each grain, as [`freedoms`] has them.
    freedoms: &'static [usize],
    /// 1/√mass or 1/√inertia of each degree of freedom; zero for one that does not move.
    weights: Vec<f64>,
}

/// The largest eigenvalue.
#[derive(Debug, Clone, PartialEq)]
pub struct Top {
    /// In s⁻² for the stiffness.
    pub value: f64,
    /// Of each Lanczos vector in its own vector.
    shares: Vec<f64>,
    /// Bound of the error of `value` by the residual, the same unit.
    pub residual: f64,
    pub vectors: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// s; infinite where nothing touches.
    pub dt: f64,
    /// ω_max of the springs alone, rad/s.
    pub omega: f64,
    /// Lanczos vectors that it took, all refinements together.
    pub vectors: usize,
    /// Relative bound of the error of the last eigenvalue.
    pub residual: f64,
}

/// What moves of these grains: x, y, z are 0, 1, 2, and the angles about them 3, 4, 5.
pub(super) fn freedoms(bodies: &Bodies) -> &'static [usize] {
    match bodies.in_space() {
        true => &[0, 1, 2, 3, 4, 5],
        false => &[0, 2, 4],
    }
}

impl Network {
    /// The network of a case at its start.
    pub fn of(case: &Case) -> Result<Self> {
        let (law, bodies) = (&case.model.law, &case.bodies);
        let freedoms = freedoms(bodies);
        let weight = |id: usize, freedom: usize| {
            let inert = match freedom < 3 {
                true => bodies.mass.get(id),
                false => bodies.inertia.get(id).filter(|_| law.rotates()),
            };
            inert.map_or(0.0, |inert| 1.0 / inert.sqrt())
        };
        let grains = 0..bodies.len();
        let weights = grains.flat_map(|id| freedoms.iter().map(move |axis| weight(id, *axis)));
        Ok(Network {
            links: linear(case)?.into_iter().map(Link::from).collect(),
            freedoms,
            weights: weights.collect(),
        })
    }

    /// Number of degrees of freedom of all grains.
    pub fn freedoms(&self) -> usize {
        self.weights.len()
    }

    pub fn contacts(&self) -> usize {
        self.links.len()
    }

    /// M^(−1/2) A M^(−1/2) x with A = `stiffness`·K + `damping`·C.
    pub fn apply(&self, stiffness: f64, damping: f64, x: &DVector<f64>) -> DVector<f64> {
        let mut y = DVector::zeros(x.len());
        for link in &self.links {
            let Linear { normal, arms, .. } = link.contact;
            let [one, two] = link.grains.map(|grain| self.motion(x, grain));
            let apart = minus(two[0], one[0]);
            let closing = along(apart, normal);
            let across = minus(apart, times(closing, normal));
            // A spin turns the surface of grain 1 at its arm along n, of grain 2 at −n.
            let turning = plus(times(arms[0], one[1]), times(arms[1], two[1]));
            let slip = minus(across, cross(turning, normal));
            let [k_s, c_s] = link.sticking;
            let normal_force =
                (stiffness * link.contact.k_n + damping * link.contact.c_n) * closing;
            let sticking = times(stiffness * k_s + damping * c_s, slip);
            let bent = times(-stiffness * link.pre_stress, across);
            let force = plus(times(normal_force, normal), plus(sticking, bent));
            let turn = cross(normal, sticking);
            let rolling = minus(two[1], one[1]);
            let twist = times(along(rolling, normal), normal);
            let moment = plus(
                times(stiffness * link.contact.bending, minus(rolling, twist)),
                times(stiffness * link.contact.twisting, twist),
            );
            for ((grain, arm), sign) in link.grains.iter().zip(arms).zip([-1.0, 1.0]) {
                let torque = minus(times(sign, moment), times(arm, turn));
                self.push(&mut y, *grain, [times(sign, force), torque]);
            }
        }
        y
    }

    /// How a grain moves along its own degrees of freedom, places and angles.
    fn motion(&self, x: &DVector<f64>, grain: Option<usize>) -> [Vector; 2] {
        let mut motion = [[0.0; 3]; 2];
        let Some(first) = grain.map(|grain| grain * self.freedoms.len()) else {
            return motion;
        };
        for (at, freedom) in (first..).zip(self.freedoms) {
            motion[freedom / 3][freedom % 3] = x[at] * self.weights[at];
        }
        motion
    }

    /// Adds force and torque to a grain's own.
    fn push(&self, y: &mut DVector<f64>, grain: Option<usize>, load: [Vector; 2]) {
        let Some(first) = grain.map(|grain| grain * self.freedoms.len()) else {
            return;
        };
        for (at, freedom) in (first..).zip(self.freedoms) {
            y[at] += load[freedom / 3][freedom % 3] * self.weights[at];
        }
    }

    /// The largest eigenvalue of M^(−1/2)(stiffness·K + damping·C)M^(−1/2). Lanczos from a fixed random vector,
    /// without reorthogonalisation: what rounding brings back are copies of eigenvalues, which do no harm
    /// to the largest one.
    pub fn top(&self, stiffness: f64, damping: f64) -> Top {
        self.lanczos(stiffness, damping, TOLERANCE)
    }

    /// The unit vector, in coordinates weighted by √mass, of the mode that first turns its sign with every step, with
    /// Cundall's α.
    pub fn fastest_mode(&self, alpha: f64) -> DVector<f64> {
        let dt = self.limit(alpha).dt;
        let top = self.lanczos(dt * dt, 2.0 * dt, OF_VECTOR);
        self.vector(dt * dt, 2.0 * dt, &top)
    }

    /// The largest stable step, with Cundall's α: the smallest dt at which the largest eigenvalue of
    /// M^(−1/2)(dt² K + 2dt C)M^(−1/2) is 4/(1+α).
    ///
    /// With dashpots the step is found from above: of any vector, dt² k + 2dt c = 4/(1+α) with
    /// k and c its shares of K and C has a solution that is no smaller than the limit.
    pub fn limit(&self, alpha: f64) -> Limit {
        let wanted = 4.0 / (1.0 + alpha);
        let springs = self.top(1.0, 0.0);
        let omega = springs.value.max(0.0).sqrt();
        let mut limit = Limit {
            dt: wanted.sqrt() / omega,
            omega,
            vectors: springs.vectors,
            residual: springs.residual / springs.value,
        };
        if omega == 0.0 || self.links.iter().all(|link| link.contact.c_n <= 0.0) {
            return limit;
        }
        for _ in 0..MOST_REFINEMENTS {
            let parts = [limit.dt * limit.dt, 2.0 * limit.dt];
            let found = self.top(parts[0], parts[1]);
            limit.vectors += found.vectors;
            limit.residual = found.residual / found.value;
            let vector = self.vector(parts[0], parts[1], &found);
            let [k, c] =
                [(1.0, 0.0), (0.0, 1.0)].map(|(k, c)| dot(&vector, &self.apply(k, c, &vector)));
            // The root of k dt² + 2c dt − wanted, in the form that does not cancel.
            let dt = wanted / (c + (c * c + k * wanted).sqrt());
            let change = (limit.dt - dt) / dt;
            limit.dt = dt;
            if change.abs() < TOLERANCE {
                break;
            }
        }
        limit
    }

    fn lanczos(&self, stiffness: f64, damping: f64, tolerance: f64) -> Top {
        let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
        let (mut value, mut shares, mut residual) = (0.0, Vec::new(), 0.0);
        self.each_vector(stiffness, damping, &mut |_, along, rest| {
            diagonal.push(along);
            let scale = diagonal.iter().copied().fold(0.0, f64::max);
            // Nothing is left: the vectors span all that the start has a share in.
            let whole = rest <= 1.0e-13 * scale || rest == 0.0;
            let ends = whole || diagonal.len() >= MOST_VECTORS;
            let mut is_found = false;
            if ends || diagonal.len().is_multiple_of(LOOK_EVERY) {
                (value, shares) = largest_of_tridiagonal(&diagonal, &off_diagonal);
                residual = rest * shares[diagonal.len() - 1].abs();
                is_found = ends || residual <= tolerance * value;
            }
            off_diagonal.push(rest);
            !is_found
        });
        Top {
            value,
            shares,
            residual,
            vectors: diagonal.len(),
        }
    }

    /// The unit vector of the largest eigenvalue, in coordinates weighted by √mass. The Lanczos vectors are made once more: all of
    /// them would be gigabytes for a million grains.
    fn vector(&self, stiffness: f64, damping: f64, top: &Top) -> DVector<f64> {
        let mut vector = DVector::zeros(self.freedoms());
        let mut shares = top.shares.iter();
        self.each_vector(stiffness, damping, &mut |basis, _, _| {
            let Some(share) = shares.next() else {
                return false;
            };
            vector.axpy(*share, basis, 1.0);
            shares.len() > 0
        });
        unit(vector)
    }

    /// Goes through the Lanczos vectors, each with its diagonal element and the length of what is left, as long as it is
    /// wanted.
    fn each_vector(
        &self,
        stiffness: f64,
        damping: f64,
        take: &mut dyn FnMut(&DVector<f64>, f64, f64) -> bool,
    ) {
        let mut vector = self.start();
        let mut before: Option<(DVector<f64>, f64)> = None;
        loop {
            let mut w = self.apply(stiffness, damping, &vector);
            let along = dot(&w, &vector);
            w.axpy(-along, &vector, 1.0);
            if let Some((before, rest)) = &before {
                w.axpy(-rest, before, 1.0);
            }
            let rest = dot(&w, &w).sqrt();
            if !take(&vector, along, rest) {
                return;
            }
            before = Some((vector, rest));
            vector = w / rest;
        }
    }

    /// A random unit vector on the degrees of freedom that move, always the same.
    fn start(&self) -> DVector<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(self.freedoms() as u64);
        let shares = self.weights.iter().map(|weight| {
            let share = symmetric(&mut random);
            if *weight > 0.0 { share } else { 0.0 }
        });
        unit(DVector::from_iterator(self.freedoms(), shares))
    }
}

impl From<Linear> for Link {
    fn from(contact: Linear) -> Self {
        let is_grain = contact.first == Body::Grain;
        let [radius1, radius2] = contact.radii;
        // Flat sides have normals along an axis, and do not turn.
        let edged = contact.normal.iter().filter(|n| **n != 0.0).count() > 1;
        let distance = match contact.first {
            Body::Grain => Some(radius1 + radius2 - contact.overlap),
            Body::Punch if edged => Some(radius2 - contact.overlap),
            _ => None,
        };
        let sticking = [contact.k_s, contact.c_s].map(|along| match contact.sticks {
            true => contact.stretch * along,
            false => 0.0,
        });
        Link {
            grains: [
                is_grain.then_some(contact.ids.0 as usize),
                Some(contact.ids.1 as usize),
            ],
            contact,
            sticking,
            // The spring's own share: a dashpot at work is no pre-stress.
            pre_stress: distance.map_or(0.0, |distance| contact.force / distance),
        }
    }
}

/// The largest eigenvalue of a symmetric tridiagonal matrix, and its vector.
fn largest_of_tridiagonal(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, Vec<f64>) {
    let size = diagonal.len();
    let matrix = DMatrix::from_fn(size, size, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => off_diagonal[i.min(j)],
        _ => 0.0,
    });
    let eigen = SymmetricEigen::new(matrix);
    let values = eigen.eigenvalues.iter().copied().enumerate();
    let (at, value) = values
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0));
    let vector = eigen.eigenvectors.column(at).iter().copied().collect();
    (value, vector)
}

fn unit(vector: DVector<f64>) -> DVector<f64> {
    let length = dot(&vector, &vector).sqrt();
    if length > 0.0 {
        vector / length
    } else {
        vector
    }
}

/// Summed in order, so that recorded limits keep their bits.
fn dot(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    a.iter().zip(b.iter()).map(|(a, b)| a * b).sum()
}
