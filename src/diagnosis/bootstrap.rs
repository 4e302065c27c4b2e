//! Confidence interval of `closed`: data simulated with the chosen model are fitted and compared again.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::decision::Diagnosis;
use super::evidence::{Domain, DomainObjective, PartialGap, closed};
use super::fit::{Fitted, Fitter, coordinates_of, values_of};
use super::hypothesis::Hypothesis;
use super::null_distribution::redraw_machine;
use identification::Place;
use identification::objective::{Deviation, FrfGap, FrfObjective, FrfSettings, ModeObjective, ModeSettings};
use measurement::{HoldOutSet, MeasurementSet, ModeTable};
use numeric::random::normal;
use numeric::statistics::root_mean_square;
use optimizer::{Control, least_squares_within};

/// Lines per FRF in a draw, and steps of its fits.
const LINES: usize = 80;
const STEPS: u64 = 10;
/// Draws of the bootstrap of `closed`.
const DRAWS: usize = 24;

/// Returns the 95 % interval of `closed`. For FRFs, machines with random discrepancies are drawn around the chosen fit; for modes, its predictions
/// are drawn with the scatter of its residuals. The machine as described, without and with the chosen effects, is fitted to each draw and predicts
/// the held-out positions. For FRFs the interval includes the figure with nuisance parameters fitted. `None` where the verdict names nothing, or too
/// few draws give a figure.
pub fn closed_interval(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    found: &Diagnosis,
    seed: u64,
    control: &Control,
) -> Option<(f64, f64)> {
    let estimate = closed(&found.held_out, &found.chosen_held_out).filter(|_| found.verdict.kind.explains())?;
    let chosen = (&found.chosen.0, &found.chosen.1);
    let compared = [&found.described, &found.explained].map(|(hypothesis, fitted)| (hypothesis, fitted));
    control.begin("6/6 interval of the closed share");
    let step = control.steps("draws", DRAWS);
    let one = |draw: usize| -> Option<f64> {
        let random = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0xD1B5_4A33).wrapping_add(draw as u64));
        match fitter.domain {
            Domain::Frf(settings) => closed_of_drawn_frfs(fitter, held_out, chosen, compared, settings, random, control),
            Domain::Modes(settings) => closed_of_drawn_modes(fitter, held_out, compared, settings, random, control),
        }
    };
    let key = fitter.cache_key("closed", chosen.0, &[found.nominal.1.clone(), chosen.1.clone()]);
    let drawn: Vec<f64> = (0..DRAWS)
        .into_par_iter()
        .filter(|_| !control.stopped())
        .filter_map(|draw| {
            let closed = control.cached(&format!("{key} {draw} {seed}"), || one(draw));
            step();
            closed
        })
        .collect();
    if drawn.len() < DRAWS / 2 || drawn.len() < 8 {
        return None;
    }
    let count = drawn.len() as f64;
    let mean = drawn.iter().sum::<f64>() / count;
    let spread = (drawn.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
    // Spread of the draws about the estimate. The interval includes their mean and the figure with nuisance parameters: whether these belong to the
    // gap is a matter of definition.
    let half = 1.96 * spread;
    let with_nuisances = found.gaps_with_nuisances.as_ref().and_then(|[before, after]| closed(before, after)).unwrap_or(estimate);
    Some((estimate.min(mean).min(with_nuisances) - half, estimate.max(mean).max(with_nuisances) + half))
}

type Model<'m> = (&'m Hypothesis, &'m Fitted);

