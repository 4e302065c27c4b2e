//! Friction, backlash and waves as numerical elements on the coordinates of a plant.

use crate::law::{FrictionLaw, TravelWave};

/// A linear combination Σ cᵢ·xᵢ of coordinates.
pub type Combination = Vec<(usize, f64)>;

/// Computes Σ cᵢ·xᵢ.
pub fn combine(of: &Combination, x: &[f64]) -> f64 {
    of.iter().map(|&(i, c)| c * x[i]).sum()
}

/// Subtracts force·c from the forces on the coordinates.
pub fn apply_force(of: &Combination, force: f64, f: &mut [f64]) {
    of.iter().for_each(|&(i, c)| f[i] -= force * c);
}

/// The load of a load-dependent friction.
#[derive(Debug, Clone, PartialEq)]
pub enum AppliedLoad {
    /// The drive's force.
    Drive,
    /// The force of a joint: its combination, stiffness, damping and half its backlash.
    Joint(Combination, f64, f64, f64),
}

/// Bristle of a friction with presliding (LuGre).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bristle {
    /// Index in the state.
    pub at: usize,
    /// σ₀.
    pub stiffness: f64,
    /// σ₁.
    pub damping: f64,
}

/// Friction of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionElement {
    pub name: String,
    pub along: Combination,
    pub law: FrictionLaw,
    pub load: AppliedLoad,
    pub bristle: Option<Bristle>,
}

impl FrictionElement {
    /// Whether its level is constant over velocity, position and load.
    pub fn is_level(&self) -> bool {
        self.law.stribeck == 0.0
            && self.law.table.is_empty()
            && self.law.wave.is_flat()
            && self.law.load_share == 0.0
    }

    /// Computes the friction level g.
    pub fn level(&self, velocity: f64, position: f64, load: f64) -> f64 {
        let law = &self.law;
        if self.is_level() {
            return law.coulomb;
        }
        let stribeck = match law.stribeck {
            0.0 => 0.0,
            excess => {
                let x = velocity.abs() / law.velocity;
                let power = if law.exponent == 1.0 {
                    x
                } else if law.exponent == 2.0 {
                    x * x
                } else {
                    x.powf(law.exponent)
                };
                excess * (-power).exp()
            }
        };
        (law.coulomb
            + stribeck
            + law.table.level(velocity)
            + law.wave.at(position).0
            + law.load_share * load.abs())
        .max(0.0)
    }
}

/// A joint with backlash.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    pub name: String,
    pub along: Combination,
    /// Half the backlash.
    pub half: f64,
    pub stiffness: f64,
    pub damping: f64,
    /// Coordinate along which the lead error varies; the wave is flat without one.
    pub travel: usize,
    pub wave: TravelWave,
}

impl Gap {
    /// Computes the deformation from mid-position, which the lead error shifts.
    pub fn stretch(&self, q: &[f64]) -> f64 {
        combine(&self.along, q) - self.wave.at(q[self.travel]).0
    }
}

/// A joint with a periodic lead error.
#[derive(Debug, Clone, PartialEq)]
pub struct Lead {
    pub along: Combination,
    /// Coordinate along which the error varies.
    pub travel: usize,
    pub stiffness: f64,
    pub damping: f64,
    pub wave: TravelWave,
}

/// A damper in series with a spring; its force is a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Relaxing {
    pub along: Combination,
    /// Index in the state.
    pub at: usize,
    pub stiffness: f64,
    pub damping: f64,
}

/// Input of the drive, held between its samples: its force, or with a winding the voltages along q and d.
pub type Input = [f64; 2];

/// Winding of the motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Indices of the currents in the state: along q (or of the armature), and along d.
    pub q: usize,
    pub d: Option<usize>,
    pub resistance: f64,
    pub inductance_q: f64,
    pub inductance_d: f64,
    /// True force per current.
    pub constant: f64,
    /// Pole pairs; 0 for a DC motor.
    pub pairs: f64,
}

impl Winding {
    /// Power per u·i: 3/2 for amplitudes of three phases.
    pub fn phases(&self) -> f64 {
        if self.d.is_some() { 1.5 } else { 1.0 }
    }

    /// Returns (i_q, i_d).
    pub fn currents(&self, y: &[f64]) -> (f64, f64) {
        (y[self.q], self.d.map_or(0.0, |d| y[d]))
    }

    /// Returns the force per product of both currents.
    pub fn reluctance(&self) -> f64 {
        1.5 * self.pairs * (self.inductance_d - self.inductance_q)
    }

    /// Computes the force on the driven point.
    pub fn force(&self, y: &[f64]) -> f64 {
        let (q, d) = self.currents(y);
        self.constant * q + self.reluctance() * q * d
    }

    /// Returns the induced voltage per rate of the driven point.
    pub fn induced(&self) -> f64 {
        self.constant / self.phases()
    }
}
