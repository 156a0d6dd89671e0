//! Seen in a mirror, or in other units, a case has the same bits.

use grains::model::Wall;

use super::*;

/// How a case looks in a mirror.
#[derive(Debug, Clone, Copy)]
enum Mirror {
    /// x → −x.
    Upright,
    /// x ↔ z.
    Diagonal,
}

impl Mirror {
    fn vector(self, [x, z]: [f64; 2]) -> [f64; 2] {
        match self {
            Mirror::Upright => [-x, z],
            Mirror::Diagonal => [z, x],
        }
    }

    fn bodies(self, bodies: &Bodies) -> Bodies {
        let mut mirrored = bodies.clone();
        for i in 0..bodies.len() {
            [mirrored.x[i], mirrored.z[i]] = self.vector([bodies.x[i], bodies.z[i]]);
            [mirrored.vx[i], mirrored.vz[i]] = self.vector([bodies.vx[i], bodies.vz[i]]);
        }
        mirrored.spin.iter_mut().for_each(|spin| *spin = -*spin);
        mirrored
    }

    fn case(self, case: &Case) -> Case {
        let mut mirrored = case.clone();
        mirrored.bodies = self.bodies(&case.bodies);
        mirrored.model.gravity = self.vector(case.model.gravity);
        for Wall { axis, place } in &mut mirrored.model.walls {
            match (self, *axis) {
                (Mirror::Upright, Axis::X) => *place = -*place,
                (Mirror::Upright, Axis::Z) | (_, Axis::Y) => {}
                (Mirror::Diagonal, Axis::X) => *axis = Axis::Z,
                (Mirror::Diagonal, Axis::Z) => *axis = Axis::X,
            }
        }
        if let Some(punch) = &mut mirrored.punch {
            punch.centre = self.vector(punch.centre);
        }
        mirrored
    }

    fn contact(self, contact: &Contact) -> Contact {
        Contact {
            tangential_force: -contact.tangential_force,
            normal: self.vector(contact.normal),
            point: self.vector(contact.point),
            ..*contact
        }
    }
}

fn is_mirrored(case: &Case, mirror: Mirror) -> Result<(), TestCaseError> {
    for (one, other) in run(case).iter().zip(run(&mirror.case(case))) {
        // Equal but for the sign of a zero.
        prop_assert_eq!(mirror.bodies(&one.bodies), other.bodies);
        let contacts: Vec<Contact> = one.contacts.iter().map(|c| mirror.contact(c)).collect();
        prop_assert_eq!(contacts, other.contacts, "step {}", one.step);
    }
    Ok(())
}

/// The case in units of which ours are these powers of two: of length, time and mass.
fn in_other_units(case: &Case, [length, time, mass]: [i32; 3]) -> Case {
    let unit = |l: i32, t: i32, m: i32| 2f64.powi(l * length + t * time + m * mass);
    let all = |column: &mut Vec<f64>, unit: f64| column.iter_mut().for_each(|v| *v *= unit);
    let mut case = case.clone();
    let model = &mut case.model;
    model.dt *= unit(0, 1, 0);
    model.gravity = model.gravity.map(|g| g * unit(1, -2, 0));
    model.law.modulus *= unit(-1, -2, 1);
    if let Viscosity::Dashpot { c_n, .. } = &mut model.law.contact.viscosity {
        *c_n *= unit(0, -1, 1);
    }
    for wall in &mut model.walls {
        wall.place *= unit(1, 0, 0);
    }
    if let Some(punch) = &mut case.punch {
        punch.centre = punch.centre.map(|coordinate| coordinate * unit(1, 0, 0));
        punch.half_extents = punch.half_extents.map(|extent| extent * unit(1, 0, 0));
        punch.velocity *= unit(1, -1, 0);
    }
    let bodies = &mut case.bodies;
    for column in [&mut bodies.x, &mut bodies.z, &mut bodies.radius] {
        all(column, unit(1, 0, 0));
    }
    for column in [&mut bodies.vx, &mut bodies.vz] {
        all(column, unit(1, -1, 0));
    }
    all(&mut bodies.mass, unit(0, 0, 1));
    all(&mut bodies.spin, unit(0, -1, 0));
    all(&mut bodies.inertia, unit(2, 0, 1));
    case
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn a_mirror_mirrors_every_bit(case in cases(any_law())) {
        is_mirrored(&case, Mirror::Upright)?;
    }

    /// Across and up are treated alike. A punch is not: it moves up and down.
    #[test]
    fn across_and_up_may_change_places(mut case in cases(any_law())) {
        case.punch = None;
        is_mirrored(&case, Mirror::Diagonal)?;
    }

    /// No length, time or mass is built in: units that are powers of two change no bit of a number.
    #[test]
    fn other_units_give_the_same_bits(
        case in cases(any_law()),
        powers in [-20i32..20, -20i32..20, -20i32..20],
    ) {
        let [length, time, mass] = powers;
        let force = 2f64.powi(length + mass - 2 * time);
        let metre = 2f64.powi(length);
        for (one, other) in run(&case).iter().zip(run(&in_other_units(&case, powers))) {
            let mut started = case.clone();
            started.bodies = one.bodies.clone();
            prop_assert_eq!(in_other_units(&started, powers).bodies, other.bodies);
            let contacts: Vec<Contact> = one
                .contacts
                .iter()
                .map(|contact| Contact {
                    overlap: contact.overlap * metre,
                    normal_force: contact.normal_force * force,
                    tangential_force: contact.tangential_force * force,
                    point: contact.point.map(|at| at * metre),
                    ..*contact
                })
                .collect();
            prop_assert_eq!(contacts, other.contacts);
        }
    }

    /// Which of two grains is named first changes no bit without friction, and with it rounding only.
    #[test]
    fn two_grains_may_change_places(
        law in any_law(),
        turn in 0.0f64..6.2,
        speeds in prop::array::uniform4(-0.02f64..0.02),
        sizes in [0.1f64..1.0, 0.1f64..1.0],
    ) {
        let dt = 1.0e-3 * sizes[0].min(sizes[1]);
        let apart = 0.95 * LARGEST * (sizes[0] + sizes[1]);
        let one = Grain::disc([0.0; 2], LARGEST * sizes[0], DENSITY)
            .moving([speeds[0] * LARGEST / dt, 0.0])
            .spinning(speeds[1] / dt);
        let two = Grain::disc([apart * turn.cos(), apart * turn.sin()], LARGEST * sizes[1], DENSITY)
            .moving([0.0, speeds[2] * LARGEST / dt])
            .spinning(speeds[3] / dt);
        let smooth = law.friction_angle == 0.0 && law.contact.viscosity == Viscosity::None;
        let track = |grains| run(&case("two", model(law.clone(), dt), grains, vec![0, 1, 30]));
        for (a, b) in track(&[one, two]).iter().zip(track(&[two, one])) {
            for ((_, a), (_, b)) in a.bodies.motion().into_iter().zip(b.bodies.motion()) {
                let size = a.iter().fold(0.0f64, |size, number| size.max(number.abs()));
                for (a, b) in a.iter().zip(b.iter().rev()) {
                    let off = (a - b).abs();
                    prop_assert!(if smooth { off == 0.0 } else { off <= 1.0e-9 * size }, "{a} {b}");
                }
            }
        }
    }
}
