//! The numbers that two engines compute with: the parameters of a scene as each says that it uses them, and how each rounds.
//!
//! Parameters are asked of a few grains that touch each other, a wall and the punch. For rounding, higher precision is the truth:
//! YADE in 128-bit arithmetic runs the same case from the same numbers, and the distance from it is the rounding error of an
//! engine. A third precision tells rounding from everything else: an error that is rounding falls by 2¹¹ from 53 to 64 bits, an
//! error of the method does not.

use serde::Serialize;

use crate::checks::{Check, Outcome};
use crate::engine::ProgramError;
use crate::engine::yade::{self, run_cases, sibling};
use crate::files::work_folder;
use crate::suite::{Figures, Grain, Track, case, cross_code, punch};
use grains::model::Model;
use grains::native::{self, CaseOptions, NativeError, run_case};
use grains::scene::{Scene, paper_scene};
use grains::tables::Snapshot;
use grains::task::{Case, Effective};

/// The most that the parameters of two engines may differ, relative.
pub const TOLERANCE: f64 = 1.0e-14;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Lasting and unique in its scene.
    pub id: String,
    /// Between what, or of what. Files call it `of`.
    #[serde(rename = "of")]
    pub bodies: String,
    pub symbol: &'static str,
    pub unit: &'static str,
    pub value: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterPair {
    /// As the native engine uses it.
    pub native: Parameter,
    /// In YADE; none if YADE does not tell it.
    pub yade: Option<f64>,
    /// |native − YADE| over the larger of the two; none if there is none in YADE.
    pub difference: Option<f64>,
}

impl ParameterPair {
    pub fn agrees(&self) -> bool {
        self.difference
            .is_some_and(|difference| difference <= TOLERANCE)
    }
}

/// Grains of the smallest, the mean and the largest size that touch each other, the left wall and the
/// punch, in the scene's model.
pub fn probe(scene: &Scene) -> Case {
    let mean = 0.5 * scene.particles.mean_diameter;
    let [small, large] = [-1.0, 1.0].map(|sign| mean * (1.0 + sign * scene.particles.dispersion));
    let grain = |position: [f64; 2], radius: f64| {
        let mut grain = Grain::disc(position, radius, 0.0);
        grain.mass = scene.grain_mass(radius);
        grain.inertia = scene.grain_inertia(radius, grain.mass);
        grain
    };
    // Touching by a hundredth of a radius, floors of four radii apart.
    let floor = |index: usize| (4.0 * index as f64 + 3.0) * large;
    let touch = 0.99;
    let (axis, mut grains) = (scene.punch_axis(), Vec::new());
    for (index, radius) in [small, mean, large].into_iter().enumerate() {
        grains.push(grain([touch * radius, floor(index)], radius));
    }
    let pairs = [(small, large), (mean, mean), (large, large)];
    for (index, (low, high)) in pairs.into_iter().enumerate() {
        let z = floor(3 + 2 * index);
        grains.push(grain([axis, z], low));
        grains.push(grain([axis, z + touch * (low + high)], high));
    }
    let bottom = floor(10);
    grains.push(grain([axis, bottom - touch * mean], mean));
    let half_extents = [scene.loading.half_width, 0.5 * scene.loading.punch_height];
    let mut case = case("parameters", Model::of(scene), &grains, vec![0]);
    case.punch = Some(punch(axis, bottom, half_extents, -scene.loading.speed));
    case
}

pub fn of_native(scene: &Scene) -> Result<Vec<Parameter>, NativeError> {
    let case = probe(scene);
    Ok(list(&case, &native::effective(&case, None)?))
}

/// What YADE says it uses; `work` is an empty folder.
pub fn of_yade(
    scene: &Scene,
    options: &yade::Options,
    work: &std::path::Path,
) -> Result<Vec<Parameter>, ProgramError> {
    let case = probe(scene);
    let (cases, _) = yade::run_cases(&[&case], options, work, &mut ())?;
    let first = cases.first();
    Ok(first.map_or(Vec::new(), |answer| list(&case, &answer.effective)))
}

