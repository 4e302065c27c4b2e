//! The ways in which a machine of a layout may differ from its description, and the coordinates in which a
//! fit follows them.

use super::catalogue::DrawnMachine;
use super::nuisance::{CHANNELS, Nuisance, SensorChain, dispersion};
use super::point::Channel;
use crate::draw::Draw;

/// Standard deviation of the effective diameter of a threaded shaft, relative: catalogues.
const DIAMETER_SD: f64 = 0.002;
/// Standard deviation of a rotor's inertia, relative: catalogues.
const INERTIA_SD: f64 = 0.02;
/// Median of a joint's loss factor, its limits, and the standard deviation of its logarithm: Beards,
/// Structural Vibration, 1996, ch. 5.
const LOSS: (f64, [f64; 2], f64) = (0.01, [1e-3, 0.07], 1.0);
/// Loss factors of toothed belts.
const BELT_LOSS: [f64; 2] = [0.02, 0.07];
/// Standard deviation of the share of dispersion of losses.
const DISPERSION_SD: f64 = 0.3;
/// Standard deviation of a journal's missing section, as an equivalent length in diameters.
const JOURNAL_SD: f64 = 0.175;
/// Standard deviation of the logarithm of a nut's length, and of the uneven load along it.
const NUT_SD: (f64, f64) = (0.5, 0.3);
/// Standard deviation of the integral rate of a servo that holds the rotor, 1/s.
const INTEGRAL_SD: f64 = 10.0;

impl Nuisance {
    /// Draws the nuisance parameters of a machine: normal numbers where its description states a standard
    /// deviation.
    ///
    /// A guide has a little stiffness, and a little damping where the description states none.
    pub fn of_layout(drawn: &DrawnMachine, draw: &mut Draw) -> Self {
        let description = &drawn.description;
        let spread = description.spread;
        let (holds, has_guide) = (description.holds_rotor, description.parameter("c_g").is_some());
        let is_belt = description.drive_ratio != 1.0;
        let loss = |draw: &mut Draw| (LOSS.0 * (LOSS.2 * draw.normal()).exp()).clamp(LOSS.1[0], LOSS.1[1]);
        let mut joint_losses: [f64; 4] = std::array::from_fn(|_| loss(draw));
        if is_belt {
            joint_losses[3] = draw.log_between(BELT_LOSS[0], BELT_LOSS[1]);
        }
        // A table on a spring alone would ring for minutes.
        let guide_hz = if holds { draw.log_between(0.2, 1.0) } else { 0.0 };
        let guide_per_s = if holds && !has_guide { draw.log_between(0.01, 0.1) } else { 0.0 };
        let diameters = description.diameter_m / description.length_m;
        Self {
            youngs: spread.modulus * draw.normal(),
            shear: spread.modulus * draw.normal(),
            diameter: DIAMETER_SD * draw.normal(),
            screw_loss: draw.log_between(3e-4, 3e-3),
            joint_losses,
            loss_dispersion: dispersion(draw),
            left_ratio: draw.between(0.85, 0.95),
            right_ratio: draw.between(0.85, 0.95),
            journal_share: (diameters * draw.between(1.0, 2.5)).min(0.09),
            turns: draw.between(2.0, 4.0),
            contacts: 3 + draw.index(3),
            skew: draw.within(0.3),
            masses: [spread.mass * draw.normal(), INERTIA_SD * draw.normal(), 0.0, 0.0, 0.0],
            integral_per_s: draw.between(0.0, 2.0),
            lag_share: draw.between(0.0, 0.2),
            guide_per_s,
            guide_hz,
            offsets_m: drawn.nut_m.iter().map(|_| spread.nut_m * draw.normal()).collect(),
            channels: CHANNELS
                .into_iter()
                .map(|channel| (channel, (spread.gain * draw.normal(), spread.delay_s * draw.normal())))
                .collect(),
            sensor: Some(SensorChain {
                corner_hz: draw.log_between(0.01, 0.08),
                mount_hz: drawn.band_hz * draw.log_between(12.0, 25.0),
            }),
        }
    }
}

