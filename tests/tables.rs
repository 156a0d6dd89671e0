//! Tables as text: read back to the same bits, refused where a row cannot be meant.

use crossgrain::files::FileError;
use crossgrain::tables::{read_bodies, write_bodies};
use proptest::prelude::*;

use crate::support::*;

fn all_bits(bodies: &Bodies) -> Vec<Vec<u64>> {
    let mut columns: Vec<&[f64]> = bodies.motion().iter().map(|(_, column)| *column).collect();
    columns.extend([&bodies.radius[..], &bodies.mass, &bodies.inertia]);
    let bits = |column: &[f64]| column.iter().map(|value| value.to_bits()).collect();
    columns.into_iter().map(bits).collect()
}

fn there_and_back(bodies: &Bodies) -> Result<Bodies, FileError> {
    let folder = &new_folder();
    let path = folder.join("bodies.csv");
    write_bodies(&path, bodies)?;
    read_bodies(&path, bodies.len() as u32)
}

fn read(text: &str) -> Result<Bodies, FileError> {
    let folder = &new_folder();
    let path = folder.join("bodies.csv");
    fs::write(&path, text).expect("a writable folder");
    read_bodies(&path, 100)
}

/// Any finite number: of every size, of both signs, zeros with and without a sign.
fn finite() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE
}

fn above_zero() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NORMAL, POSITIVE, SUBNORMAL};
    NORMAL | SUBNORMAL | POSITIVE
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn grains_read_back_to_the_same_bits(
        rows in prop::collection::vec(
            (prop::array::uniform5(finite()), prop::array::uniform3(above_zero())), 1..40),
        rotate in any::<bool>(),
    ) {
        let mut bodies = Bodies::default();
        for ([x, z, vx, vz, spin], [radius, mass, inertia]) in rows {
            bodies.push([x, z], [vx, vz], radius, mass);
            if rotate {
                bodies.spin.push(spin);
                bodies.inertia.push(inertia);
            }
        }
        let back = there_and_back(&bodies).expect("a sound table");
        prop_assert_eq!(all_bits(&back), all_bits(&bodies));
    }
}

/// A second row, and what is said of it.
const WRONG: &str = "
    1,0.3,0.2,0,0,0.005,0.2,NaN,1e-6 ⇒ row 2 has spin = NaN, which must be finite
    1,0.3,0.2,0,0,0.005,0.2,-inf,1e-6 ⇒ row 2 has spin = -inf, which must be finite
    1,0.3,0.2,0,0,0.005,0.2,1,0 ⇒ row 2 has inertia = 0, which must be finite and above 0
    1,0.3,0.2,0,0,0.005,0.2,1,-1e-6 ⇒ row 2 has inertia = -0.000001, which must be
    1,0.3,0.2,0,0,0.005,0.2,1,NaN ⇒ row 2 has inertia = NaN, which must be
    1,0.3,0.2,0,0,0.005,0.2,1,inf ⇒ row 2 has inertia = inf, which must be
    1,0.3,0.2,0,0,0.005,0.2,1, ⇒ row 2 has spin = alone, which must be given with an inertia
    1,0.3,0.2,0,0,0.005,0.2,,1e-6 ⇒ row 2 has spin = alone, which must be given with an inertia
    1,0.3,0.2,0,0,0.005,0.2,, ⇒ row 2 has spin = nothing, which must be given in every row
    1,0.3,0.2,0,0,0.005,0.2,fast,1e-6 ⇒ invalid float
    1,0.3,0.2,0,0,0.005,0.2,1 ⇒ fields
    1,0.3,0.2,0,0,0.005,-0.2,1,1e-6 ⇒ row 2 has mass = -0.2
    2,0.3,0.2,0,0,0.005,0.2,1,1e-6 ⇒ row 2 has id = 2
";

const HEADER: &str = "id,x,z,vx,vz,radius,mass,spin,inertia\n";

#[test]
fn rows_of_spins_that_cannot_be_meant_are_refused() {
    let sound = "0,0.1,0.2,0,0,0.005,0.2,-3.5,1e-6\n";
    let bodies = read(&format!("{HEADER}{sound}")).expect("a sound table");
    assert_eq!((bodies.spin, bodies.inertia), (vec![-3.5], vec![1.0e-6]));
    let refused = |text: &str, message: &str| {
        let error = read(text).expect_err(message).to_string();
        assert!(error.contains(message), "{text}: {error}");
    };
    for [row, message] in rows(WRONG) {
        refused(&format!("{HEADER}{sound}{row}\n"), message);
    }
    // The first row without a spin, the second with one.
    let late = "0,0.1,0.2,0,0,0.005,0.2,,\n1,0.3,0.2,0,0,0.005,0.2,1,1e-6\n";
    refused(&format!("{HEADER}{late}"), "in every row or in none");
    // A column for one of the two only.
    for (name, value) in [("spin", "1"), ("inertia", "1e-6")] {
        let text = format!("id,x,z,vx,vz,radius,mass,{name}\n0,0.1,0.2,0,0,0.005,0.2,{value}\n");
        refused(&text, "given with an inertia");
    }
    // Cut off inside the last number.
    refused(format!("{HEADER}{sound}").trim_end(), "cut off");
}
