//! README and docs: they stay short, their links lead somewhere, and their commands do what is printed.
//!
//! Blocks marked `sh` are commands; blocks marked `console` have commands after `$ ` and what they print, where `…`
//! stands for anything. A comment `# exit code N` ends a command that does not end with 0. The commands of a page are run
//! in one folder, in their order, with `adapters`, `examples`, `python` and `reference_data` as in the checkout, and without YADE.

use std::os::unix::fs::symlink;

use crate::support::*;

const WORDS_OF_README: usize = 1_000;
const WORDS_OF_DOCS: usize = 12_000;
/// Two pages, its header and citations included.
const WORDS_OF_PAPER: usize = 1_000;
const PAPER: &str = "paper/paper.md";

/// Commands of the pages that are not run here: how they begin, why, and the file that has the line that runs them.
const ELSEWHERE: &str = r#"
    cargo run --release -- reproduce ⇒ runs YADE where there is one, for minutes ⇒ ci/test ⇒ "$crossgrain" reproduce --out
    ci/test ⇒ is everything ⇒ .ci/run ⇒ exec bash ci/test
    apt-get install ⇒ changes the system ⇒ ci/install_engines ⇒ lmp:lammps liggghts:liggghts esysparticle:esys-particle
    crossgrain verify --detection-limits ⇒ takes minutes, and is a part of the main job ⇒ src/reproduce.rs ⇒ verify --detection-limits
    crossgrain stability ⇒ takes minutes ⇒ ci/test ⇒ stability --quick --out
    crossgrain bench ⇒ wants a quiet machine ⇒ ci/test ⇒ bench --quick --out
    /usr/bin/python3 -i yade_scripts/open_run.py ⇒ needs YADE, and a reader who types ⇒ tests/yade_open.rs ⇒ open_run.load(folder, settled)
    ci/release ⇒ wants root ⇒ ci/test ⇒ bash ci/release "$out/release"
    crossgrain study run methods ⇒ takes minutes ⇒ ci/test ⇒ study run "$out/tradeoff"
    crossgrain engine check yade ⇒ needs YADE ⇒ tests/conformance_table.rs ⇒ engine table --grains 100 --quiet --out table yade-sorted yade-ordinary
    crossgrain engine check exec:adapters/lammps.py ⇒ needs LAMMPS ⇒ tests/conformance_table.rs ⇒ engine table --grains 100 --quiet --out table yade-sorted yade-ordinary lammps
    git bisect ⇒ wants a repository with a change to find ⇒ tests/regression/commits.rs ⇒ page.find("git bisect start
    job=$(sbatch ⇒ needs Slurm ⇒ tests/slurm.rs ⇒ {array}\necho \"$job\"
    sbatch ⇒ needs Slurm ⇒ tests/slurm.rs ⇒ submit[1]
    cargo test --release --test checks -- --ignored ⇒ takes ten minutes; three runs of it are a test ⇒ tests/soak.rs ⇒ the_main_job_three_times_leaves_nothing_behind
    PROPTEST_CASES=20000 ⇒ takes a night ⇒ tests/hostile_bytes.rs ⇒ PROPTEST_CASES=20000 cargo test --release --test checks -- hostile_bytes round_trips
    RUSTC_BOOTSTRAP=1 cargo fuzz ⇒ never ends; its corpus is replayed ⇒ tests/fuzz_corpus.rs ⇒ fuzz/corpus
"#;

/// A test of the commands of each page, and the list of the pages.
macro_rules! pages {
    ($($name:ident: $path:literal),* $(,)?) => {
        const PAGES: &[&str] = &[$($path),*];
        mod commands_of {
            $(#[test] fn $name() { super::commands_do_what_is_printed($path); })*
        }
    };
}

pages! {
    readme: "README.md",
    documents: "docs/README.md",
    architecture: "docs/architecture.md",
    benchmark: "docs/benchmark.md",
    bring_your_own_engine: "docs/bring-your-own-engine.md",
    campaigns: "docs/campaigns.md",
    checks: "docs/checks.md",
    claims: "docs/claims.md",
    continuum: "docs/continuum.md",
    determinism: "docs/determinism.md",
    engine_protocol: "docs/engine-protocol.md",
    explanation: "docs/explanation.md",
    faults: "docs/faults.md",
    field_tests: "docs/field-tests.md",
    hardening: "docs/hardening.md",
    how_to: "docs/how-to.md",
    reference: "docs/reference.md",
    rules: "docs/rules.md",
    run_folder: "docs/run-folder.md",
    sensitivity: "docs/sensitivity.md",
    stability: "docs/stability.md",
    tradeoff: "docs/tradeoff.md",
    tutorial: "docs/tutorial.md",
    verification: "docs/verification.md",
    software_paper: "paper/paper.md",
}

fn text(page: &str) -> String {
    text_of(root(page))
}

/// Every page in a folder and below.
fn pages_in(folder: &str) -> Vec<String> {
    let files = below(&root(folder)).into_iter();
    let names = files.map(|path| {
        let inside = path.strip_prefix(root("")).expect("inside");
        inside.display().to_string()
    });
    names.filter(|name| name.ends_with(".md")).collect()
}

/// As `wc -w` counts.
fn words(pages: &[String]) -> usize {
    let count = |page: &String| text(page).split_whitespace().count();
    pages.iter().map(count).sum()
}

#[test]
fn the_rules_and_the_schema_of_scenes_are_what_the_program_prints() {
    let folder = &new_folder();
    for (verb, page) in [
        ("engine rules", "docs/rules.md"),
        ("scene schema", "docs/scene.schema.json"),
    ] {
        let (printed, _) = ends(folder, 0, verb);
        if std::env::var_os("CROSSGRAIN_KEEP").is_some() {
            fs::write(root(page), &printed).expect("writable");
        }
        assert!(printed == text(page), "CROSSGRAIN_KEEP=1 makes {page} anew");
    }
}

#[test]
fn readme_and_docs_are_short() {
    let readme = words(&["README.md".to_owned()]);
    assert!(readme <= WORDS_OF_README, "README.md has {readme} words");
    // What is made from the code or from records is a table to look things up in.
    let mut pages = pages_in("docs");
    pages.retain(|page| {
        !["docs/rules.md", "docs/faults.md", "docs/field-tests.md"].contains(&page.as_str())
    });
    let docs = words(&pages);
    assert!(docs <= WORDS_OF_DOCS, "docs have {docs} words");
    let paper = words(&[PAPER.to_owned()]);
    assert!(paper <= WORDS_OF_PAPER, "{PAPER} has {paper} words");
}

#[test]
fn every_page_has_a_test_of_its_commands() {
    let mut pages = pages_in("docs");
    pages.extend(["README.md", PAPER].map(str::to_owned));
    pages.sort();
    let mut listed: Vec<_> = PAGES.iter().map(ToString::to_string).collect();
    listed.sort();
    assert_eq!(listed, pages);
}

/// What stands in brackets after a link's text, without the anchor.
fn links(text: &str) -> Vec<String> {
    let ends = text.match_indices("](").map(|(at, _)| &text[at + 2..]);
    let links = ends.filter_map(|rest| rest.split_once(')'));
    links.map(|(link, _)| link.to_owned()).collect()
}

/// The anchors of a page: its headings as GitHub writes them.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |heading: &str| {
        let kept = heading.trim_start_matches('#').trim().chars();
        let kept = kept.filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    };
    headings.map(anchor).collect()
}

/// Links of a page that lead nowhere.
fn broken(page: &str, text: &str) -> Vec<String> {
    let folder = root(page).parent().expect("a folder").to_owned();
    let leads = |link: &String| {
        if link.starts_with("https://") {
            return true;
        }
        let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
        let there = match path {
            "" => root(page),
            _ => folder.join(path),
        };
        let found = || {
            anchors(&text_of(&there))
                .iter()
                .any(|heading| heading == anchor)
        };
        there.exists() && (anchor.is_empty() || found())
    };
    let links = links(text).into_iter();
    links.filter(|link| !leads(link)).collect()
}

/// What the software paper cites stands in its bibliography and the other way round, and its pictures are those that its script
/// makes.
#[test]
fn the_paper_has_its_references_and_pictures() {
    let paper = text(PAPER);
    let bibliography = text("paper/paper.bib");
    let entries = bibliography.lines();
    let entries = entries.filter_map(|line| line.strip_prefix('@')?.split_once('{'));
    let listed: BTreeSet<&str> = entries.map(|(_, key)| key.trim_end_matches(',')).collect();
    // In square brackets or in the running text, as pandoc reads them.
    let other = |letter: char| !letter.is_ascii_alphanumeric();
    let rests = paper.split('@').skip(1);
    let cited: BTreeSet<&str> = rests.filter_map(|rest| rest.split(other).next()).collect();
    assert!(cited.len() > 3, "{cited:?}");
    assert_eq!(cited, listed);
    assert_eq!(bibliography.matches("doi = {10.").count(), listed.len());
    let pictures = links(&paper)
        .into_iter()
        .filter(|link| link.ends_with(".png"));
    let pictures: Vec<String> = pictures.collect();
    assert_eq!(pictures.len(), paper.matches("![").count());
    let script = text("paper/make_figures");
    for picture in pictures {
        let name = picture.trim_end_matches(".png");
        assert!(script.contains(&format!(" {name}:")), "{picture}");
        assert!(root("paper").join(&picture).is_file(), "{picture}");
    }
}

/// Paths of documents that a text names, such as in a message of the program.
fn named_documents(text: &str) -> Vec<String> {
    let rests = text.match_indices("docs/").map(|(at, _)| &text[at..]);
    let name = |rest: &str| -> String {
        let is_of_it = |letter: &char| letter.is_ascii_alphanumeric() || "/-_.".contains(*letter);
        rest.chars().take_while(is_of_it).collect()
    };
    let names = rests.map(|rest| name(rest).trim_end_matches('.').to_owned());
    let is_one = |name: &String| name.ends_with(".md") || name.ends_with(".json");
    names.filter(is_one).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut pages = pages_in("docs");
    let others =
        "README.md CHANGELOG.md reference_data/README.md yade_scripts/README.md paper/paper.md";
    pages.extend(others.words().into_iter().map(str::to_owned));
    for page in pages {
        assert_eq!(broken(&page, &text(&page)), Vec::<String>::new(), "{page}");
    }
    let wrong =
        "[a](docs/nowhere.md) [b](README.md#nothing) [c](https://debian.org) [d](README.md)";
    let lost = ["docs/nowhere.md", "README.md#nothing"];
    assert_eq!(broken("README.md", wrong), lost);
}

#[test]
fn documents_that_the_project_names_exist() {
    let mut files = vec![root("README.md"), root("CHANGELOG.md")];
    let folders = "src crates tests adapters yade_scripts python reference_data docs paper ci";
    for folder in folders.words() {
        files.extend(below(&root(folder)));
    }
    let ends = ["rs", "py", "md", "yml"];
    let end = |file: &PathBuf| file.extension().unwrap_or_default().to_owned();
    files.retain(|file| ends.iter().any(|ending| end(file) == *ending));
    files.retain(|file| !file.ends_with("tests/docs.rs"));
    assert!(files.len() > 200, "{}", files.len());
    for file in files {
        for name in named_documents(&text_of(&file)) {
            assert!(root(&name).exists(), "{} names {name}", file.display());
        }
    }
    let named = named_documents("see docs/a.md, `docs/b/c.json`.");
    assert_eq!(named, ["docs/a.md", "docs/b/c.json"]);
}

/// A command of a page, the exit code that it says, and the lines that it shows.
type Printed = (String, i32, Vec<String>);

fn command_of(line: &str) -> Printed {
    let said = line
        .rsplit_once("# exit code ")
        .map_or("0", |(_, code)| code);
    let code = said.split(|letter: char| !letter.is_ascii_digit()).next();
    let code = code.and_then(|code| code.parse().ok()).expect("a number");
    let command = line.split(" # ").next().unwrap_or(line).trim();
    (command.to_owned(), code, Vec::new())
}

/// The commands of a page. A block without a known mark is an error: nobody would know whether to run it.
fn printed(page: &str, text: &str) -> Vec<Printed> {
    let mut commands: Vec<Printed> = Vec::new();
    let (mut block, mut begun) = (None, String::new());
    for line in text.lines() {
        if let Some(mark) = line.trim_start().strip_prefix("```") {
            block = block.is_none().then_some(mark);
            let known = ["", "sh", "console", "text", "json", "python"].contains(&mark);
            let opens = block.is_some() && mark.is_empty();
            assert!(known && !opens, "{page}: a block of «{mark}»");
            continue;
        }
        let command = match (block, line.strip_prefix("$ ")) {
            (Some("sh"), _) if !line.starts_with('#') && !line.trim().is_empty() => line,
            (Some("console"), Some(command)) => command,
            (Some("console"), None) => {
                let last = commands.last_mut().expect("a command above what it shows");
                last.2.push(line.to_owned());
                continue;
            }
            (Some(mark), _) if mark != "sh" => {
                let hidden = line.contains("crossgrain ");
                assert!(!hidden, "{page}: a command in a block of «{mark}»: {line}");
                continue;
            }
            _ => continue,
        };
        match command.strip_suffix('\\') {
            Some(part) => begun.push_str(part),
            None => commands.push(command_of(&(std::mem::take(&mut begun) + command))),
        }
    }
    commands
}

/// Whether the lines stand in the output in this order, with anything between them and anything for each `…`.
fn shown(output: &str, lines: &[String]) -> Result<(), String> {
    let mut rest = output.lines();
    let squeeze = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    for line in lines.iter().filter(|line| line.trim() != "…") {
        let pattern = squeeze(line);
        let fits = |found: &str| {
            let found = squeeze(found);
            let mut parts = pattern.split('…').map(str::trim);
            let rest = parts.next().and_then(|first| found.strip_prefix(first));
            let end = parts.fold(rest, |rest, part| Some(rest?.split_once(part)?.1));
            end.is_some()
        };
        if !rest.any(fits) {
            return Err(line.clone());
        }
    }
    Ok(())
}

/// With the program on the path, and without YADE.
const AS_A_READER: &str =
    r#"export PATH="${0%/*}:$PATH" CROSSGRAIN_YADE=/nowhere/yade GITHUB_STEP_SUMMARY=summary.md"#;

fn commands_do_what_is_printed(page: &str) {
    let folder = &new_folder();
    for part in ["adapters", "examples", "python", "reference_data"] {
        symlink(root(part), folder.join(part)).expect("writable");
    }
    for (command, code, shows) in printed(page, &text(page)) {
        if rows(ELSEWHERE).any(|[begins, _, _, _]| command.starts_with(begins)) {
            continue;
        }
        let (ended, out, errors) = bash(folder, &format!("{AS_A_READER}\n{command}"), &[]);
        assert_eq!(ended, code, "{page}: {command}\n{out}{errors}");
        if let Err(line) = shown(&out, &shows) {
            panic!("{page}: {command}\ndoes not show\n{line}\nbut\n{out}");
        }
    }
}

#[test]
fn what_is_run_elsewhere_is_run_there() {
    let mut commands = Vec::new();
    for page in PAGES {
        commands.extend(
            printed(page, &text(page))
                .into_iter()
                .map(|printed| printed.0),
        );
    }
    for [begins, why, file, line] in rows(ELSEWHERE) {
        assert!(!why.is_empty());
        let stands = commands.iter().any(|command| command.starts_with(begins));
        assert!(stands, "no page has {begins}");
        assert!(text(file).contains(line), "{file} lacks {line}");
    }
}

/// The commands in the running text, `crossgrain verb … --flag`, where places hold words for what is to be put there.
fn named_commands(text: &str) -> Vec<String> {
    let spans = text.split('`').skip(1).step_by(2);
    let commands = spans.filter(|span| span.starts_with("crossgrain "));
    commands.map(|command| command.replace('\n', " ")).collect()
}

/// The words of a command that its help does not know.
fn unknown<'a>(command: &'a str, helps: &mut BTreeMap<String, Option<String>>) -> Vec<&'a str> {
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let is_verb = |word: &&&str| word.chars().all(|letter| letter.is_ascii_lowercase());
    let verbs: Vec<&str> = words.iter().take_while(is_verb).copied().collect();
    let mut help_of = |verbs: &[&str]| {
        let asked = verbs.join(" ") + " --help";
        let help = helps.entry(asked.clone()).or_insert_with(|| {
            let (code, out, _) = say(&root(""), &asked);
            (code == 0).then_some(out)
        });
        help.clone()
    };
    let found = (1..=verbs.len())
        .rev()
        .find_map(|count| help_of(&verbs[..count]));
    let Some(help) = found else { return verbs };
    let bare = |word: &&'a str| word.trim_matches(|letter: char| "[]|\\,".contains(letter));
    let flags = words.iter().map(bare);
    let flags = flags.filter(|flag| flag.starts_with("--") && flag.len() > 2);
    let known = |flag: &&str| {
        [" ", "\n"]
            .iter()
            .any(|end| help.contains(&format!("{flag}{end}")))
    };
    flags.filter(|flag| !known(flag)).collect()
}

