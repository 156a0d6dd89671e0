//! What the program writes it can read: generated scenes and options, run, read, written again, compared, exported.

use proptest::prelude::*;

use crate::support::*;

/// What is put over [`frictional_scene`], and how it is run.
fn cases() -> impl Strategy<Value = (Value, Vec<String>)> {
    let contact = prop_oneof![
        3 => Just("{}"),
        1 => Just(r#"{"rotation": "blocked"}"#),
        1 => Just(r#"{"viscosity": {"kind": "dashpot", "c_n": 300.0, "tension": "clipped"}}"#),
        1 => Just(r#"{"viscosity": {"kind": "restitution", "e_n": 0.5, "tension": "unclipped"}}"#),
    ];
    let friction = prop_oneof![Just(0.0), 0.1f64..0.8];
    let loading = prop_oneof![
        2 => Just("null".to_owned()),
        1 => (0.0f64..0.8).prop_map(|angle| format!(r#"{{"friction_angle": {angle:?}}}"#)),
    ];
    let step = prop_oneof![
        3 => (0.1f64..0.5).prop_map(|fraction| format!(r#"{{"kind": "fraction", "of_sqrt_m_over_k": {fraction:?}}}"#)),
        1 => (1.0e-6f64..2.0e-6).prop_map(|seconds| format!(r#"{{"kind": "absolute", "seconds": {seconds:?}}}"#)),
    ];
    let numbers = (20u32..50, 1u64..400, any::<bool>(), 0.0f64..0.5);
    let scene = (numbers, contact, friction, loading, step);
    let option = prop_oneof![
        2 => Just(String::new()),
        1 => Just("--until settled".to_owned()),
        2 => (0u64..3000).prop_map(|steps| format!("--steps {steps}")),
        2 => (0.3f64..=0.9).prop_map(|share| format!("--auto-step {share:?}")),
        2 => Just("--reduced-stiffness".to_owned()),
    ];
    (scene, option, any::<u32>()).prop_map(|(((count, every, holds, alpha), contact, friction, loading, step), option, seed)| {
        let parse = |text: &str| serde_json::from_str::<Value>(text).expect("JSON");
        let soft = option.contains("stiffness") || option.contains("auto");
        let step = if soft { r#"{"kind": "fraction", "of_sqrt_m_over_k": 0.3}"# } else { &step };
        let after = if holds { r#"{"stand_still": {"seconds": 1e-4}}"# } else { "\"measure_at_once\"" };
        let mut changes = json!({
            "particles": {"count": count}, "contact": parse(contact), "material": {"friction_angle": friction},
            "damping": {"alpha": alpha + 0.1}, "settle": {"kinetic_energy_fraction": 0.05, "max_steps": 60_000},
            "loading": {"speed": 2.0, "give_up_depth": 0.02, "after_force": parse(after)},
            "measurement": {"history_every": every},
        });
        changes["time_step"] = parse(step);
        if loading != "null" {
            changes["loading"]["material"] = parse(&loading);
        }
        let options = format!("--seed {seed} {option}");
        (changes, options.split_whitespace().map(str::to_owned).collect())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn what_a_run_writes_every_verb_can_read((changes, options) in cases()) {
        let mut changes = changes;
        let step = changes["time_step"].take();
        changes.as_object_mut().expect("an object").remove("time_step");
        let mut scene = serde_json::to_value(staged_scene(&changes.to_string())).expect("a scene");
        scene["time_step"] = step;
        let place = &new_folder();
        fs::write(place.join("scene.json"), scene.to_string()).expect("writable");
        let run = |out: &str| {
            let mut words = vec!["run", "scene.json", "--engine", "native", "--quiet", "--out", out];
            words.extend(options.iter().map(String::as_str));
            say(place, &words[..])
        };
        let (code, said, errors) = run("a");
        // A bed that does not come to rest is a result. That a chosen step was too large for the run's own bed, which is another than the
        // probe's, is said.
        let beyond = said.contains("of the largest stable step of this bed");
        let ended = if beyond { code == 1 } else { matches!(code, 0 | 3) };
        prop_assert!(ended, "{options:?} {scene}: {said}{errors}");
        let read = read_run(place.join("a"));
        let (record, initial) = (&read.record, read.initial.clone());
        if record.softened.is_none() {
            let made = native_run(&read.scene, sound(), record.protocol);
            prop_assert_eq!((initial, &read.settled, &read.last), (made.initial, &made.settled, &made.last));
            prop_assert_eq!((&read.history, &read.trace), (&made.history, &made.trace));
        }
        read.write(&place.join("b")).expect("a new folder");
        prop_assert_eq!(&read_run(place.join("b")), &read);
        prop_assert_eq!(run("c").0, code);
        for other in ["b", "c"] {
            ends(place, 0, &["compare", "a", other, "--expect-bits"]);
        }
        ends(place, 0, "report vtk a --out vtk");
        ends(place, 0, "report archive a --out kept.tar.gz");
        prop_assert_eq!(bash(place, "tar xzf kept.tar.gz", &[]).0, 0);
        prop_assert_eq!(&read_run(place.join("kept")), &read);
    }
}

/// Before, the run was made, and its folder could not be read.
#[test]
fn a_history_of_more_than_a_million_moments_is_refused_before_the_run() {
    let mut scene = frictional_scene();
    scene.measurement.history_every = 1;
    let folder = &folder_with(&scene);
    for options in [
        "until settled",
        "steps 2000000",
        "auto-step",
        "reduced-stiffness",
        "quiet",
    ] {
        let command = format!("run scene.json --engine native --out out --{options}");
        let (_, errors) = ends(folder, 2, &command);
        has(&errors, ["moments of history"]);
        assert_eq!(errors.lines().count(), 1, "{errors}");
    }
    assert_eq!(there(folder).len(), 1);
    let short = "run scene.json --engine native --out out --steps 1000";
    tells(folder, 0, short, ["1000 steps"]);
    read_run(folder.join("out"));
}

/// Before, the folder had a scene that no program read.
#[test]
fn a_chosen_step_that_is_against_a_rule_of_the_scene_is_refused() {
    let mut scene = frictional_scene();
    scene.settle.kinetic_energy_fraction = 0.05;
    let radius = 0.5 * scene.particles.mean_diameter;
    // As far in a step as is allowed, with a step that is far too small.
    let of_sqrt_m_over_k = 0.05;
    scene.time_step = grains::scene::TimeStep::Fraction { of_sqrt_m_over_k };
    scene.loading.speed = 0.0099 * radius / scene.time_step_seconds();
    let folder = &folder_with(&scene);
    let command = "run scene.json --engine native --out out --auto-step 0.9";
    tells(folder, 2, command, ["/loading/speed", "mean radii a step"]);
    // The probe is kept, and no run is begun.
    assert!(there(folder).iter().all(|name| !name.contains("out")));
}
