//! What is wrong, in words that say where to look.

use super::Story;
use super::jobs::{self, Job};
use grains::tables::{Contact, Snapshot};

/// Nearer than this, over what the step changes, two numbers are one.
const SAME: f64 = 1.0e-9;

/// Relative to the larger one.
fn near(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= SAME * scale
}

/// The contacts of one moment.
pub fn contacts_agree(theirs: &Snapshot, native: &Snapshot) -> Result<(), String> {
    let pairs = |of: &Snapshot| -> Vec<(u32, u32)> {
        of.contacts.iter().map(|of| (of.id1, of.id2)).collect()
    };
    let (found, wanted) = (pairs(theirs), pairs(native));
    if let Some((one, two)) = wanted.iter().find(|pair| !found.contains(pair)) {
        return Err(format!(
            "bodies {one} and {two} touch, and no contact of them is written: grains have the ids from 0, then come the walls \
             in the order of job.json, then the punch; a wall stands first"
        ));
    }
    if let Some((one, two)) = found.iter().find(|pair| !wanted.contains(pair)) {
        return Err(format!(
            "bodies {one} and {two} do not touch, and a contact of them is written"
        ));
    }
    for (their, own) in theirs.contacts.iter().zip(&native.contacts) {
        contact_agrees(their, own)?;
    }
    Ok(())
}

fn contact_agrees(their: &Contact, own: &Contact) -> Result<(), String> {
    let of = format!("contact of bodies {} and {}", own.id1, own.id2);
    // Lengths against the size of a grain, about a hundred times an overlap at most.
    let length = 1.0e-2;
    if !near(their.overlap, own.overlap, length) {
        return Err(format!(
            "{of}: overlap {:e} m where {:e} m is right: R1 + R2 − distance, and R − distance at a wall",
            their.overlap, own.overlap
        ));
    }
    let flipped =
        near(their.normal[0], -own.normal[0], 1.0) && near(their.normal[1], -own.normal[1], 1.0);
    if flipped {
        return Err(format!(
            "{of}: the normal points from body 2 to body 1, and is to point from body 1 to body 2"
        ));
    }
    if !(near(their.normal[0], own.normal[0], 1.0) && near(their.normal[1], own.normal[1], 1.0)) {
        return Err(format!(
            "{of}: normal {:?} where {:?} is right",
            their.normal, own.normal
        ));
    }
    // An overlap's own rounding, times the stiffness.
    let slack = own.normal_force * length / own.overlap.max(f64::MIN_POSITIVE);
    if !near(their.normal_force, own.normal_force, slack) {
        return Err(format!(
            "{of}: normal force {:e} N where {:e} N is right, {:.6} of it; k_n = 2·E·R1·R2/(R1 + R2), a wall counts as a grain \
             of the same radius, and compression is positive",
            their.normal_force,
            own.normal_force,
            their.normal_force / own.normal_force
        ));
    }
    if !(near(their.point[0], own.point[0], 1.0) && near(their.point[1], own.point[1], 1.0)) {
        return Err(format!(
            "{of}: contact point {:?} where {:?} is right: from body 1's centre by R1 − overlap/2 along the normal; on the wall",
            their.point, own.point
        ));
    }
    Ok(())
}

/// The first moment and grain that is farther off than `tolerance` of its radius, or has another velocity.
pub fn moments_agree(
    theirs: &[Snapshot],
    native: &[Snapshot],
    tolerance: f64,
) -> Result<(), String> {
    if theirs.len() != native.len() {
        return Err(format!(
            "{} moments instead of {}",
            theirs.len(),
            native.len()
        ));
    }
    for (their, own) in theirs.iter().zip(native) {
        let (of_them, of_us) = (&their.bodies, &own.bodies);
        for id in 0..of_us.len() {
            let apart = (of_them.x[id] - of_us.x[id]).hypot(of_them.z[id] - of_us.z[id]);
            let slower = (of_them.vx[id] - of_us.vx[id]).hypot(of_them.vz[id] - of_us.vz[id]);
            // A velocity of 1 m/s is about what grains have.
            if !(apart <= tolerance * of_us.radius[id] && slower <= 100.0 * tolerance) {
                return Err(format!(
                    "step {}, grain {id}: at ({:e}, {:e}) m with ({:e}, {:e}) m/s, and should be at ({:e}, {:e}) m with ({:e}, \
                     {:e}) m/s: {:.2e} R off, and {tolerance:.0e} R is the most. If the checks before this one hold, forces of \
                     several contacts are added wrongly, or a contact is found too late or lost",
                    own.step,
                    of_them.x[id],
                    of_them.z[id],
                    of_them.vx[id],
                    of_them.vz[id],
                    of_us.x[id],
                    of_us.z[id],
                    of_us.vx[id],
                    of_us.vz[id],
                    apart / of_us.radius[id]
                ));
            }
        }
    }
    Ok(())
}

/// How close a run is that is close enough.
pub fn how_close(theirs: &Story, native: &Story) -> String {
    if theirs.moments == native.moments {
        return "every bit is the native engine's".to_owned();
    }
    let mut largest = 0.0f64;
    for (their, own) in theirs.moments.iter().zip(&native.moments) {
        for id in 0..own.bodies.len() {
            let apart = (their.bodies.x[id] - own.bodies.x[id])
                .hypot(their.bodies.z[id] - own.bodies.z[id]);
            largest = largest.max(apart / own.bodies.radius[id]);
        }
    }
    format!("within {largest:.1e} R of the native engine: rounding")
}

