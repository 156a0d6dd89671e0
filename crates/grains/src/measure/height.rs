//! The height of the bed: three definitions, because the paper gives none.

use crate::scene::{Scene, SurfaceHeight};
use crate::tables::Bodies;

/// The height that the scene counts depths from, m.
pub fn surface(scene: &Scene, bodies: &Bodies) -> f64 {
    match scene.measurement.surface_height {
        SurfaceHeight::HighestGrain => highest_grain(bodies),
        SurfaceHeight::MeanSurface => mean_surface(scene, bodies),
        SurfaceHeight::TwiceCentreOfMass => twice_centre_of_mass(bodies),
    }
}

/// H = max(z + R), m.
pub fn highest_grain(bodies: &Bodies) -> f64 {
    bodies
        .z
        .iter()
        .zip(&bodies.radius)
        .map(|(z, radius)| z + radius)
        .fold(0.0, f64::max)
}

/// H = mean over ⌊L/D⌋ equal columns of the highest point of any grain in the column, m; 0 where a column
/// is empty. A grain reaches z + √(R² − s²) where s is how far the column passes its centre by.
pub fn mean_surface(scene: &Scene, bodies: &Bodies) -> f64 {
    let width = scene.container.width;
    let columns = ((width / scene.particles.mean_diameter) as usize).max(1);
    let pitch = width / columns as f64;
    let mut tops = vec![0.0f64; columns];
    for ((x, z), radius) in bodies.x.iter().zip(&bodies.z).zip(&bodies.radius) {
        let first = ((x - radius) / pitch).max(0.0) as usize;
        let last = (((x + radius) / pitch) as usize).min(columns - 1);
        for (column, top) in tops.iter_mut().enumerate().take(last + 1).skip(first) {
            let low = column as f64 * pitch;
            let past = (low - x).max(x - (low + pitch)).max(0.0);
            if past <= *radius {
                *top = top.max(z + (radius * radius - past * past).sqrt());
            }
        }
    }
    tops.iter().sum::<f64>() / columns as f64
}

/// H = 2 Σmz/Σm, m: the height of a column of even density with this centre of mass.
pub fn twice_centre_of_mass(bodies: &Bodies) -> f64 {
    let moment: f64 = bodies.z.iter().zip(&bodies.mass).map(|(z, m)| z * m).sum();
    let mass: f64 = bodies.mass.iter().sum();
    2.0 * moment / mass
}
