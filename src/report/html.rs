//! Views of a document: a page, and terminal text.

use std::path::Path;

use super::plot::svg;
use super::views::{in_markdown, words};
use super::{SCRIPT, STYLE};
use crate::checks::{Check, Outcome, Tally, slug};
use crate::compare::baseline::diff::Diff;
use crate::document::{Block, Cell, Document, Section, Table, Tile, harmless};
use crate::error::Error;
use crate::files::{make_folder, sha256_hex, write_whole};

/// The folder of a page's figures and tables, beside the page.
pub const FOLDER: &str = "figures";
/// The name of a job's first page, without its end.
pub const FIRST: &str = "report";
/// Failed checks in a list for people at most, and other ones that did not pass; the page and the files have all.
const MOST_CHECKS: usize = 40;
const MOST_OTHERS: usize = 6;

/// A page with the figures and tables on it as files.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Its file's name, without its end.
    pub name: String,
    /// Needs nothing else; its links lead to the files.
    pub html: String,
    /// Names and contents, in the order of the page: each figure as SVG and CSV, each table as CSV.
    pub files: Vec<(String, String)>,
}

impl Page {
    /// Writes the files into `folder`/figures and then the page, which links to them.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        if !self.files.is_empty() {
            make_folder((folder, FOLDER))?;
        }
        for (name, contents) in &self.files {
            write_whole((folder, &format!("{FOLDER}/{name}")), contents.as_bytes())?;
        }
        let page = format!("{}.html", self.name);
        Ok(write_whole((folder, &page), self.html.as_bytes())?)
    }

    /// A file; the value is the name, which may have got a number to be unique, without its end.
    fn add(&mut self, name: &str, contents: &[(&str, String)]) -> String {
        let name = match self.name.as_str() {
            FIRST => slug(name),
            page => slug(&format!("{page}-{name}")),
        };
        let taken = |name: &str| {
            let end = format!("{name}.csv");
            self.files.iter().any(|(other, _)| *other == end)
        };
        let numbered = (2..).map(|number| format!("{name}-{number}"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        let free = names.find(|name| !taken(name)).unwrap_or(name);
        for (end, contents) in contents {
            self.files.push((format!("{free}.{end}"), contents.clone()));
        }
        free
    }
}

/// A document as one page that opens offline: the verdict, the answer and what failed first, then the sections, with details
/// folded, and every check at the end.
pub fn page(document: &Document) -> Page {
    page_against(FIRST, document, None)
}

/// The same under a name; if the run was held against a baseline, what is worse than in it stands with the verdict.
pub fn page_against(name: &str, document: &Document, diff: Option<&Diff>) -> Page {
    let mut page = Page {
        name: name.to_owned(),
        html: String::new(),
        files: Vec::new(),
    };
    let (sections, checks) = (&document.sections, &document.checks);
    let of_baseline = |wanted| diff.filter(|diff| diff.verdict == wanted);
    let (worse, untold) = (of_baseline(Outcome::Fail), of_baseline(Outcome::Skipped));
    let class = match document.verdict {
        Outcome::Fail => "bad",
        _ if worse.is_some() => "bad",
        Outcome::Pass if untold.is_none() => "good",
        _ => "open",
    };
    let title = words(&document.title);
    let named = |text: &str| format!("<span class=\"named\">{}</span>\n", words(text));
    let back = match name {
        FIRST => "",
        _ => "<p class=\"back\"><a href=\"report.html\">← the job's first page</a></p>\n",
    };
    let said = document.verdict_in_words();
    let mut heading = said.unwrap_or_default().to_owned();
    if let Some(worse) = worse {
        heading += &format!(", and worse than {}", words(&worse.baseline));
    }
    if let Some(untold) = untold {
        heading += &format!(", but incomplete against {}", words(&untold.baseline));
    }
    if !heading.is_empty() {
        heading = format!("<strong>{heading}</strong>\n");
    }
    let mut body = format!("{back}<h1>{title}</h1>\n<div class=\"verdict {class}\">{heading}");
    for line in worse.map(Diff::worse).unwrap_or_default() {
        body += &named(&line);
    }
    body += &named(&document.answer);
    if !checks.is_empty() {
        body += &format!("{}.", Tally::of(checks));
    }
    body += "</div>\n";
    let failed = of_outcome(checks, Outcome::Fail);
    if !failed.is_empty() {
        let table = short_table(&failed).html();
        body += &format!("<h2 id=\"failed\">What failed</h2>\n<div class=\"tall\">{table}</div>\n");
    }
    let link = |id: &str, title: &str| format!("<a href=\"#{id}\">{}</a>", words(title));
    let numbered = || (1..).map(|at| format!("section-{at}")).zip(sections);
    if sections.len() > 2 {
        let mut links: String = numbered()
            .map(|(id, section)| link(&id, &section.title))
            .collect();
        if !checks.is_empty() {
            links += &link("checks", "Every check");
        }
        body += &format!("<nav class=\"contents\" aria-label=\"On this page\">{links}</nav>\n");
    }
    for (id, section) in numbered() {
        body += &section_html(&mut page, &id, section);
    }
    if !checks.is_empty() {
        let html = with_file(&mut page, &Table::of_checks("checks", checks));
        let (count, s) = (checks.len(), if checks.len() == 1 { "" } else { "s" });
        body += &format!(
            "<h2 id=\"checks\">Every check</h2>\n<details><summary>{count} check{s} with limits and where these come from</summary>\n{html}</details>\n"
        );
    }
    // Of the whole text, so that no part of it can name it: no script runs but the page's own, and nothing is asked for.
    let nonce = &sha256_hex(body.as_bytes())[..32];
    page.html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src \
         'nonce-{nonce}'; base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}{}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n<script nonce=\"{nonce}\">\n{SCRIPT}</script>\n</body>\n</html>\n",
        said.map(|said| format!(": {said}")).unwrap_or_default()
    );
    page
}

