//! `crossgrain study plan`: what is run, fixed.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::cli::chosen::Chosen;
use crate::cli::print;
use crate::cli::run::{LoopOrder, YadeLimits};
use crate::error::{Error, exit};
use crate::run::scene_file::read_scene;
use crate::study::campaign::Campaign;
use crate::study::create;
use crate::study::plan::Program;
use crate::study::realization::Runner;
use grains::model::Model;
use grains::model::terms::Kernel;
use grains::native::Mode;
use grains::native::pouring::Softly;

#[derive(Debug, Subcommand)]
pub enum Kind {
    /// Many realizations of one scene in one engine
    Campaign(CampaignArguments),
}

#[derive(Debug, Args)]
pub struct CampaignArguments {
    /// The scene file
    scene: PathBuf,
    /// How many realizations
    #[arg(long)]
    members: u64,
    /// Realization of member 1; the next members have the next ones
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// native, yade or exec:PATH
    #[arg(long, default_value = "native")]
    engine: Chosen,
    /// Native: which promise it keeps
    #[arg(long, default_value = "exact")]
    mode: Mode,
    /// Native: pour at a tenth of the modulus and stiffen, as in `crossgrain run --soft-pour`
    #[arg(long)]
    soft_pour: bool,
    /// YADE: order in which interactions are visited
    #[arg(long = "loop", value_enum, default_value = "ordinary")]
    order: LoopOrder,
    #[command(flatten)]
    limits: YadeLimits,
    #[command(flatten)]
    place: Place,
}

/// Where a plan goes.
#[derive(Debug, Args)]
pub struct Place {
    /// The study's folder; must not exist
    #[arg(long)]
    pub out: PathBuf,
    /// Take over the rows that this study of the same kind has already
    #[arg(long, value_name = "DIR")]
    pub reuse: Option<PathBuf>,
}

impl Kind {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Kind::Campaign(arguments) => arguments.execute(),
        }
    }
}

impl Place {
    /// What is printed of a plan: its own words, the rows that were taken over, and how it goes on.
    pub fn words(&self, plan: &str, reused: u64) -> String {
        let reused = match reused {
            0 => String::new(),
            rows => format!("{rows} rows taken over\n"),
        };
        format!(
            "{plan}\n{reused}run it: crossgrain study run {}\n",
            self.out.display()
        )
    }
}

impl CampaignArguments {
    fn execute(self) -> Result<u8, Error> {
        let scene = read_scene(&self.scene)?;
        let general = Kernel::of(&Model::of(&scene).law) == Kernel::General;
        if general && !self.mode.is_exact() {
            return Err(Error::Usage(format!(
                "--mode {} is for frictionless scenes without dashpots; leave it away",
                self.mode.name()
            )));
        }
        let is_native = matches!(self.engine, Chosen::Native);
        if !is_native && (!self.mode.is_exact() || self.soft_pour) {
            return Err(Error::Usage(
                "--mode and --soft-pour are of the native engine".to_owned(),
            ));
        }
        let (runner, program) = match (&self.engine, self.order) {
            (Chosen::Native, _) => (Runner::Native(self.mode), None),
            (Chosen::Yade, LoopOrder::Sorted) => (Runner::YadeSorted, None),
            (Chosen::Yade, LoopOrder::Ordinary) => (Runner::YadeOrdinary, None),
            (Chosen::Exec(path), _) => (
                Runner::Brought,
                Some(Program::of(&self.limits.brought(path)?)?),
            ),
        };
        let phases = if self.soft_pour {
            let softly = Softly::tested(&scene).ok_or_else(|| {
                Error::Usage("--soft-pour needs /time_step as a fraction".to_owned())
            })?;
            softly.phases(&scene)
        } else {
            Vec::new()
        };
        let campaign = Campaign::new(&scene, runner, phases, self.members, self.seed);
        let Place { out, reuse } = &self.place;
        let last = self.seed.saturating_add(self.members.saturating_sub(1));
        let words = format!(
            "{} members of {:?} in {}, realizations {} to {last}",
            self.members,
            scene.name,
            runner.name(),
            self.seed
        );
        let reused = create(out, campaign, program, reuse.as_deref())?;
        print(&self.place.words(&words, reused))?;
        Ok(exit::AGREED)
    }
}
