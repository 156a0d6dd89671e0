//! What `run.json` of the main job says, and its checks. And records of other jobs that stand on its page: cost against error, stable
//! steps, which settings give the figures, those settled by many packings, claims; those that the user has made, or the recorded ones.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::checks::{Check, Measured, Outcome, Speed};
use crate::compare::{Comparison, first_steps};
use crate::document::Document;
use crate::error::Error;
use crate::files::{Place, read_text, unpacked};
use crate::limits::stability::Map;
use crate::paper::published::{HEIGHTS, POROSITIES, Printed, printed};
use crate::paper::{self, Number};
use crate::run::folder::RunFolder;
use crate::study::answer::answer;
use crate::study::candidates::judge::Candidates;
use crate::study::claims::{CLAIMS_VERSION, Claims};
use crate::study::search::matching::Search;
use crate::study::tradeoff::Tradeoff;
use crate::suite::parameters::{ParameterPair, pair_checks};
use crate::suite::run::Verification;
use grains::scene::paper_scene;
use verdict::judge::Judgement;

#[derive(Debug, Clone, Default, Serialize)]
pub struct Reproduction {
    pub crossgrain: String,
    pub command: String,
    pub scene_digest: String,
    /// The version of the YADE that ran live.
    pub yade: Option<String>,
    /// Of all checks; skipped if no comparison with another engine could be made or the experiment did not come to its end.
    pub verdict: Outcome,
    pub comparisons: Vec<NamedComparison>,
    /// What the first steps of YADE's loops say, if YADE ran live.
    pub first_steps: Vec<LoopSteps>,
    /// Deliberate faults, each of which the comparison must find.
    pub faults: Vec<FaultCheck>,
    /// The parameters that both engines use, if YADE ran live.
    pub facts: Vec<ParameterPair>,
    pub suite: Option<Verification>,
    pub skipped: Vec<Skipped>,
    pub claims: Vec<Claim>,
    pub numbers: Vec<Number>,
    pub text_faults: Vec<paper::TextFault>,
    /// Records of other jobs that stand on the page; they are no part of the verdict.
    pub beside: Vec<Stated>,
    pub runs: Vec<RunSummary>,
    pub seconds: f64,
}

impl Reproduction {
    pub fn checks(&self) -> Vec<Check> {
        let comparisons = self.comparisons.iter();
        let made: Vec<Outcome> = comparisons
            .map(|named| named.comparison.verdict().into())
            .collect();
        let (outcome, found) = match &made[..] {
            [] => (Outcome::Skipped, "none was made"),
            verdicts if verdicts.contains(&Outcome::Pass) => (Outcome::Pass, ""),
            verdicts if verdicts.contains(&Outcome::Fail) => (Outcome::Fail, "none agrees"),
            _ => (Outcome::Skipped, "none was decided"),
        };
        let what = "at least one comparison with another engine agrees";
        let compared = Check::of_words("compare/made", what, outcome, found);
        let mut checks = vec![compared.required()];
        let compared = self.comparisons.iter();
        checks.extend(compared.flat_map(|named| named.comparison.all_checks(&named.id)));
        let first_steps = self.first_steps.iter();
        checks
            .extend(first_steps.flat_map(|steps| first_steps::checks(&steps.judgement, &steps.id)));
        for fault in &self.faults {
            let id = format!("faults/{}", fault.fault.replace('=', "-"));
            let check = Check::of_words(id, &fault.fault, fault.verdict, &fault.found);
            checks.push(check.judged_by(
                "the fault is put into the native engine alone; the comparison with the sound one must find it",
                "any bit that differs",
            ));
        }
        checks.extend(pair_checks(&self.facts));
        if let Some(suite) = &self.suite {
            // An engine that is not there leaves the job complete.
            checks.extend(suite.checks().into_iter().map(|check| Check {
                required: false,
                ..check
            }));
        }
        checks.extend(self.numbers.iter().map(Number::check));
        checks.extend(self.skipped.iter().map(|skipped| Check {
            required: skipped.required,
            ..Check::of_words(
                skipped.id.as_str(),
                &skipped.what,
                Outcome::Skipped,
                &skipped.why,
            )
        }));
        checks
    }

