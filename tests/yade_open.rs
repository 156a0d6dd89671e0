//! `yade_scripts/open_run.py`: a run folder's bed in YADE has the bits of its tables, and goes on as the run did. Without the
//! feature `yade` this is listed as ignored and not made; with it a missing YADE is a failure.

use crossgrain::engine::yade;
use crossgrain::run::folder::Moment;
use grains::scene::{Tension, Viscosity};
use serde::Deserialize;

use crate::folder::written;
use crate::support::*;

/// Opens a bed and says what is in YADE then, and after some steps.
const OPENS: &str = "
import json, os, sys
import open_run
folder, settled, steps = sys.argv[1], sys.argv[2] == 'settled', int(sys.argv[3])
bed = open_run.load(folder, settled)
from yadeimport import O
from yade.utils import unbalancedForce
def grains():
    states = zip(bed.states, bed.radii)
    return [[of.pos[0], of.pos[2], of.vel[0], of.vel[2], radius, of.angVel[1]] for of, radius in states]
def contacts():
    found = []
    for of in bed.real_contacts():
        force = of.phys.normalForce + of.phys.shearForce
        n = of.geom.normal
        found.append([of.id1, of.id2, of.geom.penetrationDepth, force[0] * n[0] + force[2] * n[2], force[2] * n[0] - force[0] * n[2]])
    return sorted(found)
told = dict(opened=grains(), contacts=contacts(), unbalanced=unbalancedForce(), bodies=len(O.bodies))
for _ in range(steps):
    O.step()
told['later'] = grains()
files = ('/proc/self/fd/%s' % of for of in os.listdir('/proc/self/fd'))
told['sockets'] = sum(os.readlink(of).startswith('socket:') for of in files if os.path.islink(of))
with open('told.json', 'w') as file:
    json.dump(told, file)
O.exitNoBacktrace()
";

#[derive(Deserialize)]
struct Told {
    /// x, z, vx, vz, radius, spin.
    opened: Vec<[f64; 6]>,
    later: Vec<[f64; 6]>,
    /// ids, overlap, normal and tangential force.
    contacts: Vec<(u32, u32, f64, f64, f64)>,
    unbalanced: f64,
    bodies: usize,
    sockets: usize,
}

fn yade_python(place: &Path, arguments: &[&str]) -> Output {
    let yade = yade::find(None).expect("YADE is there");
    Command::new(yade.interpreter)
        .arg("-B")
        .args(arguments)
        .current_dir(place)
        .env("PYTHONPATH", root("yade_scripts"))
        .env("CROSSGRAIN", env!("CARGO_BIN_EXE_crossgrain"))
        .output()
        .expect("Python starts")
}

fn opened(run: &RunFolder, moment: &str, steps: u64) -> Told {
    let (place, _) = &written(run);
    let output = yade_python(place, &["-c", OPENS, "run", moment, &steps.to_string()]);
    let (code, out, errors) = told(&output);
    assert_eq!(code, 0, "{out}{errors}");
    let text = text_of(place.join("told.json"));
    serde_json::from_str(&text).expect("JSON")
}

/// The largest difference of a number from the table's; 0 if they are equal.
fn difference(found: &[[f64; 6]], table: &Bodies) -> f64 {
    assert_eq!(found.len(), table.x.len());
    let mut largest = 0.0_f64;
    for (at, found) in found.iter().enumerate() {
        let spin = table.spin.get(at).copied().unwrap_or(0.0);
        let [x, z, vx, vz] = [&table.x, &table.z, &table.vx, &table.vz].map(|column| column[at]);
        let row = [x, z, vx, vz, table.radius[at], spin];
        for (a, b) in found.iter().zip(row) {
            largest = largest.max((a - b).abs());
        }
    }
    largest
}

/// The contacts of the table: the same pairs, overlaps and normal forces to the bit, tangential forces to rounding.
fn has_contacts(told: &Told, table: &[Contact]) {
    assert_eq!(told.contacts.len(), table.len());
    for (found, contact) in told.contacts.iter().zip(table) {
        let (id1, id2, overlap, normal, tangential) = *found;
        assert_eq!((id1, id2), (contact.id1, contact.id2));
        assert_eq!(overlap.to_bits(), contact.overlap.to_bits());
        let scale = 1e-12 * contact.normal_force.abs().max(1.0);
        assert!((normal - contact.normal_force).abs() < scale, "{id1} {id2}");
        let off = (tangential - contact.tangential_force).abs();
        assert!(off < scale, "{id1} {id2}: {off}");
    }
    assert!(told.unbalanced.is_finite() && told.unbalanced > 0.0);
    assert_eq!(told.sockets, 0, "YADE opened a socket");
}

