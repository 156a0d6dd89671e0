//! Merging: the records of all shards, each member once, in the order of members. The bytes depend on the plan alone.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::CampaignError;
use super::member::Member;
use super::merged::{MEMBERS, SUMMARY};
use super::plan::Plan;
use super::records::{Index, Reader};
use super::run::in_words;
use super::status::missing;
use crate::files::{FileError, failed, write_whole};
use crate::study::realization::Ending;

/// `merged.json`: what was merged.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// Digest of the plan.
    pub plan: String,
    /// How many members.
    pub members: u64,
    /// Engine and version.
    pub engine: String,
    /// How many members ended in which way.
    pub endings: BTreeMap<String, u64>,
    /// SHA-256 of `members.jsonl`.
    pub sha256: String,
}

/// Merges a complete campaign into `members.jsonl`, `members.csv` and, last of all, `merged.json`.
pub fn merge(folder: &Path) -> Result<Summary, CampaignError> {
    let plan = Plan::read(folder)?;
    let digest = plan.digest();
    let index = Index::read(folder, &digest, plan.members)?;
    let missing = missing(&plan, &index);
    if !missing.is_empty() {
        return Err(CampaignError::Incomplete {
            members: in_words(&missing),
            missing: missing.len() as u64,
            wanted: plan.members,
        });
    }
    let mut reader = Reader::new(&index);
    for (member, place) in &index.repeated {
        let first = &index.places[member];
        if reader.json(first)? != reader.json(place)? {
            return Err(CampaignError::Contradiction {
                member: *member,
                first: index.path(first).to_owned(),
                second: index.path(place).to_owned(),
            });
        }
    }
    let mut engines: BTreeMap<String, u64> = BTreeMap::new();
    let mut endings: BTreeMap<String, u64> = BTreeMap::new();
    let mut hash = Sha256::new();
    let mut lines = Aside::new(folder)?;
    let mut table = Aside::new(folder)?;
    // Columns must be known before the first row; members that failed have fewer.
    let mut columns: Vec<String> = Vec::new();
    for (number, place) in &index.places {
        let member = parse(&reader.json(place)?, folder)?;
        if member.member != *number || member.realization != plan.realization(*number) {
            return Err(CampaignError::NotACampaign {
                path: folder.to_owned(),
                reason: format!("the record of member {number} is of another member"),
            });
        }
        for key in member.measured.keys() {
            if let Err(at) = columns.binary_search(key) {
                columns.insert(at, key.clone());
            }
        }
    }
    table.line(&header(&columns))?;
    for place in index.places.values() {
        let json = reader.json(place)?;
        let member = parse(&json, folder)?;
        if !member.engine.is_empty() {
            *engines.entry(member.engine.clone()).or_default() += 1;
        }
        *endings
            .entry(ending_name(&member.ending).to_owned())
            .or_default() += 1;
        hash.update(json.as_bytes());
        hash.update(b"\n");
        lines.line(&json)?;
        table.line(&row(&member, &columns))?;
    }
    if engines.len() > 1 {
        let of = engines
            .iter()
            .map(|(name, count)| format!("{name}: {count}"));
        return Err(CampaignError::MixedEngines {
            engines: of.collect::<Vec<String>>().join(", "),
        });
    }
    let summary = Summary {
        plan: digest,
        members: plan.members,
        engine: engines.into_keys().next().unwrap_or_default(),
        endings,
        sha256: hash
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect(),
    };
    lines.into_place(&folder.join(MEMBERS))?;
    table.into_place(&folder.join("members.csv"))?;
    let mut text = serde_json::to_string_pretty(&summary).unwrap_or_default();
    text.push('\n');
    write_whole(&folder.join(SUMMARY), text.as_bytes())?;
    Ok(summary)
}

fn parse(json: &str, folder: &Path) -> Result<Member, CampaignError> {
    serde_json::from_str(json).map_err(|error| CampaignError::NotACampaign {
        path: folder.to_owned(),
        reason: format!("a record is no member: {error}"),
    })
}

/// The word for it in tables.
pub fn ending_name(ending: &Ending) -> &'static str {
    match ending {
        Ending::Reached => "reached",
        Ending::Sank => "sank",
        Ending::NotSettled => "not_settled",
        Ending::Poured => "poured",
        Ending::Failed(_) => "failed",
    }
}

fn header(columns: &[String]) -> String {
    let mut names = vec![
        "member",
        "realization",
        "ending",
        "pour_steps",
        "load_steps",
    ];
    let columns: Vec<String> = columns.iter().map(|name| cell(name)).collect();
    names.extend(columns.iter().map(String::as_str));
    names.join(",")
}

/// A name as one cell: those of control points are anything.
fn cell(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

/// Numbers have no commas; the reason of a failure stands in `members.jsonl`.
fn row(member: &Member, columns: &[String]) -> String {
    let mut cells = vec![
        member.member.to_string(),
        member.realization.to_string(),
        ending_name(&member.ending).to_owned(),
        member.pour_steps.to_string(),
        member.load_steps.to_string(),
    ];
    cells.extend(columns.iter().map(|key| {
        let value = member.measured.get(key);
        value.map(|value| format!("{value:?}")).unwrap_or_default()
    }));
    cells.join(",")
}

/// A file that is written aside, of any size.
struct Aside {
    file: BufWriter<tempfile::NamedTempFile>,
}

impl Aside {
    fn new(folder: &Path) -> Result<Self, FileError> {
        let file = tempfile::Builder::new()
            .prefix(".crossgrain.partial-")
            .tempfile_in(folder)
            .map_err(failed("write into", folder))?;
        Ok(Aside {
            file: BufWriter::new(file),
        })
    }

    fn line(&mut self, text: &str) -> Result<(), FileError> {
        let written = self
            .file
            .write_all(text.as_bytes())
            .and_then(|()| self.file.write_all(b"\n"));
        written.map_err(failed("write", self.file.get_ref().path()))
    }

    fn into_place(self, path: &Path) -> Result<(), FileError> {
        let file = self
            .file
            .into_inner()
            .map_err(|error| failed("write", path)(error.into_error()))?;
        crate::files::into_place(file, path)
    }
}
