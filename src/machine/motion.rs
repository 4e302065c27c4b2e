//! Resolution and checks of the patches that only motion uses: friction, backlash, lead error and drive.

use super::check::{MachineError, fault, listing};
use super::{
    CurrentLoop, Drive, DriveFile, Encoder, Friction, FrictionForceFile, FrictionTable, Inverter, Joint, LeadError, LeadErrorFile, Machine,
    Motor, NumberSource, Operating, PointMotion, PositionLoop, Tachometry, Value, VelocityLoop, Wave, WaveFile,
};

/// Upper limit of a delay or a velocity difference, in periods of the loop.
const MOST_PERIODS: f64 = 1000.0;
/// Upper limit of the position loop's period, in periods of the innermost loop: 1 ms over 0.1 µs.
const MOST_INNER_PERIODS: f64 = 1e4;

impl Machine {
    fn resolve_wave(&self, part: &str, patch: &Option<WaveFile>) -> Result<Wave, MachineError> {
        let Some(patch) = patch else { return Ok(Wave::default()) };
        let value = |key: &str, source| self.value_or_zero(&format!("{part}.{key}"), source);
        Ok(Wave { cosine: value("cosine", &patch.cosine)?, sine: value("sine", &patch.sine)?, period: value("period", &patch.period)? })
    }

    pub(super) fn resolve_friction_patch(&self, joint: &str, patch: &FrictionForceFile) -> Result<Friction, MachineError> {
        let part = format!("{joint}.friction");
        let load_of = match &patch.load_of {
            None => None,
            Some(name) => Some(self.joint_named(&format!("{part}.load_of"), name)?),
        };
        let value = |key: &str, source| self.value_or_zero(&format!("{part}.{key}"), source);
        Ok(Friction {
            coulomb: value("coulomb", &patch.coulomb)?,
            offset: value("offset", &patch.offset)?,
            viscous_asymmetry: value("viscous_asymmetry", &patch.viscous_asymmetry)?,
            stribeck: value("stribeck", &patch.stribeck)?,
            stribeck_velocity: value("stribeck_velocity", &patch.stribeck_velocity)?,
            stribeck_exponent: value("stribeck_exponent", &patch.stribeck_exponent.clone().or(Some(NumberSource::Number(2.0))))?,
            presliding_stiffness: value("presliding_stiffness", &patch.presliding_stiffness)?,
            presliding_damping: value("presliding_damping", &patch.presliding_damping)?,
            position: self.resolve_wave(&format!("{part}.position"), &patch.position)?,
            load_share: value("load_share", &patch.load_share)?,
            load_of,
            table: match &patch.table {
                None => FrictionTable::default(),
                Some(rows) => FrictionTable::new(&format!("{part}.table"), rows)?,
            },
        })
    }

    pub(super) fn resolve_lead_error_patch(&self, joint: &str, patch: &LeadErrorFile) -> Result<LeadError, MachineError> {
        let part = format!("{joint}.lead_error");
        Ok(LeadError {
            growth: self.value_or_zero(&format!("{part}.growth"), &patch.growth)?,
            wave: self.resolve_wave(&format!("{part}.wave"), &patch.wave)?,
        })
    }

    fn resolve_encoder(&self, part: &str, name: &str, lead_m: Option<f64>, step: &Option<NumberSource>) -> Result<Encoder, MachineError> {
        let at = self.named_point(&format!("{part}.at"), name)?;
        if let Some(lead_m) = lead_m {
            if self.points[at].motion != PointMotion::Rotation {
                return Err(fault(format!("{part}.lead_m"), format!("«{name}» does not rotate; leave lead_m out")));
            }
            if !(lead_m.abs() > 0.0 && lead_m.is_finite()) {
                return Err(fault(format!("{part}.lead_m"), format!("is {lead_m}; write the travel per turn in m")));
            }
        }
        let travel = lead_m.map_or(1.0, numeric::unit::travel_per_radian_m);
        Ok(Encoder { at, travel, step: self.value_or_zero(&format!("{part}.encoder_step"), step)? })
    }

