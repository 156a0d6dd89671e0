//! How grains touch: coordination number and rattlers, and the grains around a point: one by one, and summed over ever more of them.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use super::Bed;
use super::cells::Cells;
use crate::tables::Contact;

/// How grains touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordination {
    /// Z: contacts a grain has on average with grains, walls and punch.
    pub mean: f64,
    /// Z over the grains that are not rattlers, contacts with rattlers left out; none if all are.
    pub mean_without_rattlers: Option<f64>,
    /// Share of the grains that are rattlers: under gravity a frictionless grain needs two contacts to rest in the plane and three in
    /// space, so a rattler has fewer.
    pub rattler_share: f64,
}

/// Coordination of a bed; contacts with zero overlap count.
pub fn coordination(bed: Bed<'_>) -> Coordination {
    let ids = bed.ids();
    let count = bed.bodies.len();
    let grains_of = |contact: &Contact| {
        [contact.id1, contact.id2]
            .into_iter()
            .filter(move |id| ids.is_grain(*id))
            .map(|id| id as usize)
    };
    let mut touching = vec![0u32; count];
    for contact in bed.contacts {
        for id in grains_of(contact) {
            touching[id] += 1;
        }
    }
    let least = if bed.bodies.in_space() { 3 } else { 2 };
    let rattles = |id: usize| touching[id] < least;
    let rattlers = (0..count).filter(|id| rattles(*id)).count();
    let held: usize = bed
        .contacts
        .iter()
        .filter(|contact| !grains_of(contact).any(rattles))
        .map(|contact| grains_of(contact).count())
        .sum();
    Coordination {
        mean: f64::from(touching.iter().sum::<u32>()) / count as f64,
        mean_without_rattlers: (rattlers < count).then(|| held as f64 / (count - rattlers) as f64),
        rattler_share: rattlers as f64 / count as f64,
    }
}

/// So many nearest grains are kept one by one.
pub const SINGLY: usize = 8;

/// The control volumes: so many nearest cells together.
pub const GROWING: [usize; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];

/// One grain near a point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Neighbour {
    /// Place of its centre from the point, m.
    pub from_point: [f64; 2],
    /// How many bodies it touches.
    pub contacts: u32,
    /// V_p: area of its cell, m².
    pub cell: f64,
    /// Extensive stress Σ_xx, J per metre of depth, compression positive.
    pub xx: f64,
    /// Σ_zz.
    pub zz: f64,
    /// Σ_xz.
    pub xz: f64,
}

/// The nearest cells to a point together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Together {
    /// How many.
    pub grains: usize,
    /// ΣV_p, m².
    pub cell: f64,
    /// ΣΣ_xx, J per metre of depth.
    pub xx: f64,
    /// ΣΣ_zz.
    pub zz: f64,
    /// Height of their centre of volume above the point, m.
    pub rise: f64,
}

/// The grains around a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Neighbourhood {
    /// The point's name in the scene.
    pub point: String,
    /// The nearest [`SINGLY`] grains, nearest first.
    pub singly: Vec<Neighbour>,
    /// The sums over the nearest of [`GROWING`], as far as there are so many grains.
    pub together: Vec<Together>,
}

/// The neighbourhood of a place; `extensive` is Σ of every grain. Grains at the same distance are ordered by id.
pub fn of(
    point: &str,
    place: [f64; 2],
    bed: Bed<'_>,
    cells: &Cells,
    extensive: &[Matrix3<f64>],
) -> Neighbourhood {
    let bodies = bed.bodies;
    let from_point = |id: usize| [bodies.x[id] - place[0], bodies.z[id] - place[1]];
    let distance = |id: usize| {
        let [x, z] = from_point(id);
        x.hypot(z)
    };
    let mut nearest: Vec<(f64, usize)> = (0..bodies.len()).map(|id| (distance(id), id)).collect();
    let most = GROWING[GROWING.len() - 1].min(nearest.len());
    let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if most < nearest.len() {
        nearest.select_nth_unstable_by(most, order);
        nearest.truncate(most);
    }
    nearest.sort_by(order);
    let touched = |grain: usize| {
        let grain = grain as u32;
        let of_it = |contact: &&Contact| contact.id1 == grain || contact.id2 == grain;
        bed.contacts.iter().filter(of_it).count() as u32
    };
    let singly = nearest.iter().take(SINGLY).map(|(_, id)| Neighbour {
        from_point: from_point(*id),
        contacts: touched(*id),
        cell: cells.area[*id],
        xx: extensive[*id][(0, 0)],
        zz: extensive[*id][(2, 2)],
        xz: 0.5 * (extensive[*id][(0, 2)] + extensive[*id][(2, 0)]),
    });
    let mut together = Vec::new();
    let (mut sum, mut cell, mut moment) = (Matrix3::zeros(), 0.0, 0.0);
    for (index, (_, id)) in nearest.iter().enumerate() {
        sum += extensive[*id];
        cell += cells.area[*id];
        moment += cells.area[*id] * from_point(*id)[1];
        if GROWING.contains(&(index + 1)) {
            together.push(Together {
                grains: index + 1,
                cell,
                xx: sum[(0, 0)],
                zz: sum[(2, 2)],
                rise: moment / cell,
            });
        }
    }
    Neighbourhood {
        point: point.to_owned(),
        singly: singly.collect(),
        together,
    }
}
