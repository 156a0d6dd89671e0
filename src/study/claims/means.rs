//! Means over realizations against the continuum of Table 4.

use crate::paper::published::{HEIGHTS, POROSITIES, Published, published, table_4};
use crate::study::campaign::Member;
use crate::study::claims::sample::{Moment, Number, measured, stress};
use crate::study::claims::{Claim, Row, Rule, Verdict, sample, verdict};
use crate::study::realization::Ending;
use evidence::distribution::Distribution;
use evidence::goodness;
use evidence::moments::mean;
use evidence::t_test::welch;
use evidence::zeros::Parted;
use grains::scene::Scene;

/// The control points of the paper, as the scene names them.
pub const POINTS: [&str; 3] = ["O", "A", "B"];
/// Means may be off by this share: see the published list.
const TENTH: f64 = 0.1;

fn within_a_tenth(of: f64) -> [f64; 2] {
    [(1.0 - TENTH) * of, (1.0 + TENTH) * of]
}

/// σ_zz at one point under the load.
pub fn at_point(members: &[Member], point: &str) -> Option<Claim> {
    let of = published(&format!("stress.{point}"))?;
    let parts = table_4(point)?;
    let loaded = |what: &str| stress(members, Moment::Loaded, point, what);
    let (grain, local) = (loaded("grain_zz"), loaded("local_zz"));
    let limits = of.limits();
    let row = |what: &str, values: &[f64]| {
        Row::judged(what, limits, sample::mean(values))
            .in_unit("Pa")
            .against(of.value)
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
            sample::mean(&under_load),
        )
        .in_unit("Pa")
        .against(parts.load),
    ];
    let verdict = verdict(&rows, Rule::AnyReading);
    let percent = |row: &Row| 100.0 * (row.estimate() / of.value - 1.0);
    let load = 100.0 * (rows[2].estimate() / parts.load - 1.0);
    Some(Claim::of(format!("mean.{point}"), of.place, "means")
        .says(format!(
            "The mean of σ_zz at {point} over the realizations is the continuum's, {:.1} kPa.",
            of.value / 1e3
        ))
        .found(format!(
            "The nearest grain's mean is {:+.0} % off, the local mean {:+.0} %; the load's part alone {load:+.0} %.",
            percent(&rows[0]),
            percent(&rows[1])
        ))
        .decided_by(format!(
            "Mean over members that got the force within {:.0} Pa: {}.",
            of.tolerance, of.reason
        ))
        .with(verdict, rows))
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
                Row::judged(name, within_a_tenth(weight), interval).in_unit("Pa")
            } else {
                Row::shown(name, interval).in_unit("Pa")
            };
            rows.push(row.against(weight));
        }
        let local = &rows[rows.len() - 2];
        ratios.push(format!(
            "{point} {:+.0} %",
            100.0 * (local.estimate() / weight - 1.0)
        ));
    }
    Some(Claim::of("gravity", "Table 4", "means")
        .says("Before loading the mean of σ_zz at O, A and B is the weight above, σ_g,zz = 2.3 kPa.")
        .found(format!("Local means of settled beds are off by: {}.", ratios.join(", ")))
        .decided_by("Local mean over all settled members within a tenth of 2.3 kPa at each point; the single grain's mean \
                     is shown beside it.")
        .by(Rule::All, rows))
}

/// E[Σ_zz] = V_c σ_zz.
pub fn extensive(members: &[Member]) -> Option<Claim> {
    let mut rows = Vec::new();
    for point in POINTS {
        let published = table_4(point)?.extensive;
        let values = stress(members, Moment::Loaded, point, "control_volume_zz");
        let row = Row::judged(
            format!("Σ^c_zz at {point}"),
            within_a_tenth(published),
            sample::mean(&values),
        )
        .in_unit("J");
        rows.push(row.against(published));
    }
    let off: Vec<String> = rows
        .iter()
        .filter_map(|row| Some(format!("{} {:.3} J", row.what, row.ours?.estimate)))
        .collect();
    Some(Claim::of("extensive", "Table 4, section 5", "means")
        .says("E[Σ_zz] = V_c σ_zz: 0.34, 0.18 and 0.09 J at O, A and B for the control volume of side R.")
        .found(format!("Means here: {}.", off.join(", ")))
        .decided_by("Mean of the nearest grain's Σ_zz V_c/V_p within a tenth of the printed one at every point.")
        .by(Rule::All, rows))
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
        let parted = Parted::of(&values);
        let mut row = Row::judged(
            format!("mean of Σ_zz over V_c σ_zz at {point}"),
            within_a_tenth(1.0),
            sample::mean(&values).over(published),
        )
        .against(1.0);
        if let Some(fit) = goodness::known(&law, &parted.others, super::shapes::SAMPLES) {
            row = row.with_fit(
                "grains that bear load: exponential with the theory's rate (Kolmogorov's D, exact)",
                &fit,
            );
        }
        rows.push(row);
        rows.push(
            Row::judged(
                format!("variation of Σ_zz of grains that bear load at {point}"),
                within_a_tenth(1.0),
                sample::variation(&parted.others),
            )
            .against(1.0),
        );
        rows.push(
            Row::shown(
                format!("share above the theory's 95 % value at {point}"),
                sample::share(above, values.len()),
            )
            .against(0.05),
        );
        rows.push(Row::shown(
            format!("share of grains that bear nothing at {point}"),
            sample::zeros(&parted),
        ));
        shares.push(format!(
            "{point} {:.1} %",
            100.0 * above as f64 / values.len() as f64
        ));
    }
    Some(Claim::of("exponential.theory", "Eq. 7, section 5", "figure5")
        .says("Σ_zz ~ Exp(1/(V_c σ_zz)) with σ_zz of Table 4 gives interval estimates of the stress at a point.")
        .found(format!(
            "Above the value that the theory lets one in twenty exceed are: {}.",
            shares.join(", ")
        ))
        .decided_by("Both parameters of the statement at every point: mean within a tenth of V_c σ_zz, and coefficient of \
                     variation of the grains that bear load within a tenth of 1. The p-values are for the exact statement, which no real packing meets.")
        .by(Rule::All, rows))
}

