//! Result documents of modes, sweeps, matrices, friction and the published figures.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// One undamped mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModeRow {
    /// Number of the mode, from 1.
    pub order: usize,
    /// Undamped natural frequency (Hz); 0 for a rigid body.
    pub frequency_hz: f64,
    /// Damping ratio by modal energies, to first order.
    pub damping_ratio: Option<f64>,
    /// Deflection of each point, the largest 1.
    pub shape: BTreeMap<String, f64>,
    /// Damped natural frequency f·√(1 − ζ²) (Hz) of a proportionally damped mode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damped_hz: Option<f64>,
    /// Deformation of each joint, and of each spring of a series in a joint (`joint/spring`), for that shape (m or rad).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub deformation: BTreeMap<String, f64>,
    /// Share of the strain energy of each joint, each spring of a series (contained in its joint) and each shaft.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub strain_energy_share: BTreeMap<String, f64>,
}

/// `modes.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModesDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Nut position (m).
    pub nut_m: Option<f64>,
    /// Velocity of the table (m/s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration_m_s2: Option<f64>,
    /// External axial force (N).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_n: Option<f64>,
    /// Modes in ascending frequency.
    pub modes: Vec<ModeRow>,
}

/// `matrices.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MatricesDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Names of the coordinates.
    pub coordinates: Vec<String>,
    /// Mass matrix, by rows.
    pub mass: Vec<Vec<f64>>,
    /// Damping matrix, by rows.
    pub damping: Vec<Vec<f64>>,
    /// Stiffness matrix, by rows.
    pub stiffness: Vec<Vec<f64>>,
}

/// A contact at one operating condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContactRow {
    /// External force (N).
    pub force_n: f64,
    /// Load of side A (N).
    pub load_a_n: f64,
    /// Load of side B (N); 0 where it is separated.
    pub load_b_n: f64,
    /// Stiffness (N/m).
    pub stiffness_n_per_m: f64,
}

/// One step of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepRow {
    /// Value of the swept variable, in its unit.
    pub at: f64,
    /// Contacts by name.
    pub contacts: BTreeMap<String, ContactRow>,
    /// Stiffness of each joint (N/m or N·m/rad), and of each spring of a series (`joint/spring`).
    pub joints: BTreeMap<String, f64>,
    /// Static stiffness at the requested point (N/m or N·m/rad).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub static_stiffness: Option<f64>,
    /// Undamped natural frequencies above 0 (Hz).
    pub frequencies_hz: Vec<f64>,
}

/// Unloading of a side of a contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Separation {
    /// Contact.
    pub contact: String,
    /// Side that unloads, `A` or `B`.
    pub side: String,
    /// External force (N) at which it unloads.
    pub force_n: f64,
    /// Value of the swept variable at which it unloads.
    pub at: f64,
}

/// `stiffness.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// `nut_m`, `velocity_m_s`, `acceleration_m_s2` or `force_n`.
    pub along: String,
    /// Point of the static stiffness.
    pub point: Option<String>,
    /// Nut position (m) of a second, identical axis in series with the first, where one is requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_series_with_nut_m: Option<f64>,
    /// Points inside the range at which sides of contacts unload.
    pub separations: Vec<Separation>,
    /// Steps.
    pub rows: Vec<SweepRow>,
}

/// Sensitivity of a natural frequency to one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensitivityRow {
    /// Joint.
    pub joint: String,
    /// Stiffness of the joint (N/m or N·m/rad).
    pub stiffness: f64,
    /// Deformation of the joint for the mode's shape, the largest deflection 1 (m or rad).
    pub deformation: f64,
    /// Share of the mode's strain energy.
    pub strain_energy_share: f64,
    /// d ln f/d ln k, half that share.
    pub elasticity: f64,
    /// The frequency (Hz) at each factor on the stiffness.
    pub frequencies_hz: Vec<f64>,
}

/// `sensitivity.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensitivityDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Nut position (m).
    pub nut_m: Option<f64>,
    /// Number of the natural frequency above 0, from 1.
    pub order: usize,
    /// That frequency (Hz).
    pub frequency_hz: f64,
    /// Factors on the stiffness.
    pub factors: Vec<f64>,
    /// Joints, the most influential first.
    pub joints: Vec<SensitivityRow>,
}

/// A parameter of a friction curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrictionParameter {
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// 95 % interval; absent for a parameter at a bound.
    pub interval95: Option<[f64; 2]>,
    /// At a bound of its range.
    pub at_bound: bool,
}

/// A run at constant velocity, compared with the curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrictionRow {
    /// Velocity (m/s).
    pub velocity_m_s: f64,
    /// Measured force (N).
    pub force_n: f64,
    /// Force of the curve (N).
    pub predicted_n: f64,
}

/// `friction.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrictionDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Noise model: `uniform`, `proportional` or `known`.
    pub noise: String,
    /// `coulomb_n`, `static_n`, `viscous_n_s_per_m`, `stribeck_velocity_m_s`.
    pub parameters: BTreeMap<String, FrictionParameter>,
    /// Scatter of the residuals: N for uniform noise, else relative.
    pub residual_scatter: f64,
    /// Observations less free parameters.
    pub degrees_of_freedom: usize,
    /// Speed (m/s) of least friction.
    pub least_friction_speed_m_s: f64,
    /// Observations.
    pub observations: Vec<FrictionRow>,
}

/// A published figure compared with ours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedFigure {
    /// Paper.
    pub paper: String,
    /// Section, table, figure or equation of the paper.
    pub place: String,
    /// Description of the quantity.
    pub quantity: String,
    /// Unit.
    pub unit: String,
    /// Printed value.
    pub published: Option<f64>,
    /// Ours.
    pub ours: Option<f64>,
    /// (ours − published)/published.
    pub relative_difference: Option<f64>,
    /// `agrees` (within the tolerance stated), `differs` or `not reproducible`.
    pub verdict: String,
    /// Method of ours, and the reason for a difference.
    pub remark: String,
}

/// `published.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Figures.
    pub figures: Vec<PublishedFigure>,
}

/// The lumped model with one number of lumps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConvergenceRow {
    /// Lumps per rod; absent for the exact rod.
    pub lumps: Option<usize>,
    /// First natural frequencies above 0 at the start values (Hz).
    pub frequencies_hz: Vec<f64>,
    /// Identified parameters by id.
    pub parameters: BTreeMap<String, f64>,
    /// Ids of the fitted parameters.
    pub fitted: Vec<String>,
    /// Minimum cost.
    pub cost: f64,
    /// Root of the summed squares of the relative frequency errors at each held-out position.
    pub held_out_errors: BTreeMap<String, f64>,
}

/// `convergence.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConvergenceDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Nut position of the frequencies (m).
    pub nut_m: Option<f64>,
    /// Positions fitted.
    pub fit_positions: Vec<String>,
    /// Results in ascending number of lumps, the exact rod last.
    pub rows: Vec<ConvergenceRow>,
}
