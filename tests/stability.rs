//! Stability: predicted limits against closed forms and dense eigenvalues, found limits against predicted ones, and
//! every way to fail noticed.

mod external;

use crossgrain::checks::{Outcome, Tally, record::parse};
use crossgrain::files::read_text;
use crossgrain::limits::stability::failures::{MODES, small_bed};
use crossgrain::limits::stability::scenes::{MapScene, crystal, small};
use crossgrain::limits::stability::spheres;
use crossgrain::limits::stability::trials::{Disturbed, Found};
use crossgrain::limits::stability::{Map, Row, Stability, spectrum::Network, time_step};
use crossgrain::study::realization::bed_of;
use grains::native::{linear, run_case};
use grains::scene::{Damping, Rolling, TimeStep};
use grains::task::Case;
use grains::vector::{plus, times};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::support::*;

/// dt²K + 2dt C over the masses as a full matrix, column by column.
fn dense(network: &Network, stiffness: f64, damping: f64) -> DMatrix<f64> {
    let size = network.freedoms();
    let mut matrix = DMatrix::zeros(size, size);
    for at in 0..size {
        let mut unit = DVector::zeros(size);
        unit[at] = 1.0;
        matrix.set_column(at, &network.apply(stiffness, damping, &unit));
    }
    matrix
}

fn scenes() -> Vec<(MapScene, Network)> {
    let mut scenes = small();
    scenes.extend(spheres::small(4));
    scenes.push(crystal(6).expect("a crystal at rest"));
    let network = |scene: &MapScene| Network::of(&scene.case).expect("a network");
    let networks: Vec<Network> = scenes.iter().map(network).collect();
    scenes.into_iter().zip(networks).collect()
}

fn apart(found: Option<Found>, predicted: f64) -> f64 {
    found.map_or(f64::NAN, |found| (found.limit() / predicted - 1.0).abs())
}

/// At the limit the largest eigenvalue of dt²K + 2dt C over the masses is 4/(1+α).
#[test]
fn lanczos_finds_the_largest_eigenvalue_of_the_full_matrix_and_its_limit() {
    for (MapScene { name, .. }, network) in scenes() {
        for alpha in [None, Some(0.0), Some(0.2)] {
            let dt = alpha.map(|alpha| network.limit(alpha).dt);
            let (stiffness, damping) = dt.map_or((1.0, 0.0), |dt| (dt * dt, 2.0 * dt));
            let full = dense(&network, stiffness, damping);
            let off = (&full - full.transpose()).amax();
            assert!(off <= 1.0e-12 * full.amax(), "{name}");
            let largest = SymmetricEigen::new(full).eigenvalues.max();
            let ratio = network.top(stiffness, damping).value / largest;
            assert!((ratio - 1.0).abs() < 1.0e-6, "{name}: {ratio}");
            let off = alpha.map_or(0.0, |alpha| largest * (1.0 + alpha) - 4.0);
            assert!(off.abs() < 1.0e-4, "{name}: {off}");
        }
    }
}

#[test]
fn predicted_limits_are_those_of_the_closed_forms() {
    for scene in small().into_iter().chain(spheres::small(7)) {
        let closed = scene.closed.as_ref().expect("a closed form");
        let network = Network::of(&scene.case).expect("a network");
        let off = network.limit(0.0).dt / closed.dt - 1.0;
        assert!(off.abs() < closed.tolerance, "{}: {off}", scene.name);
    }
}

/// The stiffness is the derivative of the engine's forces: K by differences of the loads that it sums.
#[test]
fn the_network_is_the_derivative_of_the_forces() {
    use grains::native::loads;
    let scene = crystal(4).expect("a crystal at rest");
    let network = Network::of(&scene.case).expect("a network");
    let full = dense(&network, 1.0, 0.0);
    let mass = &scene.case.bodies.mass;
    let step = 1.0e-10;
    for grain in 0..mass.len() {
        let moved = |by: f64| {
            let mut case = scene.case.clone();
            case.bodies.x[grain] += by;
            loads(&case).expect("loads").remove(0)
        };
        let (ahead, behind) = (moved(step), moved(-step));
        for other in 0..mass.len() {
            for axis in 0..2 {
                let slope = -(ahead[other][axis] - behind[other][axis]) / (2.0 * step);
                let weighted = slope / (mass[grain] * mass[other]).sqrt();
                let here = full[(3 * other + axis, 3 * grain)];
                near(weighted, here, 1.0e-4 * full.amax());
            }
        }
    }
}

