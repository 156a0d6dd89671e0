//! The claims for people, and the data of their plots.

use std::borrow::Cow;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::laws::{self, Contest};
use super::sample::{Moment, stress};
use super::{Claim, Claims, Judged, Row, Verdict, Volume, Volumes, counted};
use crate::checks::{Check, Outcome};
use crate::document::plot::Point;
use crate::document::table::rounded;
use crate::document::{Axis, Cell, Colour, Document, Plot, Section, Shape, Table};
use crate::paper::published::{HEIGHTS, POINTS, POROSITIES, published};
use crate::paper::recomputed::unrounded;
use crate::study::campaign::Member;
use crate::study::figures::Distribution;
use crate::study::realization::ending_in_words;
use evidence::Interval;
use evidence::distribution::Family;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Σ_zz under the load (Figure 5), σ_zz under gravity alone, σ_xx and σ_xz under the load, each at O, A, B.
    pub distributions: Vec<Distribution>,
    pub volumes: Vec<Volumes>,
    /// Laws against each other.
    pub contests: Vec<Contest>,
    /// Height and porosity of every settled bed, by one definition each.
    pub plane: Vec<Cloud>,
    /// Solid area over width, m: n = 1 − this/H.
    pub solid: f64,
}

/// Beds in the plane of height and porosity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cloud {
    /// How both are taken.
    pub definition: Cow<'static, str>,
    pub beds: Vec<[f64; 2]>,
}

/// Distributions at O, A and B that belong together: `groups.json`, read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Group {
    /// Of their files.
    name: &'static str,
    title: &'static str,
    moment: Moment,
    /// End of the measured quantity's key.
    key: &'static str,
    quantity: &'static str,
    unit: &'static str,
}

static GROUPS: LazyLock<Vec<Group>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("groups.json")).expect("it is a list of groups")
});

pub(super) fn data(members: &[Member], volumes: Vec<Volumes>, solid: f64) -> Figures {
    let distribution = |group: &Group, point: &'static str| {
        let family = match group.name {
            "shear" => Family::Laplace,
            _ => Family::Gamma,
        };
        // Of the other components there is no theory.
        let theory = unrounded(point).and_then(|parts| match group.name {
            "figure5" => Some(parts.extensive),
            "figure5-gravity" => Some(parts.weight),
            _ => None,
        });
        let values = stress(members, group.moment, point, group.key);
        let words = [group.name, group.quantity, group.unit];
        Distribution::new(words, point, theory, family, &values)
    };
    let cloud = |definition: &'static str, height: &str, porosity: &str| {
        let beds = members.iter().filter_map(|member| {
            let value = |key: &str| member.measured.get(key).copied();
            Some([value(height)?, value(porosity)?])
        });
        Cloud {
            definition: definition.into(),
            beds: beds.collect(),
        }
    };
    let window = "mean surface, porosity in a window";
    let both = |definition, index: usize| cloud(definition, HEIGHTS[index].0, POROSITIES[index].0);
    Figures {
        distributions: GROUPS
            .iter()
            .flat_map(|group| POINTS.map(|point| distribution(group, point)))
            .collect(),
        volumes,
        contests: laws::contests(members),
        plane: vec![
            both("mean surface for both", 0),
            both("highest grain for both", 1),
            both("twice the centre of mass for both", 2),
            cloud(window, HEIGHTS[0].0, POROSITIES[3].0),
        ],
        solid,
    }
}

impl Claim {
    /// The verdict in words, also where there is none.
    pub(super) fn word(&self) -> &'static str {
        match (self.verdict, self.not_computable()) {
            (Some(verdict), _) => verdict.words(),
            (None, Some(_)) => "not computable",
            (None, None) => "undecided",
        }
    }

    /// Whether there is a verdict: which one is a finding, not a failure.
    fn check(&self) -> Check {
        let outcome = Outcome::pass_or_skip(self.verdict.is_some());
        let found = format!("{}. {}", self.word(), self.reading);
        let quantity = format!("decided, either way: {}", self.statement);
        let packings = self.rows.iter().map(|row| row.packings as u64);
        Check {
            n: packings.max().unwrap_or(0),
            ..Check::of_words(format!("claims/{}", self.id), &quantity, outcome, &found)
        }
        .judged_by(&self.decided_by, &self.place)
        .required()
    }
}

