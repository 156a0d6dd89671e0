//! The benchmark as a page.

use serde::Serialize;

use super::chart::{BLUE, Chart, GREEN, VERMILION};
use super::figure::{Figure, Page, line};
use super::shell;
use crate::checks::Outcome;
use crate::document::Colour;
use crate::error::Error;
use crate::limits::bench::Bench;
use crate::limits::bench::scaling::Point;

mod strip;

use strip::Strips;

const PAGE: &str = include_str!("bench.html");

/// See [`BLUE`].
const PURPLE: Colour = Colour::Purple;
/// See [`BLUE`].
const GREY: Colour = Colour::Grey;

/// What the template is given.
#[derive(Debug, Serialize)]
struct Given<'a> {
    b: &'a Bench,
    word: &'static str,
    strips: Option<Strips>,
    figures: Vec<Figure>,
    sizes: Vec<u32>,
    rows: Vec<SizeRow<'a>>,
}

/// A way of computing, over all sizes.
#[derive(Debug, Serialize)]
struct SizeRow<'a> {
    name: &'a str,
    cells: Vec<Option<&'a Point>>,
}

/// The page.
pub fn page(bench: &Bench) -> Result<Page, Error> {
    let names = names(&bench.scaling);
    let mut sizes: Vec<u32> = bench.scaling.iter().map(|point| point.grains).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let cell = |name: &str, size: u32| {
        let mut of = bench.scaling.iter();
        of.find(|point| point.name == name && point.grains == size)
    };
    let rows = names.iter().map(|name| SizeRow {
        name,
        cells: sizes.iter().map(|size| cell(name, *size)).collect(),
    });
    let given = Given {
        b: bench,
        word: match bench.verdict {
            Outcome::Pass => "Every engine ran, every bed is sane",
            Outcome::Fail => "A bed is not what it should be",
            Outcome::Skipped | Outcome::ExpectedFailure => "Incomplete",
        },
        strips: Strips::of(bench),
        figures: figures(bench, &names)?,
        rows: rows.collect(),
        sizes,
    };
    Ok(Page {
        html: shell::render(&[("bench.html", PAGE)], &given)?,
        figures: given.figures,
    })
}

fn names(points: &[Point]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.name.as_str()) {
            names.push(&point.name);
        }
    }
    names
}

fn figures(bench: &Bench, names: &[&str]) -> Result<Vec<Figure>, Error> {
    let colours = [BLUE, GREEN, PURPLE, GREY, VERMILION];
    let chart = |y: &str, of: fn(&Point) -> Option<f64>| Chart {
        x: "grains".to_owned(),
        y: y.to_owned(),
        logarithmic: [true, true],
        series: names
            .iter()
            .zip(colours)
            .map(|(name, colour)| {
                let points = bench
                    .scaling
                    .iter()
                    .filter(|point| point.name == **name)
                    .filter_map(|point| Some((f64::from(point.grains), of(point)?)));
                line(name, colour, points.collect())
            })
            .collect(),
    };
    let charts = [
        (
            "time-and-size",
            chart("ns a step and grain", |point| {
                Some(1e9 * point.seconds_per_grain)
            }),
            "Cost of a grain in a step. Flat is what a method that only looks at neighbours can do; what rises is memory: \
             the bed no longer fits into the caches.",
        ),
        (
            "memory-and-size",
            chart("peak memory, MB", |point| {
                Some(point.peak_memory? as f64 / 1e6)
            }),
            "Largest resident memory of the whole process, reading the bed included.",
        ),
    ];
    let mut figures = Vec::new();
    for (name, chart, caption) in charts {
        figures.extend(Figure::of_chart(name, caption, &chart)?);
    }
    Ok(figures)
}
