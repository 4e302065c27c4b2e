//! One search for all hypotheses. Joints that a fit of one hypothesis found are starts of every other one,
//! until nothing improves: a missing effect may lead the joints of the nominal machine into a wrong basin,
//! from which the effect looks small.

use rayon::prelude::*;

use super::evidence::{Domain, DomainObjective};
use super::fit::{Ablation, Fitted, Fitter, IMPROVEMENT, close, start_of};
use super::hypothesis::{Hypothesis, interfaces};
use super::policy::LEAST_SCALE;
use super::screening::{Candidate, Screening, Status, descend_to_minimum, implausibility, relaxes_within};
use identification::objective::ObjectiveError;
use identification::{CHI_SQUARE_95, ToleranceEstimate};
use long_work::Control;
use machine::UnitValues;

/// Largest number of rounds, and of joints from which all hypotheses are fitted in a round.
const ROUNDS: (usize, usize) = (4, 2);
/// Number of global searches that end in the best fit of a hypothesis.
const FOUND: usize = 2;
/// Largest number of descents to the minimum of a rival, and decrease of χ² by which it has settled: fresh
/// steps continue along a valley.
const RESTARTS: usize = 5;
const SETTLED: f64 = 0.02;
/// Largest χ² of a rival as a multiple of the least: a candidate that leaves more than twice as much does not
/// explain the data.
const RIVAL: f64 = 2.0;
/// Number of fits, of those that the data do not distinguish from the best, whose joints all of these share.
const SHARED: usize = 3;
/// χ² per compared number above which every hypothesis is fitted from more starts: a multiple of the noise's
/// share, plus a constant.
const LARGE_MISFIT: (f64, f64) = (1.5, 0.1);

/// Effort of a search.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Largest number of generic impedances, and of the parameters of each.
    pub located: (usize, usize),
    /// Largest number of global searches for each candidate; 0 for the first fits alone.
    pub searches: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Fits of a set of hypotheses.
struct Search<'f, 's> {
    fitter: &'f Fitter<'s>,
    control: &'f Control,
    effort: Effort,
    nominal: Hypothesis,
    /// Best fit of the nominal machine.
    base: Fitted,
    hypotheses: Vec<Hypothesis>,
    fits: Vec<Result<Fitted, ObjectiveError>>,
    /// Nominal parameters from which all hypotheses were fitted.
    used: Vec<UnitValues>,
    /// Reduction of χ² that a candidate must exceed to be followed further: below it noise alone reduces as
    /// much. 0 for modes, whose χ² has steps.
    least_gain: f64,
}

/// Fits every candidate and the best generic impedances, jointly with the nominal parameters. The first fits
/// start from those of the nominal machine. The nominal machine and all hypotheses are then fitted from the
/// joints where the best of them end, until nothing improves. Where even the best candidate leaves a large
/// χ², all are fitted from starts all over their ranges. Returns the candidates and generic impedances by
/// reduction of χ²: these locate the discrepancy.
///
/// # Errors  as [`Fitter::objective`]; a candidate whose fit fails is reported among the candidates.
pub fn search(
    fitter: &Fitter<'_>,
    nominal: Hypothesis,
    bases: Vec<Fitted>,
    (hypotheses, others): (Vec<Hypothesis>, Vec<Candidate>),
    effort: Effort,
    control: &Control,
) -> Result<(Screening, Vec<Candidate>), ObjectiveError> {
    let is_frozen = fitter.lacks(Ablation::FrozenNominal);
    let hypotheses: Vec<Hypothesis> = match is_frozen {
        true => hypotheses.into_iter().map(|h| h.kept_at(&bases[0].units)).collect(),
        false => hypotheses,
    };
    let objective = fitter.objective(&nominal)?;
    let step = control.steps("candidates", hypotheses.len());
    let first = |hypothesis: &Hypothesis| {
        let fit = fitter.fit(hypothesis, &bases, control);
        step();
        fit
    };
    let fits = hypotheses.par_iter().map(first).collect();
    let used = bases.iter().map(|base| base.units.clone()).collect();
    let least_gain = match fitter.domain {
        Domain::Frf(_) => LEAST_SCALE * objective.noise_share().min(1.0),
        Domain::Modes(_) => 0.0,
    };
    let mut search = Search {
        fitter,
        control,
        effort,
        base: bases[0].clone(),
        nominal: nominal.clone(),
        hypotheses,
        fits,
        used,
        least_gain,
    };
    let candidates = search.hypotheses.len();
    search.add_interfaces(effort.located);
    if !is_frozen && effort.searches > 0 {
        let limit = large_misfit(&objective);
        // With few numbers almost any candidate reduces χ² much: compare them only after a global search for
        // each.
        let is_wide = matches!(fitter.domain, Domain::Modes(_)) && search.base.chi_square > limit;
        if !is_wide {
            search.exchange(&objective);
        }
        if is_wide || search.is_led_astray()? || search.least(candidates) > limit {
            search.spread(candidates, &objective);
        }
    }
    search.settle()?;
    search.nest()?;
    Ok(search.results(candidates, others))
}

