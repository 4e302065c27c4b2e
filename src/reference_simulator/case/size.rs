//! Sizes of the effects of a case, and noise of its test.

use super::fit::Fit;
use super::gauge::Gauge;
use super::plan::{Slot, Strength};
use super::subject::Subject;
use super::survey::Survey;
use crate::draw::Draw;
use crate::effect::EffectKind;
use crate::hammer::setting::Setting;
use crate::sizing::{size_for_gap_ratio, size_or_weaker};
use crate::{Result, SimulatorError};

/// Number of attempts after which a barely visible effect is accepted.
const PATIENCE: usize = 8;

/// Sets the noise such that nuisance parameters make the gap `ratio` times its noise floor, within the limits
/// of real sensors.
pub fn set_noise(setting: &mut Setting, survey: &Survey, null_gap: f64, ratio: f64) {
    let wanted = null_gap / (ratio * ratio - 1.0).sqrt();
    for _ in 0..4 {
        setting.noise = (setting.noise * wanted / survey.with_setting(setting).floor()).clamp(0.0008, 0.06);
    }
}

/// Gives each effect the size for its required strength and returns the non-centrality of each effect alone.
pub fn set_sizes(
    subject: &mut Subject,
    slot: &Slot,
    gauge: &Gauge,
    start: &[f64],
    attempt: usize,
    draw: &mut Draw,
) -> Result<Vec<f64>> {
    let mut wanted = slot.strength.unwrap_or(Strength::Clear).noncentrality();
    let mut reached = Vec::new();
    for index in 0..subject.effects.len() {
        let mut alone = Subject { effects: vec![subject.effects[index].clone()], ..subject.clone() };
        if alone.effects[0].kind != EffectKind::FrfQuantity {
            alone.effects[0].size =
                size_or_weaker(index > 0, wanted, |wanted| gauge.size_for(&alone, wanted))?;
            if index == 0 && slot.strength == Some(Strength::Strong) {
                enlarge(&mut alone, gauge, start, attempt, draw)?;
            }
        }
        let value = gauge.after_refit(&alone)?;
        if index == 0 && value < 0.7 * wanted {
            // The nonlinear refit of the joints explains the effect, although the linear projection does not.
            return Err(SimulatorError::TooWeak {
                effect: alone.effects[0].kind.name().to_owned(),
                reached: value,
                wanted,
            });
        }
        subject.effects[index].size = alone.effects[0].size;
        reached.push(value);
        wanted = value * draw.between(0.3, 0.7);
    }
    Ok(reached)
}

/// Enlarges the only effect of a subject, never below its present size.
///
/// In half of the cases the target is a gap with noise of 1.3 to 3 times the gap without the effect.
/// Otherwise it is a usual size of the kind.
fn enlarge(
    subject: &mut Subject,
    gauge: &Gauge,
    start: &[f64],
    attempt: usize,
    draw: &mut Draw,
) -> Result<()> {
    let survey = gauge.survey.thinned();
    let fit = Fit::of_chain(&subject.drawn, &survey);
    let before = fit.run(&survey.base, start)?.held_out.hypot(survey.floor());
    let least = subject.effects[0].size;
    let largest = subject.effects[0].kind.largest();
    let usual = draw.log_between(0.4, 1.5).min(largest);
    let (ratio, to_ratio) = (draw.between(1.3, 3.0), draw.chance(0.5));
    let mut gap_ratio = |size: f64| -> Result<f64> {
        subject.effects[0].size = size;
        Ok(fit.run(&survey.of(subject)?, start)?.held_out.hypot(survey.floor()) / before)
    };
    let value = if to_ratio {
        size_for_gap_ratio([least, largest], ratio, 8, gap_ratio)?.1
    } else {
        gap_ratio(usual.max(least))?
    };
    if value < 1.15 && attempt < PATIENCE {
        return Err(SimulatorError::TooWeak {
            effect: subject.effects[0].kind.name().to_owned(),
            reached: value,
            wanted: ratio,
        });
    }
    Ok(())
}
