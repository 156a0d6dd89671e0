//! Median and spread of repeated measurements.

use serde::Serialize;

/// Of measurements in one unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// Every measurement, in the order of the rounds.
    pub all: Vec<f64>,
    /// Half of them are below it.
    pub median: f64,
    /// A quarter of them is below it.
    pub low_quartile: f64,
    /// A quarter of them is above it.
    pub high_quartile: f64,
    /// The least.
    pub least: f64,
    /// The most.
    pub most: f64,
}

impl Spread {
    /// Of these; none if there are none.
    pub fn of(all: Vec<f64>) -> Option<Self> {
        let mut sorted = all.clone();
        sorted.sort_by(f64::total_cmp);
        Some(Spread {
            median: quantile(&sorted, 0.5)?,
            low_quartile: quantile(&sorted, 0.25)?,
            high_quartile: quantile(&sorted, 0.75)?,
            least: *sorted.first()?,
            most: *sorted.last()?,
            all,
        })
    }

    /// `a` over `b`, round by round.
    pub fn ratio(a: &Spread, b: &Spread) -> Option<Self> {
        Spread::of(a.all.iter().zip(&b.all).map(|(a, b)| a / b).collect())
    }
}

/// Linear between the measurements, as R's type 7.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let below = sorted[place as usize];
    let above = sorted[(place.ceil()) as usize];
    Some(below + (place - place.floor()) * (above - below))
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn quartiles_lie_between_the_measurements() {
        let spread = Spread::of(vec![4.0, 1.0, 3.0, 2.0]).expect("there are some");
        assert_eq!(
            (spread.low_quartile, spread.median, spread.high_quartile),
            (1.75, 2.5, 3.25)
        );
        assert_eq!((spread.least, spread.most), (1.0, 4.0));
        let one = Spread::of(vec![7.0]).expect("there is one");
        assert_eq!((one.low_quartile, one.high_quartile), (7.0, 7.0));
        assert_eq!(Spread::of(Vec::new()), None);
    }

    #[test]
    fn ratios_are_taken_round_by_round() {
        let spread = |all: &[f64]| Spread::of(all.to_vec()).expect("there are some");
        let ratio = Spread::ratio(&spread(&[2.0, 40.0]), &spread(&[1.0, 10.0])).expect("two");
        assert_eq!(ratio.all, [2.0, 4.0]);
    }
}
