//! Elements: rods and beams as chains, branch laws, and the assembled structure.

pub mod beam;
pub mod dense;
pub mod law;
pub mod rod;
pub mod structure;

/// A motion as a weighted sum of degrees of freedom.
pub type Form = Vec<(usize, f64)>;
