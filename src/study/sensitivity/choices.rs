//! The choices that the paper leaves open, and how a scene is moved along each of them.

use serde::{Deserialize, Serialize};

use crate::study::tradeoff::method::with_cloud;
use grains::scene::{AfterForce, Cloud, Scene, Shape};

/// A choice that is varied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The punch's speed crossed with the damping number.
    SpeedAndDamping,
    /// When the bed counts as settled.
    Settle,
    /// Friction between grains, crossed with the punch's speed.
    Friction,
    /// Disc or sphere.
    Shape,
    /// The mean diameter at the same number of grains, so that the bed's area changes.
    Diameter,
    /// The mean diameter with as many grains as keep the bed's area.
    DiameterSameArea,
    /// How long the punch stands still after the force is reached.
    Hold,
    /// Columns of the cloud: how loosely it is thrown in.
    CloudColumns,
    /// Speed of the cloud's grains.
    CloudSpeed,
    /// Number of grains, and so depth.
    Grains,
    /// Width of the box at the same depth.
    Width,
    /// The time step.
    TimeStep,
    /// Several choices at once, taken because their parts looked best, on clouds of their own.
    Combined,
}

impl Axis {
    /// In the order of pages.
    pub const ALL: [Axis; 13] = [
        Axis::SpeedAndDamping,
        Axis::Settle,
        Axis::Friction,
        Axis::Shape,
        Axis::Diameter,
        Axis::DiameterSameArea,
        Axis::Hold,
        Axis::CloudColumns,
        Axis::CloudSpeed,
        Axis::Grains,
        Axis::Width,
        Axis::TimeStep,
        Axis::Combined,
    ];

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Axis::SpeedAndDamping => "punch speed and damping",
            Axis::Settle => "settle rule",
            Axis::Friction => "friction",
            Axis::Shape => "grain mass",
            Axis::Diameter => "mean diameter, same number of grains",
            Axis::DiameterSameArea => "mean diameter, same area of grains",
            Axis::Hold => "hold after the force",
            Axis::CloudColumns => "cloud, columns",
            Axis::CloudSpeed => "cloud, speed",
            Axis::Grains => "number of grains",
            Axis::Width => "box width",
            Axis::TimeStep => "time step",
            Axis::Combined => "combined",
        }
    }

    /// What the paper says, and why the range is what it is.
    pub fn why(self) -> &'static str {
        match self {
            Axis::SpeedAndDamping => {
                "'gently' and 'spring-dashpot' without numbers; from where punches sink to where the force is an impact, \
                 and from hardly damped to YADE's examples of quasi-static runs. Damping is that of pouring and loading"
            }
            Axis::Settle => {
                "'almost completely dissipate'; kinetic energy over its peak, from visible motion to deep rest"
            }
            Axis::Friction => {
                "Table 2 prints zero; friction angle in rad, to 0.6 rad = 34 degrees, a sand's. A friction coefficient is \
                 its tangent. In a box half as wide, as steps with friction cost twenty times as much"
            }
            Axis::Shape => {
                "'spherical' particles, but weights of discs one metre long. Spheres in a box half as wide: their steps are shorter"
            }
            Axis::Diameter | Axis::DiameterSameArea => {
                "never printed; R = 5 mm follows from the control volume alone"
            }
            Axis::Hold => "'until the force was equal to 2ap'; a hold is not mentioned",
            Axis::CloudColumns | Axis::CloudSpeed => "'randomly poured'",
            Axis::Grains => "5,000 is printed; shows what the floor does",
            Axis::Width => "1 m is printed; shows what the walls do",
            Axis::TimeStep => "not printed; in units of sqrt(m/k)",
            Axis::Combined => "whether all figures come out at once",
        }
    }
}

/// The scene with another speed of the punch, m/s.
pub fn with_speed(mut scene: Scene, speed: f64) -> Scene {
    scene.loading.speed = speed;
    scene
}

/// The scene with another friction angle, rad.
pub fn with_friction(mut scene: Scene, angle: f64) -> Scene {
    scene.material.friction_angle = angle;
    scene
}

/// The scene with the punch standing still for so long after the force, s.
pub fn with_hold(mut scene: Scene, seconds: f64) -> Scene {
    scene.loading.after_force = AfterForce::StandStill { seconds };
    scene
}

/// The scene with grains of the mass of spheres.
pub fn with_spheres(mut scene: Scene) -> Scene {
    scene.particles.shape = Shape::Sphere;
    scene
}

/// The scene with another mean diameter, m, in a cloud that is as loose, with as many grains or with the same area of
/// them.
pub fn with_diameter(scene: Scene, diameter: f64, same_area: bool) -> Scene {
    let ratio = scene.particles.mean_diameter / diameter;
    let Cloud::JitteredLattice { columns, speed, .. } = scene.cloud;
    let columns = (f64::from(columns) * ratio).floor().max(1.0) as u32;
    let mut scene = with_cloud(scene, columns, speed);
    scene.particles.mean_diameter = diameter;
    if same_area {
        let count = f64::from(scene.particles.count) * ratio * ratio;
        scene.particles.count = count.round() as u32;
    }
    scene
}

/// The scene with other columns of the cloud.
pub fn with_columns(scene: Scene, columns: u32) -> Scene {
    let Cloud::JitteredLattice { speed, .. } = scene.cloud;
    with_cloud(scene, columns, speed)
}

/// The scene with another speed of the cloud's grains, m/s.
pub fn with_cloud_speed(scene: Scene, speed: f64) -> Scene {
    let Cloud::JitteredLattice { columns, .. } = scene.cloud;
    with_cloud(scene, columns, speed)
}
