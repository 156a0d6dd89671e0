//! Section 2.2, Table 1: five piles share five units of force. Recomputed by listing all cases.

use std::collections::BTreeMap;

use super::Number;

/// How many piles bear 0, 1, … 5 units.
type Subclass = [u32; 6];

/// Every way for five piles to bear 0 to 5 units each.
fn all_loads() -> impl Iterator<Item = [u32; 5]> {
    (0..6u32.pow(5)).map(|mut code| {
        [0; 5].map(|_| {
            let load = code % 6;
            code /= 6;
            load
        })
    })
}

/// The subclasses of Table 1, in its order, with the printed numbers of cases.
const TABLE_1: [(&str, Subclass, f64); 7] = [
    ("pessimistic", [4, 0, 0, 0, 0, 1], 5.0),
    ("second row", [3, 1, 0, 0, 1, 0], 20.0),
    ("third row", [3, 0, 1, 1, 0, 0], 20.0),
    ("most likely 1", [2, 2, 0, 1, 0, 0], 30.0),
    ("most likely 2", [2, 1, 2, 0, 0, 0], 30.0),
    ("sixth row", [1, 3, 1, 0, 0, 0], 20.0),
    ("optimistic", [0, 5, 0, 0, 0, 0], 1.0),
];

/// A subclass of Table 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counted {
    /// As the paper calls it, or its row.
    pub name: &'static str,
    /// How many piles bear 0, 1, … 5 units.
    pub piles: [u32; 6],
    /// Its cases, counted.
    pub cases: u32,
}

/// The subclasses in the order of Table 1 with their cases counted.
pub fn table_1() -> Vec<Counted> {
    let subclasses = subclasses();
    let counted = |(name, piles, _): &(&'static str, Subclass, f64)| Counted {
        name,
        piles: *piles,
        cases: subclasses.get(piles).copied().unwrap_or(0),
    };
    TABLE_1.iter().map(counted).collect()
}

/// The chance that one of the five piles bears at least so many units, all cases being alike.
pub fn chance_of_at_least_of_five(units: u32) -> f64 {
    let all = balanced();
    let enough = all.iter().filter(|loads| loads[0] >= units).count();
    enough as f64 / all.len() as f64
}

/// The cases with five units in all.
fn balanced() -> Vec<[u32; 5]> {
    all_loads()
        .filter(|loads| loads.iter().sum::<u32>() == 5)
        .collect()
}

/// Their subclasses with the number of cases.
fn subclasses() -> BTreeMap<Subclass, u32> {
    let mut subclasses: BTreeMap<Subclass, u32> = BTreeMap::new();
    for loads in balanced() {
        let mut piles = [0; 6];
        for load in loads {
            piles[load as usize] += 1;
        }
        *subclasses.entry(piles).or_default() += 1;
    }
    subclasses
}

/// The numbers of section 2.2.
pub fn numbers() -> Vec<Number> {
    let place = "section 2.2";
    let how = "listing all 6⁵ sets of loads";
    let (balanced, subclasses) = (balanced(), subclasses());
    let cases = |of: &Subclass| f64::from(subclasses.get(of).copied().unwrap_or(0));
    let most = subclasses.values().copied().max().unwrap_or(0);
    let total = balanced.len() as f64;
    let (pessimistic, optimistic) = (TABLE_1[0].1, TABLE_1[6].1);

    let mut numbers = vec![
        Number::new(
            place,
            "variations of 6 loads over 5 piles",
            7726.0,
            0.0,
            all_loads().count() as f64,
            "cases",
            how,
        )
        .misprint("6⁵ is 7776; a digit is wrong in the text, 50 too few; nothing else uses it"),
        Number::new(
            place,
            "cases with 5 units in all",
            126.0,
            0.0,
            total,
            "cases",
            how,
        ),
    ];
    for (name, subclass, published) in &TABLE_1 {
        numbers.push(Number::new(
            "Table 1",
            &format!("cases of the {name} subclass, of 126"),
            *published,
            0.0,
            cases(subclass),
            "cases",
            how,
        ));
    }
    let symmetric = |loads: &&[u32; 5]| loads[0] == loads[4] && loads[1] == loads[3];
    let no_moment = |loads: &&[u32; 5]| {
        let [a, b, _, d, e] = **loads;
        2 * a + b == 2 * e + d
    };
    numbers.extend([
        Number::new(
            "Table 1",
            "subclasses",
            7.0,
            0.0,
            subclasses.len() as f64,
            "subclasses",
            how,
        ),
        Number::new(
            place,
            "cases of each most likely subclass",
            30.0,
            0.0,
            f64::from(most),
            "cases",
            how,
        ),
        Number::new(
            place,
            "most likely over optimistic",
            30.0,
            0.0,
            f64::from(most) / cases(&optimistic),
            "1",
            how,
        ),
        Number::new(
            place,
            "most likely over pessimistic",
            6.0,
            0.0,
            f64::from(most) / cases(&pessimistic),
            "1",
            how,
        ),
        Number::new(
            place,
            "pessimistic over optimistic",
            5.0,
            0.0,
            cases(&pessimistic) / cases(&optimistic),
            "1",
            how,
        ),
        Number::new(
            place,
            "cases that are symmetric",
            6.0,
            0.0,
            balanced.iter().filter(symmetric).count() as f64,
            "cases",
            how,
        ),
        Number::new(
            place,
            "cases left by a moment balance",
            6.0,
            0.0,
            balanced.iter().filter(no_moment).count() as f64,
            "cases",
            how,
        )
        .remark(
            "for equally spaced piles the balance of moments about the middle one also admits \
             unsymmetric cases such as (1 0 2 2 0); 6 counts the symmetric ones only",
        ),
        Number::new(
            place,
            "chance of the optimistic case",
            1.0,
            0.5,
            100.0 * cases(&optimistic) / total,
            "%",
            how,
        ),
        Number::new(
            place,
            "chance of the pessimistic subclass",
            4.0,
            0.5,
            100.0 * cases(&pessimistic) / total,
            "%",
            how,
        ),
        Number::new(
            place,
            "chance of at least twice the mean, many piles",
            13.5,
            0.05,
            100.0 * chance_of_at_least(10_000, 10_000, 20_000),
            "%",
            "counting the cases of 10,000 piles whose mean load is 10,000 steps",
        ),
        Number::new(
            place,
            "the same in the whole units of the example",
            13.5,
            0.05,
            100.0 * chance_of_at_least(10_000, 1, 2),
            "%",
            "counting the cases of 10,000 piles whose mean load is 1 step",
        )
        .remark(
            "loads in whole units are geometric, not exponential, however many piles there are: \
             at least 2 units has 25 %, more than 2 has 12.5 %; 13.5 % needs loads in steps much \
             finer than the mean",
        ),
    ]);
    numbers
}

/// The chance that a pile bears at least `least` steps when all ways of sharing `mean` steps a pile
/// among `piles` are alike: C(S−least+N−1, N−1)/C(S+N−1, N−1).
fn chance_of_at_least(piles: u32, mean: u32, least: u32) -> f64 {
    let total = f64::from(piles) * f64::from(mean);
    let last = f64::from(piles - 1);
    (0..piles - 1)
        .map(|index| {
            let of_all = total + last - f64::from(index);
            (of_all - f64::from(least)) / of_all
        })
        .product()
}
