//! The page of the main job: its parts, and its figures as files.

use crossgrain::progress::Display;
use crossgrain::reproduce::beside::Beside;
use crossgrain::reproduce::reproduce;

use crate::support::pages::{each_figure_stands_once_and_has_numbers, job_without_yade};

/// In the order in which they must stand, by what is written only there.
const PARTS: [&str; 8] = [
    "<div class=\"verdict",
    "<h2 id=\"cost\"",
    "<h2 id=\"stability\"",
    "<h2 id=\"distributions\"",
    "<h2 id=\"comparisons\"",
    "<h2 id=\"packings\"",
    "<h2 id=\"claims\"",
    "<h2 id=\"provenance\"",
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
        crossgrain::report::page::render(&reproduction, &runs, beside, None).expect("a page")
    };
    let whole = page(&options.beside);
    let places: Vec<Option<usize>> = PARTS.iter().map(|part| whole.html.find(part)).collect();
    assert!(places.iter().all(Option::is_some), "{places:?}");
    assert!(places.is_sorted(), "{places:?}");
    assert_eq!(
        whole
            .html
            .matches("Recorded, and not run again here")
            .count(),
        4
    );
    each_figure_stands_once_and_has_numbers(&whole);
    // The job's own record names them, and they judge nothing.
    assert_eq!(reproduction.beside.len(), 3);

    let alone = page(&Beside::default());
    assert!(!alone.html.contains("<h2 id=\"cost\""));
    assert!(alone.html.contains("are not on this page"));
    each_figure_stands_once_and_has_numbers(&alone);
}
