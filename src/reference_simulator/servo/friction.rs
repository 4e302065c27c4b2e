//! Friction: elastic elements side by side, each of which slips at its share of a level that falls with speed.

/// Elements of a film.
const ELEMENTS: usize = 8;

/// Elastic distance of friction that counts as having none, m.
const RIGID_M: f64 = 50e-9;

/// A curve of friction over speed: sgn(v) (F_c + F_s e^{−|v|/v_s}) + b v.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Coulomb friction, N.
    pub coulomb_n: f64,
    /// Excess of friction at rest over it, N.
    pub excess_n: f64,
    /// Speed in which the excess falls to 1/e, m/s.
    pub stribeck_m_s: f64,
    /// Viscous friction, N·s/m.
    pub viscous_n_s_m: f64,
}

impl Friction {
    /// No friction.
    pub fn none() -> Self {
        Self { coulomb_n: 0.0, excess_n: 0.0, stribeck_m_s: 0.01, viscous_n_s_m: 0.0 }
    }

    fn level_n(&self, speed_m_s: f64) -> f64 {
        if self.excess_n == 0.0 { self.coulomb_n } else { self.coulomb_n + self.excess_n * (-speed_m_s.abs() / self.stribeck_m_s).exp() }
    }
}

/// Elements of one surface: their stretches, and where they were taken last.
///
/// Equal shares of the level; element i yields at −ln(1 − (i + ½)/n) of the mean distance: friction from rest rises steeply, then ever
/// slower, and slides as a whole at 2.8 of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    reach_m: [f64; ELEMENTS],
    stretch_m: [f64; ELEMENTS],
    at_m: f64,
}

impl Film {
    /// Relaxed at zero, elastic over a mean distance.
    pub fn relaxed(presliding_m: f64) -> Self {
        let mean = presliding_m.max(RIGID_M);
        let reach_m = std::array::from_fn(|k| -mean * (1.0 - (k as f64 + 0.5) / ELEMENTS as f64).ln());
        Self { reach_m, stretch_m: [0.0; ELEMENTS], at_m: 0.0 }
    }

    /// Stretches once carried to a position in one direction, where the level is a share of that at rest.
    fn carried(&self, position_m: f64, share: f64) -> [f64; ELEMENTS] {
        let way = position_m - self.at_m;
        std::array::from_fn(|k| {
            let limit = self.reach_m[k] * share;
            (self.stretch_m[k] + way).clamp(-limit, limit)
        })
    }

    /// Force against a motion at a position and speed, N.
    pub fn force_n(&self, law: &Friction, position_m: f64, speed_m_s: f64) -> f64 {
        let rest = law.coulomb_n + law.excess_n;
        if rest == 0.0 {
            return law.viscous_n_s_m * speed_m_s;
        }
        let stretch = self.carried(position_m, law.level_n(speed_m_s) / rest);
        let held: f64 = stretch.iter().zip(&self.reach_m).map(|(stretch, reach)| stretch / reach).sum();
        rest / ELEMENTS as f64 * held + law.viscous_n_s_m * speed_m_s
    }

    /// Takes the elements along.
    pub fn carry(&mut self, law: &Friction, position_m: f64, speed_m_s: f64) {
        let rest = law.coulomb_n + law.excess_n;
        if rest > 0.0 {
            self.stretch_m = self.carried(position_m, law.level_n(speed_m_s) / rest);
            self.at_m = position_m;
        }
    }
}
