//! Engines that are programs of their own: YADE, and those that people bring.

mod completeness;
pub mod exec;
mod punch_line;
pub mod watch;
pub mod yade;
