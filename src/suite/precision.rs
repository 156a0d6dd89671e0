//! Higher precision as truth: YADE in 128-bit arithmetic runs the same case from the same numbers, and
//! the distance from it is the rounding error of an engine.
//!
//! A third precision tells rounding from everything else: an error that is rounding falls by 2¹¹ from
//! 53 to 64 bits, an error of the method does not.

use serde::Serialize;

use super::trajectories;
use super::{Figures, Track};
use crate::checks::Check;
use crate::engine::ProgramError;
use crate::engine::yade::{self, run_cases, sibling};
use crate::files::work_folder;
use grains::generate::initial_bodies;
use grains::model::Model;
use grains::native::{CaseOptions, NativeError, run_case};
use grains::tables::Snapshot;
use grains::task::Case;

/// Steps at which the error is taken.
const MOMENTS: [u64; 7] = [0, 300, 600, 1_000, 1_500, 2_000, 3_000];

/// Beyond this error, over a radius, neighbours are no longer the same and errors say nothing.
const SATURATED: f64 = 1.0e-3;

/// The tables hold doubles; errors over a radius below this are their own rounding.
const RESOLVED: f64 = 1.0e-13;

/// Bits that long double has more than double.
const MORE_BITS: f64 = 11.0;

/// How far log₂ of a ratio of two largest errors may scatter.
const SCATTER: f64 = 2.5;

/// Errors at one moment, largest distance of a centre from its true place over the grain's radius.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Steps since the start.
    pub step: u64,
    /// The native engine's.
    pub native: f64,
    /// YADE's, in double precision.
    pub yade: f64,
    /// YADE's, in long double.
    pub long_double: f64,
}

/// Fewer grains collide too seldom for errors to be seen growing.
const FEWEST_GRAINS: u32 = 500;

/// The case: spinning grains with friction, poured; 500 at least.
pub fn case(grains: u32) -> Case {
    let grains = grains.max(FEWEST_GRAINS);
    let scene = trajectories::rough(grains);
    Case {
        name: format!("precision {grains}"),
        model: Model::of(&scene),
        bodies: initial_bodies(&scene),
        punch: None,
        moments: MOMENTS.to_vec(),
    }
}

/// The case in every precision of YADE.
#[derive(Debug, Clone)]
pub struct Precisions {
    /// What was run.
    pub case: Case,
    double: Track,
    long_double: Track,
    truth: Track,
}

/// Runs the case in every precision of YADE.
pub fn run(case: Case, options: &yade::Options) -> Result<Precisions, ProgramError> {
    let program = options.program.as_deref();
    let double = in_yade(&case, options.clone())?;
    let build = |name: &str| -> Result<Track, ProgramError> {
        let program = Some(sibling(program, name)?);
        let options = yade::Options {
            program,
            ..options.clone()
        };
        in_yade(&case, options)
    };
    let long_double = build("yade-longdouble")?;
    let truth = build("yade-float128")?;
    Ok(Precisions {
        case,
        double,
        long_double,
        truth,
    })
}

impl Precisions {
    /// The errors of the native engine with these options, and YADE's.
    pub fn errors(&self, options: impl Into<CaseOptions>) -> Result<Vec<Errors>, NativeError> {
        let native = run_case(&self.case, options)?;
        let moments = self.truth.iter().zip(&native);
        let in_yade = self.double.iter().zip(&self.long_double);
        let errors = moments.zip(in_yade).map(|((truth, native), of)| Errors {
            step: truth.step,
            native: largest_error(native, truth),
            yade: largest_error(of.0, truth),
            long_double: largest_error(of.1, truth),
        });
        Ok(errors.collect())
    }
}

fn in_yade(case: &Case, options: yade::Options) -> Result<Track, ProgramError> {
    let work = work_folder()?;
    let run = run_cases(&[case], &options, work.path(), &mut ())?;
    Ok(run.cases.into_iter().flat_map(|case| case.track).collect())
}

fn largest_error(of: &Snapshot, truth: &Snapshot) -> f64 {
    let (of, truth) = (&of.bodies, &truth.bodies);
    (0..of.len())
        .map(|id| {
            let apart = (of.x[id] - truth.x[id]).hypot(of.z[id] - truth.z[id]);
            apart / of.radius[id]
        })
        .fold(0.0, f64::max)
}

/// What the errors must show.
pub fn checks(errors: &[Errors]) -> Vec<Check> {
    let mut figures = Figures::of("");
    let mut compared = 0;
    for of in errors {
        let step = of.step;
        figures.because("both round alike");
        let what =
            format!("step-{step}/same-rounding: step {step}: native error less YADE's over R, 1");
        figures.is(&what, of.native - of.yade, 0.0, 0.0);
        if of.long_double > RESOLVED && of.native < SATURATED {
            compared += 1;
            figures.because("11 bits more; two largest errors of many scatter by a few times");
            let what = format!(
                "step-{step}/bits: step {step}: log2 of the error in double over that in long double, 1"
            );
            let bits = (of.native / of.long_double).log2();
            figures.is(&what, bits, MORE_BITS, SCATTER);
        }
    }
    figures.because("without one nothing says that the errors are rounding");
    let value = if compared > 0 { 0.0 } else { f64::NAN };
    let what = "compared: moments at which precisions were compared; 0 if any, 1";
    figures.is(what, value, 0.0, 0.0);
    figures.done()
}
