//! An engine whose contact law no reference has is held against itself, and each fault breaks the relation that is about it.

use crossgrain::checks::Outcome;
use crossgrain::compare::first_steps::Beds;
use crossgrain::engine::exec::{ExternalEngine, Options};
use crossgrain::suite::conformance::{Conformance, conformance};
use verdict::judge::Verdict;
use verdict::starts::DISPERSION;

use crate::support::*;

/// The example with a law of its own, changed so.
fn own_law(folder: &Path, name: &str, changes: &[(&str, &str)]) -> PathBuf {
    let mut source = text_of(root("examples/engine-own-law/engine.c"));
    for (right, wrong) in changes {
        assert!(source.contains(right), "{right}");
        source = source.replacen(right, wrong, 1);
    }
    let [text, program] = [format!("{name}.c"), name.to_owned()].map(|file| folder.join(file));
    fs::write(&text, source).expect("a file");
    let mut compile = Command::new("cc");
    compile.args(["-O2", "-ffp-contract=off", "-o"]);
    let done = compile.arg(&program).arg(&text).arg("-lm").output();
    let done = done.expect("a C compiler");
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{name}: {said}");
    program
}

fn checked(program: PathBuf, beds: &Beds) -> Conformance {
    let engine = ExternalEngine::ask(Options::new(program)).expect("a description");
    conformance(&engine, beds, &mut |_| ()).expect("an engine")
}

#[test]
fn the_command_says_that_no_reference_was_asked() {
    let folder = &folder_with(&narrow_scene(0.05));
    let sound = own_law(folder, "sound", &[]);
    let check = format!("engine check exec:{} --quiet --out out", sound.display());
    let (text, _) = ends(folder, 0, &check);
    let said = "CONSISTENT WITH ITSELF: 17 relations hold; it was not held against any reference.";
    has(&text, [said, "It has a contact law of its own"]);
    let pages = ["report.html", "check.json"].map(|name| text_of(folder.join("out").join(name)));
    for text in pages.into_iter().chain([text]) {
        assert!(!text.to_lowercase().contains("agreed"), "{text}");
    }
    // It says what its law has, and is not asked what cannot hold then.
    let own = [
        (
            "\\\"own_law\\\": []",
            "\\\"own_law\\\": [\\\"constants\\\"]",
        ),
        ("COHESION * r)", "2e-7)"),
    ];
    let in_metres = own_law(folder, "in-metres", &own);
    let check = format!("engine check exec:{} --quiet", in_metres.display());
    let said = "CONSISTENT WITH ITSELF: 16 relations hold and 1 were not decided";
    tells(
        folder,
        0,
        &check,
        [said, "constants of its own, with units"],
    );
    let in_metres = own_law(folder, "untold", &own[1..]);
    let check = format!("engine check exec:{} --quiet", in_metres.display());
    let said = "NOT CONSISTENT WITH ITSELF: In other units of length, mass and time: ";
    tells(
        folder,
        1,
        &check,
        [said, "What usually breaks this: a constant with a unit"],
    );
}

#[test]
fn an_engine_with_the_laws_of_the_model_is_held_against_itself_too() {
    let folder = &folder_with(&narrow_scene(0.05));
    let toy = adapter("toy.py");
    let check = format!("engine check {toy} --grains 50 --quiet --against-itself");
    tells(
        folder,
        0,
        &check,
        ["AGREED: Identical", "32 checks passed, 0 failed"],
    );
    let moved = "if step in moments:\n            v[0][0] *= 1.0 + 1e-4 * (step > 0)";
    let toy = changed_toy("if step in moments:", moved);
    let toy = engine(folder, "moved", &toy);
    let check = format!("engine check {toy} --grains 50 --quiet");
    let said = "It contradicts itself: told of at every step, or at the last one alone; ";
    tells(
        folder,
        1,
        &check,
        [
            said,
            "What usually breaks this: output that changes the run",
        ],
    );
}

