//! Pages that are broken on purpose: a question that has nothing to say of them is no question.

use super::look;
use crate::support::browser::Browser;
use crate::support::*;

/// A sound page with a table that can be sorted and filtered, and `head` and `body` put in.
fn page(folder: &Path, head: &str, body: &str) -> PathBuf {
    let rows: String = (0..15)
        .map(|row| {
            format!(
                "<tr><td>row-{row}</td><td class=\"n\">{}</td></tr>",
                row * 7 % 15
            )
        })
        .collect();
    let text = format!(
        "<!doctype html><html lang=\"en\"><head><title>A page</title><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><style>{}</style>{head}</head>\
         <body><main><h1>A page</h1><p>Words that can be read.</p><svg role=\"img\" aria-label=\"a disc\" viewBox=\"0 0 10 10\"><circle r=\"5\"/></svg><details><summary>more</summary>\
         <div class=\"scroll\"><table><tr><th scope=\"col\">name</th><th scope=\"col\" class=\"n\">value</th></tr>{rows}</table></div></details>{body}</main><script>{}</script></body></html>",
        include_str!("../../src/report/style.css"),
        include_str!("../../src/report/tables.js"),
    );
    let path = folder.join("page.html");
    fs::write(&path, text).expect("a writable folder");
    path
}

type Question = fn(&mut Browser) -> Vec<String>;

const QUESTIONS: [(&str, Question); 8] = [
    ("told", look::told),
    ("requests", look::requests),
    ("links", look::links),
    ("layout", look::layout),
    ("contrast", look::contrast),
    ("print", look::print),
    ("tables", look::tables),
    ("accessible", look::accessible),
];

/// The names of the questions that complain of a page, and all that they say.
fn complaining(browser: &mut Browser, head: &str, body: &str) -> (Vec<&'static str>, Vec<String>) {
    let folder = &new_folder();
    let page = page(folder, head, body);
    let (mut names, mut all) = (Vec::new(), Vec::new());
    for (name, question) in QUESTIONS {
        look::open(browser, &page);
        let found = question(browser);
        if !found.is_empty() {
            names.push(name);
        }
        all.extend(found);
    }
    (names, all)
}

/// Where it is put, the end of the head or of the body; what; which questions must complain, and a part of what they say.
const BROKEN: &str = r##"
    body ⇒ <a href="#nowhere">there</a> ⇒ links ⇒ #nowhere
    body ⇒ <a href="figures/lost.svg">there</a> ⇒ links ⇒ lost.svg
    body ⇒ <a href="https://elsewhere.invalid/">there</a> ⇒ links ⇒ elsewhere
    body ⇒ <script>nothing.there();</script> ⇒ told ⇒ ReferenceError
    body ⇒ <script>console.error('a trouble');</script> ⇒ told ⇒ a trouble
    body ⇒ <script>console.warn('a worry');</script> ⇒ told ⇒ a worry
    body ⇒ <script>setTimeout(() => Promise.reject('late'), 0);</script> ⇒ told ⇒ late
    body ⇒ <img alt="" width="9" height="9" src="http://pictures.invalid/a.png"> ⇒ told requests layout ⇒ pictures.invalid
    head ⇒ <link rel="stylesheet" href="https://fonts.invalid/a.css"> ⇒ told requests ⇒ fonts.invalid
    body ⇒ <script>fetch('https://counter.invalid/').catch(() => 0);</script> ⇒ told requests ⇒ counter.invalid
    body ⇒ <table><tr><td style="min-width: 2000px">wide</td></tr></table> ⇒ layout print ⇒ 360 px: sticks out
    body ⇒ <div style="overflow: hidden"><p style="width: 120rem; max-width: none">cut</p></div> ⇒ layout ⇒ 1600 px: cut off
    body ⇒ <table></table> ⇒ layout ⇒ no size
    body ⇒ <svg style="display: none"></svg> ⇒ layout ⇒ no size
    head ⇒ <style>p { color: #999; }</style> ⇒ contrast ⇒ light: contrast 2.85
    head ⇒ <style>@media (prefers-color-scheme: dark) { p { color: #333; } }</style> ⇒ contrast ⇒ dark: contrast
    head ⇒ <style>@media print { details::details-content { content-visibility: hidden !important; } }</style> ⇒ print ⇒ not printed
    head ⇒ <style>@media print { body { background: #222 !important; } }</style> ⇒ print ⇒ printed over
    head ⇒ <style>tr.away { display: table-row !important; }</style> ⇒ tables ⇒ rows are shown
    body ⇒ <script>document.querySelectorAll('th').forEach(of => of.addEventListener('click', e => e.stopPropagation(), true));</script> ⇒ tables ⇒ click one
    body ⇒ <script>addEventListener('load', () => document.querySelectorAll('th button').forEach(of => of.replaceWith(...of.childNodes)));</script> ⇒ tables accessible ⇒ only for a mouse
    body ⇒ <svg role="img" viewBox="0 0 9 9"><circle r="5"/></svg> ⇒ accessible ⇒ a image without a name
    body ⇒ <a href="#top" id="top"></a> ⇒ accessible ⇒ a link without a name
    body ⇒ <input type="text" style="display: block"> ⇒ print accessible ⇒ a textbox without a name
    body ⇒ <h4>deep</h4> ⇒ accessible ⇒ left out
    body ⇒ <p id="one">1</p><p id="one">2</p> ⇒ accessible ⇒ twice the id
    body ⇒ <p tabindex="3">first</p> ⇒ accessible ⇒ out of turn
"##;

#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Chromium: --features live")]
fn a_page_that_is_broken_on_purpose_is_complained_of_by_the_right_question() {
    let mut browser = Browser::start();
    let (names, all) = complaining(&mut browser, "", "");
    assert!(names.is_empty(), "the sound page: {all:#?}");
    for [place, text, wanted, words] in rows(BROKEN) {
        let [head, body] = ["head", "body"].map(|part| if part == place { text } else { "" });
        let (names, all) = complaining(&mut browser, head, body);
        assert_eq!(names.join(" "), wanted, "{text}: {all:#?}");
        let said = all.iter().any(|complaint| complaint.contains(words));
        assert!(said, "{text}: {all:#?}");
    }
}
