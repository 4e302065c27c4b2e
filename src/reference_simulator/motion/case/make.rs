//! Generation of a case and its label from a slot of the plan.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::fault::DataFault;
use super::fit::fitted;
use super::gauge::{Gauge, Test, Unexplained};
use super::plan::{Plan, Slot};
use super::record::{Case, Record};
use super::rows::Blocks;
use super::tour::{HELD_OUT, Tour, tour};
use crate::attempt::first_accepted;
use crate::case::{Gap, Kind, Label, Strength, WrongParameter};
use crate::draw::Draw;
use crate::machine::catalogue::round_to;
use crate::motion::belief::{Belief, IDS};
use crate::motion::catalogue::{DrawnAxis, MotionLimits, random_axis};
use crate::motion::effect::{Effect, EffectKind};
use crate::motion::layout::MotionLayout;
use crate::motion::path::Path;
use crate::motion::phase::Phase;
use crate::motion::run::{Machine, STEP_S, Sensors, Side};
use crate::sizing;
use crate::{Result, SimulatorError};

/// Generates one case of a plan. It depends only on seed, plan entry and number.
pub fn generate_one(seed: u64, plan: &Plan, index: usize) -> Result<(Case, Label)> {
    let slot = plan.slots.get(index).ok_or(SimulatorError::NoSuchCase { index, count: plan.slots.len() })?;
    if let Some(layout) = slot.layout {
        let refused = slot
            .effects
            .iter()
            .chain(&slot.partner)
            .find_map(|effect| Some((*effect, layout.refusal(*effect)?)));
        if let Some((effect, reason)) = refused {
            return Err(SimulatorError::NotOnLayout {
                index,
                effect: effect.name(),
                layout: layout.name(),
                reason,
            });
        }
    }
    let draw = Draw::new(seed).branch(0x6178_6973).branch(index as u64);
    first_accepted(index, &draw, |attempt, draw| attempted(slot, index, attempt, draw))
}

/// Random choices of a case before its test.
pub struct Choice {
    /// The axis without effects.
    pub drawn: DrawnAxis,
    /// The test.
    pub test: Test,
    /// Effects of size 1.
    pub effects: Vec<Effect>,
}

impl Choice {
    /// Draws axis, test and effects of a slot.
    pub fn random(slot: &Slot, attempt: usize, draw: &mut Draw) -> Self {
        let viscous = if slot.tour == Tour::Flat { [2.5, 4.0] } else { [0.3, 1.2] };
        let mut drawn = match slot.layout {
            None => random_axis(viscous, draw),
            Some(layout) => layout.axis(viscous, draw),
        };
        let has = |kind| slot.effects.contains(&kind);
        let surfaces = [&mut drawn.machine.axis.bearing, &mut drawn.machine.axis.guide];
        for surface in surfaces {
            surface.coulomb_n *= if has(EffectKind::CoulombFriction) { 0.0 } else { 1.0 };
            surface.viscous_n_s_m *= if has(EffectKind::ViscousFriction) { 0.0 } else { 1.0 };
        }
        // Later attempts use the other sensor location: one location may be unable to show an effect.
        let fixed = slot.kind == Kind::LookAlike || slot.effects.iter().any(|effect| effect.side().is_some());
        let side = match (slot.side, !fixed && attempt / 4 % 2 == 1) {
            (Side::Motor, true) | (Side::Table, false) => Side::Table,
            (Side::Table, true) | (Side::Motor, false) => Side::Motor,
        };
        let one_mass = draw.chance(0.5);
        let belt = slot.layout == Some(MotionLayout::BeltDriven);
        let is_rigid = side == Side::Motor
            && !has(EffectKind::Backlash)
            && slot.kind != Kind::LookAlike
            && one_mass
            && !belt;
        let weighing = draw.chance(0.3);
        let is_weighed = weighing || slot.effects.iter().any(|effect| effect.needs_weighing());
        let lacks = [(EffectKind::CoulombFriction, IDS[2]), (EffectKind::ViscousFriction, IDS[1])];
        let without: Vec<&str> = lacks.into_iter().filter(|(kind, _)| has(*kind)).map(|(_, id)| id).collect();
        let belief = Belief::new(&drawn, side, is_rigid, is_weighed, &without);
        let push = drawn.machine.axis.moving_mass_kg() * drawn.limits.acceleration_m_s2;
        let sensors = Sensors {
            side,
            quantum_m: if side == Side::Motor { 5e-8 } else { 2e-7 },
            delay_s: draw.within(5e-6),
            jitter_s: draw.between(0.0, 4e-6),
            noise_m: if side == Side::Motor { 0.0 } else { 1e-6 },
            noise_n: 0.02 * push,
            coloured: draw.between(0.1, 0.5),
            corner_hz: draw.log_between(8.0, 60.0),
        };
        let paths = tour(slot.tour, &drawn.limits, &mut draw.branch(7));
        let effects = slot.effects.iter().map(|&kind| Effect::random(kind, draw)).collect();
        Self { test: Test::of(paths, sensors, belief), drawn, effects }
    }

