//! Data of a diagnosis, FRFs or modes, behind one interface.

use nalgebra::{DMatrix, DVector};

use super::data_kind::DataKind;
use super::hypothesis::Hypothesis;
use identification::Place;
use identification::objective::{
    Deviation, FrfGap, FrfObjective, FrfSettings, MISSING, ModeObjective, ModeSettings, ModeSquares,
    ObjectiveError, PositionPrediction,
};
use machine::ParameterValues;
use measurement::{FitSet, HoldOutSet};
use numeric::statistics::{root_mean_square, root_mean_square_of_parts};
use optimizer::LeastSquares;

/// Least and largest number of compared lines per FRF, and number of all FRFs together. More lines would not
/// reduce the error of the model, fewer would average less noise.
const LINES: (usize, usize) = (60, 1000);
const TOTAL_LINES: usize = 3600;

/// Kind of diagnosed data, with their weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// Whole FRFs.
    Frf(FrfSettings),
    /// Natural frequencies and amplitudes.
    Modes(ModeSettings),
}

impl Domain {
    /// Returns the kind of its data.
    pub fn kind(self) -> DataKind {
        match self {
            Domain::Frf(_) => DataKind::Frf,
            Domain::Modes(_) => DataKind::Modes,
        }
    }
}

/// Objective of one hypothesis.
pub enum DomainObjective<'h> {
    /// Objective on FRFs.
    Frf(FrfObjective<'h>),
    /// Objective on modes.
    Modes(ModeObjective<'h>),
}

/// Gap of one position, or of one FRF there.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialGap {
    /// Index of the position in the set.
    pub position: Option<usize>,
    /// Index of the FRF in the set, where FRFs are compared.
    pub frf: Option<usize>,
    /// The gap.
    pub gap: f64,
    /// Gap due to noise alone.
    pub floor: Option<f64>,
    /// Number of lines, or of modes.
    pub count: usize,
}

impl From<FrfGap> for PartialGap {
    fn from(of: FrfGap) -> Self {
        PartialGap { position: None, frf: Some(of.frf), gap: of.gap, floor: of.noise_floor, count: of.lines }
    }
}

/// Returns the gap over parts, weighted by their lines.
pub fn gap_over(parts: &[PartialGap]) -> Option<f64> {
    root_mean_square_of_parts(parts.iter().map(|p| (p.gap, p.count)))
}

/// Returns the noise floor over parts; `None` where one is unknown.
pub fn floor_over(parts: &[PartialGap]) -> Option<f64> {
    let floors: Option<Vec<(f64, usize)>> = parts.iter().map(|p| Some((p.floor?, p.count))).collect();
    root_mean_square_of_parts(floors?)
}

/// Computes `closed` = 1 − (after² − floor²)/(before² − floor²); `None` where the gap before is at the floor.
pub fn share_closed(before: f64, after: f64, floor: f64) -> Option<f64> {
    (before > floor).then(|| 1.0 - (after * after - floor * floor) / (before * before - floor * floor))
}

/// Computes [`share_closed`] of partial gaps; `None`, too, where the floor is unknown.
pub fn closed(before: &[PartialGap], after: &[PartialGap]) -> Option<f64> {
    share_closed(gap_over(before)?, gap_over(after)?, floor_over(before)?)
}

/// Returns the number of compared lines per FRF.
fn lines_of_one(frfs: &[usize]) -> usize {
    (TOTAL_LINES / frfs.len().max(1)).clamp(LINES.0, LINES.1)
}

impl<'h> DomainObjective<'h> {
    /// Builds the objective of data to fit. Parameters in `frozen` keep their start values.
    ///
    /// # Errors  as [`FrfObjective::new`] and [`ModeObjective::new`].
    pub fn new(
        hypothesis: &'h Hypothesis,
        fit: &FitSet<'_>,
        domain: Domain,
        frozen: &[String],
    ) -> Result<Self, ObjectiveError> {
        let machine = &hypothesis.machine;
        Ok(match domain {
            Domain::Frf(settings) => DomainObjective::Frf(
                FrfObjective::new(machine, fit, settings, frozen)?.thinned(lines_of_one(fit.frfs())),
            ),
            Domain::Modes(settings) => {
                DomainObjective::Modes(ModeObjective::new(machine, fit, settings, frozen)?)
            }
        })
    }

