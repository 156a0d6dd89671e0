//! The scene: its types here, the paper's own, validation and the JSON Schema. Depends on nothing that comes after it.

pub mod check;
mod fill;
pub mod paper_scene;
pub mod problem;

pub use check::{SceneError, parse_scene, parse_scene_with};
pub use paper_scene::{open_choices, paper_scene};
pub use problem::Problem;

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::obstacle::Obstacle;
use crate::rules::Rules;
use crate::tables::Stage;

/// The JSON Schema of a scene file, generated from the types; what has a default may be left out.
pub fn json_schema() -> serde_json::Value {
    let mut schema = whole_schema();
    fill::relax(&mut schema);
    schema
}

/// The schema of a scene with everything in it.
fn whole_schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}

/// The scene format that this program reads and writes.
pub const SCENE_VERSION: u32 = 1;

/// A complete experiment: grains, contact law, box, pouring, loading and what is measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Format version of this file.
    pub version: u32,
    /// A name for people; has no effect on the run.
    pub name: String,
    /// Realization number: selects the random stream of the initial cloud.
    pub realization: u64,
    /// The grains.
    pub particles: Particles,
    /// What grains, walls and punch are made of.
    pub material: Material,
    /// What happens at a contact besides its normal spring. Left out, it is what YADE does by default.
    #[serde(default)]
    pub contact: ContactLaw,
    /// Conventions of the step and the law, where they are not this program's.
    #[serde(default, skip_serializing_if = "Rules::are_usual")]
    pub rules: Rules,
    /// What takes energy out besides contacts.
    pub damping: Damping,
    /// Gravitational acceleration, m/s², acting along −z.
    #[schemars(range(min = 0.0))]
    pub gravity: f64,
    /// The box.
    #[serde(rename = "box")]
    pub container: Container,
    /// How the grains start.
    pub cloud: Cloud,
    /// The time step.
    pub time_step: TimeStep,
    /// When pouring ends.
    pub settle: Settle,
    /// The punch and when loading ends.
    pub loading: Loading,
    /// How the bed is measured.
    pub measurement: Measurement,
    /// Bodies at rest that spheres in space run against besides box and punch, at most 5,000. The cloud starts above them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// STL files whose triangles follow the obstacles; a run's record has the triangles instead.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    /// Where the grain stress is read, relative to the punch axis and the settled surface.
    pub control_points: Vec<ControlPoint>,
    /// One line of reason for each choice that the paper leaves open, by JSON pointer; none at all where it is not
    /// the paper that is reproduced.
    pub choices: BTreeMap<String, String>,
}

/// Triangles of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// The STL file, text or binary, from the folder of the scene on.
    pub path: String,
    /// What its numbers are multiplied by, to m.
    #[serde(default = "unscaled")]
    pub scale: f64,
    /// Where its origin is put, m: x, y, z.
    #[serde(default)]
    pub shift: [f64; 3],
}

fn unscaled() -> f64 {
    1.0
}

/// Grain sizes and shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Particles {
    /// Number of grains.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: u32,
    /// Mean diameter D, m.
    pub mean_diameter: f64,
    /// Half-width of the uniform size distribution over the mean, ΔD/D.
    pub dispersion: f64,
    /// What a grain's mass is computed from.
    pub shape: Shape,
}

/// What a grain's mass is computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A cylinder one metre long: m = ρπR²·1 m.
    Disc,
    /// A ball whose centre stays in the plane: m = ρ·4/3·πR³.
    Sphere,
}

/// Elasticity, density and friction of grains, walls and punch alike.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus E, Pa; enters Eq. 4 of the paper.
    pub youngs_modulus: f64,
    /// Density of the solid ρ_s, kg/m³.
    pub density: f64,
    /// Interparticle friction angle φ in [0, π/2), rad.
    pub friction_angle: f64,
    /// Friction angle of grains on floor and walls, rad; left out, that between grains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub wall_friction_angle: Option<f64>,
    /// Of grains on the punch likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub punch_friction_angle: Option<f64>,
    /// Tangential over normal stiffness of linear springs, k_s/k_n. Has no effect without friction.
    pub stiffness_ratio: f64,
    /// Poisson's ratio ν of Hertz's springs, in [0, 0.5].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub poissons_ratio: Option<f64>,
}

