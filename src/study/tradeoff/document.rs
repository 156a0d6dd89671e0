//! What the comparison of cost and error says.

use std::collections::BTreeMap;

use super::judge::{Judgement, MISSED_KEY, MISSED_TITLE, Worst, word};
use super::plan::is_frictional;
use super::{Point, Tradeoff};
use crate::checks::Outcome;
use crate::document::{Axis, Colour, Document, Plot, Section, Table, plot};
use crate::study::figures::in_row;
use crate::study::realization::{Runner, Specification};
use evidence::t_test::Finding;
use grains::native::pouring::{End, Phase};
use grains::scene::TimeStep;

/// Errors below this share of a margin are drawn there: no margin is known that well.
const LOWEST: f64 = 0.02;

impl Tradeoff {
    pub fn document(&self) -> Document {
        let checks = self.checks();
        Document {
            title: "Cost against error".to_owned(),
            verdict: checks.first().map_or(Outcome::Pass, |check| check.outcome),
            answer: self.answer(),
            sections: vec![
                self.cost_and_error(),
                self.equivalence(),
                self.compared(),
                self.every_quantity(),
                self.orders(),
            ],
            checks,
        }
    }

    fn answer(&self) -> String {
        let clouds = self.confirmatory;
        let chosen = self.recommended.as_ref().and_then(|id| self.point(id));
        match chosen {
            Some(point) => {
                let seconds = |of| seconds(of).unwrap_or_default();
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
        let bed = self.scatter(
            "cost-and-error-of-the-settled-bed",
            "Settled bed: heights, porosities, coordination and the shape of the distribution of stress.",
            |judged| judged.bed.as_ref(),
        );
        let load = self.scatter(
            "cost-and-error-of-the-loaded-bed",
            "Loaded bed: local mean stress at O, A and B, and the share of missed loads.",
            |judged| judged.load.as_ref(),
        );
        let drawn = |plot: &Plot| plot.marks.iter().any(|mark| mark.points().is_some());
        Section::new("Cost against error", words)
            .with_all([bed, load].into_iter().filter(drawn))
            .with(self.by_cost())
            .with_all(self.remarks())
            .with(
                "A method is dominated by the cheapest one that costs no more and errs no more, in the settled and in the loaded \
                 bed, by the estimates; where the intervals overlap it is only perhaps dominated. Methods with friction are compared with \
                 each other only. Processor times are those of \
                 single threads while all cores were busy; the steps do not depend on that.",
            )
    }

    fn scatter(
        &self,
        name: &str,
        what: &str,
        worst: impl Fn(&Judgement) -> Option<&Worst>,
    ) -> Plot {
        let caption = format!(
            "{what} Filled: not dominated; hollow: dominated. Other engines have names where there is room; all methods stand in the \
             table. Bars: the 95 % interval of the quantity with the largest bias. Errors below {LOWEST} are drawn there. \
             Dotted: the margin and the null comparison."
        );
        let x = Axis::logarithmic("processor time of one realization, s");
        let y = Axis::logarithmic("largest bias over its margin");
        let mut plot = Plot::new(name, caption, x, y);
        let chosen = self.recommended.as_ref().and_then(|id| self.point(id));
        let is_chosen = |of: &Point| chosen.is_some_and(|chosen| chosen.method.id == of.method.id);
        let recommended = chosen.map_or(String::new(), |of| {
            format!("recommended: {}", of.method.name)
        });
        let groups = [
            ("native", Colour::Blue),
            ("other engines", Colour::Green),
            ("native, friction", Colour::Ochre),
            ("other engines, friction", Colour::Purple),
            (recommended.as_str(), Colour::Vermilion),
        ];
        for (group, (name, colour)) in groups.into_iter().enumerate() {
            for hollow in [false, true] {
                let own = |of: &&Point| {
                    let own = if is_chosen(of) { RECOMMENDED } else { kind(of) };
                    own == group && of.dominated_by.is_some() == hollow
                };
                let own = self.points.iter().filter(own);
                let points = own.filter_map(|point| {
                    let error = worst(&point.screened)?.error;
                    let [y, low, high] =
                        [error.estimate, error.low, error.high].map(|of| of.max(LOWEST));
                    let mut shown = plot::Point::at(seconds(point)?, y);
                    if !hollow || point.confirmed.is_some() {
                        shown = shown.between(low, high);
                    }
                    Some(match point.method.specification.runner {
                        Runner::Native => shown,
                        _ => shown.labelled(point.method.name.clone()),
                    })
                });
                let dominated = if hollow { ", dominated" } else { "" };
                plot = plot.group(&format!("{name}{dominated}"), colour, hollow, points);
            }
        }
        let plot = plot.level("margin", Colour::Sky, 1.0);
        let Some(null) = worst(&self.null_comparison) else {
            return plot;
        };
        plot.level("null comparison", Colour::Grey, null.error.estimate)
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
        let points = points.map(|of| (of.method.name.as_str(), of, &of.screened));
        let rows = references.into_iter().chain(points);
        let error = |worst: &Option<Worst>| Some(worst.as_ref()?.error);
        let largest = |worst: &Option<Worst>| Some(self.title(&worst.as_ref()?.key).to_owned());
        let made = |of: &Judgement| Some(of.endings.all()).filter(|all| *all > 0);
        let by = |point: &Point| {
            let id = point.dominated_by.as_ref()?;
            let name = self.point(id).map_or(id.as_str(), |of| &of.method.name);
            let perhaps = if point.clearly { "" } else { "perhaps " };
            Some(format!("{perhaps}{name}"))
        };
        Table::of("methods", "Every method, by cost", rows)
            .column("method", |(name, ..)| name)
            .column("what is changed", |(_, of, _)| &of.method.axis)
            .column("processor time, median, s", |(_, of, _)| seconds(of))
            .column("steps of pouring", |(_, of, _)| {
                of.costs.map(|of| of.pour_steps)
            })
            .column("steps of loading", |(_, of, _)| {
                of.costs.map(|of| of.load_steps)
            })
            .column("missed the load", |(.., of)| {
                made(of).map(|_| of.endings.missed())
            })
            .column("of", |(.., of)| made(of))
            .column("error of the settled bed over margin", |(.., of)| {
                error(&of.bed)
            })
            .column("largest in", |(.., of)| largest(&of.bed))
            .column("error of the loaded bed over margin", |(.., of)| {
                error(&of.load)
            })
            .column("largest in the loaded bed", |(.., of)| largest(&of.load))
            .column("dominated by", |(_, of, _)| by(of))
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
        let found = self.quantities.iter().find(|of| of.key == key);
        found.map_or(key, |of| &of.title)
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
            all.filter_map(|of| of.paired.correlation).reduce(least)
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
            let quantities = self.quantities.iter().filter(|of| of.margin.is_some());
            let rows = quantities.map(|of| (of.title.to_string(), judged, of.key.as_ref()));
            let name = format!("equivalence-of-{}", point.method.id);
            let of = &point.method.name;
            let caption = format!("{of}: bias of every quantity over its margin.");
            section.with(forest(&name, &caption, rows.collect()))
        })
    }

