//! The benchmark as a page.

use crate::bench::Bench;
use crate::error::Error;

/// The page.
pub fn page(bench: &Bench) -> Result<String, Error> {
    let _ = bench;
    Ok(String::new())
}
