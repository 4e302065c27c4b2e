//! Effects as numbers of the axis and its drive.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::kind::Effect as Kind;
use crate::draw::Draw;
use crate::motion::catalogue::{Use, stiffness_for, waves};
use crate::motion::plant::{Growth, Lump, Outside, Wave};
use crate::motion::run::Machine;

/// An effect of a size; 1 is what an axis may well have.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Kind.
    pub kind: Kind,
    /// Size.
    pub size: f64,
    /// Numbers in 0 … 1 that shape it.
    shape: [f64; 3],
    /// What is drawn anew for it: curves, lumps.
    seed: u64,
    sign: f64,
}

impl Effect {
    /// One of size 1.
    pub fn drawn(kind: Kind, draw: &mut Draw) -> Self {
        let shape = std::array::from_fn(|_| draw.unit());
        Self { kind, size: 1.0, shape, seed: (draw.unit() * 1e15) as u64, sign: draw.sign() }
    }

    /// The same of another size.
    pub fn sized(&self, size: f64) -> Self {
        Self { size, ..self.clone() }
    }

    fn scaled(&self, index: usize, low: f64, high: f64) -> f64 {
        low + (high - low) * self.shape[index]
    }

    /// Puts the effect into a machine. Forces are set beside the one that accelerates the whole mass.
    pub fn put_into(&self, machine: &mut Machine, usage: &Use) {
        let size = self.size;
        let mut draw = Draw::new(self.seed);
        let push_n = machine.axis.moving_mass_kg() * usage.acceleration_m_s2;
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
                axis.bearing.viscous_n_s_m += 0.06 * size * push_n / usage.speed_m_s;
                axis.guide.viscous_n_s_m += 0.09 * size * push_n / usage.speed_m_s;
            }
            Kind::StribeckFriction => {
                axis.guide.rise += 0.6 * size;
                axis.guide.fall_m_s = self.scaled(0, 0.03, 0.12) * usage.speed_m_s;
            }
            Kind::FrictionAsymmetry => {
                axis.guide.lean[1] += 0.24 * size * self.sign;
                axis.guide.lean[0] += 0.05 * size * self.sign * self.scaled(0, -1.0, 1.0);
            }
            Kind::PreslidingFriction => {
                let reach = self.scaled(0, 0.8, 1.3) * 4e-5 * size;
                axis.guide.presliding_m += reach;
                axis.bearing.presliding_m += 0.3 * reach;
            }
            Kind::PositionFriction => axis.guide.along.extend(waves(0.15 * size, usage.stroke_m, 4, &mut draw)),
            Kind::LoadFriction => axis.guide.of_load += 0.04 * size,
            Kind::Backlash => {
                axis.nut.gap_m += 1.5e-5 * size;
                axis.nut.edge_m = axis.nut.gap_m / 30.0;
            }
            Kind::DriveFlexibility => {
                let frequency_hz = 75.0 / size.sqrt();
                let stiff = axis.coupling.stiffness_n_m;
                let soft = stiffness_for(axis.masses_kg, frequency_hz);
                // In series with what is there: size 0 changes nothing.
                axis.coupling.stiffness_n_m = stiff * soft / (stiff + soft);
                axis.coupling.damping_n_s_m = axis.coupling.stiffness_n_m * 2.0 * self.scaled(0, 0.03, 0.1) / (TAU * frequency_hz);
            }
            Kind::ControlDelay => {
                machine.drive.dead_time_s += 5e-4 * size;
                machine.axis.scale_late_s += 5e-4 * size;
            }
            Kind::ForceGain => machine.drive.strength *= 1.0 + 0.05 * size * self.sign,
            Kind::TorqueRipple => {
                for (order, part) in [(1.0, 0.5), (2.0, 0.35), (6.0, 0.6)] {
                    let phase_rad = draw.within(PI);
                    let per_m = order / self.lead_m();
                    axis.cogging.push(Wave { amplitude: 0.03 * size * part * push_n, per_m, phase_rad });
                    axis.ripple.push(Wave { amplitude: 0.01 * size * part, per_m, phase_rad: phase_rad + 1.0 });
                }
            }
            Kind::LeadError => {
                axis.pitch.extend(waves(4e-6 * size, usage.stroke_m, 3, &mut draw));
                for (order, part) in [(1.0, 1.0), (2.0, 0.3)] {
                    axis.pitch.push(Wave { amplitude: 2e-6 * size * part, per_m: order / self.lead_m(), phase_rad: draw.within(PI) });
                }
            }
            Kind::LeadGrowth => {
                let (fixed_m, time_s) = (-self.scaled(0, 0.05, 0.3), self.scaled(1, 60.0, 400.0));
                axis.growth = Growth { strain: 6e-5 * size, time_s, begun_s: time_s, fixed_m };
            }
            Kind::MovingMass => axis.masses_kg[2] = (axis.masses_kg[2] + 0.05 * size * self.sign * mass_kg).max(0.3 * axis.masses_kg[2]),
            Kind::CableChain
            | Kind::LoadPendulum
            | Kind::GreaseLumps
            | Kind::ScaleCogging
            | Kind::AmplifierDeadZone
            | Kind::RunningIn
            | Kind::WiperCreep => axis.outside.extend(self.outside(usage, mass_kg, dry_n, &mut draw)),
        }
    }

    /// Lead of the screw over whose turns waves repeat.
    fn lead_m(&self) -> f64 {
        [0.005, 0.01, 0.016, 0.02][(self.shape[0] * 4.0) as usize % 4]
    }

    /// What acts on the axis from outside every list, of an effect that does.
    fn outside(&self, usage: &Use, mass_kg: f64, dry_n: f64, draw: &mut Draw) -> Option<Outside> {
        let size = self.size;
        Some(match self.kind {
            Kind::CableChain => Outside::CableChain {
                force_n: 0.4 * size * dry_n * self.sign,
                at_m: self.scaled(0, 0.3, 0.7) * usage.stroke_m,
                width_m: self.scaled(1, 0.1, 0.35) * usage.stroke_m,
            },
            Kind::LoadPendulum => Outside::Pendulum {
                mass_kg: 0.05 * size * mass_kg,
                omega_rad_s: TAU * self.scaled(0, 3.0, 12.0),
                ratio: self.scaled(1, 0.02, 0.08),
            },
            Kind::GreaseLumps => {
                let mut lump = || Lump {
                    at_m: draw.between(0.05, 0.95) * usage.stroke_m,
                    width_m: draw.between(0.02, 0.06) * usage.stroke_m,
                    force_n: 0.5 * size * dry_n * draw.between(0.5, 1.0),
                };
                Outside::Grease { lumps: (0..4).map(|_| lump()).collect(), left: self.scaled(0, 0.6, 0.9) }
            }
            Kind::ScaleCogging => Outside::ScaleCogging { amplitude_m: 8e-7 * size, period_m: self.scaled(0, 4e-4, 2e-3) },
            Kind::AmplifierDeadZone => Outside::DeadZone { force_n: 0.15 * size * dry_n },
            Kind::RunningIn => Outside::RunningIn { rise: 0.3 * size, time_s: self.scaled(0, 0.8, 3.0) },
            Kind::WiperCreep => Outside::WiperCreep { stiffness_n_m: 8.0 * size * dry_n, time_s: self.scaled(0, 0.05, 0.4) },
            _ => return None,
        })
    }

    /// Its physical values: what it changes, by name.
    pub fn values(&self, machine: &Machine, usage: &Use) -> BTreeMap<String, f64> {
        let mut with = machine.clone();
        self.put_into(&mut with, usage);
        let (old, new) = (&machine.axis, &with.axis);
        let pairs = [
            ("coulomb_n", old.bearing.coulomb_n + old.guide.coulomb_n, new.bearing.coulomb_n + new.guide.coulomb_n),
            ("viscous_n_s_m", old.bearing.viscous_n_s_m + old.guide.viscous_n_s_m, new.bearing.viscous_n_s_m + new.guide.viscous_n_s_m),
            ("rise", old.guide.rise, new.guide.rise),
            ("fall_m_s", old.guide.fall_m_s, new.guide.fall_m_s),
            ("lean_dry", old.guide.lean[0], new.guide.lean[0]),
            ("lean_viscous", old.guide.lean[1], new.guide.lean[1]),
            ("presliding_m", old.guide.presliding_m, new.guide.presliding_m),
            ("of_load", old.guide.of_load, new.guide.of_load),
            ("gap_m", old.nut.gap_m, new.nut.gap_m),
            ("coupling_stiffness_n_m", old.coupling.stiffness_n_m, new.coupling.stiffness_n_m),
            ("dead_time_s", machine.drive.dead_time_s, with.drive.dead_time_s),
            ("strength", machine.drive.strength, with.drive.strength),
            ("growth_strain", old.growth.strain, new.growth.strain),
            ("moving_mass_kg", old.moving_mass_kg(), new.moving_mass_kg()),
        ];
        let mut out: BTreeMap<String, f64> =
            pairs.into_iter().filter(|(_, before, after)| before != after).map(|(name, _, after)| (name.to_owned(), after)).collect();
        out.insert("size".to_owned(), self.size);
        out
    }
}
