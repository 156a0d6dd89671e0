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

/// How an engine starts another program, which gets away from it: by a group, a session, parents that end, other surroundings.
const WAYS: &str = r#"
    plainly ⇒ subprocess.Popen(hold)
    in a session of its own ⇒ subprocess.Popen(hold, start_new_session=True)
    by setsid, which ends ⇒ subprocess.run(['setsid', '--fork'] + hold)
    after two parents have ended ⇒ subprocess.run(['sh', '-c', 'setsid sh -c \'"$@" & exit\' - "$@" & exit', '-'] + hold)
    with no surroundings, by parents that end ⇒ subprocess.run(['setsid', '--fork', 'env', '-i'] + hold)
    with no surroundings, in a session of its own ⇒ subprocess.Popen(hold, start_new_session=True, env={})
    by mpirun ⇒ subprocess.Popen(['mpirun', '--allow-run-as-root', '--oversubscribe', '-np', '2'] + hold)
"#;

#[test]
fn memory_is_limited_for_all_that_an_engine_starts() {
    for [way, starts] in rows(WAYS) {
        if way == "by mpirun" && !cfg!(feature = "live") {
            continue;
        }
        let folder = &folder_with(&narrow_scene(0.0));
        let holds = "import time; held = b'x' * (150 << 20); time.sleep(1000)";
        let text = format!(
            "{SOUND}\nif sys.argv[1] == 'describe': SAY()\n\
             hold = [sys.executable, '-c', {holds:?}, {folder:?}]\n{starts}\ntime.sleep(1000)\n",
            folder = folder.display().to_string(),
        );
        let engine = engine(folder, "engine.py", &text);
        let more = "--steps 10 --memory-limit 100 --time-limit 20".words();
        let said = run_in(folder, 4, &engine, &more, "out");
        assert!(said.contains("MB of memory, and 100 MB"), "{way}: {said}");
        within(5, way, || at_work_in(folder) == 0);
    }
}

#[test]
fn an_engine_that_ends_its_parent_at_once_ends_too() {
    let folder = &folder_with(&narrow_scene(0.0));
    let text = "#!/bin/sh\n[ \"$1\" = away ] && exec tail -f $0\nsetsid $0 away &\nkill -KILL $PPID\nsleep 1000\n";
    let engine = engine(folder, "engine.sh", text);
    let run = format!("run scene.json --steps 100 --out out --engine {engine}");
    for time in 1..=200 {
        let ended = started(folder, &run).wait().expect("it ends");
        assert_eq!(ended.code(), None, "it is killed");
        within(5, &format!("it ends too, time {time}"), || {
            at_work_in(folder) == 0
        });
    }
}

#[test]
fn what_a_killed_program_left_is_removed_by_the_next_and_nothing_else_is() {
    let folder = &folder_with(&narrow_scene(0.0));
    let temporary = folder.join("temporary");
    fs::create_dir(&temporary).expect("created");
    let engine = toy_that_starts_another(folder, "time.sleep(1000)");
    let start = |out: &str, engine: &str| {
        let run = format!("run scene.json --steps 100 --out {out} --quiet --engine {engine}");
        let mut program = cli(folder);
        program.env("TMPDIR", &temporary).args(run.words());
        program
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts")
    };
    let litter = || {
        let all = below(folder).into_iter();
        let all = all.filter(|path| {
            path.file_name()
                .is_some_and(|name| name.to_string_lossy().starts_with(".crossgrain.partial-"))
        });
        all.count()
    };
    let mut killed = start("killed", &engine);
    pids_in(folder);
    let left = litter();
    assert!(left >= 1);
    send(&killed, "KILL");
    killed.wait().expect("it ends");
    assert_eq!(litter(), left);
    fs::remove_file(folder.join("started")).expect("removed");
    let at_work = Running(start("at-work", &engine));
    pids_in(folder);
    // What is at work keeps its own.
    let own = litter();
    assert!(start("next", "native").wait().expect("it ends").success());
    assert!(own >= 1 && litter() == own);
    assert!(is_running(at_work.0.id()));
    drop(at_work);
    // Of another machine, or named by hand.
    for name in [
        ".crossgrain.partial-0123456789ab-1-1-x",
        ".crossgrain.partial-mine",
    ] {
        fs::create_dir(folder.join(name)).expect("created");
    }
    assert!(start("last", "native").wait().expect("it ends").success());
    assert_eq!(litter(), 2);
}
