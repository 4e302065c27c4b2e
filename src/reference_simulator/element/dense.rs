//! Small dense complex systems: LU factorisation with partial pivoting that skips zeros.

use num_complex::Complex64;

/// A square complex matrix and, once factored, its LU factors.
#[derive(Clone, Debug)]
pub struct Dense {
    size: usize,
    entries: Vec<Complex64>,
    order: Vec<usize>,
}

/// The matrix has no inverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotInvertible;

impl Dense {
    /// Creates a matrix of zeros.
    pub fn zeros(size: usize) -> Self {
        Self { size, entries: vec![Complex64::ZERO; size * size], order: vec![0; size] }
    }

    /// Sets all entries to zero.
    pub fn clear(&mut self) {
        self.entries.fill(Complex64::ZERO);
    }

    /// Adds to an entry.
    pub fn add(&mut self, row: usize, column: usize, value: Complex64) {
        self.entries[row * self.size + column] += value;
    }

    /// Returns an entry.
    #[cfg(test)]
    pub fn entry(&self, row: usize, column: usize) -> Complex64 {
        self.entries[row * self.size + column]
    }

    /// Replaces the matrix by its LU factors.
    pub fn factor(&mut self) -> Result<(), NotInvertible> {
        let n = self.size;
        for column in 0..n {
            let mut pivot = column;
            let mut largest = 0.0;
            for row in column..n {
                let size = self.entries[row * n + column].l1_norm();
                if size > largest {
                    largest = size;
                    pivot = row;
                }
            }
            if !(largest > 0.0 && largest.is_finite()) {
                return Err(NotInvertible);
            }
            self.order[column] = pivot;
            if pivot != column {
                for k in 0..n {
                    self.entries.swap(column * n + k, pivot * n + k);
                }
            }
            let inverse = self.entries[column * n + column].inv();
            let (above, below) = self.entries.split_at_mut((column + 1) * n);
            let lead = &above[column * n..];
            for row in below.chunks_exact_mut(n) {
                if row[column] == Complex64::ZERO {
                    continue;
                }
                let factor = row[column] * inverse;
                row[column] = factor;
                for (entry, upper) in row[column + 1..].iter_mut().zip(&lead[column + 1..]) {
                    *entry -= factor * upper;
                }
            }
        }
        Ok(())
    }

    /// Solves for one right-hand side in place; the matrix must have been factored.
    pub fn solve(&self, right: &mut [Complex64]) {
        let n = self.size;
        for column in 0..n {
            right.swap(column, self.order[column]);
        }
        for column in 0..n {
            let value = right[column];
            if value != Complex64::ZERO {
                for (row, entry) in right.iter_mut().enumerate().skip(column + 1) {
                    *entry -= self.entries[row * n + column] * value;
                }
            }
        }
        for row in (0..n).rev() {
            let entries = &self.entries[row * n..(row + 1) * n];
            let known: Complex64 =
                entries[row + 1..].iter().zip(&right[row + 1..]).map(|(entry, value)| entry * value).sum();
            right[row] = (right[row] - known) / entries[row];
        }
    }
}
