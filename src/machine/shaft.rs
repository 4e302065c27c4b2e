//! Uniform shafts: rods with axial and torsional vibration between stations.

use super::{Operating, PointMotion, Value};

/// Where a station sits on its shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StationPlace {
    /// At a fixed distance (m) from the shaft's left end.
    At(f64),
    /// At the nut, wherever that is.
    Nut,
    /// At a distance (m) from the nut, towards the right end, times the shaft's factor.
    BesideNut(f64),
    /// At the shaft's right end.
    End,
}

/// A named place on a shaft and the points that move with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Where it is.
    pub place: StationPlace,
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
    /// Bore over diameter, 0 where it is solid.
    pub bore_ratio: Value,
    /// Young's modulus E (Pa).
    pub youngs_modulus: Value,
    /// Shear modulus G (Pa).
    pub shear_modulus: Value,
    /// Density ρ (kg/m³).
    pub density: Value,
    /// Loss factor η of the material: E and G times 1 + η·(i + s·2/π·ln(ω/ω₀)), s as in [`Machine::loss_dispersion`](super::Machine).
    pub loss_factor: Value,
    /// Factor of the distances of stations beside the nut.
    pub beside_nut: Value,
    /// How far the middle of the stations beside the nut lies from it, towards the right end, in distances of these.
    pub aside_of_nut: Value,
    /// Stations from left to right.
    pub stations: Vec<Station>,
}

impl Shaft {
    /// Distance (m) of a station from the left end; `None` for the nut where no nut position is given.
    pub fn place_m(&self, place: StationPlace, parameters: &[f64], operating: &Operating) -> Option<f64> {
        match place {
            StationPlace::At(distance_m) => Some(distance_m),
            StationPlace::Nut => operating.nut_m,
            StationPlace::BesideNut(offset_m) => {
                let (factor, aside) = (self.beside_nut.at(parameters, operating), self.aside_of_nut.at(parameters, operating));
                operating.nut_m.map(|nut_m| nut_m + offset_m * factor + offset_m.abs() * aside)
            }
            StationPlace::End => Some(self.length.at(parameters, operating)),
        }
    }

    /// Area of the section (m²) and its polar moment (m⁴).
    pub fn section(&self, parameters: &[f64], operating: &Operating) -> (f64, f64) {
        let (diameter_m, bore) = (self.diameter.at(parameters, operating), self.bore_ratio.at(parameters, operating));
        let solid_m2 = std::f64::consts::FRAC_PI_4 * diameter_m * diameter_m;
        (solid_m2 * (1.0 - bore.powi(2)), solid_m2 * diameter_m * diameter_m / 8.0 * (1.0 - bore.powi(4)))
    }

    /// Mass (kg) of the shaft, or its moment of inertia (kg·m²) about its axis.
    pub fn inertia(&self, motion: PointMotion, parameters: &[f64], operating: &Operating) -> f64 {
        let at = |value: &Value| value.at(parameters, operating);
        let (area_m2, polar_m4) = self.section(parameters, operating);
        let section = if motion == PointMotion::Translation { area_m2 } else { polar_m4 };
        at(&self.density) * at(&self.length) * section
    }

    /// Whether it is an end that [`Machine::with_tolerances`](super::Machine::with_tolerances) cut off.
    pub fn is_journal(&self) -> bool {
        self.name.starts_with("~journal")
    }

    /// Whether a point moves with one of its stations.
    pub fn carries(&self, point: usize) -> bool {
        self.stations.iter().any(|s| s.axial == Some(point) || s.torsion == Some(point))
    }
}
