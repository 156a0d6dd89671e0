//! The jobs that start YADE, with programs that are not YADE: exit code 4, words that say what happened and what to do, and no
//! record, page or folder that looks finished. `yade_driver` has the finer ways to break `run`.

use crate::hostile_names::harmless;
use crate::support::*;
use crate::yade_driver::yade;

/// Programs, and what is said of them.
const BROKEN: &str = r#"
    silent ⇒ os._exit(0) ⇒ the engine wrote nonsense ⇒ --yade, CROSSGRAIN_YADE
    babbling ⇒ print('\x1b[31mgarbage ' * 10**5); os._exit(3) ⇒ the engine ended with ⇒ garbage
    hanging ⇒ time.sleep(600) ⇒ the engine hung ⇒ --stall-limit
    hungry ⇒ all = [(b'x' * (16 << 20), time.sleep(0.02)) for i in range(10**6)] ⇒ the engine took ⇒ MB of memory, --memory-limit
    writing ⇒ put('hello.json', json.dumps({'version': '2023.02a'})); file = open(os.path.join(job, 'tables.bin'), 'wb'); [(file.write(b'x' * (1 << 20)), file.flush(), time.sleep(0.01)) for i in range(10**6)] ⇒ the engine took ⇒ MB of output, --output-limit
    numberless ⇒ put('hello.json', json.dumps({'version': '2023.02a'})); open(os.path.join(job, 'tables.bin'), 'wb').write(struct.pack('d', float('nan')) * 10**5); put('moments.jsonl', '{"stage": NaN}\n' * 3); put('done.json', json.dumps({'steps': 10})); os._exit(0) ⇒ the engine wrote nonsense ⇒ moments.jsonl
"#;

const LIMITS: &str = "--stall-limit 3 --time-limit 60 --memory-limit 200 --output-limit 20";

/// The job with each of the broken programs; nothing of this name may be in what it leaves.
fn every_way_is_told(job: &str, finished: &[&str]) {
    for [name, does, ended, words] in rows(BROKEN) {
        let folder = &folder_with(&tiny_scene());
        yade(folder, name, does);
        let job = format!("{job} {LIMITS} --yade ./{name} --out o");
        let (code, _, errors) = harmless(folder, &crossgrain(&job, folder));
        assert_eq!(code, 4, "{job:?}, {name}: {errors}");
        has(&errors, [ended]);
        for word in words.split(", ") {
            has(&errors, [word]);
        }
        let said = errors.len();
        assert!(said < 8000, "{name}: {said} bytes are said");
        for file in below(folder) {
            let partial = file.to_string_lossy().contains("crossgrain.partial");
            let half = partial || finished.iter().any(|name| file.ends_with(name));
            assert!(!half, "{job:?}, {name} left {file:?}");
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
    yade(folder, "yade", "os._exit(0)");
    let command = "stability --quick --quiet --yade ./yade --out o";
    let words = ["the engine wrote nonsense", "--yade, CROSSGRAIN_YADE"];
    tells(folder, 4, command, words);
    assert!(
        below(folder)
            .iter()
            .all(|file| !file.to_string_lossy().contains("/o/"))
    );
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
    for [name, does, ended, _] in rows(BROKEN) {
        if name == "numberless" {
            continue;
        }
        yade(folder, "yade", does);
        let compare = format!("compare native other --yade ./yade {LIMITS}");
        let (code, out, errors) = harmless(folder, &crossgrain(&compare, folder));
        // That the runs differ was found without the engine.
        assert_eq!(code, 1, "{name}: {out}{errors}");
        has(&out, [ended]);
    }
}
