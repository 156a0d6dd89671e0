//! The states that an engine starts from when it is judged: those of a user's scene, or one bed of the paper's grains at four
//! times of its life under four contact laws, and again with other constants and choices, so that a key that is not read shows.
//! They are cases of at most a hundred steps: rounding has not grown yet, every mistake shows already.

use grains::generate::{can_turn, initial_bodies};
use grains::model::{Axis, Law, Model, Wall, rotates};
use grains::native::{self, NativeError, first_contact_punch};
use grains::rules::Rules;
use grains::scene::{
    AdhesionLaw, AfterForce, Cloud, ContactLaw, Damping, Material, NewContactSlip, Rotation, Scene,
    SlipVelocity, Springs, Tension, TimeStep, TorqueArms, Viscosity, paper_scene,
};
use grains::tables::{Bodies, Punch, Snapshot, Stage};
use grains::task::{Case, Observer, Seen, Task};
use grains::with_rows;
use serde::Serialize;

use evidence::random::Source;

use crate::contacts::at_a_corner;
use crate::drawn::{
    ADHESION, COMBINATIONS, ROLLING, contact_in_space, drawn, drawn_contact, drawn_material, spin,
};
use crate::excerpt::{Excerpt, STEPS_OF_EXCERPT};
use crate::judge::NotAsked;
use crate::spheres::{adhesive, obstacles_of_scene};

/// The steps after which an engine is looked at; its contacts at the start as well.
pub const MOMENTS: [u64; 6] = [0, 1, 3, 10, 30, 100];

/// How much radii differ in the paper's scene, as a share of their mean.
pub const DISPERSION: f64 = 0.05;

with_rows! {
    /// A time in the life of a bed, in words and for identifiers.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "snake_case")]
    Start: (&'static str, &'static str) {
        /// Before anything has fallen far.
        Loose ("the loose cloud", "loose");
        /// Halfway down.
        Pouring ("pouring", "pouring");
        AtRest ("a bed at rest", "at-rest");
        UnderPunch ("a bed under the punch", "under-punch");
    }
}

impl Start {
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// For identifiers.
    pub fn key(self) -> &'static str {
        self.row().1
    }
}

with_rows! {
    /// A contact law that engines are asked for if they have its parts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "snake_case")]
    LawKind: &'static str {
        Springs "springs";
        /// Friction with history, grains that turn.
        Friction "friction";
        /// Springs and dashpots along the normal.
        Dashpots "dashpots";
        FrictionAndDashpots "friction-and-dashpots";
        /// Springs with no constant of the paper's: gravity, α, Δt, E, walls, masses and punch are others.
        OtherSprings "springs-with-other-constants";
        /// Friction of grains, walls and punch apart, with slip and arms at the contact point.
        OtherFriction "friction-with-other-constants";
        /// Friction of grains that do not turn.
        WithoutRotation "friction-without-rotation";
        /// Friction and dashpots that pull, new contacts given the slip since they touched.
        OtherDashpots "dashpots-with-other-choices";
    }
}

