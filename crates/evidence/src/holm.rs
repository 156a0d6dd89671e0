//! Several tests at once.

/// Holm's adjusted p-values (1979), in the order given: with those at most 0.05 rejected, the probability
/// that any true statement is rejected stays at most 0.05. p that are not numbers stay so and do not count.
pub fn adjusted(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len())
        .filter(|index| !p_values[*index].is_nan())
        .collect();
    order.sort_by(|a, b| p_values[*a].total_cmp(&p_values[*b]));
    let mut adjusted = p_values.to_vec();
    let mut largest = 0.0f64;
    for (place, index) in order.iter().enumerate() {
        let times = (order.len() - place) as f64;
        largest = largest.max((times * p_values[*index]).min(1.0));
        adjusted[*index] = largest;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assert_share;
    use crate::random::{Key, Source};

    /// statsmodels 0.15, `multipletests(method="holm")`.
    #[test]
    fn known_values() {
        for (given, wanted) in [
            (vec![0.01, 0.04, 0.03, 0.005], vec![0.03, 0.06, 0.06, 0.02]),
            (
                vec![0.002, 0.5, 0.011, 0.02, 0.9],
                vec![0.01, 1.0, 0.044, 0.06, 1.0],
            ),
        ] {
            for (found, wanted) in adjusted(&given).into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1.0e-12);
            }
        }
        let found = adjusted(&[0.03, f64::NAN]);
        assert!(found[0] == 0.03 && found[1].is_nan());
        assert!(adjusted(&[]).is_empty());
    }

    /// Ten true statements: any is rejected in 1 − 0.995¹⁰ = 4.9 % of the cases, not in 40 %.
    #[test]
    fn one_in_twenty_sets() {
        const KEY: Key = *b"crossgrain: tests of many tests ";
        let mut source = Source::new(&KEY, 0);
        let rejected = (0..10_000).map(|_| {
            let given: Vec<f64> = (0..10).map(|_| source.uniform()).collect();
            adjusted(&given).iter().any(|p| *p <= 0.05)
        });
        assert_share(rejected, 0.99, 0.0489);
    }
}
