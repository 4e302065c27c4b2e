//! Rods in axial or torsional motion as chains of two-node elements with consistent mass.
//!
//! Inner nodes are eliminated exactly: a uniform stretch of 2^p equal elements by p doublings, unequal
//! elements one after another. The result is the finite-element rod between its two ends, not the closed form
//! of the continuum.

use num_complex::Complex64;

/// 2^doublings equal elements in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Stiffness of one element, E S / h or G J / h.
    pub stiffness: f64,
    /// Inertia of one element, ρ S h or ρ J h.
    pub inertia: f64,
    /// Binary logarithm of the number of elements.
    pub doublings: u32,
}

/// Symmetric dynamic stiffness between the two ends of a chain.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ends {
    /// start × start
    pub first: Complex64,
    /// start × end
    pub cross: Complex64,
    /// end × end
    pub last: Complex64,
}

impl Stretch {
    /// Computes the dynamic stiffness of the stretch; `s2` = s², `modulus` is the complex factor on the
    /// stiffness.
    ///
    /// ```text
    /// element   a = k + s² m/3,   b = −k + s² m/6
    /// doubling  a ← a − b²/(2a),  b ← −b²/(2a)
    /// ```
    fn ends(&self, s2: Complex64, modulus: Complex64) -> Ends {
        let elastic = modulus * self.stiffness;
        let inertia = s2 * self.inertia;
        let mut own = elastic + inertia / 3.0;
        let mut cross = inertia / 6.0 - elastic;
        for _ in 0..self.doublings {
            let passed = cross * cross / (own * 2.0);
            own -= passed;
            cross = -passed;
        }
        Ends { first: own, cross, last: own }
    }
}

/// A chain of stretches between two kept nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rod {
    /// Stretches from start to end; at least one.
    pub stretches: Vec<Stretch>,
}

impl Rod {
    /// Computes the dynamic stiffness between the two ends, with the inner nodes eliminated.
    pub fn ends(&self, s2: Complex64, modulus: Complex64) -> Ends {
        let mut parts = self.stretches.iter().map(|stretch| stretch.ends(s2, modulus));
        let mut whole = parts.next().unwrap_or_default();
        for next in parts {
            let inverse = (whole.last + next.first).inv();
            whole = Ends {
                first: whole.first - whole.cross * whole.cross * inverse,
                cross: -whole.cross * next.cross * inverse,
                last: next.last - next.cross * next.cross * inverse,
            };
        }
        whole
    }

    /// Returns the number of elements.
    #[cfg(test)]
    pub fn elements(&self) -> usize {
        self.stretches.iter().map(|stretch| 1usize << stretch.doublings).sum()
    }
}
