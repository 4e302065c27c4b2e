//! Measurement planning: the information that each candidate measurement would add.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::tolerance::nut_columns;
use super::uncertainty::{RANGE_SD, certainty, narrow_width};
use crate::objective::{
    FrfObjective, FrfSettings, ModeObjective, ModeSettings, ModeSquares, ObjectiveError, VISIBLE,
};
use dynamics::model::{PeakSearch, Structure, peaks};
use machine::{Chain, Machine, Operating, ParameterValues, State};
use measurement::{
    Condition, FitSet, Frf, FrfLine, FrfNoise, MeasurementSet, ModeObservation, ModeTable, Quantity,
};
use numeric::unit::omega_rad_s;
use optimizer::{LeastSquares, NormalEquations};

/// A candidate measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedMeasurement {
    /// Position, by index in the set; `None` where the machine has none.
    pub position: Option<usize>,
    /// Point that responds and point that is excited.
    pub channel: (String, String),
    /// Operating state.
    pub state: State,
    /// Information JᵀJ that it adds, in the unit intervals of the columns of the design.
    pub information: DMatrix<f64>,
}

/// A selection of candidates and the remaining uncertainty of the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Indices of the candidates, in order.
    pub candidates: Vec<usize>,
    /// Standard deviation of each free parameter in its unit interval, with the plausible range as prior.
    pub sd: Vec<f64>,
    /// Geometric mean over the parameters of posterior over prior standard deviation (1); 1 if the
    /// measurements add no information.
    pub score: f64,
    /// Root mean square of the relative standard deviations of the numbers to predict (1); `None` where
    /// nothing is to be predicted.
    pub prediction_sd: Option<f64>,
}

/// The candidates of a plan and the parameters that they are to determine.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanDesign {
    /// Candidate measurements.
    pub candidates: Vec<PlannedMeasurement>,
    /// Indices of the parameters to determine: the first columns.
    pub free: Vec<usize>,
    /// Indices of all parameters, column by column: those to determine, then tolerances and others.
    columns: Vec<usize>,
    /// Prior information on each column: tolerances, and `sd` of the machine's parameters.
    prior_information: Vec<f64>,
    /// Width of the widest 95 % interval with which each parameter is identifiable, in its unit interval.
    pub narrow_widths: Vec<f64>,
    /// Numbers to predict: derivatives of their logarithms with respect to the unit intervals of the
    /// parameters. Empty: the parameters alone count.
    pub predicted: Vec<Vec<f64>>,
}

/// Noise and lines of a planned FRF measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfPlan {
    /// Relative standard deviation of each line (total, complex).
    pub noise: f64,
    /// Lowest and highest line (Hz).
    pub band_hz: (f64, f64),
    /// Number of lines.
    pub lines: usize,
}

