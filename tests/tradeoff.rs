//! Cost against error, on beds small enough for a test.

mod external;

use crossgrain::engine::exec::ExternalEngine;
use crossgrain::report;
use crossgrain::reproduce::record::Beside;
use crossgrain::study::change::{Change, What, changed};
use crossgrain::study::folder::{AnyStudy, Job, StudyFolder};
use crossgrain::study::member::{Member, Members};
use crossgrain::study::realization::{Engines, Runner, Specification};
use crossgrain::study::tradeoff::plan::{FAST, FIRST_CONFIRMATORY, Plan};
use crossgrain::study::tradeoff::{Tradeoff, judge};
use crossgrain::study::{Study, StudyError, create, plan::Program, shard::Shard};
use grains::native::pouring::{End, Phase, pour};

use crate::support::*;

/// Methods with one change each, on two clouds, as candidates on three more.
fn plan(methods: &[(&str, Change)], confirmatory: u64) -> Plan {
    let mut plan = Plan::new(small_scene(), 2, confirmatory);
    for (id, change) in methods {
        let scene = changed(small_scene(), &[*change]);
        plan.add(id, id, "test", Specification::native(scene), 1);
        plan.test_last();
    }
    plan
}

/// Runs what is missing of a study.
pub fn run<S: Study>(folder: &Path, engines: &Engines) -> Result<(), StudyError> {
    let (shard, threads) = (Shard::WHOLE, 2);
    let job = Job {
        shard,
        threads,
        engines,
    };
    StudyFolder::<S>::open(folder)?.run(&job, &Display::new(true))?;
    Ok(())
}

/// A new study, with an external engine if there is one, and how its run ends.
pub fn tried<S: Study>(
    plan: S,
    external: Option<ExternalEngine>,
) -> (Place, PathBuf, Result<(), StudyError>) {
    let place = new_folder();
    let folder = place.join("study");
    let program = external.as_ref();
    let program = program.map(|path| Program::of(path).expect("a file"));
    create(&folder, plan, program, None).expect("a new study");
    let engines = Engines {
        external,
        ..Engines::default()
    };
    let ended = run::<S>(&folder, &engines);
    (place, folder, ended)
}

/// The same in the native engine, whole.
pub fn made<S: Study>(plan: S) -> (Place, PathBuf) {
    let (place, folder, ended) = tried(plan, None);
    ended.expect("it runs");
    (place, folder)
}

/// What the rows of a folder say.
fn record(folder: &Path) -> Tradeoff {
    let folder = StudyFolder::<Plan>::open(folder).expect("a study");
    let members: Members = folder.rows().expect("rows").into_iter().collect();
    let external = folder
        .plan
        .program
        .as_ref()
        .map(|program| &program.described);
    Tradeoff::of(&folder.plan.study, &members, Vec::new(), external)
}

#[test]
fn one_phase_of_the_scenes_own_settings_is_the_scenes_own_pouring() {
    for scene in [small_scene(), frictional_scene()] {
        let initial = initial_bodies(&scene);
        let options = native::Options::default();
        let known = native::run(&scene, &Task::settle(initial.clone()), &options, &mut ());
        let known = known.expect("it settles");
        let phase = Phase {
            modulus: 1.0,
            alpha: scene.damping.alpha(),
            step: 0.45,
            end: End::Settled(scene.settle.kinetic_energy_fraction),
        };
        let poured = pour(&scene, &[phase], &options, initial).expect("it settles");
        let poured = poured.expect("there is a phase");
        assert!(poured.settled);
        assert_eq!(poured.steps, known.stages[0].steps);
        assert_eq!(poured.bed.bodies.digest(), known.last.bodies.digest());
    }
}

