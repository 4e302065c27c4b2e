//! `jointid simulate`.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write;
use std::sync::Arc;

use num_complex::Complex64;

use super::arguments::Sources;
use super::arguments::{FrfArguments, LoadArguments, ModesArguments, SimulateArguments, Simulation};
use super::common::{CommandResult, Loaded, Outcome, deliver, load, load_machine, prepare, read_document, rods, stamp, told, warn};
use super::import::quantity;
use super::validate::{check_identification, identified_values};
use super::{bode, circle, gain, hold, motion, published, servo_machine, sweep};
use dynamics::model::{Rods, Structure, undamped_modes};
use dynamics::motion::{Hold, LinearLoops, MotionError, Settings};
use machine::{Chain, Machine, Operating};
use numeric::unit::omega_rad_s;
use report::document::{Frfs, Identification, Input};
use report::simulation::{ModeRow, Modes};

/// Runs the command.
pub fn run(given: &SimulateArguments) -> CommandResult {
    match &given.what {
        Simulation::Modes(given) => modes(given),
        Simulation::Frf(given) => frf(given),
        Simulation::Matrices(given) => sweep::matrices(given),
        Simulation::Stiffness(given) => sweep::stiffness(given),
        Simulation::Sensitivity(given) => sweep::sensitivity(given),
        Simulation::Motion(given) => motion::run(given),
        Simulation::Bode(given) => bode::run(given),
        Simulation::Gain(given) => gain::run(given),
        Simulation::Hold(given) => hold::run(given),
        Simulation::Circle(given) => circle::run(given),
        Simulation::Machine(given) => servo_machine::run(given),
        Simulation::Published(given) => published::run(given),
    }
}

/// The operating condition asked for: a nut position, a named position, or mid-stroke.
pub(super) fn operating(loaded: &Loaded, nut_m: Option<f64>, position: Option<&str>, load: &LoadArguments) -> Result<Operating, String> {
    let machine = &loaded.config.machine;
    let (place, at_rest) = match (nut_m, position) {
        (Some(nut_m), _) => ("--nut-m".to_string(), Operating::at_nut(nut_m)),
        (None, Some(name)) => {
            let index = loaded.set.positions_named(&[name.to_string()]).map_err(told)?[0];
            (format!("position {name}"), Operating::at(loaded.set.positions[index].nut_m))
        }
        (None, None) => ("mid-stroke".into(), Operating::at(machine.stroke_m().map(|s| 0.5 * s))),
    };
    let operating = loaded_by(at_rest, load);
    machine.check_operating(&place, &operating).map_err(told)?;
    Ok(operating)
}

/// The operating condition with velocity, acceleration and force as asked for.
fn loaded_by(at_rest: Operating, load: &LoadArguments) -> Operating {
    let LoadArguments { velocity_m_s, acceleration_m_s2, force_n } = *load;
    Operating { velocity_m_s, acceleration_m_s2, force_n, ..at_rest }
}

/// Says where a load was given that nothing depends on, and what of the machine only motion shows.
pub(super) fn load_warnings(machine: &Machine, load: &LoadArguments) -> Vec<String> {
    let given = load.velocity_m_s.is_some() || load.acceleration_m_s2.is_some() || load.force_n.is_some();
    let none = given && machine.contacts.is_empty();
    let unmoved = none.then(|| "velocity, acceleration and force change nothing: no joint of this machine is a [contact.…]".to_string());
    let left_out = machine.left_out_of_frequency_responses().join(", ");
    let left_out = (!left_out.is_empty()).then(|| {
        format!("friction, play and lead error of {left_out} are left out here, which motion alone shows; damping of a joint is its viscous friction")
    });
    unmoved.into_iter().chain(left_out).collect()
}

fn positive(key: &str, x: f64) -> Result<f64, String> {
    if x > 0.0 && x.is_finite() { Ok(x) } else { Err(format!("{key} {x}: write a number above 0")) }
}

