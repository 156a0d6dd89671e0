//! One quantity's difference from the reference, a row a method, with the margins shaded.

use std::fmt::Write;

use crate::error::Error;
use crate::report::figure::cells;
use crate::report::figure_files::table;
use crate::report::frame::{escaped, whole};
use evidence::Interval;
use evidence::equivalence::Finding;

/// A method's row.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Number and name.
    pub name: String,
    /// Difference over margin with its 90 % interval; none where it was not measured.
    pub difference: Option<Interval>,
    /// Against the margin.
    pub finding: Option<Finding>,
}

const WIDTH: f64 = 540.0;
const NAMES: f64 = 240.0;
const RIGHT: f64 = 10.0;
const TOP: f64 = 6.0;
const ROW: f64 = 15.0;
const BOTTOM: f64 = 34.0;
/// Margins to each side.
const REACH: f64 = 4.0;
/// The drawing's own, so that its file needs no page.
const STYLE: &str = ".forest .margin { fill: #e8f3ee; } .forest .zero { stroke: #8b9197; } .forest .none { fill: #5f6368; } \
    .forest path { stroke-width: 1.6; fill: none; } .forest .same { stroke: #00674f; } .forest .apart { stroke: #a33b00; } \
    .forest .open { stroke: #5f6368; } .forest circle.same, .forest .same.tip { fill: #00674f; } \
    .forest circle.apart, .forest .apart.tip { fill: #a33b00; } .forest circle.open, .forest .open.tip { fill: #5f6368; }";

/// The panel as an SVG element; `axis` says what the margin is.
pub fn svg(rows: &[Row], axis: &str) -> String {
    let height = TOP + ROW * rows.len() as f64 + BOTTOM;
    let floor = height - BOTTOM;
    let place = |value: f64| {
        let share = (value.clamp(-REACH, REACH) + REACH) / (2.0 * REACH);
        NAMES + share * (WIDTH - RIGHT - NAMES)
    };
    let mut svg = format!("<style>{STYLE}</style><g class=\"forest\" font-size=\"11\">");
    let (left, right) = (place(-1.0), place(1.0));
    // Writing to a string does not fail.
    let _ = write!(
        svg,
        "<rect class=\"margin\" x=\"{left:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{:.1}\"/>\
         <path class=\"zero\" d=\"M{zero:.1} {TOP}V{floor:.1}\"/>",
        right - left,
        floor - TOP,
        zero = place(0.0)
    );
    for tick in [-4, -3, -2, -1, 0, 1, 2, 3, 4] {
        let at = place(f64::from(tick));
        let _ = write!(
            svg,
            "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            floor + 13.0,
            if tick < 0 {
                format!("−{}", -tick)
            } else {
                tick.to_string()
            }
        );
    }
    let _ = write!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{axis}</text>",
        place(0.0),
        floor + 28.0
    );
    for (index, row) in rows.iter().enumerate() {
        let middle = TOP + ROW * (index as f64 + 0.5);
        let _ = write!(
            svg,
            "<text x=\"0\" y=\"{:.1}\">{}</text>",
            middle + 4.0,
            escaped(&row.name)
        );
        let Some(of) = row.difference else {
            let _ = write!(
                svg,
                "<text class=\"none\" x=\"{:.1}\" y=\"{:.1}\">not measured</text>",
                place(-REACH) + 4.0,
                middle + 4.0
            );
            continue;
        };
        let class = match row.finding {
            Some(Finding::Equivalent) => "same",
            Some(Finding::Different) => "apart",
            Some(Finding::Undecided) | None => "open",
        };
        let (low, high) = (place(of.low), place(of.high));
        let _ = write!(
            svg,
            "<path class=\"{class}\" d=\"M{low:.1} {middle:.1}H{high:.1}\"/>"
        );
        if of.estimate.abs() <= REACH {
            let at = place(of.estimate);
            let _ = write!(
                svg,
                "<circle class=\"{class}\" cx=\"{at:.1}\" cy=\"{middle:.1}\" r=\"3\"/>"
            );
        } else {
            // An arrow: the estimate is beyond the panel.
            let tip = place(of.estimate);
            let back = tip - 7.0 * of.estimate.signum();
            let _ = write!(
                svg,
                "<path class=\"{class} tip\" d=\"M{back:.1} {:.1}L{tip:.1} {middle:.1}L{back:.1} {:.1}Z\"/>",
                middle - 4.0,
                middle + 4.0
            );
        }
    }
    whole([WIDTH, height], axis, &(svg + "</g>"))
}

/// The rows as they are drawn.
pub fn csv(rows: &[Row]) -> Result<String, Error> {
    let head = [
        "row",
        "bias over margin",
        "lower end, 90 %",
        "upper end, 90 %",
        "finding",
    ];
    let rows = rows.iter().map(|row| {
        let mut line = vec![row.name.clone()];
        line.extend(match row.difference {
            Some(of) => cells([of.estimate, of.low, of.high]),
            None => vec![String::new(); 3],
        });
        line.push(match row.finding {
            Some(finding) => format!("{finding:?}").to_lowercase(),
            None => String::new(),
        });
        line
    });
    table(&head, rows)
}
