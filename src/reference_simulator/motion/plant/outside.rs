//! What lies outside every list of effects.

/// A lump of grease that gives way a little with every passage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lump {
    /// Where it lies, m.
    pub at_m: f64,
    /// Its half width, m.
    pub width_m: f64,
    /// Its force, N.
    pub force_n: f64,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Outside {
    /// A cable chain pulls the table back, more and more towards one end.
    CableChain {
        /// Largest force, N.
        force_n: f64,
        /// Where it has reached half of it, m.
        at_m: f64,
        /// Over which distance it rises, m.
        width_m: f64,
    },
    /// A body swings under the table.
    Pendulum {
        /// Its mass, kg.
        mass_kg: f64,
        /// Its frequency, rad/s.
        omega_rad_s: f64,
        /// Its damping ratio.
        ratio: f64,
    },
    /// Lumps of grease on the guide; each passage leaves a share of the force.
    Grease {
        /// The lumps.
        lumps: Vec<Lump>,
        /// What a passage leaves.
        left: f64,
    },
    /// The scale's signal is not quite a sine: its reading errs within each period.
    ScaleCogging {
        /// Amplitude, m.
        amplitude_m: f64,
        /// Period, m.
        period_m: f64,
    },
    /// The amplifier gives nothing for small demands.
    DeadZone {
        /// Half width, N.
        force_n: f64,
    },
    /// Friction falls while the oil gets warm.
    RunningIn {
        /// Excess at the start.
        rise: f64,
        /// Time constant, s.
        time_s: f64,
    },
    /// Wipers that creep: a spring behind a dashpot between table and bed.
    WiperCreep {
        /// Stiffness, N/m.
        stiffness_n_m: f64,
        /// Time constant, s.
        time_s: f64,
    },
}
