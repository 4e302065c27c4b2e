//! Fits of hypotheses, jointly with the nominal parameters and the nuisance parameters.

use serde::{Deserialize, Serialize};

use super::amplitudes::amplitudes;
use super::evidence::{Domain, DomainObjective, PartialGap, gaps};
use super::hypothesis::Hypothesis;
use identification::objective::{ObjectiveError, operating};
use identification::{CHI_SQUARE_95, Place, Surroundings, Tail, ToleranceEstimate, tolerances_at};
use long_work::Control;
use machine::{OperatingVariable, Parameter, ParameterValues, UnitValues};
use measurement::{FitSet, FrfLine, HoldOutSet};
use optimizer::least_squares_within;

/// A fitted hypothesis: coordinates of the parameters of its machine and of the unknowns of the data (gain,
/// nut positions, channels).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fitted {
    /// Coordinate of each parameter of the hypothesis' machine in its unit interval.
    pub units: UnitValues,
    /// Coordinates of an unknown gain, of nut positions, and of the gains and delays of channels.
    pub tail: Tail,
    /// Least χ².
    pub chi_square: f64,
    /// Number of searches that ended in it.
    pub found: usize,
}

/// Decrease of χ² (1) by which a fit improves, and by which two ends are one: a ratio of likelihoods of
/// e^(1/4).
pub(super) const IMPROVEMENT: f64 = 0.5;
/// Starts that are followed: a number, and a further number per added parameter. Least distance between them
/// in the unit interval of some parameter, and largest step for which a linear prediction of χ² is trusted.
const FOLLOWED: (usize, usize) = (2, 2);
const LEAST_DISTANCE: f64 = 0.045;
pub(super) const TRUST_RADIUS: f64 = 0.1;
/// Amplitudes tried from further joints, as a multiple of the starts that are followed.
const PROMISING: usize = 4;
/// Lines of all FRFs together on which starts are evaluated, and least and largest number per FRF.
const COARSE: (usize, usize, usize) = (400, 40, 80);
/// Steps on the coarse lines and on all lines.
pub(super) const COARSE_STEPS: u64 = 40;
pub(super) const STEPS: u64 = 40;
/// Relative decrease of χ² per step at which a descent ends.
const TOLERANCE: f64 = 1e-4;
/// Lines of all FRFs together on which starts all over the ranges are evaluated, and least and largest number
/// per FRF.
pub(super) const MULTISTART_LINES: (usize, usize, usize) = (300, 16, 60);

/// A part of the method that can be disabled to measure its benefit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ablation {
    /// Thresholds from χ² tables instead of null simulations.
    ChiSquare,
    /// Candidates fitted alone, with the nominal parameters fixed at the nominal fit.
    FrozenNominal,
    /// No nuisance parameters are fitted.
    NoNuisances,
    /// Candidates ranked by the positions they were fitted to.
    InSample,
}

/// Data and settings of fits.
#[derive(Debug, Clone)]
pub struct Fitter<'s> {
    /// Data to fit.
    pub fit: FitSet<'s>,
    /// FRFs or modes, their weights and band.
    pub domain: Domain,
    /// Parameters that keep their start values.
    pub frozen: Vec<String>,
    /// Disabled parts of the method.
    pub ablated: Vec<Ablation>,
}

impl<'s> Fitter<'s> {
    /// Returns the number of lines per FRF, given that of all FRFs and the least and largest number per FRF.
    pub(super) fn lines_of_one(&self, (all, least, most): (usize, usize, usize)) -> usize {
        (all / self.fit.frfs().len().max(1)).clamp(least, most)
    }

    /// Whether a part of the method is disabled.
    pub(super) fn lacks(&self, part: Ablation) -> bool {
        self.ablated.contains(&part)
    }

    /// Returns the lowest and the highest frequency (Hz) of the FRFs to fit; `None` for modes.
    pub fn band_hz(&self) -> Option<(f64, f64)> {
        let Domain::Frf(settings) = self.domain else { return None };
        let frfs = self.fit.frfs().iter().map(|at| &self.fit.set().frfs[*at].lines);
        let ends = |(low, high): (f64, f64), lines: &Vec<FrfLine>| match (lines.first(), lines.last()) {
            (Some(first), Some(last)) => (low.min(first.frequency_hz), high.max(last.frequency_hz)),
            _ => (low, high),
        };
        let (low, high) = frfs.fold((f64::INFINITY, 0.0), ends);
        Some((low.max(settings.band_hz.0), high.min(settings.band_hz.1)))
    }

