//! Phases of a motion, from its reference alone.

named! {
    /// Phase of a motion.
    pub enum Phase {
        /// All of them.
        ALL {
            /// The reference has been at rest for a while.
            Dwell = "dwell",
            /// The reference has just begun to move.
            Breakaway = "breakaway",
            /// The reference reverses.
            Reversal = "reversal",
            /// The speed changes.
            Acceleration = "acceleration",
            /// The speed is constant.
            ConstantSpeed = "constant-speed",
            /// The reference has just come to rest.
            Settling = "settling",
        }
    }
}

/// Duration after a change of direction that belongs to the reversal, s; half of it before the change belongs
/// to it, too.
const REVERSAL_S: f64 = 0.06;

/// Duration after a start that belongs to the breakaway, s.
const BREAKAWAY_S: f64 = 0.06;

/// Duration after a stop that belongs to the settling, s.
const SETTLING_S: f64 = 0.12;

/// Returns the phase of each sample of a reference.
pub fn phases(command_m: &[f64], period_s: f64) -> Vec<Phase> {
    let count = command_m.len();
    let speed: Vec<f64> = (0..count)
        .map(|k| (command_m[(k + 1).min(count - 1)] - command_m[k.saturating_sub(1)]) / (2.0 * period_s))
        .collect();
    let largest = speed.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let moves: Vec<i8> =
        speed.iter().map(|v| if v.abs() < 1e-4 * largest { 0 } else { v.signum() as i8 }).collect();
    let steady =
        |k: usize| (speed[(k + 1).min(count - 1)] - speed[k.saturating_sub(1)]).abs() < 4e-4 * speed[k].abs();
    let mut out: Vec<Phase> = (0..count)
        .map(|k| match moves[k] {
            0 => Phase::Dwell,
            _ if steady(k) => Phase::ConstantSpeed,
            _ => Phase::Acceleration,
        })
        .collect();
    let samples = |time_s: f64| (time_s / period_s).round() as usize;
    let mut rest_samples = samples(1.0);
    let mut last = 0;
    for k in 0..count {
        if moves[k] == 0 {
            rest_samples += 1;
            continue;
        }
        if rest_samples > samples(0.02) {
            let end = (k + samples(BREAKAWAY_S)).min(count);
            out[k..end].iter_mut().for_each(|phase| *phase = Phase::Breakaway);
        } else if last != 0 && moves[k] != last {
            let (from, end) =
                (k.saturating_sub(samples(REVERSAL_S) / 2), (k + samples(REVERSAL_S)).min(count));
            out[from..end].iter_mut().for_each(|phase| *phase = Phase::Reversal);
        }
        (rest_samples, last) = (0, moves[k]);
    }
    let mut moving = false;
    let mut since = usize::MAX;
    for k in 0..count {
        if moves[k] != 0 {
            moving = true;
            since = 0;
        } else if moving {
            since += 1;
            if since <= samples(SETTLING_S) && out[k] == Phase::Dwell {
                out[k] = Phase::Settling;
            }
        }
    }
    out
}
