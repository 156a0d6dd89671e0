//! Bodies of any direction that spheres in space touch besides walls and punch: planes, triangles and boxes, which move and turn
//! at a constant rate whatever touches them. Operations stand in YADE's order for triangles and boxes, which decides the bits.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::reference::Motion;
use crate::vector::{Vector, cross, dot, minus, norm, plus, times};

/// A body that nothing pushes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// What it is and where at the start.
    pub shape: Surface,
    /// Of its centre, m/s: x, y, z.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub velocity: Vector,
    /// About its centre, rad/s; a plane's is along its normal.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spin: Vector,
}

/// What an obstacle is: lengths in m, vectors as x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Surface {
    /// Endless, and felt from both sides as walls are; its centre is the point.
    Plane { point: Vector, normal: Vector },
    /// Felt from both sides; its centre is that of its inscribed circle.
    Triangle { vertices: [Vector; 3] },
    /// Felt from outside and from inside.
    Box {
        centre: Vector,
        half_extents: Vector,
        /// From the axes to its own, as a quaternion of length 1 with its real part first.
        #[serde(default = "unturned", skip_serializing_if = "is_unturned")]
        orientation: Quaternion,
    },
}

/// The corners of several, m.
pub type Triangles = Vec<[Vector; 3]>;

type Quaternion = [f64; 4];

fn unturned() -> Quaternion {
    [1.0, 0.0, 0.0, 0.0]
}

fn is_unturned(orientation: &Quaternion) -> bool {
    *orientation == unturned()
}

fn is_zero(vector: &Vector) -> bool {
    *vector == [0.0; 3]
}

/// How far lengths of unit vectors may be from 1.
const UNIT: f64 = 1.0e-9;
/// The least angle of a triangle, about, rad.
const THINNEST: f64 = 1.0e-6;
/// The least vertical part of the normal of a plane in a scene.
const STEEPEST: f64 = 0.1;

impl Obstacle {
    /// At rest.
    pub fn still(shape: Surface) -> Self {
        Obstacle {
            shape,
            velocity: [0.0; 3],
            spin: [0.0; 3],
        }
    }

    fn placed_after(&self, steps: u64, dt: f64) -> Placed {
        let mut placed = Placed::new(self);
        (0..steps).for_each(|_| placed.advance(dt));
        placed
    }

    /// Whether this normal is that of no face of it after so many steps of dt, s, as at edges and corners.
    pub fn is_at_edge(&self, normal: Vector, steps: u64, dt: f64) -> bool {
        self.placed_after(steps, dt).is_at_edge(normal)
    }

    /// Where it is after so many steps of dt, s; to rounding.
    pub fn after(&self, steps: u64, dt: f64) -> Self {
        let placed = self.placed_after(steps, dt);
        let place = placed.motion.place;
        let shape = match (self.shape, &placed.shape) {
            (Surface::Plane { normal, .. }, _) => Surface::Plane {
                point: place,
                normal,
            },
            (Surface::Box { half_extents, .. }, _) => Surface::Box {
                centre: place,
                half_extents,
                orientation: placed.orientation,
            },
            (Surface::Triangle { .. }, Shape::Triangle(facet)) => Surface::Triangle {
                vertices: facet
                    .vertices
                    .map(|vertex| plus(place, placed.outward(vertex))),
            },
            (still, _) => still,
        };
        Obstacle { shape, ..*self }
    }

