//! Cases made by the models under test.
//!
//! Machines and strengths are those of the independent cases. The cases are null cases and single effects of
//! the library. Nuisance parameters are drawn from the diagnosis' own priors: the tolerances that the case
//! states, journals, nuts that hold a screw over a length, and errors of positions and channels.
//!
//! Scores on data of the diagnosis' own model are optimistic. These cases quantify by how much.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};
use num_complex::Complex64;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use config::read_machine_text;
use diagnosis::{sample_discrepancy, sample_prior};
use dynamics::model::{RodModel, Structure};
use machine::{Chain, Data, Effect, FitRule, Machine, Operating};
use numeric::random::normal;
use numeric::unit::omega_rad_s;
use reference_simulator::draw::Draw;
use reference_simulator::effect::Place;
use reference_simulator::machine::nuisance::Spread;
use reference_simulator::machine::point::Channel;
use reference_simulator::{Case, Gap, Kind, Label, Plan, Strength, generate_one};
use study::{StudyError, StudyResult};

/// Relative error of a line in a repeated test, in addition to its noise.
const REPEATABILITY: f64 = 0.01;

/// Largest number of lines of a record in the computation of the non-centrality.
const MAX_LINES: usize = 60;

/// Step of numerical derivatives, of ln(parameter).
const STEP: f64 = 1e-3;
/// The same of nuisance parameters, in standard deviations of their priors.
const STEP_SD: f64 = 0.05;

/// Number of amplitudes drawn of an effect before the case is given up.
const ATTEMPTS: usize = 30;

/// Makes a case as [`generate_one`], with the responses of the models under test.
///
/// # Errors  no drawn amplitude has the wanted strength, or the machine does not allow an effect.
pub fn own_case(seed: u64, plan: &Plan, index: usize) -> StudyResult<(Case, Label)> {
    let (mut case, mut label) = generate_one(seed, plan, index).map_err(StudyError::impossible)?;
    case.follow_up = None;
    let mut draw = Draw::new(seed).branch(0x006f_776e).branch(index as u64);
    let config = read_machine_text("machine.toml", &case.description.to_toml(), &[], &[])
        .map_err(StudyError::impossible)?;
    let nuts_m: Vec<f64> = case.positions.iter().map(|p| p.nut_m).collect();
    let described =
        config.machine.without_guide_tolerance().with_tolerances(&nuts_m).map_err(StudyError::impossible)?;
    let seed = draw.index(1 << 32) as u64;
    let mut truth = Truth::new(&described, &case, &label, seed);
    label.kind = match label.kind {
        Kind::Null | Kind::HardNullBadChannel => Kind::Null,
        Kind::HardNullWrongParameter => Kind::HardNullWrongParameter,
        Kind::Single | Kind::LookAlike | Kind::Double | Kind::Unknown => Kind::Single,
    };
    if label.kind == Kind::Single {
        let effect = select_effect(&described, &config.effects, &label, &mut draw)?;
        let wanted = match label.strength {
            Some(Strength::Faint) => 9.0,
            Some(Strength::Weak) => 25.0,
            Some(Strength::Strong) => 400.0,
            _ => 100.0,
        };
        let gauge = NoncentralityGauge::new(&truth, &described, &case)?;
        let patched = described.with_effect(effect).map_err(StudyError::impossible)?;
        let added = described.parameters.len()..patched.parameters.len();
        let with = truth.with(&patched, described.parameters.len(), seed);
        let reached;
        (truth, reached) =
            scale_to_strength(&gauge, with, added.clone(), &effect.id, wanted, &case, &mut draw)?;
        let values = added.map(|at| (truth.machine.parameters[at].id.clone(), truth.values[at])).collect();
        label.places = vec![place(effect, &label)];
        label.effects = vec![effect.id.clone()];
        (label.noncentrality, label.values) = (vec![reached], vec![values]);
    } else {
        label.effects.clear();
    }
    let closed = (label.kind == Kind::Single).then_some(1.0);
    label = Label {
        alternatives: Vec::new(),
        fitted_noncentrality: Vec::new(),
        imitation: None,
        band_hz: None,
        gap: Gap { closed, ..Gap::default() },
        fault: None,
        faulty_records: Vec::new(),
        ..label
    };
    let responses = truth.responses(&case, 1)?;
    let averages = case.averages;
    for (record, exact) in case.records.iter_mut().zip(responses) {
        for (line, exact) in record.lines.iter_mut().zip(exact) {
            let sd = component_sd(line.coherence, averages);
            line.response = exact * (sd * Complex64::new(draw.normal(), draw.normal())).exp();
        }
    }
    Ok((case, label))
}

