//! Line charts as SVG.

use std::sync::Once;

use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use crate::error::Error;

/// Labels are laid out with this font; the page shows them in the reader's own.
pub(super) const FONT: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");

/// Colours that colour-blind readers can tell apart (Okabe and Ito).
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// See [`BLUE`].
pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
/// See [`BLUE`].
pub const GREEN: RGBColor = RGBColor(0, 158, 115);

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
    /// In the legend.
    pub name: String,
    /// Of line, circle and legend.
    pub colour: RGBColor,
    /// How it is drawn.
    pub mark: Mark,
    /// In the order of the line.
    pub points: Vec<(f64, f64)>,
}

/// A chart of one quantity over another.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// Powers of ten on the horizontal and the vertical axis; points at or below zero are left out there.
    pub logarithmic: [bool; 2],
    /// Where the curves leave room for the names of the series.
    pub legend: Corner,
    /// In the order of drawing.
    pub series: Vec<Series>,
}

/// A corner or side of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corner {
    /// Top left.
    UpperLeft,
    /// Top right.
    UpperRight,
    /// Bottom right.
    LowerRight,
    /// Left, half way up.
    MiddleLeft,
}

const SIZE: (u32, u32) = (640, 360);

impl Chart {
    /// The chart as an SVG element.
    pub fn svg(&self) -> Result<String, Error> {
        static REGISTERED: Once = Once::new();
        REGISTERED.call_once(|| {
            // Fails only for a broken font file, and then drawing says so.
            let _ = register_font("sans-serif", FontStyle::Normal, FONT);
        });
        let mut text = String::new();
        self.draw(&mut text)
            .map_err(|reason| Error::Report(format!("the chart of {}: {reason}", self.y)))?;
        // Scales with the page instead of having a fixed size.
        let (width, height) = SIZE;
        Ok(text.replacen(
            &format!("width=\"{width}\" height=\"{height}\""),
            "class=\"chart\"",
            1,
        ))
    }

    /// Whether there is more than one point to show.
    pub fn can_be_drawn(&self) -> bool {
        self.range(|p| p.0).is_some() && self.range(|p| p.1).is_some()
    }

    fn shows(&self, point: &(f64, f64)) -> bool {
        let shown =
            |value: f64, axis: usize| value.is_finite() && (!self.logarithmic[axis] || value > 0.0);
        shown(point.0, 0) && shown(point.1, 1)
    }

    /// From the least to the largest of a coordinate; none if they are the same.
    fn range(&self, of: fn(&(f64, f64)) -> f64) -> Option<std::ops::Range<f64>> {
        let all = self.series.iter().flat_map(|series| &series.points);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in all.filter(|point| self.shows(point)).map(of) {
            low = low.min(value);
            high = high.max(value);
        }
        (low < high).then_some(low..high)
    }

    fn draw(&self, text: &mut String) -> Result<(), String> {
        let wanted = |point: &(f64, f64)| self.shows(point);
        let (Some(xs), Some(ys)) = (self.range(|p| p.0), self.range(|p| p.1)) else {
            return Err("has no points to show".to_owned());
        };
        let failed = |error: DrawingAreaErrorKind<_>| format!("{error}");
        let area = SVGBackend::with_string(text, SIZE).into_drawing_area();
        let mut builder = ChartBuilder::on(&area);
        builder
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64);
        let power = |tick: &f64| format!("{tick:.0e}");
        let decimal = |tick: &f64| plain(*tick);
        let (low, high) = (ys.start, ys.end);
        let room = 0.05 * (high - low);
        let (open, decades) = ((low - room)..(high + room), (0.5 * low)..(2.0 * high));
        match self.logarithmic {
            [false, false] => {
                let mut chart = builder.build_cartesian_2d(xs, open).map_err(failed)?;
                self.mesh_and_series(&mut chart, wanted, decimal, decimal)
            }
            [false, true] => {
                let decades = decades.log_scale();
                let mut chart = builder.build_cartesian_2d(xs, decades).map_err(failed)?;
                self.mesh_and_series(&mut chart, wanted, decimal, power)
            }
            [true, false] => {
                let xs = wider(&xs).log_scale();
                let mut chart = builder.build_cartesian_2d(xs, open).map_err(failed)?;
                self.mesh_and_series(&mut chart, wanted, power, decimal)
            }
            [true, true] => {
                let (xs, decades) = (wider(&xs).log_scale(), decades.log_scale());
                let mut chart = builder.build_cartesian_2d(xs, decades).map_err(failed)?;
                self.mesh_and_series(&mut chart, wanted, power, power)
            }
        }?;
        area.present().map_err(failed)
    }

    fn mesh_and_series<'a, X, Y>(
        &self,
        chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
        wanted: impl Fn(&(f64, f64)) -> bool,
        x_label: impl Fn(&f64) -> String,
        y_label: impl Fn(&f64) -> String,
    ) -> Result<(), String>
    where
        X: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
    {
        let failed = |error: DrawingAreaErrorKind<_>| format!("{error}");
        chart
            .configure_mesh()
            .x_desc(self.x.as_str())
            .y_desc(self.y.as_str())
            .x_label_formatter(&x_label)
            .y_label_formatter(&y_label)
            .label_style(("sans-serif", 13))
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .draw()
            .map_err(failed)?;
        for series in &self.series {
            let points = series.points.iter().copied().filter(|point| wanted(point));
            let colour = series.colour;
            let drawn = match series.mark {
                Mark::Line => chart
                    .draw_series(LineSeries::new(points, colour.stroke_width(2)))
                    .map_err(failed)?
                    .label(series.name.as_str())
                    .legend(move |(x, y)| {
                        PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2))
                    }),
                Mark::Circles => chart
                    .draw_series(points.map(|point| Circle::new(point, 3, colour.stroke_width(2))))
                    .map_err(failed)?
                    .label(series.name.as_str())
                    .legend(move |(x, y)| Circle::new((x + 9, y), 3, colour.stroke_width(2))),
            };
            let _ = drawn;
        }
        chart
            .configure_series_labels()
            .position(match self.legend {
                Corner::UpperLeft => SeriesLabelPosition::UpperLeft,
                Corner::UpperRight => SeriesLabelPosition::UpperRight,
                Corner::LowerRight => SeriesLabelPosition::LowerRight,
                Corner::MiddleLeft => SeriesLabelPosition::MiddleLeft,
            })
            .label_font(("sans-serif", 13))
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.2))
            .draw()
            .map_err(failed)
    }
}

/// A tick's number without the noise of its last digits.
fn plain(tick: f64) -> String {
    format!("{}", (tick * 1e9).round() / 1e9)
}

/// A little room at both ends of a logarithmic axis.
fn wider(range: &std::ops::Range<f64>) -> std::ops::Range<f64> {
    (0.8 * range.start)..(1.25 * range.end)
}
