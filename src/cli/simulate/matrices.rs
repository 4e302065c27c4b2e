//! `jointid simulate matrices`: mass, damping and stiffness matrices.

use std::fmt::Write;

use super::operating::{LoadArguments, find_operating, load_warnings};
use crate::arguments::{OutputArguments, Sources};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{load_machine, stamp};
use report::simulation::MatricesDocument;

/// Largest number of columns of a matrix that is printed as text: six take 71 characters of a terminal of 80.
const WIDEST: usize = 6;

/// Arguments of `simulate matrices`.
#[derive(Debug, clap::Args)]
pub struct MatricesArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Number of springs per rod of the lumped model, each with half of its mass at either end
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub lumps: u16,
    /// Eliminate points without inertia by static condensation
    #[arg(long)]
    pub condense: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &MatricesArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let operating = find_operating(&loaded, given.nut_m, None, &given.load)?;
    let folder = prepare(&given.output)?;
    let mut found = dynamics::model::matrices(machine, &machine.start(), &operating, usize::from(given.lumps)).map_err(to_message)?;
    if given.condense {
        found = found.condensed().map_err(to_message)?;
    }
    let rows = |m: &nalgebra::DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>();
    let warnings = load_warnings(machine, &given.load);
    warn(&given.output, &warnings);
    let mut text = format!("{}\ncoordinates: {}\n", machine.title, found.names.join(", "));
    for (name, matrix) in [("M", &found.mass), ("C", &found.damping), ("K", &found.stiffness)] {
        let _ = writeln!(text, "\n{name}");
        if matrix.ncols() > WIDEST {
            let _ = writeln!(text, "{} × {}, too wide for a terminal; print it with --json", matrix.nrows(), matrix.ncols());
            continue;
        }
        for row in matrix.row_iter() {
            let cells: Vec<String> = row.iter().map(|x| if *x == 0.0 { format!("{:>11}", "0") } else { format!("{x:>11.3e}") }).collect();
            let _ = writeln!(text, "{}", cells.join(" "));
        }
    }
    let document = MatricesDocument {
        stamp: stamp("matrices", 0, true, &loaded, warnings),
        coordinates: found.names.clone(),
        mass: rows(&found.mass),
        damping: rows(&found.damping),
        stiffness: rows(&found.stiffness),
    };
    deliver(&given.output, folder.as_ref(), "matrices.json", &document, &text)
}
