//! Nuisance parameters: differences between a machine and its description that exist in every case and are no
//! effect.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_2_PI, PI};

use num_complex::Complex64;

use super::number::{Journal, Machine};
use super::point::{Channel, Point};
use crate::draw::Draw;
use crate::element::law::REFERENCE_RAD_S;

/// Standard deviations of the nuisance parameters that the description states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Of E and of G, relative.
    pub modulus: f64,
    /// Of masses and inertias, relative.
    pub mass: f64,
    /// Of nut positions (m).
    pub nut_m: f64,
    /// Of gains of channels, relative.
    pub gain: f64,
    /// Of delays of channels (s).
    pub delay_s: f64,
}

impl Spread {
    /// Standard deviations of the uniform distributions of [`Nuisance::random`].
    pub const UNIFORM: Self =
        Self { modulus: 0.0017, mass: 0.0029, nut_m: 2.9e-4, gain: 0.0023, delay_s: 0.87e-6 };
    /// Usual uncertainties of catalogues, scales and calibrations.
    pub const USUAL: Self = Self { modulus: 0.003, mass: 0.01, nut_m: 5e-4, gain: 0.004, delay_s: 2e-6 };

    /// Returns all standard deviations times a factor.
    pub fn times(self, factor: f64) -> Self {
        let Self { modulus, mass, nut_m, gain, delay_s } = self;
        Self {
            modulus: modulus * factor,
            mass: mass * factor,
            nut_m: nut_m * factor,
            gain: gain * factor,
            delay_s: delay_s * factor,
        }
    }
}

/// Number of the random branch for the dispersion of losses.
const DISPERSION: u64 = 0xd15;

/// Draws the share of dispersion of losses: 0, 1 or uniform between, equally often.
pub fn dispersion(draw: &mut Draw) -> f64 {
    match draw.index(3) {
        0 => 0.0,
        1 => 1.0,
        _ => draw.unit(),
    }
}

/// Sensor chain of a response against the force: a charge amplifier's high-pass and the resonance of the
/// sensor on its mount.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorChain {
    /// Corner frequency of the high-pass, Hz.
    pub corner_hz: f64,
    /// Resonance of the mounted sensor, Hz.
    pub mount_hz: f64,
}

impl SensorChain {
    /// Damping ratio of a sensor on wax or a stud.
    const MOUNT_DAMPING: f64 = 0.02;

    /// Returns recorded over true response at s.
    pub fn at(&self, s: Complex64) -> Complex64 {
        let tau = std::f64::consts::TAU;
        let along = s / (tau * self.mount_hz);
        s / (s + tau * self.corner_hz) / (along * along + along * (2.0 * Self::MOUNT_DAMPING) + 1.0)
    }
}

/// One random set of all nuisance parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Nuisance {
    /// Relative error of E.
    pub youngs: f64,
    /// Relative error of G.
    pub shear: f64,
    /// Relative error of the screw's effective diameter.
    pub diameter: f64,
    /// Material loss factor of the screw.
    pub screw_loss: f64,
    /// Loss factors of nut, left bearing, right bearing and coupling, in addition to their dashpots.
    pub joint_losses: [f64; 4],
    /// Share of dispersion of all losses, from 0 (constant stiffness) to 1 (causal).
    pub loss_dispersion: f64,
    /// Journal over screw diameter, left.
    pub left_ratio: f64,
    /// Journal over screw diameter, right.
    pub right_ratio: f64,
    /// Length of each journal over the screw length.
    pub journal_share: f64,
    /// Length of the nut in leads.
    pub turns: f64,
    /// Contacts of the nut.
    pub contacts: usize,
    /// Uneven load along the nut.
    pub skew: f64,
    /// Relative errors of table, rotor, hub, mass and inertia at the nut.
    pub masses: [f64; 5],
    /// Integral gain of the drive's hold over its stiffness, 1/s.
    pub integral_per_s: f64,
    /// Lag of the hold over the ratio of its damping to its stiffness; from 1 on the hold would feed energy
    /// into the motion.
    pub lag_share: f64,
    /// Damping of the guide that the description lacks, over the table mass, 1/s.
    pub guide_per_s: f64,
    /// Natural frequency of the table alone on the stiffness of guide, hoses or counterbalance, Hz.
    pub guide_hz: f64,
    /// Error of each nut position, m.
    pub offsets_m: Vec<f64>,
    /// Relative gain error and delay (s) of each channel.
    pub channels: BTreeMap<Channel, (f64, f64)>,
    /// Sensor chain of the responses; an ideal one if absent.
    pub sensor: Option<SensorChain>,
}

