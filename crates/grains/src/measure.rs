//! Measures of a bed: here its height, how far it is from rest, the history of a run and all measures together; one definition a
//! file below. Blind to the engine: they read the tables alone.

pub mod cells;
pub mod neighbourhood;
pub mod porosity;
pub mod stress;
mod unbalanced_force;

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::reference::energy_of_jkr;
use crate::scene::{Cloud, Scene, Springs, SurfaceHeight};
use crate::tables::{Across, Bodies, BodyIds, Contact, Snapshot, Stage};
use crate::vector::{Vector, in_space, plus, times};

pub use unbalanced_force::unbalanced_force;

/// A measured number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// What it is, dots from the general to the special: `settled.height.mean_surface`.
    pub key: String,
    /// In `unit`.
    pub value: f64,
    /// SI unit, `1` for a ratio.
    pub unit: String,
}

/// A bed at one moment, as a run folder holds it.
#[derive(Debug, Clone, Copy)]
pub struct Bed<'a> {
    /// All grains.
    pub bodies: &'a Bodies,
    /// All contacts at the grains' positions, sorted by ids.
    pub contacts: &'a [Contact],
    /// What they have besides in space, in the same order; empty in the plane.
    pub across: &'a [Across],
}

impl Bed<'_> {
    /// Every contact with its force on body 2 as a vector in space, N.
    pub fn forces(&self) -> impl Iterator<Item = (&Contact, Vector)> {
        let force = |(at, contact): (usize, &Contact)| match self.across.get(at) {
            None => in_space(contact.force()),
            Some(across) => {
                let [x, z] = contact.normal;
                let along = times(contact.normal_force, [x, across.normal, z]);
                plus(along, across.tangential)
            }
        };
        let contacts = self.contacts.iter().enumerate();
        contacts.map(move |(at, contact)| (contact, force((at, contact))))
    }

    /// Ids of walls and punch.
    pub fn ids(&self) -> BodyIds {
        BodyIds::of(self.bodies)
    }
}

/// The angle of repose of a heap against the left wall, °: that of the triangle in the corner, or in space of the prism, that has its
/// centre of mass, atan(z/x).
pub fn angle_of_heap(bodies: &Bodies) -> f64 {
    let moment = |places: &[f64]| -> f64 {
        let all = bodies.mass.iter().zip(places);
        all.map(|(mass, place)| mass * place).sum()
    };
    moment(&bodies.z).atan2(moment(&bodies.x)).to_degrees()
}

/// Every measure of the beds of one run: `settled.` and `loaded.`, or `poured.` if no loading followed. Depths are counted from the
/// settled surface in both.
pub fn all(scene: &Scene, settled: Option<Bed<'_>>, last: Bed<'_>) -> Vec<Quantity> {
    let surface = surface(scene, settled.unwrap_or(last).bodies);
    let Some(settled) = settled else {
        return bed(scene, "poured", last, surface);
    };
    let mut quantities = bed(scene, "settled", settled, surface);
    let loading = scene.in_stage(Stage::Load);
    quantities.extend(bed(&loading, "loaded", last, surface));
    quantities
}

