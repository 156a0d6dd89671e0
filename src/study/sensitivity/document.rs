//! What the map says.

use super::bearing::{Bearing, Curve, distinct};
use super::judge::{Judged, Verdict};
use super::plan::{AXES, COMBINED, FRICTION, SPEED_AND_DAMPING};
use super::{Figure, Point, Sensitivity};
use crate::checks::Outcome;
use crate::document::{Axis, Colour, Document, Mark, Plot, Section, Table, plot};
use crate::study::figures::in_row;
use evidence::Interval;

/// Pressures below this are as good as none, kPa.
const FAINT: f64 = 0.2;

/// What is drawn and said of a judged figure: a sign, words and a colour.
const VERDICTS: [(&str, &str, Colour); 5] = [
    ("=", "comes out", Colour::Blue),
    ("≈", "undecided, estimate within", Colour::Sky),
    ("?", "undecided", Colour::Grey),
    ("×", "does not come out", Colour::Vermilion),
    ("–", "too few members", Colour::Ochre),
];

const COLOURS: [Colour; 7] = [
    Colour::Blue,
    Colour::Vermilion,
    Colour::Green,
    Colour::Purple,
    Colour::Sky,
    Colour::Ochre,
    Colour::Grey,
];

/// Of [`VERDICTS`].
fn class(judged: &Judged) -> usize {
    match judged.verdict {
        Verdict::ComesOut => 0,
        Verdict::Undecided if judged.near => 1,
        Verdict::Undecided => 2,
        Verdict::DoesNot => 3,
        Verdict::Skipped => 4,
    }
}

impl Sensitivity {
    pub fn document(&self) -> Document {
        Document {
            title: "What the published figures depend on".to_owned(),
            verdict: Outcome::Pass,
            answer: self.answer(),
            sections: vec![
                self.speed_and_damping(),
                self.where_figures_come_out(),
                self.one_at_a_time(),
                self.at_rest(),
                self.every_setting(),
            ],
            checks: Vec::new(),
        }
    }

    fn answer(&self) -> String {
        let joint = self.joint.iter();
        let counts = joint.map(|of| format!("{} in {}", of.title, of.comes_out.len()));
        format!(
            "Of {} settings the published figures come out together as follows: {}.",
            self.points.len(),
            counts.collect::<Vec<String>>().join(", ")
        )
    }

    fn of_axis<'a>(&'a self, axis: &'a str) -> impl Iterator<Item = &'a Point> {
        self.points
            .iter()
            .filter(move |point| point.setting.axis == axis)
    }

    fn speed_and_damping(&self) -> Section {
        let words = format!(
            "The paper leaves open how fast the punch goes, how grains are damped, when the bed counts as settled and more. Each \
             setting fills these in one way; beds of {} grains, {} clouds a setting (expensive settings fewer), the same clouds \
             in all. A published figure comes out if the interval of ours over packings lies within value ± tolerance, does \
             not come out if it lies outside, and is undecided if it holds an end. For this the interval is one of {:.2} %, so \
             that of all that is decided here one in twenty is wrong on average, at most; shown are intervals of 95 %. Shapes are \
             of grains that bear load. A star marks settings in which fewer than \
             90 % of the punches got the force: their stresses are those of the firmer beds.",
            self.grains,
            self.clouds,
            100.0 * self.level
        );
        let place = |of: fn(&Point) -> Option<f64>| {
            distinct(self.of_axis(SPEED_AND_DAMPING).filter_map(of))
        };
        let speeds = place(|point| point.setting.at.first().copied());
        let mut alphas = place(|point| point.setting.at.get(1).copied());
        // The first stands on top.
        alphas.reverse();
        let section = Section::new("Punch speed and damping", words);
        if speeds.is_empty() {
            return section;
        }
        let map = |name: &str, caption: String, show: &dyn Fn(&Point) -> (usize, String)| {
            let names = |all: &[f64]| all.iter().map(f64::to_string).collect::<Vec<String>>();
            let x = Axis::of_names("punch speed, m/s", names(&speeds));
            let y = Axis::of_names("damping α", names(&alphas));
            let mut points: [Vec<plot::Point>; 5] = Default::default();
            for point in self.of_axis(SPEED_AND_DAMPING) {
                let at = |all: &[f64], index: usize| {
                    let at = point.setting.at.get(index)?;
                    all.iter().position(|of| of == at)
                };
                let (Some(x), Some(y)) = (at(&speeds, 0), at(&alphas, 1)) else {
                    continue;
                };
                let (class, label) = show(point);
                points[class].push(plot::Point::at(x as f64, y as f64).labelled(label));
            }
            with_classes(
                Plot::new(name, caption, x, y),
                points.map(|of| (of, Vec::new())),
            )
        };
        let reached = map(
            "share-that-got-the-force",
            "Share of the punches that got the force, %: all of nine in ten and more, grey below, vermilion below half.".to_owned(),
            &|point| {
                let class = match point.reached {
                    share if share >= 0.9 => 0,
                    share if share >= 0.5 => 2,
                    _ => 3,
                };
                (class, format!("{:.0}", 100.0 * point.reached))
            },
        );
        let figures = self.figures.iter().enumerate();
        figures
            .fold(section, |section, (index, figure)| {
                let caption = format!("{}, {}.", figure.title, published(figure));
                let name = format!("speed-and-damping-{}", figure.id.replace('.', "-"));
                section.with(map(&name, caption, &|point| {
                    let judged = &point.figures[index];
                    let star = if judged.conditional { "*" } else { "" };
                    let value = judged.value.map(|of| in_unit(of.estimate, &figure.unit));
                    (class(judged), value.map_or(String::new(), |of| of + star))
                }))
            })
            .with(reached)
    }

