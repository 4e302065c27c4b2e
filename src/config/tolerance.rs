//! How well what a machine's file states is known.

use schemars::JsonSchema;
use serde::Deserialize;

use machine::Tolerance;

/// Standard deviations of stated numbers, relative unless it says otherwise; the ordinary ones where they are left out.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToleranceFile {
    /// Effective diameter of each shaft (0.002).
    diameter: Option<f64>,
    /// Young's modulus of each shaft (0.003).
    youngs_modulus: Option<f64>,
    /// Shear modulus of each shaft over Young's (0.004).
    shear_modulus: Option<f64>,
    /// What ends of each shaft lack of its whole section, in diameters of length (0.45).
    end_diameters: Option<f64>,
    /// The largest mass (0.01).
    mass: Option<f64>,
    /// The largest inertia (0.02).
    inertia: Option<f64>,
}

impl ToleranceFile {
    /// What it states.
    pub fn tolerance(&self) -> Result<Tolerance, String> {
        let ordinary = Tolerance::default();
        // What is fitted along stays within six of them: nothing becomes negative.
        let known = |key: &str, stated: Option<f64>, ordinary: f64, most: f64| match stated {
            Some(sd) if !(sd > 0.0 && sd < most) => Err(format!(
                "tolerance.{key}: is {sd}; write a standard deviation between 0 and {most} (ordinarily {ordinary}), or leave it out"
            )),
            stated => Ok(stated.unwrap_or(ordinary)),
        };
        Ok(Tolerance {
            diameter: known("diameter", self.diameter, ordinary.diameter, 0.15)?,
            youngs_modulus: known("youngs_modulus", self.youngs_modulus, ordinary.youngs_modulus, 0.15)?,
            shear_modulus: known("shear_modulus", self.shear_modulus, ordinary.shear_modulus, 0.15)?,
            end_diameters: known("end_diameters", self.end_diameters, ordinary.end_diameters, 5.0)?,
            mass: known("mass", self.mass, ordinary.mass, 0.15)?,
            inertia: known("inertia", self.inertia, ordinary.inertia, 0.15)?,
        })
    }
}
