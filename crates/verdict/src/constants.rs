//! Which constants another engine computes with: a robust fit of the native engine's to the first steps of the other.
//!
//! One step from a state is nearly linear in small changes of the constants. The differences in velocities, displacements,
//! spins and contact forces are laid onto the responses by least squares, weighted so that grains with another fault do not
//! count (weights 1/(1 + (r/s)²), s the median of |r| among grains of one kind), and again from the constants found.

use std::collections::{BTreeMap, BTreeSet};
use std::iter::repeat_n;

use evidence::in_parallel;
use evidence::moments::median;
use grains::constant::Constant;
use grains::tables::{Contact, Snapshot};
use grains::task::Case;
use grains::variant::{self, Form, Variant};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::contacts::Table;
use crate::envelope::Resolution;

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fitted {
    #[serde(serialize_with = "symbol")]
    pub constant: Constant,
    /// How much larger than the model's, relative; of gravity over |g|.
    pub larger: f64,
    pub error: f64,
}

fn symbol<S: serde::Serializer>(constant: &Constant, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(constant.symbol())
}

impl Fitted {
    /// Whether it is another than the model's: by six standard errors.
    pub fn is_wrong(&self) -> bool {
        self.larger.abs() > 6.0 * self.error && self.larger.abs() > LEAST
    }
}

/// The constants that fit best.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    pub variant: Variant,
    /// Those that were free.
    pub fitted: Vec<Fitted>,
    /// Constants that the data cannot tell from the others; they were taken as given.
    pub tied: Vec<Constant>,
    /// Of the numbers to the constants that were free.
    responses: DMatrix<f64>,
}

impl Fit {
    /// Of a variant that is known, with nothing to be fitted.
    pub fn known(variant: Variant) -> Self {
        Fit {
            variant,
            fitted: Vec::new(),
            tied: Vec::new(),
            responses: DMatrix::zeros(0, 0),
        }
    }

    /// The constants that are another than the model's.
    pub fn wrong(&self) -> Vec<Fitted> {
        let wrong = self.fitted.iter().filter(|fitted| fitted.is_wrong());
        wrong.copied().collect()
    }
}

/// Nothing smaller can be told from rounding.
const LEAST: f64 = 1.0e-12;
/// The steps that are fitted.
const FITTED_UNTIL: u64 = 1;
/// Response to a change of this size.
const CHANGE: f64 = 1.0e-6;
/// What changes by less than so many times what cannot be told has not changed.
const ROUNDED: f64 = 4.0;
/// From the constants found the fit is made again, so often at most; the responses themselves the first few times.
const ROUNDS: usize = 12;
const ROUNDS_WITH_RESPONSES: usize = 4;
/// So much larger a constant becomes in a round at most: where forces are those of the fault, small responses of the model's own say
/// little.
const LARGEST_STEP: f64 = 0.5;
/// Weights are made anew so often in each round, at most, or until what is found changes by less than this share.
const REWEIGHTED: usize = 12;
const SETTLED: f64 = 1.0e-6;
/// A direction that changes the data by less than this share of the largest cannot be told.
const TOLD: f64 = 1.0e-9;

/// Numbers that are off by so many times what cannot be told are rounding, in the first steps.
const ROUNDING: f64 = 100.0;
/// How much a contact counts that one of two runs has not: as much as the worst number.
const NOT_THERE: f64 = 27.0;

const KINDS_OF_A_CASE: usize = 100;

/// What of a run is fitted: a number for each grain and component, in m/s, and which kind it is of.
#[derive(Default)]
struct Data {
    last: u64,
    theirs: Vec<f64>,
    /// Kind of each number: the same quantity of grains in the same situation.
    kinds: Vec<usize>,
    /// Numbers that are closer than this are the same.
    noise: Vec<f64>,
    contacts: Vec<Vec<Vec<(u32, u32)>>>,
}

/// The first answer of an engine to a case: case and moments.
pub type Observed<'a> = (&'a Case, &'a [Snapshot]);

