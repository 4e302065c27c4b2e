//! SIMD numbers: four frequencies are evaluated at once by the processor's vector units.

use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_complex::Complex64;
pub use wide::f64x4 as Reals;

use super::scalar::Scalar;

/// Numbers per SIMD group.
pub const LANES: usize = 4;

/// Largest number of SIMD groups evaluated together, which hides the latency of the operations of one group.
pub const ABREAST: usize = 8;

/// Packs up to [`LANES`] numbers into one group; the last number fills the rest.
pub(super) fn padded(some: &[f64]) -> Reals {
    padded_by(some, |x| *x)
}

/// Packs a number of up to [`LANES`] values into one group; that of the last value fills the rest.
pub(super) fn padded_by<T>(some: &[T], number: impl Fn(&T) -> f64) -> Reals {
    Reals::from(std::array::from_fn::<_, LANES, _>(|lane| number(&some[lane.min(some.len() - 1)])))
}

/// Packs frequencies into up to [`ABREAST`] groups. Returns the groups and their number; the last frequency
/// fills the last group.
pub(super) fn grouped(omega_rad_s: &[f64]) -> ([Reals; ABREAST], usize) {
    let abreast = omega_rad_s.len().div_ceil(LANES);
    let group = |w: usize| {
        if w < abreast {
            padded(&omega_rad_s[w * LANES..omega_rad_s.len().min((w + 1) * LANES)])
        } else {
            Reals::ONE
        }
    };
    (std::array::from_fn(group), abreast)
}

/// A SIMD group of complex numbers.
#[derive(Debug, Clone, Copy)]
pub struct Complexes {
    /// Real parts.
    pub re: Reals,
    /// Imaginary parts.
    pub im: Reals,
}

impl Complexes {
    /// Zeros.
    pub const ZERO: Complexes = Complexes { re: Reals::ZERO, im: Reals::ZERO };

    /// Combines real and imaginary parts.
    pub fn new(re: Reals, im: Reals) -> Self {
        Complexes { re, im }
    }

    /// Real numbers as complex ones.
    pub fn real(re: Reals) -> Self {
        Complexes { re, im: Reals::ZERO }
    }

    /// Repeats a number in every lane.
    pub fn splat(z: Complex64) -> Self {
        Complexes { re: Reals::splat(z.re), im: Reals::splat(z.im) }
    }

    /// Computes one number for each lane.
    pub fn each(of: impl Fn(usize) -> Complex64) -> Self {
        let z: [Complex64; LANES] = std::array::from_fn(of);
        Complexes { re: Reals::from(z.map(|z| z.re)), im: Reals::from(z.map(|z| z.im)) }
    }

    /// Returns the number of each lane.
    pub fn lanes(self) -> [Complex64; LANES] {
        let (re, im) = (self.re.to_array(), self.im.to_array());
        std::array::from_fn(|lane| Complex64::new(re[lane], im[lane]))
    }

    /// Computes |z|².
    pub fn norm_sqr(self) -> Reals {
        self.re * self.re + self.im * self.im
    }

    /// Computes the real part of z·conj a.
    #[inline(always)]
    pub fn dot(self, a: Self) -> Reals {
        self.re.mul_add(a.re, self.im * a.im)
    }

    /// Computes z·a + b.
    #[inline(always)]
    pub fn mul_add(self, a: Self, b: Self) -> Self {
        Complexes {
            re: self.re.mul_add(a.re, self.im.mul_neg_add(a.im, b.re)),
            im: self.re.mul_add(a.im, self.im.mul_add(a.re, b.im)),
        }
    }

    /// Computes 1/z.
    #[inline]
    pub fn inverse(self) -> Self {
        Scalar::inverse(self)
    }

    /// Computes the complex conjugate.
    #[inline]
    pub fn conj(self) -> Self {
        Complexes { re: self.re, im: -self.im }
    }

    /// Computes ln z with an imaginary part between −π and π.
    #[inline]
    pub fn ln(self) -> Self {
        Complexes { re: self.norm_sqr().ln() * Reals::splat(0.5), im: self.im.atan2(self.re) }
    }

    /// Computes √z with a non-negative real part, without angles.
    pub fn sqrt(self) -> Self {
        let re = ((self.norm_sqr().sqrt() + self.re.abs()) * Reals::splat(0.5)).sqrt();
        let im = re.simd_gt(Reals::ZERO).select(self.im * Reals::splat(0.5) / re, Reals::ZERO);
        let negative = self.re.is_sign_negative();
        let signed = self.im.is_sign_negative().select(-re, re);
        Complexes::new(negative.select(im.abs(), re), negative.select(signed, im))
    }

