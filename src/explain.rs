//! What a check means, how it is computed, where that comes from and what usually breaks it, by the beginning of its id:
//! `explain.md`, read.

use std::sync::LazyLock;

/// Of a family of checks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Explanation {
    /// Parts of the ids with `*` for any one part; the longest that fits counts.
    pub pattern: &'static str,
    /// What it means that it passes.
    pub meaning: &'static str,
    /// How it is computed.
    pub formula: &'static str,
    /// Where that comes from, and where in the project it is.
    pub source: &'static str,
    /// What usually breaks it, and what to do then.
    pub breaks: &'static str,
}

/// All families.
pub static EXPLANATIONS: LazyLock<Vec<Explanation>> = LazyLock::new(|| {
    let families = include_str!("explain.md").split("\n## `");
    families.skip(1).map(Explanation::parse).collect()
});

impl Explanation {
    /// Of a section of the document, without the mark of its heading.
    fn parse(section: &'static str) -> Self {
        let part = |begins| {
            let line = section.lines().find_map(|line| line.strip_prefix(begins));
            line.expect("each family has all four parts")
        };
        Explanation {
            pattern: section.split('`').next().unwrap_or_default(),
            meaning: part("- Meaning: "),
            formula: part("- Formula: "),
            source: part("- Source: "),
            breaks: part("- Breaks: "),
        }
    }
}

/// The explanation of a check's id; none if it is of no family.
pub fn of(id: &str) -> Option<&'static Explanation> {
    let fitting = EXPLANATIONS
        .iter()
        .filter(|explanation| fits(explanation.pattern, id));
    fitting.max_by_key(|explanation| {
        (
            explanation.pattern.split('/').count(),
            explanation.pattern.len(),
        )
    })
}

/// Whether an id, or its beginning, fits a pattern. What follows the pattern may be anything.
fn fits(pattern: &str, id: &str) -> bool {
    let mut parts = id.split('/');
    pattern.split('/').all(|wanted| match parts.next() {
        Some(part) => wanted == "*" || wanted == part,
        None => wanted == "*",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_pattern_counts() {
        for (id, pattern) in [
            ("compare/sorted-live/same-scene", "compare/*/same-scene"),
            ("compare/sorted-live/bits-of-bodies", "compare/*"),
            ("compare/a/quantity/settled.height", "compare/*/quantity/*"),
            ("verify/tested/free-fall/dropped/x/100-steps", "verify/*"),
            ("verify", "verify/*"),
            ("bench/bits", "bench/bits"),
            ("bench", "bench/*"),
            ("search/emulator/height", "search/*"),
            ("engine/damping", "engine/*"),
            ("engine/itself/units", "engine/itself/*"),
            ("campaign/rows", "*/rows"),
            ("parameters/everything/dt", "parameters/*"),
        ] {
            assert_eq!(
                super::of(id).map(|explanation| explanation.pattern),
                Some(pattern),
                "{id}"
            );
        }
        assert_eq!(super::of("bake/a"), None);
        assert_eq!(super::of(""), None);
    }

    #[test]
    fn sources_are_there() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let is_path = |path: &&str| {
            ["src/", "crates/", "docs/"]
                .iter()
                .any(|at| path.starts_with(at))
        };
        for explanation in EXPLANATIONS.iter() {
            for path in explanation.source.split("; ").filter(is_path) {
                assert!(root.join(path).exists(), "{}: {path}", explanation.pattern);
            }
        }
    }
}
