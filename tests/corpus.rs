//! The corpus of engines: right ones in many builds, and wrong ones, each judged as `engine check` judges it. The confusion
//! matrix is printed, and kept in `reference_data/corpus-1.csv` (made anew with CROSSGRAIN_KEEP=1). Nothing right may be called wrong, nothing wrong right, and what is wrong must be named in 19 of 20.

use crossgrain::compare::first_steps::{answer, from_bed};
use crossgrain::engine::exec::{ExternalEngine, Options};
use serde::Deserialize;
use verdict::judge::{Judgement, Reference, Verdict};
use verdict::starts::DISPERSION;

use crate::support::*;

/// Grains of the bed.
const GRAINS: u32 = 300;
/// The share of wrong engines whose cause must be named.
const NAMED: f64 = 0.95;

#[derive(Deserialize)]
struct Corpus {
    right: Vec<Right>,
    wrong: Vec<Wrong>,
}

#[derive(Deserialize)]
struct Right {
    name: String,
    compile: Vec<String>,
    precision: String,
}

#[derive(Deserialize)]
struct Wrong {
    name: String,
    fault: String,
    cause: String,
    factor: Option<f64>,
}

fn here(name: &str) -> PathBuf {
    root("tests/corpus").join(name)
}

fn compiled(folder: &Path, name: &str, flags: &[String]) -> PathBuf {
    compiled_of("engine.c", folder, name, flags)
}

fn compiled_of(source: &str, folder: &Path, name: &str, flags: &[String]) -> PathBuf {
    let program = folder.join(name);
    let mut command = Command::new("cc");
    command.arg("-std=gnu11").args(flags).arg(here(source));
    command.args(["-lm", "-o"]).arg(&program);
    let done = command.output().expect("a C compiler");
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{name}: {said}");
    program
}

fn judged(reference: &Reference, program: PathBuf) -> Judgement {
    let options = Options::new(program);
    let engine = ExternalEngine::ask(options).expect("a description");
    let judgement = from_bed(reference, &engine, &mut |_| ());
    judgement.unwrap_or_else(|error| panic!("{}: {error}", engine.options.program.display()))
}

