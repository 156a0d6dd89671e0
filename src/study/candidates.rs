//! Settings on the same packings: which published figures each of them gives; and taken apart, what the bed bears before the load
//! and what the load adds, against the theory's two parts.

pub mod document;
pub mod judge;

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::study::candidates::judge::Candidates;
use crate::study::change::{Change, What, changed};
use crate::study::member::{Beds, MIRRORED, Members, OfBeds};
use crate::study::realization::{LAWS, Setting, Specification};
use crate::study::search::matching::{Search, keep};
use crate::study::search::space;
use crate::study::{Judged, StudyError};
use grains::scene::{ControlPoint, Scene};

/// Kinetic energy over its peak at which nothing moves any more.
const REST: f64 = 1.0e-6;
/// Friction angle of the loads with friction, rad.
const FRICTION: f64 = 0.3;
/// Speeds of the punch on beds at rest, m/s, each half of the one before; without friction the slowest go on for very long, and
/// none is needed to see what becomes of them.
const SPEEDS: [f64; 4] = [0.08, 0.04, 0.02, 0.01];
const ALL: usize = SPEEDS.len();
/// Of beds without friction or whose grains do not turn.
const FEW: usize = 3;
/// Of B, m: a smaller scene has its points nearer.
const PAPER_FARTHEST: f64 = 0.15;
/// Distances from the punch's axis at the control points' depth, m.
const ASIDE: [f64; 7] = [0.02, 0.04, 0.06, 0.11, 0.19, 0.25, 0.32];
/// Depths under the punch, m.
const BELOW: [f64; 5] = [0.04, 0.07, 0.16, 0.22, 0.3];

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    pub beds: Beds,
    pub ladders: Vec<Ladder>,
}

/// Settings that differ in the punch's speed alone, half as fast each time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ladder {
    pub name: String,
    /// Their ids.
    pub settings: Vec<String>,
}

impl Plan {
    /// Our default, the way to its quasi-static limit, and the best settings of a search.
    pub fn new(quick: bool, clouds: u64, found: Option<&Search>, best: usize) -> Self {
        let printed = with_lines(space::printed(quick));
        let base = with_lines(space::base(quick));
        let setting = |id: &str, name: &str, scene: Scene| {
            Setting::new(id, name, "candidates", Specification::native(scene), clouds)
        };
        let frictional = changed(base.clone(), &[(What::FrictionInLoading, FRICTION)]);
        let stiff = changed(frictional.clone(), &[(What::BlockedInLoading, 1.0)]);
        let poured = changed(base.clone(), &[(What::Friction, FRICTION)]);
        let name = format!("friction {FRICTION} rad in loading");
        let without = format!("{name}, grains do not turn");
        let in_both = format!("friction {FRICTION} rad in both stages");
        let frictional = setting("friction", &name, frictional);
        let mut beds = vec![
            vec![setting("printed", PRINTED, printed)],
            vec![frictional, setting("blocked", &without, stiff)],
            vec![setting("poured", &in_both, poured)],
        ];
        let rest = changed(base, &[(What::Settled, REST)]);
        let (mut at_rest, mut ladders) = (Vec::new(), Vec::new());
        let rough = changed(rest.clone(), &[(What::FrictionInLoading, FRICTION)]);
        let stiff = changed(rough.clone(), &[(What::BlockedInLoading, 1.0)]);
        let stiffly = "with friction, grains do not turn";
        for (kind, words, scene, speeds) in [
            ("rest", "without friction", rest, FEW),
            ("rest-friction", "with friction in loading", rough, ALL),
            ("rest-blocked", stiffly, stiff, FEW),
        ] {
            let settings = SPEEDS.iter().take(speeds).map(|speed| {
                let scene = changed(scene.clone(), &[(What::PunchSpeed, *speed)]);
                let name = format!("bed at rest, {words}, {speed} m/s");
                setting(&format!("{kind}-{speed}"), &name, scene)
            });
            let settings: Vec<Setting> = settings.collect();
            ladders.push(Ladder {
                name: words.to_owned(),
                settings: settings.iter().map(|setting| setting.id.clone()).collect(),
            });
            at_rest.extend(settings);
        }
        beds.push(at_rest);
        for (index, expectation) in found
            .iter()
            .flat_map(|search| &search.best)
            .take(best)
            .enumerate()
        {
            let rank = index + 1;
            let (id, name) = (
                format!("best-{rank}"),
                format!("number {rank} of the search"),
            );
            let scene = with_lines(space::scene(&space::base(quick), &expectation.at));
            beds.push(vec![Setting {
                at: expectation.at.clone(),
                ..setting(&id, &name, scene)
            }]);
        }
        Plan {
            beds: Beds(beds),
            ladders,
        }
    }
}

/// With points along the depth of the control points, on both sides, and under the punch.
fn with_lines(mut scene: Scene) -> Scene {
    let depth = scene
        .control_points
        .first()
        .map_or(0.0, |point| point.depth);
    let farthest = scene.control_points.iter().map(|point| point.offset);
    let scale = farthest.fold(0.0, f64::max) / PAPER_FARTHEST;
    let point = |name: String, offset, depth| ControlPoint {
        name,
        offset,
        depth,
    };
    for offset in ASIDE {
        let name = format!("aside {:.0} mm", 1.0e3 * scale * offset);
        let other = format!("{}{name}", MIRRORED);
        let points = [(name, offset), (other, -offset)];
        let points = points.map(|(name, offset)| point(name, scale * offset, depth));
        scene.control_points.extend(points);
    }
    let below = BELOW.map(|below| point(format!("below {:.0} mm", 1.0e3 * below), 0.0, below));
    scene.control_points.extend(below);
    scene
}

