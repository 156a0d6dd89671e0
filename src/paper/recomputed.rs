//! The printed figures that need no simulation, each recomputed by a route of our own: enumeration, numerical integration,
//! convolution.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use statrs::distribution::{ContinuousCDF, Erlang};

use super::Number;
use super::continuum::strip_load;
use super::disc_field::figure_4;
use super::integrate;
use super::published::{
    CONTROL_VOLUME, HEIGHT, OFFSETS, POINTS, POROSITY, PRESSURE, Parts, TABLE_1, table_4,
};

/// a, m.
pub const HALF_WIDTH: f64 = 0.0225;
/// Of the control points, m.
pub const DEPTH: f64 = 0.11;
/// g, m/s².
pub const GRAVITY: f64 = 9.81;
/// ρ_s, kg/m³.
pub const DENSITY: f64 = 2600.0;

/// Section 2.2 and Table 1: five piles share five units of force, by listing all cases.
pub mod piles {
    use super::*;

    /// How many piles bear 0, 1, … 5 units.
    type Subclass = [u32; 6];

    /// A subclass of Table 1.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct Counted {
        /// As the paper calls it, or its row.
        pub name: &'static str,
        /// How many piles bear 0, 1, … 5 units.
        pub piles: Subclass,
        pub cases: u32,
    }

    /// Every way for five piles to bear 0 to 5 units each.
    pub fn all_loads() -> impl Iterator<Item = [u32; 5]> {
        (0..6u32.pow(5)).map(|mut code| {
            [0; 5].map(|_| {
                let load = code % 6;
                code /= 6;
                load
            })
        })
    }

    /// The cases with five units in all.
    pub fn balanced() -> Vec<[u32; 5]> {
        all_loads()
            .filter(|loads| loads.iter().sum::<u32>() == 5)
            .collect()
    }

    /// Their subclasses with the number of cases.
    pub fn subclasses() -> BTreeMap<Subclass, u32> {
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

    /// The subclasses in the order of Table 1 with their cases counted.
    pub fn table_1() -> [Counted; 7] {
        let subclasses = subclasses();
        TABLE_1.map(|(name, piles)| Counted {
            name,
            piles,
            cases: subclasses.get(&piles).copied().unwrap_or(0),
        })
    }

    /// The chance that one of the five piles bears at least so many units, all cases being alike.
    pub fn chance_of_at_least_of_five(units: u32) -> f64 {
        let all = balanced();
        let enough = all.iter().filter(|loads| loads[0] >= units).count();
        enough as f64 / all.len() as f64
    }

    /// The chance that a pile bears at least `least` steps when all ways of sharing `mean` steps a pile
    /// among `piles` are alike: C(S−least+N−1, N−1)/C(S+N−1, N−1).
    pub fn chance_of_at_least(piles: u32, mean: u32, least: u32) -> f64 {
        let total = f64::from(piles) * f64::from(mean);
        let last = f64::from(piles - 1);
        (0..piles - 1)
            .map(|index| {
                let of_all = total + last - f64::from(index);
                (of_all - f64::from(least)) / of_all
            })
            .product()
    }
}

