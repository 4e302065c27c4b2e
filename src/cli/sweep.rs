//! `jointid simulate matrices`, `stiffness` and `sensitivity`.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use super::arguments::{Along, MatricesArguments, SensitivityArguments, StiffnessArguments};
use super::common::{CommandResult, Loaded, Outcome, deliver, load_machine, prepare, stamp, told, warn};
use super::simulate::{load_warnings, operating};
use dynamics::model::{Matrices, Rods, Structure, elastic_frequencies_hz, undamped_modes};
use machine::{FitRule, Law, LoadedPair, Machine, Operating, Parameter, Scale};
use numeric::root::{Bracket, refine};
use numeric::unit::omega_rad_s;
use report::columns;
use report::simulation::{ContactRow, MatricesDocument, SensitivityDocument, SensitivityRow, Separation, Sweep, SweepRow};

/// Most columns of a matrix that fit a terminal.
const WIDEST: usize = 6;

/// `simulate matrices`.
pub fn matrices(given: &MatricesArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let operating = operating(&loaded, given.nut_m, None, &given.load)?;
    let folder = prepare(&given.output)?;
    let mut found = dynamics::model::matrices(machine, &machine.start(), &operating, usize::from(given.lumps)).map_err(told)?;
    if given.condense {
        found = found.condensed().map_err(told)?;
    }
    let rows = |m: &nalgebra::DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>();
    let warnings = load_warnings(machine, &given.load);
    warn(&given.output, &warnings);
    let mut text = format!("{}\ncoordinates: {}\n", machine.title, found.names.join(", "));
    for (name, matrix) in [("M", &found.mass), ("C", &found.damping), ("K", &found.stiffness)] {
        let _ = writeln!(text, "\n{name}");
        if matrix.ncols() > WIDEST {
            let _ = writeln!(text, "{} × {}, too wide for a terminal: --json has it", matrix.nrows(), matrix.ncols());
            continue;
        }
        for row in matrix.row_iter() {
            let cells: Vec<String> = row.iter().map(|x| if *x == 0.0 { format!("{:>11}", "0") } else { format!("{x:>11.3e}") }).collect();
            let _ = writeln!(text, "{}", cells.join(" "));
        }
    }
    let document = MatricesDocument {
        stamp: stamp("matrices", 0, true, &loaded, warnings),
        coordinates: found.names.clone(),
        mass: rows(&found.mass),
        damping: rows(&found.damping),
        stiffness: rows(&found.stiffness),
    };
    deliver(&given.output, folder.as_ref(), "matrices.json", &document, &text)?;
    Ok(Outcome::Done)
}

impl Along {
    fn key(self) -> &'static str {
        match self {
            Along::Position => "nut_m",
            Along::Velocity => "velocity_m_s",
            Along::Acceleration => "acceleration_m_s2",
            Along::Force => "force_n",
        }
    }

    /// The operating condition at one value of what is swept.
    fn at(self, base: &Operating, x: f64) -> Operating {
        let mut operating = *base;
        *match self {
            Along::Position => &mut operating.nut_m,
            Along::Velocity => &mut operating.velocity_m_s,
            Along::Acceleration => &mut operating.acceleration_m_s2,
            Along::Force => &mut operating.force_n,
        } = Some(x);
        operating
    }
}

/// `simulate stiffness`.
pub fn stiffness(given: &StiffnessArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let along = given.along;
    let base = operating(&loaded, given.nut_m, None, &given.load)?;
    let (from, to) = range(given, machine)?;
    let folder = prepare(&given.output)?;
    if let Some(point) = &given.at {
        known_point(machine, point)?;
    }
    let mut warnings = load_warnings(machine, &given.load);
    if along != Along::Position && machine.contacts.is_empty() {
        warnings.push(format!("nothing of this machine depends on {}: none of its joints is a [contact.…]", along.key()));
    }
    warn(&given.output, &warnings);
    let steps = given.steps as usize;
    let mut rows = Vec::with_capacity(steps);
    for step in 0..steps {
        let x = from + (to - from) * step as f64 / (steps - 1) as f64;
        let here = along.at(&base, x);
        let place = format!("{} = {x}", along.key());
        machine.check_operating(&place, &here).map_err(told)?;
        let mut row = sweep_row(machine, &here, x, usize::from(given.orders))?;
        if let Some(point) = &given.at {
            let mut k = static_stiffness(machine, &here, point)?;
            if let Some(second_m) = given.in_series_with_nut_m {
                let second = Operating { nut_m: Some(second_m), ..here };
                machine.check_operating("--in-series-with-nut-m", &second).map_err(told)?;
                k = 1.0 / (1.0 / k + 1.0 / static_stiffness(machine, &second, point)?);
            }
            row.static_stiffness = Some(k);
        }
        rows.push(row);
    }
    let separations: Vec<Separation> =
        machine.contacts.iter().flat_map(|contact| separations(contact, (from, to), |x| along.at(&base, x))).collect();
    let text = sweep_text(machine, along, given.at.as_deref(), &rows, &separations);
    let document = Sweep {
        stamp: stamp("stiffness", 0, true, &loaded, warnings),
        along: along.key().into(),
        point: given.at.clone(),
        in_series_with_nut_m: given.in_series_with_nut_m,
        separations,
        rows,
    };
    deliver(&given.output, folder.as_ref(), "stiffness.json", &document, &text)?;
    Ok(Outcome::Done)
}

