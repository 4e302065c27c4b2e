//! The operating condition of a machine during a measurement or prediction.

/// The operating condition of a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Operating {
    /// Nut position from the left end of its shaft (m). `None` where the machine has no position.
    pub nut_m: Option<f64>,
    /// Velocity of the table (m/s); its friction loads nut and bearings. `None`: at rest.
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²), upward positive on a vertical axis; its inertia force loads nut and
    /// bearings. `None`: none.
    pub acceleration_m_s2: Option<f64>,
    /// External axial force (N) on nut and bearings. `None`: none.
    pub force_n: Option<f64>,
    /// Level of the excitation force (N) of hammer or shaker. `None`: not stated.
    pub level_n: Option<f64>,
    /// Decay rate σ of the exponential window of the record (1/s): its receptance is that at the complex
    /// frequency ω − iσ. 0: no window.
    pub window_per_s: f64,
}

/// A variable of the operating condition on which a number may depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OperatingVariable {
    /// Level of the excitation force.
    ForceLevel,
    /// Speed of the table, in either direction.
    Speed,
    /// Acceleration of the table, in either direction.
    Acceleration,
}

impl OperatingVariable {
    /// Returns ln(level/100 N), |velocity|/(1 m/s) or |acceleration|/(10 m/s²); 0 where the variable is not
    /// stated.
    pub fn size(self, operating: &Operating) -> f64 {
        match self {
            OperatingVariable::ForceLevel => {
                operating.level_n.filter(|n| *n > 0.0).map_or(0.0, |n| (n / 100.0).ln())
            }
            OperatingVariable::Speed => operating.velocity_m_s.map_or(0.0, f64::abs),
            OperatingVariable::Acceleration => operating.acceleration_m_s2.map_or(0.0, |a| 0.1 * a.abs()),
        }
    }

    /// Returns the name for messages, with its configuration key.
    pub fn name(self) -> &'static str {
        match self {
            OperatingVariable::ForceLevel => "force level (force_n of an [[frf]])",
            OperatingVariable::Speed => "speed (speed_m_s of an [[frf]])",
            OperatingVariable::Acceleration => "acceleration (acceleration_m_s2 of an [[frf]])",
        }
    }
}

impl Operating {
    /// Returns the condition at rest with the nut at this distance (m) from the left end of its shaft.
    pub fn at_nut(nut_m: f64) -> Self {
        Operating::at(Some(nut_m))
    }

    /// Returns the condition at rest with an optional nut position (m).
    pub fn at(nut_m: Option<f64>) -> Self {
        Operating { nut_m, ..Operating::default() }
    }
}