/// Unequal spheres on a wall, nowhere near equilibrium: the network's K is what their forces change by.
#[test]
fn the_network_of_spheres_is_the_derivative_of_their_forces() {
    let case = spheres::cluster();
    let full = dense(&Network::of(&case).expect("a network"), 1.0, 0.0);
    let forces = |case: &Case| {
        let moments = run_case(case, None).expect("a start");
        let bed = bed_of(&moments[0]);
        let mut sums = vec![[0.0; 3]; bed.bodies.len()];
        for (contact, force) in bed.forces() {
            for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
                if let Some(sum) = sums.get_mut(id as usize) {
                    *sum = plus(*sum, times(sign, force));
                }
            }
        }
        sums
    };
    let mass = &case.bodies.mass;
    let step = 1.0e-9;
    for (grain, axis) in (0..mass.len()).flat_map(|grain| (0..3).map(move |axis| (grain, axis))) {
        let moved = |by: f64| {
            let mut case = case.clone();
            let bodies = &mut case.bodies;
            [&mut bodies.x, &mut bodies.y, &mut bodies.z][axis][grain] += by;
            forces(&case)
        };
        let (ahead, behind) = (moved(step), moved(-step));
        for (other, mass_of_other) in mass.iter().enumerate() {
            for along in 0..3 {
                let slope = (behind[other][along] - ahead[other][along]) / (2.0 * step);
                let weighted = slope / (mass[grain] * mass_of_other).sqrt();
                let here = full[(6 * other + along, 6 * grain + axis)];
                near(weighted, here, 1.0e-5 * full.amax());
            }
        }
    }
}

/// Two free spheres: along the normal 2k_n/m, sticking 7k_s/m, rolling and twisting against each other 2k/I.
#[test]
fn two_spheres_have_their_closed_forms() {
    let limit = |case: &Case| Network::of(case).expect("a network").limit(0.0).dt;
    let pair = |friction: f64, rolling: [f64; 2]| {
        let mut case = spheres::pair(friction);
        let [bending_stiffness, twisting_stiffness] = rolling;
        case.model.law.contact.rolling = Some(Rolling {
            bending_stiffness: Some(bending_stiffness),
            twisting_stiffness,
            limit: None,
        });
        case
    };
    let (smooth, rough) = (pair(0.0, [0.0; 2]), pair(0.5, [0.0; 2]));
    let contact = linear(&rough).expect("a contact")[0];
    let (mass, inertia) = (rough.bodies.mass[0], rough.bodies.inertia[0]);
    // Hertz's force is two thirds of its slope times the overlap, and Mindlin's spring is 2(1 − ν)/(2 − ν) of it.
    near(
        contact.force / (contact.k_n * contact.overlap),
        2.0 / 3.0,
        1.0e-12,
    );
    near(contact.k_s / contact.k_n, 1.4 / 1.7, 1.0e-12);
    let stiff = 10.0 * contact.k_s * rough.bodies.radius[0].powi(2);
    for (case, expected) in [
        (smooth, 2.0 * (mass / (2.0 * contact.k_n)).sqrt()),
        (rough, 2.0 * (mass / (7.0 * contact.k_s)).sqrt()),
        (
            pair(0.5, [stiff, 0.0]),
            2.0 * (inertia / (2.0 * stiff)).sqrt(),
        ),
        (
            pair(0.5, [0.0, stiff]),
            2.0 * (inertia / (2.0 * stiff)).sqrt(),
        ),
    ] {
        near(limit(&case) / expected, 1.0, 1.0e-3);
    }
}

