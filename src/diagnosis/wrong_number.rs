//! Candidates beside the effects of the library: numbers that a description may state wrongly.
//!
//! They are numbers beyond their tolerance which no effect of the library changes, such as the inertia of a
//! rotor, and joints that the data drive to an end of their range: a bearing that is missing or free ends at
//! the lower one.

use std::collections::BTreeMap;

use super::fit::{Fitted, values_of};
use super::hypothesis::Hypothesis;
use machine::{
    Base, Data, Effect, FitRule, Joint, Machine, Mechanism, Parameter, Patch, Rescale, Role, Scale, Target,
    TargetKind, Value,
};

/// Range of the relative change of a number: from a tenth of it to five times, as a rotor with its brake or without.
/// It decides nothing but where a search looks.
const CHANGE: (f64, f64) = (-0.9, 4.0);
/// Ranges of a stiffness below and beyond its own, as a share of the end (1): at the far ends the joint is
/// absent, or rigid, and no estimate lies there. They decide nothing but where a search looks.
const BELOW: f64 = 1e-5;
const BEYOND: f64 = 1e3;
/// Begins the id of the parameter that stands for one of the machine, which keeps both distinct.
const MARK: char = '~';

/// Returns the candidates of a nominal machine and its fit: an id is the name of the number, or the id of the
/// stiffness.
pub(super) fn wrong_numbers(nominal: &Hypothesis, base: &Fitted, effects: &[Effect]) -> Vec<Effect> {
    let machine = &nominal.machine;
    let values = values_of(nominal, base);
    let joints = ends(machine, &base.units).into_iter().map(|at| {
        let Parameter { lower, upper, .. } = machine.parameters[at];
        joint_beyond(machine, at, values[at] < 0.5 * (lower + upper))
    });
    stated_numbers(machine, effects).chain(joints).collect()
}

/// Returns the candidates that a diagnosis of a machine may name beside the effects of the library, for the
/// positions of its nut (m) and the values of its chosen model.
pub fn named_numbers(
    machine: &Machine,
    nuts_m: &[f64],
    effects: &[Effect],
    chosen: &BTreeMap<String, f64>,
) -> Vec<Effect> {
    let with_tolerances = machine.with_tolerances(nuts_m).ok();
    let numbers = with_tolerances.iter().flat_map(|machine| stated_numbers(machine, effects));
    let joints = chosen.iter().filter_map(|(id, value)| {
        let at = machine.parameter(id.strip_prefix(MARK)?)?;
        Some(joint_beyond(machine, at, *value <= machine.parameters[at].lower))
    });
    numbers.chain(joints).collect()
}

/// Returns the numbers that have a tolerance and that no effect of the library changes.
fn stated_numbers<'m>(machine: &'m Machine, effects: &'m [Effect]) -> impl Iterator<Item = Effect> + 'm {
    let is_known = |target: &Target| {
        let changes = |effect: &&Effect| effect.patch.rescales.iter().any(|(other, ..)| other == target);
        let applies =
            |effect: &&Effect| effect.patch.points.is_empty() && machine.missing_part(effect).is_none();
        effects.iter().filter(applies).any(|effect| changes(&effect))
    };
    let is_relative = |p: &Parameter| p.is_tolerance() && p.mechanism == Mechanism::Ratio && p.start == 0.0;
    let tolerances = machine.parameters.iter().enumerate().filter(move |(_, p)| is_relative(p));
    tolerances.filter_map(move |(at, parameter)| {
        let target = target_of(machine, at).filter(|target| !is_known(target))?;
        let name = parameter.name();
        let change = Parameter {
            id: format!("{}_change", name.replace([' ', '\''], "_")),
            lower: CHANGE.0,
            upper: CHANGE.1,
            ..added(Mechanism::Ratio, "1", Scale::Linear)
        };
        let description = format!("the {name} differs from the stated one");
        let patch = Patch {
            rescales: vec![(target, Rescale::Relative, change.id.clone())],
            parameters: vec![change],
            ..Patch::default()
        };
        Some(candidate(name, description, patch))
    })
}

