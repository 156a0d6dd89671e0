//! Measures against cases that can be worked out by hand.

mod sums;

use std::f64::consts::PI;

use assert_approx_eq::assert_approx_eq;
use grains::measure::porosity::{self, Window};
use grains::measure::{self, Bed, cells, neighbourhood, stress};
use grains::scene::{Cell, Tension, Viscosity};

use crate::support::*;

fn contact(id1: u32, id2: u32, normal: [f64; 2], force: f64, point: [f64; 2]) -> Contact {
    Contact {
        id1,
        id2,
        overlap: 1.0e-6,
        normal_force: force,
        tangential_force: 0.0,
        normal,
        point,
    }
}

fn bed_of<'a>(bodies: &'a Bodies, contacts: &'a [Contact]) -> Bed<'a> {
    Bed {
        bodies,
        contacts,
        across: &[],
    }
}

/// The disc of Figure 4: R = 1 m, vertical line forces of 1 N/m, horizontal ones of 0.5 N/m. Table 3
/// says Σ_zz = 2, Σ_xx = 1, no shear.
#[test]
fn the_disc_of_figure_4_has_the_extensive_stress_of_table_3() {
    let mut bodies = Bodies::default();
    bodies.push([0.0, 0.0], [0.0, 0.0], 1.0, 1.0);
    for place in [[0.0, 2.0], [0.0, -2.0], [2.0, 0.0], [-2.0, 0.0]] {
        bodies.push(place, [0.0, 0.0], 1.0, 1.0);
    }
    let contacts = [
        contact(0, 1, [0.0, 1.0], 1.0, [0.0, 1.0]),
        contact(0, 2, [0.0, -1.0], 1.0, [0.0, -1.0]),
        contact(0, 3, [1.0, 0.0], 0.5, [1.0, 0.0]),
        contact(0, 4, [-1.0, 0.0], 0.5, [-1.0, 0.0]),
    ];
    let bed = bed_of(&bodies, &contacts);
    let stress = stress::of_grains(bed)[0];
    assert_approx_eq!(stress[(0, 0)], 1.0);
    assert_approx_eq!(stress[(2, 2)], 2.0);
    assert_approx_eq!(stress[(0, 2)], 0.0);
    // The same from the other side of each contact: body 1 and body 2 swapped.
    let swapped = contacts.map(|c| {
        let normal = c.normal.map(|component| -component);
        contact(c.id2, c.id1, normal, c.normal_force, c.point)
    });
    let bed = bed_of(&bodies, &swapped);
    assert_approx_eq!(stress::of_grains(bed)[0][(2, 2)], 2.0);
}

/// n columns of m discs, touching, in a box that fits them.
fn square_packing(columns: u32, rows: u32) -> (Scene, Bodies, Vec<Contact>) {
    let mut scene = paper_scene(1, columns * rows);
    scene.container.width = f64::from(columns) * 0.01;
    let (left, right, floor) = (columns * rows, columns * rows + 1, columns * rows + 2);
    let mut bodies = Bodies::default();
    let mut contacts = Vec::new();
    let weight = scene.grain_mass(0.005) * scene.gravity;
    for row in 0..rows {
        for column in 0..columns {
            let id = row * columns + column;
            let place = [column, row].map(|count| 0.005 + 0.01 * f64::from(count));
            bodies.push(place, [0.0, 0.0], 0.005, scene.grain_mass(0.005));
            let above = f64::from(rows - row);
            let below = [place[0], place[1] - 0.005];
            let partner = if row == 0 { floor } else { id - columns };
            contacts.push(contact(partner, id, [0.0, 1.0], weight * above, below));
            if column == 0 {
                contacts.push(contact(left, id, [1.0, 0.0], 3.0, [0.0, place[1]]));
            } else {
                let between = [place[0] - 0.005, place[1]];
                contacts.push(contact(id - 1, id, [1.0, 0.0], 3.0, between));
            }
            if column == columns - 1 {
                let at = [place[0] + 0.005, place[1]];
                contacts.push(contact(right, id, [-1.0, 0.0], 3.0, at));
            }
        }
    }
    (scene, bodies, contacts)
}

