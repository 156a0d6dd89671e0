//! The same case in two engines: every number of every moment must have the same bits. Cases are random static states, for every
//! kind of pair and every option of the contact law that YADE has; trajectories of 5, 500 and 5,000 spinning grains, poured and
//! under the punch, with friction and with dashpots; and the first steps of a recorded run.

use crate::checks::Check;
use crate::compare::bits::{self, TableBits};
use crate::engine::yade::CaseInYade;
use crate::run::folder::recorded_history;
use crate::suite::{
    self, CaseGroup, Evidence, Figures, Grain, Track, friction, springs, with_viscosity,
};
use evidence::random::Source;
use grains::generate::initial_bodies;
use grains::model::{Law, Model};
use grains::native::{first_contact_punch, run_case};
use grains::scene::{
    Cloud, Rotation, Scene, SlipVelocity, Tension, TorqueArms, Viscosity, paper_scene,
};
use grains::tables::{BodyIds, Contact, Snapshot, Stage};
use grains::task::{Case, Load};

/// A case that two engines must agree on.
pub struct CrossCase {
    /// Lasting and unique, in kebab-case.
    pub id: String,
    pub title: String,
    /// What is run in both engines.
    pub case: Case,
    /// Places that must be among its contacts; empty if it is about motion.
    pub places: Vec<Place>,
}

/// The places at which contacts are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    Grains,
    Wall,
    Face,
    /// A corner of the punch, which is an edge across the plane, and a grain.
    Corner,
    /// The punch and a grain whose centre is inside it.
    Inside,
}

impl Place {
    /// The id and words of the check at this place.
    fn name(self) -> [&'static str; 2] {
        match self {
            Place::Grains => ["grain-and-grain", "grain and grain"],
            Place::Wall => ["wall-and-grain", "wall and grain"],
            Place::Face => ["punch-face", "punch face and grain"],
            Place::Corner => ["punch-corner", "punch corner (edge) and grain"],
            Place::Inside => ["inside-punch", "punch and grain inside it"],
        }
    }

    fn of(contact: &Contact, moment: &Snapshot, ids: BodyIds) -> Option<Place> {
        if ids.is_grain(contact.id1) {
            return Some(Place::Grains);
        }
        if contact.id1 < ids.punch() {
            return Some(Place::Wall);
        }
        let at = contact.id2 as usize;
        let position = [moment.bodies.x[at], moment.bodies.z[at]];
        let punch = moment.punch?;
        let beyond = |i: usize| (position[i] - punch.centre[i]).abs() > punch.half_extents[i];
        Some(match [0, 1].map(beyond) {
            [false, false] => Place::Inside,
            [true, true] => Place::Corner,
            _ => Place::Face,
        })
    }
}

/// Compares the native engine's track and loads of a case with YADE's, number by number.
pub fn judge(
    cross: &CrossCase,
    native: &Track,
    loads: &[Vec<Load>],
    yade: &CaseInYade,
) -> Vec<Check> {
    let of_tables = |id, what, table: fn(&Snapshot, &Snapshot) -> TableBits| {
        let [differing, numbers] = summed(native, &yade.track, table);
        (id, what, differing, numbers)
    };
    let mut counts = vec![
        of_tables("motion", "positions, velocities and spins", motion),
        of_tables("contacts", "numbers of contacts", contacts),
    ];
    if !yade.loads.is_empty() {
        counts.push(differing_loads(cross, loads, &yade.loads));
    }
    for &place in &cross.places {
        counts.push(contacts_at(place, cross, native, &yade.track));
    }
    let mut figures = Figures::default();
    figures.because("same operations in the same order: every bit");
    for (id, what, differing, total) in counts {
        // Nothing compared is nothing shown.
        let value = if total == 0 {
            f64::NAN
        } else {
            differing as f64
        };
        let what = format!("{id}: {what} that differ; of {total}, 1");
        figures.is(&what, value, 0.0, 0.0);
    }
    figures.done()
}

/// Id, words, how many numbers differ, of how many.
type Count = (&'static str, &'static str, usize, usize);

