//! What is wrong with an engine that differs: the constants and forms with which the native engine does what it does, told as a
//! cause where they explain all of it, and else where it differs.

use std::cmp::Reverse;
use std::collections::HashSet;

use evidence::in_parallel;
use grains::constant::{Constant, Counted};
use grains::model::Wall;
use grains::scene::{Springs, Viscosity};
use grains::tables::{Body, Snapshot};
use grains::task::Case;
use grains::variant::{self, Alone, Form, Variant};
use serde::Serialize;
use statrs::function::factorial::ln_binomial;

use crate::constants::{Fit, Fitted, Observed, Search, situations, until};
use crate::envelope::{Farthest, Resolution};
use crate::judge::Answered;
use crate::starts::MOMENTS;
use crate::{conditions, contacts, exercise, forms};

/// A cause is held against the first so many steps, or more where the engine parts from the native one later.
const EXPLAINED_UNTIL: u64 = 10;
/// So many of the best forms are fitted in full.
const TRIED: usize = 3;
/// Under one law at most so many terms are looked for in another form at once.
const MOST_FORMS: usize = 3;

/// What is wrong, as far as it was found.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Cause {
    /// Under this law it was found.
    pub law: String,
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
    /// Springs are Hertz's and Mindlin's.
    #[serde(skip)]
    pub is_hertz: bool,
    /// Dashpots are made of a restitution.
    #[serde(skip)]
    pub by_restitution: bool,
    /// Constants that were fitted leave little unexplained of what is without them.
    #[serde(skip)]
    pub comes_near: bool,
    /// Laws that are not drawn have these constants, and nothing is off under them.
    pub under_drawn_alone: bool,
    /// With them the engine stays among the replicas for its first ten steps and the one with which it left them.
    pub explained: bool,
    /// Grains that are farther off than rounding takes them, at the first moment at which there are any, though the constants
    /// and forms are taken into account.
    pub left: Vec<usize>,
    pub left_in: String,
    /// What those grains touch.
    pub left_at: String,
    /// What all contacts or grains that are wrong first have and no other ones.
    pub condition: Option<String>,
    /// Terms of its step that are other ones, from what it writes step by step.
    pub terms: Vec<String>,
    /// Where none of them is told: what does not follow from the rest that it writes, and where.
    pub unexplained: Vec<String>,
    /// Which numbers are off first: of contacts, where they are no later than the motion, else of grains.
    pub numbers: Option<String>,
    /// The state, as it is handed to engines.
    #[serde(skip)]
    pub state: Option<Snapshot>,
    #[serde(skip)]
    pub walls: Vec<Wall>,
}

fn in_words<S: serde::Serializer>(forms: &[Form], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(forms.iter().map(|form| form.in_words()))
}

fn symbols<S: serde::Serializer>(constants: &[Constant], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(constants.iter().map(|constant| constant.symbol()))
}

