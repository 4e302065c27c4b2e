//! `jointid lab`: starts the laboratory's program, which lies beside this one, and forwards commands that
//! have moved there.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::outcome::exit_code;
use crate::terminal;

/// The laboratory's package and program.
const PROGRAM: &str = "jointid-lab";

/// Commands that have moved to the laboratory.
const COMMANDS: [&str; 3] = ["withheld", "convergence", "hybrid"];
/// Simulations that have moved there.
const SIMULATIONS: [&str; 6] = ["matrices", "sensitivity", "gain", "circle", "machine", "published"];

/// Returns the words for the laboratory's program, where those of a command line, the name of this program
/// left out, are meant for it.
pub fn requested(words: &[OsString]) -> Option<&[OsString]> {
    let word = |at: usize| words.get(at).and_then(|word| word.to_str()).unwrap_or_default();
    match (word(0), word(1)) {
        ("lab", _) => Some(&words[1..]),
        ("simulate", name) if SIMULATIONS.contains(&name) => Some(&words[1..]),
        // The schema `machine` is that of a machine file, not of the laboratory's records.
        ("schema", "machine") => None,
        ("schema", name) if COMMANDS.iter().chain(&SIMULATIONS).any(|moved| *moved == name) => Some(words),
        (name, _) if COMMANDS.contains(&name) => Some(words),
        _ => None,
    }
}

/// Returns the remark on a former name of a command of the laboratory. `withheld` keeps its name; `--quiet`
/// and `--json` ask for no remarks.
fn remark(words: &[OsString], forwarded: &[OsString]) -> Option<String> {
    let is_silent =
        words.iter().any(|word| ["--quiet", "-q", "--json"].iter().any(|silencing| word == silencing));
    if is_silent || ["lab", "withheld"].iter().any(|kept| words[0] == *kept) {
        return None;
    }
    let line =
        |words: &[OsString]| words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
    Some(format!("write «jointid lab {}»: the old name goes with the next version", line(forwarded)))
}

/// Runs the laboratory's program with the forwarded ones of the words of a command line. Returns its exit
/// code; on Unix it takes the place of this process.
pub fn run(words: &[OsString], forwarded: &[OsString]) -> u8 {
    if let Some(remark) = remark(words, forwarded) {
        terminal::note(&remark);
    }
    start(forwarded).unwrap_or_else(|message| exit_code(Err(message)))
}

/// Runs the laboratory's program. Returns its exit code.
///
/// # Errors  the program is not beside this one, or cannot be started.
fn start(forwarded: &[OsString]) -> Result<u8, String> {
    let own = std::env::current_exe().map_err(|e| format!("this program's own file cannot be found: {e}"))?;
    let mut command = found(&own).ok_or_else(|| {
        format!(
            "the laboratory is a program of its own, {PROGRAM}, which is not beside {}; in a clone of the project, `cargo build --release` builds \
             both, and `cargo install --path src/lab` installs it",
            own.display()
        )
    })?;
    started(command.args(forwarded))
}

/// Returns the laboratory's program: that beside this one, or on the search path for programs; Cargo where it
/// started this one and a build is missing or older than this program.
fn found(own: &Path) -> Option<Command> {
    let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let beside = own.with_file_name(&name);
    let changed = |path: &Path| path.metadata().and_then(|of| of.modified()).ok();
    if changed(&beside) < changed(own)
        && let Some(cargo) = by_cargo(own)
    {
        return Some(cargo);
    }
    let on_path = || {
        std::env::split_paths(&std::env::var_os("PATH")?)
            .map(|folder| folder.join(&name))
            .find(|file| file.is_file())
    };
    let file = if beside.is_file() { Some(beside) } else { on_path() };
    file.map(Command::new)
}

/// Returns the call of Cargo that builds and runs the laboratory's program in the profile of this one, where
/// Cargo started this one in a clone.
fn by_cargo(own: &Path) -> Option<Command> {
    let manifest = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR")?).join("Cargo.toml");
    if !manifest.with_file_name("src").join("lab/Cargo.toml").is_file() {
        return None;
    }
    let mut cargo = Command::new(std::env::var_os("CARGO")?);
    cargo.args(["run", "--quiet", "--package", PROGRAM, "--manifest-path"]).arg(manifest);
    match own.parent()?.file_name()?.to_str()? {
        // The folder of the profile `dev`.
        "debug" => {}
        profile => drop(cargo.args(["--profile", profile])),
    }
    cargo.arg("--");
    Some(cargo)
}

/// Takes the place of this process, so that input, output, exit code and Ctrl-C are the other program's.
#[cfg(unix)]
fn started(command: &mut Command) -> Result<u8, String> {
    let fault = std::os::unix::process::CommandExt::exec(command);
    Err(format!("{}: cannot be started: {fault}", command.get_program().display()))
}

/// Runs the other program, which ends by itself at Ctrl-C.
#[cfg(not(unix))]
fn started(command: &mut Command) -> Result<u8, String> {
    let _ = ctrlc::set_handler(|| {});
    let ended = command
        .status()
        .map_err(|fault| format!("{}: cannot be started: {fault}", command.get_program().display()))?;
    Ok(ended.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(2))
}
