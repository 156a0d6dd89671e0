//! The map for people.

use super::spheres::{Bearing, Spheres};
use super::{ALLOWED, Limits, Map, Row};
use crate::document::{Axis, Cell, Colour, Document, Plot, Point, Section, Style, Table};
use crate::engine::yade::Proposal;

use super::trials::Found;

impl Map {
    pub fn document(&self) -> Document {
        let answer = format!(
            "Found limits are at most {:.1} % off the predicted ones; {} % are allowed. {}",
            100.0 * self.farthest(),
            100.0 * ALLOWED,
            self.external_in_words()
        );
        let title = "The largest stable time steps";
        Document::new(title, answer, self.checks()).with(self.sections())
    }

    fn sections(&self) -> Vec<Section> {
        let mut sections = vec![
            Section::new(
                "Predicted and found",
                format!(
                    "Predicted: where the largest eigenvalue of dt²K + 2dtC is 4/(1+α) times the masses, K and C the springs and \
                     dashpots of all contacts. Found: a bed at rest is disturbed by a millionth of its overlaps, and the step at which the \
                     disturbance begins to grow is bracketed by trials. Found limits stand over predicted ones, and may be {} % apart. With \
                     damping the fastest mode alone is disturbed; a disturbance at random, which is not predicted, often grows only at \
                     larger steps.",
                    100.0 * ALLOWED
                ),
            )
            .with(self.limits_table())
            .with(self.limits_plot()),
            Section::new(
                "What YADE would choose",
                format!(
                    "Over the limit without damping: PWaveTimeStep and the GlobalStiffnessTimeStepper with its safety factor of 0.8, {}. \
                     The stepper looks at tangential springs and at rotations even where there are none. A step above 1 is unstable.",
                    if self.rows.iter().any(|row| row.proposal_of_yade.is_some()) {
                        "as YADE itself says"
                    } else {
                        "by its formulas"
                    }
                ),
            )
            .with(self.choices_table())
            .with(self.choices_plot()),
        ];
        if let Some(section) = self.rules_of_thumb() {
            sections.insert(0, section);
        }
        if !self.failures.is_empty() {
            let answer = "Each was tried. None hangs, and none leaves a number that is not finite in a result.";
            sections
                .push(Section::new("Where the method fails", answer).with(self.failures_table()));
        }
        let made = format!("Beds of the scene with digest {}.", self.scene_digest);
        sections.push(Section::new("How this was made", made).as_details());
        sections
    }

    /// Rows of spheres in space, with what rules of thumb go by.
    fn spheres(&self) -> impl Iterator<Item = (&Row, &Spheres)> + Clone {
        let rows = self.rows.iter();
        rows.filter_map(|row| Some((row, row.spheres.as_ref()?)))
    }

    /// Limits over the Rayleigh time, none where nothing is in space.
    fn rules_of_thumb(&self) -> Option<Section> {
        let beds = self
            .spheres()
            .filter(|(_, spheres)| spheres.bearing.is_some());
        let (row, spheres) = beds.min_by(|(a, at), (b, bt)| {
            let shares = [a.share(at), b.share(bt)];
            shares[0].total_cmp(&shares[1])
        })?;
        let answer = format!(
            "A step is often taken as a share of the Rayleigh time π R √(ρ/G)/(0.1631 ν + 0.8766), which knows no overlap. Here the smallest \
             stable share is {:.3}, of {} at a mean overlap of {:.3} R; Cundall's damping with α = {} lowers it to {:.3}. The limit falls with the \
             fourth root of the overlap. YADE's PWaveTimeStep is {:.3} of the Rayleigh time.",
            row.share(spheres),
            row.title,
            spheres.overlap,
            row.damped.alpha,
            row.damped.predicted / spheres.rayleigh,
            row.choice().p_wave / spheres.rayleigh,
        );
        let section = Section::new("Rules of thumb", answer);
        Some(section.with(self.shares_table()).with(self.shares_plot()))
    }