/// The case, looked at up to this step.
pub(crate) fn until(case: &Case, last: u64) -> Case {
    let steps = case.moments.iter().copied();
    case.at(steps.filter(|step| *step <= last).collect())
}

/// The numbers of a run, in m/s: forces as the velocity that they give a mean grain in a step.
fn numbers(case: &Case, run: &[Snapshot], contacts: &[Vec<(u32, u32)>]) -> Vec<f64> {
    let (dt, start) = (case.model.dt, &case.bodies);
    let mass = start.mass.iter().sum::<f64>() / start.len() as f64;
    let mut all = Vec::new();
    for (moment, ids) in run.iter().zip(contacts) {
        let rows = Table::from(moment).rows();
        let forces = rows.map(|row| {
            let forces = [row.contact.normal_force]
                .into_iter()
                .chain(row.tangential());
            (row.ids(), forces.take(forces_of(case)).collect())
        });
        let forces: BTreeMap<(u32, u32), Vec<f64>> = forces.collect();
        for ids in ids {
            let force = forces.get(ids);
            let missing = || vec![f64::NAN; forces_of(case)];
            let force = force.map_or_else(missing, Clone::clone);
            all.extend(force.iter().map(|force| force * dt / mass));
        }
        if moment.step == 0 {
            continue;
        }
        let bodies = &moment.bodies;
        let time = dt * moment.step as f64;
        for id in 0..bodies.len() {
            all.extend([bodies.vx[id], bodies.vz[id]]);
            if bodies.in_space() {
                all.push(bodies.vy[id]);
            }
            if bodies.rotate() {
                all.push(bodies.spin[id] * bodies.radius[id]);
            }
            if bodies.in_space() && bodies.rotate() {
                let spins = [bodies.spin_x[id], bodies.spin_z[id]];
                all.extend(spins.map(|spin| spin * bodies.radius[id]));
            }
            // Displacements come last.
            let way = [bodies.x[id] - start.x[id], bodies.z[id] - start.z[id]];
            all.extend(way.map(|way| way / time));
            if bodies.in_space() {
                all.push((bodies.y[id] - start.y[id]) / time);
            }
        }
    }
    all
}

/// How many forces are fitted of a contact: those along the normal and the tangent, in space all components of that.
fn forces_of(case: &Case) -> usize {
    if case.bodies.in_space() { 4 } else { 2 }
}

/// How many numbers are fitted of a grain: velocities and spins, and displacements.
fn numbers_of(case: &Case, rotates: bool) -> [usize; 2] {
    let [axes, spins] = if case.bodies.in_space() {
        [3, 3]
    } else {
        [2, 1]
    };
    [axes + if rotates { spins } else { 0 }, axes]
}

/// What cannot be told of a force or a velocity, and of a displacement over its time, m/s.
fn noise(case: &Case, resolution: Resolution) -> [f64; 2] {
    let (model, bodies) = (&case.model, &case.bodies);
    let (radius, mass) = (bodies.radius[0], bodies.mass[0]);
    let kick = model.dt * model.law.usual_stiffness(radius) / mass;
    // A place that is not told gives a force, and a displacement per step.
    let of_force = (resolution.overlap * kick).max(f64::MIN_POSITIVE);
    [of_force, of_force + resolution.position / model.dt]
}

