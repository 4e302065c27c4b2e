//! Four frequencies at once: numbers side by side, so that the processor's vector units work on all of them.

use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_complex::Complex64;
pub use wide::f64x4 as Reals;

use super::elimination::Scalar;

/// Numbers side by side.
pub const LANES: usize = 4;

/// Most groups of numbers side by side that are worked on in turn: what one group waits for, the others do not.
pub const ABREAST: usize = 8;

/// Complex numbers side by side.
#[derive(Debug, Clone, Copy)]
pub struct Complexes {
    /// Real parts.
    pub re: Reals,
    /// Imaginary parts.
    pub im: Reals,
}

impl Complexes {
    /// Noughts.
    pub const ZERO: Complexes = Complexes { re: Reals::ZERO, im: Reals::ZERO };

    /// From real and imaginary parts.
    pub fn new(re: Reals, im: Reals) -> Self {
        Complexes { re, im }
    }

    /// Real numbers.
    pub fn real(re: Reals) -> Self {
        Complexes { re, im: Reals::ZERO }
    }

    /// The same number in every lane.
    pub fn splat(z: Complex64) -> Self {
        Complexes { re: Reals::splat(z.re), im: Reals::splat(z.im) }
    }

    /// From one number for each lane.
    pub fn each(of: impl Fn(usize) -> Complex64) -> Self {
        let z: [Complex64; LANES] = std::array::from_fn(of);
        Complexes { re: Reals::from(z.map(|z| z.re)), im: Reals::from(z.map(|z| z.im)) }
    }

    /// The numbers one by one.
    pub fn apart(self) -> [Complex64; LANES] {
        let (re, im) = (self.re.to_array(), self.im.to_array());
        std::array::from_fn(|lane| Complex64::new(re[lane], im[lane]))
    }

    /// |z|².
    pub fn norm_sqr(self) -> Reals {
        self.re * self.re + self.im * self.im
    }

    /// The real part of z·conj a.
    #[inline(always)]
    pub fn dot(self, a: Self) -> Reals {
        self.re.mul_add(a.re, self.im * a.im)
    }

    /// z·a + b.
    #[inline(always)]
    pub fn mul_add(self, a: Self, b: Self) -> Self {
        Complexes { re: self.re.mul_add(a.re, self.im.mul_neg_add(a.im, b.re)), im: self.re.mul_add(a.im, self.im.mul_add(a.re, b.im)) }
    }

    /// 1/z.
    #[inline]
    pub fn inverse(self) -> Self {
        Scalar::inverse(self)
    }

    /// Its complex conjugate.
    #[inline]
    pub fn conj(self) -> Self {
        Complexes { re: self.re, im: -self.im }
    }

    /// ln z, its imaginary part between −π and π.
    pub fn ln(self) -> Self {
        Complexes { re: self.norm_sqr().ln() * Reals::splat(0.5), im: self.im.atan2(self.re) }
    }

    /// √z, its real part not negative; without angles.
    pub fn sqrt(self) -> Self {
        let re = ((self.norm_sqr().sqrt() + self.re.abs()) * Reals::splat(0.5)).sqrt();
        let im = re.simd_gt(Reals::ZERO).select(self.im * Reals::splat(0.5) / re, Reals::ZERO);
        let negative = self.re.is_sign_negative();
        let turned = self.im.is_sign_negative().select(-re, re);
        Complexes::new(negative.select(im.abs(), re), negative.select(turned, im))
    }

    /// sin z and cos z.
    pub fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        let (sinh, cosh) = sinh_cosh(self.im);
        (Complexes::new(sin * cosh, cos * sinh), Complexes::new(cos * cosh, -(sin * sinh)))
    }

    /// i·z.
    pub fn turned(self) -> Self {
        Complexes { re: -self.im, im: self.re }
    }
}

/// sinh x and cosh x; sinh of small x by its series, so that it keeps all its digits.
fn sinh_cosh(x: Reals) -> (Reals, Reals) {
    let size = x.abs();
    let grows = size.exp();
    let falls = Reals::ONE / grows;
    let square = x * x;
    let series = SINH.iter().fold(Reals::ZERO, |sum, c| sum.mul_add(square, Reals::splat(*c))) * x;
    let far = (grows - falls) * Reals::splat(0.5);
    let sinh = size.simd_lt(Reals::splat(0.3)).select(series, x.is_sign_negative().select(-far, far));
    (sinh, (grows + falls) * Reals::splat(0.5))
}