    fn shares_table(&self) -> Table {
        let name = self.external_name();
        let over_rayleigh = |found: Option<Found>, spheres: &Spheres| {
            found.map(|found| found.limit() / spheres.rayleigh)
        };
        let title = "Limits over the Rayleigh time of the smallest sphere";
        let table = Table::of("stability-shares", title, self.spheres())
            .column("scene", |(row, _)| Cell::Code(row.name.clone()))
            .column("mean overlap, R", |(_, spheres)| spheres.overlap)
            .column("largest overlap, R", |(_, spheres)| spheres.largest_overlap)
            .column("predicted", |(row, spheres)| row.share(spheres))
            .column("native", |(row, spheres)| {
                over_rayleigh(row.undamped.native, spheres)
            })
            .column(name, |(row, spheres)| {
                over_rayleigh(row.undamped.external, spheres)
            })
            .column("predicted with damping", |(row, spheres)| {
                row.damped.predicted / spheres.rayleigh
            })
            .column("limit over PWaveTimeStep", |(row, _)| {
                row.undamped.predicted / row.choice().p_wave
            });
        Table::from(table).without_empty_columns()
    }

    /// Lines as predicted, marks as found.
    fn shares_plot(&self) -> Plot {
        let mut plot = Plot::new(
            "stability-shares",
            "Largest stable steps of beds of spheres: lines as predicted, dots as found in native, circles in the other engine. A step above a \
             bed's line is unstable; the levels are rules of thumb.",
            Axis::logarithmic("mean overlap over R"),
            Axis::logarithmic("largest stable step over the Rayleigh time"),
        );
        for (bearing, colour) in Bearing::ALL.into_iter().zip(Colour::OF_LINES) {
            let beds = self
                .spheres()
                .filter(move |(_, spheres)| spheres.bearing == Some(bearing));
            let at = |(row, spheres): (&Row, &Spheres)| [spheres.overlap, row.share(spheres)];
            let found = |limit: fn(&Limits) -> Option<Found>| {
                beds.clone().filter_map(move |(row, spheres)| {
                    let share = limit(&row.undamped)?.limit() / spheres.rayleigh;
                    Some(Point::at(spheres.overlap, share))
                })
            };
            let mut line: Vec<[f64; 2]> = beds.clone().map(at).collect();
            line.sort_by(|a, b| a[0].total_cmp(&b[0]));
            plot = plot
                .line(bearing.words()[1], colour, line)
                .points("", colour, found(|limits| limits.native))
                .group("", colour, Style::Hollow, found(|limits| limits.external));
        }
        let of_yade = self
            .spheres()
            .map(|(row, spheres)| row.choice().p_wave / spheres.rayleigh);
        let of_yade = of_yade.fold(f64::INFINITY, f64::min);
        plot.level("PWaveTimeStep of YADE", Colour::Grey, of_yade)
            .level("0.4 of the Rayleigh time", Colour::Sky, 0.4)
    }

    /// The largest |found/predicted − 1|.
    fn farthest(&self) -> f64 {
        let limits = self
            .rows
            .iter()
            .flat_map(|row| [&row.undamped, &row.damped]);
        let found = limits.flat_map(|limit| {
            let both = [limit.native, limit.external].into_iter().flatten();
            both.map(|found| (found.limit() / limit.predicted - 1.0).abs())
        });
        found.fold(0.0, f64::max)
    }

    fn external_in_words(&self) -> String {
        let Some(engine) = &self.external else {
            return "The native engine ran alone.".to_owned();
        };
        let Some(version) = &engine.version else {
            return format!("{} did not run: {}.", engine.name, engine.missing);
        };
        let mut words = format!("{} {version} made the trials.", engine.name);
        let skipped = self.rows.iter().filter(|row| row.skipped.is_some()).count();
        if skipped > 0 {
            words += &format!(" It does not have the parts for {skipped} scenes.");
        }
        for approximation in &engine.approximations {
            words += &format!(" It says of itself: {approximation}.");
        }
        words
    }

    fn external_name(&self) -> &str {
        let external = self.external.as_ref();
        external.map_or("external", |engine| &engine.name)
    }

    fn limits_table(&self) -> Table {
        let name = self.external_name();
        let closed = |row: &Row| Some(row.closed.as_ref()?.dt / row.undamped.predicted);
        let native = |limits: &Limits| over(limits, limits.native);
        let external = |limits: &Limits| over(limits, limits.external);
        let at_random = |row: &Row| over(&row.damped, row.damped_at_random);
        let title = "Limits over predicted limits";
        let table = Table::of("stability-limits", title, &self.rows)
            .column("scene", |row| Cell::Code(row.name.clone()))
            .column("what it is", |row| &row.title)
            .column("grains", |row| row.grains)
            .column("contacts", |row| row.contacts)
            .column("limit, s", |row| row.undamped.predicted)
            .column("closed form", closed)
            .column("native", |row| native(&row.undamped))
            .column(name, |row| external(&row.undamped))
            .column("native with damping", |row| native(&row.damped))
            .column(&format!("{name} with damping"), |row| external(&row.damped))
            .column("at random with damping", at_random)
            .column("remark", |row| row.skipped.as_ref().unwrap_or(&row.remark));
        Table::from(table).without_empty_columns()
    }

