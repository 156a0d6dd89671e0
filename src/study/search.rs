//! Which settings give the published figures? History matching over the choices of [`space`], in waves: a wave is a study;
//! the next one is planned among the settings that its rows have left.

pub mod bearing;
pub mod matching;
pub mod space;

use serde::{Deserialize, Serialize};

use crate::checks::{Check, Outcome};
use crate::document::{Axis, Colour, Document, Plot, Section, Shape, Table};
use crate::study::member::{Beds, Members, OfBeds};
use crate::study::realization::{OTHER_BED, Setting, Specification};
use crate::study::search::matching::{BINS, Expectation, Figure, Map, Observed, Search, keep};
use crate::study::search::space::{AXES, OF_POURING};
use crate::study::{Judged, StudyError};
use evidence::history::{CUT, Candidate, latin_hypercube, spread};
use evidence::random::{Key, Source};
use grains::scene::Scene;

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
        let beds = beds.iter().zip(loads.chunks(size.loads));
        let settings = beds.map(|(bed, loads)| {
            let whole = loads.iter().map(|load| [&bed[..], load].concat());
            whole.collect()
        });
        Plan::of(base, 1, settings.collect(), size.clouds, Vec::new())
    }

    /// The wave after this one, among the settings that are left; or why there is none: an emulator is worse than it says and may
    /// not exclude anything, or nothing is left.
    pub fn next(&self, found: &Search, size: Size) -> Result<Self, &'static str> {
        let why = "its emulators are not good enough to exclude settings; plan it with more beds";
        let fitted = found.fitted().filter(|_| found.is_sound()).ok_or(why)?;
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
        if beds.is_empty() {
            return Err("no setting is left");
        }
        let (base, before) = (self.base.clone(), found.observed.clone());
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

impl OfBeds for Plan {
    const NAME: &'static str = "search";

    fn beds(&self) -> &Beds {
        &self.beds
    }

    fn is_whole(&self) -> Result<(), String> {
        match self
            .beds
            .settings()
            .all(|setting| setting.at.len() == AXES.len())
        {
            true => Ok(()),
            false => Err("a setting has other coordinates than the space has axes".to_owned()),
        }
    }

    fn keeps(key: &str) -> bool {
        keep(key)
    }

    fn judged(&self, members: &Members) -> Result<Judged, StudyError> {
        let record = Search::of(self, members);
        Judged::of(Self::NAME, &record, record.document())
    }
}

/// Implausibilities up to these, and shares from these on, with how dense they are drawn.
const LEAST: [(f64, &str, f64); 3] = [
    (1.0, "below: implausibility up to 1", 1.0),
    (2.0, "up to 2", 0.6),
    (CUT, "up to 3", 0.28),
];
const LEFT: [(f64, &str, f64); 3] = [
    (0.1, "above: a tenth or more is left", 1.0),
    (0.01, "above: a hundredth or more", 0.6),
    (1.0e-9, "above: less", 0.28),
];
/// The side of a square in the picture, of the way from one to the next.
const SIDE: f64 = 0.76;

/// Settings in the table of the best.
const SHOWN: usize = 5;

impl Search {
    pub fn document(&self) -> Document {
        let checks: Vec<Check> = self
            .figures
            .iter()
            .map(|figure| self.check(figure))
            .collect();
        let title = "Which settings give the published figures?";
        Document::new(title, self.answer(), checks).with([
            self.maps(),
            self.targets(),
            self.controls(),
            self.best_settings(),
            self.at_odds(),
            self.bearing(),
            self.settings().as_details(),
        ])
    }

    fn answer(&self) -> String {
        let own = self.scene_digest != space::base(false).digest();
        let first = if own { OTHER_BED } else { "" };
        format!("{first}{}", self.of_the_space())
    }

