//! Cases of the blind check. A case is one simulated machine, its hammer test, and its hidden cause.
//!
//! The test is published. The cause, an effect or a data fault or none, is kept in a sealed label.
//!
//! - `band`: band that contains most of an effect
//! - `choice`: random choices of a case before its test
//! - `fault`: data faults of a hammer test
//! - `fitted`: strength of an effect as the fitted data show it
//! - `fit`: refit of the description to noise-free data, for the gap that no joint values close
//! - `gauge`: strength of an effect as non-centrality
//! - `imitation`: library effects that imitate an outside cause
//! - `label`: the sealed label
//! - `channel_set`: measured channels and their quantity
//! - `make`: generation of a case and its label from a slot of the plan
//! - `measure`: block length, noise-free curves and records of a test
//! - `ordinary`: machines without effects, within their stated tolerances
//! - `plan`: lists of the cases to generate
//! - `record`: the published part of a case
//! - `size`: sizes of effects, and noise of a test
//! - `strike`: simulated hammer test, as published case and curves for the label
//! - `subject`: the machine under test and its noise-free responses
//! - `survey`: preview of a test on few lines
//! - `write`: files of cases and labels

mod band;
mod channel_set;
mod choice;
mod fault;
mod fit;
mod fitted;
mod gauge;
mod imitation;
mod label;
mod make;
mod measure;
mod ordinary;
mod plan;
mod record;
mod size;
mod strike;
mod subject;
mod survey;
mod write;

pub use channel_set::{ChannelSet, Quantity};
pub use fitted::VISIBLE;
pub use imitation::Imitation;
pub(crate) use label::WrongParameter;
pub use label::{Gap, HammerTest, Label};
pub use make::generate_one;
pub use ordinary::{Ordinary, measured_again, ordinary, ordinary_on_guide};
pub use plan::{Counts, Kind, LOOK_ALIKES, Plan, Slot, Strength};
pub use record::{Case, Position, Record, Scatter};
pub use write::{labels_json, write_case};

#[cfg(test)]
pub(super) use {
    fit::Fit,
    fitted::FittedGauge,
    gauge::Gauge,
    imitation::imitation,
    measure::TestRig,
    subject::{Subject, axis},
    survey::Survey,
};
