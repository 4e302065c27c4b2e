//! What only the truth has.

/// Times per turn of the two ripples of the torque.
const TIMES: [f64; 2] = [1.0, 24.0];

/// What is missing from the analytical model; each is off where its size is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Strain of the warm screw.
    pub growth: f64,
    /// Time in which the strain rises from nothing, as 1 − e^{−t/τ}, s; 0 where it is there in full from the start.
    pub growth_time_s: f64,
    /// Where the fixed bearing holds the screw, m: what grows, grows away from it. Matters where the strain rises only, since the scale
    /// is set to zero at the start.
    pub anchor_m: f64,
    /// Amplitude of the lead error that repeats every turn of the screw, m.
    pub lead_error_m: f64,
    /// Its phase at the zero of travel, rad.
    pub lead_phase_rad: f64,
    /// Amplitudes of the motor's cogging once and 24 times per turn, N·m.
    pub ripple_nm: [f64; 2],
    /// Their phases at the zero of travel, rad.
    pub ripple_phase_rad: [f64; 2],
    /// Mean distance over which friction is elastic before it slides, m.
    pub presliding_m: f64,
}

impl Default for Missing {
    /// Everything at its usual size: 50 µm/m, 0.8 µm, 0.1 and 0.15 N·m, 5 µm; the strain there from the start.
    fn default() -> Self {
        Self { growth: 5e-5, lead_error_m: 0.8e-6, ripple_nm: [0.1, 0.15], presliding_m: 5e-6, ..Self::none() }
    }
}

impl Missing {
    /// Nothing is missing: the truth and the analytical model differ by their methods only.
    pub fn none() -> Self {
        Self {
            growth: 0.0,
            growth_time_s: 0.0,
            anchor_m: -0.3,
            lead_error_m: 0.0,
            lead_phase_rad: 0.7,
            ripple_nm: [0.0; 2],
            ripple_phase_rad: [2.1, 4.4],
            presliding_m: 0.0,
        }
    }

    /// Torque of cogging on the motor at its angle, N·m: Σ A sin(n θ + φ).
    pub(super) fn cogging_nm(&self, angle_rad: f64) -> f64 {
        self.cogging(angle_rad, |_, angle| angle.sin())
    }

    /// Energy stored in it, J: Σ A/n cos(n θ + φ).
    #[cfg(test)]
    pub(super) fn cogging_j(&self, angle_rad: f64) -> f64 {
        self.cogging(angle_rad, |times, angle| angle.cos() / times)
    }

    fn cogging(&self, angle_rad: f64, wave: impl Fn(f64, f64) -> f64) -> f64 {
        let one = |k: usize| {
            if self.ripple_nm[k] == 0.0 { 0.0 } else { self.ripple_nm[k] * wave(TIMES[k], TIMES[k] * angle_rad + self.ripple_phase_rad[k]) }
        };
        one(0) + one(1)
    }

    /// Where the screw's thread, of r = `ratio_m` for one radian, carries the nut: x = r θ + γ(t) (r θ − a) + γ(0) a + e [sin(θ + φ) − sin φ].
    pub(super) fn thread(&self, ratio_m: f64, time_s: f64, angle_rad: f64) -> Thread {
        let way = ratio_m * angle_rad;
        let mut thread = Thread { at_m: way, per_rad_m: ratio_m, creep_m_s: 0.0 };
        if self.growth != 0.0 {
            let (start, rising) = if self.growth_time_s > 0.0 { (0.0, (-time_s / self.growth_time_s).exp()) } else { (self.growth, 0.0) };
            let strain = self.growth * (1.0 - rising);
            thread.at_m += strain * (way - self.anchor_m) + start * self.anchor_m;
            thread.per_rad_m += strain * ratio_m;
            if rising > 0.0 {
                thread.creep_m_s = self.growth * rising / self.growth_time_s * (way - self.anchor_m);
            }
        }
        if self.lead_error_m != 0.0 {
            let (sin, cos) = (angle_rad + self.lead_phase_rad).sin_cos();
            thread.at_m += self.lead_error_m * (sin - self.lead_phase_rad.sin());
            thread.per_rad_m += self.lead_error_m * cos;
        }
        thread
    }
}

/// The thread at the nut.
pub(super) struct Thread {
    /// Where it carries the nut, m.
    pub at_m: f64,
    /// How far a radian carries it, m.
    pub per_rad_m: f64,
    /// How fast it moves though the screw stands still, m/s.
    pub creep_m_s: f64,
}
