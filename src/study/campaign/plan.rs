//! The plan of a campaign: everything that its members depend on, fixed before the first one runs.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::CampaignError;
use crate::engine::yade;
use crate::files::{read_text, sha256_hex, write_folder, write_whole};
use crate::study::realization::Runner;
use grains::native::pouring::Phase;
use grains::scene::{Scene, parse_scene};

/// The plan format that this program reads and writes.
const PLAN_VERSION: u32 = 1;
/// The largest campaign that files, memory and merging were planned for.
pub const MOST_MEMBERS: u64 = 1_000_000;
/// A scene is a few kB.
const LARGEST: u64 = 10_000_000;
const NAME: &str = "plan.json";
/// The key of the digest in the plan's file.
const DIGEST: &str = "digest";

/// What is run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Format of this file.
    pub version: u32,
    /// Version of the program that planned it, the only one that may run it.
    pub crossgrain: String,
    /// In which engine.
    pub runner: Runner,
    /// Pouring part by part, where the scene's own stages are not used.
    pub phases: Vec<Phase>,
    /// SHA-256 of the scripts that run inside YADE, where it is YADE.
    pub yade_scripts: Option<String>,
    /// How many members.
    pub members: u64,
    /// Realization of member 1; member k pours realization `seed + k − 1`, whoever runs it.
    pub seed: u64,
    /// [`Scene::digest`].
    pub scene_digest: String,
    /// The scene; its own realization has no meaning here.
    pub scene: Scene,
}

impl Plan {
    /// The plan of so many members of the scene.
    pub fn new(
        scene: &Scene,
        runner: Runner,
        phases: Vec<Phase>,
        members: u64,
        seed: u64,
    ) -> Result<Self, CampaignError> {
        if members == 0 || members > MOST_MEMBERS {
            return Err(CampaignError::Usage(format!(
                "{members} members; a campaign has 1 to {MOST_MEMBERS}"
            )));
        }
        if seed.checked_add(members).is_none() {
            return Err(CampaignError::Usage(format!(
                "--seed {seed} leaves no room for {members} members"
            )));
        }
        let mut scene = scene.clone();
        scene.realization = seed;
        Ok(Plan {
            version: PLAN_VERSION,
            crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
            runner,
            phases,
            yade_scripts: runner.is_yade().then(yade::script_digest),
            members,
            seed,
            scene_digest: scene.digest(),
            scene,
        })
    }

    /// Which cloud a member pours; members are counted from 1.
    pub fn realization(&self, member: u64) -> u64 {
        self.seed + (member - 1)
    }

    /// SHA-256 of the whole plan, in hexadecimal; every record names it.
    pub fn digest(&self) -> String {
        sha256_hex(serde_json::to_string(self).unwrap_or_default().as_bytes())
    }

    /// Makes the campaign's folder, which must not exist.
    pub fn write(&self, folder: &Path) -> Result<(), CampaignError> {
        write_folder(folder, |aside| {
            let records = super::records::records_folder(aside);
            std::fs::create_dir(&records).map_err(crate::files::failed("create", &records))?;
            let mut text = self.text();
            text.push('\n');
            Ok(write_whole(&aside.join(NAME), text.as_bytes())?)
        })
    }

    /// As it is on the disk: the plan with its digest at the end, so that a plan that was edited is noticed before
    /// anything is run.
    fn text(&self) -> String {
        let mut stored = serde_json::to_value(self).unwrap_or_default();
        stored[DIGEST] = self.digest().into();
        serde_json::to_string_pretty(&stored).unwrap_or_default()
    }

    /// Reads the plan of a campaign's folder and checks that it is whole.
    pub fn read(folder: &Path) -> Result<Self, CampaignError> {
        let path = folder.join(NAME);
        let not_one = |reason: String| CampaignError::NotACampaign {
            path: folder.to_owned(),
            reason,
        };
        if !path.is_file() {
            return Err(not_one(format!("it has no {NAME}")));
        }
        let text = read_text(&path, LARGEST)?;
        let wrong = |error: serde_json::Error| not_one(format!("{NAME}: {error}"));
        let mut stored: serde_json::Value = serde_json::from_str(&text).map_err(wrong)?;
        let digest = stored.as_object_mut().and_then(|of| of.remove(DIGEST));
        let plan: Plan = serde_json::from_value(stored).map_err(wrong)?;
        if plan.version != PLAN_VERSION {
            return Err(not_one(format!(
                "{NAME} has version {}, and this program reads {PLAN_VERSION}",
                plan.version
            )));
        }
        // The first campaigns have none; their records name the plan's digest all the same.
        if digest.is_some_and(|digest| digest != plan.digest()) {
            return Err(not_one(format!(
                "{NAME} was changed after it was made, and plans never change; put back what was there, or plan a new \
                 campaign"
            )));
        }
        // What a scene must fulfil is checked where scenes are read.
        let scene = serde_json::to_string(&plan.scene).unwrap_or_default();
        parse_scene(&scene)?;
        if plan.scene.digest() != plan.scene_digest {
            return Err(not_one(format!(
                "the scene in {NAME} is not the one that was planned"
            )));
        }
        let Plan { members, seed, .. } = plan;
        if members == 0 || members > MOST_MEMBERS || seed.checked_add(members).is_none() {
            return Err(not_one(format!(
                "{NAME} has {members} members from seed {seed}"
            )));
        }
        Ok(plan)
    }

    /// That this program gives the bits that were planned.
    pub fn check_version(&self, folder: &Path) -> Result<(), CampaignError> {
        let other = |planned: &str, present: &str| {
            Err(CampaignError::OtherVersion {
                path: folder.to_owned(),
                planned: planned.to_owned(),
                present: present.to_owned(),
            })
        };
        let present = env!("CARGO_PKG_VERSION");
        let short = |digest: &str| digest.chars().take(12).collect::<String>();
        if self.crossgrain != present {
            return other(&self.crossgrain, present);
        }
        match &self.yade_scripts {
            Some(planned) if *planned != yade::script_digest() => other(
                &format!("{present} with YADE scripts {}", short(planned)),
                &format!("{present} with scripts {}", short(&yade::script_digest())),
            ),
            _ => Ok(()),
        }
    }
}

/// Where the plan is.
pub fn path(folder: &Path) -> PathBuf {
    folder.join(NAME)
}