    fn choices_table(&self) -> Table {
        let title = "Steps that YADE would choose, over the limit without damping";
        let over = |step: fn(&Proposal) -> f64| {
            move |row: &Row| step(row.choice()) / row.undamped.predicted
        };
        Table::of("stability-choices", title, &self.rows)
            .column("scene", |row| Cell::Code(row.name.clone()))
            .column("PWave", over(CHOICES[0].1))
            .column("GlobalStiffness", over(CHOICES[1].1))
            .column("the same with viscEl", over(CHOICES[2].1))
            .column("closed form", |row| Some(&row.closed.as_ref()?.formula))
            .into()
    }

    fn failures_table(&self) -> Table {
        let table = Table::of("stability-failures", "Failure modes", &self.failures)
            .column("", |failure| failure.outcome)
            .column("what is done", |failure| &failure.title)
            .column("what happens", |failure| &failure.happened)
            .column("who notices", |failure| &failure.noticed)
            .column("what is said", |failure| &failure.says)
            .column("in YADE", |failure| failure.yade.as_ref());
        Table::from(table).without_empty_columns()
    }

    fn limits_plot(&self) -> Plot {
        let points = |found: fn(&Limits) -> Option<Found>| -> Vec<Point> {
            let percent = |limits: &Limits| Some(100.0 * (over(limits, found(limits))? - 1.0));
            let undamped = self.points(|row| percent(&row.undamped));
            [undamped, self.points(|row| percent(&row.damped))].concat()
        };
        let allowed = 100.0 * ALLOWED;
        self.plot(
            "stability-limits",
            "Found limits against predicted ones, with and without damping; between the lines is allowed.",
            "found over predicted, % apart",
        )
        .level("allowed", Colour::Grey, allowed)
        .level("", Colour::Grey, -allowed)
        .points("native", Colour::Vermilion, points(|limits| limits.native))
        .points(self.external_name(), Colour::Green, points(|limits| limits.external))
    }

    fn choices_plot(&self) -> Plot {
        let mut plot = self
            .plot(
                "stability-choices",
                "What YADE would choose, over the largest stable step without damping. Above the line it would be unstable.",
                "step over the limit",
            )
            .level("the limit", Colour::Blue, 1.0);
        for ((name, step), colour) in CHOICES.into_iter().zip([Colour::Vermilion, Colour::Green]) {
            let points = self.points(|row| Some(step(row.choice()) / row.undamped.predicted));
            plot = plot.points(name, colour, points);
        }
        plot
    }

    /// Without marks, over the scenes.
    fn plot(&self, name: &str, caption: &str, y: &str) -> Plot {
        let scenes = self.rows.iter().map(|row| row.name.as_str());
        let x = Axis::of_names("scene", scenes);
        Plot::new(name, caption, x, Axis::linear(y))
    }

    /// A point a scene that has the value.
    fn points(&self, value: impl Fn(&Row) -> Option<f64>) -> Vec<Point> {
        let rows = self.rows.iter().enumerate();
        rows.filter_map(|(at, row)| Some(Point::at(at as f64, value(row)?)))
            .collect()
    }
}

type Choice = (&'static str, fn(&Proposal) -> f64);

const CHOICES: [Choice; 3] = [
    ("PWaveTimeStep", |proposal| proposal.p_wave),
    ("GlobalStiffness", |proposal| proposal.global_stiffness),
    ("GlobalStiffness with viscEl", |proposal| {
        proposal.with_dashpots
    }),
];

impl Row {
    /// Of the Rayleigh time.
    fn share(&self, spheres: &Spheres) -> f64 {
        self.undamped.predicted / spheres.rayleigh
    }

    fn choice(&self) -> &Proposal {
        self.proposal_of_yade.as_ref().unwrap_or(&self.proposal)
    }
}

fn over(limits: &Limits, found: Option<Found>) -> Option<f64> {
    found.map(|found| found.limit() / limits.predicted)
}
