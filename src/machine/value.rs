//! A number of the description: fixed or a parameter, changed by modifiers that may depend on the operating
//! condition.

use std::sync::Arc;

use super::{LoadedPair, Operating, OperatingVariable, Segment};

/// A number of a machine's description.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// Source of its base value.
    pub base: Base,
    /// Modifiers added by effects, applied in order.
    pub modifiers: Vec<Modifier>,
}

/// The base of a [`Value`].
#[derive(Debug, Clone, PartialEq)]
pub enum Base {
    /// A fixed number.
    Number(f64),
    /// A tolerance held at a number, and its index in [`Machine::held`](super::Machine::held).
    Held(f64, usize),
    /// The parameter with this index.
    Parameter(usize),
    /// The stiffness of a loaded contact.
    Contact(Arc<LoadedPair>),
    /// The stiffness of a screw segment.
    Segment(Arc<Segment>),
    /// The stated nut position (m).
    NutPosition,
    /// Springs in series, each with a name: 1/x = Σ 1/xᵢ.
    Series(Arc<Vec<(String, Value)>>),
}

/// A modifier of a value; `usize` is the index of a parameter p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Modifier {
    /// Multiplies by 1 + p.
    Relative(usize),
    /// Multiplies by p.
    Times(usize),
    /// Multiplies by exp(p·(2·s − 1)) with s = nut position / stroke: a monotonic change along the stroke.
    AlongStroke(usize, f64),
    /// Multiplies by exp(p·(1 − (2·s − 1)²)): a maximum or minimum at mid-stroke, for example from wear.
    MidStroke(usize, f64),
    /// Multiplies by exp(p·x), x the size of an operating variable; for the force level p is its exponent.
    With(usize, OperatingVariable),
    /// Puts a spring p in series: x becomes x·p/(x + p).
    InSeries(usize),
    /// Adds p.
    Added(usize),
    /// Subtracts p, but keeps at least a hundredth of x.
    Less(usize),
    /// Adds a number.
    Shifted(f64),
    /// [`Modifier::Relative`] with a tolerance held at a number, and its index in
    /// [`Machine::held`](super::Machine::held).
    HeldRelative(f64, usize),
    /// [`Modifier::Added`] likewise.
    HeldAdded(f64, usize),
}

impl Modifier {
    /// Returns the index of the parameter on which it depends; `None` for one that changes x by a number.
    fn parameter(&self) -> Option<usize> {
        self.clone().parameter_mut().copied()
    }

    fn parameter_mut(&mut self) -> Option<&mut usize> {
        match self {
            Modifier::Relative(index)
            | Modifier::Times(index)
            | Modifier::AlongStroke(index, _)
            | Modifier::MidStroke(index, _)
            | Modifier::With(index, _)
            | Modifier::InSeries(index)
            | Modifier::Less(index)
            | Modifier::Added(index) => Some(index),
            Modifier::Shifted(_) | Modifier::HeldRelative(..) | Modifier::HeldAdded(..) => None,
        }
    }

    /// Returns the modifier with its parameter held at a number. `None` for one that tolerances do not use.
    fn held_at(self, (p, tolerance): (f64, usize)) -> Option<Modifier> {
        match self {
            Modifier::Relative(_) => Some(Modifier::HeldRelative(p, tolerance)),
            Modifier::Added(_) => Some(Modifier::HeldAdded(p, tolerance)),
            _ => None,
        }
    }

    /// Returns the modified x and its derivatives with respect to x and to the parameter.
    fn apply(&self, x: f64, parameters: &[f64], operating: &Operating) -> (f64, f64, f64) {
        let p = self.parameter().map_or(0.0, |index| parameters[index]);
        match *self {
            Modifier::HeldRelative(by, _) => (x * (1.0 + by), 1.0 + by, 0.0),
            Modifier::Shifted(by) | Modifier::HeldAdded(by, _) => (x + by, 1.0, 0.0),
            Modifier::Relative(_) => (x * (1.0 + p), 1.0 + p, x),
            Modifier::Added(_) => (x + p, 1.0, 1.0),
            Modifier::Less(_) if p < 0.99 * x => (x - p, 1.0, -1.0),
            Modifier::Less(_) => (0.01 * x, 0.01, 0.0),
            Modifier::Times(_) => (x * p, p, x),
            Modifier::AlongStroke(_, stroke_m) | Modifier::MidStroke(_, stroke_m) => {
                let along = 2.0 * operating.nut_m.unwrap_or(0.5 * stroke_m) / stroke_m - 1.0;
                let shape = if matches!(self, Modifier::MidStroke(..)) { 1.0 - along * along } else { along };
                let factor = (p * shape).exp();
                (x * factor, factor, x * factor * shape)
            }
            Modifier::With(_, variable) => {
                let size = variable.size(operating);
                let factor = (p * size).exp();
                (x * factor, factor, x * factor * size)
            }
            Modifier::InSeries(_) => {
                let sum = x + p;
                (x * p / sum, (p / sum) * (p / sum), (x / sum) * (x / sum))
            }
        }
    }
}

