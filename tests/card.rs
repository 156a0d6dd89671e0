//! `engine card`: constants that an engine is asked for, read from how its grains move.

use crate::support::*;

/// The corpus engine with this fault, and rules that it has and does not say.
fn card_of(fault: &str, rules: &str, code: i32) -> String {
    let folder = &new_folder();
    let program = folder.join("engine.real");
    let mut compile = Command::new("cc");
    compile.args(["-std=gnu11", "-O2", "-ffp-contract=off"]);
    compile.arg(root("tests/corpus/engine.c"));
    compile.args(["-lm", "-o"]).arg(&program);
    assert!(compile.status().expect("a C compiler").success());
    let text = format!(
        "#!/bin/sh\nFAULT='{fault}' RULES='{rules}' DECLARED='' exec {} \"$@\"\n",
        program.display()
    );
    let card = format!("engine card {} --quiet", engine(folder, "engine", &text));
    ends(folder, code, &card.words()).0
}

#[test]
fn a_right_engine_has_what_was_asked_for() {
    let text = card_of("", "", 0);
    has(&text, ["AGREED: All 37 constants"]);
    assert_eq!(text.matches("  as asked\n").count(), 37, "{text}");
}

#[test]
fn what_is_wrong_is_told_with_where_and_with_what_it_would_be_right() {
    let told = [
        (
            "k_n_wall=2",
            "normal stiffness at wall: as with k_n at walls × 2;",
        ),
        (
            "c_n=1.4142135623730951",
            "dashpot at two unequal grains: as with c_n × √2",
        ),
        (
            "tan_phi_is_phi",
            "friction coefficient at wall: as with tan φ × φ / tan φ",
        ),
        ("inertia=2", "moment of inertia at one grain: as with"),
        (
            "alpha=0",
            "local damping, falling at one grain: as with damped_gravity = spared, or α × 0",
        ),
        ("k_s=1.03", "tangential stiffness at punch: 1.03"),
        (
            "gravity=0.5",
            "gravity upwards at one grain: as with gravity × 1/2",
        ),
    ];
    for (fault, words) in told {
        has(&card_of(fault, "", 1), [words]);
    }
}

#[test]
fn rules_that_are_not_declared_are_told() {
    let told = [
        (
            "wall_mass=half",
            "restitution at wall: as with wall_mass = half",
        ),
        (
            "stiffness_mean=arithmetic",
            "normal stiffness at two unequal grains: as with stiffness_mean = arithmetic",
        ),
        (
            "restitution=uncut",
            "restitution at two equal grains: as with restitution = uncut",
        ),
    ];
    for (rule, words) in told {
        has(&card_of("", rule, 1), [words]);
    }
}

#[test]
#[cfg_attr(
    not(feature = "live"),
    ignore = "needs LAMMPS, LIGGGHTS, ESyS-Particle and YADE"
)]
fn what_parameters_of_other_codes_mean() {
    let told = [
        ("yade-ordinary", "AGREED: All 25 constants"),
        ("lammps", "as it declares: slip = unstretched"),
        ("liggghts", "as it declares: slip = contact_point"),
        (
            "esysparticle",
            "as it declares: stiffness_mean = arithmetic",
        ),
    ];
    for (engine, words) in told {
        let card = format!("engine card {engine} --quiet");
        let (text, _) = ends(&new_folder(), 0, &card.words());
        has(&text, [words]);
    }
}
