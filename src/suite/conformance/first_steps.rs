//! An engine's first hundred steps from a bed, judged, and what is said of them.

use super::Trouble;
use crate::checks::{Check, Outcome};
use crate::document::{Cell, Section, Table};
use crate::engine::ProgramError;
use crate::engine::exec::{self, Description, Options, missing_for_case};
use crate::files::work_folder;
use grains::task::Case;
use verdict::Answer;
use verdict::envelope::{FACTOR, REPLICAS};
use verdict::judge::{Failure, Judgement, Limit, OfStart, Reference, Verdict};

/// The ids of its checks begin with this.
pub const CHECKS: &str = "engine/first-steps/";

/// An engine that refuses a bed is asked for one of so many grains.
const SMALL: u32 = 200;

impl From<Failure<ProgramError>> for Trouble {
    fn from(failure: Failure<ProgramError>) -> Self {
        match failure {
            Failure::Engine(error) => error.into(),
            Failure::Native(error) => error.into(),
        }
    }
}

/// The bed that an engine starts from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfBed {
    /// How many grains.
    pub grains: u32,
    /// How much their radii differ, as a share of the mean radius.
    pub dispersion: f64,
}

/// Judges the engine from a bed, or from a small one if it refuses so many grains.
pub fn first_steps(
    engine: &Description,
    options: &Options,
    bed: OfBed,
    progress: &mut dyn FnMut(&str),
) -> Result<Judgement, Trouble> {
    let OfBed { grains, dispersion } = bed;
    let found = from_bed(
        &Reference::new(grains, dispersion, progress)?,
        engine,
        options,
        progress,
    )?;
    let refused = found.starts.iter().all(|of| of.skipped.is_some());
    if !refused || grains <= SMALL {
        return Ok(found);
    }
    from_bed(
        &Reference::new(SMALL, dispersion, progress)?,
        engine,
        options,
        progress,
    )
}

