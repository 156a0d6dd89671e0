//! Ratios as dots on strips over one logarithmic axis, placed in per cent so that they fit any width.

use serde::Serialize;

use crate::limits::bench::Bench;
use crate::limits::bench::contender::Contender;

/// All strips with their axis.
#[derive(Debug, Serialize)]
pub struct Strips {
    ticks: Vec<Tick>,
    rows: Vec<Strip>,
}

#[derive(Debug, Serialize)]
struct Tick {
    place: f64,
    label: String,
}

/// An engine's time over native exact's.
#[derive(Debug, Serialize)]
struct Strip {
    name: String,
    /// Each round.
    dots: Vec<f64>,
    /// The middle half of the rounds: from, and how wide.
    box_from: f64,
    box_width: f64,
    median: f64,
    /// The goal, where there is one.
    goal: Option<f64>,
    text: String,
}

const LABELS: [f64; 13] = [
    0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0,
];

/// Where labels stand no closer than this, per cent.
const APART: f64 = 8.0;

impl Strips {
    /// Of the engines besides native exact; none if there are none.
    pub fn of(bench: &Bench) -> Option<Self> {
        let contests = bench.contests.iter();
        let others: Vec<_> = contests
            .filter(|contest| contest.contender != Contender::Exact)
            .filter_map(|contest| Some((contest, contest.over_exact.as_ref()?)))
            .collect();
        let least = others.iter().map(|(_, of)| of.least).fold(1.0, f64::min);
        let most = others.iter().map(|(_, of)| of.most).fold(1.0, f64::max);
        if others.is_empty() || least <= 0.0 {
            return None;
        }
        let (low, high) = ((0.8 * least).ln(), (1.3 * most).ln());
        let place = |ratio: f64| 100.0 * (ratio.ln() - low) / (high - low);
        let mut ticks: Vec<Tick> = Vec::new();
        for label in LABELS {
            let at = place(label);
            let free = ticks.last().is_none_or(|tick| at - tick.place > APART);
            if (0.0..=98.0).contains(&at) && free {
                ticks.push(Tick {
                    place: at,
                    label: label.to_string(),
                });
            }
        }
        let rows = others.into_iter().map(|(contest, of)| Strip {
            name: contest.name.clone(),
            dots: of.all.iter().map(|ratio| place(*ratio)).collect(),
            box_from: place(of.low_quartile),
            box_width: place(of.high_quartile) - place(of.low_quartile),
            median: place(of.median),
            goal: match contest.contender {
                Contender::YadeOrdinary => Some(place(30.0)),
                Contender::Lammps => Some(place(7.0)),
                _ => None,
            },
            text: format!("{:.2}", of.median),
        });
        Some(Strips {
            rows: rows.collect(),
            ticks,
        })
    }
}
