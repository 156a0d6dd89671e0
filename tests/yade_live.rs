//! Checks against the real YADE. Without the feature `yade` they are listed as ignored and not made;
//! with it a missing YADE is a failure. `ci/test` runs them all.

use crossgrain::checks::Outcome;
use crossgrain::compare::{Comparison, compare, first_difference::Locator};
use crossgrain::engine::{Engine, yade};
use crossgrain::suite::run::{self, Role};
use grains::scene::{
    AfterForce, Cloud, Damping, Shape, SlipVelocity, Tension, TorqueArms, Viscosity,
};
use verdict::judge::Verdict;

use crate::support::*;

fn yade_run(scene: &Scene, options: yade::Options, protocol: Protocol) -> RunFolder {
    run_of(scene, &options, protocol)
}

fn sorted() -> yade::Options {
    yade::Options::default()
}

fn all_pass(a: &RunFolder, b: &RunFolder) -> Comparison {
    let comparison = compare(a, b, None);
    for check in &comparison.checks {
        assert_eq!(check.outcome, Outcome::Pass, "{check:?}");
    }
    assert!(comparison.agrees());
    comparison
}

/// So many numbers of this table, of which none differs.
fn is_same(comparison: &Comparison, table: &str, numbers: usize) {
    let bits = comparison.tables.iter().find(|bits| bits.table == table);
    let bits = bits.expect("the table");
    assert_eq!((bits.differing, bits.numbers), (0, numbers), "{table}");
}

/// The same run in both engines, which agree in every check: the native one.
fn agreed(scene: &Scene, protocol: Protocol) -> (RunFolder, Comparison) {
    let native = native_run(scene, sound(), protocol);
    let yade = yade_run(scene, sorted(), protocol);
    let comparison = all_pass(&native, &yade);
    (native, comparison)
}

/// The same of a whole experiment, which is poured and loaded.
fn agreed_whole(scene: &Scene) -> (RunFolder, Comparison) {
    let (native, comparison) = agreed(scene, Protocol::Whole);
    assert_eq!(native.record.stages.len(), 2);
    (native, comparison)
}

/// What must hold: 20,000 steps of pouring the paper's 5,000 grains, 0 of 20,000 numbers differ.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn pouring_5000_grains_for_20000_steps_gives_the_same_bits() {
    let scene = paper_scene(1, 5000);
    let protocol = Protocol::Steps { steps: 20_000 };
    let (native, comparison) = agreed(&scene, protocol);
    is_same(&comparison, "last grains", 20_000);
    assert!(native.last.contacts.len() > 5000, "the bed has formed");
}

/// What must hold: 5,000 grains with friction 0.5 and free spins, 12,000 steps of pouring and then 3,000
/// under the punch, 0 stored numbers differ.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn rough_spinning_grains_poured_and_pressed_have_the_same_bits() {
    let mut scene = crossgrain::suite::cross_code::rough(5000);
    scene.settle.check_every = 6_000;
    scene.settle.max_steps = 12_000;
    // At the second look the bed has less energy than at the first, so pouring ends there.
    scene.settle.kinetic_energy_fraction = 0.99;
    scene.loading.pressure = 1.0e9;
    scene.loading.speed = 0.4;
    scene.loading.give_up_depth = 2999.5 * 0.4 * scene.time_step_seconds();
    scene.measurement.history_every = 500;
    let (native, comparison) = agreed_whole(&scene);
    let stages = &native.record.stages;
    let steps: Vec<u64> = stages.iter().map(|stage| stage.steps).collect();
    assert_eq!(steps, [12_000, 3_000]);
    is_same(&comparison, "settled grains", 25_000);
    is_same(&comparison, "last grains", 25_000);
    let sliding = |contact: &&Contact| contact.tangential_force != 0.0;
    let count = native.last.contacts.iter().filter(sliding).count();
    assert!(count > 5000, "{count} contacts bear a tangential force");
    assert!(native.last.bodies.spin.iter().all(|spin| *spin != 0.0));
}