fn section_html(page: &mut Page, id: &str, section: &Section) -> String {
    let mut html = format!("<h2 id=\"{id}\">{}</h2>\n", words(&section.title));
    if !section.answer.is_empty() {
        html += &format!("<p>{}</p>\n", words(&section.answer));
    }
    let mut inner = String::new();
    let mut pictures = 0;
    for block in &section.blocks {
        let picture = match block {
            Block::Heading(text) => Err(format!("<h3>{}</h3>\n", words(text))),
            Block::Text(text) => Err(format!("<p>{}</p>\n", words(text))),
            Block::Table(table) => Err(with_file(page, table)),
            Block::Plot(plot) => Ok(figure(page, &plot.caption, &svg(plot), &plot.table())),
            Block::Drawing(drawing) => {
                Ok(figure(page, &drawing.caption, &drawing.svg, &drawing.table))
            }
            Block::Tiles(tiles) => Err(tiles_html(tiles)),
        };
        // Pictures one after another stand side by side where there is room.
        match &picture {
            Ok(_) if pictures == 0 => inner += "<div class=\"pair\">\n",
            Err(_) if pictures > 0 => inner += "</div>\n",
            _ => {}
        }
        pictures = if picture.is_ok() { pictures + 1 } else { 0 };
        inner += &picture.unwrap_or_else(|other| other);
    }
    if pictures > 0 {
        inner += "</div>\n";
    }
    if section.details && !inner.is_empty() {
        let mut titles = section.blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table.title.as_str()),
            _ => None,
        });
        let summary = titles.find(|title| !title.is_empty()).unwrap_or("Details");
        let summary = words(summary);
        inner = format!("<details><summary>{summary}</summary>\n{inner}</details>\n");
    }
    html + &inner
}

fn tiles_html(tiles: &[Tile]) -> String {
    let tile = |tile: &Tile| {
        let figure = match tile.figure.as_str() {
            "" => String::new(),
            figure => format!("<strong>{}</strong>", words(figure)),
        };
        let (page, title, words) = (tile.page, words(&tile.title), words(&tile.words));
        format!("<a class=\"tile\" href=\"{page}.html\"><span>{title}</span>{figure}{words}</a>\n")
    };
    let all: String = tiles.iter().map(tile).collect();
    format!("<div class=\"tiles\">\n{all}</div>\n")
}

/// A table without the columns that hold nothing, with a link to its file, which has them.
fn with_file(page: &mut Page, table: &Table) -> String {
    let html = table.clone().without_empty_columns().html();
    if table.name.is_empty() || table.rows.is_empty() {
        return html;
    }
    let name = page.add(&table.name, &[("csv", table.csv())]);
    format!("{html}<p class=\"files\"><a href=\"{FOLDER}/{name}.csv\">CSV</a></p>\n")
}

fn figure(page: &mut Page, caption: &str, svg: &str, table: &Table) -> String {
    let caption = words(caption);
    if table.rows.is_empty() {
        return format!("<p class=\"open\">{caption}: there is nothing to draw.</p>\n");
    }
    let name = page.add(
        &table.name,
        &[("svg", svg.to_owned()), ("csv", table.csv())],
    );
    format!(
        "<figure id=\"fig-{name}\"><div class=\"scroll\"><div class=\"drawn\">{svg}</div></div><figcaption>{caption} <span class=\"files\">\
         <a href=\"{FOLDER}/{name}.svg\">SVG</a> <a href=\"{FOLDER}/{name}.csv\">CSV</a></span></figcaption></figure>\n"
    )
}

