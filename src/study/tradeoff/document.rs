//! What the comparison of cost and error says.

use std::collections::BTreeMap;

use super::judge::{Judgement, MISSED_KEY, MISSED_TITLE, Worst, word};
use super::plan::{FRICTIONAL, is_frictional};
use super::{Point, Tradeoff};
use crate::document::{Axis, Colour, Document, Plot, Section, Shape, Style, Table, plot};
use crate::study::figures::in_row;
use crate::study::realization::{Runner, Specification};
use evidence::Interval;
use evidence::t_test::Finding;
use grains::native::pouring::{End, Phase};
use grains::scene::TimeStep;

/// Errors below this share of a margin are drawn there: no margin is known that well.
const LOWEST: f64 = 0.3;

impl Tradeoff {
    pub fn document(&self) -> Document {
        Document::new("Cost against error", self.answer(), self.checks()).with([
            self.cost_and_error(),
            self.equivalence(),
            self.compared(),
            self.every_quantity(),
            self.orders(),
        ])
    }

    fn answer(&self) -> String {
        let clouds = self.confirmatory;
        let chosen = self.recommended.as_ref().and_then(|id| self.point(id));
        match chosen {
            Some(point) => {
                let seconds = |point| seconds(point).unwrap_or(f64::NAN);
                let [here, reference] = [point, &self.reference].map(seconds);
                format!(
                    "{:.1} times as fast: {} is recommended. Beds made so are equivalent to the reference's in every quantity with a \
                     margin over {clouds} clouds, at {here:.2} s of one core a realization; the reference takes {reference:.2} s.",
                    reference / here,
                    described(&point.method.specification),
                )
            }
            None if clouds == 0 => {
                "What each method costs, and how wrong it is. Which are equivalent was not tested (--confirm), so none is recommended.".to_owned()
            }
            None => format!(
                "No method is recommended: no candidate was shown to be equivalent over {clouds} clouds."
            ),
        }
    }

    fn cost_and_error(&self) -> Section {
        let words = format!(
            "Every method pours, settles, loads and measures beds of {} grains, on {} clouds (expensive methods on fewer). Each \
             result is paired with the reference's on the same cloud. A bias is divided by a margin that was set before the \
             runs; below 1 it does not matter. Two runs of one cloud diverge, so the difference of a few pairs is mostly \
             chance: the null comparison is the reference against itself on other clouds. Methods with friction are held against \
             the same scene with friction, whose own point is its null comparison. {IN_NAMES}",
            self.grains, self.screening
        );
        let chart = self.chart();
        let drawn = chart.marks.iter().any(|mark| mark.points().is_some());
        Section::new("Cost against error", self.said())
            .with_all(drawn.then_some(chart))
            .with(words)
            .with(self.by_cost())
            .with_all(self.remarks())
            .with(
                "A method is dominated by the cheapest one that costs no more and errs no more, by the estimates; where the intervals \
                 overlap it is only perhaps dominated. Methods with friction are compared with each other only. Processor times are those of \
                 single threads while all cores were busy; the steps do not depend on that.",
            )
    }

    /// Methods that are not dominated, the cheapest first, with costs and errors.
    pub fn front(&self, frictional: bool) -> Vec<(&Point, f64, Interval)> {
        let own = self.points.iter();
        let own = own.filter(|point| is_frictional(&point.method) == frictional);
        let own = own.filter(|point| point.dominated_by.is_none());
        let mut front: Vec<_> = own
            .filter_map(|point| point.place().map(|(cost, error)| (point, cost, error)))
            .collect();
        front.sort_by(|a, b| a.1.total_cmp(&b.1));
        front
    }

