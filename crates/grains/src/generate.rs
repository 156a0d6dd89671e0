//! Initial grains as a pure function of the scene: the same bits on every machine.
//!
//! Randomness is ChaCha8 with the realization as its stream; numbers are made from its bits with
//! exact operations only (no transcendental function), and grains are numbered row by row from the
//! floor up, so that neighbours stand near each other in memory.

use chacha20::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use crate::model::{Model, rotates};
use crate::scene::{Cloud, Scene};
use crate::tables::Bodies;

/// Key of the random numbers; the realization selects the stream under it.
const KEY: &[u8; 32] = b"crossgrain: the cloud of grains ";

/// The cloud that is poured: positions, velocities, radii and masses of `scene.particles.count` grains,
/// spins and moments of inertia where grains rotate.
pub fn initial_bodies(scene: &Scene) -> Bodies {
    let Cloud::JitteredLattice {
        columns,
        jitter,
        speed,
        spin,
        over,
    } = scene.cloud;
    let mut random = ChaCha8Rng::from_seed(*KEY);
    random.set_stream(scene.realization);
    let count = scene.particles.count as usize;
    let [from, to] = over.unwrap_or([0.0, scene.container.width]);
    let pitch = (to - from) / f64::from(columns);
    let mean_radius = 0.5 * scene.particles.mean_diameter;
    let largest = mean_radius * (1.0 + scene.particles.dispersion);
    let play = jitter * (0.5 * pitch - largest);

    // Bodies are felt from both sides, so nothing may start beneath one.
    let floor = [scene.container.width, scene.container.depth.unwrap_or(0.0)];
    let tops = scene.obstacles.iter().map(|obstacle| obstacle.top(floor));
    let bottom = tops.fold(0.0, f64::max);

    let mut bodies = Bodies::default();
    // In space row by row from front to back in each layer.
    let rows = |depth: f64| ((depth / pitch) as usize).max(1);
    let rows = scene.container.depth.map_or(1, rows);
    let row_pitch = scene.container.depth.unwrap_or(0.0) / rows as f64;
    for index in 0..count {
        let column = (index % columns as usize) as f64;
        let behind = (index / columns as usize % rows) as f64;
        let row = (index / (columns as usize * rows)) as f64;
        let mut random = || symmetric(&mut random);
        let radius = mean_radius * (1.0 + scene.particles.dispersion * random());
        let x = from + (column + 0.5) * pitch + play * random();
        let z = (row + 0.5) * pitch + play * random() + bottom;
        let velocity = [speed * random(), speed * random()];
        bodies.push([x, z], velocity, radius, scene.grain_mass(radius));
        if scene.in_space() {
            bodies.y.push((behind + 0.5) * row_pitch + play * random());
            bodies.vy.push(speed * random());
        }
    }
    if rotates(scene) {
        // What nothing slows down in pouring would never rest.
        let turns_in_pouring = Model::of(scene).law.rotates();
        let spin = if turns_in_pouring { spin } else { 0.0 };
        // After all other numbers, so that a cloud has the same places with and without spins.
        // A sum, so that no spin is a negative zero.
        let mut spins = || {
            let spins = (0..count).map(|_| 0.0 + spin * symmetric(&mut random));
            spins.collect()
        };
        bodies.spin = spins();
        if scene.in_space() {
            (bodies.spin_x, bodies.spin_z) = (spins(), spins());
        }
        can_turn(scene, &mut bodies);
    }
    bodies
}

/// Gives grains that turn in the scene their moments of inertia where they have none, as those of a bed that was poured in a scene
/// without rotation; they do not turn yet.
pub fn can_turn(scene: &Scene, bodies: &mut Bodies) {
    if !rotates(scene) || !bodies.inertia.is_empty() {
        return;
    }
    let grains = bodies.radius.iter().zip(&bodies.mass);
    let inertia = grains.map(|(radius, mass)| scene.grain_inertia(*radius, *mass));
    bodies.inertia = inertia.collect();
    bodies.spin.resize(bodies.mass.len(), 0.0);
    for across in [&mut bodies.spin_x, &mut bodies.spin_z] {
        across.resize(bodies.y.len(), 0.0);
    }
}

/// Uniform in [−1, 1): 53 random bits, scaled exactly.
pub fn symmetric(random: &mut ChaCha8Rng) -> f64 {
    let bits = random.next_u64() >> 11;
    bits as f64 * (2.0 / (1u64 << 53) as f64) - 1.0
}
