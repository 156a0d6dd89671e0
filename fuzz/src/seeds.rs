//! What the fuzzers begin with: sound inputs of every reader, made by the program itself.

use std::path::Path;

use serde_json::json;

use crossgrain::checks::record::{self, Found};
use crossgrain::checks::{Check, Outcome};
use crossgrain::run::folder::record::Protocol;
use crossgrain::run::recorded;
use crossgrain::study::campaign::Member;
use crossgrain::study::member::Beds;
use crossgrain::study::realization::{Engines, Setting, Specification};
use crossgrain::study::{Study, candidates, search, store, tradeoff};
use crossgrain::tables::{write_bodies, write_contacts};
use grains::generate::initial_bodies;
use grains::native;
use grains::scene::Scene;
use grains::tables::{Contact, Snapshot};
use grains::task::{self, Observer, Task};

use super::parts::{join, packed};
use super::{campaign, parts, run_folder, small, studies};

/// Sound inputs: target, name, input.
pub fn all() -> Vec<(&'static str, String, Vec<u8>)> {
    let mut seeds = Vec::new();
    let mut seed = |target, name: &str, input| seeds.push((target, name.to_owned(), input));
    let scene = small::scene();
    seed("scene", "four", json_of(&scene).into_bytes());
    let whole = folder(&scene, Protocol::Whole);
    let short = folder(&scene, Protocol::Steps { steps: 10 });
    for (name, files) in [("whole", &whole), ("short", &short)] {
        seed("run_folder", name, run_seed(files, false));
        seed(
            "run_folder",
            &format!("{name}-repaired"),
            run_seed(files, true),
        );
    }
    for (kind, name) in [
        (b'b', "bodies.csv"),
        (b'c', "contacts.csv"),
        (b'h', "history.csv"),
        (b't', "trace.csv"),
    ] {
        let table = file(&whole, name).expect("every run has it");
        seed("tables", name, [&[kind], table].concat());
        let packed = [&[kind.to_ascii_uppercase()], &*packed(table)].concat();
        seed("tables", &format!("{name}.gz"), packed);
    }
    for (repair, name) in [(false, "three"), (true, "three-repaired")] {
        seed("plan", name, plan_seed(repair));
    }
    let members = members();
    seed("campaign", "three", campaign_seed(&members));
    seed("campaign", "merged", merged_seed(&members));
    for (name, input) in rows() {
        seed("rows", name, input.into_bytes());
    }
    for (name, input) in studies() {
        seed("studies", name, input);
    }
    seed("record", "verify", record().into_bytes());
    let track = track(&scene);
    let description = json!({"protocol": 1, "name": "toy", "version": "1", "parts": ["normal_spring", "gravity", "walls"],
        "approximations": ["none to speak of"]});
    seed(
        "exec",
        "describe",
        join(&[("describe", description.to_string().as_bytes())]),
    );
    seed("exec", "scene", exec_seed(&track, false));
    seed("exec", "case", exec_seed(&track, true));
    seed("yade", "scene", yade_seed(&track, false));
    seed("yade", "case", yade_seed(&track, true));
    seeds
}

fn json_of(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).expect("it is JSON")
}

type Files = Vec<(String, Vec<u8>)>;

fn file<'a>(files: &'a Files, name: &str) -> Option<&'a [u8]> {
    let found = files.iter().find(|(found, _)| found == name);
    found.map(|(_, bytes)| bytes.as_slice())
}

/// The files of a native run.
fn folder(scene: &Scene, protocol: Protocol) -> Files {
    let run = recorded(
        scene,
        &native::Options::default(),
        protocol,
        initial_bodies(scene),
        Path::new(""),
        &mut |_, _, _| {},
    )
    .expect("a run that finishes");
    let place = parts::folder();
    let out = place.path().join("run");
    run.write(&out).expect("a writable folder");
    files_of(&out)
}

fn files_of(folder: &Path) -> Files {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder that is there") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy();
        files.push((name.into_owned(), std::fs::read(&path).expect("readable")));
    }
    files.sort();
    files
}

