//! A fourth engine, in a few lines: what the library does with an engine it does with any.

use crossgrain::checks::Outcome;
use crossgrain::compare::compare;
use crossgrain::compare::first_steps::{Beds, answer, from_bed};
use crossgrain::engine::{Description, Engine, EngineError, EngineRecord, ProgramError, Run};
use crossgrain::suite::conformance::conformance;
use crossgrain::suite::run::verify_in;
use grains::task::{Case, Observer};
use verdict::Answer;
use verdict::judge::{Reference, Verdict};

use crate::support::*;

/// The native engine under another name, as it is or with a fault that it does not tell of.
#[derive(Debug)]
struct Fourth {
    options: native::Options,
    /// It writes nonsense where there is such a law.
    breaks_at: fn(&Case) -> bool,
}

/// That writes none.
fn fourth(options: native::Options) -> Fourth {
    Fourth {
        options,
        breaks_at: |_| false,
    }
}

impl Engine for Fourth {
    fn name(&self) -> String {
        "fourth".to_owned()
    }

    fn describe(&self) -> Result<Description, EngineError> {
        let name = self.name();
        Ok(Description {
            name,
            ..self.options.describe()?
        })
    }

    fn run(
        &self,
        scene: &Scene,
        task: &Task,
        work: &Path,
        observer: &mut dyn Observer,
    ) -> Result<Run, EngineError> {
        let engine = EngineRecord::Exec {
            described: self.describe()?,
            digest: String::new(),
        };
        let run = self.options.run(scene, task, work, observer)?;
        Ok(Run { engine, ..run })
    }

    fn run_cases(&self, cases: &[&Case], work: &Path) -> Result<Vec<Answer>, EngineError> {
        match cases.iter().find(|case| (self.breaks_at)(case)) {
            Some(case) => Err(ProgramError::Nonsense(format!("case {}: a NaN", case.name)).into()),
            None => self.options.run_cases(cases, work),
        }
    }
}

const FAULT: &str = "stiffness=1e-3";

#[test]
fn its_runs_are_recorded_and_compared() {
    let protocol = Protocol::Steps { steps: 2000 };
    let run = |options| run_of(&small_scene(), &fourth(options), protocol);
    let [right, wrong] = [sound(), faulty(FAULT)].map(run);
    let label = right.record.engine.label();
    assert!(
        label.starts_with("fourth ") && label.ends_with("(exec)"),
        "{label}"
    );
    // Another engine's run is gone on with by the native one, and cannot be taken up as native's is.
    assert!(right.record.restart.is_none());
    let [whole] = &right.record.continued[..] else {
        panic!("{:?}", right.record.continued);
    };
    assert_eq!((whole.from, whole.to), (0, 2000));
    assert_eq!(whole.found, "every bit is native's");
    let native = run_of(&small_scene(), &sound(), protocol);
    assert_eq!(right.history, native.history);
    assert_eq!(compare(&right, &native, None).verdict(), Verdict::Identical);
    assert_ne!(compare(&wrong, &native, None).verdict(), Verdict::Identical);
}

#[test]
fn it_is_judged_checked_and_verified() {
    let reference = Reference::new(200, 0.1, &mut |_| ()).expect("a bed");
    let beds = Beds::from(reference.clone());
    let judged = |options, verdict, outcome| {
        let engine = fourth(options);
        let first = from_bed(&reference, &engine, &mut |_| ()).expect("a judgement");
        assert_eq!(first.verdict(), verdict);
        let checked = conformance(&engine, &beds, &mut |_| ()).expect("an engine");
        assert_eq!(checked.verdict(), verdict);
        assert!(
            checked
                .checks
                .iter()
                .any(|check| check.id == "engine/again")
        );
        let display = Display::new(true);
        let verified = verify_in(&engine, &beds, "a test", &display).expect("an engine");
        assert_eq!(verified.verdict(), outcome, "{}", verified.tally);
    };
    judged(sound(), Verdict::Identical, Outcome::Pass);
    judged(faulty(FAULT), Verdict::Different, Outcome::Fail);
}

/// It is different there, and judged by all other states.
#[test]
fn nonsense_in_some_states_is_told_with_what_they_have() {
    let reference = Reference::new(200, 0.1, &mut |_| ()).expect("a bed");
    let judged = |breaks_at| {
        let options = sound();
        let engine = Fourth { options, breaks_at };
        from_bed(&reference, &engine, &mut |_| ())
    };
    let found = judged(|case| case.model.law.has_dashpots()).expect("a judgement");
    assert_eq!(found.verdict(), Verdict::Different);
    let states = found.starts.iter();
    let (none, some): (Vec<_>, Vec<_>) = states.partition(|start| start.skipped.is_none());
    assert!(none.iter().all(|start| start.verdict == Verdict::Identical));
    assert!(some.iter().all(|start| start.verdict == Verdict::Different) && !some.is_empty());
    let condition = found.condition.as_deref().unwrap_or_default();
    assert!(condition.contains("there are dashpots"), "{condition}");
    has(
        &answer(&found),
        ["it wrote nonsense: case", "a NaN", condition],
    );
    // Of a bed that an engine may refuse, and of a start that is changed a little, nonsense is seen too.
    for breaks_at in [
        (|case| case.bodies.len() > 1000) as fn(&Case) -> bool,
        |case| case.moments == [1],
    ] {
        let found = judged(breaks_at).expect("a judgement");
        assert_eq!(found.verdict(), Verdict::Different);
        has(&answer(&found), ["it wrote nonsense"]);
    }
    // Where there is nothing else, it is no engine.
    assert!(judged(|_| true).is_err());
}

/// It has no clock, and says so instead of a number.
#[test]
fn what_it_does_not_do_is_an_error() {
    let (engine, scene) = (fourth(sound()), small_scene());
    let model = grains::model::Model::of(&scene);
    let steps = crossgrain::engine::read::TimedSteps {
        warm_up: 1,
        timed: 1,
        shares: 0,
        processes: 1,
    };
    let timed = engine.time(&model, &initial_bodies(&scene), steps, Path::new(""));
    let error = timed.expect_err("no clock").to_string();
    assert!(
        error.starts_with("fourth has no clock of its own steps"),
        "{error}"
    );
}
