//! What all pages share: head, style, and how numbers are written.

use minijinja::Environment;
use serde::Serialize;

use super::{SCRIPT, STYLE};
use crate::error::Error;

const SHELL: &str = include_str!("shell.html");
/// How every figure is set, with links to its files.
const FIGURE: &str = include_str!("figure.html");

/// Renders the last of these templates (name, text) with `page`; the others may be included in it. A page
/// extends `shell.html`, which needs `word`, the title.
pub fn render(templates: &[(&str, &str)], page: &impl Serialize) -> Result<String, Error> {
    let failed = |error: minijinja::Error| Error::Report(error.to_string());
    let mut environment = Environment::new();
    environment.add_global("style", STYLE);
    environment.add_global("script", SCRIPT);
    environment.add_filter("short", crate::paper::short);
    environment.add_filter("exp", |value: f64| format!("{value:.2e}"));
    environment.add_filter("number", number);
    environment.add_filter("two", |value: f64| format!("{value:.2}"));
    environment.add_filter("figures3", |value: f64| format!("{value:.3}"));
    environment.add_filter("truncated", truncated);
    environment.add_filter("figures", |value: f64| format!("{value:.6}"));
    let mut last = "shell.html";
    for (name, text) in [("figure.html", FIGURE), (last, SHELL)]
        .iter()
        .chain(templates)
    {
        environment.add_template(name, text).map_err(failed)?;
        last = name;
    }
    environment
        .get_template(last)
        .and_then(|template| template.render(minijinja::value::Serde(page)))
        .map_err(failed)
}

/// The last part of a long path of a function, without its arguments.
fn truncated(name: &str) -> String {
    const LONGEST: usize = 60;
    if name.starts_with("0x") {
        return "(a function without a name)".to_owned();
    }
    let name = name.split('(').next().unwrap_or(name);
    let parts: Vec<&str> = name.split("::").collect();
    let short = parts[parts.len().saturating_sub(2)..].join("::");
    short.chars().take(LONGEST).collect()
}

/// All digits, as a power of ten where zeros would be many.
pub fn number(value: f64) -> String {
    if value == 0.0 || (1.0e-4..1.0e7).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
