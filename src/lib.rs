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
//!
//! # Crates
//!
//! One folder of `src` a crate; each may use those above it that its `Cargo.toml` names, and nothing else.
//!
//! | crate | holds | what its boundary gains |
//! |---|---|---|
//! | `numeric` | statistics, laws of probability, linear fits, filters, roots, units | leaf mathematics that knows no machine |
//! | `optimizer` | differential evolution, Levenberg–Marquardt, Gauss–Newton, journals | a search that can know no drive and no data |
//! | `measurement` | sets, FRFs, modes, motion records, universal files, peaks of FRFs | what was observed can know no model |
//! | `machine` | points, shafts, joints, contacts, effects as patches | one description for every model |
//! | `config` | the TOML formats of machines and effects | parsers are built with little optimisation, and only they know the format |
//! | `dynamics` | FRFs and modes, motion, the force a motion needs | physics that cannot know what is fitted |
//! | `identification` | objectives, searches, intervals, validation, fits of motion records | the one way to parameters |
//! | `diagnosis` | effects as hypotheses, nulls, verdicts | an edit here builds neither models nor fits again |
//! | `report` | documents, tables, the page | says results without knowing how they came about |
//! | `reference_simulator` | machines and hammer tests by laws of their own | stands on no other crate: a check of a model against itself proves nothing |
//! | `withheld` | sealed cases, answers, scores | judges by documents alone, as somebody else would |
//! | `cli` | arguments, one file or folder a command, progress, terminal | the only crate that knows all others |

pub use dynamics::{inverse_dynamics, model, motion};
pub use identification::{self, neural_residual, objective, validation};
pub use machine::{self, contact};
pub use measurement::{self, modal};
pub use numeric::{self, unit};
pub use {cli, config, diagnosis, optimizer, reference_simulator, report, withheld};

pub mod guide;