fn bed(scene: &Scene, moment: &str, bed: Bed<'_>, surface: f64) -> Vec<Quantity> {
    let mut quantities = Vec::new();
    let mut add = |key: &str, value: Option<f64>, unit: &str| {
        quantities.extend(value.map(|value| Quantity {
            key: format!("{moment}.{key}"),
            value,
            unit: unit.to_owned(),
        }));
    };
    let bodies = bed.bodies;
    let heights = [
        ("highest_grain", highest_grain(bodies)),
        ("mean_surface", mean_surface(scene, bodies)),
        ("twice_centre_of_mass", twice_centre_of_mass(bodies)),
    ];
    let planar = !bodies.in_space();
    for (name, height) in heights {
        if planar || name != "mean_surface" {
            add(&format!("height.{name}"), Some(height), "m");
        }
    }
    let Cloud::JitteredLattice { over, .. } = scene.cloud;
    if over.is_some_and(|[from, _]| from == 0.0) {
        add("angle", Some(angle_of_heap(bodies)), "°");
    }
    for (name, height) in heights.into_iter().filter(|_| planar) {
        let porosity = porosity::from_height(bodies, scene.container.width, height);
        add(&format!("porosity.from_{name}"), Some(porosity), "1");
    }
    let window = porosity::Window::interior(scene, surface);
    let cells = planar.then(|| cells::of(scene, bodies));
    let layer = porosity::Layer::interior(scene, bodies);
    let coordination = neighbourhood::coordination(bed);
    let mut ratio = |key: &str, value: Option<f64>| add(key, value, "1");
    match &cells {
        Some(cells) => {
            ratio("porosity.in_window", porosity::in_window(bodies, &window));
            ratio(
                "porosity.of_cells",
                porosity::of_cells(bodies, cells, &window),
            );
        }
        None => ratio(
            "porosity.in_layer",
            layer.map(|layer| porosity::in_layer(bodies, &layer)),
        ),
    }
    ratio("coordination.mean", Some(coordination.mean));
    ratio(
        "coordination.mean_without_rattlers",
        coordination.mean_without_rattlers,
    );
    ratio("coordination.rattlers", Some(coordination.rattler_share));
    ratio("unbalanced_force", unbalanced_force(scene.gravity, bed));
    let mut energy = |key: &str, value: f64| add(key, Some(value), "J");
    energy("energy.kinetic", bodies.kinetic_energy());
    energy("energy.elastic", elastic_energy(scene, bed));
    energy("energy.potential", potential_energy(scene, bodies));
    if let Some(layer) = layer {
        let stress = stress::in_layer(bed, &layer);
        for (axis, name) in ["xx", "yy", "zz"].into_iter().enumerate() {
            let value = stress[(axis, axis)];
            add(&format!("stress.in_layer.{name}"), Some(value), "Pa");
        }
    }
    let stresses = cells.map(|cells| stress::at_control_points(scene, bed, &cells, surface));
    for at in stresses.into_iter().flatten() {
        let (grain, local) = (at.grain_stress, at.local_mean);
        for (key, value, unit) in [
            ("grain_zz", Some(grain.zz), "Pa"),
            ("grain_xx", Some(grain.xx), "Pa"),
            ("grain_xz", Some(grain.xz), "Pa"),
            ("control_volume_zz", Some(at.control_volume_zz), "J"),
            ("local_zz", local.map(|stress| stress.zz), "Pa"),
            ("local_xx", local.map(|stress| stress.xx), "Pa"),
            ("local_xz", local.map(|stress| stress.xz), "Pa"),
        ] {
            add(&format!("stress.{}.{key}", at.name), value, unit);
        }
    }
    quantities
}

/// The height that the scene counts depths from, m.
pub fn surface(scene: &Scene, bodies: &Bodies) -> f64 {
    match scene.measurement.surface_height {
        SurfaceHeight::HighestGrain => highest_grain(bodies),
        SurfaceHeight::MeanSurface => mean_surface(scene, bodies),
        SurfaceHeight::TwiceCentreOfMass => twice_centre_of_mass(bodies),
    }
}

/// H = max(z + R), m.
pub fn highest_grain(bodies: &Bodies) -> f64 {
    let tops = bodies.z.iter().zip(&bodies.radius).map(|(z, r)| z + r);
    tops.fold(0.0, f64::max)
}

/// H = mean over ⌊L/D⌋ equal columns of the highest point of any grain in the column, m; 0 where a column
/// is empty. A grain reaches z + √(R² − s²) where s is how far the column passes its centre by.
pub fn mean_surface(scene: &Scene, bodies: &Bodies) -> f64 {
    let width = scene.container.width;
    let columns = ((width / scene.particles.mean_diameter) as usize).max(1);
    let pitch = width / columns as f64;
    let mut tops = vec![0.0f64; columns];
    for ((x, z), radius) in bodies.x.iter().zip(&bodies.z).zip(&bodies.radius) {
        let first = ((x - radius) / pitch).max(0.0) as usize;
        let last = (((x + radius) / pitch) as usize).min(columns - 1);
        for (column, top) in tops.iter_mut().enumerate().take(last + 1).skip(first) {
            let low = column as f64 * pitch;
            let past = (low - x).max(x - (low + pitch)).max(0.0);
            if past <= *radius {
                *top = top.max(z + (radius * radius - past * past).sqrt());
            }
        }
    }
    tops.iter().sum::<f64>() / columns as f64
}

/// H = 2 Σmz/Σm, m: the height of a column of even density with this centre of mass.
pub fn twice_centre_of_mass(bodies: &Bodies) -> f64 {
    let moment: f64 = bodies.z.iter().zip(&bodies.mass).map(|(z, m)| z * m).sum();
    let mass: f64 = bodies.mass.iter().sum();
    2.0 * moment / mass
}

/// One moment of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistoryRow {
    /// The stage that is under way.
    pub stage: Stage,
    /// Steps since the start of the stage.
    pub step: u64,
    /// s since the start of the stage.
    pub time: f64,
    /// J.
    pub kinetic_energy: f64,
    /// J, above the floor.
    pub potential_energy: f64,
    /// J.
    pub elastic_energy: f64,
    /// Empty without contacts.
    pub unbalanced_force: Option<f64>,
    /// How many pairs touch, walls and punch included.
    pub contacts: u64,
    /// m, empty without a punch.
    pub punch_depth: Option<f64>,
    /// N, positive upwards, empty without a punch.
    pub punch_force: Option<f64>,
    /// Digest of the bits of every position and velocity.
    pub state: String,
}

