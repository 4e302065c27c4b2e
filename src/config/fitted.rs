//! Configuration section of tolerances at identified values.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::fault;
use machine::{Estimate, Machine, MachineError};

/// Estimates of tolerances: values of the machine's numbers, and what an identification starts with. A file
/// of an identified machine contains them.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedFile {
    /// Nut positions (m) of the measurement set, on which the lengths of journals and nuts depend.
    nuts_m: Vec<f64>,
    /// SHA-256 of the files of the measurements from which the estimates are.
    #[serde(default)]
    pub measurements_sha256: Vec<String>,
    /// Estimate of each tolerance by its name in an identification; those of `[tolerance]` that are not named
    /// stay as described.
    tolerances: BTreeMap<String, EstimateFile>,
}

/// Estimate of a tolerance, in its unit.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, or a table of value and sd such as { value = 0.0, sd = 0.01 }"
)]
enum EstimateFile {
    /// A value alone; its standard deviation is that of `[tolerance]`.
    Value(f64),
    /// A value with its standard deviation.
    Known(KnownFile),
}

/// A value with its standard deviation.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct KnownFile {
    /// Value.
    value: f64,
    /// Standard deviation, of the logarithm for a loss factor; 0 fixes the value.
    sd: f64,
}

impl EstimateFile {
    fn estimate(self) -> Estimate {
        match self {
            EstimateFile::Value(value) => Estimate { value, sd: None },
            EstimateFile::Known(KnownFile { value, sd }) => Estimate { value, sd: Some(sd) },
        }
    }
}

impl FittedFile {
    /// Returns the machine with its tolerances held at these estimates. `removed` tells whether effects were
    /// taken out, and tolerances with them.
    pub(super) fn applied(&self, machine: &Machine, removed: bool) -> Result<Machine, MachineError> {
        let stroke_m = machine.stroke_m().unwrap_or(f64::INFINITY);
        if let Some(nut_m) = self.nuts_m.iter().find(|nut_m| !(0.0..=stroke_m).contains(*nut_m)) {
            return Err(fault(
                "fitted.nuts_m",
                format!("{nut_m} lies outside the screw; write positions from 0 to {stroke_m} m"),
            ));
        }
        let estimates = self.tolerances.iter().map(|(name, file)| (name.clone(), file.estimate())).collect();
        let (held, unknown) = machine.with_tolerances_held(&self.nuts_m, &estimates)?;
        match unknown.first().filter(|_| !removed) {
            Some(name) => Err(fault(
                format!("fitted.tolerances.{name}"),
                "the machine has no such tolerance; remove the line",
            )),
            None => Ok(held),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::read_machine;
    use machine::Prior;

    fn read(estimates: &str) -> Result<machine::Machine, String> {
        let fitted = format!("fitted={{nuts_m=[0.6, 1.6], tolerances={{{estimates}}}}}");
        let read = read_machine("configs/tian.toml", &[fitted], &[]);
        read.map(|config| config.machine).map_err(|error| error.to_string())
    }

    #[test]
    fn estimates_are_numbers_of_simulations_and_priors_of_fits() {
        let machine = read(
            r#""mass of table"={value=0.004,sd=0.002}, "loss factor of nut"={value=0.02,sd=0.3},
               "nut length on screw"=1.2, "diameter of screw"={value=1e-4,sd=0}"#,
        );
        let machine = machine.unwrap();
        assert!(machine.parameters.iter().all(|p| !p.is_tolerance()));
        let open = machine.with_tolerances(&[0.9]).unwrap();
        assert_eq!(&open.parameters[..machine.parameters.len()], &machine.parameters[..]);
        let prior = |name: &str| {
            let found = open.parameters.iter().find(|p| p.name() == name);
            found.map(|p| (p.start, p.prior))
        };
        assert_eq!(prior("mass of table"), Some((0.004, Some(Prior::Normal(0.002)))));
        assert_eq!(prior("loss factor of nut"), Some((0.02, Some(Prior::LogNormal(0.3)))));
        // As described: a value without standard deviation, and a tolerance without a value.
        // A nut of typical length to 50 %, or none, at equal odds: the variance is 0.5·0.5² + 0.25.
        assert_eq!(prior("nut length on screw"), Some((1.2, Some(Prior::Normal(0.375_f64.sqrt())))));
        assert_eq!(prior("inertia of rotor"), Some((0.0, Some(Prior::Normal(0.02)))));
        assert_eq!(prior("diameter of screw"), None);
        // The same numbers, held or open, and held again.
        let held = open.with_tolerances_held(&[], &Default::default()).unwrap().0;
        let numbers = |machine: &machine::Machine| -> Vec<f64> {
            let (start, at) = (machine.start(), machine::Operating::at_nut(1.0));
            let of_joints =
                machine.joints.iter().flat_map(|j| [&j.loss_factor, &j.damping, &j.integral_rate]);
            let of_shafts = machine.shafts.iter().flat_map(|s| [&s.diameter, &s.nut_support_factor]);
            let of_points = machine.points.iter().map(|p| &p.inertia);
            of_points.chain(of_shafts).chain(of_joints).map(|value| value.at(&start, &at)).collect()
        };
        assert_eq!(numbers(&machine), numbers(&open));
        assert_eq!(numbers(&machine), numbers(&held));
        assert_eq!(held.with_tolerances(&[]).unwrap().parameters, open.parameters);
        assert!(open.without_guide_tolerance().parameters == open.parameters);
        let without = machine.without_guide_tolerance().with_tolerances(&[]).unwrap();
        assert_eq!(without.parameters.len() + 1, open.parameters.len());
    }

    #[test]
    fn a_value_without_its_deviation_is_refused_with_the_right_form() {
        let fault = read(r#""mass of table"={value=0.004}"#).unwrap_err();
        assert!(fault.contains("expected a number, or a table of value and sd"), "{fault}");
    }

    #[test]
    fn estimates_beyond_physics_are_refused_with_their_key() {
        for estimate in [
            r#""mass of table"=-1.0"#,
            r#""mass of table"=nan"#,
            r#""mass of table"={value=0.0,sd=-1.0}"#,
            r#""mass of table"={value=0.0,sd=1e9}"#,
            r#""loss factor of nut"=-1.0"#,
            r#""loss factor of nut"=1e6"#,
            r#""nut length on screw"=-5.0"#,
            r#""mass of nothing"=0.0"#,
        ] {
            let name = estimate.split('"').nth(1).unwrap();
            let fault = read(estimate).unwrap_err();
            assert!(fault.contains(&format!("fitted.tolerances.{name}: ")), "{fault}");
        }
    }
}
