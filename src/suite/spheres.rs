//! The field's own tests with spheres: two bodies meet as Chung and Ooi published (Granular Matter 13 (2011) 643, tests 1 to 8), the
//! models of MFiX' and LAMMPS' suites, motions that are prescribed for both bodies as ON-DEM has them.
//!
//! One judge for all. The exact answer is the limit of ever shorter steps of the step written out, under the engine's own rules; how
//! far the model's step of the case's own length is from it is what a step of that length costs any engine. An engine must be as near to
//! the model's step as rounding allows, and no further from the exact answer than that step.

use std::f64::consts::PI;
use std::sync::{LazyLock, OnceLock};

use serde::Deserialize;

use super::exact::{Known, ROUNDING, largest_difference, numbers};
use super::{CaseGroup, at, springs, world};
use grains::model::{Axis, Law, Model, Solid, Wall};
use grains::rules::{Rules, WallRadius, WallStiffness};
use grains::scene::{AdhesionLaw, Rolling, Springs, Tension, TorqueArms, Viscosity};
use grains::tables::Bodies;
use grains::task::Case;
use grains::vector::{Vector, hypot, plus, times};

/// Steps of a contact, by the time that Hertz's spring takes without a dashpot.
const STEPS: f64 = 400.0;
/// Where surfaces slip to: across, and a third of a turn away from every axis.
const WAY: Vector = [0.8, 0.6, 0.0];

/// One of Chung and Ooi's tests: `chung_ooi.json`, read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Published {
    id: &'static str,
    title: &'static str,
    materials: Vec<Material>,
    /// m.
    radius: f64,
    /// A sphere of the same material that is met: how many times the radius and the density it has. None is a plane that does not
    /// give way.
    other: Option<[f64; 2]>,
    /// Of the approach, m/s.
    speed: f64,
    restitution: f64,
    /// In central impacts nothing slips, so an engine without friction has the first two tests too; published is 0.35.
    friction: f64,
    varied: Varied,
    values: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Material {
    name: &'static str,
    /// Pa.
    modulus: f64,
    poissons_ratio: f64,
    /// kg/m³.
    density: f64,
}

/// What differs from run to run.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Varied {
    Restitution,
    /// Degrees from the normal, of a velocity that is otherwise the same.
    Angle,
    /// Along the surface, m/s.
    Along,
    /// Of the first one, rad/s.
    Spin,
    /// Of both, against each other, rad/s.
    OppositeSpins,
}

static PUBLISHED: LazyLock<Vec<Published>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("chung_ooi.json")).expect("it is a list of tests")
});

/// A sphere at the start.
#[derive(Clone, Copy)]
pub(crate) struct Sphere {
    place: Vector,
    velocity: Vector,
    spin: Vector,
    pub radius: f64,
    /// kg; the moment of inertia is that of a ball.
    pub mass: f64,
}

impl Sphere {
    pub(crate) fn new(place: Vector, radius: f64, density: f64) -> Self {
        Sphere {
            place,
            velocity: [0.0; 3],
            spin: [0.0; 3],
            radius,
            mass: density * (4.0 / 3.0) * PI * radius.powi(3),
        }
    }

    pub(crate) fn at(self, place: Vector) -> Self {
        Sphere { place, ..self }
    }

    pub(super) fn moving(self, velocity: Vector) -> Self {
        Sphere { velocity, ..self }
    }

    fn spinning(self, spin: Vector) -> Self {
        Sphere { spin, ..self }
    }

    /// So heavy that nothing changes its motion.
    fn prescribed(self) -> Self {
        Sphere {
            mass: 1.0e18,
            ..self
        }
    }
}

/// All groups, of an engine that has these rules.
pub fn groups(rules: Rules) -> Vec<CaseGroup> {
    let published = PUBLISHED.iter().map(|test| {
        let group = CaseGroup::new(test.id, test.title);
        let impacts = impacts(test, rules).into_iter();
        impacts.fold(group, |group, impact| {
            let hertz = impact.is_elastic().then_some(impact.largest);
            with(group, impact.case, hertz)
        })
    });
    let further = further(rules).into_iter().map(|(id, title, cases)| {
        let group = CaseGroup::new(id, title);
        cases
            .into_iter()
            .fold(group, |group, case| with(group, case, None))
    });
    published.chain(further).collect()
}

/// One impact of a published test, with what its closed forms need.
struct Impact {
    case: Case,
    /// N, m and s: Hertz's largest force and overlap and the time of contact, without dashpots.
    largest: [f64; 3],
}

