//! Friction of one surface: elastic elements that slip one after another, a level that falls with speed, and a film of oil.

use super::wave::{Wave, along};

/// Share of the sliding force that each element carries, the one that breaks away first in front.
pub const SHARES: [f64; 5] = [0.3, 0.25, 0.2, 0.15, 0.1];

/// Where each element breaks away, over the mean of them all weighed by their shares.
const REACH: [f64; 5] = [0.4, 0.7, 1.0, 1.6, 2.65];

/// Deflection of each element over the one at which it breaks away: within ±1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Film {
    deflection: [f64; 5],
}

/// Laws of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Sliding force at speed, N.
    pub coulomb_n: f64,
    /// Viscous coefficient at small speed, N·s/m.
    pub viscous_n_s_m: f64,
    /// Rise of the sliding force at rest over that at speed.
    pub rise: f64,
    /// Speed of the fall, m/s.
    pub fall_m_s: f64,
    /// Coulomb and viscous excess forward, and lack of it backward, over their means.
    pub lean: [f64; 2],
    /// Relative loss of the viscous coefficient at the reference speed.
    pub thinning: f64,
    /// Reference speed of the thinning, m/s.
    pub fast_m_s: f64,
    /// Mean displacement at which elements break away, m.
    pub presliding_m: f64,
    /// Sliding force for one newton through the nut.
    pub of_load: f64,
    /// Relative change of the sliding force along the travel.
    pub along: Vec<Wave>,
}

impl Friction {
    /// A surface without friction.
    pub fn none() -> Self {
        Self {
            coulomb_n: 0.0,
            viscous_n_s_m: 0.0,
            rise: 0.0,
            fall_m_s: 0.01,
            lean: [0.0; 2],
            thinning: 0.0,
            fast_m_s: 1.0,
            presliding_m: 1e-6,
            of_load: 0.0,
            along: Vec::new(),
        }
    }

    /// Carries the elements over a displacement.
    pub fn drag(&self, film: &mut Film, displacement_m: f64) {
        for (value, reach) in film.deflection.iter_mut().zip(REACH) {
            *value = (*value + displacement_m / (reach * self.presliding_m)).clamp(-1.0, 1.0);
        }
    }

    /// Sliding force of the dry part at a position, before load and speed, N.
    pub fn level_n(&self, position_m: f64, warmth: f64) -> f64 {
        if self.along.is_empty() { self.coulomb_n * warmth } else { self.coulomb_n * (1.0 + along(&self.along, position_m)) * warmth }
    }

    /// Force against the motion, with the dry level of the position.
    ///
    /// Elements Σ αᵢ s yᵢ with s = (F_c (1 + w(x)) + μ|N|) (1 + r / cosh(v/v_f)) (1 + l y), and the film f v (1 + l′ tanh) / (1 + κ |v|/v_r).
    pub fn force(&self, film: &Film, level_n: f64, speed_m_s: f64, load_n: f64) -> f64 {
        let fall = if self.rise == 0.0 { 0.0 } else { self.rise / (speed_m_s / self.fall_m_s).cosh() };
        let level = (level_n + self.of_load * load_n.abs()) * (1.0 + fall);
        let carried: f64 = film.deflection.iter().zip(SHARES).map(|(value, share)| value * share).sum();
        let lean = if self.lean[1] == 0.0 { 0.0 } else { self.lean[1] * (speed_m_s / (0.05 * self.fast_m_s)).tanh() };
        let film = self.viscous_n_s_m * speed_m_s * (1.0 + lean) / (1.0 + self.thinning * speed_m_s.abs() / self.fast_m_s);
        level * carried * (1.0 + self.lean[0] * carried) + film
    }
}
