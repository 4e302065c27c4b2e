//! Matrices of the lumped model: document and text.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use report::document::Stamp;

/// Matrices of the lumped model (`matrices.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MatricesDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Names of the coordinates, in the order of rows and columns.
    pub coordinates: Vec<String>,
    /// Mass matrix, by rows (SI units).
    pub mass: Vec<Vec<f64>>,
    /// Damping matrix, by rows (SI units).
    pub damping: Vec<Vec<f64>>,
    /// Stiffness matrix, by rows (SI units).
    pub stiffness: Vec<Vec<f64>>,
}

/// Largest number of columns of a matrix that is printed as text: six take 71 characters of a terminal of 80.
const WIDEST: usize = 6;

/// Returns matrices as text, under the title of the machine.
pub fn matrices_text(document: &MatricesDocument, title: &str) -> String {
    let mut text = format!("{title}\ncoordinates: {}\n", document.coordinates.join(", "));
    for (name, matrix) in [("M", &document.mass), ("C", &document.damping), ("K", &document.stiffness)] {
        let _ = writeln!(text, "\n{name}");
        let columns = matrix.first().map_or(0, Vec::len);
        if columns > WIDEST {
            let _ = writeln!(text, "{} × {columns}, too wide for a terminal; print it as JSON", matrix.len());
            continue;
        }
        for row in matrix {
            let cells: Vec<String> = row
                .iter()
                .map(|x| if *x == 0.0 { format!("{:>11}", "0") } else { format!("{x:>11.3e}") })
                .collect();
            let _ = writeln!(text, "{}", cells.join(" "));
        }
    }
    text
}