    /// Builds the objective of held-out FRFs: for their likelihood, or for simulated records. Their measured
    /// values enter no fit.
    ///
    /// # Errors  as [`FrfObjective::for_held_out`]; modes have no such objective.
    pub(super) fn for_held_out(
        hypothesis: &'h Hypothesis,
        held_out: &HoldOutSet<'_>,
        domain: Domain,
        frozen: &[String],
    ) -> Result<Self, ObjectiveError> {
        let Domain::Frf(settings) = domain else {
            return Err(ObjectiveError::Data("held-out modes are compared with predictions".into()));
        };
        let objective = FrfObjective::for_held_out(&hypothesis.machine, held_out, settings, frozen)?;
        Ok(DomainObjective::Frf(objective.thinned(lines_of_one(held_out.frfs()))))
    }

    /// Returns the objective on few lines, for coarse searches; `None` for modes.
    #[must_use]
    pub fn coarse(&self, lines: usize) -> Option<DomainObjective<'h>> {
        match self {
            DomainObjective::Frf(o) => Some(DomainObjective::Frf(o.curvature_sampled(lines))),
            DomainObjective::Modes(_) => None,
        }
    }

    /// Returns the indices of the free parameters.
    pub fn free(&self) -> &[usize] {
        match self {
            DomainObjective::Frf(o) => &o.free,
            DomainObjective::Modes(o) => &o.free,
        }
    }

    /// Returns the number of free parameters without those that have a prior: a prior counts as a measured
    /// number.
    pub fn unknowns(&self, of: &Hypothesis) -> usize {
        self.free().len().saturating_sub(of.machine.parameters.iter().filter(|p| p.prior.is_some()).count())
    }

    /// Returns the number of coordinates: free parameters, then gain, nut positions and channels where these
    /// are unknown.
    pub fn dimension(&self) -> usize {
        match self {
            DomainObjective::Frf(o) => LeastSquares::dimension(o),
            DomainObjective::Modes(o) => o.free.len() + usize::from(o.estimates_gain()),
        }
    }

    /// Returns the range of coordinates of nut positions.
    pub fn nut_coordinates(&self) -> std::ops::Range<usize> {
        match self {
            DomainObjective::Frf(o) => o.nut_coordinates(),
            DomainObjective::Modes(_) => self.dimension()..self.dimension(),
        }
    }

    /// Extends coordinates of the free parameters by the others.
    pub fn extended(&self, place: &[f64]) -> Place {
        match self {
            DomainObjective::Frf(o) => o.extended(place),
            DomainObjective::Modes(o) => o.extended(place),
        }
    }

    /// Applies a function to χ² as a sum of squares.
    pub fn squares<T>(&self, function: impl FnOnce(&dyn LeastSquares) -> T) -> T {
        match self {
            DomainObjective::Frf(o) => function(o),
            DomainObjective::Modes(o) => function(&ModeSquares::new(o, None)),
        }
    }

    /// Returns the number of compared numbers.
    pub fn observations(&self) -> usize {
        match self {
            DomainObjective::Frf(o) => o.observations(),
            DomainObjective::Modes(o) => o.observations(),
        }
    }

    /// Returns χ² per compared number due to noise alone.
    pub fn noise_share(&self) -> f64 {
        match self {
            DomainObjective::Frf(o) => o.noise_share(),
            DomainObjective::Modes(_) => 1.0,
        }
    }

    /// Returns the gain at given coordinates.
    pub fn gain(&self, place: &Place) -> f64 {
        match self {
            DomainObjective::Frf(o) => o.gain(place),
            DomainObjective::Modes(o) => o.gain(place),
        }
    }

    /// Returns the weighted residuals of the data, without priors.
    pub fn residuals(&self, place: &Place) -> DVector<f64> {
        match self {
            DomainObjective::Frf(o) => o.weighted_residuals(place),
            DomainObjective::Modes(o) => {
                let parameters = o.parameters(place);
                DVector::from_vec(o.residuals(&o.predict(&parameters), o.gain(place)))
            }
        }
    }

    /// Returns all terms whose squares sum to χ²: weighted residuals, then priors.
    pub fn rows(&self, place: &Place) -> DVector<f64> {
        match self {
            DomainObjective::Frf(o) => o.rows(place),
            DomainObjective::Modes(o) => DVector::from_vec(o.residuals_at(place)),
        }
    }

    /// Returns the derivatives of [`DomainObjective::rows`] with respect to the coordinates.
    pub fn slopes(&self, place: &Place) -> DMatrix<f64> {
        match self {
            DomainObjective::Frf(o) => o.slopes(place),
            DomainObjective::Modes(o) => o.linearised_at(place).1,
        }
    }
}