/// Whether the diagnosis names the cause: a constant with its factor to a part in 10⁹, or words of its own.
fn is_named(judgement: &Judgement, cause: &str, factor: Option<f64>) -> bool {
    let said: String = judgement
        .causes
        .iter()
        .map(|cause| cause.sentence())
        .collect();
    let larger = factor.map(|factor| factor - 1.0);
    let found = |symbol: &str, larger: Option<f64>| {
        let all = judgement.causes.iter().flat_map(|cause| &cause.constants);
        let mut named = all.filter(|fitted| fitted.constant.symbol().starts_with(symbol));
        // Of several walls one.
        named.any(|fitted| larger.is_none_or(|larger| (fitted.larger - larger).abs() <= 1.0e-9))
    };
    let times = |symbols: &[&str]| symbols.iter().all(|symbol| found(symbol, larger));
    // The engine's faulty grain is the one in the middle of its table.
    let alone = format!("it sits on grain {} alone", GRAINS / 2);
    let words: &[&str] = match cause {
        "k_n" => return times(&["k_n between grains", "k_n at walls", "k_n at the punch"]),
        "k_n_grain" => return times(&["k_n between grains"]),
        "k_n_wall" => return times(&["k_n at walls"]),
        "k_n_punch" => return times(&["k_n at the punch"]),
        // Walls that do not give way are twice as stiff.
        "k_n_flat" if said.contains("wall_stiffness = rigid") => return factor == Some(2.0),
        "k_n_flat" => return times(&["k_n at walls", "k_n at the punch"]),
        "k_s" => return times(&["k_s"]),
        "modulus" => return times(&["k_n between grains", "k_n at walls", "k_s"]),
        "tan_phi" => return times(&["tan φ"]),
        "alpha" => return times(&["α"]),
        "gravity" => return times(&["g_z"]),
        "gravity_x" => return found("g_x", factor),
        "wall_place" => return found("place of", factor),
        "punch_speed" => return times(&["velocity of the punch"]),
        "dt" => return times(&["Δt"]),
        "mass" => return times(&["mass"]),
        "density" => return times(&["mass", "moment of inertia"]),
        "inertia" => return times(&["moment of inertia"]),
        "c_n" => return times(&["c_n"]),
        "radius" => return times(&["radius"]),
        // In the larger bed it is another grain.
        "mass_one" if said.contains(&format!("(grain {}, grain", GRAINS / 2)) => &["alone)"],
        "mass_one" | "radius_one" => &[alone.as_str()],
        "half-kick-missing" => &["given_velocities = at_start"],
        "half-kick-doubled" => &["the first kick is 1.5 of one"],
        "kick-missing" => &["the first kick is 0 of one"],
        "drift" => &["integration = "],
        "damping-velocity" => &["damping_velocity = "],
        "damping-off-gravity" => &["damped_gravity = spared"],
        "damping-vector" => &["damping_components = "],
        "damping-off-spin" => &["damped_spins = undamped"],
        "stiffness-mean" => {
            let of_first = said.contains("the stiffness of a pair is E·R1");
            return of_first || said.contains("stiffness_mean = ");
        }
        "wall-missing" => &["of model.walls is not there"],
        // A punch that pushes nothing has no stiffness.
        "punch-missing" => return found("k_n at the punch", Some(-1.0)),
        "punch-corners" => &["corners"],
        "punch-late" => &["the punch moves after the forces"],
        "contacts-lost-near" => &["contacts of grains nearer than"],
        "contacts-lost-far" => &["contacts of grains farther apart than"],
        "contacts-late" => &["contacts are found a step after"],
        "contacts-every" => &["contacts that begin are not found"],
        "normal-old" => &["normals are those of the step before"],
        "places-old" => &["forces are those of the positions before"],
        "written-velocity" => &["written_velocities = whole_step"],
        "third-law" => &["of a pair only"],
        "history-reset" => &["the tangential force is forgotten"],
        "history-not-turned" => &["spring_turn = not_turned"],
        "history-turned-back" => &["the tangential force turns against the normal"],
        "history-length" => &["spring_turn = keeps_length"],
        "history-projected" => &["spring_turn = projected"],
        "slip-not-stretched" => &["slip = unstretched"],
        "torque-arms-flat" => &["torque_arms_at_walls = "],
        "friction-of-lammps" => &[
            "spring_turn = keeps_length",
            "slip = unstretched",
            "torque_arms_at_walls = whole_radii",
        ],
        "coulomb-components" => &["each component of the tangential force"],
        "coulomb-missing" => &["the tangential force is not limited"],
        "slip" => &["slip = "],
        "slip-without-spin" => &["the slip leaves the spins out"],
        "new-contact" => &["new_contact = "],
        "torque-arms" => &["torque_arms"],
        "torque-sign" => &["the torque on the second body"],
        "torque-off-flat" => &["walls and punch do not turn grains"],
        "spin-missing" => &["spins do not change"],
        "coulomb-spring" => &["limit_from = spring"],
        "dashpot-mass" => &["c_n is made from the mean of two masses"],
        "dashpot-whole" => &["tangential_dashpot = "],
        "clipping" => &["tension = "],
        // Not among the forms: nothing that is said can be right.
        _ => &["\u{0}"],
    };
    words.iter().all(|words| said.contains(words))
}

