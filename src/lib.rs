//! Identifies joint stiffness and damping of ball-screw feed drives from hammer tests, and diagnoses which
//! effect their model lacks.
//!
//! The [guide] explains the command. From code, a [`Study`] holds a machine, its measurements, and what is
//! fitted; it identifies, validates, compares, diagnoses and plans, on modes, FRFs and motion records alike.
//! Results are documents, which serialise as the command's JSON. A set may also be made of arrays
//! ([`MeasurementSet::from_arrays`](measurement::MeasurementSet::from_arrays)); progress, stopping and
//! resuming go through [`Control`].
//!
//! ```
//! use jointid::Study;
//!
//! // Both are built in; any other path is read from disk.
//! let bench = Study::load("configs/tian.toml", "measurements/tian")?;
//! let study = bench.fit(["l1", "l3", "l5"])?;
//! let found = study.identify()?;
//! for (id, row) in &found.parameters {
//!     println!("{id} = {:.3e} {}, 95 %: {:?}", row.value, row.unit, row.interval95);
//! }
//! assert!((found.parameters["k_n"].value / 5.59e8 - 1.0).abs() < 0.01);
//! # Ok::<(), jointid::StudyError>(())
//! ```
//!
//! Taken out of the machine's description, the rotor hold is found again, and a rival that modes alone do not
//! exclude (test `published_bench_without_its_rotor_hold`):
//!
//! ```no_run
//! # let study = jointid::Study::load("configs/tian.toml", "measurements/tian")?.fit(["l1", "l3", "l5"])?;
//! let diagnosis = study.without(["rotor-hold"])?.diagnose()?;
//! println!("{}: {}", diagnosis.verdict.kind, diagnosis.verdict.reason);
//! assert_eq!(diagnosis.verdict.effects, ["rotor-hold", "guide-stiffness"]);
//! # Ok::<(), jointid::StudyError>(())
//! ```

pub mod guide;

#[doc(inline)]
pub use study::{
    Ablation, Control, DiagnosisRequest, Drawing, FactsDocument, MachineConfig, NullCache, ObjectiveKind,
    PlanRequest, PlannedData, PredictionRequest, Progress, RodModel, Settings, Sources, Study, StudyError,
    ValidationRequest, Watcher, compare_results, effects, machine_from_text, read_diagnosis,
    read_identification, read_machine, simulation,
};

/// Result documents, as the command prints them with `--json`.
pub mod document {
    pub use report::certainty::*;
    pub use report::change::*;
    pub use report::diagnosis::*;
    pub use report::document::*;
    pub use report::prediction::*;
    pub use report::record::*;
    pub use report::vocabulary::*;
}

/// Measurement sets: from folders, arrays and files of other programs; peaks of FRFs.
pub mod measurement {
    #[doc(inline)]
    pub use study::{
        DriveEffort, ExportedSet, FrfArrays, ImportRequest, ImportedSet, MeasurementSet, MotionArrays, Peaks,
        PeaksRequest, Quantity, SetArrays, export, import, peaks, read_set,
    };
}
