//! Work on several threads, and its end: at SIGTERM, SIGHUP, Ctrl-C and Ctrl-\ long work notices, cleans up and ends; nothing is
//! half-written. A limit on the size of files is an error of writing, as a full disk is.

pub use grains::task::asked_to_end;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};

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
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on the signals are noticed instead of ending the program at once. A second Ctrl-C does.
pub fn notice() -> std::io::Result<()> {
    let asked = grains::task::flag();
    for signal in [SIGTERM, SIGINT, SIGQUIT, SIGHUP] {
        // Registered first, this ends the program if the flag is set already.
        signal_hook::flag::register_conditional_shutdown(signal, 75, Arc::clone(asked))?;
        signal_hook::flag::register(signal, Arc::clone(asked))?;
    }
    // Unnoticed it would end the program without a word; writing fails all the same.
    let noticed = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::signal::SIGXFSZ, noticed)?;
    Ok(())
}

/// Work that never looks whether it is asked to end, and writes nothing: none if it is, and the work ends with the program.
pub fn unless_asked_to_end<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Option<T> {
    let (send, done) = mpsc::channel();
    let worker = std::thread::spawn(move || send.send(work()));
    loop {
        match done.recv_timeout(Duration::from_millis(50)) {
            Ok(found) => return Some(found),
            Err(RecvTimeoutError::Timeout) if asked_to_end() => return None,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => match worker.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(_) => return None,
            },
        }
    }
}
