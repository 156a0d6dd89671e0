//! Bars of the density with their intervals, and the densities of the laws.

use super::{Curve, Distribution, LEVEL, MAIN, Panel, rows};
use crate::report::axis::Axis;
use crate::report::frame::{BARS, BLUE};
use crate::report::plot::{Plot, Stroke};
use evidence::law::Law;

/// Room above the highest bar or law.
const ROOM: f64 = 1.06;

/// Adds the histogram; its axis goes up to `least_top` at least.
pub fn add(of: &Distribution<'_>, panel: &mut Panel, curves: &[Curve], least_top: f64) {
    let bins = &of.bins;
    let densities = bins.densities(of.values, LEVEL);
    let bars = densities.iter().map(|density| density.high);
    let peaks = curves.iter().map(|curve| peak(&curve.law));
    let highest = ROOM * bars.chain(peaks).fold(0.0, f64::max);
    let mut plot = Plot::new(
        MAIN,
        Axis::across(MAIN, bins.start, bins.end()),
        Axis::upwards(MAIN, 0.0, highest.max(least_top)),
    );
    for (index, density) in densities.iter().enumerate() {
        let [from, to] = [bins.edge(index), bins.edge(index + 1)];
        let style = format!("fill=\"{BARS}\" stroke=\"#fff\"");
        plot.box_of([from, 0.0], [to, density.estimate], &style);
        plot.upright(0.5 * (from + to), [density.low, density.high], BLUE);
        rows::add(of, panel, "histogram density", [from, to], *density);
    }
    for curve in curves {
        let points = curve.points(bins, |x| curve.law.density(x));
        let series = format!("{} density", curve.name);
        rows::add_points(of, panel, &series, &points);
        plot.line(
            points,
            Stroke {
                width: 2.2,
                ..curve.stroke
            },
        );
    }
    let across = format!("{}, {}", of.quantity, of.unit);
    let upwards = format!("probability density, 1/{}", of.unit);
    panel.svg += &plot.svg([&across, &upwards]);
}

/// The largest density where it is sure to have a bound.
fn peak(law: &Law) -> f64 {
    match law {
        Law::Exponential { mean } => 1.0 / mean,
        Law::Laplace { scale, .. } => 0.5 / scale,
        Law::Gamma { .. } | Law::Weibull { .. } => 0.0,
    }
}
