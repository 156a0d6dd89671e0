//! Which settings give the published figures? History matching over the choices of [`space`], in waves: a wave is a study;
//! the next one is planned among the settings that its rows have left.

pub mod matching;
pub mod space;

use serde::{Deserialize, Serialize};

use crate::checks::{Check, Outcome, verdict};
use crate::document::{Axis, Colour, Document, Plot, Point, Section, Table};
use crate::study::member::{Beds, Members, OfBeds};
use crate::study::realization::{OTHER_BED, Setting, Specification};
use crate::study::search::matching::{BINS, Expectation, Figure, Observed, Search, keep};
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
        match self.beds.settings().all(|of| of.at.len() == AXES.len()) {
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

/// Implausibilities up to these, and shares from these on, with their colours.
const LEAST: [(f64, &str, Colour); 4] = [
    (1.0, "below: implausibility up to 1", Colour::Blue),
    (2.0, "to 2", Colour::Sky),
    (CUT, "to 3", Colour::Green),
    (f64::INFINITY, "beyond, excluded", Colour::Grey),
];
const LEFT: [(f64, &str, Colour); 3] = [
    (0.1, "above: a tenth or more is left", Colour::Purple),
    (
        0.01,
        "above: a hundredth or more is left",
        Colour::Vermilion,
    ),
    (1.0e-9, "above: less is left", Colour::Ochre),
];

/// Settings in the table of the best.
const SHOWN: usize = 5;

impl Search {
    pub fn document(&self) -> Document {
        let checks: Vec<Check> = self.figures.iter().map(|of| self.check(of)).collect();
        Document {
            title: "Which settings give the published figures?".to_owned(),
            verdict: verdict(&checks),
            answer: self.answer(),
            sections: vec![
                self.targets(),
                self.controls(),
                self.best_settings(),
                self.at_odds(),
                self.maps(),
                self.settings().as_details(),
            ],
            checks,
        }
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
            let title = |index: usize| odds.map_or("", |of| self.title(&of.figures[index]));
            return format!(
                "No setting of this space gives all published figures: the least implausible one is at {farthest:.2}, beyond {CUT}. The \
                 hardest to have at once are {} and {}, at {:.2}.",
                title(0),
                title(1),
                odds.map_or(0.0, |of| of.least)
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
        figures.find(|of| of.id == id).map_or("", |of| &of.title)
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
            .column("figure", |of| &of.title)
            .column("unit", |of| &of.unit)
            .column("published", |of| of.value)
            .column("known to", |of| of.deviation)
            .column("expected to, median", |of| of.uncertainty)
            .column("noise common to a bed's loads", |of| of.correlation)
            .column("deviations made larger, times", |of| of.inflation)
            .column("least implausibility alone", |of| of.least);
        Section::new("What is wanted", words).with(table)
    }

    /// Whether the search would have found figures that there are, and none where there are none.
    fn controls(&self) -> Section {
        let again = self.found_again.map_or(String::new(), |of| {
            format!(
                "With the results of a setting that was run as targets, and its bed unknown, the setting is left in {:.1} % of the cases \
                 ({:.1} to {:.1}). ",
                100.0 * of.estimate,
                100.0 * of.low,
                100.0 * of.high
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
        let row = |name: &str, published: Option<String>, of: &dyn Fn(&Expectation) -> String| {
            let words: Vec<String> = best.iter().map(of).collect();
            (name.to_owned(), published, words)
        };
        let axes = AXES.iter().enumerate();
        let axes =
            axes.map(|(index, axis)| row(axis.name, None, &|of| axis.scale.words(of.at[index])));
        let figures = self.figures.iter().enumerate();
        let figures = figures.map(|(index, figure)| {
            let words = |[mean, deviation]: [f64; 2]| match figure.unit.as_str() {
                "Pa" => format!("{:.1} ± {:.1} kPa", 1.0e-3 * mean, 1.0e-3 * deviation),
                _ => format!("{mean:.3} ± {deviation:.3}"),
            };
            let published = words([figure.value, figure.deviation]);
            row(&figure.title, Some(published), &|of| {
                words(of.expected[index])
            })
        });
        let last = row("implausibility", None, &|of| {
            format!("{:.2}", of.implausibility)
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
            .column("figure", |of| self.title(&of.figures[0]))
            .column("with", |of| self.title(&of.figures[1]))
            .column("least", |of| of.least);
        let words = format!("Beyond {CUT} no setting gives both.");
        Section::new("Which figure stands against which", words).with(table)
    }

    /// A square for each pair of axes: the least implausibility below the diagonal, the share that is left above.
    fn maps(&self) -> Section {
        let short = |of: &space::Axis| of.name.split(',').next().unwrap_or(of.name);
        let with_ends = |of: &space::Axis| {
            let [low, high] = [0.0, 1.0].map(|at| of.scale.words(at));
            format!("{}: {low} … {high}", of.name)
        };
        let caption = "Each square is a pair of choices, over all others: below the diagonal the least implausibility, above it \
                       the share of the settings that is left. In a square values grow to the right and upwards, over the range \
                       beside the name.";
        let x = Axis::of_names("", AXES.iter().map(short));
        let y = Axis::of_names("", AXES.iter().map(with_ends));
        let mut plot = Plot::new("pairs", caption, x, y);
        let place =
            |axis: usize, bin: usize| axis as f64 + 0.9 * ((bin as f64 + 0.5) / BINS as f64 - 0.5);
        let mut groups: [Vec<Point>; LEAST.len() + LEFT.len()] = Default::default();
        for map in &self.maps {
            let [first, second] = map.axes;
            for bin in 0..BINS * BINS {
                let (column, row) = (bin % BINS, bin / BINS);
                // The first name stands on top, and values grow upwards in each square.
                let at = Point::at(place(first, column), place(second, BINS - 1 - row));
                let found = map.least[bin];
                let class = |least: f64| LEAST.iter().position(|of| least <= of.0);
                if let Some(class) = found.and_then(class) {
                    groups[class].push(at);
                }
                let at = Point::at(place(second, row), place(first, BINS - 1 - column));
                if let Some(class) = LEFT.iter().position(|of| map.left[bin] >= of.0) {
                    groups[LEAST.len() + class].push(at);
                }
            }
        }
        for (points, (_, name, colour)) in groups.into_iter().zip(LEAST.into_iter().chain(LEFT)) {
            plot = plot.points(name, colour, points);
        }
        Section::new("What is left", "").with(plot)
    }

    fn settings(&self) -> Section {
        let title = "Every setting that was run, and its means";
        let table = Table::of("settings", title, &self.observed).column("bed", |of| of.bed);
        let axes = self.axes.iter().zip(&AXES).enumerate();
        let table = axes.fold(table, |table, (index, (name, axis))| {
            let words = |at: &f64| axis.scale.words(*at);
            table.column(name, |of| of.at.get(index).map(words))
        });
        let table = self.figures.iter().fold(table, |table, figure| {
            table.column(&figure.title, |of| of.of.get(&figure.id).map(|of| of.mean))
        });
        Section::new("Settings", "").with(table)
    }
}
