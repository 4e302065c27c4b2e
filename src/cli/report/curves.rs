//! Measured and predicted FRFs of an identification, for its page.

use std::sync::Arc;

use num_complex::Complex64;

use super::Ground;
use crate::machine::{Chain, Machine, Motion, Operating};
use crate::measurement::{Frf, Gain, MeasurementSet, Quantity};
use crate::model::{ModelError, Structure};
use crate::objective::operating;
use crate::report::page::{Curve, PeakMark};
use crate::unit::omega_rad_s;

/// Lines of a predicted FRF where none was measured.
const LINES: usize = 1500;

/// All FRFs of the set with their predictions; for a set of modes, predictions over the band of its modes.
pub(super) fn curves(ground: &Ground<'_>) -> Result<Vec<Curve>, String> {
    let set = &ground.loaded.set;
    if set.frfs.is_empty() { of_modes(ground) } else { set.frfs.iter().enumerate().map(|(at, frf)| of_frf(ground, at, frf)).collect() }
}

fn told(error: ModelError) -> String {
    error.to_string()
}

fn point(machine: &Machine, name: &str) -> Result<usize, String> {
    machine.point(name).ok_or_else(|| format!("the machine has no point «{name}»"))
}

/// The factor from prediction to what was recorded, as identified.
fn gain(ground: &Ground<'_>) -> f64 {
    match ground.loaded.set.gain {
        Gain::Known(gain) => gain,
        Gain::Unknown => ground.identified.parameters.get("gain").map_or(1.0, |g| g.value),
    }
}

/// Whether an FRF is held out.
fn held_out<'g>(ground: &'g Ground<'_>) -> Result<impl Fn(Option<usize>, Option<usize>) -> bool + 'g, String> {
    let settings = &ground.identified.settings;
    let (fit, _) = ground.loaded.set.split(settings.positions.as_deref(), &settings.hold_out).map_err(|e| e.to_string())?;
    Ok(move |frf: Option<usize>, position: Option<usize>| {
        frf.is_none_or(|f| !fit.frfs.contains(&f)) && position.is_none_or(|p| !fit.positions.contains(&p))
    })
}

/// Factor and name of the unit in which an FRF is read with ease: µm/N rather than m/N.
fn unit(machine: &Machine, (response, excitation): (usize, usize), quantity: Quantity, set: &MeasurementSet) -> (f64, String) {
    let (factor, length, angle) = match quantity {
        Quantity::Receptance => (1e6, "µm", "µrad"),
        Quantity::Mobility => (1e3, "mm/s", "mrad/s"),
        Quantity::Accelerance => (1.0, "m/s²", "rad/s²"),
    };
    let of = if machine.points[response].motion == Motion::Translation { length } else { angle };
    let per = if machine.points[excitation].motion == Motion::Translation { "N" } else { "N·m" };
    let times = if set.gain == Gain::Unknown { ", times the gain" } else { "" };
    (factor, format!("{}{times} ({of}/{per})", quantity.word()))
}

fn of_frf(ground: &Ground<'_>, at: usize, frf: &Frf) -> Result<Curve, String> {
    let (set, machine) = (&ground.loaded.set, &ground.loaded.config.machine);
    let (response, excitation) = (point(machine, &frf.response)?, point(machine, &frf.excitation)?);
    let operating = operating(set, frf);
    let (factor, unit) = unit(machine, (response, excitation), frf.quantity, set);
    let lines: Vec<f64> = frf.lines.iter().map(|l| l.frequency_hz).collect();
    let predicted = predicted(ground, (response, excitation), frf.quantity, &operating, &lines, factor)?;
    let channel = format!("{}/{}", frf.response, frf.excitation);
    let name = |p: usize| set.positions[p].name.clone();
    // A record stands for the position where there is none, and beside the channel where a position has several.
    let (position, channel) = match (frf.position, &frf.record) {
        (Some(p), Some(record)) => (name(p), format!("{channel} {record}")),
        (Some(p), None) => (name(p), channel),
        (None, Some(record)) => (record.clone(), channel),
        (None, None) => ("all".into(), channel),
    };
    let of_role = held_out(ground)?;
    Ok(Curve {
        position,
        channel,
        held_out: of_role(Some(at), None),
        unit,
        measured: frf.lines.iter().map(|l| (l.frequency_hz, l.value * factor)).collect(),
        predicted,
        peaks: Vec::new(),
    })
}

fn of_modes(ground: &Ground<'_>) -> Result<Vec<Curve>, String> {
    let (set, machine) = (&ground.loaded.set, &ground.loaded.config.machine);
    let (Some(modes), Some(response), Some(excitation)) = (&set.modes, &set.response, &set.excitation) else { return Ok(Vec::new()) };
    let channel = (point(machine, response)?, point(machine, excitation)?);
    let quantity = set.quantity.unwrap_or(Quantity::Receptance);
    let (factor, unit) = unit(machine, channel, quantity, set);
    let seen = modes.positions.iter().flatten().filter_map(|m| m.frequency_hz);
    let (low, high) = seen.fold((f64::INFINITY, 0.0_f64), |(a, b), f| (a.min(f), b.max(f)));
    let (from, to) = (0.4 * low, 1.4 * high);
    let of_role = held_out(ground)?;
    let mut curves = Vec::new();
    for (at, (position, observed)) in set.positions.iter().zip(&modes.positions).enumerate() {
        let mut lines: Vec<f64> = (0..LINES).map(|i| from * (to / from).powf(i as f64 / (LINES - 1) as f64)).collect();
        // A peak is narrower than the lines are apart: more of them around it.
        let orders = ground.identified.positions.get(&position.name).map(|p| p.orders.as_slice()).unwrap_or_default();
        for peak in orders.iter().filter_map(|o| o.predicted_hz) {
            lines.extend((-100..=100).map(|i| peak * (1.0 + 1e-6 * f64::from(i).powi(3) * 0.02)));
        }
        lines.retain(|f| *f > 0.0);
        lines.sort_by(f64::total_cmp);
        lines.dedup();
        curves.push(Curve {
            position: position.name.clone(),
            channel: format!("{response}/{excitation}"),
            held_out: of_role(None, Some(at)),
            unit: unit.clone(),
            measured: Vec::new(),
            predicted: predicted(ground, channel, quantity, &Operating::at(position.nut_m), &lines, factor)?,
            peaks: observed
                .iter()
                .filter_map(|m| {
                    Some(PeakMark { order: m.order, frequency_hz: m.frequency_hz?, amplitude: m.amplitude.map(|a| a * factor) })
                })
                .collect(),
        });
    }
    Ok(curves)
}

/// As the set would have recorded it, times a factor.
fn predicted(
    ground: &Ground<'_>,
    (response, excitation): (usize, usize),
    quantity: Quantity,
    operating: &Operating,
    lines: &[f64],
    factor: f64,
) -> Result<Vec<(f64, Complex64)>, String> {
    let machine = &ground.loaded.config.machine;
    let structure = Arc::new(Structure::new(machine, response, excitation, ground.rods).map_err(told)?);
    let (mut network, mut work) = (structure.network(), structure.workspace());
    network.update(machine, &ground.values, operating);
    let chain = machine.chain.at(&ground.values, operating);
    let scale = gain(ground) * factor;
    let at = |f: f64| {
        let omega = omega_rad_s(f);
        let recorded = Chain::log_factor(chain, omega).exp();
        network.receptance(omega, &mut work) * quantity.from_receptance(omega) * recorded * scale
    };
    Ok(lines.iter().copied().zip(lines.iter().copied().map(at)).filter(|(_, h)| h.is_finite()).collect())
}
