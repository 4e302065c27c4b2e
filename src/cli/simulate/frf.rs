//! `jointid simulate frf`: frequency response functions of a machine.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

use num_complex::Complex64;

use super::drive::describe_pole;
use super::operating::{LoadArguments, find_operating, load_warnings, require_positive};
use crate::arguments::{OutputArguments, QuantityName, Sources};
use crate::identified::{check_identification, identified_machine, identified_values, read_identification};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{load_again, load_machine, stamp};
use dynamics::model::{RodModel, Structure};
use dynamics::motion::{LinearLoops, MotionError, ServoImpedance, SimulationSettings};
use machine::{Chain, Machine, Operating};
use numeric::unit::omega_rad_s;
use report::document::FrfsDocument;

/// Arguments of `simulate frf`.
#[derive(Debug, clap::Args)]
pub struct FrfArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions of the measurement set, comma-separated; all by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "nut_m")]
    pub position: Option<Vec<String>>,
    /// Nut position from the left end of the screw (m)
    #[arg(long, value_name = "M")]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Parameter values from this identification.json instead of the start values
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// Lowest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub from_hz: f64,
    /// Highest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1000.0)]
    pub to_hz: f64,
    /// Frequency step (Hz)
    #[arg(long, value_name = "F", default_value_t = 0.5)]
    pub step_hz: f64,
    /// Response point; that of the measurement set by default
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Excitation point; that of the measurement set by default
    #[arg(long, value_name = "POINT")]
    pub excitation: Option<String>,
    /// Close the loops of the drive, which hold the machine
    #[arg(long)]
    pub closed_loop: bool,
    /// Quantity to compute
    #[arg(long, value_enum, default_value = "receptance")]
    pub quantity: QuantityName,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &FrfArguments) -> CommandResult {
    let step = require_positive("--step-hz", given.step_hz)?;
    let from = require_positive("--from-hz", given.from_hz)?;
    if !(given.to_hz >= from && given.to_hz.is_finite()) {
        return Err(format!("--to-hz {}: write a frequency from {from} Hz", given.to_hz));
    }
    let steps = ((given.to_hz - from) / step + 1e-9).floor();
    if !(steps < 1e6) {
        return Err(format!("--step-hz {step}: makes {steps:e} lines, more than a million; choose a larger step"));
    }
    let lines = steps as usize + 1;
    // A result names its own machine.
    let (identified, input) = given.result.as_deref().map(read_identification).transpose()?.unzip();
    let Sources { measurements, set, without, .. } = &given.sources;
    let loaded = match &identified {
        None => load_machine(&given.sources)?,
        Some(identified) => load_again(&identified.settings.config, measurements, &identified.stamp, (set, without))?,
    };
    let identified_as = match (&given.result, &identified) {
        (Some(path), Some(identified)) => {
            check_identification(path, identified)?;
            Some(identified_machine(identified, &loaded, &identified_values(path, identified, &loaded.config)?)?)
        }
        _ => None,
    };
    let (machine, values) = identified_as.unwrap_or_else(|| (loaded.config.machine.clone(), loaded.config.machine.start()));
    let machine = &machine;
    let point = |own: &Option<String>, set: &Option<String>, key: &str| {
        let name = own.as_ref().or(set.as_ref()).ok_or_else(|| format!("{key}: name a point of the machine"))?;
        machine.point(name).ok_or_else(|| {
            let known: Vec<&str> = machine.points.iter().map(|p| p.name.as_str()).collect();
            format!("{key} {name}: no such point; the machine has {}", known.join(", "))
        })
    };
    let response = point(&given.response, &loaded.set.response, "--response")?;
    let excitation = point(&given.excitation, &loaded.set.excitation, "--excitation")?;
    let mut conditions = Vec::new();
    match (&given.position, given.nut_m) {
        (None, Some(nut_m)) => conditions.push((format!("{nut_m}"), find_operating(&loaded, Some(nut_m), None, &given.load)?)),
        (names, _) => {
            // A machine without a nut is the same at every position.
            let positions = loaded.set.positions.iter().filter(|_| machine.stroke_m().is_some());
            let all: Vec<String> = positions.map(|p| p.name.clone()).collect();
            for name in names.as_ref().unwrap_or(&all) {
                conditions.push((name.clone(), find_operating(&loaded, None, Some(name), &given.load)?));
            }
            if conditions.is_empty() {
                let place = if machine.stroke_m().is_some() { "mid-stroke" } else { "machine" };
                conditions.push((place.into(), find_operating(&loaded, None, None, &given.load)?));
            }
        }
    }
    let representation = identified.as_ref().and_then(|i| i.settings.lumps).map_or(RodModel::Exact, RodModel::Lumped);
    let folder = prepare(&given.output)?;
    let quantity = given.quantity.quantity();
    let structure = Arc::new(Structure::new(machine, response, excitation, representation).map_err(to_message)?);
    let (mut model, mut work) = (structure.empty_model(), structure.workspace());
    let frequency_hz: Vec<f64> = (0..lines).map(|i| from + step * i as f64).collect();
    let mut positions = BTreeMap::new();
    let mut text = String::from("position,frequency_hz,real,imag\n");
    for (name, operating) in conditions {
        model.update(machine, &values, &operating);
        let chain = machine.chain.at(&values, &operating);
        let mut row = Vec::with_capacity(lines);
        let omegas: Vec<f64> = frequency_hz.iter().copied().map(omega_rad_s).collect();
        let receptances = match given.closed_loop {
            false => model.sweep(&omegas, &mut work),
            true => closed_receptances(machine, &values, &operating, (response, excitation, representation), &omegas)?,
        };
        for ((&f, &omega), receptance) in frequency_hz.iter().zip(&omegas).zip(receptances) {
            let recorded = Chain::log_factor(chain, omega).exp();
            let h = receptance * quantity.from_receptance(omega) * recorded;
            let _ = writeln!(text, "{name},{f},{:e},{:e}", h.re, h.im);
            row.push([h.re, h.im]);
        }
        positions.insert(name, row);
    }
    let document = FrfsDocument {
        stamp: {
            let warnings = load_warnings(machine, &given.load);
            warn(&given.output, &warnings);
            let mut stamp = stamp("frf", 0, true, &loaded, warnings);
            stamp.inputs.extend(input);
            stamp
        },
        quantity: quantity.word().into(),
        response: machine.points[response].name.clone(),
        excitation: machine.points[excitation].name.clone(),
        closed_loop: given.closed_loop,
        frequency_hz,
        positions,
    };
    deliver(&given.output, folder.as_ref(), "frf.json", &document, &text)
}

