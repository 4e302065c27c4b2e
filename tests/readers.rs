//! Every reader on its fuzzing seeds, on every input that made one fail, and on millions of mutated inputs.
//!
//! ```sh
//! JOINTID_STUDY=full cargo test --test main ten_million -- --ignored --nocapture
//! ```
//!
//! mutates seeds without coverage feedback. `tests/fuzz` uses coverage; its corpus in
//! `tests/fuzz/corpus/READER` (not under version control) is mutated as well, if present.

use std::fs;
use std::panic::catch_unwind;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::support::Draws;

#[path = "fuzz/src/readers.rs"]
mod fuzzed;

/// Reads the files of a folder of `tests/fuzz`, sorted by name.
fn files(folder: &str, reader: &str) -> Vec<(String, Vec<u8>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz").join(folder).join(reader);
    let Ok(entries) = fs::read_dir(path) else { return Vec::new() };
    let mut files: Vec<_> = entries
        .map(|e| e.unwrap().path())
        .map(|p| (p.display().to_string(), fs::read(&p).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn regress_inputs_that_broke_a_reader_are_read_or_refused() {
    for (name, read) in fuzzed::READERS {
        // The page is made from the documents.
        let seeds = files("seeds", if name == "page" { "documents" } else { name });
        assert!(!seeds.is_empty(), "{name}");
        for (path, bytes) in seeds.into_iter().chain(files("found", name)) {
            println!("{path}");
            read(&bytes);
        }
    }
}

/// A seed that its reader refuses is useless for fuzzing.
#[test]
fn fuzzing_seeds_are_accepted() {
    for (name, accepts) in fuzzed::ACCEPTANCE {
        for (path, bytes) in files("seeds", name) {
            assert!(accepts(&bytes), "{path}");
        }
    }
}

/// Seeds truncated at every place and with every byte changed, as after an interrupted transfer or a disk
/// error.
#[test]
fn refuse_truncated_and_changed_seeds_without_panic() {
    for (name, read) in fuzzed::READERS.into_iter().filter(|(name, _)| *name != "page") {
        for (_, bytes) in files("seeds", name) {
            let step = 1 + bytes.len() / 400;
            for at in (0..bytes.len()).step_by(step) {
                read(&bytes[..at]);
                for put in [0, b'9', b'-', 0xff] {
                    let mut mutated = bytes.clone();
                    mutated[at] = put;
                    read(&mutated);
                }
            }
        }
    }
}

/// Tokens with a meaning to one of the readers, and numbers at the limits of their types.
const TOKENS: &str = include_str!("fuzz/words.dict");

/// Mutates bytes in up to eight places: removes, inserts or duplicates bits, bytes, numbers, words, lines and
/// parts of another input, or truncates.
fn mutate(bytes: &mut Vec<u8>, other: &[u8], words: &[Vec<u8>], draws: &mut Draws) {
    let mut below = |n: usize| ((draws.next() * n as f64) as usize).min(n.saturating_sub(1));
    for _ in 0..=below(8) {
        let at = below(bytes.len() + 1);
        let to = at + below((bytes.len() - at).min(64) + 1);
        let line = |bytes: &[u8], at: usize| {
            let from = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
            (from, bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |i| at + i + 1))
        };
        match below(12) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(8),
            1 if at < bytes.len() => bytes[at] = below(256) as u8,
            2 => drop(bytes.drain(at..to)),
            3 => {
                let piece = bytes[at..to].to_vec();
                let place = below(bytes.len() + 1);
                bytes.splice(place..place, piece);
            }
            4 | 5 => drop(bytes.splice(at..at, words[below(words.len())].iter().copied())),
            // Replaces a number or a word by a token.
            6 | 7 => {
                let word = |b: &u8| b.is_ascii_alphanumeric() || b"+-._".contains(b);
                let from = bytes[..at].iter().rposition(|b| !word(b)).map_or(0, |i| i + 1);
                let end = bytes[at..].iter().position(|b| !word(b)).map_or(bytes.len(), |i| at + i);
                drop(bytes.splice(from..end, words[below(words.len())].iter().copied()));
            }
            8 => drop(bytes.drain(line(bytes, at).0..line(bytes, at).1)),
            9 => {
                let (from, end) = line(bytes, at);
                let twice = bytes[from..end].to_vec();
                bytes.splice(from..from, twice);
            }
            10 if !other.is_empty() => {
                let from = below(other.len());
                let piece = other[from..from + below((other.len() - from).min(256) + 1)].to_vec();
                bytes.splice(at..to, piece);
            }
            11 if below(8) == 0 => bytes.truncate(at),
            // Nested brackets.
            _ if below(50) == 0 => {
                drop(bytes.splice(at..at, [b'[', b'{', b'('][below(3)..][..1].repeat(1 + below(3000))))
            }
            _ => {}
        }
    }
    bytes.truncate(20_000);
}

/// Mutates seeds `count` times and reads each result. Reports a panic, or a reading time above a second, with
/// the input that causes it.
fn read_mutated(name: &str, count: u64) {
    let (_, read) = fuzzed::READERS.into_iter().find(|(reader, _)| *reader == name).unwrap();
    let begun = Instant::now();
    let words: Vec<Vec<u8>> =
        TOKENS.lines().map(|w| w.trim_matches('"').replace("\\x0A", "\n").into_bytes()).collect();
    let kept = if name == "page" { "documents" } else { name };
    let seeds: Vec<Vec<u8>> =
        ["seeds", "corpus"].iter().flat_map(|folder| files(folder, kept)).map(|f| f.1).collect();
    let next = AtomicU64::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let work = || {
            loop {
                let block = next.fetch_add(1, Ordering::Relaxed);
                if block * 1000 >= count {
                    return;
                }
                let mut draws = Draws(block);
                for at in 0..1000 {
                    let mut pick = || &seeds[(draws.next() * seeds.len() as f64) as usize % seeds.len()];
                    let (mut bytes, other) = (pick().clone(), pick());
                    mutate(&mut bytes, other, &words, &mut draws);
                    // A slow input is slow each time; a single slow reading may be due to a busy machine.
                    let quick = || {
                        let start = Instant::now();
                        catch_unwind(|| read(&bytes)).map(|()| start.elapsed() < Duration::from_secs(1))
                    };
                    let fine = (0..3).map(|_| quick()).find(|read| !matches!(read, Ok(false)));
                    if !matches!(fine, Some(Ok(true))) {
                        let path =
                            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{block}-{at}"));
                        fs::write(&path, &bytes).unwrap();
                        panic!(
                            "{name}: panics or takes more than a second; its input is in {}",
                            path.display()
                        );
                    }
                }
            }
        };
        (0..threads).for_each(|_| drop(scope.spawn(work)));
    });
    let peak = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = peak
        .lines()
        .find(|l| l.starts_with("VmHWM"))
        .unwrap_or("")
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    println!(
        "{name}: {count} inputs mutated from {} seeds in {:.0} s, {peak}",
        seeds.len(),
        begun.elapsed().as_secs_f64()
    );
}

#[test]
fn refuse_thousands_of_mutated_inputs_without_panic() {
    ["machine", "set", "tables", "universal", "documents"]
        .into_iter()
        .for_each(|name| read_mutated(name, 4000));
}

#[test]
#[ignore = "second tier: a hundred thousand inputs of each reader, two million in a study"]
fn ten_million_mutated_inputs() {
    let count = test_data::draws(100_000, 2_000_000);
    ["machine", "set", "tables", "universal", "documents"]
        .into_iter()
        .for_each(|name| read_mutated(name, count));
    read_mutated("page", count / 100);
}
