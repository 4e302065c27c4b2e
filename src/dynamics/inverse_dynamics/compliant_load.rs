//! What lies beyond a joint that gives way: it follows the encoder by its own equation of motion.

use super::backlash::sides;
use super::friction::FrictionForce;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use machine::{Machine, Modifier as Scaled, Operating, Value};
use numeric::filter::central_differences;

/// A joint with play, or made softer than described, and what the encoder moves through it alone.
pub(super) struct CompliantLoad<'m> {
    machine: &'m Machine,
    /// The joint (index).
    joint: usize,
    /// Whether each point is on the encoder's side.
    near: Vec<bool>,
    /// Rate of the joint's combination over that of the encoder's side, what is beyond at rest.
    rate: f64,
    /// So many times as far as described it gives way.
    times: f64,
}

/// Largest angular frequency (rad/s) that what is beyond may have on its joint: above, the recorded motion cannot tell the joint from a rigid one.
const STIFFEST: f64 = 1e4;
/// Angle that the fastest motion of it may go on in a step.
const ANGLE: f64 = 0.25;
/// Most steps between two samples.
const STEPS: usize = 60;

impl Rigid {
    /// Travel (m) over which friction beyond a joint that gives way builds up where none is described.
    pub const BUILDS_UP_M: f64 = 1e-6;
}

impl<'m> CompliantLoad<'m> {
    /// Behind the one joint that an effect makes give way, with the encoder and the drive on one side of it; `None` where there is none, or more than one.
    pub fn new(rigid: &Rigid, machine: &'m Machine, values: &[f64]) -> Option<Self> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let gives = |j: &machine::Joint| {
            let softened = j.stiffness.laws.iter().any(|law| matches!(law, Scaled::InSeries(_)));
            number(&j.stiffness) > 0.0 && (softened || number(&j.gap) > 0.0)
        };
        let mut soft = machine.joints.iter().enumerate().filter(|(_, j)| gives(j));
        let (Some((joint, _)), None) = (soft.next(), soft.next()) else { return None };
        Self::behind(joint, rigid, machine, values)
    }

    /// The same behind a joint (index) with a spring; `None` where it does not part the drive from something.
    pub fn behind(joint: usize, rigid: &Rigid, machine: &'m Machine, values: &[f64]) -> Option<Self> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let soft = &machine.joints[joint];
        if !(number(&soft.stiffness) > 0.0) {
            return None;
        }
        let drive = machine.drive.as_ref()?;
        let mut near = vec![false; machine.points.len()];
        near[drive.position.encoder.at] = true;
        // What any other spring or shaft ties to the encoder's side belongs to it.
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
        while let Some(tie) = ties.iter().position(|t| t.iter().any(|p| near[*p])) {
            ties.swap_remove(tie).into_iter().for_each(|p| near[p] = true);
        }
        let rate: f64 = soft.on.iter().filter(|(p, _)| near[*p]).map(|(p, c)| c * rigid.point_ratio(*p)).sum();
        let parts = soft.on.iter().any(|(p, _)| !near[*p] && !machine.points[*p].fixed);
        (near[drive.on] && parts && rate.abs() > 1e-9).then_some(CompliantLoad { machine, joint, near, rate, times: 1.0 })
    }

    /// The same, giving way so many times as far.
    pub fn softer(self, times: f64) -> Self {
        CompliantLoad { times, ..self }
    }

    /// Acceleration (m/s²) of the joint's combination per force (N) through it that is not there.
    pub fn yields(&self, rigid: &Rigid, values: &[f64]) -> f64 {
        self.rate * self.rate / rigid.inertia_of(self.machine, values, &|p| !self.near[p])
    }

    /// Whether a combination of points lies beyond.
    pub fn holds(&self, on: &[(usize, f64)]) -> bool {
        on.iter().all(|(p, _)| !self.near[*p])
    }

    /// Force of the joint against the encoder's side (N, per reading), sample by sample, what is beyond moving behind the recorded motion:
    ///
    /// ```text
    /// m·ÿ = T − Σ rⱼ·frictionⱼ(rⱼ·ẏ)        T = κ²·( k·(x − y) + c·(ẋ − ẏ) )        without play
    /// y = x ∓ ½·gap/κ, T = m·ẍ + Σ …  while T presses on that flank; else T = 0      with play
    /// ```
    ///
    /// All per reading x of the encoder, κ the rate of the joint. Semi-implicit steps, x between samples by cubic Hermite. With play the flanks are rigid and
    /// their blow plastic: the momentum it gives goes through the filter that the recorded acceleration went through.
    ///
    /// Where the position of what is beyond was recorded, T follows from it at once, and the encoder's side moves before it:
    ///
    /// ```text
    /// x = y + T/(κ²·k) ± ½·gap/κ, with that side's own mass times ẍ − ÿ added to T
    /// ```
    pub fn follow(&self, rigid: &Rigid, values: &[f64], motion: &MotionSignal) -> Vec<f64> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let soft = &self.machine.joints[self.joint];
        let mass = rigid.inertia_of(self.machine, values, &|p| !self.near[p]);
        let square = self.rate * self.rate;
        let spring = Spring {
            stiffness: (square * number(&soft.stiffness) / self.times).min(mass * STIFFEST * STIFFEST),
            damping: square * number(&soft.damping),
        };
        let half = 0.5 * number(&soft.gap) / self.rate.abs();
        let mut fastest = (spring.stiffness / mass).sqrt().max(spring.damping / mass);
        let mut slides: Vec<Slide> = Vec::new();
        for joint in &self.machine.joints {
            let ratio = rigid.ratio(&joint.on);
            if ratio.abs() < 1e-12 || !self.holds(&joint.on) {
                continue;
            }
            let mut law = FrictionForce::new(&joint.friction, &number);
            law.build_up_over(Rigid::BUILDS_UP_M * ratio.abs());
            fastest = fastest.max((law.stiffness * ratio * ratio / mass).sqrt());
            slides.push(Slide { ratio, viscous: number(&joint.damping), law, deflection: 0.0 });
        }
        let steps = ((motion.step_s * fastest / ANGLE).ceil() as usize).clamp(1, STEPS);
        let mut body = LoadBody { mass, slides, position: motion.position_m[0], speed: motion.velocity_m_s[0] };
        if motion.point.is_some_and(|p| !self.near[p]) {
            let before = rigid.inertia_of(self.machine, values, &|p| self.near[p]);
            return body.before_spring(&spring, half, before, motion);
        }
        if half > 0.0 { body.behind_play(half, motion, steps) } else { body.behind_spring(&spring, motion, steps) }
    }
}

