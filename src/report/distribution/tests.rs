use super::*;

fn quantiles(count: u32) -> Vec<f64> {
    (0..count)
        .map(|k| -0.34 * (1.0 - (f64::from(k) + 0.5) / f64::from(count)).ln())
        .collect()
}

const FITTED: [Law; 1] = [Law::Gamma {
    shape: 1.1,
    scale: 0.31,
}];

fn of(values: &[f64]) -> Distribution<'_> {
    Distribution {
        title: "O",
        quantity: "Σ_zz",
        unit: "J",
        values,
        bins: round_bins(values, 2.5 * 0.34).unwrap_or(Bins {
            start: 0.0,
            step: 1.0,
            count: 1,
        }),
        theory_mean: Some(0.34),
        fitted: &FITTED,
    }
}

#[test]
fn bins_hold_all_values_but_outliers_and_their_intervals_hold_the_law() {
    let values = quantiles(1000);
    let panel = of(&values).panel().expect("has values");
    let law = Law::Exponential { mean: 0.34 };
    let (mut sum, mut missed, mut bins) = (0.0, 0, 0);
    for row in panel
        .rows
        .iter()
        .filter(|row| row[2] == "histogram density")
    {
        let [from, to, value, low, high] =
            [3, 4, 5, 6, 7].map(|index: usize| row[index].parse::<f64>().expect("a number"));
        let wanted = (law.survival(from) - law.survival(to)) / (to - from);
        missed += u32::from(!(low..=high).contains(&wanted));
        sum += value * (to - from);
        bins += 1;
    }
    assert!(bins >= 10 && missed == 0, "{missed} of {bins}");
    assert!((sum - 0.995).abs() < 0.006, "{sum}");
    assert!(!panel.svg.contains("NaN") && !panel.svg.contains("inf"));
}

#[test]
fn nothing_to_draw_is_an_error() {
    let said = |of: Distribution<'_>| of.panel().expect_err("nothing to draw").to_string();
    assert!(said(of(&[])).contains("no values"));
    assert!(said(of(&[1.0, f64::NAN])).contains("not finite"));
    let values = [1.0, 2.0];
    let no_mean = Distribution {
        theory_mean: Some(0.0),
        ..of(&values)
    };
    assert!(said(no_mean).contains("above zero"));
    let mut no_width = of(&values);
    no_width.bins.step = 0.0;
    assert!(said(no_width).contains("no width"));
}

#[test]
fn values_below_zero_have_bins() {
    let panel = of(&[-0.3, 0.1, 0.2, 0.5]).panel().expect("has values");
    let first = panel.rows.iter().find(|row| row[2] == "histogram density");
    let from: f64 = first.expect("a bin")[3].parse().expect("a number");
    assert!((from + 0.3).abs() < 1e-9, "{from}");
}

/// Values of both signs have no variation and no share of larger values; without a theory nothing is said of one.
#[test]
fn what_a_distribution_has_not_is_left_out() {
    let values = [-0.3, -0.1, 0.1, 0.3];
    let laplace = [Law::Laplace {
        location: 0.0,
        scale: 0.2,
    }];
    let both_signs = Distribution {
        theory_mean: None,
        fitted: &laplace,
        ..of(&values)
    };
    let panel = both_signs.panel().expect("has values");
    assert!(panel.svg.contains("deviation") && !panel.svg.contains("variation"));
    assert!(!panel.svg.contains("theory") && !panel.svg.contains("share of larger"));
    assert!(panel.rows.iter().all(|row| !row[2].contains("share above")));
    assert!(panel.rows.iter().any(|row| row[2] == "laplace density"));

    let with_theory = of(&values).panel().expect("has values");
    assert!(with_theory.svg.contains("theory") && with_theory.svg.contains("share of larger"));
}
