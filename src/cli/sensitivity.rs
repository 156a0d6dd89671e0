//! `crossgrain sensitivity`: which published figures come out under which of the choices that the paper leaves open.

use std::path::{Path, PathBuf};

use clap::Args;

use super::job_folder::{JobFolder, page_line};
use super::{exit_code_if, json, tell};
use crate::error::Error;
use crate::progress::Display;
use crate::report;
use crate::study::sensitivity::judge::Verdict;
use crate::study::sensitivity::plan::Plan;
use crate::study::sensitivity::record::{Point, Sensitivity, sensitivity};

const FOLDER: JobFolder = JobFolder {
    what: "map",
    usual: "out/sensitivity",
    record: "sensitivity.json",
    keeps_members: true,
};
/// Clouds of a cheap setting: of the paper's bed, and of the small one of `--quick`.
const CLOUDS: [u64; 2] = [12, 6];

#[derive(Debug, Args)]
#[command(
    after_help = "Every finished member is kept in members.jsonl and pushes.jsonl; an interrupted map is taken up again \
    when it is started with the same --out, and may then have another number of clouds. What does not come out is a \
    finding, not a failure.\n\nExamples:\n  crossgrain sensitivity --quick\n  crossgrain sensitivity --clouds 48 --out map"
)]
pub struct Arguments {
    /// A small bed and few settings
    #[arg(long)]
    quick: bool,
    /// Clouds of a cheap setting; dear ones have a share of them [default: 12, with --quick 6]
    #[arg(long, value_parser = clap::value_parser!(u64).range(3..=10_000))]
    clouds: Option<u64>,
    /// The folder to write; a finished map in it is never overwritten
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let out = FOLDER.open(self.out.as_deref())?;
        let clouds = self.clouds.unwrap_or(CLOUDS[usize::from(self.quick)]);
        let plan = if self.quick {
            Plan::quick(clouds)
        } else {
            Plan::full(clouds)
        };
        let quick = if self.quick { " --quick" } else { "" };
        let command = format!("crossgrain sensitivity{quick} --clouds {clouds}");
        let record = sensitivity(&plan, &out, command, &Display::new(self.quiet))?;
        let text = json(&record)?;
        let page = report::sensitivity::page(&record)?;
        FOLDER.finish(&out, &page, &text)?;
        tell(self.json, &text, || in_words(&record, &out))?;
        Ok(exit_code_if(record.complete))
    }
}

/// The map as a table for a terminal.
fn in_words(record: &Sensitivity, out: &Path) -> String {
    let mut text = format!(
        "{} grains, {} clouds (dear settings fewer); ours over published: = comes out, x does not, ? undecided, . not made; * \
         where fewer than 90 % reached the force\n\n{:>4} {:<34} {:>7} ",
        record.grains, record.clouds, "", "setting", "reached"
    );
    for figure in &record.figures {
        text += &format!(" {:>11}", figure.id);
    }
    text.push('\n');
    let mut axis = None;
    for point in &record.points {
        if axis != Some(point.setting.axis) {
            axis = Some(point.setting.axis);
            text += &format!("{}\n", point.setting.axis.title());
        }
        text += &row(record, point);
    }
    text += "\ntogether, as numbers of settings:\n";
    for joint in &record.joint {
        text += &format!(
            "    {}: come out in {}; not excluded in {}\n",
            joint.title,
            numbers(&joint.comes_out),
            numbers(&joint.possible)
        );
    }
    let bearing = &record.bearing;
    text += &format!(
        "\nat rest, a soil with the internal friction of frictionless grains bears {:.1} kPa at a depth of {:.2} m; the bed is \
         {:.2} m deep\n",
        1.0e-3 * bearing.wanted,
        bearing.depth_needed,
        bearing.height
    );
    text + &format!("{:.0} s; {}", record.seconds, page_line(out))
}

fn row(record: &Sensitivity, point: &Point) -> String {
    let mut text = format!(
        "{:>4} {:<34} {:>7} ",
        point.number,
        point.setting.name,
        format!("{}/{}", point.endings.reached, point.endings.all())
    );
    for (figure, judged) in record.figures.iter().zip(&point.figures) {
        let mark = match judged.verdict {
            Verdict::ComesOut => '=',
            Verdict::DoesNot => 'x',
            Verdict::Undecided => '?',
            Verdict::NotMade => '.',
        };
        let value = judged.value.map_or(String::new(), |of| {
            format!("{:.2}", of.estimate / figure.value)
        });
        let flag = if judged.conditional { "*" } else { "" };
        text += &format!(" {:>11}", format!("{value}{mark}{flag}"));
    }
    text + "\n"
}

fn numbers(all: &[usize]) -> String {
    if all.is_empty() {
        return "none".to_owned();
    }
    let all: Vec<String> = all.iter().map(usize::to_string).collect();
    all.join(", ")
}