    /// Whether the data to fit cover more than one value of an operating variable.
    pub(super) fn varies(&self, variable: OperatingVariable) -> bool {
        let Domain::Frf(_) = self.domain else { return false };
        let set = self.fit.set();
        let values = self.fit.frfs().iter().map(|at| variable.size(&operating(set, &set.frfs[*at])));
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low > 1e-3
    }

    /// Returns the fitter without nuisance parameters: nut positions, gains and delays as stated.
    #[must_use]
    pub(super) fn without_nuisances(&self) -> Self {
        let domain = match self.domain {
            Domain::Frf(settings) if self.has_nuisances() => Domain::Frf(settings.as_stated()),
            same => same,
        };
        Fitter { domain, ..self.clone() }
    }

    /// Whether nuisance parameters are fitted: modes are too few for them.
    pub(super) fn has_nuisances(&self) -> bool {
        matches!(self.domain, Domain::Frf(_)) && !self.lacks(Ablation::NoNuisances)
    }

    /// Returns the fitter for other data of the set.
    #[must_use]
    pub(super) fn on(&self, fit: FitSet<'s>) -> Self {
        Fitter { fit, ..self.clone() }
    }

    /// Returns the blocks of cross-validation over positions (or records): retained and left-out data.
    pub(super) fn blocks(&self) -> Vec<(FitSet<'s>, FitSet<'s>)> {
        self.fit.blocks(matches!(self.domain, Domain::Frf(_)))
    }