/// The bed that was opened has the bits of this moment.
fn opened_alike(run: &RunFolder, moment: &str, steps: u64, wanted: &Moment) -> Told {
    let told = opened(run, moment, steps);
    assert_eq!(difference(&told.opened, &wanted.bodies), 0.0);
    has_contacts(&told, &wanted.contacts);
    told
}

fn native(scene: &Scene, protocol: Protocol) -> RunFolder {
    native_run(scene, sound(), protocol)
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_bed_without_friction_goes_on_in_yade_with_the_same_bits() {
    let scene = small_scene();
    let [first, later] = [3000, 3100].map(|steps| native(&scene, Protocol::Steps { steps }));
    let told = opened_alike(&first, "last", 100, &first.last);
    assert_eq!(told.bodies, first.last.bodies.x.len() + 3);
    assert_eq!(difference(&told.later, &later.last.bodies), 0.0);
    assert!(difference(&told.later, &first.last.bodies) > 1e-3);
}

/// Where the smaller load is reached, the run under the larger one only goes on.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_bed_under_the_punch_goes_on_in_yade_with_the_same_bits() {
    let scene = small_scene();
    let mut heavier = scene.clone();
    heavier.loading.pressure *= 1.2;
    let [first, later] = [&scene, &heavier].map(|scene| native(scene, Protocol::Whole));
    let [from, to] = [&first, &later].map(|run| run.record.stages[1].steps);
    assert!(to > from, "{from} {to}");
    let told = opened_alike(&first, "last", to - from, &first.last);
    assert_eq!(told.bodies, first.last.bodies.x.len() + 4);
    assert_eq!(difference(&told.later, &later.last.bodies), 0.0);

    let settled = first.settled.as_ref().expect("a settled bed");
    let told = opened_alike(&first, "settled", 1, settled);
    assert_eq!(told.bodies, first.last.bodies.x.len() + 3);

    // As folders of other engines are, which do not have the punch's bits.
    let mut of_another = first.clone();
    of_another.record.restart = None;
    let told = opened(&of_another, "last", 1);
    has_contacts(&told, &first.last.contacts);
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_bed_with_friction_keeps_its_tangential_forces() {
    let changes = r#"{"loading": {"material": {"friction_angle": 0.2, "stiffness_ratio": 0.6}}}"#;
    let scene = staged_scene(changes);
    let first = native(&scene, Protocol::Whole);
    // The same, ended by its depth twenty steps later.
    let mut deeper = scene.clone();
    let steps = first.record.stages[1].steps + 20;
    deeper.loading.pressure = 1.0e9;
    deeper.loading.give_up_depth =
        (steps as f64 - 0.5) * scene.loading.speed * scene.time_step_seconds();
    let later = native(&deeper, Protocol::Whole);
    assert_eq!(later.record.stages[1].steps, steps);
    let told = opened_alike(&first, "last", 20, &first.last);
    let slipping = first.last.contacts.iter();
    assert!(
        slipping
            .filter(|contact| contact.tangential_force != 0.0)
            .count()
            > 20
    );
    // Rounding of a force, and no more.
    let off = difference(&told.later, &later.last.bodies);
    assert!(off < 1e-9, "{off}");
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn what_cannot_be_opened_is_said_in_one_sentence() {
    let place = &new_folder();
    let open = root("yade_scripts/open_run.py");
    let open = open.to_str().expect("text");
    let refused = |words: &str| {
        let (code, out, errors) = told(&yade_python(place, &[open, "run"]));
        assert_eq!(code, 1, "{out}{errors}");
        has(&errors, [words]);
        assert!(!errors.contains("Traceback"), "{errors}");
    };
    refused("run is no run folder");
    let mut scene = small_scene();
    let (e_n, tension) = (0.5, Tension::Clipped);
    scene.contact.viscosity = Viscosity::Restitution { e_n, tension };
    let run = native(&scene, Protocol::Steps { steps: 10 });
    run.write(&place.join("run")).expect("writable");
    refused("YADE does not have the contacts");
    let bodies = place.join("run/bodies.csv");
    let text = text_of(&bodies);
    fs::write(&bodies, text.replacen('1', "2", 1)).expect("writable");
    refused("bodies.csv was changed after it was written");
}
