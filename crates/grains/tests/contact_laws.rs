//! Contact laws in space against their closed forms: what a tangential spring keeps while the load changes, the radius at walls, and
//! adhesion by Derjaguin, Muller and Toporov and by Johnson, Kendall and Roberts.

use std::f64::consts::PI;

use grains::model::{Law, Model, Wall};
use grains::obstacle::{Obstacle, Surface};
use grains::rules::{
    ConstantMoment, MomentLimit, MomentTurn, MomentsAtWalls, Rules, SpringMemory, SpringTurn,
    TangentialRestitution, WallRadius, WallStiffness,
};
use grains::scene::{AdhesionLaw, ContactLaw, Rolling, Springs, Tension, Viscosity};
use grains::tables::{Bodies, Snapshot};
use grains::task::Case;
use grains::variant::{self, Variant};
use grains::vector::{Vector, cross, dot, minus, norm, times};

const MODULUS: f64 = 2.0e7;
const POISSON: f64 = 0.3;
const RADII: [f64; 2] = [0.005, 0.004];
const ENERGY: f64 = 0.5;
const FRICTION: f64 = 0.5;

/// R* and E* of the two spheres.
fn effective() -> [f64; 2] {
    let [a, b] = RADII;
    [a * b / (a + b), MODULUS / (2.0 * (1.0 - POISSON * POISSON))]
}

fn model(law: AdhesionLaw, rules: Rules) -> Model {
    Model {
        gravity: [0.0; 2],
        alpha: 0.0,
        dt: 1.0e-7,
        walls: Vec::new(),
        obstacles: Vec::new(),
        law: Law {
            modulus: MODULUS,
            stiffness_ratio: 1.0,
            friction_angle: FRICTION,
            wall_friction_angle: None,
            punch_friction_angle: None,
            poissons_ratio: Some(POISSON),
            materials: Vec::new(),
            contact: ContactLaw {
                springs: Springs::HertzMindlin,
                adhesion: Some(ENERGY).filter(|_| law != AdhesionLaw::Pull),
                adhesion_law: law,
                ..ContactLaw::default()
            },
        },
        rules,
    }
}

/// Spheres at these places along x, so heavy that nothing changes how they move.
fn spheres(places: &[(f64, f64, f64)]) -> Bodies {
    let mut bodies = Bodies::default();
    for (radius, place, velocity) in places {
        bodies.push([*place, 0.0], [*velocity, 0.0], *radius, 1.0e30);
        bodies.inertia.push(1.0e30);
    }
    let none = vec![0.0; bodies.len()];
    for column in [
        &mut bodies.y,
        &mut bodies.vy,
        &mut bodies.spin,
        &mut bodies.spin_x,
        &mut bodies.spin_z,
    ] {
        column.clone_from(&none);
    }
    bodies
}

/// The two spheres whose overlap goes from the one to the other while both turn, so that they slip by so much.
fn path(model: Model, [from, to]: [f64; 2], slip: f64, steps: u64) -> Vec<Snapshot> {
    let time = steps as f64 * model.dt;
    let [a, b] = RADII;
    let mut bodies = spheres(&[(a, 0.0, 0.0), (b, a + b - from, (from - to) / time)]);
    bodies.spin_z = vec![slip / time / (a + b); 2];
    let case = Case {
        name: "two spheres".to_owned(),
        model,
        bodies,
        punch: None,
        moments: (0..=steps).collect(),
    };
    variant::run(&case, &Variant::default())
}

/// Over the force of a spring that keeps a force; k_s goes with √u, u and the slip with time.
#[test]
fn what_a_spring_keeps_while_the_load_changes_is_its_rule() {
    let steps = 4000;
    for [from, to] in [[1.0e-5f64, 9.0e-5], [1.5e-4, 7.0e-5]] {
        let force = 2.0 / 3.0 * (to.powf(1.5) - from.powf(1.5)) / (to - from);
        let (constant, falls) = (to.sqrt() / force, to < from);
        let both = to * 2.0 * (from.sqrt() - to.sqrt()) / (from - to) / force;
        for (memory, wanted) in [
            (SpringMemory::Displacement, constant),
            (
                SpringMemory::DisplacementRescaled,
                if falls { both } else { constant },
            ),
            (
                SpringMemory::ForceRescaled,
                if falls { constant } else { 1.0 },
            ),
        ] {
            let last = |spring_memory| {
                let rules = Rules {
                    spring_memory,
                    ..Rules::default()
                };
                let run = path(model(AdhesionLaw::Pull, rules), [from, to], 1.0e-6, steps);
                run[steps as usize].contacts[0].tangential_force
            };
            let ratio = last(memory) / last(SpringMemory::Force);
            println!(
                "{from:e} to {to:e} m, {memory:?}: {:+.1} %",
                100.0 * (ratio - 1.0)
            );
            assert!(
                (ratio / wanted - 1.0).abs() < 1.0e-3,
                "{memory:?}: {ratio}, {wanted}"
            );
        }
    }
}