/// What takes energy out besides contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Damping {
    /// Local damping: each component of the acceleration, gravity included, is scaled by
    /// 1 − α·sign(a·v).
    Cundall {
        /// Damping number α in [0, 1).
        alpha: f64,
    },
}

impl Damping {
    /// The damping number α.
    pub fn alpha(&self) -> f64 {
        match self {
            Damping::Cundall { alpha } => *alpha,
        }
    }
}

/// The box: floor at z=0, walls at x=0 and x=width, open above.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Container {
    /// Inner width L, m.
    pub width: f64,
    /// Inner depth, m, between walls at y=0 and y=depth: given, the grains are spheres in space; left out, all is in the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub depth: Option<f64>,
}

/// The loose cloud that is poured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Cloud {
    /// One grain a square lattice cell, moved off the cell's centre and given a velocity at random.
    JitteredLattice {
        /// Cells across the box.
        #[schemars(range(min = 1, max = 100_000))]
        columns: u32,
        /// Largest move off the centre, as a share of the free play of the largest grain in its cell, in [0, 1].
        jitter: f64,
        /// Each velocity component is uniform in ±speed, m/s.
        speed: f64,
        /// Each spin is uniform in ±spin, rad/s, where grains rotate in pouring.
        #[serde(default)]
        spin: f64,
        /// From where to where the cells stand, m; left out, over the whole width of the box.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        over: Option<[f64; 2]>,
    },
}

/// The time step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum TimeStep {
    /// dt = fraction·√(m/k) of the mean grain, with m its mass and k = E·R.
    Fraction { of_sqrt_m_over_k: f64 },
    /// dt in seconds.
    Absolute { seconds: f64 },
}

/// When the poured bed counts as settled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Settle {
    /// Settled when the kinetic energy has fallen to this share of the largest value that the rule has seen.
    pub kinetic_energy_fraction: f64,
    /// The rule is looked at every so many steps.
    #[schemars(range(min = 1, max = 1_000_000_000u64))]
    pub check_every: u64,
    /// Give up, and say so, after so many steps.
    #[schemars(range(min = 1, max = 1_000_000_000u64))]
    pub max_steps: u64,
}

/// The rigid punch that presses on the surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// Half-width a of the punch, m.
    pub half_width: f64,
    /// Surface load p, Pa. The punch stops at the vertical force 2ap (per metre of depth), N.
    pub pressure: f64,
    /// Downward speed of the punch, m/s, kept constant.
    pub speed: f64,
    /// Height of the punch, m; more than the give-up depth, so that no grain gets on top of it.
    pub punch_height: f64,
    /// What the surface is like when the punch arrives.
    pub surface: Surface,
    /// What happens once the force is reached.
    pub after_force: AfterForce,
    /// Loading ends without the force when the punch has gone this deep, m.
    pub give_up_depth: f64,
    /// The material from the first step of loading on, of the same density; left out, that of pouring. Contacts of the
    /// settled bed keep their shear forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Material")]
    pub material: Option<Material>,
    /// The contact law likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "ContactLaw")]
    pub contact: Option<ContactLaw>,
    /// Damping likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Damping")]
    pub damping: Option<Damping>,
}

/// What is done to the surface before loading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// Left as it settled; the punch starts at the highest grain below it.
    AsSettled,
}

/// What follows the moment at which the force is reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum AfterForce {
    /// The run ends with the first step at which the force is at least 2ap.
    MeasureAtOnce,
    /// With that step the punch stands still, and the run ends when it has stood so long, whatever the force is then.
    StandStill {
        /// s.
        seconds: f64,
    },
}

/// How the bed is measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// The surface that depths are counted from.
    pub surface_height: SurfaceHeight,
    /// Which volume V_p belongs to a grain.
    pub cell: Cell,
    /// Side of the square control volume V_c (section 3.2.3), m.
    pub control_volume_side: f64,
    /// Grains with centres this near to a control point make up the local mean stress, m.
    pub local_radius: f64,
    /// A row of history every so many steps.
    #[schemars(range(min = 1, max = 1_000_000_000u64))]
    pub history_every: u64,
}