#[test]
fn a_square_packing_has_its_heights_porosities_and_cells() {
    let (scene, bodies, _) = square_packing(30, 20);
    let porosity = 1.0 - PI / 4.0;
    assert_approx_eq!(measure::highest_grain(&bodies), 0.2, 1e-12);
    assert_approx_eq!(measure::mean_surface(&scene, &bodies), 0.2, 1e-12);
    assert_approx_eq!(measure::twice_centre_of_mass(&bodies), 0.2, 1e-12);
    let height = measure::highest_grain(&bodies);
    let from_height = porosity::from_height(&bodies, 0.3, height);
    assert_approx_eq!(from_height, porosity, 1e-12);
    let window = Window::interior(&scene, 0.2);
    let in_window = porosity::in_window(&bodies, &window).expect("an interior");
    assert_approx_eq!(in_window, porosity, 1e-10);
    let cells = cells::radical(&scene, &bodies);
    for area in &cells.area {
        assert_approx_eq!(area, &1.0e-4, 1e-13);
    }
    let of_cells = porosity::of_cells(&bodies, &cells, &window).expect("an interior");
    assert_approx_eq!(of_cells, porosity, 1e-12);
    // A bed too low to have an interior has no such porosity.
    let window = Window::interior(&scene, 0.08);
    assert_eq!(porosity::in_window(&bodies, &window), None);
}

#[test]
fn grains_of_equal_porosity_share_the_room_of_all_cells_by_their_areas() {
    let (mut scene, mut bodies, _) = square_packing(30, 20);
    bodies.radius[0] = 0.0025;
    let radical = cells::of(&scene, &bodies);
    assert_eq!(radical, cells::radical(&scene, &bodies));
    scene.measurement.cell = Cell::EqualPorosity;
    let equal = cells::of(&scene, &bodies);
    let sum = |cells: &cells::Cells| cells.area.iter().sum::<f64>();
    assert_approx_eq!(sum(&equal), sum(&radical), 1e-12);
    assert_approx_eq!(equal.area[1], 4.0 * equal.area[0], 1e-15);
    assert!(radical.area[1] < 4.0 * radical.area[0]);
}

#[test]
fn a_hollow_surface_lowers_the_mean_height_only() {
    let (scene, mut bodies, _) = square_packing(30, 20);
    // The last grain leaves the top row: a hole one column wide, into which its neighbour reaches
    // with the height of its centre.
    let last = bodies.len() - 1;
    bodies.z[last] = 0.1;
    assert_approx_eq!(measure::highest_grain(&bodies), 0.2, 1e-12);
    let mean = measure::mean_surface(&scene, &bodies);
    assert_approx_eq!(mean, 0.2 - 0.005 / 30.0, 1e-9);
}

#[test]
fn a_standing_square_packing_bears_its_weight_in_its_stress() {
    let (mut scene, bodies, contacts) = square_packing(30, 20);
    // Not midway between grains: nearest is the one in row 8 (from 0), column 15.
    scene.control_points[0].offset = 0.003;
    scene.control_points[0].depth = 0.112;
    let bed = bed_of(&bodies, &contacts);
    let weight = scene.grain_mass(0.005) * scene.gravity;
    let all = stress::at_control_points(&scene, bed, &cells::radical(&scene, &bodies), 0.2);
    let at_o = &all[0];
    assert_eq!((at_o.name.as_str(), at_o.grain), ("O", 8 * 30 + 15));
    // It bears 11 grains and hands on 12.
    let mean_force = weight * 11.5;
    assert_approx_eq!(at_o.grain_stress.zz, mean_force / 0.01, 1e-6);
    assert_approx_eq!(at_o.grain_stress.xx, 3.0 / 0.01, 1e-6);
    assert_approx_eq!(at_o.grain_stress.xz, 0.0, 1e-9);
    assert_approx_eq!(at_o.control_volume_zz, at_o.grain_stress.zz * 2.5e-5, 1e-12);
    let local = at_o.local_mean.expect("grains nearby");
    assert_approx_eq!(local.xx, 300.0, 1e-6);
    // Depth by weight: rows above times weight over the width of a column.
    assert!((local.zz - 11.2 * weight / 0.01).abs() < 0.5 * weight / 0.01);

    let coordination = neighbourhood::coordination(bed);
    // Four contacts each, but the top row has three.
    assert_approx_eq!(coordination.mean, (4.0 * 570.0 + 3.0 * 30.0) / 600.0, 1e-12);
    assert_approx_eq!(coordination.rattler_share, 0.0);
    assert!(measure::unbalanced_force(scene.gravity, bed).expect("contacts") < 1e-12);
    let one = bed_of(&bodies, &contacts[..1]);
    let stored = measure::elastic_energy(&scene, one);
    assert_approx_eq!(stored, 0.5 * 20.0 * weight * 1e-6, 1e-12);
    // With friction the tangential spring of 2 N stores ½·F²/k_s more.
    let mut rough = scene.clone();
    rough.material.friction_angle = 0.5;
    rough.material.stiffness_ratio = 0.25;
    let mut sheared = contacts[0];
    sheared.tangential_force = 2.0;
    let sheared = [sheared];
    let one = bed_of(&bodies, &sheared);
    let k_s = 0.25 * scene.material.youngs_modulus * 0.005;
    let more = measure::elastic_energy(&rough, one) - stored;
    assert!((more / (2.0 / k_s) - 1.0).abs() < 1e-9, "{more}");
    // With dashpots the force is not the spring's alone: ½k_n u².
    let mut damped = scene.clone();
    let (c_n, tension) = (1.0, Tension::Clipped);
    damped.contact.viscosity = Viscosity::Dashpot { c_n, tension };
    let of_spring = 0.5 * scene.material.youngs_modulus * 0.005 * 1e-12;
    let found = measure::elastic_energy(&damped, one);
    near(found / of_spring, 1.0, 1e-9);
}

