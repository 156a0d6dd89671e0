//! The order of the house: modules of the program import only what stands above them in `src/lib.rs`, one of them alone opens
//! files, and the crates know no files, terminals and processes.

use crate::support::*;

/// Every Rust file below a folder.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = below(folder);
    files.retain(|path| path.extension().is_some_and(|end| end == "rs"));
    files
}

/// The code without line comments.
fn code(path: &Path) -> String {
    let text = text_of(path);
    let lines = text.lines().map(|line| match line.find("//") {
        Some(at) => &line[..at],
        None => line,
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// The names after `crate::`, and of `crate::{X, Y::…}` every name.
fn imported(code: &str) -> impl Iterator<Item = &str> {
    let other = |of: char| !of.is_alphanumeric() && of != '_';
    code.split("crate::").skip(1).flat_map(move |rest| {
        let end = match rest.starts_with('{') {
            true => rest.find(';'),
            false => rest.find(other),
        };
        rest[..end.unwrap_or(rest.len())].split(other)
    })
}

/// The modules in the order of the data, as `src/lib.rs` has them.
fn order() -> Vec<String> {
    let lib = code(&root("src/lib.rs"));
    let modules = lib.lines().filter_map(|line| {
        let name = line.strip_prefix("pub mod ")?;
        Some(name.trim_end_matches([';', ' ', '{']).to_owned())
    });
    modules.collect()
}

/// What imports from right to left, as `module → module in file`.
fn wrong_ways(order: &[String], files: &[(String, String)]) -> Vec<String> {
    let place = |name: &str| order.iter().position(|of| of == name);
    let mut wrong = Vec::new();
    for (file, code) in files {
        let module = file.split('/').next().unwrap_or_default();
        let Some(here) = place(module.trim_end_matches(".rs")) else {
            continue;
        };
        for name in imported(code) {
            if place(name).is_some_and(|there| there > here) {
                wrong.push(format!("{} → {name} in {file}", order[here]));
            }
        }
    }
    wrong.sort();
    wrong.dedup();
    wrong
}

#[test]
fn modules_import_only_what_stands_before_them() {
    let source = root("src");
    let file = |path: PathBuf| {
        let name = path.strip_prefix(&source).expect("below src");
        (name.to_string_lossy().into_owned(), code(&path))
    };
    let files: Vec<(String, String)> = rust_files(&source).into_iter().map(file).collect();
    assert!(files.len() > 100, "{} files", files.len());
    let wrong = wrong_ways(&order(), &files);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn an_import_from_the_right_is_noticed() {
    let order = ["files", "engine", "study"].map(str::to_owned);
    let file = |name: &str, code: &str| (name.to_owned(), code.to_owned());
    let files = [
        file("study/plan.rs", "use crate::engine::Task;"),
        file("engine.rs", "fn f() -> crate::study::Plan {}"),
        file("files.rs", "use crate::{files::{a, b}, engine::{c}};"),
        file("main.rs", "use crate::study;"),
    ];
    let wrong = ["engine → study in engine.rs", "files → engine in files.rs"];
    assert_eq!(wrong_ways(&order, &files), wrong);
}

/// Someone can take the engine or the statistics alone: they compute, and leave reading and writing to who uses them.
#[test]
fn the_crates_know_no_files_terminals_and_processes() {
    const FORBIDDEN: &str =
        "std::fs std::process std::io std::net std::env println! eprintln! print! dbg!";
    for of in ["grains", "evidence", "verdict"] {
        let files = rust_files(&root(&format!("crates/{of}/src")));
        assert!(files.len() > 5, "{of}");
        for path in files {
            let code = code(&path);
            for word in FORBIDDEN.words() {
                assert!(!code.contains(word), "{word} in {}", path.display());
            }
        }
    }
}

/// What opens files, or asks for them by their paths.
const OF_FILES: &str = "std::fs fs:: File:: OpenOptions read_dir canonicalize symlink_metadata .exists() .is_dir() tempfile symlink( read_link";

/// Lines of a file of the program, its unit tests aside, that open a file or ask for one elsewhere than in `src/files.rs`.
fn other_doors(code: &str) -> Vec<&str> {
    let own = code.split("#[cfg(test)]").next().unwrap_or_default();
    let opens = |line: &&str| {
        // Types open nothing.
        let types = ["std::fs::File;", "unix::fs::FileExt;", "rustix::fs::Mode:"];
        let rest = types
            .iter()
            .fold((*line).to_owned(), |line, of| line.replace(of, ""));
        OF_FILES.words().iter().any(|word| rest.contains(word))
    };
    own.lines().filter(opens).collect()
}

#[test]
fn files_are_opened_in_one_module() {
    let source = root("src");
    for path in rust_files(&source) {
        let name = path.strip_prefix(&source).expect("below src").to_owned();
        let code = code(&path);
        let found = other_doors(&code);
        let is_door = name == Path::new("files.rs");
        assert!(is_door || found.is_empty(), "{}: {found:?}", name.display());
        assert!(!is_door || found.len() > 10, "{found:?}");
    }
}

#[test]
fn another_door_is_noticed() {
    let code = "use std::fs::File;\nlet a = std::fs::read(path);\nlet b = path.exists();\n#[cfg(test)]\nfs::write()";
    assert_eq!(other_doors(code).len(), 2);
}