/// The definitions of the bed's height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceHeight {
    /// The top of the highest grain.
    HighestGrain,
    /// The mean over columns one mean diameter wide of the highest grain top.
    MeanSurface,
    /// Twice the height of the centre of mass.
    TwiceCentreOfMass,
}

/// The volume that belongs to a grain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Cell {
    /// The radical (power) Voronoi cell.
    Radical,
    /// The same share of void for every grain: its area over the solid share of all radical cells.
    EqualPorosity,
}

/// A place at which the stress of the nearest grain is read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControlPoint {
    /// What the point is called, `O` in the paper.
    pub name: String,
    /// Horizontal distance from the punch axis, m.
    pub offset: f64,
    /// Depth below the settled surface, m.
    pub depth: f64,
}

impl Scene {
    /// The scene with the constants of this stage throughout: those of loading in place of those of pouring. The time step is
    /// pouring's.
    pub fn in_stage(&self, stage: Stage) -> Cow<'_, Scene> {
        if stage == Stage::Settle || !self.has_stages() {
            return Cow::Borrowed(self);
        }
        let mut scene = self.clone();
        scene.time_step = TimeStep::Absolute {
            seconds: self.time_step_seconds(),
        };
        scene.material = scene.loading.material.take().unwrap_or(scene.material);
        scene.contact = scene.loading.contact.take().unwrap_or(scene.contact);
        scene.damping = scene.loading.damping.take().unwrap_or(scene.damping);
        Cow::Owned(scene)
    }

    /// Whether pouring is the same: all but the load, what is measured, and words.
    pub fn pours_like(&self, other: &Scene) -> bool {
        let mut measurement = self.measurement.clone();
        measurement.history_every = other.measurement.history_every;
        let other = Scene {
            loading: self.loading.clone(),
            control_points: self.control_points.clone(),
            measurement,
            ..other.clone()
        };
        self.digest() == other.digest()
    }

    /// Whether loading has constants of its own.
    pub fn has_stages(&self) -> bool {
        let loading = &self.loading;
        loading.material.is_some() || loading.contact.is_some() || loading.damping.is_some()
    }

    /// The stages with constants of their own.
    pub fn stages(&self) -> impl Iterator<Item = Stage> {
        let loading = self.has_stages().then_some(Stage::Load);
        std::iter::once(Stage::Settle).chain(loading)
    }

    /// dt in seconds. For a fraction: dt = f·√(m/k) with m and k = E·R of the mean grain.
    pub fn time_step_seconds(&self) -> f64 {
        match self.time_step {
            TimeStep::Absolute { seconds } => seconds,
            TimeStep::Fraction { of_sqrt_m_over_k } => {
                let radius = 0.5 * self.particles.mean_diameter;
                let stiffness = self.material.youngs_modulus * radius;
                of_sqrt_m_over_k * (self.grain_mass(radius) / stiffness).sqrt()
            }
        }
    }

    /// Mass of a grain of this radius, kg.
    pub fn grain_mass(&self, radius: f64) -> f64 {
        let density = self.material.density;
        match self.particles.shape {
            Shape::Disc => density * std::f64::consts::PI * radius * radius,
            Shape::Sphere => {
                density * (4.0 / 3.0) * std::f64::consts::PI * radius * radius * radius
            }
        }
    }

    /// Moment of inertia about the centre of a grain of this radius and mass, kg·m²: ½mR² of a disc, 2/5 mR²
    /// of a sphere.
    pub fn grain_inertia(&self, radius: f64, mass: f64) -> f64 {
        let share = match self.particles.shape {
            Shape::Disc => 0.5,
            Shape::Sphere => 0.4,
        };
        share * mass * radius * radius
    }

    /// Whether grains are spheres in space.
    pub fn in_space(&self) -> bool {
        self.container.depth.is_some()
    }

    /// The vertical force 2ap at which the punch stops, per metre of depth or on all of it in space, N.
    pub fn target_force(&self) -> f64 {
        let depth = self.container.depth.unwrap_or(1.0);
        2.0 * self.loading.half_width * self.loading.pressure * depth
    }

    /// Steps that the punch stands still once the force is reached; none where the bed is measured at once.
    pub fn steps_standing_still(&self) -> Option<u64> {
        match self.loading.after_force {
            AfterForce::MeasureAtOnce => None,
            AfterForce::StandStill { seconds } => {
                Some(((seconds / self.time_step_seconds()).round() as u64).max(1))
            }
        }
    }

    /// x of the punch axis: the middle of the box, m.
    pub fn punch_axis(&self) -> f64 {
        0.5 * self.container.width
    }

    /// SHA-256 of the canonical JSON of all that a run depends on, in hexadecimal: the name and the
    /// reasons are left out, and keys that came later where they have the value that older scenes
    /// mean, so that a scene keeps its digest.
    pub fn digest(&self) -> String {
        let physics = Scene {
            name: String::new(),
            choices: BTreeMap::new(),
            ..self.clone()
        };
        let Cloud::JitteredLattice { spin, .. } = self.cloud;
        let mut value = physics.json();
        let mut forget = |place: &str, key: &str| {
            let object = value.pointer_mut(place).and_then(|at| at.as_object_mut());
            object.and_then(|object| object.shift_remove(key));
        };
        if self.contact == ContactLaw::default() {
            forget("", "contact");
        }
        if spin == 0.0 {
            forget("/cloud", "spin");
        }
        crate::tables::sha256_hex(value.to_string().as_bytes())
    }
}

