//! Stretches of another engine's run that the native engine makes too, while that engine runs: it goes on from a moment that the run has
//! told. What is wrong late in a long run shows there, and no first steps show it.

use std::collections::VecDeque;

use grains::model::Model;
use grains::rules::Rules;
use grains::scene::Scene;
use grains::tables::{Snapshot, Stage};
use grains::task::Until;
use serde::{Deserialize, Serialize};
use verdict::envelope::{FACTOR, REPLICAS, Resolution};
use verdict::excerpt::{Excerpt, STEPS_OF_EXCERPT};
use verdict::judge::OfStart;

/// What the native engine makes of one stretch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Continued {
    pub stage: Stage,
    /// The steps of the stage between which it lies.
    pub from: u64,
    pub to: u64,
    /// How many times as far off the run is as replicas of the native engine in double precision.
    pub ratio: f64,
    /// The same of replicas in single precision, where those in double precision are left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_single: Option<f64>,
    /// Where it is farthest off, in words.
    pub found: String,
}

impl Continued {
    /// Whether the other one begins before this one ends, and both are rounding in double precision.
    fn goes_on_in(&self, other: &Continued) -> bool {
        let both = [self, other];
        let rounding = both
            .iter()
            .all(|stretch| stretch.is_rounding(Resolution::DOUBLE));
        rounding && self.stage == other.stage && (self.from..=self.to).contains(&other.from)
    }

    pub fn is_rounding(&self, resolution: Resolution) -> bool {
        let coarse = self.in_single.filter(|_| !resolution.is_double());
        coarse.unwrap_or(self.ratio) <= FACTOR
    }
}

/// A stretch is of so many moments at equal distances; the end of a stage may be one more.
const MOMENTS: usize = 3;
/// The first stretch ends at this moment of a stage, counted from 0, and each further one at twice the moment; the last one ends with the
/// stage.
const FIRST: usize = 4;
/// Over more steps rounding grows too far.
const LONGEST: u64 = 3 * STEPS_OF_EXCERPT;
/// The liveliest moment is not looked for between moments that are so far apart.
const MOST_BETWEEN: u64 = 10_000;
/// Where the energy changes by less than this factor from look to look, it is nowhere so much larger than at the largest one.
const STEEP: f64 = 1.2;
/// A rule that is missed by this share of its energy is not missed by rounding.
const SETTLED_FOR_SURE: f64 = 1.0e-3;
/// So many grains times steps native goes on for without a gap, in all its runs.
const FOLLOWED: u64 = 400_000_000;
/// Larger beds would cost too much memory.
const LARGEST: usize = 100_000;

/// Moments of small beds are so near to each other that rounding grows little between them.
const NEAR: [u64; 2] = [10, 50];
/// More grains would write too much.
const SMALL: u32 = 500;

/// The scene as an engine is asked for it, with moments between its own if it is small.
pub fn asked_densely(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let every = scene.measurement.history_every;
    let divides = |near: &u64| every.is_multiple_of(*near);
    if scene.particles.count <= SMALL
        && let Some(near) = (NEAR[0]..=NEAR[1]).rev().find(divides)
    {
        scene.measurement.history_every = near;
    }
    scene
}

/// Watches a run.
pub struct Continuing {
    /// With the rules that the engine declares.
    scene: Scene,
    last: VecDeque<Snapshot>,
    /// Of this stage.
    moments: usize,
    /// The largest kinetic energy of a moment of settling, J, and the moment before that one, if there is one.
    peak: f64,
    before_peak: Option<Snapshot>,
    /// Step and kinetic energy, J, of told moments at which the rule of settling looks.
    told: Vec<(u64, f64)>,
    pub found: Vec<Continued>,
    /// Grains times steps that native went on for, in all its runs.
    followed: u64,
}

impl Continuing {
    pub fn new(scene: &Scene, rules: Rules) -> Self {
        let mut scene = scene.clone();
        scene.rules = rules.over(scene.rules);
        Continuing {
            scene,
            last: VecDeque::new(),
            moments: 0,
            peak: 0.0,
            before_peak: None,
            told: Vec::new(),
            found: Vec::new(),
            followed: 0,
        }
    }

    pub fn moment(&mut self, snapshot: &Snapshot) {
        let rises = |last: &Snapshot| last.stage != snapshot.stage || last.step < snapshot.step;
        // Moments against rolling and twisting are in no table.
        let law = Model::in_stage(&self.scene, snapshot.stage).law;
        let is_told = law.contact.rolling.is_none();
        if snapshot.bodies.len() > LARGEST || !is_told || !self.last.back().is_none_or(rises) {
            return;
        }
        if self
            .last
            .back()
            .is_some_and(|last| last.stage != snapshot.stage)
        {
            self.end_of_stage(true);
        }
        let energy = snapshot.bodies.kinetic_energy();
        let is_look = snapshot.step.is_multiple_of(self.scene.settle.check_every);
        if snapshot.stage == Stage::Settle && is_look && snapshot.step > 0 {
            self.told.push((snapshot.step, energy));
        }
        if snapshot.stage == Stage::Settle && energy > self.peak {
            self.peak = energy;
            self.before_peak = Some(self.last.back().unwrap_or(snapshot).clone());
        }
        if self.last.len() > MOMENTS {
            self.last.pop_front();
        }
        self.last.push_back(snapshot.clone());
        let is_small = self.followed < FOLLOWED;
        if self.moments >= FIRST && self.moments.is_power_of_two() {
            self.judge(MOMENTS);
        } else if is_small && self.moments > 0 {
            self.judge(2);
        }
        self.moments += 1;
    }

