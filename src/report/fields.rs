//! Maps of fields: closed lines about the parts of a grid above a level, by marching squares, and colours whose lightness rises
//! evenly, so that the order is seen without telling hues apart. With them the stress bulbs under a load.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::svg::{APART, Area, Axes, INK, Scale, framed, line, on_white, printed, text, whole};
use crate::document::{Colour, Drawing, Table};
use crate::paper::continuum::table::Setup;
use crate::paper::continuum::{Field, Model};

/// Values on a square grid of nodes, in rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    nodes: usize,
    values: Vec<f64>,
}

/// Two nodes side by side, the lesser first.
type Edge = [usize; 2];

impl Grid {
    /// `value` at column and row of `nodes`² nodes. The outermost ones count as below every level,
    /// so that all lines close; what is not a number does too.
    pub fn new(nodes: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let outer = |index: usize| index == 0 || index + 1 == nodes;
        let values = (0..nodes * nodes).map(|node| {
            let (column, row) = (node % nodes, node / nodes);
            let value = value(column, row);
            match outer(column) || outer(row) || value.is_nan() {
                true => f64::NEG_INFINITY,
                false => value,
            }
        });
        Grid {
            nodes,
            values: values.collect(),
        }
    }

    /// The borders of {value ≥ level} as closed lines of (column, row), with the higher side always
    /// on the same hand: holes are as the non-zero filling rule wants them.
    pub fn contours(&self, level: f64) -> Vec<Vec<[f64; 2]>> {
        let mut next = self.steps(level);
        let mut lines = Vec::new();
        while let Some((&first, _)) = next.first_key_value() {
            let mut line = Vec::new();
            let mut edge = first;
            while let Some(following) = next.remove(&edge) {
                line.push(self.crossing(edge, level));
                edge = following;
            }
            lines.push(line);
        }
        lines
    }

    /// From each edge that the border crosses to the one that it crosses next.
    fn steps(&self, level: f64) -> BTreeMap<Edge, Edge> {
        let mut next = BTreeMap::new();
        for row in 0..self.nodes - 1 {
            for column in 0..self.nodes - 1 {
                let low = row * self.nodes + column;
                let high = low + self.nodes;
                let corners = [low, low + 1, high + 1, high];
                self.cross_cell(corners, level, &mut next);
            }
        }
        next
    }

    /// Round the cell, the border goes from where one leaves the higher part to where one enters it
    /// again. The neighbour goes round the other way, so each edge is left in one cell only.
    fn cross_cell(&self, corners: [usize; 4], level: f64, next: &mut BTreeMap<Edge, Edge>) {
        let is_high = |corner: usize| self.values[corners[corner % 4]] >= level;
        let edge = |corner: usize| {
            let (a, b) = (corners[corner % 4], corners[(corner + 1) % 4]);
            [a.min(b), a.max(b)]
        };
        for leaving in (0..4).filter(|&corner| is_high(corner) && !is_high(corner + 1)) {
            let entering = (leaving + 1..leaving + 4).find(|&corner| is_high(corner + 1));
            if let Some(entering) = entering {
                next.insert(edge(leaving), edge(entering));
            }
        }
    }

    /// Where the level lies on an edge, by linear interpolation.
    fn crossing(&self, [a, b]: Edge, level: f64) -> [f64; 2] {
        let (low, high) = (self.values[a], self.values[b]);
        let share = match low.is_infinite() {
            true => 1.0,
            false => (level - low) / (high - low),
        };
        let place = |node: usize| [(node % self.nodes) as f64, (node / self.nodes) as f64];
        let (from, to) = (place(a), place(b));
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    }
}

/// Anchors from low to high: viridis.
pub const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];
/// From white to the blue of the charts, under lines and words.
const BLUES: [[f64; 3]; 3] = [
    [255.0, 255.0, 255.0],
    [172.0, 208.0, 231.0],
    [66.0, 150.0, 199.0],
];

