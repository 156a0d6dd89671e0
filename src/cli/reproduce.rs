//! `crossgrain reproduce`.
use crate::error::Error;
use clap::Args;
#[derive(Debug, Args)]
pub struct Arguments {}
impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        Ok(0)
    }
}