impl Data {
    fn new(observed: &[Observed<'_>], resolution: Resolution, last: u64) -> Self {
        let mut data = Data {
            last,
            ..Data::default()
        };
        for (index, (case, theirs)) in observed.iter().enumerate() {
            let case = until(case, last);
            let own = variant::run(&case, &Variant::default());
            let ids = |snapshot: &Snapshot| snapshot.contacts.iter().map(Contact::ids).collect();
            let contacts: Vec<Vec<(u32, u32)>> = own.iter().map(ids).collect();
            let theirs = &theirs[..own.len().min(theirs.len())];
            data.theirs.extend(numbers(&case, theirs, &contacts));
            let situations = situations(&case, &own);
            let [of_force, of_place] = noise(&case, resolution);
            // Four forces of three kinds of pairs, nine numbers of four situations at most, in each of two moments.
            for (moment, ids) in own.iter().zip(&contacts) {
                let base = KINDS_OF_A_CASE * index + 50 * usize::from(moment.step > 0);
                for (one, _) in ids {
                    let kind = base + 4 * kind_of_pair(&case, *one);
                    data.kinds.extend(kind..kind + forces_of(&case));
                    data.noise.extend(repeat_n(of_force, forces_of(&case)));
                }
                if moment.step > 0 {
                    for situation in &situations {
                        let kind = base + 12 + 9 * situation;
                        let [moving, displaced] = numbers_of(&case, moment.bodies.rotate());
                        data.kinds.extend(kind..kind + moving + displaced);
                        data.noise.extend(repeat_n(of_force, moving));
                        data.noise.extend(repeat_n(of_place, displaced));
                    }
                }
            }
            data.contacts.push(contacts);
        }
        data
    }

    /// How badly a variant fits, the less the better: Σ ln(1 + (r/s)²), s being what cannot be told.
    fn misfit(&self, observed: &[Observed<'_>], variant: &Variant) -> f64 {
        let own = self.of(observed, variant);
        let numbers = self.theirs.iter().zip(&own).zip(&self.noise);
        let residuals = numbers.map(|((their, own), noise)| ((their - own) / noise).abs());
        // A contact that one of the two does not have counts as much as the worst number.
        let residuals = residuals.map(|residual| match residual.is_finite() {
            true => residual,
            false => 1.0e12,
        });
        let logarithms = residuals.map(|residual| (1.0 + residual * residual).ln());
        logarithms.sum()
    }

    fn of(&self, observed: &[Observed<'_>], variant: &Variant) -> Vec<f64> {
        let runs = observed.iter().zip(&self.contacts);
        let numbers = runs.map(|((case, _), contacts)| {
            let case = until(case, self.last);
            numbers(&case, &variant::run(&case, variant), contacts)
        });
        numbers.flatten().collect()
    }
}

/// Touching nothing; after it come touching grains only, a wall, the punch.
pub(crate) const FLYING: usize = 0;
pub(crate) const KINDS: usize = 4;

/// Whether the first of a pair is a grain, a wall, or the punch.
pub(crate) fn kind_of_pair(case: &Case, first: u32) -> usize {
    case.ids().body(first) as usize
}

/// Whether each grain flies, touches grains only, a wall, or the punch.
pub(crate) fn situations(case: &Case, own: &[Snapshot]) -> Vec<usize> {
    let mut all = vec![FLYING; case.bodies.len()];
    for contact in own.iter().flat_map(|snapshot| &snapshot.contacts) {
        let kind = 1 + kind_of_pair(case, contact.id1);
        for id in [contact.id1, contact.id2] {
            if let Some(situation) = all.get_mut(id as usize) {
                *situation = kind.max(*situation);
            }
        }
    }
    all
}

/// Answers of an engine, to be explained.
pub struct Search<'a> {
    observed: &'a [Observed<'a>],
    /// For fits.
    early: Data,
    /// For what a fit is worth.
    late: Data,
}

impl<'a> Search<'a> {
    /// All of one contact law; what a fit is worth is judged by the steps to `until`.
    pub fn new(observed: &'a [Observed<'a>], resolution: Resolution, until: u64) -> Self {
        Search {
            observed,
            early: Data::new(observed, resolution, FITTED_UNTIL),
            late: Data::new(observed, resolution, until),
        }
    }

