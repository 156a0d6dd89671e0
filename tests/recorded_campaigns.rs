//! The recorded campaigns, the claims, the candidates and the search: what is said to have been run comes out again.

use crossgrain::files::read_text;
use crossgrain::study::Study;
use crossgrain::study::campaign::{Merged, compare::compare, merged};
use crossgrain::study::candidates::{
    self,
    judge::{Candidates, Found, Judged, Verdict as Excluded},
};
use crossgrain::study::claims::{self, Claims};
use crossgrain::study::member::of_one_bed;
use crossgrain::study::realization::{Ending, Engines, Runner};
use crossgrain::study::search::{self, matching::Search};
use evidence::history::CUT;
use evidence::t_test::Finding;
use verdict::judge::Verdict;

use crate::candidates::are_sound;
use crate::support::*;

fn recorded(name: &str) -> Merged {
    let folder: PathBuf = root("reference_data").join(name);
    merged(&folder).expect("a recorded campaign that is whole")
}

/// The native engine has the same bits on any machine: members run anew are the recorded ones, number by number.
#[test]
fn members_of_the_native_campaigns_come_out_again() {
    let native = recorded("campaign-native-1");
    let digest = paper_scene(1, 5000).digest();
    assert_eq!(native.plan.study.scene_digest, digest);
    assert!(native.rows.len() >= 1000, "{}", native.rows.len());
    let best = recorded("campaign-best-1");
    let last = native.rows.len() as u64;
    for (campaign, number) in [(&native, 1), (&native, 2), (&native, last), (&best, 1)] {
        let study = &campaign.plan.study;
        let member = study.run(number, &Engines::default(), Path::new(""));
        let mut member = member.expect("it runs");
        let recorded = &campaign.rows[number as usize - 1];
        // The version says who ran it; the numbers are those of every version.
        member.engine.clone_from(&recorded.engine);
        assert_eq!(&member, recorded);
        assert_eq!(member.ending, Ending::Reached);
    }
}

#[test]
fn a_merged_campaign_has_all_of_its_rows_and_its_comparison_is_kept() {
    let folder = &new_folder();
    let recorded = root("reference_data");
    let best = format!("{}/campaign-best", recorded.display());
    let status = format!("study status {best}-1");
    tells(folder, 0, &status, ["1000 of 1000 rows finished, merged"]);
    let compared = format!("study compare {best}-1 {best}-yade-sorted-1 --json --out judged");
    let (out, _) = ends(folder, 0, &compared);
    let kept = text_of(folder.join("judged/compare.json"));
    assert_eq!(out.trim_end(), kept.trim_end());
}

/// Sorted YADE is the native engine to the last bit, contacts and punch at the end of loading included; with friction in both
/// stages too, at the best setting of the search.
#[test]
fn the_recorded_sorted_yade_runs_have_the_native_bits() {
    for (native, yade, fewest) in [
        ("campaign-native-1", "campaign-yade-sorted-1", 3),
        ("campaign-best-1", "campaign-best-yade-sorted-1", 1),
    ] {
        let yade = recorded(yade);
        assert_eq!(yade.plan.study.runner, Runner::YadeSorted);
        let comparison = compare(&recorded(native), &yade).expect("one scene");
        assert_eq!(comparison.verdict, Verdict::Identical);
        assert!(comparison.bits.common >= fewest, "{:?}", comparison.bits);
    }
}

/// 5,000 spheres with Hertz–Mindlin springs, dashpots, friction and moments, poured, settled and pressed.
#[test]
fn the_recorded_spheres_of_yade_have_the_native_bits() {
    let yade = recorded("campaign-spheres-yade-sorted-1");
    let mut study = yade.plan.study;
    assert_eq!(study.runner, Runner::YadeSorted);
    assert_eq!(study.scene.particles.count, 5000);
    study.runner = Runner::Native;
    let member = study.run(1, &Engines::default(), Path::new(""));
    let mut member = member.expect("it runs");
    assert_eq!(member.ending, Ending::Reached);
    member.engine.clone_from(&yade.rows[0].engine);
    assert_eq!(member, yade.rows[0]);
}