const HOW: &str = "A claim is decided by the size of an effect against a limit that was set beforehand, with one number a \
    realization: within the limits where the 90 % interval lies within them (two one-sided tests at 5 %), beyond them where it lies \
    wholly outside, and undecided where it holds a limit or there are fewer than 30 realizations. p-values stand after the effects; with many realizations nearly everything has a \
    small one. A dash stands for a number that cannot be had, as a gamma shape where some stresses are below zero. A claim that does not hold here does not hold \
    for this scene; the paper leaves choices open, and the study of candidates says what hangs on them. Among the checks a claim that could be \
    decided passes, whatever its verdict.";

/// What a verdict hangs on, in words.
fn named(row: &Row) -> String {
    match row.unit.as_ref() {
        "1" => row.what.clone(),
        unit => format!("{}, {unit}", row.what),
    }
}

/// A row a claim with the number that it hangs on; with verdict and the number that this one hangs on for another scene.
fn table(name: &str, claims: &[Claim], beside: &[Claim]) -> Table {
    let both = claims.iter().map(|claim| (claim, claim.hangs_on()));
    let other = |claim: &Claim| beside.iter().find(|other| other.id == claim.id);
    let beside = |claim: &Claim| other(claim)?.hangs_on();
    let all = Table::of(name, "", both)
        .column("claim", |(claim, _)| Cell::Code(claim.id.to_string()))
        .column("verdict", |(claim, _)| claim.word())
        .column("hangs on", |(claim, row)| match row {
            None if claim.rows.is_empty() => "other claims".to_owned(),
            None => String::new(),
            Some(row) => named(row),
        })
        .column("published", |(_, row)| row.and_then(|row| row.published))
        .column("ours (95 %)", |(_, row)| row.and_then(|row| row.ours))
        .column("limits", |(_, row)| {
            row.and_then(|row| row.judged).map(limits)
        })
        .column("beside: verdict", |(claim, _)| {
            other(claim).map(Claim::word)
        })
        .column("beside: hangs on", |(claim, own)| {
            let row = beside(claim)?;
            let is_same = |own: &Row| own.what == row.what;
            let limits = row.judged.map(limits).unwrap_or_default();
            Some(match own.is_some_and(is_same) {
                true => "the same".to_owned(),
                false => format!("{}: {limits}", named(row)),
            })
        })
        .column("beside (95 %)", |(claim, _)| beside(claim)?.ours);
    Table::from(all).without_empty_columns()
}

fn readings(name: &str, claims: &[Claim]) -> Table {
    Table::of(name, "", claims)
        .column("claim", |claim| Cell::Code(claim.id.to_string()))
        .column("the paper says", |claim| &claim.statement)
        .column("where", |claim| claim.place.as_ref())
        .column("found", |claim| &claim.reading)
        .into()
}

const EARLIER: &str = "The same author's earlier paper";
const HOW_EARLIER: &str = "I. G. Tejada, \"Boussinesq-like problems in discrete media\" (arXiv:1812.08424), has the same set-up. Its laws are \
    held against these realizations as its summary says them, along the principal directions of the mean stress at each point.";

