//! What is asked of every page. Each question returns what it has to complain about.

use crate::support::browser::Browser;
use crate::support::*;

const LOOK: &str = include_str!("look.js");

/// A telephone, a tablet and a wide screen, CSS pixels.
pub const WINDOWS: [(u32, u32); 3] = [(360, 800), (800, 1100), (1600, 900)];
/// WCAG's least contrast of ordinary text.
const LEAST_CONTRAST: f64 = 4.5;
/// A4 without margins of 1 cm, CSS pixels.
const PAPER: (u32, u32) = (718, 1047);

/// What a function of `look.js` returns.
pub fn look(browser: &mut Browser, call: &str) -> Value {
    browser.evaluate(&format!("({LOOK}).{call}"))
}

fn complaints(browser: &mut Browser, call: &str) -> Vec<String> {
    let found = look(browser, call);
    let list = found.as_array().expect("a list");
    let words = list.iter().map(|entry| entry.as_str().expect("words"));
    words.map(str::to_owned).collect()
}

/// Opens a page on a wide light screen.
pub fn open(browser: &mut Browser, page: &Path) {
    browser.resize(1600, 900);
    browser.emulate("screen", "light");
    browser.open(page);
}

/// Errors and warnings that the page, or the browser about the page, has told since it was opened.
pub fn told(browser: &mut Browser) -> Vec<String> {
    browser.settle();
    let bad = |level: &Value| matches!(level.as_str(), Some("error" | "warning" | "assert"));
    let exceptions = browser.of("Runtime.exceptionThrown");
    let exceptions = exceptions.map(|event| format!("exception: {}", event["exceptionDetails"]));
    let console = browser
        .of("Runtime.consoleAPICalled")
        .filter(|event| bad(&event["type"]));
    let console = console.map(|event| format!("console: {}", event["args"]));
    let log = browser.of("Log.entryAdded").map(|event| &event["entry"]);
    let log = log
        .filter(|entry| bad(&entry["level"]))
        .map(|entry| format!("log: {}", entry["text"]));
    exceptions.chain(console).chain(log).collect()
}

/// Requests that leave the folder: all but `file:` and `data:`.
pub fn requests(browser: &mut Browser) -> Vec<String> {
    browser.settle();
    let urls = browser.of("Network.requestWillBeSent");
    let urls = urls.map(|event| &event["request"]["url"]);
    let sockets = browser
        .of("Network.webSocketCreated")
        .map(|event| &event["url"]);
    let urls = urls
        .chain(sockets)
        .map(|url| url.as_str().expect("an address"));
    let urls: Vec<&str> = urls.collect();
    let itself = urls.iter().any(|url| url.starts_with("file://"));
    assert!(itself, "the page itself was asked for: {urls:?}");
    let near = |url: &str| url.starts_with("file://") || url.starts_with("data:");
    let far = urls.into_iter().filter(|url| !near(url));
    far.map(str::to_owned).collect()
}

/// Links that lead nowhere: all must stay on the page or in its folder, but for the work that is reproduced.
pub fn links(browser: &mut Browser) -> Vec<String> {
    let links = look(browser, "links()");
    let words =
        |value: &Value| -> Vec<String> { serde_json::from_value(value.clone()).expect("words") };
    let here = browser.evaluate("decodeURIComponent(location.pathname)");
    let folder = Path::new(here.as_str().expect("a path")).with_file_name("");
    let lost = |to: &String| !to.starts_with("https://doi.org/10.") && !folder.join(to).is_file();
    let others = words(&links["others"]).into_iter().filter(lost);
    let inside = words(&links["lost"]).into_iter();
    let nowhere = inside.chain(others);
    nowhere.map(|to| format!("leads nowhere: {to}")).collect()
}

/// At each width, as it opens and with everything unfolded.
pub fn layout(browser: &mut Browser) -> Vec<String> {
    let mut all = Vec::new();
    for (width, height) in WINDOWS {
        browser.resize(width, height);
        for (unfolded, questions) in [
            (false, &["overflow()"][..]),
            (true, &["overflow()", "sizes()"]),
        ] {
            look(browser, &format!("open({unfolded})"));
            browser.settle();
            for question in questions {
                let found = complaints(browser, question);
                all.extend(
                    found
                        .into_iter()
                        .map(|complaint| format!("{width} px: {complaint}")),
                );
            }
        }
    }
    all
}