/// Returns the gaps of data with given parameters and gain.
///
/// # Errors  as [`FrfObjective::held_out`] and [`ModeObjective::held_out`].
pub fn gaps(
    hypothesis: &Hypothesis,
    parameters: &ParameterValues,
    gain: f64,
    data: &HoldOutSet<'_>,
    domain: Domain,
) -> Result<Vec<PartialGap>, ObjectiveError> {
    match domain {
        Domain::Frf(settings) => {
            if data.frfs().is_empty() {
                return Ok(Vec::new());
            }
            let objective = FrfObjective::held_out(&hypothesis.machine, data, settings)?;
            let part = |g: FrfGap| PartialGap { position: data.set().frfs[g.frf].position, ..g.into() };
            Ok(objective.gaps(parameters, gain).into_iter().map(part).collect())
        }
        Domain::Modes(settings) => {
            if data.positions().is_empty() {
                return Ok(Vec::new());
            }
            let objective = ModeObjective::held_out(&hypothesis.machine, data, settings, None)?;
            let resolution_hz = data.set().modes.as_ref().and_then(|m| m.resolution_hz);
            Ok(objective.predict(parameters).iter().map(|p| mode_part(p, resolution_hz)).collect())
        }
    }
}

/// Highest order with a gap of its own; orders count from 1.
const LAST_ORDER: u32 = 1000;

/// Returns the root mean square over positions of the relative frequency errors of each order, from 1. A mode
/// without a prediction counts as
/// [`MISSING`], one whose peak is hardly there in part. `None` for an order without observations.
///
/// # Errors  as [`ModeObjective::held_out`].
pub fn gaps_by_mode(
    hypothesis: &Hypothesis,
    parameters: &ParameterValues,
    data: &HoldOutSet<'_>,
    settings: ModeSettings,
) -> Result<Vec<Option<f64>>, ObjectiveError> {
    let objective = ModeObjective::held_out(&hypothesis.machine, data, settings, None)?;
    let errors: Vec<(u32, f64)> = objective
        .predict(parameters)
        .iter()
        .flat_map(|position| &position.deviations)
        .filter_map(|d| {
            let observed = d.observed.filter(|o| o.frequency_hz.is_some())?;
            Some((observed.order, squared_error(d).sqrt()))
        })
        .collect();
    let last = errors.iter().map(|e| e.0).max().unwrap_or(0).min(LAST_ORDER);
    Ok((1..=last)
        .map(|order| root_mean_square(errors.iter().filter(|e| e.0 == order).map(|e| e.1)))
        .collect())
}

/// Computes the gap of the modes at one position.
///
/// # Source  definition of this project: root mean square over the measured modes of the relative frequency
///   errors, a missing mode counting as 0.3; an
/// unexpected peak adds the square of 0.3, as far as it should have been visible. The floor is due to
/// rounding, resolution/√12, and stated scatter.
fn mode_part(prediction: &PositionPrediction, resolution_hz: Option<f64>) -> PartialGap {
    let (mut squares, mut floors, mut count) = (0.0, 0.0, 0_u32);
    for d in &prediction.deviations {
        squares += squared_error(d);
        if let Some(observed) = d.observed.filter(|o| o.frequency_hz.is_some()) {
            floors += observed.frequency_scatter(resolution_hz).powi(2);
            count += 1;
        }
    }
    // Unexpected peaks alone count as one mode.
    count = count.max(u32::from(squares > 0.0));
    let mean = |sum: f64| (sum / f64::from(count.max(1))).sqrt();
    PartialGap {
        position: Some(prediction.position),
        frf: None,
        gap: mean(squares),
        floor: Some(mean(floors)),
        count: count as usize,
    }
}

/// Returns the squared relative frequency error of a deviation, that of [`MISSING`] as far as one side lacks
/// the mode.
fn squared_error(d: &Deviation) -> f64 {
    let of_pair = d
        .observed
        .and_then(|o| o.frequency_hz)
        .zip(d.predicted)
        .map_or(0.0, |(hz, peak)| peak.frequency_hz / hz - 1.0);
    (1.0 - d.lacking()) * of_pair.powi(2) + d.lacking() * MISSING * MISSING
}
