//! The figures: every panel has marks, and the rows are the library's numbers.

use crossgrain::paper::continuum::{Field, Model};
use crossgrain::paper::disc_field::figure_4;
use crossgrain::study::campaign::merged;
use crossgrain::study::figures::{distributions, setup_of};

use crate::support::*;

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

/// How many places of a drawing's marks are in a part of it, given in shares of its width and height.
fn places(svg: &str, [left, top, right, bottom]: [f64; 4]) -> usize {
    let numbers = |text: &str| -> Vec<f64> {
        let words =
            text.split(|letter: char| !(letter.is_ascii_digit() || letter == '.' || letter == '-'));
        words.filter_map(|word| word.parse().ok()).collect()
    };
    let (_, frame) = svg.split_once("viewBox=\"").expect("a frame");
    let frame = numbers(frame.split('"').next().expect("numbers"));
    let across = [left, right].map(|share| frame[0] + share * frame[2]);
    let upwards = [top, bottom].map(|share| frame[1] + share * frame[3]);
    // Absolute places of paths and of circles; what is relative to them follows a letter.
    let paths = svg.split(" d=\"").skip(1);
    let paths = paths.flat_map(|path| path.split('"').next());
    let of_paths = paths.flat_map(|path| {
        let words = path.split(['M', 'L', ' ', 'Z']);
        let numbers: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
        let pairs = numbers.chunks_exact(2).map(|two| [two[0], two[1]]);
        pairs.collect::<Vec<_>>()
    });
    let first = |begins: &'static str, ends: &'static str| {
        svg.split(begins).skip(1).map(move |rest| {
            let place = numbers(rest.split(ends).next().expect("a place"));
            [place[0], place[1]]
        })
    };
    let all = of_paths.chain(first("<circle ", "r="));
    let all = all.chain(first("<rect x=\"", "width"));
    let inside = all.filter(|[x, y]| {
        (across[0]..across[1]).contains(x) && (upwards[0]..upwards[1]).contains(y)
    });
    let different: BTreeSet<[u64; 2]> = inside.map(|place| place.map(f64::to_bits)).collect();
    different.len()
}

/// A picture has so many of each piece of text, at least.
fn has_marks(drawn: &Path, name: &str, marks: &str) {
    let svg = text_of(drawn.join(format!("figure-{name}.svg")));
    assert!(!svg.contains("NaN") && svg.contains("<text"), "{name}");
    for wanted in marks.split(", ") {
        let (least, mark) = wanted.split_once(' ').expect("how many of what");
        let found = svg.matches(mark).count();
        let least: usize = least.parse().expect("a number");
        assert!(found >= least, "{name}: {found} of {mark}");
    }
}

