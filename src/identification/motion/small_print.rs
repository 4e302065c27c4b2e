//! Small deviations from the described friction and force that most axes have, and the delay of the force:
//! tolerances of the fit of motion records.

use super::nuisance_prior::{
    DELAY_SAMPLES, FRICTION_ALONG_TRAVEL, LOW_SPEED_RISE, LOW_SPEEDS, REVERSAL, RIPPLE, RIPPLE_HALF_WAVES,
    TRAVEL_HALF_WAVES, half_wave_share,
};
use dynamics::inverse_dynamics::{MotionSignal, Rigid};
use machine::{Machine, Operating, Value};
use numeric::filter::central_differences;
use numeric::statistics::{extremes, root_mean_square};

/// Kind of a tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SmallPrint {
    /// Delay of the motion behind the recorded force.
    Delay,
    /// Friction around reversals, where presliding and the filters blur its change of sign.
    Reversal,
    /// Force that varies along the travel: torque ripple.
    Ripple,
    /// Friction that varies along the travel.
    FrictionAlongTravel,
    /// Friction that rises towards standstill.
    LowSpeedRise,
}

impl SmallPrint {
    /// Kinds whose size the records estimate.
    pub const SIZED: [SmallPrint; 3] =
        [SmallPrint::Ripple, SmallPrint::FrictionAlongTravel, SmallPrint::LowSpeedRise];

    /// Whether the records estimate its size; otherwise its value has a normal prior of the stated size.
    pub fn is_sized(self) -> bool {
        Self::SIZED.contains(&self)
    }

    /// Standard deviation of the prior over the stated size: half-normal for an estimated size, else normal.
    pub fn prior_sd(self) -> f64 {
        if self.is_sized() { SIZE_SD } else { 1.0 }
    }

    /// Name in documents.
    pub fn name(self) -> &'static str {
        match self {
            SmallPrint::Delay => "delay of the motion behind the force",
            SmallPrint::Reversal => "friction at reversals",
            SmallPrint::Ripple => "force ripple along the travel",
            SmallPrint::FrictionAlongTravel => "friction along the travel",
            SmallPrint::LowSpeedRise => "rise of friction towards standstill",
        }
    }
}

/// A tolerance: its influence of one stated standard deviation.
pub(super) struct Tolerance {
    /// Kind.
    pub kind: SmallPrint,
    /// Stated size of the kind: standard deviation of the delay (s), root mean square of the ripple, or
    /// standard deviation of friction (N or N·m).
    pub stated: f64,
    /// Change of the force (N or N·m) and of extra channels, in the layout of the prediction.
    pub force: Vec<f64>,
}

/// Standard deviation of the half-normal prior of a size, over the stated size.
pub(super) const SIZE_SD: f64 = 2.0;
/// Largest number of half-waves of the ripple over the number of samples.
const COLUMNS_PER_SAMPLE: f64 = 0.04;

