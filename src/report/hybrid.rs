//! Result document of a model and a neural network trained on its residual, and its text.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;
use super::terminal::columns;

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

/// Tab. 3 of «Hybrid Multi-Domain Analytical and Data-Driven Modeling» (2019): record, feed (mm/min), errors of the analytical and of the hybrid model.
pub const PRINTED_SINES: [(&str, f64, PrintedErrors, PrintedErrors); 6] = [
    ("F1000", 1000.0, printed(7.99, 2.91, 4.2), printed(5.22, 1.87, 2.7)),
    ("F2000", 2000.0, printed(7.52, 2.83, 4.0), printed(5.16, 2.33, 2.0)),
    ("F3000", 3000.0, printed(7.70, 3.15, 1.4), printed(5.98, 1.72, 1.1)),
    ("F4000", 4000.0, printed(8.51, 3.84, 1.1), printed(5.27, 1.41, 0.7)),
    ("F5000", 5000.0, printed(10.2, 4.89, 1.1), printed(4.55, 1.64, 0.5)),
    ("F6000", 6000.0, printed(12.38, 6.21, 1.2), printed(6.79, 2.63, 0.6)),
];
/// Tab. 4 of the same paper: record, angular speed (rad/min), largest contour errors (µm) of the analytical and of the hybrid model.
pub const PRINTED_CIRCLES: [(&str, f64, f64, f64); 4] = [
    ("circle-60", 60.0, 7.19, 6.57),
    ("circle-80", 80.0, 8.62, 5.34),
    ("circle-100", 100.0, 10.26, 4.10),
    ("circle-120", 120.0, 12.54, 6.95),
];

/// Error of the predicted travel of one record: predicted minus measured travel of the point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// Root mean square of predicted minus measured travel (m).
    pub rmse_m: f64,
    /// Largest |predicted − measured travel| (m).
    pub largest_m: f64,
    /// `largest_m` over the largest measured tracking error |command − travel| (1).
    pub relative: f64,
}

/// Errors of one record, each with its root mean square (RMSE) and its maximum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HybridRow {
    /// `fit`: used in the fit; `held_out`: predicted only.
    pub role: String,
    /// Error of the physical model alone.
    pub analytical: Score,
    /// Error of the physical model with the neural network.
    pub hybrid: Score,
    /// Error of the model with the diagnosed effects as identified, where a result is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics: Option<Score>,
}

/// Training of the neural network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NeuralResidualRow {
    /// Root mean square of the residual of model and neural network over the training samples (m).
    // Former key, still read.
    #[serde(alias = "left_m")]
    pub residual_m: f64,
    /// Number of training samples.
    pub examples: usize,
    /// Number of evaluations of the objective in all trainings.
    pub evaluations: u64,
}

/// Contour error of one circle of two axes: distance from the commanded circle (m). Each figure is the maximum over the circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContourRow {
    /// `fit`: used in the fit of both axes; `held_out`: predicted only.
    pub role: String,
    /// Largest |contour error| measured (m).
    pub measured_m: f64,
    /// Largest contour error difference |predicted − measured| of the physical model (m).
    pub analytical_off_m: f64,
    /// Largest contour error difference of the physical model with the neural network (m).
    pub hybrid_off_m: f64,
    /// Largest contour error difference of the model with the diagnosed effects as identified (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics_off_m: Option<f64>,
}

/// The machine with the diagnosed effects as identified, and where it comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PhysicsRow {
    /// Path of the identification.json.
    pub result: String,
    /// Title of its machine.
    pub machine: String,
    /// Path of the machine's configuration.
    pub config: String,
    /// Measurement set whose records it predicts.
    pub measurements: String,
}

impl PhysicsRow {
    fn text(&self, column: &str) -> String {
        let PhysicsRow { result, machine, config, measurements } = self;
        format!("{column}: result {result}, machine «{machine}» ({config}), predicts {measurements}\n")
    }
}

