//! The force that a rigid machine requires for a motion.

use super::compliant_load::CompliantLoad;
use super::friction::{FrictionMemory, sign};
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use crate::law::{FrictionLaw, TravelWave};
use machine::{Machine, Operating, Value};

impl Rigid {
    /// Computes the force or torque of the drive at a constant velocity (m/s), without its position-dependent
    /// part.
    pub fn steady(&self, machine: &Machine, values: &[f64], velocity_m_s: f64) -> f64 {
        let number = |value: &Value| value.at(values, &Operating::default());
        let sum: f64 = machine
            .joints
            .iter()
            .map(|joint| {
                let ratio = self.ratio(&joint.on);
                let mut law = FrictionLaw::new(&joint.friction, &number);
                law.wave = TravelWave::default();
                let v = ratio * velocity_m_s;
                ratio
                    * (number(&joint.damping) * v
                        + sign(v) * law.level(v, 0.0)
                        + law.asymmetry * v.abs()
                        + law.offset)
            })
            .sum();
        let factor = machine.drive.as_ref().map_or(1.0, |d| number(&d.force_factor));
        sum / self.driven / factor
    }

    /// Predicts the recorded force (N) or torque (N·m) of the drive for a motion, sample by sample:
    ///
    /// ```text
    /// r_d·F(t) = Σ mᵢ·rᵢ²·a + Σ rⱼ·( cⱼ·rⱼ·v + frictionⱼ(rⱼ·v, rⱼ·x) )        recorded(t) = ( F(t + τ) − ripple ) / (1 + e)
    /// ```
    ///
    /// τ is the delay of the drive's force behind its signal, and of the recorded position behind the recorded force:
    /// where two recorders have two clocks, records cannot tell one from the other.
    ///
    /// rᵢ is the rate of a point, rⱼ that of a joint's combination, r_d that of the driven point. Springs and
    /// lead errors are not included, since they cause relative motion: [`Rigid::transmission`] predicts it.
    /// Where one joint has backlash, or an effect puts a spring in series with it, its load follows the
    /// encoder by its own equation of motion. This is omitted where extra points were recorded, whose
    /// reversals are masked.
    ///
    /// # Units      m, s, N (or rad, N·m at a driven angle)
    /// # Errors     none; parameters outside their range are not checked
    pub fn force(&self, machine: &Machine, values: &[f64], motion: &MotionSignal) -> Vec<f64> {
        self.force_remembering(machine, values, motion, &mut FrictionMemory::default())
    }

    /// As [`Rigid::force`], with the friction forces of earlier calls for this motion.
    pub(super) fn force_remembering(
        &self,
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
        memory: &mut FrictionMemory,
    ) -> Vec<f64> {
        let load = if motion.has_extra_points() { None } else { CompliantLoad::new(self, machine, values) };
        self.force_with_load(load.as_ref(), machine, values, motion, memory)
    }

    /// Predicts the force as [`Rigid::force`] with a compliant joint, given by its index and a factor on its
    /// described compliance. `None` if the joint does not separate a load from the drive, if another joint is
    /// compliant already, or if extra points were recorded.
    pub fn force_with_compliant_joint(
        &self,
        (joint, times): (usize, f64),
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
    ) -> Option<Vec<f64>> {
        if motion.has_extra_points() || CompliantLoad::new(self, machine, values).is_some() {
            return None;
        }
        let load = CompliantLoad::behind_joint(joint, self, machine, values)?.with_compliance_factor(times);
        Some(self.force_with_load(Some(&load), machine, values, motion, &mut FrictionMemory::default()))
    }

