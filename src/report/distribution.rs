//! One distribution as a panel: its histogram with intervals beside laws, and the share of larger values on a
//! logarithmic scale.

mod histogram;
mod rows;
mod survival;

use std::fmt::Write;

pub use self::rows::COLUMNS;
use super::axis::{Area, round_step, rounded};
use super::frame::{BARS, BLUE, GREEN, INK, VERMILION, key, sample, text, whole};
use super::plot::Stroke;
use crate::error::Error;
use evidence::histogram::Bins;
use evidence::law::{Family, Law};
use evidence::moments;

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution<'a> {
    /// Above the panel and in the rows: `O`.
    pub title: &'a str,
    /// On the horizontal axis: `Σ_zz`.
    pub quantity: &'a str,
    /// Of the values: `J`.
    pub unit: &'a str,
    /// One a packing, in any order.
    pub values: &'a [f64],
    /// Of the histogram; the share of larger values is shown at their edges.
    pub bins: Bins,
    /// Mean of the theory's exponential, where there is a theory.
    pub theory_mean: Option<f64>,
    /// Laws that were fitted to the values. With one of both signs, Laplace's, the share of larger values is left out.
    pub fitted: &'a [Law],
}

/// A drawn panel and its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// SVG elements without a root.
    pub svg: String,
    /// Width and height.
    pub size: [f64; 2],
    /// What is drawn, as rows of [`COLUMNS`].
    pub rows: Vec<[String; 8]>,
}

const WIDTH: f64 = 420.0;
const MAIN: Area = [62.0, 66.0, 344.0, 256.0];
/// Of the intervals.
const LEVEL: f64 = 0.95;
/// About so many bins of [`round_bins`].
const BINS: f64 = 20.0;
/// Points of each curve.
const POINTS: u32 = 100;

/// A law as it is drawn.
struct Curve {
    /// In the rows.
    name: &'static str,
    /// In the key.
    words: String,
    stroke: Stroke<'static>,
    law: Law,
}

impl Curve {
    fn theory(mean: f64) -> Self {
        Curve {
            name: "exponential",
            words: "theory".to_owned(),
            stroke: Stroke::whole(VERMILION),
            law: Law::Exponential { mean },
        }
    }

    fn fitted(law: Law) -> Self {
        let of_shape = |name: &str, shape: f64| format!("{name}, shape {}", rounded(shape, 3));
        let (name, words, stroke) = match law {
            Law::Exponential { .. } => (
                "fitted exponential",
                "fitted exponential".to_owned(),
                Stroke {
                    dashes: "2 3",
                    ..Stroke::whole(INK)
                },
            ),
            Law::Gamma { shape, .. } => ("gamma", of_shape("Gamma", shape), Stroke::dashed(GREEN)),
            Law::Weibull { shape, .. } => {
                let words = of_shape("Weibull", shape);
                ("weibull", words, Stroke::dashed(GREEN))
            }
            Law::Laplace { .. } => ("laplace", "Laplace".to_owned(), Stroke::dashed(GREEN)),
        };
        Curve {
            name,
            words,
            stroke,
            law,
        }
    }

    /// Points of a function of the law over the bins; laws of positive values begin at zero.
    fn points(&self, bins: &Bins, of: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let from = match self.law {
            Law::Laplace { .. } => bins.start,
            _ => bins.start.max(0.0),
        };
        let points = (0..=POINTS).map(|index| {
            let at = from + (bins.end() - from) * f64::from(index) / f64::from(POINTS);
            [at, of(at)]
        });
        // A Gamma law of a shape below 1 has no bound at zero.
        points.filter(|point| point[1].is_finite()).collect()
    }
}

/// About twenty bins with round edges that hold all values but the largest half per cent, which would press all others to
/// the left; they go on to `least_end` at least. None without values that are all finite.
pub fn round_bins(values: &[f64], least_end: f64) -> Option<Bins> {
    let mut values: Vec<f64> = values.to_vec();
    values.sort_by(f64::total_cmp);
    let least = values.first().filter(|value| value.is_finite())?;
    values.last().filter(|value| value.is_finite())?;
    let usual = values[((values.len() - 1) as f64 * 0.995) as usize];
    let end = usual.max(least_end);
    let step = round_step(end / BINS);
    let (first, last) = ((least / step).floor().min(0.0), (end / step).ceil());
    Some(Bins {
        start: first * step,
        step,
        count: (last - first) as usize,
    })
}

