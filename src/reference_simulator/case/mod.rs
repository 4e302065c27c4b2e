//! Cases of the blind check: published measurements, sealed labels, and their generation.

mod band;
mod choice;
mod fault;
mod fit;
mod gauge;
mod label;
mod layout;
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

pub use label::{Exact, Gap, HammerTest, Label};
pub use layout::{Layout, Quantity};
pub use make::{generate, generate_one};
pub use ordinary::{Ordinary, ordinary};
pub use plan::{Counts, Kind, LOOK_ALIKES, Plan, Slot, Strength};
pub use record::{Case, Position, Record};
pub use write::{labels_json, write_case};

#[cfg(test)]
pub(super) use {
    fit::Fit,
    gauge::Gauge,
    measure::TestRig,
    subject::{Subject, axis},
    survey::Survey,
};
