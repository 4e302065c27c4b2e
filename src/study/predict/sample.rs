//! Intervals of predictions from machines drawn from the posterior.

use num_complex::Complex64;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::evaluate::Evaluation;
use super::request::{MOST_LINES, PredictionRequest};
use crate::{StudyError, StudyResult};
use identification::{PosteriorDraw, PosteriorSample};
use machine::{Operating, Station, StationPlace};
use numeric::random::normal;
use report::prediction::{NaturalMode, PredictedFrf, PredictedMode, PredictedPosition};
use report::vocabulary::Role;

/// A place to predict.
pub(crate) struct PredictedPlace {
    pub(crate) name: String,
    pub(crate) nut_m: Option<f64>,
    /// Whether it is a fitted position of the measurement set; `None` for a place that the set does not name.
    pub(crate) fit: Option<bool>,
}

/// Number of lines of an FRF that are spread over the band, evenly in ln f.
const LINES: usize = 400;
/// Lines about each natural frequency: their number on each side, and the largest distance over the frequency
/// (1).
const PEAK_LINES: (i32, f64) = (30, 0.15);

/// The numbers of one machine at one place.
struct Predicted {
    /// The modes that continue those of the best machine, in their order; `None` for one above the searched
    /// frequencies.
    modes: Vec<Option<NaturalMode>>,
    static_stiffness: Option<f64>,
    frf: Vec<Complex64>,
}

/// Predicts one place from all drawn machines. `nut_sd_m` is the standard deviation of a nut position that
/// was not fitted, drawn with a seed.
pub(super) fn predict(
    evaluation: &Evaluation<'_>,
    sample: &PosteriorSample,
    place: &PredictedPlace,
    (nut_sd_m, seed): (f64, u64),
    request: &PredictionRequest,
) -> StudyResult<PredictedPosition> {
    let operating = |draw: &PosteriorDraw, elsewhere_m: f64| {
        // A fitted position keeps the nut position of the fit; at any other the nut is placed anew.
        let fitted = draw
            .nut_shifts_m
            .iter()
            .find(|(stated_m, _)| place.fit == Some(true) && Some(*stated_m) == place.nut_m);
        let shift_m = fitted.map_or(elsewhere_m, |(_, shift_m)| *shift_m);
        Operating::at(place.nut_m.map(|nut_m| nut_m + shift_m))
    };
    let at_best = operating(&sample.best, 0.0);
    check_supports(sample, place, &at_best)?;
    let mut space = evaluation.space();
    let best_modes = evaluation.modes(&sample.best.values, &at_best, &mut space);
    let lines_hz = lines(evaluation, &best_modes, request)?;
    let frf = evaluation.frf(&sample.best.values, &at_best, &lines_hz, &mut space);
    let static_stiffness = evaluation.static_stiffness(&sample.best.values, &at_best);
    let modes: Vec<NaturalMode> =
        best_modes.into_iter().filter(|m| m.is_below(evaluation.band_hz.1)).collect();
    let generator = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
    let drawn: Vec<Vec<Predicted>> = sample
        .draws
        .iter()
        .map(|draws| {
            let shifts_m: Vec<f64> = draws.iter().map(|_| nut_sd_m * normal(generator)).collect();
            draws
                .par_iter()
                .zip(shifts_m)
                .map_init(
                    || evaluation.space(),
                    |space, (draw, shift_m)| {
                        let operating = operating(draw, shift_m);
                        Predicted {
                            modes: continued(
                                &modes,
                                evaluation.modes(&draw.values, &operating, space),
                                evaluation.highest_hz(),
                            ),
                            static_stiffness: evaluation.static_stiffness(&draw.values, &operating),
                            frf: evaluation.frf(&draw.values, &operating, &lines_hz, space),
                        }
                    },
                )
                .collect()
        })
        .collect();
    let interval = |value: f64, of: &dyn Fn(&Predicted) -> Option<f64>| hull(value, &drawn, of);
    let mode = |(at, mode): (usize, &NaturalMode)| PredictedMode {
        frequency95: mode
            .frequency_hz
            .map(|hz| hull_of_some(hz, &drawn, &|p| p.modes[at].as_ref()?.frequency_hz)),
        // A mode above the searched frequencies lies at least there.
        natural95: interval(mode.natural_hz, &|p| {
            Some(p.modes[at].as_ref().map_or(evaluation.highest_hz(), |m| m.natural_hz))
        })
        .unwrap_or([mode.natural_hz; 2]),
        damping95: mode.damping_ratio.and_then(|z| interval(z, &|p| p.modes[at].as_ref()?.damping_ratio)),
        amplitude95: mode.amplitude.and_then(|a| interval(a, &|p| p.modes[at].as_ref()?.amplitude)),
        mode: mode.clone(),
    };
    let predicted_frf = (!lines_hz.is_empty()).then(|| PredictedFrf {
        value: frf.iter().map(|h| [h.re, h.im]).collect(),
        magnitude95: frf
            .iter()
            .enumerate()
            .map(|(at, h)| interval(h.norm(), &|p| Some(p.frf[at].norm())).unwrap_or([h.norm(); 2]))
            .collect(),
        frequency_hz: lines_hz.clone(),
    });
    Ok(PredictedPosition {
        nut_m: place.nut_m,
        role: place.fit.map(Role::of),
        modes: modes.iter().enumerate().map(mode).collect(),
        static_stiffness,
        static_stiffness95: static_stiffness.and_then(|k| interval(k, &|p| p.static_stiffness)),
        frf: predicted_frf,
    })
}

