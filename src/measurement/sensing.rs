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

/// Shortest time constant of an exponential window (s): a shorter one ends within a sample of any recorder.
const SHORTEST_WINDOW_S: f64 = 1e-6;

impl Sensing {
    /// Reads what an FRF states, else what its set states.
    ///
    /// # Errors  a number out of range, or one of both numbers of the mount.
    pub fn of(manifest: &Manifest, entry: &FrfFile) -> Result<Self, Fault> {
        let above_0 = |key: &str, own: Option<f64>, of_set: Option<f64>| match own.or(of_set) {
            Some(x) if !(x > 0.0 && x.is_finite()) => {
                Err(format!("{key}: is {x}; write a number above 0, or leave it out"))
            }
            stated => Ok(stated),
        };
        let window_s = match entry.exponential_window_s.or(manifest.exponential_window_s) {
            Some(0.0) => None,
            Some(x) if !(x >= SHORTEST_WINDOW_S && x.is_finite()) => {
                return Err(format!(
                    "exponential_window_s: is {x}; write its time constant in s, or 0 for an FRF without a window"
                ));
            }
            stated => stated,
        };
        let natural_hz =
            above_0("mount_resonance_hz", entry.mount_resonance_hz, manifest.mount_resonance_hz)?;
        let damping_ratio =
            above_0("mount_damping_ratio", entry.mount_damping_ratio, manifest.mount_damping_ratio)?;
        if natural_hz.is_some() != damping_ratio.is_some() {
            return Err(
                "states only one of mount_resonance_hz and mount_damping_ratio; write both, or neither"
                    .into(),
            );
        }
        Ok(Sensing { mount: natural_hz.zip(damping_ratio), window_per_s: window_s.map_or(0.0, f64::recip) })
    }

    /// Returns the factor that removes the mount from a recorded FRF, and under a window makes the receptance
    /// that of ω − iσ.
    ///
    /// # Source  mount: a mass on a spring and a damper on the moving surface, (2ζω_m·s + ω_m²)/(s² +
    ///   2ζω_m·s + ω_m²), as the chain fault `mount-resonance`. Window: the transform of e^(−σt)·dx/dt is s·X(s) with s = iω + σ.
    pub fn correction(&self, quantity: Quantity, frequency_hz: f64) -> Complex64 {
        if !(frequency_hz > 0.0) {
            return Complex64::ONE;
        }
        let s = Complex64::new(self.window_per_s, omega_rad_s(frequency_hz));
        let mount = self.mount.map_or(Complex64::ONE, |(natural_hz, damping_ratio)| {
            let ratio = s / omega_rad_s(natural_hz);
            let carried = 1.0 + 2.0 * damping_ratio * ratio;
            (carried + ratio * ratio) / carried
        });
        mount / quantity.windowed(self.window_per_s, omega_rad_s(frequency_hz))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::parse;

    fn of(set: &str, frf: &str) -> Result<Sensing, Fault> {
        let text =
            format!("title = \"t\"\nquantity = \"accelerance\"\n{set}\n[[frf]]\nfile = \"a.csv\"\n{frf}\n");
        let manifest = parse("manifest.toml", &text).unwrap();
        Sensing::of(&manifest, &manifest.frf[0])
    }

    #[test]
    fn an_frf_has_its_own_window_and_mount_or_those_of_its_set() {
        let set = "exponential_window_s = 0.5\nmount_resonance_hz = 3000\nmount_damping_ratio = 0.02";
        let expected = |mount, window_per_s| Ok(Sensing { mount, window_per_s });
        assert_eq!(of("", ""), expected(None, 0.0));
        assert_eq!(of(set, ""), expected(Some((3000.0, 0.02)), 2.0));
        assert_eq!(of(set, "exponential_window_s = 0"), expected(Some((3000.0, 0.02)), 0.0));
        assert_eq!(
            of(set, "exponential_window_s = 0.25\nmount_resonance_hz = 2000"),
            expected(Some((2000.0, 0.02)), 4.0)
        );
    }

    #[test]
    fn refuse_numbers_that_are_no_window_and_no_mount() {
        for (set, said) in [
            ("exponential_window_s = -1", "exponential_window_s: is -1; write its time constant"),
            ("exponential_window_s = 1e-300", "write its time constant in s"),
            ("exponential_window_s = inf", "or 0 for an FRF without a window"),
            ("mount_resonance_hz = inf\nmount_damping_ratio = 0.1", "mount_resonance_hz: is inf; write"),
            ("mount_resonance_hz = 900", "only one of mount_resonance_hz and mount_damping_ratio"),
            ("mount_damping_ratio = 0.1", "write both, or neither"),
        ] {
            let fault = of(set, "").unwrap_err();
            assert!(fault.contains(said), "{fault}");
        }
    }

    /// A free mass under a sensor on its mount, recorded with a window: the accelerometer's mass z on spring
    /// and damper follows the surface x, z̈ = ω_m²·(x − z) + 2ζω_m·(ẋ − ż), and reads its acceleration s²·Z
    /// at s = iω + σ; the surface moves by X = F/(m·s²).
    #[test]
    fn limit_the_corrected_accelerance_of_a_mass_is_its_receptance() {
        let sensing = Sensing { mount: Some((500.0, 0.05)), window_per_s: 3.0 };
        let (mass, frequency_hz, natural) = (12.0, 80.0, omega_rad_s(500.0));
        let s = Complex64::new(3.0, omega_rad_s(frequency_hz));
        let surface = 1.0 / (mass * s * s);
        let [inertia, tie] = [s * s, natural * natural + 2.0 * 0.05 * natural * s];
        let recorded = s * s * surface * tie / (inertia + tie);
        let corrected = recorded * sensing.correction(Quantity::Accelerance, frequency_hz);
        let receptance = corrected / Quantity::Accelerance.from_receptance(omega_rad_s(frequency_hz));
        assert!((receptance / surface - 1.0).norm() < 1e-12);
        assert_eq!(sensing.correction(Quantity::Accelerance, 0.0), Complex64::ONE);
    }
}
