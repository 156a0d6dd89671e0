//! Which few terms, each another number of times or by powers of sizes, explain all that is left over.

use std::collections::BTreeMap;

use grains::tables::Snapshot;
use grains::task::Case;
use grains::vector::{Vector, dot, hypot, minus, plus, times};
use nalgebra::{DMatrix, DVector};

use super::elsewhere;
use super::place::place;
use super::{DASHPOT, KEPT_DASHPOT, Of, PLAIN, ROUNDED, Row, Term};

/// So many rows of a kind are looked at.
const MOST_ROWS: usize = 300;
/// So many terms may be other ones at once.
const MOST_TERMS: usize = 3;
/// So many times what may be rounding is clearly more.
const CLEAR: f64 = 30.0;
/// Of this many rows of a right engine one may be off, by what its contacts remember and do not write.
const FEW_OFF: usize = 20;
/// And a few may be whatever their share is.
const FEWEST_OFF: usize = 3;
/// So many of the best sets of terms are looked at closely.
const TRIED: usize = 12;

/// Terms, and how much more there is of each.
type More = Vec<(usize, f64)>;

impl Row {
    pub(super) fn ratio(&self) -> f64 {
        hypot(self.off) / self.least
    }

    pub(super) fn is_off(&self) -> bool {
        self.ratio() > 1.0 || self.ratio().is_nan()
    }

    /// What is left of it with so much more of some terms.
    fn left(&self, more: &[(usize, f64)]) -> f64 {
        let left = more.iter().fold(self.off, |left, (term, more)| {
            // Contacts that begin have fewer terms.
            let value = self.terms.get(*term).map_or([0.0; 3], |term| term.2);
            minus(left, times(*more, value))
        });
        hypot(left) / self.least
    }
}

/// What explains all rows of a kind, or all that are off, and which those are.
pub(super) struct Explained {
    pub(super) said: String,
    pub(super) place: String,
    /// It is a formula, with no number of its own.
    pub(super) is_plain: bool,
}

impl Explained {
    fn plainly(said: impl Into<String>) -> Self {
        Explained {
            said: said.into(),
            place: String::new(),
            is_plain: true,
        }
    }
}

/// What explains all rows of a kind, or all that are off.
pub(super) fn explained(
    quantity: usize,
    rows: &[Row],
    runs: &[(&Case, &[Snapshot])],
) -> Option<Explained> {
    let none = rows
        .iter()
        .filter(|row| !row.off.iter().all(|part| part.is_finite()))
        .count();
    if none > 0 {
        return Some(Explained::plainly(format!(
            "{none} of {} are no numbers",
            rows.len()
        )));
    }
    let off: Vec<&Row> = rows.iter().filter(|row| row.is_off()).collect();
    if in_single_precision(rows) {
        return Some(Explained::plainly(IN_SINGLE_PRECISION));
    }
    if let Some(said) = coarse(rows) {
        return Some(Explained::plainly(said));
    }
    let plainly = off.iter().filter(|row| row.ratio() > CLEAR).count();
    if plainly == 0 || !off.iter().any(|row| row.ratio() > PLAIN) {
        return None;
    }
    let right = rows.iter().filter(|row| !row.is_off());
    let some = |rows: &[&Row]| -> usize { rows.len().div_ceil(MOST_ROWS).max(1) };
    let right: Vec<&Row> = right.collect();
    let both: Vec<&Row> = off
        .iter()
        .step_by(some(&off))
        .chain(right.iter().step_by(some(&right)))
        .copied()
        .collect();
    let all: Vec<&Row> = rows.iter().collect();
    let some: Vec<&Row> = off.iter().step_by(some(&off)).copied().collect();
    // What a formula has comes first, for all rows and for those that are off.
    let plain = search(&both, &all, plainly, true);
    if let Some((said, _)) = plain {
        return Some(Explained::plainly(said));
    }
    if let Some((said, _)) = elsewhere::explained(quantity, &all) {
        return Some(Explained::plainly(said));
    }
    let has_right = !right.is_empty();
    let of_off = search(&some, &off, plainly, true).filter(|_| has_right);
    let from_elsewhere = || elsewhere::explained(quantity, &off).filter(|_| has_right);
    if of_off.is_none()
        && let Some((said, which)) = from_elsewhere()
    {
        let is_clear = |row: &&Row| {
            let other = row.elsewhere.get(which);
            row.is_off() || other.is_some_and(|other| hypot(*other) > CLEAR * row.least)
        };
        let clear: Vec<&Row> = rows.iter().filter(is_clear).collect();
        let place = format!(" ({})", place(&clear, &off, runs));
        let is_plain = true;
        return Some(Explained {
            said,
            place,
            is_plain,
        });
    }
    if of_off.is_none()
        && let Some((said, _)) = of_terms(&both, &all, plainly)
    {
        let place = String::new();
        let is_plain = false;
        return Some(Explained {
            said,
            place,
            is_plain,
        });
    }
    let is_plain = of_off.is_some();
    let (said, more) = of_off
        .or_else(|| of_terms(&some, &off, plainly))
        .filter(|_| has_right)?;
    // Of what would hardly move a row it is not known whether it has it.
    let is_clear = |row: &&Row| row.is_off() || more.is_empty() || row.left(&more) > CLEAR;
    let clear: Vec<&Row> = rows.iter().filter(is_clear).collect();
    let place = match clear.len() == off.len() {
        true => String::new(),
        false => format!(" ({})", place(&clear, &off, runs)),
    };
    Some(Explained {
        said,
        place,
        is_plain,
    })
}

