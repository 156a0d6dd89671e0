//! Settings on many packings, taken apart: what made-up members must come to, and one small study.

use std::collections::BTreeMap;

use crossgrain::limits::stability::time_step::share_of_limit;
use crossgrain::study::Study;
use crossgrain::study::candidates::Plan;
use crossgrain::study::candidates::judge::Candidates;
use crossgrain::study::member::Member;
use crossgrain::study::realization::{Change, Ending, Setting, changed, law_key, unobserved};
use crossgrain::study::search::space::{AXES, OF_POURING, STEP, base, scene};
use evidence::distribution::Family;
use evidence::t_test::Finding;
use grains::generate::initial_bodies;
use grains::measure::stress::LAYERS;
use grains::native;
use grains::task::Task;

use crate::support::{ends, has};

const CLOUDS: u64 = 60;

/// Members of every setting: local means before the load and under it, in the theory's parts, and whether the force is reached.
fn members(plan: &Plan, law: impl Fn(&Setting, u64) -> Option<[f64; 2]>) -> Vec<Member> {
    let mut all = Vec::new();
    let theory = Candidates::of(plan, &[].into_iter().collect());
    for (setting, found) in plan.beds.settings().zip(&theory.settings) {
        for cloud in setting.realizations() {
            let shares = law(setting, cloud);
            let mut measured = BTreeMap::new();
            for point in &found.parts {
                let [before, added] = shares.unwrap_or([1.0; 2]);
                let [weight, load] = point.theory;
                let mut put = |moment: &str, value: f64| {
                    let key = format!("{moment}.stress.{}.local_zz", point.point);
                    measured.insert(key, value);
                };
                put("settled", before * weight);
                if shares.is_some() {
                    put("loaded", before * weight + added * load);
                }
            }
            for (place, layer) in LAYERS.into_iter().enumerate() {
                for (index, family) in Family::OF_STRESSES.into_iter().enumerate() {
                    // The deeper, the farther the exponential falls behind the last two.
                    let behind = match index {
                        0 => 0.01 * place as f64,
                        1 | 2 => 0.02,
                        _ => 0.0,
                    };
                    let noise = 0.001 * ((cloud * (index as u64 + 2)) % 7) as f64 - 0.003;
                    measured.insert(law_key(layer, family), noise - 1.0 - behind);
                }
            }
            all.push(Member {
                specification: setting.specification.digest(),
                realization: cloud,
                ending: match shares {
                    Some(_) => Ending::Reached,
                    None => Ending::TargetLoadNotReached,
                },
                pour_steps: 1,
                load_steps: 1,
                cost: None,
                loaded_state: None,
                measured,
            });
        }
    }
    all
}

/// With friction grains can turn, and the largest stable step is smaller; the default's 0.45 is beyond it.
#[test]
fn the_step_of_the_settings_is_stable_with_friction() {
    let mut at = vec![1.0; AXES.len()];
    at[2] = 0.5;
    at[OF_POURING - 1] = 0.0;
    for (step, wanted) in [(STEP, 0.6..1.0), (0.45, 1.0..1.5)] {
        let scene = changed(scene(&base(true), &at), &[Change::Step(step)]);
        let outcome = native::run(
            &unobserved(&scene),
            &Task::settle(initial_bodies(&scene)),
            &native::Options::default(),
            &mut (),
        );
        let bed = outcome.expect("it settles").last.bodies;
        let share = share_of_limit(&scene, &bed)
            .expect("a limit")
            .expect("a bed");
        assert!(wanted.contains(&share), "{step} {share}");
    }
}

