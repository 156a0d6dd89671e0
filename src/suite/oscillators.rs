//! Flight, and grains that swing in contact all the time, against the exact solution of the discrete equations, so that only
//! rounding is left and a fault of 1e-9 shows; some also against the differential equation, where the order of the method is left.

use std::f64::consts::PI;

use super::analytic::{SpringDashpot, State};
use crate::suite::{self, CaseGroup, Grain, Track, at, rounding};
use grains::model::Law;
use grains::scene::Rotation;
use grains::tables::Snapshot;
use grains::task::Case;

pub fn groups() -> Vec<CaseGroup> {
    vec![
        free_fall(),
        damped_flight(),
        oscillator(),
        order(),
        local_damping(),
        stack(),
        sliding_spring(),
        turning_spring(),
    ]
}

/// m/s².
const GRAVITY: f64 = 9.81;
const ALPHA: f64 = 0.3;

/// Gravity and local damping alone.
mod flight {
    use super::*;

    /// s.
    pub const DT: f64 = 1.0e-3;
    /// Steps to the moments that are looked at.
    pub const MOMENTS: [u64; 2] = [100, 1000];

    pub fn case(gravity: [f64; 2], alpha: f64, grains: &[Grain]) -> Case {
        let model = suite::world(suite::springs(1.0e6), DT, gravity, alpha, [&[], &[]]);
        suite::case("flight", model, grains, MOMENTS.to_vec())
    }

    /// Place after so many steps at this acceleration.
    pub fn flown([place, velocity]: [f64; 2], acceleration: f64, steps: u64) -> f64 {
        let n = steps as f64;
        place + (velocity * n * DT + 0.5 * acceleration * DT * DT * n * (n + 1.0))
    }

    /// A bound of the way at this speed and acceleration.
    pub fn reach(speed: f64, acceleration: f64, steps: u64) -> f64 {
        let time = steps as f64 * DT;
        (speed.abs() + acceleration.abs() * time) * time
    }
}

/// A grain that starts at rest and one that is thrown, without damping, gravity having both components.
fn free_fall() -> CaseGroup {
    let gravity = [0.6, -GRAVITY];
    let grains = [
        Grain::disc([0.0, 0.0], 0.1, 1000.0),
        Grain::disc([2.0, 1.0], 0.1, 1000.0).moving([3.0, 5.0]),
    ];
    let case = flight::case(gravity, 0.0, &grains);
    let title = "Free fall with velocities at half steps: x_n = x_0 + v_0 n dt + ½g dt² n(n+1)";
    CaseGroup::new("free-fall", title).with("", case, move |track, figures| {
        for (id, (grain, kind)) in grains.iter().zip(["dropped", "thrown"]).enumerate() {
            for steps in flight::MOMENTS {
                for (axis, name) in ["x", "z"].into_iter().enumerate() {
                    let start = [grain.position[axis], grain.velocity[axis]];
                    let expected = flight::flown(start, gravity[axis], steps);
                    let size = start[0].abs() + flight::reach(start[1], gravity[axis], steps);
                    let found = at(track, steps).position(id)[axis];
                    let what = format!("{kind}/{name}/{steps}-steps, m");
                    figures.exact(&what, found, expected, steps, size);
                }
            }
        }
    })
}

