//! Members that are drawn from known laws.

use crossgrain::study::campaign::{Fields, Member};
use crossgrain::study::claims::{self, Moment};
use crossgrain::study::realization::Ending;
use evidence::distribution::Distribution;
use evidence::random::{Key, Source};
use grains::measure::neighbourhood::{GROWING, Neighbour, Neighbourhood, SINGLY, Together};

use crate::support::*;

const KEY: Key = *b"crossgrain: tests of the claims.";
const CELL: f64 = 9.4e-5;

/// What the members are drawn from; [`Truth::paper`] is everything that the paper claims.
#[derive(Clone)]
pub struct Truth {
    pub members: u64,
    /// Of σ_zz and σ_xx over their means.
    pub normal: Distribution,
    /// Of σ_xz, Pa.
    pub shear: Distribution,
    /// Factor of the mean at each point, under the load.
    pub factor: [f64; 3],
    /// Share of a cell's stress that is common to all cells of a point.
    pub common: f64,
    /// H by each definition.
    pub heights: [f64; 3],
    pub porosity: f64,
    /// Share of members that sink.
    pub missed: f64,
    /// Added to every σ_zz under gravity, over its mean.
    pub gravity_shift: f64,
    /// So many members have a grain at each point that is slightly pulled.
    pub pulled: u64,
}

impl Truth {
    pub fn paper() -> Self {
        Truth {
            members: 600,
            normal: Distribution::Exponential { mean: 1.0 },
            shear: Distribution::Laplace {
                location: 0.0,
                scale: 3000.0,
            },
            factor: [1.0; 3],
            common: 0.0,
            heights: [0.462; 3],
            porosity: 0.168,
            missed: 0.0,
            gravity_shift: 0.0,
            pulled: 0,
        }
    }
}

const POINTS: [(&str, f64); 3] = [("O", 13.6e3), ("A", 7.4e3), ("B", 3.8e3)];
const WEIGHT: f64 = 2.3e3;

fn fields(truth: &Truth, moment: Moment, table: &[Vec<f64>], source: &mut Source) -> Fields {
    let mut points = Vec::new();
    for (index, (name, _)) in POINTS.iter().enumerate() {
        let shared = truth.normal.draw(source);
        let mut cell = |_| {
            let own = truth.normal.draw(source);
            truth.common * shared + (1.0 - truth.common) * own
        };
        let largest = GROWING[GROWING.len() - 1];
        let mut cells: Vec<f64> = (0..largest).map(&mut cell).collect();
        if moment == Moment::Settled {
            let shift = truth.gravity_shift;
            cells.iter_mut().for_each(|cell| *cell += shift);
        }
        let mut together = Vec::new();
        for (place, grains) in GROWING.iter().enumerate() {
            let sum: f64 = cells[..*grains].iter().sum();
            let loaded = moment == Moment::Loaded;
            let factor = if loaded { truth.factor[index] } else { 1.0 };
            let zz = sum * CELL * table[index][place] * factor;
            let (grains, cell, xx, rise) = (*grains, CELL * *grains as f64, sum * CELL, 0.0);
            together.push(Together {
                grains,
                cell,
                xx,
                zz,
                rise,
            });
        }
        let singly = (0..SINGLY).map(|cell| Neighbour {
            from_point: [0.0, 0.0],
            contacts: 4,
            cell: CELL,
            xx: 0.5 * truth.normal.draw(source),
            zz: cells[cell],
            xz: 1.0e-4 * truth.shear.draw(source),
        });
        points.push(Neighbourhood {
            point: (*name).to_owned(),
            singly: singly.collect(),
            together,
        });
    }
    let (across, down) = (Vec::new(), Vec::new());
    Fields {
        across,
        down,
        points,
    }
}

pub fn members(scene: &Scene, truth: &Truth) -> Vec<Member> {
    let tables = [Moment::Loaded, Moment::Settled].map(|moment| -> Vec<Vec<f64>> {
        let cells_at = |point: &grains::scene::ControlPoint| {
            let area = |grains: &usize| CELL * *grains as f64;
            let stress = |grains: &usize| {
                claims::continuum(scene, moment, point.offset, point.depth, area(grains))
            };
            GROWING.iter().map(stress).collect()
        };
        scene.control_points.iter().map(cells_at).collect()
    });
    (1..=truth.members)
        .map(|number| {
            let mut source = Source::new(&KEY, number);
            let missed = source.uniform() < truth.missed;
            let mut measured = BTreeMap::new();
            let mut add = |key: &str, value: f64| {
                measured.insert(key.to_owned(), value);
            };
            let definitions = ["mean_surface", "highest_grain", "twice_centre_of_mass"];
            for (definition, height) in definitions.iter().zip(truth.heights) {
                let height = height + 0.001 * source.normal();
                add(&format!("settled.height.{definition}"), height);
                let porosity = truth.porosity + 0.001 * source.normal();
                add(&format!("settled.porosity.from_{definition}"), porosity);
            }
            for key in ["in_window", "of_cells"] {
                let porosity = truth.porosity + 0.001 * source.normal();
                add(&format!("settled.porosity.{key}"), porosity);
            }
            let (mean, rattlers) = (4.0 + 0.01 * source.normal(), 0.02 * source.uniform());
            add("settled.coordination.mean", mean);
            add("settled.coordination.rattlers", rattlers);
            let moments = [("settled", false), ("loaded", true)];
            for (moment, loaded) in &moments[..2 - usize::from(missed)] {
                for (index, (point, stress)) in POINTS.iter().enumerate() {
                    let (mean, shift) = match loaded {
                        true => (stress * truth.factor[index], 0.0),
                        false => (WEIGHT, truth.gravity_shift),
                    };
                    let grain = (truth.normal.draw(&mut source) + shift) * mean;
                    let grain = if number > truth.pulled {
                        grain
                    } else {
                        -1.0e-3
                    };
                    let mut at = |what: &str, value: f64| {
                        add(&format!("{moment}.stress.{point}.{what}"), value)
                    };
                    at("grain_zz", grain);
                    at("control_volume_zz", grain * 25.0e-6);
                    at("grain_xx", truth.normal.draw(&mut source) * mean);
                    at("grain_xz", truth.shear.draw(&mut source));
                    at("local_zz", mean * (1.0 + 0.1 * source.normal()));
                }
            }
            let ending = match missed {
                true => Ending::TargetLoadNotReached,
                false => Ending::Reached,
            };
            Member {
                member: number,
                realization: number,
                ending,
                engine: "drawn".to_owned(),
                measured,
                settled: Some(fields(truth, Moment::Settled, &tables[1], &mut source)),
                loaded: (!missed).then(|| fields(truth, Moment::Loaded, &tables[0], &mut source)),
                ..Member::default()
            }
        })
        .collect()
}
