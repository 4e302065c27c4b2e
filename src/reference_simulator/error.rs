//! What can go wrong while a case is made.

/// Why a case, or its folder, could not be made.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// The dynamic stiffness had no inverse.
    #[error("the structure has no finite response at {frequency_hz} Hz")]
    Singular {
        /// Frequency of the line.
        frequency_hz: f64,
    },
    /// The structure still rings at the end of the longest block.
    #[error(
        "the response does not decay within {longest_s} s: H1 would be off by {bias:.4} at a resonance and by {leak:.4} over all lines"
    )]
    Ringing {
        /// Longest block tried.
        longest_s: f64,
        /// Largest relative error of H1 at a resonance.
        bias: f64,
        /// Largest root mean square of its relative error over the lines of a record.
        leak: f64,
    },
    /// No admissible size of the effect reaches the non-centrality that was asked for.
    #[error("{effect} reaches a non-centrality of {reached:.2} at most, {wanted:.2} was asked for")]
    TooWeak {
        /// Name of the effect.
        effect: String,
        /// Non-centrality at the largest admissible size.
        reached: f64,
        /// Non-centrality asked for.
        wanted: f64,
    },
    /// Ordinary nuisances leave another share of the noise than a case may have.
    #[error("ordinary nuisances make the gap {ratio:.2} times what noise leaves")]
    Noise {
        /// Gap over its floor.
        ratio: f64,
    },
    /// Every machine drawn for a case was refused.
    #[error("case {index}: none of {attempts} machines drawn could carry it; the last one: {last}")]
    NoMachine {
        /// Number of the case in its plan.
        index: usize,
        /// Machines drawn.
        attempts: usize,
        /// Reason of the last refusal.
        last: String,
    },
    /// The plan has no case of this number.
    #[error("the plan has {count} cases, none of number {index}")]
    NoSuchCase {
        /// Number asked for.
        index: usize,
        /// Cases in the plan.
        count: usize,
    },
    /// A number that no axis, drive or sensor can have.
    #[error("`{key}` is {found}; write {wanted}")]
    Refused {
        /// Its name.
        key: &'static str,
        /// What was found.
        found: f64,
        /// What to write instead.
        wanted: &'static str,
    },
    /// The axis no longer follows its command.
    #[error("the axis runs away {time_s} s after its start: its loops are not stable; lower their gains")]
    Diverged {
        /// When.
        time_s: f64,
    },
    /// A file could not be written.
    #[error("{path}: {source}")]
    Write {
        /// The file.
        path: String,
        /// What the system answered.
        source: std::io::Error,
    },
}