/// Section 2.2 and Table 1.
pub fn of_piles() -> Vec<Number> {
    let how = "listing all 6⁵ sets of loads";
    let (balanced, subclasses, table) = (piles::balanced(), piles::subclasses(), piles::table_1());
    let [pessimistic, optimistic] = [0, 6].map(|row: usize| f64::from(table[row].cases));
    let most = f64::from(subclasses.values().copied().max().unwrap_or(0));
    let total = balanced.len() as f64;
    let symmetric = |loads: &&[u32; 5]| loads[0] == loads[4] && loads[1] == loads[3];
    let no_moment = |loads: &&[u32; 5]| {
        let [a, b, _, d, e] = **loads;
        2 * a + b == 2 * e + d
    };
    let count = |holds: &dyn Fn(&&[u32; 5]) -> bool| balanced.iter().filter(holds).count() as f64;
    let number = |id: &str, what: &str, value: f64| Number::of(id, what, value, how);
    let all = piles::all_loads().count() as f64;
    let mut numbers = vec![
        number("piles/loads", "variations of 6 loads over 5 piles", all).known(
            7776.0,
            "misprint: 6⁵ is 7776; a digit is wrong in the text, 50 too few; nothing else uses it",
        ),
        number("piles/balanced", "cases with 5 units in all", total),
    ];
    for (row, subclass) in table.iter().enumerate() {
        let what = format!("cases of the {} subclass, of 126", subclass.name);
        let id = format!("table-1/{}", row + 1);
        numbers.push(number(&id, &what, f64::from(subclass.cases)));
    }
    let classes = subclasses.len() as f64;
    numbers.push(number("table-1/subclasses", "subclasses", classes));
    let add = |id: &str, what: &str, value: f64| number(&format!("piles/{id}"), what, value);
    let over = |one: &str, other: &str, ratio: f64| {
        let id = format!("{one}-over-{other}").replace("most ", "");
        add(&id, &format!("{one} over {other}"), ratio)
    };
    let chance = |case: &str, what: &str, cases: f64| {
        let words = format!("chance of the {case} {what}");
        add(&format!("chance-{case}"), &words, cases / total)
    };
    let what = "cases of each most likely subclass";
    let left = "cases left by a moment balance";
    let (a, b) = (optimistic, pessimistic);
    numbers.extend([
        add("most-likely", what, most),
        over("most likely", "optimistic", most / a),
        over("most likely", "pessimistic", most / b),
        over("pessimistic", "optimistic", b / a),
        add("symmetric", "cases that are symmetric", count(&symmetric)),
        add("moment-balance", left, count(&no_moment)).known(
            12.0,
            "for equally spaced piles the balance of moments about the middle one also admits \
             unsymmetric cases such as (1 0 2 2 0); 6 counts the symmetric ones only",
        ),
        chance("optimistic", "case", a),
        chance("pessimistic", "subclass", b),
    ]);
    let many = |id: &str, what: &str, mean: u32, how: &str| {
        let how = format!("counting the cases of 10,000 piles whose mean load is {how}");
        let chance = piles::chance_of_at_least(10_000, mean, 2 * mean);
        Number::of(id, what, chance, &how)
    };
    let what = "chance of at least twice the mean, many piles";
    numbers.push(many("piles/twice-the-mean", what, 10_000, "10,000 steps"));
    let what = "the same in the whole units of the example";
    let whole_units = many("piles/twice-in-whole-units", what, 1, "1 step");
    numbers.push(whole_units.known(
        0.250_012_500_625,
        "loads in whole units are geometric, not exponential, however many piles there are: \
         at least 2 units has 25 %, more than 2 has 12.5 %; 13.5 % needs loads in steps much \
         finer than the mean",
    ));
    numbers
}

/// Of Figure 4's disc, m.
const RADIUS: f64 = 1.0;

/// Two discs on top of each other between two forces: the force between them is inner to the pair.
fn stacked_over_sum() -> f64 {
    let sum_about = |centre: f64, ends: [f64; 2]| {
        let [low, high] = ends.map(|end| end - centre);
        // The lower force of 1 N/m pushes up, the upper one down; compression positive.
        high - low
    };
    let lower = sum_about(RADIUS, [0.0, 2.0 * RADIUS]);
    let upper = sum_about(3.0 * RADIUS, [2.0 * RADIUS, 4.0 * RADIUS]);
    sum_about(2.0 * RADIUS, [0.0, 4.0 * RADIUS]) / (lower + upper)
}

/// πR² in polar rings, m².
fn disc_area() -> f64 {
    integrate(0.0, RADIUS, 1, |r| 2.0 * PI * r)
}

