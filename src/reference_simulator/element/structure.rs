//! A structure: kept degrees of freedom, connected by branches, one-way links, rods and beams.

use num_complex::Complex64;

use super::Form;
use super::beam::Beam;
use super::dense::Dense;
use super::law::{LaplacePoint, Law};
use super::rod::Rod;
use crate::{Result, SimulatorError};

/// A linear structure, assembled line by line as dynamic stiffness.
#[derive(Clone, Debug, Default)]
pub struct Structure {
    size: usize,
    branches: Vec<(Form, Law)>,
    links: Vec<(usize, usize, Law)>,
    rods: Vec<(usize, usize, Rod)>,
    beams: Vec<([usize; 4], Beam)>,
    /// Material loss factor of rods.
    pub rod_loss: f64,
    /// Material loss factor of beams.
    pub beam_loss: f64,
    /// Share of dispersion of all losses.
    pub loss_dispersion: f64,
}

/// A measured response and its excitation, both as motions.
#[derive(Clone, Debug)]
pub struct Port {
    /// Measured motion.
    pub response: Form,
    /// Motion on which the unit force or torque acts.
    pub excitation: Form,
}

impl Structure {
    /// Adds a degree of freedom and returns its number.
    pub fn freedom(&mut self) -> usize {
        self.size += 1;
        self.size - 1
    }

    /// Adds z(s) v vᵀ.
    pub fn branch(&mut self, form: Form, law: Law) {
        self.branches.push((form, law));
    }

    /// Adds an inertia at one degree of freedom.
    pub fn inertia(&mut self, freedom: usize, value: f64) {
        self.branch(vec![(freedom, 1.0)], Law::Mass(value));
    }

    /// Adds z(s) at (row, column) alone: as in a controller, the motion of `column` causes a force at `row`.
    pub fn link(&mut self, row: usize, column: usize, law: Law) {
        self.links.push((row, column, law));
    }

    /// Adds a rod between two degrees of freedom.
    pub fn rod(&mut self, start: usize, end: usize, rod: Rod) {
        self.rods.push((start, end, rod));
    }

    /// Adds a beam over (w₁, φ₁, w₂, φ₂).
    pub fn beam(&mut self, freedoms: [usize; 4], beam: Beam) {
        self.beams.push((freedoms, beam));
    }

    /// Returns the number of rod elements, axial and torsional together.
    #[cfg(test)]
    pub fn rod_elements(&self) -> usize {
        self.rods.iter().map(|(_, _, rod)| rod.elements()).sum()
    }

    /// Assembles the dynamic stiffness at s.
    pub fn assemble(&self, s: Complex64, z: &mut Dense) {
        z.clear();
        let point = LaplacePoint::new(s, self.loss_dispersion);
        let s2 = point.s2;
        for (form, law) in &self.branches {
            let value = law.at(&point);
            for &(row, a) in form {
                for &(column, b) in form {
                    z.add(row, column, value * (a * b));
                }
            }
        }
        for (row, column, law) in &self.links {
            z.add(*row, *column, law.at(&point));
        }
        let modulus = point.modulus(self.rod_loss);
        for (start, end, rod) in &self.rods {
            let ends = rod.ends(s2, modulus);
            z.add(*start, *start, ends.first);
            z.add(*start, *end, ends.cross);
            z.add(*end, *start, ends.cross);
            z.add(*end, *end, ends.last);
        }
        let modulus = point.modulus(self.beam_loss);
        for (freedoms, beam) in &self.beams {
            let ends = beam.ends(s2, modulus);
            for (row, &at) in freedoms.iter().enumerate() {
                for (column, &to) in freedoms.iter().enumerate() {
                    z.add(at, to, ends[(row, column)]);
                }
            }
        }
    }

    /// Computes the receptances of the ports at each s: one vector of lines for each port.
    pub fn receptances(&self, ports: &[Port], lines: &[Complex64]) -> Result<Vec<Vec<Complex64>>> {
        let mut z = Dense::zeros(self.size);
        let mut out: Vec<Vec<Complex64>> = ports.iter().map(|_| Vec::with_capacity(lines.len())).collect();
        let mut excitations: Vec<&Form> = Vec::new();
        let mut column_of = Vec::with_capacity(ports.len());
        for port in ports {
            let column =
                excitations.iter().position(|known| **known == port.excitation).unwrap_or_else(|| {
                    excitations.push(&port.excitation);
                    excitations.len() - 1
                });
            column_of.push(column);
        }
        let mut solutions = vec![vec![Complex64::ZERO; self.size]; excitations.len()];
        for &s in lines {
            self.assemble(s, &mut z);
            z.factor().map_err(|_| SimulatorError::Singular {
                frequency_hz: s.im / (2.0 * std::f64::consts::PI),
            })?;
            for (solution, excitation) in solutions.iter_mut().zip(&excitations) {
                solution.fill(Complex64::ZERO);
                for &(row, weight) in excitation.iter() {
                    solution[row] += weight;
                }
                z.solve(solution);
            }
            for ((port, &column), values) in ports.iter().zip(&column_of).zip(&mut out) {
                let value: Complex64 =
                    port.response.iter().map(|&(row, weight)| solutions[column][row] * weight).sum();
                if !(value.re.is_finite() && value.im.is_finite()) {
                    return Err(SimulatorError::Singular {
                        frequency_hz: s.im / (2.0 * std::f64::consts::PI),
                    });
                }
                values.push(value);
            }
        }
        Ok(out)
    }
}