impl PlanDesign {
    /// Plans FRFs of the given channels at all positions of a set and in the given states, predicted by the
    /// machine with the given parameter values.
    ///
    /// The tolerances of machine, nut positions and channels are nuisance parameters, as in an
    /// identification.
    ///
    /// # Errors  as [`FrfObjective::new`]; the machine has no such state.
    pub fn of_frfs(
        machine: &Machine,
        values: &ParameterValues,
        set: &MeasurementSet,
        among: (&[(String, String)], &[State]),
        plan: FrfPlan,
        settings: FrfSettings,
        frozen: &[String],
    ) -> Result<Self, ObjectiveError> {
        let (machine, values) = with_tolerances(machine, values, set)?;
        let settings = settings.with_tolerances(&set.tolerance);
        let (made, in_states) = planned_frfs(&machine, &values, set, among, plan)?;
        let mut design = PlanDesign::empty();
        let Ok((all, _)) = made.split(None, &[]) else { return Ok(design) };
        let (mut found, mut gain) = (Vec::new(), 0);
        for (index, (_, machine)) in (0..made.frfs.len()).zip(in_states.iter().cycle()) {
            let fit = all.with_frfs(|at| at == index);
            let objective = FrfObjective::new(machine, &fit, settings, frozen)?;
            let place = objective.extended(&coordinates_of(machine, &objective.free, &values, false));
            let information = objective.without_nuts(objective.normal(&place).information);
            let mut prior = prior_information(machine, &objective.free, &values);
            gain = usize::from(objective.estimates_gain());
            prior.extend(std::iter::repeat_n(0.0, gain));
            prior.resize(information.nrows(), FrfObjective::NUISANCE_INFORMATION);
            found.push((without_prior(information, &prior), objective.free.clone()));
        }
        // A state may leave a parameter without effect, which is then no coordinate of its objective.
        design.columns = union(found.iter().map(|(_, free)| &free[..]));
        // Each channel has a gain and a delay of its own, unless both are exact.
        let calibration = found.first().map_or(0, |(own, free)| own.nrows() - free.len() - gain);
        let is_described = |i: &usize| !machine.parameters[*i].is_tolerance();
        design.free = design.columns.iter().copied().filter(is_described).collect();
        design.state_priors(&machine, &values);
        let places = (0..made.frfs.len()).zip(in_states.iter().cycle());
        for ((index, (state, _)), (information, free)) in places.zip(found) {
            let frf = &made.frfs[index];
            let channel = (frf.response.clone(), frf.excitation.clone());
            let nth = among.0.iter().position(|other| *other == channel).unwrap_or(0);
            let first = design.columns.len();
            let own = first + gain + calibration * nth;
            let mut columns = columns_of(&free, &design.columns);
            columns.extend((first..first + gain).chain(own..own + calibration));
            design.candidates.push(PlannedMeasurement {
                position: frf.position,
                channel,
                state: *state,
                information: spread(&information, &columns, first + gain + calibration * among.0.len()),
            });
        }
        design.prior_information.extend(std::iter::repeat_n(0.0, gain));
        design
            .prior_information
            .extend(std::iter::repeat_n(FrfObjective::NUISANCE_INFORMATION, calibration * among.0.len()));
        Ok(design)
    }

