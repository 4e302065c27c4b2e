//! Checks of records by themselves, without a model: signal, copies, resonances, and differences between
//! positions.

use std::collections::BTreeSet;

use num_complex::Complex64;

use super::chain_of_records::channel;
use super::data_fault::{Fault, pairs};
use super::evidence::Domain;
use super::fit::Fitter;
use super::policy::{HALF_POWER, NO_NOISE, UNRELATED_PHASES};
use measurement::{Frf, FrfLine, HoldOutSet, MeasurementSet};
use numeric::statistics::{median, root_mean_square};
use numeric::unit::omega_rad_s;

/// Least number of lines at which a record is tested.
const LEAST_LINES: usize = 20;
/// Relative difference of values that are equal but for the rounding of a file (1).
const ROUNDING: f64 = 1e-6;
/// Returns a fault that the records show by themselves: no signal, a copy of another record, or no resonance.
pub(super) fn fault_of_records(fitter: &Fitter<'_>, held_out: &HoldOutSet<'_>) -> Option<Fault> {
    let Domain::Frf(_) = fitter.domain else { return None };
    let set = fitter.fit.set();
    let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
    let noise: Vec<usize> = all.iter().copied().filter(|frf| is_noise(&set.frfs[*frf])).collect();
    if !noise.is_empty() {
        return Some(if noise.len() == all.len() { Fault::NoSignal } else { Fault::Noise(noise[0]) });
    }
    let equal = |(a, b): &(usize, usize)| {
        let line = |(a, b): (&FrfLine, &FrfLine)| {
            a.frequency_hz == b.frequency_hz && (a.value - b.value).norm() <= ROUNDING * a.value.norm()
        };
        let (a, b) = (&set.frfs[*a].lines, &set.frfs[*b].lines);
        a.len() == b.len() && a.iter().zip(b).all(line)
    };
    let copied = pairs(set, &all, &all).find(equal).map(|(a, b)| Fault::Copied(a.min(b), a.max(b)));
    let is_without_resonance = !all.is_empty() && all.iter().all(|frf| follows_a_power(&set.frfs[*frf]));
    copied.or(is_without_resonance.then_some(Fault::NoResonance))
}

/// Whether a record holds no signal: the steps of its phase from line to line are uniform over the circle.
/// Those of a structure are mostly small.
fn is_noise(frf: &Frf) -> bool {
    let steps = frf
        .lines
        .windows(2)
        .map(|pair| pair[1].value * pair[0].value.conj())
        .filter(|step| step.norm() > 0.0);
    let (count, sum) =
        steps.fold((0, Complex64::ZERO), |(count, sum), step| (count + 1, sum + step / step.norm()));
    count >= LEAST_LINES
        && sum.norm_sqr() / f64::from(u32::try_from(count).unwrap_or(u32::MAX)) < UNRELATED_PHASES
}

/// Whether a record follows a power of the frequency, possibly delayed, but for noise, as those of a mass,
/// spring or damper do: ln|H| is linear in ln ω, and the phase in ω. Few lines of resonances may look like
/// noise, but are farther from it than half of the power.
fn follows_a_power(frf: &Frf) -> bool {
    if frf.lines.len() < LEAST_LINES {
        return false;
    }
    let omegas: Vec<f64> = frf.lines.iter().map(|line| omega_rad_s(line.frequency_hz)).collect();
    // The factors iω of the quantity change ln|H| by a line, too, and the phase by a constant.
    let (magnitudes, phases): (Vec<f64>, Vec<f64>) =
        frf.logarithms().iter().map(|log| (log.re, log.im)).unzip();
    let log_omegas: Vec<f64> = omegas.iter().map(|omega| omega.ln()).collect();
    let (re, im) = (beyond_a_line(&log_omegas, &magnitudes), beyond_a_line(&omegas, &phases));
    let residuals: Vec<Complex64> = re.zip(im).map(|(re, im)| Complex64::new(re, im)).collect();
    is_noise_about_zero(&residuals)
        && root_mean_square(residuals.iter().map(|r| r.norm())).is_some_and(|rms| rms < HALF_POWER)
}

