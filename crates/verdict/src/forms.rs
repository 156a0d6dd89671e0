//! Which term of another engine has another form: each form is tried in the native engine's written-out step, with the constants
//! fitted anew.

use grains::rules::{Choice, Needs, Rules};
use grains::scene::{Springs, Viscosity};
use grains::tables::Body;
use grains::task::Case;
use grains::variant::{Form, Input, Key, Whose};

/// Shares of a whole kick that the first one may be by mistake.
const FIRST_KICKS: [f64; 2] = [1.5, 0.0];

/// The forms that make a difference in this case; those with a length are found by
/// [`lost_contacts`](crate::constants::Search::lost_contacts).
pub fn candidates(case: &Case) -> Vec<Form> {
    let keys = Key::ALL.into_iter();
    let unread = keys.filter(|key| key.unread(case).is_some());
    let mut forms: Vec<Form> = unread.map(Form::Unread).collect();
    forms.extend(other_rules(case).map(Form::Rule));
    forms.extend(FIRST_KICKS.map(Form::FirstKick));
    forms.extend(Form::OF_ANY_CASE);
    forms.extend([0, 1].map(Form::OneSided));
    forms.extend((0..case.model.walls.len()).map(Form::WallMissing));
    forms.extend(Form::of_case(case));
    if case.bodies.in_space() && case.model.law.has_friction() {
        forms.extend([0, 1, 2].map(Form::CoulombWithout));
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
        let all = Whose::ALL.into_iter();
        let all = all.map(move |whose| Form::TakenFor(input, whose));
        // The smaller friction angle and the mean radius of rolling are the model's, materials have no mean, and that of linear springs is a rule.
        all.filter(move |form| match form {
            // Formulas are the same for both where they have one number of each.
            Form::TakenFor(Input::StiffnessRadii, Whose::Other) => materials && !is_hertz,
            Form::TakenFor(Input::StiffnessRadii, whose) => {
                is_hertz || [Whose::First, Whose::Second].contains(whose)
            }
            Form::TakenFor(_, Whose::Other) => {
                let one_sided = [
                    Input::SlipRadii,
                    Input::TorqueArms,
                    Input::NormalPoissons,
                    Input::TangentialModuli,
                    Input::PoissonsOverShear,
                ];
                one_sided.contains(&input)
            }
            Form::TakenFor(Input::FrictionAngles, Whose::Smaller)
            | Form::TakenFor(Input::RollingRadii, Whose::Mean) => false,
            Form::TakenFor(_, Whose::Mean | Whose::GeometricMean) => ![
                Input::Materials,
                Input::NormalMaterials,
                Input::TangentialMaterials,
            ]
            .contains(&input),
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
