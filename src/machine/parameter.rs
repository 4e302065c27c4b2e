//! The numbers that are not known.

use schemars::JsonSchema;
use serde::Deserialize;

use super::schema::words_alone;

/// Whether a parameter is searched on a logarithmic or a linear scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "ScaleFile", rename_all = "lowercase")]
#[schemars(transform = words_alone)]
pub enum Scale {
    /// For positive quantities over decades: stiffness, damping.
    Logarithmic,
    /// For quantities that may be zero or change sign.
    Linear,
}

/// From which data a parameter is fitted; otherwise it keeps its start value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename = "FitFile", rename_all = "lowercase")]
#[schemars(transform = words_alone)]
pub enum FitRule {
    /// From modes and from whole FRFs.
    #[default]
    Always,
    /// From whole FRFs alone: modes do not determine it.
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
    /// Start value, in that unit.
    pub start: f64,
    /// Lower end of the plausible range.
    pub lower: f64,
    /// Upper end of the plausible range.
    pub upper: f64,
    /// Scale it is searched on.
    pub scale: Scale,
    /// From which data it is fitted.
    pub fit: FitRule,
    /// What is known of it before it is fitted (a weighed mass, a catalogue value); enters a fit as one observation more. `None`: every value of the range
    /// is equally plausible.
    pub prior: Option<Prior>,
    /// Where range and start come from.
    pub source: String,
}

/// Prior distribution of a parameter around its start value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Normal, with this standard deviation in the parameter's unit.
    Normal(f64),
    /// Log-normal: the logarithm of the parameter has this standard deviation, the start value is the median.
    LogNormal(f64),
}

impl Prior {
    /// Deviation of a value from the start value, in standard deviations.
    pub fn deviation(self, start: f64, value: f64) -> f64 {
        match self {
            Prior::Normal(sd) => (value - start) / sd,
            Prior::LogNormal(sd) => (value / start).ln() / sd,
        }
    }

    /// Derivative of [`Prior::deviation`] with the value.
    pub fn slope(self, value: f64) -> f64 {
        match self {
            Prior::Normal(sd) => 1.0 / sd,
            Prior::LogNormal(sd) => 1.0 / (sd * value),
        }
    }

    /// The value so many standard deviations from the start value.
    pub fn value(self, start: f64, deviation: f64) -> f64 {
        match self {
            Prior::Normal(sd) => start + sd * deviation,
            Prior::LogNormal(sd) => start * (sd * deviation).exp(),
        }
    }

    /// Its standard deviation: in the parameter's unit, or of the logarithm.
    pub fn sd(self) -> f64 {
        let (Prior::Normal(sd) | Prior::LogNormal(sd)) = self;
        sd
    }
}

impl Parameter {
    /// Deviation of a value from the start value in standard deviations of the prior; `None` without a prior.
    pub fn deviation(&self, value: f64) -> Option<f64> {
        Some(self.prior?.deviation(self.start, value))
    }

    /// Its place in the unit interval of its range: 0 at `lower`, 1 at `upper`.
    pub fn to_unit(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic => (value / self.lower).ln() / (self.upper / self.lower).ln(),
            Scale::Linear => (value - self.lower) / (self.upper - self.lower),
        }
    }

    /// Whether a value lies within its range and at neither end.
    pub fn holds_inside(&self, value: f64) -> bool {
        value > self.lower && value < self.upper
    }

    /// Derivative of the value with its place in the unit interval.
    pub fn unit_slope(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic => value * (self.upper / self.lower).ln(),
            Scale::Linear => self.upper - self.lower,
        }
    }

    /// Its value at a place in the unit interval.
    pub fn from_unit(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic => self.lower * (place * (self.upper / self.lower).ln()).exp(),
            Scale::Linear => self.lower + place * (self.upper - self.lower),
        }
    }

    /// A value a share of the range further, or back where that would leave it: for differences.
    pub fn stepped(&self, value: f64, share: f64) -> f64 {
        let unit = self.to_unit(value);
        self.from_unit(if unit + share <= 1.0 { unit + share } else { unit - share })
    }
}
