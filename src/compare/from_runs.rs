//! What two run folders are judged by where bits may differ: states of these very runs as starts for their engines, and the whole
//! run made again by the native engine with rounding errors, at every moment that the folders have.

use crate::checks::{Check, Outcome};
use crate::engine::{EngineRecord, ProgramError};
use crate::files::work_folder;
use crate::run::continued::Continued;
use crate::run::folder::record::Protocol;
use crate::run::folder::{Moment, RunFolder};
use crate::run::{EngineError, recorded};
use evidence::in_parallel;
use evidence::moments::{mean, standard_deviation};
use grains::generate::{can_turn, initial_bodies};
use grains::measure::HistoryRow;
use grains::model::Model;
use grains::native::{self, NativeError, Noise, first_contact_punch};
use grains::scene::Scene;
use grains::tables::{Bodies, Contact, Memories, Punch, Snapshot, Stage, StopReason};
use grains::task::{Case, Observer, Seen, Start, Task};
use verdict::contacts;
use verdict::envelope::{Resolution, of_replica};
use verdict::excerpt::Excerpt;
use verdict::judge::Reference;
use verdict::starts::{MOMENTS, State};

/// The starts of two runs of one scene: their common beginning, the moment at which A is liveliest, and where each has settled and
/// ended. Contacts begin to remember in them.
pub fn states(a: &RunFolder, b: &RunFolder) -> Result<Reference, NativeError> {
    let scene = &a.scene;
    let mut states = Vec::new();
    let mut add = |start: String, key: &str, stage: Stage, bodies: &Bodies, punch| {
        states.push(State {
            law: format!("the scene's model, stage {}", stage.name()),
            case: case_of(scene, &start, stage, bodies, punch),
            start,
            key: key.to_owned(),
            probed: true,
            drawn: false,
            faster: 1.0,
        });
    };
    add(
        "initial.csv".to_owned(),
        "initial",
        Stage::Settle,
        &a.initial,
        None,
    );
    let mut excerpts = vec![Excerpt::new(
        "initial.csv, as a scene",
        "excerpt-initial",
        scene,
        start_of(a),
    )];
    let lively = |row: &&HistoryRow| row.stage == Stage::Settle && row.contacts > 0;
    let rows = a.history.iter().filter(lively);
    let liveliest = rows.max_by(|a, b| {
        let weight = |row: &HistoryRow| row.kinetic_energy * row.contacts as f64;
        weight(a).total_cmp(&weight(b))
    });
    if let Some(row) = liveliest.filter(|row| row.step > 0) {
        let task = Task::pour(start_of(a), row.step);
        let last = native::run(scene, &task, &native::Options::default(), &mut ())?.last;
        let start = format!(
            "its liveliest moment, step {}, as native pours it",
            row.step
        );
        add(start, "liveliest", Stage::Settle, &last.bodies, None);
        let title = "its liveliest moment, as a scene";
        // Some engines count their own steps alone.
        let from = Start {
            step: 0,
            memory: Memories::default(),
            ..last.into()
        };
        excerpts.push(Excerpt::new(
            title,
            "excerpt-liveliest",
            scene,
            from.clone(),
        ));
        if a.settled.is_some() || b.settled.is_some() {
            let title = "from its liveliest moment into loading, as a scene";
            excerpts.push(Excerpt::into_loading(
                title,
                "excerpt-into-loading",
                scene,
                from,
            ));
        }
    }
    let runs = [("A", "a", a), ("B", "b", b)];
    let count = if a.last == b.last { 1 } else { 2 };
    for (name, key, run) in runs.into_iter().take(count) {
        if let Some(Moment { bodies, .. }) = &run.settled {
            let (start, key) = (format!("{name}'s settled bed"), format!("settled-{key}"));
            add(start, &key, Stage::Settle, bodies, None);
            let loading = Start {
                stage: Stage::Load,
                ..bodies.clone().into()
            };
            let (title, key) = (
                format!("{name}'s settled bed, loading as a scene"),
                format!("excerpt-{key}"),
            );
            // Of a job that starts with loading nobody says whose constants its first forces have.
            if !scene.has_stages() {
                excerpts.push(Excerpt::new(&title, &key, scene, loading.clone()));
                let (title, key) = (
                    format!("{name}'s settled bed, loading to its end"),
                    format!("{key}-to-end"),
                );
                excerpts.extend(Excerpt::to_end(&title, &key, scene, loading)?);
            } else {
                let from = Start::from(bodies.clone());
                let (title, key) = (
                    format!("{name}'s settled bed, into loading to its end"),
                    format!("excerpt-{key}-to-end"),
                );
                let into = Excerpt::into_loading(&title, &key, scene, from);
                excerpts.extend(into.ended_by_the_force()?);
            }
        }
        let punch = punch_at_end(run);
        let stage = punch.map_or(Stage::Settle, |_| Stage::Load);
        add(
            format!("{name}'s last state"),
            &format!("last-{key}"),
            stage,
            &run.last.bodies,
            punch,
        );
    }
    // States of one model stand together, those of loading last.
    states.sort_by_key(|state| state.law.ends_with(Stage::Load.name()));
    Ok(Reference::of(states, excerpts))
}

