//! Why constants are not what was asked for: explanations that are held against all readings at once.
//!
//! An explanation changes what native shows in some readings. It may be told only where every reading that it changes is shown so, and
//! where each constant that such a reading depends on is right or explained too.

use std::cell::RefCell;
use std::collections::HashMap;
use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use super::asked::{Kind, Meeting, Quantity};
use super::{Row, TOLERANCE};
use crate::checks::Outcome;
use crate::document::table::rounded;
use grains::constant::Constant;
use grains::model::{Law, Solid};
use grains::rules::{Choice, Rules};
use grains::scene::Viscosity;
use grains::task::Case;
use grains::variant::{Form, Variant, run};
use verdict::forms::{candidates, other_rules};

/// How near to a whole or half number a power must be to be told.
const POWER: f64 = 0.02;
/// So many explanations of a reading are told that nothing tells apart.
const TOLD: usize = 3;
/// What constants are multiplied by where somebody halves, doubles or takes a root.
const FACTORS: [(f64, &str); 6] = [
    (0.0, "0"),
    (0.5, "1/2"),
    (FRAC_1_SQRT_2, "1/√2"),
    (SQRT_2, "√2"),
    (2.0, "2"),
    (4.0, "4"),
];
/// By these it shows on which constants a reading depends: 0 reaches what is limited otherwise.
const VARIED: [f64; 2] = [0.0, 2.0];

/// E*, G* and R* of Hertz's and Mindlin's springs of two bodies.
type Effective = [f64; 3];

