//! Joint parameters of ball-screw feed drives from hammer tests, and the gap between model and machine.
//!
//! The [guide] tells how to use the command. From code, an identification reads a machine and a measurement set, splits the set into what is
//! fitted and what is held out, and searches:
//!
//! ```
//! use jointid::config::read_machine;
//! use jointid::identification::{Plan, identify};
//! use jointid::measurement::read_set;
//! use jointid::optimizer::Control;
//!
//! // Both come with the library; a path of your own is read from disk.
//! let machine = read_machine("configs/tian.toml", &[], &[])?.machine;
//! let set = read_set("measurements/tian")?;
//! let (fit, held_out) = set.split(Some(&["l1", "l3", "l5"].map(String::from)), &[])?;
//!
//! let plan = Plan { repeats: 1, ..Plan::default() };
//! let found = identify(&machine, &fit, &held_out, &plan, &Control::default())?;
//!
//! for estimate in &found.estimates {
//!     let parameter = &machine.parameters[estimate.parameter];
//!     println!("{} = {:.3e} {}, 95 %: {:?}", parameter.id, estimate.value, parameter.unit, estimate.interval95);
//! }
//! let nut = machine.parameters.iter().position(|p| p.id == "k_n").expect("the bench has a nut");
//! assert!((found.values[nut] / 5.59e8 - 1.0).abs() < 0.01);
//!
//! // What was held out is predicted: the four peaks at l2, l4 and l6.
//! assert_eq!(found.held_out.len(), 3);
//! assert_eq!(found.held_out[0].peaks.len(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A step further are [`diagnosis::diagnose`], which looks for what the machine lacks, and [`report::page`], which draws it.

pub use cli;
pub use config;
pub use diagnosis;
pub use dynamics::{inverse_dynamics, model, motion};
pub use identification::{self, network, objective, validation};
pub use machine::{self, contact};
pub use measurement::{self, modal};
pub use numeric::{self, unit};
pub use optimizer;
pub use reference_simulator;
pub use report;
pub use withheld;

pub mod guide;
