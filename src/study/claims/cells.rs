//! Many cells together (section 5): whether neighbours are independent, how the variation of growing volumes about the
//! control points falls with their number, which law they have, and from which number on the continuum is good enough. Means,
//! variances and correlations are over all cells, those that bear nothing included, as sums add up only with them; laws are fitted
//! to sums that are not zero.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::sample::{self, Moment, Number, nearest, together};
use super::shapes::SAMPLES;
use super::{Claim, FEWEST, LEVEL, Row, Rule};
use crate::paper::continuum::{Field, Model};
use crate::paper::published::POINTS;
use crate::study::campaign::Member;
use crate::study::figures::setup_of;
use evidence::distribution::Family;
use evidence::moments::{coefficient_of_variation, mean, standard_deviation};
use evidence::regression::{correlation, slope, spearman};
use evidence::zeros::Parted;
use evidence::{Interval, bootstrap};
use grains::measure::neighbourhood::{GROWING, Together};
use grains::scene::Scene;

/// The continuum is good enough where one packing's mean varies less than this, and is less than this off.
const GOOD_ENOUGH: f64 = 0.1;

/// So many nearest cells of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Volume {
    /// How many.
    pub cells: usize,
    pub packings: usize,
    /// Their mean area together, m².
    pub area: f64,
    /// Mean over packings of ΣΣ_zz/ΣV_p, Pa.
    pub stress: Option<Interval>,
    /// The continuum's mean over a disc of this area, Pa.
    pub continuum: f64,
    /// Coefficient of variation of ΣΣ_zz over packings.
    pub variation: Option<Interval>,
    /// The exponent of N from the volume before, of half as many cells: −½ if they were independent. 95 % each.
    pub slope: Option<Interval>,
    /// √N times that: 1 if the cells were independent and exponential.
    pub scaled: Option<Interval>,
    /// Shape of the gamma law of ΣΣ_zz over N: 1 if it were Erlang's.
    pub shape: Option<Interval>,
    /// The mean correlation of two of the cells if all varied alike: (N CV_N²/CV_1² − 1)/(N − 1).
    pub correlation: Option<f64>,
}

/// Growing volumes about a point at a moment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Volumes {
    pub moment: Moment,
    pub point: Cow<'static, str>,
    pub volumes: Vec<Volume>,
    /// CV ∝ N^exponent, all of the volumes.
    pub exponent: Option<Interval>,
    /// The number of cells from which on CV is below a tenth, between those looked at by a power law;
    /// none where it is beyond them.
    pub enough: Option<f64>,
}

/// ΣΣ_zz of so many cells in every member that has them.
fn sums(members: &[Member], moment: Moment, point: &str, cells: usize) -> Vec<f64> {
    let all = together(members, moment, point, cells);
    all.iter().map(|one| one.zz).collect()
}

/// ΣΣ_zz/ΣV_p of each, Pa.
fn stresses(volumes: &[Together]) -> Vec<f64> {
    volumes.iter().map(|one| one.zz / one.cell).collect()
}

/// The continuum's mean of σ_zz, Pa, over a disc of this area: gravity by the mean depth, and under the load the strip's
/// stress by quadrature.
pub fn continuum(scene: &Scene, moment: Moment, offset: f64, depth: f64, area: f64) -> f64 {
    const RINGS: u32 = 12;
    const SPOKES: u32 = 24;
    let setup = setup_of(scene);
    let weight = setup.weight(depth);
    if moment == Moment::Settled {
        return weight;
    }
    let radius = (area / std::f64::consts::PI).sqrt();
    let field = Field::new(Model::HalfSpace, setup.load);
    let mut sum = 0.0;
    for ring in 0..RINGS {
        // Rings of equal area.
        let from_centre = radius * ((f64::from(ring) + 0.5) / f64::from(RINGS)).sqrt();
        for spoke in 0..SPOKES {
            let angle = std::f64::consts::TAU * (f64::from(spoke) + 0.5) / f64::from(SPOKES);
            let below = (depth - from_centre * angle.sin()).max(1.0e-3);
            let x = offset + from_centre * angle.cos();
            sum += field.stress(x, below).zz;
        }
    }
    weight + sum / f64::from(RINGS * SPOKES)
}

