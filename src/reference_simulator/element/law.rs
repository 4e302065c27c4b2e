//! Laws of branches: dynamic stiffness as a function of the Laplace variable s.
//!
//! A loss factor η that does not depend on frequency must come with a stiffness that does: k (1 + (2η/π) ln(s/ω₀)) is k (1 + i η) at
//! ω₀ and has the loss η at every frequency, and unlike k (1 + i η) it is the transform of a force that follows its cause. All loss
//! factors of this module are meant so, with ω₀ = 2π · 200 rad/s, in a share of dispersion from 1 down to 0, where k (1 + i η) is left:
//! joints that lose by microslip, whatever the frequency, are nearer to that.

use num_complex::Complex64;

/// A point of the plane, with what all branches need of it.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// s
    pub s: Complex64,
    /// s²
    pub s2: Complex64,
    /// What a unit loss factor adds to 1: (2/π) ln(s/ω₀) with full dispersion, ±i with none.
    pub log: Complex64,
}

impl Spot {
    /// The spot at s, with a share of dispersion of losses.
    pub fn new(s: Complex64, dispersion: f64) -> Self {
        let causal = (s / REFERENCE_RAD_S).ln() * std::f64::consts::FRAC_2_PI;
        let constant = Complex64::new(0.0, s.im.signum());
        Self { s, s2: s * s, log: causal * dispersion + constant * (1.0 - dispersion) }
    }
}

/// Dynamic stiffness of one branch, force over the branch's motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// Spring, dashpot and loss factor side by side: k (1 + (2η/π) ln(s/ω₀)) + s c.
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
    /// Power law b s^p, as of squeezed films.
    Power {
        /// b
        coefficient: f64,
        /// p
        exponent: f64,
    },
    /// A mass hung on spring, dashpot and loss factor: s² m z / (s² m + z).
    Hung {
        /// m
        mass: f64,
        /// k
        stiffness: f64,
        /// c
        damping: f64,
        /// η
        loss: f64,
    },
}

impl Law {
    /// A spring with a loss factor.
    pub fn spring(stiffness: f64, loss: f64) -> Self {
        Self::Kelvin { stiffness, damping: 0.0, loss }
    }

    /// Dynamic stiffness at a spot.
    pub fn at(&self, spot: &Spot) -> Complex64 {
        let s = spot.s;
        match *self {
            Self::Kelvin { stiffness, damping, loss } => kelvin(spot, stiffness, damping, loss),
            Self::Mass(mass) => spot.s2 * mass,
            Self::Maxwell { stiffness, time_s } => stiffness * s * time_s / (1.0 + s * time_s),
            Self::Servo { stiffness, damping, integral, delay_s } => {
                (stiffness + s * damping + integral / s) * if delay_s == 0.0 { Complex64::ONE } else { (-s * delay_s).exp() }
            }
            Self::Power { coefficient, exponent } => coefficient * s.powf(exponent),
            Self::Hung { mass, stiffness, damping, loss } => {
                let inertia = spot.s2 * mass;
                let suspension = kelvin(spot, stiffness, damping, loss);
                inertia * suspension / (inertia + suspension)
            }
        }
    }
}

fn kelvin(spot: &Spot, stiffness: f64, damping: f64, loss: f64) -> Complex64 {
    stiffness * (1.0 + spot.log * loss) + spot.s * damping
}

/// Material loss of a shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// η
    pub factor: f64,
}

impl Loss {
    /// Factor on the modulus at a spot.
    pub fn at(&self, spot: &Spot) -> Complex64 {
        1.0 + spot.log * self.factor
    }
}

/// Frequency at which a stiffness with loss and dispersion has its stated value.
pub const REFERENCE_RAD_S: f64 = 2.0 * std::f64::consts::PI * 200.0;
