//! What every page must have.

use crossgrain::report::Page;

use super::*;

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
