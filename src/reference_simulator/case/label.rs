//! The sealed label: the truth of a case.

use std::collections::BTreeMap;

#[cfg(test)]
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::imitation::Imitation;
use super::plan::{Kind, Strength};
use crate::effect::Place;
#[cfg(test)]
use crate::machine::point::Channel;

/// Gaps of the engineer's model after a refit to noise-free data: the rms residual. For FRFs its unit is ln H
/// per component; for motions it is relative to the measured force or the tracking error. Where a wrong
/// parameter is frozen, «with» means frozen and «without» means free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Gap due to noise alone, held-out positions.
    pub floor_held_out: f64,
    /// Refit to the machine without the effect, fitted positions.
    pub without_fit: f64,
    /// Refit to the machine without the effect, held-out positions.
    pub without_held_out: f64,
    /// Refit to the machine with the effect, fitted positions.
    pub with_fit: f64,
    /// Refit to the machine with the effect, held-out positions.
    pub with_held_out: f64,
    /// 1 − without² / with² at held-out positions: the share that a perfect model of the effect can close.
    pub closed: Option<f64>,
}

impl Gap {
    /// Builds the gaps from the noise floor and the refits without and with the effect; each pair is fitted,
    /// then held out.
    pub fn new(
        floor_held_out: f64,
        [without_fit, without_held_out]: [f64; 2],
        [with_fit, with_held_out]: [f64; 2],
    ) -> Self {
        let closed = (with_held_out > 1.02 * without_held_out)
            .then(|| 1.0 - (without_held_out / with_held_out).powi(2));
        Self { floor_held_out, without_fit, without_held_out, with_fit, with_held_out, closed }
    }
}

/// A wrong start value of one parameter, by up to a factor of three; in half of the cases the value is also
/// declared known.
pub struct WrongParameter {
    /// Name.
    pub name: &'static str,
    /// Wrong start value.
    pub start: f64,
    /// Factor of its error.
    pub factor: f64,
    /// Whether the case declares the value known.
    pub is_frozen: bool,
}

impl WrongParameter {
    /// Returns name and value if the case declares it known.
    pub fn frozen(&self) -> Option<(&'static str, f64)> {
        self.is_frozen.then_some((self.name, self.start))
    }

    /// States it in the label and in the case's list of known parameters.
    pub fn state(&self, freeze: &mut Vec<String>, label: &mut Label) {
        freeze.extend(self.frozen().map(|(name, _)| name.to_owned()));
        label.frozen.clone_from(freeze);
        label.wrong_parameter = Some((self.name.to_owned(), self.factor));
    }
}

/// Noise-free curves of one record, in the quantity that the manifest states.
#[cfg(test)]
#[derive(Clone, Debug, PartialEq)]
pub struct Exact {
    /// Name of the position.
    pub position: String,
    /// Response and excitation.
    pub channel: Channel,
    /// True curve of machine and measurement, including gain and delay.
    pub with: Vec<Complex64>,
}

/// Properties of a hammer test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HammerTest {
    /// Whether the drive holds the rotor.
    pub rotor_held: bool,
    /// Whether the machine is the published bench.
    pub bench: bool,
    /// Channels of the first measurement.
    pub channels: usize,
    /// Nut positions.
    pub positions: usize,
    /// Length of the blocks, s.
    pub block_s: f64,
    /// Largest relative error of a noise-free H1 at a resonance.
    pub estimator_bias: f64,
    /// Corner of the high pass of its sensors, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high_pass_hz: Option<f64>,
}

/// The truth behind a case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// Name of the case.
    pub case: String,
    /// Number of the case in the plan.
    pub index: usize,
    /// Kind.
    pub kind: Kind,
    /// Effects, the dominant one first; empty for nulls.
    pub effects: Vec<String>,
    /// Effects that even the follow-up may not distinguish from the true one.
    pub alternatives: Vec<String>,
    /// Requested strength.
    pub strength: Option<Strength>,
    /// Non-centrality of each effect alone over all positions, with joints and nuisance parameters projected
    /// out.
    pub noncentrality: Vec<f64>,
    /// Non-centrality of each effect alone at the given positions, after joints and tolerances are fitted
    /// along.
    #[serde(default)]
    pub fitted_noncentrality: Vec<f64>,
    /// Effect of the library that comes closest to an outside cause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imitation: Option<Imitation>,
    /// Layout of the machine; absent for machines of the catalogue.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// Physical values of each effect.
    pub values: Vec<BTreeMap<String, f64>>,
    /// Location of each effect.
    pub places: Vec<Place>,
    /// Band that contains most of the effects' residual after projection of joints and nuisance parameters.
    pub band_hz: Option<[f64; 2]>,
    /// Motion phases in which the effects show; for time records only.
    #[serde(default)]
    pub phases: Vec<String>,
    /// Gaps without and with the effects.
    pub gap: Gap,
    /// True values of the description's parameters; joints at the reference position and level, as
    /// [`Nuisance::effective`](crate::machine::nuisance::Nuisance::effective).
    pub joints: BTreeMap<String, f64>,
    /// Parameter with a wrong start value, and the factor of its error.
    pub wrong_parameter: Option<(String, f64)>,
    /// Parameters that the case declares known.
    pub frozen: Vec<String>,
    /// Data fault.
    pub fault: Option<String>,
    /// Files of the faulty records.
    pub faulty_records: Vec<String>,
    /// Properties that only a hammer test has.
    pub hammer: Option<HammerTest>,
    /// Machines rejected before this one.
    pub refused: usize,
    /// Noise-free curves, for tests.
    #[cfg(test)]
    #[serde(skip)]
    pub exact: Vec<Exact>,
}

impl Label {
    /// Starts the label of a case by its number and the number of rejected machines; the caller fills in the
    /// rest.
    pub fn new(index: usize, kind: Kind, strength: Option<Strength>, refused: usize) -> Self {
        Self { case: format!("case-{:04}", index + 1), index, kind, strength, refused, ..Self::default() }
    }
}