impl LawKind {
    pub fn name(self) -> &'static str {
        self.row()
    }

    /// Whether it stands for another value of each key.
    fn is_other(self) -> bool {
        use LawKind::{OtherDashpots, OtherFriction, OtherSprings, WithoutRotation};
        [OtherSprings, OtherFriction, WithoutRotation, OtherDashpots].contains(&self)
    }

    /// Changes what the paper's scene gives to other values.
    fn change(self, case: &mut Case) {
        let (model, bodies) = (&mut case.model, &mut case.bodies);
        if self == LawKind::OtherSprings {
            // A search of contacts that is made too seldom shows where grains are fast.
            for velocity in bodies.vx.iter_mut().chain(&mut bodies.vz) {
                *velocity *= FASTER;
            }
            other_constants(model, bodies, 1.0e-4);
            model.law.modulus *= 0.6;
            if let Some(punch) = &mut case.punch {
                punch.velocity *= 0.4;
                punch.half_extents[0] *= 0.98;
            }
        }
        if [LawKind::OtherSprings, LawKind::OtherFriction].contains(&self) {
            other_masses(bodies);
        }
    }

    fn of(self, scene: &Scene) -> Law {
        let mut law = Model::of(scene).law;
        let has = |one| [one, LawKind::FrictionAndDashpots].contains(&self);
        let rubs = [LawKind::WithoutRotation, LawKind::OtherDashpots];
        if has(LawKind::Friction) || rubs.contains(&self) {
            law.friction_angle = 0.5;
            law.stiffness_ratio = 0.3;
        }
        match self {
            LawKind::WithoutRotation => law.contact.rotation = Rotation::Blocked,
            LawKind::OtherFriction => {
                law.friction_angle = 0.4;
                law.wall_friction_angle = Some(0.2);
                law.punch_friction_angle = Some(0.7);
                law.stiffness_ratio = 0.6;
                law.contact.slip_velocity = SlipVelocity::ContactPoint;
                law.contact.torque_arms = TorqueArms::ContactPoint;
            }
            LawKind::OtherDashpots => {
                law.contact.viscosity = Viscosity::restitution(0.7, Tension::Unclipped);
                law.contact.new_contact_slip = NewContactSlip::SinceTouch;
            }
            _ => {}
        }
        if has(LawKind::Dashpots) {
            let radius = 0.5 * scene.particles.mean_diameter;
            let critical = 2.0 * (0.5 * scene.grain_mass(radius) * law.modulus * radius).sqrt();
            let tension = Tension::Clipped;
            // One of the two ways to say how strong a dashpot is under each law.
            law.contact.viscosity = match self {
                LawKind::Dashpots => Viscosity::dashpot(0.3 * critical, tension),
                _ => Viscosity::restitution(0.5, tension),
            };
            law.contact.rotation = Rotation::Free;
            law.contact.slip_velocity = SlipVelocity::ContactPoint;
            law.contact.torque_arms = TorqueArms::ContactPoint;
            law.contact.new_contact_slip = NewContactSlip::WholeStep;
        }
        law
    }
}

/// Gravity, damping, step and walls that are not those of the bed; walls stand this share of the smallest radius aside.
pub(crate) fn other_constants(model: &mut Model, bodies: &Bodies, share: f64) {
    model.gravity = [1.1, -3.7];
    model.alpha = 0.35;
    model.dt *= 0.8;
    let hair = share * bodies.radius.iter().copied().fold(f64::MAX, f64::min);
    for wall in &mut model.walls {
        wall.place += hair;
    }
    model.walls.reverse();
    let is_right = |wall: &&Wall| wall.axis == Axis::X && wall.place > hair;
    let right = model
        .walls
        .iter()
        .find(is_right)
        .map_or(0.0, |wall| wall.place);
    // One more before the right wall, so that a number of walls that is taken for granted shows, and a ceiling on the highest grain,
    // for walls are felt from both sides.
    model.walls.push(Wall::at(Axis::X, right - hair));
    model.walls.push(Wall::at(Axis::Z, highest(bodies) - hair));
}

/// Of the top of a grain, m.
pub(crate) fn highest(bodies: &Bodies) -> f64 {
    let tops = bodies.z.iter().zip(&bodies.radius);
    tops.map(|(z, radius)| z + radius).fold(0.0, f64::max)
}

/// Masses that do not follow from radii, and moments of inertia that are not those of the bed.
pub(crate) fn other_masses(bodies: &mut Bodies) {
    let masses = bodies.mass.iter_mut().enumerate();
    masses.for_each(|(id, mass)| *mass *= 1.0 + 0.3 * (2.3 * id as f64).sin());
    let inertias = bodies.inertia.iter_mut();
    inertias.for_each(|inertia| *inertia *= 0.8);
}

/// The bed's states, poured and pressed by the native engine.
#[derive(Debug, Clone, PartialEq)]
pub struct Bed {
    pub(crate) scene: Scene,
    pub(crate) states: Vec<(Start, Bodies, Option<Punch>)>,
    /// Shortly before it is at its liveliest.
    rising: Bodies,
}