/// What happens at a contact besides its normal spring: the choices that YADE makes are the default.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactLaw {
    /// Whether friction turns grains.
    pub rotation: Rotation,
    /// Dashpots beside the normal springs.
    pub viscosity: Viscosity,
    /// Which velocity counts as slip.
    pub slip_velocity: SlipVelocity,
    /// Where the contact force acts on a grain.
    pub torque_arms: TorqueArms,
    /// How much of the first step's slip a new contact is given.
    pub new_contact_slip: NewContactSlip,
    /// How stiff a contact is; any but linear springs are for grains in space.
    #[serde(default, skip_serializing_if = "Springs::are_linear")]
    pub springs: Springs,
    /// Of dashpots along the tangent what `viscosity` says of those along the normal, a restitution or a damping ratio; left
    /// out, the same. For Hertz's springs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub tangential_viscosity: Option<f64>,
    /// Resistance to rolling and twisting, in space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Rolling")]
    pub rolling: Option<Rolling>,
    /// Surface energy γ of adhesion beside Hertz's springs, J/m².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub adhesion: Option<f64>,
    /// The law that γ is of.
    #[serde(default, skip_serializing_if = "AdhesionLaw::is_pull")]
    pub adhesion_law: AdhesionLaw,
}

/// What adhesion does beside Hertz's springs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AdhesionLaw {
    /// A pull A = 4πR*γ as long as the surfaces touch; Coulomb's limit is that of |N| + A.
    #[default]
    Pull,
    /// Derjaguin, Muller and Toporov: the same pull; Coulomb's limit is that of |N + 2A|.
    Dmt,
    /// Johnson, Kendall and Roberts: the contact's radius grows with γ, and it ends at the pull A = 3πR*γ.
    Jkr,
}

impl AdhesionLaw {
    pub(crate) fn is_pull(&self) -> bool {
        *self == AdhesionLaw::Pull
    }
}

/// How stiff a contact is along the normal and the tangent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Springs {
    /// k_n by Eq. 4 of the paper and k_s = k_n·(k_s/k_n).
    #[default]
    Linear,
    /// F_n = 4/3 E* √R* u^1.5 (Hertz) and k_s = 8 G* √(R* u) (Mindlin), which adds to a tangential force that is kept.
    HertzMindlin,
}

impl Springs {
    pub(crate) fn are_linear(&self) -> bool {
        *self == Springs::Linear
    }
}

/// Moments against rolling and twisting. Elastic ones add up from step to step and turn with the contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rolling {
    /// Moment for each radian of rolling, N·m/rad; left out, the moment is always the largest, a constant torque.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub bending_stiffness: Option<f64>,
    /// The same of twisting, N·m/rad, without a limit.
    pub twisting_stiffness: f64,
    /// η of the largest moment against rolling, |N| η (R_1 + R_2)/2; left out, there is no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub limit: Option<f64>,
}

