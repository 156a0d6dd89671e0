//! The page of the main job: its parts, and its figures as files.

use crossgrain::progress::Display;
use crossgrain::reproduce::beside::Beside;
use crossgrain::reproduce::reproduce;

use crate::support::pages::{each_figure_stands_once_and_has_numbers, job_without_yade};

/// Headings in the order in which they must stand: the evidence first, then what is no part of the verdict.
const PARTS: [&str; 13] = [
    "<div class=\"verdict",
    ">Comparisons</h2>",
    ">The packings</h2>",
    ">Histories</h2>",
    ">Would it notice?</h2>",
    ">Skipped</h2>",
    ">Every measured quantity</h2>",
    ">No part of the verdict</h2>",
    ">This realization beside the paper's figures</h2>",
    ">The paper's claims about its simulations</h2>",
    ">The largest stable time steps</h2>",
    ">Cost against error</h2>",
    ">Runs, versions and commands</h2>",
];

#[test]
fn every_part_stands_in_its_order_with_figures_and_where_they_come_from() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let options = job_without_yade(
        folder.path(),
        Beside::read(&[], true).expect("the recorded records"),
    );
    let (reproduction, runs) = reproduce(&options, &Display::new(true)).expect("a job");
    let page = |beside: &Beside| {
        let document = reproduction.document(&runs, beside, None);
        crossgrain::report::page(&document.expect("a document"))
    };
    let whole = page(&options.beside);
    let text = whole.html.replace("&#39;", "'");
    let places: Vec<Option<usize>> = PARTS.iter().map(|part| text.find(part)).collect();
    assert!(places.iter().all(Option::is_some), "{places:?}");
    assert!(places.is_sorted(), "{places:?}");
    let recorded = "Recorded, and not run again here";
    assert_eq!(whole.html.matches(recorded).count(), 3);
    // Distributions beside the theory's exponential, and long tables left to their own jobs.
    assert!(text.contains("theory's exponential") && text.contains("rows on the page of that job"));
    for words in [
        "Stochastic modeling of stress fields",
        "crossgrain 0.1.0, 2",
    ] {
        assert!(
            text[..places[1].expect("a place")].contains(words),
            "{words}"
        );
    }
    each_figure_stands_once_and_has_numbers(&whole);
    // The job's own record names them, and they judge nothing.
    assert_eq!(reproduction.beside.len(), 3);

    let alone = page(&Beside::default());
    assert!(!alone.html.contains("Cost against error</h2>"));
    assert!(alone.html.contains("are not on this page"));
    each_figure_stands_once_and_has_numbers(&alone);
}
