//! A function at a node (dataset 58): header and data.

use std::sync::Arc;

use num_complex::Complex64;

use crate::abscissa::Abscissa;
use crate::field::is_unused;
use crate::kind::{Encoding, OrdinateType, data_type, function_type};
use crate::place::FilePlace;
use crate::units::Units;
use crate::warning::Warning;

/// Node and direction of a response or excitation.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct NodeLocation {
    /// Name of the entity, as in the file.
    pub entity: String,
    /// Node number.
    pub node: i64,
    /// ±1, ±2, ±3 along X, Y, Z; ±4, ±5, ±6 about them; 0 scalar.
    pub direction: i64,
}

/// Quantity and unit of an axis.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RecordAxis {
    /// Specific data type, see [`data_type`](crate::data_type).
    pub data_type: i64,
    /// Exponent of length in the unit; used only for [`data_type::GENERAL`] and scalar directions.
    pub length_exponent: i64,
    /// Exponent of force in the unit.
    pub force_exponent: i64,
    /// Exponent of temperature in the unit.
    pub temperature_exponent: i64,
    /// Label, as in the file.
    pub label: String,
    /// Unit, as in the file.
    pub unit: String,
}

impl RecordAxis {
    /// Creates an axis of a data type with label and unit.
    pub fn new(data_type: i64, label: &str, unit: &str) -> Self {
        Self { data_type, label: label.to_owned(), unit: unit.to_owned(), ..Self::default() }
    }

    /// Returns the unit, if the file gives one: neither blank nor `NONE`.
    pub fn unit(&self) -> Option<&str> {
        (!is_unused(&self.unit)).then_some(self.unit.as_str())
    }
}

/// A record without its data.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordHeader {
    /// Line of the dataset number.
    pub place: FilePlace,
    /// Storage of the data.
    pub encoding: Encoding,
    /// The five identification lines: description, run, date and time, load case, free.
    pub id_lines: [String; 5],
    /// Function type, see [`function_type`](crate::function_type).
    pub function_type: i64,
    /// Number of the function.
    pub function_id: i64,
    /// Version or sequence number.
    pub version: i64,
    /// Load case; 0 is a single excitation.
    pub load_case: i64,
    /// Response location.
    pub response: NodeLocation,
    /// Reference or excitation location.
    pub reference: NodeLocation,
    /// Type and precision of the ordinate as read; the payload decides where its precision contradicts the
    /// header.
    pub ordinate_type: OrdinateType,
    /// Number of values (pairs if uneven), as read.
    pub count: usize,
    /// Whether the abscissa has a constant step and is not stored.
    pub even: bool,
    /// First abscissa, if even.
    pub abscissa_first: f64,
    /// Step of the abscissa, if even.
    pub abscissa_step: f64,
    /// Value on the z axis.
    pub z_value: f64,
    /// Abscissa (record 8).
    pub abscissa: RecordAxis,
    /// Ordinate, or its numerator (record 9).
    pub ordinate: RecordAxis,
    /// Denominator of the ordinate (record 10).
    pub denominator: RecordAxis,
    /// z axis (record 11).
    pub z_axis: RecordAxis,
    /// The dataset 164 in force: the last one before the record.
    pub units: Option<Arc<Units>>,
    /// Tolerated faults of this record.
    pub warnings: Vec<Warning>,
}

/// Ordinate values.
#[derive(Debug, Clone, PartialEq)]
pub enum Ordinate {
    /// Real.
    Real(Vec<f64>),
    /// Complex.
    Complex(Vec<Complex64>),
}

impl Ordinate {
    /// Returns the number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Complex(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A function at a node.
#[derive(Debug, Clone, PartialEq)]
pub struct UniversalRecord {
    /// Header.
    pub header: RecordHeader,
    /// Abscissa values.
    pub abscissa: Abscissa,
    /// Ordinate values.
    pub ordinate: Ordinate,
}

impl UniversalRecord {
    /// Creates a record from header and data; type, spacing and count of the header follow the data (double
    /// precision is kept).
    pub fn new(mut header: RecordHeader, abscissa: Abscissa, ordinate: Ordinate) -> Self {
        header.ordinate_type =
            OrdinateType::new(matches!(ordinate, Ordinate::Complex(_)), header.ordinate_type.is_double());
        header.count = ordinate.len();
        (header.even, header.abscissa_first, header.abscissa_step) = match abscissa {
            Abscissa::Even { first, step, .. } => (true, first, step),
            Abscissa::Uneven(_) => (false, 0.0, 0.0),
        };
        Self { header, abscissa, ordinate }
    }

    /// Creates an FRF in double precision: motion in `numerator` (data type and unit) over excitation force
    /// in N, frequency in Hz.
    pub fn frequency_response(
        response: NodeLocation,
        reference: NodeLocation,
        numerator: RecordAxis,
        frequency_hz: Abscissa,
        values: Vec<Complex64>,
    ) -> Self {
        let header = RecordHeader {
            function_type: function_type::FREQUENCY_RESPONSE,
            response,
            reference,
            abscissa: RecordAxis::new(data_type::FREQUENCY, "Frequency", "Hz"),
            ordinate: numerator,
            denominator: RecordAxis::new(data_type::EXCITATION_FORCE, "Force", "N"),
            ..RecordHeader::default()
        };
        Self::new(header, frequency_hz, Ordinate::Complex(values))
    }
}
