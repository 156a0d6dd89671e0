//! Benchmarks: their beds, what makes an engine's bed insane, and the reading of other programs' words. No test
//! here asserts a time.

mod external;

use crossgrain::checks::Outcome;
use crossgrain::child::on_path;
use crossgrain::engine::{Engine, ProgramError, read::TimedSteps, yade};
use crossgrain::limits::bench::bed::{self, Bed};
use crossgrain::limits::bench::contender::{
    self, Contender, StateCheck, Tolerance, between_grains,
};
use crossgrain::limits::bench::machine::Machine;
use crossgrain::limits::bench::scaling::Point;
use crossgrain::limits::bench::{BedRecord, Bench, Missed, Plan, Setup, timing};
use crossgrain::report::page;
use crossgrain::study::realization::Engines;
use crossgrain::tables::write_bodies;

use crate::support::*;

/// 500 settled grains: a tenth of the paper's bed, as deep.
fn small_bed() -> Bed {
    bed::settled(500, &mut ()).expect("a bed that settles")
}

const STEPS: TimedSteps = TimedSteps {
    warm_up: 10,
    timed: 40,
    shares: 0,
    processes: 1,
};

/// Grains without their ids.
fn as_a_set(bodies: &Bodies) -> Vec<[u64; 6]> {
    let motion = [&bodies.x, &bodies.z, &bodies.vx, &bodies.vz];
    let bits = |id: usize| {
        let [x, z, vx, vz] = motion.map(|column| column[id].to_bits());
        [
            x,
            z,
            vx,
            vz,
            bodies.radius[id].to_bits(),
            bodies.mass[id].to_bits(),
        ]
    };
    let mut all: Vec<[u64; 6]> = (0..bodies.len()).map(bits).collect();
    all.sort_unstable();
    all
}

#[test]
fn copies_are_mirrored_and_numbered_row_by_row() {
    let mut bodies = Bodies::default();
    // Two columns, two rows.
    for (x, z) in [(0.1, 0.1), (0.7, 0.1), (0.2, 0.3), (0.8, 0.3)] {
        bodies.push([x, z], [1.0, 2.0], 0.1, 3.0);
    }
    let wide = bed::side_by_side(&bodies, 1.0, 2, 3);
    assert_eq!(wide.len(), 12);
    let lowest = wide.x[..6].iter().map(|x| (x * 10.0).round() / 10.0);
    let lowest: Vec<f64> = lowest.collect();
    assert_eq!(lowest, [0.1, 0.7, 1.3, 1.9, 2.1, 2.7]);
    assert!(wide.z[..6].iter().all(|z| *z == 0.1));
    assert_eq!(wide.vx[..6], [1.0, 1.0, -1.0, -1.0, 1.0, 1.0]);
    assert!(wide.vz.iter().all(|vz| *vz == 2.0));
}

#[test]
fn a_bed_laid_out_of_copies_is_as_dense_as_the_settled_one() {
    let small = small_bed();
    let wide = bed::laid_out(&small, 4).expect("a sound bed");
    assert_eq!(wide.bodies.len(), 2000);
    let contacts = |bed: &Bed| {
        let now = timing::after(bed, 0).expect("a sound bed");
        between_grains(&now) as f64 / bed.bodies.len() as f64
    };
    let height = |bed: &Bed| bed.bodies.z.iter().sum::<f64>() / bed.bodies.len() as f64;
    assert!((contacts(&wide) / contacts(&small) - 1.0).abs() < 0.1);
    assert!((height(&wide) / height(&small) - 1.0).abs() < 0.02);
}

#[test]
fn shuffled_grains_are_the_same_grains() {
    let bed = small_bed();
    let shuffled = bed::shuffled(&bed.bodies);
    assert_eq!(as_a_set(&shuffled), as_a_set(&bed.bodies));
    assert_ne!(shuffled.x, bed.bodies.x);
    let near = |bodies: &Bodies| {
        let steps = bodies.z.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        steps.sum::<f64>()
    };
    assert!(near(&shuffled) > 5.0 * near(&bed.bodies));
}

#[test]
fn a_kept_bed_is_taken_over_and_a_spoilt_one_is_not() {
    let folder = &new_folder();
    let make = || bed::settled_or_kept(folder, 60, &mut ()).expect("a bed");
    let first = make();
    assert_eq!(make().bodies, first.bodies);
    let table = folder.join("bed-60.csv");
    let text = text_of(&table);
    let line = text.lines().nth(1).expect("a grain").to_owned();
    let words: Vec<&str> = line.split(',').collect();
    let moved = line.replacen(words[1], "0.0123", 1);
    fs::write(&table, text.replacen(&line, &moved, 1)).expect("a spoilt table");
    assert_eq!(make().bodies, first.bodies, "settled anew");
}

