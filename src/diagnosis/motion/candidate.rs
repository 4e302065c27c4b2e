//! Candidates for motion records, and their figures.

use super::design::CandidateDesign;
use super::free_function::Variable;
use super::grid::LinearParameter;
use crate::{Hypothesis, Status};
use machine::{Machine, ParameterValues};

/// A candidate with a design at each node of its grid.
pub struct MotionCandidate {
    /// Id.
    pub id: String,
    /// Outcome.
    pub status: Status,
    /// The machine with it; `None` for a free function.
    pub hypothesis: Option<Hypothesis>,
    /// For a free function: its variable.
    pub free: Option<Variable>,
    /// For a free function of an extra channel: the name of the channel.
    pub column: Option<String>,
    /// The effect applies, but the machine's own parameters reproduce its influence on these records.
    pub unidentifiable: bool,
    pub(super) nodes: Vec<GridNode>,
}

/// A grid node: values of the nonlinear parameters, and the design there.
pub(super) struct GridNode {
    /// Indices of the nonlinear parameters and their values.
    pub values: Vec<(usize, f64)>,
    /// Parameters of the added columns.
    pub linear: Vec<LinearParameter>,
    pub design: CandidateDesign,
}

/// A candidate at the grid node that fits the recorded force best.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenedFit {
    /// Index of the candidate.
    pub candidate: usize,
    /// Least squared misfit beside the nuisance parameters, with their penalty (N² or N²·m²).
    pub squares: f64,
    /// Squared prediction error of parts that are left out of the fit, summed, with that penalty.
    pub left_out: f64,
    /// Index of the grid node.
    pub(super) node: usize,
    /// Values of the added parameters there.
    pub added: Vec<(usize, f64)>,
}

/// Returns a candidate without a fit.
pub(super) fn without(id: String, status: Status) -> MotionCandidate {
    MotionCandidate {
        id,
        status,
        hypothesis: None,
        free: None,
        column: None,
        unidentifiable: false,
        nodes: Vec::new(),
    }
}

/// Extends values of a machine by the start values of added effects.
pub(super) fn start_of(machine: &Machine, values: &ParameterValues) -> ParameterValues {
    ParameterValues(
        values.iter().copied().chain(machine.parameters.iter().skip(values.len()).map(|p| p.start)).collect(),
    )
}
