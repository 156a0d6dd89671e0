//! Section 5: how the variation of many cells falls with their number, which law they have, and from which number on
//! the continuum is good enough.

use super::claim::{Claim, FEWEST, Row, Rule, verdict};
use super::quantities;
use super::sample::{Moment, positive, together};
use super::volumes::{GOOD_ENOUGH, Volumes, exponent, stresses, table};
use crate::study::campaign::member::Member;
use evidence::bootstrap;

/// The exponent of the number of cells may be off by this: with 256 cells the variation is then off by a third.
const EXPONENT: f64 = 0.05;
/// The variation may be off by this factor at any number of cells.
const FACTOR: f64 = 1.25;
/// Numbers of cells at which the law is judged.
const JUDGED: [usize; 3] = [4, 16, 64];

fn of_moment(series: &[Volumes], moment: Moment) -> impl Iterator<Item = &Volumes> {
    series.iter().filter(move |of| of.moment == moment.key())
}

/// CV = 1/√N.
pub fn square_root(members: &[Member], series: &[Volumes], moment: Moment) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for of in of_moment(series, moment) {
        let table = table(members, moment, &of.point);
        rows.push(
            Row::judged(
                format!("{}: exponent of N", of.point),
                "1",
                table.len(),
                [-0.5 - EXPONENT, -0.5 + EXPONENT],
                |level| exponent(&table, level),
            )
            .against(-0.5),
        );
        for one in of
            .volumes
            .iter()
            .filter(|one| [1, 16, 256].contains(&one.cells))
        {
            let sums: Vec<f64> = together(members, moment, &of.point, one.cells)
                .iter()
                .map(|one| one.zz)
                .collect();
            let scale = 1.0 / (one.cells as f64).sqrt();
            rows.push(
                Row::judged(
                    format!("{}: CV·√N of {} cells", of.point, one.cells),
                    "1",
                    one.packings,
                    [1.0 / FACTOR, FACTOR],
                    |level| Some(bootstrap::variation(&sums, level)?.over(scale)),
                )
                .against(1.0),
            );
        }
        if let (Some(exponent), Some(last)) = (of.exponent, of.volumes.last()) {
            found.push(format!(
                "{} N^{:.2}, CV·√N {:.2} at N = {} (mean correlation of two cells {:+.3})",
                of.point,
                exponent.estimate,
                last.scaled.map_or(f64::NAN, |scaled| scaled.estimate),
                last.cells,
                last.correlation.unwrap_or(f64::NAN)
            ));
        }
    }
    Claim {
        id: match moment {
            Moment::Loaded => "variation.load",
            Moment::Settled => "variation.gravity",
        }
        .into(),
        place: "section 5".into(),
        statement: format!(
            "The coefficient of variation of N cells together is 1/√N ({}).",
            moment.words()
        ),
        verdict: verdict(&rows, Rule::All),
        reading: format!("{}.", found.join("; ")),
        decided_by: format!(
            "At every point the exponent within {EXPONENT} of −½ and CV·√N within a factor of {FACTOR} of 1 at 1, 16 and 256 \
             cells. Neighbours that carry what the next one does not make the variation fall faster than 1/√N, a load that \
             differs from packing to packing makes it fall slower."
        ),
        rows,
        figure: "volumes".into(),
    }
}

/// Erlang(N).
pub fn erlang(members: &[Member], series: &[Volumes]) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for moment in Moment::BOTH {
        for of in of_moment(series, moment) {
            for cells in JUDGED {
                let sums: Vec<f64> = together(members, moment, &of.point, cells)
                    .iter()
                    .map(|one| one.zz)
                    .collect();
                let above_zero = positive(&sums);
                rows.push(
                    Row::judged(
                        format!(
                            "{}, {}: gamma shape over N of {cells} cells",
                            of.point,
                            moment.words()
                        ),
                        "1",
                        above_zero.len(),
                        [1.0 / (FACTOR * FACTOR), FACTOR * FACTOR],
                        |level| {
                            Some(quantities::gamma_shape(&above_zero)(level)?.over(cells as f64))
                        },
                    )
                    .against(1.0),
                );
            }
            let shape = rows.last().map_or(f64::NAN, Row::estimate);
            found.push(format!("{} {} {shape:.2}", of.point, moment.words()));
        }
    }
    Claim {
        id: "erlang".into(),
        place: "section 5".into(),
        statement: "Σ_zz of N cells together follows an Erlang law of shape N.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!("Gamma shape over N at 64 cells: {}.", found.join(", ")),
        decided_by: format!(
            "Gamma shape over N within a factor of {FACTOR}² of 1 at 4, 16 and 64 cells, which is a factor of {FACTOR} in the \
             variation."
        ),
        rows,
        figure: "shapes".into(),
    }
}

/// For large N the continuum.
pub fn good_enough(members: &[Member], series: &[Volumes]) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for moment in Moment::BOTH {
        for of in of_moment(series, moment) {
            let Some(last) = of.volumes.last() else {
                continue;
            };
            let all = together(members, moment, &of.point, last.cells);
            let sums: Vec<f64> = all.iter().map(|one| one.zz).collect();
            let name = |what: &str| {
                format!(
                    "{}, {}: {what} of {} cells",
                    of.point,
                    moment.words(),
                    last.cells
                )
            };
            rows.push(
                Row::judged(
                    name("CV"),
                    "1",
                    all.len(),
                    [0.0, GOOD_ENOUGH],
                    quantities::variation(&sums),
                )
                .against(0.0),
            );
            let stress = stresses(&all);
            rows.push(
                Row::judged(
                    name("mean over the continuum's"),
                    "1",
                    all.len(),
                    [1.0 - GOOD_ENOUGH, 1.0 + GOOD_ENOUGH],
                    |level| Some(quantities::mean(&stress)(level)?.over(last.continuum)),
                )
                .against(1.0),
            );
            let mean = rows.last().map_or(f64::NAN, Row::estimate);
            let from = match of.enough {
                Some(cells) if last.packings >= FEWEST => format!("from {cells:.0} cells on"),
                _ => format!("not up to {} cells", last.cells),
            };
            found.push(format!(
                "{} {} {from}, mean {:+.0} %",
                of.point,
                moment.words(),
                100.0 * (mean - 1.0)
            ));
        }
    }
    Claim {
        id: "large_scale".into(),
        place: "section 5".into(),
        statement: "For many particles the variation tends to 0 and Σ_zz equals V σ_zz in every realization.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!("CV below 10 %, and mean against the continuum at the most cells: {}.", found.join("; ")),
        decided_by: "At every point, under gravity and under the load, with the most cells looked at: CV below 10 % and mean within \
                     10 % of the continuum's mean over a disc of the same area and mean depth."
            .to_owned(),
        rows,
        figure: "volumes".into(),
    }
}