/// Figure 4 and Table 3: a disc between 1 N/m from above and below and 0.5 N/m from both sides.
pub fn of_disc() -> Vec<Number> {
    let volume = integrate(-RADIUS, RADIUS, 1, |_| 2.0 * RADIUS);
    let particle = disc_area();
    // Compression positive.
    let sums = -figure_4().average_over_disc() * particle;
    let (xx, xz, zz) = (sums[(0, 0)], sums[(0, 1)], sums[(1, 1)]);
    let field = "elastic stress field integrated over the disc";
    let number = |id: &str, what: &str, value: f64, how: &str| {
        Number::of(&format!("table-3/{id}"), what, value, how)
    };
    let integrated = "integration";
    vec![
        number("volume", "total volume", volume, integrated),
        number("particle-volume", "particle volume", particle, integrated),
        number("porosity", "porosity", 1.0 - particle / volume, integrated),
        number("sum-zz", "Σ_zz", zz, field),
        number("stress-zz", "σ_zz", zz / volume, field),
        number("sum-xx", "Σ_xx", xx, field),
        number("stress-xx", "σ_xx", xx / volume, field),
        number("sum-xy", "Σ_xy", xz, field),
        number("stress-xy", "σ_xy", xz / volume, field),
        Number::of(
            "eq-8/stacked",
            "Σ_zz of two stacked discs over the sum of theirs",
            stacked_over_sum(),
            "Σ x_i F_j of the outer forces of the pair, and of each disc alone",
        )
        .remark("printed as a formula"),
    ]
}

/// σ_g,zz, Pa, by weighing: discs of the mean size on a triangular lattice that is so wide that its
/// porosity is the published one; those with centres above the depth are counted for many heights of
/// the lattice, and their weight is set on the width that they stand on.
fn weight() -> f64 {
    const HEIGHTS: u32 = 1000;
    let solid = mean_solid_area();
    // A disc has the cell s·(√3/2)s.
    let spacing = (solid / (1.0 - *POROSITY) * 2.0 / 3f64.sqrt()).sqrt();
    let row_height = 0.5 * 3f64.sqrt() * spacing;
    let weight_of_row = DENSITY * GRAVITY * solid / spacing;
    let mut rows = 0;
    for height in 0..HEIGHTS {
        let first = row_height * (f64::from(height) + 0.5) / f64::from(HEIGHTS);
        rows += (0..1000)
            .take_while(|row| first + row_height * f64::from(*row) < DEPTH)
            .count();
    }
    weight_of_row * rows as f64 / f64::from(HEIGHTS)
}

/// Eq. 3 as printed, Pa, with θ read as arctan((X−x)/z), X₁ left and X₂ right.
fn equation_3_as_printed(offset: f64) -> f64 {
    let angle = |edge: f64| ((edge - offset) / DEPTH).atan();
    let (one, two) = (angle(-HALF_WIDTH), angle(HALF_WIDTH));
    *PRESSURE / PI * ((one - two) + one.sin() * two.cos() - two.sin() * one.cos())
}

/// A control point's row of Table 4 before rounding: two digits of 0.0945 J are 0.09.
pub fn unrounded(point: &str) -> Option<Parts> {
    let at = POINTS.iter().position(|name| *name == point)?;
    let (weight, load) = (
        weight(),
        strip_load(*PRESSURE, HALF_WIDTH, OFFSETS[at], DEPTH),
    );
    let stress = weight + load;
    let extensive = stress * *CONTROL_VOLUME;
    Some(Parts {
        weight,
        load,
        stress,
        extensive,
    })
}

