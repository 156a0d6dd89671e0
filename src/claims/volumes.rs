//! Section 5: many cells together. How their variation falls with their number, which law they have, and from which
//! number on the continuum is good enough.

use serde::Serialize;

use super::claim::{Claim, FEWEST, LEVEL, Row, Rule, verdict};
use super::means::POINTS;
use super::quantities;
use super::sample::{Moment, positive, together};
use crate::campaign::member::Member;
use crate::continuum::half_space::strip_load;
use crate::measure::neighbourhood::{GROWING, Together};
use crate::scene::Scene;
use crate::statistics::moments::{deviation, mean};
use crate::statistics::{Interval, bootstrap, line};

/// The paper's porosity, with which it weighs the bed.
const POROSITY: f64 = 0.17;
/// The exponent of the number of cells may be off by this: with 256 cells the variation is then off by a third.
const EXPONENT: f64 = 0.05;
/// The variation may be off by this factor at any number of cells.
const FACTOR: f64 = 1.25;
/// The continuum is good enough where one packing's mean varies less than this, and is less than this off.
pub const GOOD_ENOUGH: f64 = 0.1;
/// Numbers of cells at which the law is judged.
const JUDGED: [usize; 3] = [4, 16, 64];

/// So many nearest cells of a point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Volume {
    /// How many.
    pub cells: usize,
    /// Over so many packings.
    pub packings: usize,
    /// Their mean area together, m².
    pub area: f64,
    /// Mean over packings of ΣΣ_zz/ΣV_p, Pa.
    pub stress: Option<Interval>,
    /// The continuum's mean over a disc of this area, Pa.
    pub continuum: f64,
    /// Coefficient of variation of ΣΣ_zz over packings.
    pub variation: Option<Interval>,
    /// √N times that: 1 if the cells were independent and exponential.
    pub scaled: Option<Interval>,
    /// Shape of the gamma law of ΣΣ_zz over N: 1 if it were Erlang's.
    pub shape: Option<Interval>,
    /// The mean correlation of two of the cells if all varied alike: (N CV_N²/CV_1² − 1)/(N − 1).
    pub correlation: Option<f64>,
}

/// Growing volumes about a point at a moment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Volumes {
    /// `last` or `settled`.
    pub moment: &'static str,
    /// The control point.
    pub point: &'static str,
    /// In growing order.
    pub volumes: Vec<Volume>,
    /// CV ∝ N^exponent, all of the volumes.
    pub exponent: Option<Interval>,
    /// The number of cells from which on CV is below [`GOOD_ENOUGH`], between those looked at by a power law;
    /// none where it is beyond them.
    pub enough: Option<f64>,
}

fn stresses(volumes: &[Together]) -> Vec<f64> {
    volumes.iter().map(|one| one.zz / one.cell).collect()
}

/// The continuum's mean of σ_zz, Pa, over a disc of this area: gravity by the mean depth, and under the load the strip's
/// stress by quadrature.
pub fn continuum(scene: &Scene, moment: Moment, offset: f64, depth: f64, area: f64) -> f64 {
    const RINGS: u32 = 12;
    const SPOKES: u32 = 24;
    let weight = scene.material.density * scene.gravity * (1.0 - POROSITY) * depth;
    if moment == Moment::Settled {
        return weight;
    }
    let radius = (area / std::f64::consts::PI).sqrt();
    let (pressure, half_width) = (scene.loading.pressure, scene.loading.half_width);
    let mut sum = 0.0;
    for ring in 0..RINGS {
        // Rings of equal area.
        let from_centre = radius * ((f64::from(ring) + 0.5) / f64::from(RINGS)).sqrt();
        for spoke in 0..SPOKES {
            let angle = std::f64::consts::TAU * (f64::from(spoke) + 0.5) / f64::from(SPOKES);
            let below = (depth - from_centre * angle.sin()).max(1.0e-3);
            sum += strip_load(
                pressure,
                half_width,
                offset + from_centre * angle.cos(),
                below,
            );
        }
    }
    weight + sum / f64::from(RINGS * SPOKES)
}

fn volume(
    scene: &Scene,
    members: &[Member],
    moment: Moment,
    point: &str,
    cells: usize,
    single: f64,
) -> Option<Volume> {
    let all = together(members, moment, point, cells);
    let place = scene.control_points.iter().find(|of| of.name == point)?;
    if all.len() < 3 {
        return None;
    }
    let sums: Vec<f64> = all.iter().map(|one| one.zz).collect();
    let area = mean(&all.iter().map(|one| one.cell).collect::<Vec<f64>>());
    let rise = mean(&all.iter().map(|one| one.rise).collect::<Vec<f64>>());
    let n = cells as f64;
    let variation = bootstrap::variation(&sums, LEVEL);
    let shape = quantities::gamma_shape(&positive(&sums))(LEVEL);
    let ratio = deviation(&sums) / mean(&sums) / single;
    Some(Volume {
        cells,
        packings: all.len(),
        area,
        stress: quantities::mean(&stresses(&all))(LEVEL),
        continuum: continuum(scene, moment, place.offset, place.depth - rise, area),
        variation,
        scaled: variation.map(|of| of.over(1.0 / n.sqrt())),
        shape: shape.map(|of| of.over(n)),
        correlation: (cells > 1 && single.is_finite())
            .then(|| (n * ratio * ratio - 1.0) / (n - 1.0)),
    })
}

