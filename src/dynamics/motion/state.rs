//! Forces on a plant in one mode of its friction and backlash, and its stored and lost energy.

use super::force_element::{AppliedLoad, FrictionElement, Input, apply_force, combine};
use super::plant::Plant;

/// The mode of each law.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct ContactMode {
    /// Frictions: sliding forward (1) or backward (−1), sticking (0); those with bristles stay 0.
    pub frictions: Vec<i8>,
    /// Backlashes: in contact on the upper (1) or lower (−1) side, free (0).
    pub gaps: Vec<i8>,
    /// Relaxation rate of the bristles in the linear part: 2^(n/2) per second, `None` for none.
    pub relaxing: Vec<Option<i16>>,
}

/// Part of the forces to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatePart {
    /// Linear and constant forces.
    Linear,
    /// Nonlinear forces.
    Nonlinear,
    /// All forces.
    All,
}

/// Returns the relaxation rate (1/s) of a ladder step.
fn ladder(step: Option<i16>) -> f64 {
    step.map_or(0.0, |n| 2.0_f64.powf(0.5 * f64::from(n)))
}

impl Plant {
    /// Whether the plant is linear between events.
    pub fn is_linear(&self) -> bool {
        self.winding.is_none_or(|w| w.d.is_none())
            && self.ripple.is_flat()
            && self.leads.is_empty()
            && self.gaps.iter().all(|g| g.wave.is_flat())
            && self.frictions.iter().all(|r| r.is_level() && r.bristle.is_none())
    }

    /// Returns the travel of the axis per unit of the driven point, from an encoder there. It converts a
    /// torque to the force along the axis.
    fn drive_travel(&self) -> f64 {
        [self.position, self.velocity]
            .iter()
            .find(|encoder| encoder.at == self.drive)
            .map_or(1.0, |encoder| encoder.travel)
    }

    /// Computes the level of a friction.
    pub fn level(&self, friction: &FrictionElement, y: &[f64], input: Input) -> f64 {
        let (q, v) = y.split_at(self.size);
        let load = match &friction.load {
            _ if friction.law.load_share == 0.0 => 0.0,
            AppliedLoad::Drive => self.winding.map_or(input[0], |w| w.force(y)) / self.drive_travel(),
            AppliedLoad::Joint(of, stiffness, damping, half) => {
                let stretch = combine(of, q);
                let beyond = stretch - stretch.clamp(-half, *half);
                if beyond == 0.0 && *half > 0.0 { 0.0 } else { stiffness * beyond + damping * combine(of, v) }
            }
        };
        friction.level(combine(&friction.along, v), combine(&friction.along, q), load)
    }

    /// Computes the force by which a holding force may exceed the friction level before the friction is
    /// released. It exceeds the rounding of the spring forces, so that a released friction also moves.
    pub fn slack(&self, friction: &FrictionElement, y: &[f64], input: Input) -> f64 {
        let n = self.size;
        let row = |i: usize| {
            self.stiffness[i * n..(i + 1) * n].iter().zip(y).map(|(k, q)| (k * q).abs()).sum::<f64>()
        };
        let springs: f64 = friction.along.iter().map(|&(i, c)| c.abs() * row(i)).sum();
        1e-8 * self.level(friction, y, input) + 1e-14 * springs
    }

    /// Computes the relaxation rate of a bristle (1/s).
    fn relaxation(&self, friction: &FrictionElement, stiffness: f64, y: &[f64], input: Input) -> f64 {
        let speed = combine(&friction.along, &y[self.size..]).abs();
        let level = self.level(friction, y, input).max(f64::MIN_POSITIVE);
        if speed == 0.0 { 0.0 } else { stiffness * speed / level }
    }

    /// Computes the ladder steps of the bristles. A relaxation below a tenth over a step τ is left to the
    /// parabola.
    pub fn ladder_steps(&self, y: &[f64], input: Input, tau_s: f64, steps: &mut Vec<Option<i16>>) {
        steps.clear();
        for friction in &self.frictions {
            let Some(bristle) = friction.bristle else { continue };
            let rate = self.relaxation(friction, bristle.stiffness, y, input);
            steps.push((rate * tau_s > 0.1).then(|| (2.0 * rate.log2()).round().clamp(-400.0, 400.0) as i16));
        }
    }

    /// Computes the forces of all elements except sticking frictions, and the rates of bristles, relaxing
    /// forces and currents in `rate[2·size..]`.
    pub fn forces(
        &self,
        mode: &ContactMode,
        y: &[f64],
        input: Input,
        part: StatePart,
        force: &mut [f64],
        rate: &mut [f64],
    ) {
        force.fill(0.0);
        rate.fill(0.0);
        if part != StatePart::Nonlinear {
            self.linear_forces(mode, y, input, force, rate);
        }
        if part != StatePart::Linear {
            self.nonlinear_forces(mode, y, input, force, rate);
        }
    }

