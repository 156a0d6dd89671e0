//! What the comparison of cost and error says.

use super::convergence::Convergence;
use super::judge::{Judgement, MISSED_KEY, MISSED_TITLE, Worst, word};
use super::{Point, Tradeoff};
use crate::checks::Outcome;
use crate::document::{Axis, Block, Cell, Colour, Document, Mark, Plot, Section, Table, plot};
use crate::study::realization::Runner;
use evidence::Interval;
use evidence::t_test::Finding;
use grains::native::Mode;

/// Errors below this share of a margin are drawn there: no margin is known that well.
const LOWEST: f64 = 0.02;

impl Tradeoff {
    /// For people.
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
            Some(point) => format!(
                "Recommended: {}. It is equivalent to the reference in every quantity with a margin over {clouds} clouds, at \
                 {:.2} s of one core a realization; the reference takes {:.2} s.",
                point.method.name,
                seconds(point).unwrap_or_default(),
                seconds(&self.reference).unwrap_or_default()
            ),
            None if clouds == 0 => {
                "No method is recommended: equivalence was not tested in this study.".to_owned()
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
             chance: the null comparison is the reference against itself on other clouds.",
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
        let section = Section::new("Cost against error", words);
        let drawn = |plot: &Plot| {
            plot.marks
                .iter()
                .any(|mark| matches!(mark, Mark::Points { .. }))
        };
        let section = [bed, load]
            .into_iter()
            .filter(drawn)
            .fold(section, Section::with);
        section.with(self.by_cost()).with(Block::Text(
            "A method is dominated by the cheapest one that costs no more and errs no more, in the settled and in the loaded \
             bed, by the estimates; where the intervals overlap it is only perhaps dominated. Processor times are those of \
             single threads while all cores were busy; the steps do not depend on that."
                .to_owned(),
        ))
    }

    fn scatter(
        &self,
        name: &str,
        what: &str,
        worst: impl Fn(&Judgement) -> Option<&Worst>,
    ) -> Plot {
        let caption = format!(
            "{what} Filled: not dominated; hollow: dominated; bars: 95 % interval of the quantity with the largest bias. Named: \
             what is not dominated, and candidates."
        );
        let x = Axis::logarithmic("processor time of one realization, s");
        let y = Axis::logarithmic("largest bias over its margin");
        let mut plot = Plot::new(name, caption, x, y);
        let groups = [
            ("exact mode", Colour::Blue),
            ("free and single", Colour::Vermilion),
            ("other engines", Colour::Green),
        ];
        for (group, (name, colour)) in groups.into_iter().enumerate() {
            for hollow in [false, true] {
                let own = self
                    .points
                    .iter()
                    .filter(|point| kind(point) == group && point.dominated_by.is_some() == hollow);
                let points = own.filter_map(|point| {
                    let error = worst(&point.screened)?.error;
                    let named = !hollow || point.confirmed.is_some();
                    Some(plot::Point {
                        x: seconds(point)?,
                        y: error.estimate.max(LOWEST),
                        interval: Some([error.low.max(LOWEST), error.high.max(LOWEST)]),
                        label: if named {
                            point.method.name.clone()
                        } else {
                            String::new()
                        },
                    })
                });
                let points: Vec<plot::Point> = points.collect();
                if !points.is_empty() {
                    plot.marks.push(Mark::Points {
                        name: if hollow {
                            format!("{name}, dominated")
                        } else {
                            name.to_owned()
                        },
                        colour,
                        hollow,
                        points,
                    });
                }
            }
        }
        plot.marks.push(level("margin", 1.0));
        if let Some(null) = worst(&self.null_comparison) {
            let words = "null comparison: the reference on other clouds";
            plot.marks.push(level(words, null.error.estimate));
        }
        plot
    }

    fn by_cost(&self) -> Table {
        let mut table = Table::new(
            "methods",
            "Every method, by cost",
            &[
                "method",
                "what is changed",
                "processor time, median, s",
                "steps of pouring",
                "steps of loading",
                "missed the load",
                "of",
                "error of the settled bed over margin",
                "largest in",
                "error of the loaded bed over margin",
                "largest in the loaded bed",
                "dominated by",
                "remarks",
            ],
        );
        let null = Point {
            screened: self.null_comparison.clone(),
            ..self.reference.clone()
        };
        let reference = Point {
            screened: Judgement {
                bed: None,
                load: None,
                ..self.reference.screened.clone()
            },
            ..self.reference.clone()
        };
        table.row(self.row("the reference", &reference));
        table.row(self.row("the reference on other clouds: null comparison", &null));
        let mut points: Vec<&Point> = self.points.iter().collect();
        let cost = |point: &Point| seconds(point).unwrap_or(f64::INFINITY);
        points.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        for point in points {
            table.row(self.row(&point.method.name, point));
        }
        table
    }

