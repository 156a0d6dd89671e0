//! The method written out plainly: no lists, no lanes, nothing shared with the engine. Every pair is
//! looked at in the order of ids, walls after grains, the punch last, and what contacts remember is
//! kept in a map. Slow and obvious; the engine must have its bits.

use std::collections::HashMap;

use grains::model::{Model, damping_ratio};
use grains::scene::{NewContactSlip, SlipVelocity, Tension, TorqueArms, Viscosity};
use grains::tables::{Bodies, Contact, Punch};

/// Grains, what they remember and what pushes them.
pub struct AllPairs {
    model: Model,
    /// The grains now.
    pub bodies: Bodies,
    /// The punch now.
    pub punch: Option<Punch>,
    /// The contacts of the last evaluation, in the order in which they were summed.
    pub contacts: Vec<Contact>,
    histories: HashMap<(u32, u32), History>,
    force: Vec<[f64; 2]>,
    torque: Vec<f64>,
}

struct History {
    normal: [f64; 2],
    shear: [f64; 2],
}

/// Where two bodies touch; the normal points from body 1 to body 2.
struct Touch {
    overlap: f64,
    normal: [f64; 2],
    point: [f64; 2],
    radii: [f64; 2],
    effective_mass: f64,
    slip: SlipVelocity,
}

#[derive(Clone, Copy)]
struct Body {
    place: [f64; 2],
    velocity: [f64; 2],
    spin: f64,
}

impl AllPairs {
    /// The forces at the start belong to it.
    pub fn new(model: &Model, bodies: &Bodies, punch: Option<Punch>) -> Self {
        let mut all = AllPairs {
            model: model.clone(),
            bodies: bodies.clone(),
            punch,
            contacts: Vec::new(),
            histories: HashMap::new(),
            force: Vec::new(),
            torque: Vec::new(),
        };
        all.forces();
        all
    }

    /// Goes on with another model: forces are those of the old one until the next step, contacts keep what they remember.
    pub fn change(&mut self, model: &Model) {
        if !self.model.law.rotates() {
            self.torque.fill(0.0);
        }
        self.model = model.clone();
    }

    /// One time step.
    pub fn step(&mut self) {
        let (dt, alpha) = (self.model.dt, self.model.alpha);
        let damped = |acceleration: f64, velocity: f64| {
            let power = acceleration * (velocity + 0.5 * dt * acceleration);
            if power > 0.0 {
                acceleration * (1.0 - alpha)
            } else if power < 0.0 {
                acceleration * (1.0 + alpha)
            } else {
                acceleration
            }
        };
        if let Some(punch) = &mut self.punch {
            punch.centre[1] += punch.velocity * dt;
        }
        let of = &mut self.bodies;
        for i in 0..of.x.len() {
            let [gx, gz] = self.model.gravity;
            of.vx[i] += dt * damped(self.force[i][0] / of.mass[i] + gx, of.vx[i]);
            of.vz[i] += dt * damped(self.force[i][1] / of.mass[i] + gz, of.vz[i]);
            of.x[i] += dt * of.vx[i];
            of.z[i] += dt * of.vz[i];
            if self.model.law.rotates() {
                of.spin[i] += dt * damped(self.torque[i] / of.inertia[i], of.spin[i]);
            }
        }
        self.forces();
    }

