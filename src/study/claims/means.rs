//! Means over realizations against the continuum of Table 4.

use crate::checks::Outcome;
use crate::paper::published::{HEIGHTS, POINTS, POROSITIES, Published, published};
use crate::paper::recomputed::unrounded;
use crate::study::campaign::Member;
use crate::study::claims::sample::{Moment, Number, measured, stress};
use crate::study::claims::{Claim, Row, Rule, Verdict, sample, verdict};
use crate::study::realization::Ending;
use evidence::distribution::Distribution;
use evidence::moments::{mean, standard_deviation};
use evidence::zeros::Parted;
use evidence::{bootstrap, goodness};
use grains::scene::Scene;

/// Means may be off by this share: see the published list.
const TENTH: f64 = 0.1;

/// Judged to be within a tenth of the theory's value, before the paper rounded it.
pub fn near(what: String, theory: f64, number: Number<'_>) -> Row {
    let limits = [(1.0 - TENTH) * theory, (1.0 + TENTH) * theory];
    Row::judged(what, limits, number).against(theory)
}

/// σ_zz at one point under the load.
pub fn at_point(members: &[Member], point: &str) -> Option<Claim> {
    let figure = published(&format!("stress.{point}"))?;
    let parts = unrounded(point)?;
    let loaded = |what: &str| stress(members, Moment::Loaded, point, what);
    let (grain, local) = (loaded("grain_zz"), loaded("local_zz"));
    let row = |what: &str, values: &[f64]| {
        near(what.to_owned(), parts.stress, sample::mean(values)).in_unit("Pa")
    };
    let bears = Parted::loads(&grain).others;
    let bears = Row::shown("nearest grain, if it bears load", sample::mean(&bears));
    let under_load = members.iter().filter_map(|member| {
        let local_mean = |moment: Moment| {
            let key = format!("{}.stress.{point}.local_zz", moment.key());
            member.measured.get(&key).copied()
        };
        Some(local_mean(Moment::Loaded)? - local_mean(Moment::Settled)?)
    });
    let under_load: Vec<f64> = under_load.collect();
    let load = "the load's part of the local mean";
    let load = Row::shown(load, sample::mean(&under_load)).in_unit("Pa");
    let rows = vec![
        row("nearest grain, as in the paper", &grain),
        row("local mean, within two mean diameters", &local),
        load.against(parts.load),
        bears.in_unit("Pa").against(parts.stress),
    ];
    let verdict = verdict(&rows, Rule::AnyReading);
    let percent = |row: &Row| 100.0 * (row.estimate() / parts.stress - 1.0);
    let load = 100.0 * (rows[2].estimate() / parts.load - 1.0);
    Some(Claim::of(format!("mean.{point}"), figure.place, "means")
        .says(format!(
            "The mean of σ_zz at {point} over the realizations is the continuum's, {:.1} kPa; no simulated mean is printed.",
            figure.value / 1e3
        ))
        .found(format!(
            "The nearest grain's mean is {:+.0} % off, the local mean {:+.0} %; the load's part alone {load:+.0} %.",
            percent(&rows[0]),
            percent(&rows[1])
        ))
        .decided_by(format!(
            "Mean over all members that got the force within {}. Limits are of the value before rounding.",
            figure.reason
        ))
        .with(verdict, rows))
}

/// σ_g,zz = ρ_s g (1 − n) z under gravity alone.
pub fn gravity(members: &[Member]) -> Option<Claim> {
    let mut rows = Vec::new();
    let mut ratios = Vec::new();
    for point in POINTS {
        let weight = unrounded(point)?.weight;
        for (what, words) in [("local_zz", "local mean"), ("grain_zz", "nearest grain")] {
            let values = stress(members, Moment::Settled, point, what);
            let interval = sample::mean(&values);
            let name = format!("{point}: {words}");
            let row = match what {
                "local_zz" => near(name, weight, interval),
                _ => Row::shown(name, interval).against(weight),
            };
            rows.push(row.in_unit("Pa"));
        }
        let off = 100.0 * (rows[rows.len() - 2].estimate() / weight - 1.0);
        ratios.push(format!("{point} {off:+.0} %"));
    }
    Some(Claim::of("gravity", "Table 4", "means")
        .says("Before loading the mean of σ_zz at O, A and B is the weight above, σ_g,zz = 2.3 kPa.")
        .found(format!("Local means of settled beds are off by: {}.", ratios.join(", ")))
        .decided_by("Local mean over all settled members within a tenth of 2.33 kPa, which is printed as 2.3, at each point; the single grain's mean \
                     is shown beside it.")
        .by(Rule::All, rows))
}