    fn row(&self, name: &str, point: &Point) -> Vec<Cell> {
        let judged = &point.screened;
        let costs = point.costs;
        let error = |worst: &Option<Worst>| -> [Cell; 2] {
            let worst = worst.as_ref();
            [
                worst.map(|of| of.error).into(),
                worst.map(|of| self.title(&of.key)).into(),
            ]
        };
        let by = point.dominated_by.as_ref().map(|id| {
            let name = self.point(id).map_or(id.as_str(), |of| &of.method.name);
            format!("{}{name}", if point.clearly { "" } else { "perhaps " })
        });
        let all = judged.endings.all();
        let missed = (all > 0).then(|| judged.endings.missed());
        let remarks = remarks(point);
        let mut row: Vec<Cell> = vec![
            name.into(),
            point.method.axis.as_str().into(),
            costs.map(|of| of.cpu_seconds).into(),
            costs.map(|of| of.pour_steps).into(),
            costs.map(|of| of.load_steps).into(),
            missed.into(),
            (all > 0).then_some(all).into(),
        ];
        row.extend(error(&judged.bed));
        row.extend(error(&judged.load));
        row.extend([
            by.into(),
            (!remarks.is_empty()).then(|| remarks.join("; ")).into(),
        ]);
        row
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
        let mut table = Table::new(
            "candidates",
            "Tests of equivalence",
            &[
                "candidate",
                "finding",
                "clouds",
                "processor time, median, s",
                "missed the load",
                "least correlation of the pairs",
                "largest correlation of the pairs",
                "not shown",
            ],
        );
        for (point, judged) in tested() {
            let correlations = judged.differences.iter();
            let correlations: Vec<f64> = correlations
                .filter_map(|of| of.paired.correlation)
                .collect();
            let not_shown = judged.not_shown();
            table.row([
                point.method.name.as_str().into(),
                word(judged.finding()).into(),
                judged.clouds.into(),
                seconds(point).into(),
                judged.endings.missed().into(),
                correlations.iter().copied().reduce(f64::min).into(),
                correlations.iter().copied().reduce(f64::max).into(),
                (!not_shown.is_empty()).then(|| not_shown.join(", ")).into(),
            ]);
        }
        let section = Section::new("Equivalence", words).with(table);
        tested().fold(section, |section, (point, judged)| {
            let quantities = self.quantities.iter().filter(|of| of.margin.is_some());
            let rows = quantities.map(|of| (of.title.to_string(), judged, of.key.as_ref()));
            section.with(forest(
                &format!("equivalence-of-{}", point.method.id),
                &format!(
                    "{}: bias of every quantity over its margin.",
                    point.method.name
                ),
                rows.collect(),
            ))
        })
    }

    fn compared(&self) -> Section {
        let mut table = Table::new(
            "quantities",
            "Quantities and their margins",
            &[
                "quantity",
                "unit",
                "mean of the reference",
                "standard deviation",
                "packings",
                "margin",
                "reason",
            ],
        );
        for of in &self.quantities {
            table.row([
                of.title.as_ref().into(),
                of.unit.as_ref().into(),
                of.reference.map(|of| of.mean).into(),
                of.reference.map(|of| of.deviation).into(),
                of.reference.map(|of| of.count).into(),
                of.margin.into(),
                of.reason.as_ref().into(),
            ]);
        }
        Section::new("What is compared, and the margins", "").with(table)
    }

    fn every_quantity(&self) -> Section {
        let words = "Bias over margin with its 90 % interval. Green: within the margin. Vermilion: beyond it. Grey: too few \
                     packings to say.";
        let section = Section::new("Every quantity, every method", words).as_details();
        let quantities = self.quantities.iter().filter(|of| of.margin.is_some());
        quantities.fold(section, |section, of| {
            let rows = self.points.iter();
            let rows =
                rows.map(|point| (point.method.name.clone(), &point.screened, of.key.as_ref()));
            section.with(forest(
                &format!("bias-of-{}", of.key.replace(['.', '_'], "-")),
                &format!(
                    "Bias of {} over its margin. The margin: {}.",
                    of.title, of.reason
                ),
                rows.collect(),
            ))
        })
    }