    /// What settings are called away from their axes.
    fn names(&self, ids: &[String]) -> String {
        let own = self.points.iter().filter(|of| ids.contains(&of.setting.id));
        let names = own.map(|point| {
            let setting = &point.setting;
            match setting.axis.as_str() {
                SPEED_AND_DAMPING | FRICTION | COMBINED => setting.name.clone(),
                axis => format!("{axis}: {}", setting.name),
            }
        });
        match names.collect::<Vec<String>>().as_slice() {
            [] => "none".to_owned(),
            names => names.join("; "),
        }
    }

    fn where_figures_come_out(&self) -> Section {
        let table = Table::of("figures", "Each published figure", &self.figures)
            .column("figure", |figure| &figure.title)
            .column("published", published)
            .column("comes out", |figure| figure.comes_out.len())
            .column("undecided", |figure| figure.undecided.len())
            .column("does not", |figure| figure.does_not.len())
            .column("too few members", |figure| figure.skipped.len())
            .column("comes out in", |figure| self.names(&figure.comes_out))
            .column("tolerance", |figure| &figure.reason);
        let together = Table::of("together", "Figures together", &self.joint)
            .column("figures", |joint| &joint.title)
            .column("all come out in", |joint| self.names(&joint.comes_out))
            .column("none is excluded in", |joint| self.names(&joint.possible))
            .column("all estimates are within in", |joint| {
                self.names(&joint.near)
            });
        Section::new("Where each figure comes out", "")
            .with(table)
            .with(together)
    }

    fn one_at_a_time(&self) -> Section {
        let words = "Ours over published with 95 % intervals; shaded: what counts as the same. Hollow: fewer than 90 % of the \
                     punches got the force; how many did stands beside the name. What lies beyond the panel stands at its edge.";
        let axes = AXES.iter().map(|(axis, _)| *axis);
        let axes = axes.filter(|axis| *axis != SPEED_AND_DAMPING);
        let points: Vec<&Point> = axes.flat_map(|axis| self.of_axis(axis)).collect();
        let figures = self.figures.iter().enumerate();
        let figures = figures.filter(|_| !points.is_empty());
        Section::new("One choice at a time", words)
            .with_all(figures.map(|(index, figure)| column(&points, index, figure)))
    }

    fn at_rest(&self) -> Section {
        let Bearing {
            soil,
            height,
            wanted,
            angle,
            factors: [surcharge, weight],
            depth_needed,
            angle_needed,
            impedance,
            speed_of_impact,
            ..
        } = &self.bearing;
        let kilo = 1.0e-3 * wanted;
        let words = format!(
            "At rest, a soil with the internal friction of frictionless grains bears {kilo:.1} kPa at a depth of {depth_needed:.2} \
             m; the bed is {height:.2} m deep. Its friction angle is {:.2}° (frictionless spheres in the literature), its \
             bearing-capacity factors are N_q = {surcharge:.2} and N_γ = {weight:.2}, its unit weight is γ = {:.0} N/m³. To bear \
             the load at the depth of the control points, {angle_needed:.1}° are needed. A wall that moves into the bed meets \
             ρ(1−n)c = {:.0} kPa for each m/s by inertia alone, and so the published load at {speed_of_impact:.2} m/s.",
            angle.to_degrees(),
            soil.unit_weight,
            1.0e-3 * impedance,
        );
        let mut section = Section::new("Can the bed bear the load at rest?", words);
        let of = &self.bearing;
        if !of.through.is_empty() {
            section = section.with(of.through_plot()).with(of.rest_table());
        }
        if !of.standing.is_empty() {
            section = section.with(of.standing_plot()).with(of.standing_table());
        }
        section
    }