/// Returns the χ² above which a fit leaves much.
pub(super) fn large_misfit(objective: &DomainObjective<'_>) -> f64 {
    (LARGE_MISFIT.0 * objective.noise_share() + LARGE_MISFIT.1) * objective.observations() as f64
}

impl Search<'_, '_> {
    /// Adds the generic impedances that promise most by one linear step.
    fn add_interfaces(&mut self, (count, parameters): (usize, usize)) {
        if count == 0 {
            return;
        }
        let bases = [self.base.clone()];
        let mut promising: Vec<(f64, Hypothesis)> = interfaces(&self.nominal)
            .into_par_iter()
            .filter(|hypothesis| hypothesis.added.len() <= parameters)
            .filter_map(|hypothesis| {
                Some((self.fitter.predicted_cost(&hypothesis, &self.base, self.control).ok()?, hypothesis))
            })
            .collect();
        promising.sort_by(|a, b| a.0.total_cmp(&b.0));
        promising.truncate(2 * count);
        let fit = |(_, hypothesis): (f64, Hypothesis)| {
            (self.fitter.fit(&hypothesis, &bases, self.control), hypothesis)
        };
        let mut fitted: Vec<(Result<Fitted, ObjectiveError>, Hypothesis)> =
            promising.into_par_iter().map(fit).collect();
        let cost =
            |fit: &Result<Fitted, ObjectiveError>| fit.as_ref().map_or(f64::INFINITY, |fit| fit.chi_square);
        fitted.sort_by(|a, b| cost(&a.0).total_cmp(&cost(&b.0)));
        fitted.truncate(count);
        for (fit, hypothesis) in fitted {
            self.fits.push(fit);
            self.hypotheses.push(hypothesis);
        }
    }

    /// Whether the nominal machine moves a stated number farther than any right one: its joints may be as far
    /// from those of the machine that has what is missing.
    fn is_led_astray(&self) -> Result<bool, ObjectiveError> {
        let tolerances = self.fitter.tolerances(&self.nominal, &self.base)?;
        Ok(tolerances.iter().any(ToleranceEstimate::is_finding))
    }

    /// Returns the least χ² of the nominal machine and the candidates.
    fn least(&self, candidates: usize) -> f64 {
        self.fits[..candidates]
            .iter()
            .flatten()
            .map(|fit| fit.chi_square)
            .fold(self.base.chi_square, f64::min)
    }

    /// Fits hypotheses that end above the nominal machine, which each of them contains, from its minimum.
    fn nest(&mut self) -> Result<(), ObjectiveError> {
        let Search { fitter, control, base, hypotheses, fits, .. } = self;
        let fitted = hypotheses.par_iter().zip(fits).filter_map(|(h, fit)| Some((h, fit.as_mut().ok()?)));
        let above = fitted.filter(|(_, fit)| fit.chi_square > base.chi_square + IMPROVEMENT);
        above.try_for_each(|(hypothesis, fit)| {
            let objective = fitter.objective(hypothesis)?;
            let end = descend_to_minimum(fitter, &objective, &start_of(hypothesis, base, &[]), control);
            if end.chi_square < fit.chi_square {
                *fit = end;
            }
            Ok(())
        })
    }

    /// Fits the nominal machine and all hypotheses from the joints where the best of them end, until no rival
    /// improves.
    fn exchange(&mut self, objective: &DomainObjective<'_>) {
        for _ in 0..ROUNDS.0 {
            let starts = self.new_joints();
            if starts.is_empty() || self.control.stopped() {
                return;
            }
            self.used.extend(starts.iter().map(|start| start.units.clone()));
            let mut ends: Vec<Fitted> = starts
                .par_iter()
                .map(|start| descend_to_minimum(self.fitter, objective, start, self.control))
                .collect();
            ends.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
            let before = self.base.chi_square;
            if ends[0].chi_square < before {
                self.base = ends.swap_remove(0);
            }
            let moved = (self.base.chi_square < before - IMPROVEMENT).then(|| self.base.clone());
            let bases: Vec<Fitted> = moved.into_iter().chain(starts).collect();
            let again = |(hypothesis, known): (&Hypothesis, &Result<Fitted, ObjectiveError>)| match known {
                Ok(known) => self.fitter.improved(hypothesis, known, &bases, self.control).ok().flatten(),
                Err(_) => self.fitter.fit(hypothesis, &bases, self.control).ok(),
            };
            let again: Vec<Option<Fitted>> = self.hypotheses.par_iter().zip(&self.fits).map(again).collect();
            let mut gains = Vec::new();
            for (known, other) in self.fits.iter_mut().zip(again) {
                let Some(other) = other else { continue };
                gains.push((known.as_ref().map_or(f64::INFINITY, |fit| fit.chi_square), other.chi_square));
                *known = Ok(other);
            }
            let largest = self.largest_rival();
            let improved = self.base.chi_square < before - IMPROVEMENT
                || gains.iter().any(|(from, to)| *to < from - IMPROVEMENT && *to <= largest);
            if !improved {
                return;
            }
        }
    }

