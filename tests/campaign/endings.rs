//! Members that go wrong are rows; engines that go wrong are not. What is said while a campaign runs.

use crossgrain::study::campaign::{Merged, merged};
use crossgrain::study::realization::{Ending, Runner};
use grains::scene::TimeStep;

use super::{campaign, must, plan, plan_of, study};
use crate::support::*;
use crate::yade_driver::yade;

/// Runs twelve members of the scene, merges them, and returns the column `ending` of `rows.csv` with the members.
fn endings(scene: &Scene) -> (Vec<String>, Merged, String) {
    let place = &plan(scene, 12, "c");
    let said = must(place, "run", &["--threads", "2"]);
    must(place, "status", &[]);
    let folder = place.join("c");
    let table = text_of(folder.join("rows.csv"));
    let mut rows = table.lines();
    let columns = rows.next().expect("a header").split(',').count();
    let endings = rows.map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        assert_eq!(cells.len(), columns, "{row}");
        cells[2].to_owned()
    });
    let endings = endings.collect();
    (endings, merged(&folder).expect("a merged campaign"), said)
}

fn count(endings: &[String], wanted: &str) -> usize {
    endings.iter().filter(|ending| *ending == wanted).count()
}

/// Too few steps for some, too shallow a way for the punch of the others.
#[test]
fn members_that_do_not_settle_or_sink_are_rows() {
    let mut scene = tiny_scene();
    scene.settle.max_steps = 20_000;
    scene.loading.give_up_depth = 0.002;
    let (endings, merged, said) = endings(&scene);
    let missed = count(&endings, "target_load_not_reached");
    let not_settled = count(&endings, "not_settled");
    assert!(missed > 0 && not_settled > 0, "{endings:?}");
    assert_eq!(missed + not_settled, 12);
    let words =
        &format!("{not_settled} did not settle, {missed} did not get the force on the punch");
    has(&said, [words]);
    for member in &merged.rows {
        let settled = member.ending == Ending::TargetLoadNotReached;
        assert_eq!(member.settled.is_some(), settled);
        assert!(member.loaded.is_none());
        assert!(member.measured.values().all(|value| value.is_finite()));
    }
}

/// A time step at which the beds of some realizations fly apart.
#[test]
fn members_whose_engine_gives_up_are_rows_with_its_words() {
    let mut scene = tiny_scene();
    let of_sqrt_m_over_k = 1.25;
    scene.time_step = TimeStep::Fraction { of_sqrt_m_over_k };
    scene.settle.max_steps = 20_000;
    let (endings, merged, _) = endings(&scene);
    let failed = count(&endings, "failed");
    assert!(failed > 0 && failed < 12, "{endings:?}");
    assert_eq!(merged.summary.endings["failed"], failed as u64);
    for member in &merged.rows {
        if let Ending::Failed(reason) = &member.ending {
            has(reason, ["has left the box"]);
        }
    }

    // All of them: there is no engine to name, and still a campaign.
    let of_sqrt_m_over_k = 2.5;
    scene.time_step = TimeStep::Fraction { of_sqrt_m_over_k };
    let (endings, merged, said) = self::endings(&scene);
    assert_eq!(count(&endings, "failed"), 12);
    assert_eq!(merged.summary.engine, "");
    has(
        &said,
        ["merged 12 rows: 12 ended by an error of the engine"],
    );
}

/// Two grains that never settle, poured by a program that is not YADE: it writes back the start as the end, and what
/// `also` says goes wrong before that.
fn with_yade(members: u64, also: &str) -> Place {
    let mut scene = tiny_scene();
    scene.particles.count = 2;
    scene.settle.max_steps = 10;
    scene.settle.check_every = 10;
    let place = plan_of(&scene, Runner::YadeSorted, members, "c");
    let does = format!(
        "member = int(os.path.basename(job.rstrip('/')))\n{also}\n\
         frames(fine + fine, [frame(0), frame(10), end(10, 'max_steps')])"
    );
    yade(&place, "yade", &does);
    place
}

const WITH_IT: [&str; 4] = ["--threads", "2", "--yade", "./yade"];

/// A YADE that crashes for some members: the others are written down, and the same command goes on.
#[test]
fn a_broken_engine_is_no_row() {
    let fails = "if member in (2, 5) and not os.path.exists('mended'): raise SystemExit('broken')";
    let place = with_yade(6, fails);
    // A program is started where it is needed, not where this one is.
    let mended = place.join("mended");
    let text = text_of(place.join("yade"));
    let text = text.replace("'mended'", &format!("{:?}", mended.to_string_lossy()));
    fs::write(place.join("yade"), text).expect("writable");
    let (_, errors) = study(&place, 4, "run", &WITH_IT);
    has(&errors, ["4 rows are written down", "broken"]);
    has(&errors, ["rows 2, 5 the engine failed"]);
    let (said, _) = study(&place, 3, "status", &[]);
    has(&said, ["4 of 6", "missing: rows 2, 5"]);
    fs::write(mended, "").expect("writable");
    let said = must(&place, "run", &WITH_IT);
    has(&said, ["6 rows, 4 of them finished before"]);
    has(&said, ["merged 6 rows of YADE 2023.02a: 6 did not settle"]);
}

#[test]
fn a_missing_engine_is_no_row() {
    let place = &with_yade(3, "");
    fs::remove_file(place.join("yade")).expect("a file");
    let (_, errors) = study(place, 4, "run", &WITH_IT);
    has(&errors, ["YADE is missing"]);
    let (said, _) = study(place, 3, "status", &[]);
    has(&said, ["0 of 3 rows finished"]);
}

/// Where there is no terminal: lines now and then. Members that take their time without using a processor.
#[test]
fn lines_tell_members_an_hour_and_the_time_left() {
    let place = &with_yade(4, "time.sleep(6)");
    let options = ["--threads", "1", "--yade", "./yade"];
    let (_, errors) = study(place, 0, "run", &options);
    let line = errors.lines().find(|line| line.contains(" s left"));
    let line = line.unwrap_or_else(|| panic!("no line says the time left: {errors}"));
    assert!(line.starts_with("rows, shard 1/1: "), "{line}");
    has(line, [" of 4, "]);
    let before = line.split(" an hour").next().unwrap_or_default();
    let an_hour = before.rsplit(' ').next().and_then(|rate| rate.parse().ok());
    let an_hour: f64 = an_hour.expect("a rate");
    assert!((50.0..=600.0).contains(&an_hour), "{line}");
    has(&errors, ["4 of 4 written down, "]);
    let (_, _, errors) = campaign(place, "run", &["--quiet"]);
    assert_eq!(errors, "");
}
