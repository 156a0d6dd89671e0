//! The form of the distributions: exponential for normal components, which may be positive only, Laplace for the shear
//! component; by this paper, and by the same author's earlier one on the same set-up.

use std::f64::consts::FRAC_1_SQRT_2;

use super::means::near;
use super::sample::{self, Moment, Number, stress};
use super::{Claim, Row, Rule, together};
use crate::paper::published::{E_TO_MINUS_2, POINTS};
use crate::paper::recomputed::unrounded;
use crate::study::campaign::Member;
use evidence::distribution::{Distribution, Family};
use evidence::likelihood::{against_exponential, not_nested};
use evidence::moments::{mean, median, standard_deviation};
use evidence::zeros::Parted;
use evidence::{bootstrap, goodness, proportion};

/// Samples drawn for a p-value: the smallest is 1/5000, and 0.013 after Holm's correction for the 60 tests or so of all claims.
pub const SAMPLES: usize = 4999;
/// An exponential's share above two and three means: 13.5 % and 5.0 %.
const ABOVE: [(f64, f64); 2] = [(2.0, E_TO_MINUS_2), (3.0, 0.049_787_068_367_863_94)];
/// Coefficients of variation within a tenth of 1, see the published list.
const VARIATION: [f64; 2] = [0.9, 1.1];
/// Gamma shapes whose coefficient of variation 1/√k is within a tenth of 1.
const SHAPE: [f64; 2] = [1.0 / (1.1 * 1.1), 1.0 / (0.9 * 0.9)];

const DECIDED_BY: &str = "Of grains that bear load: coefficient of variation within a tenth of 1 and gamma shape within \
                          1/1.1² to 1/0.9², which is the same for a gamma law; the mean is fitted. p-values follow the effects and decide nothing: a \
                          thousand packings reject a shape of 1.15.";

/// The numbers of one sample: what decides, and what is shown.
fn rows_of(name: &str, values: &[f64]) -> Vec<Row> {
    let parted = Parted::loads(values);
    let looked_at = values.len();
    let of_all = Row::shown(
        format!("{name} of all grains: coefficient of variation"),
        sample::variation(values),
    );
    let values = &parted.others;
    let name_of = |what: &str| format!("{name} of grains that bear load: {what}");
    let variation = name_of("coefficient of variation");
    let mut variation = Row::judged(
        variation,
        VARIATION,
        sample::variation(values).out_of(looked_at),
    )
    .against(1.0);
    if let Some(fit) = goodness::fitted(Family::Exponential, values, SAMPLES) {
        let test = "exponential with the fitted mean (Lilliefors' D, drawn samples)";
        variation = variation.with_fit(test, &fit);
    }
    let of_law = |family| sample::law_shape(family, values).out_of(looked_at);
    let mut shape = Row::judged(name_of("gamma shape"), SHAPE, of_law(Family::Gamma)).against(1.0);
    if let Some(found) = against_exponential(Family::Gamma, values) {
        shape = shape.with("shape 1 (likelihood ratio, χ²₁)", found.ratio, found.p);
    }
    if let Some(fit) = goodness::fitted(Family::Gamma, values, SAMPLES) {
        let test = "gamma with the fitted shape (A², drawn samples)";
        shape = shape.with(test, fit.distances.anderson_darling, fit.anderson_darling_p);
    }
    let above = |(multiple, share): (f64, f64)| {
        let number = Number::new(values.len(), move |level| {
            proportion::above_multiple_of_mean(values, multiple, level)
        });
        let what = name_of(&format!("share above {multiple:.0} of their means"));
        Row::shown(what, number).against(share)
    };
    let nothing = format!("{name}: share of grains that bear nothing or are pulled");
    let mut rows = vec![variation, shape];
    rows.extend(ABOVE.map(above));
    rows.push(Row::shown(name_of("Weibull shape"), of_law(Family::Weibull)).against(1.0));
    rows.push(of_all.against(1.0));
    rows.push(Row::shown(nothing, sample::zeros(&parted)));
    rows
}

/// The share of grains that bear nothing or are pulled, the last of [`rows_of`], in words.
fn nothing(rows: &[Row]) -> String {
    let share = rows.last().and_then(|row| row.ours);
    share.map_or(String::new(), |share| {
        format!(
            "{:.1} % ({:.1} to {:.1}) bear nothing or are pulled.",
            100.0 * share.estimate,
            100.0 * share.low,
            100.0 * share.high
        )
    })
}

