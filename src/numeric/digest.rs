//! Digests that identify identical byte sequences.

use sha2::{Digest, Sha256};

/// Computes the SHA-256 of bytes, in hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Returns the SHA-256 digest (hexadecimal) of a value as its `Debug` text, which is never held as a whole.
/// Numbers enter with all their digits.
pub fn digest_of(value: &impl std::fmt::Debug) -> String {
    struct Sink(Sha256);
    impl std::fmt::Write for Sink {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.update(text.as_bytes());
            Ok(())
        }
    }
    let mut sink = Sink(Sha256::new());
    // The sink accepts everything.
    let _ = std::fmt::Write::write_fmt(&mut sink, format_args!("{value:?}"));
    sink.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
