//! Reading a merged campaign: its plan and all of its members. `members.jsonl` may be packed (`members.jsonl.gz`).

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::CampaignError;
use super::member::Member;
use super::merge::Summary;
use super::plan::Plan;
use crate::files::{failed, read_text};

/// The members, a line of JSON each.
pub const MEMBERS: &str = "members.jsonl";
/// See [`Summary`].
pub const SUMMARY: &str = "merged.json";
/// A member is about 20 kB; a longer line is none.
const LONGEST_LINE: u64 = 4_000_000;

/// A file and its lines.
type Lines = (PathBuf, BufReader<Box<dyn Read>>);

/// A merged campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// What was run.
    pub plan: Plan,
    /// What came of it in short.
    pub summary: Summary,
    /// In the order of their numbers, from 1, none missing.
    pub members: Vec<Member>,
}

/// Whether the campaign was merged.
pub fn is_merged(folder: &Path) -> bool {
    folder.join(SUMMARY).is_file()
}

/// Reads a merged campaign and checks its bytes and members against summary and plan.
pub fn read(folder: &Path) -> Result<Merged, CampaignError> {
    let mut members = Vec::new();
    let (plan, summary) = each(folder, |member| members.push(member))?;
    Ok(Merged {
        plan,
        summary,
        members,
    })
}

/// The same, a member at a time: of a million members not all fit into memory. What was taken counts only if this
/// ends well, since the bytes are known to be sound at the end alone.
pub fn each(folder: &Path, mut take: impl FnMut(Member)) -> Result<(Plan, Summary), CampaignError> {
    let plan = Plan::read(folder)?;
    let damaged = |reason: String| CampaignError::Damaged {
        path: folder.to_owned(),
        reason,
    };
    if !is_merged(folder) {
        return Err(CampaignError::NotMerged {
            path: folder.to_owned(),
        });
    }
    let text = read_text(&folder.join(SUMMARY), 1_000_000)?;
    let summary: Summary =
        serde_json::from_str(&text).map_err(|error| damaged(format!("{SUMMARY}: {error}")))?;
    if summary.plan != plan.digest() {
        return Err(damaged(format!("{SUMMARY} is of another plan")));
    }
    let Some((path, mut lines)) = open(folder)? else {
        return Err(damaged(format!("{MEMBERS} is not there")));
    };
    let mut read = 0;
    let mut hash = Sha256::new();
    let mut line = String::new();
    loop {
        line.clear();
        let mut bounded = (&mut lines).take(LONGEST_LINE);
        if bounded
            .read_line(&mut line)
            .map_err(failed("read", &path))?
            == 0
        {
            break;
        }
        hash.update(line.as_bytes());
        let number = read + 1;
        let member: Member = serde_json::from_str(&line)
            .map_err(|error| damaged(format!("line {number} of {MEMBERS}: {error}")))?;
        if member.member != number || member.realization != plan.realization(number) {
            return Err(damaged(format!(
                "line {number} of {MEMBERS} is of another member"
            )));
        }
        take(member);
        read = number;
    }
    let sha256: String = hash
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    if sha256 != summary.sha256 || read != plan.members {
        return Err(damaged(format!("{MEMBERS} is not what was merged")));
    }
    Ok((plan, summary))
}

/// The members' lines, if they are there.
fn open(folder: &Path) -> Result<Option<Lines>, CampaignError> {
    let plain = folder.join(MEMBERS);
    let packed = folder.join(format!("{MEMBERS}.gz"));
    let Some(path) = [plain, packed].into_iter().find(|path| path.is_file()) else {
        return Ok(None);
    };
    let file = File::open(&path).map_err(failed("open", &path))?;
    let reader: Box<dyn Read> = if path.extension().is_some_and(|end| end == "gz") {
        Box::new(flate2::read::GzDecoder::new(file))
    } else {
        Box::new(file)
    };
    Ok(Some((path, BufReader::new(reader))))
}