impl Impact {
    /// Whether it is Hertz's own: without dashpots, and nothing slips.
    fn is_elastic(&self) -> bool {
        let bodies = &self.case.bodies;
        let mut across = bodies.spin.iter().chain(&bodies.vx);
        self.case.model.law.contact.viscosity == Viscosity::None
            && across.all(|component| *component == 0.0)
    }
}

fn impacts(test: &Published, rules: Rules) -> Vec<Impact> {
    let runs = test.materials.iter().flat_map(|material| {
        test.values.iter().map(move |value| {
            let (mut e, mut approach) = (test.restitution, test.speed);
            let (mut along, mut spins) = (0.0, [0.0; 2]);
            let what = match test.varied {
                Varied::Restitution => {
                    e = *value;
                    "e"
                }
                Varied::Angle => {
                    approach = test.speed * value.to_radians().cos();
                    along = test.speed * value.to_radians().sin();
                    "angle"
                }
                Varied::Along => {
                    along = *value;
                    "along"
                }
                Varied::Spin => {
                    spins[0] = *value;
                    "spin"
                }
                Varied::OppositeSpins => {
                    // The same turn makes surfaces slip against each other.
                    spins = [*value; 2];
                    "spins"
                }
            };
            let name = format!("{}-{what}-{value}", material.name);
            impact(name, test, material, e, (approach, along, spins), rules)
        })
    });
    runs.collect()
}

fn impact(
    name: String,
    test: &Published,
    material: &Material,
    e: f64,
    (approach, along, spins): (f64, f64, [f64; 2]),
    rules: Rules,
) -> Impact {
    let (radius, modulus, poissons_ratio) =
        (test.radius, material.modulus, material.poissons_ratio);
    let mut law = hertz_mindlin(modulus, poissons_ratio, test.friction.atan());
    if e < 1.0 {
        law.contact.viscosity = Viscosity::restitution(e, Tension::Clipped);
    }
    // About the axis that lets the surface run along [`WAY`].
    let turn = |spin: f64| times(spin, [-WAY[1], WAY[0], 0.0]);
    let first = Sphere::new([0.0; 3], radius, material.density).spinning(turn(spins[0]));
    let mut spheres = vec![first];
    let (radius_mean, mass) = match test.other {
        None => (radius, first.mass),
        Some([larger, denser]) => {
            let second = Sphere::new([0.0; 3], larger * radius, denser * material.density);
            spheres.push(second.spinning(turn(spins[1])));
            (
                radius * second.radius / (radius + second.radius),
                first.mass * second.mass / (first.mass + second.mass),
            )
        }
    };
    // E* of two of this material; a plane that does not give way halves what gives.
    let rigid = if test.other.is_none() { 2.0 } else { 1.0 };
    let contact_modulus = rigid * modulus / (2.0 * (1.0 - poissons_ratio * poissons_ratio));
    let stiffness = 4.0 / 3.0 * contact_modulus * radius_mean.sqrt();
    if test.other.is_none() {
        law.modulus *= rigid * 2.0f64.sqrt() / at_walls(rules);
    }
    let depth = (1.25 * mass * approach * approach / stiffness).powf(0.4);
    let time = 2.943_276_1 * depth / approach;
    let dt = time / STEPS;
    // Half a step before touch, and so in the middle of a step of all shorter ones. In a step that ends as they touch, what a spring
    // keeps of the slip would depend on whether it keeps a force, which is none there, or a displacement.
    let gap = 0.5 * dt * approach;
    let mut model = world(law, dt, [0.0; 2], 0.0, [&[], &[]]);
    model.rules = rules;
    let moving = plus(times(along, WAY), [0.0, 0.0, -approach]);
    match spheres.get_mut(1) {
        None => {
            model.walls.push(Wall::at(Axis::Z, 0.0));
            spheres[0].place[2] = radius + gap;
            spheres[0].velocity = moving;
        }
        // The masses' centre stays.
        Some(second) => {
            second.place[2] = -second.radius;
            let share = mass / second.mass;
            second.velocity = times(-share, moving);
            spheres[0].place[2] = radius + gap;
            spheres[0].velocity = times(1.0 - share, moving);
        }
    }
    let slowed = if e < 0.5 { 2.0 } else { 1.5 };
    let moments = [0.25, 0.5, 0.75, slowed].map(|share| 1 + (share * STEPS) as u64);
    let moments = [&[0], &moments[..]].concat();
    Impact {
        case: case(&name, model, &spheres, moments),
        largest: [stiffness * depth.powf(1.5), depth, time],
    }
}

