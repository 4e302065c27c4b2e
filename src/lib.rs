//! Joint parameters of ball-screw feed drives from hammer tests, and the gap between model and machine.

pub mod numeric;
pub mod unit;

pub mod measurement;

pub mod modal;

pub mod contact;

pub mod machine;

pub mod model;

pub mod motion;

pub mod objective;

pub mod inverse_dynamics;

pub mod optimizer;

pub mod diagnosis;
pub mod identification;

pub mod validation;

pub mod report;

pub mod config;

pub mod truth;

pub mod withheld;

pub mod cli;

pub mod guide;
