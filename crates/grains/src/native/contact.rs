//! The contact law, scalar, as walls and punch have it and the fast kernel must: where two bodies touch and how stiff the contact
//! is (Eq. 4 of the paper); spring, dashpot, and the incremental tangential spring with Coulomb's limit (Eq. 5).
//!
//! In the plane a cross product with the spin ω about y is ω × (a_x, a_z) = (ω a_z, −ω a_x), and the torque of F at the
//! arm a is a_z F_x − a_x F_z. The order of the operations is part of the definition: it is what gives YADE's bits.

use crate::model::{Law, Wall};
use crate::scene::{NewContactSlip, SlipVelocity, Tension, TorqueArms};
use crate::tables::Punch;

/// Where two bodies touch. The normal points from body 1 to body 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// u_n ≥ 0, m.
    pub overlap: f64,
    /// Unit vector from body 1 to body 2.
    pub normal: [f64; 2],
    /// m.
    pub point: [f64; 2],
    /// Radii of curvature of both sides, m; a flat body has the grain's.
    pub radii: [f64; 2],
    pub pair: Pair,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pair {
    Grains,
    Wall,
    /// The punch and a grain whose centre is outside it: at a face, an edge or a corner.
    PunchOutside,
    /// The punch and a grain whose centre is inside it.
    PunchInside,
}

impl Touch {
    /// Force of a linear spring on body 2, N: (k_n u_n) n.
    pub fn spring_force(&self, stiffness: f64) -> [f64; 2] {
        let force = stiffness * self.overlap;
        [force * self.normal[0], force * self.normal[1]]
    }
}

/// Two grains: u_n = R_1 + R_2 − d, n along the line of centres.
pub fn grains([one, two]: [[f64; 2]; 2], radii: [f64; 2]) -> Option<Touch> {
    let [dx, dz] = difference(two, one);
    let distance = (dx * dx + dz * dz).sqrt();
    let overlap = radii[0] + radii[1] - distance;
    if overlap < 0.0 {
        return None;
    }
    let normal = [dx / distance, dz / distance];
    let arm = radii[0] - 0.5 * overlap;
    Some(Touch {
        overlap,
        normal,
        point: [one[0] + arm * normal[0], one[1] + arm * normal[1]],
        radii,
        pair: Pair::Grains,
    })
}

/// An infinite wall (body 1) and a grain: u_n = R − |distance|, n towards the grain's side, the point on the wall.
pub fn wall(wall: &Wall, position: [f64; 2], radius: f64) -> Option<Touch> {
    let axis = wall.axis as usize;
    let distance = position[axis] - wall.place;
    let overlap = -(distance.abs() - radius);
    if overlap < 0.0 {
        return None;
    }
    let mut normal = [0.0, 0.0];
    normal[axis] = if distance > 0.0 { 1.0 } else { -1.0 };
    let mut point = position;
    point[axis] = wall.place;
    Some(Touch {
        overlap,
        normal,
        point,
        radii: [radius, radius],
        pair: Pair::Wall,
    })
}

/// The rectangular punch (body 1) and a grain. Centre outside: s from the grain's centre to the nearest
/// point of the rectangle, u_n = R − |s|, n = −s/|s|; corners act as points. Centre inside, faces
/// included: the nearest face decides, u_n = R + depth.
pub fn punch(punch: &Punch, position: [f64; 2], radius: f64) -> Option<Touch> {
    let (centre, half_extents) = (punch.centre, punch.half_extents);
    let relative = [position[0] - centre[0], position[1] - centre[1]];
    let nearest = [0, 1].map(|axis| relative[axis].clamp(-half_extents[axis], half_extents[axis]));
    if nearest == relative {
        return Some(inside_punch(relative, half_extents, position, radius));
    }
    let s = [nearest[0] - relative[0], nearest[1] - relative[1]];
    let distance = (s[0] * s[0] + s[1] * s[1]).sqrt();
    let overlap = radius - distance;
    if overlap < 0.0 {
        return None;
    }
    let towards = [s[0] / distance, s[1] / distance];
    // The middle between the rectangle's nearest point and the grain's deepest one.
    let middle = |axis: usize| {
        0.5 * ((nearest[axis] + centre[axis]) + (position[axis] + towards[axis] * radius))
    };
    Some(Touch {
        overlap,
        normal: [-towards[0], -towards[1]],
        point: [middle(0), middle(1)],
        radii: [radius, radius],
        pair: Pair::PunchOutside,
    })
}

