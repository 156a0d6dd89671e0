//! Exit codes; scripts rely on them.

/// Everything agreed, or was done.
pub const AGREED: u8 = 0;
/// A check failed.
pub const CHECK_FAILED: u8 = 1;
/// The command line, a scene or a run folder cannot be used.
pub const USAGE: u8 = 2;
/// The run or the comparison is incomplete.
pub const INCOMPLETE: u8 = 3;
/// An engine failed.
pub const ENGINE_FAILED: u8 = 4;
/// The surroundings failed (a full disk, no permission to write, a signal to end): try again.
pub const TRY_AGAIN: u8 = 75;
