//! The chart of cost against error, on beds small enough for a test.

mod brought;

use std::path::Path;

use crossgrain::engine::yade;
use crossgrain::progress::Display;
use crossgrain::study::tradeoff::job::{self, Job};
use crossgrain::study::tradeoff::member;
use crossgrain::study::tradeoff::method::{
    Family, Method, Runner, with_modulus, with_size, with_step, with_tolerance,
};
use crossgrain::study::tradeoff::plan::{FIRST_CONFIRMING, Plan, Planned};
use crossgrain::study::tradeoff::record::of_members;
use grains::generate::initial_bodies;
use grains::native::pouring::{End, Phase, pour};
use grains::native::{self, Mode};
use grains::scene::Scene;
use grains::task::Task;

use crate::support::pages::each_figure_stands_once_and_has_numbers;
use crate::support::{crossgrain, small_scene};

fn planned(name: &str, scene: Scene, candidate: bool) -> Planned {
    Planned {
        method: Method::plain(name, Family::Step, Mode::Exact, scene),
        charting: 2,
        candidate,
    }
}

fn plan() -> Plan {
    Plan {
        reference: Method::plain("reference", Family::Reference, Mode::Exact, small_scene()),
        methods: vec![
            planned("same physics", with_step(small_scene(), 0.4), true),
            planned("hardly settled", with_tolerance(small_scene(), 0.05), true),
        ],
        charting: 2,
        confirming: 3,
    }
}

fn job(out: &Path) -> Job {
    Job {
        out: out.to_owned(),
        yade: yade::Options::default(),
        brought: None,
    }
}

