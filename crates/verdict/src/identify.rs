//! Which rules an engine computes with that declares none: those of the catalogue under which the native engine does what it does.
//!
//! Law by law, springs alone before friction and dashpots: the one other alternative that explains most of what is left is taken,
//! again and again, then the best two at once, for rules that only show together, such as the times to which velocities belong.
//! Where rules explain too little, constants are fitted and the search goes on from there.

use std::collections::BTreeSet;

use evidence::in_parallel;
use grains::constant::Constant;
use grains::native::NativeError;
use grains::rules::{CATALOGUE, Choice, Rule, Rules};
use grains::task::Case;
use grains::variant::{Form, Variant};

use crate::Engine;
use crate::constants::{Observed, Search};
use crate::envelope::Resolution;
use crate::forms::other_rules;
use crate::judge::{Judgement, Reference};
use crate::starts::LARGE_STATE;

/// The steps that are to be explained; later ones have what rounding makes of them.
const UNTIL: u64 = 10;
/// What an alternative must explain to be taken, as [`Search::unexplained`] counts it: a grain whose numbers are all off.
const GAIN: f64 = 50.0;
/// Less is enough where it leaves next to nothing, as a rule of the punch does in a bed that touches it once: a number that is a
/// hundred times as far off as rounding takes it.
const LAST_GAIN: f64 = 5.0;
/// The share that next to nothing is.
const LEFT: f64 = 0.1;
/// Rules, then constants and rules again.
const ROUNDS: usize = 2;

/// What was found.
#[derive(Debug, Clone)]
pub struct Identified {
    pub rules: Rules,
    /// Alternatives that explain its steps as well as those that were found.
    pub also: Vec<Choice>,
    /// Rules that make no difference in any state that it has the parts for.
    pub unasked: Vec<&'static str>,
    /// By these rules; constants that are wrong besides are among its causes.
    pub judgement: Judgement,
}

impl Reference {
    /// Asks an engine and finds its rules; `forms` are terms that it says it has otherwise, and `lacks` is as in
    /// [`judge`](Reference::judge).
    pub fn identify<E: From<NativeError>>(
        &self,
        forms: &[Form],
        lacks: &dyn Fn(&Case) -> Option<String>,
        engine: &mut Engine<'_, E>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Identified, E> {
        let answers = self.ask(lacks, engine, progress)?;
        let answered = answers.states.iter().zip(&answers.of_states);
        let observed = answered.filter_map(|((_, state), answer)| {
            let theirs = answer.as_ref().ok()?;
            let is_usual = !state.drawn && state.key != LARGE_STATE;
            let tells = is_usual && state.case.is_answered_by(theirs);
            tells.then_some((state.law.as_str(), (&state.case, &theirs[..])))
        });
        let observed: Vec<(&str, Observed<'_>)> = observed.collect();
        let mut laws: Vec<&str> = observed.iter().map(|(law, _)| *law).collect();
        laws.dedup();
        let mut found = Variant {
            forms: forms.to_vec(),
            ..Variant::default()
        };
        let mut rules = Rules::default();
        for law in laws {
            progress(&format!("which rules: {law}"));
            let of_law = observed.iter().filter(|(other, _)| *other == law);
            let of_law: Vec<Observed<'_>> = of_law.map(|(_, observed)| *observed).collect();
            Steps::new(&of_law, answers.resolution).explain(&mut rules, &mut found, 2);
        }
        let all: Vec<Observed<'_>> = observed.iter().map(|(_, observed)| *observed).collect();
        let steps = Steps::new(&all, answers.resolution);
        progress("which rules: all laws");
        steps.explain(&mut rules, &mut found, 1);
        let least = steps.unexplained(&rules, &found);
        for choice in rules.unusual() {
            let mut without = rules;
            choice.rule().unset(&mut without);
            if steps.unexplained(&without, &found) <= least {
                rules = without;
            }
        }
        let others = steps.others(&rules);
        let left = in_parallel(others.len(), |at| {
            steps.unexplained(&with(&rules, &[others[at]]), &found)
        });
        let also = others.iter().zip(left);
        let also = also
            .filter(|(_, left)| *left <= least)
            .map(|(choice, _)| *choice)
            .collect();
        let is_asked = |rule: &&Rule| others.iter().any(|choice| choice.rule().key == rule.key);
        let unasked = CATALOGUE.iter().filter(|rule| !is_asked(rule));
        let unasked = unasked.map(|rule| rule.key).collect();
        let judgement = self.under(rules).judge_answers(forms, answers, progress)?;
        Ok(Identified {
            rules,
            also,
            unasked,
            judgement,
        })
    }
}

fn with(rules: &Rules, choices: &[Choice]) -> Rules {
    let mut rules = *rules;
    choices.iter().for_each(|choice| choice.set(&mut rules));
    rules
}

/// Whether what is left then is so much less that the rest was explained and not met by chance.
fn explains(least: f64, left: f64) -> bool {
    least - left > GAIN || least - left > LAST_GAIN && left < LEFT * least
}

/// First steps of an engine.
struct Steps<'a> {
    observed: &'a [Observed<'a>],
    search: Search<'a>,
}

