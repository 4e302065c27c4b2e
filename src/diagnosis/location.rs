//! Location of a verdict: its interface, and the frequency band in which the chosen hypothesis changes the
//! model.
//!
//! The interface is that of an effect, of a parameter freed from its fixed value, or of a generic impedance
//! (a free stiffness, damping, mass or resonator at one interface).

use super::evidence::DomainObjective;
use super::fit::{Fitted, Fitter, coordinates_of};
use super::hypothesis::{Hypothesis, HypothesisKind};
use super::screening::Candidate;
use super::verdict::{Verdict, VerdictKind};
use identification::objective::ObjectiveError;
use machine::{Effect, Value};

/// Share of the squared change of the model that the reported band contains (1).
///
/// # Source  convention of this project: most of the change, without its wide tails, which would extend the
///   band to all lines.
const BAND_SHARE: f64 = 0.7;

/// Location to which a verdict refers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Location {
    /// Name of the point, joint or shaft; «drive» or «measurement» for an effect that changes none of these.
    /// `None` for verdicts without a discrepancy, and where neither the hypothesis nor a generic impedance
    /// has a location.
    pub interface: Option<String>,
    /// Shortest band (Hz) on a logarithmic axis that contains most of the change of the model. `None` for
    /// modes, and for verdicts without a hypothesis to compare.
    pub band_hz: Option<[f64; 2]>,
}

impl Location {
    /// Returns the location of the first named effect, of the freed parameter, or of the generic impedance
    /// that reduces χ² most.
    ///
    /// `generic_candidates` are fits of generic impedances in descending reduction of χ².
    ///
    /// # Errors  as [`Fitter::objective`].
    pub(super) fn of(
        verdict: &Verdict,
        fitter: &Fitter<'_>,
        nominal: (&Hypothesis, &Fitted),
        chosen: (&Hypothesis, &Fitted),
        (effects, generic_candidates): (&[Effect], &[Candidate]),
    ) -> Result<Self, ObjectiveError> {
        let generic = generic_candidates.first().and_then(|c| c.fitted.as_ref());
        let generic_location = || match generic.map(|(hypothesis, _)| &hypothesis.kind) {
            Some(HypothesisKind::Interface { interface, .. }) => Some(interface.clone()),
            _ => None,
        };
        let (interface, compared_fit) = match verdict.kind {
            VerdictKind::None | VerdictKind::Insufficient => return Ok(Location::default()),
            VerdictKind::Measurement => {
                return Ok(Location { interface: Some("measurement".into()), band_hz: None });
            }
            VerdictKind::Unknown => {
                (generic_location(), generic.map(|(hypothesis, fitted)| (hypothesis, fitted)))
            }
            VerdictKind::WrongParameter => (interface_of_freed_parameter(chosen.0), Some(chosen)),
            VerdictKind::Effect | VerdictKind::Ambiguous => {
                let effect = verdict
                    .first_effect()
                    .and_then(|id| Effect::contained_variant(effects, id, &chosen.0.machine));
                (effect.and_then(|e| interface_of_effect(e, chosen.0, chosen.1)), Some(chosen))
            }
        };
        let band_hz = compared_fit.map(|other| band_of_change(fitter, nominal, other)).transpose()?.flatten();
        Ok(Location { interface: interface.or_else(generic_location), band_hz })
    }
}

/// Returns the interface of an effect. Of several interfaces it is the one whose parameter moved farthest
/// from its start value.
fn interface_of_effect(effect: &Effect, hypothesis: &Hypothesis, fitted: &Fitted) -> Option<String> {
    let parameters = &hypothesis.machine.parameters;
    let moved = |id: &str| {
        let index = parameters.iter().position(|p| p.id == id)?;
        Some((fitted.units[index] - parameters[index].to_unit(parameters[index].start)).abs())
    };
    let mut interfaces = effect
        .places()
        .into_iter()
        .map(|(name, parameter)| (parameter.as_deref().and_then(moved).unwrap_or(0.0), name));
    let first = interfaces.next()?;
    Some(interfaces.fold(first, |best, other| if other.0 > best.0 { other } else { best }).1)
}