    /// What the chart says.
    fn said(&self) -> String {
        let front = self.front(false);
        if front.is_empty() {
            return "No method has an error yet: that takes two clouds, and a load.".to_owned();
        }
        let plain = |point: &&Point| !is_frictional(&point.method) && point.place().is_some();
        let all = self.points.iter().filter(plain).count();
        let sound = front.iter().find(|(.., error)| error.low <= 1.0);
        let sound = sound.map_or(
            "every one of them is shown to err beyond a margin".to_owned(),
            |(point, cost, _)| {
                format!(
                    "the cheapest of them that is not shown to err beyond a margin is {}, at {cost:.2} s against the reference's {:.2} s",
                    point.method.name,
                    seconds(&self.reference).unwrap_or(f64::NAN)
                )
            },
        );
        format!(
            "Of {all} methods without friction {} are on the front, where nothing as cheap errs less: {sound}.",
            front.len()
        )
    }

    fn chart(&self) -> Plot {
        let all = || self.points.iter().chain([&self.reference]);
        let lacking = self
            .points
            .iter()
            .filter(|point| point.screened.error().is_none());
        let lacking: Vec<&str> = lacking.map(|point| point.method.name.as_str()).collect();
        let lacking = match lacking.is_empty() {
            true => String::new(),
            false => format!(
                " Not drawn, without an error of both beds: {}.",
                lacking.join("; ")
            ),
        };
        let caption = format!(
            "Error: the largest bias over its margin, of the settled and of the loaded bed. Filled and named: the front, which no method \
             with less or as much cost undercuts. Pale: dominated. Rings: references against themselves on other clouds, what chance \
             alone gives. Bars: 95 % intervals. What is below {LOWEST} is drawn there.{lacking}"
        );
        let x = Axis::logarithmic("processor time of one realization, s");
        let y = Axis::logarithmic("error over margin");
        let mut plot = Plot::new("cost-and-error", caption, x, y).over_the_page();
        let place = |point: &Point, judged: &Judgement| {
            let error = judged.error()?;
            let [y, low, high] =
                [error.estimate, error.low, error.high].map(|value| value.max(LOWEST));
            Some((plot::Point::at(seconds(point)?, y), [low, high]))
        };
        let external = self
            .points
            .iter()
            .find(|point| point.method.specification.runner == Runner::External);
        let external = external.map_or("", |point| &point.method.name);
        let engines = [
            ("native", Colour::Blue),
            ("YADE", Colour::Vermilion),
            (external, Colour::Green),
        ];
        let of_engine = |point: &Point| match point.method.specification.runner {
            Runner::Native => 0,
            Runner::External => 2,
            _ => 1,
        };
        for (engine, (name, colour)) in engines.into_iter().enumerate() {
            let pale = self
                .points
                .iter()
                .filter(|point| point.dominated_by.is_some());
            let pale = pale.filter(|point| of_engine(point) == engine);
            let pale = pale.filter_map(|shown| {
                let (point, _) = place(shown, &shown.screened)?;
                Some(point.labelled(shown.method.name.clone()))
            });
            plot = plot.group(name, colour, Style::Pale, pale);
        }
        for (frictional, name) in [(false, "front"), (true, "front with friction")] {
            let front = self.front(frictional);
            let mut points: Vec<[f64; 2]> = Vec::new();
            for (_, cost, error) in &front {
                let level = points.last().map(|last| [*cost, last[1]]);
                points.extend(
                    level
                        .into_iter()
                        .chain([[*cost, error.estimate.max(LOWEST)]]),
                );
            }
            let dashed = frictional;
            if points.len() > 1 {
                plot = plot.with(name, Colour::Grey, Shape::Line { dashed, points });
            }
            for (engine, (name, colour)) in engines.into_iter().enumerate() {
                let own = front.iter().filter(|entry| of_engine(entry.0) == engine);
                let own = own.filter_map(|(shown, ..)| {
                    let (point, [low, high]) = place(shown, &shown.screened)?;
                    let chosen = self.recommended.as_ref() == Some(&shown.method.id);
                    let more = if chosen { ": recommended" } else { "" };
                    let label = format!("{}{more}", shown.method.name);
                    Some(point.between(low, high).labelled(label))
                });
                plot = plot.group(name, colour, Style::Filled, own);
            }
        }
        let references = all().filter_map(|reference| {
            let (judged, name) = match reference.method.id.as_str() {
                FRICTIONAL => (&reference.screened, reference.method.name.as_str()),
                id if id == self.reference.method.id => (&self.null_comparison, "the reference"),
                _ => return None,
            };
            let (point, [low, high]) = place(reference, judged)?;
            Some(point.between(low, high).labelled(name.to_owned()))
        });
        plot.group(
            "a reference against itself",
            Colour::Grey,
            Style::Hollow,
            references,
        )
        .level("margin", Colour::Sky, 1.0)
    }

