//! Section 4.2: height and porosity are tied by the area of the grains.

use std::f64::consts::PI;

use super::Number;
use crate::paper::quadrature::integrate;

/// Mean area πR² of a grain, m²: R uniform in 0.005·(1 ± 0.05), integrated over the sizes.
pub fn mean_solid_area() -> f64 {
    let (radius, dispersion) = (0.005, 0.05);
    integrate(-dispersion, dispersion, 50, |share| {
        PI * (radius * (1.0 + share)).powi(2) / (2.0 * dispersion)
    })
}

/// The numbers of section 4.2 that are tied to each other.
pub fn numbers() -> Vec<Number> {
    let solid = 5000.0 * mean_solid_area();
    let how = "area of 5,000 discs over a box 1 m wide";
    let porosity_at = |height: f64| 1.0 - solid / height;
    vec![
        Number::new(
            "section 4.2",
            "porosity n at the published height H = 0.46 m",
            0.17,
            0.01,
            porosity_at(0.46),
            "1",
            how,
        )
        .remark(
            "the published mean height and mean porosity do not belong together for R = 0.005 m; \
             0.01 is the published scatter",
        ),
        Number::new(
            "section 4.2",
            "porosity n at the upper end, H = 0.47 m",
            0.17,
            0.01,
            porosity_at(0.47),
            "1",
            how,
        )
        .derived("only beds near the upper end of H meet both, at the lower end of n"),
        Number::new(
            "section 4.2",
            "height H at the published porosity n = 0.17",
            0.46,
            0.01,
            solid / (1.0 - 0.17),
            "m",
            how,
        )
        .remark("0.01 is the published scatter"),
    ]
}