/// A document for a terminal: what stands on the page but details and pictures, and the verdict where the eye is at the end.
pub fn terminal(document: &Document) -> String {
    let mut text = format!("{}\n", document.title);
    for section in document.sections.iter().filter(|section| !section.details) {
        text += &format!("\n{}\n", section.title);
        if !section.answer.is_empty() {
            text += &format!("{}\n", section.answer);
        }
        let tile = |tile: &Tile| format!("{}: {} {}\n", tile.title, tile.figure, tile.words);
        for block in &section.blocks {
            text += &match block {
                Block::Heading(words) => format!("\n{words}\n"),
                Block::Text(words) => format!("{words}\n"),
                Block::Table(table) => {
                    format!("\n{}", table.clone().without_empty_columns().text())
                }
                Block::Plot(plot) => format!("[picture {}: {}]\n", plot.name, plot.caption),
                Block::Drawing(drawing) => {
                    format!("[picture {}: {}]\n", drawing.table.name, drawing.caption)
                }
                Block::Tiles(tiles) => tiles.iter().map(tile).collect(),
            };
        }
    }
    text += "\n";
    text += &check_lines(&document.checks, false);
    if let Some(said) = document.verdict_in_words() {
        text = text + &said.to_uppercase() + ": ";
    }
    text = text + &document.answer + "\n";
    if !document.checks.is_empty() {
        text += &format!("{}\n", Tally::of(&document.checks));
    }
    harmless(&text).into_owned()
}

/// A document as the summary of a job in Markdown: verdict and answer, what failed, the sections' tables, and what was not made.
pub fn markdown(document: &Document) -> String {
    let (sections, checks) = (&document.sections, &document.checks);
    let said = document.verdict_in_words();
    let said = said.map_or(String::new(), |said| format!(": {said}"));
    let title = in_markdown(&(document.title.clone() + &said));
    let mut text = format!("## {title}\n\n{}\n", in_markdown(&document.answer));
    if !checks.is_empty() {
        text += &format!("\n{}.\n", Tally::of(checks));
    }
    let listed = |outcome: Outcome| {
        let matching = of_outcome(checks, outcome);
        let rows = short_table(&matching).markdown(MOST_CHECKS);
        let list = format!("\n### {} ({})\n\n{rows}", outcome.word(), matching.len());
        (!matching.is_empty()).then_some(list)
    };
    text.extend(listed(Outcome::Fail));
    for section in sections.iter().filter(|section| !section.details) {
        text += &format!("\n### {}\n", in_markdown(&section.title));
        if !section.answer.is_empty() {
            text += &format!("\n{}\n", in_markdown(&section.answer));
        }
        for block in &section.blocks {
            text += &match block {
                Block::Heading(words) => format!("\n#### {}\n", in_markdown(words)),
                Block::Text(words) => format!("\n{}\n", in_markdown(words)),
                Block::Table(table) => {
                    let table = table.clone().without_empty_columns();
                    format!("\n{}", table.markdown(MOST_CHECKS))
                }
                Block::Plot(_) | Block::Drawing(_) | Block::Tiles(_) => continue,
            };
        }
    }
    text.extend(listed(Outcome::Skipped));
    text.extend(listed(Outcome::ExpectedFailure));
    text
}

fn of_outcome(checks: &[Check], outcome: Outcome) -> Vec<&Check> {
    let matching = checks.iter().filter(|check| check.outcome == outcome);
    matching.collect()
}

/// A line a check, failures first; those that passed, and more than some of one kind, only where `all` are wanted.
pub fn check_lines(checks: &[Check], all: bool) -> String {
    let mut text = String::new();
    for (outcome, most) in [
        (Outcome::Fail, MOST_CHECKS),
        (Outcome::Skipped, MOST_OTHERS),
        (Outcome::ExpectedFailure, MOST_OTHERS),
        (Outcome::Pass, 0),
    ] {
        if outcome == Outcome::Pass && !all {
            continue;
        }
        let matching = of_outcome(checks, outcome);
        let most = if all { usize::MAX } else { most };
        for check in matching.iter().take(most) {
            let line = check.in_a_line();
            // The key of a measure is its title too.
            let said = match line.strip_prefix(&check.quantity) {
                Some(rest) if check.id.ends_with(&check.quantity) => rest.to_owned(),
                _ => format!(": {line}"),
            };
            text += &format!("{:>16} {}{said}\n", outcome.word(), check.id);
        }
        if matching.len() > most {
            let (word, rest) = (outcome.word(), matching.len() - most);
            text += &format!("{word:>16} … and {rest} more\n");
        }
    }
    harmless(&text).into_owned()
}

