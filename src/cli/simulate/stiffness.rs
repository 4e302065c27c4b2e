//! `jointid simulate stiffness`: stiffness and natural frequencies over an operating variable.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::operating::{LoadArguments, find_operating, load_warnings};
use crate::arguments::{OutputArguments, Sources};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{load_machine, stamp};
use dynamics::model::{Matrices, elastic_frequencies_hz};
use machine::{LoadedPair, Machine, Operating};
use numeric::root::{Bracket, refine};
use report::columns;
use report::simulation::{ContactRow, Separation, SweepDocument, SweepRow};

/// Variables of a sweep, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum SweepVariable {
    /// Nut position (m)
    Position,
    /// Velocity (m/s)
    Velocity,
    /// Acceleration (m/s²)
    Acceleration,
    /// External force (N)
    Force,
}

/// Arguments of `simulate stiffness`.
#[derive(Debug, clap::Args)]
pub struct StiffnessArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Variable to sweep
    #[arg(long, value_enum)]
    pub along: SweepVariable,
    /// Start of the sweep; by default 2 % of the stroke for positions
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// End of the sweep; by default 98 % of the stroke for positions
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Number of steps
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub steps: u32,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Point at which to compute the static stiffness
    #[arg(long, value_name = "POINT")]
    pub at: Option<String>,
    /// Nut position (m) of a second, identical axis in series with the first, as in a cross table
    #[arg(long, allow_negative_numbers = true, value_name = "M", requires = "at")]
    pub in_series_with_nut_m: Option<f64>,
    /// Number of natural frequencies above 0 to compute
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(0..=50))]
    pub orders: u16,
    #[command(flatten)]
    pub output: OutputArguments,
}

impl SweepVariable {
    fn key(self) -> &'static str {
        match self {
            SweepVariable::Position => "nut_m",
            SweepVariable::Velocity => "velocity_m_s",
            SweepVariable::Acceleration => "acceleration_m_s2",
            SweepVariable::Force => "force_n",
        }
    }

    /// Returns the operating condition at one value of the variable.
    fn at(self, base: &Operating, x: f64) -> Operating {
        let mut operating = *base;
        *match self {
            SweepVariable::Position => &mut operating.nut_m,
            SweepVariable::Velocity => &mut operating.velocity_m_s,
            SweepVariable::Acceleration => &mut operating.acceleration_m_s2,
            SweepVariable::Force => &mut operating.force_n,
        } = Some(x);
        operating
    }
}

/// Runs the command.
pub fn run(given: &StiffnessArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let along = given.along;
    let base = find_operating(&loaded, given.nut_m, None, &given.load)?;
    let (from, to) = range(given, machine)?;
    let folder = prepare(&given.output)?;
    if let Some(point) = &given.at {
        known_point(machine, point)?;
    }
    let mut warnings = load_warnings(machine, &given.load);
    if along != SweepVariable::Position && machine.contacts.is_empty() {
        warnings.push(format!("this machine does not depend on {}: none of its joints is a [contact.…]", along.key()));
    }
    warn(&given.output, &warnings);
    let steps = given.steps as usize;
    let mut rows = Vec::with_capacity(steps);
    for step in 0..steps {
        let x = from + (to - from) * step as f64 / (steps - 1) as f64;
        let here = along.at(&base, x);
        let place = format!("{} = {x}", along.key());
        machine.check_operating(&place, &here).map_err(to_message)?;
        let mut row = sweep_row(machine, &here, x, usize::from(given.orders))?;
        if let Some(point) = &given.at {
            let mut k = static_stiffness(machine, &here, point)?;
            if let Some(second_m) = given.in_series_with_nut_m {
                let second = Operating { nut_m: Some(second_m), ..here };
                machine.check_operating("--in-series-with-nut-m", &second).map_err(to_message)?;
                k = 1.0 / (1.0 / k + 1.0 / static_stiffness(machine, &second, point)?);
            }
            row.static_stiffness = Some(k);
        }
        rows.push(row);
    }
    let separations: Vec<Separation> =
        machine.contacts.iter().flat_map(|contact| separations(contact, (from, to), |x| along.at(&base, x))).collect();
    let text = sweep_text(machine, along, given.at.as_deref(), &rows, &separations);
    let document = SweepDocument {
        stamp: stamp("stiffness", 0, true, &loaded, warnings),
        along: along.key().into(),
        point: given.at.clone(),
        in_series_with_nut_m: given.in_series_with_nut_m,
        separations,
        rows,
    };
    deliver(&given.output, folder.as_ref(), "stiffness.json", &document, &text)
}

/// Returns the range of the sweep.
fn range(given: &StiffnessArguments, machine: &Machine) -> Result<(f64, f64), String> {
    let default = match given.along {
        SweepVariable::Position => {
            let stroke_m = machine.stroke_m().ok_or("--along position: the machine has no nut; sweep another variable")?;
            Some((0.02 * stroke_m, 0.98 * stroke_m))
        }
        _ => None,
    };
    let need = |key: &str, own: Option<f64>, default: Option<f64>| {
        own.or(default).ok_or_else(|| format!("{key}: write the start and end of the sweep along {}", given.along.key()))
    };
    let (from, to) = (need("--from", given.from, default.map(|d| d.0))?, need("--to", given.to, default.map(|d| d.1))?);
    if from.is_finite() && to > from && to.is_finite() {
        Ok((from, to))
    } else {
        Err(format!("--from {from} --to {to}: write a range with the smaller value as --from"))
    }
}

