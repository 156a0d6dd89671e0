//! Which settings give the published figures? History matching over the choices of [`space`], in waves: a wave is a study;
//! the next one is planned among the settings that its rows have left.

pub mod document;
pub mod matching;
pub mod space;

use std::path::Path;

use evidence::history::{Candidate, latin_hypercube, spread};
use evidence::random::{Key, Source};
use grains::scene::Scene;
use serde::{Deserialize, Serialize};

use crate::engine::EngineError;
use crate::study::machine::Folder;
use crate::study::member::{Beds, Member, Members};
use crate::study::realization::{Engines, Runner, Setting, Specification};
use crate::study::search::matching::{Observed, Search, keep};
use crate::study::search::space::{AXES, OF_POURING};
use crate::study::{Judged, Outline, Study, StudyError};

const KEY: Key = *b"crossgrain: settings of a search";
/// Clouds of a wave begin at a multiple of this, those of a bed at one of the next.
const OF_WAVE: u64 = 1_000_000;
const OF_BED: u64 = 1000;
/// Loads that are tried for a bed of the next wave, of which those that are left and far apart are taken.
const TRIED: usize = 300;

/// A wave.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    pub base: Scene,
    /// From 1 on.
    pub wave: u64,
    /// Each is loaded in its own settings, on its own clouds.
    pub beds: Beds,
    /// What earlier waves found.
    pub before: Vec<Observed>,
}

/// How large a wave is.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    pub beds: usize,
    /// Loads on each.
    pub loads: usize,
    /// Clouds of each bed.
    pub clouds: u64,
}

impl Plan {
    /// A wave over the whole space, its settings evenly spread.
    pub fn first(base: Scene, size: Size) -> Self {
        let source = &mut Source::new(&KEY, 0);
        let beds = latin_hypercube(source, size.beds, OF_POURING);
        let loads = latin_hypercube(source, size.beds * size.loads, AXES.len() - OF_POURING);
        let settings = beds
            .iter()
            .zip(loads.chunks(size.loads))
            .map(|(bed, loads)| {
                let whole = loads.iter().map(|load| [&bed[..], load].concat());
                whole.collect()
            });
        Plan::of(base, 1, settings.collect(), size.clouds, Vec::new())
    }

    /// The wave after this one, among the settings that are left.
    ///
    /// # Errors
    ///
    /// Why there is none: an emulator is worse than it says and may not exclude anything, or nothing is left.
    pub fn next(&self, found: &Search, size: Size) -> Result<Self, &'static str> {
        let fitted = found.fitted().filter(|_| found.is_sound());
        let fitted = fitted.ok_or(
            "its emulators are not good enough to exclude settings; plan it with more beds",
        )?;
        let matched = found.matched(&fitted);
        let left = found.left(&matched);
        let wave = self.wave + 1;
        let bed = |(index, at): (usize, Vec<f64>)| {
            let source = &mut Source::new(&KEY, OF_BED * wave + index as u64);
            let mut loads = vec![matched.candidate(at.clone())];
            for _ in 0..TRIED {
                let other = (OF_POURING..AXES.len()).map(|_| source.uniform());
                let all = at[..OF_POURING].iter().copied().chain(other);
                loads.push(matched.candidate(all.collect()));
            }
            loads.retain(Candidate::is_left);
            spread(&loads, size.loads)
        };
        let beds = spread(&left, size.beds).into_iter().enumerate().map(bed);
        let beds: Vec<Vec<Vec<f64>>> = beds.filter(|loads| !loads.is_empty()).collect();
        let before = found.observed.clone();
        if beds.is_empty() {
            return Err("no setting is left");
        }
        let base = self.base.clone();
        Ok(Plan::of(base, wave, beds, size.clouds, before))
    }

    fn of(
        base: Scene,
        wave: u64,
        beds: Vec<Vec<Vec<f64>>>,
        clouds: u64,
        before: Vec<Observed>,
    ) -> Self {
        let settings = beds.into_iter().enumerate().map(|(bed, loads)| {
            let first = OF_WAVE * wave + OF_BED * bed as u64;
            let setting = |(load, mut at): (usize, Vec<f64>)| {
                space::snap(&mut at);
                let [bed, load] = [bed + 1, load + 1];
                Setting {
                    id: format!("wave-{wave}-bed-{bed}-load-{load}"),
                    name: format!("wave {wave}, bed {bed}, load {load}"),
                    axis: "search".to_owned(),
                    specification: Specification::native(space::scene(&base, &at)),
                    clouds: vec![[first, first + clouds - 1]],
                    at,
                }
            };
            loads.into_iter().enumerate().map(setting).collect()
        });
        Plan {
            beds: Beds(settings.collect()),
            base,
            wave,
            before,
        }
    }
}

impl Study for Plan {
    const KIND: &'static str = "search";
    type Row = Vec<Member>;

    fn count(&self) -> u64 {
        self.beds.count()
    }

    fn check(&self) -> Result<(), String> {
        let mut all = self.beds.settings();
        if !all.all(|of| of.at.len() == AXES.len()) {
            return Err("a setting has other coordinates than the space has axes".to_owned());
        }
        self.beds.check()
    }

    fn runner(&self, _: u64) -> Runner {
        Runner::Native
    }

    fn identity(&self, task: u64) -> String {
        self.beds.identity(task)
    }

    fn run(&self, task: u64, _: &Engines, _: &Path) -> Result<Vec<Member>, EngineError> {
        self.beds.run(task, keep)
    }

    fn belongs(&self, task: u64, row: &Vec<Member>) -> bool {
        self.beds.belongs(task, row)
    }

    fn outline(&self, row: &Vec<Member>) -> Outline {
        Beds::outline(row)
    }

    fn judge(folder: &Folder<Self>) -> Result<Judged, StudyError> {
        let mut members = Vec::new();
        folder.each(|_, row| members.extend(row))?;
        let members: Members = members.into_iter().collect();
        let record = Search::of(&folder.plan.study, &members);
        Judged::of(Self::KIND, &record, record.document())
    }
}
