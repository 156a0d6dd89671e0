//! What a card asks for: experiments of one or two grains, in the plane and in space, and how a trajectory shows each constant.
//!
//! One list of places and one of readings; in space directions are askew, so that no term can be taken along an axis of the box.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::engine::{Description, Part};
use crate::suite::spheres::{Sphere, case, hertz_mindlin};
use crate::suite::{Grain, Track, at, friction, model, punch, with_viscosity, world};
use grains::model::{Axis, Law, Model, Solid, Wall};
use grains::obstacle::{Obstacle, Surface};
use grains::scene::{Tension, Viscosity};
use grains::tables::Bodies;
use grains::task::Case;
use grains::vector::{Vector, cross, dot, hypot, minus, plus, times};

/// Radii of the grains, m; both are R of the first where grains are equal.
pub const RADII: [f64; 2] = [0.005, 0.002];
const DENSITY: f64 = 2500.0;
/// E, Pa, so that k_n of two equal grains is E·R by linear springs.
pub const MODULUS: f64 = 1.0e7;
const POISSONS_RATIO: f64 = 0.3;
/// What the other material is made of; friction is 0.6 of the first one's.
const OTHER: Solid = Solid {
    modulus: 2.5e7,
    stiffness_ratio: 0.8,
    poissons_ratio: 0.2,
    friction_angle: 0.0,
};
pub const DT: f64 = 1.0e-6;
/// The overlap that springs are read at, over the radius of the last grain.
pub const OVERLAP: f64 = 1.0e-3;
/// m/s.
pub const SPEED: f64 = 0.1;
/// Steps in a contact time where that is counted.
pub const STEPS: u64 = 100;
/// Steps in which a spring turns or its load changes, a small part of a contact time.
pub const LONG: u64 = 100;
const SHARE: f64 = 1.0 / 22.0;
/// How many times its moment of inertia a grain has, so that nothing is seen of its spin; moments have an experiment of their own.
pub const HEAVY: f64 = 1.0e6;
/// How much faster or deeper the second of two readings is.
pub const MORE: f64 = 10.0;
pub const TENSION: Tension = Tension::Clipped;

/// What the last grain meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    Equal,
    Unequal,
    Materials,
    Wall,
    /// A wall that is elsewhere, from its other side.
    Below,
    /// A wall under a grain of another material.
    Apart,
    Punch,
    Plane,
    Triangle,
    Box,
}

pub const PLACES: [Place; 10] = [
    Place::Equal,
    Place::Unequal,
    Place::Materials,
    Place::Wall,
    Place::Below,
    Place::Apart,
    Place::Punch,
    Place::Plane,
    Place::Triangle,
    Place::Box,
];

/// By which law, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Discs with linear springs.
    Plane,
    /// Spheres in space.
    Linear,
    Hertz,
}

impl Kind {
    pub const ALL: [Kind; 3] = [Kind::Plane, Kind::Linear, Kind::Hertz];

