//! The answer about the published figures: README, the first page and the paper draft say what the records say.

use crossgrain::files::read_text;
use crossgrain::study::answer::answer;
use crossgrain::study::claims::{Claim, Claims, Row, Verdict};
use crossgrain::study::search::matching::Search;
use evidence::Interval;

use crate::support::*;

fn records() -> (Claims, Search) {
    let path = root("reference_data/claims-1/claims.json.gz");
    let text = read_text(&path, 1 << 26).expect("recorded claims");
    let claims = serde_json::from_str(&text).expect("claims");
    (claims, recorded_of(root("reference_data/search-1/wave-2")))
}

fn sentences() -> [String; 3] {
    let (claims, search) = records();
    answer(&claims, &search).expect("both settings are there")
}

/// With single spaces and without Markdown's marks.
fn plain(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ").replace("**", "")
}

#[test]
fn readme_and_paper_give_the_answer_of_the_records() {
    for page in ["README.md", "paper/paper.md"] {
        let text = plain(&text_of(root(page)));
        for sentence in sentences() {
            assert!(text.contains(&sentence), "{page} lacks: {sentence}");
        }
    }
}

fn claim<'a>(claims: &'a mut [Claim], id: &str) -> &'a mut Claim {
    let found = claims.iter_mut().find(|claim| claim.id == id);
    found.expect("a claim")
}

#[test]
fn the_answer_is_no_stronger_than_the_records() {
    let (claims, search) = records();
    let said = |change: fn(&mut Claims, &mut Search)| {
        let (mut claims, mut search) = (claims.clone(), search.clone());
        change(&mut claims, &mut search);
        answer(&claims, &search).map(|sentences| sentences.join(" "))
    };
    let as_it_is = said(|_, _| ()).expect("an answer");
    has(
        &as_it_is,
        [
            "do not come out together",
            "on the edge",
            "not exponential (gamma shape at O",
            "does not exclude",
        ],
    );
    let open = said(|claims, _| claim(&mut claims.claims, "height_and_porosity").verdict = None);
    has(
        &open.expect("an answer"),
        ["not shown to come out together"],
    );
    let other = said(|claims, search| {
        let beside = claims.beside.as_mut().expect("another setting");
        for point in ["O", "A", "B"] {
            claim(&mut beside.claims, &format!("exponential.{point}")).verdict = None;
            let rows = &mut claim(&mut beside.claims, &format!("mean.{point}")).rows;
            let judged = rows.iter_mut().filter_map(|row| row.judged.as_mut());
            judged.for_each(|judged| judged.outcome = crossgrain::checks::Outcome::Skipped);
        }
        search.best[0].at.fill(0.5);
        search
            .maps
            .iter_mut()
            .for_each(|map| map.least.fill(Some(9.0)));
    });
    has(
        &other.expect("an answer"),
        [
            "our search is not shown to have",
            "exponential is undecided",
            "and excludes",
        ],
    );
    assert_eq!(said(|claims, _| claims.beside = None), None);
}

/// The numbers of the table in docs/claims.md, row by row, are those of the record, with as many digits as stand there.
#[test]
fn the_table_of_a_thousand_packings_is_that_of_the_record() {
    let (claims, _) = records();
    let beside = claims.beside.expect("another setting").claims;
    let text = text_of(root("docs/claims.md"));
    let row = |claims: &[Claim], id: &str, begins: &str| -> Row {
        let own = claims.iter().find(|claim| claim.id == id).expect("a claim");
        let found = own.rows.iter().find(|row| row.what.starts_with(begins));
        found
            .unwrap_or_else(|| panic!("{id} has no {begins}"))
            .clone()
    };
    let told = |interval: &Interval, unit: f64, digits: usize| {
        let [low, high] =
            [interval.low, interval.high].map(|limit| format!("{:.digits$}", limit / unit));
        (
            format!("{:.digits$}", interval.estimate / unit),
            format!("({low}–{high})"),
        )
    };
    let form = "Σ_zz of grains that bear load: ";
    let all = "Σ_zz of all grains: ";
    for (begins, id, number, unit, digits) in [
        (
            "height, mean surface",
            "height",
            "mean surface".to_owned(),
            1.0,
            4,
        ),
        (
            "porosity from it",
            "porosity",
            "from the mean surface".to_owned(),
            1.0,
            4,
        ),
        (
            "σ_zz under gravity at O",
            "gravity",
            "O: local".to_owned(),
            1e3,
            2,
        ),
        (
            "σ_zz at O, nearest grain",
            "mean.O",
            "nearest grain, as".to_owned(),
            1e3,
            1,
        ),
        ("at A |", "mean.A", "nearest grain, as".to_owned(), 1e3, 1),
        ("at B |", "mean.B", "nearest grain, as".to_owned(), 1e3, 1),
        (
            "variation at O, loaded",
            "exponential.O",
            format!("{form}coeff"),
            1.0,
            2,
        ),
        (
            "variation at O, all",
            "exponential.O",
            format!("{all}coeff"),
            1.0,
            2,
        ),
        (
            "gamma shape at O",
            "exponential.O",
            format!("{form}gamma"),
            1.0,
            2,
        ),
        (
            "gamma shape at A",
            "exponential.A",
            format!("{form}gamma"),
            1.0,
            2,
        ),
        (
            "gamma shape at B",
            "exponential.B",
            format!("{form}gamma"),
            1.0,
            2,
        ),
        (
            "exponent of N at O",
            "variation.load",
            "O: exponent".to_owned(),
            1.0,
            2,
        ),
    ] {
        let mut lines = text.lines();
        let line = lines.find(|line| line.starts_with(&format!("| {begins}")));
        let line = line
            .unwrap_or_else(|| panic!("no row {begins}"))
            .replace('−', "-")
            .replace(" to ", "–");
        for claims in [&claims.claims, &beside] {
            let ours = row(claims, id, &number).ours.expect("a number");
            let (estimate, interval) = told(&ours, unit, digits);
            has(&line, [&estimate, &interval]);
        }
    }
    let counts = |claims: &[Claim]| {
        [
            Some(Verdict::DoesNotHold),
            Some(Verdict::Holds),
            Some(Verdict::HoldsUnderStatedChoices),
            None,
        ]
        .map(|wanted| {
            claims
                .iter()
                .filter(|claim| claim.verdict == wanted)
                .count()
        })
    };
    let [no, yes, by_choice, open] = counts(&claims.claims);
    let [no_1, yes_1, by_choice_1, open_1] = counts(&beside);
    let sentence = format!(
        "{no} and {no_1} do not hold, {yes} and {yes_1} hold, {by_choice} and {by_choice_1} hold under stated choices, {open} and {open_1} are undecided"
    );
    has(&plain(&text), [&sentence]);
}
