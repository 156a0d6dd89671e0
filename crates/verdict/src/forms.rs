//! Which term of another engine has another form: each form is tried in the native engine's written-out step, with the constants
//! fitted anew.

use grains::rules::{Choice, Needs, Rules};
use grains::scene::{Springs, Viscosity};
use grains::tables::Body;
use grains::task::Case;
use grains::variant::{Alone, Form, Input, Key, Whose};

/// Shares of a whole kick that the first one may be by mistake.
const FIRST_KICKS: [f64; 2] = [1.5, 0.0];

/// The forms that make a difference in this case; those with a length are found by
/// [`lost_contacts`](crate::constants::Search::lost_contacts).
pub fn candidates(case: &Case) -> Vec<Form> {
    let law = &case.model.law;
    let keys = Key::ALL.into_iter();
    let unread = keys.filter(|key| key.unread(case).is_some());
    let mut forms: Vec<Form> = unread.map(Form::Unread).collect();
    forms.extend(other_rules(case).map(Form::Rule));
    forms.extend(FIRST_KICKS.map(Form::FirstKick));
    forms.extend([
        Form::FoundLate,
        Form::NotFound,
        Form::OldNormals,
        Form::OldPositions,
        Form::OneSided(0),
        Form::OneSided(1),
    ]);
    forms.extend((0..case.model.walls.len()).map(Form::WallMissing));
    if case.punch.is_some() {
        forms.extend([Form::CornersMissing, Form::PunchLate]);
    }
    if law.has_friction() {
        forms.extend([
            Form::HistoryReset,
            Form::HistoryTurnedBack,
            Form::NoCoulombLimit,
            Form::CoulombByComponent,
        ]);
    }
    if law.rotates() {
        forms.extend([
            Form::TorqueSign,
            Form::SpinsKept,
            Form::SlipOfCentres,
            Form::NoTorqueOfFlatBodies,
        ]);
    }
    if matches!(law.contact.viscosity, Viscosity::Restitution { .. }) {
        forms.push(Form::DashpotOfMeanMass);
    }
    if law.has_dashpots() {
        forms.push(Form::DashpotWhileApproaching);
    }
    if law.has_friction() {
        forms.push(Form::SlidingKeepsOld);
    }
    if law.rotates() && case.model.alpha != 0.0 {
        forms.push(Form::SpinsDampedByOld);
        // In the plane a spin has one component, along which nothing moves.
        if case.bodies.in_space() {
            forms.extend([
                Form::SpinsDampedTogether,
                Form::SpinsDampedAsVelocities,
                Form::SpinsDampedAlong,
            ]);
        }
    }
    if let Some(rolling) = law.contact.rolling {
        forms.extend((!rolling.is_constant()).then_some(Form::MomentNotTurned));
        forms.extend(rolling.limit.map(|_| Form::TwistingLimited));
    }
    let mut obstacles = case.model.obstacles.iter();
    if obstacles.any(|obstacle| obstacle.velocity != [0.0; 3] || obstacle.spin != [0.0; 3]) {
        forms.extend([
            Form::ObstacleSpinUnfelt,
            Form::ObstacleVelocityUnfelt,
            Form::ObstacleTurnsAboutOwnAxes,
        ]);
    }
    forms.extend(inputs(case));
    forms
}