fn inside_punch(
    relative: [f64; 2],
    half_extents: [f64; 2],
    position: [f64; 2],
    radius: f64,
) -> Touch {
    let depth = [0, 1].map(|axis: usize| half_extents[axis] - relative[axis].abs());
    let axis = usize::from(depth[1] < depth[0]);
    let nearest = depth[axis];
    let mut normal = [0.0, 0.0];
    normal[axis] = if relative[axis] > 0.0 { 1.0 } else { -1.0 };
    let face = [0, 1].map(|axis| position[axis] + normal[axis] * nearest);
    let deepest = [0, 1].map(|axis| position[axis] - normal[axis] * radius);
    Touch {
        overlap: (face[axis] - deepest[axis]).abs(),
        normal,
        point: [0, 1].map(|axis| 0.5 * (face[axis] + deepest[axis])),
        radii: [radius, radius],
        pair: Pair::PunchInside,
    }
}

/// What a contact remembers from step to step; of a pair that does not touch, zeros.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Memory {
    /// The normal of the last step.
    pub normal: [f64; 2],
    /// Tangential force S on body 2, N.
    pub shear: [f64; 2],
}

impl Memory {
    /// Whether the pair touched in the last step: a normal has a length.
    pub fn touching(&self) -> bool {
        self.normal != [0.0; 2]
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Parameters {
    /// Normal stiffness, N/m.
    pub k_n: f64,
    /// Tangential stiffness, N/m.
    pub k_s: f64,
    /// Damping constant, N·s/m.
    pub c_n: f64,
}

/// How one side of a contact moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Centre, m.
    pub position: [f64; 2],
    /// m/s.
    pub velocity: [f64; 2],
    /// rad/s.
    pub spin: f64,
}

impl From<&Punch> for Motion {
    fn from(punch: &Punch) -> Self {
        Motion {
            position: punch.centre,
            velocity: [0.0, punch.velocity],
            spin: 0.0,
        }
    }
}

/// What a contact does to its bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Action {
    /// Force on body 2, N; body 1 bears the opposite.
    pub force: [f64; 2],
    /// Torques on body 1 and body 2, N·m.
    pub torques: [f64; 2],
}

/// The law with what is the same for all contacts worked out once.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactRules {
    pub friction: bool,
    pub rotates: bool,
    /// tan²φ.
    pub tan_squared: f64,
    /// At walls and at the punch.
    pub tan_squared_at: [f64; 2],
    pub dashpots: bool,
    pub tension: Tension,
    pub slip_velocity: SlipVelocity,
    pub torque_arms: TorqueArms,
    pub new_contact_slip: NewContactSlip,
    /// s.
    pub dt: f64,
}

impl ContactRules {
    /// The rules of this law at this time step.
    pub fn new(law: &Law, dt: f64) -> Self {
        let [grains, walls, punch] = law.friction_angles().map(|angle| {
            let tangent = angle.tan();
            tangent * tangent
        });
        ContactRules {
            friction: law.has_friction(),
            rotates: law.rotates(),
            tan_squared: grains,
            tan_squared_at: [walls, punch],
            dashpots: law.has_dashpots(),
            tension: law.contact.viscosity.tension(),
            slip_velocity: law.contact.slip_velocity,
            torque_arms: law.contact.torque_arms,
            new_contact_slip: law.contact.new_contact_slip,
            dt,
        }
    }

    /// The same with this tan²φ.
    pub fn limited_by(&self, tan_squared: f64) -> Self {
        ContactRules {
            tan_squared,
            ..self.clone()
        }
    }

    /// Whether anything asks where on a grain a contact is.
    pub fn needs_points(&self) -> bool {
        self.dashpots
            || self.slip_velocity == SlipVelocity::ContactPoint
            || self.torque_arms == TorqueArms::ContactPoint
    }

    /// What the contact does in this step; its memory moves on by a step.
    pub fn act(
        &self,
        touch: &Touch,
        parameters: &Parameters,
        one: &Motion,
        two: &Motion,
        memory: &mut Memory,
    ) -> Action {
        let normal_force = self.normal_force(touch, parameters, one, two);
        if self.friction {
            self.move_on(touch, parameters, normal_force, one, two, memory);
        }
        memory.normal = touch.normal;
        let force = [
            normal_force[0] + memory.shear[0],
            normal_force[1] + memory.shear[1],
        ];
        Action {
            force,
            torques: if self.rotates {
                self.torques(touch, force, one, two)
            } else {
                [0.0; 2]
            },
        }
    }

    /// Normal force on body 2, N: k_n u_n, with a dashpot k_n u_n + c_n·(approach speed).
    pub fn normal_force(
        &self,
        touch: &Touch,
        parameters: &Parameters,
        one: &Motion,
        two: &Motion,
    ) -> [f64; 2] {
        let spring = parameters.k_n * touch.overlap;
        let mut force = spring;
        if self.dashpots {
            let apart = dot(touch.normal, velocity_at_point(touch, one, two));
            force = spring - parameters.c_n * apart;
            if force < 0.0 && self.tension == Tension::Clipped {
                return [0.0; 2];
            }
        }
        [force * touch.normal[0], force * touch.normal[1]]
    }

