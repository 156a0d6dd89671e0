//! The largest stable step that the contacts predict: K, C and M of the linearised problem M ü + C u̇ + K u = 0, never
//! assembled into a matrix, and their largest eigenvalue by Lanczos iteration.
//!
//! The degrees of freedom of grain i are 3i (x), 3i+1 (z) and 3i+2 (angle about y); grains that do not
//! rotate keep the third one without any spring. Of a contact with normal n, t = (−n_z, n_x) and overlap u_n:
//!
//! - its normal spring gives k_n n⊗n, its dashpot c_n n⊗n;
//! - its pre-stress gives −(F_n/d) t⊗t, with d between the two points that turn about each other: the
//!   centres, or the grain's centre and the punch's corner. It is smaller than k_n by u_n/d;
//! - a sticking tangential spring gives s k_s g⊗g, g the slip of both sides: t and the arms of the torques.
//!   s = (R_1 + R_2)/(R_1 + R_2 − u_n) where slip is corrected for ratcheting, else 1.
//!
//! Left out: that shear forces turn with the normal (smaller by S/(k_n d)), and that the ratcheting
//! correction makes K unsymmetric where radii differ (smaller by u_n/R).
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
use grains::model::Law;
use grains::native::{CaseOptions, effective, watch_case};
use grains::scene::{SlipVelocity, TorqueArms};
use grains::tables::{BodyIds, Contact, Snapshot};
use grains::task::{Case, Effective, EffectiveContact};

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
    normal: [f64; 2],
    /// N/m; N·s/m.
    k_n: f64,
    c_n: f64,
    /// s·k_s, N/m.
    k_s: f64,
    /// F_n/d, N/m.
    pre_stress: f64,
    /// Lever arms of the tangential force on both sides, m.
    arms: [f64; 2],
}

/// The linearised scene at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    links: Vec<Link>,
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

/// The parameters that the native engine says it uses for a case, and the case as it starts.
pub(super) fn at_start(case: &Case) -> Result<(Effective, Option<Snapshot>)> {
    debug_assert_eq!(case.moments.first(), Some(&0));
    // One after the other, so that a large bed is not held twice.
    let parameters = effective(case, None)?;
    let mut start = None;
    watch_case(case, &CaseOptions::default(), &mut |snapshot| {
        start = Some(snapshot);
        false
    })?;
    Ok((parameters, start))
}

impl Network {
    /// The network of a case at its start, with the parameters that the native engine says it uses.
    pub fn of(case: &Case) -> Result<Self> {
        let (parameters, start) = at_start(case)?;
        let law = &case.model.law;
        let mut weights = vec![0.0; 3 * case.bodies.len()];
        for (id, mass) in case.bodies.mass.iter().enumerate() {
            weights[3 * id] = 1.0 / mass.sqrt();
            weights[3 * id + 1] = weights[3 * id];
            if law.rotates()
                && let Some(inertia) = case.bodies.inertia.get(id)
            {
                weights[3 * id + 2] = 1.0 / inertia.sqrt();
            }
        }
        let links = start.iter().flat_map(|start| {
            let contacts = start.contacts.iter().zip(&parameters.contacts);
            contacts.map(|(contact, effective)| Link::of(law, contact, effective, start))
        });
        Ok(Network {
            links: links.collect(),
            weights,
        })
    }

    /// Number of degrees of freedom, three a grain.
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
            let [nx, nz] = link.normal;
            let [one, two] = link.grains.map(|grain| {
                grain.map_or([0.0; 3], |grain| {
                    [0, 1, 2].map(|axis| x[3 * grain + axis] * self.weights[3 * grain + axis])
                })
            });
            let apart = [two[0] - one[0], two[1] - one[1]];
            let along = apart[0] * nx + apart[1] * nz;
            let across = -apart[0] * nz + apart[1] * nx;
            // A spin turns the surface of grain 1 at its arm along n by −t, of grain 2 at −n by +t.
            let slip = across + link.arms[0] * one[2] + link.arms[1] * two[2];
            let normal = (stiffness * link.k_n + damping * link.c_n) * along;
            let sticking = stiffness * link.k_s * slip;
            let across = sticking - stiffness * link.pre_stress * across;
            let force = [normal * nx - across * nz, normal * nz + across * nx];
            for ((grain, arm), sign) in link.grains.iter().zip(link.arms).zip([-1.0, 1.0]) {
                let Some(at) = grain.map(|grain| 3 * grain) else {
                    continue;
                };
                y[at] += sign * force[0] * self.weights[at];
                y[at + 1] += sign * force[1] * self.weights[at + 1];
                y[at + 2] += arm * sticking * self.weights[at + 2];
            }
        }
        y
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
        if omega == 0.0 || self.links.iter().all(|link| link.c_n <= 0.0) {
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

impl Link {
    fn of(law: &Law, contact: &Contact, effective: &EffectiveContact, moment: &Snapshot) -> Self {
        let bodies = &moment.bodies;
        let ids = BodyIds {
            grains: bodies.len() as u32,
            walls: 0,
        };
        let two = contact.id2 as usize;
        let one = ids.is_grain(contact.id1).then_some(contact.id1 as usize);
        let centre = |grain: usize| [bodies.x[grain], bodies.z[grain]];
        let radius2 = bodies.radius[two];
        let radius1 = one.map_or(radius2, |one| bodies.radius[one]);
        let touching = radius1 + radius2;
        // Flat sides have normals along an axis.
        let is_corner = one.is_none() && contact.normal.iter().all(|n| *n != 0.0);
        let corner = is_corner.then_some(radius2 - contact.overlap);
        // What turns about what; flat sides do not turn.
        let distance = one.map_or(corner, |_| Some(touching - contact.overlap));
        let corrected = law.contact.slip_velocity == SlipVelocity::RatchetingCorrected;
        let stretch = if corrected && corner.is_none() {
            touching / (touching - contact.overlap)
        } else {
            1.0
        };
        let arm = |radius: f64, centre: [f64; 2]| match law.contact.torque_arms {
            _ if !law.rotates() => 0.0,
            TorqueArms::HalfOverlap => radius - 0.5 * contact.overlap,
            TorqueArms::ContactPoint => {
                (contact.point[0] - centre[0]).hypot(contact.point[1] - centre[1])
            }
        };
        let of_one = one.map_or(0.0, |one| arm(radius1, centre(one)));
        Link {
            grains: [one, Some(two)],
            normal: contact.normal,
            k_n: effective.k_n,
            c_n: effective.c_n,
            k_s: stretch * effective.k_s.unwrap_or(0.0),
            // The spring's own share: a dashpot at work is no pre-stress.
            pre_stress: distance.map_or(0.0, |distance| effective.k_n * contact.overlap / distance),
            arms: [of_one, arm(radius2, centre(two))],
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
