//! Engines end with the program, however it ends, and with them what they have started.

use crate::support::*;

/// The toy, which ignores signals, first starts two others, one in a session of its own, and writes the numbers down; then it does
/// `more`.
fn toy_that_starts_another(folder: &Path, more: &str) -> String {
    let imports = "import csv, json, math, os, sys, time\n";
    let started = folder.join("started");
    let starts = format!(
        "{imports}if sys.argv[1] == 'run':
    import signal, subprocess
    for name in ('HUP', 'INT', 'QUIT', 'TERM'):
        signal.signal(getattr(signal, 'SIG' + name), signal.SIG_IGN)
    other = subprocess.Popen(['sleep', '1000'])
    away = subprocess.Popen(['sleep', '1000'], start_new_session=True)
    with open({started:?}, 'w') as file:
        file.write('%d %d %d\\n' % (os.getpid(), other.pid, away.pid))
    {more}
"
    );
    let toy = changed_toy(imports, &starts);
    engine(folder, "toy.py", &toy)
}

/// Numbers of the processes that were started, once both are written down.
fn pids_in(folder: &Path) -> Vec<u32> {
    let text = || fs::read_to_string(folder.join("started")).unwrap_or_default();
    within(60, "they are started", || text().ends_with('\n'));
    text().split_whitespace().flat_map(str::parse).collect()
}

fn all_end(pids: &[u32], after: &str) {
    let what = format!("they end after {after}");
    within(5, &what, || !pids.iter().any(|pid| is_running(*pid)));
}

#[test]
fn whatever_signal_ends_the_program_nothing_that_it_started_goes_on() {
    for signal in ["TERM", "INT", "HUP", "QUIT", "KILL"] {
        let folder = &folder_with(&narrow_scene(0.0));
        let engine = toy_that_starts_another(folder, "time.sleep(1000)");
        let run = format!("run scene.json --steps 100 --out out --engine {engine}");
        let mut child = started(folder, &run);
        let pids = pids_in(folder);
        assert!(pids.len() == 3 && pids.iter().all(|pid| is_running(*pid)));
        send(&child, signal);
        let status = child.wait().expect("it ends");
        all_end(&pids, signal);
        let code = (signal != "KILL").then_some(75);
        assert_eq!(status.code(), code, "SIG{signal}");
        assert!(!folder.join("out").exists());
    }
}

#[test]
fn what_an_engine_leaves_behind_ends_with_it() {
    let folder = &folder_with(&narrow_scene(0.0));
    let engine = toy_that_starts_another(folder, "pass");
    ran_in(folder, &engine, &["--steps", "100"], "out");
    all_end(&pids_in(folder), "the engine's own end");
}
