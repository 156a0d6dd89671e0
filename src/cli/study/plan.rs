//! `crossgrain study plan`: what is run, fixed.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use crate::cli::engine::{Several, beside, one, several};
use crate::cli::print;
use crate::cli::run::{LoopOrder, YadeLimits};
use crate::engine::named::Named;
use crate::engine::{Engine, Part};
use crate::error::{Error, exit};
use crate::limits::stability::Stability;
use crate::run::folder::read_scene;
use crate::study::campaign::Campaign;
use crate::study::folder::StudyFolder;
use crate::study::plan::Program;
use crate::study::realization::Runner;
use crate::study::{Study, candidates, conventions, create, search, tradeoff};
use grains::generate::initial_bodies;
use grains::native::pouring::Softly;
use grains::task::Task;

#[derive(Debug, Subcommand)]
#[command(
    after_help = "Example:\n  crossgrain study plan campaign scene.json --members 1000 --out thousand"
)]
pub enum Kind {
    /// Many realizations of one scene in one engine
    Campaign(CampaignArguments),
    /// Many ways to run the paper's scene: what each costs, and how wrong it is
    Tradeoff(TradeoffArguments),
    /// Which settings give all published figures: a wave over the choices, or among those that a wave has left
    Search(SearchArguments),
    /// Our default, its quasi-static limit and the best settings of a search, or the open choices one at a time: published
    /// figures, and what the load adds where
    Candidates(CandidatesArguments),
    /// Each rule of the catalogue alone, and each code's whole set: what changes in a bed, under its load and in a collapsed column
    #[command(
        after_help = "Example:\n  crossgrain study plan rules --clouds 8 --out rules && crossgrain study run rules"
    )]
    Rules {
        /// Packings of every setting
        #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u64).range(3..=10_000))]
        clouds: u64,
        #[command(flatten)]
        place: Place,
    },
    /// The largest stable steps, predicted and found, and where methods fail
    #[command(
        after_help = "Example:\n  crossgrain study plan stability --quick --out stable && crossgrain study run stable"
    )]
    Stability {
        #[command(flatten)]
        map: MapArguments,
        #[command(flatten)]
        limits: YadeLimits,
        #[command(flatten)]
        place: Place,
    },
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  crossgrain study plan campaign scene.json --members 1000 --out thousand"
)]
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
    #[arg(long, default_value = "native", value_parser = one)]
    engine: Named,
    /// Native: reduced-stiffness deposition, as in `crossgrain run --reduced-stiffness`
    #[arg(long)]
    reduced_stiffness: bool,
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

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  crossgrain study plan tradeoff --quick --out methods && crossgrain study run methods"
)]
pub struct TradeoffArguments {
    /// A small bed and few methods
    #[arg(long)]
    quick: bool,
    /// Realizations of a method; expensive ones have fewer [default: 24, with --quick 6]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1000))]
    clouds: Option<u64>,
    /// Realizations of its own on which each candidate's equivalence is tested [default: 300, with --quick none]
    #[arg(long, conflicts_with = "quick", value_parser = clap::value_parser!(u64).range(0..=100_000))]
    confirm: Option<u64>,
    /// Realizations in YADE, about five minutes each for the paper's bed; 0 leaves YADE out
    #[arg(long, default_value_t = 1)]
    yade_clouds: u64,
    /// One more engine: exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long, value_parser = beside)]
    engine: Option<PathBuf>,
    /// Realizations of each method in that engine; without a punch it pours and settles
    #[arg(long, default_value_t = 1, requires = "engine", value_parser = clap::value_parser!(u64).range(1..=1000))]
    engine_clouds: u64,
    #[command(flatten)]
    limits: YadeLimits,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, Args)]