/// Friction angles, stiffness ratios and clouds, each a whole experiment, and the laws that friction goes with: every bit of every
/// moment, shear forces included.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn friction_has_the_same_bits_for_several_angles_stiffnesses_and_clouds() {
    let (c_n, tension) = (900.0, Tension::Clipped);
    let dashpot = Viscosity::Dashpot { c_n, tension };
    let laws = [
        (0.2, 1.0, SlipVelocity::RatchetingCorrected, Viscosity::None),
        (0.5, 0.3, SlipVelocity::RatchetingCorrected, Viscosity::None),
        (0.9, 0.7, SlipVelocity::ContactPoint, Viscosity::None),
        (0.5, 0.5, SlipVelocity::ContactPoint, dashpot),
    ];
    for (realization, (angle, ratio, slip, viscosity)) in (1..).zip(laws) {
        let mut scene = frictional_scene();
        scene.realization = realization;
        scene.material.friction_angle = angle;
        scene.material.stiffness_ratio = ratio;
        scene.contact.slip_velocity = slip;
        if slip == SlipVelocity::ContactPoint {
            scene.contact.torque_arms = TorqueArms::ContactPoint;
        }
        scene.contact.viscosity = viscosity;
        scene.measurement.history_every = 50;
        let (native, _) = agreed_whole(&scene);
        let mut contacts = native.last.contacts.iter();
        assert!(contacts.any(|contact| contact.tangential_force != 0.0));
    }
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn constants_of_loading_have_the_same_bits_in_both_engines() {
    for (name, changes, _, has_yade) in stages() {
        let mut scene = staged_scene(changes);
        scene.measurement.history_every = 50;
        assert_eq!(yade::lacking(&scene).is_none(), has_yade, "{name}");
        if has_yade {
            agreed_whole(&scene);
        }
    }
}

/// Every case in both engines, with trajectories of 500 grains and rounding errors; the main job adds the detection limits.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn the_suite_passes_in_both_engines() {
    let options = run::Options {
        native: true,
        grains: 500,
        detection_limits: false,
        yade: Some(sorted()),
        command: "a test".to_owned(),
    };
    let found = run::verify(&options, &Display::new(true)).expect("a verification");
    for case in &found.cases {
        let not_there = case.inapplicable && case.role == Role::Reference;
        assert!(case.outcome == Outcome::Pass || not_there, "{case:?}");
    }
    assert_eq!(found.verdict(), Outcome::Pass);
    let in_yade = found
        .cases
        .iter()
        .filter(|case| case.role == Role::Reference);
    let passed = in_yade.filter(|case| case.outcome == Outcome::Pass).count();
    assert!(passed > 35, "{passed}");
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_whole_experiment_gives_the_same_bits_for_several_scenes() {
    let mut slow = small_scene();
    slow.realization = 5;
    slow.damping = Damping::Cundall { alpha: 0.7 };
    slow.loading.speed = 0.02;
    slow.loading.give_up_depth = 0.001;
    slow.loading.pressure = 1.0e9;
    let mut spheres = small_scene();
    spheres.particles.shape = Shape::Sphere;
    spheres.particles.dispersion = 0.3;
    let Cloud::JitteredLattice {
        columns,
        jitter,
        speed,
        ..
    } = &mut spheres.cloud;
    (*columns, *jitter, *speed) = (20, 1.0, 0.1);
    // A step of spheres is short: a hundredth of the energy and half a grain of depth are some ten thousands.
    spheres.settle.kinetic_energy_fraction = 0.01;
    (spheres.loading.pressure, spheres.loading.give_up_depth) = (1.0e9, 0.005);
    let mut standing = small_scene();
    standing.loading.after_force = AfterForce::StandStill { seconds: 0.02 };
    for scene in [small_scene(), slow, spheres, standing] {
        agreed_whole(&scene);
    }
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn runs_of_one_start_are_those_made_one_by_one() {
    let mut scenes = [tiny_scene(), frictional_scene()];
    for scene in &mut scenes {
        (scene.settle.check_every, scene.settle.max_steps) = (300, 600);
    }
    let tasks = scenes.each_ref().map(initial_bodies).map(Task::whole);
    let runs: Vec<(&Scene, &Task)> = scenes.iter().zip(&tasks).collect();
    let together = sorted().run_together(&runs).expect("one start");
    for ((scene, task), moments) in runs.iter().zip(&together) {
        let mut alone: Vec<Snapshot> = Vec::new();
        let run = sorted().run(scene, task, &new_folder(), &mut alone);
        run.expect("a run");
        assert!(alone.len() > 2);
        let bits = |moments: &[Snapshot]| -> Vec<String> {
            let all = moments.iter();
            all.map(|moment| format!("{} {}", moment.step, moment.bodies.digest()))
                .collect()
        };
        assert_eq!(bits(moments), bits(&alone));
    }
    // One that YADE cannot do.
    scenes[1].contact.viscosity = Viscosity::restitution(0.5, Tension::Unclipped);
    let runs: Vec<(&Scene, &Task)> = scenes.iter().zip(&tasks).collect();
    assert_eq!(sorted().run_together(&runs), None);
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_punch_driven_to_the_floor_gives_the_same_bits() {
    let mut scene = small_scene();
    scene.loading.pressure = 1.0e9;
    scene.loading.speed = 0.4;
    scene.loading.give_up_depth = 0.07;
    let (native, _) = agreed_whole(&scene);
    let deepest = native.history.last().and_then(|row| row.punch_depth);
    assert!(deepest.is_some_and(|depth| depth >= 0.07));
    let punch = scene.particles.count + 3;
    let mut contacts = native.last.contacts.iter();
    // Grains lean on its sides or corners.
    assert!(contacts.any(|contact| contact.id1 == punch && contact.normal[0] != 0.0));
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn sorted_bits_do_not_depend_on_verlet_distance() {
    let scene = small_scene();
    let near = yade_run(&scene, sorted(), Protocol::Whole);
    let mut options = sorted();
    options.verlet_distance = 1.0e-3;
    all_pass(&near, &yade_run(&scene, options, Protocol::Whole));
}

/// The comparison can fail against the real YADE too, and says where, by starting both engines again.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn faults_are_located_against_yade() {
    let scene = small_scene();
    let protocol = Protocol::Steps { steps: 4000 };
    let good = native_run(&scene, sound(), protocol);
    let yade = yade_run(&scene, sorted(), protocol);
    for fault in ["stiffness=1e-12", "wall=1e-12", "sums=reversed"] {
        let bad = native_run(&scene, faulty(fault), protocol);
        let among_natives = compare(&good, &bad, Some(&Locator::default()));
        let against_yade = compare(&bad, &yade, Some(&Locator::default()));
        assert!(!against_yade.agrees(), "{fault} was not found");
        let expected = among_natives.first_difference.expect("found among natives");
        let found = against_yade.first_difference.expect("found against YADE");
        assert_eq!(found.step, expected.step, "{fault}");
        assert_eq!(found.number.id, expected.number.id, "{fault}");
        assert_eq!(found.differing, expected.differing, "{fault}");
    }
}

/// Starting anew from a state in the middle of loading, as the search for a difference does, goes on
/// with the same bits.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_fault_under_the_punch_is_located_against_yade() {
    let scene = small_scene();
    let mut other = scene.clone();
    other.loading.speed *= 1.0 + 1e-9;
    let native = native_run(&other, sound(), Protocol::Whole);
    let yade = yade_run(&scene, sorted(), Protocol::Whole);
    let comparison = compare(&native, &yade, Some(&Locator::default()));
    let first = comparison.first_difference.expect("a first difference");
    assert_eq!(first.stage, Stage::Load);
}

/// YADE's ordinary loop: other bits, and equal to rounding; a fault of a part in 10⁹ is not.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn the_ordinary_loop_is_equal_to_rounding() {
    let scene = small_scene();
    let protocol = Protocol::Steps { steps: 6000 };
    let mut ordinary = sorted();
    ordinary.sorted = false;
    let yade = yade_run(&scene, ordinary, protocol);
    let native = native_run(&scene, sound(), protocol);
    let comparison = compare(&native, &yade, Some(&Locator::default()));
    assert!(!comparison.same_bits, "the loops do differ");
    let answer = comparison.answer();
    assert_eq!(comparison.verdict(), Verdict::EqualToRounding, "{answer}");
    let dense = native_run(&scene, faulty("density=1e-8"), protocol);
    let comparison = compare(&dense, &yade, Some(&Locator::default()));
    assert_eq!(comparison.verdict(), Verdict::Different);
}

