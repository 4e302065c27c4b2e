//! Identifies joint stiffness and damping of ball-screw feed drives from hammer tests, and diagnoses which effect their model lacks.
//!
//! The [guide] explains the command. From code, an identification reads a machine and a measurement set, splits the set into fitted and held-out
//! positions, and searches:
//!
//! ```
//! use jointid::config::read_machine;
//! use jointid::identification::{IdentificationSettings, identify};
//! use jointid::measurement::read_set;
//! use jointid::optimizer::Control;
//!
//! // Both are built in; any other path is read from disk.
//! let machine = read_machine("configs/tian.toml", &[], &[])?.machine;
//! let set = read_set("measurements/tian")?;
//! let (fit, held_out) = set.split(Some(&["l1", "l3", "l5"].map(String::from)), &[])?;
//!
//! let settings = IdentificationSettings { repeats: 1, ..IdentificationSettings::default() };
//! let found = identify(&machine, &fit, &held_out, &settings, &Control::default())?;
//!
//! for estimate in &found.estimates {
//!     let parameter = &machine.parameters[estimate.parameter];
//!     println!("{} = {:.3e} {}, 95 %: {:?}", parameter.id, estimate.value, parameter.unit, estimate.interval95);
//! }
//! let nut = machine.parameters.iter().position(|p| p.id == "k_n").expect("the bench has a nut");
//! assert!((found.values[nut] / 5.59e8 - 1.0).abs() < 0.01);
//!
//! // Held-out positions are predicted: four peaks at each of l2, l4 and l6.
//! assert_eq!(found.held_out.len(), 3);
//! assert_eq!(found.held_out[0].peaks.len(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`diagnosis::diagnose`] finds missing effects, and [`report::page`] draws results.
//!
//! # Crates
//!
//! Each folder of `src` is a crate. It may use only the crates that its `Cargo.toml` names, all of them above it in this table.
//!
//! | crate | holds | what its boundary ensures |
//! |---|---|---|
//! | `numeric` | statistics, probability distributions, linear fits, filters, roots, units | leaf mathematics without knowledge of machines |
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
//! | `cli` | arguments, one file or folder a command, progress, terminal | the only crate that knows all others |

pub use dynamics::{inverse_dynamics, model, motion};
pub use identification::{self, neural_residual, objective, validation};
pub use machine::{self, contact};
pub use measurement::{self, modal};
pub use numeric::{self, unit};
pub use {cli, config, diagnosis, optimizer, reference_simulator, report, withheld};

pub mod guide;
