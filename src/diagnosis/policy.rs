//! All numbers that steer a verdict.
//!
//! Each states its quantity and what it guards. Which verdicts move if one is halved or doubled,
//! `jointid-lab replay` measures on stored facts.

use serde::{Deserialize, Serialize};

use super::data_kind::DataKind;

/// Numbers by which the rules judge facts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Policy {
    /// Whether null simulations calibrate the misfit: those of FRFs do; the weights of modes are a model
    /// error that is hardly known. A fit that agrees with calibrated simulations excludes one that does not.
    pub calibrated: bool,

    /// Whether null simulations bound the error of the model: those of motion records have the library's laws of
    /// friction, which no machine follows exactly.
    pub bounded: bool,

    // Significance.
    /// Largest p-value of a significant candidate. Guards machines that lack nothing.
    pub alpha: f64,
    /// Least share of χ² by which a significant candidate reduces it: small print that no tolerance describes.
    pub least_share: f64,
    /// Excess (misfit over the median of null simulations) above which an explanation is needed.
    pub excess: f64,
    /// Excess above which an effect that needs an impossible machine is none.
    pub huge_excess: f64,

    // Candidates that fit alike.
    /// Difference of χ² within which fits are indistinguishable, at an excess of one (error rate 7 %).
    pub equivalent: f64,
    /// Cost of a candidate in units of its null scale, in place of that of its parameters: wave-shaped effects of motion
    /// records, and flexible ones of the few numbers of modes, reduce χ² of any of them.
    pub penalty: Option<f64>,
    /// Share of the best reduction of χ² added to it for the error of the model.
    pub model_error: f64,
    /// Shortfall in cross-validation that a rival may have, as a share of the best candidate's improvement.
    pub shortfall: f64,

    // Further effects.
    /// Largest number of combined effects.
    pub most_effects: usize,
    /// Excess above which a further effect is sought.
    pub continue_from: f64,
    /// Least share of the remaining χ² by which a further effect must reduce it where the excess then falls
    /// to `continue_from`.
    pub next_share_last: f64,
    /// The same where it does not.
    pub next_share: f64,

    // What an effect must explain to be named.
    /// Share of the misfit beyond null simulations, and of the squared held-out gap above the noise
    /// floor, that it leaves: it may exceed one of both. Records of several machines leave more of the misfit, too.
    pub unexplained: f64,
    /// Standard deviations of a tolerance beyond which something is missing though no effect is significant.
    ///
    /// # Source  a normal tolerance exceeds four standard deviations once in 16,000 machines.
    pub implausible: f64,
    /// Standard deviations of a number of the machine with which it is another machine.
    ///
    /// # Source  Chebyshev's inequality: whatever its law, a number exceeds ten standard deviations once in a
    ///   hundred machines at most.
    pub impossible: f64,
    /// Ratio of the cross-validation loss of a better fitting generic impedance to that of the effect below which
    /// the impedance is the better explanation.
    pub left_out_generic: f64,
    /// Least logarithm of a ratio of predictive densities of held-out data that decides, in units of the
    /// misfit over null simulations: 20 to 1.
    ///
    /// # Source  Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773–795: «strong» evidence from 3 on.
    pub decisive: f64,
    /// Share of the named effect's logarithm of such a ratio over the nominal machine by which that of a generic
    /// rival must exceed it: free functions of a motion contain effects, and more than these.
    pub advantage: f64,

    // Faults of the measuring chain.
    /// Largest excess with which corrected records, or those without a faulty one, agree with the model.
    pub agrees: f64,
    /// Allowance on it as a share of the excess before: null simulations were made about the wrong fit.
    pub allowance: f64,
    /// Largest share of χ² that remains once a fault is corrected.
    pub restored: f64,
    /// Least ratio of the misfit of a contradicting record to that of the others.
    pub contradicting: f64,
    /// Least ratio of the misfit of the others without the second most contradicting record to that without
    /// the first.
    pub contradicting_alone: f64,
}

/// FRFs.
const FRF: Policy = Policy {
    calibrated: true,
    bounded: true,
    alpha: 0.01,
    least_share: 0.0,
    excess: 2.0,
    huge_excess: 5.0,
    equivalent: 9.0,
    penalty: None,
    model_error: 0.1,
    shortfall: 0.2,
    most_effects: 3,
    continue_from: 1.2,
    next_share_last: 0.25,
    next_share: 0.5,
    unexplained: 0.5,
    // The tolerances of FRFs and modes are numbers of the description, whose own warnings state it.
    implausible: f64::MAX,
    impossible: 10.0,
    left_out_generic: 0.65,
    decisive: 3.0,
    advantage: 0.0,
    agrees: 1.6,
    allowance: 0.01,
    restored: 0.2,
    contradicting: 10.0,
    contradicting_alone: 2.5,
};

/// Modes, where they differ.
const MODES: Policy = Policy {
    calibrated: false,
    bounded: false,
    alpha: 0.001,
    continue_from: 2.0,
    next_share_last: 0.4,
    next_share: 0.4,
    penalty: Some(8.0),
    ..FRF
};