    /// Plans natural frequencies and amplitudes at all positions of a set: all visible peaks of the band.
    ///
    /// They are predicted by the machine with the given parameter values.
    ///
    /// # Errors  as [`ModeObjective::new`].
    pub fn of_modes(
        machine: &Machine,
        values: &ParameterValues,
        set: &MeasurementSet,
        channel: &(String, String),
        band_hz: (f64, f64),
        settings: ModeSettings,
        frozen: &[String],
    ) -> Result<Self, ObjectiveError> {
        let mut made = set.clone();
        made.split = None;
        (made.response, made.excitation) = (Some(channel.0.clone()), Some(channel.1.clone()));
        let bare = machine;
        let (toleranced, values) = with_tolerances(bare, values, set)?;
        let (machine, values) = (&toleranced, &values);
        let structure = structure(machine, channel, settings.rods)?;
        let power = set.quantity.map_or(0, Quantity::power);
        let search = PeakSearch { from_hz: band_hz.0, to_hz: band_hz.1, precision: 1e-7, omega_power: power };
        let mut table = ModeTable { positions: Vec::new(), ..set.modes.clone().unwrap_or_default() };
        let least = table.least_prominence.unwrap_or(VISIBLE);
        // Nothing is learned from peaks that are not listed: with this limit none of them is half visible.
        table.least_prominence = Some(2.0 * least - 1.0);
        for place in &set.positions {
            let operating = Operating { nut_m: place.nut_m, ..Operating::default() };
            machine.check_operating(&format!("{}: position {}", set.path, place.name), &operating)?;
            let mut model = structure.empty_model();
            model.update(machine, values, &operating);
            let visible = peaks(&model, search, &mut structure.workspace())
                .into_iter()
                .filter(|p| p.prominence >= least);
            let observed = |(order, p): (usize, dynamics::model::Peak)| ModeObservation {
                order: order as u32 + 1,
                frequency_hz: Some(p.frequency_hz),
                frequency_sd_hz: None,
                amplitude: Some(p.amplitude),
            };
            table.positions.push(visible.enumerate().map(observed).collect());
        }
        made.modes = Some(table);
        let mut design = PlanDesign::empty();
        let Ok((all, _)) = made.split(None, &[]) else { return Ok(design) };
        for position in 0..set.positions.len() {
            let fit = all.with_positions(|at| at == position);
            // Tolerances, and what modes hardly determine, are free beside the parameters to determine.
            let own = ModeObjective::new(bare, &fit, settings, frozen)?.free;
            let first = ModeObjective::new(machine, &fit, settings, frozen)?.free;
            let objective = ModeObjective::with_all_free(machine, &fit, settings, frozen, &first)?;
            let place = objective.extended(&coordinates_of(machine, &objective.free, values, false));
            let made = |fit: &FitSet<'_>| ModeObjective::new(machine, fit, settings, frozen);
            let nuts = nut_columns(&fit, &made, values, objective.gain(&place))?;
            let objective = objective.correlated(&nuts);
            let others = objective.free.iter().copied().filter(|index| !own.contains(index));
            design.columns = own.iter().copied().chain(others).collect();
            design.free = own;
            design.state_priors(machine, values);
            let information = without_prior(
                ModeSquares::new(&objective, None).normal(&place).information,
                &prior_information(machine, &objective.free, values),
            );
            let size = information.nrows();
            let mut columns = columns_of(&objective.free, &design.columns);
            columns.extend(design.columns.len()..size);
            let information = spread(&information, &columns, size);
            design.candidates.push(PlannedMeasurement {
                position: Some(position),
                channel: channel.clone(),
                state: State::Described,
                information,
            });
        }
        Ok(design)
    }

    /// Notes prior information on all columns, and narrow widths of the parameters to determine.
    fn state_priors(&mut self, machine: &Machine, values: &ParameterValues) {
        self.prior_information = prior_information(machine, &self.columns, values);
        self.narrow_widths =
            self.free.iter().map(|i| narrow_width(&machine.parameters, values, *i)).collect();
    }

    /// Whether a choice would make the parameter of a column identifiable.
    pub fn is_identifiable(&self, choice: &Choice, column: usize) -> bool {
        2.0 * 1.96 * choice.sd[column] <= self.narrow_widths[column]
    }

    /// Computes the uncertainty that remains after these candidates.
    pub fn choice(&self, which: &[usize]) -> Choice {
        let size = self.candidates.first().map_or(0, |c| c.information.nrows());
        let mut information = DMatrix::zeros(size, size);
        which.iter().for_each(|i| information += &self.candidates[*i].information);
        self.prior_information
            .iter()
            .enumerate()
            .for_each(|(column, prior)| information[(column, column)] += prior);
        let found = certainty(&information, 1.0);
        let variance = |slopes: &Vec<f64>| -> f64 {
            let term = |(row, a): (usize, &f64)| {
                slopes
                    .iter()
                    .enumerate()
                    .map(|(column, b)| a * b * found.covariance[(row, column)])
                    .sum::<f64>()
            };
            slopes.iter().enumerate().map(term).sum()
        };
        let mean = self.predicted.iter().map(variance).sum::<f64>() / self.predicted.len() as f64;
        let sd: Vec<f64> = found.sd.into_iter().take(self.free.len()).collect();
        let score = (sd.iter().map(|s| (s / RANGE_SD).ln()).sum::<f64>() / sd.len().max(1) as f64).exp();
        Choice {
            candidates: which.to_vec(),
            sd,
            score,
            prediction_sd: (!self.predicted.is_empty()).then(|| mean.max(0.0).sqrt()),
        }
    }

