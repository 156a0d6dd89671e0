//! History matching: which settings of a simulation cannot have given published figures (Craig, Goldstein, Seheult and Smith 1997;
//! Vernon, Goldstein and Bower, Bayesian Analysis 5, 619, 2010).
//!
//! The implausibility of a setting is |expected − published|/√(variance of what is expected + variance of what was published), the
//! largest over the figures. Settings beyond [`CUT`] are left out; in the others more is simulated, until nothing is left or
//! what is left is known well enough.

use super::emulator::Emulator;
use super::random::{Key, Source, replicates};

/// Any law with one peak is within three deviations with 95 % (Pukelsheim 1994).
pub const CUT: f64 = 3.0;

/// A published figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    pub value: f64,
    /// Of how well the value is known: its own sampling and its printed rounding.
    pub deviation: f64,
}

/// A setting that might have given the figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Coordinates in the unit cube.
    pub at: Vec<f64>,
    /// Of each figure, in their order.
    pub implausibilities: Vec<f64>,
}

impl Candidate {
    pub fn worst(&self) -> f64 {
        self.implausibilities.iter().copied().fold(0.0, f64::max)
    }

    pub fn is_left(&self) -> bool {
        self.worst() <= CUT
    }
}

/// Figures with the emulators of their means, over a space of so many axes.
#[derive(Debug)]
pub struct Match<'a, Snap> {
    pub figures: &'a [(Target, Emulator)],
    pub axes: usize,
    /// Moves coordinates to the nearest setting that there is.
    pub snap: Snap,
}

/// The best candidates from which better ones are looked for, with so many moves of each length.
const BEST: usize = 20;
const MOVES: usize = 60;
const LENGTHS: [f64; 3] = [0.1, 0.03, 0.01];

impl<Snap: Fn(&mut [f64]) + Sync> Match<'_, Snap> {
    pub fn candidate(&self, mut at: Vec<f64>) -> Candidate {
        (self.snap)(&mut at);
        let implausibility = |(target, emulator): &(Target, Emulator)| {
            let found = emulator.at(&at);
            let deviation = (found.variance + target.deviation.powi(2)).sqrt();
            (found.mean - target.value).abs() / deviation
        };
        Candidate {
            implausibilities: self.figures.iter().map(implausibility).collect(),
            at,
        }
    }

    /// So many settings, evenly at random.
    pub fn candidates(&self, key: &Key, count: usize) -> Vec<Candidate> {
        replicates(key, count, |source| {
            self.candidate((0..self.axes).map(|_| source.uniform()).collect())
        })
    }

    /// Less implausible ones near the best of these, the least implausible first; `judge` says by which of the implausibilities.
    pub fn better(
        &self,
        key: &Key,
        from: &[Candidate],
        judge: impl Fn(&Candidate) -> f64 + Sync,
    ) -> Vec<Candidate> {
        let mut best: Vec<&Candidate> = from.iter().collect();
        best.sort_by(|a, b| judge(a).total_cmp(&judge(b)));
        best.truncate(BEST);
        let near = |source: &mut Source| {
            let mut at = best[source.below(best.len())].clone();
            for length in LENGTHS {
                for _ in 0..MOVES {
                    let move_by =
                        |coordinate: &f64| (coordinate + length * source.normal()).clamp(0.0, 1.0);
                    let moved = self.candidate(at.at.iter().map(move_by).collect());
                    if judge(&moved) < judge(&at) {
                        at = moved;
                    }
                }
            }
            at
        };
        let count = if best.is_empty() { 0 } else { BEST };
        let mut found = replicates(key, count, near);
        found.sort_by(|a, b| judge(a).total_cmp(&judge(b)));
        found
    }
}

/// So many of the settings, each as far as can be from those before it; the first is the least implausible.
pub fn spread(candidates: &[Candidate], count: usize) -> Vec<Vec<f64>> {
    let mut nearest = vec![f64::INFINITY; candidates.len()];
    let mut next = (0..candidates.len())
        .min_by(|a, b| candidates[*a].worst().total_cmp(&candidates[*b].worst()));
    let mut chosen: Vec<Vec<f64>> = Vec::new();
    while let Some(place) = next.filter(|place| chosen.len() < count && nearest[*place] > 0.0) {
        let at = &candidates[place].at;
        for (nearest, other) in nearest.iter_mut().zip(candidates) {
            let squares = at.iter().zip(&other.at).map(|(a, b)| (a - b).powi(2));
            *nearest = nearest.min(squares.sum());
        }
        chosen.push(at.clone());
        next = (0..candidates.len()).max_by(|a, b| nearest[*a].total_cmp(&nearest[*b]));
    }
    chosen
}

