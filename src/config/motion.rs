//! The words of a configuration file for friction, lead error and the drive.

use schemars::JsonSchema;
use serde::Deserialize;

use super::number::{Number, source};
use machine::{
    CurrentLoopPatch, DrivePatch, EncoderPatch, FrictionPatch, Inverter, LeadErrorPatch, MotorPatch, PositionLoopPatch, Source, Tachometry,
    VelocityLoopPatch, WavePatch,
};

/// A wave over the travel, of amplitude √(cosine² + sine²).
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveFile {
    cosine: Option<Number>,
    sine: Option<Number>,
    /// Travel after which it repeats (m or rad).
    period: Option<Number>,
}

impl From<WaveFile> for WavePatch {
    fn from(file: WaveFile) -> Self {
        WavePatch { cosine: source(file.cosine), sine: source(file.sine), period: source(file.period) }
    }
}

/// Friction of a joint; forces in N (N·m on angles), travel in m (rad). Viscous friction is the joint's damping.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionForceFile {
    /// Coulomb level.
    coulomb: Option<Number>,
    /// Constant force: half the difference of the levels forward and backward.
    offset: Option<Number>,
    /// What the viscous coefficient has more forward, and less backward.
    viscous_asymmetry: Option<Number>,
    /// Static less Coulomb level.
    stribeck: Option<Number>,
    /// Velocity over which the level falls.
    stribeck_velocity: Option<Number>,
    /// Exponent n of exp(−(|v|/v_s)^n); 2 by default.
    stribeck_exponent: Option<Number>,
    /// Stiffness before sliding (LuGre); none by default.
    presliding_stiffness: Option<Number>,
    /// Damping before sliding.
    presliding_damping: Option<Number>,
    /// Part of the level that depends on the position.
    position: Option<WaveFile>,
    /// Share of the force of `load_of` that adds to the level.
    load_share: Option<Number>,
    /// The joint, described before this one, whose force loads it; the drive's force by default.
    load_of: Option<String>,
}

impl From<FrictionForceFile> for FrictionPatch {
    fn from(file: FrictionForceFile) -> Self {
        FrictionPatch {
            coulomb: source(file.coulomb),
            offset: source(file.offset),
            viscous_asymmetry: source(file.viscous_asymmetry),
            stribeck: source(file.stribeck),
            stribeck_velocity: source(file.stribeck_velocity),
            stribeck_exponent: file.stribeck_exponent.map(Source::from),
            presliding_stiffness: source(file.presliding_stiffness),
            presliding_damping: source(file.presliding_damping),
            position: file.position.unwrap_or_default().into(),
            load_share: source(file.load_share),
            load_of: file.load_of,
        }
    }
}

/// Error of a screw's lead.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeadErrorFile {
    /// Growth along the travel (m per m).
    growth: Option<Number>,
    /// What repeats along the travel (m).
    wave: Option<WaveFile>,
}

impl From<LeadErrorFile> for LeadErrorPatch {
    fn from(file: LeadErrorFile) -> Self {
        LeadErrorPatch { growth: source(file.growth), wave: file.wave.unwrap_or_default().into() }
    }
}

/// The drive of an axis.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveFile {
    /// The point the motor moves.
    on: String,
    /// Force or torque per unit of what the velocity loop gives (N/V or N·m/V); with a motor per current (N/A or N·m/A).
    constant: Number,
    /// From a sample to the force it makes (s); with a motor, to its voltage.
    delay_s: Option<Number>,
    /// Largest size of what the velocity loop gives (V); without limit by default.
    saturation: Option<Number>,
    /// Ripple of force or torque over the travel of `on`.
    ripple: Option<WaveFile>,
    /// Winding of the motor; without one the force follows the loops at once.
    motor: Option<MotorFile>,
    /// Loop of its current; without one the velocity loop gives the motor's voltage.
    current: Option<CurrentFile>,
    position: PositionFile,
    velocity: VelocityFile,
}

/// The winding of a motor: direct current, or with pole_pairs synchronous in dq axes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorFile {
    /// Of the armature, or of a phase.
    resistance_ohm: Number,
    /// Of the armature, or along the q axis.
    inductance_h: Number,
    /// Along the d axis; inductance_h by default.
    inductance_d_h: Option<Number>,
    /// Pole pairs of a synchronous motor; direct current by default.
    pole_pairs: Option<u32>,
    /// Voltage of the supply (V); without limit by default.
    dc_link_v: Option<Number>,
}

/// The current loop: V = gain·(e + ∫e dt/integral_time_s), e = i_ref − i.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentFile {
    /// V/A.
    gain: Number,
    /// None by default: proportional alone.
    integral_time_s: Option<Number>,
    /// Period of the loop (s); the velocity loop's is a multiple of it.
    period_s: f64,
    /// `averaged` over a period (default), or `switching` by space vectors.
    #[serde(default)]
    inverter: InverterFile,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum InverterFile {
    #[default]
    Averaged,
    Switching,
}