#[command(
    after_help = "That no setting is left is a finding, not a failure.\n\nExample:\n  \
    crossgrain study plan search --out wave-1 && crossgrain study run wave-1\n  \
    crossgrain study plan search --after wave-1 --out wave-2"
)]
pub struct SearchArguments {
    /// The wave before, finished
    #[arg(long, value_name = "DIR")]
    after: Option<PathBuf>,
    /// A small bed; waves after it have its bed
    #[arg(long, conflicts_with = "after")]
    quick: bool,
    /// Beds that are poured in different ways [default: 60, quick: 24]
    #[arg(long, value_parser = clap::value_parser!(u16).range(2..=1000))]
    beds: Option<u16>,
    /// Loads on each bed [default: 5, quick: 3]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=100))]
    loads: Option<u16>,
    /// Realizations of each bed [default: 8, quick: 3]
    #[arg(long, value_parser = clap::value_parser!(u64).range(3..=1000))]
    clouds: Option<u64>,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  crossgrain study plan candidates --search wave-2 --out best && crossgrain study run best\n  \
    crossgrain study plan candidates --choices --out choices && crossgrain study run choices"
)]
pub struct CandidatesArguments {
    /// The last wave of a search, finished: its best settings are added
    #[arg(long, value_name = "DIR")]
    search: Option<PathBuf>,
    /// How many of them
    #[arg(long, default_value_t = 2, requires = "search", value_parser = clap::value_parser!(u8).range(1..=12))]
    best: u8,
    /// Instead, the choices that the paper leaves open, one at a time around our default; with --search those that are no
    /// axes of it, around its best setting
    #[arg(long, conflicts_with = "best")]
    choices: bool,
    /// Of the choices those alone that read the paper's words in another way, such as dashpots
    #[arg(long, conflicts_with_all = ["best", "choices"])]
    readings: bool,
    /// A small bed
    #[arg(long)]
    quick: bool,
    /// Packings of every setting [default: 400, with --choices 24, with --readings 48]
    #[arg(long, value_parser = clap::value_parser!(u64).range(3..=10_000))]
    clouds: Option<u64>,
    #[command(flatten)]
    place: Place,
}

impl CandidatesArguments {
    fn execute(self) -> Result<u8, Error> {
        let clouds = match [self.choices, self.readings] {
            [true, _] => 24,
            [_, true] => 48,
            _ => 400,
        };
        let clouds = self.clouds.unwrap_or(clouds);
        let found = self.search.as_deref().map(searched).transpose()?;
        let found = found.as_ref().map(|(_, found)| found);
        let plan = match self.choices || self.readings {
            true => candidates::Plan::of_choices(self.quick, clouds, found, self.readings),
            false => candidates::Plan::new(self.quick, clouds, found, self.best.into()),
        };
        let (settings, beds) = (plan.beds.settings().count(), plan.beds.0.len());
        let words = format!("{settings} settings on {beds} beds of {clouds} clouds each");
        self.place.create(plan, None, &words)
    }
}

/// A finished wave of a search and what it says.
fn searched(path: &Path) -> Result<(search::Plan, search::matching::Search), Error> {
    let merged = StudyFolder::<search::Plan>::open(path)?.merged()?;
    let members = merged.rows.into_iter().flatten().collect();
    let found = search::matching::Search::of(&merged.plan.study, &members);
    Ok((merged.plan.study, found))
}

impl SearchArguments {
    fn execute(self) -> Result<u8, Error> {
        let (beds, loads, clouds) = if self.quick { (24, 3, 3) } else { (60, 5, 8) };
        let size = search::Size {
            beds: self.beds.unwrap_or(beds).into(),
            loads: self.loads.unwrap_or(loads).into(),
            clouds: self.clouds.unwrap_or(clouds),
        };
        let plan = match &self.after {
            None => search::Plan::first(search::space::base(self.quick), size),
            Some(path) => {
                let (plan, found) = searched(path)?;
                let path = path.display();
                plan.next(&found, size).map_err(|why| {
                    Error::Usage(format!(
                        "no wave can follow {path}: {why} (`crossgrain study report {path}`)"
                    ))
                })?
            }
        };
        let (wave, beds, loads) = (plan.wave, plan.beds.0.len(), plan.beds.settings().count());
        let clouds = size.clouds;
        let words = format!(
            "wave {wave}: {beds} beds, {loads} loads on them, {clouds} realizations of each"
        );
        self.place.create(plan, None, &words)
    }
}

/// What is mapped, and in which engines.
#[derive(Debug, Args)]
pub struct MapArguments {
    /// Beds of 500 grains instead of 5,000; in space fewer and smaller ones
    #[arg(long)]
    quick: bool,
    /// Spheres with Hertz's springs: which shares of the Rayleigh time and of YADE's PWaveTimeStep are stable at which overlaps
    #[arg(long)]
    in_space: bool,
    /// native, yade or both; or exec:PATH, a program that speaks the engine protocol (docs/engine-protocol.md)
    #[arg(long, default_value = "both", value_parser = several)]
    engine: Several,
}

impl MapArguments {
    /// The plan, and the external engine that it names.
    pub fn plan(&self, limits: &YadeLimits) -> Result<(Stability, Option<Program>), Error> {
        let mut program = None;
        let external = match self.engine.last() {
            Some(Named::Exec(path)) => {
                program = Some(Program::of(&limits.external(path)?)?);
                Some(Runner::External)
            }
            Some(Named::Yade(_)) => Some(Runner::YadeSorted),
            _ => None,
        };
        let native = self.engine.contains(&Named::Native);
        let plan = Stability::new(native, external, self.quick, self.in_space);
        Ok((plan, program))
    }
}

