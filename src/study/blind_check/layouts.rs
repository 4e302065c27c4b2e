//! Choice of the layouts of machines.

use reference_simulator::Layout;

/// Layouts of the machines of hammer tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layouts {
    /// All layouts in turn.
    All,
    /// One layout.
    One(Layout),
}

impl Layouts {
    /// Returns the layouts of a name: that of a layout, or `all`.
    pub fn named(name: &str) -> Option<Self> {
        if name == "all" { Some(Layouts::All) } else { Layout::named(name).map(Layouts::One) }
    }

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Layouts::All => "all",
            Layouts::One(layout) => layout.name(),
        }
    }
}
