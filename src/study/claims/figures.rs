//! The data of the figures, for whoever draws them.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::means::POINTS;
use super::sample::{Moment, positive, stress};
use super::volumes::Volumes;
use crate::paper::boussinesq::published_parts;
use crate::study::campaign::member::Member;
use evidence::Interval;
use evidence::histogram::Bins;
use evidence::law::{Family, Law};
use evidence::moments::mean;

/// A bin is so wide, in means of the sample.
const BIN: f64 = 0.25;
/// Up to so many means.
const UP_TO: f64 = 6.0;
/// Of the densities' intervals.
const LEVEL: f64 = 0.95;

/// A distribution at a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// The control point.
    pub point: Cow<'static, str>,
    /// What is distributed, with its unit.
    pub what: String,
    /// How many packings.
    pub packings: usize,
    /// Mean of the sample, in its unit.
    pub mean: f64,
    /// The theory's mean in the same unit, where there is one.
    pub theory: Option<f64>,
    /// The fitted law beside the exponential: gamma, or Laplace for shear.
    pub fitted: Option<Law>,
    /// Width of a bin, in the unit of the values.
    pub bin: f64,
    /// From here on.
    pub start: f64,
    /// Density with its binomial 95 % interval, bin by bin.
    pub density: Vec<Interval>,
    /// All values, from small to large.
    pub sorted: Vec<f64>,
}

/// Data of all figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Σ_zz under the load at O, A, B: Figure 5.
    pub figure5: Vec<Histogram>,
    /// The same under gravity alone.
    pub gravity: Vec<Histogram>,
    /// Σ_xx under the load.
    pub horizontal: Vec<Histogram>,
    /// Σ_xz under the load.
    pub shear: Vec<Histogram>,
    /// Section 5.
    pub volumes: Vec<Volumes>,
    /// (height, porosity) of every settled bed, by one definition each.
    pub plane: Vec<Cloud>,
    /// Solid area over width, m: n = 1 − this/H.
    pub solid: f64,
}

/// Beds in the plane of height and porosity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cloud {
    /// How both are taken.
    pub definition: Cow<'static, str>,
    /// A bed each.
    pub beds: Vec<[f64; 2]>,
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

fn normal(members: &[Member], moment: Moment, what: &str) -> Vec<Histogram> {
    let of = |point: &'static str| {
        let (key, words, unit) = if what == "zz" && moment == Moment::Loaded {
            ("control_volume_zz".to_owned(), "Σ_zz", "J")
        } else {
            (
                format!("grain_{what}"),
                if what == "zz" { "σ_zz" } else { "σ_xx" },
                "Pa",
            )
        };
        let values = stress(members, moment, point, &key);
        let parts = published_parts(point);
        let theory = match (moment, what) {
            (Moment::Loaded, "zz") => parts.map(|parts| parts.extensive),
            (Moment::Settled, "zz") => parts.map(|parts| parts.weight),
            _ => None,
        };
        let centre = mean(&values);
        let bins = Bins {
            start: 0.0,
            step: BIN * centre,
            count: (UP_TO / BIN) as usize,
        };
        Histogram {
            point: point.into(),
            what: format!("{words} at {point}, {unit}"),
            packings: values.len(),
            mean: if values.is_empty() { 0.0 } else { centre },
            theory,
            fitted: Family::Gamma.fit(&positive(&values)),
            bin: bins.step,
            start: bins.start,
            density: bins.densities(&values, LEVEL),
            sorted: sorted(&values),
        }
    };
    let all = POINTS.map(of).into_iter();
    all.filter(|of| of.packings > 1 && of.mean > 0.0).collect()
}

fn shear(members: &[Member]) -> Vec<Histogram> {
    let of = |point: &'static str| {
        let values = stress(members, Moment::Loaded, point, "grain_xz");
        let law = Family::Laplace.fit(&values)?;
        let Law::Laplace { location, scale } = law else {
            return None;
        };
        let bins = Bins {
            start: location - UP_TO * scale,
            step: 2.0 * BIN * scale,
            count: (UP_TO / BIN) as usize,
        };
        Some(Histogram {
            point: point.into(),
            what: format!("σ_xz at {point}, Pa"),
            packings: values.len(),
            mean: mean(&values),
            theory: None,
            fitted: Some(law),
            bin: bins.step,
            start: bins.start,
            density: bins.densities(&values, LEVEL),
            sorted: sorted(&values),
        })
    };
    POINTS.into_iter().filter_map(of).collect()
}

/// The data of all figures.
pub fn of(members: &[Member], volumes: Vec<Volumes>, solid: f64) -> Figures {
    let cloud = |definition: &'static str, height: &str, porosity: &str| {
        let beds = members.iter().filter_map(|member| {
            Some([
                *member.measured.get(height)?,
                *member.measured.get(porosity)?,
            ])
        });
        Cloud {
            definition: definition.into(),
            beds: beds.collect(),
        }
    };
    let surface = "settled.height.mean_surface";
    Figures {
        figure5: normal(members, Moment::Loaded, "zz"),
        gravity: normal(members, Moment::Settled, "zz"),
        horizontal: normal(members, Moment::Loaded, "xx"),
        shear: shear(members),
        volumes,
        plane: vec![
            cloud(
                "mean surface for both",
                surface,
                "settled.porosity.from_mean_surface",
            ),
            cloud(
                "highest grain for both",
                "settled.height.highest_grain",
                "settled.porosity.from_highest_grain",
            ),
            cloud(
                "twice the centre of mass for both",
                "settled.height.twice_centre_of_mass",
                "settled.porosity.from_twice_centre_of_mass",
            ),
            cloud(
                "mean surface, porosity in a window",
                surface,
                "settled.porosity.in_window",
            ),
        ],
        solid,
    }
}