    fn by_cost(&self) -> Table {
        let itself = Judgement {
            bed: None,
            load: None,
            ..self.reference.screened.clone()
        };
        let mut points: Vec<&Point> = self.points.iter().collect();
        let cost = |point: &Point| seconds(point).unwrap_or(f64::INFINITY);
        points.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        let words = "the reference on other clouds: null comparison";
        let judged = [("the reference", &itself), (words, &self.null_comparison)];
        let references = judged.map(|(name, judged)| (name, &self.reference, judged));
        let points = points.into_iter();
        let points = points.map(|point| (point.method.name.as_str(), point, &point.screened));
        let rows = references.into_iter().chain(points);
        let error = |worst: &Option<Worst>| Some(worst.as_ref()?.error);
        let largest = |judgement: &Judgement| {
            let worsts = judgement.bed.iter().chain(&judgement.load);
            let worst = worsts.max_by(|a, b| a.error.estimate.total_cmp(&b.error.estimate))?;
            Some(self.title(&worst.key).to_owned())
        };
        let made = |judgement: &Judgement| Some(judgement.endings.all()).filter(|all| *all > 0);
        let by = |point: &Point| {
            let id = point.dominated_by.as_ref()?;
            let name = self
                .point(id)
                .map_or(id.as_str(), |other| &other.method.name);
            let perhaps = if point.clearly { "" } else { "perhaps " };
            Some(format!("{perhaps}{name}"))
        };
        Table::of("methods", "Every method, by cost", rows)
            .column("method", |(name, ..)| name)
            .column("processor time, median, s", |(_, point, _)| seconds(point))
            .column("steps of pouring", |(_, point, _)| {
                point.costs.map(|costs| costs.pour_steps)
            })
            .column("steps of loading", |(_, point, _)| {
                point.costs.map(|costs| costs.load_steps)
            })
            .column("missed the load", |(.., judgement)| {
                made(judgement).map(|_| judgement.endings.missed())
            })
            .column("of", |(.., judgement)| made(judgement))
            .column("error of the settled bed", |(.., judgement)| {
                error(&judgement.bed)
            })
            .column("error of the loaded bed", |(.., judgement)| {
                error(&judgement.load)
            })
            .column("largest in", |(.., judgement)| largest(judgement))
            .column("dominated by", |(_, point, _)| by(point))
            .into()
    }

    /// What is to be said of methods, each with whom it is said of.
    fn remarks(&self) -> impl Iterator<Item = String> {
        let mut all: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for point in [&self.reference].into_iter().chain(&self.points) {
            for remark in remarks(point) {
                all.entry(remark).or_default().push(&point.method.name);
            }
        }
        let all = all.into_iter();
        all.map(|(remark, names)| format!("{}: {remark}.", names.join("; ")))
    }

    fn title<'a>(&'a self, key: &'a str) -> &'a str {
        if key == MISSED_KEY {
            return MISSED_TITLE;
        }
        let found = self.quantities.iter().find(|quantity| quantity.key == key);
        found.map_or(key, |quantity| &quantity.title)
    }

