//! Every verdict can go either way: members drawn from known laws, with one thing wrong at a time.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crossgrain::campaign::member::{Fields, Member};
use crossgrain::campaign::merge::Summary;
use crossgrain::campaign::plan::Plan;
use crossgrain::claims::claim::Verdict;
use crossgrain::claims::{self, Claims, Moment, Origin};
use crossgrain::engine::native::Mode;
use crossgrain::files::sha256_hex;
use crossgrain::measure::neighbourhood::{GROWING, Neighbour, Neighbourhood, SINGLY, Together};
use crossgrain::realization::{Ending, Runner};
use crossgrain::scene::{Scene, paper_scene};
use crossgrain::statistics::law::Law;
use crossgrain::statistics::random::{Key, Source};

use crate::support::{crossgrain, told};

const KEY: Key = *b"crossgrain: tests of the claims.";
const CELL: f64 = 9.4e-5;

/// What the members are drawn from; [`Truth::paper`] is everything that the paper claims.
#[derive(Clone)]
struct Truth {
    members: u64,
    /// Of σ_zz and σ_xx over their means.
    normal: Law,
    /// Of σ_xz, Pa.
    shear: Law,
    /// Factor of the mean at each point, under the load.
    factor: [f64; 3],
    /// Share of a cell's stress that is common to all cells of a point.
    common: f64,
    /// H by each definition.
    heights: [f64; 3],
    porosity: f64,
    /// Share of members that sink.
    sank: f64,
    /// Added to every σ_zz under gravity, over its mean.
    gravity_shift: f64,
}

impl Truth {
    fn paper() -> Self {
        Truth {
            members: 600,
            normal: Law::Exponential { mean: 1.0 },
            shear: Law::Laplace {
                location: 0.0,
                scale: 3000.0,
            },
            factor: [1.0; 3],
            common: 0.0,
            heights: [0.462; 3],
            porosity: 0.168,
            sank: 0.0,
            gravity_shift: 0.0,
        }
    }
}

const POINTS: [(&str, f64); 3] = [("O", 13.6e3), ("A", 7.4e3), ("B", 3.8e3)];
const WEIGHT: f64 = 2.3e3;

fn fields(truth: &Truth, moment: Moment, table: &[Vec<f64>], source: &mut Source) -> Fields {
    let mut points = Vec::new();
    for (index, (name, _)) in POINTS.iter().enumerate() {
        let shared = truth.normal.draw(source);
        let mut cells: Vec<f64> = (0..GROWING[GROWING.len() - 1])
            .map(|_| {
                let own = truth.normal.draw(source);
                truth.common * shared + (1.0 - truth.common) * own
            })
            .collect();
        if moment == Moment::Settled {
            cells
                .iter_mut()
                .for_each(|cell| *cell += truth.gravity_shift);
        }
        let mut together = Vec::new();
        for (place, grains) in GROWING.iter().enumerate() {
            let sum: f64 = cells[..*grains].iter().sum();
            let factor = if moment == Moment::Loaded {
                truth.factor[index]
            } else {
                1.0
            };
            together.push(Together {
                grains: *grains,
                cell: CELL * *grains as f64,
                xx: sum * CELL,
                zz: sum * CELL * table[index][place] * factor,
                rise: 0.0,
            });
        }
        let singly = (0..SINGLY).map(|cell| Neighbour {
            from_point: [0.0, 0.0],
            contacts: 4,
            cell: CELL,
            xx: cells[cell],
            zz: cells[cell],
            xz: 0.0,
        });
        points.push(Neighbourhood {
            point: (*name).to_owned(),
            singly: singly.collect(),
            together,
        });
    }
    Fields {
        across: Vec::new(),
        down: Vec::new(),
        points,
    }
}