#[test]
fn friction_is_held_against_friction() {
    let mut plan = Plan::quick(2, 0);
    plan.methods
        .retain(|method| method.id.starts_with("friction"));
    let (_place, folder) = made(plan);
    let record = record(&folder);
    let mean_height = |id: &str| {
        let point = record.point(id).expect("it is planned");
        let height = point.screened.of("settled.height.mean_surface");
        height.expect("two pairs").paired.first_mean
    };
    let first = record.reference.screened.of("settled.height.mean_surface");
    let springs = first.expect("two pairs").paired.first_mean;
    // Friction leaves a looser bed; the first of a pair is the reference.
    let with_friction = mean_height("friction");
    assert!(with_friction > 1.01 * springs, "{with_friction} {springs}");
    assert_eq!(mean_height("friction-step-0.45"), with_friction);
    let null = &record.point("friction").expect("it is planned").screened;
    assert_eq!(null.clouds, 2);
    let mut off = null
        .differences
        .iter()
        .map(|difference| difference.paired.difference);
    assert!(off.any(|difference| difference.estimate != 0.0));
    // Their own reference is a ring of the chart, with its name.
    let page = report::page(&record.document());
    let name = &record.point("friction").expect("it is planned").method.name;
    has(&page.html, [&format!("{name}</text>")]);
}

#[test]
fn a_bed_that_is_stiffened_ends_at_the_full_stiffness_at_rest() {
    let scene = small_scene();
    let phase = |modulus, end| Phase {
        modulus,
        alpha: 0.2,
        step: 0.45,
        end,
    };
    let first = phase(0.1, End::Settled(1.0e-3));
    let second = phase(0.3, End::Seconds(0.004));
    let method = Specification {
        phases: vec![first, second, phase(1.0, End::Settled(1.0e-4))],
        ..Specification::native(scene.clone())
    };
    let options = native::Options::default();
    let initial = initial_bodies(&scene);
    let poured = pour(&scene, &method.phases, &options, initial).expect("it settles");
    let poured = poured.expect("there are phases");
    // The overlaps bear the weight at the full stiffness: the floor's contacts together.
    let ids = grains::tables::BodyIds::of_box(scene.particles.count);
    let on_floor = poured
        .bed
        .contacts
        .iter()
        .filter(|contact| !ids.is_grain(contact.id1) && contact.normal[1] > 0.9);
    let borne: f64 = on_floor.map(|contact| contact.normal_force).sum();
    let weight: f64 = scene.gravity * poured.bed.bodies.mass.iter().sum::<f64>();
    assert!((borne / weight - 1.0).abs() < 0.05, "{borne} {weight}");
    let engines = Engines::default();
    let member = Member::run(&method, 1, &engines, Path::new(""), |_| true).expect("it runs");
    assert!(member.measured.contains_key("settled.height.mean_surface"));
    assert!(member.pour_steps > 0 && member.load_steps > 0);
    assert!(member.cost.is_some_and(|cost| cost.cpu_seconds > 0.0));
}

#[test]
fn a_study_is_taken_up_where_it_was_and_finds_the_large_bias() {
    let methods = [
        ("same-physics", (What::Step, 0.4)),
        ("hardly-settled", (What::Settled, 0.05)),
    ];
    let plan = plan(&methods, 3);
    let count = plan.count();
    assert_eq!(count, 15);
    let (_place, folder) = made(plan);
    let rows = folder.join("records/shard-1-of-1.jsonl");
    let text = text_of(&rows);
    assert_eq!(text.lines().count() as u64, count);
    // Killed in the middle of the last line: that row alone is made again, and nothing that stands is changed.
    fs::write(&rows, &text[..text.len() - 20]).expect("cut");
    let missing: u64 = record(&folder)
        .points
        .iter()
        .map(|point| point.missing)
        .sum();
    assert!(missing <= 1, "{missing}");
    run::<Plan>(&folder, &Engines::default()).expect("it runs");
    let again = text_of(&rows);
    assert!(again.starts_with(&text[..text.len() - 20]));
    let (first, second) = (text.lines().last(), again.lines().last());
    let parse = |line: Option<&str>| -> Member {
        let json = line.and_then(|line| line.splitn(3, ' ').nth(2));
        serde_json::from_str(json.expect("a row")).expect("a member")
    };
    assert!(Plan::same(&parse(first), &parse(second)));

    let record = record(&folder);
    assert!(record.points.iter().all(|point| point.missing == 0));
    let height = |id: &str| {
        let judged = record.point(id).and_then(|point| point.confirmed.as_ref());
        let judged = judged.expect("a candidate");
        assert_eq!(judged.clouds, 3);
        let found = judged.of("settled.height.mean_surface").expect("measured");
        found.paired.difference.estimate
    };
    // A bed stopped at a twentieth of its energy is looser by far more than one at another step.
    let (loose, same) = (height("hardly-settled"), height("same-physics"));
    assert!(loose > 0.004, "{loose}");
    assert!(same.abs() < loose, "{same} {loose}");

    let document = record.document();
    let page = report::page(&document);
    assert!(page.html.contains("hardly-settled"));
    for name in "cost-and-error.svg equivalence-of-hardly-settled.svg \
        bias-of-settled-height-mean-surface.csv methods.csv quantities.csv"
        .split_whitespace()
    {
        assert!(page.files.iter().any(|(file, _)| file == name), "{name}");
    }
    assert!(report::terminal(&document).contains(&document.answer));
}