/// 1/11!, 1/9!, … 1: what is left out is below 1e-16 of sinh x where |x| < 0.3.
const SINH: [f64; 6] = [1.0 / 39_916_800.0, 1.0 / 362_880.0, 1.0 / 5_040.0, 1.0 / 120.0, 1.0 / 6.0, 1.0];

impl Add for Complexes {
    type Output = Self;
    #[inline]
    fn add(self, z: Self) -> Self {
        Complexes { re: self.re + z.re, im: self.im + z.im }
    }
}

impl Sub for Complexes {
    type Output = Self;
    #[inline]
    fn sub(self, z: Self) -> Self {
        Complexes { re: self.re - z.re, im: self.im - z.im }
    }
}

impl Mul for Complexes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, z: Self) -> Self {
        Complexes { re: self.im.mul_neg_add(z.im, self.re * z.re), im: self.re.mul_add(z.im, self.im * z.re) }
    }
}

impl Mul<Reals> for Complexes {
    type Output = Self;
    #[inline]
    fn mul(self, x: Reals) -> Self {
        Complexes { re: self.re * x, im: self.im * x }
    }
}

impl Mul<f64> for Complexes {
    type Output = Self;
    #[inline]
    fn mul(self, x: f64) -> Self {
        self * Reals::splat(x)
    }
}

impl Neg for Complexes {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Complexes { re: -self.re, im: -self.im }
    }
}

impl AddAssign for Complexes {
    #[inline]
    fn add_assign(&mut self, z: Self) {
        *self = *self + z;
    }
}

impl SubAssign for Complexes {
    #[inline]
    fn sub_assign(&mut self, z: Self) {
        *self = *self - z;
    }
}

impl MulAssign for Complexes {
    #[inline]
    fn mul_assign(&mut self, z: Self) {
        *self = Mul::<Complexes>::mul(*self, z);
    }
}

impl Scalar for Reals {
    const ZERO: Self = Reals::ZERO;

    #[inline(always)]
    fn inverse(self) -> Self {
        Reals::ONE / self
    }

    #[inline(always)]
    fn less(self, a: Self, b: Self) -> Self {
        a.mul_neg_add(b, self)
    }
}

impl Scalar for Complexes {
    const ZERO: Self = Complexes::ZERO;

    #[inline(always)]
    fn less(self, a: Self, b: Self) -> Self {
        Complexes { re: a.im.mul_add(b.im, a.re.mul_neg_add(b.re, self.re)), im: a.im.mul_neg_add(b.re, a.re.mul_neg_add(b.im, self.im)) }
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        let scale = Reals::ONE / self.norm_sqr();
        Complexes { re: self.re * scale, im: -(self.im * scale) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_square_roots_squared_are_the_numbers() {
        for z in [(3.0, 4.0), (-3.0, 4.0), (-3.0, -4.0), (5.0, 0.0), (-5.0, 0.0), (0.0, 0.0), (0.0, -2.0)] {
            let root = Complexes::splat(Complex64::new(z.0, z.1)).sqrt().apart()[0];
            assert!((root * root - Complex64::new(z.0, z.1)).norm() < 1e-14, "{z:?}: {root}");
        }
    }

    /// Beside those of single numbers, on both sides of where the series ends, and where the imaginary part is all there is.
    #[test]
    fn limit_sines_and_cosines_are_those_of_single_numbers() {
        for re in [0.0, 1e-9, 0.7, std::f64::consts::PI, 9.0, 40.0] {
            for im in [0.0, 1e-12, -1e-4, 0.05, 0.299, -0.301, 1.5, -12.0] {
                let z = Complex64::new(re, im);
                let (sin, cos) = Complexes::splat(z).sin_cos();
                let near = |a: Complex64, b: Complex64| (a - b).norm() <= 4e-15 * b.norm() + 1e-24;
                assert!(near(sin.apart()[1], z.sin()) && near(cos.apart()[2], z.cos()), "{z}: {:?} {:?}", sin.apart()[1], z.sin());
            }
        }
    }
}
