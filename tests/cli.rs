//! The command line: exit codes, messages, and the main job without YADE.

use crate::support::*;

#[test]
fn usage_errors_exit_with_2() {
    let folder = &new_folder();
    ends(folder, 2, &[""; 0]);
    for command in [
        "dance",
        "run scene.json",
        "run no-such-scene.json --engine native --out o",
        "scene paper --particles 0",
        "compare one",
        "reproduce --scene no-such-scene.json",
    ] {
        let (_, errors) = ends(folder, 2, command);
        assert!(!errors.is_empty());
    }
    let folder = &folder_with(&small_scene());
    let command = "run scene.json --engine native --perturb luck=1 --out o";
    tells(folder, 2, command, ["unknown perturbation"]);
}

#[test]
fn the_printed_scene_is_a_valid_one_of_the_wanted_realization() {
    let folder = &new_folder();
    let (out, _) = ends(folder, 0, "scene paper --seed 42 --particles 123");
    let scene = grains::scene::parse_scene(&out).expect("a valid scene");
    assert_eq!(scene, paper_scene(42, 123));
}

#[test]
fn a_bed_that_does_not_settle_is_incomplete() {
    let mut scene = small_scene();
    scene.settle.max_steps = 2000;
    let folder = &folder_with(&scene);
    let (out, _) = ends(folder, 3, "run scene.json --engine native --out o");
    has(&out, ["not settled"]);
    assert!(folder.join("o/run.json").is_file());
}

#[test]
fn an_engine_that_fails_exits_with_4_and_names_step_and_grain() {
    let mut scene = small_scene();
    let of_sqrt_m_over_k = 50.0;
    scene.time_step = grains::scene::TimeStep::Fraction { of_sqrt_m_over_k };
    let folder = &folder_with(&scene);
    let (_, errors) = ends(folder, 4, "run scene.json --engine native --out o");
    has(&errors, ["in step ", "grain "]);
    assert!(!folder.join("o").exists());
}

#[test]
fn a_main_job_that_compares_nothing_is_incomplete_and_says_so() {
    let folder = &folder_with(&small_scene());
    let job = "reproduce --scene scene.json --recorded --out";
    let job_in = |out: &str, code: i32| ends(folder, code, &format!("{job} {out}"));
    let (out, _) = job_in("o", 3);
    has(&out, ["--recorded leaves it out", "INCOMPLETE"]);
    // A YADE that was named is meant to be there.
    let named = "reproduce --scene scene.json --out n --yade /nowhere/yade";
    let (_, errors) = ends(folder, 4, named);
    has(&errors, ["YADE is missing"]);
    let page = text_of(folder.join("o/report.html"));
    let page = page.replace("&#39;", "'");
    has(
        &page,
        ["Incomplete", "Nothing could be compared", "skipped"],
    );
    has(&page, ["id=\"fig-packing-1\"", "stiffness=1e-12", "7776"]);
    has(&page, ["crossgrain run scene.json --engine native"]);
    let measures = text_of(folder.join("o/measures.html"));
    has(&measures, ["id=\"fig-measures-kinetic-energy\""]);
    let paper = text_of(folder.join("o/paper.html"));
    has(&paper, ["This is not the paper&#39;s scene"]);
    for remote in ["http://", "https://", "<script src"] {
        // Names of formats, and the link to the paper, which is followed only by a click.
        let others = page.replace("http://www.w3.org/", "");
        let others = others.replace("<a href=\"https://doi.org/", "");
        assert!(!others.contains(remote), "the page asks for {remote}");
    }
    let text = text_of(folder.join("o/run.json"));
    let record = json_of(folder.join("o/run.json"));
    assert_eq!(record["verdict"], "skipped");
    assert_eq!(record["yade"], Value::Null);
    let checks = record["checks"].as_array().expect("checks");
    let ids = checks.iter().filter_map(|check| check["id"].as_str());
    for id in ids {
        for engine in ["native", "yade", "lammps", "liggghts", "exec"] {
            assert!(!id.to_lowercase().contains(engine), "{id} names an engine");
        }
    }
    assert!(
        record["skipped"]
            .as_array()
            .is_some_and(|list| list.len() >= 3)
    );

    // A finished job keeps all that it has, under another name.
    let (_, errors) = job_in("o", 3);
    has(&errors, ["what was in o is in o-2 now"]);
    let kept = text_of(folder.join("o-2/run.json"));
    assert_eq!(kept, text);
    // An unfinished one is taken up with the runs that it has.
    fs::remove_file(folder.join("o/run.json")).expect("a file");
    let run = folder.join("o/native/run.json");
    let modified = || fs::metadata(&run).and_then(|file| file.modified());
    let before = modified().expect("a time");
    job_in("o", 3);
    assert_eq!(before, modified().expect("a time"));
    // A recorded run that somebody changed is no recorded run.
    fs::remove_file(folder.join("o/run.json")).expect("a file");
    let log = folder.join("o/yade-recorded/yade.log");
    fs::write(log, "other").expect("writable");
    let (_, errors) = job_in("o", 2);
    has(&errors, ["is not the recorded run"]);
    // Somebody's own report is not overwritten.
    fs::create_dir(folder.join("p")).expect("writable");
    fs::write(folder.join("p/report.html"), "mine").expect("writable");
    job_in("p", 2);
}

