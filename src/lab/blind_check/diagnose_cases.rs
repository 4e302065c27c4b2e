//! Diagnoses every case with the public command, as a separate process that receives only the case's folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use file_access::{MOST_DOCUMENT_BYTES, MOST_TABLE_BYTES, create_exclusive, read_file, read_text};
use rayon::prelude::*;
use serde_json::Value;

use super::request::{BlindCheckRequest, Program};
use crate::withheld::{Answer, CASES, Run, Seal, SealedCase, files_of};
use long_work::Control;
use numeric::parallel::OrFirstError;
use report::{OutputFolder, digest, to_json};
use study::{StudyError, StudyResult};

/// Folder of the answers.
pub(super) const DIAGNOSES: &str = "diagnoses";
/// Number of characters kept from the end of a diagnosis' stderr.
const STDERR_CHARACTERS: usize = 2000;

/// Answers of the diagnoses, before they are scored.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseAnswers {
    /// Answers with the names of their case folders.
    pub(super) answers: Vec<(String, Answer)>,
    /// Digest of the program.
    pub(super) program_sha256: String,
    /// Number of diagnoses in parallel.
    pub(super) jobs: usize,
    /// Number of threads of each diagnosis.
    pub(super) threads_each: usize,
}

/// Returns the file of the facts of a case, beside its answer.
pub(super) fn facts_file(kept: &Path, case: &str) -> PathBuf {
    kept.join(format!("{case}.facts.json"))
}

/// Runs the diagnoses of all cases.
struct DiagnosisRunner<'r> {
    program: &'r Program,
    program_sha256: String,
    cases: PathBuf,
    kept: PathBuf,
    results: OutputFolder,
    seed: u64,
    ablation: &'r [String],
    facts: bool,
    threads_each: usize,
    limit: Duration,
}

/// Diagnoses all cases of a folder with a program, the command `jointid`; results go to `place` inside the
/// folder. After a stop the answers given before it are returned.
///
/// # Errors  the program cannot be run, or a result cannot be written.
pub fn diagnose_cases(
    (folder, place): (&Path, &Path),
    program: &Program,
    seal: &Seal,
    request: &BlindCheckRequest,
    control: &Control,
) -> StudyResult<CaseAnswers> {
    let bytes = read_file(&program.file, MOST_TABLE_BYTES)
        .map_err(|e| StudyError::input(program.file.display(), e.to_string()))?;
    let cases: Vec<&SealedCase> = seal
        .cases
        .iter()
        .filter(|case| request.only.is_empty() || request.only.contains(&case.name))
        .collect();
    if let Some(unknown) = request.only.iter().find(|name| !cases.iter().any(|case| case.name == **name)) {
        return Err(StudyError::setting(
            "case",
            unknown,
            format!("{} has no such case; list its folder {CASES}", folder.display()),
        ));
    }
    let kept = std::path::absolute(folder.join(place).join(DIAGNOSES));
    let kept = kept.map_err(|e| StudyError::input(folder.display(), e.to_string()))?;
    if kept.is_symlink() {
        return Err(StudyError::input(kept.display(), "is a link; remove it"));
    }
    fs::create_dir_all(&kept).map_err(|e| StudyError::input(kept.display(), e.to_string()))?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = request.jobs.unwrap_or(cores);
    let runner = DiagnosisRunner {
        program,
        program_sha256: digest(&bytes),
        cases: folder.join(CASES),
        results: OutputFolder::prepare(&kept)?,
        kept,
        seed: seal.generator.seed,
        ablation: &request.ablation,
        facts: request.facts,
        threads_each: (cores / jobs).max(1),
        limit: Duration::from_secs(request.time_limit_s),
    };
    let step = control.steps("diagnose", cases.len());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
    let pool = pool.map_err(|e| {
        StudyError::impossible(format!("{jobs} threads cannot be started ({e}); ask for fewer jobs"))
    })?;
    let answers = pool.install(|| {
        let ask = |case: &SealedCase| -> StudyResult<Option<(String, Answer)>> {
            let answer = runner.answer(case, control)?;
            if answer.is_some() {
                step();
            }
            Ok(answer.map(|answer| (case.name.clone(), answer)))
        };
        // A common queue of single cases, because their times differ widely.
        cases.par_iter().with_max_len(1).map(|case| ask(case)).or_first_error()
    });
    Ok(CaseAnswers {
        answers: answers?.into_iter().flatten().collect(),
        program_sha256: runner.program_sha256,
        jobs,
        threads_each: runner.threads_each,
    })
}

