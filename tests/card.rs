//! `engine card`: constants that an engine is asked for, read from how its grains move, in the plane and in space.

use crate::support::*;

/// The planar engine of the corpus with this fault, and rules that it has and does not say.
fn card_of(fault: &str, rules: &str, code: i32) -> String {
    card_of_engine("engine.c", fault, rules, code)
}

fn card_of_engine(source: &str, fault: &str, rules: &str, code: i32) -> String {
    let folder = &new_folder();
    let program = folder.join("engine.real");
    let mut compile = Command::new("cc");
    compile.args(["-std=gnu11", "-O2", "-ffp-contract=off"]);
    compile.arg(root("tests/corpus").join(source));
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
    has(&text, ["AGREED: All "]);
    assert!(!text.contains(" ×"), "{text}");
}

#[test]
fn what_is_wrong_is_told_with_where_and_with_what_it_would_be_right() {
    let told = [
        (
            "k_n_wall=2",
            "normal stiffness at wall: as with k_n at walls × 2 (",
        ),
        (
            "c_n=1.4142135623730951",
            "dashpot at two equal grains: as with c_n × √2 (",
        ),
        (
            "tan_phi_is_phi",
            "friction coefficient at two equal grains: as with tan φ × φ / tan φ (",
        ),
        ("inertia=2", "as with moment of inertia × 2 ("),
        (
            "alpha=0",
            "local damping, falling at one grain: as with α × 0 (",
        ),
        (
            "k_s=1.03",
            "tangential stiffness at two equal grains: as with k_s × 1.03 (",
        ),
        (
            "gravity=0.5",
            "gravity across at one grain: as with gravity × 1/2 (",
        ),
    ];
    for (fault, words) in told {
        has(&card_of(fault, "", 1), [words]);
    }
}

#[test]
fn rules_that_are_not_declared_are_told() {
    let told = [
        ("wall_mass=half", " at wall: as with wall_mass = half ("),
        (
            "stiffness_mean=arithmetic",
            "normal stiffness at two unequal grains: as with stiffness_mean = arithmetic, or k = (k₁ + k₂)/2 (",
        ),
        (
            "restitution=uncut",
            "restitution at two equal grains: as with restitution = uncut, or the damping ratio",
        ),
    ];
    for (rule, words) in told {
        has(&card_of("", rule, 1), [words]);
    }
}

#[test]
fn a_right_engine_in_space_has_what_was_asked_for() {
    let text = card_of_engine("spheres.c", "", "", 0);
    has(&text, ["AGREED: All "]);
    assert!(!text.contains(" ×"), "{text}");
}

#[test]
fn faults_of_laws_in_space_are_told() {
    let told = [
        (
            "moment_of_spin=1",
            "limit of rolling at two equal grains in space: as if multiplied by the spin to the power 1 (",
        ),
        (
            "moment_of_spin=2",
            "twisting stiffness at two equal grains in space: as if multiplied by the spin to the power 1 (",
        ),
        ("mass_at_walls=1", " at wall: as with wall_mass = half ("),
        (
            "rolling=3",
            "moment on the first grain over that on the last at two equal grains in space: 0 times what is right (5 more)",
        ),
        (
            "rolling=4",
            "bending stiffness at wall in space: as with moments_at_walls = none (",
        ),
        (
            "rolling_cap=3",
            "limit of rolling, beside a dashpot at two equal grains in space: as with moment_limit = spring (",
        ),
        (
            "jkr=2",
            "at two equal grains in space: as with a law where adhesion acts before bodies touch, from where it would end on",
        ),
        (
            "museum=1",
            "tangential stiffness at wall: 0.00015811 times what is right (",
        ),
        (
            "museum=113",
            "as with a law where the radius in the torque is the first one's for both bodies, or",
        ),
        (
            "museum=21",
            "twisting stiffness at two equal grains in space: as with twisting stiffness × 2 (",
        ),
        (
            "history_displacement=1",
            "as with spring_memory = displacement (",
        ),
        ("history_not_turned", ": as with spring_turn = not_turned ("),
        // A component that is left out of slips shows where directions are askew.
        (
            "slip_axis=2",
            "tangential stiffness at two equal grains in space: 0.63963 times what is right",
        ),
        (
            "friction_of=1",
            "friction coefficient at two materials in space: as with a law where the friction angle is the first one's for both bodies",
        ),
    ];
    for (fault, words) in told {
        has(&card_of_engine("spheres.c", fault, "", 1), [words]);
    }
}

