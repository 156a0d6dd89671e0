//! The pictures of the claims.

use super::plot::{Axis, BLUE, GREEN, INK, PURPLE, Plot, VERMILION, picture, words};
use crate::claims::claim::{Answer, Claim};
use crate::claims::published::published;
use crate::claims::{Claims, Histogram, Volumes};
use crate::statistics::law::{Family, Law};

const POINT_COLOURS: [&str; 3] = [BLUE, VERMILION, GREEN];
const SOFT: &str = "#5f6368";

/// One panel of Figure 5: histogram with laws, and the share above a value on a logarithmic axis in the corner.
pub fn histogram(of: &Histogram) -> String {
    let end = of.start + of.bin * of.density.len() as f64;
    let shear = of.fitted.is_some_and(|law| law.family() == Family::Laplace);
    let mut laws: Vec<(Law, &str, &str)> = Vec::new();
    if let Some(mean) = of.theory {
        laws.push((Law::Exponential { mean }, VERMILION, ""));
    }
    if !shear {
        laws.push((Law::Exponential { mean: of.mean }, BLUE, "6 4"));
    }
    laws.extend(of.fitted.map(|law| (law, GREEN, "")));
    let tops = of.density.iter().map(|bin| bin.high);
    let at_start = laws.iter().map(|(law, _, _)| match law {
        Law::Exponential { mean } => 1.0 / mean,
        Law::Laplace { scale, .. } => 0.5 / scale,
        _ => 0.0,
    });
    let top = 1.05 * tops.chain(at_start).fold(0.0, f64::max);
    let mut plot = Plot::new(
        picture(460.0, 340.0),
        [66.0, 12.0, 446.0, 296.0],
        Axis::new(of.start, end, false),
        Axis::new(0.0, top, false),
        [&of.what, "probability density"],
        false,
    );
    for (index, bin) in of.density.iter().enumerate() {
        let low = of.start + of.bin * index as f64;
        plot.area(
            [low + 0.04 * of.bin, 0.0],
            [low + 0.96 * of.bin, bin.estimate],
            "#b9bec4",
            0.7,
        );
    }
    for (law, colour, dashes) in &laws {
        // A gamma law of a shape below 1 has no density at zero.
        let least = if shear {
            f64::NEG_INFINITY
        } else {
            1.0e-9 * of.bin
        };
        plot.curve(|x| law.density(x.max(least)), colour, dashes);
    }
    for (index, bin) in of.density.iter().enumerate() {
        let middle = of.start + of.bin * (index as f64 + 0.5);
        plot.interval(middle, [bin.low, bin.estimate, bin.high], INK, 1.4);
    }
    let svg = plot.done();
    if shear {
        return svg + "</svg>";
    }
    let lowest = 0.5 / of.packings as f64;
    let mut inset = Plot::new(
        svg,
        [262.0, 34.0, 440.0, 176.0],
        Axis::new(of.start, 1.2 * end, false),
        Axis::new(lowest, 1.0, true),
        ["", "share above"],
        true,
    );
    for (law, colour, dashes) in &laws {
        inset.curve(|x| law.survival(x).max(1.0e-9), colour, dashes);
    }
    let count = of.sorted.len() as f64;
    let mut steps = vec![(of.start, 1.0)];
    for (index, value) in of.sorted.iter().enumerate() {
        let [before, after] =
            [index, index + 1].map(|below| ((count - below as f64) / count).max(0.1 * lowest));
        steps.extend([(*value, before), (*value, after)]);
    }
    inset.line(steps, INK, "");
    inset.done() + "</svg>"
}

/// A quantity of growing volumes at one moment, O, A and B side by side.
fn growing(
    series: &[&Volumes],
    y: Axis,
    label: &str,
    level: impl Fn(f64) -> f64,
    other: Option<f64>,
    value: impl Fn(&crate::claims::Volume) -> Option<[f64; 3]>,
) -> String {
    let most = series
        .iter()
        .flat_map(|of| &of.volumes)
        .map(|one| one.cells)
        .max()
        .unwrap_or(1);
    let mut plot = Plot::new(
        picture(460.0, 340.0),
        [66.0, 12.0, 446.0, 296.0],
        Axis::new(0.8, 1.3 * most as f64, true),
        y,
        ["number of cells N", label],
        false,
    );
    plot.curve(level, INK, "");
    if let Some(other) = other {
        plot.curve(|_| other, SOFT, "5 4");
    }
    // Beside each other, not on each other.
    for ((of, colour), shift) in series.iter().zip(POINT_COLOURS).zip([0.94, 1.0, 1.06]) {
        for one in &of.volumes {
            if let Some(interval) = value(one) {
                plot.interval(shift * one.cells as f64, interval, colour, 2.8);
            }
        }
    }
    let mut svg = plot.done();
    for ((of, colour), place) in series.iter().zip(POINT_COLOURS).zip(0..) {
        words(
            &mut svg,
            426.0 - 22.0 * (2 - place) as f64,
            30.0,
            "middle",
            colour,
            of.point,
        );
    }
    svg + "</svg>"
}

