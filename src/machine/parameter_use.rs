//! What the parameters of a patch are used for: the mechanism of each.

use super::{
    CurrentFile, DriveFile, FrictionForceFile, LeadErrorFile, Mechanism, MotorFile, NumberSource, Patch, PeriodAlong, Rescale, Target,
    WaveFile,
};

impl Mechanism {
    /// Returns the mechanism of a number of friction, by its configuration key.
    fn of_friction(key: &str) -> Self {
        match key {
            "coulomb" | "offset" | "stribeck" | "position.cosine" | "position.sine" => Mechanism::Force,
            "viscous_asymmetry" | "presliding_damping" => Mechanism::Damping,
            "presliding_stiffness" => Mechanism::Stiffness,
            "stribeck_velocity" => Mechanism::Velocity,
            "stribeck_exponent" | "load_share" => Mechanism::Ratio,
            "position.period" => Mechanism::Period(PeriodAlong::Travel),
            _ => Mechanism::Other,
        }
    }

    /// Returns the mechanism of a number of a lead error, by its configuration key.
    fn of_lead_error(key: &str) -> Self {
        match key {
            "growth" => Mechanism::LeadExpansion,
            "wave.cosine" | "wave.sine" => Mechanism::Length,
            "wave.period" => Mechanism::Period(PeriodAlong::Travel),
            _ => Mechanism::Other,
        }
    }

    /// Returns the mechanism of a number of the drive, by its configuration key. The output of the velocity loop is a voltage or a current.
    fn of_drive(key: &str) -> Self {
        match key {
            "constant" => Mechanism::Quantity(&["N/V", "N*m/V", "N/A", "N*m/A"]),
            "saturation" => Mechanism::Quantity(&["V", "A"]),
            "position.gain_per_s" => Mechanism::Quantity(&["1/s"]),
            "velocity.gain" => Mechanism::Quantity(&["V*s/m", "A*s/m", "V*s/rad", "A*s/rad"]),
            "velocity.acceleration_feed_forward" => Mechanism::Quantity(&["V*s^2/m", "A*s^2/m", "V*s^2/rad", "A*s^2/rad"]),
            "velocity.integral_time_s" | "current.integral_time_s" => Mechanism::Quantity(&["s"]),
            "current.gain" | "motor.resistance_ohm" => Mechanism::Quantity(&["V/A"]),
            "motor.inductance_h" | "motor.inductance_d_h" => Mechanism::Quantity(&["V*s/A"]),
            "motor.dc_link_v" => Mechanism::Quantity(&["V"]),
            "force_factor" | "position.feed_forward" => Mechanism::Ratio,
            "delay_s" => Mechanism::Delay,
            "ripple.cosine" | "ripple.sine" => Mechanism::Force,
            "ripple.period" => Mechanism::Period(PeriodAlong::Motor),
            "position.encoder_step" | "velocity.encoder_step" => Mechanism::Length,
            _ => Mechanism::Other,
        }
    }

    /// Returns the mechanism of a number that a patch changes.
    fn of_target(target: &Target) -> Self {
        match target {
            Target::PointInertia(_) => Mechanism::Inertia,
            Target::JointStiffness(_) => Mechanism::Stiffness,
            Target::JointDamping(_) => Mechanism::Damping,
            Target::JointLossFactor(_) | Target::ShaftLossFactor(_) => Mechanism::LossFactor,
            Target::JointIntegralRate(_) => RATE,
            Target::ShaftYoungsModulus(_) | Target::ShaftModulus(_) | Target::ShaftShearModulus(_) => MODULUS,
            Target::Gap(_) | Target::ShaftDiameter(_) | Target::NutPosition(_) => Mechanism::Length,
            Target::Friction(_, key) => Mechanism::of_friction(key),
            Target::LeadError(_, key) => Mechanism::of_lead_error(key),
            Target::Drive(key) => Mechanism::of_drive(key),
            Target::ShaftBore(_) | Target::LossDispersion | Target::ChainGain | Target::ChainPower => Mechanism::Ratio,
            Target::ChainDelay => Mechanism::Delay,
        }
    }

    /// Returns the mechanism of a parameter that changes a number in a given way.
    fn of_change(target: &Target, rescale: Rescale) -> Self {
        match rescale {
            Rescale::Replace | Rescale::InSeries | Rescale::Added | Rescale::Less => Mechanism::of_target(target),
            Rescale::Relative
            | Rescale::Times
            | Rescale::AlongStroke
            | Rescale::MidStroke
            | Rescale::WithForceLevel
            | Rescale::WithSpeed
            | Rescale::WithAcceleration => Mechanism::Ratio,
        }
    }
}