/// Of a force that is limited a spring that keeps a displacement has what makes the limit.
#[test]
fn a_displacement_is_cut_with_the_force() {
    let rules = Rules {
        spring_memory: SpringMemory::Displacement,
        ..Rules::default()
    };
    let run = path(
        model(AdhesionLaw::Pull, rules),
        [1.5e-4, 7.0e-5],
        4.0e-4,
        500,
    );
    let contact = run[500].contacts[0];
    let limit = FRICTION.tan() * contact.normal_force;
    assert!((contact.tangential_force / limit - 1.0).abs() < 1.0e-12);
}

/// An engine that has one restitution for both directions does not hear of one along the tangent.
#[test]
fn one_restitution_is_that_along_the_normal() {
    let last = |tangential_restitution, own| {
        let rules = Rules {
            tangential_restitution,
            ..Rules::default()
        };
        let mut model = model(AdhesionLaw::Pull, rules);
        model.law.contact.viscosity = Viscosity::Ratio {
            ratio: 0.3,
            tension: Tension::Clipped,
        };
        model.law.contact.tangential_viscosity = own;
        path(model, [1.0e-5, 2.0e-5], 1.0e-9, 10)[10].contacts[0].tangential_force
    };
    let [as_model, as_normal] = [
        TangentialRestitution::AsModel,
        TangentialRestitution::AsNormal,
    ];
    let wanted = last(as_model, None);
    for own in [None, Some(0.0), Some(0.1)] {
        let found = last(as_normal, own) / wanted;
        assert!((found - 1.0).abs() < 1.0e-12, "{own:?}: {found}");
    }
    assert!((last(as_model, Some(0.1)) / wanted - 1.0).abs() > 0.5);
}