/// A state of a run, under the scene's model in this stage.
fn case_of(scene: &Scene, name: &str, stage: Stage, bodies: &Bodies, punch: Option<Punch>) -> Case {
    let model = Model::in_stage(scene, stage);
    let mut bodies = bodies.clone();
    if model.law.rotates() {
        can_turn(scene, &mut bodies);
    } else {
        bodies.do_not_turn();
    }
    Case {
        name: name.to_owned(),
        model,
        bodies,
        punch,
        moments: MOMENTS.to_vec(),
    }
}

/// What the scene has and no contact of the run's own moments shows, so that equal bits say nothing of it.
pub fn never_acts(run: &RunFolder) -> Option<String> {
    let moments = || run.settled.iter().chain([&run.last]);
    let contacts = || moments().flat_map(|moment| &moment.contacts);
    let case = case_of(&run.scene, "", Stage::Load, &run.initial, None);
    let grains = run.initial.len() as u32;
    let walls = grains + case.model.walls.len() as u32;
    let obstacles = walls..walls + case.model.obstacles.len() as u32;
    let touches = contacts().next().is_some() || run.history.iter().any(|row| row.contacts > 0);
    let rubs = contacts().any(|contact| contact.tangential_force != 0.0);
    let meets = contacts().any(|contact| obstacles.contains(&contact.id1));
    let missing = [
        ("a contact", !touches),
        (
            "a tangential force",
            touches && case.model.law.has_friction() && !rubs,
        ),
        (
            "a contact at an obstacle",
            touches && !obstacles.is_empty() && !meets,
        ),
    ];
    let missing: Vec<&str> = missing
        .iter()
        .filter(|(_, is)| *is)
        .map(|(what, _)| *what)
        .collect();
    let said = "no moment has";
    (!missing.is_empty()).then(|| format!("{said} {}", missing.join(", nor ")))
}