    /// What stands in front of a row's key.
    pub fn key(self) -> &'static str {
        ["", "space/linear/", "space/hertz/"][self as usize]
    }

    pub fn name(self) -> &'static str {
        [
            "In the plane",
            "Spheres with linear springs",
            "Spheres with Hertz's and Mindlin's springs",
        ][self as usize]
    }

    pub fn in_space(self) -> bool {
        self != Kind::Plane
    }

    /// What goes with linear springs, or with Hertz's.
    pub fn choose<T>(self, linear: T, hertz: T) -> T {
        match self {
            Kind::Plane | Kind::Linear => linear,
            Kind::Hertz => hertz,
        }
    }

    /// Whether an engine with these parts is asked for it.
    pub fn is_in(self, engine: &Description) -> bool {
        engine.has(match self {
            Kind::Plane => Part::Plane,
            Kind::Linear => Part::Space,
            Kind::Hertz => Part::HertzMindlin,
        })
    }

    /// With this k_s/k_n of linear springs and this friction angle.
    pub fn law(self, stiffness_ratio: f64, friction_angle: f64) -> Law {
        match self {
            Kind::Plane | Kind::Linear => friction(MODULUS, stiffness_ratio, friction_angle),
            Kind::Hertz => hertz_mindlin(MODULUS, POISSONS_RATIO, friction_angle),
        }
    }

    pub fn with_dashpots(self, law: Law, viscosity: Viscosity) -> Law {
        match self {
            Kind::Plane | Kind::Linear => with_viscosity(law, viscosity),
            Kind::Hertz => {
                let mut law = law;
                law.contact.viscosity = viscosity;
                law
            }
        }
    }

    pub fn grain(self, radius: f64) -> Grain {
        match self {
            Kind::Plane => Grain::disc([0.0; 2], radius, DENSITY),
            Kind::Linear | Kind::Hertz => Grain::sphere([0.0; 2], radius, DENSITY),
        }
    }

    /// A case in the plane, of one that was made for space.
    pub fn placed(self, mut case: Case) -> Case {
        if self == Kind::Plane {
            let bodies = &mut case.bodies;
            let across = [
                &mut bodies.y,
                &mut bodies.vy,
                &mut bodies.spin_x,
                &mut bodies.spin_z,
            ];
            across.into_iter().for_each(Vec::clear);
        }
        case
    }
}

pub type Read = Box<dyn Fn(&Track) -> f64 + Send + Sync>;

/// Something that is asked for, and how a trajectory shows it.
pub struct Quantity {
    pub about: About,
    pub case: Case,
    pub read: Read,
}

/// What is asked for, by which law, and where.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct About {
    pub key: String,
    pub name: String,
    pub unit: &'static str,
    pub place: &'static str,
    #[serde(skip)]
    pub kind: Kind,
    /// What meets; none of a grain alone.
    #[serde(skip)]
    pub meeting: Option<Meeting>,
    /// What is larger or smaller in another reading of the same name, and how much of it there is in this one.
    #[serde(skip)]
    pub rate: Option<(&'static str, f64)>,
    /// What the model says.
    pub asked: f64,
}

/// What a reading is called, and its unit.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Named {
    name: &'static str,
    unit: &'static str,
    /// Where the unit is another one by Hertz's law.
    by_hertz: Option<&'static str>,
}

/// By the keys of readings: `names.json`, read.
static NAMES: LazyLock<BTreeMap<&str, Named>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("names.json")).expect("it is a table of names")
});

impl About {
    pub fn new(kind: Kind, place: &'static str, key: &str, asked: f64) -> Self {
        let Some(named) = NAMES.get(key) else {
            unreachable!("{key} has no name");
        };
        let by_hertz = named.by_hertz.filter(|_| kind == Kind::Hertz);
        About {
            key: format!("{}{key}/{}", kind.key(), place.replace(' ', "-")),
            name: named.name.to_owned(),
            unit: by_hertz.unwrap_or(named.unit),
            place,
            kind,
            meeting: None,
            rate: None,
            asked,
        }
    }
}

/// The last grain at a place, by a law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    pub place: Place,
    pub kind: Kind,
}

/// Along the normal, along the tangent in which it slips, and across both.
pub type Local = [f64; 3];

impl Place {
    pub fn name(self) -> &'static str {
        [
            "two equal grains",
            "two unequal grains",
            "two materials",
            "wall",
            "wall from below",
            "wall and another material",
            "punch",
            "plane",
            "triangle",
            "box",
        ][self as usize]
    }

    pub fn is_pair(self) -> bool {
        matches!(self, Place::Equal | Place::Unequal | Place::Materials)
    }

    /// Whether an engine with these parts is asked for it.
    pub fn is_in(self, kind: Kind, engine: &Description) -> bool {
        let part = match self {
            Place::Equal | Place::Unequal | Place::Wall | Place::Below | Place::Punch => {
                return true;
            }
            Place::Materials | Place::Apart => Part::Materials,
            Place::Plane => Part::Planes,
            Place::Triangle => Part::Facets,
            Place::Box => Part::Boxes,
        };
        kind.in_space() && engine.has(part)
    }
}