    /// Returns the axis with some effects.
    pub fn with<'a>(&self, effects: impl IntoIterator<Item = &'a Effect>) -> Machine {
        let mut machine = self.drawn.machine.clone();
        effects.into_iter().for_each(|effect| effect.apply_to(&mut machine, &self.drawn.limits));
        machine
    }
}

impl Test {
    fn of(paths: Vec<(&'static str, Path)>, sensors: Sensors, belief: Belief) -> Self {
        let held_out = paths.iter().map(|(name, _)| HELD_OUT.contains(name)).collect();
        Self { paths, held_out, sensors, belief }
    }

    /// Returns the test with the usual motions in addition to its own.
    pub fn with_more(&self, limits: &MotionLimits, draw: &mut Draw) -> Self {
        let paths = self.paths.iter().cloned().chain(tour(Tour::Usual, limits, draw)).collect();
        Self::of(paths, self.sensors.clone(), self.belief.clone())
    }
}

fn attempted(slot: &Slot, index: usize, attempt: usize, draw: &mut Draw) -> Result<(Case, Label)> {
    let mut choice = Choice::random(slot, attempt, draw);
    let clean = choice.drawn.machine.clone();
    let ratio = draw.between(1.15, 1.6);
    let noise_draw = draw.branch(11);
    choice.test.set_noise(&clean, ratio, &noise_draw);
    let gauge = Gauge::new(choice.test.clone(), &clean, &choice.drawn.limits, &noise_draw)?;
    let floor = choice.test.floor(&choice.test.logs(&clean), &gauge.best.parameters, &noise_draw);
    let found = gauge.best.held_out.hypot(floor) / floor;
    // In motions with little information, the sensors' lower limits set the noise.
    let least = if slot.kind == Kind::LookAlike { 1.0 } else { 1.1 };
    if !(least..2.0).contains(&found) {
        return Err(SimulatorError::Noise { ratio: found });
    }
    let noncentrality = set_sizes(&mut choice, slot, &gauge, floor, draw)?;
    let machine = choice.with(&choice.effects);
    let wrong = (slot.kind == Kind::HardNullWrongParameter).then(|| wrong_parameter(&gauge, draw));
    let with_rows: Blocks =
        if choice.effects.is_empty() { gauge.base.clone() } else { choice.test.blocks(&machine) };
    let frozen = wrong.as_ref().and_then(WrongParameter::frozen);
    let with = fitted(&with_rows, &gauge.noise_n(), &choice.test.held_out, &choice.test.belief, frozen);
    let mut label = labelled(slot, index, attempt, &choice, &gauge);
    label.noncentrality = noncentrality;
    label.phases =
        if choice.effects.is_empty() { Vec::new() } else { phases_of(&gauge.unexplained(&machine)) };
    label.gap = Gap::new(floor, [gauge.best.fit, gauge.best.held_out], [with.fit, with.held_out]);
    let data_fault = (slot.kind == Kind::HardNullBadChannel)
        .then(|| (draw.index(choice.test.paths.len()), DataFault::random(draw)));
    let mut case = Case {
        name: label.case.clone(),
        belief: choice.test.belief.clone(),
        records: recorded(&machine, &choice.test, data_fault, &draw.branch(1)),
        fit: fitted_names(&choice.test),
        quiet: quiet(&machine, &choice.test),
        freeze: Vec::new(),
        follow_up: None,
    };
    if let Some((at, data_fault)) = data_fault {
        label.fault = Some(data_fault.name().to_owned());
        label.faulty_records.push(case.records[at].file());
    }
    if slot.kind == Kind::LookAlike {
        let test = choice.test.with_more(&choice.drawn.limits, &mut draw.branch(8));
        let records = recorded(&machine, &test, None, &draw.branch(2));
        let (name, fit) = (format!("{}-more", case.name), fitted_names(&test));
        case.follow_up =
            Some(Box::new(Case { name, records, fit, quiet: quiet(&machine, &test), ..case.clone() }));
    }
    if let Some(wrong) = wrong {
        if let Some(parameter) = case.belief.parameter_mut(wrong.name) {
            parameter.start = wrong.start;
            parameter.lower = parameter.lower.min(0.5 * wrong.start);
            parameter.upper = parameter.upper.max(2.0 * wrong.start);
        }
        wrong.state(&mut case.freeze, &mut label);
    }
    Ok((case, label))
}

fn fitted_names(test: &Test) -> Vec<String> {
    test.paths
        .iter()
        .zip(&test.held_out)
        .filter(|(_, out)| !**out)
        .map(|((name, _), _)| (*name).to_owned())
        .collect()
}

/// Simulates the records: rounded encoders, a random motor force of 0.3 times the force noise, and noise of
/// each record from its own branch.
fn recorded(
    machine: &Machine,
    test: &Test,
    data_fault: Option<(usize, DataFault)>,
    draw: &Draw,
) -> Vec<Record> {
    let one = |(k, (name, path)): (usize, &(&'static str, Path))| {
        let own = draw.branch(k as u64);
        let track = machine.run(path, STEP_S, Some((0.3 * test.sensors.noise_n, 30.0, &mut own.branch(1))));
        let distort = |log: &mut _| {
            if let Some((_, data_fault)) = data_fault.filter(|(at, _)| *at == k) {
                data_fault.distort(log);
            }
        };
        Record { name: (*name).to_owned(), log: test.sensors.read(&track, distort, &mut own.branch(2)) }
    };
    test.paths.par_iter().enumerate().map(one).collect()
}

/// Simulates the held-out records without their random errors: exact encoder, no random motor force, but
/// delayed sensors.
fn quiet(machine: &Machine, test: &Test) -> Vec<Record> {
    let mut exact = machine.clone();
    exact.drive.set.quantum_m = 0.0;
    let sensors = test.sensors.quiet();
    let one = |(name, path): &(&'static str, Path)| {
        let log = sensors.read(&exact.run(path, STEP_S, None), |_| {}, &mut Draw::new(0));
        Record { name: (*name).to_owned(), log }
    };
    let held_out: Vec<_> =
        test.paths.iter().zip(&test.held_out).filter(|(_, out)| **out).map(|(path, _)| path).collect();
    held_out.into_par_iter().map(one).collect()
}

/// Gives each effect the size for its required strength and returns the non-centrality of each effect alone.
fn set_sizes(
    choice: &mut Choice,
    slot: &Slot,
    gauge: &Gauge,
    floor: f64,
    draw: &mut Draw,
) -> Result<Vec<f64>> {
    let mut wanted = slot.strength.unwrap_or(Strength::Clear).noncentrality();
    let mut reached = Vec::new();
    for index in 0..choice.effects.len() {
        let effect = choice.effects[index].clone();
        let (machine, limits) = (&choice.drawn.machine, &choice.drawn.limits);
        let mut size = sizing::size_or_weaker(index > 0, wanted, |wanted| {
            gauge.size_for(&effect, machine, limits, wanted)
        })?;
        if index == 0 && slot.strength == Some(Strength::Strong) {
            size = enlarged_size(choice, &effect, size, gauge, floor, draw)?;
        }
        choice.effects[index].size = size;
        let value = gauge.unexplained(&choice.with([&choice.effects[index]])).noncentrality;
        reached.push(value);
        wanted = value * draw.between(0.3, 0.7);
    }
    Ok(reached)
}

/// Returns an effect size of at least `least`.
///
/// In half of the cases it is a usual size of the kind. Otherwise the gap with noise of the refitted
/// description is 1.3 to 3 times the gap without the effect.
fn enlarged_size(
    choice: &Choice,
    effect: &Effect,
    least: f64,
    gauge: &Gauge,
    floor: f64,
    draw: &mut Draw,
) -> Result<f64> {
    let before = gauge.best.held_out.hypot(floor);
    let largest = effect.kind.largest();
    let (usual, ratio) = (draw.log_between(0.4, 1.5).min(largest), draw.between(1.3, 3.0));
    if draw.chance(0.5) && usual > least {
        return Ok(usual);
    }
    let gap_ratio = |size: f64| {
        let rows = choice.test.blocks(&choice.with([&effect.sized(size)]));
        Ok(fitted(&rows, &gauge.noise_n(), &choice.test.held_out, &choice.test.belief, None)
            .held_out
            .hypot(floor)
            / before)
    };
    Ok(sizing::size_for_gap_ratio([least, largest], ratio, 6, gap_ratio)?.0)
}

/// Returns the phases in which an effect shows: at least half the largest mean square per row, or a third of
/// the total.
fn phases_of(unexplained: &Unexplained) -> Vec<String> {
    let sums = |phase: Phase| {
        let own = unexplained.by_row.iter().filter(|(at, _)| *at == phase).map(|(_, square)| square);
        own.fold((0.0, 0usize), |(sum, count), square| (sum + square, count + 1))
    };
    let all: Vec<(Phase, f64, usize)> =
        Phase::ALL.into_iter().map(|phase| (phase, sums(phase).0, sums(phase).1)).collect();
    let density = |sum: f64, count: usize| if count == 0 { 0.0 } else { sum / count as f64 };
    let (total, densest) = all.iter().fold((0.0, 0.0), |(total, densest): (f64, f64), (_, sum, count)| {
        (total + sum, densest.max(density(*sum, *count)))
    });
    let shows = |sum: f64, count: usize| density(sum, count) >= 0.5 * densest || sum >= total / 3.0;
    all.into_iter()
        .filter(|(_, sum, count)| shows(*sum, *count))
        .map(|(phase, _, _)| phase.name().to_owned())
        .collect()
}

/// Builds the label with all values known before the records.
fn labelled(slot: &Slot, index: usize, attempt: usize, choice: &Choice, gauge: &Gauge) -> Label {
    let alternatives = slot.effects.iter().filter_map(|effect| effect.indistinguishable_from());
    let known = IDS.into_iter().zip(gauge.best.parameters).filter(|(id, _)| choice.test.belief.has(id));
    let values = |effect: &Effect| -> BTreeMap<String, f64> {
        effect.values(&choice.drawn.machine, &choice.drawn.limits)
    };
    Label {
        effects: slot.effects.iter().map(|effect| effect.name().to_owned()).collect(),
        alternatives: slot
            .partner
            .into_iter()
            .chain(alternatives)
            .map(|effect| effect.name().to_owned())
            .collect(),
        values: choice.effects.iter().map(values).collect(),
        places: slot.effects.iter().map(|effect| effect.place()).collect(),
        joints: known.map(|(id, value)| (id.to_owned(), value)).collect(),
        layout: slot.layout.map(|layout| layout.name().to_owned()),
        ..Label::new(index, slot.kind, slot.strength, attempt)
    }
}

/// Draws a wrong start value of one parameter.
fn wrong_parameter(gauge: &Gauge, draw: &mut Draw) -> WrongParameter {
    let at = draw.index(3);
    let factor = draw.factor(1.6, 3.0);
    let start = round_to(gauge.best.parameters[at] * factor, 2);
    WrongParameter { name: IDS[at], start, factor, is_frozen: draw.chance(0.5) }
}
