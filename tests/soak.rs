//! The main job again and again: nothing may grow, nothing may stay behind, and every run has the bits of the first.

use crate::support::*;

/// What a process was seen to take at most.
#[derive(Debug, Default, Clone, Copy)]
struct Taken {
    /// Resident memory, kB.
    memory: u64,
    /// Open files.
    files: usize,
}

/// The program of the tests, or another one.
fn program() -> PathBuf {
    std::env::var_os("CROSSGRAIN_SOAK_PROGRAM")
        .map_or_else(|| env!("CARGO_BIN_EXE_crossgrain").into(), PathBuf::from)
}

/// The job once, looked at every few milliseconds.
fn once(place: &Path, out: &Path) -> (Option<i32>, Taken) {
    let job = "reproduce --scene scene.json --quiet --recorded --out";
    let mut child = Command::new(program())
        .args(job.words())
        .arg(out)
        .current_dir(place)
        .env("TMPDIR", place.join("temporary"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let files = format!("/proc/{}/fd", child.id());
    let mut taken = Taken::default();
    loop {
        if let Some(status) = child.try_wait().expect("a child of ours") {
            return (status.code(), taken);
        }
        let files = fs::read_dir(&files).map_or(0, Iterator::count);
        taken.memory = taken.memory.max(peak_memory(child.id()));
        taken.files = taken.files.max(files);
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// All tables below a folder but the one of the runs, which has their times.
fn tables(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let is_table = |path: &PathBuf| path.extension().is_some_and(|end| end == "csv");
    let paths = below(folder).into_iter().filter(is_table);
    let tables = paths.filter(|path| !path.ends_with("runs.csv"));
    let table = |path: PathBuf| {
        let name = path.strip_prefix(folder).expect("it is inside").to_owned();
        (name, fs::read(&path).expect("readable"))
    };
    tables.map(table).collect()
}

fn soak(least_runs: usize, least_time: Duration) {
    let place = &new_folder();
    write_scene(&tiny_scene(), &place.join("scene.json"));
    fs::create_dir(place.join("temporary")).expect("ours");
    let began = Instant::now();
    let mut first = None;
    let mut all: Vec<Taken> = Vec::new();
    while all.len() < least_runs || began.elapsed() < least_time {
        let out = place.join("o");
        let (code, taken) = once(place, &out);
        assert_eq!(code, Some(3), "without YADE it is incomplete");
        all.push(taken);
        let found = tables(&out);
        assert!(found.len() >= 5, "{:?}", found.keys());
        match &first {
            None => first = Some(found),
            Some(first) => assert!(*first == found, "run {} has other bits", all.len()),
        }
        fs::remove_dir_all(&out).expect("ours");
        let left: Vec<_> = fs::read_dir(place).expect("ours").flatten().collect();
        assert_eq!(left.len(), 2, "run {} left {left:?}", all.len());
        let temporary = fs::read_dir(place.join("temporary")).expect("ours").count();
        assert_eq!(temporary, 0, "run {} left temporary files", all.len());
        assert_eq!(at_work_in(place), 0, "run {} left a process", all.len());
    }
    let most = |runs: &[Taken]| {
        let memory = runs.iter().map(|run| run.memory).max().unwrap_or(0);
        (memory, runs.iter().map(|run| run.files).max().unwrap_or(0))
    };
    let (early, late) = all.split_at(all.len() / 2);
    let [(before, files_before), (after, files_after)] = [most(early), most(late)];
    println!(
        "{} runs in {:.0} s: memory at most {before} kB in the first half and {after} kB in the second, open files \
         {files_before} and {files_after}; the same bits each time, nothing left",
        all.len(),
        began.elapsed().as_secs_f64()
    );
    assert!(after as f64 <= 1.1 * before as f64 + 1024.0, "memory grows");
    assert!(files_after <= files_before + 2, "open files grow");
}

#[test]
fn the_main_job_three_times_leaves_nothing_behind() {
    soak(3, Duration::ZERO);
}

/// `cargo test --release --test checks -- --ignored --nocapture soak`; `CROSSGRAIN_SOAK_PROGRAM` names another program.
#[test]
#[ignore = "ten minutes"]
fn the_main_job_for_ten_minutes_leaves_nothing_behind() {
    soak(50, Duration::from_secs(600));
}
