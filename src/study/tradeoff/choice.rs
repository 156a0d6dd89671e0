//! Which points are dominated, and which method is recommended.

use super::judge::Judgement;
use super::margins::CHARTED;
use super::method::Runner;
use super::record::Point;
use evidence::Interval;
use evidence::equivalence::Finding;
use grains::native::Mode;

/// A point is dominated by the cheapest one that costs no more and errs no more in bed and load, by the estimates.
pub fn dominance(points: &mut [Point]) {
    let places: Vec<Option<(f64, [Interval; 2])>> = points
        .iter()
        .map(|point| {
            let Judgement { bed, load, .. } = &point.charted;
            let errors = [bed.as_ref()?.error, load.as_ref()?.error];
            Some((point.costs?.cpu_seconds, errors))
        })
        .collect();
    for index in 0..points.len() {
        let Some((cost, errors)) = places[index] else {
            continue;
        };
        let no_worse = |others: &[Interval; 2]| {
            others
                .iter()
                .zip(&errors)
                .all(|(other, own)| other.estimate <= own.estimate)
        };
        let better = places
            .iter()
            .enumerate()
            .filter_map(|(other, place)| Some((other, (*place)?)))
            .filter(|(other, (c, others))| *other != index && *c <= cost && no_worse(others))
            .min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        if let Some((other, (_, smaller))) = better {
            points[index].dominated_by = Some(points[other].number);
            points[index].clearly = smaller
                .iter()
                .zip(&errors)
                .any(|(other, own)| other.high < own.low);
        }
    }
}

/// The cheapest candidate that is equivalent on its own realizations.
pub fn recommend(points: &[Point], confirming: u64) -> (Option<usize>, String) {
    if confirming == 0 {
        let words = "none: equivalence was not tested (no realizations of its own were asked for)";
        return (None, words.to_owned());
    }
    let tested = points.iter().filter_map(|point| {
        let confirmed = point.confirmed.as_ref()?;
        Some((point, confirmed.finding(), point.costs?.cpu_seconds))
    });
    let equivalent = tested.filter(|(point, finding, _)| {
        *finding == Finding::Equivalent && point.method.runner == Runner::Native(Mode::Free)
    });
    match equivalent.min_by(|a, b| a.2.total_cmp(&b.2)) {
        Some((point, _, seconds)) => (
            Some(point.number),
            format!(
                "{}: equivalent to the reference in every quantity with a margin over {confirming} clouds, at \
                 {seconds:.2} s of one core a realization",
                point.method.name
            ),
        ),
        None => (
            None,
            format!("none: no candidate was shown to be equivalent over {confirming} clouds"),
        ),
    }
}

/// What was not shown to be equivalent, in words.
pub fn not_shown(judgement: &Judgement) -> Vec<String> {
    let open = |finding: Option<Finding>| match finding {
        Some(Finding::Equivalent) => None,
        Some(Finding::Different) => Some("different"),
        Some(Finding::Undecided) => Some("undecided"),
        None => Some("not measured"),
    };
    let mut words: Vec<String> = CHARTED
        .iter()
        .filter(|charted| charted.margin.is_some())
        .filter_map(|charted| {
            let of = judgement
                .differences
                .iter()
                .find(|of| of.key == charted.key);
            let word = open(of.and_then(|of| of.finding))?;
            Some(format!("{} ({word})", charted.title))
        })
        .collect();
    if let Some(word) = open(judgement.missed_finding) {
        words.push(format!("share of missed forces ({word})"));
    }
    words
}
