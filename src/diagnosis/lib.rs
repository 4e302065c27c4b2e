//! Why model and machine disagree: where the gap lies, which effect the description leaves out, how far the gap shrinks once it is in.

mod bootstrap;
mod domain;
mod fit;
mod hypothesis;
mod left_out;
mod limit;
mod model_discrepancy;
pub mod motion;
mod null;
mod peaks;
mod place;
mod plain;
mod plainer;
mod record;
mod run;
mod said;
mod verdict;

pub use bootstrap::closed_interval;
pub use domain::{Compared, Domain, Part, floor_over, gap_over, gaps, gaps_by_mode, share_closed};
pub use fit::{Ablation, Fitted, Fitter, at_start, place_of, values_of};
pub use hypothesis::{Hypothesis, Kind, Shape, interfaces};
pub use left_out::left_out;
pub use model_discrepancy::{sample_discrepancy, sample_prior};
pub use null::{Null, simulate};
pub use peaks::{PeakErrors, peak_errors};
pub use place::Where;
pub use run::{Candidate, Status, Survey, fitter, hypotheses, locate, nominal, nominal_fits, survey, tells};
pub use said::{Verdict, VerdictKind};
pub use verdict::{Diagnosis, Located, Settings, Tried, closed, diagnose};
