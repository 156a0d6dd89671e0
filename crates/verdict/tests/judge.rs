//! Engines made of the native one: what is right is called right, every constant and every form is named.

use std::sync::LazyLock;

use evidence::in_parallel;
use evidence::random::Source;
use grains::constant::Constant;
use grains::model::Kernel;
use grains::native::{Fault, NativeError, run_case};
use grains::rules::{
    CATALOGUE, Choice, GivenVelocities, Rules, SpringWhenSliding, TangentialDashpot,
    WrittenVelocities,
};
use grains::tables::Bodies;
use grains::task::Case;
use grains::variant::{self, Alone, Form, Variant};
use verdict::causes::Cause;
use verdict::constants::Fitted;
use verdict::envelope::Resolution;
use verdict::excerpt::Excerpt;
use verdict::forms;
use verdict::judge::{Judgement, Reference, Verdict};
use verdict::starts::{Bed, DISPERSION, LawKind, Start, State};
use verdict::{Answer, Engine};

static REFERENCE: LazyLock<Reference> =
    LazyLock::new(|| Reference::new(300, DISPERSION, &mut |_| ()).expect("a bed"));

fn constant(symbol: &str) -> Constant {
    Constant::with_symbol(symbol).expect("a constant")
}

fn judged(engine: &mut Engine<'_, NativeError>) -> Judgement {
    judged_by(&REFERENCE, engine)
}

fn judged_by(reference: &Reference, engine: &mut Engine<'_, NativeError>) -> Judgement {
    reference
        .judge(&[], &|_| None, engine, &mut |_| ())
        .unwrap_or_else(|_| panic!("the native engine failed"))
}

fn of_variant(variant: &Variant) -> Judgement {
    judged(&mut |cases| {
        let run = |at: usize| -> Answer { Ok(variant::run(cases[at], variant)) };
        Ok(in_parallel(cases.len(), run))
    })
}

/// Forces of places in single precision, told from the corner of a cell as wide as a grain; all else in double precision.
fn with_single_forces(case: &Case) -> Answer {
    if Kernel::of(&case.model.law) == Kernel::General {
        return Err("it cannot be taken up where contacts remember".to_owned());
    }
    let side = 2.0 * case.bodies.radius[0];
    let single = |number: &f64| {
        let corner = (number / side).floor() * side;
        corner + f64::from((number - corner) as f32)
    };
    let (mut now, mut kept) = (case.clone(), Vec::new());
    for step in 0..=case.moments.last().copied().unwrap_or(0) {
        let Bodies { x, z, .. } = &now.bodies;
        let coarse = Bodies {
            x: x.iter().map(single).collect(),
            z: z.iter().map(single).collect(),
            ..now.bodies.clone()
        };
        now.moments = vec![u64::from(step > 0)];
        let rounded = Case {
            bodies: if step > 0 { coarse } else { now.bodies.clone() },
            ..now.clone()
        };
        let after = run_case(&rounded, None).map_err(|error| error.to_string())?;
        for mut after in after {
            if step > 0 {
                let Bodies { x, z, vx, vz, .. } = &mut after.bodies;
                for id in 0..x.len() {
                    x[id] = now.bodies.x[id] + case.model.dt * vx[id];
                    z[id] = now.bodies.z[id] + case.model.dt * vz[id];
                }
            }
            (now.bodies, now.punch) = (after.bodies.clone(), after.punch);
            after.step = step;
            if case.moments.contains(&step) {
                kept.push(after);
            }
        }
    }
    Ok(kept)
}

#[test]
fn the_step_written_out_has_the_bits_of_the_fast_one() {
    let bed = Bed::new(300, DISPERSION).expect("a bed");
    for State { case, .. } in bed.states() {
        let fast = run_case(&case, None).expect("a run");
        let obvious = variant::run(&case, &Variant::default());
        for (a, b) in obvious.iter().zip(&fast) {
            let when = format!("{} step {}", case.name, b.step);
            assert_eq!(a.bodies, b.bodies, "{when}");
            assert_eq!(a.contacts, b.contacts, "{when}");
            assert_eq!(a.punch, b.punch, "{when}");
            // A zero of the other sign is equal, and is another number of the digest.
            assert_eq!(a.digest(), b.digest(), "{when}");
        }
        assert_eq!(obvious.len(), fast.len());
    }
}

