//! Effects that only the simulator has.

/// Cycles per revolution of the two ripples of the torque.
const TIMES: [f64; 2] = [1.0, 24.0];

/// Effects that the analytical model lacks; each is absent where its size is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Strain of the warm screw.
    pub growth: f64,
    /// Time constant τ of the strain, which rises as 1 − e^{−t/τ}, s; 0 for the full strain from the start.
    pub growth_time_s: f64,
    /// Position of the fixed bearing, m: the screw expands away from it. It matters only while the strain
    /// rises, because the scale is set to zero at the start.
    pub anchor_m: f64,
    /// Amplitude of the lead error that repeats every revolution of the screw, m.
    pub lead_error_m: f64,
    /// Phase of the lead error at the zero of travel, rad.
    pub lead_phase_rad: f64,
    /// Amplitudes of the motor's cogging at 1 and 24 cycles per revolution, N·m.
    pub ripple_nm: [f64; 2],
    /// Phases of the cogging at the zero of travel, rad.
    pub ripple_phase_rad: [f64; 2],
    /// Mean distance of elastic friction before sliding, m.
    pub presliding_m: f64,
    /// Mass on the table, such as a workpiece, kg.
    pub extra_kg: f64,
    /// Time constant of a first-order lag between position and velocity loop, s; 0 for none.
    pub lag_s: f64,
}

impl Default for Missing {
    /// Returns the effects of screw, motor and guide at their usual size: 50 µm/m, 0.8 µm, 0.1 and 0.15 N·m,
    /// 5 µm; the strain is constant from the start. No mass and no lag.
    fn default() -> Self {
        Self {
            growth: 5e-5,
            lead_error_m: 0.8e-6,
            ripple_nm: [0.1, 0.15],
            presliding_m: 5e-6,
            ..Self::none()
        }
    }
}

impl Missing {
    /// Returns no effect: simulator and analytical model then differ only in their methods.
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
            extra_kg: 0.0,
            lag_s: 0.0,
        }
    }

    /// Returns the cogging torque on the motor at its angle, N·m: Σ A sin(n θ + φ).
    pub(super) fn cogging_nm(&self, angle_rad: f64) -> f64 {
        self.cogging(angle_rad, |_, angle| angle.sin())
    }

    /// Returns the energy stored in the cogging, J: Σ A/n cos(n θ + φ).
    #[cfg(test)]
    pub(super) fn cogging_j(&self, angle_rad: f64) -> f64 {
        self.cogging(angle_rad, |times, angle| angle.cos() / times)
    }

    fn cogging(&self, angle_rad: f64, wave: impl Fn(f64, f64) -> f64) -> f64 {
        let one = |k: usize| {
            if self.ripple_nm[k] == 0.0 {
                0.0
            } else {
                self.ripple_nm[k] * wave(TIMES[k], TIMES[k] * angle_rad + self.ripple_phase_rad[k])
            }
        };
        one(0) + one(1)
    }

    /// Returns the position of the thread at the nut with r = `ratio_m` per radian: x = r θ +
    /// γ(t) (r θ − a) + γ(0) a + e [sin(θ + φ) − sin φ].
    pub(super) fn thread(&self, ratio_m: f64, time_s: f64, angle_rad: f64) -> Thread {
        let travel_m = ratio_m * angle_rad;
        let mut thread = Thread { position_m: travel_m, per_rad_m: ratio_m, expansion_m_s: 0.0 };
        if self.growth != 0.0 {
            let (start, remaining) = if self.growth_time_s > 0.0 {
                (0.0, (-time_s / self.growth_time_s).exp())
            } else {
                (self.growth, 0.0)
            };
            let strain = self.growth * (1.0 - remaining);
            thread.position_m += strain * (travel_m - self.anchor_m) + start * self.anchor_m;
            thread.per_rad_m += strain * ratio_m;
            if remaining > 0.0 {
                thread.expansion_m_s =
                    self.growth * remaining / self.growth_time_s * (travel_m - self.anchor_m);
            }
        }
        if self.lead_error_m != 0.0 {
            let (sin, cos) = (angle_rad + self.lead_phase_rad).sin_cos();
            thread.position_m += self.lead_error_m * (sin - self.lead_phase_rad.sin());
            thread.per_rad_m += self.lead_error_m * cos;
        }
        thread
    }
}

/// The thread at the nut.
pub(super) struct Thread {
    /// Position of the thread, m.
    pub position_m: f64,
    /// Travel per radian, m.
    pub per_rad_m: f64,
    /// Speed of the thread by thermal expansion at a standing screw, m/s.
    pub expansion_m_s: f64,
}
