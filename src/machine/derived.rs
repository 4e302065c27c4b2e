//! Quantities that follow from a machine's parameters.

/// A named quantity to be reported beside the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// Name, with its unit, for example `resonance_hz`.
    pub name: String,
    /// How it follows.
    pub from: Derivation,
}

/// How a quantity follows from a machine's parameters. Points are given by index.
#[derive(Debug, Clone, PartialEq)]
pub enum Derivation {
    /// The n-th (from 1) undamped natural frequency above 0 Hz.
    NaturalFrequency(usize),
    /// The n-th (from 1) frequency above 0 Hz at which a point rests when it is excited itself: a natural frequency of the machine with that
    /// point held.
    Antiresonance(usize, usize),
    /// Inertia of the first point over that of the second.
    InertiaRatio(usize, usize),
    /// A parameter under another name.
    Parameter(usize),
}
