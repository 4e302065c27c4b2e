//! Resolution and checks of the patches that only motion uses: friction, backlash, lead error and drive.

use super::error::{MachineError, fault, listing};
use super::number::{CURRENT, DRIVE, JOINT, MOTOR, Number, Reach, check_ranges, numbers_of};
use super::{
    CurrentLoop, Drive, DriveFile, Encoder, Inverter, Joint, Machine, Motor, Operating, PointMotion,
    PositionLoop, Tachometry, Value, VelocityLoop, Wave,
};

/// Upper limit of a delay or a velocity difference, in periods of the loop.
const MOST_PERIODS: f64 = 1000.0;
/// Upper limit of the position loop's period, in periods of the innermost loop: 1 ms over 0.1 µs.
const MOST_INNER_PERIODS: f64 = 1e4;

impl Machine {
    fn resolve_encoder(&self, part: &str, name: &str, lead_m: Option<f64>) -> Result<Encoder, MachineError> {
        let at = self.named_point(&format!("{part}.at"), name)?;
        if let Some(lead_m) = lead_m {
            if self.points[at].motion != PointMotion::Rotation {
                return Err(fault(
                    format!("{part}.lead_m"),
                    format!("«{name}» does not rotate; leave lead_m out"),
                ));
            }
            if !(lead_m.abs() > 0.0 && lead_m.is_finite()) {
                return Err(fault(
                    format!("{part}.lead_m"),
                    format!("is {lead_m}; write the travel per turn in m"),
                ));
            }
        }
        let travel = lead_m.map_or(1.0, numeric::unit::travel_per_radian_m);
        Ok(Encoder { at, travel, step: Value::default() })
    }

    pub(super) fn resolve_drive_patch(&self, patch: &DriveFile) -> Result<Drive, MachineError> {
        if self.drive.is_some() {
            return Err(fault("drive", "the machine has a drive already; describe one"));
        }
        let (position, velocity) = (&patch.position, &patch.velocity);
        let position_at = position.at.as_ref().unwrap_or(&patch.on);
        let velocity_at = velocity.at.as_ref().unwrap_or(position_at);
        // Both loops share the settings of a common point.
        let same = velocity_at == position_at;
        let velocity_lead_m = velocity.lead_m.or(position.lead_m.filter(|_| same));
        let unlimited = || Value::number(f64::INFINITY);
        let mut drive = Drive {
            on: self.named_point("drive.on", &patch.on)?,
            constant: Value::default(),
            force_factor: Value::number(1.0),
            delay_s: Value::default(),
            saturation: unlimited(),
            ripple: Wave::default(),
            motor: patch.motor.as_ref().map(|motor| Motor {
                resistance_ohm: Value::default(),
                inductance_h: Value::default(),
                inductance_d_h: Value::default(),
                pole_pairs: motor.pole_pairs,
                dc_link_v: unlimited(),
            }),
            current: patch.current.as_ref().map(|current| CurrentLoop {
                gain: Value::default(),
                integral_time_s: unlimited(),
                period_s: current.period_s,
                inverter: current.inverter,
            }),
            position: PositionLoop {
                encoder: self.resolve_encoder("drive.position", position_at, position.lead_m)?,
                gain_per_s: Value::default(),
                feed_forward: Value::default(),
                limits: position.limits_m,
                period_s: position.period_s,
            },
            velocity: VelocityLoop {
                encoder: self.resolve_encoder("drive.velocity", velocity_at, velocity_lead_m)?,
                tachometry: velocity.tachometry(),
                gain: Value::default(),
                integral_time_s: unlimited(),
                acceleration_feed_forward: Value::default(),
                period_s: velocity.period_s,
            },
        };
        self.set_numbers(DRIVE, "drive", patch, &mut drive)?;
        if let (Some(file), Some(motor)) = (&patch.motor, &mut drive.motor) {
            self.set_numbers(MOTOR, "drive", file, motor)?;
            if file.inductance_d_h.is_none() {
                motor.inductance_d_h = motor.inductance_h.clone();
            }
        }
        if let (Some(file), Some(current)) = (&patch.current, &mut drive.current) {
            self.set_numbers(CURRENT, "drive", file, current)?;
        }
        if same && velocity.encoder_step.is_none() {
            drive.velocity.encoder.step = drive.position.encoder.step.clone();
        }
        Ok(drive)
    }

    /// Returns whether closed-loop frequency responses depend on each parameter through a number of the
    /// drive. Resolutions, limits and ripple act on motion alone.
    pub fn closed_loop_parameters(&self) -> Vec<bool> {
        let drive = self.drive.iter().flat_map(Drive::numbers);
        self.depended_on(
            drive.filter(|(number, _)| number.reach == Reach::ClosedLoop).map(|(_, value)| value),
        )
    }

    /// Returns the names of the joints whose friction, backlash or lead error at the start values is ignored
    /// by frequency responses and modes.
    pub fn joints_ignored_by_frequency_responses(&self) -> Vec<&str> {
        let (start, middle) = (self.start(), Operating::default());
        let acts = |(number, value): (&Number, &Value)| {
            number.reach == Reach::MotionIgnored && value.at(&start, &middle) != 0.0
        };
        let ignored = |j: &&Joint| !j.friction.table.is_empty() || numbers_of(JOINT, *j).any(acts);
        self.joints.iter().filter(ignored).map(|j| j.name.as_str()).collect()
    }