impl Claims {
    pub fn document(&self) -> Document {
        let listed = |counts: &std::collections::BTreeMap<String, usize>| {
            let parts = counts.iter();
            let parts = parts.map(|(word, count)| format!("{}: {count}", ending_in_words(word)));
            parts.collect::<Vec<String>>().join(", ")
        };
        let mut how = Section::new("How a claim is decided", HOW);
        for [key, default, here] in &self.other_choices {
            how = how.with(format!("`{key}` is {here} instead of {default}."));
        }
        let mut choices_beside = None;
        let (beside, words) = match &self.beside {
            None => (&[][..], String::new()),
            Some(beside) => {
                let words = format!(
                    "Beside stand {} members of {} with the choices named below: {}.",
                    beside.members,
                    beside.origin.engine,
                    listed(&beside.verdicts)
                );
                let named = |[key, _, here]: &[String; 3]| format!("`{key}` {here}");
                let choices: Vec<String> = beside.other_choices.iter().map(named).collect();
                choices_beside = Some(format!("Choices beside: {}.", choices.join(", ")));
                (&beside.claims[..], words)
            }
        };
        let mut sections = vec![
            Section::new("The claims", words)
                .with(table("claims", &self.claims, beside))
                .with_all(choices_beside),
            Section::new("What was found", "").with(readings("readings", &self.claims)),
            how,
            self.means(),
            self.plane(),
            Section::new(EARLIER, HOW_EARLIER)
                .with(table("earlier", &self.earlier, &[]))
                .with(readings("earlier-readings", &self.earlier)),
            laws::section(&self.figures.contests),
        ];
        sections.extend(self.distributions());
        sections.extend(self.volumes());
        sections.extend([
            Section::new("Every number", "").with(self.numbers()).as_details(),
            Section::new("Every test", "").with(self.tests()).as_details(),
            Section::new(
                "How this was made",
                format!(
                    "crossgrain {}: `{}`. Scene with digest `{}`, plan `{}`, members `{}`. What each claim means: `docs/claims.md`.",
                    self.crossgrain,
                    self.origin.command,
                    self.scene_digest,
                    self.origin.plan,
                    self.origin.members_digest
                ),
            ),
        ]);
        let all = self.claims.iter().chain(&self.earlier);
        let checks: Vec<Check> = all.map(Claim::check).collect();
        let holds = Verdict::Holds.words();
        let mut others = self.verdicts.clone();
        others.remove(holds);
        let answer = format!(
            "{} of {} claims hold; {}. Of the earlier paper's {}: {}. {} members of {}: {}.{} A check passes where its claim could be decided, \
                 whichever way.",
            self.verdicts.get(holds).unwrap_or(&0),
            self.claims.len(),
            listed(&others),
            self.earlier.len(),
            listed(&counted(self.earlier.iter().map(Claim::word))),
            self.members,
            self.origin.engine,
            listed(&self.endings),
            other_scene(&self.other_choices)
        );
        Document::new("The paper's claims about its simulations", answer, checks).with(sections)
    }

    /// For the main report: every verdict, the means, and the distributions of Figure 5.
    pub fn summary(&self) -> Document {
        let mut document = self.document();
        let [under_load, gravity] = [GROUPS[0].title, GROUPS[1].title];
        let keep = ["The claims", "What was found", MEANS, under_load, gravity];
        let sections = &mut document.sections;
        sections.retain(|section| keep.contains(&section.title.as_str()));
        document
    }

    fn numbers(&self) -> Table {
        let shown = |row: &Row| row.judged.map_or("shown only".to_owned(), limits);
        Table::of("numbers", "Every number of every claim", self.rows())
            .column("claim", |(claim, _)| Cell::Code(claim.id.to_string()))
            .column("number", |(_, row)| &row.what)
            .column("published", |(_, row)| row.published)
            .column("ours (95 %)", |(_, row)| row.ours)
            .column("unit", |(_, row)| row.unit.as_ref())
            .column("ours over published", |(_, row)| row.ratio)
            .column("realizations", |(_, row)| row.packings)
            .column("limits", |(_, row)| shown(row))
            .column("outcome", |(_, row)| {
                row.judged.map(|judged| judged.outcome)
            })
            .into()
    }

    fn tests(&self) -> Table {
        let tests = self.rows().flat_map(|(claim, row)| {
            let all = row.probabilities.iter();
            all.map(move |test| (claim, row, test))
        });
        Table::of("tests", "Every test, adjusted by Holm", tests)
            .column("claim", |(claim, ..)| Cell::Code(claim.id.to_string()))
            .column("number", |(_, row, _)| &row.what)
            .column("test", |(.., test)| &test.test)
            .column("statistic", |(.., test)| test.statistic)
            .column("p", |(.., test)| test.p)
            .column("adjusted p", |(.., test)| test.adjusted)
            .into()
    }

