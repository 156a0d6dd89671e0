//! The frictionless kernel: the normal springs of [`super::contact`] arranged for vector lanes.
//!
//! In exact mode no operation is fused, left out or reordered, so a lane gives the bits of the scalar
//! law. In free mode the force is k_n·(reach/d − 1)·(x_2 − x_1): the same number in exact arithmetic, with
//! fewer divisions.

#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod single;

use multiversion::multiversion;

use super::rows::{LANES, Lanes, Rows};

/// The summed spring force on every grain that is in the rows, N; what was in `force` before is lost.
pub fn sum_forces<const FREE: bool>(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    #[cfg(target_arch = "x86_64")]
    if avx512::available() {
        return avx512::sum_forces::<FREE>(position, rows, force);
    }
    if FREE {
        free(position, rows, force);
    } else {
        exact(position, rows, force);
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn exact(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    sum_forces_plain::<false>(position, rows, force);
}

#[multiversion(targets("x86_64+avx2"))]
fn free(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    sum_forces_plain::<true>(position, rows, force);
}

/// As any machine can do it.
#[inline(always)]
fn sum_forces_plain<const FREE: bool>(position: &[[f64; 2]], rows: &Rows, force: &mut [[f64; 2]]) {
    for (grain, columns) in rows.grain.iter().zip(rows.start.windows(2)) {
        let columns = columns[0] as usize..columns[1] as usize;
        let neighbours = rows.other[columns.clone()]
            .iter()
            .zip(&rows.reach[columns.clone()])
            .zip(&rows.stiffness[columns]);
        let (own_x, own_z) = gather(position, grain);
        let (mut sum_x, mut sum_z) = ([0.0; LANES], [0.0; LANES]);
        for ((other, reach), stiffness) in neighbours {
            let (x, z) = gather(position, other);
            for lane in 0..LANES {
                let (dx, dz) = (x[lane] - own_x[lane], z[lane] - own_z[lane]);
                let distance = (dx * dx + dz * dz).sqrt();
                let overlap = reach[lane] - distance;
                let pull = if FREE {
                    let share = stiffness[lane] * (reach[lane] / distance - 1.0);
                    [share * dx, share * dz]
                } else {
                    let size = stiffness[lane] * overlap;
                    [size * (dx / distance), size * (dz / distance)]
                };
                // A mask instead of a choice, so that no lane becomes a branch.
                let touching = u64::from(overlap >= 0.0).wrapping_neg();
                sum_x[lane] -= f64::from_bits(pull[0].to_bits() & touching);
                sum_z[lane] -= f64::from_bits(pull[1].to_bits() & touching);
            }
        }
        for lane in 0..LANES {
            force[grain[lane] as usize] = [sum_x[lane], sum_z[lane]];
        }
    }
}

#[inline(always)]
fn gather(of: &[[f64; 2]], ids: &Lanes<u32>) -> (Lanes<f64>, Lanes<f64>) {
    let (mut x, mut z) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        [x[lane], z[lane]] = of[ids[lane] as usize];
    }
    (x, z)
}

#[cfg(test)]
mod tests {
    use super::super::Mode;
    use super::super::constants::Constants;
    use super::super::dynamics::Dynamics;
    use super::super::neighbours::Skin;
    use super::super::state::State;
    use super::single::Single;
    use super::*;
    use crate::generate::initial_bodies;
    use crate::model::Model;
    use crate::scene::paper_scene;

    /// The obvious version: the scalar law, one pair after the other in the order of the sorted loop.
    fn reference(state: &State, constants: &Constants) -> Vec<[f64; 2]> {
        let mut force = vec![[0.0; 2]; state.position.len()];
        for a in 0..force.len() {
            for b in a + 1..force.len() {
                let Some(touch) = state.grain_touch(a, b) else {
                    continue;
                };
                let stiffness = constants.stiffness(state.radius[a], state.radius[b]);
                let pair = touch.spring_force(stiffness);
                for axis in 0..2 {
                    force[a][axis] -= pair[axis];
                    force[b][axis] += pair[axis];
                }
            }
        }
        force
    }

    fn bits(force: &[[f64; 2]]) -> Vec<[u64; 2]> {
        force.iter().map(|f| f.map(f64::to_bits)).collect()
    }

    /// The largest difference over the largest force.
    fn difference(force: &[[f64; 2]], from: &[[f64; 2]]) -> f64 {
        let largest = from.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
        let pairs = force.iter().flatten().zip(from.iter().flatten());
        pairs.fold(0.0f64, |a, (b, c)| a.max((b - c).abs())) / largest
    }

    /// Moments of a pour in which grains touch; 3,001 of them, so that a group stays unfilled.
    fn moments(mut look: impl FnMut(&Dynamics)) {
        let scene = paper_scene(1, 3001);
        let constants = Constants::new(&Model::of(&scene), scene.particles.count);
        let bodies = initial_bodies(&scene);
        let skin = Skin::Adaptive { radius: 0.005 };
        let mut dynamics =
            Dynamics::new(&bodies, None, constants, skin, Mode::Exact).expect("a sound start");
        for step in 1..=9000 {
            dynamics.step().expect("a sound step");
            if step % 3000 == 0 {
                look(&dynamics);
            }
        }
    }

    #[test]
    fn lanes_have_the_bits_of_the_scalar_law_summed_pair_after_pair() {
        let mut touching = 0;
        moments(|dynamics| {
            let Dynamics {
                state, neighbours, ..
            } = dynamics;
            let expected = reference(state, &dynamics.constants);
            touching += expected.iter().filter(|force| **force != [0.0; 2]).count();
            let mut force = vec![[f64::NAN; 2]; expected.len()];
            sum_forces::<false>(&state.position, &neighbours.rows, &mut force);
            assert_eq!(
                bits(&force),
                bits(&expected),
                "this machine's widest vectors"
            );
            sum_forces_plain::<false>(&state.position, &neighbours.rows, &mut force);
            assert_eq!(bits(&force), bits(&expected), "the plainest machine's code");
            exact(&state.position, &neighbours.rows, &mut force);
            assert_eq!(bits(&force), bits(&expected), "as without 512-bit vectors");
        });
        assert!(touching > 1000, "{touching}");
    }

    #[test]
    fn free_and_single_sums_differ_by_their_rounding_alone() {
        moments(|dynamics| {
            let Dynamics {
                state, neighbours, ..
            } = dynamics;
            let (position, rows) = (&state.position, &neighbours.rows);
            let expected = reference(state, &dynamics.constants);
            let mut force = vec![[f64::NAN; 2]; expected.len()];
            // Rounding of distances over overlaps: 1e-16·R/1e-5·R here, 6e-8 of the same in single.
            sum_forces::<true>(position, rows, &mut force);
            assert!(difference(&force, &expected) < 1.0e-10);
            assert_ne!(bits(&force), bits(&expected));
            sum_forces_plain::<true>(position, rows, &mut force);
            assert!(difference(&force, &expected) < 1.0e-10);
            let mut single = Single::default();
            single.build(position, rows, 0.01);
            single.sum_forces(position, rows, &mut force);
            let found = difference(&force, &expected);
            assert!(found < 1.0e-3 && found > 1.0e-8, "{found:e}");
        });
    }
}
