//! The forces on the rim as arrows.

use super::on_map;
use crate::paper::disc_field::{DiscField, PointForce};
use crate::report::axis::rounded;
use crate::report::frame::text;

/// Length of the arrow of the strongest force.
const ARROW: f64 = 46.0;

/// The forces on the rim, from outside, as long as they are strong, with their sizes.
pub fn arrows(field: &DiscField) -> String {
    let size = |force: &PointForce| force.force[0].hypot(force.force[1]);
    let largest = field.forces().map(|force| size(&force)).fold(0.0, f64::max);
    field
        .forces()
        .filter(|force| size(force) > 1e-6 * largest)
        .map(|force| force_arrow(field, &force, size(&force), largest))
        .collect()
}

/// A push ends at the rim and a pull begins there.
fn force_arrow(field: &DiscField, force: &PointForce, size: f64, largest: f64) -> String {
    let point = force.point.map(|x| x / field.radius());
    let pushes = force.force[0] * point[0] + force.force[1] * point[1] <= 0.0;
    let sign = if pushes { -1.0 } else { 1.0 };
    // Upwards on the picture is down its coordinate.
    let away = [sign * force.force[0] / size, -sign * force.force[1] / size];
    let length = (ARROW * size / largest).max(16.0);
    let [near, far, label] = [2.0, 2.0 + length, 10.0 + length].map(|distance| {
        let [x, y] = on_map(point);
        [x + distance * away[0], y + distance * away[1]]
    });
    let line = if pushes { [far, near] } else { [near, far] };
    let anchor = match away[0] {
        x if x > 0.4 => "start",
        x if x < -0.4 => "end",
        _ => "middle",
    };
    let middle = [label[0], label[1] + 4.5 + 5.0 * away[1]];
    arrow(line) + &text(middle, anchor, &rounded(size, 3))
}

/// A line with a head at its end.
pub fn arrow([from, to]: [[f64; 2]; 2]) -> String {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    let (dx, dy) = (dx / length, dy / length);
    let base = [to[0] - 9.0 * dx, to[1] - 9.0 * dy];
    format!(
        "<path stroke=\"#1b1b1b\" stroke-width=\"2.4\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>\
         <path d=\"M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z\"/>\n",
        from[0],
        from[1],
        base[0],
        base[1],
        to[0],
        to[1],
        base[0] - 4.5 * dy,
        base[1] + 4.5 * dx,
        base[0] + 4.5 * dy,
        base[1] - 4.5 * dx
    )
}
