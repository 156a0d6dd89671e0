//! Killed, asked to end, or out of room: what was finished stays, what was half-written is not believed.

use super::{
    Chance, MEMBERS, Running, campaign, expected, finishes_as_expected, lines, merged_bytes, must,
    plan, records,
};
use crossgrain::limits::stability::Stability;
use crossgrain::study::change::{What, changed};
use crossgrain::study::realization::{Runner, Setting, Specification};
use crossgrain::study::{Study, candidates, create, search, tradeoff};
use crossgrain::study::{campaign::Campaign, folder::StudyFolder, member::Beds};

use crate::support::*;

/// The whole lines of all record files.
fn written(folder: &Path) -> BTreeSet<Vec<u8>> {
    let mut lines = BTreeSet::new();
    for entry in fs::read_dir(folder.join("records")).expect("records") {
        let bytes = fs::read(entry.expect("a file").path()).expect("readable");
        let whole = bytes.split_inclusive(|byte| *byte == b'\n');
        let whole = whole.filter(|line| line.ends_with(b"\n"));
        lines.extend(whole.map(<[u8]>::to_vec));
    }
    lines
}

/// So often each kind of study is killed: as `CROSSGRAIN_KILLS` says, else 41 times, 205 in all.
fn kills() -> usize {
    let said = std::env::var("CROSSGRAIN_KILLS").ok();
    said.map_or(41, |count| count.parse().expect("a number"))
}

/// The merged rows of the study `c`, made by one process that nobody disturbs.
fn rows_of<S: Study>(study: S) -> Vec<S::Row> {
    let place = &new_folder();
    let folder = place.join("c");
    create(&folder, study, None, None).expect("a new study");
    merged_rows::<S>(place)
}

fn merged_rows<S: Study>(place: &Path) -> Vec<S::Row> {
    // A shard of several is not judged, which is another matter.
    for shard in ["1/2", "2/2"] {
        must(place, "run", &["--shard", shard, "--threads", "2"]);
    }
    must(place, "merge", &[]);
    let merged = StudyFolder::<S>::open(&place.join("c")).and_then(StudyFolder::merged);
    merged.expect("a merged study").rows
}

/// kill -9 at moments that chance chooses, with other shards and threads each time, and where all rows are made while they are
/// merged: it comes to what an undisturbed one comes to. A small study that is done before so many kills is begun anew.
fn survives_kills<S: Study>(planned: impl Fn() -> S) {
    let wanted = rows_of(planned());
    let (all, mut kept) = (kills(), 0);
    let (mut left, mut chance) = (all, Chance(all as u64));
    for _ in 0..all {
        if left > 0 {
            let (kills, lines) = killed(planned(), left, &mut chance, &wanted);
            left -= kills;
            kept += lines;
        }
    }
    assert!(left == 0 && kept > 0, "{}: {left}, {kept}", S::KIND);
    println!("{}: killed {all} times", S::KIND);
}