    /// Computes sin z and cos z.
    pub fn sin_cos(self) -> (Self, Self) {
        let [[sin, cos]] = sin_cos([self.re]);
        let (sinh, cosh) = sinh_cosh(self.im);
        (Complexes::new(sin * cosh, cos * sinh), Complexes::new(cos * cosh, -(sin * sinh)))
    }

    /// Computes i·z.
    pub fn times_i(self) -> Self {
        Complexes { re: -self.im, im: self.re }
    }
}

/// Computes sin x and cos x of several groups at once. [`Reals::sin_cos`] is slower: it converts the quarter
/// turns to integers one by one on processors without integer vectors. The groups share the loads of the
/// coefficients.
///
/// # Source  Moshier's polynomials (Cephes, sin.c) at x less the nearest multiple of π/2, which is split into
///   the three parts of Cody and Waite
///   (1980).
#[inline(always)]
pub(super) fn sin_cos<const N: usize>(x: [Reals; N]) -> [[Reals; 2]; N] {
    if !x.iter().all(|x| x.abs().simd_lt(Reals::splat(LARGEST_REDUCED)).all()) {
        return x.map(|x| x.sin_cos().into());
    }
    let quarters = x.map(|x| (x * Reals::splat(std::f64::consts::FRAC_2_PI)).round_ties_even());
    let mut remainder = x;
    for part in HALF_PI_PARTS {
        remainder = std::array::from_fn(|n| quarters[n].mul_neg_add(Reals::splat(part), remainder[n]));
    }
    let square = remainder.map(|x| x * x);
    let series = |coefficients: [f64; 6]| {
        let mut sum = [Reals::splat(coefficients[0]); N];
        for c in &coefficients[1..] {
            sum = std::array::from_fn(|n| sum[n].mul_add(square[n], Reals::splat(*c)));
        }
        sum
    };
    let (sin, cos) = (series(SIN), series(COS));
    std::array::from_fn(|n| {
        let sin = (sin[n] * square[n]).mul_add(remainder[n], remainder[n]);
        let cos = cos[n].mul_add(square[n] * square[n], square[n].mul_neg_add(Reals::splat(0.5), Reals::ONE));
        // In the second and the fourth quadrant sin and cos swap; sin is negative in the last two, cos in the
        // middle two.
        let halves = quarters[n] * Reals::splat(0.5);
        let whole = halves.floor();
        let swap = whole.simd_ne(halves);
        let late = (whole * Reals::splat(0.5)).floor().simd_ne(whole * Reals::splat(0.5));
        let minus = Reals::splat(-0.0);
        [swap.select(cos, sin) ^ (late & minus), swap.select(sin, cos) ^ ((late ^ swap) & minus)]
    })
}

/// Largest |x| whose argument reduction by the parts of π/2 is exact.
const LARGEST_REDUCED: f64 = 1e5;
/// π/2 in three parts, of which the first two have 33 bits.
const HALF_PI_PARTS: [f64; 3] =
    [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
/// Coefficients of x¹³, x¹¹, … x³ in sin x.
const SIN: [f64; 6] = [
    1.589_623_015_765_465_7e-10,
    -2.505_074_776_285_780_7e-8,
    2.755_731_362_138_572_5e-6,
    -1.984_126_982_958_954e-4,
    8.333_333_333_322_118e-3,
    -0.166_666_666_666_666_3,
];
/// Coefficients of x¹⁴, x¹², … x⁴ in cos x.
const COS: [f64; 6] = [
    -1.135_853_652_138_768_2e-11,
    2.087_570_084_197_473e-9,
    -2.755_731_417_929_674e-7,
    2.480_158_728_885_170_5e-5,
    -1.388_888_888_887_305_6e-3,
    4.166_666_666_666_659e-2,
];

/// Computes sinh x and cosh x. Small x use the series of sinh, which keeps all digits.
fn sinh_cosh(x: Reals) -> (Reals, Reals) {
    let size = x.abs();
    let exp = size.exp();
    let inverse_exp = Reals::ONE / exp;
    let square = x * x;
    let series = SINH.iter().fold(Reals::ZERO, |sum, c| sum.mul_add(square, Reals::splat(*c))) * x;
    let far = (exp - inverse_exp) * Reals::splat(0.5);
    let sinh = size.simd_lt(Reals::splat(0.3)).select(series, x.is_sign_negative().select(-far, far));
    (sinh, (exp + inverse_exp) * Reals::splat(0.5))
}

/// 1/11!, 1/9!, … 1. The truncation error is below 1e-16 of sinh x for |x| < 0.3.
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
    fn sub_mul(self, a: Self, b: Self) -> Self {
        a.mul_neg_add(b, self)
    }
}