fn members(scene: &Scene, truth: &Truth) -> Vec<Member> {
    let tables = [Moment::Loaded, Moment::Settled].map(|moment| -> Vec<Vec<f64>> {
        let of = |point: &crossgrain::scene::ControlPoint| {
            let area = |grains: &usize| CELL * *grains as f64;
            let stress = |grains: &usize| {
                claims::continuum(scene, moment, point.offset, point.depth, area(grains))
            };
            GROWING.iter().map(stress).collect()
        };
        scene.control_points.iter().map(of).collect()
    });
    (1..=truth.members)
        .map(|number| {
            let mut source = Source::new(&KEY, number);
            let sank = source.uniform() < truth.sank;
            let mut measured = BTreeMap::new();
            let mut add = |key: String, value: f64| {
                measured.insert(key, value);
            };
            let definitions = ["mean_surface", "highest_grain", "twice_centre_of_mass"];
            for (definition, height) in definitions.iter().zip(truth.heights) {
                add(
                    format!("settled.height.{definition}"),
                    height + 0.001 * source.normal(),
                );
                add(
                    format!("settled.porosity.from_{definition}"),
                    truth.porosity + 0.001 * source.normal(),
                );
            }
            for key in ["in_window", "of_cells"] {
                add(
                    format!("settled.porosity.{key}"),
                    truth.porosity + 0.001 * source.normal(),
                );
            }
            add(
                "settled.coordination.mean".to_owned(),
                4.0 + 0.01 * source.normal(),
            );
            add(
                "settled.coordination.rattlers".to_owned(),
                0.02 * source.uniform(),
            );
            let moments: &[(&str, bool)] = if sank {
                &[("settled", false)]
            } else {
                &[("settled", false), ("last", true)]
            };
            for (moment, loaded) in moments {
                for (index, (point, stress)) in POINTS.iter().enumerate() {
                    let mean = if *loaded {
                        stress * truth.factor[index]
                    } else {
                        WEIGHT
                    };
                    let shift = if *loaded { 0.0 } else { truth.gravity_shift };
                    let grain = (truth.normal.draw(&mut source) + shift) * mean;
                    let mut at = |what: &str, value: f64| {
                        add(format!("{moment}.stress.{point}.{what}"), value)
                    };
                    at("grain_zz", grain);
                    at("control_volume_zz", grain * 25.0e-6);
                    at("grain_xx", truth.normal.draw(&mut source) * mean);
                    at("grain_xz", truth.shear.draw(&mut source));
                    at("local_zz", mean * (1.0 + 0.1 * source.normal()));
                }
            }
            Member {
                member: number,
                realization: number,
                engine: "drawn".to_owned(),
                ending: if sank { Ending::Sank } else { Ending::Reached },
                pour_steps: 1,
                load_steps: 1,
                settled_state: None,
                last_state: None,
                measured,
                settled: Some(fields(truth, Moment::Settled, &tables[1], &mut source)),
                last: (!sank).then(|| fields(truth, Moment::Loaded, &tables[0], &mut source)),
            }
        })
        .collect()
}

fn claims_of(truth: &Truth) -> Claims {
    let scene = paper_scene(1, 5000);
    let origin = Origin {
        command: "a test".to_owned(),
        engine: "drawn".to_owned(),
        plan: String::new(),
        members_digest: String::new(),
    };
    claims::of(&scene, &members(&scene, truth), origin)
}

fn verdict(claims: &Claims, id: &str) -> Option<Verdict> {
    let found = claims.claims.iter().find(|claim| claim.id == id);
    found.unwrap_or_else(|| panic!("no claim {id}")).verdict
}

/// Everything holds except what is listed.
fn only(claims: &Claims, others: &[(&str, Verdict)]) {
    for claim in &claims.claims {
        let wanted = others.iter().find(|(id, _)| *id == claim.id);
        let wanted = wanted.map_or(Verdict::Holds, |(_, verdict)| *verdict);
        assert_eq!(
            claim.verdict,
            Some(wanted),
            "{}: {}\n{:#?}",
            claim.id,
            claim.reading,
            claim.rows
        );
    }
}

const NO: Verdict = Verdict::DoesNotHold;

