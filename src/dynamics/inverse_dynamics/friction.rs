//! Friction forces along a motion.

use crate::law::FrictionLaw;

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

impl FrictionLaw {
    /// Computes g(v, x): the friction level during sliding.
    pub fn level(&self, v: f64, x: f64) -> f64 {
        let mut level = self.coulomb + self.table.level(v);
        if self.stribeck != 0.0 && self.velocity > 0.0 {
            level += self.stribeck * (-(v.abs() / self.velocity).powf(self.exponent)).exp();
        }
        if !self.wave.is_flat() {
            level += self.wave.at(x).0;
        }
        level
    }

    /// Computes the friction force along a motion of a joint that moves by `ratio` times the given velocities
    /// and positions. In presliding the deflection z follows ż = v − σ₀·|v|/g·z, exact over a step of
    /// constant v.
    pub fn forces(&self, ratio: f64, velocity: &[f64], position: &[f64], step_s: f64) -> Vec<f64> {
        let is_constant = self.coulomb == 0.0
            && self.stribeck == 0.0
            && self.table.is_empty()
            && self.wave.is_flat()
            && self.asymmetry == 0.0;
        if is_constant {
            return vec![self.offset; velocity.len()];
        }
        let mut deflection = 0.0;
        velocity
            .iter()
            .zip(position)
            .map(|(v, x)| self.force(&mut deflection, ratio * v, ratio * x, step_s))
            .collect()
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

/// Friction forces of the joints along one motion by their last laws: most changes of a parameter leave the
/// laws of other joints as they are.
#[derive(Debug, Default)]
pub(super) struct FrictionMemory {
    /// By joint: law, ratio, and its forces.
    last: Vec<Option<(FrictionLaw, f64, Vec<f64>)>>,
}

impl FrictionMemory {
    /// Returns the friction force of a joint along the motion of this memory, given by `of` for the law at
    /// this ratio.
    pub fn forces(
        &mut self,
        joint: usize,
        law: &FrictionLaw,
        ratio: f64,
        of: impl FnOnce() -> Vec<f64>,
    ) -> Vec<f64> {
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