impl Cause {
    /// In a sentence: what the engine is, and where to look.
    pub fn sentence(&self) -> String {
        let mut with: Vec<String> = Vec::new();
        let mut look_at: Vec<&str> = Vec::new();
        let is_of_springs = |fitted: &&Fitted| fitted.constant.symbol().starts_with("k_n ");
        let of_springs: Vec<&Fitted> = self.constants.iter().filter(is_of_springs).collect();
        let one_factor = of_springs.len() > 1
            && of_springs[0].constant.symbol() == "k_n between grains"
            && of_springs.iter().all(|fitted| {
                let apart = (fitted.larger - of_springs[0].larger).abs();
                apart <= 6.0 * (fitted.error + of_springs[0].error) + 1.0e-12
            });
        for fitted in &self.constants {
            let joint = one_factor && is_of_springs(&fitted);
            if joint && fitted.constant != of_springs[0].constant {
                continue;
            }
            let symbol = if joint {
                "k_n"
            } else {
                fitted.constant.symbol()
            };
            let (larger, error) = (fitted.larger, fitted.error);
            with.push(match fitted.constant.counted() {
                Counted::Gravity => format!("{symbol} off by {larger:.3e}·|g| ± {error:.0e}"),
                Counted::Radius => format!("{symbol} off by {larger:.3e} R ± {error:.0e}"),
                Counted::Factor => {
                    let error = error.max(f64::EPSILON);
                    format!("{symbol} × {:.12} ± {error:.0e}", 1.0 + larger)
                }
            });
            let place = match symbol {
                "k_s" if self.is_hertz => {
                    "k_s = 8·G*·√(R*·u), with 1/G* = (2 − ν1)/G1 + (2 − ν2)/G2 and G = E/(2(1 + ν))"
                }
                "k_n" | "k_n between grains" if self.is_hertz => {
                    "F_n = 4/3·E*·√R*·u^1.5, with 1/E* = (1 − ν1²)/E1 + (1 − ν2²)/E2"
                }
                "c_n" | "c_s" if self.by_restitution => {
                    "the formula that makes a dashpot of the restitution (law.contact.viscosity)"
                }
                _ => fitted.constant.place(),
            };
            if !look_at.contains(&place) {
                look_at.push(place);
            }
        }
        let forms = self.forms.iter().map(|form| form.in_words());
        let forms = forms.collect::<Vec<_>>().join(". And ");
        if !self.explained {
            return self.what_is_left(&forms);
        }
        let (with, look_at) = (with.join(", "), look_at.join(", "));
        let mut said = match with.is_empty() {
            true => forms,
            false => {
                let and = if forms.is_empty() { "" } else { ". And " };
                format!("equal to rounding with {with}; look at {look_at}{and}{forms}")
            }
        };
        if self.under_drawn_alone {
            said = format!(
                "{said}; so under {}, while nothing is off under the usual laws, which have this too",
                self.law
            );
        }
        for form in &self.also {
            said = format!("{said}. Or: {}", form.in_words());
        }
        let place = self.variant.alone.place();
        if !place.is_empty() {
            said = format!("{place} alone: {said}");
        }
        let tied: Vec<&str> = self.tied.iter().map(|constant| constant.symbol()).collect();
        if !tied.is_empty() {
            let tied = tied.join(", ");
            let why = "from the other constants: taken as given";
            said = format!("{said}. Its first steps do not tell {tied} {why}");
        }
        format!("{said}.")
    }

    /// Whether it says what is wrong.
    pub fn is_named(&self) -> bool {
        self.explained || !self.terms.is_empty()
    }

    /// Where it differs, and behind it the nearest fit as a hint, without digits that it does not have.
    fn what_is_left(&self, forms: &str) -> String {
        if !self.terms.is_empty() {
            let terms = self.terms.join("; in ");
            let place = self.condition.as_ref();
            let place = place.map_or(String::new(), |words| {
                format!(" In {} {words}.", self.left_in)
            });
            return format!(
                "what it writes at each step does not follow from the rest in {terms}.{place}"
            );
        }
        let some: Vec<String> = self.left.iter().take(8).map(usize::to_string).collect();
        let (of_grains, state, at) = (some.join(", "), &self.left_in, &self.left_at);
        let more = if self.left.len() > 8 { ", …" } else { "" };
        let numbers = self.numbers.as_deref();
        let left = match (&self.condition, self.left.len()) {
            (Some(condition), _) => {
                let numbers = numbers.map_or(String::new(), |said| format!("; {said}"));
                format!("in {state} {condition}{numbers}")
            }
            (None, 1) => format!(
                "in {state} it sits on grain {of_grains} alone: look at its contacts, its mass and its radius{}",
                numbers.map_or(String::new(), |said| format!("; {said}"))
            ),
            (None, _) if let Some(said) = numbers => format!("in {state} {said}"),
            (None, 0) => format!("it parts from the model in {state}"),
            (None, count) => format!(
                "in {state} {count} grains are farther off than rounding takes them ({of_grains}{more}): {at}"
            ),
        };
        let hint = |fitted: &Fitted| {
            let way = if fitted.larger < 0.0 {
                "smaller"
            } else {
                "larger"
            };
            let (symbol, by) = (fitted.constant.symbol(), fitted.larger.abs());
            format!("{symbol} {way} by about {by:.0e}")
        };
        let near = self.constants.iter().filter(|_| self.comes_near);
        let possible = near.filter(|fitted| is_possible(fitted));
        let mut hints: Vec<String> = possible.map(hint).collect();
        hints.extend((!forms.is_empty() && self.comes_near).then(|| forms.to_owned()));
        if !self.unexplained.is_empty() {
            let follows = "What it writes at each step does not follow from the rest in";
            return format!("{left}. {follows} {}.", self.unexplained.join("; and in "));
        }
        match hints.is_empty() {
            true => format!(
                "{left}. No constant and no form of a term that this program knows explains it."
            ),
            false => format!(
                "{left}. Nearest, though it does not explain it: {}.",
                hints.join(", ")
            ),
        }
    }
}

