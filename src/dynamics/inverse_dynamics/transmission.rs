//! Transmission error between the encoder of a drive and another point of its machine: wind-up, backlash,
//! lead errors.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use super::backlash::{contact_sides, position_in_backlash};
use super::compliant_load::CompliantLoad;
use super::force::Balance;
use super::friction::FrictionMemory;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use crate::law::TravelWave;
use crate::model::matrices;
use machine::{Joint, Machine, Operating, PointMotion as Kind, Value};

/// Number of springs per rod.
const LUMPS: usize = 4;
/// Static equilibrium of a machine's springs with the encoder fixed.
struct Statics {
    /// Coordinate of each point; `None` for a fixed point.
    place: Vec<Option<usize>>,
    size: usize,
    /// K over `scale`, bordered by the encoder's row and column.
    system: LU<f64, Dyn, Dyn>,
    scale: f64,
    /// M·r with the rigid-body motion r per reading.
    inertia: DVector<f64>,
}

impl Statics {
    /// Factors the equilibrium; `None` where a part is unconstrained or a spring cannot be represented in a
    /// matrix.
    fn new(machine: &Machine, values: &[f64], at: &Operating) -> Option<Self> {
        let number = |value: &Value| value.at(values, at);
        let is_other = machine
            .joints
            .iter()
            .any(|j| j.relaxation_stiffness.is_some() || number(&j.lead_error.growth) != 0.0);
        // Dampers that relax do not hold; the lead's deviation is added to the unstrained positions.
        let elastic = is_other.then(|| {
            let mut elastic = machine.clone();
            for joint in &mut elastic.joints {
                joint.relaxation_stiffness = None;
                joint.lead_error.growth = Value::number(0.0);
            }
            elastic
        });
        let of = matrices(elastic.as_ref().unwrap_or(machine), values, at, LUMPS).ok()?;
        let place: Vec<Option<usize>> =
            machine.points.iter().map(|p| of.names.iter().position(|n| *n == p.name)).collect();
        let encoder = &machine.drive.as_ref()?.position.encoder;
        let (held, size) = (place[encoder.at]?, of.names.len());
        let scale = of.stiffness.amax();
        let mut system = DMatrix::zeros(size + 1, size + 1);
        system.view_mut((0, 0), (size, size)).copy_from(&(&of.stiffness / scale));
        system[(size, held)] = encoder.travel;
        system[(held, size)] = encoder.travel;
        let system = system.lu();
        let mut reads = DVector::zeros(size + 1);
        reads[size] = 1.0;
        let rigid =
            system.solve(&reads).filter(|x| x.iter().all(|x| x.is_finite()))?.rows(0, size).clone_owned();
        Some(Statics { place, size, system, scale, inertia: &of.mass * rigid })
    }

    fn row(&self, on: &[(usize, f64)]) -> DVector<f64> {
        let mut row = DVector::zeros(self.size + 1);
        on.iter().filter_map(|(point, c)| Some((self.place[*point]?, c))).for_each(|(at, c)| row[at] += c);
        row
    }

    /// Computes the deflection of a combination of points per force on each coordinate.
    fn compliance(&self, on: &[(usize, f64)]) -> DVector<f64> {
        self.system
            .solve(&(self.row(on) / self.scale))
            .map_or_else(|| DVector::zeros(self.size), |g| g.rows(0, self.size).clone_owned())
    }

    /// Computes the deflection of a combination of points along a motion: −g·(M·r·a + Σ cⱼ·(damper and
    /// friction)ⱼ) + g_d·F.
    fn deflection(
        &self,
        compliance: &DVector<f64>,
        machine: &Machine,
        balance: &Balance,
        motion: &MotionSignal,
    ) -> Vec<f64> {
        let share = |on: &[(usize, f64)]| self.row(on).rows(0, self.size).dot(compliance);
        let inertia = self.inertia.dot(compliance);
        let driven = machine.drive.as_ref().map_or(0.0, |d| share(&[(d.on, 1.0)]));
        let mut sum: Vec<f64> = motion
            .acceleration_m_s2
            .iter()
            .zip(&balance.force)
            .map(|(a, f)| driven * f - inertia * a)
            .collect();
        for (joint, against) in &balance.resisting {
            let share = share(&machine.joints[*joint].on);
            if share != 0.0 {
                sum.iter_mut().zip(against).for_each(|(sum, f)| *sum -= share * f);
            }
        }
        sum
    }
}

impl Rigid {
    /// Predicts the transmission error at each extra point of a motion, sample by sample: the reading less
    /// that of the rigid machine.
    ///
    /// ```text
    /// e_p(t) = g_p·( d·F(t) − M·r·a(t) − Σ cⱼ·Rⱼ(t) ) + Σ kⱼ·(g_p·cⱼ)·( ½·gapⱼ·sideⱼ(t) + γⱼ·xⱼ(t) + waveⱼ(xⱼ(t)) )
    /// ```
    ///
    /// The springs are in equilibrium with the forces of the rigid motion (r per reading) while the encoder
    /// is fixed. g_p is the row of the compliance at the point. Rⱼ is the force of damper and friction of
    /// joint j along its combination cⱼ, and F the drive's force at d.
    ///
    /// A backlash is crossed in free motion to the side to which the force through it points. If the joint
    /// does not separate a load from the drive, the side changes at once. It stays while the opposing force
    /// is below a tenth of the force's root mean square.
    ///
    /// # Units      m (rad where the point rotates)
    /// # Limits     stiff springs without backlash and lead error: 0; first order in the compliance: no
    ///   vibration, no rebound in the backlash;
    ///   with several backlashes the side of each is that of the load without the others
    /// # Source     quasi-static wind-up of a feed drive: Altintas et al., CIRP Annals 60 (2011) 779–796;
    ///   signs as in the simulation of motions
    pub fn transmission(&self, machine: &Machine, values: &[f64], motion: &MotionSignal) -> Vec<Vec<f64>> {
        self.transmission_remembering(machine, values, motion, &mut FrictionMemory::default())
    }

