//! Does it matter? Each rule of the catalogue alone, and each code's whole set, on packings that all have in common: what changes in a
//! bed and under its load, and by how much the angle of a collapsed column. Differences are paired by cloud and held against margins
//! that were set before.

use serde::{Deserialize, Serialize};

use crate::document::table::Table;
use crate::document::{Document, Section};
use crate::study::change::{What, changed};
use crate::study::member::{ANGLE, Beds, Endings, Member, Members, OfBeds};
use crate::study::realization::{Setting, Specification, small_scene};
use crate::study::tradeoff::judge::{Difference, Margin, QUANTITIES, difference, word};
use crate::study::{Judged, StudyError, tradeoff};
use evidence::t_test::Finding;
use grains::generate::initial_bodies;
use grains::model::Model;
use grains::rules::{CATALOGUE, Choice, Rules};
use grains::scene::parse_scene;
use grains::task::Case;
use verdict::forms::other_rules;

/// Codes whose whole sets are tried: what the catalogue says of each.
const CODES: [&str; 4] = ["LAMMPS", "LIGGGHTS", "ESyS-Particle", "Kratos DEM"];
/// What is compared of a bed and its load.
const OF_BEDS: [&str; 6] = [
    "settled.height.mean_surface",
    "settled.porosity.of_cells",
    "settled.coordination.mean_without_rattlers",
    "loaded.stress.O.local_zz",
    "loaded.stress.A.local_zz",
    "loaded.stress.B.local_zz",
];
/// Of a collapsed column.
const OF_COLUMNS: tradeoff::judge::Quantity = tradeoff::judge::Quantity {
    key: ANGLE,
    title: "angle of the collapsed column",
    unit: "°",
    margin: Some(Margin::Absolute(1.0)),
    reason: "a degree: angles of repose are told to no less",
};
/// Four times what beds take; under some rules grains never come to rest.
const MOST_STEPS: u64 = 200_000;
const COLUMN: &str = "column";
const USUAL: &str = "usual";

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Of each scene the usual rules first, then all others.
    pub beds: Beds,
}

impl Plan {
    pub fn new(clouds: u64) -> Self {
        let changes = [
            (What::Friction, 0.5),
            (What::Step, 0.3),
            (What::Dashpots, 0.5),
        ];
        let mut bed = changed(changed(small_scene(), &[(What::Width, 0.5)]), &changes);
        bed.settle.max_steps = MOST_STEPS;
        let example = include_str!("../../examples/column-collapse.json");
        let column = parse_scene(example).unwrap_or_else(|_| bed.clone());
        let mut column = changed(column, &changes[1..]);
        // The heap alone is looked at.
        column.loading.give_up_depth = 1.0e-6;
        column.settle.max_steps = MOST_STEPS;
        let mut beds = Vec::new();
        for (scene, suffix) in [(bed, ""), (column, COLUMN)] {
            let mut add = |id: &str, name: &str, axis: &str, rules: Rules| {
                let mut scene = scene.clone();
                scene.rules = rules;
                let id = format!("{id}{}{suffix}", if suffix.is_empty() { "" } else { "-" });
                let specification = Specification::native(scene);
                beds.push(vec![Setting::new(&id, name, axis, specification, clouds)]);
            };
            add(USUAL, "this program's rules", USUAL, Rules::default());
            let case = Case {
                name: String::new(),
                model: Model::of(&scene),
                bodies: initial_bodies(&scene),
                punch: None,
                moments: Vec::new(),
            };
            for choice in other_rules(&case) {
                let mut rules = Rules::default();
                choice.set(&mut rules);
                let id = choice.name().replace(" = ", "-").replace('_', "-");
                add(&id, &choice.name(), choice.rule().key, rules);
            }
            for code in CODES {
                let id = code.to_lowercase().replace(' ', "-");
                add(&id, &format!("all of {code}"), "codes", of_code(code));
            }
        }
        Plan { beds: Beds(beds) }
    }
}

/// The rules that the catalogue says this code has; where it names the code twice, or not at all, the usual ones.
fn of_code(code: &str) -> Rules {
    let mut rules = Rules::default();
    for rule in CATALOGUE {
        let of_rule = Choice::all().filter(|choice| choice.rule().key == rule.key);
        let of_code = of_rule.filter(|choice| {
            let mut codes = choice.alternative().codes.split(", ");
            codes.any(|named| named == code)
        });
        if let [one] = of_code.collect::<Vec<_>>()[..] {
            one.set(&mut rules);
        }
    }
    rules
}

