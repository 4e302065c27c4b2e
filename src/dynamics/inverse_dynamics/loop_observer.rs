//! Reconstruction of the position loop's encoder reading from the recorded loop output, where another point
//! was recorded.

use super::error::InverseError;
use super::extra_channel::EncoderEstimate;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use machine::{Drive, Machine, Operating, PointMotion as Kind, Value};
use measurement::MotionRecord;
use numeric::filter::central_differences;
use numeric::statistics::extremes;

/// Share of the drive's largest output above which the output may be saturated.
const SATURATION_SHARE: f64 = 0.99;
/// Standard deviation of the ratio of recorded force to loop output.
const FACTOR_SD: f64 = 0.01;
/// Time constants of the loop's lag after a reversal or rest until the influence of the force there has
/// decayed.
const LAGS: f64 = 4.0;

/// Proportional loops whose output is the drive's force.
struct ProportionalLoops {
    /// k_p (1/s).
    position: f64,
    /// G·k_v (N per m/s).
    velocity: f64,
    /// f, and G·a (N per m/s²).
    feed_forward: (f64, f64),
    /// Largest force (N).
    max_force: f64,
    /// Sum of the periods of both loops (s).
    periods_s: f64,
}

impl ProportionalLoops {
    /// Reads the loops of a drive. `None` where the output depends on more than command and encoder: an
    /// integral term, a winding, two encoders.
    fn of(drive: &Drive, values: &[f64]) -> Option<Self> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let (inner, outer) = (&drive.velocity, &drive.position);
        let same_encoder = inner.encoder.at == outer.encoder.at
            && (inner.encoder.travel / outer.encoder.travel - 1.0).abs() < 1e-9;
        let supported =
            drive.motor.is_none() && drive.current.is_none() && number(&inner.integral_time_s).is_infinite();
        let constant = number(&drive.constant);
        let loops = ProportionalLoops {
            position: number(&outer.gain_per_s),
            velocity: constant * number(&inner.gain),
            feed_forward: (number(&outer.feed_forward), constant * number(&inner.acceleration_feed_forward)),
            max_force: constant * number(&drive.saturation),
            periods_s: inner.period_s + outer.period_s,
        };
        (same_encoder && supported && loops.position > 0.0 && loops.velocity > 0.0).then_some(loops)
    }

    /// Reconstructs the encoder readings from a command and a force:
    ///
    /// ```text
    /// F = G·( k_v·( k_p·(r − x) + f·ṙ − ẋ ) + a·r̈ )   ⇒   ẋ/k_p + x = r + ( f·ṙ + ( G·a·r̈ − F )/(G·k_v) )/k_p
    /// ```
    fn encoder(&self, command: &[f64], force: &[f64], start: f64, step_s: f64) -> Vec<f64> {
        let rate: Vec<f64> = central_differences(command).into_iter().map(|d| d / step_s).collect();
        let second: Vec<f64> = central_differences(&rate).into_iter().map(|d| d / step_s).collect();
        let (f, a) = self.feed_forward;
        let behind: Vec<f64> = command
            .iter()
            .zip(force)
            .zip(rate.iter().zip(&second))
            .map(|((r, force), (v, acc))| r + (f * v + (a * acc - force) / self.velocity) / self.position)
            .collect();
        first_order_lag(&behind, start, self.position * step_s)
    }
}

/// Filters `of` by a first-order lag, ẏ/k + y = of, exact for linear interpolation between samples; `h` is k
/// times the sampling step.
fn first_order_lag(of: &[f64], start: f64, h: f64) -> Vec<f64> {
    let kept = (-h).exp();
    let slope = 1.0 - (1.0 - kept) / h;
    let mut y = vec![start];
    y.extend(of.windows(2).scan(start, |y, w| {
        *y = kept * *y + (1.0 - kept) * w[0] + slope * (w[1] - w[0]);
        Some(*y)
    }));
    y
}

impl EncoderEstimate {
    /// Computes the change of the encoder reading (m) caused by a drive force (N) along a motion, relative to
    /// the reading for the command alone. At rest friction leaves the force undetermined; there the reading
    /// already includes the recorded force.
    pub fn reading_change(&self, force: &[f64], motion: &MotionSignal) -> Vec<f64> {
        let moved = |(f, rests): (&f64, &bool)| if *rests { 0.0 } else { -f / self.stiffness };
        first_order_lag(&force.iter().zip(&motion.excluded).map(moved).collect::<Vec<f64>>(), 0.0, self.lag)
    }
}