/// Grains dropped, thrown up and drifting sideways under local damping.
fn damped_flight() -> CaseGroup {
    const THROWN: f64 = 2.0;
    let (up, down) = (GRAVITY * (1.0 + ALPHA), GRAVITY * (1.0 - ALPHA));
    let grains = [
        Grain::disc([0.0, 0.0], 0.1, 1000.0),
        Grain::disc([2.0, 0.0], 0.1, 1000.0).moving([0.0, THROWN]),
        Grain::disc([4.0, 0.0], 0.1, 1000.0).moving([1.5, 0.0]),
    ];
    // It rises as long as the velocity on the step, v − ½g dt, is positive.
    let thrown_up = move |steps: u64| {
        let rising = (THROWN - 0.5 * GRAVITY * flight::DT) / (up * flight::DT);
        let rising = (rising.ceil() as u64).min(steps);
        let top = flight::flown([0.0, THROWN], -up, rising);
        let speed = THROWN + rising as f64 * flight::DT * -up;
        flight::flown([top, speed], -down, steps - rising)
    };
    let case = flight::case([0.0, -GRAVITY], ALPHA, &grains);
    let title = "Under local damping a grain falls at g(1−α) and rises at g(1+α)";
    CaseGroup::new("flight-with-local-damping", title).with("", case, move |track, figures| {
        for n in flight::MOMENTS {
            let found = |id: usize| at(track, n).position(id);
            let expected = flight::flown([0.0; 2], -down, n);
            let what = format!("dropped/{n}-steps: z of the dropped grain after {n} steps, m");
            figures.exact(&what, found(0)[1], expected, n, expected.abs());
            let size = flight::reach(THROWN, up, n);
            let what = format!("thrown/{n}-steps: z of the thrown grain after {n} steps, m");
            figures.exact(&what, found(1)[1], thrown_up(n), n, size);
            let expected = flight::flown([4.0, 1.5], 0.0, n);
            let what = format!("drifting/{n}-steps: x of the drifting grain after {n} steps, m");
            figures.exact(&what, found(2)[0], expected, n, expected);
        }
    })
}

/// A disc that swings in contact, rad/s and m.
const OMEGA: f64 = 100.0;
const RADIUS: f64 = 1.0;
/// Overlap in equilibrium, and the largest way from there, m: the grain keeps touching.
const OVERLAP: f64 = 0.125;
const AMPLITUDE: f64 = 0.0625;
/// kg/m³.
const DENSITY: f64 = 1000.0;

/// Between two walls: ω² = 2k/m, k = ER.
fn between_walls(dt: f64, alpha: f64, velocity: f64, moments: Vec<u64>) -> Case {
    let width = 2.0 * (RADIUS - OVERLAP);
    let start = [0.5 * width + AMPLITUDE, 0.0];
    let grain = Grain::disc(start, RADIUS, DENSITY).moving([velocity, 0.0]);
    let stiffness = 0.5 * grain.mass * OMEGA * OMEGA;
    let law = suite::springs(stiffness / RADIUS);
    let model = suite::world(law, dt, [0.0; 2], alpha, [&[0.0, width], &[]]);
    suite::case("between walls", model, &[grain], moments)
}

/// On the floor under gravity: k = mg/u in equilibrium, so ω² = g/u.
fn on_the_floor(dt: f64, moments: Vec<u64>) -> Case {
    let grain = Grain::disc([0.0, RADIUS - OVERLAP + AMPLITUDE], RADIUS, DENSITY);
    let stiffness = grain.mass * GRAVITY / OVERLAP;
    let law = suite::springs(stiffness / RADIUS);
    let model = suite::world(law, dt, [0.0, -GRAVITY], 0.0, [&[], &[0.0]]);
    suite::case("on the floor", model, &[grain], moments)
}

/// Way from equilibrium between the walls or on the floor.
fn off_middle(track: &Track, step: u64, axis: usize) -> f64 {
    at(track, step).position(0)[axis] - (RADIUS - OVERLAP)
}

fn oscillator() -> CaseGroup {
    const MOMENTS: [u64; 3] = [1, 137, 600];
    let title = "A grain that swings in contact follows the leapfrog solution, sin(θ/2) = ½ω dt";
    let mut group = CaseGroup::new("oscillator", title);
    let omegas = [OMEGA, (GRAVITY / OVERLAP).sqrt()];
    let dts = omegas.map(|omega| 0.1 / omega);
    let cases = [
        between_walls(dts[0], 0.0, 0.0, MOMENTS.to_vec()),
        on_the_floor(dts[1], MOMENTS.to_vec()),
    ];
    for (axis, case) in cases.into_iter().enumerate() {
        let id = case.name.replace(' ', "-");
        group = group.with(id, case, move |track, figures| {
            let swing = SpringDashpot::oscillator(omegas[axis], dts[axis]);
            for n in MOMENTS {
                let expected = swing.in_touch(&State::new(0, AMPLITUDE, 0.0), n);
                let what = format!("way/{n}-steps, m");
                let found = off_middle(track, n, axis);
                figures.exact(&what, found, expected.overlap, n, RADIUS);
                let what = format!("velocity/{n}-steps, m/s");
                let found = at(track, n).velocity(0)[axis];
                figures.exact(&what, found, expected.approach, n, omegas[axis] * RADIUS);
            }
        });
    }
    group
}

