//! Contact between screw and nut: flanks with rounded edges, linear without backlash.

/// Flanks of a nut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Stiffness of a flank, N/m.
    pub stiffness_n_m: f64,
    /// Dashpot of a flank in full contact, N·s/m.
    pub damping_n_s_m: f64,
    /// Backlash from flank to flank, m.
    pub backlash_m: f64,
    /// Distance over which a flank comes into contact, m.
    pub edge_m: f64,
}

impl Contact {
    /// Returns elastic force and damping at a relative displacement.
    ///
    /// The force is k ε ln[(1 + e^{(Δ−b/2)/ε}) / (1 + e^{−(Δ+b/2)/ε})]; the damping grows with the degree of
    /// contact of the flanks. Both are linear for b = 0.
    pub fn force(&self, shift_m: f64) -> (f64, f64) {
        if self.backlash_m == 0.0 {
            return (self.stiffness_n_m * shift_m, self.damping_n_s_m);
        }
        let (right, left) = (
            (shift_m - 0.5 * self.backlash_m) / self.edge_m,
            (-shift_m - 0.5 * self.backlash_m) / self.edge_m,
        );
        let soft = |u: f64| if u > 30.0 { u } else { u.exp().ln_1p() };
        let touch = |u: f64| 1.0 / (1.0 + (-u).exp());
        (
            self.stiffness_n_m * self.edge_m * (soft(right) - soft(left)),
            self.damping_n_s_m * (touch(right) + touch(left)),
        )
    }

    /// Returns the elastic energy at a relative displacement, by the trapezoidal rule from the middle of the
    /// backlash.
    #[cfg(test)]
    pub fn energy(&self, shift_m: f64) -> f64 {
        let parts = 2000;
        let step = shift_m / f64::from(parts);
        let inner: f64 = (1..parts).map(|k| self.force(step * f64::from(k)).0).sum();
        step * (inner + 0.5 * (self.force(0.0).0 + self.force(shift_m).0))
    }
}