/// Whether the contact tables of a run's states follow from its grains; the id of the check ends in this. Without a measured resolution
/// numbers that single precision explains decide nothing. An error where the tables cannot be made anew.
pub fn contact_tables(
    run: &RunFolder,
    id: &str,
    measured: Option<Resolution>,
) -> Result<Check, String> {
    let has_loading = run
        .record
        .stages
        .iter()
        .any(|stage| stage.stage == Stage::Load);
    let punch = punch_at_end(run);
    if run.record.softened.is_some() {
        return Err("it was poured with softer springs than the scene's".to_owned());
    }
    if has_loading && punch.is_none() {
        return Err("without its settled bed nobody knows where the punch is".to_owned());
    }
    let stage = punch.map_or(Stage::Settle, |_| Stage::Load);
    let settled = run.settled.iter();
    let settled = settled.map(|moment| ("the settled bed", Stage::Settle, moment, None));
    let states = settled.chain([("the last state", stage, &run.last, punch)]);
    let mut decided = (Outcome::Pass, "they follow from the grains".to_owned());
    for (name, stage, moment, punch) in states {
        let case = case_of(&scene_of(run), name, stage, &moment.bodies, punch);
        let bodies = &moment.bodies;
        let places = bodies.x.iter().chain(&bodies.y).chain(&bodies.z);
        let extent = places.fold(0.0, |most: f64, coordinate| most.max(coordinate.abs()));
        let wrong = |resolution: Resolution| {
            let table = contacts::Table {
                contacts: &moment.contacts,
                across: &moment.across,
            };
            contacts::contradiction(&case, table, resolution.length(extent))
                .map_err(|error| error.to_string())
        };
        let Some(why) = wrong(measured.unwrap_or(Resolution::DOUBLE))? else {
            continue;
        };
        let why = format!("in {name} {why}");
        if measured.is_some() || wrong(Resolution::SINGLE)?.is_some() {
            decided = (Outcome::Fail, why);
            break;
        }
        decided = (Outcome::Skipped, why);
    }
    let (outcome, found) = decided;
    let what = format!("{}'s contact tables", id.to_uppercase());
    let check = Check::of_words(format!("contacts-{id}"), &what, outcome, &found);
    Ok(check.required().judged_by(
        "pairs, overlaps, normals, points and normal forces of springs made anew from the grains that were written; tangential forces by \
         their limit",
        "rounding of lengths in the engine's precision",
    ))
}

/// What the stretches of a run say that the native engine made too; none of a run that has no such. Without a measured resolution those
/// that single precision explains decide nothing.
pub fn stretches(run: &RunFolder, id: &str, measured: Option<Resolution>) -> Option<Check> {
    let all = &run.record.continued;
    let what = format!("{}'s run, gone on with by native", id.to_uppercase());
    let id = format!("stretches-{id}");
    if all.is_empty() {
        let why = "none of its steps: rounding grows too far between its moments (a scene with a smaller measurement.history_every has more), \
                   or it is too large";
        let is_other = matches!(run.record.engine, EngineRecord::Exec { .. });
        let nothing = || Check::of_words(id, &what, Outcome::Skipped, why).required();
        return is_other.then(nothing);
    }
    let left = |resolution: Resolution| all.iter().find(|stretch| !stretch.is_rounding(resolution));
    let in_words = |stretch: &Continued| {
        let (stage, from, to) = (stretch.stage.name(), stretch.from, stretch.to);
        format!(
            "from step {from} to {to} of stage {stage}: {}",
            stretch.found
        )
    };
    let (outcome, found) = match (left(measured.unwrap_or(Resolution::DOUBLE)), measured) {
        (None, _) => {
            let found = format!(
                "equal to rounding {}; nothing is said of all other steps",
                reached(run, all)
            );
            (Outcome::Pass, found)
        }
        (Some(stretch), None) if left(Resolution::SINGLE).is_none() => {
            (Outcome::Skipped, in_words(stretch))
        }
        (Some(stretch), _) => (Outcome::Fail, in_words(stretch)),
    };
    let check = Check::of_words(id, &what, outcome, &found);
    Some(check.required().judged_by(
        "native runs from moments of this very run, and replicas of them with rounding errors, against what the run told next",
        "up to three moments a stretch: one in each doubling of the steps, and the end of each stage",
    ))
}

/// How many steps of each stage stretches look at, and up to where.
fn reached(run: &RunFolder, all: &[Continued]) -> String {
    let of_stage = run.record.stages.iter().map(|report| {
        let (stage, steps) = (report.stage.name(), report.steps);
        let own: Vec<&Continued> = all
            .iter()
            .filter(|stretch| stretch.stage == report.stage)
            .collect();
        let followed: u64 = own.iter().map(|stretch| stretch.to - stretch.from).sum();
        match own.iter().map(|stretch| stretch.to).max() {
            Some(to) => {
                format!("in {followed} of {steps} steps of stage {stage}, up to step {to}")
            }
            None => format!("in none of stage {stage}"),
        }
    });
    of_stage.collect::<Vec<_>>().join(", ")
}