    fn forces(&mut self) {
        let count = self.bodies.len();
        self.force = vec![[0.0; 2]; count];
        self.torque = vec![0.0; count];
        self.contacts.clear();
        for i in 0..count {
            for j in i + 1..count {
                let touch = self.two_grains(i, j);
                self.contact((i as u32, j as u32), touch, self.grain(i), j);
            }
        }
        let at_rest = |place| Body {
            place,
            velocity: [0.0; 2],
            spin: 0.0,
        };
        for wall in 0..self.model.walls.len() {
            for i in 0..count {
                let touch = self.wall(wall, i);
                let id = (count + wall) as u32;
                self.contact((id, i as u32), touch, at_rest([0.0; 2]), i);
            }
        }
        if let Some(punch) = self.punch {
            let mut on_punch = 0.0;
            for i in 0..count {
                let touch = self.punch(&punch, i);
                let id = (count + self.model.walls.len()) as u32;
                let body = Body {
                    velocity: [0.0, punch.velocity],
                    ..at_rest(punch.centre)
                };
                on_punch -= self.contact((id, i as u32), touch, body, i)[1];
            }
            self.punch = Some(Punch {
                force: on_punch,
                ..punch
            });
        }
    }

    fn grain(&self, i: usize) -> Body {
        let of = &self.bodies;
        Body {
            place: [of.x[i], of.z[i]],
            velocity: [of.vx[i], of.vz[i]],
            spin: of.spin.get(i).copied().unwrap_or(0.0),
        }
    }

    fn two_grains(&self, i: usize, j: usize) -> Option<Touch> {
        let ([x1, z1], [x2, z2]) = (self.grain(i).place, self.grain(j).place);
        let (r1, r2) = (self.bodies.radius[i], self.bodies.radius[j]);
        let (m1, m2) = (self.bodies.mass[i], self.bodies.mass[j]);
        let (dx, dz) = (x2 - x1, z2 - z1);
        let distance = (dx * dx + dz * dz).sqrt();
        let overlap = r1 + r2 - distance;
        let normal = [dx / distance, dz / distance];
        let arm = r1 - 0.5 * overlap;
        (overlap >= 0.0).then_some(Touch {
            overlap,
            normal,
            point: [x1 + arm * normal[0], z1 + arm * normal[1]],
            radii: [r1, r2],
            effective_mass: m1 * m2 / (m1 + m2),
            slip: self.model.law.contact.slip_velocity,
        })
    }

    fn wall(&self, wall: usize, i: usize) -> Option<Touch> {
        let wall = self.model.walls[wall];
        let (axis, radius) = (wall.axis as usize, self.bodies.radius[i]);
        let mut point = self.grain(i).place;
        let distance = point[axis] - wall.place;
        let overlap = radius - distance.abs();
        let mut normal = [0.0; 2];
        normal[axis] = if distance > 0.0 { 1.0 } else { -1.0 };
        point[axis] = wall.place;
        (overlap >= 0.0).then_some(Touch {
            overlap,
            normal,
            point,
            radii: [radius; 2],
            effective_mass: self.bodies.mass[i],
            slip: self.model.law.contact.slip_velocity,
        })
    }

    fn punch(&self, punch: &Punch, i: usize) -> Option<Touch> {
        let ([x, z], radius) = (self.grain(i).place, self.bodies.radius[i]);
        let ([cx, cz], [ex, ez]) = (punch.centre, punch.half_extents);
        let (rx, rz) = (x - cx, z - cz);
        let flat = |overlap, normal, point, slip| Touch {
            overlap,
            normal,
            point,
            radii: [radius; 2],
            effective_mass: self.bodies.mass[i],
            slip,
        };
        if rx.abs() <= ex && rz.abs() <= ez {
            // Centre inside: out by the nearest face.
            let (to_side, to_end) = (ex - rx.abs(), ez - rz.abs());
            let sign = |of: f64| if of > 0.0 { 1.0 } else { -1.0 };
            let (normal, depth) = if to_end < to_side {
                ([0.0, sign(rz)], to_end)
            } else {
                ([sign(rx), 0.0], to_side)
            };
            let face = [x + normal[0] * depth, z + normal[1] * depth];
            let deepest = [x - normal[0] * radius, z - normal[1] * radius];
            return Some(flat(
                (face[0] - deepest[0]).hypot(face[1] - deepest[1]),
                normal,
                [0.5 * (face[0] + deepest[0]), 0.5 * (face[1] + deepest[1])],
                match self.model.law.contact.viscosity {
                    Viscosity::None => SlipVelocity::RatchetingCorrected,
                    _ => SlipVelocity::ContactPoint,
                },
            ));
        }
        let (nearest_x, nearest_z) = (rx.max(-ex).min(ex), rz.max(-ez).min(ez));
        let (sx, sz) = (nearest_x - rx, nearest_z - rz);
        let distance = (sx * sx + sz * sz).sqrt();
        let overlap = radius - distance;
        let normal = [-(sx / distance), -(sz / distance)];
        let deepest = [x - normal[0] * radius, z - normal[1] * radius];
        let [px, pz] = [nearest_x + cx, nearest_z + cz];
        let point = [0.5 * (px + deepest[0]), 0.5 * (pz + deepest[1])];
        (overlap >= 0.0).then(|| flat(overlap, normal, point, SlipVelocity::ContactPoint))
    }

