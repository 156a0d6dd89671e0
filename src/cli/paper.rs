//! `crossgrain paper`.
use crate::error::Error;
use clap::Args;
#[derive(Debug, Args)]
pub struct Arguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}
impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let _ = self.json;
        Ok(0)
    }
}
