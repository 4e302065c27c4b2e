//! The force that a rigid machine needs for a motion.

use super::compliant_load::CompliantLoad;
use super::friction::{FrictionForce, Ripple, sign};
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use machine::{Machine, Operating, Value};

impl Rigid {
    /// Force or torque of the drive at a constant velocity (m/s), without what depends on the position.
    pub fn steady(&self, machine: &Machine, values: &[f64], velocity_m_s: f64) -> f64 {
        let number = |value: &Value| value.at(values, &Operating::default());
        let sum: f64 = machine
            .joints
            .iter()
            .map(|joint| {
                let ratio = self.ratio(&joint.on);
                let mut law = FrictionForce::new(&joint.friction, &number);
                law.wave = None;
                let v = ratio * velocity_m_s;
                ratio * (number(&joint.damping) * v + sign(v) * law.level(v, 0.0) + law.asymmetry * v.abs() + law.offset)
            })
            .sum();
        let factor = machine.drive.as_ref().map_or(1.0, |d| number(&d.force_factor));
        sum / self.driven / factor
    }

    /// The force (N) or torque (N·m) to be recorded of the drive for a motion, sample by sample:
    ///
    /// ```text
    /// r_d·F(t) = Σ mᵢ·rᵢ²·a + Σ rⱼ·( cⱼ·rⱼ·v + frictionⱼ(rⱼ·v, rⱼ·x) )        recorded(t) = ( F(t + τ) − ripple ) / (1 + e)
    /// ```
    ///
    /// rᵢ the rate of a point, rⱼ that of a joint's combination, r_d of the driven point. Springs and errors of the lead are not in it: they move
    /// parts against each other, which [`Rigid::transmission`] tells. Where one joint has play, or an effect puts a spring in series with it, what is
    /// beyond it follows the encoder by its own equation of motion; not so where further points were recorded, whose turns count for nothing.
    ///
    /// # Units      m, s, N (or rad, N·m at a driven angle)
    /// # Errors     none; parameters out of their range give what they give
    pub fn force(&self, machine: &Machine, values: &[f64], motion: &MotionSignal) -> Vec<f64> {
        let beyond = if motion.records_points() { None } else { CompliantLoad::new(self, machine, values) };
        self.force_before(beyond.as_ref(), machine, values, motion)
    }

    /// The same where a joint (index) gives way, so many times as far as it is described to; `None` where that makes no difference to the drive, or another
    /// gives way already.
    pub fn force_giving_way(
        &self,
        (joint, times): (usize, f64),
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
    ) -> Option<Vec<f64>> {
        if motion.records_points() || CompliantLoad::new(self, machine, values).is_some() {
            return None;
        }
        let beyond = CompliantLoad::behind(joint, self, machine, values)?.softer(times);
        Some(self.force_before(Some(&beyond), machine, values, motion))
    }

    fn force_before(&self, beyond: Option<&CompliantLoad<'_>>, machine: &Machine, values: &[f64], motion: &MotionSignal) -> Vec<f64> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let Some(drive) = &machine.drive else { return vec![0.0; motion.position_m.len()] };
        let mut force = self.balance(beyond, machine, values, motion).force;
        if let Some(ripple) = Ripple::new(&drive.ripple, &number) {
            force.iter_mut().zip(&motion.position_m).for_each(|(f, x)| *f -= ripple.at(self.driven * x));
        }
        let factor = number(&drive.force_factor);
        force.iter_mut().for_each(|f| *f /= factor);
        advanced(&force, number(&drive.delay_s) / motion.step_s)
    }

    /// What moves a machine along a motion, and what resists, perhaps with something behind a joint that gives way.
    pub(super) fn balance(&self, beyond: Option<&CompliantLoad<'_>>, machine: &Machine, values: &[f64], motion: &MotionSignal) -> Balance {
        let number = |value: &Value| value.at(values, &Operating::default());
        let carried = beyond.map(|beyond| beyond.follow(self, values, motion));
        let inertia = self.inertia_of(machine, values, &|p| beyond.is_none_or(|b| !b.holds(&[(p, 1.0)])));
        let mut sum: Vec<f64> = motion.acceleration_m_s2.iter().map(|a| inertia * a).collect();
        if let Some(carried) = carried {
            sum.iter_mut().zip(carried).for_each(|(sum, force)| *sum += force);
        }
        let mut load_share = Vec::new();
        let mut rubbing = Vec::new();
        for (at, joint) in machine.joints.iter().enumerate() {
            let ratio = self.ratio(&joint.on);
            if ratio.abs() < 1e-12 || beyond.is_some_and(|b| b.holds(&joint.on)) {
                continue;
            }
            let damping = number(&joint.damping);
            let law = FrictionForce::new(&joint.friction, &number);
            let mut against = law.along(ratio, &motion.velocity_m_s, &motion.position_m, motion.step_s);
            for ((sum, v), force) in sum.iter_mut().zip(&motion.velocity_m_s).zip(&mut against) {
                *force += damping * ratio * v;
                *sum += ratio * *force;
            }
            if law.load_share > 0.0 && joint.friction.load_of.is_none() {
                load_share.push((rubbing.len(), ratio, law.load_share));
            }
            rubbing.push((at, against));
        }
        // Friction in proportion to the drive's force: F = rest + µ·|F|·sgn(v), solved for F.
        for (own, ratio, share) in load_share {
            for ((sum, v), force) in sum.iter_mut().zip(&motion.velocity_m_s).zip(&mut rubbing[own].1) {
                let against = sign(ratio.signum() * v) * sum.signum();
                let before = *sum;
                *sum /= 1.0 - ratio.abs() * share * against;
                *force += (*sum - before) / ratio;
            }
        }
        Balance { rubbing, force: sum.iter().map(|f| f / self.driven).collect() }
    }

    /// The joint (index) whose damper and friction take most work along a motion.
    pub fn rubs_most(&self, machine: &Machine, values: &[f64], motion: &MotionSignal) -> Option<usize> {
        let balance = self.balance(None, machine, values, motion);
        let work =
            |(joint, force): &(usize, Vec<f64>)| self.ratio(&machine.joints[*joint].on).abs() * force.iter().map(|f| f.abs()).sum::<f64>();
        let most = balance.rubbing.iter().max_by(|a, b| work(a).total_cmp(&work(b)))?;
        (work(most) > 0.0).then_some(most.0)
    }
}

/// What moves a machine along a motion, and what resists, sample by sample.
pub(super) struct Balance {
    /// Joints (index) whose combination moves, and the force of damper and friction along it.
    pub rubbing: Vec<(usize, Vec<f64>)>,
    /// True force (N) or torque (N·m) at the driven point, its ripple included.
    pub force: Vec<f64>,
}

/// What comes later by so many samples, between samples by straight lines.
fn advanced(x: &[f64], samples: f64) -> Vec<f64> {
    if samples == 0.0 {
        return x.to_vec();
    }
    let last = x.len() - 1;
    let at = |i: isize| x[i.clamp(0, last as isize) as usize];
    let (whole, part) = (samples.floor(), samples - samples.floor());
    (0..x.len() as isize).map(|i| (1.0 - part) * at(i + whole as isize) + part * at(i + whole as isize + 1)).collect()
}