    /// Returns the objective of a hypothesis. A parameter that the hypothesis releases is not frozen.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn objective<'h>(
        &self,
        hypothesis: &'h Hypothesis,
    ) -> Result<DomainObjective<'h>, ObjectiveError> {
        DomainObjective::new(hypothesis, &self.fit, self.domain, &self.frozen_in(hypothesis))
    }

    /// Returns the objective of a hypothesis on held-out FRFs: for their likelihood, or for simulated
    /// records.
    ///
    /// # Errors  as [`DomainObjective::for_held_out`].
    pub(super) fn objective_for_held_out<'h>(
        &self,
        hypothesis: &'h Hypothesis,
        held_out: &HoldOutSet<'_>,
    ) -> Result<DomainObjective<'h>, ObjectiveError> {
        DomainObjective::for_held_out(hypothesis, held_out, self.domain, &self.frozen_in(hypothesis))
    }

    /// Returns the frozen parameters that a hypothesis does not release.
    fn frozen_in(&self, hypothesis: &Hypothesis) -> Vec<String> {
        let released: Vec<&String> =
            hypothesis.added.iter().map(|i| &hypothesis.machine.parameters[*i].id).collect();
        self.frozen.iter().filter(|id| !released.contains(id)).cloned().collect()
    }

    /// Returns an objective on the few lines of first fits; `None` for modes.
    pub(super) fn coarse<'h>(&self, objective: &DomainObjective<'h>) -> Option<DomainObjective<'h>> {
        objective.coarse(self.lines_of_one(COARSE))
    }

    /// Minimises χ² from given coordinates.
    pub(super) fn descend(
        &self,
        objective: &DomainObjective<'_>,
        from: &Fitted,
        steps: u64,
        control: &Control,
    ) -> Fitted {
        self.descend_until(objective, from, (steps, TOLERANCE), control)
    }

    /// Minimises χ² up to a number of steps or until a step reduces it by less than a share: joints in series
    /// form long valleys.
    pub(super) fn descend_until(
        &self,
        objective: &DomainObjective<'_>,
        from: &Fitted,
        end: (u64, f64),
        control: &Control,
    ) -> Fitted {
        if control.stopped() {
            return from.clone();
        }
        let place = coordinates_of(objective, from);
        let polished =
            objective.squares(|squares| least_squares_within(squares, &place, &[], end, control.stop()));
        read_back(objective, from, &Place(polished.place), polished.normal.chi_square)
    }

    /// Fits a hypothesis from fits of the nominal machine. Amplitudes over their whole ranges are evaluated,
    /// the best followed on coarse lines, and the best of these on all lines. χ² cannot rise above that of
    /// the first base: the effect with amplitude zero is among the starts.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn fit(
        &self,
        hypothesis: &Hypothesis,
        bases: &[Fitted],
        control: &Control,
    ) -> Result<Fitted, ObjectiveError> {
        control.try_cached(&self.cache_key("fit", hypothesis, bases), || {
            self.fit_uncached(hypothesis, bases, control)
        })
    }

    /// Returns the key of a calculation on these data, under which its result is stored.
    pub(super) fn cache_key(&self, what: &str, hypothesis: &Hypothesis, bases: &[Fitted]) -> String {
        format!("{what} {} {:?} {:?} {bases:?}", hypothesis.id(), self.fit.positions(), self.fit.frfs())
    }

    fn fit_uncached(
        &self,
        hypothesis: &Hypothesis,
        bases: &[Fitted],
        control: &Control,
    ) -> Result<Fitted, ObjectiveError> {
        if control.stopped() {
            return Err(ObjectiveError::Data("stopped before this candidate was fitted".into()));
        }
        let objective = self.objective(hypothesis)?;
        let coarse = self.coarse(&objective);
        let few = coarse.as_ref().unwrap_or(&objective);
        let without_effect = start_of(hypothesis, &bases[0], &[]);
        let most = FOLLOWED.0 + FOLLOWED.1 * sought(hypothesis, &bases[0]).len();
        let followed = best_starts((few, coarse.is_some()), hypothesis, bases, most);
        let starts = followed.iter().chain(std::iter::once(&without_effect));
        let mut ends: Vec<Fitted> =
            starts.map(|start| self.descend(few, start, COARSE_STEPS, control)).collect();
        ends.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        let mut best = ends.swap_remove(0);
        let found = 1 + ends
            .iter()
            .filter(|end| close(&end.units, &best.units) || end.chi_square < best.chi_square + IMPROVEMENT)
            .count();
        if coarse.is_some() {
            best = self.descend(&objective, &best, STEPS, control);
            if best.chi_square > bases[0].chi_square {
                let near = self.descend(&objective, &without_effect, STEPS, control);
                best = if near.chi_square < best.chi_square { near } else { best };
            }
        }
        Ok(Fitted { found, ..best })
    }

    /// Fits a hypothesis from other joints than its known fit came from. Returns a deeper minimum, or the
    /// known one found once more; `None` where the joints lead elsewhere.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn improved(
        &self,
        hypothesis: &Hypothesis,
        known: &Fitted,
        joints: &[Fitted],
        control: &Control,
    ) -> Result<Option<Fitted>, ObjectiveError> {
        let bases: Vec<Fitted> = std::iter::once(known).chain(joints).cloned().collect();
        control.try_cached(&self.cache_key("improved", hypothesis, &bases), || {
            let objective = self.objective(hypothesis)?;
            let coarse = self.coarse(&objective);
            let few = coarse.as_ref().unwrap_or(&objective);
            let thin = objective.coarse(self.lines_of_one(MULTISTART_LINES));
            let ends =
                best_starts((thin.as_ref().unwrap_or(few), coarse.is_some()), hypothesis, joints, FOLLOWED.0);
            let ends = ends.iter().map(|start| self.descend(few, start, COARSE_STEPS, control));
            let Some(best) = ends.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square)) else {
                return Ok(None);
            };
            let there = self.descend(few, known, COARSE_STEPS, control);
            if close(&best.units, &there.units) {
                return Ok(Some(Fitted { found: known.found + 1, ..known.clone() }));
            }
            if best.chi_square >= there.chi_square {
                return Ok(None);
            }
            let end = if coarse.is_some() { self.descend(&objective, &best, STEPS, control) } else { best };
            Ok((end.chi_square < known.chi_square).then_some(Fitted { found: 1, ..end }))
        })
    }

    /// Returns the least χ² predicted by one linear step from any amplitude, on coarse lines.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn predicted_cost(
        &self,
        hypothesis: &Hypothesis,
        base: &Fitted,
        control: &Control,
    ) -> Result<f64, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let coarse = self.coarse(&objective);
        let few = coarse.as_ref().unwrap_or(&objective);
        let cost = |start: Fitted| {
            few.squares(|squares| squares.normal(&coordinates_of(few, &start)).cost_after_step(TRUST_RADIUS))
        };
        Ok(trial_starts(hypothesis, base)
            .take_while(|_| !control.stopped())
            .map(cost)
            .fold(f64::INFINITY, f64::min))
    }

    /// Returns χ² of other data of the set with the parameters of a fit and nut positions as stated.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn loss(&self, hypothesis: &Hypothesis, fitted: &Fitted) -> Result<f64, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let mut place = coordinates_of(&objective, fitted);
        place[objective.nut_coordinates()].iter_mut().for_each(|u| *u = 0.5);
        Ok(objective.residuals(&place).norm_squared())
    }

    /// Returns the estimated tolerances of a fit; none where tolerances are not fitted.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub(super) fn tolerances(
        &self,
        hypothesis: &Hypothesis,
        fitted: &Fitted,
    ) -> Result<Vec<ToleranceEstimate>, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let place = coordinates_of(&objective, fitted);
        Ok(match &objective {
            DomainObjective::Frf(objective) if self.has_nuisances() => {
                tolerances_at(objective, self.fit.set(), &place)
            }
            _ => Vec::new(),
        })
    }

    /// Returns the gaps of data with the parameters of a fit.
    ///
    /// # Errors  as [`gaps`].
    pub(super) fn gaps(
        &self,
        hypothesis: &Hypothesis,
        fitted: &Fitted,
        data: &HoldOutSet<'_>,
    ) -> Result<Vec<PartialGap>, ObjectiveError> {
        let own = self.objective(hypothesis)?;
        let gain = own.gain(&coordinates_of(&own, fitted));
        gaps(hypothesis, &values_of(hypothesis, fitted), gain, data, self.domain)
    }
}