/// Motion records, where they differ from FRFs.
const MOTION: Policy = Policy {
    bounded: false,
    penalty: Some(8.0),
    // 1000 null simulations: rarer ones are not resolved.
    alpha: 0.005,
    least_share: 0.03,
    implausible: 4.0,
    left_out_generic: 0.5,
    advantage: 0.5,
    ..FRF
};

impl Policy {
    /// Returns the numbers for a kind of data.
    pub fn of(data: DataKind) -> &'static Policy {
        match data {
            DataKind::Frf => &FRF,
            DataKind::Modes => &MODES,
            DataKind::Motion => &MOTION,
        }
    }

    /// Returns the difference of χ² attributable to model error: `of_gain`, at most the misfit beyond null
    /// simulations where these bound it.
    pub(super) fn margin(&self, of_gain: f64, chi_square: f64, excess: f64) -> f64 {
        let beyond_nulls = chi_square * (1.0 - 1.0 / excess);
        if self.bounded { of_gain.min(beyond_nulls) } else { of_gain }
    }

    /// Returns the largest excess with which corrected records agree with the model, given that before.
    pub(super) fn reach(&self, before: f64) -> f64 {
        self.agrees + self.allowance * before
    }
}

/// Difference of χ² within which fits are indistinguishable.
pub const EQUIVALENT: f64 = FRF.equivalent;
/// Number of generic impedances that locate a discrepancy, and largest number of their parameters.
pub(super) const LOCATIONS: (usize, usize) = (5, 3);

// Probabilities.
/// Prior probabilities of the kinds of explanations: each is shared equally by all explanations of its kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PriorProbabilities {
    /// The machine as described, within its tolerances.
    pub none: f64,
    /// One effect of the library, or number of the description.
    pub effect: f64,
    /// A combination.
    pub combination: f64,
    /// A cause that the library lacks, at an interface.
    pub unknown: f64,
    /// A fault of the measuring chain of all records.
    pub fault: f64,
}

/// Prior probabilities: half of the machines under test lack nothing. All effects together, and combinations of two,
/// one in fifteen of these; a cause that no library has, and a fault of the measuring chain of all records.
pub(super) const PRIOR: PriorProbabilities =
    PriorProbabilities { none: 0.5, effect: 0.3, combination: 0.02, unknown: 0.08, fault: 0.1 };
/// Temperature, by which ln of the evidence is divided: errors of the model that no discrepancy describes make it too
/// certain. Of 1 to 10 the one with the largest mean ln of the probability of the truth on 45 machines.
pub(super) const TEMPERATURE: f64 = 2.0;
/// Probability with which a stated set holds what is missing, or its place.
pub(super) const SHARE: f64 = 0.9;

// Null simulations.
/// Least scale of a reduction of χ², in units of that by noise alone per parameter; for modes per added
/// parameter.
pub(super) const LEAST_SCALE: f64 = 3.0;
/// Factor of the squared number of added parameters in the least scale of FRFs. Null simulations are
/// projected on single directions, while a fit searches all directions jointly and, with a frequency among
/// them, the whole band.
pub(super) const SQUARED_SCALE: f64 = 0.6;
/// Least and largest variance of the residuals of modes in a draw: their weights are a model error that is
/// hardly known.
pub(super) const MODE_VARIANCE: (f64, f64) = (1.0, 2.5);

// Which fits are physical.
/// Least distance of a power of iω from 0 that counts as another measured quantity.
pub(super) const LEAST_POWER: f64 = 0.6;
/// Range of lever arms, in lengths of the arm at which the nut takes part in a motion. Where both arms are
/// below it, the fit is a resonator in the path of the force. No table has a longer arm: a mass that hardly
/// rocks stands for another effect.
pub(super) const ARMS: (f64, f64) = (0.3, 8.0);

// Faults of records.
/// Largest n·R² of phase steps that are unrelated: exceeded by one of a thousand records of noise.
///
/// # Source  Rayleigh's test of uniformity, p = exp(−n·R²); Mardia and Jupp, Directional Statistics (2000),
///   section 6.3.
pub(super) const UNRELATED_PHASES: f64 = 6.9;
/// Quantile of the normal distribution beyond which a series is no noise: one of 30,000 of equal noise is
/// (1).
pub(super) const NO_NOISE: f64 = 4.0;
/// ln of the ratio of amplitudes at half of the power (1).
pub(super) const HALF_POWER: f64 = std::f64::consts::LN_2 / 2.0;
/// Ratio of an outlying gap to the median gap of other records, and of the largest ordinary one.
pub(super) const OUTLIER: (f64, f64) = (2.5, 1.5);
/// Least gap of a held-out record that contradicts the others, and its least ratio to the second largest.
pub(super) const HELD_OUT_OUTLIER: (f64, f64) = (0.2, 8.0);
/// Least factor, or its inverse, that is a wrong unit (1): smaller ones are the effect of a gain.
pub(super) const LEAST_UNIT: f64 = 2.0;
/// Least number of driving points that are active beyond errors of phase, and least share of all of them,
/// that are no fault of single records.
pub(super) const ACTIVE_RECORDS: (usize, f64) = (2, 1.0 / 3.0);
