//! Settings of a simulation in time.

use machine::Operating;

/// Settings of a simulation in time.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationSettings {
    /// Position of the nut, for the machine's stiffness and the remaining stroke; the motion does not change
    /// the stiffness.
    pub operating: Operating,
    /// Number of springs per rod.
    pub lumps: usize,
    /// Longest step (s), an integer fraction of the innermost loop's period; `None` for that period.
    pub step_s: Option<f64>,
    /// Largest error of a step's parabola, relative to the largest state so far.
    pub tolerance: f64,
    /// Largest |command − position| (m or rad) of a stable loop; `None` for ten times the range of the
    /// command.
    pub bound: Option<f64>,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        SimulationSettings {
            operating: Operating::default(),
            lumps: 4,
            step_s: None,
            tolerance: 1e-7,
            bound: None,
        }
    }
}