/// Section 3.1 and Table 4: the continuum's stress at the control points, by Flamant's solution and weighed grains.
pub fn of_continuum() -> Vec<Number> {
    let mut numbers = Vec::new();
    let weight = weight();
    let as_printed_is = [-11_252.479, -7_542.719_4, -4_068.340_1];
    for ((point, offset), known) in POINTS.into_iter().zip(OFFSETS).zip(as_printed_is) {
        let load = strip_load(*PRESSURE, HALF_WIDTH, offset, DEPTH);
        let both = "weighed discs plus Flamant's integral";
        let number = |column: &str, what: &str, value: f64, how: &str| {
            let id = format!("table-4/{column}/{point}");
            Number::of(&id, &format!("{what} at {point}"), value, how)
        };
        let mut sum = number("stress", "σ_zz", weight + load, both);
        if let Some(row) = table_4(point)
            && (row.weight + row.load - row.stress).abs() > sum.rounding
        {
            sum = sum.remark(&format!(
                "right; the printed parts sum to {:.1} kPa because each is rounded",
                1e-3 * (row.weight + row.load)
            ));
        }
        let formula = equation_3_as_printed(offset);
        let misprint = format!(
            "misprint: the formula is at fault, not the table: its sign is wrong (X₁ is the left limit), and its size is {:.2} \
             times the integral",
            formula.abs() / load
        );
        let how = "the printed formula, θ read as arctan((X−x)/z)";
        let as_printed = Number {
            id: format!("eq-3/as-printed/{point}"),
            place: "Eq. 3".to_owned(),
            ..number("load", "Eq. 3 as printed against Table 4", formula, how)
        };
        let weighing = "weighing discs on a lattice of porosity n, counted above the depth";
        let integrating = "Flamant's line load integrated over the strip";
        numbers.extend([
            number("weight", "σ_g,zz", weight, weighing),
            number("load", "σ_p,zz", load, integrating),
            sum,
            number("extensive", "Σ_zz", (weight + load) * *CONTROL_VOLUME, both),
            as_printed.known(known, &misprint),
        ]);
    }
    let force = integrate(-HALF_WIDTH, HALF_WIDTH, 1, |_| *PRESSURE);
    let how = "the load integrated over the strip";
    let force = Number::of("load/force", "force 2ap on the punch", force, how);
    let square = integrate(-0.0025, 0.0025, 1, |_| 0.005);
    let (id, what) = (
        "table-4/control-volume",
        "V_c, a square of side R and 1 m deep",
    );
    let square = Number::of(id, what, square, "area of the square");
    let share = *CONTROL_VOLUME / (mean_solid_area() / (1.0 - *POROSITY));
    let (id, what) = (
        "section-5/control-volume",
        "V_c over the mean cell of a grain",
    );
    let share = Number::of(id, what, share, "mean area of the grains over 1−n").known(
        0.263_977_22,
        "misprint: 1 if V_c were the particle and its void, as section 5 says; section 3.2.3 and Table 4 \
         use a square of side R. The exponential law scales, so only the name is at fault",
    );
    numbers.extend([force.derived("the target of loading"), square, share]);
    numbers
}

/// Mean area πR² of a grain, m²: R uniform in 0.005·(1 ± 0.05), integrated over the sizes.
pub fn mean_solid_area() -> f64 {
    let (radius, dispersion) = (0.005, 0.05);
    integrate(-dispersion, dispersion, 1, |share| {
        PI * (radius * (1.0 + share)).powi(2) / (2.0 * dispersion)
    })
}

/// Section 4.2: height and porosity are tied by the area of the grains.
pub fn of_bed() -> Vec<Number> {
    let solid = 5000.0 * mean_solid_area();
    let how = "area of 5,000 discs over a box 1 m wide";
    let porosity_at = |height: f64| 1.0 - solid / height;
    let number = |id: &str, what: &str, value: f64| Number::of(id, what, value, how);
    let what = "porosity n at the upper end, H = 0.47 m";
    let upper = Number {
        id: "bed/porosity-at-the-upper-end".to_owned(),
        ..number("bed/porosity", what, porosity_at(0.47))
    };
    let what = "porosity n at the published height H = 0.46 m";
    let porosity = number("bed/porosity", what, porosity_at(*HEIGHT));
    let what = "height H at the published porosity n = 0.17";
    let height = number("bed/height", what, solid / (1.0 - *POROSITY));
    vec![
        porosity.known(
            0.145_594_93,
            "the published mean height and mean porosity do not belong together for R = 0.005 m; \
             0.01 is the published scatter",
        ),
        upper.derived("only beds near the upper end of H meet both, at the lower end of n"),
        height.known(0.473_525_70, "0.01 is the published scatter"),
    ]
}

/// Grid step over the mean.
const STEP: f64 = 0.01;
/// Length of the grid over the mean.
const LENGTH: f64 = 60.0;

