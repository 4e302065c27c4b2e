//! Patches: what a description, or an effect, adds to a machine.
//!
//! A machine's own description is a patch of the empty machine; an effect is a patch of a machine.
//! A patch names points, shafts and joints; [`Machine::with`](super::Machine::with) resolves the names. Its parts that are read as a configuration
//! file writes them are called …File, as what is said of a wrong one calls them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::check::{MachineError, fault};
use super::{
    DerivedPatch, DriveFile, FrictionForceFile, LeadErrorFile, LoadedPair, Machine, NumberSource, OperatingVariable, Parameter,
    PointMotion, Rescale, Segment, StationPlace, Target,
};

/// A point a patch adds.
#[derive(Debug, Clone, PartialEq)]
pub struct PointPatch {
    /// Unique name.
    pub name: String,
    /// Displacement or angle.
    pub motion: PointMotion,
    /// Mass (kg) or moment of inertia (kg·m²).
    pub inertia: NumberSource,
    /// Held to the ground.
    pub fixed: bool,
}

/// A shaft.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShaftFile {
    pub(super) name: String,
    pub(super) length_m: NumberSource,
    pub(super) diameter_m: NumberSource,
    /// Bore over diameter of a hollow shaft; solid where it is absent.
    pub(super) bore_ratio: Option<NumberSource>,
    pub(super) youngs_modulus_pa: NumberSource,
    pub(super) shear_modulus_pa: NumberSource,
    pub(super) density_kg_m3: NumberSource,
    /// η of the material: moduli times 1 + η·(i + s·2/π·ln(ω/ω₀)), as of a joint.
    pub(super) loss_factor: Option<NumberSource>,
    pub(super) station: Vec<StationFile>,
}

#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StationFile {
    at: Option<PlaceName>,
    at_m: Option<f64>,
    pub(super) axial: Option<String>,
    pub(super) torsion: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "PlaceFile", rename_all = "lowercase")]
enum PlaceName {
    Start,
    Nut,
    End,
}

impl ShaftFile {
    /// The places of its stations.
    ///
    /// # Errors  one says neither or both of name and distance.
    pub fn places(&self) -> Result<Vec<StationPlace>, MachineError> {
        let place = |station: &StationFile| match (station.at, station.at_m) {
            (Some(PlaceName::Start), None) => Ok(StationPlace::At(0.0)),
            (Some(PlaceName::Nut), None) => Ok(StationPlace::Nut),
            (Some(PlaceName::End), None) => Ok(StationPlace::End),
            (None, Some(distance_m)) => Ok(StationPlace::At(distance_m)),
            _ => {
                let mend = "write either at = \"start\", \"nut\" or \"end\", or at_m = a distance";
                Err(fault(format!("shaft.{}.station", self.name), mend))
            }
        };
        self.station.iter().map(place).collect()
    }
}

/// A joint a patch adds; fields as in [`Joint`](super::Joint).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointPatch {
    /// Unique name.
    pub name: String,
    /// Point names and coefficients.
    pub on: Vec<(String, f64)>,
    /// Points that must move alike: all translations, or all rotations.
    pub alike: Vec<String>,
    /// Points that must be angles.
    pub angles: Vec<String>,
    /// k.
    pub stiffness: NumberSource,
    /// c.
    pub damping: NumberSource,
    /// η.
    pub loss_factor: NumberSource,
    /// ω_i.
    pub integral_rate: NumberSource,
    /// Stiffness in series with the damper.
    pub relaxation_stiffness: Option<NumberSource>,
    /// Friction.
    pub friction: FrictionForceFile,
    /// Play.
    pub gap: NumberSource,
    /// Error of the lead.
    pub lead_error: LeadErrorFile,
}

impl Effect {
    /// Effects of which a kind of data is to be asked: of those with one id, which are for machines described in different words, what is for other data
    /// is left out.
    pub fn for_data(effects: &[Effect], data: Data) -> impl Iterator<Item = &Effect> {
        let shows = move |e: &Effect| e.data.contains(&data);
        effects.iter().filter(move |e| shows(e) || !effects.iter().any(|other| other.id == e.id && shows(other)))
    }