/// The range that was asked for.
fn range(given: &StiffnessArguments, machine: &Machine) -> Result<(f64, f64), String> {
    let default = match given.along {
        Along::Position => {
            let stroke_m = machine.stroke_m().ok_or("--along position: the machine has no nut; sweep something else")?;
            Some((0.02 * stroke_m, 0.98 * stroke_m))
        }
        _ => None,
    };
    let need = |key: &str, own: Option<f64>, default: Option<f64>| {
        own.or(default).ok_or_else(|| format!("{key}: write where the sweep along {} begins and ends", given.along.key()))
    };
    let (from, to) = (need("--from", given.from, default.map(|d| d.0))?, need("--to", given.to, default.map(|d| d.1))?);
    if from.is_finite() && to > from && to.is_finite() {
        Ok((from, to))
    } else {
        Err(format!("--from {from} --to {to}: write a range that rises"))
    }
}

fn known_point(machine: &Machine, name: &str) -> Result<usize, String> {
    machine.point(name).filter(|p| !machine.points[*p].fixed).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        format!("--at {name}: no such point moves; the machine has {}", known.join(", "))
    })
}

/// Static stiffness at a point.
pub(super) fn static_stiffness(machine: &Machine, operating: &Operating, point: &str) -> Result<f64, String> {
    let found: Matrices = dynamics::model::matrices(machine, &machine.start(), operating, 1).map_err(told)?;
    found.static_stiffness(point).map_err(told)
}

/// Contacts, joints and frequencies at one operating condition.
fn sweep_row(machine: &Machine, operating: &Operating, at: f64, orders: usize) -> Result<SweepRow, String> {
    let start = machine.start();
    let mut contacts = BTreeMap::new();
    for contact in &machine.contacts {
        let state = contact.at(operating).map_err(told)?;
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

/// Where the force on a contact passes a load at which one of its sides unloads.
pub(super) fn separations(contact: &LoadedPair, (from, to): (f64, f64), at: impl Fn(f64) -> Operating) -> Vec<Separation> {
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

fn sweep_text(machine: &Machine, along: Along, point: Option<&str>, rows: &[SweepRow], separations: &[Separation]) -> String {
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

/// The machine with a factor on the stiffness of a joint, as a parameter appended to the others.
fn with_factor(machine: &Machine, joint: usize) -> Machine {
    let mut scaled = machine.clone();
    let index = scaled.parameters.len();
    scaled.parameters.push(Parameter {
        id: "factor".into(),
        unit: "1".into(),
        start: 1.0,
        lower: 0.0,
        upper: f64::INFINITY,
        scale: Scale::Linear,
        fit: FitRule::Never,
        sd: None,
        source: "sensitivity".into(),
    });
    scaled.joints[joint].stiffness.laws.push(Law::Times(index));
    scaled
}

/// `simulate sensitivity`.
pub fn sensitivity(given: &SensitivityArguments) -> CommandResult {
    if !(given.from > 0.0 && given.to > given.from && given.to.is_finite()) {
        return Err(format!("--from {} --to {}: write factors above 0 that rise", given.from, given.to));
    }
    let loaded: Loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let operating = operating(&loaded, given.nut_m, None, &given.load)?;
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
            frequencies_hz.push(frequency(&scaled, &values).ok_or("the frequency is lost at a factor; choose a narrower range")?);
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
    deliver(&given.output, folder.as_ref(), "sensitivity.json", &document, &text)?;
    Ok(Outcome::Done)
}

/// Joints asked for, or all that have a stiffness.
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
            return Err(format!("--joint {name}: it has no stiffness to be changed; name another"));
        }
        chosen.push(index);
    }
    Ok(chosen)
}

/// Deformation and share of the strain energy of each joint in the mode at a frequency.
pub(super) fn mode_energy(machine: &Machine, operating: &Operating, frequency_hz: f64) -> Result<BTreeMap<String, (f64, f64)>, String> {
    let moving = machine.points.iter().position(|p| !p.fixed).ok_or("the machine has no point that moves")?;
    let structure = Arc::new(Structure::new(machine, moving, moving, Rods::Exact).map_err(told)?);
    let mut network = structure.network();
    network.update(machine, &machine.start(), operating);
    let modes = undamped_modes(&network, frequency_hz * (1.0 + 1e-6), &mut structure.workspace());
    let mode = modes.last().ok_or("the mode is not found again")?;
    let rows = network.strain_energy(machine, &machine.start(), operating, omega_rad_s(mode.frequency_hz), &mode.shape);
    Ok(rows.into_iter().map(|row| (row.name, (row.deformation.unwrap_or(0.0), row.share))).collect())
}