    /// Fits these constants, from a variant that is known already.
    pub fn fit(&self, known: &Variant, free: &[Constant]) -> Fit {
        let unfitted = |constant: &Constant| Fitted {
            constant: *constant,
            larger: 0.0,
            error: 0.0,
        };
        let mut fit = Fit {
            fitted: free.iter().map(unfitted).collect(),
            ..Fit::known(known.clone())
        };
        for round in 0..ROUNDS {
            if fit.fitted.is_empty() {
                break;
            }
            if round < ROUNDS_WITH_RESPONSES {
                self.respond(&mut fit);
            }
            if round == 0 {
                for at in untold(&fit.responses, &fit.fitted) {
                    fit.tied.push(fit.fitted.remove(at).constant);
                    fit.responses = fit.responses.remove_column(at);
                }
            }
            if !self.improve(&mut fit) && round >= ROUNDS_WITH_RESPONSES {
                break;
            }
        }
        fit
    }

    /// A fit made again with those constants alone that are wrong: the others' errors would be errors of the whole.
    pub fn pruned(&self, known: &Variant, full: &Fit) -> Fit {
        let wrong: Vec<Constant> = full.wrong().iter().map(|fitted| fitted.constant).collect();
        Fit {
            tied: full.tied.clone(),
            ..self.fit(known, &wrong)
        }
    }

    /// A few rounds of a fit for a variant, with the responses of another one.
    pub fn refit(&self, variant: &Variant, like: &Fit) -> Variant {
        let mut fit = Fit {
            variant: variant.clone(),
            ..like.clone()
        };
        for _ in 0..ROUNDS_WITH_RESPONSES {
            self.improve(&mut fit);
        }
        fit.variant
    }

    fn respond(&self, fit: &mut Fit) {
        let own = self.early.of(self.observed, &fit.variant);
        let columns = in_parallel(fit.fitted.len(), |at| {
            let variant = fit.variant.and(fit.fitted[at].constant, CHANGE);
            self.early.of(self.observed, &variant)
        });
        // Rounding alone would say that numbers on which a constant has no effect pin it down.
        fit.responses = DMatrix::from_fn(own.len(), columns.len(), |row, column| {
            let change = columns[column][row] - own[row];
            let is_rounding = change.abs() <= ROUNDED * self.early.noise[row];
            if is_rounding { 0.0 } else { change / CHANGE }
        });
    }

    /// One round; whether it has changed anything.
    fn improve(&self, fit: &mut Fit) -> bool {
        if fit.fitted.is_empty() {
            return false;
        }
        let own = self.early.of(self.observed, &fit.variant);
        let pairs = self.early.theirs.iter().zip(&own);
        let differences: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
        let Some((found, errors)) = weighted(&fit.responses, &differences, &self.early) else {
            return false;
        };
        for (fitted, (larger, error)) in fit.fitted.iter_mut().zip(found.iter().zip(&errors)) {
            let larger = larger.clamp(-LARGEST_STEP, LARGEST_STEP);
            fit.variant = fit.variant.and(fitted.constant, larger);
            fitted.larger = fit.variant.larger[&fitted.constant];
            fitted.error = *error;
        }
        let mut steps = found.iter().zip(&errors);
        steps.any(|(by, error)| by.abs() > 1.0e-3 * error)
    }

    /// How badly a variant fits, the less the better.
    pub fn misfit(&self, variant: &Variant) -> f64 {
        self.late.misfit(self.observed, variant)
    }

    /// How much of what was answered a variant leaves unexplained: Σ ln(r/s) over the numbers that are off by more than s, so many
    /// times what cannot be told. Zero where rounding is left alone.
    pub fn unexplained(&self, variant: &Variant) -> f64 {
        let own = self.late.of(self.observed, variant);
        let residuals = self.late.theirs.iter().zip(&own).zip(&self.late.noise);
        let over = residuals.map(|((their, own), noise)| match (their - own).abs() {
            residual if residual.is_finite() => (residual / (ROUNDING * noise)).max(1.0).ln(),
            _ => NOT_THERE,
        });
        over.sum()
    }

