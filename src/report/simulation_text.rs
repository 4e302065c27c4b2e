//! Results of simulations of the structure as text: modes, FRFs and sweeps.

use std::fmt::Write;

use super::csv_cell::csv_cell;
use super::document::FrfsDocument;
use super::simulation::{ModesDocument, SweepDocument};
use super::terminal::columns;

/// Returns modes as a table, under the title of the machine.
pub fn modes_text(document: &ModesDocument, title: &str) -> String {
    let mut text = format!("{title}\n");
    if let Some(nut_m) = document.nut_m {
        let _ = writeln!(text, "nut at {nut_m} m");
    }
    let _ = writeln!(text, "\n order  frequency Hz   damping %   largest at     most strain energy in");
    for mode in &document.modes {
        let damping = mode.damping_ratio.map_or_else(|| "–".into(), |z| format!("{:.2}", 100.0 * z));
        let largest =
            mode.shape.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map_or("–", |(name, _)| name);
        let joints = mode.strain_energy_share.iter().filter(|(name, _)| !name.contains('/'));
        let strained = joints
            .max_by(|a, b| a.1.total_cmp(b.1))
            .map_or_else(String::new, |(name, x)| format!("{name} ({:.0} %)", 100.0 * x));
        let line = format!(
            "{:>6}  {:>12.4}  {:>10}   {largest:<14} {strained}",
            mode.order, mode.frequency_hz, damping
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// Returns FRFs as a CSV table: the positions named first in the given order, then the others.
pub fn frfs_csv(document: &FrfsDocument, first: &[String]) -> String {
    let mut text = String::from("position,frequency_hz,real,imag\n");
    let others = document.positions.keys().filter(|name| !first.contains(name));
    for name in first.iter().chain(others) {
        let (cell, lines) = (csv_cell(name), document.positions.get(name).into_iter().flatten());
        for (f, [re, im]) in document.frequency_hz.iter().zip(lines) {
            let _ = writeln!(text, "{cell},{f},{re:e},{im:e}");
        }
    }
    text
}

/// Returns a sweep as a table, under the title of the machine.
pub fn sweep_text(document: &SweepDocument, title: &str) -> String {
    let (rows, along) = (&document.rows, &document.along);
    let contacts: Vec<&String> = rows.first().map(|row| row.contacts.keys().collect()).unwrap_or_default();
    let orders = rows.iter().map(|row| row.frequencies_hz.len()).max().unwrap_or(0);
    let units = [("_m_s2", " m/s²"), ("_m_s", " m/s"), ("_m", " m"), ("_n", " N")];
    let unit =
        units.into_iter().find_map(|(tail, unit)| Some(format!("{}{unit}", along.strip_suffix(tail)?)));
    let mut header = vec![unit.unwrap_or_else(|| along.clone())];
    header.extend(contacts.iter().map(|name| format!("{name} N/m")));
    header.extend(document.point.as_ref().map(|point| format!("{point} N/m")));
    header.extend((1..=orders).map(|order| format!("f{order} Hz")));
    let cells = rows.iter().map(|row| {
        let mut cells = vec![format!("{:.5}", row.at)];
        cells.extend(contacts.iter().map(|name| format!("{:.3e}", row.contacts[*name].stiffness_n_per_m)));
        cells.extend(row.static_stiffness.map(|k| format!("{k:.3e}")));
        cells.extend(row.frequencies_hz.iter().map(|f| format!("{f:.2}")));
        cells.resize(header.len(), "–".into());
        cells
    });
    let mut text = format!("{title}\n\n{}", columns(&header, cells));
    for s in &document.separations {
        let _ = writeln!(
            text,
            "{}: side {} unloads at {along} = {:.5} ({:.1} N)",
            s.contact, s.side, s.at, s.force_n
        );
    }
    text
}
