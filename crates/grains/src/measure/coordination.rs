//! Coordination number and rattlers.

use super::Bed;

/// How grains touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordination {
    /// Z: contacts a grain has on average with grains, walls and punch.
    pub mean: f64,
    /// Z over the grains that are not rattlers, contacts with rattlers left out; none if all are.
    pub mean_without_rattlers: Option<f64>,
    /// Share of the grains that are rattlers: under gravity a frictionless grain needs two contacts
    /// to rest, so a rattler has fewer than two.
    pub rattler_share: f64,
}

/// Coordination of a bed; contacts with zero overlap count.
pub fn of(bed: Bed<'_>) -> Coordination {
    let ids = bed.ids();
    let count = bed.bodies.len();
    let grains_of = |contact: &crate::tables::Contact| {
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
    let rattles = |id: usize| touching[id] < 2;
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
