//! Interval of `closed`: repetitions of the test, simulated with the chosen model, are fitted and compared
//! again.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::diagnose::Diagnosis;
use super::evidence::{Domain, DomainObjective, PartialGap, closed};
use super::fit::{Fitted, Fitter, coordinates_of, values_of};
use super::hypothesis::Hypothesis;
use super::null_distribution::redraw_records;
use identification::Place;
use identification::objective::{
    Deviation, FrfObjective, FrfRecord, FrfSettings, ModeObjective, ModeSettings,
};
use long_work::Control;
use measurement::{HoldOutSet, MeasurementSet, ModeTable};
use numeric::random::normal;
use numeric::statistics::root_mean_square;
use optimizer::least_squares_within;

/// Lines per FRF in a draw, and steps of its fits.
const LINES: usize = 80;
const STEPS: u64 = 10;
/// Simulated repetitions: a further one lies between the least and the largest of 39 with a probability of
/// 38/40 = 0.95.
const DRAWS: usize = 39;

/// Returns the interval that holds `closed` in 95 of 100 repetitions of the test on this machine: nut and
/// sensors set up again within their tolerances, noise anew. For FRFs, the machine is the chosen fit; for
/// modes, its predictions are drawn with the scatter of its residuals. The machine as described, without and
/// with the chosen effects, is fitted to each repetition and predicts the held-out positions. The interval
/// reaches the figure of the data themselves, which what the chosen model still leaves can put outside the
/// repetitions. `None` where the verdict names nothing, or the gap of a repetition vanishes in its noise.
///
/// # Source  Non-parametric prediction interval of order statistics: Hahn and Meeker, Statistical Intervals
///   (1991), section 5.4.
pub fn closed_interval(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    found: &Diagnosis,
    seed: u64,
    control: &Control,
) -> Option<(f64, f64)> {
    let estimate = closed(&found.held_out, &found.chosen_held_out)
        .filter(|_| found.judgement.verdict.kind.explains())?;
    let chosen = (&found.chosen.0, &found.chosen.1);
    let compared = [&found.described, &found.explained].map(|(hypothesis, fitted)| (hypothesis, fitted));
    control.begin("6/6 interval of the closed share");
    let step = control.steps("draws", DRAWS);
    let one = |draw: usize| -> Option<f64> {
        let random =
            Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0xD1B5_4A33).wrapping_add(draw as u64));
        match fitter.domain {
            Domain::Frf(settings) => {
                closed_of_drawn_frfs(fitter, held_out, chosen, compared, settings, random, control)
            }
            Domain::Modes(settings) => {
                closed_of_drawn_modes(fitter, held_out, compared, settings, random, control)
            }
        }
    };
    let key = fitter.cache_key("closed", chosen.0, &[found.nominal.1.clone(), chosen.1.clone()]);
    let drawn = (0..DRAWS).into_par_iter().map(|draw| {
        let closed =
            (!control.stopped()).then(|| control.cached(&format!("{key} {draw} {seed}"), || one(draw)))?;
        step();
        closed
    });
    let drawn: Vec<f64> = drawn.collect::<Option<_>>()?;
    Some(drawn.iter().fold((estimate, estimate), |(least, largest), x| (least.min(*x), largest.max(*x))))
}

type Model<'m> = (&'m Hypothesis, &'m Fitted);

/// Computes `closed` of FRFs in one repetition of the test on the chosen machine.
fn closed_of_drawn_frfs(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    chosen: Model<'_>,
    [before, after]: [Model<'_>; 2],
    settings: FrfSettings,
    mut random: Xoshiro256PlusPlus,
    control: &Control,
) -> Option<f64> {
    // The gap counts all lines alike, and the noise of each as stated: those without information, too.
    let lines = (LINES, FrfRecord::stated_noise);
    let mut redraw = |objective: DomainObjective<'_>| {
        Some(redraw_records(objective, chosen.1, settings, lines, &mut random)?.0)
    };
    let fit_change = redraw(fitter.objective(chosen.0).ok()?)?;
    let held_out_change = redraw(fitter.objective_for_held_out(chosen.0, held_out).ok()?)?;
    let described = fitter.without_nuisances();
    let gap = |(hypothesis, fitted): Model<'_>| -> Option<Vec<PartialGap>> {
        let own = coarse(described.objective(hypothesis).ok()?)?.shifted(&fit_change);
        let start = coordinates_of(&described.objective(hypothesis).ok()?, fitted);
        let place = Place(least_squares_within(&own, &start, &[], (STEPS, 1e-3), control.stop()).place);
        let there =
            coarse(described.objective_for_held_out(hypothesis, held_out).ok()?)?.shifted(&held_out_change);
        Some(
            there.gaps(&own.parameters(&place), own.gain(&place)).into_iter().map(PartialGap::from).collect(),
        )
    };
    closed(&gap(before)?, &gap(after)?)
}

/// Computes `closed` of modes drawn around the chosen model's predictions, with the scatter of its residuals
/// and the rounding of the measured modes.
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
    let predictions =
        ModeObjective::held_out(&hypothesis.machine, &all, settings, None).ok()?.predict(&values);
    // Root mean square of the fitted residuals, of frequencies and of amplitudes.
    let fitted_here = || {
        predictions
            .iter()
            .filter(|p| fitter.fit.positions().contains(&p.position))
            .flat_map(|p| &p.deviations)
    };
    let pairs = || fitted_here().filter_map(Deviation::pair);
    let frequency_sd =
        root_mean_square(pairs().filter_map(|(o, p)| Some(p.frequency_hz / o.frequency_hz? - 1.0)))?;
    let amplitude_sd =
        root_mean_square(pairs().filter_map(|(o, p)| Some((gain * p.amplitude / o.amplitude?).ln())))
            .unwrap_or(0.0);
    let ModeTable { positions, resolution_hz, .. } = set.modes.as_mut()?;
    for prediction in &predictions {
        for deviation in &prediction.deviations {
            let Some((observed, peak)) = deviation.pair() else { continue };
            let mode = positions[prediction.position].iter_mut().find(|m| m.order == observed.order)?;
            let drawn_hz = peak.frequency_hz * (1.0 + frequency_sd * normal(random));
            mode.frequency_hz = Some(
                resolution_hz
                    .filter(|step| *step > 0.0)
                    .map_or(drawn_hz, |step| (drawn_hz / step).round() * step),
            );
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