/// The colour at a share of such a scale, in [0, 1].
pub fn colour(anchors: &[[f64; 3]], share: f64) -> String {
    let place = (anchors.len() - 1) as f64 * share.clamp(0.0, 1.0);
    let index = (place as usize).min(anchors.len() - 2);
    let part = place - index as f64;
    let [red, green, blue] = [0, 1, 2].map(|channel| {
        let (from, to) = (anchors[index][channel], anchors[index + 1][channel]);
        (from + part * (to - from)) as u8
    });
    format!("#{red:02x}{green:02x}{blue:02x}")
}

const AREA: Area = [76.0, 70.0, 660.0, 506.0];
/// Half the width and the depth that are shown, m.
const SHOWN: [f64; 2] = [0.3, 0.46];
/// σ_p,zz over p, falling.
const LEVELS: [f64; 8] = [0.8, 0.5, 0.3, 0.2, 0.15, 0.1, 0.05, 0.03];
/// Nodes of the grid in each direction; even, so that none lies in the middle.
const BULB_NODES: usize = 320;
/// Lines are labelled where they cross a ray from the load that leans so much to the left, rad.
const LEAN: f64 = 0.42;

/// σ_p,zz/p in the half-space under the setup's load, with its control points.
pub fn bulbs(setup: &Setup) -> Drawing {
    let field = Field::new(Model::HalfSpace, setup.load);
    // A little beyond the frame, so that lines which leave it are cut there and closed outside.
    let place = |[column, row]: [f64; 2]| {
        let share = |index: f64| index / (BULB_NODES - 1) as f64;
        [
            1.04 * SHOWN[0] * (2.0 * share(column) - 1.0),
            1.04 * SHOWN[1] * share(row),
        ]
    };
    let grid = Grid::new(BULB_NODES, |column, row| {
        let [x, z] = place([column as f64, row as f64]);
        field.stress(x, z.max(1e-9)).zz / setup.load.pressure
    });
    let [left, top, width, height] = AREA;
    let x = Scale::linear([-SHOWN[0], SHOWN[0]], [left, left + width]);
    let z = Scale::linear([0.0, SHOWN[1]], [top, top + height]);
    let on = |[at, depth]: [f64; 2]| [x.place(at), z.place(depth)];
    let heads = ["what", "stress of the load over p", "x, m", "depth, m"];
    let mut table = Table::new("figure-1", "", &heads);
    let (mut svg, mut labels) = (String::new(), String::new());
    for (index, level) in LEVELS.iter().enumerate().rev() {
        let mut lines = grid.contours(*level);
        for point in lines.iter_mut().flatten() {
            *point = place(*point);
        }
        let closed = |contour: &Vec<[f64; 2]>| line(contour.iter().map(|place| on(*place))) + "Z";
        let path: String = lines.iter().map(closed).collect();
        let share = (LEVELS.len() - index) as f64 / LEVELS.len() as f64;
        let fill = colour(&BLUES, share);
        let _ = writeln!(
            svg,
            "<path fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"1\" d=\"{path}\"/>"
        );
        let ray = |[x, z]: &[f64; 2]| (z.atan2(-x) - (0.5 * std::f64::consts::PI - LEAN)).abs();
        // Not on the edges that close lines which leave the frame.
        let within =
            |[x, z]: &&[f64; 2]| *z > 0.005 && *z < SHOWN[1] - 0.015 && x.abs() < SHOWN[0] - 0.02;
        let at = lines.iter().flatten().filter(within);
        if let Some(at) = at.min_by(|a, b| ray(a).total_cmp(&ray(b))) {
            let [x, y] = on(*at);
            labels += &text([x, y + 4.5], "middle", &printed(*level, 6));
        }
        for (number, places) in lines.iter().enumerate() {
            for [x, z] in places {
                let what = format!("line {}", number + 1);
                table.row([what.into(), (*level).into(), (*x).into(), (*z).into()]);
            }
        }
    }
    svg += &on_white(&labels);
    let axes: Axes<'_> = [(&x, &x.ticks(APART[0])), (&z, &z.ticks(APART[1]))];
    let words = ["distance from the middle of the load, m", "depth, m"];
    let (mut svg, floor) = framed("bulbs", AREA, &svg, axes, words, left - 46.0);
    svg += &load(setup, &x, top);
    for (index, point) in setup.points.iter().enumerate() {
        // In turn below and above, for points side by side.
        let beside = if index % 2 == 0 { 19.0 } else { -10.0 };
        let value = field.stress(point.offset, point.depth).zz / setup.load.pressure;
        let [at, depth] = on([point.offset, point.depth]);
        let words = format!("{} {value:.3}", point.name);
        let _ = write!(
            svg,
            "<circle cx=\"{at:.1}\" cy=\"{depth:.1}\" r=\"4.5\" fill=\"{}\" stroke=\"#fff\" stroke-width=\"1.5\"/>{}",
            Colour::Vermilion.hex(),
            on_white(&text([at, depth + beside], "middle", &words))
        );
        let what = format!("point {}", point.name);
        let row = [value, point.offset, point.depth].map(Into::into);
        table.row([what.into()].into_iter().chain(row));
    }
    let words = format!(
        "Vertical stress of the load over its pressure, σ_p,zz/p, in the half-space; p = {} kPa over 2a = {} m",
        printed(1e-3 * setup.load.pressure, 6),
        printed(2.0 * setup.load.half_width, 6)
    );
    svg += &text([left, 24.0], "start", &words);
    let size = [left + width + 24.0, floor];
    Drawing {
        caption: "Stress bulbs of the continuum under the load".to_owned(),
        svg: whole(size, "Stress bulbs under a strip load", &svg),
        table,
    }
}

