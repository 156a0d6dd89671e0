//! The pictures of the claims.

use crate::error::Error;
use crate::report::axis::{Area, Axis};
use crate::report::distribution::{COLUMNS, Distribution, side_by_side};
use crate::report::figure::{Figure, cells};
use crate::report::figure_files::table;
use crate::report::frame::{BLUE, GREEN, INK, PURPLE, SOFT, VERMILION, coloured, whole};
use crate::report::plot::{Plot, Stroke};
use crate::study::claims::claim::{Answer, Claim, Row};
use crate::study::claims::published::published;
use crate::study::claims::{Claims, Histogram, Volume, Volumes};
use evidence::Interval;
use evidence::histogram::Bins;
use evidence::law::{Family, Law};

const POINT_COLOURS: [&str; 3] = [BLUE, VERMILION, GREEN];

/// A distribution as a panel like those of Figure 5: `unit` is so many of the values' own. `group` begins its name.
pub fn histogram(
    group: &str,
    of: &Histogram,
    quantity: &str,
    (unit, scale): (&str, f64),
) -> Result<Figure, Error> {
    let values: Vec<f64> = of.sorted.iter().map(|value| value / scale).collect();
    let both_signs = of.fitted.is_some_and(|law| law.family() == Family::Laplace);
    let own = (!both_signs).then_some(Law::Exponential { mean: of.mean });
    let fitted = own.into_iter().chain(of.fitted).map(|law| law.over(scale));
    let panel = Distribution {
        title: &of.point,
        quantity,
        unit,
        values: &values,
        bins: Bins {
            start: of.start / scale,
            step: of.bin / scale,
            count: of.density.len(),
        },
        theory_mean: of.theory.map(|mean| mean / scale),
        fitted: &fitted.collect::<Vec<Law>>(),
    };
    let panel = panel.panel()?;
    Ok(Figure {
        name: format!("{}-{}", group.replace('.', "-"), of.point),
        caption: of.what.clone(),
        csv: table(&COLUMNS, &panel.rows)?,
        svg: side_by_side(&[panel], &of.what),
    })
}

/// A plot's part of a picture of this size.
fn area_in([width, height]: [f64; 2]) -> Area {
    [66.0, 24.0, width - 80.0, height - 72.0]
}

/// What is shown of a volume: its lower end, itself, its upper end.
type Shown = fn(&Volume) -> Option<[f64; 3]>;

/// A quantity of growing volumes at one moment, O, A and B side by side.
fn growing(
    series: &[&Volumes],
    y: fn(Area) -> Axis,
    label: &str,
    level: impl Fn(f64) -> f64,
    other: Option<f64>,
    value: impl Fn(&Volume) -> Option<[f64; 3]>,
) -> String {
    const SIZE: [f64; 2] = [460.0, 340.0];
    let area = area_in(SIZE);
    let volumes = || series.iter().flat_map(|of| &of.volumes);
    let most = volumes().map(|one| one.cells).max().unwrap_or(1);
    let x = Axis::across(area, 0.8, 1.3 * most as f64).logarithmic();
    let mut plot = Plot::with_grid(area, x, y(area));
    plot.curve(level, Stroke::whole(INK));
    if let Some(other) = other {
        plot.curve(|_| other, Stroke::dashed(SOFT));
    }
    // Beside each other, not on each other.
    for ((of, colour), shift) in series.iter().zip(POINT_COLOURS).zip([0.94, 1.0, 1.06]) {
        for one in &of.volumes {
            if let Some([low, middle, high]) = value(one) {
                let at = shift * one.cells as f64;
                plot.upright(at, [low, high], colour);
                plot.dot([at, middle], colour, 2.8, 1.0);
            }
        }
    }
    let mut svg = plot.svg(["number of cells N", label]);
    for ((of, colour), place) in series.iter().zip(POINT_COLOURS).zip(0..) {
        let at = area[0] + area[2] - 8.0 - 22.0 * f64::from(2 - place);
        svg += &coloured(colour, [at, area[1] - 7.0], "middle", &of.point);
    }
    whole(SIZE, label, &svg)
}