/// The sums over growing numbers of cells, of the members that have all of them: a sample for each number.
fn growing(members: &[Member], moment: Moment, point: &str) -> [Vec<f64>; GROWING.len()] {
    let all = GROWING.map(|cells| sums(members, moment, point, cells));
    match all.iter().all(|sums| sums.len() == all[0].len()) {
        true => all,
        false => Default::default(),
    }
}

/// The values of packings that were drawn.
fn drawn(values: &[f64], packings: &[usize]) -> Vec<f64> {
    packings.iter().map(|one| values[*one]).collect()
}

/// Of CV ∝ N^exponent, with its interval over packings.
fn exponent(growing: &[Vec<f64>], level: f64) -> Option<Interval> {
    bootstrap::interval(growing[0].len(), level, |packings| {
        let points = GROWING.iter().zip(growing).map(|(cells, sums)| {
            let variation = coefficient_of_variation(&drawn(sums, packings));
            ((*cells as f64).ln(), variation.ln())
        });
        slope(&points.collect::<Vec<_>>()).map_or(f64::NAN, |slope| slope.estimate)
    })
}

/// Of CV ∝ N^exponent between this number of cells and the one before.
fn local(growing: &[Vec<f64>], index: usize) -> Option<Interval> {
    let before = index.checked_sub(1)?;
    let grown = GROWING[index] as f64 / GROWING[before] as f64;
    bootstrap::interval(growing[index].len(), LEVEL, |packings| {
        let variation = |index: usize| coefficient_of_variation(&drawn(&growing[index], packings));
        (variation(index) / variation(before)).ln() / grown.ln()
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
    let of_moment = |moment| POINTS.map(|point| volumes(scene, members, moment, point));
    Moment::BOTH.into_iter().flat_map(of_moment).collect()
}

fn volumes(scene: &Scene, members: &[Member], moment: Moment, point: &'static str) -> Volumes {
    let growing = growing(members, moment, point);
    let single = coefficient_of_variation(&sums(members, moment, point, 1));
    let place = scene
        .control_points
        .iter()
        .find(|place| place.name == point);
    let volume = |index: usize| {
        let cells = GROWING[index];
        let all = together(members, moment, point, cells);
        let place = place.filter(|_| all.len() >= 3)?;
        let sums: Vec<f64> = all.iter().map(|one| one.zz).collect();
        let mean_of = |quantity: fn(&Together) -> f64| {
            all.iter().map(quantity).sum::<f64>() / all.len() as f64
        };
        let (area, rise) = (mean_of(|one| one.cell), mean_of(|one| one.rise));
        let n = cells as f64;
        let variation = bootstrap::coefficient_of_variation(&sums, LEVEL);
        let shape = sample::law_shape(Family::Gamma, &Parted::loads(&sums).others).at(LEVEL);
        let ratio = coefficient_of_variation(&sums) / single;
        Some(Volume {
            cells,
            packings: all.len(),
            area,
            stress: sample::mean(&stresses(&all)).at(LEVEL),
            continuum: continuum(scene, moment, place.offset, place.depth - rise, area),
            variation,
            slope: local(&growing, index),
            scaled: variation.map(|interval| interval.over(1.0 / n.sqrt())),
            shape: shape.map(|interval| interval.over(n)),
            correlation: (cells > 1 && single.is_finite())
                .then(|| (n * ratio * ratio - 1.0) / (n - 1.0)),
        })
    };
    let volumes: Vec<Volume> = (0..GROWING.len()).filter_map(volume).collect();
    Volumes {
        moment,
        point: point.into(),
        exponent: exponent(&growing, LEVEL),
        enough: enough(&volumes),
        volumes,
    }
}

/// Correlations between neighbours may be this large: eight cells with it would vary by a third more than 1/√8.
const TOLERANCE: f64 = 0.1;
/// Nearest cells whose correlations are averaged.
const TOGETHER: usize = 8;

/// Neighbouring cells do not know of each other.
pub fn independence(members: &[Member]) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for moment in Moment::BOTH {
        for point in POINTS {
            let around = nearest(members, moment, point, TOGETHER);
            let column =
                |index: usize| -> Vec<f64> { around.iter().map(|cells| cells[index].zz).collect() };
            let (first, second) = (column(0), column(1));
            let name = format!("{point}, {}", moment.words());
            let number = Number::new(around.len(), |level| pair(&first, &second, level));
            let what = format!("{name}: correlation of the two nearest cells");
            let mut row = Row::judged(what, [-TOLERANCE, TOLERANCE], number).against(0.0);
            if let Some(ranks) = spearman(&first, &second, SAMPLES) {
                let test = "independent (Spearman's correlation, permuted)";
                row = row.with(test, ranks.value.estimate, ranks.p);
            }
            found.push(format!("{name} {:+.2}", row.estimate()));
            rows.push(row);
            let columns: Vec<Vec<f64>> = (0..TOGETHER).map(column).collect();
            let of_packings = |packings: &[usize]| mean_of_pairs(&columns, packings);
            let number = Number::new(around.len(), |level| {
                bootstrap::interval(around.len(), level, of_packings)
            });
            let what = format!("{name}: mean correlation of the eight nearest");
            rows.push(Row::shown(what, number).against(0.0));
        }
    }
    let found = found.join(", ");
    Claim::of("independence", "section 5, which sums independent cells", "correlations")
        .says("The stresses of neighbouring cells are independent.")
        .found(format!("Correlations of the two nearest cells' Σ_zz over packings: {found}."))
        .decided_by(format!(
            "Pearson's correlation over packings of the two cells nearest to each point within ± {TOLERANCE}; eight cells with \
             more would vary by a third more, or fewer, than independent ones."
        ))
        .by(Rule::All, rows)
}

fn pair(first: &[f64], second: &[f64], level: f64) -> Option<Interval> {
    bootstrap::interval(first.len(), level, |packings| {
        let both = [first, second].map(|values| drawn(values, packings));
        correlation(&both[0], &both[1]).unwrap_or(f64::NAN)
    })
}

/// Mean of the correlations of all pairs, over these packings: from the variance of the sum of the standardized columns.
fn mean_of_pairs(columns: &[Vec<f64>], packings: &[usize]) -> f64 {
    let count = columns.len() as f64;
    let mut sums = vec![0.0; packings.len()];
    for column in columns {
        let values = drawn(column, packings);
        let (centre, spread) = (mean(&values), standard_deviation(&values));
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += (value - centre) / spread;
        }
    }
    let variance = standard_deviation(&sums).powi(2);
    (variance - count) / (count * (count - 1.0))
}