/// Inputs of a contact that may be taken of one of its bodies for both, where bodies differ in them.
fn inputs(case: &Case) -> impl Iterator<Item = Form> {
    let law = &case.model.law;
    let bodies = [Body::Grain, Body::Wall, Body::Punch];
    let angles = law.friction_angles();
    let friction = bodies.into_iter().flat_map(move |at| {
        let others = bodies.into_iter();
        // That of grains is a key that is not read.
        let others = others.filter(move |whose| {
            *whose != Body::Grain && angles[*whose as usize] != angles[at as usize]
        });
        others.map(move |whose| Form::FrictionOf([at, whose]))
    });
    let radii = plays_a_part(case, Needs::Radii);
    let materials = !law.materials.is_empty();
    let is_hertz = law.contact.springs == Springs::HertzMindlin;
    let differ = move |input: &Input| match input.is_of_materials() {
        true => materials,
        false => radii,
    };
    let taken = Input::ALL.into_iter();
    let taken = taken.filter(move |input| differ(input) && input.is_in(law));
    let taken = taken.flat_map(move |input| {
        let places: &[Alone] = match input.is_of_materials() {
            true => &[Alone::Everywhere, Alone::BetweenGrains, Alone::AtObstacles],
            false => &[Alone::Everywhere],
        };
        let all = places
            .iter()
            .flat_map(move |alone| Whose::ALL.map(|whose| Form::TakenFor(input, whose, *alone)));
        // The smaller friction angle and the mean radius of rolling are the model's, materials have no mean, and that of linear springs is a rule.
        all.filter(move |form| match form {
            // Formulas are the same for both where they have one number of each.
            Form::TakenFor(Input::StiffnessRadii, Whose::Other, _) => materials && !is_hertz,
            Form::TakenFor(Input::StiffnessRadii, whose, _) => {
                is_hertz || [Whose::First, Whose::Second].contains(whose)
            }
            Form::TakenFor(_, Whose::Other, _) => {
                let one_sided = [
                    Input::SlipRadii,
                    Input::TorqueArms,
                    Input::NormalPoissons,
                    Input::TangentialModuli,
                ];
                one_sided.contains(&input)
            }
            Form::TakenFor(Input::FrictionAngles, Whose::Smaller, _)
            | Form::TakenFor(Input::RollingRadii, Whose::Mean, _) => false,
            Form::TakenFor(_, Whose::Mean | Whose::GeometricMean, _) => {
                ![Input::NormalMaterials, Input::TangentialMaterials].contains(&input)
            }
            _ => true,
        })
    });
    friction.chain(taken)
}

/// Whether the model of this case has what a rule is about.
pub fn plays_a_part(case: &Case, needs: Needs) -> bool {
    let (model, law) = (&case.model, &case.model.law);
    let has_flat = case.punch.is_some() || !model.walls.is_empty();
    let restitution = matches!(law.contact.viscosity, Viscosity::Restitution { .. });
    let is_hertz = law.contact.springs == Springs::HertzMindlin;
    let radii = &case.bodies.radius;
    let moments = law.contact.rolling.filter(|_| law.rotates());
    match needs {
        Needs::Nothing => true,
        Needs::LocalDamping => model.alpha != 0.0,
        Needs::Radii => radii.iter().any(|radius| *radius != radii[0]),
        Needs::Walls => has_flat,
        Needs::Friction => law.has_friction(),
        Needs::Spins => law.rotates(),
        Needs::DampedSpins => law.rotates() && model.alpha != 0.0,
        Needs::Dashpots => law.has_dashpots(),
        Needs::DashpotsAndFriction => law.has_dashpots() && law.has_friction(),
        Needs::Restitution => restitution,
        Needs::RestitutionAndWalls => restitution && has_flat,
        Needs::HertzAndFriction => is_hertz && law.has_friction(),
        Needs::HertzAndWalls => is_hertz && has_flat,
        Needs::HertzAndDashpots => {
            let of_its_own = law.contact.tangential_viscosity.is_some();
            is_hertz && law.has_friction() && law.has_dashpots() && of_its_own
        }
        Needs::Moments => moments.is_some(),
        Needs::ConstantMoments => moments.is_some_and(|rolling| rolling.is_constant()),
        Needs::MomentsAndWalls => moments.is_some() && has_flat,
    }
}

/// Every other rule that makes a difference in this case.
pub fn other_rules(case: &Case) -> impl Iterator<Item = Choice> {
    let rules = case.model.law.resolved(case.model.rules);
    // What walls have from pairs the punch has too, but for the slip velocity: that of the contact point.
    let is_of_pairs = move |choice: &Choice| {
        let is_slip = choice.rule().needs == Needs::Friction;
        let is_other = is_slip && choice.alternative().key != "contact_point";
        let at_punch = case.punch.is_some() && is_other;
        !at_punch && is_between_grains(*choice, &rules)
    };
    Choice::all().filter(move |choice| {
        let other = !choice.is_in(&rules) && !choice.is_models() && !is_of_pairs(choice);
        plays_a_part(case, choice.rule().needs) && other
    })
}

/// Whether an alternative at walls is what these rules have between two grains.
pub fn is_between_grains(choice: Choice, rules: &Rules) -> bool {
    let pairs = choice.rule().key.strip_suffix("_at_walls");
    let of_pairs = pairs.and_then(|pairs| Choice::of(pairs, choice.alternative().key));
    of_pairs.is_some_and(|of_pairs| of_pairs.is_in(rules))
}