#[test]
fn one_phase_of_the_scenes_own_settings_is_the_scenes_own_pouring() {
    let scene = small_scene();
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

#[test]
fn a_bed_that_is_stiffened_ends_at_the_full_stiffness_at_rest() {
    let scene = small_scene();
    let phase = |modulus, end| Phase {
        modulus,
        alpha: 0.2,
        step: 0.45,
        end,
    };
    let method = Method {
        name: "soft".to_owned(),
        family: Family::Soft,
        runner: Runner::Native(Mode::Exact),
        phases: vec![
            phase(0.1, End::Settled(1.0e-3)),
            phase(0.3, End::Seconds(0.004)),
            phase(1.0, End::Settled(1.0e-4)),
        ],
        scene: scene.clone(),
        engine: None,
    };
    let options = native::Options::default();
    let initial = initial_bodies(&scene);
    let poured = pour(&scene, &method.phases, &options, initial).expect("it settles");
    let poured = poured.expect("there are phases");
    // The overlaps bear the weight at the full stiffness: the floor's contacts together.
    let ids = grains::tables::BodyIds::of_box(scene.particles.count);
    let borne: f64 = poured
        .bed
        .contacts
        .iter()
        .filter(|contact| !ids.is_grain(contact.id1) && contact.normal[1] > 0.9)
        .map(|contact| contact.normal_force)
        .sum();
    let weight: f64 = scene.gravity * poured.bed.bodies.mass.iter().sum::<f64>();
    assert!((borne / weight - 1.0).abs() < 0.05, "{borne} {weight}");
    let member =
        member::run(&method, 1, &yade::Options::default(), None, Path::new("")).expect("it runs");
    assert!(member.measured.contains_key("settled.height.mean_surface"));
    assert!(member.cost.pour_steps > 0 && member.cost.load_steps > 0);
}

#[test]
fn a_chart_is_taken_up_where_it_was_and_finds_the_large_bias() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (plan, job, quiet) = (plan(), job(folder.path()), Display::new(true));
    let members = job::run(&plan, &job, &quiet).expect("it runs");
    let ledger = folder.path().join("members.jsonl");
    let text = std::fs::read_to_string(&ledger).expect("readable");
    assert_eq!(text.lines().count(), job::wanted(&plan).len());
    // Killed in the middle of the last line: that member alone is made again.
    std::fs::write(&ledger, &text[..text.len() - 20]).expect("cut");
    let again = job::run(&plan, &job, &quiet).expect("it runs");
    let text_again = std::fs::read_to_string(&ledger).expect("readable");
    let kept = text.lines().count() - 1;
    let head = |text: &str| {
        text.lines()
            .take(kept)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(head(&text), head(&text_again));
    let last = plan
        .methods
        .last()
        .map(|planned| &planned.method)
        .expect("methods");
    let realization = FIRST_CONFIRMING + 2;
    assert_eq!(
        members
            .get(last, realization)
            .map(|member| &member.measured),
        again.get(last, realization).map(|member| &member.measured)
    );

    let record = of_members(&plan, &again, Vec::new(), "test".to_owned());
    assert!(record.complete);
    assert_eq!(record.points.len(), 2);
    let height = |number: usize| {
        let judged = record.points[number]
            .confirmed
            .as_ref()
            .expect("a candidate");
        assert_eq!(judged.clouds, 3);
        let of = |key: &str| judged.differences.iter().find(|of| of.key == key);
        let found = of("settled.height.mean_surface").expect("measured");
        found.paired.difference.estimate
    };
    // A bed stopped at a twentieth of its energy is looser by far more than one at another step.
    assert!(height(1) > 0.004, "{}", height(1));
    assert!(height(0).abs() < height(1), "{} {}", height(0), height(1));
    let page = crossgrain::report::pareto::page(&record).expect("a page");
    let html = &page.html;
    assert!(html.contains("hardly settled") && html.contains("class=\"forest\""));
    each_figure_stands_once_and_has_numbers(&page);
}

#[test]
fn runs_without_yade_say_so_and_are_not_complete() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut plan = plan();
    plan.methods.truncate(1);
    plan.methods[0].method.runner = Runner::YadeOrdinary;
    plan.methods[0].candidate = false;
    plan.confirming = 0;
    let mut job = job(folder.path());
    job.yade.program = Some(folder.path().join("no-such-yade"));
    let members = job::run(&plan, &job, &Display::new(true)).expect("native members run");
    let record = of_members(&plan, &members, Vec::new(), "test".to_owned());
    assert!(!record.complete);
    let reason = record.points[0].not_made.as_deref().unwrap_or_default();
    assert!(reason.contains("YADE"), "{reason}");
    assert_eq!(record.recommended, None);
}

#[test]
fn heights_of_beds_of_other_depths_are_not_compared() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut plan = plan();
    plan.methods = vec![
        planned("half as deep", with_size(small_scene(), 1.0, 0.5), false),
        planned("softer", with_modulus(small_scene(), 0.1), false),
    ];
    plan.confirming = 0;
    let members = job::run(&plan, &job(folder.path()), &Display::new(true)).expect("it runs");
    let record = of_members(&plan, &members, Vec::new(), "test".to_owned());
    let has_height = |number: usize| {
        let judged = &record.points[number].charted;
        judged
            .differences
            .iter()
            .any(|of| of.key.starts_with("settled.height."))
    };
    assert!(!has_height(0));
    assert!(has_height(1));
}

#[test]
fn a_finished_chart_is_never_overwritten() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("pareto.json"), "{}").expect("written");
    let out = folder.path().to_string_lossy().into_owned();
    let output = crossgrain(&["pareto", "--quick", "--out", &out], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("finished chart"));
}

