//! Dataset 164: the units of a file.

use crate::place::FilePlace;
use crate::warning::{Warning, WarningKind};

/// Units of the datasets that follow: value in SI = value in the file / factor.
#[derive(Debug, Clone, PartialEq)]
pub struct Units {
    /// Line of the dataset number.
    pub place: FilePlace,
    /// Units code: 1 m and N, 2 ft and lbf, 3 m and kgf, 4 ft and pdl, 5 mm and mN, 6 cm and cN, 7 in and
    /// lbf, 8 mm and kgf, 9 defined by the factors alone, 10 mm and N.
    pub code: i64,
    /// Description, for information only.
    pub description: String,
    /// 1 absolute, 2 relative.
    pub temperature_mode: i64,
    /// File units of length per metre.
    pub length_factor: f64,
    /// File units of force per newton.
    pub force_factor: f64,
    /// File units of temperature per kelvin.
    pub temperature_factor: f64,
    /// Offset of temperature.
    pub temperature_offset: f64,
}

// File units per SI unit: of length per metre, of force per newton.
const FOOT: f64 = 1.0 / 0.3048;
const INCH: f64 = 1.0 / 0.0254;
const POUND_FORCE: f64 = 1.0 / 4.448_221_615_260_5;
const POUNDAL: f64 = 1.0 / 0.138_254_954_376;
const KILOGRAM_FORCE: f64 = 1.0 / 9.806_65;
/// Largest relative deviation of a factor from that of its units code (1).
const FACTOR_TOLERANCE: f64 = 1e-3;

impl Units {
    /// Returns metre and newton.
    pub fn si() -> Self {
        Self {
            place: FilePlace::default(),
            code: 1,
            description: "SI: Meter (newton)".to_owned(),
            temperature_mode: 2,
            length_factor: 1.0,
            force_factor: 1.0,
            temperature_factor: 1.0,
            temperature_offset: 273.15,
        }
    }

    /// Converts a length of the file to metres.
    pub fn length_m(&self, length: f64) -> f64 {
        length / self.length_factor
    }

    /// Converts a force of the file to newtons.
    pub fn force_n(&self, force: f64) -> f64 {
        force / self.force_factor
    }

    /// Returns length and force factor of a units code.
    fn factors_of(code: i64) -> Option<(f64, f64)> {
        Some(match code {
            1 => (1.0, 1.0),
            2 => (FOOT, POUND_FORCE),
            3 => (1.0, KILOGRAM_FORCE),
            4 => (FOOT, POUNDAL),
            5 => (1e3, 1e3),
            6 => (1e2, 1e2),
            7 => (INCH, POUND_FORCE),
            8 => (1e3, KILOGRAM_FORCE),
            10 => (1e3, 1.0),
            _ => return None,
        })
    }

    /// Warns where the factors differ from those of the code.
    pub(crate) fn check(&self, warnings: &mut Vec<Warning>) {
        let Some((length, force)) = Self::factors_of(self.code) else { return };
        for (factor, found, expected) in
            [("length", self.length_factor, length), ("force", self.force_factor, force)]
        {
            if (found / expected - 1.0).abs() > FACTOR_TOLERANCE {
                warnings.push(
                    WarningKind::UnitsConflict { code: self.code, factor, found, expected }.at(self.place),
                );
            }
        }
    }
}
