//! The report: pages that open offline, and the pictures and charts on them.

mod axis;
pub mod bench;
pub mod chart;
pub mod check_files;
pub mod claims;
mod contours;
mod difference;
pub mod disc_field;
pub mod distribution;
pub mod figure;
pub mod figure_files;
pub mod figures;
mod frame;
pub mod junit;
pub mod packing;
pub mod page;
pub mod pareto;
mod plot;
pub mod sensitivity;
mod shades;
mod shell;
pub mod stability;
pub mod verification;

/// The style of all pages.
const STYLE: &str = include_str!("report/style.css");

/// What all pages do without a server: tables sort by a click on a heading, and long ones filter.
const SCRIPT: &str = include_str!("report/tables.js");
