//! Parameters of the axis.

use std::f64::consts::TAU;

use super::friction::Friction;
use super::missing::Missing;
use crate::{Result, SimulatorError};

/// Pairs fields with their names.
macro_rules! with_names {
    ($($of:ident.$field:ident $([$at:literal])?),*) => { [$((stringify!($field), $of.$field$([$at])?)),*] };
}
pub(super) use with_names;

/// Gains and times of the cascade. Current and velocity loops are digital PI, u = k (e + T/T_i Σe); the
/// position loop is P.
#[derive(Clone, Debug, PartialEq)]
pub struct Loops {
    /// Gain of the current loop, V/A.
    pub current_gain_v_a: f64,
    /// Integral time of the current loop, s.
    pub current_time_s: f64,
    /// Gain of the velocity loop, A·s/rad.
    pub velocity_gain_a_s_rad: f64,
    /// Integral time of the velocity loop, s.
    pub velocity_time_s: f64,
    /// Gain of the position loop, 1/s.
    pub position_gain_1_s: f64,
    /// Gain of the velocity feed-forward; 1 feeds the full command speed forward.
    pub feed_forward: f64,
    /// Velocity periods over which the encoder's difference is taken. A larger number reduces noise and adds
    /// delay.
    pub speed_periods: usize,
}

/// Parameters of an axis that an engineer knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Nominal {
    /// Pole pairs of the motor.
    pub pole_pairs: f64,
    /// Resistance of a phase, Ω.
    pub resistance_ohm: f64,
    /// Inductances along d and q, H.
    pub inductance_h: [f64; 2],
    /// Torque per ampere of i_q (amplitude of the phase current), N·m/A.
    pub torque_constant_nm_a: f64,
    /// Voltage of the DC link, V.
    pub link_v: f64,
    /// Largest i_q demanded, A: three times the nominal current's amplitude.
    pub current_limit_a: f64,
    /// Inertia of the rotor, kg·m².
    pub rotor_kg_m2: f64,
    /// Inertia of the coupling, kg·m²: one half turns with the rotor, the other half with the screw.
    pub coupling_kg_m2: f64,
    /// Inertia of the screw, kg·m².
    pub screw_kg_m2: f64,
    /// Lead of the screw, m per revolution.
    pub lead_m: f64,
    /// Mass of the table, kg.
    pub table_kg: f64,
    /// Torsional stiffness between motor and screw, N·m/rad.
    pub torsion_nm_rad: f64,
    /// Torsional damping between motor and screw, N·m·s/rad.
    pub torsion_nm_s_rad: f64,
    /// Axial stiffness at the nut, N/m.
    pub axial_n_m: f64,
    /// Damping of the nut in full contact, N·s/m.
    pub axial_n_s_m: f64,
    /// Backlash of the nut from flank to flank, m.
    pub backlash_m: f64,
    /// Friction of the table.
    pub table_friction: Friction,
    /// Friction of the screw, reduced to the travel: its torque is this force times lead/2π.
    pub screw_friction: Friction,
    /// Loops of the drive.
    pub loops: Loops,
}

impl Nominal {
    /// Returns the first axis, x, with a table of 150 kg.
    pub fn x() -> Self {
        Self::with_table(150.0)
    }

    /// Returns the second axis, y, which carries the first: 1.4 times the table mass, a velocity gain to
    /// match, all else equal.
    pub fn y() -> Self {
        Self::with_table(1.4 * 150.0)
    }

    fn with_table(table_kg: f64) -> Self {
        let inductance = 2.3e-3;
        let mut nominal = Self {
            pole_pairs: 4.0,
            resistance_ohm: 0.184,
            inductance_h: [inductance; 2],
            torque_constant_nm_a: 1.018,
            link_v: 560.0,
            current_limit_a: 53.0,
            rotor_kg_m2: 5.3e-3,
            coupling_kg_m2: 0.5e-3,
            screw_kg_m2: 1.973e-3,
            lead_m: 0.016,
            table_kg,
            torsion_nm_rad: 1.54e4,
            torsion_nm_s_rad: 0.2,
            axial_n_m: 1.474e8,
            axial_n_s_m: 6000.0,
            backlash_m: 17e-6,
            table_friction: Friction {
                coulomb_n: 150.0,
                excess_n: 60.0,
                stribeck_m_s: 0.01,
                viscous_n_s_m: 800.0,
            },
            screw_friction: Friction::none(),
            loops: Loops {
                current_gain_v_a: 5000.0 * inductance,
                current_time_s: 9.8e-3,
                velocity_gain_a_s_rad: 0.0,
                velocity_time_s: 40e-3,
                position_gain_1_s: 120.0,
                feed_forward: 0.0,
                speed_periods: 1,
            },
        };
        nominal.loops.velocity_gain_a_s_rad = 800.0 * nominal.inertia_kg_m2() / nominal.torque_constant_nm_a;
        nominal
    }