/// Variation, shape and correlation against the number of cells.
pub fn volumes(claims: &Claims, moment: &str) -> [String; 3] {
    let all = claims.figures.volumes.iter();
    let series: Vec<&Volumes> = all.filter(|of| of.moment == moment).collect();
    let interval =
        |of: Option<crate::statistics::Interval>| of.map(|of| [of.low, of.estimate, of.high]);
    [
        growing(
            &series,
            Axis::new(0.02, 2.0, true),
            "coefficient of variation of ΣΣ_zz",
            |n| 1.0 / n.sqrt(),
            Some(0.1),
            |one| interval(one.variation),
        ),
        growing(
            &series,
            Axis::new(0.02, 5.0, true),
            "gamma shape over N",
            |_| 1.0,
            None,
            |one| interval(one.shape),
        ),
        growing(
            &series,
            Axis::new(-0.2, 0.8, false),
            "mean correlation of two cells",
            |_| 0.0,
            None,
            |one| one.correlation.map(|of| [of, of, of]),
        ),
    ]
}

/// Means over what is published, row by row.
pub fn means(claims: &Claims) -> String {
    let wanted = ["gravity", "mean.O", "mean.A", "mean.B", "extensive"];
    let rows: Vec<(&Claim, &crate::claims::claim::Row)> = claims
        .claims
        .iter()
        .filter(|claim| wanted.contains(&claim.id))
        .flat_map(|claim| claim.rows.iter().map(move |row| (claim, row)))
        .filter(|(_, row)| row.ratio.is_some())
        .collect();
    let most = rows
        .iter()
        .filter_map(|(_, row)| Some(row.ratio?.high))
        .fold(1.5, f64::max)
        .min(3.0);
    let height = 18.0 * rows.len() as f64;
    let mut plot = Plot::new(
        picture(760.0, height + 62.0),
        [330.0, 10.0, 746.0, 10.0 + height],
        Axis::new(0.0, 1.05 * most, false),
        // No ticks: rows have names.
        Axis::new(rows.len() as f64 - 0.01, 0.01, false),
        ["ours over published", ""],
        false,
    );
    plot.area([0.9, rows.len() as f64], [1.1, 0.0], "#009e73", 0.13);
    plot.line([(1.0, 0.0), (1.0, rows.len() as f64)], SOFT, "");
    for (index, (_, row)) in rows.iter().enumerate() {
        let Some(ratio) = row.ratio else { continue };
        let colour = match row.judged.map(|judged| judged.answer) {
            Some(Answer::Yes) => "#00674f",
            Some(Answer::No) => "#a33b00",
            _ => SOFT,
        };
        plot.level(
            index as f64 + 0.5,
            [ratio.low, ratio.estimate, ratio.high],
            colour,
        );
    }
    let mut svg = plot.done();
    for (index, (claim, row)) in rows.iter().enumerate() {
        let name = if claim.id.starts_with("mean.") {
            let point = claim.id.trim_start_matches("mean.");
            format!("{point}: {}", row.what)
        } else if claim.id == "gravity" {
            format!("gravity, {}", row.what)
        } else {
            row.what.clone()
        };
        words(
            &mut svg,
            322.0,
            24.0 + 18.0 * index as f64,
            "end",
            INK,
            &name,
        );
    }
    svg + "</svg>"
}

/// Beds in the plane of height and porosity.
pub fn plane(claims: &Claims) -> String {
    let (Some(height), Some(porosity)) = (published("height"), published("porosity")) else {
        return String::new();
    };
    let beds = claims.figures.plane.iter().flat_map(|cloud| &cloud.beds);
    let (mut x, mut y) = ([0.44f64, 0.48f64], [0.12f64, 0.20f64]);
    for [h, n] in beds {
        x = [x[0].min(h - 0.003), x[1].max(h + 0.003)];
        y = [y[0].min(n - 0.005), y[1].max(n + 0.005)];
    }
    let mut plot = Plot::new(
        picture(620.0, 400.0),
        [66.0, 12.0, 606.0, 352.0],
        Axis::new(x[0], x[1], false),
        Axis::new(y[0], y[1], false),
        ["height H, m", "porosity n"],
        false,
    );
    plot.area(
        [
            height.value - height.tolerance,
            porosity.value - porosity.tolerance,
        ],
        [
            height.value + height.tolerance,
            porosity.value + porosity.tolerance,
        ],
        "#f0e442",
        0.45,
    );
    plot.curve(|h| 1.0 - claims.figures.solid / h, INK, "");
    let colours = [BLUE, VERMILION, GREEN, PURPLE];
    for (cloud, colour) in claims.figures.plane.iter().zip(colours) {
        for [h, n] in &cloud.beds {
            plot.dot(*h, *n, colour);
        }
    }
    let mut svg = plot.done();
    for ((cloud, colour), line) in claims.figures.plane.iter().zip(colours).zip(0..) {
        words(
            &mut svg,
            598.0,
            300.0 + 15.0 * f64::from(line),
            "end",
            colour,
            cloud.definition,
        );
    }
    svg + "</svg>"
}
