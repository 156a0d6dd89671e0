//! `crossgrain pareto`: cost against error, one point a method.

use std::path::{Path, PathBuf};

use clap::Args;

use super::chosen::Beside;
use super::job_folder::{JobFolder, page_line};
use super::run::YadeLimits;
use super::{exit_code_if, json, tell};
use crate::engine::exec::Brought;
use crate::engine::yade;
use crate::error::Error;
use crate::progress::Display;
use crate::report;
use crate::run::EngineError;
use crate::study::tradeoff::job::Job;
use crate::study::tradeoff::judge::Judgement;
use crate::study::tradeoff::method::Program;
use crate::study::tradeoff::plan::Plan;
use crate::study::tradeoff::record::{Pareto, Point, pareto};

const FOLDER: JobFolder = JobFolder {
    what: "chart",
    usual: "out/pareto",
    record: "pareto.json",
    keeps_members: true,
};
/// Realizations of the chart: the paper's bed, and the small one of `--quick`.
const CHARTING: [u64; 2] = [24, 6];
/// Realizations of each test of equivalence.
const CONFIRMING: u64 = 300;

#[derive(Debug, Args)]
#[command(
    after_help = "Every finished realization is kept in members.jsonl; an interrupted chart is taken up again when it is \
    started with the same --out, and may then have other numbers of realizations.\n\nExamples:\n  crossgrain pareto \
    --quick\n  crossgrain pareto --seeds 8 --confirm 100 --out chart"
)]
pub struct Arguments {
    /// A small bed and few methods
    #[arg(long)]
    quick: bool,
    /// Realizations a method is charted with [default: 24, with --quick 6]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1000))]
    seeds: Option<u64>,
    /// Realizations of its own on which each candidate's equivalence is tested [default: 300, with --quick none]
    #[arg(long, conflicts_with = "quick", value_parser = clap::value_parser!(u64).range(0..=100_000))]
    confirm: Option<u64>,
    /// Realizations in YADE, about five minutes each for the paper's bed; 0 leaves YADE out
    #[arg(long, default_value_t = 1)]
    yade_seeds: u64,
    /// One more engine: exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long)]
    engine: Option<Beside>,
    /// Realizations a method in that engine; without a punch it pours and settles
    #[arg(long, default_value_t = 1, requires = "engine", value_parser = clap::value_parser!(u64).range(1..=1000))]
    engine_seeds: u64,
    /// The folder to write; a finished chart in it is never overwritten
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: YadeLimits,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        self.check()?;
        let brought = match &self.engine {
            Some(Beside(program)) => Some(self.limits.brought(program)?),
            None => None,
        };
        let plan = self.plan(brought.as_ref())?;
        let out = FOLDER.open(self.out.as_deref())?;
        let job = Job {
            out: out.clone(),
            yade: yade::Options {
                sorted: false,
                ..self.limits.options()
            },
            brought,
        };
        let record = pareto(&plan, &job, self.command(&plan), &Display::new(self.quiet))?;
        let text = json(&record)?;
        let page = report::pareto::page(&record)?;
        FOLDER.finish(&out, &page, &text)?;
        tell(self.json, &text, || in_words(&record, &out))?;
        Ok(exit_code_if(record.complete))
    }

    /// Other engines are paired with the reference, so they can have no clouds that the reference has not.
    fn check(&self) -> Result<(), Error> {
        let charting = self.charting();
        for (name, seeds) in [
            ("--yade-seeds", self.yade_seeds),
            ("--engine-seeds", self.engine_seeds),
        ] {
            if seeds > charting {
                return Err(Error::Usage(format!(
                    "{name} is {seeds}, and must be at most --seeds, {charting}"
                )));
            }
        }
        Ok(())
    }

    fn charting(&self) -> u64 {
        self.seeds.unwrap_or(CHARTING[usize::from(self.quick)])
    }

    fn plan(&self, brought: Option<&Brought>) -> Result<Plan, Error> {
        let charting = self.charting();
        let plan = if self.quick {
            Plan::quick(charting, self.yade_seeds)
        } else {
            Plan::full(
                charting,
                self.confirm.unwrap_or(CONFIRMING),
                self.yade_seeds,
            )
        };
        let Some(brought) = brought else {
            return Ok(plan);
        };
        let program = Program {
            described: brought.description.clone(),
            digest: brought.digest().map_err(EngineError::from)?,
        };
        Ok(plan.with_brought(&program, self.engine_seeds))
    }

    fn command(&self, plan: &Plan) -> String {
        let (seeds, yade) = (plan.charting, self.yade_seeds);
        let engine = match self.engine {
            // The path belongs to a machine.
            Some(_) => format!(" --engine exec:PATH --engine-seeds {}", self.engine_seeds),
            None => String::new(),
        };
        if self.quick {
            format!("crossgrain pareto --quick --seeds {seeds} --yade-seeds {yade}{engine}")
        } else {
            let confirm = plan.confirming;
            format!(
                "crossgrain pareto --seeds {seeds} --confirm {confirm} --yade-seeds {yade}{engine}"
            )
        }
    }
}

