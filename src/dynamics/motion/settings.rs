//! How a motion is simulated.

use machine::Operating;

/// How a motion is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationSettings {
    /// Where the nut stands, for the machine's stiffness and the stroke that is left; motion does not change the stiffness.
    pub operating: Operating,
    /// Lumps per rod.
    pub lumps: usize,
    /// Longest step (s), a whole part of the velocity loop's period; that period where it is absent.
    pub step_s: Option<f64>,
    /// What the parabola of a step may be off, relative to the largest state so far.
    pub tolerance: f64,
    /// Largest |command − position| (m or rad) that is no sign of instability; ten times what the command covers where it is absent.
    pub bound: Option<f64>,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        SimulationSettings { operating: Operating::default(), lumps: 4, step_s: None, tolerance: 1e-7, bound: None }
    }
}
