//! Uniform shafts: rods with axial and torsional vibration between stations.

use super::{Operating, Value};

/// Where a station sits on its shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// At a fixed distance (m) from the shaft's left end.
    At(f64),
    /// At the nut, wherever that is.
    Nut,
    /// At the shaft's right end.
    End,
}

/// A named place on a shaft and the points that move with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Where it is.
    pub place: Place,
    /// The point (index) that moves axially with it.
    pub axial: Option<usize>,
    /// The point (index) that turns with it.
    pub torsion: Option<usize>,
}

/// A uniform shaft, cut into rods by its stations.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// Unique name.
    pub name: String,
    /// Length (m).
    pub length: Value,
    /// Diameter (m).
    pub diameter: Value,
    /// Young's modulus E (Pa).
    pub youngs_modulus: Value,
    /// Shear modulus G (Pa).
    pub shear_modulus: Value,
    /// Density ρ (kg/m³).
    pub density: Value,
    /// Loss factor η of the material: E and G times 1 + iη.
    pub loss_factor: Value,
    /// Stations from left to right.
    pub stations: Vec<Station>,
}

impl Shaft {
    /// Distance (m) of a station from the left end; `None` for the nut where no nut position is given.
    pub fn place_m(&self, place: Place, parameters: &[f64], operating: &Operating) -> Option<f64> {
        match place {
            Place::At(distance_m) => Some(distance_m),
            Place::Nut => operating.nut_m,
            Place::End => Some(self.length.at(parameters, operating)),
        }
    }
}
