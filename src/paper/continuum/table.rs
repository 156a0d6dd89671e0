//! The continuum's stress at the control points, for each ground, each load and a punch that has sunk: how much of a
//! misfit between a simulation's means and the half-space is geometry.

use serde::Serialize;

use crate::document::{Document, Section, Table};
use crate::paper::published::{HEIGHT, OFFSETS, POINTS, POROSITY, PRESSURE};
use crate::paper::recomputed::{DENSITY, DEPTH, GRAVITY, HALF_WIDTH};

use super::{Field, Load, Model, Spread, beneath, within};
use grains::scene::ControlPoint;

/// What the stresses are computed for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setup {
    /// Its spread is that of the half-space everything is compared with.
    pub load: Load,
    pub points: Vec<ControlPoint>,
    /// Of the box, m.
    pub width: f64,
    /// From surface to base, m.
    pub height: f64,
    /// ρ_s, kg/m³.
    pub density: f64,
    /// g, m/s².
    pub gravity: f64,
    /// n.
    pub porosity: f64,
}

impl Setup {
    /// σ_g,zz = ρ_s g (1−n) z, Pa: the same in all models, as smooth walls carry nothing of it.
    pub fn weight(&self, z: f64) -> f64 {
        self.density * self.gravity * (1.0 - self.porosity) * z
    }

    /// The published load, bed and control points. The bed's height is section 4.2's.
    pub fn published() -> Self {
        Setup {
            load: Load {
                spread: Spread::Uniform,
                pressure: *PRESSURE,
                half_width: HALF_WIDTH,
            },
            points: std::iter::zip(POINTS, OFFSETS)
                .map(|(name, offset)| ControlPoint {
                    name: name.to_owned(),
                    offset,
                    depth: DEPTH,
                })
                .collect(),
            width: 1.0,
            height: *HEIGHT,
            density: DENSITY,
            gravity: GRAVITY,
            porosity: *POROSITY,
        }
    }
}

/// What the ground above the base of a sunk punch does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Above {
    /// It bears nothing: the surface is taken at the punch's base.
    Nothing,
    /// It is elastic, fills the hole and hangs on the punch (Melan); half-space and uniform load only.
    Elastic {
        /// ν.
        poisson: f64,
    },
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    pub point: String,
    /// What the load stands on, before it sinks.
    pub model: Model,
    /// Over its width.
    pub spread: Spread,
    /// How far the load has sunk below the surface, m.
    pub sunk: f64,
    /// What the ground above it does; none for a load on the surface.
    pub above: Option<Above>,
    /// σ_p,zz, Pa: of the load alone.
    pub load: f64,
    /// σ_zz = σ_g,zz + σ_p,zz, Pa. The weight is that of the point's depth before loading.
    pub stress: f64,
    /// σ_p,zz over that of the unsunk uniform load on the half-space, minus 1, in per cent.
    pub change_of_load: f64,
    /// The same of σ_zz.
    pub change: f64,
}

/// Depths of sunk punches, m: what punches of the paper's scene reach.
const SUNK: [f64; 4] = [0.01, 0.02, 0.03, 0.04];
/// Of the elastic ground above a sunk punch: the ends of what is usual.
const POISSON: [f64; 2] = [0.2, 0.5];

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Continuum {
    pub setup: Setup,
    pub rows: Vec<Row>,
}

impl Continuum {
    /// Every point for every case. Points that are not below a sunk load are left out.
    pub fn of(setup: Setup) -> Self {
        let (width, depth) = (setup.width, setup.height);
        let half_space = Model::HalfSpace;
        let bounded = Model::Box { width, depth };
        let (even, punch, nothing) = (Spread::Uniform, Spread::RigidPunch, Some(Above::Nothing));
        let mut cases = Vec::new();
        for model in [half_space, Model::Layer { depth }, bounded] {
            cases.extend([even, punch].map(|spread| (model, spread, 0.0, None)));
        }
        for sunk in SUNK {
            cases.push((half_space, even, sunk, nothing));
            cases.push((bounded, punch, sunk, nothing));
            let elastic = POISSON.map(|poisson| Some(Above::Elastic { poisson }));
            cases.extend(elastic.map(|above| (half_space, even, sunk, above)));
        }
        let reference = Field::new(half_space, setup.load);
        let mut rows = Vec::new();
        for (model, spread, sunk, above) in cases {
            let load = Load {
                spread,
                ..setup.load
            };
            let field = Field::new(beneath(model, sunk), load);
            for point in setup.points.iter().filter(|point| point.depth > sunk) {
                let (x, z) = (point.offset, point.depth);
                let of_load = match above {
                    None | Some(Above::Nothing) => field.stress(x, z - sunk).zz,
                    Some(Above::Elastic { poisson }) => within(load, sunk, poisson, x, z),
                };
                let of_weight = setup.weight(z);
                let usual = reference.stress(x, z).zz;
                rows.push(Row {
                    point: point.name.clone(),
                    model,
                    spread,
                    sunk,
                    above,
                    load: of_load,
                    stress: of_weight + of_load,
                    change_of_load: 100.0 * (of_load / usual - 1.0),
                    change: 100.0 * ((of_weight + of_load) / (of_weight + usual) - 1.0),
                });
            }
        }
        Continuum { setup, rows }
    }

    pub fn document(&self) -> Document {
        let setup = &self.setup;
        // The rows of a case stand together.
        let case = |row: &Row| (row.model, row.spread, row.sunk, row.above);
        let cases = self.rows.chunk_by(|a, b| case(a) == case(b));
        let title = "Vertical stress at the control points, weight and load";
        let table =
            Table::of("continuum", title, cases).column("ground and load", |rows| name(&rows[0]));
        let table = setup
            .points
            .iter()
            .fold(table, |table, ControlPoint { name, offset, .. }| {
                let at = |value: fn(&Row) -> f64| {
                    move |rows: &[Row]| rows.iter().find(|row| row.point == *name).map(value)
                };
                table
                    .column(
                        &format!("{name} (x = {offset} m), kPa"),
                        at(|row| 1e-3 * row.stress),
                    )
                    .column(&format!("change at {name}, %"), at(|row| row.change))
            });
        let answer = format!(
            "The stresses of a load of {:.0} N/m on a width of {} m, on a bed {} m high in a box {} m wide with a porosity of {}.",
            setup.load.force(),
            2.0 * setup.load.half_width,
            setup.height,
            setup.width,
            setup.porosity
        );
        let words = "Changes are against the uniform load on the half-space. Sunk: the load has gone down so far. In air: the \
             ground above its base bears nothing. Within: that ground is elastic, fills the hole and hangs on the \
             load (Melan).";
        let stresses = Section::new("Stresses", words).with(table);
        Document::new("The continuum under the punch", answer, Vec::new()).with([stresses])
    }
}

fn name(row: &Row) -> String {
    let ground = match row.model {
        Model::HalfSpace => "half-space",
        Model::Layer { .. } => "layer",
        Model::Box { .. } => "box",
    };
    let load = match row.spread {
        Spread::Uniform => "uniform",
        Spread::RigidPunch => "rigid punch",
    };
    let depth = 1e3 * row.sunk;
    let sunk = match row.above {
        None => String::new(),
        Some(Above::Nothing) => format!(", sunk {depth:.0} mm, in air"),
        Some(Above::Elastic { poisson }) => format!(", sunk {depth:.0} mm, within, ν = {poisson}"),
    };
    format!("{ground}, {load}{sunk}")
}