impl Rolling {
    /// Whether rolling meets a torque that does not depend on how far grains have rolled.
    pub fn is_constant(&self) -> bool {
        self.bending_stiffness.is_none()
    }
}

/// Whether friction turns grains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rotation {
    /// Grains spin about the axis across the plane.
    #[default]
    Free,
    /// Grains keep the spin zero.
    Blocked,
}

/// Dashpots beside the normal springs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Viscosity {
    /// Springs only.
    #[default]
    None,
    /// The same damping constant at every contact: F_n = k_n u_n + c_n du_n/dt.
    Dashpot {
        /// c_n, N·s/m.
        c_n: f64,
        /// Whether the dashpot may pull.
        tension: Tension,
    },
    /// At each contact the damping constant that gives its pair this restitution.
    Restitution {
        /// Rebound speed over approach speed, in (0, 1].
        e_n: f64,
        /// Whether the dashpot may pull.
        tension: Tension,
    },
    /// At each contact the damping constant c_n = 2β√(m_eff k_n).
    Ratio {
        /// β.
        ratio: f64,
        /// Whether the dashpot may pull.
        tension: Tension,
    },
}

impl Viscosity {
    /// Of one constant, N·s/m.
    pub fn dashpot(c_n: f64, tension: Tension) -> Self {
        Viscosity::Dashpot { c_n, tension }
    }

    /// Of one restitution.
    pub fn restitution(e_n: f64, tension: Tension) -> Self {
        Viscosity::Restitution { e_n, tension }
    }

    /// Whether its dashpots may pull.
    pub fn tension(&self) -> Tension {
        match self {
            Viscosity::None => Tension::Clipped,
            Viscosity::Dashpot { tension, .. }
            | Viscosity::Restitution { tension, .. }
            | Viscosity::Ratio { tension, .. } => *tension,
        }
    }

    /// Takes the other choice of the two.
    pub(crate) fn clip_otherwise(&mut self) {
        if let Viscosity::Dashpot { tension, .. }
        | Viscosity::Restitution { tension, .. }
        | Viscosity::Ratio { tension, .. } = self
        {
            *tension = tension.other();
        }
    }
}

/// Whether a dashpot may pull.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tension {
    /// The normal force is never less than zero.
    Clipped,
    /// It pulls until the grains have parted.
    Unclipped,
}

impl Tension {
    /// The other choice.
    pub(crate) fn other(self) -> Self {
        match self {
            Tension::Clipped => Tension::Unclipped,
            Tension::Unclipped => Tension::Clipped,
        }
    }
}

/// Which velocity counts as slip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SlipVelocity {
    /// That of the surfaces of the undeformed grains, so that a cycle of rolling under changing overlap
    /// leaves no displacement; at the outside of the punch, as in YADE, that of the contact point.
    #[default]
    RatchetingCorrected,
    /// That of the two bodies at the contact point.
    ContactPoint,
}

impl SlipVelocity {
    /// The other choice.
    pub(crate) fn other(self) -> Self {
        match self {
            SlipVelocity::RatchetingCorrected => SlipVelocity::ContactPoint,
            SlipVelocity::ContactPoint => SlipVelocity::RatchetingCorrected,
        }
    }
}

/// Where the contact force acts on a grain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TorqueArms {
    /// At the distance R − u_n/2 from the centre, at walls too.
    #[default]
    HalfOverlap,
    /// At the contact point: at a wall, R − u_n.
    ContactPoint,
}

impl TorqueArms {
    /// The other choice.
    pub(crate) fn other(self) -> Self {
        match self {
            TorqueArms::HalfOverlap => TorqueArms::ContactPoint,
            TorqueArms::ContactPoint => TorqueArms::HalfOverlap,
        }
    }
}

/// How much of the first step's slip a new contact is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NewContactSlip {
    /// The slip of the whole step, though the grains met during it.
    #[default]
    WholeStep,
    /// The slip since they met: overlap over approach speed, a step at most.
    SinceTouch,
}