#[test]
fn formulas_that_are_taken_for_the_models_are_told() {
    let told = [
        (
            "effective_modulus=3",
            "as with 1/E* = 1/E₁ + 1/E₂, without ν (",
        ),
        ("shear_modulus=3", "as with 1/G* of (1 − ν)/G ("),
        ("effective_radius=2", "as with R* = 2 R₁R₂/(R₁ + R₂) ("),
        ("effective_mass=3", "as with the mass in the dashpots m₂ ("),
        (
            "rolling_radius=1",
            "as with the radius in the limit of rolling R₁R₂/(R₁ + R₂) (",
        ),
        (
            "restitution_formula=2",
            "as with the damping ratio −ln e/π (",
        ),
        (
            "dashpot_half",
            "as with dashpots of β√(m k) without the 2 (",
        ),
    ];
    for (fault, words) in told {
        let text = card_of_engine("spheres.c", fault, "", 1);
        has(&text, [words]);
        // Nothing is left that would have another cause.
        let verdict = text.lines().find(|line| line.starts_with("DIFFERENT"));
        let verdict = verdict.and_then(|line| line.split(" Not read").next());
        let verdict = verdict.unwrap_or_default();
        assert!(!verdict.contains("; "), "{fault}: {verdict}");
    }
}

#[test]
fn no_cause_is_told_that_another_reading_speaks_against() {
    let never = [
        // The limit is not reached where the spring is so weak.
        ("spheres.c", "bending=0.01", "multiplied by the spin"),
        ("spheres.c", "c_n=0.7071067811865476", "wall_mass"),
        ("spheres.c", "k_s=0.5", "c_s"),
        ("spheres.c", "effective_modulus=3", "keeps its force"),
        // The moments are forgotten in each step, and their springs are right.
        ("spheres.c", "rolling_kept=2", "as with"),
        // Of the spins' sum.
        ("spheres.c", "rolling=5", "bending stiffness ×"),
        // A law of its own.
        ("engine.c", "law_nonlinear=100", "as with"),
        ("spheres.c", "hertz_exponent=1.02", "as with"),
    ];
    for (source, fault, words) in never {
        let text = card_of_engine(source, fault, "", 1);
        assert!(!text.contains(words), "{fault}: {text}");
    }
}

#[test]
fn options_of_a_scene_are_read() {
    let wrong = [
        ("engine.c", "damping_off_spin"),
        ("spheres.c", "damping_off_spin"),
        ("spheres.c", "friction_at_walls=1"),
        ("spheres.c", "friction_at_walls=2"),
        ("spheres.c", "wall_one_sided"),
        ("spheres.c", "material_ignored=3"),
        ("engine.c", "coulomb_spring"),
        ("engine.c", "new_contact_other"),
    ];
    for (source, fault) in wrong {
        has(&card_of_engine(source, fault, "", 1), ["DIFFERENT: "]);
    }
}

#[test]
fn what_no_reading_asks_for_is_listed() {
    let text = card_of("", "", 0);
    has(
        &text,
        [
            "AGREED: ",
            " Not read: ",
            "rules.spring_when_sliding = unlimited",
        ],
    );
    assert!(!text.contains("rules.wall_mass"), "{text}");
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs YADE")]
fn what_yades_parameters_mean_in_space() {
    let (text, _) = ends(&new_folder(), 0, &"engine card yade-sorted --quiet".words());
    has(&text, ["AGREED: All ", "triangle", "box"]);
    assert!(!text.contains(" ×"), "{text}");
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS")]
fn what_lammps_parameters_mean_in_space() {
    let (text, _) = ends(&new_folder(), 0, &"engine card lammps --quiet".words());
    let told = [
        "AGREED: All ",
        "as it declares: moments_at_walls = none",
        "as it declares: slip = unstretched",
        "as it declares: spring_turn = keeps_length",
        "as it declares: tangential_dashpot = within_limit",
        "as it declares: torque_arms_at_walls = whole_radii",
        "Spheres with Hertz's and Mindlin's springs",
    ];
    has(&text, told);
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LIGGGHTS and ESyS-Particle")]
fn what_parameters_of_other_codes_mean() {
    let told = [
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