impl TradeoffArguments {
    fn execute(self) -> Result<u8, Error> {
        let clouds = self.clouds.unwrap_or(if self.quick { 6 } else { 24 });
        // Other engines are paired with the reference, so they can have no clouds that the reference has not.
        for (name, own) in [
            ("--yade-clouds", self.yade_clouds),
            ("--engine-clouds", self.engine_clouds),
        ] {
            if own > clouds {
                return Err(Error::Usage(format!(
                    "{name} is {own}, and must be at most --clouds, {clouds}"
                )));
            }
        }
        let confirm = self.confirm.unwrap_or(300);
        let mut plan = match self.quick {
            true => tradeoff::plan::Plan::quick(clouds, self.yade_clouds),
            false => tradeoff::plan::Plan::full(clouds, confirm, self.yade_clouds),
        };
        let mut program = None;
        if let Some(path) = &self.engine {
            let engine = Program::of(&self.limits.external(path)?)?;
            plan = plan.with_external(&engine.described, &engine.digest, self.engine_clouds);
            program = Some(engine);
        }
        let words = format!(
            "{} methods of beds of {} grains, {} realizations",
            plan.methods.len() + 1,
            plan.reference.specification.scene.particles.count,
            plan.tasks().len()
        );
        self.place.create(plan, program, &words)
    }
}

impl Kind {
    pub fn execute(self) -> Result<u8, Error> {
        match self {
            Kind::Campaign(arguments) => arguments.execute(),
            Kind::Tradeoff(arguments) => arguments.execute(),
            Kind::Search(arguments) => arguments.execute(),
            Kind::Candidates(arguments) => arguments.execute(),
            Kind::Rules { clouds, place } => {
                let plan = conventions::Plan::new(clouds);
                let settings = plan.beds.0.len();
                let words = format!("{settings} settings on {clouds} clouds each");
                place.create(plan, None, &words)
            }
            Kind::Stability { map, limits, place } => {
                let (plan, program) = map.plan(&limits)?;
                let (scenes, grains, failures) =
                    (plan.scenes.len(), plan.grains, plan.failures.len());
                let words = format!(
                    "{scenes} scenes, beds of {grains} grains, and {failures} failure modes"
                );
                place.create(plan, program, &words)
            }
        }
    }
}

impl Place {
    /// Says what was planned in its own words, the rows that were taken over, and how it goes on.
    fn create<S: Study>(
        &self,
        study: S,
        program: Option<Program>,
        words: &str,
    ) -> Result<u8, Error> {
        let reused = match create(&self.out, study, program, self.reuse.as_deref())? {
            0 => String::new(),
            rows => format!("{rows} rows taken over\n"),
        };
        let next = format!("crossgrain study run {}", self.out.display());
        print(&format!("{words}\n{reused}run it: {next}\n"))?;
        Ok(exit::AGREED)
    }
}

impl CampaignArguments {
    fn execute(self) -> Result<u8, Error> {
        let scene = read_scene(&self.scene)?;
        let is_native = self.engine == Named::Native;
        if !is_native && self.reduced_stiffness {
            let why = "--reduced-stiffness is of the native engine";
            return Err(Error::Usage(why.to_owned()));
        }
        let (runner, program) = match (&self.engine, self.order) {
            (Named::Exec(path), _) => {
                let engine = self.limits.external(path)?;
                let whole = Task::whole(initial_bodies(&scene));
                // Without a punch it pours and settles.
                if engine.lacks(&scene, &whole) != Some(Part::Punch.in_words()) {
                    engine.check(&scene, &whole)?;
                }
                (Runner::External, Some(Program::of(&engine)?))
            }
            (Named::Native, _) => (Runner::Native, None),
            (_, LoopOrder::Sorted) => (Runner::YadeSorted, None),
            (_, LoopOrder::Ordinary) => (Runner::YadeOrdinary, None),
        };
        let mut phases = Vec::new();
        if self.reduced_stiffness && scene.in_space() {
            let why = "--reduced-stiffness is for scenes in the plane: leave /box/depth or it away";
            return Err(Error::Usage(why.to_owned()));
        }
        if self.reduced_stiffness {
            let why = "--reduced-stiffness needs /time_step as a fraction";
            let softly = Softly::tested(&scene).ok_or_else(|| Error::Usage(why.to_owned()))?;
            phases = softly.phases(&scene);
        }
        let campaign = Campaign::new(&scene, runner, phases, self.members, self.seed);
        let last = self.seed.saturating_add(self.members.saturating_sub(1));
        let (members, name, engine, first) = (self.members, &scene.name, runner.name(), self.seed);
        let words =
            format!("{members} members of {name:?} in {engine}, realizations {first} to {last}");
        self.place.create(campaign, program, &words)
    }
}