/// `run --soft-pour` is the method that was tested: the same bed and the same end, in every bit.
#[test]
fn a_run_that_is_poured_softly_is_the_tested_method() {
    use crossgrain::run::folder::RunFolder;
    use grains::native::pouring::Softly;
    use grains::tables::StopReason;
    let mut scene = small_scene();
    scene.name = "poured softly".to_owned();
    let softly = Softly::tested(&scene).expect("a step in proportion");
    let options = native::Options {
        mode: Mode::Free,
        ..native::Options::default()
    };
    let phases = softly.phases(&scene);
    let poured = pour(&scene, &phases, &options, initial_bodies(&scene)).expect("it settles");
    let poured = poured.expect("there are phases");

    let (folder, _) = crate::support::folder_with(&scene);
    let run = |more: &[&str]| {
        let mut words = vec![
            "run",
            "scene.json",
            "--mode",
            "free",
            "--soft-pour",
            "--quiet",
        ];
        words.extend(more);
        crate::support::told(&crate::support::crossgrain(&words, folder.path()))
    };
    let (code, _, message) = run(&["--engine", "native", "--out", "soft"]);
    assert_eq!(code, 0, "{message}");
    let read = RunFolder::read(&folder.path().join("soft")).expect("a run folder");
    let settled = read.settled.as_ref().expect("a settled bed");
    assert_eq!(settled.bodies.digest(), poured.bed.bodies.digest());
    let softened = read.record.softened.as_ref().expect("how it was poured");
    assert_eq!(softened.cloud_digest, initial_bodies(&scene).digest());
    assert_eq!(softened.phases, phases[..phases.len() - 1]);
    assert_eq!(softened.steps + read.record.stages[0].steps, poured.steps);
    assert_eq!(read.record.stages[0].stop, StopReason::Settled);
    assert!(
        read.record
            .command
            .contains("--mode free --soft-pour --out")
    );

    // Where it means nothing it is refused.
    for wrong in [
        &["--engine", "yade", "--out", "no"][..],
        &["--engine", "native", "--steps", "5", "--out", "no"],
        &[
            "--engine",
            "native",
            "--perturb",
            "stiffness=1e-9",
            "--out",
            "no",
        ],
    ] {
        assert_eq!(run(wrong).0, 2, "{wrong:?}");
    }
    assert!(!folder.path().join("no").exists());
}

/// Exact mode has the same bits on any machine, so a recorded realization comes out again.
#[test]
fn recorded_realizations_of_the_reference_come_out_again() {
    use crossgrain::study::tradeoff::member::Member;
    use crossgrain::study::tradeoff::plan::Plan;
    use std::io::Read;
    let unpacked = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("reference_data/pareto-1")
            .join(name);
        let file = std::fs::File::open(path).expect("recorded evidence");
        let mut text = String::new();
        let mut reader = flate2::read::GzDecoder::new(file);
        reader.read_to_string(&mut text).expect("gzip");
        text
    };
    let chart: serde_json::Value = serde_json::from_str(&unpacked("pareto.json.gz")).expect("JSON");
    assert_eq!(chart["recommended"], 42);
    let digest = chart["reference"]["digest"].as_str().expect("a digest");
    let members = unpacked("members.jsonl.gz");
    let members = members
        .lines()
        .map(|line| serde_json::from_str::<Member>(line).expect("a member"));
    let recorded: Vec<Member> = members.filter(|member| member.method == digest).collect();
    assert_eq!(recorded.len(), 308);
    let reference = Plan::full(8, 300, 1).reference;
    for realization in [2, 1001] {
        let again = member::run(
            &reference,
            realization,
            &yade::Options::default(),
            None,
            Path::new(""),
        );
        let again = again.expect("it runs");
        let of = recorded
            .iter()
            .find(|member| member.realization == realization);
        let of = of.expect("a recorded member");
        assert_eq!(again.measured, of.measured);
        assert_eq!(again.cost.pour_steps, of.cost.pour_steps);
    }
}

#[test]
fn yade_has_no_clouds_that_the_reference_has_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let words = [
        "pareto",
        "--quick",
        "--seeds",
        "2",
        "--yade-seeds",
        "3",
        "--out",
        "no",
    ];
    let (code, _, message) =
        crate::support::told(&crate::support::crossgrain(&words, folder.path()));
    assert_eq!(code, 2);
    assert!(message.contains("at most --seeds, 2"), "{message}");
    assert!(!folder.path().join("no").exists());
}
