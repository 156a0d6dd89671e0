//! Two campaigns compared: every verdict can come out.

use std::collections::BTreeMap;

use crossgrain::checks::Outcome;
use crossgrain::study::campaign::compare::{Comparison, Verdict, compare};
use crossgrain::study::campaign::{Campaign, Member, Merged};
use crossgrain::study::machine::Summary;
use crossgrain::study::realization::{Ending, Runner};
use crossgrain::study::tradeoff::judge::QUANTITIES;
use evidence::random::Source;
use evidence::t_test::Finding;
use grains::native::Mode;
use grains::scene::paper_scene;

const HEIGHT: &str = "settled.height.mean_surface";

/// Members whose numbers vary by a tenth of their margin, or by 3 % where there is none.
fn campaign(engine: &str, seed: u64, members: u64, shift: f64) -> Merged {
    let scene = paper_scene(1, 5000);
    let runner = Runner::Native(Mode::Exact);
    let plan = Campaign::plan(&scene, runner, Vec::new(), members, seed).expect("a plan");
    let mut noise = Source::new(b"crossgrain: synthetic campaigns ", seed);
    let members: Vec<Member> = (1..=members)
        .map(|number| {
            let mut measured = BTreeMap::new();
            for charted in QUANTITIES {
                let scale = charted
                    .margin
                    .map_or(0.03, |margin| 0.1 * margin.absolute(1.0));
                let moved = if charted.key == HEIGHT { shift } else { 0.0 };
                let value = 1.0 + moved + scale * noise.normal();
                measured.insert(charted.key.to_owned(), value);
            }
            Member {
                member: number,
                realization: plan.study.realization(number),
                engine: engine.to_owned(),
                ending: Ending::Reached,
                pour_steps: 1,
                load_steps: 1,
                settled_state: Some(format!("settled {engine} {number}")),
                loaded_state: Some(format!("last {engine} {number}")),
                measured,
                settled: None,
                loaded: None,
            }
        })
        .collect();
    let summary = Summary {
        plan: plan.digest(),
        rows: members.len() as u64,
        engine: engine.to_owned(),
        endings: BTreeMap::new(),
        sha256: String::new(),
    };
    Merged {
        plan,
        summary,
        rows: members,
    }
}

fn of(first: &Merged, second: &Merged) -> Comparison {
    compare(first, second).expect("one scene")
}

#[test]
fn the_same_realizations_with_the_same_bits() {
    let first = campaign("native", 1, 20, 0.0);
    let mut second = campaign("native", 1, 20, 0.0);
    second.rows.truncate(3);
    let comparison = of(&first, &second);
    assert_eq!(comparison.verdict, Verdict::SameBits);
    assert_eq!(comparison.bits.common, 3);
    // One state that differs, and it is not so any more.
    second.rows[1].loaded_state = Some("other".to_owned());
    let comparison = of(&first, &second);
    assert_eq!([comparison.bits.settled, comparison.bits.last], [3, 2]);
    assert_ne!(comparison.verdict, Verdict::SameBits);
}

#[test]
fn other_realizations_are_equivalent_different_or_too_few() {
    let first = campaign("native", 1, 60, 0.0);
    let same = of(&first, &campaign("YADE", 1001, 60, 0.0));
    assert_eq!(same.verdict, Verdict::Equivalent, "{same:?}");
    assert_eq!(same.bits.common, 0);
    let margin = 0.002;
    let shifted = of(&first, &campaign("YADE", 1001, 60, 2.0 * margin));
    assert_eq!(shifted.verdict, Verdict::Different);
    let height = shifted.quantities.iter().find(|of| of.key == HEIGHT);
    let height = height.expect("the height is charted");
    assert_eq!(height.finding, Some(Finding::Different));
    assert!(
        height.distribution_p < Some(0.05),
        "{:?}",
        height.distribution_p
    );
    let others = shifted.quantities.iter().filter(|of| of.key != HEIGHT);
    assert!(
        others
            .clone()
            .all(|of| of.finding != Some(Finding::Different))
    );
    assert_eq!(others.count(), QUANTITIES.len() - 1);
    // At the margin, with two packings, nothing can be shown.
    let few = of(&first, &campaign("YADE", 1001, 2, margin));
    assert_eq!(few.verdict, Verdict::Undecided);
}

#[test]
fn another_scene_is_not_compared() {
    let first = campaign("native", 1, 3, 0.0);
    let mut second = campaign("native", 1, 3, 0.0);
    second.plan.study.scene.loading.speed = 0.2;
    assert!(compare(&first, &second).is_err());
}

/// Nothing is equivalent that one side does not have: a quantity of all or of some packings, or a punch's force.
#[test]
fn what_is_missing_on_one_side_is_never_equivalent() {
    let first = campaign("native", 1, 60, 0.0);
    let sound = || campaign("YADE", 1001, 60, 0.0);
    assert_eq!(of(&first, &sound()).verdict, Verdict::Equivalent);
    let mut none = sound();
    for member in &mut none.rows {
        member.measured.remove(HEIGHT);
    }
    let mut one = sound();
    for member in &mut one.rows[1..] {
        member.measured.remove(HEIGHT);
    }
    let mut missed = sound();
    for member in &mut missed.rows[..6] {
        member.ending = Ending::TargetLoadNotReached;
        member.measured.retain(|key, _| !key.starts_with("loaded."));
    }
    for without in [none, one, missed] {
        for pair in [of(&first, &without), of(&without, &first)] {
            assert_ne!(pair.verdict, Verdict::Equivalent, "{pair:?}");
            assert_ne!(pair.document().verdict, Outcome::Pass);
        }
    }
}

/// The p values that are shown are those that are judged.
#[test]
fn findings_follow_from_the_p_that_is_shown() {
    let first = campaign("native", 1, 60, 0.0);
    for shift in [0.0, 0.001, 0.0019, 0.0024, 0.004] {
        let comparison = of(&first, &campaign("YADE", 1001, 60, shift));
        for of in &comparison.quantities {
            let below = |p: Option<f64>| p.is_some_and(|p| p < 0.05);
            let wanted = match (below(of.difference_p), below(of.equivalence_p)) {
                _ if of.margin.is_none() => None,
                (true, _) => Some(Finding::Different),
                (_, true) => Some(Finding::Equivalent),
                _ => Some(Finding::Undecided),
            };
            assert_eq!(of.finding, wanted, "{of:?}");
        }
    }
}
