//! Two campaigns compared: every verdict can come out.

use crossgrain::checks::Outcome;
use crossgrain::study::campaign::compare::{Compared, Comparison, Packings, compare, judge};
use crossgrain::study::campaign::{Campaign, Member, Merged};
use crossgrain::study::realization::{Ending, Runner};
use crossgrain::study::{folder::Summary, plan::Plan, tradeoff::judge::QUANTITIES};
use evidence::proportion::wilson;
use evidence::random::{Key, Source, replicates};
use evidence::t_test::Finding;
use verdict::judge::Verdict;

use crate::support::*;

const HEIGHT: &str = "settled.height.mean_surface";

/// Members whose numbers vary by a tenth of their margin, or by 3 % where there is none.
fn campaign(engine: &str, seed: u64, members: u64, shift: f64) -> Merged {
    let scene = paper_scene(1, 5000);
    let runner = Runner::Native;
    let campaign = Campaign::new(&scene, runner, Vec::new(), members, seed);
    let plan = Plan::new(campaign, None).expect("a plan");
    let mut noise = Source::new(b"crossgrain: synthetic campaigns ", seed);
    let rows: Vec<Member> = (1..=members)
        .map(|number| {
            let mut measured = BTreeMap::new();
            for charted in QUANTITIES.iter() {
                let scale = charted.margin.map(|margin| 0.1 * margin.absolute(1.0));
                let scale = scale.unwrap_or(0.03);
                let moved = if charted.key == HEIGHT { shift } else { 0.0 };
                let value = 1.0 + moved + scale * noise.normal();
                measured.insert(charted.key.to_owned(), value);
            }
            Member {
                member: number,
                realization: plan.study.realization(number),
                engine: engine.to_owned(),
                ending: Ending::Reached,
                settled_state: Some(format!("settled {engine} {number}")),
                loaded_state: Some(format!("last {engine} {number}")),
                measured,
                ..Member::default()
            }
        })
        .collect();
    let summary = Summary {
        plan: plan.digest(),
        rows: rows.len() as u64,
        engine: engine.to_owned(),
        endings: BTreeMap::new(),
        sha256: String::new(),
    };
    Merged {
        plan,
        summary,
        rows,
    }
}

fn quantities(comparison: &Comparison) -> &[Compared] {
    &comparison.judged.as_ref().expect("other bits").quantities
}

fn compared(first: &Merged, second: &Merged) -> Comparison {
    compare(first, second).expect("one scene")
}

#[test]
fn the_same_realizations_with_the_same_bits() {
    let first = campaign("native", 1, 20, 0.0);
    let mut second = campaign("native", 1, 20, 0.0);
    second.rows.truncate(3);
    let comparison = compared(&first, &second);
    assert_eq!(comparison.verdict, Verdict::Identical);
    assert_eq!(comparison.bits.common, 3);
    // What is measured with something that the engine tells besides, such as where its punch started.
    let depth = second.rows[1].measured.get_mut(HEIGHT).expect("measured");
    *depth *= 1.1;
    let comparison = compared(&first, &second);
    assert_eq!([comparison.bits.settled, comparison.bits.last], [3, 2]);
    assert_ne!(comparison.verdict, Verdict::Identical);
    let depth = second.rows[1].measured.get_mut(HEIGHT).expect("measured");
    *depth = first.rows[1].measured[HEIGHT];
    // One state that differs, and it is not so any more.
    second.rows[1].loaded_state = Some("other".to_owned());
    let comparison = compared(&first, &second);
    assert_eq!([comparison.bits.settled, comparison.bits.last], [3, 2]);
    assert_ne!(comparison.verdict, Verdict::Identical);
    // Bits of some realizations say nothing of those that have no state on one side.
    let mut second = campaign("native", 1, 20, 0.0);
    for member in &mut second.rows[3..] {
        member.ending = Ending::Failed("gone".to_owned());
        (member.settled_state, member.loaded_state) = (None, None);
        member.measured.clear();
    }
    let comparison = compared(&first, &second);
    assert_eq!([comparison.bits.common, comparison.bits.last], [20, 3]);
    assert_eq!(comparison.verdict, Verdict::Different);
}