#[test]
fn runs_without_yade_say_so_and_are_not_complete() {
    let place = &new_folder();
    let folder = place.join("study");
    let mut plan = Plan::new(small_scene(), 2, 0);
    let yade = Specification {
        runner: Runner::YadeOrdinary,
        ..plan.reference.specification.clone()
    };
    plan.add("yade", "YADE", "YADE", yade, 1);
    create(&folder, plan, None, None).expect("a new study");
    let mut engines = Engines::default();
    engines.yade.program = Some(place.join("no-such-yade"));
    let error = run::<Plan>(&folder, &engines).expect_err("YADE is missing");
    assert!(error.to_string().contains("YADE"), "{error}");
    let record = record(&folder);
    assert_eq!((record.reference.missing, record.points[0].missing), (0, 2));
    assert_eq!(record.recommended, None);
    let report = StudyFolder::<Plan>::open(&folder).expect("a study").judge();
    let report = report.expect("what is there");
    let verdict = report.document.verdict;
    assert_eq!(verdict, crossgrain::checks::Outcome::Skipped);
    fs::write(folder.join("report.json"), report.text).expect("can be written");
    let beside = Beside::read(&[folder], false).expect("its record");
    assert_eq!(beside.stated()[0].job, "tradeoff");
}

#[test]
fn heights_of_beds_of_other_depths_are_not_compared() {
    let methods = [
        ("half-as-deep", (What::Depth, 0.5)),
        ("softer", (What::Modulus, 0.1)),
    ];
    let (_place, folder) = made(plan(&methods, 0));
    let record = record(&folder);
    let has_height = |id: &str| {
        let screened = record.point(id).map(|point| &point.screened);
        let mut differences = screened.expect("a method").differences.iter();
        differences.any(|difference| difference.key.starts_with("settled.height."))
    };
    assert!(!has_height("half-as-deep"));
    assert!(has_height("softer"));
}

/// `run --reduced-stiffness` is the method that was tested: the same bed and the same end, in every bit.
#[test]
fn a_run_that_is_poured_softly_is_the_tested_method() {
    use grains::native::pouring::Softly;
    let mut scene = small_scene();
    scene.name = "poured softly".to_owned();
    let softly = Softly::tested(&scene).expect("a step in proportion");
    let phases = softly.phases(&scene);
    let poured = pour(&scene, &phases, &sound(), initial_bodies(&scene)).expect("it settles");
    let poured = poured.expect("there are phases");

    let folder = folder_with(&scene);
    let run = |code: i32, more: &str| {
        let run = format!("run scene.json --reduced-stiffness --quiet --engine {more}");
        ends(&folder, code, &run);
    };
    run(0, "native --out soft");
    let read = read_run(folder.join("soft"));
    let settled = read.settled.as_ref().expect("a settled bed");
    assert_eq!(settled.bodies.digest(), poured.bed.bodies.digest());
    let softened = read.record.softened.as_ref().expect("how it was poured");
    assert_eq!(softened.cloud_digest, initial_bodies(&scene).digest());
    assert_eq!(softened.phases, phases[..phases.len() - 1]);
    assert_eq!(softened.steps + read.record.stages[0].steps, poured.steps);
    assert_eq!(read.record.stages[0].stop, StopReason::Settled);
    let words = "--engine native --reduced-stiffness --out";
    has(&read.record.command, [words]);

    // Where it means nothing it is refused.
    run(2, "yade --out no");
    run(2, "native --steps 5 --out no");
    run(2, "native --perturb stiffness=1e-9 --out no");
    assert!(!folder.join("no").exists());
}

