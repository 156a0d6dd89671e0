//! From values to places on a drawing, round values for ticks, and numbers for print.

use crate::paper::short;

/// A rectangle of a drawing: left, top, width, height.
pub type Area = [f64; 4];

/// From values to places along one side of an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Value at `from`.
    pub low: f64,
    /// Value at `to`.
    pub high: f64,
    /// Place of `low`.
    pub from: f64,
    /// Place of `high`.
    pub to: f64,
    /// Powers of ten are evenly apart.
    pub logarithmic: bool,
}

impl Axis {
    /// Along the floor of an area.
    pub fn across([left, _, width, _]: Area, low: f64, high: f64) -> Self {
        Axis {
            low,
            high,
            from: left,
            to: left + width,
            logarithmic: false,
        }
    }

    /// Upwards along the left side of an area.
    pub fn upwards([_, top, _, height]: Area, low: f64, high: f64) -> Self {
        Axis {
            low,
            high,
            from: top + height,
            to: top,
            logarithmic: false,
        }
    }

    /// The same axis with powers of ten evenly apart.
    pub fn logarithmic(self) -> Self {
        Axis {
            logarithmic: true,
            ..self
        }
    }

    /// Where a value is. What lies a little beyond an end is placed there, to be cut off by whoever draws; farther
    /// values stop half a length beyond: numbers without bound do not draw.
    pub fn place(&self, value: f64) -> f64 {
        self.at_share(self.share(value).clamp(-0.5, 1.5))
    }

    fn share(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    fn at_share(&self, share: f64) -> f64 {
        self.from + share * (self.to - self.from)
    }

    /// A value at a share of the axis' length.
    pub fn value(&self, share: f64) -> f64 {
        if self.logarithmic {
            self.low * (self.high / self.low).powf(share)
        } else {
            self.low + share * (self.high - self.low)
        }
    }

    /// About `most` round values: multiples of 1, 2 or 5 times a power of ten; on a logarithmic axis 1, 2 and 5 times
    /// powers of ten if they have room, else the powers. None on an axis that runs backwards or has no ends.
    pub fn ticks(&self, most: f64) -> Vec<f64> {
        let has_ends = (self.high - self.low).is_finite();
        if !has_ends || self.logarithmic && self.low.min(self.high) <= 0.0 {
            return Vec::new();
        }
        if self.logarithmic {
            let steps: &[f64] = if 3.0 * (self.high / self.low).log10() <= most + 1.0 {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let powers = (self.low.log10().floor() as i32)..=(self.high.log10().ceil() as i32);
            return powers
                .flat_map(|power| steps.iter().map(move |of| of * 10f64.powi(power)))
                .filter(|tick| *tick >= 0.999_999 * self.low && *tick <= 1.000_001 * self.high)
                .collect();
        }
        let step = round_step((self.high - self.low) / most);
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last).map(|index| step * index as f64).collect()
    }
}

/// 1, 2 or 5 times a power of ten, at least `least`; 1 if that is not above zero.
pub fn round_step(least: f64) -> f64 {
    if !(least > 0.0 && least.is_finite()) {
        return 1.0;
    }
    let power = 10f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= least);
    factor.unwrap_or(10.0) * power
}

/// A number with a minus sign for print.
pub fn printed(value: f64) -> String {
    if value == 0.0 {
        // Of −0 too.
        return "0".to_owned();
    }
    let text = short(value);
    // A power of ten without the zeros before it: 2e−5.
    let text = match text.split_once('e') {
        Some((digits, power)) if digits.contains('.') => {
            let digits = digits.trim_end_matches('0').trim_end_matches('.');
            format!("{digits}e{power}")
        }
        _ => text,
    };
    text.replace('-', "−")
}

/// The same with so many significant digits.
pub fn rounded(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return printed(value);
    }
    let unit = 10f64.powi(value.abs().log10().floor() as i32 + 1 - digits);
    printed((value / unit).round() * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let axis = Axis::across([0.0, 0.0, 100.0, 10.0], -0.3, 1.0);
        assert_eq!(
            axis.ticks(7.0),
            [-0.2, 0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]
        );
        let powers = Axis::upwards([0.0, 0.0, 10.0, 90.0], 1e-3, 1.0).logarithmic();
        assert_eq!(powers.ticks(3.0), [1e-3, 1e-2, 1e-1, 1.0]);
        assert_eq!(powers.ticks(9.0).len(), 10);
        let area = [0.0, 0.0, 10.0, 90.0];
        for [low, high] in [[7.0, 0.0], [0.0, f64::INFINITY], [f64::NAN, 1.0]] {
            let axis = Axis::upwards(area, low, high);
            assert!(axis.ticks(3.0).is_empty(), "{low} to {high}");
            assert!(axis.logarithmic().ticks(3.0).is_empty(), "{low} to {high}");
        }
    }

    #[test]
    fn places_are_even_and_go_on_a_little_beyond_the_ends() {
        let axis = Axis::across([0.0, 0.0, 100.0, 10.0], -0.3, 1.0);
        assert_eq!(axis.place(7.0), 150.0);
        assert!((axis.place(1.13) - 110.0).abs() < 1e-9);
        let powers = Axis::upwards([0.0, 0.0, 10.0, 90.0], 1e-3, 1.0).logarithmic();
        assert!((powers.place(1e-1) - 30.0).abs() < 1e-9);
        assert!((powers.value(2.0 / 3.0) - 1e-1).abs() < 1e-12);
        assert_eq!(powers.place(0.0), 135.0);
    }

    #[test]
    fn steps_are_round() {
        assert_eq!(round_step(0.085), 0.1);
        assert_eq!(round_step(1.3), 2.0);
        assert_eq!(round_step(400.0), 500.0);
        assert_eq!(round_step(0.0), 1.0);
    }

    #[test]
    fn numbers_have_no_noise_and_a_minus_sign() {
        assert_eq!(printed(3.0 * 0.2), "0.6");
        assert_eq!(printed(-0.5), "−0.5");
        assert_eq!(printed(2.0e-5), "2e−5");
        assert_eq!(rounded(0.072_58, 3), "0.0726");
        assert_eq!(rounded(-0.0, 3), "0");
    }
}
