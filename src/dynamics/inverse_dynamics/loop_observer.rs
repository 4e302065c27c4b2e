//! Where the position loop's encoder was while another point was recorded: the loop tells, since its output was recorded.

use super::error::InverseError;
use super::extra_channel::EncoderEstimate;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use machine::{Drive, Machine, Operating, PointMotion as Kind, Value};
use measurement::MotionRecord;
use numeric::filter::central_differences;
use numeric::statistics::extremes;

/// Share of the drive's largest output from which the loop may have been cut off.
const CUT_OFF: f64 = 0.99;
/// Standard deviation of the factor between the force recorded and the one its loop gives.
const FACTOR: f64 = 0.01;
/// Times of the loop's lag after a turn or a rest in which it forgets the force there.
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
    largest: f64,
    /// Time (s) in which both loops take their readings.
    periods_s: f64,
}

impl ProportionalLoops {
    /// `None` where the output depends on more than command and encoder: an integral, a winding, two encoders.
    fn of(drive: &Drive, values: &[f64]) -> Option<Self> {
        let number = |value: &Value| value.at(values, &Operating::default());
        let (inner, outer) = (&drive.velocity, &drive.position);
        let same = inner.encoder.at == outer.encoder.at && (inner.encoder.travel / outer.encoder.travel - 1.0).abs() < 1e-9;
        let plain = drive.motor.is_none() && drive.current.is_none() && number(&inner.integral_time_s).is_infinite();
        let constant = number(&drive.constant);
        let loops = ProportionalLoops {
            position: number(&outer.gain_per_s),
            velocity: constant * number(&inner.gain),
            feed_forward: (number(&outer.feed_forward), constant * number(&inner.acceleration_feed_forward)),
            largest: constant * number(&drive.saturation),
            periods_s: inner.period_s + outer.period_s,
        };
        (same && plain && loops.position > 0.0 && loops.velocity > 0.0).then_some(loops)
    }

    /// Readings of the encoder behind a command and a force:
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
        lagging(&behind, start, self.position * step_s)
    }
}

/// What follows `of` with a lag, ẏ/k + y = of, exact where it is straight between samples; `h` is k times their step.
fn lagging(of: &[f64], start: f64, h: f64) -> Vec<f64> {
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
    /// By how much (m) the point lies behind what the command alone would have, for a force (N) of the drive along a motion. While that rests
    /// friction takes any force, and the one recorded stands for it in the reading.
    pub fn behind(&self, force: &[f64], motion: &MotionSignal) -> Vec<f64> {
        let moved = |(f, rests): (&f64, &bool)| if *rests { 0.0 } else { -f / self.stiffness };
        lagging(&force.iter().zip(&motion.silent).map(moved).collect::<Vec<f64>>(), 0.0, self.lag)
    }
}

impl MotionSignal {
    /// Of a record whose position is that of `response`, a point of the machine other than the one with the loop's encoder: where the loops tell from
    /// command and force what their encoder reads, the point's position is a further channel. The command is the record's, the force that of the machine (see
    /// [`EncoderEstimate::behind`]): a tracking error tells friction and inertia besides what stands between encoder and point. About turns play and wind-up go over,
    /// and friction builds up: there it counts for nothing, unlike the force.
    ///
    /// # Limits     a point that moves along with the encoder, metre by metre; proportional loops whose output was recorded and not cut off
    /// # Errors     as [`MotionSignal::new`]
    pub fn read_at(
        mut self,
        response: Option<usize>,
        record: &MotionRecord,
        machine: &Machine,
        rigid: &Rigid,
    ) -> Result<Self, InverseError> {
        let Some(drive) = &machine.drive else { return Ok(self) };
        let along = |p: &usize| machine.points[*p].motion == Kind::Translation && (rigid.point_ratio(*p) - 1.0).abs() < 1e-9;
        let Some(point) = response.filter(|p| *p != drive.position.encoder.at).filter(along) else {
            return Ok(self);
        };
        self.point = Some(point);
        let (values, force) = (machine.start(), record.load.samples());
        let Some(loops) = ProportionalLoops::of(drive, &values).filter(|_| self.further.is_empty() && Rigid::holds(machine, &values))
        else {
            return Ok(self);
        };
        if force.iter().any(|f| f.abs() > CUT_OFF * loops.largest) {
            return Ok(self);
        }
        let short = || InverseError::Data(format!("{}: is shorter than its filters need; record for longer", self.source));
        let low_pass = self.recipe.low_pass(self.step_s);
        let (lag, stiffness) = (loops.position * self.step_s, loops.velocity * loops.position);
        let encoder =
            |force: &[f64]| low_pass.forward_backward(&loops.encoder(&record.command_m, force, record.position_m[0], self.step_s));
        let at_rest: Vec<f64> = force.iter().zip(&self.silent).map(|(f, rests)| if *rests { *f } else { 0.0 }).collect();
        let (commanded, whole) = (encoder(&at_rest).ok_or_else(short)?, encoder(force).ok_or_else(short)?);
        let factor_m: Vec<f64> = force.iter().map(|f| FACTOR * f / stiffness).collect();
        let factor_m = low_pass.forward_backward(&lagging(&factor_m, 0.0, lag)).ok_or_else(short)?;
        let mut further = self.read(point, "position_m".into(), &self.position_m, (&commanded, 1.0), machine).ok_or_else(short)?;
        // The loops take their readings late, by times that no record tells: beside what is in proportion to the velocity, the acceleration with the lag.
        let late = lagging(&self.acceleration_m_s2, 0.0, lag);
        further.beside.push(self.decimated(&late).ok_or_else(short)?);
        let apart: Vec<f64> = self.position_m.iter().zip(&whole).map(|(x, e)| x - e).collect();
        let (low, high) = extremes(&apart);
        let turning = self.turning(high - low);
        let uncounted: Vec<bool> = turning.iter().zip(&self.silent).map(|(turning, rests)| *turning || *rests).collect();
        let uncounted = self.around(&uncounted, LAGS / loops.position);
        further.counts.iter_mut().zip(uncounted).for_each(|(counts, not)| *counts &= !not);
        further.told = Some(EncoderEstimate { lag, stiffness, factor_m, periods_s: loops.periods_s });
        self.further.push(further);
        Ok(self)
    }
}
