//! Means over realizations against the continuum of Table 4.

use super::claim::{Claim, Row, Rule, verdict};
use super::sample::{self, Moment, stress};
use crate::paper::published::published;
use crate::paper::published::table_4;
use crate::study::campaign::member::Member;
use evidence::distribution::Distribution;
use evidence::goodness;

/// The control points of the paper, as the scene names them.
pub const POINTS: [&str; 3] = ["O", "A", "B"];
/// Means may be off by this share: see the published list.
const TENTH: f64 = 0.1;

fn within_a_tenth(of: f64) -> [f64; 2] {
    [(1.0 - TENTH) * of, (1.0 + TENTH) * of]
}

/// σ_zz at one point under the load.
pub fn at_point(members: &[Member], point: &'static str) -> Option<Claim> {
    let of = published(match point {
        "O" => "stress.O",
        "A" => "stress.A",
        _ => "stress.B",
    })?;
    let parts = table_4(point)?;
    let loaded = |what: &str| stress(members, Moment::Loaded, point, what);
    let (grain, local) = (loaded("grain_zz"), loaded("local_zz"));
    let limits = of.limits();
    let row = |what: &str, values: &[f64]| {
        Row::judged(what, "Pa", values.len(), limits, sample::mean(values)).against(of.value)
    };
    let under_load: Vec<f64> = members
        .iter()
        .filter_map(|member| {
            let of = |moment: Moment| {
                let key = format!("{}.stress.{point}.local_zz", moment.key());
                member.measured.get(&key).copied()
            };
            Some(of(Moment::Loaded)? - of(Moment::Settled)?)
        })
        .collect();
    let rows = vec![
        row("nearest grain, as in the paper", &grain),
        row("local mean, within two mean diameters", &local),
        Row::shown(
            "the load's part: local mean less that under gravity",
            "Pa",
            under_load.len(),
            sample::mean(&under_load),
        )
        .against(parts.load),
    ];
    let verdict = verdict(&rows, Rule::AnyReading);
    let percent = |row: &Row| 100.0 * (row.estimate() / of.value - 1.0);
    let load = 100.0 * (rows[2].estimate() / parts.load - 1.0);
    Some(Claim {
        id: match point {
            "O" => "mean.O",
            "A" => "mean.A",
            _ => "mean.B",
        }
        .into(),
        place: of.place.into(),
        statement: format!(
            "The mean of σ_zz at {point} over the realizations is the continuum's, {:.1} kPa.",
            of.value / 1e3
        ),
        reading: format!(
            "The nearest grain's mean is {:+.0} % off, the local mean {:+.0} %; the load's part alone {load:+.0} %.",
            percent(&rows[0]),
            percent(&rows[1])
        ),
        decided_by: format!(
            "Mean over members that got the force within {:.0} Pa: {}.",
            of.tolerance, of.reason
        ),
        rows,
        verdict,
        figure: "means".into(),
    })
}

/// σ_g,zz = ρ_s g (1 − n) z under gravity alone.
pub fn gravity(members: &[Member]) -> Option<Claim> {
    let mut rows = Vec::new();
    let mut ratios = Vec::new();
    for point in POINTS {
        let weight = table_4(point)?.weight;
        for (what, words) in [("local_zz", "local mean"), ("grain_zz", "nearest grain")] {
            let values = stress(members, Moment::Settled, point, what);
            let interval = sample::mean(&values);
            let name = format!("{point}: {words}");
            let row = if what == "local_zz" {
                Row::judged(name, "Pa", values.len(), within_a_tenth(weight), interval)
            } else {
                Row::shown(name, "Pa", values.len(), interval)
            };
            rows.push(row.against(weight));
        }
        let local = &rows[rows.len() - 2];
        ratios.push(format!(
            "{point} {:+.0} %",
            100.0 * (local.estimate() / weight - 1.0)
        ));
    }
    Some(Claim {
        id: "gravity".into(),
        place: "Table 4".into(),
        statement: "Before loading the mean of σ_zz at O, A and B is the weight above, σ_g,zz = 2.3 kPa.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!("Local means of settled beds are off by: {}.", ratios.join(", ")),
        decided_by: "Local mean over all settled members within a tenth of 2.3 kPa at each point; the single grain's mean \
                     is shown beside it."
            .to_owned(),
        rows,
        figure: "means".into(),
    })
}