/// Forces and torques summed on grains; torques where they turn them.
fn differing_loads(cross: &CrossCase, native: &[Vec<Load>], yade: &[Vec<Load>]) -> Count {
    let (parts, what) = match cross.case.model.law.rotates() {
        true => (3, "forces and torques summed on grains"),
        false => (2, "forces summed on grains"),
    };
    let rows = native.iter().flatten().zip(yade.iter().flatten());
    let unequal = |(a, b): (&Load, &Load)| {
        (0..parts)
            .filter(|part| a[*part].to_bits() != b[*part].to_bits())
            .count()
    };
    let count = |all: &[Vec<Load>]| all.iter().map(Vec::len).sum::<usize>();
    let missing = count(native).abs_diff(count(yade));
    let differing = rows.map(unequal).sum::<usize>() + missing;
    ("loads", what, differing, count(native) * parts)
}

/// Contacts at one kind of place over all moments.
fn contacts_at(place: Place, cross: &CrossCase, one: &Track, other: &Track) -> Count {
    let ids = cross.case.ids();
    let pick = |moment: &Snapshot| -> Vec<Contact> {
        let there = |contact: &&Contact| Place::of(contact, moment, ids) == Some(place);
        moment.contacts.iter().filter(there).copied().collect()
    };
    let [differing, numbers] = summed(one, other, |a, b| bits::contacts("", &pick(a), &pick(b)));
    let [id, words] = place.name();
    (id, words, differing, numbers)
}

fn motion(a: &Snapshot, b: &Snapshot) -> TableBits {
    bits::bodies("", &a.bodies, &b.bodies)
}

fn contacts(a: &Snapshot, b: &Snapshot) -> TableBits {
    bits::contacts("", &a.contacts, &b.contacts)
}

/// How many numbers differ over all moments, one that is missing counted as one, and how many there are.
fn summed(a: &Track, b: &Track, table: impl Fn(&Snapshot, &Snapshot) -> TableBits) -> [usize; 2] {
    let tables = a.iter().zip(b).map(|(a, b)| table(a, b));
    tables.fold(
        [a.len().abs_diff(b.len()), 0],
        |[differing, numbers], table| [differing + table.differing, numbers + table.numbers],
    )
}

/// Whether any number of two moments differs.
pub fn differ(a: &Snapshot, b: &Snapshot) -> bool {
    !motion(a, b).agrees() || !contacts(a, b).agrees()
}

/// The native engine against YADE where there is no YADE: the first steps of the recorded run, by the
/// digests of its states.
pub fn recorded() -> Vec<CaseGroup> {
    /// Steps of pouring; enough for three forces on a grain, so that the order of sums shows.
    const STEPS: u64 = 3_000;
    // The program carries the record; a broken one leaves no moments, and the group fails.
    let mut recorded = recorded_history().unwrap_or_default();
    recorded.retain(|row| row.stage == Stage::Settle && row.step <= STEPS);
    let scene = paper_scene(1, 5000);
    let moments = recorded.iter().map(|row| row.step).collect();
    let case = poured("the paper's cloud".to_owned(), &scene, moments);
    let title =
        "Pouring the paper's 5,000 grains gives the states that YADE gave when it was recorded";
    let mut group = CaseGroup::new(RECORDED, title).with("", case, move |track, figures| {
        let moments = track.iter().zip(&recorded);
        let differing = moments.filter(|(moment, row)| moment.bodies.digest() != row.state);
        let differing = differing.count() + track.len().abs_diff(recorded.len());
        let none = recorded.is_empty();
        let value = if none { f64::NAN } else { differing as f64 };
        let what = format!("states: states whose bits differ; of {}, 1", recorded.len());
        figures.because("same operations in the same order: every bit");
        figures.is(&what, value, 0.0, 0.0);
    });
    group.evidence = Evidence::CrossCode;
    vec![group]
}

/// The group that only an engine with YADE's bits can pass.
pub const RECORDED: &str = "recorded-pouring";

/// Inner width of the box, m.
const WIDTH: f64 = 0.4;
/// Centre and half-extents of the punch, m.
const PUNCH: [[f64; 2]; 2] = [[0.2, 0.25], [0.05, 0.03]];

