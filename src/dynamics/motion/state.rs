//! Forces on a plant in one mode of its friction and play, and the energy it holds and loses.

use super::force_element::{AppliedLoad, FrictionElement, Input, along, pull};
use super::plant::Plant;

/// In which form each law acts.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct ContactMode {
    /// Frictions: sliding forward (1) or backward (−1), sticking (0); those with bristles stay 0.
    pub rubs: Vec<i8>,
    /// Plays: in contact on the upper (1) or lower (−1) side, free (0).
    pub gaps: Vec<i8>,
    /// Rate at which the linear part lets bristles relax: 2^(n/2) of it 1/s, `None` for none.
    pub relaxing: Vec<Option<i16>>,
}

/// What of the forces is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatePart {
    /// What is linear, with what is constant.
    Linear,
    /// What is not.
    Bent,
    /// All.
    Whole,
}

/// Rate (1/s) of a bristle's step on the ladder.
fn ladder(step: Option<i16>) -> f64 {
    step.map_or(0.0, |n| 2.0_f64.powf(0.5 * f64::from(n)))
}

impl Plant {
    /// Whether everything is linear between events.
    pub fn is_linear(&self) -> bool {
        self.winding.is_none_or(|w| w.d.is_none())
            && self.ripple.is_flat()
            && self.leads.is_empty()
            && self.gaps.iter().all(|g| g.wave.is_flat())
            && self.rubs.iter().all(|r| r.is_level() && r.bristle.is_none())
    }

    /// Travel of the axis per unit of the drive's point, by the encoder that sits there: a torque over it is the force along the axis.
    fn drive_travel(&self) -> f64 {
        [self.position, self.velocity].iter().find(|encoder| encoder.at == self.drive).map_or(1.0, |encoder| encoder.travel)
    }

    /// The level of a friction.
    pub fn level(&self, rub: &FrictionElement, y: &[f64], input: Input) -> f64 {
        let (q, v) = y.split_at(self.size);
        let load = match &rub.load {
            _ if rub.load_share == 0.0 => 0.0,
            AppliedLoad::Drive => self.winding.map_or(input[0], |w| w.force(y)) / self.drive_travel(),
            AppliedLoad::Joint(of, stiffness, damping, half) => {
                let stretch = along(of, q);
                let beyond = stretch - stretch.clamp(-half, *half);
                if beyond == 0.0 && *half > 0.0 { 0.0 } else { stiffness * beyond + damping * along(of, v) }
            }
        };
        rub.level(along(&rub.along, v), along(&rub.along, q), load)
    }

    /// Force by which what holds a friction may pass its level before it lets go: more than the rounding of the springs' forces there, so that what
    /// lets go also moves.
    pub fn slack(&self, rub: &FrictionElement, y: &[f64], input: Input) -> f64 {
        let n = self.size;
        let row = |i: usize| self.stiffness[i * n..(i + 1) * n].iter().zip(y).map(|(k, q)| (k * q).abs()).sum::<f64>();
        let springs: f64 = rub.along.iter().map(|&(i, c)| c.abs() * row(i)).sum();
        1e-8 * self.level(rub, y, input) + 1e-14 * springs
    }

    /// Rate of a bristle's relaxation at the state, 1/s.
    fn relaxation(&self, rub: &FrictionElement, stiffness: f64, y: &[f64], input: Input) -> f64 {
        let speed = along(&rub.along, &y[self.size..]).abs();
        let level = self.level(rub, y, input).max(f64::MIN_POSITIVE);
        if speed == 0.0 { 0.0 } else { stiffness * speed / level }
    }

    /// The bristles' ladder steps at a state: what is relaxed over a step τ by less than a tenth is left to the parabola.
    pub fn ladder_steps(&self, y: &[f64], input: Input, tau_s: f64, steps: &mut Vec<Option<i16>>) {
        steps.clear();
        for rub in &self.rubs {
            let Some(bristle) = rub.bristle else { continue };
            let rate = self.relaxation(rub, bristle.stiffness, y, input);
            steps.push((rate * tau_s > 0.1).then(|| (2.0 * rate.log2()).round().clamp(-400.0, 400.0) as i16));
        }
    }

