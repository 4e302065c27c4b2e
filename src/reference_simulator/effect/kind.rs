//! Names of effects, their locations, and the machines that can have them.

use serde::{Deserialize, Serialize};

use crate::named::named_effects;

named_effects! {
    /// Kind of an effect.
    pub enum EffectKind
    LISTED {
        /// The drive holds the rotor: position and velocity loop with integral action and lag.
        RotorHold = "rotor-hold",
        /// Two bellows hold the table.
        GuideStiffness = "guide-stiffness",
        /// Four wipers brake the table.
        GuideViscous = "guide-viscous",
        /// A workpiece or fixture on the table that the description lacks, or one that it has in excess.
        TableMass = "table-mass",
        /// The bed shifts and pitches on its mounts.
        BedCompliance = "bed-compliance",
        /// The nut body moves on its flange.
        NutFlangeCompliance = "nut-flange-compliance",
        /// Preload is too low or too high along part of the stroke.
        NutStiffnessPosition = "nut-stiffness-position",
        /// The stiffness of one bearing depends on the nut position.
        BearingStiffnessPosition = "bearing-stiffness-position",
        /// A ring on the hub, or a lighter hub.
        CouplingInertia = "coupling-inertia",
        /// A stage with its own inertia between rotor and coupling.
        DriveFlexibility = "drive-flexibility",
        /// A bored, thinner or thicker screw.
        ScrewDiameter = "screw-diameter",
        /// A screw with material loss.
        ScrewLossFactor = "screw-loss-factor",
        /// The table pitches and heaves on four carriages.
        TableRocking = "table-rocking",
        /// The screw bends, and its nut is loaded off the axis.
        ScrewBending = "screw-bending",
        /// A viscoelastic cover of the table with three relaxation times.
        TableRelaxation = "table-relaxation",
        /// All responses are too large or too small by one factor.
        FrfGain = "frf-gain",
        /// All responses are late or early by one delay.
        MeasurementDelay = "measurement-delay",
        /// The manifest states a wrong quantity, for example receptance for mobility.
        FrfQuantity = "frf-quantity",
    }
    OTHERS {
        /// Nut or guide stiffness depends on the force level.
        ContactLevel = "contact-level",
        /// A mass that dry friction holds on the table: it gives way at the amplitude of the blows. Outside the library.
        FrictionDamper = "friction-damper",
    }
    UNLISTED {
        /// A hose or cable swings on the table.
        HoseResonator = "hose-resonator",
        /// Delayed velocity feedback, which feeds energy in at some frequencies.
        ServoLag = "servo-lag",
        /// A bearing housing is compliant.
        HousingTilt = "housing-tilt",
        /// A ring on rubber at the screw's far end.
        RingAbsorber = "ring-absorber",
        /// An unbalanced nut yaws under axial force.
        NutYaw = "nut-yaw",
        /// Guide film with a force of power ½ or 3⁄2 in frequency.
        SqueezedFilm = "squeezed-film",
        /// A support holds the screw away from nut and bearings.
        MiddleSupport = "middle-support",
        /// The right bearing stands on a loose foundation.
        LooseFoot = "loose-foot",
        /// A brake disc on a soft spline at the rotor.
        BrakeDisc = "brake-disc",
        /// The drive feeds back the table scale in part.
        ScaleFeedback = "scale-feedback",
        /// The motor mass is suspended axially on the screw through the coupling.
        MotorThrust = "motor-thrust",
    }
}

/// Location of an effect, in names of the engineer's model.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// The point, joint or shaft nearest to the effect; "measurement" for errors of the test.
    pub interface: String,
    /// All names that count as correct, including the first.
    pub accepted: Vec<String>,
}

use EffectKind::*;

impl EffectKind {
    /// Effects outside the library on machines of all layouts.
    pub const OUTSIDE: [Self; 12] = [
        HoseResonator,
        ServoLag,
        HousingTilt,
        RingAbsorber,
        NutYaw,
        SqueezedFilm,
        MiddleSupport,
        LooseFoot,
        BrakeDisc,
        ScaleFeedback,
        MotorThrust,
        FrictionDamper,
    ];

    /// Whether it occurs with both signs.
    pub fn is_two_sided(self) -> bool {
        matches!(
            self,
            TableMass
                | NutStiffnessPosition
                | BearingStiffnessPosition
                | CouplingInertia
                | ScrewDiameter
                | TableRocking
                | FrfGain
                | MeasurementDelay
                | FrfQuantity
                | ContactLevel
        )
    }

    /// Whether the effect is possible on a machine whose drive does (or does not) hold the rotor.
    pub fn fits(self, rotor_held: bool) -> bool {
        match self {
            RotorHold => !rotor_held,
            ServoLag | ScaleFeedback => rotor_held,
            _ => true,
        }
    }

    /// Largest size that is still plausible.
    pub fn largest(self) -> f64 {
        match self {
            RotorHold | GuideStiffness | GuideViscous | TableRelaxation | SqueezedFilm => 30.0,
            TableMass | MeasurementDelay | FrfGain => 6.0,
            CouplingInertia | ScaleFeedback => 1.6,
            NutStiffnessPosition | BearingStiffnessPosition => 3.0,
            ScrewDiameter => 2.4,
            ScrewLossFactor => 5.0,
            FrfQuantity => 1.0,
            ServoLag => 2.0,
            _ => 8.0,
        }
    }

    /// Whether two listed effects in one machine remain two distinct effects.
    pub fn is_distinct_from(self, other: Self) -> bool {
        let alike = [[TableMass, FrfGain], [GuideViscous, TableRelaxation], [CouplingInertia, DriveFlexibility]];
        self != other && !alike.iter().any(|pair| pair.contains(&self) && pair.contains(&other))
    }
}
