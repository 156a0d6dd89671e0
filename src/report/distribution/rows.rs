//! What a panel shows, as rows of a table.

use super::{Distribution, Panel};
use evidence::Interval;

/// Head of the rows. A density is over 1/unit; a share has no unit.
pub const COLUMNS: [&str; 8] = [
    "panel", "unit", "series", "from", "to", "value", "low_95", "high_95",
];

/// Adds a value over a part of the horizontal axis.
pub fn add(
    of: &Distribution<'_>,
    panel: &mut Panel,
    series: &str,
    [from, to]: [f64; 2],
    value: Interval,
) {
    let number = |value: f64| {
        if value.is_nan() {
            String::new()
        } else {
            format!("{value}")
        }
    };
    panel.rows.push([
        of.title.to_owned(),
        of.unit.to_owned(),
        series.to_owned(),
        number(from),
        number(to),
        number(value.estimate),
        number(value.low),
        number(value.high),
    ]);
}

/// Adds the points of a curve, which have no intervals.
pub fn add_points(of: &Distribution<'_>, panel: &mut Panel, series: &str, points: &[[f64; 2]]) {
    for [at, value] in points {
        let value = Interval {
            estimate: *value,
            low: f64::NAN,
            high: f64::NAN,
        };
        add(of, panel, series, [*at, *at], value);
    }
}