/// Light and dark, with everything unfolded.
pub fn contrast(browser: &mut Browser) -> Vec<String> {
    look(browser, "open(true)");
    let mut all = Vec::new();
    for scheme in ["light", "dark"] {
        browser.emulate("screen", scheme);
        let found = complaints(browser, &format!("contrast({LEAST_CONTRAST})"));
        all.extend(
            found
                .into_iter()
                .map(|complaint| format!("{scheme}: {complaint}")),
        );
    }
    browser.emulate("screen", "light");
    all
}

/// On paper everything is unfolded, fits, and is black on white whatever the screen is.
pub fn print(browser: &mut Browser) -> Vec<String> {
    look(browser, "open(false)");
    browser.resize(PAPER.0, PAPER.1);
    browser.emulate("print", "dark");
    let mut all = complaints(browser, "print()");
    let light = browser.evaluate(&format!(
        "{{ const of = {LOOK}; of.luminance(of.background(document.body)) }}"
    ));
    if light.as_f64().is_none_or(|light| light < 0.99) {
        all.push(format!("the paper is printed over: luminance {light}"));
    }
    browser.emulate("screen", "light");
    let pdf = browser.pdf();
    if !pdf.starts_with(b"%PDF-") || pdf.len() < 2000 {
        all.push(format!("no PDF: {} bytes", pdf.len()));
    }
    all
}

/// Roles that say nothing without a name.
const NAMED: &str = "button heading image link navigation searchbox textbox";

/// What a screen reader or a keyboard has no use of: things without a name in the browser's own tree of what is read aloud, and
/// faults of the page's structure. Of WCAG 2.2: 1.1.1, 1.3.1, 2.1.1, 2.4.1, 2.4.2, 3.1.1, 4.1.2.
pub fn accessible(browser: &mut Browser) -> Vec<String> {
    look(browser, "open(true)");
    let mut all = complaints(browser, "structure()");
    let tree = browser.call("Accessibility.getFullAXTree", json!({}));
    let nodes = tree["nodes"].as_array().expect("a tree");
    let read = nodes.iter().filter(|node| node["ignored"] != true);
    let mut seen = 0;
    for node in read {
        let role = node["role"]["value"].as_str().unwrap_or_default();
        if !NAMED.words().contains(&role) {
            continue;
        }
        seen += 1;
        let name = node["name"]["value"].as_str().unwrap_or_default();
        if name.trim().is_empty() {
            all.push(format!("a {role} without a name"));
        }
    }
    if seen < 3 {
        all.push(format!("only {seen} things with a name were looked at"));
    }
    all
}

/// A click on a heading sorts by it, the key Enter the other way round; typing leaves the rows that have the words.
pub fn tables(browser: &mut Browser) -> Vec<String> {
    browser.resize(1600, 900);
    look(browser, "open(true)");
    let table = look(browser, "tableToUse()");
    let Some(column) = table["column"].as_u64() else {
        return vec!["no table can be sorted by numbers".to_owned()];
    };
    let mut all = Vec::new();
    let original = rows(browser);
    let key = |row: &Vec<String>| row[column as usize].parse::<f64>().expect("a number");
    for down in [false, true] {
        if down {
            browser.press_enter("th[data-tested] button");
        } else {
            browser.click("th[data-tested]");
        }
        let now = rows(browser);
        let pairs = now.windows(2).map(|two| (key(&two[0]), key(&two[1])));
        let ordered = pairs
            .clone()
            .all(|(a, b)| if down { a >= b } else { a <= b });
        let (mut before, mut after) = (original.clone(), now.clone());
        before.sort();
        after.sort();
        if !ordered || before != after {
            let values: Vec<f64> = now.iter().map(key).collect();
            all.push(format!(
                "click {}: column {column} is {values:?}",
                if down { "two, of a key," } else { "one" }
            ));
        }
    }
    if table["filter"] != true {
        return all;
    }
    // A word of one row, in letters that are not its own.
    let word = original[original.len() / 2][0..]
        .iter()
        .flat_map(|cell| cell.split_whitespace())
        .max_by_key(|word| word.len());
    let word = word.expect("a row with words").to_uppercase();
    let has = |row: &Vec<String>| row.concat().to_lowercase().contains(&word.to_lowercase());
    let wanted = original.iter().filter(|row| has(row)).count();
    browser.click("input[data-tested]");
    browser.type_text(&word);
    let shown = rows(browser);
    if shown.len() != wanted || !shown.iter().all(has) {
        all.push(format!(
            "typing {word}: {} rows are shown, {wanted} of {} have it",
            shown.len(),
            original.len()
        ));
    }
    all
}

fn rows(browser: &mut Browser) -> Vec<Vec<String>> {
    let rows = look(browser, "rowsShown()");
    serde_json::from_value(rows).expect("rows of words")
}