/// The exponent of the number of cells may be off by this: with 256 cells the variation is then off by a third.
const EXPONENT: f64 = 0.05;
/// The variation may be off by this factor at any number of cells.
const FACTOR: f64 = 1.25;
/// Numbers of cells at which the law is judged.
const JUDGED: [usize; 3] = [4, 16, 64];

fn last_estimate(rows: &[Row]) -> f64 {
    rows.last().map_or(f64::NAN, Row::estimate)
}

pub fn square_root(members: &[Member], series: &[Volumes], moment: Moment) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for scaling in series.iter().filter(|scaling| scaling.moment == moment) {
        let growing = growing(members, moment, &scaling.point);
        let name = format!("{}: exponent of N", scaling.point);
        let limits = [-0.5 - EXPONENT, -0.5 + EXPONENT];
        let number = Number::new(growing[0].len(), |level| exponent(&growing, level));
        rows.push(Row::judged(name, limits, number).against(-0.5));
        let volumes = scaling.volumes.iter();
        for one in volumes.filter(|one| [1, 16, 256].contains(&one.cells)) {
            let sums = sums(members, moment, &scaling.point, one.cells);
            let scaled = sample::variation(&sums).over(1.0 / (one.cells as f64).sqrt());
            let name = format!("{}: CV·√N of {} cells", scaling.point, one.cells);
            rows.push(Row::judged(name, [1.0 / FACTOR, FACTOR], scaled).against(1.0));
        }
        if let (Some(exponent), Some(last)) = (scaling.exponent, scaling.volumes.last()) {
            found.push(format!(
                "{} N^{:.2}, CV·√N {:.2} at N = {} (mean correlation of two cells {:+.3})",
                scaling.point,
                exponent.estimate,
                last.scaled.map_or(f64::NAN, |scaled| scaled.estimate),
                last.cells,
                last.correlation.unwrap_or(f64::NAN)
            ));
        }
    }
    let id = match moment {
        Moment::Loaded => "variation.load",
        Moment::Settled => "variation.gravity",
    };
    Claim::of(id, "section 5", "volumes")
        .says(format!(
            "The coefficient of variation of N cells together is 1/√N ({}).",
            moment.words()
        ))
        .found(format!("{}.", found.join("; ")))
        .decided_by(format!(
            "At every point the exponent within {EXPONENT} of −½ and CV·√N within a factor of {FACTOR} of 1 at 1, 16 and 256 \
             cells. Neighbours that carry what the next one does not make the variation fall faster than 1/√N, a load that \
             differs from packing to packing makes it fall slower. Cells that bear nothing count: sums add up only with them."
        ))
        .by(Rule::All, rows)
}