/// The key of the largest state.
pub const LARGE_STATE: &str = "springs-large";
/// Grains of the largest state, about.
const LARGE: usize = 5400;
/// Grains of the paper's scene.
const ALL_GRAINS: f64 = 5000.0;
/// The largest speed of spins that grains are given, rad/s.
const SPIN: f64 = 5.0;
/// How many times as fast grains are under other constants.
const FASTER: f64 = 4.0;
/// How far the punch has sunk at least, over the mean radius; at most it is twice as far.
const PRESSED: f64 = 6.0;
/// Steps between the moments of which one has the largest kinetic energy.
const RISING: u64 = 100;
/// States and excerpts of drawn laws.
const DRAWN: u64 = 24;
const DRAWN_EXCERPTS: u64 = 6;
/// So that few of them have both kinds of springs and all of dashpots.
const EXCERPTS_APART: usize = 5;
/// Time step of drawn laws over √(m/k).
const STABLE: f64 = 0.2;
/// How many times as fast grains are in some of them.
const FASTEST: f64 = 8.0;
/// A grain beside the punch stands so much higher than those below it, over its radius, that a punch that does not see it starts lower.
const HIGHER: f64 = 1.0e-3;
/// Steps of pouring before it is taken up, no multiple of those between looks.
const TAKEN_UP_AFTER: u64 = 1013;
/// Steps of loading before a punch that stands still is looked at.
const STANDS_AFTER: u64 = 1000;
/// Whether a corner of the punch touches a grain is looked at every so many steps.
const LOOKED_AT: u64 = 50;

impl Bed {
    /// A bed of so many grains whose radii differ by this share from their mean: the paper's box, narrower for fewer.
    pub fn new(grains: u32, dispersion: f64) -> Result<Self, NativeError> {
        let mut scene = paper_scene(1, grains);
        scene.particles.dispersion = dispersion;
        let share = (f64::from(grains) / ALL_GRAINS).sqrt();
        let Cloud::JitteredLattice { columns, .. } = &mut scene.cloud;
        let pitch = scene.container.width / f64::from(*columns);
        *columns = (f64::from(*columns) * share).round().max(2.0) as u32;
        scene.container.width = pitch * f64::from(*columns);
        scene.loading.half_width = (0.1 * scene.container.width).min(scene.loading.half_width);
        Bed::of(scene, PRESSED)
    }

    /// That of a scene, with a punch that has sunk by so many mean radii, or up to twice as far.
    pub(crate) fn of(scene: Scene, pressed: f64) -> Result<Self, NativeError> {
        let cloud = initial_bodies(&scene);
        let after = |task: Task| -> Result<Bodies, NativeError> {
            let end = native::run(&scene, &task, &native::Options::default(), &mut ())?;
            Ok(end.last.bodies)
        };
        // The time in which a grain falls half the cloud's height.
        let height = cloud.z.iter().copied().fold(0.0, f64::max);
        let halfway = ((height / scene.gravity).sqrt() / scene.time_step_seconds()) as u64;
        let loose = after(Task::pour(cloud.clone(), 30))?;
        let pouring = after(Task::pour(cloud.clone(), halfway))?;
        let rest = after(Task::settle(cloud.clone()))?;
        let mut livelier = scene.clone();
        livelier.measurement.history_every = RISING;
        let mut rising = Rising::default();
        let pour = Task::pour(cloud, 3 * halfway);
        native::run(&livelier, &pour, &native::Options::default(), &mut rising)?;
        let rising = rising.before_largest;
        let punch = first_contact_punch(&scene, &rest);
        let step = scene.loading.speed * scene.time_step_seconds();
        let steps = (pressed * 0.5 * scene.particles.mean_diameter / step) as u64;
        let looks = (steps..2 * steps).step_by(LOOKED_AT as usize).collect();
        let mut pressing = Case::new("pressing", Model::of(&scene), rest.clone(), looks);
        pressing.punch = Some(punch);
        let pressed = native::run_case(&pressing, None)?;
        // A corner at work, if there is one.
        let ids = pressing.ids();
        let by_a_corner = |snapshot: &Snapshot| {
            let mut contacts = snapshot.contacts.iter();
            contacts.any(|contact| at_a_corner(ids, contact))
        };
        let at = pressed.iter().position(by_a_corner).unwrap_or(0);
        let pressed = pressed.into_iter().nth(at);
        let mut states = vec![
            (Start::Loose, loose, None),
            (Start::Pouring, pouring, None),
            (Start::AtRest, rest, None),
        ];
        states.extend(pressed.map(|snapshot| (Start::UnderPunch, snapshot.bodies, snapshot.punch)));
        Ok(Bed {
            scene,
            states,
            rising,
        })
    }

    pub(crate) fn state(&self, start: Start) -> Option<&(Start, Bodies, Option<Punch>)> {
        self.states.iter().find(|state| state.0 == start)
    }