    /// YADE's time a step over the native engine's, of the runs that were made live, one each.
    pub fn speeds(&self) -> Vec<Speed> {
        let speed = |run: &RunSummary| {
            let way = run.folder.strip_prefix("yade-")?;
            Some(Speed {
                id: format!("time/{way}"),
                what: format!("time a step of {} over native", run.engine),
                unit: "times native".to_owned(),
                value: run.times_native?,
                range: None,
                less_is_better: false,
            })
        };
        self.runs.iter().filter_map(speed).collect()
    }
}

/// A comparison with the folders it was made from.
#[derive(Debug, Clone, Serialize)]
pub struct NamedComparison {
    /// The beginning of its checks' ids.
    pub id: String,
    pub title: String,
    pub folders: Vec<String>,
    pub comparison: Comparison,
}

/// What the first steps of one of YADE's loops say.
#[derive(Debug, Clone, Serialize)]
pub struct LoopSteps {
    /// The beginning of its checks' ids.
    pub id: String,
    pub title: String,
    pub judgement: Judgement,
}

#[derive(Debug, Clone, Serialize)]
pub struct Skipped {
    pub id: String,
    pub what: String,
    pub why: String,
    pub required: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultCheck {
    /// As on the command line.
    pub fault: String,
    /// Passed if the comparison found it; not made where the fault changes nothing in this scene.
    pub verdict: Outcome,
    /// The first step and grain, or why it was not found.
    pub found: String,
}

#[derive(Debug, Clone, Serialize)]
pub struct RunSummary {
    /// In the output folder.
    pub folder: String,
    /// Who ran, in words.
    pub engine: String,
    pub stages: String,
    /// Processor time over all stages, µs.
    pub microseconds_per_step: f64,
    /// Time per step over that of the native run of this job; none for a run made elsewhere.
    pub times_native: Option<f64>,
    /// Processor time of all stages, s.
    pub cpu_seconds: f64,
    pub command: String,
}

impl RunSummary {
    pub fn of(folder: &str, run: &RunFolder) -> Self {
        let record = &run.record;
        let parts = record.parts.map(|count| format!(", in {count} parts"));
        RunSummary {
            folder: folder.to_owned(),
            engine: record.engine.label(),
            stages: run.stages_in_words() + &parts.unwrap_or_default(),
            microseconds_per_step: 1e6 * record.seconds_per_step(),
            times_native: None,
            cpu_seconds: record.cpu_seconds(),
            command: record.command.clone(),
        }
    }
}

/// Everything that was measured in a run, for baselines to hold later runs against.
pub fn measured(run: &RunFolder) -> Vec<Measured> {
    let entry = |quantity: grains::measure::Quantity| Measured {
        id: quantity.key,
        unit: quantity.unit,
        value: quantity.value,
    };
    run.quantities().into_iter().map(entry).collect()
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    pub what: String,
    /// As printed, in `unit`.
    pub published: f64,
    pub scatter: Option<f64>,
    /// From this run, in `unit`.
    pub ours: f64,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    pub reading: String,
}

/// The claims that this run has a figure for; none for a scene that is not the paper's. One realization decides nothing about a
/// distribution, so these are findings, not checks.
pub fn claims(run: &RunFolder) -> Vec<Claim> {
    let scene = &run.scene;
    if scene.digest() != paper_scene(scene.realization, 5000).digest() {
        return Vec::new();
    }
    let measured = run.quantities();
    let claim = |what: String, key: &str, id: &str| {
        let figure: &Printed = printed(id)?;
        let ours = measured.iter().find(|quantity| quantity.key == key)?.value;
        let scatter = Some(figure.rounding).filter(|_| id.starts_with("bed/"));
        let off = (ours - figure.value).abs();
        let reading = match scatter {
            None => format!(
                "{:.2} of the published mean; one draw from a wide distribution",
                ours / figure.value
            ),
            Some(scatter) if off <= scatter => "within the published scatter".to_owned(),
            Some(_) => "outside the published scatter".to_owned(),
        };
        Some(Claim {
            what,
            published: figure.value,
            scatter,
            ours,
            unit: figure.unit.to_owned(),
            reading,
        })
    };
    let heights = HEIGHTS.map(|(key, words)| claim(format!("H, {words}"), key, "bed/height"));
    let porosities =
        POROSITIES.map(|(key, words)| claim(format!("n, {words}"), key, "bed/porosity"));
    let at_points = [
        ("local mean σ_zz", "local_zz", "stress"),
        (
            "Σ_zz of V_c, nearest grain",
            "control_volume_zz",
            "extensive",
        ),
    ];
    let stresses = scene.control_points.iter().flat_map(|point| {
        at_points.map(|(what, key, column)| {
            let key = format!("loaded.stress.{}.{key}", point.name);
            let id = format!("table-4/{column}/{}", point.name);
            claim(format!("{what} at {}", point.name), &key, &id)
        })
    });
    let all = heights.into_iter().chain(porosities).chain(stresses);
    all.flatten().collect()
}

/// The most of a record that is read, bytes.
const LARGEST: u64 = 1 << 25;

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
    /// What claims and search say of the published figures, in sentences; none without both.
    pub answer: Vec<String>,
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
        version: crate::checks::record::VERSION,
        recorded: include_bytes!("../../reference_data/tradeoff-1/report.json.gz"),
        document: |text| serde_json::from_str(text).map(|tradeoff: Tradeoff| tradeoff.document()),
    },
    Kind {
        job: "stability",
        made_by: "crossgrain stability",
        file: "report.json",
        version: crate::checks::record::VERSION,
        recorded: include_bytes!("../../reference_data/stability-1/report.json.gz"),
        document: |text| serde_json::from_str(text).map(|map: Map| map.document()),
    },
    Kind {
        job: "search",
        made_by: "crossgrain study plan search",
        file: "report.json",
        version: crate::checks::record::VERSION,
        recorded: include_bytes!("../../reference_data/search-1/wave-2/report.json.gz"),
        document: |text| serde_json::from_str(text).map(|search: Search| search.document()),
    },
    Kind {
        job: "candidates",
        made_by: "crossgrain study plan candidates",
        file: "report.json",
        version: crate::checks::record::VERSION,
        recorded: include_bytes!("../../reference_data/candidates-1/report.json.gz"),
        document: |text| {
            serde_json::from_str(text).map(|candidates: Candidates| candidates.document())
        },
    },
    Kind {
        job: "claims",
        made_by: "crossgrain study claims",
        file: "claims.json",
        version: CLAIMS_VERSION,
        recorded: include_bytes!("../../reference_data/claims-1/claims.json.gz"),
        document: |text| serde_json::from_str(text).map(|claims: Claims| claims.summary()),
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
        let (mut claims, mut search) = (None, None);
        for (kind, text) in KINDS.iter().zip(texts) {
            let recorded = text.is_none();
            let (path, text) = match text {
                Some(own) => own,
                None if with_recorded => {
                    let path = PathBuf::from(kind.file);
                    let text = unpacked(&path, kind.recorded)?;
                    (path, text)
                }
                None => continue,
            };
            records.push(kind.parse(&path, &text, recorded)?);
            match kind.job {
                "claims" => claims = serde_json::from_str::<Claims>(&text).ok(),
                "search" => search = serde_json::from_str::<Search>(&text).ok(),
                _ => {}
            }
        }
        let both = claims.zip(search);
        let answer = both.and_then(|(claims, search)| answer(&claims, &search));
        let answer = answer.map_or(Vec::new(), |sentences| sentences.to_vec());
        Ok(Beside { records, answer })
    }

    pub fn stated(&self) -> Vec<Stated> {
        let all = self.records.iter();
        all.map(|(stated, _)| stated.clone()).collect()
    }
}

impl Kind {
    /// The record of this job in a folder; studies of all kinds have the same file, which says whose it is.
    fn find(&self, folder: &Path) -> Result<Option<(PathBuf, String)>, Error> {
        let (path, place) = (folder.join(self.file), Place::from((folder, self.file)));
        if !place.is_taken() {
            return Ok(None);
        }
        let text = read_text(place, LARGEST)?;
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
        let command = command.ok_or_else(|| bad("it does not say its command".to_owned()))?;
        let document = (self.document)(text).map_err(|error| bad(error.to_string()))?;
        let stated = Stated {
            job: self.job,
            command,
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
        let jobs: Vec<&str> = stated.iter().map(|record| record.job).collect();
        let wanted = ["tradeoff", "stability", "search", "candidates", "claims"];
        assert_eq!(jobs, wanted);
        let mut stated = stated.iter();
        assert!(stated.all(|record| record.recorded && !record.command.is_empty()));
        let none = Beside::read(&[], false).expect("nothing");
        assert!(none.stated().is_empty());
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
            let names_both = said.contains(words) && said.contains("report.json");
            assert!(names_both, "{said}");
        }
    }
}