fn modes(given: &ModesArguments) -> CommandResult {
    let max_hz = positive("--max-hz", given.max_hz)?;
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let operating = operating(&loaded, given.nut_m, given.position.as_deref(), &given.load)?;
    let folder = prepare(&given.output)?;
    let first = machine.points.iter().position(|p| !p.fixed).ok_or("the machine has no point that moves")?;
    let structure = Arc::new(Structure::new(machine, first, first, rods(given.model, given.lumps)).map_err(told)?);
    let mut network = structure.network();
    network.update(machine, &machine.start(), &operating);
    let modes: Vec<ModeRow> = undamped_modes(&network, max_hz, &mut structure.workspace())
        .into_iter()
        .enumerate()
        .map(|(at, mode)| {
            let omega = omega_rad_s(mode.frequency_hz);
            // A rigid body strains nothing.
            let energy = match mode.frequency_hz > 0.0 {
                true => network.strain_energy(machine, &machine.start(), &operating, omega, &mode.shape),
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
    let document = Modes {
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
    deliver(&given.output, folder.as_ref(), "modes.json", &document, &text)?;
    Ok(Outcome::Done)
}

/// Deflection of every point of the machine.
fn shape(machine: &Machine, structure: &Structure, deflection: &[f64]) -> BTreeMap<String, f64> {
    if deflection.is_empty() {
        return BTreeMap::new();
    }
    let of = |point: usize| structure.coordinate_of(point).map_or(0.0, |c| deflection[c]);
    machine.points.iter().enumerate().map(|(i, p)| (p.name.clone(), of(i))).collect()
}

fn frf(given: &FrfArguments) -> CommandResult {
    let step = positive("--step-hz", given.step_hz)?;
    let from = positive("--from-hz", given.from_hz)?;
    if !(given.to_hz >= from && given.to_hz.is_finite()) {
        return Err(format!("--to-hz {}: write a frequency from {from} Hz", given.to_hz));
    }
    let steps = ((given.to_hz - from) / step + 1e-9).floor();
    if !(steps < 1e6) {
        return Err(format!("--step-hz {step}: that makes {steps:e} lines, more than a million; choose a wider step"));
    }
    let lines = steps as usize + 1;
    // A result carries the machine it is for.
    let (identified, input): (Option<Identification>, Option<Input>) = given.result.as_deref().map(read_document).transpose()?.unzip();
    let loaded = match &identified {
        None => load_machine(&given.sources)?,
        Some(identified) => load(&Sources {
            config: identified.settings.config.clone(),
            measurements: given.sources.measurements.clone(),
            set: identified.stamp.overrides.iter().chain(&given.sources.set).cloned().collect(),
            without: identified.stamp.without.iter().chain(&given.sources.without).cloned().collect(),
        })?,
    };
    let machine = &loaded.config.machine;
    let point = |own: &Option<String>, set: &Option<String>, key: &str| {
        let name = own.as_ref().or(set.as_ref()).ok_or_else(|| format!("{key}: name a point of the machine"))?;
        machine.point(name).ok_or_else(|| {
            let known: Vec<&str> = machine.points.iter().map(|p| p.name.as_str()).collect();
            format!("{key} {name}: no such point; the machine has {}", known.join(", "))
        })
    };
    let response = point(&given.response, &loaded.set.response, "--response")?;
    let excitation = point(&given.excitation, &loaded.set.excitation, "--excitation")?;
    let mut places = Vec::new();
    match (&given.position, given.nut_m) {
        (None, Some(nut_m)) => places.push((format!("{nut_m}"), operating(&loaded, Some(nut_m), None, &given.load)?)),
        (names, _) => {
            // A machine without a nut is the same at every position.
            let positions = loaded.set.positions.iter().filter(|_| machine.stroke_m().is_some());
            let all: Vec<String> = positions.map(|p| p.name.clone()).collect();
            for name in names.as_ref().unwrap_or(&all) {
                places.push((name.clone(), operating(&loaded, None, Some(name), &given.load)?));
            }
            if places.is_empty() {
                let place = if machine.stroke_m().is_some() { "mid-stroke" } else { "machine" };
                places.push((place.into(), operating(&loaded, None, None, &given.load)?));
            }
        }
    }
    let mut values = machine.start();
    let mut representation = Rods::Exact;
    if let (Some(path), Some(identified)) = (&given.result, &identified) {
        check_identification(path, identified)?;
        representation = identified.settings.lumps.map_or(Rods::Exact, Rods::Lumped);
        values = identified_values(path, identified, &loaded.config)?;
    }
    let folder = prepare(&given.output)?;
    let quantity = quantity(given.quantity);
    let structure = Arc::new(Structure::new(machine, response, excitation, representation).map_err(told)?);
    let (mut network, mut work) = (structure.network(), structure.workspace());
    let frequency_hz: Vec<f64> = (0..lines).map(|i| from + step * i as f64).collect();
    let mut positions = BTreeMap::new();
    let mut text = String::from("position,frequency_hz,real,imag\n");
    for (name, operating) in places {
        network.update(machine, &values, &operating);
        let chain = machine.chain.at(&values, &operating);
        let mut row = Vec::with_capacity(lines);
        let omegas: Vec<f64> = frequency_hz.iter().copied().map(omega_rad_s).collect();
        let receptances = match given.closed_loop {
            false => network.sweep(&omegas, &mut work),
            true => closed(machine, &values, &operating, (response, excitation, representation), &omegas)?,
        };
        for ((&f, &omega), receptance) in frequency_hz.iter().zip(&omegas).zip(receptances) {
            let recorded = Chain::log_factor(chain, omega).exp();
            let h = receptance * quantity.from_receptance(omega) * recorded;
            let _ = writeln!(text, "{name},{f},{:e},{:e}", h.re, h.im);
            row.push([h.re, h.im]);
        }
        positions.insert(name, row);
    }
    let document = Frfs {
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
    deliver(&given.output, folder.as_ref(), "frf.json", &document, &text)?;
    Ok(Outcome::Done)
}

/// Receptances with the loops of the drive closed.
fn closed(
    machine: &Machine,
    values: &[f64],
    operating: &Operating,
    (response, excitation, rods): (usize, usize, Rods),
    omega_rad_s: &[f64],
) -> Result<Vec<Complex64>, String> {
    let fault = |e: MotionError| format!("--closed-loop: {e}");
    let hold = Hold::new(machine, values, operating).map_err(fault)?;
    let settings = Settings { operating: *operating, ..Settings::default() };
    if let Some(pole) = LinearLoops::new(machine, values, &settings).map_err(fault)?.unstable() {
        return Err(format!("--closed-loop: the loops are unstable: {}", bode::said(&pole)));
    }
    let highest_hz = hold.highest_hz();
    if omega_rad_s.iter().any(|omega| *omega > numeric::unit::omega_rad_s(highest_hz)) {
        return Err(format!("--to-hz: closed loops are told up to {highest_hz} Hz, half the slowest sampling rate; write no more"));
    }
    let mut open = BTreeMap::new();
    let among: Vec<usize> = hold.points().into_iter().chain([response]).collect();
    for &at in &among {
        for force in [hold.on, excitation] {
            if let Entry::Vacant(place) = open.entry((at, force)) {
                let structure = Arc::new(Structure::new(machine, at, force, rods).map_err(told)?);
                let mut network = structure.network();
                network.update(machine, values, operating);
                place.insert(network.sweep(omega_rad_s, &mut structure.workspace()));
            }
        }
    }
    let at = |(line, omega): (usize, &f64)| hold.close(*omega, response, excitation, |point, force| open[&(point, force)][line]);
    Ok(omega_rad_s.iter().enumerate().map(at).collect())
}
