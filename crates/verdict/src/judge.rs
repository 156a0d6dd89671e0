//! The verdict on an engine's first steps: how coarsely it computes, whether it stays among the replicas, which faults would have
//! been seen, and what is wrong if it does not.

use std::collections::{BTreeSet, HashSet};
use std::sync::OnceLock;

use evidence::in_parallel;
use grains::model::Wall;
use grains::native::NativeError;
use grains::tables::Snapshot;
use grains::task::Case;
use grains::variant::{self, Constant, Form, Variant};
use serde::Serialize;

use crate::Engine;
use crate::constants::{Fit, Fitted, Observed, Search, until};
use crate::envelope::{Envelope, Farthest, Resolution};
use crate::forms;
use crate::starts::{Bed, LawKind, Start};

/// What an engine is, compared with the native one; the first that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every bit is the same.
    Identical,
    /// It parts from the native engine as runs do that are the same but for rounding.
    EqualToRounding,
    /// Its packings have the same distribution, within margins set before.
    EqualInDistribution,
    /// It is another engine.
    Different,
    /// Evidence is missing.
    Undecided,
}

impl Verdict {
    pub fn in_words(self) -> &'static str {
        match self {
            Verdict::Identical => "identical",
            Verdict::EqualToRounding => "equal to rounding",
            Verdict::EqualInDistribution => "equal in distribution",
            Verdict::Different => "different",
            Verdict::Undecided => "undecided",
        }
    }
}

/// One start under one law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfStart {
    pub law: LawKind,
    pub start: Start,
    pub verdict: Verdict,
    pub skipped: Option<String>,
    pub farthest: Option<Farthest>,
}

/// A state that the engine was not asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotAsked {
    pub law: LawKind,
    pub start: Start,
    /// What the engine says it has not.
    pub lacking: String,
}

/// The smallest fault in a constant that would have been seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limit {
    pub constant: &'static str,
    pub smallest: f64,
    pub law: LawKind,
    pub start: Start,
}

/// What is wrong, as far as it was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Under this law it was found.
    pub law: LawKind,
    /// The native engine with these constants and forms comes nearest.
    #[serde(skip)]
    pub variant: Variant,
    pub constants: Vec<Fitted>,
    /// Constants that the engine's first steps do not tell from the others; they were taken as given.
    #[serde(serialize_with = "symbols")]
    pub tied: Vec<Constant>,
    #[serde(serialize_with = "in_words")]
    pub forms: Vec<Form>,
    /// Other forms that explain it as well.
    #[serde(serialize_with = "in_words")]
    pub also: Vec<Form>,
    /// With them the engine stays among the replicas for its first ten steps and the one with which it left them.
    pub explained: bool,
    /// Grains that are farther off than rounding takes them, at the first moment at which there are any, though the constants
    /// and forms are taken into account.
    pub left: Vec<usize>,
    pub left_in: Start,
    /// The state, as it is handed to engines.
    #[serde(skip)]
    pub state: Option<Snapshot>,
    #[serde(skip)]
    pub walls: Vec<Wall>,
}

fn in_words<S: serde::Serializer>(of: &[Form], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(of.iter().map(|form| forms::in_words(*form)))
}

fn symbols<S: serde::Serializer>(of: &[Constant], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(of.iter().map(|of| of.symbol()))
}

