//! Arguments → one library call → exit code.

use std::process::ExitCode;

use clap::Parser;
use crossgrain::cli::Arguments;

fn main() -> ExitCode {
    match Arguments::parse().execute() {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprintln!("crossgrain: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
