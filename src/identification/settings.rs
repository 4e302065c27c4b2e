//! How an identification is run.

use crate::objective::{FrfSettings, ModeSettings};
use optimizer::{Found, Strategy};

/// How an identification is run.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentificationSettings {
    /// Objective, weights, rods for modes.
    pub settings: ModeSettings,
    /// Weights, band, rods for whole FRFs; where they are given FRFs are fitted, not modes.
    pub frf: Option<FrfSettings>,
    /// Whether tolerances of the description and of the measurement are fitted along with whole FRFs.
    pub tolerances: bool,
    /// Ids of parameters that keep their start values.
    pub frozen: Vec<String>,
    /// Seed of the first search; the others follow from it.
    pub seed: u64,
    /// Searches from different seeds.
    pub repeats: usize,
    /// Strategy of the differential evolution.
    pub strategy: Strategy,
    /// Place (of the free parameters and tolerances; what belongs to the data begins anew) to polish from instead of a search: for data known to lie near it.
    pub near: Option<Vec<f64>>,
    /// Intervals by profile likelihood, or else by the covariance alone.
    pub profile: bool,
    /// Bootstrap samples over lines, and as many over positions; 0 for none.
    pub bootstrap: usize,
}

impl Default for IdentificationSettings {
    fn default() -> Self {
        IdentificationSettings {
            settings: ModeSettings::default(),
            frf: None,
            tolerances: true,
            frozen: Vec::new(),
            seed: 1,
            repeats: 3,
            strategy: Strategy::CurrentToPbest,
            near: None,
            profile: true,
            bootstrap: 0,
        }
    }
}

/// One search.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeat {
    /// Its seed.
    pub seed: u64,
    /// What it found.
    pub found: Found,
}