impl Cause {
    /// In a sentence: what the engine is, and where to look.
    pub fn sentence(&self) -> String {
        let mut with: Vec<String> = Vec::new();
        let mut look_at: Vec<&str> = Vec::new();
        let is_of_springs = |of: &&Fitted| {
            use Constant::{GrainStiffness, PunchStiffness, WallStiffness};
            [GrainStiffness, WallStiffness, PunchStiffness].contains(&of.constant)
        };
        let of_springs: Vec<&Fitted> = self.constants.iter().filter(is_of_springs).collect();
        let one_factor = of_springs.len() > 1
            && of_springs[0].constant == Constant::GrainStiffness
            && of_springs.iter().all(|of| {
                let apart = (of.larger - of_springs[0].larger).abs();
                apart <= 6.0 * (of.error + of_springs[0].error) + 1.0e-12
            });
        for of in &self.constants {
            let joint = one_factor && is_of_springs(&of);
            if joint && of.constant != of_springs[0].constant {
                continue;
            }
            let symbol = if joint { "k_n" } else { of.constant.symbol() };
            let (larger, error) = (of.larger, of.error);
            with.push(match of.constant {
                Constant::GravityAcross => format!("g_x = {larger:.3e}·|g| ± {error:.0e}"),
                Constant::WallPlace(_) => format!("{symbol} off by {larger:.3e} R ± {error:.0e}"),
                _ => {
                    let error = error.max(f64::EPSILON);
                    format!("{symbol} × {:.12} ± {error:.0e}", 1.0 + larger)
                }
            });
            let place = look_at_for(of.constant);
            if !look_at.contains(&place) {
                look_at.push(place);
            }
        }
        let mut said = String::new();
        if !with.is_empty() {
            let is = if self.explained {
                "equal to rounding"
            } else {
                "nearest"
            };
            let (with, look_at) = (with.join(", "), look_at.join(", "));
            said = format!("{is} with {with}; look at {look_at}");
        }
        for form in &self.forms {
            let joint = if said.is_empty() { "" } else { ". And " };
            said = format!("{said}{joint}{}", forms::in_words(*form));
        }
        for form in &self.also {
            said = format!("{said}. Or: {}", forms::in_words(*form));
        }
        if said.is_empty() {
            said =
                "no constant and no form of a term that this program knows explains it".to_owned();
        }
        if !self.explained {
            let some: Vec<String> = self.left.iter().take(8).map(usize::to_string).collect();
            let (of_grains, state) = (some.join(", "), self.left_in.name());
            said = match self.left.len() {
                0 => format!("{said}. That is not all: it parts from this later, in {state}"),
                1..=3 => format!(
                    "{said}. In {state} it sits on grain {of_grains} alone: look at its mass, its radius and its contacts"
                ),
                count => format!(
                    "{said}. That is not all: in {state} {count} grains are still farther off than rounding takes them \
                     ({of_grains}{})",
                    if count > 8 { ", …" } else { "" }
                ),
            };
        }
        let tied: Vec<&str> = self.tied.iter().map(|of| of.symbol()).collect();
        if !tied.is_empty() {
            let tied = tied.join(", ");
            let why = "from the other constants: taken as given";
            said = format!("{said}. Its first steps do not tell {tied} {why}");
        }
        format!("{said}.")
    }
}

fn look_at_for(constant: Constant) -> &'static str {
    match constant {
        Constant::GrainStiffness => "k_n = 2·E·R1·R2/(R1 + R2) (Eq. 4)",
        Constant::WallStiffness => "k_n at walls: a wall counts as a grain of the same radius",
        Constant::PunchStiffness => "k_n at the punch: it counts as a grain of the same radius",
        Constant::ShearStiffness => "k_s = law.stiffness_ratio · k_n",
        Constant::Friction => "the limit |N| tan φ (Eq. 5)",
        Constant::Dashpot => "law.contact.viscosity",
        Constant::Damping => "model.alpha",
        Constant::GravityAcross | Constant::GravityUp => "model.gravity",
        Constant::TimeStep => "model.dt",
        Constant::Mass => "the masses in initial.csv",
        Constant::Inertia => "the moments of inertia in initial.csv",
        Constant::Radius => "the radii in initial.csv",
        Constant::WallPlace(_) => "model.walls",
        Constant::PunchSpeed => "punch.velocity, and when the punch moves: before the forces",
    }
}

/// All that was found about an engine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    pub grains: usize,
    /// How coarsely the engine computes; that of double precision where it was not measured.
    pub resolution: Resolution,
    /// Every state under every law that the engine says it has.
    pub starts: Vec<OfStart>,
    /// What it says it has not, which counts neither way.
    pub not_asked: Vec<NotAsked>,
    /// What would have been seen, the smallest first.
    pub limits: Vec<Limit>,
    /// For each law that shows something else than the ones before.
    pub causes: Vec<Cause>,
}

