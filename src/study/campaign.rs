//! Campaigns: many realizations of one scene, shared out, written down one by one, merged.
//!
//! A campaign is a folder: `plan.json`, which never changes; `records/`, a file a shard, which only grow; and, once it
//! is merged, `members.jsonl`, `members.csv` and `merged.json`.

pub mod compare;
pub mod member;
pub mod merge;
pub mod merged;
pub mod plan;
pub mod records;
pub mod run;
pub mod shard;
pub mod slurm;
pub mod status;

use std::path::PathBuf;

use crate::error::exit;
use crate::files::FileError;
use crate::run::EngineError;
use grains::scene::SceneError;

/// A campaign cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    #[error("{path} is no campaign: {reason}; `crossgrain campaign plan` makes one")]
    NotACampaign { path: PathBuf, reason: String },
    #[error(
        "the members of {path} are not merged yet; `crossgrain campaign run` makes those that are missing and merges them"
    )]
    NotMerged { path: PathBuf },
    #[error(
        "the merged members of {path} are damaged: {reason}; put back what was there, or let `crossgrain campaign merge` \
         write it anew from the records"
    )]
    Damaged { path: PathBuf, reason: String },
    #[error(
        "{path} was planned with crossgrain {planned}, and this is {present}, which may give other bits; go on with the \
         version that planned it, or plan a new campaign"
    )]
    OtherVersion {
        path: PathBuf,
        planned: String,
        present: String,
    },
    #[error("{path} is being written by another process; wait for it, or let it do another shard")]
    Busy { path: PathBuf },
    #[error(
        "members {members} are missing, {missing} of {wanted}; run `crossgrain campaign run` on the folder, then merge"
    )]
    Incomplete {
        /// The first few, for people.
        members: String,
        missing: u64,
        wanted: u64,
    },
    #[error(
        "two records of member {member} differ, in {first} and {second}: an engine whose bits depend on more than the \
         scene, or a file that was changed; find out which, and take the wrong file away"
    )]
    Contradiction {
        member: u64,
        first: PathBuf,
        second: PathBuf,
    },
    #[error("members were made by different engines ({engines}): merge what one engine made")]
    MixedEngines { engines: String },
    #[error("{0}")]
    Usage(String),
    #[error(
        "{finished} members are written down; of members {members} the engine failed, the first with: {first}"
    )]
    EnginesFailed {
        finished: u64,
        members: String,
        first: String,
    },
    #[error(
        "asked to end; {finished} of {wanted} members are written down, start the command again to go on"
    )]
    Interrupted { finished: u64, wanted: u64 },
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl CampaignError {
    /// Its exit code; none where that of the error inside counts.
    pub fn exit_code(&self) -> Option<u8> {
        match self {
            CampaignError::NotACampaign { .. }
            | CampaignError::Damaged { .. }
            | CampaignError::OtherVersion { .. }
            | CampaignError::Usage(_) => Some(exit::USAGE),
            CampaignError::Busy { .. } | CampaignError::Interrupted { .. } => Some(exit::TRY_AGAIN),
            CampaignError::NotMerged { .. } | CampaignError::Incomplete { .. } => {
                Some(exit::INCOMPLETE)
            }
            CampaignError::Contradiction { .. } | CampaignError::MixedEngines { .. } => {
                Some(exit::CHECK_FAILED)
            }
            CampaignError::EnginesFailed { .. } => Some(exit::ENGINE_FAILED),
            CampaignError::Engine(_) | CampaignError::File(_) | CampaignError::Scene(_) => None,
        }
    }
}