/// A choice of every rule, drawn.
fn drawn_rules(source: &mut Source) -> Rules {
    let mut rules = Rules::default();
    for rule in CATALOGUE.iter().filter(|rule| !rule.needs.is_of_space()) {
        let of_rule = Choice::all().filter(|choice| std::ptr::eq(choice.rule(), rule));
        let of_rule: Vec<Choice> = of_rule.collect();
        // Each is the first as often as all others together.
        let at = match source.below(2) {
            0 => 0,
            _ => 1 + source.below(of_rule.len() - 1),
        };
        of_rule[at].set(&mut rules);
    }
    rules
}

#[test]
fn a_run_under_other_rules_is_the_step_written_out_and_goes_on_where_it_ended() {
    let mut source = Source::new(b"crossgrain: rules that are drawn", 1);
    let bed = Bed::new(100, DISPERSION).expect("a bed");
    for state in bed.states().into_iter().filter(|state| state.drawn) {
        let case = state.under(drawn_rules(&mut source)).case;
        let run = run_case(&case, None).expect("a run");
        let written_out = variant::run(&case, &Variant::default());
        for (a, b) in run.iter().zip(&written_out) {
            let when = format!("{} step {}", case.name, b.step);
            assert_eq!(a.bodies, b.bodies, "{when}");
            assert_eq!(a.contacts, b.contacts, "{when}");
            assert_eq!(a.punch, b.punch, "{when}");
        }
    }
    let mut excerpts = bed.excerpts().expect("excerpts");
    excerpts.retain(|excerpt| excerpt.key.starts_with("excerpt-drawn"));
    for excerpt in excerpts {
        let mut rules = drawn_rules(&mut source);
        // Written velocities are no start, and the first kick of a start is half of one.
        rules.written_velocities = WrittenVelocities::HalfStep;
        rules.given_velocities = GivenVelocities::HalfStepBefore;
        // Where a spring does not remember its force, nobody can say what it was.
        rules.spring_when_sliding = SpringWhenSliding::Limited;
        rules.tangential_dashpot = TangentialDashpot::None;
        let excerpt = excerpt.under(rules);
        let whole = excerpt.native(None).expect("a run");
        let middle = whole.len() / 2;
        let from = whole[middle].clone();
        let (stage, step) = (from.stage, from.step);
        if step == 0 {
            continue;
        }
        let mut rest = Excerpt::new("", "", &excerpt.scene, from.into());
        rest.task.until = excerpt.task.until;
        let rest = rest.native(None).expect("a run");
        let after = whole.iter().skip(middle);
        assert_eq!((rest[0].stage, rest[0].step), (stage, step));
        for (a, b) in rest.iter().zip(after).skip(1) {
            assert_eq!(a.bodies, b.bodies, "{} step {}", excerpt.start, b.step);
        }
    }
}

