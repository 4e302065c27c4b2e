//! Tolerances: the uncertainty of stated numbers that are not identified.
//!
//! A diameter, a mass or a nut's length is known to a standard deviation. Identification and diagnosis fit such numbers as nuisance
//! parameters, each with its prior. [`Machine::with_tolerances`] makes them parameters of the machine.

mod guide;
mod held;
mod journal;
mod number;
mod nut;

use self::number::{MARK, STOP, loss, relative, size, tolerance};
use super::{Joint, Machine, MachineError, Mechanism, Parameter, Patch, PointMotion, Prior, Rescale, Role, Shaft, Target, Value};

/// Uncertainty of a description: standard deviations, relative unless stated otherwise. A tolerance of 0 fixes its number.
///
/// # Source  scatter of catalogues, drawings and weighing (largest deviation divided by about two): effective diameter of a threaded shaft
/// ±0.2 %, E ±0.3 %, G/E ±0.4 %, mass ±1 %, inertia of a rotor ±2 %. Shaft ends from journals of machined screws, 5 to 15 % thinner over 1
/// to 2.5 diameters: such an end lacks 0.35 ± 0.18 diameters of its length. Loss factors of assembled joints 0.1 to 7 %: Beards, Structural
/// Vibration, 1996, ch. 5. Dispersion between constant (microslip at one amplitude) and causal (Makris, J. Eng. Mech. 123 (1997)
/// 1209–1214). Guides from 0 to 5 1/s: viscous friction over mass of an industrial linear axis 203.5 N·s/m / 95.1 kg = 2.1 1/s (Janot,
/// Gautier and Brunot, EMPS benchmark, 2019), with a margin of about two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Effective diameter of each shaft.
    pub diameter: f64,
    /// Young's modulus of each shaft.
    pub youngs_modulus: f64,
    /// Ratio of shear modulus to Young's modulus of each shaft.
    pub shear_modulus: f64,
    /// Missing section at each end of a shaft, as an equivalent length in diameters; its standard deviation is half of it.
    pub end_diameters: f64,
    /// Length over which a nut supports its screw, relative to the typical length.
    pub nut_length: f64,
    /// The largest mass.
    pub mass: f64,
    /// The largest inertia.
    pub inertia: f64,
    /// Median loss factor of joints whose description states none; 0: only their dampers dissipate energy.
    pub loss_factor: f64,
    /// Standard deviation of ln(loss factor).
    pub loss_spread: f64,
    /// Share s of dispersion of loss factors, k·(1 + η·(i + s·2/π·ln(ω/ω₀))): 0 constant, 1 causal.
    pub loss_dispersion: f64,
    /// Standard deviation of s.
    pub loss_dispersion_sd: f64,
    /// Viscous damping (1/s) of the guide of the largest mass, over that mass, where the description states no joint between it and the ground: a
    /// half-normal distribution from 0 with this standard deviation.
    pub guide_damping: f64,
}

impl Tolerance {
    /// All numbers as stated.
    pub const NONE: Tolerance = Tolerance {
        diameter: 0.0,
        youngs_modulus: 0.0,
        shear_modulus: 0.0,
        end_diameters: 0.0,
        nut_length: 0.0,
        mass: 0.0,
        inertia: 0.0,
        loss_factor: 0.0,
        loss_spread: 0.0,
        loss_dispersion: 0.0,
        loss_dispersion_sd: 0.0,
        guide_damping: 0.0,
    };
}

impl Default for Tolerance {
    fn default() -> Self {
        Tolerance {
            diameter: 0.002,
            youngs_modulus: 0.003,
            shear_modulus: 0.004,
            end_diameters: 0.35,
            nut_length: 0.5,
            mass: 0.01,
            inertia: 0.02,
            loss_factor: 0.01,
            loss_spread: 1.0,
            loss_dispersion: 0.5,
            loss_dispersion_sd: 0.3,
            guide_damping: 2.5,
        }
    }
}

/// Median loss factor of the material of a shaft whose description states none.
///
/// # Source  structural steel 0.0002 to 0.003, including an allowance for the thread: Beards, Structural Vibration, 1996, ch. 5.
const SHAFT_LOSS: f64 = 1e-3;
/// Median of a half-normal distribution of unit standard deviation (of the full normal).
const HALF_NORMAL_MEDIAN: f64 = 0.674_489_75;
/// Standard deviation of the integral rate (1/s) of a holding servo, which corresponds to integral times of 20 to 100 ms.
const INTEGRAL_RATE: f64 = 10.0;

impl Parameter {
    /// Whether it is one of the tolerances of [`Machine::with_tolerances`].
    pub fn is_tolerance(&self) -> bool {
        self.role == Role::Tolerance
    }

    /// Returns the value from which a search starts: the stated one, or the median of a half-normal prior, whose stated value of 0 would hide it.
    pub fn search_start(&self) -> f64 {
        match self.prior {
            Some(Prior::Normal(sd)) if self.start <= self.lower => (self.start + HALF_NORMAL_MEDIAN * sd).min(self.upper),
            _ => self.start,
        }
    }

    /// Returns its name in documents: the id without the mark of a tolerance.
    pub fn name(&self) -> &str {
        if self.is_tolerance() { &self.id[MARK.len_utf8()..] } else { &self.id }
    }
}

impl Machine {
    /// Returns the machine without a tolerance of the damping of its guide, as a diagnosis takes it: there the effect «guide-viscous» competes with
    /// others.
    #[must_use]
    pub fn without_guide_tolerance(&self) -> Machine {
        Machine { tolerance: Tolerance { guide_damping: 0.0, ..self.tolerance }, ..self.clone() }
    }