    pub(super) fn resolve_drive_patch(&self, patch: &DriveFile) -> Result<Drive, MachineError> {
        if self.drive.is_some() {
            return Err(fault("drive", "the machine has a drive already; describe one"));
        }
        let value = |key: &str, source: &NumberSource| self.value(&format!("drive.{key}"), source);
        let optional = |key: &str, source: &Option<NumberSource>| match source {
            None => Ok(Value::number(f64::INFINITY)),
            Some(source) => value(key, source),
        };
        let value_or_zero = |key: &str, source| self.value_or_zero(&format!("drive.{key}"), source);
        let (position, velocity) = (&patch.position, &patch.velocity);
        let position_at = position.at.as_ref().unwrap_or(&patch.on);
        let velocity_at = velocity.at.as_ref().unwrap_or(position_at);
        // Both loops share the settings of a common point.
        let same = velocity_at == position_at;
        let velocity_lead_m = velocity.lead_m.or(position.lead_m.filter(|_| same));
        let velocity_step = if same && velocity.encoder_step.is_none() { &position.encoder_step } else { &velocity.encoder_step };
        let motor = match &patch.motor {
            None => None,
            Some(motor) => Some(Motor {
                resistance_ohm: value("motor.resistance_ohm", &motor.resistance_ohm)?,
                inductance_h: value("motor.inductance_h", &motor.inductance_h)?,
                inductance_d_h: value("motor.inductance_d_h", motor.inductance_d_h.as_ref().unwrap_or(&motor.inductance_h))?,
                pole_pairs: motor.pole_pairs,
                dc_link_v: optional("motor.dc_link_v", &motor.dc_link_v)?,
            }),
        };
        let current = match &patch.current {
            None => None,
            Some(current) => Some(CurrentLoop {
                gain: value("current.gain", &current.gain)?,
                integral_time_s: optional("current.integral_time_s", &current.integral_time_s)?,
                period_s: current.period_s,
                inverter: current.inverter,
            }),
        };
        Ok(Drive {
            on: self.named_point("drive.on", &patch.on)?,
            constant: value("constant", &patch.constant)?,
            force_factor: Value::number(1.0),
            delay_s: value_or_zero("delay_s", &patch.delay_s)?,
            saturation: optional("saturation", &patch.saturation)?,
            ripple: self.resolve_wave("drive.ripple", &patch.ripple)?,
            motor,
            current,
            position: PositionLoop {
                encoder: self.resolve_encoder("drive.position", position_at, position.lead_m, &position.encoder_step)?,
                gain_per_s: value("position.gain_per_s", &position.gain_per_s)?,
                feed_forward: value_or_zero("position.feed_forward", &position.feed_forward)?,
                limits: position.limits_m,
                period_s: position.period_s,
            },
            velocity: VelocityLoop {
                encoder: self.resolve_encoder("drive.velocity", velocity_at, velocity_lead_m, velocity_step)?,
                tachometry: velocity.tachometry(),
                gain: value("velocity.gain", &velocity.gain)?,
                integral_time_s: optional("velocity.integral_time_s", &velocity.integral_time_s)?,
                acceleration_feed_forward: value_or_zero("velocity.acceleration_feed_forward", &velocity.acceleration_feed_forward)?,
                period_s: velocity.period_s,
            },
        })
    }

    /// Returns the numbers on which only motion depends, each with its configuration key.
    pub(super) fn motion_values(&self) -> Vec<(String, &Value)> {
        let mut values = Vec::new();
        for joint in &self.joints {
            let part = |key: &str| format!("joint.{}.{key}", joint.name);
            values.push((part("gap"), &joint.gap));
            values.extend(joint.friction.values().into_iter().map(|(key, v)| (part(&format!("friction.{key}")), v)));
            values.extend(joint.lead_error.values().into_iter().map(|(key, v)| (part(&format!("lead_error.{key}")), v)));
        }
        values.extend(self.drive.iter().flat_map(Drive::values).map(|(key, v)| (format!("drive.{key}"), v)));
        values
    }

