//! The contact network as springs, dashpots and masses: K, C and M of the linearised problem
//! M ü + C u̇ + K u = 0, never assembled into a matrix.
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

use grains::case::{Case, Effective};
use grains::model::Law;
use grains::native::{NativeError, effective, run_case};
use grains::scene::{SlipVelocity, TorqueArms};
use grains::tables::{Bodies, BodyIds, Contact, Snapshot};

/// What stands in the place of the other side where that is a wall or the punch.
const FIXED: usize = usize::MAX;

/// One contact as a spring between degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Link {
    /// First grain, or [`FIXED`].
    one: usize,
    /// Second grain.
    two: usize,
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

/// Which matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Matrix {
    /// K.
    Stiffness,
    /// C.
    Damping,
}

/// The linearised scene at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    links: Vec<Link>,
    /// 1/√mass or 1/√inertia of each degree of freedom; zero for one that does not move.
    weights: Vec<f64>,
    damped: bool,
}

impl Network {
    /// The network of a case at its start, with the parameters that the native engine says it uses.
    pub fn of(case: &Case) -> Result<Self, NativeError> {
        let still = Case {
            moments: vec![0],
            ..case.clone()
        };
        let parameters = effective(&still, None)?;
        let track = run_case(&still, None)?;
        Ok(match track.first() {
            Some(start) => Network::new(&case.model.law, start, &parameters),
            None => Network {
                links: Vec::new(),
                weights: Vec::new(),
                damped: false,
            },
        })
    }

    /// The network of a moment; `parameters` has its contacts in the same order.
    pub fn new(law: &Law, moment: &Snapshot, parameters: &Effective) -> Self {
        let bodies = &moment.bodies;
        let rotates = law.rotates();
        let mut weights = vec![0.0; 3 * bodies.len()];
        for (id, mass) in bodies.mass.iter().enumerate() {
            weights[3 * id] = 1.0 / mass.sqrt();
            weights[3 * id + 1] = weights[3 * id];
            if rotates && let Some(inertia) = bodies.inertia.get(id) {
                weights[3 * id + 2] = 1.0 / inertia.sqrt();
            }
        }
        let links: Vec<Link> = moment
            .contacts
            .iter()
            .zip(&parameters.contacts)
            .map(|(contact, of)| {
                let springs = Springs {
                    k_n: of.k_n,
                    k_s: of.k_s.unwrap_or(0.0),
                    c_n: of.c_n,
                };
                link(law, bodies, contact, springs, moment)
            })
            .collect();
        let damped = links.iter().any(|link| link.c_n > 0.0);
        Network {
            links,
            weights,
            damped,
        }
    }

    /// Number of degrees of freedom, three a grain.
    pub fn freedoms(&self) -> usize {
        self.weights.len()
    }

    /// Whether a degree of freedom can move.
    pub fn moves(&self, freedom: usize) -> bool {
        self.weights[freedom] > 0.0
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.links.len()
    }

    /// Whether any contact has a dashpot.
    pub fn has_dashpots(&self) -> bool {
        self.damped
    }

    /// y = M^(−1/2) A M^(−1/2) x with A = `stiffness`·K + `damping`·C.
    pub fn apply(&self, stiffness: f64, damping: f64, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for link in &self.links {
            let [nx, nz] = link.normal;
            let move_of = |grain: usize| -> [f64; 3] {
                if grain == FIXED {
                    return [0.0; 3];
                }
                let at = 3 * grain;
                [0, 1, 2].map(|axis| x[at + axis] * self.weights[at + axis])
            };
            let (one, two) = (move_of(link.one), move_of(link.two));
            let apart = [two[0] - one[0], two[1] - one[1]];
            let along = apart[0] * nx + apart[1] * nz;
            let across = -apart[0] * nz + apart[1] * nx;
            // A spin turns the surface of grain 1 at its arm along n by −t, of grain 2 at −n by +t.
            let slip = across + link.arms[0] * one[2] + link.arms[1] * two[2];
            let normal = (stiffness * link.k_n + damping * link.c_n) * along;
            let sticking = stiffness * link.k_s * slip;
            let across = sticking - stiffness * link.pre_stress * across;
            let force = [normal * nx - across * nz, normal * nz + across * nx];
            for (grain, sign, arm) in [
                (link.one, -1.0, link.arms[0]),
                (link.two, 1.0, link.arms[1]),
            ] {
                if grain != FIXED {
                    let at = 3 * grain;
                    y[at] += sign * force[0] * self.weights[at];
                    y[at + 1] += sign * force[1] * self.weights[at + 1];
                    y[at + 2] += arm * sticking * self.weights[at + 2];
                }
            }
        }
    }

    /// x·M^(−1/2) A M^(−1/2)·x of one of the matrices.
    pub fn form(&self, of: Matrix, x: &[f64]) -> f64 {
        let (stiffness, damping) = match of {
            Matrix::Stiffness => (1.0, 0.0),
            Matrix::Damping => (0.0, 1.0),
        };
        let mut y = vec![0.0; x.len()];
        self.apply(stiffness, damping, x, &mut y);
        x.iter().zip(&y).map(|(a, b)| a * b).sum()
    }
}

/// Constants of one contact.
#[derive(Debug, Clone, Copy)]
struct Springs {
    k_n: f64,
    k_s: f64,
    c_n: f64,
}

fn link(law: &Law, bodies: &Bodies, contact: &Contact, of: Springs, moment: &Snapshot) -> Link {
    let ids = BodyIds {
        grains: bodies.len() as u32,
        walls: 0,
    };
    let two = contact.id2 as usize;
    let radius2 = bodies.radius[two];
    let centre2 = [bodies.x[two], bodies.z[two]];
    let between_grains = ids.is_grain(contact.id1);
    let one = if between_grains {
        contact.id1 as usize
    } else {
        FIXED
    };
    let radius1 = if between_grains {
        bodies.radius[one]
    } else {
        radius2
    };
    let corner = moment.punch.and_then(|punch| {
        let is_punch = !between_grains && contact.normal[0] != 0.0 && contact.normal[1] != 0.0;
        let inside =
            |axis: usize| (centre2[axis] - punch.centre[axis]).abs() < punch.half_extents[axis];
        (is_punch && !inside(0) && !inside(1)).then_some(radius2 - contact.overlap)
    });
    // What turns about what; flat sides do not turn.
    let distance = if between_grains {
        Some(radius1 + radius2 - contact.overlap)
    } else {
        corner
    };
    let corrected = law.contact.slip_velocity == SlipVelocity::RatchetingCorrected;
    let stretch = if corrected && corner.is_none() {
        (radius1 + radius2) / (radius1 + radius2 - contact.overlap)
    } else {
        1.0
    };
    let arm = |radius: f64, centre: [f64; 2]| match law.contact.torque_arms {
        TorqueArms::HalfOverlap => radius - 0.5 * contact.overlap,
        TorqueArms::ContactPoint => {
            (contact.point[0] - centre[0]).hypot(contact.point[1] - centre[1])
        }
    };
    let arms = if between_grains {
        [
            arm(radius1, [bodies.x[one], bodies.z[one]]),
            arm(radius2, centre2),
        ]
    } else {
        [0.0, arm(radius2, centre2)]
    };
    Link {
        one,
        two,
        normal: contact.normal,
        k_n: of.k_n,
        c_n: of.c_n,
        k_s: stretch * of.k_s,
        // The spring's own share: a dashpot at work is no pre-stress.
        pre_stress: distance.map_or(0.0, |distance| of.k_n * contact.overlap / distance),
        arms: if law.rotates() { arms } else { [0.0; 2] },
    }
}