#[test]
fn rattlers_and_what_is_unbalanced_show() {
    let (scene, mut bodies, mut contacts) = square_packing(5, 4);
    bodies.push([0.025, 0.3], [0.0, 0.0], 0.005, scene.grain_mass(0.005));
    // The new grain takes an id that a wall had.
    for contact in &mut contacts {
        for id in [&mut contact.id1, &mut contact.id2] {
            if *id >= 20 {
                *id += 1;
            }
        }
    }
    let bed = bed_of(&bodies, &contacts);
    let coordination = neighbourhood::coordination(bed);
    assert_approx_eq!(coordination.rattler_share, 1.0 / 21.0);
    assert_approx_eq!(
        coordination.mean_without_rattlers.expect("grains"),
        75.0 / 20.0
    );
    // One grain falls with its weight; all others are at rest.
    let weight = scene.grain_mass(0.005) * scene.gravity;
    let forces: f64 = contacts.iter().map(|c| c.normal_force).sum();
    let unbalanced = measure::unbalanced_force(scene.gravity, bed).expect("contacts");
    let wanted = weight / 21.0 / (forces / contacts.len() as f64);
    assert_approx_eq!(unbalanced, wanted, 1e-9);
}

#[test]
fn a_bed_without_a_load_is_measured_as_poured() {
    let (scene, bodies, contacts) = square_packing(4, 4);
    let bed = bed_of(&bodies, &contacts);
    let moments = |settled: Option<Bed<'_>>| -> Vec<String> {
        let all = measure::all(&scene, settled, bed).into_iter();
        let moments =
            all.map(|measure| measure.key.split('.').next().unwrap_or_default().to_owned());
        let mut moments: Vec<String> = moments.collect();
        moments.dedup();
        moments
    };
    assert_eq!(moments(None), ["poured"]);
    assert_eq!(moments(Some(bed)), ["settled", "loaded"]);
}

#[test]
fn control_points_outside_the_bed_have_no_stress() {
    let (scene, bodies, contacts) = square_packing(30, 5);
    let bed = bed_of(&bodies, &contacts);
    let all = stress::at_control_points(&scene, bed, &cells::radical(&scene, &bodies), 0.05);
    assert!(all.is_empty());
}

/// One contact holds nothing: two grains that touch only each other are rattlers, three in a row have
/// one that is not.
#[test]
fn a_grain_with_a_single_contact_is_a_rattler() {
    let mut bodies = Bodies::default();
    for column in 0..3 {
        bodies.push([0.01 * f64::from(column), 0.1], [0.0, 0.0], 0.005, 0.2);
    }
    let pair = |id, x| contact(id, id + 1, [1.0, 0.0], 1.0, [x, 0.1]);
    let touching = [pair(0, 0.005), pair(1, 0.015)];
    for (contacts, rattlers) in [(&touching[..1], 1.0), (&touching[..], 2.0 / 3.0)] {
        let bed = bed_of(&bodies, contacts);
        assert_approx_eq!(neighbourhood::coordination(bed).rattler_share, rattlers);
    }
}

#[test]
fn the_floor_bears_what_presses_down_if_the_bed_is_at_rest() {
    let scene = paper_scene(1, 2);
    let mut bodies = Bodies::default();
    bodies.push([0.1, 0.005], [0.0, 0.0], 0.005, 2.0);
    bodies.push([0.1, 0.015], [0.0, 0.0], 0.005, 3.0);
    let weight = 5.0 * scene.gravity;
    // The walls have the ids after the grains: left, right, floor. What leans on a wall does not count.
    let pair = contact(0, 1, [0.0, 1.0], 3.0 * scene.gravity, [0.1, 0.01]);
    let leaning = contact(2, 0, [1.0, 0.0], 7.0, [0.095, 0.005]);
    let share = |floor: f64, pressed: f64| {
        let contacts = [pair, leaning, contact(4, 0, [0.0, 1.0], floor, [0.1, 0.0])];
        let bed = bed_of(&bodies, &contacts);
        measure::borne_by_floor(&scene, bed, pressed)
    };
    assert_approx_eq!(share(weight, 0.0), 1.0, 1e-15);
    assert_approx_eq!(share(0.9 * weight, 0.0), 0.9, 1e-15);
    assert_approx_eq!(share(weight, weight), 0.5, 1e-15);
}
