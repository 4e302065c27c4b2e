//! `jointid simulate modes`: undamped natural frequencies and mode shapes.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use super::operating::{LoadArguments, find_operating, load_warnings, require_positive};
use crate::arguments::{OutputArguments, RodArguments, Sources};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{load_machine, stamp};
use dynamics::model::{Structure, undamped_modes};
use machine::Machine;
use numeric::unit::omega_rad_s;
use report::simulation::{ModeRow, ModesDocument};

/// Arguments of `simulate modes`.
#[derive(Debug, clap::Args)]
pub struct ModesArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Position of the measurement set; mid-stroke by default
    #[arg(long, value_name = "NAME", conflicts_with = "nut_m")]
    pub position: Option<String>,
    /// Nut position from the left end of the screw (m)
    #[arg(long, value_name = "M")]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Highest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1000.0)]
    pub max_hz: f64,
    #[command(flatten)]
    pub rods: RodArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &ModesArguments) -> CommandResult {
    let max_hz = require_positive("--max-hz", given.max_hz)?;
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let operating = find_operating(&loaded, given.nut_m, given.position.as_deref(), &given.load)?;
    let folder = prepare(&given.output)?;
    let first = machine.points.iter().position(|p| !p.fixed).ok_or("the machine has no point that moves")?;
    let structure = Arc::new(Structure::new(machine, first, first, given.rods.represent()).map_err(to_message)?);
    let mut model = structure.empty_model();
    model.update(machine, &machine.start(), &operating);
    let modes: Vec<ModeRow> = undamped_modes(&model, max_hz, &mut structure.workspace())
        .into_iter()
        .enumerate()
        .map(|(at, mode)| {
            let omega = omega_rad_s(mode.frequency_hz);
            // A rigid-body mode has no strain energy.
            let energy = match mode.frequency_hz > 0.0 {
                true => model.strain_energy(machine, &machine.start(), &operating, omega, &mode.shape),
                false => Vec::new(),
            };
            ModeRow {
                order: at + 1,
                frequency_hz: mode.frequency_hz,
                damping_ratio: mode.damping_ratio,
                shape: shape(machine, &structure, &mode.shape),
                damped_hz: mode.damping_ratio.filter(|z| *z < 1.0).map(|z| mode.frequency_hz * (1.0 - z * z).sqrt()),
                deformation: energy.iter().filter_map(|e| Some((e.name.clone(), e.deformation?))).collect(),
                strain_energy_share: energy.into_iter().map(|e| (e.name, e.share)).collect(),
            }
        })
        .collect();
    let warnings = load_warnings(machine, &given.load);
    warn(&given.output, &warnings);
    let document = ModesDocument {
        stamp: stamp("modes", 0, true, &loaded, warnings),
        nut_m: operating.nut_m,
        velocity_m_s: operating.velocity_m_s,
        acceleration_m_s2: operating.acceleration_m_s2,
        force_n: operating.force_n,
        modes,
    };
    let mut text = format!("{}\n", machine.title);
    if let Some(nut_m) = operating.nut_m {
        let _ = writeln!(text, "nut at {nut_m} m");
    }
    let _ = writeln!(text, "\n order  frequency Hz   damping %   largest at     most strain energy in");
    for mode in &document.modes {
        let damping = mode.damping_ratio.map_or_else(|| "–".into(), |z| format!("{:.2}", 100.0 * z));
        let largest = mode.shape.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map_or("–", |(name, _)| name);
        let joints = mode.strain_energy_share.iter().filter(|(name, _)| !name.contains('/'));
        let strained =
            joints.max_by(|a, b| a.1.total_cmp(b.1)).map_or_else(String::new, |(name, x)| format!("{name} ({:.0} %)", 100.0 * x));
        let line = format!("{:>6}  {:>12.4}  {:>10}   {largest:<14} {strained}", mode.order, mode.frequency_hz, damping);
        let _ = writeln!(text, "{}", line.trim_end());
    }
    deliver(&given.output, folder.as_ref(), "modes.json", &document, &text)
}

/// Returns the deflection of every point of the machine.
fn shape(machine: &Machine, structure: &Structure, deflection: &[f64]) -> BTreeMap<String, f64> {
    if deflection.is_empty() {
        return BTreeMap::new();
    }
    let of = |point: usize| structure.coordinate_of(point).map_or(0.0, |c| deflection[c]);
    machine.points.iter().enumerate().map(|(i, p)| (p.name.clone(), of(i))).collect()
}
