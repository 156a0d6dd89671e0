//! The paper's claims about its simulations, held against a campaign's members.
//!
//! One number a packing throughout; what is decided is whether an effect is smaller than a tolerance that was set
//! beforehand, never whether a p-value is small: with a thousand packings every difference has a small one.

mod beds;
mod cells;
pub mod claim;
mod document;
mod means;
mod sample;
mod shapes;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use self::cells::{Volume, Volumes, continuum};
use self::claim::{Claim, Verdict};
pub use self::document::{Cloud, Figures};
pub use self::sample::Moment;
use crate::study::campaign::member::Member;
use crate::study::realization::Ending;
use evidence::holm;
use grains::scene::{Scene, paper_scene};

/// The version of `claims.json`.
pub const CLAIMS_VERSION: u32 = 2;

/// Where the members come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// The command as it was given.
    pub command: String,
    /// Engine and version that ran them.
    pub engine: String,
    /// Digest of the campaign's plan.
    pub plan: String,
    /// SHA-256 of the merged members.
    pub members_digest: String,
}

/// The claims.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claims {
    /// [`CLAIMS_VERSION`].
    pub version: u32,
    /// Version of crossgrain.
    pub crossgrain: String,
    /// Where the members come from.
    pub origin: Origin,
    /// Digest of the campaign's scene.
    pub scene_digest: String,
    /// Where the scene differs from the project's default for the paper: key, default, here.
    pub other_choices: Vec<[String; 3]>,
    /// How many members.
    pub members: usize,
    /// How they ended.
    pub endings: BTreeMap<String, usize>,
    /// In the order of the paper.
    pub claims: Vec<Claim>,
    /// How many claims came to which verdict; `open` for those that need more members.
    pub verdicts: BTreeMap<String, usize>,
    /// Whether every claim has a verdict.
    pub complete: bool,
    /// Data of the figures.
    pub figures: Figures,
}

/// Holds the claims against the members of a scene.
pub fn of(scene: &Scene, members: &[Member], origin: Origin) -> Claims {
    let series = cells::all(scene, members);
    let mut claims: Vec<Claim> = [
        beds::height(members),
        beds::porosity(members),
        beds::both(scene, members),
        Some(beds::reached(members)),
        means::gravity(members),
        means::at_point(members, "O"),
        means::at_point(members, "A"),
        means::at_point(members, "B"),
        means::extensive(members),
    ]
    .into_iter()
    .flatten()
    .collect();
    claims.extend(means::POINTS.map(|point| shapes::at_point(members, point)));
    claims.extend(means::with_theorys_rate(members));
    claims.extend([
        shapes::horizontal(members),
        shapes::settled(members),
        shapes::positive_only(members),
        shapes::laplace(members),
        cells::independence(members),
        cells::square_root(members, &series, Moment::Loaded),
        cells::square_root(members, &series, Moment::Settled),
        cells::erlang(members, &series),
        cells::good_enough(members, &series),
    ]);
    claims.push(shapes::conclusion(&claims));
    for claim in &mut claims {
        if claim
            .rows
            .iter()
            .any(|row| row.judged.is_some() && row.ours.is_none())
        {
            claim.reading = "Too few members to say.".to_owned();
        }
    }
    adjust(&mut claims);
    let mut verdicts = BTreeMap::new();
    for claim in &claims {
        *verdicts
            .entry(claim.verdict.map_or("open", Verdict::words).to_owned())
            .or_insert(0) += 1;
    }
    let mut endings = BTreeMap::new();
    for member in members {
        *endings
            .entry(ending(&member.ending).to_owned())
            .or_insert(0) += 1;
    }
    Claims {
        version: CLAIMS_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        origin,
        scene_digest: scene.digest(),
        other_choices: other_choices(scene),
        members: members.len(),
        endings,
        complete: claims.iter().all(|claim| claim.verdict.is_some()),
        claims,
        verdicts,
        figures: document::data(members, series, beds::solid(scene)),
    }
}

fn ending(of: &Ending) -> &'static str {
    match of {
        Ending::Reached => "reached",
        Ending::TargetLoadNotReached => "target load not reached",
        Ending::NotSettled => "not settled",
        Ending::Poured => "poured",
        Ending::Failed(_) => "failed",
    }
}

/// Holm over the tests of all claims.
fn adjust(claims: &mut [Claim]) {
    let mut all: Vec<&mut claim::Probability> = claims
        .iter_mut()
        .flat_map(|claim| &mut claim.rows)
        .flat_map(|row| &mut row.probabilities)
        .collect();
    let given: Vec<f64> = all.iter().map(|one| one.p).collect();
    for (one, adjusted) in all.iter_mut().zip(holm::adjusted(&given)) {
        one.adjusted = adjusted;
    }
}

/// What of the scene is not the default: leaves of its JSON, without its name, realization and words.
fn other_choices(scene: &Scene) -> Vec<[String; 3]> {
    let leaves = |scene: &Scene| {
        let mut leaves = BTreeMap::new();
        let value = serde_json::to_value(scene).unwrap_or_default();
        collect("", &value, &mut leaves);
        leaves
    };
    let (default, here) = (leaves(&paper_scene(1, 5000)), leaves(scene));
    let mut keys: Vec<&String> = default.keys().chain(here.keys()).collect();
    keys.sort();
    keys.dedup();
    let absent = "–".to_owned();
    keys.into_iter()
        .filter(|key| default.get(*key) != here.get(*key))
        .filter(|key| {
            ![
                "/choices",
                "/name",
                "/realization",
                "/measurement/history_every",
            ]
            .iter()
            .any(|of| key.starts_with(of))
        })
        .map(|key| {
            let of = |leaves: &BTreeMap<String, String>| leaves.get(key).unwrap_or(&absent).clone();
            [key.clone(), of(&default), of(&here)]
        })
        .collect()
}

fn collect(path: &str, value: &serde_json::Value, leaves: &mut BTreeMap<String, String>) {
    match value {
        serde_json::Value::Object(map) => {
            for (key, value) in map {
                collect(&format!("{path}/{key}"), value, leaves);
            }
        }
        serde_json::Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                collect(&format!("{path}/{index}"), value, leaves);
            }
        }
        leaf => {
            leaves.insert(path.to_owned(), leaf.to_string());
        }
    }
}
