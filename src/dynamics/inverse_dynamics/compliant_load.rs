//! The load behind a compliant joint, which follows the encoder by its own equation of motion.

use super::backlash::contact_sides;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use crate::law::FrictionLaw;
use machine::{Machine, Modifier as Scaled, Operating, Value};
use numeric::filter::central_differences;

/// A joint with backlash, or softer than described, and the load that the encoder moves through this joint
/// alone.
pub(super) struct CompliantLoad<'m> {
    machine: &'m Machine,
    /// Index of the joint.
    joint: usize,
    /// Whether each point is on the encoder's side.
    encoder_side: Vec<bool>,
    /// κ: rate of the joint's deformation per rate of the encoder reading, with the load at rest.
    rate: f64,
    /// Factor on the described compliance of the joint.
    compliance_factor: f64,
}

/// Largest natural angular frequency (rad/s) of the load on its joint. Above it the recorded motion cannot
/// distinguish the joint from a rigid one.
const MAX_OMEGA_RAD_S: f64 = 1e4;
/// Largest phase advance (rad) of the fastest motion of the load in one step.
const MAX_PHASE_STEP: f64 = 0.25;
/// Largest number of steps between two samples.
const MAX_SUBSTEPS: usize = 60;

impl Rigid {
    /// Travel (m) over which friction behind a compliant joint builds up where the description gives no
    /// presliding stiffness.
    pub const PRESLIDING_TRAVEL_M: f64 = 1e-6;
}

