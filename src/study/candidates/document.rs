//! What the settings say: which figures they give, what the load adds where, and whether a slower punch adds anything else.

use evidence::Interval;
use evidence::distribution::Family;
use evidence::t_test::Finding;

use super::judge::{Candidates, Found, Halving, Judged, Layer, Parts, Verdict};
use super::{BEST, PRINTED, SPEED_AND_DAMPING, reasons};
use crate::checks::{Check, Outcome};
use crate::document::{Axis, Cell, Colour, Document, Plot, Point, Section, Shape, Table};
use crate::paper::published::{Of, POINTS, PUBLISHED, Published};
use crate::study::change::GRAINS;
use crate::study::realization::OTHER_BED;
use crate::study::search::space::{AXES, told};

/// So many settings are named in a sentence.
const NAMED: usize = 5;

const fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::ComesOut => "comes out",
        Verdict::DoesNot => "does not",
        Verdict::Undecided => "undecided",
        Verdict::Skipped => "too few packings",
    }
}

fn kilo(interval: Interval) -> Interval {
    interval.over(1.0e3)
}

/// For people: kPa with the half width of the interval.
fn kilopascals(stress: Option<Interval>) -> Cell {
    let words = |interval: Interval| {
        format!(
            "{:.2} ± {:.2}",
            interval.estimate,
            0.5 * (interval.high - interval.low)
        )
    };
    stress.map(kilo).map(words).into()
}

impl Candidates {
    pub fn document(&self) -> Document {
        let checks: Vec<Check> = self.settings.iter().map(Found::check).collect();
        let sections = [
            Some(self.figures()),
            self.one_at_a_time(),
            Some(self.taken_apart()),
            Some(self.laws()),
            self.limits(),
            self.settings(),
            Some(self.every_number().as_details()),
        ];
        let title = "Settings held against the published figures";
        Document::new(title, self.answer(), checks).with(sections.into_iter().flatten())
    }

    fn laws(&self) -> Section {
        // Settings that load the same bed have the same layers.
        let mut rows: Vec<(&Found, &Layer)> = Vec::new();
        for found in &self.settings {
            for layer in &found.layers {
                if rows.iter().all(|(_, seen)| *seen != layer) {
                    rows.push((found, layer));
                }
            }
        }
        let table = Table::of("laws", "Which law holds at which depth", rows)
            .column("setting", |(found, _)| found.name())
            .column("depth, m", |(_, layer)| layer.depth)
            .column("best, or not told from it", |(_, layer)| {
                let level = layer.level().map(Family::title);
                level.collect::<Vec<&str>>().join(", ")
            })
            .column("exponential: behind the best", |(_, layer)| {
                layer.exponential()
            })
            .column("packings", |(_, layer)| layer.packings);
        let words = "Single-grain stresses of the settled bed, over the mean of a layer of 10 cm, of grains that bear load. Each law is fitted to \
                     each packing; behind the best is a grain's mean logarithm of the density, over packings.";
        Section::new("Theory against theory, by depth", words).with(table)
    }

    fn setting(&self, id: &str) -> Option<&Found> {
        self.settings.iter().find(|found| found.setting.id == id)
    }

    fn named(&self, id: &str) -> &str {
        self.setting(id).map_or("", Found::name)
    }

    fn answer(&self) -> String {
        let [shown, open] = [Some(true), None].map(|wanted| {
            let matching = self
                .settings
                .iter()
                .filter(|found| found.gives_all() == wanted);
            matching.map(Found::described).collect::<Vec<String>>()
        });
        let names = |before: &str, settings: &[String]| match settings.len() {
            0 => String::new(),
            1..=NAMED => before.to_owned() + &settings.join(", "),
            many => format!("{before}{many} of them"),
        };
        let first = format!(
            "{}{} of {} settings were shown to give all published figures{}{}.",
            if self.grains != GRAINS { OTHER_BED } else { "" },
            shown.len(),
            self.settings.len(),
            names(": ", &shown),
            names("; undecided: ", &open)
        );
        let nearest = self.settings.iter().min_by_key(|found| {
            let come_out = found.count(Verdict::ComesOut);
            (found.missed().len(), found.figures.len() - come_out)
        });
        let nearest = nearest.filter(|found| !found.missed().is_empty());
        let nearest = nearest.map_or(String::new(), |found| {
            format!(
                " Least is missed by \"{}\": {}.",
                found.described(),
                found.missed().join("; ")
            )
        });
        let mut names: Vec<&str> = self
            .halvings
            .iter()
            .map(|halving| halving.name.as_str())
            .collect();
        names.dedup();
        let quiet = names.into_iter().map(|name| self.quasi_static(name));
        let quiet: String = quiet.collect();
        first + &nearest + &quiet
    }

