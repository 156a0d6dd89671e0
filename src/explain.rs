//! What a check means, how it is computed, where that comes from and what usually breaks it, by the beginning of its id.

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
pub const EXPLANATIONS: [Explanation; 29] = [
    Explanation {
        pattern: "compare/*",
        meaning: "Two runs of one scene agree in what is named last in the id.",
        formula: "Runs that add forces in the same order are held against each other bit by bit, others by the first \
            hundred steps of their engines from four states of a bed: replicas of the native engine with rounding errors show how far \
            rounding takes them.",
        source: "docs/determinism.md; src/compare/",
        breaks: "Any change of an operation or of the order of sums in one of the engines. Read `first difference` in the report: it names the first \
            step, grain and number.",
    },
    Explanation {
        pattern: "compare/*/same-scene",
        meaning: "Both runs were given the same scene, so that their results may be compared at all.",
        formula: "Equal digests (SHA-256) of the canonical JSON of both scenes.",
        source: "docs/run-folder.md; crates/grains/src/scene/",
        breaks: "Comparing folders of different scenes, or a scene file edited between two runs; the keys that differ are listed.",
    },
    Explanation {
        pattern: "compare/*/same-start",
        meaning: "Both runs began with the same grains.",
        formula: "Equal digests of every position, velocity and radius of the cloud.",
        source: "crates/grains/src/generate.rs",
        breaks: "Another realization, or a change of the random numbers or of the cloud.",
    },
    Explanation {
        pattern: "compare/*/same-stages",
        meaning: "Settling and loading took the same numbers of steps and ended for the same reasons.",
        formula: "Steps and reason of each stage, compared as they are.",
        source: "src/engine.rs",
        breaks: "Another stop rule, or a run that has already parted from the other: look at the first difference before this.",
    },
    Explanation {
        pattern: "compare/*/bits-along-the-way",
        meaning: "The whole way is the same, not only its end.",
        formula: "Digests of the bits of every position, velocity and spin at each row of the history.",
        source: "docs/determinism.md; src/compare/bits.rs",
        breaks: "The first row that differs brackets the step at which the engines part; `crossgrain compare` halves it down to one step.",
    },
    Explanation {
        pattern: "compare/*/quantity/*",
        meaning: "A measured quantity is the same in both runs: equal where bits are expected; else it judges nothing.",
        formula: "The key says what is measured: moment (settled, loaded or poured), measure, definition. Each definition is one file with its formula.",
        source: "crates/grains/src/measure/; docs/architecture.md",
        breaks: "If bits differ too, the engines differ: begin with the bits. If bits agree and this does not, the measuring code saw different tables.",
    },
    Explanation {
        pattern: "first-steps/*",
        meaning: "The first hundred steps of an engine from one state of a bed are the native engine's: to the bit, or to rounding.",
        formula: "The largest distance from the native run over that of replicas of it with rounding errors as coarse as the engine's in \
            every step; three times as far is rounding. After 1, 3, 10, 30 and 100 steps.",
        source: "crates/verdict; docs/bring-your-own-engine.md",
        breaks: "A constant or a term of another form in one of the engines; `crossgrain engine check` names it.",
    },
    Explanation {
        pattern: "engine/*",
        meaning: "An engine does a tiny job as the native engine does it: one grain, a wall, a pair, a bed, the rules that end a stage.",
        formula: "Places off by a share of the radius, velocities by a hundred times that share in m/s; those of engine/first-steps are judged as \
            first-steps/*.",
        source: "src/suite/conformance.rs; docs/bring-your-own-engine.md",
        breaks: "The first that fails is to be mended first: the rest may come from it. Where engine/bed alone fails, forces of several contacts are \
            added wrongly, or a contact is found too late or lost.",
    },
    Explanation {
        pattern: "engine/itself/*",
        meaning: "What must be true of any contact law is true of an engine: no reference is asked.",
        formula: "A case is changed (mirrored, renumbered, in other units, …), the answer is changed back and held against the case as it is: to the \
            bit, or to what the engine's own runs from starts with other last digits differ by.",
        source: "crates/verdict/src/invariance.rs; docs/bring-your-own-engine.md",
        breaks: "Each relation tells what usually breaks it. A fault that is the same from everywhere, such as a wrong stiffness, breaks none.",
    },
    Explanation {
        pattern: "conformance/*",
        meaning: "An engine of the conformance table is the model's, to the bit or to rounding; or it differs as it is known to, and in nothing else.",
        formula: "That of first-steps/*, the farthest of all states; what is known to differ is named by the judge and explains all that is seen.",
        source: "src/suite/conformance/table.rs; docs/bring-your-own-engine.md",
        breaks: "Another version of an engine, or a change of its adapter; `crossgrain engine check` says more about one engine.",
    },
    Explanation {
        pattern: "faults/*",
        meaning: "The comparison can fail: a small fault put into the native engine was found.",
        formula: "The scene is poured with and without the fault; the comparison of the two must fail and name the first difference.",
        source: "src/reproduce.rs; crates/grains/src/native/fault.rs",
        breaks: "A comparison that looks at too little, or a fault that changes nothing in this scene (then it is skipped).",
    },
    Explanation {
        pattern: "parameters/*",
        meaning: "Both engines use the same parameter: stiffness, mass, damping, time step.",
        formula: "Each engine is asked what it uses for a few grains that touch each other, a wall and the punch; relative difference at most 1e-14.",
        source: "src/suite/parameters.rs; crossgrain scene parameters",
        breaks: "A formula changed in one engine (k_n, mass, Cundall's α, time step). Everything that is compared later will differ for this reason.",
    },
    Explanation {
        pattern: "verify/*",
        meaning: "A small experiment with a known outcome came out as it must.",
        formula: "Closed forms in continuous time with the error of discretisation as tolerance, or the scheme's own exact solution with \
            rounding as tolerance; the basis of each limit stands beside it.",
        source: "docs/verification.md; src/suite/",
        breaks: "A change of contact law, integrator, damping or walls. `crossgrain verify --detection-limits` says which fault of which size each \
            case detects.",
    },
    Explanation {
        pattern: "paper/*",
        meaning: "A number that the paper prints and that needs no simulation is what it says it is.",
        formula: "Recomputed by a route of our own; it must round to the printed digits. Expected failures are numbers that the paper misprints or \
            computes otherwise, each with the reason.",
        source: "src/paper/; crossgrain paper",
        breaks: "A change of the recomputation. The published numbers do not change.",
    },
    Explanation {
        pattern: "claims/*",
        meaning: "The campaign decides the claim, whichever way: which verdict it has is a finding.",
        formula: "A 90 % interval within the limits holds, one outside does not, and one that holds a limit decides nothing.",
        source: "docs/claims.md; src/study/claims.rs",
        breaks: "Too few members: the interval narrows with the square root of their number.",
    },
    Explanation {
        pattern: "campaigns/*",
        meaning: "Two campaigns of one scene have the same bits, or packings of one kind: a mean differs by no more than its margin.",
        formula: "Bits of the realizations that both have run; else two one-sided tests of the difference of means at 5 %, Welch.",
        source: "docs/tradeoff.md; src/study/campaign/compare.rs",
        breaks: "Engines that differ in more than rounding, or, where it is skipped, too few packings for the margin.",
    },
    Explanation {
        pattern: "*/rows",
        meaning: "No row of a study is missing.",
        formula: "Rows that are there, of those that are planned.",
        source: "docs/campaigns.md; src/study.rs",
        breaks: "A shard that was not run or was ended: `crossgrain study status DIR` names the rows that are missing, and `crossgrain study run DIR` \
            makes them.",
    },
    Explanation {
        pattern: "tradeoff/*",
        meaning: "The fast protocol gives the reference's packings.",
        formula: "Two one-sided t tests at 5 % in every quantity with a margin, with clouds that chose nothing.",
        source: "docs/tradeoff.md; src/study/tradeoff/",
        breaks: "A change of the kernel or of reduced-stiffness deposition. The quantities that are not shown to be equal stand beside it.",
    },
    Explanation {
        pattern: "candidates/*",
        meaning: "Every published figure is decided for a setting: it comes out of it, or it does not.",
        formula: "An interval over packings against the printed value and its tolerance, of a level that counts all settings and figures.",
        source: "src/study/candidates/judge.rs; src/paper/published.rs",
        breaks: "Too few packings: plan the study with more clouds.",
    },
    Explanation {
        pattern: "stability/*",
        meaning: "The largest stable time step of a scene is where the springs and dashpots of its contacts put it.",
        formula: "Found: a bed at rest is disturbed by a millionth of its overlaps, and the step is closed in on where the disturbance begins to grow. \
            Predicted: where the largest eigenvalue of dt²K + 2dtC is 4/(1+α) times the masses. Found over predicted within 3 %.",
        source: "docs/stability.md; src/limits/stability/",
        breaks: "Another stiffness, mass or damping than the prediction reads from the contacts, or another integrator. A damped limit that is some per \
            cent too large has missed the first unstable steps, which are a narrow range.",
    },
    Explanation {
        pattern: "stability/failures/*",
        meaning: "A way in which the method fails was tried, and the program noticed it as it should.",
        formula: "A small scene is run with the fault; it must end with the trouble, or the measured sign of it, that is expected.",
        source: "docs/stability.md; src/limits/stability/failures.rs",
        breaks: "A watch over the run that looks at less than before, or a way to fail that does not fail any more.",
    },
    Explanation {
        pattern: "search/*",
        meaning: "An emulator of the search is as good as it says, so that what it excludes may be believed.",
        formula: "95 % of the means that were run lie within so many times 1.96 deviations of what the emulator expects without their bed.",
        source: "docs/sensitivity.md; src/study/search.rs",
        breaks: "Too few beds for so many choices, or packings whose scatter is estimated from too few: plan the wave with more of both.",
    },
    Explanation {
        pattern: "bench/*",
        meaning: "The benchmark holds costs of engines against each other.",
        formula: "Ratios of times in one run.",
        source: "docs/benchmark.md; src/limits/bench/",
        breaks: "A change of a kernel; another program on the machine.",
    },
    Explanation {
        pattern: "bench/bed/*",
        meaning: "An engine that was timed still has the bed that it was given: one that drops grains or contacts is fast for nothing.",
        formula: "Largest displacement, number of contacts and kinetic energy against native's after the same steps.",
        source: "src/limits/bench/contender.rs; docs/benchmark.md",
        breaks: "An engine that rounds more than it may, a neighbour list that misses contacts, another contact law.",
    },
    Explanation {
        pattern: "bench/bits",
        meaning: "The engine whose speed is shown is the one that has YADE's bits.",
        formula: "Every position and velocity of native and of YADE's sorted loop after the same steps.",
        source: "docs/determinism.md; src/limits/bench/contender.rs",
        breaks: "Optimising the kernel so that an operation or the order of a sum changes.",
    },
    Explanation {
        pattern: "bench/missed/*",
        meaning: "A part of the benchmark was skipped, or failed.",
        formula: "None; the reason stands beside it.",
        source: "docs/benchmark.md",
        breaks: "A program that is not installed (then it is skipped), or that ended with an error (then it fails).",
    },
    Explanation {
        pattern: "baseline/*",
        meaning: "Nothing is worse than in a run that was kept under a name.",
        formula: "Every check is held against the one of the same id: what fails now and did not, or is farther off than it was, is worse; what is gone, \
            no longer made or defined otherwise can no longer be told.",
        source: "docs/checks.md; src/compare/baseline/",
        breaks: "The change that was just made. The checks that it names say what broke; `crossgrain report baseline diff` shows both values of each.",
    },
    Explanation {
        pattern: "baseline/speed/*",
        meaning: "The native engine costs no more than in a run that was kept under a name.",
        formula: "A ratio of times in one run (YADE's over native's) over the same of the baseline; beyond what \
            rounds scatter, on machines of one kind. Without a live YADE the main job has none.",
        source: "docs/checks.md; src/compare/baseline/diff.rs",
        breaks: "A slower kernel, a longer neighbour list, or a busy machine: ratios of one round each are not told apart below a factor of 1.5; \
            `crossgrain bench` has several.",
    },
    Explanation {
        pattern: "run/*",
        meaning: "A check that this job could have and did not make; it counts for nothing.",
        formula: "None; the reason stands beside it.",
        source: "src/reproduce.rs",
        breaks: "YADE missing, another scene than the paper's, or an option such as --full that was not given.",
    },
];

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
                of(id).map(|explanation| explanation.pattern),
                Some(pattern),
                "{id}"
            );
        }
        assert_eq!(of("bake/a"), None);
        assert_eq!(of(""), None);
    }

    #[test]
    fn sources_are_there() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let is_path = |path: &&str| {
            ["src/", "crates/", "docs/"]
                .iter()
                .any(|at| path.starts_with(at))
        };
        for explanation in EXPLANATIONS {
            for path in explanation.source.split("; ").filter(is_path) {
                assert!(root.join(path).exists(), "{}: {path}", explanation.pattern);
            }
        }
    }
}
