//! Faults that are put in on purpose, against a baseline of a sound run: everything that a job writes must name them.

mod commits;

use std::sync::{Arc, Mutex};

use crate::support::*;

/// `reproduce` in this folder, `out` in it, with these further arguments: exit code and what it printed.
fn reproduce(folder: &Path, out: &str, arguments: &[&str]) -> (i32, String) {
    let all = [&["reproduce", "--quiet", "--out", out], arguments].concat();
    let (code, said, errors) = say(folder, &all);
    (code, said + &errors)
}

/// A sound run kept as `main`, and one with a fault held against it.
pub struct Seeded {
    /// Has `checks.xml` and `summary.md`.
    pub folder: Place,
    /// Of the second run, with what it printed and its page.
    pub code: i32,
    pub said: String,
    pub page: PathBuf,
}

impl Seeded {
    fn new(folder: Place, fault: &str, arguments: &[&str]) -> Self {
        let (code, said) = reproduce(&folder, "sound", arguments);
        assert!(code == 0, "{code}: {said}");
        ends(&folder, 0, "report baseline save sound/run.json main");
        let files = "--junit checks.xml --summary summary.md";
        let against = format!("--perturb {fault} --baseline main {files}");
        let against = against.words();
        let (code, said) = reproduce(&folder, "faulty", &[arguments, &against].concat());
        let page = folder.join("faulty/report.html");
        Seeded {
            folder,
            code,
            said,
            page,
        }
    }

    /// Without YADE: the paper's scene against the recorded run.
    pub fn stiffness() -> Arc<Self> {
        static MADE: Mutex<Option<Arc<Seeded>>> = Mutex::new(None);
        of_two(&MADE, || {
            Seeded::new(new_folder(), "stiffness=1e-3", &["--recorded"])
        })
    }

    /// With YADE.
    pub fn slow() -> Arc<Self> {
        static MADE: Mutex<Option<Arc<Seeded>>> = Mutex::new(None);
        let folder = || folder_with(&small_scene());
        of_two(&MADE, || {
            Seeded::new(folder(), "slow=4", &["--scene", "scene.json"])
        })
    }
}

/// Two tests look at what takes minutes to make, where there is a browser: the first makes it, and the second takes it away.
fn of_two<T>(made: &Mutex<Option<Arc<T>>>, make: impl FnOnce() -> T) -> Arc<T> {
    let mut made = made.lock().expect("the other test has made it");
    match made.take() {
        Some(known) => known,
        None if cfg!(feature = "live") => made.insert(Arc::new(make())).clone(),
        None => Arc::new(make()),
    }
}

/// The names of the test cases that failed, as `suite/case`, with what they say.
fn failures(folder: &Path) -> Vec<(String, String)> {
    let text = text_of(folder.join("checks.xml"));
    let report = roxmltree::Document::parse(&text).expect("XML");
    let named =
        |node: roxmltree::Node<'_, '_>| node.attribute("name").unwrap_or_default().to_owned();
    let failures = report.descendants();
    let failures = failures.filter(|node| node.has_tag_name("failure"));
    let told = |failure: roxmltree::Node<'_, '_>| {
        let case = failure.parent().expect("a test case");
        let message = failure.attribute("message").unwrap_or_default();
        (named(case), message.to_owned())
    };
    failures.map(told).collect()
}

#[test]
fn a_stiffness_that_is_a_thousandth_off_is_named_by_exit_code_junit_and_summary() {
    let made = Seeded::stiffness();
    let Seeded {
        folder,
        code,
        said,
        page,
    } = &*made;
    assert_eq!(*code, 1, "{said}");
    has(said, ["WORSE than main"]);
    let failed = failures(folder);
    let bits = "compare/sorted-recorded/bits-along-the-way";
    for id in [bits, "compare/made"] {
        assert!(
            failed.iter().any(|failure| failure.0 == id),
            "{id}: {failed:#?}"
        );
    }
    let new = failed.iter().find(|(id, _)| id == "baseline/new-failures");
    let named = new.is_some_and(|(_, words)| words.contains("bits-"));
    assert!(named, "{failed:#?}");
    let summary = text_of(folder.join("summary.md"));
    has(
        &summary,
        ["## The paper's experiment in two engines: Different"],
    );
    has(&summary, ["WORSE than main: ", "### FAIL ("]);
    has(&summary, [&format!("| NEW FAILURE | `{bits}`")]);
    let page = text_of(page);
    let failed = page.find("What failed").expect("a section");
    assert!(failed < page.find(">Comparisons</h2>").expect("a section"));
    has(&page, ["<strong>Different, and worse than main</strong>"]);
    has(&page, ["native against YADE&#39;s sorted loop, recorded"]);
}

/// Its results are the same to the last bit, so no check fails: only the clock tells.
#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn a_kernel_that_is_four_times_slower_is_named_by_exit_code_junit_and_summary() {
    let made = Seeded::slow();
    let Seeded {
        folder,
        code,
        said,
        page,
    } = &*made;
    assert_eq!(*code, 1, "{said}");
    let failed = failures(folder);
    assert!(!failed.is_empty(), "{said}");
    for (id, words) in failed {
        let speed = ["sorted", "ordinary"].map(|way| format!("baseline/speed/time/{way}"));
        assert!(speed.iter().any(|name| id.starts_with(name)), "{id}");
        has(&words, ["times the cost"]);
    }
    let summary = text_of(folder.join("summary.md"));
    let slower = "slower: time a step of YADE";
    has(&summary, ["WORSE than main: ", slower]);
    has(
        &text_of(page),
        ["Agreed, and worse than main</strong>", slower],
    );
}

#[test]
fn a_slow_kernel_has_the_same_bits_and_takes_as_long_as_it_was_told() {
    let ran = |options| native_run(&small_scene(), options, Protocol::Steps { steps: 6000 });
    let (sound, slow) = (ran(sound()), ran(faulty("slow=20")));
    assert_eq!(sound.last, slow.last);
    let [sound, slow] = [sound, slow].map(|run| run.record.seconds_per_step());
    assert!(slow > 5.0 * sound, "{slow} s against {sound} s a step");
    assert!("slow=0.5".parse::<grains::native::Fault>().is_err());
}