    fn compared(&self) -> Section {
        let title = "Quantities and their margins";
        let table = Table::of("quantities", title, &self.quantities)
            .column("quantity", |of| of.title.as_ref())
            .column("unit", |of| of.unit.as_ref())
            .column("mean of the reference", |of| of.reference.map(|of| of.mean))
            .column("standard deviation", |of| {
                of.reference.map(|of| of.deviation)
            })
            .column("packings", |of| of.reference.map(|of| of.count))
            .column("margin", |of| of.margin)
            .column("reason", |of| of.reason.as_ref());
        Section::new("What is compared, and the margins", "").with(table)
    }

    fn every_quantity(&self) -> Section {
        let words = "Bias over margin with its 90 % interval. Green: within the margin. Vermilion: beyond it. Grey: too few \
                     packings to say.";
        let section = Section::new("Every quantity, every method", words).as_details();
        let quantities = self.quantities.iter().filter(|of| of.margin.is_some());
        quantities.fold(section, |section, of| {
            let rows = self.points.iter();
            let rows = rows.map(|at| (at.method.name.clone(), &at.screened, of.key.as_ref()));
            let name = format!("bias-of-{}", of.key.replace(['.', '_'], "-"));
            let (title, reason) = (&of.title, &of.reason);
            let caption = format!("Bias of {title} over its margin. The margin: {reason}.");
            section.with(forest(&name, &caption, rows.collect()))
        })
    }

    fn orders(&self) -> Section {
        let title = "Order of convergence, fitted up to the default step of 0.45";
        let table = Table::of("orders", title, &self.convergence)
            .column("case", |of| &of.title)
            .column("error of", |of| &of.error_of)
            .column("order", |of| of.order)
            .column("theory", |of| of.expected);
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
fn described(of: &Specification) -> String {
    let mut words = match of.scene.time_step {
        TimeStep::Fraction { of_sqrt_m_over_k } => {
            format!("a time step of {of_sqrt_m_over_k} √(m/k)")
        }
        TimeStep::Absolute { seconds } => format!("a time step of {seconds} s"),
    };
    if let Some(Phase { modulus, end, .. }) = of.phases.first() {
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

/// Beside the kinds of methods.
const RECOMMENDED: usize = 4;

fn kind(point: &Point) -> usize {
    let is_other = !point.method.specification.runner.is_native();
    usize::from(is_other) + 2 * usize::from(is_frictional(&point.method))
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
    let mut plot = Plot::new(name, caption, x, y).band("within the margin", Colour::Grey, band);
    let groups = [
        (Some(Finding::Equivalent), Colour::Green),
        (Some(Finding::Different), Colour::Vermilion),
        (Some(Finding::Undecided), Colour::Grey),
        (None, Colour::Grey),
    ];
    for (finding, colour) in groups {
        let places = rows.iter().enumerate();
        let points = places.filter_map(|(row, (_, judged, key))| {
            let of = judged.of(key)?;
            let bias = of.paired.difference_90.over(of.margin?);
            (of.finding == finding).then(|| in_row(&bias, row, [-REACH, REACH], 1))
        });
        plot = plot.points(finding.map_or("too few pairs", word), colour, points);
    }
    plot
}
