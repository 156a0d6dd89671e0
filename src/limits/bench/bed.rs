//! The beds that are timed: settled ones, and wide ones laid out of copies of a settled one.

use std::path::Path;

use serde_json::json;

use super::timing::after;
use super::{Result, nonsense};
use crate::files::{read_text, write_whole};
use crate::study::realization::unobserved;
use crate::tables::{read_bodies, write_bodies};
use grains::generate::initial_bodies;
use grains::native::{self, NativeError};
use grains::scene::{Cloud, Scene, paper_scene, parse_scene};
use grains::tables::Bodies;
use grains::task::{Observer, Task};

pub const PAPER: u32 = 5000;

/// Steps that a bed laid out of copies is given to come to rest at its joints.
const RELAXING: u64 = 1000;

#[derive(Debug, Clone)]
pub struct Bed {
    /// The paper's scene for so many grains, as deep and as dense as the paper's.
    pub scene: Scene,
    pub bodies: Bodies,
}

/// The paper's scene with the box as wide as `grains` need for the paper's depth.
pub fn scene_of(grains: u32) -> Scene {
    let mut scene = paper_scene(1, grains);
    let width = f64::from(grains) / f64::from(PAPER);
    scene.container.width *= width;
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = (f64::from(*columns) * width).round() as u32;
    scene
}

/// Steps after which spheres lie, with only some that still roll.
const POURING: u64 = 25_000;

/// So many spheres as deep as wide, with Hertz's and Mindlin's springs, friction and Cundall's damping.
pub fn scene_of_spheres(grains: u32) -> Result<Scene> {
    let columns = f64::from(grains).cbrt().mul_add(0.8, 0.5).floor().max(1.0);
    let width = 0.0131 * columns;
    let scene = json!({
        "name": "spheres",
        "particles": {"count": grains, "mean_diameter": 0.01, "dispersion": 0.2},
        "material": {"youngs_modulus": 2.0e7, "poissons_ratio": 0.3, "density": 2600.0, "friction_angle": FRICTION},
        "contact": {"springs": "hertz_mindlin"},
        "damping": {"kind": "cundall", "alpha": 0.3},
        "box": {"width": width, "depth": width},
        "time_step": {"kind": "absolute", "seconds": 2.0e-5},
    });
    parse_scene(&scene.to_string()).map_err(nonsense)
}

/// Pours and settles so many grains in the native engine.
pub fn settled(grains: u32, observer: &mut dyn Observer) -> Result<Bed, NativeError> {
    let scene = unobserved(&scene_of(grains));
    let task = Task::settle(initial_bodies(&scene));
    let outcome = native::run(&scene, &task, &native::Options::default(), observer)?;
    Ok(Bed {
        scene: scene_of(grains),
        bodies: outcome.last.bodies,
    })
}

/// The most of its note, bytes.
const LONGEST_NOTE: u64 = 1 << 16;

/// The settled bed kept in this folder, or a new one that is then kept there.
pub fn settled_or_kept(folder: &Path, grains: u32, observer: &mut dyn Observer) -> Result<Bed> {
    let (name, scene) = (format!("bed-{grains}"), scene_of(grains));
    kept(folder, &name, scene, || settled(grains, observer))
}

/// The same of spheres.
pub fn poured_or_kept(folder: &Path, grains: u32) -> Result<Bed> {
    let (name, scene) = (format!("spheres-{grains}"), scene_of_spheres(grains)?);
    kept(folder, &name, scene.clone(), || {
        let bodies = initial_bodies(&scene);
        let bodies = after(
            &Bed {
                scene: scene.clone(),
                bodies,
            },
            POURING,
        )?
        .bodies;
        Ok(Bed { scene, bodies })
    })
}

