//! The map of what the published figures depend on as a page.

mod axes;
mod curves;
mod grid;
mod numbers;
mod words;

use serde::Serialize;

use self::curves::{COLOURS, Curves, Line};
use self::words::{class, in_unit, with_unit};
use super::figure::{Figure, Page};
use super::shell;
use crate::error::Error;
use crate::study::sensitivity::bearing::{Bearing, Curve};
use crate::study::sensitivity::choices::Axis;
use crate::study::sensitivity::judge::Judged;
use crate::study::sensitivity::record::{Joint, Point, Sensitivity};
use evidence::Interval;

const PAGE: &str = include_str!("sensitivity.html");
/// Pressures below this are as good as none, kPa.
const FAINT: f64 = 0.2;

/// What the template is given.
#[derive(Debug, Serialize)]
struct Given<'a> {
    s: &'a Sensitivity,
    word: &'static str,
    grid: Option<Figure>,
    axes: Option<Figure>,
    pushed: Option<Figure>,
    stood: Option<Figure>,
    figures: Vec<FigureRow>,
    joint: Vec<JointRow>,
    groups: Vec<Group>,
    rest: Vec<RestRow>,
    standing: Vec<StandingRow>,
}

#[derive(Debug, Serialize)]
struct FigureRow {
    title: &'static str,
    published: String,
    reason: &'static str,
    comes_out: Vec<String>,
    undecided: usize,
    does_not: usize,
    not_made: usize,
    unit: &'static str,
}