#[test]
fn a_main_job_that_is_asked_to_end_is_not_finished() {
    let folder = &new_folder();
    let command = "reproduce --quiet --out o --recorded";
    let mut child = started(folder, command);
    let recorded = folder.join("o/yade-recorded/run.json");
    let began = Instant::now();
    while !recorded.exists() && began.elapsed().as_secs() < 120 {
        std::thread::sleep(Duration::from_millis(20));
    }
    // Reading the tables takes a moment; the faults are at work then.
    std::thread::sleep(Duration::from_millis(600));
    send(&child, "TERM");
    assert_eq!(child.wait().expect("an end").code(), Some(75));
    assert!(!folder.join("o/run.json").exists());
    assert!(!folder.join("o/report.html").exists());
}

#[test]
fn the_papers_scene_agrees_with_the_recorded_yade_run() {
    let folder = &new_folder();
    // Where YADE is installed it is left out all the same.
    let (out, _) = ends(folder, 0, "reproduce --recorded --out o");
    has(&out, ["recorded: identical", "--recorded leaves it out"]);
    assert!(!folder.join("o/yade-sorted").exists());
    let mut lines = out.lines();
    let bits = lines.find(|line| line.contains("bits of last grains"));
    let agree = |line: &str| line.contains("pass") && line.ends_with("0 of 20000 numbers differ");
    assert!(bits.is_some_and(agree), "{out}");
    let record = json_of(folder.join("o/run.json"));
    assert_eq!(record["verdict"], "pass");
    let checks = &record["comparisons"][0]["comparison"]["checks"];
    for (list, key, count) in [(checks, "outcome", 11), (&record["faults"], "verdict", 6)] {
        let list = list.as_array().expect("a list");
        assert_eq!(list.len(), count);
        assert!(list.iter().all(|entry| entry[key] == "pass"), "{list:?}");
    }
}

/// Two jobs in one folder at once would each take the other's runs for its own.
#[test]
fn a_main_job_in_a_folder_where_another_is_at_work_is_refused() {
    let folder = &folder_with(&small_scene());
    fs::create_dir(folder.join("o")).expect("writable");
    let lock = crossgrain::files::folder_lock(&folder.join("o")).expect("free");
    let command = "reproduce --scene scene.json --out o --quiet --recorded";
    tells(folder, 75, command, ["in use by another process"]);
    assert_eq!(there(&folder.join("o")).len(), 1, "the lock");
    drop(lock);
    // It is made when the other has ended.
    ends(folder, 3, command);
}

/// The recorded run is judged like any other: with a fault in the native engine it must disagree. 5000 grains stay small.
#[test]
fn a_faulty_native_run_disagrees_with_the_recorded_yade_run() {
    let folder = folder_with(&paper_scene(1, 5000));
    crossgrain::run::folder::unpack_recorded(&folder.join("yade")).expect("writable");
    let command = "run scene.json --engine native --perturb stiffness=1e-12 --quiet --out native";
    ends(&folder, 0, command);
    let (out, _) = ends(&folder, 1, "compare native yade --no-locate");
    has(&out, ["FAIL compare/bits-along-the-way"]);
    let record = json_of(folder.join("native/run.json"));
    let peak = record["peak_memory"].as_u64().expect("Linux tells");
    assert!(peak > 1 << 20 && peak < 100 * 1_000_000, "{peak} bytes");
}

#[test]
fn a_closed_standard_error_is_no_reason_to_fail() {
    let folder = &folder_with(&small_scene());
    let run = "\"$0\" run scene.json --engine native --steps 10 --out o 2>/dev/full";
    assert_eq!(bash(folder, run, &[]).0, 0);
}