/// Against y = A cos ωt after 1¼ periods, where an error of the phase is all that shows. The phase is
/// behind by ωt·(ω dt)²/24 (θ/(ω dt) − 1 to leading order); the next terms are (ω dt)² smaller.
fn order() -> CaseGroup {
    const STEPS: [u64; 4] = [40, 80, 160, 320];
    let phase = 2.5 * PI;
    let turn = STEPS.map(|n| phase / n as f64);
    let cases = [0, 1, 2, 3].map(|index| {
        // At rest at the start: −½dt·a half a step before.
        let velocity = 0.5 * turn[index] * OMEGA * AMPLITUDE;
        between_walls(turn[index] / OMEGA, 0.0, velocity, vec![STEPS[index]])
    });
    let title = "The oscillator converges to A cos ωt with the second order in dt";
    CaseGroup::new("oscillator-order", title).with_all("", cases, move |tracks, figures| {
        let off = |index: usize| off_middle(&tracks[index], STEPS[index], 0);
        let errors = [0, 1, 2, 3].map(|index| off(index) - AMPLITUDE * phase.cos());
        figures.because("the next term of the error is smaller by (ω dt)², of the coarser step");
        for (index, pair) in errors.windows(2).enumerate() {
            let [coarse, fine] = [STEPS[index], STEPS[index + 1]];
            let what = format!("order-from-{coarse}-and-{fine}-steps, 1");
            let order = (pair[0] / pair[1]).log2();
            figures.is(&what, order, 2.0, turn[index] * turn[index]);
        }
        let finest = turn[3];
        let leading = -AMPLITUDE * phase * finest * finest / 24.0;
        let found = errors[3] / leading;
        figures.because("the next term of the error is smaller by (ω dt)²");
        let what = "leading-term: error of 320 steps over its leading term −A ωt (ω dt)²/24, 1";
        figures.is(what, found, 1.0, finest * finest);
    })
}

/// Under local damping: ω² is (1−α) of itself on the way in and (1+α) on the way out.
fn local_damping() -> CaseGroup {
    const STEPS: u64 = 4000;
    let turn = 0.005;
    let mut swing = SpringDashpot::oscillator(OMEGA, turn / OMEGA);
    swing.alpha = ALPHA;
    let start = State::new(0, AMPLITUDE, 0.0);
    let turns = swing.turns(start, STEPS - 1);
    let moments = [&turns[..], &[STEPS]].concat();
    let case = between_walls(swing.dt, ALPHA, 0.0, moments);
    let title = "Local damping takes √((1−α)/(1+α)) of the amplitude in half a period";
    CaseGroup::new("oscillator-with-local-damping", title).with("", case, move |track, figures| {
        for expected in swing.track(start, &[STEPS]) {
            let found = off_middle(track, STEPS, 0);
            let what = format!("way/{STEPS}-steps, m");
            figures.exact(&what, found, expected.overlap, STEPS, RADIUS);
            let found = at(track, STEPS).velocity(0)[0];
            let what = format!("velocity/{STEPS}-steps, m/s");
            figures.exact(&what, found, expected.approach, STEPS, OMEGA * RADIUS);
        }
        figures.because(
            "√((1−α)/(1+α)) a half period; the signs change on a step and not in between, \
             which costs (ω dt)² of the amplitude each time",
        );
        let each = ((1.0 - ALPHA) / (1.0 + ALPHA)).sqrt();
        for (half_periods, step) in (1..).zip(&turns) {
            let found = off_middle(track, *step, 0).abs() / AMPLITUDE;
            let off = f64::from(half_periods) * turn * turn;
            let what = format!(
                "amplitude/{half_periods}-half-periods: amplitude after {half_periods} half periods over that at the start, 1"
            );
            figures.is(&what, found, each.powi(half_periods), off);
        }
    })
}

