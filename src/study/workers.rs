//! Independent pieces of work on every core, with how far they are.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard};

use crate::error::Error;
use crate::interrupt::asked_to_end;
use crate::progress::Display;

/// Does `one` for 0 to `count` − 1, begun in this order, on as many threads as there are cores. The first failure
/// and a signal to end stop it; what has begun is finished first.
pub fn all(
    count: usize,
    name: &str,
    display: &Display,
    one: impl Fn(usize) -> Result<(), Error> + Sync,
) -> Result<(), Error> {
    let task = display.task(name);
    let failure: Mutex<Option<Error>> = Mutex::default();
    let (next, done, stop) = (
        AtomicUsize::new(0),
        AtomicUsize::new(0),
        AtomicBool::new(false),
    );
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count || stop.load(Ordering::Relaxed) || asked_to_end() {
                        return;
                    }
                    if let Err(error) = one(index) {
                        stop.store(true, Ordering::Relaxed);
                        lock(&failure).get_or_insert(error);
                        return;
                    }
                    let finished = done.fetch_add(1, Ordering::Relaxed) + 1;
                    let share = finished as f64 / count as f64;
                    task.share(share, &format!("{finished} of {count}"));
                }
            });
        }
    });
    if asked_to_end() {
        return Err(Error::Interrupted);
    }
    if let Some(error) = lock(&failure).take() {
        return Err(error);
    }
    task.done(&format!("{count} made"));
    Ok(())
}

/// A worker that panicked left nothing half done behind.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    match mutex.lock() {
        Ok(guard) => guard,
        Err(poisoned) => poisoned.into_inner(),
    }
}
