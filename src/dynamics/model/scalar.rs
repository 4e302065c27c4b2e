//! Numbers that can be eliminated.

use std::ops::Mul;

/// A number that can be eliminated: real without damping, complex with.
pub trait Scalar: Copy + Mul<Output = Self> {
    /// Nought.
    const ZERO: Self;

    /// 1/x.
    fn inverse(self) -> Self;

    /// x − a·b.
    fn less(self, a: Self, b: Self) -> Self;

    /// 1/x of a real x.
    #[inline(always)]
    fn inverse_real(self) -> Self {
        self.inverse()
    }

    /// x·a for a real a.
    #[inline(always)]
    fn times_real(self, a: Self) -> Self {
        self * a
    }

    /// x − a·b for a real b.
    #[inline(always)]
    fn less_real(self, a: Self, b: Self) -> Self {
        self.less(a, b)
    }

    /// x − a·b for real a and b.
    #[inline(always)]
    fn less_reals(self, a: Self, b: Self) -> Self {
        self.less(a, b)
    }
}
