//! Arguments → one library call → exit code.

use std::process::ExitCode;

use crossgrain::cli::Asked;
use crossgrain::progress::say;

fn main() -> ExitCode {
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