impl OfBeds for Plan {
    const NAME: &'static str = "candidates";

    fn beds(&self) -> &Beds {
        &self.beds
    }

    fn is_whole(&self) -> Result<(), String> {
        let known = |id: &String| self.beds.settings().any(|setting| setting.id == *id);
        let mut ladders = self.ladders.iter().flat_map(|ladder| &ladder.settings);
        match ladders.find(|id| !known(id)) {
            Some(id) => Err(format!("there is no setting {id}")),
            None => Ok(()),
        }
    }

    fn keeps(key: &str) -> bool {
        keep(key) || key.starts_with(LAWS)
    }

    fn judged(&self, members: &Members) -> Result<Judged, StudyError> {
        let record = Candidates::of(self, members);
        Judged::of(Self::NAME, &record, record.document())
    }
}

pub const PRINTED: &str = "our default";
/// Id of the search's least implausible setting.
const BEST: &str = "best-1";
const SPEED_AND_DAMPING: &str = "punch speed and damping";

/// A choice, the unit of its values, what the paper says and why the range is what it is, and what a value changes: `choices.json`, read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Choice {
    name: &'static str,
    unit: &'static str,
    reason: &'static str,
    change: What,
    values: Vec<f64>,
    /// With `--quick`.
    #[serde(default)]
    few: Vec<f64>,
    /// Open, and no axis of the search: varied around its best setting too.
    #[serde(default)]
    is_beside_search: bool,
    /// What the paper's words may mean physically, and no value that they leave out.
    #[serde(default)]
    is_reading: bool,
}

static CHOICES: LazyLock<Vec<Choice>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("candidates/choices.json")).expect("it is a list of choices")
});

/// What the paper says of a choice, and why its range is what it is.
pub fn reasons() -> impl Iterator<Item = (&'static str, &'static str)> {
    let first = (
        SPEED_AND_DAMPING,
        "'gently' and 'spring-dashpot' without numbers; from where punches sink to where the force is an impact, and from \
         hardly damped to YADE's examples of quasi-static runs. Damping is that of pouring and loading",
    );
    std::iter::once(first).chain(CHOICES.iter().map(|choice| (choice.name, choice.reason)))
}

impl Plan {
    /// The choices that the paper leaves open, one at a time around our default; or around the best setting of a search, those
    /// that are no axes of it. What they are varied around is first; settings that pour alike share their beds.
    ///
    /// With `readings` alone, those that read the paper's words in another way, around either.
    pub fn of_choices(quick: bool, clouds: u64, found: Option<&Search>, readings: bool) -> Self {
        let best = found.and_then(|search| search.best.first());
        let printed = space::base(quick);
        let base = best.map_or(printed.clone(), |expectation| {
            space::scene(&printed, &expectation.at)
        });
        let mut beds: Vec<Vec<Setting>> = Vec::new();
        let mut add = |id: &str, name: &str, axis: &str, at: &[f64], changes: &[Change]| {
            let specification = Specification::native(changed(base.clone(), changes));
            if !changes.is_empty() && specification.scene == base {
                return;
            }
            let mut setting = Setting::new(id, name, axis, specification, clouds);
            setting.at = at.to_vec();
            let specification = &setting.specification;
            let same = |bed: &&mut Vec<Setting>| bed[0].specification.pours_like(specification);
            match beds.iter_mut().find(same) {
                Some(bed) => bed.push(setting),
                None => beds.push(vec![setting]),
            }
        };
        match best {
            Some(expectation) => add(
                BEST,
                "the search's best setting",
                BEST,
                &expectation.at,
                &[],
            ),
            None => add("printed", PRINTED, PRINTED, &[], &[]),
        }
        let (speeds, alphas): (&[f64], &[f64]) = match quick {
            _ if found.is_some() || readings => (&[], &[]),
            true => (&[0.05, 0.5], &[0.8]),
            false => (&[0.05, 0.07, 0.1, 0.2, 0.5], &[0.05, 0.1, 0.2, 0.4, 0.8]),
        };
        for alpha in alphas {
            for speed in speeds {
                let changes = [(What::Alpha, *alpha), (What::PunchSpeed, *speed)];
                let id = format!("speed-{speed}-alpha-{alpha}");
                let name = format!("{speed} m/s, α = {alpha}");
                add(&id, &name, SPEED_AND_DAMPING, &[*speed, *alpha], &changes);
            }
        }
        let all = CHOICES.iter();
        let taken = |choice: &&Choice| match readings {
            true => choice.is_reading,
            false => found.is_none() || choice.is_beside_search,
        };
        for choice in all.filter(taken) {
            let word = choice.name.replace([',', ' '], "-").replace("--", "-");
            for value in if quick { &choice.few } else { &choice.values } {
                let name = format!("{}: {value} {}", choice.name, choice.unit);
                let changes = [(choice.change, *value)];
                add(
                    &format!("{word}-{value}"),
                    &name,
                    choice.name,
                    &[*value],
                    &changes,
                );
            }
        }
        Plan {
            beds: Beds(beds),
            ladders: Vec::new(),
        }
    }
}
