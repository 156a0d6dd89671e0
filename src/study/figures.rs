//! The content of the paper's figures from our own numbers.

use std::borrow::Cow;
use std::path::Path;

use crate::document::plot::Point as DataPoint;
use crate::document::{Axis, Colour, Plot, Shape, Table, rounded};
use crate::paper::continuum::table::Setup;
use crate::paper::continuum::{Field, Load, Model, Spread};
use crate::paper::recomputed::piles::{Counted, chance_of_at_least_of_five, table_1};
use crate::study::StudyError;
use crate::study::campaign::Merged;
use crate::study::realization::{Engines, Realization, Specification};
use evidence::Interval;
use evidence::distribution::{Distribution as Law, Family};
use evidence::moments::{mean, standard_deviation};
use evidence::proportion::{Bins, wilson};
use evidence::zeros::Parted;
use grains::measure;
use grains::scene::{ControlPoint, Scene};
use grains::tables::Snapshot;
use serde::{Deserialize, Serialize};

/// The continuum's side of a scene. Height and porosity of the bed are the published ones: what the theory was given.
pub fn setup_of(scene: &Scene) -> Setup {
    Setup {
        load: Load {
            spread: Spread::Uniform,
            pressure: scene.loading.pressure,
            half_width: scene.loading.half_width,
        },
        points: scene.control_points.clone(),
        width: scene.container.width,
        density: scene.material.density,
        gravity: scene.gravity,
        ..Setup::published()
    }
}

/// An interval in a row of names; its ends, and an estimate beyond them, which is then written beside it, stand at the edge.
pub fn in_row(
    interval: &Interval,
    row: usize,
    [low, high]: [f64; 2],
    decimals: usize,
) -> DataPoint {
    let within = |value: f64| value.clamp(low, high);
    let beyond = !(low..=high).contains(&interval.estimate);
    let label = beyond.then(|| format!("{:.decimals$}", interval.estimate));
    DataPoint::at(within(interval.estimate), row as f64)
        .between(within(interval.low), within(interval.high))
        .labelled(label.unwrap_or_default())
}

/// A bed under the punch.
#[derive(Debug)]
pub struct LoadedBed {
    pub scene: Scene,
    /// Height that depths are counted from, m: of the settled bed.
    pub surface: f64,
    pub last: Snapshot,
}

impl LoadedBed {
    /// Where a control point is, m.
    pub fn places(&self) -> impl Iterator<Item = (&str, [f64; 2])> {
        self.scene.control_points.iter().map(|point| {
            let x = self.scene.punch_axis() + point.offset;
            (point.name.as_str(), [x, self.surface - point.depth])
        })
    }
}

/// Runs the scene in the native engine to the end of loading.
pub fn loaded_bed(scene: &Scene) -> Result<LoadedBed, StudyError> {
    let specification = Specification::native(scene.clone());
    let run = specification.run(scene.realization, &Engines::default(), Path::new(""));
    let Realization { outcome, .. } = run?;
    let settled = outcome.settled.ok_or_else(|| {
        StudyError::Usage(format!(
            "realization {} did not settle, so there is no loaded bed to draw; take another one",
            scene.realization
        ))
    })?;
    Ok(LoadedBed {
        scene: scene.clone(),
        surface: measure::surface(scene, &settled.bodies),
        last: outcome.last,
    })
}

/// Σ^c_zz of each member that reached the force (section 3.2.3) beside the half-space's μ = σ_zz V_c (Eq. 7), a control point
/// each: Figure 5. An error where a point has no values.
pub fn distributions(campaign: &Merged) -> Result<Vec<Distribution>, StudyError> {
    let scene = &campaign.plan.study.scene;
    let setup = setup_of(scene);
    let field = Field::new(Model::HalfSpace, setup.load);
    let volume = scene.measurement.control_volume_side.powi(2);
    let distribution = |point: &ControlPoint| {
        let key = format!("loaded.stress.{}.control_volume_zz", point.name);
        let values = campaign
            .rows
            .iter()
            .filter_map(|row| row.measured.get(&key));
        let values: Vec<f64> = values.copied().collect();
        if values.is_empty() {
            return Err(StudyError::Usage(format!(
                "no member of the campaign has a stress under the load at {}, so Figure 5 cannot be drawn: did any punch get its force \
                 (`study report`), and is the point inside the bed?",
                point.name
            )));
        }
        let stress = setup.weight(point.depth) + field.stress(point.offset, point.depth).zz;
        let (words, name) = (["figure-5", "Σ_zz", "J"], &point.name);
        let theory = Some(stress * volume);
        Ok(Distribution::new(
            words,
            name,
            theory,
            Family::Gamma,
            &values,
        ))
    };
    setup.points.iter().map(distribution).collect()
}

