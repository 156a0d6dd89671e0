//! The study of rules: what is planned, and what made-up members say.

use crossgrain::study::conventions::{Conventions, Plan};
use crossgrain::study::member::{ANGLE, Member, Members, OfBeds};

use evidence::t_test::Finding;

use crate::support::*;

#[test]
fn each_rule_and_each_codes_set_is_held_against_the_usual_rules_on_the_same_clouds() {
    let plan = Plan::new(5);
    let settings: Vec<_> = plan.beds.settings().collect();
    let ids: BTreeSet<&String> = settings.iter().map(|setting| &setting.id).collect();
    assert_eq!(ids.len(), settings.len());
    for setting in &settings {
        let read = setting.specification.scene.check();
        assert!(read.is_ok(), "{}: {read:?}", setting.id);
    }
    let of_lammps = settings
        .iter()
        .find(|setting| setting.id == "lammps-column");
    let rules = of_lammps.expect("a set").specification.scene.rules;
    let names: Vec<String> = rules.unusual().map(|choice| choice.name()).collect();
    has(
        &names.join(", "),
        ["given_velocities = at_start", "spring_turn = keeps_length"],
    );
    // One rule makes heaps steeper by three degrees, and all others change nothing.
    let steeper = "spring-turn-projected-column";
    let member = |id: &str, cloud: u64, specification: String| {
        let more = if id == steeper {
            3.0
        } else {
            1.0e-3 * cloud as f64
        };
        let angle = 20.0 + 0.1 * cloud as f64 + more;
        Member {
            specification,
            realization: cloud,
            measured: BTreeMap::from([(ANGLE.to_owned(), angle)]),
            ..Member::default()
        }
    };
    let members: Members = settings
        .iter()
        .flat_map(|setting| {
            let digest = setting.specification.digest();
            let clouds = setting.realizations();
            clouds.map(move |cloud| member(&setting.id, cloud, digest.clone()))
        })
        .collect();
    let judged = plan.judged(&members).expect("a record");
    let found = judged.own["settings"].as_array().expect("settings");
    for found in found {
        let angle = &found["differences"][0];
        let is_column = found["id"]
            .as_str()
            .is_some_and(|id| id.ends_with("column"));
        let wanted = match found["id"] == steeper {
            _ if !is_column => continue,
            true => "different",
            false => "equivalent",
        };
        assert_eq!(angle["finding"], wanted, "{found}");
    }
    has(&judged.document.answer, ["1 are beyond them"]);
}

/// What is said of the recorded study is what its rows say.
#[test]
fn the_recorded_differences_are_those_of_their_rows_and_of_the_page() {
    let (_, recorded) = judged_again::<Plan, Conventions>("reference_data/conventions-1");
    let page = text_of(root("docs/rules.md"));
    let found = recorded.settings.iter();
    let all: Vec<_> = found
        .flat_map(|found| found.differences.iter().map(move |it| (found, it)))
        .collect();
    let count = |finding| {
        all.iter()
            .filter(|(_, difference)| difference.finding == Some(finding))
            .count()
    };
    let [within, beyond] = [Finding::Equivalent, Finding::Different].map(count);
    let said = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let counts = format!(
        "Of {} differences {within} are within their margins and {beyond} beyond",
        all.len()
    );
    has(&said, [counts.as_str()]);
    for (found, difference) in all {
        let margin = difference.margin.expect("a margin");
        let digits = (1.0_f64 - margin.log10().floor()).max(0.0) as usize;
        let number = |value: f64| format!("{value:.digits$}").replace('-', "−");
        let it = difference.paired.difference;
        let [estimate, low, high] = [it.estimate, it.low, it.high].map(number);
        let interval = format!("| {estimate} ({low} to {high}) |");
        let row = page.lines().find(|line| {
            line.starts_with(&format!("| {} |", found.name)) && line.contains(&interval)
        });
        assert_eq!(
            row.is_some(),
            difference.finding == Some(Finding::Different),
            "{} {interval}",
            found.name
        );
    }
}
