//! How well a description knows the numbers that it states and nobody fits.

/// Standard deviations, relative unless it says otherwise.
///
/// # Source  the defaults by the scatter of catalogues, drawings and weighing (largest deviation over about two): effective diameter of a threaded shaft ±0.2 %, E ±0.3 %,
/// G/E ±0.4 %, mass ±1 %, inertia of a rotor ±2 %; ends by the journals of machined screws, which are 5 to 15 % thinner over 1 to 2.5 diameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Effective diameter of each shaft.
    pub diameter: f64,
    /// Young's modulus of each shaft.
    pub youngs_modulus: f64,
    /// Shear modulus of each shaft over Young's.
    pub shear_modulus: f64,
    /// What ends of each shaft lack of its whole section, in diameters of length.
    pub end_diameters: f64,
    /// The largest mass.
    pub mass: f64,
    /// The largest inertia.
    pub inertia: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Tolerance { diameter: 0.002, youngs_modulus: 0.003, shear_modulus: 0.004, end_diameters: 0.45, mass: 0.01, inertia: 0.02 }
    }
}
