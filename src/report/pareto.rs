//! The chart of cost against error as a page.

use crate::error::Error;
use crate::pareto::record::Pareto;

/// A page of its own.
pub fn page(_record: &Pareto) -> Result<String, Error> {
    Ok(String::new())
}
