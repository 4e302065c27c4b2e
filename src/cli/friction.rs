//! `jointid friction`: fits a Stribeck curve to friction at constant velocities.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

use crate::arguments::OutputArguments;
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{digest_file, stamp_files};
use machine::contact::{ContactError, Observation, ParameterEstimate, ScrewDrive, StribeckNoise, StribeckOptions, fit_stribeck};
use measurement::{FrictionTable, FrictionUnit, read_friction};
use report::simulation::{FrictionDocument, FrictionParameter, FrictionRow};

/// Noise models of friction measurements, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum NoiseName {
    /// The same standard deviation in all runs
    Uniform,
    /// Standard deviation proportional to the friction
    Proportional,
    /// Standard deviations from the column force_sd_n (or torque_sd_nm)
    Known,
}

/// Arguments of `friction`.
#[derive(Debug, clap::Args)]
pub struct FrictionArguments {
    /// Table with the columns velocity_m_s and force_n (or torque_nm), one run at constant velocity per line
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Lead of the screw (m per revolution); required with torque_nm
    #[arg(long, allow_negative_numbers = true, value_name = "M")]
    pub lead_m: Option<f64>,
    /// Efficiency between motor torque and screw, above 0 and at most 1
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 1.0)]
    pub efficiency: f64,
    /// Noise model of the measurements; by default known where the table has standard deviations, else uniform
    #[arg(long, value_enum)]
    pub noise: Option<NoiseName>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &FrictionArguments) -> CommandResult {
    let path = given.data.display().to_string();
    let table = read_friction(&path).map_err(to_message)?;
    let observations = observations(given, &table)?;
    let folder = prepare(&given.output)?;
    let has_sd = table.runs.iter().any(|run| run.sd.is_some());
    let noise = given.noise.unwrap_or(if has_sd { NoiseName::Known } else { NoiseName::Uniform });
    let (noise, word) = match noise {
        NoiseName::Uniform => (StribeckNoise::Uniform, "uniform"),
        NoiseName::Proportional => (StribeckNoise::Proportional, "proportional"),
        NoiseName::Known => (StribeckNoise::Known, "known"),
    };
    let fit = fit_stribeck(&observations, &StribeckOptions::new(noise)).map_err(|e| describe_error(&path, &table, &e))?;
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
    let parameters: BTreeMap<String, FrictionParameter> =
        named.iter().map(|(name, unit, e)| ((*name).to_string(), parameter(unit, e))).collect();
    let warnings: Vec<String> = named
        .iter()
        .filter(|(_, _, e)| e.at_bound)
        .map(|(name, _, _)| format!("{name} is at a bound: these runs do not determine it; add runs at velocities where it acts"))
        .collect();
    warn(&given.output, &warnings);
    let document = FrictionDocument {
        stamp: stamp_files("friction", vec![digest_file(&table.file)], warnings),
        noise: word.into(),
        parameters,
        residual_scatter: fit.residual_scatter,
        degrees_of_freedom: fit.degrees_of_freedom,
        least_friction_speed_m_s: fit.curve.least_friction_speed_m_per_s(),
        observations: observations
            .iter()
            .map(|o| FrictionRow {
                velocity_m_s: o.velocity_m_per_s,
                force_n: o.force_n,
                predicted_n: fit.curve.force_n(o.velocity_m_per_s),
            })
            .collect(),
    };
    let mut text = format!("Stribeck curve of {path}, {} runs, {word} noise\n\n", observations.len());
    for (name, unit, e) in &named {
        let interval = e.interval_95.map_or_else(|| "at a bound".into(), |i| format!("{:.6} … {:.6}", i.lower, i.upper));
        let _ = writeln!(text, "{name:<22} {:>14.6} {unit:<6} {interval}", e.value);
    }
    let _ =
        writeln!(text, "\nresidual scatter {:.4}, least friction at {:.6} m/s", fit.residual_scatter, document.least_friction_speed_m_s);
    deliver(&given.output, folder.as_ref(), "friction.json", &document, &text)
}

/// Converts the runs to observations of force.
fn observations(given: &FrictionArguments, table: &FrictionTable) -> Result<Vec<Observation>, String> {
    let factor = match (table.unit, given.lead_m) {
        (FrictionUnit::Force, None) => 1.0,
        (FrictionUnit::Force, Some(_)) => return Err("--lead-m: the table gives forces, which need no lead; leave it out".into()),
        (FrictionUnit::Torque, None) => {
            return Err("--lead-m: the table gives torques; write the lead of the screw in m per revolution".into());
        }
        (FrictionUnit::Torque, Some(lead_m)) => {
            ScrewDrive::new(lead_m, given.efficiency).map_err(|e| format!("--lead-m, --efficiency: {e}"))?.force_n(1.0)
        }
    };
    let observation = |run: &measurement::FrictionRun| Observation {
        velocity_m_per_s: run.velocity_m_s,
        force_n: factor * run.value,
        sd_n: run.sd.map(|sd| factor * sd),
    };
    Ok(table.runs.iter().map(observation).collect())
}

/// Describes an error, with the line of the table where it lies in one.
fn describe_error(path: &str, table: &FrictionTable, error: &ContactError) -> String {
    let fault = match error {
        ContactError::NonFiniteData { row } => Some((row, "a number is not finite".to_string())),
        ContactError::ZeroVelocity { row } => {
            Some((row, "the velocity is 0: only sliding at constant velocity determines the friction curve; remove the line".into()))
        }
        ContactError::StandardDeviation { row, value } => Some((row, format!("the standard deviation is {value}; write a number above 0"))),
        ContactError::MissingStandardDeviation { row } => {
            Some((row, "has no standard deviation, which --noise known requires; write one, or choose another --noise".into()))
        }
        _ => None,
    };
    match fault {
        Some((row, fault)) => format!("{path}, line {}: {fault}", table.runs.get(*row).map_or(0, |run| run.line)),
        None => format!("{path}: {error}"),
    }
}