    /// Returns the largest χ² of a rival: a hypothesis that may explain the data.
    fn largest_rival(&self) -> f64 {
        let rival = RIVAL * self.least(self.hypotheses.len());
        if self.least_gain > 0.0 { rival.min(self.base.chi_square - self.least_gain) } else { rival }
    }

    /// Returns the nominal parameters of the best fits, as far as no round has started from them.
    fn new_joints(&self) -> Vec<Fitted> {
        let own = self.nominal.machine.parameters.len();
        let mut best: Vec<&Fitted> = self
            .fits
            .iter()
            .flatten()
            .filter(|fit| self.base.chi_square - fit.chi_square > self.least_gain)
            .collect();
        best.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        let mut joints: Vec<Fitted> = Vec::new();
        for fit in best {
            let start = Fitted { units: UnitValues(fit.units[..own].to_vec()), ..fit.clone() };
            if self
                .used
                .iter()
                .chain(joints.iter().map(|j| &j.units))
                .all(|known| !close(known, &start.units))
            {
                joints.push(start);
            }
            if joints.len() == ROUNDS.1 {
                break;
            }
        }
        joints
    }

    /// Fits the candidates from starts all over their ranges; the rivals until each was found again.
    fn spread(&mut self, candidates: usize, objective: &DomainObjective<'_>) {
        let mut found = vec![0; candidates];
        for round in 0..self.effort.searches {
            let least = self.least(candidates);
            let is_rival = |at: &usize| {
                round == 0 || self.fits[*at].as_ref().is_ok_and(|fit| fit.chi_square <= RIVAL * least)
            };
            let open: Vec<usize> = (0..candidates).filter(|at| found[*at] < FOUND).filter(is_rival).collect();
            let search = |at: &usize| {
                self.fitter.search_globally(&self.hypotheses[*at], (self.effort.seed, round), self.control)
            };
            let ends: Vec<Result<Option<Fitted>, ObjectiveError>> = open.par_iter().map(search).collect();
            let mut improved = false;
            for (at, end) in open.into_iter().zip(ends) {
                let Ok(Some(end)) = end else { continue };
                let (known, times) =
                    self.fits[at].as_ref().map_or((f64::INFINITY, 0), |fit| (fit.chi_square, fit.found));
                let is_deeper = end.chi_square < known - IMPROVEMENT;
                if is_deeper {
                    (found[at], improved) = (0, true);
                }
                if end.chi_square < known + IMPROVEMENT {
                    found[at] += 1;
                    let count = if is_deeper { 1 } else { times + 1 };
                    match &mut self.fits[at] {
                        Ok(fit) if end.chi_square >= known => fit.found = count,
                        fit => *fit = Ok(Fitted { found: count, ..end }),
                    }
                }
            }
            if improved || round == 0 {
                self.exchange(objective);
            }
        }
    }

    /// Descends to the minima of the rivals, as far as that of the nominal machine: joints in series form
    /// long valleys. Those that the data do not distinguish from the best are fitted once more from the
    /// joints of each other, on all lines: few lines do not distinguish their minima.
    fn settle(&mut self) -> Result<(), ObjectiveError> {
        let (fitter, control, own) = (self.fitter, self.control, self.nominal.machine.parameters.len());
        let largest = self.largest_rival();
        self.refine_up_to(largest, |_, objective, fit| settled(fitter, objective, fit, control))?;
        let (least, count) =
            (self.least(self.hypotheses.len()), fitter.objective(&self.nominal)?.observations() as f64);
        let nearly = largest.min(least + CHI_SQUARE_95 * (least / count).max(1.0));
        let mut joints: Vec<Fitted> =
            self.fits.iter().flatten().filter(|fit| fit.chi_square <= nearly).cloned().collect();
        joints.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        joints.truncate(SHARED);
        self.refine_up_to(nearly, |hypothesis, objective, fit| {
            // A released parameter belongs to its own hypothesis.
            let shared = || {
                objective
                    .free()
                    .iter()
                    .copied()
                    .filter(|index| *index < own && !hypothesis.added.contains(index))
            };
            let mut best = fit.clone();
            for other in joints.iter().filter(|other| !have_close_joints(other, fit, own)) {
                let mut start = Fitted { tail: other.tail.clone(), chi_square: f64::INFINITY, ..fit.clone() };
                shared().for_each(|index| start.units[index] = other.units[index]);
                let end = settled(fitter, objective, &start, control);
                if end.chi_square < best.chi_square {
                    let found = if end.chi_square < fit.chi_square - IMPROVEMENT { 1 } else { fit.found };
                    best = Fitted { found, ..end };
                }
            }
            best
        })
    }

