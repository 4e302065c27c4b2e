//! The loops of a drive: frequency response, gains, circles, and a model with a network on its residual.

use serde_json::json;

use super::chart::{Chart, axis, bar_layout, colour, layout, line, log_axis, name_axis, scatter};
use super::text::{TextTable, cell, escape, paragraph, rounded};
use crate::hybrid::{HybridDocument, HybridRow};
use crate::loops::{BodeDocument, BodeRow, CirclesDocument, GainStudyDocument, GainStudyRow};

/// Formats the frequency response from command to position.
pub fn bode(of: &BodeDocument) -> String {
    let to = of.response.as_deref().unwrap_or("the reading of the position encoder");
    let chart = |id: &str,
                 label: &str,
                 title: &str,
                 log: bool,
                 pick: fn(&BodeRow) -> (Option<f64>, Option<f64>)| {
        let y = if log { log_axis(title) } else { axis(title) };
        let caption = format!("From the command to {}.", escape(to));
        let layout = layout(true, log_axis("frequency (Hz)"), y);
        let mut chart = Chart::new(id, label, &caption, 300, layout);
        let both = [
            ("linearised", of.rows.iter().map(|r| (r.frequency_hz, pick(r).0)).collect::<Vec<_>>()),
            ("simulated", of.rows.iter().map(|r| (r.frequency_hz, pick(r).1)).collect::<Vec<_>>()),
        ];
        for (n, (name, points)) in both.into_iter().enumerate() {
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().filter_map(|(x, y)| Some((x, y?))).unzip();
            if !x.is_empty() {
                let mode = if n == 0 { "lines" } else { "markers" };
                let look = json!({
                    "name": name, "line": line(colour(n), 1.5), "marker": { "color": colour(n), "size": 5 },
                    "hovertemplate": "%{x:.4~g} Hz: %{y:.4~g}",
                });
                chart.trace(scatter(x, y, mode, look));
            }
        }
        chart.html()
    };
    let magnitude = chart("bode-magnitude", "Magnitude", "magnitude", true, |r| {
        (Some(r.magnitude), r.simulated_magnitude)
    });
    let phase =
        chart("bode-phase", "Phase", "phase (°)", false, |r| (Some(r.phase_deg), r.simulated_phase_deg));
    let mut poles = TextTable::new(
        "Poles of the closed loops, the least damped first",
        1,
        ["Frequency (Hz)", "Damping (%)", "Largest at"],
    );
    of.poles.iter().take(8).for_each(|p| {
        poles.row([
            format!("{:.1}", p.frequency_hz),
            format!("{:.1}", 100.0 * p.damping_ratio),
            p.point.clone(),
        ])
    });
    let summary = of
        .bandwidth_hz
        .map(|hz| paragraph(&format!("The bandwidth (−3 dB) is {hz:.1} Hz.")))
        .unwrap_or_default();
    format!("{summary}{magnitude}{phase}{}", poles.html())
}

/// Formats the gains of the position loop.
pub fn gain(of: &GainStudyDocument) -> String {
    let mut table = TextTable::new(
        "Gains of the position loop",
        1,
        ["1/min", "Time (s)", "Static error (µm)", "Energy (J)", "Cost"],
    );
    for r in &of.rows {
        let um = r.static_error.map(|e| 1e6 * e);
        table.row([
            format!("{:.0}", r.gain_per_min),
            cell(r.time_s, |x| format!("{x:.4}")),
            cell(um, |x| rounded(x, 4).to_string()),
            cell(r.energy_j, |x| rounded(x, 5).to_string()),
            cell(r.cost, |x| format!("{x:.4}")),
        ]);
    }
    let caption = "Time, static error and energy are relative to their largest values. Cost: error less the savings of energy and time.";
    let axes = layout(true, axis("gain of the position loop (1/min)"), axis("relative value, cost"));
    let mut chart = Chart::new("gain", "Cost over the gain of the position loop", caption, 320, axes);
    type Pick = fn(&GainStudyRow) -> Option<f64>;
    let picks: [(&str, Pick); 4] = [
        ("time", |r| r.time_s),
        ("static error", |r| r.static_error),
        ("energy", |r| r.energy_j),
        ("cost", |r| r.cost),
    ];
    for (n, (name, pick)) in picks.into_iter().enumerate() {
        let largest =
            if name == "cost" { Some(1.0) } else { of.rows.iter().filter_map(pick).reduce(f64::max) };
        let points = of.rows.iter().filter_map(|r| Some((r.gain_per_min, pick(r)? / largest?)));
        let (x, y): (Vec<f64>, Vec<f64>) = points.unzip();
        let hover = "%{x:.0f} 1/min: %{y:.4~g}";
        let look = json!({ "name": name, "line": line(colour(n), 1.5), "hovertemplate": hover });
        chart.trace(scatter(x, y, "lines+markers", look));
    }
    let summary = of
        .optimum_per_s
        .map(|k| paragraph(&format!("The minimum cost is at {:.0} 1/min.", 60.0 * k)))
        .unwrap_or_default();
    format!("{summary}{}{}", chart.html(), table.html())
}

