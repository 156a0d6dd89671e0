//! The goals of this project for its speed, and whether this run met them. Findings, never failures: a busy or an
//! unusual machine gives other times.

use serde::Serialize;

use super::contender::Contender;
use super::rounds::Contest;
use super::scaling::Point;
use super::spread::Spread;

/// A goal and what was measured of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Goal {
    /// What it says.
    pub goal: String,
    /// The bound.
    pub bound: f64,
    /// Whether the measured value must be at least or at most the bound.
    pub at_least: bool,
    /// Median; none where it could not be measured.
    pub measured: Option<f64>,
    /// Least and most of the rounds.
    pub range: Option<[f64; 2]>,
    /// Whether the median meets it.
    pub met: Option<bool>,
}

fn goal(text: &str, bound: f64, at_least: bool, of: Option<&Spread>) -> Goal {
    let measured = of.map(|spread| spread.median);
    Goal {
        goal: text.to_owned(),
        bound,
        at_least,
        measured,
        range: of.map(|spread| [spread.least, spread.most]),
        met: measured.map(|value| {
            if at_least {
                value >= bound
            } else {
                value <= bound
            }
        }),
    }
}

/// All goals, held against these figures.
pub fn goals(contests: &[Contest], points: &[Point]) -> Vec<Goal> {
    let of = |wanted: Contender| contests.iter().find(|of| of.contender == wanted);
    let over_exact = |wanted| of(wanted).and_then(|contest| contest.over_exact.as_ref());
    let growth = growth("native exact", points);
    let yade = of(Contender::YadeOrdinary);
    vec![
        goal(
            "native exact against YADE's ordinary loop, times as fast a step",
            30.0,
            true,
            over_exact(Contender::YadeOrdinary),
        ),
        goal(
            "native exact against LAMMPS gran/hooke, times as fast a step",
            7.0,
            true,
            over_exact(Contender::Lammps),
        ),
        goal(
            "native free against YADE's ordinary loop, times as fast a step",
            45.0,
            true,
            yade.and_then(|contest| contest.over_free.as_ref()),
        ),
        goal(
            "native exact, cost of a grain at 100,000 grains over that at 5,000",
            1.6,
            false,
            growth.as_ref(),
        ),
    ]
}

/// Cost of a grain at 100,000 grains over that at the paper's 5,000, repeat by repeat.
pub fn growth(name: &str, points: &[Point]) -> Option<Spread> {
    let at = |grains: u32| {
        let of = |point: &&Point| point.name == name && point.grains == grains;
        points.iter().find(of)
    };
    let (few, many) = (at(super::bed::PAPER)?, at(100_000)?);
    let ratio = Spread::ratio(&many.seconds_per_step, &few.seconds_per_step)?;
    let grains = f64::from(many.grains) / f64::from(few.grains);
    Spread::of(ratio.all.iter().map(|of| of / grains).collect())
}
