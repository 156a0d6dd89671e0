//! The jobs that start YADE, with programs that are not YADE: exit code 4, words that say what happened and what to do, and no
//! record, page or folder that looks finished. `yade_driver` has the finer ways to break `run`.

use crate::hostile_names::nothing_obeyed;
use crate::support::*;
use crate::yade_driver::yade;

/// Programs, and what is said of them.
const BROKEN: [(&str, &str, &[&str]); 6] = [
    (
        "silent",
        "os._exit(0)",
        &["the engine wrote nonsense", "--yade, CROSSGRAIN_YADE"],
    ),
    (
        "babbling",
        "print('\\x1b[31mgarbage ' * 10**5); os._exit(3)",
        &["the engine ended with", "garbage"],
    ),
    (
        "hanging",
        "time.sleep(600)",
        &["the engine hung", "--stall-limit"],
    ),
    (
        "hungry",
        "all = []\nwhile True:\n    all.append(b'x' * (16 << 20)); time.sleep(0.02)",
        &["the engine took", "MB of memory", "--memory-limit"],
    ),
    (
        "writing",
        "put('hello.json', json.dumps({'version': '2023.02a'}))\n\
         file = open(os.path.join(job, 'tables.bin'), 'wb')\n\
         while True:\n    file.write(b'x' * (1 << 20)); file.flush(); time.sleep(0.01)",
        &["the engine took", "MB of output", "--output-limit"],
    ),
    (
        "numberless",
        "put('hello.json', json.dumps({'version': '2023.02a'}))\n\
         open(os.path.join(job, 'tables.bin'), 'wb').write(struct.pack('d', float('nan')) * 10**5)\n\
         put('moments.jsonl', '{\"stage\": NaN}\\n' * 3)\n\
         put('done.json', json.dumps({'steps': 10})); os._exit(0)",
        &["the engine wrote nonsense", "moments.jsonl"],
    ),
];

const LIMITS: &str = "--stall-limit 3 --time-limit 60 --memory-limit 200 --output-limit 20";

/// Files below a folder, without the inputs of the test.
fn left(folder: &Path) -> Vec<String> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path.to_string_lossy().into_owned());
            }
        }
    }
    files
}

/// The job with each of the broken programs; nothing of this name may be in what it leaves.
fn every_way_is_told(job: &str, finished: &[&str]) {
    for (name, does, words) in BROKEN {
        let folder = &folder_with(&tiny_scene());
        yade(folder, name, does);
        let job = format!("{job} {LIMITS} --yade ./{name} --out o");
        let output = crossgrain(&job, folder);
        nothing_obeyed(folder, &output);
        let (code, _, errors) = told(&output);
        assert_eq!(code, 4, "{job:?}, {name}: {errors}");
        for word in words {
            has(&errors, [word]);
        }
        let said = errors.len();
        assert!(said < 8000, "{name}: {said} bytes are said");
        for file in left(folder) {
            let half =
                file.contains("crossgrain.partial") || finished.iter().any(|of| file.ends_with(of));
            assert!(!half, "{job:?}, {name} left {file}");
        }
    }
}

#[test]
fn a_run_tells_every_way() {
    let job = "run scene.json --engine yade --steps 10 --quiet";
    every_way_is_told(job, &["o/run.json"]);
}

#[test]
fn the_main_job_tells_every_way() {
    let job = "reproduce --scene scene.json --quiet";
    every_way_is_told(job, &["o/run.json", "o/report.html"]);
}

#[test]
fn the_ladder_tells_every_way() {
    let job = "verify --engine yade --grains 5 --quiet";
    every_way_is_told(job, &["verify.json", "report.html"]);
}

/// The map begins with minutes of native beds, so that one way stands for all.
#[test]
#[ignore = "minutes: the native part of the map comes first"]
fn the_stability_map_tells_of_a_yade_that_says_nothing() {
    let folder = &folder_with(&tiny_scene());
    let (_, does, words) = BROKEN[0];
    yade(folder, "yade", does);
    let command = "stability --quick --quiet --yade ./yade --out o";
    let (_, errors) = ends(folder, 4, command);
    assert!(words.iter().all(|word| errors.contains(word)), "{errors}");
    let finished = left(folder);
    let below = finished.iter().any(|file| file.contains("/o/"));
    assert!(!below, "{finished:?}");
}

/// `compare` goes back to the engine to find where two runs part, and says why it cannot.
#[test]
fn a_comparison_tells_that_its_engine_is_broken() {
    let folder = &folder_with(&crate::hostile_names::two_grains());
    let sound = "frames(fine + fine, [frame(0), frame(10), end(10)])";
    yade(folder, "yade", sound);
    for run in ["native --out native", "yade --out other"] {
        let run = format!("run scene.json --steps 10 --yade ./yade --engine {run}");
        ends(folder, 0, &run);
    }
    for (name, does, words) in BROKEN {
        if name == "numberless" {
            continue;
        }
        yade(folder, "yade", does);
        let compare = format!("compare native other --yade ./yade {LIMITS}");
        let output = crossgrain(&compare, folder);
        nothing_obeyed(folder, &output);
        let (code, out, errors) = told(&output);
        // That the runs differ was found without the engine.
        assert_eq!(code, 1, "{name}: {out}{errors}");
        assert!(out.contains(words[0]), "{name}: {out}{errors}");
    }
}
