//! All integration tests in one binary. A test's name states its authority: `limit_` a closed form or limit, `published_` a printed
//! figure, `recover_` planted truth from another model, `regress_` our own earlier output, `refuse_` bad input.

mod support;

mod architecture;
mod bench;
mod certainty;
mod command;
mod diagnosis;
mod effects;
mod faults;
mod frf;
mod import;
mod inverse_dynamics;
mod inverse_dynamics_command;
mod lumped;
mod lumped_command;
mod model;
mod motion;
mod motion_command;
mod page;
mod peaks;
mod physics;
mod readers;
mod records;
mod recovery;
mod refusals;
mod resume;
mod servo;
mod template;
mod transmission;
mod withheld;
