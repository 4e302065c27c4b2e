//! Joint parameters of ball-screw feed drives from hammer tests, and the gap between model and machine.

pub mod config;
pub mod identification;
pub mod machine;
pub mod measurement;
pub mod model;
pub mod numeric;
pub mod objective;
pub mod optimizer;
pub mod unit;