    /// The last moments of a stage that a rule has ended, or the number of its steps.
    pub fn end_of_stage(&mut self, by_rule: bool) {
        let last = self
            .last
            .back()
            .map(|snapshot| (snapshot.stage, snapshot.step));
        let judged = self.found.last().map(|stretch| (stretch.stage, stretch.to));
        if last != judged {
            let steps: Vec<u64> = self.last.iter().map(|snapshot| snapshot.step).collect();
            let is_short = matches!(steps[..], [_, a, b, c] if b + b > a + c);
            self.judge(MOMENTS + usize::from(is_short));
        }
        if by_rule {
            let missed = self.settled_before();
            self.found.extend(missed);
        }
        (self.moments, self.last) = (0, VecDeque::new());
    }

    /// That the rule of settling held at an earlier look, or does not hold at the last one: by told moments where every look is one, or
    /// as native goes on from the moment before the last ones, with the largest energy at a look around the liveliest moment, which may
    /// have been larger elsewhere; then the rule held earlier still.
    fn settled_before(&self) -> Option<Continued> {
        let end = self.last.back()?;
        let is_near = |snapshot: &&Snapshot| end.step - snapshot.step <= LONGEST;
        let first = self.last.iter().find(is_near)?;
        let [check, history] = [
            self.scene.settle.check_every,
            self.scene.measurement.history_every,
        ];
        let all_told = check.is_multiple_of(history);
        let (at_peak, looks) = match all_told {
            true => (self.told.clone(), self.told.clone()),
            false => {
                let before = self.before_peak.as_ref()?;
                let at_peak = self.looks(before, before.step + 2 * history)?;
                (at_peak, self.looks(first, end.step)?)
            }
        };
        // A window without a look says nothing of what the rule has seen.
        let peak = at_peak.iter().map(|look| look.1).reduce(f64::max)?;
        let most = self.scene.settle.kinetic_energy_fraction * peak;
        let held =
            |look: &&(u64, f64)| look.0 < end.step && look.1 <= most * (1.0 - SETTLED_FOR_SURE);
        let left = end.bodies.kinetic_energy();
        let ratios = at_peak.windows(2).map(|pair| pair[1].1 / pair[0].1);
        let mut steep = ratios.filter(|ratio| !(1.0 / STEEP..=STEEP).contains(ratio));
        let is_exact = all_told || steep.next().is_none();
        let found = match looks.iter().find(held) {
            Some((step, energy)) => format!(
                "the rule of settling held at step {step} already: {energy:e} J, {most:e} J at most"
            ),
            // Elsewhere between two moments the energy may have been a little larger.
            None if left > STEEP * most && is_exact => format!(
                "the rule of settling does not hold at step {}: {left:e} J, {most:e} J at most",
                end.step
            ),
            None => return None,
        };
        Some(Continued {
            stage: end.stage,
            from: first.step,
            to: end.step,
            ratio: f64::MAX,
            // At rest such grains have energies of their rounding.
            in_single: Some(0.0),
            found,
        })
    }

    /// Step and kinetic energy, J, at each look of the rule of settling after this moment, as native makes them.
    fn looks(&self, first: &Snapshot, last: u64) -> Option<Vec<(u64, f64)>> {
        if first.stage != Stage::Settle || last - first.step > 2 * MOST_BETWEEN {
            return None;
        }
        let mut excerpt = Excerpt::of_moments(&self.scene, first, last).ok()?;
        let every = self.scene.settle.check_every;
        excerpt.scene.measurement.history_every = every;
        let looks = excerpt.native(None).ok()?.into_iter();
        let looks = looks
            .filter(|snapshot| snapshot.step > first.step && snapshot.step.is_multiple_of(every));
        Some(
            looks
                .map(|snapshot| (snapshot.step, snapshot.bodies.kinetic_energy()))
                .collect(),
        )
    }

