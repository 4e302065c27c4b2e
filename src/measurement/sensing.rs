//! The stated mount of a sensor and the stated window of its signal.

use num_complex::Complex64;

use super::Quantity;
use super::frf::Fault;
use super::manifest::{FrfFile, Manifest};
use numeric::unit::omega_rad_s;

/// Mount of the sensor and window of the signal, as a manifest states them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sensing {
    /// Natural frequency (Hz) and damping ratio of the sensor on its mount.
    mount: Option<(f64, f64)>,
    /// Decay rate σ of the exponential window (1/s); 0 without one.
    pub window_per_s: f64,
}

impl Sensing {
    /// Reads what an FRF states, else what its set states.
    ///
    /// # Errors  a number out of range, or one of both numbers of the mount.
    pub fn of(manifest: &Manifest, entry: &FrfFile) -> Result<Self, Fault> {
        let above_0 = |key: &str, own: Option<f64>, of_set: Option<f64>| match own.or(of_set) {
            Some(x) if !(x > 0.0 && x.is_finite()) => Err(format!("{key}: is {x}; write a number above 0, or leave it out")),
            stated => Ok(stated),
        };
        let window_s = above_0("exponential_window_s", entry.exponential_window_s, manifest.exponential_window_s)?;
        let natural_hz = above_0("mount_resonance_hz", entry.mount_resonance_hz, manifest.mount_resonance_hz)?;
        let damping_ratio = above_0("mount_damping_ratio", entry.mount_damping_ratio, manifest.mount_damping_ratio)?;
        if natural_hz.is_some() != damping_ratio.is_some() {
            return Err("states only one of mount_resonance_hz and mount_damping_ratio; write both, or neither".into());
        }
        Ok(Sensing { mount: natural_hz.zip(damping_ratio), window_per_s: window_s.map_or(0.0, f64::recip) })
    }

    /// Returns the factor that removes the mount from a recorded FRF, and under a window makes the receptance that of ω − iσ.
    ///
    /// # Source  mount: a sensor of mass m on a spring reads 1/(1 − r² + 2iζr) of the motion, r = f/f_mount (ISO 5348). Window: the transform of
    ///   e^(−σt)·dx/dt is s·X(s) with s = iω + σ.
    pub fn correction(&self, quantity: Quantity, frequency_hz: f64) -> Complex64 {
        if !(frequency_hz > 0.0) {
            return Complex64::ONE;
        }
        let mount = self.mount.map_or(Complex64::ONE, |(natural_hz, damping_ratio)| {
            let ratio = frequency_hz / natural_hz;
            Complex64::new(1.0 - ratio * ratio, 2.0 * damping_ratio * ratio)
        });
        let derivative = Complex64::new(1.0, -self.window_per_s / omega_rad_s(frequency_hz));
        mount / derivative.powi(quantity.power())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::parse;

    fn of(set: &str, frf: &str) -> Result<Sensing, Fault> {
        let text = format!("title = \"t\"\nquantity = \"accelerance\"\n{set}\n[[frf]]\nfile = \"a.csv\"\n{frf}\n");
        let manifest = parse("manifest.toml", &text).unwrap();
        Sensing::of(&manifest, &manifest.frf[0])
    }

    #[test]
    fn an_frf_has_its_own_window_and_mount_or_those_of_its_set() {
        let set = "exponential_window_s = 0.5\nmount_resonance_hz = 3000\nmount_damping_ratio = 0.02";
        let expected = |mount, window_per_s| Ok(Sensing { mount, window_per_s });
        assert_eq!(of("", ""), expected(None, 0.0));
        assert_eq!(of(set, ""), expected(Some((3000.0, 0.02)), 2.0));
        assert_eq!(of(set, "exponential_window_s = 0.25\nmount_resonance_hz = 2000"), expected(Some((2000.0, 0.02)), 4.0));
    }

    #[test]
    fn refuse_numbers_that_are_no_window_and_no_mount() {
        for (set, said) in [
            ("exponential_window_s = 0", "exponential_window_s: is 0; write a number above 0"),
            ("exponential_window_s = -1", "exponential_window_s: is -1; write"),
            ("mount_resonance_hz = inf\nmount_damping_ratio = 0.1", "mount_resonance_hz: is inf; write"),
            ("mount_resonance_hz = 900", "only one of mount_resonance_hz and mount_damping_ratio"),
            ("mount_damping_ratio = 0.1", "write both, or neither"),
        ] {
            let fault = of(set, "").unwrap_err();
            assert!(fault.contains(said), "{fault}");
        }
    }

    /// A free mass under a sensor on its mount, recorded with a window: acceleration s²·X of X = F/(m·s²), s = iω + σ, times the sensor's magnification.
    #[test]
    fn limit_the_corrected_accelerance_of_a_mass_is_that_of_its_receptance() {
        let sensing = Sensing { mount: Some((500.0, 0.05)), window_per_s: 3.0 };
        let (mass, frequency_hz) = (12.0, 80.0);
        let s = Complex64::new(3.0, omega_rad_s(frequency_hz));
        let ratio = frequency_hz / 500.0;
        let recorded = 1.0 / mass / Complex64::new(1.0 - ratio * ratio, 0.1 * ratio);
        let corrected = recorded * sensing.correction(Quantity::Accelerance, frequency_hz);
        let receptance = corrected / Quantity::Accelerance.from_receptance(omega_rad_s(frequency_hz));
        assert!((receptance * mass * s * s - 1.0).norm() < 1e-12);
        assert_eq!(sensing.correction(Quantity::Accelerance, 0.0), Complex64::ONE);
    }
}
