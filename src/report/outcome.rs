//! What came of one run: why it ended, how high the bed is, the force against the depth, and a picture.

use crate::checks::{Check, Outcome};
use crate::document::{Axis, Colour, Document, Plot, Section, Table, rounded};
use crate::report::packing::pictures;
use crate::run::folder::{Moment, RunFolder};
use grains::measure::{Bed, HistoryRow, mean_surface, twice_centre_of_mass};
use grains::native::first_contact_punch;
use grains::tables::{Stage, StopReason};

/// Beds of more grains have no picture.
const MOST_DRAWN: usize = 20_000;

/// What came of a run, in sentences; `share` is its time step over the largest stable step of its beds, where that is known.
pub fn answer(run: &RunFolder, share: Option<f64>) -> String {
    let mut said = Vec::new();
    for stage in &run.record.stages {
        said.push(match (stage.stop, stage.stage) {
            (StopReason::Settled, _) => format!("The bed settled after {} steps", stage.steps),
            (StopReason::Reached, _) => reached(run, stage.steps),
            (StopReason::TargetLoadNotReached, _) => format!(
                "The punch went down to {} m in {} steps and never had its force of {} N",
                run.scene.loading.give_up_depth,
                stage.steps,
                rounded(run.scene.target_force(), 4)
            ),
            (StopReason::StepsDone, _) => format!("The {} steps asked for are done", stage.steps),
            (StopReason::MaxSteps, Stage::Settle) => format!(
                "The bed had not settled after {} steps, the scene's /settle/max_steps: raise it, or relax \
                 /settle/kinetic_energy_fraction",
                stage.steps
            ),
            (StopReason::MaxSteps, Stage::Load) => {
                format!("Loading had not ended after {} steps", stage.steps)
            }
            (StopReason::Interrupted, _) => {
                format!("It was asked to end after {} steps", stage.steps)
            }
        });
        if stage.stage == Stage::Settle {
            let bed = run.settled.as_ref().unwrap_or(&run.last);
            let (what, height) = match run.scene.in_space() {
                false => ("mean surface", mean_surface(&run.scene, &bed.bodies)),
                true => ("doubled centre of mass", twice_centre_of_mass(&bed.bodies)),
            };
            said.push(format!("Its {what} is {} m high", rounded(height, 4)));
            let heap = run
                .record
                .measures
                .iter()
                .find(|one| one.key.ends_with(".angle"));
            if let Some(angle) = heap {
                said.push(format!(
                    "The angle of the heap is {}°",
                    rounded(angle.value, 3)
                ));
            }
        }
    }
    if let Some(share) = share.filter(|share| *share > 1.0) {
        let smaller = match &run.record.step_choice {
            Some(choice) => format!("--auto-step with less than {}", choice.share),
            None => "a smaller one, or --auto-step".to_owned(),
        };
        said.push(format!(
            "The time step is {share:.3} of the largest stable step of this bed: do not rely on it; take {smaller}"
        ));
    }
    said.join(". ") + "."
}

fn reached(run: &RunFolder, steps: u64) -> String {
    let last = run.history.iter().rev();
    let mut of_load = last.filter(|row| row.stage == Stage::Load);
    let at = of_load.find_map(|row| Some((row.punch_force?, row.punch_depth?)));
    let at = at.map(|(force, depth)| {
        format!(
            ": {} N at a depth of {} m",
            rounded(force, 4),
            rounded(depth, 3)
        )
    });
    let mut said = format!(
        "The punch had its force after {steps} steps{}",
        at.unwrap_or_default()
    );
    let wave = wave_steps(run);
    if steps < wave {
        said += &format!(
            ". That is an impact: a wave takes about {wave} steps through the bed, so the force is that of the grains that the punch \
             struck, not of the bed; lower /loading/speed"
        );
    }
    said
}

