//! The numbers that the map's pictures draw.

use super::curves::Curves;
use crate::error::Error;
use crate::report::figure::cells;
use crate::report::figure_files::table;
use crate::study::sensitivity::choices::Axis;
use crate::study::sensitivity::record::Sensitivity;

/// Every published figure in every setting of these axes.
pub fn of_settings(record: &Sensitivity, wanted: impl Fn(Axis) -> bool) -> Result<String, Error> {
    let head = [
        "number",
        "axis",
        "setting",
        "at",
        "beside",
        "clouds",
        "share that reached the force",
        "figure",
        "unit",
        "ours",
        "lower end, 95 %",
        "upper end, 95 %",
        "verdict",
    ];
    let points = record
        .points
        .iter()
        .filter(|point| wanted(point.setting.axis));
    let rows = points.flat_map(|point| {
        let setting = &point.setting;
        let figures = record.figures.iter().zip(&point.figures);
        figures.map(move |(figure, judged)| {
            let mut row = vec![
                point.number.to_string(),
                setting.axis.title().to_owned(),
                setting.name.clone(),
                setting.at.to_string(),
                setting.beside.map_or(String::new(), |of| of.to_string()),
                point.made.to_string(),
                point.reached.to_string(),
                figure.id.to_owned(),
                figure.unit.to_owned(),
            ];
            row.extend(match judged.value {
                Some(of) => cells([of.estimate, of.low, of.high]),
                None => vec![String::new(); 3],
            });
            row.push(judged.verdict.word().to_owned());
            row
        })
    });
    table(&head, rows)
}

/// The points of every line.
pub fn of_curves(curves: &Curves) -> Result<String, Error> {
    let head = ["line", &curves.x, &curves.y, "lower end", "upper end"];
    let rows = curves.lines.iter().flat_map(|line| {
        let rows = line.points.iter();
        rows.map(|(at, [value, low, high])| {
            let mut row = vec![line.name.clone()];
            row.extend(cells([*at, *value, *low, *high]));
            row
        })
    });
    table(&head, rows)
}