/// The same of a scene alone, as native runs it.
pub fn states_of(scene: &Scene) -> Result<Reference, EngineError> {
    let work = work_folder().map_err(ProgramError::File)?;
    let native = native::Options::default();
    let (start, mut quiet) = (initial_bodies(scene), |_, _, _| ());
    let run = recorded(
        scene,
        &native,
        Protocol::Whole,
        start,
        work.path(),
        &mut quiet,
    )?;
    Ok(states(&run, &run)?)
}

/// The scene as the run's engine computes it, by the rules that it declares.
fn scene_of(run: &RunFolder) -> Scene {
    let mut scene = run.scene.clone();
    scene.rules = run.record.engine.rules().over(scene.rules);
    scene
}

/// What a run began with.
fn start_of(run: &RunFolder) -> Start {
    let softened = run.record.softened.as_ref();
    Start {
        seen: Seen {
            energy: softened.map_or(0.0, |softened| softened.energy_seen),
            ..Seen::default()
        },
        ..run.initial.clone().into()
    }
}

/// The punch where it ended, from the settled bed that it came down on and the depth to which it went.
fn punch_at_end(run: &RunFolder) -> Option<Punch> {
    let depth = run.history.last()?.punch_depth?;
    let punch = first_contact_punch(&run.scene, &run.settled.as_ref()?.bodies);
    let [x, z] = punch.centre;
    Some(Punch {
        centre: [x, z - depth],
        ..punch
    })
}

/// Native runs of the whole scene, the first without noise.
pub struct Replicas {
    runs: Vec<RunFolder>,
    /// What an engine's own rounding makes of a length of a metre, m.
    rounding: f64,
}

/// Runs whose grains are farther apart than this, over the radius, have parted for good.
const PARTED: f64 = 0.05;
/// Measures of beds that begin to part differ by less than this share.
const PARTING: f64 = 1.0e-3;

/// A history may have missed the peak of the kinetic energy by this factor.
const FAR_ABOVE: f64 = 3.0;

const REPLICAS: usize = 9;
/// Steps whose errors are made at once: over a whole run that is the same, and it takes a fraction of the time.
const SHAKEN_EVERY: u64 = 50;
/// How many standard deviations of a new run a number may be off. With nine runs a normal number is farther off at the end once in
/// 400,000 times, and on the way, where there are many, once in 10⁸ times.
const AT_END: f64 = 12.0;
const ON_THE_WAY: f64 = 25.0;
/// A share that a few contacts change in a small bed.
const FEW: f64 = 0.05;
/// A share of a number that is rounding, whatever replicas say.
const ROUNDING: f64 = 1.0e-9;

impl Replicas {
    pub fn of(run: &RunFolder, noise: Noise) -> Result<Self, String> {
        let noise = Noise {
            every: SHAKEN_EVERY,
            ..noise
        };
        let runs = in_parallel(REPLICAS, |replica| {
            let engine = native::Options {
                noise: (replica > 0).then(|| of_replica(noise, 2 * replica)),
                ..native::Options::default()
            };
            let work = work_folder().map_err(|error| error.to_string())?;
            let (protocol, start) = (run.record.protocol, start_of(run));
            recorded(
                &scene_of(run),
                &engine,
                protocol,
                start,
                work.path(),
                &mut |_, _, _| (),
            )
            .map_err(|error| error.to_string())
        });
        Ok(Replicas {
            runs: runs.into_iter().collect::<Result<_, _>>()?,
            rounding: 8.0 * noise.position,
        })
    }

