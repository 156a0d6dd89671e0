//! Independent pieces of work on several threads.

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
