//! Diagnosis of the discrepancy between model and machine: its location, the effect that the description
//! lacks, and how far including it closes the gap.

mod amplitudes;
mod beside;
mod bootstrap;
mod case;
mod chain_of_records;
mod cross_validation;
mod data_fault;
mod data_kind;
mod diagnose;
mod evidence;
mod facts;
mod fault_rules;
mod finding;
mod fit;
mod gather;
mod held_out_loss;
mod hypothesis;
mod interval;
mod judgement;
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
mod peaks;
mod policy;
mod ranking;
mod record_checks;
mod rules;
mod screening;
mod search;
#[cfg(test)]
mod tests;
mod verdict;
mod wrong_number;

pub use bootstrap::closed_interval;
pub use case::{Chosen, Need};
pub use data_kind::DataKind;
pub use diagnose::{Diagnosis, DiagnosisSettings, TriedEffect, TriedLocation, diagnose};
pub use evidence::{Domain, PartialGap, closed, floor_over, gap_over, gaps_by_mode, share_closed};
pub use facts::{Facts, Model};
pub use fit::{Ablation, Fitted, Fitter, at_start, values_of};
pub use hypothesis::{Hypothesis, HypothesisKind};
pub use judgement::{Judgement, Trial, judge};
pub use model_discrepancy::{sample_discrepancy, sample_prior};
pub use null_distribution::NullDistribution;
pub use peaks::peak_errors;
pub use policy::{EQUIVALENT, Policy};
pub use ranking::Ranked;

pub use screening::{Status, fitter, hypotheses, implausibility, relaxes_within};
pub use verdict::{Verdict, VerdictKind};
pub use wrong_number::{named_numbers, stated_id};
