//! Parameters in words.

use super::number::Reach;
use super::{Machine, Value};

impl Machine {
    /// Describes a parameter: as its file states, else by the first number of the machine that depends on it,
    /// such as «damping of bearing-left»; numbers of the structure come before those of motion. Empty where
    /// no number does.
    pub fn description_of(&self, parameter: usize) -> String {
        let stated = &self.parameters[parameter].description;
        if !stated.is_empty() {
            return stated.clone();
        }
        let depends = |value: &Value| value.depends_on().any(|index| index == parameter);
        let named = self.numbers().filter(|(number, _, value)| !number.words.is_empty() && depends(value));
        let first = named.min_by_key(|(number, ..)| number.reach != Reach::All);
        first.map(|(number, part, _)| number.words.replace("{}", part)).unwrap_or_default()
    }
}
