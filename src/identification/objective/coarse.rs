//! Objectives on few lines, for the steps of a global search.

use super::FrfObjective;

/// Largest number of lines of one FRF in the first steps of a global search.
const THIN_LINES: usize = 120;
/// Standard deviation of ln H of all lines in the first steps of a global search (1): a misfit that noise
/// does not reach.
const COARSE_SD: f64 = 0.3;

impl<'m> FrfObjective<'m> {
    /// Returns the objective on thinned lines, for the steps of a global search.
    pub(crate) fn thin(&self) -> &FrfObjective<'m> {
        self.thin.get_or_init(|| Box::new(self.thinned(THIN_LINES)))
    }

    /// Returns the objective on thinned lines of equal weight, with tolerances, nut positions and channels as
    /// stated, for the first steps of a global search.
    pub(crate) fn coarse(&self) -> &FrfObjective<'m> {
        self.coarse.get_or_init(|| {
            let mut coarse = self.resampled(&[]);
            coarse.free.truncate(self.own_count);
            self.free[self.own_count..]
                .iter()
                .for_each(|i| coarse.base[*i] = self.machine.parameters[*i].search_start());
            (coarse.nuts, coarse.settings) = (0, self.settings.as_stated());
            let thinned = self.records.iter().map(|record| record.thinned(THIN_LINES)).collect();
            coarse.records = coarse.with_precomputed_rods(thinned);
            coarse.records.iter_mut().for_each(|record| record.weight.fill(COARSE_SD.powi(-2)));
            Box::new(coarse)
        })
    }
}