    /// Whether this run's history and its end lie among them; the ids of the checks end in this.
    pub fn checks(&self, run: &RunFolder, id: &str) -> [Check; 2] {
        let check = |id: String, what: &str, outside: Option<Outside>, within: String| {
            let (outcome, found) = match outside {
                None => (Outcome::Pass, within),
                Some(Outside { why, open: None }) => (Outcome::Fail, why),
                Some(Outside {
                    why,
                    open: Some(open),
                }) => (
                    Outcome::Skipped,
                    format!("{why}; nothing is decided: {open}"),
                ),
            };
            let check = Check::of_words(id, what, outcome, &found);
            check.required().judged_by(
                "native runs of the whole scene with rounding errors of the engine's size",
                &format!("{REPLICAS} runs; {AT_END} standard deviations at the end, {ON_THE_WAY} on the way"),
            )
        };
        let upper = id.to_uppercase();
        let (outside, count) = self.history(run);
        let within = format!(
            "{count} numbers are within {ON_THE_WAY} standard deviations of {REPLICAS} native runs"
        );
        let history = check(
            format!("history-{id}"),
            &format!("{upper}'s history"),
            outside,
            within,
        );
        let (outside, count) = self.end(run);
        let within = format!(
            "{count} measures of the whole bed are within {AT_END} standard deviations of {REPLICAS} native runs"
        );
        [
            history,
            check(
                format!("end-{id}"),
                &format!("{upper}'s end"),
                outside,
                within,
            ),
        ]
    }

    /// The first number of the history that is outside, and how many were looked at.
    fn history(&self, run: &RunFolder) -> (Option<Outside>, usize) {
        type Number = fn(&HistoryRow) -> Option<f64>;
        // Energies are of all sizes, so their logarithms are looked at.
        let numbers: [(&str, Number, f64); 5] = [
            (
                "the logarithm of the kinetic energy",
                |row| logarithm(row.kinetic_energy),
                0.0,
            ),
            (
                "the logarithm of the elastic energy",
                |row| logarithm(row.elastic_energy),
                0.0,
            ),
            (
                "the potential energy",
                |row| Some(row.potential_energy),
                0.0,
            ),
            (
                "the number of contacts",
                |row| Some(row.contacts as f64),
                2.0,
            ),
            ("the depth of the punch", |row| row.punch_depth, 0.0),
        ];
        let (mut count, mut open) = (0, None);
        // Of each number, how much it varied at most.
        let mut widest = [[0.0f64; 5]; 2];
        for (at, row) in self.runs[0].history.iter().enumerate() {
            let others = self.runs.iter().map(|run| row_like(run, at, row));
            let Some(others) = others.collect::<Option<Vec<&HistoryRow>>>() else {
                continue;
            };
            for (index, (_, number, _)) in numbers.iter().enumerate() {
                let all: Vec<f64> = others.iter().filter_map(|row| number(row)).collect();
                let widest = &mut widest[row.stage as usize][index];
                *widest = widest.max(standard_deviation(&all));
            }
        }
        for (at, row) in run.history.iter().enumerate() {
            let others = self.runs.iter().filter_map(|run| row_like(run, at, row));
            let others: Vec<&HistoryRow> = others.collect();
            for (index, (name, number, floor)) in numbers.into_iter().enumerate() {
                let all: Vec<f64> = others.iter().filter_map(|row| number(row)).collect();
                let Some(value) = number(row).filter(|_| all.len() == REPLICAS) else {
                    continue;
                };
                count += 1;
                if let Some(off) = outside(value, &all, ON_THE_WAY, floor + self.rounding) {
                    let (stage, step) = (row.stage.name(), row.step);
                    let why = format!("{stage} {step}: {name} {off}");
                    // Where runs begin to part, some part by far more than others.
                    let away = (value - mean(&all)).abs();
                    let little = 10.0 * PARTING * (1.0 + mean(&all).abs());
                    let parts = self.begin_to_part() && away <= little;
                    if !(parts || away <= ON_THE_WAY * widest[row.stage as usize][index]) {
                        return (Some(Outside { why, open: None }), count);
                    }
                    open = open.or(Some(Outside {
                        why,
                        open: Some("native runs begin to part there"),
                    }));
                }
            }
        }
        (open, count)
    }

