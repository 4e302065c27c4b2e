//! Gains of the position loop and circles of two axes as text.

use report::columns;
use report::loops::{CircleRow, CirclesDocument, GainStudyDocument, GainStudyRow};

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

/// Returns contour errors of circles as a table.
pub fn circles_text(document: &CirclesDocument) -> String {
    let heads = ["rad/min", "largest contour error µm", "mean µm", "at quadrants µm"].map(String::from);
    let um = |x: f64| format!("{:.3}", 1e6 * x);
    let cells = |r: &CircleRow| {
        vec![
            format!("{}", r.speed_rad_min),
            um(r.largest_m),
            um(r.mean_m),
            r.largest_at_quadrants_m.map_or_else(|| "–".into(), um),
        ]
    };
    columns(&heads, document.rows.iter().map(cells))
}
