//! Friction laws and waves over the travel, with numerical parameters.

use machine::{Friction, FrictionTable, Value, Wave};

/// Returns the sign of a velocity: 1, −1, or 0.
pub(super) fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// A wave over the travel with numerical parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ripple {
    cosine: f64,
    sine: f64,
    wave_number: f64,
}

impl Ripple {
    /// Evaluates the parameters; `None` for zero amplitude.
    pub fn new(wave: &Wave, number: &impl Fn(&Value) -> f64) -> Option<Self> {
        let (cosine, sine, period) = (number(&wave.cosine), number(&wave.sine), number(&wave.period));
        ((cosine != 0.0 || sine != 0.0) && period > 0.0).then(|| Ripple { cosine, sine, wave_number: std::f64::consts::TAU / period })
    }

    pub fn at(&self, x: f64) -> f64 {
        let (sin, cos) = (self.wave_number * x).sin_cos();
        self.cosine * cos + self.sine * sin
    }
}

/// A friction law with numerical parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FrictionForce {
    coulomb: f64,
    pub offset: f64,
    pub asymmetry: f64,
    stribeck: f64,
    velocity: f64,
    exponent: f64,
    pub stiffness: f64,
    damping: f64,
    table: FrictionTable,
    pub wave: Option<Ripple>,
    pub load_share: f64,
}

impl FrictionForce {
    pub fn new(friction: &Friction, number: &impl Fn(&Value) -> f64) -> Self {
        FrictionForce {
            coulomb: number(&friction.coulomb),
            offset: number(&friction.offset),
            asymmetry: number(&friction.viscous_asymmetry),
            stribeck: number(&friction.stribeck),
            velocity: number(&friction.stribeck_velocity),
            exponent: number(&friction.stribeck_exponent),
            stiffness: number(&friction.presliding_stiffness),
            damping: number(&friction.presliding_damping),
            table: friction.table.clone(),
            wave: Ripple::new(&friction.position, number),
            load_share: number(&friction.load_share),
        }
    }

    /// Computes g(v, x): the friction level during sliding.
    pub fn level(&self, v: f64, x: f64) -> f64 {
        let mut level = self.coulomb + self.table.level(v);
        if self.stribeck != 0.0 && self.velocity > 0.0 {
            level += self.stribeck * (-(v.abs() / self.velocity).powf(self.exponent)).exp();
        }
        if let Some(wave) = &self.wave {
            level += wave.at(x);
        }
        level
    }

    /// Computes the friction force along a motion of a joint that moves by `ratio` times the given velocities and positions. In presliding the
    /// deflection z follows ż = v − σ₀·|v|/g·z, exact over a step of constant v.
    pub fn forces(&self, ratio: f64, velocity: &[f64], position: &[f64], step_s: f64) -> Vec<f64> {
        let is_constant =
            self.coulomb == 0.0 && self.stribeck == 0.0 && self.table.is_empty() && self.wave.is_none() && self.asymmetry == 0.0;
        if is_constant {
            return vec![self.offset; velocity.len()];
        }
        let mut deflection = 0.0;
        velocity.iter().zip(position).map(|(v, x)| self.force(&mut deflection, ratio * v, ratio * x, step_s)).collect()
    }

    /// Computes the friction force at a velocity and a position, after a step at that velocity.
    pub fn force(&self, deflection: &mut f64, v: f64, x: f64, step_s: f64) -> f64 {
        let level = self.level(v, x);
        let friction = if self.stiffness > 0.0 {
            let presliding_travel = level.max(1e-12) / self.stiffness;
            let settled = sign(v) * presliding_travel;
            let before = *deflection;
            *deflection = settled + (before - settled) * (-v.abs() * step_s / presliding_travel).exp();
            self.stiffness * *deflection + self.damping * (*deflection - before) / step_s
        } else {
            sign(v) * level
        };
        friction + self.asymmetry * v.abs() + self.offset
    }

    /// Lets the friction build up over a travel where its description has no presliding stiffness.
    pub fn build_up_over(&mut self, travel: f64) {
        if self.stiffness == 0.0 {
            self.stiffness = self.level(0.0, 0.0).max(0.0) / travel;
        }
    }
}

/// Friction forces of the joints along one motion by their last laws: most changes of a parameter leave the laws of other joints as they are.
#[derive(Debug, Default)]
pub(super) struct FrictionMemory {
    /// By joint: law, ratio, and its forces.
    last: Vec<Option<(FrictionForce, f64, Vec<f64>)>>,
}

impl FrictionMemory {
    /// Returns the friction force of a joint along the motion of this memory, given by `of` for the law at this ratio.
    pub fn forces(&mut self, joint: usize, law: &FrictionForce, ratio: f64, of: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
        if self.last.len() <= joint {
            self.last.resize_with(joint + 1, || None);
        }
        match &self.last[joint] {
            Some((known, at, forces)) if known == law && *at == ratio => forces.clone(),
            _ => {
                let forces = of();
                self.last[joint] = Some((law.clone(), ratio, forces.clone()));
                forces
            }
        }
    }
}