    fn of_the_space(&self) -> String {
        let Some(best) = self.best.first() else {
            return "Nothing can be said yet: too few rows are there.".to_owned();
        };
        if !self.is_sound() {
            return "Nothing can be said yet: an emulator is worse than it says.".to_owned();
        }
        let farthest = best.implausibility;
        if self.is_none_left() {
            let odds = self.odds.first();
            let title = |index: usize| odds.map_or("", |pair| self.title(&pair.figures[index]));
            return format!(
                "No setting of this space gives all published figures: the least implausible one is at {farthest:.2}, beyond {CUT}. The \
                 hardest to have at once are {} and {}, at {:.2}.",
                title(0),
                title(1),
                odds.map_or(0.0, |pair| pair.least)
            );
        }
        // None of the candidates may be left, though better ones were found near the best of them.
        let share = match self.left > 0.0 {
            true => format!("{:.2} %", 100.0 * self.left),
            false => format!("Less than one in {}", self.candidates),
        };
        let has = space::told(&best.at);
        format!(
            "{share} of the settings looked at may give all published figures: no figure expected of them is more than {CUT} deviations from \
             the published one. The nearest setting has {has}; its farthest figure is {farthest:.2} deviations away. `study plan candidates` \
             decides by fresh packings."
        )
    }