    fn rows(&self) -> impl Iterator<Item = (&Claim, &Row)> {
        let all = self.claims.iter().chain(&self.earlier);
        all.flat_map(|claim| claim.rows.iter().map(move |row| (claim, row)))
    }

    fn distributions(&self) -> Vec<Section> {
        let section = |group: &Group| {
            let all = self.figures.distributions.iter();
            let plots = all
                .filter(|distribution| distribution.name == group.name)
                .flat_map(Distribution::plots);
            plots.fold(Section::new(group.title, ""), Section::with)
        };
        let mut sections: Vec<Section> = GROUPS.iter().map(section).collect();
        sections.retain(|section| !section.blocks.is_empty());
        sections
    }

    /// Means over the continuum's, row by row.
    fn means(&self) -> Section {
        let wanted = ["gravity", "mean.O", "mean.A", "mean.B", "extensive"];
        let rows = self.rows().filter_map(|(claim, row)| {
            let name = match claim.id.split_once('.') {
                Some((_, point)) => format!("{point}: {}", row.what),
                None if claim.id == "gravity" => format!("gravity, {}", row.what),
                None => row.what.clone(),
            };
            let wanted = wanted.contains(&claim.id.as_ref());
            wanted.then_some((name, row.ratio?, row.judged.map(|judged| judged.outcome)))
        });
        let rows: Vec<(String, Interval, Option<Outcome>)> = rows.collect();
        let section = Section::new(MEANS, "Shown with 95 % intervals; the limits are a tenth.");
        if rows.is_empty() {
            return section;
        }
        let names = rows.iter().map(|(name, ..)| name.clone());
        let caption = "Means over the continuum's";
        let x = Axis::linear("ours over the continuum's");
        let y = Axis::of_names("", names);
        let mut plot = Plot::new("means-over-published", caption, x, y);
        for y in [0.9, 1.0, 1.1] {
            plot = plot.level("", Colour::Grey, y);
        }
        let kinds = [
            ("within", Colour::Green, Some(Outcome::Pass)),
            ("beyond", Colour::Vermilion, Some(Outcome::Fail)),
            ("undecided", Colour::Ochre, Some(Outcome::Skipped)),
            ("shown only", Colour::Grey, None),
        ];
        for (name, colour, kind) in kinds {
            let places = rows.iter().enumerate();
            let of_kind = places.filter(|(_, (_, _, outcome))| *outcome == kind);
            let points = of_kind.map(|(index, (_, ratio, _))| {
                Point::at(ratio.estimate, index as f64).between(ratio.low, ratio.high)
            });
            plot = plot.points(name, colour, points);
        }
        section.with(plot)
    }

    /// Beds in the plane of height and porosity.
    fn plane(&self) -> Section {
        let section = Section::new(
            "Height and porosity of every settled bed",
            "Band: what is printed, H = 0.46 ± 0.01 m and n = 0.17 ± 0.01. Line: n = 1 − S/(L·H), on which all beds lie that have \
             one definition for both.",
        );
        let (Some(height), Some(porosity)) = (published("height"), published("porosity")) else {
            return section;
        };
        let beds = self.figures.plane.iter().flat_map(|cloud| &cloud.beds);
        let mut x = [0.44f64, 0.48f64];
        for [height, _] in beds {
            x = [x[0].min(height - 0.003), x[1].max(height + 0.003)];
        }
        let [low, high] = porosity.limits();
        let at = |share: f64| x[0] + share * (x[1] - x[0]);
        let caption = "Height and porosity of settled beds";
        let x = Axis::linear("height H, m").within(x[0], x[1]);
        let y = Axis::linear("porosity n");
        let printed = height.limits().map(|height| [height, low, high]);
        let mut plot = Plot::new("height-and-porosity", caption, x, y)
            .with("printed", Colour::Ochre, Shape::Band(printed.into()))
            .line(
                "area of the grains",
                Colour::Grey,
                (0..=20).map(|index| {
                    let height = at(f64::from(index) / 20.0);
                    [height, 1.0 - self.figures.solid / height]
                }),
            );
        for (cloud, colour) in self.figures.plane.iter().zip(COLOURS) {
            let beds = cloud.beds.iter().map(|[height, n]| Point::at(*height, *n));
            plot = plot.points(&cloud.definition, colour, beds);
        }
        section.with(plot)
    }

