//! Which settings give the published figures? History matching over the choices of [`space`], in waves: a wave is a study;
//! the next one is planned among the settings that its rows have left.

pub mod matching;
pub mod space;

use serde::{Deserialize, Serialize};

use crate::checks::{Check, Outcome, verdict};
use crate::document::{Axis, Cell, Colour, Document, Plot, Point, Section, Table};
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
        let [one, other] = self.odds.first().map_or(["", ""], |of| {
            [0, 1].map(|index| self.title(&of.figures[index]))
        });
        let odds = self.odds.first().map_or(0.0, |of| of.least);
        if !self.is_sound() {
            return "Nothing can be said yet: an emulator is worse than it says.".to_owned();
        }
        if self.is_none_left() {
            return format!(
                "No setting of this space gives all published figures: the least implausible one is at {:.2}, beyond {CUT}. The \
                 hardest to have at once are {one} and {other}, at {odds:.2}.",
                best.implausibility
            );
        }
        format!(
            "{} of the settings looked at may give all published figures: no figure expected of them is more than {CUT} deviations from \
             the published one. The nearest setting has {}; its farthest figure is {:.2} deviations away. `study plan candidates` decides \
             by fresh packings.",
            self.share_left(),
            space::told(&best.at),
            best.implausibility
        )
    }

    /// Of so many candidates none may be left, though better ones were found near the best of them.
    fn share_left(&self) -> String {
        match self.left > 0.0 {
            true => format!("{:.2} %", 100.0 * self.left),
            false => format!("Less than one in {}", self.candidates),
        }
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
        let best = || self.best.iter().take(SHOWN);
        let names = (1..)
            .zip(best())
            .map(|(place, _)| format!("setting {place}"));
        let names: Vec<String> = ["choice or figure".into(), "published".into()]
            .into_iter()
            .chain(names)
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut table = Table::new("best", "The least implausible settings", &names);
        let mut row = |name: &str, published: Cell, of: &dyn Fn(&Expectation) -> Cell| {
            let first = [Cell::from(name), published];
            table.row(first.into_iter().chain(best().map(of)));
        };
        for (index, axis) in AXES.iter().enumerate() {
            let words = |of: &Expectation| axis.scale.words(of.at[index]).into();
            row(axis.name, Cell::Missing, &words);
        }
        for (index, figure) in self.figures.iter().enumerate() {
            let words = |mean: f64, deviation: f64| match figure.unit.as_str() {
                "Pa" => format!("{:.1} ± {:.1} kPa", 1.0e-3 * mean, 1.0e-3 * deviation),
                _ => format!("{mean:.3} ± {deviation:.3}"),
            };
            let published = words(figure.value, figure.deviation);
            row(&figure.title, published.into(), &|of| {
                let [mean, deviation] = of.expected[index];
                words(mean, deviation).into()
            });
        }
        row("implausibility", Cell::Missing, &|of| {
            format!("{:.2}", of.implausibility).into()
        });
        Section::new(
            "The best settings",
            "What is expected of them, with deviations.",
        )
        .with(table)
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
        let mut least: [Vec<Point>; 4] = Default::default();
        let mut left: [Vec<Point>; 3] = Default::default();
        for map in &self.maps {
            let [first, second] = map.axes;
            for bin in 0..BINS * BINS {
                let (column, row) = (bin % BINS, bin / BINS);
                // The first name stands on top, and values grow upwards in each square.
                let at = Point::at(place(first, column), place(second, BINS - 1 - row));
                let found = map.least[bin];
                let class = |least: f64| LEAST.iter().position(|of| least <= of.0);
                if let Some(class) = found.and_then(class) {
                    least[class].push(at);
                }
                let at = Point::at(place(second, row), place(first, BINS - 1 - column));
                if let Some(class) = LEFT.iter().position(|of| map.left[bin] >= of.0) {
                    left[class].push(at);
                }
            }
        }
        let least = least.into_iter().zip(LEAST);
        for (points, (_, name, colour)) in least.chain(left.into_iter().zip(LEFT)) {
            plot = plot.points(name, colour, points);
        }
        Section::new("What is left", "").with(plot)
    }

    fn settings(&self) -> Section {
        let mut names = vec!["bed"];
        names.extend(self.axes.iter().map(String::as_str));
        names.extend(self.figures.iter().map(|of| of.title.as_str()));
        let mut table = Table::new(
            "settings",
            "Every setting that was run, and its means",
            &names,
        );
        for of in &self.observed {
            let axes = of
                .at
                .iter()
                .zip(&AXES)
                .map(|(at, axis)| Cell::Text(axis.scale.words(*at)));
            let means = self
                .figures
                .iter()
                .map(|figure| of.of.get(&figure.id).map(|of| of.mean).into());
            table.row(
                std::iter::once(Cell::Count(of.bed))
                    .chain(axes)
                    .chain(means),
            );
        }
        Section::new("Settings", "").with(table)
    }
}