/// What is wrong, how the source is changed, and the relation that it breaks.
const FAULTS: &[(&str, &str, &str, &str)] = &[
    (
        "random",
        "g->force[0] = g->force[1] = g->torque = 0.0;",
        "extern int getpid(void); g->force[0] = g->force[1] = g->torque = 1e-9 * getpid();",
        "again",
    ),
    (
        "kept from the case before",
        "    friction = tan(",
        "    if (friction == 0.0) friction = tan(",
        "again",
    ),
    (
        "output that moves grains",
        "        if (turns) fprintf(file, \",%.17g",
        "        g->v[0] = (float)g->v[0]; if (turns) fprintf(file, \",%.17g",
        "output",
    ),
    (
        "a first step of half the length",
        "                move();",
        "                dt *= steps ? 1.0 : 0.5, move(), dt *= steps ? 1.0 : 2.0;",
        "resumed",
    ),
    (
        "forces of the first",
        "fmin(a->radius, b->radius)",
        "a->radius",
        "renumbered",
    ),
    (
        "slip limited to one side",
        "    if (ft < -most) ft = -most;\n",
        "",
        "mirrored",
    ),
    (
        "gravity along z alone",
        "+ gravity[axis]",
        "+ axis * gravity[1]",
        "turned",
    ),
    (
        "a tolerance that grows with x",
        "    if (overlap < 0.0) return;",
        "    if (overlap < 1e-6 * fabs(b->x[0])) return;",
        "shifted",
    ),
    (
        "gravity of the Earth",
        "    gravity[1] = strtod(next + 1, NULL);",
        "    gravity[1] = -9.81;",
        "units",
    ),
    (
        "a tolerance in metres",
        "    if (overlap < 0.0) return;",
        "    if (overlap < 1e-9) return;",
        "units",
    ),
    (
        "cells that end",
        "                int cell = ",
        "                if (column + beside >= CELLS) continue;\n                int cell = ",
        "copies",
    ),
    (
        "a jump in each step",
        "fn = k * (overlap - COHESION * r);",
        "fn = k * (overlap - COHESION * r) + 1e-7 * m * r / (dt * dt);",
        "step",
    ),
    (
        "a force on one side only",
        "        a->force[axis] -= f[axis];\n",
        "",
        "account",
    ),
    (
        "drag that no table tells",
        "g->force[axis] / g->mass + gravity[axis]",
        "g->force[axis] / g->mass + gravity[axis] - 1e-4 * g->v[axis] / dt",
        "account",
    ),
    (
        "the torque's sign",
        "b->torque += arm[1] * ft;",
        "b->torque -= arm[1] * ft;",
        "conserved",
    ),
    (
        "whole radii as arms",
        "b->torque += arm[1] * ft;",
        "b->torque += b->radius * ft;",
        "conserved",
    ),
];

#[test]
fn faults_break_the_relation_that_is_about_them() {
    let folder = &new_folder();
    let beds = Beds::new(200, DISPERSION);
    let broken = |found: &Conformance| -> Vec<String> {
        let failed = found
            .checks
            .iter()
            .filter(|check| check.outcome == Outcome::Fail);
        let keys = failed.map(|check| check.id.trim_start_matches("engine/itself/").to_owned());
        keys.collect()
    };
    let sound = checked(own_law(folder, "sound", &[]), &beds);
    assert_eq!(sound.verdict(), Verdict::ConsistentWithItself);
    assert_eq!(broken(&sound), [""; 0]);
    let mut missed = Vec::new();
    for (at, (name, right, wrong, relation)) in FAULTS.iter().enumerate() {
        let program = own_law(folder, &format!("fault-{at}"), &[(right, wrong)]);
        let found = checked(program, &beds);
        let keys = broken(&found);
        println!("{name:32} {keys:?}");
        if found.verdict() != Verdict::Different || !keys.iter().any(|key| key == relation) {
            missed.push((name, keys));
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}
