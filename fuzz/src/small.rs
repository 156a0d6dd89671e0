//! The small things that inputs are read against.

use crossgrain::study::campaign::Campaign;
use crossgrain::study::plan::Plan;
use crossgrain::study::realization::Runner;
use grains::generate::initial_bodies;
use grains::model::Model;
use grains::scene::{Cloud, Scene, paper_scene};
use grains::task::Case;

/// Four grains of the paper in a box of their own.
pub fn scene() -> Scene {
    let mut scene = paper_scene(1, 4);
    let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
    *columns = 2;
    scene.container.width = 0.03;
    scene.loading.half_width = 0.01;
    scene.measurement.control_volume_side = 0.01;
    scene.measurement.local_radius = 0.01;
    scene.measurement.history_every = 500;
    scene.control_points.truncate(1);
    scene.control_points[0].offset = 0.0;
    scene.control_points[0].depth = 0.005;
    for reason in scene.choices.values_mut() {
        *reason = "chosen".to_owned();
    }
    scene
}

/// Three members of it.
pub fn plan() -> Plan<Campaign> {
    let campaign = Campaign::new(&scene(), Runner::Native, Vec::new(), 3, 7);
    Plan::new(campaign, None).expect("a plan")
}

/// Its grains for ten steps, without rules.
pub fn case() -> Case {
    let scene = scene();
    Case {
        name: "four".to_owned(),
        model: Model::of(&scene),
        bodies: initial_bodies(&scene),
        punch: None,
        moments: vec![0, 10],
    }
}
