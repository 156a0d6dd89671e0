//! The initial cloud.

use crossgrain::generate::initial_bodies;
use crossgrain::scene::paper_scene;

/// Recorded once; the same on every machine.
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