/// Two grains on top of each other between floor and ceiling: MFiX's test DEM03 (Garg et al. 2012,
/// Powder Technology 220:122–137), all contacts closed all the time. Two masses and three springs:
/// y = y_eq + Σ q_j e_j/√m with the modes of M^−½ K M^−½.
struct Stack {
    mass: [f64; 2],
    equilibrium: [f64; 2],
    omega: [f64; 2],
    /// Unit vectors in the coordinates √m·(y − y_eq).
    shape: [[f64; 2]; 2],
}

impl Stack {
    /// m.
    const RADIUS: f64 = 0.5e-3;
    /// Between floor and ceiling, m.
    const HEIGHT: f64 = 1.8e-3;
    /// Of all three contacts, N/m.
    const STIFFNESS: f64 = 1.0e3;
    /// Heights at the start, m.
    const START: [f64; 2] = [0.45e-3, 1.35e-3];
    /// s, and steps to 1 ms.
    const DT: f64 = 2.5e-7;
    const STEPS: u64 = 4000;

    fn new(mass: [f64; 2]) -> Self {
        let [m1, m2] = mass;
        let k = Self::STIFFNESS;
        // k[[2, −1], [−1, 2]] y = f, from the forces at y = 0.
        let f1 = -k * Self::RADIUS - m1 * GRAVITY;
        let f2 = k * Self::RADIUS + k * Self::HEIGHT - m2 * GRAVITY;
        let equilibrium = [(2.0 * f1 + f2) / (3.0 * k), (f1 + 2.0 * f2) / (3.0 * k)];
        let (a, d) = (2.0 * k / m1, 2.0 * k / m2);
        let c = -k / (m1 * m2).sqrt();
        let middle = 0.5 * (a + d);
        let apart = (0.5 * (a - d)).hypot(c);
        let (sin, cos) = (0.5 * (2.0 * c).atan2(a - d)).sin_cos();
        Stack {
            mass,
            equilibrium,
            omega: [(middle + apart).sqrt(), (middle - apart).sqrt()],
            shape: [[cos, sin], [-sin, cos]],
        }
    }

    /// Amplitudes of the modes at the start.
    fn amplitudes(&self) -> [f64; 2] {
        let off = [0, 1].map(|i| self.mass[i].sqrt() * (Self::START[i] - self.equilibrium[i]));
        self.shape.map(|e| e[0] * off[0] + e[1] * off[1])
    }

    /// Heights from the modes' coordinates.
    fn heights(&self, q: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| {
            let sum = q[0] * self.shape[0][i] + q[1] * self.shape[1][i];
            self.equilibrium[i] + sum / self.mass[i].sqrt()
        })
    }

    /// Speeds of the modes half a step before the start, for rest at the start: −½dt·a.
    fn speeds(&self) -> [f64; 2] {
        let amplitudes = self.amplitudes();
        [0, 1].map(|j| 0.5 * Self::DT * self.omega[j] * self.omega[j] * amplitudes[j])
    }

    /// Velocities of the grains half a step before the start.
    fn velocities(&self) -> [f64; 2] {
        let heights = self.heights(self.speeds());
        [0, 1].map(|i| heights[i] - self.equilibrium[i])
    }

    /// Heights after so many steps, by the exact solution of the discrete equations.
    fn stepped(&self, steps: u64) -> [f64; 2] {
        let (amplitudes, speeds) = (self.amplitudes(), self.speeds());
        self.heights([0, 1].map(|j| {
            let start = State::new(0, amplitudes[j], speeds[j]);
            SpringDashpot::oscillator(self.omega[j], Self::DT)
                .in_touch(&start, steps)
                .overlap
        }))
    }

    /// Heights at this time.
    fn at(&self, time: f64) -> [f64; 2] {
        let amplitudes = self.amplitudes();
        self.heights([0, 1].map(|j| amplitudes[j] * (self.omega[j] * time).cos()))
    }

    /// A bound of the steps' error at this time: each mode is ωt(ω dt)²/24 behind, to leading order.
    fn error(&self, time: f64) -> f64 {
        let amplitudes = self.amplitudes();
        let lightest = self.mass[0].min(self.mass[1]).sqrt();
        let lag = |j: usize| {
            let omega = self.omega[j];
            amplitudes[j].abs() / lightest * omega * time * (omega * Self::DT).powi(2) / 24.0
        };
        lag(0) + lag(1)
    }

    /// The energy that linear leapfrog conserves: with the product of the velocities of both half steps.
    fn energy(&self, at: &Snapshot) -> f64 {
        let mut force = self.mass.map(|mass| -mass * GRAVITY);
        let mut energy = 0.0;
        for contact in &at.contacts {
            for (id, sign) in [(contact.id1, -1.0), (contact.id2, 1.0)] {
                if let Some(force) = force.get_mut(id as usize) {
                    *force += sign * contact.force()[1];
                }
            }
            energy += 0.5 * contact.normal_force * contact.normal_force / Self::STIFFNESS;
        }
        let moving = self.mass.iter().zip(&at.bodies.vz).zip(&at.bodies.z);
        for (((mass, before), height), force) in moving.zip(force) {
            let after = before + Self::DT * force / mass;
            energy += 0.5 * mass * before * after + mass * GRAVITY * height;
        }
        energy
    }
}

