//! What the parameters of a patch are used for: the mechanism of each.

use super::number::{BENDING, CURRENT, DRIVE, JOINT, MOTOR, POINT, SHAFT, stated_in};
use super::{Mechanism, Number, NumberSource, Patch, PeriodAlong, Rescale, Target};

impl NumberSource {
    /// Whether the number is a parameter, or a series of springs with the parameter among them.
    fn is_or_contains(&self, id: &str) -> bool {
        match self {
            NumberSource::Parameter(own) => own == id,
            NumberSource::Series(of) => of.series.iter().any(|spring| spring.is_or_contains(id)),
            NumberSource::Number(_)
            | NumberSource::Contact(_)
            | NumberSource::Segment(_)
            | NumberSource::Times(..) => false,
        }
    }
}

impl Rescale {
    /// Returns the mechanism of a parameter that changes a number in this way.
    fn mechanism(self, target: &Target) -> Mechanism {
        match self {
            Rescale::Replace | Rescale::InSeries | Rescale::Added | Rescale::Less => Number::all()
                .find(|number| target.selects(number))
                .map_or(Mechanism::Other, |number| number.quantity.mechanism),
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

impl Patch {
    /// Returns the mechanism of a parameter by its first use in the patch, else by its unit. Inertias come
    /// first: a stiffness may be derived from one.
    pub fn mechanism_of(&self, id: &str, unit: &str) -> Mechanism {
        let points = self.points.iter().flat_map(|file| stated_in(POINT, file));
        let joints = self.joints.iter().flat_map(|file| stated_in(JOINT, file));
        let shafts = self.shafts.iter().flat_map(|file| stated_in(SHAFT, file));
        let bending = self.bending.iter().flat_map(|file| stated_in(BENDING, file));
        let drive = self.drive.iter().flat_map(|file| {
            let motor = file.motor.iter().flat_map(|file| stated_in(MOTOR, file));
            stated_in(DRIVE, file)
                .chain(motor)
                .chain(file.current.iter().flat_map(|file| stated_in(CURRENT, file)))
        });
        let mut numbers = points.chain(joints).chain(shafts).chain(bending).chain(drive);
        let stated = numbers
            .find(|(_, source)| source.is_or_contains(id))
            .map(|(number, _)| number.quantity.mechanism);
        let changes = || {
            self.rescales
                .iter()
                .find(|(.., parameter)| parameter == id)
                .map(|(target, how, _)| how.mechanism(target))
        };
        match stated.or_else(changes) {
            // Joints between rotations have waves along an angle.
            Some(Mechanism::Period(PeriodAlong::Travel)) if unit == "rad" => {
                Mechanism::Period(PeriodAlong::Angle)
            }
            Some(mechanism) => mechanism,
            None => Mechanism::of_unit(unit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FrictionForceFile, JointPatch, PointMotion, PointPatch, Role, TargetKind, WaveFile};

    #[test]
    fn use_decides_before_unit() {
        let of = |id: &str| NumberSource::Parameter(id.into());
        let wave = |period: &str| WaveFile { period: Some(of(period)), ..WaveFile::default() };
        let friction = FrictionForceFile { position: wave("p"), ..FrictionForceFile::default() };
        let patch = Patch {
            points: vec![PointPatch {
                name: "a".into(),
                motion: PointMotion::Translation,
                inertia: of("m"),
                fixed: false,
                role: Role::Described,
            }],
            joints: vec![JointPatch {
                stiffness: of("m"),
                damping: of("c"),
                loss_factor: of("eta"),
                friction,
                ..JointPatch::default()
            }],
            rescales: vec![
                (TargetKind::JointStiffness.of("nut"), Rescale::InSeries, "k".into()),
                (TargetKind::JointStiffness.of("nut"), Rescale::AlongStroke, "slope".into()),
                (
                    Target { key: "ripple.period".into(), ..TargetKind::Drive.of("") },
                    Rescale::Replace,
                    "ripple".into(),
                ),
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