#[test]
fn other_realizations_are_equivalent_different_or_too_few() {
    let first = campaign("native", 1, 60, 0.0);
    let same = compared(&first, &campaign("YADE", 1001, 60, 0.0));
    assert_eq!(same.verdict, Verdict::EqualInDistribution, "{same:?}");
    assert_eq!(same.bits.common, 0);
    let margin = 0.002;
    let shifted = compared(&first, &campaign("YADE", 1001, 60, 2.0 * margin));
    assert_eq!(shifted.verdict, Verdict::Different);
    let height = quantities(&shifted)
        .iter()
        .find(|quantity| quantity.key == HEIGHT);
    let height = height.expect("the height is charted");
    assert!(height.power > Some(0.99), "{:?}", height.power);
    assert_eq!(height.finding, Some(Finding::Different));
    let p = height.distribution_p;
    assert!(p < Some(0.05), "{p:?}");
    let others = quantities(&shifted)
        .iter()
        .filter(|quantity| quantity.key != HEIGHT);
    let findings: Vec<_> = others.clone().map(|quantity| quantity.finding).collect();
    assert!(!findings.contains(&Some(Finding::Different)));
    assert_eq!(others.count(), QUANTITIES.len() - 1);
    // At the margin, with two packings, nothing can be shown.
    let few = compared(&first, &campaign("YADE", 1001, 2, margin));
    assert_eq!(few.verdict, Verdict::Undecided);
    assert_eq!(few.power.expect("was judged").estimate, 0.0);
    // So many are proposed as then decide.
    let three = compared(
        &campaign("native", 1, 3, 0.0),
        &campaign("YADE", 1001, 3, 0.0),
    );
    let answer = three.document().answer;
    let proposed = answer.split_once(", about ").map(|parts| parts.1);
    let proposed = proposed.and_then(|rest| rest.split(' ').next()?.parse().ok());
    let proposed: u64 = proposed.unwrap_or_else(|| panic!("{answer}"));
    assert!((4..400).contains(&proposed), "{answer}");
    let more = compared(
        &campaign("native", 1, proposed, 0.0),
        &campaign("YADE", 1001, proposed, 0.0),
    );
    assert_eq!(more.verdict, Verdict::EqualInDistribution, "{answer}");
    assert!(same.power.expect("was judged").estimate > 0.9);
    let folders = ["here", "there"].map(Path::new);
    let table = |comparison: &Comparison| {
        format!("{:?}", comparison.clone().told_apart(folders).document())
    };
    assert!(!table(&same).contains(" in here"));
    let mut twice = same.clone();
    twice.engines[1] = twice.engines[0].clone();
    has(&table(&twice), [" in here", " in there"]);
    let answer = same.document().answer;
    let begins = "Equal in distribution. With so many packings two equal engines";
    assert!(answer.starts_with(begins), "{answer}");
    let answer = shifted.document().answer;
    let begins = "These differ by more than their margins: ";
    assert!(answer.starts_with(begins), "{answer}");
    has(&answer, [height.title]);
}

#[test]
fn another_scene_is_not_compared() {
    let first = campaign("native", 1, 3, 0.0);
    let mut second = campaign("native", 1, 3, 0.0);
    second.plan.study.scene.loading.speed = 0.2;
    assert!(compare(&first, &second).is_err());
}

#[test]
fn what_is_missing_on_one_side_is_never_equivalent() {
    let first = campaign("native", 1, 60, 0.0);
    let sound = || campaign("YADE", 1001, 60, 0.0);
    assert_eq!(
        compared(&first, &sound()).verdict,
        Verdict::EqualInDistribution
    );
    let mut none = sound();
    for member in &mut none.rows {
        member.measured.remove(HEIGHT);
    }
    let mut one = sound();
    for member in &mut one.rows[1..] {
        member.measured.remove(HEIGHT);
    }
    // The force alone: every number is there.
    let mut without_force = sound();
    for member in &mut without_force.rows[..6] {
        member.ending = Ending::TargetLoadNotReached;
    }
    let mut missed = sound();
    for member in &mut missed.rows[..6] {
        member.ending = Ending::TargetLoadNotReached;
        member.measured.retain(|key, _| !key.starts_with("loaded."));
    }
    for without in [none, one, without_force, missed] {
        for pair in [compared(&first, &without), compared(&without, &first)] {
            assert_ne!(pair.verdict, Verdict::EqualInDistribution, "{pair:?}");
            assert_ne!(pair.document().verdict, Outcome::Pass);
        }
    }
}

