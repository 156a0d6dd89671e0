//! The merged bytes are the same for any number of shards, threads and processes, in any order.

use super::{MEMBERS, Running, expected, finishes_as_expected, merged_bytes, must, plan, study};
use crossgrain::study::{Study, campaign::Campaign, folder::StudyFolder, realization::Engines};

use crate::support::*;

#[test]
fn bytes_do_not_depend_on_threads_and_a_member_run_again_is_the_recorded_one() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    finishes_as_expected(place);
    let words = "24 of 24 rows finished, merged";
    has(&must(place, "status", &[]), [words]);
    let open = || StudyFolder::<Campaign>::open(&place.join("c")).expect("a campaign");
    let merged = open().merged().expect("a merged campaign");
    for number in [1, MEMBERS] {
        let member = merged
            .plan
            .study
            .run(number, &Engines::default(), Path::new(""));
        let member = member.expect("it runs");
        assert_eq!(member, merged.rows[number as usize - 1]);
        assert_ne!(member, merged.rows[1]);
    }
}

#[test]
fn bytes_do_not_depend_on_shards() {
    for count in [2, 3] {
        let place = &plan(&tiny_scene(), MEMBERS, "c");
        let shards: Vec<String> = (1..=count)
            .map(|index| format!("{index}/{count}"))
            .collect();
        let start = |shard: &String| Running::start(place, &["--shard", shard]);
        let running: Vec<Running> = shards.iter().map(start).collect();
        for process in running {
            let (code, errors) = process.end();
            assert_eq!(code, 0, "{errors}");
        }
        must(place, "merge", &[]);
        assert_eq!(&merged_bytes(&place.join("c")), expected(), "{count}");
    }
}

/// A third, then half of the rest, then all.
#[test]
fn a_campaign_goes_on_with_another_number_of_shards() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let said = must(place, "run", &["--shard", "2/3"]);
    has(&said, ["8 rows, 0 of them finished before"]);
    let (_, errors) = study(place, 3, "merge", &[]);
    let words = "rows 1, 3, 4, 6, 7, 9, 10, 12 and 8 more are missing";
    has(&errors, [words]);
    let said = must(place, "run", &["--shard", "1/2", "--threads", "2"]);
    has(&said, ["12 rows, 4 of them finished before"]);
    let (said, _) = study(place, 3, "status", &[]);
    has(&said, ["16 of 24 rows finished"]);
    let said = must(place, "run", &[]);
    has(&said, ["24 rows, 16 of them finished before"]);
    assert_eq!(&merged_bytes(&place.join("c")), expected());
    // Nothing is left to do, and nothing changes.
    let said = must(place, "run", &["--shard", "3/5"]);
    has(&said, ["5 rows, 5 of them finished before"]);
    finishes_as_expected(place);
}
