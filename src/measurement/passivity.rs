//! Activity of driving points: a passive structure takes up power there.

use super::Frf;

/// Standard deviations of its noise by which Im(receptance) of a line must exceed 0 (1).
const BEYOND_NOISE: f64 = 3.0;
/// Assumed standard deviation of a component of ln H where the noise is unknown (1).
const UNKNOWN_SD: f64 = 0.02;
/// Share of active lines above which a driving point is active (1): a few exceed the noise by chance.
const CHANCE: f64 = 0.02;
/// Largest share of Σ(Im H)² at active lines that errors of phase explain (1): they reach little of it, since
/// Im H is largest at resonances.
const PHASE_ERROR: f64 = 0.1;

/// Share of a driving point's FRF at which the structure would give off power: its active lines, where
/// Im(receptance) > 0 beyond noise.
///
/// # Source  a passive structure takes up power at a driving point: Re(mobility) ≥ 0, so Im(receptance) ≤ 0;
///   Ewins, Modal Testing (2000),
/// section 2.4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Activity {
    /// Share of the lines that are active (1).
    pub lines: f64,
    /// Share of Σ(Im receptance)² at them (1).
    pub squares: f64,
}

impl Activity {
    /// Whether the driving point is active at more lines than by chance, as by a delay, a wrong sign or a
    /// wrong quantity.
    pub fn is_active(self) -> bool {
        self.lines > CHANCE
    }

    /// Whether it is active at its resonances, too, which no delay explains.
    pub fn exceeds_phase_errors(self) -> bool {
        self.squares > PHASE_ERROR
    }
}

impl Frf {
    /// Returns the activity of a driving point; `None` for a transfer function.
    pub fn activity(&self) -> Option<Activity> {
        if self.response != self.excitation {
            return None;
        }
        let (mut count, mut active, mut all) = (0, 0.0, 0.0);
        for (line, sd) in self.lines.iter().zip(self.component_sds()) {
            let receptance = self.receptance(line);
            let square = receptance.im * receptance.im;
            all += square;
            if receptance.im > BEYOND_NOISE * sd.unwrap_or(UNKNOWN_SD) * receptance.norm() {
                count += 1;
                active += square;
            }
        }
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        Some(Activity {
            lines: share(f64::from(count), self.lines.len() as f64),
            squares: share(active, all),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Condition, FrfLine, FrfNoise, Quantity};
    use num_complex::Complex64;
    use numeric::unit::omega_rad_s;

    /// Returns the driving point of a damped mass on a spring with a natural frequency of 100 Hz, times a
    /// factor by frequency (Hz).
    fn driving_point(quantity: Quantity, factor: impl Fn(f64) -> Complex64) -> Frf {
        let line = |hz: f64| {
            let receptance = 1.0 / Complex64::new(1.0 - (hz / 100.0).powi(2), 0.04 * hz / 100.0);
            let value = receptance * quantity.from_receptance(omega_rad_s(hz)) * factor(hz);
            FrfLine { frequency_hz: hz, value, noise: Some(FrfNoise::RelativeSd(0.01)) }
        };
        Frf {
            position: None,
            record: None,
            response: "table".into(),
            excitation: "table".into(),
            quantity,
            condition: Condition::default(),
            averages: None,
            source: "test".into(),
            lines: (10..=400).map(|hz| line(f64::from(hz))).collect(),
            rejected: Vec::new(),
        }
    }

    #[test]
    fn limit_passive_driving_points_have_no_active_line() {
        for quantity in [Quantity::Receptance, Quantity::Mobility, Quantity::Accelerance] {
            let passive = driving_point(quantity, |_| Complex64::ONE);
            assert_eq!(passive.activity(), Some(Activity { lines: 0.0, squares: 0.0 }), "{quantity:?}");
            let transfer = Frf { response: "nut".into(), ..driving_point(quantity, |_| -Complex64::ONE) };
            assert_eq!(transfer.activity(), None);
        }
    }

    /// A wrong sign and a wrong quantity put the resonance on the active side, a delay the lines above it
    /// alone.
    #[test]
    fn limit_a_delay_is_active_but_no_more_than_an_error_of_phase() {
        let turned = driving_point(Quantity::Accelerance, |_| -Complex64::ONE).activity().unwrap();
        let misread = Frf {
            quantity: Quantity::Receptance,
            ..driving_point(Quantity::Accelerance, |_| Complex64::ONE)
        };
        for activity in [turned, misread.activity().unwrap()] {
            assert!(activity.is_active() && activity.exceeds_phase_errors(), "{activity:?}");
        }
        let delayed = driving_point(Quantity::Receptance, |hz| Complex64::cis(-omega_rad_s(hz) * 1e-4))
            .activity()
            .unwrap();
        assert!(delayed.is_active() && !delayed.exceeds_phase_errors(), "{delayed:?}");
    }

    #[test]
    fn limit_noise_makes_no_driving_point_active() {
        // Phase errors of one standard deviation in turn.
        let noisy = driving_point(Quantity::Mobility, |hz| {
            Complex64::cis(if hz % 2.0 < 1.0 { 0.007 } else { -0.007 })
        });
        assert!(!noisy.activity().unwrap().is_active());
    }
}