fn distance(rows: &[Row]) -> f64 {
    let found = rows.iter().flat_map(|row| &row.probabilities).next();
    found.map_or(f64::NAN, |found| found.statistic)
}

/// Exponential at one point with its fitted mean.
pub fn at_point(members: &[Member], point: &str) -> Claim {
    let values = stress(members, Moment::Loaded, point, "grain_zz");
    let rows = rows_of("Σ_zz", &values);
    Claim::of(format!("exponential.{point}"), "section 4.2, Figure 5", "figure5")
        .says(format!("At {point} the measured distribution of Σ_zz matches an exponential."))
        .found(format!(
            "Of grains that bear load: variation {:.2} instead of 1 (of all grains {:.2}), gamma shape {:.2} instead of 1, {:.1} % \
             above two of their means instead of 13.5 %; D from the fitted exponential {:.3}. {}",
            rows[0].estimate(),
            rows[rows.len() - 2].estimate(),
            rows[1].estimate(),
            100.0 * rows[2].estimate(),
            distance(&rows),
            nothing(&rows)
        ))
        .decided_by(DECIDED_BY)
        .by(Rule::All, rows)
}

/// The same for settled beds, where no load stands near: what the theory says of gravity alone.
pub fn settled(members: &[Member]) -> Claim {
    let says =
        "The exponential law holds for any class of packings: also for Σ_zz under gravity alone.";
    let claim = Claim::of("exponential.gravity", "section 3.3", "figure5.gravity").says(says);
    several(claim, members, Moment::Settled, "grain_zz")
}

pub fn horizontal(members: &[Member]) -> Claim {
    let says = "The exponential law also applies for the horizontal stress, with a different mean.";
    let claim = Claim::of("exponential.xx", "section 3.3", "figure5.xx").says(says);
    several(claim, members, Moment::Loaded, "grain_xx")
}

fn several(claim: Claim, members: &[Member], moment: Moment, what: &str) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for point in POINTS {
        let quantity = what.replace("grain_", "Σ_");
        let name = format!("{quantity} at {point}");
        let of_point = rows_of(&name, &stress(members, moment, point, what));
        let shape = of_point[1].estimate();
        found.push(format!("{point} {shape:.2}; {}", nothing(&of_point)));
        rows.extend(of_point);
    }
    let found = found.join(" ");
    claim
        .found(format!(
            "Gamma shapes of grains that bear load, instead of 1: {found}"
        ))
        .decided_by(format!("At every point: {DECIDED_BY}"))
        .by(Rule::All, rows)
}

fn in_words(claims: &[&Claim]) -> String {
    let said = claims
        .iter()
        .map(|claim| format!("{} {}", claim.id, claim.word()));
    format!("{}.", said.collect::<Vec<String>>().join("; "))
}

/// Whether all of Figure 5 is one verdict: the paper's conclusion.
pub fn conclusion(members: &[Member], claims: &[Claim]) -> Claim {
    let form = |claim: &&Claim| {
        let point = claim.id.strip_prefix("exponential.");
        point.is_some_and(|point| POINTS.contains(&point))
    };
    let rows = POINTS.into_iter().filter_map(|point| {
        let bears = Parted::loads(&stress(members, Moment::Loaded, point, "grain_zz")).others;
        let name = format!("σ_zz at {point} of grains that bear load: mean");
        let row = near(name, unrounded(point)?.stress, sample::mean(&bears));
        Some(row.in_unit("Pa"))
    });
    let means = Claim::default().by(Rule::All, rows.collect());
    let forms: Vec<&Claim> = claims.iter().filter(form).collect();
    let found = in_words(&forms);
    let all: Vec<&Claim> = forms.into_iter().chain([&means]).collect();
    Claim::of("conclusion", "sections 5 and 6", "figure5")
        .says("The mean stress over the realizations is the continuum's, and its distribution is exponential.")
        .found(format!("Means of the same grains {}; {found}", means.word()))
        .decided_by("At O, A and B, of the grains that bear load: form as in the claims named, and mean within a tenth.")
        .with(together(&all), means.rows)
}