    fn linear_forces(
        &self,
        mode: &ContactMode,
        y: &[f64],
        input: Input,
        force: &mut [f64],
        rate: &mut [f64],
    ) {
        let n = self.size;
        let (q, v) = (&y[..n], &y[n..2 * n]);
        force.copy_from_slice(&self.constant);
        let rows = self.stiffness.chunks_exact(n.max(1)).zip(self.damping.chunks_exact(n.max(1)));
        for (force, (k, c)) in force.iter_mut().zip(rows) {
            *force -= k.iter().zip(q).map(|(k, q)| k * q).sum::<f64>()
                + c.iter().zip(v).map(|(c, v)| c * v).sum::<f64>();
        }
        match &self.winding {
            None => force[self.drive] += input[0],
            Some(w) => {
                force[self.drive] += w.constant * y[w.q];
                rate[w.q] = (input[0] - w.resistance * y[w.q] - w.induced() * v[self.drive]) / w.inductance_q;
                if let Some(d) = w.d {
                    rate[d] = (input[1] - w.resistance * y[d]) / w.inductance_d;
                }
            }
        }
        for (gap, side) in self.gaps.iter().zip(&mode.gaps).filter(|(_, side)| **side != 0) {
            let beyond = combine(&gap.along, q) - f64::from(*side) * gap.half;
            apply_force(&gap.along, gap.stiffness * beyond + gap.damping * combine(&gap.along, v), force);
        }
        let mut bristles = mode.relaxing.iter();
        for (friction, sign) in self.frictions.iter().zip(&mode.frictions) {
            let velocity = combine(&friction.along, v);
            match friction.bristle {
                Some(bristle) => {
                    let z = y[bristle.at];
                    let slip = velocity - ladder(bristles.next().copied().flatten()) * z;
                    rate[bristle.at] = slip;
                    apply_force(&friction.along, bristle.stiffness * z + bristle.damping * slip, force);
                }
                None => {
                    let level = if friction.is_level() { friction.law.coulomb } else { 0.0 };
                    apply_force(
                        &friction.along,
                        f64::from(*sign) * (level + friction.law.asymmetry * velocity),
                        force,
                    );
                }
            }
        }
        for relaxing in &self.relaxing {
            let held = y[relaxing.at];
            apply_force(&relaxing.along, held, force);
            rate[relaxing.at] = relaxing.stiffness * (combine(&relaxing.along, v) - held / relaxing.damping);
        }
    }

    fn nonlinear_forces(
        &self,
        mode: &ContactMode,
        y: &[f64],
        input: Input,
        force: &mut [f64],
        rate: &mut [f64],
    ) {
        let (q, v) = (&y[..self.size], &y[self.size..2 * self.size]);
        let mut bristles = mode.relaxing.iter();
        for (friction, sign) in self.frictions.iter().zip(&mode.frictions) {
            match friction.bristle {
                Some(bristle) => {
                    let linear = ladder(bristles.next().copied().flatten());
                    let correction =
                        (linear - self.relaxation(friction, bristle.stiffness, y, input)) * y[bristle.at];
                    rate[bristle.at] += correction;
                    apply_force(
                        &friction.along,
                        bristle.damping * correction
                            + friction.law.asymmetry * combine(&friction.along, v).abs(),
                        force,
                    );
                }
                None if *sign != 0 && !friction.is_level() => {
                    apply_force(&friction.along, f64::from(*sign) * self.level(friction, y, input), force)
                }
                None => {}
            }
        }
        force[self.drive] += self.ripple.at(q[self.drive]).0;
        if let Some((w, d)) = self.winding.as_ref().and_then(|w| Some((w, w.d?))) {
            let turning = w.pairs * v[self.drive];
            force[self.drive] += w.reluctance() * y[w.q] * y[d];
            rate[w.q] -= turning * w.inductance_d * y[d] / w.inductance_q;
            rate[d] += turning * w.inductance_q * y[w.q] / w.inductance_d;
        }
        for (gap, side) in
            self.gaps.iter().zip(&mode.gaps).filter(|(gap, side)| **side != 0 && !gap.wave.is_flat())
        {
            let (error, slope) = gap.wave.at(q[gap.travel]);
            let correction = gap.stiffness * error + gap.damping * slope * v[gap.travel];
            let beyond = gap.stretch(q) - f64::from(*side) * gap.half;
            let true_force =
                gap.stiffness * beyond + gap.damping * (combine(&gap.along, v) - slope * v[gap.travel]);
            apply_force(&gap.along, -correction, force);
            force[gap.travel] += slope * true_force;
        }
        for lead in &self.leads {
            let ((error, slope), linear_part) =
                (lead.wave.at(q[lead.travel]), (combine(&lead.along, q), combine(&lead.along, v)));
            let linear = lead.stiffness * linear_part.0 + lead.damping * linear_part.1;
            let true_force = lead.stiffness * (linear_part.0 - error)
                + lead.damping * (linear_part.1 - slope * v[lead.travel]);
            apply_force(&lead.along, true_force - linear, force);
            force[lead.travel] += slope * true_force;
        }
    }