    /// Returns the machine with its tolerances appended as parameters, each with its prior.
    ///
    /// They are diameters and moduli of shafts, journals at their ends, the length of nuts at `nuts_m` (m), and the largest mass and
    /// inertia. Loss factors of joints and shafts, their dispersion, the integral action of a holding servo, and the damping of a guide that the
    /// description lacks follow. Tolerances of 0 are omitted: their numbers stay fixed; with [`Tolerance::NONE`] all do.
    ///
    /// # Errors  none for a machine that was checked.
    pub fn with_tolerances(&self, nuts_m: &[f64]) -> Result<Machine, MachineError> {
        let known = self.tolerance;
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
            change(Target::ShaftDiameter(name.clone()), "diameter", known.diameter);
            change(Target::ShaftModulus(name.clone()), "Young's modulus", known.youngs_modulus);
            // Axial and torsional stiffness vary independently: Poisson's ratio varies, and a thread carries tension and torsion
            // differently.
            if shaft.stations.iter().any(|s| s.axial.is_some()) && shaft.stations.iter().any(|s| s.torsion.is_some()) {
                change(Target::ShaftShearModulus(name.clone()), "shear modulus", known.shear_modulus);
            }
            if let Some(median) = self.loss_median(&shaft.loss_factor, SHAFT_LOSS) {
                let parameter = loss(format!("loss factor of {name}"), median, known.loss_spread);
                add(Target::ShaftLossFactor(name.clone()), Rescale::Replace, parameter);
            }
        }
        // A controller has no hysteresis.
        let is_servo = |j: &Joint| self.is_servo(j);
        let is_spring = |j: &&Joint| j.on.len() > 1 || j.stiffness.depends_on().next().is_some();
        for joint in self.joints.iter().filter(is_spring).filter(|j| !is_servo(j)) {
            if let Some(median) = self.loss_median(&joint.loss_factor, known.loss_factor) {
                let parameter = loss(format!("loss factor of {}", joint.name), median, known.loss_spread);
                add(Target::JointLossFactor(joint.name.clone()), Rescale::Replace, parameter);
            }
        }
        let has_losses = self.joints.iter().any(|j| self.loss_median(&j.loss_factor, known.loss_factor).is_some());
        if known.loss_dispersion_sd > 0.0 && has_losses {
            let reach = STOP * known.loss_dispersion_sd;
            let prior = (known.loss_dispersion, Prior::Normal(known.loss_dispersion_sd));
            let range = [known.loss_dispersion - reach, known.loss_dispersion + reach];
            add(
                Target::LossDispersion,
                Rescale::Replace,
                tolerance("dispersion of loss factors".into(), (Mechanism::Ratio, "1"), prior, range),
            );
        }
        // A holding servo also integrates; its position loop has a gain of 10 to 50 1/s.
        for joint in self.joints.iter().filter(|j| is_servo(j)).filter(|j| j.stiffness.depends_on().next().is_some()) {
            let prior = (0.0, Prior::Normal(INTEGRAL_RATE));
            let rate = tolerance(
                format!("integral action of {}", joint.name),
                (Mechanism::Quantity(&["1/s"]), "1/s"),
                prior,
                [0.0, STOP * INTEGRAL_RATE],
            );
            add(Target::JointIntegralRate(joint.name.clone()), Rescale::Added, rate);
        }
        for (motion, what, sd) in [(PointMotion::Translation, "mass", known.mass), (PointMotion::Rotation, "inertia", known.inertia)] {
            if let Some(point) = self.largest(motion).filter(|_| sd > 0.0) {
                let name = &self.points[point].name;
                add(Target::PointInertia(name.clone()), Rescale::Relative, relative(format!("{what} of {name}"), sd));
            }
        }
        let mut machine = self.with(&patch)?;
        guide::damp_undescribed_guide(&mut machine);
        journal::split_off_journals(&mut machine, nuts_m);
        nut::distribute_nut_loads(&mut machine, nuts_m);
        Ok(machine)
    }

    /// Returns the median of a loss factor: the described or the typical one; `None` where it is fixed or a parameter.
    fn loss_median(&self, described: &Value, typical: f64) -> Option<f64> {
        let stated = described.described().filter(|_| described.modifiers.is_empty())?;
        let median = if stated > 0.0 { stated } else { typical };
        (median > 0.0 && self.tolerance.loss_spread > 0.0 && self.tolerance.loss_factor > 0.0).then_some(median)
    }

    /// Returns the point with the largest inertia of a kind.
    pub(super) fn largest(&self, motion: PointMotion) -> Option<usize> {
        let size = |at: &usize| size(&self.points[*at].inertia, self);
        let own = (0..self.points.len()).filter(|at| self.points[*at].motion == motion && size(at) > 0.0);
        own.max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// Returns those of the given tolerance keys that have no effect in this machine.
    pub fn idle_tolerances<'k>(&self, keys: &[&'k str]) -> Vec<&'k str> {
        let couples = |s: &Shaft| s.stations.iter().any(|t| t.torsion.is_some()) && s.stations.iter().any(|t| t.axial.is_some());
        let idle = |key: &str| match key {
            "diameter" | "youngs_modulus" | "end_diameters" => self.shafts.is_empty(),
            "shear_modulus" => !self.shafts.iter().any(couples),
            "nut_length" => !self.shafts.iter().any(|s| s.stations.iter().any(|t| t.place == super::StationPlace::Nut)),
            "guide_damping" => guide::undescribed(self).is_none(),
            "mass" => self.largest(PointMotion::Translation).is_none(),
            "inertia" => self.largest(PointMotion::Rotation).is_none(),
            key if key.starts_with("loss_") => self.joints.is_empty() && self.shafts.is_empty(),
            _ => false,
        };
        keys.iter().copied().filter(|key| idle(key)).collect()
    }
}
