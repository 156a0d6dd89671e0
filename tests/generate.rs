//! The initial cloud.

use grains::scene::{Cloud, Rotation, Shape};

use crate::support::*;

#[test]
fn the_cloud_has_its_recorded_bits() {
    let bodies = initial_bodies(&paper_scene(1, 5000));
    assert_eq!(bodies.digest(), "dd2f11aca300c0b0");
}

#[test]
fn realizations_differ_and_the_number_of_grains_does_not_matter() {
    let one = initial_bodies(&paper_scene(1, 100));
    let two = initial_bodies(&paper_scene(2, 100));
    let more = initial_bodies(&paper_scene(1, 200));
    assert!(one.x.iter().zip(&two.x).all(|(a, b)| a != b));
    assert_eq!(one.x[..], more.x[..100]);
}

#[test]
fn grains_are_loose_inside_the_box_and_of_the_wanted_sizes() {
    let scene = paper_scene(3, 5000);
    let bodies = initial_bodies(&scene);
    for i in 0..bodies.len() {
        let radius = bodies.radius[i];
        assert!((0.00475..=0.00525).contains(&radius));
        assert!(bodies.x[i] > radius && bodies.x[i] < 1.0 - radius && bodies.z[i] > radius);
        assert!(bodies.vx[i].abs() <= 0.3 && bodies.vz[i].abs() <= 0.3);
        for j in 0..i {
            let apart = (bodies.x[i] - bodies.x[j]).hypot(bodies.z[i] - bodies.z[j]);
            assert!(apart > radius + bodies.radius[j], "{i} and {j} overlap");
        }
    }
    // Uniform sizes: mean and mean square of the published range within four standard errors.
    let mean: f64 = bodies.radius.iter().sum::<f64>() / 5000.0;
    let error = 0.00025 / 3f64.sqrt() / 5000f64.sqrt();
    assert!((mean - 0.005).abs() < 4.0 * error, "{mean}");
    let smallest = bodies.radius.iter().copied().fold(1.0, f64::min);
    let largest = bodies.radius.iter().copied().fold(0.0, f64::max);
    assert!(smallest < 0.004752 && largest > 0.005248);
}

#[test]
fn grains_that_rub_have_spins_and_inertias_in_the_same_places() {
    for shape in [Shape::Disc, Shape::Sphere] {
        let mut scene = paper_scene(2, 500);
        scene.particles.shape = shape;
        scene.particles.dispersion = 0.2;
        let smooth = initial_bodies(&scene);
        assert!(smooth.spin.is_empty() && smooth.inertia.is_empty());
        let with_spin = |scene: &mut Scene, speed: f64| {
            let Cloud::JitteredLattice { spin, .. } = &mut scene.cloud;
            *spin = speed;
        };
        with_spin(&mut scene, 7.0);
        assert_eq!(initial_bodies(&scene), smooth, "nothing turns them");
        scene.material.friction_angle = 0.4;
        let rough = initial_bodies(&scene);
        let places = Bodies {
            spin: Vec::new(),
            inertia: Vec::new(),
            ..rough.clone()
        };
        assert_eq!(places, smooth);
        assert_eq!((rough.spin.len(), rough.inertia.len()), (500, 500));
        let share = match shape {
            Shape::Disc => 0.5,
            Shape::Sphere => 0.4,
        };
        for i in 0..rough.len() {
            let (radius, mass) = (rough.radius[i], rough.mass[i]);
            let inertia = share * mass * radius.powi(2);
            assert!((rough.inertia[i] / inertia - 1.0).abs() < 1.0e-15);
            assert!(rough.spin[i].abs() <= 7.0);
        }
        // Uniform in ±7: mean and mean square within four standard errors.
        let mean: f64 = rough.spin.iter().sum::<f64>() / 500.0;
        assert!(mean.abs() < 4.0 * 7.0 / (3.0f64 * 500.0).sqrt(), "{mean}");
        let square = rough.spin.iter().map(|spin| spin * spin).sum::<f64>() / 500.0;
        let error = 49.0 * (4.0 / 45.0 / 500.0f64).sqrt();
        assert!((square - 49.0 / 3.0).abs() < 4.0 * error, "{square}");

        with_spin(&mut scene, 0.0);
        assert!(initial_bodies(&scene).spin.iter().all(|spin| *spin == 0.0));
        scene.contact.rotation = Rotation::Blocked;
        assert_eq!(initial_bodies(&scene), smooth, "they may not turn");
    }
}