/// Rate of an integral action.
const RATE: Mechanism = Mechanism::Quantity(&["1/s"]);
/// Young's or shear modulus.
const MODULUS: Mechanism = Mechanism::Quantity(&["Pa"]);
/// Density.
const DENSITY: Mechanism = Mechanism::Quantity(&["kg/m^3"]);

/// A number of a patch and its mechanism.
type Use<'p> = (&'p NumberSource, Mechanism);

/// Returns the numbers that a file states, each with its mechanism by its configuration key.
fn stated<'p, const N: usize>(numbers: [(&str, &'p Option<NumberSource>); N], of: fn(&str) -> Mechanism) -> Vec<Use<'p>> {
    numbers.into_iter().filter_map(|(key, source)| Some((source.as_ref()?, of(key)))).collect()
}

/// Returns the numbers of a wave with their mechanisms: two amplitudes and the period.
fn of_wave<'p>(wave: &'p Option<WaveFile>, keys: [&str; 3], of: fn(&str) -> Mechanism) -> Vec<Use<'p>> {
    let Some(WaveFile { cosine, sine, period }) = wave else { return Vec::new() };
    stated([(keys[0], cosine), (keys[1], sine), (keys[2], period)], of)
}

fn of_friction_file(friction: &FrictionForceFile) -> Vec<Use<'_>> {
    let own = stated(
        [
            ("coulomb", &friction.coulomb),
            ("offset", &friction.offset),
            ("viscous_asymmetry", &friction.viscous_asymmetry),
            ("stribeck", &friction.stribeck),
            ("stribeck_velocity", &friction.stribeck_velocity),
            ("stribeck_exponent", &friction.stribeck_exponent),
            ("presliding_stiffness", &friction.presliding_stiffness),
            ("presliding_damping", &friction.presliding_damping),
            ("load_share", &friction.load_share),
        ],
        Mechanism::of_friction,
    );
    let keys = ["position.cosine", "position.sine", "position.period"];
    [own, of_wave(&friction.position, keys, Mechanism::of_friction)].concat()
}

fn of_lead_error_file(error: &LeadErrorFile) -> Vec<Use<'_>> {
    let own = stated([("growth", &error.growth)], Mechanism::of_lead_error);
    [own, of_wave(&error.wave, ["wave.cosine", "wave.sine", "wave.period"], Mechanism::of_lead_error)].concat()
}

fn of_drive_file(drive: &DriveFile) -> Vec<Use<'_>> {
    let always = [
        (&drive.constant, Mechanism::of_drive("constant")),
        (&drive.position.gain_per_s, Mechanism::of_drive("position.gain_per_s")),
        (&drive.velocity.gain, Mechanism::of_drive("velocity.gain")),
    ];
    let others = stated(
        [
            ("delay_s", &drive.delay_s),
            ("saturation", &drive.saturation),
            ("position.encoder_step", &drive.position.encoder_step),
            ("position.feed_forward", &drive.position.feed_forward),
            ("velocity.encoder_step", &drive.velocity.encoder_step),
            ("velocity.integral_time_s", &drive.velocity.integral_time_s),
            ("velocity.acceleration_feed_forward", &drive.velocity.acceleration_feed_forward),
        ],
        Mechanism::of_drive,
    );
    let motor = drive.motor.iter().flat_map(MotorFile::sources).map(|(key, source)| (source, Mechanism::of_drive(key)));
    let current = drive.current.iter().flat_map(CurrentFile::sources).map(|(key, source)| (source, Mechanism::of_drive(key)));
    let keys = ["ripple.cosine", "ripple.sine", "ripple.period"];
    let ripple = of_wave(&drive.ripple, keys, Mechanism::of_drive);
    always.into_iter().chain(others).chain(motor).chain(current).chain(ripple).collect()
}

impl NumberSource {
    /// Whether the number is a parameter, or a series of springs with the parameter among them.
    fn is_or_contains(&self, id: &str) -> bool {
        match self {
            NumberSource::Parameter(own) => own == id,
            NumberSource::Series(of) => of.series.iter().any(|spring| spring.is_or_contains(id)),
            NumberSource::Number(_) | NumberSource::Contact(_) | NumberSource::Segment(_) | NumberSource::Times(..) => false,
        }
    }
}

