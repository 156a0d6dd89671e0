//! An external engine as methods of the comparison: what it can do is judged, what it cannot is missing.

use crossgrain::engine::exec::{ExternalEngine, Options};
use crossgrain::report;
use crossgrain::study::folder::StudyFolder;
use crossgrain::study::realization::Ending;
use crossgrain::study::tradeoff::{Tradeoff, plan::Plan};

use super::{record, tried};
use crate::support::*;

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

/// What is said of this scene with the engine in it, how its first method on the first cloud ended, and why rows are missing.
fn study(scene: Scene, options: Options, clouds: u64) -> (Tradeoff, Option<Ending>, String) {
    let external = ExternalEngine::ask(options).expect("an engine");
    let plan = Plan::new(scene, 2, 0);
    let plan = plan.with_external(&external.description, &external.digest, clouds);
    let digest = plan.methods[0].specification.digest();
    let (_place, folder, ended) = tried(plan, Some(external));
    let words = ended.err().map_or(String::new(), |error| error.to_string());
    let mut ending = None;
    let opened = StudyFolder::<Plan>::open(&folder).expect("a study");
    let each = opened.each(|_, row| {
        if row.specification == digest && row.realization == 1 {
            ending = Some(row.ending);
        }
    });
    each.expect("rows");
    (record(&folder), ending, words)
}

#[test]
fn without_a_punch_the_bed_is_judged_and_loading_is_skipped() {
    let folder = &new_folder();
    let text = format!("{SOUND}{SETTLES}{AND_THEN}{AT_ONCE}");
    let options = Options::new(program(folder, "engine.py", &text));
    let (record, ending, words) = study(narrow_scene(0.05), options, 2);
    assert_eq!(ending, Some(Ending::Poured));
    assert_eq!(record.points.len(), 3);
    let names = record.points.iter().map(|point| point.method.name.as_str());
    let names: Vec<&str> = names.collect();
    let planned = ["broken 1", "broken 1, step 0.225", "broken 1, step 0.65"];
    assert_eq!(names, planned);
    for point in &record.points {
        let judged = &point.screened;
        assert_eq!((judged.endings.poured, judged.endings.all()), (2, 0));
        assert!(judged.bed.is_some() && judged.load.is_none(), "{judged:?}");
        assert_eq!(point.missing, 0);
        // What the program took was seen from outside; it says 1 s.
        let cost = point.costs.expect("a cost").cpu_seconds;
        assert!((0.3..0.9).contains(&cost), "{cost}");
    }
    assert_eq!(words, "");
    let page = report::page(&record.document());
    for words in ["skipped loading", "it says of itself: nothing moves"] {
        assert!(page.html.contains(words), "{words}");
    }
}

#[test]
fn an_engine_without_stop_rules_is_skipped_and_says_why() {
    let (record, ending, words) =
        study(narrow_scene(0.05), Options::new(adapter_path("toy.py")), 1);
    assert_eq!(ending, None);
    for point in &record.points {
        let reason = point.notes.first().expect("a reason");
        for text in [reason, &words] {
            has(text, ["toy has no", "stop_rules"]);
        }
        assert!(point.costs.is_none());
        assert_eq!(point.missing, 1);
    }
    let page = report::page(&record.document());
    assert!(page.html.contains("toy has no"));
}

#[test]
fn an_engine_that_crashes_is_a_member_that_failed() {
    let folder = &new_folder();
    let text = format!("{SOUND}{SETTLES}{AND_THEN}sys.exit('no more discs')\n");
    let options = Options::new(program(folder, "engine.py", &text));
    let (record, ending, missing) = study(narrow_scene(0.05), options, 1);
    let Some(Ending::Failed(words)) = ending else {
        panic!("{ending:?}");
    };
    has(&words, ["no more discs"]);
    assert_eq!(record.points[0].screened.endings.missed(), 1);
    assert_eq!(missing, "");
}

#[test]
fn another_program_is_another_method() {
    let described = |text: &str| {
        let folder = &new_folder();
        let path = program(folder, "engine.py", text);
        let external = ExternalEngine::ask(Options::new(path)).expect("an engine");
        let plan = Plan::new(narrow_scene(0.05), 2, 0);
        let plan = plan.with_external(&external.description, &external.digest, 1);
        let digest = plan.methods[0].specification.digest();
        (plan.reference.specification.digest(), digest)
    };
    let one = format!("{SOUND}{SETTLES}{AND_THEN}");
    assert_eq!(described(&one), described(&one));
    assert_ne!(described(&one).1, described(&format!("{one}# changed\n")).1);
    assert_ne!(described(&one).1, described(&one).0);
}

#[test]
fn engines_that_cannot_take_part_are_a_usage_error() {
    let folder = &new_folder();
    for [command, message] in rows(
        "study plan tradeoff --quick --out s --engine yade ⇒ take part anyway
        bench --quick --engine native ⇒ take part anyway
        study plan tradeoff --quick --out s --engine exec:/nowhere ⇒ cannot be started
        bench --quick --engine exec:/nowhere ⇒ cannot be started
        stability --quick --engine exec:/nowhere ⇒ cannot be started
        stability --engine lammps ⇒ native, yade, both or exec:PATH
        study plan tradeoff --quick --out s --engine-clouds 2 ⇒ --engine
        study plan tradeoff --quick --out s --engine exec:/nowhere --engine-clouds 7 ⇒ at most --clouds, 6",
    ) {
        let (_, errors) = ends(folder, 2, command);
        assert!(errors.contains(message), "{command}: {errors}");
    }
    assert!(!folder.join("out").exists());
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn lammps_makes_and_loads_the_bed_that_the_native_engine_makes() {
    let options = Options::new(adapter_path("lammps.py"));
    let (record, ending, words) = study(narrow_scene(0.0), options, 1);
    assert_eq!(ending, Some(Ending::Reached));
    let point = &record.points[0];
    assert_eq!(point.screened.endings.reached, 1, "{words}");
    let height = point.screened.of("settled.height.mean_surface");
    let height = height.map(|difference| difference.paired.difference.estimate);
    let near = height.is_none_or(|height| height.abs() < 0.005);
    assert!(near, "{height:?}");
    assert!(point.costs.is_some_and(|costs| costs.pour_steps > 1000.0));
}
