//! The choices that the paper leaves open, one at a time around the printed scene.

use crate::study::member::Beds;
use crate::study::realization::Change::{
    self, Alpha, CloudSpeed, Columns, Diameter, DiameterSameArea, Friction, Hold, Settled, Size,
    Speed, Spheres, Step,
};
use crate::study::realization::{Setting, Specification, changed};
use crate::study::search::space;

pub const PRINTED: &str = "as printed";
const SPEED_AND_DAMPING: &str = "punch speed and damping";
const NEVER_PRINTED: &str = "never printed; R = 5 mm follows from the control volume alone";
const POURED: &str = "'randomly poured'";

/// A choice: what the paper says and why the range is what it is, the unit of its values, and what a value changes.
struct Choice {
    name: &'static str,
    reason: &'static str,
    unit: &'static str,
    change: fn(f64) -> Change,
    values: &'static [f64],
    /// With `--quick`.
    few: &'static [f64],
}

const CHOICES: [Choice; 11] = [
    Choice {
        name: "settle rule",
        reason: "'almost completely dissipate'; kinetic energy over its peak, from visible motion to deep rest",
        unit: "of the peak",
        change: Settled,
        values: &[1.0e-2, 1.0e-3, 1.0e-5, 1.0e-6],
        few: &[1.0e-2],
    },
    Choice {
        name: "friction of both stages",
        reason: "Table 2 prints zero; to 0.6 rad = 34 degrees, a sand's. A friction coefficient is its tangent",
        unit: "rad",
        change: Friction,
        values: &[0.1, 0.3, 0.6],
        few: &[0.3],
    },
    Choice {
        name: "mean diameter, same number of grains",
        reason: NEVER_PRINTED,
        unit: "mm",
        change: |of| Diameter(1.0e-3 * of),
        values: &[9.0, 9.5, 9.8, 10.2, 10.5],
        few: &[9.0],
    },
    Choice {
        name: "mean diameter, same area of grains",
        reason: NEVER_PRINTED,
        unit: "mm",
        change: |of| DiameterSameArea(1.0e-3 * of),
        values: &[8.0],
        few: &[],
    },
    Choice {
        name: "hold after the force",
        reason: "'until the force was equal to 2ap'; a hold is not mentioned",
        unit: "s",
        change: Hold,
        values: &[0.01, 0.05, 0.2],
        few: &[0.05],
    },
    Choice {
        name: "columns of the cloud",
        reason: POURED,
        unit: "columns",
        change: |of| Columns(of as u32),
        values: &[90.0],
        few: &[],
    },
    Choice {
        name: "speed of the cloud",
        reason: POURED,
        unit: "m/s",
        change: CloudSpeed,
        values: &[0.0, 1.0, 3.0],
        few: &[],
    },
    Choice {
        name: "number of grains, over the printed",
        reason: "5,000 is printed; shows what the floor does",
        unit: "times",
        change: |of| Size(1.0, of),
        values: &[0.5, 2.0],
        few: &[],
    },
    Choice {
        name: "box width",
        reason: "1 m is printed; shows what the walls do",
        unit: "m",
        change: |of| Size(of, 1.0),
        values: &[0.5, 2.0],
        few: &[],
    },
    Choice {
        name: "time step",
        reason: "not printed; in units of √(m/k)",
        unit: "√(m/k)",
        change: Step,
        values: &[0.1, 0.45],
        few: &[],
    },
    Choice {
        name: "mass of a grain",
        reason: "'spherical' particles, but weights of discs one metre long",
        unit: "(a sphere's)",
        change: |_| Spheres,
        values: &[1.0],
        few: &[],
    },
];

/// What the paper says of a choice, and why its range is what it is.
pub fn reasons() -> impl Iterator<Item = (&'static str, &'static str)> {
    let first = (
        SPEED_AND_DAMPING,
        "'gently' and 'spring-dashpot' without numbers; from where punches sink to where the force is an impact, and from \
         hardly damped to YADE's examples of quasi-static runs. Damping is that of pouring and loading",
    );
    std::iter::once(first).chain(CHOICES.iter().map(|of| (of.name, of.reason)))
}

/// The printed scene first; settings that pour alike share their beds.
pub fn beds(quick: bool, clouds: u64) -> Beds {
    let base = space::base(quick);
    let mut beds: Vec<Vec<Setting>> = Vec::new();
    let mut add = |id: &str, name: &str, axis: &str, at: &[f64], changes: &[Change]| {
        let of = Specification::native(changed(base.clone(), changes));
        let mut setting = Setting::new(id, name, axis, of, clouds);
        setting.at = at.to_vec();
        let specification = &setting.specification;
        let same = |bed: &&mut Vec<Setting>| bed[0].specification.pours_like(specification);
        match beds.iter_mut().find(same) {
            Some(bed) => bed.push(setting),
            None => beds.push(vec![setting]),
        }
    };
    add("printed", PRINTED, PRINTED, &[], &[]);
    let (speeds, alphas): (&[f64], &[f64]) = match quick {
        true => (&[0.05, 0.5], &[0.8]),
        false => (&[0.05, 0.07, 0.1, 0.2, 0.5], &[0.05, 0.1, 0.2, 0.4, 0.8]),
    };
    for alpha in alphas {
        for speed in speeds {
            let changes = [Alpha(*alpha), Speed(*speed)];
            if changed(base.clone(), &changes) == base {
                continue;
            }
            let id = format!("speed-{speed}-alpha-{alpha}");
            let name = format!("{speed} m/s, α = {alpha}");
            add(&id, &name, SPEED_AND_DAMPING, &[*speed, *alpha], &changes);
        }
    }
    for of in &CHOICES {
        let word = of.name.replace([',', ' '], "-").replace("--", "-");
        for value in if quick { of.few } else { of.values } {
            let (id, name) = (
                format!("{word}-{value}"),
                format!("{}: {value} {}", of.name, of.unit),
            );
            add(&id, &name, of.name, &[*value], &[(of.change)(*value)]);
        }
    }
    Beds(beds)
}
