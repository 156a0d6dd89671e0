//! An engine that was brought as points of the chart: what it can do is charted, what it cannot is not made.

use crossgrain::engine::exec::{Brought, Options};
use crossgrain::progress::Display;
use crossgrain::report;
use crossgrain::study::tradeoff::job::{self, Job};
use crossgrain::study::tradeoff::member::Ending;
use crossgrain::study::tradeoff::method::{Family, Method, Program};
use crossgrain::study::tradeoff::plan::Plan;
use crossgrain::study::tradeoff::record::{Pareto, of_members};
use grains::native::Mode;
use grains::scene::Scene;

use crate::support::engines::{AND_THEN, SOUND, adapter_path, narrow_scene, program};
use crate::support::{crossgrain, told};

/// Pours by not moving at all, and takes its time.
const SETTLES: &str = r#"
SAY = lambda: describe(parts=["normal_spring", "local_damping", "gravity", "walls", "stop_rules"],
    approximations=["nothing moves"])
"#;
const AT_ONCE: &str = r#"
steps = json.load(open(os.path.join(job, "job.json")))["settle"]["check_every"]
while time.process_time() < 0.3: pass
finish([moment(0), moment(steps), end(steps, "settled")], steps)
"#;

fn plan(scene: Scene) -> Plan {
    Plan {
        reference: Method::plain("reference", Family::Reference, Mode::Exact, scene),
        methods: Vec::new(),
        charting: 2,
        confirming: 0,
    }
}

/// The chart of this scene with the engine in it, and the member of its first point and cloud.
fn chart(scene: Scene, options: Options, clouds: u64) -> (Pareto, Option<Ending>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let brought = Brought::ask(options).expect("an engine");
    let engine = Program {
        described: brought.description.clone(),
        digest: brought.digest().expect("a file"),
    };
    let plan = plan(scene).with_brought(&engine, clouds);
    let job = Job {
        brought: Some(brought),
        ..super::job(folder.path())
    };
    let members = job::run(&plan, &job, &Display::new(true)).expect("it runs");
    let member = members.get(&plan.methods[0].method, 1);
    let ending = member.map(|member| member.ending.clone());
    (
        of_members(&plan, &members, Vec::new(), String::new()),
        ending,
    )
}

#[test]
fn without_a_punch_the_bed_is_charted_and_loading_is_not_made() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = format!("{SOUND}{SETTLES}{AND_THEN}{AT_ONCE}");
    let options = Options::new(program(folder.path(), "engine.py", &text));
    let (record, ending) = chart(narrow_scene(0.05), options, 2);
    assert_eq!(ending, Some(Ending::Poured));
    assert_eq!(record.points.len(), 3);
    let names: Vec<&str> = record
        .points
        .iter()
        .map(|point| point.method.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["broken 1", "broken 1, step 0.225", "broken 1, step 0.65"]
    );
    for point in &record.points {
        let charted = &point.charted;
        assert_eq!((charted.endings.poured, charted.endings.all()), (2, 0));
        assert!(
            charted.bed.is_some() && charted.load.is_none(),
            "{charted:?}"
        );
        assert!(point.only_poured().is_some() && point.not_made.is_none());
        // What the program took was seen from outside; it says 1 s.
        let cost = point.costs.expect("a cost").cpu_seconds;
        assert!((0.3..0.9).contains(&cost), "{cost}");
        assert_eq!(point.engine, "broken 1");
    }
    assert!(record.complete);
    let page = report::pareto::page(&record).expect("a page");
    for words in ["loading is not made", "it says of itself: nothing moves"] {
        assert!(page.html.contains(words), "{words}");
    }
}

#[test]
fn an_engine_without_stop_rules_is_not_made_and_says_why() {
    let (record, ending) = chart(narrow_scene(0.05), Options::new(adapter_path("toy.py")), 1);
    assert_eq!(ending, None);
    for point in &record.points {
        let reason = point.not_made.as_ref().expect("a reason");
        assert!(
            reason.contains("toy has no") && reason.contains("stop_rules"),
            "{reason}"
        );
        assert!(point.costs.is_none());
    }
    assert!(!record.complete);
    let page = report::pareto::page(&record).expect("a page");
    assert!(page.html.contains("toy has no"));
}

