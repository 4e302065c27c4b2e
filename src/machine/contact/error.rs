//! Errors of contacts, their loads and their data.

use thiserror::Error;

/// Why a contact, a joint or a friction curve cannot be computed; the message states the correction.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactError {
    /// A quantity that must be positive and finite is not.
    #[error("{what} must be positive and finite, not {value}")]
    NotPositive {
        /// The quantity with its unit.
        what: &'static str,
        /// Given value.
        value: f64,
    },
    /// A quantity that must be finite is not.
    #[error("{what} must be a finite number, not {value}")]
    NotFinite {
        /// The quantity with its unit.
        what: &'static str,
        /// Given value.
        value: f64,
    },
    /// A quantity outside its range.
    #[error("{what} must lie between {lower} and {upper}, not at {value}")]
    OutOfRange {
        /// The quantity with its unit.
        what: &'static str,
        /// Given value.
        value: f64,
        /// Smallest allowed value.
        lower: f64,
        /// Largest allowed value.
        upper: f64,
    },
    /// A contact angle outside (0°, 90°).
    #[error("the contact angle must lie strictly between 0° and 90°, not at {angle_deg}°")]
    ContactAngle {
        /// Given value (degrees).
        angle_deg: f64,
    },
    /// A groove not wider than the ball.
    #[error(
        "the conformity of the {race} race is the groove radius over the ball diameter and must exceed 0.5, not be {value}"
    )]
    Conformity {
        /// The race.
        race: &'static str,
        /// Given value.
        value: f64,
    },
    /// Balls too large for their pitch diameter.
    #[error("balls of {ball_diameter_m} m do not fit a pitch diameter of {pitch_diameter_m} m")]
    BallTooLarge {
        /// Ball diameter (m).
        ball_diameter_m: f64,
        /// Pitch diameter (m).
        pitch_diameter_m: f64,
    },
    /// Two bodies that touch along a line or conform to each other.
    #[error(
        "the bodies touch along a line or conform (curvature difference {difference}, must stay below {limit}): no point contact"
    )]
    LineContact {
        /// Curvature difference F(ρ).
        difference: f64,
        /// Largest difference the formula is used for.
        limit: f64,
    },
    /// A contact loaded above its elastic pressure limit.
    #[error(
        "load beyond the validity of the formula: the largest contact pressure would be {pressure_gpa:.3} GPa, the limit is {limit_gpa:.3} GPa"
    )]
    BeyondValidity {
        /// Pressure at the given load (GPa).
        pressure_gpa: f64,
        /// The limit (GPa).
        limit_gpa: f64,
    },
    /// Fewer observations than a fit with intervals needs.
    #[error("{found} observations are too few: four parameters with intervals need at least {needed}")]
    TooFewData {
        /// Observations given.
        found: usize,
        /// Observations needed.
        needed: usize,
    },
    /// Too few different speeds, regardless of repetitions.
    #[error(
        "{found} different speed(s) cannot determine the four parameters of the friction curve: measure at {needed} or more"
    )]
    TooFewSpeeds {
        /// Different |v| given.
        found: usize,
        /// Different |v| needed.
        needed: usize,
    },
    /// An observation with a number that is not finite.
    #[error("observation {row} has a velocity, force or standard deviation that is not finite")]
    NonFiniteData {
        /// Index, from 0.
        row: usize,
    },
    /// An observation at rest.
    #[error("observation {row} is at rest: only sliding at constant velocity determines the friction curve")]
    ZeroVelocity {
        /// Index, from 0.
        row: usize,
    },
    /// A standard deviation that is not positive.
    #[error("observation {row} has the standard deviation {value}, which must be positive")]
    StandardDeviation {
        /// Index, from 0.
        row: usize,
        /// Given value.
        value: f64,
    },
    /// Known noise without a standard deviation.
    #[error("observation {row} has no standard deviation, which `Noise::Known` needs for all observations")]
    MissingStandardDeviation {
        /// Index, from 0.
        row: usize,
    },
    /// Friction measured with the sign opposite to the velocity.
    #[error(
        "the forces oppose their velocities: give the friction the sign of the velocity, like the driving torque"
    )]
    OpposingForces,
    /// An empty range.
    #[error("the range of the Stribeck velocity from {lower} to {upper} m/s is empty")]
    EmptyRange {
        /// Lower end (m/s).
        lower: f64,
        /// Upper end (m/s).
        upper: f64,
    },
    /// A force that the rising branch does not reach.
    #[error("the friction curve does not reach {force_n} N on its rising branch{reason}")]
    NoRisingBranch {
        /// The requested force (N).
        force_n: f64,
        /// The reason, as the end of the sentence.
        reason: &'static str,
    },
    /// An equation whose root was not bracketed: an error of this code.
    #[error("the equation for {what} has no root where theory predicts one: please report the input")]
    NoRoot {
        /// The unknown.
        what: &'static str,
    },
}

/// Returns the value if it is positive and finite.
pub(super) fn positive(what: &'static str, value: f64) -> Result<f64, ContactError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(ContactError::NotPositive { what, value }) }
}

/// Returns the value if it is finite.
pub(super) fn finite(what: &'static str, value: f64) -> Result<f64, ContactError> {
    if value.is_finite() { Ok(value) } else { Err(ContactError::NotFinite { what, value }) }
}

/// Returns the value if it lies in [lower, upper].
pub(super) fn within(what: &'static str, value: f64, lower: f64, upper: f64) -> Result<f64, ContactError> {
    if value >= lower && value <= upper {
        Ok(value)
    } else {
        Err(ContactError::OutOfRange { what, value, lower, upper })
    }
}

/// Returns the pressure if it is within its limit.
pub(super) fn check_pressure(pressure_pa: f64, limit_pa: f64) -> Result<f64, ContactError> {
    if pressure_pa <= limit_pa {
        Ok(pressure_pa)
    } else {
        Err(ContactError::BeyondValidity { pressure_gpa: pressure_pa / 1e9, limit_gpa: limit_pa / 1e9 })
    }
}