/// The true machine and measurement of a case, in terms of the models under test.
#[derive(Clone)]
struct Truth {
    machine: Machine,
    values: Vec<f64>,
    /// Standard deviations that the case states.
    spread: Spread,
    /// Error of each nut position (m).
    nut_error_m: Vec<f64>,
    /// ln(gain) and delay (s) of each channel.
    channels: Vec<(Channel, [f64; 2])>,
}

impl Truth {
    /// Draws the truth of a description with nuisance parameters; the joints are those of the label.
    fn new(described: &Machine, case: &Case, label: &Label, seed: u64) -> Self {
        let random = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
        let spread = case.description.spread;
        let value = |p: &machine::Parameter, random: &mut Xoshiro256PlusPlus| {
            label.joints.get(&p.id).copied().or_else(|| sample_prior(p, random)).unwrap_or(p.start)
        };
        let values = described.parameters.iter().map(|p| value(p, random)).collect();
        let nut_error_m = case.positions.iter().map(|_| spread.nut_m * normal(random)).collect();
        let mut channels: Vec<(Channel, [f64; 2])> = Vec::new();
        for record in &case.records {
            if !channels.iter().any(|(channel, _)| *channel == record.channel) {
                channels
                    .push((record.channel, [spread.gain * normal(random), spread.delay_s * normal(random)]));
            }
        }
        let none = Truth { machine: Machine::default(), values, spread, nut_error_m, channels };
        none.with(described, described.parameters.len(), seed)
    }

    /// Replaces the machine by one whose first `shared` parameters are those of this one; the seed determines
    /// the journals.
    fn with(&self, machine: &Machine, shared: usize, seed: u64) -> Self {
        let machine = sample_discrepancy(machine, &mut Xoshiro256PlusPlus::seed_from_u64(!seed));
        let added_values = machine.parameters[shared..].iter().map(|p| p.start);
        let values = self.values[..shared].iter().copied().chain(added_values).collect();
        Truth { machine, values, ..self.clone() }
    }

    /// Computes the responses of a case's records in their quantity, on every n-th line.
    fn responses(&self, case: &Case, nth: usize) -> StudyResult<Vec<Vec<Complex64>>> {
        let mut out = Vec::with_capacity(case.records.len());
        for record in &case.records {
            let point = |name: &str| {
                self.machine
                    .point(name)
                    .ok_or_else(|| StudyError::impossible(format!("the machine has no point «{name}»")))
            };
            let (response, excitation) =
                (point(record.channel.response.name())?, point(record.channel.excitation.name())?);
            let structure = Arc::new(
                Structure::new(&self.machine, response, excitation, RodModel::Exact)
                    .map_err(StudyError::impossible)?,
            );
            let (mut model, mut work) = (structure.empty_model(), structure.workspace());
            let nut_m = case
                .positions
                .iter()
                .zip(&self.nut_error_m)
                .find(|(p, _)| p.name == record.position)
                .map(|(p, nut_error_m)| p.nut_m + nut_error_m);
            let operating = Operating::at(nut_m);
            model.update(&self.machine, &self.values, &operating);
            let chain = self.machine.chain.at(&self.values, &operating);
            let [gain, delay_s] = self
                .channels
                .iter()
                .find(|(channel, _)| *channel == record.channel)
                .map_or([0.0; 2], |(_, own)| *own);
            let lines = record.lines.iter().step_by(nth).map(|line| {
                let omega = omega_rad_s(line.frequency_hz);
                let own = Complex64::new(gain, -omega * delay_s);
                let recorded =
                    (Chain::log_factor(chain, omega) + own).exp() * case.quantity.factor(line.frequency_hz);
                model.receptance(omega, &mut work) * recorded
            });
            out.push(lines.collect());
        }
        Ok(out)
    }
}