/// A bed of few soft spheres, with friction and moments: what is found is what was predicted, and a limit without the rotations' springs
/// would not be.
#[test]
fn a_bed_of_spheres_is_stable_up_to_its_predicted_step() {
    let made = &mut BTreeMap::new();
    let mut limits = Vec::new();
    for name in ["smooth-bed-1e6", "rough-bed-1e6", "rolling-bed-1e6"] {
        let scene = spheres::named(name, 40, made)
            .expect("a bed at rest")
            .expect("a name");
        let predicted = Network::of(&scene.case).expect("a network").limit(0.0).dt;
        let random = Disturbed::at_random(&scene.case, scene.axes).expect("a disturbance");
        let off = apart(random.undamped().expect("trials"), predicted);
        assert!(off < 0.01, "{name}: {off}");
        limits.push(predicted);
    }
    assert!(
        limits[1] < 0.95 * limits[0] && limits[2] < 0.95 * limits[1],
        "{limits:?}"
    );
}

#[test]
fn found_limits_are_the_predicted_ones() {
    for (scene, network) in scenes() {
        let random = Disturbed::at_random(&scene.case, scene.axes).expect("a disturbance");
        let found = random.undamped().expect("trials");
        let off = apart(found, network.limit(0.0).dt);
        assert!(off < 0.005, "{}: {off}", scene.name);
        let mode = Disturbed::in_mode(&scene.case, &network.fastest_mode(0.2)).expect("a mode");
        let undamped = found.expect("a limit");
        let damped = mode.damped(0.2, &undamped).expect("trials");
        let off = apart(damped, network.limit(0.2).dt);
        assert!(off < 0.01, "{}: {off}", scene.name);
    }
}

#[test]
fn every_failure_mode_is_noticed() {
    let said = [
        ("step-beyond-limit", "native engine stopped in step"),
        ("step-just-beyond-limit", "settle"),
        ("overlap-beyond-radius", "beyond the radius"),
        ("tunnelling", "has left the box"),
        ("punch-too-fast", "/loading/speed"),
        ("fast-punch", "reached"),
        ("stiffness-contrast", "native engine stopped in step"),
        ("zero-damping", "max steps"),
        ("never-at-rest", "max steps"),
        ("load-too-large", "target load not reached"),
    ];
    assert_eq!(MODES.map(|mode| mode.name), said.map(|(name, _)| name));
    for (mode, (_, says)) in MODES.iter().zip(said) {
        let failure = mode.in_native().expect("it is tried");
        assert_eq!(failure.outcome, Outcome::Pass, "{failure:?}");
        assert!(failure.says.contains(says), "{}", failure.says);
    }
}

#[test]
fn the_automatic_step_is_the_share_of_a_limit_that_trials_confirm() {
    let mut scene = small_bed();
    let of_sqrt_m_over_k = 5.0;
    scene.time_step = TimeStep::Fraction { of_sqrt_m_over_k };
    let choice = time_step::choose(&scene, 0.8).expect("a step");
    assert_eq!(choice.time_step, 0.8 * choice.limit);
    assert!(choice.looks > 10 && choice.probed_at < choice.time_step);
    let without = choice.limit_without_damping / choice.limit;
    assert!((without - 1.2f64.sqrt()).abs() < 1.0e-6, "{without}");
    let trial = choice.trial.expect("the bed comes to rest");
    let off = (trial.stable * trial.unstable).sqrt() / trial.predicted - 1.0;
    assert!(off.abs() < 0.03, "{off}");
    // The step it was given in the file has no part in it.
    scene.time_step = TimeStep::Absolute { seconds: 1.0e-6 };
    let again = time_step::choose(&scene, 0.8).expect("a step");
    assert_eq!(again.probed_at, choice.probed_at);
    let other = again.limit / choice.limit - 1.0;
    assert!(other.abs() < 0.3, "{other}");
    let chosen = time_step::with_step(&scene, &choice);
    assert_eq!(chosen.time_step_seconds(), choice.time_step);
    scene.damping = Damping::Cundall { alpha: 0.0 };
    assert_eq!(chosen.damping.alpha(), 0.2);
}

