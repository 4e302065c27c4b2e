//! The condition a machine is in when something is measured or predicted.

/// The operating condition of a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Operating {
    /// Nut position from the left end of its shaft (m). `None` where the machine has no position.
    pub nut_m: Option<f64>,
    /// Velocity of the table (m/s), whose friction loads nut and bearings. `None`: at rest.
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²), whose inertia loads them; upward on an upright axis. `None`: none.
    pub acceleration_m_s2: Option<f64>,
    /// Outside axial force (N) that loads them. `None`: none.
    pub force_n: Option<f64>,
}

impl Operating {
    /// At rest, with the nut at this distance (m) from the left end of its shaft.
    pub fn at_nut(nut_m: f64) -> Self {
        Operating::at(Some(nut_m))
    }

    /// At rest, with the nut there, if anywhere.
    pub fn at(nut_m: Option<f64>) -> Self {
        Operating { nut_m, ..Operating::default() }
    }
}
