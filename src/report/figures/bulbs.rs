//! Figure 1's content: the half-space's stress under the load as bulbs.

use std::fmt::Write;

use crate::error::Error;
use crate::paper::continuum::table::Setup;
use crate::paper::continuum::{Field, Model};
use crate::report::axis::{Area, Axis, printed};
use crate::report::contours::Grid;
use crate::report::figure::Figure;
use crate::report::figure_files::table;
use crate::report::frame::{INK, VERMILION, border, line, text, whole};
use crate::report::shades::shade;

const SIZE: [f64; 2] = [760.0, 640.0];
const AREA: Area = [76.0, 70.0, 660.0, 506.0];
/// Half the width and the depth that are shown, m.
const REACH: [f64; 2] = [0.3, 0.46];
/// σ_p,zz over p, falling.
const LEVELS: [f64; 9] = [0.8, 0.6, 0.4, 0.3, 0.2, 0.15, 0.1, 0.05, 0.03];
/// Nodes of the grid in each direction; even, so that none lies in the middle.
const NODES: usize = 320;
/// Lines are labelled where they cross a ray from the load that leans so much to the left, rad.
const LEAN: f64 = 0.42;

/// σ_p,zz/p in the half-space under the setup's load, with its control points.
pub fn figure(setup: &Setup) -> Result<Figure, Error> {
    let field = Field::new(Model::HalfSpace, setup.load);
    // A little beyond the frame, so that lines which leave it are cut there and closed outside.
    let place = |[column, row]: [f64; 2]| {
        let share = |index: f64| index / (NODES - 1) as f64;
        [
            1.04 * REACH[0] * (2.0 * share(column) - 1.0),
            1.04 * REACH[1] * share(row),
        ]
    };
    let grid = Grid::new(NODES, |column, row| {
        let [x, z] = place([column as f64, row as f64]);
        field.stress(x, z.max(1e-9)).zz / setup.load.pressure
    });
    let x = Axis::across(AREA, -REACH[0], REACH[0]);
    let z = Axis {
        low: 0.0,
        high: REACH[1],
        from: AREA[1],
        to: AREA[1] + AREA[3],
        logarithmic: false,
    };
    let on = |[at, depth]: [f64; 2]| [x.place(at), z.place(depth)];
    let [left, top, width, height] = AREA;
    let mut svg = format!(
        "<defs><clipPath id=\"bulbs\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath></defs>\n\
         <g clip-path=\"url(#bulbs)\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
        shade(0.0)
    );
    let (mut labels, mut rows) = (String::new(), Vec::new());
    for (index, level) in LEVELS.iter().enumerate().rev() {
        let lines: Vec<Vec<[f64; 2]>> = grid
            .contours(*level)
            .into_iter()
            .map(|line| line.into_iter().map(place).collect())
            .collect();
        let path: String = lines
            .iter()
            .map(|places| line(places.iter().map(|place| on(*place))) + "Z")
            .collect();
        let share = (LEVELS.len() - index) as f64 / LEVELS.len() as f64;
        let _ = writeln!(
            svg,
            "<path fill=\"{}\" stroke=\"{INK}\" stroke-width=\"1\" d=\"{path}\"/>",
            shade(share)
        );
        let ray = |[x, z]: &[f64; 2]| (z.atan2(-x) - (0.5 * std::f64::consts::PI - LEAN)).abs();
        // Not on the edges that close lines which leave the frame.
        let within =
            |[x, z]: &&[f64; 2]| *z > 0.005 && *z < REACH[1] - 0.015 && x.abs() < REACH[0] - 0.02;
        let at = lines.iter().flatten().filter(within);
        if let Some(at) = at.min_by(|a, b| ray(a).total_cmp(&ray(b))) {
            let [x, y] = on(*at);
            labels += &text([x, y + 4.5], "middle", &printed(*level));
        }
        for (number, places) in lines.iter().enumerate() {
            for [x, z] in places {
                rows.push([
                    format!("line {}", number + 1),
                    format!("{level}"),
                    format!("{x:.6}"),
                    format!("{z:.6}"),
                ]);
            }
        }
    }
    let _ = writeln!(
        svg,
        "</g><g font-size=\"12\" stroke=\"#fff\" stroke-width=\"3.5\" stroke-linejoin=\"round\" paint-order=\"stroke\">{labels}</g>"
    );
    svg += &load(setup, &x, top);
    for (index, point) in setup.points.iter().enumerate() {
        // In turn below and above, for points side by side.
        let beside = if index % 2 == 0 { 19.0 } else { -10.0 };
        let value = field.stress(point.offset, point.depth).zz / setup.load.pressure;
        let [at, depth] = on([point.offset, point.depth]);
        let _ = write!(
            svg,
            "<circle cx=\"{at:.1}\" cy=\"{depth:.1}\" r=\"4.5\" fill=\"{VERMILION}\" stroke=\"#fff\" stroke-width=\"1.5\"/>\
             <g stroke=\"#fff\" stroke-width=\"3.5\" stroke-linejoin=\"round\" paint-order=\"stroke\">{}</g>",
            text(
                [at, depth + beside],
                "middle",
                &format!("{} {value:.3}", point.name)
            )
        );
        rows.push([
            format!("point {}", point.name),
            format!("{value}"),
            format!("{}", point.offset),
            format!("{}", point.depth),
        ]);
    }
    svg += &border(
        AREA,
        &x,
        &z,
        ["distance from the middle of the load, m", "depth, m"],
    );
    svg += &text(
        [left, 24.0],
        "start",
        &format!(
            "Vertical stress of the load over its pressure, σ_p,zz/p, in the half-space; p = {} kPa over 2a = {} m",
            printed(1e-3 * setup.load.pressure),
            printed(2.0 * setup.load.half_width)
        ),
    );
    Ok(Figure {
        name: "figure-1".to_owned(),
        caption: "Stress bulbs of the continuum under the load".to_owned(),
        svg: whole(SIZE, "Stress bulbs under a strip load", &svg),
        csv: table(
            &[
                "what",
                "stress of the load over p (1)",
                "x (m)",
                "depth (m)",
            ],
            rows,
        )?,
    })
}

/// The load on the surface: arrows on its width.
fn load(setup: &Setup, x: &Axis, surface: f64) -> String {
    let [from, to] = [-1.0, 1.0].map(|side| x.place(side * setup.load.half_width));
    let mut svg = format!(
        "<path stroke=\"{VERMILION}\" stroke-width=\"2\" d=\"M{from:.1} {:.1}H{to:.1}\"/>",
        surface - 26.0
    );
    for index in 0..5 {
        let at = from + (to - from) * f64::from(index) / 4.0;
        let _ = write!(
            svg,
            "<path stroke=\"{VERMILION}\" stroke-width=\"1.6\" d=\"M{at:.1} {:.1}V{:.1}\"/>\
             <path fill=\"{VERMILION}\" d=\"M{at:.1} {:.1}l-3.2 -8h6.4Z\"/>",
            surface - 26.0,
            surface - 7.0,
            surface - 1.0
        );
    }
    svg + &text([to + 10.0, surface - 16.0], "start", "p")
}
