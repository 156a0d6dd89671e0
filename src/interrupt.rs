//! SIGTERM, SIGHUP, Ctrl-C and Ctrl-\: long work notices, cleans up and ends; nothing is half-written. A limit on the size of
//! files is an error of writing, as a full disk is.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

pub use grains::task::asked_to_end;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};

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
