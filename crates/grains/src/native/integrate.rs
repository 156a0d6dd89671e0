//! The integrator: leapfrog, with Cundall's local damping where the scene has it.

use multiversion::multiversion;

use super::state::State;

/// Components that are advanced together: those of eight grains.
const WIDTH: usize = 16;

/// The fastest component of a step, squared, m²/s²: across and up.
pub type Fastest = [f64; 2];

/// Advances velocities and positions: v += dt·a, x += dt·v. With damping the acceleration, gravity
/// included, is scaled by 1 − α·sign(a·(v + ½dt·a)); without it nothing is computed for it. Where a velocity is not
/// a number, the fastest is not one either.
pub fn integrate(state: &mut State, dt: f64, gravity: [f64; 2], alpha: f64) -> Fastest {
    if alpha == 0.0 {
        undamped(state, dt, gravity)
    } else {
        damped(state, dt, gravity, alpha)
    }
}

/// [`integrate_plain`] with local damping, compiled for the widest vector unit that the machine has.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn damped(state: &mut State, dt: f64, gravity: [f64; 2], alpha: f64) -> Fastest {
    integrate_plain::<true>(state, dt, gravity, alpha)
}

/// [`integrate_plain`] without it, likewise.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn undamped(state: &mut State, dt: f64, gravity: [f64; 2]) -> Fastest {
    integrate_plain::<false>(state, dt, gravity, 0.0)
}

#[inline(always)]
fn integrate_plain<const DAMPED: bool>(
    state: &mut State,
    dt: f64,
    gravity: [f64; 2],
    alpha: f64,
) -> Fastest {
    let pull: [f64; WIDTH] = std::array::from_fn(|lane| gravity[lane % 2]);
    let mut fastest = [0.0; WIDTH];
    // A maximum passes over what is not a number, a sum does not.
    let mut total = [0.0; WIDTH];
    let (positions, last_positions) = state.position.as_flattened_mut().as_chunks_mut::<WIDTH>();
    let (velocities, last_velocities) = state.velocity.as_flattened_mut().as_chunks_mut::<WIDTH>();
    let (forces, last_forces) = state.force.as_flattened().as_chunks::<WIDTH>();
    let (masses, last_masses) = state.component_mass.as_chunks::<WIDTH>();
    let moving = positions.iter_mut().zip(velocities);
    for ((position, velocity), (force, mass)) in moving.zip(forces.iter().zip(masses)) {
        for lane in 0..WIDTH {
            advance::<DAMPED>(
                (&mut position[lane], &mut velocity[lane]),
                force[lane] / mass[lane] + pull[lane],
                dt,
                alpha,
                (&mut fastest[lane], &mut total[lane]),
            );
        }
    }
    let moving = last_positions.iter_mut().zip(last_velocities);
    let pushed = last_forces.iter().zip(last_masses);
    for (lane, ((position, velocity), (force, mass))) in moving.zip(pushed).enumerate() {
        let acceleration = force / mass + pull[lane];
        advance::<DAMPED>(
            (position, velocity),
            acceleration,
            dt,
            alpha,
            (&mut fastest[lane], &mut total[lane]),
        );
    }
    if total.iter().any(|total: &f64| total.is_nan()) {
        return [f64::NAN; 2];
    }
    let of = |axis: usize| {
        fastest
            .iter()
            .skip(axis)
            .step_by(2)
            .copied()
            .fold(0.0, f64::max)
    };
    [of(0), of(1)]
}

#[inline(always)]
fn advance<const DAMPED: bool>(
    (position, velocity): (&mut f64, &mut f64),
    mut acceleration: f64,
    dt: f64,
    alpha: f64,
    (fastest, total): (&mut f64, &mut f64),
) {
    if DAMPED {
        let power = acceleration * (*velocity + 0.5 * dt * acceleration);
        let sign = f64::from(u8::from(power > 0.0)) - f64::from(u8::from(power < 0.0));
        acceleration *= 1.0 - alpha * sign;
    }
    *velocity += dt * acceleration;
    *position += dt * *velocity;
    let square = *velocity * *velocity;
    *total += square;
    *fastest = if square > *fastest { square } else { *fastest };
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
    use super::*;
    use crate::generate::initial_bodies;
    use crate::model::Kernel;
    use crate::scene::paper_scene;

    /// One component as it is written down in the documentation.
    fn reference(
        x: f64,
        v: f64,
        force: f64,
        mass: f64,
        pull: f64,
        dt: f64,
        alpha: f64,
    ) -> [f64; 2] {
        let undamped = force / mass + pull;
        let power = undamped * (v + 0.5 * dt * undamped);
        let sign = if power > 0.0 {
            1.0
        } else if power < 0.0 {
            -1.0
        } else {
            0.0
        };
        let acceleration = if alpha == 0.0 {
            undamped
        } else {
            undamped * (1.0 - alpha * sign)
        };
        let v = v + dt * acceleration;
        [x + dt * v, v]
    }

    #[test]
    fn lanes_have_the_bits_of_one_component_after_the_other() {
        // Not a multiple of the width, so that the last lanes have their own loop.
        let mut start = State::new(
            &initial_bodies(&paper_scene(1, 1003)),
            None,
            Kernel::Frictionless,
        );
        for (id, force) in start.force.iter_mut().enumerate() {
            *force = [
                (id as f64).sin() * 90.0,
                if id % 7 == 0 { 0.0 } else { 3.0 },
            ];
        }
        for alpha in [0.0, 0.2] {
            let mut state = start.clone();
            let (dt, gravity) = (1.3e-5, [0.0, -9.81]);
            let mut fastest = integrate(&mut state, dt, gravity, alpha);
            for id in 0..start.position.len() {
                for axis in 0..2 {
                    let [x, v] = reference(
                        start.position[id][axis],
                        start.velocity[id][axis],
                        start.force[id][axis],
                        start.mass[id],
                        gravity[axis],
                        dt,
                        alpha,
                    );
                    assert_eq!(state.position[id][axis].to_bits(), x.to_bits());
                    assert_eq!(state.velocity[id][axis].to_bits(), v.to_bits());
                    assert!(v * v <= fastest[axis]);
                }
            }
            // Once more: the speeds reported are reached, not merely not exceeded.
            for axis in 0..2 {
                let speeds = state.velocity.iter().map(|v| v[axis] * v[axis]);
                fastest[axis] -= speeds.fold(0.0, f64::max);
            }
            assert_eq!(fastest, [0.0; 2]);
        }
    }
}