    fn equivalence(&self) -> Section {
        let tested = || {
            let points = self.points.iter();
            points.filter_map(|point| Some((point, point.confirmed.as_ref()?)))
        };
        if tested().next().is_none() {
            return Section::new("Equivalence", "Equivalence was not tested in this study.");
        }
        let words = "Candidates for a faster protocol were run on clouds that did not help to choose them. A candidate is \
                     equivalent if the 90 % interval of every bias with a margin lies within the margin (two one-sided t \
                     tests at 5 %), and so does the share of missed loads. The unit is the packing, never the grain.";
        let correlations = |judged: &Judgement, least: fn(f64, f64) -> f64| {
            let all = judged.differences.iter();
            all.filter_map(|difference| difference.paired.correlation)
                .reduce(least)
        };
        let not_shown = |judged: &Judgement| {
            let all = judged.not_shown();
            (!all.is_empty()).then(|| all.join(", "))
        };
        let table = Table::of("candidates", "Tests of equivalence", tested())
            .column("candidate", |(point, _)| &point.method.name)
            .column("finding", |(_, judged)| word(judged.finding()))
            .column("clouds", |(_, judged)| judged.clouds)
            .column("processor time, median, s", |(point, _)| seconds(point))
            .column("missed the load", |(_, judged)| judged.endings.missed())
            .column("least correlation of the pairs", |(_, judged)| {
                correlations(judged, f64::min)
            })
            .column("largest correlation of the pairs", |(_, judged)| {
                correlations(judged, f64::max)
            })
            .column("not shown", |(_, judged)| not_shown(judged));
        let section = Section::new("Equivalence", words).with(table);
        tested().fold(section, |section, (point, judged)| {
            let quantities = self
                .quantities
                .iter()
                .filter(|quantity| quantity.margin.is_some());
            let rows = quantities
                .map(|quantity| (quantity.title.to_string(), judged, quantity.key.as_ref()));
            let name = format!("equivalence-of-{}", point.method.id);
            let method = &point.method.name;
            let caption = format!("{method}: bias of every quantity over its margin.");
            section.with(forest(&name, &caption, rows.collect()))
        })
    }

    fn compared(&self) -> Section {
        let title = "Quantities and their margins";
        let table = Table::of("quantities", title, &self.quantities)
            .column("quantity", |quantity| quantity.title.as_ref())
            .column("unit", |quantity| quantity.unit.as_ref())
            .column("mean of the reference", |quantity| {
                quantity.reference.map(|reference| reference.mean)
            })
            .column("standard deviation", |quantity| {
                quantity.reference.map(|reference| reference.deviation)
            })
            .column("packings", |quantity| {
                quantity.reference.map(|reference| reference.count)
            })
            .column("margin", |quantity| quantity.margin)
            .column("reason", |quantity| quantity.reason.as_ref());
        Section::new("What is compared, and the margins", "").with(table)
    }

    fn every_quantity(&self) -> Section {
        let words = "Bias over margin with its 90 % interval. Green: within the margin. Vermilion: beyond it. Grey: too few \
                     packings to say.";
        let section = Section::new("Every quantity, every method", words).as_details();
        let quantities = self
            .quantities
            .iter()
            .filter(|quantity| quantity.margin.is_some());
        quantities.fold(section, |section, quantity| {
            let rows = self.points.iter();
            let rows = rows.map(|at| (at.method.name.clone(), &at.screened, quantity.key.as_ref()));
            let name = format!("bias-of-{}", quantity.key.replace(['.', '_'], "-"));
            let (title, reason) = (&quantity.title, &quantity.reason);
            let caption = format!("Bias of {title} over its margin. The margin: {reason}.");
            section.with(forest(&name, &caption, rows.collect()))
        })
    }