/// How often the study was killed, at most so often, and how many lines it had then. Moments are counted in rows and a little more,
/// since nobody knows how busy the machine is.
fn killed<S: Study>(
    study: S,
    most: usize,
    chance: &mut Chance,
    wanted: &[S::Row],
) -> (usize, usize) {
    let place = &new_folder();
    let folder = place.join("c");
    create(&folder, study, None, None).expect("a new study");
    let (mut before, mut kills) = (BTreeSet::new(), 0);
    for attempt in 0..10 * most {
        if kills == most {
            break;
        }
        let (shard, threads) = [("1/1", "2"), ("1/2", "1"), ("3/3", "2")][chance.below(3) as usize];
        let merges = attempt % 5 == 4;
        let mut process = match merges {
            true => Running::start(place, &["--threads", "2", "--quiet"]),
            false => Running::start(place, &["--shard", shard, "--threads", threads]),
        };
        let file = records(&folder, if merges { "1/1" } else { shard });
        let wanted = lines(&file) + chance.below(3) as usize;
        while lines(&file) < wanted && process.0.try_wait().expect("a child").is_none() {
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(Duration::from_millis(chance.below(30)));
        // A small shard may be done by now, or all of the study: then this would be no kill.
        match process.0.try_wait().expect("a child") {
            Some(_) if merges => break,
            Some(_) => continue,
            None => {}
        }
        process.kill();
        kills += 1;
        let after = written(&folder);
        assert!(before.is_subset(&after), "{} lost a record", S::KIND);
        before = after;
        if kills % 8 == 0 {
            let (_, said, _) = campaign(place, "status", &["--json"]);
            let status: Value = serde_json::from_str(&said).expect("JSON");
            let finished = status["finished"].as_u64().expect("a number");
            // A torn line that a later process has ended is a whole line and no record; a record that stands twice is one.
            assert!(finished <= before.len() as u64, "{said}");
        }
    }
    let rows = merged_rows::<S>(place);
    assert!(before.is_subset(&written(&folder)));
    assert_eq!(rows.len(), wanted.len(), "{}", S::KIND);
    let same = rows.iter().zip(wanted).all(|(row, own)| S::same(row, own));
    assert!(same, "{} has other rows", S::KIND);
    (kills, before.len())
}

/// Every kind of study, each at its own moments.
#[test]
fn kills_at_any_moment_lose_nothing_finished_and_believe_nothing_half_written() {
    let scene = || {
        let mut scene = tiny_scene();
        scene.particles.count = 50;
        scene.settle.kinetic_energy_fraction = 0.01;
        scene
    };
    let early = || changed(scene(), &[(What::Settled, 0.05)]);
    std::thread::scope(|all| {
        all.spawn(|| survives_kills(|| Campaign::new(&scene(), Runner::Native, Vec::new(), 60, 1)));
        all.spawn(|| {
            survives_kills(|| {
                let mut plan = tradeoff::plan::Plan::new(scene(), 20, 0);
                let early = Specification::native(early());
                plan.add("early", "hardly settled", "settle rule", early, 1);
                plan
            });
        });
        all.spawn(|| {
            let (beds, loads, clouds) = (10, 2, 4);
            let size = search::Size {
                beds,
                loads,
                clouds,
            };
            survives_kills(|| search::Plan::first(search::space::on_both_sides(scene()), size));
            survives_kills(|| {
                let bed = |id: &str, scene| {
                    let scene = Specification::native(scene);
                    vec![Setting::new(id, id, "candidates", scene, 25)]
                };
                let beds = Beds(vec![bed("printed", scene()), bed("early", early())]);
                let ladders = Vec::new();
                candidates::Plan { beds, ladders }
            });
            survives_kills(|| {
                let mut map = Stability::new(true, None, true, false);
                map.scenes.truncate(12);
                map.failures.truncate(4);
                map
            });
        });
    });
}

#[test]
fn asked_to_end_it_ends_soon_and_goes_on_later() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let folder = place.join("c");
    let mut process = Running::start(place, &["--threads", "1"]);
    process.wait_for_lines(&records(&folder, "1/1"), 2);
    let asked = Instant::now();
    send(&process.0, "TERM");
    let (code, errors) = process.end();
    assert_eq!(code, 75, "{errors}");
    let took = asked.elapsed();
    assert!(took < Duration::from_secs(5), "{took:?}");
    let finished = lines(&records(&folder, "1/1"));
    assert!(finished < MEMBERS as usize);
    let message = format!("asked to end; {finished} of {MEMBERS} rows are written down");
    has(&errors, [&message]);
    let said = must(place, "run", &["--threads", "2"]);
    let goes_on = format!("{MEMBERS} rows, {finished} of them finished before");
    has(&said, [&goes_on]);
    assert_eq!(&merged_bytes(&folder), expected());
}

/// A file that may not grow any more stands for a full disk: the write fails in the middle of a record.
#[test]
fn a_full_disk_says_try_again_and_later_goes_on() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let limited = |kilobytes: u32| {
        let script = format!("ulimit -f {kilobytes}; exec \"$0\" study run c --threads 2");
        bash(place, &script, &[])
    };
    let file = records(&place.join("c"), "1/1");
    for (kilobytes, at_least) in [(50, 1), (50, 1), (110, 3)] {
        let (code, _, errors) = limited(kilobytes);
        assert_eq!(code, 75, "{errors}");
        has(&errors, ["cannot write", "shard-1-of-1.jsonl"]);
        let size = fs::metadata(&file).expect("a file").len();
        assert_eq!(size, u64::from(kilobytes) * 1024, "it is full");
        assert!(lines(&file) >= at_least);
    }
    finishes_as_expected(place);
    // Room for the records, and none for merging them.
    for name in ["rows.jsonl", "rows.csv", "merged.json"] {
        fs::remove_file(place.join("c").join(name)).expect("a file");
    }
    let left = || there(&place.join("c"));
    let before = left();
    let (code, _, errors) = limited(100);
    assert_eq!(code, 75, "{errors}");
    assert_eq!(left(), before, "nothing half-merged");
    finishes_as_expected(place);
}
