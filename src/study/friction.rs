//! Friction of an axis at constant velocities, as a Stribeck curve.

use crate::stamp::{digest_file, stamp_files};
use crate::{StudyError, StudyResult};
use machine::contact::{
    ContactError, Observation, ParameterEstimate, ScrewDrive, StribeckNoise, StribeckOptions, fit_stribeck,
};
use measurement::{FrictionRun, FrictionTable, FrictionUnit, read_friction};
use report::simulation::{FrictionDocument, FrictionParameter, FrictionRow};

/// A table of friction, and how its curve is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionRequest {
    /// Path of the table, with the columns `velocity_m_s` and `force_n` (or `torque_nm`), one run at constant
    /// velocity per line.
    pub path: String,
    /// Lead of the screw (m per revolution); required where the table gives torques.
    pub lead_m: Option<f64>,
    /// Efficiency between motor torque and screw (1), above 0 and at most 1.
    pub efficiency: f64,
    /// Model of the measurement noise; by default known where the table has standard deviations, else
    /// uniform.
    pub noise: Option<StribeckNoise>,
}

impl Default for FrictionRequest {
    fn default() -> Self {
        FrictionRequest { path: String::new(), lead_m: None, efficiency: 1.0, noise: None }
    }
}

/// Fits a Stribeck curve to the runs of a table.
///
/// # Errors  the table cannot be read, a lead is missing or not needed, the runs do not suffice.
pub fn friction(request: &FrictionRequest) -> StudyResult<FrictionDocument> {
    let table = read_friction(&request.path)?;
    let observations = observations(request, &table)?;
    let has_sd = table.runs.iter().any(|run| run.sd.is_some());
    let noise = request.noise.unwrap_or(if has_sd { StribeckNoise::Known } else { StribeckNoise::Uniform });
    let fit = fit_stribeck(&observations, &StribeckOptions::new(noise))
        .map_err(|e| describe_error(&request.path, &table, &e))?;
    let named = [
        ("coulomb_n", "N", fit.coulomb_n),
        ("static_n", "N", fit.static_n),
        ("viscous_n_s_per_m", "N*s/m", fit.viscous_n_s_per_m),
        ("stribeck_velocity_m_s", "m/s", fit.stribeck_velocity_m_per_s),
    ];
    let parameter = |unit: &str, e: &ParameterEstimate| FrictionParameter {
        value: e.value,
        unit: unit.into(),
        interval95: e.interval_95.map(|i| [i.lower, i.upper]),
        at_bound: e.at_bound,
    };
    let highest_m_s = observations.iter().map(|run| run.velocity_m_per_s.abs()).fold(0.0, f64::max);
    let contradiction = fit.contradicted.map(|curve| {
        let course = if curve.static_n < curve.coulomb_n {
            "it rises from rest where the curve falls".to_string()
        } else if curve.viscous_n_s_per_m >= 0.0 {
            "no curve with constants above 0 fits it".to_string()
        } else {
            format!("at the highest speeds it still falls with speed, by {:.3} N·s/m", -curve.viscous_n_s_per_m)
        };
        format!(
            "the friction of these runs follows no Stribeck curve: {course}; do not use these values, write the runs as the friction table of a machine file instead"
        )
    });
    let bounds = named
        .iter()
        .filter(|(_, _, e)| e.at_bound)
        .map(|(name, _, _)| {
            format!(
                "{name} is at a bound: these runs do not determine it; add runs at velocities where it acts"
            )
        })
        .filter(|_| fit.contradicted.is_none());
    let warnings = contradiction.into_iter().chain(bounds).collect();
    Ok(FrictionDocument {
        stamp: stamp_files("friction", vec![digest_file(&table.file)], warnings),
        noise: match noise {
            StribeckNoise::Uniform => "uniform",
            StribeckNoise::Proportional => "proportional",
            StribeckNoise::Known => "known",
        }
        .into(),
        parameters: named.iter().map(|(name, unit, e)| ((*name).to_string(), parameter(unit, e))).collect(),
        residual_scatter: fit.residual_scatter,
        degrees_of_freedom: fit.degrees_of_freedom,
        least_friction_speed_m_s: fit.curve.least_friction_speed_up_to(highest_m_s),
        highest_speed_m_s: highest_m_s,
        observations: observations
            .iter()
            .map(|o| FrictionRow {
                velocity_m_s: o.velocity_m_per_s,
                force_n: o.force_n,
                predicted_n: fit.curve.force_n(o.velocity_m_per_s),
            })
            .collect(),
    })
}

/// Converts the runs to observations of force.
fn observations(request: &FrictionRequest, table: &FrictionTable) -> StudyResult<Vec<Observation>> {
    let efficiency = request.efficiency;
    if !(efficiency > 0.0 && efficiency <= 1.0) {
        return Err(StudyError::setting("efficiency", efficiency, "write a number above 0, up to 1"));
    }
    let factor = match (table.unit, request.lead_m) {
        (FrictionUnit::Force, None) => 1.0,
        (FrictionUnit::Force, Some(_)) => {
            return Err(StudyError::setting(
                "lead_m",
                "",
                "the table gives forces, which need no lead; leave it out",
            ));
        }
        (FrictionUnit::Torque, None) => {
            return Err(StudyError::setting(
                "lead_m",
                "",
                "the table gives torques; write the lead of the screw in m per revolution",
            ));
        }
        (FrictionUnit::Torque, Some(lead_m)) => {
            let screw = ScrewDrive::new(lead_m, efficiency);
            screw.map_err(|e| StudyError::setting("lead_m", "", e.to_string()))?.force_n(1.0)
        }
    };
    let observation = |run: &FrictionRun| Observation {
        velocity_m_per_s: run.velocity_m_s,
        force_n: factor * run.value,
        sd_n: run.sd.map(|sd| factor * sd),
    };
    Ok(table.runs.iter().map(observation).collect())
}

/// Describes an error, with the line of the table where it lies in one.
fn describe_error(path: &str, table: &FrictionTable, error: &ContactError) -> StudyError {
    let fault = match error {
        ContactError::NonFiniteData { row } => Some((row, "a number is not finite".to_string())),
        ContactError::ZeroVelocity { row } => {
            Some((row, "the velocity is 0: only sliding at constant velocity determines the friction curve; remove the line".into()))
        }
        ContactError::StandardDeviation { row, value } => Some((row, format!("the standard deviation is {value}; write a number above 0"))),
        ContactError::MissingStandardDeviation { row } => {
            Some((row, "has no standard deviation, which known noise requires; write one, or choose another model of the noise".into()))
        }
        _ => None,
    };
    match fault {
        Some((row, fault)) => StudyError::input(
            format!("{path}, line {}", table.runs.get(*row).map_or(0, |run| run.line)),
            fault,
        ),
        None => StudyError::input(path, error.to_string()),
    }
}
