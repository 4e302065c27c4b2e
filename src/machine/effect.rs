//! Patches: the additions of a description, or of an effect, to a machine.
//!
//! A machine's own description is a patch of the empty machine; an effect is a patch of a machine. A patch
//! names points, shafts and joints;
//! [`Machine::with`](super::Machine::with) resolves the names. Types that mirror a section of a configuration file end in …File, because
//! error messages use these names.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::{
    BendingFile, DerivedPatch, DriveFile, EffectIds, JointPatch, LeverFile, LoadedPair, Machine,
    OperatingVariable, Parameter, PointPatch, Rescale, Segment, ShaftFile, Target,
};

impl Effect {
    /// Returns the effects to test on one kind of data.
    ///
    /// Variants of an effect share one id; they serve machines described with different names. A variant for
    /// other data is omitted where one for this data exists.
    pub fn for_data(effects: &[Effect], data: Data) -> impl Iterator<Item = &Effect> {
        let shows_in = move |e: &Effect| e.data.contains(&data);
        effects
            .iter()
            .filter(move |e| shows_in(e) || !effects.iter().any(|other| other.id == e.id && shows_in(other)))
    }

    /// Returns the variant of an effect that a machine contains: among the effects with this id, the one
    /// whose parameters the machine has.
    pub fn contained_variant<'e>(effects: &'e [Effect], id: &str, machine: &Machine) -> Option<&'e Effect> {
        let has = |e: &Effect| e.patch.parameters.iter().all(|p| machine.parameter(&p.id).is_some());
        effects.iter().find(|e| e.id == id && has(e))
    }

    /// Returns effects without those that describe another of them in more detail.
    pub fn unrefined(effects: &[Effect], ids: &EffectIds) -> EffectIds {
        let refines = |id: &&str| {
            effects.iter().any(|e| e.id == *id && e.refines.as_ref().is_some_and(|other| ids.contains(other)))
        };
        ids.iter().filter(|id| !refines(id)).fold(EffectIds::default(), |all, id| all.with(id))
    }

    /// Returns the locations of the effect: the points, joints and shafts that it changes, each with the
    /// parameter that changes it, if any.
    ///
    /// An effect that changes no existing part is located at the points of its new joints. Numbers without
    /// such a part are located at «drive», «losses» or «measurement».
    pub fn places(&self) -> Vec<(String, Option<String>)> {
        if let Some(at) = &self.at {
            return vec![(at.clone(), None)];
        }
        let Patch { points, joints, rescales, reattached, attached, bending, .. } = &self.patch;
        let is_new =
            |name: &str| points.iter().any(|p| p.name == name) || joints.iter().any(|j| j.name == name);
        let scaled = rescales
            .iter()
            .map(|(target, _, parameter)| (target.part().to_string(), Some(parameter.clone())));
        let bent = bending.iter().map(|bending| (bending.shaft.clone(), None));
        let moved = reattached
            .iter()
            .map(|r| &r.joint)
            .chain(attached.iter().map(|a| &a.joint))
            .map(|joint| (joint.clone(), None));
        let on = joints.iter().flat_map(|joint| joint.on.iter().map(|(point, _)| (point.clone(), None)));
        let changed: Vec<_> = scaled.chain(bent).chain(moved).filter(|(name, _)| !is_new(name)).collect();
        if changed.is_empty() { on.filter(|(name, _)| !is_new(name)).collect() } else { changed }
    }

    /// Returns the first of its locations.
    pub fn location(&self) -> Option<String> {
        self.places().into_iter().next().map(|(place, _)| place)
    }

    /// Returns the operating variable that must differ between data sets for the effect to show; `None` where
    /// it depends on none.
    pub fn operating_variable(&self) -> Option<OperatingVariable> {
        self.patch.rescales.iter().find_map(|(_, rescale, _)| match rescale {
            Rescale::WithForceLevel => Some(OperatingVariable::ForceLevel),
            Rescale::WithSpeed => Some(OperatingVariable::Speed),
            Rescale::WithAcceleration => Some(OperatingVariable::Acceleration),
            _ => None,
        })
    }
}

/// The additions and changes that a description, or an effect, makes to a machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patch {
    /// Points it adds.
    pub points: Vec<PointPatch>,
    /// Shafts it adds.
    pub shafts: Vec<ShaftFile>,
    /// Joints it adds.
    pub joints: Vec<JointPatch>,
    /// The drive, if it describes one.
    pub drive: Option<DriveFile>,
    /// Contacts that it describes, for use as stiffnesses.
    pub contacts: Vec<LoadedPair>,
    /// Screw segments that it describes, for use as stiffnesses.
    pub segments: Vec<Segment>,
    /// Parameters it adds. A parameter that the machine has already (by id) keeps the machine's definition.
    pub parameters: Vec<Parameter>,
    /// Numbers it modifies: which, how, by which parameter.
    pub rescales: Vec<(Target, Rescale, String)>,
    /// Joints moved from one point (or the ground) to another.
    pub reattached: Vec<ReattachFile>,
    /// Additional points for existing joints.
    pub attached: Vec<AttachFile>,
    /// Shafts that it lets bend.
    pub bending: Vec<BendingFile>,
    /// Lever arms of sensor and hammer.
    pub levers: Vec<LeverFile>,
    /// Derived quantities to report, by name.
    pub derived: BTreeMap<String, DerivedPatch>,
}

/// A joint moved from one point (or the ground) to another.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "")]
pub struct ReattachFile {
    pub(super) joint: String,
    pub(super) from: String,
    pub(super) to: String,
}

/// An additional point for an existing joint.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "")]
pub struct AttachFile {
    pub(super) joint: String,
    pub(super) to: String,
    pub(super) times: f64,
}

/// Kinds of data in which an effect can show.
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

/// An effect: a named patch with its documentation.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// Id, for example `rotor-hold`.
    pub id: String,
    /// Description, one sentence.
    pub description: String,
    /// Its appearance in measurements, if documented.
    pub signature: Option<String>,
    /// The measurement that distinguishes it from similar effects, if documented.
    pub discriminating_test: Option<String>,
    /// Effects (ids) from which force and one encoder cannot distinguish it.
    pub confusable_with: Vec<String>,
    /// Effects (ids) from which it cannot be distinguished in motion with negligible inertia force.
    pub confusable_with_slow: Vec<String>,
    /// Whether most machines show a little of it in motion, so that stronger evidence is required to name it.
    pub common: bool,
    /// The effect (id) that it describes in more detail: a verdict names that effect alone.
    pub refines: Option<String>,
    /// Names of the points, joints or shafts that it requires; «drive» stands for the drive.
    pub needs: Vec<String>,
    /// Location to report where it is not the first part that the effect changes.
    pub at: Option<String>,
    /// Data in which it can show.
    pub data: Vec<Data>,
    /// Its patch.
    pub patch: Patch,
}