/// A random static state for each option: overlapping grains between walls and around a punch.
pub fn static_states() -> Vec<CrossCase> {
    use Place::{Corner, Face, Grains, Inside, Wall};
    let state = |(stream, (id, what, law)): (u64, (&str, &str, Law))| {
        let walls: [&[f64]; 2] = [&[0.0, WIDTH], &[0.0]];
        let model = suite::world(law, 1.0e-6, [0.3, -9.81], 0.3, walls);
        let moments = vec![0, 1, 2, 3, 30];
        let mut case = suite::case(&format!("static {id}"), model, &scattered(stream), moments);
        let [centre, half_extents] = PUNCH;
        let bottom = centre[1] - half_extents[1];
        case.punch = Some(suite::punch(centre[0], bottom, half_extents, -0.7));
        CrossCase {
            id: format!("static-state-{id}"),
            title: format!("Forces, torques and motion from a random static state: {what}"),
            case,
            places: vec![Grains, Wall, Face, Corner, Inside],
        }
    };
    (0..).zip(laws()).map(state).collect()
}

/// Every contact law that YADE has, with its id and what it is.
fn laws() -> [(&'static str, &'static str, Law); 8] {
    use SlipVelocity::{ContactPoint, RatchetingCorrected};
    // Pa; soft, so that deep overlaps do not throw the grains apart at once.
    const MODULUS: f64 = 1.0e7;
    let free = |slip_velocity, torque_arms| {
        let mut law = friction(MODULUS, 0.7, 0.4);
        law.contact.slip_velocity = slip_velocity;
        law.contact.torque_arms = torque_arms;
        law
    };
    let mut blocked = friction(MODULUS, 0.7, 0.4);
    blocked.contact.rotation = Rotation::Blocked;
    let dashpot = |law| with_viscosity(law, Viscosity::dashpot(37.3, Tension::Clipped));
    [
        ("frictionless", "normal springs only", springs(MODULUS)),
        (
            "friction",
            "friction, corrected slip, half-overlap arms",
            free(RatchetingCorrected, TorqueArms::HalfOverlap),
        ),
        (
            "friction-ratcheting",
            "friction, contact point slip, half-overlap arms",
            free(ContactPoint, TorqueArms::HalfOverlap),
        ),
        (
            "friction-point-arms",
            "friction, corrected slip, contact point arms",
            free(RatchetingCorrected, TorqueArms::ContactPoint),
        ),
        (
            "friction-point",
            "friction, contact point slip and arms",
            free(ContactPoint, TorqueArms::ContactPoint),
        ),
        ("friction-blocked", "friction, rotations blocked", blocked),
        (
            "dashpot",
            "dashpots without friction",
            dashpot(springs(MODULUS)),
        ),
        (
            "dashpot-friction",
            "dashpots and friction",
            dashpot(friction(MODULUS, 0.7, 0.4)),
        ),
    ]
}

/// Grains thrown at random into the box, every other one at the punch, some at each wall.
fn scattered(stream: u64) -> Vec<Grain> {
    const GRAINS: usize = 160;
    /// m.
    const RADII: [f64; 2] = [0.005, 0.015];
    let mut random = Source::new(b"crossgrain: random frozen states", stream);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.uniform();
    let [centre, half] = PUNCH;
    let mut grain = |index: usize| {
        let radius = uniform(RADII[0], RADII[1]);
        let position = if index.is_multiple_of(2) {
            [0, 1].map(|axis| {
                let reach = half[axis] + 0.9 * RADII[1];
                uniform(centre[axis] - reach, centre[axis] + reach)
            })
        } else {
            match index % 20 {
                1 => [0.8 * radius, uniform(0.002, 0.2)],
                3 => [WIDTH - 0.8 * radius, uniform(0.002, 0.2)],
                5 => [uniform(0.002, WIDTH - 0.002), 0.8 * radius],
                _ => [uniform(0.002, WIDTH - 0.002), uniform(0.002, 0.2)],
            }
        };
        let velocity = [uniform(-2.0, 2.0), uniform(-2.0, 2.0)];
        Grain::disc(position, radius, 2600.0)
            .moving(velocity)
            .spinning(uniform(-300.0, 300.0))
    };
    (0..GRAINS).map(&mut grain).collect()
}