/// So many points in the unit cube, whose projections on each axis are even (McKay, Beckman and Conover 1979).
pub fn latin_hypercube(source: &mut Source, count: usize, axes: usize) -> Vec<Vec<f64>> {
    let mut points = vec![Vec::with_capacity(axes); count];
    for _ in 0..axes {
        let mut places: Vec<usize> = (0..count).collect();
        source.shuffle(&mut places);
        for (point, place) in points.iter_mut().zip(places) {
            point.push((place as f64 + source.uniform()) / count as f64);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::Observation;

    const KEY: Key = *b"crossgrain: tests of a matching ";

    /// A simulation with two figures of three coordinates; the noise is a tenth of the mean.
    fn simulated(at: &[f64]) -> [f64; 2] {
        [
            12.0 + 8.0 * at[0] - 8.0 * at[1],
            4.0 + 2.0 * at[1] + 3.0 * at[0] * at[2],
        ]
    }

    /// Whether the setting `truth` is left after three waves of 40 settings, and the implausibility of the best one.
    fn waves(run: u64, targets: [f64; 2], truth: &[f64]) -> (bool, f64) {
        let source = &mut Source::new(&KEY, run);
        let targets = targets.map(|value| {
            let deviation = 0.02 * value;
            let value = value + deviation * source.normal();
            Target { value, deviation }
        });
        let mut observed: [Vec<Observation>; 2] = Default::default();
        let mut settings = latin_hypercube(source, 40, 3);
        let mut found = (true, 0.0);
        for wave in 0..3 {
            for at in settings {
                for (all, mean) in observed.iter_mut().zip(simulated(&at)) {
                    let deviation = 0.1 * mean;
                    all.push(Observation {
                        at: at.clone(),
                        group: all.len(),
                        mean: mean + deviation * source.normal(),
                        variance: deviation * deviation,
                    });
                }
            }
            let fit = |observations: &Vec<Observation>| {
                Emulator::of(observations.clone(), 0.0).expect("it fits")
            };
            let figures = targets.into_iter().zip(observed.iter().map(fit));
            let figures: Vec<(Target, Emulator)> = figures.collect();
            let matched = Match {
                figures: &figures,
                axes: 3,
                snap: |_: &mut [f64]| (),
            };
            let key = [run as u8 ^ (wave << 6); 32];
            let mut all = matched.candidates(&key, 1000);
            let best = matched.better(&key, &all, Candidate::worst);
            found.0 &= matched.candidate(truth.to_vec()).is_left();
            found.1 = best[0].worst();
            all.extend(best);
            all.retain(Candidate::is_left);
            if all.is_empty() {
                break;
            }
            settings = spread(&all, 40);
        }
        found
    }

    /// Of sixty runs at most three lose the setting that made the targets.
    #[test]
    fn the_setting_that_made_the_targets_is_left() {
        let truth = [0.3, 0.6, 0.8];
        let all: Vec<(bool, f64)> = (0..60)
            .map(|run| waves(run, simulated(&truth), &truth))
            .collect();
        let lost = all.iter().filter(|run| !run.0).count();
        assert!(lost <= 3, "{lost}");
        assert!(all.iter().all(|run| run.1 < 1.0));
    }

    /// Each target alone is possible, both together are not.
    #[test]
    fn nothing_is_left_where_two_targets_are_at_odds() {
        let all: Vec<(bool, f64)> = (0..60)
            .map(|run| waves(100 + run, [20.0, 9.0], &[1.0, 0.0, 0.0]))
            .collect();
        let found = all.iter().filter(|run| run.1 <= CUT).count();
        assert!(found <= 3, "{found}");
    }

    #[test]
    fn projections_of_a_hypercube_are_even() {
        let points = latin_hypercube(&mut Source::new(&KEY, 0), 50, 4);
        for axis in 0..4 {
            let mut places: Vec<usize> = points
                .iter()
                .map(|point| (50.0 * point[axis]) as usize)
                .collect();
            places.sort_unstable();
            assert_eq!(places, (0..50).collect::<Vec<usize>>());
        }
    }
}