fn kept(
    folder: &Path,
    name: &str,
    scene: Scene,
    make: impl FnOnce() -> Result<Bed, NativeError>,
) -> Result<Bed> {
    let grains = scene.particles.count;
    let [table, note] = ["csv", "json"].map(|end| format!("{name}.{end}"));
    let (table, note) = ((folder, &table), (folder, &note));
    let said_of = |bodies: &Bodies| {
        let (scene, state) = (scene.digest(), bodies.digest());
        let version = env!("CARGO_PKG_VERSION");
        json!({"scene_digest": scene, "state": state, "crossgrain": version}).to_string()
    };
    if let Ok(said) = read_text(note, LONGEST_NOTE)
        && let Ok(bodies) = read_bodies(table, grains)
        && said_of(&bodies) == said
    {
        return Ok(Bed { scene, bodies });
    }
    let bed = make()?;
    write_bodies(table, &bed.bodies)?;
    write_whole(note, said_of(&bed.bodies).as_bytes())?;
    Ok(bed)
}

/// `copies` of a `small` settled bed side by side, every second one mirrored, so that grains that touched a wall
/// now touch their mirror images; then some steps of rest. Grains are numbered as a cloud of
/// that width would be: row by row of the lattice that was poured, from the floor up.
pub fn laid_out(small: &Bed, copies: u32) -> Result<Bed, NativeError> {
    let Cloud::JitteredLattice { columns, .. } = small.scene.cloud;
    let mut bed = Bed {
        scene: scene_of(small.grains() * copies),
        bodies: side_by_side(&small.bodies, small.scene.container.width, columns, copies),
    };
    bed.bodies = after(&bed, RELAXING)?.bodies;
    Ok(bed)
}

/// Angle of friction of the bed with friction, rad.
pub const FRICTION: f64 = 0.5;

impl Bed {
    /// The same grains where they lie, from now on with friction and free to turn.
    pub fn with_friction(&self) -> Bed {
        let mut scene = self.scene.clone();
        scene.material.friction_angle = FRICTION;
        let mut bodies = self.bodies.clone();
        let grains = bodies.radius.iter().zip(&bodies.mass);
        bodies.inertia = grains.map(|(r, m)| scene.grain_inertia(*r, *m)).collect();
        bodies.spin = vec![0.0; bodies.len()];
        Bed { scene, bodies }
    }

    pub fn grains(&self) -> u32 {
        self.bodies.len() as u32
    }

    pub fn task(&self, steps: u64) -> Task {
        Task::pour(self.bodies.clone(), steps)
    }
}

/// The grains of [`laid_out`] before they come to rest.
pub fn side_by_side(bodies: &Bodies, width: f64, columns: u32, copies: u32) -> Bodies {
    let columns = columns as usize;
    let copies = 0..copies as usize;
    let all = copies.flat_map(|copy| (0..bodies.len()).map(move |id| (copy, id)));
    let mut places: Vec<(usize, usize)> = all.collect();
    places.sort_by_key(|&(copy, id)| {
        let column = id % columns;
        let across = [column, columns - 1 - column][copy % 2];
        (id / columns, copy, across)
    });
    numbered(bodies, width, places)
}

/// Grains in this order, each with the copy of the bed that it stands in.
fn numbered(
    source: &Bodies,
    width: f64,
    order: impl IntoIterator<Item = (usize, usize)>,
) -> Bodies {
    let mut bodies = Bodies::default();
    for (copy, id) in order {
        let (x, vx) = match copy % 2 {
            0 => (source.x[id], source.vx[id]),
            _ => (width - source.x[id], -source.vx[id]),
        };
        let (place, velocity) = ([copy as f64 * width + x, source.z[id]], [vx, source.vz[id]]);
        bodies.push(place, velocity, source.radius[id], source.mass[id]);
    }
    bodies
}

/// The same grains numbered without any order: the worst that memory can be asked for.
pub fn shuffled(bodies: &Bodies) -> Bodies {
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    // Fisher and Yates with a plain congruential generator (Knuth's MMIX): any disorder serves.
    let mut state = 1u64;
    for last in (1..order.len()).rev() {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        order.swap(last, (state >> 33) as usize % (last + 1));
    }
    numbered(bodies, 0.0, order.into_iter().map(|id| (0, id)))
}
