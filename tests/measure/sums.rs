//! Which grains go into a neighbourhood and into a piece of a profile.

use assert_approx_eq::assert_approx_eq;
use grains::measure::neighbourhood::{GROWING, SINGLY};
use grains::measure::{cells, neighbourhood, stress};

use super::{bed_of, contact};

use crate::support::*;

/// A bed of 300 grains in which grain i has Σ_zz = i + 1 and half of it across: sums tell which grains went in.
fn numbered() -> (Scene, Bodies, cells::Cells, Vec<nalgebra::Matrix3<f64>>) {
    let scene = small_scene();
    let bodies = grains::generate::initial_bodies(&scene);
    let cells = cells::radical(&scene, &bodies);
    let extensive = |id: usize| {
        let (across, up) = (0.5 * (id + 1) as f64, (id + 1) as f64);
        nalgebra::Matrix3::new(across, 0.0, 0.25, 0.0, 0.0, 0.0, 0.25, 0.0, up)
    };
    let extensive = (0..bodies.len()).map(extensive).collect();
    (scene, bodies, cells, extensive)
}

#[test]
fn a_neighbourhood_has_the_nearest_grains_in_order() {
    let (_, bodies, cells, extensive) = numbered();
    let contacts = [contact(3, 70, [1.0, 0.0], 1.0, [0.1, 0.1])];
    let bed = bed_of(&bodies, &contacts);
    let place = [0.17, 0.06];
    let found = neighbourhood::of("P", place, bed, &cells, &extensive);
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    let distance = |id: usize| (bodies.x[id] - place[0]).hypot(bodies.z[id] - place[1]);
    order.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    assert_eq!(found.singly.len(), SINGLY);
    for (neighbour, id) in found.singly.iter().zip(&order) {
        assert_eq!(neighbour.zz, (*id + 1) as f64);
        assert_eq!(neighbour.xx, 0.5 * neighbour.zz);
        assert_eq!(neighbour.xz, 0.25);
        assert_eq!(neighbour.cell, cells.area[*id]);
        assert_eq!(neighbour.contacts, u32::from([3, 70].contains(id)));
        let away = neighbour.from_point[0].hypot(neighbour.from_point[1]);
        assert_approx_eq!(away, distance(*id), 1e-15);
    }
    assert_eq!(found.together.len(), GROWING.len());
    for (together, count) in found.together.iter().zip(GROWING) {
        let nearest = &order[..count];
        assert_eq!(together.grains, count);
        let sum: f64 = nearest.iter().map(|id| (*id + 1) as f64).sum();
        assert_eq!(together.zz, sum);
        let volume: f64 = nearest.iter().map(|id| cells.area[*id]).sum();
        assert_approx_eq!(together.cell, volume, 1e-15);
        let rise = nearest
            .iter()
            .map(|id| cells.area[*id] * (bodies.z[*id] - place[1]));
        let rise: f64 = rise.sum();
        assert_approx_eq!(together.rise, rise / volume, 1e-15);
    }
    // Fewer grains than the largest control volume: as many sums as there can be.
    let mut few = Bodies::default();
    for id in 0..10 {
        let place = [bodies.x[id], bodies.z[id]];
        few.push(place, [0.0, 0.0], bodies.radius[id], 1.0);
    }
    let bed = bed_of(&few, &[]);
    let found = neighbourhood::of("P", place, bed, &cells, &extensive);
    let counts: Vec<usize> = found.together.iter().map(|cells| cells.grains).collect();
    assert_eq!(counts, [1, 2, 4, 8]);
}

#[test]
fn a_profile_has_the_mean_stress_of_every_piece() {
    let (scene, bodies, cells, _) = numbered();
    let bed = bed_of(&bodies, &[]);
    // Σ_zz = V_p·σ with a stress of a field that is linear across: every piece shows it.
    let down = |zz| nalgebra::Matrix3::from_diagonal(&[0.0, 0.0, zz].into());
    let linear = |id: usize| down(cells.area[id] * (100.0 + 50.0 * bodies.x[id]));
    let linear: Vec<_> = (0..bodies.len()).map(linear).collect();
    let across = stress::across(&scene, bed, &cells, &linear, 0.06);
    let length = stress::piece(&scene, scene.container.width);
    assert_eq!(across.len(), 15);
    assert_approx_eq!(length, 0.02, 1e-12);
    for (piece, stress) in across.iter().enumerate() {
        let [low, high] = [piece, piece + 1].map(|edge| 100.0 + 50.0 * length * edge as f64);
        assert!((low..=high).contains(stress), "piece {piece}: {stress}");
    }
    // Down the axis, a stress that grows with depth.
    let surface = 0.12;
    let deeper = |id: usize| down(cells.area[id] * (surface - bodies.z[id]));
    let deeper: Vec<_> = (0..bodies.len()).map(deeper).collect();
    let down = stress::down(&scene, bed, &cells, &deeper, surface);
    assert_eq!(down.len(), 6);
    let length = stress::piece(&scene, surface);
    for (piece, stress) in down.iter().enumerate() {
        let [low, high] = [piece, piece + 1].map(|edge| length * edge as f64);
        let fits = *stress == 0.0 || (low..=high).contains(stress);
        assert!(fits, "piece {piece}: {stress}");
    }
    assert!(down.iter().filter(|stress| **stress > 0.0).count() >= 5);
}
