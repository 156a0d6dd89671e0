//! Porosity n, the share of the volume that is not grain: from the height, in a window, from cells.
//!
//! Overlaps are counted twice; at the overlaps of the paper's bed (micrometres) that is far below
//! a part in a thousand. The punch is not looked at: where it reaches into the window, its room counts as void.

use std::f64::consts::PI;

use super::cells::Cells;
use crate::scene::Scene;
use crate::tables::Bodies;

/// n = 1 − ΣπR²/(L·H): every grain, box width L, height H.
pub fn from_height(bodies: &Bodies, width: f64, height: f64) -> f64 {
    1.0 - solid_area(bodies) / (width * height)
}

/// ΣπR², m².
pub fn solid_area(bodies: &Bodies) -> f64 {
    let grains = bodies.radius.iter();
    grains.map(|radius| PI * radius * radius).sum()
}

/// The inside of a bed of spheres: the whole base of its box between two heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// From bottom to top, m.
    pub z: [f64; 2],
    /// Width times depth of the box, m².
    pub base: f64,
}

impl Layer {
    /// Between one mean diameter above the floor and one below twice the height of the centre of mass; none in the plane, and where
    /// nothing is between.
    pub fn interior(scene: &Scene, bodies: &Bodies) -> Option<Self> {
        let inset = scene.particles.mean_diameter;
        let z = [inset, super::twice_centre_of_mass(bodies) - inset];
        let base = scene.container.width * scene.container.depth?;
        (z[1] > z[0]).then_some(Layer { z, base })
    }

    /// m³.
    pub fn volume(&self) -> f64 {
        self.base * (self.z[1] - self.z[0])
    }

    /// The volume of a sphere with its centre at this height that lies in the layer, m³. Up to the height s above the centre it is
    /// π(R²s − s³/3 + 2R³/3).
    pub fn part(&self, centre: f64, radius: f64) -> f64 {
        let [below, above] = self.z.map(|height| {
            let s = (height - centre).clamp(-radius, radius);
            PI * (radius * radius * s - s * s * s / 3.0)
        });
        above - below
    }
}

/// n = 1 − Σ(part of sphere in the layer)/(volume of layer).
pub fn in_layer(bodies: &Bodies, layer: &Layer) -> f64 {
    let grains = bodies.z.iter().zip(&bodies.radius);
    let solid: f64 = grains.map(|(z, radius)| layer.part(*z, *radius)).sum();
    1.0 - solid / layer.volume()
}

/// A rectangle inside the bed, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// From left to right, m.
    pub x: [f64; 2],
    /// From bottom to top, m.
    pub z: [f64; 2],
}

impl Window {
    /// Five mean diameters away from floor, walls and surface.
    pub fn interior(scene: &Scene, surface: f64) -> Self {
        let inset = 5.0 * scene.particles.mean_diameter;
        Window {
            x: [inset, scene.container.width - inset],
            z: [inset, surface - inset],
        }
    }

    /// m², 0 if there is no such rectangle.
    pub fn area(&self) -> f64 {
        (self.x[1] - self.x[0]).max(0.0) * (self.z[1] - self.z[0]).max(0.0)
    }

    fn holds(&self, x: f64, z: f64) -> bool {
        (self.x[0]..=self.x[1]).contains(&x) && (self.z[0]..=self.z[1]).contains(&z)
    }
}

/// n = 1 − Σ(area of grain ∩ window)/(area of window); none for a bed without an interior.
pub fn in_window(bodies: &Bodies, window: &Window) -> Option<f64> {
    let area = window.area();
    if area <= 0.0 {
        return None;
    }
    let solid: f64 = (0..bodies.len())
        .map(|i| disc_in_window(bodies.x[i], bodies.z[i], bodies.radius[i], window))
        .sum();
    Some(1.0 - solid / area)
}

/// n = 1 − ΣπR²/ΣV_p over the grains with centres in the window.
pub fn of_cells(bodies: &Bodies, cells: &Cells, window: &Window) -> Option<f64> {
    let (mut solid, mut total) = (0.0, 0.0);
    for i in 0..bodies.len() {
        if window.holds(bodies.x[i], bodies.z[i]) {
            solid += PI * bodies.radius[i] * bodies.radius[i];
            total += cells.area[i];
        }
    }
    (total > 0.0).then(|| 1.0 - solid / total)
}

/// Area of a disc inside a rectangle, exactly: ∫ max(0, min(z₁, s) − max(z₀, −s)) dx with
/// s(x) = √(R² − x²), each piece between the places where a bound changes having the antiderivative
/// of ½(x·s + R² asin(x/R)) for every s.
fn disc_in_window(x: f64, z: f64, radius: f64, window: &Window) -> f64 {
    let [left, right] = [window.x[0] - x, window.x[1] - x];
    let [low, high] = [window.z[0] - z, window.z[1] - z];
    let (from, to) = (left.max(-radius), right.min(radius));
    if from >= to || low >= radius || high <= -radius {
        return 0.0;
    }
    let half_chord = |at: f64| (radius * radius - at * at).max(0.0).sqrt();
    let mut places = vec![from, to];
    for bound in [low, high] {
        if bound.abs() < radius {
            for place in [-half_chord(bound), half_chord(bound)] {
                if place > from && place < to {
                    places.push(place);
                }
            }
        }
    }
    places.sort_by(f64::total_cmp);
    let under_arc = |at: f64| {
        0.5 * (at * half_chord(at) + radius * radius * (at / radius).clamp(-1.0, 1.0).asin())
    };
    let mut area = 0.0;
    for piece in places.windows(2) {
        let (a, b) = (piece[0], piece[1]);
        let arc = half_chord(0.5 * (a + b));
        let arc_area = under_arc(b) - under_arc(a);
        let top = if high < arc { high * (b - a) } else { arc_area };
        let bottom = if low > -arc { low * (b - a) } else { -arc_area };
        area += (top - bottom).max(0.0);
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(x0: f64, x1: f64, z0: f64, z1: f64) -> Window {
        Window {
            x: [x0, x1],
            z: [z0, z1],
        }
    }

    #[test]
    fn disc_parts_have_their_known_areas() {
        let cases = [
            (window(-5.0, 5.0, -5.0, 5.0), PI),
            (window(0.0, 5.0, -5.0, 5.0), PI / 2.0),
            (window(0.0, 5.0, 0.0, 5.0), PI / 4.0),
            (window(-0.5, 0.5, -0.5, 0.5), 1.0),
            (window(2.0, 5.0, 0.0, 5.0), 0.0),
            // The cap above half the radius: R²(acos(1/2) − √3/4).
            (window(-5.0, 5.0, 0.5, 5.0), PI / 3.0 - 3.0f64.sqrt() / 4.0),
        ];
        for (window, area) in cases {
            let found = disc_in_window(0.0, 0.0, 1.0, &window);
            assert!((found - area).abs() < 1e-14, "{window:?}: {found} {area}");
        }
    }

    #[test]
    fn parts_of_a_tiling_sum_to_the_whole() {
        let mut sum = 0.0;
        for column in -3..3 {
            for row in -3..3 {
                let (x, z) = (f64::from(column) * 0.4, f64::from(row) * 0.4);
                sum += disc_in_window(0.03, -0.05, 1.0, &window(x, x + 0.4, z, z + 0.4));
            }
        }
        assert!((sum - PI).abs() < 1e-13, "{sum}");
    }
}