    /// Forces of everything but what sticks, and the rates of bristles and relaxing forces into `rate[2·size..]`.
    pub fn forces(&self, mode: &ContactMode, y: &[f64], input: Input, part: StatePart, force: &mut [f64], rate: &mut [f64]) {
        force.fill(0.0);
        rate.fill(0.0);
        if part != StatePart::Bent {
            self.linear_forces(mode, y, input, force, rate);
        }
        if part != StatePart::Linear {
            self.bent_forces(mode, y, input, force, rate);
        }
    }

    fn linear_forces(&self, mode: &ContactMode, y: &[f64], input: Input, force: &mut [f64], rate: &mut [f64]) {
        let n = self.size;
        let (q, v) = (&y[..n], &y[n..2 * n]);
        force.copy_from_slice(&self.constant);
        let rows = self.stiffness.chunks_exact(n.max(1)).zip(self.damping.chunks_exact(n.max(1)));
        for (force, (k, c)) in force.iter_mut().zip(rows) {
            *force -= k.iter().zip(q).map(|(k, q)| k * q).sum::<f64>() + c.iter().zip(v).map(|(c, v)| c * v).sum::<f64>();
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
            let beyond = along(&gap.along, q) - f64::from(*side) * gap.half;
            pull(&gap.along, gap.stiffness * beyond + gap.damping * along(&gap.along, v), force);
        }
        let mut bristles = mode.relaxing.iter();
        for (rub, sign) in self.rubs.iter().zip(&mode.rubs) {
            let velocity = along(&rub.along, v);
            match rub.bristle {
                Some(bristle) => {
                    let z = y[bristle.at];
                    let slip = velocity - ladder(bristles.next().copied().flatten()) * z;
                    rate[bristle.at] = slip;
                    pull(&rub.along, bristle.stiffness * z + bristle.damping * slip, force);
                }
                None => {
                    let level = if rub.is_level() { rub.coulomb } else { 0.0 };
                    pull(&rub.along, f64::from(*sign) * (level + rub.asymmetry * velocity), force);
                }
            }
        }
        for relaxing in &self.relaxing {
            let held = y[relaxing.at];
            pull(&relaxing.along, held, force);
            rate[relaxing.at] = relaxing.stiffness * (along(&relaxing.along, v) - held / relaxing.damping);
        }
    }