/// With friction the load's part is 1.2 of the theory's whatever the speed below 0.04 m/s; without it every second punch loses
/// its force with each half of the speed.
#[test]
fn parts_and_limits_are_those_of_made_up_members() {
    let plan = Plan::new(true, CLOUDS, None, 0);
    assert_eq!(plan.check(), Ok(()));
    let noise = |cloud: u64| 0.02 * ((cloud % 7) as f64 - 3.0);
    let law = |setting: &Setting, cloud: u64| {
        let speed = setting.specification.scene.loading.speed;
        let with_friction = setting.specification.scene.loading.material.is_some();
        let added = match (with_friction, speed > 0.05) {
            (true, false) => 1.2,
            (true, true) => 0.9,
            (false, _) => 1.0,
        };
        let reached = with_friction || speed > 0.03 || cloud.is_multiple_of(2);
        reached.then(|| [0.9, added + noise(cloud + (1000.0 * speed) as u64)])
    };
    let members = members(&plan, law).into_iter().collect();
    let found = Candidates::of(&plan, &members);
    let printed = &found.settings[0].parts[0];
    let [before, added] = [printed.before, printed.added].map(|of| of.expect("sixty packings"));
    assert!(
        (before.estimate / printed.theory[0] - 0.9).abs() < 1.0e-9,
        "{before:?}"
    );
    assert!(
        (added.estimate / printed.theory[1] - 1.0).abs() < 0.02,
        "{added:?}"
    );
    let layers = &found.settings[0].layers;
    let level = |place: usize| layers[place].level().collect::<Vec<Family>>();
    assert_eq!(layers.len(), LAYERS.len());
    assert!(level(0).contains(&Family::Exponential), "{layers:?}");
    assert!(!level(3).contains(&Family::Exponential), "{layers:?}");
    assert!(level(3).contains(&Family::Weibull) && level(3).contains(&Family::GaussianTail));
    assert!(!level(0).contains(&Family::Gamma));
    let findings = found
        .halvings
        .iter()
        .map(|of| (of.name.as_str(), of.finding));
    let [without, with, blocked] = [
        "without friction",
        "with friction in loading",
        "with friction, grains do not turn",
    ];
    let expected = [
        (without, Finding::Equivalent),
        (without, Finding::Different),
        (with, Finding::Different),
        (with, Finding::Equivalent),
        (with, Finding::Equivalent),
        (blocked, Finding::Different),
        (blocked, Finding::Equivalent),
    ];
    assert_eq!(findings.collect::<Vec<_>>(), expected);
    assert_eq!(
        (found.halvings[1].reached, found.halvings[1].all),
        ([60, 30], 60)
    );
    let answer = found.document().answer;
    has(
        &answer,
        [
            "no quasi-static limit without friction",
            "30 of 60 punches get the force",
            "Quasi-static from \"bed at rest, with friction in loading, 0.04 m/s\" on",
        ],
    );
    // Half of the punches do not get the force, so this setting gives nothing, whatever the rest says.
    let slow = found
        .settings
        .iter()
        .find(|of| of.setting.id == "rest-0.02");
    let slow = slow.expect("it is planned");
    assert!(!slow.bears());
    assert_eq!(slow.gives_all(), Some(false));
}

#[test]
fn loads_of_another_bed_are_refused() {
    let mut plan = Plan::new(true, 3, None, 0);
    plan.beds.0[3][1]
        .specification
        .scene
        .settle
        .kinetic_energy_fraction *= 2.0;
    let why = plan.check().expect_err("another bed");
    has(&why, ["rest-0.04 does not load the beds of rest-0.08"]);
    let mut plan = Plan::new(true, 3, None, 0);
    plan.ladders[0].settings.push("faster".to_owned());
    has(
        &plan.check().expect_err("no such setting"),
        ["no setting faster"],
    );
}

#[test]
fn a_small_study_is_undecided_and_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    ends(
        folder,
        0,
        "study plan candidates --quick --clouds 3 --out best",
    );
    ends(folder, 3, "study run best --quiet");
    let page = std::fs::read_to_string(folder.join("best/report.html")).expect("a page");
    has(
        &page,
        ["Is there a quasi-static limit?", "Taken apart", "undecided"],
    );
}