#[test]
fn what_the_paper_claims_holds_if_it_is_true() {
    let claims = claims_of(&Truth::paper());
    only(&claims, &[]);
    assert!(claims.complete);
    assert_eq!(claims.verdicts["holds"], claims.claims.len());
    assert_eq!(claims.endings["reached"], 600);
    assert!(claims.other_choices.is_empty());
    assert_eq!(claims.figures.figure5.len(), 3);
    assert_eq!(claims.figures.volumes.len(), 6);

    // The p-values stand beside the effects. All statements are true: none is rejected after adjusting.
    let rows = claims.claims.iter().flat_map(|claim| &claim.rows);
    let all: Vec<_> = rows.flat_map(|row| &row.probabilities).collect();
    assert!(all.len() > 50, "{}", all.len());
    assert!(all.iter().all(|one| one.adjusted >= one.p));
    assert!(all.iter().all(|one| one.adjusted > 0.05), "{all:#?}");
}

/// Gamma laws of shape 2 are no exponentials, and their sums no Erlang laws of shape N; means stay.
#[test]
fn another_form_is_noticed() {
    let truth = Truth {
        normal: Law::Gamma {
            shape: 2.0,
            scale: 0.5,
        },
        ..Truth::paper()
    };
    only(
        &claims_of(&truth),
        &[
            ("exponential.O", NO),
            ("exponential.A", NO),
            ("exponential.B", NO),
            ("exponential.theory", NO),
            ("exponential.xx", NO),
            ("exponential.gravity", NO),
            ("variation.load", NO),
            ("variation.gravity", NO),
            ("erlang", NO),
            ("conclusion", NO),
        ],
    );
}

/// A third more at A: what is said of A and of all points fails, what is said of O, B and of forms does not.
#[test]
fn a_biased_mean_is_noticed() {
    let truth = Truth {
        factor: [1.0, 1.3, 1.0],
        ..Truth::paper()
    };
    only(
        &claims_of(&truth),
        &[
            ("mean.A", NO),
            ("extensive", NO),
            ("exponential.theory", NO),
            ("large_scale", NO),
            ("conclusion", NO),
        ],
    );
}