impl Default for Value {
    fn default() -> Self {
        Value::number(0.0)
    }
}

impl Value {
    /// Creates a fixed number.
    pub fn number(number: f64) -> Self {
        Value { base: Base::Number(number), modifiers: Vec::new() }
    }

    /// Creates a reference to the parameter with this index.
    pub fn parameter(index: usize) -> Self {
        Value { base: Base::Parameter(index), modifiers: Vec::new() }
    }

    /// Creates the stated nut position (m).
    pub fn nut_position() -> Self {
        Value { base: Base::NutPosition, modifiers: Vec::new() }
    }

    /// Computes the number for the given parameters (each in its unit) and operating condition.
    #[inline]
    pub fn at(&self, parameters: &[f64], operating: &Operating) -> f64 {
        self.modifiers.iter().fold(self.base_at(parameters, operating), |x, modifier| {
            modifier.apply(x, parameters, operating).0
        })
    }

    /// Returns the described number before any modifier; `None` where it depends on parameters.
    pub fn described(&self) -> Option<f64> {
        if let Base::Number(number) | Base::Held(number, _) = self.base { Some(number) } else { None }
    }

    /// Whether a modifier subtracts more than there is.
    pub fn is_over_subtracted(&self, parameters: &[f64], operating: &Operating) -> bool {
        let mut x = self.base_at(parameters, operating);
        self.modifiers.iter().any(|modifier| {
            let (next, _, with_parameter) = modifier.apply(x, parameters, operating);
            x = next;
            matches!(modifier, Modifier::Less(_)) && with_parameter == 0.0
        })
    }

    fn base_at(&self, parameters: &[f64], operating: &Operating) -> f64 {
        match &self.base {
            Base::Number(number) | Base::Held(number, _) => *number,
            Base::Parameter(index) => parameters[*index],
            Base::Contact(pair) => pair.stiffness(operating),
            Base::Segment(segment) => segment.stiffness_n_per_m(operating),
            Base::NutPosition => operating.nut_m.unwrap_or(f64::NAN),
            Base::Series(springs) => {
                1.0 / springs.iter().map(|(_, spring)| 1.0 / spring.at(parameters, operating)).sum::<f64>()
            }
        }
    }

    /// Returns the springs of a series, each with its share of the compliance; empty for any other value.
    pub fn compliance_shares(&self, parameters: &[f64], operating: &Operating) -> Vec<(String, f64)> {
        let Base::Series(springs) = &self.base else { return Vec::new() };
        let whole = self.base_at(parameters, operating);
        springs
            .iter()
            .map(|(name, spring)| (name.clone(), whole / spring.at(parameters, operating)))
            .collect()
    }

    /// Computes the exact derivatives with respect to the parameters: `each(index, derivative)`, possibly
    /// several times per index.
    pub fn gradient(&self, parameters: &[f64], operating: &Operating, mut each: impl FnMut(usize, f64)) {
        self.each_gradient(parameters, operating, &mut each);
    }

    fn each_gradient(&self, parameters: &[f64], operating: &Operating, each: &mut dyn FnMut(usize, f64)) {
        let mut x = self.base_at(parameters, operating);
        // Later modifiers multiply a change of x by the product of their derivatives with respect to x.
        let onward = |from: usize, mut x: f64| {
            let mut product = 1.0;
            for modifier in &self.modifiers[from..] {
                let (next, with_x, _) = modifier.apply(x, parameters, operating);
                product *= with_x;
                x = next;
            }
            product
        };
        match &self.base {
            Base::Number(_) | Base::Held(..) | Base::Contact(_) | Base::Segment(_) | Base::NutPosition => {}
            Base::Parameter(index) => each(*index, onward(0, x)),
            Base::Series(springs) => {
                let after = onward(0, x);
                for (_, spring) in springs.iter() {
                    let share = x / spring.at(parameters, operating);
                    spring.each_gradient(parameters, operating, &mut |index, d| {
                        each(index, after * share * share * d)
                    });
                }
            }
        }
        for (at, modifier) in self.modifiers.iter().enumerate() {
            let (next, _, with_parameter) = modifier.apply(x, parameters, operating);
            x = next;
            if let Some(index) = modifier.parameter() {
                each(index, with_parameter * onward(at + 1, x));
            }
        }
    }

    /// Maps the parameters to new indices.
    pub(super) fn renumber(&mut self, moved: &[usize]) {
        match &mut self.base {
            Base::Number(_) | Base::Held(..) | Base::Contact(_) | Base::Segment(_) | Base::NutPosition => {}
            Base::Parameter(index) => *index = moved[*index],
            Base::Series(springs) => {
                Arc::make_mut(springs).iter_mut().for_each(|(_, spring)| spring.renumber(moved))
            }
        }
        for index in self.modifiers.iter_mut().filter_map(Modifier::parameter_mut) {
            *index = moved[*index];
        }
    }

