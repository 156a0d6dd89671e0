//! One distribution as a panel: histogram with intervals, the theory's exponential, a fitted Gamma law, and the share of
//! larger values on a logarithmic scale.

use std::fmt::Write;

use super::frame::{Area, Axis, BLUE, GREEN, VERMILION, border, line, printed, text};
use crate::error::Error;
use crate::statistics::law::Law;
use crate::statistics::proportion::wilson;
use crate::statistics::{Interval, moments};

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distribution<'a> {
    /// Above the panel and in the rows: `O`.
    pub title: &'a str,
    /// On the horizontal axis: `Σ_zz`.
    pub quantity: &'a str,
    /// Of the values: `J`.
    pub unit: &'a str,
    /// One a packing, in any order.
    pub values: &'a [f64],
    /// Mean of the theory's exponential.
    pub theory_mean: f64,
    /// A fitted Gamma law: shape and scale.
    pub gamma: Option<(f64, f64)>,
}

/// A drawn panel of [`SIZE`] and its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// SVG elements without a root.
    pub svg: String,
    /// What is drawn, as rows of [`COLUMNS`].
    pub rows: Vec<[String; 8]>,
}

/// Width and height of a panel.
pub const SIZE: [f64; 2] = [420.0, 400.0];

/// Head of the rows. A density is over 1/unit; a share has no unit.
pub const COLUMNS: [&str; 8] = [
    "panel", "unit", "series", "from", "to", "value", "low_95", "high_95",
];

const MAIN: Area = [62.0, 66.0, 344.0, 256.0];
const INSET: Area = [266.0, 88.0, 130.0, 92.0];
/// From the inset's border to the ends of its labels: left and below.
const AROUND: [f64; 2] = [42.0, 26.0];
/// Of the intervals.
const LEVEL: f64 = 0.95;
/// About so many bins.
const BINS: f64 = 20.0;
/// Points of each curve.
const POINTS: u32 = 100;