    /// Whether a ladder of speeds ends where nothing changes any more, in words.
    fn quasi_static(&self, name: &str) -> String {
        let own = || self.halvings.iter().filter(|halving| halving.name == name);
        let Some(last) = own().next_back() else {
            return String::new();
        };
        match last.finding {
            Finding::Equivalent => {
                let all: Vec<&Halving> = own().collect();
                let changing = all
                    .iter()
                    .rposition(|halving| halving.finding != Finding::Equivalent);
                let from = &all[changing.map_or(0, |index| index + 1)].from;
                format!(
                    " Quasi-static from \"{}\" on: half of the speed changes the load's part by less than a tenth.",
                    self.named(from)
                )
            }
            Finding::Different => format!(
                " There is no quasi-static limit {name}, down to \"{}\", where {} of {} punches get the force.",
                self.named(&last.to),
                last.reached[1],
                last.all
            ),
            Finding::Undecided => {
                format!(" Whether there is a quasi-static limit {name} is undecided.")
            }
        }
    }

    fn figures(&self) -> Section {
        let table = Table::of(
            "settings",
            "Published figures, setting by setting",
            &self.settings,
        )
        .column("setting", |found| found.name())
        .column("come out", |found| found.count(Verdict::ComesOut))
        .column("undecided", Found::open)
        .column("do not come out", |found| found.missed().join("; "))
        .column("punches with the force", |found| {
            format!("{} of {}", found.endings.reached, found.endings.all())
        })
        .column("depth of the punch, mm", |found| {
            found.punch_depth.map(|depth| depth.over(1.0e-3))
        })
        .column(
            "share of the weight that the floor bears before the load",
            |found| found.by_floor,
        );
        let x = Axis::linear("ours over published, 95 %").within(0.0, 2.0);
        let names = self.settings.iter().map(|found| found.name());
        let y = Axis::of_names("", names);
        let last = self.settings.len() as f64 - 0.5;
        let band = [[0.9, -0.5, last], [1.1, -0.5, last]];
        let caption = "Means of local σ_zz at O, A and B over the published ones, with 95 % intervals; what lies beyond 2 stands at the edge. \
             A row without marks: too few punches got their force.";
        let band = Shape::Band(band.into());
        let mut plot = Plot::new("means", caption, x, y).with("a tenth", Colour::Grey, band);
        for (point, colour) in POINTS.iter().zip(Colour::OF_LINES) {
            let id = format!("stress.{point}");
            let rows = self.settings.iter().enumerate();
            let points = rows.filter_map(|(row, found)| {
                let judged = found.figures.iter().find(|judged| judged.id == id)?;
                let over = judged.value?.over(figure(judged)?.value);
                Some(crate::study::figures::in_row(&over, row, [0.0, 2.0], 1))
            });
            plot = plot.points(point, colour, points);
        }
        let words = format!(
            "{} clouds of {} grains; every setting has the same ones, and one bed bears all loads that it is poured for. A figure comes \
             out where its interval, of a level that counts all settings and figures, lies within the printed value and its \
             tolerance, and does not where it lies outside.",
            self.clouds, self.grains
        );
        Section::new("Which figures come out", words)
            .with(plot)
            .with(table)
    }

    /// Settings that are drawn: our default, the slowest on beds at rest, the best of the search.
    fn drawn(&self) -> Vec<&Found> {
        let slowest = |wanted: bool| {
            let mut all = self.settings.iter().rev();
            all.find(move |found| {
                let with = found.setting.id.starts_with("rest-friction");
                found.setting.id.starts_with("rest") && with == wanted && found.bears()
            })
        };
        let first = self.settings.first();
        let all = [first, slowest(false), slowest(true), self.setting(BEST)];
        all.into_iter().flatten().collect()
    }

    fn taken_apart(&self) -> Section {
        let control = |part: &&Parts| POINTS.contains(&&*part.point);
        let rows = self.settings.iter().flat_map(|found| {
            found
                .parts
                .iter()
                .filter(control)
                .map(move |part| (found, part))
        });
        let kilo = |stress: f64| format!("{:.2}", 1.0e-3 * stress);
        let table = Table::of(
            "parts",
            "Local mean of σ_zz, kPa, with 95 % intervals",
            rows,
        )
        .column("setting", |(found, _)| found.name())
        .column("point", |(_, part)| &part.point)
        .column("before the load", |(_, part)| kilopascals(part.before))
        .column("theory", move |(_, part)| kilo(part.theory[0]))
        .column("added by it", |(_, part)| kilopascals(part.added))
        .column("theory's load", move |(_, part)| kilo(part.theory[1]));
        let words = "The theory superposes the weight above a point and what a load on an elastic half-space adds. Here what the settled \
                     bed bears, and what the load adds to it in the same packing, as means over packings that got the force, \
                     both sides of the punch together. Settings that differ in loading have the same bed before it.";
        let section = Section::new("Taken apart", words);
        // Three points are no line.
        let lines = |found: &&Found| found.parts.len() > POINTS.len();
        let Some(first) = self.settings.first().filter(lines) else {
            return section.with(table);
        };
        let depth = first.parts.first().map_or(0.0, |part| part.depth);
        let aside = |part: &Parts| (part.depth == depth).then_some(part.offset);
        let below = |part: &Parts| (part.offset == 0.0).then_some(part.depth);
        let across = "horizontal distance from the punch's axis, m";
        let beside = "What the load adds at the control points' depth";
        let earlier = "What the bed bears there before the load";
        let under = "What the load adds under the punch";
        let plots = [
            self.along(["added-aside", beside, across], 1, aside),
            self.along(["before-aside", earlier, across], 0, aside),
            self.along(["added-below", under, "depth, m"], 1, below),
        ];
        section.with_all(plots).with(table)
    }

