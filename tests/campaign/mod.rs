//! Campaigns as processes: what shards, signals, kills, full disks, damaged files and other processes may not change.

mod damaged;
mod endings;
mod killed;
mod plans;
mod readers;
mod scale;
mod shards;
mod together;

use std::sync::OnceLock;

use crossgrain::files::file_digest;
use crossgrain::study::campaign::{Campaign, Member};
use crossgrain::study::{plan::Plan, realization::Runner, store};

use crate::support::*;

/// A folder that goes away, with a campaign of this name in it.
pub fn plan(scene: &Scene, members: u64, name: &str) -> Place {
    plan_of(scene, Runner::Native, members, name)
}

fn plan_of(scene: &Scene, runner: Runner, members: u64, name: &str) -> Place {
    let place = new_folder();
    let plan = Plan::new(Campaign::new(scene, runner, Vec::new(), members, 1), None);
    plan.and_then(|plan| plan.write(&place.join(name)))
        .expect("a new campaign");
    place
}

/// Digests of `rows.jsonl`, `rows.csv` and `merged.json` of this campaign.
pub fn merged_bytes(folder: &Path) -> [String; 3] {
    let digest = |name| file_digest(&folder.join(name)).expect("a merged campaign");
    ["rows.jsonl", "rows.csv", "merged.json"].map(digest)
}

/// What one process with one thread makes of a campaign of this scene.
pub fn undisturbed(scene: &Scene, members: u64) -> [String; 3] {
    let place = plan(scene, members, "c");
    ends(&place, 0, "study run c --threads 1");
    merged_bytes(&place.join("c"))
}

/// Members of most campaigns here.
const MEMBERS: u64 = 24;

/// [`undisturbed`] for them, made once.
fn expected() -> &'static [String; 3] {
    static EXPECTED: OnceLock<[String; 3]> = OnceLock::new();
    EXPECTED.get_or_init(|| undisturbed(&tiny_scene(), MEMBERS))
}

/// Whole lines of a file; none if there is no file.
pub fn lines(path: &Path) -> usize {
    let bytes = fs::read(path).unwrap_or_default();
    bytes.iter().filter(|byte| **byte == b'\n').count()
}

/// The record file of a shard.
fn records(folder: &Path, shard: &str) -> PathBuf {
    let (index, count) = shard.split_once('/').expect("I/N");
    folder.join(format!("records/shard-{index}-of-{count}.jsonl"))
}

/// The member as a line of the records of the plan with this digest.
pub fn record_line(plan: &str, member: &Member) -> String {
    let json = serde_json::to_string(member).expect("JSON");
    store::line(plan, member.member, &json) + "\n"
}

/// Runs the program on the campaign `c`: exit code, standard output, standard error.
fn campaign(place: &Path, verb: &str, options: &[&str]) -> (i32, String, String) {
    say(place, &[&["study", verb, "c"], options].concat())
}

/// The same of a verb that ends with this exit code: standard output, standard error.
fn study(place: &Path, code: i32, verb: &str, options: &[&str]) -> (String, String) {
    ends(place, code, &[&["study", verb, "c"], options].concat())
}

/// The same with exit code 0, or else.
fn must(place: &Path, verb: &str, options: &[&str]) -> String {
    let (out, errors) = study(place, 0, verb, options);
    out + &errors
}

/// Runs and merges what is left, and compares with the undisturbed campaign.
fn finishes_as_expected(place: &Path) {
    must(place, "run", &["--threads", "2"]);
    assert_eq!(&merged_bytes(&place.join("c")), expected());
}

impl Running {
    fn start(place: &Path, options: &[&str]) -> Self {
        let mut program = cli(place);
        program.args(["study", "run", "c"]).args(options);
        program.stdout(Stdio::piped()).stderr(Stdio::piped());
        Running(program.spawn().expect("the program starts"))
    }

    /// Waits until so many lines are in its file.
    fn wait_for_lines(&mut self, path: &Path, wanted: usize) {
        let began = Instant::now();
        while lines(path) < wanted {
            assert_eq!(self.0.try_wait().expect("a child"), None, "it has ended");
            assert!(began.elapsed() < Duration::from_secs(100), "no members");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// kill -9.
    fn kill(&mut self) {
        assert_eq!(self.0.try_wait().expect("a child"), None, "it has ended");
        self.0.kill().expect("a running child");
        self.0.wait().expect("an ended child");
    }

    /// Waits for its end: exit code, standard error.
    fn end(mut self) -> (i32, String) {
        use std::io::Read;
        let mut errors = String::new();
        if let Some(mut pipe) = self.0.stderr.take() {
            pipe.read_to_string(&mut errors).expect("text");
        }
        let status = self.0.wait().expect("an ended child");
        (status.code().unwrap_or(-1), errors)
    }
}

/// The same numbers every time (splitmix64).
struct Chance(u64);

impl Chance {
    /// Below this bound.
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits ^ (bits >> 31)) % bound
    }
}
