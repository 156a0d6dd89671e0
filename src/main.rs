//! Arguments → one library call → exit code.

use std::process::ExitCode;

use clap::Parser;
use crossgrain::cli::Arguments;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Err(error) = crossgrain::interrupt::notice() {
        eprintln!("crossgrain: signals will not be noticed: {error}");
    }
    match arguments.execute() {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprintln!("crossgrain: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
