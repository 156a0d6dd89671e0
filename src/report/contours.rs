//! Closed lines about the parts of a grid above a level, by marching squares.

use std::collections::BTreeMap;

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
            if outer(column) || outer(row) || value.is_nan() {
                f64::NEG_INFINITY
            } else {
                value
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
        let share = if low.is_infinite() {
            1.0
        } else {
            (level - low) / (high - low)
        };
        let place = |node: usize| [(node % self.nodes) as f64, (node / self.nodes) as f64];
        let (from, to) = (place(a), place(b));
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area within a closed line, with the sign of its sense.
    fn twice_area(line: &[[f64; 2]]) -> f64 {
        let next = line.iter().cycle().skip(1);
        line.iter()
            .zip(next)
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
            .sum()
    }

    #[test]
    fn a_ring_has_two_borders_of_opposite_sense() {
        let distance = |column: usize, row: usize| {
            let [x, z] = [column, row].map(|index| index as f64 - 50.0);
            x.hypot(z)
        };
        let grid = Grid::new(101, |column, row| {
            10.0 - (distance(column, row) - 30.0).abs()
        });
        let areas: Vec<f64> = grid
            .contours(0.0)
            .iter()
            .map(|line| 0.5 * twice_area(line))
            .collect();
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
