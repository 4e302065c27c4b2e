//! Number types for the elimination.

use std::ops::Mul;

/// A number type for the elimination: real without damping, complex with damping.
pub trait Scalar: Copy + Mul<Output = Self> {
    /// Zero.
    const ZERO: Self;

    /// 1/x.
    fn inverse(self) -> Self;

    /// x − a·b.
    fn sub_mul(self, a: Self, b: Self) -> Self;

    /// 1/x of a real x.
    #[inline(always)]
    fn inverse_real(self) -> Self {
        self.inverse()
    }

    /// x·a for a real a.
    #[inline(always)]
    fn mul_real(self, a: Self) -> Self {
        self * a
    }

    /// x − a·b for a real b.
    #[inline(always)]
    fn sub_mul_real(self, a: Self, b: Self) -> Self {
        self.sub_mul(a, b)
    }

    /// x − a·b for real a and b.
    #[inline(always)]
    fn sub_mul_reals(self, a: Self, b: Self) -> Self {
        self.sub_mul(a, b)
    }
}
