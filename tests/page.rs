//! The pages of the main job: the evidence on the first one, studies on pages of their own, and figures as files.

use crossgrain::engine::yade;
use crossgrain::report::{Page, page_against};
use crossgrain::reproduce::{Options, record::Beside, reproduce};

use crate::support::*;

/// Headings of the first page, in the order of the argument.
const PARTS: [&str; 9] = [
    "<div class=\"verdict",
    ">Do the engines agree?</h2>",
    ">Do the published figures come out?</h2>",
    ">Comparisons</h2>",
    ">Would it notice?</h2>",
    ">Skipped</h2>",
    ">More</h2>",
    ">What the paper leaves open, and what was chosen</h2>",
    ">Runs, versions and commands</h2>",
];
/// What the first page has at most, folded parts left out.
const MOST_WORDS: usize = 1500;
const MOST_TABLES: usize = 10;

/// What is left without everything from one of these to its end.
fn without(text: &str, parts: &[[&str; 2]]) -> String {
    let mut text = text.to_owned();
    for [from, to] in parts {
        while let Some(start) = text.find(from) {
            let end = text[start..].find(to).expect("its end") + start + to.len();
            text.replace_range(start..end, " ");
        }
    }
    text
}

#[test]
fn the_first_page_is_short_and_every_study_has_its_own() {
    let folder = &new_folder();
    let options = Options {
        out: folder.to_path_buf(),
        scene: small_scene(),
        full: false,
        suite: false,
        recorded: false,
        yade: yade::Options {
            program: Some("/nowhere/yade".into()),
            ..yade::Options::default()
        },
        fault: None,
        beside: Beside::read(&[], true).expect("the recorded records"),
        command: "a test".to_owned(),
    };
    let (reproduction, runs) = reproduce(&options, &Display::new(true)).expect("a job");
    let pages = |beside: &Beside| -> Vec<Page> {
        let documents = reproduction.documents(&runs, beside, None);
        let documents = documents.expect("documents");
        documents
            .iter()
            .map(|(name, document)| page_against(name, document, None))
            .collect()
    };
    let all = pages(&options.beside);
    let names: Vec<&str> = all.iter().map(|page| page.name.as_str()).collect();
    let studies = ["claims", "candidates", "search", "stability", "tradeoff"];
    assert_eq!(names[..3], ["report", "measures", "paper"]);
    assert_eq!(names[3..], studies);
    let first = all[0].html.replace("&#39;", "'");
    let places: Vec<Option<usize>> = PARTS.iter().map(|part| first.find(part)).collect();
    assert!(places.iter().all(Option::is_some), "{places:?}");
    assert!(places.is_sorted(), "{places:?}");
    for words in [
        "Stochastic modeling of stress fields",
        concat!("crossgrain ", env!("CARGO_PKG_VERSION"), ", 2"),
    ] {
        has(&first[..places[3].expect("a place")], [words]);
    }
    assert_eq!(options.beside.answer.len(), 3);
    for sentence in &options.beside.answer {
        has(&first, [sentence]);
    }
    // As many rows as the verdict counts.
    let (part, end) = (places[5].expect("a place"), places[6].expect("a place"));
    let rows = first[part..end].matches("<tr><td").count();
    assert!(rows > 2, "{rows}");
    has(&first, [&format!("0 failed, {rows} skipped")]);
    // What is read without unfolding anything: no tags, pictures or styles.
    let folded = [
        ["<details", "</details>"],
        ["<svg", "</svg>"],
        ["<script", "</script>"],
    ];
    let open = without(first.split("<body>").nth(1).expect("a body"), &folded);
    let words = without(&open, &[["<", ">"]]).split_whitespace().count();
    assert!(words <= MOST_WORDS, "{words} words");
    assert!(open.matches("<table").count() <= MOST_TABLES);
    // The paper's numbers are tables alone.
    for page in all.iter().filter(|page| page.name != "paper") {
        each_figure_stands_once_and_has_numbers(page);
    }
    for page in &all[1..] {
        let link = format!("href=\"{}.html\"", page.name);
        assert_eq!(first.matches(&link).count(), 1, "{}", page.name);
        assert!(page.html.contains("href=\"report.html\""), "{}", page.name);
    }
    for page in &all[3..] {
        has(&page.html, ["Recorded, and not run again here"]);
    }
    // Distributions beside the theory's exponential.
    has(&all[3].html.replace("&#39;", "'"), ["theory's exponential"]);
    // The job's own record names them, and they judge nothing.
    assert_eq!(reproduction.beside.len(), 5);
    assert_eq!(pages(&Beside::default()).len(), 3);
}