/// The load on the surface: arrows on its width.
fn load(setup: &Setup, x: &Scale, surface: f64) -> String {
    let [from, to] = [-1.0, 1.0].map(|side| x.place(side * setup.load.half_width));
    let [upper, lower] = [surface - 26.0, surface - 1.0];
    let mut path = format!("M{from:.1} {upper:.1}H{to:.1}");
    for index in 0..5 {
        let at = from + (to - from) * f64::from(index) / 4.0;
        let _ = write!(
            path,
            "M{at:.1} {upper:.1}V{lower:.1}l-2.4 -7M{at:.1} {lower:.1}l2.4 -7"
        );
    }
    let colour = Colour::Vermilion.hex();
    format!("<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" d=\"{path}\"/>")
        + &text([to + 10.0, surface - 16.0], "start", "p")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area within a closed line, with the sign of its sense.
    fn twice_area(line: &[[f64; 2]]) -> f64 {
        let next = line.iter().cycle().skip(1);
        let pairs = line.iter().zip(next);
        pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
    }

    #[test]
    fn a_ring_has_two_borders_of_opposite_sense() {
        let distance = |column: usize, row: usize| {
            let [x, z] = [column, row].map(|index| index as f64 - 50.0);
            x.hypot(z)
        };
        let height = |column, row| 10.0 - (distance(column, row) - 30.0f64).abs();
        let lines = Grid::new(101, height).contours(0.0);
        let areas: Vec<f64> = lines.iter().map(|line| 0.5 * twice_area(line)).collect();
        assert_eq!(areas.len(), 2);
        let [outer, inner] = [40f64, 20.0].map(|radius| std::f64::consts::PI * radius * radius);
        let (low, high) = (areas[0].min(areas[1]), areas[0].max(areas[1]));
        assert!((high / outer - 1.0).abs() < 1e-3, "{areas:?}");
        assert!((-low / inner - 1.0).abs() < 1e-3, "{areas:?}");
    }

    #[test]
    fn what_is_high_everywhere_is_closed_by_the_outermost_nodes() {
        let lines = Grid::new(5, |_, _| 1.0).contours(0.0);
        assert_eq!(lines.len(), 1);
        assert!(twice_area(&lines[0]) > 0.0);
    }

    #[test]
    fn nothing_high_has_no_border() {
        assert!(Grid::new(5, |_, _| f64::NAN).contours(0.0).is_empty());
    }
}
