//! Interval of `closed`: repetitions of the test, simulated with the chosen model, are fitted and compared
//! again.

use num_complex::Complex64;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::diagnose::Diagnosis;
use super::evidence::{Domain, DomainObjective, PartialGap, closed, gap_over, share_closed};
use super::fit::{Fitted, Fitter, coordinates_of, values_of};
use super::hypothesis::Hypothesis;
use super::nominal_refit::transferred;
use super::null_distribution::{noise_at, redrawn, set_up_again, simulated_changes};
use identification::Place;
use identification::objective::{
    Deviation, FrfObjective, FrfRecord, FrfSettings, ModeObjective, ModeSettings,
};
use long_work::Control;
use measurement::{HoldOutSet, MeasurementSet, ModeTable};
use numeric::random::normal;
use numeric::statistics::root_mean_square;
use optimizer::{Polished, least_squares_within};

/// Lines per FRF in a draw, and steps of its fits.
const LINES: usize = 80;
const STEPS: u64 = 10;
/// Simulated repetitions: a further one lies between the least and the largest of 39 with a probability of
/// 38/40 = 0.95.
const DRAWS: usize = 39;

/// Returns a 95 % interval of `closed`: for FRFs it holds what the true machine without the named effects would
/// close, the share of the squared gap of the machine as described that is not there without them.
///
/// The test is repeated on machines of the kind of the chosen fit: tolerances drawn anew, nut and sensors set up
/// again, noise anew. In each, the machine as described without and with the chosen effects is fitted as to the
/// data, and its error is the difference from what the drawn machine without its effects would close. Modes are
/// drawn about the chosen model's predictions with the scatter of its residuals: as a model error that is hardly
/// known stands for tolerances, the interval is that of repetitions. It reaches the figure of the data themselves.
/// `None` where the verdict names nothing, or the gap of a repetition vanishes in its noise.
///
/// # Source  Basic bootstrap interval: Davison and Hinkley, Bootstrap Methods and their Application (1997), section
///   5.2; with the ends of a non-parametric prediction interval of order statistics: Hahn and Meeker, Statistical
///   Intervals (1991), section 5.4.
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
                let error =
                    error_of_drawn_frfs(fitter, held_out, chosen, compared, settings, random, control);
                Some(estimate - error?)
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
    let reached = |(least, largest): (f64, f64), x: &f64| (least.min(*x), largest.max(*x));
    let (least, largest) = drawn.iter().fold((estimate, estimate), reached);
    Some((least, largest.min(estimate.max(1.0))))
}

type Model<'m> = (&'m Hypothesis, &'m Fitted);

/// Changes of the logarithms of measured FRFs.
type Changes = Vec<Vec<Complex64>>;

/// A drawn machine: its test, and its noise-free FRFs with and without the effects of the chosen model.
struct DrawnFrfs {
    noisy: Changes,
    with: Changes,
    without: Changes,
}

impl DrawnFrfs {
    fn of(
        objective: DomainObjective<'_>,
        (machine, fitted): Model<'_>,
        settings: FrfSettings,
        random: &mut Xoshiro256PlusPlus,
    ) -> Option<Self> {
        let with = set_up_again(&objective, fitted, random);
        let parameters = &machine.machine.parameters;
        let mut without = with.clone();
        for (unit, at) in without.iter_mut().zip(objective.free()) {
            if machine.added.contains(at) {
                *unit = parameters[*at].to_unit(parameters[*at].start);
            }
        }
        let simulated = coarse(objective)?;
        // The gap counts all lines alike, and the noise of each as stated: those without information, too.
        let noise = |record: &FrfRecord, line: usize| noise_at(record.stated_noise(), line, settings, random);
        let noisy = simulated_changes(&simulated, &with, noise)?;
        let [with, without] =
            [with, without].map(|place| simulated_changes(&simulated, &place, |_, _| Complex64::ZERO));
        Some(DrawnFrfs { noisy, with: with?, without: without? })
    }
}

/// Computes the error of `closed` of FRFs in a repetition of the test on a machine of the chosen kind: its
/// difference from what the machine without its effects would close.
fn error_of_drawn_frfs(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    chosen: Model<'_>,
    [before, after]: [Model<'_>; 2],
    settings: FrfSettings,
    mut random: Xoshiro256PlusPlus,
    control: &Control,
) -> Option<f64> {
    let (machine, fitted) = redrawn(chosen.0, chosen.1, &mut random);
    let mut draw = |objective| DrawnFrfs::of(objective, (&machine, &fitted), settings, &mut random);
    let here = draw(fitter.objective(&machine).ok()?)?;
    let there = draw(fitter.objective_for_held_out(&machine, held_out).ok()?)?;
    let described = fitter.without_nuisances();
    let gap = |(hypothesis, fitted): Model<'_>, here: &Changes, there: &Changes| -> Option<Vec<PartialGap>> {
        let own = coarse(described.objective(hypothesis).ok()?)?.shifted(here);
        // From its fit to the data, and from the joints of the drawn machine.
        let starts = [fitted.clone(), transferred(hypothesis, chosen)];
        let ends = starts.iter().map(|start| {
            let start = coordinates_of(&described.objective(hypothesis).ok()?, start);
            Some(least_squares_within(&own, &start, &[], (STEPS, 1e-3), control.stop()))
        });
        let ends: Vec<Polished> = ends.collect::<Option<_>>()?;
        let best = ends.into_iter().min_by(|a, b| a.normal.chi_square.total_cmp(&b.normal.chi_square))?;
        let place = Place(best.place);
        let held_out = described.objective_for_held_out(hypothesis, held_out).ok()?;
        let gaps = coarse(held_out)?.shifted(there).gaps(&own.parameters(&place), own.gain(&place));
        Some(gaps.into_iter().map(PartialGap::from).collect())
    };
    let measured = closed(&gap(before, &here.noisy, &there.noisy)?, &gap(after, &here.noisy, &there.noisy)?)?;
    let with = gap_over(&gap(before, &here.with, &there.with)?)?;
    let without = gap_over(&gap(before, &here.without, &there.without)?)?;
    Some(measured - share_closed(with, without, 0.0)?)
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