    /// Adds what body 1 and grain `i` do to each other, which their history then knows. Returns the
    /// force on the grain.
    fn contact(&mut self, ids: (u32, u32), touch: Option<Touch>, one: Body, i: usize) -> [f64; 2] {
        let Some(touch) = touch else {
            self.histories.remove(&ids);
            return [0.0; 2];
        };
        let two = self.grain(i);
        let [nx, nz] = touch.normal;
        let normal_force = self.normal_force(&touch, one, two);
        let shear = if self.model.law.has_friction() {
            self.shear(ids, &touch, [one, two], normal_force)
        } else {
            [0.0; 2]
        };
        // N and S act on body 2.
        let force = [normal_force[0] + shear[0], normal_force[1] + shear[1]];
        let [fx, fz] = [-force[0], -force[1]];
        let torques = match self.model.law.contact.torque_arms {
            TorqueArms::HalfOverlap => touch
                .radii
                .map(|r| (r - 0.5 * touch.overlap) * (nz * fx - nx * fz)),
            TorqueArms::ContactPoint => {
                let arm = |of: Body| [touch.point[0] - of.place[0], touch.point[1] - of.place[1]];
                let (a1, a2) = (arm(one), arm(two));
                [a1[1] * fx - a1[0] * fz, a2[1] * -fx - a2[0] * -fz]
            }
        };
        if let Some(sum) = self.force.get_mut(ids.0 as usize) {
            sum[0] += fx;
            sum[1] += fz;
            self.torque[ids.0 as usize] += torques[0];
        }
        self.force[i][0] -= fx;
        self.force[i][1] -= fz;
        self.torque[i] += torques[1];
        self.contacts.push(Contact {
            id1: ids.0,
            id2: ids.1,
            overlap: touch.overlap,
            normal_force: force[0] * nx + force[1] * nz,
            tangential_force: force[1] * nx - force[0] * nz,
            normal: touch.normal,
            point: touch.point,
        });
        let normal = touch.normal;
        self.histories.insert(ids, History { normal, shear });
        force
    }

    fn normal_force(&self, touch: &Touch, one: Body, two: Body) -> [f64; 2] {
        let law = &self.model.law;
        let [nx, nz] = touch.normal;
        let k_n = self.stiffness(touch, 1.0);
        let mut force = k_n * touch.overlap;
        let (c_n, tension) = match law.contact.viscosity {
            Viscosity::None => return [force * nx, force * nz],
            Viscosity::Dashpot { c_n, tension } => (series(c_n, c_n), tension),
            Viscosity::Restitution { e_n, tension } => {
                let critical = (touch.effective_mass * k_n).sqrt();
                (2.0 * damping_ratio(e_n, tension) * critical, tension)
            }
        };
        let apart = at_contact_point(touch, one, two);
        force -= c_n * (nx * apart[0] + nz * apart[1]);
        if force < 0.0 && tension == Tension::Clipped {
            force = 0.0;
        }
        [force * nx, force * nz]
    }