/// Computes the residuals of the line through points that fits best.
fn beyond_a_line<'v>(x: &'v [f64], y: &'v [f64]) -> impl Iterator<Item = f64> + 'v {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (x_mean, y_mean) = (mean(x), mean(y));
    let (xy, xx) = x
        .iter()
        .zip(y)
        .fold((0.0, 0.0), |(xy, xx), (x, y)| (xy + (x - x_mean) * (y - y_mean), xx + (x - x_mean).powi(2)));
    x.iter().zip(y).map(move |(x, y)| y - y_mean - xy / xx * (x - x_mean))
}

/// Returns for each record the factor by which it exceeds the median of its channel, where the records of
/// each channel differ by noise and such factors alone, and those of one are from at least three positions;
/// `None` where they differ by more. Records of other lines are not compared.
pub(super) fn factors_of_alike(set: &MeasurementSet, frfs: &[usize]) -> Option<Vec<(usize, f64)>> {
    let of_channel =
        |frf: usize| frfs.iter().copied().filter(move |other| channel(set, *other) == channel(set, frf));
    let positions = |frf: usize| {
        of_channel(frf).filter_map(|other| set.frfs[other].position).collect::<BTreeSet<usize>>().len()
    };
    if frfs.iter().all(|frf| positions(*frf) < 3) {
        return None;
    }
    let log_factor = |frf: &usize| {
        let (own, first) = (&set.frfs[*frf].lines, &set.frfs[of_channel(*frf).next()?].lines);
        let is_one_grid =
            own.len() == first.len() && own.iter().zip(first).all(|(a, b)| a.frequency_hz == b.frequency_hz);
        let logarithms: Vec<Complex64> =
            own.iter().zip(first).map(|(own, first)| (own.value / first.value).ln()).collect();
        let log_factor = median(logarithms.iter().map(|log| log.re))?;
        let rest: Vec<Complex64> = logarithms.iter().map(|log| log - log_factor).collect();
        (is_one_grid && own.len() >= LEAST_LINES && is_noise_about_zero(&rest)).then_some((*frf, log_factor))
    };
    let factors: Vec<(usize, f64)> = frfs.iter().map(log_factor).collect::<Option<_>>()?;
    let middle = |frf: usize| {
        median(
            factors
                .iter()
                .filter(|(other, _)| channel(set, *other) == channel(set, frf))
                .map(|(_, log)| *log),
        )
    };
    factors.iter().map(|(frf, log)| Some((*frf, (log - middle(*frf)?).exp()))).collect()
}

