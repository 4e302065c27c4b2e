//! Cases made by the models under test: the same machines and strengths, nulls and single effects of the library, without nuisances.
//!
//! A diagnosis that is scored on its own model's data is flattered. How much, these cases tell.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};
use num_complex::Complex64;

use super::super::common::told;
use crate::config::read_machine_text;
use crate::machine::{Chain, Data, Effect, Machine, Operating};
use crate::model::{Rods, Structure};
use crate::truth::draw::Draw;
use crate::truth::effect::Place;
use crate::truth::{Case, Gap, Kind, Label, Plan, Strength, generate_one};
use crate::unit::omega_rad_s;

/// Relative error of a line that a careful test reproduces, beside its noise.
const REPRODUCED: f64 = 0.01;

/// Lines of a record that strength is counted on.
const FEW_LINES: usize = 60;

/// Amplitudes drawn of one effect before the case is given up.
const ATTEMPTS: usize = 30;

/// As [`generate_one`], with the responses of the models under test.
pub fn own_case(seed: u64, plan: &Plan, index: usize) -> Result<(Case, Label), String> {
    let (mut case, mut label) = generate_one(seed, plan, index).map_err(told)?;
    case.follow_up = None;
    let mut draw = Draw::new(seed).branch(0x006f_776e).branch(index as u64);
    let config = read_machine_text("machine.toml", &case.description.to_toml(), &[], &[]).map_err(told)?;
    let mut machine = config.machine;
    let mut values = truth_of(&machine, &label);
    label.kind = match label.kind {
        Kind::Null | Kind::HardNullBadChannel => Kind::Null,
        Kind::HardNullWrongParameter => Kind::HardNullWrongParameter,
        Kind::Single | Kind::LookAlike | Kind::Double | Kind::Unknown => Kind::Single,
    };
    if label.kind == Kind::Single {
        let gauge = Gauge::new(&machine, &values, &case)?;
        let effect = chosen(&machine, &config.effects, &label, &mut draw)?;
        let with = machine.with_effect(effect).map_err(told)?;
        let wanted = match label.strength {
            Some(Strength::Faint) => 9.0,
            Some(Strength::Weak) => 25.0,
            Some(Strength::Strong) => 400.0,
            _ => 100.0,
        };
        let (found, reached) = amplitude(&gauge, &with, &machine, &values, &effect.id, wanted, &case, &mut draw)?;
        let own: BTreeMap<String, f64> = with.parameters.iter().zip(&found).skip(values.len()).map(|(p, v)| (p.id.clone(), *v)).collect();
        label.places = vec![place(effect, &label)];
        label.effects = vec![effect.id.clone()];
        (label.noncentrality, label.values) = (vec![reached], vec![own]);
        (machine, values) = (with, found);
    } else {
        label.effects.clear();
    }
    let closed = (label.kind == Kind::Single).then_some(1.0);
    label = Label {
        alternatives: Vec::new(),
        band_hz: None,
        gap: Gap { closed, ..Gap::default() },
        fault: None,
        faulty_records: Vec::new(),
        exact: Vec::new(),
        ..label
    };
    let responses = responses(&machine, &values, &case, 1)?;
    let averages = case.averages;
    for (record, exact) in case.records.iter_mut().zip(responses) {
        for (line, exact) in record.lines.iter_mut().zip(exact) {
            let sd = component_sd(line.coherence, averages);
            line.response = exact * (sd * Complex64::new(draw.normal(), draw.normal())).exp();
        }
    }
    Ok((case, label))
}

/// True values of the machine's parameters.
fn truth_of(machine: &Machine, label: &Label) -> Vec<f64> {
    machine.parameters.iter().map(|p| label.joints.get(&p.id).copied().unwrap_or(p.start)).collect()
}

/// The effect of the label if the library has it and the machine can have it, else any that can be had.
fn chosen<'e>(machine: &Machine, library: &'e [Effect], label: &Label, draw: &mut Draw) -> Result<&'e Effect, String> {
    let possible: Vec<&Effect> =
        library.iter().filter(|effect| effect.data.contains(&Data::Frf) && machine.with_effect(effect).is_ok()).collect();
    let same = possible.iter().find(|effect| label.effects.first() == Some(&effect.id));
    same.or_else(|| possible.get(draw.index(possible.len())))
        .copied()
        .ok_or_else(|| "no effect of the library applies to the machine".into())
}

/// Where an effect sits: as the label has it, or whatever it needs; an effect that needs nothing is one of the measurement.
fn place(effect: &Effect, label: &Label) -> Place {
    let same = label.effects.first() == Some(&effect.id);
    label.places.first().filter(|_| same).cloned().unwrap_or_else(|| {
        let accepted = if effect.needs.is_empty() { vec!["measurement".to_string()] } else { effect.needs.clone() };
        Place { interface: accepted[0].clone(), accepted }
    })
}

