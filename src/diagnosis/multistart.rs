//! Fits of hypotheses from starts all over the parameter ranges.

use rayon::prelude::*;

use super::evidence::DomainObjective;
use super::fit::{
    COARSE_STEPS, Fitted, Fitter, MULTISTART_LINES, STEPS, at_start, read_back, sought, start_of,
};
use super::hypothesis::Hypothesis;
use identification::objective::ObjectiveError;
use identification::{frf_search_minima, mode_search_end};
use long_work::Control;
use numeric::halton::halton_point;

/// Starts distributed over the parameter ranges, and the number that continue after a few steps on coarse
/// lines.
pub(super) const MULTISTART: (usize, usize) = (32, 6);
/// Lines of all FRFs together on which a machine is searched, and least and largest number per FRF.
const SEARCHED_LINES: (usize, usize, usize) = (360, 40, 120);
const MULTISTART_STEPS: u64 = 8;

impl Fitter<'_> {
    /// Searches a hypothesis as an identification of its machine does: a missing effect may have led joints and
    /// tolerances into a wrong basin, so that nothing of another fit enters. Each round has its own starts.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn search_globally(
        &self,
        hypothesis: &Hypothesis,
        (seed, round): (u64, usize),
        control: &Control,
    ) -> Result<Option<Fitted>, ObjectiveError> {
        let key = format!("{} {seed} {round}", self.cache_key("search", hypothesis, &[]));
        control.try_cached(&key, || {
            let objective = self.objective(hypothesis)?;
            let start = at_start(hypothesis);
            let seed = seed.wrapping_add(round as u64);
            if let DomainObjective::Modes(modes) = &objective {
                let end = mode_search_end(modes, seed, &control.within(&key));
                return Ok(end.map(|(place, cost)| read_back(&objective, &start, &place, cost)));
            }
            let coarse = self.coarse(&objective);
            let few = coarse.as_ref().unwrap_or(&objective);
            let minima = self.searched(&objective, &start, seed, &control.within(&key));
            let ends: Vec<Fitted> =
                minima.par_iter().map(|end| self.descend(few, end, COARSE_STEPS, control)).collect();
            let best = ends.iter().min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
            Ok(best.map(|best| self.descend(&objective, best, STEPS, control)))
        })
    }

    /// Returns the minima of FRFs on few lines from a search of the whole ranges; none of modes.
    pub(super) fn searched(
        &self,
        objective: &DomainObjective<'_>,
        start: &Fitted,
        seed: u64,
        control: &Control,
    ) -> Vec<Fitted> {
        let DomainObjective::Frf(frfs) = objective else { return Vec::new() };
        let minima = frf_search_minima(&frfs.thinned(self.lines_of_one(SEARCHED_LINES)), seed, control);
        minima.iter().map(|place| read_back(objective, start, place, f64::INFINITY)).collect()
    }

    /// Fits a hypothesis by least squares from starts all over the parameter ranges and around a fit; each
    /// round has its own.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn multistart(
        &self,
        hypothesis: &Hypothesis,
        base: &Fitted,
        round: usize,
        control: &Control,
    ) -> Result<Fitted, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let ends = self.multistart_ends(&objective, hypothesis, base, (MULTISTART, round), control);
        let best = ends.iter().min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        Ok(best.map_or_else(
            || start_of(hypothesis, base, &[]),
            |end| self.descend(&objective, end, STEPS, control),
        ))
    }

    /// Returns the best fits, on coarse lines, of starts all over the parameter ranges.
    pub(super) fn multistart_ends(
        &self,
        objective: &DomainObjective<'_>,
        hypothesis: &Hypothesis,
        base: &Fitted,
        ((starts, followed), round): ((usize, usize), usize),
        control: &Control,
    ) -> Vec<Fitted> {
        let centre = start_of(hypothesis, base, &[]);
        if control.stopped() {
            return Vec::new();
        }
        let coarse = objective.coarse(self.lines_of_one(MULTISTART_LINES));
        let few = coarse.as_ref().unwrap_or(objective);
        let (described, sought) = (&hypothesis.machine.parameters, sought(hypothesis, base));
        let varied = objective
            .free()
            .iter()
            .filter(|i| hypothesis.added.contains(i) || !described[**i].is_tolerance());
        let varied: Vec<usize> = varied.copied().collect();
        let start = |index: usize| {
            let mut start = centre.clone();
            for (place, &parameter) in halton_point(index, varied.len()).into_iter().zip(&varied) {
                let near = index % 2 == 1 && !sought.contains(&parameter);
                start.units[parameter] = if near {
                    (centre.units[parameter] + 0.5 * (place - 0.5)).clamp(0.0, 1.0)
                } else {
                    place
                };
            }
            start
        };
        let mut ends: Vec<Fitted> = (1..=starts)
            .into_par_iter()
            .map(|index| self.descend(few, &start(round * starts + index), MULTISTART_STEPS, control))
            .collect();
        ends.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        ends.truncate(followed);
        ends.par_iter().map(|end| self.descend(few, end, COARSE_STEPS, control)).collect()
    }
}
