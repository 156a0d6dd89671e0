//! The machine that the times belong to.

use serde::Serialize;

use crate::files::of_system;

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
        let kernel = |name: &str| text(&format!("/proc/sys/kernel/{name}"));
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