/// Above this share of members that do not get the force, what becomes of them matters to every mean.
const NEGLIGIBLE: f64 = 0.01;

fn definitions(members: &[Member], of: &Published, keys: &[(&str, &str)]) -> Vec<Row> {
    let row = |(key, words): &(&str, &str)| {
        let values = measured(members, key);
        let row = Row::judged(*words, of.limits(), sample::mean(&values)).in_unit(of.unit);
        row.against(of.value)
    };
    keys.iter().map(row).collect()
}

fn which_hold(rows: &[Row]) -> String {
    let names: Vec<&str> = rows
        .iter()
        .filter(|row| row.holds())
        .map(|row| row.what.as_str())
        .collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join("; ")
    }
}

fn spread(members: &[Member], key: &str) -> f64 {
    evidence::moments::standard_deviation(&measured(members, key))
}

/// H = 0.46 ± 0.01 m.
pub fn height(members: &[Member]) -> Option<Claim> {
    let of = published("height")?;
    let rows = definitions(members, of, &HEIGHTS);
    Some(Claim::of("height", of.place, "plane")
        .says("The height of the packing after pouring is H = 0.46 ± 0.01 m.")
        .found(format!(
            "Mean height within the printed ± 0.01 m by: {}; from bed to bed it varies by {:.4} m.",
            which_hold(&rows),
            spread(members, HEIGHTS[0].0)
        ))
        .decided_by("Mean over settled members within the printed ± 0.01 m. The paper does not say how a height is \
                     taken, so each definition is a reading.")
        .by(Rule::AnyReading, rows))
}

/// n = 0.17 ± 0.01.
pub fn porosity(members: &[Member]) -> Option<Claim> {
    let of = published("porosity")?;
    let rows = definitions(members, of, &POROSITIES);
    Some(Claim::of("porosity", of.place, "plane")
        .says("That height corresponds to an average porosity of n = 0.17 ± 0.01.")
        .found(format!("Mean porosity within the printed ± 0.01 by: {}.", which_hold(&rows)))
        .decided_by("Mean over settled members within the printed ± 0.01. The paper does not say where a porosity is \
                     taken, so each definition is a reading.")
        .by(Rule::AnyReading, rows))
}

/// Both at once: they are tied by the area of the grains, n = 1 − S/(L·H).
pub fn both(scene: &Scene, members: &[Member]) -> Option<Claim> {
    let (height, porosity) = (published("height")?, published("porosity")?);
    let inside = |of: &Published, value: f64| (value - of.value).abs() <= of.tolerance;
    let mut rows = Vec::new();
    let mut mixed = Vec::new();
    for (index, (height_key, height_words)) in HEIGHTS.iter().enumerate() {
        let pairs: Vec<f64> = members
            .iter()
            .filter_map(|member| {
                let of = |key: &str| member.measured.get(key).copied();
                let both =
                    inside(height, of(height_key)?) && inside(porosity, of(POROSITIES[index].0)?);
                Some(f64::from(u8::from(both)))
            })
            .collect();
        rows.push(Row::judged(
            format!("share of beds with both, {height_words} for both"),
            [0.5, 1.0],
            sample::share_of(&pairs, |both| both > 0.5),
        ));
        for (porosity_key, porosity_words) in POROSITIES {
            let (of_height, of_porosity) = (
                mean(&measured(members, height_key)),
                mean(&measured(members, porosity_key)),
            );
            if inside(height, of_height) && inside(porosity, of_porosity) {
                mixed.push(format!("{height_words} with porosity {porosity_words}"));
            }
        }
    }
    let solid = solid(scene);
    let same = verdict(&rows, Rule::AnyReading).map(|verdict| match verdict {
        Verdict::Holds => Verdict::Holds,
        Verdict::DoesNotHold if mixed.is_empty() => Verdict::DoesNotHold,
        _ => Verdict::HoldsUnderStatedChoices,
    });
    Some(Claim::of("height_and_porosity", height.place, "plane")
        .says("H = 0.46 ± 0.01 m and n = 0.17 ± 0.01 belong to the same beds.")
        .found(format!(
            "The grains' area ties them: n = 1 − {solid:.5} m/H is {:.3} at H = {} m, and n = {} would need H = {:.4} m; \
             means that meet both: {}.",
            1.0 - solid / height.value,
            height.value,
            porosity.value,
            solid / (1.0 - porosity.value),
            if mixed.is_empty() { "none".to_owned() } else { mixed.join("; ") }
        ))
        .decided_by("With one definition for both, half of the beds or more within both printed ± 0.01; a mean height and \
                     a mean porosity of different definitions count as a reading.")
        .with(same, rows))
}

