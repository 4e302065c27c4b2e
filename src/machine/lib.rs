//! The description of a machine, from which every model is built.
//!
//! A machine consists of **points** (one coordinate each, a translation or a rotation) and **shafts**
//! (uniform rods between stations, axial and torsional). **Joints** are spring–dampers on a combination of
//! points. **Parameters** are the unknown numbers, each with unit, plausible range and source. Joints may
//! have friction and backlash, and a **drive** may move the machine; both affect motion, not frequency
//! responses. An **effect** is a patch of such a description: additional points, joints and parameters, or
//! modifiers of values.

mod added_part;
mod bending;
mod check;
mod compose;
pub mod contact;
mod coordinates;
mod derived;
mod description;
mod drive;
mod effect;
mod effect_ids;
mod error;
mod friction;
mod joint;
mod loaded_pair;
mod measuring_chain;
mod mechanism;
mod motion;
mod motor;
mod number;
mod operating_condition;
mod parameter;
mod parameter_use;
mod patch;
mod point;
mod quantity;
mod role;
mod schema;
mod segment;
mod shaft;
mod source;
mod state;
mod target;
mod target_kind;
mod tolerance;
mod value;

pub use added_part::{JointPatch, LeverFile, PointPatch, ShaftFile};
pub use bending::{Bending, BendingFile};
pub use coordinates::{ParameterValues, UnitValues};
pub use derived::{Derivation, Derived, DerivedPatch};
pub use drive::{Drive, DriveFile, Encoder, PositionLoop, Tachometry, VelocityLoop};
pub use effect::{AttachFile, Data, Effect, Patch, ReattachFile};
pub use effect_ids::EffectIds;
pub use error::MachineError;
pub use friction::{Friction, FrictionForceFile, FrictionTable, LeadError, LeadErrorFile, Wave, WaveFile};
pub use joint::Joint;
pub use loaded_pair::{LoadedPair, PairState, ScrewEnd};
pub use measuring_chain::{Chain, Lever};
pub use mechanism::{Mechanism, PeriodAlong};
pub use motor::{CurrentFile, CurrentLoop, Inverter, Motor, MotorFile};
pub use number::{Number, Range, Reach};
pub use operating_condition::{Operating, OperatingVariable};
pub use parameter::{FitRule, Parameter, Prior, Scale};
pub use point::{GROUND, Point, PointMotion};
pub use quantity::{Magnitude, Quantity};
pub use role::Role;
pub use segment::{Segment, SegmentEnd, Twist};
pub use shaft::{Shaft, Station, StationPlace};
pub use source::NumberSource;
pub use state::State;
pub use target::{Rescale, Target};
pub use target_kind::TargetKind;
pub use tolerance::{Estimate, Tolerance};
pub use value::{Base, Modifier, Value};

use std::sync::Arc;

/// A checked machine description: all names are resolved and all ranges are valid.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Title for display.
    pub title: String,
    /// Coordinates; joints and shafts refer to them by index.
    pub points: Vec<Point>,
    /// Uniform rods.
    pub shafts: Vec<Shaft>,
    /// Spring–dampers.
    pub joints: Vec<Joint>,
    /// The drive, if described.
    pub drive: Option<Drive>,
    /// Contacts that joints refer to.
    pub contacts: Vec<Arc<LoadedPair>>,
    /// Screw segments that joints refer to.
    pub segments: Vec<Arc<Segment>>,
    /// The measuring chain of its FRFs.
    pub chain: Chain,
    /// Quantities that follow from the parameters and are reported with them.
    pub derived: Vec<Derived>,
    /// Unknown numbers; values refer to them by index.
    pub parameters: Vec<Parameter>,
    /// Ids of the effects the description contains.
    pub effects: Vec<String>,
    /// Stiffness-proportional damping b of every joint, c = b·k (s), in addition to the joint's own damping;
    /// 0 for none.
    ///
    /// # Source  lumped servo-axis paper: B = b·K with b = 2ζ/ω₁.
    pub stiffness_proportional_damping_s: f64,
    /// Share s of dispersion of all loss factors η: k is multiplied by 1 + η·(i + s·2/π·ln(ω/ω₀)), ω₀ =
    /// 2π·100 rad/s. s = 0 is the constant k·(1 + iη) of finite-element programs, s = 1 the causal form.
    ///
    /// # Source  constant: Beards, Structural Vibration, 1996, ch. 5; causal: Makris, J. Eng. Mech. 123
    ///   (1997) 1209–1214.
    pub loss_dispersion: Value,
    /// Tolerances of the stated numbers.
    pub tolerance: Tolerance,
    /// Tolerances held at estimates, each with what is known of it: start value and prior. Those without a
    /// prior are exact.
    pub held: Vec<Parameter>,
}

impl Default for Machine {
    fn default() -> Self {
        let tolerance = Tolerance::default();
        Machine {
            title: String::new(),
            points: Vec::new(),
            shafts: Vec::new(),
            joints: Vec::new(),
            drive: None,
            contacts: Vec::new(),
            segments: Vec::new(),
            chain: Chain::default(),
            derived: Vec::new(),
            parameters: Vec::new(),
            effects: Vec::new(),
            stiffness_proportional_damping_s: 0.0,
            loss_dispersion: Value::number(tolerance.loss_dispersion),
            tolerance,
            held: Vec::new(),
        }
    }
}

impl Machine {
    /// Returns the index of a point by name.
    pub fn point(&self, name: &str) -> Option<usize> {
        self.points.iter().position(|p| p.name == name)
    }

    /// Returns the index of a parameter by id.
    pub fn parameter(&self, id: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.id == id)
    }

    /// Returns the start values of all parameters, in order, each in its own unit.
    pub fn start(&self) -> ParameterValues {
        ParameterValues(self.parameters.iter().map(|p| p.start).collect())
    }

    /// Returns the length (m) of the shaft or segment that carries the nut, which is the range of nut
    /// positions. `None` without such a part.
    pub fn stroke_m(&self) -> Option<f64> {
        let start = self.start();
        let shaft = self.shafts.iter().find(|s| s.stations.iter().any(|t| t.place == StationPlace::Nut));
        shaft
            .map(|s| s.length.at(&start, &Operating::default()))
            .or_else(|| self.segments.first().map(|s| s.length_m))
    }
}
