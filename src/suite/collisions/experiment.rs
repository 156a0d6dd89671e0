//! What the rungs on collisions have in common: experiments made of cases, and how their tracks are read.

use crate::suite::{Group, Line, Rung, Track};
use grains::case::Case;
use grains::tables::{Bodies, Contact, Snapshot};

/// Some cases that are judged together.
pub trait Experiment: Send + Sync {
    /// What is run.
    fn cases(&self) -> Vec<Case>;
    /// What the tracks of the cases show.
    fn lines(&self, tracks: &[Track]) -> Vec<Line>;
}

/// A rung of these experiments.
pub fn rung(
    name: &'static str,
    title: &'static str,
    experiments: Vec<Box<dyn Experiment>>,
) -> Rung {
    let cases: Vec<Vec<Case>> = experiments.iter().map(|of| of.cases()).collect();
    let counts: Vec<usize> = cases.iter().map(Vec::len).collect();
    Rung {
        name,
        title,
        group: Group::Exact,
        cases: cases.into_iter().flatten().collect(),
        judge: Box::new(move |tracks| {
            let mut rest = tracks;
            let mut lines = Vec::new();
            for (experiment, count) in experiments.iter().zip(&counts) {
                let (own, others) = rest.split_at((*count).min(rest.len()));
                lines.extend(experiment.lines(own));
                rest = others;
            }
            lines
        }),
    }
}

/// One moment of a track. What is not there reads as not a number, which no line takes for right.
#[derive(Clone, Copy)]
pub struct View<'a>(Option<&'a Snapshot>);

/// The state of the case with this index after this step.
pub fn view(tracks: &[Track], case: usize, step: u64) -> View<'_> {
    let track = tracks.get(case).map_or(&[][..], Vec::as_slice);
    View(track.iter().find(|snapshot| snapshot.step == step))
}

impl<'a> View<'a> {
    /// Centre of a grain, m.
    pub fn position(self, id: usize) -> [f64; 2] {
        self.pair(id, |bodies| [&bodies.x, &bodies.z])
    }

    /// Velocity of a grain at the half step before, m/s.
    pub fn velocity(self, id: usize) -> [f64; 2] {
        self.pair(id, |bodies| [&bodies.vx, &bodies.vz])
    }

    /// Spin of a grain at the half step before, rad/s.
    pub fn spin(self, id: usize) -> f64 {
        self.pair(id, |bodies| [&bodies.spin, &bodies.spin])[0]
    }

    /// The contact with the lowest ids.
    pub fn contact(self) -> Option<&'a Contact> {
        self.0.and_then(|snapshot| snapshot.contacts.first())
    }

    fn pair(self, id: usize, columns: fn(&Bodies) -> [&Vec<f64>; 2]) -> [f64; 2] {
        self.0.map_or([f64::NAN; 2], |snapshot| {
            columns(&snapshot.bodies).map(|column| column.get(id).copied().unwrap_or(f64::NAN))
        })
    }
}

/// The largest of these, not a number if one of them is not.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a >= b { a } else { b };
    values.into_iter().fold(0.0, |most, value| {
        if value.is_nan() || f64::is_nan(most) {
            f64::NAN
        } else {
            larger(most, value)
        }
    })
}
