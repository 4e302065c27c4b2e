//! Digests that identify identical byte sequences.

use sha2::{Digest, Sha256};

/// Computes the SHA-256 of bytes, in hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}
