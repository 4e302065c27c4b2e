//! Combines the numbers of a text payload to abscissa and ordinate values.

use num_complex::Complex64;

use crate::abscissa::Abscissa;
use crate::record::{Ordinate, RecordHeader};

/// Smallest size of a number and its blank in text (bytes).
const LEAST_BYTES: u64 = 2;
/// Usual size of a number and its blank in text (bytes).
const USUAL_BYTES: u64 = 13;

/// Values of a record: its abscissas if uneven, and its ordinates, real or complex.
#[derive(Debug, Default)]
pub(crate) struct Values {
    pub abscissa: Vec<f64>,
    pub real: Vec<f64>,
    pub complex: Vec<Complex64>,
}

impl Values {
    /// Reserves space for more values.
    pub fn reserve(&mut self, more: usize, complex: bool, even: bool) {
        if complex {
            self.complex.reserve_exact(more);
        } else {
            self.real.reserve_exact(more);
        }
        if !even {
            self.abscissa.reserve_exact(more);
        }
    }

    /// Returns abscissa and ordinate of the record.
    pub fn finish(mut self, header: &RecordHeader) -> (Abscissa, Ordinate) {
        let abscissa = if header.even {
            Abscissa::Even { first: header.abscissa_first, step: header.abscissa_step, count: header.count }
        } else {
            self.abscissa.shrink_to_fit();
            Abscissa::Uneven(self.abscissa)
        };
        self.complex.shrink_to_fit();
        self.real.shrink_to_fit();
        (
            abscissa,
            if header.ordinate_type.is_complex() {
                Ordinate::Complex(self.complex)
            } else {
                Ordinate::Real(self.real)
            },
        )
    }
}

/// Values read so far, up to the declared number.
#[derive(Debug)]
pub(crate) struct Points {
    values: Values,
    pending: [f64; 3],
    filled: usize,
    width: usize,
    even: bool,
    taken: usize,
    declared: usize,
}

impl Points {
    /// Reserves space for the values that a header declares, as far as the bytes left can hold them.
    pub fn new(header: &RecordHeader, bytes_left: u64) -> Self {
        let width = numbers_per_value(header);
        let mut points = Self {
            values: Values::default(),
            pending: [0.0; 3],
            filled: 0,
            width,
            even: header.even,
            taken: 0,
            declared: header.count,
        };
        points.reserve(header.ordinate_type.is_complex(), bytes_left / (USUAL_BYTES * width as u64) + 1);
        points
    }

    /// Reserves space for more values, never more than declared.
    fn reserve(&mut self, complex: bool, more: u64) {
        let more = usize::try_from(more).unwrap_or(usize::MAX).min(self.declared - self.taken);
        self.values.reserve(more, complex, self.even);
    }

    /// Whether all declared values are read.
    pub fn is_full(&self) -> bool {
        self.taken >= self.declared
    }

    /// Whether abscissas are among the numbers.
    pub fn has_abscissa(&self) -> bool {
        !self.even
    }

    /// Returns how many numbers make one value.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of numbers of the value that is not whole yet.
    pub fn filled(&self) -> usize {
        self.filled
    }

    /// Whether the next number is an abscissa.
    pub fn expects_abscissa(&self) -> bool {
        !self.even && self.filled == 0
    }

    /// Returns the number of whole values so far.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// Returns the number of numbers so far.
    pub fn numbers(&self) -> u64 {
        (self.taken * self.width + self.filled) as u64
    }

    /// Adds the next number; `bytes_left` bounds how many can follow.
    #[inline]
    pub fn push(&mut self, number: f64, bytes_left: u64) {
        self.pending[self.filled] = number;
        self.filled += 1;
        if self.filled < self.width {
            return;
        }
        self.filled = 0;
        let complex = self.width == 2 + usize::from(!self.even);
        if self.taken == if complex { self.values.complex.capacity() } else { self.values.real.capacity() } {
            self.reserve(complex, bytes_left / (LEAST_BYTES * self.width as u64) + 1);
        }
        self.taken += 1;
        let [first, second, third] = self.pending;
        match (complex, self.even) {
            (true, true) => self.values.complex.push(Complex64::new(first, second)),
            (false, true) => self.values.real.push(first),
            (true, false) => {
                self.values.abscissa.push(first);
                self.values.complex.push(Complex64::new(second, third));
            }
            (false, false) => {
                self.values.abscissa.push(first);
                self.values.real.push(second);
            }
        }
    }

    /// Returns the values.
    pub fn into_values(self) -> Values {
        self.values
    }
}

/// Returns how many numbers make one value: abscissa if uneven, real part, imaginary part if complex.
pub(crate) fn numbers_per_value(header: &RecordHeader) -> usize {
    1 + usize::from(header.ordinate_type.is_complex()) + usize::from(!header.even)
}
