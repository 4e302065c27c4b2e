//! Location of a verdict: the interface of an effect, of a released parameter or of a generic impedance, and the band in which it changes the model.

use super::evidence::DomainObjective;
use super::fit::{Fitted, Fitter, coordinates_of};
use super::hypothesis::{Hypothesis, HypothesisKind};
use super::screening::Candidate;
use super::verdict::{Verdict, VerdictKind};
use identification::objective::ObjectiveError;
use machine::{Effect, Value};

/// Share of the squared change of the model that the reported band contains.
const SHARE: f64 = 0.7;

/// Location to which a verdict refers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Location {
    /// Point, joint or shaft; «drive» or «measurement» for an effect of neither. `None` for verdicts without a discrepancy.
    pub interface: Option<String>,
    /// The shortest band, on a logarithmic axis, with most of the change of the model; `None` for modes.
    pub band_hz: Option<[f64; 2]>,
}

impl Location {
    /// Returns the location of the first named effect, of the released parameter, or of the generic impedance that reduces χ² most.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub(super) fn of(
        verdict: &Verdict,
        fitter: &Fitter<'_>,
        nominal: (&Hypothesis, &Fitted),
        chosen: (&Hypothesis, &Fitted),
        (effects, located): (&[Effect], &[Candidate]),
    ) -> Result<Self, ObjectiveError> {
        let generic = located.first().and_then(|c| c.fitted.as_ref());
        let generic_location = || match generic.map(|(hypothesis, _)| &hypothesis.kind) {
            Some(HypothesisKind::Interface { interface, .. }) => Some(interface.clone()),
            _ => None,
        };
        let (interface, of) = match verdict.kind {
            VerdictKind::None | VerdictKind::Insufficient => return Ok(Location::default()),
            VerdictKind::Measurement => return Ok(Location { interface: Some("measurement".into()), band_hz: None }),
            VerdictKind::Unknown => (generic_location(), generic.map(|(hypothesis, fitted)| (hypothesis, fitted))),
            VerdictKind::WrongParameter => (released_at(chosen.0), Some(chosen)),
            VerdictKind::Effect | VerdictKind::Ambiguous => {
                let effect = verdict.first_effect().and_then(|id| Effect::contained_variant(effects, id, &chosen.0.machine));
                (effect.and_then(|e| effect_at(e, chosen.0, chosen.1)), Some(chosen))
            }
        };
        let band_hz = of.map(|other| band_of_change(fitter, nominal, other)).transpose()?.flatten();
        Ok(Location { interface: interface.or_else(generic_location), band_hz })
    }
}

/// Returns the location of an effect: of several, the one whose parameter moved farthest from its start.
fn effect_at(effect: &Effect, hypothesis: &Hypothesis, fitted: &Fitted) -> Option<String> {
    let parameters = &hypothesis.machine.parameters;
    let moved = |id: &str| {
        let at = parameters.iter().position(|p| p.id == id)?;
        Some((fitted.units[at] - parameters[at].to_unit(parameters[at].start)).abs())
    };
    let mut places = effect.places().into_iter().map(|(place, by)| (by.as_deref().and_then(moved).unwrap_or(0.0), place));
    let first = places.next()?;
    Some(places.fold(first, |best, other| if other.0 > best.0 { other } else { best }).1)
}

/// Returns the joint, point or shaft that a released parameter belongs to.
fn released_at(hypothesis: &Hypothesis) -> Option<String> {
    let parameter = *hypothesis.added.first()?;
    let machine = &hypothesis.machine;
    let on = |value: &Value| value.depends_on().any(|p| p == parameter);
    let joint = machine.joints.iter().find(|j| on(&j.stiffness) || on(&j.damping) || on(&j.loss_factor)).map(|j| &j.name);
    let point = || machine.points.iter().find(|p| on(&p.inertia)).map(|p| &p.name);
    let shaft = || machine.shafts.iter().find(|s| on(&s.diameter) || on(&s.length) || on(&s.youngs_modulus)).map(|s| &s.name);
    joint.or_else(point).or_else(shaft).cloned()
}

/// Returns the shortest band with most of the change from the nominal to another fit. Changes of lines are weighted by their standard deviations.
fn band_of_change(
    fitter: &Fitter<'_>,
    nominal: (&Hypothesis, &Fitted),
    other: (&Hypothesis, &Fitted),
) -> Result<Option<[f64; 2]>, ObjectiveError> {
    let [here, there] = [fitter.objective(nominal.0)?, fitter.objective(other.0)?];
    let change = there.residuals(&coordinates_of(&there, other.1)) - here.residuals(&coordinates_of(&here, nominal.1));
    let DomainObjective::Frf(objective) = here else { return Ok(None) };
    let lines_hz = objective.records().iter().flat_map(|record| record.frequencies_hz());
    // Real and imaginary part alternate.
    let squares = change.as_slice().chunks(2).map(|parts| parts.iter().map(|x| x * x).sum::<f64>());
    let mut lines: Vec<(f64, f64)> = lines_hz.zip(squares).collect();
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(shortest_band(&lines, SHARE))
}

/// Returns the shortest band on a logarithmic frequency axis that contains a share of the amounts at lines in rising order.
fn shortest_band(lines: &[(f64, f64)], share: f64) -> Option<[f64; 2]> {
    let wanted = share * lines.iter().map(|l| l.1).sum::<f64>();
    if !(wanted > 0.0 && wanted.is_finite()) {
        return None;
    }
    let (mut first, mut inside) = (0, 0.0);
    let mut best: Option<[f64; 2]> = None;
    for (to_hz, amount) in lines {
        inside += amount;
        while inside - lines[first].1 >= wanted {
            inside -= lines[first].1;
            first += 1;
        }
        let from_hz = lines[first].0;
        if inside >= wanted && best.is_none_or(|[from, to]| to_hz / from_hz < to / from) {
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
        let lines: Vec<(f64, f64)> = (1..=100).map(|f| (f64::from(f), if (40..50).contains(&f) { 9.0 } else { 0.1 })).collect();
        assert_eq!(shortest_band(&lines, 0.7), Some([42.0, 49.0]));
        // The same amounts at 2 to 4 and at 60 to 62 Hz: the upper band is shorter on a logarithmic axis.
        let twice = |f: i32| if (2..=4).contains(&f) || (60..=62).contains(&f) { 1.0 } else { 0.0 };
        let lines: Vec<(f64, f64)> = (1..=100).map(|f| (f64::from(f), twice(f))).collect();
        assert_eq!(shortest_band(&lines, 0.5), Some([60.0, 62.0]));
        assert_eq!(shortest_band(&[(1.0, 0.0)], 0.7), None);
    }
}