/// Formats the errors of a model, of the network on its residual, and of the diagnosed effects.
pub fn hybrid(of: &HybridDocument) -> String {
    let um = |x: f64| format!("{:.2}", 1e6 * x);
    let physics = of.records.values().any(|r| r.physics.is_some());
    let mut table = TextTable::new(
        "Prediction error of the travel: root mean square (µm)",
        2,
        ["Record", "Role", "Model", "With network", "With diagnosed effects"],
    );
    for (name, r) in &of.records {
        table.row([
            name.clone(),
            r.role.replace('_', " "),
            um(r.analytical.rmse_m),
            um(r.hybrid.rmse_m),
            cell(r.physics.map(|p| p.rmse_m), um),
        ]);
    }
    let axes = bar_layout(name_axis("record"), axis("RMSE (µm)"));
    let mut chart = Chart::new(
        "hybrid",
        "Prediction errors of model, neural network and diagnosed effects",
        "",
        300,
        axes,
    );
    let mut bars = |name: &str, n: usize, pick: &dyn Fn(&HybridRow) -> Option<f64>| {
        let (x, y): (Vec<String>, Vec<f64>) =
            of.records.iter().filter_map(|(name, r)| Some((escape(name), 1e6 * pick(r)?))).unzip();
        let marker = json!({ "color": colour(n) });
        chart.trace(json!({ "type": "bar", "x": x, "y": y, "name": name, "marker": marker }));
    };
    bars("model", 4, &|r| Some(r.analytical.rmse_m));
    bars("with network", 1, &|r| Some(r.hybrid.rmse_m));
    if physics {
        bars("with diagnosed effects", 0, &|r| r.physics.map(|p| p.rmse_m));
    }
    let mut summary = of
        .median_ratio
        .map(|r| {
            format!("Held out, median: with the network the error is {:.0} % of the model's.", 100.0 * r)
        })
        .unwrap_or_default();
    if let Some(r) = of.median_physics_to_hybrid {
        summary += &format!(" With the diagnosed effects it is {:.0} % of that with the network.", 100.0 * r);
    }
    let mut contours = TextTable::new(
        "Largest contour errors (µm)",
        2,
        ["Circle", "Role", "Measured", "Model error", "With network", "With diagnosed effects"],
    );
    for (name, c) in &of.contours {
        let physics = cell(c.physics_off_m, um);
        contours.row([
            name.clone(),
            c.role.replace('_', " "),
            um(c.measured_m),
            um(c.analytical_off_m),
            um(c.hybrid_off_m),
            physics,
        ]);
    }
    let contours = if of.contours.is_empty() { String::new() } else { contours.html() };
    format!("{}{}{}{contours}", paragraph(&summary), chart.html(), table.html())
}

/// Formats the contour errors of two axes on circles.
pub fn circle(of: &CirclesDocument) -> String {
    let mut table =
        TextTable::new("Contour error (µm)", 1, ["Speed (rad/min)", "Largest", "Mean", "At quadrants"]);
    let um = |x: f64| format!("{:.3}", 1e6 * x);
    of.rows.iter().for_each(|r| {
        table.row([
            rounded(r.speed_rad_min, 4).to_string(),
            um(r.largest_m),
            um(r.mean_m),
            cell(r.largest_at_quadrants_m, um),
        ])
    });
    table.html()
}
