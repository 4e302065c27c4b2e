//! Reference motions.

use std::f64::consts::{PI, TAU};

/// Peak of the acceleration over its mean, less one.
const ROUND: f64 = 0.5;

/// A piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// To a position at a speed; the acceleration is a rounded step: its mean times 1 − ½ cos 2πτ over each ramp.
    Stroke {
        /// Target, m.
        to_m: f64,
        /// Speed, m/s.
        speed_m_s: f64,
        /// Largest acceleration, m/s².
        acceleration_m_s2: f64,
    },
    /// Rest, s.
    Dwell(f64),
    /// A sine about the present position that begins and ends gently, in its first and last cycle.
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
    /// How long it takes from a position, s.
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

    /// Position after a time, m.
    fn at(&self, from_m: f64, time_s: f64) -> f64 {
        match *self {
            Self::Stroke { to_m, speed_m_s, acceleration_m_s2 } => {
                let distance = (to_m - from_m).abs();
                let (speed, ramp_s) = ramp(distance, speed_m_s, acceleration_m_s2);
                let whole = self.duration_s(from_m);
                // Way of a ramp: ∫ V (τ − ½ sin(2πτ)/2π) dt.
                let way = |time: f64| {
                    let part = time / ramp_s;
                    speed * ramp_s * (0.5 * part * part + ROUND * ((TAU * part).cos() - 1.0) / (4.0 * PI * PI))
                };
                let gone = if time_s >= whole {
                    distance
                } else if time_s < ramp_s {
                    way(time_s)
                } else if time_s <= whole - ramp_s {
                    0.5 * speed * ramp_s + speed * (time_s - ramp_s)
                } else {
                    distance - way(whole - time_s)
                };
                from_m + gone * (to_m - from_m).signum()
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

/// Speed that a distance allows, and time of its ramp.
fn ramp(distance_m: f64, speed_m_s: f64, acceleration_m_s2: f64) -> (f64, f64) {
    let speed = speed_m_s.min((distance_m * acceleration_m_s2 / (1.0 + ROUND)).sqrt());
    (speed, (1.0 + ROUND) * speed / acceleration_m_s2)
}

/// A path: pieces one after another from a start.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Start, m.
    pub start_m: f64,
    /// Pieces.
    pub pieces: Vec<Piece>,
}

impl Path {
    /// How long it takes, s.
    pub fn duration_s(&self) -> f64 {
        let mut from = self.start_m;
        let mut whole = 0.0;
        for piece in &self.pieces {
            whole += piece.duration_s(from);
            from = piece.end_m(from);
        }
        whole
    }

    /// Positions at count moments, `step_s` apart, from time 0.
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