/// Selects the effect of the label if it is in the library and applies to the machine, else any effect that
/// applies.
fn select_effect<'e>(
    machine: &Machine,
    library: &'e [Effect],
    label: &Label,
    draw: &mut Draw,
) -> StudyResult<&'e Effect> {
    let possible: Vec<&Effect> = library
        .iter()
        .filter(|effect| effect.data.contains(&Data::Frf) && machine.with_effect(effect).is_ok())
        .collect();
    let same = possible.iter().find(|effect| label.effects.first() == Some(&effect.id));
    same.or_else(|| possible.get(draw.index(possible.len())))
        .copied()
        .ok_or_else(|| StudyError::impossible("no effect of the library applies to the machine"))
}

/// Returns the location of an effect: that of the label, or the parts it needs. An effect without needs
/// belongs to the measurement.
fn place(effect: &Effect, label: &Label) -> Place {
    let same = label.effects.first() == Some(&effect.id);
    label.places.first().filter(|_| same).cloned().unwrap_or_else(|| {
        let accepted =
            if effect.needs.is_empty() { vec!["measurement".to_string()] } else { effect.needs.clone() };
        Place { interface: accepted[0].clone(), accepted }
    })
}

/// Draws an effect's values, the parameters `added` of a truth, in their ranges, and scales them to the
/// wanted non-centrality.
///
/// The values are scaled towards the start, where the effect vanishes. Returns the truth and its
/// non-centrality.
fn scale_to_strength(
    gauge: &NoncentralityGauge,
    with: Truth,
    added: std::ops::Range<usize>,
    id: &str,
    wanted: f64,
    case: &Case,
    draw: &mut Draw,
) -> StudyResult<(Truth, f64)> {
    let parameters = with.machine.parameters[added.clone()].to_vec();
    let at = |places: &[f64]| -> Truth {
        let mut truth = with.clone();
        for ((value, parameter), place) in truth.values[added.clone()].iter_mut().zip(&parameters).zip(places)
        {
            *value = parameter.from_unit(*place);
        }
        truth
    };
    let strength = |truth: &Truth| gauge.noncentrality(truth, case);
    // The effect vanishes at its start, or far below its range if it starts at a usual size (a servo
    // impedance).
    let mut least: Vec<f64> = parameters.iter().map(|p| p.to_unit(p.start)).collect();
    if strength(&at(&least))? > wanted {
        least = vec![-1.0; parameters.len()];
    }
    let every = |share: f64, target: &[f64]| -> Truth {
        at(&least.iter().zip(target).map(|(from, to)| from + share * (to - from)).collect::<Vec<f64>>())
    };
    let mut reached: f64 = 0.0;
    for _ in 0..ATTEMPTS {
        let mut target: Vec<f64> = parameters.iter().map(|_| draw.unit()).collect();
        if id == "frf-quantity" {
            // The quantity is mistaken by one derivative or not at all; there is no size between.
            target = parameters.iter().map(|p| p.to_unit(draw.sign())).collect();
            let truth = every(1.0, &target);
            let value = strength(&truth)?;
            return Ok((truth, value));
        }
        let largest = strength(&every(1.0, &target))?;
        reached = reached.max(largest);
        if largest < wanted {
            continue;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let truth = every(middle, &target);
            let value = strength(&truth)?;
            if (value / wanted).ln().abs() < 0.05 {
                return Ok((truth, value));
            }
            (low, high) = if value < wanted { (middle, high) } else { (low, middle) };
        }
    }
    Err(StudyError::impossible(format!(
        "{id}: no amplitude drawn has a non-centrality of {wanted}; {reached:.1} is the largest met"
    )))
}