/// Returns the parameter values of a fit.
pub fn values_of(hypothesis: &Hypothesis, fitted: &Fitted) -> ParameterValues {
    hypothesis.machine.from_units(&fitted.units)
}

/// Returns the start values of a machine as a fit.
pub fn at_start(hypothesis: &Hypothesis) -> Fitted {
    let units = hypothesis.machine.to_units(&hypothesis.machine.start());
    Fitted { units, tail: Tail::default(), chi_square: f64::INFINITY, found: 1 }
}

/// Returns the coordinates of a fit in the unit cube of an objective. For other data than those of the fit,
/// gain and channels are kept and nut positions start as stated. An unknown gain starts at its best value.
pub(super) fn coordinates_of(objective: &DomainObjective<'_>, fitted: &Fitted) -> Place {
    let mut place: Vec<f64> = objective.free().iter().map(|i| fitted.units[*i]).collect();
    if fitted.tail.is_empty() {
        return objective.extended(&place);
    }
    let nuts = objective.nut_coordinates();
    let rest = objective.dimension() - nuts.end;
    let gain = nuts.start - place.len();
    let same_data = fitted.tail.len() == gain + nuts.len() + rest;
    place.extend(fitted.tail.iter().take(gain));
    if same_data {
        place.extend(fitted.tail.iter().skip(gain));
    } else {
        place.extend(std::iter::repeat_n(0.5, nuts.len()));
        place.extend(fitted.tail.iter().skip(fitted.tail.len().saturating_sub(rest)));
    }
    Place(place)
}

pub(super) fn read_back(
    objective: &DomainObjective<'_>,
    from: &Fitted,
    place: &Place,
    chi_square: f64,
) -> Fitted {
    let mut units = from.units.clone();
    for (&index, &u) in objective.free().iter().zip(place) {
        units[index] = u;
    }
    Fitted { units, tail: Tail(place[objective.free().len()..].to_vec()), chi_square, found: from.found }
}

/// Returns the added parameters that a fit of the machine without the last addition leaves open: those of
/// that addition. A released parameter is part of every fit; it is sought again.
pub(super) fn sought(hypothesis: &Hypothesis, joints: &Fitted) -> Vec<usize> {
    let new: Vec<usize> =
        hypothesis.added.iter().copied().filter(|index| *index >= joints.units.len()).collect();
    if new.is_empty() { hypothesis.added.clone() } else { new }
}