    /// Returns whether closed-loop frequency responses depend on each parameter through a number of the drive. Resolutions, limits and ripple act on
    /// motion alone.
    pub fn closed_loop_parameters(&self) -> Vec<bool> {
        let linear = |key: &str| !["saturation", "encoder_step", "dc_link_v", "inductance_d_h"].iter().any(|end| key.ends_with(end));
        let mut depends = vec![false; self.parameters.len()];
        let values = self.drive.iter().flat_map(Drive::values).filter(|(key, _)| linear(key) && !key.starts_with("ripple"));
        values.for_each(|(_, value)| value.depends_on().for_each(|index| depends[index] = true));
        depends
    }

    /// Returns the names of the joints whose friction, backlash or lead error at the start values is ignored by frequency responses and
    /// modes.
    pub fn joints_ignored_by_frequency_responses(&self) -> Vec<&str> {
        let (start, middle) = (self.start(), Operating::default());
        let acts = |(key, value): &(&str, &Value)| {
            ["coulomb", "stribeck", "position.cosine", "position.sine", "load_share", "viscous_asymmetry", "wave.cosine", "wave.sine"]
                .contains(key)
                && value.at(&start, &middle) != 0.0
        };
        let ignored = |j: &&Joint| {
            j.gap.at(&start, &middle) > 0.0
                || !j.friction.table.is_empty()
                || j.friction.values().iter().any(acts)
                || j.lead_error.values().iter().any(acts)
        };
        self.joints.iter().filter(ignored).map(|j| j.name.as_str()).collect()
    }

    /// Checks the numbers on which only motion depends, each against the range of its key.
    pub(super) fn check_motion(&self, at: impl Fn(&Value) -> f64) -> Result<(), MachineError> {
        for (part, value) in self.motion_values() {
            let x = at(value);
            let key = part.rsplit('.').next().unwrap_or_default();
            let may_be_infinite = ["saturation", "integral_time_s", "dc_link_v"].contains(&key);
            let any_sign = ["offset", "viscous_asymmetry", "cosine", "sine", "growth"].contains(&key);
            let electric = ["inductance_h", "inductance_d_h", "dc_link_v"].contains(&key);
            let above_zero = electric || ["saturation", "integral_time_s", "stribeck_exponent", "constant", "force_factor"].contains(&key);
            if x.is_nan() || (x.is_infinite() && !may_be_infinite) {
                return Err(fault(part, format!("is {x}; write a finite number")));
            }
            if above_zero && !(x > 0.0) {
                return Err(fault(part, format!("is {x:?}; write a number above 0")));
            }
            if !any_sign && !(x >= 0.0) {
                return Err(fault(part, format!("is {x:?}; write 0 or a number above it")));
            }
        }
        for joint in &self.joints {
            let part = |key: &str| format!("joint.{}.{key}", joint.name);
            if at(&joint.gap) > 0.0 && !(at(&joint.stiffness) > 0.0) {
                return Err(fault(part("gap"), "the joint has no stiffness that could act beyond the backlash; write one"));
            }
            let waves = [("friction.position", &joint.friction.position), ("lead_error.wave", &joint.lead_error.wave)];
            for (key, wave) in waves {
                check_wave(&part(key), wave, &at)?;
            }
            if at(&joint.friction.stribeck) > 0.0 && !(at(&joint.friction.stribeck_velocity) > 0.0) {
                return Err(fault(part("friction.stribeck_velocity"), "is 0; write the Stribeck velocity, over which the level falls"));
            }
        }
        let Some(drive) = &self.drive else { return Ok(()) };
        check_wave("drive.ripple", &drive.ripple, &at)?;
        let periods = [
            ("current", drive.current.as_ref().map(|c| c.period_s)),
            ("velocity", Some(drive.velocity.period_s)),
            ("position", Some(drive.position.period_s)),
        ];
        let mut inner: Option<(&str, f64)> = None;
        for (key, period_s) in periods.into_iter().filter_map(|(key, period_s)| Some((key, period_s?))) {
            if !(period_s > 0.0 && period_s.is_finite()) {
                return Err(fault(format!("drive.{key}.period_s"), format!("is {period_s}; write the loop's period in s")));
            }
            if let Some((within, inner_s)) = inner {
                let ratio = period_s / inner_s;
                if !(ratio > 0.999_999 && (ratio - ratio.round()).abs() < 1e-6 * ratio) {
                    return Err(fault(
                        format!("drive.{key}.period_s"),
                        format!("{period_s} s is no multiple of the {within} loop's period of {inner_s} s; write one that is"),
                    ));
                }
            }
            inner = Some((key, period_s));
        }
        if let Some([lower, upper]) = drive.position.limits.filter(|[a, b]| !(a < b)) {
            return Err(fault(
                "drive.position.limits_m",
                format!("is [{lower}, {upper}]; write the lower end of the stroke, then the upper"),
            ));
        }
        self.check_motor(drive)?;
        let (delay_s, inner_s) = (at(&drive.delay_s), drive.period_s());
        if !(delay_s <= MOST_PERIODS * inner_s) {
            let message = format!("is {delay_s} s, more than {MOST_PERIODS} periods of the innermost loop; write a shorter one");
            return Err(fault("drive.delay_s", message));
        }
        if !(inner_s >= 1e-7) {
            return Err(fault("drive", format!("its innermost loop has a period of {inner_s} s; write 1e-7 s or more")));
        }
        let (position_s, ratio) = (drive.position.period_s, drive.position.period_s / inner_s);
        if !(ratio <= MOST_INNER_PERIODS) {
            let message = format!("{position_s} s is {ratio:.0} periods of the innermost loop; write at most {MOST_INNER_PERIODS}");
            return Err(fault("drive.position.period_s", message));
        }
        if matches!(drive.velocity.tachometry, Tachometry::Difference(periods) if periods as f64 > MOST_PERIODS) {
            return Err(fault("drive.velocity.over_s", format!("is more than {MOST_PERIODS} periods of the loop; write a shorter time")));
        }
        if drive.velocity.tachometry == Tachometry::Difference(0) {
            return Err(fault("drive.velocity.over_s", "is no multiple of the loop's period; write one that is, or leave it out"));
        }
        for (key, point) in [("on", drive.on), ("position.at", drive.position.encoder.at), ("velocity.at", drive.velocity.encoder.at)] {
            if self.points[point].fixed {
                let known = listing(self.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()));
                return Err(fault(format!("drive.{key}"), format!("«{}» does not move; {known}", self.points[point].name)));
            }
        }
        Ok(())
    }
}

