//! Positions at which the machine was measured.

/// A named position of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Position {
    /// Name, for example `l1`.
    pub name: String,
    /// Nut position from the left bearing (m).
    pub nut_m: Option<f64>,
}
