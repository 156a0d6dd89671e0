//! Two engines against each other: every measured quantity's difference, and the forces quantile by quantile.

use super::axis::Axis;
use super::figure::{Figure, cells};
use super::figure_files::table;
use super::frame::{BLUE, INK, SOFT, VERMILION, coloured, text, whole};
use super::plot::{Plot, Stroke};
use crate::compare::QuantityPair;
use crate::error::Error;
use crate::reproduce::Runs;
use crate::reproduce::record::{NamedComparison, Reproduction};

/// What is drawn, if YADE's ordinary loop ran: where the bits agree, there is no difference to draw.
pub fn figures(reproduction: &Reproduction, runs: &Runs) -> Result<Vec<Figure>, Error> {
    let mut figures = Vec::new();
    let apart = reproduction.comparisons.iter();
    for named in apart.filter(|named| !named.comparison.bits_expected) {
        figures.extend(differences(named)?);
    }
    figures.extend(quantiles(runs)?);
    Ok(figures)
}

const ROW: f64 = 15.0;
const LEFT: f64 = 308.0;
const WIDTH: f64 = 380.0;
/// Differences of less than this share of what is allowed are drawn here.
const LEAST: f64 = 1.0e-3;

/// |A − B| over what is allowed, quantity by quantity, beside that of the control pair.
fn differences(named: &NamedComparison) -> Result<Option<Figure>, Error> {
    let judged = |pair: &&QuantityPair| {
        pair.allowed.is_some_and(|allowed| allowed > 0.0) && pair.difference.is_some()
    };
    let pairs: Vec<&QuantityPair> = named.comparison.quantities.iter().filter(judged).collect();
    if pairs.is_empty() {
        return Ok(None);
    }
    let over = |pair: &QuantityPair, difference: Option<f64>| Some(difference? / pair.allowed?);
    let count = pairs.len() as f64;
    let area = [LEFT, 24.0, WIDTH, ROW * count];
    let most = pairs
        .iter()
        .filter_map(|pair| over(pair, pair.difference))
        .fold(1.0, f64::max);
    let x = Axis::across(area, LEAST, 2.0 * most).logarithmic();
    // Downwards and so without ticks: rows have names.
    let mut plot = Plot::with_grid(area, x, Axis::upwards(area, count, 0.0));
    plot.upright(1.0, [0.0, count], INK);
    for (index, pair) in pairs.iter().enumerate() {
        let at = index as f64 + 0.5;
        for (difference, colour, radius) in [
            (pair.control_difference, SOFT, 2.4),
            (
                pair.difference,
                if over(pair, pair.difference) > Some(1.0) {
                    VERMILION
                } else {
                    BLUE
                },
                3.2,
            ),
        ] {
            if let Some(share) = over(pair, difference) {
                plot.dot([share.max(LEAST), at], colour, radius, 1.0);
            }
        }
    }
    let mut svg = plot.svg(["difference over what is allowed", ""]);
    for (index, pair) in pairs.iter().enumerate() {
        let at = [LEFT - 8.0, area[1] + ROW * (index as f64 + 0.5) + 4.5];
        svg += &text(at, "end", &pair.key);
    }
    svg += &coloured(BLUE, [LEFT + 4.0, 16.0], "start", "A − B");
    svg += &coloured(
        SOFT,
        [LEFT + 60.0, 16.0],
        "start",
        "within the control pair",
    );
    let rows = pairs.iter().map(|pair| {
        let number = |of: Option<f64>| of.map_or(String::new(), |of| of.to_string());
        let mut row = vec![pair.key.clone(), pair.unit.clone()];
        row.extend(
            [
                pair.a,
                pair.b,
                pair.difference,
                pair.allowed,
                pair.control_difference,
            ]
            .map(number),
        );
        row
    });
    let head = [
        "quantity",
        "unit",
        "A",
        "B",
        "difference",
        "allowed",
        "difference within the control pair",
    ];
    Ok(Some(Figure {
        name: "differences".to_owned(),
        caption: format!(
            "{}: |A − B| over what is allowed, on a logarithmic axis; black: all that is allowed. Vermilion: more. Grey: the same of two runs of one \
             engine. At the left end: a thousandth and less.",
            named.title
        ),
        svg: whole(
            [LEFT + WIDTH + 20.0, area[3] + 70.0],
            "Differences over what is allowed",
            &svg,
        ),
        csv: table(&head, rows)?,
    }))
}

/// Quantiles that are drawn.
const QUANTILES: usize = 100;

/// Normal forces of the last moment in YADE over those in the native engine, quantile by quantile.
fn quantiles(runs: &Runs) -> Result<Option<Figure>, Error> {
    const SIZE: [f64; 2] = [520.0, 420.0];
    let of = |run: &crate::run::folder::RunFolder| -> Vec<f64> {
        let forces = run.last.contacts.iter().map(|contact| contact.normal_force);
        let mut forces: Vec<f64> = forces.filter(|force| *force > 0.0).collect();
        forces.sort_by(f64::total_cmp);
        let at = |share: f64| forces.get((share * forces.len() as f64) as usize).copied();
        (0..QUANTILES)
            .filter_map(|index| at((index as f64 + 0.5) / QUANTILES as f64))
            .collect()
    };
    let native = of(&runs.native);
    let engines = [
        ("YADE, sorted loop", &runs.yade, VERMILION),
        ("YADE, ordinary loop", &runs.ordinary, BLUE),
    ];
    let drawn: Vec<(&str, Vec<f64>, &str)> = engines
        .into_iter()
        .filter_map(|(name, run, colour)| Some((name, of(run.as_ref()?), colour)))
        .collect();
    let all = || {
        native
            .iter()
            .chain(drawn.iter().flat_map(|(_, of, _)| of))
            .copied()
    };
    let (low, high) = all().fold((f64::INFINITY, 0.0f64), |(low, high), of| {
        (low.min(of), high.max(of))
    });
    if native.is_empty() || drawn.is_empty() || low >= high {
        return Ok(None);
    }
    let area = [70.0, 14.0, 436.0, 356.0];
    let low = low.max(1.0e-4 * high);
    let axis = |axis: Axis| axis.logarithmic();
    let mut plot = Plot::with_grid(
        area,
        axis(Axis::across(area, low, 1.2 * high)),
        axis(Axis::upwards(area, low, 1.2 * high)),
    );
    plot.curve(|force| force, Stroke::whole(INK));
    let mut rows = Vec::new();
    for (name, other, colour) in &drawn {
        for (index, (x, y)) in native.iter().zip(other).enumerate() {
            if *x >= low && *y >= low {
                plot.dot([*x, *y], colour, 2.6, 0.7);
            }
            let mut row = vec![(*name).to_owned()];
            row.extend(cells([(index as f64 + 0.5) / QUANTILES as f64, *x, *y]));
            rows.push(row);
        }
    }
    let mut svg = plot.svg(["normal force in native, N", "in YADE, N"]);
    for (line, (name, _, colour)) in drawn.iter().enumerate() {
        svg += &coloured(
            colour,
            [area[0] + 10.0, area[1] + 18.0 + 16.0 * line as f64],
            "start",
            name,
        );
    }
    Ok(Some(Figure {
        name: "force-quantiles".to_owned(),
        caption: "Normal forces of the last moment, quantile by quantile: the same distribution lies on the line, the same bits do so exactly.".to_owned(),
        svg: whole(SIZE, "Quantiles of the normal forces in two engines", &svg),
        csv: table(&["engine", "quantile", "native (N)", "YADE (N)"], rows)?,
    }))
}
