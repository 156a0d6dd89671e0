//! Histories of the runs of a job on top of each other, and how rounding parts them.

use crate::compare::divergence::Separation;
use crate::error::Error;
use crate::report::chart::{BLUE, Chart, GREEN, VERMILION};
use crate::report::figure::{Figure, circles, line};
use crate::reproduce::Runs;
use crate::reproduce::record::Reproduction;
use crate::run::folder::RunFolder;
use grains::measure::HistoryRow;
use grains::tables::Stage;

/// Histories of native and YADE on top of each other.
pub fn histories(runs: &Runs) -> Result<Vec<Figure>, Error> {
    let column = |stage: Stage, of: fn(&HistoryRow) -> Option<(f64, f64)>| {
        let points = |run: &RunFolder, every: usize| {
            let rows = run.history.iter().filter(|row| row.stage == stage);
            rows.step_by(every).filter_map(of).collect::<Vec<_>>()
        };
        let mut series = vec![line("native", BLUE, points(&runs.native, 1))];
        if let Some(yade) = &runs.yade {
            let every = if stage == Stage::Settle { 4 } else { 1 };
            series.push(circles("YADE, sorted loop", VERMILION, points(yade, every)));
        }
        if let Some(ordinary) = &runs.ordinary {
            series.push(line("YADE, ordinary loop", GREEN, points(ordinary, 1)));
        }
        series
    };
    let mut figures = vec![
        (
            "kinetic-energy",
            Chart {
                x: "time since pouring began, s".to_owned(),
                y: "kinetic energy, J".to_owned(),
                logarithmic: [false, true],
                series: column(Stage::Settle, |row| Some((row.time, row.kinetic_energy))),
            },
            "Settling: the kinetic energy falls until the settle rule holds",
        ),
        (
            "unbalanced-force",
            Chart {
                x: "time since pouring began, s".to_owned(),
                y: "unbalanced force".to_owned(),
                logarithmic: [false, true],
                series: column(Stage::Settle, |row| {
                    row.unbalanced_force.map(|force| (row.time, force))
                }),
            },
            "Settling: mean net force on a grain over mean contact force",
        ),
    ];
    if runs.native.record.stages.len() > 1 {
        figures.push((
            "punch-force",
            Chart {
                x: "punch depth, mm".to_owned(),
                y: "force on the punch, N".to_owned(),
                logarithmic: [false, false],
                series: column(Stage::Load, |row| {
                    row.punch_depth
                        .zip(row.punch_force)
                        .map(|(depth, force)| (1e3 * depth, force))
                }),
            },
            "Loading: the force of the grains on the punch",
        ));
    }
    let mut drawn = Vec::new();
    for (name, chart, caption) in figures {
        drawn.extend(Figure::of_chart(name, caption, &chart)?);
    }
    Ok(drawn)
}

/// How rounding differences grow, where an ordinary pair was run.
pub fn separation(reproduction: &Reproduction) -> Result<Option<Figure>, Error> {
    let divergences = reproduction
        .comparisons
        .iter()
        .find_map(|named| named.comparison.divergences.as_ref());
    let Some(divergences) = divergences else {
        return Ok(None);
    };
    let largest = |curve: &[Separation]| {
        curve
            .iter()
            .map(|moment| (moment.step as f64, moment.largest))
            .filter(|(_, apart)| *apart > 0.0)
            .collect::<Vec<_>>()
    };
    let chart = Chart {
        x: "step of pouring".to_owned(),
        y: "largest separation over R".to_owned(),
        logarithmic: [false, true],
        series: vec![
            line("native, YADE", BLUE, largest(&divergences.engines.curve)),
            line("YADE, YADE", VERMILION, largest(&divergences.control.curve)),
        ],
    };
    // A scene too short for rounding to matter has no curve to draw.
    Figure::of_chart(
        "separation",
        "Rounding differences grow: native against YADE's ordinary loop, and two ordinary YADE runs that differ in verletDist only (before the \
         curves begin the bits agree)",
        &chart,
    )
}
