//! Units as a factor to SI and exponents of base quantities.

use std::f64::consts::TAU;
use std::fmt;
use std::ops::{Div, Mul};

/// Exponents of length, mass, time, current and temperature. Angles have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dimension {
    /// Exponent of length (m).
    pub length: i32,
    /// Exponent of mass (kg).
    pub mass: i32,
    /// Exponent of time (s).
    pub time: i32,
    /// Exponent of current (A).
    pub current: i32,
    /// Exponent of temperature (K).
    pub temperature: i32,
}

impl Dimension {
    /// Frequency and angular velocity.
    pub const FREQUENCY: Self = Self::mechanical(0, 0, -1);
    /// Force.
    pub const FORCE: Self = Self::mechanical(1, 1, -2);
    /// Torque.
    pub const TORQUE: Self = Self::mechanical(2, 1, -2);

    /// Creates a dimension of mechanics from the exponents of length, mass and time.
    pub const fn mechanical(length: i32, mass: i32, time: i32) -> Self {
        Self { length, mass, time, current: 0, temperature: 0 }
    }

    fn plus(self, other: Self, sign: i32) -> Self {
        Self {
            length: self.length.saturating_add(sign.saturating_mul(other.length)),
            mass: self.mass.saturating_add(sign.saturating_mul(other.mass)),
            time: self.time.saturating_add(sign.saturating_mul(other.time)),
            current: self.current.saturating_add(sign.saturating_mul(other.current)),
            temperature: self.temperature.saturating_add(sign.saturating_mul(other.temperature)),
        }
    }

    /// Returns what a quantity of this dimension is called, such as «a velocity»; a quantity without a name
    /// is called by its SI unit.
    pub fn name(self) -> String {
        let of = |length, mass, time| Self::mechanical(length, mass, time);
        let known = [
            (of(0, 0, 0), "a number or an angle"),
            (of(1, 0, 0), "a length"),
            (of(1, 0, -1), "a velocity"),
            (of(1, 0, -2), "an acceleration"),
            (of(0, 0, 1), "a time"),
            (Self::FREQUENCY, "a frequency"),
            (of(0, 0, -2), "an angular acceleration"),
            (of(0, 1, 0), "a mass"),
            (of(2, 1, 0), "an inertia"),
            (Self::FORCE, "a force"),
            (Self::TORQUE, "a torque"),
            (of(0, 1, -2), "a stiffness"),
            (of(0, 1, -1), "a damping"),
            (of(2, 1, -1), "a rotational damping"),
            (of(-1, 1, -2), "a pressure"),
            (of(0, -1, 2), "a receptance"),
            (of(0, -1, 1), "a mobility"),
            (of(0, -1, 0), "an accelerance"),
            (Self { length: 2, mass: 1, time: -3, current: -1, temperature: 0 }, "a voltage"),
            (Self { current: 1, ..Self::default() }, "a current"),
            (Self { temperature: 1, ..Self::default() }, "a temperature"),
        ];
        known
            .iter()
            .find(|(dimension, _)| *dimension == self)
            .map_or_else(|| format!("a quantity in {self}"), |(_, name)| (*name).into())
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [
            ("kg", self.mass),
            ("m", self.length),
            ("s", self.time),
            ("A", self.current),
            ("K", self.temperature),
        ];
        let text = |(symbol, exponent): &(&str, i32)| {
            if *exponent == 1 { (*symbol).to_string() } else { format!("{symbol}^{exponent}") }
        };
        let used: Vec<String> = parts.iter().filter(|(_, exponent)| *exponent != 0).map(text).collect();
        f.write_str(if used.is_empty() { "1".into() } else { used.join("*") }.as_str())
    }
}

/// A unit: value in SI = value · factor · (2π)^turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Factor to SI, turns counted as 1.
    pub factor: f64,
    /// Dimension.
    pub dimension: Dimension,
    /// Exponent of turns or cycles, as in rpm and Hz.
    pub turns: i32,
    /// Exponent of angles in radians or degrees.
    pub angle: i32,
}

impl Unit {
    /// The unit of pure numbers.
    pub const ONE: Self = Self::of(1.0, Dimension::mechanical(0, 0, 0));

    /// Creates a unit without angles.
    pub const fn of(factor: f64, dimension: Dimension) -> Self {
        Self { factor, dimension, turns: 0, angle: 0 }
    }

    /// Returns the factor to SI, with angles in rad.
    pub fn to_si(self) -> f64 {
        self.factor * TAU.powi(self.turns)
    }

    /// Returns the factor to Hz; `None` where it is no unit of frequency. Units without angle, such as 1/s,
    /// count cycles.
    pub fn to_hz(self) -> Option<f64> {
        match (self.dimension == Dimension::FREQUENCY, self.turns, self.angle) {
            (true, 0 | 1, 0) => Some(self.factor),
            (true, 0, 1) => Some(self.factor / TAU),
            _ => None,
        }
    }

    /// Returns the factor to another unit; `None` where the dimensions differ.
    pub fn to(self, other: Self) -> Option<f64> {
        if self.dimension != other.dimension {
            return None;
        }
        match (self.to_hz(), other.to_hz()) {
            (Some(from), Some(to)) if other.turns == 1 => Some(from / to),
            _ => Some(self.to_si() / other.to_si()),
        }
    }

    /// Whether factor and exponents are those of a unit that is in use: nested powers may exceed all bounds.
    pub fn is_plausible(self) -> bool {
        let Dimension { length, mass, time, current, temperature } = self.dimension;
        let exponents = [length, mass, time, current, temperature, self.turns, self.angle];
        self.factor.is_normal()
            && self.factor > 0.0
            && exponents.iter().all(|exponent| (-20..=20).contains(exponent))
    }

    /// Returns its power.
    pub fn power(self, exponent: i32) -> Self {
        let Dimension { length, mass, time, current, temperature } = self.dimension;
        let [length, mass, time, current, temperature] =
            [length, mass, time, current, temperature].map(|e| e.saturating_mul(exponent));
        Self {
            factor: self.factor.powi(exponent),
            dimension: Dimension { length, mass, time, current, temperature },
            turns: self.turns.saturating_mul(exponent),
            angle: self.angle.saturating_mul(exponent),
        }
    }
}

impl Mul for Unit {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            factor: self.factor * other.factor,
            dimension: self.dimension.plus(other.dimension, 1),
            turns: self.turns.saturating_add(other.turns),
            angle: self.angle.saturating_add(other.angle),
        }
    }
}

impl Div for Unit {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        Self {
            factor: self.factor / other.factor,
            dimension: self.dimension.plus(other.dimension, -1),
            turns: self.turns.saturating_sub(other.turns),
            angle: self.angle.saturating_sub(other.angle),
        }
    }
}
