//! Effects outside the library of the diagnosis.

/// A lump of grease whose force decreases with every passage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lump {
    /// Position, m.
    pub at_m: f64,
    /// Half width, m.
    pub width_m: f64,
    /// Force, N.
    pub force_n: f64,
}

/// An effect outside the library of the diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub enum UnlistedEffect {
    /// A cable chain pulls the table back with a force that rises towards one end.
    CableChain {
        /// Largest force, N.
        force_n: f64,
        /// Position of half the largest force, m.
        at_m: f64,
        /// Distance over which the force rises, m.
        width_m: f64,
    },
    /// A body is suspended at the table and swings.
    Pendulum {
        /// Mass of the body, kg.
        mass_kg: f64,
        /// Natural frequency, rad/s.
        omega_rad_s: f64,
        /// Damping ratio.
        ratio: f64,
    },
    /// Lumps of grease on the guide; each passage reduces their force by a constant factor.
    Grease {
        /// The lumps.
        lumps: Vec<Lump>,
        /// Factor on the force for each passage.
        left: f64,
    },
    /// The scale's signal is not exactly a sine, so its reading has a periodic error.
    ScaleCogging {
        /// Amplitude, m.
        amplitude_m: f64,
        /// Period, m.
        period_m: f64,
    },
    /// The amplifier has a dead zone for small demands.
    DeadZone {
        /// Half width, N.
        force_n: f64,
    },
    /// Friction decreases while the oil warms up.
    RunningIn {
        /// Relative excess of friction at the start.
        excess: f64,
        /// Time constant, s.
        time_s: f64,
    },
    /// Wipers creep: a spring in series with a dashpot between table and bed.
    WiperCreep {
        /// Stiffness, N/m.
        stiffness_n_m: f64,
        /// Time constant, s.
        time_s: f64,
    },
}
