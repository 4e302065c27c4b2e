//! Friction: parallel elastic elements, each of which slips at its share of a level that falls with speed.

/// Number of elements of a surface.
const ELEMENTS: usize = 8;

/// Least elastic distance of the elements, m; it stands for friction without presliding.
const RIGID_M: f64 = 50e-9;

/// A friction curve over speed: sgn(v) (F_c + F_s e^{−|v|/v_s}) + b v.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Coulomb friction, N.
    pub coulomb_n: f64,
    /// Excess of friction at rest over Coulomb friction, N.
    pub excess_n: f64,
    /// Speed at which the excess has fallen to 1/e, m/s.
    pub stribeck_m_s: f64,
    /// Viscous friction, N·s/m.
    pub viscous_n_s_m: f64,
}

impl Friction {
    /// Returns a curve without friction.
    pub fn none() -> Self {
        Self { coulomb_n: 0.0, excess_n: 0.0, stribeck_m_s: 0.01, viscous_n_s_m: 0.0 }
    }

    fn level_n(&self, speed_m_s: f64) -> f64 {
        if self.excess_n == 0.0 {
            self.coulomb_n
        } else {
            self.coulomb_n + self.excess_n * (-speed_m_s.abs() / self.stribeck_m_s).exp()
        }
    }
}

/// Elastic elements of one surface: their stretches and their last position.
///
/// All elements have equal shares of the level. Element i slips at −ln(1 − (i + ½)/n) of the mean distance.
/// Friction from rest rises steeply, then ever more slowly; full sliding begins at 2.8 of the mean distance.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionElements {
    slip_distance_m: [f64; ELEMENTS],
    stretch_m: [f64; ELEMENTS],
    position_m: f64,
}

impl FrictionElements {
    /// Creates relaxed elements at position zero with a mean elastic distance.
    pub fn relaxed(presliding_m: f64) -> Self {
        let mean = presliding_m.max(RIGID_M);
        let slip_distance_m =
            std::array::from_fn(|k| -mean * (1.0 - (k as f64 + 0.5) / ELEMENTS as f64).ln());
        Self { slip_distance_m, stretch_m: [0.0; ELEMENTS], position_m: 0.0 }
    }

    /// Returns the stretches after a displacement in one direction to a position; `share` is the level over
    /// the level at rest.
    fn advanced(&self, position_m: f64, share: f64) -> [f64; ELEMENTS] {
        let way = position_m - self.position_m;
        std::array::from_fn(|k| {
            let limit = self.slip_distance_m[k] * share;
            (self.stretch_m[k] + way).clamp(-limit, limit)
        })
    }

    /// Returns the force against a motion at a position and speed, N.
    pub fn force_n(&self, law: &Friction, position_m: f64, speed_m_s: f64) -> f64 {
        let rest = law.coulomb_n + law.excess_n;
        if rest == 0.0 {
            return law.viscous_n_s_m * speed_m_s;
        }
        let stretch = self.advanced(position_m, law.level_n(speed_m_s) / rest);
        let sum: f64 =
            stretch.iter().zip(&self.slip_distance_m).map(|(stretch, reach)| stretch / reach).sum();
        rest / ELEMENTS as f64 * sum + law.viscous_n_s_m * speed_m_s
    }

    /// Moves the elements to a position.
    pub fn advance(&mut self, law: &Friction, position_m: f64, speed_m_s: f64) {
        let rest = law.coulomb_n + law.excess_n;
        if rest > 0.0 {
            self.stretch_m = self.advanced(position_m, law.level_n(speed_m_s) / rest);
            self.position_m = position_m;
        }
    }
}