impl Machine {
    fn check_motor(&self, drive: &Drive) -> Result<(), MachineError> {
        let Some(motor) = &drive.motor else {
            return match drive.current {
                None => Ok(()),
                Some(_) => {
                    Err(fault("drive.current", "the motor has no winding whose current could be controlled; describe one as [drive.motor]"))
                }
            };
        };
        let Some(pairs) = motor.pole_pairs else {
            return match &drive.current {
                Some(current) if current.inverter == Inverter::Switching => {
                    Err(fault("drive.current.inverter", "a motor without pole_pairs has no three phases to switch; leave it out"))
                }
                _ => Ok(()),
            };
        };
        if !(1..=1000).contains(&pairs) {
            return Err(fault(
                "drive.motor.pole_pairs",
                format!("is {pairs}; write the number of pole pairs, or leave it out for a DC motor"),
            ));
        }
        if self.points[drive.on].motion != PointMotion::Rotation {
            return Err(fault("drive.motor.pole_pairs", format!("«{}» does not rotate; leave pole_pairs out", self.points[drive.on].name)));
        }
        let Some(current) = &drive.current else {
            return Err(fault("drive.motor", "a motor with pole_pairs needs a current loop; describe one as [drive.current]"));
        };
        let unlimited = motor.dc_link_v == Value::number(f64::INFINITY);
        if current.inverter == Inverter::Switching && unlimited {
            return Err(fault("drive.motor.dc_link_v", "is missing; a switching inverter needs its supply voltage"));
        }
        Ok(())
    }
}

fn check_wave(part: &str, wave: &Wave, at: &impl Fn(&Value) -> f64) -> Result<(), MachineError> {
    let zero = at(&wave.cosine) == 0.0 && at(&wave.sine) == 0.0;
    if zero || at(&wave.period) > 0.0 {
        Ok(())
    } else {
        Err(fault(format!("{part}.period"), "is 0; write the period of the wave along the travel"))
    }
}