/// The sums over growing numbers of cells, of the members that have all of them: [packing][number of cells].
fn table(members: &[Member], moment: Moment, point: &str) -> Vec<Vec<f64>> {
    let columns: Vec<Vec<f64>> = GROWING
        .iter()
        .map(|cells| {
            together(members, moment, point, *cells)
                .iter()
                .map(|one| one.zz)
                .collect()
        })
        .collect();
    let packings = columns.iter().map(Vec::len).min().unwrap_or(0);
    if columns.iter().any(|column| column.len() != packings) {
        return Vec::new();
    }
    (0..packings)
        .map(|packing| columns.iter().map(|column| column[packing]).collect())
        .collect()
}

fn exponent(table: &[Vec<f64>], level: f64) -> Option<Interval> {
    bootstrap::interval(table.len(), level, |packings| {
        let points: Vec<(f64, f64)> = GROWING
            .iter()
            .enumerate()
            .map(|(index, cells)| {
                let sums: Vec<f64> = packings.iter().map(|one| table[*one][index]).collect();
                ((*cells as f64).ln(), (deviation(&sums) / mean(&sums)).ln())
            })
            .collect();
        line::slope(&points).map_or(f64::NAN, |slope| slope.estimate)
    })
}

/// Between two volumes by a power law.
fn enough(volumes: &[Volume]) -> Option<f64> {
    let points: Vec<(f64, f64)> = volumes
        .iter()
        .filter_map(|one| Some((one.cells as f64, one.variation?.estimate)))
        .collect();
    let after = points
        .iter()
        .rposition(|(_, variation)| *variation > GOOD_ENOUGH);
    let Some(before) = after else {
        return points.first().map(|(cells, _)| *cells);
    };
    let ((n, high), (m, low)) = (points[before], *points.get(before + 1)?);
    let slope = (low / high).ln() / (m / n).ln();
    Some(n * ((GOOD_ENOUGH / high).ln() / slope).exp())
}

/// All points and moments that the members have.
pub fn all(scene: &Scene, members: &[Member]) -> Vec<Volumes> {
    let mut series = Vec::new();
    for moment in Moment::BOTH {
        for point in POINTS {
            let first: Vec<f64> = together(members, moment, point, 1)
                .iter()
                .map(|one| one.zz)
                .collect();
            let single = deviation(&first) / mean(&first);
            let volumes: Vec<Volume> = GROWING
                .iter()
                .filter_map(|cells| volume(scene, members, moment, point, *cells, single))
                .collect();
            series.push(Volumes {
                moment: moment.key(),
                point,
                exponent: exponent(&table(members, moment, point), LEVEL),
                enough: enough(&volumes),
                volumes,
            });
        }
    }
    series
}

fn of_moment(series: &[Volumes], moment: Moment) -> impl Iterator<Item = &Volumes> {
    series.iter().filter(move |of| of.moment == moment.key())
}

/// CV = 1/√N.
pub fn square_root(members: &[Member], series: &[Volumes], moment: Moment) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for of in of_moment(series, moment) {
        let table = table(members, moment, of.point);
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
            let sums: Vec<f64> = together(members, moment, of.point, one.cells)
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
        },
        place: "section 5",
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
        figure: "volumes",
    }
}

/// Erlang(N).
pub fn erlang(members: &[Member], series: &[Volumes]) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for moment in Moment::BOTH {
        for of in of_moment(series, moment) {
            for cells in JUDGED {
                let sums: Vec<f64> = together(members, moment, of.point, cells)
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
        id: "erlang",
        place: "section 5",
        statement: "Σ_zz of N cells together follows an Erlang law of shape N.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!("Gamma shape over N at 64 cells: {}.", found.join(", ")),
        decided_by: format!(
            "Gamma shape over N within a factor of {FACTOR}² of 1 at 4, 16 and 64 cells, which is a factor of {FACTOR} in the \
             variation."
        ),
        rows,
        figure: "shapes",
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
            let all = together(members, moment, of.point, last.cells);
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
        id: "large_scale",
        place: "section 5",
        statement: "For many particles the variation tends to 0 and Σ_zz equals V σ_zz in every realization.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!("CV below 10 %, and mean against the continuum at the most cells: {}.", found.join("; ")),
        decided_by: "At every point, under gravity and under the load, with the most cells looked at: CV below 10 % and mean within \
                     10 % of the continuum's mean over a disc of the same area and mean depth."
            .to_owned(),
        rows,
        figure: "volumes",
    }
}