    /// Replaces the fits with a χ² up to a limit by refined ones.
    fn refine_up_to(
        &mut self,
        limit: f64,
        refined: impl Fn(&Hypothesis, &DomainObjective<'_>, &Fitted) -> Fitted + Sync,
    ) -> Result<(), ObjectiveError> {
        let Search { fitter, hypotheses, .. } = self;
        let fits =
            hypotheses.par_iter().zip(&mut self.fits).filter_map(|(h, fit)| Some((h, fit.as_mut().ok()?)));
        fits.filter(|(_, fit)| fit.chi_square <= limit).try_for_each(|(hypothesis, fit)| {
            *fit = refined(hypothesis, &fitter.objective(hypothesis)?, fit);
            Ok(())
        })
    }

    /// Returns the candidates and the best generic impedances.
    fn results(self, candidates: usize, others: Vec<Candidate>) -> (Screening, Vec<Candidate>) {
        let Search { fitter, nominal, base, hypotheses, fits, .. } = self;
        let band_hz = fitter.band_hz();
        let mut all = hypotheses.into_iter().zip(fits);
        let mut tried: Vec<Candidate> = all
            .by_ref()
            .take(candidates)
            .map(|(hypothesis, fit)| Candidate::of(hypothesis, fit, &base, band_hz))
            .collect();
        let fitted = all.filter_map(|(hypothesis, fit)| Some((hypothesis, fit.ok()?)));
        let mut located: Vec<Candidate> = fitted
            .map(|(hypothesis, fitted)| {
                let (id, gain) = (hypothesis.id(), (base.chi_square - fitted.chi_square).max(0.0));
                Candidate {
                    fitted: Some((hypothesis, fitted)),
                    gain,
                    ..Candidate::without_fit(&id, Status::Tried)
                }
            })
            .collect();
        located.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        tried.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        tried.extend(others);
        (Screening { nominal, base, candidates: tried }, located)
    }
}

/// Descends from a fit until fresh steps no longer reduce its χ².
fn settled(fitter: &Fitter<'_>, objective: &DomainObjective<'_>, from: &Fitted, control: &Control) -> Fitted {
    let mut fit = from.clone();
    for _ in 0..RESTARTS {
        let end = descend_to_minimum(fitter, objective, &fit, control);
        let gain = fit.chi_square - end.chi_square;
        if gain > 0.0 {
            fit = Fitted { found: fit.found, ..end };
        }
        if gain < SETTLED {
            break;
        }
    }
    fit
}

/// Whether two fits have the same nominal parameters, which are the first.
fn have_close_joints(a: &Fitted, b: &Fitted, own: usize) -> bool {
    a.units[..own].iter().zip(&b.units[..own]).all(|(a, b)| (a - b).abs() < 1e-3)
}

impl Candidate {
    /// Returns a candidate with its fit to data in a band. A larger machine that fits worse is a failed fit,
    /// not a rejected candidate.
    pub(super) fn of(
        hypothesis: Hypothesis,
        fit: Result<Fitted, ObjectiveError>,
        base: &Fitted,
        band_hz: Option<(f64, f64)>,
    ) -> Self {
        let id = hypothesis.id();
        match fit {
            Ok(fitted) if fitted.chi_square > base.chi_square * (1.0 + 1e-2) + 3.0 => Candidate::without_fit(
                &id,
                Status::Failed("its fit ends at a larger χ² than that of the machine without it".into()),
            ),
            Ok(fitted) => {
                let gain = if implausibility(&hypothesis, &fitted).is_none() {
                    (base.chi_square - fitted.chi_square).max(0.0)
                } else {
                    0.0
                };
                let is_limit = band_hz.is_some_and(|band_hz| !relaxes_within(&hypothesis, &fitted, band_hz));
                Candidate {
                    fitted: Some((hypothesis, fitted)),
                    gain,
                    is_limit,
                    ..Candidate::without_fit(&id, Status::Tried)
                }
            }
            Err(error) => Candidate::without_fit(&id, Status::Failed(error.to_string())),
        }
    }
}
