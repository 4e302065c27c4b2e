//! One reader under AFL++ (stable Rust; `cargo install cargo-afl --locked && cargo afl config --build` once):
//!
//! ```sh
//! cd tests/fuzz
//! cargo afl build --release
//! cargo afl fuzz -t 1000 -m 500 -x words.dict -i seeds/machine -o /dev/shm/machine target/release/jointid-fuzz machine
//! ```
//!
//! An input of more than 1 s or 500 MB is kept as a hang or crash. What is found goes to `found/READER`, where `tests/readers.rs` reads it
//! in every test run. Readers: see `READERS`.

mod readers;

fn main() {
    let name = std::env::args().nth(1).unwrap_or_default();
    let Some((_, read)) = readers::READERS.iter().find(|(reader, _)| *reader == name) else {
        let names: Vec<&str> = readers::READERS.iter().map(|(reader, _)| *reader).collect();
        eprintln!("name a reader: {}", names.join(", "));
        std::process::exit(2);
    };
    afl::fuzz!(|data: &[u8]| read(data));
}