    /// The effect of an id that a machine was put together with: of those with one id, which are for machines described in different words, the one whose
    /// parameters it has.
    pub fn put_in<'e>(effects: &'e [Effect], id: &str, machine: &Machine) -> Option<&'e Effect> {
        let has = |e: &Effect| e.patch.parameters.iter().all(|p| machine.parameter(&p.id).is_some());
        effects.iter().find(|e| e.id == id && has(e))
    }

    /// Where it sits: points, joints and shafts that it changes, each with the parameter by which, where there is one; else where it adds joints;
    /// «drive» and «measurement» for what is none.
    pub fn places(&self) -> Vec<(String, Option<String>)> {
        if let Some(at) = &self.at {
            return vec![(at.clone(), None)];
        }
        let Patch { points, joints, rescales, reattached, attached, .. } = &self.patch;
        let is_new = |name: &str| points.iter().any(|p| p.name == name) || joints.iter().any(|j| j.name == name);
        let scaled = rescales.iter().map(|(target, _, parameter)| (target.part().to_string(), Some(parameter.clone())));
        let moved = reattached.iter().map(|r| &r.joint).chain(attached.iter().map(|a| &a.joint)).map(|joint| (joint.clone(), None));
        let on = joints.iter().flat_map(|joint| joint.on.iter().map(|(point, _)| (point.clone(), None)));
        let changed: Vec<_> = scaled.chain(moved).filter(|(name, _)| !is_new(name)).collect();
        if changed.is_empty() { on.filter(|(name, _)| !is_new(name)).collect() } else { changed }
    }

    /// The first of them.
    pub fn place(&self) -> Option<String> {
        self.places().into_iter().next().map(|(place, _)| place)
    }

    /// What must differ between data for the effect to show, where it is a change with the operating condition.
    pub fn circumstance(&self) -> Option<OperatingVariable> {
        self.patch.rescales.iter().find_map(|(_, rescale, _)| match rescale {
            Rescale::WithForceLevel => Some(OperatingVariable::ForceLevel),
            Rescale::WithSpeed => Some(OperatingVariable::Speed),
            Rescale::WithAcceleration => Some(OperatingVariable::Acceleration),
            _ => None,
        })
    }
}

/// What a description, or an effect, adds to a machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patch {
    /// Points it adds.
    pub points: Vec<PointPatch>,
    /// Shafts it adds.
    pub shafts: Vec<ShaftFile>,
    /// Joints it adds.
    pub joints: Vec<JointPatch>,
    /// The drive, where it describes one.
    pub drive: Option<DriveFile>,
    /// Contacts it describes, to be used as stiffnesses.
    pub contacts: Vec<LoadedPair>,
    /// Screw segments it describes, to be used as stiffnesses.
    pub segments: Vec<Segment>,
    /// Parameters it adds. One that the machine has already (by id) is kept as the machine has it.
    pub parameters: Vec<Parameter>,
    /// Numbers it scales: which, how, by which parameter.
    pub rescales: Vec<(Target, Rescale, String)>,
    /// Joints that act on one point (or the ground) and from now on act on another.
    pub reattached: Vec<ReattachFile>,
    /// Points that joints act on from now on, too.
    pub attached: Vec<AttachFile>,
    /// Arms on which sensor and hammer sit.
    pub levers: Vec<LeverFile>,
    /// Quantities to be reported, by name.
    pub derived: BTreeMap<String, DerivedPatch>,
}

/// A joint that acts on one point (or the ground) and from now on on another.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "")]
pub struct ReattachFile {
    pub(super) joint: String,
    pub(super) from: String,
    pub(super) to: String,
}

/// A point that a joint acts on from now on, too.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "")]
pub struct AttachFile {
    pub(super) joint: String,
    pub(super) to: String,
    pub(super) times: f64,
}

/// An arm on which sensor and hammer sit.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeverFile {
    /// The point at which the data are said to be taken.
    pub(super) at: String,
    /// The point whose motion is felt there, too.
    pub(super) with: String,
    /// How much of it the sensor feels.
    pub(super) read: NumberSource,
    /// How much of it the hammer drives.
    pub(super) struck: NumberSource,
}

/// Kinds of data that an effect can show in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "DataFile", rename_all = "lowercase")]
#[schemars(description = "Kinds of data.")]
pub enum Data {
    /// FRFs and modes.
    Frf,
    /// Time records of a driven axis.
    #[schemars(description = "Time records.")]
    Motion,
}

/// An effect: a named patch and what a person should know of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// Id, for example `rotor-hold`.
    pub id: String,
    /// One sentence for the user.
    pub description: String,
    /// What it looks like in measurements, where that was written down.
    pub signature: Option<String>,
    /// The measurement that tells it from its look-alikes, where that was written down.
    pub discriminating_test: Option<String>,
    /// Effects (ids) that force and one encoder do not tell it from.
    pub confusable_with: Vec<String>,
    /// Effects (ids) that no motion tells it from in which inertia takes next to no force.
    pub confusable_with_slow: Vec<String>,
    /// Of what it does to motion machines have a little ordinarily: it takes more of it to be named.
    pub common: bool,
    /// The points, joints or shafts a machine must have for it to apply, by name; «drive» stands for its drive.
    pub needs: Vec<String>,
    /// Where it sits in a person's eyes, where that is not what it changes first.
    pub at: Option<String>,
    /// Data it can show in.
    pub data: Vec<Data>,
    /// What it adds.
    pub patch: Patch,
}