    /// The states under this law, as cases.
    pub fn cases(&self, law: LawKind) -> Vec<(Start, Case)> {
        let mut model = Model::of(&self.scene);
        model.law = law.of(&self.scene);
        let mut scene = self.scene.clone();
        scene.material.friction_angle = model.law.friction_angle;
        let case = |(start, bodies, punch): &(Start, Bodies, Option<Punch>)| {
            let mut bodies = bodies.clone();
            let rotating = if model.law.rotates() { bodies.len() } else { 0 };
            for id in 0..rotating {
                // Any spins will do: these are of all sizes and signs.
                bodies.spin.push(SPIN * (1.7 * id as f64).sin());
                let inertia = scene.grain_inertia(bodies.radius[id], bodies.mass[id]);
                bodies.inertia.push(inertia);
            }
            let mut case = Case::new("", model.clone(), bodies, MOMENTS.to_vec());
            case.punch = *punch;
            law.change(&mut case);
            (*start, case)
        };
        let of_law = |(start, ..): &&(Start, Bodies, Option<Punch>)| {
            !law.is_other() || [Start::Pouring, Start::UnderPunch].contains(start)
        };
        self.states.iter().filter(of_law).map(case).collect()
    }

    /// Excerpts of scenes: pouring and the beginning of loading, with springs alone, then with friction and with other constants
    /// in loading.
    pub fn excerpts(&self) -> Result<Vec<Excerpt>, NativeError> {
        let mut rough = self.scene.clone();
        let mut staged = match self.scene.in_space() {
            true => {
                rough.contact.rolling = Some(ROLLING);
                self.scene.clone()
            }
            false => {
                rough.material.friction_angle = 0.5;
                rough.material.stiffness_ratio = 0.3;
                rough.clone()
            }
        };
        staged.loading.material = Some(Material {
            friction_angle: 0.2,
            stiffness_ratio: 2.0 * staged.material.stiffness_ratio,
            youngs_modulus: 0.7 * staged.material.youngs_modulus,
            ..staged.material.clone()
        });
        staged.loading.damping = Some(Damping::Cundall { alpha: 0.35 });
        let from = |start: Start, scene: &Scene| {
            let stage = match start {
                Start::AtRest => Stage::Load,
                _ => Stage::Settle,
            };
            let mut bodies = self.state(start).expect("every bed has it").1.clone();
            can_turn(scene, &mut bodies);
            if !rotates(scene) {
                bodies.do_not_turn();
            }
            grains::task::Start {
                stage,
                ..bodies.into()
            }
        };
        let smooth = &self.scene;
        let (pouring, mut rest) = (from(Start::Pouring, smooth), from(Start::AtRest, smooth));
        let rubbing = from(Start::Pouring, &rough);
        let (name, key) = ("pouring", "excerpt-pouring");
        let mut excerpts = vec![Excerpt::new(name, key, smooth, pouring.clone())];
        let (name, key) = ("the beginning of loading", "excerpt-loading");
        excerpts.push(Excerpt::new(name, key, smooth, rest.clone()));
        let (name, key) = ("pouring with friction", "excerpt-pouring-friction");
        excerpts.push(Excerpt::new(name, key, &rough, rubbing.clone()));
        let key = "excerpt-stages";
        let name = "pouring with friction, then loading with other constants";
        excerpts.push(Excerpt::into_loading(name, key, &staged, rubbing.clone()));
        // For engines too that have no constants of their own for loading.
        let (name, key) = (
            "pouring with friction, then loading",
            "excerpt-into-loading",
        );
        excerpts.push(Excerpt::into_loading(name, key, &rough, rubbing));
        // The depth ends it too where a punch that had its force would stand still.
        let (name, key) = ("pouring, then loading that gives up", "excerpt-gives-up");
        let mut standing = smooth.clone();
        let seconds = STEPS_OF_EXCERPT as f64 * standing.time_step_seconds();
        standing.loading.after_force = AfterForce::StandStill { seconds };
        excerpts.push(Excerpt::into_loading(name, key, &standing, pouring.clone()));
        let (name, key) = ("pouring until its most steps", "excerpt-most-steps");
        excerpts.push(Excerpt::new(name, key, smooth, pouring.clone()).to_most_steps());
        let (name, key) = ("pouring that was livelier before", "excerpt-seen");
        excerpts.push(Excerpt::new(name, key, smooth, pouring).livelier_before());
        let mut rising: grains::task::Start = self.rising.clone().into();
        let (name, key) = ("pouring until its rule holds", "excerpt-settled");
        excerpts.extend(Excerpt::new(name, key, smooth, rising.clone()).until_settled()?);
        // Rules look at multiples of all steps of the stage, not of those since a job began.
        rising.step = TAKEN_UP_AFTER;
        let name = "pouring that is taken up, until its most steps";
        let key = "excerpt-most-steps-taken-up";
        excerpts.push(Excerpt::new(name, key, smooth, rising.clone()).to_most_steps());
        let name = "pouring that is taken up, until its rule holds";
        let key = "excerpt-settled-taken-up";
        excerpts.extend(Excerpt::new(name, key, smooth, rising).until_settled()?);
        let (name, key) = ("loading to its end", "excerpt-to-end");
        excerpts.extend(Excerpt::to_end(name, key, smooth, rest.clone())?);
        if let Some((_, bodies, Some(punch))) = self.state(Start::UnderPunch) {
            let standing = Punch {
                velocity: 0.0,
                ..*punch
            };
            let from = grains::task::Start {
                stage: Stage::Load,
                step: STANDS_AFTER,
                punch: Some(standing),
                seen: Seen {
                    standing_since: Some(STANDS_AFTER),
                    ..Seen::default()
                },
                ..bodies.clone().into()
            };
            let mut scene = smooth.clone();
            let seconds = 2.0 * STEPS_OF_EXCERPT as f64 * scene.time_step_seconds();
            scene.loading.after_force = AfterForce::StandStill { seconds };
            let (name, key) = ("a punch that stands still", "excerpt-standing");
            excerpts.push(Excerpt::new(name, key, &scene, from));
        }
        if let Some(scene) = under_the_highest_top(smooth, &rest.bodies) {
            let name = "loading of a bed whose highest centre is not its highest top";
            excerpts.push(Excerpt::new(name, "excerpt-top", &scene, rest.clone()));
        }
        can_turn(&rough, &mut rest.bodies);
        if let Some(mut scene) = at_its_corner(&rough, &rest.bodies) {
            // With friction at the corner that touches first the force is not that of springs alone.
            let (name, key) = ("loading by a corner to its end", "excerpt-corner");
            excerpts.extend(Excerpt::to_end(name, key, &scene, rest.clone())?);
            // Nearly smooth at the punch alone, and only once loading has begun: contacts slide there.
            scene.loading.material = Some(Material {
                punch_friction_angle: Some(0.05),
                ..scene.material.clone()
            });
            let (name, key) = ("loading by a smooth punch", "excerpt-smooth-punch");
            let from = rest.bodies.clone().into();
            excerpts.push(Excerpt::into_loading(name, key, &scene, from));
        }
        spin(&mut rest.bodies, 20.0 * SPIN);
        rest.stage = Stage::Settle;
        let (name, key) = ("spinning until its rule holds", "excerpt-spins");
        excerpts.extend(Excerpt::new(name, key, &rough, rest).until_spins_settle()?);
        for number in 1..=DRAWN_EXCERPTS {
            let (mut scene, _) = self.drawn_scene(number);
            let name = format!("drawn law {number}, then loading with another");
            let key = format!("excerpt-drawn-{number}");
            let from = from(Start::Pouring, &scene);
            // Every law of adhesion on every kind of obstacle.
            if self.scene.in_space() {
                scene.obstacles = obstacles_of_scene(&scene, &from.bodies, number / 2);
            }
            excerpts.push(Excerpt::into_loading(&name, &key, &scene, from));
        }
        if self.scene.in_space() {
            for excerpt in &mut excerpts {
                excerpt.start += ", of spheres";
                excerpt.key += "-in-space";
            }
        }
        Ok(excerpts)
    }