    fn every_setting(&self) -> Section {
        let mut section = Section::new("Every setting", "").as_details();
        for (index, (axis, why)) in AXES.iter().enumerate() {
            let points: Vec<&Point> = self.of_axis(axis).collect();
            if points.is_empty() {
                continue;
            }
            let table = |name: &str, title: &str| {
                Table::of(&format!("{name}-{index}"), title, points.iter().copied())
                    .column("setting", |of| &of.setting.name)
            };
            let verdicts = table("verdicts", axis)
                .column("clouds", |of| of.made)
                .column("got the force", |of| of.endings.reached)
                .column("of", |of| of.endings.all())
                .column("depth at the force, m", |of| of.depth);
            let values = table("values", &format!("{axis}: ours, SI units"));
            let changes = "more than in the base, same clouds, SI units";
            let tables = [
                verdicts,
                values,
                table("changes", &format!("{axis}: {changes}")),
            ];
            let figures = self.figures.iter().enumerate();
            let [verdicts, values, changes] =
                figures.fold(tables, |[verdicts, values, changes], (at, figure)| {
                    let verdict = |of: &Point| {
                        let judged = &of.figures[at];
                        let star = if judged.conditional { "*" } else { "" };
                        format!("{}{star}", VERDICTS[class(judged)].0)
                    };
                    [
                        verdicts.column(&figure.id, verdict),
                        values.column(&figure.id, |of| of.figures[at].value),
                        changes.column(&figure.id, |of| of.figures[at].change),
                    ]
                });
            let verdicts = verdicts.column("remarks", |of| {
                let remarks: Vec<String> = of.endings.remarks().collect();
                (!remarks.is_empty()).then(|| remarks.join("; "))
            });
            section = section.with(format!("{axis}: {why}.")).with(verdicts);
            section = section.with(values).with(changes);
        }
        let signs = VERDICTS.map(|(sign, words, _)| format!("{sign} {words}"));
        section.answer = format!(
            "{}; * fewer than 90 % of the punches got the force. Means have t intervals, variations the bootstrap (BCa), \
             shares those of their influence function; the packing counts, never the grain. Shapes are of grains that bear load.",
            signs.join("; ")
        );
        section
    }
}

/// Points, filled and hollow, of each of [`VERDICTS`].
fn with_classes(mut plot: Plot, points: [(Vec<plot::Point>, Vec<plot::Point>); 5]) -> Plot {
    for ((filled, hollow), (_, name, colour)) in points.into_iter().zip(VERDICTS) {
        let named = filled.is_empty();
        let of_hollow = if named { name } else { "" };
        plot = plot.group(name, colour, false, filled);
        plot = plot.group(of_hollow, colour, true, hollow);
    }
    plot
}

/// A figure in all settings, a row a setting.
fn column(points: &[&Point], index: usize, figure: &Figure) -> Plot {
    // Heights and porosities differ by little.
    let [low, high] = match figure.id.as_str() {
        "height" | "porosity" => [0.8, 1.2],
        _ => [0.0, 2.0],
    };
    let names = points.iter().map(|point| {
        let Point {
            setting, endings, ..
        } = point;
        let missed = match endings.missed() {
            0 => String::new(),
            _ => format!(" ({} of {})", endings.reached, endings.all()),
        };
        match setting.axis.as_str() {
            COMBINED => format!("{}{missed}", setting.name),
            axis => format!("{axis}: {}{missed}", setting.name),
        }
    });
    let x = Axis::linear("ours over published").within(low, high);
    let name = format!("choices-{}", figure.id.replace('.', "-"));
    let caption = format!("{}, {}.", figure.title, published(figure));
    let plot = Plot::new(&name, caption, x, Axis::of_names("", names));
    let tolerance = figure.tolerance / figure.value;
    let last = points.len() as f64 - 0.5;
    let band = [1.0 - tolerance, 1.0 + tolerance].map(|x| [x, -0.5, last]);
    let plot = plot.band("counts as the same", Colour::Green, band);
    let mut classes: [(Vec<plot::Point>, Vec<plot::Point>); 5] = Default::default();
    for (row, point) in points.iter().enumerate() {
        let judged = &point.figures[index];
        let Some(value) = judged.value else { continue };
        let ours = value.over(figure.value);
        let (filled, hollow) = &mut classes[class(judged)];
        let shown = in_row(&ours, row, [low, high], 2);
        if judged.conditional { hollow } else { filled }.push(shown);
    }
    with_classes(plot, classes)
}

impl Bearing {
    /// The damping of most curves: that of the base scene.
    fn base_alpha(&self) -> f64 {
        self.through.first().map_or(f64::NAN, |curve| curve.alpha)
    }

    fn like_base(&self) -> impl Iterator<Item = &Curve> {
        let alpha = self.base_alpha();
        let through = self.through.iter();
        through.filter(move |curve| curve.friction == 0.0 && curve.alpha == alpha)
    }