#[test]
fn right_engines_are_equal_to_rounding_and_wrong_ones_are_different_and_named() {
    let corpus: Corpus = serde_json::from_value(json_of(here("corpus.json"))).expect("a corpus");
    let folder = &new_folder();
    let reference = Reference::new(GRAINS, DISPERSION, &mut |_| ()).expect("a bed");
    let (mut false_alarms, mut rows) =
        (Vec::new(), vec!["engine,is,judged,cause named".to_owned()]);
    for right in &corpus.right {
        let engine = compiled(folder, &right.name, &right.compile);
        let judgement = judged(&reference, engine);
        let (name, verdict) = (&right.name, judgement.verdict());
        let farthest = judgement
            .farthest()
            .and_then(|start| start.farthest.as_ref());
        let ratio = farthest.map_or(0.0, |state| state.ratio);
        let (word, precision) = (verdict.in_words(), judgement.resolution.name());
        println!("{name:24} {word}, {precision}, {ratio:.2}");
        rows.push(format!("{name},right,{word},"));
        // In single precision a limit of detection may be too large to agree.
        let is_open = verdict == Verdict::Undecided && !judgement.resolution.is_double();
        let agreed = is_open || [Verdict::Identical, Verdict::EqualToRounding].contains(&verdict);
        if !agreed || !precision.starts_with(&right.precision) {
            false_alarms.push(name);
        }
    }
    let plain = compiled(folder, "sound", &["-O2".to_owned()]);
    let (mut missed, mut unnamed) = (Vec::new(), Vec::new());
    // Every sixth one is judged each time, all of them when the table is made anew.
    let all = std::env::var_os("CROSSGRAIN_KEEP").is_some();
    let every = if all { 1 } else { 6 };
    let of_wrong: Vec<&Wrong> = corpus.wrong.iter().step_by(every).collect();
    for wrong in &of_wrong {
        let Wrong { name, fault, .. } = wrong;
        let engine = plain.display();
        let script = format!("#!/bin/sh\nFAULT='{fault}' exec '{engine}' \"$@\"\n");
        let judgement = judged(&reference, program(folder, format!("{name}.sh"), &script));
        let said: Vec<String> = judgement
            .causes
            .iter()
            .map(|cause| cause.sentence())
            .collect();
        let (word, said) = (judgement.verdict().in_words(), said.join(" "));
        println!("{name:24} {word}: {said}");
        if judgement.verdict() != Verdict::Different {
            missed.push(name);
        }
        let named = is_named(&judgement, &wrong.cause, wrong.factor);
        let yes = if named { "yes" } else { "no" };
        rows.push(format!("{name},wrong,{word},{yes}"));
        if !named {
            unnamed.push(name);
        }
    }
    let (right, wrong) = (corpus.right.len(), of_wrong.len());
    println!("\n                    called right   called different   cause named");
    let (alarms, lost) = (false_alarms.len(), missed.len());
    let (held, seen, named) = (right - alarms, wrong - lost, wrong - unnamed.len());
    println!("right, {right:3}          {held:12} {alarms:18}");
    println!("wrong, {wrong:3}          {lost:12} {seen:18} {named:13}");
    println!("not named: {unnamed:?}");
    let kept = root("reference_data/corpus-1.csv");
    let found = rows.join("\n") + "\n";
    if all {
        fs::write(&kept, &found).expect("writable");
    }
    assert!(false_alarms.is_empty(), "called wrong: {false_alarms:?}");
    assert!(missed.is_empty(), "missed: {missed:?}");
    let enough = named as f64 >= NAMED * wrong as f64;
    assert!(enough, "{named} of {wrong}: {unnamed:?}");
    // Which causes are named may hang on the compiler; which engines there are and how they are judged may not.
    let judged = |table: &str| -> Vec<String> {
        let rows = table.lines().filter_map(|row| row.rsplit_once(','));
        rows.map(|(judged, _)| judged.to_owned()).collect()
    };
    let kept = judged(&text_of(kept));
    let other: Vec<String> = judged(&found)
        .into_iter()
        .filter(|row| !kept.contains(row))
        .collect();
    assert!(other.is_empty(), "judged otherwise than kept: {other:?}");
}