/// Largest spin of the cloud, rad/s.
const SPIN: f64 = 50.0;

/// Grains, steps of pouring and steps under the punch.
const SIZES: [(u32, u64, u64); 3] = [
    (5, 20_000, 20_000),
    (500, 8_000, 3_000),
    (5_000, 3_000, 1_500),
];

/// Steps of pouring in the native engine that make the bed for the punch.
const BED_STEPS: u64 = 12_000;

/// A case for each size up to `most_grains`, law and stage.
pub fn cases(most_grains: u32) -> Vec<CrossCase> {
    let mut cases = Vec::new();
    for (grains, pour, load) in SIZES {
        if grains > most_grains {
            continue;
        }
        for (law, scene) in [("friction", rough(grains)), ("dashpot", viscous(grains))] {
            let pouring = ["pouring", "pouring"];
            let case = poured(format!("pour {grains}"), &scene, moments(pour));
            cases.push(cross_case(grains, law, pouring, case));
            if let Some(case) = pressed(&scene, load) {
                cases.push(cross_case(grains, law, ["punch", "under the punch"], case));
            }
        }
    }
    cases
}

/// The paper's scene with so many grains, friction 0.5 and spins.
pub fn rough(grains: u32) -> Scene {
    let mut scene = paper_scene(1, grains);
    scene.material.friction_angle = 0.5;
    scene.material.stiffness_ratio = 0.3;
    let Cloud::JitteredLattice { columns, spin, .. } = &mut scene.cloud;
    *spin = SPIN;
    // A few grains stand in a narrow box, so that they meet.
    if grains < 100 {
        *columns = 2;
        scene.container.width = 0.025;
        scene.loading.half_width = 0.006;
        scene.measurement.local_radius = 0.02;
    } else if grains < 1_000 {
        *columns = 25;
        scene.container.width = 0.3125;
    }
    scene
}

/// The same with dashpots of 0.3 of the critical constant of two mean grains.
pub fn viscous(grains: u32) -> Scene {
    let mut scene = rough(grains);
    let radius = 0.5 * scene.particles.mean_diameter;
    let stiffness = scene.material.youngs_modulus * radius;
    let effective_mass = 0.5 * scene.grain_mass(radius);
    let c_n = 0.3 * 2.0 * (effective_mass * stiffness).sqrt();
    let viscosity = Viscosity::dashpot(c_n, Tension::Clipped);
    scene.contact = suite::with_viscosity(suite::springs(1.0), viscosity).contact;
    scene
}

/// The scene's cloud, poured and looked at in these moments.
pub fn poured(name: String, scene: &Scene, moments: Vec<u64>) -> Case {
    Case::new(name, Model::of(scene), initial_bodies(scene), moments)
}

/// A bed that the native engine poured, with the punch set on it; none if that failed, which a case
/// of pouring shows.
fn pressed(scene: &Scene, steps: u64) -> Option<Case> {
    let name = format!("press {}", scene.particles.count);
    let mut bed = poured(name, scene, vec![BED_STEPS]);
    bed.bodies = run_case(&bed, None).ok()?.pop()?.bodies;
    bed.punch = Some(first_contact_punch(scene, &bed.bodies));
    bed.moments = moments(steps);
    Some(bed)
}

/// Ten moments, evenly spread.
fn moments(steps: u64) -> Vec<u64> {
    (0..=10).map(|tenth| tenth * steps / 10).collect()
}

fn cross_case(grains: u32, law: &str, [id, stage]: [&str; 2], case: Case) -> CrossCase {
    let steps = case.moments.last().copied().unwrap_or(0);
    CrossCase {
        id: format!("trajectory-{grains}-{law}-{id}"),
        title: format!("{grains} spinning grains with {law}, {steps} steps {stage}"),
        case,
        places: Vec::new(),
    }
}