/// Whether an engine may have this constant so much larger.
fn is_possible(fitted: &Fitted) -> bool {
    fitted.larger.abs() <= LARGEST_HINT
}

/// By so much a constant is changed to see whether contacts at one place make anything of it.
const PROBE: f64 = 1.0e-3;

/// What leaves more than this share of how far off an engine is says nothing of it.
const NEAR: f64 = 0.1;

/// Ten times as large is a unit that was mistaken, and more is a fit of another fault.
const LARGEST_HINT: f64 = 10.0;

fn of_motion(farthest: &Option<Farthest>) -> f64 {
    farthest.as_ref().map_or(0.0, |far| far.of_motion)
}

/// Law by law: the constants and forms of one are taken for known under the next. What the engine declares is tried before
/// anything else: all of it, then each.
pub(crate) fn causes(
    all: &[Answered],
    resolution: Resolution,
    declared: &[Form],
    progress: &mut dyn FnMut(&str),
) -> Vec<Cause> {
    let mut causes: Vec<Cause> = Vec::new();
    let mut known = Variant::default();
    let mut fitted: Vec<Constant> = Vec::new();
    let mut judged: Vec<Form> = Vec::new();
    let mut laws: Vec<&str> = all
        .iter()
        .map(|answered| answered.asked.law.as_str())
        .collect();
    laws.dedup();
    for law in laws {
        let ruled_out = judged.clone();
        let of_law = all.iter().filter(|answered| answered.asked.law == law);
        let of_law: Vec<&Answered> = of_law.collect();
        progress(&format!("what is wrong: {law}"));
        let farthest = of_law
            .iter()
            .filter_map(|answered| answered.farthest.as_ref());
        let left_after = farthest.filter_map(|far| far.left_after);
        let until = left_after.min().unwrap_or(0).max(EXPLAINED_UNTIL);
        let cases = of_law.iter().map(|answered| &answered.asked.case);
        judged.extend(cases.flat_map(forms::candidates));
        let mut tried = Tried {
            of_law,
            resolution,
            until,
            ruled_out: &ruled_out,
        };
        // A force that is another one from a moment on moves grains by the next.
        let parts = tried.of_law.iter().any(|answered| !answered.moves_right());
        let mut later = MOMENTS.into_iter().filter(|step| parts && *step > until);
        let is_open = loop {
            match tried.is_explained(&known).then(|| later.next()) {
                None => break true,
                Some(Some(next)) => tried.until = next,
                Some(None) => break false,
            }
        };
        if !is_open {
            continue;
        }
        let mut told = [declared].into_iter().chain(declared.chunks(1));
        let told = told.find_map(|forms| {
            let mut variant = known.clone();
            variant
                .forms
                .extend(forms.iter().filter(|form| !known.has(**form)));
            let explains = variant != known && tried.is_explained(&variant);
            explains.then(|| tried.cause(Fit::known(variant), true, Vec::new()))
        });
        let mut cause = told.unwrap_or_else(|| tried.search(&known, &fitted, MOST_FORMS - 1));
        if !cause.explained && known == Variant::default() {
            cause = tried.at_one_place().unwrap_or(cause);
        }
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
    let kinds =
        |forms: &[Form]| -> HashSet<_> { forms.iter().map(std::mem::discriminant).collect() };
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
        answered: &'a Answered<'_>,
        variant: &Variant,
    ) -> (Vec<Snapshot>, &'a [Snapshot]) {
        let case = until(&answered.asked.case, self.until);
        let count = case.moments.len().min(answered.theirs.len());
        (variant::run(&case, variant), &answered.theirs[..count])
    }

    fn farthest(&self, variant: &Variant) -> Vec<Option<Farthest>> {
        in_parallel(self.of_law.len(), |at| self.farthest_in(at, variant))
    }

    fn farthest_in(&self, at: usize, variant: &Variant) -> Option<Farthest> {
        let answered = self.of_law[at];
        let (own, theirs) = self.first_steps(answered, variant);
        answered.native.envelope.farthest_from(&own, theirs)
    }

    /// Of the many that explain nothing most are through after one state.
    fn is_explained(&self, variant: &Variant) -> bool {
        let moves_right = |far: Farthest| far.moves_right();
        (0..self.of_law.len()).all(|at| self.farthest_in(at, variant).is_some_and(moves_right))
    }

    /// The constants that play a part under this law and did not under those before.
    fn free(&self, fitted: &[Constant]) -> Vec<Constant> {
        let plays_a_part = |constant: &Constant| {
            let mut of_law = self.of_law.iter();
            of_law.any(|answered| constant.is_in(&answered.asked.case))
                && !fitted.contains(constant)
        };
        Constant::all().filter(plays_a_part).collect()
    }

    /// What differs: states in which nothing does have nothing to say.
    fn observed(&self) -> Vec<Observed<'_>> {
        let differing = self
            .of_law
            .iter()
            .filter(|answered| !answered.moves_right());
        let observed = differing.map(|answered| (&answered.asked.case, &answered.theirs[..]));
        observed.collect()
    }

    /// What explains all if contacts at one place alone have it.
    fn at_one_place(&self) -> Option<Cause> {
        let observed = self.observed();
        let search = Search::new(&observed, self.resolution, self.until);
        let mut forms: Vec<Form> = Vec::new();
        for form in observed
            .iter()
            .flat_map(|(case, _)| forms::candidates(case))
        {
            if !forms.contains(&form) {
                forms.push(form);
            }
        }
        let first_steps = |variant: &Variant| {
            let cases = observed.iter().map(|(case, _)| until(case, 1));
            let runs = cases.map(|case| variant::run(&case, variant));
            runs.collect::<Vec<_>>()
        };
        let usual = first_steps(&Variant::default());
        // Where tables are wrong before the motion is, they are so there alone.
        let wrong = self.of_law.iter().flat_map(|answered| {
            let (case, envelope) = (&answered.asked.case, &answered.native.envelope);
            let (own, theirs) = (&envelope.own[..], &answered.theirs[..]);
            let (contacts, step) = envelope.contacts_outside(own, theirs);
            let (grains, moved) = envelope.outside(own, theirs);
            let contacts = contacts
                .into_iter()
                .filter(move |_| grains.is_empty() || step < moved);
            contacts.map(|ids| case.ids().body(ids.0))
        });
        let wrong: Vec<Body> = wrong.collect();
        let mut possible = Alone::ALL.into_iter().filter(|alone| {
            *alone != Alone::Everywhere && wrong.iter().all(|first| alone.is_at(*first))
        });
        possible.find_map(|alone| {
            let there = Variant {
                alone,
                ..Variant::default()
            };
            let does_something = |constant: &Constant| {
                let changed = there.and(*constant, PROBE);
                first_steps(&changed) != usual
            };
            let free: Vec<Constant> = self.free(&[]).into_iter().filter(does_something).collect();
            let all = search.pruned(&there, &search.fit(&there, &free));
            let each = in_parallel(free.len(), |at| search.fit(&there, &free[at..=at]));
            let mut fits = [all].into_iter().chain(each);
            if let Some(fit) = fits.find(|fit| self.is_explained(&fit.variant)) {
                return Some(self.cause(fit, true, Vec::new()));
            }
            let with = |form: Form| Variant {
                forms: vec![form],
                ..there.clone()
            };
            let explain = in_parallel(forms.len(), |at| self.is_explained(&with(forms[at])));
            let mut explaining = forms.iter().zip(explain).filter(|(_, explains)| *explains);
            let (first, _) = explaining.next()?;
            let also = explaining.map(|(form, _)| *form).collect();
            Some(self.cause(Fit::known(with(*first)), true, also))
        })
    }

    /// `more` forms may be taken besides the best one, if all together explain the law.
    fn search(&self, known: &Variant, fitted: &[Constant], more: usize) -> Cause {
        let observed = self.observed();
        let with = |form: Form| {
            let mut variant = known.clone();
            variant.forms.push(form);
            variant
        };
        // A key that is not read explains all by itself, and better than numbers do.
        let mut forms: Vec<Form> = Vec::new();
        let candidates = observed.iter().map(|(case, _)| forms::candidates(case));
        for form in candidates.flatten() {
            let taken = [self.ruled_out, &known.forms, &forms];
            if !taken.iter().any(|list| list.contains(&form)) {
                forms.push(form);
            }
        }
        let mut unread = forms.iter().filter(|form| matches!(form, Form::Unread(_)));
        if let Some(form) = unread.find(|form| self.is_explained(&with(**form))) {
            return self.cause(Fit::known(with(*form)), true, Vec::new());
        }
        // So does another rule, or what one body has taken for both.
        let is_exact = |form: &Form| {
            matches!(
                form,
                Form::Rule(_) | Form::TakenFor(..) | Form::FrictionOf(_)
            )
        };
        let rules: Vec<Form> = forms.iter().copied().filter(is_exact).collect();
        let explain = in_parallel(rules.len(), |at| self.is_explained(&with(rules[at])));
        let mut explaining = rules
            .into_iter()
            .zip(explain)
            .filter(|(_, explains)| *explains);
        if let Some((first, _)) = explaining.next() {
            let also = explaining.map(|(form, _)| form).collect();
            return self.cause(Fit::known(with(first)), true, also);
        }
        let free = self.free(fitted);
        let search = Search::new(&observed, self.resolution, self.until);
        let full = search.fit(known, &free);
        let constants_alone = search.pruned(known, &full);
        if self.is_explained(&constants_alone.variant) {
            return self.cause(constants_alone, true, Vec::new());
        }
        // One alone may be found where all together go astray: a large fault of one makes others' responses meaningless.
        let alone = in_parallel(free.len(), |at| search.fit(known, &free[at..=at]));
        let mut alone = alone.into_iter();
        if let Some(fit) = alone.find(|fit| self.is_explained(&fit.variant)) {
            return self.cause(fit, true, Vec::new());
        }
        if self.ruled_out.is_empty() {
            forms.extend(search.lost_contacts(known));
        }
        // These fit nothing that they do not explain.
        forms.retain(|form| !matches!(form, Form::TakenFor(..) | Form::FrictionOf(_)));
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
                if best.as_ref().is_none_or(|(_, least, _)| misfit < *least) {
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
                let explained = with_more.filter(|cause| cause.explained);
                // What was taken first may do nothing beside what came later.
                let explained = explained.map(|cause| {
                    let mut without = known.clone();
                    let later = cause.variant.forms.iter().copied();
                    without.forms = later.filter(|other| *other != form).collect();
                    let fit = search.pruned(&without, &search.fit(&without, &free));
                    match self.is_explained(&fit.variant) {
                        true => self.cause(fit, true, Vec::new()),
                        false => cause,
                    }
                });
                explained.unwrap_or_else(|| self.cause(fit, false, Vec::new()))
            }
            _ => self.cause(constants_alone, false, Vec::new()),
        }
    }

    /// Whether the motion is much nearer than without anything else.
    fn comes_near(&self, variant: &Variant) -> bool {
        let worst = |variant: &Variant| {
            self.farthest(variant)
                .iter()
                .map(of_motion)
                .fold(0.0, f64::max)
        };
        worst(variant) <= NEAR * worst(&Variant::default())
    }

    /// What is wrong first: contacts where tables are off no later than the motion, else grains; of the states the one where it is seen
    /// first and most, and before all others one where all that is wrong has something in common.
    fn wrong_first(&self, variant: &Variant) -> Option<WrongFirst> {
        let of_state = |answered: &&Answered<'_>| {
            let (own, theirs) = self.first_steps(answered, variant);
            let (envelope, case) = (&answered.native.envelope, &answered.asked.case);
            let (grains, moved) = envelope.outside(&own, theirs);
            let (contacts, step) = envelope.contacts_outside(&own, theirs);
            let at = |step: u64| own.iter().position(|snapshot| snapshot.step == step);
            let mut first = WrongFirst {
                state: answered.asked.start.clone(),
                step: moved,
                count: grains.len(),
                condition: None,
                numbers: None,
                lacks_contacts: false,
            };
            match contacts.is_empty() || !grains.is_empty() && moved < step {
                false => {
                    let at = at(step)?;
                    (first.step, first.count) = (step, contacts.len());
                    let there: HashSet<_> = ids_of(&theirs[at]).collect();
                    let missing = ids_of(&own[at]).filter(|ids| !there.contains(ids));
                    let missing: Vec<(u32, u32)> = missing.collect();
                    let here: HashSet<_> = ids_of(&own[at]).collect();
                    let invented = ids_of(&theirs[at]).filter(|ids| !here.contains(ids));
                    let invented: Vec<(u32, u32)> = invented.collect();
                    first.lacks_contacts = !missing.is_empty();
                    let (run, wrong) = match (first.lacks_contacts, invented.is_empty()) {
                        (true, _) => (&own[..], ("contacts are missing", &missing[..])),
                        (_, false) => (
                            theirs,
                            ("contacts are there that are to be none,", &invented[..]),
                        ),
                        _ => (&own[..], ("contacts are wrong", &contacts[..])),
                    };
                    first.condition =
                        conditions::of_contacts(case, &run[..at], &run[at], wrong, &|_| true);
                    let said = contacts::what_is_off((&theirs[at]).into(), (&own[at]).into());
                    let late = begin_unseen(&own[..=at], &missing);
                    first.numbers = said.map(|said| format!("after {step} steps {said}{late}"));
                }
                true if grains.is_empty() => return None,
                true => {
                    let at = at(moved)?;
                    first.condition = conditions::of_grains(case, &own[at], &grains, &|_| true);
                    let said = conditions::off_in(&theirs[at], &own[at]);
                    first.numbers = said.map(|said| format!("after {moved} steps {said}"));
                }
            }
            Some(first)
        };
        let found = self.of_law.iter().filter_map(of_state);
        found.max_by_key(|first| (first.condition.is_some(), Reverse(first.step), first.count))
    }

    fn cause(&self, fit: Fit, explained: bool, also: Vec<Form>) -> Cause {
        let farthest = self.farthest(&fit.variant);
        let worst = (0..farthest.len())
            .max_by(|a, b| of_motion(&farthest[*a]).total_cmp(&of_motion(&farthest[*b])));
        let answered = self.of_law[worst.unwrap_or(0)];
        let (mut left, mut left_at) = (Vec::new(), String::new());
        let (mut condition, mut numbers, mut lacks_contacts) = (None, None, false);
        let mut left_in = answered.asked.start.clone();
        if !explained {
            // A fit that no engine can have hides what is wrong.
            let usual = Variant::default();
            let variant = match fit.wrong().iter().all(is_possible) {
                true => &fit.variant,
                false => &usual,
            };
            if let Some(first) = self.wrong_first(variant) {
                (condition, numbers) = (first.condition, first.numbers);
                lacks_contacts = first.lacks_contacts;
                if condition.is_some() || numbers.is_some() {
                    left_in = first.state;
                }
            }
            let (own, theirs) = self.first_steps(answered, &fit.variant);
            let (outside, step) = answered.native.envelope.outside(&own, theirs);
            left_at = what_they_touch(&answered.asked.case, &outside, &own, step);
            left = around_one(outside, own.iter().chain(theirs));
            // It is not one grain that is wrong where contacts are missing.
            left.retain(|_| !lacks_contacts);
        }
        Cause {
            law: answered.asked.law.clone(),
            is_hertz: answered.asked.case.model.law.contact.springs == Springs::HertzMindlin,
            by_restitution: matches!(
                answered.asked.case.model.law.contact.viscosity,
                Viscosity::Restitution { .. }
            ),
            comes_near: explained || self.comes_near(&fit.variant),
            constants: fit.wrong(),
            tied: fit.tied,
            forms: fit.variant.forms.clone(),
            variant: fit.variant,
            under_drawn_alone: false,
            explained,
            also,
            left,
            left_in,
            left_at,
            condition,
            numbers,
            state: answered.native.envelope.own.first().cloned(),
            walls: answered.asked.case.model.walls.clone(),
            ..Cause::default()
        }
    }
}

