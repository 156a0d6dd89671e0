//! The share of larger values, where an exponential is a straight line, as an inset of the histogram.

use super::{Curve, Distribution, LEVEL, MAIN, Panel, rows};
use crate::report::axis::{Area, Axis};
use crate::report::frame::{BLUE, text};
use crate::report::plot::Plot;
use evidence::Interval;
use evidence::proportion::wilson;

const INSET: Area = [266.0, 88.0, 130.0, 92.0];
/// From the inset's border to the ends of its labels: left and below.
const AROUND: [f64; 2] = [42.0, 26.0];

/// Where the histogram's axis must end, so that what stands below the inset leaves room for it.
pub fn room(of: &Distribution<'_>, curves: &[Curve]) -> f64 {
    if !of.has_survival() {
        return 0.0;
    }
    let bins = &of.bins;
    let across = Axis::across(MAIN, bins.start, bins.end());
    let beside = across.value((INSET[0] - AROUND[0] - MAIN[0]) / MAIN[2]);
    let below = MAIN[1] + MAIN[3] - (INSET[1] + INSET[3] + AROUND[1]);
    let densities = bins.densities(of.values, LEVEL);
    let bars = densities.iter().enumerate();
    let bars = bars.filter(|(index, _)| bins.edge(index + 1) > beside);
    let laws = curves.iter().map(|curve| curve.law.density(beside));
    let tallest = bars
        .map(|(_, density)| density.high)
        .chain(laws)
        .fold(0.0, f64::max);
    tallest * MAIN[3] / below
}

/// Adds the inset.
pub fn add(of: &Distribution<'_>, panel: &mut Panel, curves: &[Curve]) {
    let (count, bins) = (of.values.len(), &of.bins);
    let least = 10f64.powf((0.5 / count as f64).log10().floor()).min(1e-2);
    let shares: Vec<(f64, Interval)> = (0..=bins.count)
        .filter_map(|index| {
            let at = bins.edge(index);
            let above = of.values.iter().filter(|value| **value > at).count();
            Some((at, wilson(above, count, LEVEL)?))
        })
        .collect();
    let mut plot = Plot::new(
        INSET,
        Axis::across(INSET, bins.start, bins.end()),
        Axis::upwards(INSET, least, 1.0).logarithmic(),
    );
    let upper = shares.iter().map(|(at, share)| [*at, share.high]);
    let lower = shares.iter().map(|(at, share)| [*at, share.low]);
    plot.band(upper.chain(lower.rev()), BLUE, 0.22);
    for curve in curves {
        let points = curve.points(bins, |x| curve.law.survival(x));
        let series = format!("{} share above", curve.name);
        // What leaves the scale is not shown.
        let shown = points.iter().take_while(|point| point[1] >= least).count();
        rows::add_points(of, panel, &series, &points[..shown]);
        plot.line(points, curve.stroke);
    }
    for (at, share) in &shares {
        if share.estimate > 0.0 {
            plot.dot([*at, share.estimate], BLUE, 2.1, 1.0);
        }
        rows::add(of, panel, "share above", [*at, *at], *share);
    }
    let [left, top, _, _] = INSET;
    panel.svg += "<g font-size=\"11\">";
    panel.svg += &plot.svg(["", ""]);
    panel.svg += &text([left, top - 7.0], "start", "share of larger values");
    panel.svg += "</g>\n";
}