#[derive(Debug, Serialize)]
struct JointRow {
    title: &'static str,
    comes_out: Vec<String>,
    possible: Vec<String>,
    near: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Group {
    title: &'static str,
    why: &'static str,
    rows: Vec<SettingRow>,
}

#[derive(Debug, Serialize)]
struct SettingRow {
    number: usize,
    name: String,
    clouds: usize,
    reached: String,
    failed: Vec<String>,
    depth: String,
    cells: Vec<Cell>,
}

#[derive(Debug, Serialize)]
struct Cell {
    class: &'static str,
    value: String,
    range: String,
    change: String,
}

#[derive(Debug, Serialize)]
struct RestRow {
    depth: String,
    theory: String,
    pressure: String,
    angle: String,
    speeds: Vec<(String, String)>,
}

#[derive(Debug, Serialize)]
struct StandingRow {
    name: String,
    reached: String,
    depth: String,
    levels: Vec<(String, String, String)>,
}

/// A page of its own.
pub fn page(record: &Sensitivity) -> Result<Page, Error> {
    let (pushed, stood) = (pushed(&record.bearing), stood(&record.bearing));
    let given = Given {
        s: record,
        word: if record.complete {
            "what the figures depend on"
        } else {
            "what the figures depend on, incomplete"
        },
        grid: drawn(
            "speed-and-damping",
            "Ours in kPa for stresses, mm for the height; damping is that of pouring and of loading. Last panel: members in which the punch got its force.",
            grid::svg(record),
            numbers::of_settings(record, |axis| axis == Axis::SpeedAndDamping),
        )?,
        axes: drawn(
            "choices",
            "Ours over published with 95 % intervals; shaded: what counts as the same. Hollow: fewer than 90 % of the punches got the force, whose number \
             stands beside the name. A triangle points to an estimate beyond the column.",
            axes::svg(record),
            numbers::of_settings(record, |axis| axis != Axis::SpeedAndDamping),
        )?,
        pushed: drawn(
            "pushed-through",
            "Punches that go on whatever the force is: mean pressure in windows of depth, with 95 % intervals over clouds. Dashed grey: bearing capacity at rest.",
            pushed.svg(),
            numbers::of_curves(&pushed),
        )?,
        stood: drawn(
            "left-standing",
            &format!(
                "Mean pressure on the punch after it stopped; the published load is {} Pa at the start.",
                crate::paper::short(record.bearing.wanted)
            ),
            stood.svg(),
            numbers::of_curves(&stood),
        )?,
        figures: figures(record),
        joint: record.joint.iter().map(|of| joint(record, of)).collect(),
        groups: groups(record),
        rest: rest(&record.bearing),
        standing: record.bearing.standing.iter().map(standing).collect(),
    };
    let html = shell::render(&[("sensitivity.html", PAGE)], &given)?;
    let figures = [given.grid, given.axes, given.pushed, given.stood];
    Ok(Page {
        html,
        figures: figures.into_iter().flatten().collect(),
    })
}

/// A figure, unless there was nothing to draw.
fn drawn(
    name: &str,
    caption: &str,
    svg: String,
    csv: Result<String, Error>,
) -> Result<Option<Figure>, Error> {
    if svg.is_empty() {
        return Ok(None);
    }
    Ok(Some(Figure {
        name: name.to_owned(),
        caption: caption.to_owned(),
        svg,
        csv: csv?,
    }))
}

fn pushed(bearing: &Bearing) -> Curves {
    let kilo = |value: f64| 1.0e-3 * value;
    let mut lines: Vec<Line> = bearing
        .through
        .iter()
        .filter(|curve| curve.friction == 0.0 && curve.alpha == base_alpha(bearing))
        .zip(COLOURS)
        .map(|(curve, colour)| line(curve, format!("{} m/s", curve.speed), colour, 100.0))
        .collect();
    let deepest = lines
        .iter()
        .flat_map(|line| &line.points)
        .fold(0.0f64, |most, point| most.max(point.0));
    let flat = |name: &str, pressure: f64| Line {
        name: name.to_owned(),
        colour: COLOURS[6],
        dashed: true,
        points: [0.0, deepest].map(|x| (x, [pressure; 3])).to_vec(),
    };
    lines.push(flat("published load", kilo(bearing.wanted)));
    let theory = |degrees: f64, colour| Line {
        name: format!("at rest, {degrees:.1}°"),
        colour,
        dashed: true,
        points: (0..=40)
            .map(|index| {
                let depth = 0.01 * deepest * f64::from(index) / 40.0;
                let borne = bearing.soil.bears(depth, degrees.to_radians());
                (100.0 * depth, [kilo(borne); 3])
            })
            .collect(),
    };
    lines.push(theory(bearing.angle.to_degrees(), "#5f6368"));
    Curves {
        x: "depth of the punch, cm".to_owned(),
        y: "mean pressure on the punch, kPa".to_owned(),
        logarithmic: false,
        lowest: FAINT,
        lines: if bearing.through.is_empty() {
            Vec::new()
        } else {
            lines
        },
    }
}

/// The damping of most curves: that of the base scene.
fn base_alpha(bearing: &Bearing) -> f64 {
    bearing
        .through
        .first()
        .map_or(f64::NAN, |curve| curve.alpha)
}

fn stood(bearing: &Bearing) -> Curves {
    let lines = bearing.standing.iter().zip(COLOURS);
    Curves {
        x: "time after the punch stopped, s".to_owned(),
        y: "mean pressure on the punch, kPa".to_owned(),
        logarithmic: true,
        lowest: FAINT,
        lines: lines
            .map(|(curve, colour)| line(curve, curve.name.clone(), colour, 1.0))
            .collect(),
    }
}

fn line(curve: &Curve, name: String, colour: &'static str, scale: f64) -> Line {
    let points = curve.levels.iter().filter_map(|level| {
        let pressure = level.pressure?.over(1.0e3);
        let of = [pressure.estimate, pressure.low, pressure.high];
        Some((scale * level.at, of))
    });
    Line {
        name,
        colour,
        dashed: false,
        points: points.collect(),
    }
}

/// What a setting is called away from its axis.
fn named(record: &Sensitivity, numbers: &[usize]) -> Vec<String> {
    let points = numbers.iter().filter_map(|number| {
        let point = record.points.get(number.checked_sub(1)?)?;
        Some(match point.setting.axis {
            Axis::SpeedAndDamping | Axis::Friction | Axis::Combined => point.setting.name.clone(),
            axis => format!("{}: {}", axis.title(), point.setting.name),
        })
    });
    points.collect()
}

fn figures(record: &Sensitivity) -> Vec<FigureRow> {
    let rows = record.figures.iter().map(|figure| FigureRow {
        title: figure.title,
        published: format!(
            "{} ± {}",
            in_unit(figure.value, figure.unit),
            with_unit(figure.tolerance, figure.unit)
        ),
        reason: figure.reason,
        comes_out: named(record, &figure.comes_out),
        undecided: figure.undecided.len(),
        does_not: figure.does_not.len(),
        not_made: figure.not_made.len(),
        unit: figure.unit,
    });
    rows.collect()
}

fn joint(record: &Sensitivity, joint: &Joint) -> JointRow {
    JointRow {
        title: joint.title,
        comes_out: named(record, &joint.comes_out),
        possible: named(record, &joint.possible),
        near: named(record, &joint.near),
    }
}

fn groups(record: &Sensitivity) -> Vec<Group> {
    let groups = Axis::ALL.into_iter().map(|axis| Group {
        title: axis.title(),
        why: axis.why(),
        rows: record
            .points
            .iter()
            .filter(|point| point.setting.axis == axis)
            .map(|point| setting(record, point))
            .collect(),
    });
    groups.filter(|group| !group.rows.is_empty()).collect()
}

fn setting(record: &Sensitivity, point: &Point) -> SettingRow {
    let cells = record.figures.iter().zip(&point.figures);
    SettingRow {
        number: point.number,
        name: point.setting.name.clone(),
        clouds: point.made,
        reached: format!("{} of {}", point.endings.reached, point.endings.all()),
        failed: point
            .endings
            .failed
            .iter()
            .map(|(reason, count)| format!("{count} failed: {reason}"))
            .chain(
                (point.endings.not_settled > 0)
                    .then(|| format!("{} did not settle", point.endings.not_settled)),
            )
            .collect(),
        depth: point
            .depth
            .map_or("–".to_owned(), |of| format!("{:.1}", 1.0e3 * of.estimate)),
        cells: cells
            .map(|(figure, judged)| cell(judged, figure.unit))
            .collect(),
    }
}

fn cell(judged: &Judged, unit: &str) -> Cell {
    let range = |of: Interval| format!("{} to {}", in_unit(of.low, unit), in_unit(of.high, unit));
    let flag = if judged.conditional { "*" } else { "" };
    Cell {
        class: class(judged),
        value: judged.value.map_or("–".to_owned(), |of| {
            format!("{}{flag}", in_unit(of.estimate, unit))
        }),
        range: judged.value.map_or(String::new(), range),
        change: judged.change.map_or(String::new(), |of| {
            format!(
                "against the base, same clouds: {} ({})",
                in_unit(of.estimate, unit),
                range(of)
            )
        }),
    }
}

fn kilopascal(of: Option<Interval>) -> String {
    of.map_or("–".to_owned(), |of| {
        let of = of.over(1.0e3);
        format!("{:.2} ({:.2} to {:.2})", of.estimate, of.low, of.high)
    })
}

fn rest(bearing: &Bearing) -> Vec<RestRow> {
    let rows = bearing.at_rest.iter().map(|row| RestRow {
        depth: format!("{:.1}", 100.0 * row.depth),
        theory: format!("{:.2}", 1.0e-3 * row.theory),
        pressure: kilopascal(row.pressure),
        angle: row.angle.map_or("–".to_owned(), |of| {
            format!("{:.1} ({:.1} to {:.1})", of.estimate, of.low, of.high)
        }),
        speeds: row
            .speeds
            .iter()
            .map(|speed| {
                let curve = bearing.through.iter().find(|curve| {
                    curve.speed == *speed
                        && curve.friction == 0.0
                        && curve.alpha == base_alpha(bearing)
                });
                let level = curve.and_then(|curve| {
                    let mut levels = curve.levels.iter();
                    levels.find(|level| (level.at - row.depth).abs() < 1.0e-9)
                });
                (
                    format!("{speed} m/s"),
                    kilopascal(level.and_then(|level| level.pressure)),
                )
            })
            .collect(),
    });
    rows.collect()
}

fn standing(curve: &Curve) -> StandingRow {
    let levels = curve.levels.iter().map(|level| {
        (
            format!("{:.4}", level.at),
            kilopascal(level.pressure),
            kilopascal(level.on_floor),
        )
    });
    StandingRow {
        name: curve.name.clone(),
        reached: format!("{} of {}", curve.reached, curve.clouds),
        depth: curve.depth.map_or("–".to_owned(), |of| {
            let of = of.over(1.0e-3);
            format!("{:.1} ({:.1} to {:.1})", of.estimate, of.low, of.high)
        }),
        levels: levels.collect(),
    }
}