/// An engine of the corpus in space.
#[derive(Deserialize)]
struct InSpace {
    name: String,
    flags: Vec<String>,
    /// What is wrong with it, or which rules it has, as it is told to the engine.
    switch: Option<String>,
    /// A word that says so.
    #[serde(default)]
    term: String,
}

#[derive(Deserialize)]
struct CorpusInSpace {
    right: Vec<InSpace>,
    wrong: Vec<InSpace>,
}

/// Engines of spheres, written from the documents alone. Every sixteenth is judged each time, all of them with CROSSGRAIN_ALL=1, and with
/// CROSSGRAIN_KEEP=1 the table is made anew.
#[test]
fn right_engines_of_spheres_are_equal_to_rounding_and_wrong_ones_are_not() {
    let corpus: CorpusInSpace =
        serde_json::from_value(json_of(here("spheres.json"))).expect("a corpus");
    let folder = &new_folder();
    let reference = verdict::spheres::reference().expect("a bed");
    let keep = std::env::var_os("CROSSGRAIN_KEEP").is_some();
    let all = keep || std::env::var_os("CROSSGRAIN_ALL").is_some();
    // With CROSSGRAIN_ONLY=NAME,NAME wrong ones of these names.
    let only = std::env::var("CROSSGRAIN_ONLY").ok();
    let is_asked = |engine: &&InSpace| {
        let mut names = only.as_deref().into_iter().flat_map(|only| only.split(','));
        only.is_none() || names.any(|name| name == engine.name)
    };
    let every = if all || only.is_some() { 1 } else { 16 };
    let mut rows = vec!["engine,is,judged,term named".to_owned()];
    let (mut alarms, mut missed, mut named, mut count) = (Vec::new(), Vec::new(), 0, 0);
    let right = corpus.right.iter().filter(|_| only.is_none());
    for engine in right.step_by(every) {
        let mut made = compiled_of("spheres.c", folder, &engine.name, &engine.flags);
        if let Some(switch) = &engine.switch {
            let script = format!(
                "#!/bin/sh\nFAULT='{switch}' exec '{}' \"$@\"\n",
                made.display()
            );
            made = program(folder, format!("{}.sh", engine.name), &script);
        }
        let judgement = judged(&reference, made);
        let word = judgement.verdict().in_words();
        println!("{:24} {word}", engine.name);
        rows.push(format!("{},right,{word},", engine.name));
        if ![Verdict::Identical, Verdict::EqualToRounding].contains(&judgement.verdict()) {
            alarms.push(&engine.name);
        }
    }
    let plain = compiled_of("spheres.c", folder, "sound", &["-O2".to_owned()]);
    for engine in corpus.wrong.iter().filter(is_asked).step_by(every) {
        let (name, plain) = (&engine.name, plain.display());
        let fault = engine.switch.as_ref().expect("what is wrong");
        let script = format!("#!/bin/sh\nFAULT='{fault}' exec '{plain}' \"$@\"\n");
        let options = Options::new(program(folder, format!("{name}.sh"), &script));
        let engine_of = ExternalEngine::ask(options).expect("a description");
        let (word, said) = match from_bed(&reference, &engine_of, &mut |_| ()) {
            Ok(judgement) => {
                let said: Vec<String> = judgement
                    .causes
                    .iter()
                    .map(|cause| cause.sentence())
                    .collect();
                let tables = judgement
                    .starts
                    .iter()
                    .filter_map(|start| start.tables.clone());
                let said: Vec<String> = said.into_iter().chain(tables).collect();
                (judgement.verdict().in_words().to_owned(), said.join(" "))
            }
            // Such as numbers that are none.
            Err(error) => ("failed".to_owned(), error.to_string()),
        };
        let is_named = said.contains(&engine.term);
        println!("{name:24} {word}, {is_named}: {said}");
        (named, count) = (named + usize::from(is_named), count + 1);
        rows.push(format!(
            "{name},wrong,{word},{}",
            if is_named { "yes" } else { "no" }
        ));
        if !["different", "failed"].contains(&word.as_str()) {
            missed.push(name);
        }
    }
    println!(
        "{count} wrong, the term named of {named}; called wrong: {alarms:?}; missed: {missed:?}"
    );
    assert!(alarms.is_empty(), "called wrong: {alarms:?}");
    assert!(missed.is_empty(), "missed: {missed:?}");
    let kept = root("reference_data/spheres-1.csv");
    if keep {
        fs::write(&kept, rows.join("\n") + "\n").expect("writable");
    }
    // Which terms are named may hang on the compiler; how engines are judged may not.
    let judged_as = |row: &str| row.rsplit_once(',').map(|(judged, _)| judged.to_owned());
    let kept: Vec<Option<String>> = text_of(kept).lines().map(judged_as).collect();
    let other: Vec<&String> = rows
        .iter()
        .filter(|row| !kept.contains(&judged_as(row)))
        .collect();
    assert!(other.is_empty(), "judged otherwise than kept: {other:?}");
}

