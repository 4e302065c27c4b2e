//! What is sealed: the truth behind a case.

use std::collections::BTreeMap;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::layout::Layout;
use super::plan::{Kind, Strength};
use crate::effect::Place;
use crate::machine::point::Channel;

/// Gaps of the engineer's model, refitted to noise-free data: of FRFs in units of ln H per component, of motions over the measured force or
/// tracking error. Where a wrong parameter is frozen,
/// «with» is with it frozen and «without» with it free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// What noise alone leaves, held-out positions.
    pub floor_held_out: f64,
    /// Refitted to the machine without the effect: fit positions.
    pub without_fit: f64,
    /// The same, held-out positions.
    pub without_held_out: f64,
    /// Refitted to the machine as it is: fit positions.
    pub with_fit: f64,
    /// The same, held-out positions.
    pub with_held_out: f64,
    /// 1 − without² / with² on held-out positions: what a perfect model of the effect can close.
    pub closed: Option<f64>,
}

impl Gap {
    /// Of the floor on held-out positions, and of what refits without and with the effect leave: fit, then held-out positions.
    pub fn of(floor_held_out: f64, [without_fit, without_held_out]: [f64; 2], [with_fit, with_held_out]: [f64; 2]) -> Self {
        let closed = (with_held_out > 1.02 * without_held_out).then(|| 1.0 - (without_held_out / with_held_out).powi(2));
        Self { floor_held_out, without_fit, without_held_out, with_fit, with_held_out, closed }
    }
}

/// Noise-free curves of one record, in the quantity the manifest states.
#[derive(Clone, Debug, PartialEq)]
pub struct Exact {
    /// Name of the position.
    pub position: String,
    /// Response and excitation.
    pub channel: Channel,
    /// Force level over the nominal one.
    pub level: f64,
    /// Lines.
    pub frequency_hz: Vec<f64>,
    /// The machine and measurement as they are, gain and delay included.
    pub with: Vec<Complex64>,
    /// The same without the effects.
    pub without: Vec<Complex64>,
}

/// What is true of a hammer test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HammerTest {
    /// Whether the drive holds the rotor.
    pub rotor_held: bool,
    /// Whether the machine is the published bench.
    pub bench: bool,
    /// Layout of the first measurement.
    pub layout: Layout,
    /// Length of the blocks.
    pub block_s: f64,
    /// Largest error of a noise-free H1 at a resonance.
    pub estimator_bias: f64,
}

/// The truth behind a case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// Name of the case.
    pub case: String,
    /// Its number in the plan.
    pub index: usize,
    /// Kind.
    pub kind: Kind,
    /// Effects, the dominant one first; empty for nulls.
    pub effects: Vec<String>,
    /// Effects that are told apart from it by the follow-up at best.
    pub alternatives: Vec<String>,
    /// Strength that was asked for.
    pub strength: Option<Strength>,
    /// Non-centrality of each effect alone, all positions, joints and nuisances projected out.
    pub noncentrality: Vec<f64>,
    /// Physical values of each effect.
    pub values: Vec<BTreeMap<String, f64>>,
    /// Where each effect sits.
    pub places: Vec<Place>,
    /// Band that holds most of what the effects leave after joints and nuisances are projected out.
    pub band_hz: Option<[f64; 2]>,
    /// Phases of the motion in which the effects show, of time records.
    #[serde(default)]
    pub phases: Vec<String>,
    /// Gaps before and after.
    pub gap: Gap,
    /// True values of the description's parameters (joints at the reference position and level).
    pub joints: BTreeMap<String, f64>,
    /// Parameter whose start value is wrong, and by which factor.
    pub wrong_parameter: Option<(String, f64)>,
    /// Parameters that the case declares known.
    pub frozen: Vec<String>,
    /// What is wrong with the measurement.
    pub fault: Option<String>,
    /// Files of the records concerned.
    pub faulty_records: Vec<String>,
    /// What only a hammer test has.
    pub hammer: Option<HammerTest>,
    /// Machines refused before this one.
    pub refused: usize,
    /// Noise-free curves; not written, the same seed makes them again.
    #[serde(skip)]
    pub exact: Vec<Exact>,
}

impl Label {
    /// Of the case of a number, after machines that were refused; what is true of it is still to be filled in.
    pub fn begun(index: usize, kind: Kind, strength: Option<Strength>, refused: usize) -> Self {
        Self { case: format!("case-{:04}", index + 1), index, kind, strength, refused, ..Self::default() }
    }
}