impl OfBeds for Plan {
    const NAME: &'static str = "rules";

    fn beds(&self) -> &Beds {
        &self.beds
    }

    fn is_whole(&self) -> Result<(), String> {
        Ok(())
    }

    fn keeps(key: &str) -> bool {
        key == ANGLE || OF_BEDS.contains(&key)
    }

    fn judged(&self, members: &Members) -> Result<Judged, StudyError> {
        let record = Conventions::of(self, members);
        Judged::of(Self::NAME, &record, record.document())
    }
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Conventions {
    pub clouds: u64,
    pub settings: Vec<Found>,
}

/// A rule, or a code's whole set, against the usual rules on the same clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    pub id: String,
    pub name: String,
    pub endings: Endings,
    pub differences: Vec<Difference>,
}

impl Conventions {
    fn of(plan: &Plan, members: &Members) -> Self {
        let is_column = |setting: &Setting| setting.id.ends_with(COLUMN);
        let found = |setting: &Setting| {
            let mut all = plan.beds.settings();
            let usual =
                all.find(|other| other.axis == USUAL && is_column(other) == is_column(setting))?;
            let pair = |cloud| {
                let one = members.get(&usual.specification, cloud)?;
                Some((one, members.get(&setting.specification, cloud)?))
            };
            let pairs: Vec<(&Member, &Member)> = setting.realizations().filter_map(pair).collect();
            let of_beds = QUANTITIES
                .iter()
                .filter(|quantity| OF_BEDS.contains(&quantity.key));
            let quantities: Vec<_> = match is_column(setting) {
                true => vec![&OF_COLUMNS],
                false => of_beds.collect(),
            };
            let differences = quantities
                .iter()
                .filter_map(|quantity| difference(quantity, &pairs));
            (setting.axis != USUAL).then(|| Found {
                id: setting.id.clone(),
                name: setting.name.clone(),
                endings: Endings::of(members.of(setting)),
                differences: differences.collect(),
            })
        };
        Conventions {
            clouds: plan.beds.clouds(),
            settings: plan.beds.settings().filter_map(found).collect(),
        }
    }

    fn document(&self) -> Document {
        let all = self.settings.iter();
        let rows = all.flat_map(|found| {
            found
                .differences
                .iter()
                .map(move |difference| (found, difference))
        });
        let rows: Vec<(&Found, &Difference)> = rows.collect();
        let title = |(_, difference): (&Found, &Difference)| {
            let quantity = QUANTITIES
                .iter()
                .chain([&OF_COLUMNS])
                .find(|quantity| quantity.key == difference.key);
            quantity.map_or(String::new(), |quantity| {
                format!("{}, {}", quantity.title, quantity.unit)
            })
        };
        let count = |finding| {
            rows.iter()
                .filter(|(_, difference)| difference.finding == Some(finding))
                .count()
        };
        let [alike, other] = [Finding::Equivalent, Finding::Different].map(count);
        let table = Table::of(
            "differences",
            "Each rule against this program's",
            rows.iter().copied(),
        )
        .column("rule", |(found, _)| &found.name)
        .column("quantity", title)
        .column("usual", |(_, difference)| difference.paired.first_mean)
        .column("difference (95 %)", |(_, difference)| {
            difference.paired.difference
        })
        .column("margin", |(_, difference)| difference.margin)
        .column("finding", |(_, difference)| {
            difference.finding.map_or("too few", word)
        })
        .column("p of equivalence", |(_, difference)| difference.p)
        .column("packings", |(_, difference)| difference.paired.pairs)
        .column("what went wrong", |(found, _)| {
            found.endings.remarks().collect::<Vec<_>>().join("; ")
        });
        let broken = self
            .settings
            .iter()
            .filter(|found| found.differences.is_empty());
        let broken: Vec<&str> = broken.map(|found| found.name.as_str()).collect();
        let broken = match broken.is_empty() {
            true => String::new(),
            false => format!(
                " Of these no packing was left to compare: {}.",
                broken.join(", ")
            ),
        };
        let words = "Paired by cloud: the rule minus this program's. Equivalent: two one-sided tests at 5 % against the margin; different: the \
                     interval is beyond it. The angle is that of the triangle with the heap's centre of mass, from the floor.";
        let answer = format!(
            "Of {} differences {alike} are within their margins and {other} are beyond them.{broken}",
            rows.len()
        );
        let title = "Does it matter? Rules against each other";
        Document::new(title, answer, Vec::new())
            .with([Section::new("Differences", words).with(table)])
    }
}