/// The normal force on a sphere at x = R − u before a wall, a plane, a triangle and a box at x = 0.
fn at_walls(law: AdhesionLaw, rules: Rules) -> [f64; 4] {
    let (radius, overlap) = (RADII[0], 5.0e-5);
    let wall = Wall {
        axis: grains::model::Axis::X,
        place: 0.0,
    };
    let [a, b, c] = [[0.0, -1.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 2.0]];
    let plane = Surface::Plane {
        point: [0.0; 3],
        normal: [1.0, 0.0, 0.0],
    };
    let triangle = Surface::Triangle {
        vertices: [a, b, c],
    };
    let body = Surface::Box {
        centre: [-1.0, 0.0, 0.0],
        half_extents: [1.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
    };
    let obstacles = [None, Some(plane), Some(triangle), Some(body)];
    obstacles.map(|obstacle| {
        let mut model = model(law, rules);
        match obstacle {
            None => model.walls = vec![wall],
            Some(shape) => model.obstacles = vec![Obstacle::still(shape)],
        }
        let case = Case {
            name: "a sphere at a wall".to_owned(),
            model,
            bodies: spheres(&[(radius, radius - overlap, 0.0)]),
            punch: None,
            moments: vec![0],
        };
        variant::run(&case, &Variant::default())[0].contacts[0].normal_force
    })
}

#[test]
fn a_flat_wall_has_the_radius_of_the_grain() {
    let near = |found: [f64; 4], wanted: [f64; 4]| {
        let near = |(found, wanted): (&f64, &f64)| (found / wanted - 1.0).abs() < 1.0e-9;
        assert!(found.iter().zip(&wanted).all(near), "{found:?} {wanted:?}");
    };
    let flat = Rules {
        wall_radius: WallRadius::Flat,
        ..Rules::default()
    };
    let rigid = Rules {
        wall_stiffness: WallStiffness::Rigid,
        ..flat
    };
    let [radius, modulus] = [RADII[0], effective()[1]];
    let force = |radius: f64| 4.0 / 3.0 * modulus * radius.sqrt() * 5.0e-5f64.powf(1.5);
    let [half, facet, whole] = [0.5, 2.0 / 3.0, 1.0].map(|share| force(share * radius));
    let pull = AdhesionLaw::Pull;
    near(at_walls(pull, Rules::default()), [half, half, facet, half]);
    near(at_walls(pull, flat), [whole; 4]);
    near(at_walls(pull, rigid), [2.0 * whole; 4]);
    let pulled = whole - 4.0 * PI * radius * ENERGY;
    near(at_walls(AdhesionLaw::Dmt, flat), [pulled; 4]);
}

#[test]
fn derjaguins_pull_ends_with_the_surfaces_and_limits_friction_from_above() {
    let [radius, modulus] = effective();
    let pull = 4.0 * PI * radius * ENERGY;
    let run = path(
        model(AdhesionLaw::Dmt, Rules::default()),
        [2.0e-5, -1.0e-7],
        1.0e-4,
        2010,
    );
    let mut last = 0.0;
    for contact in run.iter().flat_map(|moment| &moment.contacts) {
        let hertz = 4.0 / 3.0 * modulus * radius.sqrt() * contact.overlap.powf(1.5);
        assert!((contact.normal_force - (hertz - pull)).abs() < 1.0e-12 * pull);
        let limit = FRICTION.tan() * (hertz + pull);
        assert!(contact.tangential_force.abs() < limit * (1.0 + 1.0e-12));
        last = contact.normal_force;
        if contact.overlap < 1.0e-5 {
            assert!((contact.tangential_force.abs() / limit - 1.0).abs() < 1.0e-12);
        }
    }
    println!("pull-off {last} N, 4πγR* = {pull} N");
    assert!((last / -pull - 1.0).abs() < 1.0e-3 && run[2010].contacts.is_empty());
}

/// With friction, which limits by F + 2·3πγR*, and without, where contacts remember that they touch.
#[test]
fn a_contact_of_johnson_begins_at_the_surfaces_and_ends_at_the_largest_pull() {
    let [radius, modulus] = effective();
    let pull = 3.0 * PI * radius * ENERGY;
    let largest = (9.0 * PI * ENERGY * radius * radius / (4.0 * modulus)).cbrt();
    let end = -largest * largest / (3.0 * radius);
    for friction in [FRICTION, 0.0] {
        let mut model = model(AdhesionLaw::Jkr, Rules::default());
        model.law.friction_angle = friction;
        let run = path(model.clone(), [2.0e-5, 2.0 * end], 1.0e-4, 2000);
        let (mut least, mut lowest) = (0.0f64, 0.0f64);
        for contact in run.iter().flat_map(|moment| &moment.contacts) {
            let (u, force) = (contact.overlap, contact.normal_force);
            // a by halving, from where the pull is largest up.
            let (mut low, mut high) = (largest, 10.0 * largest);
            for _ in 0..200 {
                let a = 0.5 * (low + high);
                let overlap = a * a / radius - 2.0 * (PI * ENERGY * a / modulus).sqrt();
                if overlap < u { low = a } else { high = a }
            }
            let a = 0.5 * (low + high);
            let wanted = 4.0 * modulus * a.powi(3) / (3.0 * radius)
                - 2.0 * PI * a * a * (4.0 * ENERGY * modulus / (PI * a)).sqrt();
            assert!(
                (force - wanted).abs() < 1.0e-9 * pull,
                "{u}: {force}, {wanted}"
            );
            (least, lowest) = (least.min(u), lowest.min(force));
            if u < 1.0e-5 {
                let limit = friction.tan() * (force + 2.0 * pull);
                assert!((contact.tangential_force.abs() - limit).abs() <= 1.0e-12 * pull);
            }
        }
        println!("ends at {least:e} m of {end:e}; pull-off {lowest} N, 3πγR* = {pull} N");
        assert!(least >= end && least < 0.99 * end && run[2000].contacts.is_empty());
        assert!((lowest / -pull - 1.0).abs() < 1.0e-4);
        // The way back: nothing before they touch.
        let run = path(model, [2.0 * end, 1.0e-7], 0.0, 2000);
        let first = run.iter().find_map(|moment| moment.contacts.first());
        let first = first.expect("a contact");
        assert!(first.overlap >= 0.0 && first.overlap < -0.01 * end && first.normal_force < 0.0);
    }
}

/// Moments of two spheres, the second of which goes across so fast that the normal turns, or away, and of a sphere at a wall.
fn rolled(model: Model, velocity: [f64; 2], at_wall: bool, steps: u64) -> Vec<Snapshot> {
    let (mut model, [a, b], overlap) = (model, RADII, 5.0e-5);
    model.dt = 1.0e-7;
    model.law.contact.rolling.get_or_insert(Rolling {
        bending_stiffness: Some(0.1),
        twisting_stiffness: 0.08,
        limit: None,
    });
    let mut bodies = match at_wall {
        false => spheres(&[(a, 0.0, 0.0), (b, a + b - overlap, velocity[0])]),
        true => spheres(&[(a, a - overlap, velocity[0])]),
    };
    if at_wall {
        model.walls = vec![Wall {
            axis: grains::model::Axis::X,
            place: 0.0,
        }];
    } else {
        bodies.vz[1] = velocity[1];
    }
    let last = bodies.len() - 1;
    (bodies.spin[last], bodies.spin_x[last], bodies.spin_z[last]) = (300.0, 50.0, 400.0);
    let case = Case {
        name: "moments".to_owned(),
        model,
        bodies,
        punch: None,
        moments: (0..=steps).collect(),
    };
    variant::run(&case, &Variant::default())
}

#[test]
fn what_turns_of_a_moment_is_its_rule() {
    let across = [0.0, 1.0e3];
    let last = |moment_turn| {
        let rules = Rules {
            moment_turn,
            spring_turn: SpringTurn::KeepsLength,
            ..Rules::default()
        };
        let run = rolled(model(AdhesionLaw::Pull, rules), across, false, 5);
        let (mut moment, mut before): (Vector, Vector) = ([0.0; 3], [1.0, 0.0, 0.0]);
        for snapshot in &run {
            let memory = &snapshot.memory;
            let planar = memory.planar[0].normal;
            let normal = [planar[0], memory.across[0].normal, planar[1]];
            let onto = |vector: Vector| {
                let left = minus(vector, times(dot(vector, normal), normal));
                times(norm(vector) / norm(left).max(1.0e-300), left)
            };
            let turned = match moment_turn {
                MomentTurn::Moment => onto(moment),
                MomentTurn::Force => cross(normal, onto(cross(moment, before))),
            };
            let spin = [50.0, 300.0, 400.0];
            let rolls = minus(spin, times(dot(spin, normal), normal));
            moment = minus(turned, times(0.1 * 1.0e-7, rolls));
            before = normal;
        }
        let made = run[5].memory.across[0].bending;
        let off = norm(minus(made, moment)) / norm(moment);
        assert!(off < 1.0e-14, "{moment_turn:?}: {off:e}");
        made
    };
    let [moment, force] = [MomentTurn::Moment, MomentTurn::Force].map(last);
    let apart = norm(minus(moment, force)) / norm(moment);
    assert!(apart > 1.0e-5 && apart < 1.0e-2, "{apart:e}");
}

#[test]
fn a_moment_is_limited_by_the_force_of_its_rule() {
    let last = |moment_limit, law, velocity| {
        let rules = Rules {
            moment_limit,
            ..Rules::default()
        };
        let mut model = model(law, rules);
        if law == AdhesionLaw::Pull {
            model.law.contact.viscosity = Viscosity::Ratio {
                ratio: 0.3,
                tension: Tension::Clipped,
            };
        }
        model.law.contact.rolling = Some(Rolling {
            bending_stiffness: Some(1.0e6),
            twisting_stiffness: 0.08,
            limit: Some(0.1),
        });
        let snapshot = rolled(model, [velocity, 0.0], false, 1).remove(1);
        let across = snapshot.memory.across[0];
        let size = norm(across.bending) / (0.05 * (RADII[0] + RADII[1]));
        (size, norm(across.twisting), snapshot.contacts[0])
    };
    let (of_force, of_friction) = (MomentLimit::NormalForce, MomentLimit::AsFriction);
    // The dashpot of bodies so heavy would pull, and there is no force.
    let (free, twisting, contact) = last(of_force, AdhesionLaw::Pull, 100.0);
    assert!(free > 1.0 && twisting > 0.0 && contact.normal_force == 0.0);
    let (none, twisting, _) = last(of_friction, AdhesionLaw::Pull, 100.0);
    assert_eq!([none, twisting], [0.0; 2]);
    let (limit, _, contact) = last(of_force, AdhesionLaw::Dmt, 1.0);
    assert!((limit / contact.normal_force.abs() - 1.0).abs() < 1.0e-12);
    let (limit, ..) = last(of_friction, AdhesionLaw::Dmt, 1.0);
    let [radius, modulus] = effective();
    let spring = 4.0 / 3.0 * modulus * radius.sqrt() * contact.overlap.powf(1.5);
    let wanted = spring + 4.0 * PI * radius * ENERGY;
    assert!((limit / wanted - 1.0).abs() < 1.0e-12, "{limit} {wanted}");
}

/// Against rolling, η |N| (R₁ + R₂)/2 whatever has rolled before; where grains also twist, a rule makes it weaker.
#[test]
fn a_constant_torque_is_its_limit_and_remembers_nothing() {
    let run = |constant_moment, moment_limit| {
        let rules = Rules {
            constant_moment,
            moment_limit,
            ..Rules::default()
        };
        let mut model = model(AdhesionLaw::Pull, rules);
        model.law.contact.viscosity = Viscosity::Ratio {
            ratio: 0.1,
            tension: Tension::Unclipped,
        };
        model.law.contact.rolling = Some(Rolling {
            bending_stiffness: None,
            twisting_stiffness: 0.08,
            limit: Some(0.1),
        });
        let run = rolled(model, [1.0, 0.0], false, 3);
        let torque = |moment: &Snapshot| {
            let (contact, across) = (moment.contacts[0], moment.memory.across[0]);
            let size = norm(across.bending) / (0.1 * 0.5 * (RADII[0] + RADII[1]));
            (across.bending, size, contact)
        };
        [torque(&run[1]), torque(&run[3])]
    };
    let along = ConstantMoment::AlongRolling;
    for (bending, size, contact) in run(along, MomentLimit::NormalForce) {
        assert!((size / contact.normal_force.abs() - 1.0).abs() < 1.0e-12);
        // Rolling is about y and z here, x is the normal.
        assert!(bending[1] < 0.0 && bending[2] < 0.0 && bending[0].abs() < 1.0e-12 * norm(bending));
        assert!((bending[1] / bending[2] - 300.0 / 400.0).abs() < 1.0e-12);
    }
    let [radius, modulus] = effective();
    for (_, size, contact) in run(along, MomentLimit::Spring) {
        let spring = 4.0 / 3.0 * modulus * radius.sqrt() * contact.overlap.powf(1.5);
        assert!((size / spring - 1.0).abs() < 1.0e-12 && spring > 1.01 * contact.normal_force);
    }
    let spin = 300.0f64.hypot(400.0);
    for (_, size, contact) in run(ConstantMoment::ShareOfSpin, MomentLimit::NormalForce) {
        let wanted = contact.normal_force.abs() * spin / spin.hypot(50.0);
        assert!((size / wanted - 1.0).abs() < 1.0e-12, "{size} {wanted}");
    }
}

#[test]
fn walls_may_have_no_moments() {
    let bending = |moments_at_walls, at_wall| {
        let rules = Rules {
            moments_at_walls,
            ..Rules::default()
        };
        let run = rolled(model(AdhesionLaw::Pull, rules), [0.0; 2], at_wall, 1);
        let across = run[1].memory.across[0];
        [across.bending, across.twisting].map(norm)
    };
    let none = bending(MomentsAtWalls::None, true);
    assert_eq!(none, [0.0; 2]);
    let with = bending(MomentsAtWalls::AsPairs, true);
    assert!(with.iter().all(|size| *size > 0.0));
    let pairs = [MomentsAtWalls::None, MomentsAtWalls::AsPairs].map(|rule| bending(rule, false));
    assert_eq!(pairs[0], pairs[1]);
}