    /// The lengths below and above which contacts of grains may be lost: those that fit best.
    pub fn lost_contacts(&self, known: &Variant) -> Vec<Form> {
        let mut distances = Vec::new();
        for (case, _) in self.observed {
            let start = until(case, 0);
            let bodies = &start.bodies;
            let grains = bodies.len() as u32;
            let run = variant::run(&start, known);
            for contact in run.iter().flat_map(|snapshot| &snapshot.contacts) {
                if contact.id1 < grains {
                    let radii = [contact.id1, contact.id2].map(|id| bodies.radius[id as usize]);
                    distances.push(radii[0] + radii[1] - contact.overlap);
                }
            }
        }
        distances.sort_by(f64::total_cmp);
        if distances.len() < 2 {
            return Vec::new();
        }
        let between = |at: usize| 0.5 * (distances[at] + distances[at + 1]);
        let form: [fn(f64) -> Form; 2] = [Form::LostNear, Form::LostFar];
        let best = form.map(|form| {
            let misfit = |data: &Data, length: f64| {
                let mut variant = known.clone();
                variant.forms.push(form(length));
                data.misfit(self.observed, &variant)
            };
            let (mut low, mut high) = (0, distances.len() - 2);
            while high - low > 1 {
                let step = ((high - low) / PLACES).max(1);
                let places: Vec<usize> = (low..=high).step_by(step).collect();
                let misfit_at = |at: usize| misfit(&self.early, between(places[at]));
                let best = least(places.len(), misfit_at).map_or(low, |at| places[at]);
                (low, high) = (best.saturating_sub(step).max(low), (best + step).min(high));
                if step == 1 {
                    low = best;
                    break;
                }
            }
            // Any length between two neighbours loses the same contacts at the start, and not in the steps after it.
            let (mut from, mut to) = (distances[low], distances[low + 1]);
            for _ in 0..ZOOMS {
                let part = (to - from) / PLACES as f64;
                let lengths: Vec<f64> = (1..PLACES)
                    .map(|index| from + part * index as f64)
                    .collect();
                let misfit_at = |at: usize| misfit(&self.late, lengths[at]);
                let best = least(lengths.len(), misfit_at).map_or(from, |at| lengths[at]);
                (from, to) = (best - part, best + part);
            }
            form(0.5 * (from + to))
        });
        best.to_vec()
    }
}

/// A length is searched for among so many places at a time.
const PLACES: usize = 8;
/// … and then so often among as many between the two nearest.
const ZOOMS: usize = 4;

/// The first of so many at which this is least.
fn least(count: usize, value: impl Fn(usize) -> f64 + Sync) -> Option<usize> {
    let all = in_parallel(count, value);
    (0..count).min_by(|a, b| all[*a].total_cmp(&all[*b]))
}

/// Which columns to leave out so that the others can be told, highest index first: of constants that cannot be told apart
/// the one that says most of an engine stays.
fn untold(responses: &DMatrix<f64>, free: &[Fitted]) -> Vec<usize> {
    let mut kept: BTreeSet<usize> = (0..free.len()).collect();
    let sound: Vec<usize> = (0..responses.nrows())
        .filter(|row| responses.row(*row).iter().all(|value| value.is_finite()))
        .collect();
    let column = |at| DVector::from_fn(sound.len(), |row, _| responses[(sound[row], at)]);
    let columns: Vec<DVector<f64>> = (0..free.len()).map(column).collect();
    let strongest = columns
        .iter()
        .map(|column| column.norm())
        .fold(0.0, f64::max);
    kept.retain(|at| columns[*at].norm() > TOLD * strongest);
    loop {
        let indices: Vec<usize> = kept.iter().copied().collect();
        if indices.is_empty() {
            break;
        }
        let correlation = DMatrix::from_fn(indices.len(), indices.len(), |a, b| {
            columns[indices[a]].dot(&columns[indices[b]])
                / (columns[indices[a]].norm() * columns[indices[b]].norm())
        });
        let eigen = correlation.symmetric_eigen();
        let values = eigen.eigenvalues.iter().enumerate();
        let least = values.min_by(|a, b| a.1.total_cmp(b.1));
        let Some((which, _)) = least.filter(|(_, value)| **value < TOLD) else {
            break;
        };
        let direction = eigen.eigenvectors.column(which);
        // Only a constant that takes part in the direction makes the others known.
        let in_it = |at: usize| direction[at].abs() > 0.1;
        let given_up = (0..indices.len()).filter(|at| in_it(*at));
        match given_up.min_by_key(|at| free[indices[*at]].constant.kept()) {
            Some(at) => kept.remove(&indices[at]),
            None => break,
        };
    }
    let all = (0..free.len()).rev();
    all.filter(|at| !kept.contains(at)).collect()
}

