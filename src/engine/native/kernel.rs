//! The frictionless kernel: the normal springs of [`super::contact`] arranged for vector lanes, with
//! the same bits; and the integrator of all kernels.
//!
//! Forces of all listed pairs are computed several at a time; they are then added one pair after
//! the other in the order of the list. Lanes change nothing: no operation is fused or reordered.

use multiversion::multiversion;

use super::neighbours::Neighbours;
use super::state::State;

/// Pairs handled together: a multiple of every vector width, small enough to stay in the nearest cache.
const BLOCK: usize = 256;

/// [`pair_forces_plain`], compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn pair_forces(position: &[[f64; 2]], list: &Neighbours, out: &mut [[f64; 2]]) {
    pair_forces_plain(position, list, out);
}

/// The normal force of every listed pair on its second grain; zero where the pair does not touch.
#[inline(always)]
fn pair_forces_plain(position: &[[f64; 2]], list: &Neighbours, out: &mut [[f64; 2]]) {
    let mut x = [1.0; BLOCK];
    let mut z = [1.0; BLOCK];
    let mut reach = [0.0; BLOCK];
    let mut stiffness = [0.0; BLOCK];
    let blocks = list
        .grain
        .chunks(BLOCK)
        .zip(list.other.chunks(BLOCK))
        .zip(list.reach.chunks(BLOCK).zip(list.stiffness.chunks(BLOCK)))
        .zip(out.chunks_mut(BLOCK));
    for (((grain, other), (of_reach, of_stiffness)), out) in blocks {
        // Gathering and arithmetic are loops of their own: mixed, they do not become vector code.
        for (((dx, dz), grain), other) in x.iter_mut().zip(&mut z).zip(grain).zip(other) {
            let (a, b) = (position[*grain as usize], position[*other as usize]);
            *dx = b[0] - a[0];
            *dz = b[1] - a[1];
        }
        reach[..of_reach.len()].copy_from_slice(of_reach);
        stiffness[..of_stiffness.len()].copy_from_slice(of_stiffness);
        for lane in 0..BLOCK {
            let (dx, dz) = (x[lane], z[lane]);
            let distance = (dx * dx + dz * dz).sqrt();
            let overlap = reach[lane] - distance;
            let force = stiffness[lane] * overlap;
            let touching = overlap >= 0.0;
            x[lane] = if touching {
                force * (dx / distance)
            } else {
                0.0
            };
            z[lane] = if touching {
                force * (dz / distance)
            } else {
                0.0
            };
        }
        for ((out, x), z) in out.iter_mut().zip(&x).zip(&z) {
            *out = [*x, *z];
        }
    }
}

/// Adds the pair forces to both grains of each pair, pair after pair in the order of the list.
/// The sum of the row's grain stays in a register meanwhile; the order of its terms is the same.
pub fn sum_pair_forces(list: &Neighbours, pair_force: &[[f64; 2]], force: &mut [[f64; 2]]) {
    for (i, row) in list.start.windows(2).enumerate() {
        let row = row[0] as usize..row[1] as usize;
        let mut own = force[i];
        for (other, pair) in list.other[row.clone()].iter().zip(&pair_force[row]) {
            own[0] -= pair[0];
            own[1] -= pair[1];
            let partner = &mut force[*other as usize];
            partner[0] += pair[0];
            partner[1] += pair[1];
        }
        force[i] = own;
    }
}

/// Advances velocities and positions; without local damping nothing is computed for it. Says whether
/// every grain is still within the displacement that the neighbour list allows; a NaN is not.
pub fn integrate(
    state: &mut State,
    reference: &[[f64; 2]],
    dt: f64,
    pull: [f64; 2],
    alpha: f64,
    limit_squared: f64,
) -> bool {
    if alpha == 0.0 {
        integrate_undamped(state, reference, dt, pull, limit_squared)
    } else {
        integrate_damped(state, reference, dt, pull, alpha, limit_squared)
    }
}

/// [`integrate_plain`] with local damping, compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn integrate_damped(
    state: &mut State,
    reference: &[[f64; 2]],
    dt: f64,
    pull: [f64; 2],
    alpha: f64,
    limit_squared: f64,
) -> bool {
    integrate_plain::<true>(state, reference, dt, pull, alpha, limit_squared)
}