/// How many and which rows of a kind do not follow from the rest, where no term explains them.
pub(super) fn unexplained(rows: &[Row], runs: &[(&Case, &[Snapshot])]) -> Option<String> {
    let is_plainly = |row: &&Row| row.ratio() > CLEAR || !hypot(row.off).is_finite();
    let known: Vec<&Row> = rows
        .iter()
        .filter(|row| is_plainly(row) || !row.is_off())
        .collect();
    let off: Vec<&Row> = rows.iter().filter(is_plainly).collect();
    if off.len() < FEWEST_OFF
        || FEW_OFF * off.len() <= rows.len()
        || off.iter().all(|row| row.ratio() <= PLAIN)
    {
        return None;
    }
    let is_along = |axis: &usize| {
        let mut others = off.iter().flat_map(|row| {
            let others = [0, 1, 2].into_iter().filter(|at| at != axis);
            others.map(|at| row.off[at].abs() / row.least)
        });
        others.all(|part| part <= CLEAR)
    };
    let axis = [0, 1, 2].into_iter().find(is_along);
    let is_vector = matches!(off.first()?.subject, Of::Grain(_)) && runs[0].0.bodies.in_space();
    let axis = axis.filter(|_| is_vector).map_or("", |axis| {
        [", in x alone", ", in y alone", ", in z alone"][axis]
    });
    Some(match off.len() == known.len() {
        true => format!("all {}{axis}", known.len()),
        false => format!("{}{axis}", place(&known, &off, runs)),
    })
}

const IN_SINGLE_PRECISION: &str =
    "rounded to single precision, off by some 1e-8 of themselves either way";
/// A number of 24 bits is off by at most 6e-8 of itself.
const SINGLE: f64 = 6.0e-8;
/// How near to a number of 24 bits a force is that is made again of what it is off.
const MADE_AGAIN: f64 = 1.0e-12;
/// Fewer rows may be so by chance.
const FEWEST: usize = 12;

/// Whether the forces that are told are numbers of 24 bits, and off by no more than that.
fn in_single_precision(rows: &[Row]) -> bool {
    let off = rows.iter().filter(|row| row.is_off());
    let has_few_bits = |row: &Row| {
        let model = row.terms.iter().fold([0.0; 3], |sum, (_, usual, value)| {
            plus(sum, times(*usual, *value))
        });
        let told = plus(model, row.off);
        let near = |part: f64| (part - f64::from(part as f32)).abs() <= MADE_AGAIN * part.abs();
        told.into_iter().all(near) && hypot(row.off) <= SINGLE * hypot(model)
    };
    off.count() >= FEWEST && rows.iter().all(has_few_bits)
}

