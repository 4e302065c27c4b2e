//! Branch laws: dynamic stiffness as a function of the Laplace variable s.
//!
//! A loss factor η that does not depend on frequency is causal only together with a stiffness that does. The
//! law k (1 + (2η/π) ln(s/ω₀)) equals k (1 + i η) at ω₀ and has the loss η at every frequency. Unlike k (1 +
//! i η) it is the transform of a causal force. All loss factors of this module have this form, with ω₀ = 2π ·
//! 200 rad/s.
//!
//! The share of dispersion goes from 1 down to 0, where the law is k (1 + i η). Joints whose loss comes from
//! microslip, independent of rate, are closer to 0.

use num_complex::Complex64;

/// A point of the Laplace plane with the values that all branches need.
#[derive(Clone, Copy, Debug)]
pub struct LaplacePoint {
    /// s
    pub s: Complex64,
    /// s²
    pub s2: Complex64,
    /// Term that a unit loss factor adds to 1: (2/π) ln(s/ω₀) with full dispersion, ±i with none.
    pub log: Complex64,
}

impl LaplacePoint {
    /// Creates the point s for a share of dispersion of the losses.
    pub fn new(s: Complex64, dispersion: f64) -> Self {
        let causal = (s / REFERENCE_RAD_S).ln() * std::f64::consts::FRAC_2_PI;
        let constant = Complex64::new(0.0, s.im.signum());
        Self { s, s2: s * s, log: causal * dispersion + constant * (1.0 - dispersion) }
    }

    /// Returns the factor of a loss factor on stiffness or modulus.
    pub fn modulus(&self, loss: f64) -> Complex64 {
        1.0 + self.log * loss
    }
}

/// Dynamic stiffness of one branch, force over the branch's motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// Spring, dashpot and loss factor in parallel: k (1 + (2η/π) ln(s/ω₀)) + s c.
    Kelvin {
        /// k
        stiffness: f64,
        /// c
        damping: f64,
        /// η
        loss: f64,
    },
    /// Inertia: s² m.
    Mass(f64),
    /// Spring in series with a dashpot: k s τ / (1 + s τ).
    Maxwell {
        /// k
        stiffness: f64,
        /// τ
        time_s: f64,
    },
    /// A controlled drive: (k + s c + k_i / s) e^{−s τ}.
    Servo {
        /// k
        stiffness: f64,
        /// c
        damping: f64,
        /// k_i
        integral: f64,
        /// τ
        delay_s: f64,
    },
    /// Power law b s^p, for example of squeezed films.
    Power {
        /// b
        coefficient: f64,
        /// p
        exponent: f64,
    },
    /// A mass suspended on a spring with a loss factor: s² m z / (s² m + z).
    Suspended {
        /// m
        mass: f64,
        /// k
        stiffness: f64,
        /// η
        loss: f64,
    },
}

impl Law {
    /// Creates a spring with a loss factor.
    pub fn spring(stiffness: f64, loss: f64) -> Self {
        Self::Kelvin { stiffness, damping: 0.0, loss }
    }

    /// Creates a suspended mass by its natural frequency (Hz).
    pub fn suspended(mass: f64, natural_hz: f64, loss: f64) -> Self {
        Self::Suspended { mass, stiffness: mass * (2.0 * std::f64::consts::PI * natural_hz).powi(2), loss }
    }

    /// Returns the dynamic stiffness at a point.
    pub fn at(&self, point: &LaplacePoint) -> Complex64 {
        let s = point.s;
        match *self {
            Self::Kelvin { stiffness, damping, loss } => stiffness * point.modulus(loss) + s * damping,
            Self::Mass(mass) => point.s2 * mass,
            Self::Maxwell { stiffness, time_s } => stiffness * s * time_s / (1.0 + s * time_s),
            Self::Servo { stiffness, damping, integral, delay_s } => {
                (stiffness + s * damping + integral / s)
                    * if delay_s == 0.0 { Complex64::ONE } else { (-s * delay_s).exp() }
            }
            Self::Power { coefficient, exponent } => coefficient * s.powf(exponent),
            Self::Suspended { mass, stiffness, loss } => {
                let (inertia, suspension) = (point.s2 * mass, stiffness * point.modulus(loss));
                inertia * suspension / (inertia + suspension)
            }
        }
    }
}

/// Angular frequency, rad/s, at which a stiffness with loss and dispersion has its stated value: 200 Hz.
pub const REFERENCE_RAD_S: f64 = 2.0 * std::f64::consts::PI * 200.0;
