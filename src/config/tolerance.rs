//! Configuration section of tolerances of stated numbers.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::fault;
use machine::{MachineError, Tolerance};

/// Standard deviations of stated numbers, relative unless stated otherwise. 0 fixes a number; an omitted key has the default in brackets.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToleranceFile {
    /// Effective diameter of each shaft (0.002).
    diameter: Option<f64>,
    /// Young's modulus of each shaft (0.003).
    youngs_modulus: Option<f64>,
    /// Ratio of shear modulus to Young's modulus of each shaft (0.004).
    shear_modulus: Option<f64>,
    /// Missing section at each end of a shaft, as an equivalent length in diameters; its standard deviation is half of it (0.35).
    end_diameters: Option<f64>,
    /// Length over which a nut supports its screw, relative to the typical length (0.5).
    nut_length: Option<f64>,
    /// The largest mass (0.01).
    mass: Option<f64>,
    /// The largest inertia (0.02).
    inertia: Option<f64>,
    /// Median loss factor of joints that state none, not a standard deviation (0.01).
    loss_factor: Option<f64>,
    /// Standard deviation of ln(loss factor) (1: a factor of e).
    loss_spread: Option<f64>,
    /// Share of dispersion of loss factors, not a standard deviation: 0 constant, 1 causal (0.5).
    loss_dispersion: Option<f64>,
    /// Standard deviation of that share (0.3).
    loss_dispersion_sd: Option<f64>,
    /// Damping of a guide that the description lacks, over the moving mass, in 1/s: standard deviation of a half-normal distribution (2.5).
    guide_damping: Option<f64>,
}

impl ToleranceFile {
    /// Returns the stated tolerances, with defaults for the others.
    pub fn tolerance(&self) -> Result<Tolerance, MachineError> {
        let mut known = Tolerance::default();
        // A larger relative standard deviation would make the stated number meaningless.
        const MOST: f64 = 0.15;
        let fields = [
            (&mut known.diameter, MOST),
            (&mut known.youngs_modulus, MOST),
            (&mut known.shear_modulus, MOST),
            (&mut known.end_diameters, 5.0),
            (&mut known.nut_length, 2.0),
            (&mut known.mass, MOST),
            (&mut known.inertia, MOST),
            (&mut known.loss_factor, 0.3),
            (&mut known.loss_spread, 3.0),
            (&mut known.loss_dispersion, 1.0),
            (&mut known.loss_dispersion_sd, 1.0),
            (&mut known.guide_damping, 100.0),
        ];
        for ((key, stated), (value, most)) in self.entries().into_iter().zip(fields) {
            match stated {
                None => {}
                Some(number) if (0.0..=most).contains(&number) => *value = number,
                Some(number) => {
                    let typical = *value;
                    let remedy = format!("is {number}; write a number from 0 to {most} (typically {typical}), or leave it out");
                    return Err(fault(format!("tolerance.{key}"), remedy));
                }
            }
        }
        Ok(known)
    }

    /// Returns the keys that are stated and not 0.
    pub fn stated(&self) -> Vec<&'static str> {
        self.entries().into_iter().filter(|(_, stated)| stated.is_some_and(|x| x != 0.0)).map(|(key, _)| key).collect()
    }

    fn entries(&self) -> [(&'static str, Option<f64>); 12] {
        [
            ("diameter", self.diameter),
            ("youngs_modulus", self.youngs_modulus),
            ("shear_modulus", self.shear_modulus),
            ("end_diameters", self.end_diameters),
            ("nut_length", self.nut_length),
            ("mass", self.mass),
            ("inertia", self.inertia),
            ("loss_factor", self.loss_factor),
            ("loss_spread", self.loss_spread),
            ("loss_dispersion", self.loss_dispersion),
            ("loss_dispersion_sd", self.loss_dispersion_sd),
            ("guide_damping", self.guide_damping),
        ]
    }
}
