//! Independence of neighbouring cells, which 1/√N rests on.

use super::claim::{Claim, Row, Rule, verdict};
use super::means::POINTS;
use super::sample::{Moment, nearest};
use crate::study::campaign::member::Member;
use evidence::correlation::spearman;
use evidence::{Interval, bootstrap, paired};

/// Correlations between neighbours may be this large: eight cells with it would vary by a third more than 1/√8.
const TOLERANCE: f64 = 0.1;
/// Packings exchanged for a p-value.
const PERMUTATIONS: usize = 999;
/// Nearest cells whose correlations are averaged.
const TOGETHER: usize = 8;

/// Neighbouring cells do not know of each other.
pub fn independence(members: &[Member]) -> Claim {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for moment in Moment::BOTH {
        for point in POINTS {
            let around = nearest(members, moment, point, TOGETHER);
            let of =
                |index: usize| -> Vec<f64> { around.iter().map(|cells| cells[index].zz).collect() };
            let (first, second) = (of(0), of(1));
            let name = format!("{point}, {}", moment.words());
            let mut row = Row::judged(
                format!("{name}: correlation of the two nearest cells"),
                "1",
                around.len(),
                [-TOLERANCE, TOLERANCE],
                |level| pair(&first, &second, level),
            )
            .against(0.0);
            if let Some(ranks) = spearman(&first, &second, PERMUTATIONS) {
                row = row.with(
                    "independent (Spearman's correlation, permuted)",
                    ranks.value.estimate,
                    ranks.p,
                );
            }
            rows.push(row);
            let columns: Vec<Vec<f64>> = (0..TOGETHER).map(of).collect();
            let mean = Row::shown(
                format!("{name}: mean correlation of the eight nearest"),
                "1",
                around.len(),
                |level| {
                    bootstrap::interval(around.len(), level, |packings| {
                        mean_of_pairs(&columns, packings)
                    })
                },
            )
            .against(0.0);
            found.push(format!(
                "{name} {:+.2}",
                rows.last().map_or(f64::NAN, Row::estimate)
            ));
            rows.push(mean);
        }
    }
    Claim {
        id: "independence".into(),
        place: "section 5, which sums independent cells".into(),
        statement: "The stresses of neighbouring cells are independent.".to_owned(),
        verdict: verdict(&rows, Rule::All),
        reading: format!(
            "Correlations of the two nearest cells' Σ_zz over packings: {}.",
            found.join(", ")
        ),
        decided_by: format!(
            "Pearson's correlation over packings of the two cells nearest to each point within ± {TOLERANCE}; eight cells with \
             more would vary by a third more, or fewer, than independent ones."
        ),
        rows,
        figure: "correlations".into(),
    }
}

fn pair(first: &[f64], second: &[f64], level: f64) -> Option<Interval> {
    bootstrap::interval(first.len(), level, |packings| {
        let of = |values: &[f64]| -> Vec<f64> { packings.iter().map(|one| values[*one]).collect() };
        paired::correlation(&of(first), &of(second)).unwrap_or(f64::NAN)
    })
}

/// Mean of the correlations of all pairs, over these packings: from the variance of the sum of the standardized columns.
fn mean_of_pairs(columns: &[Vec<f64>], packings: &[usize]) -> f64 {
    let count = columns.len() as f64;
    let mut sums = vec![0.0; packings.len()];
    for column in columns {
        let values: Vec<f64> = packings.iter().map(|one| column[*one]).collect();
        let centre = evidence::moments::mean(&values);
        let spread = evidence::moments::deviation(&values);
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += (value - centre) / spread;
        }
    }
    let variance = evidence::moments::deviation(&sums).powi(2);
    (variance - count) / (count * (count - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_columns_correlate_fully_and_opposite_ones_cancel() {
        let column = vec![1.0, 2.0, 5.0, 3.0];
        let opposite: Vec<f64> = column.iter().map(|value| -value).collect();
        let all = [0, 1, 2, 3];
        let close = |columns: &[Vec<f64>], wanted: f64| {
            assert!((mean_of_pairs(columns, &all) - wanted).abs() < 1.0e-12);
        };
        close(&[column.clone(), column.clone(), column.clone()], 1.0);
        close(&[column, opposite], -1.0);
    }
}
