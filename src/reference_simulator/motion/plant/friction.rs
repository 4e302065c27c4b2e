//! Friction of one surface: elastic elements that slip in sequence, a level that falls with speed, and an oil
//! film.

use super::wave::{Wave, wave_sum};

/// Share of the sliding force of each element, in the order of breakaway.
pub const SHARES: [f64; 5] = [0.3, 0.25, 0.2, 0.15, 0.1];

/// Breakaway displacement of each element, over the mean weighted by the shares.
const REACH: [f64; 5] = [0.4, 0.7, 1.0, 1.6, 2.65];

/// Deflection of each element over its breakaway displacement, within ±1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionElements {
    deflection: [f64; 5],
}

/// Parameters of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Sliding force at speed, N.
    pub coulomb_n: f64,
    /// Viscous coefficient at small speed, N·s/m.
    pub viscous_n_s_m: f64,
    /// Excess of the sliding force at rest over the force at speed, relative.
    pub excess: f64,
    /// Stribeck speed, m/s.
    pub stribeck_m_s: f64,
    /// Relative excess of Coulomb and of viscous friction in the forward direction; the backward direction
    /// lacks as much.
    pub asymmetry: [f64; 2],
    /// Relative decrease of the viscous coefficient at the reference speed.
    pub thinning: f64,
    /// Reference speed of the decrease, m/s.
    pub reference_speed_m_s: f64,
    /// Mean breakaway displacement of the elements, m.
    pub presliding_m: f64,
    /// Sliding force for one newton through the nut.
    pub load_coefficient: f64,
    /// Relative change of the sliding force along the travel.
    pub position_waves: Vec<Wave>,
}

impl Friction {
    /// Returns a surface without friction.
    pub fn none() -> Self {
        Self {
            coulomb_n: 0.0,
            viscous_n_s_m: 0.0,
            excess: 0.0,
            stribeck_m_s: 0.01,
            asymmetry: [0.0; 2],
            thinning: 0.0,
            reference_speed_m_s: 1.0,
            presliding_m: 1e-6,
            load_coefficient: 0.0,
            position_waves: Vec::new(),
        }
    }

    /// Moves the elements by a displacement.
    pub fn advance(&self, elements: &mut FrictionElements, displacement_m: f64) {
        for (value, reach) in elements.deflection.iter_mut().zip(REACH) {
            *value = (*value + displacement_m / (reach * self.presliding_m)).clamp(-1.0, 1.0);
        }
    }

    /// Returns the dry sliding force at a position, before the influence of load and speed, N.
    pub fn level_n(&self, position_m: f64, oil_factor: f64) -> f64 {
        if self.position_waves.is_empty() {
            self.coulomb_n * oil_factor
        } else {
            self.coulomb_n * (1.0 + wave_sum(&self.position_waves, position_m)) * oil_factor
        }
    }

    /// Computes the force against the motion, with the dry level of the position.
    ///
    /// Elements Σ αᵢ s yᵢ with s = (F_c (1 + w(x)) + μ|N|) (1 + r / cosh(v/v_f)) (1 + l y), and the film f v
    /// (1 + l′ tanh) / (1 + κ
    /// |v|/v_r).
    pub fn force(&self, elements: &FrictionElements, level_n: f64, speed_m_s: f64, load_n: f64) -> f64 {
        let stribeck =
            if self.excess == 0.0 { 0.0 } else { self.excess / (speed_m_s / self.stribeck_m_s).cosh() };
        let level = (level_n + self.load_coefficient * load_n.abs()) * (1.0 + stribeck);
        let carried: f64 = elements.deflection.iter().zip(SHARES).map(|(value, share)| value * share).sum();
        let asymmetry = if self.asymmetry[1] == 0.0 {
            0.0
        } else {
            self.asymmetry[1] * (speed_m_s / (0.05 * self.reference_speed_m_s)).tanh()
        };
        let film = self.viscous_n_s_m * speed_m_s * (1.0 + asymmetry)
            / (1.0 + self.thinning * speed_m_s.abs() / self.reference_speed_m_s);
        level * carried * (1.0 + self.asymmetry[0] * carried) + film
    }
}
