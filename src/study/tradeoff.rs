//! Cost against error: what each way of running the paper's scene costs, and what it does to the results.

pub mod document;
pub mod judge;
pub mod plan;

use std::borrow::Cow;
use std::path::Path;

use crate::checks::Check;
use crate::engine::EngineError;
use crate::engine::exec::{Description, Part, missing_for_scene};
use crate::study::folder::StudyFolder;
use crate::study::member::{Cost, Member, Members, values};
use crate::study::realization::{Engines, Runner, Setting, Specification, sound};
use crate::study::tradeoff::judge::{
    Convergence, Judgement, QUANTITIES, convergence, judge, outcome,
};
use crate::study::tradeoff::plan::{FAST, FIRST_CONFIRMATORY, FRICTIONAL, Plan, is_frictional};
use crate::study::{Judged, Outline, Study, StudyError};
use evidence::Interval;
use evidence::moments::{mean, median, standard_deviation};
use evidence::t_test::Finding;
use grains::generate::initial_bodies;
use grains::task::{Task, Until};

use serde::{Deserialize, Serialize};

impl Study for Plan {
    const KIND: &'static str = "tradeoff";
    type Row = Member;

    fn count(&self) -> u64 {
        self.tasks().len() as u64
    }

    fn check(&self) -> Result<(), String> {
        sound(self.settings())
    }

    fn runner(&self, task: u64) -> Runner {
        self.task(task).0.specification.runner
    }

    fn identity(&self, task: u64) -> String {
        let (setting, cloud) = self.task(task);
        format!("{} {cloud}", setting.specification.digest())
    }

    fn run(&self, task: u64, engines: &Engines, work: &Path) -> Result<Member, EngineError> {
        let (setting, cloud) = self.task(task);
        let keep = |key: &str| QUANTITIES.iter().any(|quantity| quantity.key == key);
        Member::run(&setting.specification, cloud, engines, work, keep)
    }

    fn belongs(&self, task: u64, row: &Member) -> bool {
        let (setting, cloud) = self.task(task);
        row.realization == cloud && row.specification == setting.specification.digest()
    }

    fn same(first: &Member, second: &Member) -> bool {
        let timeless = |member: &Member| Member {
            cost: None,
            ..member.clone()
        };
        timeless(first) == timeless(second)
    }

    fn outline(&self, row: &Member) -> Outline {
        let mut settings = self.settings().into_iter();
        let setting = settings.find(|setting| setting.specification.digest() == row.specification);
        row.outline(setting.map_or("", |setting| &setting.id))
    }

