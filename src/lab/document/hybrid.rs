//! Errors of a model and a neural network as text, beside those of the published axis.

use report::columns;
use report::hybrid::{ContourRow, HybridDocument, HybridRow, PhysicsRow};

/// Errors of a predicted tracking error that the paper's Tab. 3 prints for one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrintedErrors {
    /// Largest absolute error, MAE (µm).
    pub largest_um: f64,
    /// Root mean square error, RMSE (µm).
    pub rmse_um: f64,
    /// Relative error, RE (%).
    pub relative_percent: f64,
}

const fn printed(largest_um: f64, rmse_um: f64, relative_percent: f64) -> PrintedErrors {
    PrintedErrors { largest_um, rmse_um, relative_percent }
}

/// Tab. 3 of «Hybrid Multi-Domain Analytical and Data-Driven Modeling» (2019): record, feed (mm/min), errors
/// of the analytical and of the hybrid model.
pub const PRINTED_SINES: [(&str, f64, PrintedErrors, PrintedErrors); 6] = [
    ("F1000", 1000.0, printed(7.99, 2.91, 4.2), printed(5.22, 1.87, 2.7)),
    ("F2000", 2000.0, printed(7.52, 2.83, 4.0), printed(5.16, 2.33, 2.0)),
    ("F3000", 3000.0, printed(7.70, 3.15, 1.4), printed(5.98, 1.72, 1.1)),
    ("F4000", 4000.0, printed(8.51, 3.84, 1.1), printed(5.27, 1.41, 0.7)),
    ("F5000", 5000.0, printed(10.2, 4.89, 1.1), printed(4.55, 1.64, 0.5)),
    ("F6000", 6000.0, printed(12.38, 6.21, 1.2), printed(6.79, 2.63, 0.6)),
];
/// Tab. 4 of the same paper: record, angular speed (rad/min), largest contour errors (µm) of the analytical
/// and of the hybrid model.
pub const PRINTED_CIRCLES: [(&str, f64, f64, f64); 4] = [
    ("circle-60", 60.0, 7.19, 6.57),
    ("circle-80", 80.0, 8.62, 5.34),
    ("circle-100", 100.0, 10.26, 4.10),
    ("circle-120", 120.0, 12.54, 6.95),
];

/// Formats the errors by record and by circle, beside those of the published axis.
pub fn hybrid_text(document: &HybridDocument) -> String {
    let um = |x: f64| format!("{:.2}", 1e6 * x);
    let physics = document.records.values().any(|r| r.physics.is_some());
    let sine = |name: &str| PRINTED_SINES.iter().find(|p| p.0 == name);
    let mut heads: Vec<String> =
        ["record", "role", "model RMSE µm", "with network"].map(String::from).to_vec();
    if physics {
        heads.push("with physics".into());
    }
    heads.push("paper".into());
    let cells = |(name, r): (&String, &HybridRow)| {
        let mut cells =
            vec![name.clone(), r.role.replace('_', " "), um(r.analytical.rmse_m), um(r.hybrid.rmse_m)];
        if physics {
            cells.push(r.physics.map_or_else(|| "–".into(), |p| um(p.rmse_m)));
        }
        cells.push(
            sine(name)
                .map_or_else(String::new, |(_, _, a, h)| format!("{:.2} / {:.2}", a.rmse_um, h.rmse_um)),
        );
        cells
    };
    let mut text = format!("travel of «{}», predicted from the command\n", document.point);
    if let Some(result) = &document.physics {
        text += &physics_text(result, "with physics");
    }
    if let Some(result) = &document.second_physics {
        text += &physics_text(result, "second axis with physics");
    }
    text += &columns(&heads, document.records.iter().map(cells));
    let heads: Vec<String> =
        ["record", "model MAE µm", "with network", "paper", "model RE %", "with network", "paper"]
            .map(String::from)
            .to_vec();
    let share = |x: f64| format!("{:.2}", 100.0 * x);
    let cells = |(name, r): (&String, &HybridRow)| {
        let pair = |of: fn(&PrintedErrors) -> f64, digits: usize| {
            sine(name)
                .map_or_else(String::new, |(_, _, a, h)| format!("{:.digits$} / {:.digits$}", of(a), of(h)))
        };
        vec![
            name.clone(),
            um(r.analytical.largest_m),
            um(r.hybrid.largest_m),
            pair(|p| p.largest_um, 2),
            share(r.analytical.relative),
            share(r.hybrid.relative),
            pair(|p| p.relative_percent, 1),
        ]
    };
    text += "\nlargest errors (MAE), and over the largest measured tracking error (RE)\n";
    text += &columns(&heads, document.records.iter().map(cells));
    if let Some(ratio) = document.median_ratio {
        text += &format!(
            "\nheld out, median: with the network the error is {:.0} % of the model's\n",
            100.0 * ratio
        );
    }
    if let Some(ratio) = document.median_physics_to_hybrid {
        text += &match ratio {
            r if r <= 1.2 => {
                format!(
                    "the error with physics is {:.0} % of that with the network: physics lacks nothing that the network learns\n",
                    100.0 * r
                )
            }
            r => format!(
                "the error with physics is {:.0} % of that with the network: an effect is still missing\n",
                100.0 * r
            ),
        };
    }
    if !document.contours.is_empty() {
        text += &contour_text(document);
    }
    text
}

fn contour_text(document: &HybridDocument) -> String {
    let um = |x: f64| format!("{:.2}", 1e6 * x);
    let circle = |name: &str| {
        PRINTED_CIRCLES
            .iter()
            .find(|p| p.0 == name)
            .map_or_else(String::new, |(_, _, a, h)| format!("{a:.2} / {h:.2}"))
    };
    let mut heads: Vec<String> =
        ["circle", "role", "contour error µm", "model error µm", "with network"].map(String::from).to_vec();
    let physics = document.contours.values().any(|c| c.physics_off_m.is_some());
    if physics {
        heads.push("with physics".into());
    }
    heads.push("paper".into());
    let cells = |(name, c): (&String, &ContourRow)| {
        let mut cells = vec![
            name.clone(),
            c.role.replace('_', " "),
            um(c.measured_m),
            um(c.analytical_off_m),
            um(c.hybrid_off_m),
        ];
        if physics {
            cells.push(c.physics_off_m.map_or_else(|| "–".into(), um));
        }
        cells.push(circle(name));
        cells
    };
    format!("\nlargest contour errors\n{}", columns(&heads, document.contours.iter().map(cells)))
}

fn physics_text(of: &PhysicsRow, column: &str) -> String {
    let PhysicsRow { result, machine, config, measurements } = of;
    format!("{column}: result {result}, machine «{machine}» ({config}), predicts {measurements}\n")
}
