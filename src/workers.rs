//! Independent pieces of work on several threads.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};

use crate::interrupt::asked_to_end;

/// Does `one` for each item, begun in this order, on so many threads. The first failure, which is returned, and a signal
/// to end stop it; what has begun is finished first.
pub fn each<T: Send, E: Send>(
    items: impl Iterator<Item = T> + Send,
    threads: usize,
    one: impl Fn(T) -> Result<(), E> + Sync,
) -> Result<(), E> {
    let items = Mutex::new(items);
    let failure: Mutex<Option<E>> = Mutex::new(None);
    let stop = AtomicBool::new(false);
    let worker = || {
        while !stop.load(Ordering::Relaxed) && !asked_to_end() {
            let Some(item) = lock(&items).next() else {
                return;
            };
            if let Err(error) = one(item) {
                stop.store(true, Ordering::Relaxed);
                lock(&failure).get_or_insert(error);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(worker);
        }
    });
    let failure = lock(&failure).take();
    failure.map_or(Ok(()), Err)
}

/// What `one` makes of 0 to `count` − 1, in this order, on every core. The first failure, which is returned, stops it; a
/// signal to end does too, and leaves the last of them away.
pub fn map<T: Send, E: Send>(
    count: usize,
    one: impl Fn(usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let made: Mutex<BTreeMap<usize, T>> = Mutex::default();
    each(0..count, cores().min(count), |index| {
        let of = one(index)?;
        lock(&made).insert(index, of);
        Ok(())
    })?;
    let made = std::mem::take(&mut *lock(&made));
    Ok(made.into_values().collect())
}

/// The machine's cores.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// A worker that panicked left nothing half done behind.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    match mutex.lock() {
        Ok(guard) => guard,
        Err(poisoned) => poisoned.into_inner(),
    }
}