/// Of what one term is, rows are off by at most so much, some operations of 24 bits, and half of them by more than so much.
const COARSE: [f64; 2] = [3.0e-7, 3.0e-9];
/// One of both ways has at least this share of them.
const EITHER_WAY: f64 = 0.2;

/// The smallest term that is made in single precision: rows are off either way by some 1e-8 of it, and none by more. What is summed may
/// be larger than the sum.
fn coarse(rows: &[Row]) -> Option<String> {
    let off: Vec<&Row> = rows.iter().filter(|row| row.is_off()).collect();
    if off.len() < FEWEST || 2 * off.len() < rows.len() {
        return None;
    }
    // Half of the rows are off by more than this share of what has this size in each, and none by more than some operations make.
    let half = |size: &dyn Fn(&Row) -> f64| -> Option<f64> {
        let share = |row: &Row| {
            let (size, off) = (size(row), hypot(row.off));
            (off <= COARSE[0] * size + row.least).then_some(off / size.max(f64::MIN_POSITIVE))
        };
        let mut shares: Vec<f64> = rows.iter().map(share).collect::<Option<_>>()?;
        shares.sort_by(f64::total_cmp);
        Some(shares[shares.len() / 2]).filter(|half| *half > COARSE[1])
    };
    let is_either = |term: usize| {
        let along = off
            .iter()
            .filter(|row| dot(row.off, row.terms[term].2) > 0.0);
        (EITHER_WAY..=1.0 - EITHER_WAY).contains(&(along.count() as f64 / off.len() as f64))
    };
    let terms = &rows[0].terms;
    let count = shared(&rows.iter().collect::<Vec<_>>());
    let usual = (0..count).filter(|term| terms[*term].1 != 0.0 && is_either(*term));
    let found = usual.filter_map(|term| Some((half(&|row| hypot(row.terms[term].2))?, term)));
    if let Some((_, term)) = found.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))) {
        return Some(format!("{} is {IN_SINGLE_PRECISION}", terms[term].0));
    }
    // An overlap is the small difference of lengths.
    let of_distance = |row: &Row| {
        let named = |name: &str| row.sizes.iter().find(|(size, _)| *size == name);
        let over = named("(R₁ + R₂)").zip(named("u"));
        over.map_or(0.0, |((_, both), (_, u))| {
            hypot(row.terms[0].2) * both / u.abs()
        })
    };
    if terms[0].0 == SPRING && is_either(0) && half(&of_distance).is_some() {
        return Some(format!(
            "the distance of both bodies in the overlap is {IN_SINGLE_PRECISION}"
        ));
    }
    let summed = |row: &Row| SUMMED * row.least / ROUNDED;
    (is_either(0) && half(&summed).is_some())
        .then(|| format!("{} or their sum are {IN_SINGLE_PRECISION}", terms[0].0))
}

/// The first term of normal forces.
pub(super) const SPRING: &str = "the spring's force";

/// What is summed may be so many times as large as what is known of it.
const SUMMED: f64 = 3.0;

/// What no formula has as it is: factors that hang on sizes, and any multiple. In words, and of which terms there is how much more where that is the same for all.
fn of_terms(some: &[&Row], all: &[&Row], plainly: usize) -> Option<(String, More)> {
    let factor =
        |is_formula| factor(some, all, plainly, is_formula).map(|said| (said, More::new()));
    factor(true)
        .or_else(|| search(some, all, plainly, false))
        .or_else(|| factor(false))
}