/// How many times as stiff as two grains with half its radius a sphere and a wall are by these rules.
fn at_walls(rules: Rules) -> f64 {
    let flat = match rules.wall_radius {
        WallRadius::AsGrain => 1.0,
        WallRadius::Flat => 2.0f64.sqrt(),
    };
    match rules.wall_stiffness {
        WallStiffness::AsGrain => flat,
        WallStiffness::Rigid => 2.0 * flat,
    }
}

pub(crate) fn hertz_mindlin(modulus: f64, poissons_ratio: f64, friction_angle: f64) -> Law {
    let mut law = springs(modulus);
    law.poissons_ratio = Some(poissons_ratio);
    law.friction_angle = friction_angle;
    law.contact.springs = Springs::HertzMindlin;
    law.contact.torque_arms = TorqueArms::ContactPoint;
    law
}

pub(crate) fn case(name: &str, model: Model, spheres: &[Sphere], moments: Vec<u64>) -> Case {
    let column = |number: &dyn Fn(&Sphere) -> f64| spheres.iter().map(number).collect::<Vec<f64>>();
    let mut bodies = Bodies {
        x: column(&|sphere| sphere.place[0]),
        y: column(&|sphere| sphere.place[1]),
        z: column(&|sphere| sphere.place[2]),
        vx: column(&|sphere| sphere.velocity[0]),
        vy: column(&|sphere| sphere.velocity[1]),
        vz: column(&|sphere| sphere.velocity[2]),
        radius: column(&|sphere| sphere.radius),
        mass: column(&|sphere| sphere.mass),
        ..Bodies::default()
    };
    if model.law.rotates() {
        bodies.spin_x = column(&|sphere| sphere.spin[0]);
        bodies.spin = column(&|sphere| sphere.spin[1]);
        bodies.spin_z = column(&|sphere| sphere.spin[2]);
        bodies.inertia = column(&|sphere| 0.4 * sphere.mass * sphere.radius * sphere.radius);
    }
    Case::new(name, model, bodies, moments)
}

