//! The chart of cost against error as a page.

mod forest;
mod scatter;

use serde::Serialize;

use self::scatter::{Dot, Scatter};
use super::chart::{BLUE, Chart, Corner, GREEN, VERMILION};
use super::figure::{Figure, Page, line};
use super::shell;
use crate::error::Error;
use crate::study::tradeoff::choice::not_shown;
use crate::study::tradeoff::judge::{Judgement, MISSED_KEY, Worst};
use crate::study::tradeoff::method::Runner;
use crate::study::tradeoff::record::{Pareto, Point};
use evidence::equivalence::Finding;
use grains::native::Mode;

const PAGE: &str = include_str!("pareto.html");
const PART: &str = include_str!("pareto_part.html");

/// What the template is given.
#[derive(Debug, Serialize)]
struct Given<'a> {
    p: &'a Pareto,
    word: &'static str,
    charts: Vec<Figure>,
    rows: Vec<Row>,
    tested: Vec<Tested>,
    forests: Vec<Figure>,
    orders: Vec<Order>,
    convergence: Option<Figure>,
    missing: Vec<String>,
}

/// A line of the table.
#[derive(Debug, Serialize)]
struct Row {
    number: String,
    name: String,
    family: &'static str,
    seconds: String,
    steps: String,
    missed: String,
    bed: String,
    load: String,
    by: String,
    failed: Vec<String>,
}

/// A candidate's test of equivalence.
#[derive(Debug, Serialize)]
struct Tested {
    number: usize,
    name: String,
    word: &'static str,
    clouds: usize,
    seconds: String,
    missed: String,
    not_shown: Vec<String>,
    figure: Figure,
    correlations: String,
}

/// An exact case.
#[derive(Debug, Serialize)]
struct Order {
    title: String,
    error_of: String,
    order: String,
    expected: f64,
}

/// A page of its own.
pub fn page(record: &Pareto) -> Result<Page, Error> {
    let given = given(record)?;
    let html = shell::render(&[("pareto.html", PAGE)], &given)?;
    let tested = given.tested.into_iter().map(|of| of.figure);
    let figures = given.charts.into_iter().chain(tested);
    Ok(Page {
        html,
        figures: figures
            .chain(given.forests)
            .chain(given.convergence)
            .collect(),
    })
}

/// The part for the main report: the charts, and what was tested to be equivalent.
pub fn part(record: &Pareto) -> Result<Page, Error> {
    let given = given(record)?;
    Ok(Page {
        html: shell::render(&[("pareto_part.html", PART)], &given)?,
        figures: given.charts,
    })
}

fn given(record: &Pareto) -> Result<Given<'_>, Error> {
    Ok(Given {
        p: record,
        word: if record.complete {
            "cost against error"
        } else {
            "cost against error, incomplete"
        },
        charts: charts(record)?,
        rows: rows(record),
        tested: tested(record)?,
        forests: forests(record)?,
        orders: orders(record),
        convergence: convergence(record)?,
        missing: missing(record),
    })
}

fn charts(record: &Pareto) -> Result<Vec<Figure>, Error> {
    let of = |name: &str, what: &str, caption: &str, worst: fn(&Judgement) -> &Option<Worst>| {
        let dots = record.points.iter().filter_map(|point| {
            let error = worst(&point.charted).as_ref()?.error;
            Some(Dot {
                number: point.number,
                name: &point.method.name,
                x: point.costs?.cpu_seconds,
                y: [error.estimate, error.low, error.high],
                class: class(point),
                dominated: point.dominated_by.is_some(),
            })
        });
        let mut lines = vec![(1.0, "margin".to_owned())];
        if let Some(chance) = worst(&record.chance) {
            lines.push((
                chance.error.estimate,
                "chance: the reference on other clouds".to_owned(),
            ));
        }
        let scatter = Scatter {
            x: "processor time of one realization, s".to_owned(),
            y: format!("largest bias of {what} over its margin"),
            lines,
            dots: dots.collect(),
        };
        let key = "Blue: exact mode; vermilion: free and single; green: YADE and an engine that was brought. Hollow: dominated. Bars: 95 % interval of that quantity.";
        Ok(Figure {
            name: name.to_owned(),
            caption: format!("{caption} {key}"),
            svg: scatter.svg(),
            csv: scatter.csv()?,
        })
    };
    let charts = [
        of(
            "cost-and-error-of-the-settled-bed",
            "the settled bed",
            "Settled bed: heights, porosities, coordination and the shape of the distribution of stress.",
            |judged| &judged.bed,
        ),
        of(
            "cost-and-error-of-the-loaded-bed",
            "the loaded bed",
            "Loaded bed: local mean stress at O, A and B, and the share of punches that miss the force.",
            |judged| &judged.load,
        ),
    ];
    // Where nothing was measured there is nothing to draw.
    let drawn =
        |figure: &Result<Figure, Error>| figure.as_ref().map_or(true, |of| !of.svg.is_empty());
    charts.into_iter().filter(drawn).collect()
}