    /// The states under every law.
    pub fn states(&self) -> Vec<State> {
        let of_law = |law: LawKind| {
            let cases = self.cases(law).into_iter();
            cases.map(move |(start, case)| {
                let key = format!("{}-{}", law.name(), start.key());
                State {
                    // The punch is large, so that numbers that are small differences of its own are coarser there.
                    probed: law == LawKind::Springs
                        && [Start::Pouring, Start::UnderPunch].contains(&start),
                    drawn: false,
                    faster: if law == LawKind::OtherSprings {
                        FASTER
                    } else {
                        1.0
                    },
                    ..State::drawn(law.name(), start.name(), key, case)
                }
            })
        };
        let usual = LawKind::ALL.into_iter().flat_map(of_law);
        let drawn = (1..=DRAWN).filter_map(|number| self.drawn_state(number));
        usual.chain(drawn).chain([self.large_state()]).collect()
    }

    /// The bed at rest many times side by side: what goes wrong beyond some number of grains shows in its first steps.
    fn large_state(&self) -> State {
        let scene = &self.scene;
        let (_, bed, _) = self.state(Start::AtRest).expect("every bed has it");
        let copies = (LARGE / bed.len().max(1)).max(2);
        let mut bodies = Bodies::default();
        for copy in 0..copies {
            let mut bed = bed.clone();
            let shift = copy as f64 * scene.container.width;
            bed.x.iter_mut().for_each(|x| *x += shift);
            bodies.append(bed);
        }
        let mut model = Model::of(scene);
        model.walls[1].place *= copies as f64;
        let name = format!("{} grains at rest", bodies.len());
        let case = Case::new("", model, bodies, MOMENTS[..4].to_vec());
        State {
            faster: copies as f64,
            ..State::drawn(LawKind::Springs.name(), &name, LARGE_STATE.to_owned(), case)
        }
    }