/// The models of other suites, and prescribed motions: id, title and cases.
fn further(rules: Rules) -> Vec<(&'static str, &'static str, Vec<Case>)> {
    let soft = |friction: f64| hertz_mindlin(1.0e7, 0.3, friction);
    let ball = |height: f64| Sphere::new([0.0, 0.0, height], 0.005, 2500.0);
    let damped = |mut law: Law, e_n: f64| {
        law.contact.viscosity = Viscosity::restitution(e_n, Tension::Clipped);
        law
    };
    let moments = |end: u64| [0, 1, end / 8, end / 4, end / 2, end].to_vec();
    let on_floor = |law: Law, gravity: [f64; 2]| Model {
        rules,
        ..world(law, 2.0e-6, gravity, 0.0, [&[], &[0.0]])
    };
    let free = |law: Law| Model {
        rules,
        ..world(law, 2.0e-6, [0.0; 2], 0.0, [&[], &[]])
    };
    let weight = [0.0, -9.81];
    // One sphere on the floor.
    let on = |name: &str, law: Law, gravity: [f64; 2], sphere: Sphere, end: u64| {
        case(name, on_floor(law, gravity), &[sphere], moments(end))
    };
    let heavy = |name: &str, law: Law, sphere: Sphere| on(name, law, weight, sphere, 6000);
    let incline = [9.81 * 0.3f64.sin(), -9.81 * 0.3f64.cos()];
    // Pressed by its weight alone.
    let sunk = 0.005 - 2.0e-7;
    let slipping = ball(sunk).moving(times(0.02, WAY));
    let spinning = |spin: Vector| ball(sunk).spinning(spin);
    let swinging = spinning([-6.0, 8.0, 0.0]).moving(times(0.05, WAY));
    let rolling_out = slipping.spinning([-2.4, 3.2, 0.0]);
    let twisting = spinning([0.0, 0.0, 5.0]);
    let and_twisting = slipping.spinning([-2.4, 3.2, 5.0]);
    let resisting = |bending_stiffness, twisting_stiffness, limit| {
        let mut law = damped(soft(0.5), 0.5);
        law.contact.rolling = Some(Rolling {
            bending_stiffness,
            twisting_stiffness,
            limit,
        });
        law
    };
    let rolls = |limit: Option<f64>, stiffer: f64| resisting(Some(2.0e-3 * stiffer), 1.0e-3, limit);
    let constant = |limit: f64| resisting(None, 0.0, Some(limit));
    let linear = |c_n: f64, friction_angle: f64| {
        let mut law = springs(1.0e6);
        law.friction_angle = friction_angle;
        law.contact.viscosity = Viscosity::dashpot(c_n, Tension::Clipped);
        law.contact.torque_arms = TorqueArms::ContactPoint;
        law
    };
    let unequal = [ball(0.0049), Sphere::new([0.0, 0.0, 0.0148], 0.005, 5000.0)];
    let stack = [1.0, 3.0, 5.0].map(|radii| ball(radii * sunk));
    let floor = on_floor(damped(soft(0.3), 0.5), weight);
    let squeezed = {
        let mut model = on_floor(linear(0.05, 0.0), weight);
        model.walls.push(Wall::at(Axis::Z, 0.0197));
        model
    };
    let corner = {
        let mut model = on_floor(damped(soft(0.4), 0.6), weight);
        let sides = [Axis::X, Axis::Y].map(|axis| Wall::at(axis, 0.0));
        model.walls.extend(sides);
        model
    };
    // Half a step before the floor, too.
    let in_corner = Sphere::new([0.006, 0.0055, 0.0050003], 0.005, 2500.0)
        .moving([-0.5, -0.4, -0.3])
        .spinning([20.0, -30.0, 40.0]);
    let at_once = [
        ball(0.005)
            .moving([0.0, 0.1, -0.4])
            .spinning([30.0, 0.0, 10.0]),
        Sphere::new([0.0071, 0.0, -0.0021], 0.005, 5000.0).spinning([0.0, 40.0, 0.0]),
        Sphere::new([-0.0061, 0.0021, -0.0031], 0.004, 1500.0).spinning([0.0, 0.0, -50.0]),
    ];
    let prescribed = |overlap: f64, motions: [[Vector; 2]; 2]| {
        let places = [[0.0; 3], [0.006, 0.0, 0.007]];
        let radius = 0.5 * (hypot(places[1]) + overlap);
        [0, 1].map(|at| {
            let [velocity, spin] = motions[at];
            let sphere = Sphere::new(places[at], radius, 2500.0);
            sphere.moving(velocity).spinning(spin).prescribed()
        })
    };
    let moving = |velocity: Vector| [velocity, [0.0; 3]];
    let turning = |spin: Vector| [[0.0; 3], spin];
    let still = [[0.0; 3]; 2];
    // Across the normal (0.6, 0, 0.8)/1, along it, and turns about it and across it.
    let across = times(0.05, [-0.7592566, 0.0, 0.6507914]);
    let aside = [0.0, 0.04, 0.0];
    let normal = [0.6507914, 0.0, 0.7592566];
    let unlike = |adhesion: Option<f64>| {
        let mut law = damped(soft(0.4), 0.7);
        law.contact.adhesion = adhesion;
        law.materials = vec![Solid {
            modulus: 2.5e7,
            stiffness_ratio: 1.0,
            poissons_ratio: 0.2,
            friction_angle: 0.2,
        }];
        let first = ball(0.0031).moving([0.3, 0.1, -0.4]);
        let second = Sphere::new([0.0071, 0.0, -0.0021], 0.004, 5000.0);
        let both = [
            first.spinning([30.0, 0.0, 10.0]),
            second.spinning([0.0, 40.0, 0.0]),
        ];
        let mut case = case("unlike", free(law), &both, moments(800));
        case.bodies.material = vec![0, 1];
        case
    };
    let still_and_away = [still, moving(times(0.05, normal))];
    let sticky = |name: &str, by: AdhesionLaw, motions: [[Vector; 2]; 2]| {
        let mut law = soft(0.0);
        law.contact.adhesion = Some(0.05);
        law.contact.adhesion_law = by;
        case(name, free(law), &prescribed(2.0e-5, motions), moments(240))
    };
    let held = |name: &str, law: Law, one: [Vector; 2], other: [Vector; 2]| {
        let both = prescribed(5.0e-5, [one, other]);
        case(name, free(law), &both, moments(400))
    };
    vec![
        (
            "mfix-dem-01",
            "MFiX DEM01 and LAMMPS' freefall: a sphere falls, bounces on springs and dashpots, linear and Hertz's",
            vec![
                on("linear", linear(0.05, 0.0), weight, ball(0.0055), 8000),
                on("hertz", damped(soft(0.0), 0.9), weight, ball(0.0055), 8000),
            ],
        ),
        (
            "mfix-dem-03",
            "MFiX DEM03 and LAMMPS' stack: two spheres of other masses squeezed between two planes",
            vec![
                case("squeezed", squeezed, &unequal, moments(2000)),
                case("stacked", floor, &stack, moments(4000)),
            ],
        ),
        (
            "mfix-dem-04",
            "MFiX DEM04 and LAMMPS' slip: a sphere slips on a plane until it rolls",
            vec![
                heavy("slips", damped(soft(0.2), 0.5), slipping),
                heavy("spins", damped(soft(0.2), 0.5), spinning([3.0, 2.0, 5.0])),
            ],
        ),
        (
            "lammps-rolling",
            "LAMMPS' rolling decay, incline and twist decay: moments with a limit",
            vec![
                heavy("decay", rolls(Some(0.02), 1.0), rolling_out),
                on("incline", rolls(Some(0.1), 1.0), incline, ball(sunk), 6000),
                heavy("twist", rolls(Some(0.02), 1.0), twisting),
            ],
        ),
        (
            "moments",
            "Moments without a limit: a sphere swings on a plane, and turns back from a twist",
            vec![
                heavy("swings", rolls(None, 25.0), swinging),
                heavy("twist", rolls(None, 1.0), twisting),
            ],
        ),
        (
            "constant-torque",
            "A constant torque against rolling: a sphere rolls out, and one that also twists",
            vec![
                heavy("decay", constant(0.02), rolling_out),
                heavy("twists", constant(0.02), and_twisting),
            ],
        ),
        (
            "lammps-pull-off",
            "LAMMPS' pull-off: two spheres part against adhesion by DMT and by JKR",
            vec![
                sticky("dmt", AdhesionLaw::Dmt, still_and_away),
                sticky("jkr", AdhesionLaw::Jkr, still_and_away),
            ],
        ),
        (
            "materials",
            "Two spheres of two materials meet",
            vec![unlike(None)],
        ),
        (
            "adhesion",
            "Two spheres of two materials meet, with adhesion",
            vec![unlike(Some(0.5))],
        ),
        (
            "corner",
            "A spinning sphere in a corner of three planes, and three spheres that meet at once",
            vec![
                case("planes", corner, &[in_corner], moments(3000)),
                case(
                    "spheres",
                    free(damped(soft(0.4), 0.7)),
                    &at_once,
                    moments(3000),
                ),
            ],
        ),
        (
            "on-dem",
            "ON-DEM's prescribed motions: forces of two spheres whose motion nothing changes",
            vec![
                held("sticks", soft(0.8), still, moving(across)),
                held("slides", soft(0.05), still, moving(plus(across, aside))),
                held(
                    "rolls",
                    soft(0.5),
                    turning([0.0, 8.0, 0.0]),
                    turning([0.0, -6.0, 0.0]),
                ),
                held(
                    "twists",
                    soft(0.5),
                    [across, times(9.0, normal)],
                    turning(times(-7.0, normal)),
                ),
                held(
                    "turns",
                    soft(0.5),
                    [aside, [5.0, 3.0, -4.0]],
                    [across, [-6.0, 7.0, 2.0]],
                ),
            ],
        ),
        (
            "on-dem-dashpots",
            "ON-DEM's prescribed motions with dashpots: two spheres press each other and part",
            vec![
                held(
                    "presses",
                    linear(1.0, 0.5),
                    moving(aside),
                    moving(times(-0.05, normal)),
                ),
                held(
                    "parts",
                    linear(1.0, 0.5),
                    still,
                    moving(plus(times(0.03, normal), aside)),
                ),
            ],
        ),
    ]
}