/// Returns the modes of a drawn machine that continue those of the best machine: in the same order, with the
/// least sum of |ln(frequency ratio)|.
///
/// Machines that the data leave possible may differ in a mode that the data do not show; counted by order, it
/// would shift all modes above it. A mode that has no counterpart up to `beyond_hz` lies above.
fn continued(best: &[NaturalMode], drawn: Vec<NaturalMode>, beyond_hz: f64) -> Vec<Option<NaturalMode>> {
    let (rows, columns) = (best.len(), drawn.len() + best.len());
    let hz = |column: usize| drawn.get(column).map_or(beyond_hz, |mode| mode.natural_hz);
    let with = |row: usize, column: usize| (best[row].natural_hz / hz(column)).ln().abs();
    // Least sum for the first rows within the first columns.
    let mut least = vec![vec![f64::INFINITY; columns + 1]; rows + 1];
    least[0].fill(0.0);
    for row in 1..=rows {
        for column in row..=columns {
            least[row][column] =
                least[row][column - 1].min(least[row - 1][column - 1] + with(row - 1, column - 1));
        }
    }
    let mut found = vec![None; rows];
    let (mut row, mut column) = (rows, columns);
    while row > 0 {
        if column > row && least[row][column] == least[row][column - 1] {
            column -= 1;
            continue;
        }
        found[row - 1] = drawn.get(column - 1).cloned();
        (row, column) = (row - 1, column - 1);
    }
    found
}

/// Checks that the supports of the nut lie between the neighbouring stations of the screw, for every drawn
/// machine.
fn check_supports(sample: &PosteriorSample, place: &PredictedPlace, at: &Operating) -> StudyResult<()> {
    let is_near = |place: &StationPlace| matches!(place, StationPlace::Nut | StationPlace::NearNut(_));
    for shaft in &sample.machine.shafts {
        let Some(first) = shaft.stations.iter().position(|s| is_near(&s.place)) else { continue };
        let near = shaft.stations.iter().skip(first).take_while(|s| is_near(&s.place)).count();
        for draw in std::iter::once(&sample.best).chain(sample.draws.iter().flatten()) {
            let place_m = |station: &Station| shaft.place_m(station.place, &draw.values, at);
            let low_m =
                first.checked_sub(1).and_then(|at| place_m(&shaft.stations[at])).unwrap_or(f64::NEG_INFINITY);
            let high_m = shaft.stations.get(first + near).and_then(place_m).unwrap_or(f64::INFINITY);
            let inside = shaft.stations[first..first + near]
                .iter()
                .filter_map(place_m)
                .all(|x| x > low_m && x < high_m);
            if !inside {
                let fault = "is nearer to an end of the screw than the length of the nut allows; write a position farther inside";
                return Err(StudyError::setting("nut_m", &place.name, fault));
            }
        }
    }
    Ok(())
}