    /// Ranks all choices of `count` candidates in addition to the measurements `made`. The least remaining
    /// uncertainty comes first: that of the numbers to predict, where there are any, else that of the
    /// parameters.
    pub fn ranking(&self, made: &[usize], count: usize) -> Vec<Choice> {
        let open: Vec<usize> = (0..self.candidates.len()).filter(|i| !made.contains(i)).collect();
        let mut choices: Vec<Choice> = subsets(&open, count)
            .into_iter()
            .map(|added| {
                let all: Vec<usize> = made.iter().copied().chain(added.iter().copied()).collect();
                Choice { candidates: added, ..self.choice(&all) }
            })
            .collect();
        let rank = |choice: &Choice| choice.prediction_sd.unwrap_or(choice.score);
        choices.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
        choices
    }

    fn empty() -> Self {
        PlanDesign {
            candidates: Vec::new(),
            free: Vec::new(),
            columns: Vec::new(),
            prior_information: Vec::new(),
            narrow_widths: Vec::new(),
            predicted: Vec::new(),
        }
    }

    /// Returns the number of choices of `count` candidates in addition to `made`.
    pub fn choices(&self, made: usize, count: usize) -> f64 {
        let open = self.candidates.len().saturating_sub(made);
        (0..count).map(|i| (open as f64 - i as f64).max(0.0) / (i as f64 + 1.0)).product()
    }
}

/// Returns the parameters of all objectives, each once, in ascending order.
pub(super) fn union<'f>(all: impl Iterator<Item = &'f [usize]>) -> Vec<usize> {
    all.flatten().copied().collect::<std::collections::BTreeSet<usize>>().into_iter().collect()
}

/// Returns normal equations of some parameters, and of a gain where there is one, as those of more
/// parameters. The gain stays last.
pub(super) fn embedded(normal: &NormalEquations, own: &[usize], all: &[usize]) -> NormalEquations {
    let gains = normal.gradient.len() - own.len();
    let columns = [columns_of(own, all), (all.len()..all.len() + gains).collect()].concat();
    let mut whole = NormalEquations::zero(all.len() + gains);
    whole.chi_square = normal.chi_square;
    columns.iter().enumerate().for_each(|(row, i)| whole.gradient[*i] = normal.gradient[row]);
    whole.information = spread(&normal.information, &columns, all.len() + gains);
    whole
}

/// Returns the columns of parameters among those of all.
fn columns_of(own: &[usize], all: &[usize]) -> Vec<usize> {
    own.iter().filter_map(|index| all.iter().position(|other| other == index)).collect()
}

/// Returns the prior information on each free parameter, in its unit interval.
pub(super) fn prior_information(machine: &Machine, free: &[usize], values: &ParameterValues) -> Vec<f64> {
    let of =
        |i: &usize| machine.parameters[*i].deviation_slope(values[*i]).map_or(0.0, |slope| slope.powi(2));
    free.iter().map(of).collect()
}

/// Returns the machine with its tolerances as parameters, and their stated values after those given.
fn with_tolerances(
    machine: &Machine,
    values: &ParameterValues,
    set: &MeasurementSet,
) -> Result<(Machine, ParameterValues), ObjectiveError> {
    let toleranced = machine.with_tolerances(&set.nuts_m())?;
    let stated = toleranced.parameters.iter().skip(values.len()).map(|p| p.start);
    let values = ParameterValues(values.iter().copied().chain(stated).collect());
    Ok((toleranced, values))
}

/// Returns information on some columns as information on `size` columns.
fn spread(information: &DMatrix<f64>, columns: &[usize], size: usize) -> DMatrix<f64> {
    let mut whole = DMatrix::zeros(size, size);
    for (row, i) in columns.iter().enumerate() {
        columns.iter().enumerate().for_each(|(column, j)| whole[(*i, *j)] = information[(row, column)]);
    }
    whole
}

