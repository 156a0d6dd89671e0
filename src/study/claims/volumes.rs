//! Many cells together: what is measured of growing volumes about the control points.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::claim::LEVEL;
use super::means::POINTS;
use super::quantities;
use super::sample::{Moment, positive, together};
use crate::paper::continuum::half_space::strip_load;
use crate::study::campaign::member::Member;
use evidence::moments::{deviation, mean};
use evidence::{Interval, bootstrap, line};
use grains::measure::neighbourhood::{GROWING, Together};
use grains::scene::Scene;

/// The paper's porosity, with which it weighs the bed.
const POROSITY: f64 = 0.17;
/// The continuum is good enough where one packing's mean varies less than this, and is less than this off.
pub const GOOD_ENOUGH: f64 = 0.1;

/// So many nearest cells of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Volumes {
    /// `last` or `settled`.
    pub moment: Cow<'static, str>,
    /// The control point.
    pub point: Cow<'static, str>,
    /// In growing order.
    pub volumes: Vec<Volume>,
    /// CV ∝ N^exponent, all of the volumes.
    pub exponent: Option<Interval>,
    /// The number of cells from which on CV is below a tenth, between those looked at by a power law;
    /// none where it is beyond them.
    pub enough: Option<f64>,
}

/// ΣΣ_zz/ΣV_p of each, Pa.
pub fn stresses(volumes: &[Together]) -> Vec<f64> {
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
pub fn table(members: &[Member], moment: Moment, point: &str) -> Vec<Vec<f64>> {
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

/// Of CV ∝ N^exponent, with its interval over packings.
pub fn exponent(table: &[Vec<f64>], level: f64) -> Option<Interval> {
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
                moment: moment.key().into(),
                point: point.into(),
                exponent: exponent(&table(members, moment, point), LEVEL),
                enough: enough(&volumes),
                volumes,
            });
        }
    }
    series
}
