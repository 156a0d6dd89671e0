//! Names inside files – of scenes, control points, checks – that a browser, a table or a terminal would obey: in pages,
//! tables, XML and job summaries they stay text.

use crate::campaign::plan;
use crate::hostile_names::harmless;
use crate::support::*;

const MARKUP: &str =
    "<script>alert(1)</script>\"'&amp;{{ 7*7 }}{% x %}]]>--><img src=x onerror=alert(1)>";
const CELLS: &str = "a,b;\"c\"|d\t".trim_ascii_end();

/// A scene whose names are markup.
fn scene_of_markup() -> Scene {
    let mut scene = tiny_scene();
    scene.name = MARKUP.to_owned();
    scene.control_points[0].name = MARKUP.to_owned();
    scene.control_points[1].name = CELLS.to_owned();
    for reason in scene.choices.values_mut() {
        *reason = MARKUP.to_owned();
    }
    scene
}

/// No tag of ours is in the text.
fn no_markup(name: &str, text: &str) {
    for tag in ["<script>alert", "<img", "-->", "]]>"] {
        assert!(!text.contains(tag), "{name} has {tag:?}");
    }
}

/// Rows of a table, the first that of its names.
fn table(path: &Path) -> Vec<csv::StringRecord> {
    let mut table = csv::ReaderBuilder::new();
    let mut table = table.has_headers(false).from_path(path).expect("a table");
    let rows = table.records();
    rows.map(|row| row.expect("as many cells as columns"))
        .collect()
}

#[test]
fn pages_and_files_of_a_job_hold_names_as_text() {
    let folder = &folder_with(&scene_of_markup());
    let arguments = "reproduce --scene scene.json --recorded --out o --quiet";
    let (code, _, errors) = harmless(folder, &crossgrain(arguments, folder));
    assert_eq!(code, 3, "without YADE it is incomplete: {errors}");
    let read = |name: &str| text_of(folder.join(name));
    let page = read("o/report.html");
    let [begin, end] =
        ["</style>", "<script nonce"].map(|mark| page.rfind(mark).expect("is there"));
    let body = &page[begin..end];
    no_markup("report.html", body);
    has(body, ["&lt;script&gt;alert(1)"]);
    let files = "report checks o/run.json --junit j.xml --csv c.csv --summary s.md";
    harmless(folder, &crossgrain(files, folder));
    let junit = read("j.xml");
    no_markup("JUnit", &junit);
    let report = roxmltree::Document::parse(&junit).expect("XML");
    let cases = report.descendants();
    let cases = cases.filter(|node| node.has_tag_name("testcase"));
    assert_eq!(table(&folder.join("c.csv"))[1..].len(), cases.count());
    no_markup("the summary", &read("s.md"));
}

/// A column for each control point, whatever its name.
#[test]
fn the_table_of_a_campaign_has_as_many_cells_as_columns() {
    let folder = &plan(&scene_of_markup(), 3, "c");
    let (code, _, errors) = harmless(folder, &crossgrain("study run c", folder));
    assert_eq!(code, 0, "{errors}");
    let rows = table(&folder.join("c/rows.csv"));
    let named = rows[0].iter().any(|name| name.contains(CELLS));
    assert!(named, "{:?}", rows[0]);
    assert_eq!(rows[1..].len(), 3);
}

#[test]
fn names_with_control_characters_are_refused_and_shown_harmless() {
    let long = "long".repeat(51);
    for name in ["two\nlines", "\u{1b}[2J", "a\rb", "nul\0", &long] {
        let mut scene = tiny_scene();
        scene.name = name.to_owned();
        scene.control_points[0].name = name.to_owned();
        let folder = &folder_with(&scene);
        let check = crossgrain("scene check scene.json", folder);
        let (code, _, errors) = harmless(folder, &check);
        assert_eq!(code, 2, "{name:?}");
        has(&errors, ["/name: found", "/control_points/0/name: found"]);
    }
}

/// What an engine says of itself, and a record that somebody made, reach the terminal as text.
#[test]
fn words_of_other_programs_are_shown_harmless() {
    let folder = &folder_with(&tiny_scene());
    let record = r#"{"job": "verify", "version": 1, "crossgrain": "0.1.0", "command": "c", "verdict": "fail", "checks": [
        {"id": "a/b", "quantity": "\u001b[31mred\u0007 <img>", "unit": "m", "value": 2.0, "expected": 1.0, "lower": 0.5,
        "upper": 1.5, "method": "", "basis": "", "n": 1, "interval": null, "outcome": "fail", "found": ""}]}"#;
    fs::write(folder.join("run.json"), record).expect("writable");
    let checks = crossgrain("report checks run.json", folder);
    let (_, out, errors) = harmless(folder, &checks);
    assert!(out.contains("\\u{1b}[31mred"), "{out}{errors}");
}
