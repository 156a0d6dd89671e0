//! `crossgrain continuum`: the continuum's stress at the paper's control points.

use clap::Args;
use serde::Serialize;

use super::{json, print};
use crate::error::{Error, exit};
use crate::paper::boussinesq::setup;
use crate::paper::continuum::table::{Above, Row, Setup, rows};
use crate::paper::continuum::{Model, Spread};

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  crossgrain continuum\n  crossgrain continuum --height 0.467 --porosity 0.16 --json"
)]
pub struct Arguments {
    /// Height of the bed, m [default: 0.46, as printed]
    #[arg(long)]
    height: Option<f64>,
    /// Porosity for the weight [default: 0.17, as printed]
    #[arg(long)]
    porosity: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Output {
    setup: Setup,
    rows: Vec<Row>,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let mut setup = setup();
        setup.height = self.height.unwrap_or(setup.height);
        setup.porosity = self.porosity.unwrap_or(setup.porosity);
        let deepest = setup.points.iter().map(|point| point.depth);
        let deepest = deepest.fold(0.0, f64::max);
        if !(setup.height >= deepest && setup.height.is_finite()) {
            return Err(Error::Usage(format!(
                "--height is {}, and must be at least the control points' depth, {deepest} m",
                setup.height
            )));
        }
        if !(0.0..1.0).contains(&setup.porosity) {
            return Err(Error::Usage(format!(
                "--porosity is {}, and must be at least 0 and below 1",
                setup.porosity
            )));
        }
        let output = Output {
            rows: rows(&setup),
            setup,
        };
        print(&if self.json {
            json(&output)?
        } else {
            in_words(&output)
        })?;
        Ok(exit::AGREED)
    }
}

fn in_words(Output { setup, rows }: &Output) -> String {
    let mut text = format!(
        "load {:.0} N/m on a width of {} m; bed {} m high in a box {} m wide; n = {}\n\
         stresses in kPa: of the load, and with the weight; per cent against the uniform load on the half-space\n\n",
        setup.load.force(),
        2.0 * setup.load.half_width,
        setup.height,
        setup.width,
        setup.porosity
    );
    text += &format!("{:<52}", "ground and load");
    for point in &setup.points {
        text += &format!("{:>30}", format!("{} (x = {} m)", point.name, point.offset));
    }
    // The rows of a case stand together.
    let same = |a: &Row, b: &Row| {
        (a.model, a.spread, a.sunk, a.above) == (b.model, b.spread, b.sunk, b.above)
    };
    for case in rows.chunk_by(same) {
        text += &format!("\n{:<52}", name(&case[0]));
        for row in case {
            text += &format!(
                "{:>8.2} {:>+6.1} % {:>6.2} {:>+5.1} %",
                1e-3 * row.load,
                row.change_of_load,
                1e-3 * row.stress,
                row.change
            );
        }
    }
    text + "\n\nsunk: the load has gone down so far; in air: the ground above its base bears nothing; within: that ground \
           is elastic,\nfills the hole and hangs on the load (Melan). docs/continuum.md says what this means.\n"
}

/// A case in words.
fn name(row: &Row) -> String {
    let ground = match row.model {
        Model::HalfSpace => "half-space",
        Model::Layer { .. } => "layer",
        Model::Box { .. } => "box",
    };
    let load = match row.spread {
        Spread::Uniform => "uniform",
        Spread::RigidPunch => "rigid punch",
    };
    let sunk = match row.above {
        None => String::new(),
        Some(Above::Nothing) => format!(", sunk {:.0} mm, in air", 1e3 * row.sunk),
        Some(Above::Elastic { poisson }) => {
            format!(", sunk {:.0} mm, within, ν = {poisson}", 1e3 * row.sunk)
        }
    };
    format!("{ground}, {load}{sunk}")
}