/// Whether a series is independent noise about zero: it is no larger than the differences of its neighbours
/// say, or than rounding. Noise of neighbouring lines that correlates, by a window for example, is not
/// recognised.
///
/// # Source  von Neumann, Ann. Math. Stat. 12 (1941) 367–395: of equal noise, Σ(xₖ₊₁ − xₖ)²/Σxₖ² of n numbers
///   has mean 2 and standard deviation 2/√n;
/// here n is twice the number of lines.
fn is_noise_about_zero(series: &[Complex64]) -> bool {
    let squares: f64 = series.iter().map(Complex64::norm_sqr).sum();
    let steps: f64 = series.windows(2).map(|pair| (pair[1] - pair[0]).norm_sqr()).sum();
    let count = series.len() as f64;
    steps >= 2.0 * squares * (1.0 - NO_NOISE / (2.0 * count).sqrt()) || squares <= count * ROUNDING * ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::{Condition, Position, Quantity};
    use numeric::random::normal;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn frf(value: impl FnMut(f64) -> Complex64, step_hz: f64) -> Frf {
        let mut value = value;
        let lines = (1..=(800.0 / step_hz) as usize).map(|at| at as f64 * step_hz);
        Frf {
            position: None,
            record: None,
            response: String::new(),
            excitation: String::new(),
            quantity: Quantity::Receptance,
            condition: Condition::default(),
            averages: None,
            source: String::new(),
            lines: lines.map(|f| FrfLine { frequency_hz: f, value: value(f), noise: None }).collect(),
            rejected: Vec::new(),
        }
    }

    /// Noise is distinguished from three sharp modes at coarse and at fine lines, with a tenth of noise.
    #[test]
    fn limit_noise_has_unrelated_phases() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
        let mut noise = || Complex64::new(normal(&mut random), normal(&mut random));
        for step_hz in [0.5, 5.0, 20.0] {
            for _ in 0..20 {
                let modes = |f: f64| {
                    [(45.0, 1.0), (230.0, -0.3), (610.0, 0.1)]
                        .map(|(hz, a)| a / Complex64::new(hz * hz - f * f, 0.02 * hz * f))
                };
                assert!(!is_noise(&frf(
                    |f| modes(f).iter().sum::<Complex64>() * (1.0 + 0.1 * noise()),
                    step_hz
                )));
            }
            let unrelated = (0..100).filter(|_| is_noise(&frf(|_| noise(), step_hz))).count();
            assert!(unrelated >= 98, "{unrelated} at {step_hz} Hz");
        }
    }

    /// A mass, a spring, a damper and a delay hold no resonance; a well damped mode does, and one above the
    /// band.
    #[test]
    fn limit_single_elements_hold_no_resonance() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        for noise_sd in [1e-9, 0.01, 0.1] {
            for _ in 0..10 {
                let mut noise = || 1.0 + noise_sd * Complex64::new(normal(&mut random), normal(&mut random));
                let mut is = |value: fn(f64) -> Complex64| follows_a_power(&frf(|f| value(f) * noise(), 2.0));
                assert!(is(|f| Complex64::from(-1.0 / (f * f))));
                assert!(is(|_| Complex64::from(1e-8)));
                assert!(is(|f| Complex64::new(0.0, -1.0 / f)));
                assert!(is(|f| Complex64::from_polar(1.0, -5e-3 * f)));
                assert!(!is(|f| 1.0 / Complex64::new(1.0 - (f / 300.0).powi(2), 0.8 * f / 300.0)));
                assert!(!is(|f| 1.0 / Complex64::new(1.0 - (f / 1000.0).powi(2), 0.06 * f / 1000.0)));
            }
        }
    }

    /// Few lines over many modes, of which neighbours differ as much as noise does, are no single element.
    #[test]
    fn limit_coarse_lines_of_many_modes_hold_resonances() {
        let modes = |f: f64| -> Complex64 {
            let mode = |at: u32| {
                1.0 / Complex64::new(
                    1.0 - (f / (90.0 * f64::from(at))).powi(2),
                    0.03 * f / (90.0 * f64::from(at)),
                )
            };
            (1..=8).map(mode).sum()
        };
        for step_hz in [20.0, 27.0, 40.0] {
            assert!(!follows_a_power(&frf(modes, step_hz)), "{step_hz} Hz");
        }
    }

    /// Records of different positions are alike if one record with fresh noise, scaled or not, but not if a
    /// mode moves by its fortieth with a twentieth of noise.
    #[test]
    fn limit_records_alike_differ_by_noise_alone() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
        let set = |noise_sd: f64, shift: f64, random: &mut Xoshiro256PlusPlus| {
            let mut set = MeasurementSet::none();
            for at in 0..4 {
                let hz = 120.0 * (1.0 + shift * at as f64);
                let mut noise = || 1.0 + noise_sd * Complex64::new(normal(random), normal(random));
                let record = frf(|f| noise() / Complex64::new(1.0 - (f / hz).powi(2), 0.06 * f / hz), 2.0);
                set.positions.push(Position { name: format!("l{at}"), nut_m: Some(0.1 * at as f64) });
                set.frfs.push(Frf { position: Some(at), ..record });
            }
            set
        };
        for _ in 0..20 {
            let mut alike = set(0.01, 0.0, &mut random);
            alike.frfs[0].lines.iter_mut().for_each(|line| line.value *= 1.3);
            let found = factors_of_alike(&alike, &[0, 1, 2, 3]).unwrap();
            assert!(
                found
                    .iter()
                    .zip([1.3, 1.0, 1.0, 1.0])
                    .all(|((_, factor), exact)| (factor / exact - 1.0).abs() < 0.005),
                "{found:?}"
            );
            assert_eq!(factors_of_alike(&set(0.05, 0.025, &mut random), &[0, 1, 2, 3]), None);
        }
    }
}