    /// What it has to be and is not, to stand in a scene.
    pub fn lacks(&self) -> Option<&'static str> {
        let is_unit = |squared: f64| (squared - 1.0).abs() <= UNIT;
        match self.shape {
            _ if self.velocity != [0.0; 3] || self.spin != [0.0; 3] => {
                Some("a body at rest: in a scene only the punch moves")
            }
            Surface::Plane { normal, .. } if !is_unit(dot(normal, normal)) => {
                Some("a normal of length 1")
            }
            Surface::Plane { normal, .. } if normal[2].abs() < STEEPEST => Some(
                "a plane less steep, of which a cloud can lie above: the normal's z at least 0.1 in size",
            ),
            Surface::Triangle {
                vertices: [a, b, c],
            } => {
                let (one, two) = (minus(b, a), minus(c, a));
                let longest = norm(one).max(norm(two)).max(norm(minus(c, b)));
                let area = norm(cross(one, two));
                // Not a number, too.
                let is_thin = !(area > THINNEST * longest * longest && area.is_normal());
                is_thin.then_some("a triangle with an area, not a line or a point")
            }
            Surface::Box { half_extents, .. } if half_extents.iter().any(|half| *half <= 0.0) => {
                Some("half extents above 0")
            }
            Surface::Box { orientation, .. }
                if !is_unit(orientation.iter().map(|part| part * part).sum()) =>
            {
                Some("an orientation of length 1")
            }
            _ => None,
        }
    }

    /// The height of its highest point in a box of this width and depth, m.
    pub fn top(&self, [width, depth]: [f64; 2]) -> f64 {
        let Surface::Plane { point, normal } = self.shape else {
            return Placed::new(self).bounds()[1][2];
        };
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, depth], [width, depth]];
        let heights = corners.map(|[x, y]| {
            let along = normal[0] * (x - point[0]) + normal[1] * (y - point[1]);
            point[2] - along / normal[2]
        });
        heights.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// An obstacle where it is now.
#[derive(Clone)]
pub(crate) struct Placed {
    shape: Shape,
    pub(crate) motion: Motion,
    orientation: Quaternion,
    /// Rows of the matrix from its own axes to those of space.
    rotation: [Vector; 3],
}

#[derive(Clone)]
enum Shape {
    Plane { normal: Vector },
    Triangle(Box<Facet>),
    Box { half_extents: Vector },
}

/// A triangle about the centre of its inscribed circle.
#[derive(Clone, Copy)]
struct Facet {
    vertices: [Vector; 3],
    edges: [Vector; 3],
    normal: Vector,
    /// Of the edges, in the triangle's plane, outward.
    outward: [Vector; 3],
    inscribed: f64,
}

/// Where a sphere touches an obstacle; the normal points to the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub overlap: f64,
    pub normal: Vector,
    pub point: Vector,
    pub kind: Kind,
}

/// By which rules a contact slips and how stiff it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// As a wall.
    Plane,
    Triangle,
    BoxFromOutside,
    BoxFromInside,
}

fn over(a: Vector, divisor: f64) -> Vector {
    a.map(|part| part / divisor)
}

impl Facet {
    /// The triangle and its centre.
    fn new([a, b, c]: [Vector; 3]) -> (Self, Vector) {
        let [opposite_a, opposite_b, opposite_c] =
            [minus(c, b), minus(c, a), minus(b, a)].map(norm);
        let sides = plus(
            times(opposite_c, minus(c, a)),
            times(opposite_b, minus(b, a)),
        );
        let centre = plus(a, over(sides, opposite_c + opposite_a + opposite_b));
        let vertices = [a, b, c].map(|vertex| minus(vertex, centre));
        let edges = [0, 1, 2].map(|k| minus(vertices[(k + 1) % 3], vertices[k]));
        let unit = |vector| over(vector, norm(vector));
        let normal = unit(cross(edges[0], edges[1]));
        let outward = edges.map(|edge| unit(cross(edge, normal)));
        let lengths = edges.map(norm);
        let inscribed =
            lengths[0] * dot(outward[0], edges[2]) / (lengths[0] + lengths[1] + lengths[2]);
        let facet = Facet {
            vertices,
            edges,
            normal,
            outward,
            inscribed,
        };
        (facet, centre)
    }