/// What is wrong first in a state.
struct WrongFirst {
    state: String,
    step: u64,
    /// How many contacts or grains.
    count: usize,
    condition: Option<String>,
    numbers: Option<String>,
    /// Some that touch are not in the engine's table.
    lacks_contacts: bool,
}

/// How probable it may be that what is told of contacts is chance.
const CHANCE: f64 = 0.05;

/// That missing contacts are all among the few that have begun since the moment before, as where neighbours are looked for too seldom.
fn begin_unseen(own: &[Snapshot], missing: &[(u32, u32)]) -> String {
    let [.., before, now] = own else {
        return String::new();
    };
    let before_it: HashSet<_> = ids_of(before).collect();
    let begun: HashSet<_> = ids_of(now).filter(|ids| !before_it.contains(ids)).collect();
    // As many of all contacts would be among them by chance so seldom.
    let [of_all, of_begun] = [now.contacts.len(), begun.len()]
        .map(|among| ln_binomial(among as u64, missing.len() as u64));
    match of_begun - of_all < CHANCE.ln()
        && !missing.is_empty()
        && missing.iter().all(|ids| begun.contains(ids))
    {
        false => String::new(),
        true => format!(
            "; what is missing is among the {} that have begun since step {}: contacts that begin are found late, or not at all",
            begun.len(),
            before.step
        ),
    }
}