    /// The scene with every key that an engine can read drawn apart, in both stages: what is right for each value alone may be wrong for
    /// two together.
    fn drawn_scene(&self, number: u64) -> (Scene, Source) {
        let mut source = Source::new(b"crossgrain: drawn contact laws  ", number);
        let mut scene = self.scene.clone();
        let material = drawn_material(&mut source, &scene.material);
        // Loading has the springs of pouring, and other dashpots: what a contact of one kind of springs remembers is not for the other.
        let combination = EXCERPTS_APART * number as usize % COMBINATIONS;
        let of_springs = COMBINATIONS / 2;
        let next = combination / of_springs * of_springs + (combination + 1) % of_springs;
        let contact_of = |source: &mut Source, combination| match self.scene.in_space() {
            true => contact_in_space(source, combination),
            false => drawn_contact(source),
        };
        let contact = contact_of(&mut source, combination);
        let alpha = drawn(&mut source, [0.0, 0.2, 0.6, 0.95]);
        scene.gravity = drawn(&mut source, [1.62, 9.81, 30.0]);
        scene.damping = Damping::Cundall { alpha };
        scene.loading.material = Some(drawn_material(&mut source, &material));
        // What spins are for once grains are kept from turning no rule says.
        let mut in_loading = contact_of(&mut source, next);
        if contact.rotation == Rotation::Free {
            in_loading.rotation = Rotation::Free;
        }
        scene.loading.contact = Some(in_loading);
        let alpha = drawn(&mut source, [0.0, 0.2, 0.6, 0.95]);
        scene.loading.damping = Some(Damping::Cundall { alpha });
        (scene.material, scene.contact) = (material, contact);
        if self.scene.in_space() {
            let law = [AdhesionLaw::Jkr, AdhesionLaw::Dmt, AdhesionLaw::Pull][number as usize % 3];
            let contacts = [Some(&mut scene.contact), scene.loading.contact.as_mut()];
            let of_hertz = |contact: &&mut ContactLaw| contact.springs == Springs::HertzMindlin;
            for contact in contacts.into_iter().flatten().filter(of_hertz) {
                adhesive(contact, law, ADHESION);
            }
        }
        // Stable with the strongest of these springs and dashpots: else rounding grows in every step.
        scene.time_step = TimeStep::Fraction {
            of_sqrt_m_over_k: STABLE,
        };
        (scene, source)
    }