fn known_point(machine: &Machine, name: &str) -> Result<usize, String> {
    machine.point(name).filter(|p| !machine.points[*p].fixed).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        format!("--at {name}: no such point moves; the machine has {}", known.join(", "))
    })
}

/// Computes the static stiffness at a point.
pub(super) fn static_stiffness(machine: &Machine, operating: &Operating, point: &str) -> Result<f64, String> {
    let found: Matrices = dynamics::model::matrices(machine, &machine.start(), operating, 1).map_err(to_message)?;
    found.static_stiffness(point).map_err(to_message)
}

/// Computes contacts, joints and natural frequencies at one operating condition.
fn sweep_row(machine: &Machine, operating: &Operating, at: f64, orders: usize) -> Result<SweepRow, String> {
    let start = machine.start();
    let mut contacts = BTreeMap::new();
    for contact in &machine.contacts {
        let state = contact.at(operating).map_err(to_message)?;
        contacts.insert(
            contact.name.clone(),
            ContactRow {
                force_n: state.force_n,
                load_a_n: state.share.load_a_n,
                load_b_n: state.share.load_b_n,
                stiffness_n_per_m: state.stiffness_n_per_m,
            },
        );
    }
    let mut joints = BTreeMap::new();
    for joint in &machine.joints {
        let k = joint.stiffness.at(&start, operating);
        for (spring, share) in joint.stiffness.compliance_shares(&start, operating) {
            joints.insert(format!("{}/{spring}", joint.name), k / share);
        }
        joints.insert(joint.name.clone(), k);
    }
    let frequencies_hz = if orders == 0 { Vec::new() } else { elastic_frequencies_hz(machine, orders, &start, operating) };
    Ok(SweepRow { at, contacts, joints, static_stiffness: None, frequencies_hz })
}

/// Finds where the force on a contact passes a load at which one of its sides unloads.
pub(super) fn separations(contact: &LoadedPair, (from, to): (f64, f64), at: impl Fn(f64) -> Operating) -> Vec<Separation> {
    // Number of intervals in which a crossing is sought.
    const CUTS: usize = 512;
    let (unloads_a_n, unloads_b_n) = contact.pair.unloading_forces_n(contact.rule);
    let place = |cut: usize| from + (to - from) * cut as f64 / CUTS as f64;
    let mut found = Vec::new();
    for (side, force_n) in [("A", unloads_a_n), ("B", unloads_b_n)] {
        let excess = |x: f64| contact.force_n(&at(x)) - force_n;
        for cut in 0..CUTS {
            let (low, high) = (place(cut), place(cut + 1));
            let (below, above) = (excess(low), excess(high));
            if (below < 0.0) != (above < 0.0) {
                let here = refine(Bracket { lower: (low, below), upper: (high, above) }, 1e-14, excess);
                found.push(Separation { contact: contact.name.clone(), side: side.into(), force_n, at: here });
            }
        }
    }
    found
}

fn sweep_text(machine: &Machine, along: SweepVariable, point: Option<&str>, rows: &[SweepRow], separations: &[Separation]) -> String {
    let contacts: Vec<&String> = rows.first().map(|row| row.contacts.keys().collect()).unwrap_or_default();
    let orders = rows.iter().map(|row| row.frequencies_hz.len()).max().unwrap_or(0);
    let key = along.key();
    let units = [("_m_s2", " m/s²"), ("_m_s", " m/s"), ("_m", " m"), ("_n", " N")];
    let unit = units.into_iter().find_map(|(tail, unit)| Some(format!("{}{unit}", key.strip_suffix(tail)?)));
    let mut header = vec![unit.unwrap_or_else(|| key.into())];
    header.extend(contacts.iter().map(|name| format!("{name} N/m")));
    header.extend(point.map(|point| format!("{point} N/m")));
    header.extend((1..=orders).map(|order| format!("f{order} Hz")));
    let cells = rows.iter().map(|row| {
        let mut cells = vec![format!("{:.5}", row.at)];
        cells.extend(contacts.iter().map(|name| format!("{:.3e}", row.contacts[*name].stiffness_n_per_m)));
        cells.extend(row.static_stiffness.map(|k| format!("{k:.3e}")));
        cells.extend(row.frequencies_hz.iter().map(|f| format!("{f:.2}")));
        cells.resize(header.len(), "–".into());
        cells
    });
    let mut text = format!("{}\n\n{}", machine.title, columns(&header, cells));
    for s in separations {
        let _ = writeln!(text, "{}: side {} unloads at {} = {:.5} ({:.1} N)", s.contact, s.side, along.key(), s.at, s.force_n);
    }
    text
}
