//! The chart as a record: the source of its lines, its page and its picture.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::choice::{dominance, recommend};
use super::convergence::{self, Convergence};
use super::job::{self, Job, Members};
use super::judge::{Judgement, judge};
use super::margins::CHARTED;
use super::member::Member;
use super::method::{Method, Runner};
use super::plan::{FIRST_CONFIRMING, Plan};
use crate::error::Error;
use crate::progress::Display;
use crate::run::EngineError;
use evidence::moments::{mean, median};

/// The version of `pareto.json`.
pub const PARETO_VERSION: u32 = 1;

/// What a realization costs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Costs {
    /// Median over the charted realizations of the processor time of the whole protocol, s.
    pub cpu_seconds: f64,
    /// Least and most, s.
    pub range: [f64; 2],
    /// Mean steps of pouring.
    pub pour_steps: f64,
    /// Mean steps of loading.
    pub load_steps: f64,
    /// Median time of measuring, s.
    pub measuring_seconds: f64,
}

/// A method with its costs and its errors.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Point {
    /// Its number in chart and table; the reference has 0.
    pub number: usize,
    /// What it does differently.
    pub method: Method,
    /// Digest of the method, as in `members.jsonl`.
    pub digest: String,
    /// Who ran it, in words.
    pub engine: String,
    /// None if nothing was made.
    pub costs: Option<Costs>,
    /// On the realizations of the chart.
    pub charted: Judgement,
    /// On realizations of its own, where it is a candidate.
    pub confirmed: Option<Judgement>,
    /// The number of the cheapest method with at most its cost and at most its errors of bed and load.
    pub dominated_by: Option<usize>,
    /// Whether one of those errors is smaller beyond both intervals.
    pub clearly: bool,
    /// Why it was not made, or not whole.
    pub not_made: Option<String>,
}

impl Point {
    /// What an engine without a punch did not make of its members, in words.
    pub fn only_poured(&self) -> Option<String> {
        (self.charted.endings.poured > 0).then(|| {
            "loading is not made: the engine has no punch; cost and steps are those of pouring and settling"
                .to_owned()
        })
    }
}

/// A charted quantity in words.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Quantity {
    /// Its key.
    pub key: Cow<'static, str>,
    /// For people.
    pub title: Cow<'static, str>,
    /// SI unit.
    pub unit: Cow<'static, str>,
    /// Of the reference over all of its realizations, with the number of them.
    pub reference: Option<Reference>,
    /// In its unit.
    pub margin: Option<f64>,
    /// Why this margin, or why none.
    pub reason: Cow<'static, str>,
}

/// What the reference gives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Over realizations.
    pub mean: f64,
    /// From realization to realization.
    pub deviation: f64,
    /// How many.
    pub count: usize,
}

/// The chart.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Pareto {
    /// [`PARETO_VERSION`].
    pub version: u32,
    /// Version of crossgrain.
    pub crossgrain: String,
    /// The command as it was given.
    pub command: String,
    /// Processor and cores.
    pub machine: String,
    /// Digest of the reference's scene.
    pub scene_digest: String,
    /// Grains of the reference's scene.
    pub grains: u32,
    /// Realizations of the chart.
    pub charting: u64,
    /// Realizations of the tests of equivalence.
    pub confirming: u64,
    /// What is charted.
    pub quantities: Vec<Quantity>,
    /// What all others are compared with.
    pub reference: Point,
    /// The reference against itself on other clouds: the error that chance alone gives.
    pub chance: Judgement,
    /// All others.
    pub points: Vec<Point>,
    /// Exact cases.
    pub convergence: Vec<Convergence>,
    /// Number of the cheapest candidate that was shown to be equivalent.
    pub recommended: Option<usize>,
    /// What that means, or why there is none.
    pub recommendation: String,
    /// Whether everything of the plan was made.
    pub complete: bool,
    /// Time on the clock of this start of the job, s.
    pub seconds: f64,
}

/// Runs the plan and judges it.
pub fn pareto(plan: &Plan, job: &Job, command: String, display: &Display) -> Result<Pareto, Error> {
    let began = std::time::Instant::now();
    let convergence =
        convergence::all().map_err(|error| Error::Engine(EngineError::Native(error)))?;
    let members = job::run(plan, job, display)?;
    let mut record = of_members(plan, &members, convergence, command);
    record.seconds = began.elapsed().as_secs_f64();
    Ok(record)
}

/// The record of these members.
pub fn of_members(
    plan: &Plan,
    members: &Members,
    convergence: Vec<Convergence>,
    command: String,
) -> Pareto {
    let reference = point(0, &plan.reference, plan.charting, false, plan, members);
    let mut points: Vec<Point> = plan
        .methods
        .iter()
        .enumerate()
        .map(|(index, planned)| {
            let of = &planned.method;
            point(
                index + 1,
                of,
                planned.charting,
                planned.candidate,
                plan,
                members,
            )
        })
        .collect();
    dominance(&mut points);
    let (recommended, recommendation) = recommend(&points, plan.confirming);
    Pareto {
        version: PARETO_VERSION,
        crossgrain: env!("CARGO_PKG_VERSION").to_owned(),
        command,
        machine: machine(),
        scene_digest: plan.reference.scene.digest(),
        grains: plan.reference.scene.particles.count,
        charting: plan.charting,
        confirming: plan.confirming,
        quantities: quantities(plan, members),
        chance: chance(plan, members),
        complete: points.iter().all(|point| point.not_made.is_none()),
        reference,
        points,
        convergence,
        recommended,
        recommendation,
        seconds: 0.0,
    }
}