    /// The measures of the whole bed at the end that are outside, and how many were looked at.
    fn end(&self, run: &RunFolder) -> (Option<Outside>, usize) {
        let stops = |run: &RunFolder| {
            run.record
                .stages
                .iter()
                .map(|report| report.stop)
                .collect::<Vec<_>>()
        };
        if !self.runs.iter().any(|replica| stops(replica) == stops(run)) {
            let why = format!(
                "it ended otherwise: {}, and native: {}",
                run.stages_in_words(),
                self.runs[0].stages_in_words()
            );
            // One of ten runs that are alike may well be the only one of its kind.
            let steps = |run: &RunFolder| run.stages_in_words();
            let vary = self
                .runs
                .iter()
                .any(|run| steps(run) != steps(&self.runs[0]));
            let open = vary.then_some("native runs do not end in one step either");
            return (Some(Outside { why, open }), 0);
        }
        let against = against_rules(run).map(|why| Outside { why, open: None });
        if let Some(outside) = against.or_else(|| self.too_early(run)) {
            return (Some(outside), 0);
        }
        let of_runs: Vec<_> = self.runs.iter().map(RunFolder::quantities).collect();
        let (mut off, mut count, mut far) = (Vec::new(), 0, false);
        for quantity in run.quantities() {
            let key = quantity.key.as_str();
            let of_bed = key.split_once('.').is_some_and(|(_, measure)| {
                let all = [
                    "height.",
                    "porosity.",
                    "coordination.",
                    "energy.potential",
                    "energy.elastic",
                ];
                all.iter().any(|start| measure.starts_with(start))
            });
            let grains = run.initial.len() as f64;
            let floor = match key {
                "load.punch_depth" => 0.0,
                "settle.steps" => run.scene.settle.check_every as f64,
                // One contact or grain more or less is a threshold that was crossed or not.
                _ if key.contains("coordination") => 4.0 / grains,
                _ if of_bed => 0.0,
                _ => continue,
            };
            let same = of_runs
                .iter()
                .filter_map(|quantities| quantities.iter().find(|quantity| quantity.key == key));
            let all: Vec<f64> = same.map(|quantity| quantity.value).collect();
            if all.len() < REPLICAS {
                continue;
            }
            count += 1;
            let floor = floor + self.rounding;
            if let Some(why) = outside(quantity.value, &all, AT_END, floor) {
                off.push(format!("{key} {why}"));
                let share = (quantity.value - mean(&all)).abs() / mean(&all).abs();
                far |= share > PARTING || share.is_nan();
            }
        }
        type OfRun = fn(&RunFolder) -> Option<f64>;
        let shares: [(&str, OfRun); 2] = [
            ("settled", |run| {
                run.settled.as_ref().and_then(borne_tangentially)
            }),
            ("last", |run| borne_tangentially(&run.last)),
        ];
        for (state, share) in shares {
            let all: Vec<f64> = self.runs.iter().filter_map(share).collect();
            let Some(value) = share(run).filter(|_| all.len() == REPLICAS) else {
                continue;
            };
            count += 1;
            if let Some(why) = outside(value, &all, AT_END, FEW) {
                off.push(format!("Σ|ft|/Σ|fn| in the {state} state {why}"));
                far = true;
            }
        }
        let open = (!far && self.begin_to_part()).then_some("native runs only begin to part there");
        let why = off.join("; ");
        ((!off.is_empty()).then_some(Outside { why, open }), count)
    }
}

/// The row of the same moment, most often at the same place.
fn row_like<'a>(run: &'a RunFolder, at: usize, row: &HistoryRow) -> Option<&'a HistoryRow> {
    let moment = |other: &&HistoryRow| (other.stage, other.step) == (row.stage, row.step);
    let near = run.history.get(at).filter(moment);
    near.or_else(|| run.history.iter().find(moment))
}