    fn bent_forces(&self, mode: &ContactMode, y: &[f64], input: Input, force: &mut [f64], rate: &mut [f64]) {
        let (q, v) = (&y[..self.size], &y[self.size..2 * self.size]);
        let mut bristles = mode.relaxing.iter();
        for (rub, sign) in self.rubs.iter().zip(&mode.rubs) {
            match rub.bristle {
                Some(bristle) => {
                    let linear = ladder(bristles.next().copied().flatten());
                    let more = (linear - self.relaxation(rub, bristle.stiffness, y, input)) * y[bristle.at];
                    rate[bristle.at] += more;
                    pull(&rub.along, bristle.damping * more + rub.asymmetry * along(&rub.along, v).abs(), force);
                }
                None if *sign != 0 && !rub.is_level() => pull(&rub.along, f64::from(*sign) * self.level(rub, y, input), force),
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
        for (gap, side) in self.gaps.iter().zip(&mode.gaps).filter(|(gap, side)| **side != 0 && !gap.wave.is_flat()) {
            let (error, slope) = gap.wave.at(q[gap.travel]);
            let more = gap.stiffness * error + gap.damping * slope * v[gap.travel];
            let beyond = gap.stretch(q) - f64::from(*side) * gap.half;
            let true_force = gap.stiffness * beyond + gap.damping * (along(&gap.along, v) - slope * v[gap.travel]);
            pull(&gap.along, -more, force);
            force[gap.travel] += slope * true_force;
        }
        for lead in &self.leads {
            let ((error, slope), plain) = (lead.wave.at(q[lead.travel]), (along(&lead.along, q), along(&lead.along, v)));
            let linear = lead.stiffness * plain.0 + lead.damping * plain.1;
            let true_force = lead.stiffness * (plain.0 - error) + lead.damping * (plain.1 - slope * v[lead.travel]);
            pull(&lead.along, true_force - linear, force);
            force[lead.travel] += slope * true_force;
        }
    }

    /// Power that the drive puts in (W), where it does so through a winding.
    pub fn supplied_w(&self, y: &[f64], input: Input) -> f64 {
        self.winding.map_or(0.0, |w| {
            let (q, d) = w.currents(y);
            w.phases() * (input[0] * q + input[1] * d)
        })
    }

    /// Energy stored in masses, springs, bristles, windings and constant forces (J).
    pub fn stored_j(&self, mode: &ContactMode, y: &[f64]) -> f64 {
        let n = self.size;
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut twice = 0.0;
        for i in 0..n {
            let k = &self.stiffness[i * n..(i + 1) * n];
            twice += self.mass[i] * v[i] * v[i] + q[i] * k.iter().zip(q).map(|(k, q)| k * q).sum::<f64>() - 2.0 * self.constant[i] * q[i];
        }
        for (gap, side) in self.gaps.iter().zip(&mode.gaps).filter(|(_, side)| **side != 0) {
            twice += gap.stiffness * (gap.stretch(q) - f64::from(*side) * gap.half).powi(2);
        }
        twice += self.rubs.iter().filter_map(|r| r.bristle).map(|b| b.stiffness * y[b.at].powi(2)).sum::<f64>();
        twice += self.relaxing.iter().map(|r| y[r.at].powi(2) / r.stiffness).sum::<f64>();
        if let Some(w) = &self.winding {
            let (q, d) = w.currents(y);
            twice += w.phases() * (w.inductance_q * q * q + w.inductance_d * d * d);
        }
        for lead in &self.leads {
            let (error, stretch) = (lead.wave.at(q[lead.travel]).0, along(&lead.along, q));
            twice += lead.stiffness * ((stretch - error).powi(2) - stretch * stretch);
        }
        0.5 * twice + self.ripple.potential(q[self.drive])
    }

    /// Power lost in dampers, windings and in friction that is not level and sliding, and the rate of travel of that which is (W): the travel of a
    /// level friction is known exactly at both ends of a step.
    pub fn lost_w(&self, mode: &ContactMode, y: &[f64], input: Input) -> f64 {
        let n = self.size;
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut lost = 0.0;
        for i in 0..n {
            let c = &self.damping[i * n..(i + 1) * n];
            lost += v[i] * c.iter().zip(v).map(|(c, v)| c * v).sum::<f64>();
        }
        for (gap, _) in self.gaps.iter().zip(&mode.gaps).filter(|(_, side)| **side != 0) {
            lost += gap.damping * (along(&gap.along, v) - gap.wave.at(q[gap.travel]).1 * v[gap.travel]).powi(2);
        }
        for (rub, sign) in self.rubs.iter().zip(&mode.rubs) {
            let velocity = along(&rub.along, v);
            match rub.bristle {
                Some(bristle) => {
                    let z = y[bristle.at];
                    let slip = velocity - self.relaxation(rub, bristle.stiffness, y, input) * z;
                    lost += bristle.stiffness * z * (velocity - slip) + bristle.damping * slip * velocity;
                    lost += rub.asymmetry * velocity.abs() * velocity;
                }
                None => {
                    let level = if rub.is_level() { 0.0 } else { self.level(rub, y, input) };
                    lost += f64::from(*sign) * (level + rub.asymmetry * velocity) * velocity;
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
            let plain = along(&lead.along, v);
            lost += lead.damping * ((plain - slope * v[lead.travel]).powi(2) - plain * plain);
        }
        lost
    }

    /// Energy lost in level friction between two states of one mode (J).
    pub fn rubbed_j(&self, mode: &ContactMode, from: &[f64], to: &[f64]) -> f64 {
        let level = self.rubs.iter().zip(&mode.rubs).filter(|(rub, _)| rub.is_level() && rub.bristle.is_none());
        level.map(|(rub, sign)| f64::from(*sign) * rub.coulomb * (along(&rub.along, to) - along(&rub.along, from))).sum()
    }
}