/// Prediction of travel by a model, with and without a neural network (`hybrid.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HybridDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Name of the point whose travel is predicted.
    pub point: String,
    /// Errors of the first axis by record.
    pub records: BTreeMap<String, HybridRow>,
    /// Neural network of the first axis; the second axis has its own.
    pub network: NeuralResidualRow,
    /// Machine with the diagnosed effects, where a result is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics: Option<PhysicsRow>,
    /// The same of the second axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_physics: Option<PhysicsRow>,
    /// Median over held-out records of RMSE(with network)/RMSE(model) (1); absent where none is held out.
    pub median_ratio: Option<f64>,
    /// Median over held-out records of RMSE(with diagnosed effects)/RMSE(with network) (1).
    /// At most 1 where the identified effects predict as well as the network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_physics_to_hybrid: Option<f64>,
    /// Contour errors by circle: records of the same name in the sets of both axes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub contours: BTreeMap<String, ContourRow>,
}

/// Formats the errors by record and by circle, beside those of the published axis.
pub fn hybrid_text(document: &HybridDocument) -> String {
    let um = |x: f64| format!("{:.2}", 1e6 * x);
    let physics = document.records.values().any(|r| r.physics.is_some());
    let sine = |name: &str| PRINTED_SINES.iter().find(|p| p.0 == name);
    let circle =
        |name: &str| PRINTED_CIRCLES.iter().find(|p| p.0 == name).map_or_else(String::new, |(_, _, a, h)| format!("{a:.2} / {h:.2}"));
    let mut heads: Vec<String> = ["record", "role", "model RMSE µm", "with network"].map(String::from).to_vec();
    if physics {
        heads.push("with physics".into());
    }
    heads.push("paper".into());
    let cells = |(name, r): (&String, &HybridRow)| {
        let mut cells = vec![name.clone(), r.role.replace('_', " "), um(r.analytical.rmse_m), um(r.hybrid.rmse_m)];
        if physics {
            cells.push(r.physics.map_or_else(|| "–".into(), |p| um(p.rmse_m)));
        }
        cells.push(sine(name).map_or_else(String::new, |(_, _, a, h)| format!("{:.2} / {:.2}", a.rmse_um, h.rmse_um)));
        cells
    };
    let mut text = format!("travel of «{}», predicted from the command\n", document.point);
    if let Some(result) = &document.physics {
        text += &result.text("with physics");
    }
    if let Some(result) = &document.second_physics {
        text += &result.text("second axis with physics");
    }
    text += &columns(&heads, document.records.iter().map(cells));
    let heads: Vec<String> =
        ["record", "model MAE µm", "with network", "paper", "model RE %", "with network", "paper"].map(String::from).to_vec();
    let share = |x: f64| format!("{:.2}", 100.0 * x);
    let cells = |(name, r): (&String, &HybridRow)| {
        let pair = |of: fn(&PrintedErrors) -> f64, digits: usize| {
            sine(name).map_or_else(String::new, |(_, _, a, h)| format!("{:.digits$} / {:.digits$}", of(a), of(h)))
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
        text += &format!("\nheld out, median: with the network the error is {:.0} % of the model's\n", 100.0 * ratio);
    }
    if let Some(ratio) = document.median_physics_to_hybrid {
        text += &match ratio {
            r if r <= 1.2 => {
                format!(
                    "the error with physics is {:.0} % of that with the network: physics lacks nothing that the network learns\n",
                    100.0 * r
                )
            }
            r => format!("the error with physics is {:.0} % of that with the network: an effect is still missing\n", 100.0 * r),
        };
    }
    if !document.contours.is_empty() {
        let mut heads: Vec<String> = ["circle", "role", "contour error µm", "model error µm", "with network"].map(String::from).to_vec();
        let physics = document.contours.values().any(|c| c.physics_off_m.is_some());
        if physics {
            heads.push("with physics".into());
        }
        heads.push("paper".into());
        let cells = |(name, c): (&String, &ContourRow)| {
            let mut cells = vec![name.clone(), c.role.replace('_', " "), um(c.measured_m), um(c.analytical_off_m), um(c.hybrid_off_m)];
            if physics {
                cells.push(c.physics_off_m.map_or_else(|| "–".into(), um));
            }
            cells.push(circle(name));
            cells
        };
        text += "\nlargest contour errors\n";
        text += &columns(&heads, document.contours.iter().map(cells));
    }
    text
}
