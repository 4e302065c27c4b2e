//! Data faults of one record.

use crate::draw::Draw;
use crate::motion::run::{Log, RECORD_S};

/// A data fault of one record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DataFault {
    /// The position channel is late, s.
    Late(f64),
    /// The force is clipped at a share of its largest value, before the converter's noise.
    Clipped(f64),
    /// The force has a wrong range factor, larger than 1.
    Range(f64),
}

impl DataFault {
    /// Draws a data fault.
    pub fn random(draw: &mut Draw) -> Self {
        match draw.index(3) {
            0 => Self::Late(draw.between(0.8e-3, 1.6e-3)),
            1 => Self::Clipped(draw.between(0.35, 0.55)),
            _ => Self::Range(draw.between(1.15, 1.35)),
        }
    }

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Late(_) => "late",
            Self::Clipped(_) => "clipped",
            Self::Range(_) => "range",
        }
    }

    /// Applies the data fault to an exact record.
    pub fn distort(self, log: &mut Log) {
        match self {
            Self::Late(late_s) => {
                let late = late_s / RECORD_S;
                let old = log.position_m.clone();
                for (k, position) in log.position_m.iter_mut().enumerate() {
                    let at = (k as f64 - late).max(0.0);
                    let (floor, part) = (at as usize, at.fract());
                    *position = old[floor] + part * (old[(floor + 1).min(old.len() - 1)] - old[floor]);
                }
            }
            Self::Clipped(share) => {
                let largest = share * log.force_n.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                log.force_n.iter_mut().for_each(|force| *force = force.clamp(-largest, largest));
            }
            Self::Range(factor) => log.force_n.iter_mut().for_each(|force| *force *= factor),
        }
    }
}
