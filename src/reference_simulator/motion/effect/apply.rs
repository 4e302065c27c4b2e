//! Effects as changes to the parameters of axis and drive.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::kind::Effect as Kind;
use crate::draw::Draw;
use crate::motion::catalogue::{MotionLimits, stiffness_for, waves};
use crate::motion::plant::{Lump, ThermalExpansion, UnlistedEffect, Wave};
use crate::motion::run::Machine;

/// An effect with a size; 1 is plausible for a real axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Kind.
    pub kind: Kind,
    /// Size.
    pub size: f64,
    /// Shape parameters in 0 … 1.
    shape: [f64; 3],
    /// Seed of the effect's own random curves and lumps.
    seed: u64,
    sign: f64,
}

impl Effect {
    /// Draws an effect of size 1.
    pub fn random(kind: Kind, draw: &mut Draw) -> Self {
        let shape = std::array::from_fn(|_| draw.unit());
        Self { kind, size: 1.0, shape, seed: (draw.unit() * 1e15) as u64, sign: draw.sign() }
    }

    /// Returns the same effect at another size.
    pub fn sized(&self, size: f64) -> Self {
        Self { size, ..self.clone() }
    }

    fn scaled(&self, index: usize, low: f64, high: f64) -> f64 {
        low + (high - low) * self.shape[index]
    }

    /// Applies the effect to a machine. Forces are relative to the force that accelerates the whole mass.
    pub fn apply_to(&self, machine: &mut Machine, limits: &MotionLimits) {
        let size = self.size;
        let mut draw = Draw::new(self.seed);
        let push_n = machine.axis.moving_mass_kg() * limits.acceleration_m_s2;
        let mass_kg = machine.axis.moving_mass_kg();
        let dry_n = machine.axis.bearing.coulomb_n + machine.axis.guide.coulomb_n;
        let dry_n = if dry_n > 0.0 { dry_n } else { 0.2 * push_n };
        let axis = &mut machine.axis;
        match self.kind {
            Kind::CoulombFriction => {
                axis.bearing.coulomb_n += 0.06 * size * push_n;
                axis.guide.coulomb_n += 0.12 * size * push_n;
            }
            Kind::ViscousFriction => {
                axis.bearing.viscous_n_s_m += 0.06 * size * push_n / limits.speed_m_s;
                axis.guide.viscous_n_s_m += 0.09 * size * push_n / limits.speed_m_s;
            }
            Kind::StribeckFriction => {
                axis.guide.excess += 0.6 * size;
                axis.guide.stribeck_m_s = self.scaled(0, 0.03, 0.12) * limits.speed_m_s;
            }
            Kind::FrictionAsymmetry => {
                axis.guide.asymmetry[1] += 0.24 * size * self.sign;
                axis.guide.asymmetry[0] += 0.05 * size * self.sign * self.scaled(0, -1.0, 1.0);
            }
            Kind::PreslidingFriction => {
                let reach = self.scaled(0, 0.8, 1.3) * 4e-5 * size;
                axis.guide.presliding_m += reach;
                axis.bearing.presliding_m += 0.3 * reach;
            }
            Kind::PositionFriction => {
                axis.guide.position_waves.extend(waves(0.15 * size, limits.stroke_m, 4, &mut draw))
            }
            Kind::LoadFriction => axis.guide.load_coefficient += 0.04 * size,
            Kind::Backlash => {
                axis.nut.backlash_m += 1.5e-5 * size;
                axis.nut.edge_m = axis.nut.backlash_m / 30.0;
            }
            Kind::DriveFlexibility => {
                let frequency_hz = 75.0 / size.sqrt();
                let stiff = axis.coupling.stiffness_n_m;
                let soft = stiffness_for(axis.masses_kg, frequency_hz);
                // In series with the existing compliance: size 0 changes nothing.
                axis.coupling.stiffness_n_m = stiff * soft / (stiff + soft);
                axis.coupling.damping_n_s_m =
                    axis.coupling.stiffness_n_m * 2.0 * self.scaled(0, 0.03, 0.1) / (TAU * frequency_hz);
            }
            Kind::ControlDelay => {
                machine.drive.dead_time_s += 5e-4 * size;
                machine.axis.scale_delay_s += 5e-4 * size;
            }
            Kind::ForceGain => machine.drive.force_gain *= 1.0 + 0.05 * size * self.sign,
            Kind::TorqueRipple => {
                for (order, part) in [(1.0, 0.5), (2.0, 0.35), (6.0, 0.6)] {
                    let phase_rad = draw.within(PI);
                    let per_m = order / self.lead_m();
                    axis.cogging.push(Wave { amplitude: 0.03 * size * part * push_n, per_m, phase_rad });
                    axis.ripple.push(Wave {
                        amplitude: 0.01 * size * part,
                        per_m,
                        phase_rad: phase_rad + 1.0,
                    });
                }
            }
            Kind::LeadError => {
                axis.pitch.extend(waves(4e-6 * size, limits.stroke_m, 3, &mut draw));
                for (order, part) in [(1.0, 1.0), (2.0, 0.3)] {
                    axis.pitch.push(Wave {
                        amplitude: 2e-6 * size * part,
                        per_m: order / self.lead_m(),
                        phase_rad: draw.within(PI),
                    });
                }
            }
            Kind::LeadGrowth => {
                let (fixed_m, time_s) = (-self.scaled(0, 0.05, 0.3), self.scaled(1, 60.0, 400.0));
                axis.thermal_expansion =
                    ThermalExpansion { strain: 6e-5 * size, time_s, elapsed_s: time_s, fixed_m };
            }
            Kind::MovingMass => {
                axis.masses_kg[2] =
                    (axis.masses_kg[2] + 0.05 * size * self.sign * mass_kg).max(0.3 * axis.masses_kg[2])
            }
            Kind::CableChain
            | Kind::LoadPendulum
            | Kind::GreaseLumps
            | Kind::ScaleCogging
            | Kind::AmplifierDeadZone
            | Kind::RunningIn
            | Kind::WiperCreep => axis.unlisted.extend(self.unlisted(limits, mass_kg, dry_n, &mut draw)),
        }
    }

