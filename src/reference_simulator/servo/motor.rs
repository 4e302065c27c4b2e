//! The synchronous motor in the rotor-fixed frame.

use super::nominal::Nominal;

/// Computes the rates of i_d and i_q, A/s, at a speed of the rotor.
///
/// u_d = R i_d + L_d i_d′ − ω_e L_q i_q,  u_q = R i_q + L_q i_q′ + ω_e (L_d i_d + ψ),  ω_e = p ω
///
/// # Source     Symmetry 11 (2019) 1156, section 2.4.
pub fn rates_a_s(nominal: &Nominal, current_a: [f64; 2], speed_rad_s: f64, voltage_v: [f64; 2]) -> [f64; 2] {
    let ([d, q], [inductance_d, inductance_q]) = (current_a, nominal.inductance_h);
    let electric = nominal.pole_pairs * speed_rad_s;
    [
        (voltage_v[0] - nominal.resistance_ohm * d + electric * inductance_q * q) / inductance_d,
        (voltage_v[1] - nominal.resistance_ohm * q - electric * (inductance_d * d + nominal.flux_wb()))
            / inductance_q,
    ]
}

/// Computes the torque, N·m: 3/2 p (ψ i_q + (L_d − L_q) i_d i_q).
pub fn torque_nm(nominal: &Nominal, [d, q]: [f64; 2]) -> f64 {
    let [inductance_d, inductance_q] = nominal.inductance_h;
    1.5 * nominal.pole_pairs * (nominal.flux_wb() * q + (inductance_d - inductance_q) * d * q)
}

/// Computes the magnetic energy of the currents, J: 3/4 (L_d i_d² + L_q i_q²).
#[cfg(test)]
pub fn field_j(nominal: &Nominal, [d, q]: [f64; 2]) -> f64 {
    0.75 * (nominal.inductance_h[0] * d * d + nominal.inductance_h[1] * q * q)
}
