//! The content of the paper's figures from our own numbers.

use crate::document::plot::Point as DataPoint;
use crate::document::{Axis, Cell, Colour, Mark, Plot, Table};
use crate::files::work_folder;
use crate::paper::continuum::table::{Point, Setup};
use crate::paper::continuum::{Field, Load, Model, Spread, weight};
use crate::paper::recomputed::piles::{Counted, chance_of_at_least_of_five, table_1};
use crate::study::StudyError;
use crate::study::campaign::Merged;
use crate::study::distribution::Distribution;
use crate::study::realization::{Engines, Realization, Runner, Specification, run};
use evidence::distribution::Family;
use grains::measure;
use grains::scene::Scene;
use grains::tables::Snapshot;

/// The continuum's side of a scene. Height and porosity of the bed are the published ones: what the theory was given.
pub fn setup_of(scene: &Scene) -> Setup {
    let published = Setup::published();
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
pub fn loaded_bed(scene: &Scene, runner: Runner) -> Result<LoadedBed, StudyError> {
    let work = work_folder()?;
    let how = Specification {
        runner,
        phases: &[],
        engines: &Engines::default(),
        work: work.path(),
    };
    let Realization { outcome, .. } = run(scene, &how)?;
    let settled = outcome.settled.ok_or_else(|| {
        StudyError::Usage(format!(
            "realization {} did not settle, so there is no loaded bed to draw; take another one",
            scene.realization
        ))
    })?;
    Ok(LoadedBed {
        scene: scene.clone(),
        surface: measure::surface(scene, &settled.bodies),
        last: outcome.last,
    })
}

/// Σ^c_zz of each member that reached the force (section 3.2.3) beside the half-space's μ = σ_zz V_c (Eq. 7), a control point
/// each: Figure 5. An error where a point has no values.
pub fn distributions(campaign: &Merged) -> Result<Vec<Distribution>, StudyError> {
    let scene = &campaign.plan.study.scene;
    let setup = setup_of(scene);
    let field = Field::new(Model::HalfSpace, setup.load);
    let volume = scene.measurement.control_volume_side.powi(2);
    let of = |point: &Point| {
        let key = format!("loaded.stress.{}.control_volume_zz", point.name);
        let members = campaign.rows.iter();
        let mut values: Vec<f64> = members
            .filter_map(|member| member.measured.get(&key).copied())
            .collect();
        if values.is_empty() {
            return Err(StudyError::Usage(format!(
                "no member of the campaign has a stress at {}, so Figure 5 cannot be drawn",
                point.name
            )));
        }
        values.sort_by(f64::total_cmp);
        let of_weight = weight(setup.density, setup.gravity, setup.porosity, point.depth);
        let stress = of_weight + field.stress(point.offset, point.depth).zz;
        Ok(Distribution {
            name: "figure-5".into(),
            point: point.name.clone(),
            quantity: "Σ_zz".into(),
            unit: "J".into(),
            theory: Some(stress * volume),
            fitted: Family::Gamma.fit(&values),
            values,
        })
    };
    setup.points.iter().map(of).collect()
}

/// Table 1, counted, and the share of piles that bear at least a force, for five piles and for many: Figure 3.
pub fn sharings() -> (Table, Plot) {
    let subclasses = table_1();
    let all: u32 = subclasses.iter().map(|subclass| subclass.cases).sum();
    let heads = [
        "loads", "name", "bear 0", "bear 1", "bear 2", "bear 3", "bear 4", "bear 5", "cases",
        "chance",
    ];
    let title = "Five piles share five units of force (FU): how many piles bear 0, 1, … 5 of them";
    let mut table = Table::new("table-1", title, &heads);
    for Counted { name, piles, cases } in subclasses {
        // One case of it, the largest loads first.
        let loads: Vec<String> = (0..6)
            .rev()
            .flat_map(|force| vec![force.to_string(); piles[force] as usize])
            .collect();
        let head = [Cell::Text(loads.join(" ")), name.into()];
        let counts = piles.map(|piles| Cell::Count(piles.into()));
        let chance = f64::from(cases) / f64::from(all);
        let last = [Cell::Count(cases.into()), chance.into()];
        table.row(head.into_iter().chain(counts).chain(last));
    }
    let forces = || (0..6u32).map(|force| (force, f64::from(force)));
    let plot = Plot::new(
        "figure-3",
        "What one pile bears when five piles share five units of force, and when many do",
        Axis::linear("force F, FU (the mean is 1)").within(-0.3, 5.3),
        Axis::linear("share of piles with F or more").within(0.0, 1.0),
    )
    .with(Mark::Bars {
        name: "five piles, counted".to_owned(),
        colour: Colour::Sky,
        bars: forces()
            .map(|(force, at)| [at - 0.15, at + 0.15, chance_of_at_least_of_five(force)])
            .collect(),
    })
    .points(
        "many, whole units",
        Colour::Green,
        forces().map(|(force, at)| DataPoint::at(at, 0.5f64.powi(force as i32))),
    )
    .line(
        "many, fine steps: exp",
        Colour::Vermilion,
        (0..=100).map(|index| {
            let force = 0.05 * f64::from(index);
            [force, (-force).exp()]
        }),
    );
    (table, plot)
}
