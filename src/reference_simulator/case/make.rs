//! Generation of a case and its label from a slot of the plan.

use super::band::shortest_band;
use super::choice::Choice;
use super::fit::Fit;
use super::fitted::FittedGauge;
use super::gauge::Gauge;
use super::imitation::{Imitation, imitation};
use super::label::{Gap, Label, WrongParameter};
use super::measure::check_decay;
use super::plan::{Kind, Plan, Slot, Strength};
use super::record::Case;
use super::size::{set_noise, set_sizes};
use super::strike::simulated_test;
use super::subject::Subject;
use super::survey::Survey;
use crate::attempt::first_accepted;
use crate::draw::Draw;
use crate::effect::{Effect, EffectKind};
use crate::machine::catalogue::round_to;
use crate::machine::point::Channel;
use crate::{Result, SimulatorError};

/// Branch of the random numbers of a search for imitations.
const IMITATION: u64 = 0x696d;

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
    let draw = Draw::new(seed).branch(index as u64);
    first_accepted(index, &draw, |attempt, draw| attempted(slot, index, attempt, draw))
}

fn attempted(slot: &Slot, index: usize, attempt: usize, draw: &mut Draw) -> Result<(Case, Label)> {
    let mut choice = Choice::random(slot, attempt, draw);
    let channels = choice.channels.clone();
    let clean = choice.subject.without_effects();
    check_decay(&clean, &choice.setting, &channels, choice.spacing)?;
    let survey = Survey::new(&clean, &choice.setting, &channels, &choice.levels, choice.spacing)?;
    let thin = survey.thinned();
    let rough = Fit::of_chain(&clean.drawn, &thin);
    let without = rough.run(&thin.base, &rough.true_point())?;
    let ratio = draw.between(1.12, 1.9);
    set_noise(&mut choice.setting, &thin, without.held_out, ratio);
    let mut survey = survey.with_setting(&choice.setting);
    let mut without = Fit::of_chain(&clean.drawn, &survey).run(&survey.base, &without.point)?;
    if !(1.05..2.2).contains(&(without.held_out.hypot(survey.floor()) / survey.floor())) {
        // The full set of lines gives another gap than the thinned one, so the noise is set again.
        set_noise(&mut choice.setting, &survey, without.held_out, ratio);
        survey = survey.with_setting(&choice.setting);
        without = Fit::of_chain(&clean.drawn, &survey).run(&survey.base, &without.point)?;
    }
    let (mut noncentrality, mut band_hz) = (Vec::new(), None);
    let (mut fitted_noncentrality, mut closest) = (Vec::new(), None);
    let mut strength = slot.strength;
    if !choice.subject.effects.is_empty() {
        let gauge = Gauge::new(&clean, survey.clone())?;
        noncentrality = set_sizes(&mut choice.subject, slot, &gauge, &without.point, attempt, draw)?;
        if let Some(reached) = enlarge_until_decay(&mut choice, &channels, &gauge)? {
            noncentrality = reached;
            strength = noncentrality.first().map(|value| Strength::of(*value));
        }
        (fitted_noncentrality, closest) = as_fitted(slot, &choice, &survey, draw)?;
        band_hz = shortest_band(&survey.lines_hz, &gauge.unexplained(&choice.subject)?.by_line, 0.7);
    }
    let fit = Fit::of_chain(&clean.drawn, &survey);
    let wrong = (slot.kind == Kind::HardNullWrongParameter).then(|| wrong_parameter(&clean, draw));
    let with = match wrong.as_ref().and_then(WrongParameter::frozen) {
        Some(frozen) => Fit { frozen: Some(frozen), ..fit }.run(&survey.base, &without.point)?,
        None if choice.subject.effects.is_empty() => without.clone(),
        None => fit.run(&survey.of(&choice.subject)?, &without.point)?,
    };
    let mut label = labelled(slot, index, attempt, &choice);
    label.noncentrality = noncentrality;
    label.strength = strength;
    label.fitted_noncentrality = fitted_noncentrality;
    label.imitation = closest;
    label.band_hz = band_hz;
    label.gap = Gap::new(survey.floor(), [without.fit, without.held_out], [with.fit, with.held_out]);
    let mut case = simulated_test(slot, &choice, &mut label, draw)?;
    if let Some(wrong) = wrong {
        case.description
            .parameters
            .iter_mut()
            .filter(|parameter| parameter.name == wrong.name)
            .for_each(|one| one.start = wrong.start);
        wrong.state(&mut case.freeze, &mut label);
    }
    Ok((case, label))
}