/// Variation, shape and correlation against the number of cells.
pub fn volumes(claims: &Claims, moment: &str) -> Result<[Figure; 3], Error> {
    let all = claims.figures.volumes.iter();
    let series: Vec<&Volumes> = all.filter(|of| of.moment == moment).collect();
    let figure = |name: &str, caption: &str, svg: String, of: Shown| -> Result<Figure, Error> {
        Ok(Figure {
            name: format!("{name}-{moment}"),
            caption: caption.to_owned(),
            svg,
            csv: numbers(&series, of)?,
        })
    };
    let [variation, shape, correlation]: [Shown; 3] = [
        |one| interval(one.variation),
        |one| interval(one.shape),
        |one| one.correlation.map(|of| [of, of, of]),
    ];
    let drawn = [
        growing(
            &series,
            |area| Axis::upwards(area, 0.02, 2.0).logarithmic(),
            "coefficient of variation of ΣΣ_zz",
            |n| 1.0 / n.sqrt(),
            Some(0.1),
            variation,
        ),
        growing(
            &series,
            |area| Axis::upwards(area, 0.02, 5.0).logarithmic(),
            "gamma shape over N",
            |_| 1.0,
            None,
            shape,
        ),
        growing(
            &series,
            |area| Axis::upwards(area, -0.2, 0.8),
            "mean correlation of two cells",
            |_| 0.0,
            None,
            correlation,
        ),
    ];
    let [first, second, third] = drawn;
    Ok([
        figure(
            "variation-and-cells",
            "Variation of many cells together.",
            first,
            variation,
        )?,
        figure(
            "shape-and-cells",
            "Gamma shape over the number of cells.",
            second,
            shape,
        )?,
        figure(
            "correlation-and-cells",
            "Mean correlation of two cells.",
            third,
            correlation,
        )?,
    ])
}

fn interval(of: Option<Interval>) -> Option<[f64; 3]> {
    of.map(|of| [of.low, of.estimate, of.high])
}

/// The points of [`growing`].
fn numbers(
    series: &[&Volumes],
    value: impl Fn(&Volume) -> Option<[f64; 3]>,
) -> Result<String, Error> {
    let head = ["point", "cells", "value", "low_95", "high_95"];
    let rows = series.iter().flat_map(|of| {
        let shown = of
            .volumes
            .iter()
            .filter_map(|one| Some((one.cells, value(one)?)));
        shown.map(|(count, [low, middle, high])| {
            let mut row = vec![of.point.to_string(), count.to_string()];
            row.extend(cells([middle, low, high]));
            row
        })
    });
    table(&head, rows)
}