/// The scenes whose parameters the suite compares: the paper's, and the same with friction and dashpots.
pub fn scenes() -> [(&'static str, Scene); 3] {
    [
        ("paper", paper_scene(1, 5000)),
        ("friction", cross_code::rough(5000)),
        ("dashpot", cross_code::viscous(5000)),
    ]
}

/// A scene's probe, and what YADE says of it.
#[derive(Debug, Clone)]
pub struct Answer {
    pub name: &'static str,
    /// The grains that were asked of.
    pub probe: Case,
    pub yade: Effective,
}

/// A check for each scene, the largest relative difference of its parameters, from the native engine with these options against
/// YADE's answers.
pub fn checks(
    answers: &[Answer],
    options: impl Into<CaseOptions>,
) -> Result<Vec<Check>, NativeError> {
    let options = options.into();
    let mut figures = Figures::default();
    figures.because("the same formulas of the same numbers");
    for Answer { name, probe, yade } in answers {
        let native = native::effective(probe, options)?;
        let pairs = side_by_side(list(probe, &native), &list(probe, yade));
        let differences = pairs
            .iter()
            .map(|parameter| parameter.difference.unwrap_or(f64::INFINITY));
        let largest = differences.fold(0.0, f64::max);
        let count = pairs.len();
        let what =
            format!("{name}: {name} scene: largest relative difference of {count} parameters, 1");
        figures.is(&what, largest, 0.0, TOLERANCE);
    }
    Ok(figures.done())
}

pub fn side_by_side(native: Vec<Parameter>, yade: &[Parameter]) -> Vec<ParameterPair> {
    let pair = |native: Parameter| {
        let same = |other: &&Parameter| other.id == native.id;
        let yade = yade.iter().find(same).map(|other| other.value);
        ParameterPair {
            difference: yade.map(|yade| relative(native.value, yade)),
            native,
            yade,
        }
    };
    native.into_iter().map(pair).collect()
}

/// Passed if all parameters agree; none if there are none.
pub fn outcome(pairs: &[ParameterPair]) -> Option<Outcome> {
    let agree = pairs.iter().all(ParameterPair::agrees);
    (!pairs.is_empty()).then_some(Outcome::pass_if(agree))
}

pub fn pair_checks(pairs: &[ParameterPair]) -> Vec<Check> {
    let check = |pair: &ParameterPair| {
        let (native, yade) = (&pair.native, pair.yade.unwrap_or(f64::NAN));
        let found = pair.yade.map_or("YADE does not tell it", |_| "");
        let id = format!("parameters/{}", native.id);
        let what = format!("{} of {}", native.symbol, native.bodies);
        let check = Check::of_words(id, &what, Outcome::pass_if(pair.agrees()), found);
        let method = "the native engine's parameter against the one that YADE says it uses";
        let basis = "the same formulas of the same numbers, which may round once";
        let check = check.with_limits(native.value, yade, Some(TOLERANCE * yade.abs()));
        let mut check = check.judged_by(method, basis);
        native.unit.clone_into(&mut check.unit);
        check
    };
    pairs.iter().map(check).collect()
}

fn relative(a: f64, b: f64) -> f64 {
    if a == b {
        0.0
    } else {
        (a - b).abs() / a.abs().max(b.abs())
    }
}

fn list(case: &Case, effective: &Effective) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    let mut add = |id: &str, bodies: &str, symbol: &'static str, unit, value| {
        parameters.push(Parameter {
            id: format!("{id}/{symbol}"),
            bodies: bodies.to_owned(),
            symbol,
            unit,
            value,
        });
    };
    for (symbol, unit, value) in [
        ("dt", "s", effective.dt),
        ("alpha", "1", effective.alpha),
        ("g_x", "m/s²", effective.gravity[0]),
        ("g_z", "m/s²", effective.gravity[1]),
    ] {
        add("everything", "everything", symbol, unit, value);
    }
    let grain = |id: usize| {
        let radius = case.bodies.radius.get(id).copied().unwrap_or(f64::NAN);
        format!("grain {id}, R {:.4} mm", 1e3 * radius)
    };
    for (id, mass) in effective.mass.iter().enumerate() {
        let (bodies, id_of) = (grain(id), format!("grain-{id}"));
        add(&id_of, &bodies, "m", "kg", *mass);
        if let Some(inertia) = effective.inertia.get(id) {
            add(&id_of, &bodies, "I", "kg·m²", *inertia);
        }
    }
    let walls = case.bodies.len()..case.bodies.len() + case.model.walls_and_obstacles() as usize;
    let mut contacts = effective.contacts.clone();
    contacts.sort_by_key(|contact| (contact.id1, contact.id2));
    for contact in contacts {
        let (one, other) = match contact.id1 as usize {
            id if id < walls.start => (format!("grain-{id}"), grain(id)),
            id if walls.contains(&id) => {
                let wall = id - walls.start;
                (format!("wall-{wall}"), format!("wall {wall}"))
            }
            _ => ("punch".to_owned(), "punch".to_owned()),
        };
        let bodies = format!("{other}, and {}", grain(contact.id2 as usize));
        let id = format!("{one}-and-grain-{}", contact.id2);
        add(&id, &bodies, "k_n", "N/m", contact.k_n);
        if let Some(k_s) = contact.k_s {
            add(&id, &bodies, "k_s", "N/m", k_s);
            add(&id, &bodies, "tan_phi", "1", contact.tan_phi);
        }
        add(&id, &bodies, "c_n", "N·s/m", contact.c_n);
    }
    parameters
}

