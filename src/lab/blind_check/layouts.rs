//! Kinds of data of the cases, and choice of the layouts of machines.

use reference_simulator::Layout;
use reference_simulator::motion::MotionLayout;

/// Kind of data of the cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arm {
    /// Hammer tests.
    Frf,
    /// Time records of a driven axis.
    Motion,
}

/// Layouts of the machines of an arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layouts {
    /// All layouts in turn.
    All,
    /// The layout of this name, of either arm.
    One(&'static str),
}

impl Layouts {
    /// Returns the layouts of a name: that of a layout of either arm, or `all`.
    pub fn named(name: &str) -> Option<Self> {
        let of_either =
            || [Arm::Frf, Arm::Motion].into_iter().flat_map(Self::names).find(|known| *known == name);
        if name == "all" { Some(Layouts::All) } else { of_either().map(Layouts::One) }
    }

    /// Returns the names of the layouts of an arm.
    pub fn names(arm: Arm) -> Vec<&'static str> {
        match arm {
            Arm::Frf => Layout::ALL.iter().map(|layout| layout.name()).collect(),
            Arm::Motion => MotionLayout::ALL.iter().map(|layout| layout.name()).collect(),
        }
    }

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Layouts::All => "all",
            Layouts::One(name) => name,
        }
    }
}