#[test]
fn a_run_folder_keeps_the_evidence_for_its_step() {
    use crossgrain::run::folder::record::RECORD_VERSION;
    let scene = small_bed();
    let choice = time_step::choose(&scene, 0.5).expect("a step");
    let folder = &folder_with(&scene);
    let run = "run scene.json --engine native --auto-step 0.5 --steps 100 --out run";
    ends(folder, 0, run);
    let record = read_run(folder.join("run")).record;
    assert_eq!(record.version, RECORD_VERSION);
    assert_eq!(record.time_step, choice.time_step);
    assert_eq!(record.step_choice, Some(choice));
    // The probe is kept, and not made again.
    let cache = folder.join(".cache/crossgrain");
    let kept = cache.join(there(&cache).pop_first().expect("a probe"));
    let mut probe = json_of(&kept);
    probe["looks"] = json!(12345);
    fs::write(&kept, probe.to_string()).expect("written");
    ends(folder, 0, &run.replace("--out run", "--out again"));
    let again = read_run(folder.join("again")).record.step_choice;
    assert_eq!(again.expect("a choice").looks, 12345);
    // What cannot be believed is not.
    fs::write(&kept, "{}").expect("written");
    ends(folder, 0, &run.replace("--out run", "--out anew"));
    let anew = read_run(folder.join("anew")).record.step_choice;
    assert_eq!(anew, Some(time_step::choose(&scene, 0.5).expect("a step")));
}

/// A few grains with friction, and this beside them.
fn rough(beside: &str) -> String {
    format!(
        r#"{{"particles": {{"count": 100, "mean_diameter": 0.005}}, "box": {{"width": 0.15}}, "material": {{"friction_angle": 0.4}}{beside}}}"#
    )
}

#[test]
fn a_scene_with_friction_gets_a_step_that_its_bed_bears_and_a_longer_one_is_said_to_be() {
    let folder = &new_folder();
    let run = "run scene.json --engine native --quiet --out run";
    fs::write(folder.join("scene.json"), rough("")).expect("written");
    let (said, _) = ends(folder, 0, run);
    assert!(!said.contains("do not rely on it"), "{said}");
    let share = time_step::largest_share(&read_run(folder.join("run"))).expect("a share");
    assert!((0.3..0.95).contains(&share.expect("contacts")), "{share:?}");
    let words = "The bed settled after";
    has(
        &said,
        [
            words,
            "Its mean surface is 0.01",
            "The punch had its force after",
        ],
    );
    assert!(!said.contains("impact"), "{said}");
    let step = r#", "time_step": {"kind": "fraction", "of_sqrt_m_over_k": 0.6}"#;
    fs::write(folder.join("scene.json"), rough(step)).expect("written");
    let (said, _) = ends(folder, 1, run);
    has(
        &said,
        ["of the largest stable step of this bed: do not rely on it"],
    );
    let (said, _) = ends(folder, 1, "report run run");
    has(&said, ["NOT TO BE RELIED ON", "do not rely on it"]);
}

