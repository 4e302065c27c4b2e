//! A switching inverter: the voltage of a period as pulses.

use std::f64::consts::{FRAC_PI_3, TAU};

use super::force_element::Input;

/// log₂ of the timer's steps per period: pulses begin and end at multiples of 2⁻¹⁰ of a period.
pub const LEVELS: u8 = 10;

/// Rotation of the driven shaft at the start of a period.
#[derive(Debug, Clone, Copy)]
pub struct ShaftRotation {
    /// Electrical angle (rad).
    pub angle: f64,
    /// Advance of the electrical angle over a period (rad).
    pub advance: f64,
}

/// A constant voltage over a part of a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// Voltages along q and d at mid-pulse.
    pub input: Input,
    /// Start and end in timer steps.
    pub from: u32,
    pub to: u32,
}

/// Computes the space-vector pulses whose mean over a period is the wanted voltage (q, d). The period is half
/// of the carrier's, rising (`false`) or falling.
///
/// ```text
/// T₁ = √3·|u|/U·sin(π/3 − γ)·T,     T₂ = √3·|u|/U·sin γ·T,     zero voltage for the rest of T, half of it before and half after
/// ```
///
/// γ is the angle of u from the first adjacent vector.
///
/// # Limits     |u| ≤ U/√3, which the current loop observes
/// # Source     hybrid multi-domain, section 2.3 and Fig. 6; van der Broeck, Skudelny and Stanke, IEEE Trans.
///   Ind. Appl. 24 (1988) 142–150
pub fn pulses(wanted: Input, dc_link_v: f64, rotation: ShaftRotation, down: bool) -> [Pulse; 4] {
    let parts = f64::from(1_u32 << LEVELS);
    let size = wanted[0].hypot(wanted[1]);
    // The d axis is the real axis. The wanted vector is fixed in space at the shaft's angle in mid-period.
    let angle = (wanted[0].atan2(wanted[1]) + rotation.angle + 0.5 * rotation.advance).rem_euclid(TAU);
    let sector = (angle / FRAC_PI_3).floor().min(5.0);
    let gamma = angle - sector * FRAC_PI_3;
    let share = 3.0_f64.sqrt() * size / dc_link_v;
    let (first, second) = (share * (FRAC_PI_3 - gamma).sin(), share * gamma.sin());
    let (near, next) = ((Some(sector), first), (Some(sector + 1.0), second));
    // On the rising half the first leg of a sector switches first; each step switches one leg.
    let zero = (None, 0.5 * (1.0 - first - second).max(0.0));
    let active = if (sector as u32).is_multiple_of(2) { [near, next] } else { [next, near] };
    let mut order = [zero, active[0], active[1], zero];
    if down {
        order.reverse();
    }
    let mut from = 0;
    let mut end = 0.0;
    let last = order.len() - 1;
    let mut at = 0;
    order.map(|(vector, share)| {
        end += share;
        let to =
            if at == last { 1 << LEVELS } else { ((end * parts).round() as u32).clamp(from, 1 << LEVELS) };
        at += 1;
        let middle = rotation.angle + rotation.advance * 0.5 * f64::from(from + to) / parts;
        let input = vector.map_or([0.0; 2], |n: f64| {
            let (sin, cos) = (n * FRAC_PI_3 - middle).sin_cos();
            [2.0 / 3.0 * dc_link_v * sin, 2.0 / 3.0 * dc_link_v * cos]
        });
        let pulse = Pulse { input, from, to };
        from = to;
        pulse
    })
}

impl Pulse {
    /// Splits the pulse into pieces of 2^−level of the period, each starting at a multiple of its length.
    /// Yields level and start in timer steps.
    pub fn pieces(self) -> impl Iterator<Item = (u8, u32)> {
        let mut from = self.from;
        std::iter::from_fn(move || {
            let left = self.to - from;
            if left == 0 {
                return None;
            }
            let size = (31 - left.leading_zeros())
                .min(if from == 0 { 31 } else { from.trailing_zeros() })
                .min(u32::from(LEVELS));
            let piece = (LEVELS - size as u8, from);
            from += 1 << size;
            Some(piece)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of a period's pulses in the fixed frame is the wanted vector at any angle; the pieces cover
    /// the period once.
    #[test]
    fn energy_pulses_give_the_wanted_voltage_on_average() {
        let dc_link_v = 560.0;
        for degrees in 0..360 {
            for (size, down) in [(10.0, false), (150.0, true), (dc_link_v / 3.0_f64.sqrt(), false)] {
                let angle = f64::from(degrees).to_radians();
                let wanted = [size * angle.sin(), size * angle.cos()];
                let rotation = ShaftRotation { angle: 0.3, advance: 0.0 };
                let pulses = pulses(wanted, dc_link_v, rotation, down);
                let mean = |axis: usize| {
                    pulses.iter().map(|p| p.input[axis] * f64::from(p.to - p.from) / 1024.0).sum::<f64>()
                };
                // Two edges, each rounded to half a part of the period.
                let resolution = 2.0 / 3.0 * dc_link_v / 1024.0;
                assert!(
                    (mean(0) - wanted[0]).abs() < resolution && (mean(1) - wanted[1]).abs() < resolution,
                    "{degrees}° {size}: {pulses:?}"
                );
                let mut at = 0;
                for (level, from) in pulses.iter().flat_map(|p| p.pieces()) {
                    assert_eq!((from, from % (1 << (LEVELS - level))), (at, 0));
                    at += 1 << (LEVELS - level);
                }
                assert_eq!(at, 1024);
            }
        }
    }
}