/// Returns the candidate that moves the joints of a stiffness beyond an end of its range.
fn joint_beyond(machine: &Machine, at: usize, is_low: bool) -> Effect {
    let Parameter { id, lower, upper, unit, mechanism, .. } = &machine.parameters[at];
    let (start, range, text) = match is_low {
        true => (*lower, (BELOW * lower, *lower), "below its range: is that joint missing, or free?"),
        false => (*upper, (*upper, BEYOND * upper), "beyond its range: is that joint rigid?"),
    };
    let (lower, upper) = range;
    let own = added(*mechanism, unit, Scale::Logarithmic);
    let stiffness = Parameter { id: format!("{MARK}{id}"), start, lower, upper, ..own };
    let of_joint = machine.joints.iter().filter(|joint| joint.stiffness.base == Base::Parameter(at));
    let mut names: Vec<&str> = of_joint.map(|joint| joint.name.as_str()).collect();
    names.dedup();
    let rescale = |name: &str| (TargetKind::JointStiffness.of(name), Rescale::Replace, stiffness.id.clone());
    let rescales = names.into_iter().map(rescale).collect();
    let patch = Patch { rescales, parameters: vec![stiffness], ..Patch::default() };
    candidate(id, format!("{id} lies {text}"), patch)
}

/// Returns the stiffnesses, by index, of joints that a fit leaves at an end of their range.
pub(super) fn ends(machine: &Machine, units: &[f64]) -> Vec<usize> {
    let at_end = |at: &usize| {
        let parameter = &machine.parameters[*at];
        let of_joint = |joint: &Joint| joint.stiffness.base == Base::Parameter(*at);
        parameter.role == Role::Described
            && parameter.fit != FitRule::Never
            && parameter.is_at_bound(parameter.from_unit(units[*at]))
            && machine.joints.iter().any(of_joint)
    };
    (0..machine.parameters.len().min(units.len())).filter(at_end).collect()
}

/// Returns the number of the description that a relative tolerance changes.
fn target_of(machine: &Machine, tolerance: usize) -> Option<Target> {
    let depends = |value: &Value| value.depends_on().any(|at| at == tolerance);
    let of_point = machine.points.iter().find(|p| p.role == Role::Described && depends(&p.inertia));
    let of_shaft = machine.shafts.iter().find_map(|shaft| {
        let numbers = [
            (TargetKind::ShaftDiameter, &shaft.diameter),
            (TargetKind::ShaftShearModulus, &shaft.shear_modulus),
            (TargetKind::ShaftModulus, &shaft.youngs_modulus),
        ];
        let (kind, _) = numbers.into_iter().find(|(_, number)| depends(number))?;
        Some(kind.of(&shaft.name))
    });
    of_point.map(|point| TargetKind::PointInertia.of(&point.name)).or(of_shaft)
}

fn added(mechanism: Mechanism, unit: &str, scale: Scale) -> Parameter {
    Parameter {
        id: String::new(),
        unit: unit.into(),
        mechanism,
        role: Role::Described,
        start: 0.0,
        lower: 0.0,
        upper: 0.0,
        scale,
        fit: FitRule::Always,
        prior: None,
        source: "range of a diagnosis".into(),
        description: String::new(),
    }
}

fn candidate(id: &str, description: String, patch: Patch) -> Effect {
    Effect {
        id: id.into(),
        description,
        signature: None,
        discriminating_test: Some(format!("check {id} in the description and on the machine")),
        confusable_with: Vec::new(),
        confusable_with_slow: Vec::new(),
        common: false,
        refines: None,
        needs: Vec::new(),
        at: None,
        data: vec![Data::Frf],
        patch,
    }
}

/// Returns the id under which a document states a parameter: that of the machine for which it stands.
pub fn stated_id(id: &str) -> &str {
    id.strip_prefix(MARK).unwrap_or(id)
}

/// States a fitted number: its candidate's description, with the estimate.
pub(super) fn number_text(number: &Effect, hypothesis: &Hypothesis, fitted: &Fitted) -> String {
    let values = values_of(hypothesis, fitted);
    let own = number.patch.parameters.iter().filter_map(|p| hypothesis.machine.parameter(&p.id));
    let estimate = own.map(|at| match &hypothesis.machine.parameters[at] {
        Parameter { mechanism: Mechanism::Ratio, .. } => format!("by {:+.1} %", 100.0 * values[at]),
        Parameter { unit, .. } => format!("it is {:.3e} {unit}", values[at]),
    });
    format!("{} ({})", number.description, estimate.collect::<Vec<_>>().join(", "))
}