#[test]
fn verbs_and_options_that_are_named_exist() {
    let mut helps = BTreeMap::new();
    let mut named = 0;
    for page in PAGES {
        for command in named_commands(&text(page)) {
            named += 1;
            let unknown = unknown(&command, &mut helps);
            assert!(unknown.is_empty(), "{page}: {command}: {unknown:?}");
        }
    }
    assert!(named > 30, "{named} commands");
    assert_eq!(unknown("crossgrain dance", &mut helps), ["dance"]);
    let hops = "crossgrain run SCENE --hop N --out DIR";
    assert_eq!(unknown(hops, &mut helps), ["--hop"]);
}

#[test]
fn a_page_that_says_something_else_is_noticed() {
    let page =
        "```sh\n# words\na b \\\n  c # exit code 3: no\n```\n\n```console\n$ d\nx … z\n```\n";
    let commands = printed("a page", page);
    let printed_as = |command: &str, code, shows: &[&str]| {
        let shows = shows.iter().map(ToString::to_string).collect();
        (command.to_owned(), code, shows)
    };
    assert_eq!(
        commands,
        [
            printed_as("a b   c", 3, &[]),
            printed_as("d", 0, &["x … z"])
        ]
    );
    let lines = |lines: &[&str]| lines.iter().map(ToString::to_string).collect::<Vec<_>>();
    let output = "one\n  x y   z\nlast";
    for (wanted, missing) in [
        (&["one", "…", "x … z", "last"][..], None),
        (&["last", "one"], Some("one")),
        (&["x … q"], Some("x … q")),
        (&["y z"], Some("y z")),
    ] {
        assert_eq!(shown(output, &lines(wanted)).err().as_deref(), missing);
    }
}
