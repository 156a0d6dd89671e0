//! Figure 3's content with Table 1: the ways in which five piles share five units of force, and what one pile bears.

use std::fmt::Write;

use crate::error::Error;
use crate::paper::piles::{Counted, chance_of_at_least_of_five, table_1};
use crate::report::axis::{Area, Axis};
use crate::report::figure::Figure;
use crate::report::figure_files::table;
use crate::report::frame::{BARS, BLUE, GREEN, INK, VERMILION, border, line, text, whole};

const SIZE: [f64; 2] = [980.0, 400.0];
const CHART: Area = [620.0, 70.0, 330.0, 262.0];
const ROW: f64 = 34.0;
const FIRST: f64 = 112.0;
/// Left edges of names, of the first force level, and of the bars.
const COLUMNS: [f64; 3] = [20.0, 236.0, 390.0];
/// Length of the bar of all 30 cases.
const BAR: f64 = 110.0;

/// Table 1 counted, and the share of piles that bear at least a force, for five piles and for many.
pub fn figure() -> Result<Figure, Error> {
    let subclasses = table_1();
    let all: u32 = subclasses.iter().map(|subclass| subclass.cases).sum();
    let mut svg = the_table(&subclasses, all);
    let mut rows: Vec<[String; 10]> = Vec::new();
    for subclass in &subclasses {
        let [a, b, c, d, e, f] = subclass.piles.map(|piles| piles.to_string());
        let chance = f64::from(subclass.cases) / f64::from(all);
        rows.push([
            "subclass".to_owned(),
            example(subclass),
            a,
            b,
            c,
            d,
            e,
            f,
            subclass.cases.to_string(),
            format!("{chance}"),
        ]);
    }
    let x = Axis::across(CHART, 0.0, 5.0);
    let y = Axis::upwards(CHART, 0.0, 1.0);
    let mut add = |kind: &str, [force, chance]: [f64; 2]| {
        let mut row: [String; 10] = Default::default();
        row[0] = kind.to_owned();
        row[1] = format!("at least {force} FU");
        row[9] = format!("{chance}");
        rows.push(row);
    };
    let exponential: Vec<[f64; 2]> = (0..=100)
        .map(|index| 0.05 * f64::from(index))
        .map(|force| [force, (-force).exp()])
        .collect();
    for force in 0..6u32 {
        let at = f64::from(force);
        let (five, many) = (chance_of_at_least_of_five(force), 0.5f64.powi(force as i32));
        let (bar, top) = (x.place(at), y.place(five));
        let left = (bar - 9.0).max(CHART[0]);
        let right = (bar + 9.0).min(CHART[0] + CHART[2]);
        let _ = write!(
            svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{BARS}\" stroke=\"{BLUE}\"/>\
             <circle cx=\"{bar:.1}\" cy=\"{:.1}\" r=\"5\" fill=\"none\" stroke=\"{GREEN}\" stroke-width=\"2.2\"/>",
            right - left,
            y.place(0.0) - top,
            y.place(many)
        );
        add("five piles", [at, five]);
        add("many piles, whole units", [at, many]);
    }
    let _ = write!(
        svg,
        "<path fill=\"none\" stroke=\"{VERMILION}\" stroke-width=\"2.2\" d=\"{}\"/>",
        line(
            exponential
                .iter()
                .map(|[force, chance]| [x.place(*force), y.place(*chance)])
        )
    );
    for point in &exponential {
        add("many piles, fine steps", *point);
    }
    svg += &border(
        CHART,
        &x,
        &y,
        [
            "force F, FU (the mean is 1)",
            "share of piles with F or more",
        ],
    );
    svg += &key();
    Ok(Figure {
        name: "figure-3".to_owned(),
        caption: "How five piles share five units of force, and what one pile bears".to_owned(),
        svg: whole(
            SIZE,
            "Sharings of five units of force among five piles",
            &svg,
        ),
        csv: table(
            &[
                "kind",
                "what",
                "piles with 0 FU",
                "piles with 1 FU",
                "piles with 2 FU",
                "piles with 3 FU",
                "piles with 4 FU",
                "piles with 5 FU",
                "cases",
                "chance (1)",
            ],
            rows,
        )?,
    })
}

fn the_table(subclasses: &[Counted], all: u32) -> String {
    let [names, levels, bars] = COLUMNS;
    let mut svg = text(
        [names, 30.0],
        "start",
        "Five piles share 5 FU: Table 1, counted",
    );
    svg += &text([levels - 8.0, FIRST - 44.0], "start", "piles that bear");
    svg += &text([bars, FIRST - 26.0], "start", &format!("cases of {all}"));
    for force in 0..6 {
        let at = levels + 22.0 * f64::from(force);
        svg += &text([at, FIRST - 26.0], "middle", &force.to_string());
    }
    svg += &text([levels + 122.0, FIRST - 44.0], "start", "FU");
    for (index, subclass) in subclasses.iter().enumerate() {
        let y = FIRST + ROW * index as f64;
        svg += &text([names, y], "start", &example(subclass));
        let name = if subclass.name.ends_with("row") {
            ""
        } else {
            subclass.name
        };
        svg += &text([names + 92.0, y], "start", name);
        for (force, piles) in subclass.piles.iter().enumerate() {
            let at = levels + 22.0 * force as f64;
            let _ = write!(
                svg,
                "<g opacity=\"{}\">",
                if *piles == 0 { ".35" } else { "1" }
            );
            svg += &text([at, y], "middle", &piles.to_string());
            svg += "</g>";
        }
        let length = BAR * f64::from(subclass.cases) / 30.0;
        let _ = write!(
            svg,
            "<rect x=\"{bars}\" y=\"{:.1}\" width=\"{length:.1}\" height=\"16\" fill=\"{BLUE}\"/>",
            y - 13.0
        );
        svg += &text(
            [bars + length + 7.0, y],
            "start",
            &subclass.cases.to_string(),
        );
        let _ = write!(
            svg,
            "<path stroke=\"{INK}\" opacity=\".15\" d=\"M{names} {:.1}H540\"/>",
            y + 11.0
        );
    }
    svg
}

/// One case of a subclass, the largest loads first.
fn example(subclass: &Counted) -> String {
    let loads: Vec<String> = (0..6)
        .rev()
        .flat_map(|force| vec![force.to_string(); subclass.piles[force] as usize])
        .collect();
    format!("({})", loads.join(" "))
}

fn key() -> String {
    let [left, top, width, _] = CHART;
    let at = left + width - 196.0;
    let entries = [
        (
            format!(
                "<rect y=\"-11\" width=\"18\" height=\"12\" fill=\"{BARS}\" stroke=\"{BLUE}\"/>"
            ),
            "five piles, counted",
        ),
        (
            format!(
                "<circle cx=\"9\" cy=\"-4.5\" r=\"5\" fill=\"none\" stroke=\"{GREEN}\" stroke-width=\"2.2\"/>"
            ),
            "many, whole units",
        ),
        (
            format!("<path stroke=\"{VERMILION}\" stroke-width=\"2.2\" d=\"M0 -4.5h18\"/>"),
            "many, fine steps: exp",
        ),
    ];
    let mut svg = String::new();
    for (index, (symbol, words)) in entries.iter().enumerate() {
        let y = top + 26.0 + 22.0 * index as f64;
        let _ = write!(
            svg,
            "<g transform=\"translate({at:.1} {y:.1})\">{symbol}</g>"
        );
        svg += &text([at + 28.0, y], "start", words);
    }
    svg
}
