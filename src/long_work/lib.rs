//! Control of long work: progress reports, a stop flag, and a journal from which a stopped or killed run
//! continues.

mod control;
mod journal;

pub use control::{Control, Progress, Watcher};
pub use journal::{Journal, found_in, kept_as};