    /// Fast or slow grains with large or small spins, poured or under the punch, in such a scene.
    fn drawn_state(&self, number: u64) -> Option<State> {
        let start = match number % 2 {
            0 => Start::Pouring,
            _ => Start::UnderPunch,
        };
        let (_, bodies, punch) = self.state(start)?;
        let (scene, mut source) = self.drawn_scene(number);
        let mut bodies = bodies.clone();
        let faster = drawn(&mut source, [1.0, FASTEST]);
        for velocity in bodies.vx.iter_mut().chain(&mut bodies.vz) {
            *velocity *= faster;
        }
        let model = Model::of(&scene);
        let spin = drawn(&mut source, [SPIN, 60.0 * SPIN]);
        if model.law.rotates() {
            can_turn(&scene, &mut bodies);
            let spins = bodies.spin.iter_mut().enumerate();
            spins.for_each(|(id, own)| *own = spin * (1.7 * id as f64).sin());
        }
        let mut case = Case::new("", model, bodies, MOMENTS.to_vec());
        case.punch = *punch;
        let (law, key) = (format!("drawn law {number}"), format!("drawn-{number}"));
        Some(State {
            faster: FASTEST,
            ..State::drawn(&law, start.name(), key, case)
        })
    }
}

/// The scene with a punch as wide that a grain whose centre is beside it is the first one that it meets. None where no width is.
fn at_its_corner(scene: &Scene, bed: &Bodies) -> Option<Scene> {
    let axis = scene.punch_axis();
    let widths = (50..=100).rev().map(|percent| {
        let mut scene = scene.clone();
        scene.loading.half_width *= f64::from(percent) / 100.0;
        scene
    });
    let mut beside = widths.filter(|scene| {
        let punch = first_contact_punch(scene, bed);
        let bottom = punch.centre[1] - punch.half_extents[1];
        let below =
            (0..bed.len()).filter(|id| (bed.x[*id] - axis).abs() < scene.loading.half_width);
        let highest = below.map(|id| bed.z[id] + bed.radius[id]);
        let highest = highest.fold(0.0, f64::max);
        bottom > highest + HIGHER * scene.particles.mean_diameter
    });
    beside.next()
}

/// The scene with a punch as wide that the highest top below it is not that of the highest centre. None where no width is.
fn under_the_highest_top(scene: &Scene, bed: &Bodies) -> Option<Scene> {
    let axis = scene.punch_axis();
    let widths = (1..=100).rev().map(|percent| {
        let mut scene = scene.clone();
        scene.loading.half_width *= f64::from(percent) / 50.0;
        scene
    });
    let mut apart = widths.filter(|scene| {
        let half_width = scene.loading.half_width;
        let below =
            (0..bed.len()).filter(|id| (bed.x[*id] - axis).abs() < half_width + bed.radius[*id]);
        let top = |id: usize| bed.z[id] + bed.radius[id];
        let highest = below.clone().max_by(|a, b| top(*a).total_cmp(&top(*b)));
        let centre = below.max_by(|a, b| bed.z[*a].total_cmp(&bed.z[*b]));
        let least = HIGHER * scene.particles.mean_diameter;
        highest
            .zip(centre)
            .is_some_and(|(a, b)| top(a) > top(b) + least)
    });
    apart.next()
}

/// The state before the one with the largest kinetic energy.
#[derive(Default)]
struct Rising {
    last: Bodies,
    before_largest: Bodies,
    largest: f64,
}

impl Observer for Rising {
    fn snapshot(&mut self, snapshot: &Snapshot) {
        let last = std::mem::replace(&mut self.last, snapshot.bodies.clone());
        if snapshot.bodies.kinetic_energy() > self.largest {
            self.largest = snapshot.bodies.kinetic_energy();
            self.before_largest = last;
        }
    }
}

/// A state that an engine is asked to start from.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// States under one law share what is found of it.
    pub law: String,
    /// Which moment of a bed's life it is.
    pub start: String,
    /// For identifiers, one of its own.
    pub key: String,
    /// Whether it tells how coarsely an engine computes.
    pub probed: bool,
    /// Whether it is one of many that are drawn: it is held against replicas, and no limits are measured in it.
    pub drawn: bool,
    /// How many times as fast grains are as where an engine's precision is measured, or as far away.
    pub faster: f64,
    pub case: Case,
}

impl State {
    /// One of many, which the case is named by.
    pub(crate) fn drawn(law: &str, start: &str, key: String, mut case: Case) -> Self {
        case.name = format!("{law}, {start}");
        State {
            law: law.to_owned(),
            start: start.to_owned(),
            key,
            probed: false,
            drawn: true,
            faster: 1.0,
            case,
        }
    }

    /// That the engine lacks this.
    pub(crate) fn not_asked(&self, lacking: String) -> NotAsked {
        NotAsked {
            law: self.law.clone(),
            start: self.start.clone(),
            lacking,
        }
    }

