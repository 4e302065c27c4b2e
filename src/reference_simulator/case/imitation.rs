//! Whether an effect of the library imitates an outside cause within noise and tolerances.
//!
//! Every listed effect, in this crate's parametrisation, is added to the fit of the machine without effects: first many drawn sizes and shapes with
//! joints and tolerances in linear terms, then the best few in full.

use nalgebra::DVector;
use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::fitted::FittedGauge;
use super::subject::Subject;
use crate::SimulatorError;
use crate::draw::Draw;
use crate::effect::{Effect, EffectKind};
use crate::least_squares::{Minimum, minimum};
use crate::projection::Projection;

/// Sizes and shapes drawn of each effect.
const DRAWS: usize = 40;
/// Effects fitted in full.
const REFINED: usize = 3;
/// Least size drawn.
const LEAST: f64 = 0.02;

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
) -> Result<Option<Imitation>, SimulatorError> {
    let data = gauge.data(subject)?;
    let none = gauge.fit(subject)?;
    let base = gauge.shifted(&gauge.family, &none.point);
    let columns: Vec<Vec<f64>> = none.slopes.column_iter().map(|column| column.iter().copied().collect()).collect();
    let explained = Projection::new(&columns)?;
    let kinds: Vec<EffectKind> = EffectKind::LISTED.into_iter().filter(|kind| is_possible(*kind)).collect();
    let best_of = |kind: &EffectKind| {
        let mut own = draw.branch(*kind as u64);
        let tried = (0..DRAWS).filter_map(|_| {
            let mut effect = Effect::random(*kind, &base.drawn, &mut own);
            effect.size = if *kind == EffectKind::FrfQuantity { 1.0 } else { own.log_between(LEAST, kind.largest()) };
            let with = Subject { effects: vec![effect.clone()], ..base.clone() };
            let residual = DVector::from_vec(gauge.residual(&data, &with).ok()?);
            // Joints and tolerances follow the change in linear terms, from the minimum without effects.
            Some((residual.dot(&explained.residual(&residual)), effect))
        });
        tried.min_by(|(a, _), (b, _)| a.total_cmp(b))
    };
    let mut screened: Vec<(f64, Effect)> = kinds.par_iter().filter_map(best_of).collect();
    screened.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    screened.truncate(REFINED);
    let mut closest: Option<Imitation> = None;
    for (_, effect) in screened {
        let found = refined(gauge, &data, &none, &effect)?;
        if closest.as_ref().is_none_or(|known| found.cost < known.noncentrality) {
            closest = Some(Imitation { effect: effect.kind.id().to_owned(), noncentrality: found.cost });
        }
    }
    Ok(closest)
}

/// Fits joints, tolerances, size and shape together, from the joints of the fit without effects and from the true ones.
fn refined(gauge: &FittedGauge, data: &[Complex64], none: &Minimum, effect: &Effect) -> Result<Minimum, SimulatorError> {
    let count = gauge.leeway.len();
    let has_size = effect.kind != EffectKind::FrfQuantity;
    let at = |point: &[f64]| -> Subject {
        let mut changed = effect.clone();
        if has_size {
            changed.size = (effect.size * point[count].exp()).min(effect.kind.largest());
        }
        for (shape, (first, by)) in changed.shape.iter_mut().zip(effect.shape.iter().zip(&point[count + 1..])) {
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