fn run_seed(files: &Files, repair: bool) -> Vec<u8> {
    let mut parts: Vec<(&str, &[u8])> = Vec::new();
    if repair {
        parts.push(("repair", b""));
    }
    for name in run_folder::FILES {
        if let Some(bytes) = file(files, name) {
            parts.push((name, bytes));
        }
    }
    join(&parts)
}

fn plan_seed(repair: bool) -> Vec<u8> {
    let place = parts::folder();
    let out = place.path().join("campaign");
    small::plan().write(&out).expect("a writable folder");
    let text = std::fs::read(out.join("plan.json")).expect("what was written");
    let mut parts: Vec<(&str, &[u8])> = vec![("plan.json", &text)];
    if repair {
        parts.insert(0, ("repair", b""));
    }
    join(&parts)
}

/// The members of the small plan.
fn members() -> Vec<Member> {
    let plan = small::plan();
    let work = parts::folder();
    let member = |number| {
        let made = plan.study.run(number, &Engines::default(), work.path());
        made.expect("a member")
    };
    (1..=plan.study.members).map(member).collect()
}

/// Lines whose checks are put right: `* MEMBER JSON`.
fn campaign_seed(members: &[Member]) -> Vec<u8> {
    let plan = small::plan().digest();
    let starred = |member: &Member| format!("* {} {}\n", member.member, json_of(member));
    let sound = store::line(&plan, 1, &json_of(&members[0])) + "\n";
    let [first, second] = campaign::RECORDS;
    let rest = starred(&members[1]) + &starred(&members[2]);
    join(&[(first, sound.as_bytes()), (second, rest.as_bytes())])
}

fn merged_seed(members: &[Member]) -> Vec<u8> {
    let lines: String = members
        .iter()
        .map(|member| json_of(member) + "\n")
        .collect();
    join(&[("repair", b""), ("members.jsonl", lines.as_bytes())])
}

