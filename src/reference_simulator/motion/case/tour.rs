//! Motions of a test.

use crate::draw::Draw;
use crate::motion::catalogue::MotionLimits;
use crate::motion::path::{Path, Piece};

/// Set of motions of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tour {
    /// Strokes at several speeds, reversals and sines; other strokes are held out.
    Usual,
    /// Moves between random positions, a stepped sweep of sines, a creep with pauses; other moves and a sine
    /// are held out.
    Random,
    /// Slow reversals at very low acceleration.
    Gentle,
    /// Strokes at 0.3 to 0.6 of the rapid speed and 0.2 of the largest acceleration.
    Flat,
}

/// Names of the held-out motions.
pub const HELD_OUT: [&str; 2] = ["mixed", "slow-mixed"];

/// Returns the motions with their names.
pub fn tour(which: Tour, limits: &MotionLimits, draw: &mut Draw) -> Vec<(&'static str, Path)> {
    match which {
        Tour::Usual => usual(limits, draw),
        Tour::Random => random(limits, draw),
        Tour::Gentle => gentle(limits, draw),
        Tour::Flat => flat(limits, draw),
    }
}

fn stroke(limits: &MotionLimits, to: f64, speed: f64, acceleration: f64) -> Piece {
    Piece::Stroke {
        to_m: to * limits.stroke_m,
        speed_m_s: speed * limits.speed_m_s,
        acceleration_m_s2: acceleration * limits.acceleration_m_s2,
    }
}

fn usual(limits: &MotionLimits, draw: &mut Draw) -> Vec<(&'static str, Path)> {
    let at = |to: f64, speed: f64| stroke(limits, to, speed, 1.0);
    let strokes = vec![
        at(0.98, 1.0),
        Piece::Dwell(0.12),
        at(0.55, draw.between(0.5, 0.65)),
        at(0.62, draw.between(0.2, 0.3)),
        at(0.58, 0.08),
        at(0.05, draw.between(0.8, 0.95)),
    ];
    let mut reversals = Vec::new();
    for speed in [0.5, 0.25, 0.1, 0.05] {
        let reach = 0.5 + 0.12 * speed;
        for _ in 0..2 {
            reversals.extend([at(reach, speed), at(0.5, speed)]);
        }
    }
    // Sines that reach part of the speed limit and of the acceleration limit.
    let sine = |share: f64, faster: f64, cycles| {
        let omega = 0.8 * limits.acceleration_m_s2 / limits.speed_m_s;
        let amplitude_m = (share * limits.speed_m_s / omega).min(0.4 * limits.stroke_m);
        Piece::Sine { amplitude_m, frequency_hz: faster * omega / std::f64::consts::TAU, cycles }
    };
    let sines = vec![sine(0.8, 1.0, 2), sine(0.2, 2.0, 3)];
    let mixed = vec![
        at(0.9, draw.between(0.7, 0.8)),
        at(0.5, draw.between(0.35, 0.45)),
        at(0.56, 0.15),
        at(0.53, 0.06),
        at(0.7, 0.9),
        at(0.1, 1.0),
    ];
    let from = |start: f64, pieces| Path { start_m: start * limits.stroke_m, pieces };
    vec![
        ("strokes", from(0.03, strokes)),
        ("reversals", from(0.5, reversals)),
        ("sines", from(0.5, sines)),
        ("mixed", from(0.05, mixed)),
    ]
}

/// Moves at random, and sines of half to three times the frequency that reaches both limits.
fn random(limits: &MotionLimits, draw: &mut Draw) -> Vec<(&'static str, Path)> {
    let moves = |count: usize, least_speed: f64, draw: &mut Draw| {
        let mut at = 0.5;
        let mut pieces = Vec::new();
        for _ in 0..count {
            // At least a tenth of the stroke away.
            at = 0.05 + (at - 0.05 + draw.between(0.1, 0.8)) % 0.9;
            pieces.push(stroke(limits, at, draw.log_between(least_speed, 1.0), draw.between(0.3, 1.0)));
            if draw.chance(0.3) {
                pieces.push(Piece::Dwell(draw.between(0.05, 0.2)));
            }
        }
        pieces
    };
    let sine = |faster: f64, share: f64| {
        let omega = 0.8 * faster * limits.acceleration_m_s2 / limits.speed_m_s;
        let amplitude_m = (share * limits.speed_m_s / faster.max(1.0) / omega).min(0.4 * limits.stroke_m);
        Piece::Sine { amplitude_m, frequency_hz: omega / std::f64::consts::TAU, cycles: 2 }
    };
    let sweep: Vec<Piece> = [0.5, 1.0, 1.7, 3.0].map(|faster| sine(faster, draw.between(0.4, 0.9))).into();
    let mut creep = Vec::new();
    for _ in 0..4 {
        let speed = draw.log_between(0.04, 0.25);
        creep.extend([
            stroke(limits, 0.5 + 0.15 * speed, speed, 0.4),
            Piece::Dwell(0.06),
            stroke(limits, 0.5, speed, 0.4),
        ]);
    }
    let first = moves(6, 0.1, draw);
    let mut held_out = moves(5, 0.05, draw);
    held_out.extend([stroke(limits, 0.5, 0.5, 0.5), sine(0.8, 0.7)]);
    let from_middle = |pieces| Path { start_m: 0.5 * limits.stroke_m, pieces };
    vec![
        ("moves", from_middle(first)),
        ("sweep", from_middle(sweep)),
        ("creep", from_middle(creep)),
        ("mixed", from_middle(held_out)),
    ]
}

fn gentle(limits: &MotionLimits, draw: &mut Draw) -> Vec<(&'static str, Path)> {
    let mut turning = |name, start: f64, count: usize| {
        let mut pieces = Vec::new();
        for k in 0..count {
            let reach = start + (0.06 + 0.02 * draw.unit()) * if k % 2 == 0 { 1.0 } else { -1.0 };
            pieces.push(stroke(limits, reach, 0.12, 0.05));
        }
        (name, Path { start_m: start * limits.stroke_m, pieces })
    };
    vec![turning("slow-1", 0.3, 4), turning("slow-2", 0.7, 4), turning("slow-mixed", 0.5, 4)]
}

fn flat(limits: &MotionLimits, draw: &mut Draw) -> Vec<(&'static str, Path)> {
    let mut going = |name, first: f64, back: f64| {
        let speeds = [draw.between(0.5, 0.6), draw.between(0.3, 0.45)];
        let pieces = vec![stroke(limits, back, speeds[0], 0.2), stroke(limits, first, speeds[1], 0.2)];
        (name, Path { start_m: first * limits.stroke_m, pieces })
    };
    vec![going("slow-1", 0.03, 0.97), going("slow-2", 0.95, 0.05), going("slow-mixed", 0.1, 0.9)]
}
