//! Friction, play and waves, as numbers on the coordinates of a plant.

/// A combination Σ cᵢ·xᵢ of coordinates.
pub type Along = Vec<(usize, f64)>;

/// Σ cᵢ·xᵢ.
pub fn along(of: &Along, x: &[f64]) -> f64 {
    of.iter().map(|&(i, c)| c * x[i]).sum()
}

/// f −= force·c.
pub fn pull(of: &Along, force: f64, f: &mut [f64]) {
    of.iter().for_each(|&(i, c)| f[i] -= force * c);
}

/// c·cos(ωx) + s·sin(ωx).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TravelWave {
    pub cosine: f64,
    pub sine: f64,
    /// ω = 2π/period.
    pub rate: f64,
}

impl TravelWave {
    pub fn is_flat(&self) -> bool {
        self.cosine == 0.0 && self.sine == 0.0
    }

    /// Its value and slope.
    pub fn at(&self, x: f64) -> (f64, f64) {
        if self.is_flat() {
            return (0.0, 0.0);
        }
        let (sin, cos) = (self.rate * x).sin_cos();
        (self.cosine * cos + self.sine * sin, self.rate * (self.sine * cos - self.cosine * sin))
    }

    /// The potential −∫ of it as a force, without its constant.
    pub fn potential(&self, x: f64) -> f64 {
        if self.is_flat() {
            return 0.0;
        }
        let (sin, cos) = (self.rate * x).sin_cos();
        (self.sine * cos - self.cosine * sin) / self.rate
    }
}

/// What loads a friction.
#[derive(Debug, Clone, PartialEq)]
pub enum AppliedLoad {
    /// The drive's force.
    Drive,
    /// The force of a joint: the combination, its stiffness, its damping and half its play.
    Joint(Along, f64, f64, f64),
}

/// Bristles of a friction with presliding (LuGre).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bristle {
    /// Its place in the state.
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
    pub along: Along,
    pub coulomb: f64,
    pub asymmetry: f64,
    pub stribeck: f64,
    pub velocity: f64,
    pub exponent: f64,
    pub wave: TravelWave,
    pub load_share: f64,
    pub load: AppliedLoad,
    pub bristle: Option<Bristle>,
}

impl FrictionElement {
    /// Whether its level is the same at all velocities, positions and loads.
    pub fn is_level(&self) -> bool {
        self.stribeck == 0.0 && self.wave.is_flat() && self.load_share == 0.0
    }

    /// Its level g.
    pub fn level(&self, velocity: f64, position: f64, load: f64) -> f64 {
        if self.is_level() {
            return self.coulomb;
        }
        let stribeck = match self.stribeck {
            0.0 => 0.0,
            excess => {
                let x = velocity.abs() / self.velocity;
                let power = if self.exponent == 1.0 {
                    x
                } else if self.exponent == 2.0 {
                    x * x
                } else {
                    x.powf(self.exponent)
                };
                excess * (-power).exp()
            }
        };
        (self.coulomb + stribeck + self.wave.at(position).0 + self.load_share * load.abs()).max(0.0)
    }
}

/// A joint with play.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    pub name: String,
    pub along: Along,
    /// Half its width.
    pub half: f64,
    pub stiffness: f64,
    pub damping: f64,
    /// Error of its lead along a coordinate; flat for none.
    pub travel: usize,
    pub wave: TravelWave,
}

impl Gap {
    /// How far it is from its middle: the lead's error moves that.
    pub fn stretch(&self, q: &[f64]) -> f64 {
        along(&self.along, q) - self.wave.at(q[self.travel]).0
    }
}

/// A joint whose lead has an error that repeats.
#[derive(Debug, Clone, PartialEq)]
pub struct Lead {
    pub along: Along,
    /// The coordinate along which it repeats.
    pub travel: usize,
    pub stiffness: f64,
    pub damping: f64,
    pub wave: TravelWave,
}

/// A damper behind a spring: its force is a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Relaxing {
    pub along: Along,
    /// Its place in the state.
    pub at: usize,
    pub stiffness: f64,
    pub damping: f64,
}

/// What the drive puts into a plant, held between its samples: its force, or with a winding the voltages along q and d.
pub type Input = [f64; 2];

/// The winding of the motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Places of the currents in the state: along q (or of the armature), and along d.
    pub q: usize,
    pub d: Option<usize>,
    pub resistance: f64,
    pub inductance_q: f64,
    pub inductance_d: f64,
    /// True force per current.
    pub constant: f64,
    /// Pole pairs; 0 for direct current.
    pub pairs: f64,
}

impl Winding {
    /// Share of u·i that is power: 3/2 for amplitudes of three phases.
    pub fn phases(&self) -> f64 {
        if self.d.is_some() { 1.5 } else { 1.0 }
    }

    /// (i_q, i_d).
    pub fn currents(&self, y: &[f64]) -> (f64, f64) {
        (y[self.q], self.d.map_or(0.0, |d| y[d]))
    }

    /// Force per the product of both currents.
    pub fn reluctance(&self) -> f64 {
        1.5 * self.pairs * (self.inductance_d - self.inductance_q)
    }

    /// Force on the driven point.
    pub fn force(&self, y: &[f64]) -> f64 {
        let (q, d) = self.currents(y);
        self.constant * q + self.reluctance() * q * d
    }

    /// Voltage per rate of the driven point.
    pub fn induced(&self) -> f64 {
        self.constant / self.phases()
    }
}
