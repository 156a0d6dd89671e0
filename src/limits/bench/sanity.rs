//! Whether an engine's bed is still the bed that was given to it: an engine that drops grains or contacts
//! is fast, and its time means nothing.

use serde::Serialize;

use grains::measure::equilibrium::kinetic_energy;
use grains::tables::{Bodies, Snapshot};

/// How far from the native exact bed another engine's may be after the same steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerance {
    /// Of the largest displacement over the mean radius.
    pub displacement: f64,
    /// Of the number of contacts between grains, relative.
    pub contacts: f64,
    /// Kinetic energy over the other, at most, either way.
    pub energy: f64,
}

impl Tolerance {
    /// The same operations up to their order: rounding, which was seen to be 1e-11 R after 200 steps and 2e-4 R after
    /// 500, so beds are compared after 300 at most.
    pub const ROUNDING: Tolerance = Tolerance {
        displacement: 1.0e-6,
        contacts: 1.0e-3,
        energy: 1.001,
    };
    /// Other operations: a force is then rounded by a distance's last digit over the overlap, some 10⁴ times more than a sum
    /// in another order is, and so much further apart are grains after the same steps.
    pub const FREE: Tolerance = Tolerance {
        displacement: 1.0e-2,
        ..Tolerance::ROUNDING
    };
    /// Forces in single precision: rounding that may have grown until grains are apart by as much as they have moved.
    pub const SINGLE: Tolerance = Tolerance {
        displacement: 0.1,
        contacts: 0.05,
        energy: 1.5,
    };
    /// One stiffness for all contacts and a drag in place of Cundall's damping: the same method with other choices.
    pub const OTHER_LAW: Tolerance = Tolerance {
        displacement: 0.2,
        contacts: 0.15,
        energy: 10.0,
    };
}

/// An engine's bed against the native exact one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sanity {
    /// Steps after which both were looked at.
    pub steps: u64,
    /// Largest distance between a grain here and there, over the mean radius.
    pub displacement: f64,
    /// Contacts between grains here.
    pub contacts: usize,
    /// Contacts between grains there.
    pub contacts_in_exact: usize,
    /// Kinetic energy here, J.
    pub energy: f64,
    /// Kinetic energy there, J.
    pub energy_in_exact: f64,
    /// What is allowed.
    pub tolerance: Tolerance,
    /// Whether it is kept.
    pub holds: bool,
}

impl Sanity {
    /// Holds a bed, with its number of contacts between grains, against the exact one.
    pub fn of(
        bodies: &Bodies,
        contacts: usize,
        exact: &Snapshot,
        mean_radius: f64,
        tolerance: Tolerance,
    ) -> Self {
        let there = &exact.bodies;
        let contacts_in_exact = between_grains(exact);
        let displacement = if bodies.len() == there.len() {
            largest_distance(bodies, there) / mean_radius
        } else {
            f64::INFINITY
        };
        let (energy, energy_in_exact) = (kinetic_energy(bodies), kinetic_energy(there));
        let lost = (contacts as f64 / contacts_in_exact as f64 - 1.0).abs();
        let ratio = (energy / energy_in_exact).max(energy_in_exact / energy);
        Sanity {
            steps: exact.step,
            displacement,
            contacts,
            contacts_in_exact,
            energy,
            energy_in_exact,
            tolerance,
            // Comparisons that a NaN fails.
            holds: displacement <= tolerance.displacement
                && lost <= tolerance.contacts
                && ratio <= tolerance.energy,
        }
    }
}

/// Contacts between two grains.
pub fn between_grains(snapshot: &Snapshot) -> usize {
    let grains = snapshot.bodies.len() as u32;
    let contacts = snapshot.contacts.iter();
    contacts.filter(|contact| contact.id1 < grains).count()
}

fn largest_distance(a: &Bodies, b: &Bodies) -> f64 {
    let mut largest = 0.0f64;
    for id in 0..a.len() {
        let distance = (a.x[id] - b.x[id]).hypot(a.z[id] - b.z[id]);
        // A NaN would be passed over by a maximum.
        if distance.is_nan() {
            return f64::INFINITY;
        }
        largest = distance.max(largest);
    }
    largest
}
