//! Coordinates of a problem in the unit cube of an optimiser.

use machine::numbers_as_slice;
use serde::{Deserialize, Serialize};

/// A fitted coordinate of the unit cube.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// Id of the parameter, or name of the tolerance.
    pub name: String,
    /// Whether it belongs to the machine, whatever is measured on it; otherwise to the measurement: gain,
    /// delay, nut position.
    pub of_machine: bool,
    /// Standard deviation of its prior in the unit interval, and the centre of the prior; `None` without a
    /// prior.
    pub prior: Option<(f64, f64)>,
}

/// All coordinates of a problem in the unit cube: its free parameters, then its [`Tail`].
///
/// They are not values of parameters:
///
/// ```compile_fail,E0308
/// # use jointid_identification::{Place, objective::{FrfGap, FrfObjective}};
/// fn gaps(objective: &FrfObjective<'_>, place: &Place) -> Vec<FrfGap> {
///     objective.gaps(place, 1.0)
/// }
/// ```
///
/// The objective converts them:
///
/// ```
/// # use jointid_identification::{Place, objective::{FrfGap, FrfObjective}};
/// fn gaps(objective: &FrfObjective<'_>, place: &Place) -> Vec<FrfGap> {
///     objective.gaps(&objective.parameters(place), objective.gain(place))
/// }
/// ```
#[derive(Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Place(pub Vec<f64>);

/// Coordinates of the unknowns of the data, which follow those of the free parameters: an unknown gain, nut
/// positions, and the gains and delays of channels.
#[derive(Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Tail(pub Vec<f64>);

numbers_as_slice!(Place, Tail);