/// Returns a start of a hypothesis from some joints with each trial amplitude of what is sought.
fn trial_starts(hypothesis: &Hypothesis, joints: &Fitted) -> impl Iterator<Item = Fitted> {
    let sought = sought(hypothesis, joints);
    let described: Vec<&Parameter> =
        sought.iter().map(|index| &hypothesis.machine.parameters[*index]).collect();
    amplitudes(&described).into_iter().map(move |units| start_at(hypothesis, joints, &sought, &units))
}

/// Returns the most promising starts of a hypothesis from some joints: of all amplitudes the distinct ones of
/// the least χ², predicted by one linear step where derivatives are cheap, else evaluated. From all joints
/// but the first only the amplitudes that are promising there are tried.
fn best_starts(
    (few, is_linear): (&DomainObjective<'_>, bool),
    hypothesis: &Hypothesis,
    joints: &[Fitted],
    most: usize,
) -> Vec<Fitted> {
    let cost = |start: &Fitted| {
        let place = coordinates_of(few, start);
        few.squares(|squares| {
            if is_linear {
                squares.normal(&place).cost_after_step(TRUST_RADIUS)
            } else {
                squares.chi_square(&place)
            }
        })
    };
    let [first, others @ ..] = joints else { return Vec::new() };
    let mut starts: Vec<(f64, Fitted)> =
        trial_starts(hypothesis, first).map(|start| (cost(&start), start)).collect();
    let promising = if others.is_empty() { Vec::new() } else { distinct(&mut starts, PROMISING * most) };
    let sought = sought(hypothesis, first);
    let units = |start: &Fitted| sought.iter().map(|at| start.units[*at]).collect::<Vec<f64>>();
    let from_others = others.iter().flat_map(|joints| {
        promising.iter().map(|start| start_at(hypothesis, joints, &sought, &units(start)))
    });
    starts.extend(from_others.map(|start| (cost(&start), start)));
    distinct(&mut starts, most)
}

/// Returns the starts of the least χ², as many as asked: neighbouring ones end in the same minimum.
fn distinct(starts: &mut [(f64, Fitted)], most: usize) -> Vec<Fitted> {
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut followed: Vec<Fitted> = Vec::new();
    for (_, start) in starts.iter() {
        let distant = |other: &Fitted| {
            other.units.iter().zip(&start.units).any(|(a, b)| (a - b).abs() > LEAST_DISTANCE)
        };
        if followed.iter().all(distant) {
            followed.push(start.clone());
        }
        if followed.len() == most {
            break;
        }
    }
    followed
}

/// Returns the distinct minima among fits in rising order of χ². Two fits are one minimum where the parabola
/// about the better one rises by less than the 95 % quantile of χ² to the other: coordinates that the data do
/// not determine separate none.
pub(super) fn distinct_minima(objective: &DomainObjective<'_>, fits: Vec<Fitted>) -> Vec<Fitted> {
    let mut distinct: Vec<(Fitted, Surroundings)> = Vec::new();
    for fit in fits {
        let place = coordinates_of(objective, &fit);
        if !distinct.iter().any(|(_, around)| around.hold(&place, CHI_SQUARE_95)) {
            let information = Some(objective.squares(|squares| squares.normal(&place).information));
            distinct.push((fit, Surroundings { place, information }));
        }
    }
    distinct.into_iter().map(|(fit, _)| fit).collect()
}

/// Whether two fits are one minimum: the largest difference of a coordinate is below 2 % of its range.
pub(super) fn close(a: &UnitValues, b: &UnitValues) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02)
}

/// Returns a nominal fit extended by added parameters at given coordinates.
pub(super) fn start_of(hypothesis: &Hypothesis, base: &Fitted, added: &[f64]) -> Fitted {
    start_at(hypothesis, base, &hypothesis.added, added)
}

/// Returns a nominal fit extended by all other parameters at their start, with some parameters at given
/// coordinates.
fn start_at(hypothesis: &Hypothesis, base: &Fitted, parameters: &[usize], at: &[f64]) -> Fitted {
    let described = &hypothesis.machine.parameters;
    let mut units = base.units.clone();
    units.0.extend(described.iter().skip(base.units.len()).map(|p| p.to_unit(p.start)));
    for (&index, &u) in parameters.iter().zip(at) {
        units[index] = u;
    }
    Fitted { units, tail: base.tail.clone(), chi_square: f64::INFINITY, found: 1 }
}
