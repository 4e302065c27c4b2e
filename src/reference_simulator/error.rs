//! Errors of case generation.

/// Result of case generation.
pub type Result<T> = std::result::Result<T, SimulatorError>;

/// Reason for which a case, or its folder, cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SimulatorError {
    /// The dynamic stiffness is singular.
    #[error("the structure has no finite response at {frequency_hz} Hz")]
    Singular {
        /// Frequency of the line, Hz.
        frequency_hz: f64,
    },
    /// The structure still rings at the end of the longest block.
    #[error(
        "the response does not decay within {longest_s} s: the relative error of H1 is {bias:.4} at a resonance and {leak:.4} rms over all lines"
    )]
    Ringing {
        /// Longest block tried, s.
        longest_s: f64,
        /// Largest relative error of H1 at a resonance.
        bias: f64,
        /// Largest root mean square of its relative error over the lines of a record.
        leak: f64,
    },
    /// No admissible size of the effect reaches the requested non-centrality.
    #[error("{effect} reaches a non-centrality of {reached:.2} at most; {wanted:.2} is requested")]
    TooWeak {
        /// Name of the effect.
        effect: String,
        /// Non-centrality at the largest admissible size.
        reached: f64,
        /// Requested non-centrality.
        wanted: f64,
    },
    /// The gap caused by the nuisance parameters has an inadmissible ratio to the noise floor.
    #[error("with the nuisance parameters the gap is {ratio:.2} times the noise floor")]
    Noise {
        /// Gap over its noise floor.
        ratio: f64,
    },
    /// The plan asks for an effect that the layout cannot have.
    #[error("case {index}: {effect} cannot be missing from the description of layout {layout}: {reason}")]
    NotOnLayout {
        /// Number of the case in its plan.
        index: usize,
        /// Name of the effect.
        effect: &'static str,
        /// Name of the layout.
        layout: &'static str,
        /// Reason.
        reason: &'static str,
    },
    /// No machine drawn for a case is admissible.
    #[error("case {index}: none of {attempts} machines drawn is admissible; last reason: {last}")]
    NoMachine {
        /// Number of the case in its plan.
        index: usize,
        /// Machines drawn.
        attempts: usize,
        /// Reason of the last rejection.
        last: String,
    },
    /// The plan has no case of this number.
    #[error("case {index} does not exist: the plan has {count} cases, numbered from 0")]
    NoSuchCase {
        /// Requested number.
        index: usize,
        /// Cases in the plan.
        count: usize,
    },
    /// A value is outside its admissible range.
    #[error("`{key}` is {found}; write {wanted}")]
    Refused {
        /// Name of the value.
        key: &'static str,
        /// Value found.
        found: f64,
        /// Description of the admissible values.
        wanted: &'static str,
    },
    /// The axis no longer follows its command.
    #[error("the axis diverges {time_s} s after its start: its loops are unstable; lower their gains")]
    Diverged {
        /// Time of the divergence, s.
        time_s: f64,
    },
    /// A file could not be written.
    #[error("{path}: {source}")]
    Write {
        /// The file.
        path: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
}
