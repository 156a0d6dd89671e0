//! What people are told of a verification.

use super::detection::{Limit, Limits, Varied};
use super::parameters::Errors;
use super::run::{CaseResult, Role, Verification};
use crate::checks::Outcome;
use crate::document::plot::Point;
use crate::document::{Axis, Cell, Colour, Document, Plot, Section, Table};

impl Verification {
    /// As a document of its own.
    pub fn document(&self) -> Document {
        let yade = match &self.yade {
            Some(version) => format!(" YADE {version} ran live."),
            None => String::new(),
        };
        Document {
            title: "Verification suite: every contact law against what is known of it".to_owned(),
            verdict: self.verdict(),
            answer: format!("{}.{yade}", self.tally),
            sections: self.sections(),
            checks: self.checks(),
        }
    }

    /// The sections, of this document and of the main job's.
    pub fn sections(&self) -> Vec<Section> {
        let mut sections = vec![self.cases()];
        sections.extend(self.engine());
        sections.extend(self.limits.as_ref().map(detection));
        if !self.errors.is_empty() {
            let rounding = Section::new(
                "Rounding",
                "Native and YADE round alike; 11 more bits make the error smaller by about 2¹¹, so it is rounding and nothing else.",
            );
            sections.push(rounding.with(errors(&self.errors)));
        }
        sections.push(self.disc());
        sections
    }

    /// A row a case, in the order in which they were first run, with an outcome for each part that an engine had.
    fn cases(&self) -> Section {
        let missing = |case: &&CaseResult| case.outcome == Outcome::Skipped && !case.inapplicable;
        let missing = self.cases.iter().find(missing).map(|case| &case.reason);
        let skipped = missing.map(|why| format!(" Skipped: {why}"));
        let answer = format!(
            "Each case is a small experiment whose outcome is known. All engines run the same cases and are judged by the same \
             code.{}",
            skipped.unwrap_or_default()
        );
        let columns = [
            "case",
            "tested",
            "reference",
            "cross-code",
            "what it shows",
            "why",
        ];
        let mut table = Table::new("cases", "Cases", &columns);
        let mut seen: Vec<&str> = Vec::new();
        for case in &self.cases {
            if seen.contains(&case.id.as_str()) {
                continue;
            }
            seen.push(&case.id);
            let of: Vec<&CaseResult> = self.cases.iter().filter(|of| of.id == case.id).collect();
            let by = |role: Role| of.iter().find(|of| of.role == role);
            // What is missing for many is said once, above.
            let own = of
                .iter()
                .filter(|of| of.inapplicable || of.outcome == Outcome::Fail);
            let reasons: Vec<&str> = own.map(|of| of.reason.as_str()).collect();
            table.row([
                Cell::Code(case.id.clone()),
                by(Role::Tested).map(|of| of.outcome).into(),
                by(Role::Reference).map(|of| of.outcome).into(),
                by(Role::CrossCode)
                    .or(by(Role::Suite))
                    .map(|of| of.outcome)
                    .into(),
                case.title.as_str().into(),
                reasons.join(" ").into(),
            ]);
        }
        Section::new("Cases", answer).with(table)
    }

    /// What an external engine says of itself.
    fn engine(&self) -> Option<Section> {
        let engine = self.exec.as_ref()?;
        let section = Section::new("The engine", format!("{} ran the suite.", engine.label()));
        let said = engine.approximations.iter();
        Some(said.fold(section, |section, said| section.with(said.clone())))
    }

    fn disc(&self) -> Section {
        let columns = ["stress", "σ_xx, Pa", "σ_zz, Pa", "σ_xz, Pa"];
        let mut table = Table::new(
            "disc",
            "Stresses of Figure 4's disc, tension positive",
            &columns,
        );
        for (name, stress) in [
            ("Σ/V of the contact forces", self.disc.contact),
            (
                "field averaged over the disc, by quadrature",
                self.disc.disc,
            ),
            (
                "field averaged over the control square of side R at the centre",
                self.disc.square,
            ),
            ("Σ over the cell of side 2R: Table 3", self.disc.cell),
        ] {
            let name = Cell::from(name);
            table.row([name].into_iter().chain(stress.map(Cell::from)));
        }
        Section::new(
            "Inside a grain: the disc of Figure 4",
            "The paper computes a grain's stress from its contact forces and gives it to control volumes around it (section 3.3, \
             second bullet). The elastic field inside the disc, in closed form, averages to Σ/V over the grain, as it must. Over \
             the square at the centre it does not: the middle of a disc bears more of the vertical stress than its rim, and the \
             voids outside bear none. Giving the grain's Σ to a control square in proportion to its volume is a convention, not \
             the stress in that square.",
        )
        .with(table)
    }
}

fn detection(limits: &Limits) -> Section {
    let faults = limits.faults.iter().map(String::as_str);
    let columns: Vec<&str> = ["case"]
        .into_iter()
        .chain(faults)
        .chain(["false positives", "varied"])
        .collect();
    let mut table = Table::new(
        "detection-limits",
        "Smallest relative size detected",
        &columns,
    );
    for row in &limits.cases {
        let cell = |limit: &Limit| match limit {
            Limit::Unaffected => Cell::Missing,
            Limit::NotDetected => "not detected".into(),
            Limit::Detected => "detected".into(),
            Limit::From { size } => Cell::Number(*size),
        };
        let varied = match row.varied {
            Varied::Starts => "last bits at the start",
            Varied::Stiffness => "stiffness",
            Varied::Lists => "neighbour lists",
        };
        let positives = format!("{} of {}", row.false_positives, row.sound_runs);
        let cells = [Cell::Code(row.case.clone())].into_iter();
        let cells = cells.chain(row.limits.iter().map(cell));
        table.row(cells.chain([positives.into(), varied.into()]));
    }
    Section::new(
        "Detection limits",
        "For each deliberate fault the smallest relative size at which each case fails, found by halving. No value: the fault changes \
         nothing in the case. False positives are runs that fail where nothing is wrong but what is varied differs. A symmetry \
         detects faults that its two sides do not share; every fault here keeps action equal to reaction.",
    )
    .with(table)
}

/// How rounding errors grow in each precision.
fn errors(errors: &[Errors]) -> Plot {
    let points = |of: fn(&Errors) -> f64| -> Vec<[f64; 2]> {
        let points = errors.iter().map(|errors| [errors.step as f64, of(errors)]);
        points.filter(|[_, error]| *error > 0.0).collect()
    };
    let yade = points(|of| of.yade).into_iter();
    Plot::new(
        "rounding",
        "Distance from the same run in 128-bit arithmetic. It grows while grains collide, until neighbours are no longer the same.",
        Axis::linear("step of pouring"),
        Axis::logarithmic("largest error over R"),
    )
    .line("native", Colour::Blue, points(|of| of.native))
    .points("YADE, double", Colour::Vermilion, yade.map(|[x, y]| Point::at(x, y)))
    .line("YADE, long double", Colour::Green, points(|of| of.long_double))
}