/// Adds a case with its judge; with Hertz's largest force and overlap, where these are known.
fn with(group: CaseGroup, case: Case, hertz: Option<[f64; 3]>) -> CaseGroup {
    let (known, own) = (OnceLock::new(), case.clone());
    // An engine computes by the rules that it has, whatever a job says.
    let mut asked = case;
    asked.model.rules = Rules::default();
    group.with(own.name.clone(), asked, move |track, figures| {
        let found = numbers(&own, track);
        let known = known.get_or_init(|| Known::new(&own));
        figures.because("what rounding may make of two bodies that meet, over the largest speed, way or force");
        let off = largest_difference(&found, &known.step);
        figures.is("models-step: largest deviation from the model's own step, 1", off, 0.0, ROUNDING);
        figures.because("what a step of this length costs: how far the model's own step is from the limit of short ones");
        let far = largest_difference(&found, &known.exact);
        let cost = largest_difference(&known.step, &known.exact) + known.spread + ROUNDING;
        figures.is("exact: largest deviation from the exact answer, 1", far, 0.0, cost);
        if let Some([force, overlap, _]) = hertz {
            figures.because("Hertz's closed form in the middle of the contact; the step's angle there, squared");
            let middle = at(track, own.moments[2]);
            let cost = (PI / STEPS).powi(2);
            let found = middle.contact(|contact| contact.normal_force);
            figures.is("hertz-force, N", found, force, cost * force);
            let found = middle.contact(|contact| contact.overlap);
            figures.is("hertz-overlap, m", found, overlap, cost * overlap);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::exact::CONVERGED;
    use grains::variant::{Variant, run};

    /// Limits of short steps are as near as they must be beside what a step of the case's length costs; where nothing begins or ends
    /// to slip, they are known to ten digits.
    #[test]
    fn limits_of_short_steps_are_reached() {
        let mut smooth = 0;
        for group in groups(Rules::default()) {
            for case in &group.cases {
                let known = Known::new(case);
                let cost = largest_difference(&known.step, &known.exact);
                let name = format!(
                    "{} {}: {:.1e} of {cost:.1e}",
                    group.id, case.name, known.spread
                );
                println!("{name}");
                assert!(known.spread < 1.0e-4 && cost < 5.0e-2, "{name}");
                smooth += usize::from(known.spread < CONVERGED);
            }
        }
        assert!(smooth > 20, "{smooth}");
    }

    /// Hertz: the largest force and overlap in the middle of an elastic contact, and its time.
    #[test]
    fn elastic_impacts_are_hertz_own() {
        for test in &PUBLISHED[..3] {
            for impact in impacts(test, Rules::default()) {
                let case = &impact.case;
                if !impact.is_elastic() {
                    continue;
                }
                let halvings = 4;
                let mut fine = case.clone();
                fine.model.dt /= f64::from(1 << halvings);
                // From the touch on, which is half a step after the start.
                let since_touch =
                    |moment: u64| (moment << halvings).saturating_sub(1 << (halvings - 1));
                fine.moments
                    .iter_mut()
                    .for_each(|moment| *moment = since_touch(*moment));
                let track = run(&fine, &Variant::default());
                let top = &track[2].contacts[0];
                let end = track[4].bodies.clone();
                let start = &case.bodies;
                let approach = -start.vz[0] + start.vz.get(1).copied().unwrap_or(0.0);
                let apart = |bodies: &Bodies| bodies.z[0] - bodies.z.get(1).copied().unwrap_or(0.0);
                let gone = (apart(&end) - apart(start)) / approach;
                let time = case.model.dt * case.moments[4] as f64 - 1.5 * case.model.dt - gone;
                let found = [top.normal_force, top.overlap, time];
                for (found, wanted) in found.into_iter().zip(impact.largest) {
                    let off = found / wanted - 1.0;
                    assert!(off.abs() < 1.0e-6, "{} {}: {off:e}", test.id, case.name);
                }
            }
        }
    }

    /// Where a surface slips all through, friction takes μ(1 + e) of the approach, whatever the springs are; the arms of torques are
    /// shorter than radii by the overlap.
    #[test]
    fn impacts_that_slip_all_through_follow_the_published_lines() {
        let mut count = 0;
        for test in &PUBLISHED[3..5] {
            for impact in impacts(test, Rules::default()) {
                let (case, friction) = (&impact.case, test.friction);
                let start = &case.bodies;
                let track = run(case, &Variant::default());
                let end = &track[4].bodies;
                let approach = -start.vz[0];
                let taken = friction * (approach + end.vz[0]);
                let along = hypot([start.vx[0], start.vy[0], 0.0]);
                if along < 1.05 * 3.5 * taken {
                    continue;
                }
                let left = hypot([end.vx[0], end.vy[0], 0.0]);
                let turn = hypot([end.spin_x[0], end.spin[0], end.spin_z[0]]) * test.radius;
                assert!(
                    (along - left - taken).abs() < 2.0e-3 * taken,
                    "{} {}",
                    test.id,
                    case.name
                );
                let arm = turn / (2.5 * taken);
                assert!(
                    arm < 1.0 + 2.0e-3 && arm > 1.0 - impact.largest[1] / test.radius,
                    "{} {}: {arm}",
                    test.id,
                    case.name
                );
                count += 1;
            }
        }
        assert!(count >= 10, "{count}");
    }
}