pub fn erlang(members: &[Member], series: &[Volumes]) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    let limits = [1.0 / (FACTOR * FACTOR), FACTOR * FACTOR];
    for scaling in series {
        let (point, words) = (&scaling.point, scaling.moment.words());
        for cells in JUDGED {
            let sums = sums(members, scaling.moment, point, cells);
            let shape = sample::law_shape(Family::Gamma, &Parted::loads(&sums).others);
            let name = format!("{point}, {words}: gamma shape over N of {cells} cells");
            rows.push(Row::judged(name, limits, shape.over(cells as f64)).against(1.0));
        }
        found.push(format!("{point} {words} {:.2}", last_estimate(&rows)));
    }
    Claim::of("erlang", "section 5", "shapes")
        .says("Σ_zz of N cells together follows an Erlang law of shape N.")
        .found(format!("Gamma shape over N at 64 cells: {}.", found.join(", ")))
        .decided_by(format!(
            "Gamma shape over N, of cells that together bear load, within a factor of {FACTOR}² of 1 at 4, 16 and 64 cells, which is a factor of {FACTOR} in the \
             variation."
        ))
        .by(Rule::All, rows)
}

/// For large N the continuum.
pub fn good_enough(members: &[Member], series: &[Volumes]) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for scaling in series {
        let Some(last) = scaling.volumes.last() else {
            continue;
        };
        let (point, words, cells) = (&scaling.point, scaling.moment.words(), last.cells);
        let name = |what: &str| format!("{point}, {words}: {what} of {cells} cells");
        let sums = sums(members, scaling.moment, point, cells);
        let variation = sample::variation(&sums);
        rows.push(Row::judged(name("CV"), [0.0, GOOD_ENOUGH], variation).against(0.0));
        let stress = stresses(&together(members, scaling.moment, point, cells));
        let over = sample::mean(&stress).over(last.continuum);
        let limits = [1.0 - GOOD_ENOUGH, 1.0 + GOOD_ENOUGH];
        rows.push(Row::judged(name("mean over the continuum's"), limits, over).against(1.0));
        let from = match scaling.enough {
            Some(cells) if last.packings >= FEWEST => format!("from {cells:.0} cells on"),
            _ => format!("not up to {cells} cells"),
        };
        let off = 100.0 * (last_estimate(&rows) - 1.0);
        found.push(format!("{point} {words} {from}, mean {off:+.0} %"));
    }
    Claim::of("large_scale", "section 5", "volumes")
        .says("For many particles the variation tends to 0 and Σ_zz equals V σ_zz in every realization.")
        .found(format!("CV below 10 %, and mean against the continuum at the most cells: {}.", found.join("; ")))
        .decided_by("At every point, under gravity and under the load, with the most cells looked at: CV below 10 % and mean within \
                     10 % of the continuum's mean over a disc of the same area and mean depth.")
        .by(Rule::All, rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_columns_correlate_fully_and_opposite_ones_cancel() {
        let column = vec![1.0, 2.0, 5.0, 3.0];
        let opposite: Vec<f64> = column.iter().map(|value| -value).collect();
        let all = [0, 1, 2, 3];
        let close = |columns: &[Vec<f64>], wanted: f64| {
            assert!((mean_of_pairs(columns, &all) - wanted).abs() < 1.0e-12);
        };
        close(&[column.clone(), column.clone(), column.clone()], 1.0);
        close(&[column, opposite], -1.0);
    }
}
