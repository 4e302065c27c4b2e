//! Why model and machine disagree: where the gap lies, which effect the description leaves out, how far the gap shrinks once it is in.

mod fit;
mod hypothesis;
mod run;

pub use fit::{Fitted, Fitter, at_start, values_of};
pub use hypothesis::{CHANNEL_SD, Hypothesis, Kind, NUT_SD_M, Shape, interfaces, with_nuisances};
pub use run::{Candidate, Settings, Status, Survey, fitter, gap_over, locate, survey};
