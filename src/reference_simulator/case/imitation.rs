//! Whether an effect of the library imitates an outside cause within noise and tolerances.
//!
//! Every listed effect, in this crate's parametrisation, is added to the machine without effects: first a
//! random search of its size and shape alone, then a fit of the best few together with joints and tolerances.

use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::fitted::FittedGauge;
use super::subject::Subject;
use crate::Result;
use crate::draw::Draw;
use crate::effect::{Effect, EffectKind};
use crate::least_squares::{Minimum, minimum};

/// Sizes and shapes drawn of each effect, and how many of the best are moved on.
const DRAWS: (usize, usize) = (80, 3);
/// Random steps of each of these, and the scale of the first and the last: of ln(size) and of shapes.
const STEPS: (usize, [f64; 2]) = (80, [0.3, 0.01]);
/// Effects fitted in full.
const REFINED: usize = 3;
/// Least size drawn.
const LEAST: f64 = 0.02;
/// Whitened residual beyond which the cost of the random search grows with its logarithm: peaks that do not
/// meet yet must not count by their height.
const ROBUST: f64 = 10.0;

/// The effect of the library that comes closest to an outside cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Imitation {
    /// Its id.
    pub effect: String,
    /// Non-centrality that remains with it.
    pub noncentrality: f64,
}

/// Fits every listed effect that `is_possible` to noise-free data of a subject, and returns the closest.
pub fn imitation(
    gauge: &FittedGauge,
    subject: &Subject,
    is_possible: impl Fn(EffectKind) -> bool,
    draw: &Draw,
) -> Result<Option<Imitation>> {
    let data = gauge.data(subject)?;
    let none = gauge.fit(subject)?;
    // With the right effect, joints and tolerances are close to the truth; with a partial one, to the fit
    // without effects.
    let bases = [gauge.family.clone(), gauge.shifted(&gauge.family, &none.point)];
    let cost = |base: &Subject, effect: &Effect| {
        let with = Subject { effects: vec![effect.clone()], ..base.clone() };
        let residual = gauge.residual(&data, &with).unwrap_or_default();
        if residual.is_empty() {
            f64::INFINITY
        } else {
            residual.iter().map(|r| (1.0 + (r / ROBUST).powi(2)).ln()).sum()
        }
    };
    let kinds: Vec<EffectKind> = EffectKind::LISTED.into_iter().filter(|kind| is_possible(*kind)).collect();
    let best_of = |kind: &EffectKind| searched(*kind, &bases, &cost, &mut draw.branch(*kind as u64));
    let mut screened: Vec<(f64, Effect)> = kinds.par_iter().filter_map(best_of).collect();
    screened.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    screened.truncate(REFINED);
    let mut closest: Option<Imitation> = None;
    for (_, effect) in screened {
        let found = refined(gauge, &data, &none, &effect)?;
        if closest.as_ref().is_none_or(|known| found.cost < known.noncentrality) {
            closest = Some(Imitation { effect: effect.kind.name().to_owned(), noncentrality: found.cost });
        }
    }
    Ok(closest)
}

/// Searches the size and shape of an effect of the least cost on either base: draws, then random steps of
/// shrinking scale.
fn searched(
    kind: EffectKind,
    bases: &[Subject],
    cost: &(impl Fn(&Subject, &Effect) -> f64 + Sync),
    draw: &mut Draw,
) -> Option<(f64, Effect)> {
    let has_size = kind != EffectKind::FrfQuantity;
    let mut drawn: Vec<(f64, &Subject, Effect)> = Vec::new();
    for _ in 0..DRAWS.0 {
        let mut effect = Effect::random(kind, &bases[0].drawn, draw);
        effect.size = if has_size { draw.log_between(LEAST, kind.largest()) } else { 1.0 };
        drawn.extend(bases.iter().map(|base| (cost(base, &effect), base, effect.clone())));
    }
    drawn.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    drawn.truncate(DRAWS.1);
    for (least, base, effect) in &mut drawn {
        for step in 0..STEPS.0 {
            let scale = STEPS.1[0] * (STEPS.1[1] / STEPS.1[0]).powf(step as f64 / STEPS.0 as f64);
            let mut moved = effect.clone();
            if has_size {
                moved.size = (moved.size * (scale * draw.normal()).exp()).min(kind.largest());
            }
            // One to all shape numbers at a time.
            let share = draw.unit();
            for shape in &mut moved.shape {
                *shape = if draw.chance(share) { folded(*shape + scale * draw.normal()) } else { *shape };
            }
            let value = cost(base, &moved);
            if value < *least {
                (*least, *effect) = (value, moved);
            }
        }
    }
    drawn.into_iter().min_by(|(a, ..), (b, ..)| a.total_cmp(b)).map(|(least, _, effect)| (least, effect))
}

/// Fits joints, tolerances, size and shape together, from the joints of the fit without effects and from the
/// true ones.
fn refined(gauge: &FittedGauge, data: &[Complex64], none: &Minimum, effect: &Effect) -> Result<Minimum> {
    let count = gauge.leeway.len();
    let has_size = effect.kind != EffectKind::FrfQuantity;
    let at = |point: &[f64]| -> Subject {
        let mut changed = effect.clone();
        if has_size {
            changed.size = (effect.size * point[count].exp()).min(effect.kind.largest());
        }
        for (shape, (first, by)) in changed.shape.iter_mut().zip(effect.shape.iter().zip(&point[count + 1..]))
        {
            *shape = folded(first + by);
        }
        Subject { effects: vec![changed], ..gauge.shifted(&gauge.family, &point[..count]) }
    };
    let residuals = |point: &[f64]| gauge.residual(data, &at(point));
    let all = count + 1 + effect.shape.len();
    let penalties: Vec<f64> = (0..all).map(|index| if index < count { 1.0 } else { 0.0 }).collect();
    let mut start = none.point.clone();
    start.resize(all, 0.0);
    let from_none = minimum(&residuals, &penalties, start)?;
    let from_truth = minimum(&residuals, &penalties, vec![0.0; all])?;
    Ok(if from_truth.cost < from_none.cost { from_truth } else { from_none })
}

/// Folds a number into [0, 1).
fn folded(value: f64) -> f64 {
    let along = value.rem_euclid(2.0);
    (if along < 1.0 { along } else { 2.0 - along }).min(1.0 - 1e-9)
}