/// Table 1, counted, and the share of piles that bear at least a force, for five piles and for many: Figure 3.
pub fn sharings() -> (Table, Plot) {
    let subclasses = table_1();
    let all: u32 = subclasses.iter().map(|subclass| subclass.cases).sum();
    let title = "Five piles share five units of force (FU): how many piles bear 0, 1, … 5 of them";
    // One case of it, the largest loads first.
    let loads = |subclass: &Counted| {
        let forces = (0..6).rev();
        let loads =
            forces.flat_map(|force| vec![force.to_string(); subclass.piles[force] as usize]);
        loads.collect::<Vec<String>>().join(" ")
    };
    let table = Table::of("table-1", title, &subclasses)
        .column("loads", loads)
        .column("name", |subclass| subclass.name);
    let table = (0..6).fold(table, |table, force| {
        table.column(&format!("bear {force}"), |subclass| subclass.piles[force])
    });
    let table = table
        .column("cases", |subclass| subclass.cases)
        .column("chance", |subclass| {
            f64::from(subclass.cases) / f64::from(all)
        });
    let forces = || (0..6u32).map(|force| (force, f64::from(force)));
    let caption = "What one pile bears when five piles share five units of force, and when many do";
    let x = Axis::linear("force F, FU (the mean is 1)").within(-0.3, 5.3);
    let y = Axis::linear("share of piles with F or more").within(0.0, 1.0);
    let counted =
        forces().map(|(force, at)| [at - 0.15, at + 0.15, chance_of_at_least_of_five(force)]);
    let counted = Shape::Bars(counted.collect());
    let plot = Plot::new("figure-3", caption, x, y)
        .with("five piles, counted", Colour::Sky, counted)
        .points(
            "many, whole units",
            Colour::Green,
            forces().map(|(force, at)| DataPoint::at(at, 0.5f64.powi(force as i32))),
        )
        .line(
            "many, fine steps: exp",
            Colour::Vermilion,
            (0..=100).map(|index| {
                let force = 0.05 * f64::from(index);
                [force, (-force).exp()]
            }),
        );
    (table.into(), plot)
}

/// A bin is so wide, in means of the sample; for a law of both signs twice that, in its scales.
const BIN: f64 = 0.25;
/// Up to so many means.
const UP_TO: f64 = 6.0;
/// Bins at most, for samples of both signs.
const MOST_BINS: f64 = 200.0;
const LEVEL: f64 = 0.95;
const POINTS: u32 = 100;

/// One number a realization, with the laws that are held against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Of the plots' files, before the point's name.
    pub name: Cow<'static, str>,
    pub point: String,
    pub quantity: Cow<'static, str>,
    pub unit: Cow<'static, str>,
    pub theory: Option<f64>,
    /// The fitted law: gamma, or Laplace, which has both signs.
    pub fitted: Option<Law>,
    /// Realizations whose grain bears nothing or, of a load, is pulled; all else is of the others.
    pub zeros: usize,
    /// From small to large, without those.
    pub values: Vec<f64>,
}