/// A spring–damper.
struct Spring {
    stiffness: f64,
    damping: f64,
}

/// What lies beyond the joint, per reading of the encoder.
struct LoadBody {
    mass: f64,
    slides: Vec<Slide>,
    position: f64,
    speed: f64,
}

impl LoadBody {
    fn friction(&mut self, speed: f64, position: f64, step_s: f64) -> f64 {
        self.slides.iter_mut().map(|slide| slide.force(speed, position, step_s)).sum()
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
                // Amid the step, with the acceleration of the one before: else a steady acceleration would take too little force, by (ω·step)²/8 and by the
                // damping times half a step.
                let gained = 0.5 * step_s * acceleration;
                let (amid, middle) = (self.speed + gained, self.position + 0.5 * step_s * (self.speed + 0.5 * gained));
                let against = self.friction(amid, middle, step_s);
                acceleration = (force(at, speed, middle, amid) - against) / self.mass;
                self.position += step_s * (self.speed + 0.5 * step_s * acceleration);
                self.speed += step_s * acceleration;
            }
        }
        through
    }

    fn before_spring(&mut self, spring: &Spring, half: f64, before: f64, motion: &MotionSignal) -> Vec<f64> {
        let (x, v, a) = (&motion.position_m, &motion.velocity_m_s, &motion.acceleration_m_s2);
        let mut through: Vec<f64> = (0..x.len()).map(|i| self.mass * a[i] + self.friction(v[i], x[i], motion.step_s)).collect();
        let given: Vec<f64> = sides(&through).into_iter().zip(&through).map(|(side, t)| t / spring.stiffness + half * side).collect();
        let given = motion.recipe.low_pass(motion.step_s).forward_backward(&given).unwrap_or(given);
        let second = central_differences(&central_differences(&given));
        through.iter_mut().zip(second).for_each(|(t, d)| *t += before * d / (motion.step_s * motion.step_s));
        through
    }

    fn behind_play(&mut self, half: f64, motion: &MotionSignal, steps: usize) -> Vec<f64> {
        let (x, v, a) = (&motion.position_m, &motion.velocity_m_s, &motion.acceleration_m_s2);
        let step_s = motion.step_s / steps as f64;
        let mut through = vec![0.0; x.len()];
        let mut blows = vec![0.0; x.len()];
        // The flank it lies on: where it lies when it begins to move is not known, as far from both as can be.
        let mut side = 0.0;
        for i in 0..x.len() {
            if side != 0.0 {
                let before: Vec<f64> = self.slides.iter().map(|s| s.deflection).collect();
                let force = self.mass * a[i] + self.friction(v[i], x[i] - side * half, motion.step_s);
                (self.position, self.speed) = (x[i] - side * half, v[i]);
                if force * side >= 0.0 {
                    through[i] = force;
                    continue;
                }
                self.slides.iter_mut().zip(before).for_each(|(s, before)| s.deflection = before);
                side = 0.0;
            }
            for k in 0..if i + 1 < x.len() { steps } else { 0 } {
                let (before, middle) = (self.speed, self.position + 0.5 * step_s * self.speed);
                self.speed -= step_s * self.friction(before, middle, step_s) / self.mass;
                self.position += 0.5 * step_s * (before + self.speed);
                let (at, speed) = between(motion, i, (k as f64 + 1.0) / steps as f64);
                let apart = at - self.position;
                if apart.abs() >= half && (speed - self.speed) * apart > 0.0 {
                    side = apart.signum();
                    blows[i] = self.mass * (speed - self.speed) / motion.step_s;
                    break;
                }
            }
        }
        let blurred = motion.recipe.low_pass(motion.step_s).forward_backward(&blows).unwrap_or(blows);
        through.iter_mut().zip(blurred).for_each(|(force, blow)| *force += blow);
        through
    }
}

/// Position and speed of the encoder at a share s of the step after a sample.
fn between(motion: &MotionSignal, i: usize, s: f64) -> (f64, f64) {
    let (x, v, step_s) = (&motion.position_m, &motion.velocity_m_s, motion.step_s);
    let (s2, s3) = (s * s, s * s * s);
    let at = (2.0 * s3 - 3.0 * s2 + 1.0) * x[i]
        + (s3 - 2.0 * s2 + s) * step_s * v[i]
        + (3.0 * s2 - 2.0 * s3) * x[i + 1]
        + (s3 - s2) * step_s * v[i + 1];
    (at, v[i] + s * (v[i + 1] - v[i]))
}

/// Friction beyond the joint.
struct Slide {
    ratio: f64,
    viscous: f64,
    law: FrictionForce,
    deflection: f64,
}

impl Slide {
    fn force(&mut self, u: f64, y: f64, step_s: f64) -> f64 {
        let v = self.ratio * u;
        self.ratio * (self.law.slide(&mut self.deflection, v, self.ratio * y, step_s) + self.viscous * v)
    }
}