/// The fewest terms of which another multiple explains all rows.
fn search(some: &[&Row], all: &[&Row], plainly: usize, only_plain: bool) -> Option<(String, More)> {
    let count = shared(some);
    let most = |term: usize| {
        some.iter()
            .map(|row| hypot(row.terms[term].2) / row.least)
            .fold(0.0, f64::max)
    };
    let live: Vec<usize> = (0..count).filter(|term| most(*term) > 1.0).collect();
    let column = |vector: &dyn Fn(&Row) -> Vector| {
        let values = some
            .iter()
            .flat_map(|row| vector(row).map(|part| part / row.least));
        DVector::from_iterator(3 * some.len(), values)
    };
    let off = column(&|row| row.off);
    let columns: Vec<DVector<f64>> = live
        .iter()
        .map(|term| column(&|row| row.terms[*term].2))
        .collect();
    let gram = DMatrix::from_fn(live.len(), live.len(), |a, b| columns[a].dot(&columns[b]));
    let onto = DVector::from_fn(live.len(), |a, _| columns[a].dot(&off));
    for size in 1..=MOST_TERMS.min(plainly) {
        let mut sets: Vec<(f64, Vec<usize>)> = subsets(live.len(), size)
            .into_iter()
            .filter_map(|set| {
                let part = DMatrix::from_fn(size, size, |a, b| gram[(set[a], set[b])]);
                let right_side = DVector::from_fn(size, |a, _| onto[set[a]]);
                let found = part.cholesky()?.solve(&right_side);
                Some((-found.dot(&right_side), set))
            })
            .collect();
        sets.sort_by(|a, b| a.0.total_cmp(&b.0));
        let fitted = sets.into_iter().take(TRIED).filter_map(|(_, set)| {
            let matrix = DMatrix::from_columns(
                &set.iter()
                    .map(|at| columns[*at].clone())
                    .collect::<Vec<_>>(),
            );
            let found = matrix.svd(true, true).solve(&off, 1.0e-13).ok()?;
            let more: Vec<(usize, f64)> = set
                .iter()
                .map(|at| live[*at])
                .zip(found.iter().copied())
                .collect();
            all.iter().all(|row| row.left(&more) <= 5.0).then_some(more)
        });
        let mut fitted: Vec<Vec<(usize, f64)>> = fitted.collect();
        let ugly = |more: &Vec<(usize, f64)>| {
            let is_ugly = |(term, more): &&(usize, f64)| {
                let usual = some[0].terms[*term].1;
                // What comes besides comes once, twice or half.
                !is_plain(usual + more) || usual == 0.0 && more.abs() > 2.0 + 1.0e-6
            };
            more.iter().filter(is_ugly).count()
        };
        // As many free numbers as rows explain anything.
        // Nor do several terms of which one has a factor that no formula has.
        // But for one that all of them share.
        let factor = |(term, more): &(usize, f64)| some[0].terms[*term].1 + more;
        let is_shared = |more: &[(usize, f64)]| {
            let mut all = more.iter().map(factor);
            let first = all.next().unwrap_or(0.0);
            all.all(|other| (other - first).abs() < 1.0e-6)
        };
        fitted.retain(|more| match ugly(more) {
            0 => plainly > size,
            _ => is_shared(more) && plainly > 5 * size && !only_plain,
        });
        let terms = &some[0].terms;
        fitted.sort_by_key(|more| {
            (
                ugly(more),
                replaced(terms, more).is_none(),
                more.iter().map(|(term, _)| *term).sum::<usize>(),
            )
        });
        if let Some(more) = fitted.first() {
            let rounded = more.iter().map(|(term, more)| {
                let usual = some[0].terms[*term].1;
                let error = (4.0 / most(*term)).clamp(1.0e-6, 1.0e-2);
                let now = usual + more;
                let near = (2.0 * now).round() / 2.0;
                (
                    *term,
                    if (now - near).abs() <= error {
                        near - usual
                    } else {
                        *more
                    },
                )
            });
            let rounded: Vec<(usize, f64)> = rounded.filter(|(_, more)| *more != 0.0).collect();
            return (!rounded.is_empty())
                .then(|| (in_words(&some[0].terms, &rounded), more.clone()));
        }
    }
    None
}