/// Draws an effect's values in their ranges and brings them so near to the start, where it does nothing, that it has the strength wanted.
#[expect(clippy::too_many_arguments, reason = "one place calls it")]
fn amplitude(
    gauge: &Gauge,
    with: &Machine,
    machine: &Machine,
    values: &[f64],
    id: &str,
    wanted: f64,
    case: &Case,
    draw: &mut Draw,
) -> Result<(Vec<f64>, f64), String> {
    let added = &with.parameters[machine.parameters.len()..];
    let strength = |values: &[f64]| gauge.noncentrality(with, values, case);
    let at = |places: &[f64]| -> Vec<f64> {
        values.iter().copied().chain(added.iter().zip(places).map(|(p, place)| p.from_unit(*place))).collect()
    };
    // Where the effect does nothing: at its start, or for one that starts at a usual size (a drive that holds) far below its range.
    let mut least: Vec<f64> = added.iter().map(|p| p.to_unit(p.start)).collect();
    if strength(&at(&least))? > wanted {
        least = vec![-1.0; added.len()];
    }
    let every = |share: f64, target: &[f64]| -> Vec<f64> {
        at(&least.iter().zip(target).map(|(from, to)| from + share * (to - from)).collect::<Vec<f64>>())
    };
    let mut reached: f64 = 0.0;
    for _ in 0..ATTEMPTS {
        let mut target: Vec<f64> = added.iter().map(|_| draw.unit()).collect();
        if id == "frf-quantity" {
            // Taken for its neighbour, or not: there is nothing between.
            target = added.iter().map(|p| p.to_unit(draw.sign())).collect();
            let values = every(1.0, &target);
            return Ok((values.clone(), strength(&values)?));
        }
        let largest = strength(&every(1.0, &target))?;
        reached = reached.max(largest);
        if largest < wanted {
            continue;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let value = strength(&every(middle, &target))?;
            if (value / wanted).ln().abs() < 0.05 {
                return Ok((every(middle, &target), value));
            }
            (low, high) = if value < wanted { (middle, high) } else { (low, middle) };
        }
    }
    Err(format!("{id}: no amplitude drawn has a non-centrality of {wanted}; {reached:.1} is the largest met"))
}

/// Responses of a case's records in their quantity, on every n-th line.
fn responses(machine: &Machine, values: &[f64], case: &Case, nth: usize) -> Result<Vec<Vec<Complex64>>, String> {
    let mut out = Vec::with_capacity(case.records.len());
    for record in &case.records {
        let point = |name: &str| machine.point(name).ok_or_else(|| format!("the machine has no point «{name}»"));
        let (response, excitation) = (point(record.channel.response.name())?, point(record.channel.excitation.name())?);
        let structure = Arc::new(Structure::new(machine, response, excitation, Rods::Exact).map_err(told)?);
        let (mut network, mut work) = (structure.network(), structure.workspace());
        let nut_m = case.positions.iter().find(|p| p.name == record.position).map(|p| p.nut_m);
        let operating = Operating::at(nut_m);
        network.update(machine, values, &operating);
        let chain = machine.chain.at(values, &operating);
        let lines = record.lines.iter().step_by(nth).map(|line| {
            let omega = omega_rad_s(line.frequency_hz);
            let recorded = Chain::log_factor(chain, omega).exp() * case.quantity.factor(line.frequency_hz);
            network.receptance(omega, &mut work) * recorded
        });
        out.push(lines.collect());
    }
    Ok(out)
}

/// Standard deviation of each component of ln H.
fn component_sd(coherence: f64, averages: usize) -> f64 {
    let coherence = coherence.clamp(1e-3, 1.0);
    ((1.0 - coherence) / (2.0 * averages as f64 * coherence)).sqrt()
}

/// What is left of a change after the machine's own parameters explain what they can, in units of noise.
struct Gauge {
    nth: usize,
    base: Vec<Vec<Complex64>>,
    /// 1/sd of each line, weighted up to all lines.
    weights: Vec<Vec<f64>>,
    columns: DMatrix<f64>,
    normal: Cholesky<f64, nalgebra::Dyn>,
}

impl Gauge {
    fn new(machine: &Machine, values: &[f64], case: &Case) -> Result<Self, String> {
        let most = case.records.iter().map(|record| record.lines.len()).max().unwrap_or(0);
        let nth = most.div_ceil(FEW_LINES).max(1);
        let base = responses(machine, values, case, nth)?;
        let weight = |coherence: f64| {
            let sd = component_sd(coherence, case.averages).hypot(REPRODUCED);
            if coherence >= 0.8 { (nth as f64).sqrt() / sd } else { 0.0 }
        };
        let weights: Vec<Vec<f64>> =
            case.records.iter().map(|record| record.lines.iter().step_by(nth).map(|line| weight(line.coherence)).collect()).collect();
        let step = 1e-3;
        let mut columns = Vec::new();
        for at in 0..values.len() {
            let mut moved = values.to_vec();
            moved[at] *= f64::exp(step);
            let change = whitened(&responses(machine, &moved, case, nth)?, &base, &weights);
            // One decade for one standard deviation: the ranges of machine descriptions.
            columns.push(DVector::from_vec(change) * (10f64.ln() / step));
        }
        let rows = columns.first().map_or(0, DVector::len);
        let columns = if columns.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(&columns) };
        let normal = columns.transpose() * &columns + DMatrix::identity(columns.ncols(), columns.ncols());
        let normal = Cholesky::new(normal).ok_or("the machine's parameters cannot be told apart at all")?;
        Ok(Self { nth, base, weights, columns, normal })
    }

    fn noncentrality(&self, machine: &Machine, values: &[f64], case: &Case) -> Result<f64, String> {
        let change = DVector::from_vec(whitened(&responses(machine, values, case, self.nth)?, &self.base, &self.weights));
        let explained = &self.columns * self.normal.solve(&(self.columns.transpose() * &change));
        Ok(change.dot(&(&change - explained)).max(0.0))
    }
}

fn whitened(changed: &[Vec<Complex64>], base: &[Vec<Complex64>], weights: &[Vec<f64>]) -> Vec<f64> {
    let lines = changed.iter().flatten().zip(base.iter().flatten()).zip(weights.iter().flatten());
    lines
        .flat_map(|((a, b), weight)| {
            let change = (a / b).ln() * weight;
            [change.re, change.im]
        })
        .collect()
}