/// Those of all contacts of a moment.
fn ids_of(moment: &Snapshot) -> impl Iterator<Item = (u32, u32)> {
    let contacts = moment.contacts.iter();
    contacts.map(|contact| (contact.id1, contact.id2))
}

/// How many of these grains touch other grains alone, walls or the punch, and whether contacts of theirs slide.
fn what_they_touch(case: &Case, left: &[usize], own: &[Snapshot], step: u64) -> String {
    let until = own
        .iter()
        .take_while(|snapshot| snapshot.step <= step)
        .count();
    let situations = situations(case, &own[..until]);
    let kinds = [
        "fly",
        "touch grains alone",
        "touch a wall",
        "touch the punch",
    ];
    let found = kinds.iter().enumerate().filter_map(|(kind, what)| {
        let count = left.iter().filter(|id| situations[**id] == kind).count();
        (count > 0).then(|| format!("{count} {what}"))
    });
    let found: Vec<String> = found.collect();
    let slides = exercise::sliding(case, &own[..until]);
    let slides = left.iter().filter(|id| slides.contains(&(**id as u32)));
    let among = slides.count();
    match case.model.law.has_friction() {
        true => format!("{}; contacts of {among} slide", found.join(", ")),
        false => found.join(", "),
    }
}

/// Of grains that are one and those that it touches that one alone: what is wrong with it moves them. Where it may be more
/// than one of them, all.
fn around_one<'a>(
    left: Vec<usize>,
    runs: impl Iterator<Item = &'a Snapshot> + Clone,
) -> Vec<usize> {
    let touch = |a: usize, b: usize| {
        let mut contacts = runs.clone().flat_map(|snapshot| &snapshot.contacts);
        contacts
            .any(|contact| [(a, b), (b, a)].contains(&(contact.id1 as usize, contact.id2 as usize)))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_that_begin_and_are_not_there_are_told_where_that_is_no_chance() {
        let bed = crate::spheres::reference().expect("a bed");
        let mut states = bed.states().iter();
        let state = states.find(|state| state.key == "space-0-at-rest");
        let case = &state.expect("a bed at rest").case;
        let mut now = variant::run(case, &Variant::default()).remove(0);
        let all: Vec<(u32, u32)> = ids_of(&now).collect();
        let mut before = now.clone();
        // A tenth of them begins.
        before.contacts.truncate(all.len() - all.len() / 10);
        now.step = 1;
        let moments = [before, now];
        let late = |missing: &[(u32, u32)]| begin_unseen(&moments, missing);
        let newest = &all[all.len() - 3..];
        assert!(late(newest).contains("found late, or not at all"));
        assert_eq!(late(&newest[..1]), "");
        assert_eq!(late(&[newest[0], newest[1], all[0]]), "");
        assert_eq!(late(&[]), "");
    }
}
