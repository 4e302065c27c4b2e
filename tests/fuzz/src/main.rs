//! Fuzzes one reader with libFuzzer, whose instrumentation is available in stable Rust. `corpus/READER` keeps
//! the inputs that reached new code:
//!
//! ```sh
//! cd tests/fuzz && mkdir -p corpus/machine
//! RUSTFLAGS="-C passes=sancov-module -C llvm-args=-sanitizer-coverage-level=4 -C llvm-args=-sanitizer-coverage-inline-8bit-counters -C llvm-args=-sanitizer-coverage-pc-table -C llvm-args=-sanitizer-coverage-trace-compares" \
//!     cargo build --release --target "$(rustc --print host-tuple)"
//! READER=machine target/*/release/jointid-fuzz -runs=10000000 -timeout=1 -rss_limit_mb=500 -dict=words.dict corpus/machine seeds/machine
//! ```
//!
//! An input that takes more than 1 s or 500 MB ends the run as a crash does. Store such inputs in
//! `found/READER`: `tests/readers.rs` reads them in every test run. Readers: see `READERS`.

#![no_main]

mod readers;

use std::sync::LazyLock;

/// The reader named by the environment variable `READER`.
static READ: LazyLock<readers::Reader> = LazyLock::new(|| {
    let name = std::env::var("READER").unwrap_or_default();
    let Some((_, read)) = readers::READERS.iter().find(|(reader, _)| *reader == name) else {
        let names: Vec<&str> = readers::READERS.iter().map(|(reader, _)| *reader).collect();
        eprintln!("name a reader, as READER={}", names.join("|"));
        std::process::exit(2);
    };
    *read
});

libfuzzer_sys::fuzz_target!(|data: &[u8]| READ(data));
