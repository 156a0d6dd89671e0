//! Two axes and what is drawn between them, cut off at the border.

use std::fmt::Write;

use super::axis::{Area, Axis};
use super::frame::{border, grid, line};

/// Pieces of a curve.
const PIECES: u32 = 200;

/// A plot in the making; marks lie in the order in which they are added.
#[derive(Debug)]
pub struct Plot {
    /// Between its borders.
    pub area: Area,
    /// From left to right.
    pub x: Axis,
    /// From bottom to top.
    pub y: Axis,
    marks: String,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke<'a> {
    /// As SVG writes it.
    pub colour: &'a str,
    /// Of the line.
    pub width: f64,
    /// Lengths of dashes and gaps; empty for a whole line.
    pub dashes: &'a str,
}

impl<'a> Stroke<'a> {
    /// A whole line of the usual width.
    pub fn whole(colour: &'a str) -> Self {
        Stroke {
            colour,
            width: 1.8,
            dashes: "",
        }
    }
}

impl Plot {
    /// Without marks.
    pub fn new(area: Area, x: Axis, y: Axis) -> Self {
        Plot {
            area,
            x,
            y,
            marks: String::new(),
        }
    }

    /// Without marks but thin lines at the ticks.
    pub fn with_grid(area: Area, x: Axis, y: Axis) -> Self {
        Plot {
            marks: grid(area, &x, &y),
            ..Plot::new(area, x, y)
        }
    }

    fn places(&self, points: impl IntoIterator<Item = [f64; 2]>) -> String {
        let points = points.into_iter();
        let finite = points.filter(|point| point.iter().all(|value| value.is_finite()));
        line(finite.map(|[x, y]| [self.x.place(x), self.y.place(y)]))
    }

    /// A line through points; those that are not finite are left out.
    pub fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, stroke: Stroke<'_>) {
        let Stroke {
            colour,
            width,
            dashes,
        } = stroke;
        let path = self.places(points);
        let _ = write!(
            self.marks,
            "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-dasharray=\"{dashes}\" d=\"{path}\"/>"
        );
    }

    /// A function over the horizontal axis.
    pub fn curve(&mut self, of: impl Fn(f64) -> f64, stroke: Stroke<'_>) {
        let x = self.x;
        let points = (0..=PIECES).map(|piece| {
            let at = x.value(f64::from(piece) / f64::from(PIECES));
            [at, of(at)]
        });
        self.line(points, stroke);
    }

    /// A vertical line from a value to another.
    pub fn upright(&mut self, x: f64, [low, high]: [f64; 2], colour: &str) {
        let _ = write!(
            self.marks,
            "<path stroke=\"{colour}\" stroke-width=\"1.4\" d=\"M{:.1} {:.1}V{:.1}\"/>",
            self.x.place(x),
            self.y.place(low),
            self.y.place(high)
        );
    }

    /// A dot of a radius; others shine through where `opacity` is below 1.
    pub fn dot(&mut self, [x, y]: [f64; 2], colour: &str, radius: f64, opacity: f64) {
        let _ = write!(
            self.marks,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>",
            self.x.place(x),
            self.y.place(y)
        );
    }

    /// The marks within their border, with the labels of the axes.
    pub fn svg(self, labels: [&str; 2]) -> String {
        let [left, top, width, height] = self.area;
        // Several plots of a page may have this name: then they have the same area.
        let name = format!("within-{left:.0}-{top:.0}-{width:.0}-{height:.0}");
        format!(
            "<clipPath id=\"{name}\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath>\
             <g clip-path=\"url(#{name})\">{}</g>\n{}",
            self.marks,
            border(self.area, &self.x, &self.y, labels)
        )
    }
}
