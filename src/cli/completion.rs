//! Completion by the shell: its script asks this program, since names depend on machine and measurements.

use std::ffi::OsString;
use std::io;

use clap_complete::engine::{ArgValueCandidates, CompletionCandidate};
use clap_complete::env::Shells;
use clap_complete::{CompleteEnv, Shell};

use study::{Sources, Study};

/// Environment variable by which the script of a shell asks.
const ASKED: &str = "JOINTID_COMPLETE";

/// Answers the script of a shell with what may follow its words; whether it asked.
///
/// # Errors  the shell is unknown; stdout cannot be written.
pub fn answered(command: &clap::Command, words: &[OsString]) -> Result<bool, clap::Error> {
    let folder = std::env::current_dir().ok();
    let answer = CompleteEnv::with_factory(|| command.clone()).var(ASKED);
    answer.try_complete(words.iter().cloned(), folder.as_deref())
}

/// Returns the script of a shell that asks the program of this name.
///
/// # Errors  as [`io::Write::write`].
pub fn script(shell: Shell, program: &str) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    let known = Shells::builtins();
    let shell = known.completer(&shell.to_string()).ok_or(io::ErrorKind::Unsupported)?;
    shell.write_registration(ASKED, program, program, program, &mut text)?;
    Ok(text)
}

/// Effects of the library and of the machine on the command line.
pub fn effects() -> ArgValueCandidates {
    ArgValueCandidates::new(|| {
        let all = study::effects(stated("--config").as_deref(), None).map(|all| all.effects);
        let mut all = all.unwrap_or_default();
        all.sort_by(|a, b| a.id.cmp(&b.id));
        all.dedup_by(|a, b| a.id == b.id);
        let of = |id: String, about: String| CompletionCandidate::new(id).help(Some(about.into()));
        all.into_iter().map(|effect| of(effect.id, effect.description)).collect()
    })
}

/// Positions of the measurement set on the command line, or of the embedded one.
pub fn positions() -> ArgValueCandidates {
    ArgValueCandidates::new(|| candidates(false))
}

/// Its positions and records.
pub fn records() -> ArgValueCandidates {
    ArgValueCandidates::new(|| candidates(true))
}

fn candidates(with_records: bool) -> Vec<CompletionCandidate> {
    let sources = Sources {
        config: stated("--config"),
        measurements: stated("--measurements"),
        allow_outside: std::env::args_os().any(|word| word == "--allow-outside"),
        ..Sources::default()
    };
    let study = match stated("--result") {
        Some(path) => Study::open_with_result(&sources, path.as_ref()).map(|(study, ..)| study),
        None => Study::open_machine(&sources),
    };
    let Ok(study) = study else { return Vec::new() };
    let set = study.measurements();
    let mut names: Vec<&String> = set.positions.iter().map(|position| &position.name).collect();
    if with_records {
        names.extend(set.frfs.iter().filter_map(|frf| frf.record.as_ref()));
        names.extend(set.motions.iter().map(|motion| &motion.name));
    }
    names.into_iter().map(CompletionCandidate::new).collect()
}

/// Returns the value of an option of the command line that is completed; shells may pass the sign `=` as a
/// word.
fn stated(option: &str) -> Option<String> {
    let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let mut words = words.filter(|word| word != "=").skip_while(|word| !word.starts_with(option));
    let word = words.next()?;
    word.strip_prefix(option)?.strip_prefix('=').map(str::to_owned).or_else(|| words.next())
}