    fn judge(folder: &StudyFolder<Self>) -> Result<Judged, StudyError> {
        let members: Members = folder.rows()?.into_iter().collect();
        let external = folder
            .plan
            .program
            .as_ref()
            .map(|program| &program.described);
        let convergence = convergence().map_err(EngineError::Native)?;
        let record = Tradeoff::of(&folder.plan.study, &members, convergence, external);
        Judged::of(Self::KIND, &record, record.document())
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Costs {
    /// Median over the screening realizations of the processor time of the whole protocol, s.
    pub cpu_seconds: f64,
    /// Least and most, s.
    pub range: [f64; 2],
    pub pour_steps: f64,
    pub load_steps: f64,
    /// Median time of measuring, s.
    pub measuring_seconds: f64,
}

/// A method with its costs and its errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    pub method: Setting,
    /// Digest of the specification, as in the rows.
    pub digest: String,
    /// None if nothing was made.
    pub costs: Option<Costs>,
    /// On the screening realizations.
    pub screened: Judgement,
    /// On realizations of its own, where it is a candidate.
    pub confirmed: Option<Judgement>,
    /// The id of the cheapest method with at most its cost and at most its error.
    pub dominated_by: Option<String>,
    /// Whether that error is smaller beyond both intervals.
    pub clearly: bool,
    /// Realizations that are wanted and are not there.
    pub missing: u64,
    /// What an external engine lacks, and what it says of itself.
    pub notes: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    pub key: Cow<'static, str>,
    pub title: Cow<'static, str>,
    pub unit: Cow<'static, str>,
    /// Of the reference over all of its realizations, with the number of them.
    pub reference: Option<Reference>,
    /// In its unit.
    pub margin: Option<f64>,
    /// Why this margin, or why none.
    pub reason: Cow<'static, str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    pub mean: f64,
    pub deviation: f64,
    pub count: usize,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tradeoff {
    pub scene_digest: String,
    pub grains: u32,
    /// Screening realizations.
    pub screening: u64,
    /// Realizations of the tests of equivalence.
    pub confirmatory: u64,
    pub quantities: Vec<Quantity>,
    pub reference: Point,
    /// The reference against itself on other clouds: the error that chance alone gives.
    pub null_comparison: Judgement,
    pub points: Vec<Point>,
    /// Exact cases.
    pub convergence: Vec<Convergence>,
    /// Id of the cheapest candidate that was shown to be equivalent.
    pub recommended: Option<String>,
}

impl Tradeoff {
    /// Of these members; `external` is what the external engine says of itself.
    pub fn of(
        plan: &Plan,
        members: &Members,
        convergence: Vec<Convergence>,
        external: Option<&Description>,
    ) -> Self {
        let point = |method: &Setting| Point::of(method, plan, members, external);
        let reference = point(&plan.reference);
        let mut points: Vec<Point> = plan.methods.iter().map(point).collect();
        dominance(&mut points);
        let first = &plan.reference.specification;
        Tradeoff {
            scene_digest: first.scene.digest(),
            grains: first.scene.particles.count,
            screening: plan.screening,
            confirmatory: plan.confirmatory,
            quantities: quantities(&members.of(&plan.reference)),
            null_comparison: null_comparison(plan, &plan.reference, members),
            recommended: recommended(&points).map(|point| point.method.id.clone()),
            reference,
            points,
            convergence,
        }
    }

    pub fn point(&self, id: &str) -> Option<&Point> {
        self.points.iter().find(|point| point.method.id == id)
    }

    /// That the fast protocol is equivalent, where that was tested.
    pub fn checks(&self) -> Vec<Check> {
        let default = self.point(FAST);
        let Some(confirmed) = default.and_then(|point| point.confirmed.as_ref()) else {
            return Vec::new();
        };
        let check = Check::of_words(
            "tradeoff/default-is-equivalent",
            "the fast protocol against the reference",
            outcome(confirmed.finding()),
            &confirmed.not_shown().join(", "),
        );
        let n = confirmed.clouds as u64;
        vec![Check { n, ..check }.judged_by(
            "two one-sided t tests at 5 % in every quantity with a margin",
            "margins that were set before the runs",
        )]
    }
}

/// Why an external engine cannot run the specification, where it cannot, and what it says of itself. One that has all but
/// a punch pours and settles.
fn notes(specification: &Specification, engine: &Description) -> Vec<String> {
    let mut task = Task::whole(initial_bodies(&specification.scene));
    task.until = Until::EndOfSettling;
    let missing = missing_for_scene(engine, &specification.scene, &task);
    let lacks = format!("{} has no {}", engine.name, Part::list(&missing));
    let says = engine.approximations.iter();
    let says = says.map(|says| format!("it says of itself: {says}"));
    let lacks = (!missing.is_empty()).then_some(lacks);
    lacks.into_iter().chain(says).collect()
}

impl Point {
    fn of(
        method: &Setting,
        plan: &Plan,
        members: &Members,
        external: Option<&Description>,
    ) -> Self {
        let screening = Setting {
            clouds: vec![method.clouds[0]],
            ..method.clone()
        };
        let wanted = method.realizations().count() as u64;
        let reference = plan.reference_of(method);
        let judged = |[first, last]: [u64; 2]| {
            let sides = [(reference, first), (method, first)];
            let pairs = pairs(members, last + 1 - first, sides);
            judge(&pairs, comparable(method, reference))
        };
        let is_reference = method == reference;
        let tested = method.clouds.get(1).filter(|_| !is_reference);
        let screened = match is_reference && *method != plan.reference {
            // It stands among the methods, with the error that chance alone gives.
            true => null_comparison(plan, method, members),
            false => judged(method.clouds[0]),
        };
        let engine = external.filter(|_| method.specification.runner == Runner::External);
        Point {
            costs: costs(&members.of(&screening)),
            screened,
            confirmed: tested.map(|clouds| judged(*clouds)),
            dominated_by: None,
            clearly: false,
            missing: wanted - members.of(method).len() as u64,
            notes: engine.map_or(Vec::new(), |engine| notes(&method.specification, engine)),
            digest: method.specification.digest(),
            method: method.clone(),
        }
    }

    /// Its cost, s, and its error, where it can be dominated and dominate.
    pub fn place(&self) -> Option<(f64, Interval)> {
        let point = Some(self).filter(|point| point.method.id != FRICTIONAL)?;
        Some((point.costs?.cpu_seconds, point.screened.error()?))
    }
}

/// A point is dominated by the cheapest one with the same reference that costs no more and errs no more, by the estimates.
/// The reference with friction takes no part.
fn dominance(points: &mut [Point]) {
    let places = points.iter().enumerate();
    let places = places.filter_map(|(index, point)| Some((index, point.place()?)));
    let places: Vec<(usize, (f64, Interval))> = places.collect();
    for (index, (cost, error)) in &places {
        let better = places.iter().filter(|(other, (c, other_error))| {
            let alike = [*other, *index].map(|number| is_frictional(&points[number].method));
            other != index
                && alike[0] == alike[1]
                && c <= cost
                && other_error.estimate <= error.estimate
        });
        let better = better.min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        if let Some((other, (_, smaller))) = better {
            points[*index].dominated_by = Some(points[*other].method.id.clone());
            points[*index].clearly = smaller.high < error.low;
        }
    }
}

/// The cheapest candidate that is equivalent on its own realizations.
fn recommended(points: &[Point]) -> Option<&Point> {
    let equivalent = points.iter().filter_map(|point| {
        let finding = point.confirmed.as_ref()?.finding();
        let seconds = point.costs?.cpu_seconds;
        (finding == Finding::Equivalent).then_some((point, seconds))
    });
    let cheapest = equivalent.min_by(|a, b| a.1.total_cmp(&b.1));
    cheapest.map(|(point, _)| point)
}

/// Members of two settings on so many clouds, each from a first one on.
fn pairs<'a>(
    members: &'a Members,
    count: u64,
    [one, other]: [(&Setting, u64); 2],
) -> Vec<(&'a Member, &'a Member)> {
    let on =
        |(setting, first): (&Setting, u64), next| members.get(&setting.specification, first + next);
    let pair = |next| on(one, next).zip(on(other, next));
    (0..count).filter_map(pair).collect()
}

/// A reference against itself on other clouds.
fn null_comparison(plan: &Plan, reference: &Setting, members: &Members) -> Judgement {
    let sides = [1, FIRST_CONFIRMATORY].map(|first| (reference, first));
    judge(&pairs(members, plan.screening, sides), |_| true)
}

fn costs(members: &[&Member]) -> Option<Costs> {
    let column = |figure: fn(&Member, Cost) -> f64| -> Vec<f64> {
        let all = members.iter();
        all.filter_map(|member| Some(figure(member, member.cost?)))
            .collect()
    };
    let seconds = column(|_, cost| cost.cpu_seconds);
    Some(Costs {
        cpu_seconds: median(&seconds)?,
        range: [
            seconds.iter().copied().fold(f64::INFINITY, f64::min),
            seconds.iter().copied().fold(0.0, f64::max),
        ],
        pour_steps: mean(&column(|member, _| member.pour_steps as f64)),
        load_steps: mean(&column(|member, _| member.load_steps as f64)),
        measuring_seconds: median(&column(|_, cost| cost.measuring_seconds))?,
    })
}

fn quantities(reference: &[&Member]) -> Vec<Quantity> {
    let one = |quantity: &judge::Quantity| {
        let values = values(reference, quantity.key);
        let found = (values.len() > 1).then(|| Reference {
            mean: mean(&values),
            deviation: standard_deviation(&values),
            count: values.len(),
        });
        Quantity {
            key: quantity.key.into(),
            title: quantity.title.into(),
            unit: quantity.unit.into(),
            margin: (quantity.margin.zip(found)).map(|(margin, found)| margin.absolute(found.mean)),
            reference: found,
            reason: quantity.reason.into(),
        }
    };
    QUANTITIES.iter().map(one).collect()
}

/// Heights can be compared only between beds of as many grains over the width.
fn comparable(method: &Setting, reference: &Setting) -> impl Fn(&str) -> bool {
    let load = |setting: &Setting| {
        let scene = &setting.specification.scene;
        f64::from(scene.particles.count) / scene.container.width
    };
    let same_depth = (load(method) / load(reference) - 1.0).abs() < 1.0e-9;
    move |key| same_depth || !key.starts_with("settled.height.")
}
