//! Results of simulations of the control loops as text: frequency response, gains, servo impedance, circles.

use std::fmt::Write;

use super::loops::{BodeDocument, CircleRow, CirclesDocument, GainStudyDocument, GainStudyRow, HoldDocument, HoldGains, HoldRow};
use super::terminal::columns;

/// Returns a frequency response as a CSV table, with bandwidth, poles and differences below.
pub fn bode_text(bode: &BodeDocument) -> String {
    let mut text = String::from("frequency_hz,magnitude,phase_deg,simulated_magnitude,simulated_phase_deg,stuck_share\n");
    for r in &bode.rows {
        let cell = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:.6}"));
        let _ = writeln!(
            text,
            "{:.4},{:.6e},{:.4},{},{},{}",
            r.frequency_hz,
            r.magnitude,
            r.phase_deg,
            r.simulated_magnitude.map_or_else(String::new, |x| format!("{x:.6e}")),
            cell(r.simulated_phase_deg),
            r.stuck_share.map_or_else(String::new, |x| format!("{x:.3}"))
        );
    }
    let _ = writeln!(text);
    if let Some(amplitude) = bode.amplitude {
        let _ = writeln!(text, "simulated with a command of amplitude {amplitude:e} m (rad on an axis that turns)");
    }
    if let Some(hz) = bode.bandwidth_hz {
        let _ = writeln!(text, "bandwidth (−3 dB): {hz:.1} Hz");
    }
    for p in bode.poles.iter().take(6) {
        let _ = writeln!(text, "pole at {:.1} Hz, damping {:.1} %, largest at {}", p.frequency_hz, 100.0 * p.damping_ratio, p.point);
    }
    if let (Some(size), Some(phase)) = (bode.largest_difference, bode.largest_phase_difference_deg) {
        let _ = writeln!(text, "simulation and linearisation differ by at most {:.2e} of the magnitude and {phase:.2e}°", size);
    }
    text
}

/// Returns a study of the position loop's gain as a table.
pub fn gain_text(document: &GainStudyDocument) -> String {
    let heads = ["k_v 1/min", "time s", "static error µm", "energy J", "cost", ""].map(String::from);
    let cell = |x: Option<f64>, digits: usize| x.map_or_else(|| "–".into(), |x| format!("{x:.digits$}"));
    let row = |r: &GainStudyRow| {
        vec![
            format!("{:.0}", r.gain_per_min),
            cell(r.time_s, 4),
            cell(r.static_error.map(|x| 1e6 * x), 3),
            cell(r.energy_j, 3),
            cell(r.cost, 4),
            match r {
                _ if Some(r.gain_per_s) == document.optimum_per_s => "minimum".into(),
                r if r.energy_j.is_some() && !r.settled => "not settled".into(),
                _ => String::new(),
            },
        ]
    };
    columns(&heads, document.rows.iter().map(row))
}

/// Returns a servo impedance as a table, with the units of stiffness and damping.
pub fn hold_text(document: &HoldDocument, [k, c]: [&str; 2]) -> String {
    let heads = ["frequency Hz".into(), format!("k_s {k}"), format!("c_s {c}"), "phase °".into()];
    let cells = |r: &HoldRow| {
        vec![format!("{}", r.frequency_hz), format!("{:.4e}", r.stiffness), format!("{:.4e}", r.damping), format!("{:.2}", r.phase_deg)]
    };
    let point = document.point.as_deref().unwrap_or_default();
    let mut text =
        format!("impedance of the drive at «{point}» as spring and damper\n{}", columns(&heads, document.rows.iter().map(cells)));
    if document.rows.iter().any(|r| r.damping < 0.0) {
        text += "where c_s is below 0, delay or integral action makes the loops supply energy: they do not damp there\n";
    }
    text
}

/// Returns the gains that correspond to an identified spring and damper, whose parameter ids are given.
pub fn hold_gains_text(gains: &HoldGains, ids: &[String]) -> String {
    let HoldGains { stiffness, damping, position_gain_per_s, velocity_gain } = gains;
    let id = |at: usize| ids.get(at).map_or("", String::as_str);
    format!(
        "{} {stiffness:.4e} N·m/rad and {} {damping:.4e} N·m·s/rad correspond to the gains\n\
         position loop {position_gain_per_s:.4} 1/s ({:.1} 1/min)\nvelocity loop {velocity_gain:.4} per m/s\n",
        id(0),
        id(1),
        60.0 * position_gain_per_s
    )
}

/// Returns contour errors of circles as a table.
pub fn circles_text(document: &CirclesDocument) -> String {
    let heads = ["rad/min", "largest contour error µm", "mean µm", "at quadrants µm"].map(String::from);
    let um = |x: f64| format!("{:.3}", 1e6 * x);
    let cells = |r: &CircleRow| {
        vec![format!("{}", r.speed_rad_min), um(r.largest_m), um(r.mean_m), r.largest_at_quadrants_m.map_or_else(|| "–".into(), um)]
    };
    columns(&heads, document.rows.iter().map(cells))
}
