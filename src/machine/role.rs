//! Where a part or a parameter of a machine comes from.

/// Origin of a parameter, a point or a shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// The description contains it; parameters of effects count as described, too.
    #[default]
    Described,
    /// A point that an effect adds.
    Effect,
    /// [`Machine::with_tolerances`](super::Machine::with_tolerances) added it: a nuisance parameter, or a part that needs one.
    Tolerance,
    /// A diagnosis added it as part of a generic impedance.
    GenericImpedance,
}