#[test]
fn a_lost_grain_contact_or_number_is_not_sane() {
    let bed = small_bed();
    let exact = timing::after(&bed, 10).expect("a sound run");
    let contacts = between_grains(&exact);
    let judge = |bodies: &Bodies, contacts: usize| {
        StateCheck::of(bodies, contacts, &exact, 0.005, Tolerance::OTHER_LAW).holds
    };
    assert!(judge(&exact.bodies, contacts));
    assert!(!judge(&exact.bodies, contacts / 2));
    let changes: [fn(&mut Bodies); 4] = [
        |bodies| bodies.x[7] += 0.002,
        |bodies| bodies.z[7] = f64::NAN,
        |bodies| bodies.vx.fill(1.0),
        |bodies| bodies.x.truncate(499),
    ];
    for change in changes {
        let mut bodies = exact.bodies.clone();
        change(&mut bodies);
        assert!(!judge(&bodies, contacts), "{bodies:?}");
    }
    // What rounding does not explain.
    let mut moved = exact.bodies.clone();
    moved.x[7] += 1.0e-7;
    assert!(!StateCheck::of(&moved, contacts, &exact, 0.005, Tolerance::ROUNDING).holds);
}

#[test]
fn clocks_between_the_stages_change_no_bit() {
    let bed = small_bed();
    let clocked = timing::clocked(&bed, 400).expect("the bits of the engine");
    let total: f64 = clocked.shares.iter().map(|share| share.share).sum();
    assert!((total - 1.0).abs() < 1.0e-9);
    assert!(clocked.listed_pairs > clocked.touching_pairs);
    assert!(clocked.touching_pairs > 500);
}

#[test]
fn a_process_of_its_own_times_the_bed_it_is_given() {
    let folder = &new_folder();
    timing::write_bed(&small_bed(), folder).expect("a written bed");
    let program = Path::new(env!("CARGO_BIN_EXE_crossgrain"));
    let limit = Duration::from_secs(60);
    let one = timing::in_a_process(program, folder, 400, 1, limit).expect("a time");
    assert_eq!(one.window.steps, 400);
    let seconds = [Some(one.window.wall_seconds), one.window.cpu_seconds];
    assert!(
        seconds.iter().all(|second| *second > Some(0.0)),
        "{seconds:?}"
    );
    ends(folder, 2, "bench --one nowhere");
}

#[test]
fn a_folder_that_cannot_be_renamed_is_not_overwritten() {
    let folder = &new_folder();
    fs::write(folder.join("bench.json"), "{}").expect("a file");
    for out in [".", "bench.json"] {
        tells(folder, 2, &format!("bench --out {out}"), ["exists already"]);
    }
    ends(folder, 2, "bench --rounds 0");
}

const LOG: &str = "LAMMPS (29 Sep 2021 - Update 2)\nStep KinEng c_contacts \n       0  0.0395        17462 \n     \
    100   0.0429        17166 \nLoop time of 0.029 on 1 procs for 100 steps with 5000 atoms\n\n99.9% CPU use with 1 MPI tasks x 1 OpenMP \
    threads\n\nNeighs:        12581.0 ave       12581 max       12581 min\nStep KinEng c_contacts \n     100   0.0429        17166 \n     \
    600  0.059        16728 \nLoop time of 0.2 on 1 procs for 500 steps with 5000 atoms, finish time Sat Nov 21\n\n\
    50.0% CPU use with 1 MPI tasks x 1 OpenMP threads\nHistogram: 1 0 0 0 0 0 0 0 0 0\n";

/// What Python makes of this, with the adapters to import; or how it failed.
fn in_python(script: &str, arguments: &[&Path]) -> Result<String, String> {
    let (code, out, errors) = python("python3", &root("adapters"), script, arguments);
    if code == 0 { Ok(out) } else { Err(errors) }
}

#[test]
fn the_last_loop_of_so_many_steps_of_a_log_counts() {
    let folder = &new_folder();
    let log = folder.join("log");
    let times = |text: &str| {
        fs::write(&log, text).expect("a log");
        let script =
            "import granular, sys; print(granular.loop_time(open(sys.argv[1]).read(), 500))";
        in_python(script, &[&log])
    };
    assert_eq!(times(LOG).expect("a time"), "(0.2, 0.5)\n");
    let later =
        format!("{LOG}Loop time of 9.9 on 1 procs for 0 steps with 5000 atoms\n\n1.0% CPU use\n");
    assert_eq!(times(&later).expect("a time"), "(0.2, 0.5)\n");
    for unknown in ["", "0.0% CPU use"] {
        let log = LOG.replace("50.0% CPU use", unknown);
        assert_eq!(times(&log).expect("a time"), "(0.2, None)\n");
    }
    let lost = times("ERROR: lost atoms").expect_err("no time");
    has(&lost, ["no loop time of 500 steps"]);
}

