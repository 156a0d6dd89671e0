//! Discs and planar spheres: scenes, initial grains, a discrete-element engine, and measures of a bed. Knows nothing of
//! files, terminals or other programs, and can be used alone. SI units; x across, z up.
//!
//! Data flows one way:
//!
//! | module | holds |
//! |---|---|
//! | [`scene`] | an experiment as a value: grains, contact law, box, pouring, loading; its JSON Schema and validation |
//! | [`rules`] | the conventions in which codes differ, each with its alternatives |
//! | [`model`] | a scene resolved to the numbers that a step computes with |
//! | [`generate`] | the initial grains, a pure function of the scene and its realization |
//! | [`tables`], [`task`] | what an engine is given and what it returns, whichever it is |
//! | [`native`] | the engine: normal springs, friction with history, rotation, dashpots |
//! | [`constant`] | the constants of a run that may be a little wrong, and how one is made larger |
//! | [`reference`](mod@reference) | the step written out plainly, which the engine must equal bit by bit |
//! | [`variant`] | the constants and terms that another engine may have otherwise |
//! | [`vector`] | vectors in space |
//! | [`measure`] | heights, porosity, coordination, energies and stresses of a bed, blind to the engine |
//!
//! The same scene gives the same bits on every machine.
//!
//! ```
//! use grains::generate::initial_bodies;
//! use grains::measure::{self, porosity};
//! use grains::native::{self, Options};
//! use grains::scene::{Cloud, paper_scene};
//! use grains::tables::StopReason;
//! use grains::task::Task;
//!
//! // The paper's discs, forty of them in a narrow box.
//! let mut scene = paper_scene(1, 40);
//! scene.container.width = 0.06;
//! scene.cloud = Cloud::JitteredLattice { columns: 4, jitter: 0.9, speed: 0.3, spin: 0.0, over: None };
//!
//! let task = Task::settle(initial_bodies(&scene));
//! let settled = native::run(&scene, &task, &Options::default(), &mut ())?;
//! assert_eq!(settled.stages[0].stop, StopReason::Settled);
//!
//! let bodies = &settled.last.bodies;
//! let height = measure::mean_surface(&scene, bodies);
//! let porosity = porosity::from_height(bodies, scene.container.width, height);
//! println!("{} discs settled to {height:.3} m with porosity {porosity:.2}", bodies.len());
//! assert!(porosity > 0.1 && porosity < 0.3);
//! # Ok::<(), native::NativeError>(())
//! ```

pub mod constant;
pub mod generate;
pub mod measure;
pub mod model;
pub mod native;
pub mod obstacle;
pub mod reference;
pub mod rules;
pub mod scene;
pub mod tables;
pub mod task;
pub mod variant;
pub mod vector;

/// SHA-256, in hexadecimal, over the path and the bytes of every source file of this crate, unit tests and comments included:
/// results with different digests may have different bits. Those of one digest have the same.
pub const SOURCE_DIGEST: &str = env!("GRAINS_SOURCE_DIGEST");
