//! How far a campaign is.

use std::path::Path;

use serde::Serialize;

use super::CampaignError;
use super::plan::Plan;
use super::records::Index;
use super::run::in_words;

/// How far a campaign is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Status {
    /// Engine and mode.
    pub runner: String,
    /// As planned.
    pub members: u64,
    /// With a believed record.
    pub finished: u64,
    /// Members with more than one record, as two processes with different shards leave them.
    pub repeated: u64,
    /// File and number of records.
    pub files: Vec<(String, u64)>,
    /// File and line of what is not believed.
    pub damaged: Vec<(String, u64)>,
    /// The first missing members, for people; empty if there are none.
    pub missing: String,
    /// Whether the members are merged.
    pub merged: bool,
}

/// Reads every record of the campaign.
pub fn status(folder: &Path) -> Result<Status, CampaignError> {
    let plan = Plan::read(folder)?;
    let index = Index::read(folder, &plan.digest(), plan.members)?;
    let name = |path: &Path| {
        let name = path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    };
    let files = index.files.iter().zip(&index.records);
    Ok(Status {
        runner: plan.runner.name(),
        members: plan.members,
        finished: index.places.len() as u64,
        repeated: index.repeated.len() as u64,
        files: files
            .map(|(path, records)| (name(path), *records))
            .collect(),
        damaged: index
            .damaged
            .iter()
            .map(|damaged| (name(&damaged.path), damaged.line))
            .collect(),
        missing: in_words(&missing(&plan, &index)),
        merged: super::merged::is_merged(folder),
    })
}

/// The members without a record.
pub fn missing(plan: &Plan, index: &Index) -> Vec<u64> {
    (1..=plan.members)
        .filter(|member| !index.places.contains_key(member))
        .collect()
}