/// Enlarges the effects until some block contains the response, and returns their new non-centralities if
/// they changed.
///
/// A weak spring to ground makes a mode so slow that no block contains its decay: it cannot be tested.
fn enlarge_until_decay(choice: &mut Choice, channels: &[Channel], gauge: &Gauge) -> Result<Option<Vec<f64>>> {
    let mut is_enlarged = false;
    loop {
        match check_decay(&choice.subject, &choice.setting, channels, choice.spacing) {
            Ok(()) if !is_enlarged => return Ok(None),
            Ok(()) => break,
            Err(refusal) => {
                let larger = |effect: &Effect| (3.0 * effect.size).min(effect.kind.largest());
                if choice.subject.effects.iter().all(|effect| larger(effect) <= effect.size) {
                    return Err(refusal);
                }
                for effect in &mut choice.subject.effects {
                    effect.size = larger(effect);
                }
                is_enlarged = true;
            }
        }
    }
    let alone = |effect: &Effect| {
        gauge.after_refit(&Subject { effects: vec![effect.clone()], ..choice.subject.clone() })
    };
    choice.subject.effects.iter().map(alone).collect::<Result<Vec<f64>>>().map(Some)
}

/// Returns the non-centrality of each effect alone as the given positions show it, and for an outside cause
/// the library effect that comes closest to it.
fn as_fitted(
    slot: &Slot,
    choice: &Choice,
    survey: &Survey,
    draw: &Draw,
) -> Result<(Vec<f64>, Option<Imitation>)> {
    let subject = &choice.subject;
    let gauge = FittedGauge::new(subject, &survey.thinned(), choice.given.clone());
    let alone =
        |effect: &Effect| gauge.noncentrality(&Subject { effects: vec![effect.clone()], ..subject.clone() });
    let sizes = subject.effects.iter().map(alone).collect::<Result<Vec<f64>>>()?;
    if slot.kind != Kind::Unknown {
        return Ok((sizes, None));
    }
    let is_held = subject.drawn.description.holds_rotor;
    let is_possible = |kind: EffectKind| {
        kind.fits(is_held) && slot.layout.is_none_or(|layout| layout.refusal(kind).is_none())
    };
    Ok((sizes, imitation(&gauge, subject, is_possible, &draw.branch(IMITATION))?))
}

/// Builds the label with all values known before the test.
fn labelled(slot: &Slot, index: usize, attempt: usize, choice: &Choice) -> Label {
    let subject = &choice.subject;
    let machine = subject.nuisance.applied(subject.drawn.with_true_joints());
    Label {
        effects: slot.effects.iter().map(|effect| effect.name().to_owned()).collect(),
        alternatives: slot.partner.iter().map(|effect| effect.name().to_owned()).collect(),
        values: subject.effects.iter().map(|effect| effect.values(&machine)).collect(),
        places: subject.effects.iter().map(Effect::place).collect(),
        joints: subject.nuisance.effective(subject.drawn.joints.clone()),
        layout: slot.layout.map(|layout| layout.name().to_owned()),
        ..Label::new(index, slot.kind, slot.strength, attempt)
    }
}

/// Draws a wrong start value of one joint.
fn wrong_parameter(subject: &Subject, draw: &mut Draw) -> WrongParameter {
    // A bearing that floats has no stiffness.
    let names: Vec<&str> = ["k_al", "k_ar", "k_n", "k_m"]
        .into_iter()
        .filter(|name| subject.drawn.joints.contains_key(*name))
        .collect();
    let name = names[draw.index(names.len())];
    let factor = draw.factor(1.6, 3.0);
    let range = subject
        .drawn
        .description
        .parameter(name)
        .map_or([0.0, f64::INFINITY], |parameter| [parameter.lower, parameter.upper]);
    let start = round_to(subject.drawn.joints[name] * factor, 2).clamp(range[0], range[1]);
    WrongParameter { name, start, factor, is_frozen: draw.chance(0.5) }
}