/// Returns all places of the effects and freed parameters of a hypothesis.
pub(super) fn places_of(hypothesis: &Hypothesis, effects: &[Effect]) -> Vec<String> {
    if hypothesis.kind == HypothesisKind::Release {
        return interface_of_freed_parameter(hypothesis).into_iter().collect();
    }
    let of = |id: &String| Effect::contained_variant(effects, id, &hypothesis.machine);
    let mut places: Vec<String> = Vec::new();
    for (place, _) in hypothesis.effects.as_slice().iter().filter_map(of).flat_map(Effect::places) {
        if !places.contains(&place) {
            places.push(place);
        }
    }
    places
}

/// Returns the joint, point or shaft to which a freed parameter belongs.
fn interface_of_freed_parameter(hypothesis: &Hypothesis) -> Option<String> {
    let parameter = *hypothesis.added.first()?;
    let machine = &hypothesis.machine;
    let depends = |value: &Value| value.depends_on().any(|p| p == parameter);
    let joint = machine
        .joints
        .iter()
        .find(|j| depends(&j.stiffness) || depends(&j.damping) || depends(&j.loss_factor))
        .map(|j| &j.name);
    let point = || machine.points.iter().find(|p| depends(&p.inertia)).map(|p| &p.name);
    let shaft = || {
        machine
            .shafts
            .iter()
            .find(|s| depends(&s.diameter) || depends(&s.length) || depends(&s.youngs_modulus))
            .map(|s| &s.name)
    };
    joint.or_else(point).or_else(shaft).cloned()
}

/// Returns the shortest band that contains [`BAND_SHARE`] of the squared change from the nominal fit to
/// another. Lines are weighted by their standard deviations.
fn band_of_change(
    fitter: &Fitter<'_>,
    nominal: (&Hypothesis, &Fitted),
    other: (&Hypothesis, &Fitted),
) -> Result<Option<[f64; 2]>, ObjectiveError> {
    let [nominal_objective, other_objective] = [fitter.objective(nominal.0)?, fitter.objective(other.0)?];
    let change = other_objective.residuals(&coordinates_of(&other_objective, other.1))
        - nominal_objective.residuals(&coordinates_of(&nominal_objective, nominal.1));
    let DomainObjective::Frf(objective) = nominal_objective else { return Ok(None) };
    let lines_hz = objective.records().iter().flat_map(|record| record.frequencies_hz());
    // The residuals of real and imaginary part alternate.
    let squares = change.as_slice().chunks(2).map(|parts| parts.iter().map(|x| x * x).sum::<f64>());
    let mut lines: Vec<(f64, f64)> = lines_hz.zip(squares).collect();
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(shortest_band(&lines, BAND_SHARE))
}

/// Returns the shortest band (Hz) on a logarithmic frequency axis that contains a share of the amounts.
/// `lines` are pairs of frequency and amount in ascending frequency.
fn shortest_band(lines: &[(f64, f64)], share: f64) -> Option<[f64; 2]> {
    let target = share * lines.iter().map(|l| l.1).sum::<f64>();
    if !(target > 0.0 && target.is_finite()) {
        return None;
    }
    let (mut first, mut enclosed) = (0, 0.0);
    let mut best: Option<[f64; 2]> = None;
    for (to_hz, amount) in lines {
        enclosed += amount;
        while enclosed - lines[first].1 >= target {
            enclosed -= lines[first].1;
            first += 1;
        }
        let from_hz = lines[first].0;
        if enclosed >= target && best.is_none_or(|[from, to]| to_hz / from_hz < to / from) {
            best = Some([from_hz, *to_hz]);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shortest_band_holds_its_share_on_a_logarithmic_axis() {
        let lines: Vec<(f64, f64)> =
            (1..=100).map(|f| (f64::from(f), if (40..50).contains(&f) { 9.0 } else { 0.1 })).collect();
        assert_eq!(shortest_band(&lines, 0.7), Some([42.0, 49.0]));
        // The same amounts at 2 to 4 and at 60 to 62 Hz: the upper band is shorter on a logarithmic axis.
        let twice = |f: i32| if (2..=4).contains(&f) || (60..=62).contains(&f) { 1.0 } else { 0.0 };
        let lines: Vec<(f64, f64)> = (1..=100).map(|f| (f64::from(f), twice(f))).collect();
        assert_eq!(shortest_band(&lines, 0.5), Some([60.0, 62.0]));
        assert_eq!(shortest_band(&[(1.0, 0.0)], 0.7), None);
    }
}