    /// Replaces tolerances by numbers: `held` returns the number of each parameter that is held, and its index
    /// in [`Machine::held`](super::Machine::held).
    pub(super) fn hold(&mut self, held: &dyn Fn(usize) -> Option<(f64, usize)>) {
        match &mut self.base {
            Base::Number(_) | Base::Held(..) | Base::Contact(_) | Base::Segment(_) | Base::NutPosition => {}
            Base::Parameter(index) => {
                if let Some((number, tolerance)) = held(*index) {
                    self.base = Base::Held(number, tolerance);
                }
            }
            Base::Series(springs) => {
                Arc::make_mut(springs).iter_mut().for_each(|(_, spring)| spring.hold(held))
            }
        }
        for modifier in &mut self.modifiers {
            if let Some(number) = modifier.parameter().and_then(held).and_then(|p| modifier.held_at(p)) {
                *modifier = number;
            }
        }
    }

    /// Makes held tolerances parameters again: `released` returns the index of the parameter of each; `None`
    /// for one that stays a number.
    pub(super) fn release(&mut self, released: &mut dyn FnMut(usize) -> Option<usize>) {
        match &mut self.base {
            Base::Held(_, tolerance) => {
                if let Some(index) = released(*tolerance) {
                    self.base = Base::Parameter(index);
                }
            }
            Base::Series(springs) => {
                Arc::make_mut(springs).iter_mut().for_each(|(_, spring)| spring.release(released))
            }
            _ => {}
        }
        for modifier in &mut self.modifiers {
            let open = match *modifier {
                Modifier::HeldRelative(_, tolerance) => released(tolerance).map(Modifier::Relative),
                Modifier::HeldAdded(_, tolerance) => released(tolerance).map(Modifier::Added),
                _ => None,
            };
            *modifier = open.unwrap_or(*modifier);
        }
    }

    /// Returns the indices of the parameters on which it depends.
    pub fn depends_on(&self) -> Box<dyn Iterator<Item = usize> + '_> {
        let base: Box<dyn Iterator<Item = usize> + '_> = match &self.base {
            Base::Number(_) | Base::Held(..) | Base::Contact(_) | Base::Segment(_) | Base::NutPosition => {
                Box::new(std::iter::empty())
            }
            Base::Parameter(index) => Box::new(std::iter::once(*index)),
            Base::Series(springs) => Box::new(springs.iter().flat_map(|(_, spring)| spring.depends_on())),
        };
        Box::new(base.chain(self.modifiers.iter().filter_map(Modifier::parameter)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_match_finite_differences() {
        let laws = vec![
            Modifier::Relative(1),
            Modifier::InSeries(2),
            Modifier::AlongStroke(3, 2.0),
            Modifier::MidStroke(3, 2.0),
            Modifier::Times(4),
            Modifier::Added(1),
        ];
        let single = Value { base: Base::Parameter(0), modifiers: laws };
        let other = Value { base: Base::Number(4.0), modifiers: vec![Modifier::Times(1)] };
        let series =
            vec![("a".to_string(), single.clone()), ("b".into(), other), ("c".into(), Value::parameter(0))];
        let series = Value { base: Base::Series(Arc::new(series)), modifiers: vec![Modifier::Relative(2)] };
        let (here, operating) = ([3.0, 0.2, 5.0, -0.4, 1.7], Operating::at_nut(0.3));
        for value in [single, series] {
            let mut exact = [0.0; 5];
            value.gradient(&here, &operating, |index, d| exact[index] += d);
            for index in 0..5 {
                let at = |by: f64| {
                    let mut moved = here;
                    moved[index] += by;
                    value.at(&moved, &operating)
                };
                let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((exact[index] - slope).abs() < 1e-8, "{index}: {} against {slope}", exact[index]);
            }
        }
    }

    #[test]
    fn limit_compliance_shares_of_a_series_sum_to_one() {
        let springs = vec![("a".to_string(), Value::number(3.0)), ("b".into(), Value::number(6.0))];
        let value = Value { base: Base::Series(Arc::new(springs)), modifiers: Vec::new() };
        assert!((value.at(&[], &Operating::default()) - 2.0).abs() < 1e-15);
        let shares = value.compliance_shares(&[], &Operating::default());
        assert!((shares[0].1 - 2.0 / 3.0).abs() < 1e-15 && (shares[1].1 - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn limit_a_rigid_spring_in_series_changes_nothing() {
        let value = Value { base: Base::Number(3.0), modifiers: vec![Modifier::InSeries(0)] };
        assert!((value.at(&[1e15], &Operating::default()) - 3.0).abs() < 1e-12);
    }
}