/// What an engine with this form does, and what is right.
pub fn in_words(form: Form) -> String {
    match form {
        Form::Rule(choice) => {
            let (rule, alternative) = (choice.rule(), choice.alternative());
            let usual = &rule.alternatives[0];
            let instead = match usual == alternative {
                true => String::new(),
                false => format!(" instead of {}", usual.formula),
            };
            let (subject, formula) = (rule.subject(), alternative.formula);
            format!("{subject}: {formula}{instead} ({})", choice.name())
        }
        Form::FirstKick(share) => format!("the first kick is {share} of one, and is to be a whole one"),
        Form::ClassesOfRadius(most) => mean(&format!("that of the middle radii of at most {most} classes")),
        Form::WallMissing(index) => format!("wall {index} of model.walls is not there"),
        Form::CornersMissing => {
            "the punch's corners are not there: a corner acts as a point".into()
        }
        Form::PunchLate => {
            "the punch moves after the forces: it is to move before them, as grains do".into()
        }
        Form::LostNear(length) => format!("contacts of grains nearer than {length:.6} m are lost"),
        Form::LostFar(length) => format!("contacts of grains farther apart than {length:.6} m are lost"),
        Form::FoundLate => "contacts are found a step after they begin".into(),
        Form::OldNormals => "normals are those of the step before".into(),
        Form::NotFound => "contacts that begin are not found for some steps: the search is made too seldom for its skin".into(),
        Form::OldPositions => "forces are those of the positions before the step".into(),
        Form::HistoryTurnedBack => "the tangential force turns against the normal, and is to turn with it".into(),
        Form::CoulombByComponent => "each component of the tangential force is limited by itself: its size is to be limited".into(),
        Form::DashpotOfMeanMass => "c_n is made from the mean of two masses: the effective mass is m1·m2/(m1 + m2)".into(),
        Form::OneSided(0) => "of a pair only the first grain feels the force".into(),
        Form::OneSided(_) => "of a pair only the second grain feels the force".into(),
        Form::HistoryReset => "the tangential force is forgotten in each step".into(),
        Form::NoCoulombLimit => "the tangential force is not limited by |N| tan φ".into(),
        Form::TorqueSign => "the torque on the second body of a pair has the wrong sign".into(),
        Form::SpinsKept => "spins do not change".into(),
        Form::SlipOfCentres => "the slip leaves the spins out".into(),
        Form::NoTorqueOfFlatBodies => "walls and punch do not turn grains".into(),
        Form::TakenFor(input, whose, alone) => {
            let whose = match whose {
                Whose::First => "the first one's",
                Whose::Second => "the second one's",
                Whose::Smaller => "the smaller one",
                Whose::Larger => "the larger one",
                Whose::Mean => "the mean",
                Whose::GeometricMean => "the geometric mean",
                Whose::Other => "the other one's",
            };
            let place = match alone {
                Alone::Everywhere => "bodies",
                Alone::BetweenGrains => "grains",
                Alone::AtObstacles => "bodies at walls, punch and obstacles",
            };
            format!("the {} is {whose} for both {place}", input.name())
        }
        Form::FrictionOf([at, whose]) => {
            let names = [at, whose].map(|body| ["between grains", "at walls", "at the punch"][body as usize]);
            format!("friction {} is that {}", names[0], names[1])
        }
        Form::ObstacleSpinUnfelt => "what touches an obstacle does not feel that it turns: its velocity is v + ω × r".into(),
        Form::ObstacleVelocityUnfelt => "what touches an obstacle does not feel that it moves".into(),
        Form::ObstacleTurnsAboutOwnAxes => "an obstacle turns about axes that turn with it: its spin is in fixed ones".into(),
        Form::MomentNotTurned => "the moment against rolling does not turn with the normal".into(),
        Form::TwistingLimited => "the moment against twisting has the limit of that against rolling, and is to have none".into(),
        Form::SlidingKeepsOld => "a spring that is cut to Coulomb's limit keeps its force of the step before: it is to keep what was cut".into(),
        Form::DashpotWhileApproaching => "the dashpot along the normal acts while bodies approach alone".into(),
        Form::SpinsDampedByOld => "local damping of spins takes the sign of the spin before the step, and is to take that of its middle".into(),
        Form::SpinsDampedTogether => "local damping of spins takes the sign of the power of all components together, and is to take that of each".into(),
        Form::SpinsDampedAsVelocities => "local damping of spins takes the sign of the power of the velocity along the same axis, and is to take that of the spin".into(),
        Form::SpinsDampedAlong => "local damping of spins is α|ω̇| against the spin: each component is to be damped by itself".into(),
        Form::Unread(key) => format!("{} is not read: the paper's value takes its place", key.name()),
    }
}

fn mean(value: &str) -> String {
    format!("the stiffness of a pair is {value}: k_n = 2·E·R1·R2/(R1 + R2)")
}