    fn orders(&self) -> Section {
        let mut table = Table::new(
            "orders",
            "Order of convergence, fitted up to the paper's step of 0.45",
            &["case", "error of", "order", "theory"],
        );
        let x = Axis::logarithmic("time step over √(m/k)");
        let y = Axis::logarithmic("error");
        let caption = "Errors of exact cases over the time step.";
        let mut plot = Plot::new("order-of-convergence", caption, x, y);
        let colours = [Colour::Blue, Colour::Vermilion, Colour::Green];
        for (case, colour) in self.convergence.iter().zip(colours) {
            let Convergence {
                title,
                error_of,
                points,
                order,
                expected,
            } = case;
            table.row([
                title.as_str().into(),
                error_of.as_str().into(),
                (*order).into(),
                (*expected).into(),
            ]);
            plot = plot.line(title, colour, points.iter().map(|(x, y)| [*x, *y]));
        }
        let words = "Where nothing is chaotic the error falls with the square of the time step.";
        let section = Section::new("Order of convergence", words).with(table);
        if plot.marks.is_empty() {
            section
        } else {
            section.with(plot)
        }
    }
}

fn level(name: &str, y: f64) -> Mark {
    Mark::Level {
        name: name.to_owned(),
        colour: Colour::Ochre,
        y,
    }
}

fn seconds(point: &Point) -> Option<f64> {
    point.costs.map(|costs| costs.cpu_seconds)
}

/// Exact, approximate, or another engine.
fn kind(point: &Point) -> usize {
    match point.method.specification.runner {
        Runner::Native(Mode::Exact) => 0,
        Runner::Native(_) => 1,
        Runner::YadeOrdinary | Runner::YadeSorted | Runner::External => 2,
    }
}

/// What went wrong, and what the engine says of itself.
fn remarks(point: &Point) -> Vec<String> {
    let endings = &point.screened.endings;
    let mut remarks: Vec<String> = endings.remarks().collect();
    if point.missing > 0 {
        remarks.push(format!("{} realizations are missing", point.missing));
    }
    if endings.poured > 0 {
        remarks.push(
            "skipped loading: the engine has no punch; cost and steps are those of pouring and settling".to_owned(),
        );
    }
    remarks.extend(point.notes.iter().cloned());
    remarks
}

/// Biases over their margins, a row a name; how far beyond four margins a bias lies is in the numbers.
fn forest(name: &str, caption: &str, rows: Vec<(String, &Judgement, &str)>) -> Plot {
    const REACH: f64 = 4.0;
    let x = Axis::linear("bias over margin, 90 % interval").within(-REACH, REACH);
    let y = Axis::of_names("", rows.iter().map(|row| row.0.clone()));
    let mut plot = Plot::new(name, caption, x, y);
    let last = rows.len() as f64 - 0.5;
    plot.marks.push(Mark::Band {
        name: "within the margin".to_owned(),
        colour: Colour::Grey,
        points: vec![[-1.0, -0.5, last], [1.0, -0.5, last]],
    });
    let groups = [
        (Some(Finding::Equivalent), Colour::Green),
        (Some(Finding::Different), Colour::Vermilion),
        (Some(Finding::Undecided), Colour::Grey),
        (None, Colour::Grey),
    ];
    for (finding, colour) in groups {
        let points = rows
            .iter()
            .enumerate()
            .filter_map(|(row, (_, judged, key))| {
                let of = judged.of(key)?;
                let bias: Interval = of.paired.difference_90.over(of.margin?);
                (of.finding == finding).then(|| plot::Point {
                    x: bias.estimate.clamp(-REACH, REACH),
                    y: row as f64,
                    interval: Some([bias.low, bias.high].map(|end| end.clamp(-REACH, REACH))),
                    label: if bias.estimate.abs() > REACH {
                        format!("{:.1}", bias.estimate)
                    } else {
                        String::new()
                    },
                })
            });
        let points: Vec<plot::Point> = points.collect();
        if !points.is_empty() {
            plot = plot.points(finding.map_or("too few pairs", word), colour, points);
        }
    }
    plot
}