/// Steps at which the error is taken.
const MOMENTS: [u64; 7] = [0, 300, 600, 1_000, 1_500, 2_000, 3_000];

/// Beyond this error, over a radius, neighbours are no longer the same and errors say nothing.
const SATURATED: f64 = 1.0e-3;

/// The tables hold doubles; errors over a radius below this are their own rounding.
const RESOLVED: f64 = 1.0e-13;

/// Bits that long double has more than double.
const MORE_BITS: f64 = 11.0;

/// How far log₂ of a ratio of two largest errors may scatter.
const SCATTER: f64 = 2.5;

/// Errors at one moment, largest distance of a centre from its true place over the grain's radius.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Steps since the start.
    pub step: u64,
    pub native: f64,
    /// YADE's, in double precision.
    pub yade: f64,
    /// YADE's, in long double.
    pub long_double: f64,
}

/// Fewer grains collide too seldom for errors to be seen growing.
const FEWEST_GRAINS: u32 = 500;

/// The case: spinning grains with friction, poured; 500 at least.
pub fn precision_case(grains: u32) -> Case {
    let grains = grains.max(FEWEST_GRAINS);
    let name = format!("precision {grains}");
    cross_code::poured(name, &cross_code::rough(grains), MOMENTS.to_vec())
}

#[derive(Debug, Clone)]
pub struct Precisions {
    pub case: Case,
    double: Track,
    long_double: Track,
    truth: Track,
}

pub fn run_precisions(case: Case, options: &yade::Options) -> Result<Precisions, ProgramError> {
    let run = |build: Option<&str>| -> Result<Track, ProgramError> {
        let mut options = options.clone();
        if let Some(name) = build {
            options.program = Some(sibling(options.program.as_deref(), name)?);
        }
        let work = work_folder()?;
        let (cases, _) = run_cases(&[&case], &options, work.path(), &mut ())?;
        Ok(cases.into_iter().flat_map(|case| case.track).collect())
    };
    Ok(Precisions {
        double: run(None)?,
        long_double: run(Some("yade-longdouble"))?,
        truth: run(Some("yade-float128"))?,
        case,
    })
}

impl Precisions {
    /// The errors of the native engine with these options, and YADE's.
    pub fn errors(&self, options: impl Into<CaseOptions>) -> Result<Vec<Errors>, NativeError> {
        let native = run_case(&self.case, options)?;
        let largest = |snapshot: &Snapshot, truth| apart(snapshot, truth).fold(0.0, f64::max);
        let moments = self.truth.iter().zip(&native);
        let in_yade = self.double.iter().zip(&self.long_double);
        let errors = moments.zip(in_yade).map(|((truth, native), pair)| Errors {
            step: truth.step,
            native: largest(native, truth),
            yade: largest(pair.0, truth),
            long_double: largest(pair.1, truth),
        });
        Ok(errors.collect())
    }
}

/// How far each grain is off over its radius.
pub fn apart(snapshot: &Snapshot, truth: &Snapshot) -> impl Iterator<Item = f64> {
    let (bodies, truth) = (&snapshot.bodies, &truth.bodies);
    let apart = |id: usize| (bodies.x[id] - truth.x[id]).hypot(bodies.z[id] - truth.z[id]);
    (0..bodies.len()).map(move |id| apart(id) / bodies.radius[id])
}

pub fn precision_checks(errors: &[Errors]) -> Vec<Check> {
    let mut figures = Figures::default();
    let mut compared = 0;
    for error in errors {
        let step = error.step;
        figures.because("both round alike");
        let what =
            format!("step-{step}/same-rounding: step {step}: native error less YADE's over R, 1");
        figures.is(&what, error.native - error.yade, 0.0, 0.0);
        if error.long_double > RESOLVED && error.native < SATURATED {
            compared += 1;
            figures.because("11 bits more; two largest errors of many scatter by a few times");
            let what = format!(
                "step-{step}/bits: step {step}: log2 of the error in double over that in long double, 1"
            );
            let bits = (error.native / error.long_double).log2();
            figures.is(&what, bits, MORE_BITS, SCATTER);
        }
    }
    figures.because("without one nothing says that the errors are rounding");
    let value = if compared > 0 { 0.0 } else { f64::NAN };
    let what = "compared: moments at which precisions were compared; 0 if any, 1";
    figures.is(what, value, 0.0, 0.0);
    figures.done()
}