#[test]
fn an_engine_is_judged_by_the_rules_that_it_declares_and_one_declared_wrongly_is_named() {
    let mut source = Source::new(b"crossgrain: rules that are drawn", 2);
    let mut unnamed = Vec::new();
    let small = Reference::new(100, DISPERSION, &mut |_| ()).expect("a bed");
    for _ in 0..2 {
        let rules = drawn_rules(&mut source);
        let reference = small.under(rules);
        let judged = |computed: Rules| {
            let mut engine = computing(computed, Variant::default());
            let judged = reference.judge(&[], &|_| None, &mut engine, &mut |_| ());
            judged.unwrap_or_else(|_| panic!("the native engine failed"))
        };
        let right = judged(rules);
        let states = right.starts.iter().map(|state| {
            let (law, start) = (&state.law, &state.start);
            format!("{law} {start} {:?} {}", state.verdict, state.in_words())
        });
        let states: Vec<String> = states.collect();
        assert_eq!(right.verdict(), Verdict::Identical, "{rules:?} {states:#?}");
        assert_eq!(right.declared.len(), rules.unusual().count());
        // One that shows in any state.
        let others: Vec<Choice> = {
            let states = Bed::new(100, DISPERSION).expect("a bed").states();
            let cases = states.iter().map(|state| state.under(rules).case);
            let all = cases.flat_map(|case| forms::other_rules(&case).collect::<Vec<_>>());
            all.collect()
        };
        let wrong = others[source.below(others.len())];
        let mut computed = rules;
        wrong.set(&mut computed);
        let found = judged(computed);
        let said: Vec<String> = found.causes.iter().map(Cause::sentence).collect();
        let is_named = found.causes.iter().any(|cause| {
            let mut forms = cause.forms.iter().chain(&cause.also);
            forms.any(|form| *form == Form::Rule(wrong))
        });
        if found.verdict() != Verdict::Different || !is_named {
            unnamed.push(format!("{} {:?} {said:?}", wrong.name(), found.verdict()));
        }
    }
    assert!(unnamed.is_empty(), "{unnamed:#?}");
}

/// The reference under these rules, whatever a case asks for, as an engine.
fn computing(
    rules: Rules,
    variant: Variant,
) -> impl FnMut(&[&Case]) -> Result<Vec<Answer>, NativeError> {
    move |cases| {
        let run = |at: usize| -> Answer {
            let mut case = cases[at].clone();
            case.model.rules = rules;
            Ok(variant::run(&case, &variant))
        };
        Ok(in_parallel(cases.len(), run))
    }
}

#[test]
fn rules_that_are_not_declared_are_found_beside_a_wrong_constant_too() {
    let mut source = Source::new(b"crossgrain: rules that are found", 3);
    let reference = Reference::new(100, DISPERSION, &mut |_| ()).expect("a bed");
    let modulus = Constant::with_symbol("k_n between grains").expect("a constant");
    for wrong in [0.0, 1.0e-2] {
        let rules = drawn_rules(&mut source);
        let mut engine = computing(rules, Variant::default().and(modulus, wrong));
        let found = reference.identify(&[], &|_| None, &mut engine, &mut |_| ());
        let found = found.unwrap_or_else(|_| panic!("the native engine failed"));
        let said: Vec<String> = found.judgement.causes.iter().map(Cause::sentence).collect();
        // In states that were not looked at to find them too.
        let rules = (rules, found.rules);
        let is_other = found.judgement.verdict() == Verdict::Different;
        assert_eq!(is_other, wrong != 0.0, "{rules:#?} {said:?}");
        assert!(
            wrong == 0.0 || said[0].contains("k_n between grains × 1.01000000000"),
            "{said:?}"
        );
        let of_space = CATALOGUE.iter().filter(|rule| rule.needs.is_of_space());
        let of_space: Vec<&str> = of_space.map(|rule| rule.key).collect();
        assert_eq!(found.unasked, of_space, "in the plane");
    }
}

#[test]
fn the_native_engine_is_identical_and_small_faults_would_have_been_seen() {
    let judgement = of_variant(&Variant::default());
    assert_eq!(judgement.verdict(), Verdict::Identical);
    assert_eq!(judgement.unseen, Vec::<String>::new());
    assert!(
        judgement.counts.len() == 4 && judgement.counts.iter().all(|counts| counts.is_enough())
    );
    // Others are in space alone.
    let not_planar = [
        "place of wall 3",
        "place of wall 4",
        "c_s",
        "bending",
        "twisting",
        "η",
        "γ",
        "E of",
        "velocity of obstacles",
        "spin of obstacles",
    ];
    let is_planar = |constant: &Constant| {
        let mut others = not_planar.iter();
        !others.any(|other| constant.symbol().starts_with(other))
    };
    for constant in Constant::all().filter(is_planar) {
        let limit = judgement
            .limits
            .iter()
            .find(|limit| limit.constant == constant.symbol());
        let smallest = limit.map_or(f64::NAN, |limit| limit.smallest);
        assert!(smallest <= 1.0e-8, "{}: {smallest:e}", constant.symbol());
    }
}

