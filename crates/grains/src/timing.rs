//! What an engine that is timed tells, whichever it is.

use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

/// A moment on the clock of this thread's processor time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreadTime(Duration);

impl ThreadTime {
    /// Now.
    pub fn now() -> Self {
        let now = clock_gettime(ClockId::ThreadCPUTime);
        ThreadTime(Duration::new(now.tv_sec as u64, now.tv_nsec as u32))
    }

    /// Processor time that this thread used between an earlier moment and this one.
    pub fn duration_since(&self, earlier: ThreadTime) -> Duration {
        self.0.saturating_sub(earlier.0)
    }

    /// Processor time that this thread has used since.
    pub fn elapsed(&self) -> Duration {
        ThreadTime::now().duration_since(*self)
    }
}

/// Steps that were timed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// Steps in it.
    pub steps: u64,
    /// Time on the clock, s.
    pub wall_seconds: f64,
    /// Processor time, s; none where the engine tells the clock's only.
    pub cpu_seconds: Option<f64>,
}

impl Window {
    /// Seconds a step: of processor time, which other programs on the machine change least, else on the clock.
    pub fn seconds_per_step(&self) -> f64 {
        self.cpu_seconds.unwrap_or(self.wall_seconds) / self.steps as f64
    }

    /// Processor time over time on the clock; well below 1 where the machine had something else to do.
    pub fn processor_share(&self) -> Option<f64> {
        self.cpu_seconds.map(|cpu| cpu / self.wall_seconds)
    }
}

/// The part of a step's time that a stage of it takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// The stage.
    pub stage: String,
    /// Between 0 and 1.
    pub share: f64,
}
