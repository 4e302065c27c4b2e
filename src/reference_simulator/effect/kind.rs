//! Names of effects, their locations, and the machines that can have them.

use serde::{Deserialize, Serialize};

named! {
    /// Kind of an effect.
    pub enum EffectKind {
        /// Effects that a diagnosis should name.
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
        /// Effects of other rules: one of the library on request only, one outside it on machines of layouts
        /// only.
        OTHERS {
            /// Nut or guide stiffness depends on the force level.
            ContactLevel = "contact-level",
            /// A mass that dry friction holds on the table: it gives way at the amplitude of the blows.
            /// Outside the library.
            FrictionDamper = "friction-damper",
        }
        /// Effects outside the library of the diagnosis.
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
}

/// Location of an effect, in names of the engineer's model.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// The point, joint or shaft nearest to the effect; "measurement" for errors of the test.
    pub interface: String,
    /// All names that count as correct, including the first.
    pub accepted: Vec<String>,
}

impl Place {
    /// Creates a location from its names, the nearest first.
    pub fn new(names: &[&str]) -> Self {
        Self {
            interface: names[0].to_owned(),
            accepted: names.iter().map(|name| (*name).to_owned()).collect(),
        }
    }
}

use EffectKind::*;

impl EffectKind {
    /// Limits of the plausible size times sign; negative where both signs occur.
    fn sizes(self) -> [f64; 2] {
        match self {
            RotorHold | GuideStiffness | GuideViscous | TableRelaxation | SqueezedFilm => [0.0, 30.0],
            TableMass | MeasurementDelay | FrfGain => [-6.0, 6.0],
            NutStiffnessPosition | BearingStiffnessPosition => [-3.0, 3.0],
            TableRocking | ContactLevel => [-8.0, 8.0],
            CouplingInertia => [-1.6, 1.6],
            ScaleFeedback => [0.0, 1.6],
            ScrewDiameter => [-2.4, 2.4],
            ScrewLossFactor => [0.0, 5.0],
            FrfQuantity => [-1.0, 1.0],
            ServoLag => [0.0, 2.0],
            _ => [0.0, 8.0],
        }
    }

    /// Whether it occurs with both signs.
    pub fn is_two_sided(self) -> bool {
        self.sizes()[0] < 0.0
    }

    /// Largest size that is still plausible.
    pub fn largest(self) -> f64 {
        self.sizes()[1]
    }

    /// Whether the effect is possible on a machine whose drive does (or does not) hold the rotor.
    pub fn fits(self, rotor_held: bool) -> bool {
        match self {
            RotorHold => !rotor_held,
            ServoLag | ScaleFeedback => rotor_held,
            _ => true,
        }
    }

    /// Whether two listed effects in one machine remain two distinct effects.
    pub fn is_distinct_from(self, other: Self) -> bool {
        let alike =
            [[TableMass, FrfGain], [GuideViscous, TableRelaxation], [CouplingInertia, DriveFlexibility]];
        self != other && !alike.iter().any(|pair| pair.contains(&self) && pair.contains(&other))
    }
}