    /// Power (W) supplied by the drive through a winding.
    pub fn supplied_w(&self, y: &[f64], input: Input) -> f64 {
        self.winding.map_or(0.0, |w| {
            let (q, d) = w.currents(y);
            w.phases() * (input[0] * q + input[1] * d)
        })
    }

    /// Computes the energy stored in masses, springs, bristles, windings and constant forces (J).
    pub fn stored_j(&self, mode: &ContactMode, y: &[f64]) -> f64 {
        let n = self.size;
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut twice = 0.0;
        for i in 0..n {
            let k = &self.stiffness[i * n..(i + 1) * n];
            twice += self.mass[i] * v[i] * v[i] + q[i] * k.iter().zip(q).map(|(k, q)| k * q).sum::<f64>()
                - 2.0 * self.constant[i] * q[i];
        }
        for (gap, side) in self.gaps.iter().zip(&mode.gaps).filter(|(_, side)| **side != 0) {
            twice += gap.stiffness * (gap.stretch(q) - f64::from(*side) * gap.half).powi(2);
        }
        twice += self
            .frictions
            .iter()
            .filter_map(|r| r.bristle)
            .map(|b| b.stiffness * y[b.at].powi(2))
            .sum::<f64>();
        twice += self.relaxing.iter().map(|r| y[r.at].powi(2) / r.stiffness).sum::<f64>();
        if let Some(w) = &self.winding {
            let (q, d) = w.currents(y);
            twice += w.phases() * (w.inductance_q * q * q + w.inductance_d * d * d);
        }
        for lead in &self.leads {
            let (error, stretch) = (lead.wave.at(q[lead.travel]).0, combine(&lead.along, q));
            twice += lead.stiffness * ((stretch - error).powi(2) - stretch * stretch);
        }
        0.5 * twice + self.ripple.potential(q[self.drive])
    }

    /// Computes the power lost in dampers, windings and frictions (W), without the constant level of sliding
    /// frictions.
    /// [`Plant::level_friction_loss_j`] gives that loss exactly from the travel.
    pub fn lost_w(&self, mode: &ContactMode, y: &[f64], input: Input) -> f64 {
        let n = self.size;
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut lost = 0.0;
        for i in 0..n {
            let c = &self.damping[i * n..(i + 1) * n];
            lost += v[i] * c.iter().zip(v).map(|(c, v)| c * v).sum::<f64>();
        }
        for (gap, _) in self.gaps.iter().zip(&mode.gaps).filter(|(_, side)| **side != 0) {
            lost +=
                gap.damping * (combine(&gap.along, v) - gap.wave.at(q[gap.travel]).1 * v[gap.travel]).powi(2);
        }
        for (friction, sign) in self.frictions.iter().zip(&mode.frictions) {
            let velocity = combine(&friction.along, v);
            match friction.bristle {
                Some(bristle) => {
                    let z = y[bristle.at];
                    let slip = velocity - self.relaxation(friction, bristle.stiffness, y, input) * z;
                    lost += bristle.stiffness * z * (velocity - slip) + bristle.damping * slip * velocity;
                    lost += friction.law.asymmetry * velocity.abs() * velocity;
                }
                None => {
                    let level = if friction.is_level() { 0.0 } else { self.level(friction, y, input) };
                    lost += f64::from(*sign) * (level + friction.law.asymmetry * velocity) * velocity;
                }
            }
        }
        lost += self.relaxing.iter().map(|r| y[r.at].powi(2) / r.damping).sum::<f64>();
        if let Some(w) = &self.winding {
            let (q, d) = w.currents(y);
            lost += w.phases() * w.resistance * (q * q + d * d);
        }
        for lead in &self.leads {
            let slope = lead.wave.at(q[lead.travel]).1;
            let linear_part = combine(&lead.along, v);
            lost +=
                lead.damping * ((linear_part - slope * v[lead.travel]).powi(2) - linear_part * linear_part);
        }
        lost
    }

    /// Computes the energy lost to the constant level of sliding frictions between two states of one mode
    /// (J).
    pub fn level_friction_loss_j(&self, mode: &ContactMode, from: &[f64], to: &[f64]) -> f64 {
        let level = self
            .frictions
            .iter()
            .zip(&mode.frictions)
            .filter(|(friction, _)| friction.is_level() && friction.bristle.is_none());
        level
            .map(|(friction, sign)| {
                f64::from(*sign)
                    * friction.law.coulomb
                    * (combine(&friction.along, to) - combine(&friction.along, from))
            })
            .sum()
    }
}
