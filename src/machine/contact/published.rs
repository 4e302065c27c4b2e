//! The joints and friction curves of Duan, Tab. 1–3, as printed, with the quantities that had to be chosen.

use super::{Balls, BearingData, NutData, StribeckCurve};

/// Axial preload P_p (N) of the double nut: Duan, Tab. 1.
pub const NUT_PRELOAD_N: f64 = 1115.0;

/// Axial preload F_p (N) of the bearing pair: Duan, Tab. 3.
pub const BEARING_PRELOAD_N: f64 = 1000.0;

/// Efficiency P_T of the motor: Duan, Eq. 11.
pub const MOTOR_EFFICIENCY: f64 = 0.90;

/// Conformity of nut and bearing with which Eq. 7–9 and 18–20 give the published stiffnesses, with one loaded
/// turn and δ_n/sin α (1). Tab. 1 and 3 print 0.52.
pub const CONFORMITY_OF_STIFFNESSES: f64 = 0.53;

/// Lead p (m per turn) of the screw: Duan, Tab. 4.
pub const LEAD_M: f64 = 5e-3;

/// Number of balls as printed in Duan, Tab. 1. The paper's formula gives 19.85 for one turn and 99.3 for the
/// five of this nut.
pub const NUT_BALLS: Balls = Balls::Count(98.0);

/// Published axial stiffness (N/m) of the nut: Duan, section 4.1.1.
pub const NUT_STIFFNESS_N_PER_M: f64 = 1.28e8;

/// Published axial stiffness (N/m) of the bearing pair: Duan, section 4.1.2.
pub const BEARING_PAIR_STIFFNESS_N_PER_M: f64 = 4.2e7;

/// Returns one nut of the HIWIN FDW20-5B2: Duan, Tab. 1 and 4, steel as below Eq. 9, conformity 0.52 on both
/// races.
pub fn nut(balls: Balls) -> NutData {
    NutData::steel(LEAD_M, 20e-3, 3.175e-3, 45.0_f64.to_radians(), 0.52, balls)
}

/// Returns one FAG B7202: Duan, Tab. 3.
///
/// Chosen, not printed: the pitch diameter of 25 mm, midway between bore and outer diameter of a 7202.
pub fn bearing() -> BearingData {
    BearingData::steel(10, 6.6e-3, 25e-3, 40.0_f64.to_radians(), 0.52)
}

/// Returns the friction of axis 1: Duan, Tab. 2.
///
/// The table gives v_s in mm/s and no unit for d_elt. N per mm/s is assumed: only that gives a plausible
/// friction at 50 mm/s. With an axial force of P_T·f(v) and the printed rule, it unloads nut B at 34.1 m/min
/// and bearing B at 30.1 m/min; section 5.2 prints 35 and 30.
pub fn friction_axis_1() -> StribeckCurve {
    StribeckCurve {
        coulomb_n: 280.90,
        static_n: 425.80,
        viscous_n_s_per_m: 3490.0,
        stribeck_velocity_m_per_s: 0.42e-3,
    }
}

/// Returns the friction of axis 2: Duan, Tab. 2, units as for axis 1.
pub fn friction_axis_2() -> StribeckCurve {
    StribeckCurve {
        coulomb_n: 431.40,
        static_n: 1225.0,
        viscous_n_s_per_m: 5100.0,
        stribeck_velocity_m_per_s: 0.30e-3,
    }
}
