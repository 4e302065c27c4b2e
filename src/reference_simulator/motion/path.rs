//! Reference motions.

use std::f64::consts::{PI, TAU};

/// Excess of the peak acceleration over its mean, relative.
const PEAK_EXCESS: f64 = 0.5;

/// A piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// To a position at a speed. The acceleration of each ramp is its mean times 1 − cos(2πτ)/2.
    Stroke {
        /// Target, m.
        to_m: f64,
        /// Speed, m/s.
        speed_m_s: f64,
        /// Largest acceleration, m/s².
        acceleration_m_s2: f64,
    },
    /// Standstill, s.
    Dwell(f64),
    /// A sine about the present position, with a smooth start and end in its first and last cycle.
    Sine {
        /// Amplitude, m.
        amplitude_m: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Cycles.
        cycles: usize,
    },
}

impl Piece {
    /// Returns the duration from a position, s.
    pub fn duration_s(&self, from_m: f64) -> f64 {
        match *self {
            Self::Stroke { to_m, speed_m_s, acceleration_m_s2 } => {
                let (speed, ramp) = ramp((to_m - from_m).abs(), speed_m_s, acceleration_m_s2);
                if speed > 0.0 { (to_m - from_m).abs() / speed + ramp } else { 0.0 }
            }
            Self::Dwell(duration) => duration,
            Self::Sine { frequency_hz, cycles, .. } => cycles as f64 / frequency_hz,
        }
    }

    /// Returns the position after a time, m.
    fn at(&self, from_m: f64, time_s: f64) -> f64 {
        match *self {
            Self::Stroke { to_m, speed_m_s, acceleration_m_s2 } => {
                let distance = (to_m - from_m).abs();
                let (speed, ramp_s) = ramp(distance, speed_m_s, acceleration_m_s2);
                let whole = self.duration_s(from_m);
                // Distance during a ramp: ∫ V (τ − ½ sin(2πτ)/2π) dt.
                let ramp_distance = |time: f64| {
                    let part = time / ramp_s;
                    speed
                        * ramp_s
                        * (0.5 * part * part + PEAK_EXCESS * ((TAU * part).cos() - 1.0) / (4.0 * PI * PI))
                };
                let distance_gone = if time_s >= whole {
                    distance
                } else if time_s < ramp_s {
                    ramp_distance(time_s)
                } else if time_s <= whole - ramp_s {
                    0.5 * speed * ramp_s + speed * (time_s - ramp_s)
                } else {
                    distance - ramp_distance(whole - time_s)
                };
                from_m + distance_gone * (to_m - from_m).signum()
            }
            Self::Dwell(_) => from_m,
            Self::Sine { amplitude_m, frequency_hz, cycles } => {
                let (turn, last) = (time_s * frequency_hz, cycles as f64);
                let edge = turn.min(last - turn).clamp(0.0, 1.0);
                from_m + amplitude_m * (edge - (TAU * edge).sin() / TAU) * (TAU * turn).sin()
            }
        }
    }

    fn end_m(&self, from_m: f64) -> f64 {
        if let Self::Stroke { to_m, .. } = self { *to_m } else { from_m }
    }
}

/// Returns the speed that a distance allows, and the time of its ramp.
fn ramp(distance_m: f64, speed_m_s: f64, acceleration_m_s2: f64) -> (f64, f64) {
    let speed = speed_m_s.min((distance_m * acceleration_m_s2 / (1.0 + PEAK_EXCESS)).sqrt());
    (speed, (1.0 + PEAK_EXCESS) * speed / acceleration_m_s2)
}

/// A path: pieces in sequence from a start position.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Start position, m.
    pub start_m: f64,
    /// Pieces.
    pub pieces: Vec<Piece>,
}

impl Path {
    /// Returns the duration, s.
    pub fn duration_s(&self) -> f64 {
        let mut from = self.start_m;
        let mut whole = 0.0;
        for piece in &self.pieces {
            whole += piece.duration_s(from);
            from = piece.end_m(from);
        }
        whole
    }

    /// Returns the positions at `count` moments, `step_s` apart, from time 0.
    pub fn sampled(&self, step_s: f64, count: usize) -> Vec<f64> {
        let mut out = Vec::with_capacity(count);
        let (mut from, mut begun) = (self.start_m, 0.0);
        let mut pieces = self.pieces.iter();
        let mut piece = pieces.next();
        for k in 0..count {
            let time = k as f64 * step_s;
            while let Some(here) = piece.filter(|here| time - begun >= here.duration_s(from)) {
                begun += here.duration_s(from);
                from = here.end_m(from);
                piece = pieces.next();
            }
            out.push(piece.map_or(from, |here| here.at(from, time - begun)));
        }
        out
    }
}
