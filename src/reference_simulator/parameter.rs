//! Unknown parameters of descriptions.

use std::fmt::Write;

/// An unknown parameter with its plausible range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Start value.
    pub start: f64,
    /// Least plausible value.
    pub lower: f64,
    /// Largest plausible value.
    pub upper: f64,
    /// Further key of the parameter in a machine file, with its value.
    pub further: Option<(&'static str, &'static str)>,
    /// Source of the range.
    pub source: &'static str,
}

impl Parameter {
    /// Creates a parameter from its start and limits.
    pub fn new(
        name: &'static str,
        unit: &'static str,
        [start, lower, upper]: [f64; 3],
        source: &'static str,
    ) -> Self {
        Self { name, unit, start, lower, upper, further: None, source }
    }

    /// Writes the parameter's table of a machine file.
    pub fn write(&self, out: &mut String) {
        let Self { name, unit, start, lower, upper, further, source } = self;
        let _ = writeln!(
            out,
            "[parameter.{name}]\nunit = \"{unit}\"\nstart = {start:e}\nlower = {lower:e}\nupper = {upper:e}"
        );
        if let Some((key, value)) = further {
            let _ = writeln!(out, "{key} = \"{value}\"");
        }
        let _ = writeln!(out, "source = \"{source}\"\n");
    }
}
