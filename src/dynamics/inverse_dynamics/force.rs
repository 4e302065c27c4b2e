//! The force that a rigid machine needs for a motion.

use nalgebra::DMatrix;

use super::beyond::Beyond;
use super::error::InverseError;
use super::recipe::Motion;
use machine::{Friction, Machine, Motion as Kind, Operating, Value, Wave};

/// A machine whose moving points keep in step: how fast each moves beside what the position encoder reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Rigid {
    /// Rate of each point over that of the reading.
    ratios: Vec<f64>,
    /// The same of the driven point.
    driven: f64,
}

impl Rigid {
    /// The one motion that deforms neither a spring nor a shaft of the machine, scaled to one of the position encoder.
    ///
    /// # Errors  the machine has no drive, or can move otherwise, or not at all.
    pub fn new(machine: &Machine, values: &[f64]) -> Result<Self, InverseError> {
        let drive = machine.drive.as_ref().ok_or(InverseError::NoDrive)?;
        let count = machine.points.len();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut tie = |on: &[(usize, f64)]| {
            let mut row = vec![0.0; count];
            on.iter().for_each(|(point, c)| row[*point] += c);
            rows.push(row);
        };
        machine.points.iter().enumerate().filter(|(_, p)| p.fixed).for_each(|(i, _)| tie(&[(i, 1.0)]));
        for joint in &machine.joints {
            if joint.stiffness.at(values, &Operating::default()) > 0.0 {
                tie(&joint.on);
            }
        }
        for shaft in &machine.shafts {
            for pair in shaft.stations.windows(2) {
                for (a, b) in [(pair[0].axial, pair[1].axial), (pair[0].torsion, pair[1].torsion)] {
                    if let (Some(a), Some(b)) = (a, b) {
                        tie(&[(a, 1.0), (b, -1.0)]);
                    }
                }
            }
        }
        // The null space of the ties: eigenvectors of Tᵀ·T to eigenvalue 0.
        let ties = DMatrix::from_fn(rows.len(), count, |i, j| rows[i][j]);
        let eigen = (ties.transpose() * &ties).symmetric_eigen();
        let largest = eigen.eigenvalues.iter().fold(1.0_f64, |m, x| m.max(*x));
        let free: Vec<usize> = (0..count).filter(|i| eigen.eigenvalues[*i] < 1e-12 * largest).collect();
        let [only] = free[..] else {
            let fault = format!("{} motions deform no spring and no shaft of it", free.len());
            return Err(InverseError::NotRigid { fault });
        };
        let shape = eigen.eigenvectors.column(only);
        let encoder = &drive.position.encoder;
        let reading = encoder.travel * shape[encoder.at];
        if !(reading.abs() > 1e-9 && shape[drive.on].abs() > 1e-9) {
            let fault = "neither its drive nor its encoder moves where no spring is deformed".to_string();
            return Err(InverseError::NotRigid { fault });
        }
        let ratios: Vec<f64> = shape.iter().map(|x| x / reading).collect();
        Ok(Rigid { driven: ratios[drive.on], ratios })
    }

    /// Checks that a record gives what the drive gives.
    ///
    /// # Errors  a force is recorded where the drive turns, or a torque where it does not.
    pub fn check(&self, machine: &Machine, motion: &Motion) -> Result<(), InverseError> {
        let drive = machine.drive.as_ref().ok_or(InverseError::NoDrive)?;
        let point = &machine.points[drive.on];
        let wanted = if point.motion == Kind::Translation { "force_n" } else { "torque_nm" };
        if motion.load_column == wanted {
            return Ok(());
        }
        Err(InverseError::Load { path: motion.source.clone(), given: motion.load_column, wanted, point: point.name.clone() })
    }

    /// Force (N) or torque (N·m) of the drive per acceleration of the reading (m/s²).
    pub fn inertia(&self, machine: &Machine, values: &[f64]) -> f64 {
        self.inertia_of(machine, values, &|_| true) / self.driven
    }

