//! Tolerances: the uncertainty of stated numbers that are not identified.
//!
//! A diameter, a mass or a nut's length is known to a standard deviation. Identification and diagnosis fit
//! such numbers as nuisance parameters, each with its prior. [`Machine::with_tolerances`] makes them
//! parameters of the machine.

mod guide;
mod held;
mod journal;
mod number;
mod nut;

pub use held::Estimate;

use self::number::{MARK, STOP, loss, relative, size, tolerance};
use super::error::fault;
use super::{
    Joint, Machine, MachineError, Mechanism, Parameter, Patch, PointMotion, Prior, Rescale, Role, Shaft,
    StationPlace, Target, TargetKind, Value,
};
use schemars::JsonSchema;
use serde::Deserialize;

/// Largest relative standard deviation: with a larger one the stated number would be meaningless.
const MOST: f64 = 0.15;

/// What a key of the section `[tolerance]` means.
struct Entry {
    key: &'static str,
    /// Value where the description states none.
    typical: f64,
    /// Largest value that is accepted.
    most: f64,
    /// Whether a machine has a quantity with this tolerance.
    applies: fn(&Machine) -> bool,
    value: fn(&Tolerance) -> f64,
}

/// Declares the tolerances, one a line: key, typical value, largest value, and which machines have a quantity
/// with it.
macro_rules! tolerances {
    ($($(#[doc = $doc:literal])+ $key:ident: $typical:literal, $most:expr, $applies:expr;)+) => {
        /// Uncertainty of a description: standard deviations, relative unless stated otherwise. A tolerance
        /// of 0 fixes its number.
        ///
        /// # Source  scatter of catalogues, drawings and weighing (largest deviation divided by about two):
        ///   effective diameter of a threaded shaft
        /// ±0.2 %, E ±0.3 %, G/E ±0.4 %, mass ±1 %, inertia of a rotor ±2 %. Shaft ends from journals of
        /// machined screws, 5 to 15 % thinner over 1 to 2.5 diameters: such an end lacks 0.35 ± 0.18
        /// diameters of its length. Loss factors of assembled joints 0.1 to 7 %: Beards, Structural
        /// Vibration, 1996, ch. 5. Dispersion between constant (microslip at one amplitude) and causal
        /// (Makris, J. Eng. Mech. 123 (1997) 1209–1214). Guides from 0 to 5 1/s: viscous friction over mass
        /// of an industrial linear axis 203.5 N·s/m / 95.1 kg = 2.1 1/s (Janot, Gautier and Brunot, EMPS
        /// benchmark, 2019), with a margin of about two.
        #[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
        #[serde(rename = "ToleranceFile", default, deny_unknown_fields)]
        #[schemars(description = "Standard deviations of stated numbers, relative unless stated otherwise. 0 fixes a number; an omitted key has the default in brackets.")]
        pub struct Tolerance {
            $($(#[doc = $doc])+ pub $key: f64,)+
        }

        impl Tolerance {
            /// All numbers as stated.
            pub const NONE: Tolerance = Tolerance { $($key: 0.0),+ };

            const ALL: &[Entry] = &[$(Entry {
                key: stringify!($key),
                typical: $typical,
                most: $most,
                applies: $applies,
                value: |of| of.$key,
            }),+];
        }

        impl Default for Tolerance {
            fn default() -> Self {
                Tolerance { $($key: $typical),+ }
            }
        }
    };
}

tolerances! {
    /// Effective diameter of each shaft (0.002).
    diameter: 0.002, MOST, Machine::has_shaft;
    /// Young's modulus of each shaft (0.003).
    youngs_modulus: 0.003, MOST, Machine::has_shaft;
    /// Ratio of shear modulus to Young's modulus of each shaft (0.004).
    shear_modulus: 0.004, MOST, |machine| machine.shafts.iter().any(Shaft::couples_motions);
    /// Missing section at each end of a shaft, as an equivalent length in diameters; its standard deviation
    /// is half of it (0.35).
    end_diameters: 0.35, 5.0, Machine::has_shaft;
    /// Length over which a nut supports its screw, relative to the typical length (0.5).
    nut_length: 0.5, 2.0, |machine| machine.shafts.iter().any(|s| s.stations.iter().any(|t| t.place == StationPlace::Nut));
    /// The largest mass (0.01).
    mass: 0.01, MOST, |machine| machine.largest(PointMotion::Translation).is_some();
    /// The largest inertia (0.02).
    inertia: 0.02, MOST, |machine| machine.largest(PointMotion::Rotation).is_some();
    /// Median loss factor of joints that state none, not a standard deviation (0.01).
    loss_factor: 0.01, 0.3, Machine::has_losses;
    /// Standard deviation of ln(loss factor) (1: a factor of e).
    loss_spread: 1.0, 3.0, Machine::has_losses;
    /// Share of dispersion of loss factors, not a standard deviation: 0 constant, 1 causal (0.5).
    loss_dispersion: 0.5, 1.0, Machine::has_losses;
    /// Standard deviation of that share (0.3).
    loss_dispersion_sd: 0.3, 1.0, Machine::has_losses;
    /// Damping of a guide that the description lacks, over the moving mass, in 1/s: standard deviation of a
    /// half-normal distribution (2.5).
    guide_damping: 2.5, 100.0, |machine| guide::undescribed(machine).is_some();
}

impl Tolerance {
    /// Checks each number against its limits.
    ///
    /// # Errors  one is negative, above its limit or no number.
    pub fn check(&self) -> Result<(), MachineError> {
        for Entry { key, typical, most, value, .. } in Tolerance::ALL {
            let number = value(self);
            if !(0.0..=*most).contains(&number) {
                let remedy = format!(
                    "is {number}; write a number from 0 to {most} (typically {typical}), or leave it out"
                );
                return Err(fault(format!("tolerance.{key}"), remedy));
            }
        }
        Ok(())
    }
}

/// Median loss factor of the material of a shaft whose description states none.
///
/// # Source  structural steel 0.0002 to 0.003, including an allowance for the thread: Beards, Structural
///   Vibration, 1996, ch. 5.
const SHAFT_LOSS: f64 = 1e-3;
/// Median of a half-normal distribution of unit standard deviation (of the full normal).
const HALF_NORMAL_MEDIAN: f64 = 0.674_489_75;
/// Standard deviation of the integral rate (1/s) of a holding servo, which corresponds to integral times of
/// 20 to 100 ms.
const INTEGRAL_RATE: f64 = 10.0;

impl Parameter {
    /// Whether it is one of the tolerances of [`Machine::with_tolerances`].
    pub fn is_tolerance(&self) -> bool {
        self.role == Role::Tolerance
    }

    /// Returns the value from which a search starts: the stated one, or the median of a half-normal prior,
    /// whose stated value of 0 would hide it.
    pub fn search_start(&self) -> f64 {
        match self.prior {
            Some(Prior::Normal(sd)) if self.start <= self.lower => {
                (self.start + HALF_NORMAL_MEDIAN * sd).min(self.upper)
            }
            _ => self.start,
        }
    }

    /// Returns its name in documents: the id without the mark of a tolerance.
    pub fn name(&self) -> &str {
        if self.is_tolerance() { &self.id[MARK.len_utf8()..] } else { &self.id }
    }
}

impl Machine {
    /// Returns the machine with its tolerances appended as parameters, each with its prior.
    ///
    /// They are diameters and moduli of shafts, journals at their ends, the length of nuts at `nuts_m` (m),
    /// and the largest mass and inertia. Loss factors of joints and shafts, their dispersion, the integral
    /// action of a holding servo, and the damping of a guide that the description lacks follow. Tolerances of
    /// 0 are omitted: their numbers stay fixed; with [`Tolerance::NONE`] all do. Tolerances that are held at
    /// estimates keep the lengths of journals and nuts from which they were estimated.
    ///
    /// # Errors  none for a machine that was checked.
    pub fn with_tolerances(&self, nuts_m: &[f64]) -> Result<Machine, MachineError> {
        let known = self.tolerance;
        if !self.held.is_empty() {
            return Ok(self.with_held_released());
        }
        if known == Tolerance::NONE {
            return Ok(self.clone());
        }
        let mut patch = Patch::default();
        let mut add = |target: Target, rescale: Rescale, parameter: Parameter| {
            patch.rescales.push((target, rescale, parameter.id.clone()));
            patch.parameters.push(parameter);
        };
        for shaft in &self.shafts {
            let name = &shaft.name;
            let mut change = |target: Target, what: &str, sd: f64| {
                if sd > 0.0 {
                    add(target, Rescale::Relative, relative(format!("{what} of {name}"), sd));
                }
            };
            change(TargetKind::ShaftDiameter.of(name), "diameter", known.diameter);
            change(TargetKind::ShaftModulus.of(name), "Young's modulus", known.youngs_modulus);
            // Axial and torsional stiffness vary independently: Poisson's ratio varies, and a thread carries
            // tension and torsion differently.
            if shaft.couples_motions() {
                change(TargetKind::ShaftShearModulus.of(name), "shear modulus", known.shear_modulus);
            }
            if let Some(median) = self.loss_median(&shaft.loss_factor, SHAFT_LOSS) {
                let parameter = loss(format!("loss factor of {name}"), median, known.loss_spread);
                add(TargetKind::ShaftLossFactor.of(name), Rescale::Replace, parameter);
            }
        }
        // A controller has no hysteresis.
        let is_servo = |j: &Joint| self.is_servo(j);
        let is_spring = |j: &&Joint| j.on.len() > 1 || j.stiffness.depends_on().next().is_some();
        for joint in self.joints.iter().filter(is_spring).filter(|j| !is_servo(j)) {
            if let Some(median) = self.loss_median(&joint.loss_factor, known.loss_factor) {
                let parameter = loss(format!("loss factor of {}", joint.name), median, known.loss_spread);
                add(TargetKind::JointLossFactor.of(&joint.name), Rescale::Replace, parameter);
            }
        }
        let has_losses =
            self.joints.iter().any(|j| self.loss_median(&j.loss_factor, known.loss_factor).is_some());
        if known.loss_dispersion_sd > 0.0 && has_losses {
            let reach = STOP * known.loss_dispersion_sd;
            let prior = (known.loss_dispersion, Prior::Normal(known.loss_dispersion_sd));
            let range = [known.loss_dispersion - reach, known.loss_dispersion + reach];
            add(
                TargetKind::LossDispersion.of(""),
                Rescale::Replace,
                tolerance("dispersion of loss factors".into(), (Mechanism::Ratio, "1"), prior, range),
            );
        }
        // A holding servo also integrates; its position loop has a gain of 10 to 50 1/s.
        for joint in
            self.joints.iter().filter(|j| is_servo(j)).filter(|j| j.stiffness.depends_on().next().is_some())
        {
            let prior = (0.0, Prior::Normal(INTEGRAL_RATE));
            let rate = tolerance(
                format!("integral action of {}", joint.name),
                (Mechanism::Quantity(&["1/s"]), "1/s"),
                prior,
                [0.0, STOP * INTEGRAL_RATE],
            );
            add(TargetKind::JointIntegralRate.of(&joint.name), Rescale::Added, rate);
        }
        for (motion, what, sd) in [
            (PointMotion::Translation, "mass", known.mass),
            (PointMotion::Rotation, "inertia", known.inertia),
        ] {
            if let Some(point) = self.largest(motion).filter(|_| sd > 0.0) {
                let name = &self.points[point].name;
                add(
                    TargetKind::PointInertia.of(name),
                    Rescale::Relative,
                    relative(format!("{what} of {name}"), sd),
                );
            }
        }
        let mut machine = self.with(&patch)?;
        guide::damp_undescribed_guide(&mut machine);
        journal::split_off_journals(&mut machine, nuts_m);
        nut::distribute_nut_loads(&mut machine, nuts_m);
        Ok(machine)
    }

    /// Returns the median of a loss factor: the described or the typical one; `None` where it is fixed or a
    /// parameter.
    fn loss_median(&self, described: &Value, typical: f64) -> Option<f64> {
        let stated = described.described().filter(|_| described.modifiers.is_empty())?;
        let median = if stated > 0.0 { stated } else { typical };
        (median > 0.0 && self.tolerance.loss_spread > 0.0 && self.tolerance.loss_factor > 0.0)
            .then_some(median)
    }

    /// Returns the point with the largest inertia of a kind that the description states. What an effect adds,
    /// such as a bed, is none of it.
    pub(super) fn largest(&self, motion: PointMotion) -> Option<usize> {
        let size = |at: &usize| size(&self.points[*at].inertia, self);
        let is_own = |at: &usize| self.points[*at].motion == motion && self.points[*at].role != Role::Effect;
        let own = (0..self.points.len()).filter(|at| is_own(at) && size(at) > 0.0);
        own.max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// Returns the first of the chosen tolerance keys that has no effect in this machine.
    pub fn idle_tolerance(&self, chosen: impl Fn(&str) -> bool) -> Option<&'static str> {
        Tolerance::ALL.iter().find(|entry| chosen(entry.key) && !(entry.applies)(self)).map(|entry| entry.key)
    }

    fn has_shaft(&self) -> bool {
        !self.shafts.is_empty()
    }

    /// Whether it has parts with a loss factor.
    fn has_losses(&self) -> bool {
        !self.joints.is_empty() || self.has_shaft()
    }
}
