//! The search for settings that give the published figures, on beds small enough for a test.

use crossgrain::report;
use crossgrain::study::realization::Engines;
use crossgrain::study::search::matching::{Figure, Observed, Sampled, Search, keep};
use crossgrain::study::search::space::{AXES, OF_POURING, scene, snap};
use crossgrain::study::search::{Plan, Size};
use crossgrain::study::{Study, folder::StudyFolder, member::Member};
use evidence::history::CUT;

use crate::support::*;
use crate::tradeoff::made;

const SIZE: Size = Size {
    beds: 8,
    loads: 2,
    clouds: 3,
};

#[test]
fn every_corner_of_the_space_is_a_sound_scene_and_every_choice_changes_it() {
    let base = tiny_scene();
    for corner in 0..1 << AXES.len() {
        let at = (0..AXES.len()).map(|axis| f64::from(corner >> axis & 1));
        let mut at: Vec<f64> = at.collect();
        snap(&mut at);
        let own = scene(&base, &at);
        let read = parse_scene(&serde_json::to_string(&own).expect("JSON"));
        assert_eq!(read.expect("sound"), own);
    }
    let middle = vec![0.6; AXES.len()];
    for axis in 0..AXES.len() {
        let mut other = middle.clone();
        other[axis] = 0.1;
        let [one, other] = [middle.as_slice(), &other].map(|at| scene(&base, at));
        assert_ne!(one.digest(), other.digest(), "{}", AXES[axis].name);
        // Loads have the bed in common but for what is measured.
        let mut measured_alike = other;
        measured_alike.measurement = one.measurement.clone();
        let alike = one.pours_like(&measured_alike);
        assert_eq!(alike, axis >= OF_POURING, "{}", AXES[axis].name);
    }
}

#[test]
fn a_wave_has_whole_runs_in_its_rows_and_excludes_beds_that_are_too_low() {
    let plan = Plan::first(tiny_scene(), SIZE);
    assert_eq!(plan.count(), 24);
    let (_place, folder) = made(plan.clone());
    let folder = StudyFolder::<Plan>::open(&folder).expect("a study");
    let mut rows: Vec<Vec<Member>> = Vec::new();
    folder.each(|_, row| rows.push(row)).expect("rows");
    let setting = &plan.beds.0[3][1];
    let cloud = setting.realizations().nth(2).expect("three clouds");
    let mut all = rows.iter().flatten();
    let own = all.find(|member| {
        member.specification == setting.specification.digest() && member.realization == cloud
    });
    let engines = Engines::default();
    let whole = Member::run(&setting.specification, cloud, &engines, Path::new(""), keep);
    let whole = Member {
        cost: None,
        ..whole.expect("it runs")
    };
    assert_eq!(own, Some(&whole));

    // A bed of a hundred grains is a tenth of a metre high.
    let mut found = Search::of(&plan, &rows.into_iter().flatten().collect());
    assert_eq!(found.observed.len(), 16);
    assert!(found.is_none_left());
    // Emulators that know what they do not know find each setting by its own results, and no figures that cannot be.
    let again = found.found_again.expect("settings were run");
    assert!(again.estimate > 0.9, "{again:?}");
    assert!(found.of_impossible.is_some_and(|least| least > CUT));
    let height = &found.figures[0];
    assert!(height.id == "height" && height.least > CUT, "{height:?}");
    for (inflation, why) in [(1.0, "no setting is left"), (1.6, "not good enough")] {
        found.figures[0].inflation = inflation;
        for figure in &mut found.figures[1..] {
            figure.inflation = 1.0;
        }
        let none = plan.next(&found, SIZE).expect_err(why);
        assert!(none.contains(why), "{none}");
    }
    let document = found.document();
    let page = report::page(&document);
    assert!(page.html.contains("Which figure stands against which"));
}

/// What a simulation with these laws would have given, published where the truth is.
fn made_up(truth: &[f64]) -> (Plan, Search) {
    let size = Size { beds: 40, ..SIZE };
    let plan = Plan::first(tiny_scene(), size);
    let mut search = Search::of(&plan, &[].into_iter().collect());
    let law = |figure: usize, at: &[f64]| 10.0 + 4.0 * at[figure] - 3.0 * at[figure + 4];
    search.figures.truncate(3);
    for (index, figure) in search.figures.iter_mut().enumerate() {
        (figure.value, figure.deviation) = (law(index, truth), 0.1);
        figure.inflation = 1.0;
    }
    let ids = search
        .figures
        .iter()
        .map(|figure: &Figure| figure.id.clone());
    let ids: Vec<String> = ids.collect();
    for (bed, loads) in (0..).zip(&plan.beds.0) {
        for setting in loads {
            let at = setting.at.clone();
            let means = ids.iter().enumerate().map(|(index, _)| law(index, &at));
            let sampled = means.map(|mean| Sampled {
                count: 3,
                mean,
                variance: 0.01,
            });
            let sampled = ids.iter().cloned().zip(sampled).collect();
            search.observed.push(Observed { at, bed, sampled });
        }
    }
    (plan, search)
}

#[test]
fn the_next_wave_is_near_the_setting_that_made_the_figures() {
    let mut truth = vec![0.4; AXES.len()];
    snap(&mut truth);
    let (plan, search) = made_up(&truth);
    let fitted = search.fitted().expect("emulators");
    let matched = search.matched(&fitted);
    assert!(matched.candidate(truth).is_left());
    let next = plan.next(&search, SIZE).expect("something is left");
    let counts = (next.wave, next.beds.0.len(), next.before.len());
    assert_eq!(counts, (2, 8, 80));
    next.check().expect("sound");
    let clouds = |plan: &Plan| -> Vec<[u64; 2]> {
        let beds = plan.beds.0.iter();
        beds.map(|bed| bed[0].clouds[0]).collect()
    };
    for range in clouds(&next) {
        assert!(!clouds(&plan).contains(&range));
    }
    for setting in next.beds.0.iter().flatten() {
        let candidate = matched.candidate(setting.at.clone());
        assert!(candidate.is_left(), "{candidate:?}");
    }
}

/// What the recorded picture shows: filled cells, the values of each choice along both sides, each name once, and a sentence.
#[test]
fn the_picture_has_values_on_its_axes_and_says_which_choices_matter() {
    let recorded: Search = recorded_of(root("reference_data/search-1/wave-2"));
    let page = report::page(&recorded.document());
    let words = words_apart(&page, "pairs.svg");
    let count = |word: &str| words.iter().filter(|seen| *seen == word).count();
    for axis in &AXES {
        for (_, word) in axis.scale.ticks() {
            assert!(count(&word) >= 2, "{}: {word}", axis.name);
        }
    }
    // Names stand in lines of a few words.
    let all = words.join(" ");
    for axis in &AXES {
        has(&all, [axis.name]);
    }
    let svg = page.files.iter().find(|file| file.0.ends_with("pairs.svg"));
    assert!(!svg.expect("a picture").1.contains("<circle"));
    let said = "only a part of their range, whatever the others are: friction in pouring 0 to 0.24 rad (of 0 to 0.6)";
    has(
        &page.html,
        [said, "mean diameter 9.6 to 10.2 mm (of 9 to 10.2)"],
    );
}
