//! The Stribeck curve of friction measurements as text.

use std::fmt::Write;

use super::simulation::FrictionDocument;

/// Parameters of the curve, in the order of the text.
const PARAMETERS: [&str; 4] = ["coulomb_n", "static_n", "viscous_n_s_per_m", "stribeck_velocity_m_s"];

/// Formats the parameters of a Stribeck curve with their intervals.
pub fn friction_text(document: &FrictionDocument) -> String {
    let path = document.stamp.inputs.first().map_or("", |input| &input.path);
    let mut text = format!(
        "Stribeck curve of {path}, {} runs, {} noise\n\n",
        document.observations.len(),
        document.noise
    );
    for (name, e) in PARAMETERS.iter().filter_map(|name| Some((name, document.parameters.get(*name)?))) {
        let interval = e
            .interval95
            .map_or_else(|| "at a bound".into(), |[lower, upper]| format!("{lower:.6} … {upper:.6}"));
        let _ = writeln!(text, "{name:<22} {:>14.6} {:<6} {interval}", e.value, e.unit);
    }
    let (scatter, speed_m_s) = (document.residual_scatter, document.least_friction_speed_m_s);
    let least = match speed_m_s {
        0.0 => "friction rises with speed from rest".to_string(),
        _ if speed_m_s == document.highest_speed_m_s => {
            format!("friction falls with speed up to the highest one measured, {speed_m_s} m/s")
        }
        _ => format!("least friction at {speed_m_s:.6} m/s"),
    };
    let _ = writeln!(text, "\nresidual scatter {scatter:.4}, {least}");
    text
}