impl Distribution<'_> {
    /// The panel; an error where there is nothing to draw.
    pub fn panel(&self) -> Result<Panel, Error> {
        let empty = |reason: &str| {
            let reason = format!(
                "the distribution of {} at {}: {reason}",
                self.quantity, self.title
            );
            Error::Report(reason)
        };
        let mut values: Vec<f64> = self.values.to_vec();
        values.sort_by(f64::total_cmp);
        let [Some(&least), Some(&largest)] = [values.first(), values.last()] else {
            return Err(empty("no values to draw"));
        };
        if !(least.is_finite() && largest.is_finite()) {
            return Err(empty("a value is not finite"));
        }
        if !(self.theory_mean > 0.0 && self.theory_mean.is_finite()) {
            return Err(empty("the theory's mean is not above zero"));
        }
        // A few outliers would press all bins to the left.
        let usual = values[((values.len() - 1) as f64 * 0.995) as usize];
        let end = usual.max(2.5 * self.theory_mean);
        let step = super::frame::round_step(end / BINS);
        let (first, last) = ((least / step).floor().min(0.0), (end / step).ceil());
        let bins = Bins {
            start: first * step,
            step,
            count: (last - first) as usize,
        };
        let mut panel = Panel {
            svg: self.words(&values),
            rows: Vec::new(),
        };
        self.histogram(&mut panel, &values, &bins);
        self.survival(&mut panel, &values, &bins);
        Ok(panel)
    }

    fn words(&self, values: &[f64]) -> String {
        let [left, top, _, _] = MAIN;
        let unit = self.unit;
        let mut svg = format!(
            "<g font-weight=\"bold\" font-size=\"15\">{}</g>",
            text([left, top - 42.0], "start", self.title)
        );
        let mean = moments::mean(values);
        let none = values.iter().filter(|value| **value <= 0.0).count();
        let unborne = match none {
            0 => String::new(),
            _ => format!("; {none} not above zero"),
        };
        let said = [
            format!(
                "{} values, mean {} {unit}, variation {}",
                values.len(),
                three_digits(mean),
                three_digits(moments::deviation(values) / mean)
            ),
            format!(
                "theory: mean {} {unit}, variation 1{unborne}",
                three_digits(self.theory_mean)
            ),
        ];
        for (index, said) in said.iter().enumerate() {
            svg += &text([left, top - 24.0 + 16.0 * index as f64], "start", said);
        }
        svg
    }

    fn laws(&self) -> Vec<(&'static str, &'static str, Law)> {
        let mut laws = vec![(
            "exponential",
            VERMILION,
            Law::Exponential {
                mean: self.theory_mean,
            },
        )];
        if let Some((shape, scale)) = self.gamma {
            laws.push(("gamma", GREEN, Law::Gamma { shape, scale }));
        }
        laws
    }

    fn histogram(&self, panel: &mut Panel, values: &[f64], bins: &Bins) {
        let shares: Vec<(f64, Interval)> = (0..bins.count)
            .filter_map(|index| {
                let from = bins.edge(index);
                let last = index + 1 == bins.count;
                let inside = values.iter().filter(|value| {
                    **value >= from
                        && (**value < bins.edge(index + 1)
                            || last && **value <= bins.edge(bins.count))
                });
                let share = wilson(inside.count(), values.len(), LEVEL)?;
                Some((from, share.over(bins.step)))
            })
            .collect();
        let peak = shares
            .iter()
            .map(|(_, share)| share.high)
            .fold(0.0, f64::max);
        let peak = peak.max(1.0 / self.theory_mean);
        let x = Axis::across(MAIN, bins.start, bins.edge(bins.count));
        // What stands below the inset leaves room for it.
        let beside = x.low + (x.high - x.low) * (INSET[0] - AROUND[0] - MAIN[0]) / MAIN[2];
        let below = MAIN[1] + MAIN[3] - (INSET[1] + INSET[3] + AROUND[1]);
        let bars = shares.iter().filter(|(from, _)| from + bins.step > beside);
        let laws = self
            .laws()
            .into_iter()
            .map(|(_, _, law)| law.density(beside));
        let tallest = bars
            .map(|(_, share)| share.high)
            .chain(laws)
            .fold(0.0, f64::max);
        let highest = (1.06 * peak).max(tallest * MAIN[3] / below);
        let y = Axis::upwards(MAIN, 0.0, highest);
        let floor = y.place(0.0);
        for (from, share) in &shares {
            let (left, right) = (x.place(*from), x.place(from + bins.step));
            let (top, middle) = (y.place(share.estimate), 0.5 * (left + right));
            let _ = write!(
                panel.svg,
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#b4d3e8\" stroke=\"#fff\"/>\
                 <path stroke=\"{BLUE}\" stroke-width=\"1.4\" d=\"M{middle:.1} {:.1}V{:.1}\"/>",
                right - left,
                floor - top,
                y.place(share.low),
                y.place(share.high)
            );
            panel
                .rows
                .push(self.row("histogram density", [*from, from + bins.step], *share));
        }
        for (name, colour, law) in self.laws() {
            let from = bins.start.max(0.0);
            let points = curve(from, bins.edge(bins.count), |x| law.density(x));
            // A Gamma law of a shape below 1 has no bound at zero.
            let points: Vec<[f64; 2]> = points.filter(|point| point[1].is_finite()).collect();
            self.add_curve(
                panel,
                &format!("{name} density"),
                &points,
                colour,
                [&x, &y],
                2.2,
            );
        }
        let across = format!("{}, {}", self.quantity, self.unit);
        let upwards = format!("probability density, 1/{}", self.unit);
        panel.svg += &border(MAIN, &x, &y, [&across, &upwards]);
        panel.svg += &self.key();
    }

    /// The share of larger values, where an exponential is a straight line.
    fn survival(&self, panel: &mut Panel, values: &[f64], bins: &Bins) {
        let count = values.len();
        let least = 10f64.powf((0.5 / count as f64).log10().floor()).min(1e-2);
        let [left, top, _, _] = INSET;
        let x = Axis::across(INSET, bins.start, bins.edge(bins.count));
        let y = Axis::upwards(INSET, least, 1.0).logarithmic();
        let shares: Vec<(f64, Interval)> = (0..=bins.count)
            .filter_map(|index| {
                let at = bins.edge(index);
                let above = values.iter().filter(|value| **value > at).count();
                Some((at, wilson(above, count, LEVEL)?))
            })
            .collect();
        let band = |end: fn(&Interval) -> f64| {
            let place = move |(at, share): &(f64, Interval)| [x.place(*at), y.place(end(share))];
            shares.iter().map(place)
        };
        let _ = write!(
            panel.svg,
            "<path fill=\"{BLUE}\" fill-opacity=\".22\" d=\"{}Z\"/>",
            line(band(|share| share.high).chain(band(|share| share.low).rev()))
        );
        for (name, colour, law) in self.laws() {
            let from = bins.start.max(0.0);
            let points: Vec<[f64; 2]> =
                curve(from, bins.edge(bins.count), |x| law.survival(x)).collect();
            // Where the curve leaves the scale, it ends.
            let shown = points.iter().take_while(|point| point[1] >= least).count();
            self.add_curve(
                panel,
                &format!("{name} share above"),
                &points[..shown],
                colour,
                [&x, &y],
                1.8,
            );
        }
        let some = shares.iter().filter(|(_, share)| share.estimate > 0.0);
        for (at, share) in some {
            let _ = write!(
                panel.svg,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.1\" fill=\"{BLUE}\"/>",
                x.place(*at),
                y.place(share.estimate)
            );
        }
        for (at, share) in &shares {
            panel.rows.push(self.row("share above", [*at, *at], *share));
        }
        panel.svg += "<g font-size=\"11\">";
        panel.svg += &border(INSET, &x, &y, ["", ""]);
        panel.svg += &text([left, top - 7.0], "start", "share of larger values");
        panel.svg += "</g>\n";
    }

    fn add_curve(
        &self,
        panel: &mut Panel,
        name: &str,
        points: &[[f64; 2]],
        colour: &str,
        [x, y]: [&Axis; 2],
        width: f64,
    ) {
        let dashes = if colour == GREEN {
            " stroke-dasharray=\"6 4\""
        } else {
            ""
        };
        let places = points.iter().filter(|point| point[1] <= y.high);
        let _ = write!(
            panel.svg,
            "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dashes} d=\"{}\"/>",
            line(places.map(|[at, value]| [x.place(*at), y.place(*value)]))
        );
        for [at, value] in points {
            panel.rows.push(self.row(
                name,
                [*at, *at],
                Interval {
                    estimate: *value,
                    low: f64::NAN,
                    high: f64::NAN,
                },
            ));
        }
    }

    fn row(&self, series: &str, [from, to]: [f64; 2], value: Interval) -> [String; 8] {
        let number = |value: f64| {
            if value.is_nan() {
                String::new()
            } else {
                format!("{value}")
            }
        };
        [
            self.title.to_owned(),
            self.unit.to_owned(),
            series.to_owned(),
            number(from),
            number(to),
            number(value.estimate),
            number(value.low),
            number(value.high),
        ]
    }

    fn key(&self) -> String {
        let [left, top, _, height] = MAIN;
        let y = top + height + 62.0;
        let mut svg = format!(
            "<rect x=\"{left}\" y=\"{:.1}\" width=\"14\" height=\"12\" fill=\"#b4d3e8\"/>\
             <path stroke=\"{BLUE}\" stroke-width=\"1.4\" d=\"M{:.1} {:.1}v16\"/>",
            y - 11.0,
            left + 7.0,
            y - 13.0
        );
        svg += &text([left + 20.0, y], "start", "values, 95 %");
        for ((name, colour, _), (at, dashes)) in self
            .laws()
            .into_iter()
            .zip([(112.0, ""), (194.0, " stroke-dasharray=\"6 4\"")])
        {
            let at = left + at;
            let _ = write!(
                svg,
                "<path stroke=\"{colour}\" stroke-width=\"2.2\"{dashes} d=\"M{at:.1} {:.1}h22\"/>",
                y - 4.5
            );
            let words = match self.gamma {
                Some((shape, _)) if name == "gamma" => {
                    format!("Gamma, shape {}", three_digits(shape))
                }
                _ => "theory".to_owned(),
            };
            svg += &text([at + 28.0, y], "start", &words);
        }
        svg
    }
}

