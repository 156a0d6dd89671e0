//! Which term of another engine has another form: each form is tried in the native engine's written-out step, with the constants
//! fitted anew.

use grains::scene::{SlipVelocity, Viscosity};
use grains::task::Case;
use grains::variant::{Form, Key};

/// Shares of a whole kick that the first one may be.
const FIRST_KICKS: [f64; 3] = [0.5, 1.5, 0.0];

/// The forms that make a difference under this law; those with a length are found by
/// [`lost_contacts`](crate::constants::Search::lost_contacts).
pub fn candidates(case: &Case) -> Vec<Form> {
    let law = &case.model.law;
    let keys = Key::NAMES.into_iter().map(|(key, _)| key);
    let unread = keys.filter(|key| key.unread(case).is_some());
    let mut forms: Vec<Form> = unread.map(Form::Unread).collect();
    forms.extend(FIRST_KICKS.map(Form::FirstKick));
    forms.extend([Form::MovedBeforeKick, Form::MovedInMiddleOfKick]);
    if case.model.alpha != 0.0 {
        forms.extend([
            Form::DampingVelocity(0.0),
            Form::DampingVelocity(1.0),
            Form::GravityUndamped,
            Form::DampingAlongVelocity,
            Form::DampingByWholePower,
        ]);
    }
    forms.extend([
        Form::ArithmeticMean,
        Form::GeometricMean,
        Form::SmallerStiffness,
        Form::LargerStiffness,
        Form::StiffnessOfFirst,
        Form::FoundLate,
        Form::NotFound,
        Form::OldNormals,
        Form::OldPositions,
        Form::WrittenAtWholeSteps,
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
            Form::HistoryNotTurned,
            Form::HistoryTurnedBack,
            Form::HistoryKeepsLength,
            Form::HistoryProjected,
            Form::NoCoulombLimit,
            Form::CoulombByComponent,
            Form::OtherSlip,
            Form::OtherNewContact,
        ]);
        if law.contact.slip_velocity == SlipVelocity::RatchetingCorrected {
            forms.push(Form::SlipNotStretched);
        }
    }
    if law.rotates() {
        forms.extend([
            Form::OtherTorqueArms,
            Form::WholeArms,
            Form::WholeArmsAtFlatBodies,
            Form::TorqueSign,
            Form::SpinsKept,
            Form::SlipOfCentres,
            Form::NoTorqueOfFlatBodies,
        ]);
        if case.model.alpha != 0.0 {
            forms.push(Form::SpinUndamped);
        }
    }
    if law.has_dashpots() {
        forms.extend([Form::OtherClipping, Form::DashpotOnWholeVelocity]);
        if law.has_friction() {
            forms.push(Form::CoulombOfSpring);
        }
        if matches!(law.contact.viscosity, Viscosity::Restitution { .. }) {
            forms.push(Form::DashpotOfMeanMass);
        }
    }
    forms
}

/// What an engine with this form does, and what is right.
pub fn in_words(form: Form) -> String {
    match form {
        Form::FirstKick(0.5) => {
            "the first kick is half of one: the velocities that are given belong to the half step before the start".into()
        }
        Form::FirstKick(share) => format!("the first kick is {share} of one, and is to be a whole one"),
        Form::MovedBeforeKick => {
            "positions move with the velocity before the kick: first v += Δt·a, then x += Δt·v".into()
        }
        Form::MovedInMiddleOfKick => {
            "positions move with the mean of the velocities before and after the kick: first v += Δt·a, then x += Δt·v".into()
        }
        Form::DampingVelocity(share) => format!(
            "the sign in the damping is that of a·(v + {share}·Δt·a), and must be that of a·(v + ½Δt·a)"
        ),
        Form::GravityUndamped => {
            "damping leaves gravity out: the whole acceleration is multiplied by 1 − α·sign".into()
        }
        Form::DampingByWholePower => {
            "damping goes by the sign of the whole power a·v: it is to judge each component by itself".into()
        }
        Form::DampingAlongVelocity => {
            "damping acts along the velocity: it is to act on each component by itself".into()
        }
        Form::ArithmeticMean => mean("the arithmetic mean of E·R"),
        Form::GeometricMean => mean("the geometric mean of E·R"),
        Form::SmallerStiffness => mean("the smaller E·R"),
        Form::LargerStiffness => mean("the larger E·R"),
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
        Form::StiffnessOfFirst => mean("E·R1, that of the grain with the lower id"),
        Form::NotFound => "contacts that begin are not found for some steps: the search is made too seldom for its skin".into(),
        Form::OldPositions => "forces are those of the positions before the step".into(),
        Form::WrittenAtWholeSteps => "the velocities that are written belong to whole steps, and are to belong to the half step before the positions".into(),
        Form::HistoryTurnedBack => "the tangential force turns against the normal, and is to turn with it".into(),
        Form::HistoryKeepsLength => "the tangential force keeps its length as it turns with the normal: S − S × (n_old × n) is longer by √(1 + sin²) of the angle".into(),
        Form::HistoryProjected => "the tangential force is projected onto the new tangent: it is to turn with the normal".into(),
        Form::CoulombByComponent => "each component of the tangential force is limited by itself: its size is to be limited".into(),
        Form::CoulombOfSpring => "the limit of the tangential force leaves the dashpot out: N is the whole normal force".into(),
        Form::DashpotOfMeanMass => "c_n is made from the mean of two masses: the effective mass is m1·m2/(m1 + m2)".into(),
        Form::DashpotOnWholeVelocity => "dashpots brake the tangential velocity too: they act along the normal alone".into(),
        Form::OneSided(0) => "of a pair only the first grain feels the force".into(),
        Form::OneSided(_) => "of a pair only the second grain feels the force".into(),
        Form::HistoryReset => "the tangential force is forgotten in each step".into(),
        Form::HistoryNotTurned => "the tangential force does not turn with the normal".into(),
        Form::NoCoulombLimit => "the tangential force is not limited by |N| tan φ".into(),
        Form::OtherTorqueArms => "the arms of the torque are not those of law.contact.torque_arms".into(),
        Form::WholeArms => "the arms of the torque are the radii, without the half overlap".into(),
        Form::WholeArmsAtFlatBodies => "at walls and punch the arms of the torque are the radii: the overlap makes them shorter".into(),
        Form::TorqueSign => "the torque on the second body of a pair has the wrong sign".into(),
        Form::OtherSlip => "the slip velocity is not that of law.contact.slip_velocity".into(),
        Form::SlipNotStretched => "the slip has v2 − v1 as it is: (R1 + R2)/(R1 + R2 − u) times it is right".into(),
        Form::OtherNewContact => {
            "the slip of a new contact is not that of law.contact.new_contact_slip".into()
        }
        Form::SpinUndamped => "spins are not damped: 1 − α·sign acts on them as on velocities".into(),
        Form::SpinsKept => "spins do not change".into(),
        Form::SlipOfCentres => "the slip leaves the spins out".into(),
        Form::NoTorqueOfFlatBodies => "walls and punch do not turn grains".into(),
        Form::Unread(key) => format!("{} is not read: the paper's value takes its place", key.name()),
        Form::OtherClipping => "dashpots pull where they must not, or do not where they may: law.contact.viscosity.tension".into(),
    }
}

fn mean(value: &str) -> String {
    format!("the stiffness of a pair is {value}: k_n = 2·E·R1·R2/(R1 + R2)")
}