/// Returns the lines of the FRFs (Hz); none where no FRF is requested.
fn lines(
    evaluation: &Evaluation<'_>,
    modes: &[NaturalMode],
    request: &PredictionRequest,
) -> StudyResult<Vec<f64>> {
    let (from, to) = evaluation.band_hz;
    let own = match (&request.lines_hz, request.frf) {
        (Some(lines_hz), _) => lines_hz.clone(),
        (None, false) => Vec::new(),
        (None, true) => {
            let mut lines: Vec<f64> =
                (0..LINES).map(|at| from * (to / from).powf(at as f64 / (LINES - 1) as f64)).collect();
            let (count, reach) = PEAK_LINES;
            for mode in modes {
                // Dense at the peak: distances grow with the cube of the number.
                let share = |at: i32| reach * (f64::from(at) / f64::from(count)).powi(3);
                let hz = mode.frequency_hz.unwrap_or(mode.natural_hz);
                lines.extend((-count..=count).map(|at| hz * (1.0 + share(at))));
            }
            lines.retain(|hz| (from..=to).contains(hz));
            lines.sort_by(f64::total_cmp);
            lines.dedup();
            lines
        }
    };
    if let Some(hz) = own.iter().find(|hz| !(**hz > 0.0 && hz.is_finite())) {
        return Err(StudyError::setting("lines_hz", hz, "write frequencies above 0 Hz"));
    }
    let all = own.len() as f64 * request.draws as f64;
    if own.len() > MOST_LINES.0 || all > MOST_LINES.1 {
        return Err(StudyError::setting(
            "lines_hz",
            own.len(),
            "are too many lines; write fewer, or draw fewer machines",
        ));
    }
    Ok(own)
}

/// Returns the hull of a value and of its 95 % intervals about each minimum; `None` where a machine has no
/// such number.
fn hull(value: f64, drawn: &[Vec<Predicted>], of: &dyn Fn(&Predicted) -> Option<f64>) -> Option<[f64; 2]> {
    drawn.iter().flatten().all(|p| of(p).is_some()).then(|| hull_of_some(value, drawn, of))
}

/// Returns the hull as [`hull`], from the machines that have such a number.
fn hull_of_some(value: f64, drawn: &[Vec<Predicted>], of: &dyn Fn(&Predicted) -> Option<f64>) -> [f64; 2] {
    let mut ends = [value; 2];
    for predicted in drawn {
        let mut numbers: Vec<f64> = predicted.iter().filter_map(of).collect();
        if numbers.is_empty() {
            continue;
        }
        numbers.sort_by(f64::total_cmp);
        ends = [ends[0].min(order_statistic(&numbers, 0.025)), ends[1].max(order_statistic(&numbers, 0.975))];
    }
    ends
}

/// Returns the number below which a further draw lies with a probability: of n sorted numbers the one at
/// p·(n + 1), interpolated.
///
/// # Source  Davison and Hinkley, Bootstrap Methods and their Application, 1997, sec. 2.2.1.
fn order_statistic(sorted: &[f64], probability: f64) -> f64 {
    let at = (probability * (sorted.len() as f64 + 1.0) - 1.0).clamp(0.0, (sorted.len() - 1) as f64);
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    sorted[low] + (at - at.floor()) * (sorted[high] - sorted[low])
}

#[cfg(test)]
mod tests {
    use super::{NaturalMode, continued, order_statistic};

    #[test]
    fn limit_a_further_mode_shifts_no_other() {
        let modes = |all: &[f64]| -> Vec<NaturalMode> {
            let mode = |(at, hz): (usize, &f64)| NaturalMode {
                order: at + 1,
                frequency_hz: Some(*hz),
                natural_hz: *hz,
                damping_ratio: None,
                amplitude: None,
            };
            all.iter().enumerate().map(mode).collect()
        };
        let best = modes(&[24.0, 116.0, 530.0]);
        let of = |drawn: &[f64]| -> Vec<Option<f64>> {
            continued(&best, modes(drawn), 800.0).into_iter().map(|m| m.map(|m| m.natural_hz)).collect()
        };
        assert_eq!(of(&[25.0, 110.0, 239.0, 520.0]), [Some(25.0), Some(110.0), Some(520.0)]);
        assert_eq!(of(&[25.0, 110.0]), [Some(25.0), Some(110.0), None]);
        assert_eq!(of(&[25.0, 110.0, 500.0, 540.0]), [Some(25.0), Some(110.0), Some(540.0)]);
        assert_eq!(of(&[]), [None, None, None]);
    }

    #[test]
    fn limit_ends_of_199_draws_are_the_5th_and_the_195th() {
        let sorted: Vec<f64> = (1..=199).map(f64::from).collect();
        assert!(
            (order_statistic(&sorted, 0.025) - 5.0).abs() < 1e-9
                && (order_statistic(&sorted, 0.975) - 195.0).abs() < 1e-9
        );
        assert_eq!(order_statistic(&[3.0], 0.025), 3.0);
    }
}