/// Steps that a wave takes from the surface to the floor: √(m/k) a grain.
fn wave_steps(run: &RunFolder) -> u64 {
    let scene = &run.scene;
    let radius = 0.5 * scene.particles.mean_diameter;
    let settled = run.settled.as_ref().unwrap_or(&run.last);
    let layers = mean_surface(scene, &settled.bodies) / scene.particles.mean_diameter;
    let modulus = scene.in_stage(Stage::Load).material.youngs_modulus;
    let of_grain = (scene.grain_mass(radius) / (modulus * radius)).sqrt();
    (layers * of_grain / scene.time_step_seconds()).ceil() as u64
}

/// Where the punch's bottom is at the end, m.
pub fn punch_bottom(run: &RunFolder) -> Option<f64> {
    let depth = run.history.last()?.punch_depth?;
    let settled = run.settled.as_ref()?;
    let start = first_contact_punch(&run.scene, &settled.bodies).start;
    Some(start - depth)
}

/// Whether the time step was one that the beds bear.
fn time_step(share: f64) -> Check {
    let outcome = Outcome::pass_if(share <= 1.0);
    let what = "time step over the largest stable step of its beds";
    let mut check = Check::of_words("run/time-step", what, outcome, "");
    (check.value, check.upper) = (Some(share), Some(1.0));
    check.judged_by(
        "the springs of all contacts at the ends of the stages",
        "docs/stability.md",
    )
}

/// The same with pictures and numbers.
pub fn document(run: &RunFolder, share: Option<f64>) -> Document {
    let beyond = share.filter(|share| *share > 1.0);
    let checks: Vec<Check> = beyond.map(time_step).into_iter().collect();
    let moments = [
        ("settled", run.settled.as_ref()),
        ("at the end", Some(&run.last)),
    ];
    let moments = moments
        .into_iter()
        .filter_map(|(name, moment)| Some((name, moment?)));
    let moments: Vec<(&str, &Moment)> = moments.collect();
    let drawn: Vec<(Bed<'_>, Option<f64>, String)> = moments
        .iter()
        .filter(|(_, moment)| moment.bodies.len() <= MOST_DRAWN)
        .map(|(name, moment)| {
            let bottom = punch_bottom(run).filter(|_| *name != "settled");
            (moment.bed(), bottom, format!("The bed {name}"))
        })
        .collect();
    let stages = Table::of("stages", "Stages", &run.record.stages)
        .column("stage", |stage| stage.stage.name())
        .column("steps", |stage| stage.steps)
        .column("time, s", |stage| stage.steps as f64 * run.record.time_step)
        .column("processor time, s", |stage| stage.cpu_seconds);
    let heights = run.record.measures.iter();
    let heights = Table::of("measures", "What was measured", heights)
        .column("", |measure| measure.key.replace(['.', '_'], " "))
        .column("value", |measure| measure.value)
        .column("unit", |measure| &measure.unit);
    let force = Plot::new(
        "force",
        "The punch's force against its depth",
        Axis::linear("depth, m"),
        Axis::linear("force, N"),
    );
    let under = |row: &HistoryRow| Some([row.punch_depth?, row.punch_force?]);
    let points: Vec<[f64; 2]> = run.history.iter().filter_map(under).collect();
    let energy = Plot::new(
        "energy",
        "Kinetic energy while pouring",
        Axis::linear("time, s"),
        Axis::logarithmic("kinetic energy, J"),
    );
    let settling = run.history.iter().filter(|row| row.stage == Stage::Settle);
    let settling = settling.map(|row| [row.time, row.kinetic_energy]);
    let mut bed = Section::new("The bed", "").with_all(pictures(&run.scene, &drawn));
    if drawn.is_empty() {
        bed = bed.with(
            "It has too many grains for a picture; `crossgrain report vtk` gives them to ParaView.",
        );
    }
    let mut course = Section::new("How it went", "");
    if points.len() > 1 {
        let target = run.scene.target_force();
        course = course.with(force.line("", Colour::Blue, points).level(
            "the force that ends loading",
            Colour::Grey,
            target,
        ));
    }
    let course = course.with(energy.line("", Colour::Blue, settling));
    let title = format!("A run of {}: {}", run.record.engine.label(), run.scene.name);
    Document::new(title, answer(run, share), checks).with([
        bed,
        course.with(stages),
        Section::new("Measures", "").with(heights).as_details(),
    ])
}