    /// Overlap and normal of a sphere there, in the triangle's own axes.
    fn touch(&self, place: Vector, radius: f64) -> Option<(f64, Vector)> {
        let (mut normal, mut height) = (self.normal, dot(self.normal, place));
        if height < 0.0 {
            (normal, height) = (times(-1.0, normal), -height);
        }
        if height > radius {
            return None;
        }
        let beneath = minus(place, times(height, normal));
        let beyond = self.outward.map(|outward| dot(outward, beneath));
        // The first of the largest.
        let k = [1, 2]
            .into_iter()
            .fold(0, |most, k| match beyond[k] > beyond[most] {
                true => k,
                false => most,
            });
        if beyond[k] < self.inscribed {
            return Some((radius - height, over(normal, norm(normal))));
        }
        let mut nearest = plus(beneath, times(self.inscribed - beyond[k], self.outward[k]));
        let edge = self.edges[k];
        let along = dot(minus(nearest, self.vertices[k]), edge);
        let end = match along {
            along if along < 0.0 => Some(k),
            along if along > dot(edge, edge) => Some((k + 1) % 3),
            _ => None,
        };
        if let Some(end) = end {
            let vertex = self.vertices[end];
            // Not the vertex itself, as in YADE.
            nearest = times(norm(vertex), over(vertex, norm(vertex)));
        }
        let way = minus(place, nearest);
        let distance = norm(way);
        Some((radius - distance, over(way, distance)))
    }
}

impl Placed {
    pub fn new(obstacle: &Obstacle) -> Self {
        let (shape, place, orientation) = match obstacle.shape {
            Surface::Plane { point, normal } => (Shape::Plane { normal }, point, unturned()),
            Surface::Triangle { vertices } => {
                let (facet, centre) = Facet::new(vertices);
                (Shape::Triangle(Box::new(facet)), centre, unturned())
            }
            Surface::Box {
                centre,
                half_extents,
                orientation,
            } => (Shape::Box { half_extents }, centre, orientation),
        };
        Placed {
            shape,
            motion: Motion {
                place,
                velocity: obstacle.velocity,
                spin: obstacle.spin,
            },
            orientation,
            rotation: matrix(orientation),
        }
    }

    /// Moves it by a step.
    pub fn advance(&mut self, dt: f64) {
        let Motion {
            place,
            velocity,
            spin,
        } = &mut self.motion;
        *place = plus(*place, times(dt, *velocity));
        let rate = norm(*spin);
        if rate != 0.0 {
            let half = 0.5 * (rate * dt);
            let [x, y, z] = times(half.sin(), over(*spin, rate));
            self.orientation = product([half.cos(), x, y, z], self.orientation);
        }
        let [w, x, y, z] = self.orientation;
        let length = ((x * x + y * y) + (z * z + w * w)).sqrt();
        self.orientation = self.orientation.map(|part| part / length);
        self.rotation = matrix(self.orientation);
    }

    /// How it moves, for what touches it here.
    pub fn motion_at(&self, point: Vector) -> Motion {
        match self.shape {
            // It has no place of its own: its surface moves as it does here.
            Shape::Plane { .. } => {
                let arm = minus(point, self.motion.place);
                Motion {
                    place: point,
                    velocity: plus(self.motion.velocity, cross(self.motion.spin, arm)),
                    ..self.motion
                }
            }
            _ => self.motion,
        }
    }

    pub fn is_triangle(&self) -> bool {
        matches!(self.shape, Shape::Triangle(_))
    }

    /// How far any point of it moves in a step, at most, m.
    pub fn stride(&self, dt: f64) -> f64 {
        let reach = match &self.shape {
            Shape::Plane { .. } => 0.0,
            Shape::Triangle(facet) => facet.vertices.map(norm).into_iter().fold(0.0, f64::max),
            Shape::Box { half_extents } => norm(*half_extents),
        };
        (norm(self.motion.velocity) + norm(self.motion.spin) * reach) * dt
    }

