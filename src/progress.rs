//! How far long work is: a bar with the time left on a terminal, a line now and then elsewhere.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::document::harmless;
use crate::workers::lock;
use grains::tables::{Snapshot, Stage};
use grains::task::Observer;

/// Without a terminal, a line so often.
const LINE_EVERY: Duration = Duration::from_secs(15);
/// Bar positions; shares are rounded to this.
const TICKS: u64 = 1000;

/// All work of a command.
#[derive(Debug)]
pub struct Display {
    bars: Option<MultiProgress>,
}

impl Display {
    /// Bars if standard error is a terminal, lines if not, nothing if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let hidden = || MultiProgress::with_draw_target(ProgressDrawTarget::hidden());
        let bars = match quiet {
            true => Some(hidden()),
            false => std::io::stderr().is_terminal().then(MultiProgress::new),
        };
        Display { bars }
    }

    /// A piece of work with a name.
    pub fn task(&self, name: &str) -> Task {
        let bar = self.bars.as_ref().map(|bars| {
            let bar = bars.add(ProgressBar::new(TICKS));
            let style = ProgressStyle::with_template(
                "{prefix:28} {bar:30} {percent:>3} %  {elapsed_precise}, {eta} left  {msg}",
            );
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar.set_prefix(name.to_owned());
            bar.enable_steady_tick(Duration::from_millis(500));
            bar
        });
        Task {
            name: name.to_owned(),
            began: Instant::now(),
            said: Mutex::new((Instant::now(), 0.0)),
            bar,
        }
    }

    /// A line that stays.
    pub fn line(&self, text: &str) {
        match &self.bars {
            // A terminal that is gone loses the line, and nothing else.
            Some(bars) => drop(bars.println(harmless(text))),
            None => say(text),
        }
    }
}

/// One piece of work.
#[derive(Debug)]
pub struct Task {
    name: String,
    began: Instant,
    /// When a line was said, and the largest share so far.
    said: Mutex<(Instant, f64)>,
    bar: Option<ProgressBar>,
}

impl Task {
    /// A run's stage and the share of it that is done; settling takes about three quarters of the whole.
    pub fn run(&self, stage: Stage, step: u64, share: f64) {
        let whole = match stage {
            Stage::Settle => 0.75 * share,
            Stage::Load => 0.75 + 0.25 * share,
        };
        self.share(whole, &format!("{} step {step}", stage.name()));
    }

    /// The share of the work that is done; never goes back.
    pub fn share(&self, share: f64, at: &str) {
        match &self.bar {
            Some(bar) => {
                let position = (share * TICKS as f64) as u64;
                if position > bar.position() {
                    bar.set_position(position.min(TICKS));
                }
                bar.set_message(at.to_owned());
            }
            None => {
                let mut said = lock(&self.said);
                let share = share.max(said.1);
                said.1 = share;
                if said.0.elapsed() >= LINE_EVERY {
                    said.0 = Instant::now();
                    let elapsed = self.began.elapsed().as_secs_f64();
                    let how_far = if share > 0.0 {
                        let left = elapsed * (1.0 / share - 1.0);
                        format!("{:.0} % done, about {left:.0} s left", 100.0 * share)
                    } else {
                        format!("{elapsed:.0} s so far")
                    };
                    say(&format!("{}: {at}, {how_far}", self.name));
                }
            }
        }
    }

    /// The work is done.
    pub fn done(&self, what: &str) {
        match &self.bar {
            Some(bar) => bar.finish_with_message(what.to_owned()),
            None => say(&format!(
                "{}: {what} after {:.1} s",
                self.name,
                self.began.elapsed().as_secs_f64()
            )),
        }
    }
}

/// Shows how far an engine is as the share of a piece of work.
#[derive(Debug)]
pub struct StageObserver<'a>(pub &'a Task);

impl Observer for StageObserver<'_> {
    fn snapshot(&mut self, _: &Snapshot) {}

    fn progress(&mut self, _: Stage, step: u64, share: f64) {
        self.0.share(share, &format!("step {step}"));
    }
}

/// A line on standard error. Where nobody listens any more it is lost, and nothing else.
pub fn say(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{}", harmless(text));
}
