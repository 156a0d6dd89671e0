//! Settings on the same packings: which published figures each of them gives; and taken apart, what the bed bears before the load
//! and what the load adds, against the theory's two parts.

pub mod choices;
pub mod document;
pub mod judge;
pub mod published;

use std::path::Path;

use grains::scene::{ContactLaw, ControlPoint, Rotation, Scene};
use serde::{Deserialize, Serialize};

use crate::engine::EngineError;
use crate::study::candidates::judge::Candidates;
use crate::study::machine::Folder;
use crate::study::member::{Beds, MIRRORED, Member, Members};
use crate::study::realization::{
    Change, Engines, LAWS, Runner, Setting, Specification, changed, small_scene, whole_scene,
};
use crate::study::search::matching::keep;
use crate::study::search::{matching::Search, space};
use crate::study::{Judged, Outline, Study, StudyError};

/// Kinetic energy over its peak at which nothing moves any more.
const REST: f64 = 1.0e-6;
/// Friction angle of the loads with friction, rad.
const FRICTION: f64 = 0.3;
/// Speeds of the punch on beds at rest, m/s, each half of the one before; without friction the slowest go on for very long, and
/// none is needed to see what becomes of them.
const SPEEDS: [f64; 4] = [0.08, 0.04, 0.02, 0.01];
const WITHOUT_FRICTION: usize = 3;
const WITHOUT_TURNING: usize = 3;
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
    /// The choices that the paper leaves open, one at a time.
    pub fn of_choices(quick: bool, clouds: u64) -> Self {
        Plan {
            beds: choices::beds(quick, clouds),
            ladders: Vec::new(),
        }
    }

    /// The printed scene, the way to its quasi-static limit, and the best settings of a search.
    pub fn new(quick: bool, clouds: u64, found: Option<&Search>, best: usize) -> Self {
        let printed = match quick {
            true => small_scene(),
            false => whole_scene(),
        };
        let printed = with_lines(space::on_both_sides(printed));
        let base = with_lines(space::base(quick));
        let setting = |id: &str, name: &str, scene: Scene| {
            Setting::new(id, name, "candidates", Specification::native(scene), clouds)
        };
        let with_friction = |mut scene: Scene| {
            scene.loading.material = Some(grains::scene::Material {
                friction_angle: FRICTION,
                ..scene.material.clone()
            });
            scene
        };
        let without_turning = |mut scene: Scene| {
            scene.loading.contact = Some(ContactLaw {
                rotation: Rotation::Blocked,
                ..scene.contact.clone()
            });
            scene
        };
        let frictional = with_friction(base.clone());
        let stiff = without_turning(frictional.clone());
        let poured = changed(base.clone(), &[Change::Friction(FRICTION)]);
        let name = format!("friction {FRICTION} rad in loading");
        let without = format!("{name}, grains do not turn");
        let mut beds = vec![
            vec![setting("printed", choices::PRINTED, printed)],
            vec![
                setting("friction", &name, frictional),
                setting("blocked", &without, stiff),
            ],
            vec![setting(
                "poured",
                &format!("friction {FRICTION} rad in both stages"),
                poured,
            )],
        ];
        let rest = changed(base, &[Change::Settled(REST)]);
        let (mut at_rest, mut ladders) = (Vec::new(), Vec::new());
        let rough = with_friction(rest.clone());
        for (kind, words, scene, speeds) in [
            ("rest", "without friction", rest, WITHOUT_FRICTION),
            (
                "rest-friction",
                "with friction in loading",
                rough.clone(),
                SPEEDS.len(),
            ),
            (
                "rest-blocked",
                "with friction, grains do not turn",
                without_turning(rough),
                WITHOUT_TURNING,
            ),
        ] {
            let settings = SPEEDS.iter().take(speeds).map(|speed| {
                let scene = changed(scene.clone(), &[Change::Speed(*speed)]);
                let name = format!("bed at rest, {words}, {speed} m/s");
                setting(&format!("{kind}-{speed}"), &name, scene)
            });
            let settings: Vec<Setting> = settings.collect();
            ladders.push(Ladder {
                name: words.to_owned(),
                settings: settings.iter().map(|of| of.id.clone()).collect(),
            });
            at_rest.extend(settings);
        }
        beds.push(at_rest);
        for (index, of) in found.iter().flat_map(|of| &of.best).take(best).enumerate() {
            let rank = index + 1;
            let mut of_search = setting(
                &format!("best-{rank}"),
                &format!("number {rank} of the search"),
                with_lines(space::scene(&space::base(quick), &of.at)),
            );
            of_search.at = of.at.clone();
            beds.push(vec![of_search]);
        }
        Plan {
            beds: Beds(beds),
            ladders,
        }
    }
}

/// With points along the depth of the control points, on both sides, and under the punch.
fn with_lines(mut scene: Scene) -> Scene {
    let depth = scene.control_points.first().map_or(0.0, |of| of.depth);
    let farthest = scene.control_points.iter().map(|of| of.offset);
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

impl Study for Plan {
    const KIND: &'static str = "candidates";
    type Row = Vec<Member>;

    fn count(&self) -> u64 {
        self.beds.count()
    }

    fn check(&self) -> Result<(), String> {
        let known = |id: &String| self.beds.settings().any(|of| of.id == *id);
        let mut ladders = self.ladders.iter().flat_map(|of| &of.settings);
        match ladders.find(|id| !known(id)) {
            Some(id) => Err(format!("there is no setting {id}")),
            None => self.beds.check(),
        }
    }

    fn runner(&self, _: u64) -> Runner {
        Runner::Native
    }

    fn identity(&self, task: u64) -> String {
        self.beds.identity(task)
    }

    fn run(&self, task: u64, _: &Engines, _: &Path) -> Result<Vec<Member>, EngineError> {
        self.beds
            .run(task, |key| keep(key) || key.starts_with(LAWS))
    }

    fn belongs(&self, task: u64, row: &Vec<Member>) -> bool {
        self.beds.belongs(task, row)
    }

    fn outline(&self, row: &Vec<Member>) -> Outline {
        Beds::outline(row)
    }

    fn judge(folder: &Folder<Self>) -> Result<Judged, StudyError> {
        let mut members = Vec::new();
        folder.each(|_, row| members.extend(row))?;
        let members: Members = members.into_iter().collect();
        let record = Candidates::of(&folder.plan.study, &members);
        Judged::of(Self::KIND, &record, record.document())
    }
}