impl HistoryRow {
    /// The columns of `history.csv`.
    pub const HEADER: &[&str] = &[
        "stage",
        "step",
        "time",
        "kinetic_energy",
        "potential_energy",
        "elastic_energy",
        "unbalanced_force",
        "contacts",
        "punch_depth",
        "punch_force",
        "state",
    ];

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let always = [
            self.time,
            self.kinetic_energy,
            self.potential_energy,
            self.elastic_energy,
        ];
        let sometimes = [self.unbalanced_force, self.punch_depth, self.punch_force];
        let mut all = always.into_iter().chain(sometimes.into_iter().flatten());
        all.all(f64::is_finite)
    }
}

/// The row of a moment.
pub fn history_row(scene: &Scene, snapshot: &Snapshot) -> HistoryRow {
    let bed = Bed {
        bodies: &snapshot.bodies,
        contacts: &snapshot.contacts,
        across: &snapshot.across,
    };
    let scene = &scene.in_stage(snapshot.constants());
    HistoryRow {
        stage: snapshot.stage,
        step: snapshot.step,
        time: snapshot.time,
        kinetic_energy: bed.bodies.kinetic_energy(),
        potential_energy: potential_energy(scene, bed.bodies),
        elastic_energy: elastic_energy(scene, bed),
        unbalanced_force: unbalanced_force(scene.gravity, bed),
        contacts: bed.contacts.len() as u64,
        punch_depth: snapshot.punch.map(|punch| punch.depth()),
        punch_force: snapshot.punch.map(|punch| punch.force),
        state: snapshot.bodies.digest(),
    }
}

/// Σ mgz above the floor.
pub fn potential_energy(scene: &Scene, bodies: &Bodies) -> f64 {
    let moment: f64 = bodies.mass.iter().zip(&bodies.z).map(|(m, z)| m * z).sum();
    scene.gravity * moment
}

/// Energy stored in the springs of the contacts: Σ ½F_n u_n of the normal ones, with dashpots Σ ½k_n u_n²,
/// since F_n is then not the spring's alone; and with friction Σ ½F_s²/k_s of the tangential ones. Of Hertz's springs
/// Σ 2/5 k u^2.5 with F_n = k u^1.5; of Johnson, Kendall and Roberts what pulls is in it.
pub fn elastic_energy(scene: &Scene, bed: Bed<'_>) -> f64 {
    let law = Model::of(scene).law;
    let (dashpots, friction) = (law.has_dashpots(), law.has_friction());
    let radius = |id: u32| bed.bodies.radius.get(id as usize).copied();
    let stored = |contact: &Contact| {
        let grain = bed.bodies.radius[contact.id2 as usize];
        // A flat body counts as a grain of the same radius.
        let other = radius(contact.id1).unwrap_or(grain);
        let (u, shear) = (contact.overlap, contact.tangential_force);
        let stiffness = law.normal_stiffness(other, grain);
        let (normal, along) = match law.contact.springs {
            Springs::HertzMindlin => {
                let radius = other * grain / (other + grain);
                let [k, k_s] = law.solid(0).hertz_mindlin(law.solid(0), radius);
                match law.contact.adhesion.filter(|_| law.holds()) {
                    Some(energy) => {
                        let (root, energy) = energy_of_jkr(k, 3.0 * PI * radius * energy, u);
                        (energy, k_s * root)
                    }
                    None => (0.4 * k * u * u * u.sqrt(), k_s * u.sqrt()),
                }
            }
            Springs::Linear if dashpots => {
                (0.5 * stiffness * u * u, law.stiffness_ratio * stiffness)
            }
            Springs::Linear => (
                0.5 * contact.normal_force * u,
                law.stiffness_ratio * stiffness,
            ),
        };
        // A contact that only just touches holds nothing.
        let tangential = 0.5 * shear * shear / along;
        normal
            + if friction && along > 0.0 {
                tangential
            } else {
                0.0
            }
    };
    let energies = bed.contacts.iter().map(stored);
    energies.fold(0.0, |sum, energy| sum + energy)
}

/// How much of what presses down arrives at the floor: 1 for a bed at rest, whatever its stresses. Less means that the bed is
/// still moving: falling grains bear nothing, and local damping bears up to the share α of the weight of grains that sink.
///
/// Vertical force on the floor over the weight of all grains and what presses on the bed from above, `pressed` in N.
/// Friction at the walls, where there is any, is not counted.
pub fn borne_by_floor(scene: &Scene, bed: Bed<'_>, pressed: f64) -> f64 {
    let floor = bed.ids().floor();
    let on_floor = bed.forces().filter(|(contact, _)| contact.id1 == floor);
    let borne: f64 = on_floor.map(|(_, force)| force[2]).sum();
    let mass: f64 = bed.bodies.mass.iter().sum();
    borne / (mass * scene.gravity + pressed)
}
