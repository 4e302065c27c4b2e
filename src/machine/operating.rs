//! The condition a machine is in when something is measured or predicted.

/// The operating condition of a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Operating {
    /// Nut position from the left end of its shaft (m). `None` where the machine has no position.
    pub nut_m: Option<f64>,
}

impl Operating {
    /// With the nut at this distance (m) from the left end of its shaft.
    pub fn at_nut(nut_m: f64) -> Self {
        Operating { nut_m: Some(nut_m) }
    }
}