/// [`integrate_plain`] without it, likewise.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn integrate_undamped(
    state: &mut State,
    reference: &[[f64; 2]],
    dt: f64,
    pull: [f64; 2],
    limit_squared: f64,
) -> bool {
    integrate_plain::<false>(state, reference, dt, pull, 0.0, limit_squared)
}

/// Leapfrog: v += dt·a, x += dt·v. With Cundall's damping the acceleration, gravity included, is scaled by
/// 1 − α·sign(a·(v + ½dt·a)).
#[inline(always)]
fn integrate_plain<const DAMPED: bool>(
    state: &mut State,
    reference: &[[f64; 2]],
    dt: f64,
    pull: [f64; 2],
    alpha: f64,
    limit_squared: f64,
) -> bool {
    let half_step = 0.5 * dt;
    let mut within = true;
    let moving = state.position.iter_mut().zip(&mut state.velocity);
    let pushed = state.force.iter().zip(&state.mass);
    for (((position, velocity), (force, mass)), reference) in moving.zip(pushed).zip(reference) {
        let mut moved = [0.0; 2];
        for axis in 0..2 {
            let mut acceleration = force[axis] / mass + pull[axis];
            if DAMPED {
                let power = acceleration * (velocity[axis] + half_step * acceleration);
                let sign = f64::from(u8::from(power > 0.0)) - f64::from(u8::from(power < 0.0));
                acceleration *= 1.0 - alpha * sign;
            }
            velocity[axis] += dt * acceleration;
            position[axis] += dt * velocity[axis];
            moved[axis] = position[axis] - reference[axis];
        }
        within &= moved[0] * moved[0] + moved[1] * moved[1] <= limit_squared;
    }
    within
}

/// The spins, damped and advanced like a velocity component.
pub fn integrate_spins(state: &mut State, dt: f64, alpha: f64) {
    let half_step = 0.5 * dt;
    for ((spin, torque), inertia) in state.spin.iter_mut().zip(&state.torque).zip(&state.inertia) {
        let undamped = torque / inertia;
        let power = undamped * (*spin + half_step * undamped);
        let sign = f64::from(u8::from(power > 0.0)) - f64::from(u8::from(power < 0.0));
        *spin += dt * (undamped * (1.0 - alpha * sign));
    }
}

#[cfg(test)]
mod tests {
    use super::super::constants::Constants;
    use super::super::dynamics::Dynamics;
    use super::*;
    use crate::generate::initial_bodies;
    use crate::model::Model;
    use crate::scene::paper_scene;

    /// The functions compiled for this machine's vector unit against the same code compiled for the
    /// plainest machine of its kind.
    #[test]
    fn this_machines_vector_unit_gives_the_plain_bits() {
        let scene = paper_scene(1, 3000);
        let constants = Constants::new(&Model::of(&scene), scene.particles.count);
        let bodies = initial_bodies(&scene);
        let mut dynamics = Dynamics::new(&bodies, None, constants, 1.0e-3).expect("a sound start");
        let mut touching = 0;
        for _ in 0..9000 {
            dynamics.step().expect("a sound step");
            let count = dynamics.neighbours.other.len();
            if !dynamics.neighbours.builds.is_multiple_of(50) {
                continue;
            }
            let mut plain = vec![[0.0; 2]; count];
            pair_forces_plain(&dynamics.state.position, &dynamics.neighbours, &mut plain);
            touching += plain.iter().filter(|force| **force != [0.0; 2]).count();
            assert_eq!(plain, dynamics.pair_force);

            // Without damping too, and damping of nothing is none.
            for alpha in [0.2, 0.0] {
                let (mut one, mut other) = (dynamics.state.clone(), dynamics.state.clone());
                let reference = dynamics.state.position.clone();
                let (dt, pull) = (1.0e-5, [0.0, -9.81]);
                let of_one = integrate(&mut one, &reference, dt, pull, alpha, 1.0e-6);
                let of_other =
                    integrate_plain::<true>(&mut other, &reference, dt, pull, alpha, 1.0e-6);
                assert_eq!(of_one, of_other);
                assert_eq!(one.position, other.position);
                assert_eq!(one.velocity, other.velocity);
            }
        }
        assert!(touching > 1000, "{touching}");
    }
}
