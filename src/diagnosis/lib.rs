//! Diagnosis of the discrepancy between model and machine: its location, the effect that the description
//! lacks, and how far including it closes the gap.

mod amplitudes;
mod bootstrap;
mod chain_of_records;
mod choice;
mod confirmation;
mod cross_validation;
mod data_fault;
mod decision;
mod evidence;
mod fit;
mod further;
mod hypothesis;
mod location;
mod measuring_chain;
mod model_discrepancy;
pub mod motion;
mod multistart;
mod nominal_refit;
mod null_directions;
mod null_distribution;
mod one_machine;
mod one_position;
mod parsimony;
mod peaks;
mod ranking;
mod record_checks;
mod screening;
mod search;
mod thresholds;
mod verdict;

pub use bootstrap::closed_interval;
pub use decision::{Diagnosis, DiagnosisSettings, diagnose};
pub use evidence::{Domain, PartialGap, closed, floor_over, gap_over, gaps_by_mode, share_closed};
pub use fit::{Ablation, Fitted, Fitter, at_start, values_of};
pub use hypothesis::{Hypothesis, HypothesisKind};
pub use model_discrepancy::{sample_discrepancy, sample_prior};
pub use null_distribution::NullDistribution;
pub use peaks::peak_errors;
pub use ranking::EQUIVALENT;
pub use screening::{Status, fitter, hypotheses, is_plausible, largest_loss_factor, relaxes_within};
pub use verdict::{Verdict, VerdictKind};