impl Distribution<'_> {
    /// The panel; an error where there is nothing to draw.
    pub fn panel(&self) -> Result<Panel, Error> {
        self.check()?;
        let mut panel = Panel {
            svg: self.words(),
            size: [WIDTH, 0.0],
            rows: Vec::new(),
        };
        let curves = self.curves();
        let highest = survival::room(self, &curves);
        histogram::add(self, &mut panel, &curves, highest);
        if self.has_survival() {
            survival::add(self, &mut panel, &curves);
        }
        let [left, top, _, height] = MAIN;
        let (keys, lines) = key([left - 20.0, WIDTH], top + height + 62.0, &entries(&curves));
        panel.svg += &keys;
        panel.size[1] = top + height + 58.0 + 20.0 * lines as f64;
        Ok(panel)
    }

    fn check(&self) -> Result<(), Error> {
        let reason = if self.values.is_empty() {
            "no values to draw"
        } else if self.values.iter().any(|value| !value.is_finite()) {
            "a value is not finite"
        } else if !(self.bins.step > 0.0 && self.bins.end().is_finite()) || self.bins.count == 0 {
            "its bins have no width"
        } else if self
            .theory_mean
            .is_some_and(|mean| !(mean > 0.0 && mean.is_finite()))
        {
            "the theory's mean is not above zero"
        } else {
            return Ok(());
        };
        Err(Error::Report(format!(
            "the distribution of {} at {}: {reason}",
            self.quantity, self.title
        )))
    }

    fn curves(&self) -> Vec<Curve> {
        let theory = self.theory_mean.into_iter().map(Curve::theory);
        let fitted = self.fitted.iter().copied().map(Curve::fitted);
        theory.chain(fitted).collect()
    }

    fn has_survival(&self) -> bool {
        let both_signs = |law: &Law| law.family() == Family::Laplace;
        !self.fitted.iter().any(both_signs)
    }

    fn words(&self) -> String {
        let [left, top, _, _] = MAIN;
        let unit = self.unit;
        let mut svg = format!(
            "<g font-weight=\"bold\" font-size=\"15\">{}</g>",
            text([left, top - 42.0], "start", self.title)
        );
        let (mean, deviation) = (moments::mean(self.values), moments::deviation(self.values));
        let spread = if self.has_survival() {
            format!("variation {}", rounded(deviation / mean, 3))
        } else {
            format!("deviation {} {unit}", rounded(deviation, 3))
        };
        let mut second: Vec<String> = Vec::new();
        if let Some(mean) = self.theory_mean {
            second.push(format!(
                "theory: mean {} {unit}, variation 1",
                rounded(mean, 3)
            ));
        }
        let none = self.values.iter().filter(|value| **value <= 0.0).count();
        if none > 0 && self.has_survival() {
            second.push(format!("{none} not above zero"));
        }
        let first = format!(
            "{} values, mean {} {unit}, {spread}",
            self.values.len(),
            rounded(mean, 3)
        );
        for (index, said) in [first, second.join("; ")].iter().enumerate() {
            svg += &text([left, top - 24.0 + 16.0 * index as f64], "start", said);
        }
        svg
    }
}

/// Of the key.
fn entries(curves: &[Curve]) -> Vec<(String, String)> {
    let bar = format!(
        "<rect y=\"-11\" width=\"22\" height=\"12\" fill=\"{BARS}\"/>\
         <path stroke=\"{BLUE}\" stroke-width=\"1.4\" d=\"M11 -13v16\"/>"
    );
    let laws = curves.iter().map(|curve| {
        let Stroke { colour, dashes, .. } = curve.stroke;
        (sample(colour, 2.2, dashes), curve.words.clone())
    });
    std::iter::once((bar, "values, 95 %".to_owned()))
        .chain(laws)
        .collect()
}

/// Panels side by side as one drawing.
pub fn side_by_side(panels: &[Panel], label: &str) -> String {
    let (mut contents, mut width, mut height) = (String::new(), 0.0f64, 0.0f64);
    for panel in panels {
        let _ = writeln!(
            contents,
            "<g transform=\"translate({width:.0} 0)\" stroke-linejoin=\"round\">{}</g>",
            panel.svg
        );
        width += panel.size[0];
        height = height.max(panel.size[1]);
    }
    whole([width, height], label, &contents)
}

#[cfg(test)]
mod tests;
