//! Views of tables: terminal text, HTML, CSV and Markdown.

use std::fmt::Write;

use crate::checks::Outcome;
use crate::document::{Cell, Column, Table, harmless};
use crate::tables::csv_line;

/// Letters of a column in a terminal; longer words go on below, but for those of the last column, which nothing stands behind.
const WIDEST: usize = 60;
/// Letters that a heading may have in a line at least.
const HEADING: usize = 12;

/// In lines of at most so many letters, broken at spaces; a longer word stands whole.
pub fn in_lines(words: &str, most: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in words.split(' ') {
        let last = lines.len() - 1;
        let line = &mut lines[last];
        let is_full = line.chars().count() + 1 + word.chars().count() > most;
        match line.as_str() {
            "" => *line = word.to_owned(),
            _ if is_full => lines.push(word.to_owned()),
            _ => *line = format!("{line} {word}"),
        }
    }
    lines
}

/// The lines of cells side by side.
fn across(cells: &[Vec<String>]) -> Vec<Vec<String>> {
    let at = |line: usize| cells.iter().map(move |cell| cell.get(line).cloned());
    let lines = cells.iter().map(Vec::len).max().unwrap_or(0);
    (0..lines)
        .map(|line| at(line).map(Option::unwrap_or_default).collect())
        .collect()
}

impl Table {
    /// Padded for a terminal: title, headings, a line, rows.
    pub fn text(&self) -> String {
        let cell = |(column, cell): (usize, &Cell)| {
            let words = harmless(&cell.shown()).replace(['\n', '\t'], " ");
            match column + 1 == self.columns.len() {
                true => vec![words],
                false => in_lines(&words, WIDEST),
            }
        };
        // The lines of each row: its first words, and what goes on below them.
        let in_rows = |row: &Vec<Cell>| -> Vec<Vec<String>> {
            let cells: Vec<Vec<String>> = row.iter().enumerate().map(cell).collect();
            across(&cells)
        };
        let rows: Vec<Vec<String>> = self.rows.iter().flat_map(in_rows).collect();
        let letters = |words: &String| words.chars().count();
        let widest = |column: usize| {
            let cells = rows.iter().filter_map(|row| row.get(column));
            cells.map(letters).max().unwrap_or(0)
        };
        // Headings go on below where they are wider than what they head.
        let head = |(at, column): (usize, &Column)| {
            in_lines(&column.heading(), widest(at).clamp(HEADING, WIDEST))
        };
        let heads: Vec<Vec<String>> = self.columns.iter().enumerate().map(head).collect();
        let width = |column: usize| {
            let head = heads[column].iter().map(letters).max().unwrap_or(0);
            match column + 1 == heads.len() {
                true => widest(column).max(head).min(WIDEST),
                false => widest(column).max(head),
            }
        };
        let widths: Vec<usize> = (0..heads.len()).map(width).collect();
        let line = |row: &[String]| {
            let mut line = String::new();
            for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                line += &match self.has_numbers(column) {
                    true => format!("  {cell:>width$}"),
                    false => format!("  {cell:<width$}"),
                };
            }
            line.trim_end().to_owned() + "\n"
        };
        let under: Vec<String> = widths.iter().map(|width| "─".repeat(*width)).collect();
        let mut text = String::new();
        if !self.title.is_empty() {
            text = text + &harmless(&self.title) + "\n";
        }
        across(&heads).iter().for_each(|row| text += &line(row));
        text += &line(&under);
        rows.iter().for_each(|row| text += &line(row));
        text
    }

    /// As an element that scrolls sideways where it is too wide, with its title as a caption.
    pub fn html(&self) -> String {
        let mut html = String::from("<div class=\"scroll\"><table>\n");
        if !self.title.is_empty() {
            let _ = writeln!(html, "<caption>{}</caption>", words(&self.title));
        }
        let length = |row: &Vec<Cell>, column: usize| match row.get(column) {
            Some(Cell::Text(text)) => text.len(),
            _ => 0,
        };
        let class = |column: usize| match self.rows.iter().map(|row| length(row, column)).max() {
            _ if self.has_numbers(column) => " class=\"n\"",
            None | Some(0..=16) => "",
            Some(17..=200) => " class=\"w\"",
            _ => " class=\"l\"",
        };
        html += "<tr>";
        for (index, column) in self.columns.iter().enumerate() {
            let (class, heading) = (class(index), escaped(&column.heading()));
            let _ = write!(html, "<th scope=\"col\"{class}>{heading}</th>");
        }
        html += "</tr>\n";
        for row in &self.rows {
            html += "<tr>";
            for (index, cell) in row.iter().enumerate() {
                let shown = cell.shown();
                html += &match cell {
                    Cell::Code(code) => {
                        // A long one breaks between its parts before it breaks inside one.
                        let parts = escaped(code).replace('/', "/<wbr>").replace('_', "_<wbr>");
                        format!("<td class=\"k\"><code>{parts}</code></td>")
                    }
                    Cell::Outcome(outcome) => format!("<td class=\"v\">{}</td>", mark(*outcome)),
                    Cell::Text(text) => format!("<td>{}</td>", words(text)),
                    Cell::Number(value) => {
                        format!("<td class=\"n\" title=\"{value}\">{shown}</td>")
                    }
                    _ => format!("<td{}>{}</td>", class(index), escaped(&shown)),
                };
            }
            html += "</tr>\n";
        }
        html + "</table></div>\n"
    }

    /// With all digits; an interval has three columns. Words that a spreadsheet would take for a formula begin with `'`.
    pub fn csv(&self) -> String {
        let of_intervals = |column: usize| {
            let mut cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.any(|cell| matches!(cell, Cell::Interval(_)))
        };
        let wide: Vec<bool> = (0..self.columns.len()).map(of_intervals).collect();
        let head = |column: &Column| {
            let ends = ["", ": lower end", ": upper end"];
            ends.map(|end| column.heading() + end)
        };
        let in_three = |cell: &Cell| {
            let first = match cell {
                Cell::Interval(interval) => {
                    return [interval.estimate, interval.low, interval.high]
                        .map(|number| number.to_string());
                }
                Cell::Missing => String::new(),
                Cell::Number(value) => value.to_string(),
                Cell::Count(count) => count.to_string(),
                words => no_formula(&words.shown()),
            };
            [first, String::new(), String::new()]
        };
        let line = |cells: Vec<[String; 3]>| {
            let kept = wide.iter().map(|wide| if *wide { 3 } else { 1 });
            csv_line(
                cells
                    .iter()
                    .zip(kept)
                    .flat_map(|(cell, kept)| &cell[..kept]),
            )
        };
        let head = line(self.columns.iter().map(head).collect());
        let rows = self.rows.iter();
        let rows: String = rows
            .map(|row| line(row.iter().map(in_three).collect()))
            .collect();
        head + &rows
    }

    /// As GitHub and others show it, at most `most` rows; the rest is counted.
    pub fn markdown(&self, most: usize) -> String {
        let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let heads = self
            .columns
            .iter()
            .map(|column| in_markdown(&column.heading()));
        let lines = (0..self.columns.len()).map(|column| match self.has_numbers(column) {
            true => "---:".to_owned(),
            false => "---".to_owned(),
        });
        let mut text = row(heads.collect()) + &row(lines.collect());
        for cells in self.rows.iter().take(most) {
            let cell = |cell: &Cell| match cell {
                Cell::Code(code) => code_in_markdown(code),
                cell => in_markdown(&cell.shown()),
            };
            text += &row(cells.iter().map(cell).collect());
        }
        match self.rows.len().saturating_sub(most) {
            0 => text,
            rest => text + &format!("\n… and {rest} more\n"),
        }
    }
}

