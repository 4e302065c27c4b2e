//! Names of effects, their locations, and the records that can show them.

use crate::effect::Place;
use crate::motion::run::Side;

named! {
    /// Kind of an effect.
    pub enum Effect {
        /// Effects that a diagnosis should name.
        LISTED {
            /// Dry friction that the description omits.
            CoulombFriction = "coulomb-friction",
            /// Viscous friction that the description omits.
            ViscousFriction = "viscous-friction",
            /// Friction falls with speed.
            StribeckFriction = "stribeck-friction",
            /// Friction differs between forward and backward motion.
            FrictionAsymmetry = "friction-asymmetry",
            /// Friction rises over tens of micrometres.
            PreslidingFriction = "presliding-friction",
            /// Friction varies along the travel.
            PositionFriction = "position-friction",
            /// Friction grows with the force through the nut.
            LoadFriction = "load-friction",
            /// Backlash between screw and nut.
            Backlash = "backlash",
            /// A soft coupling.
            DriveFlexibility = "drive-flexibility",
            /// The force follows its demand late, and the scale's reading is late by the same time.
            ControlDelay = "control-delay",
            /// The true force differs from the recorded force.
            ForceGain = "force-gain",
            /// Cogging and ripple of the motor force over the angle.
            TorqueRipple = "torque-ripple",
            /// Error of the screw's lead.
            LeadError = "lead-error",
            /// Thermal expansion of the lead while the screw warms up.
            LeadGrowth = "lead-growth",
            /// The table is heavier or lighter than weighed.
            MovingMass = "moving-mass",
        }
        /// Effects outside the library of the diagnosis.
        UNLISTED {
            /// A cable chain pulls towards one end.
            CableChain = "cable-chain",
            /// A body suspended at the table swings.
            LoadPendulum = "load-pendulum",
            /// Lumps of grease on the guide.
            GreaseLumps = "grease-lumps",
            /// The encoder's reading has a periodic error.
            ScaleCogging = "scale-cogging",
            /// The amplifier has a dead zone for small demands.
            AmplifierDeadZone = "amplifier-dead-zone",
            /// Friction decreases while the oil warms up.
            RunningIn = "running-in",
            /// Wipers creep.
            WiperCreep = "wiper-creep",
        }
    }
}

use Effect::*;

impl Effect {
    /// Pairs of effects that the first records can hardly distinguish.
    pub const LOOK_ALIKES: [(Self, Self); 2] =
        [(Backlash, DriveFlexibility), (ControlDelay, DriveFlexibility)];

    /// Returns the only sensor location that shows the effect, if there is one.
    pub fn side(self) -> Option<Side> {
        match self {
            LeadError | LeadGrowth => Some(Side::Table),
            _ => None,
        }
    }

    /// Whether the effect is identifiable only if the moving mass is weighed.
    pub fn needs_weighing(self) -> bool {
        matches!(self, ForceGain | MovingMass)
    }

    /// Returns the effect that data of one axis cannot distinguish from it, if there is one.
    pub fn indistinguishable_from(self) -> Option<Self> {
        match self {
            ForceGain => Some(MovingMass),
            MovingMass => Some(ForceGain),
            _ => None,
        }
    }

    /// Largest size that is still plausible.
    pub fn largest(self) -> f64 {
        match self {
            DriveFlexibility => 30.0,
            StribeckFriction | FrictionAsymmetry => 4.0,
            PositionFriction => 5.0,
            ControlDelay => 4.0,
            ForceGain | MovingMass => 6.0,
            _ => 12.0,
        }
    }

    /// Whether two listed effects in one machine remain two distinct effects.
    pub fn is_distinct_from(self, other: Self) -> bool {
        let alike = [
            [Backlash, DriveFlexibility],
            [ControlDelay, DriveFlexibility],
            [StribeckFriction, PreslidingFriction],
            [CoulombFriction, ViscousFriction],
            [CoulombFriction, StribeckFriction],
            [CoulombFriction, PreslidingFriction],
            [CoulombFriction, PositionFriction],
            [CoulombFriction, FrictionAsymmetry],
            [ViscousFriction, FrictionAsymmetry],
            [ForceGain, MovingMass],
            [PositionFriction, TorqueRipple],
            [LeadError, LeadGrowth],
        ];
        self != other && !alike.iter().any(|pair| pair.contains(&self) && pair.contains(&other))
    }

    /// Returns the location, in names of the engineer's model.
    pub fn place(self) -> Place {
        let names: &[&str] = match self {
            CoulombFriction | ViscousFriction | StribeckFriction | FrictionAsymmetry | PreslidingFriction
            | PositionFriction => &["table", "guide", "friction"],
            LoadFriction => &["nut", "table", "guide", "friction"],
            Backlash => &["nut", "screw", "table"],
            DriveFlexibility => &["coupling", "screw", "motor", "table"],
            ControlDelay | AmplifierDeadZone => &["drive", "motor", "measurement"],
            ForceGain => &["measurement", "drive", "motor"],
            TorqueRipple => &["motor", "drive"],
            LeadError | LeadGrowth => &["screw", "nut", "measurement"],
            MovingMass | CableChain | LoadPendulum | GreaseLumps | WiperCreep | RunningIn => {
                &["table", "guide", "friction"]
            }
            ScaleCogging => &["measurement", "motor"],
        };
        Place::new(names)
    }
}
