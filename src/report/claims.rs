//! The claims of a campaign as a page.

mod pictures;

use serde::Serialize;

use super::figure::{Figure, Page};
use super::shell;
use crate::error::Error;
use crate::study::claims::claim::{Answer, Claim, Judged, Row, Verdict};
use crate::study::claims::{Claims, Histogram};
use evidence::Interval;

const PAGE: &str = include_str!("claims.html");
const PART: &str = include_str!("claims_part.html");
const DISTRIBUTIONS: &str = include_str!("distributions_part.html");

/// What the template is given.
#[derive(Debug, Serialize)]
struct Given<'a> {
    c: &'a Claims,
    word: &'static str,
    tally: String,
    endings: String,
    claims: Vec<Shown<'a>>,
    groups: Vec<Group>,
}

/// A claim with its numbers as text.
#[derive(Debug, Serialize)]
struct Shown<'a> {
    of: &'a Claim,
    verdict: &'static str,
    class: &'static str,
    headline: Line,
    lines: Vec<Line>,
}

/// A row as text.
#[derive(Debug, Serialize)]
struct Line {
    what: String,
    published: String,
    ours: String,
    ratio: String,
    packings: usize,
    judged: String,
    class: &'static str,
    tests: Vec<String>,
}

/// Pictures that belong together.
#[derive(Debug, Serialize)]
struct Group {
    id: &'static str,
    title: &'static str,
    caption: String,
    pictures: Vec<Figure>,
    wide: bool,
}

/// A page of its own.
pub fn page(claims: &Claims) -> Result<Page, Error> {
    render(claims, groups(claims)?, &[("claims.html", PAGE)])
}

/// The distributions for the main report.
pub fn distributions(claims: &Claims) -> Result<Page, Error> {
    let wanted = ["figure5", "figure5.gravity"];
    let mut groups = groups(claims)?;
    groups.retain(|group| wanted.contains(&group.id));
    render(
        claims,
        groups,
        &[("distributions_part.html", DISTRIBUTIONS)],
    )
}

/// Every claim with its verdict for the main report.
pub fn part(claims: &Claims) -> Result<Page, Error> {
    let mut groups = groups(claims)?;
    groups.retain(|group| group.id == "means");
    render(claims, groups, &[("claims_part.html", PART)])
}

fn render(claims: &Claims, groups: Vec<Group>, templates: &[(&str, &str)]) -> Result<Page, Error> {
    let given = Given {
        word: if claims.complete {
            "the paper's claims"
        } else {
            "the paper's claims, some open"
        },
        tally: claims
            .verdicts
            .iter()
            .map(|(verdict, count)| format!("{verdict}: {count}"))
            .collect::<Vec<_>>()
            .join(", "),
        endings: listed(
            claims
                .endings
                .iter()
                .map(|(ending, count)| (ending.as_str(), *count)),
        ),
        claims: claims.claims.iter().map(shown).collect(),
        groups,
        c: claims,
    };
    let html = shell::render(templates, &given)?;
    let figures = given.groups.into_iter().flat_map(|group| group.pictures);
    Ok(Page {
        html,
        figures: figures.collect(),
    })
}

fn listed<'a>(counts: impl Iterator<Item = (&'a str, usize)>) -> String {
    let parts: Vec<String> = counts
        .map(|(word, count)| format!("{count} {word}"))
        .collect();
    parts.join(", ")
}

fn shown(claim: &Claim) -> Shown<'_> {
    let headline = claim.rows.iter().find(|row| row.judged.is_some());
    Shown {
        of: claim,
        verdict: claim
            .verdict
            .map_or("open: too few members", Verdict::words),
        class: match claim.verdict {
            Some(Verdict::Holds) => "good",
            Some(Verdict::DoesNotHold) => "bad",
            _ => "open",
        },
        headline: headline.map_or_else(|| line(&Row::shown("", "1", 0, |_| None)), line),
        lines: claim.rows.iter().map(line).collect(),
    }
}

fn unit(of: &str) -> String {
    if of == "1" {
        String::new()
    } else {
        format!(" {of}")
    }
}

/// Four figures.
pub fn short(value: f64) -> String {
    let rounded = format!("{value:.3e}").parse().unwrap_or(value);
    crate::paper::short(rounded)
}

/// An interval with its unit.
pub fn interval(of: Option<Interval>, unit_of: &str) -> String {
    of.map_or("–".to_owned(), |of| {
        format!(
            "{} ({} to {}){}",
            short(of.estimate),
            short(of.low),
            short(of.high),
            unit(unit_of)
        )
    })
}

fn limits(of: &Judged) -> String {
    match (of.low, of.high) {
        (Some(low), Some(high)) => format!("{} to {}", short(low), short(high)),
        (Some(low), None) => format!("at least {}", short(low)),
        (None, Some(high)) => format!("at most {}", short(high)),
        (None, None) => String::new(),
    }
}