#[test]
fn sums_in_another_order_are_rounding_and_forces_in_single_precision_are_said_to_be_single() {
    let reversed: Fault = "sums=reversed".parse().expect("a fault");
    let reversed = |case: &Case| -> Answer {
        run_case(case, Some(reversed)).map_err(|error| error.to_string())
    };
    type Run<'a> = &'a (dyn Fn(&Case) -> Answer + Sync);
    let engines: [(Run<'_>, _); 2] = [
        (&reversed, "double precision"),
        (&with_single_forces, "single precision"),
    ];
    for (run, precision) in engines {
        let judgement = judged(&mut |cases| Ok(in_parallel(cases.len(), |at| run(cases[at]))));
        assert_eq!(judgement.resolution.name(), precision);
        for state in &judgement.starts {
            let refused = state.skipped.is_some();
            // A drawn law may be without memory, and then it is not refused.
            if !state.key.starts_with("drawn") {
                let remembers = !state.law.starts_with("springs");
                assert_eq!(refused, remembers && precision.starts_with("single"));
            }
            let expected = match refused {
                true => Verdict::Undecided,
                false => Verdict::EqualToRounding,
            };
            let found = state.verdict;
            // In the loose cloud few grains touch, and bits may stay.
            let bits = state.start == Start::Loose.name() && found == Verdict::Identical;
            assert!(found == expected || bits, "{precision} {state:?}");
        }
    }
}

#[test]
fn an_engine_that_refuses_is_undecided() {
    let refuses = |cases: &[&Case]| Ok(vec![Err("no".to_owned()); cases.len()]);
    assert_eq!(judged(&mut { refuses }).verdict(), Verdict::Undecided);
    let none = REFERENCE.judge(
        &[],
        &|_| Some("walls".to_owned()),
        &mut { refuses },
        &mut |_| (),
    );
    let none: Judgement = none.unwrap_or_else(|_| panic!("the native engine failed"));
    assert_eq!(none.verdict(), Verdict::Undecided);
    // 24 states of the usual laws, 24 of drawn ones and a large one.
    assert_eq!(none.not_asked.len(), 49);
}

#[test]
fn an_engine_that_writes_other_moments_is_different() {
    let judgement = judged(&mut |cases| {
        let short = |case: &&Case| -> Answer {
            let mut run = variant::run(case, &Variant::default());
            run.pop();
            Ok(run)
        };
        Ok(cases.iter().map(short).collect())
    });
    assert_eq!(judgement.verdict(), Verdict::Different);
}

#[test]
fn several_wrong_constants_are_found_at_once() {
    let wrong = [
        (constant("k_n between grains"), 0.05),
        (constant("α"), -0.1),
        (constant("g_z"), -0.001),
        (constant("Δt"), 0.01),
        (constant("tan φ"), 1.0e-4),
        (constant("moment of inertia"), 1.0e-6),
        (constant("c_n"), 0.5),
    ];
    let and =
        |variant: Variant, (constant, larger): &(Constant, f64)| variant.and(*constant, *larger);
    let variant = wrong.iter().fold(Variant::default(), and);
    let judgement = of_variant(&variant);
    let found: Vec<_> = judgement
        .causes
        .iter()
        .flat_map(|cause| &cause.constants)
        .collect();
    assert_eq!(found.len(), wrong.len(), "{found:?}");
    for (constant, larger) in wrong {
        let fitted = found.iter().find(|fitted| fitted.constant == constant);
        let apart = fitted.map_or(f64::NAN, |fitted| (fitted.larger - larger).abs());
        assert!(apart < 1.0e-11, "{}: {apart:e}", constant.symbol());
    }
    assert!(judgement.causes.iter().all(|cause| cause.explained));
    let farthest = judgement
        .farthest()
        .and_then(|start| start.farthest.as_ref());
    assert_eq!(farthest.and_then(|state| state.left_after), Some(0));
}

/// Springs that are all stiffer by the same share, as far as it is known, are said once.
/// Of a value that is cut in one law the factor is not said to be that of all.
#[test]
fn what_is_off_under_drawn_laws_alone_is_said_to_be() {
    let judgement = judged(&mut |cases| {
        let run = |at: usize| -> Answer {
            let mut case = cases[at].clone();
            case.model.alpha = case.model.alpha.min(0.9);
            Ok(variant::run(&case, &Variant::default()))
        };
        Ok(in_parallel(cases.len(), run))
    });
    assert_eq!(judgement.verdict(), Verdict::Different);
    let said = judgement.causes[0].sentence();
    assert!(
        said.contains("nothing is off under the usual laws"),
        "{said}"
    );
}

#[test]
fn one_stiffness_for_all_springs_is_one_cause() {
    let causes_of = |of_wall, of_punch, error| {
        let stiffer = |constant, larger| Fitted {
            constant,
            larger,
            error,
        };
        let cause = Cause {
            constants: vec![
                stiffer(constant("k_n between grains"), 0.05),
                stiffer(constant("k_n at walls"), of_wall),
                stiffer(constant("k_n at the punch"), of_punch),
            ],
            explained: true,
            ..Cause::default()
        };
        cause.sentence().matches('×').count()
    };
    assert_eq!(causes_of(0.05, 0.05, 0.0), 1);
    assert_eq!(causes_of(0.0505, 0.051, 1.0e-4), 1);
    assert_eq!(causes_of(0.0505, 0.052, 1.0e-4), 3);
}

/// Positions in single precision, or the velocities of the grains that fly, or of those that touch: each shows in its own number.
#[test]
fn a_coarse_number_is_told_from_the_others() {
    let bed = Bed::new(300, DISPERSION).expect("a bed");
    let mut cases = bed.cases(LawKind::Springs).into_iter();
    let (_, case) = cases
        .find(|case| case.0 == Start::Pouring)
        .expect("a state");
    let contacts = &variant::run(&case.at(vec![0]), &Variant::default())[0].contacts;
    let pairs = || contacts.iter().map(|contact| [contact.id1, contact.id2]);
    let touches = |id: usize| pairs().any(|pair| pair.contains(&(id as u32)));
    let single = |number: &mut f64| *number = f64::from(*number as f32);
    let coarse = |positions: bool, velocities: &dyn Fn(usize) -> bool| {
        let answers: Vec<Answer> = Resolution::cases(&case)
            .iter()
            .map(|case| {
                let mut run = variant::run(case, &Variant::default());
                let bodies = &mut run[0].bodies;
                for id in 0..bodies.len() {
                    if positions {
                        single(&mut bodies.x[id]);
                        single(&mut bodies.z[id]);
                    }
                    if velocities(id) {
                        single(&mut bodies.vx[id]);
                        single(&mut bodies.vz[id]);
                    }
                }
                Ok(run)
            })
            .collect();
        let resolution = Resolution::measured(&case, &answers).expect("answers");
        [resolution.position, resolution.velocity, resolution.overlap].map(|error| error > 1.0e-13)
    };
    assert_eq!(coarse(false, &|_| false), [false; 3]);
    assert_eq!(coarse(true, &|_| false), [true, false, false]);
    assert_eq!(coarse(false, &|id| !touches(id)), [false, true, false]);
    assert_eq!(coarse(false, &touches), [false, false, true]);
}

#[test]
fn each_form_is_named() {
    let bed = Bed::new(300, DISPERSION).expect("a bed");
    let mut tried: Vec<Form> = Vec::new();
    for law in LawKind::ALL {
        for (_, case) in bed.cases(law) {
            for form in forms::candidates(&case) {
                if !tried.contains(&form) {
                    tried.push(form);
                }
            }
        }
    }
    tried.extend([Form::LostNear(0.0097), Form::LostFar(0.0103)]);
    are_named(&REFERENCE, &tried);
    let in_space = verdict::spheres::reference().expect("a bed");
    let mut of_space: Vec<Form> = Vec::new();
    for state in in_space.states() {
        for form in forms::candidates(&state.case) {
            let is_rule = matches!(form, Form::Rule(_) | Form::Unread(_));
            if !is_rule && !tried.contains(&form) && !of_space.contains(&form) {
                of_space.push(form);
            }
        }
    }
    are_named(&in_space, &of_space);
}

fn are_named(reference: &Reference, tried: &[Form]) {
    let mut unnamed = Vec::new();
    for form in tried {
        let variant = Variant::of(*form);
        let judgement = judged_by(reference, &mut |cases| {
            let run = |at: usize| -> Answer { Ok(variant::run(cases[at], &variant)) };
            Ok(in_parallel(cases.len(), run))
        });
        let named = judgement.causes.iter().any(|cause| {
            let mut forms = cause.forms.iter().chain(&cause.also);
            let kind = std::mem::discriminant(form);
            forms.any(|named| match form {
                Form::Rule(_) | Form::TakenFor(..) | Form::FrictionOf(_) => named == form,
                _ => std::mem::discriminant(named) == kind,
            })
        });
        if judgement.verdict() != Verdict::Different || !named {
            let said: Vec<String> = judgement
                .causes
                .iter()
                .map(|cause| cause.sentence())
                .collect();
            unnamed.push(format!("{form:?}: {:?} {said:?}", judgement.verdict()));
        }
    }
    assert!(unnamed.is_empty(), "of {}: {unnamed:#?}", tried.len());
}

/// The friction of LAMMPS: each of three rules is a small part of a contact's force.
#[test]
fn several_forms_under_one_law_are_named_together() {
    let rule = |key, alternative| Form::Rule(Choice::of(key, alternative).expect("a rule"));
    let forms = [
        rule("slip", "unstretched"),
        rule("spring_turn", "keeps_length"),
        rule("torque_arms_at_walls", "whole_radii"),
    ];
    let judgement = of_variant(&Variant {
        forms: forms.to_vec(),
        ..Variant::default()
    });
    let named: Vec<Form> = judgement
        .causes
        .iter()
        .flat_map(|cause| cause.forms.clone())
        .collect();
    assert!(forms.iter().all(|form| named.contains(form)), "{named:?}");
    assert_eq!(named.len(), forms.len(), "{named:?}");
    assert!(judgement.causes.iter().all(|cause| cause.explained));
}

/// −0 is another bit pattern than 0, though it is the same number.
/// It is not taken for what all contacts have, nor is it told of more contacts than have it.
#[test]
fn what_contacts_at_one_place_alone_have_is_told_with_the_place() {
    let faults = [
        (
            Alone::AtObstacles,
            Variant::default().and(constant("k_s"), 0.1),
            "k_s × 1.1",
        ),
        (
            Alone::AtPunch,
            Variant::of(Form::NoCoulombLimit),
            "is not limited by |N| tan φ",
        ),
        (
            Alone::BetweenGrains,
            Variant::of(Form::SlidingKeepsOld),
            "keeps its force of the step before",
        ),
    ];
    for (alone, variant, words) in faults {
        let judgement = of_variant(&Variant { alone, ..variant });
        let place = alone.place();
        let told = |cause: &Cause| {
            let said = cause.sentence();
            said.starts_with(&format!("{place} alone: ")) && said.contains(words)
        };
        let said: Vec<String> = judgement.causes.iter().map(Cause::sentence).collect();
        assert!(judgement.causes.iter().any(told), "{place}: {said:#?}");
    }
}

#[test]
fn a_zero_of_the_other_sign_is_not_identical() {
    let judgement = judged(&mut |cases| {
        let run = |case: &&Case| {
            let mut states = run_case(case, None)?;
            for state in &mut states {
                for number in state.bodies.vx.iter_mut().filter(|number| **number == 0.0) {
                    *number = -*number;
                }
                for contact in &mut state.contacts {
                    for part in contact.normal.iter_mut().filter(|part| **part == 0.0) {
                        *part = -*part;
                    }
                }
            }
            Ok(Ok(states))
        };
        cases.iter().map(run).collect()
    });
    assert_eq!(judgement.verdict(), Verdict::EqualToRounding);
}
