//! The bed in LAMMPS, `pair_style gran/hooke`.
//!
//! The same springs, walls, gravity and masses, but one stiffness for all pairs, k_n = E·R̄ (sizes vary by ±5 %, so
//! k_n of Eq. 4 does too), and a drag force in place of Cundall's damping, which LAMMPS does not have. Rotation
//! is not integrated. What its time is good for: a step of a general DEM code over the same pairs.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::BenchError;
use super::bed::Bed;
use super::program::{self, last_row, loop_time, read_dump, write_data};
use crate::files::write_whole;
use grains::tables::Bodies;
use grains::timing::Window;

/// A timed window of another engine.
#[derive(Debug)]
pub struct Foreign {
    /// The timed steps.
    pub window: Window,
    /// The grains afterwards.
    pub bodies: Bodies,
    /// Contacts between grains afterwards.
    pub contacts: usize,
    /// As the program prints it.
    pub version: String,
}

/// Drag over √(m̄ k_n): about the dissipation that Cundall's damping gives a settled bed.
pub const DRAG: f64 = 0.016;

/// Parameters that LAMMPS and LIGGGHTS share.
#[derive(Debug, Clone, Copy)]
pub struct Parameters {
    /// k_n = E·R̄, N/m.
    pub stiffness: f64,
    /// N·s/m.
    pub drag: f64,
    /// Distance beyond touching within which pairs are listed, m.
    pub skin: f64,
}

impl Parameters {
    /// For this bed.
    pub fn of(bed: &Bed) -> Self {
        let radius = 0.5 * bed.scene.particles.mean_diameter;
        let stiffness = bed.scene.material.youngs_modulus * radius;
        Parameters {
            stiffness,
            drag: DRAG * (bed.scene.grain_mass(radius) * stiffness).sqrt(),
            // The fastest of 0.06 to 0.4 of the radius on the settled bed, together with `newton off`; the others
            // are within some per cent.
            skin: 0.2 * radius,
        }
    }
}

/// Columns of the table that both scripts ask for: step, kinetic energy, contacts of all grains.
const COLUMNS: usize = 3;

/// The input script.
pub fn script(bed: &Bed, warm_up: u64, steps: u64) -> String {
    let Parameters {
        stiffness: k,
        drag,
        skin,
    } = Parameters::of(bed);
    let dt = bed.scene.time_step_seconds();
    let (gravity, width) = (bed.scene.gravity, bed.scene.container.width);
    format!(
        "units si
dimension 2
boundary f f p
atom_style sphere
newton off
comm_modify vel yes
read_data bed.data
pair_style gran/hooke {k} NULL 0 NULL 0 0
pair_coeff * *
neighbor {skin} bin
neigh_modify delay 0 every 1 check yes
timestep {dt}
fix move all nve
fix fall all gravity {gravity} vector 0 -1 0
fix sides all wall/gran hooke {k} NULL 0 NULL 0 0 xplane 0 {width}
fix floor all wall/gran hooke {k} NULL 0 NULL 0 0 yplane 0 NULL
fix drag all viscous {drag}
fix plane all enforce2d
compute touching all contact/atom
compute contacts all reduce sum c_touching
thermo_style custom step ke c_contacts
thermo {never}
run {warm_up}
run {steps}
write_dump all custom bed.dump id x y vx vy modify sort id format float %.17g
",
        never = u32::MAX / 4
    )
}

/// What both programs are started with.
pub const ARGUMENTS: [&str; 4] = ["-in", "in.bed", "-log", "none"];

/// Finds the program and writes data and script into `work`.
pub fn prepare(bed: &Bed, warm_up: u64, steps: u64, work: &Path) -> Result<PathBuf, BenchError> {
    let lmp = program::on_path("lmp").ok_or_else(|| program::missing("lmp", "lammps"))?;
    // The density of a sphere of the disc's mass.
    let density = |radius: f64, mass: f64| mass / (4.0 / 3.0 * PI * radius.powi(3));
    let (data, width) = (work.join("bed.data"), bed.scene.container.width);
    write_data(&data, &bed.bodies, width, density)?;
    write_whole(&work.join("in.bed"), script(bed, warm_up, steps).as_bytes())?;
    Ok(lmp)
}

/// Times steps of this bed in `work`, an empty folder.
pub fn time(
    bed: &Bed,
    warm_up: u64,
    steps: u64,
    work: &Path,
    limit: Duration,
) -> Result<Foreign, BenchError> {
    let lmp = prepare(bed, warm_up, steps, work)?;
    let log = program::run(&lmp, &ARGUMENTS, work, limit)?;
    read(&log, &bed.bodies, steps, work)
}

/// Reads what LAMMPS or LIGGGHTS wrote.
pub fn read(log: &str, bodies: &Bodies, steps: u64, work: &Path) -> Result<Foreign, BenchError> {
    let nonsense = |what: &str| BenchError::Nonsense(format!("its log has {what}"));
    let (wall_seconds, counted) = loop_time(log)
        .filter(|(seconds, _)| *seconds > 0.0)
        .ok_or_else(|| nonsense("no loop time"))?;
    if counted != steps {
        return Err(nonsense("another number of steps"));
    }
    let row = last_row(log, COLUMNS).ok_or_else(|| nonsense("no table"))?;
    let contacts = row.last().copied().unwrap_or_default() / 2.0;
    let version = log
        .lines()
        .find(|line| line.starts_with("LAMMPS") || line.starts_with("LIGGGHTS"));
    Ok(Foreign {
        window: Window {
            steps,
            wall_seconds,
            cpu_seconds: processor_share(log).map(|share| share * wall_seconds),
        },
        bodies: read_dump(&work.join("bed.dump"), bodies)?,
        contacts: contacts as usize,
        version: version.unwrap_or_default().to_owned(),
    })
}

/// Of the line "99.7% CPU use with 1 MPI tasks"; LIGGGHTS has none.
fn processor_share(log: &str) -> Option<f64> {
    let line = log.lines().rfind(|line| line.contains("% CPU use"))?;
    let share: f64 = line.split('%').next()?.trim().parse().ok()?;
    Some(share / 100.0)
}
