//! The pages in a browser, as a reader has them. Without the feature `live` this is listed as ignored and not made; with it
//! a missing Chromium is a failure. `ci/install_browser` installs Debian's.

mod broken;
mod look;

use crate::regression::Seeded;
use crate::support::browser::Browser;
use crate::support::*;

/// Where pictures of the pages are kept: the folder that `CROSSGRAIN_SCREENSHOTS` names, else one in Cargo's.
fn screenshots() -> PathBuf {
    let named = std::env::var_os("CROSSGRAIN_SCREENSHOTS").map(PathBuf::from);
    let folder =
        named.unwrap_or_else(|| Path::new(env!("CARGO_TARGET_TMPDIR")).join("screenshots"));
    fs::create_dir_all(&folder).expect("a writable folder");
    folder
}

/// The first screen and the whole page at each width, light and dark.
fn keep_pictures(browser: &mut Browser, name: &str) {
    look::look(browser, "open(false)");
    for (width, height) in look::WINDOWS {
        browser.resize(width, height);
        for scheme in ["light", "dark"] {
            browser.emulate("screen", scheme);
            let path =
                |part: &str| screenshots().join(format!("{name}-{width}-{scheme}{part}.png"));
            browser.screenshot(&path(""), false);
            browser.screenshot(&path("-whole"), true);
        }
    }
    browser.emulate("screen", "light");
}

/// How long the main job's first page may be at 1280 CSS pixels across.
const MOST_PIXELS: f64 = 5000.0;

/// What is asked of every page.
const QUESTIONS: [fn(&mut Browser) -> Vec<String>; 4] =
    [look::links, look::layout, look::contrast, look::accessible];

/// Everything that is asked of a page with a table of numbers.
fn inspect(browser: &mut Browser, name: &str, page: &Path) {
    look::open(browser, page);
    let said = look::tables(browser);
    assert!(said.is_empty(), "{name}: {said:#?}");
    inspect_words(browser, name, page);
}

/// What the questions complain of.
fn asked(browser: &mut Browser, page: &Path) -> Vec<String> {
    look::open(browser, page);
    let questions = QUESTIONS.iter();
    questions.flat_map(|question| question(browser)).collect()
}

/// Everything that is asked of a page whose tables may have no numbers.
fn inspect_words(browser: &mut Browser, name: &str, page: &Path) {
    let mut all = asked(browser, page);
    look::open(browser, page);
    keep_pictures(browser, name);
    all.extend(look::print(browser));
    // Last, as what was done to the page may have made it talk.
    all.extend(look::told(browser));
    all.extend(look::requests(browser));
    let some = &all[..all.len().min(20)];
    let count = all.len();
    assert!(count == 0, "{name}: {count} complaints: {some:#?}");
    let count = |selector: &str| format!("document.querySelectorAll('{selector}').length > 0");
    for selector in ["table", "svg", ".filter input"] {
        assert_eq!(
            browser.evaluate(&count(selector)),
            true,
            "{name} has a {selector}"
        );
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Chromium: --features live")]
fn the_main_jobs_page_reads_well_everywhere_and_asks_for_nothing() {
    let folder = &folder_with(&small_scene());
    let command = "reproduce --scene scene.json --quiet --out o --recorded";
    ends(folder, 3, command);
    let mut browser = Browser::start();
    inspect_words(&mut browser, "reproduce", &folder.join("o/report.html"));
    look::open(&mut browser, &folder.join("o/report.html"));
    browser.resize(1280, 900);
    let height = browser.evaluate("document.documentElement.scrollHeight");
    let height = height.as_f64().expect("a height");
    assert!(height <= MOST_PIXELS, "{height} px");
    for other in ["measures", "paper"] {
        let said = asked(&mut browser, &folder.join(format!("o/{other}.html")));
        assert!(said.is_empty(), "{other}: {said:#?}");
    }
    // The last of them has numbers.
    let said = look::tables(&mut browser);
    assert!(said.is_empty(), "{said:#?}");
}

/// Whatever is put into a page: nothing runs but its own script, and nothing is asked for.
#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Chromium: --features live")]
fn a_script_that_was_put_into_a_page_does_not_run() {
    let folder = &new_folder();
    ends(folder, 0, "verify --engine native --quiet --out o");
    let page = folder.join("o/report.html");
    let text = text_of(&page);
    let put = "<script>document.title = 'taken'</script><p onclick=\"document.title = 'taken'\">a</p>\
               <img src=\"https://example.org/a.png\" onerror=\"document.title = 'taken'\">";
    fs::write(&page, text.replacen("</main>", &format!("{put}</main>"), 1)).expect("writable");
    let mut browser = Browser::start();
    look::open(&mut browser, &page);
    browser.evaluate("document.querySelector('main > p[onclick]').click()");
    browser.settle();
    let title = browser.evaluate("document.title");
    assert!(title != "taken", "it ran");
    // Its own script does: tables can be filtered.
    let filters = "document.querySelectorAll('.filter input').length > 0";
    assert_eq!(browser.evaluate(filters), true);
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Chromium: --features live")]
fn the_ladders_page_reads_well_everywhere_and_asks_for_nothing() {
    let folder = &new_folder();
    ends(folder, 0, "verify --engine native --quiet --out o");
    let page = folder.join("o/report.html");
    inspect(&mut Browser::start(), "verify", &page);
}

/// Of a page that was opened: the verdict and what is named first stand where they are seen without scrolling.
fn first_screen(browser: &mut Browser, page: &Path, name: &str, named: &[(&str, &str)]) {
    look::open(browser, page);
    keep_pictures(browser, name);
    for (width, height) in look::WINDOWS {
        browser.resize(width, height);
        for (selector, words) in named {
            let top = look::look(browser, &format!("top({selector:?}, {words:?})"));
            let seen = top
                .as_f64()
                .is_some_and(|top| (0.0..f64::from(height)).contains(&top));
            assert!(seen, "{width} × {height}: {words} is at {top}");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Chromium: --features live")]
fn a_seeded_fault_and_its_verdict_are_on_the_first_screen() {
    let made = Seeded::stiffness();
    let Seeded {
        code, said, page, ..
    } = &*made;
    assert_eq!(*code, 1, "{said}");
    let named = [
        (".verdict strong", "Different, and worse than main"),
        (".verdict .named", "new failures"),
        ("td", "compare/sorted-recorded/same-stages"),
    ];
    let mut browser = Browser::start();
    first_screen(&mut browser, page, "seeded", &named);
    inspect(&mut browser, "seeded", page);
    // What stands at the end of the page is not on the first screen: the question can be answered with no.
    let top = look::look(&mut browser, "top('h2', 'Runs, versions')");
    assert!(top.as_f64().is_some_and(|top| top > 900.0));
}

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Chromium and YADE")]
fn a_slower_kernel_and_its_verdict_are_on_the_first_screen() {
    let made = Seeded::slow();
    let Seeded {
        code, said, page, ..
    } = &*made;
    assert_eq!(*code, 1, "{said}");
    let named = [
        (".verdict strong", "Agreed, and worse than main"),
        (".verdict .named", "slower: time a step of YADE"),
    ];
    first_screen(&mut Browser::start(), page, "slower", &named);
}