/// So many of the first terms all rows have: contacts that begin have none of the step before.
fn shared(rows: &[&Row]) -> usize {
    rows.iter().map(|row| row.terms.len()).min().unwrap_or(0)
}

fn subsets(count: usize, size: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..size {
        let longer = all.iter().flat_map(|set: &Vec<usize>| {
            let from = set.last().map_or(0, |last| last + 1);
            (from..count).map(move |next| [&set[..], &[next]].concat())
        });
        all = longer.collect();
    }
    all
}

/// Whether a factor is one that a formula has: halves, and roots of two.
fn is_plain(factor: f64) -> bool {
    let near = |multiple: f64| (multiple - multiple.round()).abs() < 1.0e-6;
    near(2.0 * factor) || near(factor.abs() * std::f64::consts::SQRT_2)
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1.0e-6
}

/// The term that is in the place of another one, and that one.
fn replaced(terms: &[Term], more: &[(usize, f64)]) -> Option<[&'static str; 2]> {
    let gone = |&&(term, more): &&(usize, f64)| terms[term].1 != 0.0 && close(more, -terms[term].1);
    let new = |&&(term, more): &&(usize, f64)| terms[term].1 == 0.0 && close(more, 1.0);
    match (more.len(), more.iter().find(new), more.iter().find(gone)) {
        (2, Some(new), Some(gone)) => Some([terms[new.0].0, terms[gone.0].0]),
        _ => None,
    }
}

fn in_words(terms: &[Term], more: &[(usize, f64)]) -> String {
    // Of a dashpot that is another one, what it lacks a step before seems to be kept.
    let of_dashpot = more.iter().find(|(term, _)| terms[*term].0 == DASHPOT);
    let seems_kept = |(term, kept): &&(usize, f64)| {
        let lacks = of_dashpot.is_some_and(|(_, more)| close(*kept, -more));
        terms[*term].0 == KEPT_DASHPOT && lacks
    };
    let without: Vec<(usize, f64)> = more
        .iter()
        .filter(|one| !seems_kept(one))
        .copied()
        .collect();
    let more = &without[..];
    // Half of a term and half of its size are all of it where it pushes, or where it pulls.
    if let [(one, less), (size, half)] = more
        && terms[*size].0 == format!("the size of {}", terms[*one].0)
        && close(*less, -0.5 * terms[*one].1)
        && close(half.abs(), 0.5)
    {
        let way = if *half > 0.0 { "approach" } else { "part" };
        return format!("with {} only while bodies {way}", terms[*one].0);
    }
    if let Some([new, gone]) = replaced(terms, more) {
        return format!("with {new} in the place of {gone}");
    }
    let said = more.iter().map(|(term, more)| {
        let (name, usual, _) = terms[*term];
        let now = usual + more;
        match usual {
            _ if close(now, 0.0) => format!("without {name}"),
            0.0 if close(now, 1.0) => format!("with {name} besides"),
            0.0 => format!("with {} × {name} besides", number(now)),
            _ if close(now, -usual) => format!("with {name} of the other sign"),
            _ => format!("with {name} × {}", number(now / usual)),
        }
    });
    said.collect::<Vec<_>>().join(", and ")
}

fn number(value: f64) -> String {
    let short = format!("{value:.6}");
    match short.contains('.') && value.abs() >= 1.0e-3 {
        true => short.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => format!("{value:.6e}"),
    }
}