    /// Returns the travel for one radian, m.
    pub fn ratio_m(&self) -> f64 {
        self.lead_m / TAU
    }

    /// Returns the inertias of the two shafts, rotor and screw, each with half of the coupling, kg·m².
    pub fn shafts_kg_m2(&self) -> [f64; 2] {
        [self.rotor_kg_m2, self.screw_kg_m2].map(|own| own + 0.5 * self.coupling_kg_m2)
    }

    /// Returns the inertia of all moving parts at the motor, kg·m².
    pub fn inertia_kg_m2(&self) -> f64 {
        self.shafts_kg_m2().iter().sum::<f64>() + self.table_kg * self.ratio_m().powi(2)
    }

    /// Returns the flux linkage of the magnets, Wb: torque constant over 3/2 of the pole pairs.
    pub fn flux_wb(&self) -> f64 {
        self.torque_constant_nm_a / (1.5 * self.pole_pairs)
    }

    /// Returns the largest voltage amplitude of space-vector modulation, V: link/√3.
    pub fn voltage_limit_v(&self) -> f64 {
        self.link_v / 3f64.sqrt()
    }
}

/// A complete axis: known parameters and effects that the analytical model lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Known parameters.
    pub nominal: Nominal,
    /// Effects that only the simulator has.
    pub missing: Missing,
}

impl Axis {
    /// Returns the first axis with all missing effects at their usual size.
    pub fn x() -> Self {
        Self { nominal: Nominal::x(), missing: Missing::default() }
    }

    /// Returns the second axis: as the first, with other phases of lead error and cogging.
    pub fn y() -> Self {
        let missing = Missing { lead_phase_rad: 3.9, ripple_phase_rad: [5.2, 0.3], ..Missing::default() };
        Self { nominal: Nominal::y(), missing }
    }

    /// Returns the moved mass: that of the table and the one on it, kg.
    pub(super) fn table_kg(&self) -> f64 {
        self.nominal.table_kg + self.missing.extra_kg
    }

    /// Checks that every parameter is admissible.
    ///
    /// # Errors     `SimulatorError::Refused` names the first inadmissible parameter.
    pub fn check(&self) -> Result<()> {
        let (n, l, m) = (&self.nominal, &self.nominal.loops, &self.missing);
        let (table, screw) = (&n.table_friction, &n.screw_friction);
        let positive = with_names! {
            n.pole_pairs, n.inductance_h[0], n.inductance_h[1], n.torque_constant_nm_a, n.link_v, n.current_limit_a, n.rotor_kg_m2,
            n.screw_kg_m2, n.lead_m, n.table_kg, n.torsion_nm_rad, n.axial_n_m, table.stribeck_m_s, screw.stribeck_m_s, l.current_time_s,
            l.velocity_time_s
        };
        let not_negative = with_names! {
            n.resistance_ohm, n.coupling_kg_m2, n.torsion_nm_s_rad, n.axial_n_s_m, n.backlash_m, table.coulomb_n, table.excess_n,
            table.viscous_n_s_m, screw.coulomb_n, screw.excess_n, screw.viscous_n_s_m, m.lead_error_m, m.ripple_nm[0], m.ripple_nm[1],
            m.presliding_m, m.growth_time_s, m.extra_kg, m.lag_s
        };
        let finite = with_names! {
            l.current_gain_v_a, l.velocity_gain_a_s_rad, l.position_gain_1_s, l.feed_forward, m.growth, m.anchor_m, m.lead_phase_rad,
            m.ripple_phase_rad[0], m.ripple_phase_rad[1]
        };
        check_values(&positive, "a positive number", |value| value > 0.0)?;
        check_values(&[("speed_periods", l.speed_periods as f64)], "a positive number", |value| value > 0.0)?;
        check_values(&not_negative, "zero or a positive number", |value| value >= 0.0)?;
        check_values(&finite, "a finite number", |_| true)
    }
}

/// Returns an error for the first named value that is not finite or not admissible.
pub(super) fn check_values(
    numbers: &[(&'static str, f64)],
    wanted: &'static str,
    is_admissible: impl Fn(f64) -> bool,
) -> Result<()> {
    match numbers.iter().find(|(_, value)| !(value.is_finite() && is_admissible(*value))) {
        Some(&(key, found)) => Err(SimulatorError::Refused { key, found, wanted }),
        None => Ok(()),
    }
}