/// E[Σ_zz] = V_c σ_zz.
pub fn extensive(members: &[Member]) -> Option<Claim> {
    let mut rows = Vec::new();
    for point in POINTS {
        let theory = unrounded(point)?.extensive;
        let values = stress(members, Moment::Loaded, point, "control_volume_zz");
        let name = format!("Σ^c_zz at {point}");
        rows.push(near(name, theory, sample::mean(&values)).in_unit("J"));
    }
    let off = rows.iter().filter(|row| row.ours.is_some());
    let off: Vec<String> = off
        .map(|row| format!("{} {:.3} J", row.what, row.estimate()))
        .collect();
    Some(Claim::of("extensive", "Table 4, section 5", "means")
        .says("E[Σ_zz] = V_c σ_zz: 0.34, 0.18 and 0.09 J at O, A and B for the control volume of side R.")
        .found(format!("Means here: {}.", off.join(", ")))
        .decided_by("Mean of the nearest grain's Σ_zz V_c/V_p within a tenth of the theory's before rounding at every point: 0.0945 J, not 0.09 J, at B.")
        .by(Rule::All, rows))
}

/// The law with the theory's rate: mean and form at once, and the interval estimate of section 5.
pub fn with_theorys_rate(members: &[Member]) -> Option<Claim> {
    let mut rows = Vec::new();
    let mut shares = Vec::new();
    for point in POINTS {
        let theory = unrounded(point)?.extensive;
        let values = stress(members, Moment::Loaded, point, "control_volume_zz");
        let law = Distribution::Exponential { mean: theory };
        let limit = theory * 20f64.ln();
        let above = values.iter().filter(|value| **value > limit).count();
        let parted = Parted::loads(&values);
        let name = |what: &str| format!("{what} at {point}");
        let over = |values| sample::mean(values).over(theory);
        let mut row = near(name("mean of Σ_zz over V_c σ_zz"), 1.0, over(&values));
        if let Some(fit) = goodness::known(&law, &values, super::shapes::SAMPLES) {
            let test = "exponential with the theory's rate (Kolmogorov's D, exact)";
            row = row.with_fit(test, &fit);
        }
        let loaded = name("the same mean, of grains that bear load");
        let variation = name("variation of Σ_zz");
        let of_loaded = name("variation of Σ_zz of grains that bear load");
        let beyond = name("share above the theory's 95 % value");
        let nothing = name("share of grains that bear nothing or are pulled");
        rows.extend([
            row,
            near(variation, 1.0, sample::variation(&values)),
            Row::shown(loaded, over(&parted.others)).against(1.0),
            Row::shown(of_loaded, sample::variation(&parted.others)).against(1.0),
            Row::shown(beyond, sample::share(above, values.len())).against(0.05),
            Row::shown(nothing, sample::zeros(&parted)),
        ]);
        let percent = 100.0 * above as f64 / values.len() as f64;
        shares.push(format!("{point} {percent:.1} %"));
    }
    let shares = shares.join(", ");
    Some(Claim::of("exponential.theory", "Eq. 7, section 5", "figure5")
        .says("Σ_zz ~ Exp(1/(V_c σ_zz)) with σ_zz of Table 4 gives interval estimates of the stress at a point.")
        .found(format!("Above the value that the theory lets one in twenty exceed are: {shares}."))
        .decided_by("Both parameters of the statement at every point, of all grains: mean within a tenth of V_c σ_zz before rounding, and \
                     coefficient of variation within a tenth of 1. The p-values are for the exact statement, which no real packing meets.")
        .by(Rule::All, rows))
}

/// Above this share of members that do not get the force, what becomes of them matters to every mean.
const NEGLIGIBLE: f64 = 0.01;

fn which_hold(rows: &[Row]) -> String {
    let named = |wanted: Outcome| {
        let is_it = |row: &&Row| row.judged.is_some_and(|judged| judged.outcome == wanted);
        let names = rows.iter().filter(is_it).map(|row| row.what.as_str());
        names.collect::<Vec<&str>>().join("; ")
    };
    let (names, open) = (named(Outcome::Pass), named(Outcome::Skipped));
    let names = or_none(&names);
    match open.is_empty() {
        true => names.to_owned(),
        false => format!("{names}; undecided: {open}"),
    }
}

fn or_none(names: &str) -> &str {
    if names.is_empty() { "none" } else { names }
}

/// H = 0.46 ± 0.01 m.
pub fn height(members: &[Member]) -> Option<Claim> {
    let says = "The height of the packing after pouring is H = 0.46 ± 0.01 m.";
    let words = [says, "± 0.01 m", "how a height is taken", " m"];
    by_definition(members, "height", &*HEIGHTS, words)
}

/// n = 0.17 ± 0.01.
pub fn porosity(members: &[Member]) -> Option<Claim> {
    let says = "That height corresponds to an average porosity of n = 0.17 ± 0.01.";
    let words = [says, "± 0.01", "where a porosity is taken", ""];
    by_definition(members, "porosity", &*POROSITIES, words)
}