/// E[Σ_zz] = V_c σ_zz.
pub fn extensive(members: &[Member]) -> Option<Claim> {
    let mut rows = Vec::new();
    for point in POINTS {
        let published = table_4(point)?.extensive;
        let values = stress(members, Moment::Loaded, point, "control_volume_zz");
        let row = Row::judged(
            format!("Σ^c_zz at {point}"),
            "J",
            values.len(),
            within_a_tenth(published),
            sample::mean(&values),
        );
        rows.push(row.against(published));
    }
    let off: Vec<String> = rows
        .iter()
        .filter_map(|row| Some(format!("{} {:.3} J", row.what, row.ours?.estimate)))
        .collect();
    Some(Claim {
        id: "extensive".into(),
        place: "Table 4, section 5".into(),
        statement: "E[Σ_zz] = V_c σ_zz: 0.34, 0.18 and 0.09 J at O, A and B for the control volume of side R.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!("Means here: {}.", off.join(", ")),
        decided_by: "Mean of the nearest grain's Σ_zz V_c/V_p within a tenth of the printed one at every point.".to_owned(),
        rows,
        figure: "means".into(),
    })
}

/// The law with the theory's rate: mean and form at once, and the interval estimate of section 5.
pub fn with_theorys_rate(members: &[Member]) -> Option<Claim> {
    let mut rows = Vec::new();
    let mut shares = Vec::new();
    for point in POINTS {
        let published = table_4(point)?.extensive;
        let values = stress(members, Moment::Loaded, point, "control_volume_zz");
        let law = Distribution::Exponential { mean: published };
        let limit = published * 20f64.ln();
        let above = values.iter().filter(|value| **value > limit).count();
        let share = |level: f64| evidence::proportion::wilson(above, values.len(), level);
        let mut row = Row::judged(
            format!("mean of Σ_zz over V_c σ_zz at {point}"),
            "1",
            values.len(),
            within_a_tenth(1.0),
            |level| Some(sample::mean(&values)(level)?.over(published)),
        )
        .against(1.0);
        if let Some(fit) = goodness::known(&law, &values, super::shapes::SAMPLES) {
            row = row.with_fit(
                "exponential with the theory's rate (Kolmogorov's D, exact)",
                &fit,
            );
        }
        rows.push(row);
        rows.push(
            Row::judged(
                format!("variation of Σ_zz at {point}"),
                "1",
                values.len(),
                within_a_tenth(1.0),
                sample::variation(&values),
            )
            .against(1.0),
        );
        rows.push(
            Row::shown(
                format!("share above the theory's 95 % value at {point}"),
                "1",
                values.len(),
                share,
            )
            .against(0.05),
        );
        shares.push(format!(
            "{point} {:.1} %",
            100.0 * above as f64 / values.len() as f64
        ));
    }
    Some(Claim {
        id: "exponential.theory".into(),
        place: "Eq. 7, section 5".into(),
        statement: "Σ_zz ~ Exp(1/(V_c σ_zz)) with σ_zz of Table 4 gives interval estimates of the stress at a point.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!(
            "Above the value that the theory lets one in twenty exceed are: {}.",
            shares.join(", ")
        ),
        decided_by: "Both parameters of the statement at every point: mean within a tenth of V_c σ_zz, and coefficient of \
                     variation within a tenth of 1. The p-values are for the exact statement, which no real packing meets."
            .to_owned(),
        rows,
        figure: "figure5".into(),
    })
}