    /// The lowest and the highest coordinates of it.
    pub fn bounds(&self) -> [Vector; 2] {
        let place = self.motion.place;
        let extents = match &self.shape {
            Shape::Plane { .. } => return [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]],
            Shape::Triangle(facet) => {
                let vertices = facet.vertices.map(|vertex| self.outward(vertex));
                let most = |pick: fn(f64, f64) -> f64| {
                    [0, 1, 2].map(|axis| {
                        let [a, b, c] = vertices.map(|vertex| vertex[axis]);
                        pick(a, pick(b, c))
                    })
                };
                return [plus(place, most(f64::min)), plus(place, most(f64::max))];
            }
            Shape::Box { half_extents } => self
                .rotation
                .map(|row| dot(row.map(f64::abs), *half_extents)),
        };
        [minus(place, extents), plus(place, extents)]
    }

    /// Whether what is there is no farther from it than this; also of some that are.
    pub fn is_near(&self, place: Vector, reach: f64) -> bool {
        let way = minus(place, self.motion.place);
        let normal = match &self.shape {
            Shape::Plane { normal } => *normal,
            Shape::Triangle(facet) => self.outward(facet.normal),
            Shape::Box { .. } => return true,
        };
        dot(normal, way).abs() <= reach
    }

    /// The normal of a triangle's face.
    pub(crate) fn face(&self) -> Option<Vector> {
        match &self.shape {
            Shape::Triangle(facet) => Some(self.outward(facet.normal)),
            _ => None,
        }
    }

    /// Whether this normal is that of no face of it, as at edges and corners.
    fn is_at_edge(&self, normal: Vector) -> bool {
        let along = match &self.shape {
            Shape::Plane { .. } => 1.0,
            Shape::Triangle(facet) => dot(self.outward(facet.normal), normal).abs(),
            Shape::Box { .. } => self
                .inward(normal)
                .map(f64::abs)
                .into_iter()
                .fold(0.0, f64::max),
        };
        along < 1.0 - UNIT
    }

    /// Where its orientation is taken for that from its own axes to those of space.
    pub(crate) fn turned_back(mut self) -> Self {
        let [w, x, y, z] = self.orientation;
        self.orientation = [w, -x, -y, -z];
        self.rotation = matrix(self.orientation);
        self
    }

    /// From its own axes to those of space.
    pub(crate) fn outward(&self, own: Vector) -> Vector {
        self.rotation.map(|row| dot(row, own))
    }

    fn inward(&self, vector: Vector) -> Vector {
        let rows = self.rotation;
        [0, 1, 2].map(|axis| dot(rows.map(|row| row[axis]), vector))
    }

    /// Where a sphere touches it, with no smaller overlap than this.
    pub fn touch(&self, place: Vector, radius: f64, least: f64) -> Option<Place> {
        let way = minus(place, self.motion.place);
        match &self.shape {
            Shape::Plane { normal } => {
                let distance = dot(*normal, way);
                let overlap = radius - distance.abs();
                let side = if distance > 0.0 { 1.0 } else { -1.0 };
                (overlap >= least).then(|| Place {
                    overlap,
                    normal: times(side, *normal),
                    point: minus(place, times(distance, *normal)),
                    kind: Kind::Plane,
                })
            }
            Shape::Triangle(facet) => {
                let (overlap, normal) = facet.touch(self.inward(way), radius - least)?;
                let normal = self.outward(normal);
                let overlap = overlap + least;
                (overlap > least).then(|| Place {
                    overlap,
                    normal,
                    point: minus(place, times(radius - 0.5 * overlap, normal)),
                    kind: Kind::Triangle,
                })
            }
            Shape::Box { half_extents } => {
                let own = self.inward(way);
                let extents = |axis: usize| half_extents[axis];
                let is_inside = (0..3).all(|axis| own[axis].abs() <= extents(axis));
                match is_inside {
                    true => self.touch_inside(own, extents, place, radius),
                    false => self.touch_outside(own, extents, place, (radius, least)),
                }
            }
        }
    }

    /// A box and a sphere whose centre is in it: out by the nearest face.
    fn touch_inside(
        &self,
        own: Vector,
        extents: impl Fn(usize) -> f64,
        place: Vector,
        radius: f64,
    ) -> Option<Place> {
        let depths = [0, 1, 2].map(|axis| extents(axis) - own[axis].abs());
        // The first of the smallest.
        let face = [1, 2]
            .into_iter()
            .fold(0, |least, axis| match depths[axis] < depths[least] {
                true => axis,
                false => least,
            });
        let mut axis = [0.0; 3];
        axis[face] = if own[face] > 0.0 { 1.0 } else { -1.0 };
        let out = self.outward(axis);
        let out = over(out, norm(out));
        let on_face = plus(place, times(depths[face], out));
        let deepest = minus(place, times(radius, out));
        let way = minus(on_face, deepest);
        let overlap = norm(way);
        Some(Place {
            overlap,
            normal: over(way, overlap),
            point: times(0.5, plus(on_face, deepest)),
            kind: Kind::BoxFromInside,
        })
    }

    fn touch_outside(
        &self,
        own: Vector,
        extents: impl Fn(usize) -> f64,
        place: Vector,
        (radius, least): (f64, f64),
    ) -> Option<Place> {
        let centre = self.motion.place;
        let nearest = [0, 1, 2].map(|axis| own[axis].max(-extents(axis)).min(extents(axis)));
        let nearest = self.outward(nearest);
        let way = minus(nearest, minus(place, centre));
        let distance = norm(way);
        let overlap = radius - distance;
        let inward = over(way, distance);
        let deepest = plus(place, times(radius, inward));
        (overlap >= least).then(|| Place {
            overlap,
            normal: times(-1.0, inward),
            point: times(0.5, plus(plus(nearest, centre), deepest)),
            kind: Kind::BoxFromOutside,
        })
    }
}