/// The command of the pages: `engine check` names both loops of YADE.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn yade_holds_no_socket_and_does_not_outlive_the_program() {
    let folder = &folder_with(&endless_scene());
    let command = "run scene.json --engine yade --out out";
    let mut child = Running(started(folder, command));
    let program = child.0.id();
    let began = Instant::now();
    let mut yade = None;
    let mut looks = 0;
    while looks < 40 && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
        yade = yade.or_else(|| child_of(program));
        let Some(pid) = yade else { continue };
        // Looked at from its first moments on, long after its start-up of about a second.
        looks += 1;
        assert_eq!(sockets_of(pid), 0, "YADE opened a socket");
    }
    let pid = yade.expect("YADE was started");
    assert_eq!(looks, 40);
    assert!(Path::new(&format!("/proc/{pid}")).exists(), "it is at work");
    child.0.kill().expect("a running program");
    child.0.wait().expect("an ended program");
    within(30, "YADE ends, for which nobody waits", || !is_running(pid));
}

fn child_of(parent: u32) -> Option<u32> {
    let line = format!("PPid:\t{parent}\n");
    let is_child = |pid: &u32| {
        let status = fs::read_to_string(format!("/proc/{pid}/status"));
        status.is_ok_and(|status| status.contains(&line))
    };
    let names = there(Path::new("/proc"));
    names.iter().flat_map(|name| name.parse()).find(is_child)
}

fn sockets_of(pid: u32) -> usize {
    let files = fs::read_dir(format!("/proc/{pid}/fd")).expect("a child of ours, at work");
    let targets = files.filter_map(|file| fs::read_link(file.ok()?.path()).ok());
    let sockets = targets.filter(|target| target.to_string_lossy().starts_with("socket:"));
    sockets.count()
}