#[test]
fn scripts_of_other_engines_carry_the_scenes_numbers() {
    let bed = small_bed();
    let work = &new_folder();
    let ask = |bed: &Bed| {
        let model = grains::model::Model::of(&bed.scene);
        let job = json!({"protocol": 1, "kind": "timing", "model": model, "warm_up": 7, "steps": 11, "shares": 0});
        fs::write(work.join("job.json"), job.to_string()).expect("a job");
    };
    ask(&bed);
    write_bodies(&work.join("initial.csv"), &bed.bodies).expect("grains");
    let script = "import exchange, granular, importlib, sys
job = exchange.Job(sys.argv[1])
of = importlib.import_module(sys.argv[2]).timing(job, granular.OneClass(job.grains), job.folder, 5e7)
print('\\n'.join(of[0]))";
    let script = |name: &str| in_python(script, &[work, Path::new(name)]);
    let [lammps, liggghts] = ["lammps", "liggghts"].map(|name| script(name).expect("a script"));
    assert!(lammps.contains("pair_style gran/hooke 50000000 NULL 0 NULL 0 0\n"));
    assert!(lammps.contains("fix wall_1 all wall/gran hooke 50000000 NULL 0 NULL 0 0 xplane"));
    assert!(liggghts.contains("kn peratomtypepair 1 50000000\n"));
    assert!(liggghts.contains("primitive type 1 yplane 0\n"));
    // tan 0.5, and discs that turn.
    ask(&bed.with_friction());
    let lammps = script("lammps").expect("a script");
    let law = "hooke/history 50000000 50000000 0 0 0.54630248984379048 0";
    has(&lammps, [&format!("pair_style gran/{law}\n")]);
    has(&lammps, [&format!("wall/gran {law} xplane")]);
    assert!(lammps.contains("fix move all nve/sphere disc\n"));
    assert!(
        script("liggghts")
            .expect_err("is refused")
            .contains("friction")
    );
}

/// LAMMPS and LIGGGHTS time their own steps, and the bed stays the bed.
#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS and LIGGGHTS")]
fn programs_time_their_own_steps_through_their_adapters() {
    let bed = small_bed();
    let (rough, options) = (bed.with_friction(), yade::Options::default());
    use Contender::{Lammps, LammpsFriction, Liggghts};
    for (contender, processes) in [(Lammps, 1), (Lammps, 2), (Liggghts, 1), (LammpsFriction, 1)] {
        let steps = TimedSteps { processes, ..STEPS };
        let bed = if contender.friction() { &rough } else { &bed };
        let exact = timing::after(bed, 50).expect("a sound run");
        let work = &new_folder();
        let (timed, version) =
            contender::timed(contender, bed, steps, &options, work).expect("a timed run");
        assert_eq!((timed.window.steps, timed.last.step), (40, 50));
        assert!(!version.is_empty() && timed.window.wall_seconds > 0.0);
        let contacts = between_grains(&timed.last);
        let tolerance = Tolerance::OTHER_LAW;
        let state_check = StateCheck::of(&timed.last.bodies, contacts, &exact, 0.005, tolerance);
        let sane = state_check.holds && state_check.displacement > 0.0;
        assert!(sane, "{state_check:?}");
        // Grains turn the same way.
        let spins = timed.last.bodies.spin.iter().zip(&exact.bodies.spin);
        let products: Vec<f64> = spins.map(|(spin, exact)| spin * exact).collect();
        let all: f64 = products.iter().map(|product| product.abs()).sum();
        assert!(products.iter().sum::<f64>() >= 0.5 * all, "{contender:?}");
        assert_eq!(all > 0.0, contender.friction());
    }
}

#[test]
fn programs_that_fail_or_hang_are_named_and_ended() {
    let folder = &new_folder();
    let sh = on_path("sh").expect("a shell");
    let run = |script: &str, limit: u64| {
        let limit = Duration::from_millis(limit);
        timing::run(Command::new(&sh).args(["-c", script]), folder, limit)
    };
    assert_eq!(run("echo hello", 10_000).expect("a log"), "hello\n");
    let failed = run("echo no such bed >&2; exit 3", 10_000).expect_err("a failure");
    assert!(failed.to_string().contains("no such bed"), "{failed}");
    let began = Instant::now();
    let hung = run("sleep 30", 200).expect_err("too long");
    assert!(hung.to_string().contains("was ended"), "{hung}");
    assert!(began.elapsed() < Duration::from_secs(20));
    assert!(on_path("no-such-program-here").is_none());
}