/// Computes the standard deviation of each component of ln H.
fn component_sd(coherence: f64, averages: usize) -> f64 {
    let coherence = coherence.clamp(1e-3, 1.0);
    ((1.0 - coherence) / (2.0 * averages as f64 * coherence)).sqrt()
}

/// Measures the non-centrality of a change: its squared residual after a fit of joints and nuisance
/// parameters, in units of noise.
struct NoncentralityGauge {
    nth: usize,
    base: Vec<Vec<Complex64>>,
    /// 1/sd of each line, weighted up to all lines.
    weights: Vec<Vec<f64>>,
    columns: DMatrix<f64>,
    normal: Cholesky<f64, nalgebra::Dyn>,
}

impl NoncentralityGauge {
    fn new(truth: &Truth, described: &Machine, case: &Case) -> StudyResult<Self> {
        let most = case.records.iter().map(|record| record.lines.len()).max().unwrap_or(0);
        let nth = most.div_ceil(MAX_LINES).max(1);
        let base = truth.responses(case, nth)?;
        let weight = |coherence: f64| {
            let sd = component_sd(coherence, case.averages).hypot(REPEATABILITY);
            if coherence >= 0.8 { (nth as f64).sqrt() / sd } else { 0.0 }
        };
        let weights: Vec<Vec<f64>> = case
            .records
            .iter()
            .map(|record| record.lines.iter().step_by(nth).map(|line| weight(line.coherence)).collect())
            .collect();
        let mut columns = Vec::new();
        for (copy, step) in perturbed(truth, described) {
            columns.push(DVector::from_vec(whitened(&copy.responses(case, nth)?, &base, &weights)) / step);
        }
        let rows = columns.first().map_or(0, DVector::len);
        let columns =
            if columns.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(&columns) };
        let normal = columns.transpose() * &columns + DMatrix::identity(columns.ncols(), columns.ncols());
        let normal = Cholesky::new(normal).ok_or_else(|| {
            StudyError::impossible("the normal matrix of the machine's parameters is singular")
        })?;
        Ok(Self { nth, base, weights, columns, normal })
    }

    fn noncentrality(&self, truth: &Truth, case: &Case) -> StudyResult<f64> {
        let change =
            DVector::from_vec(whitened(&truth.responses(case, self.nth)?, &self.base, &self.weights));
        let explained = &self.columns * self.normal.solve(&(self.columns.transpose() * &change));
        Ok(change.dot(&(&change - explained)).max(0.0))
    }
}

/// Returns one copy of the truth per uncertain quantity, and its step in standard deviations. That of a joint
/// is one decade, as in the ranges of machine descriptions.
fn perturbed(truth: &Truth, described: &Machine) -> Vec<(Truth, f64)> {
    let mut out = Vec::new();
    let mut add = |step: f64, change: &dyn Fn(&mut Truth)| {
        let mut copy = truth.clone();
        change(&mut copy);
        out.push((copy, step));
    };
    for (at, parameter) in described.parameters.iter().enumerate() {
        match parameter.prior {
            Some(prior) => add(STEP_SD, &|t| {
                let deviation = prior.deviation(parameter.start, t.values[at]);
                t.values[at] = prior.value(parameter.start, deviation + STEP_SD);
            }),
            None if parameter.fit == FitRule::Never => {}
            None => add(STEP / 10f64.ln(), &|t| t.values[at] *= STEP.exp()),
        }
    }
    for at in 0..truth.nut_error_m.len() {
        add(STEP_SD, &|t| t.nut_error_m[at] += STEP_SD * t.spread.nut_m);
    }
    for at in 0..truth.channels.len() {
        add(STEP_SD, &|t| t.channels[at].1[0] += STEP_SD * t.spread.gain);
        add(STEP_SD, &|t| t.channels[at].1[1] += STEP_SD * t.spread.delay_s);
    }
    out
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
