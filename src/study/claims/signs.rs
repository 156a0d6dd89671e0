//! What may be positive only, and what the theory says of what may be either: Laplace for the shear component.

use super::claim::{Claim, Row, Rule, verdict};
use super::exponential::SAMPLES;
use super::means::POINTS;
use super::quantities;
use super::sample::{Moment, stress};
use crate::study::campaign::member::Member;
use evidence::goodness;
use evidence::law::{Family, Law};
use evidence::moments::{deviation, median};

/// Positive only.
pub fn positive_only(members: &[Member]) -> Claim {
    let mut rows = Vec::new();
    for moment in Moment::BOTH {
        for point in POINTS {
            let values = stress(members, moment, point, "grain_zz");
            let row = |what: &str, holds: fn(f64) -> bool| {
                let name = format!("{point}, {}: share {what}", moment.words());
                (name, quantities::share(&values, holds))
            };
            let (name, negative) = row("below zero", |value| value < 0.0);
            // None of n has an upper end of about 2.7/n: 300 packings can show that one in a hundred is not reached.
            rows.push(Row::judged(name, "1", values.len(), [0.0, 0.01], negative).against(0.0));
            let (name, zero) = row("exactly zero (nothing carried)", |value| value == 0.0);
            rows.push(Row::shown(name, "1", values.len(), zero).against(0.0));
        }
    }
    let rattlers = super::sample::measured(members, "settled.coordination.rattlers");
    rows.push(Row::shown(
        "share of all grains of a settled bed that rattle",
        "1",
        rattlers.len(),
        quantities::mean(&rattlers),
    ));
    let negative: f64 = rows
        .iter()
        .step_by(2)
        .take(6)
        .map(Row::estimate)
        .fold(0.0, f64::max);
    let zeros: Vec<f64> = rows
        .iter()
        .skip(1)
        .step_by(2)
        .take(6)
        .map(Row::estimate)
        .collect();
    Claim {
        id: "positive".into(),
        place: "section 3.3".into(),
        statement: "Particles may take any positive value of the extensive stress; negative ones are impossible.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!(
            "At most {:.1} % at any point are negative; {:.1} % to {:.1} % of the grains at the points carry nothing at all, which a \
             continuous law has no place for.",
            100.0 * negative,
            100.0 * zeros.iter().copied().fold(f64::INFINITY, f64::min),
            100.0 * zeros.iter().copied().fold(0.0, f64::max),
        ),
        decided_by: "At most one in a hundred below zero at each point.".to_owned(),
        rows,
        figure: "figure5".into(),
    }
}

/// Mean absolute deviation from the median over standard deviation: 1/√2 for Laplace, √(2/π) for a normal law.
fn peakedness(values: &[f64]) -> f64 {
    let centre = median(values).unwrap_or(f64::NAN);
    let off: f64 = values.iter().map(|value| (value - centre).abs()).sum();
    off / values.len() as f64 / deviation(values)
}

/// Laplace for the shear component, from the same theory.
pub fn laplace(members: &[Member]) -> Claim {
    let laplace = std::f64::consts::FRAC_1_SQRT_2;
    let normal = (2.0 / std::f64::consts::PI).sqrt();
    let half_way = 0.5 * (normal - laplace);
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for point in POINTS {
        let values = stress(members, Moment::Loaded, point, "grain_xz");
        let mut row = Row::judged(
            format!("{point}: mean absolute over standard deviation"),
            "1",
            values.len(),
            [laplace - half_way, laplace + half_way],
            quantities::statistic(&values, peakedness),
        )
        .against(laplace);
        if let Some(fit) = goodness::fitted(Family::Laplace, &values, SAMPLES) {
            row = row.with_fit(
                "Laplace with fitted location and scale (D, drawn samples)",
                &fit,
            );
            if let Law::Laplace { scale, .. } = fit.law {
                found.push(format!(
                    "{point} {:.3} (scale {scale:.0} Pa)",
                    row.estimate()
                ));
            }
        }
        rows.push(row);
        rows.push(Row::shown(
            format!("{point}: mean"),
            "Pa",
            values.len(),
            quantities::mean(&values),
        ));
    }
    Claim {
        id: "laplace".into(),
        place: "section 3.3 and the same theory elsewhere".into(),
        statement: "Shear components can be positive or negative and do not follow an exponential; the theory gives them a \
                    Laplace law."
            .to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!(
            "Mean absolute over standard deviation, {laplace:.3} for Laplace and {normal:.3} for a normal law: {}.",
            found.join(", ")
        ),
        decided_by: "Mean absolute over standard deviation nearer to Laplace's than half the way to the normal law's, at every \
                     point. Components are taken along x and z, the theory's along the principal axes of the mean stress, \
                     which differ from them at A and B."
            .to_owned(),
        rows,
        figure: "shear".into(),
    }
}