/// Returns the tolerances that the machine does not describe by parameters of its own.
pub(super) fn tolerances(
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
    motions: &[&MotionSignal],
) -> Vec<Tolerance> {
    let used: usize = motions.iter().map(|m| m.is_moving.iter().filter(|x| **x).count()).sum();
    let squares: f64 = motions.iter().flat_map(|m| &m.load).map(|f| f * f).sum();
    let level = (squares / used.max(1) as f64).sqrt();
    let fastest = motions.iter().flat_map(|m| &m.velocity_m_s).fold(0.0_f64, |f, v| f.max(v.abs()));
    let sliding =
        rigid.steady(machine, values, 1e-9 * fastest) - rigid.steady(machine, values, -1e-9 * fastest);
    let dry = 0.5 * sliding.abs();
    let (low, high) = extremes(motions.iter().flat_map(|m| &m.position_m));
    let mut found: Vec<Tolerance> = Vec::new();
    let mut add = |kind: SmallPrint, stated: f64, of: &dyn Fn(&MotionSignal) -> Vec<f64>| {
        if is_described(kind, machine, values) {
            return;
        }
        // Extra channels follow the force of their motion; their own tolerances are not estimated.
        let channels = |m: &&MotionSignal| {
            let mut all = m.thinned(&of(m)).unwrap_or_default();
            all.resize(m.load.len() * (1 + m.extra_channels.len()), 0.0);
            all
        };
        let force: Vec<f64> = motions.iter().flat_map(channels).collect();
        if force.iter().any(|f| *f != 0.0) && force.iter().all(|f| f.is_finite()) {
            found.push(Tolerance { kind, stated, force });
        }
    };
    let delay_s = DELAY_SAMPLES * root_mean_square(motions.iter().map(|m| m.step_s)).unwrap_or(0.0);
    add(SmallPrint::Delay, delay_s, &|m| {
        let slope = central_differences(&rigid.force(machine, values, m));
        slope.into_iter().map(|d| d * delay_s / m.step_s).collect()
    });
    let along = |m: &MotionSignal, force: Vec<f64>| -> Vec<f64> {
        force.iter().zip(m.direction()).map(|(f, s)| f * s).collect()
    };
    let below = |m: &MotionSignal, share: f64, size: f64| -> Vec<f64> {
        along(m, m.velocity_m_s.iter().map(|v| size * (-(v / (share * fastest)).powi(2)).exp()).collect())
    };
    let reversal = REVERSAL.1 * dry;
    add(SmallPrint::Reversal, reversal, &|m| below(m, REVERSAL.0, reversal));
    let wave = |m: &MotionSignal, n: u32, size: f64| -> Vec<f64> {
        let phase =
            |x: &f64| std::f64::consts::PI * f64::from(n) * (x - low) / (high - low).max(f64::MIN_POSITIVE);
        m.position_m.iter().map(|x| size * phase(x).cos()).collect()
    };
    let count = RIPPLE_HALF_WAVES.min((COLUMNS_PER_SAMPLE * used as f64) as u32);
    let ripple = RIPPLE * level;
    // Their squares add to that of the stated ripple.
    let size = ripple * (2.0 / f64::from(count.max(1))).sqrt();
    (1..=count).for_each(|n| add(SmallPrint::Ripple, ripple, &|m| wave(m, n, size)));
    let friction = FRICTION_ALONG_TRAVEL * dry;
    for n in 0..=TRAVEL_HALF_WAVES {
        let size = friction * half_wave_share(n);
        add(SmallPrint::FrictionAlongTravel, friction, &|m| along(m, wave(m, n, size)));
    }
    let rise = LOW_SPEED_RISE * dry;
    LOW_SPEEDS.into_iter().for_each(|share| add(SmallPrint::LowSpeedRise, rise, &|m| below(m, share, rise)));
    found
}

/// Whether the machine describes a kind of tolerance by its own parameters.
fn is_described(kind: SmallPrint, machine: &Machine, values: &[f64]) -> bool {
    let is_set =
        |value: &Value| value.depends_on().next().is_some() || value.at(values, &Operating::default()) != 0.0;
    let drive = machine.drive.as_ref();
    let any = |of: &dyn Fn(&machine::Friction) -> bool| machine.joints.iter().any(|j| of(&j.friction));
    match kind {
        SmallPrint::Delay => {
            drive.is_some_and(|d| is_set(&d.delay_s)) || machine.chain.delay.depends_on().next().is_some()
        }
        SmallPrint::Reversal => any(&|f| is_set(&f.presliding_stiffness)),
        SmallPrint::Ripple => drive.is_some_and(|d| is_set(&d.ripple.cosine) || is_set(&d.ripple.sine)),
        SmallPrint::FrictionAlongTravel => any(&|f| is_set(&f.position.cosine) || is_set(&f.position.sine)),
        SmallPrint::LowSpeedRise => any(&|f| is_set(&f.stribeck)),
    }
}
