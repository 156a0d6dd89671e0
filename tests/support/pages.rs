//! What every page must have.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crossgrain::engine::yade;
use crossgrain::report::figure::Page;
use crossgrain::reproduce::Options;
use crossgrain::reproduce::beside::Beside;

use super::small_scene;

/// The main job of the small scene where there is no YADE.
pub fn job_without_yade(out: &Path, beside: Beside) -> Options {
    Options {
        out: out.to_owned(),
        scene: small_scene(),
        full: false,
        ladder: false,
        yade: yade::Options {
            program: Some("/nowhere/yade".into()),
            ..yade::Options::default()
        },
        fault: None,
        beside,
        command: "a test".to_owned(),
    }
}

/// Every figure has a name of its own, stands on the page with links to its files, and is written as SVG and CSV
/// with numbers.
pub fn each_figure_stands_once_and_has_numbers(page: &Page) {
    assert!(!page.figures.is_empty());
    let names: BTreeSet<&str> = page.figures.iter().map(|of| of.name.as_str()).collect();
    assert_eq!(names.len(), page.figures.len(), "{names:?}");
    // No link without files.
    let links = page.html.matches("href=\"figures/").count();
    assert_eq!(links, 2 * names.len());
    let folder = tempfile::tempdir().expect("a temporary folder");
    page.write(folder.path()).expect("can be written");
    for figure in &page.figures {
        let name = &figure.name;
        assert!(page.html.contains(figure.svg.trim()), "{name}");
        for end in ["svg", "csv"] {
            let link = format!("href=\"figures/{name}.{end}\"");
            assert_eq!(page.html.matches(&link).count(), 1, "{link}");
            let written = folder.path().join(format!("figures/{name}.{end}"));
            assert!(
                fs::metadata(&written).expect("is there").len() > 20,
                "{name}.{end}"
            );
        }
        let mut rows = csv::Reader::from_reader(figure.csv.as_bytes());
        let mut count = 0;
        for row in rows.records() {
            let row = row.expect("as many cells as the head");
            let number = |cell: &str| cell.parse::<f64>().is_ok_and(f64::is_finite);
            assert!(row.iter().any(number), "{name}: {row:?}");
            count += 1;
        }
        assert!(count > 0, "{name}");
    }
}