impl Patch {
    /// Returns the mechanism of a parameter by its first use in the patch, else by its unit. Inertias come first: a stiffness may be derived from one.
    pub fn mechanism_of(&self, id: &str, unit: &str) -> Mechanism {
        let inertias = self.points.iter().map(|p| (&p.inertia, Mechanism::Inertia));
        let joints = self.joints.iter().flat_map(|j| {
            let own = [
                (&j.stiffness, Mechanism::Stiffness),
                (&j.damping, Mechanism::Damping),
                (&j.loss_factor, Mechanism::LossFactor),
                (&j.integral_rate, RATE),
                (&j.gap, Mechanism::Length),
            ];
            let relaxation = j.relaxation_stiffness.iter().map(|stiffness| (stiffness, Mechanism::Stiffness));
            own.into_iter().chain(relaxation).chain(of_friction_file(&j.friction)).chain(of_lead_error_file(&j.lead_error))
        });
        let shafts = self.shafts.iter().flat_map(|s| {
            let own = [
                (&s.length_m, Mechanism::Length),
                (&s.diameter_m, Mechanism::Length),
                (&s.youngs_modulus_pa, MODULUS),
                (&s.shear_modulus_pa, MODULUS),
                (&s.density_kg_m3, DENSITY),
            ];
            let bore = s.bore_ratio.iter().map(|ratio| (ratio, Mechanism::Ratio));
            own.into_iter().chain(bore).chain(s.loss_factor.iter().map(|loss| (loss, Mechanism::LossFactor)))
        });
        let bending = self.bending.iter().flat_map(|b| {
            let own = [(&b.eccentricity_m, Mechanism::Length), (&b.lateral_stiffness, Mechanism::Stiffness)];
            let ratios = b.clamping.iter().chain(&b.misalignment).map(|source| (source, Mechanism::Ratio));
            own.into_iter().chain(ratios).chain(b.loss_factor.iter().map(|loss| (loss, Mechanism::LossFactor)))
        });
        let drive = self.drive.iter().flat_map(of_drive_file);
        let mut numbers = inertias.chain(joints).chain(shafts).chain(bending).chain(drive);
        let stated = numbers.find(|(source, _)| source.is_or_contains(id)).map(|(_, mechanism)| mechanism);
        let changes =
            || self.rescales.iter().find(|(_, _, parameter)| parameter == id).map(|(target, how, _)| Mechanism::of_change(target, *how));
        match stated.or_else(changes) {
            // Joints between rotations have waves along an angle.
            Some(Mechanism::Period(PeriodAlong::Travel)) if unit == "rad" => Mechanism::Period(PeriodAlong::Angle),
            Some(mechanism) => mechanism,
            None => Mechanism::of_unit(unit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{JointPatch, PointMotion, PointPatch, Role};

    #[test]
    fn use_decides_before_unit() {
        let of = |id: &str| NumberSource::Parameter(id.into());
        let wave = |period: &str| Some(WaveFile { period: Some(of(period)), ..WaveFile::default() });
        let friction = FrictionForceFile { position: wave("p"), ..FrictionForceFile::default() };
        let patch = Patch {
            points: vec![PointPatch {
                name: "a".into(),
                motion: PointMotion::Translation,
                inertia: of("m"),
                fixed: false,
                role: Role::Described,
            }],
            joints: vec![JointPatch { stiffness: of("m"), damping: of("c"), loss_factor: of("eta"), friction, ..JointPatch::default() }],
            rescales: vec![
                (Target::JointStiffness("nut".into()), Rescale::InSeries, "k".into()),
                (Target::JointStiffness("nut".into()), Rescale::AlongStroke, "slope".into()),
                (Target::Drive("ripple.period".into()), Rescale::Replace, "ripple".into()),
            ],
            ..Patch::default()
        };
        // An inertia from which a stiffness is derived is an inertia; a unit in other words does not matter.
        for (id, unit, expected) in [
            ("m", "tonne", Mechanism::Inertia),
            ("c", "", Mechanism::Damping),
            ("eta", "-", Mechanism::LossFactor),
            ("p", "m", Mechanism::Period(PeriodAlong::Travel)),
            ("p", "rad", Mechanism::Period(PeriodAlong::Angle)),
            ("k", "N/m", Mechanism::Stiffness),
            ("slope", "1", Mechanism::Ratio),
            ("ripple", "m or rad", Mechanism::Period(PeriodAlong::Motor)),
            ("unused", "N*m/rad", Mechanism::Stiffness),
            ("unused", "s", Mechanism::Delay),
            ("unused", "K", Mechanism::Other),
        ] {
            assert_eq!(patch.mechanism_of(id, unit), expected, "{id} in {unit}");
        }
    }
}