impl Replicas {
    /// That it settled before the rule held by the largest energy of a native run at its looks. Where rounding moves that, only what is
    /// far above it decides, and a history that has the looks.
    fn too_early(&self, run: &RunFolder) -> Option<Outside> {
        let mut stages = run.record.stages.iter();
        stages.find(|report| report.stop == StopReason::Settled)?;
        let settled = run.settled.as_ref().unwrap_or(&run.last);
        let rows = |run: &RunFolder| {
            let rows = run.history.iter().filter(|row| row.stage == Stage::Settle);
            rows.fold(0.0, |most: f64, row| most.max(row.kinetic_energy))
        };
        let peaks: Vec<f64> = self.runs.iter().map(rows).chain([rows(run)]).collect();
        let largest = peaks.iter().copied().fold(0.0, f64::max);
        let left = settled.bodies.kinetic_energy();
        let fraction = run.scene.settle.kinetic_energy_fraction;
        if peaks.iter().any(|peak| largest - peak > PARTING * largest) {
            if looks_are_told(&run.scene) {
                return None;
            }
            let why = format!(
                "it settled with {left:e} J left of {largest:e} J at most in its history and native's, and the rule is {fraction:e}"
            );
            let open = "the history has no looks of the rule, as it has with a measurement.history_every that divides settle.check_every";
            let far = left > FAR_ABOVE * fraction * largest;
            return Some(Outside {
                why,
                open: (!far).then_some(open),
            });
        }
        let mut scene = scene_of(run);
        scene.measurement.history_every = scene.settle.check_every;
        let mut looks = Looks(0.0);
        let task = Task::settle(start_of(run));
        native::run(&scene, &task, &native::Options::default(), &mut looks).ok()?;
        let most = fraction * looks.0.max(start_of(run).seen.energy);
        (left > most * (1.0 + 2.0 * PARTING)).then(|| Outside {
            why: format!("it settled with {left:e} J left, and by the largest energy of a native run the rule holds at {most:e} J at most"),
            open: None,
        })
    }

    /// Whether at the end they are farther apart than rounding, and not yet as far as runs get: then some part by far more than others.
    fn begin_to_part(&self) -> bool {
        let [first, others @ ..] = &self.runs[..] else {
            return false;
        };
        let radius = 0.5 * first.scene.particles.mean_diameter;
        let own = &first.last.bodies;
        let apart = others.iter().flat_map(|run| {
            let their = &run.last.bodies;
            let both = own.x.iter().zip(&their.x).chain(own.z.iter().zip(&their.z));
            both.map(|(a, b)| (a - b).abs() / radius)
        });
        let farthest = apart.fold(0.0, f64::max);
        (ROUNDING..PARTED).contains(&farthest)
    }
}

/// The largest kinetic energy at a look of the rule of settling, J.
struct Looks(f64);

impl Observer for Looks {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        if snapshot.step > 0 {
            self.0 = self.0.max(snapshot.bodies.kinetic_energy());
        }
    }
}

/// What is outside, and why nothing follows from it, if nothing does.
struct Outside {
    why: String,
    open: Option<&'static str>,
}

/// Whether the history has every moment at which the rule of settling is looked at.
fn looks_are_told(scene: &Scene) -> bool {
    let every = scene.measurement.history_every;
    scene.settle.check_every.is_multiple_of(every)
}