    fn through_plot(&self) -> Plot {
        let caption = "Punches that go on whatever the force is: mean pressure in windows of depth, with 95 % intervals over clouds.";
        let x = Axis::linear("depth of the punch, m");
        let y = Axis::logarithmic("mean pressure on the punch, kPa");
        let mut plot = Plot::new("pushed-through", caption, x, y);
        let mut deepest = 0.0f64;
        for (curve, colour) in self.like_base().zip(COLOURS) {
            plot = with_curve(plot, curve, &format!("{} m/s", curve.speed), colour);
            let levels = curve.levels.iter();
            deepest = levels.map(|level| level.at).fold(deepest, f64::max);
        }
        let plot = plot.level("published load", Colour::Ochre, 1.0e-3 * self.wanted);
        let depths = (1..=40).map(|index| deepest * f64::from(index) / 40.0);
        let borne = depths.map(|depth| [depth, 1.0e-3 * self.soil.bears(depth, self.angle)]);
        plot.with(Mark::Line {
            name: format!("bearing capacity at rest, {:.1}°", self.angle.to_degrees()),
            colour: Colour::Grey,
            dashed: true,
            points: borne.collect(),
        })
    }

    fn standing_plot(&self) -> Plot {
        let caption = format!(
            "Mean pressure on the punch after it stopped; the published load is {:.1} kPa at the start.",
            1.0e-3 * self.wanted
        );
        let x = Axis::logarithmic("time after the punch stopped, s");
        let y = Axis::logarithmic("mean pressure on the punch, kPa");
        let plot = Plot::new("left-standing", caption, x, y);
        let curves = self.standing.iter().zip(COLOURS);
        curves.fold(plot, |plot, (curve, colour)| {
            with_curve(plot, curve, &curve.name, colour)
        })
    }

    fn rest_table(&self) -> Table {
        let title = "Pressure at rest, extrapolated from the slowest punches";
        let table = Table::of("at-rest", title, &self.at_rest)
            .column("depth, m", |row| row.depth)
            .column("clouds", |row| row.clouds)
            .column("theory, kPa", |row| 1.0e-3 * row.theory)
            .column("extrapolated to rest, kPa", |row| kilopascal(row.pressure))
            .column("angle that bears it, degrees", |row| row.angle);
        let pressure = |curve: &Curve, depth: f64| {
            let mut levels = curve.levels.iter();
            let level = levels.find(|level| (level.at - depth).abs() < 1.0e-9)?;
            kilopascal(level.pressure)
        };
        let table = self.like_base().fold(table, |table, curve| {
            let heading = format!("at {} m/s, kPa", curve.speed);
            table.column(&heading, |row| pressure(curve, row.depth))
        });
        table.into()
    }

    fn standing_table(&self) -> Table {
        let curves = self.standing.iter();
        let levels = curves.flat_map(|curve| curve.levels.iter().map(move |level| (curve, level)));
        let title = "Punches that stop when the force is reached";
        let on_floor = "more on the floor over the punch's width, kPa";
        Table::of("relaxation", title, levels)
            .column("punch", |(curve, _)| &curve.name)
            .column("got the force", |(curve, _)| curve.reached)
            .column("of", |(curve, _)| curve.clouds)
            .column("depth at the force, m", |(curve, _)| curve.depth)
            .column("time after the stop, s", |(_, level)| level.at)
            .column("on the punch, kPa", |(_, level)| kilopascal(level.pressure))
            .column(on_floor, |(_, level)| kilopascal(level.on_floor))
            .into()
    }
}

fn with_curve(plot: Plot, curve: &Curve, name: &str, colour: Colour) -> Plot {
    let points = curve.levels.iter().filter_map(|level| {
        let of = kilopascal(level.pressure)?;
        let [middle, low, high] = [of.estimate, of.low, of.high].map(|of| of.max(FAINT));
        Some(plot::Point::at(level.at, middle).between(low, high))
    });
    let points: Vec<plot::Point> = points.collect();
    plot.line(name, colour, points.iter().map(|of| [of.x, of.y]))
        .points("", colour, points)
}

fn kilopascal(of: Option<Interval>) -> Option<Interval> {
    of.map(|of| of.over(1.0e3))
}

/// Value and tolerance.
fn published(figure: &Figure) -> String {
    let [value, tolerance] = [figure.value, figure.tolerance].map(|of| in_unit(of, &figure.unit));
    let unit = match figure.unit.as_str() {
        "Pa" => " kPa",
        "m" => " mm",
        _ => "",
    };
    format!("published {value} ± {tolerance}{unit}")
}

/// As people write it: kPa, mm and plain ratios.
fn in_unit(value: f64, unit: &str) -> String {
    match unit {
        "Pa" => format!("{:.1}", 1.0e-3 * value),
        "m" => format!("{:.0}", 1.0e3 * value),
        _ if value.abs() >= 0.5 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
