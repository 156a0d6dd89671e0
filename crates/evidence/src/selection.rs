//! Many intervals at once, each of which decides something or nothing.

/// The level of all intervals at which the expected share of wrong decisions among those made is at most `error`: with `count`
/// intervals of which `decided(level)` decide, 1 − error·R/count for the largest R that decide at that level (Benjamini and Hochberg
/// 1995 for tests, Benjamini and Yekutieli 2005 for intervals of what was selected; for statements that are independent or depend
/// positively on each other). Where none decides it is 1 − error/count.
pub fn level(count: usize, error: f64, decided: impl Fn(f64) -> usize) -> f64 {
    let at = |some: usize| 1.0 - error * some as f64 / count.max(1) as f64;
    let mut some = count.max(1);
    loop {
        let fewer = decided(at(some)).max(1);
        if fewer >= some {
            return at(some);
        }
        some = fewer;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moments::mean;
    use crate::random::{Key, replicates};
    use statrs::distribution::{ContinuousCDF, Normal};

    /// Of 400 means 360 lie exactly at a limit, so that every decision about them is wrong, and 40 lie four errors beyond it.
    /// At 95 % a third of the decisions are wrong, at the corrected level one in twenty at most, and most of the 40 are found.
    #[test]
    fn few_of_the_decisions_are_wrong() {
        const KEY: Key = *b"crossgrain: tests of selections.";
        let decides =
            |off: f64, level: f64| off.abs() > Normal::standard().inverse_cdf(0.5 + 0.5 * level);
        let found = replicates(&KEY, 400, |source| {
            let off: Vec<f64> = (0..400)
                .map(|k| source.normal() + if k < 40 { 4.0 } else { 0.0 })
                .collect();
            let made = |level: f64, from: usize, to: usize| {
                let some = off[from..to].iter().filter(|off| decides(**off, level));
                some.count()
            };
            let share =
                |level: f64| made(level, 40, 400) as f64 / made(level, 0, 400).max(1) as f64;
            let level = level(400, 0.05, |level| made(level, 0, 400));
            [share(level), share(0.95), made(level, 0, 40) as f64 / 40.0]
        });
        let of = |which: usize| mean(&found.iter().map(|one| one[which]).collect::<Vec<f64>>());
        assert!(of(0) > 0.03 && of(0) < 0.05, "{}", of(0));
        assert!(of(1) > 0.25 && of(2) > 0.8, "{} {}", of(1), of(2));
    }

    #[test]
    fn all_none_and_nothing() {
        assert_eq!(level(10, 0.05, |_| 10), 0.95);
        assert_eq!(level(10, 0.05, |_| 0), 0.995);
        assert_eq!(level(0, 0.05, |_| 0), 0.95);
    }
}
