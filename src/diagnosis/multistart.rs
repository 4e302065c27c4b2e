//! Fits of hypotheses from starts all over the parameter ranges.

use rayon::prelude::*;

use super::evidence::DomainObjective;
use super::fit::{COARSE_STEPS, Fitted, Fitter, MULTISTART_LINES, STEPS, read_back, sought, start_of};
use super::hypothesis::Hypothesis;
use identification::mode_search_end;
use identification::objective::ObjectiveError;
use long_work::Control;
use numeric::halton::halton_point;

/// Starts distributed over the parameter ranges, and the number that continue after a few steps on coarse
/// lines.
pub(super) const MULTISTART: (usize, usize) = (32, 6);
const MULTISTART_STEPS: u64 = 8;

impl Fitter<'_> {
    /// Fits a hypothesis from starts all over the parameter ranges: a missing effect may have led the joints
    /// into a wrong basin. The starts of FRFs are also around a fit and differ by the round alone; modes are
    /// searched as an identification searches them, since their χ² has steps where a mode changes its order.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn search_globally(
        &self,
        hypothesis: &Hypothesis,
        base: &Fitted,
        (seed, round): (u64, usize),
        control: &Control,
    ) -> Result<Fitted, ObjectiveError> {
        let key =
            format!("{} {seed} {round}", self.cache_key("scatter", hypothesis, std::slice::from_ref(base)));
        control.try_cached(&key, || {
            let objective = self.objective(hypothesis)?;
            let DomainObjective::Modes(modes) = &objective else {
                return self.multistart(hypothesis, base, round, control);
            };
            let start = start_of(hypothesis, base, &[]);
            let end = mode_search_end(modes, seed.wrapping_add(round as u64), &control.within(&key));
            Ok(end.map_or_else(|| start.clone(), |(place, cost)| read_back(&objective, &start, &place, cost)))
        })
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
