//! The verb: record, page and exit code.

use crossgrain::study::campaign::Campaign;
use crossgrain::study::claims::{Claim, Claims, Verdict};
use crossgrain::study::folder::{AnyStudy as _, StudyFolder};
use crossgrain::study::plan::Plan;
use crossgrain::study::realization::Runner;
use evidence::distribution::Distribution;

use super::truth::{Truth, members};
use crate::campaign::record_line;

use crate::support::*;

/// Writes members as a merged campaign.
fn write_campaign(folder: &Path, truth: &Truth) {
    let scene = paper_scene(1, 5000);
    let runner = Runner::Native;
    let campaign = Campaign::new(&scene, runner, Vec::new(), truth.members, 1);
    let plan = Plan::new(campaign, None).expect("a plan");
    plan.write(folder).expect("a new folder");
    let members = members(&scene, truth);
    let lines = members
        .iter()
        .map(|member| record_line(&plan.digest(), member));
    let lines: String = lines.collect();
    fs::write(folder.join("records/shard-1-of-1.jsonl"), lines).expect("a writable folder");
    let merged = StudyFolder::<Campaign>::open(folder).and_then(|study| study.merge());
    merged.expect("whole rows");
}

/// Exit code 0 where every claim has a verdict and 3 where one is undecided; record and page are written either way.
#[test]
fn the_verb_writes_record_and_page_and_tells_whether_all_is_decided() {
    let at = &new_folder();
    let (shape, scale) = (4.0, 0.25);
    let narrow = Distribution::Gamma { shape, scale };
    for (name, count, wanted, pictures) in [
        ("many", 600, 3, 37),
        ("few", 20, 3, 31),
        // Two have no cells, which take three; one has neither intervals nor distributions, and its bed.
        ("two", 2, 3, 23),
        ("one", 1, 3, 1),
        // So far from what the paper says that so many decide all.
        ("far", 300, 0, 37),
    ] {
        let mut truth = Truth::paper();
        truth.members = count;
        if count < 3 {
            truth.heights = [0.42; 3];
        }
        if name == "far" {
            (truth.normal, truth.shear) = (narrow, narrow);
            (truth.factor, truth.heights) = ([0.5; 3], [0.44; 3]);
            (truth.common, truth.porosity) = (0.8, 0.13);
        }
        write_campaign(&at.join(name), &truth);
        let out = format!("{name}-claims");
        let (code, said, errors) = say(at, &["study", "claims", name, "--out", &out, "--json"]);
        // Not among the JSON, which others read.
        let where_it_is = format!("report: {out}/report.html\n");
        assert_eq!(code, wanted, "{name}: {errors}");
        assert!(errors.ends_with(&where_it_is), "{errors}");
        let record = text_of(at.join(&out).join("claims.json"));
        assert_eq!(record, said, "{name}");
        let record: Value = serde_json::from_str(&record).expect("JSON");
        assert_eq!(record["complete"], code == 0);
        assert_eq!(record["verdicts"]["undecided"].is_null(), code == 0);
        let page = text_of(at.join(&out).join("report.html"));
        // Three points in each of four histograms, three of them with shares of larger values, six tails, eight volumes, the means and the
        // plane.
        assert_eq!(page.matches("<svg").count(), pictures, "{name}");
        assert!(!page.contains("NaN"), "{name}");
        // The line that ties porosity to height goes past every bed, on both sides.
        let plane = at.join(&out).join("figures/height-and-porosity.csv");
        let (mut line, mut beds): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for row in csv::Reader::from_path(plane).expect("numbers").records() {
            let row = row.expect("as many cells as the head");
            match &row[0] {
                "printed" => {}
                "area of the grains" => line.push(row[1].parse().expect("a height")),
                _ => beds.push(row[1].parse().expect("a height")),
            }
        }
        assert!(!beds.is_empty() && line.len() == 21, "{name}");
        assert!(beds.iter().all(|bed| line[0] < *bed && *bed < line[20]));
    }
    // An earlier result is kept, and a folder without one is never written into.
    let (code, _, errors) = say(at, "study claims many --out few-claims");
    let kept = at.join("few-claims-2/claims.json").exists();
    assert!(code != 2 && kept, "{errors}");
    tells(at, 2, "study claims many --out few", ["exists already"]);
    // Without --out it only says.
    tells(at, 3, "study claims few", ["undecided"]);
}

#[test]
fn two_campaigns_stand_side_by_side_claim_by_claim() {
    let at = &new_folder();
    for (name, height) in [("here", 0.46), ("other", 0.6)] {
        let mut truth = Truth::paper();
        (truth.members, truth.heights) = (60, [height; 3]);
        write_campaign(&at.join(name), &truth);
    }
    let command = "study claims here --beside other --out both";
    tells(at, 3, command, ["Beside stand 60 members"]);
    let read = |path: &str| {
        let text = text_of(at.join(path));
        serde_json::from_str::<Claims>(&text).expect("claims")
    };
    let both = read("both/claims.json");
    let height = |claims: &[Claim]| {
        let own = claims.iter().find(|claim| claim.id == "height");
        own.expect("the claim of the height").verdict
    };
    let beside = both.beside.as_ref().expect("the other campaign");
    assert_eq!(height(&both.claims), Some(Verdict::Holds));
    assert_eq!(height(&beside.claims), Some(Verdict::DoesNotHold));
    // As if each were judged alone.
    tells(at, 3, "study claims other --out alone", ["undecided"]);
    assert_eq!(beside.claims, read("alone/claims.json").claims);
    let page = text_of(at.join("both/report.html"));
    assert!(page.contains("beside: verdict"));
}