/// Ordinary YADE adds in another order: other bits, packings of the same kind.
#[test]
fn the_recorded_ordinary_yade_runs_are_of_the_same_kind() {
    for (native, yade, members) in [
        ("campaign-native-1", "campaign-yade-ordinary-1", 9),
        ("campaign-best-1", "campaign-best-yade-ordinary-1", 8),
    ] {
        let yade = recorded(yade);
        assert_eq!(yade.plan.study.runner, Runner::YadeOrdinary);
        assert_eq!(yade.rows.len(), members);
        let comparison = compare(&recorded(native), &yade).expect("one scene");
        assert_eq!(comparison.bits.last, 0);
        assert_ne!(comparison.verdict, Verdict::Different, "{comparison:?}");
        let judged = comparison.judged.expect("other bits");
        let mut quantities = judged.quantities.iter();
        let height = quantities.find(|quantity| quantity.key == "settled.height.mean_surface");
        assert_eq!(
            height.and_then(|height| height.finding),
            Some(Finding::Equivalent)
        );
    }
}

/// LAMMPS adds in an order of its own too. Twenty packings decide heights; what they cannot decide is called undecided.
#[test]
fn the_recorded_lammps_runs_have_heights_as_native_ones() {
    let [native, lammps] = ["campaign-native-half-1", "campaign-lammps-half-1"].map(recorded);
    assert!(lammps.summary.engine.starts_with("LAMMPS"));
    let comparison = compare(&native, &lammps).expect("one scene");
    assert_ne!(comparison.verdict, Verdict::Different);
    let judged = comparison.judged.expect("other bits");
    for (key, finding) in [
        ("settled.height.mean_surface", Finding::Equivalent),
        ("settled.height.highest_grain", Finding::Equivalent),
        ("loaded.stress.O.local_zz", Finding::Undecided),
    ] {
        let found = judged
            .quantities
            .iter()
            .find(|quantity| quantity.key == key);
        assert_eq!(found.expect("is judged").finding, Some(finding), "{key}");
    }
}

#[test]
fn the_recorded_claims_are_those_of_the_recorded_members() {
    let folder = root("reference_data/claims-1");
    let text = read_text(&folder.join("claims.json.gz"), 1 << 24).expect("is there");
    let recorded: Claims = serde_json::from_str(&text).expect("claims");
    let native = self::recorded("campaign-native-1");
    let origin = recorded.origin.clone();
    assert_eq!(origin.members_digest, native.summary.sha256);
    let mut again = claims::of(&native.plan.study.scene, &native.rows, origin);
    again.crossgrain.clone_from(&recorded.crossgrain);
    let best = self::recorded("campaign-best-1");
    let origin = recorded.beside.as_ref().map(|claims| claims.origin.clone());
    let origin = origin.expect("the best setting stands beside");
    assert_eq!(origin.members_digest, best.summary.sha256);
    again.beside = Some(claims::of(&best.plan.study.scene, &best.rows, origin).into());
    assert!(again == recorded);
}

/// Figures that the setting does not give.
fn missed(found: &Found) -> Vec<&str> {
    let figures = found.figures.iter();
    let missed = figures.filter(|figure| figure.verdict == Excluded::DoesNot);
    missed.map(|figure| figure.id.as_str()).collect()
}

/// The settings settled by many packings say what their rows say; no figure of the search's best is excluded, and grains that
/// cannot turn have a quasi-static limit.
#[test]
fn the_recorded_candidates_are_those_of_their_rows() {
    let (_, recorded) = judged_again::<candidates::Plan, Candidates>("reference_data/candidates-1");
    for (id, misses) in [("best-1", false), ("printed", true)] {
        let found = recorded
            .settings
            .iter()
            .find(|found| found.setting.id == id);
        assert_eq!(
            found.map(|found| !missed(found).is_empty()),
            Some(misses),
            "{id}"
        );
    }
    let last = recorded.halvings.last().map(|halving| halving.finding);
    assert_eq!(last, Some(Finding::Equivalent));
}

