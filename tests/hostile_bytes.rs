//! Files of runs and studies with bytes changed at random: every verb that reads them ends, in a known way and within memory.
//!
//! The same cases each time where `PROPTEST_RNG_SEED` is set. A night's worth:
//! `PROPTEST_CASES=20000 cargo test --release --test checks -- hostile_bytes round_trips`; what fails is kept in `proptest-regressions/`.

use std::sync::LazyLock;

use crossgrain::files::sha256_hex;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use crate::readers::parts::packed;
use crate::support::*;

/// What stands in the folder, and a verb that reads it.
const READ: &str = "
    run ⇒ compare run other
    run ⇒ compare other run --expect-bits
    run ⇒ report run run --out o
    run ⇒ report vtk run --out o
    run ⇒ report archive run --out o.tar.gz
    run ⇒ run run/scene.json --engine native --from-state run --out o
    run ⇒ run run/scene.json --engine native --steps 10 --out o
    run ⇒ scene check run/scene.json
    two ⇒ study status two
    two ⇒ study run two --quiet
    two ⇒ study merge two
    two ⇒ study report two
    two ⇒ study compare two two
    two ⇒ study claims two --out o
    two ⇒ report checks two/report.json
    two ⇒ report baseline save two/report.json name --store o
";

/// Words that stand where others are expected.
const WORDS: &str = "-0 -1 1e308 1e-320 NaN inf 18446744073709551616 99999999 0.1 null true \"\" [] {} \u{0} ,, \"\"\"";

#[derive(Debug, Clone)]
enum Change {
    Flip(Index, u8),
    Cut(Index),
    /// A line is left out, or stands twice.
    Line(Index, bool),
    /// A number or word is replaced.
    Word(Index, &'static str),
    /// A part is written over another.
    Splice(Index, Index, u8),
}

impl Change {
    fn make(&self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        match self {
            Change::Flip(at, bit) => {
                let at = at.index(bytes.len());
                bytes[at] ^= 1 << (bit % 8);
            }
            Change::Cut(at) => bytes.truncate(at.index(bytes.len())),
            Change::Line(at, twice) => {
                let mut lines: Vec<&[u8]> = bytes.split_inclusive(|byte| *byte == b'\n').collect();
                let at = at.index(lines.len());
                match twice {
                    true => lines.insert(at, lines[at]),
                    false => drop(lines.remove(at)),
                }
                *bytes = lines.concat();
            }
            Change::Word(at, word) => {
                let is_apart = |byte: &u8| b",: \n[]{}".contains(byte);
                let at = at.index(bytes.len());
                let before = bytes[..at].iter().rposition(is_apart);
                let begin = before.map_or(0, |before| before + 1);
                let after = bytes[at..].iter().position(is_apart);
                let end = after.map_or(bytes.len(), |after| at + after);
                bytes.splice(begin..end.max(begin), word.bytes());
            }
            Change::Splice(from, to, length) => {
                let from = from.index(bytes.len());
                let part = bytes[from..].iter().take(usize::from(*length));
                let part: Vec<u8> = part.copied().collect();
                let to = to.index(bytes.len());
                bytes.splice(to..to, part);
            }
        }
    }
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let index = any::<Index>;
    let word = select(WORDS.split(' ').collect::<Vec<_>>());
    let one = prop_oneof![
        2 => (index(), any::<u8>()).prop_map(|(at, bit)| Change::Flip(at, bit)),
        1 => index().prop_map(Change::Cut),
        1 => (index(), any::<bool>()).prop_map(|(at, twice)| Change::Line(at, twice)),
        4 => (index(), word).prop_map(|(at, word)| Change::Word(at, word)),
        1 => (index(), index(), any::<u8>()).prop_map(|(from, to, length)| Change::Splice(from, to, length)),
    ];
    proptest::collection::vec(one, 1..4)
}

/// A run, another and a study, made once.
static FILES: LazyLock<Place> = LazyLock::new(|| {
    let mut scene = frictional_scene();
    scene.settle.kinetic_energy_fraction = 0.05;
    let place = folder_with(&scene);
    for name in ["run", "other"] {
        let run = format!("run scene.json --engine native --out {name} --steps 2000");
        ends(&place, 0, &run);
    }
    write_scene(&tiny_scene(), &place.join("scene.json"));
    let plan = "study plan campaign scene.json --members 2 --out two";
    ends(&place, 0, plan);
    ends(&place, 0, "study run two --quiet");
    place
});

proptest! {
    #![proptest_config(ProptestConfig { max_shrink_iters: 64, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn whatever_is_changed_every_verb_ends_in_a_known_way(
        verb in any::<Index>(), file in any::<Index>(), changes in changes(), [agrees, packs] in any::<[bool; 2]>()
    ) {
        let verbs: Vec<[&str; 2]> = rows(READ).collect();
        let [folder, verb] = verbs[verb.index(verbs.len())];
        let place = &new_folder();
        let files = FILES.to_str().expect("text");
        prop_assert_eq!(bash(place, "cp -r \"$1\"/* .", &[files]).0, 0);
        let mut files = below(&place.join(folder));
        files.retain(|path| path.is_file() && !path.ends_with("SHA256SUMS"));
        files.sort();
        let path = &files[file.index(files.len())];
        let mut bytes = fs::read(path).expect("readable");
        changes.iter().for_each(|change| change.make(&mut bytes));
        let name = path.file_name().and_then(|name| name.to_str()).expect("text");
        // Whoever can write a folder can write what its files are said to be.
        let sums = place.join(folder).join("SHA256SUMS");
        if agrees && sums.exists() {
            let of_others = text_of(&sums);
            let of_others = of_others.lines().filter(|line| !line.ends_with(name));
            let own = format!("{}  {name}", sha256_hex(&bytes));
            let lines: Vec<&str> = of_others.chain([&*own]).collect();
            fs::write(&sums, lines.join("\n") + "\n").expect("writable");
        }
        fs::write(path, &bytes).expect("writable");
        if packs && name.ends_with(".csv") {
            fs::remove_file(path).expect("removable");
            fs::write(path.with_file_name(format!("{name}.gz")), packed(&bytes)).expect("writable");
        }
        // It is asked to end after a while, and has less than twice the memory that is promised.
        let limited = "ulimit -v 1500000; exec timeout --preserve-status -k 5 30 \"$0\" \"$@\"";
        let (code, said, errors) = bash(place, limited, &verb.words());
        let told = format!("{verb}, {name}: exit code {code}: {errors}{said}");
        prop_assert!(matches!(code, 0..=4 | 75), "{}", told);
        prop_assert!(!errors.contains("panicked"), "{}", told);
        prop_assert!(code == 0 || !(errors.is_empty() && said.is_empty()), "{}", told);
    }
}