    /// Mass (kg) felt at the reading of some of the points, with the shafts between them.
    pub(super) fn inertia_of(&self, machine: &Machine, values: &[f64], counts: &dyn Fn(usize) -> bool) -> f64 {
        let at = Operating::default();
        let own = machine.points.iter().zip(&self.ratios).enumerate().filter(|(i, _)| counts(*i));
        let mut inertia: f64 = own.map(|(_, (p, r))| p.inertia.at(values, &at) * r * r).sum();
        for shaft in &machine.shafts {
            for (kind, point) in [
                (Kind::Translation, shaft.stations.iter().find_map(|s| s.axial)),
                (Kind::Rotation, shaft.stations.iter().find_map(|s| s.torsion)),
            ] {
                let ratio = point.filter(|p| counts(*p)).map_or(0.0, |p| self.ratios[p]);
                inertia += shaft.inertia(kind, values, &at) * ratio * ratio;
            }
        }
        inertia
    }

    /// Force or torque of the drive at a constant velocity (m/s), without what depends on the position.
    pub fn steady(&self, machine: &Machine, values: &[f64], velocity_m_s: f64) -> f64 {
        let number = |value: &Value| value.at(values, &Operating::default());
        let sum: f64 = machine
            .joints
            .iter()
            .map(|joint| {
                let ratio: f64 = joint.on.iter().map(|(point, c)| c * self.ratios[*point]).sum();
                let law = Law { wave: None, ..Law::new(&joint.friction, &number) };
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
    pub fn force(&self, machine: &Machine, values: &[f64], motion: &Motion) -> Vec<f64> {
        let beyond = if motion.records_points() { None } else { Beyond::new(self, machine, values) };
        self.force_before(beyond.as_ref(), machine, values, motion)
    }

    /// The same where a joint (index) gives way, so many times as far as it is described to; `None` where that makes no difference to the drive, or another
    /// gives way already.
    pub fn force_giving_way(&self, (joint, times): (usize, f64), machine: &Machine, values: &[f64], motion: &Motion) -> Option<Vec<f64>> {
        if motion.records_points() || Beyond::new(self, machine, values).is_some() {
            return None;
        }
        let beyond = Beyond::behind(joint, self, machine, values)?.softer(times);
        Some(self.force_before(Some(&beyond), machine, values, motion))
    }

    fn force_before(&self, beyond: Option<&Beyond<'_>>, machine: &Machine, values: &[f64], motion: &Motion) -> Vec<f64> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let Some(drive) = &machine.drive else { return vec![0.0; motion.position_m.len()] };
        let mut force = self.balance(beyond, machine, values, motion).force;
        if let Some(ripple) = Waved::new(&drive.ripple, &number) {
            force.iter_mut().zip(&motion.position_m).for_each(|(f, x)| *f -= ripple.at(self.driven * x));
        }
        let factor = number(&drive.force_factor);
        force.iter_mut().for_each(|f| *f /= factor);
        advanced(&force, number(&drive.delay_s) / motion.step_s)
    }

    /// What moves a machine along a motion, and what resists, perhaps with something behind a joint that gives way.
    pub(super) fn balance(&self, beyond: Option<&Beyond<'_>>, machine: &Machine, values: &[f64], motion: &Motion) -> Balance {
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
            let law = Law::new(&joint.friction, &number);
            let travel = Travel { ratio, motion };
            let mut against = law.along(&travel);
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

    /// The point that weighs most at the reading.
    pub fn heaviest(&self, machine: &Machine, values: &[f64]) -> Option<usize> {
        let weight = |i: &usize| self.inertia_of(machine, values, &|p| p == *i);
        (0..machine.points.len()).max_by(|a, b| weight(a).total_cmp(&weight(b)))
    }

    /// The joint (index) whose damper and friction take most work along a motion.
    pub fn rubs_most(&self, machine: &Machine, values: &[f64], motion: &Motion) -> Option<usize> {
        let balance = self.balance(None, machine, values, motion);
        let work =
            |(joint, force): &(usize, Vec<f64>)| self.ratio(&machine.joints[*joint].on).abs() * force.iter().map(|f| f.abs()).sum::<f64>();
        let most = balance.rubbing.iter().max_by(|a, b| work(a).total_cmp(&work(b)))?;
        (work(most) > 0.0).then_some(most.0)
    }

    /// Rate of a joint's combination over that of the reading.
    pub fn ratio(&self, on: &[(usize, f64)]) -> f64 {
        on.iter().map(|(point, c)| c * self.ratios[*point]).sum()
    }

    /// Rate of a point over that of the reading.
    pub fn point_ratio(&self, point: usize) -> f64 {
        self.ratios[point]
    }
}

/// What moves a machine along a motion, and what resists, sample by sample.
pub(super) struct Balance {
    /// Joints (index) whose combination moves, and the force of damper and friction along it.
    pub rubbing: Vec<(usize, Vec<f64>)>,
    /// True force (N) or torque (N·m) at the driven point, its ripple included.
    pub force: Vec<f64>,
}

pub(super) fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
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

/// A wave with its numbers.
pub(super) struct Waved {
    cosine: f64,
    sine: f64,
    wave_number: f64,
}

impl Waved {
    /// `None` where it has no height.
    pub fn new(wave: &Wave, number: &impl Fn(&Value) -> f64) -> Option<Self> {
        let (cosine, sine, period) = (number(&wave.cosine), number(&wave.sine), number(&wave.period));
        ((cosine != 0.0 || sine != 0.0) && period > 0.0).then(|| Waved { cosine, sine, wave_number: std::f64::consts::TAU / period })
    }

    pub fn at(&self, x: f64) -> f64 {
        let (sin, cos) = (self.wave_number * x).sin_cos();
        self.cosine * cos + self.sine * sin
    }
}

/// Position and velocity of a joint's combination.
struct Travel<'m> {
    ratio: f64,
    motion: &'m Motion,
}

/// A friction law with its numbers.
pub(super) struct Law {
    coulomb: f64,
    offset: f64,
    asymmetry: f64,
    stribeck: f64,
    velocity: f64,
    exponent: f64,
    pub stiffness: f64,
    damping: f64,
    wave: Option<Waved>,
    load_share: f64,
}

impl Law {
    pub fn new(friction: &Friction, number: &impl Fn(&Value) -> f64) -> Self {
        Law {
            coulomb: number(&friction.coulomb),
            offset: number(&friction.offset),
            asymmetry: number(&friction.viscous_asymmetry),
            stribeck: number(&friction.stribeck),
            velocity: number(&friction.stribeck_velocity),
            exponent: number(&friction.stribeck_exponent),
            stiffness: number(&friction.presliding_stiffness),
            damping: number(&friction.presliding_damping),
            wave: Waved::new(&friction.position, number),
            load_share: number(&friction.load_share),
        }
    }

    /// g(v, x): the level at which it slides.
    fn level(&self, v: f64, x: f64) -> f64 {
        let mut level = self.coulomb;
        if self.stribeck != 0.0 && self.velocity > 0.0 {
            level += self.stribeck * (-(v.abs() / self.velocity).powf(self.exponent)).exp();
        }
        if let Some(wave) = &self.wave {
            level += wave.at(x);
        }
        level
    }

    /// Its force along a motion. Before sliding the deflection z follows ż = v − σ₀·|v|/g·z, exact over a step of constant v.
    fn along(&self, travel: &Travel<'_>) -> Vec<f64> {
        let motion = travel.motion;
        let still = self.coulomb == 0.0 && self.stribeck == 0.0 && self.wave.is_none() && self.asymmetry == 0.0;
        if still {
            return vec![self.offset; motion.velocity_m_s.len()];
        }
        let mut deflection = 0.0;
        motion
            .velocity_m_s
            .iter()
            .zip(&motion.position_m)
            .map(|(v, x)| self.slide(&mut deflection, travel.ratio * v, travel.ratio * x, motion.step_s))
            .collect()
    }

    /// Its force at a velocity and a position, after a step of that velocity.
    pub fn slide(&self, deflection: &mut f64, v: f64, x: f64, step_s: f64) -> f64 {
        let level = self.level(v, x);
        let rubbing = if self.stiffness > 0.0 {
            let held = level.max(1e-12) / self.stiffness;
            let settled = sign(v) * held;
            let before = *deflection;
            *deflection = settled + (before - settled) * (-v.abs() * step_s / held).exp();
            self.stiffness * *deflection + self.damping * (*deflection - before) / step_s
        } else {
            sign(v) * level
        };
        rubbing + self.asymmetry * v.abs() + self.offset
    }

    /// Has it build up over a travel where it is described to be there at once.
    pub fn build_up_over(&mut self, travel: f64) {
        if self.stiffness == 0.0 {
            self.stiffness = self.level(0.0, 0.0).max(0.0) / travel;
        }
    }
}
