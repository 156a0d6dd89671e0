//! What every page must have.

use crossgrain::engine::yade;
use crossgrain::report::Page;
use crossgrain::reproduce::{Options, record::Beside};

use super::*;

/// The main job of the small scene where there is no YADE.
pub fn job_without_yade(out: &Path, beside: Beside) -> Options {
    Options {
        out: out.to_owned(),
        scene: small_scene(),
        full: false,
        suite: false,
        recorded: false,

        yade: yade::Options {
            program: Some("/nowhere/yade".into()),
            ..yade::Options::default()
        },
        fault: None,
        beside,
        command: "a test".to_owned(),
    }
}

/// Every file has a name of its own and one link on the page; every figure stands once, and is written as SVG and CSV with
/// numbers.
pub fn each_figure_stands_once_and_has_numbers(page: &Page) {
    let names: BTreeSet<&str> = page.files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names.len(), page.files.len(), "{names:?}");
    // No link without files.
    let links = page.html.matches("href=\"figures/").count();
    assert_eq!(links, names.len());
    let folder = &new_folder();
    page.write(folder).expect("can be written");
    let mut figures = 0;
    for (name, text) in &page.files {
        let link = format!("href=\"figures/{name}\"");
        assert_eq!(page.html.matches(&link).count(), 1, "{link}");
        let written = text_of(folder.join("figures").join(name));
        assert_eq!(written, *text, "{name}");
        let Some(figure) = name.strip_suffix(".svg") else {
            continue;
        };
        figures += 1;
        assert!(page.html.contains(text.trim()), "{name}");
        let mut files = page.files.iter();
        let csv = files.find(|of| of.0 == format!("{figure}.csv"));
        let (_, csv) = csv.expect("numbers");
        let mut rows = csv::Reader::from_reader(csv.as_bytes());
        let mut count = 0;
        for row in rows.records() {
            let row = row.expect("as many cells as the head");
            let number = |cell: &str| cell.parse::<f64>().is_ok_and(f64::is_finite);
            assert!(row.iter().any(number), "{name}: {row:?}");
            count += 1;
        }
        assert!(count > 0, "{name}");
    }
    assert!(figures > 0 && figures == page.html.matches("<figure").count());
}