/// Formulas that are taken for the model's.
#[derive(Clone, Copy)]
enum Formula {
    Hertz(&'static str, fn([Solid; 2], [f64; 2]) -> Effective),
    /// The stiffness of linear springs of those of two bodies.
    Linear(&'static str, fn([f64; 2]) -> f64),
    /// The mass in the dashpots of two bodies.
    Mass(&'static str, fn([f64; 2]) -> f64),
    /// The damping ratio of a restitution.
    Ratio(&'static str, fn(f64) -> f64),
    /// Dashpots of a restitution or a ratio, over what they are to be.
    Dashpot(&'static str, f64),
    /// The radius in the limit of rolling.
    Limit(&'static str, fn([f64; 2]) -> f64),
}

fn in_series([one, two]: [f64; 2]) -> f64 {
    one * two / (one + two)
}

fn effective(
    solids: [Solid; 2],
    radii: [f64; 2],
    normal: fn(f64) -> f64,
    tangential: fn(f64) -> f64,
) -> Effective {
    let whole = solids.map(|solid| solid.modulus / normal(solid.poissons_ratio));
    let shear = solids.map(|solid| solid.modulus / tangential(solid.poissons_ratio));
    [in_series(whole), in_series(shear), in_series(radii)]
}

/// 1 − ν², and E over 1/G* of one body: 2(1 + ν)(2 − ν).
fn right(solids: [Solid; 2], radii: [f64; 2]) -> Effective {
    effective(solids, radii, |nu| 1.0 - nu * nu, of_shear)
}

fn of_shear(nu: f64) -> f64 {
    2.0 * (1.0 + nu) * (2.0 - nu)
}

fn with_modulus(solids: [Solid; 2], radii: [f64; 2], normal: fn(f64) -> f64) -> Effective {
    effective(solids, radii, normal, of_shear)
}

fn with_shear(solids: [Solid; 2], radii: [f64; 2], tangential: fn(f64) -> f64) -> Effective {
    effective(solids, radii, |nu| 1.0 - nu * nu, tangential)
}

fn with_radius(solids: [Solid; 2], radii: [f64; 2], radius: f64) -> Effective {
    let [whole, shear, _] = right(solids, radii);
    [whole, shear, radius]
}

const FORMULAS: [Formula; 26] = [
    Formula::Hertz("1/E* = 1/E₁ + 1/E₂, without ν", |s, r| {
        with_modulus(s, r, |_| 1.0)
    }),
    Formula::Hertz("1/E* of (1 − ν)/E", |s, r| {
        with_modulus(s, r, |nu| 1.0 - nu)
    }),
    Formula::Hertz(
        "E* = (E₁/(1 − ν₁²) + E₂/(1 − ν₂²))/4",
        |s, r| {
            let [one, two] = s.map(|solid| with_modulus([solid; 2], r, |nu| 1.0 - nu * nu)[0]);
            let [_, shear, radius] = right(s, r);
            [0.5 * (one + two), shear, radius]
        },
    ),
    Formula::Hertz("G = E/(2(1 − ν))", |s, r| {
        with_shear(s, r, |nu| 2.0 * (1.0 - nu) * (2.0 - nu))
    }),
    Formula::Hertz("1/G* = 1/G₁ + 1/G₂", |s, r| {
        with_shear(s, r, |nu| 2.0 * (1.0 + nu))
    }),
    Formula::Hertz("1/G* of (1 − ν)/G", |s, r| {
        with_shear(s, r, |nu| 2.0 * (1.0 + nu) * (1.0 - nu))
    }),
    Formula::Hertz("1/G* of (1 + ν)(2 − ν)/E", |s, r| {
        with_shear(s, r, |nu| (1.0 + nu) * (2.0 - nu))
    }),
    Formula::Hertz("1/G* of 4(1 + ν)(2 − ν)/E", |s, r| {
        with_shear(s, r, |nu| 4.0 * (1.0 + nu) * (2.0 - nu))
    }),
    Formula::Hertz("R* = 2 R₁R₂/(R₁ + R₂)", |s, r| {
        with_radius(s, r, 2.0 * in_series(r))
    }),
    Formula::Hertz("R* = (R₁ + R₂)/2", |s, r| {
        with_radius(s, r, 0.5 * (r[0] + r[1]))
    }),
    Formula::Hertz("R* = min(R₁, R₂)", |s, r| {
        with_radius(s, r, r[0].min(r[1]))
    }),
    Formula::Linear("k = (k₁ + k₂)/2", |[a, b]| 0.5 * (a + b)),
    Formula::Linear("k = k₁k₂/(k₁ + k₂)", in_series),
    Formula::Mass("m₁ + m₂", |[a, b]| a + b),
    Formula::Mass("(m₁ + m₂)/2", |[a, b]| 0.5 * (a + b)),
    Formula::Mass("m₁", |[a, _]| a),
    Formula::Mass("m₂", |[_, b]| b),
    Formula::Dashpot("β√(m k) without the 2", 0.5),
    Formula::Dashpot("4β√(m k)", 2.0),
    Formula::Ratio("−ln e/π", |e| -e.ln() / PI),
    Formula::Ratio("−ln e/√(π² + ln² e)", |e| -e.ln() / PI.hypot(e.ln())),
    Formula::Ratio("1 − e", |e| 1.0 - e),
    Formula::Limit("R₁R₂/(R₁ + R₂)", in_series),
    Formula::Limit("R₁ + R₂", |[a, b]| a + b),
    Formula::Limit("R₁", |[a, _]| a),
    Formula::Limit("R₂", |[_, b]| b),
];

impl Formula {
    fn name(self) -> String {
        match self {
            Formula::Hertz(name, _) | Formula::Linear(name, _) => name.to_owned(),
            Formula::Mass(name, _) => format!("the mass in the dashpots {name}"),
            Formula::Ratio(name, _) => format!("the damping ratio {name}"),
            Formula::Dashpot(name, _) => format!("dashpots of {name}"),
            Formula::Limit(name, _) => format!("the radius in the limit of rolling {name}"),
        }
    }

    /// What k_n, k_s, the pull of adhesion, c_n, c_s and η are multiplied by.
    fn factors(self, meeting: Meeting, law: &Law) -> Option<[f64; 6]> {
        let (solids, radii) = (meeting.solids(law), meeting.radii());
        let is_hertz = meeting.kind == Kind::Hertz;
        let of_ratio = !matches!(
            law.contact.viscosity,
            Viscosity::None | Viscosity::Dashpot { .. }
        );
        match self {
            Formula::Hertz(_, formula) if is_hertz => {
                let [whole, shear, radius] = right(solids, radii);
                let [whole, shear, radius] = {
                    let [other, along, r] = formula(solids, radii);
                    [other / whole, along / shear, r / radius]
                };
                let root = radius.sqrt();
                Some([whole * root, shear * root, radius, 1.0, 1.0, 1.0])
            }
            Formula::Linear(_, formula) if !is_hertz => {
                let over = |factors: [f64; 2]| formula(factors) / (2.0 * in_series(factors));
                let [one, two] = [0, 1].map(|at| solids[at].modulus * radii[at]);
                let [c, d] = [
                    one * solids[0].stiffness_ratio,
                    two * solids[1].stiffness_ratio,
                ];
                Some([over([one, two]), over([c, d]), 1.0, 1.0, 1.0, 1.0])
            }
            Formula::Mass(_, formula) if of_ratio => {
                // What is flat may count as a grain of the same mass.
                let mut masses = [meeting.last().mass; 2];
                if meeting.place.is_pair() {
                    masses[0] = meeting.first().mass;
                }
                let root = (formula(masses) / meeting.mass()).sqrt();
                Some([1.0, 1.0, 1.0, root, root, 1.0])
            }
            Formula::Dashpot(_, factor) if of_ratio => Some([1.0, 1.0, 1.0, factor, factor, 1.0]),
            Formula::Ratio(_, formula) => {
                let Viscosity::Restitution { e_n, .. } = law.contact.viscosity else {
                    return None;
                };
                let ratio = |e: f64, is: f64| if is == 0.0 { 1.0 } else { formula(e) / is };
                let [normal, along] = law.damping_ratios();
                let e_s = law.contact.tangential_viscosity.unwrap_or(e_n);
                Some([1.0, 1.0, 1.0, ratio(e_n, normal), ratio(e_s, along), 1.0])
            }
            Formula::Limit(_, formula) if law.contact.rolling.is_some() => {
                let radius = formula(radii) / (0.5 * (radii[0] + radii[1]));
                Some([1.0, 1.0, 1.0, 1.0, 1.0, radius])
            }
            _ => None,
        }
    }
}

/// Pairs of what a key of the law chooses.
fn exchanged() -> impl Iterator<Item = Otherwise> {
    let of_law = |choice: &Choice| choice.rule().alternatives[0].key == "as_model";
    let of_law = move || {
        Choice::all()
            .filter(of_law)
            .filter(|choice| !choice.is_models())
    };
    of_law().flat_map(move |one| {
        let others =
            of_law().filter(move |other| one < *other && one.rule().key == other.rule().key);
        others.map(move |other| Otherwise::Exchanged(one, other))
    })
}

/// What an engine may have otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Otherwise {
    Form(Form),
    /// Two values of a key of the law, each where the other is asked for.
    Exchanged(Choice, Choice),
    /// By a factor with a name, or as it is read.
    Times(Constant, f64, &'static str),
    /// One of the formulas, by its place among them.
    Formula(usize),
}

impl Otherwise {
    /// All that makes a difference in this case, with constants by this factor too.
    pub fn all(case: &Case, read: Option<f64>) -> Vec<Otherwise> {
        let rules = other_rules(case).map(Form::Rule);
        let others = candidates(case).into_iter();
        let others = others.filter(|form| !matches!(form, Form::Rule(_)));
        let forms = rules.chain(others).map(Otherwise::Form);
        let angle = case.model.law.friction_angle;
        let of_angle = [
            (angle.tan().tan() / angle.tan(), "tan tan φ / tan φ"),
            (angle / angle.tan(), "φ / tan φ"),
        ];
        let alone = Constant::faults().filter(|constant| constant.symbol().is_empty());
        let constants = Constant::all().chain(alone);
        let times = constants
            .filter(|constant| constant.is_in(case))
            .flat_map(|constant| {
                let of_angle = of_angle
                    .into_iter()
                    .filter(move |_| constant.symbol() == "tan φ");
                let all = FACTORS.into_iter().chain(of_angle);
                let all = all.chain(read.map(|factor| (factor, "")));
                all.map(move |(factor, name)| Otherwise::Times(constant, factor, name))
            });
        let formulas = (0..FORMULAS.len()).map(Otherwise::Formula);
        forms
            .chain(exchanged())
            .chain(formulas)
            .chain(times)
            .collect()
    }

    fn name(self) -> String {
        match self {
            Otherwise::Form(Form::Rule(choice)) => choice.name(),
            Otherwise::Exchanged(one, other) => {
                format!("{} and {} exchanged", one.name(), other.alternative().key)
            }
            Otherwise::Form(form) => format!("a law where {}", form.in_words()),
            Otherwise::Formula(which) => FORMULAS[which].name(),
            Otherwise::Times(constant, factor, "") => {
                format!("{} × {}", constant.name(), rounded(factor, 5))
            }
            // The model limits nothing then.
            Otherwise::Times(constant, 0.0, _) if constant.symbol() == "η" => {
                "no limit of rolling".to_owned()
            }
            Otherwise::Times(constant, _, name) => format!("{} × {name}", constant.name()),
        }
    }

    /// Whether its number was read, and not thought of before.
    fn is_fitted(self) -> bool {
        matches!(self, Otherwise::Times(.., ""))
    }

    fn has_symbol(self) -> bool {
        matches!(self, Otherwise::Times(constant, ..) if !constant.symbol().is_empty())
    }

    /// Constants that it multiplies, and by what.
    fn factors(self, quantity: &Quantity) -> Vec<(Constant, f64)> {
        match self {
            Otherwise::Form(_) | Otherwise::Exchanged(..) => Vec::new(),
            Otherwise::Times(constant, factor, _) => vec![(constant, factor)],
            Otherwise::Formula(which) => {
                let law = &quantity.case.model.law;
                let meeting = quantity.about.meeting;
                let factors = meeting.and_then(|meeting| FORMULAS[which].factors(meeting, law));
                let names = [
                    "stiffness",
                    "shear-stiffness",
                    "adhesion",
                    "c_n",
                    "tangential-dashpot",
                    "rolling-limit",
                ];
                let constants = names.map(|name| {
                    let mut all = Constant::faults().chain(Constant::all());
                    all.find(|constant| constant.to_string() == name)
                        .expect("these are names of faults or constants")
                });
                let factors = factors.into_iter().flatten();
                constants.into_iter().zip(factors).collect()
            }
        }
    }
}

/// Where an engine has it so.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scope {
    kind: Option<Kind>,
    /// At pairs, or at what is flat.
    is_pair: Option<bool>,
    place: Option<&'static str>,
}

impl Scope {
    /// All that hold at a reading, wide ones first; at a single place a constant alone may be otherwise.
    fn around(row: &Row, one: Otherwise) -> Vec<Scope> {
        let about = &row.about;
        let is_pair = about.meeting.map(|meeting| meeting.place.is_pair());
        let scope = |kind: bool, is_pair: Option<bool>, place: bool| Scope {
            kind: kind.then_some(about.kind),
            is_pair,
            place: place.then_some(about.place),
        };
        let mut all = vec![scope(false, None, false)];
        // An engine has one time step.
        if matches!(one, Otherwise::Times(constant, ..) if constant.symbol() == "Δt") {
            return all;
        }
        all.extend(is_pair.map(|_| scope(false, is_pair, false)));
        all.push(scope(true, None, false));
        all.extend(is_pair.map(|_| scope(true, is_pair, false)));
        let at_places = is_pair.is_some() && matches!(one, Otherwise::Times(..));
        all.extend(at_places.then(|| scope(true, is_pair, true)));
        all
    }

    fn has(&self, row: &Row) -> bool {
        let is_pair = row.about.meeting.map(|meeting| meeting.place.is_pair());
        self.kind.is_none_or(|kind| kind == row.about.kind)
            && (self.is_pair.is_none() || self.is_pair == is_pair)
            && self.place.is_none_or(|place| place == row.about.place)
    }

    fn is_wide(&self) -> bool {
        self.kind.is_none() && self.is_pair.is_none()
    }
}

/// Something that is otherwise somewhere.
type Cause = (Otherwise, Scope);

/// Causes that nothing tells apart, of which the first is computed with, and the readings that they explain.
struct Entry {
    causes: Vec<Cause>,
    explained: Vec<usize>,
}

/// What native shows in each reading, with causes.
struct Readings<'a> {
    all: Vec<(&'a Quantity, &'a Row)>,
    under: Variant,
    declared: Rules,
    known: RefCell<HashMap<(usize, String), f64>>,
}

impl Readings<'_> {
    fn with(&self, causes: &[Cause], at: usize) -> f64 {
        let (quantity, row) = self.all[at];
        let here = causes.iter().filter(|(_, scope)| scope.has(row));
        let here: Vec<Otherwise> = here.map(|(one, _)| *one).collect();
        let mut variant = self.under.clone();
        let mut factors: Vec<(Constant, f64)> = Vec::new();
        for one in &here {
            if let Otherwise::Form(form) = one {
                variant.forms.push(*form);
            }
            if let Otherwise::Exchanged(one, other) = one {
                let rules = quantity.case.model.law.resolved(self.declared);
                let taken = [(one, other), (other, one)];
                let taken = taken.into_iter().find(|(asked, _)| asked.is_in(&rules));
                variant
                    .forms
                    .extend(taken.map(|(_, taken)| Form::Rule(*taken)));
            }
            for (constant, factor) in one.factors(quantity) {
                match factors.iter_mut().find(|(other, _)| *other == constant) {
                    Some((_, so_far)) => *so_far *= factor,
                    None => factors.push((constant, factor)),
                }
            }
        }
        for (constant, factor) in factors.into_iter().filter(|(_, factor)| *factor != 1.0) {
            variant = variant.and(constant, factor - 1.0);
        }
        let key = (at, format!("{variant:?}"));
        if let Some(value) = self.known.borrow().get(&key) {
            return *value;
        }
        let value = (quantity.read)(&run(&quantity.case, &variant));
        self.known.borrow_mut().insert(key, value);
        value
    }

    fn is(&self, at: usize, value: f64) -> bool {
        self.all[at].1.is(value)
    }

    fn changes(&self, at: usize, one: f64, other: f64) -> bool {
        let near = (one - other).abs() <= TOLERANCE * self.all[at].1.right.abs();
        let neither = one.is_nan() && other.is_nan();
        !(near || neither)
    }

    /// The wrong readings that a cause explains beside others, and how many it changes to what is not shown either; none where it
    /// makes a right one wrong.
    fn explained(&self, beside: &[Cause], cause: Cause) -> Option<(Vec<usize>, usize)> {
        let mut both = beside.to_vec();
        both.push(cause);
        let (mut explained, mut open) = (Vec::new(), 0);
        for at in (0..self.all.len()).filter(|at| cause.1.has(self.all[*at].1)) {
            let (before, after) = (self.with(beside, at), self.with(&both, at));
            if self.changes(at, before, after) {
                match (self.is(at, before), self.is(at, after)) {
                    (true, false) => return None,
                    (false, false) => open += 1,
                    (false, true) => explained.push(at),
                    (true, true) => {}
                }
            }
        }
        Some((explained, open))
    }

    /// Whether every reading that a cause changes is shown as it is with all causes.
    fn holds(&self, all: &[Cause], cause: Cause) -> bool {
        let without: Vec<Cause> = all
            .iter()
            .filter(|other| **other != cause)
            .copied()
            .collect();
        (0..self.all.len()).all(|at| {
            let (before, after) = (self.with(&without, at), self.with(all, at));
            !self.changes(at, before, after) || self.is(at, after)
        })
    }

    /// The causes that explain most of what is not explained yet; those that leave something open need others beside them.
    fn most(&self, beside: &[Cause], may_be_open: bool) -> Option<Entry> {
        let mut tried: Vec<Cause> = Vec::new();
        let mut fit: Vec<(Cause, Vec<usize>)> = Vec::new();
        let left = (0..self.all.len()).filter(|at| !self.is(*at, self.with(beside, *at)));
        for at in left {
            let (quantity, row) = self.all[at];
            let mut case = quantity.case.clone();
            case.model.rules = self.declared;
            let read = row.times() * row.right / self.with(beside, at);
            let is_number = read.is_finite()
                && FACTORS
                    .iter()
                    .all(|(other, _)| (other - read).abs() > 2.0 * TOLERANCE);
            let mut candidates = Otherwise::all(&case, is_number.then_some(read));
            // What explains readings of walls may be that of other flat bodies.
            for ((one, _), _) in &fit {
                if !candidates.contains(one) {
                    candidates.push(*one);
                }
            }
            for one in candidates {
                let mut both = beside.to_vec();
                let scopes = Scope::around(row, one);
                both.push((one, scopes[0]));
                if fit
                    .iter()
                    .any(|((other, _), explained)| *other == one && explained.contains(&at))
                    || !self.is(at, self.with(&both, at))
                {
                    continue;
                }
                for scope in scopes {
                    if tried.contains(&(one, scope)) {
                        continue;
                    }
                    tried.push((one, scope));
                    let Some((explained, open)) = self.explained(beside, (one, scope)) else {
                        continue;
                    };
                    if open > 0 && !(may_be_open && open < explained.len()) {
                        continue;
                    }
                    // A number that is read, or one law or place that is picked, is told by a second reading.
                    let is_free = one.is_fitted() || !scope.is_wide();
                    if explained.len() > usize::from(is_free) {
                        fit.push(((one, scope), explained));
                    }
                    break;
                }
            }
        }
        let most = fit.iter().map(|(_, explained)| explained.len()).max()?;
        let (_, explained) = fit
            .iter()
            .find(|(_, explained)| explained.len() == most)?
            .clone();
        let same = fit.iter().filter(|(_, other)| *other == explained);
        let mut causes: Vec<Cause> = same.map(|(cause, _)| *cause).collect();
        if causes.iter().any(|(one, _)| !one.is_fitted()) {
            causes.retain(|(one, _)| !one.is_fitted());
        }
        // One value that does it is said before two that are exchanged.
        let is_rule = |one: &Otherwise| matches!(one, Otherwise::Form(Form::Rule(_)));
        if causes.iter().any(|(one, _)| is_rule(one)) {
            causes.retain(|(one, _)| !matches!(one, Otherwise::Exchanged(..)));
        }
        // Of a constant that was read more than once the first number stands for all.
        let mut read: Vec<Constant> = Vec::new();
        causes.retain(|(one, _)| match one {
            Otherwise::Times(constant, _, "") => {
                let is_first = !read.contains(constant);
                read.push(*constant);
                is_first
            }
            _ => true,
        });
        // A constant of everything is said where no other one does the same.
        if causes.iter().any(|(one, _)| one.has_symbol()) {
            causes.retain(|(one, _)| one.has_symbol() || !matches!(one, Otherwise::Times(..)));
        }
        Some(Entry { causes, explained })
    }

    /// The constants on which a reading depends.
    fn depends_on(&self, at: usize) -> Vec<Constant> {
        let scope = Scope {
            kind: None,
            is_pair: None,
            place: None,
        };
        let plain = self.with(&[], at);
        let matters = |constant: &Constant| {
            let with = |factor| self.with(&[(Otherwise::Times(*constant, factor, ""), scope)], at);
            VARIED
                .into_iter()
                .any(|factor| self.changes(at, plain, with(factor)))
        };
        Constant::all().filter(matters).collect()
    }

    /// Whether what is read depends on something that is wrong and has no cause: another reading at the same place that depends on
    /// nothing else.
    fn is_in_doubt(&self, at: usize, unexplained: &[usize], is_power: bool) -> bool {
        let row = self.all[at].1;
        let mut own = None;
        unexplained.iter().any(|other| {
            let same = &self.all[*other].1.about;
            if (same.kind, same.place) != (row.about.kind, row.about.place) {
                return false;
            }
            let own = own.get_or_insert_with(|| self.depends_on(at));
            let others = self.depends_on(*other);
            // A power says nothing of what depends on all the same constants.
            let is_less = !is_power || others.len() < own.len();
            is_less && others.iter().all(|constant| own.contains(constant))
        })
    }

    /// Whether the same constant is wrong elsewhere by the same factor, and that has no cause.
    fn is_elsewhere(&self, entry: &Entry, unexplained: &[usize]) -> bool {
        entry.explained.iter().any(|at| {
            let row = self.all[*at].1;
            unexplained.iter().any(|other| {
                let other = self.all[*other].1;
                let same = other.about.kind == row.about.kind && other.constant() == row.constant();
                same && (other.times() - row.times()).abs() <= 10.0 * TOLERANCE * row.times().abs()
            })
        })
    }
}

/// Tells in each wrong row what explains it.
pub fn tell_causes(all: &[Quantity], rows: &mut [Row], declared: Rules, under: Variant) {
    let shown: Vec<usize> = (0..rows.len())
        .filter(|at| rows[*at].shown.is_some())
        .collect();
    let readings = Readings {
        all: shown.iter().map(|at| (&all[*at], &rows[*at])).collect(),
        under,
        declared,
        known: RefCell::default(),
    };
    let wrong = |at: &usize| readings.all[*at].1.outcome == Outcome::Fail;
    let mut entries: Vec<Entry> = Vec::new();
    let first =
        |entries: &[Entry]| -> Vec<Cause> { entries.iter().map(|entry| entry.causes[0]).collect() };
    let next = |beside: &[Cause]| {
        let sure = readings.most(beside, false);
        sure.or_else(|| readings.most(beside, true))
    };
    while let Some(entry) = next(&first(&entries)) {
        entries.push(entry);
    }
    // What has been left open is to be explained now.
    let fails = |entries: &[Entry]| {
        let all = first(entries);
        all.iter().rposition(|cause| !readings.holds(&all, *cause))
    };
    while let Some(at) = fails(&entries) {
        entries.remove(at);
    }
    // What is in doubt has no cause, and puts others in doubt.
    let (unexplained, doubted) = loop {
        let beside = first(&entries);
        let has_none = |at: &usize| wrong(at) && !readings.is(*at, readings.with(&beside, *at));
        let mut unexplained: Vec<usize> = (0..readings.all.len()).filter(has_none).collect();
        let mut doubted: Vec<usize> = Vec::new();
        loop {
            let more = (0..readings.all.len()).filter(wrong);
            let more = more.filter(|at| !unexplained.contains(at));
            let more = more.filter(|at| readings.is_in_doubt(*at, &unexplained, false));
            let more: Vec<usize> = more.collect();
            if more.is_empty() {
                break;
            }
            doubted.extend(&more);
            unexplained.extend(more);
        }
        let kept = |entry: &Entry| {
            let has_one = entry.explained.iter().any(|at| !unexplained.contains(at));
            has_one && !readings.is_elsewhere(entry, &unexplained)
        };
        let count = entries.len();
        entries.retain(kept);
        if entries.len() == count {
            break (unexplained, doubted);
        }
    };
    let mut told: Vec<(usize, String)> = Vec::new();
    let beside = first(&entries);
    for at in (0..readings.all.len()).filter(wrong) {
        if unexplained.contains(&at) || doubted.contains(&at) {
            continue;
        }
        let is_needed = |entry: &&Entry| {
            let without = beside.iter().filter(|cause| **cause != entry.causes[0]);
            let without: Vec<Cause> = without.copied().collect();
            !readings.is(at, readings.with(&without, at))
        };
        let mut needed: Vec<String> = entries.iter().filter(is_needed).map(Entry::name).collect();
        // Of causes that each suffice none is needed.
        if needed.is_empty() {
            let own = entries.iter().filter(|entry| entry.explained.contains(&at));
            needed = own.map(Entry::name).collect();
        }
        if !needed.is_empty() {
            told.push((shown[at], format!("as with {}", needed.join(" and "))));
        }
    }
    let powers = powers(&readings, &unexplained);
    told.extend(powers.into_iter().map(|(at, why)| (shown[at], why)));
    for (at, why) in told {
        rows[at].why = why;
    }
}

impl Entry {
    fn name(&self) -> String {
        let mut names: Vec<String> = Vec::new();
        for (one, _) in &self.causes {
            if !names.contains(&one.name()) {
                names.push(one.name());
            }
        }
        let more = names.len().saturating_sub(TOLD);
        names.truncate(TOLD);
        if more > 0 {
            names.push(format!("{more} more that no reading tells apart"));
        }
        names.join(", or ")
    }
}

/// Where no cause is known: the power of speed, spin or overlap by which wrong rows and their twins of another one differ, at all places
/// where this constant is wrong.
fn powers(readings: &Readings<'_>, unexplained: &[usize]) -> Vec<(usize, String)> {
    let power = |at: usize| {
        let row = readings.all[at].1;
        let (what, rate) = row.about.rate?;
        let mut twins = readings.all.iter().filter_map(|(_, other)| {
            let same = (other.about.kind, other.about.place) == (row.about.kind, row.about.place);
            let (number, other_rate) = other.about.rate.filter(|_| same)?;
            let same = other.constant() == row.constant();
            let power = (row.times() / other.times()).ln() / (rate / other_rate).ln();
            (same && number == what && other_rate != rate).then_some(power)
        });
        let power = twins.next_back()?;
        let whole = 0.5 * (2.0 * power).round();
        let is_whole = (power - whole).abs() < POWER && whole != 0.0;
        // A constant that is nothing has no power.
        (is_whole && row.times().abs() > TOLERANCE).then_some((what, whole))
    };
    let mut told = Vec::new();
    for at in unexplained {
        let row = readings.all[*at].1;
        let Some((what, whole)) = power(*at) else {
            continue;
        };
        let is_same =
            |other: &Row| (other.about.kind, other.constant()) == (row.about.kind, row.constant());
        let [same, others]: [Vec<usize>; 2] = [true, false].map(|same| {
            let all = unexplained.iter().copied();
            all.filter(|other| is_same(readings.all[*other].1) == same)
                .collect()
        });
        let mut of_rates = same
            .iter()
            .filter(|other| readings.all[**other].1.about.rate.is_some());
        let everywhere = of_rates.all(|other| power(*other) == Some((what, whole)));
        if everywhere && !readings.is_in_doubt(*at, &others, true) {
            let power = rounded(whole, 2);
            told.push((
                *at,
                format!("as if multiplied by the {what} to the power {power}"),
            ));
        }
    }
    told
}

#[cfg(test)]
mod tests {
    use super::super::asked::quantities;
    use super::super::card_of;
    use super::*;
    use crate::engine::Engine;
    use grains::native;

    /// What is told of an engine with these constants multiplied.
    fn told(factors: &[(&str, f64)]) -> Vec<(String, String)> {
        let engine = native::Options::default().describe().expect("described");
        let all = quantities(&engine);
        let variant = factors
            .iter()
            .fold(Variant::default(), |variant, (symbol, factor)| {
                let constant = Constant::with_symbol(symbol).expect("a constant");
                variant.and(constant, factor - 1.0)
            });
        let answers = all.iter().map(|quantity| Ok(run(&quantity.case, &variant)));
        let rows = card_of(&all, answers, Rules::default());
        let wrong = rows.into_iter().filter(|row| row.outcome == Outcome::Fail);
        wrong.map(|row| (row.about.key.clone(), row.why)).collect()
    }

    #[test]
    fn a_cause_that_is_told_is_the_one_that_was_made() {
        for (symbol, factor) in [
            ("k_s", 0.5),
            ("c_n", FRAC_1_SQRT_2),
            ("c_s", FRAC_1_SQRT_2),
            ("bending stiffness", 0.01),
            ("γ", 0.81),
            ("tan φ", 1.1),
        ] {
            let told = told(&[(symbol, factor)]);
            assert!(!told.is_empty(), "{symbol}");
            for (key, why) in told {
                assert!(why.contains(symbol), "{symbol} × {factor}: {key}: {why}");
            }
        }
    }

    #[test]
    fn each_of_two_causes_is_told() {
        let told = told(&[("c_n", 0.5), ("tan φ", 0.8)]);
        for symbol in ["c_n", "tan φ"] {
            assert!(told.iter().any(|(_, why)| why.contains(symbol)), "{symbol}");
        }
        for (key, why) in told {
            let one = ["c_n", "tan φ"].iter().any(|symbol| why.contains(symbol));
            assert!(one || !why.starts_with("as "), "{key}: {why}");
        }
    }
}
