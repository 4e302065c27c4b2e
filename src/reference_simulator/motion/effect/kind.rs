//! Names of effects, where they sit, and which records can show them.

use serde::{Deserialize, Serialize};

use crate::effect::Place;
use crate::motion::run::Side;

/// What kind of effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// Dry friction that the description leaves out.
    CoulombFriction,
    /// Viscous friction that the description leaves out.
    ViscousFriction,
    /// Friction falls with speed.
    StribeckFriction,
    /// Another friction forward than backward.
    FrictionAsymmetry,
    /// Friction rises over tens of micrometres.
    PreslidingFriction,
    /// Friction wanders along the travel.
    PositionFriction,
    /// Friction grows with the force through the nut.
    LoadFriction,
    /// A gap between screw and nut.
    Backlash,
    /// A soft coupling.
    DriveFlexibility,
    /// Force late after its demand, and the scale's word as late.
    ControlDelay,
    /// Force other than recorded.
    ForceGain,
    /// Force of the motor over its angle.
    TorqueRipple,
    /// Error of the screw's pitch.
    LeadError,
    /// The screw grows while it warms.
    LeadGrowth,
    /// A table heavier or lighter than weighed.
    MovingMass,
    /// A cable chain pulls towards one end.
    CableChain,
    /// A body swings on the table.
    LoadPendulum,
    /// Lumps of grease.
    GreaseLumps,
    /// The encoder's signal errs within its period.
    ScaleCogging,
    /// The amplifier swallows small demands.
    AmplifierDeadZone,
    /// Friction falls as the oil warms.
    RunningIn,
    /// Wipers creep.
    WiperCreep,
}

use Effect::*;

impl Effect {
    /// Effects that a diagnosis is expected to know by name.
    pub const LISTED: [Self; 15] = [
        CoulombFriction,
        ViscousFriction,
        StribeckFriction,
        FrictionAsymmetry,
        PreslidingFriction,
        PositionFriction,
        LoadFriction,
        Backlash,
        DriveFlexibility,
        ControlDelay,
        ForceGain,
        TorqueRipple,
        LeadError,
        LeadGrowth,
        MovingMass,
    ];

    /// Effects outside every list.
    pub const OUTSIDE: [Self; 7] = [CableChain, LoadPendulum, GreaseLumps, ScaleCogging, AmplifierDeadZone, RunningIn, WiperCreep];

    /// Pairs that the first records hardly tell apart.
    pub const LOOK_ALIKES: [(Self, Self); 2] = [(Backlash, DriveFlexibility), (ControlDelay, DriveFlexibility)];

    /// Identifier.
    pub fn id(self) -> &'static str {
        match self {
            CoulombFriction => "coulomb-friction",
            ViscousFriction => "viscous-friction",
            StribeckFriction => "stribeck-friction",
            FrictionAsymmetry => "friction-asymmetry",
            PreslidingFriction => "presliding-friction",
            PositionFriction => "position-friction",
            LoadFriction => "load-friction",
            Backlash => "backlash",
            DriveFlexibility => "drive-flexibility",
            ControlDelay => "control-delay",
            ForceGain => "force-gain",
            TorqueRipple => "torque-ripple",
            LeadError => "lead-error",
            LeadGrowth => "lead-growth",
            MovingMass => "moving-mass",
            CableChain => "cable-chain",
            LoadPendulum => "load-pendulum",
            GreaseLumps => "grease-lumps",
            ScaleCogging => "scale-cogging",
            AmplifierDeadZone => "amplifier-dead-zone",
            RunningIn => "running-in",
            WiperCreep => "wiper-creep",
        }
    }

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
