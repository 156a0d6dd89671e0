//! `crossgrain verify`: the ladder of exact solutions, symmetries and bits.

use clap::Args;

use super::run::YadeLimits;
use super::{json, print};
use crate::compare::Verdict;
use crate::engine::Observer;
use crate::error::{Error, exit};
use crate::progress::Display;
use crate::tables::{Snapshot, Stage};
use crate::verify::ladder::{Climbed, Climbers, Ladder};

#[derive(Debug, Args)]
pub struct Arguments {
    /// Which engines climb
    #[arg(long, value_enum, default_value = "both")]
    engine: Climbers,
    /// Trajectories of so many grains at most
    #[arg(long, default_value_t = 5000)]
    grains: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: YadeLimits,
}

impl Arguments {
    pub fn execute(self) -> Result<u8, Error> {
        let ladder = Ladder::new(self.grains);
        let mut climbed = Vec::new();
        if self.engine != Climbers::Yade {
            climbed.extend(ladder.climb_native());
        }
        if self.engine != Climbers::Native {
            let (solo, tracks) = ladder.climb_yade(&self.limits.options(), &mut ())?;
            climbed.extend(solo);
            if self.engine == Climbers::Both {
                climbed.extend(ladder.compare(&tracks));
            }
        }
        for c in &climbed {
            print(&format!("{:?} {} [{}] {}\n", c.verdict, c.name, c.engine, c.reason))?;
            for l in &c.lines {
                print(&format!("      {} {} = {:e} expected {:e} ± {:e}\n", l.holds(), l.quantity, l.value, l.expected, l.tolerance))?;
            }
        }
        Ok(exit::AGREED)
    }
}
