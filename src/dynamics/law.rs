//! Waves over the travel and friction laws with numbers in place of parameters, for motion in time and for
//! inverse dynamics.

use machine::{Friction, FrictionTable, Value, Wave};

/// A wave c·cos(ωx) + s·sin(ωx) over the travel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TravelWave {
    pub cosine: f64,
    pub sine: f64,
    /// ω = 2π/period.
    pub rate: f64,
}

impl TravelWave {
    /// Evaluates the parameters of a wave; one without a period is flat.
    pub fn new(wave: &Wave, number: &impl Fn(&Value) -> f64) -> Self {
        let period = number(&wave.period);
        if !(period > 0.0) {
            return TravelWave::default();
        }
        TravelWave {
            cosine: number(&wave.cosine),
            sine: number(&wave.sine),
            rate: std::f64::consts::TAU / period,
        }
    }

    pub fn is_flat(&self) -> bool {
        self.cosine == 0.0 && self.sine == 0.0
    }

    /// Computes value and slope.
    pub fn at(&self, x: f64) -> (f64, f64) {
        if self.is_flat() {
            return (0.0, 0.0);
        }
        let (sin, cos) = (self.rate * x).sin_cos();
        (self.cosine * cos + self.sine * sin, self.rate * (self.sine * cos - self.cosine * sin))
    }

    /// Computes the potential −∫ of the wave taken as a force, without its constant.
    pub fn potential(&self, x: f64) -> f64 {
        if self.is_flat() {
            return 0.0;
        }
        let (sin, cos) = (self.rate * x).sin_cos();
        (self.sine * cos - self.cosine * sin) / self.rate
    }
}

/// The numbers of a friction law.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionLaw {
    pub coulomb: f64,
    pub offset: f64,
    pub asymmetry: f64,
    pub stribeck: f64,
    /// Stribeck velocity and exponent.
    pub velocity: f64,
    pub exponent: f64,
    /// Presliding stiffness and damping.
    pub stiffness: f64,
    pub damping: f64,
    pub table: FrictionTable,
    pub wave: TravelWave,
    pub load_share: f64,
}

impl FrictionLaw {
    /// Evaluates the parameters of a friction.
    pub fn new(friction: &Friction, number: &impl Fn(&Value) -> f64) -> Self {
        FrictionLaw {
            coulomb: number(&friction.coulomb),
            offset: number(&friction.offset),
            asymmetry: number(&friction.viscous_asymmetry),
            stribeck: number(&friction.stribeck),
            velocity: number(&friction.stribeck_velocity),
            exponent: number(&friction.stribeck_exponent),
            stiffness: number(&friction.presliding_stiffness),
            damping: number(&friction.presliding_damping),
            table: friction.table.clone(),
            wave: TravelWave::new(&friction.position, number),
            load_share: number(&friction.load_share),
        }
    }
}
