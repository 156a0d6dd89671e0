//! The machine that the times belong to, and how far a step is from what it can do: the throughput of divisions, square roots
//! and plain arithmetic in vector lanes and of memory are measured, and multiplied by what a step cannot do without.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use crate::files::of_system;
use grains::native::timing::{OPERATIONS, add_and_multiply, divide, square_root, sum};

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machine {
    /// Model name of the processor, where the system tells.
    pub processor: String,
    /// Processors that this process may use.
    pub processors: usize,
    /// The widest vector unit that the native engine uses here.
    pub vector_unit: String,
    /// Sizes of the caches of the first processor, bytes: first level for data, second, third; 0 where unknown.
    pub caches: [u64; 3],
    /// Memory, bytes; 0 where unknown.
    pub memory: u64,
    /// Kernel and its release.
    pub system: String,
    /// Processes that were waiting for a processor over the last minute, before the benchmark began, where the
    /// system tells.
    pub load: Option<f64>,
}

impl Machine {
    /// What ratios of times depend on besides the programs.
    pub fn kind(&self) -> String {
        format!("{}, {}", self.processor, self.vector_unit)
    }

    pub fn this() -> Self {
        let text =
            |path: &str| String::from_utf8_lossy(&of_system(path).unwrap_or_default()).into_owned();
        let field = |text: &str, key: &str| -> Option<String> {
            let line = text.lines().find(|line| line.starts_with(key))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let kibibytes = |words: &str| -> u64 {
            let digits: String = words.chars().take_while(char::is_ascii_digit).collect();
            let shift = if words.contains('M') { 20 } else { 10 };
            digits.parse::<u64>().map_or(0, |number| number << shift)
        };
        let cache = |index: usize| {
            let folder = format!("/sys/devices/system/cpu/cpu0/cache/index{index}");
            kibibytes(text(&format!("{folder}/size")).trim())
        };
        let memory = field(&text("/proc/meminfo"), "MemTotal");
        let processor = field(&text("/proc/cpuinfo"), "model name");
        let load = text("/proc/loadavg");
        let kernel = |of: &str| text(&format!("/proc/sys/kernel/{of}"));
        Machine {
            processor: processor.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            vector_unit: vector_unit().to_owned(),
            // On Linux index 1 is the first level's cache of instructions.
            caches: [cache(0), cache(2), cache(3)],
            memory: memory.map_or(0, |words| kibibytes(&words)),
            system: format!("{} {}", kernel("ostype").trim(), kernel("osrelease").trim()),
            load: (load.split_whitespace().next()).and_then(|word| word.parse().ok()),
        }
    }
}

/// The widest of the vector units that the native engine is compiled for which this processor has.
pub fn vector_unit() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
        {
            return "AVX-512";
        }
        if is_x86_feature_detected!("avx2") {
            return "AVX2";
        }
    }
    "the plainest of its kind"
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Throughput {
    /// Seconds a division of doubles.
    pub division: f64,
    /// Seconds a square root of a double.
    pub square_root: f64,
    /// Seconds an addition or a multiplication of doubles, half of each, never fused.
    pub arithmetic: f64,
    /// Bytes a second read, from working sets of [`WORKING_SETS`] bytes.
    pub read: Vec<f64>,
}

/// Bytes that are read again and again: what the nearest cache holds, what caches further off hold, and what none does.
pub const WORKING_SETS: [usize; 4] = [16 << 10, 512 << 10, 8 << 20, 256 << 20];

/// What a step must do at least, whatever its program, to have YADE's bits: for each listed pair 2 divisions and a root,
/// as n = (dx/d, dz/d) is asked for; for each grain 2 divisions, as a = f/m is. The native kernel computes each pair twice, once
/// for either grain, and so could at best come within a factor of two of the first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Work {
    pub pairs: f64,
    pub grains: f64,
}

/// dx, dz, d² (3), overlap, force, 2 components, 4 additions to sums.
const ARITHMETIC_A_PAIR: f64 = 13.0;
/// For each axis: + g, the power's sign (3), damping (2), v and x (2 each), the speed squared.
const ARITHMETIC_A_GRAIN: f64 = 22.0;
/// In the rows of both its grains: id, reach and stiffness.
const BYTES_A_PAIR: f64 = 2.0 * 20.0;
/// Position (for forces and to be advanced), velocity, force and mass of both components read; position, velocity and
/// force written.
const BYTES_A_GRAIN: f64 = 80.0 + 48.0;

/// The time that a step takes at least if one resource alone counted, s.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bound {
    pub resource: String,
    pub seconds: f64,
    /// The measured time over it.
    pub distance: f64,
}

impl Work {
    pub fn bytes(&self) -> f64 {
        self.pairs * BYTES_A_PAIR + self.grains * BYTES_A_GRAIN
    }

    /// The bounds of a step that takes `measured` seconds, where a working set of its size is read at `read_rate`
    /// bytes a second; the nearest first.
    pub fn bounds(&self, of: &Throughput, read_rate: f64, measured: f64) -> Vec<Bound> {
        let Work { pairs, grains } = *self;
        let divisions = (2.0 * pairs + 2.0 * grains) * of.division + pairs * of.square_root;
        let arithmetic = (ARITHMETIC_A_PAIR * pairs + ARITHMETIC_A_GRAIN * grains) * of.arithmetic;
        let bound = |resource: &str, seconds: f64| Bound {
            resource: resource.to_owned(),
            seconds,
            distance: measured / seconds,
        };
        let mut bounds = vec![
            bound("divisions and square roots", divisions),
            bound("other arithmetic", arithmetic),
            bound("memory", self.bytes() / read_rate),
        ];
        bounds.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        bounds
    }
}

impl Throughput {
    /// Measures this machine; about a second.
    pub fn measure() -> Self {
        let numbers: Vec<f64> = (0..1024).map(|index| 1.0 + f64::from(index)).collect();
        let mut out = vec![0.0; numbers.len()];
        let mut per_number = |work: fn(&[f64], &mut [f64])| {
            let best = fastest(|| {
                for _ in 0..64 {
                    work(black_box(&numbers), black_box(&mut out));
                }
            });
            best / (64 * numbers.len()) as f64
        };
        let division = per_number(divide);
        let square_root = per_number(square_root);
        let arithmetic = per_number(add_and_multiply) / OPERATIONS as f64;
        Throughput {
            division,
            square_root,
            arithmetic,
            read: WORKING_SETS.map(read_rate).to_vec(),
        }
    }
}

/// Bytes a second read from a working set of so many bytes.
pub fn read_rate(bytes: usize) -> f64 {
    let words = vec![1.0; (bytes / 8).max(64)];
    let times = ((20 << 20) / bytes.max(1)).max(1);
    let best = fastest(|| {
        for _ in 0..times {
            black_box(sum(black_box(&words)));
        }
    });
    (times * bytes) as f64 / best
}

/// The shortest of some times, s: what the machine can do when nothing disturbs it.
fn fastest(mut work: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..15 {
        let began = Instant::now();
        work();
        best = best.min(began.elapsed().as_secs_f64());
    }
    best
}
