//! The paper's experiment as a scene, every choice that the paper leaves open named with its reason.

use std::collections::BTreeMap;

use super::*;

/// What the paper does not print, and why this project chose what it chose.
pub const OPEN_CHOICES: &[(&str, &str)] = &[
    (
        "/particles/mean_diameter",
        "never printed; R=0.005 m is the side of the control volume 'of side R'",
    ),
    (
        "/particles/shape",
        "called spherical, but the weights in Table 4 and V_c need discs one metre long",
    ),
    (
        "/material/stiffness_ratio",
        "k_s is not printed; without friction it has no effect",
    ),
    (
        "/contact",
        "'spring-dashpot' contacts without a number for the dashpot, so springs only; the rest is YADE's default",
    ),
    (
        "/damping",
        "'spring-dashpot' without a number; YADE's local damping at its default of 0.2",
    ),
    (
        "/cloud",
        "'randomly poured'; a jittered lattice is loose, free of overlap and quick to make",
    ),
    (
        "/time_step",
        "not printed; 0.45 of sqrt(m/k) of the mean grain is below the limit of a dense bed",
    ),
    (
        "/settle",
        "'almost completely dissipate'; 1e-4 of the peak was chosen because the mean surface of the first beds was then near the printed height",
    ),
    (
        "/loading/speed",
        "'gently'; at 0.05 m/s some realizations sink to the give-up depth, at 0.1 m/s the force is reached",
    ),
    (
        "/loading/punch_height",
        "the 'rigid body' has no printed size; tall enough that no grain gets on top",
    ),
    (
        "/loading/surface",
        "levelling is not mentioned, so the surface stays as it settled",
    ),
    (
        "/loading/after_force",
        "'until the force was equal to 2ap'; no hold is mentioned",
    ),
    (
        "/loading/give_up_depth",
        "a punch at the depth of the control points cannot load them",
    ),
    (
        "/measurement/surface_height",
        "height is not defined; the mean surface is what a ruler would read",
    ),
    (
        "/measurement/cell",
        "'the particle and the associated void space'; radical cells tile unequal discs",
    ),
    (
        "/measurement/local_radius",
        "not in the paper; two mean diameters reach about a dozen grains",
    ),
];

/// The paper's scene (Table 2, section 3) for one realization.
pub fn paper_scene(realization: u64, particles: u32) -> Scene {
    Scene {
        version: SCENE_VERSION,
        name: "paper".to_owned(),
        realization,
        particles: Particles {
            count: particles,
            mean_diameter: 0.01,
            dispersion: 0.05,
            shape: Shape::Disc,
        },
        material: Material {
            youngs_modulus: 1.0e10,
            density: 2600.0,
            friction_angle: 0.0,
            wall_friction_angle: None,
            punch_friction_angle: None,
            stiffness_ratio: 1.0,
        },
        contact: ContactLaw::default(),
        rules: Rules::default(),
        damping: Damping::Cundall { alpha: 0.2 },
        gravity: 9.81,
        container: Container { width: 1.0 },
        cloud: Cloud::JitteredLattice {
            columns: 80,
            jitter: 0.9,
            speed: 0.3,
            spin: 0.0,
            over: None,
        },
        time_step: TimeStep::Fraction {
            of_sqrt_m_over_k: 0.45,
        },
        settle: Settle {
            kinetic_energy_fraction: 1.0e-4,
            check_every: 1000,
            max_steps: 2_000_000,
        },
        loading: Loading {
            half_width: 0.0225,
            pressure: 44.4e3,
            speed: 0.1,
            punch_height: 0.3,
            surface: Surface::AsSettled,
            after_force: AfterForce::MeasureAtOnce,
            give_up_depth: 0.11,
            material: None,
            contact: None,
            damping: None,
        },
        measurement: Measurement {
            surface_height: SurfaceHeight::MeanSurface,
            cell: Cell::Radical,
            control_volume_side: 0.005,
            local_radius: 0.02,
            history_every: 250,
        },
        control_points: [("O", 0.0), ("A", 0.08), ("B", 0.15)]
            .into_iter()
            .map(|(name, offset)| ControlPoint {
                name: name.to_owned(),
                offset,
                depth: 0.11,
            })
            .collect(),
        choices: OPEN_CHOICES
            .iter()
            .map(|(key, reason)| ((*key).to_owned(), (*reason).to_owned()))
            .collect::<BTreeMap<_, _>>(),
    }
}