    fn force_with_load(
        &self,
        load: Option<&CompliantLoad<'_>>,
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
        memory: &mut FrictionMemory,
    ) -> Vec<f64> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let Some(drive) = &machine.drive else { return vec![0.0; motion.position_m.len()] };
        let mut force = self.balance(load, machine, values, motion, memory).force;
        let ripple = TravelWave::new(&drive.ripple, &number);
        if !ripple.is_flat() {
            force.iter_mut().zip(&motion.position_m).for_each(|(f, x)| *f -= ripple.at(self.driven * x).0);
        }
        let factor = number(&drive.force_factor);
        force.iter_mut().for_each(|f| *f /= factor);
        let delay_s = number(&drive.delay_s) + number(&machine.chain.delay);
        shifted_earlier(&force, delay_s / motion.step_s)
    }

    /// Computes driving and resisting forces along a motion, optionally with a load behind a compliant joint.
    pub(super) fn balance(
        &self,
        load: Option<&CompliantLoad<'_>>,
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
        memory: &mut FrictionMemory,
    ) -> Balance {
        let number = |value: &Value| value.at(values, &Operating::default());
        let load_force = load.map(|load| load.joint_force(self, values, motion));
        let inertia = self.inertia_of(machine, values, &|p| load.is_none_or(|b| !b.is_beyond(&[(p, 1.0)])));
        let mut sum: Vec<f64> = motion.acceleration_m_s2.iter().map(|a| inertia * a).collect();
        if let Some(load_force) = load_force {
            sum.iter_mut().zip(load_force).for_each(|(sum, force)| *sum += force);
        }
        let mut load_share = Vec::new();
        let mut resisting = Vec::new();
        for (at, joint) in machine.joints.iter().enumerate() {
            let ratio = self.ratio(&joint.on);
            if ratio.abs() < 1e-12 || load.is_some_and(|b| b.is_beyond(&joint.on)) {
                continue;
            }
            let damping = number(&joint.damping);
            let law = FrictionLaw::new(&joint.friction, &number);
            let along = || law.forces(ratio, &motion.velocity_m_s, &motion.position_m, motion.step_s);
            let mut against = memory.forces(at, &law, ratio, along);
            for ((sum, v), force) in sum.iter_mut().zip(&motion.velocity_m_s).zip(&mut against) {
                *force += damping * ratio * v;
                *sum += ratio * *force;
            }
            if law.load_share > 0.0 && joint.friction.load_of.is_none() {
                load_share.push((resisting.len(), ratio, law.load_share));
            }
            resisting.push((at, against));
        }
        // Friction proportional to the drive's force: F = F₀ + µ·|F|·sgn(v), solved for F.
        for (own, ratio, share) in load_share {
            for ((sum, v), force) in sum.iter_mut().zip(&motion.velocity_m_s).zip(&mut resisting[own].1) {
                let against = sign(ratio.signum() * v) * sum.signum();
                let before = *sum;
                *sum /= 1.0 - ratio.abs() * share * against;
                *force += (*sum - before) / ratio;
            }
        }
        Balance { resisting, force: sum.iter().map(|f| f / self.driven).collect() }
    }

    /// Finds the joint (index) whose damper and friction dissipate the most energy along a motion.
    pub fn joint_with_most_friction(
        &self,
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
    ) -> Option<usize> {
        let balance = self.balance(None, machine, values, motion, &mut FrictionMemory::default());
        let work = |(joint, force): &(usize, Vec<f64>)| {
            self.ratio(&machine.joints[*joint].on).abs() * force.iter().map(|f| f.abs()).sum::<f64>()
        };
        let most = balance.resisting.iter().max_by(|a, b| work(a).total_cmp(&work(b)))?;
        (work(most) > 0.0).then_some(most.0)
    }
}

/// Driving and resisting forces along a motion, sample by sample.
pub(super) struct Balance {
    /// Index of each moving joint, and the force of its damper and friction along its combination.
    pub resisting: Vec<(usize, Vec<f64>)>,
    /// True force (N) or torque (N·m) at the driven point, including the ripple.
    pub force: Vec<f64>,
}

/// Shifts a signal earlier by a number of samples, between them by the cubic through the nearest four.
pub fn shifted_earlier(x: &[f64], samples: f64) -> Vec<f64> {
    if samples == 0.0 {
        return x.to_vec();
    }
    let last = x.len() - 1;
    let at = |i: isize| x[i.clamp(0, last as isize) as usize];
    let (whole, t) = (samples.floor() as isize, samples - samples.floor());
    let weights = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -t * (t + 1.0) * (t - 2.0) / 2.0,
        t * (t + 1.0) * (t - 1.0) / 6.0,
    ];
    let shifted = |i: isize| (-1..).zip(weights).map(|(k, weight)| weight * at(i + whole + k)).sum();
    (0..x.len() as isize).map(shifted).collect()
}