#[test]
fn a_run_says_what_came_of_it_and_has_a_page() {
    let folder = &new_folder();
    fs::write(folder.join("scene.json"), rough("")).expect("written");
    ends(
        folder,
        0,
        "run scene.json --engine native --quiet --out run",
    );
    let (said, _) = ends(folder, 0, "report run run --out page");
    has(&said, ["The bed settled after", "N at a depth of"]);
    let page = text_of(folder.join("page/report.html"));
    has(
        &page,
        [
            "The bed settled after",
            "The bed at the end",
            "The punch&#39;s force against its depth",
            "settled height mean surface",
        ],
    );
    for name in ["packing-1", "packing-2", "force", "energy"] {
        assert!(
            folder.join(format!("page/figures/{name}.svg")).exists(),
            "{name}"
        );
    }
    let fast = r#", "loading": {"speed": 10}"#;
    fs::write(folder.join("scene.json"), rough(fast)).expect("written");
    let run = "run scene.json --engine native --quiet --out fast";
    let (said, _) = ends(folder, 0, run);
    has(&said, ["That is an impact: a wave takes about"]);
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn yade_proposes_by_its_formulas() {
    use crossgrain::engine::yade::{Options, propose};
    use crossgrain::limits::stability::time_step::by_formula;
    let work = &new_folder();
    let mut all: Vec<MapScene> = scenes().into_iter().map(|(scene, _)| scene).collect();
    // One in which twisting is what is stiffest.
    let rolling = all.iter().find(|scene| scene.name == "rolling-sphere");
    let mut twisting = rolling.expect("a name").clone();
    let moments = &mut twisting.case.model.law.contact.rolling;
    moments.as_mut().expect("moments").twisting_stiffness *= 10.0;
    all.push(twisting);
    let (space, plane): (Vec<_>, Vec<_>) = all
        .into_iter()
        .partition(|scene| scene.case.bodies.in_space());
    // A job is of one kind.
    let asked = [("plane", &plane), ("space", &space)].map(|(name, scenes)| {
        let cases: Vec<_> = scenes.iter().map(|scene| &scene.case).collect();
        let work = work.join(name);
        fs::create_dir(&work).expect("a folder");
        let (proposals, _) = propose(&cases, &Options::default(), &work).expect("YADE answers");
        scenes.iter().zip(proposals)
    });
    for (scene, of_yade) in asked.into_iter().flatten() {
        let ours = by_formula(&scene.case).expect("the formulas");
        for (ours, yade) in [
            (ours.p_wave, of_yade.p_wave),
            (ours.global_stiffness, of_yade.global_stiffness),
            (ours.with_dashpots, of_yade.with_dashpots),
        ] {
            let ratio = ours / yade;
            assert!((ratio - 1.0).abs() < 1.0e-6, "{}: {ratio}", scene.name);
        }
    }
}

#[test]
fn the_recorded_map_passes_every_check() {
    let (_, map) = judged_again::<Stability, Map>("reference_data/stability-1");
    let path = root("reference_data/stability-1/report.json.gz");
    let text = read_text(&path, 1 << 24).expect("is there");
    let checks = map.checks();
    let ids: BTreeSet<&str> = checks.iter().map(|check| check.id.as_str()).collect();
    assert_eq!(ids.len(), checks.len());
    let tally = Tally::of(&checks);
    // 15 scenes with four limits each, twelve closed forms, ten failure modes.
    assert_eq!((tally.passed, checks.len()), (82, 82), "{tally:?}");
    // The machine's own check stands first.
    let read = parse("recorded", &text).expect("a record");
    assert_eq!(read.checks[1..], checks);
    assert_eq!(map.verdict(), Outcome::Pass);
    // A number is what decides.
    let numbers = checks.iter().filter(|check| check.value.is_some());
    assert_eq!(numbers.clone().count(), 4 * map.rows.len() + 12);
    for check in numbers {
        let inside = check.value > check.lower && check.value < check.upper;
        assert!(inside, "{check:?}");
    }
    assert!(ids.iter().all(|id| crossgrain::explain::of(id).is_some()));
    for engine in ["native", "YADE", "yade"] {
        assert!(ids.iter().all(|id| !id.contains(engine)), "{engine}");
    }
    let mut worse = map.clone();
    let found = worse.rows[0].damped.external.as_mut().expect("a limit");
    found.stable *= 1.05;
    found.unstable *= 1.05;
    assert_eq!(Tally::of(&worse.checks()).failed, 1);
    assert_eq!(worse.verdict(), Outcome::Fail);
    let mut missing = map;
    missing.rows[0].damped.external = None;
    assert_eq!(missing.verdict(), Outcome::Skipped);
}

/// Of beds of one kind the limit falls with the fourth root of the overlap, as the root of Hertz's stiffness does.
#[test]
fn the_recorded_map_of_spheres_passes_every_check() {
    let (_, map) = judged_again::<Stability, Map>("reference_data/stability-spheres-1");
    let tally = Tally::of(&map.checks());
    // 21 scenes with four limits each, six closed forms.
    assert_eq!((tally.passed, map.checks().len()), (90, 90), "{tally:?}");
    for bearing in spheres::Bearing::ALL {
        let of_bed = |row: &Row| {
            let spheres = row
                .spheres
                .filter(|spheres| spheres.bearing == Some(bearing))?;
            Some(row.undamped.predicted / spheres.rayleigh * spheres.overlap.powf(0.25))
        };
        let beds: Vec<f64> = map.rows.iter().filter_map(of_bed).collect();
        let mean = beds.iter().sum::<f64>() / beds.len() as f64;
        assert_eq!(beds.len(), 5);
        for share in beds {
            near(share / mean, 1.0, 0.25);
        }
    }
}
