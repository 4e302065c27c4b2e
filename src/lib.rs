//! Identifies joint stiffness and damping of ball-screw feed drives from hammer tests, and diagnoses which effect their model lacks.
//!
//! The [guide] explains the command. From code, a [`Study`] holds a machine, its measurements, and what is fitted; it identifies, validates, compares,
//! diagnoses and plans, on modes, FRFs and motion records alike. Results are documents, which serialise as the command's JSON.
//!
//! ```
//! use jointid::Study;
//!
//! // Both are built in; any other path is read from disk.
//! let study = Study::load("configs/tian.toml", "measurements/tian")?.fit(["l1", "l3", "l5"])?;
//! let found = study.identify()?;
//! for (id, parameter) in &found.parameters {
//!     println!("{id} = {:.3e} {}, 95 %: {:?}", parameter.value, parameter.unit, parameter.interval95);
//! }
//! assert!((found.parameters["k_n"].value / 5.59e8 - 1.0).abs() < 0.01);
//!
//! // Taken out of the machine's description, the rotor hold is found again.
//! let diagnosis = study.without(["rotor-hold"])?.diagnose()?;
//! println!("{}: {}", diagnosis.verdict.kind, diagnosis.verdict.reason);
//! assert_eq!(diagnosis.verdict.effects, ["rotor-hold"]);
//! # Ok::<(), jointid::StudyError>(())
//! ```
//!
//! # Crates
//!
//! Each folder of `src` is a crate. It may use only the crates that its `Cargo.toml` names, all of them above it in this table.
//!
//! | crate | holds | what its boundary ensures |
//! |---|---|---|
//! | `numeric` | statistics, probability distributions, linear fits, filters, roots, units | leaf mathematics without knowledge of machines |
//! | `file_access` | bounded reading, creation that follows no link, escaping of hidden characters | files and text from outside are handled in one place |
//! | `optimizer` | differential evolution, Levenberg–Marquardt, Gauss–Newton, journals | searches without knowledge of drives and data |
//! | `measurement` | sets, FRFs, modes, motion records, universal files, peaks of FRFs | observations independent of any model |
//! | `machine` | points, shafts, joints, contacts, effects as patches | one description for every model |
//! | `config` | the TOML formats of machines and effects | only this crate knows the file format; it compiles fast |
//! | `dynamics` | FRFs and modes, motion, inverse dynamics | physics independent of the fit |
//! | `identification` | objectives, searches, intervals, validation, fits of motion records | one path from data to parameters |
//! | `diagnosis` | effects as hypotheses, null simulations, verdicts | edits here rebuild neither models nor fits |
//! | `report` | documents, tables, the page | presents results independently of their computation |
//! | `reference_simulator` | machines and hammer tests by independent laws | uses no other crate: a check of a model against itself proves nothing |
//! | `withheld` | sealed cases, answers, scores | judges from result documents only, like an outsider |
//! | `study` | studies, simulations and imports as one library | what callers use, and all that the command may use |
//! | `cli` | arguments, one file a command, progress, terminal | the command computes nothing |

pub mod guide;

#[doc(inline)]
pub use study::{
    Ablation, Control, DiagnosisRequest, ExportedSet, FrfArrays, ImportRequest, ImportedSet, MachineConfig, MeasurementSet, MotionArrays,
    NullCache, ObjectiveKind, Peaks, PeaksRequest, PlanRequest, PlannedData, Quantity, RodModel, SetArrays, Settings, Sources, Study,
    StudyError, ValidationRequest, effects, export, import, peaks, read_identification, read_machine, read_set, simulation,
};

/// Result documents, as the command prints them with `--json`.
pub mod document {
    pub use report::certainty::*;
    pub use report::diagnosis::*;
    pub use report::document::*;
    pub use report::record::*;
}
