//! Whether another engine's first steps are the model's: to the bit, to rounding, or not, and which constant or term is wrong
//! then. Knows nothing of files, terminals or how an engine is started: it hands out cases and judges the answers.
//!
//! In the first hundred steps rounding has a narrow envelope: replicas of the native engine with rounding errors as coarse as
//! the other engine's stay within a billionth of a grain of each other, and a constant that is wrong by less than 10⁻⁸
//! leaves them. At the end of a run all differences are of one size, and nothing can be told.
//!
//! | question | module |
//! |---|---|
//! | from which states does an engine start? | [`starts`] |
//! | how coarsely does it compute? | [`envelope::Resolution`] |
//! | and in space? | [`spheres`] |
//! | does it stay among the replicas, and what would have left them? | [`envelope`] |
//! | are its contact tables right? | `contacts` |
//! | what do the states exercise, and what not? | [`exercise`] |
//! | which constants are wrong? | [`constants`] |
//! | which term has another form? | [`forms`] |
//! | and by what it writes step by step? | `terms` |
//! | which rules does it compute with, if it does not say? | [`identify`] |
//! | does it agree with itself, whatever its law is? | [`invariance`] |
//! | all of it in order | [`judge`] |
//!
//! ```
//! use grains::constant::Constant;
//! use grains::task::Case;
//! use grains::variant::{self, Variant};
//! use verdict::judge::{Reference, Verdict};
//! use verdict::starts::DISPERSION;
//!
//! // An engine whose gravity is wrong by a millionth.
//! let gravity = Constant::with_symbol("g_z").expect("a constant");
//! let heavier = Variant::default().and(gravity, 1.0e-6);
//! let mut engine = |cases: &[&Case]| -> Result<Vec<verdict::Answer>, Box<dyn std::error::Error>> {
//!     Ok(cases.iter().map(|case| Ok(variant::run(case, &heavier))).collect())
//! };
//!
//! let reference = Reference::new(100, DISPERSION, &mut |_| ())?;
//! // It has what is asked for.
//! let found = reference.judge(&[], &|_| None, &mut engine, &mut |_| ())?;
//! assert_eq!(found.verdict(), Verdict::Different);
//! assert!(found.causes[0].sentence().starts_with("equal to rounding with g_z × 1.000001000000"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod causes;
mod conditions;
pub mod constants;
pub mod contacts;
pub mod drawn;
pub mod envelope;
pub mod excerpt;
pub mod exercise;
pub mod forms;
pub mod frame;
pub mod identify;
pub mod invariance;
pub mod judge;
pub mod spheres;
pub mod starts;
mod terms;

use grains::tables::Snapshot;
use grains::task::Case;

/// What an engine made of a case: the states at its moments, or why it refused.
pub type Answer = Result<Vec<Snapshot>, String>;

/// An engine: runs the cases in order and gives an answer for each; the error is its own.
pub type Engine<'a, E> = dyn FnMut(&[&Case]) -> Result<Vec<Answer>, E> + 'a;