impl From<MotorFile> for MotorPatch {
    fn from(file: MotorFile) -> Self {
        MotorPatch {
            resistance_ohm: file.resistance_ohm.into(),
            inductance_h: file.inductance_h.into(),
            inductance_d_h: file.inductance_d_h.map(Source::from),
            pole_pairs: file.pole_pairs,
            dc_link_v: file.dc_link_v.map(Source::from),
        }
    }
}

impl From<CurrentFile> for CurrentLoopPatch {
    fn from(file: CurrentFile) -> Self {
        CurrentLoopPatch {
            gain: file.gain.into(),
            integral_time_s: file.integral_time_s.map(Source::from),
            period_s: file.period_s,
            inverter: match file.inverter {
                InverterFile::Averaged => Inverter::Averaged,
                InverterFile::Switching => Inverter::Switching,
            },
        }
    }
}

/// The position loop: v_ref = gain·(command − position) + feed_forward·(rate of the command).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PositionFile {
    /// The point its encoder sits at; that of the motor by default.
    at: Option<String>,
    /// Travel per turn (m) where that point turns and positions are in m.
    lead_m: Option<f64>,
    /// Step of the encoder (m or rad, as it reads); none by default.
    encoder_step: Option<Number>,
    gain_per_s: Number,
    feed_forward: Option<Number>,
    /// Ends of the stroke (m or rad, as the encoder reads it), which no command may leave.
    limits_m: Option<[f64; 2]>,
    /// Period of the loop (s).
    period_s: f64,
}

/// The velocity loop: V = gain·(e + ∫e dt/integral_time_s) + acceleration_feed_forward·(second rate of the command), e = v_ref − velocity.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityFile {
    /// The point its encoder sits at; that of the position loop by default.
    at: Option<String>,
    /// Travel per turn (m) where that point turns and positions are in m; that of the position loop with its point.
    lead_m: Option<f64>,
    /// Step of the encoder (m or rad, as it reads); that of the position loop with its point.
    encoder_step: Option<Number>,
    /// `difference` of encoder readings (default), or a `tachometer`.
    #[serde(default)]
    measured: MeasuredFile,
    /// Time (s) over which readings are differenced, a multiple of the loop's period; one period by default.
    over_s: Option<f64>,
    /// V (or A) per m/s (or rad/s).
    gain: Number,
    /// None by default: proportional alone.
    integral_time_s: Option<Number>,
    acceleration_feed_forward: Option<Number>,
    /// Period of the loop (s); the position loop's is a multiple of it.
    period_s: f64,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum MeasuredFile {
    #[default]
    Difference,
    Tachometer,
}

impl From<DriveFile> for DrivePatch {
    fn from(file: DriveFile) -> Self {
        let (p, v) = (file.position, file.velocity);
        let position = EncoderPatch { at: p.at.unwrap_or_else(|| file.on.clone()), lead_m: p.lead_m, step: source(p.encoder_step) };
        // What is said of one point holds for both loops.
        let same = v.at.as_ref().is_none_or(|at| *at == position.at);
        let velocity = EncoderPatch {
            at: v.at.unwrap_or_else(|| position.at.clone()),
            lead_m: v.lead_m.or(position.lead_m.filter(|_| same)),
            step: v.encoder_step.map_or_else(|| if same { position.step.clone() } else { Source::default() }, Source::from),
        };
        DrivePatch {
            on: file.on,
            constant: file.constant.into(),
            delay_s: source(file.delay_s),
            saturation: file.saturation.map(Source::from),
            ripple: file.ripple.unwrap_or_default().into(),
            motor: file.motor.map(MotorPatch::from),
            current: file.current.map(CurrentLoopPatch::from),
            position: PositionLoopPatch {
                encoder: position,
                gain_per_s: p.gain_per_s.into(),
                feed_forward: source(p.feed_forward),
                limits: p.limits_m,
                period_s: p.period_s,
            },
            velocity: VelocityLoopPatch {
                encoder: velocity,
                tachometry: match v.measured {
                    MeasuredFile::Difference => Tachometry::Difference(periods(v.over_s.unwrap_or(v.period_s), v.period_s)),
                    MeasuredFile::Tachometer => Tachometry::Direct,
                },
                gain: v.gain.into(),
                integral_time_s: v.integral_time_s.map(Source::from),
                acceleration_feed_forward: source(v.acceleration_feed_forward),
                period_s: v.period_s,
            },
        }
    }
}

/// How many periods a time is; 0 where it is no multiple of them, which the machine refuses.
fn periods(time_s: f64, period_s: f64) -> usize {
    let ratio = time_s / period_s;
    let whole = ratio.round();
    if (ratio - whole).abs() < 1e-6 * whole && whole < 1e6 { whole as usize } else { 0 }
}
