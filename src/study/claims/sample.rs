//! Samples, one number a realization, out of a campaign's members, and intervals of them as functions of the level.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::study::campaign::{Fields, Member};
use evidence::distribution::Family;
use evidence::likelihood::against_exponential;
use evidence::zeros::Parted;
use evidence::{Interval, bootstrap, moments, proportion};
use grains::measure::neighbourhood::{Neighbour, Neighbourhood, Together};

/// When the bed is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Moment {
    /// Under gravity alone.
    Settled,
    /// When the force is reached.
    Loaded,
}

impl Moment {
    pub const BOTH: [Moment; 2] = [Moment::Loaded, Moment::Settled];

    /// As in keys of measured quantities.
    pub fn key(self) -> &'static str {
        match self {
            Moment::Settled => "settled",
            Moment::Loaded => "loaded",
        }
    }

    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Moment::Settled => "gravity alone",
            Moment::Loaded => "under the load",
        }
    }

    fn fields(self, member: &Member) -> Option<&Fields> {
        match self {
            Moment::Settled => member.settled.as_ref(),
            Moment::Loaded => member.loaded.as_ref(),
        }
    }
}

/// A measured quantity of all members that have it.
pub fn measured(members: &[Member], key: &str) -> Vec<f64> {
    let values = members.iter().filter_map(|member| member.measured.get(key));
    values.copied().collect()
}

/// A stress at a control point: `what` is the end of its key, `grain_zz`.
pub fn stress(members: &[Member], moment: Moment, point: &str, what: &str) -> Vec<f64> {
    measured(members, &format!("{}.stress.{point}.{what}", moment.key()))
}

fn around<'a>(member: &'a Member, moment: Moment, point: &str) -> Option<&'a Neighbourhood> {
    let points = &moment.fields(member)?.points;
    points.iter().find(|around| around.point == point)
}

/// The nearest grains of a point, in every member that has so many.
pub fn nearest<'a>(
    members: &'a [Member],
    moment: Moment,
    point: &str,
    count: usize,
) -> Vec<&'a [Neighbour]> {
    let singly = members
        .iter()
        .filter_map(|member| around(member, moment, point)?.singly.get(..count));
    singly.collect()
}

pub fn together(members: &[Member], moment: Moment, point: &str, grains: usize) -> Vec<Together> {
    let cells = |member| {
        let volumes = &around(member, moment, point)?.together;
        volumes.iter().find(|one| one.grains == grains).copied()
    };
    members.iter().filter_map(cells).collect()
}

/// A number over packings: its interval at any level.
pub struct Number<'a> {
    pub packings: usize,
    /// Those included whose value was set aside.
    pub looked_at: usize,
    interval: Box<dyn Fn(f64) -> Option<Interval> + 'a>,
}

impl<'a> Number<'a> {
    pub fn new(packings: usize, interval: impl Fn(f64) -> Option<Interval> + 'a) -> Self {
        Number {
            packings,
            looked_at: packings,
            interval: Box::new(interval),
        }
    }

    /// Out of so many packings, of which the others were set aside.
    pub fn out_of(self, looked_at: usize) -> Self {
        Number { looked_at, ..self }
    }

    pub fn at(&self, level: f64) -> Option<Interval> {
        (self.interval)(level)
    }

    pub fn over(self, other: f64) -> Self {
        let looked_at = self.looked_at;
        let over = Number::new(self.packings, move |level| {
            Some(self.at(level)?.over(other))
        });
        over.out_of(looked_at)
    }
}

/// Mean with its t interval.
pub fn mean(values: &[f64]) -> Number<'_> {
    Number::new(values.len(), |level| moments::mean_interval(values, level))
}

/// Standard deviation over mean with its BCa interval over packings.
pub fn variation(values: &[f64]) -> Number<'_> {
    Number::new(values.len(), |level| {
        bootstrap::coefficient_of_variation(values, level)
    })
}

/// Share of packings whose value was set aside, with Wilson's interval.
pub fn zeros(parted: &Parted) -> Number<'_> {
    Number::new(parted.zeros + parted.others.len(), |level| {
        parted.share_of_zeros(level)
    })
}

/// Share of so many packings, with Wilson's interval.
pub fn share(hits: usize, packings: usize) -> Number<'static> {
    Number::new(packings, move |level| {
        proportion::wilson(hits, packings, level)
    })
}

/// Shape of the gamma or Weibull law with its deviance interval. That one is of 95 %; other levels have the ends
/// where a normal logarithm of the shape would have them.
pub fn law_shape(family: Family, values: &[f64]) -> Number<'static> {
    let found = against_exponential(family, values).map(|found| found.shape);
    Number::new(values.len(), move |level| {
        let interval = found?;
        let normal = Normal::standard();
        let reach = normal.inverse_cdf(0.5 + 0.5 * level) / normal.inverse_cdf(0.975);
        Some(Interval {
            estimate: interval.estimate,
            low: interval.estimate * (interval.low / interval.estimate).powf(reach),
            high: interval.estimate * (interval.high / interval.estimate).powf(reach),
        })
    })
}