fn stack() -> CaseGroup {
    const STEPS: u64 = Stack::STEPS;
    // The lower grain is twice as dense.
    let sphere = |i: usize, density| Grain::sphere([0.0, Stack::START[i]], Stack::RADIUS, density);
    let [lower, upper] = [sphere(0, 2.0e4), sphere(1, 1.0e4)];
    let stack = Stack::new([lower.mass, upper.mass]);
    let [down, up] = stack.velocities();
    let grains = [lower.moving([0.0, down]), upper.moving([0.0, up])];
    let law = suite::springs(Stack::STIFFNESS / Stack::RADIUS);
    let walls: [&[f64]; 2] = [&[], &[0.0, Stack::HEIGHT]];
    let model = suite::world(law, Stack::DT, [0.0, -GRAVITY], 0.0, walls);
    let case = suite::case("stack", model, &grains, vec![0, STEPS / 2, STEPS]);
    let title = "MFiX DEM03: two spheres between floor and ceiling swing in their two modes";
    CaseGroup::new("two-stacked-grains", title).with("", case, move |track, figures| {
        for steps in [STEPS / 2, STEPS] {
            let time = steps as f64 * Stack::DT;
            let (stepped, continuous) = (stack.stepped(steps), stack.at(time));
            for (id, kind) in ["lower", "upper"].into_iter().enumerate() {
                let found = at(track, steps).position(id)[1];
                let what = format!("{kind}/{steps}-steps: height of the {kind} grain after {steps} steps, m");
                figures.exact(&what, found, stepped[id], steps, Stack::HEIGHT);
                figures.because(
                    "the steps are behind by ωt(ω dt)²/24 in each mode, and all of it is allowed",
                );
                let off = stack.error(time) + rounding(steps, Stack::HEIGHT);
                let what = format!("{kind}/{steps}-steps-continuous: height of the {kind} grain at {time} s, m");
                figures.is(&what, found, continuous[id], off);
            }
        }
        let energy = |moment: usize| {
            let found = track.get(moment).map(|at| stack.energy(at));
            found.unwrap_or(f64::NAN)
        };
        let what = "energy: energy after 4000 steps over that at the start; ½m v_{n−½}v_{n+½} + ½ku² + mgz, 1";
        figures.exact(what, energy(2) / energy(0), 1.0, STEPS, 1.0);
    })
}

/// The tangential spring alone: a grain squeezed between floor and ceiling that slides or turns to and
/// fro without ever reaching the Coulomb limit.
mod squeezed {
    use super::*;