    /// What native cannot go on from is no stretch; up to where stretches reach is said.
    fn judge(&mut self, moments: usize) {
        let is_long = |snapshots: &[Snapshot]| {
            let steps = [snapshots.first(), snapshots.last()]
                .map(|end| end.map_or(0, |snapshot| snapshot.step));
            steps[1].saturating_sub(steps[0]) > LONGEST
        };
        let before = self.last.len().saturating_sub(moments);
        let mut moments: Vec<Snapshot> = self.last.iter().skip(before).cloned().collect();
        // Of a job that begins with loading nobody says whether the punch touches already: it is where it just would.
        let begins = |snapshots: &[Snapshot]| {
            let first = snapshots.first();
            first.is_some_and(|snapshot| snapshot.stage == Stage::Load && snapshot.step == 0)
        };
        while is_long(&moments) || begins(&moments) {
            moments.remove(0);
        }
        let [first, .., last] = &moments[..] else {
            return;
        };
        let (stage, from, to) = (first.stage, first.step, last.step);
        let work = to.saturating_sub(from) * first.bodies.len() as u64;
        let speed = |snapshot: &Snapshot| snapshot.punch.map(|punch| punch.velocity);
        let stops = stage == Stage::Load && speed(first) != speed(last);
        let Ok(mut excerpt) = Excerpt::of_moments(&self.scene, first, to) else {
            return;
        };
        // Where it stops is for its rule to say.
        if stops {
            excerpt.task.until = Until::EndOfLoading;
        }
        self.followed += work;
        // However far rounding would take grains, there is none.
        if excerpt.has_bits(&moments) {
            return self.found_more(Continued {
                stage,
                from,
                to,
                ratio: 0.0,
                in_single: None,
                found: "every bit is native's".to_owned(),
            });
        }
        self.followed += REPLICAS * work;
        let judge =
            |resolution: Resolution| excerpt.judge(Ok((moments.clone(), None)), resolution).ok();
        let ratio = |state: &OfStart| {
            let far = state.farthest.as_ref();
            far.map_or(f64::MAX, |farthest| farthest.ratio.min(f64::MAX))
        };
        let double = judge(Resolution::COARSE_DOUBLE);
        // Where the rule holds at another step there is nothing to hold against: other checks judge the step.
        let is_held = |state: &OfStart| state.farthest.is_some() || !stops;
        let Some(double) = double.filter(is_held) else {
            return;
        };
        // Where rounding takes grains anywhere nothing is seen: the stretch ends at the moment before.
        let narrow =
            |snapshot: &&Snapshot| double.wide_from.is_none_or(|step| snapshot.step < step);
        let to = match ratio(&double) > FACTOR {
            true => to,
            false => moments.iter().rfind(narrow).map_or(from, |last| last.step),
        };
        if to == from {
            return;
        }
        let single = Some(&double).filter(|state| ratio(state) > FACTOR);
        let single = single.and_then(|_| judge(Resolution::SINGLE));
        let stretch = Continued {
            stage,
            from,
            to,
            ratio: ratio(&double),
            in_single: single.as_ref().map(ratio),
            found: double.skipped.clone().unwrap_or(double.in_words()),
        };
        self.found_more(stretch);
    }

    /// Those that follow each other are one, as long as both are rounding.
    fn found_more(&mut self, stretch: Continued) {
        match self.found.last_mut() {
            Some(before) if before.goes_on_in(&stretch) => {
                before.to = stretch.to;
                if stretch.ratio > before.ratio {
                    (before.ratio, before.found) = (stretch.ratio, stretch.found);
                }
            }
            _ => self.found.push(stretch),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Continuing, Rules, Snapshot, Stage, asked_densely};
    use grains::scene::paper_scene;
    use grains::tables::{Bodies, Memories};

    /// One grain of 1 kg with this kinetic energy, J.
    fn moment(step: u64, energy: f64) -> Snapshot {
        let mut bodies = Bodies::default();
        bodies.push([0.5, 0.5], [(2.0 * energy).sqrt(), 0.0], 0.005, 1.0);
        Snapshot {
            stage: Stage::Settle,
            step,
            time: 0.0,
            bodies,
            contacts: Vec::new(),
            across: Vec::new(),
            memory: Memories::default(),
            punch: None,
        }
    }

    #[test]
    fn small_beds_are_asked_for_moments_between_those_of_the_scene() {
        let every = |grains, every| {
            let mut scene = paper_scene(1, grains);
            scene.measurement.history_every = every;
            asked_densely(&scene).measurement.history_every
        };
        assert_eq!(
            [every(500, 250), every(500, 96), every(500, 20)],
            [50, 48, 20]
        );
        // No divisor is long enough, and too many grains.
        assert_eq!([every(500, 997), every(501, 250)], [997, 250]);
    }

    #[test]
    fn the_rule_of_settling_is_judged_by_its_looks_and_not_by_moments_between_them() {
        let scene = paper_scene(1, 5);
        let (check, history) = (scene.settle.check_every, scene.measurement.history_every);
        assert!(check.is_multiple_of(history) && check > 2 * history);
        let missed = |left: f64| {
            let mut continuing = Continuing::new(&scene, Rules::default());
            // The liveliest moment, and two moments after it, are before the first look.
            continuing.before_peak = Some(moment(0, 5.0));
            continuing.told = vec![(check, 1.0), (2 * check, left)];
            continuing.last = [moment(2 * check - history, left), moment(2 * check, left)].into();
            continuing.settled_before().map(|missed| missed.found)
        };
        let share = scene.settle.kinetic_energy_fraction;
        assert_eq!(missed(0.5 * share), None);
        let found = missed(2.0 * share).expect("it does not hold");
        assert!(found.contains("does not hold at step 2000"), "{found}");
    }
}