/// Area of all grains over the width, m: n = 1 − this/H.
pub fn solid(scene: &Scene) -> f64 {
    let diameter = scene.particles.mean_diameter;
    let dispersion = scene.particles.dispersion;
    let disc = 0.25 * std::f64::consts::PI * diameter.powi(2) * (1.0 + dispersion.powi(2) / 3.0);
    f64::from(scene.particles.count) * disc / scene.container.width
}

/// Every experiment ends with the force 2ap: which members are left out of what follows.
pub fn reached(members: &[Member]) -> Claim {
    let is = |wanted: fn(&Ending) -> bool| {
        members
            .iter()
            .filter(|member| wanted(&member.ending))
            .count()
    };
    let reached = is(|ending| *ending == Ending::Reached);
    let missed = is(|ending| *ending == Ending::TargetLoadNotReached);
    let others = members.len() - reached - missed;
    let share = |hits: usize| sample::share(hits, members.len());
    let mut rows = vec![
        Row::judged("force reached", [1.0 - NEGLIGIBLE, 1.0], share(reached)).against(1.0),
        Row::shown("target load not reached", share(missed)),
        Row::shown("did not settle, or failed", share(others)),
    ];
    rows.extend(bias(members));
    let verdict = verdict(&rows, Rule::All).map(|verdict| match verdict {
        Verdict::DoesNotHold => Verdict::CannotBeDecided,
        other => other,
    });
    let left_out = if missed == 0 {
        "no mean under load is biased by them".to_owned()
    } else {
        let of = &rows[3..];
        let shifts: Vec<String> = of
            .iter()
            .map(|row| format!("{} {:+.1} %", row.what, 100.0 * row.estimate()))
            .collect();
        if shifts.is_empty() {
            "means under load leave them out; they are too few to say what that does to other means"
                .to_owned()
        } else {
            format!(
                "means under load leave them out, and the members kept differ before loading from all settled ones by: {}",
                shifts.join(", ")
            )
        }
    };
    Claim::of("reached", "section 3.2.2", "means")
        .says("In each of about one thousand experiments the punch is moved until its force equals 2ap.")
        .found(format!(
            "{reached} of {} got the force, in {missed} the target load was not reached, and {others} did not settle or failed; {left_out}.",
            members.len()
        ))
        .decided_by(format!(
            "Holds where at most {} % do not get it. Otherwise it cannot be decided: the paper prints neither the \
             punch's speed nor whether experiments were dropped.",
            100.0 * NEGLIGIBLE
        ))
        .with(verdict, rows)
}

/// What leaving out members without the force does to means that all settled members have: (kept − all)/all.
fn bias(members: &[Member]) -> Vec<Row> {
    let split = |key: &str| {
        let of = |wanted: Ending| -> Vec<f64> {
            let kept = members.iter().filter(|member| member.ending == wanted);
            kept.filter_map(|member| member.measured.get(key))
                .copied()
                .collect()
        };
        (of(Ending::Reached), of(Ending::TargetLoadNotReached))
    };
    let quantities = [
        ("settled.height.mean_surface", "height"),
        ("settled.coordination.mean", "coordination"),
        ("settled.stress.O.local_zz", "local mean stress at O"),
    ];
    let row = |(key, words): (&str, &str)| {
        let (kept, dropped) = split(key);
        let all = [kept.clone(), dropped.clone()].concat();
        let share = dropped.len() as f64 / all.len() as f64;
        let scale = mean(&all);
        let compared = welch(&dropped, &kept)?;
        let times = share / scale;
        let of = compared.difference;
        let row = Row::shown(
            format!("bias of {words}"),
            Number::new(all.len(), |_| {
                Some(evidence::Interval {
                    estimate: of.estimate * times,
                    low: of.low * times,
                    high: of.high * times,
                })
            }),
        );
        let t = of.estimate / compared.error;
        Some(row.with(
            "kept members and those without the force have the same mean (Welch)",
            t,
            compared.p,
        ))
    };
    quantities.into_iter().filter_map(row).collect()
}