pub fn positive_only(members: &[Member]) -> Claim {
    let mut rows = Vec::new();
    for moment in Moment::BOTH {
        for point in POINTS {
            let values = stress(members, moment, point, "grain_zz");
            let name = |what: &str| format!("{point}, {}: share {what}", moment.words());
            let negative = values.iter().filter(|value| **value < 0.0).count();
            let negative = sample::share(negative, values.len());
            // None of n has an upper end of about 2.7/n: 300 packings can show that one in a hundred is not reached.
            rows.push(Row::judged(name("below zero"), [0.0, 0.01], negative).against(0.0));
            let parted = Parted::of(&values);
            let name = name("of grains that bear nothing");
            rows.push(Row::shown(name, sample::zeros(&parted)).against(0.0));
        }
    }
    let rattlers = sample::measured(members, "settled.coordination.rattlers");
    let what = "share of all grains of a settled bed that rattle";
    rows.push(Row::shown(what, sample::mean(&rattlers)));
    let every_second = |from: usize| rows.iter().skip(from).step_by(2).take(6).map(Row::estimate);
    let most = |from: usize| every_second(from).fold(0.0, f64::max);
    Claim::of("positive", "section 3.3", "figure5")
        .says("Particles may take any positive value of the extensive stress; negative ones are impossible.")
        .found(format!(
            "At most {:.1} % at any point are negative; {:.1} % to {:.1} % of the grains at the points carry nothing at all, which a \
             continuous law has no place for.",
            100.0 * most(0),
            100.0 * every_second(1).fold(f64::INFINITY, f64::min),
            100.0 * most(1),
        ))
        .decided_by("At most one in a hundred below zero at each point.")
        .by(Rule::All, rows)
}

/// √(2/π).
const PEAKEDNESS_OF_NORMAL: f64 = 0.797_884_560_802_865_4;

/// Mean absolute deviation from the median over standard deviation: 1/√2 for Laplace, √(2/π) for a normal law.
fn peakedness(values: &[f64]) -> f64 {
    let centre = median(values).unwrap_or(f64::NAN);
    let off: f64 = values.iter().map(|value| (value - centre).abs()).sum();
    off / values.len() as f64 / standard_deviation(values)
}

/// The numbers of shear components at a point, of which the first decides, and its reading.
fn rows_of_shear(name: &str, values: &[f64], unit: &'static str) -> (Vec<Row>, String) {
    let half_way = 0.5 * (PEAKEDNESS_OF_NORMAL - FRAC_1_SQRT_2);
    let parted = Parted::of(values);
    let values = &parted.others;
    let label = |what: &str| format!("{name}: {what}");
    let what = label("mean absolute over standard deviation of grains that bear load");
    let limits = [FRAC_1_SQRT_2 - half_way, FRAC_1_SQRT_2 + half_way];
    let number = Number::new(values.len(), |level| {
        bootstrap::of_values(values, level, peakedness)
    });
    let mut row = Row::judged(what, limits, number).against(FRAC_1_SQRT_2);
    let mut found = String::new();
    if let Some(fit) = goodness::fitted(Family::Laplace, values, SAMPLES) {
        let test = "Laplace with fitted location and scale (D, drawn samples)";
        row = row.with_fit(test, &fit);
        if let Distribution::Laplace { scale, .. } = fit.law {
            found = format!("{name} {:.3} (scale {scale:.3} {unit})", row.estimate());
        }
    }
    let nothing = label("share of grains that bear nothing");
    let rows = vec![
        row,
        Row::shown(label("mean of them"), sample::mean(values)).in_unit(unit),
        Row::shown(nothing, sample::zeros(&parted)),
    ];
    (rows, found)
}

const DECIDED_BY_PEAKEDNESS: &str = "Mean absolute over standard deviation, 0.707 for Laplace and 0.798 for a normal law, \
    nearer to Laplace's than half the way to the normal law's, at every point.";

/// Laplace for the shear component, from the same theory.
pub fn laplace(members: &[Member]) -> Claim {
    let of_point = |point| {
        let values = stress(members, Moment::Loaded, point, "grain_xz");
        rows_of_shear(point, &values, "Pa")
    };
    let (rows, found): (Vec<Vec<Row>>, Vec<String>) = POINTS.into_iter().map(of_point).unzip();
    Claim::of("laplace", "section 3.3 and the same theory elsewhere", "shear")
        .says("Shear components can be positive or negative and do not follow an exponential; the theory gives them a \
                    Laplace law.")
        .found(format!(
            "Mean absolute over standard deviation of grains that bear load, {FRAC_1_SQRT_2:.3} for Laplace and \
             {PEAKEDNESS_OF_NORMAL:.3} for a normal law: {}.",
            found.join(", ")
        ))
        .decided_by(format!(
            "{DECIDED_BY_PEAKEDNESS} Components are taken along x and z, the theory's along the principal axes of the mean stress, \
             which differ from them at A and B."
        ))
        .by(Rule::All, rows.concat())
}