/// Half of every cell's stress in common: neighbours correlate, and the variation stops to fall.
#[test]
fn cells_that_hang_together_are_noticed() {
    let truth = Truth {
        common: 0.4,
        members: 320,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    for id in [
        "independence",
        "variation.load",
        "variation.gravity",
        "erlang",
        "large_scale",
    ] {
        assert_eq!(verdict(&claims, id), Some(NO), "{id}");
    }
    let exponent = claims.figures.volumes[0].exponent.expect("many packings");
    assert!(exponent.low > -0.3, "{exponent:?}");
    assert_eq!(claims.figures.volumes[0].enough, None);
    let correlation = claims.figures.volumes[0].volumes[4].correlation;
    // 0.4²/(0.4² + 0.6²) = 0.308.
    assert!((correlation.expect("sixteen cells") - 0.308).abs() < 0.08);
}

#[test]
fn heights_are_read_by_definition() {
    let truth = Truth {
        members: 320,
        heights: [0.462, 0.49, 0.44],
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert_eq!(
        verdict(&claims, "height"),
        Some(Verdict::HoldsUnderStatedChoices)
    );
    assert_eq!(
        verdict(&claims, "height_and_porosity"),
        Some(Verdict::HoldsUnderStatedChoices)
    );
    let truth = Truth {
        members: 320,
        heights: [0.44; 3],
        porosity: 0.13,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    for id in ["height", "porosity", "height_and_porosity"] {
        assert_eq!(verdict(&claims, id), Some(NO), "{id}");
    }
}

/// Members that sank are counted, and nothing is said of means under load as if they were not.
#[test]
fn sunk_members_are_not_hidden() {
    let truth = Truth {
        sank: 0.3,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert_eq!(verdict(&claims, "reached"), Some(Verdict::CannotBeDecided));
    assert!((150..210).contains(&claims.endings["sank"]));
    let reached = claims.claims.iter().find(|claim| claim.id == "reached");
    let rows = &reached.expect("the claim").rows;
    assert!(
        rows.iter()
            .any(|row| row.what == "bias of height" && row.ours.is_some())
    );
    let mean = claims
        .claims
        .iter()
        .find(|claim| claim.id == "mean.O")
        .expect("the claim");
    assert_eq!(mean.rows[0].packings, claims.endings["reached"]);
}

#[test]
fn normal_shear_and_tension_are_noticed() {
    let truth = Truth {
        // Sums of many: a normal law as near as needed.
        shear: Law::Gamma {
            shape: 400.0,
            scale: 100.0,
        },
        gravity_shift: -0.1,
        members: 320,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert_eq!(verdict(&claims, "laplace"), Some(NO));
    assert_eq!(verdict(&claims, "positive"), Some(NO));
    assert_eq!(verdict(&claims, "exponential.O"), Some(Verdict::Holds));
}

/// Twenty members say nothing, and the record says so.
#[test]
fn few_members_leave_claims_open() {
    let truth = Truth {
        members: 20,
        ..Truth::paper()
    };
    let claims = claims_of(&truth);
    assert!(!claims.complete);
    assert_eq!(claims.verdicts["open"], claims.claims.len());
    // None at all is no panic either.
    let none = claims_of(&Truth {
        members: 0,
        ..Truth::paper()
    });
    assert!(!none.complete);
    assert!(serde_json::to_string(&none).is_ok());
}

/// Writes members as a merged campaign.
fn write_campaign(folder: &Path, truth: &Truth) {
    let scene = paper_scene(1, 5000);
    let runner = Runner::Native(Mode::Exact);
    let plan = Plan::new(&scene, runner, Vec::new(), truth.members, 1).expect("a plan");
    plan.write(folder).expect("a new folder");
    let lines: String = members(&scene, truth)
        .iter()
        .map(|member| serde_json::to_string(member).expect("JSON") + "\n")
        .collect();
    let summary = Summary {
        plan: plan.digest(),
        members: truth.members,
        engine: "drawn".to_owned(),
        endings: BTreeMap::from([("reached".to_owned(), truth.members)]),
        sha256: sha256_hex(lines.as_bytes()),
    };
    let summary = serde_json::to_string(&summary).expect("JSON");
    for (name, text) in [("members.jsonl", lines), ("merged.json", summary)] {
        fs::write(folder.join(name), text).expect("a writable folder");
    }
}

/// Exit code 0 where every claim has a verdict and 3 where one is open; record and page are written either way.
#[test]
fn the_verb_writes_record_and_page_and_tells_whether_all_is_decided() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    for (name, count, wanted) in [("many", 600, 0), ("few", 20, 3)] {
        let truth = Truth {
            members: count,
            ..Truth::paper()
        };
        write_campaign(&at.join(name), &truth);
        let out = format!("{name}-claims");
        let (code, said, errors) =
            told(&crossgrain(&["claims", name, "--out", &out, "--json"], at));
        assert_eq!((code, errors.as_str()), (wanted, ""), "{name}");
        let record = fs::read_to_string(at.join(&out).join("claims.json")).expect("a record");
        assert_eq!(record, said, "{name}");
        let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
        assert_eq!(record["complete"], code == 0);
        let page = fs::read_to_string(at.join(&out).join("report.html")).expect("a page");
        // Three points in each of four histograms, six volumes, the means and the plane.
        assert_eq!(page.matches("<svg").count(), 20, "{name}");
        assert!(!page.contains("NaN"), "{name}");
    }
    // A folder that is there is never written into.
    let (code, _, errors) = told(&crossgrain(&["claims", "many", "--out", "few-claims"], at));
    assert_eq!(code, 2);
    assert!(errors.contains("exists already"), "{errors}");
    // Without --out it only says.
    let (code, said, _) = told(&crossgrain(&["claims", "few"], at));
    assert_eq!(code, 3);
    assert!(said.contains("open: too few members"), "{said}");
}