impl Column {
    /// With its unit.
    fn heading(&self) -> String {
        match self.unit.as_str() {
            "" => self.title.clone(),
            unit => format!("{} ({unit})", self.title),
        }
    }
}

fn mark(outcome: Outcome) -> String {
    let (class, sign) = match outcome {
        Outcome::Pass => ("good", "✓ "),
        Outcome::Fail => ("bad", "✗ "),
        Outcome::Skipped | Outcome::ExpectedFailure => ("open", "– "),
    };
    format!("<span class=\"{class}\">{sign}{}</span>", outcome.word())
}

/// Text as text, in elements and attributes.
pub fn escaped(text: &str) -> String {
    harmless(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// The same with a link to the work that a DOI names.
fn linked(text: &str) -> String {
    let text = escaped(text);
    let Some((before, after)) = text.split_once("doi:10.") else {
        return text;
    };
    let of_name = |letter: char| letter.is_ascii_alphanumeric() || "./-_".contains(letter);
    let end = after.find(|letter| !of_name(letter)).unwrap_or(after.len());
    let name = after[..end].trim_end_matches('.');
    let rest = &after[name.len()..];
    format!("{before}<a href=\"https://doi.org/10.{name}\">doi:10.{name}</a>{rest}")
}

/// What stands between a pair of backticks is code, the rest is plain; all of it is where one has no pair.
fn with_code(text: &str, plain: fn(&str) -> String, code: fn(&str) -> String) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return plain(text);
    }
    let part = |(index, part): (usize, &&str)| match index % 2 {
        0 => plain(part),
        _ => code(part),
    };
    parts.iter().enumerate().map(part).collect()
}

/// Text in elements, with a link to a work and with code.
pub fn words(text: &str) -> String {
    let code = |part: &str| format!("<code>{part}</code>");
    with_code(&linked(text), str::to_owned, code)
}