    /// At floor and ceiling, m.
    pub const OVERLAP: f64 = 1.0 / 64.0;
    /// Way, or angle times radius, m.
    pub const AMPLITUDE: f64 = 0.05;
    /// s.
    pub const DT: f64 = 0.1 / OMEGA;
    /// Steps to the moments that are looked at.
    pub const MOMENTS: [u64; 3] = [1, 137, 600];
    /// An id, and how the law becomes its own.
    type Way = (&'static str, fn(Law) -> Law);
    /// Corrected slip, and slip with arms at the contact point.
    pub const WAYS: [Way; 2] = [
        ("corrected-slip", |law| law),
        ("contact-point", suite::at_contact_point),
    ];
    /// k_s/k_n.
    const RATIO: f64 = 0.5;
    /// tan φ is 5.8: sliding would begin at a way of 0.18 m.
    const FRICTION_ANGLE: f64 = 1.4;

    pub fn grain() -> Grain {
        Grain::sphere([0.0, RADIUS - OVERLAP], RADIUS, DENSITY)
    }

    /// With this k_s, N/m.
    pub fn case(stiffness: f64, way: fn(Law) -> Law, rotation: Rotation, grain: Grain) -> Case {
        let modulus = stiffness / (RATIO * RADIUS);
        let mut law = way(suite::friction(modulus, RATIO, FRICTION_ANGLE));
        law.contact.rotation = rotation;
        let ceiling = 2.0 * (RADIUS - OVERLAP);
        let model = suite::world(law, DT, [0.0; 2], 0.0, [&[], &[0.0, ceiling]]);
        suite::case("squeezed", model, &[grain], MOMENTS.to_vec())
    }

    /// The swing, slack one step before the start: the contacts are new then and are given a whole step of slip.
    pub fn swing(speed: f64, step: u64) -> State {
        let start = State::new(0, DT * speed, speed);
        SpringDashpot::oscillator(OMEGA, DT).in_touch(&start, step)
    }
}

/// ω² = 2a k_s/m. The factor a of the slip is 2R/(2R − u) with the correction, else 1.
fn sliding_spring() -> CaseGroup {
    use squeezed::{AMPLITUDE, DT, MOMENTS, OVERLAP, WAYS};
    let velocity = AMPLITUDE * OMEGA;
    let factors = [2.0 * RADIUS / (2.0 * RADIUS - OVERLAP), 1.0];
    let title = "A squeezed grain that cannot turn swings sideways with ω² = 2k_s/m";
    let mut group = CaseGroup::new("tangential-spring", title);
    for ((id, way), factor) in WAYS.into_iter().zip(factors) {
        let grain = squeezed::grain().moving([velocity, 0.0]);
        let stiffness = grain.mass * OMEGA * OMEGA / (2.0 * factor);
        let case = squeezed::case(stiffness, way, Rotation::Blocked, grain);
        group = group.with(id, case, move |track, figures| {
            for n in MOMENTS {
                let (found, expected) = (at(track, n), squeezed::swing(velocity, n));
                let what = format!("way/{n}-steps, m");
                let way = expected.overlap - DT * velocity;
                figures.exact(&what, found.position(0)[0], way, n, AMPLITUDE);
                let what = format!("velocity/{n}-steps, m/s");
                let speed = found.velocity(0)[0];
                figures.exact(&what, speed, expected.approach, n, velocity);
            }
        });
    }
    group
}

/// Iω² = 2k_s R r with the corrected slip, which counts at the distance R, and the arm r = R − u/2;
/// 2k_s (R − u)² with both at the contact point.
fn turning_spring() -> CaseGroup {
    use squeezed::{AMPLITUDE, MOMENTS, OVERLAP, WAYS};
    let spin = AMPLITUDE * OMEGA / RADIUS;
    let squares = [
        RADIUS * (RADIUS - 0.5 * OVERLAP),
        (RADIUS - OVERLAP) * (RADIUS - OVERLAP),
    ];
    let title = "A squeezed grain turns to and fro with Iω² = 2k_s R r";
    let mut group = CaseGroup::new("turning-spring", title);
    for ((id, way), square) in WAYS.into_iter().zip(squares) {
        let grain = squeezed::grain().spinning(spin);
        let stiffness = grain.inertia * OMEGA * OMEGA / (2.0 * square);
        let case = squeezed::case(stiffness, way, Rotation::Free, grain);
        group = group.with(id, case, move |track, figures| {
            for n in MOMENTS {
                let what = format!("spin/{n}-steps, rad/s");
                let expected = squeezed::swing(spin, n).approach;
                figures.exact(&what, at(track, n).spin(0), expected, n, spin);
            }
            let way = at(track, MOMENTS[2]).position(0)[0];
            let what = "way-sideways, m";
            figures.exact(what, way, 0.0, MOMENTS[2], AMPLITUDE);
        });
    }
    group
}
