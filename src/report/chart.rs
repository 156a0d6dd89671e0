//! Line charts of pages that are no documents yet.

use super::figure_files::table;
use crate::document::{Axis, Colour, Mark as PlotMark, Plot, Point};
use crate::error::Error;

pub const BLUE: Colour = Colour::Blue;
pub const VERMILION: Colour = Colour::Vermilion;
pub const GREEN: Colour = Colour::Green;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line through the points.
    Line,
    /// A circle a point.
    Circles,
}

/// Points with a name.
#[derive(Debug, Clone)]
pub struct Series {
    pub name: String,
    pub colour: Colour,
    pub mark: Mark,
    pub points: Vec<(f64, f64)>,
}

/// A chart of one quantity over another.
#[derive(Debug, Clone)]
pub struct Chart {
    pub x: String,
    pub y: String,
    pub logarithmic: [bool; 2],
    pub series: Vec<Series>,
}

impl Chart {
    /// As a plot.
    pub fn plot(&self, name: &str, caption: &str) -> Plot {
        let axis = |label: &str, logarithmic| Axis {
            logarithmic,
            ..Axis::linear(label)
        };
        let mut plot = Plot::new(
            name,
            caption,
            axis(&self.x, self.logarithmic[0]),
            axis(&self.y, self.logarithmic[1]),
        );
        for series in &self.series {
            let points = series.points.iter();
            plot = match series.mark {
                Mark::Line => plot.line(&series.name, series.colour, points.map(|(x, y)| [*x, *y])),
                Mark::Circles => plot.with(PlotMark::Points {
                    name: series.name.clone(),
                    colour: series.colour,
                    hollow: true,
                    points: points.map(|(x, y)| Point::at(*x, *y)).collect(),
                }),
            };
        }
        plot
    }

    /// Whether there is more than one point to show.
    pub fn can_be_drawn(&self) -> bool {
        self.series
            .iter()
            .map(|series| series.points.len())
            .sum::<usize>()
            > 1
    }

    /// The points as rows: series, x, y.
    pub fn csv(&self) -> Result<String, Error> {
        let rows = self.series.iter().flat_map(|series| {
            let of = |point: &(f64, f64)| {
                [
                    series.name.clone(),
                    point.0.to_string(),
                    point.1.to_string(),
                ]
            };
            series.points.iter().map(of)
        });
        table(&["series", &self.x, &self.y], rows)
    }
}
