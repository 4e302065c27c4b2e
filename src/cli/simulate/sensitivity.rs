//! `jointid simulate sensitivity`: a natural frequency over the stiffness of each joint.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use super::operating::{LoadArguments, find_operating, load_warnings};
use crate::arguments::{OutputArguments, Sources};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{load_machine, stamp};
use dynamics::model::{RodModel, Structure, elastic_frequencies_hz, undamped_modes};
use machine::{FitRule, Machine, Mechanism, Modifier, Operating, Parameter, Role, Scale};
use numeric::unit::omega_rad_s;
use report::simulation::{SensitivityDocument, SensitivityRow};

/// Arguments of `simulate sensitivity`.
#[derive(Debug, clap::Args)]
pub struct SensitivityArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Number of the natural frequency above 0, from 1
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub order: u16,
    /// Joints, comma-separated; all with a stiffness by default
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub joint: Option<Vec<String>>,
    /// Smallest factor on the stiffness
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 0.5)]
    pub from: f64,
    /// Largest factor on the stiffness
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 1.5)]
    pub to: f64,
    /// Number of factors
    #[arg(long, value_name = "N", default_value_t = 11, value_parser = clap::value_parser!(u16).range(2..=10_000))]
    pub steps: u16,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &SensitivityArguments) -> CommandResult {
    if !(given.from > 0.0 && given.to > given.from && given.to.is_finite()) {
        return Err(format!("--from {} --to {}: write factors above 0, the smaller one as --from", given.from, given.to));
    }
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let operating = find_operating(&loaded, given.nut_m, None, &given.load)?;
    let folder = prepare(&given.output)?;
    let start = machine.start();
    let order = usize::from(given.order);
    let chosen = chosen_joints(machine, given.joint.as_deref(), &operating)?;
    let frequency = |machine: &Machine, values: &[f64]| elastic_frequencies_hz(machine, order, values, &operating).get(order - 1).copied();
    let frequency_hz = frequency(machine, &start).ok_or_else(|| format!("--order {order}: the machine has no such natural frequency"))?;
    let energy = mode_energy(machine, &operating, frequency_hz)?;
    let count = usize::from(given.steps);
    let factors: Vec<f64> = (0..count).map(|i| given.from + (given.to - given.from) * i as f64 / (count - 1) as f64).collect();
    let mut joints = Vec::new();
    for index in chosen {
        let joint = &machine.joints[index];
        let scaled = with_factor(machine, index);
        let mut frequencies_hz = Vec::new();
        for factor in &factors {
            let values: Vec<f64> = start.iter().copied().chain([*factor]).collect();
            frequencies_hz.push(
                frequency(&scaled, &values).ok_or("the natural frequency does not exist at one of the factors; choose a narrower range")?,
            );
        }
        let (deformation, share) = energy.get(&joint.name).copied().unwrap_or((0.0, 0.0));
        joints.push(SensitivityRow {
            joint: joint.name.clone(),
            stiffness: joint.stiffness.at(&start, &operating),
            deformation,
            strain_energy_share: share,
            elasticity: 0.5 * share,
            frequencies_hz,
        });
    }
    joints.sort_by(|a, b| b.strain_energy_share.total_cmp(&a.strain_energy_share));
    let warnings = load_warnings(machine, &given.load);
    warn(&given.output, &warnings);
    let mut text = format!("{}\nnatural frequency {order}: {frequency_hz:.4} Hz\n\n", machine.title);
    let (low, high) = (factors[0], factors[count - 1]);
    let _ = writeln!(
        text,
        "{:<20} {:>11} {:>9} {:>10} {:>10} {:>10}",
        "joint",
        "stiffness",
        "energy %",
        "dlnf/dlnk",
        format!("f at {low}"),
        format!("f at {high}")
    );
    for row in &joints {
        let _ = writeln!(
            text,
            "{:<20} {:>11.4e} {:>9.2} {:>10.4} {:>10.3} {:>10.3}",
            row.joint,
            row.stiffness,
            100.0 * row.strain_energy_share,
            row.elasticity,
            row.frequencies_hz[0],
            row.frequencies_hz[count - 1]
        );
    }
    let document = SensitivityDocument {
        stamp: stamp("sensitivity", 0, true, &loaded, warnings),
        nut_m: operating.nut_m,
        order,
        frequency_hz,
        factors,
        joints,
    };
    deliver(&given.output, folder.as_ref(), "sensitivity.json", &document, &text)
}

/// Adds a factor on the stiffness of a joint, as a parameter appended to the others.
fn with_factor(machine: &Machine, joint: usize) -> Machine {
    let mut scaled = machine.clone();
    let index = scaled.parameters.len();
    scaled.parameters.push(Parameter {
        id: "factor".into(),
        unit: "1".into(),
        mechanism: Mechanism::Ratio,
        role: Role::Described,
        start: 1.0,
        lower: 0.0,
        upper: f64::INFINITY,
        scale: Scale::Linear,
        fit: FitRule::Never,
        prior: None,
        source: "sensitivity".into(),
        description: String::new(),
    });
    scaled.joints[joint].stiffness.modifiers.push(Modifier::Times(index));
    scaled
}

/// Returns the requested joints, or all that have a stiffness.
fn chosen_joints(machine: &Machine, names: Option<&[String]>, operating: &Operating) -> Result<Vec<usize>, String> {
    let start = machine.start();
    let stiff = |i: &usize| machine.joints[*i].stiffness.at(&start, operating) > 0.0;
    let Some(names) = names else { return Ok((0..machine.joints.len()).filter(stiff).collect()) };
    let mut chosen: Vec<usize> = Vec::new();
    for name in names {
        let known: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
        let index = machine.joints.iter().position(|j| j.name == *name);
        let index = index.ok_or_else(|| format!("--joint {name}: no such joint; the machine has {}", known.join(", ")))?;
        if chosen.contains(&index) {
            return Err(format!("--joint {name}: it is listed twice; name each joint once"));
        }
        if !stiff(&index) {
            return Err(format!("--joint {name}: it has no stiffness to vary; name another"));
        }
        chosen.push(index);
    }
    Ok(chosen)
}

/// Computes deformation and share of the strain energy of each joint in the mode at a frequency.
pub(super) fn mode_energy(machine: &Machine, operating: &Operating, frequency_hz: f64) -> Result<BTreeMap<String, (f64, f64)>, String> {
    let moving = machine.points.iter().position(|p| !p.fixed).ok_or("the machine has no point that moves")?;
    let structure = Arc::new(Structure::new(machine, moving, moving, RodModel::Exact).map_err(to_message)?);
    let mut model = structure.empty_model();
    model.update(machine, &machine.start(), operating);
    let modes = undamped_modes(&model, frequency_hz * (1.0 + 1e-6), &mut structure.workspace());
    let mode = modes.last().ok_or("the mode is not found a second time")?;
    let rows = model.strain_energy(machine, &machine.start(), operating, omega_rad_s(mode.frequency_hz), &mode.shape);
    Ok(rows.into_iter().map(|row| (row.name, (row.deformation.unwrap_or(0.0), row.share))).collect())
}
