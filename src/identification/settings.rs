//! Settings of an identification.

use std::collections::BTreeMap;

use super::place::Place;
use crate::objective::{FrfSettings, ModeSettings};
use optimizer::SearchResult;

/// Number of times that the best minimum has to be found: with this number a deeper minimum that attracts as
/// many starts is missed with a probability below 1 %, e⁻⁵.
pub const REPEATS: usize = 5;

/// Settings of an identification.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentificationSettings {
    /// Objective, weights and rod model for modes.
    pub settings: ModeSettings,
    /// Weights, band and rod model for whole FRFs. If present, FRFs are fitted instead of modes.
    pub frf: Option<FrfSettings>,
    /// Whether nuisance parameters (tolerances of the description and the measurement) are fitted together
    /// with whole FRFs.
    pub tolerances: bool,
    /// Ids of the parameters that keep their start values.
    pub frozen: Vec<String>,
    /// Seed of the first round of searches; the seeds of the others derive from it.
    pub seed: u64,
    /// Number of spread starts that have to end in the best minimum before the search ends.
    pub repeats: usize,
    /// Unit-cube coordinates of a nearby solution: least squares starts there and replaces the search.
    /// They hold the free parameters and tolerances. Gain, nut positions and channels restart at their
    /// defaults.
    pub near: Option<Place>,
    /// Fits of machines that this one contains, such as the machine without an effect: values by the names of
    /// parameters and tolerances. The search starts from each of them, too, and thus ends above none.
    pub contained: Vec<BTreeMap<String, f64>>,
    /// Whether intervals come from the profile likelihood; otherwise from the covariance.
    pub profile: bool,
    /// Number of bootstrap samples over lines, and of those over positions; 0 for no bootstrap.
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
            repeats: REPEATS,
            near: None,
            contained: Vec::new(),
            profile: true,
            bootstrap: 0,
        }
    }
}

/// One round of searches.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeat {
    /// Seed.
    pub seed: u64,
    /// Result.
    pub found: SearchResult,
}
