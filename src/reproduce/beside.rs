//! Records of other jobs that stand on the main job's page: cost against error, stable steps, claims. Those that the user
//! has made, or the recorded ones.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::files::{read_text, unpacked};
use crate::limits::stability::Map;

use crate::study::claims::{CLAIMS_VERSION, Claims};
use crate::study::tradeoff::record::{TRADEOFF_VERSION, Tradeoff};

/// The most of a record that is read, bytes.
const LARGEST: u64 = 1 << 28;

/// What a record says of itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stated {
    /// Which job made it: `tradeoff`.
    pub job: &'static str,
    /// How to make it again.
    pub command: String,
    /// Version of crossgrain that made it.
    pub crossgrain: String,
    /// Digest of its scene.
    pub scene_digest: String,
    /// Whether it is the recorded one, which comes with the program.
    pub recorded: bool,
}

/// A record and what it says of itself.
#[derive(Debug, Clone)]
pub struct Known<T> {
    /// As read.
    pub record: T,
    /// Of the page's words.
    pub stated: Stated,
}

/// The records that stand on the page.
#[derive(Debug, Clone, Default)]
pub struct Beside {
    /// Cost against error.
    pub tradeoff: Option<Known<Tradeoff>>,
    /// The largest stable steps.
    pub stability: Option<Known<Map>>,
    /// Distributions and claims.
    pub claims: Option<Known<Claims>>,
}

impl Beside {
    /// Those in these folders of finished jobs, and for the other ones the recorded ones if `with_recorded`.
    pub fn read(folders: &[PathBuf], with_recorded: bool) -> Result<Self, Error> {
        let mut beside = Beside::default();
        for folder in folders {
            beside.take(folder)?;
        }
        if with_recorded {
            fill(&mut beside.tradeoff, &TRADEOFF, TRADEOFF_RECORDED)?;
            fill(&mut beside.stability, &STABILITY, STABILITY_RECORDED)?;
            fill(&mut beside.claims, &CLAIMS, CLAIMS_RECORDED)?;
        }
        Ok(beside)
    }

    fn take(&mut self, folder: &Path) -> Result<(), Error> {
        let taken = [
            take(&mut self.tradeoff, &TRADEOFF, folder)?,
            take(&mut self.stability, &STABILITY, folder)?,
            take(&mut self.claims, &CLAIMS, folder)?,
        ];
        if taken.contains(&true) {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "{} holds no {} of a tradeoff or stability study and no {}; --with names the folder of a finished job",
            folder.display(),
            TRADEOFF.file,
            CLAIMS.file
        )))
    }

    /// What all of them say of themselves.
    pub fn stated(&self) -> Vec<&Stated> {
        let Beside {
            tradeoff,
            stability,
            claims,
        } = self;
        let all = [
            tradeoff.as_ref().map(|of| &of.stated),
            stability.as_ref().map(|of| &of.stated),
            claims.as_ref().map(|of| &of.stated),
        ];
        all.into_iter().flatten().collect()
    }
}

/// Of the jobs whose records are known here.
struct Kind {
    job: &'static str,
    file: &'static str,
    /// The newest; older ones have what the page shows.
    version: u32,
}

const TRADEOFF: Kind = Kind {
    job: "tradeoff",
    file: "report.json",
    version: TRADEOFF_VERSION,
};
const STABILITY: Kind = Kind {
    job: "stability",
    file: "report.json",
    version: crate::checks::record::VERSION,
};
const CLAIMS: Kind = Kind {
    job: "claims",
    file: "claims.json",
    version: CLAIMS_VERSION,
};

const TRADEOFF_RECORDED: &[u8] = include_bytes!("../../reference_data/tradeoff-1/report.json.gz");
const STABILITY_RECORDED: &[u8] = include_bytes!("../../reference_data/stability-1/report.json.gz");
const CLAIMS_RECORDED: &[u8] = include_bytes!("../../reference_data/claims-1/claims.json.gz");

/// What every record has.
#[derive(Debug, Deserialize)]
struct Head {
    /// None in a record of claims.
    job: Option<String>,
    version: u32,
    crossgrain: String,
    /// Of claims it stands with their origin.
    command: Option<String>,
    origin: Option<Origin>,
    scene_digest: String,
}

#[derive(Debug, Deserialize)]
struct Origin {
    command: String,
}

fn fill<T: DeserializeOwned>(
    place: &mut Option<Known<T>>,
    kind: &Kind,
    packed: &[u8],
) -> Result<(), Error> {
    if place.is_none() {
        let text = unpacked(Path::new(kind.file), packed)?;
        *place = Some(parse(kind, Path::new(kind.file), &text, true)?);
    }
    Ok(())
}

/// Whether the folder has a record of this kind.
fn take<T: DeserializeOwned>(
    place: &mut Option<Known<T>>,
    kind: &Kind,
    folder: &Path,
) -> Result<bool, Error> {
    let path = folder.join(kind.file);
    if !path.is_file() {
        return Ok(false);
    }
    let text = read_text(&path, LARGEST)?;
    let job = serde_json::from_str::<Head>(&text).map_or(None, |head| head.job);
    if job.is_some_and(|job| job != kind.job) {
        return Ok(false);
    }
    if place.is_some() {
        return Err(Error::Usage(format!(
            "{} is a second record of {}; name one with --with",
            path.display(),
            kind.job
        )));
    }
    *place = Some(parse(kind, &path, &text, false)?);
    Ok(true)
}

fn parse<T: DeserializeOwned>(
    kind: &Kind,
    path: &Path,
    text: &str,
    recorded: bool,
) -> Result<Known<T>, Error> {
    let bad = |reason: String| {
        Error::Usage(format!(
            "{}: {reason}; make it again with crossgrain {}",
            path.display(),
            kind.job
        ))
    };
    let head: Head = serde_json::from_str(text).map_err(|error| bad(error.to_string()))?;
    if head.version > kind.version {
        return Err(bad(format!(
            "it is of version {}, and this program reads up to version {}",
            head.version, kind.version
        )));
    }
    let command = head.command.or(head.origin.map(|origin| origin.command));
    Ok(Known {
        record: serde_json::from_str(text).map_err(|error| bad(error.to_string()))?,
        stated: Stated {
            job: kind.job,
            command: command.unwrap_or_default(),
            crossgrain: head.crossgrain,
            scene_digest: head.scene_digest,
            recorded,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recorded_ones_are_there_and_of_one_scene() {
        let beside = Beside::read(&[], true).expect("the recorded records are read");
        let stated = beside.stated();
        let jobs: Vec<&str> = stated.iter().map(|of| of.job).collect();
        assert_eq!(jobs, ["tradeoff", "stability", "claims"]);
        assert!(
            stated
                .iter()
                .all(|of| of.recorded && !of.command.is_empty())
        );
        assert!(
            Beside::read(&[], false)
                .expect("nothing")
                .stated()
                .is_empty()
        );
    }

    #[test]
    fn what_is_no_record_is_refused_with_what_to_do() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let read = || Beside::read(&[folder.path().to_owned()], true);
        let said = |read: Result<Beside, Error>| read.expect_err("is refused").to_string();
        assert!(said(read()).contains("--with"));
        let path = folder.path().join("report.json");
        for (text, words) in [
            ("{", "make it again"),
            (
                "{\"job\":\"stability\",\"version\":99,\"crossgrain\":\"9\",\"scene_digest\":\"\"}",
                "version 99",
            ),
        ] {
            std::fs::write(&path, text).expect("can be written");
            let said = said(read());
            assert!(
                said.contains(words) && said.contains("report.json"),
                "{said}"
            );
        }
    }
}
