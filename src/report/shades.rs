//! Colours of a scale whose lightness rises evenly, so that the order is seen without telling hues apart.

/// Anchors from low to high: viridis.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];
/// From white to the blue of the charts, under lines and words.
const BLUES: [[f64; 3]; 3] = [
    [255.0, 255.0, 255.0],
    [172.0, 208.0, 231.0],
    [66.0, 150.0, 199.0],
];

/// Viridis at a share of the scale in [0, 1].
pub fn viridis(share: f64) -> String {
    at(&VIRIDIS, share)
}

/// A light blue at a share of the scale in [0, 1].
pub fn shade(share: f64) -> String {
    at(&BLUES, share)
}

fn at(anchors: &[[f64; 3]], share: f64) -> String {
    let place = (anchors.len() - 1) as f64 * share.clamp(0.0, 1.0);
    let index = (place as usize).min(anchors.len() - 2);
    let part = place - index as f64;
    let [red, green, blue] = [0, 1, 2].map(|channel| {
        let (from, to) = (anchors[index][channel], anchors[index + 1][channel]);
        (from + part * (to - from)) as u8
    });
    format!("#{red:02x}{green:02x}{blue:02x}")
}
