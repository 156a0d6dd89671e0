//! Short words for making cases.

use std::f64::consts::PI;

use grains::model::{Axis, Law, Model, Wall};
use grains::scene::{ContactLaw, NewContactSlip, Rotation, SlipVelocity, TorqueArms, Viscosity};
use grains::tables::{Bodies, Punch};
use grains::task::Case;

/// One grain at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grain {
    /// Centre, m.
    pub position: [f64; 2],
    /// At the half step before the start, m/s.
    pub velocity: [f64; 2],
    /// rad/s, positive from z towards x.
    pub spin: f64,
    /// m.
    pub radius: f64,
    /// kg.
    pub mass: f64,
    /// kg·m².
    pub inertia: f64,
}

impl Grain {
    /// A disc one metre long of this density, at rest: m = ρπR², I = ½mR².
    pub fn disc(position: [f64; 2], radius: f64, density: f64) -> Self {
        let mass = density * PI * radius * radius;
        Grain {
            position,
            velocity: [0.0; 2],
            spin: 0.0,
            radius,
            mass,
            inertia: 0.5 * mass * radius * radius,
        }
    }

    /// A sphere of this density, at rest: m = ρ·4/3·πR³, I = 2/5 mR².
    pub fn sphere(position: [f64; 2], radius: f64, density: f64) -> Self {
        let mass = density * (4.0 / 3.0) * PI * radius * radius * radius;
        Grain {
            mass,
            inertia: 0.4 * mass * radius * radius,
            ..Grain::disc(position, radius, density)
        }
    }

    /// The same grain with its centre here, m.
    pub fn at(self, position: [f64; 2]) -> Self {
        Grain { position, ..self }
    }

    /// The same grain with this velocity, m/s.
    pub fn moving(self, velocity: [f64; 2]) -> Self {
        Grain { velocity, ..self }
    }

    /// The same grain with this spin, rad/s.
    pub fn spinning(self, spin: f64) -> Self {
        Grain { spin, ..self }
    }
}

/// A law with normal springs only.
pub fn springs(modulus: f64) -> Law {
    Law {
        modulus,
        stiffness_ratio: 1.0,
        friction_angle: 0.0,
        contact: ContactLaw::default(),
    }
}

/// A law with springs and friction of this angle (rad) and stiffness ratio k_s/k_n, grains free to spin,
/// YADE's default choices.
pub fn friction(modulus: f64, stiffness_ratio: f64, friction_angle: f64) -> Law {
    Law {
        stiffness_ratio,
        friction_angle,
        ..springs(modulus)
    }
}

/// The same law with slip and torque arms at the contact point.
pub fn at_contact_point(law: Law) -> Law {
    let contact = ContactLaw {
        slip_velocity: SlipVelocity::ContactPoint,
        torque_arms: TorqueArms::ContactPoint,
        ..law.contact
    };
    Law { contact, ..law }
}

/// The same law with these dashpots, contact point velocities and contact point arms: the form that
/// YADE's viscous law has.
pub fn with_viscosity(law: Law, viscosity: Viscosity) -> Law {
    Law {
        contact: ContactLaw {
            rotation: Rotation::Free,
            viscosity,
            slip_velocity: SlipVelocity::ContactPoint,
            torque_arms: TorqueArms::ContactPoint,
            new_contact_slip: NewContactSlip::WholeStep,
        },
        ..law
    }
}

/// A model without gravity, local damping and walls.
pub fn model(law: Law, dt: f64) -> Model {
    Model {
        gravity: [0.0; 2],
        alpha: 0.0,
        dt,
        walls: Vec::new(),
        law,
    }
}

/// A wall that holds this coordinate fixed at this place, m.
pub fn wall(axis: Axis, place: f64) -> Wall {
    Wall { axis, place }
}

/// The same under this gravity, with this α, and with walls that hold x and z at these places, m.
pub fn world(law: Law, dt: f64, gravity: [f64; 2], alpha: f64, [x, z]: [&[f64]; 2]) -> Model {
    let across = x.iter().map(|place| wall(Axis::X, *place));
    let up = z.iter().map(|place| wall(Axis::Z, *place));
    Model {
        gravity,
        alpha,
        walls: across.chain(up).collect(),
        ..model(law, dt)
    }
}

/// A case of these grains.
pub fn case(name: &str, model: Model, grains: &[Grain], moments: Vec<u64>) -> Case {
    let mut bodies = Bodies::with_capacity(grains.len());
    let rotates = model.law.rotates();
    for grain in grains {
        bodies.push(grain.position, grain.velocity, grain.radius, grain.mass);
        if rotates {
            bodies.spin.push(grain.spin);
            bodies.inertia.push(grain.inertia);
        }
    }
    Case {
        name: name.to_owned(),
        model,
        bodies,
        punch: None,
        moments,
    }
}

/// A punch with its bottom at this height, moving at this vertical velocity.
pub fn punch(axis: f64, bottom: f64, half_extents: [f64; 2], velocity: f64) -> Punch {
    Punch {
        centre: [axis, bottom + half_extents[1]],
        half_extents,
        start: bottom,
        velocity,
        force: 0.0,
    }
}
