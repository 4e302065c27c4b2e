//! Parameters of a machine as a list of numbers, in two systems of coordinates that cannot be mixed up.

use serde::{Deserialize, Serialize};

use super::Machine;

/// Values of all parameters of a machine, in its order, each in its own unit.
#[derive(Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ParameterValues(pub Vec<f64>);

/// Coordinates of all parameters of a machine, in its order, each in the unit interval of its range: 0 at
/// `lower`, 1 at `upper`.
///
/// They are not values:
///
/// ```compile_fail,E0308
/// fn twice(machine: &jointid_machine::Machine, values: &jointid_machine::ParameterValues) -> jointid_machine::ParameterValues {
///     machine.from_units(values)
/// }
/// ```
#[derive(Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct UnitValues(pub Vec<f64>);

impl Machine {
    /// Maps the values of its first parameters to the unit intervals of their ranges.
    pub fn to_units(&self, values: &ParameterValues) -> UnitValues {
        UnitValues(
            self.parameters.iter().zip(values).map(|(parameter, value)| parameter.to_unit(*value)).collect(),
        )
    }

    /// Returns the values of its first parameters at given unit coordinates.
    pub fn from_units(&self, units: &UnitValues) -> ParameterValues {
        ParameterValues(
            self.parameters.iter().zip(units).map(|(parameter, unit)| parameter.from_unit(*unit)).collect(),
        )
    }
}

/// Gives a list of numbers in one system of coordinates the reading access of a slice. It is built only
/// explicitly. Its debug text is that of a plain list, since names of stored results contain it.
#[macro_export]
macro_rules! numbers_as_slice {
    ($($name:ty),+) => {$(
        impl ::std::ops::Deref for $name {
            type Target = [f64];
            fn deref(&self) -> &[f64] {
                &self.0
            }
        }

        impl ::std::ops::DerefMut for $name {
            fn deref_mut(&mut self) -> &mut [f64] {
                &mut self.0
            }
        }

        impl<'n> IntoIterator for &'n $name {
            type Item = &'n f64;
            type IntoIter = ::std::slice::Iter<'n, f64>;
            fn into_iter(self) -> Self::IntoIter {
                self.0.iter()
            }
        }

        impl<'n> IntoIterator for &'n mut $name {
            type Item = &'n mut f64;
            type IntoIter = ::std::slice::IterMut<'n, f64>;
            fn into_iter(self) -> Self::IntoIter {
                self.0.iter_mut()
            }
        }

        impl IntoIterator for $name {
            type Item = f64;
            type IntoIter = ::std::vec::IntoIter<f64>;
            fn into_iter(self) -> Self::IntoIter {
                self.0.into_iter()
            }
        }

        impl ::std::fmt::Debug for $name {
            fn fmt(&self, formatter: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                self.0.fmt(formatter)
            }
        }
    )+};
}

numbers_as_slice!(ParameterValues, UnitValues);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn debug_text_is_that_of_a_plain_list() {
        assert_eq!(
            format!("{:?} {:?}", ParameterValues(vec![1.0, 2.5]), UnitValues(vec![0.5])),
            "[1.0, 2.5] [0.5]"
        );
    }
}