impl Judgement {
    /// Of all states: different if one is, undecided if one was not looked at.
    pub fn verdict(&self) -> Verdict {
        let has = |verdict| self.starts.iter().any(|of| of.verdict == verdict);
        let order = [
            Verdict::Different,
            Verdict::Undecided,
            Verdict::EqualToRounding,
            Verdict::Identical,
        ];
        let found = order.into_iter().find(|of| has(*of));
        found.unwrap_or(Verdict::Undecided)
    }

    pub fn farthest(&self) -> Option<&OfStart> {
        let looked_at = self.starts.iter().filter(|of| of.farthest.is_some());
        looked_at.max_by(|a, b| ratio(&a.farthest).total_cmp(&ratio(&b.farthest)))
    }
}

fn ratio(of: &Option<Farthest>) -> f64 {
    of.as_ref().map_or(0.0, |of| of.ratio)
}

/// A cause is held against the first so many steps, or more where the engine parts from the native one later.
const EXPLAINED_UNTIL: u64 = 10;
/// So many of the best forms are fitted in full.
const TRIED: usize = 3;
/// Under one law at most so many terms are looked for in another form at once.
const MOST_FORMS: usize = 3;

/// The native engine's side of a judgement: made once, for any number of engines.
#[derive(Debug, Clone)]
pub struct Reference {
    states: Vec<State>,
}

/// A start under a law.
#[derive(Debug, Clone)]
struct State {
    law: LawKind,
    start: Start,
    case: Case,
    /// For engines in double precision, made when the first engine has answered the case.
    double: OnceLock<Native>,
}

/// What is known of one case.
#[derive(Debug, Clone)]
struct Native {
    envelope: Envelope,
    limits: Vec<(Constant, f64)>,
}

/// A state with what is known of it and what an engine made of it.
struct Answered<'a> {
    asked: &'a State,
    native: Native,
    theirs: Vec<Snapshot>,
    /// None where it wrote other moments than were asked for.
    farthest: Option<Farthest>,
}

impl Answered<'_> {
    fn is_rounding(&self) -> bool {
        self.farthest.as_ref().is_some_and(Farthest::is_rounding)
    }

    fn verdict(&self) -> Verdict {
        // By their bits: == takes −0 for 0.
        let same = |(a, b): (&Snapshot, &Snapshot)| a.digest() == b.digest();
        match self.theirs.iter().zip(&self.native.envelope.own).all(same) {
            _ if self.farthest.is_none() => Verdict::Different,
            true => Verdict::Identical,
            false if self.is_rounding() => Verdict::EqualToRounding,
            false => Verdict::Different,
        }
    }
}

impl Native {
    fn new(case: &Case, resolution: Resolution) -> Result<Self, NativeError> {
        let envelope = Envelope::new(case, resolution.noise())?;
        let all = in_parallel(Constant::all().len(), |at| {
            envelope.detection_limit(Constant::all()[at])
        });
        let mut limits = Vec::new();
        for (constant, limit) in Constant::all().into_iter().zip(all) {
            limits.extend(limit?.map(|limit| (constant, limit)));
        }
        Ok(Native { envelope, limits })
    }
}