#[test]
fn an_engine_that_crashes_is_a_member_that_failed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = format!("{SOUND}{SETTLES}{AND_THEN}sys.exit('no more discs')\n");
    let options = Options::new(program(folder.path(), "engine.py", &text));
    let (record, ending) = chart(narrow_scene(0.05), options, 1);
    let Some(Ending::Failed(words)) = ending else {
        panic!("{ending:?}");
    };
    assert!(words.contains("no more discs"), "{words}");
    assert_eq!(record.points[0].charted.endings.missed(), 1);
}

/// A finished member is taken over from the ledger; that of another program under the same name is not.
#[test]
fn another_program_is_another_method() {
    let scene = || narrow_scene(0.05);
    let of = |text: &str| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = program(folder.path(), "engine.py", text);
        let brought = Brought::ask(Options::new(path)).expect("an engine");
        let engine = Program {
            described: brought.description.clone(),
            digest: brought.digest().expect("a file"),
        };
        plan(scene()).with_brought(&engine, 1).methods[0]
            .method
            .digest()
    };
    let one = format!("{SOUND}{SETTLES}{AND_THEN}");
    assert_eq!(of(&one), of(&one));
    assert_ne!(of(&one), of(&format!("{one}# changed\n")));
    assert_ne!(of(&one), plan(scene()).reference.digest());
}

#[test]
fn engines_that_cannot_take_part_are_a_usage_error() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (arguments, message) in [
        (
            &["pareto", "--quick", "--engine", "yade"][..],
            "take part anyway",
        ),
        (
            &["bench", "--quick", "--engine", "native"],
            "take part anyway",
        ),
        (
            &["pareto", "--quick", "--engine", "exec:/nowhere"],
            "cannot be started",
        ),
        (
            &["bench", "--quick", "--engine", "exec:/nowhere"],
            "cannot be started",
        ),
        (
            &["stability", "--quick", "--engine", "exec:/nowhere"],
            "cannot be started",
        ),
        (
            &["stability", "--engine", "lammps"],
            "native, yade, both or exec:PATH",
        ),
        (&["pareto", "--quick", "--engine-seeds", "2"], "--engine"),
        (
            &[
                "pareto",
                "--quick",
                "--engine",
                "exec:/nowhere",
                "--engine-seeds",
                "7",
            ],
            "at most --seeds, 6",
        ),
        (
            &[
                "campaign",
                "plan",
                "scene.json",
                "--members",
                "1",
                "--out",
                "c",
                "--engine",
                "exec:toy.py",
            ],
            "only native and yade do this",
        ),
    ] {
        let (code, _, errors) = told(&crossgrain(arguments, folder.path()));
        assert_eq!(code, 2, "{arguments:?}: {errors}");
        assert!(errors.contains(message), "{arguments:?}: {errors}");
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
#[cfg_attr(
    not(feature = "exec-engines"),
    ignore = "needs LAMMPS and LIGGGHTS: --features exec-engines"
)]
fn lammps_pours_the_bed_that_the_native_engine_pours() {
    let options = Options::new(adapter_path("lammps.py"));
    let (record, ending) = chart(narrow_scene(0.0), options, 1);
    assert_eq!(ending, Some(Ending::Poured));
    let point = &record.points[0];
    assert!(point.only_poured().is_some());
    let mut found = point.charted.differences.iter();
    let height = found.find(|of| of.key == "settled.height.mean_surface");
    let height = height.map(|of| of.paired.difference.estimate);
    assert!(
        height.is_none_or(|height| height.abs() < 0.005),
        "{height:?}"
    );
    assert!(point.costs.is_some_and(|costs| costs.pour_steps > 1000.0));
}