impl Scalar for Complexes {
    const ZERO: Self = Complexes::ZERO;

    #[inline(always)]
    fn sub_mul(self, a: Self, b: Self) -> Self {
        Complexes {
            re: a.im.mul_add(b.im, a.re.mul_neg_add(b.re, self.re)),
            im: a.im.mul_neg_add(b.re, a.re.mul_neg_add(b.im, self.im)),
        }
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        let scale = Reals::ONE / self.norm_sqr();
        Complexes { re: self.re * scale, im: -(self.im * scale) }
    }

    #[inline(always)]
    fn inverse_real(self) -> Self {
        Complexes { re: Reals::ONE / self.re, ..self }
    }

    #[inline(always)]
    fn mul_real(self, a: Self) -> Self {
        self * a.re
    }

    #[inline(always)]
    fn sub_mul_real(self, a: Self, b: Self) -> Self {
        Complexes { re: a.re.mul_neg_add(b.re, self.re), im: a.im.mul_neg_add(b.re, self.im) }
    }

    #[inline(always)]
    fn sub_mul_reals(self, a: Self, b: Self) -> Self {
        Complexes { re: a.re.mul_neg_add(b.re, self.re), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Arguments near multiples of π/2, far from 0, and beyond the limit of the reduction; NaN and infinity.
    #[test]
    fn limit_vector_sines_equal_scalar_sines() {
        let near = |x: f64, a: f64, b: f64| {
            assert!((a - b).abs() <= 2e-16 + 3e-16 * b.abs() || a.is_nan() && b.is_nan(), "{x}: {a} {b}")
        };
        let quarters = (-70_000..70_000).step_by(97).map(|n| f64::from(n) * std::f64::consts::FRAC_PI_2);
        let arguments = quarters.flat_map(|x| [-0.78, -1e-3, -1e-9, 0.0, 1e-9, 0.3, 0.7].map(|d| x + d));
        for x in arguments.chain([1e-300, -0.0, 1e7, -1e12, f64::NAN, f64::INFINITY]) {
            let [[sin, cos], _] = sin_cos([Reals::from([x, -x, 0.5 * x, 2.0]), Reals::ONE]);
            for (lane, x) in [x, -x, 0.5 * x].into_iter().enumerate() {
                near(x, sin.to_array()[lane], x.sin());
                near(x, cos.to_array()[lane], x.cos());
            }
        }
        assert_eq!(sin_cos([Reals::splat(1e-300)])[0][0].to_array()[0], 1e-300);
    }

    #[test]
    fn limit_complex_square_roots_square_back() {
        for z in [(3.0, 4.0), (-3.0, 4.0), (-3.0, -4.0), (5.0, 0.0), (-5.0, 0.0), (0.0, 0.0), (0.0, -2.0)] {
            let root = Complexes::splat(Complex64::new(z.0, z.1)).sqrt().lanes()[0];
            assert!((root * root - Complex64::new(z.0, z.1)).norm() < 1e-14, "{z:?}: {root}");
        }
    }

    /// On both sides of the limit of the series, and with a dominant imaginary part.
    #[test]
    fn limit_complex_sines_equal_scalar_sines() {
        for re in [0.0, 1e-9, 0.7, std::f64::consts::PI, 9.0, 40.0] {
            for im in [0.0, 1e-12, -1e-4, 0.05, 0.299, -0.301, 1.5, -12.0] {
                let z = Complex64::new(re, im);
                let (sin, cos) = Complexes::splat(z).sin_cos();
                let near = |a: Complex64, b: Complex64| (a - b).norm() <= 4e-15 * b.norm() + 1e-24;
                assert!(
                    near(sin.lanes()[1], z.sin()) && near(cos.lanes()[2], z.cos()),
                    "{z}: {:?} {:?}",
                    sin.lanes()[1],
                    z.sin()
                );
            }
        }
    }
}