#[test]
fn findings_follow_from_the_p_that_is_shown() {
    let first = campaign("native", 1, 60, 0.0);
    for shift in [0.0, 0.001, 0.0019, 0.0024, 0.004] {
        let comparison = compared(&first, &campaign("YADE", 1001, 60, shift));
        for quantity in quantities(&comparison) {
            let below = |p: Option<f64>| p.is_some_and(|p| p < 0.05);
            let wanted = match (below(quantity.difference_p), below(quantity.equivalence_p)) {
                _ if quantity.margin.is_none() => None,
                (true, _) => Some(Finding::Different),
                (_, true) => Some(Finding::Equivalent),
                _ => Some(Finding::Undecided),
            };
            assert_eq!(quantity.finding, wanted, "{quantity:?}");
        }
    }
}

#[test]
fn external_engines_go_through_the_same_comparison() {
    let first = campaign("native", 1, 60, 0.0);
    for (shift, verdict) in [
        (0.0, Verdict::EqualInDistribution),
        (0.004, Verdict::Different),
    ] {
        let mut second = campaign("toy 1", 1001, 60, shift);
        second.plan.study.runner = Runner::External;
        assert_eq!(compared(&first, &second).verdict, verdict);
    }
}

/// Groups of packings of one recorded campaign, drawn without replacement: they are hardly ever different, as often equal as the power
/// of the whole says, and with one mean exactly a margin off one time in twenty at most equal, and one time in twenty at most different.
#[test]
fn level_and_power_on_the_recorded_packings() {
    const KEY: Key = *b"crossgrain: tests of both sides ";
    let native = root("reference_data/campaign-native-1");
    let native = crossgrain::study::campaign::merged(&native).expect("a recorded campaign");
    let all = Packings::of(&native.rows, false);
    let (trials, side) = (400, 450);
    let groups = |source: &mut Source| {
        let mut places: Vec<usize> = (0..all.count()).collect();
        source.shuffle(&mut places);
        (all.at(&places[..side]), all.at(&places[side..2 * side]))
    };
    let share = |verdicts: &[Verdict], wanted: Verdict| {
        let hits = verdicts
            .iter()
            .filter(|verdict| **verdict == wanted)
            .count();
        wilson(hits, trials, 0.99).expect("trials")
    };
    let as_they_are = replicates(&KEY, trials, |source| {
        let (first, second) = groups(source);
        judge(&first, &second).verdict()
    });
    let different = share(&as_they_are, Verdict::Different);
    assert!(different.low <= 0.05, "{different:?}");
    let equal = share(&as_they_are, Verdict::EqualInDistribution);

    // No more than the least power of one quantity, and no less than what remains if all fail at different times.
    let (first, second) = groups(&mut Source::new(&KEY, 0));
    let told = judge(&first, &second).complete(&first, &second);
    let powers: Vec<f64> = told
        .quantities
        .iter()
        .filter_map(|quantity| quantity.power)
        .collect();
    let least = powers.iter().copied().fold(1.0, f64::min);
    let together = 1.0 - powers.iter().map(|power| 1.0 - power).sum::<f64>();
    println!("equal {equal:?}, different {different:?}, powers {powers:?}");
    let within = equal.low <= least && equal.high >= together;
    assert!(within, "{equal:?} {powers:?}");

    for key in [HEIGHT, "loaded.stress.B.local_zz"] {
        let charted = QUANTITIES.iter().find(|quantity| quantity.key == key);
        let values = native
            .rows
            .iter()
            .filter_map(|member| member.measured.get(key));
        let mean = evidence::moments::mean(&values.copied().collect::<Vec<f64>>());
        let margin = charted
            .and_then(|quantity| quantity.margin)
            .expect("a margin");
        let margin = margin.absolute(mean);
        let at_the_margin = replicates(&KEY, trials, |source| {
            let (first, second) = groups(source);
            judge(&first, &second.moved(key, margin)).verdict()
        });
        for wrong in [Verdict::EqualInDistribution, Verdict::Different] {
            let share = share(&at_the_margin, wrong);
            println!("{key} {wrong:?} {share:?}");
            assert!(share.low <= 0.05, "{key} {wrong:?} {share:?}");
        }
    }
}