#[test]
fn every_figure_has_its_panels_and_the_librarys_numbers() {
    let at = &new_folder();
    let mut scene = small_scene();
    // So light that every member gets the force.
    scene.loading.pressure *= 0.1;
    write_scene(&scene, &at.join("scene.json"));
    let plan = "study plan campaign scene.json --members 12 --out dozen";
    ends(at, 0, plan);
    ends(at, 0, "study run dozen");
    let (out, _) = ends(at, 0, "study figures --campaign dozen --out drawn");
    has(&out, ["figure-5"]);
    let drawn = at.join("drawn/figures");
    let page = text_of(at.join("drawn/report.html"));
    // Four figures with a second plot for the fourth, and two for each point of the fifth.
    assert_eq!(page.matches("<figure").count(), 11);
    assert!(page.contains("table-1.csv"));
    // Parts of each picture that must not be empty.
    let halves = [[0.0, 0.0, 0.5, 1.0], [0.5, 0.0, 1.0, 1.0]];
    let levels = [[0.0, 0.0, 1.0, 0.5], [0.0, 0.5, 1.0, 1.0]];
    // Figure 2 draws one bed twice, see below.
    for (figure, parts) in [(1, halves), (3, halves), (4, levels)] {
        let svg = text_of(drawn.join(format!("figure-{figure}.svg")));
        for part in parts {
            let count = places(&svg, part);
            assert!(count > 20, "figure {figure}, {part:?}: {count} places");
        }
    }
    // Both looks at the bed have grains in what they show.
    let svg = text_of(drawn.join("figure-2.svg"));
    for window in svg.split("<svg x=").skip(1) {
        let (_, view) = window.split_once("viewBox=\"").expect("a part of the bed");
        let (_, bed) = svg.split_once("<g id=\"bed\">").expect("a bed");
        let bed = format!("viewBox=\"{view}{bed}");
        let count = places(&bed, [0.0, 0.0, 1.0, 1.0]);
        assert!(count > 100, "figure 2: {count} places in {}", &view[..40]);
    }
    // Nine lines and three points; the bed twice with its points; bars, circles and a line; forces and profiles.
    let has = |name: &str, marks: &str| has_marks(&drawn, name, marks);
    has("1", "8 stroke-width=\"1\" d=\"M, 3 <circle");
    has("2", "2 <use, 306 <circle");
    has("3", "6 <circle, 6 <rect, 1 <path");
    has("4", "10 <path fill=\"#, 1 stroke-dasharray");
    has("4-profiles", "1 0.6366, 1 0.7189, 5 <path");
    for point in ["o", "a", "b"] {
        let bars = "5 <rect, 3 <path, 1 exponential of the same mean";
        has(&format!("5-{point}"), bars);
        has(&format!("5-{point}-share"), "5 <circle, 3 <path");
    }

    let setup = setup_of(&scene);
    let field = Field::new(Model::HalfSpace, setup.load);
    let bulbs = rows(&drawn, "figure-1.csv");
    for row in &bulbs {
        let (x, z) = (number(row, "x (m)"), number(row, "depth (m)"));
        let value = number(row, "stress of the load over p");
        let ours = field.stress(x, z.max(1e-9)).zz / setup.load.pressure;
        // Lines are straight between nodes; where one is closed outside the frame or along the surface it is none.
        let inside = x.abs() < 0.3 && (0.01..0.46).contains(&z);
        if row["what"].starts_with("point") {
            assert!((ours - value).abs() < 1e-9, "{row:?}");
        } else if inside {
            assert!((ours - value).abs() < 0.01, "{row:?}: {ours}");
        }
    }
    let levels = bulbs.iter().map(|row| &row["stress of the load over p"]);
    let levels: BTreeSet<&String> = levels.collect();
    assert_eq!(levels.len(), 8 + 3);

    let table = rows(&drawn, "table-1.csv");
    let cases: Vec<f64> = table.iter().map(|row| number(row, "cases")).collect();
    assert_eq!(cases, [5.0, 20.0, 20.0, 30.0, 30.0, 20.0, 1.0]);
    let shares = rows(&drawn, "figure-3.csv");
    let five = shares
        .iter()
        .filter(|row| row["series"] == "five piles, counted");
    let share = |row| 126.0 * number(row, "share of piles with F or more");
    let five: Vec<f64> = five.map(share).collect();
    assert_eq!(five.len(), 6);
    for (found, counted) in five.iter().zip([126.0, 70.0, 35.0, 15.0, 5.0, 1.0]) {
        assert!((found - counted).abs() < 1e-9, "{five:?}");
    }

    let field = figure_4();
    let rows_of_4 = rows(&drawn, "figure-4.csv");
    for row in rows_of_4
        .iter()
        .filter(|row| row["kind"] == "map")
        .step_by(50)
    {
        let place = [number(row, "x (m)"), number(row, "z (m)")];
        // Not beside a force, where the sixth digit of a place matters.
        if place[0].hypot(place[1]) < 0.8 * field.radius() {
            let ours = -field.stress(place)[(1, 1)];
            assert!((number(row, "stress zz (Pa)") - ours).abs() < 1e-3 * ours.abs() + 1e-3);
        }
    }

    let campaign = merged(&at.join("dozen")).expect("a merged campaign");
    let all = distributions(&campaign).expect("values");
    assert_eq!(all.len(), 3);
    for distribution in &all {
        assert_eq!(distribution.values.len() + distribution.zeros, 12);
        let bearing = distribution.values.len();
        let drawn = rows(
            &drawn,
            &format!("figure-5-{}.csv", distribution.point.to_lowercase()),
        );
        let series = |name: &'static str| drawn.iter().filter(move |row| row["series"] == name);
        let mut counted = 0;
        for row in series("realizations, 95 %") {
            let (from, to) = (number(row, "Σ_zz (J)"), number(row, "to"));
            let inside = |value: &&f64| (from..to).contains(*value);
            let inside = distribution.values.iter().filter(inside).count();
            let found = number(row, "probability density (1/J)") * (to - from) * bearing as f64;
            assert!((found - inside as f64).abs() < 1e-6, "{row:?}");
            counted += inside;
        }
        assert!(counted + 1 >= bearing, "{counted}");
        let mean = distribution.theory.expect("a theory");
        let mut points = 0;
        for row in series("theory's exponential") {
            let wanted = (-number(row, "Σ_zz (J)") / mean).exp() / mean;
            assert!((number(row, "probability density (1/J)") / wanted - 1.0).abs() < 1e-9);
            points += 1;
        }
        assert_eq!(points, 101);
    }
    let forces = rows(&drawn, "figure-2.csv");
    let grains = forces.iter().filter(|row| row["kind"] == "grain");
    assert_eq!(grains.count(), 300);
    assert!(forces.iter().filter(|row| row["kind"] == "force").count() > 300);
}

#[test]
fn a_campaign_without_values_is_an_error_and_writes_nothing() {
    let at = &new_folder();
    let mut scene = small_scene();
    // No punch of this bed bears so much.
    scene.loading.pressure *= 1e4;
    write_scene(&scene, &at.join("scene.json"));
    let command = "study plan campaign scene.json --members 2 --out two";
    ends(at, 0, command);
    ends(at, 0, "study run two");
    let (_, errors) = ends(at, 2, "study figures --campaign two --out drawn");
    has(&errors, ["no member"]);
    assert!(!at.join("drawn").exists());
    ends(at, 2, "study figures --campaign nowhere");
}
