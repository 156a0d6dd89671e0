//! The paper's figures, redrawn from our own numbers: each a drawing and the numbers that are drawn.

pub mod bulbs;
pub mod chains;
pub mod sharings;

use super::distribution::{COLUMNS, Distribution, round_bins, side_by_side};
use super::figure::Figure;
use super::figure_files::table;
use crate::error::Error;
use crate::paper::disc_field::DiscField;
use crate::study::figures::Sample;

/// Figure 4's content: the stress inside a disc.
pub fn inside_a_grain(field: &DiscField) -> Result<Figure, Error> {
    Ok(Figure {
        name: "figure-4".to_owned(),
        caption: "The stress inside a grain and its averages".to_owned(),
        svg: super::disc_field::picture(field),
        csv: table(
            &["kind", "x (m)", "z (m)", "stress zz (Pa)"],
            super::disc_field::numbers(field),
        )?,
    })
}

/// Figure 5's content: the extensive stress at the control points against the theory's exponential.
pub fn distributions(samples: &[Sample]) -> Result<Figure, Error> {
    if samples.is_empty() {
        return Err(Error::Report(
            "the campaign's scene has no control points, so Figure 5 cannot be drawn".to_owned(),
        ));
    }
    let mut panels = Vec::new();
    for sample in samples {
        let bins = round_bins(&sample.values, 2.5 * sample.theory_mean).ok_or_else(|| {
            let point = &sample.point;
            Error::Report(format!(
                "a value at {point} is not finite, so Figure 5 cannot be drawn"
            ))
        })?;
        let of = Distribution {
            title: &sample.point,
            quantity: "Σ_zz",
            unit: "J",
            values: &sample.values,
            bins,
            theory_mean: Some(sample.theory_mean),
            fitted: sample.gamma.as_slice(),
        };
        panels.push(of.panel()?);
    }
    let rows = panels.iter().flat_map(|panel| &panel.rows);
    Ok(Figure {
        name: "figure-5".to_owned(),
        caption: "The vertical extensive stress at the control points against the exponential law"
            .to_owned(),
        svg: side_by_side(&panels, "Distributions of the vertical extensive stress"),
        csv: table(&COLUMNS, rows)?,
    })
}
