//! The bed in LIGGGHTS, `model hooke/stiffness`: the same choices as in LAMMPS.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::BenchError;
use super::bed::Bed;
use super::lammps::{ARGUMENTS, Foreign, Parameters, read};
use super::program::{self, write_data};
use crate::files::write_whole;

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
atom_style granular
atom_modify map array
boundary f f p
newton off
communicate single vel yes
read_data bed.data
neighbor {skin} bin
neigh_modify delay 0
fix k_n all property/global kn peratomtypepair 1 {k}
fix k_t all property/global kt peratomtypepair 1 0
fix gamma_n all property/global gamman peratomtypepair 1 0
fix gamma_t all property/global gammat peratomtypepair 1 0
fix mu all property/global coefficientFriction peratomtypepair 1 0
pair_style gran model hooke/stiffness tangential off
pair_coeff * *
timestep {dt}
fix move all nve
fix fall all gravity {gravity} vector 0 -1 0
fix left all wall/gran model hooke/stiffness tangential off primitive type 1 xplane 0
fix right all wall/gran model hooke/stiffness tangential off primitive type 1 xplane {width}
fix floor all wall/gran model hooke/stiffness tangential off primitive type 1 yplane 0
fix drag all viscous {drag}
fix plane all enforce2d
compute touching all contact/atom
compute contacts all reduce sum c_touching
thermo_style custom step ke c_contacts
thermo {never}
run {warm_up}
run {steps}
write_dump all custom bed.dump id x y vx vy modify format \"%d %.17g %.17g %.17g %.17g\"
",
        never = u32::MAX / 4
    )
}

/// Finds the program and writes data and script into `work`.
pub fn prepare(bed: &Bed, warm_up: u64, steps: u64, work: &Path) -> Result<PathBuf, BenchError> {
    let liggghts =
        program::on_path("liggghts").ok_or_else(|| program::missing("liggghts", "liggghts"))?;
    // In two dimensions its grains are discs.
    let density = |radius: f64, mass: f64| mass / (PI * radius * radius);
    let (data, width) = (work.join("bed.data"), bed.scene.container.width);
    write_data(&data, &bed.bodies, width, density)?;
    write_whole(&work.join("in.bed"), script(bed, warm_up, steps).as_bytes())?;
    Ok(liggghts)
}

/// Times steps of this bed in `work`, an empty folder.
pub fn time(
    bed: &Bed,
    warm_up: u64,
    steps: u64,
    work: &Path,
    limit: Duration,
) -> Result<Foreign, BenchError> {
    let liggghts = prepare(bed, warm_up, steps, work)?;
    let log = program::run(&liggghts, &ARGUMENTS, work, limit)?;
    read(&log, &bed.bodies, steps, work)
}