/// One term whose factor goes by powers of sizes, or hangs on what touches; or, where it is no formula, that rises or falls with one.
fn factor(some: &[&Row], all: &[&Row], plainly: usize, is_formula: bool) -> Option<String> {
    if plainly < 6 {
        return None;
    }
    let count = shared(some);
    (0..count).find_map(|term| {
        let (name, usual, _) = some[0].terms[term];
        // A row without the term says nothing of its factor, and must be right.
        let factor = |row: &Row| -> Option<f64> {
            let value = row.terms[term].2;
            let more = dot(row.off, value) / dot(value, value);
            (row.left(&[(term, more)]) <= 2.0).then_some(usual + more)
        };
        let has = |row: &&&Row| hypot(row.terms[term].2) > row.least;
        let clear = |row: &&&Row| hypot(row.terms[term].2) > 1.0e3 * row.least;
        let without = all.iter().filter(|row| !has(row)).any(|row| row.is_off());
        if without || !all.iter().filter(has).all(|row| factor(row).is_some()) {
            return None;
        }
        let rows: Vec<&&Row> = some.iter().filter(clear).collect();
        let factors: Vec<f64> = rows.iter().filter_map(|row| factor(row)).collect();
        let (low, high) = factors
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), factor| {
                (low.min(*factor), high.max(*factor))
            });
        if rows.len() < 6 || high - low <= 1.0e-6 * high.abs().max(usual) {
            return None;
        }
        match is_formula {
            true => {
                by_powers(name, &rows, &factors, term).or_else(|| by_groups(name, &rows, &factors))
            }
            false => by_one_size(name, &rows, &factors)
                .or_else(|| by_contact(name, &rows, &factors, term)),
        }
    })
}

fn by_powers(name: &str, rows: &[&&Row], factors: &[f64], term: usize) -> Option<String> {
    if factors.iter().any(|factor| *factor <= 0.0) {
        return None;
    }
    let sizes = &rows[0].sizes;
    let logarithm = |row: &Row, size: usize| row.sizes[size].1.ln();
    // What adhesion holds has an overlap below 0.
    let has_power = |size: &usize| rows.iter().all(|row| logarithm(row, *size).is_finite());
    let sets = (1..=2).flat_map(|count| subsets(sizes.len(), count));
    let sets = sets.filter(|set| set.iter().all(has_power));
    let found = sets.filter_map(|set| {
        let matrix = DMatrix::from_fn(rows.len(), set.len() + 1, |row, column| match column {
            0 => 1.0,
            _ => logarithm(rows[row], set[column - 1]),
        });
        let logarithms =
            DVector::from_iterator(factors.len(), factors.iter().map(|factor| factor.ln()));
        let found = matrix.svd(true, true).solve(&logarithms, 1.0e-13).ok()?;
        let powers: Vec<f64> = found
            .iter()
            .skip(1)
            .map(|power| (12.0 * power).round() / 12.0)
            .collect();
        if powers.contains(&0.0) || powers.iter().any(|power| power.abs() > 3.0) {
            return None;
        }
        let sum = |row: &Row| {
            set.iter()
                .zip(&powers)
                .map(|(size, power)| power * logarithm(row, *size))
                .sum::<f64>()
        };
        let constants: Vec<f64> = rows
            .iter()
            .zip(factors)
            .map(|(row, factor)| factor.ln() - sum(row))
            .collect();
        let constant = constants.iter().sum::<f64>() / constants.len() as f64;
        let fits = rows.iter().zip(factors).all(|(row, factor)| {
            let off = (constant + sum(row)).exp() - factor;
            off.abs() * hypot(row.terms[term].2)
                <= 3.0 * row.least + 1.0e-8 * factor.abs() * hypot(row.terms[term].2)
        });
        fits.then(|| {
            let power = |(size, power): (&usize, &f64)| match *power {
                1.0 => sizes[*size].0.to_owned(),
                0.5 => format!("√{}", sizes[*size].0),
                power => format!("{}^{}", sizes[*size].0, number(power)),
            };
            let by: Vec<String> = set.iter().zip(&powers).map(power).collect();
            let (by, factor) = (by.join(" × "), constant.exp());
            match (factor - 1.0).abs() < 1.0e-6 {
                true => (0, format!("with {name} × {by} (SI)")),
                false => (1, format!("with {name} × {} × {by} (SI)", number(factor))),
            }
        })
    });
    // Two powers and a number besides fit too much.
    let found = found.filter(|(own, said)| *own == 0 || said.matches(" × ").count() < 3);
    // A formula has no number of its own, if there is such a one.
    found.min_by_key(|found| found.0).map(|found| found.1)
}

