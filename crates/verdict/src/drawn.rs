//! Laws whose every key is drawn: what is right for each value alone may be wrong for two together. And spins of all sizes.

use evidence::random::Source;
use grains::scene::{
    ContactLaw, Material, NewContactSlip, Rolling, Rotation, SlipVelocity, Springs, Tension,
    TorqueArms, Viscosity,
};
use grains::tables::Bodies;

/// φ, rad, k_s/k_n and e_n of drawn laws, the smallest first and the largest last.
pub const ANGLES: [f64; 4] = [0.0, 0.1, 0.5, 1.0];
pub const RATIOS: [f64; 4] = [0.05, 0.5, 1.0, 2.5];
pub const RESTITUTIONS: [f64; 3] = [0.1, 0.4, 0.9];
/// Moments in space.
pub(crate) const ROLLING: Rolling = Rolling {
    bending_stiffness: Some(0.1),
    twisting_stiffness: 0.08,
    limit: Some(0.1),
};
/// J/m²; the pull is a few weights of a grain.
pub(crate) const ADHESION: f64 = 2.0;

/// One of these.
pub(crate) fn drawn<T: Clone, const N: usize>(source: &mut Source, choices: [T; N]) -> T {
    choices[source.below(N)].clone()
}

/// Of a scene that has this one.
pub(crate) fn drawn_material(source: &mut Source, material: &Material) -> Material {
    let aside = [None, None, Some(0.0), Some(0.3), Some(1.1)];
    Material {
        youngs_modulus: material.youngs_modulus * drawn(source, [0.5, 1.0]),
        friction_angle: drawn(source, ANGLES),
        wall_friction_angle: drawn(source, aside),
        punch_friction_angle: drawn(source, aside),
        stiffness_ratio: drawn(source, RATIOS),
        ..material.clone()
    }
}

/// In the plane.
pub(crate) fn drawn_contact(source: &mut Source) -> ContactLaw {
    let tension = drawn(source, [Tension::Clipped, Tension::Unclipped]);
    let e_n = drawn(source, RESTITUTIONS);
    let c_n = drawn(source, [100.0, 900.0]);
    ContactLaw {
        rotation: drawn(
            source,
            [
                Rotation::Free,
                Rotation::Free,
                Rotation::Free,
                Rotation::Blocked,
            ],
        ),
        viscosity: drawn(
            source,
            [
                Viscosity::None,
                Viscosity::None,
                Viscosity::Dashpot { c_n, tension },
                Viscosity::Restitution { e_n, tension },
            ],
        ),
        slip_velocity: drawn(
            source,
            [
                SlipVelocity::RatchetingCorrected,
                SlipVelocity::ContactPoint,
            ],
        ),
        torque_arms: drawn(source, [TorqueArms::HalfOverlap, TorqueArms::ContactPoint]),
        new_contact_slip: drawn(
            source,
            [NewContactSlip::WholeStep, NewContactSlip::SinceTouch],
        ),
        ..ContactLaw::default()
    }
}

/// Kinds of springs, of dashpots and of what these may pull, together.
pub(crate) const COMBINATIONS: usize = 3 * 2 * 2;

/// In space, with one of the combinations of these; all else is drawn.
pub(crate) fn contact_in_space(source: &mut Source, combination: usize) -> ContactLaw {
    let tension = [Tension::Clipped, Tension::Unclipped][combination / 3 % 2];
    let springs = [Springs::HertzMindlin, Springs::Linear][combination / 6 % 2];
    let e_n = drawn(source, RESTITUTIONS);
    let restitution = Viscosity::Restitution { e_n, tension };
    let free = [Rotation::Free, Rotation::Free, Rotation::Blocked];
    let slip = [
        SlipVelocity::RatchetingCorrected,
        SlipVelocity::ContactPoint,
    ];
    let arms = [TorqueArms::HalfOverlap, TorqueArms::ContactPoint];
    let new = [NewContactSlip::WholeStep, NewContactSlip::SinceTouch];
    let mut contact = ContactLaw {
        rotation: drawn(source, free),
        slip_velocity: drawn(source, slip),
        torque_arms: drawn(source, arms),
        new_contact_slip: drawn(source, new),
        springs,
        ..ContactLaw::default()
    };
    let stiffer = drawn(source, [0.1, 1.0, 3.0]);
    let rolling = Rolling {
        bending_stiffness: ROLLING
            .bending_stiffness
            .map(|stiffness| stiffness * stiffer),
        twisting_stiffness: ROLLING.twisting_stiffness * drawn(source, [0.1, 1.0, 3.0]),
        limit: drawn(source, [None, Some(0.03), ROLLING.limit, Some(0.5)]),
    };
    contact.rolling = drawn(source, [None, Some(rolling)]);
    if contact.springs == Springs::Linear {
        let c_n = drawn(source, [0.3, 1.5]);
        let dashpot = Viscosity::Dashpot { c_n, tension };
        contact.viscosity = [dashpot, restitution, Viscosity::None][combination % 3].clone();
        return contact;
    }
    let ratio = drawn(source, [0.02, 0.2, 0.7]);
    let ratio = Viscosity::Ratio { ratio, tension };
    contact.viscosity = [ratio, restitution, Viscosity::None][combination % 3].clone();
    contact.tangential_viscosity = drawn(source, [None, Some(0.1), Some(0.9)]);
    let adhesion = ADHESION * drawn(source, [0.1, 1.0, 3.0]);
    contact.adhesion = drawn(source, [None, Some(adhesion)]);
    contact
}

/// Gives grains spins of all sizes about all axes that they have.
pub(crate) fn spin(bodies: &mut Bodies, largest: f64) {
    let columns = [&mut bodies.spin, &mut bodies.spin_x, &mut bodies.spin_z];
    for (axis, column) in columns.into_iter().enumerate() {
        let frequency = 1.7 + 0.6 * axis as f64;
        let spins = column.iter_mut().enumerate();
        spins.for_each(|(id, spin)| *spin = largest * (frequency * id as f64).sin());
    }
}