fn by_definition(
    members: &[Member],
    id: &'static str,
    keys: &[(&str, &str)],
    [says, scatter, open, unit]: [&str; 4],
) -> Option<Claim> {
    let figure = published(id)?;
    let row = |(key, words): &(&str, &str)| {
        let values = measured(members, key);
        let row = Row::judged(*words, figure.limits(), sample::mean(&values)).in_unit(figure.unit);
        row.against(figure.value)
    };
    let mut rows: Vec<Row> = keys.iter().map(row).collect();
    let found = which_hold(&rows);
    let beds = measured(members, keys[0].0);
    let spread = Number::new(beds.len(), |level| {
        bootstrap::of_values(&beds, level, standard_deviation)
    });
    let what = format!("standard deviation from bed to bed, {}", keys[0].1);
    let spread = Row::shown(what, spread);
    rows.push(spread.in_unit(figure.unit).against(figure.tolerance));
    let spread = &rows[keys.len()];
    Some(Claim::of(id, figure.place, "plane")
        .says(says)
        .found(format!(
            "Mean {id} within the printed {scatter} by: {found}; from bed to bed it varies by {:.4}{unit}.",
            spread.estimate()
        ))
        .decided_by(format!(
            "Mean over settled members within the printed {scatter}. The paper does not say {open}, so each definition is a \
             reading. Nor does it say whether {scatter} is such a band or the scatter from bed to bed, which is shown beside."
        ))
        .by(Rule::AnyReading, rows))
}

/// Both at once: they are tied by the area of the grains, n = 1 − S/(L·H).
pub fn both(scene: &Scene, members: &[Member]) -> Option<Claim> {
    let (height, porosity) = (published("height")?, published("porosity")?);
    let inside = |figure: &Published, value: f64| (value - figure.value).abs() <= figure.tolerance;
    let mut rows = Vec::new();
    let mut mixed = Vec::new();
    for (index, (height_key, height_words)) in HEIGHTS.iter().enumerate() {
        let beds = members.iter().filter_map(|member| {
            let value = |key: &str| member.measured.get(key).copied();
            Some(
                inside(height, value(height_key)?) && inside(porosity, value(POROSITIES[index].0)?),
            )
        });
        let beds: Vec<bool> = beds.collect();
        let hits = beds.iter().filter(|both| **both).count();
        let share = sample::share(hits, beds.len());
        let what = format!("share of beds with both, {height_words} for both");
        rows.push(Row::judged(what, [0.5, 1.0], share));
        let mean_of = |key: &str| mean(&measured(members, key));
        for (porosity_key, porosity_words) in *POROSITIES {
            if inside(height, mean_of(height_key)) && inside(porosity, mean_of(porosity_key)) {
                mixed.push(format!("{height_words} with porosity {porosity_words}"));
            }
        }
    }
    let solid = solid(scene);
    let needed = height.value * (1.0 - porosity.value) / solid;
    let same = verdict(&rows, Rule::AnyReading).map(|verdict| match verdict {
        Verdict::Holds => Verdict::Holds,
        Verdict::DoesNotHold if mixed.is_empty() => Verdict::DoesNotHold,
        _ => Verdict::HoldsUnderStatedChoices,
    });
    Some(Claim::of("height_and_porosity", height.place, "plane")
        .says("H = 0.46 ± 0.01 m and n = 0.17 ± 0.01 belong to the same beds.")
        .found(format!(
            "The grains' area ties them: n = 1 − {solid:.5} m/H is {:.3} at H = {} m, and n = {} would need H = {:.4} m, or, \
             with both as printed, a mean diameter of {:.3} mm or {:.0} grains; means that meet both: {}.",
            1.0 - solid / height.value,
            height.value,
            porosity.value,
            solid / (1.0 - porosity.value),
            1e3 * scene.particles.mean_diameter * needed.sqrt(),
            f64::from(scene.particles.count) * needed,
            or_none(&mixed.join("; "))
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
    let ended = |wanted| {
        members
            .iter()
            .filter(|member| member.ending == wanted)
            .count()
    };
    let reached = ended(Ending::Reached);
    let missed = ended(Ending::TargetLoadNotReached);
    let others = members.len() - reached - missed;
    let share = |hits: usize| sample::share(hits, members.len());
    let rows = vec![
        Row::judged("force reached", [1.0 - NEGLIGIBLE, 1.0], share(reached)).against(1.0),
        Row::shown("target load not reached", share(missed)),
        Row::shown("did not settle, or failed", share(others)),
    ];
    let verdict = verdict(&rows, Rule::All).map(|verdict| match verdict {
        Verdict::DoesNotHold => Verdict::CannotBeDecided,
        other => other,
    });
    let left_out = match missed {
        0 => "no mean under load is biased by them",
        _ => "means under load leave them out",
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