    /// As [`Rigid::transmission`], with the friction forces of earlier calls for this motion.
    pub(super) fn transmission_remembering(
        &self,
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
        memory: &mut FrictionMemory,
    ) -> Vec<Vec<f64>> {
        if motion.extra_channels.is_empty() {
            return Vec::new();
        }
        let at = Operating::at(machine.stroke_m().map(|s| 0.5 * s));
        let number = |value: &Value| value.at(values, &at);
        let Some(statics) = Statics::new(machine, values, &at) else {
            return vec![vec![0.0; motion.position_m.len()]; motion.extra_channels.len()];
        };
        let balance = self.balance(None, machine, values, motion, memory);
        // Unstrained position of each joint's combination.
        let mut unstrained: Vec<(&Joint, Vec<f64>)> = Vec::new();
        for (index, joint) in machine.joints.iter().enumerate() {
            let (half, expansion) = (0.5 * number(&joint.gap), number(&joint.lead_error.growth));
            let wave = TravelWave::new(&joint.lead_error.wave, &number);
            if !(number(&joint.stiffness) > 0.0) || (half == 0.0 && expansion == 0.0 && wave.is_flat()) {
                continue;
            }
            let mut place = vec![0.0; motion.position_m.len()];
            if half != 0.0 {
                let given = statics.deflection(&statics.compliance(&joint.on), machine, &balance, motion);
                let moved = match CompliantLoad::behind_joint(index, self, machine, values) {
                    Some(load) => position_in_backlash(
                        &given,
                        half,
                        number(&joint.stiffness) * load.acceleration_per_force(self, values),
                        motion.step_s,
                    ),
                    None => contact_sides(&given).into_iter().map(|side| half * side).collect(),
                };
                place.iter_mut().zip(moved).for_each(|(e, x)| *e += x);
            }
            if let Some((point, c)) =
                joint.on.iter().find(|(p, _)| machine.points[*p].motion == Kind::Translation)
            {
                let ratio = self.point_ratio(*point);
                for (e, x) in place.iter_mut().zip(&motion.position_m) {
                    *e += c * expansion * ratio * x + wave.at(ratio * x).0;
                }
            }
            unstrained.push((joint, place));
        }
        let of = |point: usize| {
            let compliance = statics.compliance(&[(point, 1.0)]);
            let mut error = statics.deflection(&compliance, machine, &balance, motion);
            for (joint, place) in &unstrained {
                let share =
                    number(&joint.stiffness) * statics.row(&joint.on).rows(0, statics.size).dot(&compliance);
                error.iter_mut().zip(place).for_each(|(e, x)| *e += share * x);
            }
            error
        };
        motion.extra_channels.iter().map(|f| of(f.point)).collect()
    }

    /// Computes the contribution of all backlashes to the transmission error at each extra point of a motion;
    /// `None` without backlash.
    pub(super) fn backlash_error(
        &self,
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
    ) -> Option<Vec<Vec<f64>>> {
        let has_backlash = |joint: &Joint| joint.gap.at(values, &Operating::default()) != 0.0;
        if !machine.joints.iter().any(has_backlash) {
            return None;
        }
        let mut without_backlash = machine.clone();
        without_backlash.joints.iter_mut().for_each(|joint| joint.gap = Value::number(0.0));
        let errors = [machine, &without_backlash].map(|machine| self.transmission(machine, values, motion));
        let without = |(with, without): (&Vec<f64>, &Vec<f64>)| {
            with.iter().zip(without).map(|(with, without)| with - without).collect()
        };
        Some(errors[0].iter().zip(&errors[1]).map(without).collect())
    }

    /// Computes the deflection of each extra point per additional drive force (or torque) when friction rises
    /// in one joint. It is the joint with the most friction work.
    pub fn deflection_per_friction(
        &self,
        machine: &Machine,
        values: &[f64],
        motion: &MotionSignal,
    ) -> Vec<f64> {
        let at = Operating::at(machine.stroke_m().map(|s| 0.5 * s));
        let most = self.joint_with_most_friction(machine, values, motion);
        let drive = machine.drive.as_ref().map(|d| d.on);
        let (Some(statics), Some(joint), Some(drive)) = (Statics::new(machine, values, &at), most, drive)
        else {
            return vec![0.0; motion.extra_channels.len()];
        };
        let on = &machine.joints[joint].on;
        let of = |point: usize| {
            let compliance = statics.compliance(&[(point, 1.0)]);
            let share = |on: &[(usize, f64)]| statics.row(on).rows(0, statics.size).dot(&compliance);
            share(&[(drive, 1.0)]) - share(on) * self.point_ratio(drive) / self.ratio(on)
        };
        motion.extra_channels.iter().map(|f| of(f.point)).collect()
    }

    /// Whether the springs constrain the machine while its encoder is fixed.
    pub(super) fn is_constrained(machine: &Machine, values: &[f64]) -> bool {
        Statics::new(machine, values, &Operating::at(machine.stroke_m().map(|s| 0.5 * s))).is_some()
    }
}