/// Weights of the exponential law of mean 1 on the grid, each from its own stretch.
fn exponential() -> Vec<f64> {
    let count = (LENGTH / STEP) as usize;
    (0..count)
        .map(|index| (-STEP * index as f64).exp() * -(-STEP).exp_m1())
        .collect()
}

/// Weights of the sum of `terms` independent draws on the grid.
fn sum_of(terms: u32) -> Vec<f64> {
    let one = exponential();
    let mut sum = one.clone();
    for _ in 1..terms {
        let mut next = vec![0.0; one.len()];
        for (index, weight) in sum.iter().enumerate() {
            if *weight < 1e-18 {
                continue;
            }
            for (of_next, of_one) in next[index..].iter_mut().zip(&one) {
                *of_next += weight * of_one;
            }
        }
        sum = next;
    }
    sum
}

/// Mean and standard deviation of a sum of `terms` draws, each at its stretch's middle.
fn moments(sum: &[f64], terms: u32) -> (f64, f64) {
    let middle = 0.5 * f64::from(terms);
    let place = |index: usize| STEP * (index as f64 + middle);
    let weighed = |value: &dyn Fn(f64) -> f64| -> f64 {
        let parts = sum.iter().enumerate();
        parts
            .map(|(index, weight)| value(place(index)) * weight)
            .sum()
    };
    let mean = weighed(&|at| at);
    (mean, weighed(&|at| (at - mean).powi(2)).sqrt())
}

/// Sections 3.3 and 5: the exponential law, and sums of it by convolving the law with itself on a grid.
pub fn of_sums() -> Vec<Number> {
    let number =
        |id: String, place: &str, what: &str, [published, within, value]: [f64; 3], how: &str| {
            let number = Number {
                id,
                place: place.to_owned(),
                published,
                rounding: within,
                unit: "1".to_owned(),
                ..Number::of("", what, value, how)
            };
            number.judged()
        };
    let law = |id: &str, what: &str, value: f64| {
        let (id, how) = (format!("eq-7/{id}"), "numerical integration of the density");
        number(id, "Eq. 7, section 3.3", what, [1.0, 1e-9, value], how)
    };
    let density = |x: f64| (-x).exp();
    let whole = integrate(0.0, LENGTH, 60, density);
    let mean = integrate(0.0, LENGTH, 60, |x| x * density(x));
    let mut numbers = vec![
        law("integral", "integral of the density", whole),
        law("mean", "mean over μ", mean),
    ];
    // The grid's own error is a few parts in a hundred thousand.
    let grid = 1e-4;
    for terms in [2u32, 5, 10] {
        let sum = sum_of(terms);
        let (mean, deviation) = moments(&sum, terms);
        let how = format!("convolving the exponential law with itself, N = {terms}");
        let count = f64::from(terms);
        let mut add = |id: &str, what: String, values: [f64; 3]| {
            let id = format!("section-5/{id}/{terms}");
            numbers.push(number(id, "section 5", &what, values, &how));
        };
        let what = format!("mean over Vσ of {terms} cells");
        add("mean", what, [1.0, grid, mean / count]);
        let what = format!("variance over (Vσ)² of {terms} cells, printed 1/N");
        let found = (deviation / count).powi(2);
        add("variance", what, [1.0 / count, grid, found]);
        let what = format!("coefficient of variation of {terms} cells, printed 1/√N");
        let found = deviation / mean;
        add("variation", what, [1.0 / count.sqrt(), grid, found]);
        // The grid knows the chance of ending before a whole step; half a stretch a term is added back.
        let steps = ((count / STEP) - 0.5 * count) as usize;
        let below: f64 = sum[..steps].iter().sum();
        let erlang = Erlang::new(u64::from(terms), 1.0).expect("a law of some terms");
        let erlang = erlang.cdf(count);
        let what =
            format!("chance that {terms} cells have less than their mean, printed Erlang(N)");
        add("below-mean", what, [erlang, 2e-3, below]);
    }
    numbers
}
