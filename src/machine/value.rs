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
    /// x becomes x·p/(x + p): a spring p in series with a spring x.
    InSeries(usize),
    /// x + p.
    Added(usize),
}

impl Law {
    /// The parameter it depends on, by index.
    fn parameter(&self) -> usize {
        match *self {
            Law::Relative(index) | Law::AlongStroke(index, _) | Law::InSeries(index) | Law::Added(index) => index,
        }
    }

    fn parameter_mut(&mut self) -> &mut usize {
        match self {
            Law::Relative(index) | Law::AlongStroke(index, _) | Law::InSeries(index) | Law::Added(index) => index,
        }
    }

    /// What becomes of x, and the derivatives of that with x and with the parameter.
    fn apply(&self, x: f64, parameters: &[f64], operating: &Operating) -> (f64, f64, f64) {
        let p = parameters[self.parameter()];
        match *self {
            Law::Relative(_) => (x * (1.0 + p), 1.0 + p, x),
            Law::Added(_) => (x + p, 1.0, 1.0),
            Law::AlongStroke(_, stroke_m) => {
                let share = 2.0 * operating.nut_m.unwrap_or(0.5 * stroke_m) / stroke_m - 1.0;
                let factor = (p * share).exp();
                (x * factor, factor, x * factor * share)
            }
            Law::InSeries(_) => {
                let sum = x + p;
                (x * p / sum, (p / sum) * (p / sum), (x / sum) * (x / sum))
            }
        }
    }
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
        self.laws.iter().fold(self.base_at(parameters), |x, law| law.apply(x, parameters, operating).0)
    }

    fn base_at(&self, parameters: &[f64]) -> f64 {
        match self.base {
            Base::Number(number) => number,
            Base::Parameter(index) => parameters[index],
        }
    }

    /// Its exact derivatives with the parameters: `each(index, derivative)`, an index possibly more than once.
    pub fn gradient(&self, parameters: &[f64], operating: &Operating, mut each: impl FnMut(usize, f64)) {
        let mut x = self.base_at(parameters);
        // What later laws make of a change of x is the product of their derivatives with x.
        let onward = |from: usize, mut x: f64| {
            let mut product = 1.0;
            for law in &self.laws[from..] {
                let (next, with_x, _) = law.apply(x, parameters, operating);
                product *= with_x;
                x = next;
            }
            product
        };
        if let Base::Parameter(index) = self.base {
            each(index, onward(0, x));
        }
        for (at, law) in self.laws.iter().enumerate() {
            let (next, _, with_parameter) = law.apply(x, parameters, operating);
            x = next;
            each(law.parameter(), with_parameter * onward(at + 1, x));
        }
    }

    /// Gives the parameters new indices.
    pub(super) fn renumber(&mut self, moved: &[usize]) {
        if let Base::Parameter(index) = &mut self.base {
            *index = moved[*index];
        }
        for law in &mut self.laws {
            let index = law.parameter_mut();
            *index = moved[*index];
        }
    }

    /// The parameters it depends on, by index.
    pub fn depends_on(&self) -> impl Iterator<Item = usize> + '_ {
        let base = match self.base {
            Base::Number(_) => None,
            Base::Parameter(index) => Some(index),
        };
        base.into_iter().chain(self.laws.iter().map(Law::parameter))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_those_of_finite_differences() {
        let laws = vec![Law::Relative(1), Law::InSeries(2), Law::AlongStroke(3, 2.0), Law::Added(1)];
        let value = Value { base: Base::Parameter(0), laws };
        let (here, operating) = ([3.0, 0.2, 5.0, -0.4], Operating::at_nut(0.3));
        let mut exact = [0.0; 4];
        value.gradient(&here, &operating, |index, d| exact[index] += d);
        for index in 0..4 {
            let at = |by: f64| {
                let mut moved = here;
                moved[index] += by;
                value.at(&moved, &operating)
            };
            let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert!((exact[index] - slope).abs() < 1e-8, "{index}: {} against {slope}", exact[index]);
        }
    }

    #[test]
    fn limit_a_rigid_spring_in_series_changes_nothing() {
        let value = Value { base: Base::Number(3.0), laws: vec![Law::InSeries(0)] };
        assert!((value.at(&[1e15], &Operating::default()) - 3.0).abs() < 1e-12);
    }
}