impl<'m> CompliantLoad<'m> {
    /// Finds the load behind the one joint with backlash or with a spring in series. `None` if there is no
    /// such joint, or more than one, or if it does not separate the load from encoder and drive.
    pub fn new(rigid: &Rigid, machine: &'m Machine, values: &[f64]) -> Option<Self> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let is_compliant = |j: &machine::Joint| {
            let softened = j.stiffness.modifiers.iter().any(|law| matches!(law, Scaled::InSeries(_)));
            number(&j.stiffness) > 0.0 && (softened || number(&j.gap) > 0.0)
        };
        let mut soft = machine.joints.iter().enumerate().filter(|(_, j)| is_compliant(j));
        let (Some((joint, _)), None) = (soft.next(), soft.next()) else { return None };
        Self::behind_joint(joint, rigid, machine, values)
    }

    /// Finds the load behind a joint (index) with a spring; `None` if it does not separate a load from
    /// encoder and drive.
    pub fn behind_joint(joint: usize, rigid: &Rigid, machine: &'m Machine, values: &[f64]) -> Option<Self> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let soft = &machine.joints[joint];
        if !(number(&soft.stiffness) > 0.0) {
            return None;
        }
        let drive = machine.drive.as_ref()?;
        let mut encoder_side = vec![false; machine.points.len()];
        encoder_side[drive.position.encoder.at] = true;
        // Points that other springs or shafts connect to the encoder's side belong to that side.
        let mut ties: Vec<Vec<usize>> = Vec::new();
        for (at, other) in machine.joints.iter().enumerate() {
            if at != joint && number(&other.stiffness) > 0.0 {
                ties.push(other.on.iter().map(|(p, _)| *p).filter(|p| !machine.points[*p].fixed).collect());
            }
        }
        for shaft in &machine.shafts {
            ties.push(shaft.stations.iter().filter_map(|s| s.axial).collect());
            ties.push(shaft.stations.iter().filter_map(|s| s.torsion).collect());
        }
        while let Some(tie) = ties.iter().position(|t| t.iter().any(|p| encoder_side[*p])) {
            ties.swap_remove(tie).into_iter().for_each(|p| encoder_side[p] = true);
        }
        let rate: f64 =
            soft.on.iter().filter(|(p, _)| encoder_side[*p]).map(|(p, c)| c * rigid.point_ratio(*p)).sum();
        let separates = soft.on.iter().any(|(p, _)| !encoder_side[*p] && !machine.points[*p].fixed);
        (encoder_side[drive.on] && separates && rate.abs() > 1e-9).then_some(CompliantLoad {
            machine,
            joint,
            encoder_side,
            rate,
            compliance_factor: 1.0,
        })
    }

    /// Multiplies the compliance of the joint by a factor.
    pub fn with_compliance_factor(self, compliance_factor: f64) -> Self {
        CompliantLoad { compliance_factor, ..self }
    }

    /// Computes the acceleration (m/s²) of the joint's deformation per missing force (N) through it.
    pub fn acceleration_per_force(&self, rigid: &Rigid, values: &[f64]) -> f64 {
        self.rate * self.rate / rigid.inertia_of(self.machine, values, &|p| !self.encoder_side[p])
    }

    /// Whether all points of a combination belong to the load.
    pub fn is_beyond(&self, on: &[(usize, f64)]) -> bool {
        on.iter().all(|(p, _)| !self.encoder_side[*p])
    }

    /// Computes the force of the joint on the encoder's side (N, per reading), sample by sample. The load
    /// moves behind the recorded motion:
    ///
    /// ```text
    /// m·ÿ = T − Σ rⱼ·frictionⱼ(rⱼ·ẏ)        T = κ²·( k·(x − y) + c·(ẋ − ẏ) )        without backlash
    /// y = x ∓ ½·gap/κ, T = m·ẍ + Σ …  while T presses on that flank; else T = 0      with backlash
    /// ```
    ///
    /// All quantities are per reading x of the encoder. The steps are semi-implicit; cubic Hermite
    /// polynomials give x between samples. With backlash the flanks are rigid and the impacts plastic: the
    /// momentum of an impact passes the filter of the recorded acceleration.
    ///
    /// Where the position of the load was recorded, T follows directly, and the encoder's side moves ahead of
    /// the load:
    ///
    /// ```text
    /// x = y + T/(κ²·k) ± ½·gap/κ, with that side's own mass times ẍ − ÿ added to T
    /// ```
    pub fn joint_force(&self, rigid: &Rigid, values: &[f64], motion: &MotionSignal) -> Vec<f64> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let soft = &self.machine.joints[self.joint];
        let mass = rigid.inertia_of(self.machine, values, &|p| !self.encoder_side[p]);
        let square = self.rate * self.rate;
        let spring = Spring {
            stiffness: (square * number(&soft.stiffness) / self.compliance_factor)
                .min(mass * MAX_OMEGA_RAD_S * MAX_OMEGA_RAD_S),
            damping: square * number(&soft.damping),
        };
        let half = 0.5 * number(&soft.gap) / self.rate.abs();
        let mut fastest = (spring.stiffness / mass).sqrt().max(spring.damping / mass);
        let mut frictions: Vec<LoadFriction> = Vec::new();
        for joint in &self.machine.joints {
            let ratio = rigid.ratio(&joint.on);
            if ratio.abs() < 1e-12 || !self.is_beyond(&joint.on) {
                continue;
            }
            let mut law = FrictionLaw::new(&joint.friction, &number);
            law.build_up_over(Rigid::PRESLIDING_TRAVEL_M * ratio.abs());
            fastest = fastest.max((law.stiffness * ratio * ratio / mass).sqrt());
            frictions.push(LoadFriction { ratio, viscous: number(&joint.damping), law, deflection: 0.0 });
        }
        let steps = ((motion.step_s * fastest / MAX_PHASE_STEP).ceil() as usize).clamp(1, MAX_SUBSTEPS);
        let mut body =
            LoadBody { mass, frictions, position: motion.position_m[0], speed: motion.velocity_m_s[0] };
        if motion.point.is_some_and(|p| !self.encoder_side[p]) {
            let before = rigid.inertia_of(self.machine, values, &|p| self.encoder_side[p]);
            return body.ahead_of_spring(&spring, half, before, motion);
        }
        if half > 0.0 {
            body.behind_backlash(half, motion, steps)
        } else {
            body.behind_spring(&spring, motion, steps)
        }
    }
}

/// A spring–damper.
struct Spring {
    stiffness: f64,
    damping: f64,
}

/// The load behind the joint, per reading of the encoder.
struct LoadBody {
    mass: f64,
    frictions: Vec<LoadFriction>,
    position: f64,
    speed: f64,
}

impl LoadBody {
    fn friction(&mut self, speed: f64, position: f64, step_s: f64) -> f64 {
        self.frictions.iter_mut().map(|friction| friction.force(speed, position, step_s)).sum()
    }

    fn behind_spring(&mut self, spring: &Spring, motion: &MotionSignal, steps: usize) -> Vec<f64> {
        let (x, v, step_s) = (&motion.position_m, &motion.velocity_m_s, motion.step_s / steps as f64);
        let force = |x: f64, v: f64, y: f64, u: f64| spring.stiffness * (x - y) + spring.damping * (v - u);
        let mut through = Vec::with_capacity(x.len());
        let mut acceleration = 0.0;
        for i in 0..x.len() {
            through.push(force(x[i], v[i], self.position, self.speed));
            for k in 0..if i + 1 < x.len() { steps } else { 0 } {
                let (at, speed) = between(motion, i, (k as f64 + 0.5) / steps as f64);
                // Evaluated at mid-step with the previous acceleration. Otherwise the force of a steady
                // acceleration is too small, by (ω·step)²/8 and by the damping times half a step.
                let speed_change = 0.5 * step_s * acceleration;
                let (mid_speed, middle) = (
                    self.speed + speed_change,
                    self.position + 0.5 * step_s * (self.speed + 0.5 * speed_change),
                );
                let against = self.friction(mid_speed, middle, step_s);
                acceleration = (force(at, speed, middle, mid_speed) - against) / self.mass;
                self.position += step_s * (self.speed + 0.5 * step_s * acceleration);
                self.speed += step_s * acceleration;
            }
        }
        through
    }