/// One choice at a time, no setting gives all published figures, and a force that is held is not the force of an impact.
#[test]
fn the_recorded_choices_are_those_of_their_rows() {
    let (_, recorded) = judged_again::<candidates::Plan, Candidates>("reference_data/choices-1");
    assert_eq!(recorded.settings.len(), 52);
    let excluded = recorded
        .settings
        .iter()
        .filter(|found| !missed(found).is_empty());
    assert_eq!(excluded.count(), 51);
    let at_o = |id: &str| {
        let setting = recorded
            .settings
            .iter()
            .find(|found| found.setting.id == id);
        let figure = setting.and_then(|setting| {
            setting
                .figures
                .iter()
                .find(|figure| figure.id == "stress.O")
        });
        figure.and_then(|figure| figure.value).expect("a mean")
    };
    assert!(at_o("hold-after-the-force-0.01").high < at_o("printed").low);
}

/// A slow punch needs friction, a fast one does not: by all settings of the recorded search, and as docs/sensitivity.md says.
#[test]
fn friction_bears_the_load_of_slow_punches() {
    let recorded: Search = recorded_of(root("reference_data/search-1/wave-2"));
    let classes = recorded.borne();
    let counted: usize = classes.iter().map(|class| class.settings).sum();
    assert_eq!(counted, recorded.observed.len());
    let class = |friction: f64, speed: f64| {
        let mut all = classes.iter();
        let own = all.find(|class| class.friction[1] == friction && class.speed[0] == speed);
        *own.expect("a class")
    };
    let share = |friction, speed| class(friction, speed).share().expect("settings");
    assert!(share(0.0, 0.02).high < share(0.6, 0.02).low);
    assert!(share(0.0, 0.02).high < share(0.0, 0.08).low);
    let text = text_of(root("docs/sensitivity.md"));
    for (friction, speed) in [(0.0, 0.02), (0.6, 0.02), (0.0, 0.08)] {
        let class = class(friction, speed);
        has(&text, [&format!("{} of {}", class.borne, class.settings)]);
    }
    let setup = crossgrain::paper::continuum::table::Setup::published();
    for depth in [0.0, 0.04, 0.11] {
        let angle = crossgrain::paper::bearing::needed(&setup, depth).to_degrees();
        has(&text, [&format!("{angle:.1}°")]);
    }
}

/// Around the search's best setting the choices that its space lacks change no mean but by a grain's volume, and a wide dispersion
/// has another porosity.
#[test]
fn the_recorded_choices_around_the_best_setting_are_those_of_their_rows() {
    let path = "reference_data/choices-best-1";
    let (_, recorded) = judged_again::<candidates::Plan, Candidates>(path);
    assert_eq!(recorded.settings.len(), 13);
    for found in &recorded.settings {
        let missed = missed(found);
        let is_wide = found.setting.id.ends_with("-0.1") || found.setting.id.ends_with("-0.2");
        assert_eq!(missed.contains(&"porosity"), is_wide, "{missed:?}");
        let stresses = found
            .figures
            .iter()
            .filter(|figure| figure.id.starts_with("stress."));
        let moved = |figure: &&Judged| {
            figure
                .change
                .is_some_and(|change| change.low > 0.0 || change.high < 0.0)
        };
        let expected = 3 * usize::from(found.setting.axis == "volume of a grain");
        assert_eq!(stresses.filter(moved).count(), expected);
    }
}

/// Each recorded wave of the search says what its rows say, and a load of the last one comes out again.
#[test]
fn the_recorded_search_is_that_of_its_rows() {
    for wave in ["wave-1", "wave-2"] {
        let path = format!("reference_data/search-1/{wave}");
        let (folder, recorded) = judged_again::<search::Plan, Search>(&path);
        assert!(recorded.found_again.is_some_and(|share| share.low > 0.9));
        assert!(recorded.of_impossible.is_some_and(|least| least > CUT));
        if wave == "wave-2" {
            let around = candidates::Plan::of_choices(false, 3, Some(&recorded), false);
            let axes = are_sound(&around, "best-1");
            assert!(axes.contains("friction of the punch") && !axes.contains("settle rule"));
            let setting = [folder.plan.study.beds.0[0][0].clone()];
            let cloud = setting[0].realizations().next().expect("a cloud");
            let again = of_one_bed(&setting, cloud, search::matching::keep).expect("it runs");
            let merged = folder.merged().expect("merged");
            let mut all = merged.rows.iter().flatten();
            let digest = setting[0].specification.digest();
            let own =
                all.find(|member| member.specification == digest && member.realization == cloud);
            assert_eq!(Some(&again[0]), own);
        }
    }
}
