//! What the scripts inside YADE write: the same reader as that of any engine, with inputs whose tables are numbers.

pub use super::exec::read;
