//! The blind check: cases sealed before anything is scored, answers read, scores counted.
//!
//! ```text
//! seal       digests of generator, case folders and labels; what was changed since is refused by name
//! answer     what a diagnosis says, as a file or as a failure
//! judge      one answer against one label
//! score      proportions over all cases, each with its exact interval
//! document   withheld.json
//! text       the same for a person, with the confusion matrix
//! ```
//!
//! The labels come from `truth`, the answers from the public command line; nothing here knows how either was made.

mod answer;
mod document;
mod judge;
mod score;
mod seal;
mod text;

pub use answer::{
    Answer, ChannelAnswer, ChosenAnswer, DiagnosisAnswer, EffectAnswer, GapAnswer, MotionAnswer, Run, VerdictAnswer, WhereAnswer,
};
pub use document::{CaseRow, SealRow, WithheldDocument};
pub use judge::{Judgement, judge};
pub use score::{Confusion, Proportion, Scores, Spread, scores};
pub use seal::{CASES, FOLLOW_UP, Generator, QUIET, Seal, SealedCase, files_of, folder_digest, label_of};
pub use text::{confusion_text, scores_text};
