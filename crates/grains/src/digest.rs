//! SHA-256 in hexadecimal.

use sha2::{Digest, Sha256};

/// SHA-256 of these bytes.
pub fn sha256_hex(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// The first 64 bits of a running SHA-256.
pub fn short_hex(hash: Sha256) -> String {
    hex(&hash.finalize()[..8])
}

/// Two digits a byte.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