/// Equal bins.
struct Bins {
    start: f64,
    step: f64,
    count: usize,
}

impl Bins {
    fn edge(&self, index: usize) -> f64 {
        self.start + self.step * index as f64
    }
}

fn curve(from: f64, to: f64, of: impl Fn(f64) -> f64) -> impl Iterator<Item = [f64; 2]> {
    (0..=POINTS).map(move |index| {
        let at = from + (to - from) * f64::from(index) / f64::from(POINTS);
        [at, of(at)]
    })
}

fn three_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return printed(value);
    }
    let unit = 10f64.powi(value.abs().log10().floor() as i32 - 2);
    printed((value / unit).round() * unit)
}

/// Panels side by side as one drawing.
pub fn side_by_side(panels: &[Panel], label: &str) -> String {
    let [width, height] = SIZE;
    let mut contents = String::new();
    for (index, panel) in panels.iter().enumerate() {
        let _ = writeln!(
            contents,
            "<g transform=\"translate({:.0} 0)\" stroke-linejoin=\"round\">{}</g>",
            width * index as f64,
            panel.svg
        );
    }
    super::frame::whole([width * panels.len() as f64, height], label, &contents)
}

/// One distribution as a drawing of its own.
pub fn svg(of: &Distribution<'_>) -> Result<String, Error> {
    Ok(side_by_side(&[of.panel()?], of.title))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantiles(count: u32) -> Vec<f64> {
        (0..count)
            .map(|k| -0.34 * (1.0 - (f64::from(k) + 0.5) / f64::from(count)).ln())
            .collect()
    }

    fn of(values: &[f64]) -> Distribution<'_> {
        Distribution {
            title: "O",
            quantity: "Σ_zz",
            unit: "J",
            values,
            theory_mean: 0.34,
            gamma: Some((1.1, 0.31)),
        }
    }

    #[test]
    fn bins_hold_all_values_but_outliers_and_their_intervals_hold_the_law() {
        let values = quantiles(1000);
        let panel = of(&values).panel().expect("has values");
        let law = Law::Exponential { mean: 0.34 };
        let (mut sum, mut missed, mut bins) = (0.0, 0, 0);
        for row in panel
            .rows
            .iter()
            .filter(|row| row[2] == "histogram density")
        {
            let [from, to, value, low, high] =
                [3, 4, 5, 6, 7].map(|index: usize| row[index].parse::<f64>().expect("a number"));
            let wanted = (law.survival(from) - law.survival(to)) / (to - from);
            missed += u32::from(!(low..=high).contains(&wanted));
            sum += value * (to - from);
            bins += 1;
        }
        assert!(bins >= 10 && missed == 0, "{missed} of {bins}");
        assert!((sum - 0.995).abs() < 0.006, "{sum}");
        assert!(!panel.svg.contains("NaN") && !panel.svg.contains("inf"));
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let said = |of: Distribution<'_>| of.panel().expect_err("nothing to draw").to_string();
        assert!(said(of(&[])).contains("no values"));
        assert!(said(of(&[1.0, f64::NAN])).contains("not finite"));
        let values = [1.0, 2.0];
        let no_mean = Distribution {
            theory_mean: 0.0,
            ..of(&values)
        };
        assert!(said(no_mean).contains("above zero"));
    }

    #[test]
    fn values_below_zero_have_bins() {
        let panel = of(&[-0.3, 0.1, 0.2, 0.5]).panel().expect("has values");
        let first = panel.rows.iter().find(|row| row[2] == "histogram density");
        let from: f64 = first.expect("a bin")[3].parse().expect("a number");
        assert!((from + 0.3).abs() < 1e-9, "{from}");
    }
}
