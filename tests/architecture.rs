//! The order of the house: modules of the program import only what stands above them in `src/lib.rs`, one of them alone opens
//! files, the crates know no files, terminals and processes, and values are called what they are.

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
    let other = |letter: char| !letter.is_alphanumeric() && letter != '_';
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
    let place = |name: &str| order.iter().position(|module| module == name);
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
    for name in ["grains", "evidence", "verdict"] {
        let files = rust_files(&root(&format!("crates/{name}/src")));
        assert!(files.len() > 5, "{name}");
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
            .fold((*line).to_owned(), |line, typed| line.replace(typed, ""));
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

/// The code without comments and what stands in quotation marks, which are no names.
fn names_alone(code: &str) -> String {
    let (mut names, mut rest) = (String::new(), code);
    while let Some(at) = rest.find(['"', '\'', '/']) {
        names.push_str(&rest[..at]);
        rest = &rest[at..];
        let before = names.trim_end_matches('#');
        let raw_end = format!("\"{}", "#".repeat(names.len() - before.len()));
        let escaped = |quote: char| {
            let mut is_escaped = false;
            let end = rest[1..].find(|letter: char| {
                let ends = letter == quote && !is_escaped;
                is_escaped = letter == '\\' && !is_escaped;
                ends
            });
            end.map(|end| end + 2)
        };
        let length = match rest.as_bytes()[0] {
            b'/' if rest.starts_with("//") => rest.find('\n'),
            b'/' => Some(1),
            b'"' if before.ends_with('r') => {
                rest[1..].find(&raw_end).map(|end| end + 1 + raw_end.len())
            }
            b'"' => escaped('"'),
            // A letter, and not a lifetime.
            _ if rest.starts_with("'\\") || rest.chars().nth(2) == Some('\'') => escaped('\''),
            _ => Some(1),
        };
        rest = &rest[length.unwrap_or(rest.len())..];
    }
    names + rest
}

/// The lines with a value, a field or an import that is called `of`. Constructors and methods may have the name, since they are read
/// with what stands before them: `Rows::of(members)`.
fn values_called_of(code: &str) -> Vec<String> {
    let names = names_alone(code);
    let is_of_a_name = |letter: char| letter.is_alphanumeric() || letter == '_';
    let is_value = |line: &&str| {
        line.match_indices("of").any(|(at, word)| {
            let (before, after) = (&line[..at], &line[at + word.len()..]);
            let is_whole = !before.ends_with(is_of_a_name) && !after.starts_with(is_of_a_name);
            is_whole && !["::", ".", "fn "].iter().any(|with| before.ends_with(with))
        })
    };
    let lines = names.lines().filter(is_value);
    lines.map(|line| line.trim().to_owned()).collect()
}

#[test]
fn a_value_is_called_what_it_is() {
    let files = ["src", "crates"]
        .map(|name| rust_files(&root(name)))
        .concat();
    assert!(files.len() > 150, "{} files", files.len());
    let mut found = Vec::new();
    for path in files {
        let name = path.strip_prefix(root("")).expect("below the root");
        let lines = values_called_of(&text_of(&path)).into_iter();
        found.extend(lines.map(|line| format!("{}: {line}", name.display())));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_value_called_of_is_noticed() {
    let wrong = "|of| 0\n|&of| 0\n|(_, of)| 0\nlet of = 0\nlet mut of = 0\nlet (a, of) = b\nfor of in b\nfn f(of: u8)\n\
        pub of: u8\nShard { of }\nSome(of)\nuse a::{b, of};\n'\"', |of| 0\n\"\\\"\", |of| 0\nf::<'a>(|of| 0)\n1 / of";
    let right = "fn of(a: u8)\nRows::of(members)\nrows.of(member)\n\"|of|\" // |of|\nr#\"\"|of|\"#\na.is_multiple_of(b)\n\
        \"let\nof\"\n'\"' // let of\n'\\'' // of";
    assert_eq!(values_called_of(wrong).len(), wrong.lines().count());
    assert_eq!(values_called_of(right), Vec::<String>::new());
}