/// Turned by the second and then by the first.
fn product([aw, ax, ay, az]: Quaternion, [bw, bx, by, bz]: Quaternion) -> Quaternion {
    [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
    ]
}

/// Its rows, in Eigen's order of operations.
fn matrix([w, x, y, z]: Quaternion) -> [Vector; 3] {
    let [tx, ty, tz] = [2.0 * x, 2.0 * y, 2.0 * z];
    let [wx, wy, wz] = [tx * w, ty * w, tz * w];
    let [xx, xy, xz] = [tx * x, ty * x, tz * x];
    let [yy, yz, zz] = [ty * y, tz * y, tz * z];
    [
        [1.0 - (yy + zz), xy - wz, xz + wy],
        [xy + wz, 1.0 - (xx + zz), yz - wx],
        [xz - wy, yz + wx, 1.0 - (xx + yy)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Axis, Law, Model, Wall};
    use crate::rules::Rules;
    use crate::scene::{ContactLaw, Springs, Tension, TorqueArms, Viscosity};
    use crate::tables::{Bodies, Snapshot};
    use crate::task::Case;
    use crate::variant::{self, Variant};

    /// A sphere of radius 0.1 m that falls from there and slides, after so many steps.
    fn fallen(
        (walls, obstacles): (Vec<Wall>, Vec<Obstacle>),
        viscosity: Viscosity,
        place: Vector,
        steps: u64,
    ) -> Snapshot {
        let mut bodies = Bodies::default();
        let mass = 4.0 / 3.0 * std::f64::consts::PI * 0.1f64.powi(3) * 2600.0;
        bodies.push([place[0], place[2]], [0.3, -0.5], 0.1, mass);
        bodies.y.push(place[1]);
        bodies.vy.push(-0.2);
        bodies.inertia.push(0.4 * mass * 0.01);
        bodies.spin.push(1.0);
        bodies.spin_x.push(2.0);
        bodies.spin_z.push(3.0);
        let model = Model {
            gravity: [0.0, -9.81],
            alpha: 0.0,
            dt: 2.0e-5,
            walls,
            obstacles,
            law: Law {
                modulus: 2.0e7,
                stiffness_ratio: 0.3,
                friction_angle: 0.5,
                wall_friction_angle: None,
                punch_friction_angle: None,
                poissons_ratio: Some(0.3),
                materials: Vec::new(),
                contact: ContactLaw {
                    springs: Springs::HertzMindlin,
                    torque_arms: TorqueArms::ContactPoint,
                    viscosity,
                    ..ContactLaw::default()
                },
            },
            rules: Rules::default(),
        };
        let case = Case {
            name: "a sphere".to_owned(),
            model,
            bodies,
            punch: None,
            moments: vec![steps],
        };
        variant::run(&case, &Variant::default()).remove(0)
    }

    fn plane(normal: Vector) -> Obstacle {
        let point = [0.0; 3];
        Obstacle::still(Surface::Plane { point, normal })
    }

    #[test]
    fn a_plane_across_an_axis_has_the_bits_of_a_wall() {
        let place = [0.0, 0.0, 0.0999];
        let floor = Wall {
            axis: Axis::Z,
            place: 0.0,
        };
        let viscosity = || Viscosity::Restitution {
            e_n: 0.6,
            tension: Tension::Clipped,
        };
        let on_wall = fallen((vec![floor], Vec::new()), viscosity(), place, 300);
        for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
            let on_plane = fallen((Vec::new(), vec![plane(normal)]), viscosity(), place, 300);
            assert_eq!(on_plane.bodies, on_wall.bodies);
            assert_eq!(on_plane.contacts, on_wall.contacts);
        }
        assert!(on_wall.contacts[0].tangential_force > 1.0);
    }

    #[test]
    fn a_triangle_far_from_its_edges_is_a_plane_of_two_thirds_of_the_radius() {
        // Askew, so that every component is in it.
        let normal = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
        let [a, b] = [[3.0, -2.0, 0.0], [0.0, 2.0, -1.0]];
        let c = minus([0.0; 3], plus(a, b));
        let triangle = Obstacle::still(Surface::Triangle {
            vertices: [a, b, c],
        });
        let place = times(0.0995, normal);
        let [on_plane, on_triangle] = [plane(normal), triangle].map(|obstacle| {
            let bodies = (Vec::new(), vec![obstacle]);
            fallen(bodies, Viscosity::None, place, 0).contacts[0]
        });
        assert!((on_plane.overlap - 0.0005).abs() < 1.0e-15);
        assert!((on_triangle.overlap - on_plane.overlap).abs() < 1.0e-15);
        for axis in [0, 1] {
            assert!((on_triangle.normal[axis] - on_plane.normal[axis]).abs() < 1.0e-12);
        }
        // R* is 2R/3 at the one and R/2 at the other, and the force goes with its root.
        let ratio = on_triangle.normal_force / on_plane.normal_force;
        assert!((ratio - (4.0f64 / 3.0).sqrt()).abs() < 1.0e-9, "{ratio}");
        let distance = Placed::new(&triangle).touch(times(-0.0995, normal), 0.1, 0.0);
        let below = distance.expect("it is felt from both sides").normal;
        assert!((dot(below, normal) + 1.0).abs() < 1.0e-12);
    }

    /// Box and triangle after many steps stand where the rotation by the whole angle puts them.
    #[test]
    fn what_turns_has_turned_by_rate_times_time() {
        let shape = Surface::Box {
            centre: [0.0; 3],
            half_extents: [1.0, 0.1, 0.1],
            orientation: unturned(),
        };
        let velocity = [0.0, 0.0, 0.5];
        let spin = [0.0, 0.0, std::f64::consts::PI];
        let mut placed = Placed::new(&Obstacle {
            shape,
            velocity,
            spin,
        });
        (0..1000).for_each(|_| placed.advance(5.0e-4));
        // A quarter of a turn: its long axis lies along y, a quarter of a metre up.
        let touch = placed
            .touch([0.0, 1.05, 0.25], 0.1, 0.0)
            .expect("a contact");
        assert!((touch.overlap - 0.05).abs() < 1.0e-9);
        assert!((touch.normal[1] - 1.0).abs() < 1.0e-9);
        assert!(placed.touch([1.0, 0.0, 0.25], 0.1, 0.0).is_none());
    }
}
