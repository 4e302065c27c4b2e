//! Codes of a record: function type, axis quantities and data storage.

use std::fmt;

/// Codes of the function type (record 6, field 1) used in modal tests.
pub mod function_type {
    /// Time response.
    pub const TIME: i64 = 1;
    /// Frequency response function.
    pub const FREQUENCY_RESPONSE: i64 = 4;
    /// Coherence.
    pub const COHERENCE: i64 = 6;
}

/// Codes of the quantity of an axis (records 8 to 11, field 1) used in modal tests.
pub mod data_type {
    /// Unknown or unused.
    pub const UNKNOWN: i64 = 0;
    /// General: the unit exponents define the quantity.
    pub const GENERAL: i64 = 1;
    /// Displacement.
    pub const DISPLACEMENT: i64 = 8;
    /// Reaction force.
    pub const REACTION_FORCE: i64 = 9;
    /// Velocity.
    pub const VELOCITY: i64 = 11;
    /// Acceleration.
    pub const ACCELERATION: i64 = 12;
    /// Excitation force.
    pub const EXCITATION_FORCE: i64 = 13;
    /// Time.
    pub const TIME: i64 = 17;
    /// Frequency.
    pub const FREQUENCY: i64 = 18;
    /// Rotational speed.
    pub const ROTATIONAL_SPEED: i64 = 19;
    /// Order.
    pub const ORDER: i64 = 20;
}

/// Order of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant first, code 1.
    Little,
    /// Most significant first, code 2.
    Big,
}

/// Storage of the data of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Encoding {
    /// Text, dataset 58.
    #[default]
    Ascii,
    /// IEEE numbers, dataset 58b.
    Binary(ByteOrder),
}

/// Type and precision of the ordinate (record 7, field 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OrdinateType {
    /// Code 2.
    RealSingle,
    /// Code 4.
    RealDouble,
    /// Code 5.
    ComplexSingle,
    /// Code 6.
    #[default]
    ComplexDouble,
}

impl OrdinateType {
    /// Returns the type by its parts.
    pub fn new(complex: bool, double: bool) -> Self {
        match (complex, double) {
            (false, false) => Self::RealSingle,
            (false, true) => Self::RealDouble,
            (true, false) => Self::ComplexSingle,
            (true, true) => Self::ComplexDouble,
        }
    }

    /// Returns the type of a code in the file.
    pub fn from_code(code: i64) -> Option<Self> {
        [Self::RealSingle, Self::RealDouble, Self::ComplexSingle, Self::ComplexDouble]
            .into_iter()
            .find(|kind| kind.code() == code)
    }

    /// Returns its code in the file.
    pub fn code(self) -> i64 {
        match self {
            Self::RealSingle => 2,
            Self::RealDouble => 4,
            Self::ComplexSingle => 5,
            Self::ComplexDouble => 6,
        }
    }

    /// Whether values have a real and an imaginary part.
    pub fn is_complex(self) -> bool {
        matches!(self, Self::ComplexSingle | Self::ComplexDouble)
    }

    /// Whether a number has eight bytes.
    pub fn is_double(self) -> bool {
        matches!(self, Self::RealDouble | Self::ComplexDouble)
    }
}

impl fmt::Display for OrdinateType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::RealSingle => "real single",
            Self::RealDouble => "real double",
            Self::ComplexSingle => "complex single",
            Self::ComplexDouble => "complex double",
        })
    }
}
