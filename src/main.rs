//! Arguments → one library call → exit code.

use std::process::ExitCode;

use crossgrain::cli::Asked;
use crossgrain::progress::say;

fn main() -> ExitCode {
    usable_by_their_maker();
    let arguments = Asked::parse();
    if let Err(error) = crossgrain::workers::notice() {
        say(&format!("crossgrain: signals will not be noticed: {error}"));
    }
    match arguments.execute() {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            say(&format!("crossgrain: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

/// Whatever the umask, whoever makes a file or a folder can use it.
fn usable_by_their_maker() {
    let all = rustix::fs::Mode::RWXU;
    let asked = rustix::process::umask(all);
    rustix::process::umask(asked - all);
}
