//! Lines of the FRFs of an objective: fewer of them for a search, and their noise.

use super::FrfObjective;
use super::record::FrfRecord;

impl<'m> FrfObjective<'m> {
    /// Returns the objective with at most `most` lines of each record, evenly spaced.
    #[must_use]
    pub fn thinned(&self, most: usize) -> FrfObjective<'m> {
        self.with_records(|record| record.thinned(most))
    }

    /// Returns the objective with at most `most` lines of each record, dense where its curve bends, weighted
    /// by the lines they represent.
    ///
    /// It serves searches only, since its χ² scatters more than the weights imply.
    #[must_use]
    pub fn curvature_sampled(&self, most: usize) -> FrfObjective<'m> {
        self.with_records(|record| record.curvature_sampled(most))
    }

    fn with_records(&self, each: impl Fn(&FrfRecord) -> FrfRecord) -> FrfObjective<'m> {
        let mut other = self.resampled(&[]);
        other.records = self.with_precomputed_rods(self.records.iter().map(each).collect());
        other
    }

    /// Returns the standard deviation by noise alone of each weighted residual of [`FrfObjective::rows`],
    /// without priors. A line without stated noise has that of the model error.
    pub fn noise_of_rows(&self) -> Vec<f64> {
        let model_error = self.settings.model_error;
        let of = |r: &FrfRecord| -> Vec<f64> {
            let each = r
                .noise_sd
                .iter()
                .zip(&r.weight)
                .map(|(sd, weight)| sd.unwrap_or(model_error) * weight.sqrt());
            each.flat_map(|sd| [sd, sd]).collect()
        };
        self.records.iter().flat_map(of).collect()
    }

    /// Returns the expected χ² by the noise of the lines alone, per real number compared.
    pub fn noise_share(&self) -> f64 {
        let share = |r: &FrfRecord| {
            r.noise_sd
                .iter()
                .zip(&r.weight)
                .map(|(sd, weight)| sd.unwrap_or(0.0).powi(2) * weight)
                .sum::<f64>()
        };
        self.records.iter().map(share).sum::<f64>() / self.lines().iter().sum::<usize>().max(1) as f64
    }
}
