//! Samples, one number a packing, out of a campaign's members.

use crate::study::campaign::member::{Fields, Member};
use grains::measure::neighbourhood::{Neighbour, Neighbourhood, Together};

/// When the bed is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// Under gravity alone.
    Settled,
    /// When the force is reached.
    Loaded,
}

impl Moment {
    /// Both.
    pub const BOTH: [Moment; 2] = [Moment::Loaded, Moment::Settled];

    /// As in keys of measured quantities.
    pub fn key(self) -> &'static str {
        match self {
            Moment::Settled => "settled",
            Moment::Loaded => "last",
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
            Moment::Loaded => member.last.as_ref(),
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

/// The nearest so many cells together.
pub fn together(members: &[Member], moment: Moment, point: &str, grains: usize) -> Vec<Together> {
    let of = |member| {
        let volumes = &around(member, moment, point)?.together;
        volumes.iter().find(|one| one.grains == grains).copied()
    };
    members.iter().filter_map(of).collect()
}

/// Those above zero.
pub fn positive(values: &[f64]) -> Vec<f64> {
    let above = values.iter().filter(|value| **value > 0.0);
    above.copied().collect()
}