/// Computes receptances with the loops of the drive closed.
fn closed_receptances(
    machine: &Machine,
    values: &[f64],
    operating: &Operating,
    (response, excitation, rods): (usize, usize, RodModel),
    omega_rad_s: &[f64],
) -> Result<Vec<Complex64>, String> {
    let fault = |e: MotionError| format!("--closed-loop: {e}");
    let hold = ServoImpedance::new(machine, values, operating).map_err(fault)?;
    let settings = SimulationSettings { operating: *operating, ..SimulationSettings::default() };
    if let Some(pole) = LinearLoops::new(machine, values, &settings).map_err(fault)?.unstable() {
        return Err(format!("--closed-loop: the loops are unstable: {}", describe_pole(&pole)));
    }
    let highest_hz = hold.highest_hz();
    if omega_rad_s.iter().any(|omega| *omega > numeric::unit::omega_rad_s(highest_hz)) {
        return Err(format!("--to-hz: closed loops are defined up to {highest_hz} Hz, half the slowest sampling rate; write no more"));
    }
    let mut open = BTreeMap::new();
    let among: Vec<usize> = hold.points().into_iter().chain([response]).collect();
    for &at in &among {
        for force in [hold.on, excitation] {
            if let Entry::Vacant(place) = open.entry((at, force)) {
                let structure = Arc::new(Structure::new(machine, at, force, rods).map_err(to_message)?);
                let mut model = structure.empty_model();
                model.update(machine, values, operating);
                place.insert(model.sweep(omega_rad_s, &mut structure.workspace()));
            }
        }
    }
    let at = |(line, omega): (usize, &f64)| hold.close(*omega, response, excitation, |point, force| open[&(point, force)][line]);
    Ok(omega_rad_s.iter().enumerate().map(at).collect())
}