    /// Eq. 5: the shear force turns with the normal, grows by k_s times the slip of this step, and is cut to |N| tan φ.
    fn move_on(
        &self,
        touch: &Touch,
        parameters: &Parameters,
        normal_force: [f64; 2],
        one: &Motion,
        two: &Motion,
        memory: &mut Memory,
    ) {
        let [nx, nz] = touch.normal;
        let mut shear = [0.0; 2];
        if memory.touching() {
            let [old_x, old_z] = memory.normal;
            let turn = old_z * nx - old_x * nz;
            let [sx, sz] = memory.shear;
            shear = [sx + sz * turn, sz - sx * turn];
        }
        let relative = self.slip_velocity(touch, one, two);
        let along = dot(touch.normal, relative);
        let slip = [relative[0] - along * nx, relative[1] - along * nz];
        let share = self.share_of_step(touch, along, memory.touching());
        // YADE's laws with and without a dashpot multiply in different orders.
        let growth = |slip: f64| {
            if self.dashpots {
                parameters.k_s * self.dt * slip
            } else {
                parameters.k_s * (slip * self.dt)
            }
        };
        shear[0] -= share * growth(slip[0]);
        shear[1] -= share * growth(slip[1]);
        let limit_squared = dot(normal_force, normal_force) * self.tan_squared;
        let squared = dot(shear, shear);
        if squared > limit_squared {
            let ratio = limit_squared.sqrt() / squared.sqrt();
            shear[0] *= ratio;
            shear[1] *= ratio;
        }
        memory.shear = shear;
    }

    /// Which share of this step the contact has existed; 1 but for a new contact that is timed.
    fn share_of_step(&self, touch: &Touch, along: f64, touching: bool) -> f64 {
        let way = -along * self.dt;
        if touching || self.new_contact_slip == NewContactSlip::WholeStep || way <= touch.overlap {
            return 1.0;
        }
        touch.overlap / way
    }

    /// Velocity of body 2 relative to body 1 whose tangential part is the slip, m/s.
    fn slip_velocity(&self, touch: &Touch, one: &Motion, two: &Motion) -> [f64; 2] {
        let corrected = match touch.pair {
            Pair::Grains | Pair::Wall => self.slip_velocity == SlipVelocity::RatchetingCorrected,
            // As in YADE, whatever is chosen; its law with dashpots never corrects.
            Pair::PunchOutside => false,
            Pair::PunchInside => !self.dashpots,
        };
        if !corrected {
            return velocity_at_point(touch, one, two);
        }
        let [r1, r2] = touch.radii;
        let [nx, nz] = touch.normal;
        let stretch = (r1 + r2) / (r1 + r2 - touch.overlap);
        let of_two = cross(two.spin, [-r2 * nx, -r2 * nz]);
        let of_one = cross(one.spin, [r1 * nx, r1 * nz]);
        [0, 1].map(|axis| {
            ((two.velocity[axis] - one.velocity[axis]) * stretch + of_two[axis]) - of_one[axis]
        })
    }

    /// Torques of a force on body 2 and its opposite on body 1, N·m.
    fn torques(&self, touch: &Touch, force: [f64; 2], one: &Motion, two: &Motion) -> [f64; 2] {
        let on_one = [-force[0], -force[1]];
        match self.torque_arms {
            TorqueArms::HalfOverlap => {
                let turn = torque(touch.normal, on_one);
                touch
                    .radii
                    .map(|radius| (radius - 0.5 * touch.overlap) * turn)
            }
            TorqueArms::ContactPoint => [
                torque(difference(touch.point, one.position), on_one),
                torque(difference(touch.point, two.position), force),
            ],
        }
    }
}

/// Velocity of body 2 relative to body 1 at the contact point, m/s.
fn velocity_at_point(touch: &Touch, one: &Motion, two: &Motion) -> [f64; 2] {
    let at = |motion: &Motion| {
        let turning = cross(motion.spin, difference(touch.point, motion.position));
        [
            motion.velocity[0] + turning[0],
            motion.velocity[1] + turning[1],
        ]
    };
    difference(at(two), at(one))
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// ω × a.
fn cross(spin: f64, arm: [f64; 2]) -> [f64; 2] {
    [spin * arm[1], -(spin * arm[0])]
}

/// (a × F) about y.
fn torque(arm: [f64; 2], force: [f64; 2]) -> f64 {
    arm[1] * force[0] - arm[0] * force[1]
}
