//! Numbers of a machine as built.

use std::f64::consts::PI;

use crate::element::law::Law;

/// A screw end of smaller diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Journal {
    /// Diameter over the screw diameter.
    pub ratio: f64,
    /// Length including the taper towards the screw, m.
    pub length_m: f64,
}

impl Journal {
    /// No journal.
    pub const NONE: Self = Self { ratio: 1.0, length_m: 0.0 };
}

/// The screw shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screw {
    /// Distance between the bearings, m.
    pub length_m: f64,
    /// Effective outer diameter of the threaded part, m.
    pub diameter_m: f64,
    /// Diameter of the through bore, m.
    pub bore_m: f64,
    /// E
    pub youngs_modulus_pa: f64,
    /// G
    pub shear_modulus_pa: f64,
    /// ρ
    pub density_kg_m3: f64,
    /// Material loss factor.
    pub loss: f64,
    /// End at the drive.
    pub left: Journal,
    /// Far end.
    pub right: Journal,
    /// Least number of elements over the whole length.
    pub elements: usize,
}

impl Screw {
    /// Returns the outer diameter at distance x from the left bearing: constant over 70 % of a journal, then
    /// a taper.
    pub fn diameter_at(&self, x_m: f64) -> f64 {
        let near = |journal: &Journal, distance: f64| {
            if distance >= journal.length_m {
                return 1.0;
            }
            let along = distance / journal.length_m;
            if along <= 0.7 {
                journal.ratio
            } else {
                journal.ratio + (1.0 - journal.ratio) * (along - 0.7) / 0.3
            }
        };
        self.diameter_m * near(&self.left, x_m).min(near(&self.right, self.length_m - x_m))
    }

    /// Returns the cross section at an outer diameter.
    pub fn area(&self, diameter_m: f64) -> f64 {
        PI / 4.0 * (diameter_m.powi(2) - self.bore_m.powi(2))
    }

    /// Returns the polar second moment of area at an outer diameter.
    pub fn polar(&self, diameter_m: f64) -> f64 {
        PI / 32.0 * (diameter_m.powi(4) - self.bore_m.powi(4))
    }

    /// Returns the polar inertia of a shaft of full diameter.
    pub fn polar_inertia(&self) -> f64 {
        self.density_kg_m3 * self.polar(self.diameter_m) * self.length_m
    }
}

/// A joint: spring, dashpot and loss factor in parallel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joint {
    /// k
    pub stiffness: f64,
    /// c
    pub damping: f64,
    /// η
    pub loss: f64,
}

impl Joint {
    /// Returns the law of a branch that carries `share` of the joint.
    pub fn law(&self, share: f64) -> Law {
        Law::Kelvin { stiffness: self.stiffness * share, damping: self.damping * share, loss: self.loss }
    }
}

/// The nut. Its contacts with the screw are distributed over its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nut {
    /// All contacts together.
    pub joint: Joint,
    /// Number of contacts.
    pub contacts: usize,
    /// Distance between the outermost contacts, m.
    pub length_m: f64,
    /// Load of the last contact over the mean, minus 1; the shares change linearly along the nut.
    pub skew: f64,
    /// Mass on the screw at the nut.
    pub screw_mass_kg: f64,
    /// Inertia on the screw at the nut.
    pub screw_inertia_kg_m2: f64,
}

impl Nut {
    /// Returns the offset from the nut's middle (m) and the share of each contact.
    pub fn shares(&self) -> Vec<(f64, f64)> {
        if self.contacts < 2 {
            return vec![(0.0, 1.0)];
        }
        let last = (self.contacts - 1) as f64;
        (0..self.contacts)
            .map(|contact| {
                let along = 2.0 * contact as f64 / last - 1.0;
                (0.5 * self.length_m * along, (1.0 + self.skew * along) / self.contacts as f64)
            })
            .collect()
    }
}

/// Impedance by which the drive holds the rotor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hold {
    /// k
    pub stiffness: f64,
    /// c
    pub damping: f64,
    /// k_i, gain of the integral action.
    pub integral: f64,
    /// Lag of the drive, s.
    pub lag_s: f64,
}

/// A ball-screw feed drive as built.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// The screw.
    pub screw: Screw,
    /// Lead, m per turn.
    pub lead_m: f64,
    /// The nut.
    pub nut: Nut,
    /// Bearing at the drive.
    pub bearing_left: Joint,
    /// Bearing at the far end.
    pub bearing_right: Joint,
    /// Coupling between rotor and screw.
    pub coupling: Joint,
    /// Impedance that holds the rotor while the drive is on.
    pub hold: Option<Hold>,
    /// Mass of the worktable with its load.
    pub table_mass_kg: f64,
    /// Rotor of the motor.
    pub rotor_inertia_kg_m2: f64,
    /// Inertia at the screw's driven end.
    pub hub_inertia_kg_m2: f64,
    /// Viscous damping of the table's guide, N·s/m.
    pub guide_damping_ns_per_m: f64,
    /// Stiffness of the table's guide or counterbalance along the travel, N/m.
    pub guide_stiffness_n_per_m: f64,
    /// Turns of the rotor for one turn of the screw: 1 with a coupling, the ratio of the pulleys with a belt.
    pub drive_ratio: f64,
    /// Share of dispersion of all losses.
    pub loss_dispersion: f64,
}

impl Machine {
    /// Returns the travel for one radian, m.
    pub fn ratio_m(&self) -> f64 {
        self.lead_m / (2.0 * PI)
    }

    /// Returns a joint parameter by its name in machine descriptions.
    pub fn joint_mut(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "k_al" => &mut self.bearing_left.stiffness,
            "c_al" => &mut self.bearing_left.damping,
            "k_ar" => &mut self.bearing_right.stiffness,
            "c_ar" => &mut self.bearing_right.damping,
            "k_n" => &mut self.nut.joint.stiffness,
            "c_n" => &mut self.nut.joint.damping,
            "k_m" => &mut self.coupling.stiffness,
            "c_m" => &mut self.coupling.damping,
            "k_s" => &mut self.hold.as_mut()?.stiffness,
            "c_s" => &mut self.hold.as_mut()?.damping,
            "c_g" => &mut self.guide_damping_ns_per_m,
            _ => return None,
        })
    }
}