/// All channels that a test may contain; the first ones are those of [`ChannelSet`](crate::case::ChannelSet).
pub const CHANNELS: [Channel; 8] = [
    Channel { response: Point::Table, excitation: Point::Table },
    Channel { response: Point::Rotor, excitation: Point::Rotor },
    Channel { response: Point::Rotor, excitation: Point::Table },
    Channel { response: Point::Screw, excitation: Point::Table },
    Channel { response: Point::Left, excitation: Point::Table },
    Channel { response: Point::Right, excitation: Point::Table },
    Channel { response: Point::Table, excitation: Point::Rotor },
    Channel { response: Point::NutBody, excitation: Point::Table },
];

impl Nuisance {
    /// Returns the true values of the description's parameters with stiffnesses at 100 Hz, since losses disperse
    /// them, and with the damping of the hold that its lag τ leaves: (k + iωc)·e^(−iωτ) ≈ k + iω(c − kτ).
    pub fn effective(&self, mut joints: BTreeMap<String, f64>) -> BTreeMap<String, f64> {
        let causal = (200.0 * PI / REFERENCE_RAD_S).ln() * FRAC_2_PI * self.loss_dispersion;
        for (name, loss) in ["k_n", "k_al", "k_ar", "k_m"].into_iter().zip(self.joint_losses) {
            joints.entry(name.to_owned()).and_modify(|k| *k *= 1.0 + loss * causal);
        }
        if let (Some(stiffness), Some(damping)) = (joints.get("k_s").copied(), joints.get_mut("c_s")) {
            *damping -= stiffness * self.lag_s(stiffness, *damping);
        }
        joints
    }

    /// Returns the lag of a hold of some stiffness and damping, s.
    fn lag_s(&self, stiffness: f64, damping: f64) -> f64 {
        (self.lag_share * damping / stiffness).min(5e-5)
    }

    /// Returns no nuisance at all: the machine is as described, apart from its joint values.
    pub fn none(positions: usize) -> Self {
        Self {
            loss_dispersion: 1.0,
            left_ratio: 1.0,
            right_ratio: 1.0,
            contacts: 1,
            offsets_m: vec![0.0; positions],
            ..Self::default()
        }
    }

    /// Draws all nuisance parameters.
    pub fn random(positions: usize, draw: &mut Draw) -> Self {
        Self {
            youngs: draw.within(0.003),
            shear: draw.within(0.003),
            screw_loss: draw.log_between(3e-4, 3e-3),
            joint_losses: [draw.log_between(2e-3, 1.5e-2); 4],
            loss_dispersion: dispersion(&mut draw.branch(DISPERSION)),
            left_ratio: draw.between(0.85, 0.95),
            right_ratio: draw.between(0.85, 0.95),
            journal_share: draw.between(0.008, 0.022),
            turns: draw.between(2.0, 4.0),
            contacts: 3 + draw.index(3),
            skew: draw.within(0.3),
            masses: std::array::from_fn(|_| draw.within(0.005)),
            integral_per_s: draw.between(0.0, 2.0),
            lag_share: draw.between(0.0, 0.2),
            offsets_m: (0..positions).map(|_| draw.within(5e-4)).collect(),
            channels: CHANNELS
                .into_iter()
                .map(|channel| (channel, (draw.within(0.004), draw.within(1.5e-6))))
                .collect(),
            ..Self::default()
        }
    }