/// A study of each kind that has one bed on two clouds, with its rows.
fn studies() -> [(&'static str, Vec<u8>); 3] {
    let setting = |clouds| {
        let specification = Specification::native(small::scene());
        Setting::new("one", "one", "candidates", specification, clouds)
    };
    let beds = Beds(vec![vec![setting(2)]]);
    let candidates = candidates::Plan {
        beds,
        ladders: Vec::new(),
    };
    let size = search::Size {
        beds: 2,
        loads: 1,
        clouds: 1,
    };
    let search = search::Plan::first(small::scene(), size);
    let tradeoff = tradeoff::plan::Plan::new(small::scene(), 1, 0);
    [
        ("candidates", with_rows(&candidates)),
        ("search", with_rows(&search)),
        ("tradeoff", with_rows(&tradeoff)),
    ]
}

/// With the rows of its first two tasks.
fn with_rows<S: Study>(plan: &S) -> Vec<u8> {
    let work = parts::folder();
    let row = |number| {
        let made = plan.run(number, &Engines::default(), work.path());
        (number, made.expect("a row"))
    };
    let rows: Vec<(u64, S::Row)> = (1..=plan.count().min(2)).map(row).collect();
    studies::seed(plan, &rows)
}

/// A record with a check of each kind.
fn record() -> String {
    let number = Check::of_words("suite/drop", "height", Outcome::Pass, "");
    let found = Found {
        checks: vec![
            number.with_limits(1.0, 1.0, Some(0.1)).required(),
            Check::of_words("suite/words", "a refusal", Outcome::Skipped, "no engine"),
        ],
        ..Found::default()
    };
    let own = json!({"crossgrain": "0.1.0", "command": "crossgrain verify"});
    let written = record::write("verify", &own, "any".to_owned(), found);
    written.expect("a sound record").0
}

fn rows() -> [(&'static str, String); 2] {
    let member = json!({"specification": "abc", "realization": 1, "ending": {"failed": "a reason"}, "pour_steps": 10,
        "load_steps": 2, "cost": {"cpu_seconds": 1.5, "measuring_seconds": 0.1}, "measured": {"a": 0.1}});
    [
        ("tradeoff", format!("t{member}")),
        ("loads", format!("s{}", json!([member]))),
    ]
}

#[derive(Default)]
struct Keep(Vec<Snapshot>);

impl Observer for Keep {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        self.0.push(snapshot.clone());
    }
}

/// Start and end of ten steps; grains in flight touch nothing, so that a contact with the floor is put in.
fn track(scene: &Scene) -> Vec<Snapshot> {
    let mut keep = Keep::default();
    let task = Task::pour(initial_bodies(scene), 10);
    let _: task::Outcome =
        native::run(scene, &task, &native::Options::default(), &mut keep).expect("ten steps");
    for moment in &mut keep.0 {
        moment.contacts = vec![Contact {
            id1: 6,
            id2: 0,
            overlap: 1.0e-6,
            normal_force: 2.0,
            tangential_force: 0.0,
            normal: [0.0, 1.0],
            point: [moment.bodies.x[0], 0.0],
        }];
    }
    keep.0
}

const END: &str = r#"{"end": "settle", "steps": 10, "stop": "steps_done", "wall_seconds": 0.5, "cpu_seconds": 0.4}"#;

fn exec_seed(track: &[Snapshot], case: bool) -> Vec<u8> {
    let place = parts::folder();
    let mut lines = String::new();
    for moment in track {
        let step = moment.step;
        let name = |table: &str| place.path().join(format!("settle-{step}-{table}.csv"));
        write_bodies(&name("bodies"), &moment.bodies).expect("a writable folder");
        write_contacts(&name("contacts"), &moment.contacts, &[]).expect("a writable folder");
        lines += &format!(
            "{}\n",
            json!({"stage": "settle", "step": step, "punch": null})
        );
    }
    if !case {
        lines += &format!("{END}\n");
    }
    let files = files_of(place.path());
    let mut parts: Vec<(&str, &[u8])> = Vec::new();
    if case {
        parts.push(("case", b""));
    }
    parts.push(("moments.jsonl", lines.as_bytes()));
    parts.push(("done.json", br#"{"steps": 10}"#));
    for (name, bytes) in &files {
        parts.push((name, bytes));
    }
    join(&parts)
}

fn yade_seed(track: &[Snapshot], case: bool) -> Vec<u8> {
    let mut lines = String::new();
    let mut binary = Vec::new();
    let mut table = |numbers: &[f64]| {
        numbers
            .iter()
            .for_each(|number| binary.extend(number.to_le_bytes()))
    };
    let effective = json!({"contacts": [], "mass": track[0].bodies.mass, "inertia": [], "gravity": [0.0, -9.81],
        "alpha": 0.2, "dt": 1e-5});
    let effective = effective.to_string();
    for moment in track {
        let Snapshot {
            step,
            bodies,
            contacts,
            ..
        } = moment;
        for column in [&bodies.x, &bodies.z, &bodies.vx, &bodies.vz] {
            table(column);
        }
        for contact in contacts {
            let ids = [f64::from(contact.id1), f64::from(contact.id2)];
            let [[nx, nz], [x, z]] = [contact.normal, contact.point];
            let forces = [contact.normal_force, contact.tangential_force];
            table(&[
                ids[0],
                ids[1],
                contact.overlap,
                forces[0],
                forces[1],
                nx,
                nz,
                x,
                z,
            ]);
        }
        let mut line = json!({"stage": "settle", "step": step});
        if case {
            line["loads"] = json!(vec![[0.0; 3]; bodies.len()]);
        }
        line["contacts"] = contacts.len().into();
        line["out_of_plane"] = 0.0.into();
        line["punch"] = serde_json::Value::Null;
        lines += &format!("{line}\n");
    }
    if !case {
        lines += &format!("{END}\n");
    }
    let mut parts: Vec<(&str, &[u8])> = Vec::new();
    if case {
        parts.push(("case", b""));
        parts.push(("effective.json", effective.as_bytes()));
    }
    parts.push(("moments.jsonl", lines.as_bytes()));
    parts.push(("done.json", br#"{"steps": 10}"#));
    // Its last line's end is taken off again.
    binary.push(b'\n');
    parts.push(("tables.bin", &binary));
    join(&parts)
}