/// The native engine has the same bits on any machine, so a recorded realization comes out again; and the recorded judgement is that
/// of the recorded rows.
#[test]
fn recorded_realizations_of_the_reference_come_out_again() {
    let (folder, recorded) = judged_again::<Plan, Tradeoff>("reference_data/tradeoff-1");
    let recommended = recorded.recommended.as_deref();
    // A record without the fast protocol recommends nothing.
    assert_eq!(recommended, recorded.point(FAST).map(|_| FAST));
    let merged = folder.merged().expect("merged");
    let plan = &merged.plan.study;
    let digest = plan.reference.specification.digest();
    let own = merged.rows.iter().filter(|row| row.specification == digest);
    assert_eq!(own.clone().count(), 308);
    let reference = Plan::full(8, 300, 1).reference.specification;
    for realization in [2, FIRST_CONFIRMATORY] {
        let keep = |key: &str| judge::QUANTITIES.iter().any(|quantity| quantity.key == key);
        let engines = Engines::default();
        let again = Member::run(&reference, realization, &engines, Path::new(""), keep);
        let again = again.expect("it runs");
        let recorded = own.clone().find(|row| row.realization == realization);
        let recorded = recorded.expect("a recorded member");
        assert_eq!(again.measured, recorded.measured);
        assert_eq!(again.pour_steps, recorded.pour_steps);
    }
}

#[test]
fn yade_has_no_clouds_that_the_reference_has_not() {
    let folder = &new_folder();
    let words = "study plan tradeoff --quick --clouds 2 --yade-clouds 3 --out no";
    tells(folder, 2, words, ["at most --clouds, 2"]);
    assert!(!folder.join("no").exists());
}

#[test]
fn the_fast_protocols_scene_differs_in_the_step_and_what_goes_with_it() {
    let folder = &new_folder();
    let plain = prints(folder, 0, "scene paper");
    let mut fast = prints(folder, 0, "scene paper --fast");
    let step = "/time_step/of_sqrt_m_over_k";
    assert_eq!(plain.pointer(step), Some(&0.45.into()));
    assert_eq!(fast.pointer(step), Some(&0.65.into()));
    // Looked at equally often in time.
    let every = |scene: &Value| {
        scene
            .pointer("/settle/check_every")
            .and_then(|n| n.as_f64())
    };
    let ratio = every(&plain).expect("a number") / every(&fast).expect("a number");
    assert!((ratio - 0.65 / 0.45).abs() < 0.01, "{ratio}");
    for key in ["time_step", "settle", "measurement", "choices"] {
        fast[key] = plain[key].clone();
    }
    assert_eq!(fast, plain);
}

/// What the recorded chart shows: the front as a line, each of its methods named, values on both axes, and a sentence.
#[test]
fn the_chart_names_its_front_and_says_what_it_shows() {
    let recorded: Tradeoff = recorded_of(root("reference_data/tradeoff-1"));
    let page = report::page(&recorded.document());
    let words = words_apart(&page, "cost-and-error.svg");
    for frictional in [false, true] {
        let front = recorded.front(frictional);
        assert!(front.len() > 2, "{}", front.len());
        assert!(front.is_sorted_by(|a, b| a.1 < b.1 && a.2.estimate > b.2.estimate));
        for (point, ..) in front {
            let is_there = words
                .iter()
                .any(|word| word.starts_with(&point.method.name));
            assert!(is_there, "{} has no name", point.method.name);
        }
    }
    let values: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    assert!(values.len() > 9, "{values:?}");
    let (_, svg) = &page.files[0];
    assert!(svg.contains("viewBox=\"0 0 1240 "), "as wide as the page");
    for word in ["front", "native", "margin", "a reference against itself"] {
        assert!(words.iter().any(|seen| seen == word), "{word}");
    }
    let said = "not shown to err beyond a margin is step 0.65, poured at E/10 until 1e-3, at 0.78 s against the \
                reference&#39;s 1.84 s.";
    has(&page.html, [said]);
}
