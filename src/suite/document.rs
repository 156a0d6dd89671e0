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
        let mut cases: Vec<&CaseResult> = Vec::new();
        for case in &self.cases {
            if cases.iter().all(|of| of.id != case.id) {
                cases.push(case);
            }
        }
        let by = |case: &CaseResult, role: Role| {
            let mut all = self.cases.iter();
            all.find(|of| of.id == case.id && of.role == role)
                .map(|of| of.outcome)
        };
        // What is missing for many is said once, above.
        let reasons = |case: &CaseResult| {
            let own = self.cases.iter().filter(|of| of.id == case.id);
            let own = own.filter(|of| of.inapplicable || of.outcome == Outcome::Fail);
            let reasons: Vec<&str> = own.map(|of| of.reason.as_str()).collect();
            reasons.join(" ")
        };
        let table = Table::of("cases", "Cases", cases)
            .column("case", |case| Cell::Code(case.id.clone()))
            .column("tested", |case| by(case, Role::Tested))
            .column("reference", |case| by(case, Role::Reference))
            .column("cross-code", |of| {
                by(of, Role::CrossCode).or(by(of, Role::Suite))
            })
            .column("what it shows", |case| &case.title)
            .column("why", reasons);
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
        let stresses = [
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
        ];
        let title = "Stresses of Figure 4's disc, tension positive";
        let table = Table::of("disc", title, stresses)
            .column("stress", |(name, _)| name)
            .column("σ_xx, Pa", |(_, stress)| stress[0])
            .column("σ_zz, Pa", |(_, stress)| stress[1])
            .column("σ_xz, Pa", |(_, stress)| stress[2]);
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
    let cell = |limit: &Limit| match limit {
        Limit::Unaffected => Cell::Missing,
        Limit::NotDetected => "not detected".into(),
        Limit::Detected => "detected".into(),
        Limit::From { size } => Cell::Number(*size),
    };
    let title = "Smallest relative size detected";
    let table = Table::of("detection-limits", title, &limits.cases)
        .column("case", |row| Cell::Code(row.case.clone()));
    let faults = limits.faults.iter().enumerate();
    let table = faults.fold(table, |table, (at, fault)| {
        table.column(fault, |row| row.limits.get(at).map(cell))
    });
    let table = table
        .column("false positives", |row| {
            format!("{} of {}", row.false_positives, row.sound_runs)
        })
        .column("varied", |row| match row.varied {
            Varied::Starts => "last bits at the start",
            Varied::Stiffness => "stiffness",
            Varied::Lists => "neighbour lists",
        });
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
