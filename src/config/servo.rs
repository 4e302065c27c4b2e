//! Configuration section of a drive that holds a point, entered as a spring and a damper.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::fault;
use machine::{MachineError, NumberSource};
use numeric::unit::travel_per_radian_m;

/// A drive whose loops hold a point: proportional in position and velocity, fast compared with the vibration.
/// Describe a drive with integrals, delays and current loops as [drive] and use closed loops.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServoFile {
    /// Force or torque per output of the velocity loop (N/A, N·m/A or per V).
    constant: f64,
    /// Travel per turn (m) where the point rotates and the gains refer to a travel.
    lead_m: Option<f64>,
    /// Gain of the position loop (1/s).
    position_gain_per_s: NumberSource,
    /// Gain of the velocity loop (output per m/s, or per rad/s without lead_m).
    velocity_gain: NumberSource,
}

/// Multiplies base by factor.
fn times(
    base: NumberSource,
    factor: &NumberSource,
    joint: &str,
    key: &str,
) -> Result<NumberSource, MachineError> {
    match (factor, base) {
        (NumberSource::Number(x), NumberSource::Number(b)) => Ok(NumberSource::Number(b * x)),
        // The number is innermost, so that parameters multiply it.
        (NumberSource::Parameter(id), base) => Ok(NumberSource::Times(Box::new(base), id.clone())),
        (NumberSource::Number(x), NumberSource::Times(inner, id)) => {
            Ok(NumberSource::Times(Box::new(times(*inner, &NumberSource::Number(*x), joint, key)?), id))
        }
        _ => Err(fault(format!("joint.{joint}.servo.{key}"), "write a number, or the name of a parameter")),
    }
}

impl ServoFile {
    /// Returns k = G·k_v·k_p·i and c = G·k_v·i, i = lead/2π.
    ///
    /// # Source  the loops of [`machine::PositionLoop`] and [`machine::VelocityLoop`] without integral and
    ///   delay
    pub fn stiffness_and_damping(self, joint: &str) -> Result<(NumberSource, NumberSource), MachineError> {
        for (key, x) in [("constant", Some(self.constant)), ("lead_m", self.lead_m)] {
            if let Some(x) = x.filter(|x| !(*x > 0.0 && x.is_finite())) {
                return Err(fault(
                    format!("joint.{joint}.servo.{key}"),
                    format!("is {x}; write a number above 0"),
                ));
            }
        }
        for (key, gain) in
            [("position_gain_per_s", &self.position_gain_per_s), ("velocity_gain", &self.velocity_gain)]
        {
            if let NumberSource::Number(x) = gain
                && !(*x >= 0.0 && x.is_finite())
            {
                return Err(fault(
                    format!("joint.{joint}.servo.{key}"),
                    format!("is {x}; write 0 or a number above it"),
                ));
            }
        }
        let base = NumberSource::Number(self.constant * self.lead_m.map_or(1.0, travel_per_radian_m));
        let damping = times(base, &self.velocity_gain, joint, "velocity_gain")?;
        let stiffness = times(damping.clone(), &self.position_gain_per_s, joint, "position_gain_per_s")?;
        Ok((stiffness, damping))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_gains_are_stiffness_and_damping() {
        let number = |x| NumberSource::Number(x);
        let servo = |position, velocity| ServoFile {
            constant: 2.0,
            lead_m: None,
            position_gain_per_s: position,
            velocity_gain: velocity,
        };
        let (k, c) = servo(number(50.0), number(3.0)).stiffness_and_damping("hold").unwrap();
        assert_eq!((k, c), (NumberSource::Number(300.0), NumberSource::Number(6.0)));
        let named =
            servo(number(50.0), NumberSource::Parameter("k_v".into())).stiffness_and_damping("hold").unwrap();
        let times = |base, id: &str| NumberSource::Times(Box::new(NumberSource::Number(base)), id.into());
        assert_eq!(named, (times(100.0, "k_v"), times(2.0, "k_v")));
        let series = NumberSource::Series(toml::from_str("series = [1.0, 2.0]").unwrap());
        assert!(
            servo(series, number(1.0))
                .stiffness_and_damping("hold")
                .unwrap_err()
                .part
                .contains("position_gain_per_s")
        );
    }
}
