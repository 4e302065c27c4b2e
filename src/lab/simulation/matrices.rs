//! Mass, damping and stiffness matrices.

use crate::document::matrices::MatricesDocument;
use nalgebra::DMatrix;
use study::simulation::{Load, Place, find_operating, load_warnings, require_count};
use study::{Study, StudyError, StudyResult};

/// What [`matrices`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct MatricesRequest {
    /// Place of the nut.
    pub place: Place,
    /// Load on the rolling contacts.
    pub load: Load,
    /// Number of springs per rod of the lumped model, each with half of its mass at either end.
    pub lumps: usize,
    /// Whether points without inertia are eliminated by static condensation.
    pub condense: bool,
}

impl Default for MatricesRequest {
    fn default() -> Self {
        MatricesRequest { place: Place::MidStroke, load: Load::default(), lumps: 1, condense: false }
    }
}

/// Computes the mass, damping and stiffness matrices of the lumped model.
///
/// # Errors  a setting outside its range; the machine does not allow the operating condition; a matrix does
///   not exist.
pub fn matrices(study: &Study, request: &MatricesRequest) -> StudyResult<MatricesDocument> {
    let machine = study.machine();
    let operating = find_operating(study, &request.place, &request.load)?;
    let lumps = require_count("lumps", request.lumps, 1)?;
    let mut found = dynamics::model::matrices(machine, &machine.start(), &operating, lumps)
        .map_err(StudyError::impossible)?;
    if request.condense {
        found = found.condensed().map_err(StudyError::impossible)?;
    }
    let rows =
        |m: &DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>();
    Ok(MatricesDocument {
        stamp: study.stamp(
            "matrices",
            0,
            true,
            load_warnings(machine, &request.load, std::slice::from_ref(&operating)),
        ),
        coordinates: found.names.clone(),
        mass: rows(&found.mass),
        damping: rows(&found.damping),
        stiffness: rows(&found.stiffness),
    })
}