/// Judges the engine against what is known of a bed.
pub fn from_bed(
    reference: &Reference,
    engine: &Description,
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<Judgement, Trouble> {
    let lacks = |case: &Case| {
        let missing = missing_for_case(engine, case);
        let missing: Vec<&str> = missing.iter().map(|part| part.in_words()).collect();
        (!missing.is_empty()).then(|| missing.join(", "))
    };
    let mut run = |cases: &[&Case]| -> Result<Vec<Answer>, ProgramError> {
        let work = work_folder()?;
        exec::run_cases(cases, engine, options, work.path(), &mut ())
    };
    Ok(reference.judge(&lacks, &mut run, progress)?)
}

/// One for each state.
pub fn checks(of: &Judgement) -> Vec<Check> {
    of.starts.iter().map(check).collect()
}

fn check(of: &OfStart) -> Check {
    let (outcome, found) = match (&of.skipped, of.verdict) {
        (Some(why), Verdict::Different) => (Outcome::Fail, why.clone()),
        (Some(why), _) => (Outcome::Skipped, format!("the engine refused: {why}")),
        (None, Verdict::Different) => (Outcome::Fail, said(of)),
        (None, _) => (Outcome::Pass, said(of)),
    };
    let id = format!("{CHECKS}{}-{}", of.law.name(), of.start.key());
    let quantity = format!("{}, {}", of.law.name(), of.start.name());
    let ratio = of.farthest.as_ref().map_or(f64::NAN, |of| of.ratio);
    Check::of_words(id, &quantity, outcome, &found)
        .with_limits(ratio, 0.0, Some(FACTOR))
        .required()
        .judged_by(
            "the largest distance from the native run over that of replicas with rounding errors as coarse as the engine's",
            &format!("{REPLICAS} replicas; 1, 3, 10, 30 and 100 steps"),
        )
}

fn said(of: &OfStart) -> String {
    let Some(far) = &of.farthest else {
        return String::new();
    };
    match (of.verdict, far.left_after) {
        (Verdict::Identical, _) => "every bit is the native engine's".to_owned(),
        (_, Some(step)) => format!(
            "after {step} {} it is farther off than rounding takes it; farthest, {:.1e} times as far, after {}: the {} of grain {} by {:.1e}",
            if step == 1 { "step" } else { "steps" },
            far.ratio,
            far.step,
            far.quantity.name(),
            far.grain,
            far.apart
        ),
        (_, None) => format!("at most {:.2} times as far off as replicas", far.ratio),
    }
}

/// What it comes to, in a few sentences.
pub fn answer(of: &Judgement) -> String {
    let precision = of.resolution.name();
    let seen = seen(&of.limits);
    let mut said = match of.verdict() {
        Verdict::Different => of
            .causes
            .iter()
            .map(|cause| format!("Its first steps: {}", cause.sentence()))
            .collect::<Vec<_>>()
            .join(" "),
        Verdict::Undecided => {
            let open = of.starts.iter().filter(|of| of.skipped.is_some()).count();
            format!(
                "{open} of {} states were not looked at, for it refused them.",
                of.starts.len()
            )
        }
        Verdict::Identical => {
            format!("every bit of its first hundred steps is the native engine's. {seen}")
        }
        _ => {
            let ratio = of.farthest().and_then(|of| of.farthest.as_ref());
            let ratio = ratio.map_or(0.0, |of| of.ratio);
            format!(
                "in {precision} its first hundred steps are at most {ratio:.2} times as far off as replicas. {seen}"
            )
        }
    };
    if let Some(lacking) = of.not_asked.first() {
        said = format!(
            "{said} Of {} other states nothing is said: it has no {}{}.",
            of.not_asked.len(),
            lacking.lacking,
            if of.not_asked.iter().any(|of| of.lacking != lacking.lacking) {
                " and more"
            } else {
                ""
            }
        );
    }
    said
}

fn seen(limits: &[Limit]) -> String {
    let ends = limits.first().zip(limits.last());
    ends.map_or(String::new(), |(first, last)| {
        format!(
            "A constant that is wrong by more than {:.0e} ({}) to {:.0e} ({}) would have been seen.",
            first.smallest, first.constant, last.smallest, last.constant
        )
    })
}

/// For the page.
pub fn sections(of: &Judgement) -> Vec<Section> {
    let about = format!(
        "A bed of {} grains. The engine computes in {}: it notices changes of {:.1e} m in places, {:.1e} m in overlaps, {:.1e} in \
         velocities. Replicas are native runs with such errors in every step; up to {FACTOR} times their distance is rounding.",
        of.grains,
        of.resolution.name(),
        of.resolution.position,
        of.resolution.overlap,
        of.resolution.velocity
    );
    let starts = Table::of("first-steps", "", of.starts.iter())
        .column("law", |of: &OfStart| of.law.name())
        .column("state", |of| of.start.name())
        .column("verdict", |of| of.verdict.in_words())
        .column("times as far as replicas", |of| {
            of.farthest.as_ref().map(|of| of.ratio)
        })
        .column("left them after, steps", |of| match &of.farthest {
            Some(of) => of.left_after.map_or(Cell::Missing, Cell::Count),
            None => Cell::Missing,
        });
    let limits = Table::of("smallest-faults", "", of.limits.iter())
        .column("constant", |of: &Limit| of.constant)
        .column("smallest fault seen", |of| of.smallest)
        .column("law", |of| of.law.name())
        .column("state", |of| of.start.name());
    let mut sections = vec![
        Section::new("Its first hundred steps", &about).with(Table::from(starts)),
        Section::new(
            "What would have been seen",
            "A constant that is wrong by this share, everywhere, leaves the replicas.",
        )
        .with(Table::from(limits)),
    ];
    if !of.causes.is_empty() {
        let why = Section::new("What is wrong", "");
        sections.push(
            of.causes
                .iter()
                .fold(why, |section, cause| section.with(cause.sentence())),
        );
    }
    sections
}
