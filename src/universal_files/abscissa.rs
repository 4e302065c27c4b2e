//! Abscissa values, stored or implied.

use crate::place::FilePlace;
use crate::warning::{Warning, WarningKind};

/// Abscissa values of a record.
#[derive(Debug, Clone, PartialEq)]
pub enum Abscissa {
    /// Constant step; not stored in the file.
    Even {
        /// First value.
        first: f64,
        /// Step.
        step: f64,
        /// Number of values.
        count: usize,
    },
    /// One value for each ordinate.
    Uneven(Vec<f64>),
}

impl Abscissa {
    /// Returns the number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Even { count, .. } => *count,
            Self::Uneven(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the value at an index.
    pub fn at(&self, index: usize) -> Option<f64> {
        match self {
            Self::Even { first, step, count } => (index < *count).then(|| first + index as f64 * step),
            Self::Uneven(values) => values.get(index).copied(),
        }
    }

    /// Returns all values.
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::Even { first, step, count } => {
                (0..*count).map(|index| first + index as f64 * step).collect()
            }
            Self::Uneven(values) => values.clone(),
        }
    }

    /// Warns of negative, repeated and falling values.
    pub(crate) fn check(&self, place: FilePlace, warnings: &mut Vec<Warning>) {
        let (mut negative, mut repeated, mut falling) =
            (Tally::default(), Tally::default(), Tally::default());
        match self {
            &Self::Even { first, step, count } => {
                let last = first + count.saturating_sub(1) as f64 * step;
                if count > 0 && first < 0.0 {
                    let below =
                        if step > 0.0 { (-first / step).ceil().min(count as f64) as usize } else { count };
                    negative = Tally { count: below, index: 0, value: first };
                } else if count > 1 && last < 0.0 {
                    let index = ((first / -step).floor() as usize + 1).min(count - 1);
                    negative = Tally { count: count - index, index, value: first + index as f64 * step };
                }
                let steps = Tally { count: count.saturating_sub(1), index: 1, value: first + step };
                if step == 0.0 {
                    repeated = steps;
                } else if step < 0.0 {
                    falling = steps;
                }
            }
            Self::Uneven(values) => {
                for (index, &value) in values.iter().enumerate() {
                    negative.add(value < 0.0, index, value);
                    if let Some(&before) = index.checked_sub(1).and_then(|index| values.get(index)) {
                        repeated.add(value == before, index, value);
                        falling.add(value < before, index, value);
                    }
                }
            }
        }
        if let Tally { count: count @ 1.., index, value } = negative {
            warnings.push(WarningKind::NegativeAbscissa { index, value, count }.at(place));
        }
        if let Tally { count: count @ 1.., index, value } = repeated {
            warnings.push(WarningKind::RepeatedAbscissa { index, value, count }.at(place));
        }
        if let Tally { count: count @ 1.., index, value } = falling {
            warnings.push(WarningKind::FallingAbscissa { index, value, count }.at(place));
        }
    }
}

/// Number of occurrences of a fault, and the first one.
#[derive(Debug, Default)]
struct Tally {
    count: usize,
    index: usize,
    value: f64,
}

impl Tally {
    fn add(&mut self, found: bool, index: usize, value: f64) {
        if found {
            if self.count == 0 {
                (self.index, self.value) = (index, value);
            }
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_and_uneven_values_give_the_same_warnings() {
        for (first, step) in [
            (0.0, 1.0),
            (-2.5, 1.0),
            (-2.0, 1.0),
            (2.5, -1.0),
            (2.0, -1.0),
            (3.0, 0.0),
            (-3.0, 0.0),
            (-1.0, -1.0),
        ] {
            let even = Abscissa::Even { first, step, count: 7 };
            let (mut by_rule, mut by_value) = (Vec::new(), Vec::new());
            even.check(FilePlace::default(), &mut by_rule);
            Abscissa::Uneven(even.values()).check(FilePlace::default(), &mut by_value);
            assert_eq!(by_rule, by_value, "{first} {step}");
        }
    }
}