    fn title<'a>(&'a self, id: &str) -> &'a str {
        let mut figures = self.figures.iter();
        figures
            .find(|figure| figure.id == id)
            .map_or("", |figure| &figure.title)
    }

    /// That the emulator is as good as it says.
    fn check(&self, figure: &Figure) -> Check {
        // Where it is not, nothing is decided.
        let outcome = Outcome::pass_or_skip(figure.is_sound());
        let found = format!("{:.2} times", figure.inflation);
        Check::of_words(
            format!("search/emulator/{}", figure.id),
            &format!("{}: errors of the emulator over what it says", figure.title),
            outcome,
            &found,
        )
        .judged_by(
            "95 % of the means are within so many times 1.96 deviations of what is expected without their bed",
            "deviations are made larger by that, up to 1.5 times; a worse emulator excludes nothing",
        )
        .required()
    }

    fn targets(&self) -> Section {
        let words = format!(
            "A setting's implausibility is the largest distance of what is expected from a published figure, in deviations of \
             both; beyond {CUT} it is excluded. What is expected comes from emulators of {} settings, each run on {} packings.",
            self.observed.len(),
            self.clouds
        );
        let title = "Targets and emulators";
        let table = Table::of("targets", title, &self.figures)
            .column("figure", |figure| &figure.title)
            .column("unit", |figure| &figure.unit)
            .column("published", |figure| figure.value)
            .column("known to", |figure| figure.deviation)
            .column("expected to, median", |figure| figure.uncertainty)
            .column("noise common to a bed's loads", |figure| figure.correlation)
            .column("deviations made larger, times", |figure| figure.inflation)
            .column("least implausibility alone", |figure| figure.least);
        Section::new("What is wanted", words).with(table)
    }

    /// Whether the search would have found figures that there are, and none where there are none.
    fn controls(&self) -> Section {
        let again = self.found_again.map_or(String::new(), |share| {
            format!(
                "With the results of a setting that was run as targets, and its bed unknown, the setting is left in {:.1} % of the cases \
                 ({:.1} to {:.1}). ",
                100.0 * share.estimate,
                100.0 * share.low,
                100.0 * share.high
            )
        });
        let impossible = self.of_impossible.map_or(String::new(), |least| {
            let left = if least > CUT { "nothing is left" } else { "something is left" };
            format!(
                "With figures that cannot be, the mean stresses at O and B exchanged, {left}: the least implausibility is {least:.1}."
            )
        });
        Section::new("Would the search find it?", again + &impossible)
    }

    fn best_settings(&self) -> Section {
        let best = &self.best[..self.best.len().min(SHOWN)];
        let row = |name: &str, published: Option<String>, cell: &dyn Fn(&Expectation) -> String| {
            let words: Vec<String> = best.iter().map(cell).collect();
            (name.to_owned(), published, words)
        };
        let axes = AXES.iter().enumerate();
        let axes = axes.map(|(index, axis)| {
            row(axis.name, None, &|expectation| {
                axis.scale.words(expectation.at[index])
            })
        });
        let figures = self.figures.iter().enumerate();
        let figures = figures.map(|(index, figure)| {
            let words = |[mean, deviation]: [f64; 2]| match figure.unit.as_str() {
                "Pa" => format!("{:.1} ± {:.1} kPa", 1.0e-3 * mean, 1.0e-3 * deviation),
                _ => format!("{mean:.3} ± {deviation:.3}"),
            };
            let published = words([figure.value, figure.deviation]);
            row(&figure.title, Some(published), &|expectation| {
                words(expectation.expected[index])
            })
        });
        let last = row("implausibility", None, &|expectation| {
            format!("{:.2}", expectation.implausibility)
        });
        let rows: Vec<_> = axes.chain(figures).chain([last]).collect();
        let table = Table::of("best", "The least implausible settings", &rows)
            .column("choice or figure", |row| &row.0)
            .column("published", |row| row.1.clone());
        let table = (0..best.len()).fold(table, |table, place| {
            table.column(&format!("setting {}", place + 1), |row| &row.2[place])
        });
        let words = "What is expected of them, with deviations.";
        Section::new("The best settings", words).with(table)
    }

    fn at_odds(&self) -> Section {
        let title = "Two figures at once: the larger of both implausibilities, at its least";
        let table = Table::of("odds", title, &self.odds)
            .column("figure", |pair| self.title(&pair.figures[0]))
            .column("with", |pair| self.title(&pair.figures[1]))
            .column("least", |pair| pair.least);
        let words = format!("Beyond {CUT} no setting gives both.");
        Section::new("Which figure stands against which", words).with(table)
    }

    /// Those that fit the choices; a record may come from anywhere.
    fn drawn(&self) -> impl Iterator<Item = &Map> {
        let fits = |map: &&Map| {
            let sizes = [map.least.len(), map.left.len()];
            map.axes.iter().all(|axis| *axis < AXES.len()) && sizes == [BINS * BINS; 2]
        };
        self.maps.iter().filter(fits)
    }

    /// The least implausibility of each bin of a choice, whatever the others are; none where there is no setting.
    fn least_of(&self, axis: usize) -> [Option<f64>; BINS] {
        let mut all = [None; BINS];
        for map in self.drawn().filter(|map| map.axes.contains(&axis)) {
            for (bin, least) in map.least.iter().enumerate() {
                let own = [bin % BINS, bin / BINS][usize::from(map.axes[1] == axis)];
                if let Some(least) = least {
                    all[own] = Some(all[own].map_or(*least, |value: f64| value.min(*least)));
                }
            }
        }
        all
    }

    /// Which choices matter.
    fn said(&self) -> String {
        if self.maps.is_empty() || !self.is_sound() || self.is_none_left() {
            return String::new();
        }
        let (mut parts, mut whole) = (Vec::new(), Vec::new());
        for (index, axis) in AXES.iter().enumerate() {
            let least = self.least_of(index).into_iter().enumerate();
            let bins = least.filter_map(|(bin, value)| Some((axis.scale.part(bin, BINS), value?)));
            let (all, least): (Vec<[f64; 2]>, Vec<f64>) = bins.unzip();
            let left = all.iter().zip(&least).filter(|pair| *pair.1 <= CUT);
            let left: Vec<[f64; 2]> = left.map(|pair| *pair.0).collect();
            let (title, unit) = space::split(axis.name);
            if left.len() == all.len() {
                whole.push(title);
                continue;
            }
            let [left, all] = [left, all].map(|ranges| axis.scale.told(&ranges));
            let left = format!("{left} {unit}");
            parts.push(format!("{title} {} (of {all})", left.trim_end()));
        }
        let mut said = match parts.is_empty() {
            true => "No choice alone excludes a setting.".to_owned(),
            false => format!(
                "These choices keep only a part of their range, whatever the others are: {}.",
                parts.join("; ")
            ),
        };
        if !whole.is_empty() {
            said += &format!(" Any value may do of: {}.", whole.join("; "));
        }
        said
    }

    /// A square for each pair of axes: the least implausibility below the diagonal, the share that is left above, and on it the names.
    fn maps(&self) -> Section {
        let caption = "Each square is a pair of choices, over all others: below the diagonal the least implausibility, above it \
                       the share of the settings that is left. On it stands the choice along its column and its row, over its own least \
                       implausibility.";
        let last = AXES.len() - 1;
        let within = |square: usize, at: f64| square as f64 + 0.5 + SIDE * (at - 0.5);
        let ticks = |square: &dyn Fn(usize) -> usize| {
            let all = AXES.iter().enumerate();
            let all = all.flat_map(|(index, axis)| {
                let ticks = axis.scale.ticks().into_iter();
                ticks.map(move |(at, words)| (within(square(index), at), words))
            });
            all.collect()
        };
        let side = Axis::linear("").within(0.0, AXES.len() as f64);
        let x = Axis {
            ticks: ticks(&|index| index),
            ..side.clone()
        };
        let y = Axis {
            ticks: ticks(&|index| last - index),
            ..side
        };
        let mut plot = Plot::new("pairs", caption, x, y).over_the_page();
        let mut groups: [Vec<([f64; 4], String)>; LEAST.len() + LEFT.len() + 1] =
            Default::default();
        let none = groups.len() - 1;
        let part = |axis: usize, bin: usize| AXES[axis].scale.part(bin, BINS);
        let drawn = |axis: usize, bin| part(axis, bin).map(|at| AXES[axis].scale.shown(at));
        let told = |axis: usize, bin: usize| {
            format!(
                "{} {}",
                AXES[axis].name,
                AXES[axis].scale.told(&[part(axis, bin)])
            )
        };
        let of_least = |least: f64| LEAST.iter().position(|class| least <= class.0);
        for map in self.drawn() {
            for (bin, found) in map.least.iter().enumerate() {
                let Some(least) = found else { continue };
                let bins = [bin % BINS, bin / BINS];
                let cell = |across: usize, upwards: usize| {
                    let [x, y] = [across, upwards].map(|side| drawn(map.axes[side], bins[side]));
                    let [left, right] = x.map(|at| within(map.axes[across], at));
                    let [low, high] = y.map(|at| within(last - map.axes[upwards], at));
                    [left, right, low, high]
                };
                let words = [0, 1]
                    .map(|side| told(map.axes[side], bins[side]))
                    .join("; ");
                let class = of_least(*least).unwrap_or(none);
                groups[class].push((cell(0, 1), format!("{words}: {least:.2}")));
                let share = map.left[bin];
                let class = LEFT.iter().position(|class| share >= class.0);
                let class = class.map_or(none, |index| LEAST.len() + index);
                groups[class].push((cell(1, 0), format!("{words}: {share:.4}")));
            }
        }
        let mut names = Vec::new();
        for (index, axis) in AXES.iter().enumerate() {
            let middle = [index, last - index].map(|square| square as f64 + 0.5);
            names.push(([middle[0], middle[1] + 0.07], axis.name.to_owned()));
            for (bin, least) in self.least_of(index).into_iter().enumerate() {
                let Some(least) = least else { continue };
                let [left, right] = drawn(index, bin).map(|at| within(index, at));
                let low = middle[1] - 0.5 * SIDE;
                let words = format!("{}: {least:.2}", told(index, bin));
                groups[of_least(least).unwrap_or(none)]
                    .push(([left, right, low, low + 0.1], words));
            }
        }
        let blue = LEAST.map(|class| (Colour::Blue, class));
        let red = LEFT.map(|class| (Colour::Vermilion, class));
        let grey = (Colour::Grey, (0.0, "excluded; none is left", 0.16));
        let classes = blue.into_iter().chain(red).chain([grey]);
        for (cells, (colour, (_, name, dense))) in groups.into_iter().zip(classes) {
            if !cells.is_empty() {
                plot = plot.with(name, colour, Shape::Cells(dense, cells));
            }
        }
        let plot = plot.with("", Colour::Grey, Shape::Words(names));
        Section::new("What is left", self.said()).with(plot)
    }

    fn settings(&self) -> Section {
        let title = "Every setting that was run, and its means";
        let table =
            Table::of("settings", title, &self.observed).column("bed", |observed| observed.bed);
        let axes = self.axes.iter().zip(&AXES).enumerate();
        let table = axes.fold(table, |table, (index, (name, axis))| {
            let words = |at: &f64| axis.scale.words(*at);
            table.column(name, |observed| observed.at.get(index).map(words))
        });
        let table = self.figures.iter().fold(table, |table, figure| {
            table.column(&figure.title, |observed| {
                observed.sampled.get(&figure.id).map(|sampled| sampled.mean)
            })
        });
        Section::new("Settings", "").with(table)
    }
}
