//! A scene of the map on its way to a row: predicted, found and judged.

use super::growth::{Disturbed, Found};
use super::map::{ALLOWED, ALPHA, Limits, Row, Wanted};
use super::network::Network;
use super::proposals::by_formula;
use super::rounds::Search;
use super::scenes::MapScene;
use super::spectrum::{fastest_mode, limit};
use crate::compare::{Check, Verdict};
use grains::case::Case;
use grains::native::NativeError;

/// A scene on its way to a row.
pub struct Draft {
    /// What is known of it.
    pub row: Row,
    /// The scene at rest.
    pub case: Case,
    at_random: Disturbed,
    in_mode: Disturbed,
}

impl Draft {
    /// Predicts the limits of a scene and finds them in the native engine, if that is wanted.
    pub fn new(scene: MapScene, search: bool) -> Result<Self, NativeError> {
        let network = Network::of(&scene.case)?;
        let [springs, braked] = [0.0, ALPHA].map(|alpha| limit(&network, alpha));
        let mode = fastest_mode(&network, ALPHA);
        let at_random = Disturbed::at_random(&scene.case, scene.axes)?;
        let in_mode = Disturbed::in_mode(&scene.case, &mode)?;
        let mut undamped = None;
        let mut damped = None;
        let mut damped_at_random = None;
        if search {
            undamped = at_random.undamped()?;
            if let Some(undamped) = &undamped {
                damped = in_mode.damped(ALPHA, undamped)?;
                damped_at_random = at_random.damped(ALPHA, undamped)?;
            }
        }
        let limits = |alpha, predicted, native| Limits {
            alpha,
            predicted,
            native,
            yade: None,
            exec: None,
        };
        Ok(Draft {
            row: Row {
                name: scene.name,
                title: scene.title,
                remark: scene.remark,
                grains: scene.case.bodies.len(),
                contacts: network.contacts(),
                omega: springs.omega,
                vectors: springs.vectors,
                residual: springs.residual,
                closed: scene.closed,
                undamped: limits(0.0, springs.dt, undamped),
                damped: limits(ALPHA, braked.dt, damped),
                damped_at_random,
                proposal: by_formula(&scene.case)?,
                proposal_of_yade: None,
                not_made: None,
                checks: Vec::new(),
            },
            case: scene.case,
            at_random,
            in_mode,
        })
    }

    /// What another engine is to look for: without damping at random, with damping in the fastest mode.
    pub fn searches(&self) -> [Search; 2] {
        let about = |limits: &Limits| limits.native.map_or(limits.predicted, |found| found.limit);
        let of = |disturbed: &Disturbed, limits: &Limits| {
            Search::new(disturbed.clone(), limits.alpha, about(limits))
        };
        [
            of(&self.at_random, &self.row.undamped),
            of(&self.in_mode, &self.row.damped),
        ]
    }

    /// The row with its checks: those of the engines whose limits were wanted.
    pub fn judged(self, wanted: &Wanted) -> Row {
        let mut row = self.row;
        if let Some(closed) = &row.closed {
            let off = row.undamped.predicted / closed.dt - 1.0;
            row.checks.push(Check {
                name: "predicted against the closed form".to_owned(),
                verdict: verdict(off.abs() <= closed.tolerance),
                found: format!(
                    "{} apart, {} allowed",
                    percent(off),
                    percent(closed.tolerance)
                ),
            });
        }
        for limits in [row.undamped, row.damped] {
            if wanted.native() {
                row.checks.push(of_limit("native", &limits, limits.native));
            }
            if wanted.yade() {
                row.checks.push(of_limit("YADE", &limits, limits.yade));
            }
            if let (Wanted::Exec(engine), None) = (wanted, &row.not_made) {
                let name = &engine.description.name;
                row.checks.push(of_limit(name, &limits, limits.exec));
            }
        }
        row
    }
}

/// What the check of a limit is called.
pub fn name_of(engine: &str, alpha: f64) -> String {
    format!("{engine} against predicted, α = {alpha}")
}

fn of_limit(engine: &str, limits: &Limits, found: Option<Found>) -> Check {
    let name = name_of(engine, limits.alpha);
    match found {
        Some(found) => {
            let off = found.limit / limits.predicted - 1.0;
            Check {
                name,
                verdict: verdict(off.abs() <= ALLOWED),
                found: format!("{} apart, {} allowed", percent(off), percent(ALLOWED)),
            }
        }
        None => Check {
            name,
            verdict: Verdict::NotMade,
            found: "no limit was found".to_owned(),
        },
    }
}

fn verdict(holds: bool) -> Verdict {
    if holds { Verdict::Pass } else { Verdict::Fail }
}

/// `+0.12 %`
pub fn percent(share: f64) -> String {
    format!("{:+.2} %", 100.0 * share)
}