impl Distribution {
    /// Of these values, with the likeliest law of a family: its name, quantity and unit, and the control point.
    pub fn new(
        [name, quantity, unit]: [&'static str; 3],
        point: &str,
        theory: Option<f64>,
        family: Family,
        values: &[f64],
    ) -> Self {
        let Parted {
            zeros,
            others: mut values,
        } = match family {
            Family::Laplace => Parted::of(values),
            _ => Parted::loads(values),
        };
        values.sort_by(f64::total_cmp);
        Distribution {
            name: name.into(),
            point: point.to_owned(),
            quantity: quantity.into(),
            unit: unit.into(),
            theory,
            fitted: family.fit(&values),
            zeros,
            values,
        }
    }

    /// Equal bins from zero or the least value to six means; none without two values or more that are all finite and of a mean
    /// above zero (of a scale above zero for a law of both signs).
    pub fn bins(&self) -> Option<Bins> {
        let [least, _, ..] = self.values[..] else {
            return None;
        };
        let whole = UP_TO / BIN;
        let (start, step, count) = match self.fitted {
            Some(Law::Laplace { location, scale }) => {
                (location - UP_TO * scale, 2.0 * BIN * scale, whole)
            }
            _ => {
                let step = BIN * mean(&self.values);
                let below = (-least / step).ceil().max(0.0);
                (-step * below, step, (whole + below).min(MOST_BINS))
            }
        };
        let is_sound = step > 0.0 && step.is_finite() && start.is_finite();
        (is_sound && self.values.iter().all(|value| value.is_finite())).then_some(Bins {
            start,
            step,
            count: count as usize,
        })
    }

    fn has_both_signs(&self) -> bool {
        matches!(self.fitted, Some(Law::Laplace { .. }))
    }

    fn laws(&self) -> Vec<(&'static str, Colour, Law)> {
        // Of the two families that are fitted.
        let (name, own) = match self.has_both_signs() {
            true => ("fitted Laplace", None),
            false => ("fitted gamma", Some(mean(&self.values))),
        };
        let [theory, own] =
            [self.theory, own].map(|value| value.map(|mean| Law::Exponential { mean }));
        let laws = [
            theory.map(|law| ("theory's exponential", Colour::Vermilion, law)),
            own.map(|law| ("exponential of the same mean", Colour::Grey, law)),
            self.fitted.map(|law| (name, Colour::Green, law)),
        ];
        laws.into_iter().flatten().collect()
    }

    /// Histogram and, for laws of one sign, the share of larger values; empty where there is nothing to draw.
    pub fn plots(&self) -> Vec<Plot> {
        let Some(bins) = self.bins() else {
            return Vec::new();
        };
        let (name, laws) = (format!("{}-{}", self.name, self.point), self.laws());
        let across = format!("{}, {}", self.quantity, self.unit);
        let densities = bins.densities(&self.values, LEVEL);
        let middle = |index: usize| 0.5 * (bins.edge(index) + bins.edge(index + 1));
        let numbered = || densities.iter().enumerate();
        let bars = numbered()
            .map(|(index, density)| [bins.edge(index), bins.edge(index + 1), density.estimate]);
        let ends = numbered().map(|(index, density)| {
            DataPoint::at(middle(index), density.estimate).between(density.low, density.high)
        });
        let x = Axis::linear(&across);
        let y = Axis::linear(&format!("probability density, 1/{}", self.unit));
        let mut histogram = Plot::new(&name, self.caption(), x, y)
            .with(
                "realizations, 95 %",
                Colour::Sky,
                Shape::Bars(bars.collect()),
            )
            .points("", Colour::Blue, ends);
        let curve = |law: Law, function: fn(&Law, f64) -> f64| -> Vec<[f64; 2]> {
            let from = match law {
                Law::Laplace { .. } => bins.start,
                _ => bins.start.max(0.0),
            };
            let points = (0..=POINTS).map(|index| {
                let at = from + (bins.end() - from) * f64::from(index) / f64::from(POINTS);
                [at, function(&law, at)]
            });
            // A gamma law of a shape below 1 has no bound at zero.
            points.filter(|point| point[1].is_finite()).collect()
        };
        let line = |colour: Colour, points: Vec<[f64; 2]>| Shape::Line {
            dashed: colour != Colour::Vermilion,
            points,
        };
        for (name, colour, law) in &laws {
            histogram = histogram.with(*name, *colour, line(*colour, curve(*law, Law::density)));
        }
        if self.has_both_signs() {
            return vec![histogram];
        }
        let count = self.values.len();
        let least = 10f64.powf((0.5 / count as f64).log10().floor()).min(1e-2);
        let shares = (0..=bins.count).filter_map(|index| {
            let at = bins.edge(index);
            let above = self.values.iter().filter(|value| **value > at).count();
            let share = wilson(above, count, LEVEL)?;
            let point = DataPoint::at(at, share.estimate).between(share.low, share.high);
            (above > 0).then_some(point)
        });
        let mut survival = Plot::new(
            &format!("{name}-share"),
            format!(
                "{} at {}: share of larger values",
                self.quantity, self.point
            ),
            Axis::linear(&across),
            Axis::logarithmic("share of larger values").within(least, 1.0),
        )
        .points("realizations, 95 %", Colour::Blue, shares);
        for (name, colour, law) in &laws {
            let points = curve(*law, Law::survival);
            // What leaves the scale is not shown.
            let shown = points.into_iter().take_while(|point| point[1] >= least);
            survival = survival.with(*name, *colour, line(*colour, shown.collect()));
        }
        vec![histogram, survival]
    }

    fn caption(&self) -> String {
        let (mean, deviation) = (mean(&self.values), standard_deviation(&self.values));
        let Distribution {
            quantity,
            point,
            unit,
            ..
        } = self;
        let mut caption = format!(
            "{quantity} at {point}: {} realizations whose grain bears load ({} bear nothing), mean {} {unit}",
            self.values.len(),
            self.zeros,
            rounded(mean, 4)
        );
        if self.has_both_signs() {
            return caption + &format!(", standard deviation {} {unit}", rounded(deviation, 4));
        }
        caption += &format!(", coefficient of variation {:.2}", deviation / mean);
        if let Some(theory) = self.theory {
            caption += &format!("; theory: mean {} {unit}, variation 1", rounded(theory, 4));
        }
        caption
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distribution(values: &[f64]) -> Distribution {
        let words = ["figure-5", "Σ_zz", "J"];
        Distribution::new(words, "O", Some(0.34), Family::Gamma, values)
    }

    fn of_laplace(values: &[f64], location: f64, scale: f64) -> Distribution {
        Distribution {
            theory: None,
            fitted: Some(Law::Laplace { location, scale }),
            ..distribution(values)
        }
    }

    #[test]
    fn bins_hold_nearly_all_values_and_their_intervals_hold_the_law() {
        let shares = (0..1000).map(|k| (f64::from(k) + 0.5) / 1000.0);
        let distribution = distribution(
            &shares
                .map(|share| -0.34 * (1.0 - share).ln())
                .collect::<Vec<f64>>(),
        );
        let bins = distribution.bins().expect("has values");
        let law = Law::Exponential { mean: 0.34 };
        let (mut sum, mut missed) = (0.0, 0);
        for (index, density) in bins
            .densities(&distribution.values, LEVEL)
            .iter()
            .enumerate()
        {
            let (from, to) = (bins.edge(index), bins.edge(index + 1));
            let wanted = (law.survival(from) - law.survival(to)) / (to - from);
            missed += u32::from(!(density.low..=density.high).contains(&wanted));
            sum += density.estimate * (to - from);
        }
        let count = bins.count;
        assert!(count >= 10 && missed == 0, "{missed} of {count}");
        assert!((sum - 0.9975).abs() < 0.002, "{sum}");
        let plots = distribution.plots();
        assert_eq!(plots.len(), 2);
        // Shares fall as the law's.
        let points = plots[1].marks[0].points().expect("points");
        for point in points.iter().filter(|point| point.x < 3.0 * 0.34) {
            let over = point.y / law.survival(point.x);
            assert!((over - 1.0).abs() < 0.02, "{point:?}");
        }
    }

    #[test]
    fn nothing_to_draw_draws_nothing() {
        let undrawn = [&[][..], &[1.0], &[1.0, f64::NAN], &[0.0, 0.0], &[-1.0, 0.5]];
        let without_scale = of_laplace(&[1.0, 1.0], 1.0, 0.0);
        for distribution in undrawn.into_iter().map(distribution).chain([without_scale]) {
            assert!(distribution.plots().is_empty(), "{distribution:?}");
        }
    }

    #[test]
    fn values_below_zero_have_bins() {
        let mut of_both_signs = distribution(&[0.1, 0.1, 0.2, 0.5]);
        of_both_signs.values[0] = -0.3;
        let bins = of_both_signs.bins().expect("has values");
        assert!(bins.start <= -0.3 && bins.start > -0.35, "{bins:?}");
        assert!(bins.count <= 200);
    }

    /// Values of both signs have no share of larger values; without a theory nothing is said of one.
    #[test]
    fn what_a_distribution_has_not_is_left_out() {
        let both_signs = of_laplace(&[-0.3, -0.1, 0.1, 0.3], 0.0, 0.2);
        let [plot] = &both_signs.plots()[..] else {
            panic!("one plot");
        };
        assert!(plot.caption.contains("deviation") && !plot.caption.contains("theory"));
        let names: Vec<&str> = plot.marks.iter().map(|mark| mark.name.as_str()).collect();
        assert!(names.contains(&"fitted Laplace") && !names.join(" ").contains("exponential"));
        assert!((both_signs.bins().expect("bins").end() - 1.2).abs() < 1e-9);
    }
}