    fn ahead_of_spring(
        &mut self,
        spring: &Spring,
        half: f64,
        before: f64,
        motion: &MotionSignal,
    ) -> Vec<f64> {
        let (x, v, a) = (&motion.position_m, &motion.velocity_m_s, &motion.acceleration_m_s2);
        let mut through: Vec<f64> =
            (0..x.len()).map(|i| self.mass * a[i] + self.friction(v[i], x[i], motion.step_s)).collect();
        let deflection: Vec<f64> = contact_sides(&through)
            .into_iter()
            .zip(&through)
            .map(|(side, t)| t / spring.stiffness + half * side)
            .collect();
        let deflection =
            motion.preprocessing.low_pass(motion.step_s).forward_backward(&deflection).unwrap_or(deflection);
        let second = central_differences(&central_differences(&deflection));
        through.iter_mut().zip(second).for_each(|(t, d)| *t += before * d / (motion.step_s * motion.step_s));
        through
    }

    fn behind_backlash(&mut self, half: f64, motion: &MotionSignal, steps: usize) -> Vec<f64> {
        let (x, v, a) = (&motion.position_m, &motion.velocity_m_s, &motion.acceleration_m_s2);
        let step_s = motion.step_s / steps as f64;
        let mut through = vec![0.0; x.len()];
        let mut impacts = vec![0.0; x.len()];
        // The flank in contact, 0 for none. It is unknown at the start, where the load begins midway between
        // both.
        let mut side = 0.0;
        for i in 0..x.len() {
            if side != 0.0 {
                let before: Vec<f64> = self.frictions.iter().map(|s| s.deflection).collect();
                let force = self.mass * a[i] + self.friction(v[i], x[i] - side * half, motion.step_s);
                (self.position, self.speed) = (x[i] - side * half, v[i]);
                if force * side >= 0.0 {
                    through[i] = force;
                    continue;
                }
                self.frictions.iter_mut().zip(before).for_each(|(s, before)| s.deflection = before);
                side = 0.0;
            }
            for k in 0..if i + 1 < x.len() { steps } else { 0 } {
                let (before, middle) = (self.speed, self.position + 0.5 * step_s * self.speed);
                self.speed -= step_s * self.friction(before, middle, step_s) / self.mass;
                self.position += 0.5 * step_s * (before + self.speed);
                let (at, speed) = between(motion, i, (k as f64 + 1.0) / steps as f64);
                let distance = at - self.position;
                if distance.abs() >= half && (speed - self.speed) * distance > 0.0 {
                    side = distance.signum();
                    impacts[i] = self.mass * (speed - self.speed) / motion.step_s;
                    break;
                }
            }
        }
        let filtered =
            motion.preprocessing.low_pass(motion.step_s).forward_backward(&impacts).unwrap_or(impacts);
        through.iter_mut().zip(filtered).for_each(|(force, impact)| *force += impact);
        through
    }
}

/// Interpolates position and speed of the encoder at a share s of the step after a sample.
fn between(motion: &MotionSignal, i: usize, s: f64) -> (f64, f64) {
    let (x, v, step_s) = (&motion.position_m, &motion.velocity_m_s, motion.step_s);
    let (s2, s3) = (s * s, s * s * s);
    let at = (2.0 * s3 - 3.0 * s2 + 1.0) * x[i]
        + (s3 - 2.0 * s2 + s) * step_s * v[i]
        + (3.0 * s2 - 2.0 * s3) * x[i + 1]
        + (s3 - s2) * step_s * v[i + 1];
    (at, v[i] + s * (v[i + 1] - v[i]))
}

/// Friction behind the joint.
struct LoadFriction {
    ratio: f64,
    viscous: f64,
    law: FrictionLaw,
    deflection: f64,
}

impl LoadFriction {
    fn force(&mut self, u: f64, y: f64, step_s: f64) -> f64 {
        let v = self.ratio * u;
        self.ratio * (self.law.force(&mut self.deflection, v, self.ratio * y, step_s) + self.viscous * v)
    }
}
