//! The data of the paper's figures from our own numbers; `report::figures` draws them.

use crate::engine::yade;
use crate::error::Error;
use crate::files::work_folder;
use crate::paper;
use crate::paper::continuum::table::{Point, Setup};
use crate::paper::continuum::{Field, Load, Model, Spread, weight};
use crate::study::campaign::merged::Merged;
use crate::study::realization::{Realization, Runner, Way, run};
use evidence::law::{Family, Law};
use grains::measure::height;
use grains::scene::Scene;
use grains::tables::Snapshot;

/// The continuum's side of a scene. Height and porosity of the bed are the published ones: what the theory was given.
pub fn setup_of(scene: &Scene) -> Setup {
    let published = paper::boussinesq::setup();
    Setup {
        load: Load {
            spread: Spread::Uniform,
            pressure: scene.loading.pressure,
            half_width: scene.loading.half_width,
        },
        points: scene
            .control_points
            .iter()
            .map(|point| Point {
                name: point.name.clone(),
                offset: point.offset,
                depth: point.depth,
            })
            .collect(),
        width: scene.container.width,
        density: scene.material.density,
        gravity: scene.gravity,
        ..published
    }
}

/// A bed under the punch.
#[derive(Debug)]
pub struct LoadedBed {
    /// What was run.
    pub scene: Scene,
    /// Height that depths are counted from, m: of the settled bed.
    pub surface: f64,
    /// The last moment, punch included.
    pub last: Snapshot,
}

impl LoadedBed {
    /// Where a control point is, m.
    pub fn places(&self) -> impl Iterator<Item = (&str, [f64; 2])> {
        self.scene.control_points.iter().map(|point| {
            let x = self.scene.punch_axis() + point.offset;
            (point.name.as_str(), [x, self.surface - point.depth])
        })
    }
}

/// Runs the scene in the native engine to the end of loading.
pub fn loaded_bed(scene: &Scene, runner: Runner) -> Result<LoadedBed, Error> {
    let work = work_folder()?;
    let options = yade::Options::default();
    let way = Way {
        runner,
        phases: &[],
        yade: &options,
        brought: None,
        work: work.path(),
    };
    let Realization { outcome, .. } = run(scene, &way)?;
    let settled = outcome.settled.ok_or_else(|| {
        Error::Usage(format!(
            "realization {} did not settle, so there is no loaded bed to draw; take another one",
            scene.realization
        ))
    })?;
    Ok(LoadedBed {
        scene: scene.clone(),
        surface: height::surface(scene, &settled.bodies),
        last: outcome.last,
    })
}

/// What the members of a campaign have at a control point.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Name of the control point.
    pub point: String,
    /// Σ^c_zz of each member that reached the force, J per metre of depth (section 3.2.3).
    pub values: Vec<f64>,
    /// μ = σ_zz V_c of the half-space (Eq. 7), J.
    pub theory_mean: f64,
    /// The Gamma law that fits best; none where none does.
    pub gamma: Option<Law>,
}

/// A sample a control point; an error where one has no values.
pub fn samples(campaign: &Merged) -> Result<Vec<Sample>, Error> {
    let scene = &campaign.plan.scene;
    let setup = setup_of(scene);
    let field = Field::new(Model::HalfSpace, setup.load);
    let volume = scene.measurement.control_volume_side.powi(2);
    setup
        .points
        .iter()
        .map(|point| {
            let key = format!("last.stress.{}.control_volume_zz", point.name);
            let members = campaign.members.iter();
            let values: Vec<f64> = members
                .filter_map(|member| member.measured.get(&key).copied())
                .collect();
            if values.is_empty() {
                return Err(Error::Usage(format!(
                    "no member of the campaign has a stress at {}, so Figure 5 cannot be drawn",
                    point.name
                )));
            }
            let of_weight = weight(setup.density, setup.gravity, setup.porosity, point.depth);
            let stress = of_weight + field.stress(point.offset, point.depth).zz;
            Ok(Sample {
                point: point.name.clone(),
                gamma: Family::Gamma.fit(&values),
                values,
                theory_mean: stress * volume,
            })
        })
        .collect()
}
