//! A number of the description: fixed, or a parameter, scaled by laws of the operating condition.

use super::Operating;

/// A number of a machine's description.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// Where its base comes from.
    pub base: Base,
    /// Factors that effects have put on it.
    pub laws: Vec<Law>,
}

/// The base of a [`Value`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// A fixed number.
    Number(f64),
    /// The parameter with this index.
    Parameter(usize),
}

/// One factor on a value; `usize` is the index of a parameter p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// 1 + p: a relative change.
    Relative(usize),
    /// exp(p·(2·s − 1)) with s = nut position / stroke: a steady change along the stroke.
    AlongStroke(usize, f64),
}

impl Value {
    /// A fixed number.
    pub fn number(number: f64) -> Self {
        Value { base: Base::Number(number), laws: Vec::new() }
    }

    /// The parameter with this index.
    pub fn parameter(index: usize) -> Self {
        Value { base: Base::Parameter(index), laws: Vec::new() }
    }

    /// Its number for the given parameters (each in its unit) and operating condition.
    pub fn at(&self, parameters: &[f64], operating: &Operating) -> f64 {
        let mut number = match self.base {
            Base::Number(number) => number,
            Base::Parameter(index) => parameters[index],
        };
        for law in &self.laws {
            number *= match *law {
                Law::Relative(index) => 1.0 + parameters[index],
                Law::AlongStroke(index, stroke_m) => {
                    let share = operating.nut_m.unwrap_or(0.5 * stroke_m) / stroke_m;
                    (parameters[index] * (2.0 * share - 1.0)).exp()
                }
            };
        }
        number
    }

    /// Gives the parameters new indices.
    pub(super) fn renumber(&mut self, moved: &[usize]) {
        if let Base::Parameter(index) = &mut self.base {
            *index = moved[*index];
        }
        for law in &mut self.laws {
            match law {
                Law::Relative(index) | Law::AlongStroke(index, _) => *index = moved[*index],
            }
        }
    }

    /// The parameters it depends on, by index.
    pub fn depends_on(&self) -> impl Iterator<Item = usize> + '_ {
        let base = match self.base {
            Base::Number(_) => None,
            Base::Parameter(index) => Some(index),
        };
        base.into_iter().chain(self.laws.iter().map(|law| match *law {
            Law::Relative(index) | Law::AlongStroke(index, _) => index,
        }))
    }
}