    fn orders(&self) -> Section {
        let title = "Order of convergence, fitted up to the default step of 0.45";
        let table = Table::of("orders", title, &self.convergence)
            .column("case", |case| &case.title)
            .column("error of", |case| &case.error_of)
            .column("order", |case| case.order)
            .column("theory", |case| case.expected);
        let x = Axis::logarithmic("time step over √(m/k)");
        let y = Axis::logarithmic("error");
        let caption = "Errors of exact cases over the time step.";
        let mut plot = Plot::new("order-of-convergence", caption, x, y);
        let colours = [Colour::Blue, Colour::Vermilion, Colour::Green];
        for (case, colour) in self.convergence.iter().zip(colours) {
            let points = case.points.iter().map(|(x, y)| [*x, *y]);
            plot = plot.line(&case.title, colour, points);
        }
        let words = "Where nothing is chaotic the error falls with the square of the time step.";
        let drawn = Some(plot).filter(|plot| !plot.marks.is_empty());
        Section::new("Order of convergence", words)
            .with(table)
            .with_all(drawn)
    }
}

/// What short names leave out, those of recorded studies too.
const IN_NAMES: &str = "In the names of methods a step is the time step over √(m/k), of mass and stiffness of the mean grain; E is Young's \
    modulus; a bed is settled, or poured until the stiffness is raised, at this kinetic energy over its largest one (1e-3).";

/// What is done, with units.
fn described(specification: &Specification) -> String {
    let mut words = match specification.scene.time_step {
        TimeStep::Fraction { of_sqrt_m_over_k } => {
            format!("a time step of {of_sqrt_m_over_k} √(m/k)")
        }
        TimeStep::Absolute { seconds } => format!("a time step of {seconds} s"),
    };
    if let Some(Phase { modulus, end, .. }) = specification.phases.first() {
        words += &format!(", poured with {modulus} of Young's modulus");
        if let End::Settled(share) = end {
            words += &format!(" until the kinetic energy is {share:e} of its largest");
        }
    }
    words
}

fn seconds(point: &Point) -> Option<f64> {
    point.costs.map(|costs| costs.cpu_seconds)
}

/// What went wrong, and what the engine says of itself.
fn remarks(point: &Point) -> Vec<String> {
    let (endings, missing) = (&point.screened.endings, point.missing);
    let missing = (missing > 0).then(|| format!("{missing} realizations are missing"));
    let poured = "skipped loading: the engine has no punch; cost and steps are those of pouring and settling";
    let poured = (endings.poured > 0).then(|| poured.to_owned());
    let own = endings.remarks().chain(missing).chain(poured);
    own.chain(point.notes.iter().cloned()).collect()
}

/// Biases over their margins, a row a name; how far beyond four margins a bias lies is in the numbers.
fn forest(name: &str, caption: &str, rows: Vec<(String, &Judgement, &str)>) -> Plot {
    const REACH: f64 = 4.0;
    let x = Axis::linear("bias over margin, 90 % interval").within(-REACH, REACH);
    let y = Axis::of_names("", rows.iter().map(|row| row.0.clone()));
    let last = rows.len() as f64 - 0.5;
    let band = [[-1.0, -0.5, last], [1.0, -0.5, last]];
    let (plot, band) = (Plot::new(name, caption, x, y), Shape::Band(band.into()));
    let mut plot = plot.with("within the margin", Colour::Grey, band);
    let groups = [
        (Some(Finding::Equivalent), Colour::Green),
        (Some(Finding::Different), Colour::Vermilion),
        (Some(Finding::Undecided), Colour::Grey),
        (None, Colour::Grey),
    ];
    for (finding, colour) in groups {
        let places = rows.iter().enumerate();
        let points = places.filter_map(|(row, (_, judged, key))| {
            let difference = judged.of(key)?;
            let bias = difference.paired.difference_90.over(difference.margin?);
            (difference.finding == finding).then(|| in_row(&bias, row, [-REACH, REACH], 1))
        });
        plot = plot.points(finding.map_or("too few pairs", word), colour, points);
    }
    plot
}