/// What of a run's end is against the scene's rules, by its own history.
pub fn against_rules(run: &RunFolder) -> Option<String> {
    let (scene, settle) = (&run.scene, &run.scene.settle);
    let ended = |stage, stop| {
        let mut stages = run.record.stages.iter();
        stages
            .find(|report| (report.stage, report.stop) == (stage, stop))
            .map(|report| report.steps)
    };
    if let Some(steps) = ended(Stage::Settle, StopReason::Settled)
        && looks_are_told(scene)
    {
        let looks = run.history.iter().filter(|row| {
            row.stage == Stage::Settle
                && row.step > 0
                && row.step.is_multiple_of(settle.check_every)
        });
        let mut peak = start_of(run).seen.energy;
        let holds = |row: &&HistoryRow| {
            peak = peak.max(row.kinetic_energy);
            // The rule may sum in another order.
            row.kinetic_energy <= settle.kinetic_energy_fraction * peak * (1.0 + ROUNDING)
        };
        let first = looks.clone().find(holds).map(|row| row.step);
        if first != Some(steps) {
            let first = first.map_or("at none of its looks".to_owned(), |step| {
                format!("at step {step}")
            });
            return Some(format!(
                "it settled at step {steps}, and by its own history the rule holds {first} first"
            ));
        }
    }
    let settled = ended(Stage::Settle, StopReason::Settled);
    let settled = settled.map(|_| run.settled.as_ref().unwrap_or(&run.last));
    if let (Some(bed), Some(peak)) = (settled, largest_peak(run)) {
        let left = bed.bodies.kinetic_energy();
        let most = settle.kinetic_energy_fraction * peak;
        if left > most * (1.0 + ROUNDING) {
            return Some(format!(
                "it settled with {left:e} J left, and by its own history the rule holds at {most:e} J at most"
            ));
        }
    }
    let steps = ended(Stage::Load, StopReason::Reached)?;
    let last = run.history.last()?;
    let (force, depth) = (last.punch_force?, last.punch_depth?);
    let target = scene.target_force();
    let moved = (depth / (scene.loading.speed * scene.time_step_seconds())).round() as u64;
    match scene.steps_standing_still() {
        None if force < target * (1.0 - ROUNDING) => Some(format!(
            "it ended with {force:e} N on the punch, and {target:e} N are asked for"
        )),
        Some(standing) if moved + standing != steps => Some(format!(
            "its punch stood still for {} steps, and {standing} are asked for",
            steps.saturating_sub(moved)
        )),
        _ => None,
    }
}

/// What the kinetic energy of pouring had at most, J, by the history: between two rows it may have been above the largest one by as
/// much as that is above its neighbours. None where that one has not two of them.
fn largest_peak(run: &RunFolder) -> Option<f64> {
    let rows = run.history.iter().filter(|row| row.stage == Stage::Settle);
    let energies: Vec<f64> = rows.map(|row| row.kinetic_energy).collect();
    let around = energies
        .windows(3)
        .filter(|window| window[1] >= window[0] && window[1] >= window[2]);
    let peak = around.max_by(|a, b| a[1].total_cmp(&b[1]))?;
    let beyond = energies.iter().any(|energy| *energy > peak[1]);
    let above = peak[1] * peak[1] / peak[0].min(peak[2]);
    (!beyond).then_some(above.max(start_of(run).seen.energy))
}

/// Σ|ft|/Σ|fn| of a state's contacts; none where nothing is pressed.
fn borne_tangentially(moment: &Moment) -> Option<f64> {
    let sum = |force: fn(&Contact) -> f64| {
        moment
            .contacts
            .iter()
            .map(|contact| force(contact).abs())
            .sum::<f64>()
    };
    let [normal, tangential] = [
        sum(|contact| contact.normal_force),
        sum(|contact| contact.tangential_force),
    ];
    (normal > 0.0).then(|| tangential / normal)
}

fn logarithm(energy: f64) -> Option<f64> {
    (energy > 0.0).then(|| energy.ln())
}

/// How far a number is off, if that is more than so many standard deviations of a new run, and than this.
fn outside(value: f64, all: &[f64], deviations: f64, floor: f64) -> Option<String> {
    let (mean, deviation) = (mean(all), standard_deviation(all));
    let of_new = deviation * (1.0 + 1.0 / all.len() as f64).sqrt();
    let most = deviations * of_new + floor + ROUNDING * (1.0 + mean.abs());
    let off = (value - mean).abs();
    let far = off / of_new.max(f64::MIN_POSITIVE);
    // What is no number is outside.
    (off.is_nan() || off > most).then(|| {
        format!("is {value:e}, and native's are {mean:e} ± {deviation:.1e}: {far:.0} standard deviations off")
    })
}