/// Checks by their names and sentences.
fn short_table(checks: &[&Check]) -> Table {
    Table::of("", "", checks.iter().copied())
        .column("check", |check| Cell::Code(check.id.clone()))
        .column("found", Check::in_a_line)
        .into()
}

impl Table {
    /// All that is known of checks, a row each.
    pub fn of_checks(name: &str, checks: &[Check]) -> Table {
        let text = |text: &str| Some(text.to_owned()).filter(|owned| !owned.is_empty());
        Table::of(name, "", checks)
            .column("outcome", |check| check.outcome)
            .column("id", |check| Cell::Code(check.id.clone()))
            .column("quantity", |check| text(&check.quantity))
            .column("unit", |check| text(&check.unit))
            .column("value", |check| check.value)
            .column("expected", |check| check.expected)
            .column("lower", |check| check.lower)
            .column("upper", |check| check.upper)
            .column("n", |check| check.n)
            .column("interval_low", |check| check.interval.map(|[low, _]| low))
            .column("interval_high", |check| {
                check.interval.map(|[_, high]| high)
            })
            .column("method", |check| text(&check.method))
            .column("basis", |check| text(&check.basis))
            .column("found", |check| text(&check.found))
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Axis, Colour, Plot};

    fn document() -> Document {
        let check = |id: &str, outcome| Check::of_words(id, "height", outcome, "<it>");
        let table = Table::of("heights", "Heights", [1.0]).column("height, m", |height| height);
        let [x, y] = ["time, s", "height, m"].map(Axis::linear);
        let plot = Plot::new("fall", "It falls", x, y);
        let points = [[0.0, 1.0], [1.0, 0.0]];
        let drawn = plot.clone().line("ball", Colour::Blue, points);
        let both = |title: &str, answer: &str| {
            let section = Section::new(title, answer).with(table.clone());
            section.with(drawn.clone())
        };
        Document {
            title: "A job & its <title>".to_owned(),
            verdict: Outcome::Fail,
            answer: "It fell.".to_owned(),
            sections: vec![
                both("First", "An answer."),
                both("Second", "").as_details(),
                Section::new("Third", "").with(plot),
            ],
            checks: vec![
                check("a/good", Outcome::Pass),
                check("a/bad", Outcome::Fail),
            ],
        }
    }

    #[test]
    fn a_page_says_the_verdict_first_and_links_to_files_of_its_own() {
        let page = page(&document());
        let order = [
            "A job &amp; its &lt;title&gt;</h1>",
            "<strong>Different",
            "It fell.",
            "What failed",
            "a/<wbr>bad",
            "First",
            "<svg ",
            "<details>",
            "a/<wbr>good",
        ];
        let places = order.map(|words| page.html.find(words));
        assert!(places[0].is_some() && places.is_sorted(), "{places:?}");
        let names: Vec<&str> = page.files.iter().map(|(name, _)| name.as_str()).collect();
        let own = [
            "heights.csv",
            "fall.svg",
            "fall.csv",
            "heights-2.csv",
            "fall-2.svg",
            "fall-2.csv",
            "checks.csv",
        ];
        assert_eq!(names, own);
        for name in names {
            let link = format!("href=\"figures/{name}\"");
            assert_eq!(page.html.matches(&link).count(), 1, "{name}");
        }
        assert!(page.html.contains("It falls: there is nothing to draw"));
    }

    #[test]
    fn a_summary_has_what_did_not_pass() {
        let text = markdown(&document());
        let head = "## A job \\& its \\<title\\>: Different\n\nIt fell.\n";
        assert!(text.starts_with(head), "{text}");
        let rows =
            "### FAIL (1)\n\n| check | found |\n| --- | --- |\n| `a/bad` | height; \\<it\\> |\n";
        let first = text.find(rows).expect("what failed");
        assert!(
            text.find("| 1 |").is_some_and(|place| place > first),
            "{text}"
        );
    }

    #[test]
    fn a_terminal_has_the_verdict_last_and_no_details() {
        let text = terminal(&document());
        for part in [
            "FAIL a/bad: height; <it>",
            "[picture fall: It falls]",
            "DIFFERENT: It fell.\n1 check passed, 1 failed",
        ] {
            assert!(text.contains(part), "{text}");
        }
        assert!(!text.contains("a/good") && !text.contains("Second"));
        let mut crashed = document();
        crashed.checks[1].engine_failed = true;
        assert!(terminal(&crashed).contains("ENGINE FAILED: It fell.\n"));
        assert!(markdown(&crashed).contains(": Engine failed\n"));
        assert!(page(&crashed).html.contains("<strong>Engine failed"));
        assert_eq!(crashed.exit_code(), crate::exit::ENGINE_FAILED);
    }
}