    /// Variation, shape and correlation of many cells against their number.
    fn volumes(&self) -> Vec<Section> {
        let section =
            |name: &str, title: &str, y: Axis, shown: Shown, independent: fn(f64) -> f64| {
                let section = Section::new(title, "Line: independent exponential cells.");
                section.with_all(Moment::BOTH.into_iter().filter_map(|moment| {
                    let all = self.figures.volumes.iter();
                    let series: Vec<&Volumes> =
                        all.filter(|scaling| scaling.moment == moment).collect();
                    let cells = series.iter().flat_map(|scaling| &scaling.volumes);
                    let most = cells.map(|one| one.cells).max()?;
                    let name = format!("{name}-{}", moment.key());
                    let caption = format!("{title}, {}", moment.words());
                    let x = Axis::logarithmic("number of cells N");
                    let counts = (0..=40).map(|index| (most as f64).powf(f64::from(index) / 40.0));
                    let line = counts.map(|n| [n, independent(n)]);
                    let plot = Plot::new(&name, caption, x, y.clone());
                    let plot = plot.line("independent cells", Colour::Grey, line);
                    let series = series.into_iter().zip(COLOURS);
                    Some(series.fold(plot, |plot, (scaling, colour)| {
                        let points = scaling.volumes.iter();
                        let points = points.filter_map(|one| {
                            let [value, low, high] = shown(one)?;
                            Some(Point::at(one.cells as f64, value).between(low, high))
                        });
                        plot.points(&scaling.point, colour, points)
                    }))
                }))
            };
        let mut sections = vec![
            section(
                "variation-and-cells",
                "Variation of many cells together",
                Axis::logarithmic("coefficient of variation of ΣΣ_zz"),
                |one| one.variation.map(ends),
                |n| 1.0 / n.sqrt(),
            ),
            section(
                "slope-and-cells",
                "Local exponent of N, from half as many cells",
                Axis::linear("slope of ln CV against ln N"),
                |one| one.slope.map(ends),
                |_| -0.5,
            ),
            section(
                "shape-and-cells",
                "Gamma shape of many cells together, over their number",
                Axis::logarithmic("gamma shape over N"),
                |one| one.shape.map(ends),
                |_| 1.0,
            ),
            section(
                "correlation-and-cells",
                "Mean correlation of two of the cells, (N CV_N²/CV_1² − 1)/(N − 1)",
                Axis::linear("mean correlation of two cells"),
                |one| one.correlation.map(|value| [value; 3]),
                |_| 0.0,
            ),
        ];
        sections.retain(|section| !section.blocks.is_empty());
        sections
    }
}

const MEANS: &str = "Means against Table 4";
const COLOURS: [Colour; 4] = [
    Colour::Blue,
    Colour::Vermilion,
    Colour::Green,
    Colour::Purple,
];

/// What is drawn of a volume, with the ends of its interval.
type Shown = fn(&Volume) -> Option<[f64; 3]>;

fn ends(interval: Interval) -> [f64; 3] {
    [interval.estimate, interval.low, interval.high]
}

fn limits(judged: Judged) -> String {
    let short = |value: f64| rounded(value, 4);
    match (judged.low, judged.high) {
        (Some(low), Some(high)) => format!("{} to {}", short(low), short(high)),
        (Some(low), None) => format!("at least {}", short(low)),
        (None, Some(high)) => format!("at most {}", short(high)),
        (None, None) => String::new(),
    }
}

/// That claims about the paper's scene are held against another one.
fn other_scene(choices: &[[String; 3]]) -> String {
    let named = |[key, there, here]: &[String; 3]| format!("{key} is {here}, not {there}");
    let first: Vec<String> = choices.iter().take(3).map(named).collect();
    let more = if choices.len() > 3 { ", …" } else { "" };
    match first.is_empty() {
        true => String::new(),
        false => format!(" The scene is not the paper's: {}{more}.", first.join(", ")),
    }
}