fn no_formula(text: &str) -> String {
    let text = harmless(text);
    if text.starts_with(['=', '+', '-', '@', '\t', '\n']) {
        format!("'{text}")
    } else {
        text.into_owned()
    }
}

fn code_in_markdown(code: &str) -> String {
    let code = harmless(code).replace(['`', '|'], "'");
    format!("`{}`", code.replace(['\n', '\t'], " "))
}

/// Text in Markdown, in one line; what stands between a pair of backticks is code.
pub fn in_markdown(text: &str) -> String {
    with_code(text, plain_in_markdown, code_in_markdown)
}

fn plain_in_markdown(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in harmless(text).chars() {
        match letter {
            '|' | '*' | '_' | '`' | '[' | ']' | '<' | '>' | '\\' | '#' | '!' | '~' | '&' => {
                safe.extend(['\\', letter])
            }
            '\n' | '\t' => safe.push(' '),
            letter => safe.push(letter),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use evidence::Interval;

    fn table() -> Table {
        let mean = Interval {
            estimate: 2.0,
            low: 1.5,
            high: 2.5,
        };
        let code = Cell::Code("<b>|`\u{202e}`".to_owned());
        Table {
            rows: vec![
                vec![
                    "=1+1, \"quoted\"".into(),
                    0.470_123_456.into(),
                    mean.into(),
                    Outcome::Pass.into(),
                ],
                vec![code, Cell::Missing, Cell::Missing, Outcome::Fail.into()],
            ],
            ..Table::new(
                "t",
                "Heights | of <beds>",
                &["engine", "height, m", "mean", "outcome"],
            )
        }
    }

    #[test]
    fn long_words_go_on_below_and_push_no_number_aside() {
        let mut table = Table::new("t", "", &["of", "force, N", "why"]);
        let long = "the field averaged over the control square of side R at the centre";
        let why = "a sentence that nothing stands behind, so that it may be as long as it is";
        table.row([long.into(), 1.5.into(), why.into()]);
        table.row(["Σ".into(), 20.0.into(), "short".into()]);
        let (head, tail) = long.split_at(long.len() - "centre".len());
        let text = table.text();
        let lines: Vec<&str> = text.lines().skip(2).collect();
        let [head, tail] = [head, tail].map(str::trim);
        assert_eq!(lines[0], format!("  {head}        1.5  {why}"));
        assert_eq!(lines[1], format!("  {tail}"));
        assert_eq!(lines[2].find("20"), lines[0].find("1.5").map(|at| at + 2));
    }

    #[test]
    fn a_terminal_has_columns() {
        let text = table().text();
        let lines: Vec<&str> = text.lines().collect();
        let [_, head, _, first, last] = lines[..] else {
            panic!("{text}");
        };
        let wanted = [
            "  engine          height (m)          mean  outcome",
            "  =1+1, \"quoted\"      0.4701  2 [1.5, 2.5]  pass",
            "  <b>|`\\u{202e}`           –             –  FAIL",
        ];
        assert_eq!([head, first, last], wanted);
    }

    #[test]
    fn a_page_has_text_as_text() {
        let html = table().html();
        assert!(!html.contains("<b>"), "{html}");
        for part in [
            "&lt;b&gt;|`\\u{202e}`",
            "<th scope=\"col\" class=\"n\">height (m)</th>",
            "title=\"0.470123456\">0.4701<",
        ] {
            assert!(html.contains(part), "{html}");
        }
        assert_eq!(words("a `b` & `c"), "a `b` &amp; `c");
        assert_eq!(words("a `b`"), "a <code>b</code>");
    }

    #[test]
    fn a_file_has_all_digits_and_no_formulas() {
        let text = table().csv();
        let mut reader = csv::ReaderBuilder::new();
        let mut reader = reader.has_headers(false).from_reader(text.as_bytes());
        let rows = reader.records().map(|row| {
            let row = row.expect("a row");
            row.iter().collect::<Vec<_>>().join("|")
        });
        let wanted = [
            "engine|height (m)|mean|mean: lower end|mean: upper end|outcome",
            "'=1+1, \"quoted\"|0.470123456|2|1.5|2.5|pass",
            "<b>|`\\u{202e}`|||||FAIL",
        ];
        assert_eq!(rows.collect::<Vec<_>>(), wanted);
    }

    #[test]
    fn a_summary_breaks_no_table_and_counts_what_it_leaves_out() {
        let text = table().markdown(1);
        assert!(text.ends_with("\n\n… and 1 more\n"), "{text}");
        for line in table().markdown(9).lines() {
            assert_eq!(line.replace("\\|", "").matches('|').count(), 5, "{line}");
        }
    }
}