    /// The same as an engine computes it that has these rules otherwise than the model.
    pub fn under(&self, rules: Rules) -> Self {
        let mut state = self.clone();
        state.case.model.rules = rules.over(state.case.model.rules);
        state
    }
}

#[cfg(test)]
mod tests {
    use grains::tables::{Snapshot, StopReason};

    use super::*;
    use crate::envelope::Resolution;
    use crate::judge::Verdict;
    use grains::task::Until;

    #[test]
    fn dashpots_are_three_tenths_of_what_lets_two_grains_part_without_a_bounce() {
        let scene = paper_scene(1, 2);
        let law = LawKind::Dashpots.of(&scene);
        let radius = 0.5 * scene.particles.mean_diameter;
        let stiffness = law.normal_stiffness(radius, radius);
        let half_mass = 0.5 * scene.grain_mass(radius);
        let Viscosity::Dashpot { c_n, .. } = law.contact.viscosity else {
            panic!("{law:?}")
        };
        let share = c_n / (2.0 * (half_mass * stiffness).sqrt());
        assert!((share - 0.3).abs() < 1.0e-12, "{share}");
    }

    /// What contacts remember when loading begins is asked of engines too that have no constants of their own for it.
    #[test]
    fn settling_goes_on_into_loading_with_friction_and_the_same_constants() {
        let bed = Bed::new(100, DISPERSION).expect("a bed");
        let excerpts = bed.excerpts().expect("they run");
        let goes_on = |excerpt: &&Excerpt| {
            let (scene, task) = (&excerpt.scene, &excerpt.task);
            let from = (task.start.stage, task.until) == (Stage::Settle, Until::EndOfLoading);
            from && scene.material.friction_angle > 0.0 && !scene.has_stages()
        };
        let into_loading = excerpts.iter().find(goes_on).expect("one goes on");
        let moments = into_loading.native(None).expect("it runs");
        let first = moments.iter().find(|moment| moment.stage == Stage::Load);
        let contacts = &first.expect("loading begins").contacts;
        assert!(
            contacts
                .iter()
                .any(|contact| contact.tangential_force != 0.0)
        );
    }

    /// How its punch began and goes, and why it ended, are told by an engine itself.
    #[test]
    fn what_is_told_of_the_punch_and_of_the_end_is_held_against_the_rules() {
        let bed = Bed::new(100, DISPERSION).expect("a bed");
        let excerpts = bed.excerpts().expect("they run");
        let to_end = |excerpt: &&Excerpt| excerpt.key == "excerpt-to-end";
        let excerpt = excerpts.iter().find(to_end).expect("one goes to its end");
        let moments = excerpt.native(None).expect("it runs");
        let judged = |moments: &[Snapshot], stop: StopReason| {
            let ended = Some(vec![(Stage::Load, stop)]);
            let answer = Ok((moments.to_vec(), ended));
            excerpt
                .judge(answer, Resolution::DOUBLE)
                .expect("a verdict")
        };
        assert_eq!(
            judged(&moments, StopReason::Reached).verdict,
            Verdict::Identical
        );
        let other = judged(&moments, StopReason::TargetLoadNotReached);
        assert_eq!(other.verdict, Verdict::Different);
        let why = other.skipped.unwrap_or_default();
        assert!(
            why.contains("load ended as target_load_not_reached"),
            "{why}"
        );
        // Which moment came where which was due, so that a run that is wrong by more is told in other words.
        let short = judged(&moments[..moments.len() - 1], StopReason::Reached);
        assert_eq!(short.verdict, Verdict::Different);
        let why = short.skipped.unwrap_or_default();
        assert!(why.contains(": none where load "), "{why}");
        assert!(
            why.contains("before that it is as far off as rounding takes it"),
            "{why}"
        );
        let changes: [fn(&mut Punch); 2] = [
            |punch| punch.start -= 1.0e-3,
            |punch| punch.velocity = -punch.velocity,
        ];
        for change in changes {
            let mut told = moments.clone();
            told.iter_mut()
                .filter_map(|moment| moment.punch.as_mut())
                .for_each(change);
            assert_eq!(
                judged(&told, StopReason::Reached).verdict,
                Verdict::Different
            );
        }
    }
}
