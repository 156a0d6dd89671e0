//! The recorded campaigns: what is said to have been run comes out again.

use std::path::{Path, PathBuf};

use crossgrain::campaign::compare::{Verdict, compare};
use crossgrain::campaign::merged::{Merged, read};
use crossgrain::campaign::run::again;
use crossgrain::realization::{Ending, Runner};
use crossgrain::scene::paper_scene;

fn recorded(name: &str) -> Merged {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("reference_data")
        .join(name);
    read(&folder).expect("a recorded campaign that is whole")
}

/// The native engine has the same bits on any machine: members run anew are the recorded ones, number by number.
#[test]
fn members_of_the_native_campaign_come_out_again() {
    let native = recorded("campaign-native-1");
    assert_eq!(native.plan.scene_digest, paper_scene(1, 5000).digest());
    assert!(native.members.len() >= 1000, "{}", native.members.len());
    for number in [1, 2, native.members.len() as u64] {
        let member = again(&native.plan, number).expect("it runs");
        assert_eq!(member, native.members[number as usize - 1]);
        assert_eq!(member.ending, Ending::Reached);
    }
}

/// Sorted YADE is the native engine to the last bit, contacts and punch at the end of loading included.
#[test]
fn the_recorded_sorted_yade_runs_have_the_native_bits() {
    let (native, yade) = (
        recorded("campaign-native-1"),
        recorded("campaign-yade-sorted-1"),
    );
    assert_eq!(yade.plan.runner, Runner::YadeSorted);
    let comparison = compare(&native, &yade).expect("one scene");
    assert_eq!(comparison.verdict, Verdict::SameBits);
    assert!(comparison.bits.common >= 3, "{:?}", comparison.bits);
}

/// Ordinary YADE adds in another order: other bits, packings of the same kind.
#[test]
fn the_recorded_ordinary_yade_runs_are_of_the_same_kind() {
    let (native, yade) = (
        recorded("campaign-native-1"),
        recorded("campaign-yade-ordinary-1"),
    );
    assert_eq!(yade.plan.runner, Runner::YadeOrdinary);
    assert!(yade.members.len() >= 9);
    let comparison = compare(&native, &yade).expect("one scene");
    assert_eq!(
        comparison.bits.last, 0,
        "another order of sums has other bits"
    );
    assert_ne!(comparison.verdict, Verdict::Different, "{comparison:?}");
}