fn class(point: &Point) -> &'static str {
    match point.method.runner {
        Runner::Native(Mode::Exact) => "exact",
        Runner::Native(_) => "free",
        Runner::YadeOrdinary | Runner::YadeSorted | Runner::Brought => "other",
    }
}

fn rows(record: &Pareto) -> Vec<Row> {
    let mut points: Vec<&Point> = record.points.iter().collect();
    let cost = |point: &Point| point.costs.map_or(f64::INFINITY, |costs| costs.cpu_seconds);
    points.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let mut reference = row(record, &record.reference, &record.reference.charted);
    reference.number = String::new();
    (reference.bed, reference.load) = ("0 by definition".to_owned(), "0 by definition".to_owned());
    let mut chance = row(record, &record.reference, &record.chance);
    chance.number = String::new();
    chance.name = "the reference on other clouds: what chance gives".to_owned();
    let others = points
        .into_iter()
        .map(|point| row(record, point, &point.charted));
    [reference, chance].into_iter().chain(others).collect()
}

fn row(record: &Pareto, point: &Point, judged: &Judgement) -> Row {
    let error = |worst: &Option<Worst>| {
        worst.as_ref().map_or("–".to_owned(), |worst| {
            let of = worst.error;
            format!(
                "{:.2} ({:.2} to {:.2}), {}",
                of.estimate,
                of.low,
                of.high,
                title(record, &worst.key)
            )
        })
    };
    Row {
        number: point.number.to_string(),
        name: point.method.name.clone(),
        family: point.method.family.title(),
        seconds: point.costs.map_or("–".to_owned(), |costs| {
            format!("{:.2}", costs.cpu_seconds)
        }),
        steps: point.costs.map_or("–".to_owned(), |costs| {
            format!("{:.0} + {:.0}", costs.pour_steps, costs.load_steps)
        }),
        missed: match judged.endings.all() {
            0 => "–".to_owned(),
            all => format!("{} of {all}", judged.endings.missed()),
        },
        bed: error(&judged.bed),
        load: error(&judged.load),
        by: point.dominated_by.map_or(String::new(), |by| {
            format!("{by}{}", if point.clearly { "" } else { " ?" })
        }),
        failed: judged
            .endings
            .failed
            .iter()
            .map(|(reason, count)| format!("{count} failed: {reason}"))
            .chain(point.not_made.clone())
            .chain(point.only_poured())
            .chain(says_of_itself(point))
            .collect(),
    }
}

fn says_of_itself(point: &Point) -> Vec<String> {
    let engine = point.method.engine.as_ref();
    let says = engine.map_or(&[][..], |of| &of.described.approximations);
    let line = |says: &String| format!("it says of itself: {says}");
    says.iter().map(line).collect()
}

fn title<'a>(record: &'a Pareto, key: &'a str) -> &'a str {
    if key == MISSED_KEY {
        return "share of missed forces";
    }
    let found = record.quantities.iter().find(|of| of.key == key);
    found.map_or(key, |of| &of.title)
}