/// That spheres are right says nothing of the plane, which such an engine says it has.
#[test]
fn an_engine_that_refuses_the_plane_is_not_agreed_with() {
    let folder = &new_folder();
    let plain = compiled_of("spheres.c", folder, "sound", &["-O2".to_owned()]);
    let script = format!(
        "#!/bin/sh\nFAULT=plane_refused=1 exec '{}' \"$@\"\n",
        plain.display()
    );
    let refusing = program(folder, "refusing.sh", &script);
    let check = format!(
        "engine check exec:{} --grains 100 --quiet",
        refusing.display()
    );
    let (text, _) = ends(folder, 3, &check);
    has(&text, ["Undecided: the engine refused: no plane here"]);
}

#[derive(Deserialize)]
struct Museum {
    faults: Vec<FaultOfACode>,
}

/// A fault that a released code had, made again.
#[derive(Deserialize)]
struct FaultOfACode {
    number: u32,
    part: Option<String>,
    code: String,
    switch: Option<String>,
    /// By which command.
    command: Option<String>,
    found: String,
    /// Words that name it; empty where it is found and not named.
    named: String,
    /// Words that are right though they do not name it.
    partly: Option<String>,
}

/// Of what is said, the sentence with these words, else the first one; shortened.
fn sentence(said: &str, words: &str) -> String {
    let sentences = || {
        said.split_inclusive(". ")
            .flat_map(str::lines)
            .map(str::trim)
    };
    let sentence = sentences().find(|sentence| !words.is_empty() && sentence.contains(words));
    let sentence = sentence
        .or_else(|| sentences().find(|sentence| !sentence.is_empty()))
        .unwrap_or_default();
    match sentence.char_indices().nth(240) {
        Some((end, _)) => {
            sentence[..end]
                .rsplit_once(' ')
                .map_or(sentence, |(sentence, _)| sentence)
                .to_owned()
                + " …"
        }
        None => sentence.to_owned(),
    }
}

