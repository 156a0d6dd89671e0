//! Records of other jobs that stand on the main job's page: cost against error, stable steps, which settings give the figures, those settled by many packings, claims. Those that the user
//! has made, or the recorded ones.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::document::Document;
use crate::error::Error;
use crate::files::{read_text, unpacked};
use crate::limits::stability::Map;
use crate::study::candidates::judge::Candidates;
use crate::study::claims::{CLAIMS_VERSION, Claims};
use crate::study::search::matching::Search;
use crate::study::tradeoff::{TRADEOFF_VERSION, Tradeoff};

/// The most of a record that is read, bytes.
const LARGEST: u64 = 1 << 28;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stated {
    pub job: &'static str,
    pub command: String,
    pub crossgrain: String,
    pub scene_digest: String,
    /// Whether it is the recorded one, which comes with the program.
    pub recorded: bool,
}

/// The records that stand on the page: what each says of itself, and what it shows.
#[derive(Debug, Clone, Default)]
pub struct Beside {
    /// At most one of a job.
    pub records: Vec<(Stated, Document)>,
}

/// A job whose records are known here.
struct Kind {
    job: &'static str,
    made_by: &'static str,
    file: &'static str,
    /// The newest; older ones have what the page shows.
    version: u32,
    /// The one that comes with the program, packed.
    recorded: &'static [u8],
    document: fn(&str) -> serde_json::Result<Document>,
}

const KINDS: [Kind; 5] = [
    Kind {
        job: "tradeoff",
        made_by: "crossgrain study plan tradeoff",
        file: "report.json",
        version: TRADEOFF_VERSION,
        recorded: include_bytes!("../../reference_data/tradeoff-1/report.json.gz"),
        document: |text| serde_json::from_str(text).map(|of: Tradeoff| of.document()),
    },
    Kind {
        job: "stability",
        made_by: "crossgrain stability",
        file: "report.json",
        version: crate::checks::record::VERSION,
        recorded: include_bytes!("../../reference_data/stability-1/report.json.gz"),
        document: |text| serde_json::from_str(text).map(|of: Map| of.document()),
    },
    Kind {
        job: "search",
        made_by: "crossgrain study plan search",
        file: "report.json",
        version: crate::checks::record::VERSION,
        recorded: include_bytes!("../../reference_data/search-1/wave-2/report.json.gz"),
        document: |text| serde_json::from_str(text).map(|of: Search| of.document()),
    },
    Kind {
        job: "candidates",
        made_by: "crossgrain study plan candidates",
        file: "report.json",
        version: crate::checks::record::VERSION,
        recorded: include_bytes!("../../reference_data/candidates-1/report.json.gz"),
        document: |text| serde_json::from_str(text).map(|of: Candidates| of.document()),
    },
    Kind {
        job: "claims",
        made_by: "crossgrain study claims",
        file: "claims.json",
        version: CLAIMS_VERSION,
        recorded: include_bytes!("../../reference_data/claims-1/claims.json.gz"),
        document: |text| serde_json::from_str(text).map(|of: Claims| of.summary()),
    },
];

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

impl Beside {
    /// Those in these folders of finished jobs, and for the other ones the recorded ones if `with_recorded`.
    pub fn read(folders: &[PathBuf], with_recorded: bool) -> Result<Self, Error> {
        let mut texts: [Option<(PathBuf, String)>; KINDS.len()] = Default::default();
        for folder in folders {
            let mut taken = false;
            for (kind, place) in KINDS.iter().zip(&mut texts) {
                let Some(found) = kind.find(folder)? else {
                    continue;
                };
                taken = true;
                if place.replace(found).is_some() {
                    return Err(Error::Usage(format!(
                        "{} is a second record of {}; name one with --with",
                        folder.join(kind.file).display(),
                        kind.job
                    )));
                }
            }
            if !taken {
                let jobs = KINDS.map(|kind| format!("{} of {}", kind.file, kind.job));
                return Err(Error::Usage(format!(
                    "{} holds none of {}; --with names the folder of a finished job",
                    folder.display(),
                    jobs.join(", ")
                )));
            }
        }
        let mut records = Vec::new();
        for (kind, text) in KINDS.iter().zip(texts) {
            match text {
                Some((path, text)) => records.push(kind.parse(&path, &text, false)?),
                None if with_recorded => {
                    let path = Path::new(kind.file);
                    records.push(kind.parse(path, &unpacked(path, kind.recorded)?, true)?);
                }
                None => {}
            }
        }
        Ok(Beside { records })
    }

    pub fn stated(&self) -> Vec<Stated> {
        let all = self.records.iter();
        all.map(|(stated, _)| stated.clone()).collect()
    }
}

impl Kind {
    /// The record of this job in a folder; studies of all kinds have the same file, which says whose it is.
    fn find(&self, folder: &Path) -> Result<Option<(PathBuf, String)>, Error> {
        let path = folder.join(self.file);
        if !path.is_file() {
            return Ok(None);
        }
        let text = read_text(&path, LARGEST)?;
        let job = serde_json::from_str::<Head>(&text).map_or(None, |head| head.job);
        Ok(job
            .is_none_or(|job| job == self.job)
            .then_some((path, text)))
    }

    fn parse(&self, path: &Path, text: &str, recorded: bool) -> Result<(Stated, Document), Error> {
        let bad = |reason: String| {
            Error::Usage(format!(
                "{}: {reason}; make it again with {}",
                path.display(),
                self.made_by
            ))
        };
        let head: Head = serde_json::from_str(text).map_err(|error| bad(error.to_string()))?;
        if head.version > self.version {
            return Err(bad(format!(
                "it is of version {}, and this program reads up to version {}",
                head.version, self.version
            )));
        }
        let command = head.command.or(head.origin.map(|origin| origin.command));
        let document = (self.document)(text).map_err(|error| bad(error.to_string()))?;
        let stated = Stated {
            job: self.job,
            command: command.unwrap_or_default(),
            crossgrain: head.crossgrain,
            scene_digest: head.scene_digest,
            recorded,
        };
        Ok((stated, document))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recorded_ones_are_there_and_of_one_scene() {
        let beside = Beside::read(&[], true).expect("the recorded records are read");
        let stated = beside.stated();
        let jobs: Vec<&str> = stated.iter().map(|of| of.job).collect();
        assert_eq!(
            jobs,
            ["tradeoff", "stability", "search", "candidates", "claims"]
        );
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
