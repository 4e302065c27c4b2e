//! `jointid simulate hold`: impedance of the drive's loops, or gains from an identified spring and damper.

use std::path::PathBuf;

use super::operating::{LoadArguments, find_operating};
use crate::arguments::{OutputArguments, Sources};
use crate::identified::read_identification;
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{load_machine, stamp};
use dynamics::motion::{ServoImpedance, gains_of};
use machine::PointMotion;
use numeric::unit::omega_rad_s;
use report::columns;
use report::loops::{HoldDocument, HoldGains, HoldRow};

/// Arguments of `simulate hold`.
#[derive(Debug, clap::Args)]
pub struct HoldArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Frequencies (Hz), comma-separated
    #[arg(long, value_name = "F", value_delimiter = ',', default_value = "1,2,5,10,20,50,100,200,400")]
    pub at_hz: Vec<f64>,
    /// identification.json whose k_s and c_s are converted to gains
    #[arg(long, value_name = "FILE", requires = "constant", requires = "lead_m")]
    pub result: Option<PathBuf>,
    /// With --result: torque per output of the velocity loop (N·m/A or N·m/V)
    #[arg(long, value_name = "G", requires = "result", allow_negative_numbers = true)]
    pub constant: Option<f64>,
    /// With --result: lead of the screw (m per revolution)
    #[arg(long, value_name = "M", requires = "result", allow_negative_numbers = true)]
    pub lead_m: Option<f64>,
    /// With --result: parameters of stiffness and damping, comma-separated
    #[arg(long, value_name = "IDS", value_delimiter = ',', default_value = "k_s,c_s")]
    pub ids: Vec<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &HoldArguments) -> CommandResult {
    match &given.result {
        Some(path) => from_result(given, path),
        None => from_gains(given),
    }
}

fn from_gains(given: &HoldArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let operating = find_operating(&loaded, None, None, &LoadArguments::default())?;
    let hold = ServoImpedance::new(machine, &machine.start(), &operating).map_err(|e| format!("{}: {e}", loaded.config.path))?;
    if let Some(f) = given.at_hz.iter().find(|f| !(**f > 0.0 && f.is_finite())) {
        return Err(format!("--at-hz {f}: write frequencies above 0 Hz"));
    }
    if let Some(f) = given.at_hz.iter().find(|f| **f > hold.highest_hz()) {
        return Err(format!(
            "--at-hz {f}: the impedance of the loops is defined up to {} Hz, half the slowest sampling rate; write no more",
            hold.highest_hz()
        ));
    }
    let folder = prepare(&given.output)?;
    let row = |&frequency_hz: &f64| {
        let omega = omega_rad_s(frequency_hz);
        let z = hold.at_driven_point(omega).map_err(to_message)?;
        Ok(HoldRow { frequency_hz, stiffness: z.re, damping: z.im / omega, phase_deg: z.arg().to_degrees() })
    };
    let rows = given.at_hz.iter().map(row).collect::<Result<Vec<_>, String>>()?;
    let point = &machine.points[hold.on];
    let rotates = point.motion == PointMotion::Rotation;
    let (k, c) = if rotates { ("N·m/rad", "N·m·s/rad") } else { ("N/m", "N·s/m") };
    let heads = ["frequency Hz".into(), format!("k_s {k}"), format!("c_s {c}"), "phase °".into()];
    let cells = |r: &HoldRow| {
        vec![format!("{}", r.frequency_hz), format!("{:.4e}", r.stiffness), format!("{:.4e}", r.damping), format!("{:.2}", r.phase_deg)]
    };
    let mut text = format!("impedance of the drive at «{}» as spring and damper\n{}", point.name, columns(&heads, rows.iter().map(cells)));
    if rows.iter().any(|r| r.damping < 0.0) {
        text += "where c_s is below 0, delay or integral action makes the loops supply energy: they do not damp there\n";
    }
    let document = HoldDocument { stamp: stamp("hold", 0, true, &loaded, Vec::new()), point: Some(point.name.clone()), rows, gains: None };
    deliver(&given.output, folder.as_ref(), "hold.json", &document, &text)
}

fn from_result(given: &HoldArguments, path: &std::path::Path) -> CommandResult {
    let (identified, input) = read_identification(path)?;
    let [k, c] = given.ids.as_slice() else {
        return Err(format!("--ids {}: write two parameters, of stiffness and damping", given.ids.join(",")));
    };
    let value = |id: &String| {
        identified.parameters.get(id).map(|p| (p.value, p.identifiable)).ok_or_else(|| {
            let known: Vec<&str> = identified.parameters.keys().map(String::as_str).collect();
            format!("{}: has no parameter «{id}»; it has {}; name others by --ids", path.display(), known.join(", "))
        })
    };
    let ((stiffness, identifiable_k), (damping, identifiable_c)) = (value(k)?, value(c)?);
    let (constant, lead_m) = (given.constant.unwrap_or(f64::NAN), given.lead_m.unwrap_or(f64::NAN));
    for (key, x) in [("--constant", constant), ("--lead-m", lead_m), (k, stiffness), (c, damping)] {
        if !(x > 0.0 && x.is_finite()) {
            return Err(format!("{key} {x}: gains need a number above 0"));
        }
    }
    let folder = prepare(&given.output)?;
    let (position_gain_per_s, velocity_gain) = gains_of(stiffness, damping, constant, lead_m);
    let loaded = load_machine(&given.sources)?;
    let mut stamp = stamp("hold", 0, true, &loaded, Vec::new());
    for (id, identifiable) in [(k, identifiable_k), (c, identifiable_c)] {
        if identifiable != Some(true) {
            stamp.warnings.push(format!("{id} is not identifiable from these data: the gains depend on its start value or its range"));
        }
    }
    stamp.inputs.push(input);
    warn(&given.output, &stamp.warnings);
    let text = format!(
        "{k} {stiffness:.4e} N·m/rad and {c} {damping:.4e} N·m·s/rad correspond to the gains\n\
         position loop {position_gain_per_s:.4} 1/s ({:.1} 1/min)\nvelocity loop {velocity_gain:.4} per m/s\n",
        60.0 * position_gain_per_s
    );
    let gains = Some(HoldGains { stiffness, damping, position_gain_per_s, velocity_gain });
    let document = HoldDocument { stamp, point: None, rows: Vec::new(), gains };
    deliver(&given.output, folder.as_ref(), "hold.json", &document, &text)
}
