//! Views of documents: every job says what it found as a [`Document`](crate::document::Document), and here it becomes what
//! people and programs read.
//!
//! ```
//! use crossgrain::checks::Outcome;
//! use crossgrain::document::{Axis, Colour, Document, Plot, Section, Table};
//! use crossgrain::report;
//!
//! let heights = Table::of("heights", "Heights of the bed", [("native", 0.4702)])
//!     .column("engine", |(engine, _)| engine)
//!     .column("height, m", |(_, height)| height);
//! let settling = Plot::new("settling", "The bed settles", Axis::linear("time, s"), Axis::logarithmic("energy, J"))
//!     .line("native", Colour::Blue, [[0.1, 1.0], [0.2, 1e-3]]);
//! let document = Document {
//!     title: "One run".to_owned(),
//!     verdict: Outcome::Pass,
//!     answer: "The bed came to rest.".to_owned(),
//!     sections: vec![
//!         Section::new("The bed", "It is 0.47 m high.").with(heights).with(settling),
//!         Section::new("How it was run", "").with("`crossgrain run scene.json`").as_details(),
//!     ],
//!     checks: Vec::new(),
//! };
//! // Without checks it judges nothing.
//! assert!(report::terminal(&document).ends_with("\nThe bed came to rest.\n"));
//! let page = report::page(&document);
//! assert!(page.html.contains("href=\"figures/settling.svg\""));
//! // page.write(folder)? writes report.html and figures/settling.svg, settling.csv, heights.csv.
//! assert_eq!(page.files.len(), 3);
//! ```

pub mod disc_field;
pub mod fields;
pub mod history;
pub mod html;
mod junit;
pub mod outcome;
pub mod packing;
mod plot;
mod svg;
mod views;

pub use html::{FIRST, Page, check_lines, markdown, page, page_against, terminal};
pub use junit::{junit, junit_of_error};
pub use plot::svg;

/// The style of all pages.
const STYLE: &str = include_str!("report/style.css");

/// What all pages do without a server: tables sort by a click on a heading, and long ones filter.
const SCRIPT: &str = include_str!("report/tables.js");
