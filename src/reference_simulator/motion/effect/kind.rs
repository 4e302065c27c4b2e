//! Names of effects, where they sit, and which records can show them.

use crate::effect::Place;
use crate::motion::run::Side;
use crate::named::named_effects;

named_effects! {
    /// What kind of effect.
    pub enum Effect
    LISTED {
        /// Dry friction that the description leaves out.
        CoulombFriction = "coulomb-friction",
        /// Viscous friction that the description leaves out.
        ViscousFriction = "viscous-friction",
        /// Friction falls with speed.
        StribeckFriction = "stribeck-friction",
        /// Another friction forward than backward.
        FrictionAsymmetry = "friction-asymmetry",
        /// Friction rises over tens of micrometres.
        PreslidingFriction = "presliding-friction",
        /// Friction wanders along the travel.
        PositionFriction = "position-friction",
        /// Friction grows with the force through the nut.
        LoadFriction = "load-friction",
        /// A gap between screw and nut.
        Backlash = "backlash",
        /// A soft coupling.
        DriveFlexibility = "drive-flexibility",
        /// Force late after its demand, and the scale's word as late.
        ControlDelay = "control-delay",
        /// Force other than recorded.
        ForceGain = "force-gain",
        /// Force of the motor over its angle.
        TorqueRipple = "torque-ripple",
        /// Error of the screw's pitch.
        LeadError = "lead-error",
        /// The screw grows while it warms.
        LeadGrowth = "lead-growth",
        /// A table heavier or lighter than weighed.
        MovingMass = "moving-mass",
    }
    OTHERS {}
    OUTSIDE {
        /// A cable chain pulls towards one end.
        CableChain = "cable-chain",
        /// A body swings on the table.
        LoadPendulum = "load-pendulum",
        /// Lumps of grease.
        GreaseLumps = "grease-lumps",
        /// The encoder's signal errs within its period.
        ScaleCogging = "scale-cogging",
        /// The amplifier swallows small demands.
        AmplifierDeadZone = "amplifier-dead-zone",
        /// Friction falls as the oil warms.
        RunningIn = "running-in",
        /// Wipers creep.
        WiperCreep = "wiper-creep",
    }
}

use Effect::*;

impl Effect {
    /// Pairs that the first records hardly tell apart.
    pub const LOOK_ALIKES: [(Self, Self); 2] = [(Backlash, DriveFlexibility), (ControlDelay, DriveFlexibility)];

    /// The side from which alone it can be seen, where there is one.
    pub fn side(self) -> Option<Side> {
        match self {
            LeadError | LeadGrowth => Some(Side::Table),
            _ => None,
        }
    }

    /// Whether it can be seen only if the moving mass has been weighed.
    pub fn needs_weighing(self) -> bool {
        matches!(self, ForceGain | MovingMass)
    }

    /// The effect that the data of one axis never tell apart from it.
    pub fn twin(self) -> Option<Self> {
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

    /// Whether two listed effects can be planted together and stay two effects.
    pub fn joins(self, other: Self) -> bool {
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

    /// Where it sits, in names of the engineer's model.
    pub fn place(self) -> Place {
        let names: &[&str] = match self {
            CoulombFriction | ViscousFriction | StribeckFriction | FrictionAsymmetry | PreslidingFriction | PositionFriction => {
                &["table", "guide", "friction"]
            }
            LoadFriction => &["nut", "table", "guide", "friction"],
            Backlash => &["nut", "screw", "table"],
            DriveFlexibility => &["coupling", "screw", "motor", "table"],
            ControlDelay | AmplifierDeadZone => &["drive", "motor", "measurement"],
            ForceGain => &["measurement", "drive", "motor"],
            TorqueRipple => &["motor", "drive"],
            LeadError | LeadGrowth => &["screw", "nut", "measurement"],
            MovingMass | CableChain | LoadPendulum | GreaseLumps | WiperCreep | RunningIn => &["table", "guide", "friction"],
            ScaleCogging => &["measurement", "motor"],
        };
        Place { interface: names[0].to_owned(), accepted: names.iter().map(|name| (*name).to_owned()).collect() }
    }
}