/// Faults of real codes that first steps show, each time every third one, with CROSSGRAIN_ALL=1 all of them; of the others
/// `tests/corpus/museum.json` says which command finds them. CROSSGRAIN_KEEP=1 writes what finds each, after how many seconds and
/// with which words, to `reference_data/museum-1.csv`.
#[test]
fn faults_that_real_codes_had_are_found() {
    let museum: Museum = serde_json::from_value(json_of(here("museum.json"))).expect("a museum");
    assert_eq!(
        museum.faults.iter().map(|fault| fault.number).max(),
        Some(26)
    );
    let folder = &new_folder();
    let in_space = verdict::spheres::reference().expect("a bed");
    let planar = Reference::new(GRAINS, DISPERSION, &mut |_| ()).expect("a bed");
    let plain = compiled_of("spheres.c", folder, "sound", &["-O2".to_owned()]);
    let keep = std::env::var_os("CROSSGRAIN_KEEP").is_some();
    let all = keep || std::env::var_os("CROSSGRAIN_ALL").is_some();
    let every = if all { 1 } else { 3 };
    let mut record = csv::Writer::from_writer(Vec::new());
    record
        .write_record(["number", "seconds", "says"])
        .expect("memory");
    let mut write = |fault: &FaultOfACode, seconds: f64, said: &str| {
        let number = format!(
            "{}{}",
            fault.number,
            fault.part.as_deref().unwrap_or_default()
        );
        let words = Some(fault.named.as_str()).filter(|words| !words.is_empty());
        let words = words.or(fault.partly.as_deref()).unwrap_or_default();
        let row = [number, format!("{seconds:.1}"), sentence(said, words)];
        record.write_record(row).expect("memory");
    };
    let is_asked = |fault: &&FaultOfACode| {
        fault.command.as_deref() == Some("engine check") && fault.found == "different"
    };
    let (mut missed, mut unnamed) = (Vec::new(), Vec::new());
    for entry in museum.faults.iter().filter(is_asked).step_by(every) {
        let (fault, plain) = (entry.switch.as_ref().expect("a switch"), plain.display());
        let script = format!("#!/bin/sh\nFAULT='{fault}' exec '{plain}' \"$@\"\n");
        let options = Options::new(program(folder, format!("{fault}.sh"), &script));
        let begun = Instant::now();
        let engine = ExternalEngine::ask(options).expect("a description");
        let bed = if fault.contains("parts=2") {
            &in_space
        } else {
            &planar
        };
        let said = match from_bed(bed, &engine, &mut |_| ()) {
            Ok(found) if found.verdict() == Verdict::Different => answer(&found),
            Ok(_) => String::new(),
            Err(error) => format!("it failed: {error}"),
        };
        println!("{} {}: {said}", entry.number, entry.code);
        if !said.is_empty() {
            write(entry, begun.elapsed().as_secs_f64(), &said);
        }
        if said.is_empty() {
            missed.push(fault);
        } else if !said.contains(&entry.named) {
            unnamed.push(fault);
        }
    }
    println!("not in first steps: {missed:?}; not named: {unnamed:?}");
    if keep {
        // What other commands find.
        let others = museum.faults.iter().filter(|fault| {
            !is_asked(fault)
                || missed
                    .iter()
                    .any(|switch| fault.switch.as_ref() == Some(switch))
        });
        for entry in others {
            let (Some(command), Some(fault)) = (&entry.command, &entry.switch) else {
                continue;
            };
            let path = folder.join(format!("{fault}.sh"));
            let script = format!(
                "#!/bin/sh\nFAULT='{fault}' exec '{}' \"$@\"\n",
                plain.display()
            );
            program(folder, &path, &script);
            let (verb, more) = command
                .split_once(" --")
                .map_or((command.as_str(), String::new()), |(verb, more)| {
                    (verb, format!(" --{more}"))
                });
            let begun = Instant::now();
            let (code, said, _) = say(folder, &format!("{verb} exec:{}{more}", path.display()));
            println!("{} {}, {command}, {code}: {said}", entry.number, entry.code);
            let last = said
                .lines()
                .find_map(|line| line.strip_prefix("DIFFERENT: "));
            if let Some(last) = last {
                write(entry, begun.elapsed().as_secs_f64(), last);
            }
        }
        let text = record.into_inner().expect("memory");
        fs::write(root("reference_data/museum-1.csv"), text).expect("writable");
    }
    // What stands in a program in units of its own shows in other units alone, and what tables do to a run in the relations of an engine
    // with itself.
    let by_relations = ["museum=25,parts=1", "museum=17,parts=1", "museum=8,parts=1"];
    missed.retain(|fault| !by_relations.contains(&fault.as_str()));
    assert!(
        missed.is_empty() && unnamed.is_empty(),
        "missed: {missed:?}, unnamed: {unnamed:?}"
    );
}