/// A number that a careful analysis fits along, in units of the standard deviation of its prior. All priors
/// are normal and unbounded.
#[derive(Clone, Debug, PartialEq)]
pub enum Leeway {
    /// A joint parameter by name, logarithmic, with the standard deviation of its logarithm.
    Joint(String, f64),
    /// Young's modulus.
    Youngs,
    /// Shear modulus.
    Shear,
    /// Diameter of the screw.
    Diameter,
    /// Loss factor of the screw, logarithmic.
    ScrewLoss,
    /// Loss factor of a joint by its place in [`Nuisance::joint_losses`], logarithmic.
    JointLoss(usize),
    /// Share of dispersion.
    Dispersion,
    /// Journal at an end: left, right.
    Journal(usize),
    /// Length of the nut, logarithmic.
    NutLength,
    /// Uneven load along the nut.
    NutLoad,
    /// Mass of the table.
    TableMass,
    /// Inertia of the rotor.
    RotorInertia,
    /// Integral rate of the drive that holds the rotor.
    IntegralRate,
    /// A nut position by its number.
    Offset(usize),
    /// Gain of a channel.
    Gain(Channel),
    /// Delay of a channel.
    Delay(Channel),
}

impl Leeway {
    /// Returns all that may differ in a test: joints as wide as the ranges of the description (a quarter of
    /// ln(upper/lower)), its tolerances, and the test's own.
    pub fn all(
        drawn: &DrawnMachine,
        nuisance: &Nuisance,
        positions: &[usize],
        channels: &[Channel],
    ) -> Vec<Self> {
        let description = &drawn.description;
        let width = |name: &String| {
            description.parameter(name).map(|of| Self::Joint(name.clone(), 0.25 * (of.upper / of.lower).ln()))
        };
        let mut out: Vec<Self> = drawn.joints.keys().filter_map(width).collect();
        out.extend([
            Self::Youngs,
            Self::Shear,
            Self::Diameter,
            Self::ScrewLoss,
            Self::Dispersion,
            Self::NutLoad,
        ]);
        out.extend([Self::TableMass, Self::RotorInertia]);
        out.extend((0..4).filter(|joint| nuisance.joint_losses[*joint] > 0.0).map(Self::JointLoss));
        if nuisance.journal_share > 0.0 {
            out.extend([Self::Journal(0), Self::Journal(1)]);
        }
        if nuisance.turns > 0.0 {
            out.push(Self::NutLength);
        }
        if description.holds_rotor {
            out.push(Self::IntegralRate);
        }
        out.extend(positions.iter().map(|position| Self::Offset(*position)));
        out.extend(channels.iter().flat_map(|channel| [Self::Gain(*channel), Self::Delay(*channel)]));
        out
    }

    /// Changes a machine and its nuisance parameters by so many standard deviations.
    pub fn shift(&self, drawn: &mut DrawnMachine, nuisance: &mut Nuisance, by: f64) {
        let spread = drawn.description.spread;
        match self {
            Self::Joint(name, sd) => {
                drawn.joints.entry(name.clone()).and_modify(|value| *value *= (sd * by).exp());
            }
            Self::Youngs => nuisance.youngs += spread.modulus * by,
            Self::Shear => nuisance.shear += spread.modulus * by,
            Self::Diameter => nuisance.diameter += DIAMETER_SD * by,
            Self::ScrewLoss => nuisance.screw_loss *= (LOSS.2 * by).exp(),
            Self::JointLoss(joint) => nuisance.joint_losses[*joint] *= (LOSS.2 * by).exp(),
            Self::Dispersion => nuisance.loss_dispersion += DISPERSION_SD * by,
            Self::Journal(end) => {
                let description = &drawn.description;
                let length = nuisance.journal_share * description.length_m / description.diameter_m;
                let ratio = if *end == 0 { &mut nuisance.left_ratio } else { &mut nuisance.right_ratio };
                // The section lacks 1 − ratio² of its area over the length; its compliance counts, so the
                // ratio changes in its logarithm.
                *ratio *= (-0.5 * JOURNAL_SD / length * by).exp();
            }
            Self::NutLength => nuisance.turns *= (NUT_SD.0 * by).exp(),
            Self::NutLoad => nuisance.skew += NUT_SD.1 * by,
            Self::TableMass => nuisance.masses[0] += spread.mass * by,
            Self::RotorInertia => nuisance.masses[1] += INERTIA_SD * by,
            Self::IntegralRate => nuisance.integral_per_s += INTEGRAL_SD * by,
            Self::Offset(position) => nuisance.offsets_m[*position] += spread.nut_m * by,
            Self::Gain(channel) => nuisance.channels.entry(*channel).or_default().0 += spread.gain * by,
            Self::Delay(channel) => nuisance.channels.entry(*channel).or_default().1 += spread.delay_s * by,
        }
    }
}
