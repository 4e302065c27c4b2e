//! Lateral bending of a uniform shaft: Euler–Bernoulli elements with consistent mass; doubling eliminates the
//! inner nodes.

use nalgebra::{Matrix2, Matrix4};
use num_complex::Complex64;

/// 2^doublings equal beam elements between two kept nodes, each with deflection and slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Bending stiffness E I.
    pub rigidity: f64,
    /// Mass per length ρ S.
    pub mass_per_length: f64,
    /// Length of one element.
    pub element_m: f64,
    /// Binary logarithm of the number of elements.
    pub doublings: u32,
}

impl Beam {
    /// Computes the dynamic stiffness over (w₁, φ₁, w₂, φ₂); `s2` = s², `modulus` is the complex factor on E
    /// I.
    pub fn ends(&self, s2: Complex64, modulus: Complex64) -> Matrix4<Complex64> {
        let h = self.element_m;
        let k = self.rigidity / (h * h * h);
        let m = self.mass_per_length * h / 420.0;
        let stiffness = [
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [0.0, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
            [0.0, 0.0, 12.0, -6.0 * h],
            [0.0, 0.0, 0.0, 4.0 * h * h],
        ];
        let mass = [
            [156.0, 22.0 * h, 54.0, -13.0 * h],
            [0.0, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
            [0.0, 0.0, 156.0, -22.0 * h],
            [0.0, 0.0, 0.0, 4.0 * h * h],
        ];
        let mut z = Matrix4::zeros();
        for row in 0..4 {
            for column in row..4 {
                z[(row, column)] = modulus * (k * stiffness[row][column]) + s2 * (m * mass[row][column]);
                z[(column, row)] = z[(row, column)];
            }
        }
        for _ in 0..self.doublings {
            z = doubled(&z);
        }
        z
    }
}

/// Joins two equal chains end to end and eliminates the common node.
fn doubled(z: &Matrix4<Complex64>) -> Matrix4<Complex64> {
    let block = |row: usize, column: usize| z.fixed_view::<2, 2>(row, column).into_owned();
    let (first, cross, back, last) = (block(0, 0), block(0, 2), block(2, 0), block(2, 2));
    let inverse = inverted(&(last + first));
    let into = cross * inverse;
    let passed = into * cross;
    let mut out = Matrix4::zeros();
    out.fixed_view_mut::<2, 2>(0, 0).copy_from(&(first - into * back));
    out.fixed_view_mut::<2, 2>(2, 2).copy_from(&(last - back * inverse * cross));
    out.fixed_view_mut::<2, 2>(0, 2).copy_from(&-passed);
    out.fixed_view_mut::<2, 2>(2, 0).copy_from(&-passed.transpose());
    out
}

fn inverted(a: &Matrix2<Complex64>) -> Matrix2<Complex64> {
    let inverse = (a.m11 * a.m22 - a.m12 * a.m21).inv();
    Matrix2::new(a.m22 * inverse, -a.m12 * inverse, -a.m21 * inverse, a.m11 * inverse)
}