/// A factor that rises or falls with one size, row by row. Of a few contacts it may do so by chance, at however many moments.
fn by_one_size(name: &str, rows: &[&&Row], factors: &[f64]) -> Option<String> {
    let mut subjects: Vec<(usize, Of)> = Vec::new();
    for subject in rows.iter().map(|row| (row.at.0, row.subject)) {
        if subjects.len() < FEWEST && !subjects.contains(&subject) {
            subjects.push(subject);
        }
    }
    if subjects.len() < FEWEST {
        return None;
    }
    let told = (0..rows[0].sizes.len()).find_map(|size| {
        let both = rows.iter().zip(factors);
        let mut both: Vec<(f64, f64)> = both.map(|(row, by)| (row.sizes[size].1, *by)).collect();
        both.sort_by(|a, b| a.0.total_cmp(&b.0));
        both.dedup_by(|a, b| a.0 == b.0);
        let goes = |way: f64| both.windows(2).all(|two| way * (two[1].1 - two[0].1) > 0.0);
        let enough = both.len() >= FEWEST && 2 * both.len() > rows.len();
        (enough && (goes(1.0) || goes(-1.0))).then_some((size, both[0], both[both.len() - 1]))
    });
    told.map(|(size, (low, first), (high, last))| {
        let [first, last] = [first, last].map(number);
        format!(
            "with {name} × a factor that goes with {}: {first} at {low:.3e} to {last} at {high:.3e} (SI)",
            rows[0].sizes[size].0
        )
    })
}

/// A factor that each contact or grain has at all moments, and others another one: what is multiplied by it is the term.
fn by_contact(name: &str, rows: &[&&Row], factors: &[f64], term: usize) -> Option<String> {
    let mut of_each: Vec<((usize, Of), f64, usize)> = Vec::new();
    for (row, factor) in rows.iter().zip(factors) {
        let subject = (row.at.0, row.subject);
        let Some((_, first, count)) = of_each.iter_mut().find(|one| one.0 == subject) else {
            of_each.push((subject, *factor, 1));
            continue;
        };
        if (*factor - *first).abs() * hypot(row.terms[term].2) > 10.0 * row.least {
            return None;
        }
        *count += 1;
    }
    of_each.retain(|one| one.2 > 1);
    let all = || of_each.iter().map(|one| one.1);
    let (low, high) = (
        all().fold(f64::INFINITY, f64::min),
        all().fold(f64::NEG_INFINITY, f64::max),
    );
    // Where some are right it is told of the others alone.
    let usual = rows.first()?.terms[term].1;
    let are_off = all().all(|factor| (factor - usual).abs() > 1.0e-6);
    (are_off && of_each.len() >= FEWEST).then(|| {
        let [low, high] = [low, high].map(number);
        format!("with {name} × a factor of {low} to {high}, which each keeps")
    })
}

fn by_groups(name: &str, rows: &[&&Row], factors: &[f64]) -> Option<String> {
    let mut groups: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (row, factor) in rows.iter().zip(factors) {
        groups.entry(&row.between).or_default().push(*factor);
    }
    let same = |factors: &Vec<f64>| {
        factors
            .iter()
            .all(|factor| (factor - factors[0]).abs() <= 1.0e-6 * factors[0].abs().max(1.0e-3))
    };
    let told = groups.len() > 1 && groups.len() <= 9 && groups.values().all(same);
    told.then(|| {
        let other = groups
            .iter()
            .filter(|(_, factors)| (factors[0] - 1.0).abs() > 1.0e-6);
        let said: Vec<String> = other
            .map(|(between, factors)| format!("{} between {between}", number(factors[0])))
            .collect();
        format!("with {name} × {}", said.join(", by "))
    })
}
