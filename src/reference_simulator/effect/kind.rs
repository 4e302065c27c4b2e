//! Names of effects, where they sit, and which machines can have them.

use serde::{Deserialize, Serialize};

use crate::named::named_effects;

named_effects! {
    /// What kind of effect.
    pub enum EffectKind
    LISTED {
        /// The drive holds the rotor: position and velocity loop with integral action and lag.
        RotorHold = "rotor-hold",
        /// Two bellows hold the table.
        GuideStiffness = "guide-stiffness",
        /// Four wipers brake the table.
        GuideViscous = "guide-viscous",
        /// A workpiece or fixture on the table, or one that is missing.
        TableMass = "table-mass",
        /// The bed shifts and pitches on its mounts.
        BedCompliance = "bed-compliance",
        /// The nut's body moves on its flange.
        NutFlangeCompliance = "nut-flange-compliance",
        /// Preload lost, or too high, along part of the stroke.
        NutStiffnessPosition = "nut-stiffness-position",
        /// One bearing changes with the nut's position.
        BearingStiffnessPosition = "bearing-stiffness-position",
        /// A ring on the hub, or a lighter hub.
        CouplingInertia = "coupling-inertia",
        /// A stage with its own inertia between rotor and coupling.
        DriveFlexibility = "drive-flexibility",
        /// A bored, thinner or thicker screw.
        ScrewDiameter = "screw-diameter",
        /// A screw of lossy material.
        ScrewLossFactor = "screw-loss-factor",
        /// The table pitches and heaves on four carriages.
        TableRocking = "table-rocking",
        /// The screw bends; its nut is loaded off the axis.
        ScrewBending = "screw-bending",
        /// A covering that relaxes, three times over.
        TableRelaxation = "table-relaxation",
        /// All responses too large or too small.
        FrfGain = "frf-gain",
        /// All responses late or early.
        MeasurementDelay = "measurement-delay",
        /// Mobility called receptance, and the like.
        FrfQuantity = "frf-quantity",
    }
    OTHERS {
        /// Nut or guide depends on the force level.
        ContactLevel = "contact-level",
    }
    OUTSIDE {
        /// A hose or cable swings on the table.
        HoseResonator = "hose-resonator",
        /// Velocity feedback that comes late and feeds some frequencies.
        ServoLag = "servo-lag",
        /// A bearing housing gives way.
        HousingTilt = "housing-tilt",
        /// A ring on rubber at the screw's far end.
        RingAbsorber = "ring-absorber",
        /// An unbalanced nut yaws under axial force.
        NutYaw = "nut-yaw",
        /// Guide film with a force of power ½ or 3⁄2 of frequency.
        SqueezedFilm = "squeezed-film",
        /// A support grips the screw away from nut and bearings.
        MiddleSupport = "middle-support",
        /// The right bearing stands on a loose foundation.
        LooseFoot = "loose-foot",
        /// A brake's disc on a soft spline at the rotor.
        BrakeDisc = "brake-disc",
        /// The drive follows the table's scale in part.
        ScaleFeedback = "scale-feedback",
        /// The motor's mass hangs axially on the screw through the coupling.
        MotorThrust = "motor-thrust",
    }
}

/// Where an effect sits, in names of the engineer's model.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// The point, joint or shaft nearest to it; "measurement" for errors of the test.
    pub interface: String,
    /// Every name that is a right answer, the first included.
    pub accepted: Vec<String>,
}

use EffectKind::*;

impl EffectKind {
    /// Whether it occurs with either sign.
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

    /// Whether a machine whose rotor is held by its drive (or is not) can have it.
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

    /// Whether two listed effects can be planted together and stay two effects.
    pub fn joins(self, other: Self) -> bool {
        let alike = [[TableMass, FrfGain], [GuideViscous, TableRelaxation], [CouplingInertia, DriveFlexibility]];
        self != other && !alike.iter().any(|pair| pair.contains(&self) && pair.contains(&other))
    }
}
