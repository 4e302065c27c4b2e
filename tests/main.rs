//! All integration tests, in one binary. The prefix of a test's name states the source of the expected
//! result:
//!
//! - `limit_`: a closed form or limiting case,
//! - `published_`: a printed figure,
//! - `recover_`: the known values of an independent model,
//! - `regress_`: an earlier output of this program,
//! - `refuse_`: invalid input, which is refused.

mod support;

mod answers;
mod architecture;
mod basins;
mod bench;
mod certainty;
mod closed_loop;
mod command;
mod contradictions;
mod diagnosis;
mod effects;
mod faults;
mod frf;
mod friction_table;
mod guide;
mod import;
mod inputs;
mod inputs_machine;
mod inverse_dynamics;
mod inverse_dynamics_command;
mod laboratory;
mod lumped;
mod lumped_command;
mod machine_data;
mod machine_files;
mod measuring_chain;
mod model;
mod motion;
mod motion_certainty;
mod motion_command;
mod motion_faults;
mod nested;
mod no_effect;
mod outputs;
mod page;
mod peaks;
mod physics;
mod plan;
mod prediction;
mod readers;
mod records;
mod recovery;
mod refusals;
mod resume;
mod servo;
mod stale_names;
mod study;
mod template;
mod transmission;
mod unstated;
mod wrong_numbers;