/// Subtracts the prior information from that of a measurement: the prior counts once per plan, not once per
/// measurement.
fn without_prior(mut information: DMatrix<f64>, prior: &[f64]) -> DMatrix<f64> {
    prior.iter().enumerate().for_each(|(column, prior)| information[(column, column)] -= prior);
    information
}

fn structure(
    machine: &Machine,
    channel: &(String, String),
    rods: dynamics::model::RodModel,
) -> Result<Arc<Structure>, ObjectiveError> {
    let named = |name: &String| {
        machine.point(name).ok_or_else(|| {
            let known: Vec<&str> = machine.points.iter().map(|p| p.name.as_str()).collect();
            ObjectiveError::Data(format!(
                "the machine has no point «{name}»; its points are {}",
                known.join(", ")
            ))
        })
    };
    Ok(Arc::new(Structure::new(machine, named(&channel.0)?, named(&channel.1)?, rods)?))
}

/// Returns the set with the FRFs of all positions, channels and states as predicted, the states innermost;
/// and each state with its machine.
pub(super) fn planned_frfs(
    machine: &Machine,
    values: &ParameterValues,
    set: &MeasurementSet,
    (channels, states): (&[(String, String)], &[State]),
    plan: FrfPlan,
) -> Result<(MeasurementSet, Vec<(State, Machine)>), ObjectiveError> {
    let mut made = set.clone();
    made.frfs.clear();
    made.split = None;
    let mut places: Vec<(Option<usize>, Option<f64>)> =
        set.positions.iter().enumerate().map(|(at, p)| (Some(at), p.nut_m)).collect();
    if places.is_empty() {
        places.push((None, None));
    }
    let in_states = states
        .iter()
        .map(|state| Ok((*state, machine.in_state(*state)?)))
        .collect::<Result<Vec<_>, ObjectiveError>>()?;
    for place in places {
        for (response, excitation) in channels {
            for (state, machine) in &in_states {
                made.frfs.push(predicted_frf(
                    machine,
                    values,
                    (place, *state),
                    (response, excitation),
                    plan,
                )?);
            }
        }
    }
    Ok((made, in_states))
}

fn predicted_frf(
    machine: &Machine,
    values: &ParameterValues,
    ((position, nut_m), state): ((Option<usize>, Option<f64>), State),
    (response, excitation): (&String, &String),
    plan: FrfPlan,
) -> Result<Frf, ObjectiveError> {
    let structure =
        structure(machine, &(response.clone(), excitation.clone()), dynamics::model::RodModel::Exact)?;
    let operating = Operating { nut_m, level_n: state.level_n(), ..Operating::default() };
    machine.check_operating("plan", &operating)?;
    let (mut model, mut work) = (structure.empty_model(), structure.workspace());
    model.update(machine, values, &operating);
    let chain = machine.chain.at(values, &operating);
    let step = (plan.band_hz.1 - plan.band_hz.0) / plan.lines.saturating_sub(1).max(1) as f64;
    let lines = (0..plan.lines)
        .map(|line| {
            let frequency_hz = plan.band_hz.0 + step * line as f64;
            let omega = omega_rad_s(frequency_hz);
            let value = model.receptance(omega, &mut work) * Chain::log_factor(chain, omega).exp();
            FrfLine { frequency_hz, value, noise: Some(FrfNoise::RelativeSd(plan.noise)) }
        })
        .collect();
    Ok(Frf {
        position,
        record: None,
        response: response.clone(),
        excitation: excitation.clone(),
        quantity: Quantity::Receptance,
        condition: Condition { force_level_n: state.level_n(), ..Condition::default() },
        averages: None,
        source: format!("plan: {response}/{excitation}"),
        lines,
        rejected: Vec::new(),
    })
}

/// Returns the unit-cube coordinates of parameter values, with an unknown gain in the middle of its range.
pub(super) fn coordinates_of(
    machine: &Machine,
    free: &[usize],
    values: &ParameterValues,
    gain: bool,
) -> Vec<f64> {
    let mut place: Vec<f64> = free.iter().map(|i| machine.parameters[*i].to_unit(values[*i])).collect();
    place.extend(gain.then_some(0.5));
    place
}