    /// k_n, or k_s with the ratio k_s/k_n.
    fn stiffness(&self, touch: &Touch, ratio: f64) -> f64 {
        let [a, b] = touch.radii.map(|r| self.model.law.modulus * r * ratio);
        if self.model.law.contact.viscosity == Viscosity::None {
            2.0 * a * b / (a + b)
        } else {
            series(a, b)
        }
    }

    fn shear(
        &self,
        ids: (u32, u32),
        touch: &Touch,
        on: [Body; 2],
        normal_force: [f64; 2],
    ) -> [f64; 2] {
        let [one, two] = on;
        let law = &self.model.law;
        let dt = self.model.dt;
        let [nx, nz] = touch.normal;
        let history = self.histories.get(&ids);
        let mut carried = [0.0; 2];
        if let Some(History { normal, shear }) = history {
            let o = normal[1] * nx - normal[0] * nz;
            carried = [shear[0] + shear[1] * o, shear[1] - shear[0] * o];
        }
        let [mut sx, mut sz] = carried;
        let [vx, vz] = match touch.slip {
            SlipVelocity::ContactPoint => at_contact_point(touch, one, two),
            SlipVelocity::RatchetingCorrected => {
                let [r1, r2] = touch.radii;
                let a = (r1 + r2) / (r1 + r2 - touch.overlap);
                let (w1, w2) = (one.spin, two.spin);
                let (v1, v2) = (one.velocity, two.velocity);
                [
                    ((v2[0] - v1[0]) * a + w2 * (-r2 * nz)) - w1 * (r1 * nz),
                    ((v2[1] - v1[1]) * a + -(w2 * (-r2 * nx))) - -(w1 * (r1 * nx)),
                ]
            }
        };
        let along = nx * vx + nz * vz;
        let [tx, tz] = [vx - along * nx, vz - along * nz];
        // The way since they met, over the way in this step.
        let mut share = 1.0;
        let way = -along * dt;
        if law.contact.new_contact_slip == NewContactSlip::SinceTouch
            && history.is_none()
            && way > touch.overlap
        {
            share = touch.overlap / way;
        }
        let k_s = self.stiffness(touch, law.stiffness_ratio);
        let [gx, gz] = if law.contact.viscosity == Viscosity::None {
            [k_s * (tx * dt), k_s * (tz * dt)]
        } else {
            [k_s * dt * tx, k_s * dt * tz]
        };
        sx -= share * gx;
        sz -= share * gz;
        let walls = self.bodies.len() as u32;
        let own = match ids.0 {
            body if body < walls => None,
            body if body < walls + self.model.walls.len() as u32 => law.wall_friction_angle,
            _ => law.punch_friction_angle,
        };
        let tan = own.unwrap_or(law.friction_angle).tan();
        let [fx, fz] = normal_force;
        let limit_squared = (fx * fx + fz * fz) * (tan * tan);
        let squared = sx * sx + sz * sz;
        if squared > limit_squared {
            let cut = limit_squared.sqrt() / squared.sqrt();
            sx *= cut;
            sz *= cut;
        }
        [sx, sz]
    }
}

/// Velocity of body 2 relative to body 1 at the contact point.
fn at_contact_point(touch: &Touch, one: Body, two: Body) -> [f64; 2] {
    let of = |body: Body| {
        let [ax, az] = [0, 1].map(|axis| touch.point[axis] - body.place[axis]);
        let [vx, vz] = body.velocity;
        [vx + body.spin * az, vz - body.spin * ax]
    };
    let (v1, v2) = (of(one), of(two));
    [v2[0] - v1[0], v2[1] - v1[1]]
}

/// Two bodies of twice these constants in series, as the law with dashpots adds them.
fn series(a: f64, b: f64) -> f64 {
    1.0 / (1.0 / (2.0 * a) + 1.0 / (2.0 * b))
}
