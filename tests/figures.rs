//! The figures: every panel has ink, and the rows are the library's numbers.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crossgrain::paper::continuum::{Field, Model};
use crossgrain::paper::disc_field::figure_4;
use crossgrain::study::campaign::merged;
use crossgrain::study::figures::{samples, setup_of};
use resvg::tiny_skia::Pixmap;

use crate::support::{crossgrain, small_scene, told, write_scene};

/// The rows of a figure by the names of its head.
fn rows(folder: &Path, name: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.join(name)).expect("a CSV");
    reader
        .deserialize()
        .map(|row| row.expect("a row"))
        .collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().expect("a number")
}

/// Different colours in a part of the picture, given in shares of its width and height.
fn colours(picture: &Pixmap, [left, top, right, bottom]: [f32; 4]) -> usize {
    let place = |share: f32, of: u32| (share * of as f32) as u32;
    let (width, height) = (picture.width(), picture.height());
    let mut seen = std::collections::BTreeSet::new();
    for y in place(top, height)..place(bottom, height) {
        for x in place(left, width)..place(right, width) {
            let pixel = picture.pixel(x, y).expect("inside");
            seen.insert([pixel.red(), pixel.green(), pixel.blue()]);
        }
    }
    seen.len()
}

#[test]
fn every_figure_has_its_panels_and_the_librarys_numbers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let mut scene = small_scene();
    // So light that every member gets the force.
    scene.loading.pressure *= 0.1;
    write_scene(&scene, &at.join("scene.json"));
    let run = |arguments: &[&str]| {
        let (code, out, errors) = told(&crossgrain(arguments, at));
        assert_eq!(code, 0, "{arguments:?}: {errors}");
        out
    };
    run(&[
        "campaign",
        "plan",
        "scene.json",
        "--members",
        "12",
        "--out",
        "dozen",
    ]);
    run(&["campaign", "run", "dozen"]);
    let out = run(&["figures", "--campaign", "dozen", "--out", "drawn"]);
    assert!(out.contains("figure-5"), "{out}");
    let drawn = at.join("drawn");
    assert_eq!(fs::read_dir(&drawn).expect("is there").count(), 15);

    // Parts of each picture that must not be of one colour.
    let halves = [[0.0, 0.0, 0.5, 1.0], [0.5, 0.0, 1.0, 1.0]];
    let thirds = [0.0, 1.0, 2.0].map(|third| [third / 3.0, 0.0, (third + 1.0) / 3.0, 1.0]);
    let levels = [[0.0, 0.0, 1.0, 0.5], [0.0, 0.5, 1.0, 1.0]];
    let parts: [(u32, &[[f32; 4]]); 5] = [
        (1, &halves),
        (2, &levels),
        (3, &halves),
        (4, &levels),
        (5, &thirds),
    ];
    for (figure, parts) in parts {
        let picture = Pixmap::load_png(drawn.join(format!("figure-{figure}.png"))).expect("a PNG");
        for part in parts {
            let count = colours(&picture, *part);
            assert!(count > 40, "figure {figure}, {part:?}: {count} colours");
        }
        let svg = fs::read_to_string(drawn.join(format!("figure-{figure}.svg"))).expect("text");
        assert!(
            !svg.contains("NaN") && svg.contains("<text"),
            "figure {figure}"
        );
    }

    let setup = setup_of(&scene);
    let field = Field::new(Model::HalfSpace, setup.load);
    let bulbs = rows(&drawn, "figure-1.csv");
    for row in &bulbs {
        let (x, z) = (number(row, "x (m)"), number(row, "depth (m)"));
        let value = number(row, "stress of the load over p (1)");
        let ours = field.stress(x, z.max(1e-9)).zz / setup.load.pressure;
        // Lines are straight between nodes; where one is closed outside the frame or along the surface it is none.
        let inside = x.abs() < 0.3 && (0.01..0.46).contains(&z);
        if row["what"].starts_with("point") {
            assert!((ours - value).abs() < 1e-9, "{row:?}");
        } else if inside {
            assert!((ours - value).abs() < 0.01, "{row:?}: {ours}");
        }
    }
    let levels: std::collections::BTreeSet<&String> = bulbs
        .iter()
        .map(|row| &row["stress of the load over p (1)"])
        .collect();
    assert_eq!(levels.len(), 9 + 3);

    let table = rows(&drawn, "figure-3.csv");
    let of = |kind: &'static str| table.iter().filter(move |row| row["kind"] == kind);
    let cases: Vec<f64> = of("subclass").map(|row| number(row, "cases")).collect();
    assert_eq!(cases, [5.0, 20.0, 20.0, 30.0, 30.0, 20.0, 1.0]);
    let five: Vec<f64> = of("five piles")
        .map(|row| 126.0 * number(row, "chance (1)"))
        .collect();
    for (found, counted) in five.iter().zip([126.0, 70.0, 35.0, 15.0, 5.0, 1.0]) {
        assert!((found - counted).abs() < 1e-9, "{five:?}");
    }

    let field = figure_4().expect("balances");
    for row in rows(&drawn, "figure-4.csv")
        .iter()
        .filter(|row| row["kind"] == "map")
        .step_by(50)
    {
        let place = [number(row, "x (m)"), number(row, "z (m)")];
        // Not beside a force, where the sixth digit of a place matters.
        if place[0].hypot(place[1]) < 0.8 * field.radius() {
            let ours = -field.stress(place)[1][1];
            assert!((number(row, "stress zz (Pa)") - ours).abs() < 1e-3 * ours.abs() + 1e-3);
        }
    }

    let campaign = merged::read(&at.join("dozen")).expect("a merged campaign");
    let samples = samples(&campaign).expect("values");
    assert_eq!(samples.len(), 3);
    let drawn_shares = rows(&drawn, "figure-5.csv");
    for sample in &samples {
        assert_eq!(sample.values.len(), 12);
        let at_point = || {
            drawn_shares
                .iter()
                .filter(|row| row["panel"] == sample.point)
        };
        for row in at_point().filter(|row| row["series"] == "histogram density") {
            let (from, to) = (number(row, "from"), number(row, "to"));
            let inside = sample
                .values
                .iter()
                .filter(|value| (from..to).contains(*value))
                .count();
            let found = number(row, "value") * (to - from) * 12.0;
            assert!((found - inside as f64).abs() < 1e-6, "{row:?}");
        }
        for row in at_point().filter(|row| row["series"] == "exponential density") {
            let mean = sample.theory_mean;
            let wanted = (-number(row, "from") / mean).exp() / mean;
            assert!((number(row, "value") / wanted - 1.0).abs() < 1e-9);
        }
    }
    let forces = rows(&drawn, "figure-2.csv");
    assert_eq!(
        forces.iter().filter(|row| row["kind"] == "grain").count(),
        300
    );
    assert!(forces.iter().filter(|row| row["kind"] == "force").count() > 300);
}

#[test]
fn a_campaign_without_values_is_an_error_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let mut scene = small_scene();
    // No punch of this bed bears so much.
    scene.loading.pressure *= 1e4;
    write_scene(&scene, &at.join("scene.json"));
    for arguments in [
        vec![
            "campaign",
            "plan",
            "scene.json",
            "--members",
            "2",
            "--out",
            "two",
        ],
        vec!["campaign", "run", "two"],
    ] {
        assert_eq!(told(&crossgrain(&arguments, at)).0, 0);
    }
    let arguments = ["figures", "--campaign", "two", "--out", "drawn"];
    let (code, _, errors) = told(&crossgrain(&arguments, at));
    assert_eq!(code, 2);
    assert!(errors.contains("no member"), "{errors}");
    assert!(!at.join("drawn").exists());
    let (code, _, errors) = told(&crossgrain(&["figures", "--campaign", "nowhere"], at));
    assert_eq!(code, 2, "{errors}");
    let (code, _, _) = told(&crossgrain(&["figures", "--scale", "0"], at));
    assert_eq!(code, 2);
}
