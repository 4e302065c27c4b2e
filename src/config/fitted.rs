//! Configuration section of tolerances at identified values.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::fault;
use machine::{Machine, MachineError};

/// Tolerances at identified values: numbers of the machine from then on. A file of an identified machine
/// contains it.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedFile {
    /// Nut positions (m) of the measurement set, on which the lengths of journals and nuts depend.
    nuts_m: Vec<f64>,
    /// Value of each tolerance by its name in an identification; those of `[tolerance]` that are not named
    /// stay as described.
    tolerances: BTreeMap<String, f64>,
}

impl FittedFile {
    /// Returns the machine with its tolerances held at these values. `removed` tells whether effects were
    /// taken out, and tolerances with them.
    pub(super) fn applied(&self, machine: &Machine, removed: bool) -> Result<Machine, MachineError> {
        let stroke_m = machine.stroke_m().unwrap_or(f64::INFINITY);
        if let Some(nut_m) = self.nuts_m.iter().find(|nut_m| !(0.0..=stroke_m).contains(*nut_m)) {
            return Err(fault(
                "fitted.nuts_m",
                format!("{nut_m} lies outside the screw; write positions from 0 to {stroke_m} m"),
            ));
        }
        if let Some((name, value)) = self.tolerances.iter().find(|(_, value)| !value.is_finite()) {
            return Err(fault(
                format!("fitted.tolerances.{name}"),
                format!("is {value}; write a finite number"),
            ));
        }
        let (held, unknown) = machine.with_tolerances_held(&self.nuts_m, &self.tolerances)?;
        match unknown.first().filter(|_| !removed) {
            Some(name) => Err(fault(
                format!("fitted.tolerances.{name}"),
                "the machine has no such tolerance; remove the line",
            )),
            None => Ok(held),
        }
    }
}
