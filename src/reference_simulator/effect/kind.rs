//! Names of effects, where they sit, and which machines can have them.

use serde::{Deserialize, Serialize};

/// What kind of effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EffectKind {
    /// The drive holds the rotor: position and velocity loop with integral action and lag.
    RotorHold,
    /// Two bellows hold the table.
    GuideStiffness,
    /// Four wipers brake the table.
    GuideViscous,
    /// A workpiece or fixture on the table, or one that is missing.
    TableMass,
    /// The bed shifts and pitches on its mounts.
    BedCompliance,
    /// The nut's body moves on its flange.
    NutFlangeCompliance,
    /// Preload lost, or too high, along part of the stroke.
    NutStiffnessPosition,
    /// One bearing changes with the nut's position.
    BearingStiffnessPosition,
    /// A ring on the hub, or a lighter hub.
    CouplingInertia,
    /// A stage with its own inertia between rotor and coupling.
    DriveFlexibility,
    /// A bored, thinner or thicker screw.
    ScrewDiameter,
    /// A screw of lossy material.
    ScrewLossFactor,
    /// The table pitches and heaves on four carriages.
    TableRocking,
    /// The screw bends; its nut is loaded off the axis.
    ScrewBending,
    /// A covering that relaxes, three times over.
    TableRelaxation,
    /// All responses too large or too small.
    FrfGain,
    /// All responses late or early.
    MeasurementDelay,
    /// Mobility called receptance, and the like.
    FrfQuantity,
    /// Nut or guide depends on the force level.
    ContactLevel,
    /// A hose or cable swings on the table.
    HoseResonator,
    /// Velocity feedback that comes late and feeds some frequencies.
    ServoLag,
    /// A bearing housing gives way.
    HousingTilt,
    /// A ring on rubber at the screw's far end.
    RingAbsorber,
    /// An unbalanced nut yaws under axial force.
    NutYaw,
    /// Guide film with a force of power ½ or 3⁄2 of frequency.
    SqueezedFilm,
    /// A support grips the screw away from nut and bearings.
    MiddleSupport,
    /// The right bearing stands on a loose foundation.
    LooseFoot,
    /// A brake's disc on a soft spline at the rotor.
    BrakeDisc,
    /// The drive follows the table's scale in part.
    ScaleFeedback,
    /// The motor's mass hangs axially on the screw through the coupling.
    MotorThrust,
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
    /// Effects that a diagnosis is expected to know by name.
    pub const LISTED: [Self; 18] = [
        RotorHold,
        GuideStiffness,
        GuideViscous,
        TableMass,
        BedCompliance,
        NutFlangeCompliance,
        NutStiffnessPosition,
        BearingStiffnessPosition,
        CouplingInertia,
        DriveFlexibility,
        ScrewDiameter,
        ScrewLossFactor,
        TableRocking,
        ScrewBending,
        TableRelaxation,
        FrfGain,
        MeasurementDelay,
        FrfQuantity,
    ];

    /// Effects outside every list.
    pub const OUTSIDE: [Self; 11] = [
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
    ];

    /// Identifier.
    pub fn id(self) -> &'static str {
        match self {
            RotorHold => "rotor-hold",
            GuideStiffness => "guide-stiffness",
            GuideViscous => "guide-viscous",
            TableMass => "table-mass",
            BedCompliance => "bed-compliance",
            NutFlangeCompliance => "nut-flange-compliance",
            NutStiffnessPosition => "nut-stiffness-position",
            BearingStiffnessPosition => "bearing-stiffness-position",
            CouplingInertia => "coupling-inertia",
            DriveFlexibility => "drive-flexibility",
            ScrewDiameter => "screw-diameter",
            ScrewLossFactor => "screw-loss-factor",
            TableRocking => "table-rocking",
            ScrewBending => "screw-bending",
            TableRelaxation => "table-relaxation",
            FrfGain => "frf-gain",
            MeasurementDelay => "measurement-delay",
            FrfQuantity => "frf-quantity",
            ContactLevel => "contact-level",
            HoseResonator => "hose-resonator",
            ServoLag => "servo-lag",
            HousingTilt => "housing-tilt",
            RingAbsorber => "ring-absorber",
            NutYaw => "nut-yaw",
            SqueezedFilm => "squeezed-film",
            MiddleSupport => "middle-support",
            LooseFoot => "loose-foot",
            BrakeDisc => "brake-disc",
            ScaleFeedback => "scale-feedback",
            MotorThrust => "motor-thrust",
        }
    }

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
