//! Evidence of modes: each residual of a fit with its derivatives, so that two tests of one machine can be
//! fitted jointly.

use super::place::{Coordinate, Place};
use crate::objective::{ModeObjective, Objective, PositionPrediction};
use measurement::{FitSet, ModeObservation};

/// A residual of a fit of modes about its minima. A frequency's is relative (1); that of an amplitude, or of
/// modes that one side lacks, is in its standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeResidual {
    /// Name of the position.
    pub position: String,
    /// Nut position (m), where the machine has one.
    pub nut_m: Option<f64>,
    /// Order of the mode whose frequency it compares; `None` for another residual.
    pub order: Option<u32>,
    /// Standard deviation by model error; 0 for another residual.
    pub model_sd: f64,
    /// Standard deviation by rounding and stated scatter; 1 for another residual.
    pub scatter_sd: f64,
    /// Whether the set states the scatter of the frequency.
    pub is_scatter_stated: bool,
    /// Residual at each minimum.
    pub deviations: Vec<f64>,
    /// Derivative with respect to each coordinate of the posterior.
    pub slopes: Vec<f64>,
}

/// Returns the residuals of a fit about the best of its minima, with those at all of them. `columns` are the
/// changes of the residuals by one standard deviation of each coordinate after those of the objective.
pub(super) fn mode_residuals(
    objective: &ModeObjective<'_>,
    fit: &FitSet<'_>,
    (coordinates, minima): (&[Coordinate], &[Place]),
    columns: &[Vec<f64>],
) -> Vec<ModeResidual> {
    let own = coordinates.len() - columns.len();
    let prior = |column: usize| coordinates[own + column].prior.unwrap_or((1.0, 0.5));
    let at: Vec<(Vec<f64>, _)> =
        minima.iter().map(|place| objective.data_linearised(&place[..own])).collect();
    let predictions = objective.predict(&objective.parameters(&Place(minima[0][..own].to_vec())));
    let settings = objective.mode_settings();
    let places: Vec<_> = predictions.iter().flat_map(|p| observations(p, settings.objective)).collect();
    let residual = |(row, (position, observed)): (usize, &(usize, Option<ModeObservation>))| {
        let scatter_sd = observed.map_or(1.0, |o| o.frequency_scatter(objective.resolution_hz()));
        let model_sd = observed.map_or(0.0, |_| settings.frequency_model_error);
        let sd = observed.map_or(1.0, |_| settings.frequency_sd(scatter_sd));
        let of_tolerances = |column: usize| sd * columns[column][row] / prior(column).0;
        let own_slopes = (0..own).map(|column| sd * at[0].1[(row, column)]);
        let slopes: Vec<f64> = own_slopes.chain((0..columns.len()).map(of_tolerances)).collect();
        let deviation = |(place, (residuals, _)): (&Place, &(Vec<f64>, _))| {
            let moved = |column: usize| slopes[own + column] * (place[own + column] - prior(column).1);
            sd * residuals[row] + (0..columns.len()).map(moved).sum::<f64>()
        };
        let described = &fit.set().positions[*position];
        ModeResidual {
            position: described.name.clone(),
            nut_m: described.nut_m,
            order: observed.map(|o| o.order),
            model_sd,
            scatter_sd,
            is_scatter_stated: observed.is_some_and(|o| o.frequency_sd_hz.is_some()),
            deviations: minima.iter().zip(&at).map(deviation).collect(),
            slopes,
        }
    };
    places.iter().enumerate().map(residual).collect()
}

/// Returns the position of each residual of a position, in the order of [`ModeObjective::residuals`], and the
/// observation where it compares a frequency.
fn observations(
    prediction: &PositionPrediction,
    objective: Objective,
) -> Vec<(usize, Option<ModeObservation>)> {
    let observed = || prediction.deviations.iter().filter(|d| d.observed.is_some());
    let frequencies = observed().map(|d| d.pair().map(|(observation, _)| observation));
    let with_amplitude = observed().filter(|d| d.observed.is_some_and(|o| o.amplitude.is_some()));
    let amplitudes = with_amplitude.filter(|_| objective != Objective::Frequencies).map(|_| None);
    frequencies.chain(amplitudes).chain([None]).map(|observed| (prediction.position, observed)).collect()
}
