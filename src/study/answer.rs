//! What all that was run says of the published figures, in three sentences made from the records, each with the numbers it hangs on.

use super::claims::{Claim, Claims, Row, Verdict};
use super::search::matching::{BINS, Search};
use super::search::space::{AXES, Scale};
use crate::checks::Outcome;
use crate::paper::published::POINTS;
use evidence::history::CUT;
use evidence::{Interval, proportion};

/// The mean diameter among [`AXES`], and that of R = 5 mm, mm.
const DIAMETER: usize = 4;
const PRINTED_DIAMETER: f64 = 10.0;

/// None where the claims have no other setting beside them, or a number is missing.
pub fn answer(claims: &Claims, search: &Search) -> Option<[String; 3]> {
    let beside = &claims.beside.as_ref()?.claims;
    Some([
        at_our_default(&claims.claims)?,
        at_the_best(beside, search)?,
        what_is_open(search)?,
    ])
}

fn claim<'a>(claims: &'a [Claim], id: &str) -> Option<&'a Claim> {
    claims.iter().find(|claim| claim.id == id)
}

fn row<'a>(claims: &'a [Claim], id: &str, begins: &str) -> Option<&'a Row> {
    let mut rows = claim(claims, id)?.rows.iter();
    rows.find(|row| row.what.starts_with(begins))
}

fn told(interval: Interval, decimals: usize) -> String {
    let [estimate, low, high] =
        [interval.estimate, interval.low, interval.high].map(|value| format!("{value:.decimals$}"));
    format!("{estimate} ({low}–{high})")
}

fn listed(names: &[String]) -> String {
    match names {
        [] => "no point".to_owned(),
        [one] => one.clone(),
        [many @ .., last] => format!("{} and {last}", many.join(", ")),
    }
}

/// Means over the continuum's at O, A and B.
fn means(claims: &[Claim], begins: &str) -> Option<String> {
    let ratio = |point| row(claims, &format!("mean.{point}"), begins)?.ratio;
    let all: Option<Vec<Interval>> = POINTS.into_iter().map(ratio).collect();
    Some(listed(
        &all?
            .into_iter()
            .map(|interval| told(interval, 2))
            .collect::<Vec<_>>(),
    ))
}

fn at_our_default(claims: &[Claim]) -> Option<String> {
    let both = match claim(claims, "height_and_porosity")?.verdict {
        Some(Verdict::DoesNotHold) => "do not come out together",
        Some(_) => "come out together by some definitions",
        None => "are not shown to come out together",
    };
    let share = row(
        claims,
        "height_and_porosity",
        "share of beds with both, mean surface",
    )?;
    Some(format!(
        "At our default for what is not printed, height and porosity {both} ({} of the beds have both by the mean surface), and the means at \
         O, A and B are {} of the continuum's, which the paper says its own equal.",
        told(share.ours?, 2),
        means(claims, "nearest grain, as")?
    ))
}

/// Whether more of it was not searched; less than zero is no friction.
fn is_end(scale: &Scale, at: f64) -> bool {
    match scale {
        Scale::OneOf(_) => false,
        Scale::FromZero(_) => at >= 1.0,
        _ => at <= 0.0 || at >= 1.0,
    }
}

fn at_the_best(claims: &[Claim], search: &Search) -> Option<String> {
    let at = &search.best.first()?.at;
    let on_edge = AXES
        .iter()
        .zip(at)
        .any(|(axis, at)| is_end(&axis.scale, *at));
    let edge = if on_edge {
        ", on the edge of its space,"
    } else {
        ""
    };
    let local = |point| row(claims, &format!("mean.{point}"), "local mean")?.judged;
    let local = POINTS.map(|point| local(point).map(|judged| judged.outcome));
    let near = match local.iter().all(|outcome| *outcome == Some(Outcome::Pass)) {
        true => "has local means within a tenth of the continuum's",
        false => "is not shown to have local means within a tenth of the continuum's",
    };
    let mut shapes = Vec::new();
    for point in POINTS {
        let id = format!("exponential.{point}");
        if claim(claims, &id)?.verdict == Some(Verdict::DoesNotHold) {
            let shape = row(claims, &id, "Σ_zz of grains that bear load: gamma")?.ours?;
            shapes.push(format!("{point}, {}", told(shape, 2)));
        }
    }
    let law = match shapes.is_empty() {
        true => "whether stresses of its loaded grains are exponential is undecided".to_owned(),
        false => format!(
            "stresses of its loaded grains are not exponential (gamma shape at {}, not 1)",
            listed(&shapes)
        ),
    };
    Some(format!(
        "The best setting of our search{edge} {near} at O, A and B ({}), but {law}.",
        means(claims, "local mean")?
    ))
}

fn what_is_open(search: &Search) -> Option<String> {
    let hits = (search.left * search.candidates as f64).round() as usize;
    let left = proportion::wilson(hits, search.candidates, 0.95)?.over(0.01);
    // Bins of the diameter that begin at the printed one or above.
    let (map, stride) = search.maps.iter().find_map(|map| match map.axes {
        [DIAMETER, _] => Some((map, 1)),
        [_, DIAMETER] => Some((map, BINS)),
        _ => None,
    })?;
    let bins = map.least.iter().enumerate().filter_map(|(index, least)| {
        let low = AXES[DIAMETER].scale.part(index / stride % BINS, BINS)[0];
        let from = AXES[DIAMETER].scale.value(low);
        (from >= PRINTED_DIAMETER - 1e-9).then_some((*least)?)
    });
    let least = bins.fold(f64::INFINITY, f64::min);
    let diameter = match least < CUT {
        true => format!(
            "does not exclude mean diameters of {PRINTED_DIAMETER} mm and more (R = 5 mm; {least:.2} deviations, cut at {CUT})"
        ),
        false => format!("excludes mean diameters of {PRINTED_DIAMETER} mm and more (R = 5 mm)"),
    };
    Some(format!(
        "Which settings the paper had is open: the search leaves {} % of its space and {diameter}.",
        told(left, 2)
    ))
}
