//! Residuals of FRFs at given values: line by line, as the gap of each FRF, and their correlation.

use num_complex::Complex64;
use rayon::prelude::*;

use super::frf::FrfObjective;
use super::record::{Decoded, FrfRecord, factor, log_factor, wrapped};
use crate::Place;
use dynamics::model::{ABREAST, Complexes, LANES};
use machine::ParameterValues;
use numeric::statistics::root_mean_square;

/// The gap of one FRF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfGap {
    /// Index of the FRF in the set.
    pub frf: usize,
    /// √ of the mean of ½·[(ln|H_m| − ln|H_s|)² + wrap(arg H_m − arg H_s)²].
    pub gap: f64,
    /// The gap by the noise of the lines alone; `None` where the noise is unknown.
    pub noise_floor: Option<f64>,
    /// Number of lines compared.
    pub lines: usize,
}

impl FrfObjective<'_> {
    /// Calls `each(line, residuals)` for every four lines of a record, from a multiple of four on.
    ///
    /// The residuals are r = ln(measured/predicted), without the gain of the set. Past the last line those of
    /// the last line repeat.
    pub(super) fn visit(
        &self,
        record: &FrfRecord,
        here: &Decoded,
        lines: std::ops::Range<usize>,
        mut each: impl FnMut(usize, Complexes),
    ) {
        let operating = here.operating(record);
        let mut scratch = self.borrow(record.structure);
        scratch.network.update(self.machine, &here.parameters, &operating);
        let factor = factor(self.machine.chain.at(&here.parameters, &operating), here.channel(record));
        let loops = self.loops(record.structure, (here, operating), &mut scratch.encoders, &[]);
        let groups = lines.start / LANES..lines.end.div_ceil(LANES);
        let mut followed = [Complexes::ZERO; ABREAST];
        for from in groups.clone().step_by(ABREAST) {
            let some = from..groups.end.min(from + ABREAST);
            let mut predicted =
                scratch.network.receptances_on(&record.lines, some.clone(), &mut scratch.work);
            if let Some(loops) = &loops {
                predicted =
                    loops.close(&record.lines, some.clone(), &mut scratch.encoders, predicted, &mut followed);
            }
            for ((at, predicted), omega) in some.clone().zip(predicted).zip(&record.lines.omega_rad_s()[some])
            {
                let residual = record.measured(at * LANES) - predicted.ln() - log_factor(factor, *omega);
                each(at * LANES, wrapped(residual));
            }
        }
        self.give_back(record.structure, scratch);
    }

    /// Returns the residuals of all records at given parameters and gain, with nut positions as stated.
    pub fn residuals(&self, parameters: &ParameterValues, gain: f64) -> Vec<Vec<Complex64>> {
        self.residuals_of(&self.as_stated(parameters, gain))
    }

    pub(super) fn as_stated(&self, parameters: &ParameterValues, gain: f64) -> Decoded {
        let channels = self.channels.iter().map(|channel| channel.calibration).collect();
        Decoded { parameters: parameters.clone(), log_gain: gain.ln(), nut_shift_m: Vec::new(), channels }
    }

    /// Returns the residuals of all records at coordinates of free parameters, gain, nut positions and
    /// channels.
    pub fn residuals_at(&self, place: &Place) -> Vec<Vec<Complex64>> {
        self.residuals_of(&self.decode(place))
    }

    fn residuals_of(&self, here: &Decoded) -> Vec<Vec<Complex64>> {
        self.records
            .par_iter()
            .map(|record| {
                let mut residuals = Vec::with_capacity(record.omega_rad_s.len());
                let count = record.omega_rad_s.len();
                self.visit(record, here, 0..count, |line, r| {
                    residuals.extend(r.lanes().iter().take(count - line).map(|r| r - here.log_gain));
                });
                residuals
            })
            .collect()
    }

    /// Returns the gap of each record at given parameters and gain.
    ///
    /// # Source  this project's definition of the gap between a measured and a predicted FRF: root mean
    ///   square of the error of ln H, per component.
    pub fn gaps(&self, parameters: &ParameterValues, gain: f64) -> Vec<FrfGap> {
        self.gaps_of(self.residuals(parameters, gain))
    }

    /// Returns the gap of each record at given coordinates, nuisance parameters included.
    pub fn gaps_at(&self, place: &Place) -> Vec<FrfGap> {
        self.gaps_of(self.residuals_at(place))
    }

    fn gaps_of(&self, residuals: Vec<Vec<Complex64>>) -> Vec<FrfGap> {
        self.records
            .iter()
            .zip(residuals)
            .map(|(record, residuals)| {
                let noise: Option<Vec<f64>> = record.stated_sd.iter().copied().collect();
                FrfGap {
                    frf: record.frf,
                    gap: (residuals.iter().map(|r| 0.5 * r.norm_sqr()).sum::<f64>() / residuals.len() as f64)
                        .sqrt(),
                    noise_floor: noise.and_then(root_mean_square),
                    lines: residuals.len(),
                }
            })
            .collect()
    }

    /// Returns the variance inflation of the estimates by correlation of neighbouring lines, 1 + 2·Σρ.
    ///
    /// The sum runs over the lags up to the first insignificant one. The result is 1 for noise alone, and
    /// large where model error dominates.
    ///
    /// # Source  effective sample size of an autocorrelated series; Bayley and Hammersley, J. R. Stat. Soc.
    ///   Suppl. 8 (1946) 184–197.
    pub fn correlation_factor(&self, place: &Place) -> f64 {
        let residuals = self.residuals_of(&self.decode(place));
        let weighted = |record: &FrfRecord, r: &[Complex64]| -> Vec<Complex64> {
            r.iter().zip(&record.weight).map(|(r, w)| r * w.sqrt()).collect()
        };
        let series: Vec<Vec<Complex64>> =
            self.records.iter().zip(&residuals).map(|(record, r)| weighted(record, r)).collect();
        let total: f64 = series.iter().flatten().map(Complex64::norm_sqr).sum();
        let count = 2.0 * series.iter().map(Vec::len).sum::<usize>() as f64;
        let longest = series.iter().map(Vec::len).max().unwrap_or(0) / 10;
        let mut sum = 0.0;
        for lag in 1..=longest {
            let products: f64 = series
                .iter()
                .flat_map(|s| s.iter().zip(s.iter().skip(lag)))
                .map(|(a, b)| (a * b.conj()).re)
                .sum();
            let correlation = products / total;
            if !(correlation > 2.0 / count.sqrt()) {
                break;
            }
            sum += correlation;
        }
        1.0 + 2.0 * sum
    }
}