fn tested(record: &Pareto) -> Result<Vec<Tested>, Error> {
    let candidates = record.points.iter().filter_map(|point| {
        let judged = point.confirmed.as_ref()?;
        let rows: Vec<forest::Row> = record
            .quantities
            .iter()
            .filter(|quantity| quantity.margin.is_some())
            .map(|quantity| forest_row(judged, &quantity.key, quantity.title.to_string()))
            .collect();
        let correlations: Vec<f64> = judged
            .differences
            .iter()
            .filter_map(|of| of.paired.correlation)
            .collect();
        let least = correlations.iter().copied().fold(f64::INFINITY, f64::min);
        let most = correlations
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let csv = forest::csv(&rows);
        let figure = csv.map(|csv| Figure {
            name: format!("equivalence-of-method-{}", point.number),
            caption: "Bias of every quantity over its margin, with its 90 % interval.".to_owned(),
            svg: forest::svg(&rows, "bias over margin, 90 % interval"),
            csv,
        });
        Some(figure.map(|figure| Tested {
            number: point.number,
            name: point.method.name.clone(),
            word: match judged.finding() {
                Finding::Equivalent => "equivalent",
                Finding::Different => "different",
                Finding::Undecided => "undecided",
            },
            clouds: judged.clouds,
            seconds: point.costs.map_or("–".to_owned(), |costs| {
                format!("{:.2}", costs.cpu_seconds)
            }),
            missed: format!("{} of {}", judged.endings.missed(), judged.endings.all()),
            not_shown: not_shown(judged),
            figure,
            correlations: if correlations.is_empty() {
                "–".to_owned()
            } else {
                format!("{least:.2} to {most:.2}")
            },
        }))
    });
    candidates.collect()
}

fn forest_row(judged: &Judgement, key: &str, name: String) -> forest::Row {
    let of = judged.differences.iter().find(|of| of.key == key);
    forest::Row {
        name,
        difference: of.and_then(|of| Some(of.paired.difference_90.over(of.margin?))),
        finding: of.and_then(|of| of.finding),
    }
}

fn forests(record: &Pareto) -> Result<Vec<Figure>, Error> {
    let charted = record.quantities.iter().filter_map(|quantity| {
        let margin = quantity.margin?;
        let rows: Vec<forest::Row> = record
            .points
            .iter()
            .map(|point| {
                let name = format!("{} {}", point.number, shortened(&point.method.name));
                forest_row(&point.charted, &quantity.key, name)
            })
            .collect();
        let unit = if quantity.unit == "1" {
            ""
        } else {
            &quantity.unit
        };
        Some(forest::csv(&rows).map(|csv| Figure {
            name: format!("bias-of-{}", quantity.key.replace(['.', '_'], "-")),
            csv,
            svg: forest::svg(
                &rows,
                &format!("bias over the margin of {margin:.3} {unit}"),
            ),
            caption: format!(
                "{}. Margin: {}.",
                capitalised(&quantity.title),
                quantity.reason
            ),
        }))
    });
    charted.collect()
}

/// Fits beside a panel; the table has the whole name.
fn shortened(name: &str) -> String {
    const LETTERS: usize = 40;
    if name.chars().count() <= LETTERS {
        return name.to_owned();
    }
    let kept: String = name.chars().take(LETTERS - 1).collect();
    format!("{}…", kept.trim_end())
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn orders(record: &Pareto) -> Vec<Order> {
    let order = |case: &crate::study::tradeoff::convergence::Convergence| Order {
        title: capitalised(&case.title),
        error_of: case.error_of.clone(),
        order: case.order.map_or("–".to_owned(), |order| {
            format!(
                "{:.2} ({:.2} to {:.2})",
                order.estimate, order.low, order.high
            )
        }),
        expected: case.expected,
    };
    record.convergence.iter().map(order).collect()
}

fn convergence(record: &Pareto) -> Result<Option<Figure>, Error> {
    let names = ["swing", "bounce", "damped swing"];
    let series = record
        .convergence
        .iter()
        .zip(names)
        .zip([BLUE, VERMILION, GREEN]);
    let chart = Chart {
        x: "time step over √(m/k)".to_owned(),
        y: "error".to_owned(),
        logarithmic: [true, true],
        legend: Corner::LowerRight,
        series: series
            .map(|((case, name), colour)| line(name, colour, case.points.clone()))
            .collect(),
    };
    Figure::of_chart(
        "order-of-convergence",
        "Errors of exact cases over the time step.",
        &chart,
    )
}

fn missing(record: &Pareto) -> Vec<String> {
    let missing = record.points.iter().filter_map(|point| {
        let reason = point.not_made.as_ref()?;
        Some(format!("{} {}: {reason}", point.number, point.method.name))
    });
    missing.collect()
}
