//! Parameters: the unknown numbers of a machine.

use schemars::JsonSchema;
use serde::Deserialize;

use super::schema::enum_without_descriptions;
use super::{Mechanism, Role};

/// The scale on which a parameter is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "ScaleFile", rename_all = "lowercase")]
#[schemars(transform = enum_without_descriptions)]
pub enum Scale {
    /// For positive quantities that span decades: stiffness, damping.
    Logarithmic,
    /// For quantities that may be zero or change sign.
    Linear,
}

/// The data from which a parameter is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename = "FitFile", rename_all = "lowercase")]
#[schemars(transform = enum_without_descriptions)]
pub enum FitRule {
    /// From modes and from whole FRFs.
    #[default]
    Always,
    /// From whole FRFs only: modes do not determine it.
    Frf,
    /// Never: it keeps its start value.
    Never,
}

/// An unknown number of a machine with its plausible range.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Unique id, for example `k_al`.
    pub id: String,
    /// Unit, for example `N/m`.
    pub unit: String,
    /// Physical meaning.
    pub mechanism: Mechanism,
    /// Origin.
    pub role: Role,
    /// Start value, in that unit.
    pub start: f64,
    /// Lower end of the plausible range.
    pub lower: f64,
    /// Upper end of the plausible range.
    pub upper: f64,
    /// Scale on which it is searched.
    pub scale: Scale,
    /// Data from which it is fitted.
    pub fit: FitRule,
    /// Prior knowledge (a weighed mass, a catalogue value); it enters a fit as one additional observation.
    /// `None`: all values of the range are equally plausible.
    pub prior: Option<Prior>,
    /// Source of range and start value.
    pub source: String,
    /// What it is, as the machine's file states; empty where the file states nothing.
    pub description: String,
}

/// Prior distribution of a parameter, centred on its start value unless it states its own median.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Normal, with this standard deviation in the parameter's unit.
    Normal(f64),
    /// Log-normal above the start value, its median, with this standard deviation of the logarithm; below it
    /// normal, with the start value times this as the standard deviation. A number that may as well be absent,
    /// as a loss factor, is thus not excluded at zero.
    LogNormal(f64),
    /// Log-normal about a median of its own, such as a catalogue value, in the parameter's unit: median, and
    /// standard deviation of the logarithm.
    Catalogue(f64, f64),
}

impl Prior {
    /// Returns the deviation of a value from the start value, in standard deviations.
    pub fn deviation(self, start: f64, value: f64) -> f64 {
        match self {
            Prior::Normal(sd) => (value - start) / sd,
            Prior::LogNormal(sd) if value < start => (value / start - 1.0) / sd,
            Prior::LogNormal(sd) => (value / start).ln() / sd,
            Prior::Catalogue(median, sd) => (value / median).ln() / sd,
        }
    }

    /// Returns the derivative of [`Prior::deviation`] with respect to the value.
    fn slope(self, start: f64, value: f64) -> f64 {
        match self {
            Prior::Normal(sd) => 1.0 / sd,
            Prior::LogNormal(sd) if value < start => 1.0 / (sd * start),
            Prior::LogNormal(sd) | Prior::Catalogue(_, sd) => 1.0 / (sd * value),
        }
    }

    /// Returns the value at a deviation from the start value, given in standard deviations.
    pub fn value(self, start: f64, deviation: f64) -> f64 {
        match self {
            Prior::Normal(sd) => start + sd * deviation,
            Prior::LogNormal(sd) if deviation < 0.0 => start * (1.0 + sd * deviation),
            Prior::LogNormal(sd) => start * (sd * deviation).exp(),
            Prior::Catalogue(median, sd) => median * (sd * deviation).exp(),
        }
    }

    /// Returns the standard deviation: in the parameter's unit, or of the logarithm.
    pub fn sd(self) -> f64 {
        let (Prior::Normal(sd) | Prior::LogNormal(sd) | Prior::Catalogue(_, sd)) = self;
        sd
    }
}

impl Parameter {
    /// Whether it is of the same kind as another parameter, so that their sum means something.
    pub fn is_like(&self, other: &Parameter) -> bool {
        self.mechanism == other.mechanism && self.unit == other.unit
    }

    /// Whether a value lies at an end of the plausible range: within a thousandth of it, on the parameter's
    /// scale.
    pub fn is_at_bound(&self, value: f64) -> bool {
        let place = self.to_unit(value);
        !(1e-3..=1.0 - 1e-3).contains(&place)
    }

    /// Returns the deviation of a value from the start value in standard deviations of the prior; `None`
    /// without a prior.
    pub fn deviation(&self, value: f64) -> Option<f64> {
        Some(self.prior?.deviation(self.start, value))
    }

    /// Returns the derivative of this deviation with respect to the coordinate in the unit interval of its
    /// range; `None` without a prior.
    pub fn deviation_slope(&self, value: f64) -> Option<f64> {
        Some(self.prior?.slope(self.start, value) * self.unit_slope(value))
    }

    /// Maps a value to the unit interval of its range: 0 at `lower`, 1 at `upper`.
    pub fn to_unit(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic => (value / self.lower).ln() / (self.upper / self.lower).ln(),
            Scale::Linear => (value - self.lower) / (self.upper - self.lower),
        }
    }

    /// Whether a value lies strictly inside its range.
    pub fn holds_inside(&self, value: f64) -> bool {
        value > self.lower && value < self.upper
    }

    /// Returns the derivative of the value with respect to its unit coordinate.
    pub fn unit_slope(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic => value * (self.upper / self.lower).ln(),
            Scale::Linear => self.upper - self.lower,
        }
    }

    /// Returns the value at a unit coordinate.
    pub fn from_unit(&self, unit: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic => self.lower * (unit * (self.upper / self.lower).ln()).exp(),
            Scale::Linear => self.lower + unit * (self.upper - self.lower),
        }
    }

    /// Returns a value shifted by a share of the range, for finite differences. The shift is downward where
    /// it would leave the range.
    pub fn stepped(&self, value: f64, share: f64) -> f64 {
        let unit = self.to_unit(value);
        self.from_unit(if unit + share <= 1.0 { unit + share } else { unit - share })
    }
}