impl MotionSignal {
    /// Adds an extra channel to a record whose position is that of `response`, a point other than that of the
    /// loop's encoder. The encoder reading is reconstructed from the recorded command and the force through
    /// the law of the loops.
    ///
    /// The prediction uses the force of the machine instead of the recorded one (see
    /// [`EncoderEstimate::reading_change`]). The tracking error then carries information on friction and
    /// inertia in addition to the transmission. Around reversals backlash and wind-up change sides and
    /// friction builds up: there the channel is masked, but not the force.
    ///
    /// # Limits     the point moves with the encoder in the ratio 1; proportional loops whose recorded output
    ///   is not saturated
    /// # Errors     as [`MotionSignal::new`]
    pub fn with_reconstructed_encoder(
        mut self,
        response: Option<usize>,
        record: &MotionRecord,
        machine: &Machine,
        rigid: &Rigid,
    ) -> Result<Self, InverseError> {
        let Some(drive) = &machine.drive else { return Ok(self) };
        let along = |p: &usize| {
            machine.points[*p].motion == Kind::Translation && (rigid.point_ratio(*p) - 1.0).abs() < 1e-9
        };
        let Some(point) = response.filter(|p| *p != drive.position.encoder.at).filter(along) else {
            return Ok(self);
        };
        self.point = Some(point);
        let (values, force) = (machine.start(), record.load.samples());
        let Some(loops) = ProportionalLoops::of(drive, &values)
            .filter(|_| self.extra_channels.is_empty() && Rigid::is_constrained(machine, &values))
        else {
            return Ok(self);
        };
        if force.iter().any(|f| f.abs() > SATURATION_SHARE * loops.max_force) {
            return Ok(self);
        }
        let short = || {
            InverseError::Data(format!(
                "{}: is shorter than its filters need; record for longer",
                self.source
            ))
        };
        let low_pass = self.preprocessing.low_pass(self.step_s);
        let (lag, stiffness) = (loops.position * self.step_s, loops.velocity * loops.position);
        let encoder = |force: &[f64]| {
            low_pass.forward_backward(&loops.encoder(
                &record.command_m,
                force,
                record.position_m[0],
                self.step_s,
            ))
        };
        let at_rest: Vec<f64> =
            force.iter().zip(&self.excluded).map(|(f, rests)| if *rests { *f } else { 0.0 }).collect();
        let (commanded, whole) = (encoder(&at_rest).ok_or_else(short)?, encoder(force).ok_or_else(short)?);
        let factor_m: Vec<f64> = force.iter().map(|f| FACTOR_SD * f / stiffness).collect();
        let factor_m = low_pass.forward_backward(&first_order_lag(&factor_m, 0.0, lag)).ok_or_else(short)?;
        let mut channel = self
            .extra_channel(point, "position_m".into(), &self.position_m, (&commanded, 1.0), machine)
            .ok_or_else(short)?;
        // The delays of the loops' readings are unknown. In addition to the velocity, the acceleration
        // filtered by the lag is projected out.
        let late = first_order_lag(&self.acceleration_m_s2, 0.0, lag);
        channel.projected_out.push(self.decimated(&late).ok_or_else(short)?);
        let difference: Vec<f64> = self.position_m.iter().zip(&whole).map(|(x, e)| x - e).collect();
        let (low, high) = extremes(&difference);
        let reversing = self.near_reversals(high - low);
        let masked: Vec<bool> =
            reversing.iter().zip(&self.excluded).map(|(reversing, rests)| *reversing || *rests).collect();
        let masked = self.within_filter_reach(&masked, LAGS / loops.position);
        channel.is_used.iter_mut().zip(masked).for_each(|(counts, not)| *counts &= !not);
        channel.encoder_estimate =
            Some(EncoderEstimate { lag, stiffness, factor_m, periods_s: loops.periods_s });
        self.extra_channels.push(channel);
        Ok(self)
    }
}
