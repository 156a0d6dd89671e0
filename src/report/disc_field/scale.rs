//! The bands of colour of the map, and their bar.

use super::{LINE, compression, nodes, panel, tick};
use crate::paper::disc_field::DiscField;
use crate::report::axis::{Area, round_step, rounded};
use crate::report::frame::text;
use crate::report::shades::viridis;

/// Left edge, top, width and height of the colour bar.
const BAR: Area = [545.0, 84.0, 22.0, 230.0];
/// About as many bands of colour.
const BANDS: f64 = 20.0;

/// Beyond this many distances between the quartiles lie outliers, after Tukey.
const FENCE: f64 = 1.5;

/// The bands of colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// The lowest level, in steps.
    pub first: f64,
    /// From one level to the next, Pa.
    pub step: f64,
    /// How many.
    pub bands: u32,
    /// Whether the field goes below and above the scale.
    pub beyond: [bool; 2],
}

impl Scale {
    /// From the least to the largest value, but not to outliers: near a force there is no largest.
    pub fn of(field: &DiscField) -> Self {
        let mut values: Vec<f64> = nodes()
            .flat_map(|x| nodes().map(move |z| [x, z]))
            .filter(|[x, z]| x.hypot(*z) < 1.0)
            .map(|point| compression(field, point))
            .chain(
                panel::AXES
                    .into_iter()
                    .flat_map(|axis| panel::profile(field, axis))
                    .map(|[_, value]| value),
            )
            .filter(|value| value.is_finite())
            .collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
        let (low, quarter, three_quarters, high) = (at(0.0), at(0.25), at(0.75), at(1.0));
        let fence = FENCE * (three_quarters - quarter);
        let inner = [low.max(quarter - fence), high.min(three_quarters + fence)];
        let step = round_step((inner[1] - inner[0]) / BANDS);
        // Without noise where the least value is the rounding of a zero.
        let first = (inner[0] / step + 1e-6).floor();
        let last = (inner[1] / step - 1e-6).ceil().max(first + 1.0);
        let beyond = [low < step * (first - 1e-6), high > step * (last + 1e-6)];
        Scale {
            first,
            step,
            bands: (last - first) as u32,
            beyond,
        }
    }

    /// Lower end of a band, Pa.
    pub fn level(&self, band: u32) -> f64 {
        self.step * (self.first + f64::from(band))
    }

    /// Lower end of the scale, Pa.
    pub fn low(&self) -> f64 {
        self.level(0)
    }

    /// Upper end of the scale, Pa.
    pub fn high(&self) -> f64 {
        self.level(self.bands)
    }

    /// Whether zero parts tension from compression.
    pub fn has_tension(&self) -> bool {
        self.first < 0.0 && self.high() > 0.0
    }

    /// In [0, 1] within the scale.
    pub fn share(&self, value: f64) -> f64 {
        (value - self.low()) / (self.high() - self.low())
    }

    /// Of a band.
    pub fn colour(&self, band: u32) -> String {
        viridis((f64::from(band) + 0.5) / f64::from(self.bands))
    }

    /// Bands with a label: all, or so many that the labels have room on `length`.
    pub fn labelled(&self, length: f64) -> impl Iterator<Item = (u32, String)> + '_ {
        let every = (LINE * f64::from(self.bands) / length).ceil().max(1.0) as u32;
        // Zero is labelled.
        let offset = self.first.rem_euclid(f64::from(every)) as u32;
        (0..=self.bands)
            .filter(move |band| (band + offset).is_multiple_of(every))
            .map(|band| (band, rounded(self.level(band), 6)))
    }
}

/// The bands from the lowest to the highest with labels, and what stands for values beyond the scale.
pub fn colour_bar(scale: &Scale) -> String {
    let [left, top, width, height] = BAR;
    let step = height / f64::from(scale.bands);
    let y = |band: u32| top + height - step * f64::from(band);
    let mut svg = text([left, top - 46.0], "start", "σ_zz, Pa");
    for band in 0..scale.bands {
        svg += &bar_part(y(band + 1), step, &scale.colour(band));
    }
    for (band, label) in scale.labelled(height) {
        svg += &tick([left + width, y(band)], [5.0, 0.0]);
        svg += &text([left + width + 9.0, y(band) + 4.5], "start", &label);
    }
    let last = scale.bands - 1;
    let ends = [
        (top + height + 10.0, 0, "below", "less: clipped"),
        (top - 26.0, last, "above", "more: clipped"),
    ];
    for ((y, band, name, label), beyond) in ends.into_iter().zip(scale.beyond) {
        if beyond {
            svg += &bar_part(y, 16.0, &scale.colour(band));
            svg += &bar_part(y, 16.0, &format!("url(#disc-field-{name})"));
            svg += &text([left + width + 9.0, y + 12.5], "start", label);
        }
    }
    svg
}

fn bar_part(y: f64, height: f64, fill: &str) -> String {
    let [left, _, width, _] = BAR;
    format!(
        "<rect x=\"{left}\" y=\"{y:.1}\" width=\"{width}\" height=\"{height:.1}\" fill=\"{fill}\"/>\n"
    )
}