    /// Applies the nuisance parameters to a machine that equals its description apart from its joints.
    pub fn applied(&self, mut machine: Machine) -> Machine {
        machine.loss_dispersion = self.loss_dispersion;
        let screw = &mut machine.screw;
        screw.youngs_modulus_pa *= 1.0 + self.youngs;
        screw.shear_modulus_pa *= 1.0 + self.shear;
        screw.diameter_m *= 1.0 + self.diameter;
        screw.loss = self.screw_loss;
        let length_m = self.journal_share * screw.length_m;
        screw.left = Journal { ratio: self.left_ratio, length_m };
        screw.right = Journal { ratio: self.right_ratio, length_m };
        machine.nut.contacts = self.contacts;
        machine.nut.length_m = (self.turns * machine.lead_m).min(0.12 * machine.screw.length_m);
        machine.nut.skew = self.skew;
        let [nut, left, right, coupling] = self.joint_losses;
        machine.nut.joint.loss = nut;
        machine.bearing_left.loss = left;
        machine.bearing_right.loss = right;
        machine.coupling.loss = coupling;
        machine.table_mass_kg *= 1.0 + self.masses[0];
        machine.rotor_inertia_kg_m2 *= 1.0 + self.masses[1];
        machine.hub_inertia_kg_m2 *= 1.0 + self.masses[2];
        machine.nut.screw_mass_kg *= 1.0 + self.masses[3];
        machine.nut.screw_inertia_kg_m2 *= 1.0 + self.masses[4];
        machine.guide_damping_ns_per_m += self.guide_per_s * machine.table_mass_kg;
        machine.guide_stiffness_n_per_m +=
            (std::f64::consts::TAU * self.guide_hz).powi(2) * machine.table_mass_kg;
        if let Some(hold) = &mut machine.hold {
            hold.integral = self.integral_per_s * hold.stiffness;
            hold.lag_s = self.lag_s(hold.stiffness, hold.damping);
        }
        machine
    }

    /// Returns one copy for each nuisance parameter, changed by one standard deviation of its prior. A
    /// careful analysis marginalises these directions.
    pub fn directions(&self, channels: &[Channel]) -> Vec<Self> {
        let mut out = Vec::new();
        let mut moved = |change: &dyn Fn(&mut Self)| {
            let mut copy = self.clone();
            change(&mut copy);
            out.push(copy);
        };
        moved(&|n| n.youngs += Spread::UNIFORM.modulus);
        moved(&|n| n.shear += Spread::UNIFORM.modulus);
        moved(&|n| n.screw_loss += 7e-4);
        moved(&|n| n.joint_losses.iter_mut().for_each(|loss| *loss += 4e-3));
        moved(&|n| n.loss_dispersion += 0.3);
        moved(&|n| n.left_ratio -= 0.03);
        moved(&|n| n.right_ratio -= 0.03);
        moved(&|n| n.journal_share += 0.004);
        moved(&|n| n.turns += 0.6);
        moved(&|n| n.skew += 0.17);
        moved(&|n| n.integral_per_s += 0.6);
        moved(&|n| n.lag_share += 0.06);
        for index in 0..self.masses.len() {
            moved(&|n| n.masses[index] += Spread::UNIFORM.mass);
        }
        for index in 0..self.offsets_m.len() {
            moved(&|n| n.offsets_m[index] += Spread::UNIFORM.nut_m);
        }
        for channel in channels {
            moved(&|n| n.channels.entry(*channel).or_default().0 += Spread::UNIFORM.gain);
            moved(&|n| n.channels.entry(*channel).or_default().1 += Spread::UNIFORM.delay_s);
        }
        out
    }

    /// Returns the relative gain error and the delay (s) of a channel.
    pub fn channel(&self, channel: Channel) -> (f64, f64) {
        self.channels.get(&channel).copied().unwrap_or_default()
    }
}