impl Meeting {
    pub fn last(self) -> Grain {
        let radius = RADII[usize::from(self.place == Place::Unequal)];
        self.kind.grain(radius)
    }

    pub fn first(self) -> Grain {
        self.kind.grain(RADII[0])
    }

    fn has_materials(self) -> bool {
        matches!(self.place, Place::Materials | Place::Apart)
    }

    /// How far the surface of what is met is from the origin along the normal, m.
    fn shift(self) -> f64 {
        if self.place == Place::Below {
            0.02
        } else {
            0.0
        }
    }

    /// From what is met to the last grain, the tangent, and across both.
    pub fn directions(self) -> [Vector; 3] {
        let [normal, tangent] = match (self.kind, self.place) {
            (Kind::Plane, Place::Punch) => [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]],
            (Kind::Plane, Place::Below) => [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            (Kind::Plane, _) => [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
            (Kind::Hertz, Place::Below) => [[0.0, 0.0, -1.0], [0.6, 0.8, 0.0]],
            (_, Place::Below) => [[-1.0, 0.0, 0.0], [0.0, 0.6, 0.8]],
            (_, Place::Wall | Place::Apart) => [[0.0, 1.0, 0.0], [0.6, 0.0, 0.8]],
            (_, Place::Punch) => [[0.0, 0.0, -1.0], [0.8, 0.6, 0.0]],
            _ => [[0.36, 0.48, 0.8], [0.8, -0.6, 0.0]],
        };
        [normal, tangent, cross(normal, tangent)]
    }

    pub fn in_space(self, local: Local) -> Vector {
        let [normal, tangent, across] = self.directions();
        let along = plus(times(local[0], normal), times(local[1], tangent));
        plus(along, times(local[2], across))
    }

    pub fn local(self, vector: Vector) -> Local {
        self.directions()
            .map(|direction| dot(vector, direction) + 0.0)
    }

    /// With this k_s/k_n of linear springs and this friction angle.
    pub fn law(self, stiffness_ratio: f64, friction_angle: f64) -> Law {
        let mut law = self.kind.law(stiffness_ratio, friction_angle);
        if self.has_materials() {
            let friction_angle = 0.6 * friction_angle;
            law.materials = vec![Solid {
                friction_angle,
                ..OTHER
            }];
        }
        law
    }

    /// The radii by which stiffnesses go: flat bodies count as a grain of the same radius, triangles of twice it.
    pub fn radii(self) -> [f64; 2] {
        let last = self.last().radius;
        let first = match self.place {
            _ if self.place.is_pair() => RADII[0],
            Place::Triangle => 2.0 * last,
            _ => last,
        };
        [first, last]
    }

    /// What both are made of.
    pub fn solids(self, law: &Law) -> [Solid; 2] {
        [0, u32::from(self.has_materials())].map(|material| law.solid(material))
    }

    /// k_n and k_s: over the overlap N/m of linear springs, F/u^1.5 and k_s/u^0.5 of Hertz's and Mindlin's, N/m^1.5.
    pub fn stiffness(self, law: &Law) -> [f64; 2] {
        let [one, two] = self.solids(law);
        let [r1, r2] = self.radii();
        let half_mean = |a: f64, b: f64| 2.0 * a * b / (a + b);
        let [a, b] = [one.modulus * r1, two.modulus * r2];
        match self.kind {
            Kind::Hertz => one.hertz_mindlin(two, 0.5 * half_mean(r1, r2)),
            _ => [
                half_mean(a, b),
                half_mean(a * one.stiffness_ratio, b * two.stiffness_ratio),
            ],
        }
    }

    /// The power of the overlap that the normal force goes with.
    pub fn power(self) -> f64 {
        self.kind.choose(1.0, 1.5)
    }

    /// dF/du at this overlap, N/m.
    pub fn slope(self, law: &Law, overlap: f64) -> f64 {
        let power = self.power();
        power * self.stiffness(law)[0] * overlap.powf(power - 1.0)
    }

    /// m₁m₂/(m₁ + m₂), or the whole mass at flat bodies, kg.
    pub fn mass(self) -> f64 {
        let (one, two) = (self.first().mass, self.last().mass);
        match self.place.is_pair() {
            true => one * two / (one + two),
            false => two,
        }
    }

    /// How long a contact without dashpots lasts, s.
    pub fn contact_time(self, law: &Law) -> f64 {
        let [stiffness, _] = self.stiffness(law);
        match self.kind {
            Kind::Hertz => {
                let depth = (1.25 * self.mass() * SPEED * SPEED / stiffness).powf(0.4);
                2.943_276_1 * depth / SPEED
            }
            _ => PI * (self.mass() / stiffness).sqrt(),
        }
    }

    /// The last grain this deep, at this velocity along the tangent and inward.
    pub fn meeting(
        self,
        law: Law,
        overlap: f64,
        [along, inward]: [f64; 2],
        moments: Vec<u64>,
    ) -> Case {
        let sphere = |grain: Grain, distance: f64| {
            let place = self.in_space([distance + self.shift(), 0.0, 0.0]);
            let mut sphere = Sphere::new(place, grain.radius, DENSITY);
            sphere.mass = grain.mass;
            sphere
        };
        let (first, last) = (self.first(), self.last());
        let mut spheres = Vec::new();
        let mut distance = last.radius - overlap;
        if self.place.is_pair() {
            distance += first.radius;
            spheres.push(sphere(first, 0.0));
        }
        spheres.push(sphere(last, distance).moving(self.in_space([-inward, along, 0.0])));
        let turns = law.rotates();
        let mut made = case("card", self.world(law), &spheres, moments);
        if turns {
            let pair = [first.inertia, HEAVY * last.inertia];
            made.bodies.inertia = pair[2 - spheres.len()..].to_vec();
        }
        if self.has_materials() {
            made.bodies.material = [0, 1][2 - spheres.len()..].to_vec();
        }
        if self.place == Place::Punch {
            made.punch = Some(punch(0.0, 0.0, [0.05, 0.05], 0.0));
        }
        self.kind.placed(made)
    }

    /// With what is flat: its surface goes through the origin.
    pub fn world(self, law: Law) -> Model {
        let mut made = model(law, DT);
        let [normal, tangent, across] = self.directions();
        let side = 0.05;
        let shape = match self.place {
            Place::Wall | Place::Below | Place::Apart => {
                let axes = [Axis::X, Axis::Y, Axis::Z];
                let axis = axes.into_iter().find(|axis| normal[axis.in_space()] != 0.0);
                let axis = axis.unwrap_or(Axis::Z);
                let place = self.shift() * normal[axis.in_space()];
                made.walls.push(Wall::at(axis, place));
                return made;
            }
            Place::Plane => Surface::Plane {
                point: [0.0; 3],
                normal,
            },
            Place::Triangle => Surface::Triangle {
                vertices: [0.0, 1.0, 2.0].map(|third: f64| {
                    let angle = third * 2.0 * PI / 3.0;
                    let [cos, sin] = [side * angle.cos(), side * angle.sin()];
                    plus(times(cos, tangent), times(sin, across))
                }),
            },
            Place::Box => Surface::Box {
                centre: times(-side, normal),
                half_extents: [side; 3],
                // From z to the normal, about what is across both: cos θ = 0.8.
                orientation: [
                    0.9f64.sqrt(),
                    -0.8 * 0.1f64.sqrt(),
                    0.6 * 0.1f64.sqrt(),
                    0.0,
                ],
            },
            _ => return made,
        };
        made.obstacles.push(Obstacle::still(shape));
        made
    }

    /// The same with spins of the first and the last grain, so many times as hard to turn as they are.
    pub fn spinning(self, mut case: Case, spins: [Local; 2], heavy: f64) -> Case {
        let from = 1 - self.id_of_last();
        for (id, local) in spins[from..].iter().enumerate() {
            let [x, y, z] = self.in_space(*local);
            case.bodies.spin[id] = y;
            if self.kind.in_space() {
                case.bodies.spin_x[id] = x;
                case.bodies.spin_z[id] = z;
            }
        }
        let inertia = [self.first(), self.last()].map(|grain| heavy * grain.inertia);
        case.bodies.inertia = inertia[from..].to_vec();
        case
    }

    /// A collision at this speed, of so many steps without dashpots, from half a step before it on.
    pub fn bounce(self, law: Law, speed: f64, steps: u64, moments: Vec<u64>) -> Case {
        let mut case = self.meeting(law.clone(), 0.0, [0.0, speed], moments);
        // A slow contact by Hertz's law lasts longer.
        let power = 0.4 * (self.power() - 1.0);
        let slowness = (SPEED / speed).powf(power);
        let dt = slowness * self.contact_time(&case.model.law) / steps as f64;
        let gap = self.meeting(law, -0.5 * speed * dt, [0.0, speed], Vec::new());
        (case.model.dt, case.bodies) = (dt, gap.bodies);
        case
    }

    /// A contact that slips along the tangent while its spring turns about the normal by this angle.
    pub fn turning(self, friction_angle: f64, angle: f64, moments: Vec<u64>) -> Case {
        let law = self.law(0.5, friction_angle);
        let overlap = OVERLAP * self.last().radius;
        let time = SHARE * self.contact_time(&law);
        // Half the overlap, however long it takes; of a pair by the first one's spin, so that the normal stays what it is.
        let speed = 0.5 * overlap / time;
        let [speed, spin] = match self.place.is_pair() {
            true => [0.0, -speed / RADII[0]],
            false => [speed, 0.0],
        };
        let case = self.meeting(law, overlap, [speed, 0.0], moments);
        // A spring turns with half the sum of the spins.
        let spins = [[0.0, 0.0, spin], [2.0 * angle / time, 0.0, 0.0]];
        let mut case = self.spinning(case, spins, HEAVY);
        case.model.dt = time / LONG as f64;
        case
    }

    pub fn id_of_last(self) -> usize {
        usize::from(self.place.is_pair())
    }

    /// The force on a grain between this moment and the next, N.
    pub fn force_on(self, id: usize, track: &Track, step: u64, dt: f64) -> Local {
        let mass = [self.first(), self.last()][id + 1 - self.id_of_last()].mass;
        self.local(change(track, step, id, Bodies::velocity).map(|part| mass * part / dt))
    }

    /// The same on the last one.
    pub fn force(self, track: &Track, step: u64, dt: f64) -> Local {
        self.force_on(self.id_of_last(), track, step, dt)
    }

    /// The torque on a grain with its own moment of inertia likewise, N·m.
    pub fn torque_on(self, id: usize, track: &Track, step: u64) -> Local {
        let inertia = [self.first(), self.last()][id + 1 - self.id_of_last()].inertia;
        self.local(
            change(track, step, id, Bodies::angular_velocity).map(|part| inertia * part / DT),
        )
    }

    pub fn torque(self, track: &Track, step: u64) -> Local {
        self.torque_on(self.id_of_last(), track, step)
    }

    /// How deep the last grain is, m.
    pub fn overlap(self, track: &Track, step: u64) -> f64 {
        let place = vector(track, step, self.id_of_last(), Bodies::position);
        let radius = self.last().radius;
        match self.place.is_pair() {
            true => {
                RADII[0] + radius - hypot(minus(place, vector(track, step, 0, Bodies::position)))
            }
            false => radius + self.shift() - self.local(place)[0],
        }
    }

    /// What stiffnesses along the tangent go with: the overlap to the power that is left.
    pub fn root(self, track: &Track, step: u64) -> f64 {
        self.overlap(track, step).powf(self.power() - 1.0)
    }

    /// Friction over the normal force.
    pub fn friction(self, track: &Track, step: u64) -> f64 {
        let [out, along, across] = self.force(track, step, DT);
        along.hypot(across) / out.abs()
    }

    /// k_s, by what the third step adds to the force of the second one.
    pub fn tangential_stiffness(self, track: &Track) -> f64 {
        let [one, two] = [1, 2].map(|step| self.force(track, step, DT)[1]);
        let way = self.velocity(track, 2)[1] * DT;
        (one - two) / way / self.root(track, 2)
    }

    /// The last grain's place, against that of the first one.
    pub fn place_of_last(self, track: &Track, step: u64) -> Local {
        let last = vector(track, step, self.id_of_last(), Bodies::position);
        self.local(match self.place.is_pair() {
            true => minus(last, vector(track, step, 0, Bodies::position)),
            false => last,
        })
    }

    /// Of the last grain against what it meets, m/s.
    pub fn velocity(self, track: &Track, step: u64) -> Local {
        let last = vector(track, step, self.id_of_last(), Bodies::velocity);
        self.local(match self.place.is_pair() {
            true => minus(last, vector(track, step, 0, Bodies::velocity)),
            false => last,
        })
    }
}

/// From this moment to the next.
pub fn change(track: &Track, step: u64, id: usize, which: fn(&Bodies, usize) -> Vector) -> Vector {
    let [before, after] = [step, step + 1].map(|step| vector(track, step, id, which));
    minus(after, before)
}

/// Of a grain; not a number where nothing is told.
pub fn vector(track: &Track, step: u64, id: usize, which: fn(&Bodies, usize) -> Vector) -> Vector {
    let told = at(track, step).0.map(|snapshot| &snapshot.bodies);
    let told = told.filter(|bodies| id < bodies.len());
    told.map_or([f64::NAN; 3], |bodies| which(bodies, id))
}

/// All that an engine with these parts is asked for.
pub fn quantities(engine: &Description) -> Vec<Quantity> {
    let mut all = Vec::new();
    for kind in Kind::ALL.into_iter().filter(|kind| kind.is_in(engine)) {
        let places = PLACES.into_iter().filter(|place| place.is_in(kind, engine));
        all.extend(places.flat_map(|place| Meeting { place, kind }.quantities()));
        // Hertz's law changes nothing of one grain.
        if kind != Kind::Hertz {
            all.extend(alone(kind));
        }
    }
    all
}

/// Of one grain: gravity, local damping on the way down and up, and how it is turned.
fn alone(kind: Kind) -> Vec<Quantity> {
    let gravity = [0.7, -9.81];
    let meeting = Meeting {
        place: Place::Wall,
        kind,
    };
    let grain = meeting.last();
    let row = |key, case, asked, read| Quantity {
        about: About::new(kind, "one grain", key, asked),
        case,
        read,
    };
    let thrown = |velocity: Vector, alpha: f64| {
        let world = world(kind.law(1.0, 0.0), DT, gravity, alpha, [&[], &[]]);
        let mut sphere = Sphere::new([0.0; 3], grain.radius, DENSITY).moving(velocity);
        sphere.mass = grain.mass;
        kind.placed(case("card", world, &[sphere], vec![0, 1, 2]))
    };
    let acceleration = |track: &Track, axis: usize| {
        let [before, after] = [1, 2].map(|step| vector(track, step, 0, Bodies::velocity)[axis]);
        (after - before) / DT
    };
    let fall = |axis: usize| -> Read { Box::new(move |track| acceleration(track, axis)) };
    let [down, up] = [-1.0, 1.0].map(|side: f64| -> Read {
        Box::new(move |track| side * (acceleration(track, 2) / gravity[1] - 1.0))
    });
    let overlap = OVERLAP * grain.radius;
    let mut turned = meeting.meeting(kind.law(1.0, 0.5), overlap, [3.0, 0.0], vec![0, 1, 2, 3]);
    let own = 1.5 * grain.inertia;
    turned.bodies.inertia = vec![own];
    let inertia = move |track: &Track| {
        let force = meeting.force(track, 2, DT)[1];
        let turn = change(track, 2, 0, Bodies::angular_velocity);
        let turn = match kind {
            Kind::Plane => turn[1],
            _ => meeting.local(turn)[2],
        };
        (force * DT * grain.radius / turn).abs()
    };
    let mut damped = turned.clone();
    damped.model.alpha = 0.3;
    // What brakes the grain is larger by α, and what turns it is smaller.
    let share = inertia;
    let of_spin = move |track: &Track| {
        let read = share(track);
        (read - own) / (read + own)
    };
    // Turns round within its first step.
    let turning = |share: f64| thrown([0.1, 0.0, share * 9.81 * DT], 0.3);
    let first = |side: f64| -> Read {
        Box::new(move |track| {
            let [before, after] = [0, 1].map(|step| vector(track, step, 0, Bodies::velocity)[2]);
            side * ((after - before) / DT / gravity[1] - 1.0)
        })
    };
    let still = || thrown([0.0; 3], 0.0);
    let across = move |track: &Track| acceleration(track, 0) / gravity[0] - 1.0;
    let (falls, rises) = ([0.1, 0.0, -1.0], [-0.1, 0.0, 1.0]);
    let falls_back = thrown([-0.1, 0.0, -1.0], 0.3);
    vec![
        row("g-x", still(), gravity[0], fall(0)),
        row("g-z", still(), gravity[1], fall(2)),
        row("alpha-down", thrown(falls, 0.3), 0.3, down),
        row("alpha-up", thrown(rises, 0.3), 0.3, up),
        row("alpha-across", falls_back, 0.3, Box::new(across)),
        row("alpha-turn-down", turning(0.3), 0.3, first(-1.0)),
        row("alpha-turn-up", turning(0.7), 0.3, first(1.0)),
        row("inertia", turned, own, Box::new(inertia)),
        row("alpha-spin", damped, 0.3, Box::new(of_spin)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Engine;
    use grains::native;
    use grains::rules::Choice;
    use grains::variant::{Form, Variant, run};

    /// Of an engine with all parts.
    fn all() -> Vec<Quantity> {
        let engine = native::Options::default().describe().expect("described");
        quantities(&engine)
    }

    fn read(quantity: &Quantity, variant: &Variant) -> f64 {
        (quantity.read)(&run(&quantity.case, variant))
    }

    #[test]
    fn readings_are_near_to_what_is_asked_for() {
        let all = all();
        assert!(all.len() > 300, "{}", all.len());
        for quantity in all {
            let found = read(&quantity, &Variant::default());
            let (key, asked) = (&quantity.about.key, quantity.about.asked);
            let off = (found - asked).abs() / asked.abs();
            assert!(off < 0.02, "{key}: {found} for {asked}");
        }
    }

    #[test]
    fn half_the_mass_at_walls_shows_at_all_that_is_flat_and_at_no_pair() {
        let half = Choice::of("wall_mass", "half").expect("a rule");
        let half = Variant::of(Form::Rule(half));
        let all = all();
        let rebounds = all
            .iter()
            .filter(|quantity| quantity.about.key.contains("e-05/"));
        for quantity in rebounds {
            let share = read(quantity, &half) / read(quantity, &Variant::default());
            let is_pair = quantity.about.place.starts_with("two ");
            let is_right = (share - 1.0).abs() < 1.0e-9;
            assert_eq!(is_right, is_pair, "{}: {share}", quantity.about.place);
        }
    }
}