    /// Checks the numbers on which only motion depends, each against the range of its key.
    pub(super) fn check_motion(&self, at: impl Fn(&Value) -> f64) -> Result<(), MachineError> {
        for joint in &self.joints {
            let of_motion = numbers_of(JOINT, joint).filter(|(number, _)| number.reach != Reach::All);
            check_ranges(of_motion, |key| format!("joint.{}.{key}", joint.name), &at)?;
        }
        let of_drive = self.drive.iter().flat_map(Drive::numbers);
        check_ranges(of_drive, |key| format!("drive.{key}"), &at)?;
        for joint in &self.joints {
            let part = |key: &str| format!("joint.{}.{key}", joint.name);
            if at(&joint.gap) > 0.0 && !(at(&joint.stiffness) > 0.0) {
                return Err(fault(
                    part("gap"),
                    "the joint has no stiffness that could act beyond the backlash; write one",
                ));
            }
            let waves = [
                ("friction.position", &joint.friction.position),
                ("lead_error.wave", &joint.lead_error.wave),
            ];
            for (key, wave) in waves {
                check_wave(&part(key), wave, &at)?;
            }
            if at(&joint.friction.stribeck) > 0.0 && !(at(&joint.friction.stribeck_velocity) > 0.0) {
                return Err(fault(
                    part("friction.stribeck_velocity"),
                    "is 0; write the Stribeck velocity, over which the level falls",
                ));
            }
        }
        self.drive.as_ref().map_or(Ok(()), |drive| self.check_drive(drive, at))
    }

    /// Checks periods, limits, delay and points of a drive.
    fn check_drive(&self, drive: &Drive, at: impl Fn(&Value) -> f64) -> Result<(), MachineError> {
        check_wave("drive.ripple", &drive.ripple, &at)?;
        let periods = [
            ("current", drive.current.as_ref().map(|c| c.period_s)),
            ("velocity", Some(drive.velocity.period_s)),
            ("position", Some(drive.position.period_s)),
        ];
        let mut inner: Option<(&str, f64)> = None;
        for (key, period_s) in periods.into_iter().filter_map(|(key, period_s)| Some((key, period_s?))) {
            if !(period_s > 0.0 && period_s.is_finite()) {
                return Err(fault(
                    format!("drive.{key}.period_s"),
                    format!("is {period_s}; write the loop's period in s"),
                ));
            }
            if let Some((within, inner_s)) = inner {
                let ratio = period_s / inner_s;
                if !(ratio > 0.999_999 && (ratio - ratio.round()).abs() < 1e-6 * ratio) {
                    return Err(fault(
                        format!("drive.{key}.period_s"),
                        format!(
                            "{period_s} s is no multiple of the {within} loop's period of {inner_s} s; write one that is"
                        ),
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
            let message = format!(
                "is {delay_s} s, more than {MOST_PERIODS} periods of the innermost loop; write a shorter one"
            );
            return Err(fault("drive.delay_s", message));
        }
        if !(inner_s >= 1e-7) {
            return Err(fault(
                "drive",
                format!("its innermost loop has a period of {inner_s} s; write 1e-7 s or more"),
            ));
        }
        let (position_s, ratio) = (drive.position.period_s, drive.position.period_s / inner_s);
        if !(ratio <= MOST_INNER_PERIODS) {
            let message = format!(
                "{position_s} s is {ratio:.0} periods of the innermost loop; write at most {MOST_INNER_PERIODS}"
            );
            return Err(fault("drive.position.period_s", message));
        }
        if matches!(drive.velocity.tachometry, Tachometry::Difference(periods) if periods as f64 > MOST_PERIODS)
        {
            return Err(fault(
                "drive.velocity.over_s",
                format!("is more than {MOST_PERIODS} periods of the loop; write a shorter time"),
            ));
        }
        if drive.velocity.tachometry == Tachometry::Difference(0) {
            return Err(fault(
                "drive.velocity.over_s",
                "is no multiple of the loop's period; write one that is, or leave it out",
            ));
        }
        for (key, point) in [
            ("on", drive.on),
            ("position.at", drive.position.encoder.at),
            ("velocity.at", drive.velocity.encoder.at),
        ] {
            if self.points[point].fixed {
                let known = listing(self.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()));
                return Err(fault(
                    format!("drive.{key}"),
                    format!("«{}» does not move; {known}", self.points[point].name),
                ));
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
                Some(_) => Err(fault(
                    "drive.current",
                    "the motor has no winding whose current could be controlled; describe one as [drive.motor]",
                )),
            };
        };
        let Some(pairs) = motor.pole_pairs else {
            return match &drive.current {
                Some(current) if current.inverter == Inverter::Switching => Err(fault(
                    "drive.current.inverter",
                    "a motor without pole_pairs has no three phases to switch; leave it out",
                )),
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
            return Err(fault(
                "drive.motor.pole_pairs",
                format!("«{}» does not rotate; leave pole_pairs out", self.points[drive.on].name),
            ));
        }
        let Some(current) = &drive.current else {
            return Err(fault(
                "drive.motor",
                "a motor with pole_pairs needs a current loop; describe one as [drive.current]",
            ));
        };
        let unlimited = motor.dc_link_v == Value::number(f64::INFINITY);
        if current.inverter == Inverter::Switching && unlimited {
            return Err(fault(
                "drive.motor.dc_link_v",
                "is missing; a switching inverter needs its supply voltage",
            ));
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
