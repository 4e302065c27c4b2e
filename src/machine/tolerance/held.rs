//! Tolerances held at estimated values.

use std::collections::BTreeMap;

use crate::{Machine, MachineError, Tolerance};

impl Machine {
    /// Returns the machine with its tolerances held at values: numbers of the description from then on, with
    /// no tolerance left. Tolerances without a value stay as described. The second number lists the names to
    /// which no tolerance belongs.
    ///
    /// `nuts_m` (m) are the nut positions of the set from which the values were estimated: the lengths of
    /// journals and nuts depend on them.
    ///
    /// # Errors  as [`Machine::with_tolerances`].
    pub fn with_tolerances_held(
        &self,
        nuts_m: &[f64],
        values: &BTreeMap<String, f64>,
    ) -> Result<(Machine, Vec<String>), MachineError> {
        let mut machine = self.with_tolerances(nuts_m)?;
        let tolerances = || machine.parameters.iter().filter(|p| p.is_tolerance());
        let unknown =
            values.keys().filter(|name| !tolerances().any(|p| p.name() == *name)).cloned().collect();
        let held: Vec<Option<f64>> = machine
            .parameters
            .iter()
            .map(|p| {
                p.is_tolerance()
                    .then(|| values.get(p.name()).map_or(p.start, |value| value.clamp(p.lower, p.upper)))
            })
            .collect();
        machine.change_numbers(&mut |_, _, value| value.hold(&|index| held[index]));
        machine.drop_unused_parameters();
        machine.tolerance = Tolerance::NONE;
        Ok((machine, unknown))
    }
}