#[test]
fn what_is_not_installed_is_not_a_failure_and_what_crashes_is() {
    let missed = |error| Missed::of("x", "x", false, error).expect("no interruption");
    let missing = ProgramError::Missing {
        engine: "LAMMPS",
        reason: "nowhere".to_owned(),
        package: "lammps",
    };
    assert!(!missed(missing.into()).failed);
    let status = "signal 11".to_owned();
    let log = String::new();
    assert!(missed(ProgramError::Crashed { status, log }.into()).failed);
    assert!(Missed::of("x", "x", false, ProgramError::Interrupted.into()).is_err());
    assert!(Contender::YadeOrdinary.needed() && !Contender::Lammps.needed());
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn the_timed_steps_of_yade_have_the_native_bits() {
    let (bed, work) = (small_bed(), &new_folder());
    let steps = TimedSteps {
        shares: 10,
        ..STEPS
    };
    let model = grains::model::Model::of(&bed.scene);
    let options = yade::Options::default();
    let (timed, _) = options
        .time(&model, &bed.bodies, steps, work)
        .expect("a timed run");
    let exact = timing::after(&bed, 50).expect("a sound run");
    assert_eq!(timed.last.bodies, exact.bodies);
    assert_eq!(timed.last.contacts.len(), exact.contacts.len());
    assert_eq!((timed.window.steps, timed.shares.len()), (40, 4));
    assert!(timed.peak_memory.expect("YADE tells") > 1 << 20);
}

/// A round of the native engine alone, as a page: other engines are missing with their reasons, and no number is lost.
#[test]
fn a_benchmark_without_other_engines_is_incomplete_and_draws_what_there_is() {
    let bed = bed::settled(60, &mut ()).expect("a bed that settles");
    let with_friction = bed.with_friction();
    let in_space = bed::poured_or_kept(&new_folder(), 60).expect("a bed of spheres");
    let work = new_folder();
    let yade = yade::Options {
        program: Some("/nowhere/yade".into()),
        ..yade::Options::default()
    };
    let engines = Engines {
        yade,
        external: None,
    };
    let setup = Setup {
        plan: Plan {
            rounds: 2,
            warm_up: 10,
            native: 200,
            other: 20,
            ..Plan::QUICK
        },
        bed: &bed,
        with_friction: &with_friction,
        in_space: &in_space,
        engines: &engines,
        crossgrain: Path::new(env!("CARGO_BIN_EXE_crossgrain")),
        work: &work,
    };
    let task = Display::new(true).task("a round");
    let mut missed = Vec::new();
    let rounds = contender::rounds(&setup, &task, &mut missed);
    let (mut contests, [sorted_bits, friction_bits, space_bits]) = rounds.expect("a round");
    // Whatever else this machine has.
    contests.retain(|contest| contest.contender.is_native());
    missed.retain(|missed| missed.what.starts_with("YADE"));
    let clocked = timing::clocked(&bed, 100).expect("the bits of the engine");
    let size = |name: &str, grains: u32| {
        let seconds_per_step = contests[0].seconds_per_step.clone();
        Point {
            name: name.to_owned(),
            grains,
            seconds_per_grain: seconds_per_step.median / f64::from(grains),
            seconds_per_step,
            peak_memory: Some(4_000_000),
        }
    };
    let bench = Bench {
        crossgrain: "0.1.0".to_owned(),
        command: "crossgrain bench".to_owned(),
        quick: true,
        rounds: 2,
        machine: Machine::this(),
        bed: BedRecord {
            grains: 60,
            scene_digest: bed.scene.digest(),
            state: bed.bodies.digest(),
            listed_pairs: clocked.listed_pairs,
            touching_pairs: clocked.touching_pairs,
            steps_per_build: 100.0,
        },
        sorted_bits,
        friction_bits,
        space_bits,
        friction_cost: None,
        stages: clocked.shares,
        scaling: vec![size("native", 60), size("native", 120)],
        speed_ups: Vec::new(),
        disturbed: false,
        missed,
        seconds: 1.0,
        contests,
    };
    let document = bench.document();
    assert_eq!(document.verdict, Outcome::Skipped);
    let checks = document.checks.iter();
    let beds = checks.filter(|check| check.id.starts_with("bench/bed/"));
    // With YADE and LAMMPS in space.
    assert_eq!(beds.count(), 9);
    let yade = "bench/missed/ordinary-loop";
    let check = document.checks.iter().find(|check| check.id == yade);
    assert!(check.is_some_and(|check| check.required && check.outcome == Outcome::Skipped));
    let page = page(&document);
    each_figure_stands_once_and_has_numbers(&page);
    assert_eq!(page.html.matches("<figure").count(), 2);
    if let Some(folder) = std::env::var_os("CROSSGRAIN_DRAWINGS") {
        page.write(Path::new(&folder)).expect("a writable folder");
    }
}
