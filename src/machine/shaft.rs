//! Uniform shafts: rods with axial and torsional vibration between stations.

use super::{Bending, Operating, PointMotion, Value};

/// The place of a station on its shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StationPlace {
    /// At a fixed distance (m) from the shaft's left end.
    At(f64),
    /// At the nut position.
    Nut,
    /// At a distance (m) from the nut, positive towards the right end, multiplied by the shaft's factor.
    NearNut(f64),
    /// At the shaft's right end.
    End,
}

/// A place on a shaft and the points that move with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Its place.
    pub place: StationPlace,
    /// The point (index) that moves axially with it.
    pub axial: Option<usize>,
    /// The point (index) that rotates with it.
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
    /// Bore diameter divided by outer diameter; 0 for a solid shaft.
    pub bore_ratio: Value,
    /// Young's modulus E (Pa).
    pub youngs_modulus: Value,
    /// Shear modulus G (Pa).
    pub shear_modulus: Value,
    /// Density ρ (kg/m³).
    pub density: Value,
    /// Loss factor η of the material: E and G are multiplied by 1 + η·(i + s·2/π·ln(ω/ω₀)), s as in
    /// [`Machine::loss_dispersion`](super::Machine).
    pub loss_factor: Value,
    /// True position of the nut (m): the stated one, unless an effect changes it.
    pub nut_position: Value,
    /// Factor of the distances between the nut and the stations next to it.
    pub nut_support_factor: Value,
    /// Offset of the midpoint of these stations from the nut, positive towards the right end, in units of
    /// their nominal distance from the nut.
    pub nut_support_offset: Value,
    /// Stations from left to right.
    pub stations: Vec<Station>,
    /// Name of the shaft whose end a journal is; `None` for other shafts.
    pub journal_of: Option<String>,
    /// Its lateral bending, if described.
    pub bending: Option<Bending>,
}

/// Least free length between a nut at a changed position and the next stations, as a share of the distance
/// between these.
const LEAST_SPAN: f64 = 0.01;

impl Shaft {
    /// Returns the distance (m) of a station from the left end; `None` at the nut where no nut position is
    /// given.
    pub fn place_m(&self, place: StationPlace, parameters: &[f64], operating: &Operating) -> Option<f64> {
        match place {
            StationPlace::At(distance_m) => Some(distance_m),
            StationPlace::Nut => self.nut_m(parameters, operating),
            StationPlace::NearNut(offset_m) => self
                .nut_m(parameters, operating)
                .map(|nut_m| self.support_m(nut_m, offset_m, parameters, operating)),
            StationPlace::End => Some(self.length.at(parameters, operating)),
        }
    }

    /// Returns the true position (m) of the nut; `None` where no nut position is given.
    pub fn nut_m(&self, parameters: &[f64], operating: &Operating) -> Option<f64> {
        let stated_m = operating.nut_m?;
        if self.nut_position.modifiers.is_empty() {
            return Some(stated_m);
        }
        let [low_m, high_m] = self.nut_range_m(stated_m, parameters, operating);
        Some(self.nut_position.at(parameters, operating).max(low_m).min(high_m))
    }

    /// Whether the true position of the nut follows the parameters that change it: it stops before its
    /// supports reach the next stations.
    pub fn nut_moves(&self, parameters: &[f64], operating: &Operating) -> bool {
        self.nut_m(parameters, operating) == Some(self.nut_position.at(parameters, operating))
    }

    /// Returns the range of true nut positions (m): its supports stay between the next stations. It includes
    /// the stated position.
    fn nut_range_m(&self, stated_m: f64, parameters: &[f64], operating: &Operating) -> [f64; 2] {
        let is_at_nut =
            |station: &Station| matches!(station.place, StationPlace::Nut | StationPlace::NearNut(_));
        let place_m = |station: &Station| self.place_m(station.place, parameters, operating);
        let first = self.stations.iter().position(is_at_nut).unwrap_or(0);
        let after = self.stations[first..].iter().find(|station| !is_at_nut(station)).and_then(place_m);
        let before = self.stations[..first].last().and_then(place_m);
        let (before_m, after_m) =
            (before.unwrap_or(0.0), after.unwrap_or_else(|| self.length.at(parameters, operating)));
        let margin_m = LEAST_SPAN * (after_m - before_m);
        let supports = self.stations[first..].iter().filter_map(|station| match station.place {
            StationPlace::NearNut(offset_m) => Some(self.support_m(0.0, offset_m, parameters, operating)),
            _ => None,
        });
        let [left_m, right_m] =
            supports.fold([0.0_f64; 2], |[left, right], at| [left.min(at), right.max(at)]);
        [stated_m.min(before_m + margin_m - left_m), stated_m.max(after_m - margin_m - right_m)]
    }

    /// Returns the place (m) of a support of a nut at `nut_m`, nominally at this distance from it.
    fn support_m(&self, nut_m: f64, offset_m: f64, parameters: &[f64], operating: &Operating) -> f64 {
        let (factor, aside) = (
            self.nut_support_factor.at(parameters, operating),
            self.nut_support_offset.at(parameters, operating),
        );
        nut_m + offset_m * factor + offset_m.abs() * aside
    }

    /// Returns the cross-sectional area (m²) and its polar second moment (m⁴).
    pub fn section(&self, parameters: &[f64], operating: &Operating) -> (f64, f64) {
        let (diameter_m, bore) =
            (self.diameter.at(parameters, operating), self.bore_ratio.at(parameters, operating));
        let solid_m2 = std::f64::consts::FRAC_PI_4 * diameter_m * diameter_m;
        (solid_m2 * (1.0 - bore.powi(2)), solid_m2 * diameter_m * diameter_m / 8.0 * (1.0 - bore.powi(4)))
    }

    /// Returns the mass (kg) of the shaft, or its moment of inertia (kg·m²) about its axis.
    pub fn inertia(&self, motion: PointMotion, parameters: &[f64], operating: &Operating) -> f64 {
        let at = |value: &Value| value.at(parameters, operating);
        let (area_m2, polar_m4) = self.section(parameters, operating);
        let section = if motion == PointMotion::Translation { area_m2 } else { polar_m4 };
        at(&self.density) * at(&self.length) * section
    }

    /// Whether it is a journal separated by [`Machine::with_tolerances`](super::Machine::with_tolerances).
    pub fn is_journal(&self) -> bool {
        self.journal_of.is_some()
    }

    /// Whether it has both axial and torsional motion.
    pub(super) fn couples_motions(&self) -> bool {
        self.stations.iter().any(|s| s.axial.is_some()) && self.stations.iter().any(|s| s.torsion.is_some())
    }

    /// Whether a point moves with one of its stations.
    pub fn carries(&self, point: usize) -> bool {
        self.stations.iter().any(|s| s.axial == Some(point) || s.torsion == Some(point))
    }
}
