//! Settings on many packings, taken apart: what made-up members must come to, and one small study.

use crossgrain::limits::stability::time_step::share_of_limit;
use crossgrain::report;
use crossgrain::study::candidates::judge::{Candidates, Verdict};
use crossgrain::study::candidates::{PRINTED, Plan, reasons};
use crossgrain::study::change::{Change, What, changed};
use crossgrain::study::folder::StudyFolder;
use crossgrain::study::member::{Beds, Member, Members, of_one_bed};
use crossgrain::study::realization::{
    Ending, Engines, Setting, Specification, law_key, unobserved,
};
use crossgrain::study::search::space::{AXES, OF_POURING, STEP, base, scene};
use crossgrain::study::{Study, create, search::matching::keep};
use evidence::distribution::Family;
use evidence::t_test::Finding;
use grains::measure::stress::LAYERS;
use grains::scene::Material;

use crate::support::*;
use crate::tradeoff::run;

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
                let key = |moment: &str| format!("{moment}.stress.{}.local_zz", point.point);
                measured.insert(key("settled"), before * weight);
                if shares.is_some() {
                    measured.insert(key("loaded"), before * weight + added * load);
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
            let ending = match shares {
                Some(_) => Ending::Reached,
                None => Ending::TargetLoadNotReached,
            };
            all.push(Member {
                measured,
                ..Member::without(&setting.specification, cloud, ending)
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
        let scene = changed(scene(&base(true), &at), &[(What::Step, step)]);
        let task = Task::settle(initial_bodies(&scene));
        let bed = native_outcome(&unobserved(&scene), &task, None)
            .0
            .last
            .bodies;
        let share = share_of_limit(&scene, &bed).expect("a limit");
        let share = share.expect("a bed");
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
    let [before, added] =
        [printed.before, printed.added].map(|interval| interval.expect("sixty packings"));
    let ratio = before.estimate / printed.theory[0];
    assert!((ratio - 0.9).abs() < 1.0e-9, "{before:?}");
    let ratio = added.estimate / printed.theory[1];
    assert!((ratio - 1.0).abs() < 0.02, "{added:?}");
    let layers = &found.settings[0].layers;
    let level = |place: usize| layers[place].level().collect::<Vec<Family>>();
    assert_eq!(layers.len(), LAYERS.len());
    assert!(level(0).contains(&Family::Exponential), "{layers:?}");
    assert!(!level(3).contains(&Family::Exponential), "{layers:?}");
    assert!(level(3).contains(&Family::Weibull) && level(3).contains(&Family::GaussianTail));
    assert!(!level(0).contains(&Family::Gamma));
    let findings = found.halvings.iter();
    let findings = findings.map(|halving| (halving.name.as_str(), halving.finding));
    let (same, other) = (Finding::Equivalent, Finding::Different);
    let names = [
        "without friction",
        "with friction in loading",
        "with friction, grains do not turn",
    ];
    let expected = [same, other, other, same, same, other, same];
    let expected_names = [0, 0, 1, 1, 1, 2, 2].map(|name| names[name]);
    assert!(findings.eq(expected_names.into_iter().zip(expected)));
    let halving = &found.halvings[1];
    assert_eq!((halving.reached, halving.all), ([60, 30], 60));
    let answer = found.document().answer;
    has(&answer, ["no quasi-static limit without friction"]);
    has(&answer, ["30 of 60 punches get the force"]);
    let words = "Quasi-static from \"bed at rest, with friction in loading, 0.04 m/s\" on";
    has(&answer, [words]);
    // Half of the punches do not get the force, so this setting gives nothing, whatever the rest says.
    let mut slow = found.settings.iter();
    let slow = slow.find(|found| found.setting.id == "rest-0.02");
    let slow = slow.expect("it is planned");
    assert!(!slow.bears());
    assert_eq!(slow.gives_all(), Some(false));
}

#[test]
fn loads_of_another_bed_are_refused() {
    let mut plan = Plan::new(true, 3, None, 0);
    let settle = &mut plan.beds.0[3][1].specification.scene.settle;
    settle.kinetic_energy_fraction *= 2.0;
    let why = plan.check().expect_err("another bed");
    has(&why, ["rest-0.04 does not load the beds of rest-0.08"]);
    let mut plan = Plan::new(true, 3, None, 0);
    plan.ladders[0].settings.push("faster".to_owned());
    let why = plan.check().expect_err("no such setting");
    has(&why, ["no setting faster"]);
}

#[test]
fn a_small_study_is_undecided_and_says_so() {
    let folder = &new_folder();
    let command = "study plan candidates --quick --clouds 3 --out best";
    ends(folder, 0, command);
    ends(folder, 3, "study run best --quiet");
    let page = text_of(folder.join("best/report.html"));
    has(&page, ["quasi-static limit?", "Taken apart", "undecided"]);
}

/// The whole run in one go.
fn whole(specification: &Specification) -> Member {
    let engines = Engines::default();
    let run = Member::run(specification, 1, &engines, Path::new(""), keep).expect("it runs");
    Member { cost: None, ..run }
}

#[test]
fn a_bed_poured_once_and_loaded_is_the_whole_run_bit_for_bit() {
    for mut scene in [small_scene(), frictional_scene()] {
        scene.loading.give_up_depth = 0.02;
        let scenes = [&[][..], &[(What::PunchSpeed, 0.3)], &[(What::Hold, 0.01)]];
        let [first, fast, held] = scenes.map(|changes| changed(scene.clone(), changes));
        // The bed is poured in the first scene, which may be one in which nothing turns.
        let mut rough = first.clone();
        let (friction_angle, material) = (0.5, rough.material.clone());
        rough.loading.material = Some(Material {
            friction_angle,
            ..material
        });
        let scenes = [first, fast, held, rough];
        let native = scenes.map(Specification::native);
        let settings = native.map(|specification| Setting::new("a", "a", "test", specification, 1));
        let loaded = of_one_bed(&settings, 1, keep).expect("they run");
        for (setting, loaded) in settings.iter().zip(loaded) {
            assert!(loaded.loaded_state.is_some());
            assert_eq!(loaded, whole(&setting.specification));
        }
    }
}

#[test]
fn friction_bears_the_punch_earlier() {
    let mut base = small_scene();
    base.loading.give_up_depth = 0.04;
    base.loading.pressure *= 0.25;
    let slow = changed(base, &[(What::PunchSpeed, 0.02)]);
    let without = whole(&Specification::native(slow.clone()));
    let with = whole(&Specification::native(changed(
        slow,
        &[(What::Friction, 0.5)],
    )));
    let endings = [&with, &without].map(|member| member.ending.clone());
    assert_eq!(endings, [Ending::Reached, Ending::Reached]);
    assert!(with.load_steps < without.load_steps);
}

/// That all settings of this plan are different scenes that a run takes; returns their axes.
pub fn are_sound(plan: &Plan, first: &str) -> BTreeSet<String> {
    assert_eq!(plan.check(), Ok(()));
    let (mut ids, mut digests) = (BTreeSet::new(), BTreeSet::new());
    for setting in plan.beds.settings() {
        let specification = &setting.specification;
        let text = serde_json::to_string(&specification.scene).expect("a scene");
        let read = parse_scene(&text);
        assert!(read.is_ok(), "{}: {read:?}", setting.id);
        assert!(ids.insert(&setting.id), "{}", setting.id);
        assert!(digests.insert(specification.digest()), "{}", setting.id);
    }
    let settings = || plan.beds.settings();
    assert_eq!(
        settings().next().map(|setting| setting.id.as_str()),
        Some(first)
    );
    settings().map(|setting| setting.axis.clone()).collect()
}

#[test]
fn choices_are_sound_scenes_around_the_printed_one() {
    for quick in [true, false] {
        let axes = are_sound(&Plan::of_choices(quick, 3, None, false), "printed");
        let readings = are_sound(&Plan::of_choices(quick, 3, None, true), "printed");
        assert!(
            readings.is_subset(&axes) && readings.len() > 2,
            "{readings:?}"
        );
        if !quick {
            let named = reasons().map(|reason| reason.0);
            let named: BTreeSet<&str> = named.chain([PRINTED]).collect();
            assert!(axes.iter().map(String::as_str).eq(named));
        }
    }
}

/// The small scene as it is, settled much too early, and loaded so slowly that the punch sinks.
fn three_settings(clouds: u64) -> Plan {
    let mut base = small_scene();
    base.loading.give_up_depth = 0.04;
    let setting = |id: &str, axis: &str, changes: &[Change]| {
        let scene = changed(base.clone(), changes);
        Setting::new(id, id, axis, Specification::native(scene), clouds)
    };
    let speed = "punch speed and damping";
    let sound = setting("as it is", PRINTED, &[]);
    let slow = setting("slow", speed, &[(What::PunchSpeed, 0.02)]);
    let early = setting("hardly settled", "settle rule", &[(What::Settled, 0.05)]);
    let beds = Beds(vec![vec![sound, slow], vec![early]]);
    Plan {
        beds,
        ladders: Vec::new(),
    }
}

fn rows(folder: &Path) -> Vec<Vec<Member>> {
    let rows = StudyFolder::<Plan>::open(folder).and_then(|study| study.rows());
    rows.expect("rows of a study")
}

#[test]
fn choices_are_held_against_the_printed_scene_on_the_same_clouds() {
    let place = &new_folder();
    let [three, eight] = ["three", "eight"].map(|name| place.join(name));
    create(&three, three_settings(3), None, None).expect("a new study");
    run::<Plan>(&three, &Engines::default()).expect("it runs");
    // More clouds are added to what is there: three of two beds.
    let plan = three_settings(8);
    let taken = create(&eight, plan.clone(), None, Some(&three)).expect("a new study");
    assert_eq!(taken, 6);
    assert_eq!(rows(&eight).len(), 6);
    run::<Plan>(&eight, &Engines::default()).expect("it runs");
    let rows = rows(&eight);
    assert_eq!(rows.len(), 16);

    let members: Members = rows.into_iter().flatten().collect();
    let record = Candidates::of(&plan, &members);
    let [sound, slow, early] = &record.settings[..] else {
        panic!("three settings");
    };
    let height = |setting: usize| record.settings[setting].figures[0].clone();
    assert_eq!(height(0).id, "height");
    assert!(height(0).change.is_none());
    let moved = height(2).change.expect("eight clouds").low;
    assert!(moved > 0.002, "{moved}");
    // Beds are the same where only the load differs.
    assert_eq!(height(0).value, height(1).value);
    assert_eq!((sound.endings.all(), early.endings.all()), (8, 8));
    // A small bed is not half a metre high.
    assert_eq!(height(0).verdict, Verdict::DoesNot);

    // Members whose punch missed the force are counted, and give no stress.
    let loaded = members.of(&slow.setting).into_iter();
    let missed = loaded.filter(|row| row.ending == Ending::TargetLoadNotReached);
    let measured = |row: &Member| row.measured.contains_key("loaded.stress.O.local_zz");
    let missed = missed.inspect(|row| assert!(!measured(row))).count();
    assert_eq!(slow.endings.target_load_not_reached, missed);
    let judged = slow.figures.iter().find(|figure| figure.id == "stress.O");
    let judged = judged.expect("a published figure");
    assert_eq!(judged.packings, 8 - missed);
    assert_eq!(judged.conditional, missed > 0);

    let document = record.document();
    let page = report::page(&document);
    has(&page.html, ["hardly settled", "One choice at a time"]);
    for name in ["means.svg", "changes.csv", "numbers.csv"] {
        assert!(page.files.iter().any(|(file, _)| file == name), "{name}");
    }
    assert!(!page.html.contains("quasi-static limit"));
    assert!(report::terminal(&document).contains(&document.answer));
}