impl DiagnosisRunner<'_> {
    /// Returns the answer to a case, from a stored run where there is one; `None` if it was stopped.
    fn answer(&self, case: &SealedCase, control: &Control) -> StudyResult<Option<Answer>> {
        let run = match self.stored(case) {
            Some(run) => Some(run),
            None => self.run(case, control)?,
        };
        let Some(run) = run else { return Ok(None) };
        let files = files_of(&self.cases.join(&case.name))?;
        Ok(Some(run.answer(&files)))
    }

    fn arguments(&self, case: &SealedCase) -> Vec<String> {
        let mut words =
            vec!["diagnose".to_string(), "--config".into(), format!("{}/machine.toml", case.name)];
        words.extend(["--measurements".into(), case.name.clone()]);
        if !case.freeze.is_empty() {
            words.extend(["--freeze".into(), case.freeze.join(",")]);
        }
        words.extend(["--seed".into(), self.seed.to_string(), "--json".into()]);
        words.extend(self.ablation.iter().cloned());
        if self.facts {
            let file = facts_file(&self.kept, &case.name).display().to_string();
            words.extend(["--facts".into(), file, "--replace".into()]);
        }
        words
    }

    /// Returns a stored run of this program on this case that ended by itself.
    fn stored(&self, case: &SealedCase) -> Option<Run> {
        let text = read_text(&self.kept.join(format!("{}.json", case.name)), MOST_DOCUMENT_BYTES).ok()?;
        let run: Run = serde_json::from_str(&text).ok()?;
        let same = run.schema == Run::SCHEMA
            && run.program_sha256 == self.program_sha256
            && run.case_sha256 == case.sha256
            && run.arguments == self.arguments(case)
            && run.exit_code.is_some();
        same.then_some(run)
    }

    /// Runs a diagnosis; `None` if it was stopped.
    fn run(&self, case: &SealedCase, control: &Control) -> StudyResult<Option<Run>> {
        if control.stopped() {
            return Ok(None);
        }
        // Pipes that are not read fill up and block; files do not.
        let file = |end: &str| {
            let path = self.kept.join(format!("{}.{end}", case.name));
            create_exclusive(&path).map_err(|e| StudyError::input(path.display(), e.to_string()))
        };
        let ((stdout, printed), (stderr, errors)) = (file("out")?, file("err")?);
        let begun = Instant::now();
        let (name, first) = self
            .program
            .command
            .split_first()
            .ok_or_else(|| StudyError::impossible("the program has no command"))?;
        let mut child = Command::new(name)
            .args(first)
            .args(self.arguments(case))
            .current_dir(&self.cases)
            .env("RAYON_NUM_THREADS", self.threads_each.to_string())
            .stdin(Stdio::null())
            .stdout(stdout)
            .stderr(stderr)
            .spawn()
            .map_err(|e| StudyError::input(self.program.file.display(), format!("cannot be started: {e}")))?;
        let ended = self.wait(&mut child, begun, control)?;
        let seconds = begun.elapsed().as_secs_f64();
        let text = |path: &Path| {
            fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
        };
        let (document, mut words) = (text(&printed), text(&errors));
        let _ = (fs::remove_file(&printed), fs::remove_file(&errors));
        let Some(exit_code) = ended else {
            return Ok(None);
        };
        if exit_code.is_none() && begun.elapsed() >= self.limit {
            words = format!("ended after the limit of {} s", self.limit.as_secs());
        }
        let from = words.char_indices().rev().nth(STDERR_CHARACTERS - 1).map_or(0, |(at, _)| at);
        let run = Run {
            schema: Run::SCHEMA.into(),
            program_sha256: self.program_sha256.clone(),
            case_sha256: case.sha256.clone(),
            arguments: self.arguments(case),
            exit_code,
            seconds,
            said: words[from..].to_string(),
            diagnosis: serde_json::from_str::<Value>(&document).ok(),
        };
        let text = to_json(&run)?;
        self.results.write(&format!("{}.json", case.name), text.as_bytes())?;
        Ok(Some(run))
    }

    /// Waits for the end. Returns the exit code (none for a signal or the time limit), or `None` if stopped.
    fn wait(&self, child: &mut Child, begun: Instant, control: &Control) -> StudyResult<Option<Option<i32>>> {
        loop {
            if let Some(status) = child.try_wait().map_err(StudyError::impossible)? {
                // Ctrl-C reaches both processes; the diagnosis may end before this process sets its flag.
                if status.code() == Some(3) {
                    std::thread::sleep(Duration::from_millis(300));
                }
                return Ok((!control.stopped()).then_some(status.code()));
            }
            let stopped = control.stopped();
            if stopped || begun.elapsed() >= self.limit {
                let _ = child.kill();
                child.wait().map_err(StudyError::impossible)?;
                return Ok((!stopped).then_some(None));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}
