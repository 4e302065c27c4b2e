//! Diagnoses every case with the public command, as a separate process that receives only the case's folder.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde_json::Value;

use super::arguments::WithheldArguments;
use super::make_cases::Flag;
use crate::outcome::to_message;
use crate::progress::WorkProgress;
use numeric::parallel::OrFirstError;
use report::{OutputFolder, digest, to_json};
use withheld::{Answer, CASES, Run, Seal, SealedCase, files_of};

/// Number of characters kept from the end of a diagnosis' stderr.
const STDERR_CHARACTERS: usize = 2000;

/// Runs the diagnoses of all cases.
pub struct DiagnosisRunner {
    program: PathBuf,
    /// Digest of the program.
    pub program_sha256: String,
    cases: PathBuf,
    kept: PathBuf,
    results: OutputFolder,
    seed: u64,
    ablation: Vec<String>,
    /// Number of diagnoses in parallel.
    pub jobs: usize,
    /// Number of threads of each diagnosis.
    pub threads_each: usize,
    limit: Duration,
}

impl DiagnosisRunner {
    /// Prepares the diagnoses; their results go to `place` inside the folder.
    pub fn new(folder: &Path, place: &Path, seal: &Seal, ablation: &[String], given: &WithheldArguments) -> Result<Self, String> {
        let program = std::env::current_exe().map_err(|e| format!("this program's own file cannot be found: {e}"))?;
        let program_sha256 = digest(&fs::read(&program).map_err(|e| format!("{}: {e}", program.display()))?);
        let kept = folder.join(place).join("diagnoses");
        fs::create_dir_all(&kept).map_err(|e| format!("{}: {e}", kept.display()))?;
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let jobs = given.jobs.map_or(cores, usize::from);
        Ok(Self {
            program,
            program_sha256,
            cases: folder.join(CASES),
            results: OutputFolder::prepare(&kept)?,
            kept,
            seed: seal.generator.seed,
            ablation: ablation.to_vec(),
            jobs,
            threads_each: (cores / jobs).max(1),
            limit: Duration::from_secs(given.time_limit_s.into()),
        })
    }

    /// Diagnoses all cases. Returns the answers; after a stop, those given before it.
    pub fn all(&self, seal: &Seal, stop: &Flag, quiet: bool) -> Result<Vec<(String, Answer)>, String> {
        let progress = WorkProgress::counted(quiet, "diagnose", seal.cases.len());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.jobs).build().map_err(to_message)?;
        let answers: Result<Vec<Option<(String, Answer)>>, String> = pool.install(|| {
            let ask = |case: &SealedCase| -> Result<Option<(String, Answer)>, String> {
                let run = match self.stored(case) {
                    Some(run) => run,
                    None => match self.run(case, stop)? {
                        Some(run) => run,
                        None => return Ok(None),
                    },
                };
                progress.step();
                Ok(Some((case.name.clone(), run.answer(&files_of(&self.cases.join(&case.name))?))))
            };
            // A common queue of single cases, because their times differ widely.
            seal.cases.par_iter().with_max_len(1).map(ask).or_first_error()
        });
        progress.end();
        Ok(answers?.into_iter().flatten().collect())
    }

    fn arguments(&self, case: &SealedCase) -> Vec<String> {
        let mut words = vec!["diagnose".to_string(), "--config".into(), format!("{}/machine.toml", case.name)];
        words.extend(["--measurements".into(), case.name.clone()]);
        if !case.freeze.is_empty() {
            words.extend(["--freeze".into(), case.freeze.join(",")]);
        }
        words.extend(["--seed".into(), self.seed.to_string(), "--json".into()]);
        words.extend(self.ablation.iter().cloned());
        words
    }

    /// Returns a stored run of this program on this case that ended by itself.
    fn stored(&self, case: &SealedCase) -> Option<Run> {
        let text = fs::read_to_string(self.kept.join(format!("{}.json", case.name))).ok()?;
        let run: Run = serde_json::from_str(&text).ok()?;
        let same = run.schema == Run::SCHEMA
            && run.program_sha256 == self.program_sha256
            && run.case_sha256 == case.sha256
            && run.arguments == self.arguments(case)
            && run.exit_code.is_some();
        same.then_some(run)
    }

    /// Runs a diagnosis; `None` if it was stopped.
    fn run(&self, case: &SealedCase, stop: &Flag) -> Result<Option<Run>, String> {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        // Pipes that are not read fill up and block; files do not.
        let [printed, errors] = ["out", "err"].map(|end| self.kept.join(format!(".{}.{}.{end}", case.name, std::process::id())));
        let file = |path: &Path| File::create(path).map_err(|e| format!("{}: {e}", path.display()));
        let begun = Instant::now();
        let mut child = Command::new(&self.program)
            .args(self.arguments(case))
            .current_dir(&self.cases)
            .env("RAYON_NUM_THREADS", self.threads_each.to_string())
            .stdin(Stdio::null())
            .stdout(file(&printed)?)
            .stderr(file(&errors)?)
            .spawn()
            .map_err(|e| format!("{}: cannot be started: {e}", self.program.display()))?;
        let ended = self.wait(&mut child, begun, stop)?;
        let seconds = begun.elapsed().as_secs_f64();
        let text = |path: &Path| fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
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
        self.results.write(&format!("{}.json", case.name), to_json(&run)?.as_bytes())?;
        Ok(Some(run))
    }

    /// Waits for the end. Returns the exit code (none for a signal or the time limit), or `None` if stopped.
    fn wait(&self, child: &mut Child, begun: Instant, stop: &Flag) -> Result<Option<Option<i32>>, String> {
        loop {
            if let Some(status) = child.try_wait().map_err(to_message)? {
                // Ctrl-C reaches both processes; the diagnosis may end before this process sets its flag.
                if status.code() == Some(3) {
                    std::thread::sleep(Duration::from_millis(300));
                }
                return Ok((!stop.load(Ordering::Relaxed)).then_some(status.code()));
            }
            let stopped = stop.load(Ordering::Relaxed);
            if stopped || begun.elapsed() >= self.limit {
                let _ = child.kill();
                child.wait().map_err(to_message)?;
                return Ok((!stopped).then_some(None));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}
