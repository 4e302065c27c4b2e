//! Derived quantities: quantities computed from a machine's parameters.

use schemars::JsonSchema;
use serde::Deserialize;

/// A named quantity that is reported together with the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// Name, with its unit, for example `resonance_hz`.
    pub name: String,
    /// Its derivation.
    pub from: Derivation,
}

/// The derivation of a quantity from a machine's parameters. Points are given by index.
#[derive(Debug, Clone, PartialEq)]
pub enum Derivation {
    /// The n-th (from 1) undamped natural frequency above 0 Hz.
    NaturalFrequency(usize),
    /// The n-th (from 1) antiresonance above 0 Hz of the driving-point response at a point: a natural
    /// frequency of the machine with that point fixed.
    Antiresonance(usize, usize),
    /// Inertia of the first point divided by that of the second.
    InertiaRatio(usize, usize),
    /// A parameter under another name.
    Parameter(usize),
}

/// A derived quantity: one of four kinds.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    rename = "DerivedFile",
    untagged,
    expecting = "expected { natural_frequency = n }, { antiresonance = n, at = \"point\" }, { inertia = [\"a\", \"b\"] } or { parameter = \"id\" }"
)]
pub enum DerivedPatch {
    /// n-th undamped natural frequency above 0.
    NaturalFrequency {
        /// n.
        natural_frequency: usize,
    },
    /// n-th antiresonance at a point.
    Antiresonance {
        /// n.
        antiresonance: usize,
        /// The point.
        at: String,
    },
    /// Inertia of one point divided by that of another.
    InertiaRatio {
        /// The two points.
        inertia: [String; 2],
    },
    /// A parameter.
    Parameter {
        /// Its id.
        parameter: String,
    },
}