/// Computes `closed` of FRFs for one machine drawn around the chosen model.
fn closed_of_drawn_frfs(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    chosen: Model<'_>,
    [before, after]: [Model<'_>; 2],
    settings: FrfSettings,
    random: Xoshiro256PlusPlus,
    control: &Control,
) -> Option<f64> {
    // The same seed draws the same machine for both.
    let (fit_change, _) = redraw_machine(|h| fitter.objective(h).ok(), chosen.0, chosen.1, settings, LINES, random.clone())?;
    let held_out_change =
        redraw_machine(|h| fitter.objective_for_held_out(h, held_out).ok(), chosen.0, chosen.1, settings, LINES, random)?.0;
    let described = fitter.without_nuisances();
    let gap = |(hypothesis, fitted): Model<'_>| -> Option<Vec<PartialGap>> {
        let own = coarse(described.objective(hypothesis).ok()?)?.shifted(&fit_change);
        let start = coordinates_of(&described.objective(hypothesis).ok()?, fitted);
        let place = Place(least_squares_within(&own, &start, &[], (STEPS, 1e-3), control.stop()).place);
        let there = coarse(described.objective_for_held_out(hypothesis, held_out).ok()?)?.shifted(&held_out_change);
        let part = |g: FrfGap| PartialGap { position: None, frf: Some(g.frf), gap: g.gap, floor: g.noise_floor, count: g.lines };
        Some(there.gaps(&own.parameters(&place), own.gain(&place)).into_iter().map(part).collect())
    };
    closed(&gap(before)?, &gap(after)?)
}

/// Computes `closed` of modes drawn around the chosen model's predictions, with the scatter of its residuals and the rounding of the measured modes.
fn closed_of_drawn_modes(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    [before, after]: [Model<'_>; 2],
    settings: ModeSettings,
    mut random: Xoshiro256PlusPlus,
    control: &Control,
) -> Option<f64> {
    let set = draw_modes(fitter, held_out, after, settings, &mut random)?;
    let there = held_out.in_version(&set);
    let again = fitter.on(fitter.fit.in_version(&set));
    let gap = |(hypothesis, fitted): Model<'_>| -> Option<Vec<PartialGap>> {
        let found = again.descend(&again.objective(hypothesis).ok()?, fitted, STEPS, control);
        again.gaps(hypothesis, &found, &there).ok()
    };
    closed(&gap(before)?, &gap(after)?)
}

/// Returns the set with modes drawn around a model's predictions.
fn draw_modes(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    (hypothesis, fitted): Model<'_>,
    settings: ModeSettings,
    random: &mut Xoshiro256PlusPlus,
) -> Option<MeasurementSet> {
    let mut set = fitter.fit.set().clone();
    let own = fitter.objective(hypothesis).ok()?;
    let (gain, values) = (own.gain(&coordinates_of(&own, fitted)), values_of(hypothesis, fitted));
    let all = fitter.fit.both(held_out);
    let predictions = ModeObjective::held_out(&hypothesis.machine, &all, settings, None).ok()?.predict(&values);
    // Root mean square of the fitted residuals, of frequencies and of amplitudes.
    let fitted_here = || predictions.iter().filter(|p| fitter.fit.positions().contains(&p.position)).flat_map(|p| &p.deviations);
    let pairs = || fitted_here().filter_map(Deviation::pair);
    let frequency_sd = root_mean_square(pairs().filter_map(|(o, p)| Some(p.frequency_hz / o.frequency_hz? - 1.0)))?;
    let amplitude_sd = root_mean_square(pairs().filter_map(|(o, p)| Some((gain * p.amplitude / o.amplitude?).ln()))).unwrap_or(0.0);
    let ModeTable { positions, resolution_hz, .. } = set.modes.as_mut()?;
    for prediction in &predictions {
        for deviation in &prediction.deviations {
            let Some((observed, peak)) = deviation.pair() else { continue };
            let mode = positions[prediction.position].iter_mut().find(|m| m.order == observed.order)?;
            let drawn_hz = peak.frequency_hz * (1.0 + frequency_sd * normal(random));
            mode.frequency_hz = Some(resolution_hz.filter(|step| *step > 0.0).map_or(drawn_hz, |step| (drawn_hz / step).round() * step));
            let drawn = gain * peak.amplitude * (amplitude_sd * normal(random)).exp();
            mode.amplitude = mode.amplitude.map(|_| drawn);
        }
    }
    Some(set)
}

fn coarse(objective: DomainObjective<'_>) -> Option<FrfObjective<'_>> {
    match objective {
        DomainObjective::Frf(objective) => Some(objective.thinned(LINES)),
        DomainObjective::Modes(_) => None,
    }
}