    /// What the bed bears before the load (0) or what the load adds (1), at the places that are given.
    fn along(
        &self,
        [name, caption, x]: [&str; 3],
        part: usize,
        place: impl Fn(&Parts) -> Option<f64>,
    ) -> Plot {
        let y = Axis::linear("local mean of σ_zz, kPa");
        let mut plot = Plot::new(name, caption, Axis::linear(x), y);
        let drawn = self.drawn();
        let sorted = |found: &Found| {
            let all = found.parts.iter();
            let all = all.filter_map(|parts| {
                Some((place(parts)?, [parts.before, parts.added], parts.theory))
            });
            let mut all: Vec<(f64, [Option<Interval>; 2], [f64; 2])> = all.collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            all.into_iter()
        };
        if let Some(first) = drawn.first() {
            let theory = sorted(first).map(|(at, _, theory)| [at, 1.0e-3 * theory[part]]);
            plot = plot.line("theory", Colour::Grey, theory);
        }
        for (setting, colour) in drawn.into_iter().zip(Colour::OF_LINES) {
            let points = sorted(setting).filter_map(|(at, found, _)| {
                let found = kilo(found[part]?);
                Some(Point::at(at, found.estimate).between(found.low, found.high))
            });
            plot = plot.points(setting.name(), colour, points);
        }
        plot
    }

    /// What each choice changes against our default; none where no choices were varied.
    fn one_at_a_time(&self) -> Option<Section> {
        let varied = |found: &&Found| reasons().any(|(name, _)| name == found.setting.axis);
        let own = self.settings.iter().filter(varied);
        own.clone().next()?;
        let means = PUBLISHED
            .iter()
            .enumerate()
            .filter(|(_, figure)| figure.statistic == Of::Mean);
        let table = Table::of("changes", "What a choice changes, with 95 % intervals", own)
            .column("setting", |found| found.name());
        let table = means.fold(table, |table, (index, figure)| {
            let heading = match figure.unit {
                "1" => figure.title.to_owned(),
                unit => format!("{}, {unit}", figure.title),
            };
            table.column(&heading, move |found| found.figures[index].change)
        });
        let is_varied = |name: &str| self.settings.iter().any(|found| found.setting.axis == name);
        let reasons = reasons().filter(|(name, _)| is_varied(name));
        let reasons = Table::of("reasons", "Why each choice is varied", reasons)
            .column("choice", |reason| reason.0)
            .column("what the paper says, and the range", |reason| reason.1);
        let base = self.settings.first().map_or("", |found| found.name());
        let crossed = match is_varied(SPEED_AND_DAMPING) {
            true => " (punch speed and damping are crossed)",
            false => "",
        };
        let words = format!(
            "Each setting is the first one ({base}) but for one choice{crossed}, on its clouds. A change is the mean of the differences on \
             the same cloud."
        );
        Some(
            Section::new("One choice at a time", words)
                .with(table)
                .with(reasons),
        )
    }

    /// None where no speeds were halved.
    fn limits(&self) -> Option<Section> {
        self.halvings.first()?;
        let more = |index: usize| {
            move |halving: &Halving| {
                let found = halving.more.get(index).copied().flatten()?;
                let [low, high] = [found.low, found.high].map(|share| 100.0 * share);
                Some(format!("{low:+.0} to {high:+.0} %"))
            }
        };
        let finding = |halving: &Halving| match halving.finding {
            Finding::Equivalent => "nothing changes",
            Finding::Different => "it changes",
            Finding::Undecided => "undecided",
        };
        let speed = |id: &str| {
            let found = self.setting(id);
            found.map_or(0.0, |found| found.setting.specification.scene.loading.speed)
        };
        let step = |halving: &Halving| {
            let [from, to] = [&halving.from, &halving.to].map(|id| speed(id));
            format!("{}: {from} to {to} m/s", halving.name)
        };
        let reached = |halving: &Halving| {
            let [before, after] = halving.reached;
            format!("{before}, then {after} of {}", halving.all)
        };
        let title = "What half of the speed adds more, of the theory's load (90 %)";
        let table = Table::of("halvings", title, &self.halvings)
            .column("bed at rest", step)
            .column("O", more(0))
            .column("A", more(1))
            .column("B", more(2))
            .column("punches with the force", reached)
            .column("finding", finding);
        let words = "A load is quasi-static where half of the punch's speed changes what it adds at no control point by a tenth of \
                     the theory's, on the same packings, nor the share of punches with the force (two one-sided tests at 5 %).";
        Some(Section::new("Is there a quasi-static limit?", words).with(table))
    }