/// The chart as a table for a terminal.
fn in_words(record: &Pareto, out: &Path) -> String {
    let mut text = format!(
        "{} grains, {} realizations a method (dear ones fewer), against {}\ncost: processor time of one realization, \
         median; errors: largest bias over its margin, with the ends of its 95 % interval\n\n",
        record.grains, record.charting, record.reference.method.name
    );
    text += &format!(
        "{:>3} {:<50} {:>8} {:>7} {:>6}  {:<22} {:<22} {}\n",
        "",
        "method",
        "cpu s",
        "steps",
        "missed",
        "error of the bed",
        "error of the stresses",
        "dominated by"
    );
    let chance = Point {
        number: record.points.len() + 1,
        charted: record.chance.clone(),
        ..record.reference.clone()
    };
    text += &row("", "the reference", &record.reference, false);
    text += &row("", "the reference on other clouds: chance", &chance, true);
    let mut points: Vec<&Point> = record.points.iter().collect();
    let cost = |point: &Point| point.costs.map_or(f64::INFINITY, |costs| costs.cpu_seconds);
    points.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    for point in points {
        text += &row(&point.number.to_string(), &point.method.name, point, true);
        for (reason, count) in &point.charted.endings.failed {
            text += &format!("{:>4}{count} failed: {reason}\n", "");
        }
        if let Some(reason) = &point.not_made {
            text += &format!("{:>4}not made: {reason}\n", "");
        }
        if let Some(words) = point.only_poured() {
            text += &format!("{:>4}{words}\n", "");
        }
    }
    text += "\nequivalence on clouds of their own:\n";
    for point in &record.points {
        let Some(confirmed) = &point.confirmed else {
            continue;
        };
        let open = crate::study::tradeoff::choice::not_shown(confirmed);
        text += &format!(
            "{:>3} {}: {:?} over {} clouds{}\n",
            point.number,
            point.method.name,
            confirmed.finding(),
            confirmed.clouds,
            if open.is_empty() {
                String::new()
            } else {
                format!("; not shown: {}", open.join(", "))
            }
        );
    }
    text += "\norder of convergence on exact cases:\n";
    for case in &record.convergence {
        let order = case.order.map_or("none".to_owned(), |order| {
            format!(
                "{:.2} ({:.2} to {:.2})",
                order.estimate, order.low, order.high
            )
        });
        text += &format!("    {}: {order}, expected {}\n", case.title, case.expected);
    }
    text + &format!(
        "\nrecommended: {}\n{:.0} s; {}",
        record.recommendation,
        record.seconds,
        page_line(out)
    )
}

fn row(number: &str, name: &str, point: &Point, with_errors: bool) -> String {
    let (seconds, steps) = point
        .costs
        .map_or(("–".to_owned(), "–".to_owned()), |costs| {
            let steps = costs.pour_steps + costs.load_steps;
            (format!("{:.2}", costs.cpu_seconds), format!("{steps:.0}"))
        });
    let judged: &Judgement = &point.charted;
    let error = |worst: &Option<crate::study::tradeoff::judge::Worst>| match worst {
        Some(worst) if with_errors => {
            let of = worst.error;
            format!("{:.2} ({:.2} to {:.2})", of.estimate, of.low, of.high)
        }
        _ => String::new(),
    };
    let by = point.dominated_by.map_or(String::new(), |by| {
        format!("{by}{}", if point.clearly { "" } else { " ?" })
    });
    let missed = match judged.endings.all() {
        0 => "–".to_owned(),
        all => format!("{}/{all}", judged.endings.missed()),
    };
    format!(
        "{number:>3} {name:<50} {seconds:>8} {steps:>7} {missed:>6}  {:<22} {:<22} {by}\n",
        error(&judged.bed),
        error(&judged.load)
    )
}
