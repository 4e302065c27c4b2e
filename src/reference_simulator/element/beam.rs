//! Lateral bending of a uniform shaft: Euler–Bernoulli elements with consistent mass; doubling eliminates the inner nodes.

use num_complex::Complex64;

/// A 2 × 2 complex matrix, rows first.
type Two = [[Complex64; 2]; 2];

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
    /// Computes the dynamic stiffness over (w₁, φ₁, w₂, φ₂); `s2` = s², `modulus` is the complex factor on E I.
    pub fn ends(&self, s2: Complex64, modulus: Complex64) -> [[Complex64; 4]; 4] {
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
        let mut z = [[Complex64::ZERO; 4]; 4];
        for row in 0..4 {
            for column in row..4 {
                z[row][column] = modulus * (k * stiffness[row][column]) + s2 * (m * mass[row][column]);
                z[column][row] = z[row][column];
            }
        }
        for _ in 0..self.doublings {
            z = doubled(&z);
        }
        z
    }
}

/// Joins two equal chains end to end and eliminates the common node.
fn doubled(z: &[[Complex64; 4]; 4]) -> [[Complex64; 4]; 4] {
    let block = |r: usize, c: usize| -> Two { [[z[r][c], z[r][c + 1]], [z[r + 1][c], z[r + 1][c + 1]]] };
    let (first, cross, back, last) = (block(0, 0), block(0, 2), block(2, 0), block(2, 2));
    let inverse = inverted(&added(&last, &first));
    let into = product(&cross, &inverse);
    let onto = product(&back, &inverse);
    let own_first = subtracted(&first, &product(&into, &back));
    let own_last = subtracted(&last, &product(&onto, &cross));
    let passed = product(&into, &cross);
    let mut out = [[Complex64::ZERO; 4]; 4];
    for row in 0..2 {
        for column in 0..2 {
            out[row][column] = own_first[row][column];
            out[row + 2][column + 2] = own_last[row][column];
            out[row][column + 2] = -passed[row][column];
            out[column + 2][row] = -passed[row][column];
        }
    }
    out
}

fn product(a: &Two, b: &Two) -> Two {
    std::array::from_fn(|r| std::array::from_fn(|c| a[r][0] * b[0][c] + a[r][1] * b[1][c]))
}

fn added(a: &Two, b: &Two) -> Two {
    std::array::from_fn(|r| std::array::from_fn(|c| a[r][c] + b[r][c]))
}

fn subtracted(a: &Two, b: &Two) -> Two {
    std::array::from_fn(|r| std::array::from_fn(|c| a[r][c] - b[r][c]))
}

fn inverted(a: &Two) -> Two {
    let inverse = (a[0][0] * a[1][1] - a[0][1] * a[1][0]).inv();
    [[a[1][1] * inverse, -a[0][1] * inverse], [-a[1][0] * inverse, a[0][0] * inverse]]
}