/// Gravity and the order of a step, by what the numbers look like.
pub fn flight(job: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    let (given, dt, g) = (
        &job.task.start.bodies,
        job.scene.time_step_seconds(),
        job.scene.gravity,
    );
    let (their, own) = (&theirs.moments[1].bodies, &native.moments[1].bodies);
    let (z, v) = (given.z[0], given.vz[0]);
    let (fallen, gained) = (their.z[0] - z, their.vz[0] - v);
    let is = |value: f64, expected: f64, scale: f64| (value - expected).abs() <= 1.0e-6 * scale;
    if is(gained, 0.0, g * dt) {
        return Err("after a step the velocity is the one of the start: gravity is missing, or velocities are written before \
                    the step"
            .to_owned());
    }
    if is(gained, g * dt, g * dt) {
        return Err("gravity points up; model.gravity is (x, z) with its sign".to_owned());
    }
    if is(gained, -0.5 * g * dt, g * dt) || is(gained, -1.5 * g * dt, g * dt) {
        return Err("after a step the velocity has half a kick too few or too many: velocities here belong to the half step \
                    before the positions, so each step gives a whole kick, v += dt·a, and then x += dt·v"
            .to_owned());
    }
    if is(fallen, v * dt, g * dt * dt) {
        return Err("the grain was moved with the velocity before the kick: first v += dt·a, then x += dt·v".to_owned());
    }
    if is(fallen, v * dt - 0.5 * g * dt * dt, g * dt * dt) {
        return Err("the grain was moved by v·dt + ½a·dt²: the velocity that is given belongs to the half step before, so it is \
                    moved by (v + dt·a)·dt"
            .to_owned());
    }
    if !is(gained, own.vz[0] - v, g * dt) {
        return Err(format!(
            "after a step vz has changed by {gained:e} m/s, and {:e} m/s is right (dt = {dt:e} s, gravity {g} m/s²)",
            own.vz[0] - v
        ));
    }
    moments_agree(&theirs.moments, &native.moments, jobs::ROUNDING)?;
    Ok("gravity and the order of a step are right".to_owned())
}

/// Cundall's damping.
pub fn damping(job: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    let given = &job.task.start.bodies;
    let (dt, g, alpha) = (
        job.scene.time_step_seconds(),
        job.scene.gravity,
        job.scene.damping.alpha(),
    );
    let (their, own) = (&theirs.moments[1].bodies, &native.moments[1].bodies);
    let names = ["falls", "rises", "turns round in the step"];
    for (id, name) in names.iter().enumerate() {
        let (gained, wanted) = (their.vz[id] - given.vz[id], own.vz[id] - given.vz[id]);
        let is = |expected: f64| (gained - expected).abs() <= 1.0e-6 * g * dt;
        if is(wanted) {
            continue;
        }
        let why = if is(-g * dt) {
            "it is not damped at all"
        } else if id == 2 {
            "the sign is that of a·(v + ½dt·a), with the velocity in the middle of the kick"
        } else if is(-2.0 * g * dt - wanted) {
            "the sign is the wrong way round: what speeds a grain up is made smaller, what slows it down larger"
        } else {
            "each component of the acceleration, gravity included, is multiplied by 1 − α·sign(a·(v + ½dt·a))"
        };
        return Err(format!(
            "the grain that {name}: vz changes by {gained:e} m/s and should by {wanted:e} m/s (α = {alpha}): {why}"
        ));
    }
    moments_agree(&theirs.moments, &native.moments, jobs::ROUNDING)?;
    Ok("what speeds up is damped, what slows down is helped, by the right amount".to_owned())
}

/// The settle rule ended the run where it should.
pub fn rules(_: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    let end = |story: &Story| {
        let stage = story.outcome.stages.last();
        stage.map(|stage| (stage.steps, stage.stop))
    };
    let (found, wanted) = (end(theirs), end(native));
    if found != wanted {
        return Err(format!(
            "settling ended with {found:?} and should with {wanted:?} (steps, reason): every settle.check_every steps, not at \
             step 0, the kinetic energy Σ½mv² of the written velocities is compared with kinetic_energy_fraction times the \
             largest that was seen at such a step, this one included"
        ));
    }
    moments_agree(&theirs.moments, &native.moments, jobs::ROUNDING)?;
    Ok(format!(
        "it ended after {} steps, as it should",
        wanted.map_or(0, |(steps, _)| steps)
    ))
}

/// The punch, its force and the grains below it.
pub fn punch(_: &Job, theirs: &Story, native: &Story) -> Result<String, String> {
    for (their, own) in theirs.moments.iter().zip(&native.moments) {
        let (Some(found), Some(wanted)) = (their.punch, own.punch) else {
            return Err(format!(
                "step {}: no punch is written, and loading has one from its start",
                own.step
            ));
        };
        if !near(found.centre[0], wanted.centre[0], 1.0e-2)
            || !near(found.centre[1], wanted.centre[1], 1.0e-2)
        {
            return Err(format!(
                "step {}: the punch's centre is at {:?} m and should be at {:?} m: it starts on the highest grain below it and \
                 moves by its velocity times dt a step",
                own.step, found.centre, wanted.centre
            ));
        }
        // Rounding of overlaps, times a stiffness.
        if (found.force - wanted.force).abs() > 1.0e-6 * wanted.force.abs().max(1.0) {
            return Err(format!(
                "step {}: the force on the punch is {:e} N and should be {:e} N: what grains push it up with, positive upwards",
                own.step, found.force, wanted.force
            ));
        }
    }
    moments_agree(&theirs.moments, &native.moments, jobs::ROUNDING)?;
    Ok("the punch goes down and bears what it should".to_owned())
}
