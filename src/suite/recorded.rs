//! The native engine against YADE where there is no YADE: the first steps of the recorded run, by the
//! digests of its states.

use super::{Group, Line, Rung, Track};
use crate::run::folder::recording;
use grains::case::Case;
use grains::generate::initial_bodies;
use grains::measure::history::HistoryRow;
use grains::model::Model;
use grains::scene::paper_scene;
use grains::tables::Stage;

/// Steps of pouring; enough for three forces on a grain, so that the order of sums shows.
const STEPS: u64 = 3_000;

/// The rung.
pub fn rungs() -> Vec<Rung> {
    // The program carries the record; a broken one leaves no moments, and the rung fails.
    let recorded: Vec<HistoryRow> = recording::history()
        .unwrap_or_default()
        .into_iter()
        .filter(|row| row.stage == Stage::Settle && row.step <= STEPS)
        .collect();
    let scene = paper_scene(1, 5000);
    let case = Case {
        name: "the paper's cloud".to_owned(),
        model: Model::of(&scene),
        bodies: initial_bodies(&scene),
        punch: None,
        moments: recorded.iter().map(|row| row.step).collect(),
    };
    vec![Rung {
        name: "recorded-pouring",
        title: "pouring the paper's 5,000 grains gives the states that YADE gave when it was recorded",
        group: Group::Parity,
        cases: vec![case],
        judge: Box::new(move |tracks| judge(&tracks[0], &recorded)),
    }]
}

fn judge(track: &Track, recorded: &[HistoryRow]) -> Vec<Line> {
    let moments = track.iter().zip(recorded);
    let differing = moments.filter(|(moment, row)| moment.bodies.digest() != row.state);
    let differing = differing.count() + track.len().abs_diff(recorded.len());
    vec![Line {
        quantity: format!("states whose bits differ, of {}", recorded.len()),
        unit: "1".to_owned(),
        value: if recorded.is_empty() {
            f64::NAN
        } else {
            differing as f64
        },
        expected: 0.0,
        tolerance: 0.0,
        basis: "same operations in the same order: every bit".to_owned(),
    }]
}