    /// Returns the lead of the screw, m: the period of the waves per revolution.
    fn lead_m(&self) -> f64 {
        [0.005, 0.01, 0.016, 0.02][(self.shape[0] * 4.0) as usize % 4]
    }

    /// Returns the unlisted effect of an unlisted kind.
    fn unlisted(
        &self,
        limits: &MotionLimits,
        mass_kg: f64,
        dry_n: f64,
        draw: &mut Draw,
    ) -> Option<UnlistedEffect> {
        let size = self.size;
        Some(match self.kind {
            Kind::CableChain => UnlistedEffect::CableChain {
                force_n: 0.4 * size * dry_n * self.sign,
                at_m: self.scaled(0, 0.3, 0.7) * limits.stroke_m,
                width_m: self.scaled(1, 0.1, 0.35) * limits.stroke_m,
            },
            Kind::LoadPendulum => UnlistedEffect::Pendulum {
                mass_kg: 0.05 * size * mass_kg,
                omega_rad_s: TAU * self.scaled(0, 3.0, 12.0),
                ratio: self.scaled(1, 0.02, 0.08),
            },
            Kind::GreaseLumps => {
                let mut lump = || Lump {
                    at_m: draw.between(0.05, 0.95) * limits.stroke_m,
                    width_m: draw.between(0.02, 0.06) * limits.stroke_m,
                    force_n: 0.5 * size * dry_n * draw.between(0.5, 1.0),
                };
                UnlistedEffect::Grease {
                    lumps: (0..4).map(|_| lump()).collect(),
                    left: self.scaled(0, 0.6, 0.9),
                }
            }
            Kind::ScaleCogging => UnlistedEffect::ScaleCogging {
                amplitude_m: 8e-7 * size,
                period_m: self.scaled(0, 4e-4, 2e-3),
            },
            Kind::AmplifierDeadZone => UnlistedEffect::DeadZone { force_n: 0.15 * size * dry_n },
            Kind::RunningIn => {
                UnlistedEffect::RunningIn { excess: 0.3 * size, time_s: self.scaled(0, 0.8, 3.0) }
            }
            Kind::WiperCreep => UnlistedEffect::WiperCreep {
                stiffness_n_m: 8.0 * size * dry_n,
                time_s: self.scaled(0, 0.05, 0.4),
            },
            _ => return None,
        })
    }

    /// Returns the physical values that the effect changes, by name.
    pub fn values(&self, machine: &Machine, limits: &MotionLimits) -> BTreeMap<String, f64> {
        let mut with = machine.clone();
        self.apply_to(&mut with, limits);
        let (old, new) = (&machine.axis, &with.axis);
        let pairs = [
            (
                "coulomb_n",
                old.bearing.coulomb_n + old.guide.coulomb_n,
                new.bearing.coulomb_n + new.guide.coulomb_n,
            ),
            (
                "viscous_n_s_m",
                old.bearing.viscous_n_s_m + old.guide.viscous_n_s_m,
                new.bearing.viscous_n_s_m + new.guide.viscous_n_s_m,
            ),
            ("rise", old.guide.excess, new.guide.excess),
            ("fall_m_s", old.guide.stribeck_m_s, new.guide.stribeck_m_s),
            ("lean_dry", old.guide.asymmetry[0], new.guide.asymmetry[0]),
            ("lean_viscous", old.guide.asymmetry[1], new.guide.asymmetry[1]),
            ("presliding_m", old.guide.presliding_m, new.guide.presliding_m),
            ("of_load", old.guide.load_coefficient, new.guide.load_coefficient),
            ("gap_m", old.nut.backlash_m, new.nut.backlash_m),
            ("coupling_stiffness_n_m", old.coupling.stiffness_n_m, new.coupling.stiffness_n_m),
            ("dead_time_s", machine.drive.dead_time_s, with.drive.dead_time_s),
            ("strength", machine.drive.force_gain, with.drive.force_gain),
            ("growth_strain", old.thermal_expansion.strain, new.thermal_expansion.strain),
            ("moving_mass_kg", old.moving_mass_kg(), new.moving_mass_kg()),
        ];
        let mut out: BTreeMap<String, f64> = pairs
            .into_iter()
            .filter(|(_, before, after)| before != after)
            .map(|(name, _, after)| (name.to_owned(), after))
            .collect();
        out.insert("size".to_owned(), self.size);
        out
    }
}