/// Returns all subsets of `count` members, in lexicographic order.
fn subsets(members: &[usize], count: usize) -> Vec<Vec<usize>> {
    if count == 0 {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for (at, first) in members.iter().enumerate() {
        for rest in subsets(&members[at + 1..], count - 1) {
            let mut subset = vec![*first];
            subset.extend(rest);
            all.push(subset);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_subsets_are_counted_by_binomials() {
        let members = [0, 1, 2, 3, 4, 5];
        assert_eq!(subsets(&members, 3).len(), 20);
        assert_eq!(subsets(&members, 0), [Vec::<usize>::new()]);
        assert!(subsets(&members[..2], 3).is_empty());
    }

    fn design(informations: &[[f64; 2]]) -> PlanDesign {
        let candidate = |(position, d): (usize, &[f64; 2])| PlannedMeasurement {
            position: Some(position),
            channel: ("a".into(), "a".into()),
            state: State::Described,
            information: DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(d)),
        };
        PlanDesign {
            candidates: informations.iter().enumerate().map(candidate).collect(),
            free: vec![0, 1],
            columns: vec![0, 1],
            prior_information: vec![0.0, 0.0],
            narrow_widths: vec![0.05, 0.05],
            predicted: Vec::new(),
        }
    }

    #[test]
    fn complementary_measurements_rank_above_redundant_ones() {
        let design = design(&[[1e6, 0.0], [1e6, 0.0], [0.0, 1e6]]);
        let ranking = design.ranking(&[], 2);
        assert!(ranking[0].candidates == [0, 2] || ranking[0].candidates == [1, 2], "{ranking:?}");
        assert_eq!(ranking[2].candidates, [0, 1]);
        assert!(design.is_identifiable(&ranking[2], 0) && !design.is_identifiable(&ranking[2], 1));
    }

    #[test]
    fn limit_embedded_equations_keep_their_numbers() {
        let mut own = NormalEquations::zero(3);
        own.chi_square = 7.0;
        own.gradient.copy_from_slice(&[1.0, 2.0, 3.0]);
        own.information = DMatrix::from_fn(3, 3, |i, j| (10 * i + j) as f64);
        assert_eq!(union([&[1, 5][..], &[2, 5]].into_iter()), [1, 2, 5]);
        let whole = embedded(&own, &[1, 5], &[1, 2, 5]);
        assert_eq!((whole.chi_square, whole.gradient.as_slice()), (7.0, &[1.0, 0.0, 2.0, 3.0][..]));
        assert_eq!(
            (whole.information[(3, 2)], whole.information[(2, 0)], whole.information[(1, 1)]),
            (21.0, 10.0, 0.0)
        );
    }

    #[test]
    fn measured_candidates_are_not_ranked_again() {
        let ranking = design(&[[1e6, 0.0], [1e6, 0.0], [0.0, 1e6]]).ranking(&[0], 1);
        assert_eq!(ranking[0].candidates, [2]);
        assert_eq!(ranking.len(), 2);
    }

    /// What is predicted depends on the second parameter alone, with a known interval.
    #[test]
    fn limit_predictions_decide_the_ranking_where_they_are_named() {
        let of_second = PlanDesign { predicted: vec![vec![0.0, 0.5]], ..design(&[[1e8, 1e2], [0.0, 1e4]]) };
        let ranking = of_second.ranking(&[], 1);
        assert_eq!(ranking[0].candidates, [1]);
        assert!(ranking[0].score > ranking[1].score);
        // Information 1e4 and that of the range, 12.
        let sd = 0.5 / (1e4_f64 + 12.0).sqrt();
        assert!((ranking[0].prediction_sd.unwrap() / sd - 1.0).abs() < 1e-9, "{ranking:?}");
    }
}
