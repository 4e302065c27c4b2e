//! Results of simulations of the control loops as text: frequency response, servo impedance, gains from a
//! spring and a damper.

use std::fmt::Write;

use super::loops::{BodeDocument, HoldDocument, HoldGains, HoldRow};
use super::terminal::columns;

/// Returns a frequency response as a CSV table, with bandwidth, poles and differences below.
pub fn bode_text(bode: &BodeDocument) -> String {
    let mut text = String::from(
        "frequency_hz,magnitude,phase_deg,simulated_magnitude,simulated_phase_deg,stuck_share\n",
    );
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
        let _ = writeln!(
            text,
            "simulated with a command of amplitude {amplitude:e} m (rad on an axis that turns)"
        );
    }
    if let Some(hz) = bode.bandwidth_hz {
        let _ = writeln!(text, "bandwidth (−3 dB): {hz:.1} Hz");
    }
    for p in bode.poles.iter().take(6) {
        let _ = writeln!(
            text,
            "pole at {:.1} Hz, damping {:.1} %, largest at {}",
            p.frequency_hz,
            100.0 * p.damping_ratio,
            p.point
        );
    }
    if let (Some(size), Some(phase)) = (bode.largest_difference, bode.largest_phase_difference_deg) {
        let _ = writeln!(
            text,
            "simulation and linearisation differ by at most {:.2e} of the magnitude and {phase:.2e}°",
            size
        );
    }
    text
}

/// Returns a servo impedance as a table, with the units of stiffness and damping.
pub fn hold_text(document: &HoldDocument, [k, c]: [&str; 2]) -> String {
    let heads = ["frequency Hz".into(), format!("k_s {k}"), format!("c_s {c}"), "phase °".into()];
    let cells = |r: &HoldRow| {
        vec![
            format!("{}", r.frequency_hz),
            format!("{:.4e}", r.stiffness),
            format!("{:.4e}", r.damping),
            format!("{:.2}", r.phase_deg),
        ]
    };
    let point = document.point.as_deref().unwrap_or_default();
    let mut text = format!(
        "impedance of the drive at «{point}» as spring and damper\n{}",
        columns(&heads, document.rows.iter().map(cells))
    );
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