fn point(
    number: usize,
    method: &Method,
    charting: u64,
    candidate: bool,
    plan: &Plan,
    members: &Members,
) -> Point {
    let own: Vec<&Member> = (1..=charting)
        .filter_map(|realization| members.get(method, realization))
        .collect();
    let digest = method.digest();
    let missing = charting as usize - own.len();
    let why = members.not_made.get(&digest).cloned();
    let confirming = FIRST_CONFIRMING..FIRST_CONFIRMING + plan.confirming;
    let confirmed = candidate && plan.confirming > 0;
    Point {
        number,
        engine: match method.runner {
            Runner::Native(mode) => format!("native, {} mode", mode.name()),
            Runner::YadeSorted => "YADE, sorted loop".to_owned(),
            Runner::YadeOrdinary => "YADE, ordinary loop".to_owned(),
            Runner::Brought => method
                .engine
                .as_ref()
                .map_or("brought".to_owned(), |of| of.described.label()),
        },
        costs: costs(&own),
        charted: judge(
            &pairs(plan, method, 1..=charting, members),
            comparable(plan, method),
        ),
        confirmed: confirmed.then(|| {
            judge(
                &pairs(plan, method, confirming, members),
                comparable(plan, method),
            )
        }),
        dominated_by: None,
        clearly: false,
        not_made: why.or((missing > 0).then(|| format!("{missing} realizations are missing"))),
        method: method.clone(),
        digest,
    }
}

fn pairs<'a>(
    plan: &Plan,
    method: &Method,
    realizations: impl Iterator<Item = u64>,
    members: &'a Members,
) -> Vec<(&'a Member, &'a Member)> {
    realizations
        .filter_map(|realization| {
            let reference = members.get(&plan.reference, realization)?;
            Some((reference, members.get(method, realization)?))
        })
        .collect()
}

fn chance(plan: &Plan, members: &Members) -> Judgement {
    let reference = |realization| members.get(&plan.reference, realization);
    let pairs: Vec<(&Member, &Member)> = (0..plan.charting)
        .filter_map(|index| {
            let other = reference(FIRST_CONFIRMING + index)?;
            Some((reference(1 + index)?, other))
        })
        .collect();
    judge(&pairs, |_| true)
}

fn costs(members: &[&Member]) -> Option<Costs> {
    let of = |figure: fn(&Member) -> f64| -> Vec<f64> {
        members.iter().map(|member| figure(member)).collect()
    };
    let seconds = of(|member| member.cost.cpu_seconds);
    Some(Costs {
        cpu_seconds: median(&seconds)?,
        range: [
            seconds.iter().copied().fold(f64::INFINITY, f64::min),
            seconds.iter().copied().fold(0.0, f64::max),
        ],
        pour_steps: mean(&of(|member| member.cost.pour_steps as f64)),
        load_steps: mean(&of(|member| member.cost.load_steps as f64)),
        measuring_seconds: median(&of(|member| member.cost.measuring_seconds))?,
    })
}

fn quantities(plan: &Plan, members: &Members) -> Vec<Quantity> {
    let all = (1..=plan.charting)
        .chain(FIRST_CONFIRMING..FIRST_CONFIRMING + plan.confirming.max(plan.charting));
    let reference: Vec<&Member> = all
        .filter_map(|realization| members.get(&plan.reference, realization))
        .collect();
    CHARTED
        .iter()
        .map(|charted| {
            let values: Vec<f64> = reference
                .iter()
                .filter_map(|member| member.measured.get(charted.key).copied())
                .collect();
            let found = (values.len() > 1).then(|| Reference {
                mean: mean(&values),
                deviation: evidence::moments::deviation(&values),
                count: values.len(),
            });
            Quantity {
                key: charted.key.into(),
                title: charted.title.into(),
                unit: charted.unit.into(),
                margin: charted
                    .margin
                    .zip(found)
                    .map(|(margin, found)| margin.absolute(found.mean)),
                reference: found,
                reason: charted.reason.into(),
            }
        })
        .collect()
}

/// Heights can be compared only between beds of as many grains over the width.
fn comparable(plan: &Plan, method: &Method) -> impl Fn(&str) -> bool {
    let load =
        |method: &Method| f64::from(method.scene.particles.count) / method.scene.container.width;
    let same_depth = (load(method) / load(&plan.reference) - 1.0).abs() < 1.0e-9;
    move |key| same_depth || !key.starts_with("settled.height.")
}

/// The processor's name and the number of its cores, where the system tells.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or("unknown processor", |(_, name)| name.trim());
    format!("{name}, {cores} cores")
}