impl Reference {
    /// Of a bed of so many grains whose radii differ by this share from their mean; `progress` hears what is under way.
    pub fn new(
        grains: u32,
        dispersion: f64,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, NativeError> {
        progress("pouring a bed");
        let bed = Bed::new(grains, dispersion)?;
        let states = LawKind::ALL.into_iter().flat_map(|law| {
            let of = bed.cases(law).into_iter();
            of.map(move |(start, case)| State {
                law,
                start,
                case,
                double: OnceLock::new(),
            })
        });
        Ok(Reference {
            states: states.collect(),
        })
    }

    /// Judges an engine; `lacks` says what it has not that a case asks for, and such a case is not handed to it.
    pub fn judge<E: From<NativeError>>(
        &self,
        lacks: &dyn Fn(&Case) -> Option<String>,
        engine: &mut Engine<'_, E>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Judgement, E> {
        let (mut states, mut not_asked) = (Vec::new(), Vec::new());
        for of in &self.states {
            match lacks(&of.case) {
                Some(lacking) => not_asked.push(NotAsked {
                    law: of.law,
                    start: of.start,
                    lacking,
                }),
                None => states.push(of),
            }
        }
        // The punch is large, so that numbers that are small differences of its own are coarser there.
        let is_probed = |of: &&State| {
            of.law == LawKind::Springs && [Start::Pouring, Start::UnderPunch].contains(&of.start)
        };
        let cases: Vec<&Case> = states.iter().map(|of| &of.case).collect();
        let probed = states.iter().copied().filter(is_probed);
        let probed: Vec<&Case> = probed.map(|of| &of.case).collect();
        let probes: Vec<Vec<Case>> = probed.iter().map(|case| Resolution::cases(case)).collect();
        progress("the engine runs");
        let asked: Vec<&Case> = probes.iter().flatten().chain(cases).collect();
        let mut of_cases = engine(&asked)?;
        let mut judgement = Judgement {
            grains: states.first().map_or(0, |of| of.case.bodies.len()),
            resolution: Resolution::DOUBLE,
            starts: Vec::new(),
            not_asked,
            limits: Vec::new(),
            causes: Vec::new(),
        };
        let mut resolution = Resolution::DOUBLE;
        for (case, probes) in probed.iter().zip(&probes) {
            let rest = of_cases.split_off(probes.len().min(of_cases.len()));
            let answers = std::mem::replace(&mut of_cases, rest);
            let measured = Resolution::measured(case, &answers);
            resolution = measured.map_or(resolution, |of| resolution.coarser(of));
        }
        let mut all = Vec::with_capacity(states.len());
        for (of, answer) in states.into_iter().zip(of_cases) {
            let mut judged = OfStart {
                law: of.law,
                start: of.start,
                verdict: Verdict::Undecided,
                skipped: None,
                farthest: None,
            };
            match answer {
                // Nothing need be known of it.
                Err(reason) => judged.skipped = Some(reason),
                Ok(theirs) => {
                    progress(&format!("replicas: {}", of.case.name));
                    let is_double = resolution == Resolution::DOUBLE;
                    let native = match of.double.get() {
                        Some(native) if is_double => native.clone(),
                        _ => Native::new(&of.case, resolution)?,
                    };
                    if is_double {
                        of.double.get_or_init(|| native.clone());
                    }
                    let answered = Answered {
                        asked: of,
                        farthest: native.envelope.farthest(&theirs),
                        native,
                        theirs,
                    };
                    judged.verdict = answered.verdict();
                    judged.farthest = answered.farthest.clone();
                    let why = "it wrote other moments than were asked for";
                    judged.skipped = judged.farthest.is_none().then(|| why.to_owned());
                    all.push(answered);
                }
            }
            judgement.starts.push(judged);
        }
        judgement.limits = limits(&all);
        judgement.resolution = resolution;
        if judgement.verdict() == Verdict::Different {
            judgement.causes = causes(&all, resolution, progress);
        }
        Ok(judgement)
    }
}

/// For each constant the smallest fault that any of the states that were looked at shows.
fn limits(all: &[Answered]) -> Vec<Limit> {
    let mut limits: Vec<Limit> = Vec::new();
    for answered in all.iter().filter(|of| of.farthest.is_some()) {
        let limit = |(constant, smallest): &(Constant, f64)| Limit {
            constant: constant.symbol(),
            smallest: *smallest,
            law: answered.asked.law,
            start: answered.asked.start,
        };
        limits.extend(answered.native.limits.iter().map(limit));
    }
    // The first of several that are as small.
    limits.sort_by(|a, b| a.smallest.total_cmp(&b.smallest));
    let mut seen = BTreeSet::new();
    limits.retain(|of| seen.insert(of.constant));
    limits
}

/// Law by law: the constants and forms of one are taken for known under the next.
fn causes(all: &[Answered], resolution: Resolution, progress: &mut dyn FnMut(&str)) -> Vec<Cause> {
    let mut causes: Vec<Cause> = Vec::new();
    let mut known = Variant::default();
    let mut fitted: Vec<Constant> = Vec::new();
    let mut judged: Vec<Form> = Vec::new();
    for law in LawKind::ALL {
        let ruled_out = judged.clone();
        let of_law = all.iter().filter(|of| of.asked.law == law);
        let of_law: Vec<&Answered> = of_law.collect();
        if of_law.is_empty() {
            continue;
        }
        progress(&format!("what is wrong: {}", law.name()));
        let farthest = of_law.iter().filter_map(|of| of.farthest.as_ref());
        let left_after = farthest.filter_map(|of| of.left_after);
        let until = left_after.min().unwrap_or(0).max(EXPLAINED_UNTIL);
        let cases = of_law.iter().map(|answered| &answered.asked.case);
        judged.extend(cases.flat_map(forms::candidates));
        let tried = Tried {
            of_law,
            resolution,
            until,
            ruled_out: &ruled_out,
        };
        if tried.is_explained(&known) {
            continue;
        }
        let cause = tried.search(&known, &fitted, MOST_FORMS - 1);
        let before = std::mem::replace(&mut known, cause.variant.clone());
        fitted.extend(tried.free(&fitted));
        // A length that is not quite met leaves a few grains in every law: that was said.
        let new = !cause.constants.is_empty() || !same_kinds(&cause.forms, &before.forms);
        if new || causes.is_empty() {
            causes.push(cause);
        }
    }
    causes
}

fn same_kinds(a: &[Form], b: &[Form]) -> bool {
    let kinds = |of: &[Form]| -> HashSet<_> { of.iter().map(std::mem::discriminant).collect() };
    kinds(a) == kinds(b)
}

struct Tried<'a> {
    of_law: Vec<&'a Answered<'a>>,
    resolution: Resolution,
    /// The step that first steps go to.
    until: u64,
    /// Forms that would have shown under a law before.
    ruled_out: &'a [Form],
}

