//! Where an engine's numbers are off.

use std::collections::{BTreeMap, BTreeSet};

use grains::tables::{Contact, Snapshot};
use grains::task::Case;

use super::{MARKS, Of, Row};
use crate::conditions;

/// In no more steps than these a step says more than which contacts are wrong there.
const FEW_STEPS: usize = 3;
/// So many grains or contacts are named.
const FEW: usize = 4;

/// What those that are off have of their own sizes and of what their contacts are, at all moments.
fn split(rows: &[&Row]) -> Option<String> {
    let grains = usize::from(matches!(rows.first()?.subject, Of::Grain(_)));
    let has = MARKS.map(|(mark, _)| move |row: &&Row| row.marks & mark != 0);
    let properties = MARKS.iter().zip(&has).map(|((_, words), has)| {
        let words = [words[2 * grains], words[2 * grains + 1]];
        (words, has as &dyn Fn(&&Row) -> bool)
    });
    let properties: Vec<_> = properties.collect();
    let names = rows[0].sizes.iter().enumerate();
    let sizes = names.map(|(at, (name, _))| (*name, move |row: &&Row| row.sizes[at].1));
    let sizes: Vec<_> = sizes.collect();
    let numbers = sizes
        .iter()
        .map(|(name, size)| (*name, size as &dyn Fn(&&Row) -> f64));
    let numbers: Vec<_> = numbers.collect();
    let of_contact = |row: &&Row| match row.subject {
        Of::Contact(one, two) => (row.at.0, one, two),
        Of::Grain(id) => (row.at.0, id as u32, id as u32),
    };
    let is_off = |row: &&Row| row.is_off();
    conditions::of_rows(rows, (is_off, of_contact), &properties, &numbers)
}

/// Where rows are off: what all of them have at the moment that has most, or which they are.
pub(super) fn place(rows: &[&Row], off: &[&Row], runs: &[(&Case, &[Snapshot])]) -> String {
    let mut few: Vec<String> = Vec::new();
    for row in off {
        let name = match row.subject {
            Of::Contact(one, two) => format!("{one}–{two}"),
            Of::Grain(id) => format!("grain {id}"),
        };
        if !few.contains(&name) {
            few.push(name);
        }
        if few.len() > FEW {
            break;
        }
    }
    let begins = |row: &Row| match row.subject {
        Of::Contact(one, two) => {
            let before = row.at.1.checked_sub(1).map(|at| &runs[row.at.0].1[at]);
            // Tables have rising ids.
            before.is_none_or(|moment| {
                let place = moment
                    .contacts
                    .binary_search_by_key(&(one, two), Contact::ids);
                place.is_err()
            })
        }
        Of::Grain(_) => false,
    };
    if rows.iter().all(|row| begins(row) == row.is_off()) {
        return "in the first step of each alone".to_owned();
    }
    let mut moments: BTreeMap<(usize, usize), (usize, usize)> = BTreeMap::new();
    for row in rows {
        let counts = moments.entry(row.at).or_default();
        counts.0 += 1;
        counts.1 += usize::from(row.is_off());
    }
    let whole = moments
        .values()
        .filter(|(_, off)| *off > 0)
        .all(|(all, off)| all == off);
    let steps = moments.iter().filter(|(_, counts)| counts.1 > 0);
    let steps: BTreeSet<u64> = steps.map(|(at, _)| runs[at.0].1[at.1].step).collect();
    if whole && (few.len() > FEW || steps.len() <= FEW_STEPS) {
        let steps: Vec<String> = steps.iter().map(u64::to_string).collect();
        let more = if steps.len() > 6 { ", …" } else { "" };
        return format!(
            "in step {}{more} alone, and in all of them there",
            steps[..steps.len().min(6)].join(", ")
        );
    }
    let is_at_times = |row: &&Row| {
        !row.is_off()
            && off
                .iter()
                .any(|off| off.subject == row.subject && off.at.0 == row.at.0)
    };
    if few.len() <= FEW && !rows.iter().any(is_at_times) {
        return format!("{} alone", few.join(", "));
    }
    if let Some(where_all_are) = split(rows) {
        return where_all_are;
    }
    // A moment at which all are off, as where all contacts begin, tells no condition.
    let (run, at) = moments
        .iter()
        .max_by_key(|(_, (all, off))| (off < all, *off))
        .map_or((0, 0), |(at, _)| *at);
    let here = off.iter().filter(|row| row.at == (run, at));
    let (case, moments) = runs[run];
    let (mut contacts, mut grains) = (Vec::new(), Vec::new());
    for row in here {
        match row.subject {
            Of::Contact(one, two) => contacts.push((one, two)),
            Of::Grain(id) => grains.push(id),
        }
    }
    let all: Vec<Of> = rows
        .iter()
        .filter(|row| row.at == (run, at))
        .map(|row| row.subject)
        .collect();
    let condition = match contacts.is_empty() {
        true => {
            let among = |id: usize| all.contains(&Of::Grain(id));
            conditions::of_grains(case, &moments[at.saturating_sub(1)], &grains, &among)
        }
        false => {
            let among = |ids: (u32, u32)| all.contains(&Of::Contact(ids.0, ids.1));
            conditions::of_contacts(
                case,
                &moments[..at],
                &moments[at],
                ("contacts are wrong", &contacts),
                &among,
            )
        }
    };
    condition.unwrap_or_else(|| format!("{} of {}", off.len(), rows.len()))
}