/// Means over what is published, row by row.
pub fn means(claims: &Claims) -> Result<Option<Figure>, Error> {
    const ROW: f64 = 18.0;
    let wanted = ["gravity", "mean.O", "mean.A", "mean.B", "extensive"];
    let rows: Vec<(&Claim, &Row)> = claims
        .claims
        .iter()
        .filter(|claim| wanted.contains(&claim.id.as_ref()))
        .flat_map(|claim| claim.rows.iter().map(move |row| (claim, row)))
        .filter(|(_, row)| row.ratio.is_some())
        .collect();
    if rows.is_empty() {
        return Ok(None);
    }
    let most = rows
        .iter()
        .filter_map(|(_, row)| Some(row.ratio?.high))
        .fold(1.5, f64::max)
        .min(3.0);
    let count = rows.len() as f64;
    let area = [400.0, 10.0, 346.0, ROW * count];
    let mut plot = Plot::with_grid(
        area,
        Axis::across(area, 0.0, 1.05 * most),
        // Downwards and so without ticks: rows have names.
        Axis::upwards(area, count, 0.0),
    );
    plot.box_of(
        [0.9, count],
        [1.1, 0.0],
        "fill=\"#009e73\" fill-opacity=\".13\"",
    );
    plot.upright(1.0, [0.0, count], SOFT);
    for (index, (_, row)) in rows.iter().enumerate() {
        let Some(ratio) = row.ratio else { continue };
        let colour = match row.judged.map(|judged| judged.answer) {
            Some(Answer::Yes) => "#00674f",
            Some(Answer::No) => "#a33b00",
            _ => SOFT,
        };
        let at = index as f64 + 0.5;
        plot.level(at, [ratio.low, ratio.high], colour);
        plot.dot([ratio.estimate, at], colour, 3.2, 1.0);
    }
    let mut svg = plot.svg(["ours over published", ""]);
    let name = |claim: &Claim, row: &Row| {
        if claim.id.starts_with("mean.") {
            let point = claim.id.trim_start_matches("mean.");
            format!("{point}: {}", row.what)
        } else if claim.id == "gravity" {
            format!("gravity, {}", row.what)
        } else {
            row.what.clone()
        }
    };
    let mut numbers = Vec::new();
    for (index, (claim, row)) in rows.iter().enumerate() {
        let name = name(claim, row);
        let at = [area[0] - 8.0, area[1] + ROW * (index as f64 + 0.5) + 4.5];
        svg += &coloured(INK, at, "end", &name);
        if let Some(of) = row.ratio {
            let mut line = vec![name];
            line.extend(cells([of.estimate, of.low, of.high]));
            numbers.push(line);
        }
    }
    Ok(Some(Figure {
        name: "means-over-published".to_owned(),
        caption: "Means over published means.".to_owned(),
        svg: whole([760.0, area[3] + 62.0], "Means over published means", &svg),
        csv: table(
            &["mean", "ours over published", "low_95", "high_95"],
            numbers,
        )?,
    }))
}

/// Beds in the plane of height and porosity.
pub fn plane(claims: &Claims) -> Result<Option<Figure>, Error> {
    const SIZE: [f64; 2] = [620.0, 400.0];
    let (Some(height), Some(porosity)) = (published("height"), published("porosity")) else {
        return Ok(None);
    };
    let beds = claims.figures.plane.iter().flat_map(|cloud| &cloud.beds);
    let (mut x, mut y) = ([0.44f64, 0.48f64], [0.12f64, 0.20f64]);
    for [h, n] in beds {
        x = [x[0].min(h - 0.003), x[1].max(h + 0.003)];
        y = [y[0].min(n - 0.005), y[1].max(n + 0.005)];
    }
    let area = area_in(SIZE);
    let mut plot = Plot::with_grid(
        area,
        Axis::across(area, x[0], x[1]),
        Axis::upwards(area, y[0], y[1]),
    );
    let end = |side: f64| {
        [
            height.value + side * height.tolerance,
            porosity.value + side * porosity.tolerance,
        ]
    };
    plot.box_of(end(-1.0), end(1.0), "fill=\"#f0e442\" fill-opacity=\".45\"");
    plot.curve(|h| 1.0 - claims.figures.solid / h, Stroke::whole(INK));
    let colours = [BLUE, VERMILION, GREEN, PURPLE];
    for (cloud, colour) in claims.figures.plane.iter().zip(colours) {
        for bed in &cloud.beds {
            plot.dot(*bed, colour, 2.2, 0.45);
        }
    }
    let mut svg = plot.svg(["height H, m", "porosity n"]);
    let [right, floor] = [area[0] + area[2], area[1] + area[3]];
    for ((cloud, colour), line) in claims.figures.plane.iter().zip(colours).zip(0..) {
        let at = [right - 8.0, floor - 58.0 + 16.0 * f64::from(line)];
        svg += &coloured(colour, at, "end", &cloud.definition);
    }
    let beds = claims.figures.plane.iter().flat_map(|cloud| {
        let row = |[h, n]: &[f64; 2]| {
            let definition = cloud.definition.to_string();
            [definition, h.to_string(), n.to_string()]
        };
        cloud.beds.iter().map(row)
    });
    Ok(Some(Figure {
        name: "height-and-porosity".to_owned(),
        caption: "Height and porosity of settled beds.".to_owned(),
        csv: table(&["definition", "height (m)", "porosity (1)"], beds)?,
        svg: whole(SIZE, "Height and porosity of settled beds", &svg),
    }))
}