impl<'a> Steps<'a> {
    fn new(observed: &'a [Observed<'a>], resolution: Resolution) -> Self {
        let search = Search::new(observed, resolution, UNTIL);
        Steps { observed, search }
    }

    /// Every alternative that makes a difference in one of the cases under these rules.
    fn others(&self, rules: &Rules) -> Vec<Choice> {
        let of_case = |(case, _): &Observed<'_>| {
            let mut case = (*case).clone();
            case.model.rules = *rules;
            other_rules(&case).collect::<Vec<_>>()
        };
        let others: BTreeSet<Choice> = self.observed.iter().flat_map(of_case).collect();
        others.into_iter().collect()
    }

    fn variant(rules: &Rules, found: &Variant) -> Variant {
        let mut variant = found.clone();
        variant.forms.extend(rules.unusual().map(Form::Rule));
        variant
    }

    fn unexplained(&self, rules: &Rules, found: &Variant) -> f64 {
        self.search.unexplained(&Steps::variant(rules, found))
    }

    /// Rules, and constants where rules leave too much.
    fn explain(&self, rules: &mut Rules, found: &mut Variant, most: usize) {
        for round in 0..ROUNDS {
            let least = self.descend(rules, found, most);
            if least < LAST_GAIN || round + 1 == ROUNDS {
                return;
            }
            let known = Steps::variant(rules, found);
            let plays_a_part =
                |constant: &Constant| self.observed.iter().any(|(case, _)| constant.is_in(case));
            let free: Vec<Constant> = Constant::all().filter(plays_a_part).collect();
            let fit = self.search.pruned(&known, &self.search.fit(&known, &free));
            if !explains(least, self.search.unexplained(&fit.variant)) {
                return;
            }
            found.larger = fit.variant.larger;
        }
    }

    /// Takes what explains most, one alternative at a time and up to `most` where no single one does; what is left.
    fn descend(&self, rules: &mut Rules, found: &Variant, most: usize) -> f64 {
        let mut least = self.unexplained(rules, found);
        while least >= LAST_GAIN {
            let others = self.others(rules);
            let single = others.iter().map(|choice| vec![*choice]);
            let pairs = others.iter().enumerate().filter(|_| most > 1);
            let pairs = pairs.flat_map(|(at, one)| {
                let more = others[at + 1..].iter();
                let apart = more.filter(|two| two.rule().key != one.rule().key);
                apart.map(|two| vec![*one, *two])
            });
            let better = [single.collect::<Vec<_>>(), pairs.collect()]
                .into_iter()
                .find_map(|tried| {
                    let left = in_parallel(tried.len(), |at| {
                        self.unexplained(&with(rules, &tried[at]), found)
                    });
                    let best = (0..tried.len()).min_by(|a, b| left[*a].total_cmp(&left[*b]))?;
                    explains(least, left[best]).then(|| (tried[best].clone(), left[best]))
                });
            let Some((taken, left)) = better else { break };
            (*rules, least) = (with(rules, &taken), left);
        }
        least
    }
}