    /// What the settings of the search and on beds at rest are.
    fn settings(&self) -> Option<Section> {
        self.halvings.first()?;
        let found = || {
            self.settings
                .iter()
                .filter(|found| found.setting.at.len() == AXES.len())
        };
        let title = "Choices of the search's settings, the least implausible first";
        let axes = Table::of("choices", title, AXES.iter().enumerate());
        let axes = axes.column("choice", |(_, axis)| axis.name);
        let table = found().fold(axes, |table, found| {
            table.column(found.name(), |(index, axis)| {
                axis.scale.words(found.setting.at[index])
            })
        });
        let section = Section::new(
            "Settings",
            "Our default has the paper's numbers, and choices of ours where it prints none. A bed is at rest at 10⁻⁶ of its largest kinetic energy. Friction \
             in loading is an angle of 0.3 rad between grains, after pouring without. Slower punches without friction go on for \
             very long and are left out. Table 2 prints no friction: a setting with friction in either stage contradicts it.",
        );
        Some(section.with_all(found().next().map(|_| table)))
    }

    fn every_number(&self) -> Section {
        let rows = self.settings.iter();
        let rows = rows.flat_map(|found| found.figures.iter().map(move |figure| (found, figure)));
        let table = Table::of("numbers", "Every figure of every setting", rows)
            .column("setting", |(found, _)| found.name())
            .column("figure", |(_, judged)| {
                figure(judged).map(|published| &published.title)
            })
            .column("published", |(_, judged)| {
                figure(judged).map(|published| published.value)
            })
            .column("ours (95 %)", |(_, judged)| judged.value)
            .column("unit", |(_, judged)| {
                figure(judged).map(|published| published.unit)
            })
            .column("verdict", |(_, judged)| word(judged.verdict))
            .column("bear nothing", |(_, judged)| judged.zeros)
            .column("packings", |(_, judged)| judged.packings);
        Section::new("Every number", "").with(table)
    }
}

fn figure(judged: &Judged) -> Option<&'static Published> {
    PUBLISHED.iter().find(|figure| figure.id == judged.id)
}

impl Found {
    /// Recorded plans call the search's least implausible setting by its number, and the default as printed.
    fn name(&self) -> &str {
        match self.setting.id.as_str() {
            BEST => "the search's best setting",
            "printed" => PRINTED,
            _ => &self.setting.name,
        }
    }

    /// Its name; of a setting of the search, with its choices.
    fn described(&self) -> String {
        let (name, at) = (self.name(), &self.setting.at);
        match at.len() == AXES.len() {
            true => format!("{name} ({})", told(at)),
            false => name.to_owned(),
        }
    }

    /// What does not come out, for people.
    fn missed(&self) -> Vec<&'static str> {
        let all = self.figures.iter();
        let all = all.filter(|judged| judged.verdict == Verdict::DoesNot);
        let all = all.filter_map(|judged| Some(&figure(judged)?.title[..]));
        let force = (!self.bears()).then_some("the force");
        force.into_iter().chain(all).collect()
    }

    /// Figures that are not decided.
    fn open(&self) -> usize {
        self.count(Verdict::Undecided) + self.count(Verdict::Skipped)
    }

    fn count(&self, verdict: Verdict) -> usize {
        let figures = self.figures.iter();
        figures.filter(|judged| judged.verdict == verdict).count()
    }

    /// That every figure is decided: which way is a finding.
    fn check(&self) -> Check {
        let open = self.open();
        let outcome = Outcome::pass_or_skip(open == 0);
        let found = format!("{open} of {} are undecided", self.figures.len());
        let quantity = format!("every published figure decided: {}", self.name());
        Check {
            n: self.endings.all() as u64,
            ..Check::of_words(
                format!("candidates/{}", self.setting.id),
                &quantity,
                outcome,
                &found,
            )
        }
        .judged_by(
            "intervals over packings of a level that counts all settings and figures",
            "the printed values and their tolerances",
        )
        .required()
    }
}