fn line(row: &Row) -> Line {
    let (judged, class) = match row.judged {
        None => ("shown only".to_owned(), "open"),
        Some(judged) => {
            let (word, class) = match judged.answer {
                Answer::Yes => ("within", "good"),
                Answer::No => ("beyond", "bad"),
                Answer::Open => ("open", "open"),
            };
            let by = if judged.by_estimate {
                ", by the estimate"
            } else {
                ""
            };
            (format!("{word} {}{by}", limits(&judged)), class)
        }
    };
    Line {
        what: row.what.clone(),
        published: row.published.map_or("–".to_owned(), |of| {
            format!("{}{}", short(of), unit(&row.unit))
        }),
        ours: interval(row.ours, &row.unit),
        ratio: row.ratio.map_or(String::new(), |of| {
            format!("{:.2} ({:.2} to {:.2})", of.estimate, of.low, of.high)
        }),
        packings: row.packings,
        judged,
        class,
        tests: row
            .probabilities
            .iter()
            .map(|one| {
                format!(
                    "{}: {:.3}, p {}, adjusted {}",
                    one.test,
                    one.statistic,
                    probability(one.p),
                    probability(one.adjusted)
                )
            })
            .collect(),
    }
}

fn probability(p: f64) -> String {
    if p >= 1.0e-3 {
        format!("{p:.3}")
    } else {
        format!("{p:.0e}")
    }
}

fn groups(claims: &Claims) -> Result<Vec<Group>, Error> {
    let data = &claims.figures;
    let drawn = |group: &str, of: &[Histogram], quantity: &str, unit: (&str, f64)| {
        let pictures = of
            .iter()
            .map(|of| pictures::histogram(group, of, quantity, unit));
        pictures.collect::<Result<Vec<Figure>, Error>>()
    };
    let (joule, kilopascal) = (("J", 1.0), ("kPa", 1.0e3));
    let [variation_loaded, shape_loaded, correlation_loaded] = pictures::volumes(claims, "last")?;
    let [variation_settled, shape_settled, correlation_settled] =
        pictures::volumes(claims, "settled")?;
    let laws = "Bars with 95 % binomial intervals: members. Dotted: exponential with the members' mean; dashed green: fitted gamma law";
    let theory = "; vermilion: exponential with the theory's mean of Table 4";
    let inset = "Inset: share of members above a value with its interval, on a logarithmic axis, where an exponential is a straight line.";
    let group = |id, title, caption: String, pictures, wide| Group {
        id,
        title,
        caption,
        pictures,
        wide,
    };
    let pairs = "Left under the load, right under gravity alone; blue O, vermilion A, green B, with 95 % intervals.";
    Ok(vec![
        group(
            "figure5",
            "Distributions of Σ_zz at O, A and B under the load (the paper's Figure 5)",
            format!("{laws}{theory}. {inset}"),
            drawn("figure5", &data.figure5, "Σ_zz", joule)?,
            false,
        ),
        group(
            "figure5.gravity",
            "The same under gravity alone",
            format!("{laws}{theory}. {inset}"),
            drawn("figure5.gravity", &data.gravity, "σ_zz", kilopascal)?,
            false,
        ),
        group(
            "figure5.xx",
            "Horizontal stress under the load",
            format!("{laws}. {inset}"),
            drawn("figure5.xx", &data.horizontal, "σ_xx", kilopascal)?,
            false,
        ),
        group(
            "shear",
            "Shear stress under the load",
            "Bars with 95 % binomial intervals: members; dashed green: fitted Laplace law.".to_owned(),
            drawn("shear", &data.shear, "σ_xz", kilopascal)?,
            false,
        ),
        group(
            "means",
            "Means against Table 4",
            "Ours over published, with 95 % intervals; shaded: within a tenth. Green within the limits, vermilion beyond, grey \
             shown only."
                .to_owned(),
            pictures::means(claims)?.into_iter().collect(),
            true,
        ),
        group(
            "plane",
            "Height and porosity of every settled bed",
            "Yellow: what is printed, H = 0.46 ± 0.01 m and n = 0.17 ± 0.01. Black: n = 1 − S/(L·H), on which all beds lie that have \
             one definition for both."
                .to_owned(),
            pictures::plane(claims)?.into_iter().collect(),
            true,
        ),
        group(
            "volumes",
            "Variation of many cells together",
            format!("{pairs} Black: 1/√N. Dashed: 10 %, below which the continuum is good enough for one packing."),
            vec![variation_loaded, variation_settled],
            false,
        ),
        group(
            "shapes",
            "Gamma shape of many cells together, over their number",
            format!("{pairs} Black: Erlang's law of shape N."),
            vec![shape_loaded, shape_settled],
            false,
        ),
        group(
            "correlations",
            "Correlation of cells",
            format!(
                "{pairs} What the variation of N cells says of the mean correlation of two of them if all varied alike, \
                 (N CV_N²/CV_1² − 1)/(N − 1); 0 if they were independent."
            ),
            vec![correlation_loaded, correlation_settled],
            false,
        ),
    ])
}
