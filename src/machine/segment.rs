//! Screw segments: the part of a screw between a bearing and the nut, as a massless spring.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;

use super::Operating;
use super::schema::enum_without_descriptions;

/// The end of the screw from which a segment reaches to the nut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename = "EndFile", rename_all = "lowercase")]
#[schemars(transform = enum_without_descriptions)]
pub enum SegmentEnd {
    /// From the left (lower) end: its length is the nut position.
    #[default]
    Start,
    /// From the right (upper) end: its length is the screw length minus the nut position.
    End,
}

/// Torsional compliance of a segment: the nut travels as the screw twists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Shear modulus G (Pa).
    pub shear_modulus_pa: f64,
    /// Lead p (m per turn).
    pub lead_m: f64,
}

/// A massless segment of a screw between an end and the nut.
///
/// ```text
/// 1    l    l·(p/2π)²                          E·A    π·d²·E
/// ─ = ─── + ─────────     without twist    k = ─── = ───────        A = π·d²/4,  J = π·d⁴/32
/// k   E·A      G·J                              l       4·l
/// ```
///
/// # Units      d, l, p in m, k in N/m
/// # Limits     G → ∞ gives the segment without twist
/// # Source     Duan et al., Eq. 21 (K_sl); vertical feed system, Eq. 26 (with twist, the same after clearing
///   fractions) and 27.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Unique name.
    pub name: String,
    /// Load-carrying diameter d (m).
    pub diameter_m: f64,
    /// Young's modulus E (Pa).
    pub youngs_modulus_pa: f64,
    /// Length of the whole screw between its ends (m), which is the range of nut positions.
    pub length_m: f64,
    /// The end from which it reaches to the nut.
    pub from: SegmentEnd,
    /// Twist; `None` where it is negligible.
    pub twist: Option<Twist>,
}

impl Segment {
    /// Computes the stiffness (N/m) at the nut position, or at mid-stroke where none is given.
    pub fn stiffness_n_per_m(&self, operating: &Operating) -> f64 {
        let nut_m = operating.nut_m.unwrap_or(0.5 * self.length_m);
        let length_m = match self.from {
            SegmentEnd::Start => nut_m,
            SegmentEnd::End => self.length_m - nut_m,
        };
        let area_m2 = PI * self.diameter_m * self.diameter_m / 4.0;
        let stretch = 1.0 / (self.youngs_modulus_pa * area_m2);
        let twist = self.twist.map_or(0.0, |twist| {
            let polar_m4 = area_m2 * self.diameter_m * self.diameter_m / 8.0;
            let travel_m = twist.lead_m / (2.0 * PI);
            travel_m * travel_m / (twist.shear_modulus_pa * polar_m4)
        });
        1.0 / (length_m * (stretch + twist))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(from: SegmentEnd, twist: Option<Twist>) -> Segment {
        Segment {
            name: "s".into(),
            diameter_m: 0.0325,
            youngs_modulus_pa: 2.06e11,
            length_m: 1.2,
            from,
            twist,
        }
    }

    /// Eq. 26 and 27 of the vertical-axis paper, written out as printed.
    #[test]
    fn published_segment_with_and_without_twist() {
        let (d, e, g, p, z, l): (f64, f64, f64, f64, f64, f64) = (0.0325, 2.06e11, 7.9e10, 0.02, 0.35, 1.2);
        let printed = 4.0 * g * e * PI.powi(3) * d.powi(4)
            / (16.0 * g * PI * PI * d * d * (l - z) + 32.0 * p * p * e * (l - z));
        let at = Operating::at_nut(z);
        let upper =
            segment(SegmentEnd::End, Some(Twist { shear_modulus_pa: g, lead_m: p })).stiffness_n_per_m(&at);
        assert!((upper / printed - 1.0).abs() < 1e-12, "{upper:e} {printed:e}");
        let lower = segment(SegmentEnd::Start, None).stiffness_n_per_m(&at);
        assert!((lower / (PI * d * d * e / (4.0 * z)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn limit_a_rigid_twist_changes_nothing() {
        let at = Operating::at_nut(0.5);
        let rigid = segment(SegmentEnd::Start, Some(Twist { shear_modulus_pa: 1e30, lead_m: 0.02 }));
        let (a, b) = (rigid.stiffness_n_per_m(&at), segment(SegmentEnd::Start, None).stiffness_n_per_m(&at));
        assert!((a / b - 1.0).abs() < 1e-12);
    }
}
