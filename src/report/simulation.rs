//! Result documents of modes, sweeps and friction.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// One undamped mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModeRow {
    /// Mode number in ascending frequency, from 1.
    pub order: usize,
    /// Undamped natural frequency (Hz); 0 for a rigid-body mode.
    pub frequency_hz: f64,
    /// Damping ratio by modal energies, to first order (1).
    pub damping_ratio: Option<f64>,
    /// Deflection by point, relative to the largest (1).
    pub shape: BTreeMap<String, f64>,
    /// Damped natural frequency f·√(1 − ζ²) of a proportionally damped mode (Hz).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damped_hz: Option<f64>,
    /// Deformation of each joint, and of each spring of a series in a joint (`joint/spring`), for `shape` (m
    /// or rad).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub deformation: BTreeMap<String, f64>,
    /// Share of each joint, each spring of a series (contained in its joint) and each shaft in the strain
    /// energy (1).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub strain_energy_share: BTreeMap<String, f64>,
}

/// Undamped modes (`modes.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModesDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Position of the nut (m).
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

/// A preloaded pair of contacts at one operating condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContactRow {
    /// External force on the pair (N).
    pub force_n: f64,
    /// Load of side A (N).
    pub load_a_n: f64,
    /// Load of side B (N); 0 where it is separated.
    pub load_b_n: f64,
    /// Stiffness of the pair (N/m).
    pub stiffness_n_per_m: f64,
}

/// Stiffness and natural frequencies at one value of the swept variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepRow {
    /// Value of the swept variable (unit by `along`).
    pub at: f64,
    /// Loads and stiffness by contact.
    pub contacts: BTreeMap<String, ContactRow>,
    /// Stiffness of each joint, and of each spring of a series (`joint/spring`) (N/m or N·m/rad).
    pub joints: BTreeMap<String, f64>,
    /// Static stiffness at `point` (N/m or N·m/rad).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub static_stiffness: Option<f64>,
    /// Undamped natural frequencies above 0 (Hz), ascending.
    pub frequencies_hz: Vec<f64>,
}

/// Operating condition at which one side of a contact unloads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Separation {
    /// Name of the contact.
    pub contact: String,
    /// Side that unloads: `A` or `B`.
    pub side: String,
    /// External force at which it unloads (N).
    pub force_n: f64,
    /// Value of the swept variable at which it unloads (unit by `along`).
    pub at: f64,
}

/// Stiffness over a swept operating variable (`stiffness.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Swept variable with its unit: `nut_m`, `velocity_m_s`, `acceleration_m_s2` or `force_n`.
    pub along: String,
    /// Name of the point of the static stiffness, where one is requested.
    pub point: Option<String>,
    /// Position of the nut of a second, identical axis in series with the first (m), where one is requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_series_with_nut_m: Option<f64>,
    /// Values inside the range at which sides of contacts unload.
    pub separations: Vec<Separation>,
    /// Results in ascending value of the swept variable.
    pub rows: Vec<SweepRow>,
}

/// Estimate of one parameter of the Stribeck curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrictionParameter {
    /// Estimate (in `unit`).
    pub value: f64,
    /// Unit of estimate and interval.
    pub unit: String,
    /// 95 % confidence interval (in `unit`); absent for a parameter at a bound.
    pub interval95: Option<[f64; 2]>,
    /// Whether the estimate lies at a bound of its range, so that the runs do not determine it.
    pub at_bound: bool,
}

/// A run at constant velocity, compared with the Stribeck curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrictionRow {
    /// Velocity (m/s).
    pub velocity_m_s: f64,
    /// Measured force (N).
    pub force_n: f64,
    /// Force of the Stribeck curve (N).
    pub predicted_n: f64,
}

/// Fit of a Stribeck curve (`friction.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrictionDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Noise model: `uniform`, `proportional` or `known`.
    pub noise: String,
    /// Estimates by name: `coulomb_n`, `static_n`, `viscous_n_s_per_m`, `stribeck_velocity_m_s`.
    pub parameters: BTreeMap<String, FrictionParameter>,
    /// Scatter of the residuals: in N for uniform noise; relative to the force or to the known standard
    /// deviations otherwise (1).
    pub residual_scatter: f64,
    /// Number of observations minus number of free parameters.
    pub degrees_of_freedom: usize,
    /// Speed of lowest friction (m/s) from rest to the highest speed of the runs: 0 where the friction rises
    /// throughout, the highest speed where it falls throughout.
    pub least_friction_speed_m_s: f64,
    /// Highest speed of the runs (m/s).
    pub highest_speed_m_s: f64,
    /// Runs compared with the curve.
    pub observations: Vec<FrictionRow>,
}
