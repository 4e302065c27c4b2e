//! Blind check: cases are sealed before scoring, diagnoses are read, scores are counted.
//!
//! ```text
//! seal       digests of generator, case folders and labels; later changes are rejected by file name
//! answer     diagnosis of a case, or the reason of its failure
//! judge      judgement of one answer against one label
//! proportion shares with their exact intervals
//! score      proportions over all cases, each with its exact interval
//! breakdown  scores by size, layout and kind of outside cause
//! document   withheld.json
//! error      broken seals, failed diagnoses
//! page       scores of several checks as a page in Markdown
//! text       scores and confusion matrix as text
//! ```
//!
//! The labels come from the reference simulator, the answers from the public command line. This module
//! depends on neither's internals.

mod answer;
mod breakdown;
mod document;
mod error;
mod judge;
mod page;
mod proportion;
mod score;
mod seal;
mod text;

pub use answer::{
    Answer, ChannelAnswer, ChosenAnswer, DiagnosisAnswer, EffectAnswer, GapAnswer, MotionAnswer, Run,
    VerdictAnswer, WhereAnswer,
};
pub use breakdown::{LayoutScore, OutsideKind, OutsideScore, SingleScore};
pub use document::{CaseRow, SealRow, WithheldDocument};
pub use error::WithheldError;
pub use judge::{Judgement, judge};
pub use page::{PageColumn, scores_page};
pub use proportion::Proportion;
pub use score::{Confusion, Scores, Spread, scores};
pub use seal::{CASES, FOLLOW_UP, Generator, QUIET, Seal, SealedCase, files_of, folder_digest, label_of};
pub use text::{confusion_text, scores_text, withheld_text};
