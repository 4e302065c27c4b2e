//! Tolerances held at estimated values.

use std::collections::BTreeMap;

use super::super::error::fault;
use super::guide::OF_GUIDE;
use crate::{Machine, MachineError, Parameter, Prior, Tolerance};

/// Rounding of a written value at an end of its range, relative to the range (1).
const ROUNDING: f64 = 1e-9;

/// Estimate of a tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Value, in the unit of the tolerance.
    pub value: f64,
    /// Standard deviation in that unit, of the logarithm for a log-normal prior; 0 for an exact number,
    /// `None` where only that of the description is known.
    pub sd: Option<f64>,
}

impl Estimate {
    /// Returns a tolerance with this estimate as its prior; one that is exact has none.
    fn of(self, tolerance: &Parameter) -> Result<Parameter, MachineError> {
        let Parameter { lower, upper, prior, .. } = tolerance;
        let part = || format!("fitted.tolerances.{}", tolerance.name());
        let slack = ROUNDING * (upper - lower);
        if !(lower - slack..=upper + slack).contains(&self.value) {
            let unit = if tolerance.unit == "1" { String::new() } else { format!(" {}", tolerance.unit) };
            let range = format!("write a value from {lower} to {upper}{unit}");
            return Err(fault(part(), format!("is {}; {range}", self.value)));
        }
        // A standard deviation of the logarithm is compared with the range of the logarithm.
        let limit = match prior {
            Some(Prior::LogNormal(_)) if *lower > 0.0 => (upper / lower).ln(),
            Some(Prior::LogNormal(_)) => f64::INFINITY,
            _ => upper - lower,
        };
        let prior = match (self.sd, prior) {
            (None, prior) => *prior,
            (Some(0.0), _) => None,
            (Some(sd), _) if !(sd > 0.0 && sd <= limit) => {
                return Err(fault(
                    part(),
                    format!("has the sd {sd}; write a standard deviation from 0 to {limit}"),
                ));
            }
            (Some(sd), Some(Prior::LogNormal(_))) => Some(Prior::LogNormal(sd)),
            (Some(sd), _) => Some(Prior::Normal(sd)),
        };
        Ok(Parameter { start: self.value.clamp(*lower, *upper), prior, ..tolerance.clone() })
    }
}

impl Machine {
    /// Returns the machine with its tolerances held at estimates: numbers of the description from then on.
    /// [`Machine::with_tolerances`] makes them parameters again, with the estimates as priors. Tolerances
    /// without an estimate stay as described. The second list has the names to which no tolerance belongs.
    ///
    /// `nuts_m` (m) are the nut positions of the set from which the values were estimated: the lengths of
    /// journals and nuts depend on them.
    ///
    /// # Errors  as [`Machine::with_tolerances`]; an estimate is outside the range of its tolerance.
    pub fn with_tolerances_held(
        &self,
        nuts_m: &[f64],
        estimates: &BTreeMap<String, Estimate>,
    ) -> Result<(Machine, Vec<String>), MachineError> {
        let mut machine = self.with_tolerances(nuts_m)?;
        let first = machine.parameters.iter().position(Parameter::is_tolerance);
        let first = first.unwrap_or(machine.parameters.len());
        let tolerances = &machine.parameters[first..];
        let is_unknown = |name: &&String| tolerances.iter().all(|p| p.name() != *name);
        let unknown = estimates.keys().filter(is_unknown).cloned().collect();
        let estimate = |p: &Parameter| estimates.get(p.name()).map_or(Ok(p.clone()), |e| e.of(p));
        let held: Vec<Parameter> = tolerances.iter().map(estimate).collect::<Result<_, _>>()?;
        let before = machine.held.len();
        let number = |index: usize| index.checked_sub(first).map(|at| (held[at].start, before + at));
        machine.change_numbers(&mut |_, _, value| value.hold(&number));
        machine.held.extend(held);
        machine.drop_unused_parameters();
        machine.tolerance = Tolerance::NONE;
        Ok((machine, unknown))
    }

    /// Returns the machine with the tolerances that are held as parameters, each with its prior, after all
    /// others.
    pub(super) fn with_held_released(&self) -> Machine {
        let mut machine = self.clone();
        machine.held.iter_mut().for_each(|p| p.prior = None);
        let mut parameters = std::mem::take(&mut machine.parameters);
        let mut released = vec![None; self.held.len()];
        machine.change_numbers(&mut |_, _, value| {
            value.release(&mut |tolerance| {
                self.held[tolerance].prior?;
                if released[tolerance].is_none() {
                    released[tolerance] = Some(parameters.len());
                    parameters.push(self.held[tolerance].clone());
                }
                released[tolerance]
            })
        });
        Machine { parameters, ..machine }
    }

    /// Returns the machine without a tolerance of the damping of its guide, as a diagnosis takes it: there
    /// the effect «guide-viscous» competes with others.
    #[must_use]
    pub fn without_guide_tolerance(&self) -> Machine {
        let mut machine = self.clone();
        machine.tolerance.guide_damping = 0.0;
        let of_guide = machine.held.iter_mut().filter(|p| p.name().starts_with(OF_GUIDE));
        of_guide.for_each(|p| p.prior = None);
        machine
    }
}
