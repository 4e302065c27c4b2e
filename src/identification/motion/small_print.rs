//! Small deviations from the described friction and force that most axes have, and the delay of the force: tolerances of the fit of motion records.

use super::nuisance_prior::{
    DELAY_SAMPLES, FRICTION_ALONG_TRAVEL, LOW_SPEED_RISE, LOW_SPEEDS, REVERSAL, RIPPLE, RIPPLE_HALF_WAVES, TRAVEL_HALF_WAVES,
    half_wave_share,
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
    pub const SIZED: [SmallPrint; 3] = [SmallPrint::Ripple, SmallPrint::FrictionAlongTravel, SmallPrint::LowSpeedRise];

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
    /// Change of the force (N or N·m) and of extra channels, in the layout of the prediction.
    pub force: Vec<f64>,
}

/// Stated sizes of the tolerances with their reference quantities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedSizes {
    /// Standard deviation of the delay (s).
    pub delay_s: f64,
    /// Standard deviation of friction at reversals (N or N·m).
    pub reversal: f64,
    /// Root mean square of the ripple (N or N·m).
    pub ripple: f64,
    /// Standard deviation of dry friction along the travel (N or N·m).
    pub friction: f64,
    /// Standard deviation of the rise towards standstill (N or N·m).
    pub rise: f64,
}

/// Standard deviation of the half-normal prior of a size, over the stated size.
pub(super) const SIZE_SD: f64 = 2.0;
/// Largest number of half-waves of the ripple over the number of samples.
const COLUMNS_PER_SAMPLE: f64 = 0.04;

/// Returns the tolerances that the machine does not describe by parameters of its own, and their stated sizes.
pub(super) fn tolerances(rigid: &Rigid, machine: &Machine, values: &[f64], motions: &[&MotionSignal]) -> (Vec<Tolerance>, StatedSizes) {
    let used: usize = motions.iter().map(|m| m.is_moving.iter().filter(|x| **x).count()).sum();
    let squares: f64 = motions.iter().flat_map(|m| &m.load).map(|f| f * f).sum();
    let level = (squares / used.max(1) as f64).sqrt();
    let fastest = motions.iter().flat_map(|m| &m.velocity_m_s).fold(0.0_f64, |f, v| f.max(v.abs()));
    let sliding = rigid.steady(machine, values, 1e-9 * fastest) - rigid.steady(machine, values, -1e-9 * fastest);
    let dry = 0.5 * sliding.abs();
    let (low, high) = extremes(motions.iter().flat_map(|m| &m.position_m));
    let step_s = root_mean_square(motions.iter().map(|m| m.step_s)).unwrap_or(0.0);
    let sizes = StatedSizes {
        delay_s: DELAY_SAMPLES * step_s,
        reversal: REVERSAL.1 * dry,
        ripple: RIPPLE * level,
        friction: FRICTION_ALONG_TRAVEL * dry,
        rise: LOW_SPEED_RISE * dry,
    };
    let mut found: Vec<Tolerance> = Vec::new();
    let mut add = |kind: SmallPrint, of: &dyn Fn(&MotionSignal) -> Vec<f64>| {
        // Extra channels follow the force of their motion; their own tolerances are not estimated.
        let channels = |m: &&MotionSignal| {
            let mut all = m.thinned(&of(m)).unwrap_or_default();
            all.resize(m.load.len() * (1 + m.extra_channels.len()), 0.0);
            all
        };
        let force: Vec<f64> = motions.iter().flat_map(channels).collect();
        if force.iter().any(|f| *f != 0.0) && force.iter().all(|f| f.is_finite()) {
            found.push(Tolerance { kind, force });
        }
    };
    let described = Described::new(machine, values);
    if !described.delay {
        add(SmallPrint::Delay, &|m| {
            let slope = central_differences(&rigid.force(machine, values, m));
            slope.into_iter().map(|d| d * sizes.delay_s / m.step_s).collect()
        });
    }
    let along = |m: &MotionSignal, force: Vec<f64>| -> Vec<f64> { force.iter().zip(m.direction()).map(|(f, s)| f * s).collect() };
    let below = |m: &MotionSignal, share: f64, size: f64| -> Vec<f64> {
        along(m, m.velocity_m_s.iter().map(|v| size * (-(v / (share * fastest)).powi(2)).exp()).collect())
    };
    if !described.presliding {
        add(SmallPrint::Reversal, &|m| below(m, REVERSAL.0, sizes.reversal));
    }
    let wave = |m: &MotionSignal, n: u32, size: f64| -> Vec<f64> {
        let phase = |x: &f64| std::f64::consts::PI * f64::from(n) * (x - low) / (high - low).max(f64::MIN_POSITIVE);
        m.position_m.iter().map(|x| size * phase(x).cos()).collect()
    };
    if !described.ripple {
        let count = RIPPLE_HALF_WAVES.min((COLUMNS_PER_SAMPLE * used as f64) as u32);
        // Their squares add to that of the stated ripple.
        let size = sizes.ripple * (2.0 / f64::from(count.max(1))).sqrt();
        (1..=count).for_each(|n| add(SmallPrint::Ripple, &|m| wave(m, n, size)));
    }
    if !described.along_travel {
        for n in 0..=TRAVEL_HALF_WAVES {
            let size = sizes.friction * half_wave_share(n);
            add(SmallPrint::FrictionAlongTravel, &|m| along(m, wave(m, n, size)));
        }
    }
    if !described.stribeck {
        for share in LOW_SPEEDS {
            add(SmallPrint::LowSpeedRise, &|m| below(m, share, sizes.rise));
        }
    }
    (found, sizes)
}

/// Kinds of tolerance that the machine describes by its own parameters.
struct Described {
    delay: bool,
    ripple: bool,
    along_travel: bool,
    stribeck: bool,
    presliding: bool,
}

impl Described {
    fn new(machine: &Machine, values: &[f64]) -> Self {
        let is_set = |value: &Value| value.depends_on().next().is_some() || value.at(values, &Operating::default()) != 0.0;
        let drive = machine.drive.as_ref();
        let any = |of: &dyn Fn(&machine::Friction) -> bool| machine.joints.iter().any(|j| of(&j.friction));
        Described {
            delay: drive.is_some_and(|d| is_set(&d.delay_s)),
            ripple: drive.is_some_and(|d| is_set(&d.ripple.cosine) || is_set(&d.ripple.sine)),
            along_travel: any(&|f| is_set(&f.position.cosine) || is_set(&f.position.sine)),
            stribeck: any(&|f| is_set(&f.stribeck)),
            presliding: any(&|f| is_set(&f.presliding_stiffness)),
        }
    }
}