/// The earlier paper, by its summary: I. G. Tejada, "Boussinesq-like problems in discrete media". Its laws are said to hold along
/// the principal directions.
const SOURCE: &str = "arXiv:1812.08424, summary";

/// Extensive stress of the nearest grain in every packing, J/m, along the principal directions of its mean over the packings: the
/// one nearer to the vertical and the one across it; and its shear.
fn principal(members: &[Member], point: &str) -> [Vec<f64>; 3] {
    let nearest = sample::nearest(members, Moment::Loaded, point, 1);
    let parts = nearest
        .iter()
        .map(|cells| [cells[0].xx, cells[0].zz, cells[0].xz]);
    let parts: Vec<[f64; 3]> = parts.collect();
    let middle = |part: usize| {
        mean(
            &parts
                .iter()
                .map(|stress| stress[part])
                .collect::<Vec<f64>>(),
        )
    };
    // From z towards x, at most an eighth of a turn while σ_zz is the larger one.
    let turn = 0.5 * (2.0 * middle(2)).atan2(middle(1) - middle(0));
    let (sin, cos) = turn.sin_cos();
    let along =
        |[xx, zz, xz]: &[f64; 3], [x, z]: [f64; 2]| x * x * xx + z * z * zz + 2.0 * x * z * xz;
    let across = |[xx, zz, xz]: &[f64; 3]| sin * cos * (xx - zz) + (cos * cos - sin * sin) * xz;
    [
        parts
            .iter()
            .map(|stress| along(stress, [sin, cos]))
            .collect(),
        parts
            .iter()
            .map(|stress| along(stress, [cos, -sin]))
            .collect(),
        parts.iter().map(across).collect(),
    ]
}

pub fn of_earlier_paper(members: &[Member], others: &[Claim]) -> Vec<Claim> {
    let (mut normal, mut shear, mut shapes, mut peaks) = (vec![], vec![], vec![], vec![]);
    for point in POINTS {
        let [upright, level, of_shear] = principal(members, point);
        for (name, values) in [("nearer to the vertical", upright), ("across it", level)] {
            let name = format!("{point}, {name}");
            let rows = rows_of(&name, &values);
            shapes.push(format!("{name} {:.2}", rows[1].estimate()));
            normal.extend(rows);
        }
        let (mut rows, found) = rows_of_shear(point, &of_shear, "J/m");
        let loaded = Parted::of(&of_shear).others;
        if let Some(between) = not_nested(Family::Laplace, Family::Normal, &loaded) {
            let test = "Laplace and normal equally far from the truth (Vuong's z; positive: Laplace nearer)";
            rows[0] = rows[0].clone().with(test, between.z, between.p);
        }
        peaks.push(found);
        shear.extend(rows);
    }
    let means = others.iter().filter(|claim| {
        POINTS
            .iter()
            .any(|point| claim.id == format!("mean.{point}"))
    });
    let means: Vec<&Claim> = means.collect();
    let shapes = shapes.join("; ");
    vec![
        Claim::of("earlier.normal", SOURCE, "figure5")
            .says("In principal directions the normal components of a grain's extensive stress are exponential.")
            .found(format!("Gamma shapes of grains that bear load, instead of 1: {shapes}."))
            .decided_by(format!("In both directions at every point: {DECIDED_BY}"))
            .by(Rule::All, normal),
        Claim::of("earlier.shear", SOURCE, "shear")
            .says("The shear component has a Laplace law.")
            .found(format!("{}.", peaks.join(", ")))
            .decided_by(DECIDED_BY_PEAKEDNESS)
            .by(Rule::All, shear),
        Claim::of("earlier.scale", SOURCE, "figure5")
            .says("The scales of these laws follow from the continuum's solution.")
            .found(in_words(&means))
            .decided_by("Holds where the mean vertical stress does at O, A and B.")
            .with(together(&means), Vec::new()),
    ]
}