/// Least squares with weights; the estimates and their standard errors. None where they cannot be solved for.
fn weighted(
    responses: &DMatrix<f64>,
    differences: &[f64],
    data: &Data,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let columns = responses.ncols();
    let scale = (0..columns).map(|column| {
        let response = responses.column(column);
        let finite = response.iter().filter(|value| value.is_finite());
        let sum: f64 = finite.map(|value| value * value).sum();
        sum.sqrt().max(f64::MIN_POSITIVE)
    });
    let scale: Vec<f64> = scale.collect();
    // Row by row in memory, as they are walked through.
    let mut rows: Vec<usize> = Vec::new();
    let mut scaled: Vec<f64> = Vec::new();
    for (row, difference) in differences.iter().enumerate() {
        let values = (0..columns).map(|at| responses[(row, at)] / scale[at]);
        if difference.is_finite() && values.clone().all(f64::is_finite) {
            rows.push(row);
            scaled.extend(values);
        }
    }
    let mut found = DVector::<f64>::zeros(columns);
    let mut errors = Vec::new();
    for _ in 0..REWEIGHTED {
        let left = rows.iter().zip(scaled.chunks_exact(columns));
        let left = left.map(|(row, values)| {
            let by: f64 = values
                .iter()
                .zip(&found)
                .map(|(value, found)| value * found)
                .sum();
            differences[*row] - by
        });
        let left: Vec<f64> = left.collect();
        let mut by_kind = vec![Vec::new(); KINDS_OF_A_CASE * data.contacts.len()];
        for (row, left) in rows.iter().zip(&left) {
            by_kind[data.kinds[*row]].push(left.abs());
        }
        let of_kind = |residuals: &Vec<f64>| median(residuals).unwrap_or(0.0);
        let scales: Vec<f64> = by_kind.iter().map(of_kind).collect();
        let mut normal = DMatrix::<f64>::zeros(columns, columns);
        let mut right = DVector::<f64>::zeros(columns);
        let mut spread = DMatrix::<f64>::zeros(columns, columns);
        for ((row, left), values) in rows.iter().zip(&left).zip(scaled.chunks_exact(columns)) {
            let s = scales[data.kinds[*row]].max(data.noise[*row]);
            let weight = 1.0 / (1.0 + (left / s) * (left / s)) / (s * s);
            for a in 0..columns {
                if values[a] == 0.0 {
                    continue;
                }
                right[a] += weight * values[a] * left;
                for b in 0..=a {
                    let product = weight * values[a] * values[b];
                    normal[(a, b)] += product;
                    spread[(a, b)] += product * weight * left * left;
                }
            }
        }
        normal.fill_upper_triangle_with_lower_triangle();
        spread.fill_upper_triangle_with_lower_triangle();
        let inverse = normal.try_inverse()?;
        let step = &inverse * right;
        found += &step;
        // What rounding leaves open, and the sandwich: weights that depend on the differences, which are of many sizes.
        let covariance = &inverse + &inverse * spread * &inverse;
        let error = |at: usize| covariance[(at, at)].max(0.0).sqrt() / scale[at];
        errors = (0..columns).map(error).collect();
        if step.norm() <= SETTLED * found.norm() {
            break;
        }
    }
    let found = (0..columns).map(|at| found[at] / scale[at]).collect();
    Some((found, errors))
}