impl Tried<'_> {
    /// The first steps with this variant, and the answer cut to them.
    fn first_steps<'a>(
        &self,
        of: &'a Answered<'_>,
        variant: &Variant,
    ) -> (Vec<Snapshot>, &'a [Snapshot]) {
        let case = until(&of.asked.case, self.until);
        let count = case.moments.len().min(of.theirs.len());
        (variant::run(&case, variant), &of.theirs[..count])
    }

    fn farthest(&self, variant: &Variant) -> Vec<Option<Farthest>> {
        in_parallel(self.of_law.len(), |at| {
            let of = self.of_law[at];
            let (own, theirs) = self.first_steps(of, variant);
            of.native.envelope.farthest_from(&own, theirs)
        })
    }

    fn is_explained(&self, variant: &Variant) -> bool {
        let mut farthest = self.farthest(variant).into_iter();
        farthest.all(|of| of.is_some_and(|of| of.is_rounding()))
    }

    /// The constants that play a part under this law and did not under those before.
    fn free(&self, fitted: &[Constant]) -> Vec<Constant> {
        let plays_a_part = |constant: &Constant| {
            let mut of_law = self.of_law.iter();
            of_law.any(|answered| constant.is_in(&answered.asked.case))
                && !fitted.contains(constant)
        };
        Constant::all().into_iter().filter(plays_a_part).collect()
    }

    /// `more` forms may be taken besides the best one, if all together explain the law.
    fn search(&self, known: &Variant, fitted: &[Constant], more: usize) -> Cause {
        // States in which nothing differs have nothing to say.
        let differing = self.of_law.iter().filter(|of| !of.is_rounding());
        let observed = differing.map(|of| (&of.asked.case, &of.theirs[..]));
        let observed: Vec<Observed<'_>> = observed.collect();
        let free = self.free(fitted);
        let search = Search::new(&observed, self.resolution, self.until);
        let full = search.fit(known, &free);
        let constants_alone = search.pruned(known, &full);
        if self.is_explained(&constants_alone.variant) {
            return self.cause(constants_alone, true, Vec::new());
        }
        let mut forms: Vec<Form> = Vec::new();
        let candidates = observed.iter().map(|(case, _)| forms::candidates(case));
        for form in candidates.flatten() {
            let taken = [self.ruled_out, &known.forms, &forms];
            if !taken.iter().any(|of| of.contains(&form)) {
                forms.push(form);
            }
        }
        let with = |form: Form| {
            let mut variant = known.clone();
            variant.forms.push(form);
            variant
        };
        if self.ruled_out.is_empty() {
            forms.extend(search.lost_contacts(known));
        }
        let misfits = in_parallel(forms.len(), |at| {
            search.misfit(&search.refit(&with(forms[at]), &full))
        });
        let mut order: Vec<usize> = (0..forms.len()).collect();
        order.sort_by(|a, b| misfits[*a].total_cmp(&misfits[*b]));
        let mut best: Option<(Fit, f64, Form)> = None;
        let mut explaining: Vec<(Fit, Form)> = Vec::new();
        for at in order.into_iter().take(TRIED) {
            let with = with(forms[at]);
            let fit = search.pruned(&with, &search.fit(&with, &free));
            if self.is_explained(&fit.variant) {
                explaining.push((fit, forms[at]));
            } else {
                let misfit = search.misfit(&fit.variant);
                if best.as_ref().is_none_or(|(_, of, _)| misfit < *of) {
                    best = Some((fit, misfit, forms[at]));
                }
            }
        }
        if !explaining.is_empty() {
            // Of several the one that needs the fewest constants besides.
            explaining.sort_by_key(|(fit, _)| fit.wrong().len());
            let also = explaining[1..].iter().map(|(_, form)| *form).collect();
            return self.cause(explaining.swap_remove(0).0, true, also);
        }
        let alone = search.misfit(&constants_alone.variant);
        match best {
            Some((fit, misfit, form)) if misfit < 0.5 * alone => {
                let with_more = (more > 0).then(|| self.search(&with(form), fitted, more - 1));
                let explained = with_more.filter(|of| of.explained);
                explained.unwrap_or_else(|| self.cause(fit, false, Vec::new()))
            }
            _ => self.cause(constants_alone, false, Vec::new()),
        }
    }

    fn cause(&self, fit: Fit, explained: bool, also: Vec<Form>) -> Cause {
        let farthest = self.farthest(&fit.variant);
        let worst = (0..farthest.len())
            .max_by(|a, b| ratio(&farthest[*a]).total_cmp(&ratio(&farthest[*b])));
        let of = self.of_law[worst.unwrap_or(0)];
        let left = if explained {
            Vec::new()
        } else {
            let (own, theirs) = self.first_steps(of, &fit.variant);
            let outside = of.native.envelope.outside(&own, theirs);
            around_one(outside, own.iter().chain(theirs))
        };
        Cause {
            law: of.asked.law,
            constants: fit.wrong(),
            tied: fit.tied,
            forms: fit.variant.forms.clone(),
            variant: fit.variant,
            explained,
            also,
            left,
            left_in: of.asked.start,
            state: of.native.envelope.own.first().cloned(),
            walls: of.asked.case.model.walls.clone(),
        }
    }
}

/// Of grains that are one and those that it touches that one alone: what is wrong with it moves them. Where it may be more
/// than one of them, all.
fn around_one<'a>(
    left: Vec<usize>,
    runs: impl Iterator<Item = &'a Snapshot> + Clone,
) -> Vec<usize> {
    let touch = |a: usize, b: usize| {
        let mut contacts = runs.clone().flat_map(|of| &of.contacts);
        contacts.any(|of| [(a, b), (b, a)].contains(&(of.id1 as usize, of.id2 as usize)))
    };
    let few = left.len() <= MOST_NEIGHBOURS;
    let is_centre =
        |one: &usize| few && left.iter().all(|other| other == one || touch(*one, *other));
    let centres: Vec<usize> = left.iter().copied().filter(is_centre).collect();
    match centres[..] {
        [one] => vec![one],
        _ => left,
    }
}

/// A disc and those that can touch it.
const MOST_NEIGHBOURS: usize = 7;
